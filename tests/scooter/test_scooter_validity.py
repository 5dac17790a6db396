"""Scooter: where the closed form holds, what it says elsewhere, and which sign is reversed."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, wrap_angle
from mobility_imu.readers import read_recording
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    RideSettings,
    ScooterGeometry,
    ScooterMount,
    estimate_angles,
    estimate_ride,
)
from mobility_imu.scooter.angles import LARGEST_ERROR_RAD, OBSERVABILITY_LIMIT
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
from mobility_imu.scooter.sensitivity import steering_error_per_tilt
from mobility_imu.simulation.scooter import COURSES, draw_driver, draw_scooter, simulate_parked
from mobility_imu.simulation.scooter import simulate_ride as drive

G = STANDARD_GRAVITY_MPS2
LEVEL = np.array([0.0, 0.0, G])
FORMS = ["corrected", "printed"]


def at(steering_deg, throttle_deg=10.0, body=LEVEL):
    return lever_acceleration(body, np.deg2rad(steering_deg), np.deg2rad(throttle_deg), SUZUKI_ET4D)


# --- accelerated sensors ----------------------------------------------------------------------


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("steering_deg", [0, 30, -60])
def test_lengths_off_gravity_are_not_valid_beyond_the_stated_error(steering_deg, sign, form):
    """The limit is a steering error of 20 deg by a tilt of |length / g - 1|: 12 % straight ahead.

    Of both sensors at once: eq. 5 fits, and their length is all that tells.
    """
    most = LARGEST_ERROR_RAD / steering_error_per_tilt(LEVEL, np.deg2rad(steering_deg), SUZUKI_ET4D)
    if steering_deg == 0:
        assert most == pytest.approx(0.119, abs=0.001)
    for part, valid in ((0.98, True), (1.02, False)):
        scale = 1 + sign * part * most
        lever, body = scale * at(steering_deg), scale * LEVEL
        found = estimate_angles([lever], [body], SUZUKI_ET4D, form=form)
        assert found.valid.tolist() == [valid] and bool(found.warnings) != valid
        assert np.rad2deg(found.steering_rad[0]) == pytest.approx(steering_deg)


def test_one_sensor_alone_is_enough_and_a_single_one_has_no_body():
    for lever, body in ((1.2, 1.0), (0.8, 1.0), (1.0, 1.2), (1.0, 0.8)):
        assert not estimate_angles(lever * at(0), body * LEVEL, SUZUKI_ET4D).valid
    assert estimate_angles(1.05 * at(0), None, SUZUKI_ET4D).valid
    assert not estimate_angles(1.2 * at(0), None, SUZUKI_ET4D).valid


@given(st.floats(-40, 40), st.floats(0, 40), st.floats(0, 2 * np.pi), st.floats(0.01, 0.3))
def test_what_is_valid_errs_by_no_more_than_was_allowed(steering_deg, throttle_deg, where, size):
    """An acceleration of the lever of any direction across gravity, and the same along gravity."""
    lever = at(steering_deg, throttle_deg)
    up = lever / G
    one = np.cross(up, [1.0, 0.0, 0.0])
    one /= np.linalg.norm(one)
    across = np.cos(where) * one + np.sin(where) * np.cross(up, one)
    found = estimate_angles(lever + size * G * (across + up), LEVEL, SUZUKI_ET4D)
    if found.valid:
        # Half as much again: the error is not small any more, and the length grows by both.
        error = wrap_angle(found.steering_rad - np.deg2rad(steering_deg))
        assert abs(error) < 1.5 * LARGEST_ERROR_RAD


@pytest.mark.parametrize("towards", [0.0, 1.0, 2.0, 4.0])
def test_a_scooter_that_leans_too_far_is_not_valid(towards):
    """30 deg between the body's force and its z axis, to any side."""
    for lean_deg, valid in ((29.5, True), (30.5, False)):
        lean = np.deg2rad(lean_deg)
        side = np.array([np.cos(towards), np.sin(towards)]) * np.sin(lean)
        body = G * np.array([*side, np.cos(lean)])
        lever = at(0, body=body)
        found = estimate_angles(lever, body, SUZUKI_ET4D)
        assert found.valid == valid


def test_near_u_of_90_deg_nothing_is_valid():
    """On level ground cos(u) sin(20 deg) has to be above sin(2 deg): u up to 84 deg."""
    limit = np.rad2deg(
        np.arccos(OBSERVABILITY_LIMIT / np.sin(SUZUKI_ET4D.steering_inclination_rad))
    )
    assert limit == pytest.approx(84.1, abs=0.1)
    steering = np.array([limit - 0.1, limit + 0.1, 89.0])
    assert estimate_angles(at(steering), LEVEL, SUZUKI_ET4D).valid.tolist() == [True, False, False]
    # A little acceleration turns the angle by 20 deg far earlier.
    assert not estimate_angles(1.03 * at(80.0), LEVEL, SUZUKI_ET4D).valid


def test_a_warning_says_how_many_samples_were_accelerated():
    lever, body = np.tile(at(0), (100, 1)), np.tile(LEVEL, (100, 1))
    lever[:5] *= 1.3
    assert estimate_angles(lever, body, SUZUKI_ET4D).warnings == ()
    lever[5:7] *= 1.3
    (warning,) = estimate_angles(lever, body, SUZUKI_ET4D).warnings
    assert "accelerated in 7 % of the samples" in warning
    lever[:40] *= 1.3
    lever[90:] = np.nan
    body[39] = body_specific_force(np.deg2rad(40), 0.0)
    (warning,) = estimate_angles(lever, body, SUZUKI_ET4D).warnings
    assert "the sensors were accelerated in 44 % of the samples" in warning
    assert "off gravity by 30 % (median)" in warning and "z axis in 2 %" in warning


def test_nothing_and_no_numbers_give_no_warning():
    assert estimate_angles(np.zeros((0, 3)), None, SUZUKI_ET4D).warnings == ()
    assert estimate_angles(np.full((4, 3), np.nan), LEVEL, SUZUKI_ET4D).warnings == ()


@pytest.mark.parametrize("course", COURSES)
@pytest.mark.parametrize("single_imu", [False, True])
def test_slow_drives_stay_valid(course, single_imu):
    """After the paper's median: all of a smooth floor, nine of ten samples of a rough one."""
    ride = drive(COURSES[course], seed=1, unit=draw_scooter(1), driver=draw_driver(1))
    found = estimate_ride(ride.recording, SUZUKI_ET4D, None, RideSettings(single_imu=single_imu))
    rough = course in ("tactile", "slopes")
    assert found.valid.mean() >= (0.9 if rough else 0.999)
    assert rough or found.warnings == ()


def test_parked_scooters_stay_valid():
    for seed in range(3):
        parked = simulate_parked(pitch_rad=0.08, bank_rad=0.05, seed=seed, unit=draw_scooter(seed))
        found = estimate_ride(parked, SUZUKI_ET4D)
        assert found.valid.all() and found.warnings == ()


def test_raw_samples_of_a_rough_floor_that_are_left_out_are_the_bad_ones():
    ride = drive(COURSES["tactile"], seed=2, unit=draw_scooter(2), driver=draw_driver(2))
    found = estimate_ride(ride.recording, SUZUKI_ET4D, None, RideSettings(median_window=1))
    error = np.rad2deg(wrap_angle(found.steering_rad - ride.steering_rad))
    rms = [np.sqrt(np.mean(error[flags] ** 2)) for flags in (found.valid, ~found.valid)]
    assert rms[1] > 2 * rms[0]
    (warning,) = found.warnings[:1]
    assert warning.startswith("simulated ride, tactile: the sensors were accelerated in ")


# --- which sign is reversed -------------------------------------------------------------------


def sweep(first_deg, last_deg, count=1000):
    """Lever pulled from one throttle angle to another, evenly."""
    return at(0.0, np.linspace(first_deg, last_deg, count))


def test_a_sweep_beyond_90_deg_is_no_reversed_sensor():
    for lever in (
        sweep(0, -180),
        sweep(-10, 180),
        np.concatenate([sweep(0, 170, 200), sweep(170, 170)]),
    ):
        found = estimate_angles(lever, LEVEL, SUZUKI_ET4D)
        assert found.valid.mean() > 0.9
    # It begins on the far side, but comes back.
    estimate_angles(sweep(-170, 0), LEVEL, SUZUKI_ET4D)


@given(st.floats(-50, 50), st.floats(0, 40), st.floats(-8, 8), st.floats(-8, 8))
def test_a_reversed_sensor_is_refused_wherever_the_controls_are(steering, throttle, pitch, roll):
    body = body_specific_force(np.deg2rad(pitch), np.deg2rad(roll))
    lever = at(steering, throttle, body)
    for wrong in ((-lever, body), (-lever, None)):
        with pytest.raises(InputError, match=r"lever_acc_mps2: .*the sign is flipped"):
            estimate_angles(*wrong, SUZUKI_ET4D)
    for lever_too in (lever, -lever):
        with pytest.raises(InputError, match=r"body_acc_mps2: .*the sign is flipped"):
            estimate_angles(lever_too, -body, SUZUKI_ET4D)


def test_a_reversed_sensor_of_a_whole_ride_is_refused_in_spite_of_blows():
    ride = drive(COURSES["tactile"], seed=3, unit=draw_scooter(3), driver=draw_driver(3))
    lever, body = (ride.recording.sensor(name).acc_mps2 for name in ("lever", "body"))
    with pytest.raises(InputError, match="lever_acc_mps2"):
        estimate_angles(-lever, body, SUZUKI_ET4D)
    with pytest.raises(InputError, match="body_acc_mps2"):
        estimate_angles(lever, -body, SUZUKI_ET4D)


@pytest.mark.parametrize("side", [1, -1])
def test_the_sign_changes_at_90_deg_to_the_controls_at_rest(side):
    """One reading a quarter of a degree to either side."""
    lever = at(0.0, 90 - side * 0.25)
    if side > 0:
        estimate_angles(lever, LEVEL, SUZUKI_ET4D)
    else:
        with pytest.raises(InputError, match="more than 90 deg away"):
            estimate_angles(lever, LEVEL, SUZUKI_ET4D)
    body = G * np.array([0.0, np.cos(side * 0.004), np.sin(side * 0.004)])
    if side > 0:
        estimate_angles(body, body, SUZUKI_ET4D)
    else:
        with pytest.raises(InputError, match=r"the median z is -0\.0392"):
            estimate_angles(body, body, SUZUKI_ET4D)


def test_how_many_samples_speak_for_a_right_sign():
    """A tenth within 90 deg, or the first quarter of a second; both on the wrong side: reversed."""
    right, wrong = at(0.0, 10.0), at(0.0, 150.0)
    for first, many, refused in ((0, 95, True), (0, 105, False), (20, 0, False), (10, 0, True)):
        lever = np.tile(wrong, (1000, 1))
        lever[:first] = right
        lever[1000 - many :] = right
        if refused:
            with pytest.raises(InputError, match="the sign is flipped"):
                estimate_angles(lever, LEVEL, SUZUKI_ET4D)
        else:
            estimate_angles(lever, LEVEL, SUZUKI_ET4D)


@pytest.mark.parametrize("samples", [slice(0, 25), slice(500, 800)])
def test_a_sign_is_right_from_90_deg_on(samples):
    """A quarter of a degree within, at first or in more than a tenth of the samples."""
    lever = np.tile(at(0.0, 150.0), (1000, 1))
    lever[samples] = at(0.0, 89.75)
    estimate_angles(lever, LEVEL, SUZUKI_ET4D)


def test_blows_at_first_do_not_reverse_a_sign():
    """Ten of the first 25 readings are large and on the wrong side."""
    lever = np.tile(at(0.0, 150.0), (1000, 1))
    lever[:15] = at(0.0)
    lever[15:25] *= 5
    estimate_angles(lever, LEVEL, SUZUKI_ET4D)


def test_a_sign_that_nothing_shows_is_not_reversed():
    lever, body = np.tile(at(0.0), (100, 1)), np.tile(LEVEL, (100, 1))
    lever[:50], body[50:] = np.nan, np.nan
    assert not estimate_angles(lever, body, SUZUKI_ET4D).valid.any()


def test_a_long_recording_is_looked_at_from_its_beginning_to_its_end():
    """A minute at rest, then an hour beyond 90 deg: a twentieth is not enough, but it began so."""
    lever = np.tile(at(0.0, 150.0), (200_000, 1))
    lever[:2000] = at(0.0)
    estimate_angles(lever, LEVEL, SUZUKI_ET4D)
    with pytest.raises(InputError, match="the sign is flipped"):
        estimate_angles(lever[2000:], LEVEL, SUZUKI_ET4D)
    lever[:2000], lever[-30_000:] = at(0.0, 150.0), at(0.0)
    estimate_angles(lever, LEVEL, SUZUKI_ET4D)


# --- real recordings --------------------------------------------------------------------------


def real(name, recording, geometry):
    folder = find_folder(name)
    if folder is None:
        pytest.skip(f"{name} is not here")
    (path,) = folder.rglob(f"{recording}.csv.gz")
    (geometry_path,) = folder.rglob(f"{geometry}.toml")
    truth = pd.read_csv(path.with_name(f"{recording}_truth.csv.gz"))
    return (
        read_recording(path),
        ScooterGeometry.from_toml(geometry_path),
        ScooterMount.in_toml(geometry_path),
        truth,
    )


@pytest.mark.parametrize("window", [1, 9, 25])
@pytest.mark.parametrize("name", ["trial1_rigid", "trial1_foam"])
def test_a_chain_in_hands_is_no_slow_drive_and_the_closed_form_says_so(name, window):
    """It errs by 34 and 85 deg there."""
    ride, geometry, mount, truth = real("two-hinges", name, "geometry")
    found = estimate_ride(ride, geometry, mount, RideSettings(median_window=window))
    error = wrap_angle(found.steering_rad - truth["steering_rad"].to_numpy())
    assert np.rad2deg(np.sqrt(np.nanmean(error**2))) > 30
    assert found.valid.mean() < 0.01
    assert f"{name}.csv.gz: the sensors were accelerated in " in found.warnings[0]


@pytest.mark.parametrize(
    ("name", "steering_deg", "throttle_deg"), [("slow", 5, 2.5), ("medium", 4, 4)]
)
def test_a_hinge_that_sweeps_180_deg_on_a_fixed_base_is_valid(name, steering_deg, throttle_deg):
    """Accelerometers in steps of 0.01 g with offsets to 0.03 g; steering is truly 0."""
    ride, geometry, mount, truth = real("one-hinge", f"pitch_{name}", f"pitch_{name}_geometry")
    found = estimate_ride(ride, geometry, mount)
    assert found.valid.mean() > 0.99 and found.warnings == ()
    for angle, most in (("steering", steering_deg), ("throttle", throttle_deg)):
        error = wrap_angle(getattr(found, f"{angle}_rad") - truth[f"{angle}_rad"].to_numpy())
        assert np.rad2deg(np.sqrt(np.nanmean(error**2))) < most
