"""Faults put into a recording on purpose, to see whether they are found.

Each function takes a recording without a fault and gives one with it. Nothing here is shared with
what looks for faults.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.frames import (
    FloatArray,
    as_floats,
    as_number,
    as_rotation,
    as_vectors,
    one_of,
    shown,
)
from mobility_imu.recording import Imu, Recording

__all__ = [
    "clip",
    "exchange",
    "freeze",
    "jump",
    "late",
    "late_half",
    "left_handed",
    "offset",
    "reverse",
    "scale",
    "silence",
    "spike",
    "tip",
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
    start_s = as_number(start_s, "start_s", negative=True)
    length_s = as_number(length_s, "length_s", zero=True)
    first = int(np.searchsorted(recording.time_s, recording.time_s[0] + start_s))
    if first == len(recording):
        raise InputError(f"start_s = {start_s:g}: the recording is over by then")
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
    start_s = as_number(start_s, "start_s", negative=True)
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
    axis = one_of("axis", axis, (0, 1, 2))
    places = as_floats(samples, "samples")
    whole = np.isin(places, np.arange(len(values)))
    if places.ndim > 1 or not whole.all():
        raise InputError(
            f"samples = {shown(samples)}: expected indices from 0 to {len(values) - 1}"
        )
    values[places.astype(int), axis] += as_number(size, "size", negative=True)
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
    values = _half(recording, sensor, half) + as_vectors(vector, "vector", ndim=1, finite=True)
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
    return _with(recording, sensor, half, _half(recording, sensor, half) * _factors(factors))


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
    factors = as_vectors(signs, "signs", ndim=1)
    if (np.abs(factors) != 1).any():
        raise InputError(f"signs = {shown(signs)}: expected 1 or -1 for each axis")
    return scale(recording, sensor, "gyr", factors)


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
    imu, time_s = _sensor(recording, sensor), recording.time_s
    # Whole samples: interpolation would make the noise of a late sensor smaller.
    steps = _steps(recording, as_number(lag_s, "lag_s", zero=True))
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
    steps = _steps(recording, as_number(lag_s, "lag_s", negative=True))
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
    one, other = _sensor(recording, first), recording.sensor(second)
    return _replaced(recording, {first: other, second: one})


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
    axis = one_of("axis", axis, (0, 1, 2))
    imu, signs = _sensor(recording, sensor), np.where(np.arange(3) == axis, -1.0, 1.0)
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
    imu = _sensor(recording, sensor)
    gyr = None if imu.gyr_radps is None else imu.gyr_radps @ rotation.T
    return _replaced(recording, {sensor: Imu(imu.acc_mps2 @ rotation.T, gyr)})


def tip(
    recording: Recording,
    sensor: str,
    axis: ArrayLike,
    angle_rad: float,
    start_s: float,
    length_s: float,
) -> Recording:
    """Recording of a sensor that is tipped over during the recording, and stays so.

    Parameters
    ----------
    recording : Recording
    sensor : name
    axis : (3,) array, in the sensor's axes, about which it is tipped
    angle_rad : rad
    start_s : s after the recording's start
    length_s : s, in which it is tipped, at one rate

    Returns
    -------
    Recording
    """
    along = as_vectors(axis, "axis", ndim=1, finite=True)
    if not along.any():
        raise InputError("axis: of length 0, expected a direction")
    angle_rad = as_number(angle_rad, "angle_rad", negative=True)
    start_s = as_number(start_s, "start_s", negative=True)
    # Near 1 by a power of 2, which moves no digit: the square of 1e200 has no number.
    along = np.ldexp(along, -int(np.frexp(np.abs(along).max())[1]))
    unit = along / np.linalg.norm(along)
    imu, time_s = _sensor(recording, sensor), recording.time_s - recording.time_s[0]
    part = np.clip((time_s - start_s) / as_number(length_s, "length_s"), 0.0, 1.0)
    back = Rotation.from_rotvec(-part[:, None] * angle_rad * unit)
    rate = np.where((part > 0) & (part < 1), angle_rad / length_s, 0.0)
    gyr = back.apply(recording.gyroscope(sensor).copy()) + rate[:, None] * unit
    return _replaced(recording, {sensor: Imu(back.apply(imu.acc_mps2.copy()), gyr)})


def jump(recording: Recording, start_s: float, length_s: float) -> Recording:
    """Recording whose clock leaps once.

    Parameters
    ----------
    recording : Recording
    start_s : s after the recording's start
    length_s : s; negative for a leap back

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        If the leap leaves a gap, or times that run backwards: then nothing reads it.
    """
    expect("recording", recording, Recording)
    start_s = as_number(start_s, "start_s", negative=True)
    time_s = recording.time_s.copy()
    time_s[time_s - time_s[0] >= start_s] += as_number(length_s, "length_s", negative=True)
    return Recording(time_s, recording.sensors, source=recording.source)


def _sensor(recording: Recording, sensor: str) -> Imu:
    expect("recording", recording, Recording)
    return recording.sensor(sensor)


def _steps(recording: Recording, lag_s: float) -> int:
    """A lag in whole samples, less than the recording has."""
    if abs(lag_s) >= recording.time_s[-1] - recording.time_s[0]:
        raise InputError(f"lag_s = {lag_s:g}: expected less than the recording's length")
    return round(lag_s * recording.sampling_rate_hz)


def _factors(factors: ArrayLike) -> FloatArray:
    found = as_floats(factors, "factors")
    if found.shape not in ((), (3,)) or not np.isfinite(found).all():
        raise InputError(f"factors = {shown(factors)}: expected one finite number, or three")
    return found


def _half(recording: Recording, sensor: str, half: str) -> FloatArray:
    one_of("half", half, ("acc", "gyr"))
    acc = _sensor(recording, sensor).acc_mps2
    values = acc if half == "acc" else recording.gyroscope(sensor)
    return values.copy()


def _with(recording: Recording, sensor: str, half: str, values: FloatArray) -> Recording:
    imu = recording.sensor(sensor)
    new = Imu(values, imu.gyr_radps) if half == "acc" else Imu(imu.acc_mps2, values)
    return _replaced(recording, {sensor: new})


def _replaced(recording: Recording, sensors: dict[str, Imu]) -> Recording:
    return Recording(recording.time_s, {**recording.sensors, **sensors}, source=recording.source)
