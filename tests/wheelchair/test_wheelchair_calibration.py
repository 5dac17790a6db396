"""Wheelchair: realignment of the sensors (equations 1.1 to 1.15), and trials that do not serve."""

import math
import re

import numpy as np
import pytest
from chairs import (
    BOTH_WAYS,
    CHAIRS,
    EXACT,
    ROUNDING,
    calibrated,
    directions,
    is_rotation,
    rotations,
    trials,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.wheelchair import (
    IDEAL,
    LIKE_SAMPLE,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    Leg,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    VelocitySettings,
    calibrate_mount,
    estimate_velocity,
)
from mobility_imu.wheelchair.calibration import (
    _axle,
    _longest_way,
    _straightest,
    alignment_matrix,
    axle_direction,
    frame_alignment_angles,
    realign,
    wheel_alignment_angles,
)
from mobility_imu.wheelchair.velocity import (
    wheel_spin_rate,
)


@given(st.floats(-4, 4), st.floats(-4, 4))
def test_alignment_matrix_is_the_printed_one(gamma, epsilon):
    c, s, ce, se = math.cos(gamma), math.sin(gamma), math.cos(epsilon), math.sin(epsilon)
    printed = [[c, s * se, s * ce], [0, ce, -se], [-s, c * se, c * ce]]  # 1.5, 1.11
    about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])  # 1.4
    about_x = np.array([[1, 0, 0], [0, ce, -se], [0, se, ce]])
    ours = alignment_matrix(gamma, epsilon)
    assert ours == pytest.approx(np.array(printed), abs=ROUNDING)
    assert ours == pytest.approx(about_y @ about_x, abs=ROUNDING)  # 1.3
    assert is_rotation(ours)


@given(directions, st.floats(0.01, 50))
def test_any_mounting_form_turns_z_onto_the_axle(direction, rate):
    matrix = alignment_matrix(*wheel_alignment_angles(rate * direction))
    assert is_rotation(matrix)
    assert matrix[:, 2] == pytest.approx(direction, abs=ROUNDING)


@given(directions.filter(lambda u: abs(u[2]) > 1e-3))
def test_printed_form_keeps_z_in_the_sensors_own_hemisphere(direction):
    matrix = alignment_matrix(*wheel_alignment_angles(direction, form="printed"))
    assert is_rotation(matrix)
    # tan and atan of an angle whose cosine is 1e-3 or more: three digits of sixteen are lost
    assert matrix[:, 2] == pytest.approx(math.copysign(1, direction[2]) * direction, abs=1e-10)


@given(directions, st.lists(directions, min_size=1, max_size=4))
def test_realigned_vectors_are_the_same_vectors_in_other_axes(direction, measured):
    to_imu = alignment_matrix(*wheel_alignment_angles(direction))
    aligned = realign(measured, to_imu)  # 1.1, 1.10
    assert aligned @ to_imu.T == pytest.approx(np.array(measured), abs=ROUNDING)  # 1.2
    assert aligned[:, 2] == pytest.approx(np.array(measured) @ direction, abs=ROUNDING)


@given(rotations)
def test_frame_z_points_up_however_the_sensor_is_mounted(imu_to_chair):
    up_imu = imu_to_chair.T @ [0, 0, 1]
    resting = STANDARD_GRAVITY_MPS2 * up_imu  # specific force: upward
    to_imu = alignment_matrix(*frame_alignment_angles(resting))
    assert realign(resting, to_imu) == pytest.approx([0, 0, STANDARD_GRAVITY_MPS2], abs=1e-11)


def test_printed_frame_form_turns_a_sensor_mounted_upside_down_on_its_head():
    resting = [0.5, -0.3, -9.8]
    for form, z in (("corrected", 1), ("printed", -1)):
        aligned = realign(resting, alignment_matrix(*frame_alignment_angles(resting, form=form)))
        assert aligned / np.linalg.norm(resting) == pytest.approx([0, 0, z], abs=ROUNDING)


def test_printed_resting_acceleration_of_minus_z_is_half_a_turn_wrong_with_atan2():
    # 1.12 asks for P z = -acc: an atan2 solution of it points z into the floor.
    resting = np.array([0.5, -0.3, 9.8])
    to_imu = alignment_matrix(*frame_alignment_angles(-resting))
    assert realign(resting, to_imu)[2] == pytest.approx(-np.linalg.norm(resting))


@pytest.mark.parametrize("angles", [wheel_alignment_angles, frame_alignment_angles])
def test_vectors_without_a_solution_are_refused(angles):
    with pytest.raises(InputError, match="zero vector"):
        angles([0, 0, 0])
    with pytest.raises(InputError, match="z = 0"):
        angles([1, 1, 0], form="printed")
    with pytest.raises(InputError, match="form"):
        angles([1, 1, 1], form="atan")
    with pytest.raises(InputError, match="zero vector"):
        angles([math.nan, 0, 1])


@given(directions, st.integers(0, 1000))
def test_axle_is_found_through_noise_and_points_along_the_forward_spin(direction, seed):
    rng = np.random.default_rng(seed)
    spin = np.r_[np.zeros(50), 4 + np.sin(np.arange(200) / 20), np.full(10, -1.0)]
    gyr = spin[:, None] * direction + 0.01 * rng.standard_normal((260, 3))
    found, off_axle = axle_direction(gyr)
    # 0.01 rad/s of noise over 200 samples at 4 rad/s turn the axle by 2e-4 rad (1 sd)
    assert found @ direction > math.cos(1e-3)
    # two axes of noise against the spin's root mean square, 3.5
    assert 0.003 < off_axle < 0.006


@settings(deadline=None, max_examples=15)
@given(rotations, rotations, rotations)
def test_turning_the_sensors_in_their_mounts_changes_nothing(frame, left, right):
    geometry = CHAIRS[2]
    drives = trials(geometry, 6, legs=BOTH_WAYS[:4], noise=LIKE_SAMPLE)
    turns = {"frame": frame, "left_wheel": left, "right_wheel": right}

    def turned(drive):
        sensors = {
            name: Imu(imu.acc_mps2 @ turns[name].T, imu.gyr_radps @ turns[name].T)
            for name, imu in drive.recording.sensors.items()
        }
        return Recording(drive.recording.time_s, sensors)

    static, straight, drive = drives
    one = estimate_velocity(drive.recording, geometry, calibrated(static, straight).mount)
    other = estimate_velocity(
        turned(drive), geometry, calibrate_mount(turned(static), turned(straight)).mount
    )
    assert other.linear_velocity_mps == pytest.approx(one.linear_velocity_mps, abs=EXACT)
    assert other.yaw_rate_radps == pytest.approx(one.yaw_rate_radps, abs=EXACT)
    assert other.wheel_yaw_rate_radps == pytest.approx(one.wheel_yaw_rate_radps, abs=EXACT)


def test_calibration_finds_the_mounting_it_was_simulated_with():
    mounting = random_mounting(8)
    static, straight, _ = trials(SAMPLE_CHAIR, 8, mounting=mounting)
    found = calibrated(static, straight)
    frame = mounting["frame"].rotation_body_to_imu.T
    assert found.mount.rotation_frame_imu_to_chair == pytest.approx(frame, abs=EXACT)
    for side in ("left", "right"):
        axle = mounting[f"{side}_wheel"].rotation_body_to_imu[:, 2]
        assert found.mount.rotation_imu_to_wheel(side)[2] == pytest.approx(axle, abs=EXACT)
    assert max(found.off_axle_share) < EXACT


def test_calibration_holds_through_noise_like_the_samples():
    truth = random_mounting(9)
    static, straight, _ = trials(SAMPLE_CHAIR, 9, noise=LIKE_SAMPLE, mounting=truth)
    found = calibrated(static, straight).mount.rotation_frame_imu_to_chair
    wanted = truth["frame"].rotation_body_to_imu.T
    # up: a bias of 0.02 m/s^2 on each axis is 2 mrad of tilt (1 sd)
    assert math.acos(min(found[2] @ wanted[2], 1)) < 3.5 * 0.02 * math.sqrt(2) / 9.8
    # forward: as large, and the noise of a push's acceleration on top
    assert math.acos(min(found[0] @ wanted[0], 1)) < 0.03


@pytest.mark.parametrize(
    ("static_legs", "straight_legs", "message"),
    [
        ((Leg(4, 3.0, 0.0, 30.0),), STRAIGHT_TRIAL, r"frame turns at 0\.52 rad/s"),
        (STATIC_TRIAL, STATIC_TRIAL, r"left wheel turns 0\.00 rad"),
        (STATIC_TRIAL, (Leg(1, 1.0), Leg(2, 1.0, 0.8), Leg(1, 1.0)), r"turns 2\.\d+ rad"),
        (STATIC_TRIAL, (Leg(1, 1.0), Leg(6, 4.0, 1.0, 50.0), Leg(1, 1.0)), "chair turned"),
        (STATIC_TRIAL, (Leg(1, 1.0), Leg(6, 9.0, 1.5, 9.0), Leg(1, 1.0)), r"heading changes by 8"),
        (STATIC_TRIAL, (Leg(2, 5.0, 1.0),), r"rate changes by 0\.00 rad/s"),
    ],
)
def test_trials_that_cannot_calibrate_are_refused_with_the_number(
    static_legs, straight_legs, message
):
    still, line = (
        simulate_drive(
            legs, SAMPLE_CHAIR, random_mounting(0), seed=0, noise=IDEAL, push_share=0.0
        ).recording
        for legs in (static_legs, straight_legs)
    )
    with pytest.raises(InputError, match=message):
        calibrate_mount(still, line)


def moved(static, straight, *names):
    """A static trial with some sensors of a chair that moves."""
    count = min(len(static), len(straight))
    sensors = {}
    for name in static.sensors:
        imu = (straight if name in names else static).sensors[name]
        sensors[name] = Imu(imu.acc_mps2[:count], imu.gyr_radps[:count])
    return Recording(static.time_s[:count], sensors, source="static")


ROLLS = (Leg(1, 1.0), Leg(2, 8.0, 1.0))


@pytest.mark.parametrize("noise", [IDEAL, LIKE_SAMPLE])
def test_a_static_trial_whose_wheels_roll_is_refused_with_their_rate(noise):
    static, straight, _ = trials(SAMPLE_CHAIR, 8, noise=noise)
    rolling = trials(SAMPLE_CHAIR, 8, ROLLS, noise)[2].recording
    with pytest.raises(InputError, match=r"left wheel turns at 2\.98 rad/s .*the chair rolls; cut"):
        calibrate_mount(rolling, straight.recording)
    # Wheels that roll beside a frame at rest, as on a lift or on rollers.
    names = ("left_wheel", "right_wheel")
    with pytest.raises(InputError, match="the chair rolls"):
        calibrate_mount(moved(static.recording, rolling, *names), straight.recording)


def test_wheels_that_only_shake_in_the_static_trial_do_not_roll():
    """A hand on the rims, or a motor beside the chair: fast, and about no axle."""
    static, straight, _ = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)
    rng, trial = np.random.default_rng(911_200), static.recording
    shaken = {
        name: Imu(
            imu.acc_mps2 + rng.normal(0, 1.5, (len(trial), 3)),
            imu.gyr_radps + rng.normal(0, 0.15, (len(trial), 3)),
        )
        for name, imu in trial.sensors.items()
        if name != "frame"
    }
    still = Recording(trial.time_s, trial.sensors | shaken, source="static")
    told = calibrate_mount(still, straight.recording).warnings
    assert not any("static trial" in text for text in told)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_wheel_that_is_turned_by_hand_in_the_static_trial_is_told(side):
    static, straight, _ = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)
    rolling = trials(SAMPLE_CHAIR, 8, ROLLS, LIKE_SAMPLE)[2].recording
    one = moved(static.recording, rolling, f"{side}_wheel")
    (text,) = [t for t in calibrate_mount(one, straight.recording).warnings if "static trial" in t]
    assert f"static: the {side} wheel turns at " in text and "cut the trial" in text


def test_a_frame_that_is_carried_in_the_static_trial_is_told():
    static, straight, _ = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)
    carried = static.recording
    imu = carried.sensors["frame"]
    lift = 2 * np.sin(4 * np.pi * carried.time_s)[:, None] * imu.acc_mps2.mean(axis=0) / 9.81
    sensors = carried.sensors | {"frame": Imu(imu.acc_mps2 + lift, imu.gyr_radps)}
    told = calibrate_mount(Recording(carried.time_s, sensors), straight.recording).warnings
    assert any("carried, tipped or pushed; cut the trial" in text for text in told)


@pytest.mark.parametrize("side", ["left", "right"])
def test_offsets_of_the_wheels_are_no_motion_in_the_static_trial(side):
    """They read like a turn of 0.2 rad/s, and gravity stays."""
    static, straight, _ = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)
    imu = static.recording.sensors[f"{side}_wheel"]
    sensors = static.recording.sensors | {
        f"{side}_wheel": Imu(imu.acc_mps2, imu.gyr_radps + np.array([0.2, 0, 0]))
    }
    shifted = Recording(static.recording.time_s, sensors)
    assert not calibrate_mount(shifted, straight.recording, take_off_offsets=False).warnings


def test_missing_sensor_or_gyroscope_is_named():
    static, straight, drive = trials(SAMPLE_CHAIR, 0)
    calibration = calibrated(static, straight)
    sensors = dict(drive.recording.sensors)
    without = Recording(drive.recording.time_s, {k: v for k, v in sensors.items() if k != "frame"})
    with pytest.raises(InputError, match=r"no sensor 'frame'.*left_wheel, right_wheel"):
        estimate_velocity(without, SAMPLE_CHAIR, calibration.mount)
    blind = Recording(drive.recording.time_s, sensors | {"frame": Imu(sensors["frame"].acc_mps2)})
    with pytest.raises(InputError, match="'frame' has no gyroscope"):
        estimate_velocity(blind, SAMPLE_CHAIR, calibration.mount)
    with pytest.raises(InputError, match="form = 'minus'"):
        estimate_velocity(
            drive.recording, SAMPLE_CHAIR, calibration.mount, VelocitySettings(form="minus")
        )
    with pytest.raises(InputError, match="side = 'middle'"):
        wheel_spin_rate([1.0], [0.0], 0.3, side="middle")


@pytest.mark.parametrize(
    ("gyr", "message"),
    [
        (np.zeros((50, 3)), "turns by 0 rad"),
        (np.r_[np.ones((9, 3)), -np.ones((9, 3))], "turns by 0 rad"),
        (np.full((9, 3), np.nan), "not a finite number at row 0"),
        (np.zeros((0, 3)), "turns by 0 rad"),
        (np.zeros(3), "expected shape"),
        ([["a", "b", "c"]], "expected real numbers"),
    ],
)
def test_an_axle_needs_a_wheel_that_turns_forward(gyr, message):
    with pytest.raises(InputError, match=message):
        axle_direction(gyr)


def test_realign_takes_rotations_only():
    with pytest.raises(InputError, match="rotation_aligned_to_imu: a mirror"):
        realign(np.ones((2, 3)), np.diag([1.0, 1, -1]))


def drive(legs, seed=8):
    return trials(SAMPLE_CHAIR, seed, legs, noise=LIKE_SAMPLE)[2].recording


@pytest.mark.parametrize(("turning_s", "works"), [(2.0, True), (30.0, False)])
def test_a_trial_that_turns_gives_its_straightest_part_if_that_is_long(turning_s, works):
    """4.8 m of straight line, then a circle: 1.6 m of it are fine, 27 m are too much."""
    static = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)[0].recording
    legs = (Leg(1, 2.0), Leg(2, 4.0, 1.2), Leg(6, turning_s, 1.0, 60.0), Leg(1, 1.0))
    if works:
        found = calibrate_mount(static, drive(legs))
        begin, end = re.search(r"part is used, (.*) to (.*) s", found.warnings[0]).groups()
        assert float(begin) < 2.1 and 5.9 < float(end) < 8.5
    else:
        with pytest.raises(InputError, match=r"heading changes by|the chair turned"):
            calibrate_mount(static, drive(legs))


def test_what_the_frame_turns_by_is_no_loose_sensor():
    """The wheel's axle swings by 20 deg/s with the frame, or the sensor alone does."""
    _, straight, _ = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)
    recording = straight.recording
    gyr, up = recording.gyroscope("left_wheel"), np.array([0.0, 0.0, 1.0])
    axle, _ = axle_direction(gyr)
    across = np.cross(axle, [0.3, 0.5, 0.8])
    across /= np.linalg.norm(across)
    fast = np.abs(gyr @ axle) > 1.0
    wobble = 0.35 * np.abs(gyr @ axle).max() * np.sin(9 * recording.time_s) * fast
    sensors = dict(recording.sensors)
    sensors["left_wheel"] = Imu(sensors["left_wheel"].acc_mps2, gyr + np.outer(wobble, across))
    loose = Recording(recording.time_s, sensors, source="loose")
    with pytest.raises(InputError, match="the chair turned, or the sensor is loose"):
        _axle(loose, "left", up)
    frame = recording.gyroscope("frame")
    sensors["frame"] = Imu(sensors["frame"].acc_mps2, frame + np.outer(wobble, up))
    with_frame = Recording(recording.time_s, sensors, source="rough")
    direction, fraction = _axle(with_frame, "left", up)
    assert fraction > 0.2 and direction @ axle > 0.999


@given(st.integers(0, 10**6), st.integers(1, 25))
@settings(deadline=None, max_examples=60)
def test_the_longest_way_on_one_heading_is_that_of_all_pairs(seed, count):
    rng = np.random.default_rng(seed)
    heading = np.cumsum(rng.standard_normal(count))
    way = np.cumsum(rng.uniform(0.1, 1, count))
    pairs = [
        (first, last)
        for first in range(count)
        for last in range(first, count)
        if np.ptp(heading[first : last + 1]) <= 2.0
    ]
    first, last = _longest_way(heading, way, 2.0)
    assert way[last] - way[first] == pytest.approx(max(way[k] - way[j] for j, k in pairs))
    assert (first, last) in pairs


@pytest.mark.parametrize(
    ("straight_s", "swing", "works"), [(4.0, 1.5, True), (4.0, 0.0, False), (0.5, 1.5, False)]
)
def test_the_straightest_part_has_to_be_long_and_to_change_its_speed(straight_s, swing, works):
    """Two bends with a straight line between them; each condition by itself refuses the trial."""
    count, bend = round(100 * straight_s), np.full(300, 1.0)
    up = np.array([0.0, 0.0, 1.0])
    yaw = np.r_[bend, np.zeros(count), -bend]
    # The wheels' rate swings along the straight line alone.
    rate = 4.0 + np.r_[0 * bend, swing * np.sin(np.linspace(0, 2 * np.pi, count)), 0 * bend]
    acc = np.tile(STANDARD_GRAVITY_MPS2 * up, (len(yaw), 1))
    sensors = {"frame": Imu(acc, np.outer(yaw, up)), "left_wheel": Imu(acc, np.outer(rate, up))}
    trial = Recording(np.arange(len(yaw)) / 100, sensors)
    part, refusal, notes = _straightest(trial, up, ["left"])
    assert bool(notes) == works and bool(refusal) != works
    if works:
        assert straight_s < part.time_s[-1] - part.time_s[0] < straight_s + 2 * np.deg2rad(46)
        assert "only its straightest part is used" in notes[0]


def test_offsets_at_rest_are_found_and_taken_off():
    """Of both trials: each rests for a second or more at its beginning."""
    static, straight, _ = trials(SAMPLE_CHAIR, 8)
    offset = np.deg2rad([1.0, -2.0, 1.5])
    shifted = [
        Recording(
            run.recording.time_s,
            {k: Imu(v.acc_mps2, v.gyr_radps + offset) for k, v in run.recording.sensors.items()},
        )
        for run in (static, straight)
    ]
    plain, found = calibrated(static, straight), calibrate_mount(*shifted)
    assert set(found.offsets) == {"frame", "left_wheel", "right_wheel"}
    for each in found.offsets.values():
        assert each.offset_radps == pytest.approx(offset, abs=1e-9)
    as_they_are = calibrate_mount(*shifted, take_off_offsets=False)
    assert not as_they_are.offsets
    for side in ("left", "right"):
        axle = plain.mount.rotation_imu_to_wheel(side)[2]
        assert found.mount.rotation_imu_to_wheel(side)[2] == pytest.approx(axle, abs=1e-9)
        assert as_they_are.mount.rotation_imu_to_wheel(side)[2] @ axle < 1 - 1e-6
