"""Scooter: what must hold of the geometry, of both forms of the angles, and of Table 1."""

from __future__ import annotations

import os
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import optimize

from mobility_imu.errors import InputError
from mobility_imu.frames import wrap_angle
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.scooter.static_table import (
    compare_static_table,
    static_subtraction,
    static_table,
)
from mobility_imu.scooter import SUZUKI_ET4D, ScooterGeometry, estimate_angles
from mobility_imu.scooter.angles import (
    angle_standard_deviations,
    steering_angle,
    three_axis_angles,
    throttle_angle,
)
from mobility_imu.scooter.geometry import (
    body_specific_force,
    lever_acceleration,
    rotation_lever_base_to_steering,
    rotation_lever_to_body,
    rotation_lever_to_lever_base,
    rotation_steering_column_to_body,
    rotation_steering_to_column,
)

G = 9.80665
MILLI_G = G / 1000
LEVEL = np.array([0.0, 0.0, G])
ALPHA, BETA = SUZUKI_ET4D.steering_inclination_rad, SUZUKI_ET4D.lever_inclination_rad


def rad(*degrees):
    values = [np.deg2rad(value) for value in degrees]
    return values if len(values) > 1 else values[0]


def parts(body, steering_rad, geometry=SUZUKI_ET4D):
    """Give ax_B, C1, K1, K2, written out here a second time."""
    alpha = geometry.steering_inclination_rad
    x, y, z = np.moveaxis(np.asarray(body, float), -1, 0)
    c1, k1 = y * np.cos(alpha) + z * np.sin(alpha), z * np.cos(alpha) - y * np.sin(alpha)
    return x, c1, k1, c1 * np.cos(steering_rad) - x * np.sin(steering_rad)


def whole_domain():
    """Body's force and true angles over the range of the controls and slopes to 10 deg."""
    axes = rad(np.linspace(-50, 50, 21), np.linspace(0, 40, 9), np.linspace(-10, 10, 9))
    steering, throttle, pitch, roll = (
        grid.ravel() for grid in np.meshgrid(axes[0], axes[1], axes[2], axes[2], indexing="ij")
    )
    return body_specific_force(pitch, roll), steering, throttle


# --- geometry -------------------------------------------------------------------------------


def test_each_rotation_does_what_its_frame_says():
    x, y, z = np.eye(3)
    # The shaft leans back: its upper end points to the rider.
    np.testing.assert_allclose(
        rotation_steering_column_to_body(ALPHA) @ z, [0, -np.sin(ALPHA), np.cos(ALPHA)]
    )
    # Steering left carries the wheel's forward axis to the left, which is -x.
    assert (rotation_steering_to_column(rad(10)) @ y)[0] < 0
    # At rest the lever's y axis points up by beta, whatever alpha is.
    at_rest = rotation_lever_to_body(0.0, 0.0, SUZUKI_ET4D)
    np.testing.assert_allclose(at_rest @ y, [0, np.cos(BETA), np.sin(BETA)], atol=1e-15)
    # Pushing the lever tips its z axis forward, about the lever's own x axis.
    pushed = rotation_lever_to_lever_base(rad(10))
    assert (pushed @ z)[1] > 0
    np.testing.assert_allclose(pushed @ x, x)


@pytest.mark.parametrize("shape", [(), (1,), (4,), (2, 3), (0,)])
def test_rotations_keep_the_shape_of_their_angles(shape):
    angle = np.linspace(-1, 1, int(np.prod(shape))).reshape(shape)
    for rotation in (
        rotation_steering_column_to_body(angle),
        rotation_steering_to_column(angle),
        rotation_lever_base_to_steering(angle, 0.1),
        rotation_lever_to_lever_base(angle),
    ):
        assert rotation.shape == (*shape, 3, 3)
        unit = np.broadcast_to(np.eye(3), rotation.shape)
        np.testing.assert_allclose(rotation @ np.swapaxes(rotation, -1, -2), unit, atol=1e-15)


def test_the_lever_reads_as_much_as_the_body():
    body, steering, throttle = whole_domain()
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    np.testing.assert_allclose(np.linalg.norm(lever, axis=-1), G, rtol=1e-14)


def test_chain_broadcasts():
    steering = rad(np.zeros((5, 1)))
    throttle = rad(np.zeros(4))
    assert lever_acceleration(LEVEL, steering, throttle, SUZUKI_ET4D).shape == (5, 4, 3)


def test_specific_force_on_slopes_points_up_the_slope():
    assert body_specific_force(rad(5), 0.0)[1] == pytest.approx(G * np.sin(rad(5)))  # nose up
    assert body_specific_force(0.0, rad(5))[0] == pytest.approx(G * np.sin(rad(5)))  # right up
    assert body_specific_force(rad(np.zeros((3, 1))), rad(np.zeros(2))).shape == (3, 2, 3)
    assert body_specific_force(0.1, 0.2, 1.0) @ body_specific_force(0.1, 0.2, 1.0) == (
        pytest.approx(1.0)
    )


@pytest.mark.parametrize(
    ("alpha", "beta", "words"),
    [
        (20.0, 0.1, ["steering_inclination_rad = 20", "degrees"]),
        (0.3, 9.0, ["lever_inclination_rad = 9", "degrees"]),
        (0.0, 0.1, ["steering_inclination_rad = 0", "vertical"]),
        (-0.3, 0.1, ["steering_inclination_rad = -0.3", "expected between"]),
        (1.56, 0.1, ["steering_inclination_rad = 1.56"]),
        (float("nan"), 0.1, ["steering_inclination_rad = nan: expected a number"]),
        (0.3, float("inf"), ["lever_inclination_rad = inf: expected a number"]),
        (0.3, "much", ["lever_inclination_rad", "'much'"]),
        (0.3, "0.1", ["lever_inclination_rad", "'0.1'"]),
        (0.3, -1.6, ["lever_inclination_rad = -1.6"]),
    ],
)
def test_impossible_geometry_is_refused(alpha, beta, words):
    with pytest.raises(InputError) as caught:
        ScooterGeometry(alpha, beta)
    for word in words:
        assert word in str(caught.value)


def test_degrees_that_are_radians_are_noticed():
    with pytest.raises(InputError, match=r"steering_inclination_deg = 0\.349.*radians"):
        ScooterGeometry.from_degrees(0.349, 0.157)
    with pytest.raises(InputError, match="lever_inclination_deg = 95"):
        ScooterGeometry.from_degrees(20, 95)


def test_geometry_from_a_file(tmp_path):
    path = tmp_path / "g.toml"
    path.write_text("[scooter]\nsteering_inclination_deg = 20\nlever_inclination_deg = 9.0\n")
    assert ScooterGeometry.from_toml(path) == SUZUKI_ET4D
    path.write_text("[scooter]\nsteering_inclination_deg = 0.35\nlever_inclination_deg = 9.0\n")
    with pytest.raises(InputError, match=r"g\.toml, \[scooter\]: steering_inclination_deg = 0\.35"):
        ScooterGeometry.from_toml(path)
    path.write_text("[scooter]\nsteering_inclination_deg = 20\n")
    with pytest.raises(InputError, match="lever_inclination_deg is missing"):
        ScooterGeometry.from_toml(path)


@given(
    alpha=st.floats(0.0351, 1.535),
    beta=st.floats(-1.57, 1.57),
)
def test_a_geometry_that_was_written_is_the_same_again(alpha, beta):
    geometry = ScooterGeometry(alpha, beta)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "g.toml"
        assert geometry.to_toml(path) == path.read_text()
        again = ScooterGeometry.from_toml(path)
    # Not every angle in radians has one in degrees that gives all its bits again.
    assert again.steering_inclination_rad == pytest.approx(alpha, rel=3e-16, abs=0)
    assert again.lever_inclination_rad == pytest.approx(beta, rel=3e-16, abs=0)


def test_what_was_written_needs_no_more_digits_than_it_had(tmp_path):
    text = "[scooter]\nsteering_inclination_deg = 20\nlever_inclination_deg = 9.123456789\n"
    path = tmp_path / "g.toml"
    path.write_text(text)
    assert ScooterGeometry.from_toml(path).to_toml() == text


def test_a_geometry_is_written_whole_or_not_at_all(tmp_path):
    """Into a folder, or a file that is not there: a sentence, and nothing of the file is lost."""
    with pytest.raises(InputError, match="is a folder"):
        SUZUKI_ET4D.to_toml(tmp_path)
    with pytest.raises(InputError, match="no such folder to write"):
        SUZUKI_ET4D.to_toml(tmp_path / "none" / "g.toml")
    path = tmp_path / "g.toml"
    path.write_text("before")
    os.chmod(path, 0o600)
    SUZUKI_ET4D.to_toml(path)
    assert ScooterGeometry.from_toml(path) == SUZUKI_ET4D
    assert path.stat().st_mode & 0o777 == 0o600 and list(tmp_path.iterdir()) == [path]


# --- angles ---------------------------------------------------------------------------------


def test_both_forms_invert_the_chain_over_the_whole_domain():
    # d asin(s) / ds = 1 / cos(u): towards |u| = 90 deg rounding grows without bound, so 1 deg is
    # left free. There 1e-16 x 57 x (the chain's few roundings) stays below 1e-13 rad.
    body, steering, throttle = whole_domain()
    x, c1, k1, k2 = parts(body, steering)
    clear = np.abs(steering + np.arctan2(x, c1)) < rad(89)
    assert 0.99 < clear.mean() < 1  # the margin costs the corners of the domain only
    assert (c1 > 0).all() and (k1 > 0).all()
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)

    ours = three_axis_angles(lever[clear], body[clear], SUZUKI_ET4D)
    printed_steering = steering_angle(lever, body, SUZUKI_ET4D)
    printed_throttle = throttle_angle(lever, body, printed_steering, SUZUKI_ET4D)
    for estimate, truth in zip(ours, (steering[clear], throttle[clear]), strict=True):
        np.testing.assert_allclose(estimate, truth, rtol=0, atol=1e-12)
    np.testing.assert_allclose(printed_steering[clear], steering[clear], rtol=0, atol=1e-12)
    np.testing.assert_allclose(printed_throttle[clear], throttle[clear], rtol=0, atol=1e-12)
    # Valid means an arm of sin(2 deg) or more: all of the domain but the same corners.
    valid = estimate_angles(lever, body, SUZUKI_ET4D).valid
    assert valid[np.abs(k2) > 0.035 * G].all() and not valid[np.abs(k2) < 0.0348 * G].any()
    assert 0.98 < valid.mean() < 1


angles_deg = st.floats(-180, 180)
scooters = st.builds(ScooterGeometry.from_degrees, st.floats(5, 60), st.floats(-60, 60))


@given(scooters, st.floats(-70, 70), st.floats(-70, 70), angles_deg, angles_deg, st.floats(0.1, 9))
def test_three_axis_form_is_exact_for_any_scooter_and_attitude(
    geometry, pitch_deg, roll_deg, steering_deg, throttle_deg, scale
):
    pitch, roll, steering, throttle = rad(pitch_deg, roll_deg, steering_deg, throttle_deg)
    body = body_specific_force(pitch, roll, gravity_mps2=1.0)
    _, c1, _, k2 = parts(body, steering, geometry)
    # The solution nearer to straight ahead, and an arm of 0.03 g: an error of 1e-16 in an
    # acceleration grows by 1 / 0.03 in an angle, and again as much through the square root.
    assume(k2 * c1 > 0 and min(abs(k2), abs(c1)) > 0.03)
    lever = lever_acceleration(body, steering, throttle, geometry)
    steering_est, throttle_est = three_axis_angles(scale * lever, body, geometry)
    assert abs(wrap_angle(steering_est - steering)) < 1e-11
    assert abs(wrap_angle(throttle_est - throttle)) < 1e-11


@given(scooters, st.floats(-10, 10), st.floats(-10, 10), st.floats(-50, 50), st.floats(0, 40))
def test_printed_form_equals_three_axis_form_in_its_branches(
    geometry, pitch_deg, roll_deg, steering_deg, throttle_deg
):
    pitch, roll, steering, throttle = rad(pitch_deg, roll_deg, steering_deg, throttle_deg)
    body = body_specific_force(pitch, roll)
    lever = lever_acceleration(body, steering, throttle, geometry)
    _, c1, k1, k2 = parts(body, steering, geometry)
    assume(c1 > 0.3 and k1 > 0.3 and k2 > 0.3 and lever[2] > 0.3)
    printed = estimate_angles(lever, body, geometry, form="printed")
    ours = estimate_angles(lever, body, geometry)
    assert printed.steering_rad == pytest.approx(ours.steering_rad, abs=1e-11)
    assert printed.throttle_rad == pytest.approx(ours.throttle_rad, abs=1e-11)


def test_throttle_and_attitude_do_not_leak_into_steering_nor_back():
    # With perfect sensors, what one control does leaves the estimate of the other alone.
    steering, throttle = rad(np.array([-40, 0, 40])), rad(np.array([0, 20, 40]))
    lever = lever_acceleration(LEVEL, steering[:, None], throttle, SUZUKI_ET4D)
    angles = estimate_angles(lever, None, SUZUKI_ET4D)
    np.testing.assert_allclose(angles.steering_rad, np.broadcast_to(steering[:, None], (3, 3)))
    np.testing.assert_allclose(angles.throttle_rad, np.broadcast_to(throttle, (3, 3)), atol=1e-14)


def test_a_common_scale_cancels_and_the_three_axis_form_needs_no_common_scale():
    rng = np.random.default_rng(7)
    body = body_specific_force(*rad(rng.uniform(-8, 8, 50), rng.uniform(-8, 8, 50)))
    lever = lever_acceleration(
        body, *rad(rng.uniform(-40, 40, 50), rng.uniform(0, 40, 50)), SUZUKI_ET4D
    )
    printed = steering_angle(lever, body, SUZUKI_ET4D)
    np.testing.assert_allclose(steering_angle(3 * lever, 3 * body, SUZUKI_ET4D), printed)
    ours = three_axis_angles(lever, body, SUZUKI_ET4D)
    np.testing.assert_allclose(three_axis_angles(1.02 * lever, 0.97 * body, SUZUKI_ET4D), ours)
    assert np.abs(steering_angle(1.02 * lever, body, SUZUKI_ET4D) - printed).max() > rad(0.5)


def test_turning_scooter_and_ground_together_changes_nothing():
    # Heading is not in gravity: any yaw of the whole scooter gives the same readings.
    pitch, roll = rad(6, -4)
    up = rotation_steering_to_column(rad(73)) @ [0, 0, G]
    np.testing.assert_allclose(up, LEVEL)
    body = body_specific_force(pitch, roll)
    lever = lever_acceleration(body, *rad(25, 15), SUZUKI_ET4D)
    angles = estimate_angles(lever, body, SUZUKI_ET4D)
    np.testing.assert_allclose(np.rad2deg([angles.steering_rad, angles.throttle_rad]), [25, 15])


@pytest.mark.parametrize(
    ("true_deg", "mirror_deg"), [((0, 20), (180, -20)), ((50, 40), (130, 13.66))]
)
def test_a_mirror_solution_gives_the_same_acceleration(true_deg, mirror_deg):
    steering, throttle = rad(*true_deg)
    _, _, k1, k2 = parts(LEVEL, steering)
    other = np.pi - steering, throttle - 2 * np.arctan2(k2, k1)
    np.testing.assert_allclose(np.rad2deg(other), mirror_deg, atol=0.005)
    np.testing.assert_allclose(
        lever_acceleration(LEVEL, *other, SUZUKI_ET4D),
        lever_acceleration(LEVEL, steering, throttle, SUZUKI_ET4D),
        atol=1e-13,
    )
    # Neither form can know better, and neither flag says so.
    for form in ("corrected", "printed"):
        angles = estimate_angles(
            lever_acceleration(LEVEL, *other, SUZUKI_ET4D), None, SUZUKI_ET4D, form=form
        )
        np.testing.assert_allclose(np.rad2deg(angles.steering_rad), true_deg[0], atol=1e-9)
        assert angles.valid


def test_downhill_steeper_than_the_shaft_the_printed_form_turns_the_wrong_way():
    body = body_specific_force(rad(-26), 0.0)  # C1 < 0: also braking at 4.8 m/s² on the level
    lever = lever_acceleration(body, *rad(30, 10), SUZUKI_ET4D)
    printed = estimate_angles(lever, body, SUZUKI_ET4D, form="printed")
    ours = estimate_angles(lever, body, SUZUKI_ET4D)
    assert np.rad2deg(printed.steering_rad) == pytest.approx(-30)
    assert not printed.valid
    np.testing.assert_allclose(np.rad2deg([ours.steering_rad, ours.throttle_rad]), [30, 10])
    assert ours.valid


@pytest.mark.parametrize(
    ("pitch_deg", "roll_deg", "limit_deg"),
    [(5, 0, 54.0), (7, 0, 48.9), (10, 0, 43.2), (0, 5, 62.2), (0, 7, 51.7), (0, 10, 37.2)],
)
def test_a_single_imu_saturates_on_a_slope(pitch_deg, roll_deg, limit_deg):
    body = body_specific_force(*rad(pitch_deg, roll_deg))
    steering = rad(np.arange(0, 80, 0.01))
    lever = lever_acceleration(body, steering, 0.0, SUZUKI_ET4D)
    printed = estimate_angles(lever, None, SUZUKI_ET4D, form="printed")
    last_deg = np.rad2deg(steering[np.isfinite(printed.steering_rad)].max())
    assert last_deg == pytest.approx(limit_deg, abs=0.06)
    # The three-axis form answers 90 deg there, and says that it is not to be trusted.
    ours = estimate_angles(lever, None, SUZUKI_ET4D)
    beyond = np.isnan(printed.steering_rad)
    np.testing.assert_allclose(ours.steering_rad[beyond], np.pi / 2)
    assert not ours.valid[beyond].any()
    assert ours.valid[np.rad2deg(steering) < limit_deg - 5].all()


@pytest.mark.parametrize(
    ("body", "steering_deg", "why"),
    [
        (body_specific_force(rad(-20), 0.0), 20, "acceleration along the shaft: r = 0"),
        (body_specific_force(rad(-19), 0.0), 20, "acceleration 1 deg from the shaft"),
        (LEVEL, 90, "K2 = 0"),
        (LEVEL, 85, "K2 = 0.03 g"),
        (body_specific_force(0.0, rad(20)), 43.2, "K2 = 0 on a side slope"),
    ],
)
@pytest.mark.parametrize("form", ["corrected", "printed"])
def test_unobservable_steering_is_flagged(body, steering_deg, why, form):
    lever = lever_acceleration(body, *rad(steering_deg, 10), SUZUKI_ET4D)
    assert not estimate_angles(lever, body, SUZUKI_ET4D, form=form).valid, why


def test_unobservable_throttle_is_flagged():
    # Lying on its side the scooter feels gravity along the lever's axis: no throttle angle.
    body = body_specific_force(0.0, rad(88))
    lever = lever_acceleration(body, 0.0, rad(10), SUZUKI_ET4D)
    assert not estimate_angles(lever, body, SUZUKI_ET4D).valid


def test_a_vertical_shaft_hides_the_steering():
    # Counter-example to section 2.2: the axes differ, yet one steering angle is like another.
    lever = [
        rotation_lever_base_to_steering(0.0, BETA).T
        @ rotation_steering_to_column(rad(steering)).T
        @ LEVEL
        for steering in (-50, 0, 50)
    ]
    np.testing.assert_allclose(lever, [lever[0]] * 3, atol=1e-15)


def test_missing_samples_stay_missing_and_alone():
    lever = np.tile(lever_acceleration(LEVEL, *rad(10, 5), SUZUKI_ET4D), (3, 1))
    lever[1, 2] = np.nan
    lever[2] = 0.0
    with np.errstate(all="raise"):
        angles = estimate_angles(lever, None, SUZUKI_ET4D)
    assert angles.valid.tolist() == [True, False, False]
    assert np.isnan(angles.throttle_rad[1])
    frame = angles.to_frame()
    assert frame.columns.tolist() == ["steering_deg", "throttle_deg", "valid"]
    assert frame["steering_deg"][0] == pytest.approx(10)
    assert estimate_angles(np.empty((0, 3)), None, SUZUKI_ET4D).valid.shape == (0,)
    assert not estimate_angles(np.full((2, 3), np.nan), None, SUZUKI_ET4D).valid.any()


@pytest.mark.parametrize(
    ("lever", "body", "words"),
    [
        (np.ones((4, 2)), None, "lever_acc_mps2: expected three components"),
        (np.ones((4, 3)), np.ones((4, 4)), "body_acc_mps2: expected three components"),
        (np.ones((4, 3)), np.ones((5, 3)), "same number of samples"),
        ([["a", "b", "c"]], None, "expected real numbers"),
        ([[0.1, 0.2, 0.97]], None, "is it in g"),
        ([[1.0, 2.0, 9.5]], [[0.0, 0.0, 1.0]], "is it in g"),
        ([[-1.0, -2.0, -9.5]], None, "sign is flipped"),
        ([[1.0, 2.0, 9.5]], [[0.0, 0.0, -9.8]], "body_acc_mps2: the median z is -9.8"),
        ([[-1.0, -2.0, -9.5]], [[0.0, 0.0, 9.8]], "lever_acc_mps2: the median"),
    ],
)
def test_bad_input_is_refused(lever, body, words):
    with pytest.raises(InputError, match=words):
        estimate_angles(lever, body, SUZUKI_ET4D)


@pytest.mark.parametrize("geometry", [None, "ET4D", (0.35, 0.16), ScooterGeometry])
@pytest.mark.parametrize(
    "work",
    [
        lambda geometry: estimate_angles([LEVEL], None, geometry),
        lambda geometry: steering_angle(LEVEL, LEVEL, geometry),
        lambda geometry: throttle_angle(LEVEL, LEVEL, 0.0, geometry),
        lambda geometry: three_axis_angles(LEVEL, LEVEL, geometry),
        lambda geometry: lever_acceleration(LEVEL, 0.0, 0.0, geometry),
        lambda geometry: angle_standard_deviations(LEVEL, 0.0, 0.0, geometry, lever_sd_mps2=0.02),
    ],
)
def test_what_is_no_geometry_is_refused(work, geometry):
    with pytest.raises(InputError, match=r"geometry: got .*, expected ScooterGeometry"):
        work(geometry)


@pytest.mark.parametrize("name", ["steering_rad", "throttle_rad"])
def test_angles_that_are_none_have_no_standard_deviation(name):
    angles = {"steering_rad": 0.0, "throttle_rad": 0.0, name: "0.1"}
    with pytest.raises(InputError, match=f"{name}: expected real numbers, got text"):
        angle_standard_deviations(LEVEL, **angles, geometry=SUZUKI_ET4D, lever_sd_mps2=0.02)


def test_unknown_form_is_refused():
    with pytest.raises(InputError, match=r"form = 'closed'.*corrected"):
        estimate_angles([LEVEL], None, SUZUKI_ET4D, form="closed")


def test_sign_check_lets_every_position_of_the_controls_pass():
    body, steering, throttle = whole_domain()
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    for k in np.linspace(0, len(lever) - 1, 200).astype(int):
        estimate_angles(lever[k], body[k], SUZUKI_ET4D)
        estimate_angles(lever[k], None, SUZUKI_ET4D)


def test_three_axis_form_is_the_least_squares_solution():
    rng = np.random.default_rng(2022)
    n = 60
    body = body_specific_force(*rad(rng.uniform(-10, 10, n), rng.uniform(-10, 10, n)))
    truth = np.column_stack(rad(rng.uniform(-50, 50, n), rng.uniform(0, 40, n)))
    noise = rng.normal(0, 50 * MILLI_G, (n, 3))
    lever = lever_acceleration(body, truth[:, 0], truth[:, 1], SUZUKI_ET4D) + noise
    ours = np.column_stack(three_axis_angles(lever, body, SUZUKI_ET4D))

    def misfit(angles, k):
        return lever[k] - lever_acceleration(body[k], angles[0], angles[1], SUZUKI_ET4D)

    compared = 0
    for k in range(n):
        best = optimize.least_squares(misfit, truth[k], args=(k,), xtol=1e-15, ftol=1e-15)
        assert np.linalg.norm(misfit(ours[k], k)) <= np.linalg.norm(best.fun) + 1e-9
        if parts(body[k], best.x[0])[3] > 0.3:  # clear of K2 = 0, where the minimum is flat
            np.testing.assert_allclose(ours[k], best.x, atol=1e-5)
            compared += 1
    assert compared > 50


@pytest.mark.parametrize(
    ("steering_deg", "throttle_deg", "expected"),
    # degrees per milli-g; a simulation made beforehand gave 0.168, 0.191, 0.252, 0.464 for
    # steering and 0.057, 0.089 for throttle
    [
        (0, 0, (0.168, 0.057)),
        (30, 20, (0.191, None)),
        (50, 40, (0.252, 0.089)),
        (70, 0, (0.464, None)),
    ],
)
def test_sensitivity_to_noise_on_level_ground(steering_deg, throttle_deg, expected):
    lever = lever_acceleration(LEVEL, *rad(steering_deg, throttle_deg), SUZUKI_ET4D)
    sd = angle_standard_deviations(
        lever, *rad(steering_deg, throttle_deg), SUZUKI_ET4D, lever_sd_mps2=MILLI_G
    )
    for ours, theirs in zip(np.rad2deg(sd), expected, strict=True):
        if theirs is not None:
            assert ours == pytest.approx(theirs, abs=0.003)


@pytest.mark.parametrize("case_deg", [(0, 0, 0, 0), (40, 30, 7, 0), (-50, 10, -5, 5)])
def test_standard_deviations_by_monte_carlo(case_deg):
    # 20 000 draws: the sd of an sd is 0.5 %, so 2.5 % is five of them. The noise is small (2 and
    # 1 milli-g) to stay in the first order.
    rng = np.random.default_rng(11)
    steering, throttle, pitch, roll = rad(*case_deg)
    body = body_specific_force(pitch, roll)
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    sds = {"lever_sd_mps2": 2 * MILLI_G, "body_sd_mps2": MILLI_G}
    noisy_lever = lever + rng.normal(0, sds["lever_sd_mps2"], (20_000, 3))
    noisy_body = body + rng.normal(0, sds["body_sd_mps2"], (20_000, 3))
    drawn = three_axis_angles(noisy_lever, noisy_body, SUZUKI_ET4D)
    predicted = angle_standard_deviations(lever, steering, throttle, SUZUKI_ET4D, **sds)
    for samples, sd in zip(drawn, predicted, strict=True):
        assert samples.std() == pytest.approx(sd, rel=0.025)


def test_standard_deviations_are_those_of_the_normal_equations():
    body, steering, throttle = body_specific_force(*rad(4, -3)), *rad(35, 25)
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    step = 1e-6
    columns = [
        (
            lever_acceleration(body, steering + ds, throttle + dt, SUZUKI_ET4D)
            - lever_acceleration(body, steering - ds, throttle - dt, SUZUKI_ET4D)
        )
        / (2 * step)
        for ds, dt in ((step, 0.0), (0.0, step))
    ]
    h = np.column_stack(columns)
    sd = angle_standard_deviations(
        lever, steering, throttle, SUZUKI_ET4D, lever_sd_mps2=0.03, body_sd_mps2=0.04
    )
    np.testing.assert_allclose(np.square(sd), 0.05**2 * np.diag(np.linalg.inv(h.T @ h)), rtol=1e-8)


def test_standard_deviations_grow_without_bound_where_steering_is_lost():
    steering = rad(np.array([0, 60, 89.999, np.nan]))
    lever = lever_acceleration(LEVEL, np.nan_to_num(steering), 0.0, SUZUKI_ET4D)
    sd, _ = angle_standard_deviations(lever, steering, 0.0, SUZUKI_ET4D, lever_sd_mps2=MILLI_G)
    assert sd[0] < sd[1] < 1e-3 * sd[2]
    assert np.isnan(sd[3])  # no angle, no spread
    with pytest.raises(InputError, match="body_sd_mps2 = -1"):
        angle_standard_deviations(
            lever, steering, 0.0, SUZUKI_ET4D, lever_sd_mps2=MILLI_G, body_sd_mps2=-1
        )


# --- Table 1 --------------------------------------------------------------------------------


def test_table_1_matches_the_printed_cells_one_to_one():
    keys = ["row", "column", "quantity"]
    ours = static_table()
    assert len(ours) == 100
    printed = load_published("scooter_table1")
    assert set(map(tuple, ours[keys].values)) == set(map(tuple, printed[keys].values))
    assert len(compare_static_table()) == 100


def test_table_1_has_closed_forms():
    table = static_table().set_index(["row", "column", "quantity"])["value"]
    # Straight wheel: the estimate takes the whole slope for throttle.
    assert table["upward", "c", "single_mae"] == pytest.approx(5)
    # Upward slope with one IMU: sin(estimate) = sin(alpha + 5 deg) / sin(alpha) x sin(true).
    true = rad(np.array([50, 100 / 3, 50 / 3]))
    error = np.rad2deg(np.arcsin(np.sin(rad(25)) / np.sin(rad(20)) * np.sin(true)) - true)
    assert table["upward", "a", "single_mae"] == pytest.approx(2 * error.sum() / 7)
    # With both IMUs nothing remains.
    dual = table[[name.startswith("dual") for name in table.index.get_level_values("quantity")]]
    assert len(dual) == 50
    assert np.abs(dual).max() < 1e-12


def test_table_1_as_far_as_geometry_explains_it():
    both = compare_static_table()
    single = both[both["quantity"] == "single_mae"]
    near = single["difference"].abs() <= 1
    assert near.sum() == 18
    assert (near & (single["row"] != "flat")).sum() == 15
    # A table of zeros would also be near in 7 cells: they say nothing for the geometry.
    assert (single["published"] <= 1).sum() == 7


def test_the_other_slope_sign_is_refuted_by_table_1():
    both = compare_static_table(static_table(slope_rad=-rad(5)))
    single = both[both["quantity"] == "single_mae"]
    assert (single["difference"].abs() <= 1).sum() < 18


def test_which_side_is_up_geometry_cannot_tell_from_the_steering_columns():
    ours, other = static_table(), static_table(left_row_ax_sign=1)
    steering = ours["column"].isin(["a", "b"])
    np.testing.assert_allclose(ours["value"][steering], other["value"][steering], atol=1e-12)
    with pytest.raises(InputError, match="left_row_ax_sign = 0"):
        static_table(left_row_ax_sign=0)


def test_subtraction_at_rest_is_right_on_level_ground_only():
    table = static_subtraction()
    assert (table.loc["flat"] < 1e-9).all()
    assert (table.drop("flat") > 0.05).all(axis=None)
    # Nose up or down the body's x stays zero: subtraction takes nothing out of the steering.
    single = static_table().set_index(["row", "column", "quantity"])["value"]
    for row in ("upward", "downward"):
        assert table.loc[row, "a"] == pytest.approx(single[row, "a", "single_mae"])
    # On a side slope it is exact with the wheel straight, so its mean error is far smaller.
    assert table.loc["left", "a"] < 0.3 * single["left", "a", "single_mae"]


def test_a_reading_without_numbers_leaves_its_neighbours_alone():
    """A throttle near the end of the circle is wrapped, whatever stands beside it."""
    level = body_specific_force(0.0, 0.0)
    lever = lever_acceleration(level, 0.2, np.deg2rad(175), SUZUKI_ET4D)
    alone = three_axis_angles([lever], level, SUZUKI_ET4D)
    beside = three_axis_angles([lever, [np.nan] * 3], level, SUZUKI_ET4D)
    assert np.rad2deg(alone[1][0]) == pytest.approx(175)
    assert beside[0][0] == alone[0][0] and beside[1][0] == alone[1][0]
    assert np.isnan(beside[1][1])


def test_readings_without_end_give_no_warning_and_are_not_valid():
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = estimate_angles([[0, 0, 9.8], [1e200, 0, 1e200], [0, 0, 9.8]], None, SUZUKI_ET4D)
    assert found.valid.tolist() == [True, False, True]


def test_empty_and_single_readings():
    assert estimate_angles(np.zeros((0, 3)), None, SUZUKI_ET4D).to_frame().empty
    one = estimate_angles([0, 1.534, 9.686], None, SUZUKI_ET4D)
    assert one.steering_rad.shape == () and len(one.to_frame()) == 1
    for bad in ([0, 0], [["a", 0, 0]], np.ma.masked_equal([[0, 0, 9.8]], 0)):
        with pytest.raises(InputError, match="lever_acc_mps2"):
            estimate_angles(bad, None, SUZUKI_ET4D)


@pytest.mark.parametrize("name", ["lever_sd_mps2", "body_sd_mps2"])
@pytest.mark.parametrize("value", [-1, np.nan, np.inf, "1", True])
def test_noise_that_cannot_be(name, value):
    sd = {"lever_sd_mps2": 0.1, "body_sd_mps2": 0.1, name: value}
    with pytest.raises(InputError, match=name):
        angle_standard_deviations([0, 0, 9.8], 0.0, 0.0, SUZUKI_ET4D, **sd)
