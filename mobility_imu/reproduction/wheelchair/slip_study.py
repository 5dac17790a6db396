"""Errors of the speed on random courts with slip: uncorrected, the tool's way, and ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mobility_imu.executors import run_all
from mobility_imu.frames import FloatArray
from mobility_imu.results import Result
from mobility_imu.simulation.sensor import MTI_1, SensorModel
from mobility_imu.simulation.wheelchair import Court, random_court
from mobility_imu.wheelchair.calibration import calibrate_mount
from mobility_imu.wheelchair.slip import correct_slip, detect_slip
from mobility_imu.wheelchair.velocity import VelocitySettings, estimate_velocity

NAMES = ("uncorrected", "tool's way", "ours", "printed", "printed, corrected")
"""Ways to the speed, in the order of :class:`SpeedErrors`."""


@dataclass(frozen=True, eq=False, repr=False)
class SpeedErrors(Result):
    """How well the speed and the flags of slip are found on one court.

    Parameters
    ----------
    rms_mps : (5,) array, m/s, root mean square error by each of :data:`NAMES`
    flagged_that_slip : fraction of the flagged frames that slip; NaN if none is flagged
    slipping_that_are_flagged : fraction of the slipping frames that are flagged; NaN if none slips
    """

    rms_mps: FloatArray
    flagged_that_slip: float
    slipping_that_are_flagged: float


def speed_errors(court: Court, model: SensorModel = MTI_1) -> SpeedErrors:
    """Drive a court with its calibration trials, and hold all five speeds against the truth.

    Parameters
    ----------
    court : Court
    model : of the sensors

    Returns
    -------
    SpeedErrors
    """
    drive = court.drive(model)
    still, line = court.calibration_trials(model)
    mount = calibrate_mount(still.recording, line.recording).mount
    plain, ours, printed, printed_corrected = (
        estimate_velocity(drive.recording, court.geometry, mount, settings)
        for settings in (
            VelocitySettings(),
            VelocitySettings(slip_correction=True),
            VelocitySettings(form="printed"),
            VelocitySettings(form="printed", slip_correction=True, slip_method="tool"),
        )
    )
    fs = drive.recording.sampling_rate_hz
    tool = correct_slip(
        plain.linear_velocity_mps,
        mount.frame(drive.recording.sensor("frame").acc_mps2)[:, 0],
        detect_slip(plain.yaw_rate_radps, plain.wheel_yaw_rate_radps, fs),
        fs,
        method="tool",
    )
    others = (found.linear_velocity_mps for found in (ours, printed, printed_corrected))
    speeds = (plain.linear_velocity_mps, tool, *others)
    errors = [np.sqrt(np.mean((speed - drive.linear_velocity_mps) ** 2)) for speed in speeds]
    return SpeedErrors(
        np.array(errors), _part(drive.slipping, plain.slip), _part(plain.slip, drive.slipping)
    )


def _part(flags: Any, within: Any) -> float:
    return float(flags[within].mean()) if within.any() else float("nan")


def random_court_errors(
    seeds: Sequence[int], both_wheels_share: float, executor: Any = None
) -> list[SpeedErrors]:
    """Errors on random courts.

    Parameters
    ----------
    seeds : of the courts
    both_wheels_share : of the episodes of slip, in which both wheels slip, by amounts that
        differ by up to 20 %, 0 to 1
    executor : anything with ``submit``; None computes here, one court after the other

    Returns
    -------
    list of SpeedErrors, in the order of the seeds
    """
    return run_all(_on_random_court, [(seed, both_wheels_share) for seed in seeds], executor)


def _on_random_court(seed: int, both_wheels_share: float) -> SpeedErrors:
    return speed_errors(random_court(seed, both_wheels_share=both_wheels_share))
