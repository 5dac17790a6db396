"""Walker: an axis and an arm fitted to an arc."""

import inspect

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import as_rotation
from mobility_imu.walker.arc_fit import TOLERANCE, fit_arc


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


def test_many_rotations_are_checked_as_one_is():
    """The tolerance is that of the check of a single rotation."""
    assert inspect.signature(as_rotation).parameters["tolerance"].default == TOLERANCE
