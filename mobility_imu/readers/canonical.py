"""The package's own table: ``time_s``, then ``<sensor>_acc_x_mps2 … <sensor>_gyr_z_radps``."""

from __future__ import annotations

import re

from mobility_imu.errors import InputError
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import MEND_ROW, parse_numbers
from mobility_imu.readers.wording import listed, named

AXES = ("x", "y", "z")
_COLUMN = re.compile(r"(\w+?)_(acc_[xyz]_mps2|gyr_[xyz]_radps)")
_MEANT = re.compile(r"(^|_)(acc|gyr|gyro|accel)(_|$)", re.IGNORECASE)


def is_canonical(names: str) -> bool:
    """Whether a line of names is that of a canonical table.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return "time_s" in names.lower() and not names.startswith(("[", "{"))


def read_canonical(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """Sensors of a canonical table; columns of other quantities are left out with a warning.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the table states clock and units

    Returns
    -------
    tuple of Stream, all with the same times

    Raises
    ------
    InputError
        If a column is missing, misspelt or appears twice, or a cell is no finite number.
    """

    def wanted(name: str) -> bool:
        if name.lower() == "time_s" or _COLUMN.fullmatch(name):
            return True
        if not name or _MEANT.search(name):
            raise InputError(
                f"{source}: column {named(name)} is not known; expected <sensor>_acc_x_mps2 or "
                "<sensor>_gyr_x_radps"
            )
        return False

    table = parse_numbers(text, source=source, wanted=wanted)
    time_s = table.columns(["time_s"])[:, 0]
    groups: dict[str, set[str]] = {}
    for name in table.header:
        match = _COLUMN.fullmatch(name)
        if match is not None:
            groups.setdefault(match[1], set()).add(match[2][:3])
    if not groups:
        raise InputError(
            f"{source}: no sensor; expected columns <sensor>_acc_x_mps2 beside time_s "
            f"(it has: {table.listed()})"
        )
    said = (f"{source}: not used: {listed(table.left_out)}",) if table.left_out else ()
    streams = []
    for sensor, have in groups.items():
        acc, gyr = (
            table.columns([f"{sensor}_{quantity}_{axis}_{unit}" for axis in AXES])
            if quantity == "acc" or "gyr" in have
            else None
            for quantity, unit in (("acc", "mps2"), ("gyr", "radps"))
        )
        assert acc is not None
        streams.append(
            Stream(time_s, acc, gyr, source=source, label=sensor, warnings=said, counted=True)
        )
        said = ()
    table.check_finite(range(len(table.header)), advice=MEND_ROW)
    return tuple(streams)
