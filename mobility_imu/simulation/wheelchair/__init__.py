"""A manual chair with an IMU on each wheel and the frame, driven along legs.

``simulate_drive`` rolls smoothly on a flat floor without slip; ``simulate_court`` adds pushes,
coasting and braking, wheels that slip or skid, toe, slopes and any sensor model.
"""

from mobility_imu.simulation.sensor import IDEAL, SensorNoise
from mobility_imu.simulation.wheelchair.chair import SIDES, Leg, Mounting, random_mounting
from mobility_imu.simulation.wheelchair.court import FINER, SimulatedCourt, simulate_court
from mobility_imu.simulation.wheelchair.drive import (
    COURT,
    LIKE_SAMPLE,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    SimulatedDrive,
    simulate_drive,
)
from mobility_imu.simulation.wheelchair.pushing import Pushing, SlipEpisode
from mobility_imu.simulation.wheelchair.random_courts import Court, random_court

__all__ = [
    "COURT",
    "FINER",
    "IDEAL",
    "LIKE_SAMPLE",
    "SIDES",
    "STATIC_TRIAL",
    "STRAIGHT_TRIAL",
    "Court",
    "Leg",
    "Mounting",
    "Pushing",
    "SensorNoise",
    "SimulatedCourt",
    "SimulatedDrive",
    "SlipEpisode",
    "random_court",
    "random_mounting",
    "simulate_court",
    "simulate_drive",
]
