"""Suzurikawa et al. 2022, the driving test: 4 drivers, 3 runs, 5 courses, on many drawn scooters.

No recording is public. Rides are simulated with the assumptions of
``mobility_imu.simulation.scooter``, many of them set by hand. What comes out is a distribution
over scooters that the paper's could have been, never a copy of the paper's one.

:mod:`mobility_imu.reproduction.scooter.driving_record` keeps the whole study.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.frames import FloatArray, wrap_angle
from mobility_imu.reproduction.scooter.driving_rides import (
    ANGLES,
    DRIVERS,
    PAPER_ESTIMATORS,
    PUBLISHED_LIMIT_DEG,
    RUNS,
    Calibration,
    Conditions,
    Corrections,
    Estimator,
    RideInputs,
    inputs_of,
    known_mounting,
    make_ride,
    motion_and_truth,
)
from mobility_imu.reproduction.scooter.paper_method import PAPER_MEDIAN_WINDOW
from mobility_imu.scooter.fusion import complementary_angles, fuse_angles
from mobility_imu.scooter.fusion_settings import FusionSettings
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.simulation.scooter import COURSES, SimulatedRide, draw_scooter

if TYPE_CHECKING:
    import pandas as pd

CALIBRATED_SD_RAD = np.full(6, np.deg2rad(0.4))
"""What a calibration on level ground and a ramp states of the mounting, in the median."""
BIN_DEG = 2.0
"""Bin width of Figure 8."""
DURATION_EDGES_DEG = {
    "steering": np.arange(-71.0, 72.0, BIN_DEG),
    "throttle": np.arange(-21.0, 62.0, BIN_DEG),
}
"""Bin edges of Figure 8 in deg, for both angles."""
ERROR_EDGES_DEG = np.arange(0.0, 40.5, 0.5)
"""Bins of Figure 9; the last one also takes what is beyond."""


def _with_gyroscopes(ride: RideInputs) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    return ride.lever_acc, ride.lever_gyr, ride.body_acc, ride.body_gyr


def _complementary(ride: RideInputs) -> FloatArray:
    angles = complementary_angles(*_with_gyroscopes(ride), ride.rate_hz, SUZUKI_ET4D)
    return np.column_stack(angles)[ride.moving]


def _fused(ride: RideInputs, smooth: bool) -> FloatArray:
    assumed = FusionSettings()
    if ride.calibrated:
        assumed = assumed.after_calibration(CALIBRATED_SD_RAD)
    angles = fuse_angles(*_with_gyroscopes(ride), ride.rate_hz, SUZUKI_ET4D, assumed, smooth=smooth)
    return np.column_stack([angles.steering_rad, angles.throttle_rad])[ride.moving]


def _filter(ride: RideInputs) -> FloatArray:
    return _fused(ride, smooth=False)


def _smoother(ride: RideInputs) -> FloatArray:
    return _fused(ride, smooth=True)


ESTIMATORS: dict[str, Estimator] = {
    **PAPER_ESTIMATORS,
    "complementary filter": _complementary,
    "Kalman filter": _filter,
    "smoother": _smoother,
}
"""Those without gyroscopes; and three with them, of which only the smoother looks ahead (as the
medians do)."""


@dataclass(frozen=True)
class StudySettings:
    """What to drive and what to estimate; all that a worker needs.

    Parameters
    ----------
    drivers, runs : how many of each, on every course
    courses : names from ``mobility_imu.simulation.scooter.COURSES``
    estimators : names from :data:`ESTIMATORS`
    calibrations : name to what finds the mounting, or None for none at all; module-level functions,
        so that they can be sent to another process
    conditions : Conditions
    histograms : whether to fill the histograms, too
    """

    drivers: int = DRIVERS
    runs: int = RUNS
    courses: tuple[str, ...] = tuple(COURSES)
    estimators: tuple[str, ...] = tuple(ESTIMATORS)
    calibrations: Mapping[str, Calibration | None] = field(
        default_factory=lambda: {"as drawn": None, "known": known_mounting}
    )
    conditions: Conditions = field(default_factory=Conditions)
    histograms: bool = False

    def __post_init__(self) -> None:
        """Check numbers and names."""
        if not 1 <= self.drivers <= 16 or not 1 <= self.runs <= 16:
            raise InputError(
                f"drivers = {self.drivers}, runs = {self.runs}: expected 1 to 16 of each"
            )
        for name, known in (("courses", COURSES), ("estimators", ESTIMATORS)):
            unknown = set(getattr(self, name)) - set(known)
            if unknown:
                raise InputError(f"{name}: no {sorted(unknown)}; there are {list(known)}")


class DrivingStudy(NamedTuple):
    """Errors of all estimators on all drawn scooters.

    Parameters
    ----------
    table : DataFrame with one row per ``scooter`` (its seed), ``course``, ``mounting`` (name of the
        calibration), ``estimator``, ``angle`` (steering, throttle) and ``against`` (wire, truth):
        ``p90_deg`` and ``mae_deg`` of the absolute error over the samples in motion of all
        drivers and runs, and their number ``n``
    durations_s : (course, mounting, estimator, angle) to (k, k) array, s: time spent at each true
        (first axis, by the wire sensors) and estimated angle, bins :data:`DURATION_EDGES_DEG`, all
        scooters together; what lies outside counts in the outermost bins
    errors : (scooter, course, mounting, estimator, angle) to counts of absolute errors against the
        wire sensors, bins :data:`ERROR_EDGES_DEG`
    """

    table: pd.DataFrame
    durations_s: dict[tuple[str, str, str, str], FloatArray]
    errors: dict[tuple[int, str, str, str, str], NDArray[np.int64]]


class _Part(NamedTuple):
    rows: list[tuple[Any, ...]]
    durations_s: dict[tuple[str, str, str, str], FloatArray]
    errors: dict[tuple[int, str, str, str, str], NDArray[np.int64]]


COLUMNS = (
    "scooter", "course", "mounting", "estimator", "angle", "against", "p90_deg", "mae_deg", "n",
)  # fmt: skip


def driving_study(
    scooters: Sequence[int],
    settings: StudySettings | None = None,
    *,
    executor: Executor | None = None,
) -> DrivingStudy:
    """Drive all courses on every drawn scooter and measure every estimator's error.

    Parameters
    ----------
    scooters : seeds; each draws one scooter's mounting and sensors. The drivers are the same.
    settings : StudySettings; None is the whole study
    executor : anything with ``submit``, which then gets one task per scooter; None computes here

    Returns
    -------
    DrivingStudy
        The same bytes for any executor and number of workers.

    Raises
    ------
    InputError
        If a scooter appears twice or is negative.
    """
    import pandas as pd

    settings = settings or StudySettings()
    seeds = [int(seed) for seed in scooters]
    if not seeds or min(seeds) < 0 or len(set(seeds)) != len(seeds):
        raise InputError(f"scooters = {seeds}: expected different seeds, none negative")
    parts = run_all(study_scooter, [(seed, settings) for seed in seeds], executor)
    durations: dict[tuple[str, str, str, str], FloatArray] = {}
    errors: dict[tuple[int, str, str, str, str], NDArray[np.int64]] = {}
    for part in parts:
        errors |= part.errors
        for key, values in part.durations_s.items():
            durations[key] = durations.get(key, 0.0) + values
    table = pd.DataFrame([row for part in parts for row in part.rows], columns=list(COLUMNS))
    return DrivingStudy(table, durations, errors)


def study_scooter(scooter: int, settings: StudySettings) -> _Part:
    """Part of one scooter; see :func:`driving_study`.

    Parameters
    ----------
    scooter : seed
    settings : StudySettings

    Returns
    -------
    rows, durations and error counts of this scooter
    """
    unit = draw_scooter(scooter)
    if not settings.conditions.mounting:
        unit = replace(unit, lever_mounting=(0.0, 0.0, 0.0), body_mounting=(0.0, 0.0, 0.0))
    corrections = {
        mounting: None if calibration is None else calibration(unit)
        for mounting, calibration in settings.calibrations.items()
    }
    rows: list[tuple[Any, ...]] = []
    durations: dict[tuple[str, str, str, str], FloatArray] = {}
    counts: dict[tuple[int, str, str, str, str], NDArray[np.int64]] = {}
    for course in settings.courses:
        # By mounting and estimator: one (n, 2) array per ride, and what to compare it with.
        found: dict[tuple[str, str], list[FloatArray]] = {}
        compare: dict[str, list[FloatArray]] = {"wire": [], "truth": []}
        for driver in range(settings.drivers):
            for run in range(settings.runs):
                ride = make_ride(scooter, course, driver, run, settings.conditions, unit=unit)
                moving, truth = motion_and_truth(ride)
                for against, values in truth.items():
                    compare[against].append(values)
                for mounting, turns in corrections.items():
                    inputs = inputs_of(ride, moving, turns, settings.conditions.median_window)
                    for name in settings.estimators:
                        angles = ESTIMATORS[name](inputs)
                        found.setdefault((mounting, name), []).append(angles)
        joined = {against: np.concatenate(values) for against, values in compare.items()}
        for (mounting, name), pieces in found.items():
            estimate = np.concatenate(pieces)
            for k, angle in enumerate(ANGLES):
                for against, values in joined.items():
                    off = np.abs(np.rad2deg(wrap_angle(estimate[:, k] - values[:, k])))
                    p90, mae = float(np.quantile(off, 0.9)), float(off.mean())
                    rows.append(
                        (scooter, course, mounting, name, angle, against, p90, mae, len(off))
                    )
                    if settings.histograms and against == "wire":
                        counts[scooter, course, mounting, name, angle] = np.histogram(
                            np.minimum(off, ERROR_EDGES_DEG[-1]), ERROR_EDGES_DEG
                        )[0]
                        durations[course, mounting, name, angle] = _durations(
                            angle, values[:, k], estimate[:, k]
                        )
    return _Part(rows, durations, counts)


def estimate_ride(
    ride: SimulatedRide,
    moving: NDArray[np.bool_],
    estimators: Sequence[str] = tuple(ESTIMATORS),
    *,
    corrections: Corrections | None = None,
    window: int = PAPER_MEDIAN_WINDOW,
) -> dict[str, FloatArray]:
    """Run estimators on one ride: name to (k, 2) array, rad, of the k samples in motion.

    Parameters
    ----------
    ride : SimulatedRide
    moving : (n,) bool array, see ``motion_and_truth``
    estimators : names from :data:`ESTIMATORS`
    corrections : rotations of both IMUs to {T} and {B}; None for none
    window : samples of the paper's median

    Returns
    -------
    dict of name to (k, 2) array, rad
    """
    inputs = inputs_of(ride, moving, corrections, window)
    return {name: ESTIMATORS[name](inputs) for name in estimators}


def _durations(angle: str, true_rad: FloatArray, estimate_rad: FloatArray) -> FloatArray:
    edges = DURATION_EDGES_DEG[angle]
    true, estimate = (
        np.clip(np.rad2deg(values), edges[0], edges[-1] - 1e-9)
        for values in (true_rad, estimate_rad)
    )
    return np.asarray(
        np.histogram2d(true, estimate, bins=(edges, edges))[0] * 0.01
    )  # samples at 100 Hz


STATEMENTS = (
    "dual, steering: 90 % of errors below 10 deg on all courses",
    "dual, throttle: 90 % of errors below 5 deg on all courses",
    "steering: dual below single on all courses",
    "throttle: dual below single on all courses",
)
"""Statements of section 3.2 on Figure 9."""


def statements(
    study: DrivingStudy, *, mounting: str = "as drawn", against: str = "wire"
) -> pd.DataFrame:
    """For which drawn scooters the paper's statements hold.

    Parameters
    ----------
    study : DrivingStudy
    mounting : name of the calibration
    against : "wire" or "truth"

    Returns
    -------
    DataFrame of bools, one row per scooter, one column for each of :data:`STATEMENTS`
    """
    import pandas as pd

    table = study.table
    rows = table[(table["mounting"] == mounting) & (table["against"] == against)]
    p90 = rows.pivot_table(
        index=["scooter", "course"], columns=["angle", "estimator"], values="p90_deg"
    )
    holds = {}
    for text, angle in zip(STATEMENTS[:2], ANGLES, strict=True):
        holds[text] = p90[angle, "dual"] < PUBLISHED_LIMIT_DEG[angle]
    for text, angle in zip(STATEMENTS[2:], ANGLES, strict=True):
        holds[text] = p90[angle, "dual"] < p90[angle, "single"]
    return pd.DataFrame(holds).groupby(level="scooter").all()


def summary(
    study: DrivingStudy, *, mounting: str = "as drawn", against: str = "wire"
) -> pd.DataFrame:
    """Median, smallest and largest P90 over the scooters, by estimator, angle and course.

    Parameters
    ----------
    study : DrivingStudy
    mounting : name of the calibration
    against : "wire" or "truth"

    Returns
    -------
    DataFrame with median, min and max, deg; index estimator, angle, course
    """
    table = study.table
    rows = table[(table["mounting"] == mounting) & (table["against"] == against)]
    grouped = rows.groupby(["estimator", "angle", "course"], sort=False)["p90_deg"]
    return grouped.agg(["median", "min", "max"])


def show_summary(table: pd.DataFrame) -> pd.DataFrame:
    """Summary for reading: courses side by side, "median (smallest-largest)".

    Parameters
    ----------
    table : what :func:`summary` returns

    Returns
    -------
    DataFrame of text; index estimator and angle, one column per course
    """
    cells = [f"{row.median:.1f} ({row.min:.1f}-{row.max:.1f})" for row in table.itertuples()]
    flat = table.index.to_frame(index=False).assign(cell=cells)
    wide = flat.pivot_table(
        index=["estimator", "angle"], columns="course", values="cell", aggfunc="first", sort=False
    )
    return wide.rename_axis(columns=None)
