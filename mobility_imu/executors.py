"""Work spread over processes or machines: anything with ``submit`` may do it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from mobility_imu.errors import InputError
from mobility_imu.frames import shown

Found = TypeVar("Found")


def check_executor(executor: Any) -> None:
    """Check that something can take work: an object with ``submit``, or None.

    Parameters
    ----------
    executor : what was given

    Raises
    ------
    InputError
        If it is something else, such as the class of an executor.
    """
    if executor is None:
        return
    if isinstance(executor, type) or not callable(getattr(executor, "submit", None)):
        raise InputError(
            f"executor = {shown(executor)}: expected an object with submit, such as a "
            "ProcessPoolExecutor, or None"
        )


def run_all(
    function: Callable[..., Found], arguments: Iterable[tuple[Any, ...]], executor: Any = None
) -> list[Found]:
    """Results of a function for several sets of arguments, in their order.

    Parameters
    ----------
    function : callable; for another process it has to be picklable, as its arguments and results.
        ``functools.partial`` gives it settings by name.
    arguments : one tuple of arguments per call
    executor : anything with ``submit`` (``ProcessPoolExecutor``, ``Client.get_executor()`` of Dask,
        ``MPIPoolExecutor``); None computes here, one call after the other

    Returns
    -------
    list
        The same for every executor. If a call raises, so does this; calls that wait are cancelled.

    Raises
    ------
    InputError
        If the executor is none, the function cannot be called, or the arguments are no tuples.

    Examples
    --------
    >>> run_all(pow, [(2, 3), (3, 2)])
    [8, 9]
    """
    check_executor(executor)
    if not callable(function):
        raise InputError(f"function = {shown(function)}: expected a function")
    calls = _calls(arguments)
    if executor is None:
        return [function(*each) for each in calls]
    futures = [executor.submit(function, *each) for each in calls]
    try:
        return [future.result() for future in futures]
    finally:
        for future in futures:
            future.cancel()  # those that are done stay done


def _calls(arguments: Any) -> Iterator[tuple[Any, ...]]:
    """Arguments of each call, one after the other: they may be long, and made on the way."""
    try:
        given = iter(arguments)
    except TypeError:
        raise InputError(f"arguments: got {shown(arguments)}, expected a list of tuples") from None
    for each in given:
        if not isinstance(each, tuple | list):
            raise InputError(f"arguments: {shown(each)} among them, expected a tuple for each call")
        yield tuple(each)
