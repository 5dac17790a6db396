"""A fault can be undone, and what it costs is what the result changes by."""

import pickle
from functools import partial

import numpy as np
import pytest

from mobility_imu import faults
from mobility_imu.errors import InputError
from mobility_imu.faults import Cost, Fault
from mobility_imu.health import examine
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation import faults as injected


@pytest.fixture
def moving():
    time_s = np.arange(2000) / 100
    rng = np.random.default_rng(3)

    def sensor(shift):
        turn = np.sin(time_s + shift)
        acc = np.column_stack([9.81 * np.sin(turn), 0 * turn, 9.81 * np.cos(turn)])
        gyr = np.column_stack([0 * turn, -np.cos(time_s + shift), 0 * turn])
        return Imu(acc + rng.normal(0, 0.02, acc.shape), gyr + rng.normal(0, 0.002, gyr.shape))

    return Recording(time_s, {"lever": sensor(0.0), "body": sensor(1.0)}, source="ride.csv")


def rate(recording):
    return {("rate", "rad/s"): recording.gyroscope("lever")[:, 1]}


def largest_apart(first, second):
    return max(
        np.abs(first.gyroscope(name) - second.gyroscope(name)).max() for name in first.sensors
    )


def test_exchanged_sensors_and_signs_are_undone_exactly(moving):
    wrong = injected.exchange(moving, "lever", "body")
    assert largest_apart(faults.exchanged(wrong, "lever", "body"), moving) == 0
    wrong = injected.reverse(moving, "lever", (1, -1, 1))
    assert largest_apart(faults.multiplied(wrong, "lever", "gyr", (1, -1, 1)), moving) == 0


def test_a_late_sensor_comes_back_where_it_was(moving):
    wrong = injected.late(moving, "body", 0.2)
    back = faults.shifted(wrong, "body", 0.2)
    inside = slice(None, -20)
    np.testing.assert_allclose(
        back.gyroscope("body")[inside], moving.gyroscope("body")[inside], atol=1e-9
    )


def test_the_cost_of_spikes_is_their_size(moving):
    wrong = injected.spike(moving, "lever", "gyr", [300, 900], 1, 20.0)
    (found,) = faults.with_costs(examine(wrong), wrong, rate)
    assert found.code == "spike" and found.samples == 2
    assert found.size == pytest.approx(20, abs=1.1)
    (cost,) = found.costs
    assert (cost.name, cost.unit) == ("rate", "rad/s")
    assert cost.largest == pytest.approx(20, abs=0.1)
    assert found.told.endswith("; it moves the rate by up to 20 rad/s")
    assert largest_apart(faults.all_repaired([found], wrong), moving) < 0.1


def test_a_cut_range_goes_on_as_a_curve(moving):
    """The sine's top, cut at 0.8 of its height, comes back to a tenth of what was lost."""
    wrong = injected.clip(moving, "lever", "gyr", 0.8)
    (found,) = examine(wrong)
    assert found.code == "range" and found.size == pytest.approx(0.8)
    back = found.repair(wrong).gyroscope("lever")[:, 1]
    top = np.abs(moving.gyroscope("lever")[:, 1]).max()
    assert np.abs(back).max() == pytest.approx(top, abs=0.1 * (top - 0.8) + 0.02)


def test_a_cut_range_is_the_one_at_which_an_axis_stays_and_other_axes_remain_as_they_are(moving):
    rates = np.array(moving.gyroscope("lever"))
    rates[:, 1] = np.clip(rates[:, 1], -0.8, 0.8)
    flags = np.abs(rates[:, 1]) == 0.8
    at = np.flatnonzero(flags)[20]
    rates[at, 0] = 1.5
    cut = faults.with_half(moving, "lever", "gyr", rates)
    mended = faults.widened(cut, "lever", "gyr", flags).gyroscope("lever")
    np.testing.assert_array_equal(mended[:, [0, 2]], rates[:, [0, 2]])
    assert np.abs(mended[:, 1]).max() > 0.9
    (found,) = (fault for fault in examine(cut) if fault.code == "range")
    assert found.size == 0.8 and "0.8 rad/s" in found.sentence


def test_a_frozen_half_is_bridged(moving):
    wrong = injected.freeze(moving, "lever", "gyr", 5.0, 1.0)
    (found,) = examine(wrong)
    assert found.size == pytest.approx(1.0, abs=0.02)
    assert largest_apart(found.repair(wrong), moving) < largest_apart(wrong, moving)


def test_what_cannot_be_undone_or_is_refused_has_no_cost(moving):
    whole = np.ones(len(moving), bool)
    found = Fault("loose", "lever", 0.0, whole, "ride.csv: lever is loose")

    def refused(recording):
        raise InputError("no")

    assert faults.with_costs([found], moving, rate) == (found,)
    assert found.told == found.sentence and not found.costs
    undone = Fault(
        "scale", "lever", 0.0, whole, "s",
        repair=partial(faults.multiplied, sensor="lever", half="gyr", factors=0.5),
    )  # fmt: skip
    assert faults.with_costs([undone], moving, refused)[0].costs == ()
    (priced,) = faults.with_costs([undone], moving, rate)
    assert priced.costs[0].largest == pytest.approx(0.5, abs=0.01)


def test_samples_without_a_result_do_not_count():
    known = np.array([1.0, np.nan, 3.0])
    assert faults.largest_change(known, [1.5, 9.0, 3.0]) == 0.5
    assert np.isnan(faults.largest_change([np.nan], [1.0]))
    assert str(Cost("steering", 12.34, "deg")) == "the steering by up to 12 deg"


def test_faults_that_cannot_be_undone_take_no_place_among_those_that_are_priced(moving):
    whole = np.ones(len(moving), bool)
    broken = [Fault("loose", "lever", 0.0, whole, "s")] * (faults.MOST_PRICED + 1)
    half = partial(faults.multiplied, sensor="lever", half="gyr", factors=0.5)
    undone = [Fault("scale", "lever", 0.0, whole, "s", repair=half)] * (faults.MOST_PRICED + 1)
    found = faults.with_costs([*broken, *undone], moving, rate)
    assert [bool(fault.costs) for fault in found] == (
        [False] * len(broken) + [True] * faults.MOST_PRICED + [False]
    )


def test_a_fault_that_moves_nothing_has_a_cost_of_0_and_one_of_no_result_none(moving):
    whole = np.ones(len(moving), bool)
    same = partial(faults.multiplied, sensor="body", half="gyr", factors=2.0)
    fault = Fault("scale", "body", 0.0, whole, "s", repair=same)
    (priced,) = faults.with_costs([fault], moving, rate)
    assert priced.costs == (Cost("rate", 0.0, "rad/s"),) and priced.told == "s"
    (unknown,) = faults.with_costs(
        [fault], moving, lambda r: {("rate", "rad/s"): np.full(9, np.nan)}
    )
    assert unknown.costs == ()


def test_one_half_alone_is_moved_turned_or_freed_of_an_offset(moving):
    earlier = faults.shifted(moving, "body", 0.1, half="gyr")
    whole = faults.shifted(moving, "body", 0.1)
    assert (earlier.gyroscope("body") == whole.gyroscope("body")).all()
    assert (earlier.sensor("body").acc_mps2 == moving.sensor("body").acc_mps2).all()
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = faults.turned_back(injected.turn(moving, "body", quarter), "body", quarter.T)
    assert largest_apart(turned, moving) < 1e-12
    freed = injected.offset(moving, "body", "gyr", [0.1, 0.0, -0.2])
    freed = faults.without_offset(freed, "body", np.array([0.1, 0.0, -0.2]))
    assert largest_apart(freed, moving) < 1e-12
    with pytest.raises(InputError, match="half"):
        faults.half_of(moving, "body", "gry")


def test_faults_can_be_pickled(moving):
    found = examine(injected.spike(moving, "lever", "acc", [40], 0, 400.0))
    (again,) = pickle.loads(pickle.dumps(found))
    assert again.sentence == found[0].sentence
    assert again.repair(moving).sensors.keys() == moving.sensors.keys()
