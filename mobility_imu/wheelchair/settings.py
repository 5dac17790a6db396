"""Settings of the task identification, and their files: thresholds of Table 1 and of step 4."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from mobility_imu.errors import InputError
from mobility_imu.frames import as_number, check_positive
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.settings import read_json_numbers
from mobility_imu.readers.wording import listed

__all__ = [
    "NamedSettings",
    "SettingsFile",
    "TaskSettings",
    "read_named_settings",
    "read_settings",
]

MAY_BE_ZERO = (
    "pivot_radius_m",
    "wide_radius_m",
    "onset_velocity_mps",
    "onset_yaw_rate_degps",
    "look_s",
)
MOST_FRAMES = 10**9
"""No recording is longer; a segment of more frames comes from a wrong unit."""


@dataclass(frozen=True)
class TaskSettings:
    """Thresholds of Table 1 and of step 4; the document's values are the defaults.

    Parameters
    ----------
    segment_s : s, length of a segment of the aggregate approximation
    linear_velocity_mps : m/s, below it (in size) the chair does not travel
    yaw_rate_degps : deg/s, from it on the chair turns (Table 1 prints ">", the tool takes ">=")
    pivot_radius_m, wide_radius_m : m, up to the first a turn is a pivot, from the second on wide
    onset_velocity_mps, onset_yaw_rate_degps : m/s and deg/s, where a task begins and ends. The
        document gives only the first; 10 deg/s is the tool's.
    look_s : s, how far step 4 looks for them; the tool looks 30 frames, which is this at 100 Hz

    Raises
    ------
    InputError
        For a value that is not a positive number, or radii out of order.

    Examples
    --------
    >>> TaskSettings(segment_s=0.5).look_s
    0.3
    """

    segment_s: float = 0.25
    linear_velocity_mps: float = 0.5
    yaw_rate_degps: float = 40.0
    pivot_radius_m: float = 0.2
    wide_radius_m: float = 0.5
    onset_velocity_mps: float = 0.1
    onset_yaw_rate_degps: float = 10.0
    look_s: float = 0.30

    def __post_init__(self) -> None:
        """Check each value."""
        check_positive(self, allow_zero=MAY_BE_ZERO)
        if self.pivot_radius_m > self.wide_radius_m:
            raise InputError(
                f"pivot_radius_m = {self.pivot_radius_m} is larger than "
                f"wide_radius_m = {self.wide_radius_m}"
            )

    def frames(self, sampling_rate_hz: float) -> tuple[int, int]:
        """Length of a segment and of the look window.

        A segment that is no whole number of frames is rounded (:meth:`rounding` tells of it; the
        public tool goes on with the fraction and labels most frames wrongly).

        Parameters
        ----------
        sampling_rate_hz : Hz

        Returns
        -------
        segment, look : frames

        Raises
        ------
        InputError
            If a segment is shorter than a frame, or no recording is as long.
        """
        rate = as_number(sampling_rate_hz, "sampling_rate_hz")
        for name, seconds in (("segment_s", self.segment_s), ("look_s", self.look_s)):
            if not seconds * rate <= MOST_FRAMES:
                raise InputError(
                    f"{name} = {seconds:g}: more than {MOST_FRAMES:.0e} frames at {rate:g} Hz; "
                    "is it in s?"
                )
        segment = round(self.segment_s * rate)
        if segment < 1:
            raise InputError(f"segment_s = {self.segment_s} is less than one frame at {rate:g} Hz")
        return segment, round(self.look_s * rate)

    def rounding(self, sampling_rate_hz: float) -> tuple[str, ...]:
        """Warning that a segment is no whole number of frames, if it is none.

        Parameters
        ----------
        sampling_rate_hz : Hz

        Returns
        -------
        tuple of one sentence, or empty
        """
        count, _ = self.frames(sampling_rate_hz)
        exact = self.segment_s * sampling_rate_hz
        if abs(exact - count) <= 1e-6 * exact:
            return ()
        return (
            f"segment of {self.segment_s} s is {exact:g} frames at {sampling_rate_hz:g} Hz: "
            f"rounded to {count}",
        )


# The tool's keys; freqAcq stands beside them.
_TOOL_KEYS = {
    "inptSegmentsec": "segment_s",
    "seuilVitLinAbs": "linear_velocity_mps",
    "seuilVitAngAbs": "yaw_rate_degps",
    "seuilRayonMin": "pivot_radius_m",
    "seuilRayonMax": "wide_radius_m",
    "newSeuilVitLinAbs": "onset_velocity_mps",
    "newSeuilVitAngAbs": "onset_yaw_rate_degps",
}


class SettingsFile(NamedTuple):
    """Settings of a JSON file, and the sampling rate if it states one.

    Parameters
    ----------
    settings : TaskSettings
    sampling_rate_hz : Hz, or None
    """

    settings: TaskSettings
    sampling_rate_hz: float | None


@dataclass(frozen=True)
class NamedSettings:
    """Settings of a file, and the names that they have there.

    Parameters
    ----------
    settings : TaskSettings
    sampling_rate_hz : Hz, or None
    keys : name of a setting to the key of the file; of one that the file leaves out, to the key
        that the file would have it under
    """

    settings: TaskSettings
    sampling_rate_hz: float | None
    keys: Mapping[str, str]

    def as_typed(self, error: InputError) -> str:
        """Message on these settings with the keys of the file.

        Parameters
        ----------
        error : raised for one of them

        Returns
        -------
        str
        """
        return _with_keys(str(error), self.keys)


def _with_keys(message: str, keys: Mapping[str, str]) -> str:
    """Message in which each setting has its key's name."""
    for name, key in keys.items():
        message = re.sub(rf"\b(?:{TaskSettings.__name__}\.)?{name}(?= (?:=|is) )", key, message)
    return message


def read_settings(path: str | Path) -> SettingsFile:
    """Settings from a JSON file, with the public tool's keys or with ours.

    The tool writes a zero as null: null is read as 0.

    Parameters
    ----------
    path : JSON file of one object of numbers; ``freqAcq`` is the sampling rate in Hz

    Returns
    -------
    SettingsFile

    Raises
    ------
    InputError
        If it is not a JSON object of numbers, has an unknown key, two values for one setting, or a
        value that is impossible, or the sampling rate is none that a sensor has.
    """
    named = read_named_settings(path)
    return SettingsFile(named.settings, named.sampling_rate_hz)


def read_named_settings(path: str | Path) -> NamedSettings:
    """Settings of a JSON file as :func:`read_settings` reads them, with the file's own names.

    Parameters
    ----------
    path : JSON file

    Returns
    -------
    NamedSettings

    Raises
    ------
    InputError
        As for :func:`read_settings`.
    """
    found = read_json_numbers(path)
    numbers = {key: 0.0 if value is None else value for key, value in found.items()}
    rate = numbers.pop("freqAcq", None)
    if rate is not None:
        if found["freqAcq"] is None:
            raise InputError(f"{path}: freqAcq = null, expected the sampling rate in Hz")
        check_rate(rate, f"{path}: freqAcq")
    ours = tuple(TaskSettings.__dataclass_fields__)
    unknown = [key for key in numbers if key not in _TOOL_KEYS and key not in ours]
    if unknown:
        known = ", ".join([*ours, *_TOOL_KEYS, "freqAcq"])
        raise InputError(f"{path}: {listed(unknown)} is not a setting (known: {known})")
    values: dict[str, float] = {}
    keys: dict[str, str] = {}
    for key, value in numbers.items():
        name = _TOOL_KEYS.get(key, key)
        if name in values and values[name] != value:
            raise InputError(
                f"{path}: {key} = {value:g}, but {keys[name]} = {values[name]:g} as well"
            )
        values[name] = value
        keys.setdefault(name, key)
    if not _TOOL_KEYS.keys().isdisjoint(numbers):
        keys = {name: key for key, name in _TOOL_KEYS.items()} | keys
    try:
        return NamedSettings(TaskSettings(**values), rate, keys)
    except InputError as error:
        text = _with_keys(str(error), keys)
        for key in (key for key, value in found.items() if value is None):
            text = text.replace(f"{key} = 0.0", f"{key} = null, which is read as 0")
        raise InputError(f"{path}: {text}") from None
