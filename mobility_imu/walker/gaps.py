"""Gaps that were filled with straight lines, and lie in a move."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from mobility_imu.faults import Fault
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.reach import BRIDGED_S, FRAME, UNKNOWN, placed
from mobility_imu.walker.rest_checks import LONGEST_MOVE_S, Readings

__all__ = ["filled_samples", "gaps_in_moves", "without_gaps"]

STRAIGHT = 1e-9
"""Readings are on a line if they are so near to it, as a fraction of the largest: a sum's rounding,
far below the last digit that any sensor gives."""


def filled_samples(recording: Recording, shortest_s: float = BRIDGED_S) -> NDArray[np.bool_]:
    """Samples on straight lines of all axes, longer than some time: those of a filled gap.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    shortest_s : s

    Returns
    -------
    (n,) bool array
    """
    values = np.hstack([recording.sensor(FRAME).acc_mps2, recording.gyroscope(FRAME)])
    step = np.diff(values, axis=0)
    near = STRAIGHT * np.abs(values).max(axis=0)
    on_line = np.zeros(len(values), np.bool_)
    on_line[1:-1] = (np.abs(np.diff(step, axis=0)) <= near).all(axis=1)
    on_line[1:-1] &= (np.abs(step[1:]) > near).any(axis=1)
    count = max(3, round(shortest_s * recording.sampling_rate_hz))
    return np.asarray(long_runs(on_line, count, grow=False))


def gaps_in_moves(recording: Recording, still: NDArray[np.bool_]) -> Iterator[Fault]:
    """Filled gaps in which, or beside which, the frame moves.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    still : (m,) bool array, rests of its last samples

    Yields
    ------
    Fault
    """
    filled = filled_samples(recording)
    at_rest = placed(still, len(recording))
    flags = np.zeros(len(recording), np.bool_)
    longest = 0
    for run in runs_of(filled):
        if not at_rest[max(0, run.start - 1) : run.stop + 1].all():
            flags[run], longest = True, max(longest, run.stop - run.start)
    if flags.any():
        seconds = longest / recording.sampling_rate_hz
        yield fault_of(
            recording, "gap", FRAME, flags,
            f"runs along straight lines for up to {seconds:.2g} s: a gap that was filled, too long "
            f"for a frame that moves (up to {BRIDGED_S:g} s); cut the recording there, or record "
            f"again{UNKNOWN}", size=seconds, unit="s",
        )  # fmt: skip


def without_gaps(readings: Readings, gap: NDArray[np.bool_]) -> Readings:
    """Readings in which the rests beside a gap do not count, so that no move ends at it.

    Parameters
    ----------
    readings : Readings
    gap : (n,) bool array of a recording whose last samples the readings are

    Returns
    -------
    Readings
    """
    far = round(LONGEST_MOVE_S / 2 * readings.rate_hz) + 1
    still = readings.still.copy()
    for run in runs_of(gap[-len(still) :]):
        still[max(0, run.start - far) : run.stop + far] = False
    return readings._replace(still=still)
