"""The whole simulated driving test as a record: 20 scooters, 4 drivers, 3 runs, 5 courses.

The record ``scooter_driving`` holds what chapter, scorecard and command show of it: the 90 % error
of every scooter, course, mounting, estimator and angle; what one IMU does while braking and in
curves; and the same scooters with one effect of the model switched off at a time.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.executors import run_all
from mobility_imu.reproduction.scooter.driving import (
    COLUMNS,
    DrivingStudy,
    StudySettings,
    driving_study,
    estimate_ride,
    summary,
)
from mobility_imu.reproduction.scooter.driving_rides import (
    ANGLES,
    DRIVERS,
    RUNS,
    Conditions,
    ablations,
    make_ride,
    motion_and_truth,
)
from mobility_imu.simulation.scooter import COURSES

if TYPE_CHECKING:
    import pandas as pd

SCOOTERS = tuple(range(20))
ABLATION_DRIVERS = 2
"""Drivers per scooter and course, one run each, with one effect switched off."""
ABLATION_ESTIMATORS = ("single", "dual", "subtraction", "body's x only")
BRAKING_MPS2 = 0.5
"""Deceleration from which a sample counts as braking; ours."""
CRUISING_MPS2 = 0.1
"""Largest change of speed of a sample that counts as driving at constant speed; ours."""
TURNED_DEG = 25.0
"""Steering angle from which a sample of the course with curves counts as turned; ours."""


def driving_record(executor: Executor | None = None) -> dict[str, Any]:
    """Numbers of the record ``scooter_driving``.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here

    Returns
    -------
    dict
        ``numbers`` with ``scooters``, ``drivers``, ``runs`` (counts), ``p90_deg`` (by against,
        mounting, estimator, angle and course: one number per scooter, deg), ``mae_deg`` (the same
        for the mounting as drawn, against the wires), ``effects`` (see :func:`single_imu_effects`)
        and ``ablations`` (``drivers``; ``p90_deg`` by condition, estimator, angle and course, deg,
        median over the scooters; ``below_dual`` by condition, estimator and course: for how many
        scooters the steering's 90 % error is smaller than that of the dual estimate). The same
        bytes for any executor.
    """
    study = driving_study(SCOOTERS, executor=executor)
    table = study.table
    mae = table[
        (table["mounting"] == "as drawn")
        & (table["against"] == "wire")
        & table["estimator"].isin(ABLATION_ESTIMATORS)
    ]
    effects = run_all(single_imu_effects, [(scooter,) for scooter in SCOOTERS], executor)
    return {
        "numbers": {
            "scooters": len(SCOOTERS),
            "drivers": DRIVERS,
            "runs": RUNS,
            "p90_deg": _nested(
                table, ["against", "mounting", "estimator", "angle", "course"], "p90_deg"
            ),
            "mae_deg": _nested(mae, ["estimator", "angle", "course"], "mae_deg"),
            "effects": {name: [round(e[name], 3) for e in effects] for name in effects[0]},
            "ablations": _ablations(executor),
        }
    }


def recorded_study(numbers: Mapping[str, Any]) -> DrivingStudy:
    """Study of the record, for all functions that take one; histograms are not recorded.

    Parameters
    ----------
    numbers : what ``recorded.numbers("scooter_driving")`` returns

    Returns
    -------
    DrivingStudy
        ``mae_deg`` is NaN where it was not recorded, ``n`` is 0.
    """
    import pandas as pd

    rows = []
    for against, by_mounting in numbers["p90_deg"].items():
        for mounting, by_estimator in by_mounting.items():
            for estimator, by_angle in by_estimator.items():
                for angle, by_course in by_angle.items():
                    for course, values in by_course.items():
                        kept = mounting == "as drawn" and against == "wire"
                        mae = numbers["mae_deg"].get(estimator) if kept else None
                        means = [np.nan] * len(values) if mae is None else mae[angle][course]
                        rows += [
                            (k, course, mounting, estimator, angle, against, p90, mean, 0)
                            for k, (p90, mean) in enumerate(zip(values, means, strict=True))
                        ]
    return DrivingStudy(pd.DataFrame(rows, columns=list(COLUMNS)), {}, {})


def smaller_than(
    study: DrivingStudy, first: str, second: str, *, mounting: str = "as drawn"
) -> pd.DataFrame:
    """For how many scooters one estimator has the smaller 90 % error against the wires.

    Parameters
    ----------
    study : DrivingStudy
    first, second : names of estimators
    mounting : name of the calibration

    Returns
    -------
    DataFrame of counts, one row per angle, one column per course
    """
    table = study.table
    rows = table[(table["mounting"] == mounting) & (table["against"] == "wire")]
    p90 = rows.pivot_table(
        index=["angle", "course", "scooter"], columns="estimator", values="p90_deg", sort=False
    )
    smaller = (p90[first] < p90[second]).rename("smaller").reset_index()
    counts: pd.DataFrame = smaller.pivot_table("smaller", "angle", "course", "sum", sort=False)
    return counts.rename_axis(index=None, columns=None)


def single_imu_effects(scooter: int) -> dict[str, float]:
    """What braking does to the throttle and a curve to the steering, with one IMU and with two.

    Parameters
    ----------
    scooter : seed

    Returns
    -------
    dict
        ``braking, single`` and ``braking, dual``: by how many degrees the mean throttle error while
        braking exceeds that at constant speed, on the straight course. ``curves, single`` and
        ``curves, dual``: estimated over true steering (1) where the wheel is turned by
        :data:`TURNED_DEG` or more. Median over the drivers, one run each, against the wires.
    """
    found: dict[str, list[float]] = {}
    for driver in range(DRIVERS):
        straight = make_ride(scooter, "straight", driver, 0, Conditions())
        moving, truth = motion_and_truth(straight)
        rates = np.gradient(straight.speed_mps, straight.recording.time_s)[moving]
        for name, angles in estimate_ride(straight, moving, ("single", "dual")).items():
            error_deg = np.rad2deg(angles[:, 1] - truth["wire"][:, 1])
            rise = error_deg[rates < -BRAKING_MPS2].mean()
            rise -= error_deg[np.abs(rates) < CRUISING_MPS2].mean()
            found.setdefault(f"braking, {name}", []).append(float(rise))
        curves = make_ride(scooter, "curves", driver, 0, Conditions())
        moving, truth = motion_and_truth(curves)
        wire = truth["wire"][:, 0]
        turned = np.abs(wire) >= np.deg2rad(TURNED_DEG)
        for name, angles in estimate_ride(curves, moving, ("single", "dual")).items():
            gain = np.median(angles[turned, 0] / wire[turned])
            found.setdefault(f"curves, {name}", []).append(float(gain))
    return {name: float(np.median(values)) for name, values in found.items()}


def _ablations(executor: Executor | None) -> dict[str, Any]:
    quick = StudySettings(
        drivers=ABLATION_DRIVERS,
        runs=1,
        estimators=ABLATION_ESTIMATORS,
        calibrations={"as drawn": None},
    )
    p90: dict[str, Any] = {}
    below: dict[str, Any] = {}
    for name, conditions in ablations().items():
        one = driving_study(SCOOTERS, replace(quick, conditions=conditions), executor=executor)
        middle = summary(one)["median"].round(3)
        p90[name] = {
            estimator: {
                angle: {course: float(middle[estimator, angle, course]) for course in COURSES}
                for angle in ANGLES
            }
            for estimator in ABLATION_ESTIMATORS
        }
        below[name] = {
            estimator: smaller_than(one, estimator, "dual").loc["steering"].astype(int).to_dict()
            for estimator in ("subtraction", "body's x only")
        }
    return {"drivers": ABLATION_DRIVERS, "p90_deg": p90, "below_dual": below}


def _nested(table: pd.DataFrame, keys: list[str], value: str) -> Any:
    """Nested dictionaries by keys; the innermost is a list in the table's order."""
    if not keys:
        return [round(float(number), 3) for number in table[value]]
    return {
        str(name): _nested(part, keys[1:], value)
        for name, part in table.groupby(keys[0], sort=False)
    }
