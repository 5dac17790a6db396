"""Faults that begin or end within a drive are told with their times."""

import numpy as np
import pytest
from faulty import SENSORS, calibration, drive, look, of_code, slow

from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.wheelchair.fault_kinds import clean_drive
from mobility_imu.simulation import faults as inject
from mobility_imu.wheelchair import estimate_velocity, find_faults
from mobility_imu.wheelchair.faults import with_valid


def from_then_on(sensor, start_s, change, stop_s=np.inf):
    """Drive in which a sensor reads what another recording of it says, for a while."""
    trial = drive().trial
    now = (trial.time_s > start_s) & (trial.time_s < stop_s)
    old, new = trial.sensor(sensor), change(trial).sensor(sensor)
    sensors = dict(trial.sensors)
    sensors[sensor] = Imu(
        np.where(now[:, None], new.acc_mps2, old.acc_mps2),
        np.where(now[:, None], new.gyr_radps, old.gyr_radps),
    )
    return Recording(trial.time_s, sensors, source="changed"), now


def noisy(trial, sensor):
    rng = np.random.default_rng(4)
    sensors = dict(trial.sensors)
    gyr = sensors[sensor].gyr_radps + rng.normal(0, 0.5, (len(trial), 3))
    sensors[sensor] = Imu(sensors[sensor].acc_mps2, gyr)
    return Recording(trial.time_s, sensors)


def about(sensor, size_degps):
    return np.deg2rad(size_degps) * drive().court.mounting[sensor].rotation_body_to_imu[:, 2]


KINDS = {
    "scale": (lambda t, s: inject.scale(t, s, "gyr", 1.3), np.inf),
    "late": (lambda t, s: inject.late(t, s, 0.2), np.inf),
    "noise": (noisy, 35.0),
}
START_S = 25.0


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_that_begins_within_a_drive_is_told(kind, sensor):
    change, stop_s = KINDS[kind]
    faulty, now = from_then_on(sensor, START_S, lambda t: change(t, sensor), stop_s)
    found = [f for f in look(faulty) if f.sensor == sensor and f.code == "at odds"]
    assert len(found) == 1 and found[0].costs
    assert abs(found[0].first_s - START_S) < 8.0
    cal, chair = calibration(), drive().court.geometry
    result, clean = (
        estimate_velocity(one, chair, cal.mount, offsets=cal.offsets)
        for one in (faulty, drive().trial)
    )
    valid = with_valid(result, look(faulty)).valid
    assert valid[~now].mean() > 0.6
    # The yaw rate is the frame's, the speed the wheels'.
    name, least = ("yaw_rate_radps", np.deg2rad(2.0))
    if sensor != "frame":
        name, least = ("linear_velocity_mps", 0.05)
    off = np.abs(getattr(result, name) - getattr(clean, name))
    assert np.quantile(off[valid], 0.99) < least < off[~valid].max()


def test_an_offset_for_some_seconds_is_told():
    faulty, now = from_then_on(
        "frame", START_S, lambda t: inject.offset(t, "frame", "gyr", about("frame", 20.0)), 29.0
    )
    (found,) = look(faulty)
    assert (found.code, found.sensor) == ("at odds", "frame")
    assert found.flags[now].all() and found.flags.mean() < 0.3


def test_a_fault_of_the_whole_drive_is_no_fault_of_a_part():
    for faulty in (
        inject.late(drive().trial, "frame", 0.3),
        inject.scale(drive().trial, "left_wheel", "gyr", 1.2),
    ):
        assert not of_code(look(faulty), "at odds")


@pytest.mark.parametrize("seed", [1, 2, 3, 4, *map(slow, range(5, 13))])
def test_no_part_of_a_sound_drive_is_at_odds(seed):
    one = clean_drive(seed)
    cal = one.calibration()
    found = find_faults(one.trial, one.court.geometry, cal.mount, offsets=cal.offsets)
    assert not of_code(found, "at odds")
