"""OptiTrack Motive's table export: poses of rigid bodies."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.table import as_numbers
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.results import Result

HEADER_LINES = 7
"""Settings, a blank line, then type, name, id, quantity and axis of each column."""
PARTS = 7
"""Columns of a pose; four of its quaternion (x, y, z, w), three of its position."""


@dataclass(frozen=True, eq=False, repr=False)
class Poses(Result):
    """Poses of one rigid body; NaN where the cameras lost it.

    Parameters
    ----------
    time_s : (n,) array, s, from the start of the take
    quaternion : (n, 4) array, (x, y, z, w), body to world
    position_m : (n, 3) array, m, in the world's axes (Motive's y points up)
    """

    time_s: FloatArray
    quaternion: FloatArray
    position_m: FloatArray


def parse_optitrack(text: str, body: str, source: str) -> Poses:
    """Poses of one rigid body of a take (rotations as quaternions, lengths in m).

    Parameters
    ----------
    text : content of the file
    body : the rigid body's name
    source : the file's name, for messages

    Returns
    -------
    Poses

    Raises
    ------
    InputError
        If it is no such export, it holds no such body, or the units are others.
    """
    import pandas as pd

    lines = text.split("\n", HEADER_LINES)
    if not lines[0].startswith("Format Version") or len(lines) <= HEADER_LINES:
        raise InputError(f"{source}: no table export of OptiTrack Motive, or it holds no frames")
    head = list(csv.reader(io.StringIO("\n".join(lines[:HEADER_LINES]))))
    settings = dict(zip(head[0][::2], head[0][1::2], strict=False))
    for name, wanted in (("Rotation Type", "Quaternion"), ("Length Units", "Meters")):
        if settings.get(name) != wanted:
            raise InputError(
                f"{source}: {name} is '{quoted(settings.get(name, 'not stated'))}', expected "
                f"{wanted}"
            )
    names = next((row for row in head if len(row) > 1 and row[1] == "Name"), [])
    columns = [k for k, name in enumerate(names) if name == body][:PARTS]
    if len(columns) < PARTS:
        have = listed(list(dict.fromkeys(name for name in names[2:] if ":" not in name)))
        raise InputError(f"{source}: no rigid body {body} (it has: {have})")
    try:
        table = pd.read_csv(io.StringIO(lines[HEADER_LINES]), header=None, usecols=[1, *columns])
    except (ValueError, pd.errors.ParserError) as error:
        raise InputError(f"{source}: cannot be read as a table ({quoted(str(error))})") from None
    numbers = as_numbers(table[[1, *columns]])
    if numbers is None:
        raise InputError(
            f"{source}: cannot be read as a table (a time or a number of {body} is a word)"
        )
    time_s, poses = numbers[:, 0], numbers[:, 1:]
    if len(time_s) < 2 or not np.isfinite(time_s).all() or not (np.diff(time_s) > 0).all():
        raise InputError(f"{source}: the times of the frames do not increase")
    return Poses(time_s, poses[:, :4], poses[:, 4:])
