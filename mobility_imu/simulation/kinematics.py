"""Rates and accelerations of a motion that is given as positions and orientations."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray


def second_derivative(values: FloatArray, dt: float) -> FloatArray:
    """Second time derivative by central differences.

    Summed up twice it gives back the values, whatever the step.

    Parameters
    ----------
    values : (n, ...) array, at even times
    dt : s, between them

    Returns
    -------
    (n, ...) array, per s²; the first and the last repeat their neighbours; three times at least

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
    axes : (n, 3, 3) array, sensor to world, at even times; turns of well under 180 deg per step
    dt : s, between them

    Returns
    -------
    (n, 3) array, rad/s
    """
    steps = np.swapaxes(axes[:-1], 1, 2) @ axes[1:]
    turns = _rotation_vectors(steps) / dt
    return np.concatenate([turns[:1], (turns[1:] + turns[:-1]) / 2, turns[-1:]])


def _rotation_vectors(rotations: FloatArray) -> FloatArray:
    """Rotation vectors, (n, 3), rad, of small turns, (n, 3, 3), by their antisymmetric part.

    SciPy's ``Rotation`` gives the same to the last digit, for any turn, in seven times as long.
    """
    across = np.column_stack(
        [rotations[:, j, i] - rotations[:, i, j] for i, j in ((1, 2), (2, 0), (0, 1))]
    )
    twice_sine = np.linalg.norm(across, axis=1)
    angle = np.arctan2(twice_sine, np.trace(rotations, axis1=1, axis2=2) - 1)
    factor = np.divide(angle, twice_sine, out=np.ones_like(angle), where=twice_sine > 0)
    return np.asarray(across * factor[:, None])


def felt_by_imu(
    position_m: FloatArray, rotation_imu_to_world: FloatArray, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Specific force and rate that an ideal IMU measures on its path.

    Parameters
    ----------
    position_m : (n, 3) array, m, the IMU in the world, z up, at even times
    rotation_imu_to_world : (n, 3, 3) array
    dt : s, between the times

    Returns
    -------
    (n, 3) array, m/s², and (n, 3) array, rad/s, both in the IMU's axes
    """
    force = second_derivative(position_m, dt)
    force[:, 2] += STANDARD_GRAVITY_MPS2
    acc = np.einsum("nij,ni->nj", rotation_imu_to_world, force)
    return acc, angular_rates(rotation_imu_to_world, dt)
