"""Walker on real walks: steps found beside those that the recordings' authors labelled.

The walks are of a frame with one IMU on it, see ``labelled-walks`` in
``datasets``. Known are windows of two seconds that their authors cut out as steps.
Footprint, place of the sensor, which way is forward, course and person are not known: an assumed
mount stands for them. So steps can be judged here, the path cannot.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Recording
from mobility_imu.reproduction.walker.real_sensors import (
    kinds_of,
    rounded,
    sensor_row,
)
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.steps import Steps, find_steps
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory

if TYPE_CHECKING:
    import pandas as pd

DATASET = "labelled-walks"
HELD_BACK = tuple(f"walk_{number:02d}" for number in (3, 6, 12, 15, 18, 21, 24, 27, 30))
"""Walks that were not looked at until the settings were fixed; they have a record of their own."""
NEAR_S = 1.0
"""A step belongs to a label if its middle is this near to the label's, and to one label only."""
AROUND_S, SPEED_HZ = 4.0, 10.0
"""Forward speed is kept this long on both sides of a step without a label, at this rate."""
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


def match_labels(
    lift_s: FloatArray, place_s: FloatArray, labels: pd.DataFrame, near_s: float = NEAR_S
) -> Matched:
    """Step of each label: the nearest in time that no earlier label has taken.

    Parameters
    ----------
    lift_s, place_s : (k,) arrays, s
    labels : DataFrame with ``begin_s`` and ``end_s``, in the order of time
    near_s : s, largest distance of the middles

    Returns
    -------
    Matched
    """
    middle = (lift_s + place_s) / 2
    free = set(range(len(middle)))
    of_label = []
    for label in (labels["begin_s"] + labels["end_s"]) / 2:
        near = [k for k in free if abs(middle[k] - label) < near_s]
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
        **medians_of(steps),
        "off_s": rounded(np.mean(middle[hit] - window), 3),
        "off_sd_s": rounded(np.std(middle[hit] - window), 3),
        "still_percent": rounded(100 * found.stationary.mean(), 1),
        "end_m": rounded(np.linalg.norm(found.position_m[-1, :2]), 2),
        "end_sd_m": rounded(found.horizontal_sd_m[-1], 3),
        "nis": rounded(mean_nis(walk.recording), 2),
        "warnings": kinds_of([*found.warnings, *steps.warnings]),
        "sensor": sensor_row(walk.recording, rest),
        "seen": others,
    }


def medians_of(steps: Steps) -> dict[str, float]:
    """Medians over the steps: ``swing_s``, ``length_m``, ``lift_mm``, ``pitch_deg``.

    Parameters
    ----------
    steps : Steps
    """
    return {
        "swing_s": rounded(np.median(steps.swing_s), 2),
        "length_m": rounded(np.median(steps.length_m), 3),
        "lift_mm": rounded(1000 * np.median(steps.lift_height_m), 1),
        "pitch_deg": rounded(np.rad2deg(np.median(steps.pitch_rad)), 2),
    }


def mean_nis(recording: Recording) -> float:
    """Mean normalised innovation per observed number; strides count as one sample's update.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    """
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
    speed = np.interp(clock, found.time_s, forward_speed(found), left=np.nan, right=np.nan)
    return {
        "walk": walk.name,
        "lift_s": rounded(lift, 2),
        "place_s": rounded(place, 2),
        "length_m": rounded(steps.length_m[k], 2),
        "kind": kind_of_other(lift, place, walk.labels),
        "seen": LOOKED_AT.get((walk.name, round(lift, 1)), "not looked at"),
        "speed_mps": [None if np.isnan(v) else rounded(v, 2) for v in speed],
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


def kept(row: dict[str, Any]) -> dict[str, Any]:
    """Part of a row that the record keeps; the rest is in its summary.

    Parameters
    ----------
    row : from :func:`walk_row`
    """
    return {name: value for name, value in row.items() if name != "sensor"}
