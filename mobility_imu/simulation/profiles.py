"""How something goes from one level to another: smooth rises, humps and windows of a variable."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import FloatArray


def least_jerk(u: FloatArray, rise: float = 1.0) -> FloatArray:
    """Rise of least jerk between 0 and 1: level before and after, acceleration without jumps.

    Parameters
    ----------
    u : array, how far the change has come; 0 at its beginning, 1 at its end
    rise : by how much the level rises

    Returns
    -------
    array of the same shape

    Examples
    --------
    >>> least_jerk(np.array([-1.0, 0.0, 0.5, 2.0]), 4.0).tolist()
    [0.0, 0.0, 2.0, 4.0]
    """
    u = np.clip(u, 0, 1)
    return rise * u**3 * (10 - 15 * u + 6 * u**2)


def least_jerk_slope(u: FloatArray, rise: float = 1.0) -> FloatArray:
    """Derivative of :func:`least_jerk` by u.

    Parameters
    ----------
    u, rise : as in :func:`least_jerk`

    Returns
    -------
    array of the same shape
    """
    u = np.clip(u, 0, 1)
    return rise * 30 * u**2 * (1 - u) ** 2


def least_jerk_bend(u: FloatArray, rise: float = 1.0) -> FloatArray:
    """Second derivative of :func:`least_jerk` by u.

    Parameters
    ----------
    u, rise : as in :func:`least_jerk`

    Returns
    -------
    array of the same shape
    """
    u = np.clip(u, 0, 1)
    return rise * 60 * u * (1 - u) * (1 - 2 * u)


def smooth(u: FloatArray) -> FloatArray:
    """Rise from 0 to 1 with three continuous derivatives (a polynomial of seventh order).

    One order smoother than :func:`least_jerk`: sums of samples at 100 Hz are as good as integrals.

    Parameters
    ----------
    u : array, how far the change has come; 0 at its beginning, 1 at its end

    Returns
    -------
    array of the same shape
    """
    u = np.clip(u, 0, 1)
    return u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3)


def hump(u: FloatArray) -> FloatArray:
    """Rise from 0 to 1 at the middle and back, as smooth at both ends as :func:`smooth`.

    Parameters
    ----------
    u : array, how far the change has come; 0 at its beginning, 1 at its end

    Returns
    -------
    array of the same shape
    """
    u = np.clip(u, 0, 1)
    return (4 * u * (1 - u)) ** 4


def window(
    time_s: FloatArray, start_s: FloatArray | float, stop_s: FloatArray | float, fade_s: float
) -> FloatArray:
    """Rise to 1 after a start, and fall to 0 before a stop.

    Parameters
    ----------
    time_s : (n,) array, s
    start_s, stop_s : float or (n,) array, s; 0 before the one and after the other
    fade_s : s, length of the rise and of the fall

    Returns
    -------
    (n,) array
    """
    return smooth((time_s - start_s) / fade_s) * smooth((stop_s - time_s) / fade_s)


def cosine_ramp(u: FloatArray) -> FloatArray:
    """Rise from 0 to 1 as half a wave of a cosine.

    Parameters
    ----------
    u : array, how far the change has come; 0 at its beginning, 1 at its end

    Returns
    -------
    array of the same shape
    """
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(u, 0, 1))


def cosine_ramp_integral(u: FloatArray) -> FloatArray:
    """Integral of :func:`cosine_ramp` over u, from 0.

    Parameters
    ----------
    u : array, how far the change has come; 0 at its beginning, 1 at its end

    Returns
    -------
    array of the same shape
    """
    inside = np.clip(u, 0, 1)
    return 0.5 * (inside - np.sin(np.pi * inside) / np.pi) + np.maximum(u - 1, 0)
