"""Headline numbers at the level of real sensors: record, rows, and the sentence beside each."""

import math

import numpy as np
import pytest

from mobility_imu.reproduction import real_level, real_level_claims, recorded
from mobility_imu.reproduction.claims import check
from mobility_imu.reproduction.real_level_claims import HEADLINES, at_levels, what_changes
from mobility_imu.reproduction.scorecard import WORKS, all_claims

RECORD = recorded.numbers("level_real")


@pytest.mark.parametrize("work", WORKS)
def test_the_record_has_every_headline_at_both_levels(work):
    mine = [one.key for one in HEADLINES if one.work == work]
    assert mine and len(set(mine)) == len(mine)
    for level in real_level.LEVEL_NAMES:
        assert set(mine) <= set(RECORD[work][level])
        assert all(math.isfinite(value) for value in RECORD[work][level].values())


@pytest.mark.parametrize(
    ("name", "compute"), [("court", real_level.court_row), ("frame", real_level.frame_row)]
)
def test_the_first_one_comes_out_as_recorded(name, compute):
    found = compute(0, "real")
    assert found.keys() == RECORD["first"][name].keys()
    for key, value in found.items():
        assert value == pytest.approx(RECORD["first"][name][key], rel=0.01, abs=1e-3), key


def test_the_walkers_intervals_hold_on_real_sensors_unless_they_are_called_calibrated():
    """95 % are stated; creep of the tips is not in the deviations."""
    found = RECORD["walker"]["real"]
    for name in ("mount", "rectangle_end"):
        assert found[f"{name}_covered"] > max(found[f"{name}_covered_if_calibrated"], 0.9)
    assert found["corridor_end_covered_if_calibrated"] < found["corridor_end_covered"] < 0.95


def test_levels_differ_by_the_sensors_alone():
    one, other = (
        real_level.random_court(3, slips=0).drive(model)
        for model in real_level.CHAIR_SENSORS.values()
    )
    assert np.array_equal(one.linear_velocity_mps, other.linear_velocity_mps)
    usual, real = real_level.FRAMES.values()
    assert usual.imperfections == real.imperfections and usual.sensor != real.sensor


@pytest.mark.parametrize("headline", HEADLINES, ids=lambda h: f"{h.work}, {h.what}")
def test_the_sentence_says_what_the_row_finds(headline):
    (claim,) = (
        claim
        for claim in real_level_claims.level_claims(headline.work)
        if claim.what == headline.what and headline.chapter in claim.where
    )
    usual, real = at_levels(headline)
    assert (claim.simulated, claim.simulated_as_real) == (usual, real) and claim.n >= 10
    outcome = check(claim)
    assert outcome.ours == real
    assert (outcome.verdict == "differs") == ("does not hold" in what_changes(headline))


def test_the_rows_are_on_the_scorecard_and_none_counts_as_an_experiment():
    rows = [claim for claim in all_claims() if claim.where.startswith("sensors as real ones")]
    assert len(rows) == len(HEADLINES) == len(real_level_claims.level_table())
    assert not any(claim.experiment for claim in rows)
