"""Scooter, contradictions: what is told of two sensors, all of it, and nothing that is not so."""

import numpy as np
import pytest
from rides import FUSION, mount, moved_deg, ride, slow, turned, unspoilt
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    ScooterMount,
    estimate_ride,
    find_faults,
)
from mobility_imu.scooter.agreement import Seen
from mobility_imu.scooter.contradictions import LARGEST_SCALE, contradictions
from mobility_imu.scooter.machine import zeros_of
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import COURSES


def codes(recording, mounted=None):
    """Kinds of faults that both sensors show together, in order."""
    return [fault.code for fault in contradictions(recording, SUZUKI_ET4D, mounted).faults]


@pytest.mark.parametrize("sensor", ["lever", "body"])
@pytest.mark.parametrize("lag_s", [0.2, slow(0.6), slow(1.0), 1.5])
@pytest.mark.parametrize("calibrated", [True, False])
def test_a_lag_is_all_that_is_told_of_a_late_sensor(sensor, lag_s, calibrated):
    """What is beside it is judged without it: nothing is at odds, and nothing is turned."""
    mounted = mount() if calibrated else None
    (found,) = contradictions(put.late(ride(), sensor, lag_s), SUZUKI_ET4D, mounted).faults
    assert (found.code, found.sensor) == ("lag", sensor)
    assert found.size == pytest.approx(lag_s, abs=0.01)


@pytest.mark.parametrize(
    ("code", "how"),
    [
        ("offset", lambda r: put.offset(r, "body", "gyr", (0, 0, 0.5))),
        ("turned", lambda r: turned(r, "lever", "x", 8)),
    ],
)
def test_what_is_behind_a_lag_is_told_as_well(code, how):
    assert codes(how(put.late(ride(), "lever", 0.3)), mount()) == ["lag", code]


def in_other_axes(recording, mounted):
    """The same ride by sensors that lie quite otherwise in their boxes, and its mount."""
    turns = {
        name: Rotation.from_rotvec(vector).as_matrix()
        for name, vector in (("lever", [0.9, -1.4, 0.6]), ("body", [-1.1, 0.5, 1.8]))
    }
    for name, rotation in turns.items():
        recording = put.turn(recording, name, rotation)
    return recording, ScooterMount(
        mounted.rotation_lever_imu_to_lever @ turns["lever"].T,
        mounted.rotation_body_imu_to_body @ turns["body"].T,
        mounted.sd_rad,
    )


TURNS = {
    "lever": lambda r: turned(r, "lever", "y", 4),
    "throttle": lambda r: turned(r, "body", "x", 6),
    "vertical": lambda r: turned(r, "body", "z", 15),
    "vertical and throttle": lambda r: turned(turned(r, "body", "z", 15), "lever", "x", 6),
    "fell over": lambda r: turned(r, "body", "x", 60),
}


@pytest.mark.parametrize(
    "name", ["lever", "vertical and throttle", "fell over", slow("throttle"), slow("vertical")]
)
def test_a_turn_costs_the_same_whatever_the_sensors_axes_are(name):
    """The repair turns in the axes of the mount: seed 52 has shaking that shows the vertical."""
    faulty = TURNS[name](ride(52))
    (found,) = find_faults(faulty, SUZUKI_ET4D, mount(52), FUSION)
    other, mounted = in_other_axes(faulty, mount(52))
    (again,) = find_faults(other, SUZUKI_ET4D, mounted, FUSION)
    assert found.code == again.code == "turned"
    assert again.size == pytest.approx(found.size, rel=0.01)
    for cost, same in zip(found.costs, again.costs, strict=True):
        assert same.largest == pytest.approx(cost.largest, rel=0.05, abs=0.1)
    real = moved_deg(
        estimate_ride(faulty, SUZUKI_ET4D, mount(52), FUSION),
        unspoilt(FUSION, 52),
    )
    assert max(real) / 2 < max(cost.largest for cost in found.costs) < 2 * max(real)


def test_two_turns_are_both_named_and_both_undone():
    faulty = TURNS["vertical and throttle"](ride(52))
    (found,) = contradictions(faulty, SUZUKI_ET4D, mount(52)).faults
    assert "the throttle is" in found.sentence and "about the vertical" in found.sentence
    assert "zero-g" not in found.sentence  # no offset turns a sensor about the vertical
    assert contradictions(found.repair(faulty), SUZUKI_ET4D, mount(52)).faults == ()


def test_who_has_no_mount_is_not_asked_since_when():
    (found,) = contradictions(turned(ride(), "lever", "x", 20), SUZUKI_ET4D, None).faults
    assert found.code == "turned" and "calibrate the mount" in found.sentence
    assert "since the calibration" not in found.sentence
    (found,) = contradictions(turned(ride(), "lever", "x", 8), SUZUKI_ET4D, mount()).faults
    assert "was one turned since the calibration?" in found.sentence
    assert "zero-g" not in found.sentence  # 140 mg are more than two sensors' offsets


@pytest.mark.parametrize("sensor", ["lever", "body"])
@pytest.mark.parametrize("factor", [1 / 57.3, slow(0.1), slow(1 / 4.05), 4.05])
def test_a_scale_is_measured_from_a_mistaken_unit_on(sensor, factor):
    (found,) = contradictions(put.scale(ride(), sensor, "gyr", factor), SUZUKI_ET4D, None).faults
    assert (found.code, found.sensor) == ("scale", f"{sensor}_gyr")
    assert found.size == pytest.approx(factor, rel=0.06)


def test_a_scale_at_the_limit_is_not_told_as_measured():
    faulty = put.scale(ride(), "lever", "gyr", 0.8 / LARGEST_SCALE)
    (found,) = contradictions(faulty, SUZUKI_ET4D, None).faults
    assert "reads 1/100 or less of what" in found.sentence
    slow = put.scale(ride(51, "straight"), "body", "gyr", 1.2 * LARGEST_SCALE)
    (found,) = contradictions(slow, SUZUKI_ET4D, None).faults
    assert "reads 100 times or more what" in found.sentence


def test_rates_that_no_sensor_reads_are_no_recording():
    """So that there are none whose rests cannot be looked for."""
    with pytest.raises(InputError, match="this looks like deg/s"):
        put.scale(ride(), "lever", "gyr", 57.3)


@pytest.mark.parametrize("sensor", ["lever", "body"])
def test_a_gyroscope_of_noise_alone_is_not_an_exchange(sensor):
    noise = 1e-3 * np.random.default_rng(3).standard_normal((len(ride()), 3))
    sensors = dict(ride().sensors)
    sensors[sensor] = Imu(sensors[sensor].acc_mps2, noise)
    assert codes(Recording(ride().time_s, sensors, source="noise.csv")) == ["at odds"]


@pytest.mark.parametrize("course", COURSES)
def test_an_exchange_is_all_that_is_told_of_it(course):
    assert codes(put.exchange(ride(51, course), "lever", "body")) == ["exchanged"]


def test_what_is_too_short_says_nothing_of_both():
    found = contradictions(put.late(ride(), "lever", 0.3).trim(5, 9.5), SUZUKI_ET4D, None)
    assert found.faults == () and not found.signs_tested
    assert contradictions(ride(), SUZUKI_ET4D, None).signs_tested


def zero_of(steering, yaw):
    """Steering, deg, at which a scooter that turns so does not turn."""
    up = np.tile([0.0, 0.0, 9.81], (len(yaw), 1))
    turning = np.column_stack([0 * yaw, 0 * yaw, yaw])
    seen = Seen(steering, 0 * yaw, np.ones(len(yaw), bool))
    return np.rad2deg(zeros_of(seen, up, turning, turning, RATE_HZ).steering_rad)


RATE_HZ, ZERO = 50.0, np.deg2rad(3.0)
YAW = 0.8 * np.clip(1.5 * np.sin(np.arange(3000) / RATE_HZ / 4), -1, 1)


@pytest.mark.parametrize("beside_m", [-0.22, 0.22])
def test_the_zero_of_the_steering_does_not_move_with_where_the_lever_sits(beside_m):
    """A lever beside the middle is pulled outwards, by r yaw² in curves to either side."""
    # eq. 5 near zero: a pull across moves the steering by its angle over the sine of 20 deg
    pulled = beside_m * YAW**2 / 9.81 / np.sin(np.deg2rad(20))
    found = zero_of(np.arctan(0.9 * YAW) + ZERO + pulled, YAW)
    assert found == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize(
    ("speed_mps", "drives"), [(3.5, False), (2.5, True), (0.32, True), (0.25, False)]
)
def test_only_a_scooter_at_the_speeds_of_one_shows_where_it_does_not_turn(speed_mps, drives):
    """With a wheelbase of 0.9 m at 0.3 to 3 m/s: two sensors in a hand turn otherwise."""
    yaw = 0.5 * YAW
    found = zero_of(np.arctan(0.9 / speed_mps * yaw) + ZERO, yaw)
    assert found == pytest.approx(3.0, abs=0.3) if drives else np.isnan(found)
