"""Work spread over processes or machines: anything with ``submit`` may do it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

Found = TypeVar("Found")


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

    Examples
    --------
    >>> run_all(pow, [(2, 3), (3, 2)])
    [8, 9]
    """
    if executor is None:
        return [function(*each) for each in arguments]
    futures = [executor.submit(function, *each) for each in arguments]
    try:
        return [future.result() for future in futures]
    finally:
        for future in futures:
            future.cancel()  # those that are done stay done
