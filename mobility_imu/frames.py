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

import dataclasses
import numbers
from collections.abc import Collection
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError

FloatArray = NDArray[np.float64]
Choice = TypeVar("Choice")

STANDARD_GRAVITY_MPS2 = 9.80665
"""What an ideal accelerometer at rest reads in total, m/s² (standard gravity)."""
GAP_FACTOR = 1.5
"""A time step longer than this many usual ones is a gap: at 1.5 a sample is missing."""


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
    wrapped = (np.asarray(angle_rad, float) + np.pi) % (2 * np.pi) - np.pi
    # The remainder of a number just below a multiple is rounded up to the whole turn.
    return np.asarray(np.where(wrapped >= np.pi, -np.pi, wrapped))


def as_vectors(
    values: ArrayLike,
    name: str,
    *,
    ndim: int | None = None,
    length: int | None = None,
    finite: bool = False,
) -> FloatArray:
    """Check that an array is made of three-vectors and of real numbers.

    Parameters
    ----------
    values : (..., 3) array
    name : what to call it in the error message
    ndim : number of dimensions expected: 1 for one vector, 2 for a series; None takes any
    length : number of vectors expected in a series, if it is known
    finite : whether NaN and infinity are refused

    Returns
    -------
    (..., 3) float array

    Raises
    ------
    InputError
        If the last axis has not three components, a component is not a real number, or the shape
        or a value is not what was asked for.

    Examples
    --------
    >>> as_vectors([0, 0, 9.81], "acc_mps2", ndim=2)
    Traceback (most recent call last):
    mobility_imu.errors.InputError: acc_mps2: expected shape (n, 3), got (3,)
    """
    array = _as_float(values, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise InputError(f"{name}: expected three components in the last axis, got {array.shape}")
    if ndim is not None and array.ndim != ndim:
        expected = {1: "(3,)", 2: "(n, 3)"}.get(ndim, f"of {ndim} dimensions")
        raise InputError(f"{name}: expected shape {expected}, got {array.shape}")
    if length is not None and (array.ndim != 2 or len(array) != length):
        raise InputError(f"{name}: expected shape ({length}, 3) like the others, got {array.shape}")
    if finite and not np.isfinite(array).all():
        rows = np.isfinite(array).all(axis=-1).ravel()
        raise InputError(f"{name}: not a finite number at row {int(np.argmin(rows))}")
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


def as_clock(time_s: ArrayLike, name: str = "time_s", *, even: bool = False) -> FloatArray:
    """Check that times are finite and increase.

    Parameters
    ----------
    time_s : (n,) array, s, two samples or more
    name : what to call it in the error message
    even : whether a step may be no longer than half as much again as the usual one

    Returns
    -------
    (n,) float array, s

    Raises
    ------
    InputError
        If there are fewer than two times, or they repeat, run backwards or, with ``even``, leave a
        gap; the message says where.
    """
    clock = as_series(time_s, name)
    if len(clock) < 2:
        raise InputError(f"{name}: {len(clock)} sample(s), expected at least 2")
    step = np.diff(clock)
    if (step == 0).any():
        k = int(np.argmax(step == 0))
        raise InputError(f"{name}: {clock[k]:g} s stands twice (samples {k} and {k + 1})")
    if (step < 0).any():
        k = int(np.argmax(step < 0))
        raise InputError(
            f"{name}: runs backwards at sample {k + 1} ({clock[k]:g} s, then {clock[k + 1]:g} s)"
        )
    usual = float(np.median(step))
    gap = step > GAP_FACTOR * usual
    if even and gap.any():
        k = int(np.argmax(gap))
        raise InputError(
            f"{name}: gap of {step[k]:.3g} s after {clock[k]:g} s (usual step {usual:.3g} s; "
            f"{int(gap.sum())} gap(s) in all)"
        )
    return clock


def as_flags(flags: ArrayLike, name: str, *, length: int) -> NDArray[np.bool_]:
    """Check that an array has one flag per sample.

    Parameters
    ----------
    flags : (n,) array of truth values, or of 0 and 1
    name : what to call it in the error message
    length : the number of samples

    Returns
    -------
    (n,) bool array, a copy
    """
    array = np.array(flags)
    if array.shape != (length,):
        raise InputError(f"{name}: expected shape ({length},) like the others, got {array.shape}")
    if array.dtype != np.bool_ and not (array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all()):
        raise InputError(f"{name}: expected truth values, or 0 and 1")
    return array.astype(np.bool_)


def as_rotation(matrix: ArrayLike, name: str, *, tolerance: float = 1e-3) -> FloatArray:
    """Check that a matrix is a rotation: orthogonal, and no mirror.

    Parameters
    ----------
    matrix : (3, 3) array
    name : what to call it in the error message
    tolerance : largest entry by which the matrix times its transpose may miss the identity

    Returns
    -------
    (3, 3) float array

    Raises
    ------
    InputError
        If it has another shape, is not orthogonal, or exchanges right and left.

    Examples
    --------
    >>> as_rotation([[1, 0, 0], [0, 1, 0], [0, 0, -1]], "mount")
    Traceback (most recent call last):
    mobility_imu.errors.InputError: mount: a mirror (determinant -1), expected a rotation matrix
    """
    array = _as_float(matrix, name)
    if array.shape != (3, 3) or not np.isfinite(array).all():
        raise InputError(f"{name}: expected a rotation matrix of 3 x 3 numbers")
    if not np.allclose(array @ array.T, np.eye(3), atol=tolerance):
        raise InputError(f"{name}: not orthogonal, expected a 3 x 3 rotation matrix")
    if np.linalg.det(array) < 0:
        raise InputError(f"{name}: a mirror (determinant -1), expected a rotation matrix")
    return array


def one_of(name: str, value: Choice, choices: Collection[Choice]) -> Choice:
    """Check that an option has one of its values.

    Parameters
    ----------
    name : of the option
    value : what was given
    choices : what may be given

    Returns
    -------
    the value

    Raises
    ------
    InputError
        If it is none of them.

    Examples
    --------
    >>> one_of("form", "prnted", ("corrected", "printed"))
    Traceback (most recent call last):
    mobility_imu.errors.InputError: form = 'prnted': expected 'corrected' or 'printed'
    """
    try:
        known = value in choices
    except (TypeError, ValueError):  # arrays, and what has no hash
        known = False
    if not known:
        *others, last = map(repr, choices)
        raise InputError(f"{name} = {value!r}: expected {', '.join(others)} or {last}")
    return value


def as_number(
    value: Any, name: str, *, zero: bool = False, negative: bool = False, infinite: bool = False
) -> float:
    """Check that a value is one real number, by default above zero.

    Parameters
    ----------
    value : number of Python or NumPy; truth values and text are none
    name : what to call it in the error message
    zero : whether zero is allowed
    negative : whether numbers below zero are allowed, zero as well
    infinite : whether infinity is allowed

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is not such a number.
    """
    expected = "a number" if negative else "a number of 0 or more" if zero else "a positive number"
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    real = isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)
    number = float(value) if real else np.nan
    low = number >= 0 if zero else number > 0
    if not (negative or low) or not (np.isfinite(number) or (infinite and not np.isnan(number))):
        shown = value if real else repr(value)
        raise InputError(f"{name} = {shown}: expected {expected}")
    return number


def as_count(value: Any, name: str, *, least: int = 1) -> int:
    """Check that a value is a whole number.

    Parameters
    ----------
    value : int of Python or NumPy; truth values are none
    name : what to call it in the error message
    least : smallest that is allowed

    Returns
    -------
    int

    Raises
    ------
    InputError
        If it is not a whole number, or too small.
    """
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool | np.bool_)
    if not whole or value < least:
        raise InputError(f"{name} = {value!r}: expected a whole number of {least} or more")
    return int(value)


def check_positive(settings: Any, *names: str, allow_zero: Collection[str] = ()) -> None:
    """Check that fields of a frozen dataclass are positive numbers, and make them floats.

    Parameters
    ----------
    settings : dataclass, in its ``__post_init__``
    names : fields to check; none checks all
    allow_zero : fields that may be zero

    Raises
    ------
    InputError
        If a field is not such a number; the message names class and field.
    """
    for field in names or [f.name for f in dataclasses.fields(settings)]:
        number = as_number(
            getattr(settings, field), f"{type(settings).__name__}.{field}", zero=field in allow_zero
        )
        object.__setattr__(settings, field, number)


def _as_float(values: Any, name: str) -> FloatArray:
    """Array of floats; complex numbers, dates, text, truth values and masks are refused."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise InputError(f"{name}: masked values, expected real numbers")
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O":  # columns of mixed types: converted one by one
            array = np.asarray(array, float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected real numbers") from None
    if array.dtype.kind not in "fiu":
        raise InputError(f"{name}: expected real numbers, got {array.dtype}")
    return array.astype(float, copy=False)
