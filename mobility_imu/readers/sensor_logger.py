"""The app Sensor Logger (Android, iOS): a folder with one file per quantity, columns ``z,y,x``.

``Accelerometer.csv`` holds no gravity. Android writes the specific force into
``TotalAcceleration.csv``; iOS reads it with the opposite sign, as the sum of ``Accelerometer.csv``
and ``Gravity.csv``. With the setting "Standardise Units & Frames" (from version 1.29), iOS writes
signs and units of Android; ``Metadata.csv`` states it as ``standardisation``. The
export as JSON is one file with the rows of all quantities and of the metadata.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers.halves import Half, join_halves
from mobility_imu.readers.json_samples import json_number
from mobility_imu.readers.json_text import load_recording
from mobility_imu.readers.layout import find_layout, split_row
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.wording import listed, quoted

ELAPSED, EPOCH_NS = "seconds_elapsed", "time"
COLUMNS = (EPOCH_NS, ELAPSED, "z", "y", "x")
STANDARDISED = "Standardise Units & Frames"
EXACT_S = 0.01
"""To this the time of day and the seconds of all rows of a file agree, if no digits were lost: half
a sample of a phone at 50 Hz. A spreadsheet that writes 1.71512E+18 ns loses minutes."""
LONGEST_BEFORE_S = 10.0
"""Readings from longer before the start are left over in the phone; the app writes them, as zeros,
with their times of days ago. Its documentation knows some from just before the start, too."""
RAW_RATES = "GyroscopeUncalibrated"
"""Read where Gyroscope.csv is missing or empty."""
USED = (
    "TotalAcceleration", "Accelerometer", "AccelerometerUncalibrated", "Gravity", "Gyroscope",
    RAW_RATES,
)  # fmt: skip


def is_sensor_logger(names: str) -> bool:
    """Whether a line of names is one of Sensor Logger's.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return ELAPSED in names


def read_sensor_logger_file(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The phone of an export as JSON. A table does not say what it holds: its folder is asked for.

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
        For a table, with the way to go on; for JSON as :func:`read_sensor_logger`.
    """
    if text.lstrip().startswith("["):
        return read_sensor_logger(_tables(text, source), source, asked)
    raise InputError(
        f"{source}: one file of Sensor Logger, which does not say which quantity it holds; give "
        "the folder of the recording, with Metadata.csv beside it"
    )


def _tables(text: str, source: str) -> dict[str, str]:
    """Rows of an export as JSON, as the tables of an export as CSV."""
    records = load_recording(text, source)
    rows: dict[str, list[list[object]]] = {}
    for k, record in enumerate(records):
        if not isinstance(record, dict):
            raise InputError(f"{source}: record {k} is no object with sensor, time, x, y, z")
        sensor = str(record.get("sensor"))
        if sensor == "Metadata":
            told = {name: value for name, value in record.items() if isinstance(value, str)}
            rows[sensor] = [list(told), list(told.values())]
        if sensor not in USED:
            continue
        for name in COLUMNS:
            try:
                json_number(record.get(name))
            except ValueError:
                raise InputError(
                    f"{source}: record {k} ({sensor}): {name} is "
                    f"{quoted(repr(record.get(name)))}, expected a number"
                ) from None
        rows.setdefault(sensor, [[*COLUMNS]]).append([record[name] for name in COLUMNS])
    if "Metadata" not in rows:
        raise InputError(
            f"{source}: no record of Metadata, which states the platform: Android and iOS have "
            "opposite signs; export the recording as .zip"
        )
    return {sensor: _as_csv(table) for sensor, table in rows.items()}


def _as_csv(rows: list[list[object]]) -> str:
    file = io.StringIO()
    csv.writer(file, lineterminator="\n").writerows(rows)
    return file.getvalue()


def read_sensor_logger(files: Mapping[str, str], source: str, asked: Asked) -> tuple[Stream, ...]:
    """The phone of one recording.

    Parameters
    ----------
    files : name of a file without its ending ("Gyroscope") to its content
    source : the folder's name, for messages
    asked : not used, for the files state their clock and the app documents its units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If the platform is not stated, or no file holds accelerations with gravity.
    """
    platform, like_android = _platform(files, source)
    read = [n for n in USED if n in files and (n != RAW_RATES or "Gyroscope" not in files)]
    halves, stale = {}, 0
    for name in read:
        half = _half(files[name], f"{source}/{name}.csv")
        fresh = half.time_s >= -LONGEST_BEFORE_S
        fresh |= not fresh.any()
        stale += int((~fresh).sum())
        halves[name] = half._replace(time_s=half.time_s[fresh], values=half.values[fresh])
    acc = _with_gravity(halves, platform, like_android, source)
    said: tuple[str, ...] = ()
    if stale:
        said = (f"{source}: {stale} reading(s) from long before the start left out",)
    if not like_android:
        said += (f"{source}: signs of the accelerations reversed (iOS reads -1 g upward)",)
        acc = acc._replace(values=-acc.values)
    elif platform == "ios":
        said += (
            f"{source}: signs of the accelerations kept: iOS with {STANDARDISED} has Android's",
        )
    rates = halves.get("Gyroscope")
    if rates is None and RAW_RATES in halves:
        rates = halves[RAW_RATES]
        said += (f"{source}: rates of {RAW_RATES}.csv, whose offsets are not taken off",)
    begun = next(_epoch(files[name]) for name in read)
    return (join_halves(acc, rates, source, warnings=said, epoch_s=begun),)


def _with_gravity(
    halves: Mapping[str, Half], platform: str, like_android: bool, source: str
) -> Half:
    """Accelerations with gravity, in m/s², with the sign of the platform."""
    summed = {"Accelerometer", "Gravity"} <= set(halves)
    if "TotalAcceleration" in halves:
        return halves["TotalAcceleration"]
    if "AccelerometerUncalibrated" in halves and not (summed and platform == "ios"):
        acc = halves["AccelerometerUncalibrated"]
        scale = 1.0 if like_android else STANDARD_GRAVITY_MPS2
        return acc._replace(values=acc.values * scale)
    if not summed:
        raise InputError(
            f"{source}: no accelerations with gravity; record TotalAcceleration (Android), or "
            "Accelerometer and Gravity (iOS), in Sensor Logger"
        )
    moved, gravity = halves["Accelerometer"], halves["Gravity"]
    if not np.array_equal(moved.time_s, gravity.time_s):
        raise InputError(f"{source}: Accelerometer.csv and Gravity.csv have different times")
    return moved._replace(values=moved.values + gravity.values)


def _platform(files: Mapping[str, str], source: str) -> tuple[str, bool]:
    """Platform, and whether signs and units are Android's."""
    if "Metadata" not in files:
        raise InputError(
            f"{source}: no Metadata.csv, which states the platform: Android and iOS have opposite "
            "signs; add it, or write one of two lines, 'platform' and below it 'android' or 'ios'"
        )
    names, _, row = files["Metadata"].strip().partition("\n")
    mark = max(",;", key=names.count)
    columns = split_row(names.strip(), mark)
    twice = [n for n in ("platform", "standardisation") if columns.count(n) > 1]
    if twice:
        raise InputError(
            f"{source}/Metadata.csv: column {twice[0]} is there twice; remove the one that is wrong"
        )
    told = dict(zip(columns, split_row(row.strip(), mark), strict=False))
    platform = told.get("platform", "").lower()
    if platform not in ("android", "ios"):
        raise InputError(
            f"{source}/Metadata.csv: platform '{quoted(platform)}', expected android or ios"
        )
    standardised = told.get("standardisation", "").strip().lower()
    if standardised not in ("", "false", "true"):
        raise InputError(
            f"{source}/Metadata.csv: standardisation '{quoted(standardised)}', expected true or "
            "false"
        )
    return platform, platform == "android" or standardised == "true"


def _epoch(text: str) -> float | None:
    """Time of day, s, at which the seconds of a file begin; None if it is not told exactly."""
    layout = find_layout(text, "")
    if any(layout.names.count(name) != 1 for name in (EPOCH_NS, ELAPSED)):
        return None
    begins = []
    for row in (layout.body.lstrip().partition("\n")[0], layout.body.rstrip().rpartition("\n")[2]):
        cells = [cell.replace(",", ".") for cell in split_row(row, layout.separator)]
        cells = cells[layout.indexed :]
        try:
            now, elapsed = (float(cells[layout.names.index(n)]) for n in (EPOCH_NS, ELAPSED))
        except (ValueError, IndexError):
            return None
        begins.append(TIME_UNITS["ns"] * now - elapsed)
    # A spreadsheet keeps fifteen digits, or fewer.
    return begins[0] if abs(begins[1] - begins[0]) < EXACT_S else None


def _half(text: str, source: str) -> Half:
    names = find_layout(text, source).names
    columns = []
    for axis in "xyz":
        found = [n for n in names if re.fullmatch(rf"(?:\w*?)[_ ]?{axis}", n, re.IGNORECASE)]
        if len(found) > 1:
            raise InputError(
                f"{source}: column {axis} is there twice ({listed(found)}); remove the one that is "
                "wrong"
            )
        if not found:
            raise InputError(f"{source}: no column {axis} (it has: {listed(names)})")
        columns.append(found[0])
    table = parse_numbers(text, source=source, wanted={ELAPSED, *columns}.__contains__)
    time_s = table.columns([ELAPSED], finite=True)[:, 0]
    return Half(time_s, table.columns(columns, finite=True), source)
