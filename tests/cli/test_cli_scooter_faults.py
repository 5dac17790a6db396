"""Faults of a scooter's sensors on the command line: told with their cost, refused if strict."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from command_lines import angles

from mobility_imu.cli.scooter import _is_explained
from mobility_imu.health import fault_of
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter.force import PoseLength

FUSION = ("--method", "fusion")


def spoil(folder, how, name="bad.csv"):
    ride = pd.read_csv(folder / "ride.csv.gz")
    how(ride)
    ride.to_csv(folder / name, index=False)
    return name


def reversed_lever(ride):
    ride[[name for name in ride if name.startswith("lever_gyr")]] *= -1


def late_lever(ride):
    names = [name for name in ride if name.startswith("lever_")]
    ride[names] = ride[names].shift(20).bfill()


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize(
    ("how", "says"), [(reversed_lever, "the wrong sign"), (late_lever, "later than the body's")]
)
def test_a_fault_is_told_once_with_its_cost(tmp_path, works, fails, how, says):
    bad = spoil(tmp_path, how)
    line = [*angles(bad, "geometry.toml"), *FUSION]
    said = works(*line).stderr
    told = [text for text in said.splitlines() if says in text]
    assert len(told) == 1 and "it moves the steering by up to" in told[0]
    valid = pd.read_csv(tmp_path / "a.csv")["valid"]
    assert valid.mean() < 0.9
    (tmp_path / "a.csv").unlink()
    fails(*line, "--strict", says=["bad.csv: lever"])


@pytest.mark.usefixtures("simulated")
def test_an_uncertain_angle_is_told_and_no_fault(works):
    """A stated noise of 0.6 m/s² leaves the steering uncertain by more than 10 deg."""
    line = [*angles("ride.csv.gz", "geometry.toml"), "--acc-noise-mps2"]
    told = works(*line, "0.6", "--strict").stderr
    assert "the steering is uncertain by 1" in told and "nine of ten errors" in told


def frozen_body(ride):
    names = [name for name in ride if name.startswith("body_acc")]
    ride.loc[20:, names] = ride.loc[20, names].to_numpy()


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize("options", [(), FUSION])
def test_an_accelerometer_that_stands_still_is_refused_if_strict(tmp_path, works, fails, options):
    bad = spoil(tmp_path, frozen_body)
    line = [*angles(bad, "geometry.toml"), *options]
    said = [text for text in works(*line).stderr.splitlines() if "body_acc" in text]
    assert len(said) == 1 and "repeats its last reading" in said[0]
    assert (pd.read_csv(tmp_path / "a.csv")["valid"][20:] == 0).all()
    (tmp_path / "a.csv").unlink()
    fails(*line, "--strict", says=["bad.csv: body_acc"])


def frozen_and_cut(ride):
    """A lever that stands still for a second, and blows that its range cuts."""
    names = [name for name in ride if name.startswith("lever_acc")]
    ride.loc[500:600, names] = ride.loc[500, names].to_numpy()
    for start in (900, 1100, 1300):
        ride.loc[start : start + 2, "lever_acc_y_mps2"] = 19.6


@pytest.mark.usefixtures("simulated")
def test_only_what_was_told_is_not_told_again(tmp_path, works):
    """That the lever is frozen was told with its cost; that blows were cut was not."""
    bad = spoil(tmp_path, frozen_and_cut)
    said = works(*angles(bad, "geometry.toml")).stderr
    assert said.count("lever_acc in 101 samples") == 1 and "lever_acc is frozen" not in said
    assert said.count("lever_acc is saturated in 9 samples") == 1


@pytest.mark.usefixtures("simulated")
def test_a_sound_ride_passes_strict(works):
    assert "warning" not in works(*angles("ride.csv.gz", "geometry.toml"), "--strict").stderr
    parked = ["parked_level.csv.gz", "parked_ramp.csv.gz"]
    options = ["--geometry", "geometry.toml", "--poses", "poses.csv"]
    works("scooter", "calibrate", *parked, *options, "-o", "mount.toml", "--strict")


@pytest.mark.usefixtures("simulated")
def test_the_closed_form_says_that_it_does_not_use_gyroscopes(tmp_path, works):
    bad = spoil(tmp_path, reversed_lever)
    assert "the closed form does not use it" in works(*angles(bad, "geometry.toml")).stderr
    assert (pd.read_csv(tmp_path / "a.csv")["valid"] == 1).mean() > 0.9


@pytest.mark.usefixtures("simulated")
def test_poses_in_radians_are_told_and_refused_if_strict(tmp_path, works, fails):
    poses = pd.read_csv(tmp_path / "poses.csv")
    np.deg2rad(poses).to_csv(tmp_path / "rad.csv", index=False)
    line = ["scooter", "calibrate", "parked_level.csv.gz"]
    line += ["--geometry", "geometry.toml", "--poses", "rad.csv", "-o", "m.toml"]
    assert "the poses fit no mount" in works(*line).stderr
    assert "the poses miss this mount by" in (tmp_path / "m.toml").read_text()
    (tmp_path / "m.toml").unlink()
    fails(*line, "--strict", says=["rad.csv", "the poses fit no mount"])


@pytest.mark.usefixtures("simulated")
def test_check_and_calibrate_tell_faults_of_parked_recordings(tmp_path, works):
    parked = pd.read_csv(tmp_path / "parked_level.csv.gz")
    parked["lever_gyr_x_radps"] *= -1
    parked.to_csv(tmp_path / "bad.csv", index=False)
    options = ["--geometry", "geometry.toml", "--poses", "poses.csv"]
    line = ["scooter", "calibrate", "bad.csv", "parked_ramp.csv.gz", *options, "-o", "m.toml"]
    assert "bad.csv: lever_gyr turns the other way" in works(*line).stderr
    assert "bad.csv: lever_gyr turns" in works("scooter", "check", "bad.csv", *options).stderr


def held_lever(ride):
    names = [name for name in ride if name.startswith("lever_acc")]
    ride.loc[20:60, names] = ride.loc[20, names].to_numpy()


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize("options", [(), FUSION])
def test_a_loss_that_moves_no_angle_passes_strict(tmp_path, works, options):
    """At rest, a held reading is told; its samples are not valid, and the others do not feel it."""
    line = [*angles(spoil(tmp_path, held_lever), "geometry.toml"), *options, "--strict"]
    assert "bad.csv: lever_acc is frozen in 41 samples" in works(*line).stderr
    found = pd.read_csv(tmp_path / "a.csv")
    assert (found["valid"][20:61] == 0).all() and (found["valid"][80:] == 1).mean() > 0.9
    works(*angles("ride.csv.gz", "geometry.toml", "sound.csv"), *options)
    sound = pd.read_csv(tmp_path / "sound.csv")
    for name in ("steering_deg", "throttle_deg"):
        assert (found[name] - sound[name])[found["valid"] == 1].abs().max() < 1.0


@pytest.mark.usefixtures("simulated")
def test_what_only_the_estimate_says_is_refused_if_strict(tmp_path, works, fails):
    """No sensor is at fault; with such a noise few angles are known.

    Words in the name of the file decide nothing.
    """
    name = "x: the sensors were accelerated in y: lever_acc is frozen in z.csv.gz"
    (tmp_path / "ride.csv.gz").rename(tmp_path / name)
    line = [*angles(name, "geometry.toml"), *FUSION, "--acc-noise-mps2", "100"]
    assert "leave the steering uncertain by 20 deg or more" in works(*line).stderr
    (tmp_path / "a.csv").unlink()
    fails(*line, "--strict", says=["of the samples are valid"])


def scaled(ride, sensor):
    ride[[name for name in ride if name.startswith(f"{sensor}_acc")]] *= 1.3


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize("sensor", ["lever", "body"])
def test_calibrate_tells_an_accelerometer_once(tmp_path, works, sensor):
    """Its poses are of the other length as well; of another recording's sensor they are told."""
    for name in ("level", "ramp"):
        parked = pd.read_csv(tmp_path / f"parked_{name}.csv.gz")
        scaled(parked, sensor)
        parked.to_csv(tmp_path / f"{name}.csv", index=False)
    line = ["scooter", "calibrate", "level.csv", "ramp.csv", "--geometry", "geometry.toml"]
    said = works(*line, "--poses", "poses.csv", "-o", "m.toml").stderr.splitlines()
    for name in ("level", "ramp"):
        (told,) = [text for text in said if f"{name}.csv: " in text and "m/s²" in text]
        assert f"{sensor}_acc reads 1" in told and "m/s² of gravity" in told


@pytest.mark.usefixtures("simulated")
@pytest.mark.parametrize("factor", [1.0, 1.3])
def test_calibrate_tells_a_body_that_leans_beside_another_fault(tmp_path, works, factor):
    """In the first pose 1 m/s² across is a lean of 6 deg, which no scale explains."""
    parked = pd.read_csv(tmp_path / "parked_level.csv.gz")
    parked.loc[parked["time_s"] < parked["time_s"][0] + 2.5, "body_acc_y_mps2"] += 1.0
    parked[[name for name in parked if name.startswith("body_acc")]] *= factor
    parked.to_csv(tmp_path / "bad.csv", index=False)
    line = ["scooter", "calibrate", "bad.csv", "parked_ramp.csv.gz", "--geometry", "geometry.toml"]
    said = works(*line, "--poses", "poses.csv", "-o", "m.toml").stderr
    assert ("body_acc reads" in said) == (factor != 1)
    assert "bad.csv: in pose 1 gravity lies" in said and "in the body's IMU" in said


def parked_with(fault_samples, sensor="lever_acc", code="scale"):
    """A parked recording of two poses, 2 s each, and a fault in some of its samples."""
    turning = np.zeros((500, 3))
    turning[210:290] = 1.0
    imu = Imu(np.tile([0.0, 0.0, 9.8], (500, 1)), turning)
    parked = Recording(np.arange(500) / 100, {"lever": imu, "body": imu}, source="a.csv")
    flags = np.zeros(500, bool)
    flags[fault_samples] = True
    return parked, fault_of(parked, code, sensor, flags, "is at fault")


@pytest.mark.parametrize(
    ("samples", "sensor", "told"),
    [
        (slice(None), "lever_acc", True),
        (slice(350, 400), "lever_acc", True),
        (slice(0, 200), "lever_acc", False),
        (slice(None), "body_acc", False),
        (slice(None), "lever_gyr", False),
    ],
)
def test_only_a_length_that_a_fault_of_the_same_pose_explains_is_left_out(samples, sensor, told):
    parked, fault = parked_with(samples, sensor)
    wrong = PoseLength("a.csv", 1, "lever", 7.0)
    assert _is_explained(wrong, [(parked, fault)]) == told
    assert not _is_explained(wrong._replace(source="b.csv"), [(parked, fault)])
    assert not _is_explained(wrong, [])
    exchanged = replace(fault, sensor=f"body_acc, {sensor}")
    assert _is_explained(wrong, [(parked, exchanged)]) == told
