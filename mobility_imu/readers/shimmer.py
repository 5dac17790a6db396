"""Shimmer's Consensys and ShimmerCapture: calibrated signals with a row of units, time in ms.

Consensys names a column ``Shimmer_40AC_Accel_LN_X_CAL``; before the signal stands what the user
calls the sensor. ShimmerCapture has the same in three rows: sensors, signals, ``RAW`` or ``CAL``.
"""

from __future__ import annotations

import re

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.layout import find_layout, split_row
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream, factor
from mobility_imu.readers.table import NumberTable, parse_numbers
from mobility_imu.readers.wording import listed, quoted

TIMES = ("TimestampSync_Unix", "Timestamp_Unix", "TimestampSync", "Timestamp")
ACCELEROMETERS = ("Accel_WR", "Accel_LN", "Accel")
"""The wide range first: it is not cut off where a wheel or a foot hits something."""
_SIGNAL = rf"{'|'.join(TIMES)}|(?:{'|'.join(ACCELEROMETERS)}|Gyro)_[XYZ]"
_NAME = re.compile(rf"(.+?)_({_SIGNAL})_CAL")
_DATES = re.compile(r"_Timestamp\w*FormattedUnix_CAL")
_SENSOR = r'"?Shimmer(?:(?!_CAL|_RAW)[^,;\t])*'
_CAPTURED = re.compile(rf"\s*{_SENSOR}(?:[,;\t]{_SENSOR}){{3,}}[,;\t\s]*")
"""First row of ShimmerCapture, whose sensors are called Shimmer until the user renames them."""
CAPTURED = {
    "Timestamp": "Timestamp",
    "Accelerometer": "Accel",
    "Low Noise Accelerometer": "Accel_LN",
    "Wide Range Accelerometer": "Accel_WR",
    "Gyroscope": "Gyro",
}
"""ShimmerCapture's names of signals, and Consensys'."""
CAPTURED_ROWS = 3
"""Of the head, behind the sensors: signals, RAW or CAL, units."""


def is_shimmer(names: str) -> bool:
    """Whether a line of names is Consensys', or the first row of ShimmerCapture.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    consensys = rf"Shimmer_\w+_(CAL|RAW)|\w_({_SIGNAL})_(CAL|RAW)\b"
    return re.search(consensys, names) is not None or _CAPTURED.fullmatch(names) is not None


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
    names, separator, rows, above = layout.names, layout.separator, layout.body, 1
    if _CAPTURED.fullmatch(separator.join(names)):
        names, rows = _as_consensys(names, rows, separator, source)
        above = CAPTURED_ROWS
    units_row, _, rows = rows.partition("\n")
    units = dict(zip(names, split_row(units_row, separator), strict=False))
    if "_RAW" in "".join(names) and "_CAL" not in "".join(names):
        raise InputError(f"{source}: raw counts; export calibrated data from Consensys (CAL)")
    table = parse_numbers(
        f"{separator.join(names)}\n{rows}", source=source, separator=separator,
        first_line=layout.line + above, wanted=lambda name: _NAME.fullmatch(name) is not None,
    )  # fmt: skip
    labels = dict.fromkeys(match[1] for name in table.header if (match := _NAME.fullmatch(name)))
    if not labels:
        raise InputError(f"{source}: no column Shimmer_..._CAL (it has: {listed(names)})")
    return tuple(_stream(table, label, units) for label in labels)


def _as_consensys(
    sensors: tuple[str, ...], body: str, separator: str, source: str
) -> tuple[tuple[str, ...], str]:
    """ShimmerCapture's columns under names as Consensys has them, and the rows from the units."""
    lines = body.split("\n", CAPTURED_ROWS - 1)
    if len(lines) < CAPTURED_ROWS:
        raise InputError(f"{source}: a file of ShimmerCapture has four rows above its numbers")
    signals, kinds = (
        [cell.strip() for cell in split_row(line, separator)] for line in lines[: CAPTURED_ROWS - 1]
    )
    names = []
    for sensor, signal, kind in zip(sensors, signals, kinds, strict=False):
        title, axis = re.fullmatch(r"(.*?)( [XYZ])?", signal).groups("")  # type: ignore[union-attr]
        names.append(
            f"{sensor}_{CAPTURED.get(title, title)}{axis.replace(' ', '_')}_{kind.upper()}"
        )
    return tuple(names), lines[-1]


def _stream(table: NumberTable, label: str, units: dict[str, str]) -> Stream:
    def columns(signal: str, quantity: str) -> FloatArray | None:
        names = [f"{label}_{signal}_{axis}_CAL" for axis in "XYZ"]
        if names[0] not in table.header:
            return None
        unit = _in_seconds(units.get(names[0], ""))
        return table.columns(names, finite=True) * factor(quantity, unit, table.source)

    clock = next((t for t in TIMES if f"{label}_{t}_CAL" in table.header), None)
    if clock is None:
        if any(_DATES.search(name) for name in table.every):
            raise InputError(
                f"{table.source}: the time of {label} is written as dates; export it as Unix time "
                "in ms from Consensys"
            )
        raise InputError(f"{table.source}: no time of {label} (it has: {table.listed()})")
    used = next(
        (a for a in ACCELEROMETERS if f"{label}_{a}_X_CAL" in table.header), ACCELEROMETERS[-1]
    )
    acc = columns(used, "acc")
    if acc is None:
        raise InputError(f"{table.source}: no accelerometer of {label} (it has: {table.listed()})")
    name = f"{label}_{clock}_CAL"
    unit = units.get(name, "").strip()
    if _in_seconds(unit) != "ms":
        raise InputError(f"{table.source}: {name} is in '{quoted(unit)}', expected ms")
    both = sum(f"{label}_{a}_X_CAL" in table.header for a in ACCELEROMETERS) > 1
    said = (
        (f"{table.source}: of two accelerometers {used} is used (the wider range)",) if both else ()
    )
    return Stream(
        table.columns([name], finite=True)[:, 0] * TIME_UNITS["ms"], acc, columns("Gyro", "gyr"),
        source=table.source, label=label.removeprefix("Shimmer_"), warnings=said,
    )  # fmt: skip


def _in_seconds(unit: str) -> str:
    """Unit with ``s`` for a second, as ``m/(sec^2)`` and ``mSecs`` of ShimmerCapture are not."""
    return re.sub(r"(?<![a-z])(m?)secs?", r"\1s", unit.strip().lower())
