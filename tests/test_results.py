"""Results: read-only, also nested and after pickling; compared by identity; one line as a repr."""

import copy
import pickle
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

from mobility_imu.results import Result, read_only


class Pair(NamedTuple):
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Inner(Result):
    values: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Outer(Result):
    time_s: np.ndarray
    inner: Inner | None = None
    parts: tuple = ()
    pair: Pair | None = None
    table: dict = field(default_factory=dict)
    rows: list = field(default_factory=list)
    sd: float = 0.0
    secret: str = field(default="", repr=False)
    warnings: tuple[str, ...] = ()


def made():
    return Outer(
        np.arange(5.0),
        Inner(np.ones((2, 3))),
        parts=(np.ones(2), (np.zeros(3),)),
        pair=Pair(np.ones(2), np.ones(2)),
        table={"a": np.ones(4), "b": [np.ones(1)]},
        rows=[np.ones(2)],
        warnings=("one",),
    )


def arrays(value):
    """Every array in a result, however deep."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, Result):
        yield from arrays(list(vars(value).values()))
    elif isinstance(value, dict):
        yield from arrays(list(value.values()))
    elif isinstance(value, list | tuple):
        for part in value:
            yield from arrays(part)


WAYS = {
    "itself": lambda result: result,
    "pickle": lambda result: pickle.loads(pickle.dumps(result)),
    "oldest pickle": lambda result: pickle.loads(pickle.dumps(result, 2)),
    "copy": copy.copy,
    "deep copy": copy.deepcopy,
    "replace": lambda result: replace(result, sd=0.0),
}


@pytest.mark.parametrize("way", WAYS)
def test_arrays_are_read_only_and_the_same(way):
    result, before = WAYS[way](made()), list(arrays(made()))
    found = list(arrays(result))
    assert len(found) == len(before) == 9
    for array, same in zip(found, before, strict=True):
        assert np.array_equal(array, same)
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 7
    assert type(result.pair) is Pair and result.warnings == ("one",)
    with pytest.raises(AttributeError):
        result.sd = 1.0


def test_no_later_change_of_the_input_reaches_a_result():
    time_s, part, table = np.arange(5.0), np.ones(2), {"a": np.ones(4)}
    view = time_s[:]
    view.setflags(write=False)  # what it looks at can be written to
    result = Outer(view, parts=(part,), table=table)
    time_s[0], part[0], table["a"][0] = 99, 99, 99
    table["b"] = np.ones(1)
    assert result.time_s[0] == 0 and result.parts[0][0] == 1
    assert result.table["a"][0] == 1 and "b" not in result.table
    time_s[1] = 3  # the input itself stays writeable


def test_what_nobody_can_write_to_is_not_copied():
    one = read_only(np.arange(5.0))
    assert read_only(one) is one and read_only(one[1:]).base is one
    assert Outer(one).time_s is one


def test_equality_is_identity():
    one, other = made(), made()
    assert one == one and one != other and one in [other, one]
    assert len({one, other, one}) == 2 and hash(one) == hash(one)


@pytest.mark.parametrize("length", [5, 10**5])
def test_a_repr_is_one_short_line(length):
    text = repr(replace(made(), time_s=np.zeros(length)))
    assert "\n" not in text and len(text) < 300
    assert f"time_s[{length}]" in text and "1 warning(s)" in text and "secret" not in text


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (np.zeros(0), "parts[0]"),
        (np.array(3.0), "parts[]"),
        (np.array([1.23456, 2]), "parts=[1.235, 2]"),
        (np.zeros((4, 3), bool), "parts[4 x 3]"),
        (list(range(9)), "parts: 9"),
        ("x" * 100, "parts: str"),
        (pd.DataFrame([1, 2]), "parts: DataFrame"),
        (1 / 3, "parts=0.333333"),
        (None, "parts=None"),
    ],
    ids=repr,
)
def test_values_in_a_repr(value, says):
    assert says in repr(Outer(np.zeros(5), parts=value))
