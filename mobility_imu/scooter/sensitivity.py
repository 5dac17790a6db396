"""What small errors do to both angles: derivatives of the three-axis form, in closed form.

Where a reading fits eq. 5 exactly, the least-squares angles move with the lever's reading f and
the prediction p = Rᵀ b by ``d angles = H⁺ (df - dp)``, with H the 3x2 derivative of p by the
angles. All below is this one line, with df or dp for a bias, a turned IMU, a wrong inclination or
an unknown slope. Every row carries 1 / K2: where the steering cannot be observed,
nothing is small any more.

Angles and body acceleration are the *estimate's*: for a single IMU the level gravity it believes
in, and the angles it reports. Mountings are rotation vectors that turn the nominal axes onto the
real ones, as in :mod:`mobility_imu.scooter.calibration`.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_floats,
    as_number,
    as_vectors,
    one_of,
    wrap_angle,
)
from mobility_imu.hinges import column_vector, turn
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.geometry import (
    ScooterGeometry,
    body_specific_force,
    lever_acceleration,
    rotation_lever_to_body,
)

__all__ = [
    "Sensitivities",
    "by_body_acceleration",
    "by_body_mounting",
    "by_lever_acceleration",
    "by_lever_inclination",
    "by_lever_mounting",
    "by_steering_inclination",
    "mirror_angles",
    "sensitivities",
    "single_imu_range",
    "steering_error_per_tilt",
    "worst_error_per_tilt",
]


class Sensitivities(NamedTuple):
    """Derivatives of (steering, throttle), second to last axis, by small errors.

    Parameters
    ----------
    lever_bias, body_bias : (..., 2, 3) arrays, rad per m/s², by what is added to a reading
    lever_mounting, body_mounting : (..., 2, 3) arrays, rad/rad, by the turn of an IMU about x, y, z
    steering_inclination, lever_inclination : (..., 2, 1) arrays, rad/rad, by a believed alpha or
        beta that is too large
    slope : (..., 2, 2) array, rad/rad, by pitch and roll of the ground
    """

    lever_bias: FloatArray
    body_bias: FloatArray
    lever_mounting: FloatArray
    body_mounting: FloatArray
    steering_inclination: FloatArray
    lever_inclination: FloatArray
    slope: FloatArray


def sensitivities(
    pitch_rad: ArrayLike,
    roll_rad: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
    *,
    imus: Literal["dual", "single"],
) -> Sensitivities:
    """Derivatives of the estimated angles of a scooter at rest on a slope.

    Parameters
    ----------
    pitch_rad, roll_rad : (...) arrays, rad, of the ground; nose up, right side up
    steering_rad, throttle_rad : (...) arrays, rad, where the controls are; all four broadcast
    geometry : ScooterGeometry
    imus : "dual", or "single": no body IMU, the ground is taken to be level

    Returns
    -------
    Sensitivities
        NaN where a single IMU saturates, infinite or NaN where K2 = 0.

    Raises
    ------
    InputError
        If ``imus`` is neither.

    Examples
    --------
    >>> from mobility_imu.scooter import SUZUKI_ET4D
    >>> straight = sensitivities(0.0, 0.0, 0.0, 0.0, SUZUKI_ET4D, imus="dual")
    >>> straight.lever_mounting[0].round(2).tolist()  # steering: 2.9 deg for 1 deg about y
    [0.0, -2.89, 0.46]
    """
    one_of("imus", imus, ("dual", "single"))
    pitch, roll, steering, throttle = np.broadcast_arrays(
        *(np.asarray(v, float) for v in (pitch_rad, roll_rad, steering_rad, throttle_rad))
    )
    force = body_specific_force(pitch, roll)
    lever = lever_acceleration(force, steering, throttle, geometry)
    by_slope = np.zeros((*pitch.shape, 2, 2))
    if imus == "dual":
        body = force
    else:
        body = np.broadcast_to([0.0, 0.0, STANDARD_GRAVITY_MPS2], force.shape)
        rotation = rotation_lever_to_body(steering, throttle, geometry)
        steering, throttle = three_axis_angles(lever, body, geometry)
        right, left = single_imu_range(pitch, roll, geometry)
        inside = (np.asarray(steering_rad) >= right) & (np.asarray(steering_rad) <= left)
        steering = np.where(inside, steering, np.nan)
        sin_p, cos_p, sin_r, cos_r = np.sin(pitch), np.cos(pitch), np.sin(roll), np.cos(roll)
        zero = np.zeros_like(pitch)
        by_pitch = np.stack([-sin_p * sin_r, cos_p, -sin_p * cos_r], axis=-1)
        by_roll = np.stack([cos_p * cos_r, zero, -cos_p * sin_r], axis=-1)
        force_by_slope = STANDARD_GRAVITY_MPS2 * np.stack([by_pitch, by_roll], axis=-1)
        by_slope = by_lever_acceleration(body, steering, throttle, geometry) @ (
            np.swapaxes(rotation, -1, -2) @ force_by_slope
        )
    pose = (body, steering, throttle, geometry)
    known = imus == "dual"
    return Sensitivities(
        lever_bias=by_lever_acceleration(*pose),
        body_bias=by_body_acceleration(*pose) * known,
        lever_mounting=by_lever_mounting(*pose),
        body_mounting=by_body_mounting(*pose) * known,
        steering_inclination=by_steering_inclination(*pose)[..., None],
        lever_inclination=by_lever_inclination(*pose)[..., None],
        slope=by_slope,
    )


def by_lever_acceleration(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Derivative of both angles by the lever's reading: H⁺, the pseudo-inverse of eq. 5's.

    With f the lever's reading and e its part across f, steering follows e's x component over K2,
    throttle follows the direction of (y, z) and, through K2, the steering.

    Parameters
    ----------
    body_acc_mps2 : (..., 3) array, m/s², in {B}, as the estimate takes it
    steering_rad, throttle_rad : (...) arrays, rad, as estimated
    geometry : ScooterGeometry

    Returns
    -------
    (..., 2, 3) array, rad per m/s²
    """
    pose = _pose(body_acc_mps2, steering_rad, throttle_rad, geometry)
    f, k1, k2 = pose.lever, pose.k1, pose.k2
    across = k1**2 + k2**2
    x_axis = np.array([1.0, 0.0, 0.0])
    with np.errstate(divide="ignore", invalid="ignore"):  # not observable: infinite or NaN
        straight = x_axis - f[..., :1] * f / (f**2).sum(axis=-1, keepdims=True)
        steering = straight / k2[..., None]
        turn = np.stack([np.zeros_like(k1), -f[..., 2], f[..., 1]], axis=-1)
        throttle = (turn - (k1 * f[..., 0])[..., None] * steering) / across[..., None]
    return np.stack([steering, throttle], axis=-2)


def by_body_acceleration(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Derivative of both angles by the body's reading: -H⁺ Rᵀ.

    Parameters
    ----------
    body_acc_mps2, steering_rad, throttle_rad, geometry : as in :func:`by_lever_acceleration`

    Returns
    -------
    (..., 2, 3) array, rad per m/s²
    """
    by_lever = by_lever_acceleration(body_acc_mps2, steering_rad, throttle_rad, geometry)
    rotation = rotation_lever_to_body(steering_rad, throttle_rad, geometry)
    return -by_lever @ np.swapaxes(rotation, -1, -2)


def by_lever_mounting(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Derivative of both angles by a turn of the lever's IMU about its x, y and z: H⁺ [f]ₓ.

    An IMU turned by a small rotation vector e reads f - e x f. About x it costs throttle one to
    one and steering nothing, at any pose.

    Parameters
    ----------
    body_acc_mps2, steering_rad, throttle_rad, geometry : as in :func:`by_lever_acceleration`

    Returns
    -------
    (..., 2, 3) array, rad/rad
    """
    f = _pose(body_acc_mps2, steering_rad, throttle_rad, geometry).lever
    by_lever = by_lever_acceleration(body_acc_mps2, steering_rad, throttle_rad, geometry)
    return np.cross(by_lever, f[..., None, :])


def by_body_mounting(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Derivative of both angles by a turn of the body's IMU about its x, y and z: -H⁺ Rᵀ [b]ₓ.

    About x it is the same as an alpha and a beta that are both too large, at any pose.

    Parameters
    ----------
    body_acc_mps2, steering_rad, throttle_rad, geometry : as in :func:`by_lever_acceleration`

    Returns
    -------
    (..., 2, 3) array, rad/rad
    """
    body = as_vectors(body_acc_mps2, "body_acc_mps2")
    by_body = by_body_acceleration(body, steering_rad, throttle_rad, geometry)
    return np.cross(by_body, body[..., None, :])


def by_steering_inclination(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Derivative of both angles by the believed alpha: -H⁺ dp/d alpha.

    Parameters
    ----------
    body_acc_mps2, steering_rad, throttle_rad, geometry : as in :func:`by_lever_acceleration`

    Returns
    -------
    (..., 2) array, rad/rad; positive where a too large alpha gives a too large angle
    """
    p = _pose(body_acc_mps2, steering_rad, throttle_rad, geometry)
    # d C1 = K1, d K1 = -C1, d K2 = K1 cos(steering), d phi = 1, each per d alpha.
    k2_slope = p.k1 * np.cos(p.steering)
    prediction = np.stack(
        [
            p.k1 * np.sin(p.steering),
            k2_slope * np.cos(p.phi) + p.c1 * np.sin(p.phi) - p.lever[..., 2],
            k2_slope * np.sin(p.phi) - p.c1 * np.cos(p.phi) + p.lever[..., 1],
        ],
        axis=-1,
    )
    by_lever = by_lever_acceleration(body_acc_mps2, steering_rad, throttle_rad, geometry)
    return -(by_lever @ prediction[..., None])[..., 0]


def by_lever_inclination(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Derivative of both angles by the believed beta: (0, 1), for beta only adds to the throttle.

    Parameters
    ----------
    body_acc_mps2, steering_rad, throttle_rad, geometry : as in :func:`by_lever_acceleration`

    Returns
    -------
    (..., 2) array, rad/rad
    """
    k2 = _pose(body_acc_mps2, steering_rad, throttle_rad, geometry).k2
    return np.where(np.isnan(k2)[..., None], np.nan, [0.0, 1.0])


def steering_error_per_tilt(
    body_acc_mps2: ArrayLike, steering_rad: ArrayLike, geometry: ScooterGeometry
) -> FloatArray:
    """Steering error by a small tilt of the lever's IMU in the worst direction: hypot(K1, K2) / K2.

    The length of the steering row of :func:`by_lever_mounting`; the throttle has no part in it.
    Divided by the acceleration it is also the error by a bias in the worst direction.

    Parameters
    ----------
    body_acc_mps2 : (..., 3) array, m/s², in {B}, as the estimate takes it
    steering_rad : (...) array, rad, as estimated
    geometry : ScooterGeometry

    Returns
    -------
    (...) array, rad/rad; infinite where K2 = 0
    """
    p = _pose(body_acc_mps2, steering_rad, 0.0, geometry)
    with np.errstate(divide="ignore"):
        return np.hypot(p.k1, p.k2) / np.abs(p.k2)


def worst_error_per_tilt(
    body_acc_mps2: ArrayLike, geometry: ScooterGeometry, *, lock_rad: float
) -> FloatArray:
    """Largest steering error by a small tilt of the lever's IMU, over all that the wheel can turn.

    It is found at a lock, unless K2 = 0 lies between the locks: there two IMUs are useless too.

    Parameters
    ----------
    body_acc_mps2 : (..., 3) array, m/s², in {B}, as the estimate takes it
    geometry : ScooterGeometry
    lock_rad : rad, the wheel turns this far to either side

    Returns
    -------
    (...) array, rad/rad; infinite where K2 = 0 lies within the wheel's range
    """
    lock = as_number(lock_rad, "lock_rad")
    ends = (-lock, lock)
    cost = np.maximum(*(steering_error_per_tilt(body_acc_mps2, end, geometry) for end in ends))
    # Where the mirror of a lock lies within the range, K2 = 0 somewhere on the way.
    for end in ends:
        mirror, _ = mirror_angles(body_acc_mps2, end, 0.0, geometry)
        cost = np.where(np.abs(mirror) < lock, np.inf, cost)
    return np.asarray(cost)


def single_imu_range(
    pitch_rad: ArrayLike, roll_rad: ArrayLike, geometry: ScooterGeometry
) -> tuple[FloatArray, FloatArray]:
    """Steering angles between which a single IMU on a slope can answer at all.

    The lever reads ``r sin(u)`` along x; an estimate that believes in level ground knows no more
    than ``g sin(alpha)``. Beyond it eq. 6 asks for the arcsine of more than 1.

    Parameters
    ----------
    pitch_rad, roll_rad : (...) arrays, rad, of the ground; nose up, right side up
    geometry : ScooterGeometry

    Returns
    -------
    right_rad, left_rad : (...) arrays, rad; -inf and inf where no steering angle saturates. They
        say nothing of the mirror: beyond ``|u| = 90 deg`` an answer comes, but of the mirror image.
    """
    expect("geometry", geometry, ScooterGeometry)
    pitch, roll = as_floats(pitch_rad, "pitch_rad"), as_floats(roll_rad, "roll_rad")
    if pitch.ndim and roll.ndim and pitch.shape != roll.shape:
        raise InputError(f"roll_rad: expected shape {pitch.shape} like pitch_rad, got {roll.shape}")
    x, c1, _ = column_vector(
        body_specific_force(pitch, roll, gravity_mps2=1.0),
        geometry.steering_inclination_rad,
    )
    ahead = np.arctan2(x, c1)
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = np.sin(geometry.steering_inclination_rad) / np.hypot(x, c1)
        most = np.where(sine < 1, np.arcsin(np.minimum(sine, 1)), np.inf)
    return -most - ahead, most - ahead


def mirror_angles(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> tuple[FloatArray, FloatArray]:
    """The other pair of angles at which the lever reads the same.

    Parameters
    ----------
    body_acc_mps2 : (..., 3) array, m/s², in {B}
    steering_rad, throttle_rad : (...) arrays, rad
    geometry : ScooterGeometry

    Returns
    -------
    steering_rad, throttle_rad : (...) arrays, rad, in [-pi, pi]

    Examples
    --------
    >>> from mobility_imu.scooter import SUZUKI_ET4D
    >>> other = mirror_angles([0.0, 0.0, 9.8], np.deg2rad(50), np.deg2rad(40), SUZUKI_ET4D)
    >>> np.rad2deg(other).round(1).tolist()
    [130.0, 13.7]
    """
    p = _pose(body_acc_mps2, steering_rad, throttle_rad, geometry)
    return (
        wrap_angle(np.pi - p.steering - 2 * np.arctan2(p.x, p.c1)),
        wrap_angle(p.throttle - 2 * np.arctan2(p.k2, p.k1)),
    )


class _Pose(NamedTuple):
    """Eq. 5 at a pose, in the paper's abbreviations."""

    steering: FloatArray
    throttle: FloatArray
    phi: FloatArray
    x: FloatArray
    c1: FloatArray
    k1: FloatArray
    k2: FloatArray
    lever: FloatArray


def _pose(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> _Pose:
    expect("geometry", geometry, ScooterGeometry)
    body = as_vectors(body_acc_mps2, "body_acc_mps2")
    alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
    angles = as_floats(steering_rad, "steering_rad"), as_floats(throttle_rad, "throttle_rad")
    try:
        steering, throttle, x, c1, k1 = np.broadcast_arrays(*angles, *column_vector(body, alpha))
    except ValueError:
        shapes = ", ".join(str(np.shape(one)) for one in (body[..., 0], *angles))
        raise InputError(
            f"body_acc_mps2, steering_rad, throttle_rad: expected one length, got shapes {shapes}"
        ) from None
    phi = throttle + alpha - beta
    lever_x, k2 = turn(x, c1, np.sin(steering), np.cos(steering))
    lever_z, lever_y = turn(k1, k2, np.sin(phi), np.cos(phi))
    lever = np.stack([lever_x, lever_y, lever_z], axis=-1)
    return _Pose(steering, throttle, phi, x, c1, k1, k2, lever)
