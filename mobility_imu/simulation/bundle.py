"""What ``mobility-imu simulate`` writes: the files of a simulated recording with its truth.

Each function returns the contents by file name, tables and texts; nothing is written here.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TypeAlias

import numpy as np
import pandas as pd

from mobility_imu.frames import as_count, one_of
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry
from mobility_imu.simulation.levels import LEVELS, MOUNTS, REAL_LEVEL, tilt_run, unit_of
from mobility_imu.simulation.scooter import (
    COURSES,
    PARKED_POSES_DEG,
    SimulatedRide,
    draw_driver,
    draw_scooter,
    simulate_parked,
    simulate_ride,
)
from mobility_imu.simulation.sensor import LPMS_CU2, REAL
from mobility_imu.simulation.walker import (
    CORRIDOR,
    RECTANGLE,
    TIMED_UP_AND_GO,
    attach_imu,
    simulate_walk,
)
from mobility_imu.simulation.wheelchair import (
    COURT,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    random_mounting,
    simulate_court,
    simulate_drive,
)
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.wheelchair.geometry import SAMPLE_CHAIR

__all__ = [
    "SCOOTER_FILES",
    "SCOOTER_SENSORS",
    "WALKER_COURSES",
    "WALKER_FILES",
    "WALKER_LEVELS",
    "WHEELCHAIR_FILES",
    "WHEELCHAIR_LEVELS",
    "scooter_bundle",
    "walker_bundle",
    "wheelchair_bundle",
]

Contents: TypeAlias = dict[str, pd.DataFrame | str]

SCOOTER_FILES = (
    "geometry.toml",
    "ride.csv.gz",
    "truth.csv.gz",
    "reference.csv.gz",
    "poses.csv",
    "parked_level.csv.gz",
    "parked_ramp.csv.gz",
)
"""Names of the files of a scooter."""
WHEELCHAIR_FILES = (
    "geometry.toml",
    "static.csv.gz",
    "straight.csv.gz",
    "court.csv.gz",
    "truth.csv.gz",
)
"""Names of the files of a wheelchair."""
WALKER_FILES = (
    "geometry.toml",
    "true_mount.toml",
    "tilts.csv.gz",
    "walk.csv.gz",
    "truth.csv.gz",
)
"""Names of the files of a walking frame."""
WALKER_COURSES = MappingProxyType(
    {"corridor": CORRIDOR, "rectangle": RECTANGLE, "timed-up-and-go": TIMED_UP_AND_GO}
)
"""What can be walked, by name."""
SCOOTER_SENSORS = MappingProxyType({"data sheet": LPMS_CU2, "real": REAL})
"""Sensors of a scooter, by the name of their level."""
WHEELCHAIR_LEVELS = ("sample", "real")
"""Sensors of a chair: noise and biases like those of WheelMove-ID's sample, or the sizes of others'
recordings."""
WALKER_LEVELS = MappingProxyType({**LEVELS, "real": REAL_LEVEL})
"""Levels of a walking frame by name."""
RAMP_RAD = float(np.deg2rad(5))
"""Slope of the second place where the scooter is parked."""


def scooter_bundle(seed: int, course: str = "curves", *, level: str = "data sheet") -> Contents:
    """A scooter drawn from the seed: a ride, two parked recordings, truth and reference.

    Parameters
    ----------
    seed : the same seed gives the same contents
    course : name in ``mobility_imu.simulation.scooter.COURSES``
    level : name in :data:`SCOOTER_SENSORS`

    Returns
    -------
    dict of the contents by name, in the order of :data:`SCOOTER_FILES`

    Raises
    ------
    InputError
        If there is no such course or level, or the seed is negative or not whole.
    """
    one_of("course", course, tuple(COURSES))
    sensor = SCOOTER_SENSORS[one_of("level", level, tuple(SCOOTER_SENSORS))]
    unit = draw_scooter(seed)
    ride = simulate_ride(
        COURSES[course], seed=seed, unit=unit, driver=draw_driver(seed), sensor=sensor
    )
    parked = [
        simulate_parked(
            pitch_rad=pitch, bank_rad=0, seed=10 * seed + k, unit=unit, sensor=sensor
        ).to_frame()
        for k, pitch in enumerate((0.0, RAMP_RAD))
    ]
    poses = pd.DataFrame(
        np.array(PARKED_POSES_DEG, float), columns=["steering_deg", "throttle_deg"]
    )
    contents = (
        _scooter_section(SUZUKI_ET4D),
        ride.recording.to_frame(),
        ride.truth(),
        _reference(ride),
        poses,
        *parked,
    )
    return dict(zip(SCOOTER_FILES, contents, strict=True))


def wheelchair_bundle(seed: int, *, level: str = "sample") -> Contents:
    """A chair with 19 degrees of camber on a court: three trials, truth and geometry.

    Parameters
    ----------
    seed : the same seed gives the same contents
    level : name in :data:`WHEELCHAIR_LEVELS`; "real" drives with pushes, and its truth states slip

    Returns
    -------
    dict of the contents by name, in the order of :data:`WHEELCHAIR_FILES`

    Raises
    ------
    InputError
        If there is no such level, or the seed is negative or not whole.
    """
    real = one_of("level", level, WHEELCHAIR_LEVELS) == "real"
    mounting = random_mounting(seed)
    seeds = [1000 * seed + k for k in range(3)]
    trials = zip((STATIC_TRIAL, STRAIGHT_TRIAL, COURT), seeds, strict=True)
    drives = [
        simulate_court(legs, SAMPLE_CHAIR, mounting, seed=one, unit_seed=seed, model=REAL)
        if real
        else simulate_drive(legs, SAMPLE_CHAIR, mounting, seed=one)
        for legs, one in trials
    ]
    contents = (
        SAMPLE_CHAIR.to_toml(),
        *(drive.recording.to_frame() for drive in drives),
        drives[-1].truth(),
    )
    return dict(zip(WHEELCHAIR_FILES, contents, strict=True))


def walker_bundle(
    seed: int, course: str = "corridor", *, level: str = "realistic", pose: int = 1
) -> Contents:
    """A walking frame: tilts for the calibration, a walk, its truth, geometry and true mount.

    Parameters
    ----------
    seed : the same seed gives the same contents
    course : name in :data:`WALKER_COURSES`
    level : name in :data:`WALKER_LEVELS`
    pose : mounting of the paper's Table 1, 1 to 5

    Returns
    -------
    dict of the contents by name, in the order of :data:`WALKER_FILES`

    Raises
    ------
    InputError
        If there is no such course, level or pose, or the seed is negative or not whole.
    """
    path = WALKER_COURSES[one_of("course", course, tuple(WALKER_COURSES))]
    chosen = WALKER_LEVELS[one_of("level", level, tuple(WALKER_LEVELS))]
    mounting = str(one_of("pose", as_count(pose, "pose"), range(1, len(MOUNTS) + 1)))
    tilts, tape = tilt_run(seed, mounting, chosen)
    walk = attach_imu(
        simulate_walk(path, seed=seed, imperfections=chosen.imperfections),
        MOUNTS[mounting],
        chosen.sensor,
        seed=100 * seed + pose,
        unit_seed=unit_of(seed, mounting),  # the sensor of the tilts
    )
    contents = (
        _walker_section(tape),
        f"{_walker_section(tape)}\n{_mount_section(walk.mount)}",
        tilts.recording.to_frame(),
        walk.recording.to_frame(),
        walk.truth(),
    )
    return dict(zip(WALKER_FILES, contents, strict=True))


def _reference(ride: SimulatedRide) -> pd.DataFrame:
    """Table of the wire sensors, on their own clock."""
    return pd.DataFrame(
        {
            "time_s": ride.reference_time_s,
            "steering_deg": np.rad2deg(ride.reference[:, 0]),
            "throttle_deg": np.rad2deg(ride.reference[:, 1]),
        }
    )


def _scooter_section(geometry: ScooterGeometry) -> str:
    alpha, beta = np.rad2deg([geometry.steering_inclination_rad, geometry.lever_inclination_rad])
    return (
        f"[scooter]\nsteering_inclination_deg = {float(round(alpha, 9))}\n"
        f"lever_inclination_deg = {float(round(beta, 9))}\n"
    )


def _walker_section(tape: WalkerGeometry) -> str:
    return (
        f"[walker]\nfootprint_width_m = {tape.footprint_width_m:.4f}\n"
        f"footprint_length_m = {tape.footprint_length_m:.4f}\n"
    )


def _mount_section(mount: WalkerMount) -> str:
    rotation = [[round(float(v), 6) for v in row] for row in mount.rotation_imu_to_body]
    place = [round(float(v), 4) for v in mount.translation_body_m]
    return f"[walker.mount]\nrotation_imu_to_body = {rotation}\ntranslation_body_m = {place}\n"
