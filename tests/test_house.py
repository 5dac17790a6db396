"""Rules of the house: who imports whom, equations that resolve, notebooks as they should be."""

import ast
import importlib
import json
import re
import subprocess
import sys
from pathlib import Path

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
    {"frames", "data", "_compiled", "executors"},
    {"runs", "results"},
    {"rotations", "filters", "recording"},
    {"hinges", "quality", "readers"},
    {"datasets"},
    set(DEVICES),
    {"simulation", "outcomes"},
    {"plots", "reproduction"},
    {"report", "cli"},
    {"__main__"},
)
NOTEBOOKS = sorted([*(ROOT / "notebooks").rglob("*.ipynb"), *(ROOT / "book").glob("*.ipynb")])
EQUATIONS = yaml.safe_load((ROOT / "book" / "equations.yml").read_text())


def layer(room):
    found = [k for k, rooms in enumerate(LAYERS) if room in rooms]
    assert found, f"mobility_imu/{room} has no place in the architecture"
    return found[0]


def imports(path):
    """Modules of this package that a file imports (type checking aside counts too)."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            if node.module == "mobility_imu":
                yield from (f"mobility_imu.{alias.name}" for alias in node.names)
            elif node.module.startswith("mobility_imu."):
                yield node.module
        elif isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.startswith("mobility_imu."))


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: p.stem)
def test_imports_go_one_way(path):
    room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if room == "__init__":
        assert not list(imports(path))
        return
    for module in imports(path):
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
            assert parts[2:] == ["geometry"], f"{path.name} imports an estimator: {module}"


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


def test_every_chapter_is_in_the_table_of_contents():
    toc = (ROOT / "book" / "_toc.yml").read_text()
    for path in NOTEBOOKS:
        assert str(path.relative_to(ROOT).with_suffix("")) in toc


def test_version_is_stated_once_for_all():
    import tomllib

    import mobility_imu

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert project["version"] == mobility_imu.__version__ == citation["version"]


@pytest.mark.parametrize(
    "page", ["README.md", "data/README.md", "notebooks/wheelchair/realignment.ipynb"]
)
def test_the_public_sample_is_to_be_had_where_the_pages_say(page):
    text = (ROOT / page).read_text()
    assert data.SAMPLE_REPOSITORY.removeprefix("https://github.com/") in text
    for part in (data.SAMPLE_COMMIT, data.SAMPLE_ARCHIVE, data.SAMPLE_ARCHIVE_SHA256):
        assert part in text, f"{page}: {part}"
