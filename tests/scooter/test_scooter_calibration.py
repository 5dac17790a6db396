"""Scooter, calibration: what parked poses show of the mounts, and what they cannot."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter.calibration import (
    ParkedPose,
    find_stills,
    mount_from_poses,
    parked_poses,
)
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.simulation.scooter import (
    draw_scooter,
    simulate_parked,
)
from mobility_imu.simulation.sensor import IDEAL

POSES = [tuple(np.deg2rad(p)) for p in ((50, 0), (50, 40), (0, 40), (0, 0), (-50, 0), (-50, 40))]


def test_calibration_finds_what_gravity_shows():
    """Ideal sensors, exact stops, three attitudes: the mounting itself comes out."""
    unit = draw_scooter(3)
    poses = []
    for k, (pitch, bank) in enumerate(((0, 0), (8, 0), (0, 8))):
        parked = simulate_parked(
            POSES,
            pitch_rad=np.deg2rad(pitch),
            bank_rad=np.deg2rad(bank),
            seed=k,
            unit=unit,
            sensor=IDEAL,
            stop_sd_rad=0.0,
        )
        poses += parked_poses(parked, POSES)
    # Nothing but rounding is left, so the prior may be as weak as one likes.
    found = mount_from_poses(poses, SUZUKI_ET4D, prior_sd_rad=1e3).mount
    for matrix, tilt in (
        (found.rotation_lever_imu_to_lever, unit.lever_mounting),
        (found.rotation_body_imu_to_body, unit.body_mounting),
    ):
        apart = Rotation.from_matrix(matrix) * Rotation.from_rotvec(tilt).inv()
        assert apart.magnitude() < 1e-6


def test_level_ground_does_not_show_the_heading_of_the_body_imu():
    parked = simulate_parked(POSES, pitch_rad=0.0, bank_rad=0.0, seed=1, unit=draw_scooter(1))
    mounting = mount_from_poses(parked_poses(parked, POSES), SUZUKI_ET4D)
    assert mounting.unseen == ("body IMU about z",)


def test_stills_are_found_one_per_pose():
    parked = simulate_parked(POSES, pitch_rad=0.0, bank_rad=0.0, seed=1)
    stills = find_stills(parked)
    assert len(stills) == len(POSES)
    for k, still in enumerate(stills):
        assert (
            3.0 * k - 0.2 <= parked.time_s[still.start] < parked.time_s[still.stop] <= 3 * k + 2.3
        )
    with pytest.raises(InputError, match=r"6 still intervals .* expected 5"):
        parked_poses(parked, POSES[:5])


@pytest.mark.parametrize(("held", "found"), [(98, 1), (99, 2)])
@pytest.mark.parametrize("rate_hz", [100, 50])
def test_a_pose_that_is_held_too_short_is_none_late_in_a_recording_too(held, found, rate_hz):
    """Rest, then a hold of about a second between two moves.

    The mean over a fifth of a second takes 19 of 100 samples per second off a hold; of the rest
    0.8 s are asked for.
    """
    if rate_hz == 50:
        held = {98: 48, 99: 49}[held]  # the mean takes 9 of 50
    still, moving = np.zeros((400, 3)), np.ones((50, 3))
    gyr = np.concatenate([still, moving, still[:held], moving])
    acc = np.tile([0.0, 0.0, 9.8], (len(gyr), 1))
    sensors = {"lever": Imu(acc, gyr)}
    stills = find_stills(Recording(np.arange(len(gyr)) / rate_hz, sensors))
    assert len(stills) == found
    if found == 2:
        assert 450 < stills[1].start < stills[1].stop < 450 + held


def test_too_few_poses():
    pose = ParkedPose(np.array([0, 0, 9.8]), np.array([0, 0, 9.8]), 0.0, 0.0)
    with pytest.raises(InputError, match="at least three poses"):
        mount_from_poses([pose] * 4, SUZUKI_ET4D)


def test_mounting_file(tmp_path):
    path = tmp_path / "g.toml"
    path.write_text("[scooter]\nsteering_inclination_deg = 20\n")
    assert ScooterMount.in_toml(path) is None
    with pytest.raises(InputError, match=r"no section \[scooter.mount\]"):
        ScooterMount.from_toml(path)
    path.write_text("[scooter.mount]\nrotation_lever_imu_to_lever = [[1, 0], [0, 1]]\n")
    with pytest.raises(InputError, match="expected 3 x 3 numbers"):
        ScooterMount.from_toml(path)


def moved(parts, rate_hz=100):
    """Recording of a level lever whose gyroscope reads each value about x for some seconds."""
    gyr = np.concatenate([np.outer(np.atleast_1d(v) * np.ones(n), [1, 0, 0]) for v, n in parts])
    acc = np.tile([0.0, 0.0, 9.8], (len(gyr), 1))
    return Recording(np.arange(len(gyr)) / rate_hz, {"lever": Imu(acc, gyr)})


def test_a_tenth_of_a_second_beside_every_move_is_left_out():
    """At both ends, beyond what the mean over a fifth of a second takes."""
    (still,) = find_stills(moved([(1.0, 100), (0.0, 200), (1.0, 99)]))
    assert 118 <= still.start <= 122 and 278 <= still.stop <= 282


@pytest.mark.parametrize(("rate_radps", "rests"), [(0.02, True), (0.028, True), (0.032, False)])
def test_a_pose_rests_below_three_hundredths_of_a_radian_per_second(rate_radps, rests):
    """A lever that trembles forth and back from one sample to the next."""
    tremble = rate_radps * np.where(np.arange(300) % 2, 1.0, -1.0)
    assert bool(find_stills(moved([(tremble, 300)]))) == rests


@pytest.mark.parametrize(
    "given", [[0.1, 0.2], [[0.1, 0.2, 0.3]], [[[0.1, 0.2]]], [[0.1, np.inf]], [[np.nan, 0.1]]]
)
def test_settings_that_are_no_pairs_of_angles_are_refused(given):
    with pytest.raises(InputError, match="two finite numbers"):
        parked_poses(moved([(0.0, 300)]), given)


@pytest.mark.parametrize("vector", [[0.0, 0.0], np.eye(3), [0.0, 0.0, np.nan]])
@pytest.mark.parametrize("name", ["lever_acc_mps2", "body_acc_mps2"])
def test_a_pose_has_one_vector_of_each_sensor(name, vector):
    usual = {"lever_acc_mps2": [0.0, 0.0, 9.8], "body_acc_mps2": [0.0, 0.0, 9.8]}
    with pytest.raises(InputError, match=name):
        ParkedPose(**{**usual, name: vector}, steering_rad=0.0, throttle_rad=0.0)


def error_of_a_calibration(faults, pose_sd=0.01, prior_sd=0.05):
    """Turns that a calibration errs by, with faults in units of their standard deviations.

    ``faults``: mount of lever and body (6); stops 50, 0, -50, then 0 and 40 degrees (5); bias and
    axes of both accelerometers (2 x 12): 0.5 % of gravity, 0.3 % and 0.2 deg.
    """
    mounts, stops, sensors = np.split(np.asarray(faults, float), [6, 11])
    turns = prior_sd * mounts.reshape(2, 3)
    there = np.tile(POSES, (2, 1))
    held = there + pose_sd * np.column_stack(
        [stops[[0, 0, 1, 1, 2, 2] * 2], stops[[3, 4, 4, 3, 3, 4] * 2]]
    )
    body = np.array([body_specific_force(pitch, 0.0) for pitch in np.repeat([0.0, 0.1], 6)])
    axes = np.where(np.eye(3) > 0, 0.003, np.deg2rad(0.2))
    seen = []
    for force, turn, sensor in zip(
        (lever_acceleration(body, *held.T, SUZUKI_ET4D), body),
        turns,
        sensors.reshape(2, 12),
        strict=True,
    ):
        read = force @ Rotation.from_rotvec(turn).as_matrix()
        read = read @ (np.eye(3) + axes * sensor[3:].reshape(3, 3)).T
        seen.append(read + 0.005 * sensor[:3] * np.linalg.norm(body[0]))
    poses = [ParkedPose(*vectors, *pose) for *vectors, pose in zip(*seen, there, strict=True)]
    found = mount_from_poses(poses, SUZUKI_ET4D, pose_sd_rad=pose_sd, prior_sd_rad=prior_sd)
    rotations = found.mount.rotation_lever_imu_to_lever, found.mount.rotation_body_imu_to_body
    off = [
        (Rotation.from_matrix(r) * Rotation.from_rotvec(t).inv()).as_rotvec()
        for r, t in zip(rotations, turns, strict=True)
    ]
    return np.ravel(off), found


def test_the_deviation_of_a_mount_is_the_root_of_the_sum_of_each_fault_by_itself():
    """A stop is off in all poses that use it, a sensor in all: each fault counts once."""
    step = 1e-3
    none, found = error_of_a_calibration(np.zeros(35))
    each = [(error_of_a_calibration(fault)[0] - none) / step for fault in step * np.eye(35)]
    assert np.sqrt(np.square(each).sum(axis=0)) == pytest.approx(found.sd_rad, rel=0.01)
    assert np.abs(none).max() < 1e-9 and found.unseen == ()
    assert found.pose_sd_rad == 0.01 and found.prior_sd_rad == 0.05


def test_directions_are_unseen_from_four_fifths_of_the_prior_on():
    """On one slope with a weak prior the body's heading keeps the prior's deviation."""
    acc = body_specific_force(0.0, 0.0)
    level = [ParkedPose(lever_acceleration(acc, *pose, SUZUKI_ET4D), acc, *pose) for pose in POSES]
    for prior_sd in (0.02, 0.05, 0.2):
        found = mount_from_poses(level, SUZUKI_ET4D, prior_sd_rad=prior_sd)
        unseen = found.sd_rad > 0.8 * prior_sd
        names = [f"{which} IMU about {axis}" for which in ("lever", "body") for axis in "xyz"]
        assert found.unseen == tuple(np.array(names)[unseen]) and unseen[5]
        assert len(found.warnings) == unseen.sum()
