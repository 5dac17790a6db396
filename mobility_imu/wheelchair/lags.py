"""Time by which one sensor comes after another, from a movement that both see."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from mobility_imu.frames import FloatArray
from mobility_imu.wheelchair.fits import covariance_by_pieces, pieces_of
from mobility_imu.wheelchair.series import as_motion, as_rate

__all__ = ["Lag", "lag_between"]

LONGEST_LAG_S = 3.0
"""Longer ones leave too little of a short recording; a push repeats itself every second, a turn
does not."""
LEAST_CORRELATION = 0.8
"""Series that go together less well, whatever the lag, do not see the same movement."""
MOST_STEPS = 5
"""Whole samples are corrected by the fit so often at most."""
LEAST_CHANGE = 1e-9
"""Series that change by less, in rad/s or m/s, stand still: what is left is rounding."""
PIECE_S = 2.0
"""Residuals within such a piece depend on each other."""


class Lag(NamedTuple):
    """How much later a second series comes.

    Parameters
    ----------
    lag_s, sd_s : s, positive if the second comes after the first, and its standard deviation
    correlation : of the two series once the lag is taken out
    """

    lag_s: float
    sd_s: float
    correlation: float


def lag_between(first: ArrayLike, second: ArrayLike, sampling_rate_hz: float) -> Lag | None:
    """Lag of a second series after a first one that sees the same movement.

    The largest correlation gives whole samples; a least-squares fit of the first series' slope to
    what is left gives the rest of it, and its standard deviation from the scatter of whole pieces.

    Parameters
    ----------
    first, second : (n,) arrays in one unit
    sampling_rate_hz : Hz

    Returns
    -------
    Lag, or None where the two do not go together for any lag
    """
    one = as_motion(first, "first")
    two = as_motion(second, "second", length=len(one))
    rate = as_rate(sampling_rate_hz)
    reach = min(round(LONGEST_LAG_S * rate), len(one) // 3)
    if reach < 2:
        return None
    one, two = one - one.mean(), two - two.mean()
    if not one.any() or not two.any():
        return None
    size = fft.next_fast_len(len(one) + reach, real=True)
    product = fft.irfft(np.conj(fft.rfft(one, size)) * fft.rfft(two, size), size)
    steps = np.arange(-reach, reach + 1)
    products = product[steps]
    best = int(steps[np.argmax(products)])
    for _ in range(MOST_STEPS):
        early, late = _overlap(one, two, best)
        slope = np.gradient(early) * rate
        design = np.column_stack([early, -slope, np.ones(len(early))])
        found = np.linalg.lstsq(design, late, rcond=None)[0]
        if not found[0] > 0:
            return None
        rest = float(found[1] / found[0])
        more = round(float(np.clip(rest * rate, -reach, reach)))
        if not more or abs(best + more) > reach:
            break
        best += more
    if min(np.ptp(early), np.ptp(late)) < LEAST_CHANGE:
        return None
    correlation = float(np.corrcoef(early, late)[0, 1])
    if not correlation > LEAST_CORRELATION or abs(rest) * rate > 1:
        return None
    residual = late - design @ found
    covariance = covariance_by_pieces(design, residual, pieces_of(len(early), PIECE_S, rate))
    return Lag(best / rate + rest, float(np.sqrt(covariance[1, 1]) / found[0]), correlation)


def _overlap(one: FloatArray, two: FloatArray, steps: int) -> tuple[FloatArray, FloatArray]:
    """Both series where they overlap once the second comes earlier by some samples."""
    if steps >= 0:
        return one[: len(one) - steps], two[steps:]
    return one[-steps:], two[: len(two) + steps]
