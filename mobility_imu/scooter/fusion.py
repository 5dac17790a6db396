"""Steering and throttle angles from accelerometers and gyroscopes together.

The two controls are hinges: what the lever's gyroscope reads beyond the body's is their motion.
An extended Kalman filter integrates that, corrects it with eq. 5 sample by sample, and learns what
is constant: the sensors' offsets, scales and misalignments, and the lever arms between them. A
Rauch-Tung-Striebel pass then lets each angle use the whole recording. A complementary filter stands
beside it, as a simpler baseline.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu._compiled import compiled
from mobility_imu.arguments import settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_vectors
from mobility_imu.hinges import hinge_rates
from mobility_imu.results import Result
from mobility_imu.scooter.angles import check_gravity, three_axis_angles
from mobility_imu.scooter.fusion_passes import Readings, first_angles, prepared, run_passes
from mobility_imu.scooter.fusion_settings import FusionSettings
from mobility_imu.scooter.geometry import ScooterGeometry

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "FusedAngles",
    "FusionSettings",
    "complementary_angles",
    "fuse_angles",
    "move_specific_force",
]

LARGEST_VALID_SD_RAD = float(np.deg2rad(20.0))
"""Standard deviation of the steering from which a sample is not valid."""
SLOWEST_RATE_HZ = 10.0
"""Sampling rate below which the rates cannot be integrated; the controls turn within 0.1 s."""
LARGEST_ACC_MPS2 = 2000.0
"""Largest component of an acceleration, m/s²; beyond what such sensors measure (200 g)."""
LARGEST_RATE_RADPS = 100.0
"""Largest component of a rate, rad/s; beyond what such sensors measure (4000 deg/s is 70)."""


@dataclass(frozen=True, eq=False, repr=False)
class FusedAngles(Result):
    """Angles of the filter with their standard deviations.

    Parameters
    ----------
    steering_rad, throttle_rad : (n,) arrays, rad
    steering_sd_rad, throttle_sd_rad : (n,) arrays, rad, one standard deviation: noise, errors of
        the sensors and of their mounting, flexing, and the clock
    valid : (n,) bool array: the numbers are finite, and the sd of the steering is below
        ``LARGEST_VALID_SD_RAD``
    settings : FusionSettings, with what was taken from the recording
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

    State: steering, throttle, drift of both hinges' rates, and a coloured disturbance of the
    acceleration; beside it the constants of :class:`FusionSettings`, which it learns as far as the
    recording shows them, and whose uncertainty stays in the angles' as far as it does not. A first
    pass finds the sizes that the settings leave to the recording. It starts from the median of the
    first half second, so the scooter should be still there, or steered slowly.

    Parameters
    ----------
    lever_acc_mps2, lever_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {T}, all finite
    body_acc_mps2, body_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {B}, all finite
    sampling_rate_hz : Hz, even samples, at least ``SLOWEST_RATE_HZ``
    geometry : ScooterGeometry
    settings : FusionSettings; None is the default, with the noises taken from the recording
    smooth : whether each angle uses the whole recording; False uses the past only, and states a
        standard deviation that is too small, by 1.7 in simulated rides of 20 s

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
    settings = settings_or_default("settings", settings, FusionSettings)
    readings, rate_hz = _checked(
        lever_acc_mps2, lever_gyr_radps, body_acc_mps2, body_gyr_radps, sampling_rate_hz, geometry
    )
    problem = prepared(readings, geometry, rate_hz, smooth)
    angles, sd, settings = run_passes(problem, settings, smooth)
    valid = np.isfinite(angles).all(axis=1) & (sd[:, 0] < LARGEST_VALID_SD_RAD)
    return FusedAngles(
        angles[:, 0].copy(), angles[:, 1].copy(), sd[:, 0].copy(), sd[:, 1].copy(), valid, settings
    )


def _checked(
    lever_acc: ArrayLike,
    lever_gyr: ArrayLike,
    body_acc: ArrayLike,
    body_gyr: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
) -> tuple[Readings, float]:
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
        # A copy: a read-only array would be another type to the compiler.
        array = np.array(as_vectors(values, name, ndim=2, finite=True), order="C")
        largest = float(np.abs(array).max(initial=0.0))
        if largest > limit:
            raise InputError(
                f"{name}: reaches {largest:.4g}, more than any such sensor measures ({limit:g}): "
                "is it in another unit?"
            )
        arrays.append(array)
    readings = Readings(*arrays)
    shapes = {array.shape for array in readings}
    if len(shapes) != 1 or not len(readings.lever_acc):
        raise InputError(
            f"accelerations and rates have shapes {sorted(shapes)}: expected all (n, 3), with one "
            "sample or more"
        )
    check_gravity(readings.lever_acc, readings.body_acc, geometry)
    return readings, rate_hz


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
    start = first_angles(readings.lever_acc, readings.body_acc, rate_hz, geometry)
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
