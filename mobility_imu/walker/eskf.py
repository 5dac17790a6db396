"""The walker's error-state Kalman filter and smoother, written to be read.

Dense 15 x 15 matrices in plain NumPy, one function for each equation. ``_kernel`` computes the same
in compiled loops; without numba, or before it has compiled, this module does the work.

The state moves with the readings (eqs 20 and 21), its error with eq. 24. Samples share a step of
the covariance in strides; where the frame stands still, a stride ends with an update. The smoother
is the adjoint form of Rauch's, Tung's and Striebel's, by Bryson and Frazier: it needs no inverse of
a covariance.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.walker.error_state import (
    ACC_BIAS,
    ATTITUDE,
    GYR_BIAS,
    POSITION,
    VELOCITY,
    Form,
    NavigationState,
    corrected_state,
    strapdown_step,
)

__all__ = [
    "Noise",
    "Update",
    "back_over_step",
    "back_over_update",
    "known_end",
    "motion_fraction",
    "predict",
    "process_noise",
    "smooth",
    "update",
    "variances_of",
    "zero_updates",
]

SATURATED_ACC_SD_MPS2 = 20.0
"""Noise of one sample, m/s², where the sensor is at the end of its range; nothing is known."""
SATURATED_GYR_SD_RADPS = 1.0
"""Noise of one sample, rad/s, where the gyroscope is at the end of its range: 60 deg/s."""

_EYE3, _EYE15 = np.eye(3), np.eye(15)


class Noise(NamedTuple):
    """Assumed noise: squares of the densities (per root of Hz; bias walks per root of s).

    The last is a factor: of gyr and acc in a move that is too long for one of a frame.
    """

    gyr: float
    acc: float
    gyr_bias_walk: float
    acc_bias_walk: float
    velocity: float
    height: float
    rate: float
    long_move: float


class Problem(NamedTuple):
    """What filter and smoother are given: n samples in m strides."""

    acc: FloatArray  # (n, 3) m/s², means over the intervals
    gyr: FloatArray  # (n, 3) rad/s
    dt: FloatArray  # (n,) s, length of the intervals
    still: NDArray[np.bool_]  # (n,)
    long_move: NDArray[np.bool_]  # (n,) whether the move is too long for one of a frame
    saturated: NDArray[np.bool_]  # (n,) whether the accelerometer is at the end of its range
    rate_saturated: NDArray[np.bool_]  # (n,) whether the gyroscope is
    observed: FloatArray  # (n, 4) velocity and height that the updates observe; (1, 4): always
    ends: NDArray[np.int64]  # (m,) sample after each stride's last
    noise: Noise
    zero_rate: bool
    form: Form
    upright_cos: float


class Update(NamedTuple):
    """What an update has computed."""

    state: NavigationState
    covariance: FloatArray
    error: FloatArray  # K z, which has corrected the state
    gain: FloatArray  # K
    information: FloatArray  # inverse of the innovation's covariance S
    nis: float  # normalised innovation squared


def motion_fraction(noise: Noise) -> float:
    """Fraction of a standing frame's measured rate that is motion.

    With the prior "rate 0 with variance s²" and a reading of variance g², the rate's best estimate
    is s²/(s²+g²) of the reading; its error does not depend on the reading less the bias, so that
    the latter may be used once more, as an observation of the bias with variance s² + g².
    """
    return noise.rate / (noise.rate + noise.gyr)


def process_noise(
    noise: Noise,
    dt_s: float,
    samples: int,
    fraction: float,
    saturated: bool,
    rate_saturated: bool = False,
) -> FloatArray:
    """Covariance Q of w in eq. 24, integrated over a stride of some samples (-v_g/2, -C'(q) v_a).

    White acceleration over the time h reaches the velocity with h, both with h²/2, and the position
    with h³/3, less what is constant within each sample.
    """
    h = dt_s
    acc = SATURATED_ACC_SD_MPS2**2 * h if saturated else noise.acc
    gyr = SATURATED_GYR_SD_RADPS**2 * h if rate_saturated else noise.gyr * fraction
    q = np.zeros((15, 15))
    q[ATTITUDE, ATTITUDE] = gyr / 4 * h * _EYE3
    q[GYR_BIAS, GYR_BIAS] = noise.gyr_bias_walk * h * _EYE3
    q[POSITION, POSITION] = acc * h**3 * (1 / 3 - 1 / (12 * samples**2)) * _EYE3
    q[POSITION, VELOCITY] = q[VELOCITY, POSITION] = acc * h**2 / 2 * _EYE3
    q[VELOCITY, VELOCITY] = acc * h * _EYE3
    q[ACC_BIAS, ACC_BIAS] = noise.acc_bias_walk * h * _EYE3
    return q


def predict(
    state: NavigationState,
    covariance: FloatArray,
    acc: FloatArray,
    gyr: FloatArray,
    dt: FloatArray,
    noise: Noise,
    *,
    fraction: float = 1.0,
    saturated: bool = False,
    rate_saturated: bool = False,
    form: Form = "corrected",
) -> tuple[list[NavigationState], FloatArray, FloatArray]:
    """States and covariance after a stride: eqs 20 and 21 at each sample, eq. 24 as P → Φ P Φ' + Q.

    Parameters
    ----------
    state, covariance : before the stride; (15, 15)
    acc, gyr : (k, 3) arrays, m/s² and rad/s, means over the stride's k intervals
    dt : (k,) array, s
    noise : Noise
    fraction : of the measured rate that counts as motion
    saturated, rate_saturated : whether accelerometer, gyroscope were at the end of their range
    form : of eq. 24

    Returns
    -------
    k states, (15, 15) transition Φ of the stride, (15, 15) covariance
    """
    states, phi = [], _EYE15
    for acc_k, gyr_k, dt_k in zip(acc, gyr, dt.tolist(), strict=True):
        state, step = strapdown_step(state, acc_k, gyr_k, dt_k, form=form, motion_fraction=fraction)
        states.append(state)
        phi = step @ phi
    q = process_noise(noise, float(dt.sum()), len(dt), fraction, saturated, rate_saturated)
    return states, phi, phi @ covariance @ phi.T + q


def update(
    state: NavigationState, covariance: FloatArray, z: FloatArray, h: FloatArray, r: FloatArray
) -> Update:
    """State and covariance after an observation: S = H P H' + R, K = P H' S⁻¹, error K z.

    Parameters
    ----------
    state, covariance : before it; (15, 15)
    z : (k,) array, innovation, observed less predicted
    h : (k, 15) array, H: what the observation says of the error state
    r : (k,) array, variances of the observations, which are independent

    Returns
    -------
    Update
    """
    information: FloatArray = np.asarray(np.linalg.inv(h @ covariance @ h.T + np.diag(r)), float)
    gain = covariance @ h.T @ information
    left = _EYE15 - gain @ h
    error = gain @ z
    after = left @ covariance @ left.T + (gain * r) @ gain.T  # Joseph's form: stays positive
    nis = float(z @ information @ z)
    return Update(corrected_state(state, error), after, error, gain, information, nis)


def zero_updates(
    state: NavigationState,
    gyr: FloatArray,
    observed: FloatArray,
    dt_s: float,
    noise: Noise,
    *,
    zero_rate: bool,
    upright: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Innovation z, matrix H and variances R of a standing frame at a stride's end.

    The velocity is zero. The height is the start's, if the frame is upright. The mean rate over
    the stride is the gyroscope's bias, if zero rates are used. A stride's mean has the noise of its
    duration.

    Parameters
    ----------
    state : NavigationState, predicted
    gyr : (k, 3) array, rad/s, readings of the stride
    observed : (k, 4) array, velocity (m/s) and height (m); zeros but for simulations
    dt_s : s, duration of the stride
    noise : Noise
    zero_rate, upright : whether rate and height are observed

    Returns
    -------
    (k,), (k, 15), (k,) arrays
    """
    seen = observed.sum(axis=0) / len(observed)
    components = [9, 10, 11]
    z = [seen[:3] - state.velocity_mps]
    r = [noise.velocity] * 3
    if upright:
        components.append(8)
        z.append(seen[3:] - state.position_m[2])
        r.append(noise.height)
    if zero_rate:
        components += [3, 4, 5]
        z.append(gyr.sum(axis=0) / len(gyr) - state.gyr_bias_radps)
        r += [noise.rate + noise.gyr] * 3
    return np.concatenate(z), _rows_of_identity(tuple(components)), np.array(r) / dt_s


@cache
def _rows_of_identity(components: tuple[int, ...]) -> FloatArray:
    h = _EYE15[list(components)]
    h.setflags(write=False)  # all strides share it
    return h


def smooth(
    covariance: FloatArray, mu: FloatArray, big_lambda: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Smoothed error P μ and covariance P - P Λ P, from what later updates say of the state.

    Parameters
    ----------
    covariance : (15, 15) array, P after the filter's update
    mu : (15,) array, μ
    big_lambda : (15, 15) array, Λ, an information matrix

    Returns
    -------
    (15,), (15, 15) arrays
    """
    return covariance @ mu, covariance - covariance @ big_lambda @ covariance


def back_over_update(
    mu: FloatArray,
    big_lambda: FloatArray,
    z: FloatArray,
    h: FloatArray,
    gain: FloatArray,
    information: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Before an update: μ → C' μ + H' S⁻¹ z and Λ → C' Λ C + H' S⁻¹ H, where C = 1 - K H."""
    c = _EYE15 - gain @ h
    weighted = h.T @ information
    return c.T @ mu + weighted @ z, c.T @ big_lambda @ c + weighted @ h


def back_over_step(
    mu: FloatArray, big_lambda: FloatArray, phi: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Before a prediction: μ → Φ' μ and Λ → Φ' Λ Φ."""
    back = phi.T @ big_lambda @ phi
    return phi.T @ mu, (back + back.T) / 2  # rounding must not grow in the unsymmetric part


def known_end(
    first: NavigationState,
    last: NavigationState,
    covariance: FloatArray,
    position_sd_m: float,
    heading_sd_rad: float,
) -> tuple[FloatArray, FloatArray]:
    """μ = H' S⁻¹ z and Λ = H' S⁻¹ H of a walk that ends where it began, turned as it was.

    Observed are the last position (x and y) and the heading: the turn about the world's z axis,
    of which an attitude error about the IMU's axes makes twice the third row of C'(q).

    Parameters
    ----------
    first, last : NavigationState, at the start and as filtered at the end
    covariance : (15, 15) array, at the end
    position_sd_m, heading_sd_rad : how well the return is known

    Returns
    -------
    (15,), (15, 15) arrays : where the smoother starts
    """
    turns = [Rotation.from_quat(state.quaternion, scalar_first=True) for state in (first, last)]
    turned = (turns[1] * turns[0].inv()).as_rotvec()[2]
    h = np.zeros((3, 15))
    h[0, 6], h[1, 7] = 1.0, 1.0
    h[2, ATTITUDE] = 2 * world_up(last)
    z = np.array([*(first.position_m - last.position_m)[:2], -turned])
    r = np.array([position_sd_m, position_sd_m, heading_sd_rad]) ** 2
    weighted = h.T @ np.linalg.inv(h @ covariance @ h.T + np.diag(r))
    return weighted @ z, weighted @ h


class Filtered(NamedTuple):
    """The filter's result, with what the smoother needs of each of m strides."""

    states: FloatArray  # (n + 1, 16): at the start and after each interval, as in ``as_row``
    covariances: FloatArray  # (m + 1, 15, 15): at the start and after each stride
    nis: FloatArray  # (n,), 0 but at the last sample of a stride with an update
    nis_dof: NDArray[np.int64]  # (n,), number of observations
    transitions: list[FloatArray]
    updates: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None]  # z, H, K, S⁻¹
    corrections: FloatArray  # (m, 15), K z; zeros without an update


def run_filter(problem: Problem, start: NavigationState, covariance: FloatArray) -> Filtered:
    """Filter all strides.

    Parameters
    ----------
    problem : Problem
    start, covariance : state where the first interval begins, (15, 15) covariance of its error

    Returns
    -------
    Filtered
    """
    count, strides = len(problem.dt), len(problem.ends)
    states, covariances = np.empty((count + 1, 16)), np.empty((strides + 1, 15, 15))
    nis, nis_dof = np.zeros(count), np.zeros(count, np.int64)
    result = Filtered(states, covariances, nis, nis_dof, [], [], np.zeros((strides, 15)))
    state, begin, up = start, 0, world_up(start)
    states[0], covariances[0] = as_row(start), covariance
    for g, end in enumerate(problem.ends.tolist()):
        stride, rest = slice(begin, end), bool(problem.still[begin])
        fraction = motion_fraction(problem.noise) if rest and problem.zero_rate else 1.0
        noise = problem.noise
        if problem.long_move[begin]:
            noise = noise._replace(gyr=noise.gyr * noise.long_move, acc=noise.acc * noise.long_move)
        path, phi, covariance = predict(
            state, covariance, problem.acc[stride], problem.gyr[stride], problem.dt[stride],
            noise, fraction=fraction, saturated=bool(problem.saturated[begin]),
            rate_saturated=bool(problem.rate_saturated[begin]), form=problem.form,
        )  # fmt: skip
        state, done = path[-1], None
        if rest:
            z, h, r = zero_updates(
                state, problem.gyr[stride],
                problem.observed[stride] if len(problem.observed) > 1 else problem.observed,
                float(problem.dt[stride].sum()), problem.noise, zero_rate=problem.zero_rate,
                upright=bool(world_up(state) @ up > problem.upright_cos),
            )  # fmt: skip
            result_of = update(state, covariance, z, h, r)
            state, covariance = result_of.state, result_of.covariance
            result.nis[end - 1], result.nis_dof[end - 1] = result_of.nis, len(z)
            done = (z, h, result_of.gain, result_of.information)
            result.corrections[g] = result_of.error
        path[-1] = state
        states[begin + 1 : end + 1] = [as_row(each) for each in path]
        covariances[g + 1] = covariance
        result.transitions.append(phi)
        result.updates.append(done)
        begin = end
    return result


def run_smoother(
    problem: Problem, filtered: Filtered, mu: FloatArray, big_lambda: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Smooth all strides, from the last to the first.

    Inside a stride the corrections are linear from sample to sample.

    Parameters
    ----------
    problem : Problem
    filtered : Filtered
    mu, big_lambda : (15,), (15, 15) arrays, what is known beyond the last update; zeros if nothing

    Returns
    -------
    (n + 1, 16) states, (m + 1, 16) variances at the strides' ends, see :func:`variances_of`
    """
    bounds = [0, *problem.ends.tolist()]
    errors = np.empty((bounds[-1] + 1, 15))
    variances, before_update = np.empty((len(bounds), 16)), np.zeros(15)
    for g in range(len(bounds) - 1, -1, -1):
        error, spread = smooth(filtered.covariances[g], mu, big_lambda)
        errors[bounds[g]], variances[g] = error, variances_of(spread)
        if g < len(bounds) - 1:
            inside = np.arange(1, bounds[g + 1] - bounds[g])[:, None]
            later = inside / (bounds[g + 1] - bounds[g])
            errors[bounds[g] + 1 : bounds[g + 1]] = (1 - later) * error + later * before_update
        if g == 0:
            break
        before_update = error + filtered.corrections[g - 1]
        done = filtered.updates[g - 1]
        if done is not None:
            mu, big_lambda = back_over_update(mu, big_lambda, *done)
        mu, big_lambda = back_over_step(mu, big_lambda, filtered.transitions[g - 1])
    states = np.empty_like(filtered.states)
    for k, error in enumerate(errors):
        states[k] = as_row(corrected_state(from_row(filtered.states[k]), error))
    return states, variances


def variances_of(covariances: FloatArray) -> FloatArray:
    """Variances of the error state, (..., 15), and after them the covariance of x and y.

    Parameters
    ----------
    covariances : (..., 15, 15) array

    Returns
    -------
    (..., 16) array
    """
    diagonal = np.maximum(np.diagonal(covariances, axis1=-2, axis2=-1), 0)  # rounding
    x, y = POSITION.start, POSITION.start + 1
    return np.concatenate([diagonal, covariances[..., x, y, None]], axis=-1)


def stride_ends(
    still: NDArray[np.bool_], alone: NDArray[np.bool_], moving: int, resting: int
) -> NDArray[np.int64]:
    """Sample after each stride's last; no stride holds still and moving samples.

    Samples that stand alone, and those near the ends of a rest, each are a stride: there the
    updates tell most.

    Parameters
    ----------
    still, alone : (n,) bool arrays
    moving, resting : most samples in a stride of a moving and of a resting frame

    Returns
    -------
    (m,) int64 array
    """
    changes = (still[1:] != still[:-1]) | (alone[1:] != alone[:-1])
    bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), len(still)]
    ends: list[int] = []
    for begin, stop in pairwise(bounds):
        if alone[begin]:
            ends += range(begin + 1, stop + 1)
        elif not still[begin]:
            ends += [*range(begin + moving, stop, moving), stop]
        else:
            first = min(begin + resting, stop)
            last = max(stop - resting, first)  # between these, strides of several samples
            ends += range(begin + 1, first + 1)
            ends += range(first + resting, last, resting)
            ends += range(last if last > first else first + 1, stop + 1)
    return np.array(ends, np.int64)


def world_up(state: NavigationState) -> FloatArray:
    """The world's upward axis in the IMU's axes: last row of C'(q)."""
    w, x, y, z = state.quaternion.tolist()
    return np.array([2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z])


def as_row(state: NavigationState) -> FloatArray:
    """State as 16 numbers: attitude, position, velocity, biases of gyroscope, accelerometer."""
    return np.concatenate(state)


def from_row(x: FloatArray) -> NavigationState:
    """State from 16 numbers."""
    return NavigationState(x[0:4], x[4:7], x[7:10], x[10:13], x[13:16])
