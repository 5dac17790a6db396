"""Walks with a sensor on the foot, motion capture at every sample."""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.datasets.files import Files, Note, Output
from mobility_imu.errors import InputError
from mobility_imu.readers.matlab import parse_matlab
from mobility_imu.readers.streams import Stream

FILE = re.compile(r"data/vicon/processed/[\d-]+\.mat")
MIRROR = np.array([1.0, -1.0, 1.0])
"""The origin's y is mirrored against a right-handed frame with z up."""


def wanted(path: str) -> bool:
    """Whether a file is a walk."""
    return FILE.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """Recording and truth of each walk, numbered by their dates."""
    walks = sorted(name for name in files.names if wanted(name))
    if not walks:
        raise InputError("the origin has none of the walks")
    for number, path in enumerate(walks, 1):
        label = f"foot_{number:02d}"
        found = parse_matlab(files.read(path), ["ts", "imu", "gt", "zv_shoe_opt"], label)
        stamps, imu, place = found["ts"].ravel(), found["imu"], found["gt"] * MIRROR
        still = found["zv_shoe_opt"].ravel()
        if imu.shape != (len(stamps), 6) or place.shape != (len(stamps), 3):
            raise InputError(f"{label}: its variables are no series of one length")
        time_s = stamps - stamps[0]
        out.stream(label, "frame", Stream(time_s, imu[:, :3], imu[:, 3:], source=label))
        x, y, z = (place - place[0]).T
        truth = {"time_s": time_s, "x_m": x, "y_m": y, "z_m": z, "still": still.astype(int)}
        out.table(f"{label}_truth", truth)
    return Note(
        done=[
            f"{len(walks)} walks in the order of their dates. frame_* are the sensor's own axes "
            "and units; nothing was changed.",
            "Truth: Vicon at every sample, from the first sample; its y is mirrored (the origin's "
            "frame is left-handed: mirrored it fits the sensor better in every walk).",
            "still: the origin's best mask of rests, of its SHOE detector (zv_shoe_opt).",
            "Up is -z in walks 01 to 52 and +z in 53 to 56. Heading of truth and sensor differ by "
            "a constant. Steps of 1.1 to 8.8 ms around 5 ms: '--fill-gaps-s 0.05' where a command "
            "calls one a gap.",
        ],
        fitted=["The mask of rests was chosen by the origin with the motion capture at hand."],
        left_out=["The set's other recordings, which have no motion capture."],
    )
