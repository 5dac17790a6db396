"""What the public sample gave, read from the record and checked wherever the sample is."""

from __future__ import annotations

from typing import Any

from mobility_imu.data import sample_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.differences import differing
from mobility_imu.reproduction.recorded import load_record
from mobility_imu.reproduction.wheelchair.sample_study import PARTS, sample_checksum

RECORD = "wheelmove_sample"


def sample_numbers(part: str) -> dict[str, Any]:
    """Recorded numbers of one part; where the sample is, they are computed again and compared.

    Parameters
    ----------
    part : a key of :data:`~mobility_imu.reproduction.wheelchair.sample_study.PARTS`

    Returns
    -------
    dict, as the part's function describes it

    Raises
    ------
    InputError
        If the sample that is here is another one, or gives another number than the record.
    """
    recorded: dict[str, Any] = load_record(RECORD)["numbers"]
    folder = sample_folder()
    if folder is not None:
        if sample_checksum(folder) != recorded["sample_sha256"]:
            raise InputError(
                f"{folder}: its files are not those of the recorded sample; "
                "data/README.md says where the sample is to be had"
            )
        for name, value, _ in differing(PARTS[part](folder), recorded[part], partial=True):
            raise InputError(
                f"record {RECORD}, {part}.{name}: the sample gives {value}; renew the record"
            )
    return dict(recorded[part])


def sample_note() -> str:
    """Where the recorded numbers come from, for the pages that show them.

    Returns
    -------
    str of three lines with date, checksum of the sample and command
    """
    record = load_record(RECORD)
    checked = "no" if sample_folder() is None else "yes"
    return (
        f"Recorded on {record['date']} from the public sample "
        f"(SHA-256 {record['numbers']['sample_sha256'][:12]}…)\n"
        f"by {record['command']}\n"
        f"Computed again and compared where the sample is; here: {checked}."
    )
