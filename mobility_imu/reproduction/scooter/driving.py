"""Suzurikawa et al. 2022, the driving test: 4 drivers, 3 runs, 5 courses, on many drawn scooters.

No recording is public. Rides are simulated with the assumptions of
``mobility_imu.simulation.scooter``, many of them set by hand. What comes out is a distribution
over scooters that the paper's could have been, never a copy of the paper's one.

:mod:`mobility_imu.reproduction.scooter.driving_record` keeps the whole study.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, wrap_angle
from mobility_imu.reproduction.scooter.paper_method import PAPER_MEDIAN_WINDOW, paper_angles
from mobility_imu.scooter.fusion import complementary_angles, fuse_angles
from mobility_imu.scooter.fusion_settings import FusionSettings
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.scooter.pulses import moving_samples, reference_angles, synchronise
from mobility_imu.simulation.scooter import (
    COURSES,
    NO_SHAKING,
    PERFECT_REFERENCE,
    SMOOTH_GROUND,
    Ground,
    Layout,
    Reference,
    ScooterUnit,
    Shaking,
    SimulatedRide,
    draw_driver,
    draw_scooter,
    simulate_ride,
)
from mobility_imu.simulation.sensor import IDEAL, LPMS_CU2, SensorModel

if TYPE_CHECKING:
    import pandas as pd

DRIVERS = 4
RUNS = 3
LONGEST_GAP_S = 1.0
"""Seconds between two pulses (0.2 m apart) beyond which the scooter counts as standing; ours."""
LONGER_WINDOW = 101
"""Samples in the window of the fair baseline without gyroscopes (one second)."""
CALIBRATED_SD_RAD = np.full(6, np.deg2rad(0.4))
"""What a calibration on level ground and a ramp states of the mounting, in the median."""
ANGLES = ("steering", "throttle")
BIN_DEG = 2.0
"""Bin width of Figure 8."""
DURATION_EDGES_DEG = {
    "steering": np.arange(-71.0, 72.0, BIN_DEG),
    "throttle": np.arange(-21.0, 62.0, BIN_DEG),
}
"""Bin edges of Figure 8 in deg, for both angles."""
ERROR_EDGES_DEG = np.arange(0.0, 40.5, 0.5)
"""Bins of Figure 9; the last one also takes what is beyond."""
PUBLISHED_LIMIT_DEG = {"steering": 10.0, "throttle": 5.0}

Corrections = tuple[FloatArray, FloatArray]
"""Rotations from the lever's and the body's IMU axes to {T} and {B}."""
Calibration = Callable[[ScooterUnit], Corrections]


def known_mounting(unit: ScooterUnit) -> Corrections:
    """True mounting of both IMUs, as a calibration without error would find it.

    Parameters
    ----------
    unit : ScooterUnit

    Returns
    -------
    lever, body : (3, 3) arrays, rotations from the IMU's axes to {T} and {B}
    """
    lever, body = (
        Rotation.from_rotvec(tilt).as_matrix() for tilt in (unit.lever_mounting, unit.body_mounting)
    )
    return lever, body


@dataclass(frozen=True)
class Conditions:
    """What the rides are made of, and the window they are smoothed with.

    Parameters
    ----------
    layout, ground, shaking, reference, sensor : see ``mobility_imu.simulation.scooter``
    mounting : whether the IMUs are mounted with an error
    median_window : samples, of the paper's filter
    """

    layout: Layout = field(default_factory=Layout)
    ground: Ground = field(default_factory=Ground)
    shaking: Shaking = field(default_factory=Shaking)
    reference: Reference = field(default_factory=Reference)
    sensor: SensorModel = LPMS_CU2
    mounting: bool = True
    median_window: int = PAPER_MEDIAN_WINDOW


def ablations() -> dict[str, Conditions]:
    """Full model, then the model with one effect switched off at a time, then with few left."""
    full = Conditions()
    nothing = Conditions(
        layout=Layout.together(),
        ground=SMOOTH_GROUND,
        shaking=NO_SHAKING,
        reference=PERFECT_REFERENCE,
        sensor=IDEAL,
        mounting=False,
        median_window=1,
    )
    return {
        "everything": full,
        "no lever arms": replace(full, layout=Layout.together()),
        "no roughness": replace(full, ground=replace(full.ground, roughness_m=0.0)),
        "no bumps on the paving": replace(full, ground=replace(full.ground, tactile_m=0.0)),
        "bumps in step with wheelbase": replace(
            full, ground=replace(full.ground, tactile_pitch_m=(0.06, 0.06))
        ),
        "no camber or grade": replace(
            full, ground=replace(full.ground, grade_sd_rad=0.0, bank_sd_rad=0.0)
        ),
        "no local vibration": replace(
            full, shaking=replace(full.shaking, vibration_mps2=0.0, tactile_mps2=0.0)
        ),
        "no spikes": replace(full, shaking=replace(full.shaking, spikes_per_s=0.0)),
        "no mounting error": replace(full, mounting=False),
        "ideal sensor": replace(full, sensor=IDEAL),
        "perfect reference": replace(full, reference=PERFECT_REFERENCE),
        "no median filter": replace(full, median_window=1),
        "lever arms only": replace(nothing, layout=full.layout, median_window=PAPER_MEDIAN_WINDOW),
        "mounting error only": replace(nothing, mounting=True, median_window=PAPER_MEDIAN_WINDOW),
        "nothing": nothing,
    }


class _Inputs(NamedTuple):
    """What an estimator may see of a ride."""

    lever_acc: FloatArray
    lever_gyr: FloatArray
    body_acc: FloatArray
    body_gyr: FloatArray
    rate_hz: float
    moving: NDArray[np.bool_]
    window: int
    calibrated: bool


Estimator = Callable[[_Inputs], FloatArray]


def _paper(ride: _Inputs, method: Any, window: int, edge: Any) -> FloatArray:
    angles = paper_angles(
        ride.lever_acc,
        ride.body_acc,
        ride.moving,
        SUZUKI_ET4D,
        method=method,
        window=window,
        edge=edge,
    )
    return np.column_stack([angles.steering_rad, angles.throttle_rad])


def _single(ride: _Inputs) -> FloatArray:
    return _paper(ride, "single", ride.window, "zero")


def _dual(ride: _Inputs) -> FloatArray:
    return _paper(ride, "dual", ride.window, "zero")


def _subtraction(ride: _Inputs) -> FloatArray:
    return _paper(ride, "subtraction", ride.window, "zero")


def _body_x_only(ride: _Inputs) -> FloatArray:
    # Eq. 6 with the body's x as measured, but C1 = g sin(alpha): the body's y and z do not enter.
    level = np.broadcast_to([0.0, 0.0, STANDARD_GRAVITY_MPS2], ride.body_acc.shape).copy()
    level[:, 0] = ride.body_acc[:, 0]
    return _paper(ride._replace(body_acc=level), "dual", ride.window, "zero")


def _longer_median(ride: _Inputs) -> FloatArray:
    # Zeros beyond the ends would spoil a whole second of each ride: not a fair baseline.
    return _paper(ride, "dual", LONGER_WINDOW, "nearest")


def _with_gyroscopes(ride: _Inputs) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    return ride.lever_acc, ride.lever_gyr, ride.body_acc, ride.body_gyr


def _complementary(ride: _Inputs) -> FloatArray:
    angles = complementary_angles(*_with_gyroscopes(ride), ride.rate_hz, SUZUKI_ET4D)
    return np.column_stack(angles)[ride.moving]


def _fused(ride: _Inputs, smooth: bool) -> FloatArray:
    assumed = FusionSettings()
    if ride.calibrated:
        assumed = assumed.after_calibration(CALIBRATED_SD_RAD)
    angles = fuse_angles(*_with_gyroscopes(ride), ride.rate_hz, SUZUKI_ET4D, assumed, smooth=smooth)
    return np.column_stack([angles.steering_rad, angles.throttle_rad])[ride.moving]


def _filter(ride: _Inputs) -> FloatArray:
    return _fused(ride, smooth=False)


def _smoother(ride: _Inputs) -> FloatArray:
    return _fused(ride, smooth=True)


ESTIMATORS: dict[str, Estimator] = {
    "single": _single,
    "dual": _dual,
    "subtraction": _subtraction,
    "body's x only": _body_x_only,
    "dual, longer median": _longer_median,
    "complementary filter": _complementary,
    "Kalman filter": _filter,
    "smoother": _smoother,
}
"""The paper's two; its reference 37's; a probe that shows why reference 37's does well; the paper's
dual estimate with a median over 101 samples; and three with gyroscopes, of which only the smoother
looks ahead (as the medians do)."""


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
                    inputs = _inputs(ride, moving, turns, settings.conditions.median_window)
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


def make_ride(
    scooter: int,
    course: str,
    driver: int,
    run: int,
    conditions: Conditions,
    *,
    unit: ScooterUnit | None = None,
) -> SimulatedRide:
    """One run of the study. Scooter, course, driver and run make its seed, no two alike.

    Parameters
    ----------
    scooter : seed
    course : name in ``mobility_imu.simulation.scooter.COURSES``
    driver, run : numbers from 0 to 15
    conditions : Conditions
    unit : ScooterUnit; None draws that of the seed

    Returns
    -------
    SimulatedRide
    """
    place = list(COURSES).index(course)
    return simulate_ride(
        COURSES[course],
        seed=((scooter * len(COURSES) + place) * 16 + driver) * 16 + run,
        unit=draw_scooter(scooter) if unit is None else unit,
        driver=draw_driver(driver),
        layout=conditions.layout,
        ground=conditions.ground,
        shaking=conditions.shaking,
        reference=conditions.reference,
        sensor=conditions.sensor,
    )


def motion_and_truth(ride: SimulatedRide) -> tuple[NDArray[np.bool_], dict[str, FloatArray]]:
    """Samples in motion by the pulses, with wire sensors and truth at these samples.

    Parameters
    ----------
    ride : SimulatedRide

    Returns
    -------
    moving : (n,) bool array
    truth : "wire" and "truth" to (k, 2) arrays, rad, steering and throttle of the k samples
    """
    time_s = ride.recording.time_s
    moving = moving_samples(time_s, ride.pulses_s, longest_gap_s=LONGEST_GAP_S)
    offset = synchronise(ride.pulses_s, ride.reference_pulses_s)
    wire = reference_angles(time_s, ride.reference_time_s, ride.reference, offset.offset_s)
    true = np.column_stack([ride.steering_rad, ride.throttle_rad])
    return moving, {"wire": wire[moving], "truth": true[moving]}


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
    moving : (n,) bool array, see :func:`motion_and_truth`
    estimators : names from :data:`ESTIMATORS`
    corrections : rotations of both IMUs to {T} and {B}; None for none
    window : samples of the paper's median

    Returns
    -------
    dict of name to (k, 2) array, rad
    """
    inputs = _inputs(ride, moving, corrections, window)
    return {name: ESTIMATORS[name](inputs) for name in estimators}


def _inputs(
    ride: SimulatedRide,
    moving: NDArray[np.bool_],
    corrections: Corrections | None,
    window: int,
) -> _Inputs:
    recording = ride.recording
    lever, body = (recording.sensor(name).acc_mps2 for name in ("lever", "body"))
    lever_gyr, body_gyr = (recording.gyroscope(name) for name in ("lever", "body"))
    if corrections is not None:
        to_lever, to_body = (turn.T for turn in corrections)
        lever, lever_gyr = lever @ to_lever, lever_gyr @ to_lever
        body, body_gyr = body @ to_body, body_gyr @ to_body
    rate_hz = recording.sampling_rate_hz
    calibrated = corrections is not None
    return _Inputs(lever, lever_gyr, body, body_gyr, rate_hz, moving, window, calibrated)


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
