"""The app Physics Toolbox, multi record: ``time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz``; g, rad/s, s."""

from __future__ import annotations

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers.streams import Asked, Stream, held_warnings
from mobility_imu.readers.table import parse_numbers

FORCE = [f"gF{axis}" for axis in "xyz"]
RATE = [f"w{axis}" for axis in "xyz"]


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
    acc = table.columns(FORCE) * STANDARD_GRAVITY_MPS2
    gyr = table.columns(RATE) if RATE[0] in table.header else None
    both = acc.any(axis=1) if gyr is None else acc.any(axis=1) & gyr.any(axis=1)
    if not both.any():
        raise InputError(f"{source}: a sensor reads zero throughout")
    begin = int(np.argmax(both))
    said: tuple[str, ...] = (
        (f"{source}: {begin} row(s) of zeros at the beginning left out",) if begin else ()
    )
    time_s = table.columns(["time"])[begin:, 0]
    said += held_warnings(time_s, acc[begin:], source)
    return (
        Stream(
            time_s, acc[begin:], None if gyr is None else gyr[begin:], source=source, warnings=said
        ),
    )
