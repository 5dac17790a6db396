"""Folders that were removed or may not be entered, clocks given twice, settings of nothing."""

import errno
import os
from pathlib import Path

import pytest
from command_lines import SCOOTER_TOML, angles, scooter_ride, velocity_csv

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand


def forbidden(monkeypatch, folder):
    """Folder that may be named, but not entered: a superuser may enter every one."""
    stat = os.stat

    def of(path, *arguments, **options):
        if isinstance(path, str | Path) and Path(path).parent == folder:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return stat(path, *arguments, **options)

    monkeypatch.setattr(os, "stat", of)


@pytest.mark.parametrize("name", [".", "..", "./"])
def test_a_current_folder_that_was_removed(tmp_path, monkeypatch, fails, name):
    gone = tmp_path / "above" / "gone"
    gone.mkdir(parents=True)
    monkeypatch.chdir(gone)
    gone.rmdir()
    (tmp_path / "above").rmdir()
    try:
        fails("read", name, says=["the current folder does not exist any more"])
    finally:
        monkeypatch.chdir(tmp_path)


def test_a_file_in_a_folder_that_may_not_be_entered(tmp_path, monkeypatch):
    folder = tmp_path / "closed"
    folder.mkdir()
    scooter_ride(folder)
    forbidden(monkeypatch, folder)
    for name in ("ride.csv", "Trial"):
        with pytest.raises(InputError, match=f"{name}: cannot be read .Permission denied"):
            understand(folder / name)


def test_a_name_that_no_file_can_have(tmp_path, monkeypatch):
    """Windows says so of a name with a question mark."""
    stat = os.stat

    def of(path, *arguments, **options):
        if "?" in str(path):
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL), str(path))
        return stat(path, *arguments, **options)

    monkeypatch.setattr(os, "stat", of)
    with pytest.raises(InputError, match="no such file"):
        understand(tmp_path / "ride?.csv")


def test_a_session_in_a_folder_that_may_not_be_entered(tmp_path, monkeypatch):
    (tmp_path / "Inertial.csv").write_text("")
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(InputError, match="the folder cannot be read"):
        understand(tmp_path)


def test_a_link_that_leads_to_itself(tmp_path, fails):
    (tmp_path / "loop").symlink_to("loop")
    fails("read", "loop", says=["loop: cannot be read (Too many levels of symbolic links)"])


@pytest.mark.parametrize("clocks", [("own", "own"), ("own", "same"), ("start", "start")])
@pytest.mark.parametrize("joined", [False, True])
def test_a_clock_that_is_given_twice(tmp_path, fails, clocks, joined):
    scooter_ride(tmp_path)
    parts = ["lever=ride.csv#lever", *(f"clock={clock}" for clock in clocks)]
    parts = [",".join(parts)] if joined else parts
    fails("read", *parts, says=["the clock is named twice; give it once"])
    parts = ["lever=ride.csv#lever", "lever=ride.csv#body"]
    fails("read", *parts, says=["the sensor lever is named twice; give it once"])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"segment_s": null}', "segment_s = null, which is read as 0: expected a positive"),
        ('{"inptSegmentsec": null}', "inptSegmentsec = null, which is read as 0: expected a pos"),
        ('{"wide_radius_m": null}', "larger than wide_radius_m = null, which is read as 0"),
        ('{"freqAcq": null}', "freqAcq = null, expected the sampling rate in Hz"),
        ('{"segment_s": 0}', "segment_s = 0.0: expected a positive"),
    ],
)
def test_settings_that_are_null(tmp_path, fails, text, says):
    velocity_csv(tmp_path / "v.csv")
    (tmp_path / "s.json").write_text(text)
    fails(
        "wheelchair",
        "tasks",
        "v.csv",
        "--settings",
        "s.json",
        "-o",
        "k.csv",
        says=["s.json: ", says],
    )


@pytest.mark.parametrize("stated", ["", "sd_rad = [1, 1, 1, 1, 1, 1]\n"], ids=["empty", "sd"])
def test_a_mount_without_its_keys(tmp_path, fails, stated):
    scooter_ride(tmp_path)
    (tmp_path / "g.toml").write_text(f"{SCOOTER_TOML}[scooter.mount]\n{stated}")
    what = "it is missing" if stated else "the section is empty"
    says = f"g.toml, [scooter.mount] rotation_lever_imu_to_lever: expected 3 x 3 numbers; {what}"
    fails(*angles(), says=[says])


@pytest.mark.parametrize("command", ["calibrate", "check"])
def test_a_table_of_one_pose(simulated, fails, command):
    Path("poses.csv").write_text("steering_deg,throttle_deg\n0,0\n")
    line = ["scooter", command, "parked_level.csv.gz", "--geometry", "geometry.toml"]
    line += ["--poses", "poses.csv", *(["-o", "m.toml"] if command == "calibrate" else [])]
    said = fails(*line, says=["expected 1, one per pose; three poses or more are needed"])
    assert "names" not in said


@pytest.mark.parametrize("command", ["calibrate", "check"])
@pytest.mark.parametrize(
    ("row", "says"),
    [
        ("0,", "line 3, column throttle_deg: expected a number, got nothing"),
        ("nan,0", "line 3, column steering_deg: expected a number, got nothing"),
        ("0,inf", "line 3, column throttle_deg: expected a number, got nothing"),
        ("0,-400", "line 3: an angle of 400, expected between -180 and 180 deg"),
        ("TRUE,0", "line 3, column steering_deg: 'TRUE' is not a number"),
    ],
)
def test_a_pose_that_is_none_is_named_with_its_line(simulated, fails, command, row, says):
    Path("poses.csv").write_text(f"steering_deg,throttle_deg\n0,0\n{row}\n10,10\n")
    line = ["scooter", command, "parked_level.csv.gz", "--geometry", "geometry.toml"]
    line += ["--poses", "poses.csv", *(["-o", "m.toml"] if command == "calibrate" else [])]
    fails(*line, says=[f"poses.csv: {says}"])
