"""Sizes of what goes wrong in real sensors, measured on the recordings of other people.

    python benchmarks/measure_real_sensors.py          (MOBILITY_IMU_RECORDINGS names their folder)

Writes data/reference/real_sensors.csv: one row per size, with the file that it was measured on and
its checksum. No truth of a recording is used. The simulations' level "real" has these sizes.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import signal

from mobility_imu.quality import resolution_of

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "data" / "reference" / "real_sensors.csv"
BANDS_HZ = ((5.0, 10.0), (10.0, 20.0), (20.0, 45.0))
"""Bands of vibration; below 5 Hz pushes and steps are motion."""
RESTING = ("drives/*.csv.gz", "truth/chair_mocap/*_static.csv.gz", "walks/walk_*.csv.gz")
DRIVES, HINGES = "drives/*.csv.gz", "truth/one_hinge/pitch_*[mw].csv.gz"
STREAMS = (
    "mobility_aids/wheelchair_left_wheel_module_asphalt.csv",
    "mobility_aids/wheelchair_frame_module_asphalt_100hz.csv",
    "xio/ximu3_left_foot_udp/Inertial.csv",
)


def triads(path: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray, float]]:
    """Name, accelerations, rates and sampling rate of each sensor of a recording."""
    table = pd.read_csv(path)
    rate = 1 / float(np.median(np.diff(table["time_s"])))
    for column in table.columns:
        if column.endswith("_acc_x_mps2"):
            name = column[: -len("_acc_x_mps2")]
            acc, gyr = (
                table[[f"{name}_{kind}_{axis}_{unit}" for axis in "xyz"]].to_numpy()
                for kind, unit in (("acc", "mps2"), ("gyr", "radps"))
            )
            yield name, acc, gyr, rate


def at_rest(acc: np.ndarray, gyr: np.ndarray, rate: float) -> slice:
    """The quietest second."""
    count = round(rate)
    begins = range(0, len(acc) - count, count // 2)
    spread = [
        acc[k : k + count].std(0).sum() / 10 + gyr[k : k + count].std(0).sum() for k in begins
    ]
    begin = begins[int(np.argmin(spread))]
    return slice(begin, begin + count)


def resting_rows(path: Path) -> Iterator[tuple[str, str, float, str]]:
    """Offsets of the gyroscope, length of gravity and noise in the quietest second."""
    for name, acc, gyr, rate in triads(path):
        rest = at_rest(acc, gyr, rate)
        off = np.rad2deg(gyr[rest].mean(axis=0))
        yield name, "gyroscope offset, root mean square of the axes", rms(off), "deg/s"
        yield name, "length of the acceleration", rms(acc[rest].mean(axis=0)) * 3**0.5, "m/s2"
        noise = np.diff(acc[rest], axis=0).std(axis=0) / 2**0.5
        yield name, "accelerometer noise per sample", rms(noise), "m/s2"
        noise = np.diff(np.rad2deg(gyr[rest]), axis=0).std(axis=0) / 2**0.5
        yield name, "gyroscope noise per sample", rms(noise), "deg/s"


def step_rows(path: Path) -> Iterator[tuple[str, str, float, str]]:
    """Steps of both quantities of a sensor at rest: the base of the hinge."""
    for name, acc, gyr, _ in triads(path):
        if name == "body":
            for kind, values, unit in (("acc", acc, "m/s2"), ("gyr", np.rad2deg(gyr), "deg/s")):
                levels = np.unique(values[:, 0].round(5))
                step = float(np.median(np.diff(levels))) if len(levels) > 1 else 0.0
                assert resolution_of(values).pairs
                yield name, f"step of {kind}", step, unit


def vibration_rows(path: Path) -> Iterator[tuple[str, str, float, str]]:
    """Vibration in bands while the wheels turn by 1 rad/s and more, each axis, without the rest."""
    sensors = {name: (acc, gyr, rate) for name, acc, gyr, rate in triads(path)}
    spin = np.linalg.norm(sensors["left_wheel"][1], axis=1)
    for name in ("frame", "left_wheel"):
        acc, gyr, rate = sensors[name]
        rest = at_rest(acc, gyr, rate)
        for low, high in BANDS_HZ:
            band = signal.butter(4, [low, min(high, 0.45 * rate)], "band", fs=rate, output="sos")
            shaken = signal.sosfiltfilt(band, acc, axis=0)
            size = np.sqrt(max(rms(shaken[spin > 1]) ** 2 - rms(shaken[rest]) ** 2, 0.0))
            yield name, f"vibration {low:g} to {high:g} Hz", float(size), "m/s2"


def clock_rows(path: Path) -> Iterator[tuple[str, str, float, str]]:
    """Scatter of the steps between stamps, doubled samples and lost ones."""
    table = pd.read_csv(path)
    stamps = next(column for column in table.columns if "time" in column.lower())
    unit = 1e-6 if "(us)" in stamps else 1.0  # "in ms" is in s there
    clock = table[stamps].to_numpy(float) * unit
    step = np.diff(clock)
    usual = float(np.median(step[step > 0]))
    same = (table.filter(regex="(?i)acc|gyr").diff().iloc[1:] == 0).all(axis=1)
    near = np.abs(step / usual - 1) < 0.5
    yield "stream", "scatter of the stamps", float(np.std(step[near]) / 2**0.5 * 1e3), "ms"
    yield "stream", "doubled samples", 100 * float(np.mean(same)), "%"
    lost = np.maximum(np.round(step / usual) - 1, 0).sum()
    yield "stream", "lost samples", 100 * float(lost / (lost + len(clock))), "%"


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def measured(root: Path) -> pd.DataFrame:
    """All sizes as a table."""
    work = [(pattern, resting_rows) for pattern in RESTING]
    work += [(HINGES, step_rows), (DRIVES, vibration_rows)]
    work += [(name, clock_rows) for name in STREAMS]
    rows = []
    for pattern, look in work:
        for path in sorted(root.glob(pattern)):
            checksum = hashlib.sha256(path.read_bytes()).hexdigest()
            for sensor, quantity, value, unit in look(path):
                name = path.relative_to(root).as_posix()
                rows.append((quantity, float(f"{value:.3g}"), unit, sensor, name, checksum))
    return pd.DataFrame(rows, columns=["quantity", "value", "unit", "sensor", "file", "sha256"])


if __name__ == "__main__":
    found = measured(Path(os.environ["MOBILITY_IMU_RECORDINGS"]))
    found.to_csv(TABLE, index=False)
    summary = found.groupby(["quantity", "unit", "sensor"])["value"]
    summary.describe()[["count", "min", "50%", "max"]].to_csv(sys.stdout)
