"""Walker: what rests, thresholds and the forms of eq. 24 do to a simulated walk.

Small studies of the chapters on navigation. Each takes walks that it is given, with their truth.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.walker.studies import DATASHEET
from mobility_imu.reproduction.walker.tables import POSES, pose_mount
from mobility_imu.runs import runs_of
from mobility_imu.simulation.sensor import MTI_1, SensorModel, without
from mobility_imu.simulation.walker import (
    CORRIDOR,
    PERFECT,
    REALISTIC,
    Imperfections,
    Leg,
    SimulatedWalker,
    attach_imu,
    simulate_walk,
)
from mobility_imu.walker.error_state import Form
from mobility_imu.walker.navigation import (
    Navigation,
    NavigationSettings,
    integrate_strapdown,
    navigate,
)
from mobility_imu.walker.stillness import StillnessSettings, find_stillness
from mobility_imu.walker.trajectory import trajectory_from_path

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "NOISE_ONLY",
    "closing_errors",
    "consistency_table",
    "corridor_walks",
    "creep_m",
    "distance_error",
    "form_table",
    "four_paths",
    "margin_table",
    "path_error",
    "readings",
    "stride_table",
    "threshold_table",
    "walks",
]

NOISE_ONLY = without(DATASHEET, "clock_rate_sd")
"""What the data sheet states of the sensor (noise, bias, range), and an exact clock."""
FORMS: dict[Form, str] = {"corrected": "derived", "printed": "our copy's"}
STRIDES = ((1, 1), (8, 1), (8, 2), (8, 4))
"""Most samples in a stride of a moving and of a resting frame; the last are the standard ones."""


def readings(walk: SimulatedWalker) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Clock, accelerometer and gyroscope of a simulated walk.

    Parameters
    ----------
    walk : SimulatedWalker

    Returns
    -------
    (n,) s, (n, 3) m/s², (n, 3) rad/s arrays
    """
    frame = walk.recording.sensor("frame")
    return walk.recording.time_s, frame.acc_mps2, walk.recording.gyroscope("frame")


def walks(
    path: Sequence[Leg],
    seeds: Iterable[int],
    sensor: SensorModel,
    imperfections: Imperfections = PERFECT,
) -> list[SimulatedWalker]:
    """Simulated walks: one for each mounting of Table 1 and each seed.

    Parameters
    ----------
    path : legs of the walk
    seeds : at most 10, from 0 on; the five mountings have other random numbers
    sensor : SensorModel
    imperfections : of the frame and its user

    Returns
    -------
    list of SimulatedWalker, the seeds of one mounting beside each other
    """
    made = []
    for k, pose in enumerate(POSES, 1):
        for seed in seeds:
            number = 10 * seed + k
            motion = simulate_walk(path, seed=number, imperfections=imperfections)
            made.append(attach_imu(motion, pose_mount(pose), sensor, seed=number, unit_seed=number))
    return made


def corridor_walks(seeds: Iterable[int] = (1, 2)) -> dict[str, list[SimulatedWalker]]:
    """Walks of 10 m at two levels.

    Parameters
    ----------
    seeds : as in :func:`walks`

    Returns
    -------
    dict: "datasheet" has the data sheet's noise and bias and a frame that stands firmly;
        "realistic" adds scale and misalignment, and a frame that rocks, creeps and lands hard
    """
    seeds = list(seeds)
    return {
        "datasheet": walks(CORRIDOR, seeds, NOISE_ONLY),
        "realistic": walks(CORRIDOR, seeds, MTI_1, REALISTIC),
    }


def creep_m(walk: SimulatedWalker) -> float:
    """How far the frame creeps forward in all rests of a walk, from the truth.

    Parameters
    ----------
    walk : SimulatedWalker

    Returns
    -------
    float, m
    """
    x = walk.position_body_m[:, 0]
    return float(sum(x[run.stop - 1] - x[run.start] for run in runs_of(walk.stationary)))


def _rests(walk: SimulatedWalker, detector: StillnessSettings | None) -> NDArray[np.bool_]:
    _, acc, gyr = readings(walk)
    return find_stillness(acc, gyr, walk.recording.sampling_rate_hz, detector)


def path_error(
    walk: SimulatedWalker, settings: NavigationSettings | None = None, *, smooth: bool = False
) -> tuple[Navigation, FloatArray, FloatArray]:
    """Path by the filter, and its errors against the truth in the filter's own world axes.

    Parameters
    ----------
    walk : SimulatedWalker
    settings : of the filter
    smooth : whether the smoother follows

    Returns
    -------
    Navigation, and errors (found minus true) of position and velocity, (n, 3) m and m/s
    """
    path = navigate(*readings(walk), _rests(walk, None), settings, smooth=smooth)
    truth, level = walk.path_in_axes(path.rotation_imu_to_world()[0])
    return path, path.position_m - truth, path.velocity_mps - walk.velocity_imu_mps @ level.T


def four_paths(walk: SimulatedWalker) -> dict[str, Navigation]:
    """Paths of the IMU from one recording: integrated, with resets, filtered, smoothed.

    Parameters
    ----------
    walk : SimulatedWalker

    Returns
    -------
    dict of Navigation by method; all start from the filter's first state
    """
    given, still = readings(walk), _rests(walk, None)
    filtered = navigate(*given, still, smooth=False)
    start = filtered.state(0)
    return {
        "no update": integrate_strapdown(*given, start),
        "velocity set to 0": integrate_strapdown(*given, start, still=still),
        "filter": filtered,
        "filter and smoother": navigate(*given, still),
    }


def distance_error(
    walk: SimulatedWalker, detector: StillnessSettings | None = None
) -> tuple[float, float]:
    """Error of the distance of a straight walk, and how much of it the detector finds still.

    Parameters
    ----------
    walk : SimulatedWalker
    detector : StillnessSettings

    Returns
    -------
    float, float : m, found minus true; fraction of the samples
    """
    still = _rests(walk, detector)
    path = trajectory_from_path(navigate(*readings(walk), still), walk.mount)
    return float(np.linalg.norm(path.position_m[-1, :2]) - walk.distance_m), float(still.mean())


def threshold_table(
    levels: Mapping[str, Sequence[SimulatedWalker]], thresholds: Iterable[tuple[float, float]]
) -> pd.DataFrame:
    """Error of the distance by level and by the thresholds of the stillness detector.

    Parameters
    ----------
    levels : name to walks
    thresholds : of rate (rad/s) and deviation of the specific force (m/s²)

    Returns
    -------
    DataFrame : level, thresholds, mean and sd of the error, mean of its size (m); samples found
        still and samples in which the frame stands (%)
    """
    import pandas as pd

    rows = []
    for level, made in levels.items():
        standing = 100 * np.mean([walk.stationary.mean() for walk in made])
        for rate_radps, deviation_mps2 in thresholds:
            detector = StillnessSettings(rate_radps, deviation_mps2)
            errors, still = np.array([distance_error(walk, detector) for walk in made]).T
            rows.append(
                {
                    "level": level,
                    "rate, rad/s": rate_radps,
                    "force, m/s²": deviation_mps2,
                    "error, m": errors.mean(),
                    "sd, m": errors.std(),
                    "mean abs, m": np.abs(errors).mean(),
                    "still, %": 100 * still.mean(),
                    "standing, %": standing,
                }
            )
    return pd.DataFrame(rows)


def margin_table(
    made: Sequence[SimulatedWalker],
    margins_s: Iterable[tuple[float, float]] = ((0.07, 0.04), (0.07, 0.0), (0.0, 0.0)),
    thresholds: Iterable[tuple[float, float]] = ((0.05, 0.25), (0.08, 0.5), (0.12, 0.7)),
) -> pd.DataFrame:
    """Mean error of the distance by the quiet that the detector asks for around a sample.

    Parameters
    ----------
    made : walks
    margins_s : pairs of ``margin_s`` and ``shorten_s`` of the detector, s; their sum is the quiet
    thresholds : as in :func:`threshold_table`

    Returns
    -------
    DataFrame : quiet (s), and one column of mean errors (m) for each threshold of the rate
    """
    import pandas as pd

    thresholds = list(thresholds)
    rows = []
    for margin_s, shorten_s in margins_s:
        row = {"quiet around, s": margin_s + shorten_s}
        for rate_radps, deviation_mps2 in thresholds:
            detector = StillnessSettings(
                rate_radps, deviation_mps2, margin_s=margin_s, shorten_s=shorten_s
            )
            errors = [distance_error(walk, detector)[0] for walk in made]
            row[f"error at {rate_radps:g} rad/s, m"] = float(np.mean(errors))
        rows.append(row)
    return pd.DataFrame(rows)


def stride_table(
    levels: Mapping[str, Sequence[SimulatedWalker]],
    strides: Sequence[tuple[int, int]] = STRIDES,
) -> pd.DataFrame:
    """What steps of the covariance over several samples change, against one step per sample.

    Parameters
    ----------
    levels : name to walks
    strides : samples in a stride of a moving and of a resting frame; the first is the reference

    Returns
    -------
    DataFrame : level, strides, updates per still sample (%), largest change of the path (mm) and of
        a standard deviation (%), rms error of the path (mm), mean normalised innovation squared
    """
    import pandas as pd

    rows = []
    for level, made in levels.items():
        reference: list[Navigation] = []
        for moving, resting in strides:
            settings = NavigationSettings(moving_stride=moving, resting_stride=resting)
            results = [path_error(walk, settings, smooth=True) for walk in made]
            paths = [path for path, _, _ in results]
            reference = reference or paths
            pairs = list(zip(paths, reference, strict=True))
            squares = [np.mean(np.sum(error**2, axis=1)) for _, error, _ in results]
            updates = sum(np.count_nonzero(path.nis_dof) for path in paths)
            rows.append(
                {
                    "level": level,
                    "moving": moving,
                    "resting": resting,
                    "updates per still sample, %": 100
                    * updates
                    / sum(path.still.sum() for path in paths),
                    "path changed by, mm": 1e3
                    * max(np.abs(a.position_m - b.position_m).max() for a, b in pairs),
                    "sd changed by, %": 100 * max(np.abs(a.sd / b.sd - 1).max() for a, b in pairs),
                    "rms error, mm": 1e3 * np.sqrt(np.mean(squares)),
                    "NIS": mean_nis(paths),
                }
            )
    return pd.DataFrame(rows)


def mean_nis(paths: Iterable[Navigation]) -> float:
    """Mean square of the normalised innovations of several paths; 1 if the stated sd are right.

    Parameters
    ----------
    paths : Navigation each

    Returns
    -------
    float
    """
    paths = list(paths)
    return float(sum(p.nis.sum() for p in paths) / sum(p.nis_dof.sum() for p in paths))


def consistency_table(levels: Mapping[str, Sequence[SimulatedWalker]]) -> pd.DataFrame:
    """How large the filter's errors are against the standard deviations that it states.

    Parameters
    ----------
    levels : name to walks

    Returns
    -------
    DataFrame : level, mean normalised innovation squared, mean squared error of the end over its
        variance, and how many ends lie within 2 sd (%); x and y of the end count each
    """
    import pandas as pd

    rows = []
    for level, made in levels.items():
        results = [path_error(walk) for walk in made]
        ends = np.array([error[-1, :2] / path.sd[-1, 6:8] for path, error, _ in results])
        rows.append(
            {
                "level": level,
                "NIS (1)": mean_nis(path for path, _, _ in results),
                "end: error²/sd² (1)": np.mean(ends**2),
                "end within 2 sd, % (95)": 100 * np.mean(np.abs(ends) < 2),
            }
        )
    return pd.DataFrame(rows)


def closing_errors(
    made: Sequence[SimulatedWalker], settings: Sequence[NavigationSettings]
) -> list[tuple[float, float, float]]:
    """Errors of the filter at the end of walks that turn once around.

    Parameters
    ----------
    made : walks
    settings : of the filter, one for each result

    Returns
    -------
    list of three floats each : mean and largest error of the end on the floor (m), rms error of the
        heading (deg)
    """
    given = [(walk, readings(walk), _rests(walk, None)) for walk in made]
    results = []
    for chosen in settings:
        ends, headings = [], []
        for walk, data, still in given:
            path = trajectory_from_path(navigate(*data, still, chosen, smooth=False), walk.mount)
            way = walk.position_body_m[-1] - walk.position_body_m[0]
            ends.append(np.linalg.norm(path.position_m[-1, :2] - way[:2]))
            headings.append(np.rad2deg(path.yaw_rad[-1]) - 360)
        heading_deg = float(np.sqrt(np.mean(np.square(headings))))
        results.append((float(np.mean(ends)), float(np.max(ends)), heading_deg))
    return results


def form_table(made: Sequence[SimulatedWalker]) -> pd.DataFrame:
    """Errors by the form of eq. 24, with and without what else finds the gyroscope's bias.

    Parameters
    ----------
    made : walks that turn once around

    Returns
    -------
    DataFrame : whether the zero rate of a rest is observed, whether the filter starts from the
        gyroscope's mean over the first rest, form of eq. 24, and :func:`closing_errors`
    """
    import pandas as pd

    cases = [
        (zero_rate, first_mean, form)
        for zero_rate, first_mean in ((True, True), (True, False), (False, True), (False, False))
        for form in FORMS
    ]
    settings = [
        NavigationSettings(zero_rate=zero_rate, initial_gyr_mean=first_mean, form=form)
        for zero_rate, first_mean, form in cases
    ]
    rows = [
        {
            "zero rate": "yes" if zero_rate else "no",
            "first mean": "yes" if first_mean else "no",
            "(24)": FORMS[form],
            "end error, m": mean_m,
            "largest, m": largest_m,
            "heading rms, deg": heading_deg,
        }
        for (zero_rate, first_mean, form), (mean_m, largest_m, heading_deg) in zip(
            cases, closing_errors(made, settings), strict=True
        )
    ]
    return pd.DataFrame(rows)
