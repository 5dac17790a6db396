"""Manual wheelchair: from wheel and frame IMUs to velocities, and from those to locomotor tasks."""

from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate
from mobility_imu.wheelchair.geometry import SAMPLE_CHAIR, WheelchairGeometry
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.tasks import Task, identify_tasks
from mobility_imu.wheelchair.velocity import ChairVelocity, estimate_velocity

__all__ = [
    "SAMPLE_CHAIR",
    "ChairVelocity",
    "Task",
    "TaskSettings",
    "WheelchairCalibration",
    "WheelchairGeometry",
    "calibrate",
    "estimate_velocity",
    "identify_tasks",
]
