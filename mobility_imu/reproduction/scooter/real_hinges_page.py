"""What two hinged chains gave, read from the records and checked wherever the recordings are."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.differences import differing, shown
from mobility_imu.reproduction.real_files import Numbers, checksums, lacking_files
from mobility_imu.reproduction.recorded import load_record
from mobility_imu.reproduction.scooter.real_hinges import (
    ONE_HINGE,
    TWO_HINGES,
    errors_of,
    read_chain,
)

CHAINS = {"real_two_hinges": TWO_HINGES, "real_one_hinge": ONE_HINGE}
"""Records and their chains."""


class HeldBackRow(NamedTuple):
    """Errors of one angle of a recording that was held back, before and after a change.

    Parameters
    ----------
    recording : name of its file
    angle : "steering" or "throttle"
    rms_before_deg : deg, root mean square error with the assumptions of the first run
    ratio_before : stated deviation over that error
    covered_before : fraction of samples inside the 95 % interval
    rms_after_deg, ratio_after, covered_after : the same by the fusion of this package
    """

    recording: str
    angle: str
    rms_before_deg: float
    ratio_before: float
    covered_before: float
    rms_after_deg: float
    ratio_after: float
    covered_after: float


BEFORE_COMMIT = "76f893c"
"""Commit of the first run on the recordings held back; nothing had been set by them."""
# Kept as they were measured: the first run cannot be repeated unseen.
HELD_BACK = (
    HeldBackRow("trial2_rigid", "steering", 2.3, 0.82, 0.99, 2.58, 0.99, 0.99),
    HeldBackRow("trial2_rigid", "throttle", 3.8, 0.55, 0.87, 3.77, 0.74, 0.98),
    HeldBackRow("trial2_foam", "steering", 10.7, 0.50, 0.76, 8.06, 0.77, 0.90),
    HeldBackRow("trial2_foam", "throttle", 12.7, 0.44, 0.69, 8.18, 0.78, 0.88),
    HeldBackRow("roll_slow", "steering", 8.4, 0.23, 0.00, 1.99, 0.71, 0.85),
    HeldBackRow("roll_slow", "throttle", 0.75, 1.79, 1.00, 1.57, 0.88, 1.00),
    HeldBackRow("roll_medium", "steering", 6.2, 0.57, 0.91, 4.50, 1.08, 1.00),
    HeldBackRow("roll_medium", "throttle", 2.4, 0.68, 0.82, 1.81, 0.97, 1.00),
    HeldBackRow("roll_fast", "steering", 3.6, 0.46, 0.63, 7.59, 1.13, 1.00),
    HeldBackRow("roll_fast", "throttle", 5.7, 0.35, 0.50, 3.25, 0.99, 0.98),
)
"""Recordings held back, by the fusion before and after it was changed; all samples with a
reference."""
UNSMOOTHED_DEG = {
    "trial1_rigid": (1.53, 2.38), "trial1_foam": (5.71, 5.83),
    "pitch_slow": (2.69, 0.82), "pitch_medium": (1.00, 2.89),
    "trial2_rigid": (2.58, 3.81), "trial2_foam": (8.33, 8.59),
    "roll_slow": (1.54, 1.98), "roll_medium": (2.71, 1.81), "roll_fast": (6.62, 3.32),
}  # fmt: skip
"""Errors in deg, steering and throttle, by the fusion after, its accelerations not smoothed."""
ROLL_FAST_GRAVITY_MPS2 = 8.10
"""Median length of the lever's acceleration in ``roll_fast``, averaged over half a second: turns
shorten a mean."""
ROLL_FAST_RATE_DEGPS = 321.0
"""Median rate of that sensor."""
ROLL_FAST_SCALE_PERCENT = (2.8, 0.8)
"""Errors of scale of two axes of that sensor, by a fit to gravity at the encoder's angles."""
QMT_FOAM_STEERING_DEG = (4.4, 4.6)
"""Root mean square error of the peer's steering on foam, qmt 0.2.4 by ``make bench``."""
QMT_BOTH_DEG = {
    "trial1_rigid": 5.36, "trial1_foam": 9.21, "pitch_slow": 10.19, "pitch_medium": 17.91,
}  # fmt: skip
"""Root of the sum of both angles' mean square errors, from the same runs, with those of the peer's
24 settings that fit the reference best."""
WITHOUT_FIRST_SAMPLE_DEG = (4.8505, 2.2128)
"""Error and stated deviation of the steering of ``pitch_slow`` without its first sample."""
SIMULATED_BEFORE = {
    "simulated": {
        "steering": {"median_rms_deg": 1.06, "worst_rms_deg": 2.23, "covered": 1.00},
        "throttle": {"median_rms_deg": 0.35, "worst_rms_deg": 1.13, "covered": 1.00},
    },
    "simulated_as_real": {
        "steering": {"median_rms_deg": 4.98, "worst_rms_deg": 12.03, "covered": 0.56},
        "throttle": {"median_rms_deg": 1.33, "worst_rms_deg": 4.90, "covered": 0.71},
    },
}
"""What the fusion of that commit gave in the twenty simulated rides, at both levels of errors."""


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


@lru_cache(maxsize=1)
def _both() -> tuple[Numbers, ...]:
    return tuple(hinge_numbers(name) for name in CHAINS)


def of_all(kind: str) -> Numbers:
    """One part of the numbers of both chains.

    Parameters
    ----------
    kind : a part that lists recordings, such as "sensors", "spectra", "variants" or "causes"

    Returns
    -------
    dict, recording to its numbers

    Raises
    ------
    InputError
        If the records have no such part.
    """
    if not all(isinstance(numbers.get(kind), dict) for numbers in _both()):
        raise InputError(f"kind = {kind!r}: expected a part of both records that lists recordings")
    return {recording: part for numbers in _both() for recording, part in numbers[kind].items()}


def row_of(recording: str, method: str = "fusion") -> Numbers:
    """Errors of both angles of one recording by one method.

    Parameters
    ----------
    recording : name of its file
    method : "fusion" or "closed-form"

    Returns
    -------
    dict, one row of the record

    Raises
    ------
    InputError
        If no row has these names.
    """
    for row in (row for numbers in _both() for row in numbers["rows"]):
        if (row["recording"], row["method"]) == (recording, method):
            found: Numbers = row
            return found
    raise InputError(f"recording = {recording!r}, method = {method!r}: no such row is recorded")


def variant_of(recording: str, name: str) -> Numbers:
    """Errors of one recording with one of the fusion's assumptions changed.

    Parameters
    ----------
    recording : name of its file
    name : name of the variant, such as "white noise only"

    Returns
    -------
    dict, one variant of the record

    Raises
    ------
    InputError
        If no variant has these names.
    """
    for variant in of_all("variants").get(recording, ()):
        if variant["variant"] == name:
            found: Numbers = variant
            return found
    raise InputError(f"recording = {recording!r}, name = {name!r}: no such variant is recorded")


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
