"""Faults put into a recording on purpose, to see whether they are found.

Each function takes a recording without a fault and gives one with it. Nothing here is shared with
what looks for faults.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray, as_floats, as_number, as_rotation, one_of
from mobility_imu.recording import Imu, Recording

__all__ = [
    "clip",
    "exchange",
    "freeze",
    "late",
    "late_half",
    "left_handed",
    "offset",
    "reverse",
    "scale",
    "silence",
    "spike",
    "turn",
]


def freeze(
    recording: Recording, sensor: str, half: str, start_s: float, length_s: float
) -> Recording:
    """Recording in which one half of a sensor repeats its last reading for a while.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    start_s : s after the recording's start
    length_s : s

    Returns
    -------
    Recording
    """
    values = _half(recording, sensor, half)
    first = int(np.searchsorted(recording.time_s, recording.time_s[0] + start_s))
    last = int(np.searchsorted(recording.time_s, recording.time_s[0] + start_s + length_s))
    values[first:last] = values[first]
    return _with(recording, sensor, half, values)


def silence(recording: Recording, sensor: str, start_s: float = 0.0) -> Recording:
    """Recording in which a gyroscope reads zero from some time on.

    Parameters
    ----------
    recording : Recording
    sensor : name
    start_s : s after the recording's start

    Returns
    -------
    Recording
    """
    values = _half(recording, sensor, "gyr")
    values[recording.time_s - recording.time_s[0] >= start_s] = 0.0
    return _with(recording, sensor, "gyr", values)


def clip(recording: Recording, sensor: str, half: str, limit: float) -> Recording:
    """Recording in which one half of a sensor has a smaller range.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    limit : m/s² or rad/s, end of the range on each axis

    Returns
    -------
    Recording
    """
    limit = as_number(limit, "limit")
    values = np.clip(_half(recording, sensor, half), -limit, limit)
    return _with(recording, sensor, half, values)


def spike(
    recording: Recording, sensor: str, half: str, samples: ArrayLike, axis: int, size: float
) -> Recording:
    """Recording with single readings far off.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    samples : indices
    axis : 0, 1 or 2
    size : m/s² or rad/s, added to the readings

    Returns
    -------
    Recording
    """
    values = _half(recording, sensor, half)
    values[np.asarray(samples, int), axis] += size
    return _with(recording, sensor, half, values)


def offset(recording: Recording, sensor: str, half: str, vector: ArrayLike) -> Recording:
    """Recording in which one half of a sensor reads a constant too much.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    vector : (3,) array, m/s² or rad/s

    Returns
    -------
    Recording
    """
    values = _half(recording, sensor, half) + as_floats(vector, "vector")
    return _with(recording, sensor, half, values)


def scale(recording: Recording, sensor: str, half: str, factors: ArrayLike) -> Recording:
    """Recording in which one half of a sensor reads too much or too little by factors.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    factors : number, or (3,) array for the axes

    Returns
    -------
    Recording
    """
    values = _half(recording, sensor, half) * as_floats(factors, "factors")
    return _with(recording, sensor, half, values)


def reverse(recording: Recording, sensor: str, signs: ArrayLike = (-1, -1, -1)) -> Recording:
    """Recording in which axes of a gyroscope have the wrong sign.

    Parameters
    ----------
    recording : Recording
    sensor : name
    signs : (3,) array of 1 and -1

    Returns
    -------
    Recording
    """
    return scale(recording, sensor, "gyr", signs)


def late(recording: Recording, sensor: str, lag_s: float) -> Recording:
    """Recording in which a sensor's readings come late.

    Parameters
    ----------
    recording : Recording
    sensor : name
    lag_s : s; before its first reading it repeats that

    Returns
    -------
    Recording
    """
    imu, time_s = recording.sensor(sensor), recording.time_s
    # Whole samples: interpolation would make the noise of a late sensor smaller.
    steps = round(as_number(lag_s, "lag_s", zero=True) * recording.sampling_rate_hz)
    index = np.maximum(np.arange(len(time_s)) - steps, 0)
    new = Imu(imu.acc_mps2[index], None if imu.gyr_radps is None else imu.gyr_radps[index])
    return _replaced(recording, {sensor: new})


def late_half(recording: Recording, sensor: str, half: str, lag_s: float) -> Recording:
    """Recording in which one half of a sensor comes late, or early, against the other.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    lag_s : s, rounded to whole samples; negative for a half that comes early

    Returns
    -------
    Recording of the time that both halves have readings for
    """
    late, other = _half(recording, sensor, half), "acc" if half == "gyr" else "gyr"
    steps = round(as_number(lag_s, "lag_s", negative=True) * recording.sampling_rate_hz)
    count = len(recording) - abs(steps)
    begin = max(steps, 0)
    values = {half: late[begin - steps :][:count], other: _half(recording, sensor, other)[begin:]}
    imu = Imu(values["acc"][:count], values["gyr"][:count])
    time_s = recording.time_s[begin:][:count]
    return Recording(time_s, {sensor: imu}, source=recording.source)


def exchange(recording: Recording, first: str, second: str) -> Recording:
    """Recording in which two sensors have each other's names.

    Parameters
    ----------
    recording : Recording
    first, second : names

    Returns
    -------
    Recording
    """
    return _replaced(recording, {first: recording.sensor(second), second: recording.sensor(first)})


def left_handed(recording: Recording, sensor: str, axis: int) -> Recording:
    """Recording of a sensor with left-handed axes: one axis has the wrong sign in both halves.

    Parameters
    ----------
    recording : Recording
    sensor : name
    axis : 0, 1 or 2

    Returns
    -------
    Recording
    """
    imu, signs = recording.sensor(sensor), np.where(np.arange(3) == axis, -1.0, 1.0)
    gyr = None if imu.gyr_radps is None else imu.gyr_radps * signs
    return _replaced(recording, {sensor: Imu(imu.acc_mps2 * signs, gyr)})


def turn(recording: Recording, sensor: str, rotation: ArrayLike) -> Recording:
    """Recording of a sensor that sits turned in its place.

    Parameters
    ----------
    recording : Recording
    sensor : name
    rotation : (3, 3) array, from the axes as they should be to those of the turned sensor

    Returns
    -------
    Recording
    """
    rotation = as_rotation(rotation, "rotation")
    imu = recording.sensor(sensor)
    gyr = None if imu.gyr_radps is None else imu.gyr_radps @ rotation.T
    return _replaced(recording, {sensor: Imu(imu.acc_mps2 @ rotation.T, gyr)})


def _half(recording: Recording, sensor: str, half: str) -> FloatArray:
    one_of("half", half, ("acc", "gyr"))
    values = recording.sensor(sensor).acc_mps2 if half == "acc" else recording.gyroscope(sensor)
    return values.copy()


def _with(recording: Recording, sensor: str, half: str, values: FloatArray) -> Recording:
    imu = recording.sensor(sensor)
    new = Imu(values, imu.gyr_radps) if half == "acc" else Imu(imu.acc_mps2, values)
    return _replaced(recording, {sensor: new})


def _replaced(recording: Recording, sensors: dict[str, Imu]) -> Recording:
    return Recording(recording.time_s, {**recording.sensors, **sensors}, source=recording.source)
