"""ActiGraph's exports of raw samples: ten lines of head, then g and deg/s with a wall clock."""

from __future__ import annotations

import re
from datetime import UTC, datetime

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.layout import comma_separated
from mobility_imu.readers.streams import LOCAL, Asked, Stream
from mobility_imu.readers.table import parse_numbers

ACCELEROMETER = [f"Accelerometer {axis}" for axis in "XYZ"]
GYROSCOPE = [f"Gyroscope {axis}" for axis in "XYZ"]
HEAD_LINES = 10
"""Of ActiGraph's raw export; the names of the columns stand behind them."""


def is_actigraph(names: str) -> bool:
    """Whether a file begins like ActiGraph's.

    Parameters
    ----------
    names : its first line

    Returns
    -------
    bool
    """
    return "Data File Created By ActiGraph" in names


def read_actigraph(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The sensor of a file; its rate stands in the first line.

    Rows are evenly spaced by ActiGraph's software, so the clock is their number over the rate.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If a column is missing, or a cell is no number.
    """
    lines = comma_separated(text).split("\n", HEAD_LINES)
    stated = re.search(r"\bat (\d+(?:\.\d+)?) Hz", lines[0])
    if len(lines) <= HEAD_LINES or stated is None:
        raise InputError(f"{source}: an ActiGraph file states 'at ... Hz' and has ten head lines")
    rate = check_rate(float(stated[1]), source)
    table = parse_numbers(
        lines[HEAD_LINES], separator=",", source=source, first_line=HEAD_LINES + 1,
        wanted={*ACCELEROMETER, *GYROSCOPE}.__contains__,
    )  # fmt: skip
    gyr = (
        np.deg2rad(table.columns(GYROSCOPE, finite=True)) if GYROSCOPE[0] in table.header else None
    )
    return (
        Stream(
            np.arange(len(table)) / rate,
            table.columns(ACCELEROMETER, finite=True) * STANDARD_GRAVITY_MPS2,
            gyr,
            source=source,
            rate_from="the file's head",
            counted=True,
            epoch_s=_epoch(lines),
            epoch_in=LOCAL,
        ),
    )


def _epoch(lines: list[str]) -> float | None:
    """Time of day, s, of the first sample; None if neither it nor the head tells."""
    stamp = re.match(r"(\d{4})-(\d\d)-(\d\d)T(\d\d):(\d\d):(\d\d)(\.\d+)?", _first_row(lines[-1]))
    if stamp is not None:
        whole = _seconds(*map(int, stamp.groups()[:6]))
        return None if whole is None else whole + float(stamp[7] or 0)
    head = "\n".join(lines[:-1])
    date = re.search(r"^Start Date (\d+)\D(\d+)\D(\d+)", head, re.MULTILINE)
    time = re.search(r"^Start Time (\d+):(\d+):(\d+)", head, re.MULTILINE)
    order = re.search(r"date format ([Mdy]+)\W([Mdy]+)\W([Mdy]+)", head)
    if date is None or time is None or order is None:
        return None
    part = {letters[0]: int(number) for letters, number in zip(order.groups(), date.groups(),
                                                               strict=True)}  # fmt: skip
    if set(part) != {"y", "M", "d"}:
        return None
    return _seconds(part["y"], part["M"], part["d"], *map(int, time.groups()))


def _first_row(table: str) -> str:
    """First row of a table below its names."""
    return table.partition("\n")[2].partition("\n")[0].lstrip('" ')


def _seconds(*at: int) -> float | None:
    """Seconds since 1970 of year, month, day, hour, minute, second on the wall; None if no date."""
    try:
        return datetime(*at, tzinfo=UTC).timestamp()  # type: ignore[misc,arg-type]
    except ValueError:
        return None
