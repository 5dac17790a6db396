"""Runs of flags: where they begin and end, and which are long enough."""

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobility_imu.errors import InputError
from mobility_imu.runs import changes_of, long_runs, runs_of


@given(st.lists(st.booleans(), max_size=40))
def test_runs_are_the_flags_and_lie_apart(flags):
    runs = runs_of(np.array(flags, bool))
    again = np.zeros(len(flags), bool)
    for run in runs:
        assert run.start < run.stop
        again[run] = True
    assert again.tolist() == flags
    assert all(one.stop < other.start for one, other in pairwise(runs))


@given(st.lists(st.booleans(), max_size=40), st.integers(1, 5), st.booleans())
def test_long_runs_are_those_that_are_long(flags, shortest, grow):
    kept = np.zeros(len(flags), bool)
    for run in runs_of(flags):
        if run.stop - run.start >= shortest:
            kept[max(run.start - grow, 0) : run.stop] = True
    assert long_runs(flags, shortest, grow=grow).tolist() == kept.tolist()


def test_flags_in_any_dress():
    for flags in ([0, 1, 1], [0.0, 1.0, 1.0], pd.Series([False, True, True], index=[9, 8, 7])):
        assert runs_of(flags) == [slice(1, 3)]
    assert runs_of([]) == []


@pytest.mark.parametrize("flags", [[0, 256, 1], [0, 0.5, 1], [[1, 0]], ["1"], None, 1, [np.nan]])
def test_what_is_no_flag(flags):
    for look in (runs_of, lambda f: long_runs(f, 1, grow=False)):
        with pytest.raises(InputError, match="flags: expected"):
            look(flags)


@given(st.lists(st.integers(0, 2), max_size=40))
def test_codes_stay_the_same_from_change_to_change(codes):
    starts = [*changes_of(codes), len(codes)]
    for start, stop in pairwise(starts):
        assert len(set(codes[start:stop])) == 1
        assert start == 0 or codes[start - 1] != codes[start]
    assert starts[0] == 0


def test_codes_of_any_kind():
    assert changes_of(["a", "a", "b"]).tolist() == [0, 2]
    assert changes_of(pd.Series([1, 1, 2], index=[9, 8, 7])).tolist() == [0, 2]
    for bad in (1, [[1, 2]]):
        with pytest.raises(InputError, match="codes: expected"):
            changes_of(bad)
