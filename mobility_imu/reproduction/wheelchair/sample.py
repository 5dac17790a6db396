"""WheelMove-ID: its tool's results on its sample recording, and what its printed equations give.

The document prints no results; the public tool made them from the sample, which may not be passed
on. Claims on it are not reproducible unless MOBILITY_IMU_DATA names its folder.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mobility_imu.data import recordings_folder, sample_folder
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.recording import Recording
from mobility_imu.reproduction.claims import Basis, Claim
from mobility_imu.simulation.wheelchair import (
    IDEAL,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    Leg,
    SimulatedDrive,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry
from mobility_imu.wheelchair.slip import detect_slip
from mobility_imu.wheelchair.tasks import Task, TaskSettings, curvature_radius, identify_tasks
from mobility_imu.wheelchair.velocity import Camber, ChairVelocity, estimate_velocity

SAMPLE_CHAIR = WheelchairGeometry.from_degrees(
    19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
)
"""The chair of the sample, from its file ``Properties.txt``."""

SIDES: tuple[Side, Side] = ("left", "right")
NEEDS_SAMPLE = "needs MOBILITY_IMU_DATA"
SHIPPED_VELOCITIES = "2 - For Task Indentification/Propulsion_preprocessed.csv"  # codespell:ignore
BEFORE_SLIP_CORRECTION = "reference-outputs/propulsion_velocity_before_slip_correction.csv"
# Turns slower than this say little about a factor of the yaw rate.
SMALLEST_TURN_RADPS = 0.3
TURN_BACK_AND_FORTH = (Leg(6, 2.0, 1.2, 60.0), Leg(6, 2.0, 1.2, -60.0))


class LabelFile(NamedTuple):
    """Labels that the public tool gave to a velocity series, and the settings it had.

    Parameters
    ----------
    labels : name in ``reference-outputs``
    velocities : file of the sample's folder
    settings : TaskSettings
    what : series and settings in words
    basis : what kind of data the series is
    """

    labels: str
    velocities: str
    settings: TaskSettings
    what: str
    basis: Basis


_FAST = TaskSettings(
    segment_s=0.24,
    linear_velocity_mps=3.4,
    yaw_rate_degps=20.0,
    pivot_radius_m=2.0,
    wide_radius_m=4.0,
    onset_velocity_mps=3.0,
    onset_yaw_rate_degps=10.0,
)
_REAL: Basis = "reproduced on real data"
_SYNTHETIC: Basis = "reproduced on synthetic data"
_SIX = "reference-outputs/velocities_six_tasks.csv"

LABEL_FILES = (
    LabelFile(
        "labels_propulsion_default.csv",
        SHIPPED_VELOCITIES,
        TaskSettings(),
        "sample trial, default thresholds",
        _REAL,
    ),
    LabelFile(
        "labels_propulsion_seg050.csv",
        SHIPPED_VELOCITIES,
        TaskSettings(segment_s=0.5),
        "sample trial, segments of 0.5 s",
        _REAL,
    ),
    LabelFile(
        "labels_propulsion_fast.csv",
        SHIPPED_VELOCITIES,
        _FAST,
        "sample trial, thresholds for a fast chair",
        _REAL,
    ),
    LabelFile(
        "labels_six_tasks_default.csv",
        _SIX,
        TaskSettings(),
        "made-up series with all six tasks, default thresholds",
        _SYNTHETIC,
    ),
    LabelFile(
        "labels_six_tasks_seg050.csv",
        _SIX,
        TaskSettings(segment_s=0.5),
        "made-up series with all six tasks, segments of 0.5 s",
        _SYNTHETIC,
    ),
)


class Sample(NamedTuple):
    """The sample's trial with its calibration, and the tool's velocities before slip correction.

    Parameters
    ----------
    static, straight, trial : Recording
    calibration : WheelchairCalibration
    linear_velocity_mps, wheel_yaw_rate_radps, yaw_rate_radps : (n,) arrays, the tool's
    """

    static: Recording
    straight: Recording
    trial: Recording
    calibration: WheelchairCalibration
    linear_velocity_mps: FloatArray
    wheel_yaw_rate_radps: FloatArray
    yaw_rate_radps: FloatArray


def load_sample(folder: Path) -> Sample:
    """Read the sample's three trials and calibrate; read what the tool made of them.

    Parameters
    ----------
    folder : what :func:`~mobility_imu.data.sample_folder` gives

    Returns
    -------
    Sample
    """
    static, straight, trial = (
        read_recording(folder / "1 - For Data Preprocessing" / f"{name}.csv")
        for name in ("Static", "StraightLine", "Propulsion")
    )
    tool = np.loadtxt(folder / BEFORE_SLIP_CORRECTION, delimiter=",", skiprows=1)
    return Sample(static, straight, trial, calibrate(static, straight), *tool.T[1:])


def differing_labels(folder: Path, reference: LabelFile) -> tuple[int, int]:
    """Count the frames whose task is not the tool's, and all frames.

    Parameters
    ----------
    folder : the sample's
    reference : one of ``LABEL_FILES``

    Returns
    -------
    (differing, all)
    """
    series = read_velocities(folder / reference.velocities)
    ours = identify_tasks(
        series.linear_velocity_mps,
        series.yaw_rate_radps,
        series.sampling_rate_hz,
        reference.settings,
        edge="tool",
    )
    path = folder / "reference-outputs" / reference.labels
    theirs = np.loadtxt(path, delimiter=",", skiprows=1, dtype=int)[:, 1]
    return int(np.count_nonzero(ours != theirs)), len(ours)


def yaw_gain(
    yaw_rate_radps: FloatArray,
    wheel_yaw_rate_radps: FloatArray,
    linear_velocity_mps: FloatArray,
    *,
    side: Side,
) -> tuple[float, float]:
    """Factor between the wheels' and the frame's yaw rate in turns to one side (least squares).

    A radius that is wrong by a share e adds e / distance of the speed to the wheels' yaw rate;
    fitted beside the factor, it does not pass for a part of it.

    Parameters
    ----------
    yaw_rate_radps, wheel_yaw_rate_radps : (n,) arrays, rad/s
    linear_velocity_mps : (n,) array, m/s
    side : turns to the "left" or to the "right", faster than 0.3 rad/s

    Returns
    -------
    factor : 1 if they agree
    share of the speed : rad/m, 0 if the radii are right
    """
    sign = 1 if side == "left" else -1
    turning = sign * yaw_rate_radps > SMALLEST_TURN_RADPS
    causes = np.column_stack([yaw_rate_radps, linear_velocity_mps])[turning]
    factor, share = np.linalg.lstsq(causes, wheel_yaw_rate_radps[turning])[0]
    return float(factor), float(share)


def open_combinations() -> int:
    """Count the combinations of letters (of 36) for which Table 2 names no task.

    Returns
    -------
    int
    """
    from mobility_imu.reproduction.published import load_published

    patterns: dict[str, dict[str, str]] = {}
    for _, cell in load_published("wheelchair_table2").iterrows():
        patterns.setdefault(cell["column"], {})[cell["row"]] = cell["printed"]
    signals = ("linear_velocity", "abs_linear_velocity", "abs_yaw_rate", "curvature_radius")
    combinations = [
        dict(zip(signals, letters, strict=True)) for letters in product("abc", "bc", "bc", "abc")
    ]
    return sum(
        not any(pattern.items() <= letters.items() for pattern in patterns.values())
        for letters in combinations
    )


def claims() -> list[Claim]:
    """Give the tool's results on its sample, and what printed equations say of known motions.

    Returns
    -------
    list of Claim

    Notes
    -----
    Where an equation is checked, the published value is what the equation is meant to give: a
    factor of 1, or the sign that the document states.
    """
    return [*_sample_claims(), *_equation_claims()]


def _sample_claims() -> list[Claim]:
    labels = [
        Claim(
            work="wheelchair",
            where="public tool, task labels",
            what=f"frames labelled otherwise: {reference.what} ({NEEDS_SAMPLE})",
            published_value=0,
            unit="frames",
            basis=reference.basis,
            compute=partial(_on_sample, partial(_label_difference, reference)),
            tolerance=0,
            tolerance_reason="same rules on the same numbers",
        )
        for reference in LABEL_FILES
    ]
    return [
        *labels,
        _sample_claim(
            "public tool, velocity",
            "largest difference before slip correction, camber term as printed",
            0,
            "m/s",
            lambda s: _largest(_velocity(s, "printed").linear_velocity_mps - s.linear_velocity_mps),
            0.004,
            "the tool's alignment matrices are off a rotation by 1.7e-4",
        ),
        _sample_claim(
            "public tool, yaw rate",
            "largest difference of the frame's yaw rate",
            0,
            "deg/s",
            lambda s: _largest(
                np.rad2deg(_velocity(s, "printed").yaw_rate_radps - s.yaw_rate_radps)
            ),
            0.01,
            "the tool takes the vertical from half of the static trial",
        ),
        _sample_claim(
            "public tool, slip",
            "share of frames flagged, camber term as printed",
            100 * 3670 / 12656,
            "%",
            lambda s: 100 * float(_velocity(s, "printed").slip.mean()),
            0.5,
            "frames at the threshold flip with differences of 0.003 rad/s",
        ),
        _sample_claim(
            "public tool, slip",
            "windows flagged, from the tool's own two yaw rates",
            166,
            "windows",
            lambda s: float(
                len(detect_slip(s.yaw_rate_radps, s.wheel_yaw_rate_radps, 100.0).first)
            ),
            0,
            "same rule on the same numbers",
        ),
        _sample_claim(
            "eqs 1.16-1.18 as printed",
            "wheels' over frame's yaw rate, the sample's left turns",
            1,
            "-",
            lambda s: _sample_gain(s, "printed"),
            0.02,
            "a track known to 1 cm of 84, radii to 1 %",
        ),
        _sample_claim(
            "eqs 1.16-1.18 sign-safe",
            "wheels' over frame's yaw rate, the sample's left turns",
            1,
            "-",
            lambda s: _sample_gain(s, "sign-safe"),
            0.02,
            "a track known to 1 cm of 84, radii to 1 %",
        ),
        _sample_claim(
            "eq. 1.12",
            "direction of the resting acceleration, told by the sample's turns; up is +1",
            -1,
            "-",
            _resting_direction,
            0.01,
            "a sign",
        ),
    ]


def _equation_claims() -> list[Claim]:
    known = "radii and track are known to about 1 %"
    return [
        *(
            Claim(
                work="wheelchair",
                where="eqs 1.16-1.18 as printed",
                what=f"wheels' over true yaw rate, ideal sensors, {side} turn",
                published_value=1,
                unit="-",
                basis=_SYNTHETIC,
                compute=partial(_simulated_gain, "printed", side),
                tolerance=0.01,
                tolerance_reason=known,
            )
            for side in SIDES
        ),
        *(
            Claim(
                work="wheelchair",
                where="eqs 1.16-1.18 sign-safe",
                what=f"wheels' over true yaw rate, ideal sensors, {side} turn",
                published_value=1,
                unit="-",
                basis=_SYNTHETIC,
                compute=partial(_simulated_gain, "sign-safe", side),
                tolerance=0.01,
                tolerance_reason=known,
            )
            for side in SIDES
        ),
        Claim(
            work="wheelchair",
            where="eq. 1.17, printed minus",
            what="velocity over the true one, straight line, axles as in eq. 1.7",
            published_value=1,
            unit="-",
            basis=_SYNTHETIC,
            compute=_printed_velocity_share,
            tolerance=0.01,
            tolerance_reason=known,
        ),
        Claim(
            work="wheelchair",
            where="eq. 2.1, units as listed",
            what="radius of a circle of 1 m, yaw rate in deg/s",
            published_value=1,
            unit="m",
            basis="reproduced by geometry alone",
            compute=lambda: float(curvature_radius([1.0], [math.degrees(1.0)])[0]),
            tolerance=0.01,
            tolerance_reason="a unit",
        ),
        Claim(
            work="wheelchair",
            where="Table 2",
            what="combinations of letters without a task (of 36)",
            published_value=0,
            unit="-",
            basis="published numbers recomputed",
            compute=lambda: float(open_combinations()),
            tolerance=0,
            tolerance_reason="a count of printed letters",
        ),
        Claim(
            work="wheelchair",
            where="section 2",
            what="tasks found on the simulated court",
            published_value=6,
            unit="tasks",
            basis=_SYNTHETIC,
            compute=_tasks_on_court,
            tolerance=0,
            tolerance_reason="all six are driven for seconds, well inside the limits of Table 1",
        ),
    ]


def _sample_claim(
    where: str,
    what: str,
    published_value: float,
    unit: str,
    compute: Callable[[Sample], float],
    tolerance: float,
    tolerance_reason: str,
) -> Claim:
    return Claim(
        work="wheelchair",
        where=where,
        what=f"{what} ({NEEDS_SAMPLE})",
        published_value=published_value,
        unit=unit,
        basis=_REAL,
        compute=partial(_on_sample, lambda folder: compute(load_sample(folder))),
        tolerance=tolerance,
        tolerance_reason=tolerance_reason,
    )


def _on_sample(compute: Callable[[Path], float]) -> float:
    folder = sample_folder()
    return math.nan if folder is None else compute(folder)


def _label_difference(reference: LabelFile, folder: Path) -> float:
    return float(differing_labels(folder, reference)[0])


def _velocity(sample: Sample, camber: Camber) -> ChairVelocity:
    return estimate_velocity(sample.trial, sample.calibration, SAMPLE_CHAIR, camber=camber)


def _sample_gain(sample: Sample, camber: Camber) -> float:
    found = _velocity(sample, camber)
    return yaw_gain(
        found.yaw_rate_radps, found.wheel_yaw_rate_radps, found.linear_velocity_mps, side="left"
    )[0]


def _resting_direction(sample: Sample) -> float:
    """Give +1 if turns to the left are positive about the acceleration at rest.

    The right wheel is the faster one in a left turn, and left turns are positive about the
    vertical that points up: the wheels tell where up is, without gravity.
    """
    resting = sample.static.sensor("frame").acc_mps2.mean(axis=0)
    about = np.asarray(sample.trial.sensor("frame").gyr_radps) @ resting
    radius = SAMPLE_CHAIR.wheel_radius_m
    left, right = (
        np.asarray(sample.trial.sensor(f"{side}_wheel").gyr_radps)
        @ sample.calibration.rotation_imu_to_wheel(side)[2]
        for side in SIDES
    )
    return float(np.sign((radius.right * right - radius.left * left) @ about))


def _simulate(legs: tuple[Leg, ...]) -> tuple[SimulatedDrive, WheelchairCalibration]:
    mounting = random_mounting(1)
    still, line, drive = (
        simulate_drive(part, SAMPLE_CHAIR, mounting, seed=1, noise=IDEAL)
        for part in (STATIC_TRIAL, STRAIGHT_TRIAL, legs)
    )
    return drive, calibrate(still.recording, line.recording)


def _simulated_gain(camber: Camber, side: Side) -> float:
    drive, calibration = _simulate(TURN_BACK_AND_FORTH)
    found = estimate_velocity(drive.recording, calibration, SAMPLE_CHAIR, camber=camber)
    return yaw_gain(
        drive.yaw_rate_radps, found.wheel_yaw_rate_radps, drive.linear_velocity_mps, side=side
    )[0]


def _printed_velocity_share() -> float:
    drive, calibration = _simulate(STRAIGHT_TRIAL)
    radius = SAMPLE_CHAIR.wheel_radius_m
    left, right = (
        np.asarray(drive.recording.sensor(f"{side}_wheel").gyr_radps)
        @ calibration.rotation_imu_to_wheel(side)[2]
        for side in SIDES
    )
    printed = (left * radius.left - right * radius.right) / 2
    return float(printed @ drive.linear_velocity_mps) / float(
        drive.linear_velocity_mps @ drive.linear_velocity_mps
    )


def _tasks_on_court() -> float:
    folder = recordings_folder() / "wheelchair_court"
    static, straight, court = (
        read_recording(folder / f"{name}.csv.gz") for name in ("static", "straight", "court")
    )
    geometry = WheelchairGeometry.from_toml(folder / "geometry.toml")
    found = estimate_velocity(court, calibrate(static, straight), geometry)
    codes = identify_tasks(found.linear_velocity_mps, found.yaw_rate_radps, court.sampling_rate_hz)
    return float(len(set(codes.tolist()) & set(Task)))


def _largest(difference: FloatArray) -> float:
    return float(np.abs(difference).max())
