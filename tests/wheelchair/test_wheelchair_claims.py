"""Wheelchair: rows of the scorecard with no sample, with the public sample, and with all."""

import math
import os
import re
from collections import Counter
from functools import partial
from pathlib import Path

import pytest

from mobility_imu.data import SAMPLE_VARIABLE, sample_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction.claims import Cell, Quotation, check
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.scorecard import reason_of
from mobility_imu.reproduction.wheelchair import claims as rows_module
from mobility_imu.reproduction.wheelchair import claims_equations
from mobility_imu.reproduction.wheelchair.claims import claims
from mobility_imu.reproduction.wheelchair.sample import (
    SAMPLE_FILES,
    TOOL_VELOCITIES,
)
from mobility_imu.reproduction.wheelchair.sample_study import cached_sample
from mobility_imu.simulation.wheelchair import IDEAL, random_mounting, simulate_drive
from mobility_imu.wheelchair import SAMPLE_CHAIR
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.tasks import find_pattern, task_steps

SAMPLE = sample_folder()
PAPERS = os.environ.get("MOBILITY_IMU_PAPERS")
CLAIMS = claims()


def verdicts(chosen):
    return Counter(outcome.verdict for outcome in map(check, chosen))


def needs_tool(claim):
    return "does not contain them" in claim.what


def test_without_the_sample_only_rows_that_need_it_have_no_number(monkeypatch):
    monkeypatch.delenv(SAMPLE_VARIABLE, raising=False)
    for outcome in map(check, CLAIMS):
        claim = outcome.claim
        if claim.needs_sample:
            assert outcome.verdict == "needs the sample"
            assert "(needs the public " in claim.what
        else:
            assert math.isnan(outcome.ours) == (outcome.verdict == "not reproducible")
            assert "needs" not in claim.what
    assert 0 < sum(claim.needs_sample for claim in CLAIMS) < len(CLAIMS) / 4


@pytest.mark.skipif(SAMPLE is None, reason=f"{SAMPLE_VARIABLE} is not set")
def test_with_the_public_sample_alone_only_the_tools_answers_are_missing(tmp_path, monkeypatch):
    for name in SAMPLE_FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).symlink_to(SAMPLE / name)
    monkeypatch.setenv(SAMPLE_VARIABLE, str(tmp_path))
    found = {claim.where: check(claim) for claim in CLAIMS if claim.needs_sample}
    assert {where for where, outcome in found.items() if math.isnan(outcome.ours)} == {
        "public tool, task labels",
        "public tool, velocity",
        "public tool, yaw rate",
        "public tool, slip",
    }
    for outcome in map(check, CLAIMS):
        if outcome.claim.needs_sample:
            assert math.isnan(outcome.ours) == needs_tool(outcome.claim)
    sign_safe = found["equations (1.16) to (1.18), our sign-safe form"]
    assert sign_safe.verdict == "agrees"
    assert found["equation (1.12)"].ours == 1.0  # an accelerometer, up is +g
    assert found["equation (1.17) as in the document"].ours == pytest.approx(-1, abs=0.01)


@pytest.mark.skipif(
    SAMPLE is None or not (SAMPLE / TOOL_VELOCITIES).is_file(),
    reason="the public tool's answers to the sample are not here",
)
def test_with_the_tools_answers_every_row_of_the_tool_agrees():
    assert verdicts(c for c in CLAIMS if needs_tool(c)) == {"agrees": 7}


def test_a_folder_that_is_not_there_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv(SAMPLE_VARIABLE, str(tmp_path / "nowhere"))
    claim = next(claim for claim in CLAIMS if claim.needs_sample)
    with pytest.raises(InputError, match="nowhere"):
        check(claim)


def test_rows_that_differ_are_those_with_a_finding(monkeypatch):
    monkeypatch.delenv(SAMPLE_VARIABLE, raising=False)
    differing = [o.claim for o in map(check, CLAIMS) if o.verdict == "differs"]
    assert Counter(claim.finding for claim in differing) == {
        "W1": 1,
        "W3": 4,
        "W4": 1,
        "W5": 1,
        "W6": 1,
        "W7": 1,
        "W8": 1,
        "W9": 1,
        "W10": 1,
    }
    assert all(claim.why is None for claim in differing)  # the kind of the finding says it
    assert {reason_of(claim) for claim in differing} == {
        "right in another reading",
        "the text contradicts itself",
        "the text leaves it open",
    }


def test_the_print_is_right_with_the_axes_of_its_figure_1():
    rows = [c for c in CLAIMS if "outward" in c.what and "equation (1.18)" not in c.where]
    assert {c.where for c in rows} == {"equations (1.8) and (1.9)", "equation (1.17)"}
    assert set(verdicts(rows)) == {"agrees"}


def test_settings_taken_from_the_print_are_marked():
    copied = [c for c in CLAIMS if c.copied]
    assert Counter(c.where.split(",")[0] for c in copied) == {
        "Table 1": 12,
        "Table 2": 14,
        "section 2.1": 1,
        "section 2.4": 1,
    }
    assert set(verdicts(copied)) == {"agrees"}
    # An agreement with our own derivation says so as well.
    derived = [c for c in CLAIMS if c.reference is not None and "derivation" in c.reference_from]
    assert len(derived) == 4
    assert all(c.reference_from.startswith("our own derivation: ") for c in derived)


def test_a_factor_rests_on_the_frames_that_turn():
    ideal = simulate_drive(
        claims_equations.TURN_BACK_AND_FORTH, SAMPLE_CHAIR, random_mounting(1), seed=1, noise=IDEAL
    )
    yaw = ideal.yaw_rate_radps
    rows = [c for c in CLAIMS if "ideal sensors" in c.what]
    assert [c.n for c in rows] == [(yaw > 0.3).sum(), (yaw < -0.3).sum()]
    assert all(f"of {len(yaw)} frames" in c.what for c in rows)


@pytest.mark.skipif(SAMPLE is None, reason=f"{SAMPLE_VARIABLE} is not set")
def test_left_turns_of_the_sample_are_counted():
    turns = cached_sample(SAMPLE)[1]["sign-safe"].yaw_rate_radps > 0.3
    rows = [c for c in CLAIMS if "the sample's left turns" in c.what]
    assert [c.n for c in rows] == [turns.sum()] * 2


# What stands under "published"


def test_every_cell_of_both_tables_has_a_row():
    cells = {
        (claim.source.table, claim.source.row, claim.source.column)
        for claim in CLAIMS
        if isinstance(claim.source, Cell)
    }
    for name, count in (("wheelchair_table1", 10), ("wheelchair_table2", 14)):
        printed = load_published(name)
        expected = {
            (name, row, column) for row, column in zip(printed.row, printed.column, strict=True)
        }
        assert {cell for cell in cells if cell[0] == name} == expected
        assert len(expected) == count


def test_a_published_number_stands_in_its_cell_or_quotation():
    published = [claim for claim in CLAIMS if claim.published]
    for claim in published:
        if isinstance(claim.source, Cell):
            cells = load_published(claim.source.table).set_index(["row", "column", "quantity"])
            text = cells.loc[claim.source[1:], "printed"]
        else:
            text = claim.source.text
        numbers = re.findall(r"-?\d+(?:\.\d+)?", text)
        assert claim.published in numbers
    assert len(published) == 15
    # The tool's answers, factors of 1 and counts of ours are references.
    assert not any("tool" in claim.where or claim.needs_sample for claim in published)


@pytest.mark.skipif(PAPERS is None, reason="MOBILITY_IMU_PAPERS does not name the papers' folder")
def test_quotations_are_found_in_the_document():
    def plain(text):
        return re.sub(r"[\u2010-\u2015]", "-", " ".join(text.split()))

    document = plain((Path(PAPERS) / "wheelmove-id-v0-calculation.txt").read_text())
    quotations = [c.source.text for c in CLAIMS if isinstance(c.source, Quotation)]
    assert len(quotations) > 10
    for text in quotations:
        assert len(text) >= 25
        assert plain(text) in document


# Rows that compare can also fail


@pytest.mark.parametrize(
    ("change", "signal"),
    [
        ({"linear_velocity_mps": 0.6}, "linear velocity"),
        ({"yaw_rate_degps": 45.0}, "abs yaw rate"),
        ({"wide_radius_m": 0.6}, "curvature radius"),
    ],
)
def test_another_threshold_than_the_printed_one_is_noticed(monkeypatch, change, signal):
    other = partial(task_steps, settings=TaskSettings(**change))
    monkeypatch.setattr(rows_module, "task_steps", other)
    rows = [claim for claim in CLAIMS if claim.where.startswith("Table 1, ")]
    differing = {o.claim.where for o in map(check, rows) if o.verdict == "differs"}
    assert any(f", {signal}, " in where for where in differing)


def test_another_task_for_the_same_letters_is_noticed(monkeypatch):
    exchanged = {1: 1, 2: 3, 3: 2, 4: 4, 5: 5, 6: 6}

    def other(symbols):
        codes = find_pattern(symbols)
        return [exchanged[int(code)] for code in codes]

    monkeypatch.setattr(rows_module, "find_pattern", other)
    rows = [claim for claim in CLAIMS if claim.where.startswith("Table 2, ")]
    differing = {o.claim.where for o in map(check, rows) if o.verdict == "differs"}
    assert differing == {"Table 2, forward, linear velocity", "Table 2, backward, linear velocity"}


def test_tolerances_that_were_set_with_the_result_known_say_so():
    said = [c for c in CLAIMS if "result known" in c.tolerance_reason]
    assert {c.tolerance for c in said} == {0.004, 0.01, 0.5}
    assert all(claim.tolerance_reason for claim in CLAIMS if claim.compute)
