"""Shimmer's Consensys: names ``Shimmer_<id>_<signal>_CAL``, a row of units, time in ms."""

from __future__ import annotations

import re

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.layout import find_layout, split_row
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream, factor
from mobility_imu.readers.table import NumberTable, parse_numbers
from mobility_imu.readers.wording import listed, quoted

_NAME = re.compile(r"(Shimmer_\w+?)_(\w+)_CAL")
ACCELEROMETERS = ("Accel_WR", "Accel_LN", "Accel")
"""The wide range first: it is not cut off where a wheel or a foot hits something."""
TIMES = ("TimestampSync_Unix", "Timestamp_Unix", "TimestampSync", "Timestamp")


def is_shimmer(names: str) -> bool:
    """Whether a line of names is Consensys'.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return re.search(r"Shimmer_\w+_(CAL|RAW)", names) is not None


def read_shimmer(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The sensors of a file, calibrated; raw counts are refused.

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
    layout = find_layout(text, source)
    units_row, _, rows = layout.body.partition("\n")
    units = dict(zip(layout.names, split_row(units_row, layout.separator), strict=False))
    if "_RAW" in "".join(layout.names) and "_CAL" not in "".join(layout.names):
        raise InputError(f"{source}: raw counts; export calibrated data from Consensys (CAL)")
    header = layout.separator.join(layout.names)
    table = parse_numbers(
        f"{header}\n{rows}", source=source, separator=layout.separator,
        first_line=layout.line + 1, wanted=lambda name: _wanted(name),
    )  # fmt: skip
    labels = dict.fromkeys(match[1] for name in table.header if (match := _NAME.fullmatch(name)))
    if not labels:
        raise InputError(f"{source}: no column Shimmer_..._CAL (it has: {listed(layout.names)})")
    return tuple(_stream(table, label, units) for label in labels)


def _wanted(name: str) -> bool:
    match = _NAME.fullmatch(name)
    return match is not None and re.match(r"Timestamp|Accel|Gyro", match[2]) is not None


def _stream(table: NumberTable, label: str, units: dict[str, str]) -> Stream:
    def columns(signal: str, quantity: str) -> FloatArray | None:
        names = [f"{label}_{signal}_{axis}_CAL" for axis in "XYZ"]
        if names[0] not in table.header:
            return None
        unit = units.get(names[0], "")
        return table.columns(names, finite=True) * factor(quantity, unit, table.source)

    clock = next((t for t in TIMES if f"{label}_{t}_CAL" in table.header), None)
    if clock is None:
        raise InputError(f"{table.source}: no time of {label} (it has: {table.listed()})")
    used = next(
        (a for a in ACCELEROMETERS if f"{label}_{a}_X_CAL" in table.header), ACCELEROMETERS[-1]
    )
    acc = columns(used, "acc")
    if acc is None:
        raise InputError(f"{table.source}: no accelerometer of {label} (it has: {table.listed()})")
    name = f"{label}_{clock}_CAL"
    unit = units.get(name, "").strip()
    if unit != "ms":
        raise InputError(f"{table.source}: {name} is in '{quoted(unit)}', expected ms")
    both = sum(f"{label}_{a}_X_CAL" in table.header for a in ACCELEROMETERS) > 1
    said = (
        (f"{table.source}: of two accelerometers {used} is used (the wider range)",) if both else ()
    )
    return Stream(
        table.columns([name], finite=True)[:, 0] * TIME_UNITS["ms"], acc, columns("Gyro", "gyr"),
        source=table.source, label=label.partition("_")[2], warnings=said,
    )  # fmt: skip
