"""What all results have in common: arrays that nobody can change, and a repr of one line."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from mobility_imu.errors import InputError

LONGEST_VALUE = 80
"""Characters of a field's value that a repr shows at most."""


def read_only(array: np.ndarray) -> np.ndarray:
    """Copy of an array that nobody can write to; an array that nobody can write to is returned.

    Parameters
    ----------
    array : array; a view counts as writeable if what it looks at can be written to

    Returns
    -------
    array of the same type and shape

    Raises
    ------
    InputError
        If it is no array.
    """
    if not isinstance(array, np.ndarray):
        raise InputError(f"array: got {type(array).__name__}, expected an array")
    held: Any = array
    while isinstance(held, np.ndarray) and not held.flags.writeable:
        held = held.base
    if held is None:
        return array
    array = array.copy()
    array.setflags(write=False)
    return array


class Result:
    """Base of frozen dataclasses that hold arrays; declare them with ``eq=False, repr=False``.

    Arrays are copied and made read-only, also those inside tuples, lists and dictionaries, so that
    no later change of an input reaches a result; pickles and copies are read-only too. Two results
    are equal only if they are the same object: an array has no single truth value to compare by.
    A subclass with a ``__post_init__`` of its own calls this one at its end.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True, eq=False, repr=False)
    ... class Speed(Result):
    ...     time_s: np.ndarray
    ...     speed_mps: np.ndarray
    ...     warnings: tuple[str, ...] = ()
    >>> Speed(np.arange(9.0), np.ones(9))
    Speed(time_s[9], speed_mps[9])
    """

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            object.__setattr__(self, field.name, _frozen(getattr(self, field.name)))

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore from a pickle or a copy: there arrays come back writeable."""
        for name, value in state.items():
            object.__setattr__(self, name, value)
        Result.__post_init__(self)

    def __repr__(self) -> str:
        """One line: small values as they are, arrays by their shape, warnings by their number."""
        parts = [
            text
            for field in dataclasses.fields(self)  # type: ignore[arg-type]
            if field.repr and (text := _described(field.name, getattr(self, field.name, None)))
        ]
        return f"{type(self).__name__}({', '.join(parts)})"


def _frozen(value: Any) -> Any:
    """Value with read-only arrays in it; containers are copied, and keep their types."""
    if isinstance(value, np.ndarray):
        return read_only(value)
    if isinstance(value, tuple) and hasattr(value, "_fields"):  # a NamedTuple
        return type(value)(*map(_frozen, value))
    if type(value) in (tuple, list):
        return type(value)(map(_frozen, value))
    if type(value) is dict:
        return {key: _frozen(part) for key, part in value.items()}
    return value


def _described(name: str, value: Any) -> str:
    if isinstance(value, np.ndarray):
        if 0 < value.size <= 3 and value.ndim == 1 and value.dtype.kind == "f":
            numbers = ", ".join(f"{v:.4g}" for v in value)
            return f"{name}=[{numbers}]"
        return f"{name}[{' x '.join(map(str, value.shape))}]"
    if name == "warnings":
        return f"{len(value)} warning(s)" if value else ""
    if isinstance(value, list | tuple | dict | set) and len(value) > 4:
        return f"{name}: {len(value)}"
    if isinstance(value, float):
        return f"{name}={value:.6g}"
    text = repr(value)
    if len(text) > LONGEST_VALUE or "\n" in text:
        return f"{name}: {type(value).__name__}"
    return f"{name}={text}"
