"""Names of files, and output files: checked before the work begins, written all or none.

An output is a regular file or a new name. It never replaces an input of the same command, under
whatever name, nor a file that a stream of the command goes to; two outputs are never one file.
"""

from __future__ import annotations

import errno
import gzip
import io
import os
import secrets
import shutil
import stat
import unicodedata
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from mobility_imu.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)

_FORMS = {"float64": "%.6f", "bool": "%s", **dict.fromkeys(("int8", "int64"), "%d")}
"""How a number of each type is written."""
ROWS_AT_ONCE = 10_000
"""Rows of a table that are text and numbers at once."""


class Destination(NamedTuple):
    """Where an output goes.

    Parameters
    ----------
    target : path of the file itself, symbolic links followed
    before : what the file system says of the file that is there now, None for a new name
    """

    target: Path
    before: os.stat_result | None


@dataclass(frozen=True, eq=False)
class Outputs:
    """Files that a command is going to write, checked when this is made.

    Parameters
    ----------
    files : option to path, such as {"--output": Path("a.csv")}; None where an option is not given
    inputs : files that the command reads
    folder : folder that is made for the files if it does not exist, with its parents

    Raises
    ------
    InputError
        If a file cannot be written, is no regular file, is an input or open already, or is named
        twice.
    """

    files: Mapping[str, Path | None]
    inputs: tuple[Path, ...] = ()
    folder: Path | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check every file."""
        if not isinstance(self.files, Mapping):
            raise InputError(f"files: got {type(self.files).__name__}, expected a mapping to Path")
        if not isinstance(self.inputs, tuple | list):
            raise InputError(f"inputs: got {type(self.inputs).__name__}, expected a tuple of Path")
        named = {"files": self.files.values(), "inputs": self.inputs, "folder": (self.folder,)}
        for name, paths in named.items():
            for path in paths:
                if not isinstance(path, Path) and (path is not None or name == "inputs"):
                    raise InputError(f"{name}: got {type(path).__name__}, expected Path")
        self._destinations()

    def write(self, contents: Mapping[Path, bytes]) -> None:
        """Write the files: all of them, or none and no trace.

        Parameters
        ----------
        contents : path, as the option named it, to content

        Raises
        ------
        InputError
            If one of them cannot be written; the files are then as they were before.
        """
        # Again: a name may have become something else while the command worked.
        places = self._destinations()
        # Left in this order: bring back old files, remove what is unfinished, remove new folders.
        with ExitStack() as folders, ExitStack() as tidy, ExitStack() as undo:
            if self.folder is not None:
                _make_folder(self.folder, folders)
            parts = {
                path: _write_part(path, places[path], content, tidy)
                for path, content in contents.items()
            }
            for path, part in parts.items():
                if len(parts) > 1:
                    _remember(path, places[path], tidy, undo)
                with _naming(path):
                    os.replace(part, places[path].target)
            undo.pop_all()
            folders.pop_all()

    def _destinations(self) -> dict[Path, Destination]:
        if self.folder is not None and not _is_folder(self.folder):
            return {path: Destination(path, None) for path in self.files.values() if path}
        given = {option: path for option, path in self.files.items() if path is not None}
        places = {path: _destination(path) for path in given.values()}
        inputs = {_identity(path): path for path in self.inputs}
        streams = _open_files()
        taken: dict[tuple[object, ...], str] = {}
        for option, path in given.items():
            before = places[path].before
            if before is not None and (before.st_dev, before.st_ino) in inputs:
                raise InputError(
                    f"{option} {path}: is an input of this command and would be replaced; "
                    "choose another name"
                )
            if before is not None and (before.st_dev, before.st_ino) in streams:
                # As in "-o log >> log", or "-o /dev/stdout >> log": the log would be lost.
                raise InputError(
                    f"{option} {path}: is a file that the command has open, such as the one that "
                    "standard output goes to; choose another name"
                )
            key = _key(places[path])
            if key in taken:
                raise InputError(
                    f"{option} {path}: is the same file as {taken[key]}; choose another name"
                )
            taken[key] = option
        return places


def as_path(path: str | os.PathLike[str], name: str = "path") -> Path:
    """Check that a value is the name of a file.

    Parameters
    ----------
    path : str or Path
    name : what to call it in the error message

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If it is something else.
    """
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str):
        raise InputError(f"{name}: got {type(path).__name__}, expected the name of a file")
    return Path(path)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file, whole or not at all; an existing file is replaced and keeps its mode.

    Parameters
    ----------
    path : str or Path
    text : its content

    Raises
    ------
    InputError
        If it cannot be written, or something else than a regular file has this name.
    """
    target = as_path(path)
    if not isinstance(text, str):
        raise InputError(f"text: got {type(text).__name__}, expected text")
    Outputs({"path": target}).write({target: text.encode()})


def csv_bytes(table: pd.DataFrame, path: Path) -> bytes:
    """Content of a CSV file; packed if its name ends in .gz, the same bytes each time.

    Parameters
    ----------
    table : DataFrame
    path : name of the file

    Returns
    -------
    bytes
    """
    if isinstance(table, type):
        raise InputError(f"table: got the class {table.__name__} itself, expected DataFrame")
    if not hasattr(table, "columns"):
        raise InputError(f"table: got {type(table).__name__}, expected DataFrame")
    if not isinstance(path, Path):
        raise InputError(f"path: got {type(path).__name__}, expected Path")
    text = _csv_text(table).encode()
    return gzip.compress(text, mtime=0) if path.suffix == ".gz" else text


def _csv_text(table: pd.DataFrame) -> str:
    """Text as pandas writes it, row by row where all are numbers: three times as fast."""
    forms = [_FORMS.get(str(kind)) for kind in table.dtypes]
    # One column alone is left to pandas, which writes a missing number there as two quotes.
    if None in forms or len(forms) < 2 or table.columns.nlevels > 1 or os.linesep != "\n":
        return str(table.to_csv(index=False, float_format="%.6f"))
    row = f"{','.join(map(str, forms))}\n"
    parts = [table.head(0).to_csv(index=False)]
    for start in range(0, len(table), ROWS_AT_ONCE):
        some = table.iloc[start : start + ROWS_AT_ONCE]
        columns = [column.to_numpy().tolist() for _, column in some.items()]
        parts.append("".join(map(row.__mod__, zip(*columns, strict=True))))
    return "".join([parts[0], *(part.replace("nan", "") for part in parts[1:])])


def figure_bytes(figure: Figure, path: Path) -> bytes:
    """Content of a picture in the format that the file's name ends in.

    Parameters
    ----------
    figure : Figure
    path : name of the file, ending in .png, .svg or .pdf

    Returns
    -------
    bytes
    """
    if isinstance(figure, type):
        raise InputError(f"figure: got the class {figure.__name__} itself, expected Figure")
    if not hasattr(figure, "savefig"):
        raise InputError(f"figure: got {type(figure).__name__}, expected Figure")
    if not isinstance(path, Path):
        raise InputError(f"path: got {type(path).__name__}, expected Path")
    buffer = io.BytesIO()
    figure.savefig(buffer, format=path.suffix[1:], dpi=150)
    return buffer.getvalue()


def _destination(path: Path) -> Destination:
    """Where a path leads to: a regular file, or a new name in a folder."""
    with _naming(path):
        if not path.parent.is_dir():
            raise InputError(f"{path.parent}: no such folder to write {path.name} into")
        target = path.parent.resolve() / path.name
        before = _what_is_there(path)
        if before is not None:
            if not stat.S_ISREG(before.st_mode):
                kind = next((name for test, name in _KINDS if test(before.st_mode)), "no file")
                raise InputError(f"{path}: is {kind}, expected the name of a file to write")
            if path.is_symlink():
                target = path.resolve(strict=True)
        # The folder as well: what is unfinished stands beside the target.
        folder_serves = os.access(target.parent, os.W_OK | os.X_OK)
        if not folder_serves or (before is not None and not os.access(target, os.W_OK)):
            raise InputError(f"{path}: cannot be written (no permission, or read-only)")
    return Destination(target, before)


def _what_is_there(path: Path) -> os.stat_result | None:
    """State of the file that a path leads to, links followed; None for a new name."""
    try:
        return path.stat()
    except FileNotFoundError:
        if path.is_symlink():
            raise InputError(f"{path}: is a link to a file that does not exist") from None
        return None


def _is_folder(folder: Path) -> bool:
    """Whether a folder is there; if it is not, it is checked that it can be made."""
    with _naming(folder):
        if folder.is_dir():
            return True
        nearest = folder
        while _what_is_there(nearest) is None:
            nearest = nearest.parent
        if nearest == folder or not nearest.is_dir():
            raise InputError(f"{nearest}: is a file, expected a folder")
        if not os.access(nearest, os.W_OK | os.X_OK):
            raise InputError(f"{folder}: cannot be made (no permission, or read-only)")
    return False


def _key(place: Destination) -> tuple[object, ...]:
    """What two outputs share if they are one file."""
    if place.before is not None:
        return place.before.st_dev, place.before.st_ino
    # Some file systems take A.csv for a.csv, or one spelling of an accent for the other.
    name = unicodedata.normalize("NFC", place.target.name).casefold()
    return _identity(place.target.parent), name


def _open_files() -> set[tuple[int, int]]:
    """Device and number of each file that this process has open, as far as the system tells."""
    numbers = {0, 1, 2}
    with suppress(OSError, ValueError):
        numbers |= {int(name) for name in os.listdir("/dev/fd")}
    found = set()
    for number in numbers:
        with suppress(OSError):
            state = os.fstat(number)
            found.add((state.st_dev, state.st_ino))
    return found


def _identity(path: Path) -> tuple[int, int] | None:
    """Device and number of the file that a path leads to, None if there is none."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino


def _make_folder(folder: Path, undo: ExitStack) -> None:
    """Make a folder and its parents; ``undo`` removes what was made."""
    with _naming(folder):
        missing = [folder]
        while not missing[-1].exists():
            missing.append(missing[-1].parent)
        for path in reversed(missing[:-1]):
            undo.callback(_quietly, path.rmdir)
            path.mkdir()


def _write_part(path: Path, place: Destination, content: bytes, tidy: ExitStack) -> Path:
    """Write content under a passing name beside the target."""
    with _naming(path):
        # Short: the target's own name may have the greatest length that is allowed.
        part = place.target.parent / f".{secrets.token_hex(8)}.part"
        tidy.callback(_quietly, part.unlink)
        # The system takes the user's mask off; nobody else may read what replaces a private file.
        mode = 0o666 if place.before is None else 0o600
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        with open(os.open(part, flags, mode), "wb") as file:
            file.write(content)
            file.flush()
            _to_disk(file.fileno())
        if place.before is not None:
            _keep_owner(part, place.before)
            os.chmod(part, stat.S_IMODE(place.before.st_mode))
    return part


def _to_disk(number: int) -> None:
    """Have the system write a file down before it replaces another one."""
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP):
            raise  # the others mean that the file system knows no such request


def _keep_owner(part: Path, before: os.stat_result) -> None:
    """Set owner and group as on the file that is replaced, as far as is allowed."""
    for user in (before.st_uid, -1):
        with suppress(OSError, AttributeError):  # Windows has no chown
            os.chown(part, user, before.st_gid)
            return


def _remember(path: Path, place: Destination, tidy: ExitStack, undo: ExitStack) -> None:
    """Register the target's present file with ``undo``, which restores it."""
    if place.before is None:
        undo.callback(_quietly, place.target.unlink)
        return
    with _naming(path):
        backup = place.target.parent / f".{secrets.token_hex(8)}.old"
        tidy.callback(_quietly, backup.unlink)
        try:
            os.link(place.target, backup)
        except OSError:  # a file system without hard links
            shutil.copy2(place.target, backup)
        undo.callback(_quietly, os.replace, backup, place.target)


def _quietly(action: object, *arguments: object) -> None:
    """Take a step of tidying up; a step that fails, or was taken already, is passed over."""
    with suppress(OSError):
        action(*arguments)  # type: ignore[operator]


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Turn errors of the system into one line that names the output."""
    try:
        yield
    except InputError:
        raise
    except ValueError as error:  # a character that no name can have
        raise InputError(f"{path}: cannot be written ({error})") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None
