"""Xsens (Movella) DOT: recordings of the app and of the PC software, named columns after a head."""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.layout import comma_separated
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.wording import listed
from mobility_imu.readers.xsens_mt import OF_MT_MANAGER

ACCELEROMETER = [f"Acc_{axis}" for axis in "XYZ"]
GYROSCOPE = [f"Gyr_{axis}" for axis in "XYZ"]
TURNS = [f"dq_{axis}" for axis in "XYZ"]
"""Vector part of the turn during one sample, with which a log of the PC software may be checked."""
CLOCK_RANGE = 2**32
"""The sensor's clock counts microseconds in 32 bits and starts again at 0 after 71.6 minutes."""
LARGEST_ACC_MPS2, LARGEST_GYR_DEGPS = 200.0, 2300.0
"""More than the sensor's ranges (16 g, 2000 deg/s); such a number is a damaged row."""
MOST_HEADER_LINES = 30
"""Lines in which the names are looked for; files of the app have 11 before them. Set by hand."""
LARGEST_TICK_STEP = 5000.0
"""A usual step below it counts tenths of a millisecond, one above it microseconds. A DOT gives 1,
4, 10, 12, 15, 20, 30, 60 or 120 samples a second (Movella DOT user manual, output rates): 4 Hz are
steps of 2,500 in the one unit, 120 Hz of 8,333 in the other."""
SAME_UNIT = 2.0
"""Factor within which a gyroscope agrees with the turns; degrees and radians differ by 57. Set by
hand: at rest the turns, which have four decimals, are off by tenths."""


def is_xsens_dot(line: str) -> bool:
    """Whether a file begins like a DOT recording of the app or of the PC software.

    A table whose head was taken off has the names of an export of MT Manager, which has other units
    of rate and clock: further columns tell, or nothing does.

    Parameters
    ----------
    line : its first line, after ``sep=``

    Returns
    -------
    bool
    """
    if re.match(r'"?(DeviceTag|FirmwareVersion)', line):
        return True
    names = re.match(r'"?(PacketCounter"?[,;\t ]\s*"?)?SampleTimeFine\b', line)
    return names is not None and not re.search(OF_MT_MANAGER, line)


def read_xsens_dot(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """Stream of a recording with acceleration (m/s²) and angular rate.

    Rates are in deg/s, except where the PC software computed them from the turns ``dq`` ("Custom
    mode 4"): then in rad/s. Where turns are logged, they tell which.

    Rows of zeros at the beginning, before the sensor's first sample, are left out, and so are
    damaged rows (NaN, infinity, more than the sensor's range); a warning says how many.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the clock and the units are the sensor's

    Returns
    -------
    tuple of one Stream; its time is the sensor's own clock, which starts at an arbitrary moment

    Raises
    ------
    InputError
        If a column is missing (real-time recordings hold no rates), no row is usable, or the rates
        fit the turns in no unit.
    """
    lines = comma_separated(text).split("\n", MOST_HEADER_LINES)
    head = next((k for k, line in enumerate(lines) if "SampleTimeFine" in line), None)
    if head is None:
        raise InputError(f"{source}: no line of names with SampleTimeFine; is it a DOT recording?")
    names = [name.strip() for name in lines[head].split(",")]
    missing = [name for name in [*ACCELEROMETER, *GYROSCOPE] if name not in names]
    if missing:
        raise InputError(
            f"{source}: no column {listed(missing)} (it has: {listed(names)}); record "
            "'Rate quantities' or 'Custom' with acceleration and angular velocity: FreeAcc has no "
            "gravity"
        )
    turns = [name for name in TURNS if name in names]
    body, unread = _without_bare_stamps("\n".join(lines[head:]))
    table = parse_numbers(
        body, separator=",", source=source, first_line=head + 1,
        wanted={"SampleTimeFine", *ACCELEROMETER, *GYROSCOPE, *turns}.__contains__,
    )  # fmt: skip
    values = table.columns([*ACCELEROMETER, *GYROSCOPE])
    # Written before the sensor's first sample.
    begin = int(np.argmax((values != 0).any(axis=1)))
    acc, gyr = values[:, :3], values[:, 3:]
    count = table.columns(["SampleTimeFine"])[:, 0]
    possible = np.isfinite(values).all(axis=1) & np.isfinite(count)
    possible &= (np.abs(acc) < LARGEST_ACC_MPS2).all(axis=1)
    possible &= (np.abs(gyr) < LARGEST_GYR_DEGPS).all(axis=1)
    started = np.arange(len(values)) >= begin
    damaged = int((~possible & started).sum())
    sound = possible & started
    said = []
    if begin:
        said.append(f"{source}: {begin} row(s) of zeros at the beginning left out")
    if damaged:
        said.append(f"{source}: {damaged} damaged row(s) left out")
    if unread:
        said.append(f"{source}: {unread} row(s) without readings at the end left out")
    time_s = _seconds(count[sound])
    scale = np.pi / 180
    if turns == TURNS and _in_radians(gyr[sound], table.columns(TURNS)[sound], time_s, source):
        scale = 1.0
        said.append(f"{source}: angular rates taken in rad/s, for they are the turns dq over time")
    return (
        Stream(
            time_s,
            acc[sound],
            gyr[sound] * scale,
            source=source,
            warnings=tuple(said),
        ),
    )


def _without_bare_stamps(table: str) -> tuple[str, int]:
    """Table without last rows that hold a stamp alone, and their number.

    The PC software writes some while a measurement ends. A last line that does not end may be cut,
    and is kept, so that it is told.
    """
    lines = table.split("\n")
    end = len(lines) - 1
    while not lines[-1] and end > 1 and lines[end - 1].rstrip("\r").isdigit():
        end -= 1
    return "\n".join([*lines[:end], lines[-1]]), len(lines) - 1 - end


def _in_radians(gyr: FloatArray, turns: FloatArray, time_s: FloatArray, source: str) -> bool:
    """Whether rates are in rad/s: the turn during a sample, of which ``dq`` is half, tells."""
    step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    told = np.isfinite(turns).all(axis=1)
    power = float((turns[told] ** 2).sum())
    if not (power > 0 and step_s > 0):
        raise InputError(
            f"{source}: its turns dq are zero, so that the unit of Gyr is not known; state it in a "
            "map (mobility-imu read --map)"
        )
    ratio = float((gyr[told] * turns[told]).sum()) * step_s / (2 * power)
    for unit, radians in ((1.0, True), (180 / np.pi, False)):
        if unit / SAME_UNIT < ratio < unit * SAME_UNIT:
            return radians
    raise InputError(
        f"{source}: Gyr fits the turns dq neither in rad/s nor in deg/s (ratio {ratio:.3g}); state "
        "the unit in a map (mobility-imu read --map)"
    )


def _seconds(count: FloatArray) -> FloatArray:
    """Sensor's clock in s; it goes on where the counter starts again.

    The app counts microseconds, the PC software tenths of a millisecond. The usual step tells which
    (:data:`LARGEST_TICK_STEP`), except for a log of the PC software at 1 Hz, which is taken for the
    app's at 100 Hz.
    """
    wraps = np.cumsum(np.diff(count, prepend=count[:1]) < -CLOCK_RANGE / 2)
    whole = count + CLOCK_RANGE * wraps
    step = float(np.median(np.diff(whole))) if len(whole) > 1 else LARGEST_TICK_STEP
    return whole * (1e-4 if step < LARGEST_TICK_STEP else 1e-6)
