"""Sensors that repeat themselves, and sensors at the end of their range."""

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.quality import frozen_samples, saturated_samples


def noise(count=600, axes=3):
    return np.random.default_rng(3).standard_normal((count, axes))


def test_a_sensor_that_works_is_neither():
    assert not frozen_samples(noise(), 100).any() and not saturated_samples(noise()).any()


def test_a_sensor_that_repeats_itself():
    stuck = noise()
    stuck[200:260] = stuck[200]
    assert np.nonzero(frozen_samples(stuck, 100))[0].tolist() == list(range(200, 260))
    short = noise()
    short[200:220] = short[200]  # a fifth of a second
    assert not frozen_samples(short, 100).any()
    one_axis = noise()
    one_axis[200:260, 0] = 0
    assert not frozen_samples(one_axis, 100).any()


def test_from_the_first_sample_on():
    assert frozen_samples(np.ones((600, 3)), 100).all()


@pytest.mark.parametrize("kind", [float, np.float32, np.int16])
def test_the_end_of_a_range_at_either_side(kind):
    """Of int16 the most negative number has no absolute value."""
    acc = np.round(1000 * noise()).astype(kind)
    acc[100:105, 1] = -32768
    acc[300:302, 1] = -32768  # two samples may be a blow
    assert np.nonzero(saturated_samples(acc))[0].tolist() == list(range(100, 105))
    assert saturated_samples(acc, run=2).sum() == 7


def test_nothing_is_neither():
    assert frozen_samples(np.zeros((0, 3)), 100).shape == (0,)
    assert saturated_samples(np.zeros((0, 3))).shape == (0,)
    assert frozen_samples(np.zeros((1, 3)), 100).tolist() == [False]
    assert saturated_samples(np.zeros((1, 3))).tolist() == [False]


@pytest.mark.parametrize("values", [[1, 2, 3], 1.0, None, "abc", np.zeros((5, 0)), 1j * noise()])
def test_what_is_no_series(values):
    for look in (saturated_samples, lambda v: frozen_samples(v, 100)):
        with pytest.raises(InputError, match="values: expected"):
            look(values)


@pytest.mark.parametrize("rate", [0, -100, np.nan, np.inf, "100", None, True])
def test_rates_and_counts_that_are_none(rate):
    with pytest.raises(InputError, match="sampling_rate_hz = "):
        frozen_samples(noise(), rate)
    with pytest.raises(InputError, match="run = "):
        saturated_samples(noise(), run=rate)
