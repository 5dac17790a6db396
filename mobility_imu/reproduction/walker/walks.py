"""Walker: what all chapters and claims say of simulated calibrations and walks, computed once.

Each of the five mountings of Table 1 is calibrated and walked with 20 times at each level, in the
paper's way where it matters: the filter alone, and the IMU's position by the paper's two methods.
The record is ``walker_walks``.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.data import published_folder
from mobility_imu.reproduction.walker.past import past_numbers
from mobility_imu.reproduction.walker.studies import (
    LEVELS,
    METHOD_1,
    METHOD_1_ROOTLESS,
    METHOD_2_TILTS_DEG,
    PAPERS_WAY,
    calibration_study,
    method_2,
    sources,
    walking_study,
)
from mobility_imu.reproduction.walker.tables import POSES, pose_translation
from mobility_imu.simulation.walker import CORRIDOR, RECTANGLE, RECTANGLE_OPEN

if TYPE_CHECKING:
    import pandas as pd

SEEDS, SOURCE_SEEDS = 20, 4
COURSES = {"last corner turned": RECTANGLE, "last corner not turned": RECTANGLE_OPEN}
PAPERS_LEVEL = "realistic"
"""Level that the paper's errors are held against; the others have smaller errors."""
_PLACE = ["x_m", "y_m", "z_m"]


def walker_walks(executor: Any = None) -> dict[str, Any]:
    """Calibrations, corridors and rectangles at full size, as the record keeps them.

    Parameters
    ----------
    executor : anything with ``submit``; None computes in this process. The numbers are the same

    Returns
    -------
    dict
        ``numbers``, see :func:`walk_numbers`, and ``inputs``: SHA-256 of Table 1, from which the
        mountings come.
    """
    table = published_folder() / "walker_table1.csv"
    return {
        "numbers": walk_numbers(range(SEEDS), range(SOURCE_SEEDS), executor=executor),
        "inputs": {table.name: hashlib.sha256(table.read_bytes()).hexdigest()},
    }


def walk_numbers(
    seeds: Iterable[int], source_seeds: Iterable[int], *, executor: Any = None
) -> dict[str, Any]:
    """Tables of simulated calibrations and walks.

    Parameters
    ----------
    seeds : one per repetition of calibration, corridor and rectangle; they include 0
    source_seeds : one per repetition of the walks with one source of error at a time, and of
        what goes past the paper
    executor : as in :func:`walker_walks`

    Returns
    -------
    dict of lists of rows (dict by column); the units are in the names
    """
    seeds, source_seeds = list(seeds), list(source_seeds)
    mounts = calibration_study(seeds, executor=executor)
    ways = [variant.name for variant in PAPERS_WAY]
    positions = mounts[~mounts["smooth"] & mounts["name"].isin(ways)]
    walks = {
        name: walking_study(seeds, course, smooth=False, positions=positions, executor=executor)
        for name, course in {"corridor": CORRIDOR, **COURSES}.items()
    }
    rounds = {name: walks[name] for name in COURSES}
    return {
        "seeds": len(seeds),
        "source_seeds": len(source_seeds),
        **_calibration(mounts),
        **_corridor(walks["corridor"]),
        **_rectangle(rounds),
        "heights": _heights(walks),
        "sources": _sources(source_seeds, executor),
        **{name: _rows(table) for name, table in past_numbers(source_seeds, executor).items()},
    }


def _calibration(mounts: pd.DataFrame) -> dict[str, Any]:
    import pandas as pd

    rows = []
    for (level, name, smooth), runs in mounts.groupby(["level", "name", "smooth"], sort=False):
        found = runs.dropna(subset="error_m")
        bias = {f"bias_{axis}_mm": 1000 * found[f"error_{axis}_m"].mean() for axis in "xyz"}
        sizes = {"position_rms_mm": 1000 * _rms(found["error_m"])}
        turns = {f"{key}_rms_deg": _rms(found[f"{key}_deg"]) for key in ("turn", "heading")}
        counts = {"runs": len(runs), "without_result": len(runs) - len(found)}
        key = {"level": level, "name": name, "smooth": bool(smooth)}
        rows.append({**key, **sizes, **turns, **bias, **counts})
    rootless = mounts[mounts["error_m"].isna() & (mounts["name"] == METHOD_1)]
    lost = rootless.groupby(["level", "pose", "smooth"], sort=False).size().rename("runs")
    filtered = mounts[~mounts["smooth"]]
    first = filtered[(filtered["level"] == PAPERS_LEVEL) & (filtered["seed"] == 0)]
    first = first[first["name"].isin([variant.name for variant in PAPERS_WAY])]
    return {
        "calibration": _rows(pd.DataFrame(rows), 3),
        "without_root": _rows(lost.reset_index()),
        "apart": [row for tilt in METHOD_2_TILTS_DEG for row in _apart(filtered, tilt)],
        "second_nearer": [row for tilt in METHOD_2_TILTS_DEG for row in _nearer(filtered, tilt)],
        "first_mounts": _rows(first[["pose", "name", *_PLACE]]),
    }


def _apart(filtered: pd.DataFrame, tilt_deg: float) -> list[dict[str, Any]]:
    """Distance between the positions by the two methods, where both give one.

    Beside method 1 as printed stands the one without roots, which loses no run. Poses are told
    apart at 3 deg alone.
    """
    apart = [np.linalg.norm(pose_translation(p, 1) - pose_translation(p, 2)) for p in POSES]
    published_mm = 1000 * float(np.mean(apart))
    table = filtered.set_index(["name", "level", "pose", "seed"])[_PLACE]
    rows = []
    for name in (METHOD_1, METHOD_1_ROOTLESS):
        gap = table.loc[name] - table.loc[method_2(tilt_deg)]
        gap_mm = 1000 * np.sqrt((gap**2).sum(axis=1, skipna=False)).dropna()
        for level in LEVELS:
            own = gap_mm.loc[level]
            groups = {"all": own}
            if tilt_deg == 3.0:
                groups |= {pose: own.loc[pose] for pose in own.index.unique("pose")}
            rows += [
                {
                    "method_1": name,
                    "velocity_tilt_deg": tilt_deg,
                    "level": level,
                    "pose": pose,
                    "mean_mm": round(float(values.mean()), 2),
                    "share_beyond_published": round(float((values > published_mm).mean()), 3),
                    "runs": len(values),
                }
                for pose, values in groups.items()
            ]
    return rows


def _nearer(filtered: pd.DataFrame, tilt_deg: float) -> list[dict[str, Any]]:
    """How often the second method's position is nearer to the truth than the first's."""
    error = filtered.set_index(["name", "level", "pose", "seed"])["error_m"]
    nearer = error.loc[method_2(tilt_deg)] < error.loc[METHOD_1_ROOTLESS]
    return [
        {
            "velocity_tilt_deg": tilt_deg,
            "level": level,
            "share": round(float(nearer.loc[level].mean()), 3),
            "runs": len(nearer.loc[level]),
        }
        for level in LEVELS
    ]


def _corridor(walks: pd.DataFrame) -> dict[str, Any]:
    walks = walks.assign(
        of_ten_m=walks["distance_m"] - 10, error_m=walks["distance_m"] - walks["true_distance_m"]
    )
    true = walks[walks["source"] == "true"]
    levels = true.groupby("level", sort=False).agg(
        signed_m=("error_m", "mean"),
        sd_m=("error_m", "std"),
        mean_abs_m=("error_m", lambda e: e.abs().mean()),
        largest_m=("error_m", lambda e: e.abs().max()),
        of_ten_mean_abs_m=("of_ten_m", lambda e: e.abs().mean()),
        end_m=("end_m", "mean"),
        heading_sd_deg=("heading_deg", "std"),
        walks=("error_m", "size"),
    )
    here = true[true["level"] == PAPERS_LEVEL]
    by_pose = here.groupby("pose")["error_m"].mean().rename("signed_m")
    distances = {
        pose: [round(float(d), 4) for d in own["distance_m"]] for pose, own in here.groupby("pose")
    }
    key = ["level", "seed", "pose"]
    place = walks.pivot_table(index=key, columns="source", values="distance_m", sort=False)
    moved = (place[METHOD_1_ROOTLESS] - place[method_2(3)]).abs()
    by_level = moved.groupby("level", sort=False).agg(
        mean_m="mean", largest_m="max", share_within_1mm=lambda v: (v < 0.001).mean(), walks="size"
    )
    return {
        "corridor": _rows(levels.reset_index()),
        "corridor_by_pose": _rows(by_pose.reset_index()),
        "corridor_distances_m": distances,
        "corridor_by_the_two_methods": _rows(by_level.reset_index(), 6),
    }


def _rectangle(rounds: dict[str, pd.DataFrame]) -> dict[str, Any]:
    import pandas as pd

    every = pd.concat([walks.assign(course=name) for name, walks in rounds.items()])
    wanted = {
        "closing_m": ("closing_m", "mean"),
        "x_m": ("closing_x_m", "mean"),
        "y_m": ("closing_y_m", "mean"),
        "mixed_m": ("mixed_m", "mean"),
        "walks": ("end_m", "size"),
    }
    levels = every[every["source"] == "true"].groupby(["course", "level"], sort=False)
    summary = levels.agg(
        end_m=("end_m", "mean"),
        end_95th_m=("end_m", lambda v: np.percentile(v, 95)),
        corner_m=("corner_m", "mean"),
        rms_m=("rms_m", "mean"),
        heading_sd_deg=("heading_deg", "std"),
        **wanted,
    )
    sources_ = every.groupby(["course", "level", "source"], sort=False).agg(**wanted)
    here = every[every["level"] == PAPERS_LEVEL]
    by_pose = here.groupby(["course", "source", "pose"], sort=False).agg(**wanted)
    first = here[here["seed"] == 0]
    return {
        "rectangle": _rows(summary.reset_index()),
        "rectangle_by_source": _rows(sources_.reset_index()),
        "rectangle_by_pose": _rows(by_pose.reset_index()),
        "first_rounds": _rows(
            first[["course", "source", "pose", "closing_x_m", "closing_y_m", "heading_deg"]]
        ),
        "tables_apart": [
            row for name, walks in rounds.items() for row in _tables_apart(name, walks)
        ],
    }


def _tables_apart(course: str, walks: pd.DataFrame) -> list[dict[str, Any]]:
    """How far the two methods' closing errors differ, over how far their positions do.

    Positions are compared on the floor, as the tables' x and y are. Eq. 27 corrects both ends for
    the lever arm; "end only" is end of the frame less start of the IMU. "As turned" has
    the ratio of eq. 28 for the turn between both ends, to 0.05.
    """
    key = ["level", "seed", "pose"]
    one, two = (
        walks[walks["source"] == name].set_index(key) for name in (METHOD_1_ROOTLESS, method_2(3))
    )
    gaps = {
        what: np.hypot(
            one[f"{what}_x_m"] - two[f"{what}_x_m"], one[f"{what}_y_m"] - two[f"{what}_y_m"]
        )
        for what in ("arm", "closing", "mixed")
    }
    turn_rad = sum(leg.turn_rad for leg in COURSES[course])
    by_28 = 2 * abs(np.sin(turn_rad / 2))
    rows = []
    for ends, what in (("both ends", "closing"), ("end only", "mixed")):
        ratio = gaps[what] / gaps["arm"]
        rows += [
            {
                "course": course,
                "level": level,
                "corrected": ends,
                "ratio_mean": round(float(ratio.loc[level].mean()), 4),
                "ratio_5th": round(float(ratio.loc[level].quantile(0.05)), 4),
                "ratio_95th": round(float(ratio.loc[level].quantile(0.95)), 4),
                "share_as_turned": round(float((abs(ratio.loc[level] - by_28) < 0.05).mean()), 3),
                "moved_mean_m": round(float(gaps[what].loc[level].mean()), 5),
                "walks": len(ratio.loc[level]),
            }
            for level in LEVELS
        ]
    return rows


def _heights(walks: dict[str, pd.DataFrame]) -> list[dict[str, Any]]:
    """Height of the end over the start: paper, eq. 24 and below, resets it at each rest."""
    rows = []
    for course, table in walks.items():
        for level, own in table.groupby("level", sort=False):
            largest = float(own["height_m"].abs().max())
            rows.append({"course": course, "level": level, "largest_m": round(largest, 6)})
    return rows


def _sources(seeds: list[int], executor: Any) -> list[dict[str, Any]]:
    straight = walking_study(seeds, CORRIDOR, sources(), smooth=False, executor=executor)
    straight["error_m"] = straight["distance_m"] - straight["true_distance_m"]
    around = walking_study(seeds, RECTANGLE, sources(), smooth=False, executor=executor)
    errors = straight.groupby("level", sort=False)["error_m"]
    ends = around.groupby("level", sort=False)
    table = errors.agg(corridor_signed_m="mean", corridor_mean_abs_m=lambda e: e.abs().mean())
    table["rectangle_end_m"] = ends["end_m"].mean()
    table["rectangle_heading_mean_abs_deg"] = ends["heading_deg"].agg(lambda v: v.abs().mean())
    table["walks"] = errors.size()
    return _rows(table.rename_axis("source").reset_index())


def _rms(values: pd.Series) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _rows(table: pd.DataFrame, digits: int = 5) -> list[dict[str, Any]]:
    """Rows as JSON has them: numbers rounded, None for what is not there."""
    numbers = table.select_dtypes("floating").columns
    rounded = table.assign(**{name: table[name].round(digits) for name in numbers})
    return [
        {name: None if value != value else value for name, value in row.items()}
        for row in rounded.to_dict("records")
    ]
