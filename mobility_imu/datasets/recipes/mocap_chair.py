"""Sports chairs against motion capture: which trials are taken, and what is written of them."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from mobility_imu.datasets.files import Files, Note, Output, decoded
from mobility_imu.datasets.recipes.mocap_chair_fit import (
    Agreement,
    Calibration,
    agreement,
    camber_from_gravity,
    cut_calibration,
    truth_table,
)
from mobility_imu.errors import InputError
from mobility_imu.readers.clocks import join_streams
from mobility_imu.readers.optitrack import parse_optitrack
from mobility_imu.readers.streams import Asked
from mobility_imu.readers.xio import read_xio
from mobility_imu.recording import Recording

TASK = r"(figure8|intermittentsprint|slalom|straightpush|uturn)[^_/]*_(ls|hs)"
CAPTURE = re.compile(rf"data/(test_[^/]+/[^/]+)/opti/(?:[^/]*_)?({TASK})\.csv", re.IGNORECASE)
SENSOR = re.compile(
    r"data/(test_[^/]+/[^/]+)/imu/(?:[^/]*_)?([^_/]+_[^_/]+)/(Chair|x-IMU3)[^/]*/Inertial\.csv",
    re.IGNORECASE,
)
PERSON = re.compile(r"data/(test_[^/]+/[^/]+)/[^/]+/")
PLACES = {"frame": "chair", "right_wheel": "x-imu3"}
ONE_CHAIR = "test_02.13"
"""On this day all sat in one kind of chair; its radius and track are fitted together."""
RATE_HZ = 50.0
SMALL_BYTES = 4 * 2**20
"""Captures of this size or more were not at hand when the choice was made; they change nothing."""
SHORTEST_SAMPLES = 200
SHORTEST_CUT_SAMPLES = 50
RADIUS_TOLERANCE = 0.012
OTHERS = "others/"
"""Folder of the trials that the choice left out."""


@dataclass(eq=False)
class Trial:
    """One trial that motion capture saw.

    Parameters
    ----------
    person : number of the person, in the order of the folders
    task : such as ``slalom_ls``
    recording : frame and right wheel
    fit : how it agrees with motion capture
    reason : why it was left out; empty if it was chosen
    """

    person: int
    task: str
    recording: Recording
    fit: Agreement
    reason: str = ""

    @property
    def label(self) -> str:
        """Name of its files."""
        return f"P{self.person:02d}_{self.task}"


@dataclass(frozen=True)
class Chair:
    """Geometry of a chair, fitted to motion capture; camber from gravity.

    Parameters
    ----------
    radius_m : m, of the wheels
    half_track_m : m, speed of a wheel per yaw rate, by motion capture
    camber_rad : rad
    """

    radius_m: float
    half_track_m: float
    camber_rad: float

    def to_toml(self) -> str:
        """Geometry file; the turning chair turns a leaning wheel about its axle as well."""
        track_m = 2 * (self.half_track_m + self.radius_m * np.sin(self.camber_rad))
        return (
            f"[wheelchair]\ncamber_deg = {np.degrees(self.camber_rad):.1f}\n"
            f"wheel_radius_left_m = {self.radius_m:.4f}\n"
            f"wheel_radius_right_m = {self.radius_m:.4f}\ntrack_m = {track_m:.3f}\n"
        )


def wanted(path: str) -> bool:
    """Whether a file is a capture of a task, or a table of one of the two sensors."""
    return CAPTURE.fullmatch(path) is not None or SENSOR.fullmatch(path) is not None


def convert(files: Files, out: Output) -> Note:
    """Recordings, truth and geometry of the chosen trials; the others in a folder of their own."""
    folders = sorted({m[1] for name in files.names if (m := PERSON.match(name))})
    people = {folder: number for number, folder in enumerate(folders, 1)}
    origin = _Origin.of(files, people)
    note = _note()
    trials = origin.trials(note)
    if not trials:
        raise InputError("the origin has no trial with both sensors and motion capture")
    chair_of = {
        number: ONE_CHAIR if folder.startswith(f"{ONE_CHAIR}/") else str(number)
        for folder, number in people.items()
    }
    middle = _middles([trial for trial in trials if not trial.reason], chair_of)
    for trial in trials:
        radius = middle.get(chair_of[trial.person], (np.nan, np.nan))[0]
        if not trial.reason and not abs(trial.fit.radius_m / radius - 1) < RADIUS_TOLERANCE:
            trial.reason = "radius is not that of the chair's other trials"
    cuts = {p: origin.calibration(p) for p in sorted({t.person for t in trials})}
    sound = {p for p, cut in cuts.items() if cut.shortest >= SHORTEST_CUT_SAMPLES}
    for trial in trials:
        if not trial.reason and trial.person not in sound:
            trial.reason = "no rest or straight way of this person to calibrate with"
    chairs = _chairs(trials, chair_of, cuts)
    _write(trials, chairs, cuts, sound, out, note)
    return note


@dataclass(frozen=True, eq=False)
class _Origin:
    """The origin's files by person and trial; no message or file of ours has a person's name.

    Parameters
    ----------
    files : of the origin
    captures : person and task to path
    sensors : person and task to the paths of the sensors, by their place
    """

    files: Files
    captures: dict[tuple[int, str], str]
    sensors: dict[tuple[int, str], dict[str, str]]

    @classmethod
    def of(cls, files: Files, people: dict[str, int]) -> _Origin:
        """Sort the origin's paths; the first of two of one kind is taken."""
        captures: dict[tuple[int, str], str] = {}
        sensors: dict[tuple[int, str], dict[str, str]] = {}
        for name in files.names:
            if match := CAPTURE.fullmatch(name):
                captures.setdefault((people[match[1]], match[2].lower()), name)
            elif match := SENSOR.fullmatch(name):
                trial = sensors.setdefault((people[match[1]], match[2].lower()), {})
                trial.setdefault(match[3].lower(), name)
        return cls(files, captures, sensors)

    def recording(self, person: int, task: str) -> tuple[Recording, tuple[str, ...]]:
        """Frame and right wheel of a trial, and what was odd."""
        label = f"P{person:02d}_{task}"
        paths = self.sensors.get((person, task), {})
        if any(place not in paths for place in PLACES.values()):
            raise InputError(f"{label}: a sensor has no file")
        streams = {
            sensor: read_xio(
                decoded(self.files, paths[place], label), f"{label}, {sensor}", Asked()
            )[0]
            for sensor, place in PLACES.items()
        }
        return join_streams(streams, RATE_HZ, source=label)

    def trials(self, note: Note) -> list[Trial]:
        """Every trial that can be put beside motion capture; the note says which cannot."""
        found = []
        for (person, task), path in self.captures.items():
            label = f"P{person:02d}_{task}"
            capture = self.files.read(path)
            try:
                poses = parse_optitrack(capture.decode("utf-8", "replace"), "chair", label)
                recording, said = self.recording(person, task)
                if len(recording) < SHORTEST_SAMPLES:
                    raise InputError(f"{label}: the trial is too short ({len(recording)} samples)")
                fit = agreement(recording, poses)
            except InputError as error:
                note.left_out.append(str(error))
                continue
            note.warnings += said
            small = len(capture) < SMALL_BYTES
            reason = fit.fault() if small else "not at hand when the choice was made"
            found.append(Trial(person, task, recording, fit, reason))
        return found

    def calibration(self, person: int) -> Calibration:
        """Rest and straight way of a person, of all the trials."""
        recordings = {}
        for task in sorted(task for p, task in self.sensors if p == person):
            try:
                recordings[task], _ = self.recording(person, task)
            except InputError:  # a trial that cannot be read gives no calibration
                continue
        return cut_calibration(recordings)


def _middles(trials: list[Trial], chair_of: dict[int, str]) -> dict[str, tuple[float, float]]:
    """Median radius and half track of each chair."""
    sizes: dict[str, list[tuple[float, float]]] = {}
    for trial in trials:
        sizes.setdefault(chair_of[trial.person], []).append(
            (trial.fit.radius_m, trial.fit.half_track_m)
        )
    return {
        chair: (float(np.median([r for r, _ in found])), float(np.median([h for _, h in found])))
        for chair, found in sizes.items()
    }


def _chairs(
    trials: list[Trial], chair_of: dict[int, str], cuts: dict[int, Calibration]
) -> dict[int, Chair]:
    """Geometry of each person's chair, as far as chosen trials tell."""
    chosen = [trial for trial in trials if not trial.reason]
    own = {p: camber_from_gravity(cuts[p].straight) for p in {t.person for t in chosen}}
    leans: dict[str, list[float]] = {}
    # A person with more trials counts more often.
    for trial in chosen:
        leans.setdefault(chair_of[trial.person], []).append(own[trial.person])
    median = {chair: _median(values) for chair, values in leans.items()}
    usual = _median([own[trial.person] for trial in chosen])
    sizes = _middles(chosen, chair_of)
    return {
        person: Chair(*sizes[chair], usual if np.isnan(median[chair]) else median[chair])
        for person, chair in chair_of.items()
        if chair in sizes
    }


def _median(values: list[float]) -> float:
    """Median of the numbers among the values, NaN if there is none."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else np.nan


def _write(
    trials: list[Trial],
    chairs: dict[int, Chair],
    cuts: dict[int, Calibration],
    sound: set[int],
    out: Output,
    note: Note,
) -> None:
    """Write every trial, what each person needs for it, and the table of the choice."""
    chosen = {trial.person for trial in trials if not trial.reason}
    for person in sorted({trial.person for trial in trials}):
        place = "" if person in chosen else OTHERS
        if person in sound:
            for name, table in (
                ("static", cuts[person].static),
                ("straight", cuts[person].straight),
            ):
                out.table(f"{place}P{person:02d}_{name}", table)
        if person in chairs:
            out.text(f"{place}P{person:02d}_geometry.toml", chairs[person].to_toml())
    rows: dict[str, list[str | int | float]] = {}
    for trial in trials:
        place = OTHERS if trial.reason else ""
        out.recording(place + trial.label, trial.recording)
        table = truth_table(trial.recording.time_s, trial.fit)
        out.table(f"{place}{trial.label}_truth", table, digits=4)
        for column, value in _row(trial).items():
            rows.setdefault(column, []).append(value)
    out.table("trials", rows, digits=4)
    count = sum(not trial.reason for trial in trials)
    note.done.append(
        f"{count} of {len(trials)} trials chosen, of {len(chosen)} people; {OTHERS} holds the "
        "others, trials.csv.gz says of each trial how it agrees and why it was left out."
    )


def _row(trial: Trial) -> dict[str, str | int | float]:
    """Row of the table of the choice."""
    fit = trial.fit
    return {
        "trial": trial.label,
        "chosen": int(not trial.reason),
        "why_not": trial.reason,
        "capture_begins_s": fit.begin_s,
        "path_m": fit.path_m,
        "fastest_mps": fit.fastest_mps,
        "wheel_misfit_mps": fit.wheel_misfit_mps,
        "gyroscope_gain": fit.gain,
        "gyroscope_correlation": fit.correlation,
        "radius_m": fit.radius_m,
        "half_track_m": fit.half_track_m,
    }


def _note() -> Note:
    return Note(
        done=[
            f"Frame and right wheel (x-IMU3) interpolated to {RATE_HZ:g} Hz by their own stamps, "
            "which are one clock within 30 ms; g and deg/s to SI. People are numbered in the order "
            "of their folders. The task is the name; _ls slow, _hs fast.",
            "Truth: speed along the chair's forward axis and yaw rate (positive to the left) from "
            "OptiTrack, 120 Hz, low-passed at 3 Hz forward and backward: do the same to what you "
            "compare. Gaps up to 50 ms are interpolated, longer ones are empty with 0.27 s on "
            "both sides.",
            "PNN_static and PNN_straight: the person's longest rest, and the longest steady "
            "straight way of the straight pushes.",
            "Chosen: captured way over 5 m, yaw rate correlates over 0.99 with gain 0.97 to 1.03, "
            "wheel and capture agree within 0.05 m/s in a fit that leaves the sideways motion free "
            "(up to 0.064 m/s without it), radius within 1.2 % of the chair's median. So the truth "
            "is sound, but trials in which the wheel slips are not among them.",
        ],
        fitted=[
            "One clock shift per trial, to 2 ms, from yaw rate and wheel together.",
            "Radius and half track, from the capture: P01 to P08 together, the others each for "
            "itself. The scale of the speed is not tested.",
        ],
        assumed=[
            "Camber from gravity along the axle, mean over whole turns of the wheel; the left "
            "wheel is like the right one, which alone has a sensor.",
        ],
    )
