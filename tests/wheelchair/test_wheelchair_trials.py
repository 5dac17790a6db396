"""Drives that the chapters share: what is calibrated fits what was simulated."""

import numpy as np
import pytest

from mobility_imu.reproduction.wheelchair.facing import (
    along_outward_axle,
    facing_mounting,
    forward_axles,
)
from mobility_imu.reproduction.wheelchair.trials import (
    MIDDLE,
    STRAIGHT_ON,
    TURN_LEFT,
    court_and_calibrate,
    court_tasks,
    drive_and_calibrate,
    printed_speed_and_turn,
    wheel_rates,
)
from mobility_imu.simulation.wheelchair import Leg, SlipEpisode, random_mounting
from mobility_imu.wheelchair import SAMPLE_CHAIR
from mobility_imu.wheelchair.geometry import SIDES, side_sign


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_leaning_wheel_reads_its_spin_and_a_part_of_the_turn(turn):
    legs = (Leg(1, 1.0), Leg(4, 5.0, 0.0, np.rad2deg(turn)), Leg(1, 1.0))
    drive, mount = drive_and_calibrate(legs, SAMPLE_CHAIR, random_mounting(2))
    rates = wheel_rates(drive.recording, mount)
    for side in SIDES:
        s = side_sign(side)
        spin = -s * turn * SAMPLE_CHAIR.track_m / 2 / SAMPLE_CHAIR.wheel_radius_m.of(side)
        along = spin + s * turn * np.sin(SAMPLE_CHAIR.camber_rad)
        across = abs(turn) * np.cos(SAMPLE_CHAIR.camber_rad)
        assert np.isclose(rates[side][MIDDLE, 2], along)
        assert np.isclose(np.hypot(*rates[side][MIDDLE, :2]), across)


@pytest.mark.parametrize(("facing", "sign"), [("outward", 1), ("inward", -1)])
def test_the_signs_of_speed_and_turn_follow_the_facing_and_oppose_each_other(facing, sign):
    found = printed_speed_and_turn(facing, SAMPLE_CHAIR, seed=5)
    assert np.allclose(found, [sign, -sign], rtol=0, atol=1e-9)


def test_in_the_middle_of_its_drives_the_chair_keeps_its_pace():
    for legs, speed, turn in ((STRAIGHT_ON, 1.0, 0.0), (TURN_LEFT, 0.0, 1.0)):
        assert legs[0].duration_s < MIDDLE / 100 < legs[0].duration_s + legs[1].duration_s
        assert legs[1].linear_velocity_mps == speed
        assert np.isclose(np.deg2rad(legs[1].yaw_rate_degps), turn)


@pytest.mark.parametrize("facing", ["outward", "inward"])
def test_arctangents_follow_the_sensor_and_atan2_follows_the_roll(facing):
    printed = along_outward_axle(facing, "printed", count=20)
    assert np.allclose(printed, 1 if facing == "outward" else -1)
    # atan2 gives the axle of the forward roll: outward on the left wheel, inward on the right one.
    assert np.allclose(along_outward_axle(facing, "corrected", count=20), [1, -1] * 20)


def test_slip_is_in_the_drive_and_not_in_its_calibration():
    mounting, slip = random_mounting(1), SlipEpisode("left", 3.0, 0.5, 0.9)
    slipping, mount = court_and_calibrate(STRAIGHT_ON, SAMPLE_CHAIR, mounting, [slip])
    rolling, same = court_and_calibrate(STRAIGHT_ON, SAMPLE_CHAIR, mounting)
    assert slipping.slipping.any() and not rolling.slipping.any()
    for side in SIDES:
        assert np.array_equal(mount.rotation_imu_to_wheel(side), same.rotation_imu_to_wheel(side))
        axle = mounting[f"{side}_wheel"].rotation_body_to_imu[:, 2]
        assert mount.rotation_imu_to_wheel(side)[2] @ axle > 0.999


def test_tasks_of_a_court_with_perfect_sensors_differ_at_the_changes_only():
    found, driven = court_tasks(10.0, 0.0, 1)
    assert len(found) == len(driven) and set(found) == set(driven)
    changes = np.nonzero(np.diff(driven))[0]
    apart = np.nonzero(found != driven)[0]
    assert all(np.abs(changes - k).min() <= 70 for k in apart)


@pytest.mark.parametrize("facing", ["outward", "inward"])
def test_axles_are_those_of_the_mounting(facing):
    axles = list(forward_axles(facing, 10))
    for k, (side, axle) in enumerate(axles):
        mounted = facing_mounting(facing, k // 2)[f"{side}_wheel"].rotation_body_to_imu
        assert np.array_equal(axle, mounted[:, 2])
    assert [side for side, _ in axles] == list(SIDES) * 10
