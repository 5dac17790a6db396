"""Scooter: what is wrong with a ride, its settings or a calibration is told, not only computed."""

import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from rides import FUSION, mount, moved_deg, ride, unspoilt

from mobility_imu.errors import InputError
from mobility_imu.faults import rescaled
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    Remark,
    RideAngles,
    RideSettings,
    ScooterGeometry,
    ScooterMount,
    calibrate_mount,
    check_poses,
    estimate_ride,
    find_faults,
    mark_faults,
)
from mobility_imu.scooter.calibration import ParkedPose, mount_from_poses
from mobility_imu.scooter.contradictions import contradictions
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import PARKED_POSES_RAD, draw_scooter, simulate_parked
from mobility_imu.simulation.sensor import LPMS_CU2, REAL


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
    plain = unspoilt(FUSION)
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
    assert tuple(one.sentence for one in found.remarks) == found.warnings
    unsure = replace(FUSION, acc_noise_mps2=100.0)
    found = estimate_ride(ride(), SUZUKI_ET4D, mount(), unsure)
    (told,) = found.warnings
    assert found.remarks == (("estimate", "", told),)
    assert "leave the steering uncertain by 20 deg or more" in told


def test_warnings_are_the_sentences_of_the_remarks():
    """A command reads the remarks: warnings of another origin would not be told."""
    rad = np.zeros(3)
    found = RideAngles(rad, rad, rad, rad, rad, rad == 0, RideSettings())
    assert "remark" not in repr(found)
    one = Remark("settings", "", "odd")
    told = replace(found, remarks=(one,))
    assert repr(told).endswith(", 1 warning(s))") and told.warnings == ("odd",)
    assert pickle.loads(pickle.dumps(told)).warnings == ("odd",)
    assert not replace(told, remarks=()).warnings
    with pytest.raises(ValueError, match="warnings"):
        replace(told, warnings=("other",))
    for wrong, says in (
        (None, "remarks: got None, expected a tuple of Remark"),
        ("abc", "remarks: got 'abc', expected a tuple of Remark"),
        (3, "remarks: got 3, expected a tuple of Remark"),
        (["odd"], r"remarks\[0\]: got str, expected Remark"),
        (("odd",), r"remarks\[0\]: got str, expected Remark"),
        ((tuple(one),), r"remarks\[0\]: got tuple, expected Remark"),
        ((one._replace(code="odd"),), "code of a remark = 'odd'"),
        ((one._replace(code=[]),), r"code of a remark = \[\]"),
        ((one._replace(sensor=None),), "sensor of a remark: got NoneType, expected str"),
        ((one._replace(sentence=5),), "sentence of a remark: got int, expected str"),
    ):
        with pytest.raises(InputError, match=says):
            replace(found, remarks=wrong)


def car_park(seed=5, sensor=LPMS_CU2):
    unit = draw_scooter(seed)
    return [
        simulate_parked(
            pitch_rad=pitch, bank_rad=0.0, seed=100 * seed + k, unit=unit, sensor=sensor
        )
        for k, pitch in enumerate(np.deg2rad([0.2, 5.0]).tolist())
    ]


def calibrated(spoil=lambda acc, time_s: acc, sensor="body"):
    """Calibration of parked recordings in which accelerations of one sensor are changed."""
    parked = [
        changed(one, sensor, spoil(one.sensor(sensor).acc_mps2.copy(), one.time_s))
        for one in car_park()
    ]
    return calibrate_mount(parked, PARKED_POSES_RAD, SUZUKI_ET4D)


@pytest.mark.parametrize("level", [LPMS_CU2, REAL])
def test_a_sound_calibration_has_no_doubts(level):
    """Phones' uncalibrated sensors lead to turns of several deg; they are no fault."""
    found = calibrate_mount(car_park(sensor=level), PARKED_POSES_RAD, SUZUKI_ET4D)
    assert found.severe == () and found.warnings == ()


def test_a_turn_that_is_no_mounting_is_told():
    found = calibrated(lambda acc, _: acc[:, [2, 1, 0]])
    (told,) = found.severe
    assert "the body's IMU would be turned by 9" in told or "turned by 8" in told
    assert told in found.warnings


def test_poses_that_fit_no_mount_state_a_larger_standard_deviation():
    """A sign of the lever's accelerometer leaves a misfit of many deg; the sd grows with it."""
    sound, found = calibrated(), calibrated(lambda acc, _: acc * [-1, 1, 1], "lever")
    assert "the poses fit no mount" in found.severe[0]
    assert found.misfit_rad > 5 * sound.misfit_rad
    assert (found.sd_rad > 5 * sound.sd_rad).all()


def test_a_body_that_leans_in_one_pose_of_a_parked_recording_is_told():
    def shifted(acc, time_s):
        acc[time_s < 3, 1] += 1.0
        return acc

    found = calibrated(shifted)
    assert len(found.severe) == 2  # 1 m/s² across gravity is a lean of 5.8 deg
    assert "in pose 1 gravity lies 5.8 deg otherwise in the body's IMU" in found.severe[0]


def test_angles_that_no_control_has_are_refused():
    with pytest.raises(InputError, match=r"settings of the poses: an angle is .*e\+298, .*rad"):
        calibrate_mount(car_park(), np.array(PARKED_POSES_RAD) * 1e299, SUZUKI_ET4D)
    up = np.array([0.0, 0.0, 9.8])
    huge = [ParkedPose(up, 1e300 * up, *angles) for angles in PARKED_POSES_RAD]
    with pytest.raises(InputError, match="body_acc_mps2: a pose whose acceleration is too large"):
        mount_from_poses(huge, SUZUKI_ET4D)


def test_a_wrong_inclination_is_not_taken_for_exchanged_names():
    """Twice the true alpha: with names exchanged the sensors agree better, with alpha best."""
    wrong = ScooterGeometry.from_degrees(40.0, 9.0)
    (found,) = contradictions(ride(), wrong, mount()).faults
    assert found.code == "geometry" and 15 <= found.size <= 25
    assert "look at the inclinations in the geometry file" in found.sentence
    (found,) = contradictions(put.exchange(ride(), "lever", "body"), SUZUKI_ET4D, mount()).faults
    assert found.code == "exchanged" and "or the inclinations in the geometry" in found.sentence


def test_an_accelerometer_that_drifted_is_named_beside_a_turned_sensor():
    """On level ground, an offset is a turn: 40 mg across are 7 deg of steering."""
    lever = ride().sensor("lever").acc_mps2 + np.array([0.04 * 9.81, 0.0, 0.0])
    (found,) = contradictions(changed(ride(), "lever", lever), SUZUKI_ET4D, mount()).faults
    assert found.code == "turned"
    assert re.search(r"zero-g offsets changed by (3|4)\d mg look the same", found.sentence)


def test_a_pose_without_gravity_is_told():
    def off_for_seconds(acc, time_s):
        acc[(time_s > 7) & (time_s < 9), :] = 0
        return acc

    found = calibrated(off_for_seconds, "lever")
    assert re.search(r"in pose \d the lever's IMU reads .* m/s², where gravity is", found.severe[0])
    wrong = found.wrong_lengths[0]
    assert wrong.sentence == found.severe[0] and wrong.sensor == "lever"
    assert wrong.length_mps2 < 8
    assert f"in pose {wrong.pose + 1} the lever's" in found.severe[0]


@pytest.mark.parametrize("sensor", ["lever", "body"])
def test_a_calibration_and_a_ride_have_one_limit_of_gravitys_length(sensor):
    """Scales that real sensors have are no fault of a calibration either."""
    for factor, wrong in ((0.86, False), (1.14, False), (0.8, True), (1.25, True)):
        found = calibrated(lambda acc, _, factor=factor: factor * acc, sensor)
        assert any("where gravity is" in text for text in found.severe) == wrong
        parked = changed(car_park()[1], sensor, factor * car_park()[1].sensor(sensor).acc_mps2)
        assert bool(find_faults(parked, SUZUKI_ET4D)) == wrong


def test_exchanged_names_of_a_parked_recording_are_told():
    parked = put.exchange(car_park()[0], "lever", "body")
    with pytest.raises(InputError, match="have lever and body each other's names"):
        check_poses(parked, PARKED_POSES_RAD, SUZUKI_ET4D)
    with pytest.raises(InputError, match=r"expected 3, one per pose$"):
        check_poses(car_park()[0], PARKED_POSES_RAD[:3], SUZUKI_ET4D)


def test_what_marks_faults_checks_what_it_is_given():
    found = estimate_ride(ride(), SUZUKI_ET4D)
    other = find_faults(put.late(ride(51).trim(0, 10), "lever", 0.3), SUZUKI_ET4D)
    for bad, words in (
        (other, "flags of a fault"),
        (["frozen"], r"faults\[0\]: got str, expected Fault"),
        (None, "faults: got NoneType"),
        (other[0], "faults: got Fault"),
    ):
        with pytest.raises(InputError, match=words):
            mark_faults(found, bad)


def test_a_mount_that_is_known_worse_than_fusion_assumes_is_told():
    """Sizes after a calibration are never wider than without one; a larger sd is said, then."""
    rotations = mount().rotation_lever_imu_to_lever, mount().rotation_body_imu_to_body
    for sd_deg, told in ((0.5, False), (0.9, False), (10.0, True)):
        known = ScooterMount(*rotations, np.full(6, np.deg2rad(sd_deg)))
        found = estimate_ride(ride(), SUZUKI_ET4D, known, FUSION)
        assert any("states 10.0 deg (median)" in text for text in found.warnings) == told


def test_a_clock_in_another_unit_is_told():
    """With times of half their size the filter has to bend the sensors; sound ones it need not."""
    words = "the filter can follow the readings only if"
    for factor, told in ((0.5, True), (1.0, False)):
        again = Recording(ride().time_s * factor, ride().sensors, source="r.csv")
        found = estimate_ride(again, SUZUKI_ET4D, mount(), FUSION)
        assert any(words in text for text in found.warnings) == told


@pytest.mark.parametrize(
    ("sensor", "half", "factor"),
    [("body", "acc", 9.81), ("lever", "acc", 1 / 9.81), ("lever", "gyr", 1 / 57.3)],
)
def test_a_part_in_another_unit_is_told_alone_with_its_cost(sensor, half, factor):
    """The body's accelerometer moved the steering by 28 deg, and nothing was told."""
    part = (ride().time_s > 6) & (ride().time_s < 12)
    wrong = rescaled(ride(), sensor, half, part, factor)
    (found,) = find_faults(wrong, SUZUKI_ET4D, mount(), FUSION)
    assert (found.code, found.sensor) == ("unit", f"{sensor}_{half}")
    assert np.isclose(found.first_s, 6.0, atol=0.05) and np.isclose(found.size, 6.0, atol=0.05)
    moved = moved_deg(estimate_ride(wrong, SUZUKI_ET4D, mount(), FUSION), unspoilt(FUSION))
    assert np.allclose([cost.largest for cost in found.costs], moved, rtol=0.1, atol=0.5)
