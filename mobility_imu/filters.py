"""Filters, thin on ``scipy.ndimage``."""

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
    if window < 1 or window % 2 == 0:
        raise InputError(f"median window = {window}: expected an odd number of samples")
    if window > len(data):
        raise InputError(f"median window = {window}: longer than the {len(data)} samples")
    if window == 1:
        return data.copy()
    mode = "constant" if edge == "zero" else "nearest"
    columns = data.reshape(len(data), -1).T
    # One row at a time: scipy's fast running median is for 1-D input only (10 times faster).
    rows = [
        ndimage.median_filter(np.ascontiguousarray(row), size=window, mode=mode) for row in columns
    ]
    return np.stack(rows, axis=1).reshape(data.shape)
