"""What two hinged chains gave, read from the records and checked wherever the recordings are."""

from __future__ import annotations

from pathlib import Path

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.real import Numbers, checksums, differing, lacking_files, shown
from mobility_imu.reproduction.recorded import load_record
from mobility_imu.reproduction.scooter.real_hinges import (
    ONE_HINGE,
    TWO_HINGES,
    errors_of,
    read_chain,
)

CHAINS = {"real_two_hinges": TWO_HINGES, "real_one_hinge": ONE_HINGE}
"""Records and their chains."""


def hinge_numbers(name: str) -> Numbers:
    """Recorded numbers of one chain.

    Parameters
    ----------
    name : "real_two_hinges" or "real_one_hinge"

    Returns
    -------
    dict, see :func:`~mobility_imu.reproduction.scooter.real_hinges.chain_numbers` and
    :func:`~mobility_imu.reproduction.scooter.real_hinges_record.chain_details`
    """
    numbers: Numbers = load_record(name)["numbers"]
    return numbers


def hinges_again(name: str) -> int:
    """Compute the errors of a record again where its recordings are, and compare.

    Parameters
    ----------
    name : "real_two_hinges" or "real_one_hinge"

    Returns
    -------
    int, rows that came out as recorded; 0 if the recordings are not here, or other files

    Raises
    ------
    InputError
        If a recording of the same bytes gives another number than the record.
    """
    numbers, chain = hinge_numbers(name), CHAINS[name]
    folder = find_folder(chain.dataset)
    if folder is None or not _same_files(folder, numbers["files"]):
        return 0
    for recorded in numbers["rows"]:
        stem, method = recorded["recording"], recorded["method"]
        found = errors_of(read_chain(folder, stem, chain.recordings[stem]), method)
        for place, now, was in differing(found, {key: recorded[key] for key in found}):
            raise InputError(
                f"record {name}, {stem}, {method}, {place}: the recording gives {shown(now)}, "
                f"the record has {shown(was)}; renew the record"
            )
    return len(numbers["rows"])


def _same_files(folder: Path, files: dict[str, str]) -> bool:
    return not lacking_files(folder, files) and checksums(folder, files) == files


def hinge_note(name: str, again: int | None = None) -> str:
    """Where the recorded numbers come from, for the page that shows them.

    Parameters
    ----------
    name : "real_two_hinges" or "real_one_hinge"
    again : rows that were computed again, from :func:`hinges_again`; None says nothing of it

    Returns
    -------
    str of two lines, or three
    """
    record = load_record(name)
    numbers = record["numbers"]
    lines = [
        f"{len(numbers['series'])} recordings, {numbers['origin'].removeprefix('https://')}",
        f"recorded on {record['date']} by {record['command']}",
    ]
    if again is not None:
        here = f"{again} rows, all as recorded" if again else "no, the recordings are not here"
        lines.append(f"computed again here: {here}")
    return "\n".join(lines)
