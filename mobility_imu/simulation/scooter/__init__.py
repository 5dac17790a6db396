"""A mobility scooter that is driven over courses, with an IMU on the lever and one on the body.

The rear axle follows a path as a kinematic bicycle does; both wheels meet the ground's slope and
roughness in turn. The two IMUs move with the rigid body, the steering and the lever, so that
centripetal, Euler and Coriolis terms are in what they measure: positions are differentiated twice,
no formula of an estimator is used.
"""

from mobility_imu.simulation.scooter.course import COURSES, SMOOTH_GROUND, Course, Ground, Segment
from mobility_imu.simulation.scooter.driver import (
    DRIVER_HZ,
    LARGEST_STEERING_RAD,
    LARGEST_THROTTLE_RAD,
    SPEED_LIMIT_MPS,
    Driver,
    draw_driver,
)
from mobility_imu.simulation.scooter.parked import (
    PARKED_POSES_DEG,
    PARKED_POSES_RAD,
    simulate_parked,
)
from mobility_imu.simulation.scooter.parts import (
    FAST_HZ,
    NO_SHAKING,
    PERFECT_REFERENCE,
    Layout,
    Reference,
    ScooterUnit,
    Shaking,
    draw_scooter,
)
from mobility_imu.simulation.scooter.reference import with_play
from mobility_imu.simulation.scooter.ride import SimulatedRide, simulate_ride

__all__ = [
    "COURSES",
    "DRIVER_HZ",
    "FAST_HZ",
    "LARGEST_STEERING_RAD",
    "LARGEST_THROTTLE_RAD",
    "NO_SHAKING",
    "PARKED_POSES_DEG",
    "PARKED_POSES_RAD",
    "PERFECT_REFERENCE",
    "SMOOTH_GROUND",
    "SPEED_LIMIT_MPS",
    "Course",
    "Driver",
    "Ground",
    "Layout",
    "Reference",
    "ScooterUnit",
    "Segment",
    "Shaking",
    "SimulatedRide",
    "draw_driver",
    "draw_scooter",
    "simulate_parked",
    "simulate_ride",
    "with_play",
]
