"""x-io's comma-separated files: ``sensors.csv`` of an NGIMU, ``Inertial.csv`` of an x-IMU3.

Both state their units in the names of the columns: g and deg/s. Both read +1 g on the axis that
points up, and their gyroscopes are right-handed.
"""

from __future__ import annotations

from mobility_imu.readers.streams import Stream, stream_in_g_and_degrees
from mobility_imu.readers.table import parse_numbers

ACCELEROMETER = [f"Accelerometer {axis} (g)" for axis in "XYZ"]
GYROSCOPE = [f"Gyroscope {axis} (deg/s)" for axis in "XYZ"]


def parse_ngimu(text: str, source: str) -> Stream:
    """Stream of an NGIMU's ``sensors.csv``; its time counts from the start of the session.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages

    Returns
    -------
    Stream

    Raises
    ------
    InputError
        If a column is missing, or a cell is no number.
    """
    table = parse_numbers(text, separator=",", source=source)
    time_s = table.columns(["Time (s)"])[:, 0]
    return stream_in_g_and_degrees(table, time_s, ACCELEROMETER, GYROSCOPE)


def parse_ximu3(text: str, source: str) -> Stream:
    """Stream of an x-IMU3's ``Inertial.csv``; its time counts from when the device was put on.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages

    Returns
    -------
    Stream

    Raises
    ------
    InputError
        If a column is missing, or a cell is no number.
    """
    table = parse_numbers(text, separator=",", source=source)
    time_s = table.columns(["Timestamp (us)"])[:, 0] * 1e-6
    return stream_in_g_and_degrees(table, time_s, ACCELEROMETER, GYROSCOPE)
