"""Simulated rides that several test files put faults into."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.scooter import SUZUKI_ET4D, RideSettings, ScooterMount, estimate_ride
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import COURSES, draw_driver, draw_scooter, simulate_ride

FUSION = RideSettings(method="fusion")
LIKE_NEW = np.full(6, np.deg2rad(0.5))
"""Standard deviations of a mount that was calibrated with care, rad."""


def slow(*values):
    """Further values of what the suite tries at its ends."""
    return pytest.param(*values, marks=pytest.mark.slow)


@cache
def ride(seed=51, course="curves"):
    unit, driver = draw_scooter(seed), draw_driver(seed)
    return simulate_ride(COURSES[course], seed=seed, unit=unit, driver=driver).recording


@cache
def mount(seed=51):
    unit = draw_scooter(seed)
    turns = [Rotation.from_rotvec(tilt).as_matrix() for tilt in unit.mountings.values()]
    return ScooterMount(*turns, LIKE_NEW)


@cache
def unspoilt(settings, seed=51):
    """What a calibrated ride without a fault gives."""
    return estimate_ride(ride(seed), SUZUKI_ET4D, mount(seed), settings)


def turned(recording, sensor, axis, angle_deg):
    rotation = Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
    return put.turn(recording, sensor, rotation)


def moved_deg(found, clean):
    """Largest change of steering and throttle where the sound ride is valid."""
    return [
        np.rad2deg(
            np.abs(getattr(found, f"{name}_rad") - getattr(clean, f"{name}_rad"))[clean.valid].max()
        )
        for name in ("steering", "throttle")
    ]
