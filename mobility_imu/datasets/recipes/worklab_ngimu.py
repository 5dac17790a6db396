"""A coast-down of a sports chair, three NGIMUs of one session."""

from __future__ import annotations

import re

import numpy as np

from mobility_imu.datasets.files import Files, Note, Output, decoded
from mobility_imu.datasets.series import longest_run
from mobility_imu.errors import InputError
from mobility_imu.readers.clocks import join_streams
from mobility_imu.readers.streams import Asked
from mobility_imu.readers.xio import read_xio
from mobility_imu.recording import Recording

FILE = re.compile(
    r"docs/chapters/examples/example_data/imu_example_data/"
    r"NGIMU - \d (Frame|Left|Right) - [0-9A-F]+/sensors\.csv"
)
PLACES = {"Frame": "frame", "Left": "left_wheel", "Right": "right_wheel"}
RATE_HZ = 400.0
STILL_RADPS = 0.12
"""Slower on every axis of every sensor; rest, with a person in the chair."""
FAST_RADPS, LEVEL_RADPS = 2.0, 0.12
"""Wheels faster and the frame slower than this; straight driving."""
EDGE_S = 0.25
GEOMETRY = """\
# The values that worklab's own example assumes; nobody states that they were measured.
[wheelchair]
camber_deg = 18.0
wheel_radius_left_m = 0.32
wheel_radius_right_m = 0.32
track_m = 0.80
"""


def wanted(path: str) -> bool:
    """Whether a file is the table of one of the three sensors."""
    return FILE.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """The session on one clock, a static and a straight part of it, and the geometry."""
    paths = {PLACES[m[1]]: name for name in files.names if (m := FILE.fullmatch(name))}
    if len(paths) < len(PLACES):
        raise InputError(f"the origin has {len(paths)} of three sensors of the session")
    streams = {
        sensor: read_xio(decoded(files, paths[sensor], sensor), f"coast, {sensor}", Asked())[0]
        for sensor in PLACES.values()
    }
    recording, said = join_streams(streams, RATE_HZ, source="coast")
    out.recording("coast", recording)
    edge = round(EDGE_S * RATE_HZ)
    for name, part in (("static", _still(recording)), ("straight", _straight(recording))):
        first, last = part.start + edge, part.stop - edge
        if last - first < RATE_HZ:
            raise InputError(f"coast: no second of {name} in it")
        clock = recording.time_s
        out.recording(f"coast_{name}", recording.trim(clock[first], clock[last]))
    out.text("coast_geometry.toml", GEOMETRY)
    return Note(
        done=[
            "g and deg/s were turned into SI; the three sensors were interpolated to "
            f"{RATE_HZ:g} Hz by their stamps, which count from the start of the session.",
            "Packets over Wi-Fi come twice or not at all: samples whose stamps repeat or run "
            "backwards were left out, holes bridged by straight lines.",
            "coast_static and coast_straight were cut from the same recording: the longest rest, "
            "and the longest way without turning.",
        ],
        assumed=[
            "The stamps of the three sensors are one clock (the session's): by the turn at the "
            "end, frame and wheels differ by less than 3 ms.",
            "Geometry: the values that worklab's example assumes. The turn does not fit them: with "
            "radii of 0.32 m 'wheelchair check' finds a track of 0.93 m and a camber of 19 deg.",
        ],
        warnings=list(said),
    )


def _still(recording: Recording) -> slice:
    rates = np.hstack([recording.gyroscope(name) for name in recording.sensors])
    return longest_run((np.abs(rates) < STILL_RADPS).all(axis=1))


def _straight(recording: Recording) -> slice:
    frame = np.abs(recording.gyroscope("frame"))
    wheels = [np.abs(recording.gyroscope(s)).max(axis=1) for s in ("left_wheel", "right_wheel")]
    return longest_run((frame[:, 2] < LEVEL_RADPS) & (np.min(wheels, axis=0) > FAST_RADPS))
