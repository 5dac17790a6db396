"""Wheelchair: tasks against the printed tables, plain code and a simulator."""

import math
from dataclasses import fields, replace
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from chairs import (
    ROUNDING,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import pyplot as plt
from plain_tasks import plain_tasks

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.plots.wheelchair import chronogram
from mobility_imu.readers import read_recording
from mobility_imu.readers.velocities import VelocitySeries, read_velocities
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.wheelchair.sample import open_combinations
from mobility_imu.simulation.wheelchair import (
    COURT,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    Task,
    TaskSettings,
    WheelchairGeometry,
    calibrate_mount,
    estimate_velocity,
    identify_tasks,
    task_codes,
    tasks,
)
from mobility_imu.wheelchair.tasks import (
    Symbols,
    curvature_radius,
    find_pattern,
    reduce_variability,
    refine_edges,
    task_steps,
    window_means,
)


def test_curvature_radius_is_in_metres_for_rad_per_second():
    # a circle of 3 m radius at 1.5 m/s takes 2 pi 3 / 1.5 s for a turn
    yaw_rate = 2 * math.pi / (2 * math.pi * 3 / 1.5)
    assert curvature_radius([1.5], [yaw_rate]) == pytest.approx([3.0])
    assert curvature_radius([-1.5], [yaw_rate]) == pytest.approx([3.0])
    assert curvature_radius([1.5], [-yaw_rate]) == pytest.approx([3.0])
    # taken literally, in deg/s, a wide turn becomes a pivot
    assert curvature_radius([1.5], [math.degrees(yaw_rate)])[0] < 0.2
    assert curvature_radius([0.0, 2.0, 1e300], [0.0, 0.0, 1e-290]).tolist() == [np.inf] * 3


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=40), st.integers(1, 45))
def test_window_means_are_means(values, length):
    found = window_means(values, length)
    expected = [np.mean(values[s : s + length]) for s in range(len(values))]
    assert found == pytest.approx(expected, abs=ROUNDING)


def test_every_letter_and_every_pattern_of_the_printed_tables():
    """Constant series in the middle of each range of Table 1, looked up in Table 2."""
    patterns = {}
    for _, cell in load_published("wheelchair_table2").iterrows():
        patterns.setdefault(cell["column"], {})[cell["row"]] = cell["printed"]
    names = {
        "static": Task.STATIC,
        "forward": Task.FORWARD,
        "backward": Task.BACKWARD,
        "pivot": Task.PIVOT,
        "tight": Task.TIGHT,
        "wide": Task.WIDE,
    }
    driven = {
        Task.STATIC: (0.2, 20),
        Task.FORWARD: (1.0, 10),
        Task.BACKWARD: (-1.0, 10),
        Task.PIVOT: (0.1, 60),
        Task.TIGHT: (0.4, 60),
        Task.WIDE: (1.0, 60),
    }
    for task, (velocity, yaw_rate) in driven.items():
        count = 100
        steps = task_steps(np.full(count, velocity), np.full(count, np.deg2rad(yaw_rate)), 100)
        letters = dict(
            zip(
                ("linear_velocity", "abs_linear_velocity", "abs_yaw_rate", "curvature_radius"),
                ["abc"[getattr(steps.symbols, f.name)[50]] for f in fields(steps.symbols)],
                strict=True,
            )
        )
        fitting = [name for name, pattern in patterns.items() if pattern.items() <= letters.items()]
        assert [names[name] for name in fitting] == [task]
        assert (steps.reduced == task).all()


LIMITS = TaskSettings()


@pytest.mark.parametrize(
    ("velocity", "yaw_radps", "task"),
    [
        (0.5, 0.0, Task.FORWARD),
        (np.nextafter(0.5, 0), 0.0, Task.STATIC),
        (-0.5, 0.0, Task.BACKWARD),
        (1.0, math.radians(40), Task.WIDE),  # the print leaves exactly 40 without a letter
        (1.0, math.radians(39.999), Task.FORWARD),
        (0.2, 1.0, Task.PIVOT),
        (0.201, 1.0, Task.TIGHT),
        (0.499, -1.0, Task.TIGHT),
        (-0.5, 1.0, Task.WIDE),
        (0.0, 1.0, Task.PIVOT),
        (0.0, 0.0, Task.STATIC),
    ],
)
def test_limits_of_table_1(velocity, yaw_radps, task):
    # two equal values are added and halved without rounding
    limits = TaskSettings(segment_s=0.02)
    codes = task_codes(np.full(64, velocity), np.full(64, yaw_radps), 100, limits)
    assert set(codes) == {task}


def test_rocking_within_a_segment_counts_as_forward_because_table_2_leaves_it_open():
    rocking = np.tile([1.0, -1.0], 100)
    steps = task_steps(rocking, np.zeros(200), 100, TaskSettings(segment_s=0.2))
    assert set(steps.symbols.velocity) == {1}
    assert set(steps.symbols.speed) == {2}
    assert set(find_pattern(steps.symbols)) == {Task.FORWARD}


def test_onset_moves_to_where_motion_begins_and_end_to_where_it_ends():
    codes = np.full(100, Task.STATIC, np.int8)
    codes[40:60] = Task.FORWARD
    speed = np.zeros(100)
    speed[30:75] = 0.3
    calm = np.zeros(100)
    refined = refine_edges(codes, speed, calm, 30, LIMITS)
    assert np.nonzero(refined == Task.FORWARD)[0][[0, -1]].tolist() == [30, 74]
    # not found within the look window: nothing moves
    refined = refine_edges(codes, speed, calm, 9, LIMITS)
    assert np.nonzero(refined == Task.FORWARD)[0][[0, -1]].tolist() == [40, 59]


def test_rotations_take_precedence_over_travel():
    codes = np.full(100, Task.FORWARD, np.int8)
    codes[50:] = Task.WIDE
    turning = np.where(np.arange(100) >= 38, 20.0, 0.0)
    refined = refine_edges(codes, np.full(100, 1.0), turning, 30, LIMITS)
    assert np.nonzero(refined == Task.WIDE)[0][0] == 38


@pytest.mark.parametrize(("length", "absorbed"), [(4, True), (5, False)])
def test_variability_step_takes_only_what_is_shorter_than_a_segment(length, absorbed):
    codes = np.r_[np.full(20, 2), np.full(length, 6), np.full(20, 2)].astype(np.int8)
    reduced = reduce_variability(codes, 5)
    assert (set(reduced) == {2}) is absorbed
    # not between two of one kind, and not at the ends
    for other in ([2, 2, 2, 6, 6, 5, 5, 5], [6, 2, 2, 2, 2, 2, 2, 6]):
        codes = np.array(other, np.int8)
        assert np.array_equal(reduce_variability(codes, 3), codes)


# Tasks: against the plain rendering of the document

HOSTILE_VELOCITY = [
    0.0,
    -0.0,
    0.5,
    -0.5,
    float(np.nextafter(0.5, 0)),
    0.1,
    float(np.nextafter(0.1, 0)),
    0.2,
    -0.05,
    1.3,
    -1.3,
    1e-300,
    4.0,
]
HOSTILE_YAW_RATE = [
    0.0,
    -0.0,
    1e-290,
    math.radians(40),
    float(np.nextafter(math.radians(40), 0)),
    math.radians(10),
    -math.radians(10),
    1.0,
    -1.0,
    2.5,
    -2.6,
    0.4,
]
stretch = st.tuples(
    st.integers(1, 9), st.sampled_from(HOSTILE_VELOCITY), st.sampled_from(HOSTILE_YAW_RATE)
)


@st.composite
def drives(draw):
    """Runs of hostile values with noise from nothing to more than the thresholds' gaps."""
    runs = draw(st.lists(stretch, min_size=1, max_size=16))
    velocity, yaw_rate = (np.concatenate([np.full(run[0], run[k]) for run in runs]) for k in (1, 2))
    noise = draw(st.sampled_from([0.0, 0.0, 1e-16, 0.02, 0.3]))
    rng = np.random.default_rng(draw(st.integers(0, 1000)))
    velocity = velocity + noise * rng.standard_normal(len(velocity))
    yaw_rate = yaw_rate + noise * rng.standard_normal(len(yaw_rate))
    segment = draw(st.integers(1, min(12, len(velocity))))
    look = draw(st.integers(0, 12))
    thresholds = TaskSettings(segment_s=segment / 100, look_s=look / 100)
    if draw(st.booleans()):
        thresholds = replace(
            thresholds,
            linear_velocity_mps=0.2,
            yaw_rate_degps=10.0,
            pivot_radius_m=0.5,
            wide_radius_m=0.5,
            onset_velocity_mps=0.3,
            onset_yaw_rate_degps=0.0,
        )
    return velocity, yaw_rate, segment, look, thresholds


def differing(velocity, yaw_rate, segment, look, thresholds, edge):
    ours = task_codes(velocity, yaw_rate, 100, thresholds, edge=edge)
    plain = plain_tasks(velocity, yaw_rate, segment, look, thresholds, edge)
    return int((ours != np.array(plain)).sum())


@settings(deadline=None, max_examples=300)
@given(drives(), st.sampled_from(["covering", "tool"]), st.sampled_from([1, 2, 7, 16384]))
def test_tasks_equal_the_plain_rendering_of_the_document(drive, edge, block):
    with mock.patch.object(tasks, "BLOCK", block):
        assert differing(*drive, edge) == 0


def hostile(kind, count=400):
    """Long series of one bad habit each."""
    rng = np.random.default_rng(7)
    t = np.arange(count)
    at_velocity = 0.5 + rng.choice([-1e-16, 0, 1e-16, -0.01, 0.01], count)
    at_yaw = np.deg2rad(40) + rng.choice([-1e-16, 0, 1e-16, -0.01, 0.01], count)
    return {
        "noise at thresholds": (at_velocity, at_yaw),
        "zeros in yaw": (np.full(count, 0.3), np.where(t % 3, 0.8, 0.0)),
        "one yaw of 1e-290": (np.full(count, 0.1), np.where(t == 200, 1e-290, 1.0)),
        "alternating runs": (np.where(t // 3 % 2, 1.0, 0.0), np.where(t // 4 % 2, 0.9, 0.2)),
        "ties": (np.where(t // 5 % 2, 1.0, 0.0), np.zeros(count)),
        "rest": (np.zeros(count), np.zeros(count)),
        "starts moving": (np.full(count, 1.0), np.full(count, 0.2)),
        "white noise": (rng.standard_normal(count), 2 * rng.standard_normal(count)),
    }[kind]


@pytest.mark.parametrize("edge", ["covering", "tool"])
@pytest.mark.parametrize("segment", [1, 2, 9, 10, 25, 399, 400])
@pytest.mark.parametrize(
    "kind",
    [
        "noise at thresholds",
        "zeros in yaw",
        "one yaw of 1e-290",
        "alternating runs",
        "ties",
        "rest",
        "starts moving",
        "white noise",
    ],
)
def test_tasks_equal_the_plain_rendering_on_hostile_series(kind, segment, edge):
    thresholds = TaskSettings(segment_s=segment / 100)
    with mock.patch.object(tasks, "BLOCK", 64):
        assert differing(*hostile(kind), segment, 30, thresholds, edge) == 0


def test_tasks_of_a_long_drive_do_not_depend_on_the_blocks():
    drive = simulate_drive(COURT, SAMPLE_CHAIR, random_mounting(2), seed=2)
    velocity = np.tile(drive.linear_velocity_mps, 7)
    yaw_rate = np.tile(drive.yaw_rate_radps, 7)
    assert len(velocity) > 2 * tasks.BLOCK
    in_blocks = task_codes(velocity, yaw_rate, 100)
    with mock.patch.object(tasks, "BLOCK", 10**9):
        at_once = task_codes(velocity, yaw_rate, 100)
    assert np.array_equal(in_blocks, at_once)


@settings(deadline=None, max_examples=50)
@given(drives())
def test_direction_of_a_turn_does_not_matter(drive):
    velocity, yaw_rate, _, _, thresholds = drive
    one = task_codes(velocity, yaw_rate, 100, thresholds)
    assert np.array_equal(one, task_codes(velocity, -yaw_rate, 100, thresholds))


@settings(deadline=None, max_examples=50)
@given(drives(), st.sampled_from([0.5, 2.0, 4.0]))
def test_clock_and_length_units_do_not_matter(drive, factor):
    velocity, yaw_rate, _, _, thresholds = drive
    one = task_codes(velocity, yaw_rate, 100, thresholds)
    # the same frames on a faster clock, with times that shrink alike
    faster = replace(
        thresholds,
        segment_s=thresholds.segment_s / factor,
        look_s=thresholds.look_s / factor,
    )
    assert np.array_equal(one, task_codes(velocity, yaw_rate, 100 * factor, faster))
    # another unit of length, a power of two so that no rounding moves a value over a limit
    lengths = ("linear_velocity_mps", "onset_velocity_mps", "pivot_radius_m", "wide_radius_m")
    scaled = replace(thresholds, **{k: factor * getattr(thresholds, k) for k in lengths})
    assert np.array_equal(one, task_codes(factor * velocity, yaw_rate, 100, scaled))


@settings(deadline=None, max_examples=50)
@given(drives())
def test_edges_differ_only_in_frames_that_not_all_offsets_cover(drive):
    velocity, yaw_rate, segment, _, thresholds = drive
    covering, tool = (
        task_steps(velocity, yaw_rate, 100, thresholds, edge=edge) for edge in ("covering", "tool")
    )
    different = np.nonzero(covering.pattern != tool.pattern)[0]
    assert (different < segment - 1).all()


def test_a_trial_that_starts_in_motion_is_called_static_at_first_by_the_tools_edge_only():
    velocity, yaw_rate = np.full(200, 1.2), np.zeros(200)
    assert (task_codes(velocity, yaw_rate, 100) == Task.FORWARD).all()
    codes = task_codes(velocity, yaw_rate, 100, edge="tool")
    # of 25 offsets t + 1 reach frame t: they are outvoted up to 12 of 25
    assert np.nonzero(codes == Task.STATIC)[0].tolist() == list(range(12))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(24), np.zeros(24), 100), "24 frames are fewer than the 25"),
        ((np.zeros(0), np.zeros(0), 100), "0 frames"),
        ((np.zeros(100), np.zeros(99), 100), "expected 100 samples"),
        ((np.r_[np.zeros(50), np.nan], np.zeros(51), 100), "sample 50 is nan"),
        ((np.zeros(51), np.r_[np.zeros(50), np.inf], 100), "sample 50 is inf"),
        ((np.zeros((50, 2)), np.zeros(50), 100), "one time series"),
        ((np.zeros(100), np.zeros(100), 0), "sampling_rate_hz = 0"),
        ((np.zeros(100), np.zeros(100), math.nan), "sampling_rate_hz = nan"),
        ((np.zeros(100), np.zeros(100), 1), "less than one frame"),
    ],
)
def test_series_that_cannot_be_segmented_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        task_codes(*arguments)


def test_unknown_edge_is_refused():
    with pytest.raises(InputError, match="edge = 'both'"):
        task_codes(np.zeros(100), np.zeros(100), 100, edge="both")


def test_find_pattern_gives_one_task_to_each_of_the_36_combinations():
    grid = np.stack(np.meshgrid(range(3), (1, 2), (1, 2), range(3)), -1).reshape(-1, 4)
    codes = find_pattern(Symbols(*grid.astype(np.int8).T))
    assert set(codes) == set(Task)
    assert len(codes) == 36


def test_uneven_clocks_and_unequal_series_of_a_drive_are_refused(court):
    drive = court[0]
    gap = drive.time_s + np.where(np.arange(len(drive)) > 99, 5.0, 0.0)
    with pytest.raises(InputError, match=r"time_s: gap of 5.01 s after 0.99 s"):
        identify_tasks(replace(drive, time_s=gap))
    with pytest.raises(InputError, match=r"yaw_rate_radps: expected shape \(5250,\)"):
        identify_tasks(replace(drive, yaw_rate_radps=drive.yaw_rate_radps[:-1]))


def test_a_drive_a_file_and_arrays_get_the_same_tasks(court, tmp_path):
    drive = court[0]
    tasks = identify_tasks(drive, TaskSettings(segment_s=0.255), edge="tool")
    again = task_codes(
        drive.linear_velocity_mps,
        drive.yaw_rate_radps,
        100,
        TaskSettings(segment_s=0.255),
        edge="tool",
    )
    assert np.array_equal(tasks.codes, again) and tasks.codes.dtype == np.int8
    assert "25.5 frames at 100 Hz" in tasks.warnings[0] and tasks.edge == "tool"
    assert len(tasks) == len(drive) and tasks.settings.segment_s == 0.255
    drive.to_frame().to_csv(tmp_path / "v.csv", index=False)
    from_file = identify_tasks(read_velocities(tmp_path / "v.csv"))
    assert np.array_equal(from_file.codes, identify_tasks(drive).codes)
    assert list(from_file.to_frame()["task"].unique()[:1]) == ["static"]


@pytest.mark.parametrize("codes", [[0, 1, 3], [0, 1, -1], [0.5, 1, 2], ["a"], [np.nan]])
def test_letters_that_are_none_are_refused(codes):
    good = np.ones(len(codes), np.int8)
    with pytest.raises(InputError, match=r"symbols.radius"):
        Symbols(good, good, good, codes)


# The bundled recording


@pytest.fixture(scope="module")
def court():
    folder = recordings_folder() / "wheelchair_court"
    static, straight, trial = (
        read_recording(folder / f"{name}.csv.gz") for name in ("static", "straight", "court")
    )
    geometry = WheelchairGeometry.from_toml(folder / "geometry.toml")
    found = estimate_velocity(trial, geometry, calibrate_mount(static, straight).mount)
    return found, pd.read_csv(folder / "truth.csv.gz")


def test_velocities_of_the_bundled_recording(court):
    found, truth = court
    # gyro bias 0.003 and noise 0.003 rad/s (1 sd each): 0.3 m of wheel, 57.3 deg
    assert np.abs(found.linear_velocity_mps - truth["linear_velocity_mps"]).max() < 0.01
    yaw = np.rad2deg(found.yaw_rate_radps)
    assert np.abs(yaw - truth["yaw_rate_degps"]).max() < 57.3 * 0.003 * 7
    assert not found.slip.any()


def test_tasks_of_the_bundled_recording_are_right_away_from_the_changes(court):
    found, truth = court
    codes = task_codes(found.linear_velocity_mps, found.yaw_rate_radps, 100)
    assert set(codes) == set(Task)
    # A change takes 0.8 s, and step 4 looks 0.30 s further than a segment of 0.25 s sees: from
    # 0.7 s on either side of a programmed change every frame is the driven task.
    ends = np.cumsum([leg.duration_s for leg in COURT])[:-1]
    far = np.abs(truth["time_s"].to_numpy()[:, None] - ends).min(axis=1) > 0.7
    assert np.array_equal(codes[far], truth["task_code"][far])
    assert far.mean() > 0.5
    assert (codes == truth["task_code"]).mean() > 0.9


def test_three_combinations_of_table_2_are_open():
    # velocity b, speed c, yaw rate b, with any of the three letters of the radius
    assert open_combinations() == 3


def test_tasks_of_a_drive_are_valid_where_its_velocities_are():
    """Frames within a segment of 0.25 s of what is not known have windows that hold some of it."""
    time_s = np.arange(600) / 100
    valid = (time_s < 2) | (time_s >= 3)
    drive = VelocitySeries(time_s, np.sin(time_s), 0 * time_s, 100.0, valid)
    found = identify_tasks(drive)
    assert np.array_equal(found.valid, (time_s < 1.755) | (time_s > 3.235))
    assert any("not valid for 1.0 of 6.0 s (2.00 to 2.99 s)" in text for text in found.warnings)
    whole = identify_tasks(replace(drive, valid=None))
    assert whole.valid.all() and not any("not valid" in text for text in whole.warnings)
    assert np.array_equal(whole.codes, found.codes)
    figure = chronogram(time_s, found.codes, found.linear_velocity_mps, valid=found.valid)
    shares = next(axes.child_axes for axes in figure.axes if axes.child_axes)[0]
    labels = [text.get_text() for text in shares.get_yticklabels()]
    assert sum(int(text.split()[0]) for text in labels) == pytest.approx(75, abs=2)
    assert "crossed out: not known" in figure.axes[-1].get_xlabel()
    plt.close(figure)
