"""What the audit of the walker's tables computes: repairs, lever arms, headings."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.plots.style import COLOURS
from mobility_imu.plots.walker import (
    draw_frames,
    plot_lever_arm,
    plot_pose_errors,
    plot_positions,
)
from mobility_imu.reproduction.walker import tables as walker
from mobility_imu.reproduction.walker.tables import (
    POSES,
    best_repair,
    closing_with_arm,
    implied_headings,
    lever_arm_ratio,
    nearest_rotation,
    pose_mount,
    pose_rotation,
    pose_translation,
    printed_average,
    repaired_rotation,
    rotation_distance,
)


def angle_deg(one, other):
    return np.rad2deg(Rotation.from_matrix(one.T @ other).magnitude())


@pytest.mark.parametrize("seed", range(8))
def test_a_spoilt_entry_is_found_and_recomputed(seed):
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(rng=rng).as_matrix()
    row, column = rng.integers(3, size=2)
    spoilt = rotation.copy()
    spoilt[row, column] += 0.3 * np.sign(rng.normal())
    repair = best_repair(spoilt)
    assert (repair.row, repair.column) == (row, column)
    assert repair.printed == spoilt[row, column]
    # The distance grows with the square of the offset's part that bends: 1e-4 is its flat bottom.
    assert repair.value == pytest.approx(rotation[row, column], abs=1e-4)
    assert repair.distance < 1e-4


def test_nearest_rotation_is_a_rotation_even_of_a_mirror():
    rng = np.random.default_rng(1)
    for matrix in rng.normal(size=(50, 3, 3)):
        near = nearest_rotation(matrix)
        assert np.allclose(near @ near.T, np.eye(3)) and np.linalg.det(near) > 0
        other = Rotation.random(200, rng=rng).as_matrix()
        distances = np.linalg.norm(other - matrix, axis=(1, 2))
        assert rotation_distance(matrix) <= distances.min() + 1e-12


def test_repaired_rotations_of_table_1():
    for pose in POSES:
        matrix = repaired_rotation(pose)
        assert np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
        changed = np.abs(matrix - pose_rotation(pose)) > 0.0006  # what projecting alone may move
        expected = {"1": [(2, 1)], "2": [(0, 0)]}.get(pose, [])
        assert [tuple(place) for place in np.argwhere(changed)] == expected
    assert repaired_rotation("1")[2, 1] == pytest.approx(-0.9996, abs=1e-4)
    assert repaired_rotation("2")[0, 0] == pytest.approx(0.3307, abs=1e-4)
    assert angle_deg(nearest_rotation(pose_rotation("2")), repaired_rotation("2")) == pytest.approx(
        4.8, abs=0.05
    )


def test_mounts_have_the_first_methods_position():
    for pose in POSES:
        mount = pose_mount(pose)
        assert np.array_equal(mount.translation_body_m, pose_translation(pose, 1))
        assert np.array_equal(mount.rotation_imu_to_body, repaired_rotation(pose))


def walked(monkeypatch, first_rad, last_rad, *, ends):
    """Put closing errors into Tables 3 and 4 that are made by a known formula."""
    rng = np.random.default_rng(9)
    path = rng.normal(0, 0.3, (5, 6)) + 1j * rng.normal(0, 0.3, (5, 6))
    arms = {k: np.array([pose_translation(p, k - 2) @ [1, 1j, 0] for p in POSES]) for k in (3, 4)}
    made = {}
    for table, arm in arms.items():
        at_start = np.exp(1j * first_rad) * arm[:, None] if ends == "both" else 0
        made[table] = path - np.exp(1j * last_rad) * arm[:, None] + at_start
    monkeypatch.setattr(
        walker, "runs", lambda table, axis: made[table].real if axis == "x" else made[table].imag
    )
    return path, arms


def test_ratio_follows_eq_27_if_both_ends_are_corrected(monkeypatch):
    for turn in (0.0, np.pi / 3, np.pi / 2):
        walked(monkeypatch, 0.4, 0.4 + turn, ends="both")
        assert np.allclose(lever_arm_ratio(), 2 * np.sin(turn / 2))


def test_headings_and_arms_come_back_if_only_the_end_is_corrected(monkeypatch):
    last = np.linspace(-1.5, 1.5, 30).reshape(5, 6)
    path, arms = walked(monkeypatch, 0.0, last, ends="last")
    assert np.allclose(lever_arm_ratio(), 1)
    assert np.allclose(implied_headings(), last)
    closed = closing_with_arm(3, 0.0)
    expected = np.abs(path - (np.exp(1j * last) - 1) * arms[3][:, None])
    assert np.allclose(closed, expected)
    assert np.allclose(closing_with_arm(3, [0.0, 1.0])[0], closed)


def test_published_headings():
    heading = np.rad2deg(implied_headings())
    usual = np.ones((5, 6), bool)
    usual[1, 1:] = False
    assert (np.abs(heading[usual] + 95) < 18).all() and (np.abs(heading[~usual] + 10) < 9).all()


def test_printed_averages_are_those_of_the_tables():
    assert printed_average(3, "distance") == 0.5170 and printed_average(4, "x") == -0.3374
    assert printed_average(2, "distance_estimation", "5") == 9.6525


def test_an_end_a_quarter_turn_off_makes_an_error_of_the_position_count():
    """If the end was corrected: 25 rounds see 1.46 times an error of T, five of pose 2 hardly."""
    gain = 2 * np.abs(np.sin(implied_headings() / 2))
    usual = np.ones((5, 6), bool)
    usual[1, 1:] = False
    assert round(gain[usual].mean(), 2) == 1.46 and gain[~usual].max() < 0.32


def test_figures_show_what_they_are_given():
    errors = np.array([[0.1, 0.2, 0.3], [-0.1, -0.2, -0.6]])
    axes = plot_pose_errors(errors, path_m=10.0).axes[0]
    means = [line.get_ydata()[0] for line in axes.lines if line.get_color() == COLOURS["vermilion"]]
    assert np.allclose(means, [0.2, -0.3])

    first, second = (np.array([pose_translation(p, k) for p in POSES]) for k in (1, 2))
    above, side = plot_positions(first, second).axes
    assert "right" in above.get_xlabel() and "up" in side.get_ylabel()
    dots = [line.get_xydata() for line in above.lines if line.get_marker() == "o"]
    assert np.allclose(np.concatenate(dots), first[:, [1, 0]] * [-1, 1])

    apart = np.zeros((5, 6, 2))
    plane, turns = plot_lever_arm(apart, (first - second)[:, :2], implied_headings(), POSES).axes
    assert len(plane.get_legend_handles_labels()[1]) == 5 and "deg" in turns.get_ylabel()


def test_frames_are_all_drawn():
    texts = {text.get_text() for text in draw_frames().axes[0].texts}
    assert {f"${axis}_{frame}$" for axis in "xyz" for frame in "bIw"} <= texts
