"""Axes, signs and units that every module keeps to.

* Right-handed frames. Vectors are columns of components; arrays are ``(n, 3)``, time first.
* Scooter body {B}: x right, y forward, z up (the frame of Suzurikawa et al. 2022).
  Wheelchair and walker: x forward, y left, z up.
* ``rotation_a_to_b`` turns components in frame a into components in frame b.
* Accelerometers read specific force: a sensor at rest reads +9.81 m/s² along the axis
  that points up. Gyroscopes read rad/s, right-hand rule; a yaw rate is positive to the left.
* SI and radians inside; degrees only in files and pictures for people, with suffix ``_deg``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError

FloatArray = NDArray[np.float64]

STANDARD_GRAVITY_MPS2 = 9.80665
"""What an ideal accelerometer at rest reads in total, m/s² (standard gravity)."""


def wrap_angle(angle_rad: ArrayLike) -> FloatArray:
    """Bring angles into the half-open interval [-pi, pi).

    Parameters
    ----------
    angle_rad : array, rad, any shape

    Returns
    -------
    array of the same shape, rad

    Examples
    --------
    >>> wrap_angle([0.0, 4.0]).round(4).tolist()
    [0.0, -2.2832]
    """
    return (np.asarray(angle_rad, float) + np.pi) % (2 * np.pi) - np.pi


def as_vectors(values: ArrayLike, name: str) -> FloatArray:
    """Check that an array is made of three-vectors and of real numbers.

    Parameters
    ----------
    values : (..., 3) array
    name : what to call it in the error message

    Returns
    -------
    (..., 3) float array

    Raises
    ------
    InputError
        If the last axis has not three components, or a component is not a number.
    """
    array = _as_float(values, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise InputError(f"{name}: expected three components in the last axis, got {array.shape}")
    return array


def as_series(values: ArrayLike, name: str, *, length: int | None = None) -> FloatArray:
    """Check that an array is one finite time series.

    Parameters
    ----------
    values : (n,) array
    name : what to call it in the error message
    length : the number of samples expected, if it is known

    Returns
    -------
    (n,) float array

    Raises
    ------
    InputError
        If it has another shape or length, or holds NaN or infinity.
    """
    array = _as_float(values, name)
    if array.ndim != 1:
        raise InputError(f"{name}: expected one time series, got an array of shape {array.shape}")
    if length is not None and len(array) != length:
        raise InputError(f"{name}: expected {length} samples like the others, got {len(array)}")
    bad = ~np.isfinite(array)
    if bad.any():
        first = int(np.argmax(bad))
        raise InputError(f"{name}: sample {first} is {array[first]}, expected a finite number")
    return array


def _as_float(values: Any, name: str) -> FloatArray:
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected real numbers") from None
