"""Outcomes of a recording: events of tasks, and pushes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import integrate, ndimage, signal

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_series
from mobility_imu.wheelchair.tasks import Codes, Task

if TYPE_CHECKING:
    import pandas as pd


def turn_direction(codes: Codes, yaw_rate_radps: ArrayLike) -> NDArray[np.str_]:
    """Direction of each frame's rotation: "left", "right", or "" outside rotations.

    A rotation is one direction as a whole, by the sign of the angle it turns through.

    Parameters
    ----------
    codes : (n,) array of task codes
    yaw_rate_radps : (n,) array, rad/s, left positive

    Returns
    -------
    (n,) array of str
    """
    yaw = as_series(yaw_rate_radps, "yaw_rate_radps", length=len(codes))
    starts = np.r_[0, np.nonzero(np.diff(codes))[0] + 1]
    turned = np.add.reduceat(yaw, starts)
    way = np.where(codes[starts] < Task.PIVOT, "", np.where(turned > 0, "left", "right"))
    return np.repeat(way, np.diff(np.r_[starts, len(codes)]))


def task_events(
    time_s: ArrayLike,
    codes: Codes,
    linear_velocity_mps: ArrayLike,
    yaw_rate_radps: ArrayLike,
) -> pd.DataFrame:
    """One row per run of a task.

    Parameters
    ----------
    time_s : (n,) array, s, even
    codes : (n,) array of task codes
    linear_velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s

    Returns
    -------
    DataFrame
        ``task``, ``direction``, ``onset_s``, ``end_s`` (first frame after it), ``duration_s``,
        ``distance_m`` (along the path, backward positive too) and ``turn_angle_deg`` (left
        positive).
    """
    import pandas as pd

    clock = as_series(time_s, "time_s", length=len(codes))
    velocity = as_series(linear_velocity_mps, "linear_velocity_mps", length=len(codes))
    yaw = as_series(yaw_rate_radps, "yaw_rate_radps", length=len(codes))
    step = (clock[-1] - clock[0]) / max(len(clock) - 1, 1)
    starts = np.r_[0, np.nonzero(np.diff(codes))[0] + 1]
    stops = np.r_[starts[1:], len(codes)]
    path = np.r_[0, integrate.cumulative_trapezoid(np.abs(velocity), dx=step, initial=0)]
    heading = np.r_[0, integrate.cumulative_trapezoid(yaw, dx=step, initial=0)]
    return pd.DataFrame(
        {
            "task": [Task(code).title for code in codes[starts]],
            "direction": turn_direction(codes, yaw)[starts],
            "onset_s": clock[starts],
            "end_s": clock[0] + stops * step,
            "duration_s": (stops - starts) * step,
            "distance_m": path[stops] - path[starts],
            "turn_angle_deg": np.rad2deg(heading[stops] - heading[starts]),
        }
    )


FLAT_S = 0.4
"""Seconds at one speed that make a low a rest, at whose end the push then begins."""


@dataclass(frozen=True)
class PushSettings:
    """What counts as a push on the rims.

    Parameters
    ----------
    smoothing_s : s, sd of the Gaussian that takes the wheels' ripple out
    smallest_gain_mps : m/s, speed gained from the onset to the peak
    shortest_cycle_s : s, between two onsets
    """

    smoothing_s: float = 0.06
    smallest_gain_mps: float = 0.05
    shortest_cycle_s: float = 0.35

    def __post_init__(self) -> None:
        """Refuse what cannot be a setting."""
        for name, value in vars(self).items():
            if not np.isfinite(value) or value <= 0:
                raise InputError(f"{name} = {value}: expected a positive number")


class Pushes(NamedTuple):
    """Pushes of a drive: when they begin, when the speed peaks, and what they gain.

    Parameters
    ----------
    onset_s, peak_s : (k,) arrays, s
    speed_gain_mps : (k,) array, m/s
    """

    onset_s: FloatArray
    peak_s: FloatArray
    speed_gain_mps: FloatArray

    @property
    def frequency_hz(self) -> float:
        """Pushes per second while pushing, one over the median time between onsets."""
        if len(self.onset_s) < 2:
            return float("nan")
        return float(1 / np.median(np.diff(self.onset_s)))


def detect_pushes(
    time_s: ArrayLike, linear_velocity_mps: ArrayLike, settings: PushSettings | None = None
) -> Pushes:
    """Find pushes as rises of the forward speed.

    An onset is a low of the smoothed speed from which it rises by the smallest gain or more; the
    peak is the next high. Only forward motion counts.

    Parameters
    ----------
    time_s : (n,) array, s, even
    linear_velocity_mps : (n,) array, m/s
    settings : PushSettings

    Returns
    -------
    Pushes
    """
    settings = settings or PushSettings()
    velocity = as_series(linear_velocity_mps, "linear_velocity_mps")
    clock = as_series(time_s, "time_s", length=len(velocity))
    if len(clock) < 3:
        return Pushes(*(np.empty(0) for _ in range(3)))
    fs = (len(clock) - 1) / (clock[-1] - clock[0])
    smooth = ndimage.gaussian_filter1d(velocity, settings.smoothing_s * fs, mode="nearest")
    peaks, _ = signal.find_peaks(
        np.r_[smooth[0], smooth, smooth[-1] - 1e-9],
        prominence=settings.smallest_gain_mps,
        distance=max(1, round(settings.shortest_cycle_s * fs)),
    )
    peaks = np.clip(peaks - 1, 0, len(smooth) - 1)
    onsets, tops = [], []
    last = 0
    for peak in peaks:
        # The low before it; on a flat rest the rise begins where the rest ends.
        low = last + int(np.argmin(smooth[last : peak + 1]))
        floor = smooth[low] + 0.05 * (smooth[peak] - smooth[low])
        near = last + np.nonzero(smooth[last : peak + 1] <= floor)[0]
        if near[-1] - near[0] > FLAT_S * fs:
            low = int(near[-1])
        if smooth[peak] - smooth[low] >= settings.smallest_gain_mps and smooth[peak] > 0:
            onsets.append(low)
            tops.append(int(peak))
        last = int(peak)
    at = np.array(onsets, int), np.array(tops, int)
    return Pushes(clock[at[0]], clock[at[1]], smooth[at[1]] - smooth[at[0]])
