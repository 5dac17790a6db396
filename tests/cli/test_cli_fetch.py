"""``mobility-imu fetch``: its list, its messages, its exit codes."""

import subprocess
import sys
from dataclasses import replace
from typing import get_args

import pytest

from mobility_imu.cli import fetch
from mobility_imu.datasets import catalogue
from mobility_imu.datasets.files import Note


@pytest.fixture(autouse=True)
def machine(monkeypatch, tmp_path):
    for name in ("MOBILITY_IMU_RECORDINGS", "MOBILITY_IMU_DATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("MOBILITY_IMU_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def origin(monkeypatch, tmp_path):
    """A small local repository behind the name one-hinge, and a recipe that copies."""
    folder = tmp_path / "origin"
    folder.mkdir()

    def git(*arguments):
        identity = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
        command = ["git", "-C", str(folder), *identity, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()

    class Recipe:
        def wanted(self, path):
            return True

        def convert(self, files, out):
            out.text("a.csv", files.read("a.csv").decode())
            return Note(done=["copied"])

    git("init", "-q")
    (folder / "a.csv").write_text("1\n")
    git("add", ".")
    git("commit", "-qm", "first")
    commit = git("rev-parse", "HEAD")
    dataset = replace(catalogue.DATASETS["one-hinge"], origin=f"file://{folder}", commit=commit)
    monkeypatch.setitem(catalogue.DATASETS, "one-hinge", dataset)
    monkeypatch.setattr("mobility_imu.datasets.obtain._recipe", lambda dataset: Recipe())


def test_the_command_knows_the_catalogues_names():
    assert get_args(fetch.Name) == get_args(catalogue.Name) == tuple(catalogue.DATASETS)


def test_the_command_line_starts_without_numpy():
    code = "import sys, mobility_imu.cli.main; print('numpy' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "False"


def test_the_list_names_size_origin_licence_and_use(works, tmp_path):
    text = works("fetch", "--list").stdout
    for dataset in catalogue.list_datasets():
        for part in (dataset.name, dataset.origin, dataset.commit, dataset.licence):
            assert part in text
        assert f"good for: {dataset.good_for}" in text
        assert f"about {dataset.download_mb:g} MB to fetch" in text
    assert text.count("not here") == len(catalogue.list_datasets())
    assert list(tmp_path.iterdir()) == []  # looking writes nothing


def test_fetch_says_where_it_is_and_the_list_knows_it(works, origin, tmp_path):
    result = works("fetch", "one-hinge")
    folder = tmp_path / "cache" / "one-hinge"
    assert result.stdout == f"one-hinge: {folder} (NOTE.txt says what was done)\n"
    assert result.stderr == ""
    assert sorted(p.name for p in folder.iterdir()) == ["NOTE.txt", "a.csv"]
    assert f"here: {folder}" in works("fetch", "--list").stdout
    assert works("fetch", "one-hinge").stdout == result.stdout  # again: nothing to do


def test_neither_name_nor_list(fails):
    fails("fetch", says=["give the name of one data set, or --list"])


def test_name_and_list(fails):
    fails("fetch", "one-hinge", "--list", says=["give the name of one data set, or --list"])


def test_a_name_that_is_none(fails):
    fails("fetch", "one_hinge", says=["one_hinge", "terrain-chair"])


def test_no_network(fails, monkeypatch):
    unreachable = replace(catalogue.DATASETS["one-hinge"], origin="https://127.0.0.1:9/a/b")
    monkeypatch.setitem(catalogue.DATASETS, "one-hinge", unreachable)
    fails("fetch", "one-hinge", says=["https://127.0.0.1:9/a/b", "is there a network?"])


def test_no_git(fails, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    fails("fetch", "one-hinge", says=["git is not installed"])


def test_no_pooch(fails, monkeypatch):
    monkeypatch.setitem(sys.modules, "pooch", None)
    fails("fetch", "wheelmove-id-sample", says=["pip install 'mobility-imu[fetch]'"])


def test_a_folder_of_somebody_else(fails, tmp_path):
    (tmp_path / "cache" / "one-hinge").mkdir(parents=True)
    fails("fetch", "one-hinge", says=["is there already"])


def test_a_variable_that_names_no_folder(fails, monkeypatch, tmp_path):
    monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "gone"))
    fails("fetch", "--list", says=["MOBILITY_IMU_RECORDINGS", "no such folder"])


def test_a_list_that_cannot_be_made_whole_prints_nothing(monkeypatch, tmp_path, fails):
    monkeypatch.setenv("MOBILITY_IMU_DATA", str(tmp_path))  # the first set is there
    monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "none"))
    fails("fetch", "--list", says=["MOBILITY_IMU_RECORDINGS", "no such folder"])
