"""Thin wrappers of ``scipy.ndimage`` and ``scipy.signal``, and the root mean square."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_count, as_floats, one_of, shown


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
    one_of("edge", edge, ("nearest", "zero"))
    data, window = _checked("median", values, window)
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
    data, window = _checked("moving average", values, window)
    return np.asarray(ndimage.uniform_filter1d(data, window, axis=0, mode="nearest"))


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
        If the window is even or longer than the data, the order does not fit into it or is so high
        that rounding spoils the fit, or a value near an end, to which a polynomial is fitted, is
        not finite.
    """
    from scipy import signal

    data, window = _checked("Savitzky-Golay", values, window)
    order = as_count(order, "Savitzky-Golay order", least=0)
    if order >= window:
        raise InputError(f"Savitzky-Golay order = {order}: expected from 0 to window - 1")
    # SciPy solves in powers of the place: its weights are off by 1e-4 from 1e13 on, then useless.
    if order * np.log10(max(window // 2, 1)) > 13:
        raise InputError(
            f"Savitzky-Golay order = {order}: expected up to {int(13 / np.log10(window // 2))} "
            f"in a window of {window}, beyond which rounding spoils it"
        )
    if not (np.isfinite(data[:window]).all() and np.isfinite(data[-window:]).all()):
        raise InputError(
            f"Savitzky-Golay: values that are not finite within {window} samples of an end"
        )
    return np.asarray(signal.savgol_filter(data, window, order, axis=0))


def rms(values: ArrayLike) -> float:
    """Root of the mean square; NaN is left out.

    Parameters
    ----------
    values : array of any shape with one number or more

    Returns
    -------
    float, in the unit of the values

    Raises
    ------
    InputError
        If there is no number in it.

    Examples
    --------
    >>> rms([3.0, float("nan"), -3.0])
    3.0
    """
    data = as_floats(values, "values")
    data = data[~np.isnan(data)]
    if not data.size:
        raise InputError("values: expected one number or more")
    return float(np.sqrt(np.mean(np.square(data))))


def _checked(name: str, values: ArrayLike, window: int) -> tuple[FloatArray, int]:
    """Data as a float array of one or two dimensions, and the window as a whole odd number."""
    data = as_floats(values, name)
    if data.ndim not in (1, 2) or not data.size:
        raise InputError(f"{name}: expected one or more samples, got an array {data.shape}")
    given: Any = window
    try:
        whole = int(given) if not isinstance(given, bool) and given == int(given) else given
        window = as_count(whole, f"{name} window")
    except (InputError, TypeError, ValueError, OverflowError):
        window = 0
    if window % 2 == 0:
        raise InputError(f"{name} window = {shown(given)}: expected an odd number of samples")
    if window > len(data):
        raise InputError(f"{name} window = {window}: longer than the {len(data)} samples")
    return data, window
