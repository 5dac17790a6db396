"""The app Sensor Logger (Android, iOS): a folder with one file per quantity, columns ``z,y,x``.

``Accelerometer.csv`` holds no gravity. Android writes the specific force into
``TotalAcceleration.csv``; iOS reads it with the opposite sign, as the sum of ``Accelerometer.csv``
and ``Gravity.csv``. With the setting "Standardise Units & Frames" (from version 1.29), iOS writes
signs and units of Android; ``Metadata.csv`` states it as ``standardisation``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers.halves import Half, join_halves
from mobility_imu.readers.layout import find_layout, split_row
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.wording import listed, quoted

ELAPSED, EPOCH_NS = "seconds_elapsed", "time"
STANDARDISED = "Standardise Units & Frames"
EXACT_S = 0.01
"""To this the time of day and the seconds of all rows of a file agree, if no digits were lost: half
a sample of a phone at 50 Hz. A spreadsheet that writes 1.71512E+18 ns loses minutes."""
USED = ("TotalAcceleration", "Accelerometer", "AccelerometerUncalibrated", "Gravity", "Gyroscope")


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
    """One file by itself: it does not say what it holds, so that its folder is asked for.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used

    Raises
    ------
    InputError
        Always, with the way to go on.
    """
    raise InputError(
        f"{source}: one file of Sensor Logger, which does not say which quantity it holds; give "
        "the folder of the recording, with Metadata.csv beside it"
    )


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
    halves = {name: _half(files[name], f"{source}/{name}.csv") for name in USED if name in files}
    if "TotalAcceleration" in halves:
        acc = halves["TotalAcceleration"]
    elif platform == "ios" and {"Accelerometer", "Gravity"} <= set(halves):
        moved, gravity = halves["Accelerometer"], halves["Gravity"]
        if not np.array_equal(moved.time_s, gravity.time_s):
            raise InputError(f"{source}: Accelerometer.csv and Gravity.csv have different times")
        acc = Half(moved.time_s, moved.values + gravity.values, moved.source)
    elif "AccelerometerUncalibrated" in halves:
        acc = halves["AccelerometerUncalibrated"]
        if not like_android:
            acc = acc._replace(values=acc.values * STANDARD_GRAVITY_MPS2)
    else:
        raise InputError(
            f"{source}: no accelerations with gravity; record TotalAcceleration (Android), or "
            "Accelerometer and Gravity (iOS), in Sensor Logger"
        )
    said: tuple[str, ...] = ()
    if not like_android:
        said = (f"{source}: signs of the accelerations reversed (iOS reads -1 g upward)",)
        acc = acc._replace(values=-acc.values)
    elif platform == "ios":
        said = (
            f"{source}: signs of the accelerations kept: iOS with {STANDARDISED} has Android's",
        )
    begun = next(_epoch(files[name]) for name in USED if name in files)
    return (join_halves(acc, halves.get("Gyroscope"), source, warnings=said, epoch_s=begun),)


def _platform(files: Mapping[str, str], source: str) -> tuple[str, bool]:
    """Platform, and whether signs and units are Android's."""
    if "Metadata" not in files:
        raise InputError(
            f"{source}: no Metadata.csv, which states the platform: Android and iOS have opposite "
            "signs"
        )
    names, _, row = files["Metadata"].strip().partition("\n")
    mark = max(",;", key=names.count)
    told = dict(zip(split_row(names.strip(), mark), split_row(row.strip(), mark), strict=False))
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
    if EPOCH_NS not in layout.names or ELAPSED not in layout.names:
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
        if len(found) != 1:
            raise InputError(f"{source}: no column {axis} (it has: {listed(names)})")
        columns.append(found[0])
    table = parse_numbers(text, source=source, wanted={ELAPSED, *columns}.__contains__)
    time_s = table.columns([ELAPSED], finite=True)[:, 0]
    return Half(time_s, table.columns(columns, finite=True), source)
