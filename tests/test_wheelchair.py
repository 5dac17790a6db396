"""Wheelchair: alignment, velocities, slip and tasks against geometry, a simulator and plain code.

The simulator shares only the chair's dimensions with the estimators, and its accelerometers are
checked here against the numerically differentiated path of the sensor.
"""

import json
import math
import re
import warnings
from dataclasses import replace
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_tasks import plain_tasks
from scipy import integrate
from scipy.spatial.transform import Rotation

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.plots.wheelchair import chronogram, draw_frames
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.wheelchair.facing import facing_mounting
from mobility_imu.reproduction.wheelchair.printed import (
    gyroscope_outward,
    printed_angles,
    sign_choices,
    spin_printed,
    velocity_printed,
    wheel_rates_printed,
    yaw_rate_printed,
)
from mobility_imu.reproduction.wheelchair.sample import open_combinations, yaw_gain
from mobility_imu.simulation.wheelchair import (
    COURT,
    IDEAL,
    LIKE_SAMPLE,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    Leg,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    Task,
    TaskSettings,
    WheelchairGeometry,
    calibrate,
    estimate_velocity,
    identify_tasks,
    tasks,
)
from mobility_imu.wheelchair.calibration import (
    alignment_matrix,
    axle_direction,
    frame_alignment_angles,
    realign,
    wheel_alignment_angles,
)
from mobility_imu.wheelchair.geometry import side_sign
from mobility_imu.wheelchair.slip import SlipSettings, SlipWindows, correct_slip, detect_slip
from mobility_imu.wheelchair.tasks import (
    Symbols,
    curvature_radius,
    find_pattern,
    read_settings,
    reduce_variability,
    refine_edges,
    task_steps,
    window_means,
)
from mobility_imu.wheelchair.velocity import (
    linear_velocity,
    printed_yaw_gain,
    wheel_spin_rate,
    wheel_spin_rate_printed,
    wheel_yaw_rate,
)

# A few roundings of numbers of size 1 to 10.
ROUNDING = 1e-12
# The same after some dozen operations per sample, with speeds and rates of size 1 to 10.
EXACT = 1e-9

SAMPLE_CHAIR = WheelchairGeometry.from_degrees(
    19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
)
# Turns to both sides, on the spot and rolling, forward and backward.
BOTH_WAYS = (
    Leg(1, 1.0),
    Leg(2, 1.0, 1.4),
    Leg(6, 1.5, 1.2, 70.0),
    Leg(6, 1.5, 1.1, -80.0),
    Leg(3, 1.0, -0.8),
    Leg(4, 1.5, 0.0, 150.0),
    Leg(4, 1.5, 0.0, -150.0),
    Leg(1, 1.0),
)

directions = (
    st.tuples(*[st.floats(-1, 1)] * 3)
    .map(np.array)
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: v / np.linalg.norm(v))
)
rotations = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(rng=seed).as_matrix())


def is_rotation(matrix):
    return np.abs(matrix @ matrix.T - np.eye(3)).max() < ROUNDING and np.linalg.det(matrix) > 0


# Geometry


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("camber_deg", [0, 3, 19, 24])
def test_wheel_touches_the_floor_half_a_track_beside_the_middle(side, camber_deg):
    chair = WheelchairGeometry.from_degrees(
        camber_deg, wheel_radius_left_m=0.31, wheel_radius_right_m=0.33, track_m=0.8
    )
    axle, centre = chair.axle_direction(side), chair.wheel_centre(side)
    assert abs(np.linalg.norm(axle) - 1) < ROUNDING
    down_the_wheel = np.cross(axle, [1, 0, 0])  # in the wheel's plane, across the travel
    contact = centre + getattr(chair.wheel_radius_m, side) * down_the_wheel
    assert contact == pytest.approx([0, side_sign(side) * 0.4, 0], abs=ROUNDING)
    # forward roll: the point on the floor is at rest when the centre moves forward at r per rad
    assert np.cross(axle, contact - centre)[0] < 0
    # tops lean in
    assert abs(centre[1]) <= 0.4


def test_distance_of_the_wheel_centres_is_that_between_their_places():
    apart = SAMPLE_CHAIR.wheel_centre("left") - SAMPLE_CHAIR.wheel_centre("right")
    assert apart[1] == pytest.approx(SAMPLE_CHAIR.wheel_centre_distance_m, abs=ROUNDING)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"camber_rad": 19}, "camber_rad = 19.*camber in degrees"),
        ({"camber_rad": math.nan}, "camber_rad = nan"),
        ({"wheel_radius_left_m": 31.47}, "wheel_radius_left_m = 31.47.*cm"),
        ({"wheel_radius_right_m": 2.0}, "wheel_radius_right_m = 2.*circumference"),
        ({"wheel_radius_right_m": -0.3}, "wheel_radius_right_m = -0.3"),
        ({"track_m": 84}, "track_m = 84.*cm"),
        ({"track_m": 0.35}, "wheel centres"),
    ],
)
def test_impossible_chairs_are_refused_with_the_value_and_a_guess(change, message):
    with pytest.raises(InputError, match=message):
        replace(SAMPLE_CHAIR, **change)


def test_camber_given_in_radians_where_degrees_are_asked_is_refused():
    with pytest.raises(InputError, match="radians"):
        WheelchairGeometry.from_degrees(
            0.33, wheel_radius_left_m=0.3, wheel_radius_right_m=0.3, track_m=0.8
        )


def test_roll_out_length_gives_the_same_chair_as_the_radius():
    rolled = WheelchairGeometry.from_circumference(
        19,
        wheel_circumference_left_m=2 * math.pi * 0.3147,
        wheel_circumference_right_m=2 * math.pi * 0.3195,
        track_m=0.84,
    )
    for name in vars(rolled):
        assert getattr(rolled, name) == pytest.approx(getattr(SAMPLE_CHAIR, name), abs=ROUNDING)


def write_toml(folder, text):
    path = folder / "geometry.toml"
    path.write_text(text)
    return path


WHEELCHAIR_TOML = """[wheelchair]
camber_deg = 19.0
wheel_radius_left_m = 0.3147
wheel_radius_right_m = 0.3195
track_m = 0.84
"""


def test_geometry_file(tmp_path):
    path = write_toml(tmp_path, WHEELCHAIR_TOML + "[scooter]\nlever_inclination_deg = 9\n")
    assert WheelchairGeometry.from_toml(path) == SAMPLE_CHAIR


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WHEELCHAIR_TOML.replace("track_m = 0.84", ""), "track_m is missing"),
        (WHEELCHAIR_TOML.replace("track_m", "trak_m"), "trak_m is unknown"),
        (WHEELCHAIR_TOML.replace("0.84", '"0.84"'), "track_m = '0.84': expected a number"),
        (WHEELCHAIR_TOML.replace("0.84", "84"), r"\[wheelchair\].*track_m = 84"),
        (WHEELCHAIR_TOML.replace("0.84", "0,84"), "not valid TOML"),
        ("[scooter]\n", r"no section \[wheelchair\]"),
        ("", "empty"),
    ],
)
def test_bad_geometry_file_is_named_with_what_is_wrong(tmp_path, text, message):
    path = write_toml(tmp_path, text)
    with pytest.raises(InputError, match=message) as error:
        WheelchairGeometry.from_toml(path)
    assert str(path) in str(error.value)


# Realignment, equations 1.1 to 1.15


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
    for form, z in (("any mounting", 1), ("printed", -1)):
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


# Simulator


def trials(geometry, seed, legs=BOTH_WAYS, noise=IDEAL, sampling_rate_hz=100.0, mounting=None):
    mounting = mounting or random_mounting(seed)
    return tuple(
        simulate_drive(
            part, geometry, mounting, seed=seed + k, noise=noise, sampling_rate_hz=sampling_rate_hz
        )
        for k, part in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, legs))
    )


def calibrated(static, straight, _=None):
    return calibrate(static.recording, straight.recording)


CHAIRS = [
    WheelchairGeometry.from_degrees(
        camber, wheel_radius_left_m=left, wheel_radius_right_m=right, track_m=track
    )
    for camber, left, right, track in (
        (0, 0.30, 0.30, 0.60),
        (3, 0.305, 0.30, 0.62),
        (19, 0.3147, 0.3195, 0.84),
        (24, 0.33, 0.31, 0.95),
    )
]
chairs = pytest.mark.parametrize("chair", CHAIRS, ids=["0deg", "3deg", "19deg", "24deg"])


@pytest.mark.parametrize("sensor", ["frame", "left_wheel", "right_wheel"])
def test_simulated_sensors_are_the_derivatives_of_their_path_in_the_room(sensor):
    rate = 2000.0
    mounting = random_mounting(3)
    legs = (Leg(2, 1.0, 1.4), Leg(6, 1.0, 1.2, 120.0), Leg(4, 1.0, 0.0, -150.0))
    drive = simulate_drive(legs, SAMPLE_CHAIR, mounting, seed=0, noise=IDEAL, sampling_rate_hz=rate)
    time_s, v, w = drive.recording.time_s, drive.linear_velocity_mps, drive.yaw_rate_radps

    def sum_up(series):
        return integrate.cumulative_simpson(series, x=time_s, initial=0)

    heading = sum_up(w)
    room = np.column_stack(
        [sum_up(v * np.cos(heading)), sum_up(v * np.sin(heading)), np.zeros_like(v)]
    )
    chair_to_room = Rotation.from_rotvec(heading[:, None] * [0, 0, 1])
    if sensor == "frame":
        body_to_chair, origin = Rotation.identity(len(v)), np.zeros(3)
    else:
        side = sensor.removesuffix("_wheel")
        sign = {"left": 1, "right": -1}[side]
        radius = getattr(SAMPLE_CHAIR.wheel_radius_m, side)
        rolled = sum_up(v - sign * w * SAMPLE_CHAIR.track_m / 2) / radius
        # a wheel whose axle is z: laid on its side, leaned by the camber, then rolled
        lean = sign * SAMPLE_CHAIR.camber_rad
        upright = Rotation.from_euler("x", lean - math.pi / 2)
        body_to_chair = upright * Rotation.from_rotvec(rolled[:, None] * [0, 0, 1])
        origin = np.array(
            [
                0,
                sign * (SAMPLE_CHAIR.track_m / 2 - radius * math.sin(SAMPLE_CHAIR.camber_rad)),
                radius * math.cos(SAMPLE_CHAIR.camber_rad),
            ]
        )
    place, turn = mounting[sensor].position_m, mounting[sensor].rotation_body_to_imu
    path = room + chair_to_room.apply(origin + body_to_chair.apply(place))
    imu_to_room = chair_to_room * body_to_chair * Rotation.from_matrix(turn.T)
    acc = (path[2:] - 2 * path[1:-1] + path[:-2]) * rate**2
    force = imu_to_room[1:-1].inv().apply(acc + np.array([0, 0, STANDARD_GRAVITY_MPS2]))
    spun = (imu_to_room[:-2].inv() * imu_to_room[2:]).as_rotvec() * rate / 2
    made = drive.recording.sensor(sensor)
    # Central differences leave h^2/12 of the fourth derivative (0.05 m at 6 rad/s: 1e-6 m/s^2,
    # more where the motion changes) and rounding of 1e-16 / h^2 of some metres: 1e-8.
    assert made.acc_mps2[1:-1] == pytest.approx(force, abs=2e-4)
    assert made.gyr_radps[1:-1] == pytest.approx(spun, abs=2e-5)


def test_same_seed_gives_the_same_bytes_and_another_seed_others():
    first, again, other = (
        simulate_drive(
            STRAIGHT_TRIAL, SAMPLE_CHAIR, random_mounting(1), seed=seed, noise=LIKE_SAMPLE
        ).recording
        for seed in (5, 5, 6)
    )
    pd.testing.assert_frame_equal(first.to_frame(), again.to_frame(), check_exact=True)
    assert not np.array_equal(first.sensor("frame").acc_mps2, other.sensor("frame").acc_mps2)


def test_simulated_truth_rolls_where_its_speed_and_yaw_rate_say():
    drive = simulate_drive(BOTH_WAYS, SAMPLE_CHAIR, random_mounting(0), seed=0, push_share=0.0)
    duration = sum(leg.duration_s for leg in BOTH_WAYS)
    length = sum(leg.duration_s * leg.linear_velocity_mps for leg in BOTH_WAYS)
    turned = sum(leg.duration_s * leg.yaw_rate_degps for leg in BOTH_WAYS)
    truth = drive.truth()
    assert len(truth) == round(duration * 100)
    # minimum-jerk changes are odd about their middle, so the sums are exact but for the first
    # and last leg's half sample
    assert truth["linear_velocity_mps"].sum() / 100 == pytest.approx(length, abs=1e-6)
    assert truth["yaw_rate_degps"].sum() / 100 == pytest.approx(turned, abs=1e-4)


def test_leg_shorter_than_a_change_is_refused():
    with pytest.raises(InputError, match=r"0\.5 s"):
        simulate_drive([Leg(1, 1), Leg(2, 0.5, 1)], SAMPLE_CHAIR, random_mounting(0), seed=0)


# Velocities, equations 1.16 to 1.18


@chairs
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_ideal_sensors_give_the_driven_velocities_back(chair, seed):
    static, straight, drive = trials(chair, seed)
    found = estimate_velocity(drive.recording, calibrated(static, straight), chair)
    assert found.linear_velocity_mps == pytest.approx(drive.linear_velocity_mps, abs=EXACT)
    assert found.yaw_rate_radps == pytest.approx(drive.yaw_rate_radps, abs=EXACT)
    assert found.wheel_yaw_rate_radps == pytest.approx(drive.yaw_rate_radps, abs=EXACT)
    assert not found.slip.any()
    assert found.to_frame()["yaw_rate_degps"].to_numpy() == pytest.approx(
        np.rad2deg(drive.yaw_rate_radps), abs=np.rad2deg(EXACT)
    )


def axle_rates(drive, calibration):
    return {
        side: drive.recording.sensor(f"{side}_wheel").gyr_radps
        @ calibration.rotation_imu_to_wheel(side).T
        for side in ("left", "right")
    }


@chairs
def test_uncorrected_rates_pair_with_the_distance_of_the_wheel_centres(chair):
    static, straight, drive = trials(chair, seed=4)
    rates = axle_rates(drive, calibrated(static, straight))
    left, right = rates["left"][:, 2], rates["right"][:, 2]
    yaw = wheel_yaw_rate(left, right, chair, distance_m=chair.wheel_centre_distance_m)
    assert yaw == pytest.approx(drive.yaw_rate_radps, abs=EXACT)
    # ... and give the velocity midway between the centres, which lies beside the middle of the
    # contacts when the radii differ
    middle = (chair.wheel_centre("left") + chair.wheel_centre("right"))[1] / 2
    expected = drive.linear_velocity_mps - drive.yaw_rate_radps * middle
    assert linear_velocity(left, right, chair) == pytest.approx(expected, abs=EXACT)


@chairs
def test_mixed_pairs_are_wrong_by_the_ratio_of_the_two_distances(chair):
    static, straight, drive = trials(chair, seed=4)
    rates = axle_rates(drive, calibrated(static, straight))
    w = drive.yaw_rate_radps
    spins = [
        wheel_spin_rate(rates[side][:, 2], w, chair.camber_rad, side=side)
        for side in ("left", "right")
    ]
    ratio = chair.track_m / chair.wheel_centre_distance_m
    mixed = wheel_yaw_rate(*spins, chair, distance_m=chair.wheel_centre_distance_m)
    assert mixed == pytest.approx(ratio * w, abs=EXACT)


@chairs
def test_printed_camber_term_falsifies_the_wheels_yaw_rate_by_the_predicted_gain(chair):
    static, straight, drive = trials(chair, seed=5)
    printed = estimate_velocity(
        drive.recording, calibrated(static, straight), chair, camber="printed"
    )
    gain_left, gain_right = printed_yaw_gain(chair)
    w = drive.yaw_rate_radps
    assert printed.wheel_yaw_rate_radps == pytest.approx(
        np.where(w > 0, gain_left, gain_right) * w, abs=EXACT
    )
    # The frame's yaw rate does not pass through the wheels; the speed's two errors cancel but
    # for the difference of the radii.
    assert printed.yaw_rate_radps == pytest.approx(w, abs=EXACT)
    unlike = abs(np.diff(chair.wheel_radius_m)[0]) * math.sin(chair.camber_rad)
    error = printed.linear_velocity_mps - drive.linear_velocity_mps
    assert np.abs(error).max() <= unlike * np.abs(w).max() + EXACT


def test_printed_gain_of_the_samples_chair():
    assert printed_yaw_gain(SAMPLE_CHAIR) == pytest.approx((0.674, 1.326), abs=5e-4)
    flat = replace(SAMPLE_CHAIR, camber_rad=0.0)
    assert printed_yaw_gain(flat) == pytest.approx((1.0, 1.0), abs=ROUNDING)


@given(st.floats(-3, 3), st.floats(-20, 20), st.floats(0, 0.42))
def test_no_fixed_sign_of_the_root_serves_both_directions_of_turn(yaw, spin, camber):
    # What the gyro of a leaning wheel reads: its spin, and the yaw rate along its own axes.
    for side, s in (("left", 1), ("right", -1)):
        along = spin + s * yaw * math.sin(camber)
        across = yaw * math.cos(camber)
        exact = wheel_spin_rate([along], [yaw], camber, side=side)
        assert exact == pytest.approx(spin, abs=EXACT)
        printed = wheel_spin_rate_printed([[0, across, along]], camber, side=side)[0]
        # right in right turns, twice the share off in left turns, whatever the side
        wrong = 2 * s * max(yaw, 0) * math.sin(camber)
        assert printed - spin == pytest.approx(wrong, abs=EXACT)


# The print in the axes of its Figure 1


FACINGS = pytest.mark.parametrize(("facing", "sign"), [("outward", 1), ("inward", -1)])


def straight_at_1_mps(mounting):
    legs = (Leg(1, 1.0), Leg(2, 5.0, 1.0), Leg(1, 1.0))
    return simulate_drive(legs, SAMPLE_CHAIR, mounting, seed=0, noise=IDEAL, push_share=0.0)


@FACINGS
@pytest.mark.parametrize("seed", range(5))
def test_a_sensor_that_faces_outward_turns_positively_on_the_left_wheel_only(facing, sign, seed):
    # Rolling forward carries the top of a wheel forward: a rotation about the chair's left.
    line = straight_at_1_mps(facing_mounting(facing, seed))
    for side, s in (("left", 1), ("right", -1)):
        rate = line.recording.sensor(f"{side}_wheel").gyr_radps[300]
        along_z = rate[2] / np.linalg.norm(rate)
        assert along_z * s * sign > math.cos(0.51)  # tilted by 0.5 rad at most


def test_sensors_that_face_outward_get_the_axle_of_figure_1_and_inward_ones_the_opposite():
    outcome = {}
    for facing in ("outward", "inward"):
        printed, by_atan2 = [], []
        for seed in range(1000):
            mounting = facing_mounting(facing, seed)
            for side, s in (("left", 1), ("right", -1)):
                forward = mounting[f"{side}_wheel"].rotation_body_to_imu[:, 2]
                outward = s * forward
                rate = 4.0 * forward  # what the gyroscope reads in a forward push
                printed.append(alignment_matrix(*printed_angles(rate))[:, 2] @ outward)
                by_atan2.append(alignment_matrix(*wheel_alignment_angles(rate))[:, 2] @ forward)
        # tan and atan of angles up to 0.5 rad: a few roundings
        assert np.abs(printed) == pytest.approx(np.ones(2000), abs=EXACT)
        assert by_atan2 == pytest.approx(np.ones(2000), abs=EXACT)
        outcome[facing] = set(np.sign(printed))
    assert outcome == {"outward": {1.0}, "inward": {-1.0}}


@FACINGS
def test_printed_minus_of_the_velocity_is_right_for_sensors_that_face_outward(facing, sign):
    mounting = facing_mounting(facing, 3)
    line = straight_at_1_mps(mounting)
    rates = wheel_rates_printed(line.recording, line.recording)
    left, right = rates.left[:, 2], rates.right[:, 2]
    printed = velocity_printed(left, right, SAMPLE_CHAIR)
    assert printed == pytest.approx(sign * line.linear_velocity_mps, abs=EXACT)
    assert printed[300] == pytest.approx(sign * 1.0, abs=EXACT)
    # With a plus the wheels would cancel, and so would axles that are positive forward on both
    # sides with the printed minus: the inverse tangents and the minus belong together.
    assert linear_velocity(left, right, SAMPLE_CHAIR) == pytest.approx(0 * printed, abs=EXACT)
    still = simulate_drive(STATIC_TRIAL, SAMPLE_CHAIR, mounting, seed=0, noise=IDEAL)
    forward = axle_rates(line, calibrate(still.recording, line.recording))
    cancelled = velocity_printed(forward["left"][:, 2], forward["right"][:, 2], SAMPLE_CHAIR)
    assert cancelled == pytest.approx(0 * printed, abs=EXACT)


@FACINGS
def test_printed_sum_of_the_yaw_rate_is_positive_to_the_right_with_outward_axles(facing, sign):
    mounting = facing_mounting(facing, 4)
    line = straight_at_1_mps(mounting)
    turn = simulate_drive(BOTH_WAYS, SAMPLE_CHAIR, mounting, seed=0, noise=IDEAL)
    rates = wheel_rates_printed(line.recording, turn.recording)
    # Without the camber term; the rates along the axles go with the distance of the centres.
    printed = yaw_rate_printed(
        rates.left[:, 2],
        rates.right[:, 2],
        SAMPLE_CHAIR,
        distance_m=SAMPLE_CHAIR.wheel_centre_distance_m,
    )
    assert printed == pytest.approx(-sign * turn.yaw_rate_radps, abs=EXACT)


@given(st.floats(-3, 3), st.floats(-20, 20))
def test_printed_root_is_exact_with_the_sign_that_fits_the_turn(yaw, velocity):
    for side, s in (("left", 1), ("right", -1)):
        spin = s * (velocity - s * yaw * SAMPLE_CHAIR.track_m / 2)
        spin /= getattr(SAMPLE_CHAIR.wheel_radius_m, side)
        gyroscope = gyroscope_outward(velocity, yaw, SAMPLE_CHAIR, side)
        found = spin_printed(gyroscope, SAMPLE_CHAIR, -1 if yaw > 0 else 1)
        assert found == pytest.approx(spin, abs=EXACT)


def test_every_fixed_choice_of_signs_fails_in_one_turn_or_in_the_velocity():
    choices = sign_choices(SAMPLE_CHAIR)
    assert len(choices) == 8
    for choice in choices:
        yaw_error = max(abs(choice.yaw_left - 1), abs(choice.yaw_right - 1))
        velocity_error = max(abs(choice.velocity_left), abs(choice.velocity_right))
        # a third of the yaw rate, or a tenth of a metre per second for each rad/s
        assert yaw_error > 0.2 or velocity_error > 0.1
        # Opposite signs cancel in (1.18), but for the radii; like signs in (1.17).
        opposite = choice.sign_left != choice.sign_right
        assert (yaw_error < 0.01) == (opposite and choice.distance == "centres")
        assert (velocity_error < 0.01) == (not opposite)
    # The two choices of like signs mirror each other.
    both_plus, both_minus = (
        c for c in choices if c.sign_left == c.sign_right and c.distance == "centres"
    )
    gains = printed_yaw_gain(SAMPLE_CHAIR)
    assert (both_plus.yaw_left, both_plus.yaw_right) == pytest.approx(gains, abs=EXACT)
    assert (both_minus.yaw_right, both_minus.yaw_left) == pytest.approx(gains, abs=EXACT)


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
    one = estimate_velocity(drive.recording, calibrated(static, straight), geometry)
    other = estimate_velocity(turned(drive), calibrate(turned(static), turned(straight)), geometry)
    assert other.linear_velocity_mps == pytest.approx(one.linear_velocity_mps, abs=EXACT)
    assert other.yaw_rate_radps == pytest.approx(one.yaw_rate_radps, abs=EXACT)
    assert other.wheel_yaw_rate_radps == pytest.approx(one.wheel_yaw_rate_radps, abs=EXACT)


def test_calibration_finds_the_mounting_it_was_simulated_with():
    mounting = random_mounting(8)
    static, straight, _ = trials(SAMPLE_CHAIR, 8, mounting=mounting)
    found = calibrated(static, straight)
    frame = mounting["frame"].rotation_body_to_imu.T
    assert found.rotation_frame_imu_to_chair == pytest.approx(frame, abs=EXACT)
    for side in ("left", "right"):
        axle = mounting[f"{side}_wheel"].rotation_body_to_imu[:, 2]
        assert found.rotation_imu_to_wheel(side)[2] == pytest.approx(axle, abs=EXACT)
    assert max(found.off_axle_share) < EXACT


def test_calibration_holds_through_noise_like_the_samples():
    truth = random_mounting(9)
    static, straight, _ = trials(SAMPLE_CHAIR, 9, noise=LIKE_SAMPLE, mounting=truth)
    found = calibrated(static, straight).rotation_frame_imu_to_chair
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
        calibrate(still, line)


def test_missing_sensor_or_gyroscope_is_named():
    static, straight, drive = trials(SAMPLE_CHAIR, 0)
    calibration = calibrated(static, straight)
    sensors = dict(drive.recording.sensors)
    without = Recording(drive.recording.time_s, {k: v for k, v in sensors.items() if k != "frame"})
    with pytest.raises(InputError, match=r"no sensor 'frame'.*left_wheel, right_wheel"):
        estimate_velocity(without, calibration, SAMPLE_CHAIR)
    blind = Recording(drive.recording.time_s, sensors | {"frame": Imu(sensors["frame"].acc_mps2)})
    with pytest.raises(InputError, match="'frame' has no gyroscope"):
        estimate_velocity(blind, calibration, SAMPLE_CHAIR)
    with pytest.raises(InputError, match="camber = 'minus'"):
        estimate_velocity(drive.recording, calibration, SAMPLE_CHAIR, camber="minus")
    with pytest.raises(InputError, match="side = 'middle'"):
        wheel_spin_rate([1.0], [0.0], 0.3, side="middle")


# Slip


def series(count, *stretches):
    """Zeros with ones in [first, last]."""
    values = np.zeros(count)
    for first, last in stretches:
        values[first : last + 1] = 1.0
    return values


@pytest.mark.parametrize(
    ("rate", "stretches", "windows"),
    [
        (100, [], []),
        (100, [(20, 20)], [(20, 20)]),
        # last to first: 9 frames apart merge, 10 (0.10 s) do not
        (100, [(20, 25), (34, 40)], [(20, 40)]),
        (100, [(20, 25), (35, 40)], [(20, 25), (35, 40)]),
        (100, [(20, 25), (34, 40), (49, 50)], [(20, 50)]),
        (50, [(20, 25), (29, 40)], [(20, 40)]),
        (50, [(20, 25), (30, 40)], [(20, 25), (30, 40)]),
        (100, [(0, 3), (97, 99)], [(0, 3), (97, 99)]),
        (100, [(0, 99)], [(0, 99)]),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_slip_windows_and_their_merging(rate, stretches, windows, sign):
    apart = series(100, *stretches)
    found = detect_slip(np.full(100, 0.4), 0.4 + sign * apart, rate)
    assert list(zip(found.first, found.last, strict=True)) == windows
    flags = found.flags(100)
    assert flags.tolist() == series(100, *windows).astype(bool).tolist()


def test_a_difference_at_the_threshold_is_no_slip():
    assert len(detect_slip([0.0, 0.0], [0.2, -0.2], 100).first) == 0
    assert len(detect_slip([0.0, 0.0], [np.nextafter(0.2, 1), 0.0], 100).first) == 1


@pytest.mark.parametrize(("length", "replaced"), [(6, False), (7, True)])
def test_only_windows_longer_than_60_ms_are_corrected(length, replaced):
    windows = SlipWindows(np.array([50]), np.array([50 + length - 1]))
    velocity = np.r_[np.ones(50), np.full(length, 5.0), np.ones(143 - length)]
    corrected = correct_slip(velocity, np.zeros(193), windows, 100)
    inside = corrected[50 : 50 + length]
    assert np.allclose(inside, 1.0 if replaced else 5.0, atol=EXACT)
    assert np.array_equal(np.delete(corrected, np.s_[50 : 50 + length]), np.ones(193 - length))


def slipping_drive(noise):
    """A drive, and the same one with the left wheel spinning freely for half a second, twice."""
    static, straight, drive = trials(SAMPLE_CHAIR, 11, legs=COURT[:4], noise=noise)
    calibration = calibrated(static, straight)
    extra = np.zeros(len(drive.recording))
    for first in (350, 1000):
        extra[first : first + 50] = 6.0 * np.sin(np.pi * np.arange(50) / 50) ** 2
    imu = drive.recording.sensor("left_wheel")
    axle = calibration.rotation_left_imu_to_wheel[2]
    sensors = dict(drive.recording.sensors)
    sensors["left_wheel"] = Imu(imu.acc_mps2, imu.gyr_radps + extra[:, None] * axle)
    return drive, Recording(drive.recording.time_s, sensors), calibration, extra > 0


@pytest.mark.parametrize("noise", [IDEAL, LIKE_SAMPLE])
def test_correction_restores_a_slipping_stretch_better_than_leaving_it(noise):
    drive, slipping, calibration, where = slipping_drive(noise)
    left, mended = (
        estimate_velocity(slipping, calibration, SAMPLE_CHAIR, slip_correction=on)
        for on in (False, True)
    )
    truth = drive.linear_velocity_mps
    error_left = np.abs(left.linear_velocity_mps - truth)
    error_mended = np.abs(mended.linear_velocity_mps - truth)
    assert error_left[where].max() > 0.9  # 6 rad/s on one of two wheels of 0.315 m
    # the ends of a slip lie below the threshold: 0.2 rad/s of 0.84 m of track, halved
    assert error_mended[where].max() < 0.1
    assert np.array_equal(left.slip, mended.slip)
    assert where[left.slip].mean() > 0.95
    assert left.slip[where].mean() > 0.7
    assert np.array_equal(
        left.linear_velocity_mps[~left.slip], mended.linear_velocity_mps[~left.slip]
    )


def test_tilt_and_bias_of_the_accelerometer_do_not_matter_between_two_good_ends():
    windows = SlipWindows(np.array([40]), np.array([90]))
    velocity = np.full(200, 1.5)
    velocity[40:91] = 9.0
    corrected = correct_slip(velocity, np.full(200, 0.7), windows, 100)
    assert corrected == pytest.approx(np.full(200, 1.5), abs=EXACT)


@pytest.mark.parametrize("window", [(0, 20), (180, 199), (0, 199), (0, 198), (1, 199)])
def test_windows_at_the_ends_lean_on_the_end_that_is_there(window):
    time_s = np.arange(200) / 100
    truth = 1 + 0.5 * time_s
    velocity = truth.copy()
    velocity[window[0] : window[1] + 1] += 2.0
    windows = SlipWindows(np.array([window[0]]), np.array([window[1]]))
    corrected = correct_slip(velocity, np.full(200, 0.5), windows, 100)
    if window == (0, 199):  # no good speed anywhere: only its changes are known
        assert np.diff(corrected) == pytest.approx(np.diff(truth), abs=EXACT)
    else:
        assert corrected == pytest.approx(truth, abs=EXACT)


@pytest.mark.parametrize("count", [2, 8, 9, 10, 15])
def test_shortest_recordings_do_not_break_the_correction(count):
    windows = SlipWindows(np.array([0]), np.array([count - 1]))
    assert np.isfinite(correct_slip(np.ones(count), np.zeros(count), windows, 100)).all()


def test_slip_settings_are_checked():
    SlipSettings(merge_gap_s=0.0)
    for change in ({"threshold_radps": 0.0}, {"low_pass_hz": -1.0}, {"shortest_s": math.nan}):
        with pytest.raises(InputError, match=next(iter(change))):
            SlipSettings(**change)


# Tasks: radius, windows, patterns


def test_curvature_radius_is_in_metres_for_rad_per_second():
    # a circle of 3 m radius at 1.5 m/s takes 2 pi 3 / 1.5 s for a turn
    yaw_rate = 2 * math.pi / (2 * math.pi * 3 / 1.5)
    assert curvature_radius([1.5], [yaw_rate]) == pytest.approx([3.0])
    assert curvature_radius([-1.5], [yaw_rate]) == pytest.approx([3.0])
    assert curvature_radius([1.5], [-yaw_rate]) == pytest.approx([3.0])
    # taken literally, in deg/s, a wide turn becomes a pivot
    assert curvature_radius([1.5], [math.degrees(yaw_rate)])[0] < 0.2
    assert curvature_radius([0.0, 2.0, 1e300], [0.0, 0.0, 1e-290]).tolist() == [np.inf] * 3


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=40), st.integers(1, 45))
def test_window_means_are_means(values, length):
    found = window_means(values, length)
    expected = [np.mean(values[s : s + length]) for s in range(len(values))]
    assert found == pytest.approx(expected, abs=ROUNDING)


def test_every_letter_and_every_pattern_of_the_printed_tables():
    """Constant series in the middle of each range of Table 1, looked up in Table 2."""
    patterns = {}
    for _, cell in load_published("wheelchair_table2").iterrows():
        patterns.setdefault(cell["column"], {})[cell["row"]] = cell["printed"]
    names = {
        "static": Task.STATIC,
        "forward": Task.FORWARD,
        "backward": Task.BACKWARD,
        "pivot": Task.PIVOT,
        "tight": Task.TIGHT,
        "wide": Task.WIDE,
    }
    driven = {
        Task.STATIC: (0.2, 20),
        Task.FORWARD: (1.0, 10),
        Task.BACKWARD: (-1.0, 10),
        Task.PIVOT: (0.1, 60),
        Task.TIGHT: (0.4, 60),
        Task.WIDE: (1.0, 60),
    }
    for task, (velocity, yaw_rate) in driven.items():
        count = 100
        steps = task_steps(np.full(count, velocity), np.full(count, np.deg2rad(yaw_rate)), 100)
        letters = dict(
            zip(
                ("linear_velocity", "abs_linear_velocity", "abs_yaw_rate", "curvature_radius"),
                ["abc"[row[50]] for row in steps.symbols],
                strict=True,
            )
        )
        fitting = [name for name, pattern in patterns.items() if pattern.items() <= letters.items()]
        assert [names[name] for name in fitting] == [task]
        assert (steps.reduced == task).all()


LIMITS = TaskSettings()


@pytest.mark.parametrize(
    ("velocity", "yaw_radps", "task"),
    [
        (0.5, 0.0, Task.FORWARD),
        (np.nextafter(0.5, 0), 0.0, Task.STATIC),
        (-0.5, 0.0, Task.BACKWARD),
        (1.0, math.radians(40), Task.WIDE),  # the print leaves exactly 40 without a letter
        (1.0, math.radians(39.999), Task.FORWARD),
        (0.2, 1.0, Task.PIVOT),
        (0.201, 1.0, Task.TIGHT),
        (0.499, -1.0, Task.TIGHT),
        (-0.5, 1.0, Task.WIDE),
        (0.0, 1.0, Task.PIVOT),
        (0.0, 0.0, Task.STATIC),
    ],
)
def test_limits_of_table_1(velocity, yaw_radps, task):
    # two equal values are added and halved without rounding
    limits = TaskSettings(segment_s=0.02)
    codes = identify_tasks(np.full(64, velocity), np.full(64, yaw_radps), 100, limits)
    assert set(codes) == {task}


def test_rocking_within_a_segment_counts_as_forward_because_table_2_leaves_it_open():
    rocking = np.tile([1.0, -1.0], 100)
    steps = task_steps(rocking, np.zeros(200), 100, TaskSettings(segment_s=0.2))
    assert set(steps.symbols.velocity) == {1}
    assert set(steps.symbols.speed) == {2}
    assert set(find_pattern(steps.symbols)) == {Task.FORWARD}


def test_onset_moves_to_where_motion_begins_and_end_to_where_it_ends():
    codes = np.full(100, Task.STATIC, np.int8)
    codes[40:60] = Task.FORWARD
    speed = np.zeros(100)
    speed[30:75] = 0.3
    calm = np.zeros(100)
    refined = refine_edges(codes, speed, calm, 30, LIMITS)
    assert np.nonzero(refined == Task.FORWARD)[0][[0, -1]].tolist() == [30, 74]
    # not found within the look window: nothing moves
    refined = refine_edges(codes, speed, calm, 9, LIMITS)
    assert np.nonzero(refined == Task.FORWARD)[0][[0, -1]].tolist() == [40, 59]


def test_rotations_take_precedence_over_travel():
    codes = np.full(100, Task.FORWARD, np.int8)
    codes[50:] = Task.WIDE
    turning = np.where(np.arange(100) >= 38, 20.0, 0.0)
    refined = refine_edges(codes, np.full(100, 1.0), turning, 30, LIMITS)
    assert np.nonzero(refined == Task.WIDE)[0][0] == 38


@pytest.mark.parametrize(("length", "absorbed"), [(4, True), (5, False)])
def test_variability_step_takes_only_what_is_shorter_than_a_segment(length, absorbed):
    codes = np.r_[np.full(20, 2), np.full(length, 6), np.full(20, 2)].astype(np.int8)
    reduced = reduce_variability(codes, 5)
    assert (set(reduced) == {2}) is absorbed
    # not between two of one kind, and not at the ends
    for other in ([2, 2, 2, 6, 6, 5, 5, 5], [6, 2, 2, 2, 2, 2, 2, 6]):
        codes = np.array(other, np.int8)
        assert np.array_equal(reduce_variability(codes, 3), codes)


# Tasks: against the plain rendering of the document

HOSTILE_VELOCITY = [
    0.0,
    -0.0,
    0.5,
    -0.5,
    float(np.nextafter(0.5, 0)),
    0.1,
    float(np.nextafter(0.1, 0)),
    0.2,
    -0.05,
    1.3,
    -1.3,
    1e-300,
    4.0,
]
HOSTILE_YAW_RATE = [
    0.0,
    -0.0,
    1e-290,
    math.radians(40),
    float(np.nextafter(math.radians(40), 0)),
    math.radians(10),
    -math.radians(10),
    1.0,
    -1.0,
    2.5,
    -2.6,
    0.4,
]
stretch = st.tuples(
    st.integers(1, 9), st.sampled_from(HOSTILE_VELOCITY), st.sampled_from(HOSTILE_YAW_RATE)
)


@st.composite
def drives(draw):
    """Runs of hostile values with noise from nothing to more than the thresholds' gaps."""
    runs = draw(st.lists(stretch, min_size=1, max_size=16))
    velocity, yaw_rate = (np.concatenate([np.full(run[0], run[k]) for run in runs]) for k in (1, 2))
    noise = draw(st.sampled_from([0.0, 0.0, 1e-16, 0.02, 0.3]))
    rng = np.random.default_rng(draw(st.integers(0, 1000)))
    velocity = velocity + noise * rng.standard_normal(len(velocity))
    yaw_rate = yaw_rate + noise * rng.standard_normal(len(yaw_rate))
    segment = draw(st.integers(1, min(12, len(velocity))))
    look = draw(st.integers(0, 12))
    thresholds = TaskSettings(segment_s=segment / 100, look_s=look / 100)
    if draw(st.booleans()):
        thresholds = replace(
            thresholds,
            linear_velocity_mps=0.2,
            yaw_rate_degps=10.0,
            pivot_radius_m=0.5,
            wide_radius_m=0.5,
            onset_velocity_mps=0.3,
            onset_yaw_rate_degps=0.0,
        )
    return velocity, yaw_rate, segment, look, thresholds


def differing(velocity, yaw_rate, segment, look, thresholds, edge):
    ours = identify_tasks(velocity, yaw_rate, 100, thresholds, edge=edge)
    plain = plain_tasks(velocity, yaw_rate, segment, look, thresholds, edge)
    return int((ours != np.array(plain)).sum())


@settings(deadline=None, max_examples=300)
@given(drives(), st.sampled_from(["covering", "tool"]), st.sampled_from([1, 2, 7, 16384]))
def test_tasks_equal_the_plain_rendering_of_the_document(drive, edge, block):
    with mock.patch.object(tasks, "BLOCK", block):
        assert differing(*drive, edge) == 0


def hostile(kind, count=400):
    """Long series of one bad habit each."""
    rng = np.random.default_rng(7)
    t = np.arange(count)
    at_velocity = 0.5 + rng.choice([-1e-16, 0, 1e-16, -0.01, 0.01], count)
    at_yaw = np.deg2rad(40) + rng.choice([-1e-16, 0, 1e-16, -0.01, 0.01], count)
    return {
        "noise at thresholds": (at_velocity, at_yaw),
        "zeros in yaw": (np.full(count, 0.3), np.where(t % 3, 0.8, 0.0)),
        "one yaw of 1e-290": (np.full(count, 0.1), np.where(t == 200, 1e-290, 1.0)),
        "alternating runs": (np.where(t // 3 % 2, 1.0, 0.0), np.where(t // 4 % 2, 0.9, 0.2)),
        "ties": (np.where(t // 5 % 2, 1.0, 0.0), np.zeros(count)),
        "rest": (np.zeros(count), np.zeros(count)),
        "starts moving": (np.full(count, 1.0), np.full(count, 0.2)),
        "white noise": (rng.standard_normal(count), 2 * rng.standard_normal(count)),
    }[kind]


@pytest.mark.parametrize("edge", ["covering", "tool"])
@pytest.mark.parametrize("segment", [1, 2, 9, 10, 25, 399, 400])
@pytest.mark.parametrize(
    "kind",
    [
        "noise at thresholds",
        "zeros in yaw",
        "one yaw of 1e-290",
        "alternating runs",
        "ties",
        "rest",
        "starts moving",
        "white noise",
    ],
)
def test_tasks_equal_the_plain_rendering_on_hostile_series(kind, segment, edge):
    thresholds = TaskSettings(segment_s=segment / 100)
    with mock.patch.object(tasks, "BLOCK", 64):
        assert differing(*hostile(kind), segment, 30, thresholds, edge) == 0


def test_tasks_of_a_long_drive_do_not_depend_on_the_blocks():
    drive = simulate_drive(COURT, SAMPLE_CHAIR, random_mounting(2), seed=2)
    velocity = np.tile(drive.linear_velocity_mps, 7)
    yaw_rate = np.tile(drive.yaw_rate_radps, 7)
    assert len(velocity) > 2 * tasks.BLOCK
    in_blocks = identify_tasks(velocity, yaw_rate, 100)
    with mock.patch.object(tasks, "BLOCK", 10**9):
        at_once = identify_tasks(velocity, yaw_rate, 100)
    assert np.array_equal(in_blocks, at_once)


@settings(deadline=None, max_examples=50)
@given(drives())
def test_direction_of_a_turn_does_not_matter(drive):
    velocity, yaw_rate, _, _, thresholds = drive
    one = identify_tasks(velocity, yaw_rate, 100, thresholds)
    assert np.array_equal(one, identify_tasks(velocity, -yaw_rate, 100, thresholds))


@settings(deadline=None, max_examples=50)
@given(drives(), st.sampled_from([0.5, 2.0, 4.0]))
def test_clock_and_length_units_do_not_matter(drive, factor):
    velocity, yaw_rate, _, _, thresholds = drive
    one = identify_tasks(velocity, yaw_rate, 100, thresholds)
    # the same frames on a faster clock, with times that shrink alike
    faster = replace(
        thresholds,
        segment_s=thresholds.segment_s / factor,
        look_s=thresholds.look_s / factor,
    )
    assert np.array_equal(one, identify_tasks(velocity, yaw_rate, 100 * factor, faster))
    # another unit of length, a power of two so that no rounding moves a value over a limit
    lengths = ("linear_velocity_mps", "onset_velocity_mps", "pivot_radius_m", "wide_radius_m")
    scaled = replace(thresholds, **{k: factor * getattr(thresholds, k) for k in lengths})
    assert np.array_equal(one, identify_tasks(factor * velocity, yaw_rate, 100, scaled))


@settings(deadline=None, max_examples=50)
@given(drives())
def test_edges_differ_only_in_frames_that_not_all_offsets_cover(drive):
    velocity, yaw_rate, segment, _, thresholds = drive
    covering, tool = (
        task_steps(velocity, yaw_rate, 100, thresholds, edge=edge) for edge in ("covering", "tool")
    )
    different = np.nonzero(covering.pattern != tool.pattern)[0]
    assert (different < segment - 1).all()


def test_a_trial_that_starts_in_motion_is_called_static_at_first_by_the_tools_edge_only():
    velocity, yaw_rate = np.full(200, 1.2), np.zeros(200)
    assert (identify_tasks(velocity, yaw_rate, 100) == Task.FORWARD).all()
    codes = identify_tasks(velocity, yaw_rate, 100, edge="tool")
    # of 25 offsets t + 1 reach frame t: they are outvoted up to 12 of 25
    assert np.nonzero(codes == Task.STATIC)[0].tolist() == list(range(12))


# Tasks: settings and refusals


def test_settings_file_with_the_tools_keys_and_nulls(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text(
        json.dumps(
            {
                "freqAcq": 100,
                "inptSegmentsec": "0.5",
                "seuilVitLinAbs": 0.6,
                "seuilVitAngAbs": 30,
                "seuilRayonMin": None,
                "seuilRayonMax": 0.7,
                "newSeuilVitLinAbs": 0.2,
                "newSeuilVitAngAbs": None,
            }
        )
    )
    found = read_settings(path)
    assert found.sampling_rate_hz == 100
    assert found.settings == TaskSettings(
        segment_s=0.5,
        linear_velocity_mps=0.6,
        yaw_rate_degps=30.0,
        pivot_radius_m=0.0,
        wide_radius_m=0.7,
        onset_velocity_mps=0.2,
        onset_yaw_rate_degps=0.0,
    )
    path.write_text('{"segment_s": 0.4}')
    assert read_settings(path) == (TaskSettings(segment_s=0.4), None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"seuilVitLin": 0.5}', "seuilVitLin is not a setting.*seuilVitLinAbs"),
        ('{"seuilVitLinAbs": "fast"}', "seuilVitLinAbs = 'fast', expected a number"),
        ('{"seuilVitLinAbs": [1]}', "expected a number"),
        ('{"seuilVitLinAbs": -1}', r"linear_velocity_mps = -1\.0"),
        ('{"inptSegmentsec": null}', "segment_s = 0"),
        ('{"seuilRayonMin": 2}', "larger than"),
        ("[1, 2]", "JSON object"),
        ("{", "not valid JSON"),
        ("", "empty"),
    ],
)
def test_bad_settings_file_is_named_with_what_is_wrong(tmp_path, text, message):
    path = tmp_path / "settings.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_settings(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    "change",
    [
        {"segment_s": 0.0},
        {"segment_s": -1.0},
        {"linear_velocity_mps": math.inf},
        {"yaw_rate_degps": math.nan},
        {"pivot_radius_m": 0.6},
        {"look_s": "long"},
    ],
)
def test_impossible_settings_are_refused(change):
    with pytest.raises(InputError, match=next(iter(change))):
        TaskSettings(**change)


def test_segment_of_a_broken_number_of_frames_is_rounded_with_a_warning():
    velocity, yaw_rate = np.ones(500), np.zeros(500)
    with pytest.warns(UserWarning, match=re.escape("0.25 s is 12.5 frames at 50 Hz")):
        codes = identify_tasks(velocity, yaw_rate, 50)
    assert (codes == Task.FORWARD).all()
    # 0.29 s at 100 Hz is 28.999999999999996 in floating point: whole, no warning
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        identify_tasks(velocity, yaw_rate, 100, TaskSettings(segment_s=0.29))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(24), np.zeros(24), 100), "24 frames are fewer than the 25"),
        ((np.zeros(0), np.zeros(0), 100), "0 frames"),
        ((np.zeros(100), np.zeros(99), 100), "expected 100 samples"),
        ((np.r_[np.zeros(50), np.nan], np.zeros(51), 100), "sample 50 is nan"),
        ((np.zeros(51), np.r_[np.zeros(50), np.inf], 100), "sample 50 is inf"),
        ((np.zeros((50, 2)), np.zeros(50), 100), "one time series"),
        ((np.zeros(100), np.zeros(100), 0), "sampling_rate_hz = 0"),
        ((np.zeros(100), np.zeros(100), math.nan), "sampling_rate_hz = nan"),
        ((np.zeros(100), np.zeros(100), 1), "less than one frame"),
    ],
)
def test_series_that_cannot_be_segmented_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        identify_tasks(*arguments)


def test_unknown_edge_is_refused():
    with pytest.raises(InputError, match="edge = 'both'"):
        identify_tasks(np.zeros(100), np.zeros(100), 100, edge="both")


def test_find_pattern_gives_one_task_to_each_of_the_36_combinations():
    grid = np.stack(np.meshgrid(range(3), (1, 2), (1, 2), range(3)), -1).reshape(-1, 4)
    codes = find_pattern(Symbols(*grid.astype(np.int8).T))
    assert set(codes) == set(Task)
    assert len(codes) == 36


# The bundled recording


@pytest.fixture(scope="module")
def court():
    folder = recordings_folder() / "wheelchair_court"
    static, straight, trial = (
        read_recording(folder / f"{name}.csv.gz") for name in ("static", "straight", "court")
    )
    geometry = WheelchairGeometry.from_toml(folder / "geometry.toml")
    found = estimate_velocity(trial, calibrate(static, straight), geometry)
    return found, pd.read_csv(folder / "truth.csv.gz")


def test_velocities_of_the_bundled_recording(court):
    found, truth = court
    # gyro bias 0.003 and noise 0.003 rad/s (1 sd each): 0.3 m of wheel, 57.3 deg
    assert np.abs(found.linear_velocity_mps - truth["linear_velocity_mps"]).max() < 0.01
    yaw = np.rad2deg(found.yaw_rate_radps)
    assert np.abs(yaw - truth["yaw_rate_degps"]).max() < 57.3 * 0.003 * 7
    assert not found.slip.any()


def test_tasks_of_the_bundled_recording_are_right_away_from_the_changes(court):
    found, truth = court
    codes = identify_tasks(found.linear_velocity_mps, found.yaw_rate_radps, 100)
    assert set(codes) == set(Task)
    # A change takes 0.8 s, and step 4 looks 0.30 s further than a segment of 0.25 s sees: from
    # 0.7 s on either side of a programmed change every frame is the driven task.
    ends = np.cumsum([leg.duration_s for leg in COURT])[:-1]
    far = np.abs(truth["time_s"].to_numpy()[:, None] - ends).min(axis=1) > 0.7
    assert np.array_equal(codes[far], truth["task_code"][far])
    assert far.mean() > 0.5
    assert (codes == truth["task_code"]).mean() > 0.9


# What the tables leave open


def test_three_combinations_of_table_2_are_open():
    # velocity b, speed c, yaw rate b, with any of the three letters of the radius
    assert open_combinations() == 3


def test_a_wrong_radius_is_not_mistaken_for_a_wrong_factor():
    rng = np.random.default_rng(3)
    yaw, speed = rng.uniform(0.4, 1.2, 500), rng.uniform(1, 4, 500)
    factor, share = yaw_gain(yaw, 0.7 * yaw + 0.02 * speed, speed, side="left")
    assert (factor, share) == pytest.approx((0.7, 0.02), abs=ROUNDING)


# Figures


def bars(figure):
    """Start and width (s) of every coloured bar of the chronogram, by its band's centre."""
    from matplotlib.collections import PolyCollection

    found = {}
    for collection in figure.axes[-1].collections:
        assert isinstance(collection, PolyCollection)
        if len(collection.get_facecolor()):  # the hatch has none
            for path in collection.get_paths():
                box = path.get_extents()
                found.setdefault(round((box.y0 + box.y1) / 2), []).append((box.x0, box.width))
    return found


@pytest.fixture
def no_figures_left_open():
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    yield
    plt.close("all")


@pytest.mark.usefixtures("no_figures_left_open")
def test_chronogram_has_a_bar_for_every_run_in_the_band_of_its_task():
    codes = np.repeat([1, 2, 6, 2, 4], [100, 300, 50, 50, 10])
    time_s = 5 + np.arange(510) / 100
    figure = chronogram(time_s, codes)
    assert bars(figure) == {
        1: [pytest.approx((5, 1))],
        2: [pytest.approx((6, 3)), pytest.approx((9.5, 0.5))],
        6: [pytest.approx((9, 0.5))],
        4: [pytest.approx((10, 0.1))],
    }
    names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert names == [task.title for task in Task]


@pytest.mark.usefixtures("no_figures_left_open")
@pytest.mark.parametrize("minutes", [0.1, 2, 30])
def test_chronogram_keeps_the_velocities_peaks_at_any_length(minutes, tmp_path):
    count = int(minutes * 6000)
    time_s = np.arange(count) / 100
    velocity = np.sin(time_s)
    velocity[count // 3] = 9.0  # one sample
    codes = np.where(velocity > 0.5, Task.FORWARD, Task.STATIC)
    figure = chronogram(time_s, codes, velocity, np.full(count, -1.0))
    upper, lower, _ = (ax for ax in figure.axes if ax.get_ylabel() != "share of time")
    curve = max((line.get_ydata() for line in upper.lines), key=len)
    assert np.max(curve) == 9.0
    assert max((line.get_ydata() for line in lower.lines), key=len)[0] == pytest.approx(-57.3, 0.01)
    figure.savefig(tmp_path / "chronogram.png")


@pytest.mark.usefixtures("no_figures_left_open")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 1], [1, 7]), "sample 1 is 7, expected a task"),
        (([0, 1], [1, 0]), "sample 1 is 0"),
        (([0, 1], [1]), "expected 2 samples"),
        (([0, 0], [1, 1]), "rising times"),
        (([0], [1]), "rising times"),
        (([0, 1], [1, 1], [1.0]), "linear_velocity_mps: expected 2"),
    ],
)
def test_impossible_chronograms_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        chronogram(*arguments)


@pytest.mark.usefixtures("no_figures_left_open")
@pytest.mark.parametrize("chair", [None, *CHAIRS], ids=["sample", "0deg", "3deg", "19deg", "24deg"])
def test_frames_are_drawn_to_scale_for_any_chair(chair, tmp_path):
    figure = draw_frames(chair)
    chair = chair or SAMPLE_CHAIR
    rear = figure.axes[0]
    contacts = [line.get_xdata()[0] for line in rear.lines if line.get_marker() == "^"]
    assert sorted(contacts) == pytest.approx([-chair.track_m / 2, chair.track_m / 2])
    figure.savefig(tmp_path / "frames.png")
