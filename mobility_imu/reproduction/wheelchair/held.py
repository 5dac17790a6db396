"""Drives and trials that were held back until the settings were fixed: four records, run once.

Eight drives of ``terrain-chair``, four of ``car-wheels``, the chosen trials of people with even
numbers of ``mocap-chair``, and the trials of it that the choice left out because wheel and motion
capture differ, the way is short or the radius is another one. Rows are those of the studies of the
others.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mobility_imu.reproduction.real_files import Numbers, held_study
from mobility_imu.reproduction.wheelchair import real_car, real_drives, real_mocap
from mobility_imu.reproduction.wheelchair.real_common import INSIDE, rounded, spread

DRIVES = tuple(
    f"{ground}_{kind}"
    for ground, kinds in (
        ("carpet", ("donut", "straight")),
        ("concrete", ("donut", "straight")),
        ("gravel", ("donut",)),
        ("linoleum", ("donut", "straight")),
        ("sidewalk", ("straight",)),
    )
    for kind in kinds
)
CARS = real_car.HELD_BACK
TRACK_M = 0.526
"""By hand, mean of the three circles that were looked at; the chair is the same."""
PARTS = ("_truth.csv.gz", ".csv.gz")
OTHERS = "others/"
"""Subfolder with the trials that the choice left out."""
NOT_AT_HAND = "not at hand when the choice was made"
UNLIKE = "yaw rates do not correlate"
"""No clock shift makes wheel and motion capture one, so that nothing can be compared."""


def held_drives(executor: Any = None) -> Numbers | None:
    """Record ``held_drives``: eight drives, the frame's gyroscope against the wheels.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a recording is not here
    """
    lines = {real_drives.straight_for(name) for name in DRIVES}
    tried = [name for name in real_drives.BY_HAND if name.endswith("straight")]
    files = [f"{name}.csv.gz" for name in sorted({*DRIVES, *lines, *tried})]
    return held_study(
        real_drives.DATASET, "held_drives", lambda _: [*files, "geometry.toml"], _drives
    )


def _drives(folder: Path) -> Numbers:
    rows = [real_drives.drive_row(folder, real_drives.load_ridden(folder, name)) for name in DRIVES]
    judged = [row for row in rows if row["judged"]]
    off = np.array([row["track_m"] - TRACK_M for row in judged])
    sd = np.array([row["track_sd_m"] for row in judged])
    summary = {
        "recordings": len(rows),
        "refused": 0,
        "judged": len(judged),
        "called_wrong": sum(not row["fits"] for row in judged),
        "straight_judged": sum(row["judged"] for row in rows if row["drive"].endswith("straight")),
        "track_m": spread(row["track_m"] for row in judged),
        "track_off_m": float(np.abs(off).max()),
        "track_inside": int(np.count_nonzero(np.abs(off) < INSIDE * sd)),
        "slip": spread(row["slip"] for row in rows),
        "residual_degps": spread(row["residual_degps"] for row in rows),
        "saturated_drives": sum(bool(row["saturated_s"]) for row in rows),
    }
    return {"rows": rounded(rows), "summary": rounded(summary)}


def held_car(executor: Any = None) -> Numbers | None:
    """Record ``held_car``: four drives of a car against satellite positions.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a recording is not here
    """
    parts = ("_geometry.toml", "_static.csv.gz", "_straight.csv.gz", *PARTS)
    files = [f"{name}{part}" for name in CARS for part in parts]

    def compute(folder: Path) -> Numbers:
        found = real_car.real_numbers(folder, list(CARS))
        return {key: found[key] for key in ("rows", "summary", "series")}

    return held_study(real_car.DATASET, "held_car", lambda _: files, compute)


def held_names(folder: Path) -> list[str]:
    """Chosen trials of the people with even numbers.

    Parameters
    ----------
    folder : of the data set

    Returns
    -------
    list of str
    """
    return [name for name in real_mocap.trial_names(folder) if real_mocap.is_held_back(name)]


def left_out(folder: Path) -> pd.DataFrame:
    """Trials that the choice left out, of captures that were at hand when it was made.

    Parameters
    ----------
    folder : of the data set

    Returns
    -------
    DataFrame: ``trial``, ``why_not`` and how wheel and capture agree; empty without the table
    """
    path = folder / "trials.csv.gz"
    if not path.is_file():
        return pd.DataFrame({"trial": [], "why_not": []})
    table = pd.read_csv(path)
    return table[(table["chosen"] == 0) & (table["why_not"] != NOT_AT_HAND)]


def _files_of(names: list[str], place: str, folder: Path) -> list[str]:
    """Files of some trials; what a person's trials share may lie beside the chosen ones."""
    files = [f"{place}{name}{part}" for name in names for part in PARTS]
    for person in sorted({name[:3] for name in names}):
        where = "" if (folder / f"{person}_static.csv.gz").is_file() else place
        ends = ("static.csv.gz", "straight.csv.gz", "geometry.toml")
        files += [f"{where}{person}_{end}" for end in ends]
    return files


def held_chairs(executor: Any = None) -> Numbers | None:
    """Record ``held_chairs``: fifteen trials of sports chairs against motion capture.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a recording is not here
    """

    def files(folder: Path) -> list[str]:
        return _files_of(held_names(folder), "", folder)

    def compute(folder: Path) -> Numbers:
        found = real_mocap.real_numbers(folder, held_names(folder))
        return {key: found[key] for key in ("rows", "summary")}

    return held_study(real_mocap.DATASET, "held_chairs", files, compute)


def comparable(folder: Path) -> pd.DataFrame:
    """Trials left out that can be compared: one clock fits, and the chair's sizes are known.

    Parameters
    ----------
    folder : of the data set

    Returns
    -------
    DataFrame as of :func:`left_out`
    """
    table = left_out(folder)
    sized = [
        any((folder / f"{place}{name[:3]}_geometry.toml").is_file() for place in ("", OTHERS))
        for name in table["trial"]
    ]
    return table[(table["why_not"] != UNLIKE) & np.array(sized, bool)]


def dropped_chairs(executor: Any = None) -> Numbers | None:
    """Record ``dropped_chairs``: the trials that the choice left out.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a recording is not here
    """

    def files(folder: Path) -> list[str]:
        names = comparable(folder)["trial"].tolist()
        return [*_files_of(names, OTHERS, folder), "trials.csv.gz"] if names else []

    return held_study(real_mocap.DATASET, "dropped_chairs", files, _dropped)


def _dropped(folder: Path) -> Numbers:
    table, everything = comparable(folder), left_out(folder)
    rows, ratios = [], []
    for name, why, misfit in zip(
        table["trial"], table["why_not"], table["wheel_misfit_mps"], strict=True
    ):
        trial = real_mocap.load_trial(folder, f"{OTHERS}{name}")
        speed = trial.speed
        ratios.append(speed.error / speed.sd)
        rows.append(
            {
                "trial": name,
                "why_not": why,
                "wheel_misfit_mps": misfit,
                "way_m": float(np.abs(speed.true) @ speed.step_s),
                "fastest_mps": float(np.abs(speed.true).max()),
                "speed": speed.summary(),
                "path_ratio": speed.path_ratio,
                "yaw_rate_rms_degps": float(
                    np.rad2deg(np.sqrt(np.mean(np.square(trial.yaw_rate.error))))
                ),
            }
        )
    summary = {
        "recordings": len(rows),
        "refused": 0,
        "people": len({row["trial"][:3] for row in rows}),
        "left_out": len(everything),
        "no_common_clock": int((everything["why_not"] == UNLIKE).sum()),
        "speed_rms_mps": spread(row["speed"]["rms"] for row in rows),
        "path_ratio": spread(row["path_ratio"] for row in rows),
        "speed_sd_over_rms": spread(row["speed"]["sd_over_rms"] for row in rows),
        "speed_inside": float(np.mean(np.abs(np.concatenate(ratios)) < INSIDE)),
        "by_reason": {
            why: {
                "recordings": len(some),
                "speed_rms_mps": spread(row["speed"]["rms"] for row in some),
                "path_ratio": spread(row["path_ratio"] for row in some),
            }
            for why in dict.fromkeys(table["why_not"])
            if (some := [row for row in rows if row["why_not"] == why])
        },
    }
    return {"rows": rounded(rows), "summary": rounded(summary)}
