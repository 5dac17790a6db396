"""What real recordings gave, read from the records and checked wherever the recordings are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.differences import differing
from mobility_imu.reproduction.real_files import checksums
from mobility_imu.reproduction.recorded import load_record
from mobility_imu.reproduction.walker import real_feet, real_walks

Numbers = dict[str, Any]


class Source(NamedTuple):
    """How the rows of a record are computed again.

    Parameters
    ----------
    dataset : name of the data set
    row : function of its folder and of a recording's name
    kept : function that leaves of a row what the record keeps
    name_of : function from the row's ``walk`` to the recording's name
    files_of : function from that name to the files that are read
    """

    dataset: str
    row: Callable[[Path, str], Numbers]
    kept: Callable[[Numbers], Numbers]
    name_of: Callable[[str], str]
    files_of: Callable[[str], list[str]]


SOURCES = {
    "real_walks": Source(
        real_walks.DATASET,
        real_walks.walk_row,
        real_walks.kept,
        str,
        lambda name: [f"{name}.csv.gz", "labelled_steps.csv", "mount.toml"],
    ),
    "real_feet": Source(
        real_feet.DATASET,
        real_feet.foot_row,
        real_feet.kept,
        lambda walk: walk.removeprefix("foot_"),
        lambda name: [f"foot_{name}.csv.gz", f"foot_{name}_truth.csv.gz"],
    ),
}
"""Both records of the walker."""


def real_numbers(name: str) -> Numbers:
    """Recorded numbers of one data set.

    Parameters
    ----------
    name : "real_walks" or "real_feet"

    Returns
    -------
    dict: ``origin``; ``files``, SHA-256 by name; ``rows``, one per recording; ``summary``
    """
    numbers: Numbers = load_record(name)["numbers"]
    return numbers


def computed_again(name: str, every: int = 1) -> int:
    """Compute rows of a record again where the recordings are, and compare.

    Parameters
    ----------
    name : "real_walks" or "real_feet"
    every : 1 takes every row, 4 every fourth

    Returns
    -------
    int, rows that came out as recorded; 0 if the recordings are not here, or other files

    Raises
    ------
    InputError
        If a recording of the same bytes gives another number than the record.
    """
    source, numbers = SOURCES[name], real_numbers(name)
    folder = find_folder(source.dataset)
    if folder is None:
        return 0
    count = 0
    for recorded in numbers["rows"][::every]:
        one = source.name_of(recorded["walk"])
        names = source.files_of(one)
        if not all((folder / file).is_file() for file in names):
            continue
        sums = checksums(folder, names)
        if any(numbers["files"][file] != sums[file] for file in names):
            continue
        found = source.kept(source.row(folder, one))
        for place, value, _ in differing(found, recorded, partial=True):
            raise InputError(
                f"record {name}, {recorded['walk']}, {place}: the recording gives {value}; renew "
                "the record"
            )
        count += 1
    return count


def real_note(name: str, again: int) -> str:
    """Where the recorded numbers come from, for the page that shows them.

    Parameters
    ----------
    name : "real_walks" or "real_feet"
    again : rows that were computed again, from :func:`computed_again`

    Returns
    -------
    str of three lines
    """
    record = load_record(name)
    numbers = record["numbers"]
    here = f"{again} of them, all as recorded" if again else "no, they are not on this machine"
    return (
        f"{len(numbers['rows'])} recordings, {numbers['origin']}\n"
        f"recorded on {record['date']} by {record['command']}\n"
        f"computed again here: {here}"
    )
