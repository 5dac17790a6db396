"""What several recipes do to series: low-pass without delay, the longest run of a flag."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_floats, as_number
from mobility_imu.runs import runs_of

LEAST_CUTOFF = 1e-6
"""Smallest cutoff, as a part of the rate; below it the filter's equations cannot be solved."""
FEWEST_SAMPLES = 10
"""The filter mirrors a series at its ends by 9 samples, and needs one more."""


def low_pass(values: ArrayLike, cutoff_hz: float, rate_hz: float) -> FloatArray:
    """Second-order Butterworth low-pass, forward and backward, of each column.

    Parameters
    ----------
    values : (n,) or (n, k) array
    cutoff_hz : Hz
    rate_hz : Hz

    Returns
    -------
    array of the same shape

    Raises
    ------
    InputError
        If the cutoff is not below half of the rate, or the series are too short or not finite.
    """
    from scipy import signal

    series = as_floats(values, "values")
    rate, cutoff = as_number(rate_hz, "rate_hz"), as_number(cutoff_hz, "cutoff_hz")
    least, most = LEAST_CUTOFF * rate, rate / 2
    if not least <= cutoff < most:
        raise InputError(f"cutoff_hz = {cutoff:g}: expected from {least:g} to below {most:g} Hz")
    if series.ndim not in (1, 2) or len(series) < FEWEST_SAMPLES or not np.isfinite(series).all():
        raise InputError(
            f"values: expected finite numbers, (n,) or (n, k), {FEWEST_SAMPLES} samples or more; "
            f"got shape {series.shape}"
        )
    b, a = signal.butter(2, cutoff / (rate / 2))
    return np.asarray(signal.filtfilt(b, a, series, axis=0))


def longest_run(flags: ArrayLike) -> slice:
    """The first of the longest runs where a flag is set; empty if it never is.

    Parameters
    ----------
    flags : (n,) bool array

    Returns
    -------
    slice
    """
    return max(runs_of(flags), key=lambda run: run.stop - run.start, default=slice(0, 0))
