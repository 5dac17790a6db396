"""Columns named after quantity, axis and unit, in whatever words a logger has for them.

``Acceleration x (m/s^2)``, ``Gyroscope Y (rad/s)``, ``ACCELEROMETER Z (m/s²)``: one rule finds the
three axes of a quantity, its unit and the factor that turns it into m/s² or rad/s.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.streams import factor
from mobility_imu.readers.table import NumberTable
from mobility_imu.readers.wording import listed


class Triple(NamedTuple):
    """The three columns of one quantity.

    Parameters
    ----------
    names : of the columns for x, y and z
    unit : as the names state it; empty if they state none
    """

    names: tuple[str, str, str]
    unit: str


def find_triple(names: Sequence[str], pattern: str, source: str) -> Triple | None:
    """Columns that a pattern with one group for the axis finds, None if there are none.

    Parameters
    ----------
    names : of all columns
    pattern : regular expression with the groups ``axis`` and, perhaps, ``unit``
    source : the file's name, for messages

    Returns
    -------
    Triple, or None

    Raises
    ------
    InputError
        If an axis is missing or found twice, or the units of the axes differ.
    """
    found: dict[str, str] = {}
    units = set()
    for name in names:
        match = re.fullmatch(pattern, name.strip(), re.IGNORECASE)
        if match is None:
            continue
        axis = match["axis"].lower()
        if axis in found:
            raise InputError(
                f"{source}: columns {listed([found[axis], name])} are both the {axis} axis"
            )
        found[axis] = name
        units.add((match.groupdict().get("unit") or "").strip())
    if not found:
        return None
    if set(found) != set("xyz"):
        raise InputError(f"{source}: of three axes only {listed(found.values())}")
    if len(units) > 1:
        raise InputError(f"{source}: axes in different units ({listed(sorted(units))})")
    return Triple((found["x"], found["y"], found["z"]), units.pop())


def vectors(table: NumberTable, triple: Triple, quantity: str) -> FloatArray:
    """Readings in m/s² or rad/s.

    Parameters
    ----------
    table : the file's columns
    triple : the three columns
    quantity : "acc" or "gyr"

    Returns
    -------
    (n, 3) array

    Raises
    ------
    InputError
        If the unit is not known, or a cell is no number.
    """
    return np.asarray(
        table.columns(triple.names, finite=True) * factor(quantity, triple.unit, table.source)
    )
