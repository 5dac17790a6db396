"""What the walker's chapters on navigation compute: algebra with symbols, and small studies."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.reproduction.walker.algebra import (
    conjugate,
    cross_rows,
    product,
    turned,
    turning_rows,
)
from mobility_imu.reproduction.walker.navigation_studies import (
    NOISE_ONLY,
    closing_errors,
    consistency_table,
    corridor_walks,
    creep_m,
    distance_error,
    form_table,
    four_paths,
    margin_table,
    path_error,
    stride_table,
    threshold_table,
    walks,
)
from mobility_imu.simulation.walker import Leg
from mobility_imu.walker.navigation import NavigationSettings
from mobility_imu.walker.stillness import StillnessSettings

SHORT = (Leg(2.0),)


@pytest.fixture(scope="module")
def short_walks():
    return walks(SHORT, (1,), NOISE_ONLY)


def test_the_algebra_is_that_of_turns():
    rng = np.random.default_rng(5)
    first, second = Rotation.random(2, rng=rng)
    p, q = (turn.as_quat(scalar_first=True) for turn in (first, second))
    v, w = rng.normal(size=(2, 3))
    together = (first * second).as_matrix()
    np.testing.assert_allclose(turning_rows(product(p, q)), together, atol=1e-14)
    np.testing.assert_allclose(turned(p, v), first.apply(v), atol=1e-14)
    np.testing.assert_allclose(turned(conjugate(p), turned(p, v)), v, atol=1e-14)
    np.testing.assert_allclose(np.array(cross_rows(v)) @ w, np.cross(v, w), atol=1e-14)


def test_walks_are_one_for_each_mounting_and_seed():
    made = walks(SHORT, (0, 1), NOISE_ONLY)
    assert len(made) == 10
    mounts = [walk.mount.translation_body_m for walk in made]
    assert np.array_equal(mounts[0], mounts[1]) and not np.array_equal(mounts[1], mounts[2])
    assert all(walk.distance_m == pytest.approx(2, abs=0.1) for walk in made)


def test_each_path_is_better_than_the_one_before(short_walks):
    walk = short_walks[3]
    ends = []
    for path in four_paths(walk).values():
        truth, _ = walk.path_in_axes(path.rotation_imu_to_world()[0])
        ends.append(np.linalg.norm(path.position_m[-1] - truth[-1]))
    assert ends[0] > 3 * ends[1] > 9 * ends[2] and ends[3] < 0.02


def test_a_loose_detector_makes_a_walk_short(short_walks):
    table = threshold_table({"one": short_walks[:2]}, ((0.05, 0.25), (0.3, 2.0)))
    assert table["still, %"].is_monotonic_increasing
    assert abs(table["error, m"][0]) < 0.02 and table["error, m"][1] < -0.1
    bare = margin_table(short_walks[:2], ((0.07, 0.04), (0.0, 0.0)), ((0.12, 0.7),))
    assert bare.iloc[1, 1] < bare.iloc[0, 1] < 0.01
    error, found = distance_error(short_walks[0], StillnessSettings())
    assert abs(error) < 0.02 and 0.3 < found < 0.8


def test_strides_change_the_path_by_less_than_its_error(short_walks):
    table = stride_table({"one": short_walks[:2]}, ((1, 1), (8, 4)))
    assert table["path changed by, mm"][0] == 0
    assert 0 < table["path changed by, mm"][1] < table["rms error, mm"][1]
    assert table["updates per still sample, %"].round().tolist()[0] == 100


def test_a_frame_that_creeps_is_worse_than_the_filter_states():
    levels = corridor_walks((1,))
    assert creep_m(levels["datasheet"][0]) == pytest.approx(0, abs=1e-6)
    assert creep_m(levels["realistic"][0]) > 0.02
    table = consistency_table({name: made[:2] for name, made in levels.items()})
    assert table["NIS (1)"][0] < 1 < table["NIS (1)"][1]


def test_the_smoother_follows_only_if_it_is_asked_for(short_walks):
    forward, error, _ = path_error(short_walks[0])
    both, _, _ = path_error(short_walks[0], smooth=True)
    assert error.shape == forward.position_m.shape
    assert (both.sd[50:-50, 6] < forward.sd[50:-50, 6] + 1e-12).all()


def test_the_wrong_sign_hurts_where_nothing_else_finds_the_bias():
    around = walks((Leg(1.0, np.pi / 2),) * 4, (1,), NOISE_ONLY)[:2]
    table = form_table(around)
    assert table["(24)"].tolist() == ["derived", "our copy's"] * 4
    first, last = table.iloc[0], table.iloc[-1]
    assert first["end error, m"] < 0.05 and last["end error, m"] > 0.2
    ((mean_m, largest_m, _),) = closing_errors(around, [NavigationSettings()])
    assert mean_m == first["end error, m"] and largest_m >= mean_m
