"""Geometry TOML: what the user measured on the device, one section per device."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, shown
from mobility_imu.readers.table import read_text
from mobility_imu.readers.wording import listed, named, quoted

SECTIONS = (
    "scooter",
    "scooter.mount",
    "wheelchair",
    "wheelchair.mount",
    "walker",
    "walker.mount",
)
"""Every section that a geometry file may have."""
MOUNT_KEYS: dict[str, tuple[str, ...]] = {
    "scooter.mount": (
        "rotation_lever_imu_to_lever",
        "rotation_body_imu_to_body",
        "sd_rad",
    ),
    "wheelchair.mount": (
        "rotation_left_imu_to_wheel",
        "rotation_right_imu_to_wheel",
        "rotation_frame_imu_to_chair",
    ),
    "walker.mount": (
        "rotation_imu_to_body",
        "translation_body_m",
        "rotation_sd_rad",
        "translation_sd_m",
    ),
}
"""Every key that a section of a mount may have."""


def read_section(path: str | Path, section: str, keys: Sequence[str]) -> dict[str, float]:
    """Read the numbers of one section; every key is needed, none has a default.

    Parameters
    ----------
    path : TOML file
    section : "scooter", "wheelchair" or "walker"
    keys : names of the numbers that must be there

    Returns
    -------
    dict of key to float

    Raises
    ------
    InputError
        No such file, section or key, an unknown section or key (perhaps a misspelt one), or a
        value that is no number.
    """
    table = find_table(path, section)
    if table is None:
        raise InputError(f"{path}: no section [{section}]")
    missing = [key for key in keys if key not in table]
    unknown = [key for key in table if key not in keys and not isinstance(table[key], dict)]
    if missing or unknown:
        said = [f"{key} is missing" for key in missing]
        said += [f"{listed(unknown)} is unknown"] if unknown else []
        raise InputError(f"{path}, [{section}]: {'; '.join(said)} (expected: {', '.join(keys)})")
    numbers = {key: as_number(table[key]) for key in keys}
    for key, number in numbers.items():
        if number is None:
            raise InputError(f"{path}, [{section}] {key} = {shown(table[key])}: expected a number")
    return {key: number for key, number in numbers.items() if number is not None}


def read_arrays(
    path: str | Path, section: str, shapes: dict[str, tuple[int, ...]]
) -> dict[str, FloatArray] | None:
    """Read the vectors and matrices of a section such as "walker.mount"; None if it is not there.

    Parameters
    ----------
    path : TOML file
    section : name of the section, with dots
    shapes : what must be there: key to shape

    Returns
    -------
    dict of key to array of that shape, or None

    Raises
    ------
    InputError
        No such file, a key that is missing or unknown, or one of another shape.
    """
    table = find_table(path, section)
    if table is None:
        return None
    known = MOUNT_KEYS.get(section, tuple(shapes))
    unknown = [key for key in table if key not in known]
    if unknown:
        raise InputError(
            f"{path}, [{section}]: {listed(unknown)} is unknown (known: {', '.join(known)})"
        )
    arrays = {}
    for key, shape in sorted(shapes.items(), key=lambda pair: pair[0] not in table):
        numbers = _as_array(table.get(key), shape)
        if not np.isfinite(numbers).all():
            size = " x ".join(map(str, shape))
            but = "" if key in table else "; it is missing" if table else "; the section is empty"
            raise InputError(f"{path}, [{section}] {key}: expected {size} numbers{but}")
        arrays[key] = numbers
    return arrays


def find_table(path: str | Path, section: str) -> dict[str, Any] | None:
    """Section of a TOML file as the file has it, None if there is none.

    Parameters
    ----------
    path : TOML file
    section : name of the section, with dots

    Returns
    -------
    dict, or None

    Raises
    ------
    InputError
        No such file, no TOML, or a section that no geometry file has (perhaps a misspelt one).
    """
    table = read_toml(path, again=True)  # geometry and mount are two sections of one file
    _check_sections(table, path)
    for name in section.split("."):
        found = table.get(name)
        if not isinstance(found, dict):
            return None
        table = found
    return table


def read_toml(path: str | Path, *, again: bool = False) -> dict[str, Any]:
    """Content of a TOML file.

    Parameters
    ----------
    path : TOML file
    again : whether it is read more than once, which no pipe allows

    Returns
    -------
    dict

    Raises
    ------
    InputError
        No such file, or no TOML.
    """
    text = read_text(path, again=again, form="TOML")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML ({quoted(str(error), 200)})") from None
    except RecursionError:
        raise InputError(f"{path}: not valid TOML (nested too deeply)") from None
    except ValueError:
        # Python converts no decimal integer of more than some thousand digits.
        raise InputError(f"{path}: a number has too many digits") from None


def is_repeated(value: object) -> bool:
    """Whether a value of a TOML file comes from sections in two brackets, ``[[name]]``.

    Parameters
    ----------
    value : what the file has

    Returns
    -------
    bool
    """
    return isinstance(value, list) and any(isinstance(part, dict) for part in value)


def as_number(value: object) -> float | None:
    """Number of a TOML or JSON file as a float.

    Parameters
    ----------
    value : what the file has

    Returns
    -------
    float, or None for text, truth values, and integers that no float holds

    Examples
    --------
    >>> as_number(3), as_number("3"), as_number(True), as_number(10**400)
    (3.0, None, None, None)
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:
        return None


def _as_array(value: object, shape: tuple[int, ...]) -> FloatArray:
    """Nested lists of numbers as an array; NaN alone if a part is missing, longer or no number."""
    if not shape:
        number = as_number(value)
        return np.array(np.nan if number is None else number)
    if not isinstance(value, list) or len(value) != shape[0]:
        return np.array(np.nan)
    parts = [_as_array(part, shape[1:]) for part in value]
    return np.array(parts if all(p.shape == shape[1:] for p in parts) else np.nan)


def _check_sections(table: dict[str, Any], path: str | Path) -> None:
    every = dict(table)
    for device, section in table.items():
        if device in SECTIONS and isinstance(section, dict):
            inner = {f"{device}.{named(name)}": value for name, value in section.items()}
            # What is neither a section nor called like one is a number of the device.
            every |= {n: v for n, v in inner.items() if n in SECTIONS or isinstance(v, dict)}
    for name, value in every.items():
        if name in SECTIONS and not isinstance(value, dict):
            instead = f"[[{name}]]" if is_repeated(value) else f"{name} = {shown(value)}"
            raise InputError(f"{path}: write [{name}], not {instead}")
    unknown = [name for name in every if name not in SECTIONS]
    if unknown:
        known = ", ".join(f"[{name}]" for name in SECTIONS)
        raise InputError(f"{path}: {listed(unknown)} is unknown (known sections: {known})")
