"""How a user pushes, coasts and brakes, and how a wheel slips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mobility_imu.arguments import check_limits
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_floats, as_number, check_positive
from mobility_imu.simulation.checks import LONGEST_S
from mobility_imu.simulation.profiles import cosine_ramp, cosine_ramp_integral
from mobility_imu.simulation.wheelchair.chair import Leg
from mobility_imu.wheelchair.geometry import Side, side_sign


@dataclass(frozen=True)
class Pushing:
    """How a user drives: velocity cycles of a push and an interval of coasting.

    Parameters
    ----------
    push_s : s, hands on the rim; acceleration rises and falls as a squared sine
    cycle_s : s, from one push onset to the next
    strongest_mps2 : m/s², mean acceleration of the strongest push
    coasting_mps2 : m/s², deceleration by rolling resistance (1.5 % of gravity on a court)
    braking_mps2 : m/s², mean deceleration of a brake
    """

    push_s: float = 0.35
    cycle_s: float = 1.0
    strongest_mps2: float = 2.5
    coasting_mps2: float = 0.15
    braking_mps2: float = 2.0

    def __post_init__(self) -> None:
        """Check every size."""
        check_positive(self)
        check_limits(self, {"push_s": (1e-3, LONGEST_S)})
        if self.push_s >= self.cycle_s:
            raise InputError(f"push_s = {self.push_s}: expected less than cycle_s = {self.cycle_s}")


@dataclass(frozen=True)
class SlipEpisode:
    """An interval in which one wheel does not roll.

    Parameters
    ----------
    side : "left" or "right"
    start_s, duration_s : s
    peak_mps : m/s, how much faster than rolling the wheel's rim runs at the most: positive when
        it spins on a forward push, negative when it skids on a brake
    rise_s : s, of the squared-sine edges; half the duration if that is shorter
    """

    side: Side
    start_s: float
    duration_s: float
    peak_mps: float
    rise_s: float = 0.15

    def __post_init__(self) -> None:
        """Check side, times and speed."""
        side_sign(self.side)
        check_positive(self, "duration_s", "rise_s")
        for name in ("start_s", "peak_mps"):
            as_number(getattr(self, name), f"SlipEpisode.{name}", negative=True)

    def profile(self, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Excess speed of the rim, m/s, and its change, m/s².

        Parameters
        ----------
        time_s : (n,) array, s

        Returns
        -------
        two (n,) arrays
        """
        time_s = as_floats(time_s, "time_s")
        rise = min(self.rise_s, self.duration_s / 2)
        since, left = time_s - self.start_s, self.start_s + self.duration_s - time_s
        u = np.clip(np.minimum(since, left) / rise, 0, 1)
        falling = np.where(since < left, 1.0, -1.0)
        edge = np.pi / 2 * np.sin(np.pi * u) / rise * falling
        return self.peak_mps * np.sin(np.pi / 2 * u) ** 2, self.peak_mps * edge


def pushed(
    legs: Sequence[Leg], pushing: Pushing, time_s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed, acceleration and push onsets of a drive in velocity cycles.

    Parameters
    ----------
    legs : of Leg
    pushing : Pushing
    time_s : (n,) array, s

    Returns
    -------
    (n,) array, m/s; (n,) array, m/s²; (k,) array, s

    Raises
    ------
    InputError
        If a leg before a rest, or before the other way, is too short to brake in.
    """
    cycles = _Cycles(pushing, time_s)
    start = 0.0
    for leg, following in zip(legs, [*legs[1:], None], strict=True):
        cycles.drive_leg(leg, following, start)
        start += leg.duration_s
    return cycles.velocity, cycles.acceleration, np.array(cycles.onsets)


class _Cycles:
    """Speed and acceleration that pushes, coasting and brakes add up to, from rest."""

    def __init__(self, pushing: Pushing, time_s: FloatArray) -> None:
        self.pushing, self.time_s = pushing, time_s
        self.velocity, self.acceleration = np.zeros(len(time_s)), np.zeros(len(time_s))
        self.onsets: list[float] = []
        self.speed = 0.0

    def drive_leg(self, leg: Leg, following: Leg | None, start: float) -> None:
        """Add one leg: brake to its speed if it is slower, push and coast, brake at its end."""
        pushing, target, end = self.pushing, leg.linear_velocity_mps, start + leg.duration_s
        now = start
        # Braking into a rest, or before going the other way, belongs to this leg.
        stops = following is None or following.linear_velocity_mps * target <= 0
        brake_s = max(2 * abs(target) / pushing.braking_mps2, 0.3) if stops and target else 0.0
        if target * np.sign(self.speed) < abs(self.speed) - 0.3 and self.speed != 0:
            slower = target - self.speed
            slowing_s = max(abs(slower) / pushing.braking_mps2, 0.3)
            self.bump(now, slowing_s, slower)
            now += slowing_s
        if brake_s > end - now + 1e-9:
            raise InputError(
                f"leg at {start:g} s: {end - now:.2f} s are too short to brake in from "
                f"{abs(target):g} m/s, expected {brake_s:.2f} s or more"
            )
        while target and now + pushing.push_s <= end - brake_s + 1e-9:
            until = min(now + pushing.cycle_s, end - brake_s)
            # Half of what the coasting will take on top of the target.
            wanted = abs(target) + pushing.coasting_mps2 * (until - now - pushing.push_s) / 2
            gain = min(wanted - abs(self.speed), pushing.strongest_mps2 * pushing.push_s)
            if gain > 0:
                self.onsets.append(now)
                self.bump(now, pushing.push_s, np.sign(target) * gain)
            self.coast(now + pushing.push_s, until - now - pushing.push_s)
            now = until
        if target:
            self.coast(now, end - brake_s - now)
            if brake_s and self.speed:
                self.bump(end - brake_s, brake_s, -self.speed)
                self.speed = 0.0

    def bump(self, begin: float, duration: float, gain: float) -> None:
        """Add a push or a brake: acceleration as a squared sine."""
        inside, after = self.during(begin, duration)
        u = (self.time_s[inside] - begin) / duration
        self.velocity[inside] += gain * (u - np.sin(2 * np.pi * u) / (2 * np.pi))
        self.velocity[after] += gain
        self.acceleration[inside] += gain / duration * (1 - np.cos(2 * np.pi * u))
        self.speed += gain

    def coast(self, begin: float, duration: float) -> None:
        """Add rolling resistance; it cannot turn the motion round."""
        if duration <= 0 or self.speed == 0:
            return
        loss = -np.sign(self.speed) * min(self.pushing.coasting_mps2 * duration, abs(self.speed))
        # Ramps in and out, so that the acceleration stays continuous.
        edge = min(0.1, duration / 3)
        inside, after = self.during(begin, duration)
        time_s = self.time_s[inside]
        rise = (time_s - begin) / edge
        fall = (time_s - begin - duration + edge) / edge
        rate = loss / (duration - edge)
        self.acceleration[inside] += rate * (cosine_ramp(rise) - cosine_ramp(fall))
        ramps = cosine_ramp_integral(rise) - cosine_ramp_integral(fall)
        self.velocity[inside] += rate * edge * ramps
        self.velocity[after] += loss
        self.speed += loss

    def during(self, begin: float, duration: float) -> tuple[slice, slice]:
        """Samples of a span, and those after it."""
        first, last = np.searchsorted(self.time_s, (begin, begin + duration))
        return slice(first, last), slice(last, None)
