"""What several recipes do to series: low-pass without delay, the longest run of a flag."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray
from mobility_imu.runs import runs_of


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
    """
    from scipy import signal

    b, a = signal.butter(2, cutoff_hz / (rate_hz / 2))
    return np.asarray(signal.filtfilt(b, a, np.asarray(values, float), axis=0))


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
