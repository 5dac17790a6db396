"""What an install brings: dependencies, tables, extras by name, and pages whose commands run."""

import ast
import importlib.util
import re
import shlex
import sys
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

from mobility_imu import data
from mobility_imu.cli.main import app, main
from mobility_imu.errors import InputError, MissingExtraError, missing_extra, needs

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
CORE = {"numpy", "pandas", "scipy", "typer"}
README = (ROOT / "README.md").read_text()
HOW_TO_USE = (ROOT / "book" / "how_to_use.md").read_text()


@pytest.fixture
def beside(tmp_path, monkeypatch):
    """Empty folder beside the checkout, as the README has it; the commands run there."""
    (tmp_path / "mobility_imu").symlink_to(ROOT)
    folder = tmp_path / "empty"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture(scope="module")
def check():
    """The slow checks, which share the way that commands are found on a page."""
    spec = importlib.util.spec_from_file_location("check", ROOT / "checks" / "check.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(monkeypatch, command):
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as left:
        main()
    return left.value.code


# Dependencies


def named(requirement):
    """Name of a requirement, lower case, and its bounds."""
    name, bounds = re.fullmatch(r"([\w-]+(?:\[[\w,]+\])?)(.*)", requirement).groups()
    return name.lower(), bounds


def test_the_core_needs_four_libraries():
    assert {named(line)[0] for line in PROJECT["dependencies"]} == CORE


def test_requirements_name_what_the_extras_name_with_the_same_bounds():
    lines = (ROOT / "requirements.txt").read_text().splitlines()
    listed = dict(named(line) for line in lines if re.match(r"[A-Za-z]", line))
    extras = PROJECT["optional-dependencies"]
    wanted = [*extras["fast"], *extras["plot"], *extras["fetch"], *extras["book"], *extras["dev"]]
    wanted = dict(named(line) for line in wanted if not line.startswith("mobility-imu"))
    core = dict(named(line) for line in PROJECT["dependencies"])
    assert listed == wanted | core


def test_modules_import_only_the_core_before_they_are_asked_for_more():
    for path in (ROOT / "mobility_imu").rglob("*.py"):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Import):
                names = {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names = {(node.module or "").partition(".")[0]}
            else:
                continue
            # numba: make check STEP=nonumba
            foreign = names - set(sys.stdlib_module_names) - CORE - {"mobility_imu"}
            assert not foreign, f"{path.name} imports {foreign} at once"


def test_types_are_carried():
    assert (ROOT / "mobility_imu" / "py.typed").is_file()


# Extras


def test_a_missing_library_names_its_extra(monkeypatch):
    assert needs("json").loads("1") == 1
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(MissingExtraError) as error:
        needs("emcee")
    assert str(error.value) == "needs emcee: pip install 'mobility-imu[book]'"
    assert isinstance(error.value, ImportError)


def test_a_library_that_no_extra_brings_is_an_import_error():
    with pytest.raises(ModuleNotFoundError, match="no_such_library"):
        needs("no_such_library")
    assert missing_extra(ModuleNotFoundError(name="kiwisolver")) is None


def test_each_library_is_in_the_extra_that_the_message_names():
    from mobility_imu.errors import EXTRAS

    for library, extra in EXTRAS.items():
        brought = {named(line)[0] for line in PROJECT["optional-dependencies"][extra]}
        assert library in brought


def test_a_command_whose_extra_is_missing_says_so_in_a_line(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    table = "time_s,linear_velocity_mps,yaw_rate_degps\n"
    rows = "".join(f"{k / 100},{k % 200 / 100},0\n" for k in range(400))
    Path("v.csv").write_text(table + rows)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    command = "mobility-imu wheelchair tasks v.csv --figure f.png -o t.csv"
    assert run(monkeypatch, command.split()) == 2
    said = capsys.readouterr()
    assert said.err == "mobility-imu: needs matplotlib: pip install 'mobility-imu[plot]'\n"
    assert said.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["v.csv"]


# Data


def test_data_of_somebody_else_beside_an_install_are_not_taken(monkeypatch, tmp_path):
    (tmp_path / "data" / "published").mkdir(parents=True)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "another"\n')
    monkeypatch.setattr(data, "ROOT", tmp_path)
    assert data.checkout() is None
    monkeypatch.setattr(data, "INSTALLED", "reproduction")  # a folder that the package has
    with pytest.raises(InputError, match="install the package again"):
        data.published_folder()
    with pytest.raises(InputError, match="checkout of the project"):
        data.recordings_folder()


def test_an_install_finds_its_tables_inside_the_package(monkeypatch, tmp_path):
    monkeypatch.setattr(data, "ROOT", tmp_path)
    monkeypatch.setattr(data.resources, "files", lambda package: tmp_path / package)
    for name in ("published", "recorded", "reference"):
        folder = tmp_path / "mobility_imu" / "_data" / name
        folder.mkdir(parents=True)
        assert getattr(data, f"{name}_folder")() == folder


# Pages


def test_the_public_checks_run_every_step(check):
    workflow = (ROOT / ".github" / "workflows" / "check.yml").read_text(encoding="utf-8")
    (steps,) = re.findall(r"step: \[(.*)\]", workflow)
    assert steps.split(", ") == list(check.STEPS)


def test_commands_are_found_on_a_page(check):
    inline, indented = "text `mobility-imu x`\n\n", "    mobility-imu a \\\n        b   # why\n\n"
    page = inline + indented + "```text\nmobility-imu c\n```\n"
    assert check.examples(page) == ["mobility-imu a b", "mobility-imu c"]


def test_the_pages_show_every_command(check):
    groups = {each.name: each.typer_instance for each in app.registered_groups}
    names = [f"{g} {c.name}" for g, inside in groups.items() for c in inside.registered_commands]
    names += [command.name for command in app.registered_commands]
    assert len(names) >= 11
    shown = check.examples(HOW_TO_USE)
    for name in names:
        assert any(f"{line} ".startswith(f"mobility-imu {name} ") for line in shown), name


def shown_runs(page):
    """Commands of a page that are followed by what they print, with these lines."""
    joined = re.sub(r"\\\n\s*", "", page)
    blocks = [
        [line[4:] for line in block.splitlines()]
        for block in re.findall(r"(?:^ {4}.*\n)+", joined, flags=re.MULTILINE)
    ]
    return [
        (before[-1], block) for before, block in pairwise(blocks) if block[0].startswith("read: ")
    ]


def test_the_readmes_examples_run_from_an_empty_folder_and_print_what_it_shows(
    check, beside, monkeypatch, capfd
):
    """Words are the same, numbers to 2 % or 0.1, their last digit."""
    assert len(check.examples(README)) >= 6
    expected = dict(shown_runs(README))
    assert len(expected) == 6
    for command in check.examples(README):
        code = run(monkeypatch, shlex.split(command))
        printed = capfd.readouterr().err.splitlines()
        assert code == 0, (command, printed)
        if command not in expected:
            continue
        shown = expected.pop(command)
        number = r"-?\d+(?:\.\d+)?"
        assert [re.sub(number, "#", line) for line in printed[: len(shown)]] == [
            re.sub(number, "#", line) for line in shown
        ]
        for one, other in zip(printed, shown, strict=False):
            values = (list(map(float, re.findall(number, line))) for line in (one, other))
            assert next(values) == pytest.approx(next(values), rel=0.02, abs=0.1)
    assert not expected, "shown, but not among the commands"
    for page in (README, HOW_TO_USE):
        python = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
        capfd.readouterr()
        exec(compile(python, "first example", "exec"), {})
        assert "time_s" in capfd.readouterr().out.replace("lift_s", "time_s")
