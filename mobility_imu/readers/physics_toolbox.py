"""The app Physics Toolbox, multi record: ``time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz``; g, rad/s, s."""

from __future__ import annotations

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import parse_numbers

FORCE = [f"gF{axis}" for axis in "xyz"]
RATE = [f"w{axis}" for axis in "xyz"]
LONGEST_START_S = 1.0
"""A gyroscope reports within this. One that reads zero for longer rests, on a phone that corrects
its offset and cuts small rates off."""


def is_physics_toolbox(names: str) -> bool:
    """Whether a line of names is Physics Toolbox'.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return names.startswith("time") and "gFx" in names


def read_physics_toolbox(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The phone of a file; rows before both sensors report are left out.

    A sensor that has not reported yet reads zero. So does a gyroscope at rest on some phones:
    zeros that last longer than :data:`LONGEST_START_S` are kept, with a warning.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the app documents its units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If a column is missing or a cell is no number.
    """
    table = parse_numbers(text, source=source, wanted={"time", *FORCE, *RATE}.__contains__)
    acc = table.columns(FORCE, finite=True) * STANDARD_GRAVITY_MPS2
    gyr = table.columns(RATE, finite=True) if RATE[0] in table.header else None
    time_s = table.columns(["time"], finite=True)[:, 0]
    begin = _first(acc, "accelerometer", source)
    said = []
    if gyr is not None:
        turns = max(begin, _first(gyr, "gyroscope", source))
        silent_s = float(time_s[turns] - time_s[begin])
        if silent_s <= LONGEST_START_S:
            begin = turns
        else:
            said.append(
                f"{source}: the gyroscope reads exactly zero in the first {silent_s:.3g} s, taken "
                "for a rest; cut them off if the phone moved"
            )
    if begin:
        said.append(f"{source}: {begin} row(s) of zeros at the beginning left out")
    return (
        Stream(
            time_s[begin:], acc[begin:], None if gyr is None else gyr[begin:], source=source,
            warnings=tuple(said),
        ),
    )  # fmt: skip


def _first(values: FloatArray, sensor: str, source: str) -> int:
    """First row in which a sensor reports."""
    there = values.any(axis=1)
    if not there.any():
        raise InputError(f"{source}: the {sensor} reads zero throughout")
    return int(np.argmax(there))
