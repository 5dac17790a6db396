"""Steering and throttle angles of a motorized mobility scooter (Suzurikawa et al. 2022)."""

from mobility_imu.scooter.angles import ScooterAngles, angle_standard_deviations, estimate_angles
from mobility_imu.scooter.calibration import ScooterCalibration, calibrate_mount
from mobility_imu.scooter.faults import find_faults, mark_faults
from mobility_imu.scooter.fusion import FusedAngles, FusionSettings, fuse_angles
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.pose_check import (
    PoseCheck,
    PoseCheckSettings,
    check_poses,
    pose_uncertainty,
)
from mobility_imu.scooter.ride import Remark, RideAngles, RideSettings, estimate_ride

__all__ = [
    "SUZUKI_ET4D",
    "FusedAngles",
    "FusionSettings",
    "PoseCheck",
    "PoseCheckSettings",
    "Remark",
    "RideAngles",
    "RideSettings",
    "ScooterAngles",
    "ScooterCalibration",
    "ScooterGeometry",
    "ScooterMount",
    "angle_standard_deviations",
    "calibrate_mount",
    "check_poses",
    "estimate_angles",
    "estimate_ride",
    "find_faults",
    "fuse_angles",
    "mark_faults",
    "pose_uncertainty",
]
