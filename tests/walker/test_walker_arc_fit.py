"""Walker: an axis and an arm fitted to an arc."""

import inspect

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.frames import as_rotation
from mobility_imu.walker.arc_fit import TOLERANCE, _rotation_vectors, fit_arc


def test_arc_fit_finds_axis_and_arm():
    """A quarter turn about a known axis with 1 mm noise: the arm within 4 sd."""
    rng = np.random.default_rng(5)
    axis, arm = np.array([0.0, 0.6, 0.8]), np.array([0.5, 0.4, -0.3])
    angles = np.linspace(0, 0.7, 300)
    attitude = Rotation.from_rotvec(np.outer(angles, axis)).as_matrix()
    path = [1, 2, 3] + attitude @ arm + 0.001 * rng.standard_normal((300, 3))
    fit = fit_arc(path, attitude)
    assert np.allclose(fit.axis_imu, axis, atol=1e-6)
    off = fit.arm_imu_m - (arm - (arm @ axis) * axis)
    sd = np.sqrt(np.linalg.eigvalsh(fit.covariance_m2)[1:])
    assert np.linalg.norm(off) < 4 * np.linalg.norm(sd) and sd.max() < 0.002
    assert 0.001 < fit.residual_m < 0.0025


@pytest.mark.parametrize(
    "angles_deg", [[0, 0, 0, 180, 180, 180], [0, 60, 120, 180, 180], [0, 180, 180, -179.9999, 180]]
)
@pytest.mark.parametrize("sign", [1, -1])
def test_half_turns_have_an_axis_and_an_arm(angles_deg, sign):
    """Their matrices are symmetric: the axis is not in the difference across the diagonal."""
    axis, arm = np.array([0.0, 0.6, 0.8]), np.array([0.5, 0.4, -0.3])
    attitude = Rotation.from_rotvec(sign * np.deg2rad(angles_deg)[:, None] * axis).as_matrix()
    fit = fit_arc([1, 2, 3] + attitude @ arm, attitude)
    assert np.allclose(np.abs(fit.axis_imu @ axis), 1)
    if 60 in angles_deg:  # a half turn alone goes either way
        assert np.allclose(fit.axis_imu, sign * axis)
    assert np.allclose(fit.arm_imu_m, arm - (arm @ axis) * axis) and fit.residual_m < 1e-6


def test_rotation_vectors_are_those_of_single_rotations():
    """Of SciPy, from nothing to a half turn; noise of rounded files near it does no harm."""
    rng = np.random.default_rng(3)
    axes = rng.standard_normal((200, 3))
    angles = np.r_[
        0, 1e-8, 1e-4, np.linspace(0, np.pi - 1e-3, 194), np.pi - np.array([1e-4, 1e-7, 1e-10])
    ]
    axes *= (angles / np.linalg.norm(axes, axis=1))[:, None]
    turns = Rotation.from_rotvec(axes).as_matrix()
    assert np.allclose(_rotation_vectors(turns)[:-1], axes[:-1], atol=1e-8)
    assert np.allclose(np.abs(_rotation_vectors(turns)[-1]), np.abs(axes[-1]), atol=1e-8)
    rounded = _rotation_vectors(turns.round(6))
    assert np.allclose(np.abs(rounded[-3:]), np.abs(axes[-3:]), atol=1e-4)


def test_many_rotations_are_checked_as_one_is():
    """The tolerance is that of the check of a single rotation."""
    assert inspect.signature(as_rotation).parameters["tolerance"].default == TOLERANCE
