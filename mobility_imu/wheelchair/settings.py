"""Settings of the task identification, and their files: thresholds of Table 1 and of step 4."""

from __future__ import annotations

import json
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.readers.table import read_text


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
        for name, value in asdict(self).items():
            if not isinstance(value, int | float) or not np.isfinite(value) or value < 0:
                raise InputError(f"{name} = {value!r}: expected a positive number")
            if value == 0 and name in ("segment_s", "linear_velocity_mps", "yaw_rate_degps"):
                raise InputError(f"{name} = 0: expected a positive number")
        if self.pivot_radius_m > self.wide_radius_m:
            raise InputError(
                f"pivot_radius_m = {self.pivot_radius_m} is larger than "
                f"wide_radius_m = {self.wide_radius_m}"
            )

    def frames(self, sampling_rate_hz: float) -> tuple[int, int]:
        """Length of a segment and of the look window, in frames.

        A segment that is no whole number of frames is rounded, with a warning (the public tool
        goes on with the fraction and labels most frames wrongly).
        """
        exact = self.segment_s * sampling_rate_hz
        count = round(exact)
        if count < 1:
            raise InputError(
                f"segment_s = {self.segment_s} is less than one frame at {sampling_rate_hz:g} Hz"
            )
        if abs(exact - count) > 1e-6 * exact:
            warnings.warn(
                f"segment of {self.segment_s} s is {exact:g} frames at {sampling_rate_hz:g} Hz: "
                f"rounded to {count}",
                stacklevel=3,
            )
        return count, round(self.look_s * sampling_rate_hz)


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
    """Settings of a JSON file, and the sampling rate if it states one."""

    settings: TaskSettings
    sampling_rate_hz: float | None


def read_settings(path: str | Path) -> SettingsFile:
    """Read settings from JSON, with the public tool's keys or with ours.

    The tool writes a zero as null: null is read as 0.

    Raises
    ------
    InputError
        If it is not a JSON object of numbers, or has an unknown key.
    """
    try:
        content: Any = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not valid JSON ({error})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a JSON object of settings")
    values: dict[str, float] = {}
    rate = None
    ours = set(TaskSettings.__dataclass_fields__)
    for key, raw in content.items():
        try:
            value = 0.0 if raw is None else float(raw)
        except (TypeError, ValueError):
            raise InputError(f"{path}: {key} = {raw!r}, expected a number") from None
        if key == "freqAcq":
            rate = value
        elif key in _TOOL_KEYS or key in ours:
            values[_TOOL_KEYS.get(str(key), str(key))] = value
        else:
            known = ", ".join([*_TOOL_KEYS, "freqAcq"])
            raise InputError(f"{path}: {key} is not a setting (known: {known})")
    try:
        return SettingsFile(TaskSettings(**values), rate)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
