"""Geometry TOML: what the user measured on the device, one section per device."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path

from mobility_imu.errors import InputError
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
    try:
        content = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML ({error})") from None
    table = content.get(section)
    if not isinstance(table, dict):
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
