"""Simulated walks of the chapters on steps: what they are made of, and what is counted in them."""

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.reproduction.walker.gait import (
    COURSES,
    gait_walk,
    gait_walks,
    percent_exact,
    step_errors,
)
from mobility_imu.simulation.levels import LEVELS, MOUNTS
from mobility_imu.simulation.walker import CORRIDOR, PERFECT, Leg, WalkStyle
from mobility_imu.walker.steps import GaitSettings, find_steps

SHORT = (Leg(1.5),)


def test_poses_take_turns_and_a_seed_gives_the_same_walk():
    first, again = gait_walk(SHORT, 6), gait_walk(SHORT, 6)
    rate = first.recording.sensor("frame").gyr_radps
    assert np.array_equal(rate, again.recording.sensor("frame").gyr_radps)
    at_rest = first.recording.sensor("frame").acc_mps2[:100].mean(axis=0)
    up = MOUNTS["2"].rotation_imu_to_body[2]  # the second pose, since 6 mod 5 is 1
    assert np.linalg.norm(at_rest / np.linalg.norm(at_rest) - up) < np.deg2rad(1.5)


def test_each_course_is_walked_at_each_level():
    walks = gait_walks(most=1)
    assert set(walks) == {(level, course, 0) for level in LEVELS for course in COURSES}
    assert {count for _, count in COURSES.values()} == {20, 3, 5}
    # A frame without imperfections moves alike whatever the sensor.
    places = [walks[level, "10 m", 0].motion.position_m for level in LEVELS]
    assert np.array_equal(places[0], places[1]) and not np.array_equal(places[1], places[2])


def test_imperfections_and_style_replace_those_of_the_level():
    style = WalkStyle(length_m=(0.2, 0.2))
    walk = gait_walk(SHORT, 1, imperfections=PERFECT, style=style)
    length = walk.motion.step_table()["length_m"].to_numpy()
    assert np.allclose(length[:-1], 0.2, atol=1e-6)


def test_errors_are_found_minus_true():
    walks = [gait_walk(SHORT, seed) for seed in (0, 1)]
    found = [find_steps(walk.trajectory) for walk in walks]
    off = step_errors(walks, found)
    assert {len(values) for values in off.values()} == {sum(map(len, found))}
    assert np.allclose(off["swing_s"], off["place_s"] - off["lift_s"])
    true = np.hstack([w.motion.step_table()["length_m"] for w in walks])
    assert np.allclose(true + off["length_m"], np.hstack([s.length_m for s in found]))


def test_a_wrong_count_cannot_be_matched():
    walk = gait_walk(SHORT, 0)
    far = find_steps(walk.trajectory, GaitSettings(least_length_m=5.0))
    with pytest.raises(InputError, match="0 steps in a walk of"):
        step_errors([walk], [far])
    assert percent_exact([walk]) == 100
    assert percent_exact([walk], GaitSettings(least_length_m=5.0)) == 0


def test_an_unknown_level_is_refused():
    with pytest.raises(InputError, match="level"):
        gait_walk(CORRIDOR, 0, level="real")
