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
from decimal import Decimal
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError

FloatArray = NDArray[np.float64]
Choice = TypeVar("Choice")
_TRUTH = (bool, np.bool_)

ROUNDED = 0.02
"""A rotation matrix whose numbers have two decimals misses an orthogonal one by less."""
STANDARD_GRAVITY_MPS2 = 9.80665
"""What an ideal accelerometer at rest reads in total, m/s² (standard gravity)."""
GAP_FACTOR = 1.5
"""A time step longer than this many usual ones is a gap; at 1.5 a sample is missing."""
SHORTEST_STEP_S, LONGEST_STEP_S = 1e-9, 1e9
"""Between these lies the usual step of any clock in seconds."""
LONGEST_SHOWN = 60
"""Characters of a value that a message shows at most."""


def wrap_angle(angle_rad: ArrayLike) -> FloatArray:
    """Angles in the half-open interval [-pi, pi); NaN and infinity become NaN.

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
    angle = as_floats(angle_rad, "angle_rad")
    with np.errstate(invalid="ignore"):  # infinite angles have no place in a turn: NaN
        wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    # The remainder of a number just below a multiple is rounded up to the whole turn.
    return np.asarray(np.where(wrapped >= np.pi, -np.pi, wrapped))


def as_floats(values: Any, name: str) -> FloatArray:
    """Check that an array of any shape is made of real numbers, and make them floats.

    Complex numbers, dates, text, truth values, missing and masked values are refused: a
    conversion would change their meaning without a word. An array of floats is not copied.

    Parameters
    ----------
    values : array
    name : what to call it in the error message

    Returns
    -------
    float array of the same shape

    Raises
    ------
    InputError
        If a value is not a real number, or rows of nested lists differ in length.

    Examples
    --------
    >>> as_floats(["1", "2"], "time_s")
    Traceback (most recent call last):
    mobility_imu.errors.InputError: time_s: expected real numbers, got text
    """
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise InputError(f"{name}: expected real numbers, got masked values")
    if isinstance(values, bytearray):
        raise InputError(f"{name}: expected real numbers, got bytes")
    if not isinstance(values, np.ndarray) and _holds_truth(values):
        raise InputError(f"{name}: expected real numbers, got truth values")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: expected real numbers in rows of one length") from None
    if array.dtype.kind == "O":  # columns of mixed types: converted one by one
        strange = [kind for kind in set(map(type, array.ravel())) if not _is_real(kind)]
        if strange:
            raise InputError(f"{name}: expected real numbers, got {strange[0].__name__}")
        try:
            array = array.astype(float)
        except OverflowError:
            raise InputError(f"{name}: a number is too large") from None
    elif array.dtype.kind not in "fiu":
        kinds = {"U": "text", "S": "text", "b": "truth values", "c": "complex numbers"}
        kinds |= {"M": "dates", "m": "time differences"}
        got = kinds.get(array.dtype.kind, str(array.dtype))
        raise InputError(f"{name}: expected real numbers, got {got}")
    with np.errstate(over="ignore"):  # longer floats may become infinite
        return np.asarray(array.astype(float, copy=False))


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
    if ndim is not None:
        _check_control("ndim", ndim)
    if length is not None:
        _check_control("length", length)
    if not isinstance(finite, _TRUTH):
        check_switches(finite=finite)
    array = as_floats(values, name)
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
    if length is not None:
        _check_control("length", length)
    array = as_floats(values, name)
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
        gap; the message says where. Also if the usual step is none that a clock in s can have.
    """
    check_switches(even=even)
    clock = as_series(time_s, name)
    if len(clock) < 2:
        raise InputError(f"{name}: {len(clock)} sample(s), expected at least 2")
    with np.errstate(over="ignore"):
        step = np.diff(clock)
    if (step == 0).any():
        k = int(np.argmax(step == 0))
        raise InputError(f"{name}: {clock[k]:g} s appears twice (samples {k} and {k + 1})")
    if (step < 0).any():
        k = int(np.argmax(step < 0))
        raise InputError(
            f"{name}: runs backwards at sample {k + 1} ({clock[k]:g} s, then {clock[k + 1]:g} s)"
        )
    usual = float(np.median(step))
    if not SHORTEST_STEP_S <= usual <= LONGEST_STEP_S or not np.isfinite(step).all():
        raise InputError(f"{name}: steps of {usual:.3g} s, which no clock has; are the times in s?")
    gap = step > GAP_FACTOR * usual
    if even and gap.any():
        k = int(np.argmax(gap))
        raise InputError(
            f"{name}: gap of {step[k]:.3g} s after {clock[k]:g} s (usual step {usual:.3g} s; "
            f"{int(gap.sum())} gap(s) in all)"
        )
    return clock


def as_flags(flags: ArrayLike, name: str, *, length: int | tuple[int, ...]) -> NDArray[np.bool_]:
    """Check that an array has one flag per sample.

    Parameters
    ----------
    flags : (n,) array of truth values, or of 0 and 1
    name : what to call it in the error message
    length : the number of samples, or the shape of the array that they stand in

    Returns
    -------
    (n,) bool array, a copy; with a shape, an array of that shape
    """
    if not isinstance(length, tuple):
        _check_control("length", length)
        length = (length,)
    expected = f"{name}: expected truth values, or 0 and 1"
    if isinstance(flags, np.ma.MaskedArray) and np.ma.is_masked(flags):
        raise InputError(f"{expected}; some are masked")
    if isinstance(flags, bytearray):
        raise InputError(f"{expected}, got bytes")
    try:
        array = np.array(flags)
    except (TypeError, ValueError):
        raise InputError(expected) from None
    if array.dtype.kind == "O" and set(map(type, array.ravel())) <= {bool, np.bool_}:
        array = array.astype(np.bool_)
    if array.shape != length:
        raise InputError(f"{name}: expected shape {length} like the others, got {array.shape}")
    if array.dtype != np.bool_ and not (array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all()):
        raise InputError(expected)
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
    tolerance = as_number(tolerance, "tolerance", zero=True)
    array = as_floats(matrix, name)
    if array.shape != (3, 3) or not np.isfinite(array).all():
        raise InputError(f"{name}: expected a rotation matrix of 3 x 3 numbers")
    off = np.abs(array @ array.T - np.eye(3)).max() if np.abs(array).max() <= 2 else np.inf
    if off > tolerance:
        rounded = "; were its numbers rounded? Write six digits" if off < ROUNDED else ""
        raise InputError(f"{name}: not orthogonal, expected a 3 x 3 rotation matrix{rounded}")
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
    the choice that equals the value

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
    if not isinstance(choices, Collection) or getattr(choices, "ndim", 1) == 0:
        raise InputError(f"choices: got {type(choices).__name__}, expected a collection")
    if isinstance(value, np.bool_):
        value = bool(value)  # type: ignore[assignment]
    for choice in choices:
        # Of one kind first: arrays have no single truth value, and True does not mean 1.
        real, wanted = _is_real(type(value)), _is_real(type(choice))
        if real == wanted and (real or isinstance(value, type(choice))) and value == choice:
            return choice
    names = [repr(choice) for choice in choices]
    expected = " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
    raise InputError(f"{name} = {shown(value)}: expected {expected}")


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
    # Each alone first: this is called more often than any other check.
    if not (
        isinstance(zero, _TRUTH) and isinstance(negative, _TRUTH) and isinstance(infinite, _TRUTH)
    ):
        check_switches(zero=zero, negative=negative, infinite=infinite)
    expected = "a number" if negative else "a number of 0 or more" if zero else "a positive number"
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    try:
        with np.errstate(over="ignore"):
            number = float(value) if _is_real(type(value)) else np.nan
    except OverflowError:
        number = np.nan
    low = number >= 0 if zero else number > 0
    if not (negative or low) or not (np.isfinite(number) or (infinite and not np.isnan(number))):
        raise InputError(f"{name} = {shown(value)}: expected {expected}")
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
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if not (_is_real(type(least)) and isinstance(least, numbers.Integral)):
        raise InputError(f"least = {shown(least)}: expected a whole number")
    whole = _is_real(type(value)) and isinstance(value, numbers.Integral)
    if not whole or value < least:
        raise InputError(f"{name} = {shown(value)}: expected a whole number of {least} or more")
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


def shown(value: object) -> str:
    """Value as a message shows it: on one line, and cut after some characters.

    Parameters
    ----------
    value : anything

    Returns
    -------
    str

    Examples
    --------
    >>> shown("0.84"), shown(0.84), shown(10**80)[-6:]
    ("'0.84'", '0.84', '000...')
    """
    try:
        text = " ".join((f"{value}" if _is_real(type(value)) else repr(value)).split())
    except (ValueError, RecursionError):
        # Python writes no integer of more than some thousand digits, and no endless nesting.
        return "a value too long to show"
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def check_switches(**switches: Any) -> None:
    """Check that options are True or False: an array has no single truth value.

    Parameters
    ----------
    **switches : name of an option to what was given

    Raises
    ------
    InputError
        If one is something else.
    """
    for name, value in switches.items():
        if not isinstance(value, _TRUTH):
            raise InputError(f"{name} = {shown(value)}: expected True or False")


def check_together(**shapes: tuple[int, ...]) -> None:
    """Check that arrays broadcast together.

    Parameters
    ----------
    **shapes : name of each array to its shape, without the axis of components

    Raises
    ------
    InputError
        If they do not; the message has all names and shapes.
    """
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        got = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(f"{got}: expected the same number of samples") from None


def _check_control(name: str, value: Any) -> None:
    """Check a number of dimensions or samples."""
    if not isinstance(value, int | np.integer) or value < 0:
        raise InputError(f"{name} = {shown(value)}: expected a whole number")


def _is_real(kind: type) -> bool:
    """Whether values of a type are real numbers; truth values and time differences are not."""
    return issubclass(kind, numbers.Real | Decimal) and not issubclass(
        kind, bool | np.bool_ | np.timedelta64
    )


def _holds_truth(values: Any) -> bool:
    """Whether nested lists have a truth value among numbers, which NumPy would turn into 1 or 0."""
    if not isinstance(values, list | tuple):
        return isinstance(values, bool | np.bool_)
    kinds = set(map(type, values))
    if kinds <= {float, int}:
        return False
    return any(map(_holds_truth, values))
