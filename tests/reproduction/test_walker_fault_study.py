"""The study of faults put into walks: its rows add up, and the same case gives the same row."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.reproduction.recorded import numbers
from mobility_imu.reproduction.walker import faults
from mobility_imu.reproduction.walker.fault_kinds import (
    DRAWN_BY,
    FLOOR_KINDS,
    KINDS,
    LATER_KINDS,
    TILT_KINDS,
    _sign,
    _size,
    clean_walk,
)
from mobility_imu.reproduction.walker.fault_motions import (
    over_kerbs,
    turned_on_the_way,
    up_a_ramp,
)
from mobility_imu.simulation.levels import MOUNTS
from mobility_imu.simulation.walker import CORRIDOR, simulate_walk

RECORD = "faults_walker"
TOLD, RIGHT, TOLD_LARGE = 0.85, 0.83, 0.95
TOLD_LATER, RIGHT_LATER = 0.4, 0.95
"""Of floors and of an IMU that is turned on the way: their limits are those of moves and steps. Of
the 131 that matter 47 % are told, with a standard deviation of 4 % as so many draws have it: the
floor lies below by 1.7 of them. All that are told are told rightly; a wrong one is by chance."""
FEW = 0.2
"""More of 16 drawn cases that matter are told: 8 of 14, 2 of 8 and 4 of 5. One kerb less fails."""


OWN_SEED = 502_000


@pytest.mark.parametrize(
    "kind", ["reversed gyroscope", "clock", "rolls", "tilts, scale", "turned on the way"]
)
def test_a_case_is_the_same_each_time(kind):
    first, again = (faults.one_case(kind, 1, faults.SEEN_SEED) for _ in range(2))
    assert {key: str(value) for key, value in first.items()} == {
        key: str(value) for key, value in again.items()
    }
    assert first["ratio"] > 0 and isinstance(first["found_as"], str)


def test_later_kinds_leave_the_cases_of_the_others_alone():
    """A kind's number is a part of its seed."""
    assert sorted(DRAWN_BY.values()) == list(range(len(KINDS) + len(TILT_KINDS)))
    first = {"gyroscope freezes": 0, "start turns": 23, "tilts, another order": 24}
    assert first | {"tilts, short rest": 31} == {
        kind: DRAWN_BY[kind] for kind in (*first, "tilts, short rest")
    }


def test_kerbs_are_as_high_as_they_are_drawn():
    motion = clean_walk(OWN_SEED, "data sheet", with_sd=False).walk.motion
    higher = over_kerbs(motion, [2, 5], [0.1, -0.25]).position_m - motion.position_m
    when = [motion.steps[k].place_s + 0.1 for k in (1, 2, 4, 5)]
    found = [higher[np.searchsorted(motion.time_s, at), 2] for at in when]
    assert found == pytest.approx([0.0, 0.1, 0.1, -0.15])
    assert not higher[:, :2].any()


def test_a_ramp_is_as_steep_as_it_is_drawn():
    """The frame leans as the floor does, and goes as far along it."""
    level = simulate_walk(CORRIDOR, seed=OWN_SEED)
    ramp = up_a_ramp(level, np.deg2rad(6.0))
    standing = np.flatnonzero(level.stationary & (level.position_m[:, 0] > 2.0))[[0, -1]]
    way, went = (np.diff(m.position_m[standing], axis=0)[0] for m in (level, ramp))
    assert np.rad2deg(np.arctan2(went[2], went[0])) == pytest.approx(6.0, abs=0.05)
    assert np.hypot(went[0], went[2]) == pytest.approx(way[0], rel=1e-3)
    forward = ramp.rotation_body_to_world[standing, :, 0]
    assert np.rad2deg(np.arcsin(forward[:, 2])) == pytest.approx(6.0, abs=0.1)
    still = level.time_s < level.steps[0].lift_s
    assert np.allclose(ramp.position_m[still], level.position_m[still], atol=1e-9)


def test_an_imu_that_is_turned_stays_where_it_is():
    walk = clean_walk(OWN_SEED, "data sheet", with_sd=False)
    motion, mount = walk.walk.motion, MOUNTS[walk.pose]
    fits = turned_on_the_way(motion, mount, np.deg2rad(40.0), 20.0)
    arm = mount.translation_body_m
    places = [m.position_m + m.rotation_body_to_world @ arm for m in (motion, fits)]
    assert np.allclose(*places)
    turn = np.swapaxes(motion.rotation_body_to_world, 1, 2) @ fits.rotation_body_to_world
    angle = np.rad2deg(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]))
    assert np.allclose(angle[motion.time_s < 20.0], 0.0)
    assert np.allclose(angle[motion.time_s > 20.6], 40.0)


def test_after_large_turns_that_were_missed_few_steps_followed():
    """The chapter gives it as the reason; when an IMU was turned is drawn after size and sign."""
    kind = "turned on the way"
    cases = faults.table(numbers(RECORD)).query("kind == @kind").reset_index(drop=True)
    missed = cases[(cases["found_as"] == "") & (cases["ratio"] > faults.MATTERS)]
    left = []
    for case in missed.index[missed["size"] > 20]:
        seed = faults.FIRST_SEED + faults._base(kind, case)
        walk = clean_walk(seed, faults.FAULTY_LEVELS[faults._base(kind, case) % 2], with_sd=False)
        motion, rng = walk.walk.motion, faults.stream(faults.FIRST_SEED, DRAWN_BY[kind], case)
        assert _size(rng, 0.2, 180.0) == pytest.approx(missed.loc[case, "size"], rel=0.01)
        _sign(rng)
        when = rng.uniform(0.2, 0.8) * motion.time_s[-1]
        left.append(sum(step.lift_s > when for step in motion.steps))
    assert sorted(left) == [3, 4, 4]


@pytest.mark.parametrize("kind", ["turned on the way", *FLOOR_KINDS])
def test_later_kinds_have_sensible_rows(kind):
    """What is told is told rightly, and what a floor costs is what the path is off."""
    rows = [faults.one_case(kind, case, OWN_SEED) for case in range(16)]
    told = [row for row in rows if row["found_as"]]
    assert told and all(row["right"] for row in told), [row["found_as"] for row in told]
    matter = [row for row in rows if row["ratio"] > faults.MATTERS]
    assert 0 < len(matter) < len(rows) or kind == "turned on the way"
    assert sum(bool(row["found_as"]) for row in matter) > FEW * len(matter)
    for row in told:
        if kind in FLOOR_KINDS:
            assert row["cost_stated"] == pytest.approx(row["cost_real"], rel=0.3), row


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
        row | found | {"case": 5, "ratio": 4.0, "cost_stated": None},
        row | found | {"case": 6, "ratio": 4.0, "right": False, "cost_stated": None},
    ]
    quiet = [{"level": "real", "seed": 1, "walk": [], "tilts": ["lag frame_gyr 0.1"]}]
    made = faults.numbers_of(rows, quiet)
    (summary,) = made["kinds"]
    assert (summary["cases"], summary["matter"], summary["told"], summary["right"]) == (7, 5, 4, 3)
    assert (summary["priced"], summary["within_two"], summary["unpriced"]) == (2, 1, 2)
    assert (summary["refused"], summary["largest_missed"], summary["told_in_vain"]) == (1, 5.0, 0)
    cases = faults.table(made)
    assert cases["ratio"].tolist()[:4] == [9.0, 9.0, 5.0, 1.0] and np.isnan(cases["ratio"][4])
    assert cases["matters"].tolist() == [True, True, True, False, True, True, True]
    assert cases["found_as"].tolist() == ["lag", "lag", "", "", "refused", "lag", "lag"]
    assert made["clean"]["real"]["tilts_with_alarm"] == 1
    assert made["clean"]["real"]["walk_with_alarm"] == 0


def test_a_mount_moves_by_a_distance_and_an_angle():
    """7 cm along three axes; the axis that is furthest off by its own deviation decides."""
    clean = faults._calibration(0, faults.SEEN_SEED)
    turn = Rotation.from_rotvec(np.deg2rad(3.0) * np.array([0.6, 0.0, 0.8])).as_matrix()
    apart = np.array([0.02, -0.03, 0.06])
    mount = replace(
        clean.mount,
        rotation_imu_to_body=turn @ clean.mount.rotation_imu_to_body,
        translation_body_m=clean.mount.translation_body_m + apart,
    )
    moved = faults._mount_moved(clean, replace(clean, mount=mount))
    ratio, distance = moved["position of the IMU"]
    sd = clean.translation_sd_m + faults.SETTLED_MOUNT_M
    assert (ratio, distance) == pytest.approx((np.max(np.abs(apart) / sd), 0.07))
    assert moved["turn of the IMU"][1] == pytest.approx(3.0)


def test_an_example_for_the_chapter():
    """The same walk with and without the fault, which is told with its cost."""
    example = faults.example("reversed gyroscope", 2)
    assert (example.clean.time_s == example.faulty.time_s).all()
    clean, faulty = example.clean.gyroscope("frame"), example.faulty.gyroscope("frame")
    signs = np.sign((clean * faulty).sum(axis=0))
    assert (signs < 0).any() and np.allclose(faulty, signs * clean)
    acc = example.clean.sensor("frame").acc_mps2
    assert (example.faulty.sensor("frame").acc_mps2 == acc).all()
    (found,) = [fault for fault in example.faults if fault.code == "reversed"]
    place = {cost.name: cost.largest for cost in found.costs}["place"]
    right, wrong = example.result_clean, example.result_faulty
    moved = np.linalg.norm(wrong.position_m - right.position_m, axis=1).max()
    assert place == pytest.approx(moved, rel=0.01)
    assert faults.example("rolls", 2).result_clean is None


def test_the_record_has_a_hundred_of_each_kind():
    kept = numbers(RECORD)
    assert [row["kind"] for row in kept["kinds"]] == [*KINDS, *TILT_KINDS]
    assert all(row["cases"] == faults.CASES for row in kept["kinds"])
    priced, within = (sum(row[name] for row in kept["kinds"]) for name in ("priced", "within_two"))
    assert within >= 0.8 * priced > 300
    cases = faults.table(kept)
    assert len(cases) == faults.CASES * len(kept["kinds"])
    for row in kept["kinds"]:
        mine = cases[(cases["kind"] == row["kind"]) & (cases["found_as"] != "refused")]
        # The record keeps three digits: a ratio just above two is two there.
        surely, perhaps = (
            (mine["ratio"] > faults.MATTERS).sum(),
            (mine["ratio"] >= faults.MATTERS).sum(),
        )
        assert surely <= row["matter"] <= perhaps


def test_what_the_record_says_of_all_kinds():
    """Floors under the computed figures. The goal of 98 % told is missed.

    Of the faults that are read and move the result by more than two stated deviations 88 % are
    told, of those that move it by more than ten 98 %. Walks and tilts without a fault that have
    an alarm are 0.9 % together.
    """
    kept = numbers(RECORD)
    cases = faults.table(kept)
    matter = cases[(cases["ratio"] > faults.MATTERS) & (cases["found_as"] != "refused")]
    later = matter["kind"].isin(LATER_KINDS)
    named = matter[later & (matter["found_as"] != "")]
    assert later.any() and len(named) >= TOLD_LATER * later.sum()
    assert named["right"].mean() >= RIGHT_LATER
    matter = matter[~later]
    told, right = (matter["found_as"] != "").mean(), matter["right"].mean()
    assert 0.98 > told >= TOLD and right >= RIGHT, (told, right)
    large = matter[matter["ratio"] > 10]
    assert (large["found_as"] != "").mean() >= TOLD_LARGE
    levels = kept["clean"].values()
    recordings, walks, tilts = (
        sum(level[name] for level in levels)
        for name in ("recordings", "walk_with_alarm", "tilts_with_alarm")
    )
    assert recordings >= 200 and walks + tilts <= 0.01 * 2 * recordings, (walks, tilts)
    for name, level in kept["clean"].items():
        if name != "real":
            assert level["walk_with_alarm"] == level["tilts_with_alarm"] == 0, name
