"""Check of names that come in a list."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from mobility_imu.errors import InputError
from mobility_imu.frames import check_switches, shown

__all__ = ["as_names"]


def as_names(names: Any, name: str, *, ordered: bool = False) -> tuple[str, ...]:
    """Check that names come in a list: one text would be taken for its letters.

    Parameters
    ----------
    names : names in any collection
    name : what to call them in the error message
    ordered : whether their order counts, so that a set of them is refused

    Returns
    -------
    tuple of str

    Raises
    ------
    InputError
        If they are something else, or one of them is no text or empty.

    Examples
    --------
    >>> as_names("frame", "expected")
    Traceback (most recent call last):
    mobility_imu.errors.InputError: expected: got 'frame', expected a list of names
    """
    check_switches(ordered=ordered)
    wrong = (str, bytes, set, frozenset) if ordered else (str, bytes)
    try:
        if isinstance(names, wrong) or not isinstance(names, Iterable):
            raise TypeError
        found = tuple(names)
    except TypeError:  # an array of no dimension is iterable by its class only
        raise InputError(f"{name}: got {shown(names)}, expected a list of names") from None
    for one in found:
        if not isinstance(one, str) or not one:
            raise InputError(f"{name}: {shown(one)} among them, expected names as text")
    return found
