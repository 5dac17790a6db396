"""A hand-held chain with two hinges: steering and throttle at once, on a moving base."""

from __future__ import annotations

import re

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from mobility_imu.datasets.files import Files, Note, Output, decoded
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, wrap_angle
from mobility_imu.readers.segments import parse_segments
from mobility_imu.readers.table import NumberTable
from mobility_imu.recording import Imu, Recording

FILE = re.compile(r"data/dataset/trial([12])/(imu_rigid|imu_nonrigid|omc)\.csv")
LABELS = {"imu_rigid": "rigid", "imu_nonrigid": "foam"}
BODY, MIDDLE, LEVER = 3, 4, 5
"""Segments; the hinge between 3 and 4 steers, the one between 4 and 5 is the throttle."""
LATE_SAMPLES = {1: 0, 2: 1}
"""In trial 2 the IMUs are one sample late."""
TURN = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0.0]])
"""The segments' axes (z, x, y) are the scooter's (x, y, z)."""
MARGIN_FRAMES = 9
"""Around lost markers the pose is not used; half of this on either side."""
GEOMETRY = "[scooter]\nsteering_inclination_deg = 45.0\nlever_inclination_deg = 45.0\n"


def wanted(path: str) -> bool:
    """Whether a file is of one of the two trials."""
    return FILE.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """Recording and truth of both trials, rigid and on foam, and the geometry."""
    paths = {(int(m[1]), m[2]): name for name in files.names if (m := FILE.fullmatch(name))}
    trials = sorted({trial for trial, _ in paths})
    if not trials:
        raise InputError("the origin has none of the trials")
    for trial in trials:
        tables = {}
        for kind in ("omc", *LABELS):
            if (trial, kind) not in paths:
                raise InputError(f"trial {trial}: the origin has no {kind}.csv")
            label = f"trial{trial}, {kind}"
            tables[kind] = parse_segments(decoded(files, paths[trial, kind], label), label)
        for kind, name in LABELS.items():
            _convert_part(f"trial{trial}_{name}", tables[kind], tables["omc"], trial, out)
    out.text("geometry.toml", GEOMETRY)
    return Note(
        done=[
            "lever is segment 5, body segment 3. Axes exchanged, (x, y, z) = (z, x, y) of the "
            "segment; the body in addition turned by 45 deg about x, so that the scooter's model "
            "holds. Both inclinations are 45 deg (any pair that is equal gives the same).",
            "Truth: turn of segment 4 against 3 about y (steering), minus that of 5 against 4 "
            "about z (throttle), from the markers' poses, interpolated on the sphere to the IMU's "
            "times; empty where markers are lost and 0.13 s around.",
        ],
        fitted=["In trial 2 the IMUs are one sample late: corrected in the truth."],
        assumed=["The hinges' axes are the segments' axes."],
    )


def _convert_part(
    name: str,
    imu: tuple[float, NumberTable],
    poses: tuple[float, NumberTable],
    trial: int,
    out: Output,
) -> None:
    """Recording and truth of one trial with one kind of fixing."""
    rate_hz, table = imu
    time_s = np.arange(len(table)) / rate_hz
    incline = Rotation.from_euler("x", 45, degrees=True).as_matrix()
    sensors = {
        sensor: Imu(
            *(
                table.columns([f"seg{segment}_{q}_{axis}" for axis in "xyz"]) @ turn.T
                for q in ("acc", "gyr")
            )
        )
        for sensor, segment, turn in (("lever", LEVER, TURN), ("body", BODY, incline @ TURN))
    }
    out.recording(name, Recording(time_s, sensors, source=name))
    steering, throttle = _angles(*poses, time_s - LATE_SAMPLES[trial] / rate_hz)
    truth = {"time_s": time_s, "steering_rad": steering, "throttle_rad": throttle}
    out.table(f"{name}_truth", truth)


def _angles(rate_hz: float, table: NumberTable, at_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Steering and throttle at some times, rad; NaN where a segment was not seen."""
    clock = np.arange(len(table)) / rate_hz
    usable = (at_s >= 0) & (at_s <= clock[-1])
    turns = {}
    for segment in (BODY, MIDDLE, LEVER):
        quaternion = table.columns([f"seg{segment}_quat_{axis}" for axis in "xyzw"])
        seen = np.isfinite(quaternion).all(axis=1)
        frames = np.flatnonzero(seen)
        if len(frames) < 2:
            raise InputError(f"{table.source}: segment {segment} is never seen")
        path = Slerp(clock[frames], Rotation.from_quat(quaternion[frames]))
        turns[segment] = path(np.clip(at_s, clock[frames[0]], clock[frames[-1]]))
        lost = np.convolve(~seen, np.ones(MARGIN_FRAMES), "same")
        usable &= np.interp(at_s, clock, lost) < 1e-9

    def about(first: int, second: int, axis: int) -> FloatArray:
        relative = (turns[first].inv() * turns[second]).as_quat()
        return wrap_angle(2 * np.arctan2(relative[:, axis], relative[:, 3]))

    steering, throttle = about(BODY, MIDDLE, 1), -about(MIDDLE, LEVER, 2)
    return np.where(usable, steering, np.nan), np.where(usable, throttle, np.nan)
