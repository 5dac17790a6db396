"""Walks with a walking frame, and the steps that their authors cut out."""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.datasets.files import Files, Note, Output, decoded
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.readers.json_samples import read_json_samples
from mobility_imu.readers.streams import Asked, Stream

FOLDER = "python/manually_cut_data/"
WALK = re.compile(re.escape(FOLDER) + r"walker_steps/step_cluster_(\d+)\.json")
STEP = re.compile(re.escape(FOLDER) + r"extracted_steps/step_(\d+)\.json")
COPIES = range(7, 12)
"""Clusters that hold the walks of clusters 2 to 6 once more."""
APART_S = 0.8
"""Windows whose middles are closer are one step, cut out twice."""
EDGE_S = 0.01
FOOTPRINT_M = (0.55, 0.45)
PLACE_M = (0.3, 0.0, 0.7)


def wanted(path: str) -> bool:
    """Whether a file is a walk or a step cut out of one."""
    walk = WALK.fullmatch(path)
    return (walk is not None and int(walk[1]) not in COPIES) or STEP.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """One recording per walk, the labelled steps, and an assumed mount."""
    names = [name for name in files.names if wanted(name)]
    walks = {int(m[1]): m[0] for name in names if (m := WALK.fullmatch(name))}
    windows = [
        (stream.time_s[0], stream.time_s[-1])
        for name in names
        if STEP.fullmatch(name)
        for stream in read_json_samples(decoded(files, name, name), name, Asked())
    ]
    labels: list[tuple[str, float, float]] = []
    rest = []
    for number, path in sorted(walks.items()):
        label = f"walk_{number:02d}"
        stream = read_json_samples(decoded(files, path, path), label, Asked())[0]
        begin = stream.time_s[0]
        labels += _steps_of(label, stream.time_s, windows)
        # Stamps are s since 1970, which a float keeps to a quarter of a microsecond only.
        clock = (stream.time_s - begin).round(4)
        # Five decimals are a thousand times finer than the sensor's steps.
        acc = stream.acc_mps2.round(5)
        out.stream(label, "frame", Stream(clock, acc, stream.gyr_radps, source=label))
        rest.append(np.median(stream.acc_mps2, axis=0))
    if not labels:
        raise InputError("the origin has no walk with a labelled step in it")
    rows = [f"{walk},{first},{last}" for walk, first, last in labels]
    out.text("labelled_steps.csv", "\n".join(["walk,begin_s,end_s", *rows]) + "\n")
    up_g = (np.median(rest, axis=0) / STANDARD_GRAVITY_MPS2).round(2)
    out.text("mount.toml", _mount(up_g))
    return Note(
        done=[
            f"{len(walks)} walks, {len(labels)} labelled steps. g and deg/s were turned into SI; "
            "times count from each walk's start.",
            "labelled_steps.csv: windows of about 2 s that the authors cut out as steps, on each "
            f"walk's clock. Windows whose middles are less than {APART_S} s apart are one step.",
            "The authors had resampled to 80 Hz; accelerations are mostly rounded to 0.01 g.",
        ],
        assumed=[
            f"mount.toml: upright from the median acceleration of all walks, {up_g.tolist()} g; "
            "forward (the sensor's z), height and place of the sensor and the footprint are "
            "assumptions. Course and person are not known.",
        ],
        left_out=[
            "Clusters 7 to 11, which hold the walks of 2 to 6 once more; falls, turns, idle parts.",
        ],
    )


def _steps_of(
    label: str, time_s: FloatArray, windows: list[tuple[float, float]]
) -> list[tuple[str, float, float]]:
    """Steps whose windows lie inside a walk, each once, on the walk's clock."""
    begin, end = time_s[0], time_s[-1]
    inside = {
        (round(first - begin, 3), round(last - begin, 3))
        for first, last in windows
        if begin - EDGE_S <= first and last <= end + EDGE_S
    }
    steps, before = [], -np.inf
    for first, last in sorted(inside):
        if (first + last) / 2 - before > APART_S:
            steps.append((label, float(first), float(last)))
            before = (first + last) / 2
    return steps


def _mount(up: FloatArray) -> str:
    """Mount with the sensor's z forward, as far as that is level."""
    up = up / np.linalg.norm(up)
    forward = np.array([0.0, 0.0, 1.0]) - up[2] * up
    forward /= np.linalg.norm(forward)
    rows = np.array([forward, np.cross(up, forward), up]).round(9) + 0.0
    return (
        "# Upright from gravity; forward, height, place and footprint are assumptions: NOTE.txt.\n"
        f"[walker]\nfootprint_width_m = {FOOTPRINT_M[0]}\nfootprint_length_m = {FOOTPRINT_M[1]}\n"
        f"[walker.mount]\nrotation_imu_to_body = {rows.tolist()}\n"
        f"translation_body_m = {list(PLACE_M)}\n"
    )
