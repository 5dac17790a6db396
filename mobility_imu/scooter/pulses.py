"""Hall pulses of a rear wheel: when the scooter moves, and how far apart two loggers' clocks are.

The paper keeps what was recorded in motion, by the pulses of a rear wheel, and finds the clock of
its reference, which runs on a second logger, by the same pulses (section 2.5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_clock, as_floats, as_number, as_series

__all__ = ["ClockOffset", "moving_samples", "reference_angles", "synchronise"]

BINS_PER_WINDOW = 16
MOST_BINS = 40_000_000
PAIRS_AT_ONCE = 4_000_000
PAIRS_IN_ORDER = 500_000


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
    """Samples that were recorded in motion: those between two pulses that follow soon.

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
    longest_gap_s = as_number(longest_gap_s, "longest_gap_s")
    if len(pulses) < 2:
        return np.zeros(len(time), bool)
    after = np.searchsorted(pulses, time, side="right")
    inside = (after > 0) & (after < len(pulses))
    gaps = np.diff(pulses)[np.clip(after - 1, 0, len(pulses) - 2)]
    return inside & (gaps <= longest_gap_s)


def synchronise(
    pulses_s: ArrayLike, reference_pulses_s: ArrayLike, *, tolerance_s: float = 0.02
) -> ClockOffset:
    """Offset of a second clock, from the pulses that both loggers saw.

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
    proposals = _Proposals(ours, theirs, as_number(tolerance_s, "tolerance_s"))
    votes, first = proposals.most_votes()
    offset = float(np.median(proposals.between(first, first + proposals.tolerance_s)))
    rival, _ = proposals.most_votes(apart_from=offset)
    if votes < 3 or rival >= votes:
        raise InputError(
            f"pulses_s and reference_pulses_s: {votes} of {len(ours)} pulses match at "
            f"{offset:.3f} s, {rival} at another offset: no one offset fits (constant speed all "
            "the way, or pulses of two rides?)"
        )
    return ClockOffset(offset, votes)


class _Proposals:
    """Offsets that all pairs of pulses propose, counted without keeping all pairs.

    A histogram with bins much narrower than the tolerance bounds the votes of every window from
    above; only where a window may win are the proposals put in order and counted.
    """

    def __init__(self, ours: FloatArray, theirs: FloatArray, tolerance_s: float) -> None:
        self.ours, self.theirs, self.tolerance_s = ours, theirs, tolerance_s
        self.origin, self.step = theirs[0] - ours[-1], tolerance_s / BINS_PER_WINDOW
        span = (theirs[-1] - ours[0] - self.origin) / self.step
        if not span <= MOST_BINS:
            raise InputError(
                f"pulses_s and reference_pulses_s: {span * self.step:.3g} s from the first to the "
                f"last, expected at most {MOST_BINS * self.step:.3g} s with a tolerance of "
                f"{tolerance_s:g} s: are the times in s?"
            )
        self.bins = int(span) + 2
        counts = np.zeros(self.bins, np.int64)
        rows = max(1, PAIRS_AT_ONCE // len(ours))
        for start in range(0, len(theirs), rows):
            part = (theirs[start : start + rows, None] - ours - self.origin).ravel()
            bins = (part / self.step).astype(np.int64)
            low = bins.min()
            found = np.bincount(bins - low)
            counts[low : low + len(found)] += found
        # A window begins in its bin and, with rounding, ends one bin beyond its width at most.
        total = np.r_[0, np.cumsum(counts)]
        ends = np.minimum(np.arange(len(counts)) + BINS_PER_WINDOW + 2, len(counts))
        bound = total[ends] - total[:-1]
        self.cuts = np.unique(
            np.searchsorted(total, np.arange(0, total[-1], PAIRS_IN_ORDER), side="right") - 1
        )
        self.bound = np.maximum.reduceat(bound, self.cuts)

    def between(self, low: float, high: float) -> FloatArray:
        """Proposals from low to high, in order."""
        starts = np.searchsorted(self.theirs, self.ours + (low - self.step), side="left")
        stops = np.searchsorted(self.theirs, self.ours + (high + self.step), side="right")
        counts = stops - starts
        own = np.repeat(np.arange(len(self.ours)), counts)
        places = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        found = np.sort(self.theirs[np.repeat(starts, counts) + places] - self.ours[own])
        return found[(found >= low) & (found <= high)]

    def most_votes(self, *, apart_from: float | None = None) -> tuple[int, float]:
        """Most proposals in a window, and the first proposal of that window.

        With ``apart_from``, only windows count that begin further from it than two tolerances.
        """
        most, first = 0, np.inf
        edges = self.origin + np.r_[self.cuts, self.bins] * self.step
        for k in np.argsort(-self.bound, kind="stable"):
            if self.bound[k] < most:
                break
            high = edges[k + 1] + self.step
            found = self.between(edges[k] - self.step, high + self.tolerance_s)
            votes = np.searchsorted(found, found + self.tolerance_s, side="right")
            votes -= np.arange(len(found))
            counted = found <= high
            if apart_from is not None:
                counted &= np.abs(found - apart_from) > 2 * self.tolerance_s
            votes = np.where(counted, votes, 0)
            best = int(np.argmax(votes)) if len(votes) else 0
            if len(votes) and (votes[best], -found[best]) > (most, -first):
                most, first = int(votes[best]), float(found[best])
        return most, first


def reference_angles(
    time_s: ArrayLike, reference_time_s: ArrayLike, reference_rad: ArrayLike, offset_s: float
) -> FloatArray:
    """Angles of the wire sensors at the times of our samples, by linear interpolation.

    Parameters
    ----------
    time_s : (n,) array, s, our clock
    reference_time_s : (m,) array, s, the reference's clock
    reference_rad : (m, k) array, rad
    offset_s : s, reference clock minus ours, see :func:`synchronise`

    Returns
    -------
    (n, k) array, rad; the first and last value hold beyond the reference's ends

    Raises
    ------
    InputError
        If a clock does not increase, or the reference's arrays differ in length.
    """
    time = as_series(time_s, "time_s")
    offset = as_number(offset_s, "offset_s", negative=True)
    theirs = as_clock(reference_time_s, "reference_time_s") - offset
    values = as_floats(reference_rad, "reference_rad")
    if values.ndim != 2 or len(values) != len(theirs):
        raise InputError(f"reference_rad has shape {values.shape}: expected ({len(theirs)}, k)")
    return np.column_stack([np.interp(time, theirs, column) for column in values.T])


def _pulses(values: ArrayLike, name: str, least: int) -> FloatArray:
    pulses = as_series(values, name)
    if (np.diff(pulses) < 0).any():
        raise InputError(f"{name}: expected times in order")
    if len(pulses) < least:
        raise InputError(f"{name}: {len(pulses)} pulses, expected at least {least}")
    return pulses
