"""Axes and halves that say nothing: what they hide, and what they do not."""

import numpy as np
import pytest
from faulty import SENSORS, calibration, drive, largest, look, of_code, series

from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation import faults as inject
from mobility_imu.wheelchair import estimate_velocity
from mobility_imu.wheelchair.faults import not_told


def dead(trial, sensor, half, axis, start=0, stop=None):
    """Recording in which an axis repeats its reading at the start, up to the stop."""
    imu = trial.sensor(sensor)
    values = {"acc": np.array(imu.acc_mps2), "gyr": np.array(imu.gyr_radps)}
    values[half][start:stop, axis] = values[half][start, axis]
    new = Imu(values["acc"], values["gyr"])
    return Recording(trial.time_s, {**trial.sensors, sensor: new}, source="dead")


def told(faulty):
    return {(fault.code, fault.sensor) for fault in look(faulty)}


@pytest.mark.parametrize("axis", range(3))
def test_a_dead_axis_of_the_frames_accelerometer_hides_no_fault_of_its_gyroscope(axis):
    """The frame's gyroscope knows the yaw rate without it."""
    trial = drive().trial
    mine = ("dead axis", f"frame_acc_{'xyz'[axis]}")
    zero = inject.scale(trial, "frame", "acc", np.where(np.arange(3) == axis, 0.0, 1.0))
    assert told(zero) == {mine}  # and it leans by nothing
    assert told(dead(trial, "frame", "acc", axis)) == {mine}
    late = told(dead(inject.late(trial, "left_wheel", 0.3), "frame", "acc", axis))
    assert ("lag", "left_wheel") in late and ("lag", "right_wheel") not in late
    for faulty in (inject.reverse(trial, "frame"), inject.scale(trial, "frame", "gyr", 1.1)):
        assert told(dead(faulty, "frame", "acc", axis)) > {mine}


@pytest.mark.parametrize("half", ["acc", "gyr"])
@pytest.mark.parametrize("sensor", SENSORS[1:])
def test_by_a_wheel_with_a_dead_axis_nothing_is_judged(sensor, half):
    """Its yaw rate comes from both halves."""
    for axis in range(3):
        mine = ("dead axis", f"{sensor}_{half}_{'xyz'[axis]}")
        assert told(dead(drive().trial, sensor, half, axis)) == {mine}
        late = look(dead(inject.late(drive().trial, "frame", 0.3), sensor, half, axis))
        (lag,) = of_code(late, "lag")
        assert lag.sensor == "frame" or "which of the two is wrong, two cannot tell" in lag.sentence


def test_the_accelerometers_fault_does_not_explain_that_wheels_and_frame_disagree():
    trial, cal, chair = drive().trial, calibration(), drive().court.geometry
    faulty = inject.late(trial, "frame", 0.5)
    found = estimate_velocity(faulty, chair, cal.mount, offsets=cal.offsets)
    (said,) = [one for one in found.warnings if "wheels and frame disagree" in one]
    for spoiled in (dead(trial, "frame", "acc", 0), inject.clip(trial, "left_wheel", "acc", 8.0)):
        faults = look(spoiled)
        assert faults and all("_acc" in fault.sensor for fault in faults)
        assert said in not_told(found, faulty, chair, cal.mount, faults)
    assert said not in not_told(found, faulty, chair, cal.mount, look(faulty))


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("axis", range(3))
def test_an_axis_that_is_dead_for_a_moment_is_replaced_there_only(sensor, axis):
    """In 0.4 s of a minute: elsewhere its own readings stay, and no sensor is at odds."""
    trial = drive().trial
    faulty = dead(trial, sensor, "gyr", axis, 2500, 2540)
    (found,) = look(faulty)
    assert (found.code, found.sensor) == ("dead axis", f"{sensor}_gyr_{'xyz'[axis]}")
    mended = found.repair(faulty).gyroscope(sensor)
    assert np.array_equal(mended[~found.flags], faulty.gyroscope(sensor)[~found.flags])
    real, costs = series(faulty), {cost.name: cost.largest for cost in found.costs}
    for name in ("distance", "turn"):
        moved = largest(real, series(trial), name)
        assert costs[name] < 2 * moved + 0.05


@pytest.mark.parametrize("part", [0.7, 1.0])
@pytest.mark.parametrize("sensor", SENSORS)
def test_an_accelerometer_that_is_frozen_is_no_sensor_at_odds(sensor, part):
    """What a wheel's gyroscope reads without gravity beside it is not the chair's yaw rate."""
    acc = np.array(drive().trial.sensor(sensor).acc_mps2)
    acc[: int(part * len(acc))] = acc[0]
    new = Imu(acc, drive().trial.gyroscope(sensor))
    trial = drive().trial
    faulty = Recording(trial.time_s, {**trial.sensors, sensor: new}, source="frozen")
    assert told(faulty) == {("frozen", f"{sensor}_acc")}


def test_a_line_through_a_long_loss_that_is_no_recording_ends_no_look():
    """Between readings half a turn apart it passes zero, as if gravity were taken out."""
    trial, lost = drive().trial, slice(260, 4722)
    acc = np.array(trial.sensor("right_wheel").acc_mps2)
    acc[lost] = acc[lost.start]
    new = Imu(acc, trial.gyroscope("right_wheel"))
    faulty = Recording(trial.time_s, {**trial.sensors, "right_wheel": new}, source="frozen")
    found = look(inject.late(faulty, "left_wheel", 0.3))
    assert ("frozen", "right_wheel_acc") in {(fault.code, fault.sensor) for fault in found}
    assert of_code(found, "lag") and told(faulty) == {("frozen", "right_wheel_acc")}
