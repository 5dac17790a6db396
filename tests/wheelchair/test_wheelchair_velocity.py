"""Wheelchair: velocities (equations 1.16 to 1.18) against geometry and a simulator."""

import math
from dataclasses import replace

import numpy as np
import pytest
from chairs import (
    BOTH_WAYS,
    EXACT,
    ROUNDING,
    calibrated,
    chairs,
    trials,
)
from hypothesis import given
from hypothesis import strategies as st

from mobility_imu.errors import InputError
from mobility_imu.recording import Recording
from mobility_imu.reproduction.wheelchair.facing import facing_mounting, forward_axles
from mobility_imu.reproduction.wheelchair.printed import (
    gyroscope_outward,
    printed_angles,
    sign_choices,
    spin_printed,
    velocity_printed,
    wheel_rates_printed,
    yaw_rate_printed,
)
from mobility_imu.reproduction.wheelchair.sample import yaw_gain
from mobility_imu.simulation.wheelchair import (
    IDEAL,
    STATIC_TRIAL,
    Leg,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    VelocitySettings,
    calibrate_mount,
    estimate_velocity,
)
from mobility_imu.wheelchair.calibration import (
    alignment_matrix,
    wheel_alignment_angles,
)
from mobility_imu.wheelchair.geometry import side_sign
from mobility_imu.wheelchair.uncertainty import velocity_standard_deviation
from mobility_imu.wheelchair.velocity import (
    linear_velocity,
    printed_yaw_gain,
    single_wheel_velocity,
    wheel_spin_rate,
    wheel_spin_rate_printed,
    wheel_yaw_rate,
)


@chairs
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_ideal_sensors_give_the_driven_velocities_back(chair, seed):
    static, straight, drive = trials(chair, seed)
    found = estimate_velocity(drive.recording, chair, calibrated(static, straight).mount)
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
        @ calibration.mount.rotation_imu_to_wheel(side).T
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
        drive.recording, chair, calibrated(static, straight).mount, VelocitySettings(form="printed")
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
        for side, forward in forward_axles(facing, 1000):
            outward = side_sign(side) * forward
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
    forward = axle_rates(line, calibrate_mount(still.recording, line.recording))
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


def test_a_wrong_radius_is_not_mistaken_for_a_wrong_factor():
    rng = np.random.default_rng(3)
    yaw, speed = rng.uniform(0.4, 1.2, 500), rng.uniform(1, 4, 500)
    factor, share = yaw_gain(yaw, 0.7 * yaw + 0.02 * speed, speed, side="left")
    assert (factor, share) == pytest.approx((0.7, 0.02), abs=ROUNDING)


@pytest.mark.parametrize(
    "call",
    [
        lambda a, b: wheel_spin_rate(a, b, 0.3, side="left"),
        lambda a, b: linear_velocity(a, b, SAMPLE_CHAIR),
        lambda a, b: wheel_yaw_rate(a, b, SAMPLE_CHAIR, distance_m=0.8),
        lambda a, b: single_wheel_velocity(a, b, SAMPLE_CHAIR, side="right"),
        lambda a, b: velocity_standard_deviation(
            a, b, SAMPLE_CHAIR, gyr_sd_radps=0.01, radius_sd_m=0.001
        ),
    ],
)
def test_series_of_unequal_length_are_refused(call):
    with pytest.raises(InputError, match=r"\(5,\).*\(4,\).*expected series of one length"):
        call(np.ones(5), np.ones(4))
    assert np.shape(call(np.ones(5), 1.0)) == (5,)


def test_one_wheel_of_no_side_is_refused():
    with pytest.raises(InputError, match="side = 'middle'"):
        single_wheel_velocity(np.ones(3), np.ones(3), SAMPLE_CHAIR, side="middle")
    with pytest.raises(InputError, match="side = 'middle'"):
        wheel_spin_rate_printed(np.ones((3, 3)), 0.3, side="middle")


def test_settings_that_go_together_and_one_pair_that_does_not():
    for form in ("corrected", "printed"):
        for correct in (True, False):
            for method in ("wheels", "tool"):
                settings = {"form": form, "slip_correction": correct, "slip_method": method}
                if form == "printed" and correct and method == "wheels":
                    with pytest.raises(InputError, match="slip_method = 'wheels'"):
                        VelocitySettings(**settings)
                else:
                    assert VelocitySettings(**settings).form == form


def test_the_rate_of_a_velocity_is_that_of_its_clock():
    found = calibrated_velocity()
    assert found.sampling_rate_hz == 100.0
    late = replace(found, time_s=found.time_s + 17.3)
    assert late.sampling_rate_hz == 100.0


def test_a_recording_without_wheels_names_them():
    static, straight, drive = trials(SAMPLE_CHAIR, 3)
    mount = calibrate_mount(static.recording, straight.recording).mount
    recording = drive.recording
    only = Recording(recording.time_s, {"frame": recording.sensors["frame"]}, source="d.csv")
    with pytest.raises(InputError, match="left_wheel"):
        estimate_velocity(only, SAMPLE_CHAIR, mount)
    for side in ("left", "right"):
        names = ("frame", f"{side}_wheel")
        one = Recording(recording.time_s, {name: recording.sensors[name] for name in names})
        assert len(estimate_velocity(one, SAMPLE_CHAIR, mount)) == len(recording)


def calibrated_velocity():
    static, straight, drive = trials(SAMPLE_CHAIR, 3)
    mount = calibrate_mount(static.recording, straight.recording).mount
    return estimate_velocity(drive.recording, SAMPLE_CHAIR, mount)
