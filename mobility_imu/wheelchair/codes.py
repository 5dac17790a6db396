"""The six locomotor tasks and their codes (Table 2 of the document)."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import as_series

__all__ = ["Codes", "Task", "as_codes"]

Codes = NDArray[np.int8]


class Task(IntEnum):
    """The six tasks of Table 2, with the tool's codes."""

    STATIC = 1
    FORWARD = 2
    BACKWARD = 3
    PIVOT = 4
    TIGHT = 5
    WIDE = 6

    @property
    def title(self) -> str:
        """Name of the task in words."""
        return {
            Task.STATIC: "static",
            Task.FORWARD: "forward propulsion",
            Task.BACKWARD: "backward propulsion",
            Task.PIVOT: "pivot rotation",
            Task.TIGHT: "tight rotation",
            Task.WIDE: "wide rotation",
        }[self]


def as_codes(
    codes: ArrayLike,
    name: str = "codes",
    known: tuple[int, ...] = tuple(Task),
    *,
    length: int | None = None,
) -> Codes:
    """Check that an array is a series of codes.

    Parameters
    ----------
    codes : (n,) array of whole numbers
    name : what to call it in the error message
    known : codes that are allowed; those of :class:`Task` if not given
    length : number of codes expected, if it is known

    Returns
    -------
    (n,) array of int8

    Raises
    ------
    InputError
        If it has another shape or length, or a code is unknown.
    """
    if type(codes) is np.ndarray and codes.dtype == np.int8 and codes.ndim == 1:
        array, numbers = codes, codes
    else:
        numbers = as_series(codes, name)
        array = np.zeros(len(numbers), np.int8)
    if length is not None and len(numbers) != length:
        raise InputError(f"{name}: expected {length} samples like the others, got {len(numbers)}")
    if len(numbers):
        low, high = min(known), max(known)
        strange = (numbers < low) | (numbers > high)
        if numbers.dtype != np.int8:
            strange |= numbers != np.round(numbers)
        if strange.any():
            first = int(np.argmax(strange))
            raise InputError(
                f"{name}: sample {first} is {numbers[first]:g}, expected {low} to {high}"
            )
    return array if numbers is array else numbers.astype(np.int8)
