"""Angles against a protractor on the command line."""

import pandas as pd
import pytest

PARKED = ("parked_level.csv.gz", "parked_ramp.csv.gz")
POSES = ("--poses", "poses.csv")


@pytest.fixture(scope="module")
def written():
    """Text of the calibrated scooter, once it was written."""
    return []


@pytest.fixture
def calibrated(simulated, works, written, tmp_path):
    """The simulated scooter with a mount by its parked recordings."""
    path = tmp_path / "s.toml"
    if not written:
        line = ("scooter", "calibrate", *PARKED, "--geometry", "geometry.toml", *POSES, "-o", path)
        works(*line)
        written.append(path.read_text())
    path.write_text(written[0])


@pytest.mark.usefixtures("calibrated")
@pytest.mark.parametrize("method", ["closed-form", "fusion"])
def test_a_calibrated_scooter_agrees_with_its_stops(tmp_path, works, method):
    options = ("--geometry", "s.toml", *POSES, "--method", method, "--sensors", "calibrated")
    result = works("scooter", "check", PARKED[1], *options, "-o", "c.csv")
    told, lines = result.stdout, result.stdout.splitlines()
    summary = result.stderr.splitlines()
    assert summary[0].startswith(f"read: {PARKED[1]}: body, lever")
    assert len(summary) == 5 and summary[-1] == "written: c.csv"
    quiet = works("scooter", "check", PARKED[1], *options, "--quiet")
    assert quiet.stderr == "" and quiet.stdout == told
    table = pd.read_csv(tmp_path / "c.csv")
    assert list(table) == [
        "pose",
        "start_s",
        "stop_s",
        "control",
        "set_deg",
        "found_deg",
        "difference_deg",
        "sd_deg",
        "inside_95",
        "judged",
    ]
    assert len(table) == 12 and lines[0].startswith("pose  control")
    assert sum(line.endswith(("yes", "no")) for line in lines) == 12
    assert table["difference_deg"].abs().max() < 5
    if method == "closed-form":
        assert "- agrees: " in told


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize("command", ["calibrate", "check"])
def test_a_gap_of_a_parked_recording_is_bridged_as_the_message_says(fails, works, command):
    pd.read_csv(PARKED[0]).drop(index=range(300, 306)).to_csv("gap.csv", index=False)
    line = ["scooter", command, "gap.csv", "--geometry", "geometry.toml", *POSES]
    line += [PARKED[1], "-o", "m.toml"] if command == "calibrate" else []
    fails(*line, says=["gap of 0.07 s", "give --fill-gaps-s"])
    assert "gap(s) filled in with 6" in works(*line, "--fill-gaps-s", 0.07).stderr


@pytest.mark.usefixtures("calibrated")
def test_poses_of_another_order_differ(tmp_path, works):
    poses = pd.read_csv(tmp_path / "poses.csv")
    poses[::-1].to_csv(tmp_path / "reversed.csv", index=False)
    told = works(
        "scooter", "check", PARKED[0], "--geometry", "s.toml", "--poses", "reversed.csv"
    ).stdout
    assert "- differs: " in told and not (tmp_path / "c.csv").exists()


@pytest.mark.usefixtures("calibrated")
def test_bad_input(tmp_path, fails):
    usual = ("scooter", "check", PARKED[0], "--geometry", "s.toml")
    fails(*usual, says=["--poses"])
    fails(*usual, "--poses", "none.csv", says=["none.csv", "no such file"])
    (tmp_path / "few.csv").write_text("steering_deg,throttle_deg\n0,0\n")
    fails(*usual, "--poses", "few.csv", says=["still ", "expected 1, one per pose"])
    (tmp_path / "radians.csv").write_text("steering_rad,throttle_rad\n0,0\n")
    fails(*usual, "--poses", "radians.csv", says=["steering_deg"])
    fails(*usual, *POSES, "--scale-sd-deg", "0", says=["--scale-sd-deg"])
    fails(*usual, *POSES, "--sensors", "cheap", says=["--sensors"])
