"""One hinge on a motor, beside it a fixed base: two coarse sensors and an encoder."""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.datasets.files import Files, Note, Output
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.readers.matlab import parse_matlab
from mobility_imu.recording import Imu, Recording
from mobility_imu.rotations import elementary_rotation

FILE = re.compile(
    r"MatlabCode/Data/raw_(pitch_slow|pitch_medium|roll_slow|roll_medium|roll_fast)\.mat"
)
AXES = {
    "pitch": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]]),
    "roll": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0.0]]),
}
"""Turn of the sensors' axes into the scooter's, for each axis that lay along the shaft."""
SAMPLES = 30_000
"""The first five minutes of each run."""
AT_ZERO_DEG = 1.5
SENSORS = {"lever": 2, "body": 1}
"""The origin's number of each sensor."""


def wanted(path: str) -> bool:
    """Whether a file is one of the runs about a horizontal axis that are converted."""
    return FILE.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """Recording, truth and geometry of each run."""
    runs = {m[1]: name for name in files.names if (m := FILE.fullmatch(name))}
    if not runs:
        raise InputError("the origin has none of the runs")
    for run, path in runs.items():
        _convert_run(run, files.read(path), out)
    return Note(
        done=[
            "Axes exchanged only (pitch: x, y, z = y, z, x of the sensor; roll: x, -z, y), so the "
            "steps of 0.01 g and 0.06 deg/s are as they came. g and deg/s were turned into SI.",
            "Stamps come in doubles: the time is the row's number at the mean rate of the run.",
            "The encoder leads by one row, which is corrected in the truth. throttle_rad is minus "
            "the encoder's angle; steering_rad is 0, since there is no second hinge.",
            "The first five of about 25 minutes of each run.",
        ],
        fitted=[
            "rotation_lever_imu_to_lever brings the lever's zero onto the encoder's: a constant of "
            "the angle is not tested.",
        ],
        assumed=["Inclinations 20 and 0 deg; the base is level (turned about x by its gravity)."],
        left_out=["pitch_fast, which was not at hand, and the runs about the vertical (yaw)."],
    )


def _convert_run(run: str, content: bytes, out: Output) -> None:
    names = [f"all_{q}_{k}_{axis}" for q in ("accel", "gyro") for k in (1, 2) for axis in "xyz"]
    found = parse_matlab(content, [*names, "all_time", "all_encoder"], run)
    lengths = {values.shape for values in found.values()}
    if len(lengths) != 1 or found["all_time"].ndim != 1 or len(found["all_time"]) < 2:
        raise InputError(f"{run}: its variables are no series of one length")
    stamps = found["all_time"]
    count = min(SAMPLES, len(stamps))
    time_s = np.arange(count) * (stamps[-1] - stamps[0]) / (len(stamps) - 1)
    turn = AXES[run.split("_")[0]]

    def series(quantity: str, number: int) -> FloatArray:
        values = np.column_stack([found[f"all_{quantity}_{number}_{axis}"] for axis in "xyz"])
        return np.asarray(values[:count] @ turn.T)

    acc_g = {sensor: series("accel", number) for sensor, number in SENSORS.items()}
    sensors = {
        sensor: Imu(acc_g[sensor] * STANDARD_GRAVITY_MPS2, np.deg2rad(series("gyro", number)))
        for sensor, number in SENSORS.items()
    }
    out.recording(run, Recording(time_s, sensors, source=run))
    encoder_deg = np.r_[np.nan, found["all_encoder"][: count - 1]]
    truth = {
        "time_s": time_s,
        "steering_rad": 0.0 * encoder_deg,
        "throttle_rad": -np.deg2rad(encoder_deg),
    }
    out.table(f"{run}_truth", truth)
    at_zero = np.abs(encoder_deg) < AT_ZERO_DEG
    if not at_zero.any():
        raise InputError(f"{run}: the encoder never is at zero")
    out.text(f"{run}_geometry.toml", _geometry(acc_g["lever"][at_zero], acc_g["body"]))


def _geometry(lever_at_zero: FloatArray, body: FloatArray) -> str:
    """Geometry whose mount levels both sensors by a turn about x."""
    rows = []
    for sensor, acc in (("lever", lever_at_zero), ("body", body)):
        _, y, z = acc.mean(axis=0)
        matrix = (elementary_rotation("x", np.arctan2(y, z)).round(6) + 0.0).tolist()
        rows.append(f"rotation_{sensor}_imu_to_{sensor} = {matrix}\n")
    return (
        "[scooter]\nsteering_inclination_deg = 20.0\nlever_inclination_deg = 0.0\n\n"
        f"[scooter.mount]\n{''.join(rows)}"
    )
