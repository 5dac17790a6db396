"""What a recording tells of its own noise: relations that hold exactly for made signals."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mobility_imu.scooter.fusion_noise import (
    COLOURED_AFTER_S,
    KEPT_BY_MEANS,
    SMALLEST_NOISE_MPS2,
    TURNS_AFTER_S,
    acceleration_noise,
    added_variance,
    bounded_and_wandering,
    smallest_step,
    smoothed,
    trust,
    white_and_coloured,
)
from mobility_imu.scooter.fusion_settings import FusionSettings

MAD = 1.4826
"""Standard deviation of a Gaussian by its median absolute deviation."""


def test_the_spread_is_about_the_median():
    lever, body = np.zeros((5, 3)), np.zeros((5, 3))
    lever[:, 2] = [10.0, 10.0, 11.0, 12.0, 20.0]
    body[:, 1] = 9.0
    assert acceleration_noise(lever, body) == pytest.approx(MAD * 1.0)


def test_the_step_of_the_coarser_converter():
    lever, body = np.zeros((6, 3)), np.zeros((6, 3))
    lever[:, 0] = [0.0, 0.5, 0.25, 0.5, 1.0, 0.0]
    body[:, 2] = [9.0, 9.1, 9.2, 9.4, 9.0, 9.0]
    assert smallest_step(lever, body) == 0.25
    assert smallest_step(body, 0 * lever) == pytest.approx(0.1)
    assert smallest_step(0 * body, 0 * lever) == SMALLEST_NOISE_MPS2


# Here and below as many changes are up as down: their median is 0.


def test_a_noise_that_alternates_is_white():
    values = np.tile([[1.0, 0.0, 0.5], [-1.0, 0.0, -0.5]], (101, 1))[:-1]
    assert_allclose(white_and_coloured(values, 10.0, 1.0), (MAD * 2 / 2**0.5, 0.0))


def test_a_noise_that_stays_for_its_correlation_time_is_coloured():
    steps = np.repeat(np.tile([1.0, -1.0], 11)[:-1], 20)
    values = steps[:, None] * [0.5, 1.0, 0.0]
    whole = (2 * MAD) ** 2 / 2
    white, coloured = white_and_coloured(values, 10.0, 2.0)
    assert white == 0 and coloured == pytest.approx((whole / KEPT_BY_MEANS) ** 0.5)
    # A correlation time of one sample or less: there is no mean that could take anything away.
    each = np.repeat(np.tile([1.0, -1.0], 21)[:-1], 10)[:, None] * [0.5, 1.0, 0.0]
    assert_allclose(white_and_coloured(each, 10.0, 0.01), (0.0, whole**0.5))


@pytest.mark.parametrize(
    ("rate_hz", "correlation_s", "fewest"),
    [(1.0, 0.1, 50), (100.0, 0.1, 1000), (100.0, 0.3, 1200), (10.0, 2.0, 200)],
)
def test_short_recordings_tell_nothing_of_their_noise(rate_hz, correlation_s, fewest):
    values = np.random.default_rng(7).standard_normal((fewest, 3))
    assert white_and_coloured(values, rate_hz, correlation_s) is not None
    assert white_and_coloured(values[1:], rate_hz, correlation_s) is None
    assert COLOURED_AFTER_S == 1.0


@pytest.mark.parametrize(("seconds", "part"), [(64, 1.0), (32, 1.0), (16, 0.5)])
def test_an_angle_that_grows_wanders(seconds, part):
    """Rates on a straight line: the mean square of a parabola's differences is known exactly."""
    rate_hz, grown = 10.0, 0.02
    n = round(seconds * rate_hz)
    steps = np.array([round(part * after * rate_hz) for after in TURNS_AFTER_S])
    squares = (grown * steps / (2 * rate_hz)) ** 2 * (n - steps) * (n - steps + 2) / 3
    density2 = np.diff(squares)[0] / (np.diff(steps)[0] / rate_hz)
    angle, density = bounded_and_wandering(grown * np.arange(n) + 5.0, rate_hz)
    assert angle == 0 and density == pytest.approx(density2**0.5)


def test_an_angle_that_comes_and_goes_is_bounded():
    """A swing with a period of 4 s is as far as it can be after 2 s, and back after 8."""
    rate_hz = 50.0
    angle = 0.03 * np.cos(2 * np.pi * np.arange(40 * 50 + 1) / (4 * rate_hz))
    found, density = bounded_and_wandering(rate_hz * np.diff(angle), rate_hz)
    assert density == 0 and found == pytest.approx(0.03, rel=5e-3)
    assert bounded_and_wandering(np.ones(49), 10.0) == (0.0, 0.0)
    assert bounded_and_wandering(np.arange(50.0), 0.001) == (0.0, 0.0)


def test_a_residual_counts_less_by_the_square_of_its_size():
    """Of all axes together: the root mean square of 3, 0, 0 is 3 by the root of 3."""
    rows = np.array([[0.0, 0, 0], [1, -1, 1], [2, 2, -2], [0, 3 * 3**0.5, 0]])
    assert_allclose(trust(rows, 1.0)[:, 0], [1, 1, 1 / 4, 1 / 9])


def test_what_counts_little_is_not_spread_over_its_neighbours():
    values = np.tile([1.0, -2.0, 9.8], (101, 1))
    values[50] += 20.0
    weights = np.ones((101, 1))
    assert smoothed(values, weights, 2.0)[48, 0] > 2
    weights[50] = 1e-6
    assert_allclose(smoothed(values, weights, 2.0), np.tile([1.0, -2.0, 9.8], (101, 1)), atol=1e-5)


def test_smoothing_keeps_the_density_of_white_noise():
    """Sums over many samples have the variance of raw ones; single samples have a fifth."""
    noise = np.random.default_rng(1).normal(0, 1, (20_000, 3))
    soft = smoothed(noise, np.ones((20_000, 1)), 2.0)
    sums = soft.reshape(200, 100, 3).sum(axis=1)
    assert np.var(sums) == pytest.approx(100, rel=0.15)
    # The square of a Gaussian is one that is narrower by the root of 2: 1 / (2 width sqrt(pi)).
    assert np.var(soft) == pytest.approx(1 / (4 * np.pi**0.5), rel=0.05)


def test_flexing_and_the_clock_add_to_the_variance():
    settings = FusionSettings(flexing_sd_rad=0.02, clock_sd_s=0.01)
    angles = np.outer(np.arange(50) / 100, [0.0, 3.0])
    assert_allclose(added_variance(angles, settings, 100.0, past=False)[:, 0], 0.02**2)
    assert_allclose(added_variance(angles, settings, 100.0, past=False)[:, 1], 0.02**2 + 0.03**2)
    before = added_variance(angles, settings, 100.0, past=True)[:, 1]
    assert_allclose(before, [0.02**2, *[0.02**2 + 0.03**2] * 49])
