"""LP-Research's LpmsControl: one line of names with units, several sensors by ``SensorId``.

Its accelerometers read −1 g on the axis that points up. A specific force is +1 g there, so the
signs are reversed here. Its gyroscopes are right-handed.
"""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream, factor
from mobility_imu.readers.table import NumberTable, parse_numbers


def is_lpms(names: str) -> bool:
    """Whether a line of names is LpmsControl's.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return bool(re.match(r'\s*"?SensorId\b', names)) and "TimeStamp" in names


def read_lpms(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """One stream for each SensorId, in the order of the numbers.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the file states clock and units

    Returns
    -------
    tuple of Stream

    Raises
    ------
    InputError
        If a column is missing, its unit is not known, or a cell is no number.
    """
    table = parse_numbers(
        text,
        source=source,
        wanted=lambda name: re.match(r"SensorId|TimeS|Acc|Gyro", name) is not None,
    )
    ids = table.columns(["SensorId"], finite=True)[:, 0]
    time_s = _time(table)
    acc, gyr = (
        _vectors(table, word, quantity) for word, quantity in (("Acc", "acc"), ("Gyro", "gyr"))
    )
    said = f"{source}: signs of the accelerations reversed (LPMS reads -1 g on the axis that is up)"
    streams: list[Stream] = []
    for number in np.unique(ids):
        rows = ids == number
        streams.append(
            Stream(
                time_s[rows], -acc[rows], gyr[rows], source=source, label=f"{number:g}",
                warnings=(said,) if not streams else (),
            )
        )  # fmt: skip
    return tuple(streams)


def _time(table: NumberTable) -> FloatArray:
    for name in table.header:
        match = re.fullmatch(r"TimeStamp\s*\((.*)\)", name)
        if match:
            scale = TIME_UNITS.get(match[1].strip())
            if scale is None:
                raise InputError(
                    f"{table.source}: time in '{match[1]}', expected {', '.join(TIME_UNITS)}"
                )
            return table.columns([name], finite=True)[:, 0] * scale
    raise InputError(f"{table.source}: no column TimeStamp (s) (it has: {table.listed()})")


def _vectors(table: NumberTable, word: str, quantity: str) -> FloatArray:
    columns = []
    for axis in "XYZ":
        names = [n for n in table.header if re.fullmatch(rf"{word}{axis}\s*\(.*\)", n)]
        if len(names) != 1:
            raise InputError(
                f"{table.source}: no column {word}{axis} with its unit (it has: {table.listed()})"
            )
        unit = names[0].partition("(")[2].rstrip(") ")
        columns.append(
            table.columns(names, finite=True)[:, 0] * factor(quantity, unit, table.source)
        )
    return np.column_stack(columns)
