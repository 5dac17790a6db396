"""Scooter, two sensors: short ways to their agreement lead where the long ones lead."""

from functools import cache, partial
from itertools import product

import numpy as np
import pytest
from rides import mount, ride

from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter.agreement import agreement
from mobility_imu.scooter.sensor_pair import SensorPair

NAMES = ("lever", "body")
CYCLE = np.eye(3)[[1, 2, 0]]
FLIP = np.diag([1.0, -1.0, 1.0])


@cache
def pair(calibrated=True, with_rests=True):
    recording = ride() if with_rests else ride().trim(3.0, 17.0)
    return SensorPair(recording, SUZUKI_ET4D, mount() if calibrated else None)


def rearranged(recording, *, sensor, acc, gyr):
    imu = recording.sensor(sensor)
    other = Imu(imu.acc_mps2 @ acc.T, imu.gyr_radps @ gyr.T)
    return Recording(recording.time_s, {**recording.sensors, sensor: other})


@pytest.mark.parametrize("calibrated", [True, False])
@pytest.mark.parametrize("name", NAMES)
def test_a_gyroscope_is_multiplied_as_if_its_readings_were(name, calibrated):
    """Each axis adds to the motion by itself, so that no series is made anew."""
    two = pair(calibrated)
    for factors in (1.0, 0.5, -1.0, np.array([1.0, -1.0, 2.0]), np.array([0.0, 1.0, 1.3])):
        rates = {**two.readings.gyr, name: two.readings.gyr[name] * factors}
        long = agreement(two.seen, two.moved(rates, two.seen))
        assert two.with_rates(name, factors) == pytest.approx(long, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("with_rests", [True, False])
@pytest.mark.parametrize("name", NAMES)
def test_a_sensor_in_other_axes_agrees_as_its_recording_would(name, with_rests):
    """Medians at rest turn exactly with axes that are exchanged or reversed."""
    two, seen = pair(with_rests=with_rests), 0
    assert (two.rest is not None) == with_rests
    for acc, gyr in product((np.eye(3), CYCLE, FLIP), repeat=2):
        short = two.in_axes(name, acc=acc, gyr=gyr)
        long = two.repaired(partial(rearranged, sensor=name, acc=acc, gyr=gyr))
        assert (short is None) == (long is None)
        if long is not None:
            assert short == pytest.approx(long, rel=1e-9, abs=1e-9)
            seen += 1
    assert seen >= 3
