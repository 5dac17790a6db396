"""Folders and archives that hold one session: a file per sensor, or a file per quantity."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path, PurePosixPath

from mobility_imu.errors import InputError
from mobility_imu.readers.phyphox import is_phyphox, read_phyphox
from mobility_imu.readers.sensor_logger import is_sensor_logger, read_sensor_logger
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import decoded, read_text
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.readers.xio import is_xio, read_xio

LARGEST_MEMBER = 500_000_000
"""Bytes of one file in an archive; more is no recording."""
MOST_FILES = 200
XIO_FILES = ("sensors.csv", "Inertial.csv")


def read_session(path: Path, asked: Asked) -> tuple[str, tuple[Stream, ...]]:
    """Sensors of a folder or a ``.zip``.

    Known are sessions of x-io (a folder for each sensor, with ``sensors.csv`` or
    ``Inertial.csv``; one such folder by itself) and exports of Sensor Logger and phyphox.

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
        If it is no such session.
    """
    names, read = _opened(path)
    texts: dict[str, str] = {}

    def text(name: str) -> str:
        if name not in texts:
            texts[name] = read(name)
        return texts[name]

    inertial = [n for n in names if PurePosixPath(n).name in XIO_FILES and is_xio(_head(text(n)))]
    if inertial:
        streams = []
        for name in inertial:
            label = PurePosixPath(name).parent.name or path.stem
            (stream,) = read_xio(text(name), f"{path.name}/{name}", asked)
            streams.append(stream.called(label))
        return "x-io session", tuple(streams)
    tables = {PurePosixPath(n).stem: n for n in names if n.lower().endswith(".csv")}
    if len(tables) > MOST_FILES:
        raise InputError(f"{path}: {len(tables)} files; expected the folder of one recording")
    for form, begins, reader in (
        ("Sensor Logger", is_sensor_logger, read_sensor_logger),
        ("phyphox", is_phyphox, read_phyphox),
    ):
        known = [stem for stem, name in tables.items() if begins(_head(_or_empty(text, name)))]
        if known:
            files = {stem: _or_empty(text, name) for stem, name in tables.items()}
            return form, reader({k: v for k, v in files.items() if v.strip()}, path.name, asked)
    raise InputError(
        f"{path}: is a folder or archive without a session that is known (x-io, Sensor Logger, "
        f"phyphox); it holds {listed(sorted(names)) or 'nothing'}"
    )


def _opened(path: Path) -> tuple[list[str], Callable[[str], str]]:
    """Names of the files of a session, and a function that reads one."""
    if path.is_dir():
        files = [p for p in sorted([*path.glob("*"), *path.glob("*/*")]) if p.is_file()]
        names = [p.relative_to(path).as_posix() for p in files]
        return names, lambda name: read_text(path / name)
    try:
        with zipfile.ZipFile(path) as archive:
            names = [i.filename for i in archive.infolist() if not i.is_dir()]
    except (OSError, zipfile.BadZipFile, NotImplementedError) as error:
        raise InputError(f"{path}: cannot be opened as an archive ({error})") from None

    def member(name: str) -> str:
        try:
            with zipfile.ZipFile(path) as archive:
                if archive.getinfo(name).file_size > LARGEST_MEMBER:
                    raise InputError(f"{path}/{quoted(name)}: too large for a recording")
                return decoded(archive.read(name), f"{path}/{quoted(name)}")
        except (OSError, zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
            raise InputError(f"{path}/{quoted(name)}: cannot be read ({error})") from None

    return names, member


def _or_empty(text: Callable[[str], str], name: str) -> str:
    """Content of a file; an app's empty file is no fault."""
    try:
        return text(name)
    except InputError:
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
    return [p for p in sorted([*path.glob("*"), *path.glob("*/*")]) if p.is_file()]


__all__ = ["is_session", "read_session", "session_files"]
