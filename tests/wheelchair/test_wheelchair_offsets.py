"""Constant offsets of the chair's gyroscopes: no calibration, turn or radius may suffer."""

import numpy as np
import pytest
from chairs import trials

from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.wheelchair import LIKE_SAMPLE, Leg
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    VelocitySettings,
    calibrate_mount,
    check_geometry,
    estimate_velocity,
)

TURN = (Leg(1, 3.0), Leg(2, 2.0, 1.2), Leg(4, 3.0, 0.0, 50.0), Leg(2, 2.0, 1.2), Leg(1, 1.0))
BOTH_WAYS = (
    Leg(1, 3.0),
    Leg(2, 2.0, 1.2),
    Leg(4, 4.0, 0.0, 90.0),
    Leg(2, 2.0, 1.2),
    Leg(4, 4.0, 0.0, -90.0),
    Leg(3, 2.0, -1.0),
)


def shifted(recording, offsets):
    sensors = dict(recording.sensors)
    for name, offset in offsets.items():
        sensors[name] = Imu(sensors[name].acc_mps2, recording.gyroscope(name) + offset)
    return Recording(recording.time_s, sensors, source=recording.source)


def turned(found):
    return np.rad2deg(found.yaw_rate_radps.sum() / found.sampling_rate_hz)


SENSORS = ("frame", "left_wheel", "right_wheel")


@pytest.mark.parametrize("size_degps", [1.0, 3.0])
@pytest.mark.parametrize("sensor", SENSORS)
def test_an_offset_changes_no_calibration_and_no_turn(sensor, size_degps):
    """150 deg in 3 s; every axis of one sensor is off, in all three recordings alike."""
    runs = [run.recording for run in trials(SAMPLE_CHAIR, 5, TURN, noise=LIKE_SAMPLE)]
    offset = np.deg2rad(size_degps) * np.array([1.0, -1.0, 1.0])
    static, straight, drive = (shifted(run, {sensor: offset}) for run in runs)
    reference, found = calibrate_mount(*runs[:2]), calibrate_mount(static, straight)
    for name in ("rotation_frame_imu_to_chair", "rotation_left_imu_to_wheel"):
        apart = getattr(found.mount, name) - getattr(reference.mount, name)
        assert np.abs(apart).max() < 1e-9
    before = estimate_velocity(runs[2], SAMPLE_CHAIR, reference.mount)
    after = estimate_velocity(drive, SAMPLE_CHAIR, found.mount)
    assert turned(after) == pytest.approx(150, abs=1.0)
    assert turned(after) == pytest.approx(turned(before), abs=1e-6)
    np.testing.assert_allclose(after.linear_velocity_mps, before.linear_velocity_mps, atol=1e-9)
    taken = after.offsets[sensor].offset_radps - before.offsets[sensor].offset_radps
    np.testing.assert_allclose(taken, offset, atol=1e-9)
    if size_degps > 2:
        assert any(f"gyroscope of {sensor} has an offset" in text for text in after.warnings)


def test_without_taking_them_off_the_turn_is_wrong():
    """The same offset, left in: what the other tests hold against."""
    static, straight, drive = (run.recording for run in trials(SAMPLE_CHAIR, 5, TURN))
    mount = calibrate_mount(static, straight).mount
    up = mount.rotation_frame_imu_to_chair[2]
    drive = shifted(drive, {"frame": np.deg2rad(2.0) * up})
    raw = estimate_velocity(drive, SAMPLE_CHAIR, mount, VelocitySettings(take_off_offsets=False))
    assert turned(raw) == pytest.approx(150 + 2.0 * 11, abs=1.0)
    assert raw.offsets == {}
    printed = estimate_velocity(drive, SAMPLE_CHAIR, mount, VelocitySettings(form="printed"))
    assert turned(printed) == pytest.approx(turned(raw), abs=1e-9)


@pytest.mark.parametrize("sensor", SENSORS)
def test_an_offset_blames_neither_track_nor_radii(sensor):
    runs = [run.recording for run in trials(SAMPLE_CHAIR, 6, BOTH_WAYS, noise=LIKE_SAMPLE)]
    offset = np.deg2rad([3.0, -2.0, 2.5])
    static, straight, drive = (shifted(run, {sensor: offset}) for run in runs)
    cal = calibrate_mount(static, straight)
    found = check_geometry(drive, SAMPLE_CHAIR, cal.mount, offsets=cal.offsets)
    assert found.fits, found.warnings
    assert found.lag_s == pytest.approx(0, abs=0.005)
    assert found.correlation > 0.999 and found.gain == pytest.approx(1, abs=0.01)


def test_a_trial_without_rest_takes_the_calibrations_offsets_or_says_so():
    static, straight, drive = (
        shifted(run.recording, {"frame": np.deg2rad([0.0, 0.0, 2.0])})
        for run in trials(SAMPLE_CHAIR, 7, BOTH_WAYS, noise=LIKE_SAMPLE)
    )
    cal = calibrate_mount(static, straight)
    rolling = drive.trim(3.4, np.inf)
    known = estimate_velocity(rolling, SAMPLE_CHAIR, cal.mount, offsets=cal.offsets)
    assert np.rad2deg(known.offsets["frame"].offset_radps[2]) == pytest.approx(2.0, abs=0.2)
    unknown = estimate_velocity(rolling, SAMPLE_CHAIR, cal.mount)
    assert unknown.offsets == {}
    assert any("no second of rest" in text for text in unknown.warnings)
    assert (unknown.yaw_rate_sd_radps > known.yaw_rate_sd_radps).mean() > 0.95
    # A rest of the trial itself counts for more than another day's.
    other = {
        "frame": calibrate_mount(
            *(shifted(r, {"frame": [0, 0, 0.1]}) for r in (static, straight))
        ).offsets["frame"]
    }
    own = estimate_velocity(drive, SAMPLE_CHAIR, cal.mount, offsets=other)
    assert np.rad2deg(own.offsets["frame"].offset_radps[2]) == pytest.approx(2.0, abs=0.2)


def test_a_straight_line_with_a_bend_gives_its_straight_part():
    bend = (Leg(1, 2.0), Leg(2, 4.0, 1.2), Leg(6, 2.0, 1.0, 60.0), Leg(1, 1.0))
    static, straight, _ = trials(SAMPLE_CHAIR, 8, noise=LIKE_SAMPLE)
    _, _, bent = trials(SAMPLE_CHAIR, 8, bend, noise=LIKE_SAMPLE)
    wanted = calibrate_mount(static.recording, straight.recording).mount
    found = calibrate_mount(static.recording, bent.recording)
    assert "only its straightest part is used" in found.warnings[0]
    for name in ("rotation_frame_imu_to_chair", "rotation_left_imu_to_wheel"):
        apart = getattr(found.mount, name)[2] @ getattr(wanted, name)[2]
        assert np.arccos(min(apart, 1.0)) < np.deg2rad(2.0)
    forward = found.mount.rotation_frame_imu_to_chair[0] @ wanted.rotation_frame_imu_to_chair[0]
    assert np.arccos(min(forward, 1.0)) < np.deg2rad(3.0)
