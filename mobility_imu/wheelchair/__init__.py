"""Manual wheelchair: from wheel and frame IMUs to velocities, and from those to locomotor tasks."""

from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount
from mobility_imu.wheelchair.check import GeometryCheck, check_geometry
from mobility_imu.wheelchair.faults import find_faults
from mobility_imu.wheelchair.geometry import SAMPLE_CHAIR, WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.outcomes import Pushes, PushSettings, detect_pushes, task_events
from mobility_imu.wheelchair.settings import TaskSettings, read_settings
from mobility_imu.wheelchair.slip import (
    SlipReport,
    SlipSettings,
    SlipWindows,
    WheelSpeeds,
    correct_slip,
    detect_slip,
    slip_report,
    slip_sources,
    wheel_speeds,
)
from mobility_imu.wheelchair.smoothing import smooth_recording, with_smoothing_sd
from mobility_imu.wheelchair.tasks import Task, Tasks, identify_tasks, task_codes
from mobility_imu.wheelchair.uncertainty import AssumedErrors
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

__all__ = [
    "SAMPLE_CHAIR",
    "AssumedErrors",
    "ChairVelocity",
    "GeometryCheck",
    "PushSettings",
    "Pushes",
    "SlipReport",
    "SlipSettings",
    "SlipWindows",
    "Task",
    "TaskSettings",
    "Tasks",
    "VelocitySettings",
    "WheelSpeeds",
    "WheelchairCalibration",
    "WheelchairGeometry",
    "WheelchairMount",
    "calibrate_mount",
    "check_geometry",
    "correct_slip",
    "detect_pushes",
    "detect_slip",
    "estimate_velocity",
    "find_faults",
    "identify_tasks",
    "read_settings",
    "slip_report",
    "slip_sources",
    "smooth_recording",
    "task_codes",
    "task_events",
    "wheel_speeds",
    "with_smoothing_sd",
]
