"""Profiles of a change: what they are at both ends, how smooth they are, what they sum up to."""

import numpy as np
import pytest

from mobility_imu.simulation import profiles

U = np.linspace(-0.5, 1.5, 2001)
STEP = U[1] - U[0]


@pytest.mark.parametrize("rise", [profiles.least_jerk, profiles.smooth, profiles.cosine_ramp])
def test_rises_go_from_0_to_1_and_stay(rise):
    level = rise(U)
    assert (level[U <= 0] == 0).all() and np.allclose(level[U >= 1], 1, atol=1e-15)
    assert (np.diff(level) >= 0).all()
    assert np.allclose(level + level[::-1], 1, atol=1e-12)  # symmetric about the middle


def test_hump_and_window_rise_and_fall():
    assert profiles.hump(np.array([0.0, 0.5, 1.0, 7.0])).tolist() == [0, 1, 0, 0]
    flat = profiles.window(U, 0.0, 1.0, 0.25)
    assert (flat[(U >= 0.25) & (U <= 0.75)] == 1).all() and (flat[(U <= 0) | (U >= 1)] == 0).all()


def test_derivatives_of_the_rise_of_least_jerk_are_its_derivatives():
    """Central differences over 1e-3: their error is step²/6 times the third derivative (60)."""
    level, slope, bend = (
        shape(U, 3.0)
        for shape in (profiles.least_jerk, profiles.least_jerk_slope, profiles.least_jerk_bend)
    )
    assert np.abs(np.gradient(level, STEP) - slope).max() < 3 * 60 * STEP**2
    inside = np.abs(U - 0.5) < 0.49  # the bend has a kink at both ends
    assert np.abs(np.gradient(slope, STEP) - bend)[inside].max() < 3 * 360 * STEP**2


@pytest.mark.parametrize(
    ("rise", "order"), [(profiles.least_jerk, 2), (profiles.smooth, 3)], ids=["5th", "7th"]
)
def test_as_many_derivatives_vanish_at_the_ends_as_it_says(rise, order):
    """Near 0 the rise is a multiple of u to the power of one more than that."""
    small = np.array([1e-3, 2e-3])
    ratio = np.divide(*rise(small)[::-1])
    assert ratio == pytest.approx(2.0 ** (order + 1), rel=0.02)


def test_integral_of_the_ramp():
    summed = np.cumsum(profiles.cosine_ramp(U)) * STEP
    assert np.abs(summed - profiles.cosine_ramp_integral(U)).max() < STEP
