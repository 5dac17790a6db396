"""How parked poses miss eq. 5, to first order: by errors of sensors, mounts, inclinations, angles.

A pose is judged by directions: an error of a reading along itself changes nothing.
"""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.scooter.geometry import (
    ScooterGeometry,
    lever_acceleration,
    rotation_lever_to_body,
)

__all__ = ["ERRORS", "by_errors", "by_set_angles", "set_covariance"]

ERRORS = 32
"""Errors that all poses share, see :func:`by_errors`."""
STEP_RAD = 1e-5
"""Step of numerical derivatives."""


def by_errors(poses: FloatArray, body: FloatArray, geometry: ScooterGeometry) -> FloatArray:
    """By how much the lever's direction misses eq. 5 for each error that poses share.

    Parameters
    ----------
    poses : (n, 2) array, rad, steering and throttle
    body : (n, 3) array, gravity in {B}, of any length
    geometry : ScooterGeometry

    Returns
    -------
    (n, 3, 32) array
        Columns: turns of lever and body; offset (in units of gravity) and, row by row, axes of the
        lever's accelerometer, then of the body's; alpha and beta
    """
    steering, throttle = poses.T
    body = body / np.linalg.norm(body, axis=-1, keepdims=True)
    rotation = rotation_lever_to_body(steering, throttle, geometry)
    lever = lever_acceleration(body, steering, throttle, geometry)
    to_lever = _across(lever)
    to_body = -np.swapaxes(rotation, -1, -2) @ _across(body)
    parts = (
        np.cross(to_lever, lever[:, None, :]),
        np.cross(to_body, body[:, None, :]),
        to_lever @ _sensor_errors(lever),
        to_body @ _sensor_errors(body),
        to_lever @ _by_inclinations(poses, body, geometry),
    )
    return np.concatenate(parts, axis=-1)


def _across(directions: FloatArray) -> FloatArray:
    """Matrix that takes off the part along a direction, (n, 3, 3)."""
    return np.asarray(np.eye(3) - directions[:, :, None] * directions[:, None, :])


def _sensor_errors(directions: FloatArray) -> FloatArray:
    """Change of a reading by its offset (three columns) and by its axes (nine), (n, 3, 12)."""
    count = len(directions)
    offset = np.broadcast_to(np.eye(3), (count, 3, 3))
    axes = np.einsum("ik,nj->nikj", np.eye(3), directions).reshape(count, 3, 9)
    return np.concatenate([offset, axes], axis=-1)


def _by_inclinations(poses: FloatArray, body: FloatArray, geometry: ScooterGeometry) -> FloatArray:
    """Minus the change of eq. 5's prediction by alpha and by beta, (n, 3, 2)."""
    believed = np.array([geometry.steering_inclination_rad, geometry.lever_inclination_rad])
    columns = []
    for step in STEP_RAD * np.eye(2):
        ahead, behind = (
            lever_acceleration(
                body, poses[:, 0], poses[:, 1], ScooterGeometry(*inclinations.tolist())
            )
            for inclinations in (believed + step, believed - step)
        )
        columns.append((behind - ahead) / (2 * STEP_RAD))
    return np.stack(columns, axis=-1)


def by_set_angles(poses: FloatArray, body: FloatArray, geometry: ScooterGeometry) -> FloatArray:
    """Change of eq. 5's prediction by steering and throttle.

    Parameters
    ----------
    poses : (n, 2) array, rad, steering and throttle
    body : (n, 3) array, gravity in {B}
    geometry : ScooterGeometry

    Returns
    -------
    (n, 3, 2) array
    """
    columns = []
    for step in STEP_RAD * np.eye(2):
        ahead, behind = (
            lever_acceleration(body, moved[:, 0], moved[:, 1], geometry)
            for moved in (poses + step, poses - step)
        )
        columns.append((ahead - behind) / (2 * STEP_RAD))
    return np.stack(columns, axis=-1)


def set_covariance(poses: FloatArray, common_sd: float, own_sd: float) -> FloatArray:
    """Covariance of set angles: an error of each angle of the scale, and a new one in each pose.

    Parameters
    ----------
    poses : (n, 2) array, rad, steering and throttle
    common_sd : rad, of what comes back wherever the same angle is set
    own_sd : rad, of what each pose has of its own

    Returns
    -------
    (2n, 2n) array, rad²; steering and throttle of the first pose, then of the second
    """
    rounded, size = poses.round(6), poses.size
    covariance = own_sd**2 * np.eye(size)
    for control in range(2):
        same = rounded[:, None, control] == rounded[None, :, control]
        covariance[control::2, control::2] += common_sd**2 * same
    return covariance
