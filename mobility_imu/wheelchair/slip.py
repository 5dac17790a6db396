"""Wheel slip: where wheels and frame disagree on the yaw rate, and what to put there instead.

Slip is found by the public tool's rule (it is not in version 0 of the document), with frames turned
into seconds. There are two corrections. The tool integrates the frame's acceleration. Ours first
finds which wheel slips: with the frame's yaw rate known, either wheel alone gives the speed, and
the one that still rolls agrees with the acceleration. It integrates only where neither does.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import check_columns, expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_count, as_number, as_series, check_positive, one_of
from mobility_imu.results import Result
from mobility_imu.runs import changes_of, runs_of
from mobility_imu.wheelchair.geometry import WheelchairGeometry

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "SlipMethod",
    "SlipReport",
    "SlipSettings",
    "SlipWindows",
    "Source",
    "WheelSpeeds",
    "correct_slip",
    "detect_slip",
    "slip_report",
    "slip_sources",
    "wheel_speeds",
]

SlipMethod = Literal["wheels", "tool"]
# A wheel that rolls departs from the integrated acceleration by what a frame that rocks by 1
# degree makes of it in half a second: 9.8 sin(1 deg) 0.5 s.
ROLLING_WITHIN_MPS = 0.09
MOST_SAMPLES = 10**9
"""Samples that a recording may have at most: a day at 10 kHz."""
SLOWEST_CORNER = 1e-7
"""Corner over sampling rate below which a low-pass of doubles has lost its digits."""


class Source(IntEnum):
    """Where a sample's speed comes from."""

    BOTH_WHEELS = 0
    LEFT_WHEEL = 1
    RIGHT_WHEEL = 2
    ACCELERATION = 3


@dataclass(frozen=True, eq=False, repr=False)
class WheelSpeeds(Result):
    """The chair's speed from each wheel alone.

    Parameters
    ----------
    left, right : (n,) arrays, m/s, finite
    """

    left: FloatArray
    right: FloatArray

    def __post_init__(self) -> None:
        """Check that both are series of one length."""
        object.__setattr__(self, "left", as_series(self.left, "wheels.left"))
        right = as_series(self.right, "wheels.right", length=len(self.left))
        object.__setattr__(self, "right", right)
        super().__post_init__()


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
    wheel_yaw_rate_radps : (n,) array, rad/s, from spins and track (the corrected form)
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
    expect("geometry", geometry, WheelchairGeometry)
    velocity = as_series(linear_velocity_mps, "linear_velocity_mps")
    excess = as_series(
        wheel_yaw_rate_radps, "wheel_yaw_rate_radps", length=len(velocity)
    ) - as_series(yaw_rate_radps, "yaw_rate_radps", length=len(velocity))
    half = excess * geometry.track_m / 2
    return WheelSpeeds(velocity - half, velocity + half)


MOSTLY_AT_ODDS = 0.5
"""More slip than this part of the turning time is none: something is wrong with a sensor."""


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
        """Check the numbers."""
        check_positive(self, allow_zero=("merge_gap_s",))


@dataclass(frozen=True, eq=False, repr=False)
class SlipWindows(Result):
    """First and last sample of each window of slip.

    Parameters
    ----------
    first, last : (k,) arrays of whole numbers, rising; last is not before first
    settings : SlipSettings that the windows were found with

    Raises
    ------
    InputError
        If the two differ in length, are no whole numbers, or are out of order.
    """

    first: NDArray[np.int64]
    last: NDArray[np.int64]
    settings: SlipSettings = SlipSettings()

    def __post_init__(self) -> None:
        """Check that the windows follow one another."""
        expect("settings", self.settings, SlipSettings)
        first, last = (
            as_series(getattr(self, name), f"windows.{name}") for name in ("first", "last")
        )
        whole = all((ends == np.round(ends)).all() for ends in (first, last))
        if len(first) != len(last) or not whole:
            raise InputError("windows: expected as many first as last samples, whole numbers")
        if (first < 0).any() or (last < first).any() or (first[1:] <= last[:-1]).any():
            raise InputError("windows: expected windows that end before the next one begins")
        object.__setattr__(self, "first", first.astype(np.int64))
        object.__setattr__(self, "last", last.astype(np.int64))
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of windows."""
        return len(self.first)

    def within(self, count: int) -> SlipWindows:
        """The same windows, checked to lie inside a recording.

        Parameters
        ----------
        count : samples of the recording

        Raises
        ------
        InputError
            If the last window ends after the recording.
        """
        as_count(count, "count", least=0)
        if len(self) and self.last[-1] >= count:
            raise InputError(
                f"windows: the last one ends at sample {self.last[-1]}, but there are {count} "
                "samples; were they found in another recording?"
            )
        return self

    def flags(self, count: int) -> NDArray[np.bool_]:
        """One flag per sample, True inside the windows.

        Parameters
        ----------
        count : samples of the recording

        Returns
        -------
        (count,) bool array

        Raises
        ------
        InputError
            If the last window ends after the recording, or no recording is so long.
        """
        self.within(count)
        if count > MOST_SAMPLES:
            raise InputError(
                f"count = {count}: expected the samples of the recording, at most {MOST_SAMPLES} "
                "(a day at 10 kHz)"
            )
        flags = np.zeros(count, np.bool_)
        for first, last in zip(self.first, self.last, strict=True):
            flags[first : last + 1] = True
        return flags


CHECK_SENSORS = (
    "is a sensor dead, late, exchanged or turned? Check each sensor's name and place, and record "
    "again"
)
"""What :func:`at_odds` asks."""


def at_odds(
    slip: ArrayLike,
    wheel_yaw_rate_radps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    settings: SlipSettings,
    source: str,
) -> tuple[str, ...]:
    """Warning where wheels and frame disagree too long for any slip.

    Parameters
    ----------
    slip : (n,) bool array
    wheel_yaw_rate_radps, yaw_rate_radps : (n,) arrays, rad/s, of the wheels and of the frame
    settings : SlipSettings
    source : the first words of the message

    Returns
    -------
    tuple of str, empty or with one sentence
    """
    flags = np.asarray(slip, bool)
    turning = np.abs(np.asarray(wheel_yaw_rate_radps)) + np.abs(np.asarray(yaw_rate_radps))
    moving = turning > settings.threshold_radps
    part = float(flags[moving].mean()) if moving.any() else 0.0
    if part <= MOSTLY_AT_ODDS:
        return ()
    return (
        f"{source}: wheels and frame disagree in {100 * part:.0f} % of the time in which one of "
        f"them turns; no wheel slips so long: {CHECK_SENSORS}",
    )


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
    settings = settings_or_default("settings", settings, SlipSettings)
    yaw = as_series(yaw_rate_radps, "yaw_rate_radps")
    wheels = as_series(wheel_yaw_rate_radps, "wheel_yaw_rate_radps", length=len(yaw))
    fs = as_number(sampling_rate_hz, "sampling_rate_hz")
    runs = runs_of(np.abs(yaw - wheels) > settings.threshold_radps)
    first = np.array([run.start for run in runs], np.int64)
    last = np.array([run.stop - 1 for run in runs], np.int64)
    if not runs:
        return SlipWindows(first, last, settings)
    # Counted between samples, as the tool does; the small term keeps 10 frames 10 frames.
    together = (first[1:] - last[:-1]) < settings.merge_gap_s * fs - 1e-9
    return SlipWindows(first[np.r_[True, ~together]], last[np.r_[~together, True]], settings)


def correct_slip(
    linear_velocity_mps: ArrayLike,
    forward_acc_mps2: ArrayLike,
    windows: SlipWindows,
    sampling_rate_hz: float,
    settings: SlipSettings | None = None,
    *,
    wheels: WheelSpeeds | None = None,
    method: SlipMethod = "wheels",
) -> FloatArray:
    """Replace the mean of the wheels by something better in the longer slip windows.

    Parameters
    ----------
    linear_velocity_mps : (n,) array, m/s, mean of the wheels
    forward_acc_mps2 : (n,) array, m/s², frame IMU, forward
    windows : from :func:`detect_slip`
    sampling_rate_hz : Hz
    settings : SlipSettings; those that the windows were found with if None
    wheels : WheelSpeeds, from :func:`wheel_speeds`; method "wheels" needs them
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
        If the method is neither, or "wheels" has no wheel speeds; "tool": if the sampling rate is
        too low or too high for the low-pass.
    """
    expect("windows", windows, SlipWindows)
    settings = windows.settings if settings is None else settings
    expect("settings", settings, SlipSettings)
    one_of("method", method, ("wheels", "tool"))
    velocity = as_series(linear_velocity_mps, "linear_velocity_mps").copy()
    acc = as_series(forward_acc_mps2, "forward_acc_mps2", length=len(velocity))
    sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    long = _long_enough(windows.within(len(velocity)), sampling_rate_hz, settings)
    if method == "wheels":
        if wheels is None:
            raise InputError("wheels: method 'wheels' needs the speed from each wheel")
        expect("wheels", wheels, WheelSpeeds)
        as_series(wheels.left, "wheels.left", length=len(velocity))
        source = slip_sources(wheels, acc, windows, sampling_rate_hz, settings)
        for first, last in zip(windows.first[long], windows.last[long], strict=True):
            here = slice(first, last + 1)
            if (source[here] == Source.ACCELERATION).any():
                velocity[here] = _integrated(velocity, acc, first, last, sampling_rate_hz)
        velocity = np.where(source == Source.LEFT_WHEEL, wheels.left, velocity)
        return np.where(source == Source.RIGHT_WHEEL, wheels.right, velocity)
    if settings.low_pass_hz >= sampling_rate_hz / 2:
        raise InputError(
            f"low_pass_hz = {settings.low_pass_hz:g}: expected less than half the sampling rate of "
            f"{sampling_rate_hz:g} Hz; record faster, or lower it in SlipSettings"
        )
    if settings.low_pass_hz < SLOWEST_CORNER * sampling_rate_hz:
        raise InputError(
            f"low_pass_hz = {settings.low_pass_hz:g}: expected at least {SLOWEST_CORNER:g} of the "
            f"sampling rate of {sampling_rate_hz:g} Hz; raise it in SlipSettings"
        )
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
    disagreement changes sign, slip may have changed wheels: each interval is judged by itself.

    Parameters
    ----------
    wheels : WheelSpeeds, from :func:`wheel_speeds`
    forward_acc_mps2 : (n,) array, m/s², frame IMU, forward
    windows : from :func:`detect_slip`
    sampling_rate_hz : Hz
    settings : SlipSettings; those that the windows were found with if None

    Returns
    -------
    (n,) array of ``Source``; BOTH_WHEELS outside the windows and in the short ones. The wheel with
    the smaller departure (root mean square) rolls if that is within ``ROLLING_WITHIN_MPS``, or
    within half of what parts the two wheels: then it is nearer to the acceleration than to the
    other wheel, whatever a slope does to the acceleration. Else both slip: ACCELERATION.
    """
    expect("windows", windows, SlipWindows)
    settings = windows.settings if settings is None else settings
    expect("settings", settings, SlipSettings)
    expect("wheels", wheels, WheelSpeeds)
    left, right = wheels.left, wheels.right
    acc = as_series(forward_acc_mps2, "forward_acc_mps2", length=len(left))
    sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    source = np.zeros(len(left), np.int8)
    long = _long_enough(windows.within(len(left)), sampling_rate_hz, settings)
    for first, last in zip(windows.first[long], windows.last[long], strict=True):
        here = slice(first, last + 1)
        departures = [
            wheel[here] - _integrated(wheel, acc, first, last, sampling_rate_hz)
            for wheel in (left, right)
        ]
        edges = [*changes_of(right[here] > left[here]), last + 1 - first]
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
    return np.asarray(path[first - before : last - before + 1])


@dataclass(frozen=True, eq=False, repr=False)
class SlipReport(Result):
    """What was found and changed, window by window and in all.

    Parameters
    ----------
    start_s, end_s : (k,) arrays, s, first and last sample of each window from the recording's start
    corrected : (k,) array of bool; the short windows are only flagged
    largest_change_mps : (k,) array, m/s, of each window
    sources : one text per window: where its speed comes from
    share, corrected_share : of all samples, flagged and corrected, 0 to 1
    settings : SlipSettings that were used
    warnings : sentences for the user
    """

    start_s: FloatArray
    end_s: FloatArray
    corrected: NDArray[np.bool_]
    largest_change_mps: FloatArray
    sources: tuple[str, ...]
    share: float
    corrected_share: float
    settings: SlipSettings = SlipSettings()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that there is one entry for each window."""
        check_columns(self, "start_s", "end_s", "largest_change_mps", flags=("corrected",))
        sources = [str, len(self.start_s)]
        check_fields(
            self, sources=sources, share=float, corrected_share=float, settings=SlipSettings
        )
        super().__post_init__()

    @property
    def largest_change(self) -> float:
        """Largest change of the speed in the whole recording, m/s."""
        return float(self.largest_change_mps.max(initial=0.0))

    def to_frame(self) -> pd.DataFrame:
        """Table with one row per window.

        Returns
        -------
        DataFrame
            ``start_s``, ``end_s``, ``corrected``, ``largest_change_mps`` and ``speed_from``
        """
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
    settings : SlipSettings; those that the windows were found with if None
    source : (n,) array from :func:`slip_sources`; None for the tool's method

    Returns
    -------
    SlipReport
    """
    expect("windows", windows, SlipWindows)
    settings = windows.settings if settings is None else settings
    expect("settings", settings, SlipSettings)
    before = as_series(uncorrected_mps, "uncorrected_mps")
    count = len(before)
    change = np.abs(as_series(corrected_mps, "corrected_mps", length=count) - before)
    sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    corrected = _long_enough(windows.within(count), sampling_rate_hz, settings)
    codes = np.full(count, float(Source.ACCELERATION)) if source is None else source
    codes = as_series(codes, "source", length=count)
    if not np.isin(codes, list(Source)).all():
        raise InputError("source: expected codes of Source, 0 to 3")
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
        share=float(lengths.sum() / max(count, 1)),
        corrected_share=float(lengths[corrected].sum() / max(count, 1)),
        settings=settings,
    )
