"""Inputs that are damaged, hostile or misspelt: one line each, exit code 2."""

import gzip
import os

import numpy as np
import pandas as pd
import pytest
from command_lines import (
    CORRIDOR,
    COURT,
    SCOOTER_TOML,
    angles,
    calibrate,
    scooter_ride,
    trajectory,
    velocity,
    velocity_csv,
)
from steps_taken import steps_of

EYE = "[[1,0,0],[0,1,0],[0,0,1]]"
SCOOTER_MOUNT = (
    f"[scooter.mount]\nrotation_lever_imu_to_lever = {EYE}\nrotation_body_imu_to_body = {EYE}\n"
)
WALKER_MOUNT = f"[walker.mount]\nrotation_imu_to_body = {EYE}\ntranslation_body_m = [0.4, 0, 0.6]\n"


@pytest.fixture
def ride(tmp_path):
    scooter_ride(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("mount", "mont"), "scooter.mont is unknown"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("scooter", "scoter"), "scoter is unknown"),
        (SCOOTER_TOML + SCOOTER_MOUNT + "fixed_with = 'glue'\n", "fixed_with is unknown"),
        (SCOOTER_TOML + "[scooter.mount.inner]\na = 1\n", "inner is unknown"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("body_imu", "body_inu"), "body_inu"),
        ("wheels = 4\n" + SCOOTER_TOML, "wheels is unknown"),
        ("[[scooter]]\n" + SCOOTER_TOML.partition("\n")[2], "write [scooter], not [[scooter]]"),
        ("scooter = 3\n", "write [scooter], not scooter = 3"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("[1,0,0]", '["1","0","0"]', 1), "3 x 3 numbers"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("[1,0,0]", "[true,0,0]", 1), "3 x 3 numbers"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("[1,0,0]", "[nan,0,0]", 1), "3 x 3 numbers"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("[1,0,0]", "[1,0]", 1), "3 x 3 numbers"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace("[1,0,0]", "1", 1), "3 x 3 numbers"),
        (SCOOTER_TOML + SCOOTER_MOUNT.replace(",0,0]", f",0,1{310 * '0'}]", 1), "3 x 3 numbers"),
        (SCOOTER_TOML.replace("20.0", '"20"'), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "true"), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "1979-05-27"), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "[20.0]"), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "nan"), "steering_inclination_deg = nan"),
        (SCOOTER_TOML.replace("20.0", "1" + 310 * "0"), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "1" + 5000 * "0"), "too many digits"),
        (SCOOTER_TOML.replace("20.0", "0x" + 5000 * "f"), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "[0x" + 5000 * "f" + "]"), "expected a number"),
        (SCOOTER_TOML.replace("20.0", "'" + 1_000_000 * "7" + "'"), "7777..."),
        ("x = " + 5000 * "[" + 5000 * "]", "nested too deeply"),
        ("x = " + 5000 * "{a = ", "TOML"),
        ("[" + 5000 * "a." + "b]\n", ""),
        (SCOOTER_TOML + SCOOTER_TOML, "not valid TOML"),
        ("[scooter]\nsteering_inclination_deg = \x1b[2J\n", "not valid TOML"),
        ("\x00", "not valid TOML"),
        ("", "the file is empty"),
    ],
)
@pytest.mark.usefixtures("no_collection")
def test_faulty_geometry_of_a_scooter(ride, fails, text, says):
    (ride / "bad.toml").write_text(text)
    fails(*angles(geometry="bad.toml"), says=["bad.toml", says])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (WALKER_MOUNT.replace("mount", "mounting"), "walker.mounting is unknown"),
        (WALKER_MOUNT + "translation_m = [1, 2, 3]\n", "translation_m is unknown"),
        (WALKER_MOUNT.replace("0.4", "'0.4'"), "translation_body_m: expected 3 numbers"),
        (WALKER_MOUNT + "translation_sd_m = [true, 1, 1]\n", "translation_sd_m"),
        (WALKER_MOUNT + "[hinge]\n", "hinge is unknown"),
    ],
)
def test_faulty_mount_of_a_walker(tmp_path, fails, text, says):
    (tmp_path / "bad.toml").write_text(text)
    fails(*trajectory(mount="bad.toml"), says=["bad.toml", says])


def test_what_the_commands_write_is_known(tmp_path, short, works):
    """The mount of one command is the geometry of the next, with standard deviations."""
    works(*calibrate())
    text = (tmp_path / "m.toml").read_text()
    assert "translation_sd_m" in text and "rotation_sd_rad" in text
    works(*trajectory(walk=short))
    (tmp_path / "m.toml").rename(tmp_path / "before.toml")
    works(*calibrate(geometry="before.toml"), "--method", "two-tilts")


def corruptions(packed, count):
    """Files with one byte changed, files cut short, files with something behind."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        broken = bytearray(packed)
        broken[rng.integers(len(packed))] ^= 1 << rng.integers(8)
        yield bytes(broken)
    yield from (packed[:k] for k in range(0, len(packed), max(1, len(packed) // count)))
    yield packed[:10] + b"\x07" + packed[11:]
    yield packed + b"behind"
    yield packed[:-8] + bytes(8)  # checksum and length
    yield b"\x1f\x8b"


def test_damaged_archives(ride, fails, works, run):
    """A damaged archive is refused, or gives the same table as before it was damaged."""
    text = (ride / "ride.csv").read_bytes()
    packed = gzip.compress(text[: text.rindex(b"\n", 0, 3000) + 1], mtime=0)
    (ride / "ride.csv.gz").write_bytes(packed)
    works(*angles("ride.csv.gz"), "--median-window", 1)
    whole = (ride / "a.csv").read_bytes()
    (ride / "a.csv").unlink()
    refused = 0
    for broken in corruptions(packed, 60):
        (ride / "ride.csv.gz").write_bytes(broken)
        result = run(*angles("ride.csv.gz"), "--median-window", 1)
        if result.returncode == 0:  # a byte of the header that means nothing
            assert (ride / "a.csv").read_bytes() == whole
            (ride / "a.csv").unlink()
            continue
        refused += 1
        assert result.returncode == 2
        assert result.stderr.startswith("mobility-imu: ride.csv.gz: ")
        assert len(result.stderr.splitlines()) == 1
        assert not (ride / "a.csv").exists()
    assert refused > 100


@pytest.mark.parametrize("name", ["n" * 300, "n" * 5000, "none/" + "n" * 300, "a\x01b" * 60])
def test_names_that_no_file_can_have(ride, fails, name):
    fails(*angles(ride=name))
    fails(*angles(geometry=name))
    fails("wheelchair", "tasks", name, "-o", "t.csv")
    fails(*trajectory(walk=name, mount=CORRIDOR / "true_mount.toml"))


@pytest.mark.parametrize("kind", ["folder", "device", "device by a link"])
def test_what_is_no_file(ride, fails, kind):
    name = {"folder": "there", "device": os.devnull, "device by a link": "link"}[kind]
    (ride / "there").mkdir()
    (ride / "link").symlink_to("/dev/zero")  # it never ends
    fails(*angles(ride=name))
    fails(*angles(geometry=name))
    fails("wheelchair", "tasks", name, "-o", "t.csv")


@pytest.mark.parametrize("length", ["-1", "nan", "inf", "1e6", "61"])
def test_lengths_of_gaps_that_cannot_be_filled(ride, fails, length):
    fails(*angles(), "--fill-gaps-s", length, says=["gaps"])
    fails(*velocity(), "--fill-gaps-s", length, says=["gaps"])
    fails(*calibrate(), "--fill-gaps-s", length, says=["gaps"])


def test_a_gap_with_more_samples_than_the_recording(ride, fails):
    table = pd.read_csv(ride / "ride.csv")
    table.loc[100:, "time_s"] += 50
    table.to_csv(ride / "gap.csv", index=False)
    fails(*angles("gap.csv"), "--fill-gaps-s", 60, says=["gap.csv", "5000 samples", "200"])


@pytest.mark.parametrize("rate", ["0", "-100", "nan", "inf", "1e300", "fast"])
def test_sampling_rates_that_are_none(tmp_path, fails, rate):
    velocity_csv(tmp_path / "v.csv")
    fails(*velocity(), "--sampling-rate-hz", rate)
    text = (tmp_path / "v.csv").read_text().replace("time_s", "clock")
    (tmp_path / "v.csv").write_text(text)
    fails("wheelchair", "tasks", "v.csv", "-o", "t.csv", "--sampling-rate-hz", rate)


@pytest.mark.parametrize("window", ["0", "-5", "24", "1001", str(10**30), "2.5"])
def test_windows_that_are_none(ride, fails, window):
    fails(*angles(), "--median-window", window)
    for kind in ("moving-average", "savitzky-golay"):
        fails(*velocity(), "--filter", kind, "--filter-window", window.replace("1001", "10000001"))


@pytest.mark.parametrize("order", ["-1", "7", str(10**30)])
def test_orders_that_are_none(fails, order):
    fails(*velocity(), "--filter", "savitzky-golay", "--filter-order", order)


def test_many_columns_take_no_more_steps_than_their_number(tmp_path, run):
    """Three times the columns, at most three times the steps of the interpreter."""

    def steps(sensors):
        names = [f"s{k}_acc_{axis}_mps2" for k in range(sensors) for axis in "xyz"]
        rows = [",".join([f"{t}", *(3 * sensors * ["5.7"])]) for t in (0.0, 0.01, 0.02)]
        (tmp_path / "wide.csv").write_text("\n".join([",".join(["time_s", *names]), *rows]))
        result = run(*angles("wide.csv"))
        assert result.returncode == 2
        assert "no sensor 'body'" in result.stderr
        return steps_of(run, *angles("wide.csv"))

    (tmp_path / "g.toml").write_text(SCOOTER_TOML)
    assert steps(300) < 3.1 * steps(100)


def test_clocks_in_another_unit(ride, run):
    """Milliseconds, or steps of a billion: an answer or one line, never a traceback."""
    ride_table = pd.read_csv(ride / "ride.csv")
    for factor in (1e3, 1e9, 1e-9, 1e300, 1e-300):
        ride_table.assign(time_s=ride_table["time_s"] * factor).to_csv(ride / "t.csv", index=False)
        for method in ("closed-form", "fusion"):
            result = run(*angles("t.csv"), "--method", method)
            assert result.returncode in (0, 2)
            assert len(result.stderr.splitlines()) <= 3


def test_readings_that_no_sensor_gives(tmp_path, run):
    walk = pd.read_csv(CORRIDOR / "walk.csv.gz")
    for value in (1e4, 1e30, 1e200, 1.7e308):
        for column in ("frame_acc_z_mps2", "frame_gyr_z_radps"):
            broken = walk.copy()
            broken.loc[120, column] = value
            broken.to_csv(tmp_path / "w.csv", index=False)
            result = run(*trajectory(walk="w.csv", mount=CORRIDOR / "true_mount.toml"))
            assert result.returncode in (0, 2)
            assert "Warning" not in result.stderr and "overflow" not in result.stderr


def test_frozen_sensors(ride, run):
    """Both sensors repeat one sample: no noise to be found in the recording."""
    still = pd.read_csv(ride / "ride.csv")
    still.iloc[:, 1:] = still.iloc[0, 1:].to_numpy()
    for axis in "xyz":
        still[[f"lever_gyr_{axis}_radps", f"body_gyr_{axis}_radps"]] = 0.0
    still.to_csv(ride / "still.csv", index=False)
    result = run(*angles("still.csv"), "--method", "fusion")
    assert result.returncode in (0, 2)
    if result.returncode == 2:
        assert len(result.stderr.splitlines()) == 1


def test_check_with_a_wheel_missing(tmp_path, fails):
    straight = pd.read_csv(COURT / "straight.csv.gz")
    kept = straight[[name for name in straight if not name.startswith("left_wheel")]]
    kept.to_csv(tmp_path / "s.csv", index=False)
    trials = velocity(straight="s.csv")[2:-2]
    fails("wheelchair", "check", *trials, says=["s.csv", "left_wheel"])
    fails(*velocity(straight="s.csv"), says=["s.csv", "left_wheel"])


def test_filled_gaps_are_told(ride, works):
    pd.read_csv(ride / "ride.csv").drop(index=range(50, 60)).to_csv(ride / "gap.csv", index=False)
    said = works(*angles("gap.csv"), "--fill-gaps-s", 1).stderr
    assert "warning: gap.csv: 1 gap(s) filled in with 10 interpolated samples" in said
    assert len(pd.read_csv(ride / "a.csv")) == 200


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--median-window", "0", "--median-window 0: expected a whole number"),
        ("--median-window", "8", "--median-window 8: expected an odd number"),
        ("--median-window", "2001", "ride.csv: --median-window 2001: longer than"),
        ("--sampling-rate-hz", "inf", ": --sampling-rate-hz: sampling rate of inf Hz"),
        ("--fill-gaps-s", "61", ": --fill-gaps-s: gaps of up to 61.0 s: expected"),
    ],
)
def test_an_impossible_value_is_named_as_typed(room, fails, option, value, says):
    line = ["ride.csv", option, value]
    fails("scooter", "angles", *line, "--geometry", "g.toml", "-o", "a.csv", says=[says])
    if option != "--median-window":
        fails("read", *line, says=[says])


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (1.0, "seat repeats body and is left out"),
        (1 / 9.81, "looks like g; seat is left out, since it is not needed"),
    ],
)
@pytest.mark.parametrize("first", [False, True])
def test_a_sensor_that_is_not_needed_spoils_no_recording(ride, works, factor, says, first):
    """A further sensor that copies a needed one, or is in another unit, is left out with a word."""
    works(*angles())
    table = pd.read_csv(ride / "ride.csv")
    body = [name for name in table if name.startswith("body")]
    for k, name in enumerate(body):
        place = 1 + k if first else table.shape[1]
        table.insert(place, name.replace("body", "seat"), table[name] * factor)
    table.to_csv(ride / "more.csv", index=False)
    assert says in works(*angles("more.csv", output="b.csv")).stderr
    assert (ride / "b.csv").read_bytes() == (ride / "a.csv").read_bytes()


def test_of_three_equal_sensors_the_two_that_are_needed_are_refused(ride, fails):
    """Without the first, the other two are still each other's copies."""
    table = pd.read_csv(ride / "ride.csv")
    for name in [name for name in table if name.startswith("body")]:
        table[name] = table[name.replace("body", "lever")]
        table.insert(1, name.replace("body", "seat"), table[name])
    table.to_csv(ride / "three.csv", index=False)
    fails(*angles("three.csv"), says=["lever and body have the same readings"])


def test_a_needed_sensor_that_copies_or_is_in_g_is_refused_beside_others(ride, fails):
    table = pd.read_csv(ride / "ride.csv")
    for name in [name for name in table if name.startswith("body")]:
        table[name.replace("body", "seat")] = table[name] / 9.81
        table[name] = table[name.replace("body", "lever")]
    table.to_csv(ride / "copy.csv", index=False)
    fails(*angles("copy.csv"), says=["lever and body have the same readings"])
    for name in [name for name in table if name.startswith("body")]:
        table[name] = table[name.replace("body", "seat")]
    table.to_csv(ride / "g.csv", index=False)
    fails(*angles("g.csv"), says=["body_acc has a median length of", "looks like g"])
