"""Where the IMU goes: strapdown integration with an error-state Kalman filter and smoother.

World frame: z up, origin where the IMU is at the start. Its heading is a matter of choice: here
the IMU is brought upright by the shortest turn. (The paper lays x in the vertical plane of the
IMU's x axis, which fails where that axis is vertical, as it nearly is in its third mounting.)

A reading is taken for the value at its time. The filter steps from midpoint to midpoint between
samples, with the means over these intervals; what is given out is brought back to the samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_series, as_vectors
from mobility_imu.walker.geometry import rotation_world_to_imu

STATES = ("attitude", "gyr_bias", "position", "velocity", "acc_bias")
"""Order of the error state (eq. 23), each with three components."""
GRAVITY_MPS2 = np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2])
"""The vector g of eq. 21. It must point up, or a resting accelerometer would read downward."""

_DEG = float(np.deg2rad(1))
# Where the sensor was cut off, this much noise (m/s² per sample) says that nothing is known.
CUT_ACC_SD_MPS2 = 20.0


@dataclass(frozen=True)
class NavigationSettings:
    """What the filter takes for granted. The first two are the MTi-1's data sheet.

    Parameters
    ----------
    gyr_noise_radps_sqrthz : rad/s/sqrt(Hz), density of the gyroscope's noise
    acc_noise_mps2_sqrthz : m/s²/sqrt(Hz), density of the accelerometer's noise
    gyr_noise_factor, acc_noise_factor : 1, the filter's noise over the sensor's; more than 1 stands
        in for what is not white noise (scale factor, misalignment, sampling)
    gyr_bias_walk : rad/s per square root of s, how fast the bias may wander
    acc_bias_walk : m/s² per square root of s
    gyr_bias_sd_radps : rad/s, doubt of the bias at the start beyond that of the mean
    acc_bias_sd_mps2 : m/s², bias at the start; the first attitude errs with it
    velocity_noise : m/s per square root of Hz, of a frame that stands: zero-velocity update
    height_noise : m per square root of Hz, of the floor: zero-height update
    rate_noise : rad/s per square root of Hz, of a frame that stands: zero-rate update
    upright_rad : rad, the height is known only within this angle of the first attitude
    zero_rate : whether to make zero-rate updates, which the paper does not
    initial_gyr_mean : whether to start with the mean of the gyroscope over the first still stretch
    dynamics : error dynamics, "corrected" or as "printed" in eq. 24
    """

    gyr_noise_radps_sqrthz: float = 0.007 * _DEG
    acc_noise_mps2_sqrthz: float = 120e-6 * STANDARD_GRAVITY_MPS2
    gyr_noise_factor: float = 3.0
    acc_noise_factor: float = 5.0
    gyr_bias_walk: float = 1e-5
    acc_bias_walk: float = 1e-4
    gyr_bias_sd_radps: float = 0.01 * _DEG
    acc_bias_sd_mps2: float = 0.03
    velocity_noise: float = 0.001
    height_noise: float = 0.0005
    rate_noise: float = 0.014 * _DEG
    upright_rad: float = 3 * _DEG
    zero_rate: bool = True
    initial_gyr_mean: bool = True
    dynamics: Literal["corrected", "printed"] = "corrected"

    def __post_init__(self) -> None:
        """Refuse what no filter can work with."""
        for name, value in vars(self).items():
            if name == "dynamics":
                if value not in ("corrected", "printed"):
                    raise InputError(f"dynamics = {value!r}: expected 'corrected' or 'printed'")
            elif not isinstance(value, bool) and not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value}: expected a positive number")


@dataclass(frozen=True)
class ClosedLoop:
    """The frame is known to end where it began, and turned as it was.

    Parameters
    ----------
    position_sd_m : m, how well that is known, per axis
    heading_sd_rad : rad
    """

    position_sd_m: float = 0.03
    heading_sd_rad: float = 2 * _DEG

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive."""
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} = {value}: expected a positive number")


class NavigationState(NamedTuple):
    """State of an IMU: attitude (4,), position, velocity, biases of gyroscope and accelerometer."""

    quaternion: FloatArray
    position_m: FloatArray
    velocity_mps: FloatArray
    gyr_bias_radps: FloatArray
    acc_bias_mps2: FloatArray


class Navigation(NamedTuple):
    """Path of the IMU with standard deviations, at the samples; arrays with n rows.

    Parameters
    ----------
    time_s : (n,) s
    quaternion : (n, 4) Hamilton, scalar first, IMU to world
    position_m, velocity_mps : (n, 3) world
    gyr_bias_radps, acc_bias_mps2 : (n, 3) IMU's axes
    sd : (n, 15) standard deviations in the order of STATES; the attitude's are half angles, rad,
        about the IMU's axes
    still : (n,) bool
    nis : (n,) normalised innovation squared, summed over the updates of a sample
    nis_dof : (n,) int, number of these updates
    """

    time_s: FloatArray
    quaternion: FloatArray
    position_m: FloatArray
    velocity_mps: FloatArray
    gyr_bias_radps: FloatArray
    acc_bias_mps2: FloatArray
    sd: FloatArray
    still: NDArray[np.bool_]
    nis: FloatArray
    nis_dof: NDArray[np.int64]

    def rotation_imu_to_world(self) -> FloatArray:
        """Give the attitude as matrices, (n, 3, 3)."""
        return np.swapaxes(rotation_world_to_imu(self.quaternion), 1, 2)


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
    acc, gyr = as_vectors(acc_mps2, "acc_mps2"), as_vectors(gyr_radps, "gyr_radps")
    slope, bend = np.zeros_like(gyr), np.zeros_like(gyr)
    slope[1:-1] = (gyr[2:] - gyr[:-2]) / 2
    bend[1:-1] = gyr[2:] - 2 * gyr[1:-1] + gyr[:-2]
    rate = gyr + bend / 24 + dt_s / 12 * np.cross(gyr, slope)
    return acc - dt_s / 8 * np.cross(slope, acc), rate


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
    w1, w2, w3 = np.asarray(rate_radps, float)
    matrix = np.array([[0, -w1, -w2, -w3], [w1, 0, w3, -w2], [w2, -w3, 0, w1], [w3, w2, -w1, 0]])
    q = np.asarray(quaternion, float)
    to_world = rotation_world_to_imu(q).T
    return 0.5 * matrix @ q, to_world @ np.asarray(acc_imu_mps2, float), np.array(velocity_mps)


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
    force = to_imu @ (np.asarray(acc_world_mps2, float) + GRAVITY_MPS2)
    return force + state.acc_bias_mps2, np.asarray(rate_radps, float) + state.gyr_bias_radps


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
    back = np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    return np.concatenate(
        [
            back @ true.quaternion,
            true.gyr_bias_radps - estimate.gyr_bias_radps,
            true.position_m - estimate.position_m,
            true.velocity_mps - estimate.velocity_mps,
            true.acc_bias_mps2 - estimate.acc_bias_mps2,
        ]
    )


def error_dynamics(
    quaternion: ArrayLike,
    rate_radps: ArrayLike,
    force_mps2: ArrayLike,
    *,
    dynamics: Literal["corrected", "printed"] = "corrected",
) -> FloatArray:
    """Matrix A of the error state's differential equation (eq. 24).

    The paper prints +1/2 where the gyroscope's bias acts on the attitude, and nothing where the
    accelerometer's bias acts on the velocity. Eqs 20 to 22 give -1/2 and -C'(q).

    Parameters
    ----------
    quaternion : (4,) array, Hamilton, scalar first, IMU to world
    rate_radps : (3,) array, rad/s, gyroscope less its estimated bias
    force_mps2 : (3,) array, m/s², accelerometer less its estimated bias
    dynamics : "corrected" or "printed"

    Returns
    -------
    (15, 15) array, blocks in the order of STATES
    """
    to_world = rotation_world_to_imu(quaternion).T
    a = np.zeros((15, 15))
    a[0:3, 0:3] = -_cross_matrix(np.asarray(rate_radps, float))
    a[0:3, 3:6] = (0.5 if dynamics == "printed" else -0.5) * np.eye(3)
    a[6:9, 9:12] = np.eye(3)
    a[9:12, 0:3] = -2 * to_world @ _cross_matrix(np.asarray(force_mps2, float))
    if dynamics == "corrected":
        a[9:12, 12:15] = -to_world
    return a


def step_transition(
    state: NavigationState,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    dt_s: float,
    *,
    dynamics: Literal["corrected", "printed"] = "corrected",
) -> tuple[NavigationState, FloatArray]:
    """One step of the integration, and what it does to a small error: eq. 24 over one interval.

    Parameters
    ----------
    state : NavigationState before the interval
    acc_mps2, gyr_radps : (3,) arrays, readings over the interval
    dt_s : s
    dynamics : "corrected" or "printed"

    Returns
    -------
    NavigationState after the interval, and the (15, 15) transition matrix
    """
    x = np.concatenate(list(state))
    sign, couple = _signs(dynamics)
    after, blocks = np.empty(16), np.zeros((7, 3, 3))
    _advance(x, np.array(acc_mps2, float), np.array(gyr_radps, float), dt_s, 1.0, sign, couple,
             after, blocks)  # fmt: skip
    phi = np.eye(15)
    qq, qb, vq, vb, va = blocks[:5]
    phi[0:3, 0:3], phi[0:3, 3:6] = qq, qb
    for column, block in ((0, vq), (3, vb), (12, va)):
        phi[9:12, column : column + 3] = block
        phi[6:9, column : column + 3] = dt_s / 2 * block
    phi[6:9, 9:12] = dt_s * np.eye(3)
    return _split(after), phi


def integrate_strapdown(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    start: NavigationState,
    *,
    still: ArrayLike | None = None,
) -> Navigation:
    """Integrate eqs 20 and 21 without a filter; the velocity is set to 0 where the frame is still.

    Parameters
    ----------
    time_s : (n,) array, s
    acc_mps2, gyr_radps : (n, 3) arrays, in the IMU's axes
    start : NavigationState at the first sample (its biases are taken off throughout)
    still : (n,) bool array, none if it is not given

    Returns
    -------
    Navigation; its standard deviations are NaN
    """
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    acc, gyr = interval_means(acc, gyr, float(np.median(np.diff(clock))))
    states = np.empty((len(clock) + 1, 16))
    states[0] = np.concatenate(list(start))
    _integrate(acc, gyr, at_rest, _intervals(clock), states)
    empty = np.full((len(clock) + 1, 15), np.nan)
    none = np.zeros(len(clock))
    return _at_samples(clock, states, empty, at_rest, none, none.astype(np.int64))


def navigate(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    still: ArrayLike,
    settings: NavigationSettings | None = None,
    *,
    smooth: bool = True,
    cut: ArrayLike | None = None,
    closed_loop: ClosedLoop | None = None,
) -> Navigation:
    """Path of an IMU by the error-state Kalman filter, with its smoother unless that is declined.

    When the frame is still: velocity zero, height as at the start (if it is upright), rate zero.
    The smoother gives what a Rauch-Tung-Striebel smoother gives, by the adjoint recursion of
    Bryson and Frazier, which needs no inverse.

    Parameters
    ----------
    time_s : (n,) array, s
    acc_mps2 : (n, 3) array, m/s², specific force in the IMU's axes
    gyr_radps : (n, 3) array, rad/s, in the IMU's axes
    still : (n,) bool array, see :func:`mobility_imu.walker.stillness.find_stillness`
    settings : NavigationSettings
    smooth : whether each estimate may use what comes after it
    cut : (n,) bool array, samples in which the accelerometer was at the end of its range
    closed_loop : where the smoother may take the end for known; the filter makes no use of it

    Returns
    -------
    Navigation

    Raises
    ------
    InputError
        If nothing is still within the first 5 s: where up is, and the biases, come from there.
    """
    settings = settings or NavigationSettings()
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    acc, gyr = interval_means(acc, gyr, float(np.median(np.diff(clock))))
    state, covariance = _start(clock, acc, gyr, at_rest, settings)
    return run_filter(
        clock,
        acc,
        gyr,
        at_rest,
        state,
        covariance,
        settings,
        smooth=smooth,
        cut=cut,
        closed_loop=closed_loop,
    )


def run_filter(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    still: ArrayLike,
    start: NavigationState,
    covariance: ArrayLike,
    settings: NavigationSettings,
    *,
    smooth: bool = True,
    cut: ArrayLike | None = None,
    closed_loop: ClosedLoop | None = None,
    observed: ArrayLike | None = None,
) -> Navigation:
    """Filter and smoother from a given start and means over intervals, see :func:`navigate`.

    Parameters
    ----------
    time_s, acc_mps2, gyr_radps, still, settings, smooth, cut, closed_loop : as in :func:`navigate`
    start : NavigationState
    covariance : (15, 15) array, of the error of the start
    observed : (n, 4) array, velocity (m/s) and height (m) that the updates take for observed;
        zeros if it is not given. Simulations put the stated noise here to test consistency.

    Returns
    -------
    Navigation
    """
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    count = len(clock)
    doubt = np.zeros(count, np.bool_) if cut is None else np.asarray(cut, np.bool_)
    seen = np.zeros((count, 4)) if observed is None else np.ascontiguousarray(observed, float)
    if doubt.shape != (count,) or seen.shape != (count, 4):
        raise InputError(f"cut {doubt.shape}, observed {seen.shape}: expected ({count},) and rows")
    dt = _intervals(clock)
    sign, couple = _signs(settings.dynamics)
    noise = _noises(settings)
    states = np.empty((count + 1, 16))
    states[0] = np.concatenate(list(start))
    packed = np.empty((count + 1, 120))
    nis, dof = np.zeros(count), np.zeros(count, np.int64)
    upright = np.zeros(count, np.bool_)
    first = np.ascontiguousarray(covariance, float)
    _forward(acc, gyr, at_rest, doubt, seen, dt, noise, settings.zero_rate, sign, couple,
             np.cos(settings.upright_rad), first, states, packed, nis, dof, upright)  # fmt: skip
    variance = np.empty((count + 1, 15))
    if smooth:
        smoothed = np.empty_like(states)
        mu, big = np.zeros(15), np.zeros((15, 15))
        if closed_loop is not None:
            mu, big = _closing(states, packed[-1], closed_loop)
        _backward(acc, gyr, at_rest, upright, seen, dt, noise, settings.zero_rate, sign, couple,
                  states, packed, mu, big, smoothed, variance)  # fmt: skip
        states = smoothed
    else:
        diagonal = [k * (k + 1) // 2 + k for k in range(15)]
        variance = np.maximum(packed[:, diagonal], 0)
    return _at_samples(clock, states, variance, at_rest, nis, dof)


def _closing(
    states: FloatArray, packed: FloatArray, closed: ClosedLoop
) -> tuple[FloatArray, FloatArray]:
    """What a known end says of the last state: where the smoother starts."""
    lower = np.zeros((15, 15))
    lower[np.tril_indices(15)] = packed
    p = lower + np.tril(lower, -1).T
    first, last = (rotation_world_to_imu(states[k, :4]).T for k in (0, -1))  # IMU to world
    drift = Rotation.from_matrix(last @ first.T).as_rotvec()[2]
    h = np.zeros((3, 15))
    h[0, 6], h[1, 7] = 1.0, 1.0
    h[2, 0:3] = 2 * last[2]
    seen = np.array([*(states[0, 4:6] - states[-1, 4:6]), -drift])
    spread = np.diag([closed.position_sd_m, closed.position_sd_m, closed.heading_sd_rad]) ** 2
    weight = np.linalg.solve(h @ p @ h.T + spread, h).T
    return weight @ seen, weight @ h


def _inputs(
    time_s: ArrayLike, acc_mps2: ArrayLike, gyr_radps: ArrayLike, still: ArrayLike | None
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
    clock = as_series(time_s, "time_s")
    acc = np.ascontiguousarray(as_vectors(acc_mps2, "acc_mps2"))
    gyr = np.ascontiguousarray(as_vectors(gyr_radps, "gyr_radps"))
    at_rest = np.zeros(len(clock), np.bool_) if still is None else np.array(still, np.bool_)
    if not acc.shape == gyr.shape == (len(clock), 3) or at_rest.shape != clock.shape:
        raise InputError(
            f"time_s {clock.shape}, acc_mps2 {acc.shape}, gyr_radps {gyr.shape}, still "
            f"{at_rest.shape}: expected (n,), (n, 3), (n, 3), (n,)"
        )
    if len(clock) < 2 or (np.diff(clock) <= 0).any():
        raise InputError("time_s: expected two or more times that increase")
    for name, values in (("time_s", clock), ("acc_mps2", acc), ("gyr_radps", gyr)):
        if not np.isfinite(values).all():
            raise InputError(f"{name}: not a finite number at row {_first_bad(values)}")
    return clock, acc, gyr, at_rest


def _first_bad(values: FloatArray) -> int:
    return int(np.argmax(~np.isfinite(values.reshape(len(values), -1)).all(axis=1)))


def _intervals(clock: FloatArray) -> FloatArray:
    """Length of the interval that each sample stands for: from midpoint to midpoint."""
    step = np.diff(clock)
    bounds = np.concatenate([[step[0]], step, [step[-1]]])
    return np.asarray((bounds[1:] + bounds[:-1]) / 2)


def _signs(dynamics: str) -> tuple[float, float]:
    return (1.0, 0.0) if dynamics == "printed" else (-1.0, 1.0)


def _noises(settings: NavigationSettings) -> FloatArray:
    """Densities squared: gyroscope, accelerometer, their walks, velocity, height, rate."""
    return np.array(
        [
            settings.gyr_noise_radps_sqrthz * settings.gyr_noise_factor,
            settings.acc_noise_mps2_sqrthz * settings.acc_noise_factor,
            settings.gyr_bias_walk,
            settings.acc_bias_walk,
            settings.velocity_noise,
            settings.height_noise,
            settings.rate_noise,
        ]
    ) ** 2  # fmt: skip


def _start(
    clock: FloatArray,
    acc: FloatArray,
    gyr: FloatArray,
    still: NDArray[np.bool_],
    settings: NavigationSettings,
) -> tuple[NavigationState, FloatArray]:
    """Upright by the first still stretch's mean specific force, rates less their mean there."""
    soon = still & (clock < clock[0] + 5.0)
    if not soon.any():
        raise InputError(
            "the frame is not still within the first 5 s: expected some seconds of rest at the "
            "start, which say where up is"
        )
    begin = int(np.argmax(soon))
    moving = np.nonzero(~still[begin:])[0]
    rest = slice(begin, begin + int(moving[0]) if len(moving) else len(still))
    force, rate = acc[rest].mean(axis=0), gyr[rest].mean(axis=0)
    up = force / np.linalg.norm(force)
    turn, _ = Rotation.align_vectors([[0.0, 0.0, 1.0]], up[None])
    length = float(np.sum(_intervals(clock)[rest]))
    gyr_bias = rate if settings.initial_gyr_mean else np.zeros(3)
    bias_var = settings.gyr_bias_sd_radps**2
    if settings.initial_gyr_mean:
        bias_var += (settings.gyr_noise_radps_sqrthz * settings.gyr_noise_factor) ** 2 / length
    else:
        bias_var = (0.5 * _DEG) ** 2
    # The first attitude is right if the accelerometer's bias is nil: both err together.
    acc_var = settings.acc_bias_sd_mps2**2
    lean = _cross_matrix(up) / (2 * STANDARD_GRAVITY_MPS2)
    level_var = (settings.acc_noise_mps2_sqrthz * settings.acc_noise_factor) ** 2 / length
    p = np.zeros((15, 15))
    p[0:3, 0:3] = lean @ lean.T * (acc_var + level_var) + 1e-10 * np.eye(3)
    p[0:3, 12:15] = lean * acc_var
    p[12:15, 0:3] = p[0:3, 12:15].T
    p[3:6, 3:6] = bias_var * np.eye(3)
    p[6:9, 6:9] = 1e-12 * np.eye(3)
    p[9:12, 9:12] = settings.velocity_noise**2 * np.eye(3)
    p[12:15, 12:15] = acc_var * np.eye(3)
    zero = np.zeros(3)
    start = NavigationState(turn.as_quat(scalar_first=True), zero, zero, gyr_bias, zero)
    return start, p


def _split(x: FloatArray) -> NavigationState:
    return NavigationState(x[0:4], x[4:7], x[7:10], x[10:13], x[13:16])


def _at_samples(
    clock: FloatArray,
    states: FloatArray,
    variance: FloatArray,
    still: NDArray[np.bool_],
    nis: FloatArray,
    dof: NDArray[np.int64],
) -> Navigation:
    """From the midpoints between the samples to the samples."""
    middle, spread = np.empty((len(clock), 16)), np.empty((len(clock), 15))
    _between(states, variance, middle, spread)
    quaternion = middle[:, 0:4]
    position, velocity, gyr_bias, acc_bias = (middle[:, k : k + 3] for k in (4, 7, 10, 13))
    return Navigation(
        clock, quaternion, position, velocity, gyr_bias, acc_bias, spread, still, nis, dof
    )


def _cross_matrix(v: FloatArray) -> FloatArray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


# Compiled from here on. A state has 16 numbers: attitude, position, velocity, biases. The error
# state has 15; position and velocity of both stand at other places, see STATES.
# A product and the sum after it may be rounded once instead of twice ("contract"), nothing else.
_compiled = njit(cache=True, fastmath={"contract"})


@_compiled
def _matrix(w, x, y, z, out):
    """Quaternion to matrix, IMU to world."""
    out[0, 0] = w * w + x * x - y * y - z * z
    out[0, 1] = 2 * (x * y - w * z)
    out[0, 2] = 2 * (x * z + w * y)
    out[1, 0] = 2 * (x * y + w * z)
    out[1, 1] = w * w - x * x + y * y - z * z
    out[1, 2] = 2 * (y * z - w * x)
    out[2, 0] = 2 * (x * z - w * y)
    out[2, 1] = 2 * (y * z + w * x)
    out[2, 2] = w * w - x * x - y * y + z * z


@_compiled
def _product(w0, w1, w2, w3, c, x, y, z):
    """Product of two quaternions."""
    return (
        w0 * c - w1 * x - w2 * y - w3 * z,
        w0 * x + w1 * c + w2 * z - w3 * y,
        w0 * y - w1 * z + w2 * c + w3 * x,
        w0 * z + w1 * y - w2 * x + w3 * c,
    )


@_compiled
def _from_vector(v1, v2, v3):
    """Quaternion of a rotation vector."""
    square = (v1 * v1 + v2 * v2 + v3 * v3) / 4
    if square < 1e-3:  # the next terms are below rounding
        c = 1 - square / 2 * (1 - square / 12 * (1 - square / 30 * (1 - square / 56)))
        s = (1 - square / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72)))) / 2
        return c, s * v1, s * v2, s * v3
    half = np.sqrt(square)
    s = np.sin(half) / (2 * half)
    return np.cos(half), s * v1, s * v2, s * v3


@_compiled
def _advance(x, acc, gyr, dt, share, sign, couple, out, blocks):
    """State and blocks of the transition over one interval.

    share is how much of the measured rate is taken for motion. Blocks, 3 x 3 each: attitude from
    attitude and gyroscope bias, velocity from attitude, gyroscope and accelerometer bias. What the
    velocity gains, the position gains by half the interval. The last two blocks are scratch.
    """
    p1 = (gyr[0] - x[10]) * share * dt
    p2 = (gyr[1] - x[11]) * share * dt
    p3 = (gyr[2] - x[12]) * share * dt
    f1, f2, f3 = acc[0] - x[13], acc[1] - x[14], acc[2] - x[15]
    qq, qb, vq, vb, va = blocks[0], blocks[1], blocks[2], blocks[3], blocks[4]
    r, back = blocks[5], blocks[6]
    hc, hx, hy, hz = _from_vector(p1 / 2, p2 / 2, p3 / 2)
    m0, m1, m2, m3 = _product(x[0], x[1], x[2], x[3], hc, hx, hy, hz)
    _matrix(m0, m1, m2, m3, r)
    m0, m1, m2, m3 = _product(m0, m1, m2, m3, hc, hx, hy, hz)
    length = np.sqrt(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3)
    out[0], out[1], out[2], out[3] = m0 / length, m1 / length, m2 / length, m3 / length
    for i in range(3):
        gain = r[i, 0] * f1 + r[i, 1] * f2 + r[i, 2] * f3
        if i == 2:
            gain -= STANDARD_GRAVITY_MPS2
        out[7 + i] = x[7 + i] + dt * gain
        out[4 + i] = x[4 + i] + dt * x[7 + i] + dt * dt / 2 * gain
    for i in range(10, 16):
        out[i] = x[i]
    # The bias acts on the attitude through the right Jacobian 1 - [p x] / 2 + [p x]² / 6.
    k = sign * 0.5 * share * dt
    square = p1 * p1 + p2 * p2 + p3 * p3
    m0, m1, m2, m3 = _product(hc, -hx, -hy, -hz, hc, -hx, -hy, -hz)
    _matrix(m0, m1, m2, m3, qq)
    _matrix(hc, -hx, -hy, -hz, back)
    qb[0, 0], qb[0, 1], qb[0, 2] = 1 + (p1 * p1 - square) / 6, p1 * p2 / 6, p1 * p3 / 6
    qb[1, 0], qb[1, 1], qb[1, 2] = p1 * p2 / 6, 1 + (p2 * p2 - square) / 6, p2 * p3 / 6
    qb[2, 0], qb[2, 1], qb[2, 2] = p1 * p3 / 6, p2 * p3 / 6, 1 + (p3 * p3 - square) / 6
    qb[0, 1] += p3 / 2
    qb[0, 2] -= p2 / 2
    qb[1, 0] -= p3 / 2
    qb[1, 2] += p1 / 2
    qb[2, 0] += p2 / 2
    qb[2, 1] -= p1 / 2
    # -2 R [f x] acts on the attitude's error in the middle of the interval.
    for i in range(3):
        a = -2 * dt * (r[i, 1] * f3 - r[i, 2] * f2)
        b = -2 * dt * (r[i, 2] * f1 - r[i, 0] * f3)
        c = -2 * dt * (r[i, 0] * f2 - r[i, 1] * f1)
        for j in range(3):
            vq[i, j] = a * back[0, j] + b * back[1, j] + c * back[2, j]
            va[i, j] = -couple * dt * r[i, j]
            qb[i, j] *= k
        vb[i, 0] = k / 2 * (a - b * p3 / 4 + c * p2 / 4)
        vb[i, 1] = k / 2 * (b + a * p3 / 4 - c * p1 / 4)
        vb[i, 2] = k / 2 * (c - a * p2 / 4 + b * p1 / 4)


@_compiled
def _between(states, variance, middle, spread):
    for k in range(len(middle)):
        for i in range(16):
            middle[k, i] = (states[k, i] + states[k + 1, i]) / 2
        square = 0.0
        for i in range(4):
            square += middle[k, i] * middle[k, i]
        length = np.sqrt(square)
        for i in range(4):
            middle[k, i] /= length
        for i in range(15):
            spread[k, i] = np.sqrt((variance[k, i] + variance[k + 1, i]) / 2)


@_compiled
def _integrate(acc, gyr, still, dt, states):
    blocks = np.empty((7, 3, 3))
    for k in range(len(acc)):
        _advance(states[k], acc[k], gyr[k], dt[k], 1.0, -1.0, 1.0, states[k + 1], blocks)
        if still[k]:
            states[k + 1, 7:10] = 0.0


# Matrices of the error state lie flat, 16 numbers a row of which the last is 0, 16 rows: only then
# does the compiler see that a row fits its registers. Six times faster than (15, 15) arrays.


@_compiled
def _rows(blocks, dt, p, out):
    """Transition times p."""
    for i in range(3):
        q0, q1, q2 = blocks[0, i, 0], blocks[0, i, 1], blocks[0, i, 2]
        b0, b1, b2 = blocks[1, i, 0], blocks[1, i, 1], blocks[1, i, 2]
        v0, v1, v2 = blocks[2, i, 0], blocks[2, i, 1], blocks[2, i, 2]
        u0, u1, u2 = blocks[3, i, 0], blocks[3, i, 1], blocks[3, i, 2]
        a0, a1, a2 = blocks[4, i, 0], blocks[4, i, 1], blocks[4, i, 2]
        k = 16 * i
        for j in range(16):
            x0, x1, x2 = p[j], p[16 + j], p[32 + j]
            y0, y1, y2 = p[48 + j], p[64 + j], p[80 + j]
            gain = (
                v0 * x0 + v1 * x1 + v2 * x2 + u0 * y0 + u1 * y1 + u2 * y2
                + a0 * p[192 + j] + a1 * p[208 + j] + a2 * p[224 + j]
            )  # fmt: skip
            out[k + j] = q0 * x0 + q1 * x1 + q2 * x2 + b0 * y0 + b1 * y1 + b2 * y2
            out[48 + k + j] = p[48 + k + j]
            out[96 + k + j] = p[96 + k + j] + dt * p[144 + k + j] + dt / 2 * gain
            out[144 + k + j] = p[144 + k + j] + gain
            out[192 + k + j] = p[192 + k + j]


@_compiled
def _rows_back(blocks, dt, p, out):
    """Transposed transition times p."""
    for i in range(3):
        q0, q1, q2 = blocks[0, 0, i], blocks[0, 1, i], blocks[0, 2, i]
        b0, b1, b2 = blocks[1, 0, i], blocks[1, 1, i], blocks[1, 2, i]
        v0, v1, v2 = blocks[2, 0, i], blocks[2, 1, i], blocks[2, 2, i]
        u0, u1, u2 = blocks[3, 0, i], blocks[3, 1, i], blocks[3, 2, i]
        a0, a1, a2 = blocks[4, 0, i], blocks[4, 1, i], blocks[4, 2, i]
        k = 16 * i
        for j in range(16):
            x0, x1, x2 = p[j], p[16 + j], p[32 + j]
            s0 = p[144 + j] + dt / 2 * p[96 + j]
            s1 = p[160 + j] + dt / 2 * p[112 + j]
            s2 = p[176 + j] + dt / 2 * p[128 + j]
            out[k + j] = q0 * x0 + q1 * x1 + q2 * x2 + v0 * s0 + v1 * s1 + v2 * s2
            out[48 + k + j] = (
                p[48 + k + j] + b0 * x0 + b1 * x1 + b2 * x2 + u0 * s0 + u1 * s1 + u2 * s2
            )
            out[96 + k + j] = p[96 + k + j]
            out[144 + k + j] = p[144 + k + j] + dt * p[96 + k + j]
            out[192 + k + j] = p[192 + k + j] + a0 * s0 + a1 * s1 + a2 * s2


@_compiled
def _transpose(p, out):
    for i in range(15):
        for j in range(15):
            out[16 * i + j] = p[16 * j + i]


@_compiled
def _product_rows(a, b, out, first, last):
    """Rows first to last of a times the matrix b; in short sums, which do not wait for another."""
    for k in range(16 * first, 16 * last, 16):
        a0, a1, a2, a3, a4 = a[k], a[k + 1], a[k + 2], a[k + 3], a[k + 4]
        a5, a6, a7, a8, a9 = a[k + 5], a[k + 6], a[k + 7], a[k + 8], a[k + 9]
        a10, a11, a12, a13, a14 = a[k + 10], a[k + 11], a[k + 12], a[k + 13], a[k + 14]
        for j in range(16):
            out[k + j] = (
                (a0 * b[j] + a1 * b[16 + j] + a2 * b[32 + j] + a3 * b[48 + j])
                + (a4 * b[64 + j] + a5 * b[80 + j] + a6 * b[96 + j] + a7 * b[112 + j])
                + (a8 * b[128 + j] + a9 * b[144 + j] + a10 * b[160 + j] + a11 * b[176 + j])
                + (a12 * b[192 + j] + a13 * b[208 + j] + a14 * b[224 + j])
            )


@_compiled
def _correct(x, error):
    """Put an error into a state (eq. 22 turned round)."""
    m0, m1, m2, m3 = _product(x[0], x[1], x[2], x[3], 1.0, error[0], error[1], error[2])
    length = np.sqrt(m0 * m0 + m1 * m1 + m2 * m2 + m3 * m3)
    x[0], x[1], x[2], x[3] = m0 / length, m1 / length, m2 / length, m3 / length
    for i in range(3):
        x[10 + i] += error[3 + i]
        x[4 + i] += error[6 + i]
        x[7 + i] += error[9 + i]
        x[13 + i] += error[12 + i]


@_compiled
def _share(still, zero_rate, noise):
    """How much of a measured rate is motion, if a standing frame has a noise of its own.

    With the prior "rate 0 with noise s" and a reading with noise g, the rate's best estimate is
    s²/(s²+g²) of the reading; its error does not depend on the reading less the bias, so that the
    latter may be used once more, as an observation of the bias with variance s² + g².
    """
    if still and zero_rate:
        return noise[6] / (noise[6] + noise[0])
    return 1.0


@_compiled
def _forward(
    acc, gyr, still, cut, seen, dt, noise, zero_rate, sign, couple, upright_cos, first,
    states, packed, nis, dof, upright,
):  # fmt: skip
    p, work, other = np.zeros(256), np.zeros(256), np.zeros(256)
    blocks, r = np.empty((7, 3, 3)), np.empty((3, 3))
    error, column = np.zeros(16), np.zeros(16)
    _matrix(states[0, 0], states[0, 1], states[0, 2], states[0, 3], r)
    up0, up1, up2 = r[2, 0], r[2, 1], r[2, 2]
    for i in range(15):
        for j in range(15):
            p[16 * i + j] = first[i, j]
    for k in range(len(acc)):
        h = dt[k]
        share = _share(still[k], zero_rate, noise)
        x = states[k + 1]
        _advance(states[k], acc[k], gyr[k], h, share, sign, couple, x, blocks)
        _rows(blocks, h, p, work)
        _transpose(work, other)
        _pack(p, packed[k])  # here, since what was just transposed cannot be read at once
        _rows(blocks, h, other, p)
        white = CUT_ACC_SD_MPS2**2 * h if cut[k] else noise[1]
        for i in range(3):
            p[17 * i] += noise[0] * share / 4 * h
            p[17 * (3 + i)] += noise[2] * h
            p[17 * (6 + i)] += white * h * h * h / 4
            p[17 * (6 + i) + 3] += white * h * h / 2
            p[17 * (9 + i) - 3] += white * h * h / 2
            p[17 * (9 + i)] += white * h
            p[17 * (12 + i)] += noise[3] * h
        if still[k]:
            error[:] = 0.0
            _matrix(x[0], x[1], x[2], x[3], r)
            upright[k] = r[2, 0] * up0 + r[2, 1] * up1 + r[2, 2] * up2 > upright_cos
            for m in range(7):
                if m < 3:
                    at, variance, residual = 9 + m, noise[4] / h, seen[k, m] - x[7 + m]
                elif m == 3:
                    if not upright[k]:
                        continue
                    at, variance, residual = 8, noise[5] / h, seen[k, 3] - x[6]
                else:
                    if not zero_rate:
                        break
                    at, variance = m - 1, (noise[6] + noise[0]) / h
                    residual = gyr[k, m - 4] - x[6 + m]
                residual -= error[at]
                total = p[17 * at] + variance
                nis[k] += residual * residual / total
                dof[k] += 1
                _observe(p, at, 1 / total, residual, column, error)
            _correct(x, error)
    _pack(p, packed[len(acc)])


@_compiled
def _observe(p, at, inverse, residual, column, error):
    """Covariance and error after one state has been observed."""
    for j in range(16):
        column[j] = p[16 * at + j]
    for j in range(16):
        error[j] += column[j] * (residual * inverse)
    for i in range(0, 15, 5):
        g0, g1, g2 = column[i] * inverse, column[i + 1] * inverse, column[i + 2] * inverse
        g3, g4 = column[i + 3] * inverse, column[i + 4] * inverse
        k = 16 * i
        for j in range(16):
            p[k + j] -= g0 * column[j]
            p[k + 16 + j] -= g1 * column[j]
            p[k + 32 + j] -= g2 * column[j]
            p[k + 48 + j] -= g3 * column[j]
            p[k + 64 + j] -= g4 * column[j]


@_compiled
def _pack(p, packed):
    """Lower triangle, row by row."""
    at = 0
    for i in range(15):
        for j in range(i + 1):
            packed[at + j] = p[16 * i + j]
        at += i + 1


@_compiled
def _unpack(packed, p):
    at = 0
    for i in range(15):
        for j in range(i + 1):
            p[16 * i + j] = packed[at + j]
            p[16 * j + i] = packed[at + j]
        at += i + 1


@_compiled
def _backward(
    acc, gyr, still, upright, seen, dt, noise, zero_rate, sign, couple,
    states, packed, mu_last, big_last, smoothed, smoothed_var,
):  # fmt: skip
    """Adjoint recursion: mu and big hold what later updates say of the state and how surely.

    With P after a sample's updates, the smoothed error is P mu and its covariance P - P big P. All
    updates observe single states, so going back over them only touches these states' rows:
    mu += (residual - error) / R, big += D - D P big - (D P big)' - D (P - P big P) D, D = 1 / R.
    """
    p, big, known, block = np.zeros(256), np.zeros(256), np.zeros(256), np.zeros(256)
    work, other, after = np.zeros(256), np.zeros(256), np.empty(16)
    mu, was, error, variance = np.zeros(16), np.zeros(16), np.zeros(16), np.zeros(16)
    blocks = np.empty((7, 3, 3))
    at, weight, residual = np.empty(7, np.int64), np.empty(7), np.empty(7)
    for i in range(15):
        mu[i] = mu_last[i]
        for j in range(15):
            big[16 * i + j] = big_last[i, j]
    _unpack(packed[len(acc)], p)
    for k in range(len(acc), -1, -1):
        _product_rows(mu, p, error, 0, 1)
        x = smoothed[k]
        x[:] = states[k]
        _correct(x, error)
        _product_rows(big, p, known, 0, 15)
        for j in range(16):
            variance[j] = p[17 * j]
        for i in range(15):
            for j in range(16):
                variance[j] -= p[16 * i + j] * known[16 * i + j]
        for j in range(15):
            smoothed_var[k, j] = max(variance[j], 0.0)
        if k == 0:
            break
        s, h = k - 1, dt[k - 1]
        if still[s]:
            count = 0
            for m in range(3):
                at[count], weight[count] = 9 + m, h / noise[4]
                residual[count] = seen[s, m] - states[k, 7 + m]
                count += 1
            if upright[s]:
                at[count], weight[count] = 8, h / noise[5]
                residual[count] = seen[s, 3] - states[k, 6]
                count += 1
            if zero_rate:
                for m in range(3):
                    at[count], weight[count] = 3 + m, h / (noise[6] + noise[0])
                    residual[count] = gyr[s, m] - states[k, 10 + m]
                    count += 1
            for a in range(count):
                mu[at[a]] += weight[a] * (residual[a] - error[at[a]])
                _product_rows(p, known, block, at[a], at[a] + 1)  # P big P
            for a in range(count):
                for j in range(15):
                    change = weight[a] * known[16 * j + at[a]]
                    big[16 * at[a] + j] -= change
                    big[16 * j + at[a]] -= change
            for a in range(count):
                big[17 * at[a]] += weight[a]
                for b in range(count):
                    left = p[16 * at[a] + at[b]] - block[16 * at[a] + at[b]]
                    big[16 * at[a] + at[b]] -= weight[a] * left * weight[b]
        share = _share(still[s], zero_rate, noise)
        _advance(states[s], acc[s], gyr[s], h, share, sign, couple, after, blocks)
        _rows_back(blocks, h, big, work)
        _transpose(work, other)
        _unpack(packed[k - 1], p)  # here, as in _forward
        _rows_back(blocks, h, other, big)
        # Rounding makes big a little unsymmetric; the updates would let that grow without bound.
        for i in range(15):
            for j in range(i):
                mean = (big[16 * i + j] + big[16 * j + i]) / 2
                big[16 * i + j] = mean
                big[16 * j + i] = mean
        was[:] = mu
        _vector_back(blocks, h, was, mu)


@_compiled
def _vector_back(blocks, dt, v, out):
    """Transposed transition times a vector."""
    qq, qb, vq, vb, va = blocks[0], blocks[1], blocks[2], blocks[3], blocks[4]
    s0, s1, s2 = v[9] + dt / 2 * v[6], v[10] + dt / 2 * v[7], v[11] + dt / 2 * v[8]
    for i in range(3):
        out[i] = (
            qq[0, i] * v[0] + qq[1, i] * v[1] + qq[2, i] * v[2]
            + vq[0, i] * s0 + vq[1, i] * s1 + vq[2, i] * s2
        )  # fmt: skip
        out[3 + i] = (
            v[3 + i] + qb[0, i] * v[0] + qb[1, i] * v[1] + qb[2, i] * v[2]
            + vb[0, i] * s0 + vb[1, i] * s1 + vb[2, i] * s2
        )  # fmt: skip
        out[6 + i] = v[6 + i]
        out[9 + i] = v[9 + i] + dt * v[6 + i]
        out[12 + i] = v[12 + i] + va[0, i] * s0 + va[1, i] * s1 + va[2, i] * s2
