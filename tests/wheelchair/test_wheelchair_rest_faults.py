"""Offsets that a chair's rests show and a constant does not undo."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from faulty import SENSORS, calibration, drive, look, of_code, slow

from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation import faults as inject
from mobility_imu.wheelchair import VelocitySettings, check_geometry, estimate_velocity
from mobility_imu.wheelchair.check import NO_VERDICT_WHY
from mobility_imu.wheelchair.faults import not_told, with_valid


def changed(sensor, series_degps):
    """Drive whose gyroscope reads more along its main axis, by a series."""
    trial = drive().trial
    axis = drive().court.mounting[sensor].rotation_body_to_imu[:, 2]
    sensors = dict(trial.sensors)
    gyr = sensors[sensor].gyr_radps + np.deg2rad(series_degps)[:, None] * axis
    sensors[sensor] = Imu(sensors[sensor].acc_mps2, gyr)
    return Recording(trial.time_s, sensors, source="changed")


def stepped(sensor, size_degps, part):
    count = len(drive().trial)
    return changed(sensor, size_degps * (np.arange(count) > part * count)), part * count


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("size", [3.0, 10.0])
@pytest.mark.parametrize("part", [0.3, slow(0.6)])
def test_a_step_of_an_offset_is_told_with_its_time(sensor, size, part):
    faulty, sample = stepped(sensor, size, part)
    # Between the two times, of the step and of what is told, the sensor may be at odds.
    (found,) = of_code(look(faulty), "offset")
    assert found.sensor == f"{sensor}_gyr"
    assert found.size == pytest.approx(size, abs=0.4)
    about = float(found.sentence.partition("at about ")[2].partition(" s")[0])
    assert about == pytest.approx(faulty.time_s[int(sample)], abs=3.0)  # a wheel slips in between
    assert found.costs and found.repair is not None
    assert not of_code(look(found.repair(faulty)), "offset")


def test_samples_under_another_offset_are_not_valid():
    """Where the constant that is taken off is right, they are; elsewhere the yaw rate is off."""
    faulty, _ = stepped("frame", 3.0, 0.6)
    cal, chair = calibration(), drive().court.geometry
    result = estimate_velocity(faulty, chair, cal.mount, offsets=cal.offsets)
    clean = estimate_velocity(drive().trial, chair, cal.mount, offsets=cal.offsets)
    valid = with_valid(result, look(faulty)).valid
    off = np.abs(result.yaw_rate_radps - clean.yaw_rate_radps)
    assert off[valid].max() < np.deg2rad(0.5) < np.deg2rad(2.0) < off[~valid].max()
    assert 0.2 < valid.mean() < 0.8


def test_a_drift_is_told_as_one():
    count = len(drive().trial)
    (found,) = look(changed("frame", np.linspace(0, 4.0, count)))
    assert found.code == "offset" and "drifts by" in found.sentence
    assert found.size == pytest.approx(4.0, abs=0.6)
    assert found.flags.any() and not found.flags.all()


CHANGES = {
    "a step": lambda sensor: stepped(sensor, 3.0, 0.5)[0],
    "a drift": lambda sensor: changed(sensor, np.linspace(0, 4.0, len(drive().trial))),
}


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("kind", CHANGES)
def test_the_geometry_is_not_judged_with_an_offset_that_changes(kind, sensor):
    """One constant is fitted with the track, which is wrong in a part of the drive."""
    faulty, cal = CHANGES[kind](sensor), calibration()
    found = check_geometry(faulty, drive().court.geometry, cal.mount, offsets=cal.offsets)
    (told,) = of_code(look(faulty), "offset")
    assert told.sentence in found.warnings and found.warnings[0] == NO_VERDICT_WHY
    assert not found.judged and not found.fits and np.isnan(found.track_m)
    # All of its samples may be touched: that it changes is another thing.
    everywhere = replace(told, flags=np.ones(len(faulty), np.bool_))
    assert told.changes and everywhere.changes
    assert not of_code(look(with_offsets(["frame"], 20.0)), "offset")[0].changes


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("size", [20.0, 50.0])
def test_a_large_offset_is_told_as_one(sensor, size):
    """No sound sensor has it: it is not taken off, and was told as a scale or a turned sensor."""
    up = drive().court.mounting[sensor].rotation_body_to_imu[:, 2]
    faulty = inject.offset(drive().trial, sensor, "gyr", np.deg2rad(size) * up)
    (found,) = look(faulty)
    assert (found.code, found.sensor) == ("offset", f"{sensor}_gyr")
    assert found.size == pytest.approx(size, abs=0.5) and "while the chair stands" in found.sentence
    assert {cost.name for cost in found.costs if cost.largest > 0} >= {
        "turn" if sensor == "frame" else "distance"
    }


def with_offsets(names, size_degps):
    trial = drive().trial
    for name in names:
        main = drive().court.mounting[name].rotation_body_to_imu[:, 2]
        trial = inject.offset(trial, name, "gyr", np.deg2rad(size_degps) * main)
    return trial


@pytest.mark.parametrize("names", list(combinations(SENSORS, 2)))
def test_two_large_offsets_are_both_told(names):
    """The third stands: they were told as scales, or as offsets that no rest shows."""
    found = look(with_offsets(names, 20.0))
    assert [(fault.code, fault.sensor) for fault in found] == [
        ("offset", f"{name}_gyr") for name in names
    ]
    assert all("while the chair stands" in fault.sentence for fault in found)


def test_what_rests_show_is_not_said_to_be_shown_by_none():
    """Three that read much may turn steadily; gravity shows an offset all the same."""
    for fault in of_code(look(with_offsets(SENSORS, 20.0)), "offset"):
        assert "its rests show more than any sound sensor's offset" in fault.sentence
        assert "no rest of the drive" not in fault.sentence


def test_a_steady_turn_of_all_is_no_offset():
    """Each reads the same turn, about another axis of its own."""
    trial = drive().trial
    turn = np.deg2rad([12.0, 0.0, 0.0]), np.deg2rad([7.0, 7.0, 7.0]), np.deg2rad([0.0, 12.0, 0.0])
    for name, rates in zip(SENSORS, turn, strict=True):
        trial = inject.offset(trial, name, "gyr", rates)
    assert not any("while the chair stands" in fault.sentence for fault in look(trial))


def test_a_small_change_and_a_constant_are_no_fault():
    assert look(stepped("frame", 0.3, 0.5)[0]) == ()
    assert not of_code(look(changed("left_wheel", np.full(len(drive().trial), 3.0))), "offset")


def without_rest(warnings):
    return [one for one in warnings if "no second of rest" in one]


@pytest.mark.parametrize("sensor", SENSORS)
def test_no_warning_says_that_a_chair_never_rests_whose_rest_shows_an_offset(sensor):
    cal, chair = calibration(), drive().court.geometry
    faulty = with_offsets([sensor], 20.0)
    told, found = look(faulty), estimate_velocity(faulty, chair, cal.mount)
    assert "while the chair stands" in of_code(told, "offset")[0].sentence
    (said,) = without_rest(found.warnings)
    assert f"known or taken off ({sensor})" in said
    assert said in not_told(found, faulty, chair, cal.mount, ())
    assert not without_rest(not_told(found, faulty, chair, cal.mount, told))
    assert not without_rest(check_geometry(faulty, chair, cal.mount).warnings)


def test_the_sensors_whose_offset_is_not_told_are_still_named():
    trial, cal = drive(rests=False).trial, calibration(rests=False)
    chair = drive(rests=False).court.geometry
    found = estimate_velocity(trial, chair, cal.mount)
    (fault,) = of_code(look(with_offsets(["frame"], 20.0)), "offset")
    (said,) = without_rest(not_told(found, trial, chair, cal.mount, [fault]))
    assert "known or taken off (left_wheel, right_wheel)" in said
    (said,) = without_rest(not_told(found, trial, chair, cal.mount, ()))
    assert "known or taken off (frame, left_wheel, right_wheel)" in said
    printed = VelocitySettings(form="printed")
    found = estimate_velocity(trial, chair, cal.mount, printed)
    assert not without_rest(not_told(found, trial, chair, cal.mount, [fault]))
