"""What holds for the rows of all three works, and how they are judged and counted."""

import math

import pytest

from mobility_imu.errors import InputError
from mobility_imu.reproduction import scorecard
from mobility_imu.reproduction.claims import Claim, Outcome, share_rule
from mobility_imu.reproduction.findings import findings

USUAL = {
    "work": "walker",
    "where": "here",
    "what": "a number",
    "unit": "1",
    "basis": "computed on simulated data",
    "reference": 1.0,
    "reference_from": "this test",
    "tolerance_reason": "none",
    "compute": lambda: 1.0,
}


def claim(**given):
    return Claim(**(USUAL | given))


def test_work_place_and_quantity_name_one_row():
    names = [(c.work, c.where, c.what) for c in scorecard.all_claims()]
    assert len(set(names)) == len(names)


def test_findings_of_rows_exist_and_are_of_the_same_work():
    known = {(f.work, f.id) for f in findings()}
    assert {(c.work, c.finding) for c in scorecard.all_claims() if c.finding} <= known


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({}, "our assumptions do not explain it"),
        ({"finding": "K6"}, "the text contradicts itself"),
        ({"finding": "K4"}, "the text is not right"),
        (
            {"finding": "K6", "why": "our assumptions do not explain it"},
            "our assumptions do not explain it",
        ),
    ],
)
def test_a_reason_that_is_given_comes_before_the_kind_of_the_finding(given, why):
    assert scorecard.reason_of(claim(**given)) == why


def test_a_bound_has_one_side():
    below, above = claim(bound="below"), claim(bound="above")
    values = (0.1, 0.999, 1.0, 1.001, 9.0)
    assert [Outcome(below, v).verdict == "agrees" for v in values] == [1, 1, 0, 0, 0]
    assert [Outcome(above, v).verdict == "agrees" for v in values] == [0, 0, 0, 1, 1]
    with pytest.raises(InputError, match="bound"):
        claim(bound="below", tolerance=0.1)


@pytest.mark.parametrize(("cases", "least"), [(5, 5), (10, 9), (20, 15), (100, 59)])
def test_a_share_holds_where_a_coin_hardly_reaches_it(cases, least):
    rule = share_rule(cases)
    judged = claim(**rule)
    assert Outcome(judged, least / cases).verdict == "agrees"
    assert Outcome(judged, (least - 1) / cases).verdict == "differs"
    tail = sum(math.comb(cases, k) for k in range(least, cases + 1)) / 2**cases
    assert tail < 0.05 < tail + math.comb(cases, least - 1) / 2**cases
    assert f"({100 * tail:.1f} %" in rule["tolerance_reason"]


def test_too_few_cases_judge_no_share():
    with pytest.raises(InputError, match="coin"):
        share_rule(4)


def test_what_a_trivial_model_meets_and_what_we_copied_is_counted_apart():
    outcomes = [
        Outcome(claim(experiment=True, trivial=1.0), 1.0),
        Outcome(claim(experiment=True, trivial=1.0), 2.0),
        Outcome(claim(experiment=True, trivial=3.0), 1.0),
        Outcome(claim(copied=True), 1.0),
        Outcome(claim(copied=True), 2.0),
    ]
    assert scorecard.simulated_experiments(outcomes) == (2, 1, 3)
    counted = scorecard.totals(outcomes).loc[("walker", "computed on simulated data")]
    assert counted[["agrees", "differs", "trivial too", "settings copied"]].tolist() == [3, 2, 1, 1]
    records = scorecard.to_records(outcomes)
    assert [r["copied"] for r in records] == [False] * 3 + [True] * 2


def test_the_command_says_what_its_totals_count(capsys):
    outcomes = [Outcome(claim(experiment=True, trivial=1.0, copied=True), 1.0)]
    scorecard.print_scorecard(outcomes, everything=True)
    told = " ".join(capsys.readouterr().out.split())
    assert scorecard.NO_RECORDING in told
    assert "1 of 1 agree; a trivial model meets 1 of those that agree" in told
    assert "settings copied" in told and "a setting taken from the text" in told
