"""Filters: what they do at the ends, and windows and data that are none."""

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.filters import median_filter, moving_average, rms, savitzky_golay

SERIES = np.random.default_rng(4).standard_normal((50, 3))
FILTERS = {
    "median": median_filter,
    "mean": moving_average,
    "polynomial": lambda values, window: savitzky_golay(values, window, 0),
}


def plain_median(values, window, pad):
    half = window // 2
    padded = np.pad(values, half, **pad)
    return np.array([np.median(padded[k : k + window]) for k in range(len(values))])


@pytest.mark.parametrize("window", [1, 3, 25, 49])
@pytest.mark.parametrize(("edge", "pad"), [("nearest", {"mode": "edge"}), ("zero", {})])
def test_the_median_is_that_of_the_window(window, edge, pad):
    found = median_filter(SERIES, window, edge=edge)
    for column, filtered in zip(SERIES.T, found.T, strict=True):
        assert filtered == pytest.approx(plain_median(column, window, pad))


@pytest.mark.parametrize("name", FILTERS)
def test_shape_is_kept_and_one_sample_changes_nothing(name):
    for values in (SERIES, SERIES[:, 0], SERIES.astype(np.float32), pd.DataFrame(SERIES)):
        assert FILTERS[name](values, 5).shape == np.shape(values)
    same = FILTERS[name](SERIES, 1)
    assert same == pytest.approx(SERIES) and not np.shares_memory(same, SERIES)
    assert FILTERS[name](SERIES, 5.0) == pytest.approx(FILTERS[name](SERIES, np.int64(5)))
    assert FILTERS[name](np.full((9, 2), 3), 5) == pytest.approx(np.full((9, 2), 3.0))


def test_a_polynomial_is_kept():
    t = np.linspace(-1, 1, 50)
    inside = savitzky_golay(t**3 - t, 9, 3)
    assert inside == pytest.approx(t**3 - t, abs=1e-12)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize(
    "window", [0, -5, 4, 51, 10**30, 2.5, np.nan, np.inf, "5", None, True, [5], 10**400]
)
def test_windows_that_are_none(name, window):
    with pytest.raises(InputError, match="window = ") as error:
        FILTERS[name](SERIES, window)
    assert len(str(error.value)) < 150


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize(
    "values", [1.0, [], np.zeros((0, 3)), np.zeros((5, 0)), np.zeros((5, 3, 3)), "abc", 1j * SERIES]
)
def test_data_that_are_none(name, values):
    with pytest.raises(InputError, match="expected"):
        FILTERS[name](values, 1)


@pytest.mark.parametrize("order", [-1, 5, 1.5, "2", None, np.nan, True, 10**30])
def test_orders_that_are_none(order):
    with pytest.raises(InputError, match="Savitzky-Golay order = "):
        savitzky_golay(SERIES, 5, order)


@pytest.mark.parametrize(("window", "order"), [(301, 150), (301, 7), (101, 9), (21, 14)])
def test_orders_whose_weights_would_be_lost_in_rounding(window, order):
    """SciPy's are off by 0.1 % and more there, and it refuses the highest orders."""
    data = np.random.default_rng(1).normal(size=2 * window)
    with pytest.raises(InputError, match=f"order = {order}: expected up to .* window of {window}"):
        savitzky_golay(data, window, order)


@pytest.mark.parametrize(("window", "order"), [(301, 5), (101, 7), (21, 12), (11, 10), (3, 2)])
def test_orders_that_a_window_takes(window, order):
    """Each window fitted by itself, in Legendre polynomials."""
    data = np.random.default_rng(1).normal(size=2 * window)
    base, _ = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1, 1, window), order))
    half = window // 2
    windows = np.lib.stride_tricks.sliding_window_view(data, window)
    expected = windows @ (base @ base[half])
    assert np.allclose(savitzky_golay(data, window, order)[half:-half], expected, atol=1e-3)


def test_a_misspelt_edge():
    with pytest.raises(InputError, match="edge = 'zeros': expected 'nearest' or 'zero'"):
        median_filter(SERIES, 3, edge="zeros")


def test_root_of_the_mean_square():
    assert rms(SERIES) == pytest.approx(np.sqrt((SERIES**2).mean()))
    assert rms(pd.Series([np.nan, 3, -3])) == 3 and type(rms([2])) is float
    for nothing in ([], [np.nan], "abc"):
        with pytest.raises(InputError, match="values: expected"):
            rms(nothing)
