"""Drives of a chair on seven kinds of ground: three modules with clocks of their own."""

from __future__ import annotations

import re

from mobility_imu.datasets.files import Files, Note, Output, decoded
from mobility_imu.errors import InputError
from mobility_imu.readers.androsensor import read_androsensor
from mobility_imu.readers.clocks import join_streams
from mobility_imu.readers.streams import Asked

FOLDER = "imu_data/set_full/"
DRIVE = re.compile(
    re.escape(FOLDER) + r"(Left|Middle|Right)_([A-Z][a-z]+)(Straight|Donut)_Module\.csv"
)
PLACES = {"frame": "Middle", "left_wheel": "Right", "right_wheel": "Left"}
"""The module that the origin calls Left turns as a right wheel does, and the other way round."""
RATE_HZ = 100.0
GEOMETRY = """\
# Radius assumed, track by hand from the donuts, camber hardly any: see NOTE.txt.
[wheelchair]
camber_deg = 0.0
wheel_radius_left_m = 0.305
wheel_radius_right_m = 0.305
track_m = 0.527
"""


def wanted(path: str) -> bool:
    """Whether a file is of a drive with modules on the frame and on both wheels."""
    return DRIVE.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """One recording per drive, and the geometry."""
    note = Note(
        done=[
            f"The three modules of a drive were put on one clock by their wall-clock stamps and "
            f"interpolated to {RATE_HZ:g} Hz; nothing else was changed.",
            "The origin calls the wheels left and right the other way round (with its names they "
            "turn against the frame's gyroscope): the names are exchanged here. If the modules "
            "state gravity and not force (-1 g upward), the origin's names are right, and all "
            "turns go to the other side: donuts to the right.",
            "straight: pushed along; donut: several turns to the left. Each drive begins with some "
            "seconds of rest, of which a static trial can be cut.",
        ],
        assumed=[
            "Radius of the wheels 0.305 m (geometry.toml): nobody measured it.",
            "Accelerometers that read +1 g upward, as Android's do. Each wheel's own gravity "
            "speaks against it: `mirrored` is found in five of the six drives that were looked at.",
            "Track 0.527 m, by hand from the donuts with this radius; camber 0.",
        ],
        left_out=[
            "Drives with power assistance (no modules on the wheels), second straight drives, and "
            "joined files."
        ],
    )
    found = [m for name in files.names if (m := DRIVE.fullmatch(name))]
    drives = sorted({(m[2], m[3]) for m in found})
    have = {m[0] for m in found}
    converted = 0
    for ground, kind in drives:
        label = f"{ground.lower()}_{kind.lower()}"
        paths = {s: f"{FOLDER}{p}_{ground}{kind}_Module.csv" for s, p in PLACES.items()}
        if not have.issuperset(paths.values()):
            note.left_out.append(f"{label}: not all three modules have a file.")
            continue
        streams = {
            sensor: read_androsensor(decoded(files, path, path), f"{label}, {sensor}", Asked())[0]
            for sensor, path in paths.items()
        }
        recording, said = join_streams(streams, RATE_HZ, source=label)
        out.recording(label, recording)
        note.warnings += said
        converted += 1
    if not converted:
        raise InputError("the origin has no drive with all three modules")
    out.text("geometry.toml", GEOMETRY)
    return note
