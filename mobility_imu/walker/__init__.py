"""Walking frame with one IMU: calibrated by tilting, then followed (Doan & Pham).

The way of the data: ``WalkerGeometry`` is measured, ``calibrate_mount`` finds the
``WalkerMount``, ``estimate_trajectory`` the path, ``find_steps`` the steps of the
frame, ``walking_summary`` and the walking tests what they say; ``find_faults`` tells what
was wrong with the recording.
"""

from mobility_imu.walker.calibration import WalkerCalibration, calibrate_mount
from mobility_imu.walker.faults import find_faults, find_tilt_faults, valid_samples
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation import ClosedLoop, NavigationSettings
from mobility_imu.walker.steps import GaitSettings, Steps, Turns, find_steps, find_turns
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.tilt_detection import Tilt
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory
from mobility_imu.walker.walking_tests import (
    TimedUpAndGo,
    WalkingSummary,
    WalkTest,
    six_minute_walk,
    ten_metre_walk,
    timed_up_and_go,
    walking_summary,
)

__all__ = [
    "ClosedLoop",
    "GaitSettings",
    "NavigationSettings",
    "Steps",
    "StillnessSettings",
    "Tilt",
    "TimedUpAndGo",
    "Trajectory",
    "Turns",
    "WalkTest",
    "WalkerCalibration",
    "WalkerGeometry",
    "WalkerMount",
    "WalkingSummary",
    "calibrate_mount",
    "estimate_trajectory",
    "find_faults",
    "find_steps",
    "find_tilt_faults",
    "find_turns",
    "six_minute_walk",
    "ten_metre_walk",
    "timed_up_and_go",
    "valid_samples",
    "walking_summary",
]
