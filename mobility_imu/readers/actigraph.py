"""ActiGraph's exports of raw samples: ten lines of head, then g and deg/s with a wall clock."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.layout import comma_separated, split_row
from mobility_imu.readers.streams import LOCAL, Asked, Stream, contradicted, times_of_rows
from mobility_imu.readers.table import NumberTable, parse_numbers
from mobility_imu.readers.wording import quoted

ACCELEROMETER = [f"Accelerometer {axis}" for axis in "XYZ"]
GYROSCOPE = [f"Gyroscope {axis}" for axis in "XYZ"]
HEAD_LINES = 10
"""Of ActiGraph's raw export; the names of the columns stand behind them."""
TIME = r"(?P<hour>\d{1,2}):(?P<minute>\d\d):(?P<second>\d\d)(?:[.,](?P<part>\d+))?"
STAMPS = [
    re.compile(rf"(?P<y>\d{{4}})-(?P<M>\d\d)-(?P<d>\d\d){between}{TIME}", re.ASCII)
    for between in "T "
]
"""Dates and times as ActiLife writes them with the gyroscope's, whatever the head's date format."""
PARTS = {"y": r"(?P<y>\d{4}|\d{2})", "M": r"(?P<M>\d{1,2})", "d": r"(?P<d>\d{1,2})"}
"""Numbers of a date by the first letter of the head's date format."""
FIRST_YEAR, LAST_YEAR = 1970, 2199
"""Nanoseconds since 1970 have no room for later years than 2262."""
FINE_ENOUGH = 10
"""Steps of the stamps within one row, from which their rounding does not count. Set by hand."""
WHOLE = 1e-6
"""Steps of the stamps within one row are a whole number if they are as near to one."""
FINEST = 9
"""Digits of a second's fraction that are kept: nanoseconds."""


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
    rows were taken out, repeated or exchanged, their stamps are the clock, which shows it: in the
    head's date format, or as ActiLife writes them with the gyroscope's rows.

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
    clock = _clock(lines, rate, table, source)
    return (
        Stream(
            clock.time_s,
            table.columns(ACCELEROMETER, finite=True) * STANDARD_GRAVITY_MPS2,
            gyr,
            source=source,
            warnings=clock.warnings,
            rate_from=clock.rate_from,
            counted=True,
            epoch_s=clock.epoch_s,
            epoch_in=LOCAL,
        ),
    )


class _Clock(NamedTuple):
    """Times of the rows as a Stream takes them."""

    time_s: FloatArray
    epoch_s: float | None
    rate_from: str
    warnings: tuple[str, ...]


def _clock(lines: list[str], rate_hz: float, table: NumberTable, source: str) -> _Clock:
    """Number of the rows over the rate, or their stamps where these say otherwise."""
    head = "\n".join(lines[:HEAD_LINES])
    time_s, unseen = times_of_rows(len(table), rate_hz, source)
    epoch_s, rate_from = _epoch(head, source), "the file's head"
    stamps, digits = _stamps(lines[HEAD_LINES], _order(head), source)
    said: list[str] = []
    if len(stamps) == len(table):
        epoch_s = float((stamps[0] - np.datetime64("1970-01-01")) / np.timedelta64(1, "s"))
        passed_s = (stamps - stamps[0]) / np.timedelta64(1, "s")
        off_s = np.abs(passed_s - time_s)
        if _are_coarse(digits, rate_hz):
            said.append(_coarse(off_s, rate_hz, digits, source))
        elif off_s.max() > 0.5 / rate_hz:
            time_s, rate_from = passed_s, "its clock"
            said += contradicted(rate_hz, passed_s, "Timestamp", source)
    elif "Timestamp" in table.every:
        said.append(
            f"{source}: the times of column Timestamp are not in the head's date format, so that "
            "lost rows cannot be seen; the rows are counted at the rate of the head"
        )
    else:
        said.append(unseen)
    return _Clock(time_s, epoch_s, rate_from, tuple(said))


def _are_coarse(digits: int, rate_hz: float) -> bool:
    """Whether stamps with so many digits of a second do not tell a row from the next."""
    of_step = 10.0**digits / rate_hz
    return of_step < FINE_ENOUGH and abs(of_step - max(1, round(of_step))) > WHOLE


def _coarse(off_s: FloatArray, rate_hz: float, digits: int, source: str) -> str:
    """Sentence on stamps that are coarser than the rows; refused if they show that rows are lost.

    Rows that share a stamp have no times of their own, so that a loss has no exact length.
    """
    resolution_s = 10.0**-digits
    bad = off_s > resolution_s + 0.5 / rate_hz
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(
            f"{source}: row {k + 1} of the data: its Timestamp is {off_s[k]:.3g} s from its place "
            f"at {rate_hz:g} Hz; rows were lost, or repeat, before it. Export the stamps with "
            "milliseconds, or cut the recording there"
        )
    return (
        f"{source}: column Timestamp is in steps of {resolution_s:g} s, so that shorter losses "
        "cannot be seen; the rows are counted at the rate of the head"
    )


def _stamps(table: str, order: tuple[str, ...], source: str) -> tuple[NDArray[np.datetime64], int]:
    """Times of day of the rows, and digits of their fractions; none if the first row has none."""
    names, _, rows = table.partition("\n")
    column = [name.strip() for name in split_row(names, ",")]
    if "Timestamp" not in column:
        return np.empty(0, "datetime64[ns]"), 0
    k = column.index("Timestamp")
    lines = enumerate(rows.split("\n"), HEAD_LINES + 2)
    cells = {n: (row.split(",", k + 1) + [""] * k)[k].strip('" \r')
             for n, row in lines if row.strip(' \r",')}  # fmt: skip
    first = next(iter(cells.values()), "")
    patterns = [*STAMPS, *_of_head(first, order)]
    pattern = next((p for p in patterns if _iso(p.fullmatch(first)) is not None), None)
    if pattern is None:
        return np.empty(0, "datetime64[ns]"), 0
    found, digits = [], 0
    for line, cell in cells.items():
        match = pattern.fullmatch(cell)
        stamp = _iso(match)
        if match is None or stamp is None:
            raise InputError(
                f"{source}: line {line}, column Timestamp: '{quoted(cell)}' is no date and time "
                "as in the first row"
            )
        digits = max(digits, len(match["part"] or ""))
        found.append(stamp)
    return np.array(found, "datetime64[ns]"), digits


def _of_head(first: str, order: tuple[str, ...]) -> list[re.Pattern[str]]:
    """Pattern of dates in the head's order, with 12 hours where the first row has them."""
    if not order:
        return []
    half = r" ?(?P<half>[AaPp])\.?[Mm]\.?" if re.search(r"[AaPp]\.?[Mm]\.?$", first) else ""
    return [re.compile(r"[/.\- ]".join(PARTS[letter] for letter in order) + f"[T ]{TIME}{half}",
                       re.ASCII)]  # fmt: skip


def _iso(match: re.Match[str] | None) -> str | None:
    """Date and time as numpy reads it; None for no match, and for numbers that no date has."""
    if match is None:
        return None
    found = match.groupdict()
    hour = _hour(found["y"], found["M"], found["d"], found["hour"], found.get("half"))
    if hour is None or found["minute"] > "59" or found["second"] > "59":
        return None
    return f"{hour}:{found['minute']}:{found['second']}.{(found['part'] or '0')[:FINEST]}"


@lru_cache(maxsize=64)
def _hour(y: str, month: str, day: str, hour: str, half: str | None) -> str | None:
    """Date and hour as numpy reads them, found once for all rows of an hour."""
    year, of_day = int(y) + (2000 if len(y) == 2 else 0), int(hour)
    if half:
        if not 1 <= of_day <= 12:
            return None
        of_day = of_day % 12 + (12 if half in "Pp" else 0)
    if not FIRST_YEAR <= year <= LAST_YEAR:
        return None
    if _seconds(year, int(month), int(day), of_day, 0, 0) is None:
        return None
    return f"{year:04d}-{int(month):02d}-{int(day):02d}T{of_day:02d}"


def _order(head: str) -> tuple[str, ...]:
    """Order of year, month and day that the head states, as "M", "d", "y"; empty without."""
    found = re.search(r"date format ([Mdy]+)\W([Mdy]+)\W([Mdy]+)", head)
    letters = tuple(word[0] for word in found.groups()) if found else ()
    return letters if set(letters) == set(PARTS) else ()


def _epoch(head: str, source: str) -> float | None:
    """Time of day, s, at which the recording starts; None if the head does not tell."""
    date = re.search(r"^Start Date (\d+)\D(\d+)\D(\d+)", head, re.MULTILINE | re.ASCII)
    time = re.search(r"^Start Time (\d+):(\d+):(\d+)", head, re.MULTILINE | re.ASCII)
    order = _order(head)
    if date is None or time is None or not order:
        return None
    part = dict(zip(order, date.groups(), strict=True))
    numbers = [part["y"], part["M"], part["d"], *time.groups()]
    # Python turns no text of thousands of digits into a number.
    if any(len(number) > len("2020") for number in numbers):
        raise InputError(
            f"{source}: '{quoted(date[0])}' and '{quoted(time[0])}' of the head are no date and "
            "time; correct them"
        )
    return _seconds(*map(int, numbers))


def _seconds(*at: int) -> float | None:
    """Seconds since 1970 of year, month, day, hour, minute, second on the wall; None if no date."""
    try:
        return datetime(*at, tzinfo=UTC).timestamp()  # type: ignore[misc,arg-type]
    except (ValueError, OverflowError):
        return None
