"""Rates beyond the end of a gyroscope's range, which a foot reaches in its swing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.runs import runs_of

__all__ = ["bridged_rates"]

BESIDE = 3
"""Samples on either side of a cut that say how the rate goes on. Our choice, not swept."""
FARTHEST = 2.0
"""The bridge stays below this multiple of the range. Our choice, not swept."""


def bridged_rates(
    gyr_radps: FloatArray, range_radps: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Rates with a cubic over each cut, and where an axis is cut.

    A gyroscope that cuts a swing's peak off leaves a tilt of a degree at its end. The cubic spline
    through the samples beside the cut is nearer to the truth than the limit; where it is lower than
    what was read, the reading stays. A cut at the recording's ends stays as it is.

    Parameters
    ----------
    gyr_radps : (n, 3) array, rad/s, in the IMU's axes
    range_radps : rad/s, largest rate that is read right

    Returns
    -------
    (n, 3) array, rad/s : the readings themselves where nothing is cut
    (n,) bool array : samples in which an axis is beyond the range
    """
    beyond = np.abs(gyr_radps) > range_radps
    cut = np.asarray(beyond.any(axis=1))
    if not cut.any():
        return gyr_radps, cut
    from scipy.interpolate import CubicSpline

    bridged = gyr_radps.copy()
    for axis in np.flatnonzero(beyond.any(axis=0)):
        read = gyr_radps[:, axis]
        for sign in (1.0, -1.0):
            for run in runs_of(sign * read > range_radps):
                before, after = run.start - BESIDE, run.stop + BESIDE
                if before < 0 or after > len(read):
                    continue
                beside = np.r_[before : run.start, run.stop : after]
                peak = sign * CubicSpline(beside, read[beside])(np.arange(run.start, run.stop))
                peak = np.clip(peak, sign * read[run], FARTHEST * range_radps)
                bridged[run, axis] = sign * peak
    return bridged, cut
