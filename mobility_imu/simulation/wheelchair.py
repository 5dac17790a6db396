"""A manual chair with an IMU on each wheel and the frame, driven along legs.

Rigid-body kinematics from the chair's speed and yaw rate: nothing of the estimators is used.
``simulate_drive`` rolls smoothly on a flat floor without slip; ``simulate_court`` adds pushes,
coasting and braking, wheels that slip or skid, toe, slopes and any sensor model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import integrate
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.rotations import elementary_rotation
from mobility_imu.simulation.sensor import SensorModel, measure
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry, side_sign

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Leg:
    """A stretch of a drive with one speed and one yaw rate.

    Parameters
    ----------
    task : task code 1-6 that is driven here (see ``mobility_imu.wheelchair.Task``)
    duration_s : s
    linear_velocity_mps : m/s, forward positive
    yaw_rate_degps : deg/s, left positive
    slope_deg : deg, the floor rises this much in the direction the chair faces; only
        ``simulate_court`` drives on slopes
    """

    task: int
    duration_s: float
    linear_velocity_mps: float = 0.0
    yaw_rate_degps: float = 0.0
    slope_deg: float = 0.0


# All six tasks, turns to both sides; radii well inside the limits of Table 1.
COURT = (
    Leg(1, 3.0),
    Leg(2, 5.0, 1.3),
    Leg(6, 4.0, 1.2, 60.0),
    Leg(2, 3.0, 1.2),
    Leg(5, 3.0, 0.5, 90.0),
    Leg(1, 2.0),
    Leg(4, 3.0, 0.0, -120.0),
    Leg(1, 2.0),
    Leg(3, 4.0, -0.9),
    Leg(1, 2.0),
    Leg(4, 2.5, 0.0, 100.0),
    Leg(2, 4.0, 1.6),
    Leg(6, 4.0, 1.3, -55.0),
    Leg(5, 3.0, 0.6, -100.0),
    Leg(2, 5.0, 1.8),
    Leg(1, 3.0),
)
SIDES: tuple[Side, Side] = ("left", "right")
# Simulated motion per sample of a sensor model: 2.5 ms at 100 Hz, a hundredth of a push.
FINER = 4
STATIC_TRIAL = (Leg(1, 3.0),)
STRAIGHT_TRIAL = (Leg(1, 1.0), Leg(2, 5.0, 1.2), Leg(1, 1.0))


@dataclass(frozen=True)
class SensorNoise:
    """White noise and constant bias of the simulated IMUs, the same size on every axis.

    Parameters
    ----------
    acc_sd_mps2, gyr_sd_radps : standard deviation of each sample
    acc_bias_sd_mps2, gyr_bias_sd_radps : standard deviation of the bias drawn per sensor and axis
    """

    acc_sd_mps2: float
    gyr_sd_radps: float
    acc_bias_sd_mps2: float
    gyr_bias_sd_radps: float


IDEAL = SensorNoise(0.0, 0.0, 0.0, 0.0)
# The size of what the three sensors of WheelMove-ID's sample show in its static trial.
LIKE_SAMPLE = SensorNoise(0.02, 0.003, 0.02, 0.003)


@dataclass(frozen=True)
class Mounting:
    """How one IMU sits on its body.

    Parameters
    ----------
    rotation_body_to_imu : (3, 3) array
    position_m : (3,) array, m, in the body's frame (wheel: from its centre)
    """

    rotation_body_to_imu: FloatArray
    position_m: FloatArray


@dataclass(frozen=True)
class SimulatedDrive:
    """A recording and the truth it was made from.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel
    linear_velocity_mps : (n,) array, m/s, midway between the wheels' contacts
    yaw_rate_radps : (n,) array, rad/s
    task : (n,) array of task codes. A rest ends when motion begins and begins when it ends;
        between two motions the change is in the middle
    """

    recording: Recording
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    task: np.ndarray

    def truth(self) -> pd.DataFrame:
        """Give the truth as the velocity and task tables name it."""
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.recording.time_s,
                "linear_velocity_mps": self.linear_velocity_mps,
                "yaw_rate_degps": np.rad2deg(self.yaw_rate_radps),
                "task_code": self.task,
            }
        )


def random_mounting(seed: int) -> dict[str, Mounting]:
    """Give the three IMUs any orientation, and places as on a real chair.

    Parameters
    ----------
    seed : the same seed gives the same mounting
    """
    rng = np.random.default_rng(seed)
    places = {
        "frame": (0.10, 0.05, 0.40),
        "left_wheel": (0.04, 0.02, 0.03),
        "right_wheel": (-0.03, 0.05, 0.03),
    }
    return {
        name: Mounting(Rotation.random(rng=rng).as_matrix(), np.array(place))
        for name, place in places.items()
    }


def simulate_drive(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: dict[str, Mounting],
    *,
    seed: int,
    noise: SensorNoise = LIKE_SAMPLE,
    sampling_rate_hz: float = 100.0,
    transition_s: float = 0.8,
    push_share: float = 0.08,
    push_rate_hz: float = 1.0,
) -> SimulatedDrive:
    """Drive along legs and record it.

    Parameters
    ----------
    legs : the drive; between two legs speed and yaw rate change with minimum jerk
    geometry : WheelchairGeometry
    mounting : of ``frame``, ``left_wheel``, ``right_wheel``
    seed : for the noise; the same seed gives the same bytes
    noise : SensorNoise
    sampling_rate_hz : Hz
    transition_s : s, length of a change
    push_share : speed swings by this share of itself with each push
    push_rate_hz : pushes per second

    Returns
    -------
    SimulatedDrive

    Raises
    ------
    InputError
        If a leg is shorter than a change.
    """
    _check_legs(legs, transition_s)
    for leg in legs:
        if leg.slope_deg:
            raise InputError(f"slope_deg = {leg.slope_deg:g}: this drive is on a flat floor")
    count = round(sum(leg.duration_s for leg in legs) * sampling_rate_hz)
    time_s = np.arange(count) / sampling_rate_hz
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    speed, speed_change, _ = _profile(
        [leg.linear_velocity_mps for leg in legs], ends, time_s, transition_s
    )
    yaw, yaw_change, _ = _profile(
        [np.deg2rad(leg.yaw_rate_degps) for leg in legs], ends, time_s, transition_s
    )
    turn = 2 * np.pi * push_rate_hz
    swing = 1 + push_share * np.sin(turn * time_s)
    velocity = speed * swing
    acceleration = speed_change * swing + speed * push_share * turn * np.cos(turn * time_s)
    motion = _flat(velocity, acceleration, yaw, yaw_change)
    rng = np.random.default_rng(seed)
    sensors = {"frame": _frame_imu(motion, mounting["frame"])}
    for side in SIDES:
        sensors[f"{side}_wheel"] = _wheel_imu(
            time_s, motion, geometry, side, mounting[f"{side}_wheel"]
        )
    sensors = {name: _add_noise(imu, noise, rng) for name, imu in sensors.items()}
    recording = Recording(time_s, sensors, source="simulated wheelchair")
    return SimulatedDrive(recording, velocity, yaw, _tasks(legs, ends, time_s, transition_s))


def _check_legs(legs: Sequence[Leg], transition_s: float) -> None:
    for leg in legs:
        if leg.duration_s < transition_s:
            raise InputError(
                f"leg of {leg.duration_s} s is shorter than a change of {transition_s} s"
            )


def _profile(
    values: Sequence[float], ends: FloatArray, time_s: FloatArray, transition_s: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Levels with minimum-jerk changes centred on the ends, and its first two derivatives."""
    level = np.full(len(time_s), float(values[0]))
    slope, bend = np.zeros(len(time_s)), np.zeros(len(time_s))
    for end, step in zip(ends, np.diff(values), strict=True):
        u = np.clip((time_s - end) / transition_s + 0.5, 0, 1)
        level += step * u**3 * (10 - 15 * u + 6 * u**2)
        slope += step * 30 * u**2 * (1 - u) ** 2 / transition_s
        bend += step * 60 * u * (1 - u) * (1 - 2 * u) / transition_s**2
    return level, slope, bend


def _tasks(
    legs: Sequence[Leg], ends: FloatArray, time_s: FloatArray, transition_s: float
) -> np.ndarray:
    task = np.full(len(time_s), legs[0].task, np.int8)
    for end, before, after in zip(ends, legs[:-1], legs[1:], strict=True):
        at = end
        if before.task == 1 and after.task != 1:
            at = end - transition_s / 2
        elif after.task == 1 and before.task != 1:
            at = end + transition_s / 2
        task[time_s >= at] = after.task
    return task


class _Motion(NamedTuple):
    """The chair's motion in its own frame; the origin is midway between the contacts.

    Parameters
    ----------
    velocity, acceleration, yaw, yaw_change : (n,) arrays, along x and about z
    rate, rate_change : (n, 3) arrays, rad/s and rad/s²
    force : (n, 3) array, m/s², specific force at the origin
    """

    velocity: FloatArray
    acceleration: FloatArray
    yaw: FloatArray
    yaw_change: FloatArray
    rate: FloatArray
    rate_change: FloatArray
    force: FloatArray


def _flat(
    velocity: FloatArray, acceleration: FloatArray, yaw: FloatArray, yaw_change: FloatArray
) -> _Motion:
    level = np.zeros_like(velocity)
    return _sloping(velocity, acceleration, yaw, yaw_change, (level, level, level))


def _sloping(
    velocity: FloatArray,
    acceleration: FloatArray,
    yaw: FloatArray,
    yaw_change: FloatArray,
    pitch: tuple[FloatArray, FloatArray, FloatArray],
) -> _Motion:
    """Motion with the nose raised by a pitch (with its two derivatives), the axle level."""
    angle, angle_change, angle_bend = pitch
    # Heading about the vertical, then pitch: the chair's x shares in the heading's rate.
    roll = yaw * np.tan(angle)
    roll_change = yaw_change * np.tan(angle) + yaw * angle_change / np.cos(angle) ** 2
    gravity = STANDARD_GRAVITY_MPS2
    return _Motion(
        velocity,
        acceleration,
        yaw,
        yaw_change,
        rate=np.column_stack([roll, -angle_change, yaw]),
        rate_change=np.column_stack([roll_change, -angle_bend, yaw_change]),
        force=np.column_stack(
            [
                acceleration + gravity * np.sin(angle),
                velocity * yaw,
                velocity * angle_change + gravity * np.cos(angle),
            ]
        ),
    )


def _frame_imu(motion: _Motion, mounting: Mounting) -> Imu:
    place = np.broadcast_to(mounting.position_m, motion.rate.shape)
    still = np.zeros_like(place)
    turn = mounting.rotation_body_to_imu.T
    return Imu(_specific_force(motion, place, still, still) @ turn, motion.rate @ turn)


def _wheel_imu(
    time_s: FloatArray,
    motion: _Motion,
    geometry: WheelchairGeometry,
    side: Side,
    mounting: Mounting,
    *,
    toe_rad: float = 0.0,
    slip_mps: FloatArray | float = 0.0,
    slip_change_mps2: FloatArray | float = 0.0,
) -> Imu:
    sign = side_sign(side)
    contact = np.array([0.0, sign * geometry.track_m / 2, 0.0])
    radius = getattr(geometry.wheel_radius_m, side)
    # The contact travels as the chair does at its lateral place; a wheel that toes in rolls as
    # far as the travel goes along its plane, and scrubs sideways. Slip comes on top.
    along = np.cos(toe_rad)
    travel = motion.velocity - motion.yaw * contact[1]
    travel_change = motion.acceleration - motion.yaw_change * contact[1]
    spin = (travel * along + slip_mps) / radius
    spin_change = (travel_change * along + slip_change_mps2) / radius
    angle = integrate.cumulative_trapezoid(spin, time_s, initial=0)
    toed = elementary_rotation("z", -sign * toe_rad)
    axle = toed @ geometry.axle_direction(side)
    ahead = toed @ np.array([1.0, 0.0, 0.0])
    centre = contact + toed @ (geometry.wheel_centre(side) - contact)
    base = np.column_stack([ahead, np.cross(axle, ahead), axle])  # wheel to chair at angle 0
    turned = base @ elementary_rotation("z", angle)
    arm = turned @ mounting.position_m
    swing = spin[:, None] * np.cross(axle, arm)
    swing_change = spin_change[:, None] * np.cross(axle, arm) + spin[:, None] * np.cross(
        axle, swing
    )
    acc = _specific_force(motion, centre + arm, swing, swing_change)
    rate = spin[:, None] * axle + motion.rate
    to_imu = mounting.rotation_body_to_imu @ np.swapaxes(turned, 1, 2)
    return Imu(np.einsum("nij,nj->ni", to_imu, acc), np.einsum("nij,nj->ni", to_imu, rate))


def _specific_force(
    motion: _Motion, place: FloatArray, drift: FloatArray, drift_change: FloatArray
) -> FloatArray:
    """Specific force at a place that moves in the chair's frame; chair components, (n, 3)."""
    around = np.cross(motion.rate, place)
    carried = np.cross(motion.rate_change, place) + np.cross(motion.rate, around)
    return carried + 2 * np.cross(motion.rate, drift) + drift_change + motion.force


def _add_noise(imu: Imu, noise: SensorNoise, rng: np.random.Generator) -> Imu:
    assert imu.gyr_radps is not None
    shape = imu.acc_mps2.shape
    acc_bias = noise.acc_bias_sd_mps2 * rng.standard_normal(3)
    gyr_bias = noise.gyr_bias_sd_radps * rng.standard_normal(3)
    return Imu(
        imu.acc_mps2 + acc_bias + noise.acc_sd_mps2 * rng.standard_normal(shape),
        imu.gyr_radps + gyr_bias + noise.gyr_sd_radps * rng.standard_normal(shape),
    )


@dataclass(frozen=True)
class Pushing:
    """How a user drives: velocity cycles of a push and a stretch of coasting.

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
        """Refuse what cannot be."""
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value}: expected a positive number")
        if self.push_s >= self.cycle_s:
            raise InputError(f"push_s = {self.push_s}: expected less than cycle_s = {self.cycle_s}")


@dataclass(frozen=True)
class SlipEpisode:
    """A stretch in which one wheel does not roll.

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
        """Refuse what cannot be."""
        side_sign(self.side)
        for name in ("duration_s", "rise_s"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} = {getattr(self, name)}: expected a positive number")

    def profile(self, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the rim's excess speed, m/s, and its change, m/s²."""
        rise = min(self.rise_s, self.duration_s / 2)
        since, left = time_s - self.start_s, self.start_s + self.duration_s - time_s
        u = np.clip(np.minimum(since, left) / rise, 0, 1)
        falling = np.where(since < left, 1.0, -1.0)
        edge = np.pi / 2 * np.sin(np.pi * u) / rise * falling
        return self.peak_mps * np.sin(np.pi / 2 * u) ** 2, self.peak_mps * edge


@dataclass(frozen=True)
class SimulatedCourt(SimulatedDrive):
    """A court with its truth: that of a drive, and what only a court has.

    Parameters
    ----------
    acceleration_mps2 : (n,) array, m/s², change of the speed
    slip_left_mps, slip_right_mps : (n,) arrays, m/s, the rim's speed beyond rolling; 0 where the
        wheel rolls
    pitch_rad : (n,) array, rad, nose up positive
    push_onset_s : (k,) array, s, when pushes begin
    """

    acceleration_mps2: FloatArray
    slip_left_mps: FloatArray
    slip_right_mps: FloatArray
    pitch_rad: FloatArray
    push_onset_s: FloatArray

    @property
    def slipping(self) -> np.ndarray:
        """Where at least one wheel slips, (n,) of bool."""
        return (self.slip_left_mps != 0) | (self.slip_right_mps != 0)

    def truth(self) -> pd.DataFrame:
        """Give the truth as the velocity and task tables name it, and the slip of each wheel."""
        return (
            super()
            .truth()
            .assign(slip_left_mps=self.slip_left_mps, slip_right_mps=self.slip_right_mps)
        )


def simulate_court(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: dict[str, Mounting],
    *,
    seed: int,
    unit_seed: int = 0,
    slips: Sequence[SlipEpisode] = (),
    toe_rad: float = 0.0,
    pushing: Pushing | None = None,
    model: SensorModel | None = None,
    sampling_rate_hz: float = 100.0,
    transition_s: float = 0.8,
) -> SimulatedCourt:
    """Drive along legs with pushes, coasting and braking, and record it.

    A leg's task begins with the leg: a push begins there, a turn begins there if the chair went
    straight before, and a rest begins where the brake has ended. The true speed and yaw rate do
    not know of the slips: those are added to the wheels' spin alone.

    Parameters
    ----------
    legs : the court
    geometry : WheelchairGeometry, the true one
    mounting : of ``frame``, ``left_wheel``, ``right_wheel``
    seed : of this power-up: biases and noise; the same seed gives the same bytes
    unit_seed : of the three sensors as made: scale, misalignment
    slips : episodes of slip; those of one wheel add up
    toe_rad : rad, both wheels' fronts point inward by this
    pushing : Pushing; its default values if None
    model : SensorModel; None for ideal sensors
    sampling_rate_hz : Hz
    transition_s : s, length of a change of yaw rate or slope

    Returns
    -------
    SimulatedCourt

    Raises
    ------
    InputError
        If a leg is shorter than a change or too short to brake in, or the model loses samples.
    """
    _check_legs(legs, transition_s)
    if model is not None and model.dropped_share:
        raise InputError(
            f"dropped_share = {model.dropped_share}: the three sensors need one clock, expected 0"
        )
    count = round(sum(leg.duration_s for leg in legs) * sampling_rate_hz)
    # A sensor model samples by itself, out of something faster.
    finer = 1 if model is None else FINER
    time_s = np.arange((count - 1) * finer + 1) / (sampling_rate_hz * finer)
    velocity, acceleration, onsets = _pushed(legs, pushing or Pushing(), time_s)
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    rates = [np.deg2rad(leg.yaw_rate_degps) for leg in legs]
    inside = _changes_inside_turns(rates, ends, transition_s)
    yaw, yaw_change, _ = _profile(rates, inside, time_s, transition_s)
    pitch = _profile([np.deg2rad(leg.slope_deg) for leg in legs], ends, time_s, transition_s)
    motion = _sloping(velocity, acceleration, yaw, yaw_change, pitch)

    imus = {"frame": _frame_imu(motion, mounting["frame"])}
    slipped = {}
    for side in SIDES:
        profiles = [slip.profile(time_s) for slip in slips if slip.side == side]
        total, change = np.sum(profiles, axis=0) if profiles else np.zeros((2, len(time_s)))
        slipped[side] = total[::finer]
        imus[f"{side}_wheel"] = _wheel_imu(
            time_s,
            motion,
            geometry,
            side,
            mounting[f"{side}_wheel"],
            toe_rad=toe_rad,
            slip_mps=total,
            slip_change_mps2=change,
        )
    if model is not None:
        for k, (name, imu) in enumerate(imus.items()):
            assert imu.gyr_radps is not None
            imus[name] = measure(
                time_s,
                imu.acc_mps2,
                imu.gyr_radps,
                model,
                sampling_rate_hz=sampling_rate_hz,
                seed=3 * seed + k,
                unit_seed=3 * unit_seed + k,
            ).imu
    stated = time_s[::finer]
    task = np.array([leg.task for leg in legs], np.int8)
    return SimulatedCourt(
        recording=Recording(stated, imus, source="simulated wheelchair court"),
        linear_velocity_mps=velocity[::finer],
        yaw_rate_radps=yaw[::finer],
        task=task[np.searchsorted(ends, stated, side="right")],
        acceleration_mps2=acceleration[::finer],
        slip_left_mps=slipped["left"],
        slip_right_mps=slipped["right"],
        pitch_rad=pitch[0][::finer],
        push_onset_s=onsets,
    )


def _changes_inside_turns(
    rates: Sequence[float], ends: FloatArray, transition_s: float
) -> FloatArray:
    """Middles of the changes of yaw rate: a turn begins and ends with its leg."""
    before, after = np.asarray(rates[:-1]), np.asarray(rates[1:])
    shift = np.where(before == 0, 0.5, np.where(after == 0, -0.5, 0.0))
    return ends + shift * transition_s


def _pushed(
    legs: Sequence[Leg], pushing: Pushing, time_s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed, acceleration and push onsets of a drive in velocity cycles."""
    velocity, acceleration = np.zeros(len(time_s)), np.zeros(len(time_s))
    onsets: list[float] = []
    speed, start = 0.0, 0.0

    def bump(begin: float, duration: float, gain: float) -> None:
        nonlocal speed
        u = np.clip((time_s - begin) / duration, 0, 1)
        velocity[:] += gain * (u - np.sin(2 * np.pi * u) / (2 * np.pi))
        acceleration[:] += gain / duration * (1 - np.cos(2 * np.pi * u))
        speed += gain

    def coast(begin: float, duration: float) -> None:
        """Rolling resistance; it cannot turn the motion round."""
        nonlocal speed
        if duration <= 0 or speed == 0:
            return
        loss = -np.sign(speed) * min(pushing.coasting_mps2 * duration, abs(speed))
        # Ramps in and out, so that the acceleration stays continuous.
        edge = min(0.1, duration / 3)
        rise, fall = (time_s - begin) / edge, (time_s - begin - duration + edge) / edge
        rate = loss / (duration - edge)
        acceleration[:] += rate * (_ramp(rise) - _ramp(fall))
        velocity[:] += rate * edge * (_ramp_sum(rise) - _ramp_sum(fall))
        speed += loss

    for leg, following in zip(legs, [*legs[1:], None], strict=True):
        target, end = leg.linear_velocity_mps, start + leg.duration_s
        now = start
        if target == 0 and speed != 0:
            raise InputError(
                f"leg at {start:g} s: the chair still rolls at {speed:.2f} m/s, expected a rest; "
                "the leg before is too short to brake"
            )
        # Braking into a rest, or before going the other way, belongs to this leg.
        stops = following is None or following.linear_velocity_mps * target <= 0
        brake_s = max(2 * abs(target) / pushing.braking_mps2, 0.3) if stops and target else 0.0
        if target * np.sign(speed) < abs(speed) - 0.3 and speed != 0:
            slower = target - speed
            bump(now, max(abs(slower) / pushing.braking_mps2, 0.3), slower)
            now += max(abs(slower) / pushing.braking_mps2, 0.3)
        while target and now + pushing.push_s <= end - brake_s + 1e-9:
            until = min(now + pushing.cycle_s, end - brake_s)
            # Half of what the coasting will take on top of the target.
            wanted = abs(target) + pushing.coasting_mps2 * (until - now - pushing.push_s) / 2
            gain = min(wanted - abs(speed), pushing.strongest_mps2 * pushing.push_s)
            if gain > 0:
                onsets.append(now)
                bump(now, pushing.push_s, np.sign(target) * gain)
            coast(now + pushing.push_s, until - now - pushing.push_s)
            now = until
        if target:
            coast(now, end - brake_s - now)
            if brake_s and speed:
                bump(end - brake_s, brake_s, -speed)
                speed = 0.0
        start = end
    return velocity, acceleration, np.array(onsets)


def _ramp(u: FloatArray) -> FloatArray:
    """Rise from 0 to 1 between 0 and 1."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(u, 0, 1))


def _ramp_sum(u: FloatArray) -> FloatArray:
    """Integral of the ramp."""
    inside = np.clip(u, 0, 1)
    return 0.5 * (inside - np.sin(np.pi * inside) / np.pi) + np.maximum(u - 1, 0)


@dataclass(frozen=True)
class Court:
    """All that a court is made from; every drive of it has the same chair and sensors.

    Parameters
    ----------
    legs, geometry, mounting, slips, toe_rad, pushing : as in :func:`simulate_court`
    seed : of sensors and noise
    """

    legs: tuple[Leg, ...]
    geometry: WheelchairGeometry
    mounting: dict[str, Mounting]
    slips: tuple[SlipEpisode, ...]
    toe_rad: float
    pushing: Pushing
    seed: int

    def drive(
        self, model: SensorModel | None = None, *, sampling_rate_hz: float = 100.0
    ) -> SimulatedCourt:
        """Drive the court."""
        return self._record(self.legs, self.slips, 0, model, sampling_rate_hz)

    def calibration_trials(
        self, model: SensorModel | None = None, *, sampling_rate_hz: float = 100.0
    ) -> tuple[SimulatedCourt, SimulatedCourt]:
        """Record the static and the straight-line trial with the same chair and sensors."""
        return (
            self._record(STATIC_TRIAL, (), 1, model, sampling_rate_hz),
            self._record(STRAIGHT_TRIAL, (), 2, model, sampling_rate_hz),
        )

    def _record(
        self,
        legs: Sequence[Leg],
        slips: Sequence[SlipEpisode],
        trial: int,
        model: SensorModel | None,
        sampling_rate_hz: float,
    ) -> SimulatedCourt:
        return simulate_court(
            legs,
            self.geometry,
            self.mounting,
            seed=3 * self.seed + trial,
            unit_seed=self.seed,
            slips=slips,
            toe_rad=self.toe_rad,
            pushing=self.pushing,
            model=model,
            sampling_rate_hz=sampling_rate_hz,
        )


def random_court(
    seed: int, *, slips: int = 8, both_wheels_share: float = 0.15, largest_toe_rad: float = 0.017
) -> Court:
    """Draw a court: chair, mounting, order and size of the tasks, slips.

    Camber 0 to 24°, radii that differ by up to 1 %, all six tasks, turns to both sides. A slip
    lasts 0.2 to 1 s. Half of them spin, by 0.4 to 1.5 m/s; half skid, by 40 to 100 % of the
    leg's speed.

    Parameters
    ----------
    seed : the same seed gives the same court
    slips : number of episodes, at most
    both_wheels_share : of the episodes, both wheels slip together, by amounts 20 % apart or less
    largest_toe_rad : rad, the toe is drawn between this inward and this outward (1°)

    Returns
    -------
    Court
    """
    rng = np.random.default_rng([seed, 17])
    radius = rng.uniform(0.28, 0.33)
    geometry = WheelchairGeometry(
        camber_rad=float(np.deg2rad(rng.uniform(0, 24))),
        wheel_radius_left_m=float(radius),
        wheel_radius_right_m=float(radius * rng.uniform(0.99, 1.01)),
        track_m=float(rng.uniform(0.70, 0.95)),
    )
    rest = Leg(1, 1.5)

    def turn(task: int, side: int) -> tuple[Leg, ...]:
        rate = rng.uniform(55, 80) if task == 6 else rng.uniform(90, 140)
        if task == 4:
            return rest, Leg(4, rng.uniform(2, 3), 0.0, side * rate), rest
        around = rng.uniform(0.8, 1.4) if task == 6 else rng.uniform(0.28, 0.42)
        return (Leg(task, rng.uniform(3, 4), np.deg2rad(rate) * around, side * rate),)

    parts = [turn(task, side) for task in (4, 5, 6) for side in (1, -1)]
    parts += [(Leg(2, rng.uniform(3, 6), rng.uniform(0.9, 2.5)),) for _ in range(4)]
    parts += [(rest, Leg(3, rng.uniform(3, 4), -rng.uniform(0.6, 1.2)), rest) for _ in range(2)]
    order = rng.permutation(len(parts))
    legs = (Leg(1, 2.0), *(leg for k in order for leg in parts[k]), Leg(1, 2.0))

    starts = np.cumsum([0, *(leg.duration_s for leg in legs[:-1])])
    rolling = [k for k, leg in enumerate(legs) if leg.linear_velocity_mps]
    episodes: list[SlipEpisode] = []
    for k in rng.choice(rolling, min(slips, len(rolling)), replace=False):
        leg, duration = legs[k], rng.uniform(0.2, 1.0)
        begin = starts[k] + rng.uniform(0.3, leg.duration_s - duration - 0.3)
        speed = leg.linear_velocity_mps
        spin = np.sign(speed) * rng.uniform(0.4, 1.5)
        skid = -speed * rng.uniform(0.4, 1.0)
        peak = float(spin if rng.random() < 0.5 else skid)
        rise = float(rng.uniform(0.05, 0.25))
        first: Side = "left" if rng.random() < 0.5 else "right"
        episodes.append(SlipEpisode(first, float(begin), float(duration), peak, rise))
        if rng.random() < both_wheels_share:
            other: Side = "right" if first == "left" else "left"
            alike = peak * float(rng.uniform(0.8, 1.2))
            episodes.append(SlipEpisode(other, float(begin), float(duration), alike, rise))
    return Court(
        legs=legs,
        geometry=geometry,
        mounting=random_mounting(seed),
        slips=tuple(episodes),
        toe_rad=float(rng.uniform(-largest_toe_rad, largest_toe_rad)),
        pushing=Pushing(
            push_s=float(rng.uniform(0.3, 0.45)),
            cycle_s=float(rng.uniform(0.8, 1.3)),
            coasting_mps2=float(rng.uniform(0.1, 0.25)),
        ),
        seed=seed,
    )
