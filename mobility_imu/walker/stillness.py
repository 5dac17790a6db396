"""When the walking frame stands still. The paper gives no detector; this one is ours.

A sample is still if, from a little before it to a little after, the rate stays small and the
specific force stays near its own local mean. The detector sees neither a constant offset of the
force nor a slow, even creep: what moves slowly enough passes for still. So does a frame that rolls
on wheels over a floor that does not shake it, and nothing in one IMU's readings tells it for sure.
On real ground (a wheelchair's frame on asphalt, grass, gravel and a sidewalk) none of the rolling
passed for still.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu.arguments import check_limits, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, as_vectors, check_positive
from mobility_imu.recording import HIGHEST_RATE_HZ

__all__ = ["StillnessSettings", "find_stillness", "stillness_signals"]


LARGEST_READING = 1e100
"""Readings beyond cannot be squared and summed."""
LONGEST_S = 60.0
"""No mean or margin is longer; nobody stands for a minute between two steps."""


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
    shorten_s : s, taken off both ends of each still interval
    """

    rate_radps: float = 0.05
    acc_deviation_mps2: float = 0.25
    mean_s: float = 0.05
    local_mean_s: float = 0.31
    margin_s: float = 0.07
    shorten_s: float = 0.04

    def __post_init__(self) -> None:
        """Check that the limits are positive and no length negative."""
        lengths = ("mean_s", "local_mean_s", "margin_s", "shorten_s")
        check_positive(self, allow_zero=lengths)
        check_limits(self, dict.fromkeys(lengths, (0.0, LONGEST_S)))

    @property
    def eroded_s(self) -> float:
        """What a still interval loses at each of its ends, s; margin and shortening together."""
        return self.margin_s + self.shorten_s


def stillness_signals(
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    settings: StillnessSettings | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Sizes of the two signals that the detector compares with its limits.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s², in the IMU's axes
    gyr_radps : (n, 3) array, rad/s, in the IMU's axes
    sampling_rate_hz : Hz
    settings : StillnessSettings, for the lengths of the means

    Returns
    -------
    (n,) array, rad/s, of the mean rate; (n,) array, m/s², distance of the short mean of the
    specific force from the longer one

    Raises
    ------
    InputError
        If the arrays are empty, not of one length or not finite, or the rate is not positive.
    """
    settings = settings_or_default("settings", settings, StillnessSettings)
    acc = as_vectors(acc_mps2, "acc_mps2", ndim=2, finite=True)
    gyr = as_vectors(gyr_radps, "gyr_radps", length=len(acc), finite=True)
    rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    if rate_hz > HIGHEST_RATE_HZ:
        raise InputError(f"sampling_rate_hz = {rate_hz:g}: expected up to {HIGHEST_RATE_HZ:g}")
    if not len(acc):
        raise InputError("acc_mps2: no samples")
    for name, values in (("acc_mps2", acc), ("gyr_radps", gyr)):
        if np.abs(values).max() > LARGEST_READING:
            raise InputError(
                f"{name}: reaches {np.abs(values).max():.3g}, expected readings of an IMU"
            )

    def mean(values: FloatArray, seconds: float) -> FloatArray:
        count = 2 * int(seconds * rate_hz / 2) + 1
        return np.asarray(ndimage.uniform_filter1d(values, count, axis=0, mode="nearest"))

    def size(values: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", values, values)))

    deviation = mean(acc, settings.mean_s) - mean(acc, settings.local_mean_s)
    return size(mean(gyr, settings.mean_s)), size(deviation)


def find_stillness(
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    settings: StillnessSettings | None = None,
) -> NDArray[np.bool_]:
    """Whether the frame stands (or is held) still, for each sample.

    Parameters
    ----------
    acc_mps2, gyr_radps, sampling_rate_hz : as in :func:`stillness_signals`
    settings : StillnessSettings

    Returns
    -------
    (n,) bool array
    """
    settings = settings_or_default("settings", settings, StillnessSettings)
    rate, deviation = stillness_signals(acc_mps2, gyr_radps, sampling_rate_hz, settings)
    quiet = (rate < settings.rate_radps) & (deviation < settings.acc_deviation_mps2)
    # An erosion by both lengths: the margin asks for quiet all around, the rest shortens.
    reach = 2 * round(settings.eroded_s * sampling_rate_hz) + 1
    return np.asarray(ndimage.minimum_filter1d(quiet.astype(np.int8), reach, mode="nearest") > 0)
