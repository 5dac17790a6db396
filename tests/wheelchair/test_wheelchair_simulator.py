"""Wheelchair: the simulator against the differentiated path of its sensors.

The simulator shares only the chair's dimensions with the estimators."""

import math

import numpy as np
import pandas as pd
import pytest
from chairs import (
    BOTH_WAYS,
)
from scipy import integrate
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.simulation.wheelchair import (
    IDEAL,
    LIKE_SAMPLE,
    STRAIGHT_TRIAL,
    Leg,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import SAMPLE_CHAIR


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
    path = room + chair_to_room.apply(origin + body_to_chair.apply(np.array(place)))
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
