"""A wheel that turns faster than its gyroscope can read, as on the drives of others."""

from dataclasses import replace

import numpy as np
import pytest
from chairs import trials

from mobility_imu.recording import Imu, Recording
from mobility_imu.runs import runs_of
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.simulation.wheelchair import random_court, random_mounting, simulate_drive
from mobility_imu.simulation.wheelchair.chair import Leg
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    WheelchairGeometry,
    calibrate_mount,
    check_geometry,
    estimate_velocity,
)
from mobility_imu.wheelchair.saturation import (
    saturated_gyroscopes,
    saturation_warnings,
    usable_samples,
)

RANGE_DEGPS = 250.0


def narrow():
    """The simulated sensor, set to 250 deg/s as on a cheap module."""
    return replace(MTI_1, gyr=replace(MTI_1.gyr, full_scale=np.deg2rad(RANGE_DEGPS)))


@pytest.fixture(scope="module")
def drives():
    """Courts with a wide and with a narrow range; wheels lie with an axis along the axle."""
    court = random_court(7, slips=0)
    static, straight = court.calibration_trials(MTI_1)
    cal = calibrate_mount(static.recording, straight.recording)
    wide, tight = court.drive(MTI_1), court.drive(narrow())
    return court, cal, wide, tight


def test_a_limit_is_found_where_the_wheel_is_faster(drives):
    _, _, wide, tight = drives
    assert not saturated_gyroscopes(wide.recording, wide.recording.sensors)
    found = saturated_gyroscopes(tight.recording, tight.recording.sensors)
    assert set(found) == {"left_wheel", "right_wheel"}
    for name, flags in found.items():
        beyond = np.abs(wide.recording.gyroscope(name)).max(axis=1) > np.deg2rad(RANGE_DEGPS)
        assert (flags & ~beyond).sum() <= 2
        assert (flags & beyond).sum() > 0.9 * beyond.sum()
    for sentence in saturation_warnings(tight.recording, found):
        assert "end of its range (250 deg/s)" in sentence
        assert "choose a larger range" in sentence
    usable = usable_samples(len(tight.recording), found)
    assert (usable == ~(found["left_wheel"] | found["right_wheel"])).all()


def test_the_speed_is_not_trusted_there(drives):
    court, cal, wide, tight = drives
    before = estimate_velocity(wide.recording, court.geometry, cal.mount, offsets=cal.offsets)
    after = estimate_velocity(tight.recording, court.geometry, cal.mount, offsets=cal.offsets)
    unknown = np.isinf(after.linear_velocity_sd_mps)
    assert 0.01 < unknown.mean() < 0.9
    assert not np.isinf(before.linear_velocity_sd_mps).any()
    error = np.abs(after.linear_velocity_mps - tight.linear_velocity_mps)
    # Outside, half a second off the limit, it is as good as with the wide range.
    near = np.convolve(unknown, np.ones(101), "same") > 0
    assert error[unknown].max() > 0.3
    assert error[~near].max() < 0.1
    assert not after.slip[unknown].any()
    assert sum("end of its range" in sentence for sentence in after.warnings) == 2
    assert np.isfinite(after.yaw_rate_sd_radps).all()


def test_one_wheel_and_a_frame_at_their_limits(drives):
    court, cal, _, tight = drives
    sensors = {k: v for k, v in tight.recording.sensors.items() if k != "left_wheel"}
    gyr = sensors["frame"].gyr_radps.copy()
    axis = int(np.argmax(np.abs(gyr).max(axis=0)))
    limit = np.deg2rad(125.0)
    gyr[500:600, axis] = limit
    gyr[:, axis] = np.clip(gyr[:, axis], -limit, limit)
    sensors["frame"] = Imu(sensors["frame"].acc_mps2, gyr)
    found = estimate_velocity(Recording(tight.recording.time_s, sensors), court.geometry, cal.mount)
    assert np.isinf(found.yaw_rate_sd_radps[500:600]).all()
    assert np.isinf(found.linear_velocity_sd_mps[500:600]).all()


def test_the_check_leaves_such_samples_out(drives):
    court, cal, wide, tight = drives
    before, after = (
        check_geometry(run.recording, court.geometry, cal.mount, offsets=cal.offsets)
        for run in (wide, tight)
    )
    assert before.judged and after.judged
    assert abs(after.track_m - court.geometry.track_m) < 3 * after.track_sd_m
    assert after.correlation > 0.99
    assert any("end of its range" in sentence for sentence in after.warnings)


def test_exact_readings_of_a_steady_motion_are_no_limit():
    """Simulated without noise, at a speed that no range has, and at one that a range has."""
    chair = WheelchairGeometry.from_degrees(
        0, wheel_radius_left_m=0.3, wheel_radius_right_m=0.3, track_m=0.6
    )
    for speed in (1.0, 0.3 * np.deg2rad(RANGE_DEGPS)):
        drive = simulate_drive(
            (Leg(1, 2.0), Leg(2, 5.0, float(speed)), Leg(1, 2.0)), chair, random_mounting(0), seed=0
        )
        assert not saturated_gyroscopes(drive.recording, drive.recording.sensors)


def test_the_sample_chair_is_below_every_limit():
    for run in trials(SAMPLE_CHAIR, 3):
        assert not saturated_gyroscopes(run.recording, run.recording.sensors)


def clipped(limit_radps):
    """A sensor whose z axis swings beyond a limit; the others tremble."""
    rng = np.random.default_rng(4)
    gyr = 0.1 * rng.standard_normal((300, 3))
    swing = 1.5 * limit_radps * np.sin(np.arange(300) / 40) ** 3
    gyr[:, 2] = np.clip(swing, -limit_radps, limit_radps)
    acc = np.tile([0.0, 0.0, 9.8], (300, 1))
    return Recording(np.arange(300) / 100, {"frame": Imu(acc, gyr)})


@pytest.mark.parametrize("range_degps", [125, 300, 350, 400, 450, 500, 600, 900, 1000, 1200, 2000])
def test_ranges_that_are_sold_are_limits_to_two_percent(range_degps):
    """The fastest axis stays at the limit for half a second while the others still change."""
    for own, counts in ((1.0, True), (0.981, True), (1.019, True), (0.97, False), (1.03, False)):
        limit = np.deg2rad(range_degps * own)
        recording = clipped(limit)
        found = saturated_gyroscopes(recording, ["frame"])
        assert bool(found) == counts
        if counts:
            at_limit = np.abs(recording.gyroscope("frame")[:, 2]) == limit
            assert np.array_equal(found["frame"], at_limit)


@pytest.mark.parametrize(
    ("largest_degps", "counts"),
    [(239.9, False), (240.2, True), (247.5, True), (254.9, True), (255.1, False)],
)
def test_ranges_that_are_neighbours_leave_no_gap(largest_degps, counts):
    """245 deg/s less 2 % to 250 deg/s and 2 %."""
    recording = clipped(np.deg2rad(largest_degps))
    assert bool(saturated_gyroscopes(recording, ["frame"])) == counts


@pytest.mark.parametrize(("rate_hz", "shortest"), [(50, 3), (100, 5), (200, 10)])
def test_a_limit_is_held_for_a_twentieth_of_a_second(rate_hz, shortest):
    """Three samples at least; a peak in coarse steps repeats itself for less."""
    limit = np.deg2rad(RANGE_DEGPS)
    for held in (shortest - 1, shortest):
        rng = np.random.default_rng(5)
        up = np.arange(0.0, limit, 0.5)
        peak = np.r_[up, np.full(held, limit), up[::-1], np.zeros(30)]
        gyr = 0.05 * rng.standard_normal((4 * len(peak), 3))
        gyr[:, 2] = np.tile(peak, 4) + 0.01 * rng.standard_normal(len(gyr)) * (
            np.tile(peak, 4) < limit
        )
        acc = np.tile([0.0, 0.0, 9.8], (len(gyr), 1))
        recording = Recording(np.arange(len(gyr)) / rate_hz, {"frame": Imu(acc, gyr)})
        found = saturated_gyroscopes(recording, ["frame"])
        assert bool(found) == (held == shortest)
        if found:
            assert np.array_equal(found["frame"], gyr[:, 2] == limit)


def test_a_recording_may_begin_and_end_at_the_limit():
    whole = clipped(np.deg2rad(RANGE_DEGPS))
    at_limit = np.abs(whole.gyroscope("frame")[:, 2]) == np.deg2rad(RANGE_DEGPS)
    first, last, *_ = runs_of(at_limit)
    part = slice(first.stop - 10, last.start + 10)
    imu = whole.sensors["frame"]
    cut = Imu(imu.acc_mps2[part], imu.gyr_radps[part])
    found = saturated_gyroscopes(Recording(whole.time_s[part], {"frame": cut}), ["frame"])
    assert np.array_equal(found["frame"], at_limit[part]) and found["frame"][[0, -1]].all()


def test_a_wheel_beyond_its_range_for_more_than_half_of_the_time():
    """The median rate is the limit itself then. 125 deg/s is 0.7 m/s of a usual wheel."""
    court = random_court(3, slips=0)
    low = replace(MTI_1, gyr=replace(MTI_1.gyr, full_scale=np.deg2rad(125.0)))
    wide, tight = court.drive(MTI_1), court.drive(low)
    found = saturated_gyroscopes(tight.recording, ["left_wheel", "right_wheel"])
    halves = []
    for name, flags in found.items():
        beyond = np.abs(wide.recording.gyroscope(name)).max(axis=1) > np.deg2rad(126)
        assert 0.3 < beyond.mean()
        halves.append(flags.mean() > 0.5)
        assert (flags & beyond).sum() > 0.97 * beyond.sum()
    assert any(halves)
    assert set(found) == {"left_wheel", "right_wheel"}
