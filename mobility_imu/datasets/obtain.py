"""Fetch a data set: from its origin, through its recipe, into the cache; all of it or nothing."""

from __future__ import annotations

import importlib
import os
import shutil
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from mobility_imu import __version__
from mobility_imu.datasets.catalogue import NO_LICENCE, Dataset, find_dataset
from mobility_imu.datasets.files import Files, Note, Output, Recipe
from mobility_imu.datasets.folders import NOTE, cache_folder, is_complete
from mobility_imu.datasets.git import fetch_commit
from mobility_imu.datasets.http import download
from mobility_imu.errors import InputError
from mobility_imu.frames import shown

FORGOTTEN_S = 24 * 3600.0
"""An unfinished folder this old is of a process that was killed."""
LARGEST_MEMBER = 200_000_000
"""Bytes of one file of an archive; none of ours is a tenth of it."""


def fetch_dataset(name: str, *, progress: Callable[[str], None] | None = None) -> Path:
    """Fetch a data set into the cache, unless it is there.

    Nothing is written outside the cache, and nothing stays there when it fails or is interrupted.

    Parameters
    ----------
    name : as in ``list_datasets``
    progress : called with what is being done

    Returns
    -------
    Path of the folder

    Raises
    ------
    InputError
        If the origin cannot be reached or holds something else, git or pooch is missing, the disk
        is full, the cache holds another folder of this name, or an argument is wrong.
    """
    dataset = find_dataset(name)
    if not (progress is None or callable(progress)):
        raise InputError(f"progress = {shown(progress)}: expected a function of a text, or None")
    target = cache_folder() / dataset.name
    if is_complete(target, dataset):
        return target
    say = progress or (lambda doing: None)
    recipe = _recipe(dataset)
    with _written(target.parent), _workshop(target) as workshop:
        say(f"fetching {dataset.name} (about {dataset.download_mb:g} MB)")
        files = _origin(dataset, workshop, recipe)
        say(f"converting {dataset.name}")
        out = Output(workshop / "files")
        out.folder.mkdir()
        note = recipe.convert(files, out)
        out.text(NOTE, note_text(dataset, note, out.folder))
        _put(out.folder, target, dataset)
    return target


def note_text(dataset: Dataset, note: Note, folder: Path) -> str:
    """Text of the note beside the recordings: origin, licence, and what was done.

    Parameters
    ----------
    dataset : which one
    note : what the recipe did
    folder : its files are listed

    Returns
    -------
    str
    """
    terms = dataset.licence
    if terms == NO_LICENCE:
        terms += ": read the files here, do not pass them on"
    lines = [
        f"{dataset.name}: {dataset.about}",
        "",
        f"Origin: {dataset.origin}",
        dataset.stamp,
        f"Licence of the origin: {terms}",
        f"Good for: {dataset.good_for}",
        f"Converted by mobility-imu {__version__}",
    ]
    for title, sentences in (
        ("Done", note.done),
        ("Fitted to the reference (so not tested by it)", note.fitted),
        ("Assumed", note.assumed),
        ("Left out", note.left_out),
        ("Odd in single files", note.warnings),
    ):
        if sentences:
            lines += ["", title, *(f"- {sentence}" for sentence in sentences)]
    names = sorted(str(p.relative_to(folder).as_posix()) for p in folder.rglob("*") if p.is_file())
    return "\n".join([*lines, "", f"{len(names)} files", *(f"- {name}" for name in names)]) + "\n"


def _recipe(dataset: Dataset) -> Recipe:
    module = importlib.import_module(
        f"mobility_imu.datasets.recipes.{dataset.name.replace('-', '_')}"
    )
    return cast(Recipe, module)


def _origin(dataset: Dataset, workshop: Path, recipe: Recipe) -> Files:
    """Files of the origin, brought into the workshop."""
    if dataset.sha256 is None:
        return fetch_commit(dataset.origin, dataset.commit, workshop / "origin", recipe.wanted)
    archive = workshop / "origin.zip"
    download(dataset.origin, dataset.sha256, archive)
    return ZipFiles(archive)


@dataclass(frozen=True, eq=False)
class ZipFiles:
    """Files of an archive, read one by one; none is unpacked to a path that the archive names.

    Parameters
    ----------
    archive : path of the archive
    """

    archive: Path

    @property
    def names(self) -> list[str]:
        """Every path in the archive, sorted."""
        with self._opened() as archive:
            return sorted(i.filename for i in archive.infolist() if not i.is_dir())

    def read(self, name: str) -> bytes:
        """Content of a file.

        Parameters
        ----------
        name : path in the archive
        """
        with self._opened() as archive:
            if archive.getinfo(name).file_size > LARGEST_MEMBER:
                raise InputError(f"{self.archive.name}: {name} is too large to be a recording")
            return archive.read(name)

    @contextmanager
    def _opened(self) -> Iterator[zipfile.ZipFile]:
        try:
            with zipfile.ZipFile(self.archive) as archive:
                yield archive
        except (zipfile.BadZipFile, KeyError, NotImplementedError, RuntimeError) as error:
            raise InputError(f"{self.archive.name}: cannot be unpacked ({error})") from None


@contextmanager
def _written(cache: Path) -> Iterator[None]:
    """State in one line that the cache cannot be written: no permission, a full disk."""
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{cache}: cannot be written ({error.strerror or error}); nothing is left there"
        ) from None


@contextmanager
def _workshop(target: Path) -> Iterator[Path]:
    """Folder to work in, beside the target; removed at the end, with folders made for it."""
    if target.exists() or target.is_symlink():
        raise InputError(
            f"{target}: is there already and is not what this version fetches; remove it, or move "
            "it away"
        )
    with ExitStack() as undo:
        for folder in reversed([p for p in target.parents if not p.exists()]):
            folder.mkdir()
            undo.callback(_remove_if_empty, folder)
        _remove_forgotten(target)
        workshop = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
        undo.callback(_remove, workshop)
        yield workshop


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def _remove(folder: Path) -> None:
    if os.name == "nt":  # git writes its objects read-only, which there forbids to remove them
        for path in folder.rglob("*"):
            with suppress(OSError):
                path.chmod(0o700)
    shutil.rmtree(folder, ignore_errors=True)


def _remove_forgotten(target: Path) -> None:
    """Remove what a process left that was killed long ago."""
    for old in target.parent.glob(f".{target.name}-*"):
        with suppress(OSError):
            if time.time() - old.stat().st_mtime > FORGOTTEN_S:
                _remove(old)


def _put(folder: Path, target: Path, dataset: Dataset) -> None:
    """Rename the finished folder; another process may have done so a moment ago."""
    try:
        folder.rename(target)
    except OSError:
        if not is_complete(target, dataset):
            raise
