"""Wheelchair on the command line: from raw trials to velocities, tasks and a chronogram."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command_lines import COURT, velocity, velocity_csv

from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction import recorded

ROOT = Path(__file__).resolve().parents[2]


def test_from_raw_trial_to_chronogram(tmp_path, works):
    works(*velocity())
    found = pd.read_csv(tmp_path / "v.csv")
    assert list(found) == [
        "time_s",
        "linear_velocity_mps",
        "yaw_rate_degps",
        "slip",
        "linear_velocity_sd_mps",
        "yaw_rate_sd_degps",
        "valid",
    ]
    truth = pd.read_csv(COURT / "truth.csv.gz")
    # Simulated noise and bias: 0.003 rad/s on the gyroscopes, times the radius.
    error = found["linear_velocity_mps"] - truth["linear_velocity_mps"]
    assert np.sqrt((error**2).mean()) < 0.002
    assert found["slip"].sum() == 0

    works("wheelchair", "tasks", "v.csv", "-o", "tasks.csv", "--figure", "chronogram.png")
    tasks = pd.read_csv(tmp_path / "tasks.csv")
    assert list(tasks) == [
        "time_s",
        "linear_velocity_mps",
        "yaw_rate_degps",
        "task_code",
        "task",
        "valid",
    ]
    assert tasks["valid"].eq(1).all()
    assert set(tasks["task_code"]) == {1, 2, 3, 4, 5, 6}
    assert tasks.groupby("task_code")["task"].nunique().eq(1).all()
    assert (tmp_path / "chronogram.png").read_bytes().startswith(b"\x89PNG")


def test_printed_camber_falsifies_the_yaw_of_the_wheels(tmp_path, works):
    works(*velocity(), "--camber", "printed")
    assert pd.read_csv(tmp_path / "v.csv")["slip"].mean() > 0.2


def test_check_events_and_filters(tmp_path, works, fails):
    trials = velocity()[2:-2]
    assert "the geometry fits" in works("wheelchair", "check", *trials).stdout
    wrong = (COURT / "geometry.toml").read_text().replace("track_m = 0.84", "track_m = 0.80")
    (tmp_path / "wrong.toml").write_text(wrong)
    result = works("wheelchair", "check", *trials[:-1], tmp_path / "wrong.toml")
    assert "0.840 m, not 0.800 m" in result.stdout
    works(*velocity(), "--filter", "savitzky-golay", "--filter-window", 9)
    works("wheelchair", "tasks", "v.csv", "-o", "t.csv", "--events", "e.csv", "--direction")
    events = pd.read_csv(tmp_path / "e.csv")
    assert events["duration_s"].sum() == pytest.approx(52.5)
    tasks = pd.read_csv(tmp_path / "t.csv")
    assert set(tasks["direction"].dropna()) == {"left", "right"}


@pytest.mark.parametrize(
    ("kind", "option", "value", "says"),
    [
        ("moving-average", "--filter-window", 8, "expected an odd number"),
        ("moving-average", "--filter-window", 100001, "longer than the 5250 samples"),
        ("savitzky-golay", "--filter-window", -1, "expected an odd number"),
        ("savitzky-golay", "--filter-order", 9, "expected from 0 to one less than --filter-window"),
        ("savitzky-golay", "--filter-order", -1, "expected a whole number of 0 or more"),
    ],
)
def test_an_impossible_filter_is_named_as_typed(fails, kind, option, value, says):
    line = fails(*velocity(), "--filter", kind, option, value)
    assert f": {option} {value}: {says}" in line


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"seuilRayonMin": -1}, "s.json: seuilRayonMin = -1.0: expected"),
        ({"inptSegmentsec": 1e9}, "s.json: inptSegmentsec = 1e+09: more than"),
        ({"inptSegmentsec": 1e-4}, "s.json: inptSegmentsec = 0.0001 is less than one frame"),
        ({"look_s": 1e9}, "s.json: look_s = 1e+09: more than"),
        ({"freqAcq": -5}, "s.json: freqAcq: sampling rate of -5.0 Hz"),
    ],
)
def test_an_impossible_setting_is_named_by_the_key_of_its_file(tmp_path, fails, settings, says):
    velocity_csv(tmp_path / "v.csv")
    (tmp_path / "s.json").write_text(json.dumps(settings))
    fails("wheelchair", "tasks", "v.csv", "-o", "t.csv", "--settings", "s.json", says=[says])


@pytest.mark.parametrize("name", ["t.csv", "t.csv.gz"])
def test_tasks_are_read_again(tmp_path, works, name):
    """The table of tasks has the velocities that it was made from."""
    velocity_csv(tmp_path / "v.csv")
    works("wheelchair", "tasks", "v.csv", "-o", name, "--direction")
    works("wheelchair", "tasks", name, "-o", "again.csv", "--direction")
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / name), pd.read_csv(tmp_path / "again.csv"))


def test_no_task_is_named_where_the_velocities_are_not_valid(tmp_path, works):
    table = velocity_csv(tmp_path / "v.csv")
    table["linear_velocity_sd_mps"] = np.where(table["time_s"].between(2, 2.5), np.inf, 0.01)
    table["valid"] = (~table["time_s"].between(4, 5)).astype(int)
    table.to_csv(tmp_path / "v.csv", index=False)
    result = works("wheelchair", "tasks", "v.csv", "-o", "t.csv", "--events", "e.csv",
                   "--figure", "f.png")  # fmt: skip
    assert "not valid for 1.5 of 6.0 s (2.00 to 2.50 s, 4.00 to 5.00 s)" in result.stderr
    tasks, events = pd.read_csv(tmp_path / "t.csv"), pd.read_csv(tmp_path / "e.csv")
    # A vote reaches nearly a segment of 0.25 s to both sides.
    reached = table["time_s"].between(1.755, 2.745) | table["time_s"].between(3.755, 5.245)
    assert (tasks["valid"] == ~reached).all()
    for event in events.itertuples():
        inside = (tasks["time_s"] >= event.onset_s) & (tasks["time_s"] < event.end_s - 0.001)
        assert event.valid == tasks["valid"][inside].min()
    assert set(events["valid"]) == {0, 1}
    without = works("wheelchair", "tasks", "v.csv", "-o", "t.csv", "--quiet").stderr
    assert "not valid" in without


def of_table(table):
    """Recording of a chair's table, as it is before it is written."""
    halves = ("acc", "mps2"), ("gyr", "radps")
    sensors = {
        name: Imu(*(table.filter(regex=f"^{name}_{half}_._{unit}$") for half, unit in halves))
        for name in ("frame", "left_wheel", "right_wheel")
    }
    return Recording(table["time_s"], sensors)


def test_lags_of_clocks_are_not_in_the_standard_deviations():
    """The numbers of the page on how to use the book, of the courts that the command simulates."""
    from mobility_imu.simulation.bundle import wheelchair_bundle
    from mobility_imu.wheelchair import SAMPLE_CHAIR, calibrate_mount, estimate_velocity

    speeds, yaws = [], []
    for seed in (1, 2, 3):
        _, *trials, truth = wheelchair_bundle(seed, level="real").values()
        static, straight, court = map(of_table, trials)
        by = calibrate_mount(static, straight)
        found = estimate_velocity(court, SAMPLE_CHAIR, by.mount, offsets=by.offsets)
        table = found.to_frame()
        for name, sd, into in (
            ("linear_velocity_mps", "linear_velocity_sd_mps", speeds),
            ("yaw_rate_degps", "yaw_rate_sd_degps", yaws),
        ):
            into.append(((table[name] - truth[name]).abs() < 2 * table[sd]).mean())
    assert (round(100 * min(yaws)), round(100 * max(yaws))) == (62, 66)
    assert (round(100 * min(speeds)), round(100 * max(speeds))) == (80, 93)


def test_the_page_states_how_many_speeds_of_real_chairs_are_within_twice_their_deviation():
    inside = {
        name: round(100 * recorded.numbers(name)["summary"]["speed_inside"])
        for name in ("real_chair_mocap", "held_chairs", "dropped_chairs")
    }
    page = " ".join((ROOT / "book" / "how_to_use.md").read_text().split())
    assert inside == {"real_chair_mocap": 98, "held_chairs": 97, "dropped_chairs": 89}
    assert "98 % of the speeds are within twice their deviation" in page
    assert "in the held-back trials 97 %." in page
    assert "In the trials that the choice left out, 89 % are." in page
    dropped = recorded.numbers("dropped_chairs")["summary"]["speed_sd_over_rms"]["median"]
    assert round(1 / dropped, 1) == 3.5
    assert "the rms error is 3.5 times the stated deviation (median)" in page


def test_a_fault_that_was_found_is_named_where_the_estimate_refuses(tmp_path, fails):
    """The estimate sees no more than that the wheels turn against the frame."""
    trial = pd.read_csv(COURT / "court.csv.gz")
    trial[[f"frame_gyr_{axis}_radps" for axis in "xyz"]] *= -1
    trial.to_csv(tmp_path / "trial.csv", index=False)
    line = fails(*velocity(tmp_path / "trial.csv"), says=["swapped, or the frame's sensor"])
    assert line.index("frame_gyr turns the other way than both wheels") < line.index(
        "the estimate refuses"
    )


SETTINGS = {
    "freqAcq": 100,
    "inptSegmentsec": 0.5,
    "seuilVitLinAbs": 0.5,
    "seuilVitAngAbs": 40,
    "seuilRayonMin": 0.2,
    "seuilRayonMax": 0.5,
    "newSeuilVitLinAbs": None,
    "newSeuilVitAngAbs": 10,
}


@pytest.fixture
def with_settings(tmp_path):
    """Command line of ``wheelchair tasks`` with settings, given as JSON text or as an object."""
    velocity_csv(tmp_path / "v.csv")

    def with_settings(content):
        text = content if isinstance(content, str) else json.dumps(content)
        (tmp_path / "s.json").write_text(text)
        return ["wheelchair", "tasks", "v.csv", "-o", "tasks.csv", "--settings", "s.json"]

    return with_settings


def test_tool_settings_file(with_settings, works, fails):
    works(*with_settings(SETTINGS), "--edge", "tool")
    fails(*with_settings(SETTINGS | {"freqAcq": 50}), says=["50 Hz", "100 Hz"])
    fails(*with_settings({"seuilVitLin": 1}), says=["seuilVitLin", "not a setting"])


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ('{"freqAcq": 0}', "freqAcq: sampling rate of 0"),
        ('{"freqAcq": null}', "freqAcq = null, expected the sampling rate"),
        ('{"freqAcq": NaN}', "freqAcq = nan, expected a number"),
        ('{"freqAcq": -100}', "freqAcq: sampling rate of -100"),
        ('{"freqAcq": "100"}', "freqAcq = '100', expected a number"),
        ('{"seuilVitLinAbs": true}', "seuilVitLinAbs = True, expected a number"),
        ('{"seuilVitLinAbs": "0.5"}', "seuilVitLinAbs = '0.5', expected a number"),
        ('{"seuilVitLinAbs": 1, "seuilVitLinAbs": 2}', "seuilVitLinAbs appears twice"),
        ('{"seuilVitLinAbs": NaN}', "seuilVitLinAbs = nan, expected a number"),
        ('{"seuilVitLinAbs": 1' + 310 * "0" + "}", "expected a number"),
        ('{"seuilVitLinAbs": 1' + 5000 * "0" + "}", "too many digits"),
        (100_000 * "[", "nested too deeply"),
        ('{"seuilVitLinAbs": ' + 100_000 * '{"a": ', "nested too deeply"),
        ("[1, 2]", "expected a JSON object"),
        ("{", "not valid JSON"),
        ('{"a\x1b[2J": 1}', "not valid JSON"),
        ('{"a\\u001b[2J": 1}', r"a\x1b[2J is not a setting"),
    ],
)
@pytest.mark.usefixtures("no_collection")
def test_faulty_settings_are_one_line(with_settings, fails, content, says):
    fails(*with_settings(content), says=["s.json", says])


def test_uneven_segment_warns(with_settings, works):
    result = works(*with_settings({"segment_s": 0.255}), "--quiet")
    assert "warning" in result.stderr and "25.5 frames" in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_bad_input(tmp_path, fails):
    static, court = COURT / "static.csv.gz", COURT / "court.csv.gz"
    fails(*velocity(COURT / "none.csv"), says=["none.csv", "no such file"])
    fails(*velocity(static=court), says=["rad/s", "static trial"])
    fails(*velocity(straight=static), says=["straight-line trial"])
    fails(*velocity(straight=court), says=["across its axle"])
    fails(*velocity(geometry=COURT / "none.toml"), says=["no such file"])
    velocity_csv(tmp_path / "v.csv")
    figure = ["v.csv", "-o", "t.csv", "--figure", "chronogram.xyz"]
    fails("wheelchair", "tasks", *figure, says=["--figure", ".png"])
    fails("wheelchair", "tasks", "v.csv", "-o", "none/t.csv", says=["no such folder"])


def test_units_of_velocities_are_asked_for(tmp_path, works, fails):
    velocity_csv(tmp_path / "own.csv")
    text = (tmp_path / "own.csv").read_text()
    bare = text.replace("_mps", "").replace("_degps", "")
    (tmp_path / "v.csv").write_text(bare)
    fails(
        *["wheelchair", "tasks", "v.csv", "-o", "t.csv"],
        says=["linear_velocity states no unit", "--units 'm/s, deg/s'"],
    )
    works("wheelchair", "tasks", "v.csv", "--units", "m/s, deg/s", "-o", "t.csv", "--quiet")
    works("wheelchair", "tasks", "own.csv", "-o", "same.csv", "--quiet")
    assert (tmp_path / "t.csv").read_bytes() == (tmp_path / "same.csv").read_bytes()


def test_a_fault_is_told_with_its_cost_and_refused_when_strict(tmp_path, works, fails):
    """A wheel's gyroscope reads 6 % too much: told once, with what it moves; samples not valid."""
    command = velocity()
    court = pd.read_csv(command[2])
    rates = [name for name in court if name.startswith("right_wheel_gyr")]
    court[rates] *= 1.06
    court.to_csv(tmp_path / "scaled.csv", index=False)
    command[2] = tmp_path / "scaled.csv"
    said = works(*command).stderr
    assert said.count("right_wheel_gyr reads") == 1
    assert "% too much, by the turns of the wheel as gravity counts them" in said
    assert "it moves the speed by up to 0.0" in said and "the distance by up to" in said
    assert not pd.read_csv(tmp_path / "v.csv")["valid"].any()
    (tmp_path / "v.csv").unlink()
    fails(*command, "--strict", says=["right_wheel_gyr reads"])
    assert not (tmp_path / "v.csv").exists()
    trials = command[2:-2]
    assert "right_wheel_gyr reads" in works("wheelchair", "check", *trials).stderr
    fails("wheelchair", "check", *trials, "--strict", says=["right_wheel_gyr reads"])


def changed(tmp_path, path, name, change):
    """A trial whose table is changed, under another name."""
    table = pd.read_csv(path)
    change(table)
    table.to_csv(tmp_path / name, index=False)
    return tmp_path / name


def test_strict_looks_at_the_sensors_that_a_command_uses(tmp_path, works, fails):
    """The calibration's trials need no accelerometer of a wheel; they need the gyroscopes."""

    def hold(half):
        def change(table):
            names = [name for name in table if name.startswith(f"left_wheel_{half}")]
            table.loc[300:500, names] = table.loc[300, names].to_numpy()

        return change

    court = pd.read_csv(COURT / "court.csv.gz")
    court[court["time_s"] < 15].to_csv(tmp_path / "short.csv", index=False)
    command = velocity(tmp_path / "short.csv")
    straight = command.index("--straight") + 1
    kept = command[straight]
    command[straight] = changed(tmp_path, kept, "acc.csv", hold("acc"))
    trials = command[2:-2]
    works(*command, "--strict")
    works("wheelchair", "check", *trials, "--strict")
    (tmp_path / "v.csv").unlink()
    command[straight] = changed(tmp_path, kept, "gyr.csv", hold("gyr"))
    fails(*command, "--strict", says=["left_wheel_gyr", "repeats its last reading"])


def test_a_range_that_is_cut_is_said_once(tmp_path, works):
    """In the drive and in the straight-line trial, by both commands, of a range that is sold."""

    def cut(table):
        names = [name for name in table if name.startswith("left_wheel_gyr")]
        table[names] = table[names].clip(-np.deg2rad(125), np.deg2rad(125))

    command = velocity()
    for place, name in ((2, "drive.csv"), (command.index("--straight") + 1, "line.csv")):
        command[place] = changed(tmp_path, command[place], name, cut)
    for result in (works(*command), works("wheelchair", "check", *command[2:-2])):
        said = result.stdout + result.stderr
        for name in ("drive.csv", "line.csv"):
            about = [s for s in said.splitlines() if name in s and "end of its range" in s]
            assert len(about) == 1 and "choose a wider range" in about[0]
    valid = pd.read_csv(tmp_path / "v.csv")["valid"]
    assert 0.2 < valid.mean() < 1.0


@pytest.mark.parametrize("percent", ["-1", "nan", "inf", "150"])
def test_the_scale_of_gyroscopes_is_refused_by_its_option(fails, percent):
    files = {name: COURT / f"{name}.csv.gz" for name in ("court", "static", "straight")}
    options = ["--static", files["static"], "--straight", files["straight"]]
    options += ["--geometry", COURT / "geometry.toml", "--gyroscope-scale-percent", percent]
    says = [f"--gyroscope-scale-percent {percent}: expected 0 to 100"]
    fails("wheelchair", "check", files["court"], *options, says=says)


def test_a_count_as_clock_is_named_with_its_file(tmp_path, fails):
    table = velocity_csv(tmp_path / "v.csv")
    table["time_s"] = range(len(table))
    table.to_csv(tmp_path / "v.csv", index=False)
    says = ["v.csv: segment_s = 0.25 is less than one frame at 1 Hz; are its times in s"]
    fails("wheelchair", "tasks", "v.csv", "-o", "t.csv", says=says)
    (tmp_path / "s.json").write_text('{"inptSegmentsec": 0.25}')
    says = ["s.json: inptSegmentsec = 0.25 is less", "has v.csv its times in s, and no count"]
    fails("wheelchair", "tasks", "v.csv", "-o", "t.csv", "--settings", "s.json", says=says)
