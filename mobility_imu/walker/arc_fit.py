"""An axis and an arm fitted to the whole arc of a tilt. Past the paper, which uses the two ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_vectors
from mobility_imu.results import Result

__all__ = ["ArcFit", "fit_arc"]

LEAST_TURN_RAD = float(np.deg2rad(1))
"""With less of a turn the noise decides where the axis is."""


@dataclass(frozen=True, eq=False, repr=False)
class ArcFit(Result):
    """An axis fitted to the whole of a tilt.

    Parameters
    ----------
    axis_imu : (3,) array, unit vector that the frame turns positively about, IMU's axes
    arm_imu_m : (3,) array, m, from the axis to the IMU at right angles, IMU's axes
    covariance_m2 : (3, 3) array, m², of the arm
    residual_m : rms distance of the path from the arc, m
    """

    axis_imu: FloatArray
    arm_imu_m: FloatArray
    covariance_m2: FloatArray
    residual_m: float


def fit_arc(position_m: ArrayLike, rotation_imu_to_world: ArrayLike) -> ArcFit:
    """Axis and arm from all samples of a tilt, by linear least squares.

    With a fixed axis, r_k = e + R(q_k) arm. The axis is the main direction of the rotation vectors
    from the start; the arm is at right angles to it. Neighbouring residuals are alike, so that
    the covariance is that of as many samples as are independent. Errors that change more slowly
    than the arc lasts are not in it: the fit takes them up.

    Parameters
    ----------
    position_m : (n, 3) array, m, world, upright to upright or to the end of the tilt; three
        samples or more
    rotation_imu_to_world : (n, 3, 3) array

    Returns
    -------
    ArcFit

    Raises
    ------
    InputError
        If there are too few samples, or the IMU turns by less than 1 deg.
    """
    position = as_vectors(position_m, "position_m", ndim=2, finite=True)
    attitude = np.asarray(rotation_imu_to_world, float)
    count = len(position)
    if attitude.shape != (count, 3, 3) or not np.isfinite(attitude).all():
        raise InputError(
            f"rotation_imu_to_world: expected ({count}, 3, 3) numbers, got {attitude.shape}"
        )
    if count < 3:
        raise InputError(f"position_m: {count} sample(s), expected at least 3")
    turns = Rotation.from_matrix(attitude[0].T @ attitude).as_rotvec()
    largest = float(np.linalg.norm(turns, axis=1).max())
    if largest < LEAST_TURN_RAD:
        raise InputError(
            f"rotation_imu_to_world: turns by {np.rad2deg(largest):.2g} deg, expected 1 deg or more"
        )
    _, _, directions = np.linalg.svd(turns, full_matrices=False)
    axis = directions[0] * np.sign(np.sum(turns @ directions[0]))
    # Two unknown components of the arm, in a basis at right angles to the axis.
    basis = directions[1:3].T
    design = np.zeros((3 * count, 5))
    design[:, :3] = np.tile(np.eye(3), (count, 1))
    design[:, 3:] = (attitude @ basis).reshape(-1, 2)
    solution, *_ = np.linalg.lstsq(design, position.ravel(), rcond=None)
    residual = (position.ravel() - design @ solution).reshape(-1, 3)
    variance = float(np.sum(residual**2)) / (3 * count - 5) * _correlated_samples(residual)
    spread = variance * np.linalg.inv(design.T @ design)[3:, 3:]
    return ArcFit(
        axis,
        basis @ solution[3:],
        basis @ spread @ basis.T,
        float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))),
    )


def _correlated_samples(residual: FloatArray) -> float:
    """How many neighbouring samples count as one: the integrated autocorrelation, at least 1."""
    count = len(residual)
    spectrum = np.abs(np.fft.rfft(residual, 2 * count, axis=0)) ** 2
    products = np.fft.irfft(spectrum.sum(axis=1))[:count]
    if not products[0] > 0:
        return 1.0
    correlation = products / products[0]
    negative = np.nonzero(correlation < 0)[0]
    until = int(negative[0]) if len(negative) else count
    return float(max(1.0, 1 + 2 * np.sum(correlation[1:until])))
