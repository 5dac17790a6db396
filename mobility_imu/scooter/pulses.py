"""Hall pulses of a rear wheel: when the scooter moves, and how far apart two loggers' clocks are.

The paper keeps what was recorded in motion, by the pulses of a rear wheel, and finds the clock of
its reference, which runs on a second logger, by the same pulses (section 2.5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_series


class ClockOffset(NamedTuple):
    """How far one clock is ahead of another.

    Parameters
    ----------
    offset_s : s, reference clock minus own clock
    matched : number of pulses that support it
    """

    offset_s: float
    matched: int


def moving_samples(
    time_s: ArrayLike, pulses_s: ArrayLike, *, longest_gap_s: float
) -> NDArray[np.bool_]:
    """Tell which samples were recorded in motion: those between two pulses that follow soon.

    The paper extracts "the data recorded during motion based on the signal from the Hall sensor"
    and says no more. A longest gap between pulses is our reading of it. Motion before the first
    and after the last pulse of a ride, up to one pulse's way each, is lost.

    Parameters
    ----------
    time_s : (n,) array, s
    pulses_s : (m,) array, s, on the same clock
    longest_gap_s : s; two pulses further apart have a standstill between them. The way from pulse
        to pulse divided by this is the slowest speed that counts as motion.

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If the pulses are not in order, or the gap is not positive.

    Examples
    --------
    >>> moving_samples([0, 1, 2, 3, 4, 5], [0.9, 2.1, 4.8], longest_gap_s=1.5).tolist()
    [False, True, True, False, False, False]
    """
    time, pulses = as_series(time_s, "time_s"), _pulses(pulses_s, "pulses_s", 0)
    if not longest_gap_s > 0:
        raise InputError(f"longest_gap_s = {longest_gap_s}: expected a positive time")
    if len(pulses) < 2:
        return np.zeros(len(time), bool)
    after = np.searchsorted(pulses, time, side="right")
    inside = (after > 0) & (after < len(pulses))
    gaps = np.diff(pulses)[np.clip(after - 1, 0, len(pulses) - 2)]
    return inside & (gaps <= longest_gap_s)


def synchronise(
    pulses_s: ArrayLike, reference_pulses_s: ArrayLike, *, tolerance_s: float = 0.02
) -> ClockOffset:
    """Find the offset of a second clock from the pulses that both loggers saw.

    Every pair of pulses proposes an offset. The one proposed most often, within the tolerance, is
    taken, and the median of its proposals returned: a pulse that one logger missed, or saw twice,
    does no harm. At constant speed a shift by one pulse fits almost as well; starting and stopping
    tell them apart.

    Parameters
    ----------
    pulses_s : (m,) array, s, on our clock
    reference_pulses_s : (k,) array, s, on the reference's clock
    tolerance_s : s, width of the window in which proposals count as one: the sampling interval of
        the slower logger and some reserve for drift

    Returns
    -------
    ClockOffset
        ``reference_time - offset_s`` is on our clock. A logger that samples sees a pulse up to one
        sample late, on average half of it: that stays in the offset.

    Raises
    ------
    InputError
        With fewer than three pulses on a side, or if another offset fits as well.

    Examples
    --------
    >>> ours = np.array([1.0, 2.0, 2.7, 3.3, 4.1])
    >>> offset = synchronise(ours, np.delete(ours, 1) + 12.5)
    >>> round(offset.offset_s, 3), offset.matched
    (12.5, 4)
    """
    ours = _pulses(pulses_s, "pulses_s", 3)
    theirs = _pulses(reference_pulses_s, "reference_pulses_s", 3)
    proposed = np.sort((theirs[:, None] - ours[None, :]).ravel())
    ends = np.searchsorted(proposed, proposed + tolerance_s, side="right")
    votes = ends - np.arange(len(proposed))
    best = int(np.argmax(votes))
    offset = float(np.median(proposed[best : ends[best]]))
    elsewhere = np.abs(proposed - offset) > 2 * tolerance_s
    rival = int(votes[elsewhere].max(initial=0))
    if votes[best] < 3 or rival >= votes[best]:
        raise InputError(
            f"pulses_s and reference_pulses_s: {votes[best]} of {len(ours)} pulses match at "
            f"{offset:.3f} s, {rival} at another offset: no one offset fits (constant speed all "
            "the way, or pulses of two rides?)"
        )
    return ClockOffset(offset, int(votes[best]))


def reference_angles(
    time_s: ArrayLike, reference_time_s: ArrayLike, reference_rad: ArrayLike, offset_s: float
) -> FloatArray:
    """Bring the wire sensors' angles to the times of our samples, by linear interpolation.

    Parameters
    ----------
    time_s : (n,) array, s, our clock
    reference_time_s : (m,) array, s, the reference's clock
    reference_rad : (m, k) array, rad
    offset_s : s, reference clock minus ours, see :func:`synchronise`

    Returns
    -------
    (n, k) array, rad; the first and last value hold beyond the reference's ends
    """
    time = as_series(time_s, "time_s")
    theirs = as_series(reference_time_s, "reference_time_s") - offset_s
    values = np.asarray(reference_rad, float)
    if values.ndim != 2 or len(values) != len(theirs):
        raise InputError(f"reference_rad has shape {values.shape}: expected ({len(theirs)}, k)")
    return np.column_stack([np.interp(time, theirs, column) for column in values.T])


def _pulses(values: ArrayLike, name: str, least: int) -> FloatArray:
    pulses = np.asarray(values, float)
    if pulses.ndim != 1 or not np.isfinite(pulses).all() or (np.diff(pulses) < 0).any():
        raise InputError(f"{name}: expected finite times in order, one axis")
    if len(pulses) < least:
        raise InputError(f"{name}: {len(pulses)} pulses, expected at least {least}")
    return pulses
