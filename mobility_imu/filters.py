"""Filters, thin on ``scipy.ndimage`` and ``scipy.signal``."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray


def median_filter(
    values: ArrayLike, window: int, *, edge: Literal["nearest", "zero"] = "nearest"
) -> FloatArray:
    """Running median of each column, centred.

    Parameters
    ----------
    values : (n,) or (n, k) array
    window : samples in the window, odd; 1 leaves the data as they are
    edge : "nearest" repeats the end samples beyond the ends. "zero" puts zeros there, as
        MATLAB's ``medfilt1`` does: half a window of samples at each end is then not usable.

    Returns
    -------
    array of the same shape

    Raises
    ------
    InputError
        If the window is even, not positive, or longer than the data.
    """
    data = np.asarray(values, float)
    _check_window("median", window, len(data))
    if window == 1:
        return data.copy()
    mode = "constant" if edge == "zero" else "nearest"
    columns = data.reshape(len(data), -1).T
    # One row at a time: scipy's fast running median is for 1-D input only (10 times faster).
    rows = [
        ndimage.median_filter(np.ascontiguousarray(row), size=window, mode=mode) for row in columns
    ]
    return np.stack(rows, axis=1).reshape(data.shape)


def moving_average(values: ArrayLike, window: int) -> FloatArray:
    """Running mean of each column, centred; the end samples are repeated beyond the ends.

    Parameters
    ----------
    values : (n,) or (n, k) array
    window : samples in the window, odd; 1 leaves the data as they are

    Returns
    -------
    array of the same shape

    Raises
    ------
    InputError
        If the window is even, not positive, or longer than the data.
    """
    data = np.asarray(values, float)
    _check_window("moving average", window, len(data))
    return ndimage.uniform_filter1d(data, window, axis=0, mode="nearest")


def savitzky_golay(values: ArrayLike, window: int, order: int) -> FloatArray:
    """Savitzky-Golay smoothing of each column, by polynomials over a centred window.

    Parameters
    ----------
    values : (n,) or (n, k) array
    window : samples in the window, odd
    order : of the polynomial, smaller than the window

    Returns
    -------
    array of the same shape

    Raises
    ------
    InputError
        If the window is even or longer than the data, or the order does not fit into it.
    """
    from scipy import signal

    data = np.asarray(values, float)
    _check_window("Savitzky-Golay", window, len(data))
    if not 0 <= order < window:
        raise InputError(f"Savitzky-Golay order = {order}: expected from 0 to window - 1")
    return signal.savgol_filter(data, window, order, axis=0)


def _check_window(name: str, window: int, count: int) -> None:
    if window < 1 or window % 2 == 0:
        raise InputError(f"{name} window = {window}: expected an odd number of samples")
    if window > count:
        raise InputError(f"{name} window = {window}: longer than the {count} samples")
