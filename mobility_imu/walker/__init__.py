"""Walking frame with one IMU: calibrated by tilting, then followed (Doan & Pham)."""

from mobility_imu.walker.calibration import MountCalibration, calibrate_mount
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory

__all__ = [
    "MountCalibration",
    "Trajectory",
    "WalkerGeometry",
    "WalkerMount",
    "calibrate_mount",
    "estimate_trajectory",
]
