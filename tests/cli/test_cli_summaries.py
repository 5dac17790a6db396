"""What a command says when it has done its work: read, found, written; in at most five lines."""

import shlex

import pandas as pd
import pytest
from command_lines import (
    COMMANDS,
    CORRIDOR,
    COURT,
    angles,
    calibrate,
    name_of,
    trajectory,
    velocity,
)

from mobility_imu.cli.messages import MOST_LINES, summarize

PARKED = ["scooter", "calibrate", "simulated/parked_level.csv.gz", "simulated/parked_ramp.csv.gz"]


@pytest.fixture
def parked(works):
    works("simulate", "scooter", "--seed", 1, "-o", "simulated")
    files = ["--geometry", "simulated/geometry.toml", "--poses", "simulated/poses.csv"]
    return [*PARKED, *files, "-o", "m.toml"]


def lines_of(result):
    lines = result.stderr.splitlines()
    return [line for line in lines if not line.startswith("mobility-imu: warning: ")]


NEED_POSES = ("scooter calibrate", "scooter check")


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("command", [c for c in COMMANDS if c not in NEED_POSES])
def test_every_command_says_what_it_read_and_wrote(room, works, command):
    arguments, inputs, options = COMMANDS[command]
    outputs = [part for option in options for part in (option, name_of(command, option))]
    result = works(*command.split(), *arguments, *outputs)
    lines = lines_of(result)
    assert result.stdout == "" and 3 <= len(lines) <= MOST_LINES
    assert lines[0].startswith(f"read: {inputs[0]}: ")
    assert lines[-1] == "written: " + ", ".join(name_of(command, option) for option in options)
    quiet = works(*command.split(), *arguments, *outputs, "--quiet")
    assert lines_of(quiet) == [] and quiet.stdout == ""
    warned = set(result.stderr.splitlines()) - set(lines)
    assert set(quiet.stderr.splitlines()) == warned


def test_a_ride_tells_its_angles(room, works):
    read, steering, throttle, valid, _ = lines_of(works(*angles()))
    assert read == "read: ride.csv: body, lever; 2.0 s at 100 Hz"
    table = pd.read_csv(room / "a.csv")
    for line, name in ((steering, "steering"), (throttle, "throttle")):
        low, high = table[f"{name}_deg"].agg(["min", "max"])
        assert line == f"{name}: {low:.1f} to {high:.1f} deg, sd not known"
    assert valid == "valid: 100 % of 200 samples"
    with_noise = lines_of(works(*angles(), "--acc-noise-mps2", 0.1))
    sd = pd.read_csv(room / "a.csv")["steering_sd_deg"].median()
    assert with_noise[1].endswith(f"sd {sd:.2g} deg (median)")


def test_a_calibration_tells_the_turns_of_both_sensors(parked, works):
    read, lever, body, written = lines_of(works(*parked))
    assert read == "read: 2 parked recordings, 6 poses in each" and written == "written: m.toml"
    assert lever.startswith("lever's IMU: 1.64 deg") and body.startswith("body's IMU: 1.13 deg")


def test_a_drive_tells_its_way_and_its_turn(works, tmp_path):
    _, way, turn, slip, _ = lines_of(works(*velocity()))
    table = pd.read_csv(tmp_path / "v.csv")
    assert way.startswith(f"distance forward: {table['linear_velocity_mps'].sum() / 100:.2f} m")
    turned = table["yaw_rate_degps"].sum() / 100
    assert turn.startswith(f"turn from beginning to end: {turned:.0f} deg (sd at most ")
    assert slip == "slip: 0 % of the time"


def test_a_drive_of_which_nothing_is_known_has_no_task(room, works):
    table = pd.read_csv(room / "velocity.csv").assign(valid=0)
    table.to_csv(room / "unknown.csv", index=False)
    _, kinds, unknown, _ = lines_of(works("wheelchair", "tasks", "unknown.csv", "-o", "t.csv"))
    assert kinds == "0 kinds of task" and unknown == "not known: 6.0 s"


def test_a_check_keeps_standard_output_for_its_table(works):
    files = ["--static", COURT / "static.csv.gz", "--straight", COURT / "straight.csv.gz"]
    line = ["wheelchair", "check", COURT / "court.csv.gz", *files, "--geometry"]
    result = works(*line, COURT / "geometry.toml")
    assert result.stdout.startswith("wheels' yaw rate") and "read" not in result.stdout
    assert lines_of(result)[1:] == ["geometry: fits"]


def test_a_walk_tells_its_end_and_its_steps(works, short, tmp_path):
    _, used, place, turns, _ = lines_of(works(*calibrate()))
    assert used == "tilts used: front, back, right, left"
    assert place.startswith("IMU at x, y, z = ") and place.endswith(" mm")
    assert turns.startswith("sd of roll, pitch, yaw: ") and turns.endswith(" deg")
    walk = ["walker", "trajectory", short, "--geometry", "m.toml"]
    _, end, turn, steps, _ = lines_of(works(*walk, "-o", "path.csv", "--steps", "s.csv"))
    path = pd.read_csv(tmp_path / "path.csv").iloc[-1]
    assert end == (
        f"end at x = {path['x_m']:.2f} m, y = {path['y_m']:.2f} m "
        f"(sd {path['x_sd_m']:.2g} and {path['y_sd_m']:.2g} m)"
    )
    assert turn.startswith(f"turn from beginning to end: {round(path['yaw_deg'])} deg")
    assert steps.startswith(f"steps: {len(pd.read_csv(tmp_path / 's.csv'))}, ")


def test_a_simulation_tells_the_next_command(works, tmp_path):
    said = lines_of(works("simulate", "walker", "--seed", 3, "-o", "a b"))
    command = said[-1].removeprefix("next: mobility-imu ")
    assert "'a b'/tilts.csv.gz" in command
    works(*shlex.split(command))
    assert (tmp_path / "mount.toml").is_file()


def test_a_path_without_steps_is_summarized_all_the_same(works):
    walk = trajectory(walk=CORRIDOR / "tilts.csv.gz", mount=CORRIDOR / "true_mount.toml")
    assert lines_of(works(*walk))[-1] == "written: path.csv"


def test_a_summary_is_never_longer_and_each_part_one_line(capsys):
    summarize([f"line {k}\nand more" for k in range(9)], quiet=False)
    assert capsys.readouterr().err.splitlines() == [f"line {k} and more" for k in range(MOST_LINES)]
    summarize(["a"], quiet=True)
    assert capsys.readouterr() == ("", "")
