"""Check of the fields of results, which a script may make itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from mobility_imu.arguments import check_shape, expect
from mobility_imu.errors import InputError
from mobility_imu.frames import as_count, as_flags, as_floats, as_series, one_of, shown

__all__ = ["check_fields"]


def check_fields(result: Any, **kinds: Any) -> None:
    """Check fields of a result, and make them what they should be; ``warnings`` too if it has some.

    Parameters
    ----------
    result : frozen dataclass, in its ``__post_init__``
    **kinds : name of a field to what it has to be: ``float`` (a number, or NaN), ``int`` (0 or
        more), ``bool``, another class, the shape of an array as a tuple of whole numbers, a list
        of one class (a tuple of its objects) and a length if that is known, or a list of ``bool``
        or ``int`` and a length (an array of that many flags or whole numbers)

    Raises
    ------
    InputError
        If a field is something else; the message names class and field.
    """
    if hasattr(result, "warnings"):
        kinds = {**kinds, "warnings": [str]}
    for name, kind in kinds.items():
        label, value = f"{type(result).__name__}.{name}", getattr(result, name)
        if isinstance(kind, tuple):
            check_shape(result, name, kind)
        elif isinstance(kind, list):
            several = {bool: _flags, int: _wholes}.get(kind[0], _objects)
            object.__setattr__(result, name, several(label, value, *kind))
        elif kind in (float, int, bool):
            one = {float: _number, int: _count, bool: _truth}[kind]
            object.__setattr__(result, name, one(label, value))
        else:
            expect(label, value, kind)


def _flags(label: str, value: Any, _: type, length: int) -> Any:
    return as_flags(value, label, length=length)


def _wholes(label: str, value: Any, _: type, length: int) -> Any:
    numbers = as_series(value, label, length=length)
    if (numbers != np.round(numbers)).any() or (np.abs(numbers) > 2**53).any():
        raise InputError(f"{label}: expected whole numbers")
    return numbers.astype(np.int64)


def _objects(label: str, value: Any, kind: type, length: int | None = None) -> tuple[Any, ...]:
    if kind is str and isinstance(value, np.ndarray) and value.ndim == 1:
        value = value.tolist()
    if not isinstance(value, list | tuple) or length not in (None, len(value)):
        many = "" if length is None else f"{length} "
        raise InputError(f"{label}: got {shown(value)}, expected a tuple of {many}{kind.__name__}")
    for number, one in enumerate(value):
        expect(f"{label}[{number}]", one, kind)
    return tuple(map(str, value)) if kind is str else tuple(value)


def _number(label: str, value: Any) -> float:
    number = as_floats(value, label)
    if number.shape != ():
        raise InputError(f"{label} = {shown(value)}: expected one number")
    return float(number)


def _count(label: str, value: Any) -> int:
    return as_count(value, label, least=0)


def _truth(label: str, value: Any) -> bool:
    return bool(one_of(label, value, (True, False)))
