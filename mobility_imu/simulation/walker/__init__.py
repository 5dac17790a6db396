"""A walking frame that is tilted for its calibration, or walked with, and an IMU fixed to it.

The rigid frame's position and orientation are written down as smooth functions of time; what the
IMU feels follows by differentiating its own path twice, no formula of an estimator is used.
"""

from mobility_imu.simulation.walker.imu import SimulatedWalker, attach_imu
from mobility_imu.simulation.walker.motion import (
    FAST_HZ,
    PERFECT,
    REALISTIC,
    Imperfections,
    StepTruth,
    TiltTruth,
    WalkerMotion,
)
from mobility_imu.simulation.walker.tilts import TiltStyle, measured_geometry, simulate_tilts
from mobility_imu.simulation.walker.walk import (
    CORRIDOR,
    OUT_AND_BACK_30,
    RECTANGLE,
    RECTANGLE_OPEN,
    TIMED_UP_AND_GO,
    Leg,
    WalkStyle,
    simulate_walk,
)

__all__ = [
    "CORRIDOR",
    "FAST_HZ",
    "OUT_AND_BACK_30",
    "PERFECT",
    "REALISTIC",
    "RECTANGLE",
    "RECTANGLE_OPEN",
    "TIMED_UP_AND_GO",
    "Imperfections",
    "Leg",
    "SimulatedWalker",
    "StepTruth",
    "TiltStyle",
    "TiltTruth",
    "WalkStyle",
    "WalkerMotion",
    "attach_imu",
    "measured_geometry",
    "simulate_tilts",
    "simulate_walk",
]
