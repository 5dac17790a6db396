"""Constants that the scooter's fusion learns: what is assumed of them, and what cannot be one."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.scooter.fusion_filter import ARMS, BODY, CONSTANTS
from mobility_imu.scooter.fusion_settings import FusionSettings

__all__ = ["constant_deviations", "unlikely_constant"]

KINDS = (
    ("acc_offset_sd_mps2", "accelerometer's offset"),
    ("acc_scale_sd", "accelerometer's scale"),
    ("misalignment_sd_rad", "turn"),
    ("gyr_scale_sd", "gyroscope's scale"),
    ("bias_sd_radps", "gyroscope's offset"),
    ("axes_apart_sd_rad", "gyroscope's turn against its accelerometer"),
)
"""Setting and words of each kind of constant; three axes of each, in the filter's order."""
UNLIKELY_SDS = 4.0
"""Standard deviations beyond which a learned constant is none: one recording in 660 has one of the
24 that are judged by chance. Simulated rides with sound sensors, six courses, seeds 1 to 9, learn
1.1 at most."""
JUDGED = ("acc_offset_sd_mps2", "acc_scale_sd", "misalignment_sd_rad", "gyr_scale_sd")
"""Offsets of gyroscopes are judged at rest, where they show."""


def constant_deviations(settings: FusionSettings) -> FloatArray:
    """Standard deviations of all constants before anything is learned.

    Parameters
    ----------
    settings : FusionSettings

    Returns
    -------
    (CONSTANTS,) array: the lever's sensor, the body's, and the components of the lever arms
    """
    sensor = np.repeat([getattr(settings, name) for name, _ in KINDS], 3)
    arms = np.full(CONSTANTS - ARMS, settings.lever_arm_sd_m)
    return np.concatenate((sensor, sensor, arms))


def unlikely_constant(constants: FloatArray, settings: FusionSettings) -> tuple[str, ...]:
    """Sentence if the filter could follow the recording only with an error that no sensor has.

    Parameters
    ----------
    constants : (CONSTANTS,) array, as learned
    settings : FusionSettings that the filter started from

    Returns
    -------
    tuple of no or one sentence
    """
    times = np.abs(constants / constant_deviations(settings))[:ARMS]
    judged = np.repeat([name in JUDGED for name, _ in KINDS], 3)
    times = np.where(np.tile(judged, 2), times, 0.0)
    worst = int(np.argmax(times))
    if not times[worst] > UNLIKELY_SDS:
        return ()
    name = "lever" if worst < BODY else "body"
    _, what = KINDS[worst % BODY // 3]
    return (
        f"the filter can follow the readings only if the {name}'s {what} is off by "
        f"{times[worst]:.0f} times what is assumed (axis {'xyz'[worst % 3]}): the standard "
        "deviations are too small then; is the time in s, do both sensors keep one clock, are "
        "their axes right, was one turned during the ride?",
    )
