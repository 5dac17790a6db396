"""State of an IMU that moves, its error state, and their equations of motion (eqs 20 to 24).

World frame: z up, origin where the IMU is at the start. Quaternions are Hamilton's, scalar first,
and turn IMU components into world components. Errors are true minus estimated.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_number, as_vectors, one_of
from mobility_imu.rotations import cross_matrix
from mobility_imu.walker.geometry import rotation_world_to_imu

__all__ = [
    "GRAVITY_MPS2",
    "STATES",
    "Form",
    "NavigationState",
    "corrected_state",
    "error_dynamics",
    "imu_output",
    "interval_means",
    "state_error",
    "step_transition",
    "strapdown_rates",
]

Form = Literal["corrected", "printed"]
FORMS: tuple[Form, ...] = ("corrected", "printed")

STATES = ("attitude", "gyr_bias", "position", "velocity", "acc_bias")
"""Order of the error state (eq. 23), each with three components."""
ATTITUDE, GYR_BIAS, POSITION, VELOCITY, ACC_BIAS = (slice(k, k + 3) for k in range(0, 15, 3))

GRAVITY_MPS2: FloatArray = np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2])
"""The vector g of eq. 21. It must point up, or a resting accelerometer would read downward."""
GRAVITY_MPS2.setflags(write=False)

_EYE3, _EYE15 = np.eye(3), np.eye(15)


class NavigationState(NamedTuple):
    """State of an IMU.

    Parameters
    ----------
    quaternion : (4,) array, Hamilton, scalar first, IMU to world
    position_m, velocity_mps : (3,) arrays, world
    gyr_bias_radps, acc_bias_mps2 : (3,) arrays, IMU's axes
    """

    quaternion: FloatArray
    position_m: FloatArray
    velocity_mps: FloatArray
    gyr_bias_radps: FloatArray
    acc_bias_mps2: FloatArray


def interval_means(
    acc_mps2: ArrayLike, gyr_radps: ArrayLike, dt_s: float
) -> tuple[FloatArray, FloatArray]:
    """Means over the intervals around the samples, from values at the samples.

    To second order in the interval: the rate's mean with its coning term, and the force turned by
    what the attitude in the middle differs from that after half of the mean rate. Without this a
    tilt of 30 deg leaves 0.1 mm at 100 Hz, a rectangle of 17.5 m some millimetres.

    Parameters
    ----------
    acc_mps2, gyr_radps : (n, 3) arrays, in the IMU's axes
    dt_s : s, between two samples

    Returns
    -------
    (n, 3), (n, 3) arrays : m/s² and rad/s
    """
    dt = as_number(dt_s, "dt_s")
    force = np.array(as_vectors(acc_mps2, "acc_mps2", ndim=2))
    rate = np.array(as_vectors(gyr_radps, "gyr_radps", length=len(force)))
    if len(force) < 3:
        return force, rate
    acc, gyr = force[1:-1].T.copy(), rate.T.copy()  # components first: whole rows are fast
    slope, middle = (gyr[:, 2:] - gyr[:, :-2]) / 2, gyr[:, 1:-1]
    coning = dt / 12 * _cross_product(middle, slope)
    rate[1:-1] += ((gyr[:, 2:] - 2 * middle + gyr[:, :-2]) / 24 + coning).T
    force[1:-1] -= (dt / 8 * _cross_product(slope, acc)).T
    return force, rate


def _cross_product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of vectors in columns."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def strapdown_rates(
    quaternion: ArrayLike, velocity_mps: ArrayLike, rate_radps: ArrayLike, acc_imu_mps2: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rates of attitude, velocity and position of an IMU (eq. 20).

    Parameters
    ----------
    quaternion : (4,) array, Hamilton, scalar first, IMU to world
    velocity_mps : (3,) array, m/s, world
    rate_radps : (3,) array, rad/s, of the IMU against the world, in the IMU's axes
    acc_imu_mps2 : (3,) array, m/s², acceleration without gravity, in the IMU's axes

    Returns
    -------
    (4,), (3,), (3,) arrays : time derivatives of quaternion, velocity and position
    """
    w1, w2, w3 = as_vectors(rate_radps, "rate_radps", ndim=1)
    matrix = np.array([[0, -w1, -w2, -w3], [w1, 0, w3, -w2], [w2, -w3, 0, w1], [w3, w2, -w1, 0]])
    to_world = rotation_world_to_imu(quaternion).T
    return (
        0.5 * matrix @ np.asarray(quaternion, float),
        to_world @ as_vectors(acc_imu_mps2, "acc_imu_mps2", ndim=1),
        np.array(as_vectors(velocity_mps, "velocity_mps", ndim=1)),
    )


def imu_output(
    state: NavigationState, acc_world_mps2: ArrayLike, rate_radps: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Readings of accelerometer and gyroscope, white noise aside (eq. 21).

    Parameters
    ----------
    state : NavigationState
    acc_world_mps2 : (3,) array, m/s², acceleration in the world
    rate_radps : (3,) array, rad/s, in the IMU's axes

    Returns
    -------
    (3,), (3,) arrays : specific force in m/s² and rate in rad/s; at rest and upright +9.81 along z
    """
    to_imu = rotation_world_to_imu(state.quaternion)
    force = to_imu @ (as_vectors(acc_world_mps2, "acc_world_mps2", ndim=1) + GRAVITY_MPS2)
    rate = as_vectors(rate_radps, "rate_radps", ndim=1)
    return force + state.acc_bias_mps2, rate + state.gyr_bias_radps


def state_error(true: NavigationState, estimate: NavigationState) -> FloatArray:
    """Error state of an estimate, true minus estimated (eqs 22-23).

    Parameters
    ----------
    true, estimate : NavigationState

    Returns
    -------
    (15,) array in the order of STATES; the attitude's part is half the rotation vector, rad
    """
    w, x, y, z = estimate.quaternion
    vector_part = np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    return np.concatenate(
        [
            vector_part @ true.quaternion,
            true.gyr_bias_radps - estimate.gyr_bias_radps,
            true.position_m - estimate.position_m,
            true.velocity_mps - estimate.velocity_mps,
            true.acc_bias_mps2 - estimate.acc_bias_mps2,
        ]
    )


def corrected_state(estimate: NavigationState, error: FloatArray) -> NavigationState:
    """State with its estimated error taken off: eqs 22-23 solved for the true state.

    Parameters
    ----------
    estimate : NavigationState
    error : (15,) array in the order of STATES; the attitude's part is half a rotation vector, rad

    Returns
    -------
    NavigationState
    """
    q = _product(estimate.quaternion, np.concatenate([[1.0], error[ATTITUDE]]))
    return NavigationState(
        q / math.sqrt(q @ q),
        estimate.position_m + error[POSITION],
        estimate.velocity_mps + error[VELOCITY],
        estimate.gyr_bias_radps + error[GYR_BIAS],
        estimate.acc_bias_mps2 + error[ACC_BIAS],
    )


def error_dynamics(
    quaternion: ArrayLike, rate_radps: ArrayLike, force_mps2: ArrayLike, *, form: Form = "corrected"
) -> FloatArray:
    """Matrix A of the error state's differential equation (eq. 24).

    Our text copy has +1/2 where the gyroscope's bias acts on the attitude, and nothing where the
    accelerometer's bias acts on the velocity. Eqs 20 to 22 give -1/2 and -C'(q). The plus is right
    if the state holds minus the bias of eq. 21; a sign or an entry may also be lost in the copy.

    Parameters
    ----------
    quaternion : (4,) array, Hamilton, scalar first, IMU to world
    rate_radps : (3,) array, rad/s, gyroscope less its estimated bias
    force_mps2 : (3,) array, m/s², accelerometer less its estimated bias
    form : "corrected", or "printed" for what our text copy has

    Returns
    -------
    (15, 15) array, blocks in the order of STATES
    """
    one_of("form", form, FORMS)
    to_world = rotation_world_to_imu(quaternion).T
    a = np.zeros((15, 15))
    a[ATTITUDE, ATTITUDE] = -cross_matrix(rate_radps)
    a[ATTITUDE, GYR_BIAS] = (0.5 if form == "printed" else -0.5) * _EYE3
    a[POSITION, VELOCITY] = _EYE3
    a[VELOCITY, ATTITUDE] = -2 * to_world @ cross_matrix(force_mps2)
    if form == "corrected":
        a[VELOCITY, ACC_BIAS] = -to_world
    return a


def step_transition(
    state: NavigationState,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    dt_s: float,
    *,
    form: Form = "corrected",
) -> tuple[NavigationState, FloatArray]:
    """State after one interval and its derivative: eqs 20, 21 and 24 integrated over the interval.

    Parameters
    ----------
    state : NavigationState before the interval
    acc_mps2, gyr_radps : (3,) arrays, mean readings over the interval
    dt_s : s
    form : of eq. 24, "corrected" or "printed"

    Returns
    -------
    NavigationState after the interval, and the (15, 15) transition matrix of small errors
    """
    acc = as_vectors(acc_mps2, "acc_mps2", ndim=1, finite=True)
    gyr = as_vectors(gyr_radps, "gyr_radps", ndim=1, finite=True)
    one_of("form", form, FORMS)
    return strapdown_step(state, acc, gyr, as_number(dt_s, "dt_s"), form=form)


def strapdown_step(
    state: NavigationState,
    acc: FloatArray,
    gyr: FloatArray,
    dt: float,
    *,
    form: Form = "corrected",
    motion_fraction: float = 1.0,
) -> tuple[NavigationState, FloatArray]:
    """As :func:`step_transition`, unchecked; only a fraction of the rate may count as motion.

    Rate and force are constant in the interval. The force acts at the attitude in its middle:
    first half a turn, then the velocity, then the other half.
    """
    turn = motion_fraction * dt * (gyr - state.gyr_bias_radps)  # rotation vector p
    force = acc - state.acc_bias_mps2  # f
    half = _quaternion(turn / 2)
    middle = _product(state.quaternion, half)
    to_world = _matrix(middle)  # C'(q) in the middle of the interval
    quaternion = _product(middle, half)
    gain = dt * (to_world @ force - GRAVITY_MPS2)  # of velocity
    after = NavigationState(
        quaternion / math.sqrt(quaternion @ quaternion),
        state.position_m + dt * (state.velocity_mps + gain / 2),
        state.velocity_mps + gain,
        state.gyr_bias_radps,
        state.acc_bias_mps2,
    )

    sign, coupling = (1.0, 0.0) if form == "printed" else (-1.0, 1.0)
    p_cross = _cross(turn)
    half_back = _matrix(half).T
    phi = _EYE15.copy()
    phi[ATTITUDE, ATTITUDE] = half_back @ half_back
    # A bias acts on the attitude through the right Jacobian 1 - [p x] / 2 + [p x]² / 6.
    bias_gain = sign * motion_fraction * dt / 2
    phi[ATTITUDE, GYR_BIAS] = bias_gain * (_EYE3 - p_cross / 2 + p_cross @ p_cross / 6)
    # -2 C'(q) [f x] acts on the attitude error of the interval's middle.
    tilt_gain = -2 * dt * to_world @ _cross(force)
    velocity = np.zeros((3, 15))
    velocity[:, ATTITUDE] = tilt_gain @ half_back
    velocity[:, GYR_BIAS] = bias_gain / 2 * tilt_gain @ (_EYE3 - p_cross / 4)
    velocity[:, ACC_BIAS] = -coupling * dt * to_world
    phi[VELOCITY] += velocity
    phi[POSITION] += dt / 2 * velocity
    phi[POSITION, VELOCITY] += dt * _EYE3
    return after, phi


def _quaternion(rotation_vector: FloatArray) -> FloatArray:
    """Quaternion of a rotation vector."""
    x, y, z = rotation_vector.tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    s = math.sin(angle / 2) / angle if angle > 1e-8 else 0.5
    return np.array([math.cos(angle / 2), s * x, s * y, s * z])


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Product of two quaternions."""
    w, x, y, z = a.tolist()
    c, i, j, k = b.tolist()
    return np.array(
        [
            w * c - x * i - y * j - z * k,
            w * i + x * c + y * k - z * j,
            w * j - x * k + y * c + z * i,
            w * k + x * j - y * i + z * c,
        ]
    )


def _matrix(q: FloatArray) -> FloatArray:
    """Matrix of a unit quaternion, IMU to world: eq. 1 transposed, for one attitude and fast."""
    w, x, y, z = q.tolist()
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def _cross(v: FloatArray) -> FloatArray:
    """As :func:`mobility_imu.rotations.cross_matrix`, without its checks: called at each sample."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
