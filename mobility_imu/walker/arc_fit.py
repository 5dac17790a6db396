"""An axis and an arm fitted to the whole arc of a tilt. Past the paper, which uses the two ends."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import (
    LONGEST_STEP_S,
    SHORTEST_STEP_S,
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_flags,
    as_floats,
    as_number,
    as_rotation,
    as_vectors,
)
from mobility_imu.results import Result
from mobility_imu.runs import runs_of

__all__ = ["ArcFit", "arm_noise", "fit_arc"]

LEAST_TURN_RAD = float(np.deg2rad(1))
"""With less of a turn the noise decides where the axis is."""
TOLERANCE = 1e-3
"""Largest entry by which a matrix times its transpose may miss the identity, as that of
:func:`~mobility_imu.frames.as_rotation`."""
LEAST_SINE = 1e-9
"""Twice the sine of an angle, below which rounding decides about the axis."""
NEAR_HALF_TURN = 10 * TOLERANCE
"""The same, below which the entries' errors decide about the axis of nearly a half turn."""
LARGEST_SIZE = 1e9
"""Of a position, m, and of a noise, above which squares lose their meaning."""


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
        If there are too few samples, the IMU turns by less than 1 deg, a position is too large for
        one, or a matrix is no rotation.
    """
    position = as_vectors(position_m, "position_m", ndim=2, finite=True)
    count = len(position)
    _check_size("position_m", float(np.abs(position).max(initial=0.0)))
    axis, basis, design = _linear_model(rotation_imu_to_world, count)
    normal = design.T @ design
    solution = np.linalg.solve(normal, design.T @ position.ravel())
    residual = (position.ravel() - design @ solution).reshape(-1, 3)
    variance = float(np.sum(residual**2)) / (3 * count - 5) * _correlated_samples(residual)
    spread = variance * np.linalg.inv(normal)[3:, 3:]
    return ArcFit(
        axis,
        basis @ solution[3:],
        basis @ spread @ basis.T,
        float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))),
    )


def _check_size(name: str, size: float) -> None:
    """Check that a number can be squared and summed."""
    if size > LARGEST_SIZE:
        raise InputError(f"{name}: reaches {size:.4g}, expected {LARGEST_SIZE:g} at most")


def _linear_model(
    rotation_imu_to_world: ArrayLike, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Axis, (3, 2) basis at right angles to it, and (3 n, 5) design of the fit of an arc."""
    attitude = as_floats(rotation_imu_to_world, "rotation_imu_to_world")
    if attitude.shape != (count, 3, 3) or not np.isfinite(attitude).all():
        raise InputError(
            f"rotation_imu_to_world: expected ({count}, 3, 3) numbers, got {attitude.shape}"
        )
    _check_rotations(attitude)
    if count < 3:
        raise InputError(f"position_m: {count} sample(s), expected at least 3")
    turns = _rotation_vectors(attitude[0].T @ attitude)
    largest = float(np.linalg.norm(turns, axis=1).max())
    if largest < LEAST_TURN_RAD:
        raise InputError(
            f"rotation_imu_to_world: turns by {np.rad2deg(largest):.2g} deg, expected 1 deg or more"
        )
    _, directions = np.linalg.eigh(turns.T @ turns)
    axis = directions[:, 2] * np.copysign(1.0, np.sum(turns @ directions[:, 2]))
    # Two unknown components of the arm, in a basis at right angles to the axis.
    basis = directions[:, :2]
    design = np.zeros((3 * count, 5))
    design[:, :3] = np.tile(np.eye(3), (count, 1))
    design[:, 3:] = (attitude @ basis).reshape(-1, 2)
    return axis, basis, design


def _rotation_vectors(turn: FloatArray) -> FloatArray:
    """Angle times axis of rotations (n, 3, 3); of a half turn, the axis nearer to the others'."""
    # The antisymmetric part is the sine times the axis, the trace 1 + 2 cosines.
    across = np.column_stack([
        turn[:, 2, 1] - turn[:, 1, 2],
        turn[:, 0, 2] - turn[:, 2, 0],
        turn[:, 1, 0] - turn[:, 0, 1],
    ])  # fmt: skip
    twice_sine = np.linalg.norm(across, axis=1)
    angle = np.arctan2(twice_sine, np.trace(turn, axis1=1, axis2=2) - 1)
    vectors = np.asarray(across * (angle / np.maximum(twice_sine, LEAST_SINE))[:, None])
    half = (twice_sine < NEAR_HALF_TURN) & (angle > np.pi / 2)
    if half.any():
        vectors[half] = Rotation.from_matrix(turn[half]).as_rotvec()
        either = half & (twice_sine < LEAST_SINE)
        along = vectors[either] @ vectors[~either].sum(axis=0)
        vectors[either] *= np.where(along < 0, -1.0, 1.0)[:, None]
    return vectors


def _check_rotations(attitude: FloatArray) -> None:
    """Check that each matrix is a rotation; all at once, and those that look odd one by one."""
    small = np.clip(attitude, -2, 2)  # no rotation either way, and the products stay finite
    # Products by hand: numpy's of many small matrices take four times as long.
    rows = [[np.ascontiguousarray(small[:, i, j]) for j in range(3)] for i in range(3)]
    (a, b, c), (d, e, f), (u, v, w) = rows
    bad = a * (e * w - f * v) - b * (d * w - f * u) + c * (d * v - e * u) < 0
    for one, other in combinations_with_replacement(range(3), 2):
        product = sum(x * y for x, y in zip(rows[one], rows[other], strict=True))
        bad |= np.abs(product - (one == other)) > TOLERANCE
    for k in np.flatnonzero(bad):
        as_rotation(attitude[k], f"rotation_imu_to_world[{k}]", tolerance=TOLERANCE)


def arm_noise(
    rotation_imu_to_world: ArrayLike,
    still: ArrayLike,
    interval_s: float,
    *,
    acc_noise_mps2_sqrthz: float,
    gyr_noise_radps_sqrthz: float,
) -> FloatArray:
    """Covariance of the arm of an arc by the sensor's white noise alone, (3, 3) in m².

    Position errs by noise that is integrated twice, so slowly that the residuals of a fit hardly
    show it. A movement begins and ends at rest: its velocity errs by a Brownian bridge. The height
    is known at both ends of the arc. The gyroscope's noise turns gravity into the horizontal.

    Parameters
    ----------
    rotation_imu_to_world : (n, 3, 3) array, as in :func:`fit_arc`
    still : (n,) bool array, True where the velocity is known to be zero
    interval_s : s, between samples
    acc_noise_mps2_sqrthz, gyr_noise_radps_sqrthz : densities of the noise; 0 for none

    Returns
    -------
    (3, 3) array, m², in the IMU's axes

    Raises
    ------
    InputError
        As :func:`fit_arc`; or if flags, interval or densities are impossible.
    """
    count = len(np.atleast_1d(rotation_imu_to_world))
    at_rest = as_flags(still, "still", length=count)
    interval = as_number(interval_s, "interval_s")
    acc = as_number(acc_noise_mps2_sqrthz, "acc_noise_mps2_sqrthz", zero=True)
    gyr = as_number(gyr_noise_radps_sqrthz, "gyr_noise_radps_sqrthz", zero=True)
    if not SHORTEST_STEP_S <= interval <= LONGEST_STEP_S:
        raise InputError(
            f"interval_s = {interval:g}: expected {SHORTEST_STEP_S:g} to {LONGEST_STEP_S:g} s "
            "from sample to sample"
        )
    _check_size("acc_noise_mps2_sqrthz", acc)
    _check_size("gyr_noise_radps_sqrthz", gyr)
    _, basis, design = _linear_model(rotation_imu_to_world, count)
    # How the arm follows the position: (component of the arm, axis of the world, sample).
    follows = basis @ np.linalg.solve(design.T @ design, design.T)[3:]
    by_acc = _by_acceleration(np.moveaxis(follows.reshape(3, count, 3), 1, 2), ~at_rest, interval)
    end = np.zeros(count)
    end[-1] = 1.0
    of_end = _by_acceleration(end, ~at_rest, interval)
    if of_end.any():
        by_acc[:, 2] -= np.outer(by_acc[:, 2] @ of_end, of_end) / (of_end @ of_end)
    by_gyr = STANDARD_GRAVITY_MPS2 * interval * _sum_of_later(by_acc[:, :2])
    return np.asarray(
        (
            acc**2 * np.einsum("iak,jak->ij", by_acc, by_acc)
            + gyr**2 * np.einsum("iak,jak->ij", by_gyr, by_gyr)
        )
        / interval
    )


def _by_acceleration(
    by_position: FloatArray, moving: NDArray[np.bool_], interval_s: float
) -> FloatArray:
    """What follows the position at each sample (last axis), by the error of each acceleration."""
    by_velocity = interval_s * _sum_of_later(by_position)
    result = np.zeros_like(by_velocity)
    for run in runs_of(moving):
        part = by_velocity[..., run]
        passed = np.arange(1, part.shape[-1] + 1) / part.shape[-1]
        result[..., run] = interval_s * (
            _sum_of_later(part) - np.sum(part * passed, axis=-1, keepdims=True)
        )
    return result


def _sum_of_later(values: FloatArray) -> FloatArray:
    """Sum of each value and all after it, along the last axis."""
    return np.cumsum(values[..., ::-1], axis=-1)[..., ::-1]


def _correlated_samples(residual: FloatArray) -> float:
    """How many neighbouring samples count as one: the integrated autocorrelation, at least 1."""
    count = len(residual)
    padded = next_fast_len(2 * count, real=True)
    spectrum = np.abs(rfft(residual, padded, axis=0)) ** 2
    products = irfft(spectrum.sum(axis=1), padded)[:count]
    if not products[0] > 0:
        return 1.0
    correlation = products / products[0]
    negative = np.nonzero(correlation < 0)[0]
    until = int(negative[0]) if len(negative) else count
    return float(max(1.0, 1 + 2 * np.sum(correlation[1:until])))
