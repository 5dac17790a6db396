"""Scooter: derivatives of both angles against perturbed estimates, random draws and SymPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, wrap_angle
from mobility_imu.scooter import SUZUKI_ET4D, ScooterGeometry, estimate_angles
from mobility_imu.scooter.angles import angle_standard_deviations, three_axis_angles
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
from mobility_imu.scooter.sensitivity import (
    by_lever_acceleration,
    mirror_angles,
    sensitivities,
    single_imu_range,
    steering_error_per_tilt,
    worst_error_per_tilt,
)

G = STANDARD_GRAVITY_MPS2
SIZES = {
    "lever_bias": 3,
    "body_bias": 3,
    "lever_mounting": 3,
    "body_mounting": 3,
    "steering_inclination": 1,
    "lever_inclination": 1,
    "slope": 2,
}


def poses(count=200, seed=3):
    """Slopes to 6 deg and the range of the controls, away from where one IMU saturates."""
    rng = np.random.default_rng(seed)
    pitch, roll = np.deg2rad(rng.uniform(-6, 6, (2, count)))
    steering, throttle = np.deg2rad(rng.uniform([[-40], [0]], [[40], [40]], (2, count)))
    right, left = single_imu_range(pitch, roll, SUZUKI_ET4D)
    room = np.minimum(steering - right, left - steering) > np.deg2rad(8)
    return pitch[room], roll[room], steering[room], throttle[room]


def estimate(pose, imus, error, size):
    """Both angles, with one error put in exactly; nothing of the derivatives is used here."""
    pitch, roll, steering, throttle = pose
    give = {name: np.zeros(count) for name, count in SIZES.items()}
    give[error] = np.asarray(size, float)
    force = body_specific_force(pitch + give["slope"][0], roll + give["slope"][1])
    lever = lever_acceleration(force, steering, throttle, SUZUKI_ET4D)
    lever_turn, body_turn = (
        Rotation.from_rotvec(give[f"{who}_mounting"]).as_matrix() for who in ("lever", "body")
    )
    lever = lever @ lever_turn + give["lever_bias"]  # rows times the matrix: its transpose
    body = force @ body_turn + give["body_bias"]
    believed = ScooterGeometry(
        SUZUKI_ET4D.steering_inclination_rad + give["steering_inclination"][0],
        SUZUKI_ET4D.lever_inclination_rad + give["lever_inclination"][0],
    )
    return np.stack(
        three_axis_angles(lever, body if imus == "dual" else (0.0, 0.0, G), believed), axis=-1
    )


@pytest.mark.parametrize("imus", ["dual", "single"])
@pytest.mark.parametrize("error", SIZES)
def test_derivatives_are_those_of_the_estimate(imus, error):
    pose = poses()
    ours = getattr(sensitivities(*pose, SUZUKI_ET4D, imus=imus), error)
    assert ours.shape == (len(pose[0]), 2, SIZES[error])
    step = 1e-5
    for k in range(SIZES[error]):
        one = step * np.eye(SIZES[error])[k]
        there, back = estimate(pose, imus, error, one), estimate(pose, imus, error, -one)
        # Central differences: the third derivative times step²; it grows as 1 / K2³, to 1e2 here.
        np.testing.assert_allclose(ours[..., k], (there - back) / (2 * step), atol=3e-7, rtol=1e-6)


def test_spread_by_noise_is_what_angle_standard_deviations_says():
    pitch, roll, steering, throttle = poses()
    body = body_specific_force(pitch, roll)
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    s = sensitivities(pitch, roll, steering, throttle, SUZUKI_ET4D, imus="dual")
    sd = np.sqrt((0.02 * s.lever_bias) ** 2 @ np.ones(3) + (0.01 * s.body_bias) ** 2 @ np.ones(3))
    theirs = angle_standard_deviations(
        lever, steering, throttle, SUZUKI_ET4D, lever_sd_mps2=0.02, body_sd_mps2=0.01
    )
    np.testing.assert_allclose(sd, np.stack(theirs, axis=-1), rtol=1e-12)


def test_covariance_of_all_errors_together_matches_random_scooters():
    # 0.5 deg of tilt on every axis, 3 mg of bias; 4 % of the sd, 8 % of the variance: 20 000
    # draws know an sd to 0.5 %, the curvature at these sizes adds about 1 %.
    rng = np.random.default_rng(11)
    count, mount, bias = 20_000, np.deg2rad(0.5), 3e-3 * G
    pitch, roll, steering, throttle = np.deg2rad([-3, 4, -35, 25])
    force = body_specific_force(pitch, roll)
    lever = lever_acceleration(force, steering, throttle, SUZUKI_ET4D)
    turned = [
        Rotation.from_rotvec(rng.normal(0, mount, (count, 3))).inv().apply(v)
        + rng.normal(0, bias, (count, 3))
        for v in (lever, force)
    ]
    seen = np.stack(three_axis_angles(*turned, SUZUKI_ET4D), axis=-1)
    s = sensitivities(pitch, roll, steering, throttle, SUZUKI_ET4D, imus="dual")
    by_all = np.concatenate(
        [
            mount * s.lever_mounting,
            mount * s.body_mounting,
            bias * s.lever_bias,
            bias * s.body_bias,
        ],
        axis=-1,
    )
    np.testing.assert_allclose(np.cov(seen.T), by_all @ by_all.T, rtol=0.08, atol=1e-6)


def test_known_numbers_on_level_ground():
    # Straight and at rest: g cos/sin of alpha and beta, by hand.
    alpha, beta = SUZUKI_ET4D.steering_inclination_rad, SUZUKI_ET4D.lever_inclination_rad
    s = sensitivities(0.0, 0.0, 0.0, 0.0, SUZUKI_ET4D, imus="dual")
    assert s.lever_mounting[0, 1] == pytest.approx(-np.cos(beta) / np.sin(alpha))  # -2.89
    assert s.lever_mounting[0, 2] == pytest.approx(np.sin(beta) / np.sin(alpha))  # 0.46
    assert np.rad2deg(s.lever_bias[0, 0]) * G / 1000 == pytest.approx(0.1675, abs=1e-4)
    assert np.rad2deg(np.linalg.norm(s.lever_bias[1])) * G / 1000 == pytest.approx(0.0573, abs=1e-4)
    # A believed alpha that is too large: -tan(steering) / tan(alpha).
    lock = np.deg2rad(50)
    s = sensitivities(0.0, 0.0, lock, 0.0, SUZUKI_ET4D, imus="single")
    assert s.steering_inclination[0, 0] == pytest.approx(-np.tan(lock) / np.tan(alpha))


@pytest.mark.parametrize("imus", ["dual", "single"])
def test_what_holds_at_every_pose(imus):
    s = sensitivities(*poses(), SUZUKI_ET4D, imus=imus)
    # Lever IMU about x, and beta: throttle one to one, steering not at all. They cannot be told
    # apart.
    np.testing.assert_allclose(s.lever_mounting[..., 0], [[0, -1]] * len(s.slope), atol=1e-12)
    np.testing.assert_allclose(s.lever_inclination[..., 0], [[0, 1]] * len(s.slope))
    if imus == "single":
        assert not s.body_bias.any() and not s.body_mounting.any() and s.slope.all()
    else:
        assert not s.slope.any()
        # Body IMU about x: alpha and beta, both too large.
        np.testing.assert_allclose(
            s.body_mounting[..., 0],
            (s.steering_inclination + s.lever_inclination)[..., 0],
            atol=1e-12,
        )


def test_on_level_ground_a_tilted_body_imu_is_a_slope_that_is_not_there():
    steering, throttle = np.deg2rad(np.meshgrid([-50, 0, 30], [0, 40]))
    dual, single = (
        sensitivities(0.0, 0.0, steering, throttle, SUZUKI_ET4D, imus=imus)
        for imus in ("dual", "single")
    )
    # Turned about x by e it reads a pitch of e, about y a roll of -e, where there is none.
    np.testing.assert_allclose(dual.body_mounting[..., 0], -single.slope[..., 0], atol=1e-12)
    np.testing.assert_allclose(dual.body_mounting[..., 1], single.slope[..., 1], atol=1e-12)


def test_what_an_accelerometer_cannot_see_costs_nothing():
    # A turn about the acceleration itself leaves the reading as it was; a common scale cancels.
    pitch, roll, steering, throttle = poses()
    s = sensitivities(pitch, roll, steering, throttle, SUZUKI_ET4D, imus="dual")
    body = body_specific_force(pitch, roll)
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    for by, along in ((s.lever_mounting, lever), (s.body_mounting, body)):
        np.testing.assert_allclose(by @ along[..., None], 0, atol=1e-12)
    for by, along in ((s.lever_bias, lever), (s.body_bias, body)):
        np.testing.assert_allclose(by @ along[..., None], 0, atol=1e-12)


def test_worst_tilt_is_the_length_of_the_row():
    pitch, roll, steering, throttle = poses()
    s = sensitivities(pitch, roll, steering, throttle, SUZUKI_ET4D, imus="dual")
    worst = steering_error_per_tilt(body_specific_force(pitch, roll), steering, SUZUKI_ET4D)
    np.testing.assert_allclose(worst, np.linalg.norm(s.lever_mounting[:, 0], axis=-1))
    np.testing.assert_allclose(worst / G, np.linalg.norm(s.lever_bias[:, 0], axis=-1))


def test_observability_is_lost_with_k2():
    # Side slope of 20 deg: K2 = 0 at 43.2 deg. The product with K2 stays, the derivative does not.
    roll, end = np.deg2rad(20), np.deg2rad(43.22)
    body = body_specific_force(0.0, roll)
    steering = end - np.array([1e-1, 1e-2, 1e-3])
    size = np.abs(by_lever_acceleration(body, steering, 0.0, SUZUKI_ET4D)[:, 0]).max(axis=-1)
    assert (np.diff(size) > 0).all() and size[-1] > 50 * size[0]


def test_single_imu_range_is_where_the_printed_form_ends():
    pitch, roll = np.deg2rad(
        np.meshgrid(np.arange(-9, 10, 3.0), np.arange(-9, 10, 3.0), indexing="ij")
    )
    right, left = single_imu_range(pitch, roll, SUZUKI_ET4D)
    body = body_specific_force(pitch, roll)
    for limit, outward in ((right, -1), (left, 1)):
        there = np.isfinite(limit)
        for step, answers in ((-1e-3, True), (1e-3, False)):
            steering = limit[there] + outward * step
            lever = lever_acceleration(body[there], steering, 0.0, SUZUKI_ET4D)
            angles = estimate_angles(lever, None, SUZUKI_ET4D, form="printed")
            assert (np.isfinite(angles.steering_rad) == answers).all()
    assert not np.isfinite(single_imu_range(np.deg2rad(-5), 0.0, SUZUKI_ET4D)[1])
    np.testing.assert_allclose(
        np.rad2deg(
            single_imu_range(np.deg2rad([5, 7, 10, 0]), np.deg2rad([0, 0, 0, 7]), SUZUKI_ET4D)[1]
        ),
        [54.0, 48.9, 43.2, 51.7],
        atol=0.05,
    )


def test_mirror_reads_the_same_and_is_its_own_mirror():
    pitch, roll, steering, throttle = poses()
    body = body_specific_force(pitch, roll)
    other = mirror_angles(body, steering, throttle, SUZUKI_ET4D)
    np.testing.assert_allclose(
        lever_acceleration(body, *other, SUZUKI_ET4D),
        lever_acceleration(body, steering, throttle, SUZUKI_ET4D),
        atol=1e-13,
    )
    again = mirror_angles(body, *other, SUZUKI_ET4D)
    np.testing.assert_allclose(wrap_angle(np.subtract(again, (steering, throttle))), 0, atol=1e-12)


def test_saturated_and_unknown_are_said():
    s = sensitivities(np.deg2rad(7), 0.0, np.deg2rad(50), 0.0, SUZUKI_ET4D, imus="single")
    assert np.isnan(s.lever_bias).all()
    with pytest.raises(InputError, match="imus = 'both'"):
        sensitivities(0.0, 0.0, 0.0, 0.0, SUZUKI_ET4D, imus="both")


def test_worst_cost_of_a_tilt_is_at_a_lock_or_infinite():
    """Level: hypot(K1, K2) / K2 at a lock. Nose down by 15 deg and leaning, K2 = 0 on the way."""
    lock = np.deg2rad(70)
    body = body_specific_force(np.deg2rad([0.0, -15.0]), np.deg2rad([0.0, 8.0]))
    cost = worst_error_per_tilt(body, SUZUKI_ET4D, lock_rad=lock)
    assert cost[0] == pytest.approx(steering_error_per_tilt(body[0], lock, SUZUKI_ET4D))
    alpha = SUZUKI_ET4D.steering_inclination_rad
    k2 = np.sin(alpha) * np.cos(lock)
    assert cost[0] == pytest.approx(np.hypot(np.cos(alpha), k2) / k2)
    assert np.isinf(cost[1])
    with pytest.raises(InputError, match="lock_rad = 0"):
        worst_error_per_tilt(body, SUZUKI_ET4D, lock_rad=0)


@pytest.mark.parametrize("roll_deg", [-6.0, -1.0, 4.0])
def test_worst_cost_of_a_tilt_is_the_largest_of_all_steering_angles(roll_deg):
    """Leaning to either side, where one lock is worse than the other."""
    lock, body = np.deg2rad(50), body_specific_force(0.0, np.deg2rad(roll_deg))
    each = steering_error_per_tilt(
        np.tile(body, (101, 1)), np.linspace(-lock, lock, 101), SUZUKI_ET4D
    )
    assert each[0] != pytest.approx(each[-1], rel=0.05)
    assert worst_error_per_tilt(body, SUZUKI_ET4D, lock_rad=lock) == pytest.approx(each.max())
