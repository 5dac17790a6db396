"""The study of faults put into walks: its rows add up, and the same case gives the same row."""

import numpy as np
import pytest

from mobility_imu.reproduction.recorded import numbers
from mobility_imu.reproduction.walker import faults
from mobility_imu.reproduction.walker.fault_kinds import KINDS, TILT_KINDS

RECORD = "faults_walker"


@pytest.mark.parametrize("kind", ["reversed gyroscope", "clock", "rolls", "tilts, scale"])
def test_a_case_is_the_same_each_time(kind):
    first, again = (faults.one_case(kind, 1) for _ in range(2))
    assert {key: str(value) for key, value in first.items()} == {
        key: str(value) for key, value in again.items()
    }
    assert first["ratio"] > 0 and isinstance(first["found_as"], str)


def test_rows_add_up():
    """Refusals stand apart; what does not matter counts neither for nor against."""
    row = {"kind": "lag", "case": 0, "sensor": "frame_gyr", "size": 0.1, "unit": "s", "of": "place"}
    found = {"found_as": "lag", "right": True, "cost_real": 1.0}
    rows = [
        row | found | {"ratio": 9.0, "cost_stated": 1.5},
        row | found | {"case": 1, "ratio": 9.0, "cost_stated": 3.0},
        row | {"case": 2, "ratio": 5.0, "found_as": "", "right": False, "cost_real": 1.0},
        row | {"case": 3, "ratio": 1.0, "found_as": "", "right": False, "cost_real": 0.1},
        row | {"case": 4, "ratio": float("inf"), "found_as": "refused", "right": True},
    ]
    quiet = [{"level": "real", "seed": 1, "walk": [], "tilts": ["lag frame_gyr 0.1"]}]
    made = faults.numbers_of(rows, quiet)
    (summary,) = made["kinds"]
    assert (summary["matter"], summary["right"], summary["found"]) == (3, 2, 2)
    assert (summary["priced"], summary["within_two"]) == (2, 1)
    assert (summary["refused"], summary["largest_missed"]) == (1, 5.0)
    cases = faults.table(made)
    assert cases["ratio"].tolist()[:4] == [9.0, 9.0, 5.0, 1.0] and np.isnan(cases["ratio"][4])
    assert cases["matters"].tolist() == [True, True, True, False, True]
    assert cases["found_as"].tolist() == ["lag", "lag", "", "", "refused"]
    assert made["clean"]["real"]["tilts_with_alarm"] == 1
    assert made["clean"]["real"]["walk_with_alarm"] == 0


def test_an_example_for_the_chapter():
    example = faults.example("lag", 2)
    assert len(example.clean) and len(example.faulty)
    assert example.result_clean is not None and len(example.result_faulty)


def test_the_record_has_a_hundred_of_each_kind():
    kept = numbers(RECORD)
    assert [row["kind"] for row in kept["kinds"]] == [*KINDS, *TILT_KINDS]
    assert all(row["cases"] == faults.CASES for row in kept["kinds"])
    recordings = sum(level["recordings"] for level in kept["clean"].values())
    alarms = sum(level["walk_with_alarm"] for level in kept["clean"].values())
    assert recordings >= 200 and alarms <= 0.01 * recordings
    priced, within = (sum(row[name] for row in kept["kinds"]) for name in ("priced", "within_two"))
    assert within >= 0.8 * priced > 300
    cases = faults.table(kept)
    assert len(cases) == faults.CASES * len(kept["kinds"])
    for row in kept["kinds"]:
        mine = cases[(cases["kind"] == row["kind"]) & (cases["found_as"] != "refused")]
        assert int((mine["ratio"] > faults.MATTERS).sum()) == pytest.approx(row["matter"], abs=1)
