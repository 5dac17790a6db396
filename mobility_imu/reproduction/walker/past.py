"""Walker, past the paper, at full size for the record: smoother, known end, uncertainty."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.reproduction.walker.studies import (
    DATASHEET,
    LEVELS,
    Level,
    spread,
    tilt_run,
    unit_of,
    walking_study,
)
from mobility_imu.reproduction.walker.tables import POSES, pose_mount
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.simulation.walker import RECTANGLE, Imperfections, attach_imu, simulate_walk
from mobility_imu.walker.calibration import calibrate_mount
from mobility_imu.walker.navigation import ClosedLoop, NavigationSettings
from mobility_imu.walker.trajectory import estimate_trajectory

if TYPE_CHECKING:
    import pandas as pd

ROCKING = Level(MTI_1, Imperfections(rocking_rad=float(np.deg2rad(0.6))))
"""A frame that rocks so strongly that few rests are found."""
SENSOR = NavigationSettings.for_calibrated_sensor()
UNITS_LEVELS = ("sensor", "realistic")
"""Levels with the errors of a real unit."""


def smoothing(seeds: Iterable[int], executor: Any = None) -> pd.DataFrame:
    """Error of the path around the rectangle by filter and by smoother.

    Parameters
    ----------
    seeds : one per repetition in each pose
    executor : anything with ``submit``; None computes in this process

    Returns
    -------
    DataFrame
        One row per level: ``filter_rms_m``, ``smoothed_rms_m`` (mean of the walks' rms errors on
        the floor), ``walks``.
    """
    levels = {"realistic": LEVELS["realistic"], "strong rocking": ROCKING}
    ways: dict[str, dict[str, Any]] = {"filter": {"smooth": False}, "smoothed": {"smooth": True}}
    return _rectangle_means(list(seeds), levels, ways, ("rms",), executor)


def known_end(seeds: Iterable[int], executor: Any = None) -> pd.DataFrame:
    """Smoothed rectangle without and with the constraint that it ends where it began.

    Parameters
    ----------
    seeds, executor : as in :func:`smoothing`

    Returns
    -------
    DataFrame
        One row per level: ``free_rms_m``, ``tied_rms_m`` over the walk, ``free_end_m``,
        ``tied_end_m`` (distance of the end from its true place), ``walks``.
    """
    levels = {name: LEVELS[name] for name in UNITS_LEVELS}
    ends = {"free": None, "tied": ClosedLoop()}
    ways: dict[str, dict[str, Any]] = {name: {"closed_loop": end} for name, end in ends.items()}
    return _rectangle_means(list(seeds), levels, ways, ("rms", "end"), executor)


def _rectangle_means(
    seeds: list[int],
    levels: Mapping[str, Level],
    ways: Mapping[str, Mapping[str, Any]],
    errors: Sequence[str],
    executor: Any,
) -> pd.DataFrame:
    """Mean errors around the rectangle, one row per level, columns ``<way>_<error>_m``."""
    import pandas as pd

    columns: dict[str, Any] = {}
    for name, options in ways.items():
        walks = walking_study(seeds, RECTANGLE, levels, executor=executor, **options)
        groups = walks.groupby("level", sort=False)
        columns |= {f"{name}_{error}_m": groups[f"{error}_m"].mean() for error in errors}
    return pd.DataFrame({**columns, "walks": len(seeds) * len(POSES)}).reset_index()


def printed_dynamics(seeds: Iterable[int], executor: Any = None) -> pd.DataFrame:
    """Rectangle by the filter with (24) corrected and as printed, with and without zero rates.

    Parameters
    ----------
    seeds, executor : as in :func:`smoothing`

    Returns
    -------
    DataFrame
        One row per form and choice (``level``): ``end_m``, ``heading_rms_deg``, ``walks``.
    """
    ways = {
        f"{dynamics}{'' if zero_rate else ', no zero-rate update'}": Level(
            DATASHEET,
            navigation=NavigationSettings(form=dynamics, zero_rate=zero_rate),
        )
        for dynamics in ("corrected", "printed")
        for zero_rate in (True, False)
    }
    walks = walking_study(seeds, RECTANGLE, ways, smooth=False, executor=executor)
    found = walks.groupby("level", sort=False).agg(
        end_m=("end_m", "mean"), heading_rms_deg=("heading_deg", _rms), walks=("end_m", "size")
    )
    return found.reset_index()


def mount_ratios(
    seeds: Iterable[int], executor: Any = None, poses: Sequence[str] = POSES
) -> pd.DataFrame:
    """Errors of a calibration by whole arcs over the standard deviations that it states.

    Parameters
    ----------
    seeds, executor : as in :func:`smoothing`
    poses : mountings of Table 1

    Returns
    -------
    DataFrame
        One row per level: rms ratios ``x``, ``y``, ``z`` of the position and ``roll``, ``pitch``,
        ``heading`` of the rotation, 1 if the standard deviations are right; ``runs``.
    """
    import pandas as pd

    rows = pd.DataFrame(spread(partial(_mount_ratios_of, poses=tuple(poses)), seeds, executor))
    groups = rows.groupby("level", sort=False)
    return groups.agg(_rms).assign(runs=groups.size()).reset_index()


def _mount_ratios_of(seed: int, poses: tuple[str, ...]) -> list[dict[str, Any]]:
    rows = []
    for level in UNITS_LEVELS:
        for pose in poses:
            run, tape = tilt_run(seed, pose, LEVELS[level])
            found = calibrate_mount(run.recording, tape, settings=SENSOR)
            off = found.mount.translation_body_m - run.mount.translation_body_m
            turn = Rotation.from_matrix(
                found.mount.rotation_imu_to_body @ run.mount.rotation_imu_to_body.T
            ).as_rotvec()
            ratios = [*(off / found.translation_sd_m), *(turn / found.rotation_sd_rad)]
            names = ("x", "y", "z", "roll", "pitch", "heading")
            rows.append({"level": level, **dict(zip(names, ratios, strict=True))})
    return rows


def end_ratios(seeds: Iterable[int], executor: Any = None) -> pd.DataFrame:
    """Error of the end of a rectangle over its stated standard deviation.

    Parameters
    ----------
    seeds, executor : as in :func:`smoothing`

    Returns
    -------
    DataFrame
        One row per level: ``ratio`` (rms), ``walks``.
    """
    import pandas as pd

    rows = pd.DataFrame(spread(_end_ratios_of, seeds, executor))
    groups = rows.groupby("level", sort=False)["ratio"]
    return pd.DataFrame({"ratio": groups.agg(_rms), "walks": groups.size()}).reset_index()


def _end_ratios_of(seed: int, poses: tuple[str, ...] = ("1", "3", "5")) -> list[dict[str, Any]]:
    rows = []
    for name, level in LEVELS.items():
        motion = simulate_walk(RECTANGLE, seed=seed, imperfections=level.imperfections)
        for pose in poses:
            unit = unit_of(seed, pose)
            run = attach_imu(motion, pose_mount(pose), level.sensor, seed=unit, unit_seed=unit)
            path = estimate_trajectory(run.recording, None, pose_mount(pose), SENSOR)
            goal = run.position_body_m[-1] - run.position_body_m[0]
            off = float(np.linalg.norm((path.position_m[-1] - goal)[:2]))
            rows.append({"level": name, "ratio": off / float(path.horizontal_sd_m[-1])})
    return rows


def past_numbers(seeds: Iterable[int], executor: Any = None) -> dict[str, pd.DataFrame]:
    """All tables of this module by their names in the record.

    Parameters
    ----------
    seeds, executor : as in :func:`smoothing`

    Returns
    -------
    dict of DataFrame
    """
    seeds = list(seeds)
    tables = {
        "smoothing": smoothing,
        "known_end": known_end,
        "printed_dynamics": printed_dynamics,
        "mount_ratios": mount_ratios,
        "end_ratios": end_ratios,
    }
    return {name: make(seeds, executor) for name, make in tables.items()}


def _rms(values: pd.Series) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
