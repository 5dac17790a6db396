"""Any other CSV, by a map: a small TOML file that says which column is what.

.. code-block:: toml

    [clock]
    column = "t"            # or rate_hz = 100
    unit = "ms"             # s, ms, us, ns, min or h

    [sensors.frame]
    acc = ["ax", "ay", "-az"]   # a minus reverses the sign
    acc_unit = "g"
    gyr = ["gx", "gy", "-gz"]
    gyr_unit = "deg/s"

``first_row = 3`` in ``[clock]`` names the line of the names, if it is not the first. A file without
names has ``names = ["t", "ax", ...]`` at the top level of the map. The names of sensors are of
letters, digits and ``_``, as canonical CSV has them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, shown
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.geometry import is_repeated, read_toml
from mobility_imu.readers.json_samples import json_table
from mobility_imu.readers.layout import SEPARATORS, split_row
from mobility_imu.readers.streams import TIME_UNITS, Stream, factor, known_unit, times_of_rows
from mobility_imu.readers.table import MEND_ROW, NumberTable, parse_numbers
from mobility_imu.readers.wording import listed, named, quoted

CLOCK_WORDS = {unit: unit for unit in TIME_UNITS} | {"µs": "us", "μs": "us", "sec": "s"}
_BRACKETED = re.compile(r"[(\[]([^()\[\]]*)[)\]]")
CLOCK_KEYS = {"column", "unit", "rate_hz", "first_row"}
SENSOR_KEYS = {"acc", "acc_unit", "gyr", "gyr_unit"}


def read_mapped(text: str, source: str, map_path: str | Path) -> tuple[Stream, ...]:
    """Sensors of a table as a map describes them.

    Parameters
    ----------
    text : content of the table
    source : the table's name, for messages
    map_path : TOML file

    Returns
    -------
    tuple of Stream, all with the same times

    Raises
    ------
    InputError
        If the map misses something, has an unknown key or value, or uses a column twice, a column
        is not there, or a cell of it is no finite number.
    """
    plan = _plan(map_path)
    clock, sensors = plan["clock"], plan["sensors"]
    table = _table(text, source, plan, set(_used(clock, sensors)), map_path)
    time_s, rate_from, unseen = _times(table, clock, map_path)
    said = (*_other_units(clock, sensors, source, map_path), *unseen)
    streams = []
    for name, sensor in sensors.items():
        values = {
            quantity: _signed(table, sensor[quantity])
            * factor(quantity, sensor[f"{quantity}_unit"], str(map_path))
            for quantity in ("acc", "gyr")
            if quantity in sensor
        }
        streams.append(
            Stream(
                time_s, values["acc"], values.get("gyr"), source=source, label=name,
                rate_from=rate_from, counted="rate_hz" in clock, warnings=said,
            )
        )  # fmt: skip
        said = ()
    return tuple(streams)


def _used(clock: dict[str, Any], sensors: dict[str, Any]) -> list[str]:
    """Names of the columns that a map uses, without signs."""
    axes = [
        name.removeprefix("-")
        for sensor in sensors.values()
        for key in ("acc", "gyr")
        for name in sensor.get(key, ())
    ]
    return [clock["column"], *axes] if "column" in clock else axes


def _other_units(
    clock: dict[str, Any], sensors: dict[str, Any], source: str, map_path: str | Path
) -> tuple[str, ...]:
    """Sentences on columns whose names state another unit than the map, which counts."""
    said = []
    mapped: list[tuple[str, str | None, Callable[[str], str | None]]] = [
        (column, known_unit(quantity, sensor[f"{quantity}_unit"]), partial(known_unit, quantity))
        for sensor in sensors.values()
        for quantity in ("acc", "gyr")
        for column in sensor.get(quantity, ())
    ]
    if "column" in clock:
        mapped.append((clock["column"], clock.get("unit"), CLOCK_WORDS.get))
    for column, unit, known in mapped:
        stated = {found for text in _BRACKETED.findall(column) if (found := known(text.strip()))}
        if stated and unit not in stated:
            said.append(
                f"{source}: the name of column {named(column)} states {listed(sorted(stated))}, "
                f"but {Path(map_path).name} says {unit}, which is taken"
            )
    return tuple(said)


def _table(
    text: str, source: str, plan: dict[str, Any], read: set[str], map_path: str | Path
) -> NumberTable:
    """Columns that a map names; a JSON array of objects has its values under their keys."""
    clock = plan["clock"]
    if re.match(r"\s*\[\s*\{", text):
        if "names" in plan or "first_row" in clock:
            raise InputError(f"{map_path}: names and first_row are for tables; {source} is JSON")
        table = json_table(text, source, sorted(read))
        table.check_finite(range(len(table.header)), advice=MEND_ROW)
        return table
    first = _whole(clock.get("first_row", 1), f"{map_path}, [clock] first_row")
    lines = text.split("\n", first - 1)
    if len(lines) < first:
        raise InputError(f"{source}: has no line {first}, where {map_path} expects the names")
    body = lines[first - 1]
    if "names" in plan:
        names = _quoted_names(plan["names"])
        body = _with_tabs(body, len(names))
        separator = _separator(body, len(names))
        body = separator.join(names) + "\n" + body
        first -= 1
    else:
        body = _with_tabs(body)
    table = parse_numbers(body, source=source, first_line=first, wanted=read.__contains__)
    table.check_finite(range(len(table.header)), advice=MEND_ROW)
    return table


def _quoted_names(names: Sequence[str]) -> list[str]:
    """Names as cells of a line: a separator in one is part of it.

    A column without a name gets one: at an end of the line it would be taken for an index, or for
    what a separator too many leaves, and every other column would move.
    """
    named = (name.strip() or f"unnamed {k + 1}" for k, name in enumerate(names))
    return ['"' + name.replace('"', '""') + '"' for name in named]


def _with_tabs(body: str, count: int | None = None) -> str:
    """Table whose cells are separated by blanks alone, with tabs in their place.

    Commas may then be decimal commas: the number of columns tells, if it is known.
    """
    line = body.lstrip().partition("\n")[0]
    cells = len(line.split())
    by_comma = "," in line and (cells != count or len(split_row(line, ",")) == count)
    if by_comma or any(sep in line for sep in "\t;") or cells < 2:
        return body
    return "\n".join("\t".join(row.split()) for row in body.split("\n"))


def _separator(body: str, count: int) -> str:
    """Separator of a table without names: the one that makes the expected number of cells.

    The mark that stands most often may be the decimal comma.
    """
    line = body.lstrip("\r\n").partition("\n")[0].strip("\r")
    fits = [sep for sep in SEPARATORS if len(split_row(line.rstrip(sep), sep)) == count]
    return fits[0] if fits else max(SEPARATORS, key=line.count)


def _plan(path: str | Path) -> dict[str, Any]:
    """Content of a map, checked: what is left to find out is whether it fits the table."""
    plan = read_toml(path)
    sensors = plan.get("sensors")
    sections = {"clock": plan.get("clock"), "sensors": sensors}
    if isinstance(sensors, dict):
        sections |= {f"sensors.{named(name)}": sensor for name, sensor in sensors.items()}
    for name, value in sections.items():
        if is_repeated(value):
            raise InputError(f"{path}: write [{name}], not [[{name}]]")
    unknown = set(plan) - {"clock", "sensors", "names"}
    clock = plan.get("clock")
    if unknown or not isinstance(clock, dict) or not isinstance(sensors, dict) or not sensors:
        what = f"{listed(sorted(unknown))} is unknown" if unknown else "something is missing"
        raise InputError(f"{path}: {what}; a map has [clock] and [sensors.<name>]")
    names = plan.get("names", [])
    if not isinstance(names, list) or not all(map(_is_one_line, names)):
        raise InputError(f"{path}: names must be a list of texts, each of one line")
    _check_clock(clock, path)
    _check_sensors(sensors, path)
    used = _used(clock, sensors)
    twice = next((name for k, name in enumerate(used) if name in used[:k]), None)
    if twice is not None:
        raise InputError(
            f"{path}: column '{quoted(twice)}' is named twice; each column is the time, or one "
            "axis of one sensor"
        )
    return plan


def _check_clock(clock: dict[str, Any], path: str | Path) -> None:
    place = f"{path}, [clock]"
    _known(clock, CLOCK_KEYS, place)
    if ("column" in clock) == ("rate_hz" in clock):
        raise InputError(f"{place}: expected either column or rate_hz")
    if "rate_hz" in clock:
        check_rate(clock["rate_hz"], f"{place} rate_hz")
        return
    if not _is_name(clock["column"]):
        raise InputError(f"{place} column: expected the name of a column")
    unit = clock.get("unit")
    if not isinstance(unit, str) or unit not in TIME_UNITS:
        got = f", got {shown(unit)}" if "unit" in clock else ""
        raise InputError(f"{place} unit: expected {', '.join(TIME_UNITS)}{got}")


def _check_sensors(sensors: dict[str, Any], path: str | Path) -> None:
    lower = [name.lower() for name in sensors]
    for name, sensor in sensors.items():
        place = f"{path}, [sensors.{named(name)}]"
        if not re.fullmatch(r"\w+", name):
            raise InputError(f"{place}: a sensor's name is of letters, digits and _ only")
        if lower.count(name.lower()) > 1:
            raise InputError(f"{place}: two sensors' names differ in upper and lower case alone")
        if not isinstance(sensor, dict) or "acc" not in sensor:
            raise InputError(f'{place}: expected acc = ["...", "...", "..."]')
        _known(sensor, SENSOR_KEYS, place)
        for quantity in ("acc", "gyr"):
            columns, unit = sensor.get(quantity), f"{quantity}_unit"
            if columns is None:
                continue
            if (
                not isinstance(columns, list)
                or len(columns) != 3
                or not all(map(_is_name, columns))
            ):
                raise InputError(f"{place}: {quantity} must name three columns")
            if unit not in sensor:
                raise InputError(f"{place}: {unit} is missing")
            if not isinstance(sensor[unit], str):
                raise InputError(f"{place} {unit} = {shown(sensor[unit])}: expected a text")


def _is_one_line(value: object) -> bool:
    return isinstance(value, str) and not re.search(r"[\r\n]", value)


def _is_name(value: object) -> bool:
    return isinstance(value, str) and value.strip("- ") != ""


def _known(table: dict[str, Any], keys: set[str], place: str) -> None:
    unknown = set(table) - keys
    if unknown:
        raise InputError(
            f"{place}: {listed(sorted(unknown))} is unknown (expected: {', '.join(sorted(keys))})"
        )


def _whole(value: object, place: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 1000:
        raise InputError(f"{place}: expected a whole number from 1 to 1000")
    return value


def _times(
    table: NumberTable, clock: dict[str, Any], path: str | Path
) -> tuple[FloatArray, str, tuple[str, ...]]:
    """Times, where they come from, and a sentence on what they do not show."""
    if "rate_hz" in clock:
        rate = check_rate(clock["rate_hz"], f"{path}, [clock] rate_hz")
        time_s, unseen = times_of_rows(len(table), rate, table.source)
        return time_s, f"{Path(path).name}", (unseen,)
    times = table.columns([clock["column"]])[:, 0]
    return np.asarray(times * TIME_UNITS[clock["unit"]]), "its clock", ()


def _signed(table: NumberTable, columns: Sequence[str]) -> FloatArray:
    names = [c.removeprefix("-") if c.removeprefix("-") in table.header else c for c in columns]
    signs = np.array(
        [1.0 if name == column else -1.0 for name, column in zip(names, columns, strict=True)]
    )
    return np.asarray(table.columns(names) * signs)
