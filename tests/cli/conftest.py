"""Run commands in this process, and hold each failure to the contract of the command line."""

import shutil
import sys
from typing import NamedTuple

import pandas as pd
import pytest
from command_lines import CORRIDOR, COURT, contents, rests_csv, scooter_ride, velocity_csv

from mobility_imu.cli import main


class Result(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Run one command in a folder of its own, as a shell would; returns code and both outputs.

    What compiled libraries write by themselves counts as output.
    """
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["mobility-imu", *map(str, arguments)])
        capfd.readouterr()
        with pytest.raises(SystemExit) as left:
            main()
        found = capfd.readouterr()
        return Result(left.value.code, found.out, found.err)

    return run


@pytest.fixture
def works(run):
    """Exit code 0."""

    def works(*arguments):
        result = run(*arguments)
        assert result.returncode == 0, result.stderr
        return result

    return works


@pytest.fixture
def fails(run, tmp_path):
    """Exit code 2, one line on stderr that says it, no file left behind or changed."""

    def fails(*arguments, says=()):
        before = contents(tmp_path)
        result = run(*arguments)
        assert result.returncode == 2, result
        assert result.stdout == ""
        assert result.stderr.endswith("\n") and result.stderr.startswith("mobility-imu: ")
        line = result.stderr[:-1]
        assert line.isprintable(), result.stderr  # one line, and nothing that acts on a terminal
        for part in says:
            assert part in line
        assert contents(tmp_path) == before
        return line

    return fails


@pytest.fixture(scope="session")
def inputs(tmp_path_factory):
    """Folder with the inputs of every command, each under a short name."""
    folder = tmp_path_factory.mktemp("inputs")
    scooter_ride(folder)
    velocity_csv(folder / "velocity.csv")
    (folder / "settings.json").write_text('{"segment_s": 0.25}')
    (folder / "poses.csv").write_text("steering_deg,throttle_deg\n0,0\n")
    for path in (COURT / "static.csv.gz", COURT / "straight.csv.gz", CORRIDOR / "tilts.csv.gz"):
        shutil.copy(path, folder)
    rests_csv(folder / "rests.csv")
    for path in (COURT / "court.csv.gz", CORRIDOR / "walk.csv.gz", folder / "rests.csv"):
        table = pd.read_csv(path)
        table[table["time_s"] < 20].to_csv(folder / path.name, index=False)
    shutil.copy(COURT / "geometry.toml", folder / "chair.toml")
    shutil.copy(CORRIDOR / "true_mount.toml", folder / "frame.toml")
    return folder


@pytest.fixture(scope="session")
def scooter(tmp_path_factory):
    """Folder with what ``simulate scooter --seed 3`` writes."""
    folder = tmp_path_factory.mktemp("scooter")
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as left:
        patch.setattr(sys, "argv", ["", "simulate", "scooter", "--seed", "3", "-o", str(folder)])
        main()
    assert left.value.code == 0
    return folder


@pytest.fixture
def simulated(scooter, tmp_path):
    """The files of a simulated scooter in the folder of a test, which may change its own."""
    for path in scooter.iterdir():
        shutil.copy(path, tmp_path)


@pytest.fixture
def short(inputs):
    """The first 20 s of the bundled walk."""
    return inputs / "walk.csv.gz"


@pytest.fixture
def plain(monkeypatch):
    """Figures are empty: that they are written is tried, not what they show."""
    from matplotlib.figure import Figure

    monkeypatch.setattr("mobility_imu.plots.wheelchair.chronogram", lambda *_, **__: Figure())


@pytest.fixture
def room(inputs, tmp_path):
    """Folder of a test with these inputs, which it may change."""
    for path in inputs.iterdir():
        shutil.copy(path, tmp_path)
    return tmp_path
