"""Errors of the sensor that no tilt shows: what is assumed of them, and what its rests say."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.runs import runs_of
from mobility_imu.walker.mount import REACH_M
from mobility_imu.walker.navigation import Navigation

__all__ = [
    "REST_WORDS",
    "SCALES_OF_ACC",
    "check_deviations",
    "off_scale",
    "scale_at_rest",
    "wrong_readings",
]

REST_WORDS = "at rest the accelerometer reads"
OFF_SCALE_TIMES = 3.0
"""Standard deviations of the mount from which on it is told that the scale which the rests show
moves it. Our choice, not swept."""
REST_SD_MPS2, USUAL_SCALE, USUAL_OFFSET_MPS2 = 0.01, 0.05, 0.1
"""Scatter of gravity's size in a rest, 1 mg, and errors of the accelerometer from which the rests
choose: 5 % of gravity and 10 mg, so that the scale is at fault, which costs more, where they leave
it open. Our choices, not swept."""
KINDS_OF_ERROR = [
    (row, *kind)
    for row in range(3)
    for kind in [
        ("offset", row),
        *((half, column) for column in range(3) for half in ("acc", "gyr")),
    ]
]
"""Errors of :func:`wrong_readings`, in its order: axis; the accelerometer's offset, or the half
that mixes in another axis; and which. With its own axis it is the scale."""
SCALES_OF_ACC = [k for k, error in enumerate(KINDS_OF_ERROR) if error[1:] == ("acc", error[0])]
"""Numbers of the recordings of :func:`wrong_readings` whose accelerometer has a wrong scale."""


def wrong_readings(
    recording: Recording, acc_bias_mps2: float, scale: float, axes_rad: float
) -> Iterator[Recording]:
    """Recordings with one error each: of a scale factor, an axis, or the accelerometer's bias.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    acc_bias_mps2 : m/s², size of the bias
    scale : 1, size of the error of a scale factor
    axes_rad : rad, by which an axis leans toward another one

    Yields
    ------
    Recording; 21 of them
    """
    acc, gyr = recording.sensor("frame").acc_mps2, recording.gyroscope("frame")
    for row, kind, column in KINDS_OF_ERROR:
        mixing, offset = np.eye(3), np.zeros(3)
        if kind == "offset":
            offset[row] = acc_bias_mps2
        else:
            mixing[row, column] += scale if row == column else axes_rad
        if kind == "gyr":
            wrong = Imu(acc, gyr @ mixing.T)
        else:
            wrong = Imu(acc @ mixing.T + offset, gyr)
        yield Recording(recording.time_s, {"frame": wrong})


def scale_at_rest(path: Navigation, recording: Recording) -> float:
    """Error of the accelerometer's scale, 1, by which the rests would read gravity's size.

    An offset, which costs hardly anything, is fitted beside it. Only rests that are tilted tell
    both apart; without them it is the scale.

    Parameters
    ----------
    path : Navigation
    recording : Recording that it is of

    Returns
    -------
    float
    """
    acc = recording.sensor("frame").acc_mps2[-len(path.time_s) :]
    means = np.array([acc[rest].mean(axis=0) for rest in runs_of(path.still)])
    size = np.linalg.norm(means, axis=1)
    rows = np.column_stack([np.full(len(size), STANDARD_GRAVITY_MPS2), means / size[:, None]])
    known = np.diag((REST_SD_MPS2 / np.array([USUAL_SCALE, *[USUAL_OFFSET_MPS2] * 3])) ** 2)
    return float(np.linalg.solve(rows.T @ rows + known, rows.T @ (size - STANDARD_GRAVITY_MPS2))[0])


def off_scale(scale: float, moved: FloatArray, place_sd: FloatArray) -> Iterator[str]:
    """Warn of an accelerometer whose scale moves the mount beyond what its sd allows.

    Parameters
    ----------
    scale : error of the accelerometer's scale, 1
    moved, place_sd : (3,) arrays, m, what it does to the position, and the stated sd of that

    Yields
    ------
    str; none if it is within the sd
    """
    times = float((np.abs(moved) / place_sd).max())
    if times > OFF_SCALE_TIMES:
        yield (
            f"{REST_WORDS} {abs(100 * scale):.1f} % too "
            f"{'much' if scale > 0 else 'little'}: if this is its scale, the IMU's position is "
            f"wrong by about {np.linalg.norm(moved):.2g} m, {times:.1f} times its stated standard "
            "deviation; calibrate the accelerometer, or use another sensor"
        )


def check_deviations(place_sd: FloatArray, turn_sd: FloatArray) -> None:
    """Check that a mount is known within what a frame reaches.

    Parameters
    ----------
    place_sd, turn_sd : (3,) arrays, m and rad, of the mount's position and rotation

    Raises
    ------
    InputError
        If one is larger: the recording shows no mount.
    """
    if not (place_sd.max() <= REACH_M and turn_sd.max() <= np.pi):
        raise InputError(
            f"the tilts leave the IMU's position uncertain by {place_sd.max():.2g} m and its axes "
            f"by {np.rad2deg(turn_sd.max()):.2g} deg (one standard deviation): no mount; is one of "
            "the sensor's axes broken, or a unit wrong?"
        )
