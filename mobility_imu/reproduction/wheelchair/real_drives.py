"""A chair on several grounds: what the record ``real_drives`` holds.

Six drives with a module on the frame and on both wheels, each module with a clock of its own. There
is no reference: the frame's gyroscope judges the wheels, and a count by hand judges the code.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from mobility_imu.errors import InputError
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import Numbers, checksums
from mobility_imu.reproduction.wheelchair.real_common import (
    INSIDE,
    offset_numbers,
    recorded_study,
    rounded,
    spectrum,
    spread,
)
from mobility_imu.results import Result
from mobility_imu.simulation.sensor import MTI_1, REAL, SensorModel
from mobility_imu.simulation.wheelchair import Leg, random_mounting, simulate_court
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount
from mobility_imu.wheelchair.check import SLOWEST_TURN_RADPS, GeometryCheck, check_geometry
from mobility_imu.wheelchair.codes import Task
from mobility_imu.wheelchair.geometry import SIDES, WheelchairGeometry
from mobility_imu.wheelchair.outcomes import detect_pushes
from mobility_imu.wheelchair.saturation import saturated_gyroscopes, usable_samples
from mobility_imu.wheelchair.slip import detect_slip
from mobility_imu.wheelchair.tasks import identify_tasks
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

DATASET, RECORD = "terrain-chair", "real_drives"
BY_HAND = MappingProxyType(
    {
        # distance m, turn deg, track m
        "asphalt_straight": (23.32, 80.0, None),
        "asphalt_donut": (26.83, 1130.0, 0.526),
        "grass_straight": (18.76, -110.0, None),
        "grass_donut": (15.04, 984.0, 0.525),
        "gravel_straight": (9.98, 189.0, None),
        "sidewalk_donut": (21.32, 1074.0, 0.527),
    }
)
"""By independent code, offsets taken off by hand, same radius; it did not see the saturation."""
STATIC_S = 4.0
"""Every drive begins with a longer rest; this much of it is its static trial."""
MOVING_MPS = 0.2
FAST_MPS = 0.5
"""Spectra are compared while the chair rolls faster than this."""
LARGEST_SHIFT_S = 0.2
"""Clocks are tried that differ from the frame's by up to this."""
SHOWN_S = MappingProxyType({"asphalt_straight": (3.0, 30.0), "grass_straight": (5.0, 15.0)})
"""Parts of drives of which the record keeps a series: the ones that went wrong."""
SIMULATED_SEEDS = range(10)
OFFSET_SD_DEGPS = 2.0
"""Of the simulated gyroscopes: about that of these modules."""


@dataclass(frozen=True, eq=False, repr=False)
class Ridden(Result):
    """One drive with its result.

    Parameters
    ----------
    name : ground and kind
    recording : Recording
    chair : WheelchairGeometry
    calibration : from the drive's first rest and a straight drive
    found : ChairVelocity
    check : GeometryCheck
    """

    name: str
    recording: Recording
    chair: WheelchairGeometry
    calibration: WheelchairCalibration
    found: ChairVelocity
    check: GeometryCheck


def straight_for(name: str) -> str:
    """Straight drive on the same ground, which calibrates; asphalt stands for the sidewalk.

    Parameters
    ----------
    name : of a drive

    Returns
    -------
    str
    """
    return f"{name.split('_')[0].replace('sidewalk', 'asphalt')}_straight"


def load_ridden(folder: Path, name: str, straight: str | None = None) -> Ridden:
    """Read a drive, calibrate, find its velocities, check the geometry.

    Parameters
    ----------
    folder : of the data set
    name : of the drive
    straight : drive that calibrates; None takes the one on the same ground

    Returns
    -------
    Ridden
    """
    recording = read_recording(folder / f"{name}.csv.gz")
    line = read_recording(folder / f"{straight or straight_for(name)}.csv.gz")
    chair = WheelchairGeometry.from_toml(folder / "geometry.toml")
    start = recording.time_s[0]
    cal = calibrate_mount(recording.trim(start, start + STATIC_S), line)
    found = estimate_velocity(recording, chair, cal.mount, offsets=cal.offsets)
    check = check_geometry(recording, chair, cal.mount, offsets=cal.offsets)
    return Ridden(name, recording, chair, cal, found, check)


def clock_shifts(ridden: Ridden) -> Numbers:
    """Shift of each wheel's clock that makes the wheels agree with the frame best.

    One constant for a drive. It is fitted to what it is judged by: a small gain says nothing, a
    large one says that the clocks differ.

    Parameters
    ----------
    ridden : Ridden

    Returns
    -------
    dict with ``left_ms``, ``right_ms`` (positive: the wheel's readings come late), and
    ``residual_degps`` and ``slip`` as recorded (``before``) and with the shifts (``after``)
    """
    found, chair = ridden.found, ridden.chair
    time_s, yaw = found.time_s, found.yaw_rate_radps
    usable = _usable(ridden)
    half = chair.track_m / 2
    speeds = [
        found.linear_velocity_mps + sign * half * found.wheel_yaw_rate_radps for sign in (-1, 1)
    ]
    inside = usable.copy()
    edge = round(LARGEST_SHIFT_S * found.sampling_rate_hz)
    inside[:edge] = inside[-edge:] = False

    def turned(shifts: FloatArray) -> FloatArray:
        left, right = (
            np.interp(time_s + shift, time_s, speed)
            for shift, speed in zip(shifts, speeds, strict=True)
        )
        return np.asarray((right - left) / chair.track_m)

    def cost(shifts: FloatArray) -> float:
        if np.abs(shifts).max() > LARGEST_SHIFT_S:
            return float("inf")
        return float(np.mean(np.square((turned(shifts) - yaw)[inside])))

    starts = [np.array([a, b]) for a in (-0.1, 0.0, 0.1) for b in (-0.1, 0.0, 0.1)]
    fine = {"xatol": 1e-6, "fatol": 1e-12}
    tried = [optimize.minimize(cost, s, method="Nelder-Mead", options=fine) for s in starts]
    best = min(tried, key=lambda one: float(one.fun)).x
    rate = found.sampling_rate_hz
    numbers: Numbers = {"left_ms": 1000 * best[0], "right_ms": 1000 * best[1]}
    for when, shifts in (("before", np.zeros(2)), ("after", best)):
        wheels = turned(shifts)
        windows = detect_slip(yaw, np.where(usable, wheels, yaw), rate)
        numbers[f"residual_{when}_degps"] = float(np.rad2deg(rms((wheels - yaw)[inside])))
        numbers[f"slip_{when}"] = float(windows.flags(len(yaw)).mean())
    return numbers


def _usable(ridden: Ridden) -> NDArray[np.bool_]:
    recording = ridden.recording
    return usable_samples(len(recording), saturated_gyroscopes(recording, recording.sensors))


def drive_row(folder: Path, ridden: Ridden) -> Numbers:
    """Row of the record of one drive.

    Parameters
    ----------
    folder : of the data set
    ridden : Ridden

    Returns
    -------
    dict
    """
    recording, found, check = ridden.recording, ridden.found, ridden.check
    rate = found.sampling_rate_hz
    apart = found.wheel_yaw_rate_radps - found.yaw_rate_radps
    saturated = saturated_gyroscopes(recording, recording.sensors)
    left_on = estimate_velocity(
        recording, ridden.chair, ridden.calibration.mount, VelocitySettings(take_off_offsets=False)
    )
    hand = BY_HAND.get(ridden.name, (None, None, None))
    fastest = {
        name: float(np.rad2deg(np.abs(recording.gyroscope(name)).max()))
        for name in recording.sensors
    }
    wrong_slip = detect_slip(found.yaw_rate_radps, found.wheel_yaw_rate_radps, rate)
    return {
        "drive": ridden.name,
        "calibrated_by": straight_for(ridden.name),
        "seconds": len(recording) / rate,
        "offsets": offset_numbers(found.offsets),
        "distance_m": float(found.linear_velocity_mps.sum() / rate),
        "distance_by_hand_m": hand[0],
        "turn_deg": _turned(found.yaw_rate_radps, rate),
        "turn_by_hand_deg": hand[1],
        "wheels_turn_deg": _turned(found.wheel_yaw_rate_radps, rate),
        "offsets_left_on": {
            "distance_m": float(left_on.linear_velocity_mps.sum() / rate),
            "turn_deg": _turned(left_on.yaw_rate_radps, rate),
            "wheels_turn_deg": _turned(left_on.wheel_yaw_rate_radps, rate),
        },
        "saturated_s": {name: float(flags.sum() / rate) for name, flags in saturated.items()},
        "fastest_degps": fastest,
        "speed_sd_median_mps": float(np.median(found.linear_velocity_sd_mps)),
        "speed_unknown": float(np.isinf(found.linear_velocity_sd_mps).mean()),
        "judged": check.judged,
        "fits": check.fits,
        "track_m": check.track_m,
        "track_sd_m": check.track_sd_m,
        "track_by_hand_m": hand[2],
        "correlation": check.correlation,
        "gain": check.gain,
        "residual_degps": float(np.rad2deg(rms(apart[_usable(ridden)]))),
        "slip": float(found.slip.mean()),
        "slip_with_saturated": float(wrong_slip.flags(len(found)).mean()),
        "clocks": clock_shifts(ridden),
        "tasks": _task_fractions(found),
        "turning_degps": _usual_turn(found),
        "pushes": len(detect_pushes(found.time_s, found.linear_velocity_mps).onset_s),
        "tracks_by_calibration": _tracks(folder, ridden.name) if check.judged else {},
    }


def _turned(rate_radps: FloatArray, rate_hz: float) -> float:
    return float(np.rad2deg(rate_radps.sum() / rate_hz))


def _task_fractions(found: ChairVelocity) -> Numbers:
    """Fraction of the moving time that each task takes."""
    codes = identify_tasks(found).codes
    moving = codes[codes != Task.STATIC]
    return {task.title: float(np.mean(moving == task)) for task in Task if task != Task.STATIC}


def _usual_turn(found: ChairVelocity) -> float:
    """Median yaw rate while the chair turns faster than 0.3 rad/s, deg/s."""
    size = np.abs(found.yaw_rate_radps)
    return float(np.rad2deg(np.median(size[size > SLOWEST_TURN_RADPS])))


def _tracks(folder: Path, name: str) -> Numbers:
    """Track and its standard deviation by the straight drive that calibrated."""
    found = {}
    for line in sorted(p.name.removesuffix(".csv.gz") for p in folder.glob("*_straight.csv.gz")):
        if line not in BY_HAND:
            continue
        check = load_ridden(folder, name, line).check
        found[line] = {"track_m": check.track_m, "track_sd_m": check.track_sd_m}
    return found


def calibration_rows(folder: Path, names: list[str]) -> list[Numbers]:
    """What each straight drive gives as calibration, offsets taken off and left on.

    Parameters
    ----------
    folder : of the data set
    names : drives that are here

    Returns
    -------
    list of dict
    """
    rows = []
    for name in (n for n in names if n.endswith("straight")):
        recording = read_recording(folder / f"{name}.csv.gz")
        static = recording.trim(recording.time_s[0], recording.time_s[0] + STATIC_S)
        row: Numbers = {"drive": name}
        for key, taken_off in (("offsets_off", True), ("offsets_on", False)):
            try:
                cal = calibrate_mount(static, recording, take_off_offsets=taken_off)
            except InputError as error:
                row[key] = {"refused": str(error).split(": ", 1)[-1]}
            else:
                row[key] = {f"off_axle_{s}": cal.off_axle_share.of(s) for s in SIDES}
        rows.append(row)
    return rows


def ground_spectra(drives: list[Ridden]) -> Numbers:
    """Spectra of the frame's vertical acceleration on each ground, and at rest.

    Parameters
    ----------
    drives : Ridden

    Returns
    -------
    dict from drive, and ``rest``, to ``hz`` and ``density`` (m/s² per root hertz); the drives have
    the mean ``speed_mps`` beside
    """
    found: Numbers = {}
    for one in drives:
        rate = one.found.sampling_rate_hz
        up = one.calibration.mount.frame(one.recording.sensor("frame").acc_mps2)[:, 2]
        fast = np.abs(one.found.linear_velocity_mps) > FAST_MPS
        found[one.name] = spectrum(up, rate, fast)
        found[one.name]["speed_mps"] = float(np.abs(one.found.linear_velocity_mps[fast]).mean())
        if "rest" not in found:
            found["rest"] = spectrum(up[: round(STATIC_S * rate)], rate)
    return found


def yaw_series(ridden: Ridden, start_s: float, stop_s: float) -> Numbers:
    """Speeds and yaw rates of a part of a drive, ten times a second.

    Parameters
    ----------
    ridden : Ridden
    start_s, stop_s : s

    Returns
    -------
    dict of lists: ``time_s``, ``speed_mps``, ``frame_degps``, ``wheels_degps``, ``usable``
    """
    found, step = ridden.found, round(0.1 * ridden.found.sampling_rate_hz)
    columns = {
        "time_s": found.time_s,
        "speed_mps": found.linear_velocity_mps,
        "frame_degps": np.rad2deg(found.yaw_rate_radps),
        "wheels_degps": np.rad2deg(found.wheel_yaw_rate_radps),
        "usable": _usable(ridden).astype(float),
    }
    part = (found.time_s >= start_s) & (found.time_s <= stop_s)
    return {
        key: [round(float(v), 3) for v in values[part][::step]] for key, values in columns.items()
    }


def cheap_module() -> SensorModel:
    """Simulated sensor with the data sheet's errors and offsets like those of the real modules.

    Returns
    -------
    SensorModel
    """
    gyr = replace(MTI_1.gyr, turn_on_bias_sd=float(np.deg2rad(OFFSET_SD_DEGPS)))
    return replace(MTI_1, gyr=gyr)


def simulated(model: SensorModel) -> Numbers:
    """Simulated drives of the same kinds, judged alike: exact geometry, flat ground, no slip.

    Parameters
    ----------
    model : of the three sensors

    Returns
    -------
    dict with ``track_error_m``, ``track_sd_m``, ``correlation``, residual and slip of both kinds
    of drive, and ``track_inside``, the drives whose stated 95 % interval holds the true track
    """
    chair = WheelchairGeometry.from_degrees(
        0, wheel_radius_left_m=0.305, wheel_radius_right_m=0.305, track_m=0.527
    )
    straight = (Leg(1, 6.0), Leg(2, 20.0, 1.0), Leg(1, 4.0))
    donut = (
        Leg(1, 6.0),
        Leg(2, 4.0, 0.6),
        Leg(6, 30.0, 0.7, 35.0),
        Leg(2, 4.0, 0.6),
        Leg(1, 2.0),
    )
    rows: dict[str, list[float]] = {}
    for seed in SIMULATED_SEEDS:
        line, turn = (
            simulate_court(
                legs,
                chair,
                random_mounting(seed),
                seed=2 * seed + k,
                unit_seed=seed,
                model=model,
            ).recording
            for k, legs in enumerate((straight, donut))
        )
        cal = calibrate_mount(line.trim(0.0, STATIC_S), line)
        check = check_geometry(turn, chair, cal.mount, offsets=cal.offsets)
        found = [estimate_velocity(r, chair, cal.mount, offsets=cal.offsets) for r in (line, turn)]
        row = {
            "track_error_m": abs(check.track_m - chair.track_m),
            "track_sd_m": check.track_sd_m,
            "correlation": check.correlation,
        }
        for kind, drive in zip(("straight", "donut"), found, strict=True):
            apart = drive.wheel_yaw_rate_radps - drive.yaw_rate_radps
            row[f"residual_{kind}_degps"] = float(np.rad2deg(rms(apart)))
            row[f"slip_{kind}"] = float(drive.slip.mean())
        for key, value in row.items():
            rows.setdefault(key, []).append(value)
    off, sd = np.array(rows["track_error_m"]), np.array(rows["track_sd_m"])
    return {
        "drives": len(SIMULATED_SEEDS),
        "track_inside": int(np.count_nonzero(off < INSIDE * sd)),
        **{key: spread(v) for key, v in rows.items()},
    }


def summary_of(rows: list[Numbers]) -> Numbers:
    """Numbers over all drives.

    Parameters
    ----------
    rows : of the drives

    Returns
    -------
    dict
    """
    judged = [row for row in rows if row["judged"]]
    return {
        "recordings": len(rows),
        "refused": 0,
        "judged": len(judged),
        "distance_over_by_hand": spread(
            row["distance_m"] / row["distance_by_hand_m"] for row in rows
        ),
        "turn_less_by_hand_deg": spread(row["turn_deg"] - row["turn_by_hand_deg"] for row in rows),
        "track_m": spread(row["track_m"] for row in judged),
        "track_inside": sum(
            abs(row["track_m"] - row["track_by_hand_m"]) < INSIDE * row["track_sd_m"]
            for row in judged
        ),
        "saturated_drives": sum(bool(row["saturated_s"]) for row in rows),
        "largest_offset_degps": max(
            abs(axis)
            for row in rows
            for sensor in row["offsets"].values()
            for axis in sensor["offset_degps"]
        ),
    }


def real_numbers(folder: Path, names: list[str] | None = None) -> Numbers:
    """Numbers of the record that come from the recordings alone.

    Parameters
    ----------
    folder : of the data set
    names : drives that are looked at; None takes those that were counted by hand

    Returns
    -------
    dict with ``files``, ``rows``, ``summary``, ``calibrations``, ``spectra``, ``series``
    """
    names = names or [name for name in BY_HAND if (folder / f"{name}.csv.gz").is_file()]
    drives = [load_ridden(folder, name) for name in names]
    rows = [drive_row(folder, one) for one in drives]
    by_name = {one.name: one for one in drives}
    return {
        "files": checksums(folder, [*(f"{n}.csv.gz" for n in names), "geometry.toml"]),
        "rows": rounded(rows),
        "summary": rounded(summary_of(rows)),
        "calibrations": rounded(calibration_rows(folder, names)),
        "spectra": rounded(ground_spectra(drives)),
        "series": {
            name: yaw_series(by_name[name], *part)
            for name, part in SHOWN_S.items()
            if name in by_name
        },
    }


def study(executor: Any = None) -> Numbers | None:
    """All numbers of the record, those of the simulation beside them.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if the data set is not here
    """
    return recorded_study(
        DATASET,
        RECORD,
        real_numbers,
        {
            "simulated": lambda: simulated(cheap_module()),
            "simulated_as_real": lambda: simulated(REAL),
        },
    )
