"""The paper's method on a path: rotation, distances and arms by the ends of tilts (eqs 3 to 19)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.walker.geometry import (
    TiltDirection,
    rotation_body_to_world,
    rotation_world_to_imu,
)
from mobility_imu.walker.navigation import Navigation
from mobility_imu.walker.tilt_detection import Tilt
from mobility_imu.walker.tilt_equations import (
    Form,
    arm_angle,
    distance_to_edge,
    forward_axis,
    quaternion_from_rotation,
    rotation_imu_to_body,
    tilt_angle,
    tilt_displacement,
    tilt_rotation,
)

__all__ = ["arms_by_velocity", "distances_by_ends", "rotation_by_ends"]


def rotation_by_ends(path: Navigation, back: Tilt) -> FloatArray:
    """IMU's rotation to the frame's axes: a tilt to the back leads straight backward.

    Parameters
    ----------
    path : Navigation
    back : Tilt

    Returns
    -------
    (3, 3) array
    """
    displacement = tilt_displacement(path.position_m[back.span.start : back.top + 1])
    body = rotation_body_to_world(forward_axis(displacement))
    return rotation_imu_to_body(body, path.quaternion[back.span.start])


def distances_by_ends(
    path: Navigation, tilts: Mapping[TiltDirection, Tilt], imu_to_body: FloatArray
) -> dict[TiltDirection, float]:
    """Distances of the IMU to the edges of some tilts, by the chords and angles between their ends.

    Parameters
    ----------
    path : Navigation
    tilts : Tilt by direction
    imu_to_body : (3, 3) array

    Returns
    -------
    dict from direction to m
    """
    distances: dict[TiltDirection, float] = {}
    for name, tilt in tilts.items():
        start = path.quaternion[tilt.span.start]
        # The frame may stand a little turned after an earlier tilt: its axes at this tilt's start.
        here = rotation_world_to_imu(start).T @ imu_to_body.T
        turned = tilt_rotation(here, path.quaternion[tilt.top], imu_to_body)
        chord = tilt_displacement(path.position_m[tilt.span.start : tilt.top + 1])
        distances[name] = distance_to_edge(
            float(np.linalg.norm(chord)), tilt_angle(quaternion_from_rotation(turned))
        )
    return distances


def arms_by_velocity(
    path: Navigation, tilts: Mapping[TiltDirection, Tilt], velocity_tilt_rad: float, form: Form
) -> dict[TiltDirection, float]:
    """Angles of the arms from the edges to the IMU, by its velocity early in some tilts.

    Parameters
    ----------
    path : Navigation
    tilts : Tilt by direction
    velocity_tilt_rad : rad, tilt at which the velocity is looked at
    form : "corrected", or "printed" as if that tilt were none

    Returns
    -------
    dict from direction to rad

    Raises
    ------
    InputError
        If a tilt does not get that far.
    """
    arms: dict[TiltDirection, float] = {}
    for name, tilt in tilts.items():
        k, theta = _early_in_tilt(path, tilt, velocity_tilt_rad)
        arms[name] = arm_angle(path.velocity_mps[k], tilt_rad=0.0 if form == "printed" else theta)
    return arms


def _early_in_tilt(path: Navigation, tilt: Tilt, wanted_rad: float) -> tuple[int, float]:
    """First sample of the movement that is tilted by the wanted angle, and its angle."""
    attitude = path.rotation_imu_to_world()[tilt.span.start : tilt.top + 1, 2]
    lean = np.arccos(np.clip(attitude @ attitude[0], -1, 1))
    beyond = np.nonzero(lean >= wanted_rad)[0]
    if not len(beyond):
        raise InputError(
            f"velocity_tilt_rad = {wanted_rad:g}: the tilt to the {tilt.direction} does not get "
            "there"
        )
    return tilt.span.start + int(beyond[0]), float(lean[beyond[0]])
