"""Runs of samples: where flags are set, and where codes stay the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def runs_of(flags: ArrayLike) -> list[slice]:
    """Give the runs of samples where a flag is set."""
    edge = np.diff(np.r_[0, np.asarray(flags, np.int8), 0])
    starts, stops = np.nonzero(edge == 1)[0], np.nonzero(edge == -1)[0]
    return [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]


def long_runs(flags: NDArray[np.bool_], shortest: int, *, grow: bool) -> NDArray[np.bool_]:
    """Keep only runs of at least ``shortest`` flags; ``grow`` adds the sample before each."""
    edge = np.diff(np.r_[0, flags.astype(np.int8), 0])
    starts, stops = np.nonzero(edge == 1)[0], np.nonzero(edge == -1)[0]
    long = stops - starts >= shortest
    out = np.zeros(len(flags) + 1, int)
    np.add.at(out, starts[long] - grow, 1)
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

    Examples
    --------
    >>> changes_of([1, 1, 2, 2, 1]).tolist()
    [0, 2, 4]
    """
    values = np.asarray(codes)
    if not len(values):
        return np.zeros(0, np.intp)
    return np.concatenate([[0], np.nonzero(values[1:] != values[:-1])[0] + 1])
