"""Scooter on the command line: files in, files out, one line when something is wrong."""

import numpy as np
import pandas as pd
import pytest
from command_lines import angles, scooter_ride


@pytest.mark.parametrize("extra", [(), ("--single-imu",), ("--form", "printed")])
def test_angles_of_a_steered_scooter(tmp_path, works, extra):
    steering, throttle = scooter_ride(tmp_path)
    works(*angles(), "--median-window", 1, *extra)
    table = pd.read_csv(tmp_path / "a.csv")
    assert list(table) == [
        "time_s",
        "steering_deg",
        "throttle_deg",
        "steering_sd_deg",
        "throttle_sd_deg",
        "valid",
    ]
    # The file carries six decimals.
    assert np.allclose(table["steering_deg"], steering, atol=2e-3)
    assert np.allclose(table["throttle_deg"], throttle, atol=2e-3)
    assert table["steering_sd_deg"].isna().all()
    assert (table["valid"] == 1).all()


def test_standard_deviation_needs_the_noise(tmp_path, works):
    scooter_ride(tmp_path)
    one_mg = 9.80665e-3
    works(*angles(), "--single-imu", "--acc-noise-mps2", one_mg)
    # At the centre, 20 degrees of inclination: 0.0573 / sin(20 deg) = 0.1675 deg per milli-g.
    assert pd.read_csv(tmp_path / "a.csv")["steering_sd_deg"].min() == pytest.approx(
        0.1675, abs=2e-3
    )


def test_bad_input(tmp_path, fails):
    scooter_ride(tmp_path, body=False)
    fails(*angles(), says=["ride.csv", "body", "--single-imu"])
    fails(*angles(geometry="none.toml"), says=["none.toml", "no such file"])
    (tmp_path / "bad.toml").write_text("[scooter]\nsteering_inclination_deg = 20\n")
    fails(*angles(geometry="bad.toml"), says=["lever_inclination_deg is missing"])
    fails("scooter", "angles", "ride.csv", says=["Missing option"])
    scooter_ride(tmp_path)
    fails(*angles(), "--median-window", 24, says=["24", "odd"])
    scooter_ride(tmp_path, acc_unit=1 / 9.80665)
    fails(*angles(), says=["9.81", "looks like g"])


@pytest.mark.usefixtures("simulated")
def test_from_parked_poses_to_smoothed_angles(tmp_path, works):
    """Calibrated and smoothed, the steering error is less than half of the paper's method."""
    parked = ["parked_level.csv.gz", "parked_ramp.csv.gz"]
    options = ["--geometry", "geometry.toml", "--poses", "poses.csv", "-o", "mount.toml"]
    works("scooter", "calibrate", *parked, *options)
    truth = pd.read_csv(tmp_path / "truth.csv.gz")
    moving = truth["speed_mps"] > 0.1
    errors = {}
    for name, geometry, extra in (
        ("paper", "geometry.toml", []),
        ("ours", "mount.toml", ["--method", "fusion"]),
    ):
        works(*angles("ride.csv.gz", geometry), *extra)
        table = pd.read_csv(tmp_path / "a.csv")
        error = (table["steering_deg"] - truth["steering_deg"]).abs()[moving]
        errors[name] = error.quantile(0.9)
        assert (table["valid"] == 1).mean() > 0.99
    assert table["steering_sd_deg"].notna().all()
    assert errors["ours"] < 0.5 * errors["paper"]


@pytest.mark.usefixtures("simulated")
def test_sensors_that_fail(tmp_path, works, fails):
    ride = pd.read_csv(tmp_path / "ride.csv.gz")
    body = [f"body_acc_{axis}_mps2" for axis in "xyz"]
    broken = ride.copy()
    broken.loc[300:400, body] = broken.loc[300, body].to_numpy()
    broken.to_csv(tmp_path / "frozen.csv", index=False)
    result = works(*angles("frozen.csv", "geometry.toml"))
    assert "frozen.csv: body_acc in 101 samples, first at 3.00 s, repeats" in result.stderr
    assert (pd.read_csv(tmp_path / "a.csv")["valid"][300:401] == 0).all()
    flipped = ride.copy()
    flipped[body] *= -1
    flipped.to_csv(tmp_path / "flipped.csv", index=False)
    fails(*angles("flipped.csv", "geometry.toml"), says=["sign is flipped"])
    ride[::5].head(200).to_csv(tmp_path / "slow.csv", index=False)
    result = works(*angles("slow.csv", "geometry.toml"))
    assert "25 samples is 1.25 s" in result.stderr and "--median-window 5" in result.stderr


@pytest.mark.usefixtures("simulated")
def test_fusion_needs_both_sensors_with_gyroscopes(tmp_path, fails):
    fusion = [*angles("ride.csv.gz", "geometry.toml"), "--method", "fusion"]
    fails(*fusion, "--single-imu", says=["both IMUs"])
    ride = pd.read_csv(tmp_path / "ride.csv.gz")
    no_gyro = ride.drop(columns=[name for name in ride if "lever_gyr" in name])
    no_gyro.to_csv(tmp_path / "no_gyro.csv", index=False)
    fusion = [*angles("no_gyro.csv", "geometry.toml"), "--method", "fusion"]
    fails(*fusion, says=["'lever' has no gyroscope"])


@pytest.mark.parametrize("noise", ["inf", "nan", "-1", "1e200"])
@pytest.mark.parametrize("method", ["closed-form", "fusion"])
def test_noise_that_no_accelerometer_has(tmp_path, fails, noise, method):
    scooter_ride(tmp_path)
    options = ["--method", method, "--acc-noise-mps2", noise]
    fails(*angles(), *options, says=["acc-noise-mps2"])


def test_fusion_needs_a_noise_above_zero(tmp_path, fails):
    scooter_ride(tmp_path)
    options = ["--method", "fusion", "--acc-noise-mps2", 0]
    fails(*angles(), *options, says=["noise above 0"])


@pytest.mark.parametrize("pose", ["1e308,40", "50,181", "nan,0", ",0", "inf,0", "left,0", "50"])
def test_poses_that_are_none(tmp_path, fails, pose):
    scooter_ride(tmp_path)
    (tmp_path / "poses.csv").write_text(f"steering_deg,throttle_deg\n50,0\n{pose}\n0,0\n")
    parked = ["scooter", "calibrate", "ride.csv", "--geometry", "g.toml"]
    fails(*parked, "--poses", "poses.csv", "-o", "m.toml", says=["poses.csv"])


def with_gyroscopes(folder, *, noise=1e-5, time_factor=1.0):
    """The ride again, with gyroscopes that stay near zero."""
    scooter_ride(folder)
    ride = pd.read_csv(folder / "ride.csv")
    rng = np.random.default_rng(2)
    for name in ("lever", "body"):
        for axis in "xyz":
            ride[f"{name}_gyr_{axis}_radps"] = noise * rng.standard_normal(len(ride))
    ride["time_s"] *= time_factor
    ride.to_csv(folder / "ride.csv", index=False)
    return ride


def test_fusion_of_a_constant_recording(tmp_path, works):
    """No traceback: angles of what the sensors repeat, each sample marked as not valid."""
    ride = with_gyroscopes(tmp_path, noise=0.0)
    ride.loc[:, ride.columns != "time_s"] = ride.iloc[0, 1:].to_numpy()
    ride.to_csv(tmp_path / "ride.csv", index=False)
    result = works(*angles(), "--method", "fusion")
    assert "lever_acc repeats its last reading" in result.stderr
    table = pd.read_csv(tmp_path / "a.csv")
    assert (table["valid"] == 0).all() and table["steering_deg"].notna().all()


def test_fusion_of_rounded_readings(tmp_path, works):
    ride = with_gyroscopes(tmp_path)
    ride[[name for name in ride if "acc" in name]] = ride.filter(like="acc").round(1)
    ride.to_csv(tmp_path / "ride.csv", index=False)
    works(*angles(), "--method", "fusion")
    assert pd.read_csv(tmp_path / "a.csv")["steering_sd_deg"].between(0.1, 20).all()


@pytest.mark.parametrize(("factor", "rate"), [(1000, "0.1 Hz"), (20, "sampling_rate_hz = 5")])
def test_fusion_with_times_that_are_too_far_apart(tmp_path, fails, factor, rate):
    with_gyroscopes(tmp_path, time_factor=factor)
    fails(*angles(), "--method", "fusion", says=["ride.csv", rate])


def test_a_mount_that_is_a_mirror(tmp_path, fails):
    scooter_ride(tmp_path)
    with (tmp_path / "g.toml").open("a") as file:
        file.write(
            "[scooter.mount]\n"
            "rotation_lever_imu_to_lever = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n"
            "rotation_body_imu_to_body = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
        )
    fails(*angles(), says=["g.toml", "rotation_lever_imu_to_lever", "mirror"])


def test_options_that_a_method_does_not_use_are_told(tmp_path, works, fails):
    with_gyroscopes(tmp_path)
    fusion = (*angles(), "--method", "fusion")
    for line, option in (
        ((*angles(), "--causal"), "--causal"),
        ((*fusion, "--form", "printed"), "--form"),
        ((*fusion, "--median-window", 5), "--median-window"),
    ):
        assert f"warning: {option} has no effect with --method" in works(*line).stderr
    assert "no effect" not in works(*fusion, "--causal").stderr
    fails(*fusion, "--acc-noise-mps2", "1e-9", says=["--acc-noise-mps2 1e-09: expected at least"])
