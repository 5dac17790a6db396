"""Scooter: a wrong angle in the table of parked poses is told, and what cannot be seen is not."""

from functools import cache

import numpy as np
import pytest

from mobility_imu.scooter import SUZUKI_ET4D, calibrate_mount
from mobility_imu.scooter import pose_table as rule
from mobility_imu.scooter.pose_check import PoseCheckSettings
from mobility_imu.simulation.scooter import PARKED_POSES_RAD, draw_scooter, simulate_parked
from mobility_imu.simulation.sensor import LPMS_CU2, REAL

SLOPES_DEG = (0.0, 5.0)


@cache
def parked(seed=7, sensor=LPMS_CU2):
    return [
        simulate_parked(
            pitch_rad=float(np.deg2rad(pitch)),
            bank_rad=0.0,
            seed=100 * seed + k,
            unit=draw_scooter(seed),
            sensor=sensor,
        )
        for k, pitch in enumerate(SLOPES_DEG)
    ]


def calibrated(changes_deg, sensor=LPMS_CU2):
    """Calibration with a table of which some angles are off; ``changes_deg`` by pose, control."""
    table = np.array(PARKED_POSES_RAD)
    for place, change in changes_deg.items():
        table[place] += np.deg2rad(change)
    return calibrate_mount(
        parked(sensor=sensor), [tuple(row) for row in table.tolist()], SUZUKI_ET4D
    )


@pytest.mark.parametrize("sensor", [LPMS_CU2, REAL])
def test_right_angles_are_not_called_wrong(sensor):
    assert calibrated({}, sensor).severe == ()


@pytest.mark.parametrize("pose", range(6))
def test_a_wrong_pose_is_named_with_the_angles_at_which_it_fits(pose):
    """Within 3 deg: stops are off by 0.5 deg, and gravity shows a third of the steering's."""
    found = calibrated({(pose, 0): 9.0, (pose, 1): -6.0})
    (told,) = [text for text in found.severe if "does not fit the others" in text]
    assert told.startswith(f"pose {pose + 1} does") and told in found.warnings
    right = [float(word) for word in told.split("throttle at ")[1].split(" deg")[0].split(" and ")]
    assert right == pytest.approx(np.rad2deg(PARKED_POSES_RAD[pose]).tolist(), abs=3)


def test_a_stop_that_is_wrong_wherever_it_is_used_is_named():
    found = calibrated({(4, 0): 10.0, (5, 0): 10.0})
    (told,) = [text for text in found.severe if "does not fit the others" in text]
    assert told.startswith("the steering of poses 5, 6 does not fit the others: at -5")


def test_two_wrong_poses_are_told_without_a_name():
    found = calibrated({(0, 1): 3.5, (4, 0): 5.0, (3, 1): -3.5})
    (told,) = found.severe
    assert "no single pose or stop is to blame" in told


@pytest.mark.parametrize(("control", "least_deg"), [(0, 1.5), (1, 4.0)])
def test_one_angle_in_all_poses_is_a_turn_of_an_imu(control, least_deg):
    """What cannot be seen: poses fit as before, and the mount turns as far as gravity feels it."""
    off = {(pose, control): 5.0 for pose in range(6)}
    sound, found = calibrated({}), calibrated(off)
    assert found.severe == ()
    assert found.misfit_rad == pytest.approx(sound.misfit_rad, rel=0.2)
    body = control == 0
    key = "rotation_body_imu_to_body" if body else "rotation_lever_imu_to_lever"
    turn = getattr(found.mount, key) @ getattr(sound.mount, key).T
    angle = np.rad2deg(np.arccos((np.trace(turn) - 1) / 2))
    assert angle > least_deg


def test_sizes_are_those_of_a_check_with_phones():
    usual = PoseCheckSettings()
    assert rule.STOP_SD_RAD == usual.stop_sd_rad
    assert rule.OFFSET_SD * 9.80665 == pytest.approx(usual.acc_offset_sd_mps2)
    assert (rule.SCALE_SD, rule.AXES_SD_RAD) == (usual.acc_scale_sd, usual.acc_axes_sd_rad)
    assert rule.INCLINATION_SD_RAD == usual.geometry_sd_rad


def test_steps_of_readings_are_found():
    assert rule.step_of(parked(sensor=REAL)[0]) == pytest.approx(0.01, rel=0.05)
    assert rule.step_of(parked()[0]) < 0.002
