"""Headline numbers of the chapters, with sensors of a data sheet and with sensors as real ones are.

Scooters, courts, frames, walks and seeds are the same at both levels; only the sensors differ. The
record ``level_real`` keeps the numbers, :mod:`mobility_imu.reproduction.real_level_claims` holds
the levels against each other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.filters import rms
from mobility_imu.reproduction.scooter.driving import StudySettings, driving_study
from mobility_imu.reproduction.scooter.driving_rides import ANGLES, Conditions
from mobility_imu.reproduction.scooter.real_hinges import simulated_summary
from mobility_imu.reproduction.wheelchair.slip_study import speed_errors
from mobility_imu.simulation.levels import LEVELS, MOUNTS, REAL_LEVEL, tilt_run, unit_of
from mobility_imu.simulation.scooter import COURSES
from mobility_imu.simulation.sensor import LPMS_CU2, MTI_1, REAL
from mobility_imu.simulation.walker import (
    CORRIDOR,
    RECTANGLE,
    Leg,
    WalkerMotion,
    attach_imu,
    simulate_walk,
)
from mobility_imu.simulation.wheelchair import random_court
from mobility_imu.walker.calibration import calibrate_mount as calibrate_walker
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation_settings import NavigationSettings
from mobility_imu.walker.steps import find_steps
from mobility_imu.walker.trajectory import estimate_trajectory
from mobility_imu.wheelchair.calibration import calibrate_mount as calibrate_wheelchair
from mobility_imu.wheelchair.check import check_geometry
from mobility_imu.wheelchair.tasks import identify_tasks
from mobility_imu.wheelchair.velocity import estimate_velocity

if TYPE_CHECKING:
    import pandas as pd

Numbers = dict[str, float]
LEVEL_NAMES = ("data sheet", "real")
"""Both levels, in the order of the table."""
SCOOTERS, COURTS, WALKERS = 10, 20, 20
"""Seeds from 0: scooters that each drive five courses, courts, frames that walk twice."""
WITHIN = 1.96
SCOOTER_SENSORS = {"data sheet": LPMS_CU2, "real": REAL}
CHAIR_SENSORS = {"data sheet": MTI_1, "real": REAL}
FRAMES = {"data sheet": LEVELS["realistic"], "real": REAL_LEVEL}
"""Frames that land alike, with both sensors."""
CALIBRATED = NavigationSettings.for_calibrated_sensor()
SETTINGS = {"data sheet": CALIBRATED, "real": NavigationSettings()}
"""What a user states of both sensors."""


def scooter_numbers(level: str) -> Numbers:
    """Fusion and closed form on drawn rides, and what the paper says of its driving test.

    Parameters
    ----------
    level : of :data:`LEVEL_NAMES`

    Returns
    -------
    dict: ``rides`` and, for each angle, rms and coverage by fusion, rms by the closed form,
    largest 90 % error of a course by two IMUs (median over scooters), and the fractions of pairs of
    scooter and course with the smaller error: two IMUs than one, the Kalman filter than two IMUs
    """
    sensor = SCOOTER_SENSORS[level]
    found = simulated_summary(sensor, SCOOTERS)
    settings = StudySettings(
        drivers=1,
        runs=1,
        estimators=("single", "dual", "Kalman filter"),
        calibrations={"as drawn": None},
        conditions=Conditions(sensor=sensor),
    )
    table = driving_study(range(SCOOTERS), settings).table
    errors = _errors_by_wire(table)
    numbers: Numbers = {"rides": SCOOTERS * len(COURSES)}
    for angle in ANGLES:
        fusion, closed = found["fusion"][angle], found["closed-form"][angle]
        largest = errors[angle, "dual"].groupby(level="scooter").max()
        dual = errors[angle, "dual"]
        numbers |= {
            f"fusion_{angle}_rms_deg": fusion["median_rms_deg"],
            f"fusion_{angle}_covered": fusion["covered"],
            f"closed_form_{angle}_rms_deg": closed["median_rms_deg"],
            f"dual_{angle}_largest_p90_deg": float(largest.median()),
            f"dual_below_single_{angle}": float((dual < errors[angle, "single"]).mean()),
            f"kalman_below_dual_{angle}": float((errors[angle, "Kalman filter"] < dual).mean()),
        }
    return numbers


def _errors_by_wire(table: pd.DataFrame) -> pd.DataFrame:
    """90 % errors against the wire sensors, a row per scooter and course."""
    rows = table[table["against"] == "wire"]
    return rows.pivot_table(
        index=["scooter", "course"], columns=["angle", "estimator"], values="p90_deg"
    )


def court_row(seed: int, level: str) -> Numbers:
    """Speed, track and tasks on a court without slip, and slip on one where a wheel slips.

    Parameters
    ----------
    seed : of the court
    level : of :data:`LEVEL_NAMES`

    Returns
    -------
    dict of numbers of this court
    """
    model = CHAIR_SENSORS[level]
    court = random_court(seed, slips=0)
    still, line = court.calibration_trials(model)
    cal = calibrate_wheelchair(still.recording, line.recording)
    run = court.drive(model)
    found = estimate_velocity(run.recording, court.geometry, cal.mount, offsets=cal.offsets)
    check = check_geometry(run.recording, court.geometry, cal.mount, offsets=cal.offsets)
    error = found.linear_velocity_mps - run.linear_velocity_mps
    track = abs(check.track_m - court.geometry.track_m)
    slips = speed_errors(random_court(seed, both_wheels_share=0.0), model)
    return {
        "speed_rms_mps": rms(error),
        "speed_covered": float(np.mean(np.abs(error) < WITHIN * found.linear_velocity_sd_mps)),
        "track_error_m": track,
        "track_covered": float(track < WITHIN * check.track_sd_m),
        "geometry_fits": float(check.fits),
        "tasks_alike": float(np.mean(identify_tasks(found).codes == run.task)),
        "slip_rms_mps": float(slips.rms_mps[2]),
        "slip_uncorrected_rms_mps": float(slips.rms_mps[0]),
        "slip_flags_right": slips.flagged_that_slip,
        "slip_found": slips.slipping_that_are_flagged,
    }


def court_summary(rows: list[Numbers]) -> Numbers:
    """Medians of the errors and means of the fractions over all courts.

    Parameters
    ----------
    rows : from :func:`court_row`

    Returns
    -------
    dict, with ``courts``
    """
    return {"courts": len(rows), **_pooled(rows)}


def frame_row(seed: int, level: str) -> Numbers:
    """A frame calibrated by tilting, and with that mount a corridor and a rectangle.

    Parameters
    ----------
    seed : of frame, user and sensor; the mountings of Table 1 take turns
    level : of :data:`LEVEL_NAMES`

    Returns
    -------
    dict of numbers of this frame; only ``answered``, 0, where the calibration is refused. With
    sensors as real ones are, ``..._if_calibrated`` is the same coverage if the user states that
    their maker calibrated each
    """
    chosen, pose = FRAMES[level], tuple(MOUNTS)[seed % len(MOUNTS)]
    run, tape = tilt_run(seed, pose, chosen)
    try:
        found = calibrate_walker(run.recording, tape, settings=SETTINGS[level])
    except InputError:
        return {"answered": 0.0}
    off = found.mount.translation_body_m - MOUNTS[pose].translation_body_m
    turn = Rotation.from_matrix(
        found.mount.rotation_imu_to_body @ MOUNTS[pose].rotation_imu_to_body.T
    )
    row = {
        "answered": 1.0,
        "mount_error_m": float(np.linalg.norm(off)),
        "mount_turn_deg": float(np.rad2deg(turn.magnitude())),
        "mount_covered": float(np.mean(np.abs(off) < WITHIN * found.translation_sd_m)),
    }
    trusted = None
    if level == "real":
        trusted = calibrate_walker(run.recording, tape, settings=CALIBRATED)
        row["mount_covered_if_calibrated"] = float(
            np.mean(np.abs(off) < WITHIN * trusted.translation_sd_m)
        )
    for name, course in (("corridor", CORRIDOR), ("rectangle", RECTANGLE)):
        motion = simulate_walk(course, seed=seed, imperfections=chosen.imperfections)
        key = seed, pose, level
        row |= _walk_numbers(name, course, motion, key, found.mount, tape, SETTINGS[level])
        if trusted is not None:
            again = _walk_numbers(name, course, motion, key, trusted.mount, tape, CALIBRATED)
            row[f"{name}_end_covered_if_calibrated"] = again[f"{name}_end_covered"]
    return row


def _walk_numbers(
    name: str,
    course: tuple[Leg, ...],
    motion: WalkerMotion,
    key: tuple[int, str, str],
    mount: WalkerMount,
    tape: WalkerGeometry,
    settings: NavigationSettings,
) -> Numbers:
    seed, pose, level = key
    unit = unit_of(seed, pose)
    walk = attach_imu(motion, MOUNTS[pose], FRAMES[level].sensor, seed=1000 + unit, unit_seed=unit)
    path = estimate_trajectory(walk.recording, tape, mount, settings)
    goal = (walk.position_body_m[-1] - walk.position_body_m[0])[:2]
    end = (path.position_m[-1] - path.position_m[0])[:2]
    length = sum(leg.length_m for leg in course)
    error = end - goal
    sd = np.maximum(path.position_sd_m[-1, :2], 1e-9)
    return {
        f"{name}_end_percent": 100 * float(np.linalg.norm(error)) / length,
        f"{name}_distance_percent": 100
        * abs(float(np.linalg.norm(end) - np.linalg.norm(goal)))
        / length,
        f"{name}_end_covered": float(np.mean(np.abs(error) < WITHIN * sd)),
        f"{name}_steps_right": float(len(find_steps(path)) == len(motion.steps)),
    }


def frame_summary(rows: list[Numbers]) -> Numbers:
    """Medians of the errors and means of the fractions over all frames.

    Parameters
    ----------
    rows : from :func:`frame_row`

    Returns
    -------
    dict, with ``frames``
    """
    answered = [row for row in rows if row["answered"]]
    fraction = len(answered) / len(rows)
    return {"frames": len(rows), **_pooled(answered), "answered": fraction}


def _pooled(rows: list[Numbers]) -> Numbers:
    """Median of each error, mean of each fraction."""
    pooled = {}
    for key in rows[0]:
        values = [row[key] for row in rows]
        error = key.endswith(("_mps", "_m", "_deg", "_percent"))
        pooled[key] = float(np.nanmedian(values) if error else np.nanmean(values))
    return pooled


def level_real(executor: Any = None) -> dict[str, Any]:
    """Record ``level_real``: the headline numbers of each work at both levels.

    Parameters
    ----------
    executor : anything with ``submit``; None computes in this process

    Returns
    -------
    dict with ``numbers``: work to level to name to number; under ``first`` those of the first
    ``court`` and ``frame`` at the level "real"
    """
    levels = [(level,) for level in LEVEL_NAMES]
    scooters = run_all(scooter_numbers, levels, executor)
    numbers: dict[str, dict[str, Numbers]] = {
        "scooter": dict(zip(LEVEL_NAMES, scooters, strict=True)),
        "wheelchair": {},
        "walker": {},
    }
    for level in LEVEL_NAMES:
        courts = run_all(court_row, [(seed, level) for seed in range(COURTS)], executor)
        frames = run_all(frame_row, [(seed, level) for seed in range(WALKERS)], executor)
        numbers["wheelchair"][level] = court_summary(courts)
        numbers["walker"][level] = frame_summary(frames)
    # One of each by itself, which a test computes again.
    numbers["first"] = {"court": court_row(0, "real"), "frame": frame_row(0, "real")}
    return {
        "numbers": {
            work: {
                part: {key: float(f"{value:.4g}") for key, value in found.items()}
                for part, found in parts.items()
            }
            for work, parts in numbers.items()
        }
    }
