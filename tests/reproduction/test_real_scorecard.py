"""Independent real recordings: records, what comes of computing them again, rows, the command."""

import hashlib
import json
from typing import get_args

import numpy as np
import pytest

from mobility_imu.datasets.folders import CACHE_VARIABLE, RECORDINGS_VARIABLE, find_folder
from mobility_imu.errors import InputError
from mobility_imu.reproduction import real, real_claims, recorded
from mobility_imu.reproduction.claims import BASES, Why, check
from mobility_imu.reproduction.differences import differing
from mobility_imu.reproduction.real import REAL_SETS, RealRecord, recompute
from mobility_imu.reproduction.real_claims import REAL_BASIS, ROWS, Sides
from mobility_imu.reproduction.real_scorecard import print_real, real_records, real_scorecard
from mobility_imu.reproduction.scooter import real_hinges

HINGES = ("real_two_hinges", "real_one_hinge")
RECORDS = {name: record for name in REAL_SETS if (record := real.real_record(name)) is not None}


def test_each_set_has_rows_and_each_record_a_study():
    assert set(ROWS) == set(REAL_SETS)
    assert set(RECORDS) <= set(recorded.STUDIES)
    assert set(HINGES) <= set(RECORDS)


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_says_where_its_numbers_are_from(name):
    record = RECORDS[name]
    assert "https://" in record.origin and "licence" in record.origin
    assert record.command == f"python -m mobility_imu.reproduction.recorded {name}"
    assert record.files and all(len(sha) == 64 for sha in record.files.values())
    assert record.rows and record.summary


@pytest.mark.parametrize("name", RECORDS)
def test_rows_are_of_the_basis_and_have_a_number(name):
    rows = real_claims.real_claims(REAL_SETS[name].work)
    mine = [claim for claim in rows if claim.where == REAL_SETS[name].title]
    assert mine and all(claim.basis == REAL_BASIS in BASES for claim in mine)
    for claim in mine:
        outcome = check(claim)
        assert claim.n >= 1 and np.isfinite(outcome.ours)
        assert outcome.verdict in ("agrees", "differs") and claim.why in get_args(Why)


@pytest.mark.slow  # part by part in scooter/test_scooter_real.py
@pytest.mark.parametrize("name", HINGES)
def test_hinges_give_the_recorded_numbers_again(name):
    if find_folder(REAL_SETS[name].dataset) is None:
        pytest.skip(f"data set {REAL_SETS[name].dataset} is not here")
    found = recompute(name)
    assert found.state == "as recorded", found.message


@pytest.mark.parametrize("name", HINGES)
def test_the_simulation_stands_beside_at_both_levels(name):
    claims = real_claims.ROWS[name](name, RECORDS[name].numbers)
    errors = [claim for claim in claims if "by fusion: rms error" in claim.what]
    assert len(errors) == 2
    for claim in errors:
        assert claim.reference == claim.simulated < claim.simulated_as_real


def test_an_error_twice_as_large_as_promised_agrees_still():
    def verdict(found):
        return check(real_claims.promised("real_car", "error", "m/s", Sides(found, 1.0), 2)).verdict

    assert [verdict(v) for v in (0.1, 1.0, 2.0, 2.1)] == ["agrees"] * 3 + ["differs"]


def test_coverage_and_ratio_have_one_limit_each():
    inside = [real_claims.covered("real_car", "speed", Sides(v), 2) for v in (0.84, 0.86, 1.0)]
    assert [check(c).verdict for c in inside] == ["differs", "agrees", "agrees"]
    ratios = [real_claims.within_two("real_car", "speed", Sides(v), 2) for v in (0.5, 1.0)]
    assert [check(c).verdict for c in ratios] == ["differs", "agrees"]


def test_differences_are_named_with_their_place():
    recorded_numbers = {"rows": [{"rms": 1.0, "what": "a"}, {"rms": None}], "n": 3}
    same = {"rows": [{"rms": 1.009, "what": "a"}, {"rms": None}], "n": 3}
    assert not list(differing(same, recorded_numbers))
    other = {"rows": [{"rms": 1.02, "what": "b"}, {"rms": 2.0}], "n": 3, "more": 1}
    places = [place for place, _, _ in differing(other, recorded_numbers)]
    assert places == ["rows[0].rms", "rows[0].what", "rows[1].rms", "more"]
    assert [p for p, _, _ in differing({"rows": []}, recorded_numbers)] == ["rows", "n"]
    assert not list(differing({"v": float("nan")}, {"v": float("nan")}))
    assert list(differing({"v": True}, {"v": 1.5}))


class Fake:
    """A set with one file, its record, and a study that computes the numbers of a folder."""

    def __init__(self, folder, monkeypatch):
        self.folder, self.rows, self.further = folder, [{"trial": "a", "rms": 1.0}], {}
        (folder / "a.csv").write_text("time_s\n0\n")
        sha = hashlib.sha256((folder / "a.csv").read_bytes()).hexdigest()
        self.record = RealRecord(
            "https://somewhere at 1; licence: none stated",
            "python -m x",
            "2026-01-01",
            {"a.csv": sha},
            [{"trial": "a", "rms": 1.0}],
            {"median": 1.0},
        )
        self.sha = sha
        monkeypatch.setattr(real, "real_record", lambda name: self.record)
        monkeypatch.setattr(real, "find_folder", lambda dataset: self.folder)
        monkeypatch.setattr(real, "_study", lambda name: self.study)

    def study(self):
        numbers = {
            "files": {"a.csv": self.sha, **self.further},
            "rows": self.rows,
            "summary": {"median": float(np.median([row["rms"] for row in self.rows]))},
        }
        return {"numbers": numbers, "inputs": numbers["files"]}


@pytest.fixture
def fake(tmp_path, monkeypatch):
    return Fake(tmp_path, monkeypatch)


def test_the_same_files_and_numbers_are_as_recorded(fake):
    found = recompute("real_car")
    assert found.state == "as recorded" and found.compared == 3
    assert found.numbers["summary"] == {"median": 1.0}


def test_another_number_is_said_with_both_values(fake):
    fake.rows = [{"trial": "a", "rms": 2.0}]
    found = recompute("real_car")
    assert found.state == "differs" and "rows[0].rms = 2, recorded 1" in found.message
    assert found.numbers["summary"] == {"median": 2.0}


def test_other_files_are_said(fake):
    fake.sha = "0" * 64
    found = recompute("real_car")
    assert found.state == "other files" and "a.csv" in found.message


def test_with_further_recordings_those_of_the_record_are_compared(fake):
    fake.further = {"b.csv": "1" * 64}
    fake.rows = [{"trial": "a", "rms": 1.0}, {"trial": "b", "rms": 9.0}]
    found = recompute("real_car")
    assert found.state == "as recorded" and "1 further files" in found.message
    fake.rows[0]["rms"] = 3.0
    assert recompute("real_car").state == "differs"


def test_what_is_not_here_is_said_with_what_to_do(fake):
    fake.folder = None
    found = recompute("real_car")
    assert found.state == "not here" and "mobility-imu fetch car-wheels" in found.message
    assert found.numbers == fake.record.numbers


def test_a_folder_that_lacks_files_is_not_computed(fake):
    (fake.folder / "a.csv").unlink()
    found = recompute("real_car")
    assert found.state == "not here" and "lacks a.csv" in found.message


def test_nothing_recorded_is_said(fake):
    fake.record = None
    found = recompute("real_car")
    assert found.state == "no record" and found.numbers is None


def test_there_is_no_other_set():
    with pytest.raises(InputError, match="record = 'real_train'"):
        real.real_record("real_train")


def test_errors_of_an_angle():
    """Ten degrees off with a stated sd of five; where not valid or without a reference: ignored."""
    error = np.deg2rad([10.0, -10.0, 10.0, np.nan, 90.0])
    sd = np.deg2rad(np.full(5, 5.0))
    found = real_hinges.angle_errors(error, sd, np.array([1, 1, 1, 1, 0], bool))
    assert (found.rms_deg, found.sd_deg, found.sd_ratio, found.covered) == (10.0, 5.0, 0.5, 0.0)
    assert (found.samples, found.valid) == (4, 0.75)
    unstated = real_hinges.angle_errors(error, sd * np.nan, np.ones(5, bool))
    assert unstated.sd_deg is None and unstated.covered is None
    assert real_hinges.angle_errors(error, sd, np.zeros(5, bool)).rms_deg is None


def test_a_refused_recording_counts_against_the_method():
    row = {
        "rms_deg": 1.0,
        "sd_deg": 1.0,
        "sd_ratio": 1.0,
        "covered": 0.9,
        "samples": 9,
        "valid": 1.0,
    }
    rows = [
        {"method": "fusion", "steering": row, "throttle": row},
        {"method": "fusion", "refused": "upside down"},
    ]
    summary = real_hinges.summary_of(rows)
    assert summary["fusion"]["refused"] == 1 and summary["fusion"]["steering"]["covered"] == 0.9
    assert summary["closed-form"]["recordings"] == 0


def test_the_scorecard_of_real_recordings_without_them(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv(RECORDINGS_VARIABLE, raising=False)
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    told = []
    found = real_scorecard("scooter", progress=lambda done, of: told.append((done, of)))
    assert told == [(1, 2), (2, 2)]
    assert [one.state for one in found.sets] == ["not here", "not here"]
    records = real_records(found)
    assert json.loads(json.dumps(records)) == records
    assert [r["record"] for r in records] == list(HINGES)
    assert all(r["rows"] and r["files"] and r["origin"] for r in records)
    print_real(found)
    text = " ".join(capsys.readouterr().out.split())
    assert "mobility-imu fetch two-hinges" in text and "rows agree" in text
