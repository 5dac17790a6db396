"""Which files of this package some code depends on, found by following its imports."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def imported(code: str) -> set[str]:
    """Names that some code imports from this package, anywhere in it, modules and others.

    Parameters
    ----------
    code : Python

    Returns
    -------
    set of names with dots, such as "mobility_imu.walker.steps"
    """
    found = set()
    for node in _statements(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.split(".")[0] == PACKAGE.name}


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Statements inside a node at any depth; no expressions, which are most of a tree."""
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        for inner in getattr(node, field, ()):
            yield inner
            yield from _statements(inner)


def named(code: str) -> set[str]:
    """Names of modules that stand in some code as text, to be imported when it runs.

    Parameters
    ----------
    code : Python

    Returns
    -------
    set of names with dots
    """
    return {found[1] for found in re.finditer(rf"[\"']({PACKAGE.name}(?:\.\w+)+)[\"']", code)}


@cache
def file_of(module: str) -> Path | None:
    """File of a module.

    Parameters
    ----------
    module : name with dots

    Returns
    -------
    Path, or None if the name is not one of a module
    """
    place = PACKAGE.joinpath(*module.split(".")[1:])
    for path in (place.with_suffix(".py"), place / "__init__.py"):
        if path.is_file():
            return path
    return None


@cache
def called(path: Path) -> frozenset[Path]:
    """Files whose code a file may call: those of the names that it imports.

    Parameters
    ----------
    path : file of this package

    Returns
    -------
    frozenset of Path
    """
    return frozenset(
        file for name in imported(path.read_text(encoding="utf-8")) if (file := file_of(name))
    )


@cache
def loaded(path: Path) -> frozenset[Path]:
    """Files that are loaded when a file runs: also packages, and modules that it names as text.

    Parameters
    ----------
    path : file of this package

    Returns
    -------
    frozenset of Path
    """
    text = path.read_text(encoding="utf-8")
    files = set(called(path)) | {file for name in named(text) if (file := file_of(name))}
    if "import_module(" in text:  # by a name that is made when it runs: all that stand beside it
        files |= set(path.parent.rglob("*.py"))
    # A package is loaded before its modules.
    packages = {folder / "__init__.py" for file in files for folder in file.parents}
    return frozenset(files | {p for p in packages if PACKAGE in p.parents and p.is_file()})


def reached(
    files: Iterable[Path],
    step: Callable[[Path], Iterable[Path]],
    *,
    without: Callable[[Path], bool] = lambda path: False,
) -> set[Path]:
    """Files that some files lead to, themselves included.

    Parameters
    ----------
    files : where to start
    step : :func:`called` or :func:`loaded`
    without : files that are passed over, with what only they lead to

    Returns
    -------
    set of Path
    """
    waiting, seen = set(files), set()
    while waiting:
        file = waiting.pop()
        if file not in seen and not without(file):
            seen.add(file)
            waiting |= set(step(file))
    return seen
