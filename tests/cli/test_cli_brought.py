"""Commands of all devices: geometry files and names as people bring them."""

import re
import shutil

import numpy as np
import pandas as pd
import pytest
from command_lines import CORRIDOR, COURT, angles, calibrate, scooter_ride, trajectory, velocity

TRUE_MOUNT = CORRIDOR / "true_mount.toml"
EYE = "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"


def test_a_name_that_begins_with_a_dash_is_shown_how_to_write(tmp_path, fails):
    shutil.copy(CORRIDOR / "walk.csv.gz", tmp_path / "-walk.csv.gz")
    line = trajectory(walk="-walk.csv.gz", mount=TRUE_MOUNT)
    fails(*line, says=["-walk.csv.gz: begins with a dash", "write ./-walk.csv.gz"])


def test_an_option_that_is_none_is_no_file(fails):
    fails(*trajectory(mount=TRUE_MOUNT), "--qick", says=["--qick"])


def test_an_option_is_no_file_though_one_has_its_name(tmp_path, fails):
    (tmp_path / "-o").write_text("")
    line = trajectory(mount=TRUE_MOUNT)
    assert "-o" in line
    said = fails(*line, "--qick", says=["--qick"])
    assert "./-o" not in said


@pytest.mark.parametrize("order", ["Front,Back,Right,Left", " FRONT, back,RIGHT ,left"])
def test_the_order_may_be_in_capitals(works, order):
    assert "warning" not in works(*calibrate(), "--order", order).stderr


def test_an_unknown_direction_is_shown_as_typed(fails):
    fails(*calibrate(), "--order", "Vorne,back", says=["--order Vorne, back"])


@pytest.mark.parametrize(("degrees", "told"), [(20, False), (35, False), (55, False), (70, True)])
def test_an_inclination_from_the_horizontal_is_asked_about(tmp_path, works, degrees, told):
    scooter_ride(tmp_path)
    (tmp_path / "g.toml").write_text(
        f"[scooter]\nsteering_inclination_deg = {degrees}\nlever_inclination_deg = 9\n"
    )
    said = works(*angles()).stderr
    assert ("from the horizontal, write 20" in said) == told


@pytest.mark.parametrize("sd_rad", ["[0.5, 0.4, 0.2, 0.4, 0.4, 1.6]", "[0.01, 0, 0, 0, 0, 1.6]"])
def test_a_scooters_mount_known_to_so_many_degrees_is_asked_about(tmp_path, works, sd_rad):
    scooter_ride(tmp_path)
    mount = "".join(
        f"rotation_{name} = {EYE}\n" for name in ("lever_imu_to_lever", "body_imu_to_body")
    )
    text = (tmp_path / "g.toml").read_text()
    (tmp_path / "g.toml").write_text(f"{text}[scooter.mount]\n{mount}sd_rad = {sd_rad}\n")
    said = works(*angles()).stderr
    # The turn of the body about the vertical may be unknown.
    assert ("are the numbers in degrees?" in said) == sd_rad.startswith("[0.5")


@pytest.mark.parametrize(("sd", "told"), [("0.5, 0.5, 0.34", True), ("0.01, 0.5, 0.01", False)])
def test_a_walkers_mount_likewise(tmp_path, works, sd, told):
    text = TRUE_MOUNT.read_text() + f"rotation_sd_rad = [{sd}]\n"
    assert re.search(r"\[walker.mount\][^\[]*rotation_imu", text)
    (tmp_path / "m.toml").write_text(text)
    said = works(*trajectory()).stderr
    assert ("are the numbers in degrees?" in said) == told


def test_a_mount_in_a_chairs_geometry_is_told_as_unused(tmp_path, works):
    keys = ("left_imu_to_wheel", "right_imu_to_wheel", "frame_imu_to_chair")
    mount = "".join(f"rotation_{key} = {EYE}\n" for key in keys)
    text = (COURT / "geometry.toml").read_text()
    (tmp_path / "g.toml").write_text(f"{text}[wheelchair.mount]\n{mount}")
    told = "g.toml: [wheelchair.mount] is not used"
    line = velocity(geometry="g.toml")
    assert told in works(*line).stderr
    check = ["wheelchair", "check", *line[2 : line.index("-o")]]
    assert told in works(*check).stderr
    assert "not used" not in works(*velocity()).stderr


@pytest.fixture(scope="module")
def parked(tmp_path_factory):
    from mobility_imu.simulation.bundle import scooter_bundle

    folder = tmp_path_factory.mktemp("parked")
    contents = scooter_bundle(900_590)
    (folder / "g.toml").write_text(contents["geometry.toml"])
    contents["parked_level.csv.gz"].to_csv(folder / "level.csv", index=False)
    contents["poses.csv"].to_csv(folder / "deg.csv", index=False)
    pd.DataFrame(np.deg2rad(contents["poses.csv"])).to_csv(folder / "rad.csv", index=False)
    return folder


@pytest.mark.parametrize(("poses", "told"), [("deg.csv", False), ("rad.csv", True)])
def test_poses_in_rad_are_asked_about(parked, works, poses, told):
    files = ["--poses", parked / poses, "--geometry", parked / "g.toml"]
    said = works("scooter", "check", parked / "level.csv", *files).stderr
    assert ("are they in rad?" in said) == told


def test_rests_of_another_walk_are_asked_about(tmp_path, works):
    from mobility_imu.simulation.bundle import walker_bundle

    other = walker_bundle(900_591)["truth.csv.gz"]
    assert other["time_s"].iloc[-1] > 60
    walk = pd.read_csv(CORRIDOR / "walk.csv.gz")
    walk[walk["time_s"] < 60].to_csv(tmp_path / "walk.csv", index=False)
    other.to_csv(tmp_path / "other.csv", index=False)
    line = trajectory(walk="walk.csv", mount=TRUE_MOUNT)
    asked = "do not resemble those that the readings show: are they of this recording?"
    assert asked in works(*line, "--rests", "other.csv").stderr
    assert asked not in works(*line, "--rests", CORRIDOR / "truth.csv.gz").stderr
    # Who knows the first and the last rest only knows no other walk's.
    truth = pd.read_csv(CORRIDOR / "truth.csv.gz")
    ends = (truth["time_s"] < 2) | (truth["time_s"] > 58)
    truth.assign(stationary=truth["stationary"] * ends).to_csv(tmp_path / "some.csv", index=False)
    assert asked not in works(*line, "--rests", "some.csv").stderr
