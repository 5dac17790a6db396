"""How commands read recordings: with what the user says of files that do not say it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mobility_imu.cli.messages import warn
from mobility_imu.errors import InputError

if TYPE_CHECKING:
    from mobility_imu.faults import Fault
    from mobility_imu.frames import FloatArray
    from mobility_imu.recording import Recording

LARGEST_MOUNT_SD_RAD = 0.3
"""Median standard deviation of a mount's turns from which on it may be in degrees: calibrations
find 0.003 to 0.03 rad. Set by hand."""
SENSORS = {
    "scooter": ("lever", "body"),
    "wheelchair": ("frame", "left_wheel", "right_wheel"),
    "walker": ("frame",),
}
"""Names of the sensors that each device's commands use, in the order of a file without names."""


def read_input(
    path: Path,
    device: str,
    sampling_rate_hz: float | None,
    fill_gaps_s: float = 0.0,
) -> Recording:
    """Recording for a command of a device.

    A command finds the faults of the sensors that it uses and tells them, or refuses the recording,
    with :func:`tell_faults`.

    Parameters
    ----------
    path : as typed
    device : "scooter", "wheelchair" or "walker"
    sampling_rate_hz : of ``--sampling-rate-hz``
    fill_gaps_s : of ``--fill-gaps-s``

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        What reading refuses, and a sensor that stands for two.
    """
    from mobility_imu.health import examine
    from mobility_imu.readers import read_recording

    check_reading(sampling_rate_hz, fill_gaps_s)
    recording = read_recording(
        path,
        sampling_rate_hz=sampling_rate_hz,
        fill_gaps_s=fill_gaps_s,
        expected=SENSORS[device],
    )
    said = []
    # Of three equal sensors only the first is compared: without it the others are looked at again.
    while copies := [found for found in examine(recording) if found.code == "copy"]:
        recording, left = _without_copy(recording, copies[0], SENSORS[device])
        said.append(left)
    warn(said)
    return recording


def _without_copy(
    recording: Recording, copy: Fault, needed: Sequence[str]
) -> tuple[Recording, str]:
    """Recording without a copy that is not needed, and a warning; an error if both are needed."""
    from dataclasses import replace

    *_, other = copy.sensor.split(", ")
    first = copy.sensor.removesuffix(f", {other}")
    if other in needed:
        first, other = other, first
    if other in needed:
        raise InputError(copy.sentence)
    sensors = {name: imu for name, imu in recording.sensors.items() if name != other}
    said = f"{recording.source}: {other} repeats {first} and is left out: it is not needed"
    return replace(recording, sensors=sensors), said


def check_reading(sampling_rate_hz: float | None, fill_gaps_s: float = 0.0) -> None:
    """Check the options with which recordings are read; messages name the option.

    Parameters
    ----------
    sampling_rate_hz : of ``--sampling-rate-hz``
    fill_gaps_s : of ``--fill-gaps-s``

    Raises
    ------
    InputError
        If a value is impossible.
    """
    from mobility_imu.readers.clocks import check_fill, check_rate

    if sampling_rate_hz is not None:
        check_rate(sampling_rate_hz, "--sampling-rate-hz")
    with as_typed({"gaps to be filled up to ": "--fill-gaps-s: gaps of up to "}):
        check_fill(fill_gaps_s)


@contextmanager
def as_typed(words: Mapping[str, str]) -> Iterator[None]:
    """Name settings as the user typed them where the library refuses their values.

    Parameters
    ----------
    words : beginnings of the library's messages, such as "median_window = ", to what takes their
        place, such as "--median-window "

    Raises
    ------
    InputError
        The same message in these words.
    """
    try:
        yield
    except InputError as error:
        raise InputError(in_words(str(error), words)) from error


def in_words(text: str, words: Mapping[str, str]) -> str:
    """Sentence of the library in the words of the command line.

    Parameters
    ----------
    text : message or warning
    words : as for :func:`as_typed`

    Returns
    -------
    str
    """
    for ours, typed in words.items():
        text = text.replace(ours, typed)
    return text


def sd_in_degrees(path: Path, what: str, sd_rad: FloatArray | None) -> list[str]:
    """Warning of a mount whose turns are known so badly that degrees may be meant.

    Parameters
    ----------
    path : geometry file
    what : section and key
    sd_rad : (k,) array, rad, as the file has it, or None

    Returns
    -------
    list of str, with one sentence or none
    """
    import numpy as np

    if sd_rad is None or np.median(sd_rad) <= LARGEST_MOUNT_SD_RAD:
        return []
    return [
        f"{path}, {what} states {np.rad2deg(np.median(sd_rad)):.0f} deg (median), more than a "
        "calibration leaves: are the numbers in degrees? Write them in rad"
    ]


def tell_faults(faults: Sequence[Fault], strict: bool) -> None:
    """Warn of each fault with what it costs, or refuse the recording.

    Parameters
    ----------
    faults : as a device's ``find_faults`` found them
    strict : of ``--strict``

    Raises
    ------
    InputError
        With ``strict``, the first fault's sentence.
    """
    if strict and faults:
        raise InputError(faults[0].sentence)
    warn(fault.told for fault in faults)


MOST_NAMED = 2
"""Faults that an error names: it is one line."""


@contextmanager
def naming(faults: Sequence[Fault]) -> Iterator[None]:
    """Name the faults that were found where the estimate refuses the recording.

    The estimate sees only that the readings contradict each other, and guesses at a usual cause.

    Parameters
    ----------
    faults : of the same recording

    Raises
    ------
    InputError
        Sentences of the faults, then that of the estimate.
    """
    try:
        yield
    except InputError as error:
        if not faults:
            raise
        named = [fault.sentence for fault in faults[:MOST_NAMED]]
        more = [f"{len(faults) - MOST_NAMED} more fault(s)"] if len(faults) > MOST_NAMED else []
        raise InputError(f"{'; '.join([*named, *more])}; the estimate refuses: {error}") from error
