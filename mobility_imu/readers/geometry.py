"""Geometry TOML: what the user measured on the device, one section per device."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.table import read_text


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
        No such file, section or key, an unknown key (perhaps a misspelt one), or no number.
    """
    table = find_table(path, section)
    if table is None:
        raise InputError(f"{path}: no section [{section}]")
    missing = [key for key in keys if key not in table]
    unknown = [
        key for key, value in table.items() if key not in keys and not isinstance(value, dict)
    ]
    if missing or unknown:
        said = [f"{key} is missing" for key in missing] + [f"{key} is unknown" for key in unknown]
        raise InputError(f"{path}, [{section}]: {'; '.join(said)} (expected: {', '.join(keys)})")
    for key in keys:
        if isinstance(table[key], bool) or not isinstance(table[key], int | float):
            raise InputError(f"{path}, [{section}] {key} = {table[key]!r}: expected a number")
    return {key: float(table[key]) for key in keys}


def read_arrays(
    path: str | Path, section: str, shapes: dict[str, tuple[int, ...]]
) -> dict[str, FloatArray] | None:
    """Read the vectors and matrices of a section such as "walker.mount"; None if it is not there.

    Parameters
    ----------
    path : TOML file
    section : name of the section, with dots
    shapes : what must be there: key to shape

    Raises
    ------
    InputError
        No such file, a key that is missing, or one of another shape.
    """
    table = find_table(path, section)
    if table is None:
        return None
    arrays = {}
    for key, shape in shapes.items():
        try:
            arrays[key] = np.array(table[key], float)
        except (KeyError, TypeError, ValueError):
            arrays[key] = np.array(np.nan)
        if arrays[key].shape != shape or not np.isfinite(arrays[key]).all():
            size = " x ".join(map(str, shape))
            raise InputError(f"{path}, [{section}] {key}: expected {size} numbers")
    return arrays


def find_table(path: str | Path, section: str) -> dict[str, Any] | None:
    """Give a section of a TOML file as it stands there, None if there is none."""
    try:
        table = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML ({error})") from None
    for name in section.split("."):
        found = table.get(name)
        if not isinstance(found, dict):
            return None
        table = found
    return table
