"""Checks at the boundary: what is no real number, clock, flag, rotation, option or count."""

import datetime
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import (
    as_clock,
    as_count,
    as_flags,
    as_floats,
    as_number,
    as_rotation,
    as_series,
    as_vectors,
    check_positive,
    one_of,
    shown,
    wrap_angle,
)

ROWS = [[0.0, 0.0, 9.8], [1.0, 2.0, 3.0]]


def refused(check, *arguments, **options):
    with pytest.raises(InputError) as error:
        check(*arguments, **options)
    message = str(error.value)
    assert "\n" not in message and len(message) < 200
    return message


@pytest.mark.parametrize(
    "values",
    [
        ROWS,
        tuple(map(tuple, ROWS)),
        np.array(ROWS, object),
        np.array(ROWS, np.float32),
        np.array(ROWS, ">f8"),
        np.array(ROWS, np.longdouble),
        np.asfortranarray(ROWS),
        pd.DataFrame(ROWS, index=[7, 3]),
        np.ma.masked_array(ROWS),
        [[Decimal(0), Fraction(0), 9.8], [1, np.int8(2), np.float32(3)]],
    ],
    ids=lambda values: type(values).__name__,
)
def test_real_numbers_in_any_dress(values):
    found = as_vectors(values, "acc_mps2", ndim=2, length=2, finite=True)
    assert found.dtype == np.float64 and type(found) is np.ndarray
    assert found == pytest.approx(np.array(ROWS))


@pytest.mark.parametrize("kind", [np.int8, np.int16, np.uint8, np.uint64, np.float16])
def test_integers_become_floats(kind):
    largest = np.array([[np.iinfo(kind).max if kind != np.float16 else 60000, 0, 1]], kind)
    found = as_vectors(largest, "acc_mps2")
    assert found.dtype == np.float64 and np.array_equal(found, largest)


@pytest.mark.parametrize(
    "row",
    [
        ["1", "2", "3"],
        [b"1", b"2", b"3"],
        "abc",
        [1j, 0, 0],
        [True, False, True],
        [True, 2.0, 3.0],
        [None, 1, 2],
        None,
        [datetime.datetime(2026, 1, 1)] * 3,
        np.array(["2026", "2026", "2026"], "M8[s]"),
        np.array([1, 2, 3], "m8[s]"),
        np.array(["1", "2", "3"], object),
        np.array([True, 2.0, 3.0], object),
        np.array([1j, 2, 3], object),
        np.array([None, 2.0, 3.0], object),
        np.ma.masked_array([1.0, 2, 3], [1, 0, 0]),
        pd.Series([True, False, True]),
        [10**400, 1, 2],
        [[1, 2], [3]],
        {"a": 1},
        {1, 2, 3},
        range,
        np.zeros(3, [("a", float)]),
    ],
    ids=repr,
)
def test_what_is_no_real_number(row):
    for check in (as_floats, as_vectors, as_series, as_clock):
        assert "name: " in refused(check, row, "name")
    refused(wrap_angle, row)


def test_floats_are_not_copied():
    values = np.ones((4, 3))
    assert as_vectors(values, "acc_mps2") is values


@pytest.mark.parametrize("shape", [(), (0,), (2,), (3, 2), (2, 3, 4)])
def test_vectors_have_three_components(shape):
    assert "three components" in refused(as_vectors, np.zeros(shape), "acc_mps2")


@pytest.mark.parametrize("shape", [(3,), (2, 2, 3)])
def test_a_series_of_vectors_has_two_dimensions(shape):
    assert "expected shape (n, 3)" in refused(as_vectors, np.zeros(shape), "acc", ndim=2)
    assert "like the others" in refused(as_vectors, np.zeros(shape), "acc", length=2)
    assert "like the others" in refused(as_vectors, np.zeros((4, 3)), "acc", length=2)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_first_row_that_is_not_finite_is_named(value):
    values = np.zeros((5, 3))
    values[3, 1] = value
    assert "row 3" in refused(as_vectors, values, "acc", finite=True)
    assert "sample 3" in refused(as_series, values[:, 1], "speed")
    assert as_vectors(values, "acc") is values


def test_empty_arrays_are_arrays():
    assert as_vectors(np.zeros((0, 3)), "acc", ndim=2, finite=True).shape == (0, 3)
    assert as_series([], "speed").shape == (0,)
    assert as_flags([], "still", length=0).shape == (0,)


@pytest.mark.parametrize("angle", [np.pi, -np.pi, 3 * np.pi, np.nextafter(-np.pi, -4), 1e300, -0.0])
def test_wrapped_angles_lie_in_the_half_open_interval(angle):
    found = wrap_angle(angle)
    assert -np.pi <= found < np.pi
    if abs(angle) < 10:
        assert np.cos(found) == pytest.approx(np.cos(angle), abs=1e-12)


def test_an_angle_that_is_none_leaves_the_others_alone():
    assert wrap_angle([np.nan, np.inf, 4.0])[2] == pytest.approx(4 - 2 * np.pi)
    assert np.isnan(wrap_angle([np.nan, np.inf, 4.0])[:2]).all()


@pytest.mark.parametrize(
    ("clock", "says"),
    [
        ([], "0 sample(s)"),
        ([0], "1 sample(s)"),
        ([[0, 1]], "one time series"),
        ([0, 0, 1], "0 s appears twice (samples 0 and 1)"),
        ([0, 2, 1], "runs backwards at sample 2"),
        (np.array([3, 2, 5], np.uint8), "runs backwards at sample 1"),
        ([0, 1, 2, 3, 10], "gap of 7 s after 3 s"),
        ([0, 10, 11, 12, 13], "gap of 10 s after 0 s"),
        ([0, np.nan], "sample 1 is nan"),
        ([-1.7e308, 1.7e308], "are the times in s?"),
        ([0, 1e308, 1.7e308], "are the times in s?"),
        ([0, 5e-324, 1e-323], "are the times in s?"),
        ([2**62, 2**62 + 1, 2**62 + 2], "appears twice"),
        (pd.date_range("2026", periods=3), "got dates"),
        (pd.to_timedelta([1, 2, 3], unit="s"), "got time differences"),
    ],
)
def test_clocks_that_are_none(clock, says):
    assert says in refused(as_clock, clock, even=True)


def test_only_an_even_clock_has_no_gaps():
    assert as_clock([0, 1, 2, 3, 10]).tolist() == [0, 1, 2, 3, 10]
    assert as_clock([0, 1, 2, 3.4, 4.8], even=True)[-1] == 4.8
    assert "no_s:" in refused(as_clock, [0], "no_s")


@pytest.mark.parametrize(
    "flags",
    [
        [True, False, True],
        [1, 0, 1],
        [1.0, 0.0, 1.0],
        np.array([True, False, True], object),
        pd.Series([True, False, True], index=[5, 6, 7]),
        pd.array([True, False, True], dtype="boolean"),
    ],
)
def test_flags_in_any_dress(flags):
    found = as_flags(flags, "still", length=3)
    assert found.dtype == np.bool_ and found.tolist() == [True, False, True]
    assert not np.shares_memory(found, np.asarray(flags))


@pytest.mark.parametrize(
    "flags",
    [
        *([True, False], [[True], [False], [True]], None, ["0", "1", "1"], [0, 2, 1]),
        *([0, np.nan, 1], [0, 0.5, 1], [1j, 0, 1], [[1], [1, 2], 3], "101"),
        *(b"\1\0\1", bytearray(b"\1\0\1")),
        np.ma.masked_array([1, 0, 1], [0, 1, 0]),
        pd.array([True, False, None], dtype="boolean"),
        np.array([True, None, False], object),
    ],
    ids=repr,
)
def test_flags_that_are_none(flags):
    assert "still" in refused(as_flags, flags, "still", length=3)


@pytest.mark.parametrize(
    "matrix",
    [
        *(np.diag([1.0, 1, -1]), 2 * np.eye(3), np.zeros((3, 3)), np.eye(4), np.eye(3)[0]),
        *(np.full((3, 3), np.nan), 1e200 * np.eye(3), np.eye(3, dtype=bool), 1j * np.eye(3)),
        *(None, "abc", [[True, 0, 0], [0, 1, 0], [0, 0, 1]]),
    ],
    ids=repr,
)
def test_rotations_that_are_none(matrix):
    assert "mount" in refused(as_rotation, matrix, "mount")


def test_a_rotation_of_integers_is_one():
    found = as_rotation([[0, -1, 0], [1, 0, 0], [0, 0, 1]], "mount")
    assert found.dtype == np.float64 and found[1, 0] == 1


FORMS = ("corrected", "printed")


@pytest.mark.parametrize(
    "value",
    [
        *("prnted", "Printed", "", " printed", None, np.nan, 1, True, ["printed"], {}, b"printed"),
        *(np.ones(2), np.array(["printed"]), pd.DataFrame([1]), "x" * 10000, "\x1b[2J"),
    ],
    ids=lambda value: repr(value)[:20],
)
def test_a_misspelt_option_is_refused_with_the_choices(value):
    message = refused(one_of, "form", value, FORMS)
    assert message.startswith("form = ") and message.endswith("expected 'corrected' or 'printed'")
    assert message.isprintable()


def test_an_option_becomes_one_of_the_choices():
    assert type(one_of("form", np.str_("printed"), FORMS)) is str
    assert one_of("n", 2, {1: "a", 2: "b"}) == 2
    assert refused(one_of, "axis", "xy", "xyz").endswith("expected 'x', 'y' or 'z'")
    assert refused(one_of, "form", "x", ("y",)).endswith("expected 'y'")
    assert "n = True" in refused(one_of, "n", True, (1, 2))
    assert "n = 1" in refused(one_of, "n", 1, (True, False))
    assert one_of("form", None, ("a", None)) is None
    assert type(one_of("task", np.int8(3), range(1, 7))) is int
    assert one_of("on", True, (True, False)) is True


NUMBERS = (1.5, 2, np.float32(0.25), np.float16(1), np.int64(8), np.uint8(3), np.array(2.0))
HUGE = 10**400
NO_NUMBERS = (True, np.True_, np.array(True), "1", None, 1 + 0j, [1.0], np.array([2.0]), pd.NA)
NO_NUMBERS += (pd.NaT, np.datetime64("2026"), np.timedelta64(1, "s"), np.nan, HUGE, -HUGE)
NO_NUMBERS += (Fraction(10**400), pd.Series([1.0]), "x" * 10000)


@pytest.mark.parametrize("value", [*NUMBERS, Decimal("1.5"), Fraction(1, 2), 5e-324], ids=repr)
def test_positive_numbers(value):
    found = as_number(value, "noise")
    assert type(found) is float and found == float(value)


@pytest.mark.parametrize(
    "value", [*NO_NUMBERS, 0, -0.0, -1, np.inf, -np.inf], ids=lambda value: repr(value)[:20]
)
def test_what_is_no_positive_number(value):
    assert "noise = " in refused(as_number, value, "noise")


def test_zero_negative_and_infinite_numbers_where_they_are_allowed():
    assert as_number(0, "x", zero=True) == 0 and as_number(-1, "x", negative=True) == -1
    assert as_number(0, "x", negative=True) == 0
    assert as_number(np.inf, "x", infinite=True) == np.inf
    assert as_number(-np.inf, "x", infinite=True, negative=True) == -np.inf
    refused(as_number, -1, "x", zero=True)
    refused(as_number, -np.inf, "x", infinite=True)
    refused(as_number, np.nan, "x", infinite=True, negative=True)


@pytest.mark.parametrize("value", [1, np.int8(1), np.uint64(1), np.array(1)], ids=repr)
def test_whole_numbers(value):
    found = as_count(value, "window")
    assert type(found) is int and found == 1


@pytest.mark.parametrize(
    "value",
    [*(v for v in NO_NUMBERS if v is not HUGE), 0, -1, 1.0, 1.5, np.inf],
    ids=lambda value: repr(value)[:20],
)
def test_what_is_no_whole_number(value):
    assert "window = " in refused(as_count, value, "window")


def test_the_least_count_can_be_another():
    assert as_count(0, "x", least=0) == 0
    assert as_count(10**30, "seed") == 10**30
    for least in (3, np.int64(3), np.uint8(3)):
        assert "x = 2: expected a whole number of 3 or more" in refused(
            as_count, 2, "x", least=least
        )
        assert as_count(3, "x", least=least) == 3
    for least in (True, 1.0, np.timedelta64(1), "1", None):
        assert "least = " in refused(as_count, 2, "x", least=least)


@dataclass(frozen=True)
class Noise:
    acc: float = 1.0
    gyr: float = 1.0

    def __post_init__(self):
        check_positive(self, allow_zero=("gyr",))


def test_settings_become_floats_or_name_class_and_field():
    made = Noise(np.float32(2), 0)
    assert type(made.acc) is type(made.gyr) is float
    for bad in ("1", True, 0, -1, np.nan, np.inf, None):
        assert refused(Noise, bad).startswith("Noise.acc = ")
    assert refused(Noise, 1, -1).startswith("Noise.gyr = ")


def test_values_are_shown_short_and_in_one_line():
    for value in ("x" * 10**6, np.zeros((100, 3)), pd.DataFrame([1, 2]), 16**5000, list(range(99))):
        assert len(shown(value)) <= 63 and "\n" not in shown(value)
    assert shown(np.float64(0.5)) == "0.5"


def test_a_rotation_matrix_that_was_rounded_is_refused_with_what_to_do():
    """Of all matrices with three decimals a fifth miss an orthogonal one by more than allowed."""
    exact = Rotation.random(200, random_state=1).as_matrix()
    for matrix in exact.round(2):
        assert refused(as_rotation, matrix, "mount").endswith("Write six digits")
    few = [m for m in exact.round(3) if abs(m @ m.T - np.eye(3)).max() > 1e-3]
    assert len(few) > 20
    for matrix in few:
        assert refused(as_rotation, matrix, "mount").endswith("Write six digits")
    for matrix in exact.round(6):
        as_rotation(matrix, "mount")
    assert "digits" not in refused(as_rotation, 1.1 * np.eye(3), "mount")
