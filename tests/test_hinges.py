"""Two hinges: the shared algebra against the product of rotations, and against differences."""

import numpy as np
import pytest

from mobility_imu.hinges import column_vector, hinge_rates, steered, tip_reading, turn
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter.geometry import rotation_lever_to_body

ALPHA, LEAN = SUZUKI_ET4D.steering_inclination_rad, SUZUKI_ET4D.lean_rad
SIN, COS = np.sin(ALPHA), np.cos(ALPHA)
POSES = [(0.0, 0.0), (0.7, -0.2), (-1.1, 0.6), (2.5, 3.0)]


def test_turn_is_a_rotation_of_the_axes():
    """A vector along the first axis has, in axes turned by an angle, that angle with minus sign."""
    first, second = turn(1.0, 0.0, np.sin(0.3), np.cos(0.3))
    assert np.arctan2(second, first) == pytest.approx(-0.3)


@pytest.mark.parametrize(("steering", "throttle"), POSES)
def test_reading_at_the_tip_is_the_product_of_rotations(steering, throttle):
    body = np.array([1.0, -2.0, 9.0])
    *reading, k2 = tip_reading(body, steering, throttle + LEAN, SIN, COS)
    rotation = rotation_lever_to_body(steering, throttle, SUZUKI_ET4D)
    assert reading == pytest.approx((rotation.T @ body).tolist(), abs=1e-12)
    column = column_vector(body, ALPHA)
    assert np.allclose(steered(column, np.float64(steering)), (reading[0], k2), atol=1e-12)


@pytest.mark.parametrize(("steering", "throttle"), POSES)
def test_rates_of_the_hinges_are_what_turned_the_rotation(steering, throttle):
    """Body and controls turn at once; the gyroscopes read the rotations' own differences."""
    body_rate, rates, dt = np.array([0.3, -0.5, 0.2]), np.array([0.9, -0.4]), 1e-6

    def pose(t):
        return rotation_lever_to_body(steering + t * rates[0], throttle + t * rates[1], SUZUKI_ET4D)

    spin = pose(0).T @ (pose(dt) - pose(-dt)) / (2 * dt)
    lever_rate = pose(0).T @ body_rate + [spin[2, 1], spin[0, 2], spin[1, 0]]
    arguments = (lever_rate, body_rate, steering, throttle + LEAN, SIN, COS)
    found = hinge_rates(*arguments)
    assert found[:2] == pytest.approx(rates, abs=1e-8)
    ahead = hinge_rates(lever_rate, body_rate, steering + dt, throttle + LEAN + dt, SIN, COS)
    slopes = (np.array(ahead[:2]) - found[:2]) / dt
    assert found[2:] == pytest.approx(slopes, abs=1e-5)
