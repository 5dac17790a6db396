"""The walker's claims: what is printed, what differs, and the record behind the simulated ones."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest

from mobility_imu.reproduction.claims import Cell, check
from mobility_imu.reproduction.scorecard import reason_of
from mobility_imu.reproduction.walker.claims import claims
from mobility_imu.reproduction.walker.studies import (
    LEVELS,
    PAPERS_WAY,
    calibration_study,
    walking_study,
)
from mobility_imu.reproduction.walker.tables import pose_translation
from mobility_imu.reproduction.walker.walks import COURSES
from mobility_imu.reproduction.walker.walks_record import recorded_row, walk_record
from mobility_imu.simulation.walker import CORRIDOR

REALISTIC = {"realistic": LEVELS["realistic"]}


@pytest.fixture(scope="module")
def outcomes():
    return [check(claim) for claim in claims()]


@pytest.fixture(scope="module")
def first_mounts():
    return calibration_study([0], REALISTIC, variants=PAPERS_WAY, poses=["1"])


def test_every_place_and_quantity_stands_once(outcomes):
    rows = [(o.claim.where, o.claim.what) for o in outcomes]
    assert len(set(rows)) == len(rows)


def test_every_printed_average_error_and_length_is_held_against_its_rows(outcomes):
    """60 averages, 30 distance errors, 60 lengths; each has its own cell."""
    cells = [
        o.claim.source
        for o in outcomes
        if isinstance(o.claim.source, Cell) and o.claim.basis == "published numbers recomputed"
    ]
    assert len(set(cells)) == len(cells) == 60 + 30 + 60


def test_printed_numbers_that_do_not_recompute_are_the_known_ones(outcomes):
    differ = {
        (o.claim.where, o.claim.finding)
        for o in outcomes
        if o.verdict == "differs" and o.claim.basis == "published numbers recomputed"
    }
    assert differ == {
        ("Table 2, pose 5", "K5"),
        ("section 3, text", "K5"),
        ("section 3, text", "K9"),
        ("Table 1, pose 1", "K4"),
        ("Table 1, pose 2", "K11"),
        ("Tables 1, 3 and 4 with eq. 27", "K6"),
    }


def test_equations_that_differ_have_a_finding(outcomes):
    geometry = [o for o in outcomes if o.claim.basis == "computed by geometry alone"]
    differ = {o.claim.finding for o in geometry if o.verdict == "differs"}
    assert differ == {"K1", "K2", "K3", "K10", "K14", "K16"}
    assert all(o.ours < 1e-6 for o in geometry if o.verdict == "agrees" and not o.claim.source)


def test_no_number_of_tables_1_to_4_is_said_to_be_reproduced_from_a_recording(outcomes):
    missing = [o for o in outcomes if "from the recording" in o.claim.where]
    assert len(missing) == 30 + 20
    assert {o.verdict for o in missing} == {"not reproducible"}
    assert {o.claim.reason for o in missing} == {"not published"}


def test_simulated_errors_are_far_below_the_papers(outcomes):
    """Except where one end alone is corrected: there the lever arm makes most of the number."""
    closing = {
        o.claim.where: o for o in outcomes if o.claim.what == "mean closing error of the rectangle"
    }
    assert len(closing) == 8
    for where, outcome in closing.items():
        assert outcome.verdict == "differs"
        if "end only" in where:
            assert abs(outcome.ours - outcome.claim.trivial) < 0.05 < 0.1 < abs(outcome.difference)
        else:
            assert outcome.ours < 0.25 * outcome.claim.target


def test_reasons_blame_the_print_only_where_the_print_errs(outcomes):
    """Our closing errors contain the lever arm already; what they still lack is our gap."""
    differ = [o.claim for o in outcomes if o.verdict == "differs"]
    closing = [c for c in differ if c.what == "mean closing error of the rectangle"]
    assert {reason_of(c) for c in closing} == {"our assumptions do not explain it"}
    reasons = {c.finding: reason_of(c) for c in differ if c not in closing and c.finding}
    assert reasons["K4"] == "the text is not right"
    assert reasons["K6"] == "the text contradicts itself"
    assert reasons["K12"] == "right in another reading"
    assert {reasons[k] for k in ("K1", "K3", "K5", "K10", "K11")} == {"our copy may be at fault"}


def test_algebra_is_no_experiment(outcomes):
    """(28) needs no walk, and how Tables 3 and 4 were made is our finding, not a statement."""
    algebra = [
        o.claim
        for o in outcomes
        if o.claim.basis == "computed on simulated data" and o.claim.finding in ("K6", "K8")
    ]
    ours = [c for c in algebra if "difference of the two closing errors" in c.what]
    assert len(ours) == 3 and sum(c.finding == "K8" for c in algebra) == 3
    assert not any(c.experiment for c in algebra if c.finding == "K8" or c in ours)


def test_the_record_is_of_this_table():
    assert set(walk_record()["inputs"]) == {"walker_table1.csv"}


def test_a_part_of_the_record_comes_out_again(first_mounts):
    """Seed 0 in pose 1: same mounts and rounds; other builds of NumPy may differ by microns."""
    for row in first_mounts.to_dict("records"):
        kept = recorded_row("first_mounts", pose="1", name=row["name"])
        for axis in ("x_m", "y_m", "z_m"):
            assert row[axis] == pytest.approx(kept[axis], abs=2e-5)
    walks = {
        name: walking_study(
            [0], course, REALISTIC, smooth=False, poses=["1"], positions=first_mounts
        )
        for name, course in {"corridor": CORRIDOR, **COURSES}.items()
    }
    true = walks["corridor"][walks["corridor"]["source"] == "true"]
    kept = walk_record()["numbers"]["corridor_distances_m"]["1"][0]
    assert true["distance_m"].iloc[0] == pytest.approx(kept, abs=1e-4)
    for name in COURSES:
        for row in walks[name].to_dict("records"):
            kept = recorded_row("first_rounds", course=name, source=row["source"], pose="1")
            assert row["closing_x_m"] == pytest.approx(kept["closing_x_m"], abs=2e-5)
            assert row["closing_y_m"] == pytest.approx(kept["closing_y_m"], abs=2e-5)


def test_any_executor_gives_the_same_numbers():
    """Also if the second seed is done before the first."""

    class Backward:
        def __init__(self):
            self.waiting = []

        def submit(self, work, seed):
            self.waiting.append((work, seed))
            return self

        def result(self):
            if isinstance(self.waiting[0], tuple):
                self.done = [work(seed) for work, seed in reversed(self.waiting)]
                self.waiting = [None]
            return self.done.pop()

        def cancel(self):
            return False

    def study(executor):
        return calibration_study(
            [0, 1], REALISTIC, variants=PAPERS_WAY, poses=["2"], executor=executor
        )

    alone = study(None)
    with ThreadPoolExecutor(2) as pool:
        assert study(pool).equals(alone)
    assert study(Backward()).equals(alone)


def test_an_error_of_the_mount_shows_only_if_the_last_corner_is_not_turned():
    """100 mm sideways: 141 mm of closing error a quarter turn off, none after a whole round."""
    x, y, z = pose_translation("1", 1)
    place = {"x_m": x, "y_m": y + 0.1, "z_m": z}
    wrong = pd.DataFrame([{"level": "data sheet", "seed": 1, "pose": "1", "name": "off", **place}])
    level = {"data sheet": LEVELS["data sheet"]}
    added = {}
    for name, course in COURSES.items():
        ends = walking_study([1], course, level, smooth=False, poses=["1"], positions=wrong)
        ends = ends.set_index("source")[["closing_x_m", "closing_y_m"]]
        added[name] = float(np.linalg.norm(ends.loc["off"] - ends.loc["true"]))
    assert added["last corner not turned"] == pytest.approx(0.1414, abs=0.002)
    assert added["last corner turned"] < 0.002
