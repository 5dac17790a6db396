"""Where an estimate refuses a recording, the faults that were found before are named first."""

import pandas as pd
import pytest
from command_lines import CORRIDOR, COURT, angles, calibrate, trajectory, velocity

from mobility_imu.cli import wheelchair
from mobility_imu.errors import InputError

TRUE_MOUNT = CORRIDOR / "true_mount.toml"
XYZ = "xyz"


def named_first(line, fault, refusal):
    assert 0 < line.index(fault) < line.index("the estimate refuses: ") < line.index(refusal)


def spoil(path, how):
    table = pd.read_csv(path)
    how(table)
    table.to_csv("bad.csv", index=False)
    return "bad.csv"


def turned(sensor):
    def how(table):
        table[[f"{sensor}_gyr_{axis}_radps" for axis in XYZ]] *= -1

    return how


def silent(sensor, count):
    def how(table):
        table.loc[:count, [f"{sensor}_acc_{axis}_mps2" for axis in XYZ]] = 0.0

    return how


@pytest.mark.usefixtures("simulated")
def test_a_ride(fails):
    bad = spoil("ride.csv.gz", silent("lever", 80))
    line = fails(*angles(bad, "geometry.toml"), "--method", "fusion")
    named_first(line, "lever_acc in 81 samples", "lever_acc_mps2: is 0")


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize("command", ["calibrate", "check"])
def test_parked_poses(fails, command):
    pd.read_csv("poses.csv").iloc[:-1].to_csv("fewer.csv", index=False)
    bad = spoil("parked_level.csv.gz", turned("lever"))
    more = ["parked_ramp.csv.gz", "-o", "m.toml"] if command == "calibrate" else []
    line = ["scooter", command, bad, *more, "--geometry", "geometry.toml", "--poses", "fewer.csv"]
    named_first(fails(*line), "lever_gyr turns the other way", "6 still intervals")


def test_tilts(fails):
    bad = spoil(CORRIDOR / "tilts.csv.gz", turned("frame"))
    named_first(fails(*calibrate(tilts=bad)), "frame_gyr turns the other way", "no tilt found")


def test_a_walk(fails):
    bad = spoil(CORRIDOR / "walk.csv.gz", silent("frame", 300))
    line = fails(*trajectory(walk=bad, mount=TRUE_MOUNT))
    named_first(line, "frame_acc in 301 samples", "bad.csv: acc_mps2: zero in the first rest")


def test_a_drive_whose_samples_refuse_what_a_filter_hides(fails, monkeypatch):
    def refuse(*_):
        raise InputError("only without the filter")

    monkeypatch.setattr(wheelchair, "_with_smoothing_sd", refuse)
    bad = spoil(COURT / "court.csv.gz", silent("frame", 300))
    line = fails(*velocity(bad), "--filter", "moving-average")
    named_first(line, "frame_acc", "only without the filter")


@pytest.mark.parametrize(
    "error", [ImportError("libfreetype.so.6: not found"), ValueError("'x' is no backend\nuse agg")]
)
def test_a_library_that_draws_and_fails_is_named(fails, monkeypatch, error):
    def broken(name):
        raise error

    monkeypatch.setattr("mobility_imu.cli.wheelchair.needs", broken)
    command = "wheelchair tasks v.csv -o k.csv --figure f.svg"
    fails(*command.split(), says=["--figure f.svg: matplotlib", str(error).splitlines()[0]])
