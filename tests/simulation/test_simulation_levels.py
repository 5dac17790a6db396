"""Levels and mountings of the walker's simulations, and the files of a simulated recording."""

import importlib.util
import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.reproduction.walker import studies
from mobility_imu.reproduction.walker.tables import POSES, pose_mount
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry
from mobility_imu.simulation import bundle
from mobility_imu.simulation.levels import (
    DATASHEET,
    FOOTPRINT,
    LEVELS,
    MOUNTS,
    REAL_LEVEL,
    tilt_run,
    unit_of,
)
from mobility_imu.simulation.scooter import COURSES
from mobility_imu.simulation.sensor import MTI_1, REAL
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.wheelchair.geometry import WheelchairGeometry


@pytest.mark.parametrize("pose", POSES)
def test_mountings_are_those_of_table_1(pose):
    """Typed in the simulation, worked out from the published table in the reproduction."""
    printed = pose_mount(pose)
    assert np.allclose(
        MOUNTS[pose].rotation_imu_to_body, printed.rotation_imu_to_body, rtol=0, atol=1e-9
    )
    assert np.array_equal(MOUNTS[pose].translation_body_m, printed.translation_body_m)
    assert tuple(MOUNTS) == POSES


def test_levels_grow_from_noise_to_the_frame():
    assert list(LEVELS) == ["data sheet", "sensor", "realistic"]
    assert DATASHEET.acc.noise_density == MTI_1.acc.noise_density > 0
    assert DATASHEET.acc.scale_sd == DATASHEET.gyr.misalignment_sd_rad == 0
    assert LEVELS["data sheet"].sensor == DATASHEET and LEVELS["realistic"].sensor == MTI_1
    assert LEVELS["sensor"].imperfections == LEVELS["data sheet"].imperfections
    for name, level in studies.LEVELS.items():
        assert (level.sensor, level.imperfections) == (
            LEVELS[name].sensor,
            LEVELS[name].imperfections,
        )


def test_levels_and_mountings_cannot_be_changed_for_others():
    for table in (LEVELS, MOUNTS, bundle.WALKER_COURSES):
        with pytest.raises(TypeError):
            table["new"] = None


def test_units_differ_by_pose_and_seed():
    assert len({unit_of(seed, pose) for seed in range(20) for pose in POSES}) == 100


def size(quantity, sensor, measure="median"):
    """Number of the table of what real recordings show."""
    table = pd.read_csv(find_reference())
    values = table["value"][(table["quantity"] == quantity) & (table["sensor"] == sensor)]
    return getattr(values, measure)()


def find_reference():
    return Path(__file__).parents[2] / "data" / "reference" / "real_sensors.csv"


def test_the_real_level_has_the_sizes_that_were_measured():
    """Each within the digits that are written in the code."""
    offset = "gyroscope offset, root mean square of the axes"
    deg = np.deg2rad(1)
    assert REAL.gyr.turn_on_bias_sd == pytest.approx(deg * size(offset, "left_wheel"), rel=0.03)
    frame = REAL_LEVEL.sensor.gyr.turn_on_bias_sd
    assert frame == pytest.approx(deg * size(offset, "frame"), rel=0.01)
    assert REAL.acc.noise_density * 10 == pytest.approx(
        size("accelerometer noise per sample", "left_wheel"), rel=0.05
    )
    assert REAL.gyr.noise_density * 10 == pytest.approx(
        deg * size("gyroscope noise per sample", "frame"), rel=0.05
    )
    assert REAL.acc.step == pytest.approx(size("step of acc", "body"), rel=1e-3)
    assert REAL.gyr.step == pytest.approx(deg * size("step of gyr", "body"), rel=1e-3)
    for band in REAL.vibration:
        low, high = band.band_hz
        shaken = size(f"vibration {low:g} to {high:g} Hz", "frame")
        assert band.sd_mps2 == pytest.approx(shaken, rel=0.01)
    way = REAL.delivery
    assert way.doubled_share == pytest.approx(
        size("doubled samples", "stream", "max") / 100, rel=0.1
    )
    assert way.filled_share == pytest.approx(size("lost samples", "stream") / 100, rel=0.1)
    jitter_ms = size("scatter of the stamps", "stream", "max")
    assert way.jitter_s == pytest.approx(jitter_ms / 1e3, rel=0.05)


def test_the_table_is_what_the_recordings_give():
    root = os.environ.get("MOBILITY_IMU_RECORDINGS")
    if root is None or not (Path(root) / "drives").is_dir():
        pytest.skip("MOBILITY_IMU_RECORDINGS does not name the recordings")
    spec = importlib.util.spec_from_file_location(
        "measure_real_sensors", find_reference().parents[2] / "benchmarks/measure_real_sensors.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found, kept = module.measured(Path(root)), pd.read_csv(find_reference())
    assert found.drop(columns="value").equals(kept.drop(columns="value"))
    assert np.allclose(found["value"], kept["value"], rtol=0.02, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "make", "table"),
    [
        ("scooter", bundle.scooter_bundle, "ride.csv.gz"),
        ("wheelchair", bundle.wheelchair_bundle, "court.csv.gz"),
        ("walker", bundle.walker_bundle, "walk.csv.gz"),
    ],
)
def test_all_devices_take_the_real_level(name, make, table):
    """Rounded as real sensors are, but for samples that were filled in; the same bytes again."""
    usual, real = make(2), make(2, level="real")
    assert tuple(usual) == tuple(real)
    recorded = real[table]
    assert recorded.equals(make(2, level="real")[table])
    for kind, step in (("acc", REAL.acc.step), ("gyr", REAL.gyr.step)):
        values = recorded.filter(like=f"_{kind}_").to_numpy()
        on_grid = np.abs(values / step - np.round(values / step)) < 1e-6
        assert 0.97 < on_grid.mean() < 1
    assert np.allclose(np.diff(recorded["time_s"]), 0.01)
    assert len(recorded) == len(real["truth.csv.gz"])
    with pytest.raises(InputError, match="level = 'none'"):
        make(2, level="none")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: unit_of(1, "6"), "pose = '6': expected '1', '2'"),
        (lambda: unit_of(-1, "1"), "seed = -1"),
        (lambda: tilt_run(0, 1, LEVELS["sensor"]), "pose = 1"),
        (lambda: bundle.scooter_bundle(1, "curve"), "course = 'curve': expected 'straight'"),
        (lambda: bundle.walker_bundle(1, "corridr"), "course = 'corridr': expected 'corridor'"),
        (lambda: bundle.walker_bundle(1, level="data-sheet"), "level = 'data-sheet'"),
        (lambda: bundle.walker_bundle(1, pose=0), "pose = 0"),
        (lambda: bundle.walker_bundle(1, pose=6), "pose = 6"),
        (lambda: bundle.walker_bundle(1, pose="1"), "pose = '1'"),
        (lambda: bundle.wheelchair_bundle(-1), "seed = -1: expected a whole number of 0 or more"),
        (lambda: bundle.scooter_bundle(1.0), "seed = 1.0"),
    ],
)
def test_what_is_not_there_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_bundles_are_what_the_commands_say(tmp_path):
    made = {
        bundle.SCOOTER_FILES: bundle.scooter_bundle(3, "straight"),
        bundle.WHEELCHAIR_FILES: bundle.wheelchair_bundle(3),
        bundle.WALKER_FILES: bundle.walker_bundle(3, level="sensor", pose=4),
    }
    for names, contents in made.items():
        assert tuple(contents) == names
        for name, content in contents.items():
            kind = str if name.endswith(".toml") else pd.DataFrame
            assert isinstance(content, kind), name
    scooter, chair, walker = made.values()
    for name, text in (("s", scooter), ("c", chair), ("w", walker)):
        (tmp_path / f"{name}.toml").write_text(text["geometry.toml"])
    assert ScooterGeometry.from_toml(tmp_path / "s.toml") == SUZUKI_ET4D
    assert WheelchairGeometry.from_toml(tmp_path / "c.toml").track_m == 0.84
    assert WalkerGeometry.from_toml(tmp_path / "w.toml") == FOOTPRINT
    (tmp_path / "m.toml").write_text(walker["true_mount.toml"])
    mount = WalkerMount.from_toml(tmp_path / "m.toml")
    assert np.allclose(
        mount.rotation_imu_to_body, MOUNTS["4"].rotation_imu_to_body, rtol=0, atol=1e-6
    )
    for contents, recording in ((scooter, "ride"), (chair, "court"), (walker, "walk")):
        clock, truth = contents[f"{recording}.csv.gz"]["time_s"], contents["truth.csv.gz"]
        assert np.array_equal(clock, truth["time_s"])


def test_the_ramp_is_a_ramp_and_the_poses_are_held():
    """Both parked recordings hold six poses; on the ramp gravity leans by 5 deg in the body."""
    made = bundle.scooter_bundle(2, "side")
    assert len(made["poses.csv"]) == 6 and set(COURSES) >= {"side"}
    level, ramp = (
        made[f"parked_{name}.csv.gz"].filter(like="body_acc").to_numpy()
        for name in ("level", "ramp")
    )
    apart = np.arccos(
        np.sum(level.mean(axis=0) * ramp.mean(axis=0))
        / np.linalg.norm(level.mean(axis=0))
        / np.linalg.norm(ramp.mean(axis=0))
    )
    assert np.rad2deg(apart) == pytest.approx(5, abs=0.5)  # turn-on biases of 5 mg
