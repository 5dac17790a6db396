"""Walker's filter and smoother on feet: the path beside that of a motion capture system.

The sensor is on a foot, see ``foot-walks`` in ``datasets``; a foot is not the
walker's device. It is the one public recording by which its filter can be judged. Given to the
filter are the rests (the origin's best mask); fitted is the heading's zero. The mount is made from
the gravity of the first half second.
"""

from __future__ import annotations

import warnings
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial.transform import Rotation

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import checksums, origin_of
from mobility_imu.reproduction.walker.real_sensors import (
    kinds_of,
    rounded,
    sensor_row,
    sensors_summary,
    spectra,
)
from mobility_imu.reproduction.walker.studies import Level, walking_study
from mobility_imu.results import Result
from mobility_imu.runs import runs_of
from mobility_imu.simulation.levels import REAL_LEVEL
from mobility_imu.simulation.walker import RECTANGLE
from mobility_imu.walker.error_state import NavigationState
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation import NavigationSettings, integrate_strapdown
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory

DATASET = "foot-walks"
HELD_BACK = tuple(f"{number:02d}" for number in range(2, 57, 2))
"""Walks that were not looked at until the settings were fixed; they have a record of their own."""
FILL_GAPS_S = 0.05
"""Gaps of the clock up to this are filled, as ``--fill-gaps-s`` does."""
UPRIGHT_S = 0.5
"""The gravity of this time at the start makes the mount."""
FAST_MPS = 0.5
"""A foot that moves faster does not rest, whatever the mask says."""
CUT_DEGPS = 500.0
"""Readings of this gyroscope pile up a little above, whatever the foot does: its range."""
JUMP_MPS = 10.0
"""No foot is so fast (twice the fastest swing of a runner here): markers were exchanged or lost."""
SURE_M = 1e-4
"""Where the stated standard deviation is below this the walk has not begun."""
WITHIN = 1.96
EDGES = (-np.inf, *np.arange(-4.0, 4.5, 0.5).tolist(), np.inf)
"""Bins of the errors over the stated standard deviation."""
SHOWN = ("13", "35")
"""Walks whose error is kept over time: one like most, and the worst."""
SHOWN_HZ = 1.2

SIMULATED_SEEDS = range(4)
"""Of the simulated rectangles at the level of real sensors; each in five mountings."""

_FRAME, _FOOT = NavigationSettings.for_calibrated_sensor(), NavigationSettings.for_foot()
WAYS: dict[str, tuple[NavigationSettings, bool]] = {
    "frame": (_FRAME, True),
    "foot": (_FOOT, True),
    "detector": (_FRAME, False),
}
"""Settings of a frame or of a foot with the rests given; a frame's with our detector."""

_FREE = replace(_FRAME, zero_rate=False)
_LEARNED = replace(_FREE, initial_gyr_mean=False)
VARIANTS: dict[str, tuple[NavigationSettings, bool]] = {
    "frame, not smoothed": (_FRAME, False),
    "frame, (24) as printed": (replace(_FRAME, form="printed"), True),
    "no zero rates": (_FREE, True),
    "no zero rates, (24) as printed": (replace(_FREE, form="printed"), True),
    "no zero rates, no first mean": (_LEARNED, True),
    "no zero rates, no first mean, (24) as printed": (replace(_LEARNED, form="printed"), True),
    "foot, range told": (
        NavigationSettings.for_foot(gyr_range_radps=float(np.deg2rad(CUT_DEGPS))),
        True,
    ),
    "foot, not smoothed": (_FOOT, False),
    "foot, (24) as printed": (replace(_FOOT, form="printed"), True),
    "foot, zero rates": (replace(_FOOT, zero_rate=True), True),
    "foot, noise of the frame": (
        replace(
            _FOOT,
            gyr_noise_factor=_FRAME.gyr_noise_factor,
            acc_noise_factor=_FRAME.acc_noise_factor,
        ),
        True,
    ),
}
"""Settings with something changed, and whether smoothed; rests given."""


@dataclass(frozen=True, eq=False, repr=False)
class Foot(Result):
    """One walk of a foot with its truth.

    Parameters
    ----------
    name : two digits
    recording : Recording with a sensor "frame"
    mount : WalkerMount that brings the sensor upright
    place_m : (n, 3) array, m, by motion capture, at the recording's times
    still : (n,) bool array, the origin's mask of rests
    clock_s : (m,) array, s, the times as they were recorded, with gaps
    """

    name: str
    recording: Recording
    mount: WalkerMount
    place_m: FloatArray
    still: NDArray[np.bool_]
    clock_s: FloatArray


def foot_names(folder: Path) -> list[str]:
    """Numbers of the walks in a folder, sorted.

    Parameters
    ----------
    folder : of the data set
    """
    return sorted(path.name[5:7] for path in folder.glob("foot_??.csv.gz"))


def load_foot(folder: Path, name: str) -> Foot:
    """Read one walk; make its mount from the gravity at the start.

    Parameters
    ----------
    folder : of the data set
    name : two digits

    Returns
    -------
    Foot
    """
    import pandas as pd

    with warnings.catch_warnings():  # of gaps that are filled: the table of the sensors has them
        warnings.simplefilter("ignore")
        read = read_recording(folder / f"foot_{name}.csv.gz", fill_gaps_s=FILL_GAPS_S)
    recording = Recording(read.time_s, read.sensors, source=f"foot_{name}")
    truth = pd.read_csv(folder / f"foot_{name}_truth.csv.gz")
    time = recording.time_s
    first = recording.sensor("frame").acc_mps2[time < time[0] + UPRIGHT_S]
    upright, _ = Rotation.align_vectors([[0.0, 0.0, 1.0]], [first.mean(axis=0)])
    place = [np.interp(time, truth["time_s"], truth[f"{axis}_m"]) for axis in "xyz"]
    still = np.interp(time, truth["time_s"], truth["still"]) > 0.99
    mount = WalkerMount(upright.as_matrix(), np.zeros(3))
    clock = truth["time_s"].to_numpy()
    return Foot(name, recording, mount, np.column_stack(place), still, clock)


def follow_foot(foot: Foot, way: str) -> Trajectory:
    """Path of a foot by the walker's command.

    Parameters
    ----------
    foot : Foot
    way : a key of ``WAYS``

    Returns
    -------
    Trajectory
    """
    return _followed(foot, way, foot.still)


def _followed(foot: Foot, way: str, rests: NDArray[np.bool_]) -> Trajectory:
    settings, given = WAYS[way]
    return estimate_trajectory(
        foot.recording, None, foot.mount, settings, rests=rests if given else None
    )


def turned_to_fit(
    path_m: FloatArray, place_m: FloatArray, first: float = 1.0
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Path on the floor and truth, both from their start, the truth turned to fit best.

    Parameters
    ----------
    path_m, place_m : (n, 2) or (n, 3) arrays, m, found and by motion capture
    first : fraction of the samples, from the start, by which the turn is fitted

    Returns
    -------
    two (n,) complex arrays, m, x + iy in the path's own axes
    """
    path, true = (a[:, 0] + 1j * a[:, 1] for a in (path_m, place_m))
    path, true = path - path[0], true - true[0]
    some = slice(0, max(1, round(first * len(path))))
    turn = np.vdot(true[some], path[some])
    return path, true * (turn / abs(turn) if abs(turn) > 0 else 1.0)


def judged(foot: Foot, found: Trajectory) -> dict[str, Any]:
    """Error of one path beside what it states.

    Parameters
    ----------
    foot : Foot
    found : Trajectory

    Returns
    -------
    dict: ``rms_m`` on the floor, heading turned to fit, and ``rms_first_quarter_m``, turned by the
    first quarter alone; ``end_m``; ``height_rms_m``; ``sd_m`` (median of the stated) and ``ratio``
    of rms to it; ``covered_percent`` of both coordinates by 95 % intervals, and ``samples`` of it
    """
    place = foot.place_m[-len(found) :]
    path, true = turned_to_fit(found.position_m, place)
    error = path - true
    early = np.subtract(*turned_to_fit(found.position_m, place, 0.25))
    over, begun = _over_sd(found, error)
    height = found.position_m[:, 2] - (place[:, 2] - place[0, 2])
    size = rms(np.abs(error))
    middle = float(np.median(found.horizontal_sd_m))
    return {
        "rms_m": rounded(size, 4),
        "rms_first_quarter_m": rounded(rms(np.abs(early)), 4),
        "end_m": rounded(abs(error[-1]), 4),
        "height_rms_m": rounded(rms(height), 4),
        "sd_m": rounded(middle, 4),
        "ratio": rounded(size / middle, 2),
        "covered_percent": rounded(100 * np.mean(np.abs(over) < WITHIN), 1),
        "samples": int(np.count_nonzero(begun)),
    }


def _over_sd(
    found: Trajectory, error: NDArray[np.complex128]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Errors over their stated standard deviations, (k, 2), and the samples after the start."""
    sd = found.position_sd_m[:, :2]
    begun = np.asarray((sd > SURE_M).all(axis=1))
    return np.column_stack([error.real, error.imag])[begun] / sd[begun], begun


def error_bins(foot: Foot, way: str) -> list[int]:
    """Errors over their stated standard deviations, counted between ``EDGES``.

    Parameters
    ----------
    foot : Foot
    way : a key of ``WAYS``

    Returns
    -------
    list of int
    """
    found = follow_foot(foot, way)
    path, true = turned_to_fit(found.position_m, foot.place_m[-len(found) :])
    counts, _ = np.histogram(_over_sd(found, path - true)[0], EDGES)
    return [int(count) for count in counts]


def foot_row(folder: Path, name: str) -> dict[str, Any]:
    """Numbers of one walk.

    Parameters
    ----------
    folder : of the data set
    name : two digits

    Returns
    -------
    dict: ``walk``, ``seconds``, ``way_m`` and ``climb_m`` (range of the height) by motion capture,
    ``speed_mps``, ``still_percent``, ``longest_move_s`` and ``slide_mps`` (rms speed of the foot
    in the given rests, by motion capture); ``rests``, their number; ``fast_rests``, those in which
    the foot's mean speed is above ``FAST_MPS``; ``fastest_rest_mps``; where there are fast rests,
    ``without_fast_rests_m``, the error with a foot's settings when they are not given;
    ``cut_samples``, in which a rate is above ``CUT_DEGPS``; ``truth_jumps``, samples at which the
    motion capture itself moves faster than ``JUMP_MPS``; for each of ``WAYS`` what :func:`judged`
    gives with the path's ``warnings``, or ``refused``; ``detector_still_percent``;
    ``strapdown_rms_m`` by integration with the velocity set to zero in rests, without a filter;
    ``start_rms_m`` of an estimate that stays at the start; ``sensor``
    """
    foot = load_foot(folder, name)
    time, place = foot.recording.time_s, foot.place_m
    rate = foot.recording.sampling_rate_hz
    # The markers tremble: a tenth of a second is averaged before the way is summed.
    smooth = ndimage.uniform_filter1d(place, round(0.1 * rate), axis=0)
    way = np.linalg.norm(np.diff(smooth[:: round(0.05 * rate), :2], axis=0), axis=1).sum()
    speed = np.linalg.norm(np.gradient(smooth, time, axis=0), axis=1)
    rates = np.abs(np.rad2deg(foot.recording.gyroscope("frame")))
    in_rests = [float(speed[run].mean()) for run in runs_of(foot.still)]
    steps = np.linalg.norm(np.diff(place, axis=0), axis=1)
    moves = [time[min(run.stop, len(time) - 1)] - time[run.start] for run in runs_of(~foot.still)]
    row: dict[str, Any] = {
        "walk": f"foot_{name}",
        "seconds": rounded(time[-1] - time[0], 1),
        "way_m": rounded(way, 1),
        "climb_m": rounded(np.ptp(place[:, 2]), 2),
        "speed_mps": rounded(way / (time[-1] - time[0]), 2),
        "still_percent": rounded(100 * foot.still.mean(), 1),
        "longest_move_s": rounded(max(moves, default=0.0), 2),
        "slide_mps": rounded(rms(speed[foot.still]), 3),
        "fast_rests": sum(mean > FAST_MPS for mean in in_rests),
        "fastest_rest_mps": rounded(max(in_rests), 2),
        "rests": len(in_rests),
        "cut_samples": int(np.count_nonzero((rates > CUT_DEGPS).any(axis=1))),
        "truth_jumps": int(np.count_nonzero(steps > JUMP_MPS * np.diff(time))),
        "start_rms_m": rounded(rms(np.linalg.norm(place[:, :2] - place[0, :2], axis=1)), 3),
        "strapdown_rms_m": rounded(_strapdown_rms(foot), 3),
        "sensor": sensor_row(foot.recording, foot.still, foot.clock_s),
    }
    if row["fast_rests"]:
        mask = _without_fast_rests(foot, speed)
        row["without_fast_rests_m"] = judged(foot, _followed(foot, "foot", mask))["rms_m"]
    for kind in WAYS:
        try:
            found = follow_foot(foot, kind)
        except InputError as error:
            row[kind] = {"refused": str(error).split(":")[1].strip()}
            continue
        row[kind] = {**judged(foot, found), "warnings": kinds_of(found.warnings)}
        if kind == "detector":
            row["detector_still_percent"] = rounded(100 * found.stationary.mean(), 1)
    return row


def _without_fast_rests(foot: Foot, speed_mps: FloatArray) -> NDArray[np.bool_]:
    """Given rests without those in which the foot moves fast: they show what such a rest costs."""
    still = foot.still.copy()
    for run in runs_of(foot.still):
        if speed_mps[run].mean() > FAST_MPS:
            still[run] = False
    return still


def _strapdown_rms(foot: Foot) -> float:
    """Error of eqs 20 and 21 integrated, with the velocity set to zero in the given rests."""
    begin = int(np.argmax(foot.still))
    imu, gyr = foot.recording.sensor("frame"), foot.recording.gyroscope("frame")
    zero = np.zeros(3)
    turn = Rotation.from_matrix(foot.mount.rotation_imu_to_body).as_quat(scalar_first=True)
    path = integrate_strapdown(
        foot.recording.time_s[begin:],
        imu.acc_mps2[begin:],
        gyr[begin:],
        NavigationState(turn, zero, zero, zero, zero),
        still=foot.still[begin:],
    )
    found, true = turned_to_fit(path.position_m, foot.place_m[begin:])
    return rms(np.abs(found - true))


def over_time(folder: Path, name: str) -> dict[str, Any]:
    """Truth, path and stated standard deviation of one walk, with settings of frame and foot.

    Parameters
    ----------
    folder : of the data set
    name : two digits

    Returns
    -------
    dict: ``walk``, ``time_s``, ``true_x_m``, ``true_y_m``; for "frame" and "foot" ``error_x_m``,
    ``error_y_m`` and ``sd_m`` on the floor, ``SHOWN_HZ`` times a second
    """
    foot = load_foot(folder, name)
    series: dict[str, Any] = {"walk": f"foot_{name}"}
    for way in ("frame", "foot"):
        found = follow_foot(foot, way)
        path, true = turned_to_fit(found.position_m, foot.place_m[-len(found) :])
        time = found.time_s - found.time_s[0]
        some = np.searchsorted(time, np.arange(0, time[-1], 1 / SHOWN_HZ))
        if way == "frame":
            turn = true
            series["time_s"] = time[some].round(2).tolist()
            series["true_x_m"], series["true_y_m"] = _xy(true[some])
        # Both errors in the axes of the first: the headings differ by a little.
        back = np.vdot(true, turn)
        x, y = _xy((path - true)[some] * back / abs(back))
        sd = found.horizontal_sd_m[some].round(3).tolist()
        series[way] = {"error_x_m": x, "error_y_m": y, "sd_m": sd}
    return series


def _xy(values: NDArray[np.complex128]) -> tuple[list[float], list[float]]:
    return values.real.round(3).tolist(), values.imag.round(3).tolist()


def variant_row(folder: Path, name: str) -> dict[str, dict[str, Any]]:
    """Errors of one walk with each of ``VARIANTS``.

    Parameters
    ----------
    folder : of the data set
    name : two digits

    Returns
    -------
    dict from the variant to what :func:`judged` gives
    """
    foot = load_foot(folder, name)
    return {
        what: judged(
            foot,
            estimate_trajectory(
                foot.recording, None, foot.mount, settings, rests=foot.still, smooth=smooth
            ),
        )
        for what, (settings, smooth) in VARIANTS.items()
    }


def real_feet(executor: Any = None) -> dict[str, Any] | None:
    """Record ``real_feet``: every walk, summary, variants, spectra, two walks over time.

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
    names = [name for name in foot_names(folder) if name not in HELD_BACK]
    each = [(folder, name) for name in names]
    rows = run_all(foot_row, each, executor)
    varied = run_all(variant_row, each, executor)
    feet = [load_foot(folder, name) for name in names]
    files = checksums(
        folder, [f"foot_{name}{end}.csv.gz" for name in names for end in ("", "_truth")]
    )
    bins = {
        way: np.sum([error_bins(foot, way) for foot in feet], axis=0).tolist()
        for way in ("frame", "foot")
    }
    summary = {
        **feet_summary(rows),
        "warnings": {
            way: dict(Counter(kind for row in rows for kind in row[way].get("warnings", ())))
            for way in WAYS
        },
        "variants": {what: ways_summary([row[what] for row in varied]) for what in VARIANTS},
        "simulated_as_real": simulated_as_real(executor),
        "sensors": sensors_summary([row["sensor"] for row in rows]),
        "edges": list(EDGES[1:-1]),
        "bins": bins,
        "spectra": spectra([(foot.recording, foot.still) for foot in feet]),
        "over_time": [over_time(folder, name) for name in SHOWN if name in names],
    }
    numbers = {
        "origin": origin_of(DATASET),
        "files": files,
        "rows": [kept(row) for row in rows],
        "summary": summary,
    }
    return {"numbers": numbers, "inputs": files}


def simulated_as_real(executor: Any = None) -> dict[str, Any]:
    """A walking frame around a rectangle with sensors as real recordings show them.

    The record ``walker_walks`` has the same for the other levels, under ``smoothing``.

    Parameters
    ----------
    executor : anything with ``submit``; None computes in this process

    Returns
    -------
    dict: ``smoothed_rms_m`` (mean of the walks' errors) and ``walks``
    """
    levels = {"real": Level(REAL_LEVEL.sensor, REAL_LEVEL.imperfections)}
    walks = walking_study(SIMULATED_SEEDS, RECTANGLE, levels, executor=executor)
    return {"smoothed_rms_m": rounded(walks["rms_m"].mean(), 4), "walks": len(walks)}


def kept(row: dict[str, Any]) -> dict[str, Any]:
    """Part of a row that the record keeps; the rest is in its summary.

    Parameters
    ----------
    row : from :func:`foot_row`
    """
    part = {name: value for name, value in row.items() if name != "sensor"}
    for way in WAYS:
        part[way] = {k: v for k, v in row[way].items() if k not in ("samples", "warnings")}
    return part


def feet_summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians, extremes and pooled coverage.

    Parameters
    ----------
    rows : from :func:`foot_row`

    Returns
    -------
    dict: ``walks``, ``way_m`` of all; ``strapdown_rms_m`` and ``start_rms_m``, medians; for each of
    ``WAYS`` what :func:`ways_summary` gives
    """
    return {
        "walks": len(rows),
        "way_m": rounded(sum(row["way_m"] for row in rows), 0),
        "strapdown_rms_m": rounded(np.median([row["strapdown_rms_m"] for row in rows]), 3),
        "start_rms_m": rounded(np.median([row["start_rms_m"] for row in rows]), 3),
        **{way: ways_summary([row[way] for row in rows]) for way in WAYS},
    }


def ways_summary(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians, extremes and pooled coverage of one way over several walks.

    Parameters
    ----------
    found : from :func:`judged`, or with ``refused``

    Returns
    -------
    dict: ``walks``, ``refused``; ``median_rms_m``, ``p90_rms_m``, ``worst_rms_m``,
    ``median_first_quarter_m``, ``median_end_m``, ``median_height_m``, ``median_sd_m``,
    ``median_ratio``, ``within_factor_two`` (walks whose ratio is between 1/2 and 2) and
    ``covered_percent``, pooled over all samples
    """
    kept = [one for one in found if "refused" not in one]
    sizes = [one["rms_m"] for one in kept]
    counts = [one["samples"] for one in kept]

    def median(name: str) -> float:
        return rounded(np.median([one[name] for one in kept]), 3)

    return {
        "walks": len(kept),
        "refused": len(found) - len(kept),
        "median_rms_m": median("rms_m"),
        "p90_rms_m": rounded(np.percentile(sizes, 90), 3),
        "worst_rms_m": rounded(max(sizes), 3),
        "median_first_quarter_m": median("rms_first_quarter_m"),
        "median_end_m": median("end_m"),
        "median_height_m": median("height_rms_m"),
        "median_sd_m": median("sd_m"),
        "median_ratio": median("ratio"),
        "within_factor_two": sum(0.5 <= one["ratio"] <= 2 for one in kept),
        "covered_percent": rounded(
            np.average([one["covered_percent"] for one in kept], weights=counts), 1
        ),
    }
