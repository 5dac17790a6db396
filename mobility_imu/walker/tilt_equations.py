"""Equations 3 to 19 of Doan & Pham: from a tilted frame to the place of its IMU."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_floats, as_number, as_rotation, as_vectors, one_of
from mobility_imu.walker.geometry import (
    TILT_DIRECTIONS,
    TiltDirection,
    WalkerGeometry,
    rotation_world_to_imu,
)

__all__ = [
    "Form",
    "arm_angle",
    "distance_to_edge",
    "forward_axis",
    "imu_height",
    "position_four_tilts",
    "position_gain",
    "position_two_tilts",
    "quaternion_from_rotation",
    "rotation_imu_to_body",
    "tilt_angle",
    "tilt_displacement",
    "tilt_quaternion",
    "tilt_rotation",
]

Form = Literal["corrected", "printed"]
"""The equations as we correct them, or as they are printed."""
_FORMS: tuple[Form, ...] = ("corrected", "printed")
LARGE = 1e100
"""Numbers above it are made smaller before they are squared, where only their ratio counts."""


def tilt_displacement(position_m: ArrayLike) -> FloatArray:
    """Displacement of the IMU in a tilt, from its end to its start (eq. 3).

    The paper counts samples by i here and tilts by i later; the difference is r_1 - r_N of one
    tilt. In a backward tilt it points forward.

    Parameters
    ----------
    position_m : (n, 3) array, m, world, from the first to the last sample of the tilting movement;
        two samples or more

    Returns
    -------
    (3,) array, m
    """
    position = as_vectors(position_m, "position_m", ndim=2)
    if len(position) < 2:
        raise InputError(f"position_m: {len(position)} sample(s), expected both ends of a tilt")
    with np.errstate(over="ignore"):  # beyond the largest number is infinity
        return np.asarray(position[0] - position[-1])


def forward_axis(displacement_m: ArrayLike) -> FloatArray:
    """Forward axis of the frame in the world, from a backward tilt (eqs 4-5).

    Parameters
    ----------
    displacement_m : (3,) array, m, world, see :func:`tilt_displacement`

    Returns
    -------
    (3,) array, horizontal unit vector
    """
    x, y, _ = as_vectors(displacement_m, "displacement_m", ndim=1)
    with np.errstate(over="ignore"):  # what overflows is refused
        length = float(np.hypot(x, y))
    if length == np.inf:
        raise InputError("displacement_m: too large to have a direction")
    if not length > 1e-6:
        raise InputError("displacement_m: no horizontal part, so no forward direction")
    return np.array([x / length, y / length, 0.0])


def rotation_imu_to_body(rotation_body_to_world: ArrayLike, quaternion: ArrayLike) -> FloatArray:
    """IMU to body, from the body's axes and the attitude at the same moment (eq. 7).

    (C_b1^w)^T C'(q_1). Our text copy lacks the first transpose, and names the result, which turns
    IMU components into body components, the other way round; the print may be right.

    Parameters
    ----------
    rotation_body_to_world : (3, 3) array
    quaternion : (4,) array, Hamilton, scalar first, IMU to world

    Returns
    -------
    (3, 3) array
    """
    to_world = rotation_world_to_imu(_one_quaternion(quaternion)).T
    return np.asarray(as_rotation(rotation_body_to_world, "rotation_body_to_world").T @ to_world)


def tilt_rotation(
    rotation_body_to_world: ArrayLike, quaternion: ArrayLike, imu_to_body: ArrayLike
) -> FloatArray:
    """Body at the end of a tilt to body at its start (eqs 8-9).

    Parameters
    ----------
    rotation_body_to_world : (3, 3) array, at the start of the tilt
    quaternion : (4,) array, IMU to world at the end of the tilt
    imu_to_body : (3, 3) array, see :func:`rotation_imu_to_body`

    Returns
    -------
    (3, 3) array
    """
    imu_at_end = rotation_imu_to_body(rotation_body_to_world, quaternion)
    return np.asarray(imu_at_end @ as_rotation(imu_to_body, "imu_to_body").T)


def quaternion_from_rotation(rotation: ArrayLike) -> FloatArray:
    """Quaternion of a rotation matrix, scalar first (eq. 10).

    As printed the vector part has the sign for the transposed matrix, one in the sense of eq. 1;
    eq. 12 takes no notice of it. The form fails near half a turn, where the scalar part is 0;
    tilts do not get there.

    Parameters
    ----------
    rotation : (3, 3) array

    Returns
    -------
    (4,) array
    """
    c = as_rotation(rotation, "rotation")
    scalar = 0.5 * np.sqrt(max(np.trace(c) + 1, 0.0))
    if scalar < 0.05:
        raise InputError("rotation: eq. 10 does not hold near half a turn")
    vector = np.array([c[2, 1] - c[1, 2], c[0, 2] - c[2, 0], c[1, 0] - c[0, 1]])
    return np.concatenate([[scalar], vector / (4 * scalar)])


def tilt_quaternion(axis: ArrayLike, angle_rad: float) -> FloatArray:
    """Quaternion of a tilt by an angle about an axis (eq. 11).

    Parameters
    ----------
    axis : (3,) array, unit vector; +y for a tilt to the front, -y back, +x right, -x left
    angle_rad : rad

    Returns
    -------
    (4,) array, scalar first
    """
    direction = as_vectors(axis, "axis", ndim=1, finite=True)
    half = as_number(angle_rad, "angle_rad", negative=True) / 2
    return np.concatenate([[np.cos(half)], np.sin(half) * direction])


def tilt_angle(quaternion: ArrayLike, *, form: Form = "corrected") -> float:
    """Angle of a tilt, without sign, rad (eq. 12).

    Near 0 the printed arc cosine magnifies rounding and noise; the arc tangent does not.

    Parameters
    ----------
    quaternion : (4,) array, scalar first
    form : "corrected" (arc tangent) or "printed" (arc cosine)
    """
    q = _one_quaternion(quaternion)
    if one_of("form", form, _FORMS) == "printed":
        return float(2 * np.arccos(np.clip(q[0], -1, 1)))
    size = np.abs(q).max()
    if LARGE < size < np.inf:  # only the ratio counts
        q = q / size
    return float(2 * np.arctan2(np.linalg.norm(q[1:]), abs(q[0])))


def distance_to_edge(displacement_m: float, angle_rad: float) -> float:
    """Distance of the IMU from the edge that the frame is tilted about, m (eq. 13).

    Parameters
    ----------
    displacement_m : m, length of the chord between the two ends of the arc
    angle_rad : rad, angle between them
    """
    angle = as_number(angle_rad, "angle_rad")
    chord = as_number(displacement_m, "displacement_m", zero=True)
    with np.errstate(over="ignore"):  # beyond the largest number is infinity
        return float(chord / (2 * np.sin(angle / 2)))


def imu_height(distances_m: Mapping[TiltDirection, float], geometry: WalkerGeometry) -> float:
    """Height of the IMU over the floor from its distances to the four edges, m (eq. 14).

    The mean of the heights of two triangles, each by Heron's formula. It needs the footprint's
    width and length, which the paper lists in its procedure.

    Parameters
    ----------
    distances_m : m, per direction of tilt: front d1, back d2, right d3, left d4
    geometry : WalkerGeometry

    Raises
    ------
    InputError
        If two distances do not reach across the footprint, so that there is no such triangle.
    """
    expect("geometry", geometry, WalkerGeometry)
    distances = _four_distances(distances_m)
    total = 0.0
    sides: tuple[tuple[float, TiltDirection, TiltDirection], ...] = (
        (geometry.footprint_width_m, "right", "left"),
        (geometry.footprint_length_m, "front", "back"),
    )
    for base, one, other in sides:
        a, b = distances[one], distances[other]
        p = (base + a + b) / 2
        square = p * (p - base) * (p - a) * (p - b)
        if square < 0:
            raise InputError(
                f"distances to the {one} and {other} edges, {a:.3f} and {b:.3f} m, make no "
                f"triangle over {base:.3f} m: eq. 14 gives no height"
            )
        total += np.sqrt(square) / base
    return float(total)


def position_four_tilts(
    distances_m: Mapping[TiltDirection, float],
    geometry: WalkerGeometry,
    *,
    form: Form = "corrected",
) -> FloatArray:
    """Position of the IMU in the body frame from four tilts (eq. 15).

    The printed roots hold for 0 <= x and abs(y) <= width / 2, as in all of the paper's poses.
    Elsewhere they lose the sign, and they magnify errors where x or the distance to a side is
    small. The differences of squares do neither.

    Parameters
    ----------
    distances_m : m, per direction of tilt
    geometry : WalkerGeometry
    form : "corrected" (differences of squares) or "printed" (roots)

    Returns
    -------
    (3,) array, m

    Raises
    ------
    InputError
        If a root of the printed form has no real value.
    """
    one_of("form", form, _FORMS)
    height = imu_height(distances_m, geometry)
    d1, d2, d3, d4 = (distances_m[name] for name in TILT_DIRECTIONS)
    if form == "printed":
        squares = np.array([d2**2, d3**2, d4**2]) - height**2
        if (squares < 0).any():
            raise InputError(
                f"eq. 15 as printed: the height {height:.3f} m is more than the distance to the "
                f"{('back', 'right', 'left')[int(np.argmin(squares))]} edge; use the corrected form"
            )
        x, right, left = np.sqrt(squares)
        return np.array([x, (right - left) / 2, height])
    width, length = geometry.footprint_width_m, geometry.footprint_length_m
    return np.array(
        [(d2**2 - d1**2 + length**2) / (2 * length), (d3**2 - d4**2) / (2 * width), height]
    )


def arm_angle(velocity_mps: ArrayLike, *, tilt_rad: float = 0.0) -> float:
    """Angle of the arm from edge to IMU against the vertical, rad (eqs 16-17).

    At the start of a tilt the IMU moves at right angles to the arm. At the very start there is no
    velocity, and the paper does not say when its "initial velocity" is taken. Later, at a tilt of
    theta, the arm has turned by theta, which has to be added back.

    Parameters
    ----------
    velocity_mps : (3,) array, m/s, world
    tilt_rad : rad, tilt at that moment; 0 for the printed form, which is exact at the very start
    """
    velocity = as_vectors(velocity_mps, "velocity_mps", ndim=1)
    size = np.abs(velocity).max()
    if LARGE < size < np.inf:  # only the direction counts
        velocity = velocity / size
    speed = float(np.linalg.norm(velocity))
    if not speed > 0:
        raise InputError("velocity_mps: zero, so without a direction")
    beta = np.arccos(np.clip(velocity[2] / speed, -1, 1))
    return float(np.pi / 2 - beta + as_number(tilt_rad, "tilt_rad", negative=True))


def position_two_tilts(
    distance_back_m: float,
    distance_right_m: float,
    arm_back_rad: float,
    arm_right_rad: float,
    footprint_width_m: float,
) -> FloatArray:
    """Position of the IMU in the body frame from a backward and a rightward tilt (eqs 18-19).

    Parameters
    ----------
    distance_back_m, distance_right_m : m, d2 and d3
    arm_back_rad, arm_right_rad : rad, gamma_2 and gamma_3, see :func:`arm_angle`
    footprint_width_m : m, CD

    Returns
    -------
    (3,) array, m
    """
    for name, distance in (("back", distance_back_m), ("right", distance_right_m)):
        as_number(distance, f"distance_{name}_m")
    for name, angle in (("back", arm_back_rad), ("right", arm_right_rad)):
        as_number(angle, f"arm_{name}_rad", negative=True)
    as_number(footprint_width_m, "footprint_width_m")
    return np.array(
        [
            distance_back_m * np.sin(arm_back_rad),
            distance_right_m * np.sin(arm_right_rad) - footprint_width_m / 2,
            (distance_back_m * np.cos(arm_back_rad) + distance_right_m * np.cos(arm_right_rad)) / 2,
        ]
    )


def position_gain(
    distances_m: Mapping[TiltDirection, float],
    geometry: WalkerGeometry,
    *,
    form: Form = "corrected",
) -> FloatArray:
    """How much an error of the distances grows in each component of eq. 15: row norms of its slope.

    Parameters
    ----------
    distances_m, geometry, form : as in :func:`position_four_tilts`

    Returns
    -------
    (3,) array, m per m
    """
    step, known = 1e-6, _four_distances(distances_m)

    def moved(name: TiltDirection, by: float) -> FloatArray:
        return position_four_tilts({**known, name: known[name] + by}, geometry, form=form)

    slopes = [(moved(name, step) - moved(name, -step)) / (2 * step) for name in TILT_DIRECTIONS]
    return np.asarray(np.linalg.norm(slopes, axis=0))


def _one_quaternion(quaternion: ArrayLike) -> FloatArray:
    """One quaternion, checked for its shape; its length is checked where it becomes a matrix."""
    q = as_floats(quaternion, "quaternion")
    if q.shape != (4,):
        raise InputError(f"quaternion: expected shape (4,), got {q.shape}")
    return q


def _four_distances(distances_m: Mapping[TiltDirection, float]) -> dict[TiltDirection, float]:
    """Distances to all four edges, each a positive number."""
    expect("distances_m", distances_m, Mapping)
    missing = [name for name in TILT_DIRECTIONS if name not in distances_m]
    if missing:
        raise InputError(f"distances_m: no distance to the {', '.join(missing)} edge")
    return {
        name: as_number(distances_m[name], f"distances_m[{name!r}]") for name in TILT_DIRECTIONS
    }
