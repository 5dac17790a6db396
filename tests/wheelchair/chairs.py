"""Chairs, drives and mountings that several test files of the wheelchair use."""

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mobility_imu.simulation.wheelchair import (
    IDEAL,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    Leg,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    WheelchairGeometry,
    calibrate_mount,
)

# A few roundings of numbers of size 1 to 10.
ROUNDING = 1e-12
# The same after some dozen operations per sample, with speeds and rates of size 1 to 10.
EXACT = 1e-9

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


def trials(geometry, seed, legs=BOTH_WAYS, noise=IDEAL, sampling_rate_hz=100.0, mounting=None):
    mounting = mounting or random_mounting(seed)
    return tuple(
        simulate_drive(
            part, geometry, mounting, seed=seed + k, noise=noise, sampling_rate_hz=sampling_rate_hz
        )
        for k, part in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, legs))
    )


def calibrated(static, straight, _=None):
    return calibrate_mount(static.recording, straight.recording)


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
