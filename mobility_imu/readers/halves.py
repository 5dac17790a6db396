"""Accelerations and rates that a logger writes into two files, each with its own stamps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
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
    acc: Half, gyr: Half | None, source: str, *, label: str = "", warnings: tuple[str, ...] = ()
) -> Stream:
    """One stream of both; rates are interpolated to the accelerations' stamps.

    Parameters
    ----------
    acc : accelerations, m/s²
    gyr : rates, rad/s, or None
    source : names both, for messages
    label : what the files call the sensor
    warnings : of the reader

    Returns
    -------
    Stream, from the later start to the earlier end

    Raises
    ------
    InputError
        If the two share no time.
    """
    if gyr is None:
        return Stream(acc.time_s, acc.values, None, source=source, label=label, warnings=warnings)
    if len(acc.time_s) == len(gyr.time_s) and np.array_equal(acc.time_s, gyr.time_s):
        return Stream(
            acc.time_s, acc.values, gyr.values, source=source, label=label, warnings=warnings
        )
    stamps, first = np.unique(gyr.time_s, return_index=True)
    values = gyr.values[first]
    inside = (acc.time_s >= stamps[0]) & (acc.time_s <= stamps[-1])
    if inside.sum() < 2:
        raise InputError(
            f"{source}: accelerations ({acc.time_s[0]:.3f} to {acc.time_s[-1]:.3f} s) and rates "
            f"({stamps[0]:.3f} to {stamps[-1]:.3f} s) share no time"
        )
    time_s = acc.time_s[inside]
    rates = np.column_stack([np.interp(time_s, stamps, axis) for axis in values.T])
    said = f"{source}: rates interpolated to the accelerations' stamps"
    return Stream(
        time_s, acc.values[inside], rates, source=source, label=label, warnings=(*warnings, said)
    )
