"""WheelMove-ID's recordings: ``Chassis_``, ``RoueGauche_`` and ``RoueDroite_``; no clock."""

from __future__ import annotations

from mobility_imu.readers.streams import GIVEN, Asked, Stream, times_of_rows
from mobility_imu.readers.table import parse_numbers

SENSORS = {"Chassis": "frame", "RoueGauche": "left_wheel", "RoueDroite": "right_wheel"}


def is_wheelmove_id(names: str) -> bool:
    """Whether a line of names is that of a WheelMove-ID recording.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return "chassis_" in names.lower() or "roue" in names.lower()


def read_wheelmove_id(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """Three sensors in m/s² and rad/s; the rate stands in WheelMove-ID's settings, not here.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : with the sampling rate

    Returns
    -------
    tuple of Stream, all with the same times

    Raises
    ------
    InputError
        If a column is missing, a cell is no number, or no rate was given.
    """
    table = parse_numbers(text, source=source)
    rate = asked.rate(source, "a WheelMove-ID recording", " (its settings have it as freqAcq)")
    time_s, said = times_of_rows(len(table), rate, source)
    return tuple(
        Stream(
            time_s,
            table.columns([f"{theirs}_Acc_{axis}" for axis in "XYZ"], finite=True),
            table.columns([f"{theirs}_Gyr_{axis}" for axis in "XYZ"], finite=True),
            source=source,
            label=ours,
            rate_from=GIVEN,
            counted=True,
            warnings=(said,) if ours == "frame" else (),
        )
        for theirs, ours in SENSORS.items()
    )
