"""Accelerations and rates that a logger writes into two files, each with its own stamps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.blocks import check_stamps
from mobility_imu.readers.clocks import (
    check_forward,
    ends_left_out,
    longest_silent_gap,
    losses,
)
from mobility_imu.readers.streams import Stream


class Half(NamedTuple):
    """One quantity of a sensor on its own clock.

    Parameters
    ----------
    time_s : (n,) array, s
    values : (n, 3) array, m/s² or rad/s
    source : the file's name, for messages
    """

    time_s: FloatArray
    values: FloatArray
    source: str


class Pause(NamedTuple):
    """A time in which the logger itself wrote nothing.

    Parameters
    ----------
    begin_s : s, on the clock of the samples, which goes on meanwhile
    length_s : s
    why : where it is told
    """

    begin_s: float
    length_s: float
    why: str


def join_halves(
    acc: Half,
    gyr: Half | None,
    source: str,
    *,
    warnings: tuple[str, ...] = (),
    epoch_s: float | None = None,
    pauses: Sequence[Pause] = (),
) -> Stream:
    """One stream of both; rates are interpolated to the accelerations' stamps.

    Accelerations within a gap of the rates are left out, so that the stream has the gap.

    Parameters
    ----------
    acc : accelerations, m/s²
    gyr : rates, rad/s, or None
    source : names both, for messages
    warnings : of the reader
    epoch_s : as in :class:`~mobility_imu.readers.streams.Stream`
    pauses : of the logger; they are no losses of the rates

    Returns
    -------
    Stream, from the later start to the earlier end

    Raises
    ------
    InputError
        If the two share no time, a clock jumps back, or rows share a stamp.
    """
    if gyr is None or np.array_equal(acc.time_s, gyr.time_s):
        rates = None if gyr is None else gyr.values
        return Stream(
            acc.time_s, acc.values, rates, source=source, warnings=warnings, epoch_s=epoch_s,
            gap_why=_reasons(acc.time_s, pauses),
        )  # fmt: skip
    for half in (acc, gyr):
        check_stamps(half.time_s, half.values, half.source)
        check_forward(half.time_s, half.source)
    stamps, first = np.unique(gyr.time_s, return_index=True)
    values = gyr.values[first]
    inside = (acc.time_s >= stamps[0]) & (acc.time_s <= stamps[-1])
    if inside.sum() < 2:
        raise InputError(
            f"{source}: accelerations ({acc.time_s[0]:.3f} to {acc.time_s[-1]:.3f} s) and rates "
            f"({stamps[0]:.3f} to {stamps[-1]:.3f} s) share no time"
        )
    ends = {
        name: np.array([times.min(), times.max()])
        for name, times in (("accelerations", acc.time_s), ("rates", stamps))
    }
    makes_way, gaps, told = _gaps(acc.time_s, stamps, pauses, gyr.source)
    said = [
        f"{source}: rates interpolated to the accelerations' stamps",
        *ends_left_out(ends, source),
        *told,
    ]
    inside &= ~makes_way
    time_s = acc.time_s[inside]
    rates = np.column_stack([np.interp(time_s, stamps, axis) for axis in values.T])
    return Stream(
        time_s, acc.values[inside], rates, source=source, warnings=(*warnings, *said),
        epoch_s=epoch_s, gap_why=_reasons(time_s, [*pauses, *gaps]),
    )  # fmt: skip


def _gaps(
    acc_time_s: FloatArray, stamps: FloatArray, pauses: Sequence[Pause], source: str
) -> tuple[NDArray[np.bool_], list[Pause], list[str]]:
    """Gaps of the rates.

    Returns
    -------
    (n,) bool array : accelerations within a long gap, which make way, so that both have it
    list of Pause : the gaps that made some make way, as reasons
    list of str : a warning, or none
    """
    step = np.diff(stamps)
    longest = longest_silent_gap(float(np.median(step)))
    own = step - _paused(stamps, pauses)
    lost = losses(np.cumsum(np.r_[0.0, own])) | (own > longest)
    told = []
    if lost.any():
        k = int(np.argmax(np.where(lost, own, 0.0)))
        told.append(
            f"{source}: {int(lost.sum())} gap(s) in the rates, the longest of {own[k]:.3g} s "
            f"after {stamps[k] - stamps[0]:.2f} s"
        )
    inside = (acc_time_s >= stamps[0]) & (acc_time_s <= stamps[-1])
    after = np.clip(np.searchsorted(stamps, acc_time_s, side="right") - 1, 0, len(step) - 1)
    makes_way = inside & (step[after] > longest) & (acc_time_s > stamps[after])
    gaps = [
        Pause(
            np.nextafter(stamps[k], np.inf),
            own[k],
            f"gap of {own[k]:.3g} s in the rates ({source})",
        )
        for k in np.unique(after[makes_way])
        if own[k] > longest
    ]
    return makes_way, gaps, told


def _paused(stamps: FloatArray, pauses: Sequence[Pause]) -> FloatArray:
    """How long the logger paused in each step between stamps, s."""
    paused = np.zeros(len(stamps) - 1)
    for pause in pauses:
        k = int(np.searchsorted(stamps, pause.begin_s)) - 1
        if 0 <= k < len(paused):
            paused[k] += pause.length_s
    return paused


def _reasons(time_s: FloatArray, pauses: Sequence[Pause]) -> dict[int, str]:
    """Why there is a gap after a sample, by the sample's number."""
    found: dict[int, list[str]] = {}
    for pause in pauses:
        before = np.where(time_s < pause.begin_s, time_s, -np.inf)
        if np.isfinite(before).any():
            found.setdefault(int(np.argmax(before)), []).append(pause.why)
    return {k: " and ".join(why) for k, why in found.items()}
