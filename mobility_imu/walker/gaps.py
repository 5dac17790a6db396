"""Gaps that were filled with straight lines, in which the frame moves or may have moved."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect
from mobility_imu.faults import Fault
from mobility_imu.frames import as_flags
from mobility_imu.health import fault_of
from mobility_imu.recording import Imu, Recording
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.reach import BRIDGED_S, FRAME, MOSTLY, SHORTEST_MOVE_S, UNKNOWN, placed

__all__ = ["filled_samples", "gaps_in_moves", "is_of_a_gap", "without_samples"]

STRAIGHT = 1e-9
"""Readings are on a line if they are so near to it, as a fraction of the largest: a sum's rounding,
far below the last digit that any sensor gives."""
FEWEST_ON_LINE = 3
"""Samples on one line, one after the other, of all axes, that no sensor gives by itself."""


def filled_samples(recording: Recording) -> NDArray[np.bool_]:
    """Samples on straight lines of all axes: those of a filled gap.

    Parameters
    ----------
    recording : Recording with a sensor "frame"

    Returns
    -------
    (n,) bool array
    """
    expect("recording", recording, Recording)
    values = np.hstack([recording.sensor(FRAME).acc_mps2, recording.gyroscope(FRAME)])
    step = np.diff(values, axis=0)
    near = STRAIGHT * np.abs(values).max(axis=0)
    on_line = np.zeros(len(values), np.bool_)
    on_line[1:-1] = (np.abs(np.diff(step, axis=0)) <= near).all(axis=1)
    on_line[1:-1] &= (np.abs(step[1:]) > near).any(axis=1)
    return np.asarray(long_runs(on_line, FEWEST_ON_LINE, grow=False))


def is_of_a_gap(fault: Fault, filled: NDArray[np.bool_]) -> bool:
    """Whether what a fault touches was filled, most of each run: then the gap is what is wrong.

    A level line goes on where the readings beside it are the same.

    Parameters
    ----------
    fault : Fault
    filled : (n,) bool array, of :func:`filled_samples`

    Returns
    -------
    bool
    """
    return all(filled[run].mean() > MOSTLY for run in runs_of(fault.flags))


def without_samples(recording: Recording, flags: NDArray[np.bool_]) -> Recording:
    """Recording whose other samples follow each other as if nothing had been between them.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    flags : (n,) bool array, the samples that are left out

    Returns
    -------
    Recording of the sensor "frame"
    """
    expect("recording", recording, Recording)
    kept = ~as_flags(flags, "flags", length=len(recording))
    acc, gyr = recording.sensor(FRAME).acc_mps2[kept], recording.gyroscope(FRAME)[kept]
    return Recording(recording.time_s[: len(acc)], {FRAME: Imu(acc, gyr)}, source=recording.source)


def gaps_in_moves(
    recording: Recording, still: NDArray[np.bool_], filled: NDArray[np.bool_]
) -> Iterator[Fault]:
    """Filled gaps in which, or beside which, the frame moves, or that are as long as a move.

    Filled readings from rest to rest say that the frame stood, whatever it did.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    still : (m,) bool array, rests of its last samples
    filled : (n,) bool array, of :func:`filled_samples`

    Yields
    ------
    Fault
    """
    at_rest = placed(still, len(recording))
    flags = np.zeros(len(recording), np.bool_)
    longest = 0.0
    for run in runs_of(filled):
        seconds = (run.stop - run.start) / recording.sampling_rate_hz
        rests = at_rest[max(0, run.start - 1) : run.stop + 1].all()
        if seconds >= (SHORTEST_MOVE_S if rests else BRIDGED_S):
            flags[run], longest = True, max(longest, seconds)
    if flags.any():
        yield fault_of(
            recording, "gap", FRAME, flags,
            f"runs along straight lines for up to {longest:.2g} s: a gap that was filled, longer "
            f"than a line can bridge in a move ({BRIDGED_S:g} s), or so long that a whole step may "
            f"be missing ({SHORTEST_MOVE_S:.2g} s); cut the recording there, or record again"
            f"{UNKNOWN}",
            size=longest, unit="s",
        )  # fmt: skip
