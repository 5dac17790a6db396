"""Steering and throttle angles from accelerometers and gyroscopes together.

The two controls are hinges: what the lever's gyroscope reads beyond the body's is their motion.
An extended Kalman filter integrates that, corrects it with eq. 5 sample by sample, and learns the
difference of the gyroscopes' biases; a Rauch-Tung-Striebel pass then lets each angle use the whole
recording. A complementary filter stands beside it, as a simpler baseline.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu._compiled import compiled
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_vectors, check_positive
from mobility_imu.hinges import hinge_rates, tip_reading
from mobility_imu.results import Result
from mobility_imu.scooter.angles import check_gravity, three_axis_angles
from mobility_imu.scooter.geometry import ScooterGeometry

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "FusedAngles",
    "FusionSettings",
    "acceleration_noise",
    "complementary_angles",
    "fuse_angles",
    "move_specific_force",
]

SLOPE_SMOOTHING_S = 0.3
"""Time constant of the acceleration from which the filter takes its derivatives."""
LARGEST_VALID_SD_RAD = float(np.deg2rad(20.0))
"""Standard deviation of the steering from which a sample is not valid."""
SMALLEST_NOISE_MPS2 = 1e-3
"""Noise that :func:`acceleration_noise` finds at least; no accelerometer of a scooter has less."""
SLOWEST_RATE_HZ = 10.0
"""Sampling rate below which the rates cannot be integrated; the controls turn within 0.1 s."""
LARGEST_ACC_MPS2 = 2000.0
"""Largest component of an acceleration, m/s²; beyond what such sensors measure (200 g)."""
LARGEST_RATE_RADPS = 100.0
"""Largest component of a rate, rad/s; beyond what such sensors measure (4000 deg/s is 70)."""
# Beyond these the squares in the filter's matrices lose all digits.
SETTING_LIMITS = {
    "acc_sd_mps2": (1e-4, 1e8),
    "rate_noise_radps_sqrthz": (1e-6, 10.0),
    "bias_sd_radps": (1e-8, 10.0),
    "bias_walk_radps": (1e-10, 10.0),
    "huber": (1e-3, 1e8),
}
"""Smallest and largest value of each setting of the filter."""


@dataclass(frozen=True)
class FusionSettings:
    """Assumed noise model of the filter.

    Parameters
    ----------
    acc_sd_mps2 : m/s², sd per axis of the difference between the lever's acceleration and what
        eq. 5 makes of the body's; None takes it from the recording, see :func:`acceleration_noise`
    rate_noise_radps_sqrthz : rad/s per square root of Hz, density of the noise of the difference
        of the rates (two gyroscopes, flexing); at 100 Hz the default is 0.01 rad/s per sample
    bias_sd_radps : rad/s, how far the rates' bias may be off at the start
    bias_walk_radps : rad/s per square root of s, how fast it may wander
    huber : residuals beyond this many sd count less

    Raises
    ------
    InputError
        If a value is no positive number, or beyond what can be computed with.
    """

    acc_sd_mps2: float | None = None
    rate_noise_radps_sqrthz: float = 0.001
    bias_sd_radps: float = 0.01
    bias_walk_radps: float = 1e-4
    huber: float = 2.0

    def __post_init__(self) -> None:
        """Check every number."""
        names = [field.name for field in dataclasses.fields(self)]
        given = [name for name in names if name != "acc_sd_mps2" or self.acc_sd_mps2 is not None]
        check_positive(self, *given)
        for name in given:
            low, high = SETTING_LIMITS[name]
            if not low <= getattr(self, name) <= high:
                raise InputError(
                    f"FusionSettings.{name} = {getattr(self, name):g}: expected between {low:g} "
                    f"and {high:g}"
                )


@dataclass(frozen=True, eq=False, repr=False)
class FusedAngles(Result):
    """Angles of the filter with their standard deviations.

    Parameters
    ----------
    steering_rad, throttle_rad : (n,) arrays, rad
    steering_sd_rad, throttle_sd_rad : (n,) arrays, rad, one standard deviation
    valid : (n,) bool array: the numbers are finite, and the sd of the steering is below
        ``LARGEST_VALID_SD_RAD``
    settings : FusionSettings, with the noise that was taken from the recording
    warnings : sentences for the user
    """

    steering_rad: FloatArray
    throttle_rad: FloatArray
    steering_sd_rad: FloatArray
    throttle_sd_rad: FloatArray
    valid: NDArray[np.bool_]
    settings: FusionSettings
    warnings: tuple[str, ...] = ()

    def to_frame(self) -> pd.DataFrame:
        """Table in degrees with steering_deg, throttle_deg, their sd, and valid."""
        import pandas as pd

        return pd.DataFrame(
            {
                "steering_deg": np.rad2deg(self.steering_rad),
                "throttle_deg": np.rad2deg(self.throttle_rad),
                "steering_sd_deg": np.rad2deg(self.steering_sd_rad),
                "throttle_sd_deg": np.rad2deg(self.throttle_sd_rad),
                "valid": self.valid,
            }
        )


class _Readings(NamedTuple):
    """Contiguous (n, 3) arrays of all four sensors, checked."""

    lever_acc: FloatArray
    lever_gyr: FloatArray
    body_acc: FloatArray
    body_gyr: FloatArray


def acceleration_noise(lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike) -> float:
    """Noise of eq. 5 per axis, from the lengths of the two accelerations.

    Whatever the angles, both IMUs should measure the same length; the spread of the difference
    (robust, from the median absolute deviation) is the noise along one direction. Readings that
    repeat themselves, of a coarse or a dead converter, have no spread that means anything: the
    noise is one step of the converter at least, and ``SMALLEST_NOISE_MPS2``.

    Parameters
    ----------
    lever_acc_mps2, body_acc_mps2 : (n, 3) arrays, m/s², best in the sensors' own axes, where the
        steps of the converters show

    Returns
    -------
    float, m/s²

    Raises
    ------
    InputError
        If the arrays differ in shape, are empty, or hold a number that is not finite.

    Examples
    --------
    >>> parked = np.tile([0.0, 0.0, 9.81], (100, 1))
    >>> acceleration_noise(parked, parked)
    0.001
    """
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2", ndim=2, finite=True)
    body = as_vectors(body_acc_mps2, "body_acc_mps2", length=len(lever), finite=True)
    if not len(lever):
        raise InputError("lever_acc_mps2: no sample, expected at least one")
    apart = np.linalg.norm(lever, axis=1) - np.linalg.norm(body, axis=1)
    spread = float(1.4826 * np.median(np.abs(apart - np.median(apart))))
    return max(spread, SMALLEST_NOISE_MPS2, _step(lever), _step(body))


def _step(values: FloatArray) -> float:
    """Smallest step between the readings of a sensor; 0 if they all are the same."""
    steps = [np.diff(np.unique(axis)) for axis in values.T]
    return min((float(step.min()) for step in steps if len(step)), default=0.0)


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

    Returns
    -------
    (n, 3) array, m/s²

    Raises
    ------
    InputError
        If the arrays differ in shape, or a number is not positive.
    """
    acc = as_vectors(acc_mps2, "acc_mps2", ndim=2)
    gyr = as_vectors(gyr_radps, "gyr_radps", length=len(acc))
    arm = as_vectors(arm_m, "arm_m", ndim=1)
    rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    width = as_number(smoothing_s, "smoothing_s") * rate_hz
    spin_up = ndimage.gaussian_filter1d(gyr, width, axis=0, order=1)
    euler = np.cross(spin_up * rate_hz, arm)
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
    """Angles by an extended Kalman filter and, unless ``smooth=False``, an RTS smoother.

    State: steering, throttle, and the bias of both hinges' rates. It starts from the median of the
    first half second, so the scooter should be still there, or steered slowly.

    Parameters
    ----------
    lever_acc_mps2, lever_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {T}, all finite
    body_acc_mps2, body_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {B}, all finite
    sampling_rate_hz : Hz, even samples, at least ``SLOWEST_RATE_HZ``
    geometry : ScooterGeometry
    settings : FusionSettings; None is the default, with the noise taken from the recording
    smooth : whether each angle uses the whole recording; False uses the past only

    Returns
    -------
    FusedAngles
        ``valid`` is true where the numbers are finite and the steering's standard deviation is
        below ``LARGEST_VALID_SD_RAD``. It cannot see a sensor that is frozen, saturated or
        turned.

    Raises
    ------
    InputError
        Arrays of different shapes, without samples, with numbers that are not finite or that no
        such sensor measures; a sampling rate that is too low; accelerations in g, or with gravity
        in the wrong direction.
    """
    settings = FusionSettings() if settings is None else settings
    readings, rate_hz = _checked(
        lever_acc_mps2, lever_gyr_radps, body_acc_mps2, body_gyr_radps, sampling_rate_hz, geometry
    )
    if settings.acc_sd_mps2 is None:
        noise = acceleration_noise(readings.lever_acc, readings.body_acc)
        settings = dataclasses.replace(settings, acc_sd_mps2=noise)
    assert settings.acc_sd_mps2 is not None
    start, slow = _start(readings, rate_hz, geometry)
    dt = 1 / rate_hz
    drift = np.array(
        [settings.rate_noise_radps_sqrthz**2 * dt] * 2 + [settings.bias_walk_radps**2 * dt] * 2
    )
    spread = np.diag([0.35, 0.35, settings.bias_sd_radps, settings.bias_sd_radps]) ** 2
    x, p, x_before, p_before, steps = _filter(
        *readings, slow, dt, geometry.steering_inclination_rad, geometry.lean_rad,
        settings.acc_sd_mps2**2, drift, settings.huber, np.array([*start, 0.0, 0.0]), spread,
    )  # fmt: skip
    if smooth:
        x, p = _smooth(x, p, x_before, p_before, steps)
    sd = np.sqrt(np.maximum(p[:, [0, 1], [0, 1]], 0))
    valid = np.isfinite(x).all(axis=1) & (sd[:, 0] < LARGEST_VALID_SD_RAD)
    return FusedAngles(
        x[:, 0].copy(), x[:, 1].copy(), sd[:, 0].copy(), sd[:, 1].copy(), valid, settings
    )


def _checked(
    lever_acc: ArrayLike,
    lever_gyr: ArrayLike,
    body_acc: ArrayLike,
    body_gyr: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
) -> tuple[_Readings, float]:
    """All readings as the compiled loops need them, and the sampling rate."""
    rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    if rate_hz < SLOWEST_RATE_HZ:
        raise InputError(
            f"sampling_rate_hz = {rate_hz:g}: expected {SLOWEST_RATE_HZ:g} Hz or more, for rates "
            "are integrated (is the time in ms?)"
        )
    arrays = []
    for values, name, limit in (
        (lever_acc, "lever_acc_mps2", LARGEST_ACC_MPS2),
        (lever_gyr, "lever_gyr_radps", LARGEST_RATE_RADPS),
        (body_acc, "body_acc_mps2", LARGEST_ACC_MPS2),
        (body_gyr, "body_gyr_radps", LARGEST_RATE_RADPS),
    ):
        array = np.ascontiguousarray(as_vectors(values, name, ndim=2, finite=True))
        largest = float(np.abs(array).max(initial=0.0))
        if largest > limit:
            raise InputError(
                f"{name}: reaches {largest:.4g}, more than any such sensor measures ({limit:g}): "
                "is it in another unit?"
            )
        arrays.append(array)
    readings = _Readings(*arrays)
    shapes = {array.shape for array in readings}
    if len(shapes) != 1 or not len(readings.lever_acc):
        raise InputError(
            f"accelerations and rates have shapes {sorted(shapes)}: expected all (n, 3), with one "
            "sample or more"
        )
    check_gravity(readings.lever_acc, readings.body_acc, geometry)
    return readings, rate_hz


def _start(
    readings: _Readings, rate_hz: float, geometry: ScooterGeometry
) -> tuple[FloatArray, FloatArray]:
    """Angles, and the body's acceleration, by the median of the first half second."""
    first = slice(0, max(1, round(0.5 * rate_hz)))
    lever, body = (np.median(acc[first], axis=0) for acc in (readings.lever_acc, readings.body_acc))
    return np.array(three_axis_angles(lever, body, geometry), float), body


@compiled()
def _slopes(
    acc: FloatArray, steering: float, tip: float, sin_alpha: float, cos_alpha: float
) -> FloatArray:
    """Derivative of eq. 5 by the state: (3, 4), with nothing by the biases."""
    x, y, z, k2 = tip_reading(acc, steering, tip, sin_alpha, cos_alpha)
    h = np.zeros((3, 4))
    h[0, 0] = k2
    h[1, 0], h[1, 1] = -x * np.cos(tip), -z
    h[2, 0], h[2, 1] = -x * np.sin(tip), y
    return h


@compiled()
def _correct(
    x: FloatArray, p: FloatArray, residual: FloatArray, h: FloatArray, noise: float, huber: float
) -> tuple[FloatArray, FloatArray]:
    """State and covariance after one reading, its three axes one after the other."""
    # Blows are far from Gaussian: what lies beyond the bound counts less.
    innovation = h @ p @ h.T
    for i in range(3):
        innovation[i, i] += noise
    distance = np.sqrt(residual @ np.linalg.solve(innovation, residual) / 3)
    r = noise * max(1.0, float((distance / huber) ** 2))
    dx = np.zeros(4)
    for i in range(3):
        ph = p @ h[i]
        variance = h[i] @ ph + r
        gain = ph / variance
        dx += gain * (residual[i] - h[i] @ dx)
        p = p - np.outer(gain, ph)
    return x + dx, (p + p.T) / 2


@compiled()
def _filter(
    lever_acc: FloatArray,
    lever_gyr: FloatArray,
    body_acc: FloatArray,
    body_gyr: FloatArray,
    slow: FloatArray,
    dt: float,
    alpha: float,
    lean: float,
    noise: float,
    drift: FloatArray,
    huber: float,
    x: FloatArray,
    p: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """States and covariances after and before each correction, and transition matrices."""
    count = len(lever_acc)
    xs, ps = np.empty((count, 4)), np.empty((count, 4, 4))
    xs_before, ps_before = np.empty((count, 4)), np.empty((count, 4, 4))
    steps = np.empty((count, 4, 4))
    ca, sa = np.cos(alpha), np.sin(alpha)
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
        # The slopes come from a smoothed acceleration: with the raw one its noise would stand in
        # residual and slope alike, and vibration would pull the angles to one side.
        slow += dt / SLOPE_SMOOTHING_S * (body_acc[k] - slow)
        tx, ty, tz, _ = tip_reading(body_acc[k], x[0], x[1] + lean, sa, ca)
        residual = lever_acc[k] - np.array([tx, ty, tz])
        x, p = _correct(x, p, residual, _slopes(slow, x[0], x[1] + lean, sa, ca), noise, huber)
        xs[k], ps[k] = x, p
    return xs, ps, xs_before, ps_before, steps


@compiled()
def _smooth(
    x: FloatArray, p: FloatArray, x_before: FloatArray, p_before: FloatArray, steps: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """States and covariances given the whole recording (Rauch-Tung-Striebel)."""
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

    Raises
    ------
    InputError
        As :func:`fuse_angles`, and if the time constant is no positive number.
    """
    time_constant = as_number(time_constant_s, "time_constant_s")
    readings, rate_hz = _checked(
        lever_acc_mps2, lever_gyr_radps, body_acc_mps2, body_gyr_radps, sampling_rate_hz, geometry
    )
    start, _ = _start(readings, rate_hz, geometry)
    slow = np.column_stack(three_axis_angles(readings.lever_acc, readings.body_acc, geometry))
    out = _complement(
        slow, readings.lever_gyr, readings.body_gyr, start, 1 / rate_hz, time_constant,
        geometry.steering_inclination_rad, geometry.lean_rad,
    )  # fmt: skip
    return out[:, 0], out[:, 1]


@compiled()
def _complement(
    slow: FloatArray,
    lever_gyr: FloatArray,
    body_gyr: FloatArray,
    start: FloatArray,
    dt: float,
    time_constant: float,
    alpha: float,
    lean: float,
) -> FloatArray:
    """Integrated rates of the hinges, drawn to the slow angles with the time constant."""
    out = np.empty_like(slow)
    ca, sa = np.cos(alpha), np.sin(alpha)
    gain = dt / (time_constant + dt)
    s, t = start[0], start[1]
    for k in range(len(slow)):
        if k > 0:
            gt, gb = (lever_gyr[k] + lever_gyr[k - 1]) / 2, (body_gyr[k] + body_gyr[k - 1]) / 2
            rate_s, rate_t, _, _ = hinge_rates(gt, gb, s, t + lean, sa, ca)
            s += dt * rate_s
            t += dt * rate_t
        # Shortest way round: a blow may throw the slow angle across +-180 deg.
        s += gain * ((slow[k, 0] - s + np.pi) % (2 * np.pi) - np.pi)
        t += gain * ((slow[k, 1] - t + np.pi) % (2 * np.pi) - np.pi)
        out[k, 0], out[k, 1] = s, t
    return out
