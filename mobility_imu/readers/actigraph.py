"""ActiGraph's exports of raw samples: ten lines of head, then g and deg/s with a wall clock."""

from __future__ import annotations

import re
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.layout import comma_separated
from mobility_imu.readers.streams import LOCAL, Asked, Stream
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.wording import quoted

ACCELEROMETER = [f"Accelerometer {axis}" for axis in "XYZ"]
GYROSCOPE = [f"Gyroscope {axis}" for axis in "XYZ"]
HEAD_LINES = 10
"""Of ActiGraph's raw export; the names of the columns stand behind them."""
STAMP = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?")


def is_actigraph(names: str) -> bool:
    """Whether a file begins like ActiGraph's.

    Parameters
    ----------
    names : its first line

    Returns
    -------
    bool
    """
    return re.search("Data (Table )?File Created By ActiGraph", names) is not None


def read_actigraph(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The sensor of a file; its rate stands in the first line.

    Rows are evenly spaced by ActiGraph's software, so the clock is their number over the rate. If
    rows were taken out, repeated or exchanged, their stamps are the clock, which shows it.

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
        If a column is missing, or a cell is no number or no time.
    """
    lines = comma_separated(text).split("\n", HEAD_LINES)
    stated = re.search(r"\bat (\d+(?:\.\d+)?) Hz", lines[0])
    if len(lines) <= HEAD_LINES or stated is None:
        raise InputError(
            f"{source}: expected ten head lines, the first with 'at ... Hz'; for a table of counts "
            "per epoch: export the raw data from ActiLife"
        )
    rate = check_rate(float(stated[1]), source)
    table = parse_numbers(
        lines[HEAD_LINES], separator=",", source=source, first_line=HEAD_LINES + 1,
        wanted={*ACCELEROMETER, *GYROSCOPE}.__contains__,
    )  # fmt: skip
    gyr = (
        np.deg2rad(table.columns(GYROSCOPE, finite=True)) if GYROSCOPE[0] in table.header else None
    )
    time_s, epoch_s = np.arange(len(table)) / rate, _epoch(lines[:HEAD_LINES])
    stamps = _stamps(lines[HEAD_LINES], source)
    if len(stamps) == len(table):
        epoch_s = float((stamps[0] - np.datetime64("1970-01-01")) / np.timedelta64(1, "s"))
        passed_s = (stamps - stamps[0]) / np.timedelta64(1, "s")
        if np.abs(passed_s - time_s).max() > 0.5 / rate:
            time_s = passed_s
    return (
        Stream(
            time_s,
            table.columns(ACCELEROMETER, finite=True) * STANDARD_GRAVITY_MPS2,
            gyr,
            source=source,
            rate_from="the file's head",
            counted=True,
            epoch_s=epoch_s,
            epoch_in=LOCAL,
        ),
    )


def _stamps(table: str, source: str) -> NDArray[np.datetime64]:
    """Times of day of the rows; none if the first row has no such time."""
    lines = enumerate(table.split("\n")[1:], HEAD_LINES + 2)
    cells = {k: row.partition(",")[0].strip('" ') for k, row in lines if row.strip(' \r",')}
    if not STAMP.fullmatch(next(iter(cells.values()), "")):
        return np.empty(0, "datetime64[ns]")
    for line, cell in cells.items():
        if not STAMP.fullmatch(cell):
            raise InputError(
                f"{source}: line {line}, column Timestamp: '{quoted(cell)}' is no date and time"
            )
    try:
        return np.array(list(cells.values()), "datetime64[ns]")
    except ValueError as error:
        raise InputError(f"{source}: column Timestamp: {error}") from None


def _epoch(lines: list[str]) -> float | None:
    """Time of day, s, at which the recording starts; None if the head does not tell."""
    head = "\n".join(lines)
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


def _seconds(*at: int) -> float | None:
    """Seconds since 1970 of year, month, day, hour, minute, second on the wall; None if no date."""
    try:
        return datetime(*at, tzinfo=UTC).timestamp()  # type: ignore[misc,arg-type]
    except (ValueError, OverflowError):
        return None
