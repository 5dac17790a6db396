"""Files of other people's recordings: where they are from, and which bytes a record rests on."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from mobility_imu.datasets.catalogue import find_dataset
from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError

Numbers = dict[str, Any]
FROZEN = "d5e260b"
"""Commit at which the settings were fixed, before anybody ran the recordings held back."""


def origin_of(dataset: str) -> str:
    """Where a data set is from, for its record.

    Parameters
    ----------
    dataset : name by which it is fetched

    Returns
    -------
    str with address, commit and licence
    """
    found = find_dataset(dataset)
    return f"{found.origin} at {found.commit}; licence: {found.licence}"


def checksums(folder: Path, names: Iterable[str]) -> dict[str, str]:
    """SHA-256 of files.

    Parameters
    ----------
    folder : that holds them
    names : of the files in it

    Returns
    -------
    dict from name to 64 hexadecimal digits

    Raises
    ------
    InputError
        If a file is not there.
    """
    sums = {}
    for name in names:
        path = folder / name
        if not path.is_file():
            raise InputError(f"{path}: no such file")
        sums[name] = hashlib.sha256(path.read_bytes()).hexdigest()
    return sums


def lacking_files(folder: Path, names: Iterable[str]) -> list[str]:
    """Files that a folder lacks.

    Parameters
    ----------
    folder : of a data set
    names : that are looked for

    Returns
    -------
    list of str
    """
    return [name for name in names if not (folder / name).is_file()]


def held_study(
    dataset: str,
    record: str,
    files: Callable[[Path], list[str]],
    compute: Callable[[Path], Numbers],
) -> Numbers | None:
    """Record of recordings that were held back until the settings were fixed.

    Parameters
    ----------
    dataset : name by which it is fetched
    record : name of the record
    files : gives the files that are read from a folder; all of them have to be there
    compute : gives ``rows``, ``summary`` and what else the record keeps, from that folder

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a file of the record is not here
    """
    folder = find_folder(dataset)
    names = [] if folder is None else files(folder)
    if folder is None or not names or lacking_files(folder, names):
        return None
    numbers = {
        "origin": origin_of(dataset),
        "command": f"python -m mobility_imu.reproduction.recorded {record}",
        "frozen": FROZEN,
        "files": checksums(folder, names),
        **compute(folder),
    }
    return {"numbers": numbers, "inputs": numbers["files"]}
