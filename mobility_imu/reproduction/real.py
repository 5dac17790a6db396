"""Independent real recordings: what is recorded of them, and whether it comes out here again.

Most of these recordings have no licence for passing on, so the project keeps numbers that were
computed from them, with origin, checksum of each file, and command. Where a set is on this machine,
named by MOBILITY_IMU_RECORDINGS or fetched, its numbers are computed again and compared.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from mobility_imu.data import recorded_folder
from mobility_imu.datasets.folders import RECORDINGS_VARIABLE, find_folder
from mobility_imu.frames import one_of
from mobility_imu.reproduction.claims import Work
from mobility_imu.reproduction.differences import differing, leaves, shown
from mobility_imu.reproduction.real_files import Numbers, lacking_files

State = Literal["as recorded", "differs", "other files", "not here", "no record"]
STATES: tuple[State, ...] = ("as recorded", "differs", "other files", "not here", "no record")
SHOWN_DIFFERENCES = 3


class RealSet(NamedTuple):
    """A set of recordings that others made, and the record that we keep of it.

    Parameters
    ----------
    record : name of the record
    work : "scooter", "wheelchair" or "walker", whose method is tried
    dataset : name by which ``mobility-imu fetch`` knows the set
    title : device and reference, in a few words
    """

    record: str
    work: Work
    dataset: str
    title: str


REAL_SETS: dict[str, RealSet] = {
    real.record: real
    for real in (
        RealSet("real_two_hinges", "scooter", "two-hinges", "two hinges, motion capture"),
        RealSet("real_one_hinge", "scooter", "one-hinge", "one motorised hinge, encoder"),
        RealSet("real_drives", "wheelchair", "terrain-chair", "chair on real ground"),
        RealSet("real_chair_mocap", "wheelchair", "mocap-chair", "sports chairs, motion capture"),
        RealSet("real_car", "wheelchair", "car-wheels", "car, satellite positions"),
        RealSet("real_walks", "walker", "labelled-walks", "walking frame, labelled steps"),
        RealSet("real_feet", "walker", "foot-walks", "sensor on a foot, motion capture"),
        RealSet("held_drives", "wheelchair", "terrain-chair", "held back: chair on real ground"),
        RealSet("held_chairs", "wheelchair", "mocap-chair", "held back: sports chairs"),
        RealSet("held_car", "wheelchair", "car-wheels", "held back: car"),
        RealSet("held_walks", "walker", "labelled-walks", "held back: walking frame"),
        RealSet("held_feet", "walker", "foot-walks", "held back: sensor on a foot"),
        RealSet(
            "dropped_chairs", "wheelchair", "mocap-chair", "left out by the choice: sports chairs"
        ),
    )
}
"""Sets by the names of their records; *held back* were not looked at until the settings were fixed
at the commit :data:`~mobility_imu.reproduction.real_files.FROZEN`."""
HELD_OF = {
    "held_drives": "real_drives",
    "held_chairs": "real_chair_mocap",
    "dropped_chairs": "real_chair_mocap",
    "held_car": "real_car",
    "held_walks": "real_walks",
    "held_feet": "real_feet",
}
"""Record of what was held back to the record of what was looked at."""


@dataclass(frozen=True)
class RealRecord:
    """What is recorded of a set.

    Parameters
    ----------
    origin : where the recordings are from, at which commit
    command : that computes the record again
    date : when that was done last
    files : name to SHA-256 of each file that was read
    rows : numbers of each recording
    summary : numbers of the set
    """

    origin: str
    command: str
    date: str
    files: Mapping[str, str]
    rows: list[Numbers]
    summary: Numbers

    @property
    def numbers(self) -> Numbers:
        """``rows`` and ``summary``, which computing the record again has to give."""
        return {"rows": self.rows, "summary": self.summary}


@dataclass(frozen=True)
class Recomputed:
    """What came of computing a record again.

    Parameters
    ----------
    real : which set
    state : "as recorded", "differs", "other files" (computed from files that are not those of the
        record, so nothing is compared), "not here" or "no record"
    message : one sentence on it
    compared : how many numbers were compared
    numbers : ``rows`` and ``summary`` as computed here, or else as recorded; None without either
    """

    real: RealSet
    state: State
    message: str
    compared: int = 0
    numbers: Mapping[str, Any] | None = None


def real_sets(work: Work | None = None) -> list[RealSet]:
    """Sets on which the methods of one work, or of all, are tried.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three

    Returns
    -------
    list of RealSet
    """
    return [real for real in REAL_SETS.values() if work in (None, real.work)]


def real_record(name: str) -> RealRecord | None:
    """What is recorded of a set.

    Parameters
    ----------
    name : a key of :data:`REAL_SETS`

    Returns
    -------
    RealRecord, or None if there is no record yet

    Raises
    ------
    InputError
        If there is no such set.
    """
    from mobility_imu.reproduction.recorded import load_record

    one_of("record", name, tuple(REAL_SETS))
    if not (recorded_folder() / f"{name}.json").is_file():
        return None
    record = load_record(name)
    numbers = record["numbers"]
    return RealRecord(
        numbers["origin"],
        record["command"],
        record["date"],
        numbers["files"],
        numbers["rows"],
        numbers["summary"],
    )


def record_note(name: str) -> str:
    """Where recorded numbers are from, for the pages that show them.

    Parameters
    ----------
    name : a key of :data:`REAL_SETS`, of which there is a record

    Returns
    -------
    str of three lines: origin, files and recordings, date and command
    """
    record = real_record(name)
    assert record is not None, f"{name}: nothing is recorded"
    return (
        f"{record.origin.removeprefix('https://')}\n"
        f"{len(record.rows)} recordings, {len(record.files)} files; the record has the SHA-256\n"
        f"recorded on {record.date} by {record.command}"
    )


def recompute(name: str) -> Recomputed:
    """Compute a record again where its recordings are, and compare.

    Parameters
    ----------
    name : a key of :data:`REAL_SETS`

    Returns
    -------
    Recomputed

    Raises
    ------
    InputError
        If there is no such set, or MOBILITY_IMU_RECORDINGS names a folder that does not exist.
    """
    record, real = real_record(name), REAL_SETS[name]
    if record is None:
        return Recomputed(real, "no record", f"{name}: nothing is recorded of this set yet")
    folder = find_folder(real.dataset)
    if folder is None:
        return Recomputed(real, "not here", missing(real), numbers=record.numbers)
    lacking = lacking_files(folder, record.files)
    if lacking:
        return Recomputed(
            real,
            "not here",
            f"{real.dataset}: {folder} lacks {_listed(lacking)}; the numbers are those recorded",
            numbers=record.numbers,
        )
    found = _study(name)()
    assert found is not None, f"{name}: its study found no recordings in {folder}"
    numbers = found["numbers"]
    others = [file for file, sha in record.files.items() if numbers["files"].get(file) != sha]
    if others:
        return Recomputed(
            real,
            "other files",
            f"{real.dataset}: {_listed(others)} in {folder} not as recorded (SHA-256); the numbers "
            "are those of the files that are here",
            numbers=numbers,
        )
    return _compared(real, record, numbers)


def _compared(real: RealSet, record: RealRecord, numbers: Numbers) -> Recomputed:
    """Compare with the record; with further recordings here, only those that it has."""
    found, further = numbers, [name for name in numbers["files"] if name not in record.files]
    recorded = record.numbers
    if further:
        known = {_identity(row) for row in record.rows}
        recorded = {"rows": record.rows}
        found = {"rows": [row for row in numbers["rows"] if _identity(row) in known]}
    found = {name: found[name] for name in recorded}
    off, compared = list(differing(found, recorded)), len(list(leaves(found)))
    also = f", with {len(further)} further files, which the record lacks" if further else ""
    if not off:
        message = f"computed again here, {compared} numbers as recorded on {record.date}{also}"
    else:
        first = "; ".join(
            f"{place} = {shown(now)}, recorded {shown(was)}"
            for place, now, was in off[:SHOWN_DIFFERENCES]
        )
        more = f" and {len(off) - SHOWN_DIFFERENCES} more" if len(off) > SHOWN_DIFFERENCES else ""
        message = (
            f"{len(off)} of {compared} numbers differ from the record of {record.date}{also}: "
            f"{first}{more}"
        )
    return Recomputed(
        real,
        "differs" if off else "as recorded",
        f"{real.dataset}: {message}",
        compared,
        numbers,
    )


def _identity(row: Numbers) -> tuple[Any, ...]:
    """Which recording a row is of, and by which method."""
    return next(iter(row.values())), row.get("method")


def missing(real: RealSet) -> str:
    """Sentence for a set that is not on this machine: what to do to have it computed again.

    Parameters
    ----------
    real : RealSet

    Returns
    -------
    str
    """
    return (
        f"{real.dataset}: the numbers are those recorded; get it with 'mobility-imu fetch "
        f"{real.dataset}', or name a folder that has it in {RECORDINGS_VARIABLE}"
    )


def _study(name: str) -> Callable[[], Numbers | None]:
    from mobility_imu.reproduction.recorded import STUDIES

    study = STUDIES[name]
    function: Callable[[], Numbers | None] = getattr(
        importlib.import_module(study.module), study.function
    )
    return function


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - SHOWN_DIFFERENCES} more" if len(names) > SHOWN_DIFFERENCES else ""
    return ", ".join(names[:SHOWN_DIFFERENCES]) + more
