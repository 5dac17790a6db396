"""Faults put into simulated walks and tilts: which are found, what they cost, what is told.

Each kind has a hundred recordings. Sizes are drawn evenly in
their logarithm, from what changes nothing to what spoils the walk. A fault matters if it moves
place or heading somewhere by more than twice the standard deviation that the result without it
states, or, where the motion itself is at fault, if the path is that far from the true one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.faults import Fault
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Recording
from mobility_imu.reproduction.walker.fault_kinds import (
    DRAWN_BY,
    FLOOR_KINDS,
    KINDS,
    MOTION_KINDS,
    TILT_KINDS,
    Injected,
    Walked,
    clean_walk,
)
from mobility_imu.simulation.levels import LEVELS
from mobility_imu.simulation.seeds import stream
from mobility_imu.walker.calibration import (
    WalkerCalibration,
    calibrate_from_path,
    calibrate_mount,
)
from mobility_imu.walker.faults import find_faults, find_tilt_faults
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "CASES",
    "example",
    "false_alarms",
    "numbers_of",
    "one_case",
    "study",
    "summary_of",
    "table",
]

CASES = 100
"""Recordings of each kind."""
POOL = 25
"""Recordings without a fault that the kinds share; places and sizes are drawn anew."""
FIRST_SEED = 308_000
"""Of the study. Nobody had looked at these walks when a check was last changed."""
SEEN_SEED = 8_000
"""Of an earlier run, after which some checks were changed; examples and tests use it."""
FAULTY_LEVELS = ("realistic", "real")
MATTERS = 2.0
SETTLED_M, SETTLED_DEG = 0.005, 0.1
"""Added to the standard deviations, which are nearly zero at the start and do not hold creep and
slip of the tips. Our choice, not swept."""
SETTLED_MOUNT_M, SETTLED_MOUNT_DEG = 0.002, 0.1
"""The same for the mount; 2 mm is what a tape is read to. Our choice, not swept."""
CLEAN = 55
"""Clean walks, and as many clean tilts, of each level."""
FEET = "foot-walks"
WALKS = "labelled-walks"


@lru_cache(maxsize=POOL)
def _pool(k: int, first_seed: int) -> Walked:
    return clean_walk(first_seed + k, FAULTY_LEVELS[k % 2])


@lru_cache(maxsize=POOL)
def _path(k: int, first_seed: int) -> Trajectory:
    walk = _pool(k, first_seed)
    return estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)


@lru_cache(maxsize=POOL)
def _calibration(k: int, first_seed: int) -> WalkerCalibration:
    walk = _pool(k, first_seed)
    return calibrate_mount(walk.tilts.recording, walk.tape)


def _base(kind: str, case: int) -> int:
    """Number of the recording in the pool.

    Where the path is held against the truth, errors that a sensor of the level "real" has anyway
    would count as those of the fault: these kinds have the other level alone.
    """
    return 2 * (case % ((POOL + 1) // 2)) if kind in MOTION_KINDS else case % POOL


def _drawn(kind: str, case: int, first_seed: int) -> Injected:
    """The faulty recording of a case."""
    injection = {**KINDS, **TILT_KINDS}[kind][0]
    rng = stream(first_seed, DRAWN_BY[kind], case)
    return injection(_pool(_base(kind, case), first_seed), rng)


def one_case(kind: str, case: int, first_seed: int = FIRST_SEED) -> dict[str, Any]:
    """Inject one fault and look for it.

    Parameters
    ----------
    kind : a key of ``KINDS`` or ``TILT_KINDS``
    case : 0 to 99
    first_seed : of the walks

    Returns
    -------
    dict
        ``sensor``, ``size``, ``unit``; ``ratio``: largest change in standard deviations; ``of``:
        the result that changes most by it; ``found_as``: codes, or "refused"; ``right``: whether
        the kind is rightly named or refused; ``cost_real`` and ``cost_stated`` of that result,
        None where there is none
    """
    base = _base(kind, case)
    clean = _pool(base, first_seed)
    row: dict[str, Any] = {"kind": kind, "case": case}
    try:
        faulty = _drawn(kind, case, first_seed)
        row |= {"sensor": faulty.sensor, "size": faulty.size, "unit": faulty.unit}
        if kind in TILT_KINDS:
            found = find_tilt_faults(faulty.recording, faulty.tape, order=faulty.order)
            made = _mount_of(faulty)
            moved = _mount_moved(_calibration(base, first_seed), made)
        else:
            found = find_faults(faulty.recording, clean.tape, faulty.mount)
            path = estimate_trajectory(faulty.recording, clean.tape, faulty.mount)
            moved = (
                _path_moved(_path(base, first_seed), path)
                if faulty.truth is None
                else _path_off(faulty, path)
            )
    except InputError:
        return row | {"ratio": float("inf"), "found_as": "refused", "right": True}
    codes = {**KINDS, **TILT_KINDS}[kind][1]
    told = sorted({fault.code for fault in found})
    of = max(moved, key=lambda name: moved[name][0])
    # What is stated of a start is not how far the path is off the true one.
    comparable = faulty.truth is None or kind in FLOOR_KINDS
    return row | {
        "ratio": moved[of][0],
        "of": of,
        "found_as": ", ".join(told),
        "right": bool(codes & set(told)),
        "cost_real": moved[of][1],
        "cost_stated": _stated(found, of, codes) if comparable else None,
    }


def _stated(found: tuple[Fault, ...], of: str, codes: frozenset[str]) -> float | None:
    """Cost that is told of a result, of the faults of the right kind."""
    costs = [c.largest for f in found if f.code in codes for c in f.costs if c.name == of]
    return max(costs) if costs else None


Moved = dict[str, tuple[float, float]]


def _path_moved(clean: Trajectory, faulty: Trajectory) -> Moved:
    """How far place and heading moved: in standard deviations, and in m and deg."""
    at = faulty.time_s
    if at[0] > clean.time_s[-1] or at[-1] > 2 * clean.time_s[-1] or len(at) == len(clean):
        at = clean.time_s[-len(at) :]  # another clock: sample by sample

    def then(series: FloatArray) -> FloatArray:
        return np.asarray(np.interp(at, clean.time_s, series))

    count = min(len(at), len(faulty))
    apart = [
        faulty.position_m[-count:, k] - then(clean.position_m[:, k])[-count:] for k in range(3)
    ]
    place = np.linalg.norm(apart, axis=0)
    heading = np.rad2deg(np.abs(faulty.yaw_rad[-count:] - then(clean.yaw_rad)[-count:]))
    sd = np.hypot(clean.horizontal_sd_m, clean.position_sd_m[:, 2])
    place_sd = then(sd)[-count:] + SETTLED_M
    heading_sd = np.rad2deg(then(clean.yaw_sd_rad)[-count:]) + SETTLED_DEG
    return {
        "place": (float((place / place_sd).max()), float(place.max())),
        "heading": (float((heading / heading_sd).max()), float(heading.max())),
    }


def _path_off(faulty: Injected, path: Trajectory) -> Moved:
    """How far a path is from the true one, from where it begins on, in its own deviations."""
    assert faulty.truth is not None
    count = len(path)
    position = faulty.truth.position_body_m[-count:]
    rotation = faulty.truth.rotation_body_to_world[-count:]
    begin = rotation[0]
    c, s = begin[0, 0], begin[1, 0]
    level = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) / np.hypot(c, s)
    level[2, 2] = 1.0
    place = np.linalg.norm(path.position_m - (position - position[0]) @ level.T, axis=1)
    true = rotation[:, :2, 0] @ level[:2, :2].T
    heading = np.rad2deg(np.abs(np.angle(np.exp(1j * (np.arctan2(*true.T[::-1]) - path.yaw_rad)))))
    upright = rotation[:, 2, 2] > 0.8
    place_sd = np.hypot(path.horizontal_sd_m, path.position_sd_m[:, 2]) + SETTLED_M
    heading_sd = np.rad2deg(path.yaw_sd_rad) + SETTLED_DEG
    return {
        "place": (float((place / place_sd).max()), float(place.max())),
        "heading": (
            float((heading / heading_sd)[upright].max()),
            float(heading[upright].max()),
        ),
    }


def _mount_of(faulty: Injected) -> WalkerCalibration:
    """Mount as the command finds it, without the work for its standard deviations."""
    path, _ = navigate_recording(faulty.recording)
    return calibrate_from_path(path, faulty.tape, order=faulty.order)


def _mount_moved(clean: WalkerCalibration, faulty: WalkerCalibration) -> Moved:
    """How far the mount moved: in standard deviations, and in m and deg.

    Each axis of the position over its own standard deviation, the largest; the cost is a distance.
    """
    apart = faulty.mount.translation_body_m - clean.mount.translation_body_m
    turn = faulty.mount.rotation_imu_to_body @ clean.mount.rotation_imu_to_body.T
    ratio = float((np.abs(apart) / (clean.translation_sd_m + SETTLED_MOUNT_M)).max())
    angle = float(np.rad2deg(Rotation.from_matrix(turn).magnitude()))
    angle_sd = float(np.rad2deg(np.linalg.norm(clean.rotation_sd_rad)))
    return {
        "position of the IMU": (ratio, float(np.linalg.norm(apart))),
        "turn of the IMU": (angle / (angle_sd + SETTLED_MOUNT_DEG), angle),
    }


def false_alarms(seed: int, level: str) -> dict[str, Any]:
    """What is told of a walk and of tilts without a fault.

    Parameters
    ----------
    seed : of the motion
    level : "data sheet", "sensor", "realistic" or "real"

    Returns
    -------
    dict with ``level``, ``seed``, ``walk`` and ``tilts``, lists of "code sensor size"
    """
    walk = clean_walk(seed, level, with_sd=False)
    return {
        "level": level,
        "seed": seed,
        "walk": _words(find_faults(walk.walk.recording, walk.tape, walk.mount)),
        "tilts": _words(find_tilt_faults(walk.tilts.recording, walk.tape)),
    }


def _words(found: tuple[Fault, ...]) -> list[str]:
    return [
        f"{fault.code} {fault.sensor}" + ("" if np.isnan(fault.size) else f" {fault.size:.3g}")
        for fault in found
    ]


def real_alarms() -> dict[str, dict[str, list[str]]]:
    """What is told of the real walks and feet, by data set and recording; empty without them.

    Feet are taken as if they were frames: their first half second is level, nothing else is known.
    """
    told: dict[str, dict[str, list[str]]] = {}
    for dataset, pattern in ((WALKS, "walk_??.csv.gz"), (FEET, "foot_??.csv.gz")):
        folder = find_folder(dataset)
        if folder is None:
            continue
        told[dataset] = {}
        for path in sorted(folder.glob(pattern)):
            recording = read_recording(path, fill_gaps_s=0.05)
            mount = (
                WalkerMount.from_toml(folder / "mount.toml")
                if dataset == WALKS
                else _levelled(recording)
            )
            told[dataset][path.name.split(".")[0]] = _told_of(recording, mount)
    return told


def _told_of(recording: Recording, mount: WalkerMount) -> list[str]:
    try:
        estimate_trajectory(recording, None, mount)
    except InputError:
        return ["refused"]
    return _words(find_faults(recording, None, mount))


def _levelled(recording: Recording) -> WalkerMount:
    """Mount by which the sensor is upright in the first half second, at the ankle."""
    first = recording.time_s < recording.time_s[0] + 0.5
    up = recording.sensor("frame").acc_mps2[first].mean(axis=0)
    up = up / np.linalg.norm(up)
    side = np.cross(up, [1.0, 0.0, 0.0])
    side = side / np.linalg.norm(side)
    return WalkerMount(np.array([np.cross(side, up), side, up]), np.array([0.0, 0.0, 0.1]))


def study(executor: Any = None) -> dict[str, Any] | None:
    """Faults that are found, and alarms where there is none.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here

    Returns
    -------
    dict with ``numbers``, see :func:`numbers_of`, and beside them ``real``, the alarms on real
    recordings; None if these are not here
    """
    if find_folder(WALKS) is None or find_folder(FEET) is None:
        return None
    jobs = [(kind, list(range(k, CASES, 4))) for k in range(4) for kind in (*KINDS, *TILT_KINDS)]
    rows = [row for some in run_all(_cases, jobs, executor) for row in some]
    levels = (*LEVELS, "real")
    quiet = [
        (FIRST_SEED + 1000 * m + k, level)
        for m, level in enumerate(levels, start=1)
        for k in range(CLEAN)
    ]
    clean = run_all(false_alarms, quiet, executor)
    return {"numbers": numbers_of(rows, clean) | {"real": real_alarms()}}


def _cases(kind: str, cases: list[int]) -> list[dict[str, Any]]:
    return [one_case(kind, case) for case in cases]


COLUMNS = ("sensor", "size", "unit", "ratio", "of", "found_as", "right", "cost_stated", "cost_real")
"""Of a row as the record keeps it: one line with semicolons, nothing where there is no number."""
NUMBERS = ("size", "ratio", "cost_stated", "cost_real")


def numbers_of(rows: list[dict[str, Any]], clean: list[dict[str, Any]]) -> dict[str, Any]:
    """Rows and alarms as the record has them.

    Parameters
    ----------
    rows : of :func:`one_case`
    clean : of :func:`false_alarms`

    Returns
    -------
    dict: ``kinds``, rows of :func:`summary_of`; ``cases``, lines by kind, see ``COLUMNS``;
    ``clean``, alarms by level, of walks and of tilts
    """
    cases = {
        kind: [_line(row) for row in sorted(of_kind, key=lambda r: r["case"])]
        for kind in (*KINDS, *TILT_KINDS)
        if (of_kind := [row for row in rows if row["kind"] == kind])
    }
    alarms = {
        level: {
            "recordings": len(mine),
            **{
                f"{what}_with_alarm": sum(bool(one[what]) for one in mine)
                for what in ("walk", "tilts")
            },
            "told": {
                f"{what} {one['seed']}": one[what]
                for one in mine
                for what in ("walk", "tilts")
                if one[what]
            },
        }
        for level in dict.fromkeys(one["level"] for one in clean)
        if (mine := [one for one in clean if one["level"] == level])
    }
    return {"kinds": [summary_of(kind, rows) for kind in cases], "cases": cases, "clean": alarms}


def _line(row: dict[str, Any]) -> str:
    return ";".join(str(_kept(row.get(column))) for column in COLUMNS)


def _kept(value: Any) -> Any:
    """Three digits of a number, and 1 or 0; nothing for what there is no number for."""
    if value is None or (isinstance(value, float) and not np.isfinite(value)):
        return ""
    return f"{value:.3g}" if isinstance(value, float) else int(value) if value in (0, 1) else value


def table(numbers: dict[str, Any]) -> pd.DataFrame:
    """All cases of a record.

    Parameters
    ----------
    numbers : of :func:`numbers_of`

    Returns
    -------
    DataFrame: ``kind``, ``case``, those of ``COLUMNS``, and ``matters``: whether the ratio is
    above ``MATTERS``; a refusal counts as mattering
    """
    import pandas as pd

    rows = [
        (kind, case, *line.split(";"))
        for kind, lines in numbers["cases"].items()
        for case, line in enumerate(lines)
    ]
    found = pd.DataFrame(rows, columns=["kind", "case", *COLUMNS])
    for column in NUMBERS:
        found[column] = pd.to_numeric(found[column], errors="coerce")
    found["right"] = found["right"] == "1"
    found["matters"] = (found["ratio"] > MATTERS) | (found["found_as"] == "refused")
    return found


def summary_of(kind: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How many faults of a kind matter, are found, and have a cost that holds.

    Parameters
    ----------
    kind : a key of ``KINDS`` or ``TILT_KINDS``
    rows : of :func:`one_case`

    Returns
    -------
    dict with ``cases``, ``refused``, ``matter`` (refusals left out), and of those that matter
    ``told`` (at all) and ``right`` (named rightly); of those that are told ``priced``, whose right
    name states a cost of the result that moves most, and of these ``within_two``, whose cost is
    right within a factor of two; ``unpriced``, told without such a cost; ``largest_missed`` (in
    standard deviations); ``told_in_vain``, told though they do not matter
    """
    mine = [row for row in rows if row["kind"] == kind]
    refused = [row for row in mine if row["found_as"] == "refused"]
    seen = [row for row in mine if row["found_as"] != "refused"]
    matter = [row for row in seen if row["ratio"] > MATTERS]
    told = [row for row in matter if row["found_as"]]
    priced = [row for row in told if row["right"] and row["cost_stated"] is not None]
    within = [r for r in priced if 0.5 <= r["cost_stated"] / max(r["cost_real"], 1e-9) <= 2.0]
    missed = [row["ratio"] for row in matter if not row["found_as"]]
    return {
        "kind": kind,
        "cases": len(mine),
        "refused": len(refused),
        "matter": len(matter),
        "told": len(told),
        "right": sum(row["right"] for row in matter),
        "priced": len(priced),
        "within_two": len(within),
        "unpriced": len(told) - len(priced),
        "largest_missed": float(f"{max(missed, default=0.0):.3g}"),
        "told_in_vain": sum(bool(row["found_as"]) for row in seen if row["ratio"] <= MATTERS),
    }


@dataclass(frozen=True, eq=False)
class Example:
    """A walk with and without a fault, for a drawing.

    Parameters
    ----------
    clean, faulty : Recording
    result_clean, result_faulty : Trajectory; the first is None where the motion is at fault
    faults : what is found, with costs
    """

    clean: Recording
    faulty: Recording
    result_clean: Trajectory | None
    result_faulty: Trajectory
    faults: tuple[Fault, ...]


def example(kind: str, case: int = 0) -> Example:
    """A walk with and without a fault, for a drawing.

    Parameters
    ----------
    kind : a key of ``KINDS``
    case : 0 to 99, which of its walks

    Returns
    -------
    Example
    """
    base = _base(kind, case)
    clean, faulty = _pool(base, SEEN_SEED), _drawn(kind, case, SEEN_SEED)
    return Example(
        clean.walk.recording,
        faulty.recording,
        _path(base, SEEN_SEED) if faulty.truth is None else None,
        estimate_trajectory(faulty.recording, clean.tape, faulty.mount),
        find_faults(faulty.recording, clean.tape, faulty.mount),
    )
