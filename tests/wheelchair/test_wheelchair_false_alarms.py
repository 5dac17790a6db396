"""Sound drives that are short or turn on the spot; what must not be blamed for another fault."""

import numpy as np
import pytest
from faulty import SENSORS, calibration, drive, look, of_code, slow

from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.wheelchair.fault_kinds import clean_drive
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.simulation.wheelchair import Leg, random_mounting, simulate_court
from mobility_imu.simulation.wheelchair.drive import STATIC_TRIAL, STRAIGHT_TRIAL
from mobility_imu.wheelchair import SAMPLE_CHAIR, calibrate_mount, estimate_velocity, find_faults
from mobility_imu.wheelchair.faults import not_told, valid_samples


def looked_at(legs, seed):
    mounting = random_mounting(seed)
    static, straight, trial = (
        simulate_court(
            part, SAMPLE_CHAIR, mounting, seed=10 * seed + k, unit_seed=seed, model=MTI_1
        )
        for k, part in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, legs))
    )
    cal = calibrate_mount(static.recording, straight.recording)
    return find_faults(trial.recording, SAMPLE_CHAIR, cal.mount, offsets=cal.offsets)


@pytest.mark.parametrize("length_s", [7.0, 10.0])
@pytest.mark.parametrize("seed", [1, slow(2), slow(3), slow(4)])
def test_short_parts_of_a_sound_drive_are_sound(seed, length_s):
    """A fit of few pieces stated 0.80 ± 0.02 deg/s, an axle or a lean of 9 deg.

    A slip may last for most of such a part, in which wheels and frame are at odds indeed.
    """
    one = clean_drive(seed)
    cal, start_s = one.calibration(), float(one.trial.time_s[0])
    while start_s + length_s < one.trial.time_s[-1]:
        part = one.trial.trim(start_s, start_s + length_s)
        found = find_faults(part, one.court.geometry, cal.mount, offsets=cal.offsets)
        assert {fault.code for fault in found} <= {"at odds"}
        start_s += length_s / 2


@pytest.mark.parametrize("seed", range(1, 5))
def test_a_straight_trial_is_sound(seed):
    one = clean_drive(seed)
    cal = one.calibration()
    assert find_faults(one.straight, one.court.geometry, cal.mount, offsets=cal.offsets) == ()


@pytest.mark.parametrize("yaw_degps", [90.0, 150.0, 200.0])
def test_a_turn_on_the_spot_is_sound(yaw_degps):
    """A sensor on the rim is pulled outward, and up with it, to one side in its axes."""
    turns = (Leg(1, 3.0), Leg(4, 10.0, 0, yaw_degps), Leg(4, 10.0, 0, -yaw_degps), Leg(1, 3.0))
    for seed in (1, 2):
        assert looked_at(turns, seed) == ()


def test_both_wheels_that_read_too_much_are_not_the_frame_that_reads_too_little():
    faulty = drive().trial
    for sensor in SENSORS[1:]:
        faulty = inject.scale(faulty, sensor, "gyr", 1.05)
    found = look(faulty)
    assert [(f.code, f.sensor) for f in found] == [
        ("scale", "left_wheel_gyr"),
        ("scale", "right_wheel_gyr"),
    ]


def test_one_wheel_is_not_called_both():
    sensors = dict(drive().trial.sensors)
    alone = Recording(drive().trial.time_s, {k: sensors[k] for k in SENSORS[:2]})
    (found,) = of_code(look(inject.scale(alone, "frame", "gyr", 1.1)), "scale")
    assert "against the left wheel" in found.sentence and "both" not in found.sentence


@pytest.mark.parametrize("sensor", SENSORS[1:])
def test_axes_in_another_order_are_told_once(sensor):
    """Wrong signs and an axle 139 deg off contradict each other; both are one export's."""
    sensors = dict(drive().trial.sensors)
    order = [1, 0, 2]
    sensors[sensor] = Imu(sensors[sensor].acc_mps2[:, order], sensors[sensor].gyr_radps[:, order])
    found = look(Recording(drive().trial.time_s, sensors, source="other order"))
    mine = [fault for fault in found if fault.sensor.startswith(sensor)]
    assert len(mine) == 1 and mine[0].code in ("turned", "reversed")
    assert mine[0].code == "reversed" or "axes in another order" in mine[0].sentence


def test_a_drive_too_short_to_compare_its_sensors_says_so():
    trial, cal, chair = drive().trial, calibration(), drive().court.geometry
    for length_s, said in ((4.0, True), (8.0, False)):
        part = trial.trim(trial.time_s[0], trial.time_s[0] + length_s)
        result = estimate_velocity(part, chair, cal.mount, offsets=cal.offsets)
        warnings = not_told(result, part, chair, cal.mount, ())
        assert any("too short to compare the sensors" in one for one in warnings) == said


@pytest.mark.parametrize("sensor", SENSORS[1:])
def test_an_axis_of_an_accelerometer_with_the_wrong_sign_is_not_the_gyroscope(sensor):
    """The result does not depend on it: the samples stay valid."""
    for axis in range(3):
        signs = np.where(np.arange(3) == axis, -1.0, 1.0)
        found = look(inject.scale(drive().trial, sensor, "acc", signs))
        assert {(f.code, f.sensor) for f in found} <= {("reversed", f"{sensor}_acc")}
        assert valid_samples(found, len(drive().trial)).all()
        for fault in found:
            assert f"axis {'xyz'[axis]} of the accelerometer" in fault.sentence


@pytest.mark.parametrize("sensor", SENSORS[1:])
def test_one_accelerometer_that_reads_gravity_is_told_as_such(sensor):
    found = look(inject.scale(drive().trial, sensor, "acc", (-1, -1, -1)))
    assert [(fault.code, fault.sensor) for fault in found] == [("reversed", f"{sensor}_acc")]
    assert "-1 g upward" in found[0].sentence and valid_samples(found, len(drive().trial)).all()


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_clock_that_drifts_is_told_as_one(sensor):
    trial = drive().trial
    sensors, at = dict(trial.sensors), trial.time_s - np.linspace(0, 0.08, len(trial))
    sensors[sensor] = Imu(
        *(
            np.column_stack([np.interp(at, trial.time_s, axis) for axis in values.T])
            for values in (sensors[sensor].acc_mps2, sensors[sensor].gyr_radps)
        )
    )
    faulty = Recording(trial.time_s, sensors, source="drifts")
    (found,) = of_code(look(faulty), "lag")
    assert found.sensor == sensor and "clock that drifts" in found.sentence
    assert found.size == pytest.approx(0.08, abs=0.03)
    assert not of_code(look(inject.late(trial, sensor, 0.2)), "lag")[0].sentence.count("drifts")
