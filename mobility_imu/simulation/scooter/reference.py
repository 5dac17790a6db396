"""The paper's truth: wire sensors at the controls, Hall pulses of a wheel, two clocks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu._compiled import choose, compiled
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_series
from mobility_imu.simulation.scooter.driver import ScooterMotion
from mobility_imu.simulation.scooter.parts import Reference

_PLAIN_S_PER_SAMPLE = 0.5e-6


def read_reference(
    fast: ScooterMotion, reference: Reference, sampling_rate_hz: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Wire sensors on the second logger's clock, and the Hall pulses on both clocks.

    Parameters
    ----------
    fast : ScooterMotion
    reference : Reference
    sampling_rate_hz : Hz, of the second logger
    rng : the source of the draws

    Returns
    -------
    (m, 2) array, rad, steering and throttle; (m,) array, s, their times on the logger's clock;
    (k,) arrays, s, the pulses on the IMUs' clock and on the logger's
    """
    offset = reference.clock_offset_s * rng.standard_normal()
    time_s = np.arange(fast.time_s[0], fast.time_s[-1], 1 / sampling_rate_hz)
    wires = []
    for angle, play in (
        (fast.steering_rad, reference.steering_play_rad),
        (fast.throttle_rad, reference.throttle_play_rad),
    ):
        wire = with_play(np.interp(time_s, fast.time_s, angle), play) * reference.disk_radius_m
        if reference.resolution_m > 0:
            wire = np.round(wire / reference.resolution_m) * reference.resolution_m
        wires.append(wire / reference.disk_radius_m)
    between = 2 * np.pi * reference.wheel_radius_m / reference.wheel_magnets
    first = between * (1 - rng.random())  # the wheel stands somewhere
    marks = np.arange(first, fast.distance_m[-1], between)
    pulses = np.interp(marks, fast.distance_m, fast.time_s)
    # The logger sees a pulse at its next sample; the analyser of the bus stamps milliseconds.
    seen = np.ceil((pulses + offset) * sampling_rate_hz) / sampling_rate_hz
    return np.column_stack(wires), time_s + offset, np.round(pulses, 3), seen


def with_play(angle_rad: ArrayLike, width_rad: float) -> FloatArray:
    """Angle of a follower with backlash: it moves only when it is pushed.

    Parameters
    ----------
    angle_rad : (n,) array, rad, of what pushes it; it begins in the middle of the play
    width_rad : rad, of the play

    Returns
    -------
    (n,) array, rad

    Examples
    --------
    >>> with_play([0.0, 1.0, 0.5, -1.0], 1.0).tolist()
    [0.0, 0.5, 0.5, -0.5]
    """
    angle = np.ascontiguousarray(as_series(angle_rad, "angle_rad"))
    if not len(angle):
        raise InputError("angle_rad: 0 samples, expected at least 1")
    width = as_number(width_rad, "width_rad", zero=True)
    given, plain_s = (angle, width), len(angle) * _PLAIN_S_PER_SAMPLE
    # Comparing and adding are exact: both ways give the same bytes.
    if choose({_followed: given}, plain_s=plain_s, what="backlash of the wires") == "compiled":
        return np.asarray(_followed(*given))
    return _follow(*given)


def _follow(angle: FloatArray, width: float) -> FloatArray:
    """Follow sample by sample."""
    out = np.empty_like(angle)
    follower = angle[0]
    for k in range(len(angle)):
        follower = min(max(follower, angle[k] - width / 2), angle[k] + width / 2)
        out[k] = follower
    return out


_followed = compiled()(_follow)
