"""Loops compiled by numba if it is there; without it they run as the Python that they are.

Compiling takes seconds, which nobody should wait for unasked. Where a readable form of a loop
exists, :func:`choose` says which of the two to run.

Environment variables: ``MOBILITY_IMU_NO_NUMBA=1`` acts as if numba were not installed;
``MOBILITY_IMU_COMPILE=always`` compiles at the first call, ``never`` uses only machine code that is
there already. Studies that must give the same bytes in every process set one of them.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping
from typing import Any, Literal, TypeVar, cast

try:
    if os.environ.get("MOBILITY_IMU_NO_NUMBA", "0") not in ("", "0"):
        raise ImportError("MOBILITY_IMU_NO_NUMBA is set")
    import numba
except ImportError:  # an extra: everything runs without it, some things slowly
    numba = None  # type: ignore[assignment]

HAVE_NUMBA = numba is not None
"""Whether loops are compiled."""
PATIENCE_S = 5.0
"""Seconds of plain Python after which a process compiles rather than go on so."""

Function = TypeVar("Function", bound=Callable[..., Any])
_log = logging.getLogger("mobility_imu")
_spent_s: dict[Any, float] = {}


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


def machine_code_ready(function: Callable[..., Any], *arguments: Any) -> bool:
    """Whether a compiled function can run at once: its machine code is in memory or on the disk.

    Numba has no public question for this. Of a dispatcher it is used that ``overloads`` holds what
    is in memory, and of its cache the index of the file; where a numba has these no more, the
    answer is no, and the loop is compiled when it is worth it.

    Parameters
    ----------
    function : made by :func:`compiled`
    *arguments : of the call; their types choose the machine code

    Returns
    -------
    bool
    """
    dispatcher: Any = function
    typeof: Callable[[Any], Any] = getattr(numba, "typeof", type)
    if numba is None or not hasattr(dispatcher, "overloads"):
        return False
    types = tuple(typeof(argument) for argument in arguments)
    if types in dispatcher.overloads:
        return True
    try:
        cache, context = dispatcher._cache, dispatcher.targetctx
        context.refresh()
        name = cache._cache_file._load_index().get(cache._index_key(types, context.codegen()))
        return name is not None and os.path.exists(cache._cache_file._data_path(name))
    except Exception:  # a damaged index, or another numba
        return False


def choose(
    functions: Mapping[Callable[..., Any], tuple[Any, ...]], *, plain_s: float, what: str
) -> Literal["compiled", "plain"]:
    """Whether to run loops compiled, or their plain form.

    Compiled, if the machine code is there. If not: plain, until the plain form has taken this
    process longer than ``PATIENCE_S``; then compiling is worth its time, and a line of the log
    ``mobility_imu`` says so before it begins.

    Parameters
    ----------
    functions : compiled functions with the arguments of the coming call
    plain_s : s, about how long the plain form will take
    what : name of the work, for the log

    Returns
    -------
    "compiled" or "plain"
    """
    wish = os.environ.get("MOBILITY_IMU_COMPILE", "")
    if numba is None:
        return "plain"
    if not all(hasattr(function, "overloads") for function in functions):  # NUMBA_DISABLE_JIT
        return "compiled" if wish == "always" else "plain"
    if all(machine_code_ready(function, *given) for function, given in functions.items()):
        return "compiled"
    if wish == "never":
        return "plain"
    if wish != "always":
        _spent_s[what] = _spent_s.get(what, 0.0) + plain_s
        if _spent_s[what] <= PATIENCE_S:
            return "plain"
        _log.info("compiling the %s for this computer, some 10 s; later runs start at once", what)
    return "compiled"
