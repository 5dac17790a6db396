"""Files of a fixed commit of a git repository: only those that are wanted, each checked."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import signal
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mobility_imu.errors import InputError
from mobility_imu.readers.wording import quoted

SETTINGS = (
    "gc.auto=0",
    "maintenance.auto=false",
    "core.hooksPath=" + os.devnull,
    "credential.helper=",
    "protocol.version=2",
    # Ask for these objects plainly: what is here already says nothing about them.
    "fetch.negotiationAlgorithm=noop",
    # Give up a connection that stands still.
    "http.lowSpeedLimit=1000",
    "http.lowSpeedTime=60",
)
FIRST_VERSION = "2.29"
"""Of git; the first that fetches single objects by ids from its input."""
OF_ANOTHER_REPOSITORY = {
    *("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_COMMON_DIR", "GIT_PREFIX"),
    *("GIT_OBJECT_DIRECTORY", "GIT_ALTERNATE_OBJECT_DIRECTORIES", "GIT_QUARANTINE_PATH"),
    *("GIT_CONFIG", "GIT_CONFIG_PARAMETERS", "GIT_CONFIG_COUNT", "GIT_NAMESPACE"),
    *("GIT_GRAFT_FILE", "GIT_SHALLOW_FILE", "GIT_REPLACE_REF_BASE", "GIT_NO_REPLACE_OBJECTS"),
}
"""Variables that a hook, for example, sets for the repository that it runs in."""


@dataclass(frozen=True, eq=False)
class GitFiles:
    """Files of one commit, in a bare repository without work tree.

    Parameters
    ----------
    folder : the bare repository
    ids : path in the commit to id of the file's content
    """

    folder: Path
    ids: Mapping[str, str]

    @property
    def names(self) -> Sequence[str]:
        """Every path of the commit, sorted."""
        return sorted(self.ids)

    def read(self, name: str) -> bytes:
        """Content of a file.

        Parameters
        ----------
        name : path in the commit

        Returns
        -------
        bytes

        Raises
        ------
        InputError
            If there is no such file, it was not fetched, or its content has not the id that the
            commit states.
        """
        if name not in self.ids:
            raise InputError(f"the origin has no file {quoted(name)}")
        content = _git(self.folder, "cat-file", "blob", self.ids[name])
        if blob_id(content) != self.ids[name]:
            raise InputError(f"a file of the origin is damaged: {self.ids[name]}")
        return content


def blob_id(content: bytes) -> str:
    """Name that git gives to a file's content (SHA-1).

    Parameters
    ----------
    content : of the file

    Returns
    -------
    str, 40 digits

    Examples
    --------
    >>> blob_id(b"")
    'e69de29bb2d1d6434b8b29ae775ad8c2e48c5391'
    """
    head = b"blob %d\0" % len(content)
    return hashlib.sha1(head + content, usedforsecurity=False).hexdigest()


def fetch_commit(url: str, commit: str, folder: Path, wanted: Callable[[str], bool]) -> GitFiles:
    """Fetch the files of a commit that are wanted; the rest of the repository stays where it is.

    Git names everything by its checksum, so the commit's id checks the whole list of files, and
    each file's id its content.

    Parameters
    ----------
    url : address of the repository
    commit : its id, 40 digits
    folder : a new bare repository is made here
    wanted : whether a path is needed

    Returns
    -------
    GitFiles

    Raises
    ------
    InputError
        If git is missing or too old, the repository cannot be reached, or it has no such commit or
        none of the files.
    """
    folder.mkdir(parents=True)
    _git(folder, "init", "--quiet", "--bare")
    _git(folder, "remote", "add", "origin", url)
    source = ("--no-tags", "--filter=blob:none", "--quiet", "origin")
    _git(folder, "fetch", "--depth=1", *source, commit, asked=url)
    listing = _git(folder, "ls-tree", "-r", "-z", "--full-tree", commit)
    ids = dict(_entries(listing))
    needed = sorted({blob for path, blob in ids.items() if wanted(path)})
    if not needed:
        raise InputError(f"{url}: commit {commit} has none of the files that are wanted")
    _git(
        folder,
        *("fetch", "--no-write-fetch-head", "--recurse-submodules=no", "--stdin", *source),
        given="".join(f"{blob}\n" for blob in needed).encode(),
        asked=url,
    )
    return GitFiles(folder, ids)


def _entries(listing: bytes) -> list[tuple[str, str]]:
    """Path and id of each regular file of ``git ls-tree -r -z``."""
    found = []
    for entry in listing.split(b"\0"):
        head, _, path = entry.partition(b"\t")
        if head.startswith((b"100644 blob ", b"100755 blob ")):
            found.append((path.decode("utf-8", "replace"), head.split()[2].decode()))
    return found


def _git(folder: Path, *arguments: str, given: bytes = b"", asked: str = "") -> bytes:
    """Output of git, run in a repository; ``asked`` is the address that it talks to."""
    command = ["git", "-C", str(folder)]
    for setting in SETTINGS:
        command += ["-c", setting]
    try:
        with subprocess.Popen(
            [*command, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=_environment(),
            # A group of its own: an interrupt reaches us, and we end git with its helpers.
            start_new_session=True,
        ) as process:
            try:
                output, errors = process.communicate(given)
            except BaseException:
                _end(process)
                raise
    except FileNotFoundError:
        raise InputError(
            f"git is not installed; data sets are fetched with git {FIRST_VERSION} or newer"
        ) from None
    if process.returncode == 0:
        return output
    why = _reason(errors.decode("utf-8", "replace"))
    if "No space left" in why:
        raise InputError(f"{folder.parent.parent}: the disk is full; nothing is left there")
    if asked:
        raise InputError(f"{asked}: cannot be fetched ({why}); is there a network?")
    raise InputError(f"git {arguments[0]} failed ({why})")


def _environment() -> dict[str, str]:
    """Environment without settings of another repository, and without questions to the user."""
    kept = {k: value for k, value in os.environ.items() if k not in OF_ANOTHER_REPOSITORY}
    quiet = {"GIT_TERMINAL_PROMPT": "0", "GIT_ASKPASS": "", "SSH_ASKPASS": "", "LC_ALL": "C"}
    return kept | quiet | {"GIT_NO_LAZY_FETCH": "1", "GIT_SSH_COMMAND": "ssh -oBatchMode=yes"}


def _end(process: subprocess.Popen[bytes]) -> None:
    """End git and the helpers that it started."""
    with contextlib.suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    process.wait()


def _reason(errors: str) -> str:
    """Line of git's messages that says why it failed."""
    lines = [line.strip() for line in errors.splitlines() if line.strip()]
    marked = [line for line in lines if re.match(r"(fatal|error|remote):", line)]
    return (marked or lines or ["no reason given"])[0]
