"""Accelerations and rates that a logger writes into two files, each with its own stamps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
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


def join_halves(
    acc: Half,
    gyr: Half | None,
    source: str,
    *,
    warnings: tuple[str, ...] = (),
    epoch_s: float | None = None,
    gap_why: str = "",
) -> Stream:
    """One stream of both; rates are interpolated to the accelerations' stamps.

    Accelerations within a gap of the rates are left out, so that the stream has the gap.

    Parameters
    ----------
    acc : accelerations, m/s²
    gyr : rates, rad/s, or None
    source : names both, for messages
    warnings : of the reader
    epoch_s, gap_why : as in :class:`~mobility_imu.readers.streams.Stream`

    Returns
    -------
    Stream, from the later start to the earlier end

    Raises
    ------
    InputError
        If the two share no time, or the rates' clock jumps back.
    """
    if gyr is None or np.array_equal(acc.time_s, gyr.time_s):
        rates = None if gyr is None else gyr.values
        return Stream(
            acc.time_s, acc.values, rates, source=source, warnings=warnings, epoch_s=epoch_s,
            gap_why=gap_why,
        )  # fmt: skip
    for half in (acc, gyr):
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
    said = [f"{source}: rates interpolated to the accelerations' stamps"]
    said += ends_left_out(ends, source)
    step = np.diff(stamps)
    longest = longest_silent_gap(float(np.median(step)))
    lost = losses(stamps) | (step > longest)
    if lost.any():
        k = int(np.argmax(np.where(lost, step, 0.0)))
        found = (
            f"{int(lost.sum())} gap(s) in the rates, the longest of {step[k]:.3g} s after "
            f"{stamps[k] - stamps[0]:.2f} s"
        )
        # Accelerations in a long one make way, so that both have it.
        after = np.clip(np.searchsorted(stamps, acc.time_s, side="right") - 1, 0, len(step) - 1)
        inside &= ~((step[after] > longest) & (acc.time_s > stamps[after]))
        gap_why = gap_why or f"{found} ({gyr.source})"
        said.append(f"{gyr.source}: {found}")
    time_s = acc.time_s[inside]
    rates = np.column_stack([np.interp(time_s, stamps, axis) for axis in values.T])
    return Stream(
        time_s, acc.values[inside], rates, source=source, warnings=(*warnings, *said),
        epoch_s=epoch_s, gap_why=gap_why,
    )  # fmt: skip
