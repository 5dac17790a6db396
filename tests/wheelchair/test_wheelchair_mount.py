"""Wheelchair: the mount, applied, written and read."""

import re

import numpy as np
import pytest
from chairs import BOTH_WAYS, EXACT, trials
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.recording import Recording
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    WheelchairGeometry,
    WheelchairMount,
    calibrate_mount,
)

LEFT, RIGHT, FRAME = Rotation.random(3, rng=np.random.default_rng(5)).as_matrix()
MOUNT = WheelchairMount(LEFT, RIGHT, FRAME)


def test_a_mount_turns_vectors_into_wheel_and_chair_axes():
    vectors = np.random.default_rng(1).normal(size=(7, 3))
    assert MOUNT.frame(vectors) == pytest.approx(vectors @ FRAME.T, abs=EXACT)
    assert MOUNT.wheel("left", vectors) == pytest.approx(vectors @ LEFT.T, abs=EXACT)
    assert MOUNT.wheel("right", vectors[0]) == pytest.approx(RIGHT @ vectors[0], abs=EXACT)
    assert MOUNT.wheel("left", vectors.tolist()).shape == (7, 3)
    with pytest.raises(InputError, match="three components"):
        MOUNT.frame(vectors[:, :2])


def test_the_mounted_sensors_measure_the_chair():
    static, straight, drive = trials(SAMPLE_CHAIR, 2, legs=BOTH_WAYS)
    mount = calibrate_mount(static.recording, straight.recording).mount
    yaw = mount.frame(drive.recording.gyroscope("frame"))[:, 2]
    assert yaw == pytest.approx(drive.yaw_rate_radps, abs=EXACT)


@pytest.mark.parametrize("side", ["middle", "Left", None, 1, ["left"]])
def test_a_side_that_no_chair_has_is_refused(side):
    for call in (
        MOUNT.rotation_imu_to_wheel,
        lambda side: MOUNT.wheel(side, np.ones((2, 3))),
        SAMPLE_CHAIR.axle_direction,
        SAMPLE_CHAIR.wheel_centre,
        SAMPLE_CHAIR.wheel_radius_m.of,
    ):
        with pytest.raises(InputError, match=r"side = .*expected 'left' or 'right'"):
            call(side)


@pytest.mark.parametrize(
    ("rotations", "message"),
    [
        ((np.diag([1.0, 1, -1]), RIGHT, FRAME), "rotation_left_imu_to_wheel: a mirror"),
        ((LEFT, 2 * np.eye(3), FRAME), "rotation_right_imu_to_wheel: not orthogonal"),
        ((LEFT, RIGHT, np.full((3, 3), np.nan)), "rotation_frame_imu_to_chair: expected a rot"),
        ((LEFT, RIGHT, None), "rotation_frame_imu_to_chair: missing"),
        ((None, None, FRAME), "both missing"),
        ((LEFT, RIGHT, np.eye(2)), "rotation_frame_imu_to_chair: expected a rotation"),
        ((LEFT, "none", FRAME), "rotation_right_imu_to_wheel: expected real numbers"),
    ],
)
def test_what_is_no_mount_is_refused(rotations, message):
    with pytest.raises(InputError, match=message):
        WheelchairMount(*rotations)


def test_a_mount_keeps_its_rotations():
    left = LEFT.copy()
    mount = WheelchairMount(left, RIGHT, FRAME)
    left[:] = 0
    assert np.array_equal(mount.rotation_left_imu_to_wheel, LEFT)
    with pytest.raises(ValueError, match="read-only"):
        mount.rotation_left_imu_to_wheel[0, 0] = 2


@pytest.mark.parametrize("mount", [MOUNT, WheelchairMount(None, RIGHT, FRAME)])
def test_a_written_mount_reads_as_the_same(tmp_path, mount):
    path = tmp_path / "mount.toml"
    text = mount.to_toml(path, geometry=SAMPLE_CHAIR)
    assert path.read_text() == text
    found = WheelchairMount.from_toml(path)
    assert WheelchairGeometry.from_toml(path) == SAMPLE_CHAIR
    for name in vars(mount):
        one, other = getattr(found, name), getattr(mount, name)
        assert (one is None) == (other is None)
        if one is not None:
            assert one == pytest.approx(other, abs=1e-9)
    assert mount.to_toml() in text and "[wheelchair]" not in mount.to_toml()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.replace("wheelchair.mount", "wheelchair.mont"), "wheelchair.mont is unknown"),
        (lambda t: t.replace("rotation_left", "rotation_lft"), "rotation_lft_imu_to_wheel is unk"),
        (lambda t: t.replace("rotation_frame_imu", "#"), "rotation_frame_imu_to_chair: expected 3"),
        (lambda t: t[: t.index("[wheelchair.mount]")], r"no section \[wheelchair.mount\]"),
        (lambda t: t.replace("= [[", '= [["1", '), "expected 3 x 3 numbers"),
        (lambda t: re.sub(r"= \[\[[^,]+", "= [[9.0", t), "not orthogonal"),
    ],
)
def test_a_faulty_mount_file_is_named_with_what_is_wrong(tmp_path, change, message):
    path = tmp_path / "mount.toml"
    path.write_text(change(MOUNT.to_toml(geometry=SAMPLE_CHAIR)))
    with pytest.raises(InputError, match=message) as error:
        WheelchairMount.from_toml(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("missing", ["left", "right"])
def test_a_wheel_without_a_sensor_has_no_rotation_and_says_so(missing):
    static, straight, drive = (part.recording for part in trials(SAMPLE_CHAIR, 3))
    sensors = {k: v for k, v in straight.sensors.items() if k != f"{missing}_wheel"}
    found = calibrate_mount(static, Recording(straight.time_s, sensors))
    assert getattr(found.mount, f"rotation_{missing}_imu_to_wheel") is None
    assert np.isnan(found.off_axle_share.of(missing))
    assert found.warnings and missing in found.warnings[0]
    with pytest.raises(InputError, match=f"no rotation for the {missing} wheel.*straight-line"):
        found.mount.wheel(missing, drive.gyroscope(f"{missing}_wheel"))
