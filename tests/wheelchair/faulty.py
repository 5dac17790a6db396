"""Drives of a simulated chair whose sensors the tests spoil, and looks at what is found."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.reproduction.wheelchair.fault_kinds import clean_drive
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.wheelchair import find_faults
from mobility_imu.wheelchair.faults import results

SEED = 41
SENSORS = ("frame", "left_wheel", "right_wheel")


def slow(*values):
    """Further values of what the suite tries on some."""
    return pytest.param(*values, marks=pytest.mark.slow)


@cache
def drive(*, rests=True):
    return clean_drive(SEED, MTI_1, rests=rests)


@cache
def calibration(rests=True):
    return drive(rests=rests).calibration()


def look(trial, rests=True):
    cal = calibration(rests)
    geometry = drive(rests=rests).court.geometry
    return find_faults(trial, geometry, cal.mount, offsets=cal.offsets)


def of_code(found, code):
    return [fault for fault in found if fault.code == code]


def series(trial, rests=True):
    cal = calibration(rests)
    geometry = drive(rests=rests).court.geometry
    return results(trial, geometry, cal.mount, None, cal.offsets)


def largest(first, second, name):
    (key,) = [key for key in first if key[0] == name]
    return float(np.abs(first[key] - second[key]).max())


def turned(trial, sensor, angle_deg):
    """About an axis across the sensor's own one, so that the whole angle counts."""
    axis = drive().court.mounting[sensor].rotation_body_to_imu[:, 0]
    return inject.turn(
        trial, sensor, Rotation.from_rotvec(np.deg2rad(angle_deg) * axis).as_matrix()
    )
