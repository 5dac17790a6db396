"""What all results have in common: arrays that nobody can change, and a repr of one line."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


class Result:
    """Base of frozen dataclasses that hold arrays; declare them with ``eq=False, repr=False``.

    Arrays are made read-only, also after pickling and copying. Two results are equal only if they
    are the same object: an array has no single truth value to compare by.

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
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                if value.flags.writeable:
                    value = value.view()
                    value.setflags(write=False)
                object.__setattr__(self, field.name, value)

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
            if (text := _described(field.name, getattr(self, field.name)))
        ]
        return f"{type(self).__name__}({', '.join(parts)})"


def _described(name: str, value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size <= 3 and value.ndim == 1 and value.dtype.kind == "f":
            numbers = ", ".join(f"{v:.4g}" for v in value)
            return f"{name}=[{numbers}]"
        return f"{name}[{' x '.join(map(str, value.shape))}]"
    if name == "warnings":
        return f"{len(value)} warning(s)" if value else ""
    if isinstance(value, list | tuple | dict) and len(value) > 4:
        return f"{name}: {len(value)}"
    if isinstance(value, float):
        return f"{name}={value:.6g}"
    return f"{name}={value!r}" if len(repr(value)) <= 80 else name
