"""AndroSensor's tables, and loggers that borrowed its names: units in the header, a wall clock."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.layout import comma_separated, from_names, split_row
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream, factor
from mobility_imu.readers.table import line_of
from mobility_imu.readers.wording import listed, quoted

ELAPSED = "Time since start in ms"
WALL = "YYYY-MO-DD HH-MI-SS_SSS"
SENSORS = ("ACCELEROMETER", "GYROSCOPE")
ZONE = r"(?: ?Z| ?[+-]\d\d:?\d\d)?"
WALL_PART, WALL_S = 0.05, 0.1
"""Elapsed time and wall clock agree to this part and this time: far less than the factor of 1,000
between the units, more than a phone's clock is set right by on the way. Set by hand."""


def is_androsensor(names: str) -> bool:
    """Whether a line of names is AndroSensor's.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return ELAPSED in names and "ACCELEROMETER X" in names


def read_androsensor(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """Stream on the wall clock, in s since midnight of the day on which it begins.

    The elapsed time runs evenly but from a start of its own; the wall clock is coarse. The median
    of their difference joins them. Some loggers write seconds under the name of milliseconds:
    the wall clock tells which unit it is.

    Parameters
    ----------
    text : content of the file; LINEAR ACCELERATION (gravity taken out) is not used
    source : the file's name, for messages
    asked : not used, for the names state the units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If a column is missing, a cell is no number or no date, or the two clocks do not agree.
    """
    import pandas as pd

    plain = comma_separated(from_names(text))
    _check_once([name.strip() for name in split_row(plain.partition("\n")[0], ",")], source)
    try:
        table = _table(plain)
    except (ValueError, pd.errors.ParserError) as error:
        raise InputError(f"{source}: cannot be read as a table ({quoted(str(error))})") from None
    if not len(table):
        raise InputError(f"{source}: a header, but no rows of data")
    table.columns = [str(name).strip() for name in table.columns]
    line = partial(line_of, text)
    wall = _seconds_of_day(_column(table, WALL, source), source, line)
    elapsed = _numbers(_column(table, ELAPSED, source), ELAPSED, source, line)
    elapsed *= _unit_of_elapsed(elapsed, wall, source)
    accelerometer, gyroscope = SENSORS
    acc = _vectors(table, accelerometer, "acc", source, line)
    turns = any(name.startswith("GYRO") for name in table.columns)  # some phones have none
    gyr = _vectors(table, gyroscope, "gyr", source, line) if turns else None
    time_s = elapsed + np.median(wall - elapsed)
    return (Stream(time_s, acc, gyr, source=source),)


def _table(text: str) -> Any:
    """Table whose words stay words: pandas takes a column of TRUE and FALSE for truth values."""
    import pandas as pd

    read = partial(pd.read_csv, index_col=False, low_memory=False)
    table = read(io.StringIO(text))
    words = {name: str for name, dtype in table.dtypes.items() if dtype.kind == "b"}
    return read(io.StringIO(text), dtype=words) if words else table


def _check_once(names: list[str], source: str) -> None:
    """Check that no column that is read is there twice; pandas would give the second a new name."""
    axes = [f"{sensor} {axis} (" for sensor in SENSORS for axis in "XYZ"]
    for wanted in (ELAPSED, WALL, *axes):
        found = [n for n in names if n == wanted or (wanted in axes and n.startswith(wanted))]
        if len(found) > 1:
            raise InputError(
                f"{source}: column {wanted.rstrip(' (')} is there twice ({listed(found)}); remove "
                "the one that is wrong"
            )


def _vectors(
    table: Any, sensor: str, quantity: str, source: str, line: Callable[[int], int]
) -> FloatArray:
    """Readings in m/s² or rad/s, by the unit in the names: ``(m/s²)``, also written ``(m/s^2)``."""
    columns = []
    for axis in "XYZ":
        name = next((n for n in table.columns if n.startswith(f"{sensor} {axis} (")), None)
        if name is None:
            names = listed(list(table.columns))
            raise InputError(f"{source}: no column {sensor} {axis} (it has: {names})")
        unit = name.partition("(")[2].rstrip(") ")
        columns.append(_numbers(table[name], name, source, line) * factor(quantity, unit, source))
    return np.column_stack(columns)


def _column(table: Any, name: str, source: str) -> Any:
    if name not in table:
        raise InputError(f"{source}: no column {name} (it has: {listed(list(table.columns))})")
    return table[name]


def _numbers(column: Any, name: str, source: str, line: Callable[[int], int]) -> FloatArray:
    import pandas as pd

    values = np.array(pd.to_numeric(column, errors="coerce"), float)
    if not np.isfinite(values).all():
        k = int(np.argmin(np.isfinite(values)))
        raise InputError(
            f"{source}: line {line(k)}, column {name}: "
            f"'{quoted(_cell(column, k))}' is not a finite number"
        )
    return values


def _cell(column: Any, row: int) -> str:
    """A cell as the file has it; an empty one is NaN to pandas."""
    cell = column.iloc[row]
    return "" if cell != cell else str(cell)


def _seconds_of_day(column: Any, source: str, line: Callable[[int], int]) -> FloatArray:
    """Wall clock in s since the first row's midnight; the last separator may be a colon.

    Stamps may tell their distance to UTC, which changes where summer time begins or ends.
    """
    import pandas as pd

    dates = column.astype(str).str.replace(rf"[:_.](\d{{3}})(?={ZONE}$)", r".\1", regex=True)
    parsed = pd.to_datetime(dates, errors="coerce", utc=True)
    if parsed.isna().any():
        k = int(np.argmax(parsed.isna()))
        raise InputError(
            f"{source}: line {line(k)}: '{quoted(_cell(column, k))}' is no date and time"
        )
    midnight = pd.to_datetime(dates.iloc[:1]).iloc[0].normalize()  # where the phone was
    if midnight.tzinfo is None:
        midnight = midnight.tz_localize("UTC")
    return np.array((parsed - midnight).dt.total_seconds(), float)


def _unit_of_elapsed(elapsed: FloatArray, wall: FloatArray, source: str) -> float:
    """Seconds of one unit of the elapsed time: 1 or 0.001."""
    span, real = np.ptp(elapsed), np.ptp(wall)
    for unit in (TIME_UNITS["s"], TIME_UNITS["ms"]):
        if abs(span * unit - real) <= WALL_PART * real + WALL_S:
            return unit
    raise InputError(
        f"{source}: {quoted(re.sub(' in ms', '', ELAPSED))} runs over {span:g} (ms or s), the wall "
        f"clock over {real:g} s"
    )
