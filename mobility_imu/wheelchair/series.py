"""Check of what the chair's functions are given: series of one length, or single numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_series

__all__ = ["alike"]


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
