"""Scooter, forces: what an accelerometer cannot say, and a sensor that slips."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rides import FUSION, mount, ride, slow, unspoilt
from scipy import ndimage
from scipy.spatial.transform import Rotation

from mobility_imu.faults import with_half
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.health import examine
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.scooter.fault_cases import ride_of
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    RideSettings,
    ScooterGeometry,
    estimate_ride,
    find_faults,
    mark_faults,
    slips,
)
from mobility_imu.scooter.contradictions import AT_ODDS, rearranged
from mobility_imu.scooter.faults import _unless_shared
from mobility_imu.scooter.force import (
    LARGEST_SCALE,
    forceless,
    held_samples,
    is_wrong_length,
    wrong_length,
)
from mobility_imu.scooter.ride import usable_samples
from mobility_imu.scooter.sensor_pair import SensorPair
from mobility_imu.scooter.slips import ENDS, steps_of
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import draw_scooter, simulate_parked
from mobility_imu.simulation.sensor import REAL

CLOSED = RideSettings()
METHODS = pytest.mark.parametrize("settings", [FUSION, CLOSED], ids=["fusion", "closed"])
SENSORS = pytest.mark.parametrize("sensor", ["lever", "body"])


def judged(recording, settings):
    """Faults of a ride, and its angles once they are marked."""
    found = find_faults(recording, SUZUKI_ET4D, mount(), settings)
    return found, mark_faults(estimate_ride(recording, SUZUKI_ET4D, mount(), settings), found)


def errors_deg(marked, sound):
    """Largest change of an angle in what is valid, whole turns among it."""
    apart = np.abs(
        [marked.steering_rad - sound.steering_rad, marked.throttle_rad - sound.throttle_rad]
    )
    return np.rad2deg(apart[:, marked.valid].max(initial=0.0))


def dead(recording, sensor, where):
    """Accelerometer that gives noise alone."""
    values = np.array(recording.sensor(sensor).acc_mps2)
    values[where] = np.random.default_rng(1).normal(0, 0.01, values[where].shape)
    return with_half(recording, sensor, "acc", values)


def frozen(recording, sensor, where):
    values = np.array(recording.sensor(sensor).acc_mps2)
    values[where] = values[np.argmax(where)]
    return with_half(recording, sensor, "acc", values)


def when(place, length_s=3.0):
    time_s = ride().time_s
    first = {"begin": 0.0, "middle": 8.0, "end": time_s[-1] - length_s + 0.005}[place]
    return (time_s >= first) & (time_s < first + length_s)


@METHODS
@SENSORS
@pytest.mark.parametrize("place", ["begin", "middle", "end"])
def test_an_accelerometer_without_gravity_is_told_and_nothing_else(place, sensor, settings):
    lost = when(place)
    found, marked = judged(dead(ride(), sensor, lost), settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("no gravity", f"{sensor}_acc")]
    assert found[0].size == pytest.approx(3.0, abs=0.02)
    assert not marked.valid[lost].any()
    sound = unspoilt(settings)
    if settings == CLOSED:
        assert errors_deg(marked, sound) < 1  # a median reaches no further than is marked
    else:
        # Of normal errors one in 16,000 is beyond four standard deviations.
        apart = np.abs(marked.steering_rad - sound.steering_rad) / marked.steering_sd_rad
        assert apart[marked.valid].max(initial=0.0) < 4


def test_the_estimate_itself_does_not_trust_what_feels_no_gravity():
    lost = when("begin")
    found = estimate_ride(dead(ride(), "lever", lost), SUZUKI_ET4D, mount(), FUSION)
    assert not found.valid[lost].any()
    assert (np.abs(found.throttle_rad[found.valid]) < 1.5 * np.pi).all()
    assert any("lever_acc is weightless in 300 samples" in text for text in found.warnings)


def test_a_blow_is_no_loss_of_gravity():
    acc = np.array(ride().sensor("body").acc_mps2)
    acc[500:514] = 0.0
    assert not forceless(acc, 100.0).any()
    assert not forceless(ride().sensor("lever").acc_mps2, 100.0).any()


@METHODS
@SENSORS
@pytest.mark.parametrize("factor", [4.0, slow(2.0), slow(1.5), 1.25])
def test_an_accelerometer_in_another_range_is_told(factor, sensor, settings):
    found, marked = judged(put.scale(ride(), sensor, "acc", factor), settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("scale", f"{sensor}_acc")]
    assert found[0].size == pytest.approx(factor, rel=0.03)
    assert not marked.valid.any()
    (warning,) = [text for text in marked.warnings if "_acc" in text]
    assert f"{sensor}_acc is out of scale" in warning
    assert not any("accelerated" in text for text in marked.warnings)
    if settings == CLOSED:
        assert "takes it for an acceleration, and no sample is valid" in found[0].told


def test_the_limits_leave_room_for_every_length_that_sensors_have_read():
    path = Path(__file__).parents[2] / "data" / "reference" / "real_sensors.csv"
    table = pd.read_csv(path)
    lengths = table.loc[table["quantity"] == "length of the acceleration", "value"]
    assert (lengths.min().round(2), lengths.max().round(1)) == (8.45, 11.2)
    # As the comment of LARGEST_SCALE has them; 3 % is the scale error of data sheets.
    limits = STANDARD_GRAVITY_MPS2 / LARGEST_SCALE, STANDARD_GRAVITY_MPS2 * LARGEST_SCALE
    assert limits == pytest.approx((8.2, 11.8), abs=0.05)
    assert limits[0] < 0.97 * lengths.min() and 1.03 * lengths.max() < limits[1]
    assert not any(is_wrong_length(length) for length in lengths)


@pytest.mark.parametrize("factor", [0.87, 1.0, 1.1])
def test_lengths_that_sensors_of_others_read_are_right(factor):
    assert wrong_length(factor * ride().sensor("lever").acc_mps2, 100.0) is None


def swung(fastest_degps, arm_m, middle_deg=0.0):
    """Lever on a parked scooter that swings by 90 deg to both sides, for 20 s; its throttle, rad.

    Sound sensors without mounting errors; the lever's is at a distance above the hinge.
    """
    time_s, rng, none = np.arange(2000) / 100, np.random.default_rng(4), np.zeros(2000)
    swing_radps = np.deg2rad(fastest_degps) / (np.pi / 2)
    swing = np.pi / 2 * np.sin(swing_radps * time_s)
    throttle = swing + np.deg2rad(middle_deg)
    rate = np.pi / 2 * swing_radps * np.cos(swing_radps * time_s)
    gravity = STANDARD_GRAVITY_MPS2
    along = -gravity * np.sin(throttle) - arm_m * swing_radps**2 * swing
    up = gravity * np.cos(throttle) - arm_m * rate**2
    series = {
        "lever": ([none, along, up], [-rate, none, none]),
        "body": ([none, none, none + gravity], [none, none, none]),
    }
    sensors = {
        name: Imu(*(np.transpose(half) + rng.normal(0, 0.01, (2000, 3)) for half in halves))
        for name, halves in series.items()
    }
    return Recording(time_s, sensors), throttle


SWINGS = pytest.mark.parametrize(("fastest_degps", "arm_m"), [(240, 0.0), (450, 0.0), (450, 0.05)])


@SWINGS
def test_a_turn_does_not_shorten_gravity(fastest_degps, arm_m):
    """Means over half a second of these swings are 8 to 23 % too short."""
    acc = swung(fastest_degps, arm_m)[0].sensor("lever").acc_mps2
    mean = np.linalg.norm(ndimage.uniform_filter1d(acc, 50, axis=0), axis=1)
    assert np.median(mean) < 0.93 * STANDARD_GRAVITY_MPS2
    assert wrong_length(acc, 100.0) is None


@SWINGS
@pytest.mark.parametrize("factor", [0.6, 0.7, 2.0])
def test_a_scale_is_found_in_a_fast_turn(fastest_degps, arm_m, factor):
    """Too small by 7 % on an arm of 5 cm, where the turn adds up to 3 m/s²; too large to within
    what the turn shortens."""
    length = wrong_length(factor * swung(fastest_degps, arm_m)[0].sensor("lever").acc_mps2, 100.0)
    told = length / (factor * STANDARD_GRAVITY_MPS2)
    assert (1 < told < 1.08) if factor < 1 and arm_m else (0.75 < told < 1.01)
    assert factor > 1 or arm_m or told == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize(("settings", "arm_m"), [(FUSION, 0.05), (CLOSED, 0.0)])
def test_a_lever_that_turns_fast_is_valid(settings, arm_m):
    """The closed form has no lever arm."""
    recording, throttle = swung(450, arm_m)
    found = estimate_ride(recording, ScooterGeometry(np.deg2rad(20), 0.0), None, settings)
    # Nothing moves but the lever: the fusion is not sure of the steering, and says so.
    assert {remark.code for remark in found.remarks} <= {"uncertain"} and found.valid.mean() > 0.98
    apart_deg = np.rad2deg(found.throttle_rad - throttle)[found.valid]
    assert np.sqrt(np.mean(apart_deg**2)) < 2  # 24 deg is what two samples' delay would be


@METHODS
def test_a_lever_that_turns_fast_is_not_mounted_wrongly(settings):
    """Means of half a second are too short for angles, and the lever never is at zero for long."""
    recording, _ = swung(450, 0.0, middle_deg=60.0)
    assert find_faults(recording, ScooterGeometry(np.deg2rad(20), 0.0), None, settings) == ()


def slipped(recording, sensor, axis, angle_deg, at_s):
    turn = Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
    later, imu = recording.time_s >= at_s, recording.sensor(sensor)
    halves = [
        np.where(later[:, None], values @ turn.T, values)
        for values in (imu.acc_mps2, imu.gyr_radps)
    ]
    return Recording(
        recording.time_s, {**recording.sensors, sensor: Imu(*halves)}, source="slipped.csv"
    )


@METHODS
@pytest.mark.parametrize(
    ("sensor", "axis", "angle_deg", "at_s"),
    [
        ("body", "y", 40, 10.2),
        slow("body", "y", 40, 5.0),
        ("lever", "x", 15, 10.2),
        ("lever", "y", 40, 10.2),
        slow("lever", "y", 15, 10.2),
        slow("body", "x", 15, 10.2),
        ("body", "y", 15, 10.2),
    ],
)
def test_a_sensor_that_slips_during_the_ride(sensor, axis, angle_deg, at_s, settings):
    found, marked = judged(slipped(ride(), sensor, axis, angle_deg, at_s), settings)
    assert [fault.code for fault in found] == ["slipped"]
    assert "do not agree before and after" in found[0].told
    assert not marked.valid.any()


def test_a_step_is_found_where_it_is():
    time_s = np.arange(200) / 10
    values = 0.1 * time_s + 2.0 * (time_s >= 7.0)
    step = steps_of(values + np.random.default_rng(2).normal(0, 0.3, 200), time_s)
    # By its size, place and noise 0.76, with a standard deviation of 0.015.
    assert step.time_s == pytest.approx(7.0, abs=0.2) and step.size == pytest.approx(2.0, abs=0.2)
    assert step.explained > 0.7
    short = steps_of(values[:10], time_s[:10])
    assert (short.size, short.explained) == (0, 0) and np.isnan(short.time_s)


@pytest.mark.parametrize("at", [0.05, ENDS, 0.3, 0.5])
def test_a_line_hides_most_of_a_step_at_an_end(at):
    """What a line leaves of a step after a part of the points; the origin of ``ENDS``."""

    def left(part):
        place = (np.arange(2000) + 0.5) / 2000
        step = (place >= part).astype(float)
        return float(np.mean((step - np.polyval(np.polyfit(place, step, 1), place)) ** 2))

    inside = at * (1 - at)
    assert left(at) == pytest.approx(inside * (1 - 3 * inside), rel=1e-2)
    assert (left(at) >= 0.99 * left(0.5)) == (at >= ENDS)


@pytest.mark.parametrize(("split_s", "agree"), [(14.0, True), (19.0, False), (4.0, False)])
def test_only_parts_that_are_long_and_show_gravity_speak_against_a_slip(split_s, agree):
    """Upside down from 14 s on: that part alone is no ride, and with it nothing agrees."""
    pair = SensorPair(slipped(ride(), "lever", "x", 180, 14.0), SUZUKI_ET4D, mount())
    assert slips._parts_agree(pair, split_s, AT_ODDS) == agree


SIGNS = {"x": (-1, 1, 1), "y": (1, -1, 1)}


@METHODS
@SENSORS
@pytest.mark.parametrize("axis", SIGNS)
def test_an_axis_of_an_accelerometer_with_the_wrong_sign(axis, sensor, settings):
    """The gyroscope is not blamed, and the closed form is not believed."""
    found, marked = judged(put.scale(ride(), sensor, "acc", SIGNS[axis]), settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("reversed", f"{sensor}_acc")]
    assert f"axis {axis} of the accelerometer has the wrong sign" in found[0].sentence
    assert not marked.valid.any()


@METHODS
@pytest.mark.parametrize(
    ("sensor", "axes"), [("lever", (0, 2, 1)), ("lever", (1, 0, 2)), ("body", (1, 0, 2))]
)
def test_axes_of_an_accelerometer_that_are_exchanged(sensor, axes, settings):
    found, marked = judged(rearranged(ride(), sensor, axes, (1, 1, 1)), settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("swapped", f"{sensor}_acc")]
    assert not marked.valid.any()


def test_a_lag_that_is_longer_than_any_that_is_looked_for():
    """It cannot be measured, and the closed form mixes two times."""
    found, marked = judged(put.late(ride(), "lever", 3.0), CLOSED)
    assert found[0].code == "at odds" and "slipped" not in [fault.code for fault in found]
    assert found[0].told.endswith("the angles are not valid") and not marked.valid.any()


def held(recording, sensor, half, every, count):
    """Readings of which some are given again."""
    values = recording.sensor(sensor).acc_mps2 if half == "acc" else recording.gyroscope(sensor)
    place = np.arange(len(values))
    fresh = np.where(place % every < count, place - place % every, place)
    return with_half(recording, sensor, half, values[fresh])


@METHODS
def test_readings_that_are_given_again_are_told_as_such(settings):
    """A quarter of the readings: too short each for a frozen sensor."""
    faulty = held(ride(), "lever", "acc", 50, 15)
    found, marked = judged(faulty, settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("held", "lever_acc")]
    assert found[0].size == pytest.approx(0.14, abs=0.01)
    sound = unspoilt(settings)
    if settings == CLOSED:
        assert errors_deg(marked, sound) < 1
    else:
        apart = np.abs(marked.steering_rad - sound.steering_rad) / marked.steering_sd_rad
        assert apart[marked.valid].max(initial=0.0) < 4


@METHODS
def test_a_slow_sensor_in_a_fast_table_is_not_at_the_end_of_its_range(settings):
    slow = held(held(ride(), "lever", "acc", 10, 10), "lever", "gyr", 10, 10)
    found, marked = judged(slow, settings)
    codes = [(fault.code, fault.sensor) for fault in found]
    assert codes == [("held", "lever_acc"), ("held", "lever_gyr")]
    assert not any("saturated" in text for text in marked.warnings)


def test_one_axis_that_jumps_shows_held_readings_of_a_coarse_sensor():
    """Steps explain what repeats itself and goes on a step away, on all axes."""
    place = np.arange(2000)
    coarse = 0.1 * np.random.default_rng(8).normal(0, 0.5, (2000, 3)).round()
    coarse[:, 2] += 9.8
    kept = coarse[np.where(place % 50 < 15, place - place % 50, place)]
    assert not held_samples(kept, 100.0).any()
    coarse[:, 1] += (place + 45) % 100 < 50  # moves on by 1 m/s² while a reading is kept
    kept = coarse[np.where(place % 50 < 15, place - place % 50, place)]
    expected = (place % 50 > 0) & (place % 50 < 15)
    assert (held_samples(kept, 100.0) == expected).mean() > 0.98


def test_coarse_sensors_at_rest_hold_nothing():
    parked = simulate_parked(pitch_rad=0.0, bank_rad=0.0, seed=5, unit=draw_scooter(3), sensor=REAL)
    for sensor in parked.sensors.values():
        assert not held_samples(sensor.acc_mps2, 100.0).any()
        assert not held_samples(np.repeat(sensor.gyr_radps, 2, axis=0), 200.0).any()


@pytest.mark.parametrize("seed", [7, 23])
def test_a_level_parked_body_has_no_axes_to_exchange(seed):
    parked = simulate_parked(
        pitch_rad=0.0, bank_rad=0.0, seed=seed, unit=draw_scooter(seed), sensor=REAL
    )
    assert "swapped" not in [fault.code for fault in find_faults(parked, SUZUKI_ET4D)]


@METHODS
@pytest.mark.parametrize(
    ("how", "behind"),
    [
        (lambda r: put.late(r, "lever", 0.4), ("lag", "lever")),
        (lambda r: put.reverse(r, "lever"), ("reversed", "lever_gyr")),
        (lambda r: put.exchange(r, "lever", "body"), ("exchanged", "lever, body")),
        (lambda r: put.offset(r, "lever", "gyr", (0, 0, 0.5)), ("offset", "lever_gyr")),
    ],
)
def test_what_is_behind_a_scale_is_told_as_well(how, behind, settings):
    """A scale loses nothing: without it both sensors can be held against each other."""
    found, marked = judged(how(put.scale(ride(), "body", "acc", 1.5)), settings)
    codes = [(fault.code, fault.sensor) for fault in found]
    scaled = "lever_acc" if behind[0] == "exchanged" else "body_acc"
    assert behind in codes and ("scale", scaled) in codes
    assert not {"at odds", "slipped", "turned"} & {code for code, _ in codes}
    assert not marked.valid.any()


@SENSORS
@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_a_pose_that_is_held_hides_no_scale(factor, sensor):
    """Axis x of the lever rests at its largest value; none is cut, and nothing is shortened."""
    parked = simulate_parked(
        pitch_rad=np.deg2rad(5), bank_rad=0.0, seed=703, unit=draw_scooter(701), sensor=REAL
    )
    found = find_faults(put.scale(parked, sensor, "acc", factor), SUZUKI_ET4D)
    assert [(fault.code, fault.sensor) for fault in found] == [("scale", f"{sensor}_acc")]


@METHODS
@SENSORS
def test_a_cut_axis_is_no_scale(sensor, settings):
    found, _ = judged(put.clip(ride(), sensor, "acc", 7.0), settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("range", f"{sensor}_acc")]


def turned_until(recording, sensor, axis, angle_deg, until_s):
    back = slipped(recording, sensor, axis, -angle_deg, until_s)
    rotation = Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
    return put.turn(back, sensor, rotation)


@pytest.mark.parametrize(
    ("sensor", "axis", "angle_deg"),
    [("lever", "x", 60), ("lever", "y", 60), ("body", "x", 50), ("body", "y", 50)],
)
def test_a_sensor_that_is_turned_only_at_the_beginning_slipped(sensor, axis, angle_deg):
    """Most accelerations fit angles: it is not said that they do not."""
    found, marked = judged(turned_until(ride(), sensor, axis, angle_deg, 4.0), FUSION)
    assert [fault.code for fault in found] == ["slipped"]
    assert "do not agree before and after" in found[0].told and not marked.valid.any()


def dead_together(where):
    return dead(dead(ride(), "lever", where), "body", where)


def frozen_together(where):
    return frozen(frozen(ride(), "lever", where), "body", where)


def silent_together(where):
    recording = ride()
    for sensor in ("lever", "body"):
        rates = np.where(where[:, None], 0, recording.gyroscope(sensor))
        recording = with_half(recording, sensor, "gyr", rates)
    return recording


@pytest.mark.parametrize(
    ("how", "code", "half", "settings"),
    [
        (dead_together, "no gravity", "acc", FUSION),
        (dead_together, "no gravity", "acc", CLOSED),
        (frozen_together, "frozen", "acc", FUSION),
        (frozen_together, "frozen", "acc", CLOSED),
        (silent_together, "frozen", "gyr", FUSION),
    ],
)
def test_what_both_sensors_lose_at_once_comes_back_from_neither(how, code, half, settings):
    """A price would be that of one lost reading in the place of another one.

    The filter learns from all samples; the closed form looks at each by itself.
    """
    lost = when("middle")
    found, marked = judged(how(lost), settings)
    told = {fault.sensor: fault for fault in found if fault.code == code}
    assert set(told) == {f"lever_{half}", f"body_{half}"}
    for fault in told.values():
        assert fault.repair is None and fault.costs == ()
        assert fault.sentence.endswith("the angles are not valid") == (settings == FUSION)
    assert not marked.valid[lost].any()
    # The closed form loses these three seconds of 20, and half a median on either side.
    assert (marked.valid.mean() > 0.75) == (settings == CLOSED)


def test_phones_that_rest_together_lost_nothing():
    """Both repeat themselves in coarse steps, and go on a step away: each undoes the other."""
    coarse = ride_of(5, 300).recording
    found = [fault for fault in examine(coarse) if fault.code == "frozen"]
    assert [fault.sensor for fault in found] == ["lever_acc", "body_acc"]
    assert find_faults(coarse, SUZUKI_ET4D, None, FUSION) == ()
    at_once = [found[0], replace(found[1], flags=found[0].flags)]
    assert all(fault.repair for fault in _unless_shared(at_once, coarse))
    acc = np.array(coarse.sensor("body").acc_mps2)
    acc[np.flatnonzero(found[0].flags)[-1] + 1 :] += 0.5
    moved = _unless_shared(at_once, with_half(coarse, "body", "acc", acc))
    assert [fault.repair is None for fault in moved] == [False, True]


def test_what_both_lose_one_after_the_other_comes_back():
    faulty = dead(dead(ride(), "lever", when("middle")), "body", when("end"))
    found, _ = judged(faulty, FUSION)
    dead_ones = [fault for fault in found if fault.code == "no gravity"]
    assert [bool(fault.costs) for fault in dead_ones] == [True, True]


def zero(recording, sensor, where):
    values = np.where(where[:, None], 0.0, recording.sensor(sensor).acc_mps2)
    return with_half(recording, sensor, "acc", values)


@METHODS
@SENSORS
@pytest.mark.parametrize("place", ["middle", "end"])
def test_zeros_are_told_once(place, sensor, settings):
    lost = when(place)
    found, marked = judged(zero(ride(), sensor, lost), settings)
    assert [(fault.code, fault.sensor) for fault in found] == [("no gravity", f"{sensor}_acc")]
    assert not marked.valid[lost].any()
    (text,) = [text for text in marked.warnings if f"{sensor}_acc" in text]
    assert f"{sensor}_acc is weightless in " in text


@METHODS
def test_zeros_and_a_frozen_sensor_are_told_once_each(settings):
    faulty = put.freeze(zero(ride(), "lever", when("middle")), "lever", "acc", 3.0, 3.0)
    found, marked = judged(faulty, settings)
    codes = [(fault.code, fault.sensor) for fault in found]
    assert codes == [("frozen", "lever_acc"), ("no gravity", "lever_acc")]
    assert [fault.size for fault in found] == pytest.approx([3.0, 3.0], abs=0.03)
    assert len([text for text in marked.warnings if "lever_acc" in text]) == 2


@SENSORS
@pytest.mark.parametrize("how", [dead, zero, frozen])
@pytest.mark.parametrize("place", ["begin", "middle", "end"])
def test_the_closed_form_does_not_trust_a_median_that_reaches_into_a_loss(place, how, sensor):
    """By itself, without what finds faults."""
    lost = when(place)
    found = estimate_ride(how(ride(), sensor, lost), SUZUKI_ET4D, mount(), CLOSED)
    assert not found.valid[ndimage.binary_dilation(lost, iterations=12)].any()
    assert errors_deg(found, unspoilt(CLOSED)) == 0


def test_the_closed_form_trusts_what_is_beside_a_rest_in_coarse_steps():
    """A phone that stands repeats itself; what goes on until the recording ends may be a loss."""
    coarse = ride_of(5, 300).recording
    usable, _ = usable_samples(coarse, ["lever", "body"])
    with_median, _ = usable_samples(coarse, ["lever", "body"], 12)
    assert 0.9 < usable.mean() < 1 and (usable == with_median).all()
    ended = coarse.trim(coarse.time_s[0], coarse.time_s[2620])
    usable, _ = usable_samples(ended, ["lever", "body"])
    with_median, _ = usable_samples(ended, ["lever", "body"], 12)
    assert np.flatnonzero(usable & ~with_median).tolist() == list(range(2581, 2593))
