"""Walker: steps, summaries and walking tests against simulated truth."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walker_recordings import pose_mount

from mobility_imu.errors import InputError
from mobility_imu.reproduction.walker.tables import POSES
from mobility_imu.simulation.sensor import MTI_1, without
from mobility_imu.simulation.walker import (
    CORRIDOR,
    PERFECT,
    REALISTIC,
    RECTANGLE,
    TIMED_UP_AND_GO,
    Leg,
    WalkStyle,
    attach_imu,
    simulate_walk,
)
from mobility_imu.walker import StillnessSettings, Trajectory, estimate_trajectory
from mobility_imu.walker.geometry import FOOTPRINT
from mobility_imu.walker.steps import GaitSettings, find_steps, find_turns
from mobility_imu.walker.walking_tests import (
    path_at,
    six_minute_walk,
    ten_metre_walk,
    time_at,
    timed_up_and_go,
    walking_summary,
)

DATASHEET = without(MTI_1, "scale_sd", "misalignment_sd_rad", "g_sensitivity_sd")
LEVELS = {"datasheet": (DATASHEET, PERFECT), "sensor": (MTI_1, PERFECT)}
LEVELS["realistic"] = (MTI_1, REALISTIC)
COURSES = {"corridor": (CORRIDOR, 20), "rectangle": (RECTANGLE, 5), "tug": (TIMED_UP_AND_GO, 5)}
DETECTOR_S = 0.155
"""Half of the detector's longer mean: it sees a move at most so early, or late when it ends."""


@functools.cache
def walk(course, level="realistic", seed=0, style=None, imperfections=None):
    """True motion and estimated trajectory."""
    sensor, usual = LEVELS[level]
    motion = simulate_walk(course, seed=seed, style=style, imperfections=imperfections or usual)
    mount = pose_mount(POSES[seed % 5])
    made = attach_imu(motion, mount, sensor, seed=seed, unit_seed=seed)
    return motion, estimate_trajectory(made.recording, FOOTPRINT, mount)


def drawn(moves, *, rate_hz=100.0, rest_s=1.0, move_s=1.0):
    """Trajectory without any error, from moves (forward m, left m, turn rad, lift m, pitch rad)."""
    rest, move = round(rest_s * rate_hz), round(move_s * rate_hz)
    ramp = np.linspace(0, 1, move + 2)[1:-1]
    state, rows, still = np.zeros(3), [], []
    for change in [*moves, None]:
        rows += [np.r_[state, 0, 0]] * rest
        still += [True] * rest
        if change is not None:
            change = np.asarray(change, float)
            hump = 4 * ramp * (1 - ramp)
            rows += list(
                np.column_stack([state + np.outer(ramp, change[:3]), np.outer(hump, change[3:])])
            )
            still += [False] * move
            state = state + change[:3]
    x, y, yaw, z, pitch = np.array(rows).T
    turn = Rotation.from_euler("ZY", np.column_stack([yaw, -pitch])).as_matrix()
    time, sure = np.arange(len(x)) / rate_hz, np.zeros((len(x), 3))
    return Trajectory(time, np.column_stack([x, y, z]), turn, np.array(still), sure, sure[:, 0])


STEP = (0.3, 0.0, 0.0, 0.05, 0.1)
PIVOT = (0.0, 0.0, 0.5, 0.04, 0.1)


# Steps.


@pytest.mark.parametrize("most", [5, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize("level", LEVELS)
def test_steps_are_counted_exactly(level, most):
    """At least 95 % of the walks, on every course; the five poses take turns.

    Of 15 walks that is each one, of 30 all but one.
    """
    exact = []
    for course, count in COURSES.values():
        for seed in range(min(count, most)):
            motion, trajectory = walk(course, level, seed)
            exact.append(len(find_steps(trajectory)) == len(motion.steps))
    assert np.mean(exact) >= 0.95


@pytest.mark.parametrize("size", [1e160, 1e300])
def test_steps_of_any_size_have_a_length(size):
    """Squares of such lengths overflow; the lengths do not."""
    path = drawn([STEP, STEP])
    found = find_steps(replace(path, position_m=path.position_m * size))
    assert found.length_m == pytest.approx(find_steps(path).length_m * size)


@pytest.mark.parametrize("level", LEVELS)
def test_times_lengths_and_turns(level):
    """Times to what the detector's mean explains; lengths to 1 cm; turns to 0.5 deg."""
    for course in (CORRIDOR, TIMED_UP_AND_GO):
        for seed in range(5):
            motion, trajectory = walk(course, level, seed)
            steps = find_steps(trajectory)
            lift, place, length, turn = motion.step_table().to_numpy().T
            assert np.abs(steps.lift_s - lift).max() < DETECTOR_S + 0.02
            # A rocking, ringing frame comes to rest later than it is put down.
            slack = 0.15 if level == "realistic" else 0.02
            assert np.abs(steps.place_s - place).max() < DETECTOR_S + slack
            assert np.abs(steps.length_m - length).max() < 0.012
            assert np.abs(steps.turn_rad - turn).max() < np.deg2rad(0.5)


def test_lift_height_and_pitch():
    """Height to 1 cm (it drifts), pitch to 0.5 deg."""
    motion, trajectory = walk(CORRIDOR, "realistic", 3)
    steps = find_steps(trajectory)
    for k, step in enumerate(motion.steps):
        here = (motion.time_s > step.lift_s) & (motion.time_s < step.place_s)
        assert abs(steps.lift_height_m[k] - motion.position_m[here, 2].max()) < 0.01
        pitch = np.arcsin(motion.rotation_body_to_world[here, 2, 0]).max()
        assert abs(steps.pitch_rad[k] - pitch) < np.deg2rad(0.5)


def test_a_drawn_walk_is_read_exactly():
    steps = find_steps(drawn([STEP, STEP, PIVOT, (0.0, 0.2, 0.0, 0.03, 0.05)]))
    assert np.allclose(steps.length_m, [0.3, 0.3, 0.0, 0.2])
    assert np.allclose(steps.turn_rad, [0, 0, 0.5, 0])
    assert np.allclose(steps.direction_rad, [0, 0, np.nan, np.pi / 2], equal_nan=True)
    # The middle samples of an even number miss the very top by 1e-4 of it.
    assert np.allclose(steps.lift_height_m, [0.05, 0.05, 0.04, 0.03], rtol=1e-3)
    assert np.allclose(steps.pitch_rad, [0.1, 0.1, 0.1, 0.05], rtol=1e-3)
    assert np.allclose(steps.place_m, [[0.3, 0], [0.6, 0], [0.6, 0], [0.6, 0.2]])
    assert np.allclose(steps.path_m, [0.3, 0.6, 0.6, 0.8])
    assert np.allclose(steps.swing_s, 1.01 - 0.22) and np.allclose(steps.stance_s[:-1], 0.99 + 0.22)
    assert np.isnan(steps.stance_s[-1])


def test_what_is_too_small_is_no_step_and_splits_no_stance():
    rock = (0.01, 0.0, 0.02, 0.0, 0.01)
    steps = find_steps(drawn([STEP, rock, rock, STEP]))
    assert len(steps) == 2
    assert np.isclose(steps.stance_s[0], 3 * 0.99 + 2 * 1.01 + 0.22)
    # The way that the small moves make is on the way along the placements all the same.
    assert np.isclose(steps.path_m[-1], 0.62) and np.allclose(steps.length_m, 0.3)
    small = find_steps(drawn([rock] * 3), GaitSettings(least_length_m=0.005))
    assert len(small) == 3


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.5])
def test_the_world_does_not_matter(angle):
    one = drawn([STEP, PIVOT, STEP])
    turn = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    other = replace(
        one,
        position_m=one.position_m @ turn.T + [3.0, -2.0, 0.5],
        rotation_body_to_world=turn @ one.rotation_body_to_world,
    )
    a, b = find_steps(one), find_steps(other)
    for name in ("lift_s", "length_m", "turn_rad", "lift_height_m", "pitch_rad", "path_m"):
        assert np.allclose(getattr(a, name), getattr(b, name), atol=1e-12)


def test_cut_off_moves_are_said_and_left_out():
    whole = drawn([STEP] * 3)
    part = slice(150, len(whole.time_s) - 150)  # begins and ends in the middle of a move
    cut = Trajectory(*(v[part] for v in list(vars(whole).values())[:6]))
    steps = find_steps(cut)
    assert len(steps) == 1 and len(steps.warnings) == 2
    assert "begins in a move" in steps.warnings[0] and "ends in a move" in steps.warnings[1]


def test_doubts_are_said():
    """Rocking that never rests joins steps; a frame that is swung very slowly passes for still."""
    rocking = replace(REALISTIC, rocking_rad=np.deg2rad(0.6))
    motion, trajectory = walk((Leg(4.0),), imperfections=rocking)
    steps = find_steps(trajectory)
    assert len(steps) < len(motion.steps)
    assert any("too long for one step" in said for said in steps.warnings)
    _, trajectory = walk((Leg(4.0),), style=WalkStyle(swing_s=(2.5, 4.0)))
    assert any("in the air" in said for said in find_steps(trajectory).warnings)
    _, trajectory = walk(CORRIDOR)
    assert not find_steps(trajectory).warnings


def test_a_move_of_twice_the_usual_length_may_be_two_steps():
    """Two moves without the rest between them: 2.8 s, which is less than the limit of 3 s."""
    trajectory = drawn([STEP] * 6)
    still = trajectory.stationary.copy()
    still[200:300] = False
    steps = find_steps(replace(trajectory, stationary=still))
    assert len(steps) == 5 and 2 < steps.swing_s.max() < 3
    assert any("moves too long for one step: 1, up to 2.8 s" in said for said in steps.warnings)
    still[230:300] = True  # a third longer than the others: one step
    assert not find_steps(replace(trajectory, stationary=still)).warnings
    assert not find_steps(trajectory).warnings


def test_nobody_walks():
    standing = drawn([])
    steps = find_steps(standing)
    assert len(steps) == 0 and len(steps.to_frame()) == 0 and len(steps.path_m) == 0
    assert len(find_turns(steps).angle_rad) == 0
    with pytest.raises(InputError, match="there is none"):
        walking_summary(steps)
    with pytest.raises(InputError, match="never stands"):
        find_steps(replace(standing, stationary=np.zeros(len(standing.time_s), bool)))


def test_given_rests_are_brought_in_by_nothing():
    """Those of a detector by what it takes off their ends."""
    path = drawn([STEP])
    for stillness in (None, StillnessSettings(margin_s=0.1, shorten_s=0.05)):
        off_s = 0.0 if stillness is None else 0.15
        found = find_steps(replace(path, stillness=stillness))
        assert found.lift_s == pytest.approx([0.99 + off_s])
        assert found.place_s == pytest.approx([2.0 - off_s])


def test_settings_are_checked():
    for wrong in ({"least_length_m": 0}, {"least_turn_rad": 5}, {"least_length_m": "0.05"}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            GaitSettings(**wrong)
    assert GaitSettings(least_turn_rad=np.pi / 2).least_turn_rad == np.pi / 2
    with pytest.raises(InputError, match="least_turn_rad"):
        GaitSettings(least_turn_rad=np.deg2rad(91))
    with pytest.raises(InputError, match="longer than half of the move"):
        find_steps(replace(drawn([STEP]), stillness=StillnessSettings(margin_s=0.6)))


def test_table_has_units_in_its_names():
    table = find_steps(drawn([STEP, PIVOT])).to_frame()
    assert table.columns.tolist() == [
        "step", "lift_s", "place_s", "swing_s", "stance_s", "length_m", "turn_deg",
        "lift_height_m", "pitch_deg", "x_m", "y_m",
    ]  # fmt: skip
    assert table["step"].tolist() == [1, 2] and np.isclose(table["turn_deg"][1], np.rad2deg(0.5))


# Summary.


def test_summary_of_a_drawn_square():
    """Back where it began: the way is counted, not the displacement."""
    corner = [(0.0, 0.0, np.pi / 4, 0.04, 0.1)] * 2
    sides = [
        [(0.5 * c, 0.5 * s, 0.0, 0.05, 0.1)] * 4 for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))
    ]
    trajectory = drawn([move for side in sides for move in [*side, *corner]])
    summary = walking_summary(find_steps(trajectory))
    assert np.linalg.norm(trajectory.position_m[-1]) < 1e-12 and np.isclose(summary.path_m, 8.0)
    assert summary.step_count == 24 and np.isclose(summary.cadence_per_min, 30)
    steps = find_steps(trajectory)
    assert np.isclose(summary.mean_speed_mps, 8.0 / (steps.place_s[23] - steps.lift_s[0]))
    assert np.isclose(summary.step_length_mean_m, 0.5) and summary.step_length_cv < 1e-12
    assert np.allclose(summary.turns.angle_rad, np.pi / 2) and len(summary.turns.angle_rad) == 4
    table = summary.to_frame()
    assert table["turn_count"][0] == 4 and np.isclose(table["turned_deg"][0], 360)


def test_turns_of_two_senses_are_two():
    steps = find_steps(drawn([PIVOT, PIVOT, (0, 0, -0.4, 0.04, 0.1), STEP]))
    turns = find_turns(steps)
    assert np.allclose(turns.angle_rad, [1.0, -0.4])
    assert turns.first_step.tolist() == [0, 2] and turns.last_step.tolist() == [1, 2]
    assert np.isclose(turns.stop_s[0], steps.place_s[1])
    table = turns.to_frame()
    assert table["first_step"].tolist() == [1, 3] and table["last_step"].tolist() == [2, 3]
    assert np.allclose(table["turn_deg"], np.rad2deg([1.0, -0.4]))
    assert np.allclose(table["start_s"], steps.lift_s[[0, 2]])
    assert np.allclose(table["stop_s"], steps.place_s[[1, 2]])


def test_cadence_and_speed_against_truth():
    """Cadence to 0.1 /min; speed to 2 % at most, short by what the tips creep unseen."""
    for seed in range(5):
        motion, trajectory = walk(RECTANGLE, "realistic", seed)
        summary = walking_summary(find_steps(trajectory))
        lift, place, *_ = motion.step_table().to_numpy().T
        assert abs(summary.cadence_per_min - 60 * (len(lift) - 1) / (lift[-1] - lift[0])) < 0.1
        speed = motion.knots().way_m[-1] / (place[-1] - lift[0])
        assert abs(summary.mean_speed_mps / speed - 1) < 0.02
        assert len(summary.turns.angle_rad) == 4
        assert np.allclose(summary.turns.angle_rad, np.pi / 2, atol=np.deg2rad(1.5))


# Walking tests.


def test_way_and_time_are_inverse():
    steps = find_steps(drawn([STEP] * 5))
    for way in (0.05, 0.3, 0.75, 1.5):
        assert np.isclose(path_at(steps, time_at(steps, way)), way)
    assert path_at(steps, 0.0) == 0 and np.isclose(path_at(steps, 1e3), 1.5)
    assert np.isclose(time_at(steps, 0.6), steps.place_s[1])


@pytest.mark.parametrize("level", LEVELS)
def test_ten_metre_walk(level):
    """Times to 2 %, by creep and scale; the frame itself passes within a stance and a half."""
    for seed in range(5):
        motion, trajectory = walk((Leg(14.0),), level, seed)
        steps, (knots, way) = find_steps(trajectory), motion.knots()
        at = dict(zip((0, 2, 8, 10), np.interp([0, 2, 8, 10], way, knots), strict=True))
        static = ten_metre_walk(steps, start="static")
        rolling = ten_metre_walk(steps, start="rolling")
        assert abs(static.duration_s / (at[10] - at[0]) - 1) < 0.02
        assert abs(rolling.duration_s / (at[8] - at[2]) - 1) < 0.02
        passed = motion.time_s[np.argmax(motion.position_m[:, 0] >= 10)]
        assert abs(static.stop_s - passed) < 3.0
        assert static.distance_m == 10 and np.isclose(rolling.distance_m, 6)
        assert np.isclose(static.speed_mps * static.duration_s, 10)


def test_ten_metre_walk_refuses():
    trajectory = drawn([STEP] * 20)
    steps = find_steps(trajectory)
    with pytest.raises(InputError, match="6 m long, 4 m shorter than 10 m"):
        ten_metre_walk(steps, start="static")
    with pytest.raises(InputError, match="shorter than 8 m"):
        ten_metre_walk(steps, start="rolling")
    with pytest.raises(InputError, match="start = 'flying'"):
        ten_metre_walk(steps, start="flying")
    with pytest.raises(InputError, match="run_up_m"):
        ten_metre_walk(steps, start="rolling", run_up_m=5)
    assert ten_metre_walk(steps, start="static", distance_m=6).step_count == 20


def test_distance_in_a_time():
    """Sixty seconds here, to 2 % of the truth; the refusal; the step under way."""
    motion, trajectory = walk(CORRIDOR, "realistic", 1)
    steps = find_steps(trajectory)
    test = six_minute_walk(steps, duration_s=60)
    knots, way = motion.knots()
    true = np.interp(knots[0] + 60, knots, way)
    assert abs(test.distance_m / true - 1) < 0.02 and np.isclose(test.duration_s, 60)
    with pytest.raises(InputError, match=r"goes on for 7[0-9].* expected at least 360 s"):
        six_minute_walk(steps)
    drawing = drawn([STEP] * 3)
    steps = find_steps(drawing)
    half = six_minute_walk(steps, duration_s=steps.swing_s[0] + 1.0)  # of a 2 s cycle
    assert np.isclose(half.distance_m, 0.45) and half.step_count == 1


@pytest.mark.parametrize("level", LEVELS)
def test_timed_up_and_go(level):
    for seed in range(5):
        motion, trajectory = walk(TIMED_UP_AND_GO, level, seed)
        steps = find_steps(trajectory)
        lift, place, _, turn = motion.step_table().to_numpy().T
        phases = timed_up_and_go(steps)
        turning = np.nonzero(turn)[0]
        first, second = turning[:6], turning[6:]
        true = [lift[0], lift[first[0]], place[first[-1]], lift[second[0]], place[second[-1]]]
        assert np.abs(phases.boundary_s - true).max() < DETECTOR_S + 0.15
        assert phases.step_count.tolist() == [first[0], 6, second[0] - first[-1] - 1, 6]
        assert np.allclose(phases.turn_rad[[1, 3]], np.pi, atol=np.deg2rad(3))
        assert np.allclose(phases.distance_m[[0, 2]], 3.0, atol=0.1)
        assert np.isclose(phases.duration_s, np.diff(phases.boundary_s).sum())
        assert np.isclose(phases.to_frame()["duration_s"].sum(), phases.duration_s)


def test_timed_up_and_go_needs_two_turns():
    half = [(0, 0, np.pi / 4, 0.04, 0.1)] * 4
    one = drawn([STEP, STEP, *half, STEP])
    with pytest.raises(InputError, match="found 1, expected 2"):
        timed_up_and_go(find_steps(one))
    at_once = drawn([*half, STEP, *half])
    with pytest.raises(InputError, match="no step before"):
        timed_up_and_go(find_steps(at_once))
