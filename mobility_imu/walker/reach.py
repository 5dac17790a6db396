"""What a path can do about a fault of a sensor: bridge it, or know nothing from there on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mobility_imu.faults import Fault, half_of, with_half
from mobility_imu.frames import FloatArray
from mobility_imu.health import samples_lost
from mobility_imu.quality import same_as_before
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.saturation import FARTHEST, bridged_rates
from mobility_imu.walker.stillness import StillnessSettings, stillness_signals

__all__ = [
    "BRIDGED_S",
    "BROKEN",
    "FRAME",
    "MOSTLY",
    "SHORTEST_MOVE_S",
    "UNKNOWN",
    "is_of_half",
    "placed",
    "rates_in_time",
    "samples_unknown",
    "with_reach",
]

FRAME = "frame"
BROKEN = frozenset({"frozen", "dead axis"})
"""Faults of readings that say nothing; what else is odd comes from them."""
BRIDGED_S = 0.3
"""A frozen half is bridged by a line if it is shorter: a third of a step."""
SHORTEST_MOVE_S = 3 * BRIDGED_S
"""No step hides in a rest that is lost for a shorter time: of 450 moves of 16 real walks the
shortest that goes on by 0.1 m takes 0.98 s."""
MOSTLY = 0.5
"""Part of the samples from which on they count as all: readings beside may be the same, and a few
others between. Our choice, not swept."""
MOST_CAPPED, MOST_CUT = 0.05, 0.1
"""Parts of the cut samples whose curve ends at twice the range, and of all samples that are cut, up
to which what was cut off counts as known. Our choice, not swept."""
UNKNOWN = "; what the path does there is not known, nor its place and heading from there on"


def rates_in_time(recording: Recording, told: Iterable[Fault]) -> FloatArray:
    """Rates without a lag that is told: a late gyroscope turns gravity at rest.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    told : Fault

    Returns
    -------
    (n, 3) array, rad/s
    """
    for fault in told:
        if fault.code == "lag" and fault.repair is not None:
            return fault.repair(recording).gyroscope(FRAME)
    return recording.gyroscope(FRAME)


def with_reach(fault: Fault, recording: Recording, stillness: StillnessSettings) -> Fault:
    """Fault as the path sees it: with the repair that a path can be found with, or with none.

    Parameters
    ----------
    fault : Fault of the frame, of :func:`mobility_imu.health.examine`
    recording : Recording
    stillness : StillnessSettings

    Returns
    -------
    Fault
        An axis that is dead throughout has no repair, and its sentence says so. A cut range is
        repaired by a curve over each cut, or has no repair if too much is cut. A frozen half, or an
        axis that is dead for some time, is bridged by a line if that is shorter than ``BRIDGED_S``
        and ends at readings, or the other half shows no motion meanwhile, or has no repair. For as
        long as a move, a half that repeats itself as well shows nothing.
        Faults of other kinds are as they were.
    """
    if fault.code == "dead axis" and fault.flags.all():
        return replace(fault, sentence=fault.sentence + UNKNOWN)
    if fault.code == "range":
        half = fault.sensor.removeprefix(f"{FRAME}_")
        _, known = _with_peaks(half_of(recording, FRAME, half), fault.flags)
        if known:
            return replace(fault, repair=partial(_peaks_back, half=half, flags=fault.flags))
        return replace(fault, sentence=fault.sentence + UNKNOWN, repair=None)
    if fault.code not in BROKEN:
        return fault
    imu, rate_hz = recording.sensor(FRAME), recording.sampling_rate_hz
    rates = recording.gyroscope(FRAME)
    turns, shakes = stillness_signals(
        imu.acc_mps2, rates - np.median(rates, axis=0), rate_hz, stillness
    )
    if is_of_half(fault, "gyr"):
        moves, same = shakes > stillness.acc_deviation_mps2, same_as_before(imu.acc_mps2)
    else:
        moves, same = turns > stillness.rate_radps, same_as_before(rates)
    for run in runs_of(fault.flags):
        seconds = (run.stop - run.start) / rate_hz
        at_an_end = run.start == 0 or run.stop == len(recording)
        bridged = seconds <= BRIDGED_S and not at_an_end and fault.repair is not None
        both = seconds >= SHORTEST_MOVE_S and same[run].mean() > MOSTLY
        if both or (moves[run].any() and not bridged):
            return replace(fault, sentence=fault.sentence + UNKNOWN, repair=None)
    return replace(fault, repair=fault.repair or _as_it_is)


def _as_it_is(recording: Recording) -> Recording:
    """Recording whose axis repeats its reading at one end of it, at rest: nothing is lost."""
    return recording


def _peaks_back(recording: Recording, half: str, flags: NDArray[np.bool_]) -> Recording:
    """Recording with a curve over each cut of one half."""
    undone, _ = _with_peaks(half_of(recording, FRAME, half), flags)
    return with_half(recording, FRAME, half, undone)


def _with_peaks(values: FloatArray, flags: NDArray[np.bool_]) -> tuple[FloatArray, bool]:
    """Readings with a curve over each cut, and whether the curves stay below twice the range.

    The spline goes on as the readings beside a cut rise and fall.
    """
    undone, known = np.array(values), True
    for k, axis in enumerate(values.T):
        limit = float(np.abs(axis[flags]).max(initial=0.0))
        cut = long_runs(flags & (np.abs(axis) == limit), 2, grow=False)
        if not cut.any():
            continue
        below = np.nextafter(limit, 0.0)
        bridged, _ = bridged_rates(
            np.where(cut, axis, np.clip(axis, -below, below))[:, None], below
        )
        undone[cut, k] = bridged[cut, 0]
        capped = np.abs(bridged[cut, 0]) >= (FARTHEST - 0.01) * limit
        known &= bool(capped.mean() < MOST_CAPPED and cut.mean() < MOST_CUT)
    return undone, known


def is_of_half(fault: Fault, half: str) -> bool:
    """Whether a fault is one of a half of the frame's sensor, or of an axis of that half.

    Parameters
    ----------
    fault : Fault, whose sensor is "frame", "frame_gyr" or "frame_gyr_x"
    half : "acc" or "gyr"

    Returns
    -------
    bool
    """
    return fault.sensor.removeprefix(f"{FRAME}_").split("_")[0] == half


def placed(flags: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """Flags of a recording from those of its last samples.

    Parameters
    ----------
    flags : (n,) bool array
    count : samples of the recording
    """
    return np.asarray(np.r_[np.zeros(count - len(flags), np.bool_), flags])


def samples_unknown(faults: Iterable[Fault], count: int) -> NDArray[np.bool_]:
    """Samples that tell nothing of other faults.

    A half or an axis says nothing there, the readings were filled in, or more is cut off at the end
    of a range than can be undone.

    Parameters
    ----------
    faults : Fault, as :func:`with_reach` gives them
    count : samples of the recording

    Returns
    -------
    (n,) bool array
    """
    faults = list(faults)
    unknown = samples_lost(faults, count)
    for fault in faults:
        if fault.code == "gap" or (fault.code == "range" and fault.repair is None):
            unknown |= fault.flags
    return unknown
