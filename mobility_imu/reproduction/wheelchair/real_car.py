"""A car against satellite positions: what the record ``real_car`` holds.

Two drives with a sensor on the body and on both wheels of one axle. Radii and track are fitted on
the first drive against the satellite positions, and so is one shift of the clocks per drive.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import Numbers, checksums
from mobility_imu.reproduction.wheelchair.real_common import (
    INSIDE,
    Against,
    against,
    low_passed,
    offset_numbers,
    ratio_fractions,
    recorded_study,
    rounded,
    spread,
)
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount
from mobility_imu.wheelchair.check import check_geometry
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

DATASET, RECORD = "car-wheels", "real_car"
CUTOFF_HZ = 0.5
"""The reference was low-passed so, forward and backward."""
HELD_BACK = ("trial04", "trial06", "trial09", "trial10")
"""Drives that were not looked at until the settings were fixed; they have a record of their own."""
FITTED_ON = "trial02"
"""Radii and track were fitted on this drive."""
SERIES_STEP_S = 1.0


class Drive(NamedTuple):
    """One drive of the car, calibrated with its own cuts.

    Parameters
    ----------
    name : of the drive
    car : WheelchairGeometry
    calibration : WheelchairCalibration
    recording : Recording
    found : ChairVelocity
    truth : table of the reference
    """

    name: str
    car: WheelchairGeometry
    calibration: WheelchairCalibration
    recording: Recording
    found: ChairVelocity
    truth: pd.DataFrame

    def speed(self, found: ChairVelocity) -> Against:
        """Speed beside the reference.

        Parameters
        ----------
        found : ChairVelocity of this drive
        """
        speed = low_passed(found.linear_velocity_mps, found.sampling_rate_hz, CUTOFF_HZ)
        time_s, true = (self.truth[name].to_numpy(float) for name in ("time_s", "speed_mps"))
        return against(time_s, true, found.time_s, speed, found.linear_velocity_sd_mps)


def load_drive(folder: Path, name: str) -> Drive:
    """Read a drive, calibrate with its cuts, find speed and yaw rate.

    Parameters
    ----------
    folder : of the data set
    name : of the drive

    Returns
    -------
    Drive
    """
    static, straight, recording = (
        read_recording(folder / f"{name}{part}.csv.gz") for part in ("_static", "_straight", "")
    )
    car = WheelchairGeometry.from_toml(folder / f"{name}_geometry.toml")
    cal = calibrate_mount(static, straight)
    found = estimate_velocity(recording, car, cal.mount, offsets=cal.offsets)
    return Drive(name, car, cal, recording, found, pd.read_csv(folder / f"{name}_truth.csv.gz"))


def path_errors(drive: Drive) -> FloatArray:
    """Distance of the integrated path from the satellite positions, m.

    The path is turned and moved so that it fits best: its start and its first heading are not
    known.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    (m,) array, m, one for each position
    """
    found = drive.found
    step = 1 / found.sampling_rate_hz
    heading = np.cumsum(found.yaw_rate_radps) * step
    way = np.cumsum(found.linear_velocity_mps * np.exp(1j * heading)) * step
    time_s, east, north = (
        drive.truth[name].to_numpy(float) for name in ("time_s", "east_m", "north_m")
    )
    place = east + 1j * north
    here = np.isfinite(place)
    place = place[here]
    mine = np.interp(time_s[here], found.time_s, way.real) + 1j * np.interp(
        time_s[here], found.time_s, way.imag
    )
    mine, place = mine - mine.mean(), place - place.mean()
    turn = np.vdot(mine, place)
    return np.asarray(np.abs(mine * turn / abs(turn) - place))


def drive_row(drive: Drive) -> Numbers:
    """Row of the record of one drive.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    dict
    """
    speed = drive.speed(drive.found)
    check = check_geometry(
        drive.recording, drive.car, drive.calibration.mount, offsets=drive.calibration.offsets
    )
    left_on = estimate_velocity(
        drive.recording,
        drive.car,
        drive.calibration.mount,
        VelocitySettings(take_off_offsets=False),
    )
    away = path_errors(drive)
    fastest = max(
        float(np.rad2deg(np.abs(drive.recording.gyroscope(name)).max()))
        for name in ("left_wheel", "right_wheel")
    )
    return {
        "trial": drive.name,
        "geometry_fitted_on_it": drive.name == FITTED_ON,
        "seconds": len(drive.recording) / drive.found.sampling_rate_hz,
        "way_m": float(np.abs(speed.true) @ speed.step_s),
        "fastest_mps": float(np.abs(speed.true).max()),
        "speed": speed.summary(),
        "path_ratio": speed.path_ratio,
        "speed_rms_offsets_left_on_mps": rms(drive.speed(left_on).error),
        "position_rms_m": rms(away),
        "position_largest_m": float(away.max()),
        "offsets": offset_numbers(drive.found.offsets),
        "fastest_wheel_degps": fastest,
        "slip": float(drive.found.slip.mean()),
        "geometry_judged": check.judged,
        "geometry_fits": check.fits,
        "track_m": check.track_m,
        "track_sd_m": check.track_sd_m,
        "turned_deg": float(np.rad2deg(check.turned_rad)),
        "check_says": check.warnings[0] if check.warnings else "",
    }


def real_numbers(folder: Path, names: list[str] | None = None) -> Numbers:
    """Numbers of the record that come from the recordings alone.

    Parameters
    ----------
    folder : of the data set
    names : drives that are looked at; None takes all that were not held back

    Returns
    -------
    dict with ``files``, ``rows``, ``summary``, ``series``
    """
    ending = "_truth.csv.gz"
    here = [p.name.removesuffix(ending) for p in sorted(folder.glob(f"*{ending}"))]
    names = names or [name for name in here if name not in HELD_BACK]
    drives = [load_drive(folder, name) for name in names]
    rows = [drive_row(drive) for drive in drives]
    speeds = [drive.speed(drive.found) for drive in drives]
    ratios = np.concatenate([speed.error / speed.sd for speed in speeds])
    summary = {
        "recordings": len(rows),
        "refused": 0,
        "speed_rms_mps": spread(row["speed"]["rms"] for row in rows),
        "path_ratio": spread(row["path_ratio"] for row in rows),
        "speed_sd_over_rms": spread(row["speed"]["sd_over_rms"] for row in rows),
        "speed_inside": float(np.mean(np.abs(ratios) < INSIDE)),
        "speed_ratio_fractions": ratio_fractions(ratios),
        "position_rms_m": spread(row["position_rms_m"] for row in rows),
    }
    parts = ("", "_static", "_straight", "_truth")
    files = [f"{n}{part}.csv.gz" for n in names for part in parts]
    return {
        "files": checksums(folder, [*files, *(f"{n}_geometry.toml" for n in names)]),
        "rows": rounded(rows),
        "summary": rounded(summary),
        "series": [_series(drive.name, s) for drive, s in zip(drives, speeds, strict=True)],
    }


def _series(name: str, speed: Against) -> Numbers:
    """Speed's error over time, about once a second."""
    step = max(1, round(SERIES_STEP_S / float(np.median(speed.step_s))))
    columns = {
        "time_s": speed.time_s,
        "true_mps": speed.true,
        "error_mps": speed.error,
        "sd_mps": speed.sd,
    }
    return {
        "trial": name,
        **{key: [round(float(v), 4) for v in values[::step]] for key, values in columns.items()},
    }


def study(executor: Any = None) -> Numbers | None:
    """All numbers of the record.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if the data set is not here
    """
    return recorded_study(DATASET, RECORD, real_numbers)
