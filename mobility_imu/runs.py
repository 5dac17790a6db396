"""Runs of samples: where flags are set, and where codes stay the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import as_count, as_flags, one_of

FEWEST_VALUES = 20
"""An axis that never changes is dead if another one of its sensor takes more values than this."""


def runs_of(flags: ArrayLike) -> list[slice]:
    """Runs of samples where a flag is set.

    Parameters
    ----------
    flags : (n,) array of truth values, or of 0 and 1

    Returns
    -------
    list of slice, in the order of time

    Raises
    ------
    InputError
        If the flags are no series of truth values.

    Examples
    --------
    >>> runs_of([0, 1, 1, 0, 1])
    [slice(1, 3, None), slice(4, 5, None)]
    """
    starts, stops = _edges(some_flags(flags))
    return [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]


def long_runs(flags: ArrayLike, shortest: int, *, grow: bool) -> NDArray[np.bool_]:
    """Flags of which only the runs of some length are kept.

    Parameters
    ----------
    flags : (n,) array of truth values, or of 0 and 1
    shortest : samples in the shortest run that is kept
    grow : whether the sample before each run is added to it

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If the flags are no series of truth values, or ``shortest`` is no whole number.

    Examples
    --------
    >>> long_runs([0, 1, 1, 0, 1], 2, grow=True).tolist()
    [True, True, True, False, False]
    """
    flags = some_flags(flags)
    starts, stops = _edges(flags)
    long = stops - starts >= as_count(shortest, "shortest", least=0)
    one_of("grow", grow, (True, False))
    if not long.any():
        return np.zeros(len(flags), np.bool_)
    out = np.zeros(len(flags) + 1, int)
    np.add.at(out, np.maximum(starts[long] - grow, 0), 1)
    np.add.at(out, stops[long], -1)
    return np.cumsum(out[:-1]) > 0


def changes_of(codes: ArrayLike) -> NDArray[np.intp]:
    """First sample of each run of equal codes.

    Parameters
    ----------
    codes : (n,) array

    Returns
    -------
    (k,) array of int; empty for no samples

    Raises
    ------
    InputError
        If the codes are no series.

    Examples
    --------
    >>> changes_of([1, 1, 2, 2, 1]).tolist()
    [0, 2, 4]
    """
    try:
        values = np.asarray(codes)
    except ValueError:
        raise InputError("codes: expected one code per sample") from None
    if values.ndim != 1:
        raise InputError(f"codes: expected one code per sample, got shape {values.shape}")
    if not len(values):
        return np.zeros(0, np.intp)
    return np.concatenate([[0], np.nonzero(values[1:] != values[:-1])[0] + 1])


def some_flags(flags: ArrayLike, name: str = "flags") -> NDArray[np.bool_]:
    """Check that an array has flags of samples, however many.

    Parameters
    ----------
    flags : (n,) array of truth values, or of 0 and 1
    name : what to call it in the error message

    Returns
    -------
    (n,) bool array, a copy

    Raises
    ------
    InputError
        If they are no series of truth values, or of 0 and 1.
    """
    try:
        length = np.size(flags)
    except ValueError:  # rows of several lengths
        length = 0
    return as_flags(flags, name, length=length)


def _edges(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where runs start, and where they stop."""
    within = np.zeros(len(flags) + 2, np.bool_)
    within[1:-1] = flags
    edges = np.flatnonzero(within[1:] != within[:-1])
    return edges[::2], edges[1::2]
