"""What is wrong with a sensor: samples in which it is frozen or at the end of its range."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.runs import long_runs


def frozen_samples(values: ArrayLike, sampling_rate_hz: float) -> NDArray[np.bool_]:
    """Where a sensor repeats itself on all axes for a quarter of a second or more.

    Noise alone changes the last digit of some axis with every sample of a working sensor.

    Parameters
    ----------
    values : (n, k) array
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) bool array
    """
    values = np.asarray(values, float)
    if not len(values):
        return np.zeros(0, np.bool_)
    same = np.r_[False, (np.diff(values, axis=0) == 0).all(axis=1)]
    return long_runs(same, max(2, round(0.25 * sampling_rate_hz) - 1), grow=True)


def saturated_samples(values: ArrayLike, *, run: int = 3) -> NDArray[np.bool_]:
    """Where an axis stays at its largest size for some samples: the range of the sensor is cut.

    Parameters
    ----------
    values : (n, k) array
    run : fewest samples at the limit, one after the other

    Returns
    -------
    (n,) bool array
    """
    values = np.asarray(values, float)  # not int16, whose largest size it cannot hold
    cut = np.zeros(len(values), bool)
    if not len(values):
        return cut
    for axis in np.abs(values).T:
        at_limit = (axis == axis.max()) & (axis > 1.2 * np.median(axis))
        cut |= long_runs(at_limit, run, grow=False)
    return cut
