"""What is wrong with a sensor: samples in which it is frozen or at the end of its range."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_count, as_floats, as_number
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

    Raises
    ------
    InputError
        If the readings are no series of one or more axes.
    """
    values = _readings(values)
    rate = as_number(sampling_rate_hz, "sampling_rate_hz")
    if not len(values):
        return np.zeros(0, np.bool_)
    same = np.r_[False, (np.diff(values, axis=0) == 0).all(axis=1)]
    return long_runs(same, max(2, round(0.25 * rate) - 1), grow=True)


def saturated_samples(values: ArrayLike, *, run: int = 3) -> NDArray[np.bool_]:
    """Where an axis stays at its largest size for some samples: the range of the sensor is cut.

    Parameters
    ----------
    values : (n, k) array
    run : fewest samples at the limit, one after the other

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If the readings are no series of one or more axes.
    """
    values, run = _readings(values), as_count(run, "run")
    cut = np.zeros(len(values), bool)
    if not len(values):
        return cut
    for axis in np.abs(values).T:
        at_limit = (axis == axis.max()) & (axis > 1.2 * np.median(axis))
        cut |= long_runs(at_limit, run, grow=False)
    return cut


def _readings(values: ArrayLike) -> FloatArray:
    """Readings as floats, not as int16, which cannot hold its own largest size."""
    array = as_floats(values, "values")
    if array.ndim != 2 or not array.shape[1]:
        raise InputError(f"values: expected shape (n, k), got {array.shape}")
    return array
