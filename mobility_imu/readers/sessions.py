"""Folders and archives that hold one session: a file per sensor, or a file per quantity."""

from __future__ import annotations

import os
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path, PurePosixPath

from mobility_imu.errors import InputError
from mobility_imu.readers.kinds import EXPORT, is_plain, of_archive, what_to_do
from mobility_imu.readers.phyphox import EVENTS, is_phyphox, read_phyphox
from mobility_imu.readers.sensor_logger import is_sensor_logger, read_sensor_logger
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import EmptyFile, decoded, read_text
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.readers.xio import is_xio, read_xio

try:
    from lzma import LZMAError
except ImportError:  # a Python that was built without it unpacks no such archive
    LZMAError = zipfile.BadZipFile  # type: ignore[misc, assignment]

LARGEST_MEMBER = 500_000_000
"""Bytes of one file in an archive; more is no recording: 8 hours at 100 Hz with
rows of 150 characters are 430 million."""
MOST_FILES = 200
"""Tables in a folder whose beginnings are read; more are a study. Set by hand."""
DAMAGED = (zipfile.BadZipFile, EOFError, zlib.error, LZMAError)
"""Errors of an archive that is not as it was written."""
LONGEST_BEGINNING = 1000
"""Bytes by which a file is known that is no archive."""
LOCKED = 1
"""Flag of a file in an archive that needs a password (APPNOTE.TXT, section 4.4.4, bit 0)."""
UNNAMED = ("", "..")
"""Last parts of paths that are no names: the current folder, and the one above."""
UNPACK = "; unpack it and give the folder"
XIO_FILES = ("sensors.csv", "Inertial.csv")
PHONES = {
    "Sensor Logger": (is_sensor_logger, read_sensor_logger),
    "phyphox": (is_phyphox, read_phyphox),
}


class NoSession(InputError):
    """A folder or archive without anything that is known as a session."""


def read_session(path: Path, asked: Asked) -> tuple[str, tuple[Stream, ...]]:
    """Sensors of a folder or a ``.zip``.

    Known are sessions of x-io (a folder for each sensor, with ``sensors.csv`` or
    ``Inertial.csv``; one such folder by itself) and exports of Sensor Logger and phyphox.

    Recordings of x-io with one sensor each, side by side, look like one session: a warning names
    the folders that were taken as such.

    Parameters
    ----------
    path : folder or archive
    asked : what the user says

    Returns
    -------
    name : of the format
    streams : tuple of Stream, labelled by their folders

    Raises
    ------
    InputError
        If it is no such session, or holds several recordings that can be told apart.
    """
    names, read = _opened(path)
    source = str(path) if path.name in UNNAMED else path.name
    texts: dict[str, str] = {}

    def text(name: str) -> str:
        if name not in texts:
            texts[name] = read(name)
        return texts[name]

    inertial = [n for n in names if PurePosixPath(n).name in XIO_FILES and is_xio(_head(text(n)))]
    recordings = [("x-io", session) for session in _xio_sessions(inertial)]
    of_xio = {PurePosixPath(name).parent for name in inertial}
    folders: dict[PurePosixPath, list[str]] = {}
    for name in names:
        folder = PurePosixPath(name).parent
        if name.lower().endswith(".csv") and folder not in of_xio:
            folders.setdefault(folder, []).append(name)
    if sum(map(len, folders.values())) > MOST_FILES:
        raise InputError(
            f"{path}: {sum(map(len, folders.values()))} files; expected the folder of one recording"
        )
    for folder, tables in folders.items():
        heads = [_head(_or_empty(text, name)) for name in tables]
        known = [form for form, (begins, _) in PHONES.items() if any(map(begins, heads))]
        recordings += [(form, folder) for form in known[:1]]
    if len(recordings) > 1:
        found = listed(f"{folder} ({form})" for form, folder in recordings)
        raise InputError(
            f"{path}: holds {len(recordings)} recordings: {found}; give one of these folders by "
            "itself, with no other recording in it"
        )
    if inertial:
        streams = []
        for name in inertial:
            label = PurePosixPath(name).parent.name or own_name(path).stem
            (stream,) = read_xio(text(name), f"{source}/{name}", asked)
            streams.append(stream.called(label))
        if len(streams) > 1 and not asked.own_clocks:
            said = (
                f"{path}: sensors in {listed(str(folder) for folder in sorted(of_xio))} taken as "
                "one session on one clock; if they are recordings of their own, give one of these "
                "folders by itself"
            )
            streams[0] = replace(streams[0], warnings=(*streams[0].warnings, said))
        return "x-io session", tuple(streams)
    if recordings:
        form, folder = recordings[0]
        files = {PurePosixPath(name).stem: _or_empty(text, name) for name in folders[folder]}
        events = folder / f"{EVENTS}.csv"
        files |= {EVENTS: _or_empty(text, str(events))} if str(events) in names else {}
        read_phone = PHONES[form][1]
        return form, read_phone({k: v for k, v in files.items() if v.strip()}, source, asked)
    raise _no_session(path, names)


def _no_session(path: Path, names: list[str]) -> InputError:
    """Error for a folder or archive that holds nothing known; it says what is there."""
    kind = "" if path.is_dir() else of_archive(names)
    if kind:
        return InputError(f"{path}: is {kind}; {EXPORT}")
    held = sorted(names) or [f"{p.name}/" for p in sorted(path.glob("*/"))]
    do = "" if path.is_dir() or not held else "; unpack it and give what is in it"
    return NoSession(
        f"{path}: is a folder or archive without a session that is known (x-io, Sensor Logger, "
        f"phyphox); it holds {listed(held) or 'nothing'}{do}"
    )


def _xio_sessions(inertial: list[str]) -> list[PurePosixPath]:
    """Folders of the sessions of x-io's files: each sensor's folder lies in its session's."""
    sensors = {PurePosixPath(name).parent for name in inertial}
    sessions = set()
    for folder in sensors:
        # A sensor's folder within another's is a recording of its own.
        nested = any(folder in other.parents or other in folder.parents for other in sensors)
        sessions.add(folder if nested else folder.parent)
    return sorted(sessions)


def _opened(path: Path) -> tuple[list[str], Callable[[str], str]]:
    """Names of the files of a session, and a function that reads one."""
    if path.is_dir():
        if not os.access(path, os.R_OK | os.X_OK):
            raise InputError(f"{path}: the folder cannot be read (no permission)")
        names = [p.relative_to(path).as_posix() for p in session_files(path)]
        return [name for name in names if not _is_hidden(name)], lambda name: read_text(path / name)
    try:
        with zipfile.ZipFile(path) as archive:
            packed = [i.filename for i in archive.infolist() if i.filename and not i.is_dir()]
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: cannot be opened as an archive (the name of a file in it is not in UTF-8, as "
            f"it is marked){UNPACK}"
        ) from None
    except (OSError, ValueError, OverflowError, *DAMAGED, NotImplementedError) as error:
        other = _what_else(path)
        if other:
            raise InputError(f"{path}: {other}") from None
        raise InputError(
            f"{path}: cannot be opened as an archive ({error}); is it complete?"
        ) from None

    # Some programs of Windows write its separator, against the format.
    windows = not any("/" in name for name in packed)
    called = [name.replace("\\", "/") if windows else name for name in packed]
    members = {name: own for name, own in zip(called, packed, strict=True) if not _is_hidden(name)}
    often = Counter(called)

    def content(name: str) -> str:
        if often[name] > 1:
            raise InputError(
                f"{path}: holds two files called {quoted(name)}{UNPACK} with the one that is meant"
            )
        try:
            with zipfile.ZipFile(path) as archive:
                member = archive.getinfo(members[name])
                if member.file_size > LARGEST_MEMBER:
                    raise InputError(f"{path}/{quoted(name)}: too large for a recording")
                if member.flag_bits & LOCKED:
                    raise InputError(f"{path}/{quoted(name)}: is locked with a password{UNPACK}")
                return decoded(archive.read(member), f"{path}/{quoted(name)}")
        except InputError:
            raise
        except (OSError, ValueError, RuntimeError, OverflowError, *DAMAGED) as error:
            # What another program can unpack: a kind of packing that is not known here.
            do = UNPACK if isinstance(error, NotImplementedError) else ""
            raise InputError(
                f"{path}/{quoted(name)}: cannot be read ({quoted(str(error), 100)}){do}"
            ) from None

    return list(members), content


def _what_else(path: Path) -> str:
    """What a file is under the name of an archive, and what to do; empty if that is not known."""
    try:
        with path.open("rb") as file:
            raw = file.read(LONGEST_BEGINNING)
    except (OSError, ValueError):
        return ""
    if raw.startswith(b"PK"):
        return ""
    if not raw.strip():
        return "the file is empty"
    return what_to_do(raw) or ("is a text, no archive; rename it to .csv" if is_plain(raw) else "")


def own_name(path: Path) -> Path:
    """Path, or the folder's own name where it is typed as ``.`` or ``..``.

    Parameters
    ----------
    path : any path

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the current folder was removed, so that it has no name.
    """
    if path.name not in UNNAMED:
        return path
    try:
        return Path(path.resolve().name or path)
    except OSError:
        raise InputError(
            f"{path}: the current folder does not exist any more; change to one that does"
        ) from None


def _is_hidden(name: str) -> bool:
    """Whether a file belongs to the computer it was on, as those that macOS packs with others."""
    return any(part.startswith(".") or part == "__MACOSX" for part in PurePosixPath(name).parts)


def _or_empty(text: Callable[[str], str], name: str) -> str:
    """Content of a file; an app's empty file is no fault."""
    try:
        return text(name)
    except EmptyFile:
        return ""


def _head(text: str) -> str:
    return text.lstrip().partition("\n")[0]


def is_session(path: Path) -> bool:
    """Whether a path is a folder or an archive.

    Parameters
    ----------
    path : any path

    Returns
    -------
    bool
    """
    try:
        return path.is_dir() or (path.suffix.lower() == ".zip" and path.is_file())
    except (OSError, ValueError):
        return False


def session_files(path: Path) -> list[Path]:
    """Files that reading a session opens, so that no output replaces one.

    Parameters
    ----------
    path : folder or archive

    Returns
    -------
    list of Path
    """
    if not path.is_dir():
        return [path]
    found = [*path.glob("*"), *path.glob("*/*"), *path.glob(f"*/{EVENTS}.csv")]
    return [p for p in sorted(found) if is_regular(p)]


def is_regular(path: Path) -> bool:
    """Whether a path is a file that can be looked at unasked: a pipe may never end.

    Parameters
    ----------
    path : any path

    Returns
    -------
    bool
    """
    try:
        return path.is_file()
    except (OSError, ValueError):  # a folder that may be listed, but not entered
        return False


__all__ = ["NoSession", "is_regular", "is_session", "own_name", "read_session", "session_files"]
