"""A gyroscope that cuts off the peaks of fast swings."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.walker.navigation import NavigationSettings, navigate
from mobility_imu.walker.saturation import bridged_rates

RATE_HZ, RANGE_RADPS = 200.0, 8.7


def swings(seconds=12.0, each_s=0.6, peak_radps=16.0):
    """Rates of a foot about its y axis: back and forth, with rests, the forward swing cut off."""
    time = np.arange(0, seconds, 1 / RATE_HZ)
    rate = np.zeros((len(time), 3))
    for start in np.arange(2.0, seconds - 2.0, 1.5):
        phase = (time - start) / each_s
        moving = (phase > 0) & (phase < 1)
        p = phase[moving]
        rate[moving, 1] = -peak_radps * (np.sin(np.pi * p) ** 4 - 0.375)
        rate[moving, 1] *= np.minimum(1, 20 * np.minimum(p, 1 - p))
    return time, rate


def test_a_bridge_is_nearer_to_the_peak_than_the_limit():
    _, true = swings()
    read = np.clip(true, -RANGE_RADPS, RANGE_RADPS)
    limit = RANGE_RADPS - 1e-6
    assert (np.abs(true) > RANGE_RADPS).any()
    bridged, cut = bridged_rates(read, limit)
    assert (cut == (np.abs(read) > limit).any(axis=1)).all()
    assert (
        np.abs((bridged - true).sum(axis=0)).max() < 0.5 * np.abs((read - true).sum(axis=0)).max()
    )
    assert (bridged[~cut] == read[~cut]).all()
    assert (np.abs(bridged) >= np.abs(read)).all()


def test_within_the_range_nothing_is_touched():
    _, true = swings()
    same, cut = bridged_rates(true, 100.0)
    assert same is true
    assert not cut.any()


@pytest.mark.parametrize("where", [slice(0, 4), slice(-4, None)])
def test_a_cut_at_the_end_of_a_recording_stays(where):
    rate = np.zeros((50, 3))
    rate[where, 2] = 9.0
    bridged, cut = bridged_rates(rate, RANGE_RADPS)
    assert (bridged == rate).all()
    assert cut.sum() == 4


def test_a_path_through_cuts_is_better_and_less_sure():
    """A foot that turns where it is: what is cut off tilts it, and gravity carries it away."""
    time, true = swings()
    attitude = Rotation.identity()
    acc = np.zeros_like(true)
    for k, turn in enumerate(true / RATE_HZ):  # force at the sample, the middle of its interval
        middle = attitude * Rotation.from_rotvec(turn / 2)
        acc[k] = middle.inv().apply([0, 0, 9.80665])
        attitude = attitude * Rotation.from_rotvec(turn)
    still = np.abs(true).max(axis=1) == 0
    read = np.clip(true, -RANGE_RADPS, RANGE_RADPS)
    settings = NavigationSettings.for_foot()
    told = NavigationSettings.for_foot(gyr_range_radps=RANGE_RADPS - 1e-6)
    before = navigate(time, acc, read, still, settings)
    after = navigate(time, acc, read, still, told)
    apart = [np.linalg.norm(path.position_m[:, :2], axis=1).max() for path in (before, after)]
    assert apart[1] < 0.5 * apart[0]
    assert (after.sd[-1, 6:8] > before.sd[-1, 6:8]).all()


def test_cuts_that_are_told_widen_the_path_too():
    time, true = swings()
    acc = np.tile([0.0, 0.0, 9.80665], (len(time), 1))
    still = np.abs(true).max(axis=1) == 0
    cut = np.abs(true).max(axis=1) > RANGE_RADPS
    settings = NavigationSettings.for_foot()
    plain = navigate(time, acc, 0 * true, still, settings)
    wide = navigate(time, acc, 0 * true, still, settings, cut_gyr=cut)
    assert (wide.sd[-1, 6:8] > plain.sd[-1, 6:8]).all()
