"""Outcomes of a drive: events of tasks, and pushes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import check_columns, check_limits, expect, settings_or_default
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_clock, as_flags, as_number, check_positive
from mobility_imu.results import Result
from mobility_imu.runs import changes_of
from mobility_imu.wheelchair.codes import Task, as_codes
from mobility_imu.wheelchair.series import as_motion

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "PushSettings",
    "Pushes",
    "detect_pushes",
    "onset_errors",
    "task_events",
    "turn_direction",
]


def turn_direction(codes: ArrayLike, yaw_rate_radps: ArrayLike) -> NDArray[np.str_]:
    """Direction of each frame's rotation: "left", "right", or "" outside rotations.

    A rotation is one direction as a whole, by the sign of the angle it turns through.

    Parameters
    ----------
    codes : (n,) array of task codes
    yaw_rate_radps : (n,) array, rad/s, left positive

    Returns
    -------
    (n,) array of str

    Raises
    ------
    InputError
        If a code is no task, the two series differ in length, or a rate is beyond what can be.
    """
    codes = as_codes(codes)
    yaw = as_motion(yaw_rate_radps, "yaw_rate_radps", length=len(codes))
    starts = changes_of(codes)
    if not len(starts):
        return np.zeros(0, "<U5")
    turned = np.add.reduceat(yaw, starts)
    way = np.where(codes[starts] < Task.PIVOT, "", np.where(turned > 0, "left", "right"))
    return np.repeat(way, np.diff(np.r_[starts, len(codes)]))


def task_events(
    time_s: ArrayLike,
    codes: ArrayLike,
    linear_velocity_mps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    *,
    valid: ArrayLike | None = None,
) -> pd.DataFrame:
    """One row per run of a task.

    Parameters
    ----------
    time_s : (n,) array, s, even
    codes : (n,) array of task codes
    linear_velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s
    valid : (n,) array of truth values, whether a frame's task is known, as ``Tasks.valid``; adds
        a column

    Returns
    -------
    DataFrame
        ``task``, ``direction``, ``onset_s``, ``end_s`` (first frame after it), ``duration_s``,
        ``distance_m`` (along the path, backward positive too) and ``turn_angle_deg`` (left
        positive); with ``valid`` given a column ``valid``, 1 where all frames of the event are.

    Raises
    ------
    InputError
        If there are fewer than two frames, the times are not even, a code is no task, the series
        differ in length, or a number is beyond what can be.
    """
    import pandas as pd
    from scipy import integrate

    clock = as_clock(time_s, even=True)
    codes = as_codes(codes, length=len(clock))
    velocity = as_motion(linear_velocity_mps, "linear_velocity_mps", length=len(clock))
    yaw = as_motion(yaw_rate_radps, "yaw_rate_radps", length=len(clock))
    step = (clock[-1] - clock[0]) / (len(clock) - 1)
    starts = changes_of(codes)
    stops = np.r_[starts[1:], len(codes)]
    path = np.r_[0, integrate.cumulative_trapezoid(np.abs(velocity), dx=step, initial=0)]
    heading = np.r_[0, integrate.cumulative_trapezoid(yaw, dx=step, initial=0)]
    events = pd.DataFrame(
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
    if valid is not None:
        known = as_flags(valid, "valid", length=len(clock))
        events["valid"] = np.logical_and.reduceat(known, starts).astype(int)
    return events


def onset_errors(codes: ArrayLike, true_codes: ArrayLike, sampling_rate_hz: float) -> pd.DataFrame:
    """How far from each true onset the nearest onset of the same task was found.

    Parameters
    ----------
    codes : (n,) array of task codes that were found
    true_codes : (n,) array of task codes that were driven
    sampling_rate_hz : Hz

    Returns
    -------
    DataFrame
        one row per true run of a task but the first: ``task``, ``true_onset_s`` from the first
        frame, and ``error_s``, found minus true; NaN if that task was not found at all

    Raises
    ------
    InputError
        If a code is no task, or the two series differ in length.

    Examples
    --------
    >>> onset_errors([1, 1, 1, 2], [1, 1, 2, 2], 100).to_dict("records")
    [{'task': 'forward propulsion', 'true_onset_s': 0.02, 'error_s': 0.01}]
    """
    import pandas as pd

    truth = as_codes(true_codes, "true_codes")
    found = as_codes(codes, length=len(truth))
    fs = as_number(sampling_rate_hz, "sampling_rate_hz")
    onsets = changes_of(found)
    rows = []
    for start in changes_of(truth)[1:]:
        same = onsets[found[onsets] == truth[start]]
        nearest = same[np.argmin(np.abs(same - start))] if len(same) else np.nan
        rows.append((Task(int(truth[start])).title, start / fs, (nearest - start) / fs))
    return pd.DataFrame(rows, columns=["task", "true_onset_s", "error_s"])


FLAT_S = 0.4
"""A minimum that lasts longer than this (s) is a pause; the push starts at its end."""


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
        """Check the numbers."""
        check_positive(self)
        check_limits(self, {"smoothing_s": (1e-6, 60.0), "shortest_cycle_s": (1e-6, 3600.0)})


@dataclass(frozen=True, eq=False, repr=False)
class Pushes(Result):
    """Pushes of a drive: when they begin, when the speed peaks, and what they gain.

    Parameters
    ----------
    onset_s, peak_s : (k,) arrays, s
    speed_gain_mps : (k,) array, m/s
    settings : PushSettings that were used
    warnings : sentences for the user
    """

    onset_s: FloatArray
    peak_s: FloatArray
    speed_gain_mps: FloatArray
    settings: PushSettings = field(default_factory=PushSettings)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that all are series of one length."""
        expect("settings", self.settings, PushSettings)
        check_columns(self, "onset_s", "peak_s", "speed_gain_mps")
        check_fields(self)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of pushes."""
        return len(self.onset_s)

    def to_frame(self) -> pd.DataFrame:
        """Table with one row per push.

        Returns
        -------
        DataFrame
            ``onset_s``, ``peak_s`` and ``speed_gain_mps``
        """
        import pandas as pd

        names = ("onset_s", "peak_s", "speed_gain_mps")
        return pd.DataFrame({name: getattr(self, name) for name in names})

    @property
    def frequency_hz(self) -> float:
        """Pushes per second while pushing, one over the median time between onsets."""
        if len(self.onset_s) < 2:
            return float("nan")
        return float(1 / np.median(np.diff(self.onset_s)))


def detect_pushes(
    time_s: ArrayLike, linear_velocity_mps: ArrayLike, settings: PushSettings | None = None
) -> Pushes:
    """Pushes, found as rises of the forward speed.

    An onset is a minimum of the smoothed speed from which it rises by the smallest gain or more;
    the peak is the next maximum. Only forward motion counts.

    Parameters
    ----------
    time_s : (n,) array, s, even
    linear_velocity_mps : (n,) array, m/s
    settings : PushSettings; the defaults if None

    Returns
    -------
    Pushes
        none where the recording is too short for one

    Raises
    ------
    InputError
        If there are fewer than two samples, the times are not even, the series differ in length,
        or a speed is beyond what can be.
    """
    from scipy import ndimage, signal

    settings = settings_or_default("settings", settings, PushSettings)
    clock = as_clock(time_s, even=True)
    velocity = as_motion(linear_velocity_mps, "linear_velocity_mps", length=len(clock))
    if len(clock) < 3:
        return Pushes(np.empty(0), np.empty(0), np.empty(0), settings)
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
        # The minimum before it; after a pause the rise begins where the pause ends.
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
    return Pushes(clock[at[0]], clock[at[1]], smooth[at[1]] - smooth[at[0]], settings)
