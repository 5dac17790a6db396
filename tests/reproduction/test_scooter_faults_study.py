"""The record of faults put into simulated rides: what it keeps, and what it must hold."""

import json

import numpy as np
import pytest

from mobility_imu.data import recorded_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction import recorded
from mobility_imu.reproduction.scooter import fault_cases as cases
from mobility_imu.reproduction.scooter import faults as study


@pytest.fixture(scope="module")
def numbers():
    return recorded.numbers("faults_scooter")


@pytest.fixture(scope="module")
def table(numbers):
    return study.recorded_table(numbers)


def test_the_record_is_small_and_names_no_place(numbers):
    assert (recorded_folder() / "faults_scooter.json").stat().st_size < 150_000
    assert "/work" not in json.dumps(numbers)


def test_each_kind_has_a_hundred_cases(table):
    assert table["kind"].value_counts().to_dict() == dict.fromkeys(
        [*cases.KINDS, "poses"], cases.CASES
    )
    assert numbers_of_clean(recorded.numbers("faults_scooter")) == study.CLEAN_RIDES


def numbers_of_clean(numbers):
    return sum(numbers["clean"]["rides"].values())


def test_the_summary_is_that_of_the_rows(numbers, table):
    again = study.summary(table).reset_index().to_dict("records")
    for found, kept in zip(again, numbers["summary"], strict=True):
        # Cells have three digits: a cost at the edge of a factor of two may fall to the other side.
        assert found.pop("within_two") == pytest.approx(kept.pop("within_two"), abs=1)
        assert found.pop("matter") == pytest.approx(kept.pop("matter"), abs=1)
        assert found.pop("told") == pytest.approx(kept.pop("told"), abs=1)
        assert found.pop("rightly") == pytest.approx(kept.pop("rightly"), abs=1)
        assert found == kept


def test_one_row_is_found_again(table):
    """The first lag of the first ride, computed here; of an older record, another ride's."""
    if recorded.is_stale("faults_scooter"):
        pytest.skip("the record is older than the code")
    first = cases.ride_of(0)
    place = list(cases.KINDS).index("lag")
    kind = cases.KINDS["lag"]
    case = kind.draw(first.recording, np.random.default_rng([cases.SEED, place, 0]))
    moved_sds, code, *_ = study.told_of(case, first, kind.codes)
    row = table[table["kind"] == "lag"].iloc[0]
    assert case.size == pytest.approx(row["size"], rel=0.01)
    assert code == row["found_as"]
    assert moved_sds == pytest.approx(row["moved_sds"], rel=0.05)


@pytest.mark.parametrize("kind", study.EXAMPLES)
def test_the_examples_are_told_by_their_kind(kind):
    found = study.example(kind)
    codes = cases.KINDS[kind].codes
    assert found.faults[0].code in codes and found.faults[0].costs
    assert len(found.clean) == len(found.result_clean.time_s) == len(found.faulty)
    assert not np.array_equal(found.result_clean.steering_rad, found.result_faulty.steering_rad)


def test_an_example_that_there_is_not():
    with pytest.raises(InputError, match="expected one of lag"):
        study.example("rust")
