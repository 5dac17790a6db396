"""Table of the times at which a device is known to rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import as_clock
from mobility_imu.readers.flags import flag_column, with_flags
from mobility_imu.readers.layout import check_names
from mobility_imu.readers.table import line_of, read_text

__all__ = ["read_rests"]

COLUMNS = ["time_s", "stationary"]
LARGEST_COVER = 100.0
"""Times that of the recording that a table may last: a minute of a recording of an hour and a half.
Times in ms are 1,000. Set by hand."""
_SAME_TIME = 0.1
"""Fraction of the recording's interval within which a row belongs to a sample: more than the
rounding of a written time, less than half a sample. Set by hand."""


def read_rests(path: str | Path, time_s: ArrayLike) -> NDArray[np.bool_]:
    """Whether each sample of a recording is at rest, from a CSV table with time_s and stationary.

    The table may be denser or sparser than the recording: a sample between two rows rests if both
    say so. Other columns are ignored, so that a corrected path.csv serves.

    Parameters
    ----------
    path : CSV with the columns time_s, on the recording's clock, and stationary, 0 or 1
        (or a word such as TRUE)
    time_s : (n,) array, s, the recording's clock

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If a column is missing, a cell is neither 0 nor 1 nor such a word, the times do not
        increase, do not cover the recording or last far longer, or there is no rest at all.
    """
    clock = as_clock(time_s)
    time, stationary = COLUMNS
    table = with_flags(
        read_text(path),
        source=str(path),
        wanted=lambda name: name.lower() == time,
        flags=lambda name: name.lower() == stationary,
    )
    check_names([name for name in table.every if name.lower() in COLUMNS], str(path))
    names = [name.lower() for name in table.every]
    times = table.columns(COLUMNS if stationary not in names else [time])[:, 0]
    flags = flag_column(table, names.index(stationary))
    if len(table) < 2:
        raise InputError(f"{path}: {len(table)} row(s), expected one for each sample")
    if np.isnan(flags).any():
        line = line_of(table.text, int(np.argmax(np.isnan(flags))))
        raise InputError(f"{path}: line {line}, column stationary: is empty, expected 1 or 0")
    table.check_finite([[name.lower() for name in table.header].index(time)])
    later = np.diff(times) > 0
    if not later.all():
        line = line_of(table.text, int(np.argmin(later)) + 1)
        raise InputError(f"{path}: line {line}: time_s does not increase from the row before")
    interval = float(np.median(np.diff(clock)))
    if clock[0] < times[0] - interval or clock[-1] > times[-1] + interval:
        raise InputError(
            f"{path}: time_s from {times[0]:g} to {times[-1]:g} s, but the recording lasts from "
            f"{clock[0]:g} to {clock[-1]:g} s: expected a row for each of its samples, on its clock"
        )
    after = np.clip(np.searchsorted(times, clock), 1, len(times) - 1)
    before = after - 1
    if times[-1] - times[0] > LARGEST_COVER * (clock[-1] - clock[0] + interval):
        raise InputError(
            f"{path}: {times[-1] - times[0]:g} s, but the recording lasts {clock[-1] - clock[0]:g} "
            "s; are its times in s?"
        )
    rests = (flags[before] > 0) & (flags[after] > 0)
    for row in (before, after):
        same = np.abs(times[row] - clock) <= _SAME_TIME * interval
        rests[same] = flags[row[same]] > 0
    if not rests.any():
        raise InputError(f"{path}: stationary is 0 throughout, expected the rests of the recording")
    return np.asarray(rests)
