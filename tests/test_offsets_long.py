"""Offsets of gyroscopes in recordings of hours."""

import tracemalloc

import numpy as np
import pytest

from mobility_imu.offsets import MOST_COMPARED, gyroscope_offset

OFFSET_RADPS = np.array([0.01, -0.02, 0.005])


def rest(blocks, *, moved=0.0, seed=900_550):
    """Readings of a rest of so many half seconds at 10 Hz, of which a fraction is a slow turn."""
    gyr = OFFSET_RADPS + 1e-3 * np.random.default_rng(seed).standard_normal((5 * blocks, 3))
    gyr[: round(moved * len(gyr))] += 0.03
    return gyr, np.ones(len(gyr), bool)


@pytest.mark.parametrize("moved", [0.0, 0.3])
def test_a_day_of_rest_needs_little_memory(moved):
    gyr, flags = rest(100_000, moved=moved)  # 14 h, and 240 GB if each were compared with each
    tracemalloc.start()
    found = gyroscope_offset(gyr, flags, 10)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 500e6
    # Noise of a mean of 350,000 samples is 2e-6; what moves is left out.
    assert np.abs(found.offset_radps - OFFSET_RADPS).max() < 2e-5


@pytest.mark.parametrize("period", [3, 4])
def test_a_motion_that_comes_again_and_again_is_left_out_of_a_long_rest(period):
    """Blocks that are evenly spaced may be those that move, each of them."""
    gyr, flags = rest(period * MOST_COMPARED)
    gyr[np.arange(len(gyr)) // 5 % period == 0] += 0.03
    found = gyroscope_offset(gyr, flags, 10)
    assert np.abs(found.offset_radps - OFFSET_RADPS).max() < 1e-4


def test_the_middle_of_many_is_that_of_all():
    """One block more than are compared, each with each: the offset is the same to its noise."""
    few = gyroscope_offset(*rest(MOST_COMPARED, moved=0.3), 10)
    gyr, flags = rest(2 * MOST_COMPARED + 1, moved=0.3)
    many = gyroscope_offset(gyr, flags, 10)
    assert few.rest_s == pytest.approx(0.35 * MOST_COMPARED, rel=1e-2)
    assert many.rest_s == pytest.approx(0.7 * MOST_COMPARED, rel=1e-2)
    assert np.abs(many.offset_radps - OFFSET_RADPS).max() < 1e-4
