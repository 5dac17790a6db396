"""A car with a sensor on each wheel, against satellite positions."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.datasets.files import Files, Note, Output, decoded
from mobility_imu.datasets.series import longest_run, low_pass
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.clocks import join_streams
from mobility_imu.readers.streams import Asked
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.xsens_dot import read_xsens_dot
from mobility_imu.recording import Recording
from mobility_imu.results import Result

FILE = re.compile(r"Datasets/(trial(?:02|04|06|08|09|10))/(CAR|IMU2|IMU4|GNSS)\.csv")
PLACES = {"frame": "CAR", "left_wheel": "IMU4", "right_wheel": "IMU2"}
OFFSETS_S = {"right_wheel": 132.71}
"""Clocks of CAR, IMU3 and IMU4 are this far ahead of those of IMU1 and IMU2."""
FITTED_ON = "trial02"
RATE_HZ = 120.0
FIX_STEP_S = 0.01
"""True step of the receiver's rows, whose time column steps by 0.1 s."""
GRID_S = 0.05
CUTOFF_HZ = 0.5
LARGEST_JUMP_MPS2 = 8.0
"""Between fixes no car changes its speed faster; the receiver is at fault there."""
JUMP_MARGIN_S = 1.5
AXIS_M, ECCENTRICITY_SQUARED = 6378137.0, 0.00669438
"""Ellipsoid WGS 84."""
STATIC_SAMPLES, STRAIGHT_SAMPLES, EDGE_SAMPLES = 1200, 1800, 30


@dataclass(frozen=True, eq=False, repr=False)
class Fixes(Result):
    """Positions of the receiver, and what follows from them.

    Parameters
    ----------
    time_s : (n,) array, s, of each new fix on the receiver's clock
    east_m, north_m : (n,) arrays, m, from the first fix
    grid_s : (k,) array, s, even times between the first and the last fix
    speed_mps : (k,) array, m/s, at these times, from the low-passed path
    """

    time_s: FloatArray
    east_m: FloatArray
    north_m: FloatArray
    grid_s: FloatArray
    speed_mps: FloatArray


def wanted(path: str) -> bool:
    """Whether a file is of one of the trials, and of a sensor that is used."""
    return FILE.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """Recording, truth, cuts and geometry of each trial."""
    paths = {(m[1], m[2]): name for name in files.names if (m := FILE.fullmatch(name))}
    trials = sorted({trial for trial, _ in paths})
    if FITTED_ON not in trials:
        raise InputError(f"the origin lacks {FITTED_ON}, on which the geometry is fitted")
    note = _note()
    geometry = ""
    for trial in sorted(trials, key=lambda name: name != FITTED_ON):
        missing = [name for name in (*PLACES.values(), "GNSS") if (trial, name) not in paths]
        if missing:
            raise InputError(f"{trial}: the origin has no {', '.join(missing)}")
        streams = {
            place: read_xsens_dot(
                decoded(files, paths[trial, name], trial), f"{trial}, {place}", Asked()
            )[0]
            for place, name in PLACES.items()
        }
        recording, said = join_streams(streams, RATE_HZ, offsets_s=OFFSETS_S, source=trial)
        note.warnings += said
        out.recording(trial, recording)
        for name, part in _cuts(recording).items():
            out.table(f"{trial}_{name}", recording.to_frame().iloc[part])
            if part.stop <= part.start:
                note.warnings.append(f"{trial}: no part for {name} was found.")
        fixes = parse_fixes(decoded(files, paths[trial, "GNSS"], trial), f"{trial}, GNSS")
        shift_s = clock_shift(fixes, recording)
        truth, dropped = _truth(fixes, shift_s, recording.time_s[-1])
        out.table(f"{trial}_truth", truth, digits=4)
        note.fitted.append(f"{trial}: receiver's clock shifted by {shift_s:+.2f} s.")
        if dropped:
            note.warnings.append(f"{trial}: speed left out at {dropped} fixes, near jumps.")
        if trial == FITTED_ON:
            geometry = _geometry(truth, recording)
        out.text(f"{trial}_geometry.toml", geometry)
    return note


def _note() -> Note:
    return Note(
        done=[
            f"The three sensors were put on one even clock of {RATE_HZ:g} Hz by their own stamps; "
            "rows of zeros at the beginning and damaged rows were left out; deg/s to rad/s.",
            "Truth at the receiver's fixes: east_m and north_m from the first fix, not filtered; "
            f"speed_mps from the path low-passed at {CUTOFF_HZ:g} Hz, forward and backward (do the "
            f"same to what you compare). Within {JUMP_MARGIN_S:g} s of a jump of more than "
            f"{LARGEST_JUMP_MPS2:g} m/s2 between fixes the speed is empty. In the first and last "
            "second the low-pass knows less.",
            "The receiver's time column steps by 0.1 s; its true step is 0.01 s.",
            "_static and _straight were cut from each trial: the longest rest and the longest way "
            "without turning.",
        ],
        fitted=[
            f"Radii and track were fitted on {FITTED_ON} to the positions and are used for all "
            "trials: the scale of the speed is not tested there. The track is weakly seen.",
            f"The right wheel's clock was shifted by {OFFSETS_S['right_wheel']:g} s, from the "
            "wheels' rates.",
        ],
        assumed=["Camber 0. frame = CAR, left wheel = IMU4, right wheel = IMU2, axle = z."],
        left_out=["The origin's other trials, which were not at hand, and the other axle."],
    )


def parse_fixes(text: str, source: str) -> Fixes:
    """Positions in m from the first one, and the speed from their low-passed path.

    Parameters
    ----------
    text : content of ``GNSS.csv``: ``Lat_GNSS`` and ``Long_GNSS``, deg, which repeat until the
        next fix
    source : the file's name, for messages

    Returns
    -------
    Fixes
    """
    table = parse_numbers(text, separator=",", source=source)
    latitude, longitude = table.columns(["Lat_GNSS", "Long_GNSS"]).T
    new = np.flatnonzero(np.r_[True, (np.diff(latitude) != 0) | (np.diff(longitude) != 0)])
    if len(new) < 3 or not np.isfinite(latitude + longitude).all():
        raise InputError(f"{source}: expected three positions or more, all of them numbers")
    first = np.deg2rad(latitude[0])
    w = 1 - ECCENTRICITY_SQUARED * np.sin(first) ** 2
    east_m = np.deg2rad(longitude - longitude[0])[new] * AXIS_M / np.sqrt(w) * np.cos(first)
    north_m = np.deg2rad(latitude - latitude[0])[new] * AXIS_M * (1 - ECCENTRICITY_SQUARED) / w**1.5
    time_s = np.asarray(new * FIX_STEP_S, float)
    grid_s = np.arange(time_s[0], time_s[-1], GRID_S)
    east, north = (
        low_pass(np.interp(grid_s, time_s, values), CUTOFF_HZ, 1 / GRID_S)
        for values in (east_m, north_m)
    )
    speed_mps = np.asarray(np.hypot(np.gradient(east, grid_s), np.gradient(north, grid_s)), float)
    return Fixes(time_s, east_m, np.asarray(north_m, float), grid_s, speed_mps)


def clock_shift(fixes: Fixes, recording: Recording) -> float:
    """Seconds to add to the receiver's clock: there its speed is most nearly the wheels' rate.

    The factor between the two is free, so that no radius is needed.

    Parameters
    ----------
    fixes : of the receiver
    recording : with both wheels

    Returns
    -------
    float, s, to 0.01 s
    """
    end = recording.time_s[-1]
    grid = np.arange(0, end, GRID_S)
    left, right = (
        np.interp(grid, recording.time_s, low_pass(rate, CUTOFF_HZ, RATE_HZ))
        for rate in _wheel_rates(recording)
    )
    rate = (left + right) / 2
    fewest = 0.6 * min(len(fixes.grid_s), len(grid))

    def misfit(shift_s: float) -> float:
        there = np.interp(fixes.grid_s + shift_s, grid, rate, left=np.nan, right=np.nan)
        both = np.isfinite(there)
        if both.sum() <= fewest:
            return 9.0
        speed, there = fixes.speed_mps[both], there[both]
        return float(np.std(speed - there @ speed / (there @ there) * there))

    coarse = min(np.arange(-fixes.grid_s[-1] / 2, grid[-1] / 2, 0.25), key=misfit)
    return float(min(np.arange(coarse - 0.3, coarse + 0.3, 0.01), key=misfit))


def _wheel_rates(recording: Recording) -> tuple[FloatArray, FloatArray]:
    left, right = (
        np.abs(recording.gyroscope(wheel)[:, 2]) for wheel in ("left_wheel", "right_wheel")
    )
    return left, right


def _cuts(recording: Recording) -> dict[str, slice]:
    """Longest rest, and longest way without turning."""
    rate, _ = _wheel_rates(recording)
    yaw = np.abs(_rolling(recording.gyroscope("frame")[:, 2], "mean"))
    parts = {
        "static": (longest_run(_rolling(rate < 0.05, "min") > 0), STATIC_SAMPLES),
        "straight": (longest_run((yaw < np.deg2rad(1)) & (rate > 5)), STRAIGHT_SAMPLES),
    }
    return {
        name: slice(
            run.start + EDGE_SAMPLES,
            min(run.start + EDGE_SAMPLES + most, run.stop - EDGE_SAMPLES),
        )
        for name, (run, most) in parts.items()
    }


def _rolling(values: ArrayLike, what: str) -> FloatArray:
    """Mean or least value of a centred window of half a second."""
    import pandas as pd

    window = pd.Series(np.asarray(values, float)).rolling(60, center=True, min_periods=1)
    return np.asarray(getattr(window, what)(), float)


def _truth(fixes: Fixes, shift_s: float, end_s: float) -> tuple[dict[str, FloatArray], int]:
    """Table of the truth on the recording's clock, and at how many fixes the speed is left out."""
    step = np.diff(fixes.time_s)
    speed_between = np.hypot(np.diff(fixes.east_m), np.diff(fixes.north_m)) / step
    jumps = np.r_[0, np.abs(np.diff(speed_between)) / step[1:], 0] > LARGEST_JUMP_MPS2
    speed = np.interp(fixes.time_s, fixes.grid_s, fixes.speed_mps)
    speed[_near(fixes.time_s, fixes.time_s[jumps])] = np.nan
    time_s = fixes.time_s + shift_s
    here = (time_s > 0) & (time_s < end_s)
    columns = {
        "time_s": time_s,
        "speed_mps": speed,
        "east_m": fixes.east_m,
        "north_m": fixes.north_m,
    }
    truth = {name: values[here] for name, values in columns.items()}
    return truth, int(np.isnan(truth["speed_mps"]).sum())


def _near(time_s: FloatArray, jumps_s: FloatArray) -> NDArray[np.bool_]:
    if not len(jumps_s):
        return np.zeros(len(time_s), np.bool_)
    return np.asarray(np.abs(time_s[:, None] - jumps_s).min(axis=1) < JUMP_MARGIN_S)


def _geometry(truth: dict[str, FloatArray], recording: Recording) -> str:
    """Radii and track from speed = radius · rate ± yaw rate · track / 2, least squares."""
    seen = np.isfinite(truth["speed_mps"])
    speed = truth["speed_mps"][seen]
    left, right, yaw = (
        np.interp(truth["time_s"][seen], recording.time_s, low_pass(rate, CUTOFF_HZ, RATE_HZ))
        for rate in (*_wheel_rates(recording), recording.gyroscope("frame")[:, 2])
    )
    design = np.r_[np.c_[left, 0 * left, yaw], np.c_[0 * right, right, -yaw]]
    radius_left, radius_right, half_track = np.linalg.lstsq(design, np.r_[speed, speed])[0]
    return (
        f"[wheelchair]\ncamber_deg = 0.0\nwheel_radius_left_m = {radius_left:.4f}\n"
        f"wheel_radius_right_m = {radius_right:.4f}\ntrack_m = {2 * half_track:.3f}\n"
    )
