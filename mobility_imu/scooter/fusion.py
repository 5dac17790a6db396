"""Steering and throttle angles from accelerometers and gyroscopes together.

The two controls are hinges: what the lever's gyroscope reads beyond the body's is their motion.
An extended Kalman filter integrates that, corrects it with eq. 5 sample by sample, and learns the
difference of the gyroscopes' biases; a Rauch-Tung-Striebel pass then lets each angle use the whole
recording.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu._compiled import compiled
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_vectors
from mobility_imu.hinges import hinge_rates, tip_reading
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.geometry import ScooterGeometry

SLOPE_SMOOTHING_S = 0.3
"""Time constant of the acceleration from which the filter takes its derivatives."""


@dataclass(frozen=True)
class FusionSettings:
    """What the filter takes for granted.

    Parameters
    ----------
    acc_sd_mps2 : m/s², sd per axis of the difference between the lever's acceleration and what
        eq. 5 makes of the body's; None takes it from the recording, see :func:`acceleration_noise`
    rate_sd_radps : rad/s per sample, noise of the difference of the rates (two gyroscopes, flexing)
    bias_sd_radps : rad/s, how far the rates' bias may be off at the start
    bias_walk_radps : rad/s per square root of s, how fast it may wander
    huber : residuals beyond this many sd count less
    """

    acc_sd_mps2: float | None = None
    rate_sd_radps: float = 0.01
    bias_sd_radps: float = 0.01
    bias_walk_radps: float = 1e-4
    huber: float = 2.0


class FusedAngles(NamedTuple):
    """Angles with their standard deviations, (n,) arrays in rad, and a flag for each sample."""

    steering_rad: FloatArray
    throttle_rad: FloatArray
    steering_sd_rad: FloatArray
    throttle_sd_rad: FloatArray
    valid: NDArray[np.bool_]


def acceleration_noise(lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike) -> float:
    """Noise of eq. 5 per axis, m/s², from the lengths of the two accelerations.

    Whatever the angles, both IMUs should measure the same length; the spread of the difference
    (robust, from the median absolute deviation) is the noise along one direction.
    """
    lever, body = as_vectors(lever_acc_mps2, "lever"), as_vectors(body_acc_mps2, "body")
    apart = np.linalg.norm(lever, axis=1) - np.linalg.norm(body, axis=1)
    return float(1.4826 * np.median(np.abs(apart - np.median(apart))))


def move_specific_force(
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    arm_m: ArrayLike,
    sampling_rate_hz: float,
    *,
    smoothing_s: float = 0.02,
) -> FloatArray:
    """Specific force at another place of the same rigid body: Euler and centripetal terms added.

    Parameters
    ----------
    acc_mps2, gyr_radps : (n, 3) arrays, m/s² and rad/s, in the body's axes
    arm_m : (3,) array, m, from the sensor to the other place
    sampling_rate_hz : Hz
    smoothing_s : s, Gaussian smoothing of the derivative of the rate
    """
    acc, gyr = as_vectors(acc_mps2, "acc_mps2"), as_vectors(gyr_radps, "gyr_radps")
    arm = np.asarray(arm_m, float)
    spin_up = ndimage.gaussian_filter1d(gyr, smoothing_s * sampling_rate_hz, axis=0, order=1)
    euler = np.cross(spin_up * sampling_rate_hz, arm)
    return acc + euler + np.cross(gyr, np.cross(gyr, arm))


def fuse_angles(
    lever_acc_mps2: ArrayLike,
    lever_gyr_radps: ArrayLike,
    body_acc_mps2: ArrayLike,
    body_gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
    settings: FusionSettings | None = None,
    *,
    smooth: bool = True,
) -> FusedAngles:
    """Angles by an extended Kalman filter, with the smoother unless ``smooth`` is False."""
    settings = settings or FusionSettings()
    arrays = [
        np.ascontiguousarray(as_vectors(values, name))
        for name, values in (
            ("lever_acc_mps2", lever_acc_mps2),
            ("lever_gyr_radps", lever_gyr_radps),
            ("body_acc_mps2", body_acc_mps2),
            ("body_gyr_radps", body_gyr_radps),
        )
    ]
    shapes = {array.shape for array in arrays}
    if len(shapes) != 1 or arrays[0].ndim != 2:
        raise InputError(
            f"accelerations and rates have shapes {sorted(shapes)}: expected all (n, 3)"
        )
    lever_acc, lever_gyr, body_acc, body_gyr = arrays
    noise = settings.acc_sd_mps2 or acceleration_noise(lever_acc, body_acc)
    first = slice(0, max(1, round(0.5 * sampling_rate_hz)))
    start = three_axis_angles(
        np.median(lever_acc[first], axis=0), np.median(body_acc[first], axis=0), geometry
    )
    alpha = geometry.steering_inclination_rad
    lean = geometry.lean_rad
    state = np.array([*start, 0.0, 0.0], float)
    spread = np.diag([0.35, 0.35, settings.bias_sd_radps, settings.bias_sd_radps]) ** 2
    dt = 1 / sampling_rate_hz
    drift = np.array(
        [(settings.rate_sd_radps * dt) ** 2] * 2 + [settings.bias_walk_radps**2 * dt] * 2
    )
    x, p, x_before, p_before, steps = _filter(
        lever_acc, lever_gyr, body_acc, body_gyr, np.median(body_acc[first], axis=0), dt, alpha,
        lean, noise**2, drift, settings.huber, state, spread,
    )  # fmt: skip
    if smooth:
        x, p = _smooth(x, p, x_before, p_before, steps)
    sd = np.sqrt(np.maximum(p[:, [0, 1], [0, 1]], 0))
    valid = np.isfinite(x).all(axis=1) & (sd[:, 0] < np.deg2rad(20))
    return FusedAngles(x[:, 0], x[:, 1], sd[:, 0], sd[:, 1], valid)


@compiled()
def _filter(
    lever_acc, lever_gyr, body_acc, body_gyr, slow, dt, alpha, lean, noise, drift, huber, x, p
):
    count = len(lever_acc)
    xs, ps = np.empty((count, 4)), np.empty((count, 4, 4))
    xs_before, ps_before = np.empty((count, 4)), np.empty((count, 4, 4))
    steps = np.empty((count, 4, 4))
    ca, sa = np.cos(alpha), np.sin(alpha)
    h, res = np.empty((3, 4)), np.empty(3)
    h[:] = 0.0
    x, p, slow = x.copy(), p.copy(), slow.copy()
    for k in range(count):
        f = np.eye(4)
        if k > 0:
            gt, gb = (lever_gyr[k] + lever_gyr[k - 1]) / 2, (body_gyr[k] + body_gyr[k - 1]) / 2
            rate_s, rate_t, s_by_t, t_by_s = hinge_rates(gt, gb, x[0], x[1] + lean, sa, ca)
            f[0, 1], f[0, 2] = dt * s_by_t, -dt
            f[1, 0], f[1, 3] = dt * t_by_s, -dt
            x[0] += dt * (rate_s - x[2])
            x[1] += dt * (rate_t - x[3])
            p = f @ p @ f.T
            for i in range(4):
                p[i, i] += drift[i]
        steps[k] = f
        xs_before[k], ps_before[k] = x, p
        s, phi = x[0], x[1] + lean
        tx, ty, tz, k2 = tip_reading(body_acc[k], s, phi, sa, ca)
        res[0], res[1], res[2] = lever_acc[k, 0] - tx, lever_acc[k, 1] - ty, lever_acc[k, 2] - tz
        # The slopes come from a smoothed acceleration: with the raw one its noise would stand in
        # residual and slope alike, and vibration would pull the angles to one side.
        slow += dt / SLOPE_SMOOTHING_S * (body_acc[k] - slow)
        tx, ty, tz, k2 = tip_reading(slow, s, phi, sa, ca)
        cp, sp = np.cos(phi), np.sin(phi)
        h[0, 0], h[0, 1] = k2, 0.0
        h[1, 0], h[1, 1] = -tx * cp, -tz
        h[2, 0], h[2, 1] = -tx * sp, ty
        # Blows are far from Gaussian: what lies beyond the bound counts less.
        innovation = h @ p @ h.T
        for i in range(3):
            innovation[i, i] += noise
        distance = np.sqrt(res @ np.linalg.solve(innovation, res) / 3)
        r = noise * max(1.0, (distance / huber) ** 2)
        dx = np.zeros(4)
        for i in range(3):
            ph = p @ h[i]
            variance = h[i] @ ph + r
            gain = ph / variance
            dx += gain * (res[i] - h[i] @ dx)
            p = p - np.outer(gain, ph)
        p = (p + p.T) / 2
        x = x + dx
        xs[k], ps[k] = x, p
    return xs, ps, xs_before, ps_before, steps


@compiled()
def _smooth(x, p, x_before, p_before, steps):
    xs, ps = x.copy(), p.copy()
    for k in range(len(x) - 2, -1, -1):
        gain = np.linalg.solve(p_before[k + 1], steps[k + 1] @ p[k]).T
        xs[k] = x[k] + gain @ (xs[k + 1] - x_before[k + 1])
        ps[k] = p[k] + gain @ (ps[k + 1] - p_before[k + 1]) @ gain.T
    return xs, ps


def complementary_angles(
    lever_acc_mps2: ArrayLike,
    lever_gyr_radps: ArrayLike,
    body_acc_mps2: ArrayLike,
    body_gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
    *,
    time_constant_s: float = 1.5,
) -> tuple[FloatArray, FloatArray]:
    """Angles by a causal complementary filter: gyroscopes for the fast, eq. 5 for the slow.

    The hinges' rates, the lever's gyroscope less the body's, are integrated; the result is drawn to
    the angles of :func:`~mobility_imu.scooter.angles.three_axis_angles` from the raw accelerations
    with the time constant. It starts from the median of the first half second: start at rest.

    Parameters
    ----------
    lever_acc_mps2, lever_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {T}
    body_acc_mps2, body_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {B}
    sampling_rate_hz : Hz
    geometry : ScooterGeometry
    time_constant_s : s. A bias of b rad/s between the gyroscopes leaves b * time_constant_s. At
        1.5 s the 0.3 deg/s of a usual gyroscope costs about half a degree; a shorter one lets more
        of the shaking through.

    Returns
    -------
    steering_rad, throttle_rad : (n,) arrays, rad
    """
    if not (sampling_rate_hz > 0 and time_constant_s > 0):
        raise InputError(
            f"sampling_rate_hz = {sampling_rate_hz}, time_constant_s = {time_constant_s}: "
            "expected positive numbers"
        )
    arrays = [
        np.ascontiguousarray(as_vectors(values, name))
        for values, name in (
            (lever_acc_mps2, "lever_acc_mps2"),
            (lever_gyr_radps, "lever_gyr_radps"),
            (body_acc_mps2, "body_acc_mps2"),
            (body_gyr_radps, "body_gyr_radps"),
        )
    ]
    if len({array.shape for array in arrays}) != 1 or arrays[0].ndim != 2:
        raise InputError(f"shapes {[array.shape for array in arrays]}: expected all (n, 3)")
    lever_acc, lever_gyr, body_acc, body_gyr = arrays
    first = slice(0, max(1, round(0.5 * sampling_rate_hz)))
    start = three_axis_angles(
        np.median(lever_acc[first], axis=0), np.median(body_acc[first], axis=0), geometry
    )
    slow = np.column_stack(three_axis_angles(lever_acc, body_acc, geometry))
    alpha = geometry.steering_inclination_rad
    out = _complement(
        slow, lever_gyr, body_gyr, np.array(start, float), 1 / sampling_rate_hz, time_constant_s,
        alpha, geometry.lean_rad,
    )  # fmt: skip
    return out[:, 0], out[:, 1]


@compiled()
def _complement(slow, lever_gyr, body_gyr, start, dt, time_constant, alpha, lean):
    out = np.empty_like(slow)
    ca, sa = np.cos(alpha), np.sin(alpha)
    share = dt / (time_constant + dt)
    s, t = start[0], start[1]
    for k in range(len(slow)):
        if k > 0:
            gt, gb = (lever_gyr[k] + lever_gyr[k - 1]) / 2, (body_gyr[k] + body_gyr[k - 1]) / 2
            rate_s, rate_t, _, _ = hinge_rates(gt, gb, s, t + lean, sa, ca)
            s += dt * rate_s
            t += dt * rate_t
        # Shortest way round: a blow may throw the slow angle across +-180 deg.
        s += share * ((slow[k, 0] - s + np.pi) % (2 * np.pi) - np.pi)
        t += share * ((slow[k, 1] - t + np.pi) % (2 * np.pi) - np.pi)
        out[k, 0], out[k, 1] = s, t
    return out
