"""x-io's comma-separated files: ``sensors.csv`` of an NGIMU, ``Inertial.csv`` of an x-IMU3.

Both state their units in the names of the columns: g and deg/s. Both read +1 g on the axis that
points up, and their gyroscopes are right-handed. The first x-IMU has the same columns without a
clock; its packet number counts packets of every kind, not samples.
"""

from __future__ import annotations

from mobility_imu.readers.streams import (
    GIVEN,
    TIME_UNITS,
    Asked,
    Stream,
    stream_in_g_and_degrees,
    times_of_rows,
)
from mobility_imu.readers.table import parse_numbers

ACCELEROMETER = [f"Accelerometer {axis} (g)" for axis in "XYZ"]
GYROSCOPE = [f"Gyroscope {axis} (deg/s)" for axis in "XYZ"]
CLOCKS = {"Time (s)": TIME_UNITS["s"], "Timestamp (us)": TIME_UNITS["us"]}
PACKETS = "Packet number"
READ = {*ACCELEROMETER, *GYROSCOPE, *CLOCKS, PACKETS}


def is_xio(names: str) -> bool:
    """Whether a line of names is x-io's.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return GYROSCOPE[0] in names and ACCELEROMETER[0] in names


def read_xio(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The sensor of an NGIMU's, x-IMU3's or first x-IMU's file.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : with the sampling rate, which the first x-IMU's file does not state

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If a column is missing, a cell is no number, or no rate is known.
    """
    table = parse_numbers(text, source=source, wanted=READ.__contains__)
    clock = next((name for name in CLOCKS if name in table.header), None)
    if clock is not None:
        time_s = table.columns([clock], finite=True)[:, 0] * CLOCKS[clock]
        return (stream_in_g_and_degrees(table, time_s, ACCELEROMETER, GYROSCOPE),)
    rate = asked.rate(source, "a file of the first x-IMU", " (its Registers.csv has it)")
    time_s, said = times_of_rows(len(table), rate, source)
    found = stream_in_g_and_degrees(table, time_s, ACCELEROMETER, GYROSCOPE)
    return (
        Stream(
            time_s, found.acc_mps2, found.gyr_radps, source=source, rate_from=GIVEN, counted=True,
            warnings=(said,),
        ),
    )  # fmt: skip
