"""Wrong arguments at every door: one line that names the argument, and nothing taken in silence."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace

import numpy as np
import pandas as pd
import pytest
from doors import refused

from mobility_imu import datasets, faults, health, offsets, quality, runs, scooter, walker
from mobility_imu import wheelchair as chair
from mobility_imu.datasets.series import longest_run, low_pass
from mobility_imu.executors import check_executor
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
from mobility_imu.unit_changes import find_unit_change
from mobility_imu.walker.tilt_detection import Tilt
from mobility_imu.wheelchair.geometry import WheelPair, printed_yaw_gain
from mobility_imu.wheelchair.outcomes import onset_errors
from mobility_imu.wheelchair.tasks import Symbols, TaskSteps

COUNT = 300
EYE, ONES, TIME_S = np.eye(3), np.ones(COUNT), np.arange(COUNT) / 100
NONE, ALL = np.zeros(COUNT, bool), np.ones(COUNT, bool)
RNG = np.random.default_rng(1)
GYR = RNG.normal(0, 0.002, (COUNT, 3))
ACC = np.tile([0.0, 0.0, 9.81], (COUNT, 1)) + RNG.normal(0, 0.02, (COUNT, 3))
STILL = Recording(TIME_S, {"frame": Imu(ACC, GYR), "left_wheel": Imu(ACC, GYR)})
OFFSETS = offsets.rest_offsets(STILL)
FAULT = faults.Fault("frozen", "frame_gyr", 0.0, NONE, "sentence", repair=lambda told: told)
POSES = np.deg2rad([[30.0, 0.0], [0.0, 20.0], [-30.0, 10.0], [30.0, 20.0]])


def parked():
    """A scooter whose controls are held in four poses, moved in between."""
    each = np.repeat(np.arange(len(POSES)), 200)
    body = np.tile(body_specific_force(0.0, 0.0), (len(each), 1))
    lever = lever_acceleration(body, *POSES[each].T, scooter.SUZUKI_ET4D)
    turning = np.zeros_like(body)
    for change in range(200, len(each), 200):
        turning[change - 10 : change + 10, 0] = 1.0
    sensors = {"lever": Imu(lever, turning), "body": Imu(body, turning)}
    return Recording(np.arange(len(each)) / 100, sensors)


PARKED = parked()
GEOMETRY = scooter.SUZUKI_ET4D
CALIBRATION = scooter.calibrate_mount(PARKED, POSES, GEOMETRY)
WINDOWS = chair.SlipWindows([10, 60], [20, 70])
FRAME = walker.WalkerGeometry(0.6, 0.52)
TURNS = walker.Turns([1.0], [2.0], [1.5], [0], [1])
CODES = np.ones(COUNT, np.int8)
SYMBOLS = Symbols(CODES, CODES, CODES, CODES)
RESULTS = {
    type(one).__name__: one
    for one in (
        CALIBRATION,
        scooter.check_poses(PARKED, POSES, GEOMETRY),
        chair.ChairVelocity(TIME_S, *[ONES] * 3, NONE, ONES, ONES, OFFSETS),
        chair.GeometryCheck(*[0.1] * 5, True, True, *[1.0] * 8, chair.SAMPLE_CHAIR, OFFSETS),
        chair.Pushes([1.0], [1.2], [0.3]),
        chair.SlipReport([0.1], [0.2], [True], [0.3], ("left",), 0.1, 0.1),
        chair.Tasks(TIME_S, CODES, ONES, ONES),
        chair.WheelchairCalibration(
            chair.WheelchairMount(EYE, EYE, EYE), WheelPair(0.1, float("nan")), OFFSETS
        ),
        TaskSteps(SYMBOLS, CODES, CODES, CODES),
        TURNS,
        Tilt("front", slice(0, 9), 4, 0.5),
        walker.TimedUpAndGo(np.arange(5.0), ONES[:4], ONES[:4], [1, 2, 3, 4]),
        walker.Trajectory(TIME_S, ACC, np.tile(EYE, (COUNT, 1, 1)), ALL, ACC, ONES),
        walker.WalkTest(0.0, 1.0, 2.0, 3),
        walker.WalkerCalibration(
            walker.WalkerMount(EYE, np.zeros(3)), ONES[:3], ONES[:3], (0.6, 0.52),
            (Tilt("front", slice(0, 9), 4, 0.5),),
            geometry=FRAME, method="all-samples", form="corrected",
        ),
        walker.WalkingSummary(3, *[0.5] * 9, TURNS),
        FAULT,
        datasets.list_datasets()[0],
    )
}  # fmt: skip
TEXTS = np.array(["a"])
STRANGE = (
    3j, "abc", b"abc", bytearray(b"abc"), object(), dict, {"a": 1}, [[1, 2], [3]], [object()],
    TEXTS, np.zeros((2, 2, 2, 2)), scooter.RideSettings(), (n for n in range(3)),
    pd.DataFrame({"a": [1]}), np.array([object(), None], object),
    np.ma.array([1.0, 2.0], mask=[0, 1]),
)  # fmt: skip


@pytest.mark.parametrize("name", RESULTS)
def test_every_field_of_a_result_is_checked(name):
    result = RESULTS[name]
    for field in fields(result):
        text = isinstance(getattr(result, field.name), str) or field.name == "sha256"
        for value in STRANGE:
            if (text and isinstance(value, str)) or (field.name == "repair" and callable(value)):
                continue  # any text, or any function, may stand there
            if value is TEXTS and field.type.startswith("tuple[str"):
                continue  # several texts may come in an array
            said = refused(lambda f=field, v=value: replace(result, **{f.name: v}))
            assert field.name in said


@pytest.mark.parametrize("name", [n for n, one in RESULTS.items() if hasattr(one, "warnings")])
def test_warnings_are_sentences(name):
    result = RESULTS[name]
    for value in (["odd"], np.array(["odd"]), (np.str_("odd"),), np.array(["odd"], object)):
        found = replace(result, warnings=value).warnings
        assert found == ("odd",) and type(found[0]) is str
    for value in (None, 3, "odd", ("odd", 3), {"odd"}, float("nan"), np.array(5.0)):
        assert "warnings" in refused(lambda v=value: replace(result, warnings=v))


@pytest.mark.parametrize(
    "door",
    [
        lambda given: offsets.common_rest(given, ["frame"]),
        lambda given: offsets.offset_warnings(given, OFFSETS, ["frame"]),
        lambda given: offsets.rest_offsets(given),
        lambda given: offsets.without_offsets(given, OFFSETS),
        find_unit_change,
        health.examine,
        lambda given: health.fault_of(given, "frozen", "frame_gyr", NONE, "odd"),
        lambda given: faults.all_repaired([FAULT], given),
        lambda given: faults.repaired_where_possible([FAULT], given),
        lambda given: faults.with_costs([FAULT], given, lambda told: {}),
        lambda given: faults.with_readings(given, "frame", acc_mps2=ACC),
        lambda given: faults.half_of(given, "frame", "acc"),
        lambda given: faults.interpolated(given, "frame", "acc", NONE),
        lambda given: faults.shifted(given, "frame", 0.1),
        lambda given: faults.turned_back(given, "frame", EYE),
        lambda given: faults.without_offset(given, "frame", np.zeros(3)),
        lambda given: faults.exchanged(given, "frame", "left_wheel"),
        lambda given: scooter.check_poses(given, POSES, GEOMETRY),
        lambda given: scooter.calibrate_mount([given, given], POSES, GEOMETRY),
    ],
)
def test_what_is_no_recording_is_named(door):
    for value in (None, 3, "walk.csv", [STILL], object(), ACC):
        assert "expected Recording" in refused(lambda v=value: door(v))


@pytest.mark.parametrize(
    "door",
    [
        lambda given: offsets.merge_offsets(given, OFFSETS),
        lambda given: offsets.merge_offsets(OFFSETS, given),
        lambda given: offsets.without_offsets(STILL, given),
        lambda given: offsets.offset_warnings(STILL, given, ["frame"]),
        lambda given: replace(RESULTS["ChairVelocity"], offsets=given),
    ],
)
def test_offsets_come_by_their_sensors(door):
    for value in (3, "frame", [OFFSETS], list(OFFSETS.items()), {"frame": None}, {"frame": EYE}):
        refused(lambda v=value: door(v))


@pytest.mark.parametrize("door", [offsets.common_rest, offsets.rest_offsets])
def test_rests_are_found_in_named_sensors_without_the_samples_that_fail(door):
    for value in (3, "frame", [3], [None], [""], np.array(5.0), object(), ["lever"]):
        refused(lambda v=value: door(STILL, v))
    for value in (3, "frame", [ALL], NONE, {"frame": None}, {"frame": True}, {"frame": ALL[1:]},
                  {"frame": 0.5 * ONES}, {"frame": ["a"] * COUNT}, {"other": ALL[1:]}):  # fmt: skip
        assert "skip" in refused(lambda v=value: door(STILL, ["frame"], skip=v))
    found = offsets.rest_offsets(STILL, (name for name in ["frame"]), skip={"left_wheel": ALL})
    assert list(found) == ["frame"]


@pytest.mark.parametrize("rate", [1e308, 10**18])
def test_a_rate_beyond_any_sensor_leaves_no_block_of_rest(rate):
    assert len(offsets.rest_blocks(GYR, ALL, rate).first) == 0
    assert offsets.gyroscope_offset(GYR, ALL, rate) is None
    assert "more than any sensor reads" in refused(lambda: offsets.rest_blocks(1e9 * ACC, ALL, 100))


@pytest.mark.parametrize(
    ("door", "name"),
    [
        (lambda: quality.resolution_of(ACC, skip=3), "skip"),
        (lambda: quality.resolution_of(ACC, skip=NONE[1:]), "skip"),
        (lambda: quality.resolution_of(ACC, skip=["a"] * COUNT), "skip"),
        (lambda: quality.frozen_samples(ACC, 100, follows=None), "follows"),
        (lambda: quality.frozen_samples(ACC, 100, follows="abc"), "follows"),
        (lambda: quality.turned_gravity(ACC[1:], GYR, 100), "gyr_radps"),
        (lambda: quality.turned_gravity(ACC[:, :2], GYR, 100), "acc_mps2"),
        (lambda: quality.smallest_step(["a", "b"]), "axis"),
        (lambda: quality.smallest_step(ACC), "axis"),
        (lambda: runs.runs_of([[1, 2], [3]]), "flags"),
        (lambda: runs.long_runs(ALL, "3", grow=False), "shortest"),
        (lambda: runs.long_runs(ALL, 3, grow=None), "grow"),
        (lambda: runs.changes_of([[1, 2], [3]]), "codes"),
        (lambda: health.samples_lost([FAULT], "9"), "count"),
        (lambda: health.samples_lost([FAULT], COUNT + 1), "flags of a fault"),
        (lambda: health.single_spikes(ACC, None), "least"),
        (lambda: health.stuck_axes(ACC, 100, skip=None), "skip"),
        (lambda: faults.largest_change(ONES, ONES[1:]), "second"),
        (lambda: faults.shifted(STILL, "frame", "0.1"), "lag_s"),
        (lambda: faults.turned_back(STILL, "frame", [1, 2]), "rotation"),
        (lambda: faults.multiplied(STILL, "frame", "acc", [1, 2]), "factors"),
        (lambda: faults.without_offset(STILL, "frame", [1, 2]), "offset_radps"),
        (lambda: faults.interpolated(STILL, "frame", "acc", ALL[1:]), "flags"),
        (lambda: faults.rescaled(STILL, "frame", "acc", ALL[1:], 2.0), "flags"),
        (lambda: faults.rescaled(STILL, "frame", "acc", ALL, float("nan")), "factor"),
        (lambda: faults.half_of(STILL, np.array(["frame", "a"]), "acc"), "sensor"),
        (lambda: faults.all_repaired(np.array(5.0), STILL), "faults"),
        (lambda: faults.all_repaired("ab", STILL), "faults"),
        (lambda: faults.all_repaired({FAULT: 1}, STILL), "faults"),
        (lambda: faults.one_sided("ab"), "fault"),
        (lambda: walker.valid_samples(RESULTS["Trajectory"], np.array(5.0)), "faults"),
        (lambda: replace(FAULT, repair=3), "repair"),
        (lambda: find_unit_change(STILL, np.array(["frame", "a"])), "name"),
        (lambda: printed_yaw_gain(None), "geometry"),
        (lambda: WINDOWS.within("abc"), "count"),
        (lambda: WINDOWS.within(None), "count"),
        (lambda: Symbols([[1, 2], [3]], CODES, CODES, CODES), "symbols.velocity"),
        (lambda: chair.Tasks(3, CODES, ONES, ONES), "time_s"),
        (lambda: chair.ChairVelocity(None, *[ONES] * 3, NONE, ONES, ONES), "time_s"),
        (lambda: onset_errors(CODES, np.ma.array(CODES, mask=ALL), 100), "true_codes"),
        (
            lambda: chair.with_smoothing_sd(
                *[RESULTS["ChairVelocity"]] * 2, chair.SAMPLE_CHAIR,
                chair.WheelchairMount(EYE, EYE, EYE), np.array(["none", "none"]),
            ),
            "method",
        ),
        (lambda: scooter.ScooterMount(EYE, EYE).to_toml(sd_rad=-ONES[:6]), "sd_rad"),
        (lambda: scooter.pose_uncertainty(POSES, GEOMETRY, pitch_rad=20.0), "pitch_rad"),
        (lambda: scooter.pose_uncertainty(np.rad2deg(POSES), GEOMETRY), "poses_rad"),
        (lambda: low_pass("abc", 5, 100), "values"),
        (lambda: low_pass(ONES, 50, 100), "cutoff_hz"),
        (lambda: low_pass(ONES, 5, 0), "rate_hz"),
        (lambda: low_pass(ONES[:9], 5, 100), "values"),
        (lambda: longest_run([[1, 2], [3]]), "flags"),
        (lambda: datasets.fetch_dataset("one-hinge", progress=3), "progress"),
    ],
)  # fmt: skip
def test_the_argument_is_named(door, name):
    assert re.match(rf"(\w+\.|windows: )?{name}", refused(door))


@pytest.mark.parametrize("door", [scooter.check_poses, scooter.calibrate_mount])
def test_poses_in_degrees_are_refused(door):
    """A whole turn is more than any control makes; 6 deg and less are poses in rad as well."""
    said = refused(lambda: door(PARKED, np.rad2deg(POSES), GEOMETRY))
    assert said.startswith("settings of the poses: an angle is 30, ") and "in deg" in said


def test_wanted_sensors_come_in_a_list(tmp_path):
    path = tmp_path / "walk.csv"
    STILL.to_frame().to_csv(path, index=False)
    for value in (None, 3, "frame", b"frame", {"frame"}, [3], [""], np.array(5.0), object()):
        assert refused(lambda v=value: read_recording(path, expected=v)).startswith("expected: ")
    for value in (["frame"], np.array(["frame"]), (name for name in ["frame"])):
        assert "frame" in read_recording(path, expected=value).sensors


@pytest.mark.parametrize(
    "door",
    [
        lambda pool: check_executor(pool),
        lambda pool: scooter.estimate_ride([PARKED], GEOMETRY, executor=pool),
        lambda pool: scooter.estimate_ride(PARKED, GEOMETRY, executor=pool),
        lambda pool: chair.estimate_velocity(
            [STILL], chair.SAMPLE_CHAIR, chair.WheelchairMount(EYE, EYE, EYE), executor=pool
        ),
        lambda pool: walker.estimate_trajectory(
            [STILL], FRAME, walker.WalkerMount(EYE, np.zeros(3)), executor=pool
        ),
    ],
)
def test_the_class_of_an_executor_is_none(door):
    assert refused(lambda: door(ThreadPoolExecutor)).startswith("executor = <class ")
