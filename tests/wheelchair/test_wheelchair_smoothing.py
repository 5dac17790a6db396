"""Velocities of smoothed recordings: what the filter changes is in their standard deviations."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.wheelchair import (
    WheelchairGeometry,
    calibrate_mount,
    estimate_velocity,
    smooth_recording,
    with_smoothing_sd,
)

COURT = recordings_folder() / "wheelchair_court"
CHAIR = WheelchairGeometry.from_toml(COURT / "geometry.toml")
FILTERS = [
    ("moving-average", 7),
    ("moving-average", 51),
    ("savitzky-golay", 7),
    ("savitzky-golay", 51),
]


@cache
def trials():
    return tuple(read_recording(COURT / f"{n}.csv.gz") for n in ("court", "static", "straight"))


def estimate(drive, static, straight):
    found = calibrate_mount(static, straight)
    return estimate_velocity(drive, CHAIR, found.mount, offsets=found.offsets), found.mount


def errors_of(drive):
    truth = pd.read_csv(COURT / "truth.csv.gz")
    return (
        drive.linear_velocity_mps - truth["linear_velocity_mps"],
        drive.yaw_rate_radps - np.deg2rad(truth["yaw_rate_degps"]),
    )


@cache
def smoothed(method, window):
    unsmoothed, mount = estimate(*trials())
    drive, _ = estimate(*[smooth_recording(one, method, window=window) for one in trials()])
    return with_smoothing_sd(drive, unsmoothed, CHAIR, mount, method, window=window), drive


@pytest.mark.parametrize(("method", "window"), FILTERS)
def test_errors_of_smoothed_velocities_lie_within_their_standard_deviations(method, window):
    """95 % or more: what stays constant over a recording may as well be on the safe side."""
    found, plain = smoothed(method, window)
    speed, yaw = errors_of(found)
    speed_sd, yaw_sd = found.linear_velocity_sd_mps, found.yaw_rate_sd_radps
    assert (np.abs(speed) < 2 * speed_sd).mean() > 0.95
    assert (np.abs(yaw) < 2 * yaw_sd).mean() > 0.95
    assert np.median(yaw_sd) < 3 * np.sqrt(np.mean(yaw**2))
    # Half a percent of radius and 0.3 % of scale, of two wheels; this court's are off by less.
    moving = np.abs(found.linear_velocity_mps) > 0.3
    part = (plain.linear_velocity_sd_mps / np.abs(found.linear_velocity_mps))[moving]
    assert np.median(part) == pytest.approx(np.hypot(0.005, 0.003) / np.sqrt(2), rel=0.1)
    assert np.median(speed_sd) < 14 * np.sqrt(np.mean(speed**2))
    assert np.array_equal(found.linear_velocity_mps, plain.linear_velocity_mps)


OUTSIDE = [(0.0, 0.22), (0.59, 0.37), (0.0, 0.14), (0.04, 0.27)]
"""Parts of speeds and yaw rates that lie outside where a filter is not in their deviations."""


@pytest.mark.parametrize(("how", "outside"), list(zip(FILTERS, OUTSIDE, strict=True)))
def test_without_the_filter_standard_deviations_are_too_small(how, outside):
    found, plain = smoothed(*how)
    speed, yaw = errors_of(found)
    parts = (
        (np.abs(speed) > 2 * plain.linear_velocity_sd_mps).mean(),
        (np.abs(yaw) > 2 * plain.yaw_rate_sd_radps).mean(),
    )
    assert parts == pytest.approx(outside, abs=0.01)


def test_no_filter_changes_nothing():
    found, plain = smoothed("none", 7)
    assert np.allclose(found.linear_velocity_sd_mps, plain.linear_velocity_sd_mps, rtol=1e-9)
    assert np.allclose(found.yaw_rate_sd_radps, plain.yaw_rate_sd_radps, rtol=1e-9)


def test_what_is_not_known_without_the_filter_is_not_known_with_it():
    unsmoothed, mount = estimate(*trials())
    names = ("time_s", "linear_velocity_mps", "yaw_rate_radps", "wheel_yaw_rate_radps", "slip")
    fields = {name: getattr(unsmoothed, name) for name in names}
    sd = np.where(np.arange(len(unsmoothed)) < 100, np.inf, 0.1)
    lost = type(unsmoothed)(
        **fields, linear_velocity_sd_mps=sd, yaw_rate_sd_radps=sd, valid=np.isfinite(sd)
    )
    found = with_smoothing_sd(unsmoothed, lost, CHAIR, mount)
    assert np.isinf(found.linear_velocity_sd_mps[:100]).all() and not found.valid[:100].any()
    assert np.isfinite(found.yaw_rate_sd_radps[100:]).all() and found.valid[100:].all()


def test_series_of_two_lengths_are_refused():
    unsmoothed, mount = estimate(*trials())
    short = Recording(
        trials()[0].time_s[:-1],
        {n: Imu(i.acc_mps2[:-1], i.gyr_radps[:-1]) for n, i in trials()[0].sensors.items()},
    )
    drive, _ = estimate(short, *trials()[1:])
    with pytest.raises(InputError, match=r"unsmoothed: \d+ samples, expected \d+"):
        with_smoothing_sd(drive, unsmoothed, CHAIR, mount)


def test_a_wheel_that_turns_gravity_round_within_the_window_is_smoothed_all_the_same():
    """At 9 rad/s, a turn takes 0.7 s: over half of it little of gravity is left."""
    time_s = np.arange(2000) / 100
    angle = 9.0 * time_s
    acc = 9.81 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(2000)])
    gyr = np.tile([0.0, 0.0, -9.0], (2000, 1)) + np.random.default_rng(2).normal(0, 0.01, (2000, 3))
    found = smooth_recording(
        Recording(time_s, {"left_wheel": Imu(acc, gyr)}), "moving-average", window=51
    ).sensor("left_wheel")
    assert np.array_equal(found.acc_mps2, acc)
    assert found.gyr_radps.std(axis=0).max() < 0.003
