"""Scooter: the slopes of the least squares for the mount are those of their misfit."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.spatial.transform import Rotation

from mobility_imu.scooter.geometry import SUZUKI_ET4D, rotation_lever_to_body
from mobility_imu.scooter.mount_fit import MountFit


def fit_of(turns, seed=1, poses=7):
    """Directions of poses as sensors turned by so much read them, and their fit."""
    rng = np.random.default_rng(seed)
    steering, throttle = rng.uniform(-0.9, 0.9, (2, poses))
    chain = rotation_lever_to_body(steering, throttle, SUZUKI_ET4D)
    up = rng.normal(size=(poses, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    lever = np.einsum("nji,nj->ni", chain, up)
    of_lever, of_body = Rotation.from_rotvec(np.reshape(turns, (2, 3))).as_matrix()
    return MountFit(lever @ of_lever, up @ of_body, chain, 0.01, 0.2)


@pytest.mark.parametrize("size", [0.0, 1e-7, 1e-3, 0.3, 2.5])
def test_slopes_are_the_changes_of_the_misfit(size):
    rng = np.random.default_rng(3)
    turns = size * rng.normal(size=6)
    fit = fit_of(0.1 * rng.normal(size=6))
    numerical = approx_fprime(turns, fit.misfit, 1e-7)
    assert fit.slopes(turns) == pytest.approx(numerical, abs=2e-4)  # 1 / sd times 1e-7, rounded


def test_turns_of_exact_readings_come_back_but_for_the_prior():
    turns = np.array([0.05, -0.1, 0.02, -0.03, 0.04, 0.1])
    loose = fit_of(turns)._replace(prior_sd_rad=1e6)
    assert loose.solved().x == pytest.approx(turns, abs=1e-8)
    # A prior of the stops' size draws them towards zero.
    tight = loose._replace(prior_sd_rad=0.01)
    assert np.linalg.norm(tight.solved().x) < np.linalg.norm(turns)
