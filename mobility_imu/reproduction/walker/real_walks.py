"""Walker on real walks: steps found beside those that the recordings' authors labelled.

The walks are of a frame with one IMU on it, see ``labelled-walks`` in
:mod:`mobility_imu.datasets`. Known are windows of two seconds that their authors cut out as steps.
Footprint, place of the sensor, which way is forward, course and person are not known: an assumed
mount stands for them. So steps can be judged here, the path cannot.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.datasets.catalogue import find_dataset
from mobility_imu.datasets.folders import find_folder
from mobility_imu.executors import run_all
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.real_sensors import (
    kinds_of,
    rounded,
    sensor_row,
    sensors_summary,
    spectra,
)
from mobility_imu.runs import runs_of
from mobility_imu.simulation.levels import LEVELS, MOUNTS
from mobility_imu.simulation.walker import CORRIDOR, attach_imu, simulate_walk
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.geometry import FOOTPRINT, WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.steps import GaitSettings, Steps, find_steps
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory

if TYPE_CHECKING:
    import pandas as pd

DATASET = "labelled-walks"
NEAR_S = 1.0
"""A step belongs to a label if its middle is this near to the label's, and to one label only."""
AROUND_S, SPEED_HZ = 4.0, 10.0
"""Forward speed is kept this long on both sides of a step without a label, at this rate."""
LIMIT_FACTORS = (0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4, 2.0)
"""By which both limits of the stillness detector are multiplied."""
BURST_S, BURST_MERGED_S, BURST_MEAN_S = 0.5, 0.5, 0.2
"""A method without a filter: least length of a burst, gaps that are closed, length of the mean."""
BURST_LIMITS_MPS2 = (0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8)
"""What the force's running rms about its median has to pass there."""
SIMULATED_SEEDS = range(8)

LOOKED_AT: dict[tuple[str, float], str] = {
    ("walk_01", 19.9): "step like its neighbours",
    ("walk_05", 16.2): "step, after a second of shaking on the spot",
    ("walk_16", 29.2): "first part of a labelled step",
    ("walk_17", 7.2): "two steps or more without a stand between them, counted as one",
    ("walk_20", 1.0): "step, short",
    ("walk_23", 0.4): "step, then slow rolling up to the next one",
    ("walk_25", 46.1): "step like its neighbours",
    ("walk_25", 52.4): "step like its neighbours",
    ("walk_26", 0.4): "step like its neighbours",
    ("walk_28", 0.6): "step like its neighbours",
    ("walk_28", 3.1): "step like its neighbours",
    ("walk_28", 5.3): "step like its neighbours",
    ("walk_28", 7.8): "step like its neighbours",
    ("walk_28", 24.3): "first part of a labelled step",
}
"""What we saw in the readings around each step without a label, by walk and time of lifting."""


class Walk(NamedTuple):
    """One real walk: recording, assumed frame, labelled windows.

    Parameters
    ----------
    name : such as "walk_01"
    recording : Recording with a sensor "frame"
    geometry, mount : assumed
    labels : DataFrame with ``begin_s`` and ``end_s``
    """

    name: str
    recording: Recording
    geometry: WalkerGeometry
    mount: WalkerMount
    labels: pd.DataFrame


class Matched(NamedTuple):
    """Steps held against labels.

    Parameters
    ----------
    of_label : number of the step that belongs to each label, -1 if none does
    others : numbers of the steps without a label, in their order
    """

    of_label: NDArray[np.int64]
    others: list[int]


def walk_names(folder: Path) -> list[str]:
    """Names of the walks in a folder, sorted.

    Parameters
    ----------
    folder : of the data set
    """
    return sorted(path.name.split(".")[0] for path in folder.glob("walk_??.csv.gz"))


def load_walk(folder: Path, name: str) -> Walk:
    """Read one walk with its labels.

    Parameters
    ----------
    folder : of the data set
    name : such as "walk_01"

    Returns
    -------
    Walk
    """
    import pandas as pd

    labels = pd.read_csv(folder / "labelled_steps.csv")
    read = read_recording(folder / f"{name}.csv.gz")
    return Walk(
        name,
        # Warnings name the walk, not where it lies on this machine.
        Recording(read.time_s, read.sensors, source=name),
        WalkerGeometry.from_toml(folder / "mount.toml"),
        WalkerMount.from_toml(folder / "mount.toml"),
        labels[labels["walk"] == name].reset_index(drop=True),
    )


def match_labels(lift_s: FloatArray, place_s: FloatArray, labels: pd.DataFrame) -> Matched:
    """Step of each label: the nearest in time that no earlier label has taken.

    Parameters
    ----------
    lift_s, place_s : (k,) arrays, s
    labels : DataFrame with ``begin_s`` and ``end_s``, in the order of time

    Returns
    -------
    Matched
    """
    middle = (lift_s + place_s) / 2
    free = set(range(len(middle)))
    of_label = []
    for label in (labels["begin_s"] + labels["end_s"]) / 2:
        near = [k for k in free if abs(middle[k] - label) < NEAR_S]
        best = min(near, key=lambda k: abs(middle[k] - label)) if near else -1
        free.discard(best)
        of_label.append(best)
    return Matched(np.array(of_label, np.int64), sorted(free))


def kind_of_other(lift_s: float, place_s: float, labels: pd.DataFrame) -> str:
    """Why a step has no label, by the times alone.

    Parameters
    ----------
    lift_s, place_s : s
    labels : DataFrame with ``begin_s`` and ``end_s`` of the walk

    Returns
    -------
    "before the first label"; "split" if it lies over a window whose label has a step already;
    "left out" of the labels otherwise
    """
    if place_s < labels["begin_s"].min():
        return "before the first label"
    over = (labels["begin_s"] < place_s) & (labels["end_s"] > lift_s)
    return "split" if over.any() else "left out"


def walk_row(folder: Path, name: str) -> dict[str, Any]:
    """Numbers of one walk.

    Parameters
    ----------
    folder : of the data set
    name : such as "walk_01"

    Returns
    -------
    dict: ``labels`` and ``found`` of them, ``steps``, ``others`` (their number) and its parts
    ``before``, ``left_out``, ``split``; ``between``, steps from the first label to the last;
    medians of ``swing_s``, ``length_m``, ``lift_mm`` and ``pitch_deg``; of the labelled steps
    ``off_s`` (mean of their middle after the label's) and ``off_sd_s``; ``still_percent``,
    ``end_m`` from the start, ``end_sd_m``, ``nis`` (mean normalised innovation of a sample's
    update), ``warnings``, ``sensor`` and ``seen``, the steps without a label one by one
    """
    walk = load_walk(folder, name)
    found = estimate_trajectory(walk.recording, walk.geometry, walk.mount)
    steps = find_steps(found)
    matched = match_labels(steps.lift_s, steps.place_s, walk.labels)
    others = [_other(walk, found, steps, k) for k in matched.others]
    kinds = [other["kind"] for other in others]
    hit = matched.of_label[matched.of_label >= 0]
    window = walk.labels[["begin_s", "end_s"]].mean(axis=1).to_numpy()[matched.of_label >= 0]
    middle = (steps.lift_s + steps.place_s) / 2
    inside = (middle > walk.labels["begin_s"].min()) & (middle < walk.labels["end_s"].max())
    rest = np.zeros(len(walk.recording), np.bool_)
    rest[-len(found) :] = found.stationary
    return {
        "walk": name,
        "seconds": rounded(walk.recording.time_s[-1], 1),
        "labels": len(walk.labels),
        "found": len(hit),
        "steps": len(steps),
        "others": len(others),
        "before": kinds.count("before the first label"),
        "left_out": kinds.count("left out"),
        "split": kinds.count("split"),
        "between": int(inside.sum()),
        **_medians(steps),
        "off_s": rounded(np.mean(middle[hit] - window), 3),
        "off_sd_s": rounded(np.std(middle[hit] - window), 3),
        "still_percent": rounded(100 * found.stationary.mean(), 1),
        "end_m": rounded(np.linalg.norm(found.position_m[-1, :2]), 2),
        "end_sd_m": rounded(found.horizontal_sd_m[-1], 3),
        "nis": rounded(_mean_nis(walk.recording), 2),
        "warnings": kinds_of([*found.warnings, *steps.warnings]),
        "sensor": sensor_row(walk.recording, rest),
        "seen": others,
    }


def _medians(steps: Steps) -> dict[str, float]:
    return {
        "swing_s": rounded(np.median(steps.swing_s), 2),
        "length_m": rounded(np.median(steps.length_m), 3),
        "lift_mm": rounded(1000 * np.median(steps.lift_height_m), 1),
        "pitch_deg": rounded(np.rad2deg(np.median(steps.pitch_rad)), 2),
    }


def _mean_nis(recording: Recording) -> float:
    """Mean normalised innovation per observed number; strides count as one sample's update."""
    path, _ = navigate_recording(recording)
    strides, samples = np.count_nonzero(path.nis_dof), np.count_nonzero(path.still)
    return float(path.nis.sum() / path.nis_dof.sum() * strides / samples)


def _other(walk: Walk, found: Trajectory, steps: Steps, k: int) -> dict[str, Any]:
    """One step without a label: when, how far, of which kind, and the speed around it."""
    lift, place = float(steps.lift_s[k]), float(steps.place_s[k])
    clock = np.arange(lift - AROUND_S, place + AROUND_S, 1 / SPEED_HZ)
    windows = walk.labels[
        (walk.labels["end_s"] > clock[0]) & (walk.labels["begin_s"] < clock[-1])
    ].to_numpy()[:, 1:]
    near = (steps.place_s > clock[0]) & (steps.lift_s < clock[-1])
    moves = np.column_stack([steps.lift_s, steps.place_s])[near]
    return {
        "walk": walk.name,
        "lift_s": rounded(lift, 2),
        "place_s": rounded(place, 2),
        "length_m": rounded(steps.length_m[k], 2),
        "kind": kind_of_other(lift, place, walk.labels),
        "seen": LOOKED_AT.get((walk.name, round(lift, 1)), "not looked at"),
        "speed_mps": np.interp(clock, found.time_s, forward_speed(found), left=np.nan, right=np.nan)
        .round(3)
        .tolist(),
        "windows_s": [[rounded(t - lift, 2) for t in window] for window in windows],
        "moves_s": [[rounded(t - lift, 2) for t in move] for move in moves],
    }


def forward_speed(found: Trajectory) -> FloatArray:
    """Speed of the frame along its forward axis, m/s, averaged over a fifth of a second.

    Parameters
    ----------
    found : Trajectory

    Returns
    -------
    (n,) array
    """
    velocity = np.gradient(found.position_m[:, :2], found.time_s, axis=0)
    ahead = np.column_stack([np.cos(found.yaw_rad), np.sin(found.yaw_rad)])
    count = max(1, round(0.2 / float(np.median(np.diff(found.time_s)))))
    return np.asarray(ndimage.uniform_filter1d(np.sum(velocity * ahead, axis=1), count))


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
    folder, name : as for :func:`load_walk`
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


def burst_counts(folder: Path, name: str, limit_mps2: float) -> tuple[int, int, int]:
    """The same for a method without filter or gyroscope: bursts of the specific force.

    A burst is where the running rms of the force about its median is above a limit.

    Parameters
    ----------
    folder, name : as for :func:`load_walk`
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
    level : of ``mobility_imu.simulation.levels.LEVELS``

    Returns
    -------
    dict: ``level``, ``seed``, true and found ``steps``, medians as in :func:`walk_row`,
    ``still_percent``, ``end_sd_m``, ``end_error_m``, ``nis``
    """
    chosen = LEVELS[level]
    motion = simulate_walk(CORRIDOR, seed=seed, imperfections=chosen.imperfections)
    run = attach_imu(motion, MOUNTS["1"], chosen.sensor, seed=1000 + seed, unit_seed=seed)
    found = estimate_trajectory(run.recording, FOOTPRINT, MOUNTS["1"])
    steps = find_steps(found)
    true = run.position_body_m[-1] - run.position_body_m[0]
    return {
        "level": level,
        "seed": seed,
        "true_steps": len(motion.steps),
        "steps": len(steps),
        **_medians(steps),
        "still_percent": rounded(100 * found.stationary.mean(), 1),
        "end_sd_m": rounded(found.horizontal_sd_m[-1], 3),
        "end_error_m": rounded(np.linalg.norm((found.position_m[-1] - true)[:2]), 3),
        "nis": rounded(_mean_nis(run.recording), 2),
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
    names = walk_names(folder)
    rows = run_all(walk_row, [(folder, name) for name in names], executor)
    levels = [(seed, level) for level in ("sensor", "realistic") for seed in SIMULATED_SEEDS]
    files = checksums(folder, [*(f"{n}.csv.gz" for n in names), "labelled_steps.csv", "mount.toml"])
    summary = {
        **summarised(rows),
        "variants": {
            "as it is": totals(rows),
            **{what: _varied(folder, names, change) for what, change in VARIANTS.items()},
        },
        "limits": [
            {"factor": factor, **_varied(folder, names, {"limits": factor})}
            for factor in LIMIT_FACTORS
        ],
        "bursts": [
            {"limit_mps2": limit, **_summed([burst_counts(folder, n, limit) for n in names])}
            for limit in BURST_LIMITS_MPS2
        ],
        "simulated": run_all(simulated_row, levels, executor),
        "sensors": sensors_summary([row["sensor"] for row in rows]),
        "spectra": _walk_spectra(folder, names),
        "simulated_spectra": simulated_spectra("realistic"),
    }
    numbers = {
        "origin": origin(DATASET),
        "files": files,
        "rows": [kept(row) for row in rows],
        "summary": summary,
    }
    return {"numbers": numbers, "inputs": files}


def kept(row: dict[str, Any]) -> dict[str, Any]:
    """Part of a row that the record keeps; the rest is in its summary.

    Parameters
    ----------
    row : from :func:`walk_row`
    """
    return {name: value for name, value in row.items() if name != "sensor"}


def summarised(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Totals over all walks.

    Parameters
    ----------
    rows : from :func:`walk_row`

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
    rows : from :func:`walk_row`
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


def checksums(folder: Path, names: Iterable[str]) -> dict[str, str]:
    """SHA-256 of files.

    Parameters
    ----------
    folder : in which they lie
    names : of the files

    Returns
    -------
    dict from name to 64 hexadecimal digits
    """
    return {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in names}


def origin(name: str) -> str:
    """Where a data set is from, with its commit and licence, in one line.

    Parameters
    ----------
    name : of the data set
    """
    dataset = find_dataset(name)
    return f"{dataset.origin} at {dataset.commit[:12]}, licence: {dataset.licence}"
