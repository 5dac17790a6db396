"""Loops of the fusion: a Kalman filter that also learns what is constant, and its smoother.

What changes from sample to sample is the state: both angles, the drift of both hinges' rates, and a
disturbance of the lever's acceleration. What stays, errors of the sensors and lever arms, are
constants. Each state keeps its derivative by the constants, so that the many constants cost no
large covariance (Friedland's separated bias estimation, IEEE Trans. Autom. Control 14, 1969). The
result is that of a filter that has state and constants in one vector.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from mobility_imu._compiled import compiled
from mobility_imu.frames import FloatArray
from mobility_imu.hinges import hinge_rates, tip_reading

__all__ = [
    "ARMS",
    "CONSTANTS",
    "STATES",
    "Chunk",
    "Estimate",
    "Inputs",
    "Model",
    "arm_acceleration",
    "correct",
    "plain",
    "predict",
    "reading_errors",
    "run_filter",
    "run_smoother",
]

STATES = 7
"""Steering, throttle, drift of both hinges' rates, disturbance in the lever's x, y, z."""
CONSTANTS = 45
"""For lever, then body: offset, scale, misalignment, gyroscope's scale and offset, and by how much
its axes are off those of the accelerometer, each x, y, z; then the three lever arms."""
BODY, ARMS = 18, 36
"""Where the body's errors and the lever arms begin among the constants."""
SLOPE_SMOOTHING_S = 0.3
"""Time constant of the acceleration from which the filter takes its derivatives."""


class Inputs(NamedTuple):
    """Readings in {T} and {B}, and what follows from them alone.

    Parameters
    ----------
    lever_acc, lever_gyr, body_acc, body_gyr : (n, 3) arrays, m/s² and rad/s
    lever_spin, body_spin : (n, 3) arrays, rad/s², derivatives of the rates
    """

    lever_acc: FloatArray
    lever_gyr: FloatArray
    body_acc: FloatArray
    body_gyr: FloatArray
    lever_spin: FloatArray
    body_spin: FloatArray


class Model(NamedTuple):
    """Numbers of the model that stay over a recording.

    Parameters
    ----------
    dt : s
    sin_alpha, cos_alpha : of the shaft's inclination
    lean : rad, the tip's angle with the lever released
    noise : (m/s²)², white noise of the lever's acceleration against the body's
    disturbance : (m/s²)², variance of the coloured disturbance
    decay : autocorrelation of the disturbance after one sample
    drift : (2,) array, rad² and (rad/s)² by which angles and drifts wander in one sample
    huber : sd beyond which a residual counts less
    """

    dt: float
    sin_alpha: float
    cos_alpha: float
    lean: float
    noise: float
    disturbance: float
    decay: float
    drift: FloatArray
    huber: float


class Estimate(NamedTuple):
    """What the filter knows after a sample.

    Parameters
    ----------
    state : (7,) array
    covariance : (7, 7) array, of the state if the constants were known
    by_constants : (7, 45) array, derivative of the state's error by the constants' error
    constants : (45,) array
    constants_covariance : (45, 45) array
    slow : (3,) array, m/s², smoothed acceleration of the body
    """

    state: FloatArray
    covariance: FloatArray
    by_constants: FloatArray
    constants: FloatArray
    constants_covariance: FloatArray
    slow: FloatArray


class Chunk(NamedTuple):
    """What a run of the filter gives for its samples, and what its smoother needs.

    Parameters
    ----------
    states : (n, 7) array
    sd : (n, 2) array, rad, of both angles with what the constants add; undefined with ``keep``
    residuals : (n, 3) array, m/s², before each correction, the disturbance among them
    gains : (n, 7, 7) array, of the smoother from the sample after to this one
    offsets, remainders, couplings : (n, 7), (n, 7, 7) and (n, 7, 45) arrays: the smoothed state is
        ``gain @ state after + offset + coupling @ constants``, its covariance has the remainder
    """

    states: FloatArray
    sd: FloatArray
    residuals: FloatArray
    gains: FloatArray
    offsets: FloatArray
    remainders: FloatArray
    couplings: FloatArray


@compiled()
def _add_block(matrix: FloatArray, row: int, column: int, block: FloatArray, factor: float) -> None:
    """Add a block to a part of a matrix. A slice would do; it takes seconds more to compile.

    Parameters
    ----------
    matrix : (n, m) array, changed
    row, column : where the block begins
    block : (i, j) array
    factor : of the block
    """
    for i in range(block.shape[0]):
        for j in range(block.shape[1]):
            matrix[row + i, column + j] += factor * block[i, j]


@compiled()
def arm_acceleration(rate: FloatArray, spin: FloatArray) -> FloatArray:
    """Acceleration by a lever arm: ``(spin x + rate x rate x) arm``, Euler and centripetal.

    Parameters
    ----------
    rate, spin : (3,) arrays, rad/s and rad/s², of the rigid body, in its axes

    Returns
    -------
    (3, 3) array, 1/s²
    """
    x, y, z = rate[0], rate[1], rate[2]
    a, b, c = spin[0], spin[1], spin[2]
    return np.array(
        [
            [-y * y - z * z, x * y - c, x * z + b],
            [x * y + c, -x * x - z * z, y * z - a],
            [x * z - b, y * z + a, -x * x - y * y],
        ]
    )


@compiled()
def reading_errors(reading: FloatArray) -> FloatArray:
    """Error of a reading by offset, scale and misalignment, nine columns.

    ``error = offset + scale * reading + misalignment x reading``: a scale or an axis that is off
    acts like an offset that turns with the attitude.

    Parameters
    ----------
    reading : (3,) array

    Returns
    -------
    (3, 9) array
    """
    errors = np.zeros((3, 9))
    x, y, z = reading[0], reading[1], reading[2]
    for i in range(3):
        errors[i, i] = 1.0
        errors[i, 3 + i] = reading[i]
    errors[0, 7], errors[0, 8] = z, -y
    errors[1, 6], errors[1, 8] = -z, x
    errors[2, 6], errors[2, 7] = y, -x
    return errors


@compiled()
def _true_rate(reading: FloatArray, c: FloatArray, at: int) -> FloatArray:
    """Rate of the sensor whose errors begin at ``at``, without them."""
    x, y, z = c[at + 6] + c[at + 15], c[at + 7] + c[at + 16], c[at + 8] + c[at + 17]
    a, b, d = reading[0], reading[1], reading[2]
    return np.array(
        [
            a - (y * d - z * b) - c[at + 9] * a - c[at + 12],
            b - (z * a - x * d) - c[at + 10] * b - c[at + 13],
            d - (x * b - y * a) - c[at + 11] * d - c[at + 14],
        ]
    )


@compiled()
def predict(
    lever_rate: FloatArray, body_rate: FloatArray, before: Estimate, model: Model
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """State one sample later: the hinges turn by the difference of the gyroscopes.

    Parameters
    ----------
    lever_rate, body_rate : (3,) arrays, rad/s, mean readings over the sample
    before : Estimate
    model : Model

    Returns
    -------
    state, covariance, by_constants : as in Estimate
    transition : (7, 7) array
    """
    x, c, dt = before.state.copy(), before.constants, model.dt
    sa, ca, tip = model.sin_alpha, model.cos_alpha, x[1] + model.lean
    lever, body = _true_rate(lever_rate, c, 0), _true_rate(body_rate, c, BODY)
    rate_s, rate_t, s_by_t, t_by_s = hinge_rates(lever, body, x[0], tip, sa, ca)
    st, ct, ss, cs = np.sin(tip), np.cos(tip), np.sin(x[0]), np.cos(x[0])
    by_lever = np.array([[0.0, -st, ct], [-1.0, 0.0, 0.0]])
    by_body = np.array([[0.0, sa, -ca], [cs, ca * ss, sa * ss]])
    f = np.eye(STATES)
    f[0, 1], f[0, 2] = dt * s_by_t, -dt
    f[1, 0], f[1, 3] = dt * t_by_s, -dt
    x[0] += dt * (rate_s - x[2])
    x[1] += dt * (rate_t - x[3])
    v = f @ before.by_constants
    p = f @ before.covariance @ f.T
    for at, rate, by_rate in ((0, lever_rate, by_lever), (BODY, body_rate, by_body)):
        # Columns of reading_errors are offset, scale, misalignment.
        columns = dt * (by_rate @ reading_errors(rate))
        _add_block(v, 0, at + 12, columns[:, :3], -1.0)
        _add_block(v, 0, at + 9, columns[:, 3:6], -1.0)
        _add_block(v, 0, at + 6, columns[:, 6:], -1.0)
        _add_block(v, 0, at + 15, columns[:, 6:], -1.0)
    for i in range(2):
        p[i, i] += model.drift[0]
        p[2 + i, 2 + i] += model.drift[1]
    for i in range(4, STATES):
        f[i, i] = model.decay
        x[i] *= model.decay
        for j in range(CONSTANTS):
            v[i, j] *= model.decay
        for j in range(STATES):
            p[i, j] *= model.decay
            p[j, i] *= model.decay
        p[i, i] += model.disturbance * (1 - model.decay**2)
    return x, p, v, f


@compiled()
def _measurement(
    inputs: Inputs, k: int, x: FloatArray, c: FloatArray, slow: FloatArray, model: Model
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residual of the lever's acceleration, its slopes by the state, and by the constants."""
    sa, ca, tip = model.sin_alpha, model.cos_alpha, x[1] + model.lean
    st, ct = np.sin(tip), np.cos(tip)
    rx, ry, rz, _ = tip_reading(np.eye(3), x[0], tip, sa, ca)
    turn = np.empty((3, 3))
    turn[0], turn[1], turn[2] = rx, ry, rz
    # Slopes come from a smoothed acceleration: with the raw one its noise would stand in residual
    # and slope alike, and vibration would pull angles and constants to one side.
    errors = reading_errors(slow)
    steady = slow - errors @ c[BODY : BODY + 9]
    sx, sy, sz, k2 = tip_reading(steady, x[0], tip, sa, ca)
    # The column between both hinges turns with the lever but for the throttle's rate about x.
    lever = _true_rate(inputs.lever_gyr[k], c, 0)
    body = _true_rate(inputs.body_gyr[k], c, BODY)
    rate_s, rate_t, _, ahead = hinge_rates(lever, body, x[0], tip, sa, ca)
    spin, body_spin = inputs.lever_spin[k], inputs.body_spin[k]
    column = np.array([lever[0] + rate_t, lever[1], lever[2]])
    column_spin = np.array(
        [
            rx @ body_spin + rate_s * ahead,
            spin[1] + rate_t * lever[2],
            spin[2] - rate_t * lever[1],
        ]
    )
    to_lever = np.array([[1.0, 0.0, 0.0], [0.0, ct, -st], [0.0, st, ct]])
    h = np.zeros((3, STATES))
    h[0, 0] = k2
    h[1, 0], h[1, 1] = -sx * ct, -sz
    h[2, 0], h[2, 1] = -sx * st, sy
    by_c = np.zeros((3, CONSTANTS))
    for i in range(3):
        h[i, 4 + i] = 1.0
    _add_block(by_c, 0, 0, reading_errors(np.array([sx, sy, sz])), 1.0)
    _add_block(by_c, 0, BODY, turn @ errors, -1.0)
    _add_block(by_c, 0, ARMS, arm_acceleration(lever, spin), 1.0)
    _add_block(by_c, 0, ARMS + 3, turn @ arm_acceleration(body, body_spin), -1.0)
    _add_block(by_c, 0, ARMS + 6, arm_acceleration(column, column_spin) @ to_lever, 1.0)
    residual = inputs.lever_acc[k] - turn @ inputs.body_acc[k] - by_c @ c - x[4:]
    return residual, h, by_c


@compiled()
def correct(
    x: FloatArray,
    p: FloatArray,
    v: FloatArray,
    c: FloatArray,
    m: FloatArray,
    residual: FloatArray,
    h: FloatArray,
    by_c: FloatArray,
    noise: float,
    huber: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """State and constants after one reading of three axes.

    ``sensitivity = by_c + h v`` is the residual's derivative by the constants with the state that
    follows from them; the state's own gain is that for known constants.

    Parameters
    ----------
    x, p, v, c, m : state, covariance, by_constants, constants and their covariance, as in Estimate
    residual : (3,) array, m/s²
    h, by_c : (3, 7) and (3, 45) arrays, slopes by the state and by the constants
    noise : (m/s²)², per axis
    huber : a residual beyond this many sd counts less: blows are far from Gaussian

    Returns
    -------
    x, p, v, c, m : after the correction
    """
    sensitivity = by_c + h @ v
    hp, sm = h @ p, sensitivity @ m
    own, whole = hp @ h.T, sm @ sensitivity.T
    for i in range(3):
        own[i, i] += noise
    # Rounding may make a squared distance negative.
    squared = residual @ np.linalg.solve(own + whole, residual) / 3
    distance = np.sqrt(np.maximum(squared, 0.0))
    if distance > huber:
        for i in range(3):
            own[i, i] += noise * ((distance / huber) ** 2 - 1)
    gain = np.linalg.solve(own, hp).T
    weighed = np.linalg.solve(own + whole, sm)
    step = residual @ weighed
    x = x + v @ step + gain @ (residual - sensitivity @ step)
    p = p - gain @ hp
    m = m - sm.T @ weighed
    return x, (p + p.T) / 2, v - gain @ sensitivity, c + step, m


@compiled()
def run_filter(
    inputs: Inputs, first: int, last: int, before: Estimate, model: Model, keep: bool
) -> tuple[Chunk, Estimate]:
    """Filter over the samples from ``first`` up to ``last``.

    Parameters
    ----------
    inputs : Inputs
    first, last : samples; the sample before ``first`` is where ``before`` stands
    before : Estimate; at the start of the recording what is assumed
    model : Model
    keep : whether to keep what the smoother needs

    Returns
    -------
    chunk : Chunk; without ``keep`` its last four arrays are empty
    after : Estimate after the last sample
    """
    count = last - first
    kept = count if keep else 0
    states, sd, residuals = np.empty((count, STATES)), np.empty((count, 2)), np.empty((count, 3))
    gains, offsets = np.zeros((kept, STATES, STATES)), np.zeros((kept, STATES))
    remainders = np.zeros((kept, STATES, STATES))
    couplings = np.zeros((kept, STATES, CONSTANTS))
    slow = before.slow.copy()
    x, p, v, c, m = (
        before.state, before.covariance, before.by_constants, before.constants,
        before.constants_covariance,
    )  # fmt: skip
    for k in range(first, last):
        i = k - first
        if k > 0:
            at = Estimate(x, p, v, c, m, slow)
            lever = (inputs.lever_gyr[k] + inputs.lever_gyr[k - 1]) / 2
            body = (inputs.body_gyr[k] + inputs.body_gyr[k - 1]) / 2
            x_next, p_next, v_next, f = predict(lever, body, at, model)
            if keep:
                g = np.linalg.solve(p_next, f @ p).T
                u = v - g @ v_next
                gains[i], couplings[i] = g, u
                offsets[i] = x - g @ x_next - u @ c
                remainders[i] = p - g @ p_next @ g.T
            x, p, v = x_next, p_next, v_next
        slow += model.dt / SLOPE_SMOOTHING_S * (inputs.body_acc[k] - slow)
        residual, h, by_c = _measurement(inputs, k, x, c, slow, model)
        residuals[i] = residual + x[4:]
        x, p, v, c, m = correct(x, p, v, c, m, residual, h, by_c, model.noise, model.huber)
        states[i] = x
        if not keep:
            sd[i] = _angle_sd(p, v, m)
    chunk = Chunk(states, sd, residuals, gains, offsets, remainders, couplings)
    return chunk, Estimate(x, p, v, c, m, slow)


@compiled()
def _angle_sd(p: FloatArray, v: FloatArray, m: FloatArray) -> FloatArray:
    """Standard deviation of both angles: their own, and what the constants add."""
    by_steering, by_throttle = v[0] @ m @ v[0], v[1] @ m @ v[1]
    both = np.array([p[0, 0] + by_steering, p[1, 1] + by_throttle])
    return np.asarray(np.sqrt(np.maximum(both, 0.0)))


@compiled()
def run_smoother(
    chunk: Chunk,
    state: FloatArray,
    covariance: FloatArray,
    by_constants: FloatArray,
    constants: FloatArray,
    constants_covariance: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """States given the whole recording (Rauch-Tung-Striebel), from a chunk's end to before it.

    The constants of the last sample hold for all; each state follows from the one after and them.

    Parameters
    ----------
    chunk : Chunk
    state, covariance, by_constants : smoothed, of the chunk's last sample
    constants, constants_covariance : of the recording's last sample

    Returns
    -------
    states : (n, 7) array
    sd : (n, 2) array, rad, of both angles
    state, covariance, by_constants : smoothed, of the sample before the chunk
    """
    count = len(chunk.states)
    states, sd = np.empty((count, STATES)), np.empty((count, 2))
    x, p, v = state, covariance, by_constants
    for i in range(count - 1, -1, -1):
        states[i] = x
        sd[i] = _angle_sd(p, v, constants_covariance)
        g = chunk.gains[i]
        x = g @ x + chunk.offsets[i] + chunk.couplings[i] @ constants
        v = g @ v + chunk.couplings[i]
        p = g @ p @ g.T + chunk.remainders[i]
    return states, sd, x, p, v


def plain(function: Any) -> Any:
    """Python of a compiled function that calls no compiled one either; itself without numba.

    Parameters
    ----------
    function : a compiled one

    Returns
    -------
    function
    """
    from types import FunctionType

    body = getattr(function, "py_func", function)
    called = {
        name: plain(value)
        for name, value in body.__globals__.items()
        if name in body.__code__.co_names and hasattr(value, "py_func")
    }
    return FunctionType(
        body.__code__, {**body.__globals__, **called}, body.__name__, body.__defaults__
    )
