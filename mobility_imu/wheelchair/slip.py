"""Wheel slip: where wheels and frame disagree on the yaw rate, and what to put there instead.

Finding slip is the public tool's rule (it is not in version 0 of the document), with frames turned
into seconds. Mending it is done in two ways. The tool integrates the frame's acceleration. Ours
asks first which wheel slips: with the frame's yaw rate known, either wheel alone gives the speed,
and the one that still rolls agrees with the acceleration. Only where neither does is it integrated.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_series
from mobility_imu.wheelchair.geometry import WheelchairGeometry

if TYPE_CHECKING:
    import pandas as pd

SlipMethod = Literal["wheels", "tool"]
# A wheel that rolls departs from the integrated acceleration by what a frame that rocks by 1
# degree makes of it in half a second: 9.8 sin(1 deg) 0.5 s.
ROLLING_WITHIN_MPS = 0.09


class Source(IntEnum):
    """Where a sample's speed comes from."""

    BOTH_WHEELS = 0
    LEFT_WHEEL = 1
    RIGHT_WHEEL = 2
    ACCELERATION = 3


class WheelSpeeds(NamedTuple):
    """The chair's speed from each wheel alone, m/s, (n,) arrays."""

    left: FloatArray
    right: FloatArray


def wheel_speeds(
    linear_velocity_mps: ArrayLike,
    wheel_yaw_rate_radps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    geometry: WheelchairGeometry,
) -> WheelSpeeds:
    """Chair's speed from each wheel alone, with the frame's yaw rate.

    The left contact travels at V - yaw_rate * track / 2, the right one at V + yaw_rate * track / 2.
    With (1.17) and (1.18) for the two wheels, each wheel's own V is their mean less or plus half a
    track of what the wheels' yaw rate has too much.

    Parameters
    ----------
    linear_velocity_mps : (n,) array, m/s, mean of the wheels
    wheel_yaw_rate_radps : (n,) array, rad/s, from spins and track (sign-safe)
    yaw_rate_radps : (n,) array, rad/s, frame gyroscope
    geometry : WheelchairGeometry

    Returns
    -------
    WheelSpeeds

    Examples
    --------
    At 1.5 m/s straight ahead the right wheel spins 0.6 m/s too fast:

    >>> chair = WheelchairGeometry.from_degrees(
    ...     0, wheel_radius_left_m=0.3, wheel_radius_right_m=0.3, track_m=0.6
    ... )
    >>> speeds = wheel_speeds([1.8], [1.0], [0.0], chair)
    >>> print(speeds.left.round(3), speeds.right.round(3))
    [1.5] [2.1]
    """
    velocity = np.asarray(linear_velocity_mps, float)
    excess = np.asarray(wheel_yaw_rate_radps, float) - np.asarray(yaw_rate_radps, float)
    half = excess * geometry.track_m / 2
    return WheelSpeeds(velocity - half, velocity + half)


@dataclass(frozen=True)
class SlipSettings:
    """When a disagreement counts as slip; the tool's frames at 100 Hz, in seconds.

    Parameters
    ----------
    threshold_radps : rad/s, difference of the yaw rates beyond which a wheel slips
    merge_gap_s : s, windows whose last and first sample are closer than this are one
    shortest_s : s, only windows longer than this are corrected
    low_pass_hz : Hz, corner of the tool's low-pass on the acceleration that it integrates
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
    *,
    wheels: WheelSpeeds | None = None,
    method: SlipMethod = "tool",
) -> FloatArray:
    """Replace the mean of the wheels by something better in the longer slip windows.

    Parameters
    ----------
    linear_velocity_mps : (n,) array, m/s, mean of the wheels
    forward_acc_mps2 : (n,) array, m/s², frame IMU, forward
    windows : from :func:`detect_slip`
    sampling_rate_hz : Hz
    settings : SlipSettings; the tool's values if None
    wheels : WheelSpeeds, for method "wheels"
    method : "wheels" takes the wheel that :func:`slip_sources` finds to roll, and integrates where
        none does. "tool" always integrates: from the speed before the window; what it misses at
        the end is taken off linearly, which also removes a constant tilt or bias of the
        accelerometer. Its low-pass runs over the whole recording (the tool filters each window by
        itself).

    Returns
    -------
    (n,) array, m/s; the given one outside the windows

    Raises
    ------
    InputError
        If the method is neither, or "wheels" has no wheel speeds.
    """
    settings = settings or SlipSettings()
    velocity = as_series(linear_velocity_mps, "linear_velocity_mps").copy()
    acc = as_series(forward_acc_mps2, "forward_acc_mps2", length=len(velocity))
    if method not in ("wheels", "tool"):
        raise InputError(f"method = {method!r}: expected 'wheels' or 'tool'")
    long = _long_enough(windows, sampling_rate_hz, settings)
    if method == "wheels":
        if wheels is None:
            raise InputError("wheels: method 'wheels' needs the speed from each wheel")
        source = slip_sources(wheels, acc, windows, sampling_rate_hz, settings)
        for first, last in zip(windows.first[long], windows.last[long], strict=True):
            here = slice(first, last + 1)
            if (source[here] == Source.ACCELERATION).any():
                velocity[here] = _integrated(velocity, acc, first, last, sampling_rate_hz)
        for wheel, code in zip(wheels, (Source.LEFT_WHEEL, Source.RIGHT_WHEEL), strict=True):
            velocity = np.where(source == code, wheel, velocity)
        return velocity
    if not long.any():
        return velocity
    from scipy import signal

    sections = signal.butter(2, settings.low_pass_hz, fs=sampling_rate_hz, output="sos")
    # The usual padding of nine samples, fewer where the recording is shorter.
    smooth = signal.sosfiltfilt(sections, acc, padlen=min(9, len(acc) - 1))
    for first, last in zip(windows.first[long], windows.last[long], strict=True):
        velocity[first : last + 1] = _integrated(velocity, smooth, first, last, sampling_rate_hz)
    return velocity


def slip_sources(
    wheels: WheelSpeeds,
    forward_acc_mps2: ArrayLike,
    windows: SlipWindows,
    sampling_rate_hz: float,
    settings: SlipSettings | None = None,
) -> NDArray[np.int8]:
    """Which wheel still rolls where the wheels disagree.

    Each wheel's speed is held against the acceleration, integrated between that wheel's own two
    ends of the window: of a wheel that slips and grips again only the middle departs. Where the
    disagreement changes sign, slip may have changed wheels: each stretch is judged by itself.

    Parameters
    ----------
    wheels : WheelSpeeds, from :func:`wheel_speeds`
    forward_acc_mps2 : (n,) array, m/s², frame IMU, forward
    windows : from :func:`detect_slip`
    sampling_rate_hz : Hz
    settings : SlipSettings

    Returns
    -------
    (n,) array of ``Source``; BOTH_WHEELS outside the windows and in the short ones. The wheel with
    the smaller departure (root mean square) rolls if that is within ``ROLLING_WITHIN_MPS``, or
    within half of what parts the two wheels: then it is nearer to the acceleration than to the
    other wheel, whatever a slope does to the acceleration. Else both slip: ACCELERATION.
    """
    settings = settings or SlipSettings()
    left = as_series(wheels.left, "wheels.left")
    right = as_series(wheels.right, "wheels.right", length=len(left))
    acc = as_series(forward_acc_mps2, "forward_acc_mps2", length=len(left))
    source = np.zeros(len(left), np.int8)
    long = _long_enough(windows, sampling_rate_hz, settings)
    for first, last in zip(windows.first[long], windows.last[long], strict=True):
        here = slice(first, last + 1)
        departures = [
            wheel[here] - _integrated(wheel, acc, first, last, sampling_rate_hz)
            for wheel in (left, right)
        ]
        faster = right[here] > left[here]
        edges = np.r_[0, np.nonzero(np.diff(faster))[0] + 1, last + 1 - first]
        for begin, end in pairwise(edges):
            sizes = [_rms(d[begin:end]) for d in departures]
            best = int(np.argmin(sizes))
            apart = _rms((departures[1] - departures[0])[begin:end])
            rolls = sizes[best] <= max(ROLLING_WITHIN_MPS, apart / 2)
            code = (Source.LEFT_WHEEL, Source.RIGHT_WHEEL)[best] if rolls else Source.ACCELERATION
            source[first + begin : first + end] = code
    return source


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _long_enough(
    windows: SlipWindows, sampling_rate_hz: float, settings: SlipSettings
) -> NDArray[np.bool_]:
    # Counted in samples; the small term keeps 6 frames 6 frames.
    return (windows.last - windows.first + 1) > settings.shortest_s * sampling_rate_hz + 1e-9


def _integrated(
    speed: FloatArray, acc: FloatArray, first: int, last: int, sampling_rate_hz: float
) -> FloatArray:
    """Speed from first to last: the acceleration's integral, tied to the speed beside them."""
    from scipy import integrate

    before, after = max(first - 1, 0), min(last + 1, len(speed) - 1)
    gained = integrate.cumulative_trapezoid(
        acc[before : after + 1], dx=1 / sampling_rate_hz, initial=0
    )
    if first == 0:
        # No speed is known before: lean on the end alone.
        path = speed[after] + gained - gained[-1]
    else:
        path = speed[before] + gained
        if after > last:
            path = path - (path[-1] - speed[after]) * np.linspace(0, 1, len(path))
    return path[first - before : last - before + 1]


@dataclass(frozen=True)
class SlipReport:
    """What was found and changed, window by window and in all.

    Parameters
    ----------
    start_s, end_s : (k,) arrays, s, first and last sample of each window from the recording's start
    corrected : (k,) array of bool; the short windows are only flagged
    largest_change_mps : (k,) array, m/s, of each window
    sources : one text per window: where its speed comes from
    share, corrected_share : of all samples, flagged and corrected, 0 to 1
    """

    start_s: FloatArray
    end_s: FloatArray
    corrected: NDArray[np.bool_]
    largest_change_mps: FloatArray
    sources: tuple[str, ...]
    share: float
    corrected_share: float

    @property
    def largest_change(self) -> float:
        """Largest change of the speed in the whole recording, m/s."""
        return float(self.largest_change_mps.max(initial=0.0))

    def to_frame(self) -> pd.DataFrame:
        """Give a table with one row per window."""
        import pandas as pd

        return pd.DataFrame(
            {
                "start_s": self.start_s,
                "end_s": self.end_s,
                "corrected": self.corrected,
                "largest_change_mps": self.largest_change_mps,
                "speed_from": self.sources,
            }
        )


def slip_report(
    uncorrected_mps: ArrayLike,
    corrected_mps: ArrayLike,
    windows: SlipWindows,
    sampling_rate_hz: float,
    settings: SlipSettings | None = None,
    *,
    source: ArrayLike | None = None,
) -> SlipReport:
    """Sum up a correction, for a methods section.

    Parameters
    ----------
    uncorrected_mps, corrected_mps : (n,) arrays, m/s
    windows : from :func:`detect_slip`
    sampling_rate_hz : Hz
    settings : SlipSettings that were used
    source : (n,) array from :func:`slip_sources`; None for the tool's method

    Returns
    -------
    SlipReport
    """
    before = as_series(uncorrected_mps, "uncorrected_mps")
    change = np.abs(as_series(corrected_mps, "corrected_mps", length=len(before)) - before)
    corrected = _long_enough(windows, sampling_rate_hz, settings or SlipSettings())
    codes = np.full(len(before), Source.ACCELERATION) if source is None else np.asarray(source)
    texts, largest = [], []
    for first, last, long in zip(windows.first, windows.last, corrected, strict=True):
        used = np.unique(codes[first : last + 1]) if long else [Source.BOTH_WHEELS]
        texts.append(" and ".join(Source(code).name.lower().replace("_", " ") for code in used))
        largest.append(change[first : last + 1].max())
    lengths = windows.last - windows.first + 1
    return SlipReport(
        start_s=windows.first / sampling_rate_hz,
        end_s=windows.last / sampling_rate_hz,
        corrected=corrected,
        largest_change_mps=np.array(largest, float),
        sources=tuple(texts),
        share=float(lengths.sum() / len(before)),
        corrected_share=float(lengths[corrected].sum() / len(before)),
    )
