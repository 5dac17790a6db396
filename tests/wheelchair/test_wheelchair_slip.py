"""Wheelchair: windows of slip and their correction."""

import math

import numpy as np
import pytest
from chairs import (
    EXACT,
    calibrated,
    trials,
)

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.wheelchair import (
    COURT,
    IDEAL,
    LIKE_SAMPLE,
)
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    VelocitySettings,
    estimate_velocity,
    slip_report,
    slip_sources,
)
from mobility_imu.wheelchair.slip import (
    SlipSettings,
    SlipWindows,
    Source,
    WheelSpeeds,
    correct_slip,
    detect_slip,
    wheel_speeds,
)


def series(count, *stretches):
    """Zeros with ones in [first, last]."""
    values = np.zeros(count)
    for first, last in stretches:
        values[first : last + 1] = 1.0
    return values


@pytest.mark.parametrize(
    ("rate", "stretches", "windows"),
    [
        (100, [], []),
        (100, [(20, 20)], [(20, 20)]),
        # last to first: 9 frames apart merge, 10 (0.10 s) do not
        (100, [(20, 25), (34, 40)], [(20, 40)]),
        (100, [(20, 25), (35, 40)], [(20, 25), (35, 40)]),
        (100, [(20, 25), (34, 40), (49, 50)], [(20, 50)]),
        (50, [(20, 25), (29, 40)], [(20, 40)]),
        (50, [(20, 25), (30, 40)], [(20, 25), (30, 40)]),
        (100, [(0, 3), (97, 99)], [(0, 3), (97, 99)]),
        (100, [(0, 99)], [(0, 99)]),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_slip_windows_and_their_merging(rate, stretches, windows, sign):
    apart = series(100, *stretches)
    found = detect_slip(np.full(100, 0.4), 0.4 + sign * apart, rate)
    assert list(zip(found.first, found.last, strict=True)) == windows
    flags = found.flags(100)
    assert flags.tolist() == series(100, *windows).astype(bool).tolist()


def test_a_difference_at_the_threshold_is_no_slip():
    assert len(detect_slip([0.0, 0.0], [0.2, -0.2], 100).first) == 0
    assert len(detect_slip([0.0, 0.0], [np.nextafter(0.2, 1), 0.0], 100).first) == 1


@pytest.mark.parametrize(("length", "replaced"), [(6, False), (7, True)])
def test_only_windows_longer_than_60_ms_are_corrected(length, replaced):
    windows = SlipWindows(np.array([50]), np.array([50 + length - 1]))
    velocity = np.r_[np.ones(50), np.full(length, 5.0), np.ones(143 - length)]
    corrected = correct_slip(velocity, np.zeros(193), windows, 100, method="tool")
    inside = corrected[50 : 50 + length]
    assert np.allclose(inside, 1.0 if replaced else 5.0, atol=EXACT)
    assert np.array_equal(np.delete(corrected, np.s_[50 : 50 + length]), np.ones(193 - length))


def slipping_drive(noise):
    """A drive, and the same one with the left wheel spinning freely for half a second, twice."""
    static, straight, drive = trials(SAMPLE_CHAIR, 11, legs=COURT[:4], noise=noise)
    calibration = calibrated(static, straight)
    extra = np.zeros(len(drive.recording))
    for first in (350, 1000):
        extra[first : first + 50] = 6.0 * np.sin(np.pi * np.arange(50) / 50) ** 2
    imu = drive.recording.sensor("left_wheel")
    axle = calibration.mount.rotation_left_imu_to_wheel[2]
    sensors = dict(drive.recording.sensors)
    sensors["left_wheel"] = Imu(imu.acc_mps2, imu.gyr_radps + extra[:, None] * axle)
    return drive, Recording(drive.recording.time_s, sensors), calibration, extra > 0


@pytest.mark.parametrize("noise", [IDEAL, LIKE_SAMPLE])
def test_correction_restores_a_slipping_stretch_better_than_leaving_it(noise):
    drive, slipping, calibration, where = slipping_drive(noise)
    left, mended = (
        estimate_velocity(
            slipping, SAMPLE_CHAIR, calibration.mount, VelocitySettings(slip_correction=on)
        )
        for on in (False, True)
    )
    truth = drive.linear_velocity_mps
    error_left = np.abs(left.linear_velocity_mps - truth)
    error_mended = np.abs(mended.linear_velocity_mps - truth)
    assert error_left[where].max() > 0.9  # 6 rad/s on one of two wheels of 0.315 m
    # the ends of a slip lie below the threshold: 0.2 rad/s of 0.84 m of track, halved
    assert error_mended[where].max() < 0.1
    assert np.array_equal(left.slip, mended.slip)
    assert where[left.slip].mean() > 0.95
    assert left.slip[where].mean() > 0.7
    assert np.array_equal(
        left.linear_velocity_mps[~left.slip], mended.linear_velocity_mps[~left.slip]
    )


def test_tilt_and_bias_of_the_accelerometer_do_not_matter_between_two_good_ends():
    windows = SlipWindows(np.array([40]), np.array([90]))
    velocity = np.full(200, 1.5)
    velocity[40:91] = 9.0
    corrected = correct_slip(velocity, np.full(200, 0.7), windows, 100, method="tool")
    assert corrected == pytest.approx(np.full(200, 1.5), abs=EXACT)


@pytest.mark.parametrize("window", [(0, 20), (180, 199), (0, 199), (0, 198), (1, 199)])
def test_windows_at_the_ends_lean_on_the_end_that_is_there(window):
    time_s = np.arange(200) / 100
    truth = 1 + 0.5 * time_s
    velocity = truth.copy()
    velocity[window[0] : window[1] + 1] += 2.0
    windows = SlipWindows(np.array([window[0]]), np.array([window[1]]))
    corrected = correct_slip(velocity, np.full(200, 0.5), windows, 100, method="tool")
    if window == (0, 199):  # no good speed anywhere: only its changes are known
        assert np.diff(corrected) == pytest.approx(np.diff(truth), abs=EXACT)
    else:
        assert corrected == pytest.approx(truth, abs=EXACT)


@pytest.mark.parametrize("count", [2, 8, 9, 10, 15])
def test_shortest_recordings_do_not_break_the_correction(count):
    windows = SlipWindows(np.array([0]), np.array([count - 1]))
    assert np.isfinite(
        correct_slip(np.ones(count), np.zeros(count), windows, 100, method="tool")
    ).all()


def test_slip_settings_are_checked():
    SlipSettings(merge_gap_s=0.0)
    for change in ({"threshold_radps": 0.0}, {"low_pass_hz": -1.0}, {"shortest_s": math.nan}):
        with pytest.raises(InputError, match=next(iter(change))):
            SlipSettings(**change)


def test_a_rate_that_is_too_low_for_the_low_pass_is_refused():
    windows = SlipWindows(np.array([2]), np.array([5]))
    with pytest.raises(InputError, match=r"low_pass_hz = 2: expected less than half.*3 Hz"):
        correct_slip(np.ones(30), np.zeros(30), windows, 3, method="tool")
    lower = SlipSettings(low_pass_hz=1.0)
    assert len(correct_slip(np.ones(30), np.zeros(30), windows, 3, lower, method="tool")) == 30


def test_a_report_of_nothing_has_no_share():
    nothing = SlipWindows(np.zeros(0), np.zeros(0))
    report = slip_report([], [], nothing, 100)
    assert report.share == report.corrected_share == report.largest_change == 0


@pytest.mark.parametrize(
    ("first", "last", "message"),
    [
        ([3], [2], "end before the next one begins"),
        ([3, 4], [5, 6], "end before the next one begins"),
        ([-1], [2], "end before the next one begins"),
        # one wrong window among right ones
        ([-1, 4, 9], [2, 6, 12], "end before the next one begins"),
        ([1, 4, 9], [2, 3, 12], "end before the next one begins"),
        ([1, 4, 6], [2, 6, 12], "end before the next one begins"),
        ([1.5, 4], [2, 6], "whole numbers"),
        ([1, 4], [2, 6.5], "whole numbers"),
        ([1.5], [2], "whole numbers"),
        ([1], [2, 3], "as many first as last"),
        ([np.nan], [2], "windows.first: sample 0 is nan"),
    ],
)
def test_windows_that_cannot_be_are_refused(first, last, message):
    with pytest.raises(InputError, match=message):
        SlipWindows(first, last)


def test_windows_of_another_recording_are_refused():
    windows = SlipWindows([5], [40])
    speeds = wheel_speeds(np.ones(30), np.zeros(30), np.zeros(30), SAMPLE_CHAIR)
    for call in (
        lambda: correct_slip(np.ones(30), np.ones(30), windows, 100, wheels=speeds),
        lambda: slip_sources(speeds, np.ones(30), windows, 100),
        lambda: slip_report(np.ones(30), np.ones(30), windows, 100),
        lambda: windows.flags(30),
    ):
        with pytest.raises(InputError, match="ends at sample 40, but there are 30 samples"):
            call()


@pytest.mark.parametrize("rate", [0, -100, np.nan, np.inf, "100", True, None])
def test_rates_that_no_sensor_has_are_refused(rate):
    windows = SlipWindows([], [])
    speeds = wheel_speeds(np.ones(30), np.zeros(30), np.zeros(30), SAMPLE_CHAIR)
    for call in (
        lambda: detect_slip(np.ones(30), np.ones(30), rate),
        lambda: correct_slip(np.ones(30), np.ones(30), windows, rate, wheels=speeds),
        lambda: slip_sources(speeds, np.ones(30), windows, rate),
        lambda: slip_report(np.ones(30), np.ones(30), windows, rate),
    ):
        with pytest.raises(InputError, match="sampling_rate_hz = "):
            call()


@pytest.mark.parametrize("source", [[5.0], [0, 1], ["left"], [0.5]])
def test_sources_that_are_none_are_refused(source):
    with pytest.raises(InputError, match="source"):
        slip_report([1.0], [1.0], SlipWindows([], []), 100, source=source)


@pytest.mark.parametrize("method", ["tool", "wheels"])
def test_of_several_windows_only_the_long_ones_are_corrected(method):
    """Three windows in which the left wheel spins: 50 ms, 300 ms, and 50 ms again."""
    windows = SlipWindows([20, 60, 120], [24, 89, 124])
    spin = windows.flags(200).astype(float)
    speeds = wheel_speeds(1 + 0.5 * spin, -spin / SAMPLE_CHAIR.track_m, 0 * spin, SAMPLE_CHAIR)
    assert np.allclose(speeds.left, 1 + spin) and np.allclose(speeds.right, 1)
    velocity = (speeds.left + speeds.right) / 2
    corrected = correct_slip(velocity, 0 * spin, windows, 100, wheels=speeds, method=method)
    assert np.allclose(corrected, 1 + 0.5 * spin * (np.arange(200) // 60 != 1), atol=EXACT)


@pytest.mark.parametrize(
    ("off", "apart", "source"),
    [
        (0.4, 1.0, Source.LEFT_WHEEL),  # nearer to the acceleration than to the other wheel
        (-0.4, -1.0, Source.LEFT_WHEEL),
        (0.6, 1.0, Source.ACCELERATION),  # nearer to the other wheel
        (1.4, -1.0, Source.RIGHT_WHEEL),
        (0.14, 0.1, Source.LEFT_WHEEL),  # within 0.09 m/s, root mean square
        (0.16, 0.1, Source.ACCELERATION),
    ],
)
def test_the_wheel_that_rolls_is_near_the_acceleration_or_far_from_the_other(off, apart, source):
    """At a steady 1 m/s both wheels rise and fall again, with a root mean square of sqrt(3/8)."""
    bump = np.zeros(300)
    bump[100:200] = np.sin(np.pi * (np.arange(100) + 0.5) / 100) ** 2
    speeds = WheelSpeeds(1 + off * bump, 1 + (off + apart) * bump)
    found = slip_sources(speeds, np.zeros(300), SlipWindows([100], [199]), 100)
    assert (found[100:200] == source).all() and not found[:100].any() and not found[200:].any()


def test_a_report_states_share_change_and_source_of_each_window():
    """100 samples; windows of 4 and of 10, of which the second takes one wheel, then the other."""
    windows = SlipWindows([10, 30], [13, 39])
    source = np.zeros(100)
    source[30:39], source[39] = Source.LEFT_WHEEL, Source.RIGHT_WHEEL
    before = np.zeros(100)
    after = 0.02 * np.arange(100) * (source > 0)
    report = slip_report(before, after, windows, 50, SlipSettings(shortest_s=0.1), source=source)
    assert report.start_s.tolist() == [0.2, 0.6] and report.end_s.tolist() == [0.26, 0.78]
    assert report.corrected.tolist() == [False, True]
    assert report.largest_change_mps == pytest.approx([0.0, 0.78])
    assert report.sources == ("both wheels", "left wheel and right wheel")
    assert report.share == pytest.approx(0.14) and report.corrected_share == pytest.approx(0.1)
    table = report.to_frame()
    assert table["speed_from"].tolist() == list(report.sources) and report.largest_change == 0.78
    one = slip_report([1.0], [2.0], SlipWindows([0], [0]), 50, SlipSettings(shortest_s=1e-3))
    assert one.share == one.corrected_share == 1 and one.sources == ("acceleration",)
