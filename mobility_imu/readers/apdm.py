"""APDM's two text exports: Mobility Lab's table with units, and "Format=7" with three header rows.

Both hold all sensors of a session on one clock, read +1 g on the axis that points up, and have
right-handed gyroscopes.
"""

from __future__ import annotations

import re

from mobility_imu.errors import InputError
from mobility_imu.readers.layout import comma_separated, split_row
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream, contradicted, factor
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.wording import quoted

QUANTITIES = {"Acceleration": "acc", "Angular Velocity": "gyr"}
FORMAT_7 = {
    "Acceleration": "acc",
    "Angular Velocity": "gyr",
    "Gyroscope": "gyr",
    "Accelerometer": "acc",
}


def is_apdm(names: str) -> bool:
    """Whether a file begins like one of APDM's exports.

    Parameters
    ----------
    names : its first line

    Returns
    -------
    bool
    """
    return names.startswith(("Test Name:", "Format=7"))


def read_apdm(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """All sensors of a session.

    A "Format=7" file states no units: APDM documents m/s², rad/s and microseconds.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used

    Returns
    -------
    tuple of Stream, all with the same times

    Raises
    ------
    InputError
        If a column is missing, its unit is not known, or a cell is no number.
    """
    text = comma_separated(text)
    return _format_7(text, source) if text.startswith("Format=7") else _table(text, source)


def _table(text: str, source: str) -> tuple[Stream, ...]:
    lines = text.split("\n", 4)
    if len(lines) < 5:
        raise InputError(f"{source}: an APDM export needs five lines or more")
    stated = re.match(r"Sample Rate:,\s*(\d+(?:\.\d*)?),\s*Hz", lines[1], re.ASCII)
    names = [name.strip() for name in split_row(lines[2].rstrip("\r"), ",")]
    row = (unit.strip() for unit in split_row(lines[3].rstrip("\r"), ","))
    units = dict(zip(names, row, strict=False))
    parts = [tuple(name.rsplit("/", 2)) for name in names]
    read = {"/".join(part) for part in parts if len(part) == 3 and part[1] in QUANTITIES} | {"Time"}
    table = parse_numbers(
        lines[2] + "\n" + lines[4],
        separator=",",
        source=source,
        first_line=4,
        wanted=read.__contains__,
    )
    time_s = table.columns(["Time"], finite=True)[:, 0] * _time_scale(units.get("Time", ""), source)
    said = contradicted(float(stated[1]), time_s, "Time", source) if stated else ()
    streams: list[Stream] = []
    for label in dict.fromkeys(part[0] for part in parts if len(part) == 3):
        found = {}
        for title, quantity in QUANTITIES.items():
            columns = [f"{label}/{title}/{axis}" for axis in "XYZ"]
            if columns[0] in names:
                unit = units.get(columns[0], "")
                found[quantity] = table.columns(columns, finite=True) * factor(
                    quantity, unit, source
                )
        if "acc" not in found:
            raise InputError(f"{source}: no {quoted(label)}/Acceleration/X, Y, Z")
        streams.append(
            Stream(
                time_s, found["acc"], found.get("gyr"), source=source, label=label,
                warnings=() if streams else said,
            )
        )  # fmt: skip
    return tuple(streams)


def _time_scale(unit: str, source: str) -> float:
    """What times are multiplied by to be in s; without a unit they are in s."""
    scale = TIME_UNITS.get(unit or "s")
    if scale is None:
        raise InputError(
            f"{source}: time in '{quoted(unit)}' is not known; expected {', '.join(TIME_UNITS)}"
        )
    return scale


def _format_7(text: str, source: str) -> tuple[Stream, ...]:
    lines = text.split("\n", 3)
    if len(lines) < 4:
        raise InputError(f"{source}: an APDM export of format 7 needs four lines or more")
    heads, quantities, axes = (
        [cell.strip() for cell in split_row(line.rstrip("\r"), ",")] for line in lines[:3]
    )
    width = max(len(heads), len(quantities), len(axes))
    heads, quantities, axes = (row + [""] * (width - len(row)) for row in (heads, quantities, axes))
    # A number opens a sensor's columns, its label follows some columns later; a quantity stands
    # over its first axis.
    starts = [k for k, cell in enumerate(heads) if cell.isdigit()]
    names = []
    quantity = ""
    for k in range(width):
        begin = max((start for start in starts if start <= k), default=0)
        end = next((start for start in starts if start > k), width)
        labels = [cell for cell in heads[begin + 1 : end] if cell]
        quantity = quantities[k] or quantity
        names.append(f"{labels[0] if labels else heads[begin]}/{quantity}/{axes[k]}/{k}")
    wanted = {}
    for k, name in enumerate(names):
        place, what, axis, _ = name.rsplit("/", 3)
        if what in FORMAT_7 and axis in ("X", "Y", "Z"):
            if (place, FORMAT_7[what], axis) in wanted:
                raise InputError(
                    f"{source}: column {quoted(name[: name.rindex('/')])} appears twice"
                )
            wanted[(place, FORMAT_7[what], axis)] = k
    if not wanted:
        raise InputError(f"{source}: no accelerations found in the three header rows")
    time_column = next((k for k in range(width) if re.search("time", quantities[k], re.I)), 0)
    read = {*wanted.values(), time_column}
    header = ",".join(str(k) for k in range(width))
    table = parse_numbers(
        header + "\n" + lines[3], separator=",", source=source, first_line=3,
        wanted=lambda name: int(name) in read,
    )  # fmt: skip
    time_s = table.columns([str(time_column)], finite=True)[:, 0] * TIME_UNITS["us"]
    streams = []
    for place in dict.fromkeys(key[0] for key in wanted):
        found = {
            q: table.columns([str(wanted[(place, q, axis)]) for axis in "XYZ"], finite=True)
            for q in ("acc", "gyr")
            if all((place, q, axis) in wanted for axis in "XYZ")
        }
        if "acc" not in found:
            raise InputError(f"{source}: no accelerations of {quoted(place)}")
        streams.append(Stream(time_s, found["acc"], found.get("gyr"), source=source, label=place))
    return tuple(streams)
