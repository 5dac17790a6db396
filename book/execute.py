"""Run each notebook once, for the tests and for the book alike.

Copies under ``_build/executed`` are run by pytest and nbmake on all cores and keep their outputs.
A copy is run again only if its notebook, a module that it can reach or data that these name have
changed. ``--assemble`` then lays the sources of the book beside each other in ``_build/source``.

    python book/execute.py [--assemble] [NOTEBOOK ...]
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import datetime
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [
    str(ROOT),
    str(ROOT / "book"),
]  # the package of this checkout, whichever is installed

from kernels import ONE_THREAD, forked_kernels  # noqa: E402
from modules import write_pages  # noqa: E402

from mobility_imu.reproduction import imports  # noqa: E402

EXECUTED = ROOT / "_build" / "executed"
SOURCE = ROOT / "_build" / "source"
DATA = ROOT / "data"
TIMEOUT_S = 300
LONG = (
    *("wheelchair/slip", "scooter/past_the_paper", "scooter/constant_errors", "walker/steps"),
    *("walker/arcs", "scooter/table1_explained", "walker/past_the_paper"),
    *("scooter/table1_posterior", "scooter/table1_controls", "walker/rests"),
    *("scooter/driving_test", "wheelchair/real_ground", "walker/rectangle"),
)
"""Ends of the names of those that take longest, for a machine that has not run any yet."""
VARIABLES = ("MOBILITY_IMU_DATA", "MOBILITY_IMU_RECORDINGS")
"""Environment variables that change what a notebook computes."""


def notebooks() -> list[Path]:
    """All notebooks of the book, relative to the project."""
    found = [*(ROOT / "notebooks").rglob("*.ipynb"), *(ROOT / "book").glob("*.ipynb")]
    return sorted(p.relative_to(ROOT) for p in found if ".ipynb_checkpoints" not in p.parts)


def code_of(notebook: Path) -> str:
    """Code of a notebook; lines for IPython only are left out."""
    cells = json.loads((ROOT / notebook).read_text(encoding="utf-8"))["cells"]
    lines = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "code")
    return re.sub(r"^\s*[%!].*$", "", lines, flags=re.MULTILINE)


def modules_reached(notebook: Path) -> set[Path]:
    """Files of the package that a notebook can reach."""
    code = code_of(notebook)
    names = imports.imported(code) | imports.named(code)
    if "mobility-imu" in code:
        names.add("mobility_imu.cli")
    return imports.reached((f for n in names if (f := imports.file_of(n))), imports.loaded)


@cache
def bytes_of(path: Path) -> bytes:
    """Content of a file of the project, read once."""
    return path.read_bytes()


@cache
def inside(folder: Path) -> frozenset[Path]:
    """Files in a folder of data, and below it."""
    return frozenset(path for path in folder.rglob("*") if path.is_file())


@cache
def beside(folder: Path) -> frozenset[Path]:
    """Settings that lie beside modules."""
    return frozenset(folder.glob("*.toml"))


def data_reached(notebook: Path, modules: set[Path]) -> list[Path]:
    """Data files in the folders that a notebook or its modules ask :mod:`mobility_imu.data` for."""
    asking = [bytes_of(m).decode() for m in modules if m.name != "data.py"]
    text = code_of(notebook) + "".join(asking)
    folders = [f for f in DATA.iterdir() if f.is_dir() and f"{f.name}_folder" in text]
    files = [*map(inside, folders), *map(beside, {m.parent for m in modules})]
    return sorted(set().union(*files))


def key_of(notebook: Path) -> str:
    """Digest of all that a notebook's outputs depend on."""
    modules = modules_reached(notebook)
    files = [ROOT / notebook, *sorted(modules), *data_reached(notebook, modules)]
    digest = hashlib.sha256()
    for path in [*files, ROOT / "constraints.txt"]:
        digest.update(str(path.relative_to(ROOT)).encode())
        digest.update(bytes_of(path))
    for name in VARIABLES:
        digest.update(f"{name}={os.environ.get(name, '')}".encode())
    digest.update(platform.python_version().encode())
    return digest.hexdigest()


def is_current(notebook: Path) -> bool:
    """Whether the executed copy has what the sources would give now."""
    copy = EXECUTED / notebook
    mark = copy.with_suffix(".key")
    return copy.is_file() and mark.is_file() and mark.read_text() == key_of(notebook)


def execute(chosen: list[Path]) -> int:
    """Run the copies that are not current; pytest's exit code, 0 if there is nothing to do."""
    stale = {n: key_of(n) for n in chosen if not is_current(n)}
    print(f"notebooks: {len(chosen) - len(stale)} current, {len(stale)} to run", flush=True)
    if not stale:
        return 0
    environment = {
        **ONE_THREAD,
        # Compiled from the first call on: readable forms differ in the last digits.
        "MOBILITY_IMU_COMPILE": "always",
        **os.environ,
    }
    workers = min(os.cpu_count() or 1, len(stale)) if len(stale) > 1 else 0
    order = in_order(list(stale), len(stale) // max(workers, 1))
    begun = time.time()
    # nbmake passes over whatever lies in a folder named _build: run elsewhere, then move.
    with (
        tempfile.TemporaryDirectory(prefix="notebooks-") as folder,
        tempfile.TemporaryDirectory(prefix="kernels-") as spec,
        forked_kernels(Path(spec)) as (options, variables),
    ):
        room = Path(folder)
        for notebook in stale:
            (room / notebook).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / notebook, room / notebook)
        with machine_code(environment, wanted=workers > 1):
            code = subprocess.run(
                [
                    *(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"),
                    *("-c", os.devnull, "--rootdir", folder, "--durations=5"),
                    *("-n", str(workers), "--dist", "worksteal"),
                    *("--nbmake", f"--nbmake-timeout={TIMEOUT_S}", "--overwrite", *options),
                    *(str(room / n) for n in order),
                ],
                cwd=folder,
                env=environment | variables,
            ).returncode
        for notebook, key in stale.items():
            keep(room / notebook, EXECUTED / notebook, key)
    kernel = sum(seconds_of(EXECUTED / n) for n in chosen)
    print(
        f"notebooks: {time.time() - begun:.0f} s; all kernels together {kernel:.0f} s", flush=True
    )
    return code


@contextlib.contextmanager
def machine_code(environment: dict[str, str], *, wanted: bool) -> Iterator[None]:
    """Have the filters compiled beside the notebooks; one that needs them sooner does it itself."""
    if not wanted:
        yield
        return
    command = [sys.executable, str(ROOT / "book" / "machine_code.py")]
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH", ""))))
    with subprocess.Popen(command, env=environment | {"PYTHONPATH": paths}) as compiling:
        try:
            yield
        finally:
            compiling.terminate()  # no notebook needed what is not compiled yet


def in_order(chosen: list[Path], first_part: int) -> list[Path]:
    """Longest first, so that no core waits at the end for a long one.

    Each of two cores begins with a part of the list. The wheelchair's notebooks need no compiled
    loops, and the walker's filter compiles first: both parts begin with these, while the scooter's
    filter is compiled.
    """
    longest = sorted(chosen, key=lambda n: (-seconds_of(EXECUTED / n), place_in_long(n)))
    begin = [n for n in longest if "wheelchair" in n.parts]
    begin += [n for n in longest if "walker" in n.parts][:6]
    others = [n for n in longest if n not in begin]
    here = max(first_part - len(begin[::2]), 0)
    return [*begin[::2], *others[:here], *begin[1::2], *others[here:]]


def keep(ran: Path, copy: Path, key: str) -> None:
    """Put an executed notebook in its place, with its key if it ran to the end."""
    copy.parent.mkdir(parents=True, exist_ok=True)
    copy.with_suffix(".key").unlink(missing_ok=True)
    shutil.copyfile(ran, copy)
    if finished(copy):
        copy.with_suffix(".key").write_text(key)


def finished(copy: Path) -> bool:
    """Whether every code cell of an executed copy ran without an error."""
    cells = [c for c in json.loads(copy.read_text())["cells"] if c["cell_type"] == "code"]
    ran = all(c.get("execution_count") for c in cells if "".join(c["source"]).strip())
    return ran and not any(o["output_type"] == "error" for c in cells for o in c["outputs"])


def seconds_of(copy: Path) -> float:
    """Seconds that an executed copy's cells took; a copy that never ran counts as long."""
    if not copy.is_file():
        return float("inf")
    spans = [c["metadata"].get("execution", {}) for c in json.loads(copy.read_text())["cells"]]
    return sum(
        (stamp(s["shell.execute_reply"]) - stamp(s["iopub.execute_input"])).total_seconds()
        for s in spans
        if {"shell.execute_reply", "iopub.execute_input"} <= s.keys()
    )


def place_in_long(notebook: Path) -> int:
    """Place of a notebook in ``LONG``; those that are not in it come last."""
    name = str(notebook.with_suffix(""))
    return next((k for k, end in enumerate(LONG) if name.endswith(end)), len(LONG))


def stamp(text: str) -> datetime:
    """Moment of a cell's stamp."""
    return datetime.fromisoformat(text.replace("Z", "+00:00"))


def assemble() -> None:
    """Lay prose, executed notebooks and configuration beside each other for Sphinx."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    ignore = shutil.ignore_patterns("*.ipynb", "__pycache__")
    shutil.copytree(ROOT / "book", SOURCE / "book", ignore=ignore)
    write_pages(SOURCE / "book")
    shutil.copyfile(ROOT / "pyproject.toml", SOURCE / "pyproject.toml")
    for notebook in notebooks():
        target = SOURCE / notebook
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(EXECUTED / notebook, target)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python book/execute.py")
    parser.add_argument("notebooks", nargs="*", type=Path, help="none is all of them")
    parser.add_argument("--assemble", action="store_true", help="lay out the book's sources")
    given = parser.parse_args()
    chosen = [p.resolve().relative_to(ROOT) for p in given.notebooks] or notebooks()
    code = execute(chosen)
    if code == 0 and given.assemble:
        assemble()
    return code


if __name__ == "__main__":
    sys.exit(main())
