"""Check of what the chair's functions are given: series of one length, numbers, offsets."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_series
from mobility_imu.offsets import GyroscopeOffset, check_offsets
from mobility_imu.recording import HIGHEST_RATE_HZ

__all__ = ["alike", "as_motion", "as_offsets", "as_rate"]

LARGEST_MOTION = 1e6
"""Largest speed, m/s, and rate, rad/s; sums over it do not overflow, and nothing moves so fast."""


def alike(**named: ArrayLike) -> list[FloatArray]:
    """Check that series have one length; single numbers go with any.

    Parameters
    ----------
    named : (n,) arrays or single numbers, by their names

    Returns
    -------
    list of float arrays, (n,) or ()

    Raises
    ------
    InputError
        If a value is no finite number, an array no series, or the series differ in length.
    """
    arrays = [_as_array(values, name) for name, values in named.items()]
    if len({array.shape for array in arrays if array.ndim}) > 1:
        sizes = ", ".join(f"{name} {a.shape}" for name, a in zip(named, arrays, strict=True))
        raise InputError(f"{sizes}: expected series of one length")
    return arrays


def as_motion(values: ArrayLike, name: str, *, length: int | None = None) -> FloatArray:
    """Check that an array is a finite series of speeds or rates that something can have.

    Parameters
    ----------
    values : (n,) array, m/s or rad/s
    name : what to call it in the error message
    length : the number of samples expected, if it is known

    Returns
    -------
    (n,) float array

    Raises
    ------
    InputError
        If it has another shape or length, holds NaN or infinity, or a value is beyond
        ``LARGEST_MOTION``.
    """
    series = as_series(values, name, length=length)
    largest = max(float(series.max()), -float(series.min())) if len(series) else 0.0
    if largest > LARGEST_MOTION:
        first = int(np.argmax(np.abs(series) > LARGEST_MOTION))
        raise InputError(
            f"{name}: sample {first} is {series[first]:.4g}, more than anything moves "
            f"({LARGEST_MOTION:g}): correct or remove it"
        )
    return series


def _as_array(values: ArrayLike, name: str) -> FloatArray:
    single = not hasattr(values, "__len__") or isinstance(values, str)
    if single or getattr(values, "ndim", None) == 0:
        return np.asarray(as_number(values, name, negative=True))
    return as_series(values, name)


def as_offsets(offsets: Mapping[str, GyroscopeOffset] | None) -> dict[str, GyroscopeOffset]:
    """Check offsets of gyroscopes from other recordings.

    Parameters
    ----------
    offsets : sensor to GyroscopeOffset; none if None

    Returns
    -------
    dict

    Raises
    ------
    InputError
        If it is no mapping, or a value is no GyroscopeOffset.
    """
    given = {} if offsets is None else offsets
    check_offsets("offsets", given)
    return dict(given)


def as_rate(sampling_rate_hz: float) -> float:
    """Check that a rate is not beyond that of any sensor.

    One that is too low is left to the checks of the clock: they know of milliseconds.

    Parameters
    ----------
    sampling_rate_hz : Hz

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is no number above 0, or too large.
    """
    rate = as_number(sampling_rate_hz, "sampling_rate_hz")
    if rate > HIGHEST_RATE_HZ:
        raise InputError(f"sampling_rate_hz = {rate:g}: expected {HIGHEST_RATE_HZ:g} Hz at most")
    return rate
