"""Real walks over all of them: record, changed settings, and simulated walks beside them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

from mobility_imu.datasets.folders import find_folder
from mobility_imu.executors import run_all
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.real_files import checksums, origin_of
from mobility_imu.reproduction.walker.real_sensors import rounded, sensors_summary, spectra
from mobility_imu.reproduction.walker.real_walks import (
    DATASET,
    HELD_BACK,
    Walk,
    kept,
    load_walk,
    match_labels,
    mean_nis,
    medians_of,
    walk_names,
    walk_row,
)
from mobility_imu.runs import runs_of
from mobility_imu.simulation.levels import LEVELS, MOUNTS, REAL_LEVEL
from mobility_imu.simulation.walker import CORRIDOR, attach_imu, simulate_walk
from mobility_imu.walker.geometry import FOOTPRINT
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation_settings import NavigationSettings
from mobility_imu.walker.steps import GaitSettings, find_steps
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.trajectory import estimate_trajectory

NEAR_SWEPT_S = (0.25, 0.5, 1.0)
SHIFT_S = 1.5
"""Labels that are moved by this much, about half of the time from step to step, fit by chance."""
LIMIT_FACTORS = (0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4, 2.0)
"""By which both limits of the stillness detector are multiplied."""
BURST_S, BURST_MERGED_S, BURST_MEAN_S = 0.5, 0.5, 0.2
"""A method without a filter: least length of a burst, gaps that are closed, length of the mean."""
BURST_LIMITS_MPS2 = (0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8)
"""What the force's running rms about its median has to pass there."""
SIMULATED_SEEDS = range(8)


def counted(
    folder: Path,
    name: str,
    *,
    limits: float = 1.0,
    least_length_m: float | None = None,
    offset_degps: float = 0.0,
    place_m: Iterable[float] | None = None,
) -> tuple[int, int, int]:
    """Labels, labels with a step, and steps without a label, with something changed.

    Parameters
    ----------
    folder, name : as for ``load_walk``
    limits : factor on both limits of the stillness detector
    least_length_m : m, a shorter move is no step; None leaves it as it is, 0 lets every move count
    offset_degps : deg/s, added to the gyroscope's upward axis
    place_m : m, of the sensor in the frame, instead of the assumed one

    Returns
    -------
    three int
    """
    walk = load_walk(folder, name)
    usual, imu = StillnessSettings(), walk.recording.sensor("frame")
    detector = StillnessSettings(
        rate_radps=limits * usual.rate_radps, acc_deviation_mps2=limits * usual.acc_deviation_mps2
    )
    rates = walk.recording.gyroscope("frame") + np.deg2rad([0.0, offset_degps, 0.0])
    recording = Recording(
        walk.recording.time_s, {"frame": Imu(imu.acc_mps2, rates)}, source=walk.name
    )
    mount = walk.mount
    if place_m is not None:
        mount = WalkerMount(mount.rotation_imu_to_body, np.array(list(place_m)))
    found = estimate_trajectory(recording, walk.geometry, mount, stillness=detector)
    gait = None if least_length_m is None else GaitSettings(least_length_m=least_length_m)
    steps = find_steps(found, gait)
    return _counts(walk, steps.lift_s, steps.place_s)


def near_counts(folder: Path, names: Iterable[str]) -> list[dict[str, float]]:
    """Labels with a step for several distances, and the same for labels moved by ``SHIFT_S``.

    Parameters
    ----------
    folder : of the data set
    names : of the walks

    Returns
    -------
    list of dict: ``near_s``, ``found``, ``found_shifted``
    """
    total = np.zeros((len(NEAR_SWEPT_S), 2), int)
    for name in names:
        walk = load_walk(folder, name)
        steps = find_steps(estimate_trajectory(walk.recording, walk.geometry, walk.mount))
        moved = walk.labels[["begin_s", "end_s"]] + SHIFT_S
        for k, near in enumerate(NEAR_SWEPT_S):
            for j, labels in enumerate((walk.labels, moved)):
                matched = match_labels(steps.lift_s, steps.place_s, labels, near)
                total[k, j] += np.count_nonzero(matched.of_label >= 0)
    return [
        {"near_s": near, "found": int(a), "found_shifted": int(b)}
        for near, (a, b) in zip(NEAR_SWEPT_S, total, strict=True)
    ]


def burst_counts(folder: Path, name: str, limit_mps2: float) -> tuple[int, int, int]:
    """The same for a method without filter or gyroscope: bursts of the specific force.

    A burst is where the running rms of the force about its median is above a limit.

    Parameters
    ----------
    folder, name : as for ``load_walk``
    limit_mps2 : m/s²

    Returns
    -------
    three int: labels, labels with a burst, bursts without a label
    """
    walk = load_walk(folder, name)
    acc, rate = walk.recording.sensor("frame").acc_mps2, walk.recording.sampling_rate_hz
    square = np.sum((acc - np.median(acc, axis=0)) ** 2, axis=1)
    # A running sum may end a little below zero.
    mean = np.maximum(ndimage.uniform_filter1d(square, round(BURST_MEAN_S * rate)), 0)
    level = np.sqrt(mean)
    loud = ndimage.binary_closing(
        level > limit_mps2, np.ones(round(BURST_MERGED_S * rate), np.bool_)
    )
    runs = [run for run in runs_of(loud) if run.stop - run.start > BURST_S * rate]
    time = walk.recording.time_s
    ends = np.array([(time[run.start], time[run.stop - 1]) for run in runs]).reshape(-1, 2)
    return _counts(walk, *ends.T)


def _counts(walk: Walk, lift_s: FloatArray, place_s: FloatArray) -> tuple[int, int, int]:
    matched = match_labels(lift_s, place_s, walk.labels)
    return len(walk.labels), int((matched.of_label >= 0).sum()), len(matched.others)


VARIANTS: dict[str, dict[str, Any]] = {
    "every move is a step": {"least_length_m": 1e-9},
    "a step has 10 cm or more": {"least_length_m": 0.10},
    "sensor taken to be 0.4 m lower": {"place_m": (0.3, 0.0, 0.3)},
    "sensor taken to be 0.3 m further back": {"place_m": (0.0, 0.0, 0.7)},
    "gyroscope off by 2.5 deg/s": {"offset_degps": 2.5},
}
"""What is changed, one thing at a time, to see what the count depends on."""


def simulated_row(seed: int, level: str) -> dict[str, Any]:
    """The same numbers for a simulated corridor of 10 m: what the simulation promises.

    Parameters
    ----------
    seed : of the walk and of the sensor; the mounting is that of Table 1, row 1
    level : of ``mobility_imu.simulation.levels.LEVELS``, or "real" for its ``REAL_LEVEL``

    Returns
    -------
    dict: ``level``, ``seed``, true and found ``steps``, medians as in ``walk_row``,
    ``still_percent``, ``end_sd_m``, ``end_error_m``, ``nis``
    """
    chosen = REAL_LEVEL if level == "real" else LEVELS[level]
    motion = simulate_walk(CORRIDOR, seed=seed, imperfections=chosen.imperfections)
    run = attach_imu(motion, MOUNTS["1"], chosen.sensor, seed=1000 + seed, unit_seed=seed)
    settings = None if level == "real" else NavigationSettings.for_calibrated_sensor()
    found = estimate_trajectory(run.recording, FOOTPRINT, MOUNTS["1"], settings)
    steps = find_steps(found)
    true = run.position_body_m[-1] - run.position_body_m[0]
    return {
        "level": level,
        "seed": seed,
        "true_steps": len(motion.steps),
        "steps": len(steps),
        **medians_of(steps),
        "still_percent": rounded(100 * found.stationary.mean(), 1),
        "end_sd_m": rounded(found.horizontal_sd_m[-1], 3),
        "end_error_m": rounded(np.linalg.norm((found.position_m[-1] - true)[:2]), 3),
        "nis": rounded(mean_nis(run.recording), 2),
    }


def simulated_spectra(level: str) -> dict[str, Any]:
    """Spectra of the simulated sensor on its frame, as those of the recordings.

    Parameters
    ----------
    level : of ``mobility_imu.simulation.levels.LEVELS``

    Returns
    -------
    dict as :func:`~mobility_imu.reproduction.walker.real_sensors.spectra` gives it
    """
    chosen = LEVELS[level]
    pairs = []
    for seed in SIMULATED_SEEDS[:2]:
        motion = simulate_walk(CORRIDOR, seed=seed, imperfections=chosen.imperfections)
        run = attach_imu(motion, MOUNTS["1"], chosen.sensor, seed=1000 + seed, unit_seed=seed)
        found = estimate_trajectory(run.recording, FOOTPRINT, MOUNTS["1"])
        pairs.append((run.recording, found.stationary))
    return spectra(pairs)


def real_walks(executor: Any = None) -> dict[str, Any] | None:
    """Record ``real_walks``: every walk, the variants, spectra, and simulated walks beside them.

    Parameters
    ----------
    executor : anything with ``submit``; None computes in this process

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if the data set is not here
    """
    folder = find_folder(DATASET)
    if folder is None:
        return None
    names = [name for name in walk_names(folder) if name not in HELD_BACK]
    rows = run_all(walk_row, [(folder, name) for name in names], executor)
    levels = [(seed, level) for level in ("sensor", "realistic") for seed in SIMULATED_SEEDS]
    files = checksums(folder, [*(f"{n}.csv.gz" for n in names), "labelled_steps.csv", "mount.toml"])
    summary = {
        **summarised(rows),
        "variants": {
            "as it is": totals(rows),
            **{what: _varied(folder, names, change) for what, change in VARIANTS.items()},
        },
        "near": near_counts(folder, names),
        "limits": [
            {"factor": factor, **_varied(folder, names, {"limits": factor})}
            for factor in LIMIT_FACTORS
        ],
        "bursts": [
            {"limit_mps2": limit, **_summed([burst_counts(folder, n, limit) for n in names])}
            for limit in BURST_LIMITS_MPS2
        ],
        "simulated": run_all(simulated_row, levels, executor),
        "simulated_as_real": run_all(
            simulated_row, [(seed, "real") for seed in SIMULATED_SEEDS], executor
        ),
        "sensors": sensors_summary([row["sensor"] for row in rows]),
        "spectra": _walk_spectra(folder, names),
        "simulated_spectra": simulated_spectra("realistic"),
    }
    numbers = {
        "origin": origin_of(DATASET),
        "files": files,
        "rows": [kept(row) for row in rows],
        "summary": summary,
    }
    return {"numbers": numbers, "inputs": files}


def summarised(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Totals over all walks.

    Parameters
    ----------
    rows : from ``walk_row``

    Returns
    -------
    dict: ``walks``, ``labels``, ``found``, ``others``, ``before``, ``left_out``, ``split`` and
    ``found_percent``, ``others_percent`` of the labels
    """
    names = ("labels", "found", "others", "before", "left_out", "split")
    sums = {name: sum(row[name] for row in rows) for name in names}
    return {
        "walks": len(rows),
        **sums,
        "found_percent": rounded(100 * sums["found"] / sums["labels"], 2),
        "others_percent": rounded(100 * sums["others"] / sums["labels"], 2),
    }


def totals(rows: list[dict[str, Any]]) -> dict[str, int]:
    """Labels, those found, and others, over all walks.

    Parameters
    ----------
    rows : from ``walk_row``
    """
    return {name: sum(row[name] for row in rows) for name in ("labels", "found", "others")}


def _varied(folder: Path, names: list[str], change: dict[str, Any]) -> dict[str, int]:
    return _summed([counted(folder, name, **change) for name in names])


def _summed(counts: list[tuple[int, int, int]]) -> dict[str, int]:
    total = np.sum(counts, axis=0).tolist()
    return dict(zip(("labels", "found", "others"), total, strict=True))


def _walk_spectra(folder: Path, names: list[str]) -> dict[str, Any]:
    pairs = []
    for name in names:
        walk = load_walk(folder, name)
        found = estimate_trajectory(walk.recording, walk.geometry, walk.mount)
        rest = np.zeros(len(walk.recording), np.bool_)
        rest[-len(found) :] = found.stationary
        pairs.append((walk.recording, rest))
    return spectra(pairs)
