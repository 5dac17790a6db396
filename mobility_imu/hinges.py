"""Two hinges in a row that see one vector at both ends: a steering shaft with a lever on it.

The body's vector, an acceleration or a rate, is turned about x by alpha into the column {N} of the
shaft, about the shaft (z) by the steering angle, and about x by the lever's tip, which is
``throttle + alpha - beta``. Each step exchanges two components (:func:`turn`). The letters are
those of Suzurikawa et al. 2022: ``(C1, K1)`` after the first step, ``K2`` after the second.

The loops over samples take one sample at a time and are compiled where numba is there.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from mobility_imu._compiled import compiled
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_floats, as_vectors, check_together

__all__ = ["ColumnVector", "column_vector", "hinge_rates", "steered", "tip_reading", "turn"]


class ColumnVector(NamedTuple):
    """Components of the body's vector in the column {N}: the paper's ax_B, C1 and K1.

    Parameters
    ----------
    x, c1, k1 : (...) arrays, in the unit of the vector
    """

    x: FloatArray
    c1: FloatArray
    k1: FloatArray


def turn(first: Any, second: Any, sin: Any, cos: Any) -> tuple[Any, Any]:
    """Two components of a vector in axes that are turned by an angle, from the first to the second.

    Parameters
    ----------
    first, second : floats or arrays, the components before
    sin, cos : floats or arrays, sine and cosine of the angle

    Returns
    -------
    two floats or arrays
    """
    return first * cos + second * sin, second * cos - first * sin


def column_vector(body: FloatArray, alpha_rad: float) -> ColumnVector:
    """Turn the body's vectors into the column: C1 and K1 beside the unchanged x.

    Parameters
    ----------
    body : (..., 3) array, in {B}
    alpha_rad : rad, how far the shaft leans back

    Returns
    -------
    ColumnVector
    """
    body, alpha = as_vectors(body, "body"), as_floats(alpha_rad, "alpha_rad")
    check_together(body=body.shape[:-1], alpha_rad=alpha.shape)
    c1, k1 = turn(body[..., 1], body[..., 2], np.sin(alpha), np.cos(alpha))
    return ColumnVector(body[..., 0], c1, k1)


def steered(column: ColumnVector, steering_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lever's x component and K2: the column's vector turned about the shaft.

    Parameters
    ----------
    column : ColumnVector
    steering_rad : (...) array, rad

    Returns
    -------
    x, k2 : (...) arrays
    """
    if not isinstance(column, ColumnVector):
        raise InputError(f"column: got {type(column).__name__}, expected ColumnVector")
    steering_rad = as_floats(steering_rad, "steering_rad")
    check_together(column=np.shape(column.x), steering_rad=steering_rad.shape)
    x, k2 = turn(column.x, column.c1, np.sin(steering_rad), np.cos(steering_rad))
    return x, k2


_turn = compiled()(turn)


@compiled()
def tip_reading(
    body: FloatArray, steering_rad: float, tip_rad: float, sin_alpha: float, cos_alpha: float
) -> tuple[float, float, float, float]:
    """Body's vector as the lever's sensor reads it, for one sample, and K2.

    Parameters
    ----------
    body : (3,) array, in {B}
    steering_rad, tip_rad : rad; the tip is the throttle angle plus alpha less beta
    sin_alpha, cos_alpha : of the shaft's inclination

    Returns
    -------
    x, y, z, k2 : floats
    """
    c1, k1 = _turn(body[1], body[2], sin_alpha, cos_alpha)
    x, k2 = _turn(body[0], c1, np.sin(steering_rad), np.cos(steering_rad))
    z, y = _turn(k1, k2, np.sin(tip_rad), np.cos(tip_rad))
    return x, y, z, k2


@compiled()
def hinge_rates(
    lever: FloatArray,
    body: FloatArray,
    steering_rad: float,
    tip_rad: float,
    sin_alpha: float,
    cos_alpha: float,
) -> tuple[float, float, float, float]:
    """Rates of steering and throttle from two gyroscopes, for one sample, and their derivatives.

    The lever's rate less the body's, along the shaft and along the lever's axis.

    Parameters
    ----------
    lever, body : (3,) arrays, rad/s, in {T} and {B}
    steering_rad, tip_rad : rad; the tip is the throttle angle plus alpha less beta
    sin_alpha, cos_alpha : of the shaft's inclination

    Returns
    -------
    steering_radps, throttle_radps : floats
    steering_by_tip, throttle_by_steering : floats, derivatives in 1/s; the other two are zero
    """
    level, along = _turn(body[1], body[2], sin_alpha, cos_alpha)
    across, shaft = _turn(lever[1], lever[2], np.sin(tip_rad), np.cos(tip_rad))
    beside, ahead = _turn(body[0], level, np.sin(steering_rad), np.cos(steering_rad))
    return shaft - along, beside - lever[0], -across, ahead
