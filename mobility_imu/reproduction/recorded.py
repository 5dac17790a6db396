"""Results too long for a page: computed once, kept with command, seed, versions and checksums.

``python -m mobility_imu.reproduction.recorded`` (``make record``) renews all of them, or those that
are named. A record is stale when code that it depends on has changed since: :func:`is_stale`.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import json
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from mobility_imu.data import checkout, recorded_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.imports import called, file_of, reached


class Study(NamedTuple):
    """How a record is made.

    Parameters
    ----------
    module : where the study lives; its code and that of all it imports decide staleness
    function : takes ``executor`` and gives the numbers, as JSON wants them; None if what it needs
        (a recording that may not be passed on) is not there
    seed : what the random numbers start from, in words
    inputs : names of the files that it reads, to be checked by their sums
    reads_recordings : whether the code of the readers counts: a study that simulates reads no file
    refuses : whether a refused argument may be one of its results; if not, checks of arguments do
        not decide staleness: one that refuses would end the study
    """

    module: str
    function: str
    seed: str
    inputs: tuple[str, ...] = ()
    reads_recordings: bool = False
    refuses: bool = True


CHECKS = ("check", "expect")
"""How the names of functions begin that check arguments and return nothing that is used."""
CONVERTING = ("check_fields", "check_shape")
"""Checks that also make what they check something else, which may change a number."""
STUDIES: dict[str, Study] = {
    "scooter_driving": Study(
        "mobility_imu.reproduction.scooter.driving_record",
        "driving_record",
        "scooters 0 to 19; each ride's seed is made from scooter, course, driver and run",
        refuses=False,
    ),
    "scooter_posterior_calibration": Study(
        "mobility_imu.reproduction.scooter.posterior_check",
        "recorded_check",
        "2022 and the table's number, 0 to 99",
        ("scooter_table1.csv",),
        refuses=False,
    ),
    "scooter_prediction": Study(
        "mobility_imu.reproduction.scooter.prediction",
        "recorded_prediction",
        "1; each ride's seed is made from scooter, course, driver and run",
        ("scooter_table1.csv",),
        refuses=False,
    ),
    "scooter_table1_controls": Study(
        "mobility_imu.reproduction.scooter.table1_controls",
        "shuffle_record",
        "1, of the shuffled tables and of the fits' starting points",
        ("scooter_table1.csv",),
        refuses=False,
    ),
    "real_two_hinges": Study(
        "mobility_imu.reproduction.scooter.real_hinges_record",
        "two_hinges_record",
        "none for the recordings; the simulated rides beside them: scooters 0 to 3",
        reads_recordings=True,
    ),
    "real_one_hinge": Study(
        "mobility_imu.reproduction.scooter.real_hinges_record",
        "one_hinge_record",
        "none for the recordings; the simulated rides beside them: scooters 0 to 3",
        reads_recordings=True,
    ),
    "faults_scooter": Study(
        "mobility_imu.reproduction.scooter.faults",
        "faults_record",
        "250,000 and the ride's number, 0 to 24; 242,000 to 247,000 for rides without a fault",
        reads_recordings=True,
    ),
    "wheelmove_sample": Study(
        "mobility_imu.reproduction.wheelchair.sample_study",
        "study",
        "none: nothing is drawn",
        reads_recordings=True,
    ),
    "real_chair_mocap": Study(
        "mobility_imu.reproduction.wheelchair.real_mocap",
        "study",
        "0 to 19, of the simulated courts beside the recordings",
        reads_recordings=True,
    ),
    "real_car": Study(
        "mobility_imu.reproduction.wheelchair.real_car",
        "study",
        "none: nothing is drawn",
        reads_recordings=True,
    ),
    "real_drives": Study(
        "mobility_imu.reproduction.wheelchair.real_drives",
        "study",
        "0 to 9, of the simulated drives beside the recordings",
        reads_recordings=True,
    ),
    "walker_walks": Study(
        "mobility_imu.reproduction.walker.walks",
        "walker_walks",
        "0 to 19, and 0 to 3 for one source of error at a time",
        ("walker_table1.csv",),
    ),
    "real_walks": Study(
        "mobility_imu.reproduction.walker.real_walks_study",
        "real_walks",
        "0 to 7 for the simulated walks",
        reads_recordings=True,
    ),
    "real_feet": Study(
        "mobility_imu.reproduction.walker.real_feet",
        "real_feet",
        "0 to 3 for the simulated walks",
        reads_recordings=True,
    ),
    **{
        f"held_{name}": Study(
            f"mobility_imu.reproduction.{work}.held",
            f"held_{name}",
            "none: nothing is drawn",
            reads_recordings=True,
        )
        for work, names in (
            ("wheelchair", ("drives", "chairs", "car")),
            ("walker", ("walks", "feet")),
        )
        for name in names
    },
    "faults_wheelchair": Study(
        "mobility_imu.reproduction.wheelchair.faults",
        "study",
        "317000 to 317024 for the courts, with the kind's and the case's numbers for places and "
        "sizes; 318000 to 321069 for courts without a fault",
    ),
    "dropped_chairs": Study(
        "mobility_imu.reproduction.wheelchair.held",
        "dropped_chairs",
        "none: nothing is drawn",
        reads_recordings=True,
    ),
    "faults_walker": Study(
        "mobility_imu.reproduction.walker.faults",
        "study",
        "308000 to 308024 for walks that get a fault; from 309000, 310000, 311000 and 312000 for "
        "others",
        reads_recordings=True,
    ),
    "level_real": Study(
        "mobility_imu.reproduction.real_level",
        "level_real",
        "0 to 9 for scooters, 0 to 19 for courts and frames",
    ),
}
"""Every record by its name."""


def load_record(name: str) -> dict[str, Any]:
    """One record, as ``data/recorded/<name>.json`` has it.

    Parameters
    ----------
    name : a key of :data:`STUDIES`

    Returns
    -------
    dict
        ``numbers`` (what the study gave), ``command``, ``seed``, ``versions``, ``inputs`` (SHA-256
        by name), ``code`` (digest of the code), ``date``.

    Raises
    ------
    InputError
        If there is no such record.
    """
    path = recorded_folder() / f"{name}.json"
    if name not in STUDIES or not path.is_file():
        raise InputError(f"record {name!r}: no such record; there are {', '.join(STUDIES)}")
    record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return record


def numbers(name: str) -> Any:
    """Numbers of one record; see :func:`load_record`.

    Parameters
    ----------
    name : a key of :data:`STUDIES`

    Returns
    -------
    what the study gave, as JSON has it
    """
    return load_record(name)["numbers"]


def write_record(name: str, executor: Any = None) -> Path | None:
    """Run a study and keep what it gave.

    Parameters
    ----------
    name : a key of :data:`STUDIES`
    executor : anything with ``submit``; None computes here

    Returns
    -------
    Path of the record, or None if the study could not run for want of its recording

    Raises
    ------
    InputError
        If the package was installed without the project around it.
    """
    from datetime import date

    root = checkout()
    if root is None:
        raise InputError("records are renewed in a checkout of the project only")
    study = STUDIES[name]
    found = getattr(importlib.import_module(study.module), study.function)(executor)
    if found is None:
        return None
    record = {
        "numbers": found["numbers"],
        "command": f"python -m mobility_imu.reproduction.recorded {name}",
        "seed": study.seed,
        "versions": _versions(),
        "inputs": found.get("inputs", {}),
        "code": code_digest(study),
        "date": date.today().isoformat(),
    }
    folder = root / "data" / "recorded"
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.json"
    part = path.with_suffix(".part")
    part.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    part.replace(path)
    return path


def is_stale(name: str) -> bool:
    """Whether the code behind a record has changed since the record was made.

    Parameters
    ----------
    name : a key of :data:`STUDIES`

    Returns
    -------
    bool
    """
    return bool(load_record(name)["code"] != code_digest(STUDIES[name]))


def code_digest(study: Study) -> str:
    """Digest of the code that a study depends on, within this package.

    Definitions count, not where they stand: moving a function from file to file, another comment
    or docstring changes nothing; nor does another check of an argument, if ``refuses`` is false.

    Parameters
    ----------
    study : Study

    Returns
    -------
    str of 16 hexadecimal digits
    """
    files = _files(study)
    definitions = sorted(text for path in files for text in _definitions(path, study.refuses))
    return hashlib.sha256("\n".join(definitions).encode()).hexdigest()[:16]


def _files(study: Study) -> set[Path]:
    """Files of this package whose code a study may call."""
    start = file_of(study.module)
    assert start is not None, f"no module {study.module}"
    return reached(
        [start], called, without=lambda p: p.parent.name == "readers" and not study.reads_recordings
    )


@cache
def _definitions(path: Path, refuses: bool) -> tuple[str, ...]:
    return tuple(_dumped(ast.parse(path.read_text(encoding="utf-8")), refuses))


def _dumped(tree: ast.Module, refuses: bool) -> Iterator[str]:
    """What each definition computes, without imports and docstrings, and checks unless they count.

    Parameters
    ----------
    tree : is changed
    refuses : whether checks of arguments count
    """
    if not refuses:
        _leave_checks_out(tree)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            kept = [
                part
                for part in body
                if not isinstance(part, ast.Import | ast.ImportFrom)
                and not (isinstance(part, ast.Expr) and isinstance(part.value, ast.Constant))
            ]
            node.body = kept or [ast.Pass()]  # type: ignore[attr-defined]
    for node in tree.body:
        yield ast.dump(node)


def _leave_checks_out(node: ast.AST) -> None:
    for child in ast.iter_child_nodes(node):
        _leave_checks_out(child)
    if isinstance(node, ast.ExceptHandler):
        return  # whether it raises or goes on is not the same
    for field in ("body", "orelse", "finalbody"):
        body = getattr(node, field, None)
        if isinstance(body, list) and body:
            kept = [
                one for part in body for one in _without_refusals(part) if not _only_checks(one)
            ]
            setattr(node, field, kept or [ast.Pass()])


def _without_refusals(node: ast.stmt) -> list[ast.stmt]:
    """What a statement tries, if all that it does about an error is to refuse; else the statement.

    With and without it, an error ends the study.
    """
    if isinstance(node, ast.Try) and not node.orelse and not node.finalbody:
        if all(len(one.body) == 1 and _only_checks(one.body[0]) for one in node.handlers):
            return node.body
    return [node]


def _only_checks(node: ast.AST) -> bool:
    """Whether a statement raises an InputError or does nothing."""
    if isinstance(node, ast.Expr):
        called = node.value.func if isinstance(node.value, ast.Call) else None
        name = getattr(called, "attr", getattr(called, "id", ""))
        return name.lstrip("_").startswith(CHECKS) and name not in CONVERTING
    if isinstance(node, ast.Raise):
        called = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
        return getattr(called, "id", "") == "InputError"
    if isinstance(node, ast.If | ast.For):
        # A name that a condition gives a value is used later.
        named = any(isinstance(part, ast.NamedExpr) for part in ast.walk(node))
        inside = [*node.body, *node.orelse]
        return not named and all(isinstance(n, ast.Pass) or _only_checks(n) for n in inside)
    return False


def _versions() -> dict[str, str]:
    import platform
    from importlib.metadata import version

    return {
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "scipy", "pandas")},
    }


def main(arguments: list[str] | None = None) -> None:
    """Renew records from the command line.

    Parameters
    ----------
    arguments : of the command; None takes those of the process
    """
    import argparse
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    parser = argparse.ArgumentParser(prog="python -m mobility_imu.reproduction.recorded")
    parser.add_argument("names", nargs="*", help=f"of {', '.join(STUDIES)}; none is all of them")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    given = parser.parse_args(arguments)
    unknown = set(given.names) - set(STUDIES)
    if unknown:
        parser.error(f"no such record: {', '.join(sorted(unknown))}")
    # Compiled from the first call on: readable forms differ in the last digits.
    os.environ.setdefault("MOBILITY_IMU_COMPILE", "always")
    # New processes, not copies of this one: works alike on every system.
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        for name in given.names or STUDIES:
            path = write_record(name, pool)
            print(f"{name}: {path or 'not renewed, its recordings are not all there'}")


if __name__ == "__main__":
    main()
