"""Checks of what the chair's functions are given: series of one length, and objects of one kind."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_series

__all__ = ["alike", "expect"]


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


def _as_array(values: ArrayLike, name: str) -> FloatArray:
    single = not hasattr(values, "__len__") or isinstance(values, str)
    if single or getattr(values, "ndim", None) == 0:
        return np.asarray(as_number(values, name, negative=True))
    return as_series(values, name)


def expect(name: str, value: object, kind: type) -> None:
    """Check that an argument is of the kind that a function works with.

    Parameters
    ----------
    name : of the argument
    value : what was given
    kind : class that it must have

    Raises
    ------
    InputError
        If it is something else.
    """
    if not isinstance(value, kind):
        raise InputError(f"{name}: got {type(value).__name__}, expected {kind.__name__}")
