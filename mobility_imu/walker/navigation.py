"""Where the IMU goes: strapdown integration with an error-state Kalman filter and smoother.

World frame: z up, origin where the IMU is at the start. Its heading is a matter of choice: here
the IMU is brought upright by the shortest turn. (The paper lays x in the vertical plane of the
IMU's x axis, which fails where that axis is vertical, as it nearly is in its third mounting.)

A reading is taken for the value at its time. The filter steps from midpoint to midpoint between
samples, with the means over these intervals; what is given out is brought back to the samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_series, as_vectors
from mobility_imu.walker import _kernel as recursion
from mobility_imu.walker.geometry import rotation_world_to_imu

STATES = ("attitude", "gyr_bias", "position", "velocity", "acc_bias")
"""Order of the error state (eq. 23), each with three components."""
GRAVITY_MPS2 = np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2])
"""The vector g of eq. 21. It must point up, or a resting accelerometer would read downward."""

_DEG = float(np.deg2rad(1))
LONG_INTERVAL = 1.5
"""An interval of more than so many ordinary ones, a gap, shares its step with no other sample."""


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
    moving_stride : 8, samples of a moving frame that share one step of the covariance
    resting_stride : 4, samples of a resting frame that share one, and one update at their end;
        closer to the ends of a rest each has its own. With 1 and 1: the textbook's filter. Gaps
        and samples that are cut off always stand alone
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
    moving_stride: int = 8
    resting_stride: int = 4

    def __post_init__(self) -> None:
        """Refuse what no filter can work with."""
        for name, value in vars(self).items():
            if name == "dynamics":
                if value not in ("corrected", "printed"):
                    raise InputError(f"dynamics = {value!r}: expected 'corrected' or 'printed'")
            elif name in ("moving_stride", "resting_stride"):
                if not isinstance(value, int) or value < 1:
                    raise InputError(f"{name} = {value}: expected a whole number from 1")
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
        about the IMU's axes; inside a stride their squares are linear from sample to sample
    still : (n,) bool
    nis : (n,) normalised innovation squared, summed over the updates of a sample
    nis_dof : (n,) int, number of these updates; 0 but at a stride's last sample
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
    force, rate = acc.copy(), gyr.copy()
    recursion.interval_means(acc, gyr, dt_s, force, rate)
    return force, rate


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

    Our text copy has +1/2 where the gyroscope's bias acts on the attitude, and nothing where the
    accelerometer's bias acts on the velocity. Eqs 20 to 22 give -1/2 and -C'(q). The plus is right
    if the state holds minus the bias of eq. 21; a sign or an entry may also be lost in the copy.

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
    states, step = np.empty((2, 16)), np.empty(45)
    states[0] = _joined(state)
    recursion.advance(
        states, 0, np.array([acc_mps2], float), np.array([gyr_radps], float), dt_s, 1.0,
        *_signs(dynamics), step,
    )  # fmt: skip
    phi = np.eye(15)
    qq, qb, vq, vb, va = step.reshape(5, 3, 3)
    phi[0:3, 0:3], phi[0:3, 3:6] = qq, qb
    for column, block in ((0, vq), (3, vb), (12, va)):
        phi[9:12, column : column + 3] = block
        phi[6:9, column : column + 3] = dt_s / 2 * block
    phi[6:9, 9:12] = dt_s * np.eye(3)
    return _split(states[1]), phi


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
    states[0] = _joined(start)
    recursion.integrate(acc, gyr, at_rest, _intervals(clock), states)
    empty = np.full((len(clock) + 1, 15), np.nan)
    none = np.zeros(len(clock))
    ends = np.arange(1, len(clock) + 1)
    return _at_samples(clock, states, ends, empty, at_rest, none, none.astype(np.int64))


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
    Bryson and Frazier, which needs no inverse. The state is integrated at every sample, the
    covariance in strides, see NavigationSettings.

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
        zeros if it is not given. Simulations put the stated noise here to test consistency. An
        update takes the mean over its stride.

    Returns
    -------
    Navigation
    """
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    count = len(clock)
    doubt = np.zeros(count, np.bool_) if cut is None else np.asarray(cut, np.bool_)
    seen = np.zeros((1, 4)) if observed is None else np.ascontiguousarray(observed, float)
    if doubt.shape != (count,) or (observed is not None and seen.shape != (count, 4)):
        raise InputError(
            f"cut {doubt.shape}, observed {seen.shape}: expected ({count},) and ({count}, 4)"
        )
    dt = _intervals(clock)
    alone = doubt | (dt > LONG_INTERVAL * np.median(dt))
    ends = recursion.stride_ends(at_rest, alone, settings.moving_stride, settings.resting_stride)
    begins = np.concatenate([[0], ends[:-1]])
    length = np.add.reduceat(dt, begins)
    sizes = np.where(ends - begins == 1, recursion.STEP, recursion.CHAIN)
    places = np.concatenate([[0], np.cumsum(sizes)])
    strides = len(ends)
    states, chains, packed, shifts, said, variance = _rooms(
        (count + 1, 16), (places[-1],), (strides + 1, 120), (strides, 16), (strides, 16),
        (strides + 1, 15),
    )  # fmt: skip
    states[0] = _joined(start)
    nis, dof = np.zeros(count), np.zeros(count, np.int64)
    recursion.forward(
        acc, gyr, at_rest, doubt, seen, dt, ends, length, places, _noises(settings),
        settings.zero_rate, *_signs(settings.dynamics), np.cos(settings.upright_rad),
        np.ascontiguousarray(covariance, float), states, chains, packed, shifts, said, nis, dof,
        recursion.aligned(5, 256),
    )  # fmt: skip
    if smooth:
        mu, big = np.zeros(15), np.zeros((15, 15))
        if closed_loop is not None:
            mu, big = _closing(states, packed, closed_loop)
        recursion.backward(
            at_rest, ends, length, places, chains, packed, shifts, said, mu, big, states, variance,
            recursion.aligned(7, 256),
        )  # fmt: skip
    else:
        diagonal = [k * (k + 1) // 2 + k for k in range(15)]
        variance = np.maximum(packed[:, diagonal], 0)
    return _at_samples(clock, states, ends, variance, at_rest, nis, dof)


def _closing(
    states: FloatArray, packed: FloatArray, closed: ClosedLoop
) -> tuple[FloatArray, FloatArray]:
    """What a known end says of the last state: where the smoother starts."""
    flat = np.zeros(256)
    recursion.unpack(packed, len(packed) - 1, flat)
    p = flat.reshape(16, 16)[:15, :15]
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


def _rooms(*shapes: tuple[int, ...]) -> list[FloatArray]:
    """Arrays in one piece of memory: to get it in small ones takes longer than to fill it."""
    ends = np.cumsum([math.prod(shape) for shape in shapes])
    parts = np.split(np.empty(ends[-1]), ends[:-1])
    return [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]


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


def _joined(state: NavigationState) -> FloatArray:
    x = np.concatenate(list(state))
    x[:4] /= np.linalg.norm(x[:4])
    return x


def _split(x: FloatArray) -> NavigationState:
    return NavigationState(x[0:4], x[4:7], x[7:10], x[10:13], x[13:16])


def _at_samples(
    clock: FloatArray,
    states: FloatArray,
    ends: NDArray[np.int64],
    variance: FloatArray,
    still: NDArray[np.bool_],
    nis: FloatArray,
    dof: NDArray[np.int64],
) -> Navigation:
    """From the midpoints between the samples to the samples."""
    middle, spread = np.empty((len(clock), 16)), np.empty((len(clock), 15))
    recursion.between(states, ends, variance, middle, spread)
    quaternion = middle[:, 0:4]
    position, velocity, gyr_bias, acc_bias = (middle[:, k : k + 3] for k in (4, 7, 10, 13))
    return Navigation(
        clock, quaternion, position, velocity, gyr_bias, acc_bias, spread, still, nis, dof
    )


def _cross_matrix(v: FloatArray) -> FloatArray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
