"""Angles of parked poses beside a protractor's: what is stated holds, and what is wrong is seen."""

import pickle

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    PoseCheckSettings,
    ScooterGeometry,
    calibrate_mount,
    check_poses,
    estimate_angles,
    pose_uncertainty,
)
from mobility_imu.scooter.calibration import ParkedPose, mount_from_poses
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
from mobility_imu.scooter.pose_check import _judge, _means
from mobility_imu.simulation.scooter import PARKED_POSES_RAD, draw_scooter, simulate_parked

POSES = np.deg2rad([(s, t) for s in (-40, -20, 0, 20, 40) for t in (0, 20, 40)])
LIST = POSES.tolist()
IMUS = PoseCheckSettings.for_calibrated_imus()


def exact(poses=POSES, *, force=None):
    """Recording without any error; each pose rests for 2 s, with a moment of turning between."""
    each = np.repeat(np.arange(len(poses)), 200)
    body = np.tile(body_specific_force(0.0, 0.0) if force is None else force, (len(each), 1))
    lever = lever_acceleration(body, *poses[each].T, SUZUKI_ET4D)
    gyr = np.zeros_like(body)
    for k in range(1, len(poses)):
        gyr[200 * k - 5 : 200 * k + 5] = 1.0
    last_digit = 1e-5 * np.random.default_rng(1).standard_normal((2, *body.shape))
    sensors = {"lever": Imu(lever + last_digit[0], gyr), "body": Imu(body + last_digit[1], 0 * gyr)}
    return Recording(np.arange(len(each)) / 100, sensors)


@pytest.fixture(scope="module")
def checks():
    """Twelve drawn scooters with the mount that a calibration found, and without."""
    found = {True: [], False: []}
    for seed in range(12):
        unit = draw_scooter(seed)
        parked = [
            simulate_parked(pitch_rad=pitch, bank_rad=0.0, seed=100 * seed + k, unit=unit)
            for k, pitch in enumerate(np.deg2rad([0.2, 5.0]))
        ]
        mount = calibrate_mount(parked, PARKED_POSES_RAD, SUZUKI_ET4D).mount
        recording = simulate_parked(LIST, pitch_rad=0.0, bank_rad=0.0, seed=7000 + seed, unit=unit)
        for calibrated in (True, False):
            given = mount if calibrated else None
            found[calibrated].append(check_poses(recording, LIST, SUZUKI_ET4D, given, IMUS))
    return found


@pytest.mark.parametrize("calibrated", [True, False])
def test_stated_deviations_hold_on_drawn_scooters(checks, calibrated):
    """Sizes of the simulated sensors are those assumed; few scooters, whose poses share errors.

    Poses of a scooter may be all inside 95 %, or all outside: a fraction of twelve has a standard
    deviation of 6.3 %. Three of them are left; fewer than nine that agree are one draw in 500.
    """
    found = checks[calibrated]
    rms = np.sqrt(np.mean([one.rms_rad**2 for one in found], axis=0))
    stated = np.sqrt(np.mean([one.difference_sd_rad**2 for one in found], axis=(0, 1)))
    assert (stated / rms > 0.6).all() and (stated / rms < 1.7).all()
    assert 0.76 <= np.mean([one.inside for one in found])
    assert sum(one.verdict == "agrees" for one in found) >= 9


def test_a_calibration_makes_the_stated_deviation_smaller(checks):
    with_mount, without = (checks[c][0].difference_sd_rad for c in (True, False))
    assert (with_mount < without).all()


def test_sensors_that_stay_on_make_the_expected_deviation_smaller():
    """A changed offset is most of what a calibration cannot take away."""
    usual, on = (
        pose_uncertainty(POSES, SUZUKI_ET4D, settings)
        for settings in (PoseCheckSettings(), PoseCheckSettings().kept_on())
    )
    assert (on < usual).all() and (on[:, 0] < 0.5 * usual[:, 0]).all()


def test_expected_uncertainty_is_that_of_drawn_errors():
    """Turns, offsets and axes drawn at a tenth of the assumed sizes, where all is linear."""
    tenth = {
        "mount_sd_rad": 0.1 * IMUS.mount_sd_rad,
        "acc_offset_sd_mps2": 0.1 * IMUS.acc_offset_sd_mps2,
        "acc_scale_sd": 0.1 * IMUS.acc_scale_sd,
        "acc_axes_sd_rad": 0.1 * IMUS.acc_axes_sd_rad,
        "geometry_sd_rad": 0.1 * IMUS.geometry_sd_rad,
    }
    settings = PoseCheckSettings(**tenth)
    expected = pose_uncertainty(POSES, SUZUKI_ET4D, settings, calibrated=False, pitch_rad=0.03)
    rng = np.random.default_rng(5)
    axes = np.where(np.eye(3) > 0, settings.acc_scale_sd, settings.acc_axes_sd_rad)
    errors = []
    for _ in range(400):
        body = np.tile(body_specific_force(0.03, 0.0), (len(POSES), 1))
        alpha, beta = settings.geometry_sd_rad * rng.standard_normal(2)
        real = ScooterGeometry(
            SUZUKI_ET4D.steering_inclination_rad + alpha, SUZUKI_ET4D.lever_inclination_rad + beta
        )
        readings = []
        for force in (lever_acceleration(body, *POSES.T, real), body):
            turn = settings.mount_sd_rad * rng.standard_normal(3)
            seen = force - np.cross(turn, force)
            offset = settings.acc_offset_sd_mps2 * rng.standard_normal(3)
            readings.append(seen + seen @ (axes * rng.standard_normal((3, 3))).T + offset)
        found = estimate_angles(*readings, SUZUKI_ET4D)
        errors.append(np.column_stack([found.steering_rad, found.throttle_rad]) - POSES)
    # 400 draws: the rms of each is known to 3.5 %, sd; the worst of 30 is within four of these.
    assert np.allclose(np.sqrt(np.mean(np.square(errors), axis=0)) / expected, 1.0, atol=0.14)


# Steering and throttle of the stops, and slopes, that a calibration is taken to have had.
STOPS = np.deg2rad([[50, 0], [50, 40], [0, 40], [0, 0], [-50, 0], [-50, 40]])
SLOPES_RAD = np.deg2rad([0.0, 5.0])


def angles_with(errors, calibrated):
    """Angles that are found in ``POSES`` on a slope, with errors of the sizes of ``IMUS``.

    ``errors``: turns of lever's and body's IMU (6); offset and axes of both accelerometers
    (2 x 12); alpha and beta (2); the stops 50, 0 and -50, then 0 and 40 degrees (5); changes of the
    offsets since the calibration (6).
    """
    turns, of_sensors, inclinations, stops, changes = np.split(errors, [6, 30, 32, 37])
    of_sensors, turns, changes = (e.reshape(2, -1) for e in (of_sensors, turns, changes))
    real = ScooterGeometry(
        *(
            IMUS.geometry_sd_rad * inclinations
            + [SUZUKI_ET4D.steering_inclination_rad, SUZUKI_ET4D.lever_inclination_rad]
        )
    )

    def readings(body, poses, later):
        for k, force in enumerate((lever_acceleration(body, *poses.T, real), body)):
            seen = force @ Rotation.from_rotvec(IMUS.mount_sd_rad * turns[k]).as_matrix()
            sd = np.where(np.eye(3) > 0, IMUS.acc_scale_sd, IMUS.acc_axes_sd_rad)
            offset = IMUS.acc_offset_sd_mps2 * of_sensors[k, :3]
            offset = offset + later * IMUS.acc_change_sd_mps2 * changes[k]
            yield seen @ (np.eye(3) + sd * of_sensors[k, 3:].reshape(3, 3)).T + offset

    body = np.tile(body_specific_force(0.03, 0.0), (len(POSES), 1))
    lever, body = readings(body, POSES, later=calibrated)
    if calibrated:
        there = np.tile(STOPS, (2, 1))
        off = np.column_stack([stops[np.repeat([0, 1, 2], 2)], stops[[3, 4, 4, 3, 3, 4]]])
        held = there + IMUS.stop_sd_rad * np.tile(off, (2, 1))
        at = np.stack([body_specific_force(pitch, 0.0) for pitch in np.repeat(SLOPES_RAD, 6)])
        parked = [
            ParkedPose(*vectors, *pose)
            for *vectors, pose in zip(*readings(at, held, later=False), there, strict=True)
        ]
        mount = mount_from_poses(parked, SUZUKI_ET4D).mount
        lever, body = mount.lever(lever), mount.body(body)
    found = estimate_angles(lever, body, SUZUKI_ET4D)
    assert found.valid.all()
    return np.column_stack([found.steering_rad, found.throttle_rad])


@pytest.mark.parametrize("calibrated", [True, False])
def test_expected_uncertainty_is_the_root_of_the_sum_of_each_error_by_itself(calibrated):
    """One error after the other goes through calibration and angles; nothing else is assumed."""
    step = 0.001  # of one standard deviation, where all is linear
    without = angles_with(np.zeros(43), calibrated)
    each = [(angles_with(d, calibrated) - without) / step for d in step * np.eye(43)]
    expected = pose_uncertainty(POSES, SUZUKI_ET4D, IMUS, calibrated=calibrated, pitch_rad=0.03)
    assert np.sqrt(np.square(each).sum(axis=0)) == pytest.approx(expected, rel=0.01)


def test_exact_readings_agree():
    found = check_poses(exact(), LIST, SUZUKI_ET4D)
    assert np.allclose(found.found_rad, POSES, atol=1e-4) and found.inside.all()
    assert found.verdict == "agrees" and found.chi_square < 1e-3 and found.probability > 0.999
    assert "smaller than stated" in found.warnings[0]


@pytest.mark.parametrize("method", ["closed-form", "fusion"])
def test_a_steering_that_is_off_in_all_poses_differs(method):
    settings = PoseCheckSettings.for_calibrated_imus(method)
    really = (POSES + np.deg2rad([20.0, 0.0])).tolist()
    parked = simulate_parked(really, pitch_rad=0.0, bank_rad=0.0, seed=4)
    found = check_poses(parked, LIST, SUZUKI_ET4D, None, settings)
    assert found.verdict == "differs"
    assert any("steering is off by" in sentence for sentence in found.warnings)
    assert not any("throttle" in sentence for sentence in found.warnings)


def test_poses_in_another_order_differ():
    found = check_poses(exact(), LIST[::-1], SUZUKI_ET4D)
    assert found.verdict == "differs"


def test_a_pose_that_no_reading_shows_is_not_judged():
    """At 90 deg on level ground steering cannot be observed."""
    poses = np.vstack([POSES[:4], [[np.pi / 2, 0.0]]])
    found = check_poses(exact(poses), poses.tolist(), SUZUKI_ET4D)
    assert found.judged.tolist() == [True] * 4 + [False]
    assert "pose 5" in found.warnings[0] and np.isnan(found.difference_sd_rad[4]).all()
    assert found.rms_rad.max() < 1e-4 and found.chi_square < 1e-3  # of the four
    assert found.verdict == "agrees"
    few = np.vstack([POSES[:2], [[np.pi / 2, 0.0]]])
    assert check_poses(exact(few), few.tolist(), SUZUKI_ET4D).verdict == "cannot be judged"


def test_none_that_can_be_judged():
    none = np.array([[np.pi / 2, 0.0], [np.pi / 2, 0.1]])
    found = check_poses(exact(none), none.tolist(), SUZUKI_ET4D)
    assert found.verdict == "cannot be judged" and np.isnan(found.rms_rad).all()
    assert np.isnan(found.probability) and len(found.to_frame()) == 4


def test_a_slope_needs_no_name():
    """The body's IMU sees it."""
    found = check_poses(exact(force=body_specific_force(0.1, 0.05)), LIST, SUZUKI_ET4D)
    assert np.allclose(found.found_rad, POSES, atol=1e-4)


def test_the_table_has_a_row_for_each_pose_and_control():
    found = check_poses(exact(), LIST, SUZUKI_ET4D)
    table = found.to_frame()
    assert len(table) == 2 * len(POSES) and set(table["control"]) == {"steering", "throttle"}
    assert np.allclose(table["set_deg"], np.rad2deg(POSES).ravel())
    assert (table["stop_s"] > table["start_s"]).all() and (table["inside_95"] == 1).all()
    again = pickle.loads(pickle.dumps(found))
    assert again.to_frame().equals(table) and not again.found_rad.flags.writeable
    assert "\n" not in repr(found)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"parked": None}, "parked: got NoneType"),
        ({"settings_of_poses_rad": LIST[:3]}, "expected 3, one per pose"),
        ({"settings_of_poses_rad": [[0.0, np.nan]]}, "two finite"),
        ({"geometry": 0.3}, "geometry: got float"),
        ({"mount": np.eye(3)}, "mount: got ndarray"),
        ({"settings": "fusion"}, "settings: got str"),
    ],
)
def test_wrong_arguments_are_named(given, says):
    usual = {"parked": exact(), "settings_of_poses_rad": LIST, "geometry": SUZUKI_ET4D}
    with pytest.raises(InputError, match=says):
        check_poses(**(usual | given))


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"method": "magic"}, "method"),
        ({"reading_sd_rad": 0.0}, "reading_sd_rad"),
        ({"acc_offset_sd_mps2": -1.0}, "acc_offset_sd_mps2"),
        ({"mount_sd_rad": np.nan}, "mount_sd_rad"),
    ],
)
def test_wrong_settings_are_named(given, says):
    with pytest.raises(InputError, match=says):
        PoseCheckSettings(**given)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"poses_rad": [1.0, 2.0]}, "poses_rad"),
        ({"poses_rad": [[np.inf, 0.0]]}, "poses_rad"),
        ({"calibrated": "yes"}, "calibrated"),
        ({"pitch_rad": None}, "pitch_rad"),
        ({"geometry": None}, "geometry"),
    ],
)
def test_wrong_questions_on_uncertainty_are_named(given, says):
    with pytest.raises(InputError, match=says):
        pose_uncertainty(**({"poses_rad": POSES, "geometry": SUZUKI_ET4D} | given))


@pytest.mark.parametrize("judged", [[True] * 4, [True, False, True, True]])
def test_means_are_those_of_the_judged_poses_with_what_they_share(judged):
    """Own errors of 1 and a shared one of 0.5 in the steering, of 2 and 1 in the throttle."""
    judged = np.array(judged)
    difference = np.array([[1.0, 10.0], [2.0, 20.0], [4.0, 30.0], [9.0, 70.0]])
    covariance = np.diag(np.tile([1.0, 4.0], 4))
    covariance[0::2, 0::2] += 0.25
    covariance[1::2, 1::2] += 1.0
    covariance[:, ~np.repeat(judged, 2)] = covariance[~np.repeat(judged, 2)] = np.nan
    count = judged.sum()
    for (name, mean, sd), column, own, shared in zip(
        _means(difference, covariance, judged), (0, 1), (1.0, 4.0), (0.25, 1.0), strict=True
    ):
        assert name == ("steering", "throttle")[column]
        assert mean == pytest.approx(difference[judged, column].mean())
        assert sd == pytest.approx(np.sqrt(own / count + shared))


@pytest.mark.parametrize("count", [3, 6])
def test_verdicts_change_where_chance_ends(count):
    """Differences of both signs, whose squares sum up to a chi-square of two numbers a pose."""
    judged, sign = np.ones(count, bool), np.where(np.arange(count) % 2, -1.0, 1.0)
    sign = (sign - sign.mean())[:, None] * [1.0, 1.0]
    pattern = sign / np.sqrt(np.square(sign).sum())
    low, high = stats.chi2.ppf([0.005, 1 - 0.05 / 3], 2 * count)
    for square, verdict, small in (
        (0.98 * low, "agrees", True),
        (1.02 * low, "agrees", False),
        (0.98 * high, "agrees", False),
        (1.02 * high, "differs", False),
    ):
        found, warnings = _judge(np.sqrt(square) * pattern, np.eye(2 * count), judged)
        assert found == verdict and bool(warnings) == small, (square, warnings)
    # A mean is off beyond 2.4 of its standard deviations: 5 % of three tests, to both sides.
    for size, verdict in ((2.35, "agrees"), (2.43, "differs")):
        off = np.zeros((count, 2))
        off[:, 1] = -size / np.sqrt(count)
        found, warnings = _judge(off, np.eye(2 * count), judged)
        assert found == verdict
        assert [text.split(" is off")[0] for text in warnings] == ["throttle"] * (size > 2.4)
