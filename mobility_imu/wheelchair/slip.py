"""Wheel slip: where wheels and frame disagree on the yaw rate, and what to put there instead.

The rule is the public tool's (it is not in version 0 of the document), with frames turned into
seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_series


@dataclass(frozen=True)
class SlipSettings:
    """When a disagreement counts as slip; the tool's frames at 100 Hz, in seconds.

    Parameters
    ----------
    threshold_radps : rad/s, difference of the yaw rates beyond which a wheel slips
    merge_gap_s : s, windows whose last and first sample are closer than this are one
    shortest_s : s, only windows longer than this are corrected
    low_pass_hz : Hz, corner of the low-pass on the acceleration that is integrated
    """

    threshold_radps: float = 0.2
    merge_gap_s: float = 0.10
    shortest_s: float = 0.06
    low_pass_hz: float = 2.0

    def __post_init__(self) -> None:
        """Refuse what cannot be a setting."""
        for name, value in vars(self).items():
            if not np.isfinite(value) or value < 0 or (value == 0 and name != "merge_gap_s"):
                raise InputError(f"{name} = {value}: expected a positive number")


class SlipWindows(NamedTuple):
    """First and last sample of each window of slip."""

    first: NDArray[np.int64]
    last: NDArray[np.int64]

    def flags(self, count: int) -> NDArray[np.bool_]:
        """One flag per sample."""
        edge = np.zeros(count + 1, int)
        np.add.at(edge, self.first, 1)
        np.add.at(edge, self.last + 1, -1)
        return np.cumsum(edge[:-1]) > 0


def detect_slip(
    yaw_rate_radps: ArrayLike,
    wheel_yaw_rate_radps: ArrayLike,
    sampling_rate_hz: float,
    settings: SlipSettings | None = None,
) -> SlipWindows:
    """Windows in which the wheels' yaw rate leaves the frame's.

    Parameters
    ----------
    yaw_rate_radps : (n,) array, rad/s, frame gyroscope
    wheel_yaw_rate_radps : (n,) array, rad/s, eq. 1.18
    sampling_rate_hz : Hz
    settings : SlipSettings; the tool's values if None

    Returns
    -------
    SlipWindows
    """
    settings = settings or SlipSettings()
    yaw = as_series(yaw_rate_radps, "yaw_rate_radps")
    wheels = as_series(wheel_yaw_rate_radps, "wheel_yaw_rate_radps", length=len(yaw))
    apart = np.abs(yaw - wheels) > settings.threshold_radps
    change = np.diff(np.r_[0, apart.astype(np.int8), 0])
    first, last = np.nonzero(change == 1)[0], np.nonzero(change == -1)[0] - 1
    # Counted between samples, as the tool does; the small term keeps 10 frames 10 frames.
    together = (first[1:] - last[:-1]) < settings.merge_gap_s * sampling_rate_hz - 1e-9
    if len(first) == 0:
        return SlipWindows(first, last)
    return SlipWindows(first[np.r_[True, ~together]], last[np.r_[~together, True]])


def correct_slip(
    linear_velocity_mps: ArrayLike,
    forward_acc_mps2: ArrayLike,
    windows: SlipWindows,
    sampling_rate_hz: float,
    settings: SlipSettings | None = None,
) -> FloatArray:
    """Replace the wheels' speed in the longer slip windows by the integrated acceleration.

    The integral starts at the speed before the window; what it misses at the end is taken off
    linearly, which also removes a constant tilt or bias of the accelerometer. The low-pass runs
    over the whole recording (the tool filters each window by itself).

    Parameters
    ----------
    linear_velocity_mps : (n,) array, m/s, from the wheels
    forward_acc_mps2 : (n,) array, m/s², frame IMU, forward
    windows : from :func:`detect_slip`
    sampling_rate_hz : Hz
    settings : SlipSettings; the tool's values if None

    Returns
    -------
    (n,) array, m/s
    """
    from scipy import integrate, signal

    settings = settings or SlipSettings()
    velocity = as_series(linear_velocity_mps, "linear_velocity_mps").copy()
    acc = as_series(forward_acc_mps2, "forward_acc_mps2", length=len(velocity))
    long = (windows.last - windows.first + 1) > settings.shortest_s * sampling_rate_hz + 1e-9
    if not long.any():
        return velocity
    sections = signal.butter(2, settings.low_pass_hz, fs=sampling_rate_hz, output="sos")
    # The usual padding of nine samples, fewer where the recording is shorter.
    smooth = signal.sosfiltfilt(sections, acc, padlen=min(9, len(acc) - 1))
    for first, last in zip(windows.first[long], windows.last[long], strict=True):
        before, after = max(first - 1, 0), min(last + 1, len(velocity) - 1)
        gained = integrate.cumulative_trapezoid(
            smooth[before : after + 1], dx=1 / sampling_rate_hz, initial=0
        )
        if first == 0:
            # No speed is known before: lean on the end alone.
            path = velocity[after] + gained - gained[-1]
        else:
            path = velocity[before] + gained
            if after > last:
                path = path - (path[-1] - velocity[after]) * np.linspace(0, 1, len(path))
        velocity[first : last + 1] = path[first - before : last - before + 1]
    return velocity
