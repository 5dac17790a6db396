"""Rules of the house: who imports whom, equations that resolve, notebooks as they should be."""

import ast
import enum
import importlib
import inspect
import json
import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from mobility_imu import data

ROOT = Path(__file__).resolve().parents[1]
VERDICT = ("right", "error", "contradiction", "ambiguous", "silent", "copy")
PACKAGE = ROOT / "mobility_imu"
DEVICES = ("scooter", "wheelchair", "walker")
# From the right of the architecture's chain to its left; a module may import what stands before it.
LAYERS = (
    {"errors"},
    {"frames", "data", "_compiled", "files"},
    {"runs", "results", "executors", "names"},
    {"rotations", "filters", "recording"},
    {"hinges", "quality", "readers", "arguments"},
    {"offsets", "fields", "unit_changes"},
    {"datasets", "faults"},
    {"health"},
    set(DEVICES),
    {"simulation"},
    {"plots", "reproduction"},
    {"report", "cli"},
    {"__main__"},
)
NOTEBOOKS = sorted([*(ROOT / "notebooks").rglob("*.ipynb"), *(ROOT / "book").glob("*.ipynb")])
EQUATIONS = yaml.safe_load((ROOT / "book" / "equations.yml").read_text())


STATED = ("scooter", "wheelchair", "walker", "simulation", "readers", "hinges")
"""Subpackages whose ``__all__`` says what a script may rely on."""


def layer(room):
    found = [k for k, rooms in enumerate(LAYERS) if room in rooms]
    assert found, f"mobility_imu/{room} has no place in the architecture"
    return found[0]


class Read(NamedTuple):
    """What the rules ask of a file: what it imports of this package, also inside functions and for
    types alone; names of long functions; first lines of docstrings."""

    imports: tuple[str, ...]
    long: frozenset[str]
    beginnings: tuple[str, ...]


@cache
def read(path):
    imported, long, beginnings = [], set(), []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("mobility_imu"):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                own = whole in MODULES or node.module == "mobility_imu"
                imported.append(whole if own else node.module)
        elif isinstance(node, ast.Import):
            imported += [a.name for a in node.names if a.name.startswith("mobility_imu.")]
        elif isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            beginnings.append((ast.get_docstring(node) or "").partition("\n")[0])
            if isinstance(node, ast.FunctionDef) and length_without_docstring(node) > 60:
                long.add(node.name)
    return Read(tuple(imported), frozenset(long), tuple(beginnings))


def name_of(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}
FOLDERS: dict[str, list[str]] = {}
for module, path in MODULES.items():
    FOLDERS.setdefault(path.parent.relative_to(ROOT).as_posix(), []).append(module)
# One test a folder: one a file, three hundred, takes longer than what is looked at.
in_each_folder = pytest.mark.parametrize("names", FOLDERS.values(), ids=FOLDERS.keys())


@in_each_folder
def test_imports_go_one_way(names):
    for name in names:
        goes_one_way(MODULES[name])


def goes_one_way(path):
    room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if room == "__init__":
        assert not read(path).imports, path.name
        return
    for module in read(path).imports:
        parts = module.split(".")
        other = parts[1]
        if other == "__version__":
            continue
        if other == room:
            continue
        assert layer(other) < layer(room), f"{path.name} imports {module}"
        if room in DEVICES:
            assert other not in DEVICES, f"{path.name} imports another device: {module}"
        if room == "simulation" and other in DEVICES:
            assert parts[2:] in (["geometry"], ["mount"]), f"{path.name} imports {module}"


def test_the_imports_have_no_circle():
    """Inside folders neither, nor by way of imports inside functions."""
    found = {name: set(read(path).imports) & MODULES.keys() for name, path in MODULES.items()}
    waiting = dict(found)
    while free := [name for name, others in waiting.items() if not others & waiting.keys()]:
        for name in free:
            del waiting[name]
    # What is left lies on a circle, or leads to one; with what leads away from it taken off:
    while free := [n for n in waiting if not any(n in found[other] for other in waiting)]:
        for name in free:
            del waiting[name]
    assert not waiting, f"circles: {sorted(waiting)}"


def test_numba_is_imported_in_one_place():
    """It is an extra, and an installation may have no place for compiled code."""
    found = {
        name
        for name, path in MODULES.items()
        if re.search(r"^\s*(?:import|from) numba", path.read_text(), re.MULTILINE)
    }
    assert found == {"mobility_imu._compiled"}, found


def length_without_docstring(node):
    length = node.end_lineno - node.lineno + 1
    if ast.get_docstring(node) is not None:
        length -= node.body[0].end_lineno - node.body[0].lineno + 1
    return length


@in_each_folder
def test_files_and_functions_fit_their_readers(names):
    """No file over 600 lines; no function over 60 lines but in the annotated kernel."""
    for name in names:
        assert len(MODULES[name].read_text().splitlines()) <= 600, name
        # The kernel is the annotated loops of the walker.
        assert "._kernel" in name or not read(MODULES[name]).long, name


def stated_names():
    """Every public name that a script may rely on, as module and name."""
    for name, path in MODULES.items():
        if path.name == "__init__.py" and name.split(".")[1:2] in [[s] for s in STATED]:
            for public in getattr(importlib.import_module(name), "__all__", ()):
                yield name, public


PUBLIC = list(stated_names())


@in_each_folder
def test_what_holds_arrays_is_a_result(names):
    """Read-only, compared by identity, printed in one line, pickled: see results.py.

    Dataclasses with arrays, and named tuples with arrays that a script gets.
    """
    for name in names:
        holds_arrays_in_results(name)


def holds_arrays_in_results(name):
    from mobility_imu.results import Result

    for node in ast.parse(MODULES[name].read_text()).body:
        if not isinstance(node, ast.ClassDef) or node.name == "Result":
            continue
        dressed = [ast.unparse(d) for d in node.decorator_list if "dataclass" in ast.unparse(d)]
        fields = [ast.unparse(f.annotation) for f in node.body if isinstance(f, ast.AnnAssign)]
        if issubclass(getattr(importlib.import_module(name), node.name), Result):
            for option in ("frozen=True", "eq=False", "repr=False"):
                assert dressed and option in dressed[0], f"{name}.{node.name}: {option}"
            for part in node.body:
                if isinstance(part, ast.FunctionDef) and part.name == "__post_init__":
                    assert "super().__post_init__()" in ast.unparse(part), f"{name}.{node.name}"
        elif re.search("Array|ndarray", " ".join(fields)):
            shown = dressed and not node.name.startswith("_")
            shown = shown or node.name in {public for _, public in PUBLIC}
            assert not shown, f"{name}.{node.name}: derive it from Result"


def parameters_of(thing):
    """Names that somebody who calls a function, or makes an object, has to know."""
    try:
        names = list(inspect.signature(thing).parameters)
    except (TypeError, ValueError):
        return []
    return [name for name in names if name not in ("self", "cls")]


@pytest.mark.parametrize(("module", "public"), PUBLIC)
def test_public_names_are_documented(module, public):
    """What ``__all__`` lists is there, and says what it takes."""
    name = f"{module}.{public}"
    thing = getattr(importlib.import_module(module), public)
    if not inspect.isclass(thing) and not inspect.isroutine(thing):
        return  # a constant, or names of choices
    parts = [(name, thing)]
    if inspect.isclass(thing):
        if issubclass(thing, Exception | enum.Enum):
            parts = []
        for attribute, raw in vars(thing).items():
            bound = getattr(raw, "__func__", raw)
            if not attribute.startswith("_") and inspect.isfunction(bound):
                parts.append((f"{name}.{attribute}", bound))
    for whole, part in parts:
        text = inspect.getdoc(part) or ""
        assert text, f"{whole} has no docstring"
        if parameters_of(part):
            assert "Parameters\n---" in text, f"{whole}: no parameters"


@in_each_folder
def test_docstrings_begin_with_what_there_is(names):
    """Not with "Give ..." or "Refuse what ...", which say nothing."""
    bad = ("Give", "Gives", "Refuse", "Refuses")
    found = [
        (name, line)
        for name in names
        for line in read(MODULES[name]).beginnings
        if line.partition(" ")[0] in bad
    ]
    assert not found


def test_package_stays_light():
    """Importing the package loads none of the heavy libraries."""
    code = (
        "import sys, mobility_imu; heavy = {'numpy', 'scipy', 'pandas', 'sympy', 'matplotlib'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_every_numbered_equation_has_one_entry():
    numbers = {work: [e["number"] for e in EQUATIONS if e["work"] == work] for work in DEVICES}
    assert numbers["scooter"] == [str(k) for k in range(1, 8)]
    assert numbers["wheelchair"] == [f"1.{k}" for k in range(1, 19)] + ["2.1"]
    assert numbers["walker"] == [str(k) for k in range(1, 29)]


@pytest.mark.parametrize("entry", EQUATIONS, ids=lambda e: e["id"])
def test_equation_resolves(entry):
    assert entry["printed"] in VERDICT
    assert bool(entry["correction"]) == (entry["printed"] != "right")
    if entry["status"] == "open":
        assert not entry["function"] and not entry["notebook"] and not entry["test"]
        return
    module, _, name = entry["function"].rpartition(".")
    function = getattr(importlib.import_module(module), name)
    first = (function.__doc__ or "").strip().splitlines()[0]
    numbers = covered_numbers(first)
    assert entry["number"] in numbers, f"{entry['function']} does not name ({entry['number']})"
    notebook = ROOT / entry["notebook"]
    text = "".join("".join(cell["source"]) for cell in json.loads(notebook.read_text())["cells"])
    assert name in text, f"{notebook.name} does not use {name}"
    label = f"({entry['work']}-eq-{entry['number']})"
    assert label in text, f"{notebook.name} does not show the equation under the label {label}"
    path, _, test = entry["test"].partition("::")
    assert f"def {test}(" in (ROOT / path).read_text(), f"no test {entry['test']}"


def covered_numbers(line):
    """Equation numbers that a docstring's first line names; ranges like 1.3-1.5 are opened."""
    inside = re.search(r"eqs?\.?\s*([\d.,\s\-–and]+)", line)
    if inside is None:
        return set()
    found = set()
    for low, high in re.findall(r"(\d+(?:\.\d+)?)(?:\s*[-–]\s*(\d+(?:\.\d+)?))?", inside[1]):
        found.add(low)
        if high:
            head, _, first = low.rpartition(".")
            last = high.rpartition(".")[2]
            prefix = f"{head}." if head else ""
            found |= {f"{prefix}{k}" for k in range(int(first), int(last) + 1)}
    return found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
class TestNotebook:
    def cells(self, path):
        return json.loads(path.read_text())["cells"]

    def test_is_stored_without_outputs(self, path):
        assert all(
            not cell.get("outputs") and cell.get("execution_count") is None
            for cell in self.cells(path)
        )

    def test_asserts_something(self, path):
        code = "".join("".join(c["source"]) for c in self.cells(path) if c["cell_type"] == "code")
        assert "assert " in code

    def test_figures_have_caption_and_alt_text(self, path):
        for cell in self.cells(path):
            code = "".join(cell["source"])
            if cell["cell_type"] == "code" and re.search(r"plt\.show\(\)|subplots\(|^fig$", code):
                meta = cell["metadata"].get("mystnb", {})
                assert meta.get("figure", {}).get("caption"), code[:80]
                assert meta.get("figure", {}).get("name"), code[:80]
                assert len(meta.get("image", {}).get("alt", "")) > 20, code[:80]

    def test_names_no_machine_path_and_no_network(self, path):
        text = path.read_text()
        assert not re.search(r"(?<![\w.:/])/(?:home|root|tmp|work|mnt)/\w", text)
        assert not re.search(r"urlopen|requests\.|urlretrieve", text)


def test_notebooks_use_what_there_is():
    """``plots.style.show_table`` and ``filters.rms``, not a copy of them in each chapter."""
    copies = set()
    for path in NOTEBOOKS:
        cells = json.loads(path.read_text())["cells"]
        code = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "code")
        for name in re.findall(r"^def (show|show_table|rms)\(", code, re.MULTILINE):
            copies.add(f"{path.stem}.{name}")
    assert not copies, copies


def test_every_chapter_is_in_the_table_of_contents():
    toc = (ROOT / "book" / "_toc.yml").read_text()
    for path in NOTEBOOKS:
        assert str(path.relative_to(ROOT).with_suffix("")) in toc


def test_tests_that_are_left_to_the_slow_step_are_there():
    for place, tests in tomllib.loads((ROOT / "tests" / "rare.toml").read_text()).items():
        parts = place.split(".")
        within = parts.pop() if parts[-1][0].isupper() else None
        tree = ast.parse((ROOT / "tests").joinpath(*parts).with_suffix(".py").read_text())
        if within is not None:
            tree = next(n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == within)
        names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        assert set(tests) <= names, place


def test_version_is_stated_once_for_all():
    import tomllib

    import mobility_imu

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert project["tool"]["setuptools"]["dynamic"]["version"]["attr"] == "mobility_imu.__version__"
    assert mobility_imu.__version__ == citation["version"]


@pytest.mark.parametrize(
    "page", ["README.md", "data/README.md", "notebooks/wheelchair/realignment.ipynb"]
)
def test_the_public_sample_is_to_be_had_where_the_pages_say(page):
    text = (ROOT / page).read_text()
    assert data.SAMPLE_REPOSITORY.removeprefix("https://github.com/") in text
    for part in (data.SAMPLE_COMMIT, data.SAMPLE_ARCHIVE, data.SAMPLE_ARCHIVE_SHA256):
        assert part in text, f"{page}: {part}"
