"""Summaries of the commands: what was read, what was found, how sure it is, where it was written.

Each function returns the lines for one command's result, without the line of the files.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobility_imu.frames import FloatArray

if TYPE_CHECKING:
    from mobility_imu.recording import Recording
    from mobility_imu.scooter import PoseCheck, RideAngles, ScooterCalibration
    from mobility_imu.walker import Steps, Trajectory, WalkerCalibration
    from mobility_imu.wheelchair import ChairVelocity, GeometryCheck, Tasks


def read_line(recording: Recording) -> str:
    """What was read of a recording.

    Parameters
    ----------
    recording : as it was read

    Returns
    -------
    str
    """
    sensors = ", ".join(sorted(recording.sensors))
    count, rate = len(recording.time_s), recording.sampling_rate_hz
    return f"read: {recording.source}: {sensors}; {count / rate:.1f} s at {rate:.5g} Hz"


def written_line(paths: Iterable[Path | None]) -> str:
    """Where the results are.

    Parameters
    ----------
    paths : files; None is left out

    Returns
    -------
    str
    """
    return "written: " + ", ".join(str(path) for path in paths if path is not None)


def ride_lines(found: RideAngles) -> list[str]:
    """Range of both angles with their standard deviation, and how much of the ride is valid.

    Parameters
    ----------
    found : RideAngles

    Returns
    -------
    list of str
    """
    if not found.valid.any():
        return ["no sample is valid, so no angle is known"]
    lines = []
    for name in ("steering", "throttle"):
        angle, sd = (
            np.rad2deg(getattr(found, f"{name}_{part}rad")[found.valid]) for part in ("", "sd_")
        )
        uncertainty = (
            f"sd {np.median(sd):.2g} deg (median)" if np.isfinite(sd).all() else "sd not known"
        )
        lines.append(f"{name}: {angle.min():.1f} to {angle.max():.1f} deg, {uncertainty}")
    lines.append(f"valid: {_percent(found.valid)} of {len(found.valid)} samples")
    return lines


def scooter_mount_lines(found: ScooterCalibration) -> list[str]:
    """Turns of both IMUs from their nominal axes, and what the poses do not show.

    Parameters
    ----------
    found : ScooterCalibration

    Returns
    -------
    list of str
    """
    turns = (found.mount.rotation_lever_imu_to_lever, found.mount.rotation_body_imu_to_body)
    sd = np.rad2deg(found.sd_rad).reshape(2, 3).max(axis=1)
    return [
        f"{name}'s IMU: {_turn_deg(turn):.2f} deg from its nominal axes, sd at most {most:.2g} deg"
        for name, turn, most in zip(("lever", "body"), turns, sd, strict=True)
    ]


VERDICTS = {
    "agrees": "agrees: the differences are not larger than the stated uncertainty predicts",
    "differs": "differs: the differences are larger than the stated uncertainty predicts",
    "cannot be judged": "cannot be judged",
}
"""What ``scooter check`` says for each verdict."""


def pose_check_lines(found: PoseCheck) -> list[str]:
    """Differences from the protractor's angles, and the verdict.

    Parameters
    ----------
    found : PoseCheck

    Returns
    -------
    list of str
    """
    poses = int(found.judged.sum())
    counts = found.inside[found.judged].sum(axis=0)
    lines = [
        f"{name}: rms {rms:.2f} deg; {count} of {poses} inside their 95 % interval"
        for name, rms, count in zip(
            ("steering", "throttle"), np.rad2deg(found.rms_rad), counts, strict=True
        )
    ]
    return [*lines, VERDICTS[found.verdict]]


def velocity_lines(found: ChairVelocity) -> list[str]:
    """Distance forward minus backward, and turn, with their uncertainty; fraction of slip.

    All errors of the speed are assumed to have the same sign: this is the worst case.

    Parameters
    ----------
    found : ChairVelocity

    Returns
    -------
    list of str
    """
    speed, step = found.linear_velocity_mps, 1 / found.sampling_rate_hz
    way, way_sd = step * speed.sum(), step * found.linear_velocity_sd_mps.sum()
    turn, turn_sd = (
        step * np.rad2deg(rate).sum() for rate in (found.yaw_rate_radps, found.yaw_rate_sd_radps)
    )
    uncertainty = f"sd at most {turn_sd:.2g} deg"
    return [
        f"distance forward: {way:.2f} m (sd at most {way_sd:.2g} m); "
        f"largest speed {speed.max():.2f} m/s",
        f"turn from beginning to end: {_whole(turn)} deg ({uncertainty}), left positive",
        f"slip: {_percent(found.slip)} of the time"
        if np.isfinite(found.wheel_yaw_rate_radps).any()
        else "slip: cannot be found with one wheel",
    ]


def check_lines(found: GeometryCheck) -> list[str]:
    """Whether the stated geometry agrees with the recording.

    Parameters
    ----------
    found : GeometryCheck

    Returns
    -------
    list of str
    """
    if not found.judged:
        return ["geometry: not judged"]
    return ["geometry: fits" if found.fits else f"geometry: {len(found.warnings)} warning(s)"]


def tasks_lines(found: Tasks) -> list[str]:
    """Time in each task where it is known, the longest first.

    Parameters
    ----------
    found : Tasks

    Returns
    -------
    list of str
    """
    from mobility_imu.wheelchair import Task

    step = float(np.median(np.diff(found.time_s))) if len(found) > 1 else 0.0
    assert found.valid is not None
    times = {task: step * int(((found.codes == task) & found.valid).sum()) for task in Task}
    longest = sorted((task for task in Task if times[task]), key=lambda task: -times[task])
    parts = [f"{task.title} {times[task]:.1f} s" for task in longest[:4]]
    more = [f"{len(longest) - 4} more"] if len(longest) > 4 else []
    kinds = f"{len(longest)} kind{'' if len(longest) == 1 else 's'} of task"
    lines = [": ".join([kinds, *([", ".join([*parts, *more])] if longest else [])])]
    if not found.valid.all():
        lines.append(f"not known: {step * int((~found.valid).sum()):.1f} s")
    return lines


def walker_mount_lines(found: WalkerCalibration) -> list[str]:
    """Place and rotation of the IMU, with their standard deviations.

    Parameters
    ----------
    found : WalkerCalibration

    Returns
    -------
    list of str
    """
    place = _triple(1000 * found.mount.translation_body_m, 1000 * found.translation_sd_m)
    turn_sd = np.rad2deg(found.rotation_sd_rad)
    turns = "not known" if np.isnan(turn_sd).any() else ", ".join(f"{sd:.2g}" for sd in turn_sd)
    return [
        f"tilts used: {', '.join(tilt.direction for tilt in found.tilts)}",
        f"IMU at x, y, z = {place} mm",
        f"sd of roll, pitch, yaw: {turns}" + ("" if turns == "not known" else " deg"),
    ]


def trajectory_lines(found: Trajectory, steps: Steps | None) -> list[str]:
    """End of the path with its standard deviation, turn, and steps.

    Parameters
    ----------
    found : Trajectory
    steps : Steps, or None if none were found

    Returns
    -------
    list of str
    """
    end, sd = found.position_m[-1], found.position_sd_m[-1]
    lines = [
        f"end at x = {end[0]:.2f} m, y = {end[1]:.2f} m (sd {sd[0]:.2g} and {sd[1]:.2g} m)",
        f"turn from beginning to end: {_whole(np.rad2deg(found.yaw_rad[-1]))} deg "
        f"(sd {np.rad2deg(found.yaw_sd_rad[-1]):.2g} deg), left positive",
    ]
    if steps is not None and len(steps):
        lines.append(f"steps: {len(steps)}, {steps.path_m[-1]:.2f} m in all")
    return lines


def _percent(flags: NDArray[np.bool_]) -> str:
    share = 100 * float(np.mean(flags))
    return f"{share:.0f} %" if share in (0.0, 100.0) else f"{np.clip(share, 0.1, 99.9):.1f} %"


def _whole(number: float) -> int:
    return round(float(number))  # without the sign of a zero


def _turn_deg(rotation: FloatArray) -> float:
    return float(np.rad2deg(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))))


def _triple(values: FloatArray, sds: FloatArray) -> str:
    known = np.isfinite(sds).all()
    return ", ".join(
        f"{value:.1f} ± {sd:.1f}" if known else f"{value:.1f}"
        for value, sd in zip(values, sds, strict=True)
    )
