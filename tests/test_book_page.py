"""One page of the book by itself: what is laid out for it."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from mobility_imu._compiled import HAVE_NUMBA

BOOK = Path(__file__).resolve().parents[1] / "book"


@pytest.fixture
def page(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(BOOK))
    import page

    monkeypatch.setattr(page, "SOURCE", tmp_path / "source")
    monkeypatch.setattr(page, "EXECUTED", tmp_path / "executed")
    yield page
    for name in ("page", "execute"):
        sys.modules.pop(name, None)


def test_a_page_is_laid_out_with_what_it_needs_and_nothing_else(page, tmp_path):
    notebook = Path("notebooks/walker/steps.ipynb")
    (tmp_path / "executed" / notebook.parent).mkdir(parents=True)
    (tmp_path / "executed" / notebook).write_text("{}")
    page.lay_out(Path("book/equations.md"))
    page.lay_out(notebook)
    laid = {p.relative_to(page.SOURCE).as_posix() for p in page.SOURCE.rglob("*") if p.is_file()}
    pages = {name for name in laid if name.endswith((".md", ".ipynb"))}
    assert pages == {"notebooks/walker/steps.ipynb", "book/bibliography.md"}
    assert {"book/_config.yml", "book/references.bib", "pyproject.toml", "_toc.yml"} <= laid
    toc = yaml.safe_load((page.SOURCE / "_toc.yml").read_text())
    assert toc["root"] == "notebooks/walker/steps"
    assert toc["chapters"] == [{"file": "book/bibliography"}]


def test_what_did_not_change_stays_as_it_is(page):
    """Sphinx reads again only what is newer than its own copy."""
    page.lay_out(Path("book/bibliography.md"))
    config = page.SOURCE / "book" / "_config.yml"
    before = config.stat().st_mtime_ns
    page.lay_out(Path("book/equations.md"))
    assert config.stat().st_mtime_ns == before
    assert "chapters" in (page.SOURCE / "_toc.yml").read_text()


def listed():
    """Pages in the order of the table of contents."""
    toc = yaml.safe_load((BOOK / "_toc.yml").read_text())
    return [chapter["file"] for part in toc["parts"] for chapter in part["chapters"]]


def needs():
    return yaml.safe_load((BOOK / "chapters.yml").read_text())


def test_every_chapter_says_what_it_needs():
    chapters = [page for page in listed() if page.startswith("notebooks/")]
    alone = {"notebooks/beyond/sensor_faults"}  # the other pages there are lists to look things up
    assert list(needs()) == [p for p in chapters if "/beyond/" not in p or p in alone]


@pytest.mark.parametrize("chapter", list(needs()))
def test_nothing_is_needed_before_it_was_given(chapter):
    """What a chapter needs first stands before it, and its own line links to exactly that."""
    order = listed()
    assert all(order.index(page) < order.index(chapter) for page in needs()[chapter])
    notebook = json.loads((BOOK.parent / f"{chapter}.ipynb").read_text())
    first = [cell for cell in notebook["cells"] if cell["cell_type"] == "markdown"][:3]
    prose = "\n\n".join("".join(cell["source"]) for cell in first)
    line = prose.partition("**You need")[2].partition("\n\n")[0]
    assert line, "no line 'You need first' at its beginning"
    links = {
        link.strip("/").removesuffix(".ipynb").rpartition("/")[2]
        for link in re.findall(r"\]\(([^)#]+)\)", line)
    }
    assert links == {page.rpartition("/")[2] for page in needs()[chapter]}


def test_both_cores_begin_with_what_does_not_need_the_scooters_filter(page, monkeypatch, tmp_path):
    import execute

    monkeypatch.setattr(execute, "EXECUTED", tmp_path)  # nothing was run before
    notebooks = execute.notebooks()
    order = execute.in_order(notebooks, 20)
    assert sorted(order) == notebooks
    plain = [n for n in notebooks if "wheelchair" in n.parts]
    half = (len(plain) + 6) // 2
    assert set(plain) < {*order[: len(plain) + 6 - half], *order[20 : 20 + half]}
    first = order.index(Path("notebooks/scooter/past_the_paper.ipynb"))
    assert order[0] == Path("notebooks/wheelchair/slip.ipynb")
    assert {"wheelchair", "walker"} == {n.parts[1] for n in order[:first]}


DEVICES = """
import runpy, sys
from mobility_imu.scooter import fusion_filter
from mobility_imu.walker import _kernel
runpy.run_path(sys.argv[1])
for module in (fusion_filter, _kernel):
    for name in ("run_filter", "run_smoother"):
        print(sum(getattr(module, name).stats.cache_hits.values()))
"""


@pytest.mark.slow
@pytest.mark.skipif(not HAVE_NUMBA, reason="numba is an extra")
def test_the_filters_that_are_compiled_are_those_that_the_first_page_needs(tmp_path):
    environment = {
        **os.environ,
        **{"NUMBA_CACHE_DIR": str(tmp_path), "MOBILITY_IMU_COMPILE": "always", "MPLBACKEND": "agg"},
    }
    subprocess.run([sys.executable, BOOK / "machine_code.py"], env=environment, check=True)
    cells = json.loads((BOOK / "index.ipynb").read_text(encoding="utf-8"))["cells"]
    code = next("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    (tmp_path / "page.py").write_text(code, encoding="utf-8")
    found = subprocess.run(
        [sys.executable, "-c", DEVICES, tmp_path / "page.py"],
        env=environment, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    assert found.split() == ["1"] * 4
