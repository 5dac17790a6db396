"""A floor that is not level: the moves show it, and the path holds each rest at one height."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobility_imu.faults import Cost, Fault
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.walker.reach import FRAME, placed, samples_unknown
from mobility_imu.walker.rest_checks import Readings, moves_between_rests
from mobility_imu.walker.trajectory import Trajectory

__all__ = ["floor_faults", "slope_of_floor"]

HARMLESS = frozenset({"start", "mount", "coarse", "gap", "not closed"})
"""Faults beside which the moves still show the floor; any other may be what moves their heights."""
FOLLOWS_M_SQRTHZ = 1.0
"""Noise of the zero-height update from which on z follows the floor: it then is 0.04 m off after
eight stairs of 0.17 m, with a stated 0.036 m, and with 0.1 it is 0.9 m off."""
KERB_M = 0.1
"""Height of a single move that is told. Moves of 80 simulated walks reach 0.034 m, those of 15 of
16 real walks 0.073 m; in the other, which is told as rolled, one reaches 0.29 m."""
RISE_M, SLOPE_DEG, FEWEST_MOVES = 0.4, 2.5, 5
"""Height that a floor gains along the way, and its slope, from which on both are told; and the
fewest moves that show it. The heights of 80 simulated walks add up to 0.21 m, of which each move of
a sensor of the level "real" has 7 mm: on a long way it is the slope that tells."""
OFFSET_PER_AXES = 2.0
"""Offset of the accelerometer, g, per rad that its axes are off. Data sheets of cheap sensors state
20 mg beside 1 %; a calibrated one has 3 mg beside 0.1 deg."""
SLOPE_SDS = 2.6
"""Standard deviations from which on a rise is more than the sensor's errors: of normal ones, 1 in
100 is further off."""
CHANGES_DEG = 1.0
"""Slope that the frame leans with, against its first rest, from which on the floor is not one
plane. Of 100 simulated walks, level "real", on a level floor it is at most 0.16 deg."""


def floor_faults(
    recording: Recording, found: Trajectory, known: Iterable[Fault] = ()
) -> Iterator[Fault]:
    """Moves that end higher or lower than they began, which the zero-height update denies.

    A move of which both ends are at rest shows its height by the accelerometer, to some
    centimetres. A path whose ``height_noise_m_sqrthz`` is large follows it, which is no fault.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    found : Trajectory of its last samples
    known : Fault, of the recording

    Yields
    ------
    Fault
    """
    known = tuple(known)
    settings = found.settings  # those of a foot are without zero-rate updates
    follows = settings.height_noise_m_sqrthz >= FOLLOWS_M_SQRTHZ or not settings.zero_rate
    if follows or {fault.code for fault in known} - HARMLESS:
        return
    count = len(found)
    lost = samples_unknown(known, len(recording))[-count:]
    readings = Readings(
        found.time_s,
        recording.sensor(FRAME).acc_mps2[-count:],
        recording.gyroscope(FRAME)[-count:],
        found.stationary,
        lost,
    )
    moves = moves_between_rests(readings)
    if not moves.spans:
        return
    ends = np.array([(span.start, span.stop - 1) for span in moves.spans])
    ways = found.position_m[ends[:, 1], :2] - found.position_m[ends[:, 0], :2]
    forward = _by_frame(ways, found.yaw_rad[ends].mean(axis=1))
    # On a slope of some degrees the filter drops the update, and z follows the floor.
    heights, gained = moves.misfit[:, 5], np.diff(found.position_m[ends, 2], axis=1)[:, 0]
    heights = np.where(heights == 0, 0.0, heights - gained)
    high = np.abs(heights) > KERB_M
    slope = slope_of_floor(ways, heights)
    sloping = ways @ slope
    if high.any():
        what, heights = _kerbs(heights[high]), np.where(high, heights, 0.0)
    elif (
        np.hypot(*slope) > np.tan(np.deg2rad(SLOPE_DEG))
        and _largest_sum(sloping) > RISE_M
        and (
            _largest_sum(sloping)
            > SLOPE_SDS * _rise_sd(ways, heights, forward, settings.axes_sd_rad)
            or _leans_with(slope, ways, forward, found.rotation_body_to_world[:, 2, :2], ends)
        )
    ):
        total = np.cumsum(sloping)
        way = "rises" if total[np.argmax(np.abs(total))] > 0 else "falls"
        what, heights = f"goes along a floor that {way} by {_largest_sum(sloping):.1f} m", sloping
    else:
        return
    flags = np.zeros(count, np.bool_)
    flags[moves.spans[int(np.argmax(heights != 0.0))].start :] = True
    largest = _largest_sum(heights)
    fault = fault_of(
        recording, "floor", FRAME, placed(flags, len(recording)),
        f"{what}, as its moves show: the path holds each rest at the height of the first, and its "
        "z, with the standard deviation, is that of a level floor; use x and y alone (Python: "
        "NavigationSettings(height_noise_m_sqrthz=10) lets z follow)",
        size=largest, unit="m",
    )  # fmt: skip
    yield replace(fault, costs=(Cost("place", largest, "m"),))


def _largest_sum(heights_m: FloatArray) -> float:
    return float(np.abs(np.cumsum(heights_m)).max())


def slope_of_floor(ways_m: FloatArray, heights_m: FloatArray) -> FloatArray:
    """Slope of a plane floor along x and y, by least squares; 0 where too few moves show it.

    Parameters
    ----------
    ways_m : (m, 2) array, m, of the moves
    heights_m : (m,) array, m, that each gains

    Returns
    -------
    (2,) array, 1

    Examples
    --------
    >>> slope_of_floor(np.tile([0.5, 0.0], (6, 1)), np.full(6, 0.02)).round(3).tolist()
    [0.04, 0.0]
    """
    if len(ways_m) < FEWEST_MOVES:
        return np.zeros(2)
    return np.asarray(_slope_by_heights(ways_m) @ heights_m)


def _slope_by_heights(ways_m: FloatArray) -> FloatArray:
    """Least squares as a matrix (2, m). Of a straight way the slope across stays 0."""
    return np.asarray(np.linalg.pinv(ways_m, rcond=0.1))


def _by_frame(ways_m: FloatArray, yaw_rad: FloatArray) -> FloatArray:
    """Ways (m, 2) along the frame's own axes, forward and to the left."""
    along = (ways_m @ [1, 1j]) * np.exp(-1j * yaw_rad)
    return np.column_stack([along.real, along.imag])


def _rise_sd(
    ways_m: FloatArray, heights_m: FloatArray, by_frame_m: FloatArray, axes_sd_rad: float
) -> float:
    """Standard deviation of what a floor gains up to its highest or lowest place, m.

    At rest an offset of the accelerometer turns what it takes for the vertical, and so do its axes;
    these also mix the way into the height. Seen from the frame that is one slope all along: on a
    straight way it passes for the floor's, there and back it cancels.
    """
    fit = _slope_by_heights(ways_m)
    slope = fit @ heights_m
    furthest = int(np.argmax(np.abs(np.cumsum(ways_m @ slope))))
    weights = ways_m[: furthest + 1].sum(axis=0) @ fit
    # Of the axes, vertical that reads as forward at rest, and forward as vertical in the move.
    by_sensor = axes_sd_rad * np.sqrt(OFFSET_PER_AXES**2 + 2) * (weights @ by_frame_m)
    left = heights_m - ways_m @ slope
    by_moves = np.sqrt(left @ left / max(len(left) - 2, 1)) * weights
    return float(np.hypot(np.linalg.norm(by_sensor), np.linalg.norm(by_moves)))


def _leans_with(
    slope: FloatArray,
    ways_m: FloatArray,
    by_frame_m: FloatArray,
    up: FloatArray,
    ends: NDArray[np.int_],
) -> bool:
    """Whether the frame has come to lean with the slope since its first rest.

    No constant error of the sensor changes that; a floor with one slope from the start does not
    either.
    """
    leans = up[ends].mean(axis=1) - up[0]
    by_leans = slope_of_floor(ways_m, (by_frame_m * leans).sum(axis=1))
    return bool(by_leans @ slope / np.hypot(*slope) > np.tan(np.deg2rad(CHANGES_DEG)))


def _kerbs(heights_m: FloatArray) -> str:
    most = float(heights_m[np.argmax(np.abs(heights_m))])
    often = "" if len(heights_m) == 1 else f", {len(heights_m)} times by more than {KERB_M:g} m"
    way = "higher" if most > 0 else "lower"
    return f"is set down {abs(most):.2f} m {way} than it was lifted{often}"
