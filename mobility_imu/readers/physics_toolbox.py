"""The app Physics Toolbox, multi record: ``time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz``; g, rad/s, s.

By a setting of the app the time is that of the day, as in ``19:00:25:0160``.
"""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.readers.layout import find_layout
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import line_of, parse_numbers
from mobility_imu.readers.wording import quoted

FORCE = [f"gF{axis}" for axis in "xyz"]
RATE = [f"w{axis}" for axis in "xyz"]
LONGEST_START_S = 1.0
"""A gyroscope reports within this. One that reads zero for longer rests, on a phone that corrects
its offset and cuts small rates off."""
OF_DAY = re.compile(r'(\s*"?)(\d{1,2}):(\d\d):(\d\d)[:.,](\d{3,4})(?=["\s;,\t])')
"""A time of day at the beginning of a row; the last group is the fraction of a second."""
DAY_S = 86_400.0
OF_IPHONE = "gFTotal"
"""A column that the app has on an iPhone, where no public file tells the sign of gravity."""


def is_physics_toolbox(names: str) -> bool:
    """Whether a line of names is Physics Toolbox'.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return names.startswith("time") and "gFx" in names


def read_physics_toolbox(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The phone of a file; rows before both sensors report are left out.

    A sensor that has not reported yet reads zero. So does a gyroscope at rest on some phones:
    zeros that last longer than :data:`LONGEST_START_S` are kept, with a warning.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the app documents its units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If a column is missing or a cell is no number.
    """
    of_day, text = _times_of_day(text, source)
    table = parse_numbers(text, source=source, wanted={"time", *FORCE, *RATE}.__contains__)
    acc = table.columns(FORCE, finite=True) * STANDARD_GRAVITY_MPS2
    gyr = table.columns(RATE, finite=True) if RATE[0] in table.header else None
    time_s = table.columns(["time"], finite=True)[:, 0] if of_day is None else of_day
    begin = _first(acc, "accelerometer", source)
    said = []
    if OF_IPHONE in table.every:
        said.append(
            f"{source}: has the column {OF_IPHONE} of an iPhone, whose accelerations may have the "
            "other sign: with the phone face up, gFz must be +1; if it is -1, read it by a map"
        )
    if gyr is not None:
        turns = max(begin, _first(gyr, "gyroscope", source))
        silent_s = float(time_s[turns] - time_s[begin])
        if silent_s <= LONGEST_START_S:
            begin = turns
        else:
            said.append(
                f"{source}: the gyroscope reads exactly zero in the first {silent_s:.3g} s, taken "
                "for a rest; cut them off if the phone moved"
            )
    if begin:
        said.append(f"{source}: {begin} row(s) of zeros at the beginning left out")
    return (
        Stream(
            time_s[begin:], acc[begin:], None if gyr is None else gyr[begin:], source=source,
            warnings=tuple(said),
        ),
    )  # fmt: skip


def _times_of_day(text: str, source: str) -> tuple[FloatArray | None, str]:
    """Times of day in s, which go on after midnight, and the table with 0 in their place.

    Without times of day: None, and the table as it is.
    """
    layout = find_layout(text, source)
    if not OF_DAY.match(layout.body.lstrip("\r\n")):
        return None, text
    parts: list[list[float]] = []
    plain = []
    for row in layout.body.split("\n"):
        found = OF_DAY.match(row)
        if not row.strip():
            plain.append(row)
            continue
        if found is None:
            line, cell = line_of(text, len(parts)), row.partition(layout.separator)[0]
            raise InputError(
                f"{source}: line {line}, column time: '{quoted(cell)}' is no time of day as in the "
                "first row"
            )
        parts.append([float(found[group]) for group in range(2, 6)] + [len(found[5])])
        plain.append(f"{found[1]}0{row[found.end() :]}")
    hours, minutes, seconds, fraction, digits = np.array(parts).T
    # Four digits are tenths of a millisecond, or milliseconds behind a zero.
    if len(set(digits)) > 1 or (digits[0] == 4 and fraction.max() < 1000):
        raise InputError(
            f"{source}: column time: the fractions of the seconds are not told from milliseconds; "
            "record with elapsed time in Physics Toolbox"
        )
    of_day = 3600 * hours + 60 * minutes + seconds + fraction / 10 ** digits[0]
    midnights = np.cumsum(np.diff(of_day, prepend=of_day[:1]) < -DAY_S / 2)
    names = layout.separator.join(layout.names)
    above = "\n" * (layout.line - 1)
    return of_day + DAY_S * midnights, f"{above}{names}\n" + "\n".join(plain)


def _first(values: FloatArray, sensor: str, source: str) -> int:
    """First row in which a sensor reports."""
    there = values.any(axis=1)
    if not there.any():
        raise InputError(f"{source}: the {sensor} reads zero throughout")
    return int(np.argmax(there))
