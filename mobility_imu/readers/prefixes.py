"""Exports of MT Manager that the common beginning of their names names, and words for sensors."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from mobility_imu.errors import InputError
from mobility_imu.readers.sessions import is_regular
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import read_text
from mobility_imu.readers.wording import listed
from mobility_imu.readers.xsens_mt import is_xsens_mt, join_exports, parse_export

SENSOR_WORDS = {
    "left_wheel": ("left", "gauche", "izquierda", "links"),
    "right_wheel": ("right", "droite", "derecha", "rechts"),
    "frame": ("frame", "chassis", "chasis", "rahmen"),
    "lever": ("lever", "throttle", "levier"),
    "body": ("body", "tiller", "scooter"),
}
"""Words in a file's or folder's name, or in a vendor's label, that tell which sensor it is."""
DEVICES = (("frame", "left_wheel", "right_wheel"), ("lever", "body"))


def by_words(label: str) -> str | None:
    """Sensor that a label names by one of the known words.

    Parameters
    ----------
    label : name of a sensor, file or folder, with or without accents

    Returns
    -------
    str; None if it has no word of a sensor, or words of two

    Examples
    --------
    >>> by_words("Essai-Châssis"), by_words("00B421AF")
    ('frame', None)
    """
    lower = _plain(label)
    found = [name for name, words in SENSOR_WORDS.items() if any(word in lower for word in words)]
    return found[0] if len(found) == 1 else None


def _plain(text: str) -> str:
    """Text in small letters without accents."""
    apart = unicodedata.normalize("NFKD", text.lower())
    return "".join(char for char in apart if not unicodedata.combining(char))


def xsens_parts(prefix: Path, *, strict: bool = True) -> dict[str, Path]:
    """Text exports whose names begin like this, by the sensor that the rest of the name tells.

    Parameters
    ----------
    prefix : folder and beginning of the names
    strict : whether files that begin like this and cannot be told apart are an error

    Returns
    -------
    sensor name to file; empty if there are none

    Raises
    ------
    InputError
        If two files are for one sensor, the files are of several trials, or no name tells a sensor.
    """
    try:
        return _parts(prefix)
    except InputError:
        if strict:
            raise
        return {}


def _parts(prefix: Path) -> dict[str, Path]:
    begin_alike = _begin_alike(prefix)
    parts: dict[str, Path] = {}
    for path in begin_alike:
        sensor = by_words(path.stem[len(prefix.name) :])
        if sensor is None:
            continue
        if sensor in parts:
            raise InputError(
                f"{prefix}: two files for the {sensor} sensor, {parts[sensor].name} and "
                f"{path.name}; give them as {','.join(f'{name}=FILE' for name in DEVICES[0])}"
            )
        parts[sensor] = path
    if not parts and len(begin_alike) == 1 and is_xsens_mt(first_line(begin_alike[0])):
        return {"frame": begin_alike[0]}
    if not parts and begin_alike:
        raise InputError(
            f"{prefix}: {listed(p.name for p in begin_alike)} begin like this; give them as "
            f"{','.join(f'{name}=FILE' for name in DEVICES[0])}"
        )
    return parts


def of_one_prefix(prefix: Path, parts: Mapping[str, Path], asked: Asked) -> tuple[Stream, ...]:
    """Sensors of exports whose names begin alike; a warning names those that are not used.

    Parameters
    ----------
    prefix : folder and beginning of the names
    parts : sensor name to file, of :func:`xsens_parts`
    asked : with the sampling rate, if the files do not state it

    Returns
    -------
    tuple of Stream, all with the same times

    Raises
    ------
    InputError
        As :func:`~mobility_imu.readers.xsens_mt.join_exports`.
    """
    exports = {name: parse_export(read_text(file), str(file)) for name, file in parts.items()}
    streams = join_exports(exports, asked)
    others = [file for file in _begin_alike(prefix) if file not in parts.values()]
    unknown = [file.name for file in others if _is_export(file)]
    if not unknown:
        return streams
    said = f"{prefix}: not used, since no word for a sensor is in the name: {listed(unknown)}"
    return (replace(streams[0], warnings=(*streams[0].warnings, said)), *streams[1:])


def exports_in(folder: Path) -> str:
    """End of a message: how exports of MT Manager in a folder are named.

    Parameters
    ----------
    folder : any path

    Returns
    -------
    str, empty if there are none
    """
    begins: dict[str, None] = {}
    for file in filter(is_regular, sorted(_texts(folder))):
        stem = _plain(file.stem)
        words = [stem.find(w) for found in SENSOR_WORDS.values() for w in found if w in stem]
        if words and _is_export(file):
            begins[re.sub(r"[\W_]*$", "", file.stem[: min(words)])] = None
    names = [name for name in begins if name]
    if not names:
        return ""
    return (
        f"; exports of MT Manager are given by the beginning of their names, as {folder}/{names[0]}"
        + (f" (also {listed(names[1:])})" if names[1:] else "")
    )


def _texts(folder: Path) -> list[Path]:
    """Paths of a folder that end in .txt, or .TXT as some systems write it."""
    return [path for path in folder.glob("*") if path.suffix.lower() == ".txt"]


def _begin_alike(prefix: Path) -> list[Path]:
    """Text files of one trial whose names begin like this.

    They have the same number, or none, between the beginning and the word for the sensor.
    """
    try:
        if not prefix.parent.is_dir() or not prefix.name:
            return []
        alike = (p for p in _texts(prefix.parent) if p.stem.startswith(prefix.name))
        files = sorted(filter(is_regular, alike))
    except (OSError, ValueError):
        return []
    trials: dict[tuple[str, ...], list[Path]] = {}
    whole = True
    for path in files:
        rest = _plain(path.stem[len(prefix.name) :])
        if prefix.name[-1].isdigit() and rest[:1].isdigit():
            continue  # trial 10 is not trial 1
        words = [rest.find(w) for found in SENSOR_WORDS.values() for w in found if w in rest]
        before = rest[: min(words, default=len(rest))].replace("_", "-")
        numbers = re.findall(r"\d+", re.sub(r"\b[0-9a-f]{8}\b", "", before))  # not a serial number
        trials.setdefault(tuple(numbers), []).append(path)
        whole &= bool(numbers) or not rest[:1].isalnum()
    if len(trials) > 1 and not (whole and () in trials):
        several = listed(path.name for paths in trials.values() for path in paths)
        raise InputError(f"{prefix}: several trials begin like this ({several}); name one of them")
    return trials.get((), next(iter(trials.values()), []))


def _is_export(neighbour: Path) -> bool:
    """Whether a file that nobody named is an export; one that cannot be read is none."""
    try:
        return is_xsens_mt(first_line(neighbour))
    except InputError:
        return False


def first_line(path: Path) -> str:
    """First line of a text file.

    Parameters
    ----------
    path : the file

    Returns
    -------
    str
    """
    return read_text(path).partition("\n")[0]
