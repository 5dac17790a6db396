"""Rates of orientations: exact for a constant turn, of any size below half a turn a step."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.simulation.kinematics import angular_rates, felt_by_imu, second_derivative

DT = 0.01
AXIS = np.array([2.0, -1.0, 2.0]) / 3


@pytest.mark.parametrize("step_deg", [1e-9, 0.1, 30, 89, 91, 150, 179])
def test_a_constant_turn_has_its_rate(step_deg):
    """Also beyond 90 deg per step, where the sine of the step alone would fold back."""
    turns = np.deg2rad(step_deg) * np.outer(np.arange(6), AXIS)
    rates = angular_rates(Rotation.from_rotvec(turns).as_matrix(), DT)
    assert rates == pytest.approx(np.tile(np.deg2rad(step_deg) / DT * AXIS, (6, 1)), rel=1e-6)


def test_the_axes_to_start_from_do_not_matter():
    turns = np.cumsum(np.random.default_rng(0).normal(0, 0.05, (50, 3)), axis=0)
    axes = Rotation.from_rotvec(turns).as_matrix()
    turned = Rotation.from_rotvec([0.3, -2.0, 1.0]).as_matrix() @ axes
    assert angular_rates(turned, DT) == pytest.approx(angular_rates(axes, DT), abs=1e-11)


def test_differences_summed_up_twice_give_the_values_back():
    values = np.random.default_rng(1).normal(size=(40, 2))
    bend = second_derivative(values, DT)
    slope = np.diff(values, axis=0)[:1] + np.cumsum(bend[1:-1], axis=0) * DT**2
    assert values[1] + np.cumsum(slope, axis=0) == pytest.approx(values[2:], abs=1e-12)


def test_a_turntable_feels_gravity_and_the_pull_to_its_middle():
    """Radius 0.5 m at 2 rad/s: 2 m/s² inward along the IMU's own -x, 9.80665 upward."""
    angle = 2.0 * np.arange(200) * 1e-3
    place = 0.5 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    axes = Rotation.from_euler("z", angle[:, None]).as_matrix()
    acc, gyr = felt_by_imu(place, axes, 1e-3)
    assert acc[1:-1] == pytest.approx(np.tile([-2.0, 0.0, 9.80665], (198, 1)), abs=1e-6)
    assert gyr == pytest.approx(np.tile([0.0, 0.0, 2.0], (200, 1)), abs=1e-9)


@pytest.mark.parametrize("size_rad", [0.0, 1e-9, 1e-3, 1.0])
def test_rates_are_those_of_scipys_rotations(size_rad):
    rng = np.random.default_rng(3)
    steps = Rotation.from_rotvec(size_rad * rng.uniform(-1, 1, (200, 3)))
    axes = [Rotation.random(rng=rng)]
    for step in steps:
        axes.append(axes[-1] * step)
    turns = steps.as_rotvec() / DT
    expected = np.vstack([turns[:1], (turns[1:] + turns[:-1]) / 2, turns[-1:]])
    found = angular_rates(np.array([one.as_matrix() for one in axes]), DT)
    assert found == pytest.approx(expected, abs=1e-14 / DT)
