"""Scooter: what is wrong with a ride, its settings or a calibration is told, not only computed."""

from dataclasses import replace

import numpy as np
import pytest
from rides import FUSION, mount, ride

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import SUZUKI_ET4D, RideSettings, estimate_ride, find_faults


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


def test_a_noise_far_below_that_of_the_recording_is_told_and_not_used():
    """A data sheet's noise, on a scooter that shakes: the stated sd would be too small."""
    plain = estimate_ride(ride(), SUZUKI_ET4D, mount(), FUSION)
    quiet = replace(FUSION, acc_noise_mps2=0.002)
    found = estimate_ride(ride(), SUZUKI_ET4D, mount(), quiet)
    (told,) = [text for text in found.warnings if "noise" in text]
    assert "0.002 m/s² is stated, the accelerations have 0." in told
    assert np.array_equal(found.steering_sd_rad, plain.steering_sd_rad)
    assert found.settings.acc_noise_mps2 == 0.002
    loud = replace(FUSION, acc_noise_mps2=1.0)
    assert not estimate_ride(ride(), SUZUKI_ET4D, mount(), loud).warnings
    with pytest.raises(InputError, match=r"acc_noise_mps2 = 1e-09: expected at least 0\.0001"):
        replace(FUSION, acc_noise_mps2=1e-9)


def test_a_ride_with_few_valid_samples_says_why():
    """Axes x and y of the lever exchanged: no steering angle explains most readings."""
    swapped = ride().sensor("lever").acc_mps2[:, [1, 0, 2]]
    bad = changed(ride(), "lever", swapped)
    found = estimate_ride(bad, SUZUKI_ET4D, mount(), RideSettings(median_window=25))
    assert found.valid.mean() < 0.5
    assert any("of the samples are valid: the others fit no angles" in w for w in found.warnings)
    unsure = replace(FUSION, acc_noise_mps2=100.0)
    (told,) = estimate_ride(ride(), SUZUKI_ET4D, mount(), unsure).warnings
    assert "leave the steering uncertain by 20 deg or more" in told
