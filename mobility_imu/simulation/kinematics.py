"""Rates and accelerations of a motion that is given as positions and orientations."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import FloatArray


def second_derivative(values: FloatArray, dt: float) -> FloatArray:
    """Second time derivative by central differences.

    Summed up twice it gives back the values, whatever the step.

    Parameters
    ----------
    values : (n, ...) array, at even times
    dt : s, between them

    Returns
    -------
    (n, ...) array, per s²; the first and the last repeat their neighbours

    Examples
    --------
    >>> second_derivative(np.array([0.0, 1.0, 4.0, 9.0]), 1.0).tolist()
    [2.0, 2.0, 2.0, 2.0]
    """
    inner = (values[2:] - 2 * values[1:-1] + values[:-2]) / dt**2
    return np.concatenate([inner[:1], inner, inner[-1:]])


def angular_rates(axes: FloatArray, dt: float) -> FloatArray:
    """Angular rate in the sensor's axes from its orientation, centred differences.

    Parameters
    ----------
    axes : (n, 3, 3) array, sensor to world, at even times; turns of under 90 deg per step
    dt : s, between them

    Returns
    -------
    (n, 3) array, rad/s
    """
    step = np.swapaxes(axes[:-1], 1, 2) @ axes[1:]
    # Rodrigues: the skew part of a rotation matrix is sin(angle) times its axis.
    skew = np.stack(
        [
            step[:, 2, 1] - step[:, 1, 2],
            step[:, 0, 2] - step[:, 2, 0],
            step[:, 1, 0] - step[:, 0, 1],
        ],
        axis=1,
    )
    sine = np.linalg.norm(skew, axis=1, keepdims=True) / 2
    turns = skew / 2 / np.sinc(np.arcsin(np.minimum(sine, 1)) / np.pi) / dt
    return np.concatenate([turns[:1], (turns[1:] + turns[:-1]) / 2, turns[-1:]])
