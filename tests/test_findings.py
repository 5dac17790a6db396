"""Findings about the three works: quoted word for word, of a kind, and borne out by a check."""

import ast
import functools
import inspect
import os
import re
from pathlib import Path

import pytest

from mobility_imu.reproduction.claims import Cell, Quotation
from mobility_imu.reproduction.findings import KINDS, Evidence, counts, findings, quoted
from mobility_imu.reproduction.published import load_published, published_names
from mobility_imu.reproduction.scorecard import WORKS, all_claims

ROOT = Path(__file__).resolve().parents[1]
FILES = {"scooter": "suzurikawa", "wheelchair": "wheelmove", "walker": "doan"}
TABLES = {work: [name for name in published_names() if name.startswith(work)] for work in FILES}
DASHES = dict.fromkeys(map(ord, "‐‑–−"), "-")
PAPERS = os.environ.get("MOBILITY_IMU_PAPERS")
needs_papers = pytest.mark.skipif(not PAPERS, reason="MOBILITY_IMU_PAPERS is not set")


def normalised(text):
    """White space away, all dashes alike, so that line breaks and typography do not matter."""
    return re.sub(r"\s+", "", text.translate(DASHES))


@pytest.fixture(scope="module")
def papers():
    return {
        work: [normalised(p.read_text()) for p in Path(PAPERS).glob(f"{start}*.txt")]
        for work, start in FILES.items()
    }


def test_findings_are_numbered_without_a_gap_and_have_a_known_kind():
    letters = {"scooter": "S", "wheelchair": "W", "walker": "K"}
    for work, letter in letters.items():
        ids = [f.id for f in findings(work)]
        assert ids == [f"{letter}{k}" for k in range(1, len(ids) + 1)]
    assert {f.kind for f in findings()} <= set(KINDS)
    assert sum(sum(kinds.values()) for kinds in counts().values()) == len(findings())


@functools.cache
def evidence_of(identity):
    """Numbers of a finding's check, computed once."""
    (finding,) = (f for f in findings() if f.id == identity)
    return finding.evidence()


@pytest.mark.parametrize("finding", findings(), ids=lambda f: f.id)
def test_every_finding_is_borne_out_and_its_opposite_is_not(finding):
    evidence = evidence_of(finding.id)
    assert evidence
    for item in evidence:
        assert item.holds(), item
        assert not item.inverted().holds(), item


@pytest.mark.parametrize("finding", findings(), ids=lambda f: f.id)
def test_every_finding_says_all_that_a_reader_needs(finding):
    for field in ("title", "place", "reading", "verdict", "settles", "consequence"):
        assert len(getattr(finding, field)) >= 5, field
    assert finding.quotation and finding.chapters
    for chapter in finding.chapters:
        text = (ROOT / f"{chapter}.ipynb").read_text()
        assert f"finding-{finding.id.lower()}>" in text, f"{chapter} does not refer to {finding.id}"


@pytest.mark.parametrize("finding", findings(), ids=lambda f: f.id)
def test_no_check_is_made_of_written_numbers_only(finding):
    """A number of a check comes from the package, a printed table or a quotation."""
    tree = ast.parse(inspect.getsource(finding.function()))
    calls = {
        node.func.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert calls - {"Evidence", "float", "round", "abs", "max", "min", "sum", "tuple", "len"}


def test_evidence_tells_right_from_wrong():
    known = Evidence("x", "print", 2.0, "right", 1.0, truth=1.0, tolerance=0.1)
    assert known.holds() and not known.inverted().holds()
    assert not known._replace(second=1.2).holds()  # the correction must hit the truth
    assert not known._replace(first=1.05).holds()  # and the print must miss it
    open_question = Evidence("x", "one", 2.0, "other", 1.0, tolerance=0.5)
    assert open_question.holds() and not open_question._replace(second=1.6).holds()


def test_numbers_in_quotations_are_found_or_refused():
    assert quoted("S1", r"and ([0-9.]+)% of the movable") == 11.3
    with pytest.raises(Exception, match="S1"):
        quoted("S1", r"and ([0-9.]+) elephants")


@needs_papers
@pytest.mark.parametrize("finding", findings(), ids=lambda f: f.id)
def test_quotations_are_word_for_word(finding, papers):
    for passage in finding.quotation:
        assert any(normalised(passage) in text for text in papers[finding.work]), passage


def test_published_numbers_have_a_cell_or_a_sentence_that_prints_them():
    tables = {}
    for claim in all_claims():
        if not claim.published:
            continue
        where = f"{claim.work}, {claim.where}, {claim.what}"
        if isinstance(claim.source, Cell):
            name, *key = claim.source
            if name not in tables:
                tables[name] = load_published(name).set_index(["row", "column", "quantity"])
            text = tables[name].loc[tuple(key), "printed"]
        else:
            assert isinstance(claim.source, Quotation), where
            assert len(claim.source.text) >= 25, where
            text = claim.source.text
        number = re.escape(normalised(claim.published))
        # The number by itself: not a part of a longer one. A minus belongs to it.
        assert re.search(rf"(?<![\d.]){number}(?!\d|\.\d)", normalised(text)), where


@needs_papers
@pytest.mark.parametrize("work", WORKS)
def test_sentences_of_claims_are_word_for_word(work, papers):
    for claim in all_claims(work):
        if isinstance(claim.source, Quotation):
            assert any(normalised(claim.source.text) in text for text in papers[work]), claim.where


# Numbers of a verdict that no check gives: limits and ranges that the works or their tools state,
# and results that the named chapter asserts.
STATED = {
    "S1": {"4.5", "5", "44"},
    "S2": {"20"},
    "S3": {"7", "20", "50"},
    "S4": {"0.05", "0.24", "5"},
    "S8": {"100", "28", "5", "6"},
    "W3": {"1", "0.3"},
    "W9": {"19"},
    "W12": {"10", "30", "0.30", "100", "1.5"},
    "K4": {"0.01"},
    "K7": {"1", "3"},
    "K18": {"10"},
    "K19": {"3", "1.5", "1.7"},
}


def numbers_of(text):
    """Numbers in prose; those of equations, tables and names are left out."""
    plain = re.sub(
        r"\$[^$]*\$|\([0-9.]+\)|\bpose \d|\b[A-Z]\d+|row \d|cell \d-\w|step \d", " ", text
    )
    return re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.]*\d)", plain)


@functools.cache
def printed(work):
    """Every cell of a work's tables as it is in the print."""
    return set().union(*(set(load_published(name)["printed"]) for name in TABLES[work]))


@pytest.mark.parametrize("finding", findings(), ids=lambda f: f.id)
def test_numbers_of_a_verdict_are_those_of_its_check(finding):
    evidence = evidence_of(finding.id)
    known = [abs(x) for e in evidence for x in (e.first, e.second, e.truth) if x == x]
    cells = printed(finding.work)
    told = " ".join(finding.quotation) + " ".join(
        f"{e.what} {e.first_from} {e.second_from}" for e in evidence
    )
    for number in numbers_of(finding.verdict):
        digits = len(number.partition(".")[2])
        near = any(abs(round(value, digits) - float(number)) < 1e-9 for value in known)
        assert (
            near
            or number in cells
            or number in STATED.get(finding.id, ())
            or re.search(rf"(?<![\d.]){re.escape(number)}(?!\d)", told)
        ), f"{finding.id}: {number} in its verdict comes from nowhere"
