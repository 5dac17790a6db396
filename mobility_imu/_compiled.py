"""Loops compiled by numba if it is there; without it they run as the Python that they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

try:
    import numba
except ImportError:  # an extra: everything runs without it, some things slowly
    numba = None  # type: ignore[assignment]

HAVE_NUMBA = numba is not None
"""Whether loops are compiled."""

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with ``numba.njit``, and keep the machine code if it can be kept.

    An installation that nobody may write to, without a home that could hold the code, has no place
    for it: there the function is compiled anew in each process.

    Parameters
    ----------
    **options : for ``numba.njit``

    Returns
    -------
    decorator
    """

    def decorate(function: Function) -> Function:
        if numba is None:
            return function
        try:
            return cast(Function, numba.njit(cache=True, **options)(function))
        except RuntimeError:  # "cannot cache function: no locator available"
            return cast(Function, numba.njit(**options)(function))

    return decorate
