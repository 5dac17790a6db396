"""A floor that is not level: the moves show it, and the path holds each rest at one height."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

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
    # On a slope of some degrees the filter drops the update, and z follows the floor.
    heights, gained = moves.misfit[:, 5], np.diff(found.position_m[ends, 2], axis=1)[:, 0]
    heights = np.where(heights == 0, 0.0, heights - gained)
    high = np.abs(heights) > KERB_M
    slope = slope_of_floor(ways, heights)
    sloping = ways @ slope
    if high.any():
        what, heights = _kerbs(heights[high]), np.where(high, heights, 0.0)
    elif np.hypot(*slope) > np.tan(np.deg2rad(SLOPE_DEG)) and _largest_sum(sloping) > RISE_M:
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
    # Of a straight way the slope across stays 0.
    slope, *_ = np.linalg.lstsq(ways_m, heights_m, rcond=0.1)
    return np.asarray(slope)


def _kerbs(heights_m: FloatArray) -> str:
    most = float(heights_m[np.argmax(np.abs(heights_m))])
    often = "" if len(heights_m) == 1 else f", {len(heights_m)} times by more than {KERB_M:g} m"
    way = "higher" if most > 0 else "lower"
    return f"is set down {abs(most):.2f} m {way} than it was lifted{often}"
