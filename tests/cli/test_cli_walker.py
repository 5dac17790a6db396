"""Walking frame on the command line: from tilts to a mount, from a walk to a path and steps."""

import re

import numpy as np
import pandas as pd
import pytest
from command_lines import CORRIDOR, calibrate, trajectory

TRUE_MOUNT = CORRIDOR / "true_mount.toml"


def end_sd(path):
    return path[["x_sd_m", "y_sd_m"]].iloc[-1]


@pytest.mark.parametrize("method", ["four-tilts", "two-tilts", "all-samples"])
def test_from_tilts_to_a_path(tmp_path, works, method):
    """Mount within 10 cm (the paper's method) or 3 cm (whole arcs), path within 2 % of 10 m."""
    from mobility_imu.walker import WalkerGeometry, WalkerMount

    works(*calibrate(), "--method", method)
    found, true = (WalkerMount.from_toml(f) for f in (tmp_path / "m.toml", TRUE_MOUNT))
    off = np.linalg.norm(found.translation_body_m - true.translation_body_m)
    assert off < (0.03 if method == "all-samples" else 0.1)
    assert WalkerGeometry.from_toml(tmp_path / "m.toml") == WalkerGeometry.from_toml(
        CORRIDOR / "geometry.toml"
    )
    assert ("translation_sd_m" in (tmp_path / "m.toml").read_text()) == (method == "all-samples")
    works(*trajectory(), "--steps", "steps.csv")
    path = pd.read_csv(tmp_path / "path.csv")
    truth = pd.read_csv(CORRIDOR / "truth.csv.gz")
    first = ["time_s", "x_m", "y_m", "z_m", "yaw_deg", "stationary"]
    assert list(path) == [*first, "x_sd_m", "y_sd_m", "z_sd_m", "yaw_sd_deg", "valid"]
    assert (path["valid"] == 1).all()
    assert (path[["x_sd_m", "y_sd_m", "z_sd_m", "yaw_sd_deg"]] >= 0).all(axis=None)
    assert np.hypot(*end_sd(path)) < 0.2
    end = path[["x_m", "y_m"]].iloc[-1] - truth[["x_m", "y_m"]].iloc[-1]
    assert np.hypot(*end) < 0.2
    assert len(pd.read_csv(tmp_path / "steps.csv")) == 29


def test_commands_write_what_the_library_finds(tmp_path, short, works):
    """Mount, path and steps, byte for byte."""
    from mobility_imu.files import csv_bytes
    from mobility_imu.readers import read_recording
    from mobility_imu.walker import (
        ClosedLoop,
        WalkerGeometry,
        WalkerMount,
        calibrate_mount,
        estimate_trajectory,
        find_steps,
    )

    works(*calibrate())
    geometry = WalkerGeometry.from_toml(CORRIDOR / "geometry.toml")
    found = calibrate_mount(read_recording(CORRIDOR / "tilts.csv.gz"), geometry)
    assert (tmp_path / "m.toml").read_text() == found.to_toml()
    works(*trajectory(walk=short), "--steps", "steps.csv", "--closed-loop")
    path = estimate_trajectory(
        read_recording(short),
        geometry,
        WalkerMount.from_toml(tmp_path / "m.toml"),
        closed_loop=ClosedLoop(),
    )
    whole = path.to_frame().assign(valid=0)  # a corridor does not close
    for name, table in (("path.csv", whole), ("steps.csv", find_steps(path).to_frame())):
        written = tmp_path / name
        assert len(table) and written.read_bytes() == csv_bytes(table, written)


def test_options(short, works, fails):
    works(*calibrate(), "--no-smooth", "--form", "printed", "--method", "two-tilts")
    for options in (["--no-smooth"], ["--closed-loop"]):
        works(*trajectory(walk=short), *options)
    assert "no step found" in works(*trajectory(walk=CORRIDOR / "tilts.csv.gz")).stderr
    assert "[walker]" in works("walker", "calibrate", "--help").stdout
    both = ["--no-smooth", "--closed-loop"]
    fails(*trajectory(), *both, says=["--closed-loop needs the smoother"])
    swapped = works(*calibrate(), "--order", "right,front,left,back")
    assert "other way round" in swapped.stderr


def test_a_sensor_of_unknown_scale_makes_the_stated_deviations_larger(tmp_path, works, fails):
    """At the end of a straight walk of 10 m, 2 % of scale are 0.2 m."""
    works(*trajectory(mount=TRUE_MOUNT))
    usual = pd.read_csv(tmp_path / "path.csv").iloc[-1]
    works(*trajectory(mount=TRUE_MOUNT), "--scale-percent", "2")
    wide = pd.read_csv(tmp_path / "path.csv").iloc[-1]
    assert (wide["x_m"], wide["yaw_deg"]) == (usual["x_m"], usual["yaw_deg"])
    part = np.sqrt(wide["x_sd_m"] ** 2 - usual["x_sd_m"] ** 2)
    assert part == pytest.approx(np.sqrt(0.02**2 - 0.01**2) * wide["x_m"], rel=0.01)
    for wrong in ("-1", "0", "nan", "inf", "200"):
        says = [f"--scale-percent {wrong}: expected 0.0001 to 100"]
        fails(*trajectory(mount=TRUE_MOUNT), "--scale-percent", wrong, says=says)

    from mobility_imu.walker import WalkerMount

    def height_sd(*options):
        works(*calibrate(), *options)
        return WalkerMount.from_toml(tmp_path / "m.toml").translation_sd_m[2]

    assert height_sd() > 2 * height_sd("--scale-percent", "0.3")
    exact = WalkerMount.from_toml(tmp_path / "m.toml").rotation_sd_rad
    works(*calibrate())
    assert (WalkerMount.from_toml(tmp_path / "m.toml").rotation_sd_rad > 2 * exact)[:2].all()


def test_rests_that_are_known(tmp_path, short, works, fails):
    """A path's own rests give the same path again; what does not serve is said."""
    command = trajectory(walk=short, mount=TRUE_MOUNT)
    works(*command, "--steps", "steps.csv")
    first = pd.read_csv(tmp_path / "path.csv")
    first.to_csv(tmp_path / "rests.csv", index=False)
    again = works(*command, "--rests", "rests.csv")
    assert "known can be given" not in again.stderr
    assert np.array_equal(pd.read_csv(tmp_path / "path.csv")["x_m"], first["x_m"])
    first[["time_s", "stationary"]][::2].to_csv(tmp_path / "half.csv", index=False)
    works(*command, "--rests", "half.csv")
    thin = pd.read_csv(tmp_path / "path.csv")
    assert np.hypot(*(thin[["x_m", "y_m"]] - first[["x_m", "y_m"]]).to_numpy().T).max() < 0.02
    for change, says in (
        ({"stationary": 2}, ["r.csv: line 2, column stationary", "got '2'", "1 or 0"]),
        ({"stationary": 0}, ["r.csv", "0 throughout"]),
        ({"time_s": 1.0}, ["r.csv", "time_s does not increase"]),
        ({"time_s": first["time_s"] + 100}, ["r.csv", "from 100 to", "on its clock"]),
        ({"time_s": first["time_s"] * 1000}, ["r.csv", "are its times in s?"]),
    ):
        first.assign(**change).to_csv(tmp_path / "r.csv", index=False)
        fails(*command, "--rests", "r.csv", says=says)
    first[["time_s"]].to_csv(tmp_path / "r.csv", index=False)
    fails(*command, "--rests", "r.csv", says=["no column", "stationary"])
    fails(*command, "--rests", "none.csv", says=["none.csv: no such file"])
    (tmp_path / "path.csv").write_text("kept")
    fails(*command, "--rests", "path.csv", says=["path.csv"])
    assert (tmp_path / "path.csv").read_text() == "kept"


@pytest.fixture
def saved(tmp_path):
    """Write a changed recording; returns its name."""

    def saved(table):
        table.to_csv(tmp_path / "t.csv", index=False)
        return "t.csv"

    return saved


def test_tilts_that_do_not_serve(fails, saved):
    tilts = pd.read_csv(CORRIDOR / "tilts.csv.gz")
    cut = tilts[tilts["time_s"] < 5.0]  # in the hold of the first tilt
    fails(*calibrate(tilts=saved(cut)), says=["t.csv", "before the recording ends"])
    half = saved(tilts[tilts["time_s"] < 15.0])
    fails(*calibrate(tilts=half), "--method", "four-tilts", says=["missing: ", "left"])
    gap = saved(tilts.drop(index=range(500, 540)))
    fails(*calibrate(tilts=gap), says=["gap of 0.41 s"])
    in_g = tilts.copy()
    in_g[[f"frame_acc_{k}_mps2" for k in "xyz"]] /= 9.80665
    fails(*calibrate(tilts=saved(in_g)), says=["looks like g"])
    shaken = tilts.copy()
    shaken["frame_gyr_x_radps"] += 0.4 * np.sin(50 * shaken["time_s"])
    fails(*calibrate(tilts=saved(shaken)), says=["not still within the first 5 s"])
    fails(*calibrate(), "--order", "up,down", says=["--order up, down: expected names"])
    renamed = tilts.rename(columns=lambda name: name.replace("frame", "lever"))
    fails(*calibrate(tilts=saved(renamed)), says=["no sensor 'frame'", "lever"])


def test_geometry_and_walks_that_do_not_serve(tmp_path, fails, saved):
    fails(*trajectory(mount=CORRIDOR / "geometry.toml"), says=["[walker.mount]"])
    (tmp_path / "cm.toml").write_text("[walker]\nfootprint_width_m = 60\nfootprint_length_m = 52\n")
    fails(*calibrate(geometry="cm.toml"), says=["footprint_width_m", "in cm?"])
    (tmp_path / "m.toml").write_text(TRUE_MOUNT.read_text().replace("0.987", "0.687"))
    fails(*trajectory(), says=["m.toml", "rotation matrix"])
    missing = ["--steps", "none/steps.csv"]
    fails(*trajectory(mount=TRUE_MOUNT), *missing, says=["no such folder"])
    walk = pd.read_csv(CORRIDOR / "walk.csv.gz")
    spoilt = walk.copy()
    spoilt.loc[120, "frame_acc_z_mps2"] = 1e30
    fails(
        *trajectory(walk=saved(spoilt), mount=TRUE_MOUNT),
        says=["t.csv", "frame_acc_z is 1e+30 m/s²", "sample 120"],
    )
    walk.loc[4000, "frame_gyr_z_radps"] = np.nan
    fails(
        *trajectory(walk=saved(walk), mount=TRUE_MOUNT),
        says=["line 4002, column frame_gyr_z", "NaN", "correct it"],
    )


def late_gyroscope(table, samples=20):
    """The recording of a gyroscope that comes late."""
    axes = [f"frame_gyr_{k}_radps" for k in "xyz"]
    return table.assign(**{name: table[name].shift(samples) for name in axes}).dropna()


def test_a_fault_is_told_with_what_it_costs(tmp_path, works, fails, saved):
    """A late gyroscope moves every heading: nothing is valid, and --strict refuses."""
    late = saved(late_gyroscope(pd.read_csv(CORRIDOR / "walk.csv.gz")))
    said = works(*trajectory(walk=late, mount=TRUE_MOUNT)).stderr
    later = re.search(r"frame_gyr comes (\S+) ± 0\.01 s later", said)
    assert later and float(later[1]) == pytest.approx(0.2, abs=0.0101)
    assert "; it moves the place by up to " in said
    assert (pd.read_csv(tmp_path / "path.csv")["valid"] == 0).all()
    fails(*trajectory(walk=late, mount=TRUE_MOUNT), "--strict", says=["frame_gyr"])


def test_a_fault_in_the_tilts_is_told_in_the_mount(works, fails, saved):
    scaled = pd.read_csv(CORRIDOR / "tilts.csv.gz")
    scaled[[f"frame_gyr_{k}_radps" for k in "xyz"]] *= 1.1
    tilts = saved(scaled)
    said = works(*calibrate(tilts=tilts)).stderr
    assert "too much as far as tilts show it" in said and "moves the position of the IMU" in said
    fails(*calibrate(tilts=tilts), "--strict", says=["frame_gyr reads", "too much"])


def test_what_follows_a_frozen_gyroscope_is_not_valid(tmp_path, works, saved):
    walk = pd.read_csv(CORRIDOR / "walk.csv.gz")
    axes = [f"frame_gyr_{k}_radps" for k in "xyz"]
    walk.loc[3000:3400, axes] = walk.loc[3000, axes].to_numpy(float)
    said = works(*trajectory(walk=saved(walk), mount=TRUE_MOUNT)).stderr
    assert "what the path does there is not known" in said
    path = pd.read_csv(tmp_path / "path.csv")
    valid, rest = path["valid"], np.flatnonzero(path["stationary"][:2995])[-1]
    assert (valid[:rest] == 1).all() and (valid[rest:] == 0).all()
