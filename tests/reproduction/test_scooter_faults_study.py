"""The record of faults put into simulated rides: what it keeps, and what it holds."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from mobility_imu.data import recorded_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction import recorded
from mobility_imu.reproduction.scooter import fault_cases as cases
from mobility_imu.reproduction.scooter import faults as study
from mobility_imu.scooter.faults import find_faults
from mobility_imu.scooter.geometry import SUZUKI_ET4D


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


COUNTED = ("refused", "matter", "told", "right", "priced", "within_two", "unpriced")


def test_the_summary_is_that_of_the_rows(numbers, table):
    again = study.summary(table).reset_index().to_dict("records")
    for found, kept in zip(again, numbers["summary"], strict=True):
        # Cells have three digits: a cost at the edge of a factor of two may fall to the other side.
        assert list(found) == list(kept) == ["kind", "cases", *COUNTED]
        assert [found[key] for key in COUNTED] == pytest.approx(
            [kept[key] for key in COUNTED], abs=1
        )
        assert (found["kind"], found["cases"]) == (kept["kind"], kept["cases"])


def test_how_many_are_told_and_how_well_they_are_priced(table):
    """Floors three standard deviations (of a fraction of as many cases) below the record.

    The aim of the study is 98 % told or refused; its page says which faults are missed.
    """
    found = study.summary(table)
    total = found.sum()
    assert total["matter"] > 650
    assert total["told"] >= 0.96 * total["matter"]
    assert total["refused"] + total["told"] >= 0.98 * (total["refused"] + total["matter"])
    assert total["right"] >= 0.93 * total["matter"]
    assert total["within_two"] >= 0.94 * total["priced"]
    # The worst kind: turns within what a mount leaves uncertain.
    part = found["told"] / found["matter"]
    rough = ["turned since the calibration", "clock"]
    assert part.drop(rough).min() >= 0.85
    assert part["turned since the calibration"] >= 0.85
    right = found["right"] / found["matter"]
    assert right.drop(rough).min() >= 0.7
    assert right["turned since the calibration"] >= 0.6
    near = found["within_two"] / found["priced"]
    assert near["turned since the calibration"] >= 0.6


def test_an_axis_that_hardly_turns_is_not_called_reversed():
    """Real sensors in many curves: the body's rate about x is mostly noise, and moves no angle."""
    assert study.clean_row(212, study.SEEN_CLEAN_SEED)["told"] == []


LARGEST_ACCUSED, AIM = 0.03, 0.01
"""Part of sound rides of which something may be told, and that which is wanted."""


def test_how_often_a_sound_ride_is_accused(numbers):
    clean = numbers["clean"]
    assert len(clean["told"]) <= LARGEST_ACCUSED * sum(clean["rides"].values())


def test_so_many_sound_rides_tell_the_aim_from_twice_the_limit():
    """Number of accused rides is binomial: as wanted, it passes but once in 100 records."""
    most = int(LARGEST_ACCUSED * study.CLEAN_RIDES)
    assert stats.binom.sf(most, study.CLEAN_RIDES, AIM) < 0.01
    assert stats.binom.cdf(most, study.CLEAN_RIDES, 2 * LARGEST_ACCUSED) < 0.05


def test_later_kinds_leave_the_cases_of_the_others_alone(table):
    """A kind's number is a part of its seed: all are as the record has them."""
    assert sorted(cases.DRAWN_BY.values()) == list(range(len(cases.KINDS) + 1))
    assert (cases.DRAWN_BY["clock"], cases.DRAWN_BY[cases.POSES]) == (12, 13)
    ride = cases.ride_of(3)
    for kind in ("frozen", "spikes", "clock"):
        rng = np.random.default_rng([cases.SEED, cases.DRAWN_BY[kind], 3])
        case = cases.KINDS[kind].draw(ride.recording, rng)
        row = table[table["kind"] == kind].iloc[3 * cases.cases_of(kind, 3)]
        assert (case.sensor, case.size) == (row["sensor"], pytest.approx(row["size"], rel=0.01))


@pytest.mark.parametrize("number", [0, 1])
def test_exchanged_halves_are_told_as_those(number):
    """Of both sensors one half, and each time another part of the ride."""
    ride, kind = cases.ride_of(number, 502_000), cases.KINDS["exchanged halves"]
    rng = np.random.default_rng([502_000, number])
    drawn = [kind.draw(ride.recording, rng) for _ in range(4)]
    assert len({case.sensor for case in drawn}) == 2
    for case in drawn:
        faulty = case.faulty()
        first, last = faulty.time_s[[0, -1]]
        part = ride.recording.trim(first - 1e-6, last + 1e-6)
        for half, values in (("acc", "acc_mps2"), ("gyr", "gyr_radps")):
            of = {"lever": "body", "body": "lever"} if half in case.sensor else {}
            for name in ("lever", "body"):
                right = getattr(part.sensor(of.get(name, name)), values)
                assert np.array_equal(getattr(faulty.sensor(name), values), right)
    (found,) = find_faults(drawn[0].faulty(), SUZUKI_ET4D, ride.mount, cases.FUSION)
    assert (found.code, found.sensor) == ("exchanged", drawn[0].sensor)


def test_counts_add_up():
    """Refusals stand apart; what does not matter counts neither for nor against."""
    nan = float("nan")
    case = ["lag", "real", "lever", 0.1, "s"]
    rows = [
        [*case, 9.0, "lag", 1, 1.5, 1.0, 0.2, 0.1],
        [*case, 9.0, "lag", 1, 3.0, 1.0, 0.1, 0.1],
        [*case, 9.0, "at odds", 0, nan, 1.0, nan, 0.1],
        [*case, 5.0, "", 0, nan, 1.0, nan, 0.1],
        [*case, 1.0, "lag", 1, 1.0, 0.1, 0.1, 0.1],
        [*case, float("inf"), "refused", 1, nan, nan, nan, nan],
    ]
    (found,) = study.summary(study.table_of(rows)).reset_index().to_dict("records")
    assert found == {
        "kind": "lag", "cases": 6, "refused": 1, "matter": 4, "told": 3, "right": 2,
        "priced": 2, "within_two": 1, "unpriced": 1,
    }  # fmt: skip


def test_whole_turns_are_no_change():
    found = cases.ride_of(0).found
    turned = replace(found, steering_rad=found.steering_rad + 2 * np.pi)
    moved, sds = study._moved(turned, found)
    assert moved == pytest.approx([0, 0], abs=1e-6) and sds == pytest.approx(0, abs=1e-6)


def test_one_row_is_found_again(table):
    """The first lag of the first ride, computed here."""
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
