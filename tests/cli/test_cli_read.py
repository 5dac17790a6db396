"""``mobility-imu read``: several files on one clock."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command_lines import COURT

ROOT = Path(__file__).resolve().parents[2]
LAG = r"(\w+) lags by (-?[\d.]+) ± ([\d.]+) s"
COLUMNS = ("frame", "left_wheel", "right_wheel")


@pytest.fixture
def files(tmp_path):
    """The court's recording as one file for each sensor, each with a clock of its own."""
    table = pd.read_csv(COURT / "court.csv.gz")
    for k, name in enumerate(COLUMNS):
        own = table.filter(regex=f"^{name}_|^time_s$").iloc[70 * k :].copy()
        own["time_s"] += (0.0, -7.3, 132.71)[k]
        own.to_csv(tmp_path / f"{name}.csv", index=False)
    return [f"{name}.csv" for name in COLUMNS]


def test_files_come_on_one_clock(files, works):
    result = works("read", *files, "-o", "trial.csv")
    assert "joined by their movement: left_wheel lags by " in result.stderr
    found = re.findall(LAG, result.stderr)
    assert [name for name, _, _ in found] == ["left_wheel", "right_wheel"]
    page = re.findall(LAG, (ROOT / "book" / "your_recordings.md").read_text())
    for shown, (name, lag, sd) in zip(page, found, strict=True):
        assert shown[0] == name
        assert abs(float(shown[1]) - float(lag)) < 2e-4 and abs(float(shown[2]) - float(sd)) < 2e-4
    for (_, lag, sd), true in zip(found, (-7.3, 132.71), strict=True):
        assert abs(float(lag) - true) < 3 * float(sd) and float(sd) < 0.001
    assert "format    canonical CSV" in result.stdout
    table = pd.read_csv("trial.csv")
    assert [c for c in table if c.endswith("gyr_x_radps")] == [f"{n}_gyr_x_radps" for n in COLUMNS]
    truth = pd.read_csv(COURT / "court.csv.gz")
    begin = truth.time_s[140]  # the one that begins last
    for name in COLUMNS:
        x = f"{name}_gyr_y_radps"
        there = np.interp(table.time_s + begin, truth.time_s, truth[x])
        assert np.sqrt(np.mean((table[x] - there) ** 2)) < 0.05


def test_a_command_takes_the_files_as_well(files, works):
    trial = ",".join(f"{name}={name}.csv" for name in COLUMNS)
    options = [
        *("--static", COURT / "static.csv.gz", "--straight", COURT / "straight.csv.gz"),
        *("--geometry", COURT / "geometry.toml", "-o", "v.csv"),
    ]
    result = works("wheelchair", "velocity", trial, *options)
    assert "joined by their movement" in result.stderr
    found = pd.read_csv("v.csv")
    truth = pd.read_csv(COURT / "truth.csv.gz")
    speed = np.interp(found.time_s + truth.time_s[140], truth.time_s, truth.linear_velocity_mps)
    assert np.sqrt(np.mean((found.linear_velocity_mps - speed) ** 2)) < 0.03


def test_what_says_nothing_is_asked_for(files, fails, works):
    for name in COLUMNS:
        own = pd.read_csv(f"{name}.csv").iloc[:300]  # at rest
        own.to_csv(f"{name}.csv", index=False)
    fails("read", *files, says=["expected 10 to 28800 s", "clock=same"])
    for name, shift in zip(COLUMNS, (0.0, -7.3, 132.71), strict=True):
        own = pd.read_csv(f"{name}.csv")
        own["time_s"] -= shift
        own.to_csv(f"{name}.csv", index=False)
    result = works("read", *files, "clock=same")
    assert "joined by" not in result.stderr


def test_an_input_is_not_replaced(files, fails):
    fails("read", *files, "-o", "left_wheel.csv", says=["left_wheel.csv", "is an input"])


def test_a_recording_without_a_gyroscope_is_shown(tmp_path, works):
    table = pd.read_csv(COURT / "court.csv.gz")
    table.filter(regex="^time_s$|_acc_").to_csv(tmp_path / "acc.csv", index=False)
    result = works("read", "acc.csv", "-o", "own.csv")
    assert result.stdout.count("gyr     none") == 3
    table.filter(regex="^time_s$|_acc_|^frame_").to_csv(tmp_path / "one.csv", index=False)
    result = works("read", "one.csv")
    assert result.stdout.count("gyr     none") == 2 and "at rest" in result.stdout


def test_a_written_recording_says_where_its_times_begin(files, works):
    """Canonical tables of different sensors, written one by one, do not share a start."""
    for k, name in enumerate(files):  # 20 s, over the same time
        begin = 800 - 70 * k
        pd.read_csv(name).iloc[begin : begin + 2000].to_csv(name, index=False)
    result = works("read", *files, "-o", "trial.csv")
    assert "its times count from its first sample: clock=same does not fit" in result.stderr
    assert "count from its first" not in works("read", "trial.csv", "-o", "again.csv").stderr
    one = ",".join(f"{name}={name}.csv" for name in COLUMNS)
    for clocks in ([], ["clock=start"]):
        own = works("read", one, *clocks, "-o", "own.csv").stderr
        assert "count from its first sample" in own
        assert ("joined by their movement" in own) == (not clocks)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("line", [["Frame=frame.csv", "frame=none.csv"], ["a=frame.csv,A=b.csv"]])
def test_names_that_differ_in_case_only_are_refused_before_a_file_is_read(fails, line):
    """Columns of tables have names in any case; one name for two files would be wrong as well."""
    said = fails("read", *line, "-o", "out.csv", says=["differ only in upper and lower case"])
    assert said.endswith("; give each file a name of its own")
