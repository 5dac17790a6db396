"""The book's text and shown code keep to what a reader can follow."""

import ast
import importlib.util
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted((ROOT / "notebooks").rglob("*.ipynb"))
FRONT = ROOT / "book/index.ipynb"
TEXTS = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "data/README.md")]
TEXTS += sorted((ROOT / "book").glob("*.md"))


def load_reading():
    spec = importlib.util.spec_from_file_location("reading", ROOT / "book/reading.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["reading"] = module  # its named tuples look themselves up here
    spec.loader.exec_module(module)
    return module


reading = load_reading()


def name(path):
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_shown_code_comes_in_small_steps_between_prose(page):
    assert reading.heavy(page) == []


@pytest.mark.parametrize("page", [FRONT, *PAGES], ids=name)
def test_sentences_are_short(page):
    assert reading.too_long(page) == []


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_terms_are_linked_to_the_glossary_where_a_chapter_first_uses_them(page):
    assert reading.unlinked(page) == []


@pytest.mark.parametrize("page", [FRONT, *PAGES], ids=name)
def test_pages_use_plain_words(page):
    prose = [cell.text for cell in reading.cells(page) if cell.kind == "markdown"]
    captions = [cell.caption for cell in reading.cells(page)]
    assert reading.dropped("\n\n".join(prose + captions)) == []


@pytest.mark.parametrize("page", TEXTS, ids=name)
def test_other_texts_use_plain_words(page):
    assert reading.dropped(page.read_text()) == []


def spoken(path):
    """Docstrings and messages of a file: all its texts but the names of things."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.value


PACKAGES = [path.parent for path in sorted((ROOT / "mobility_imu").rglob("__init__.py"))]


@pytest.mark.parametrize("folder", PACKAGES, ids=name)
def test_docstrings_and_messages_use_plain_words(folder):
    texts = ((path.name, text) for path in folder.glob("*.py") for text in spoken(path))
    assert [(file, word) for file, text in texts for word in reading.dropped(text)] == []


def test_the_rules_find_what_they_are_for():
    long = "This sentence goes on and on " + "and on " * 20 + "until nobody can follow."
    assert [reading.words(s) for s in reading.sentences(f"Short, with 5 m/s. {long}")] == [3, 50]
    assert reading.sentences("| a | b |\n\n```python\nx = 1\n```\n\n# Title\n\nOne. Two.") == [
        "One.",
        "Two.",
    ]
    assert reading.sentences("It is 3. The sum $a. B$ of eq. 4 counts.") == [
        "It is 3.",
        "The sum x of eq 4 counts.",
    ]
    assert reading.dropped("The other wheel is the best witness.")
    assert not reading.dropped("A `witness` in code, and the other wheel.")
    assert reading.used("yaw rate", "Two yaw rates.") and not reading.used("yaw rate", "yaw-rated")
    assert reading.linked("yaw rate", "a {term}`yaw rate`") and reading.linked(
        "yaw rate", "{term}`rates <yaw rate>`"
    )
    assert not reading.linked("yaw rate", "a yaw rate")
