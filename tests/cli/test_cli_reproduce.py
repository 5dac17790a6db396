"""The scorecard on the command line."""

import json

import pytest

from mobility_imu.reproduction import scorecard as computed


@pytest.fixture
def once(monkeypatch):
    """What the commands of a test compute is computed by the first of them."""
    kept, compute = {}, computed.scorecard

    def scorecard(work=None, **options):
        if work not in kept:
            kept[work] = compute(work, **options)
        return kept[work]

    monkeypatch.setattr(computed, "scorecard", scorecard)


@pytest.mark.usefixtures("once")
def test_reproduce_on_the_terminal_and_as_json(works):
    table = works("reproduce", "--work", "walker")
    assert "9.6525" in table.stdout and "differs" in table.stdout
    records = json.loads(works("reproduce", "--work", "walker", "--json").stdout)
    wrong = {r["where"] for r in records if r["verdict"] == "differs"}
    # Which ones differ is held by test_walker_audit.py; here, that the command says the same.
    outcomes = computed.scorecard("walker")
    assert wrong == {o.claim.where for o in outcomes if o.verdict == "differs"}
    for record in records:
        assert (record["tolerance"] is None) == (record["tolerance_reason"] is None)


def test_reproduce_real_without_the_recordings(tmp_path, works, fails, monkeypatch):
    monkeypatch.delenv("MOBILITY_IMU_RECORDINGS", raising=False)
    monkeypatch.setenv("MOBILITY_IMU_CACHE", str(tmp_path / "cache"))
    told = works("reproduce", "--real", "--work", "scooter").stdout
    assert sum(line.startswith("not here: ") for line in told.splitlines()) == 2
    sets = json.loads(works("reproduce", "--real", "--json").stdout)
    assert {one["state"] for one in sets} <= {"not here", "no record"}
    monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "nowhere"))
    fails("reproduce", "--real", says=["MOBILITY_IMU_RECORDINGS", "no such folder"])


def test_rows_of_real_recordings_are_in_the_whole_scorecard(works):
    rows = json.loads(works("reproduce", "--work", "scooter", "--json").stdout)
    real = [row for row in rows if row["basis"] == "tried on independent real recordings"]
    assert real and all(row["n"] >= 1 for row in real)
    assert any(row["simulated"] is not None for row in real)
