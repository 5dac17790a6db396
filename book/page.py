"""Build one page of the book, not strictly: references to other pages stay open.

The notebook is run first if something that it depends on has changed. What comes out lies under
``_build/page``; the book itself is not touched.

    python book/page.py notebooks/walker/steps.ipynb
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from execute import EXECUTED, ROOT, execute

PAGE = ROOT / "_build" / "page"
SOURCE = PAGE / "source"
BESIDE = ("book/bibliography.md",)
"""Pages that every page refers to."""


def lay_out(page: Path) -> None:
    """Lay the page and what it needs beside each other for Sphinx; what did not change stays."""
    wanted = {SOURCE / page: (EXECUTED if page.suffix == ".ipynb" else ROOT) / page}
    wanted[SOURCE / "pyproject.toml"] = ROOT / "pyproject.toml"  # states the address
    for file in (ROOT / "book").rglob("*"):
        name = file.relative_to(ROOT)
        hidden = "__pycache__" in name.parts or file.suffix in (".ipynb", ".md")
        if file.is_file() and (not hidden or name.as_posix() in BESIDE):
            wanted[SOURCE / name] = file
    for old in [p for p in SOURCE.rglob("*") if p.is_file() and p not in wanted]:
        old.unlink()
    for target, file in wanted.items():
        if not target.is_file() or target.read_bytes() != file.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
    names = [Path(name).with_suffix("") for name in BESIDE if Path(name) != page]
    lines = ["format: jb-book", f"root: {page.with_suffix('').as_posix()}"]
    lines += ["chapters:", *(f"  - file: {name.as_posix()}" for name in names)] if names else []
    (SOURCE / "_toc.yml").write_text("\n".join(lines) + "\n")


def build() -> int:
    """Run Sphinx by way of jupyter-book; its exit code."""
    tool = Path(sys.executable).with_name("jupyter-book")
    options = ["--path-output", "..", "--config", "book/_config.yml", "--toc", "_toc.yml"]
    # The package of this checkout, for what the pages take from its docstrings.
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [str(tool), "build", ".", *options, "-q"], cwd=SOURCE, env=environment
    ).returncode


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python book/page.py")
    parser.add_argument("page", type=Path, help="a notebook, or a page of prose in book/")
    page = parser.parse_args().page.resolve().relative_to(ROOT)
    if page.suffix == ".ipynb" and (code := execute([page])):
        return code
    lay_out(page)
    code = build()
    if code == 0:
        print(f"{(PAGE / '_build' / 'html' / page.with_suffix('.html')).as_uri()}")
    return code


if __name__ == "__main__":
    sys.exit(main())
