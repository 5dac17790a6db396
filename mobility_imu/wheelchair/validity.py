"""Tasks where the velocities are not valid: which frames they reach, and how that is told."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.frames import FloatArray, as_count, as_flags
from mobility_imu.runs import runs_of, some_flags

__all__ = ["known_tasks", "on_unknown"]

MOST_TIMES = 3
"""Spans of time that a warning lists."""


def known_tasks(known: ArrayLike, segment: int) -> NDArray[np.bool_]:
    """Frames whose task rests on known velocities only: all windows that vote for it hold no other.

    Parameters
    ----------
    known : (n,) array of truth values, whether each frame's velocities are known
    segment : frames in a window

    Returns
    -------
    (n,) bool array

    Examples
    --------
    >>> known_tasks([1, 1, 1, 0, 1, 1, 1], 2).tolist()
    [True, True, False, False, False, True, True]
    """
    flags = some_flags(known, "known")
    segment = min(as_count(segment, "segment"), len(flags))
    total = np.r_[0, np.cumsum(~flags)]
    index, last = np.arange(len(flags)), len(flags)
    unknown = total[np.minimum(index + segment, last)] - total[np.maximum(index - segment + 1, 0)]
    return np.asarray(unknown == 0)


def on_unknown(time_s: FloatArray, known: NDArray[np.bool_]) -> tuple[str, ...]:
    """Sentence on velocities that are not valid, and so on tasks that are not known.

    Parameters
    ----------
    time_s : (n,) array, s
    known : (n,) bool array, whether each frame's velocities are valid

    Returns
    -------
    tuple of str, empty if all are
    """
    known = as_flags(known, "known", length=len(time_s))
    runs = runs_of(~known)
    if not runs:
        return ()
    step = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    spans = [f"{time_s[run.start]:.2f} to {time_s[run.stop - 1]:.2f} s" for run in runs]
    more = [f"{len(spans) - MOST_TIMES} more"] if len(spans) > MOST_TIMES else []
    return (
        f"the velocities are not valid for {step * int((~known).sum()):.1f} of "
        f"{step * len(known):.1f} s ({', '.join([*spans[:MOST_TIMES], *more])}): the tasks named "
        "there and within a segment of there are not known (valid = 0); leave them out",
    )
