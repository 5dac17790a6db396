"""Simulated recordings that several tests of the walker take."""

import functools
from dataclasses import replace

from scipy.spatial.transform import Rotation

from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker import tables
from mobility_imu.simulation.sensor import MTI_1, without
from mobility_imu.simulation.walker import (
    CORRIDOR,
    PERFECT,
    attach_imu,
    simulate_tilts,
    simulate_walk,
)
from mobility_imu.walker.calibration import calibrate_from_path
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.geometry import FOOTPRINT as FRAME
from mobility_imu.walker.geometry import TILT_DIRECTIONS

pose_mount = functools.cache(tables.pose_mount)
"""Mounting of one pose: 10 ms from the printed tables, and some tests need it a hundred times."""
DATASHEET = without(MTI_1, "scale_sd", "misalignment_sd_rad", "g_sensitivity_sd")


@functools.cache
def tilt_recording(
    seed=0, pose="1", sensor=DATASHEET, imperfections=PERFECT, order=TILT_DIRECTIONS
):
    motion = simulate_tilts(FRAME, seed=seed, order=order, imperfections=imperfections)
    unit = 10 * seed + int(pose)
    return attach_imu(motion, pose_mount(pose), sensor, seed=unit, unit_seed=unit).recording


@functools.cache
def walked(pose="1", course=CORRIDOR):
    return attach_imu(
        simulate_walk(course, seed=1), pose_mount(pose), DATASHEET, seed=1, unit_seed=1
    )


def rebuilt(recording, *, time_s=None, acc=None, gyr=None):
    """The recording with other times or readings."""
    imu = recording.sensors["frame"]
    return Recording(
        recording.time_s if time_s is None else time_s,
        {"frame": Imu(imu.acc_mps2 if acc is None else acc, imu.gyr_radps if gyr is None else gyr)},
        source=recording.source,
    )


def changed(path, **values):
    """The path of an IMU with other values in some of its fields."""
    return path._replace(**values) if hasattr(path, "_replace") else replace(path, **values)


def errors(calibration, pose):
    mount = pose_mount(pose)
    turn = calibration.mount.rotation_imu_to_body @ mount.rotation_imu_to_body.T
    return (
        calibration.mount.translation_body_m - mount.translation_body_m,
        Rotation.from_matrix(turn).magnitude(),
    )


def cut_out(recording, keep):
    imu = recording.sensors["frame"]
    return Recording(
        recording.time_s[keep], {"frame": Imu(imu.acc_mps2[keep], imu.gyr_radps[keep])}
    )


def placed(recording, geometry, **options):
    """Calibration without what the sensor's errors do: the same mount in a tenth of the time."""
    return calibrate_from_path(navigate_recording(recording)[0], geometry, **options)
