"""From the recording of a ride to both angles, as the paper does it (section 2.5).

The paper's order: keep what was recorded in motion, by the Hall pulses of a rear wheel; smooth the
accelerations with a median of 25 samples; apply eqs. 6 and 7. Beside it is the compensation of
its reference 37: subtract the body's acceleration from the lever's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.filters import median_filter
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_flags,
    as_vectors,
    one_of,
)
from mobility_imu.hinges import column_vector, steered
from mobility_imu.results import Result
from mobility_imu.scooter.angles import steering_angle, throttle_angle
from mobility_imu.scooter.geometry import ScooterGeometry

__all__ = [
    "PAPER_MEDIAN_WINDOW",
    "ClippedAngles",
    "clipped_angles",
    "paper_angles",
    "subtract_body",
]

PAPER_MEDIAN_WINDOW = 25
"""Samples in the paper's window; MATLAB's "order" of a median is its width, 0.25 s at 100 Hz."""


@dataclass(frozen=True, eq=False, repr=False)
class ClippedAngles(Result):
    """Angles by the printed formulas, and where an arcsine had to be clipped.

    Parameters
    ----------
    steering_rad, throttle_rad : (n,) arrays, rad
    clipped : (n,) bool array, true where no angle explains the reading
    """

    steering_rad: FloatArray
    throttle_rad: FloatArray
    clipped: NDArray[np.bool_]


def subtract_body(lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike) -> FloatArray:
    """Subtract what the body's IMU reads beyond gravity from the lever's, axis by axis.

    The compensation of the paper's reference 37, as section 4 describes it; the angles then follow
    from the single-IMU equations. It takes the axes of {T} and {B} for parallel: right only with
    both controls at beta = 0 and at rest, and the more wrong the further they are turned.

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², in {T}
    body_acc_mps2 : (..., 3) array, m/s², in {B}

    Returns
    -------
    (..., 3) array, m/s²
    """
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2")
    body = as_vectors(body_acc_mps2, "body_acc_mps2")
    return np.asarray(lever - (body - np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2])))


def clipped_angles(
    lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike | None, geometry: ScooterGeometry
) -> ClippedAngles:
    """Angles as printed (eqs. 6 and 7), with the arcsines' arguments clipped to +-1.

    Noise and unknown slopes drive the argument beyond 1, where MATLAB's ``asin`` turns complex and
    NumPy's gives NaN. The paper does not say what it did. Clipping keeps the real part of MATLAB's
    steering angle, and keeps every sample in the statistics.

    Parameters
    ----------
    lever_acc_mps2 : (n, 3) array, m/s², in {T}
    body_acc_mps2 : (n, 3) array, m/s², in {B}; None for a single IMU on level ground
    geometry : ScooterGeometry

    Returns
    -------
    ClippedAngles
    """
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2")
    level = (0.0, 0.0, STANDARD_GRAVITY_MPS2)
    body = as_vectors(level if body_acc_mps2 is None else body_acc_mps2, "body_acc_mps2")
    column = column_vector(body, geometry.steering_inclination_rad)
    held = lever.copy()
    reach = np.hypot(column.x, column.c1) * (1 - 1e-12)
    held[..., 0] = np.clip(lever[..., 0], -reach, reach)
    steering = steering_angle(held, body, geometry)
    _, k2 = steered(column, steering)
    reach = np.hypot(column.k1, k2) * (1 - 1e-12)
    held[..., 1] = np.clip(lever[..., 1], -reach, reach)
    throttle = throttle_angle(held, body, steering, geometry)
    return ClippedAngles(steering, throttle, (held != lever).any(axis=-1))


def paper_angles(
    lever_acc_mps2: ArrayLike,
    body_acc_mps2: ArrayLike | None,
    moving: NDArray[np.bool_],
    geometry: ScooterGeometry,
    *,
    method: Literal["single", "dual", "subtraction"],
    window: int = PAPER_MEDIAN_WINDOW,
    edge: Literal["zero", "nearest"] = "zero",
) -> ClippedAngles:
    """Angles in motion as the paper computes them: extract, smooth, transform (section 2.5).

    The samples in motion are joined before the median runs over them, so where a standstill was cut
    out the window sees both sides of it. With ``edge="zero"``, as MATLAB's ``medfilt1`` pads unless
    told otherwise, the first and last half window are pulled towards zero: the outermost sample is
    the smallest of 13 positive readings, not their median.

    Parameters
    ----------
    lever_acc_mps2 : (n, 3) array, m/s², in {T}, the whole recording
    body_acc_mps2 : (n, 3) array, m/s², in {B}; None is allowed for "single"
    moving : (n,) bool array, see :func:`~mobility_imu.scooter.pulses.moving_samples`
    geometry : ScooterGeometry
    method : "single" (level ground assumed), "dual", or "subtraction" (see :func:`subtract_body`)
    window, edge : of the median filter; a window of 1 leaves it out

    Returns
    -------
    ClippedAngles of the samples in motion only

    Raises
    ------
    InputError
        If nothing moves for as long as the window, or the body's sensor is missing.
    """
    one_of("method", method, ("single", "dual", "subtraction"))
    if method != "single" and body_acc_mps2 is None:
        raise InputError(f"method = {method!r}: needs the body's sensor, which is missing")
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2", ndim=2)
    inside = as_flags(moving, "moving", length=len(lever))
    if inside.sum() < window:
        raise InputError(
            f"only {int(inside.sum())} samples in motion: fewer than the median window of {window}"
        )
    lever = median_filter(lever[inside], window, edge=edge)
    if method == "single" or body_acc_mps2 is None:
        return clipped_angles(lever, None, geometry)
    body = as_vectors(body_acc_mps2, "body_acc_mps2", length=len(inside))
    body = median_filter(body[inside], window, edge=edge)
    if method == "dual":
        return clipped_angles(lever, body, geometry)
    return clipped_angles(subtract_body(lever, body), None, geometry)
