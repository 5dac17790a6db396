"""Checks of the simulators' settings that no other room needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import as_number, shown

LONGEST_S = 36000.0
"""Ten hours: no part of a simulation lasts longer."""
LONGEST_M = 1e4
"""No part of a course is longer."""


def check_range(value: Any, name: str, *, most: float = np.inf, any_order: bool = False) -> None:
    """Check that a value is a range of positive numbers, (low, high).

    Parameters
    ----------
    value : what was given
    name : what to call it in the error message
    most : largest high end
    any_order : whether it is a pair of which either may be the larger

    Raises
    ------
    InputError
        If it is no tuple or list of two numbers with 0 < low <= high <= most.
    """
    limit = f" <= {most:g}" if np.isfinite(most) else ""
    fits = isinstance(value, tuple | list) and len(value) == 2
    if fits:
        low, high = (as_number(end, name) for end in value)
        fits = max(low, high) <= most and (any_order or low <= high)
    if not fits:
        if any_order:
            raise InputError(
                f"{name} = {shown(value)}: expected two positive numbers{limit}, as a tuple"
            )
        raise InputError(
            f"{name} = {shown(value)}: expected (low, high) with 0 < low <= high{limit}, as a tuple"
        )


def check_ranges(style: Any) -> None:
    """Check that each field of a style is a range or a positive number, as its default is.

    Parameters
    ----------
    style : dataclass with defaults, in its ``__post_init__``
    """
    for field in fields(style):
        value = getattr(style, field.name)
        most = LONGEST_S if field.name.endswith("_s") else np.inf
        if isinstance(field.default, tuple):
            check_range(value, field.name, most=most)
        elif as_number(value, field.name) > most:
            raise InputError(f"{field.name} = {value:g}: expected up to {most:g}")


def check_triple(value: Any, name: str) -> None:
    """Check that a value is a sequence of three numbers, such as a place.

    Parameters
    ----------
    value : what was given
    name : what to call it in the error message

    Raises
    ------
    InputError
        If it is none.
    """
    if isinstance(value, bytes | bytearray | memoryview):
        raise InputError(f"{name} = {shown(value)}: expected three numbers")
    fits = isinstance(value, Sequence | np.ndarray) and not isinstance(value, str)
    if not fits or getattr(value, "ndim", 1) == 0 or len(value) != 3:
        raise InputError(f"{name} = {shown(value)}: expected three numbers")
    for axis, number in zip("xyz", value, strict=True):
        as_number(number, f"{name}, {axis}", negative=True)
