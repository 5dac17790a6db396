"""Scooter: what is wrong with a ride, its settings or a calibration is told, not only computed."""

import numpy as np
import pytest
from rides import FUSION, mount, ride

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import SUZUKI_ET4D, estimate_ride, find_faults


def changed(recording, sensor, acc):
    """Recording with other accelerations of one sensor."""
    imu = Imu(acc, recording.sensor(sensor).gyr_radps)
    return Recording(recording.time_s, {**recording.sensors, sensor: imu}, source="r.csv")


@pytest.mark.parametrize("sensor", ["lever", "body"])
def test_a_sensor_that_is_not_on_yet_is_named(sensor):
    """Without a direction of gravity there are no angles that a filter could start from."""
    acc = ride().sensor(sensor).acc_mps2.copy()
    acc[:300] = 0
    dead = changed(ride(), sensor, acc)
    with pytest.raises(InputError, match=rf"r.csv: {sensor}_acc_mps2: is 0 from 0 to 0.5 s"):
        estimate_ride(dead, SUZUKI_ET4D, mount(), FUSION)
    told = find_faults(dead, SUZUKI_ET4D, mount(), FUSION)
    assert any(fault.sensor == f"{sensor}_acc" for fault in told)
