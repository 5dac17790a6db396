"""WheelMove-ID's public sample recording, and what the public tool answered, recorded by us.

The sample may not be passed on: ``data/README.md`` says where it is to be had, and the variable
MOBILITY_IMU_DATA names its folder. The tool's answers to the sample are not part of it; we recorded
them in its subfolder ``reference-outputs``, which nobody else has. The tool's answers to a made-up
series are bundled in ``data/reference``.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mobility_imu.data import reference_folder
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.recording import Recording
from mobility_imu.reproduction.published import load_published
from mobility_imu.results import Result
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount
from mobility_imu.wheelchair.geometry import Side, side_sign
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.tasks import task_codes

TRIAL_FILES = tuple(
    f"1 - For Data Preprocessing/{name}.csv" for name in ("Static", "StraightLine", "Propulsion")
)
SHIPPED_VELOCITIES = "2 - For Task Indentification/Propulsion_preprocessed.csv"  # codespell:ignore
SAMPLE_RATE_HZ = 100.0
"""As the sample's ``Properties.txt`` states it."""
SAMPLE_FILES = (*TRIAL_FILES, SHIPPED_VELOCITIES)
"""What is read of the sample, by name in its folder."""

TOOL_VELOCITIES = "reference-outputs/propulsion_velocity_before_slip_correction.csv"
"""Where we recorded the tool's velocities of the sample trial; not part of the public sample."""

SIGNALS = ("linear_velocity", "abs_linear_velocity", "abs_yaw_rate", "curvature_radius")
"""Rows of the document's two tables, in the order of the print."""

TASK_NAMES = ("static", "forward", "backward", "pivot", "tight", "wide")
"""Columns of Table 2, in the order of the print and of the task codes."""

# Turns slower than this say little about a factor of the yaw rate.
SMALLEST_TURN_RADPS = 0.3


class LabelFile(NamedTuple):
    """A velocity series, and where the labels are that the public tool gave to it.

    Parameters
    ----------
    labels : file name
    velocities : file name
    settings : TaskSettings that the tool had
    what : series and settings in words
    bundled : True if both lie in ``data/reference``; otherwise they lie in the sample's folder
    """

    labels: str
    velocities: str
    settings: TaskSettings
    what: str
    bundled: bool

    def folder(self, sample: Path | None) -> Path | None:
        """Folder of both files, None if they are not here.

        Parameters
        ----------
        sample : what :func:`~mobility_imu.data.sample_folder` gives
        """
        folder = reference_folder() if self.bundled else sample
        return folder if folder is not None and (folder / self.labels).is_file() else None


FAST = TaskSettings(
    segment_s=0.24,
    linear_velocity_mps=3.4,
    yaw_rate_degps=20.0,
    pivot_radius_m=2.0,
    wide_radius_m=4.0,
    onset_velocity_mps=3.0,
    onset_yaw_rate_degps=10.0,
)
"""Thresholds between which the sample's fast chair changes its task often."""


def _on_sample(name: str, settings: TaskSettings, what: str) -> LabelFile:
    labels = f"reference-outputs/labels_propulsion_{name}.csv"
    return LabelFile(labels, SHIPPED_VELOCITIES, settings, f"sample trial, {what}", False)


def _made_up(name: str, settings: TaskSettings, what: str) -> LabelFile:
    series = "made-up series with all six tasks"
    labels = f"labels_six_tasks_{name}.csv.gz"
    return LabelFile(labels, "velocities_six_tasks.csv.gz", settings, f"{series}, {what}", True)


LABEL_FILES = (
    _on_sample("default", TaskSettings(), "default thresholds"),
    _on_sample("seg050", TaskSettings(segment_s=0.5), "segments of 0.5 s"),
    _on_sample("fast", FAST, "thresholds for a fast chair"),
    _made_up("default", TaskSettings(), "default thresholds"),
    _made_up("seg050", TaskSettings(segment_s=0.5), "segments of 0.5 s"),
)


class Sample(NamedTuple):
    """The sample's three trials and the calibration from the first two.

    Parameters
    ----------
    static, straight, trial : Recording
    calibration : WheelchairCalibration, with the gyroscopes' offsets left in, as the public tool
        has them: the trial itself has no rest
    """

    static: Recording
    straight: Recording
    trial: Recording
    calibration: WheelchairCalibration


@dataclass(frozen=True, eq=False, repr=False)
class ToolVelocities(Result):
    """What the public tool made of the sample trial before its slip correction.

    Parameters
    ----------
    linear_velocity_mps, wheel_yaw_rate_radps, yaw_rate_radps : (n,) arrays
    """

    linear_velocity_mps: FloatArray
    wheel_yaw_rate_radps: FloatArray
    yaw_rate_radps: FloatArray


def load_sample(folder: Path) -> Sample:
    """Read the sample's three trials and calibrate.

    Parameters
    ----------
    folder : what :func:`~mobility_imu.data.sample_folder` gives

    Returns
    -------
    Sample
    """
    static, straight, trial = (
        understand(folder / name, sampling_rate_hz=SAMPLE_RATE_HZ).recording for name in TRIAL_FILES
    )
    calibration = calibrate_mount(static, straight, take_off_offsets=False)
    return Sample(static, straight, trial, calibration)


def load_tool_velocities(folder: Path) -> ToolVelocities | None:
    """Read what the tool made of the sample trial, if that was recorded in this folder.

    Parameters
    ----------
    folder : what :func:`~mobility_imu.data.sample_folder` gives

    Returns
    -------
    ToolVelocities, or None: the public sample does not contain them
    """
    path = folder / TOOL_VELOCITIES
    if not path.is_file():
        return None
    return ToolVelocities(*np.loadtxt(path, delimiter=",", skiprows=1).T[1:])


def differing_labels(reference: LabelFile, folder: Path) -> int:
    """Count the frames whose task is not the tool's, with its rule for the first frames.

    Parameters
    ----------
    reference : one of ``LABEL_FILES``
    folder : from :meth:`LabelFile.folder`

    Returns
    -------
    int, of all frames of the series
    """
    series = read_velocities(folder / reference.velocities)
    ours = task_codes(
        series.linear_velocity_mps,
        series.yaw_rate_radps,
        series.sampling_rate_hz,
        reference.settings,
        edge="tool",
    )
    path = folder / reference.labels
    theirs = np.loadtxt(path, delimiter=",", skiprows=1, usecols=1, dtype=np.int8)
    if len(ours) != len(theirs):
        raise InputError(f"{path}: {len(theirs)} labels for a series of {len(ours)} frames")
    return int(np.count_nonzero(ours != theirs))


def yaw_gain(
    yaw_rate_radps: FloatArray,
    wheel_yaw_rate_radps: FloatArray,
    linear_velocity_mps: FloatArray,
    *,
    side: Side,
) -> tuple[float, float]:
    """Factor between the wheels' and the frame's yaw rate in turns to one side (least squares).

    Radii that are wrong by unlike fractions add a fraction of the speed to the wheels' yaw rate.
    It is fitted beside the factor, so that it does not pass for a part of it.

    Parameters
    ----------
    yaw_rate_radps, wheel_yaw_rate_radps : (n,) arrays, rad/s, left positive
    linear_velocity_mps : (n,) array, m/s
    side : turns to the "left" or to the "right", faster than 0.3 rad/s

    Returns
    -------
    factor : 1 if they agree
    part of the speed : rad/m, 0 if the radii are right
    """
    turning = side_sign(side) * yaw_rate_radps > SMALLEST_TURN_RADPS
    causes = np.column_stack([yaw_rate_radps, linear_velocity_mps])[turning]
    factor, share = np.linalg.lstsq(causes, wheel_yaw_rate_radps[turning])[0]
    return float(factor), float(share)


def open_combinations() -> int:
    """Count the combinations of letters (of 36) for which Table 2 names no task.

    Returns
    -------
    int
    """
    patterns = printed_patterns().values()
    return sum(
        not any(pattern.items() <= letters.items() for pattern in patterns)
        for letters in letter_combinations()
    )


def printed_patterns() -> dict[str, dict[str, str]]:
    """Letters that Table 2 prints for each task, by signal; an empty cell has no entry.

    Returns
    -------
    dict from task to dict from signal to letter
    """
    patterns: dict[str, dict[str, str]] = {name: {} for name in TASK_NAMES}
    for _, cell in load_published("wheelchair_table2").iterrows():
        patterns[cell["column"]][cell["row"]] = cell["printed"]
    return patterns


def letter_combinations() -> list[dict[str, str]]:
    """All 36 combinations of the letters that the four signals can have."""
    letters = product("abc", "bc", "bc", "abc")
    return [dict(zip(SIGNALS, combination, strict=True)) for combination in letters]
