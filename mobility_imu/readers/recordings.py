"""Recordings of IMUs, in whatever format: one file, several, a folder or an archive."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mobility_imu.errors import InputError
from mobility_imu.files import as_path
from mobility_imu.readers.clocks import check_fill, check_rate, one_clock
from mobility_imu.readers.column_map import read_mapped
from mobility_imu.readers.formats import find_format
from mobility_imu.readers.sessions import is_session, read_session, session_files
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import read_text
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.readers.xsens_mt import is_xsens_mt, join_exports, parse_export
from mobility_imu.recording import Recording
from mobility_imu.results import Result

SENSOR_WORDS = {
    "left_wheel": ("left", "gauche", "izquierda", "links"),
    "right_wheel": ("right", "droite", "derecha", "rechts"),
    "frame": ("frame", "chassis", "chasis", "rahmen"),
    "lever": ("lever", "throttle", "levier"),
    "body": ("body", "tiller", "scooter"),
}
"""Words in a file's or folder's name, or in a vendor's label, that tell which sensor it is."""
DEVICES = (("frame", "left_wheel", "right_wheel"), ("lever", "body"))
MOST_SENSORS = 12


@dataclass(frozen=True, eq=False, repr=False)
class Reading(Result):
    """A recording, and what was understood of its file.

    Parameters
    ----------
    recording : Recording
    format : name of the format
    labels : sensor name to what the file calls it
    rate_from : where the sampling rate comes from
    warnings : what was left out, reversed, interpolated or found odd
    """

    recording: Recording
    format: str
    labels: Mapping[str, str]
    rate_from: str
    warnings: tuple[str, ...] = field(default=(), kw_only=True)


def read_recording(
    path: str | Path,
    *,
    sampling_rate_hz: float | None = None,
    fill_gaps_s: float = 0.0,
    expected: Sequence[str] = (),
) -> Recording:
    """Read a recording in any format that the package knows; warnings say what was odd.

    Parameters
    ----------
    path : a file, a folder or archive of a session, the common beginning of the names of several
        Xsens exports (``Trial`` for ``Trial-Frame.txt``, ``Trial-LeftWheel.txt``, ...), or several
        files as ``lever=a.csv,body=b.csv``
    sampling_rate_hz : Hz, for formats without a clock; such a file is refused without it
    fill_gaps_s : gaps up to this length are filled by linear interpolation; 0 refuses any gap
    expected : names of sensors that are wanted; a sensor without a telling name gets them in order

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        Unknown format, missing columns, a rate or unit that nobody states, and whatever
        :class:`~mobility_imu.recording.Recording` refuses.
    """
    found = understand(
        path,
        sampling_rate_hz=sampling_rate_hz,
        fill_gaps_s=fill_gaps_s,
        expected=expected,
    )
    for sentence in found.warnings:
        warnings.warn(sentence, stacklevel=2)
    return found.recording


def understand(
    path: str | Path,
    *,
    sampling_rate_hz: float | None = None,
    fill_gaps_s: float = 0.0,
    expected: Sequence[str] = (),
    map_path: str | Path | None = None,
) -> Reading:
    """Read a recording as :func:`read_recording` does, and say what was understood.

    Parameters
    ----------
    path, sampling_rate_hz, fill_gaps_s, expected : as in :func:`read_recording`
    map_path : TOML file that says which column is what, for tables of no known format
        (:mod:`mobility_imu.readers.column_map`)

    Returns
    -------
    Reading

    Raises
    ------
    InputError
        As :func:`read_recording`.
    """
    source = str(path)
    if sampling_rate_hz is not None:
        check_rate(sampling_rate_hz, source)
    check_fill(fill_gaps_s)
    form, streams, are_named = _streams(path, Asked(sampling_rate_hz), map_path)
    named, said = _named(streams, expected, source, are_named=are_named)
    recording, found = one_clock(named, source, fill_gaps_s=fill_gaps_s)
    return Reading(
        recording,
        form,
        {name: stream.label for name, stream in named.items()},
        ", ".join(dict.fromkeys(stream.rate_from for stream in streams)),
        warnings=(*said, *found),
    )


def _streams(
    path: str | Path, asked: Asked, map_path: str | Path | None
) -> tuple[str, tuple[Stream, ...], bool]:
    """Format and sensors of everything that a path names, and whether these bear our names."""
    whole = as_path(path)
    several = None if _is_there(whole) or is_session(whole) else _pairs(str(path))
    if several:
        forms: list[str] = []
        streams: list[Stream] = []
        for sensor, file in several:
            file, label = _file_and_label(file)
            form, found, _ = _streams(file, asked, map_path)
            if label is not None:
                found = tuple(stream for stream in found if stream.label == label)
            if len(found) != 1:
                raise InputError(
                    f"{file}: {len(found)} sensors, expected one for '{sensor}'; name it as in "
                    f"{sensor}={file}#LABEL"
                )
            forms.append(form)
            streams.append(found[0].called(sensor))
        return ", ".join(dict.fromkeys(forms)), tuple(streams), True
    if map_path is not None:
        return "mapped CSV", read_mapped(read_text(whole), str(path), map_path), True
    if not _is_there(whole):
        if is_session(whole):
            return (*read_session(whole, asked), False)
        parts = _xsens_parts(whole)
        if parts:
            exports = {
                name: parse_export(read_text(file), str(file)) for name, file in parts.items()
            }
            return "Xsens MT Manager", join_exports(exports, asked), True
        what = "is a folder" if _is_folder(whole) else "no such file"
        raise InputError(f"{path}: {what}, and no Xsens exports whose names begin like this")
    if is_session(whole):
        return (*read_session(whole, asked), False)
    text = read_text(whole)
    known = find_format(text, str(path))
    return known.name, known.read(text, str(path), asked), known.names_sensors


def _pairs(text: str) -> list[tuple[str, str]]:
    """Sensors and files of ``lever=a.csv,body=b.csv``; empty if a text is nothing like it."""
    parts = text.split(",")
    found = [re.fullmatch(r"(\w+)=(.+)", part) for part in parts]
    if not all(found) or len(parts) > MOST_SENSORS:
        return []
    pairs = [(match[1], match[2]) for match in found if match]
    names = [name for name, _ in pairs]
    if len(set(names)) < len(names):
        raise InputError(f"{quoted(text)}: a sensor is named twice")
    return pairs


def _file_and_label(text: str) -> tuple[str, str | None]:
    """File and sensor of ``session.csv#Lumbar``; a file whose own name has the mark is itself."""
    if "#" not in text or _is_there(as_path(text)):
        return text, None
    file, _, label = text.rpartition("#")
    return file, label


def _named(
    streams: Sequence[Stream], expected: Sequence[str], source: str, *, are_named: bool
) -> tuple[dict[str, Stream], tuple[str, ...]]:
    """Sensors under the names that the devices' commands know."""
    names: list[str | None] = [s.label if are_named else _by_words(s.label) for s in streams]
    said = []
    if len(streams) == 1 and not are_named and len(expected) <= 1:
        ours = expected[0] if expected else names[0] or "frame"
        if names[0] not in (None, ours):
            said.append(f"{source}: '{quoted(streams[0].label)}' taken as {ours}")
        names[0] = ours
    open_names = [name for name in expected if name not in names]
    unnamed = [k for k, name in enumerate(names) if name is None]
    # A scooter's two sensors, or one of them, may be taken in their order; a chair's may not.
    if unnamed and len(unnamed) <= len(open_names) and tuple(expected) == DEVICES[1]:
        for k, name in zip(unnamed, open_names, strict=False):
            names[k] = name
        if len(streams) > 1:
            told = (f"'{quoted(streams[k].label)}' as {names[k]}" for k in unnamed)
            said.append(f"{source}: sensors taken in their order: {', '.join(told)}")
    elif not expected and (unnamed or len(set(names)) < len(names)):
        # Nothing is asked of the names: the file's own will do.
        names = [
            re.sub(r"\W+", "_", stream.label).strip("_") or f"sensor_{k + 1}"
            for k, stream in enumerate(streams)
        ]
    for k, given in enumerate(names):
        if given is None:
            label = streams[k].label or streams[k].source
            raise InputError(
                f"{source}: which sensor is '{quoted(label)}' (of "
                f"{listed(s.label or s.source for s in streams)})? Give them as "
                f"{','.join(f'{n}=FILE#LABEL' for n in expected)}"
            )
        if names.count(given) > 1:
            both = [s.label or s.source for s, n in zip(streams, names, strict=True) if n == given]
            raise InputError(f"{source}: two files for the {given} sensor, {listed(both)}")
    return {str(name): stream for name, stream in zip(names, streams, strict=True)}, tuple(said)


def _by_words(label: str) -> str | None:
    """Sensor that a label names by one of the known words."""
    lower = label.lower()
    found = [name for name, words in SENSOR_WORDS.items() if any(word in lower for word in words)]
    return found[0] if len(found) == 1 else None


def recording_files(path: str | Path) -> list[Path]:
    """Files that :func:`read_recording` opens for a name.

    Parameters
    ----------
    path : as in :func:`read_recording`

    Returns
    -------
    list of Path, empty if there is no such recording
    """
    whole = as_path(path)
    if is_session(whole):
        return session_files(whole)
    if _is_there(whole):
        return [whole]
    pairs = _pairs(str(path))
    files: Iterable[Path] = (
        [f for _, name in pairs for f in recording_files(_file_and_label(name)[0])]
        if pairs
        else _xsens_parts(whole).values()
    )
    return list(files)


def _is_there(path: Path) -> bool:
    """Whether a file can be looked at under this name; folders begin names of Xsens exports."""
    try:
        return path.exists() and not path.is_dir()
    except (OSError, ValueError):  # a name that is too long, a folder that may not be entered
        return False


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def _xsens_parts(prefix: Path) -> dict[str, Path]:
    """Text exports whose names begin like this, by the sensor that the rest of the name tells."""
    try:
        if not prefix.parent.is_dir() or not prefix.name:
            return {}
        exports = sorted(prefix.parent.glob("*.txt"))
    except (OSError, ValueError):
        return {}
    begin_alike = [p for p in exports if p.stem.startswith(prefix.name)]
    parts: dict[str, Path] = {}
    for path in begin_alike:
        sensor = _by_words(path.stem[len(prefix.name) :])
        if sensor is None:
            continue
        if sensor in parts:
            raise InputError(
                f"{prefix}: two files for the {sensor} sensor, {parts[sensor].name} and {path.name}"
            )
        parts[sensor] = path
    if not parts and len(begin_alike) == 1 and is_xsens_mt(_first_line(begin_alike[0])):
        return {"frame": begin_alike[0]}
    if not parts and begin_alike:
        raise InputError(
            f"{prefix}: {listed(p.name for p in begin_alike)} begin like this; give them as "
            f"{','.join(f'{name}=FILE' for name in DEVICES[0])}"
        )
    return parts


def _first_line(path: Path) -> str:
    return read_text(path).partition("\n")[0]
