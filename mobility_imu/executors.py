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
    function : callable; for another process it has to be picklable, as its arguments and results
    arguments : one tuple of arguments per call
    executor : anything with ``submit`` (``ProcessPoolExecutor``, ``Client.get_executor()`` of Dask,
        ``MPIPoolExecutor``); None computes here, one call after the other

    Returns
    -------
    list

    Examples
    --------
    >>> run_all(pow, [(2, 3), (3, 2)])
    [8, 9]
    """
    if executor is None:
        return [function(*each) for each in arguments]
    return [future.result() for future in [executor.submit(function, *each) for each in arguments]]
