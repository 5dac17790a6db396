"""Assumed noise of the walker's filter, its options, and a walk that is known to close."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mobility_imu.arguments import check_limits
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, as_count, check_positive, one_of
from mobility_imu.walker import eskf
from mobility_imu.walker.error_state import FORMS, Form

__all__ = ["ClosedLoop", "NavigationSettings"]

_DEG = float(np.deg2rad(1))
SIZES = 1e-12, 1e6
"""Smallest and largest size of a setting; beyond these, squares in the filter lose all digits."""
LONGEST_STRIDE = 10**6
CALIBRATED_SCALE_SD, CALIBRATED_AXES_SD_RAD = 0.003, 0.1 * _DEG
"""Of a sensor whose maker calibrates each unit. Our choice; the MTi-1's data sheet has neither."""


@dataclass(frozen=True)
class NavigationSettings:
    """Assumed noise model of the filter, and its options. The first two are the MTi-1's data sheet.

    Parameters
    ----------
    gyr_noise_radps_sqrthz : rad/s/sqrt(Hz), density of the gyroscope's noise
    acc_noise_mps2_sqrthz : m/s²/sqrt(Hz), density of the accelerometer's noise
    gyr_noise_factor, acc_noise_factor : 1, the filter's noise over the sensor's; more than 1 stands
        in for what is not white noise (scale factor, misalignment, sampling)
    gyr_bias_walk_radps_sqrts : rad/s per square root of s, how fast the bias may wander
    acc_bias_walk_mps2_sqrts : m/s² per square root of s
    gyr_bias_sd_radps : rad/s, uncertainty of the bias at the start beyond that of the mean
    acc_bias_sd_mps2 : m/s², bias at the start; the first attitude errs with it
    velocity_noise_mps_sqrthz : m/s/sqrt(Hz), of a frame that stands: zero-velocity update
    height_noise_m_sqrthz : m/sqrt(Hz), of the floor: zero-height update
    rate_noise_radps_sqrthz : rad/s/sqrt(Hz), of a frame that stands: zero-rate update
    upright_rad : rad, the height is known only within this angle of the first attitude
    longest_move_s : s, a frame that is lifted and set down rests again before
    long_move_factor : 1, larger noise of both sensors in a move that lasts longer, in which errors
        add up that one step does not show (a frame on wheels, carried, or a sensor on a foot)
    gyr_range_radps : rad/s, a rate beyond it is cut by the gyroscope: bridged, and uncertain
    zero_rate : whether to make zero-rate updates, which the paper does not
    initial_gyr_mean : whether to start with the mean of the gyroscope over the first rest
    gyr_bias_prior_sd_radps : rad/s, size of the bias where the start is not that mean, but zero
    scale_sd, axes_sd_rad : 1 and rad, how well the sensor's scale factors and axes are known; not
        in the filter, but in the standard deviations of mount and path, and so in what is told or
        called valid by them. 1 % each, as data sheets of cheap sensors state; see
        :meth:`for_calibrated_sensor`
    form : of the error dynamics, "corrected" or as "printed" in eq. 24
    moving_stride : 8, samples of a moving frame that share one step of the covariance
    resting_stride : 4, samples of a resting frame that share one, and one update at their end;
        closer to the ends of a rest each has its own. With 1 and 1: the textbook's filter. Gaps
        and samples that are cut off always stand alone

    Raises
    ------
    InputError
        If a value is impossible; the message names it.
    """

    gyr_noise_radps_sqrthz: float = 0.007 * _DEG
    acc_noise_mps2_sqrthz: float = 120e-6 * STANDARD_GRAVITY_MPS2
    gyr_noise_factor: float = 3.0
    acc_noise_factor: float = 5.0
    gyr_bias_walk_radps_sqrts: float = 1e-5
    acc_bias_walk_mps2_sqrts: float = 1e-4
    gyr_bias_sd_radps: float = 0.01 * _DEG
    acc_bias_sd_mps2: float = 0.03
    velocity_noise_mps_sqrthz: float = 0.001
    height_noise_m_sqrthz: float = 0.0005
    rate_noise_radps_sqrthz: float = 0.014 * _DEG
    upright_rad: float = 3 * _DEG
    longest_move_s: float = 5.0
    long_move_factor: float = 20.0
    gyr_range_radps: float = 1e3
    zero_rate: bool = True
    initial_gyr_mean: bool = True
    gyr_bias_prior_sd_radps: float = 0.5 * _DEG
    scale_sd: float = 0.01
    axes_sd_rad: float = 0.01
    form: Form = "corrected"
    moving_stride: int = 8
    resting_stride: int = 4

    def __post_init__(self) -> None:
        """Check each field."""
        others = {"zero_rate", "initial_gyr_mean", "form", "moving_stride", "resting_stride"}
        check_positive(self, *(name for name in vars(self) if name not in others))
        one_of("NavigationSettings.form", self.form, FORMS)
        for name in ("moving_stride", "resting_stride"):
            count = as_count(getattr(self, name), f"NavigationSettings.{name}")
            object.__setattr__(self, name, count)
        for name in ("zero_rate", "initial_gyr_mean"):
            flag = one_of(f"NavigationSettings.{name}", getattr(self, name), (True, False))
            object.__setattr__(self, name, flag)
        sizes = dict.fromkeys((n for n in vars(self) if n not in others), SIZES)
        strides = dict.fromkeys(("moving_stride", "resting_stride"), (1, LONGEST_STRIDE))
        check_limits(
            self,
            {
                **sizes,
                **strides,
                "upright_rad": (SIZES[0], np.pi),
                "scale_sd": (1e-6, 1.0),
                "axes_sd_rad": (1e-6, 1.0),
            },
        )

    @classmethod
    def for_calibrated_sensor(cls) -> NavigationSettings:
        """Settings for a sensor whose maker calibrates each unit, as the paper's MTi-1.

        Scale factors are taken to be known to 0.3 % and axes to 0.1 deg, as the simulated MTi-1
        has them; its data sheet states neither.

        Returns
        -------
        NavigationSettings
        """
        return cls(scale_sd=CALIBRATED_SCALE_SD, axes_sd_rad=CALIBRATED_AXES_SD_RAD)

    @classmethod
    def for_foot(cls, *, gyr_range_radps: float = 1e3) -> NavigationSettings:
        """Settings for a sensor on a foot instead of a frame.

        A foot that stands still turns and slides a little, and the floor hits it at each step; a
        frame that is set down does neither. Therefore: no zero-rate updates; a standing foot moves
        by millimetres per second; larger noise factors for what 200 samples per second leave of the
        hits. The gyroscope's offset is assumed to be as small as a data sheet says (0.25 deg/s,
        LORD 3DM-GX3-25), since a person who waits at the start sways by more;
        ``estimate_trajectory`` takes off a larger one that longer rests show. The sizes were chosen
        on 28 public walks with motion capture and given rests; scale factors and axes are those of
        a sensor that its maker calibrates, as theirs is.

        A foot swings faster than many gyroscopes can read. Where the readings end is to be given:
        what is cut off there costs more than all noise.

        Parameters
        ----------
        gyr_range_radps : rad/s, largest rate that the gyroscope reads right

        Returns
        -------
        NavigationSettings
        """
        return cls(
            gyr_noise_factor=60.0,
            acc_noise_factor=40.0,
            acc_bias_sd_mps2=0.1,
            velocity_noise_mps_sqrthz=0.002,
            height_noise_m_sqrthz=0.01,
            upright_rad=1.0,
            long_move_factor=2.0,
            gyr_range_radps=gyr_range_radps,
            zero_rate=False,
            initial_gyr_mean=False,
            gyr_bias_prior_sd_radps=0.25 * _DEG,
            scale_sd=CALIBRATED_SCALE_SD,
            axes_sd_rad=CALIBRATED_AXES_SD_RAD,
        )

    def noise(self) -> eskf.Noise:
        """Squared densities for the filter."""
        return eskf.Noise(
            gyr=(self.gyr_noise_radps_sqrthz * self.gyr_noise_factor) ** 2,
            acc=(self.acc_noise_mps2_sqrthz * self.acc_noise_factor) ** 2,
            gyr_bias_walk=self.gyr_bias_walk_radps_sqrts**2,
            acc_bias_walk=self.acc_bias_walk_mps2_sqrts**2,
            velocity=self.velocity_noise_mps_sqrthz**2,
            height=self.height_noise_m_sqrthz**2,
            rate=self.rate_noise_radps_sqrthz**2,
            long_move=self.long_move_factor**2,
        )


@dataclass(frozen=True)
class ClosedLoop:
    """The frame is known to end where it began, and turned as it was.

    Parameters
    ----------
    position_sd_m : m, how well that is known, per axis
    heading_sd_rad : rad

    Raises
    ------
    InputError
        If a size is not positive.
    """

    position_sd_m: float = 0.03
    heading_sd_rad: float = 2 * _DEG

    def __post_init__(self) -> None:
        """Check both."""
        check_positive(self)
        check_limits(self, dict.fromkeys(vars(self), SIZES))
