"""When the walking frame stands still. The paper gives no detector; this one is ours.

A sample is still if, from a little before it to a little after, the rate stays small and the
specific force stays near its own local mean. Neither says anything of an offset or of a slow,
even creep: what moves slowly enough passes for still.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_vectors


@dataclass(frozen=True)
class StillnessSettings:
    """What counts as still.

    Parameters
    ----------
    rate_radps : rad/s, largest mean rate
    acc_deviation_mps2 : m/s², largest distance of the mean specific force from its longer mean
    mean_s : s, length of the short mean, which takes out noise
    local_mean_s : s, length of the longer mean of the specific force
    margin_s : s, both must hold this long before and after
    shorten_s : s, taken off both ends of each still stretch
    """

    rate_radps: float = 0.05
    acc_deviation_mps2: float = 0.25
    mean_s: float = 0.05
    local_mean_s: float = 0.31
    margin_s: float = 0.07
    shorten_s: float = 0.04

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive."""
        for name, value in vars(self).items():
            if not np.isfinite(value) or value < 0 or (value == 0 and name[-2:] == "ps"):
                raise InputError(f"{name} = {value}: expected a positive number")


def find_stillness(
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    settings: StillnessSettings | None = None,
) -> NDArray[np.bool_]:
    """Say for each sample whether the frame stands (or is held) still.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s², in the IMU's axes
    gyr_radps : (n, 3) array, rad/s, in the IMU's axes
    sampling_rate_hz : Hz
    settings : StillnessSettings

    Returns
    -------
    (n,) bool array
    """
    settings = settings or StillnessSettings()
    acc, gyr = as_vectors(acc_mps2, "acc_mps2"), as_vectors(gyr_radps, "gyr_radps")
    if acc.ndim != 2 or acc.shape != gyr.shape:
        raise InputError(f"acc_mps2 {acc.shape}, gyr_radps {gyr.shape}: expected both (n, 3)")

    def odd(seconds: float) -> int:
        return 2 * int(seconds * sampling_rate_hz / 2) + 1

    def mean(values: FloatArray, seconds: float) -> FloatArray:
        return ndimage.uniform_filter1d(values, odd(seconds), axis=0, mode="nearest")

    def below(values: FloatArray, limit: float) -> NDArray[np.bool_]:
        return np.asarray(np.einsum("ij,ij->i", values, values) < limit**2)

    rate = mean(gyr, settings.mean_s)
    deviation = mean(acc, settings.mean_s) - mean(acc, settings.local_mean_s)
    quiet = below(rate, settings.rate_radps) & below(deviation, settings.acc_deviation_mps2)
    # An erosion by both lengths: the margin asks for quiet all around, the rest shortens.
    reach = 2 * round((settings.margin_s + settings.shorten_s) * sampling_rate_hz) + 1
    return np.asarray(ndimage.minimum_filter1d(quiet.astype(np.int8), reach, mode="nearest") > 0)
