"""Single readings of a gyroscope that are off by some times its noise."""

import numpy as np
import pytest
from faulty import SENSORS, drive, look, of_code

from mobility_imu.datasets.folders import find_folder
from mobility_imu.readers import read_recording
from mobility_imu.reproduction.wheelchair.fault_kinds import MODELS, clean_drive
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.sensor import REAL
from mobility_imu.wheelchair.contradictions import lone_jumps

DRIVES = find_folder("terrain-chair")


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_reading_that_is_off_by_ten_times_the_noise_is_told(sensor):
    """0.02 rad/s: 1.1 deg/s of a yaw rate that is known to 0.14 deg/s; two of three by chance."""
    rng = np.random.default_rng(12)
    told = []
    for axis in range(3):
        places = rng.choice(np.arange(300, len(drive().trial) - 300), 3, replace=False)
        found = of_code(
            look(inject.spike(drive().trial, sensor, "gyr", places, axis, 0.02)), "spike"
        )
        told.append(bool(found))
        for fault in found:
            assert fault.sensor == f"{sensor}_gyr" and set(np.flatnonzero(fault.flags)) <= set(
                places
            )
    assert sum(told) >= 2


@pytest.mark.parametrize("model", [*MODELS.values(), REAL], ids=[*MODELS, "real"])
def test_no_reading_of_a_sound_gyroscope_is_off(model):
    for seed in (71, 72, 73):
        trial = clean_drive(seed, model).trial
        for imu in trial.sensors.values():
            assert not lone_jumps(imu.gyr_radps, imu.acc_mps2, trial.sampling_rate_hz).any()


@pytest.mark.skipif(DRIVES is None, reason="the drives are not here")
def test_no_reading_of_a_real_chair_is_off():
    files = sorted(DRIVES.glob("*_donut.csv.gz")) + sorted(DRIVES.glob("*_straight.csv.gz"))
    assert len(files) >= 5
    for file in files:
        drive_ = read_recording(file)
        for imu in drive_.sensors.values():
            assert not lone_jumps(imu.gyr_radps, imu.acc_mps2, drive_.sampling_rate_hz).any()
