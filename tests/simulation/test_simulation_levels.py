"""Levels and mountings of the walker's simulations, and the files of a simulated recording."""

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
    tilt_run,
    unit_of,
)
from mobility_imu.simulation.scooter import COURSES
from mobility_imu.simulation.sensor import MTI_1
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
