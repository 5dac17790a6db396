"""What others' recordings gave, read from the records and checked wherever the recordings are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.differences import differing
from mobility_imu.reproduction.real_files import Numbers, checksums
from mobility_imu.reproduction.recorded import load_record
from mobility_imu.reproduction.wheelchair import real_car, real_drives, real_mocap

__all__ = ["REAL_RECORDS", "real_note", "real_numbers"]

REAL_RECORDS: dict[str, tuple[str, Callable[[Path, list[str]], Numbers], str]] = {
    real_mocap.RECORD: (real_mocap.DATASET, real_mocap.real_numbers, "trial"),
    real_car.RECORD: (real_car.DATASET, real_car.real_numbers, "trial"),
    real_drives.RECORD: (real_drives.DATASET, real_drives.real_numbers, "drive"),
}
"""Record to its data set, the function that computes its numbers, and the key of a row's name."""


def real_numbers(name: str) -> Numbers:
    """Recorded numbers; where the recordings are, they are computed again and compared.

    What is simulated beside the recordings is not computed again.

    Parameters
    ----------
    name : a key of :data:`REAL_RECORDS`

    Returns
    -------
    dict with ``origin``, ``command``, ``files``, ``rows``, ``summary`` and what the study adds

    Raises
    ------
    InputError
        If the recordings that are here give another number than the record.
    """
    recorded: Numbers = load_record(name)["numbers"]
    folder = _folder(name, recorded)
    if folder is not None:
        _, compute, key = REAL_RECORDS[name]
        found = compute(folder, [row[key] for row in recorded["rows"]])
        # A folder that was fetched holds the same numbers, maybe in files packed otherwise.
        found.pop("files")
        for place, value, _ in differing(found, recorded, partial=True):
            raise InputError(
                f"record {name}, {place}: the recordings give {value}; renew the record"
            )
    return recorded


def real_note(name: str) -> str:
    """Where recorded numbers come from, for the pages that show them.

    Parameters
    ----------
    name : a key of :data:`REAL_RECORDS`

    Returns
    -------
    str of four lines: origin, files, date and command, and whether they were computed again here
    """
    record = load_record(name)
    numbers: Numbers = record["numbers"]
    origin, files = numbers["origin"], numbers["files"]
    folder = _folder(name, numbers)
    checked = "no, the recordings are not here"
    if folder is not None:
        same = sum(checksums(folder, [f])[f] == sha256 for f, sha256 in files.items())
        checked = f"yes, from {same} of {len(files)} files with the recorded SHA-256"
    return (
        f"{origin.removeprefix('https://')}\n"
        f"{len(files)} files; the record has the SHA-256 of each\n"
        f"recorded on {record['date']} by {record['command']}\n"
        f"computed again and compared here: {checked}"
    )


def _folder(name: str, numbers: dict[str, Any]) -> Path | None:
    """Folder of the data set, if every recorded file is in it."""
    folder = find_folder(REAL_RECORDS[name][0])
    if folder is None or not all((folder / file).is_file() for file in numbers["files"]):
        return None
    return folder
