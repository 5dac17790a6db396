"""What the scooter's fusion assumes about sensors, mounting and noise, and why these sizes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_series, check_positive

__all__ = ["FusionSettings"]

# Beyond these the squares in the filter's matrices lose all digits.
SETTING_LIMITS = {
    "acc_sd_mps2": (1e-4, 1e8),
    "acc_step_mps2": (1e-4, 1e8),
    "disturbance_sd_mps2": (1e-6, 1e6),
    "disturbance_time_s": (1e-3, 1e4),
    "rate_noise_radps_sqrthz": (1e-6, 10.0),
    "bias_sd_radps": (1e-8, 10.0),
    "bias_walk_radps": (1e-10, 10.0),
    "acc_offset_sd_mps2": (1e-6, 10.0),
    "acc_scale_sd": (1e-6, 1.0),
    "misalignment_sd_rad": (1e-6, 1.0),
    "axes_apart_sd_rad": (1e-6, 1.0),
    "gyr_scale_sd": (1e-6, 1.0),
    "lever_arm_sd_m": (1e-6, 10.0),
    "flexing_sd_rad": (1e-8, 1.0),
    "clock_sd_s": (1e-8, 1.0),
    "huber": (1e-3, 1e8),
}
"""Smallest and largest value of each setting of the filter."""
FROM_THE_RECORDING = (
    "acc_sd_mps2",
    "acc_step_mps2",
    "disturbance_sd_mps2",
    "rate_noise_radps_sqrthz",
    "flexing_sd_rad",
    "clock_sd_s",
)
"""Settings that the recording itself tells where they are None."""
SMALLEST_DISTURBANCE_MPS2 = 0.1
"""Coloured disturbance that is assumed at least: one per cent of gravity, for bent scales,
warming, cables."""
SMALLEST_RATE_NOISE = 0.001
"""Density of the rates' noise that is assumed at least, rad/s per square root of Hz."""


@dataclass(frozen=True)
class FusionSettings:
    """Assumed noise model of the filter.

    The sizes are those of uncalibrated consumer sensors, stuck on by hand: zero-g offset 20 to 50
    mg at most (data sheets of InvenSense MPU-6050, Bosch BMI160, ST LSM6DS3), 15 mg as one standard
    deviation; scale up to 3 %, cross-axis 1 to 2 % at most, and half a degree by hand; a gyroscope
    reads up to 3 deg/s at rest, 1.1 deg/s as one standard deviation. What a bent scale, a cable or
    warmth do to an acceleration is taken to last for ten seconds.

    Parameters
    ----------
    acc_sd_mps2 : m/s², white noise per axis of the difference between the lever's acceleration and
        what eq. 5 makes of the body's; None takes it from the recording
    acc_step_mps2 : m/s², step of the coarser converter: the least that a recording's noise can be;
        None takes it from the readings, whose axes must then be the sensors' own
    disturbance_sd_mps2 : m/s², coloured noise of that difference (first-order Gauss-Markov): what
        flexes, bends and warms; None takes it from the recording
    disturbance_time_s : s, its correlation time
    rate_noise_radps_sqrthz : rad/s per square root of Hz, density of the noise of the difference
        of the rates (two gyroscopes, flexing); None takes it from the recording
    bias_sd_radps : rad/s, offset of each gyroscope's axis
    bias_walk_radps : rad/s per square root of s, how fast the rates' bias may wander
    acc_offset_sd_mps2 : m/s², offset of each accelerometer's axis
    acc_scale_sd : relative error of each accelerometer's scale
    misalignment_sd_rad : rad, by which the axes of an IMU are off about each axis: cross-axis
        sensitivity and mounting together
    axes_apart_sd_rad : rad, by which the axes of a gyroscope are off those of the accelerometer
        beside it: cross-axis sensitivity
    gyr_scale_sd : relative error of each gyroscope's scale
    lever_arm_sd_m : m, distances of both IMUs and of both hinges' axes
    flexing_sd_rad : rad, by which the IMUs turn against what they sit on; the angles are those of
        the controls, so it is part of their standard deviation; None takes it from the recording
    clock_sd_s : s, by which the time of a sample is uncertain; None is half a sample
    huber : residuals beyond this many sd count less

    Raises
    ------
    InputError
        If a value is no positive number, or beyond what can be computed with.
    """

    acc_sd_mps2: float | None = None
    acc_step_mps2: float | None = None
    disturbance_sd_mps2: float | None = None
    disturbance_time_s: float = 10.0
    rate_noise_radps_sqrthz: float | None = None
    bias_sd_radps: float = 0.02
    bias_walk_radps: float = 1e-4
    acc_offset_sd_mps2: float = 0.15
    acc_scale_sd: float = 0.01
    misalignment_sd_rad: float = 0.0125
    axes_apart_sd_rad: float = 0.01
    gyr_scale_sd: float = 0.01
    lever_arm_sd_m: float = 0.3
    flexing_sd_rad: float | None = None
    clock_sd_s: float | None = None
    huber: float = 2.0

    def __post_init__(self) -> None:
        """Check every number."""
        names = [field.name for field in dataclasses.fields(self)]
        given = [
            name
            for name in names
            if name not in FROM_THE_RECORDING or getattr(self, name) is not None
        ]
        check_positive(self, *given)
        for name in given:
            low, high = SETTING_LIMITS[name]
            if not low <= getattr(self, name) <= high:
                raise InputError(
                    f"FusionSettings.{name} = {getattr(self, name):g}: expected between {low:g} "
                    f"and {high:g}"
                )

    def after_calibration(self, mount_sd_rad: FloatArray) -> FusionSettings:
        """Settings for IMUs whose mount a calibration found.

        A mount from parked poses contains the accelerometers' errors there. What it leaves,
        its standard deviation, is given to the axes and to the accelerometers in equal parts. Sizes
        that are not the default stay.

        Parameters
        ----------
        mount_sd_rad : (6,) array, rad, as ``ScooterMount.sd_rad``; the median counts, as a turn
            that the poses did not show says nothing of the others

        Returns
        -------
        FusionSettings

        Raises
        ------
        InputError
            If the standard deviations are no six numbers of 0 or more.
        """
        found = as_series(mount_sd_rad, "mount_sd_rad", length=6)
        if found.min() < 0:
            raise InputError(f"mount_sd_rad = {found.min():g}: expected no negative number")
        part = float(np.median(found)) / 2**0.5
        sizes = {
            "acc_offset_sd_mps2": part * STANDARD_GRAVITY_MPS2,
            "acc_scale_sd": part,
            "misalignment_sd_rad": part,
        }
        assumed = {field.name: field.default for field in dataclasses.fields(self)}
        return dataclasses.replace(
            self,
            **{
                name: min(max(size, SETTING_LIMITS[name][0]), getattr(self, name))
                for name, size in sizes.items()
                if getattr(self, name) == assumed[name]
            },
        )

    @property
    def complete(self) -> bool:
        """Whether nothing is left for the recording to tell."""
        return all(getattr(self, name) is not None for name in FROM_THE_RECORDING)
