"""Wrong arguments at the simulators, the recordings and the helpers that all devices share."""

import os
from dataclasses import fields, is_dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from doors import refused
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from matplotlib.figure import Figure

from mobility_imu import files, filters, frames, hinges, rotations
from mobility_imu.executors import run_all
from mobility_imu.fields import check_fields
from mobility_imu.names import as_names
from mobility_imu.recording import Imu, Recording
from mobility_imu.results import read_only
from mobility_imu.scooter import SUZUKI_ET4D, RideAngles, RideSettings, angles, geometry, pulses
from mobility_imu.scooter.ride import Remark
from mobility_imu.simulation import disturbances, faults, levels, scooter, sensor, walker
from mobility_imu.simulation import wheelchair as chair
from mobility_imu.wheelchair.geometry import SAMPLE_CHAIR

COUNT = 300
TIME_S, ONES = np.arange(COUNT) / 100, np.ones(COUNT)
RNG = np.random.default_rng(1)
GYR = RNG.normal(0, 0.002, (COUNT, 3))
ACC = np.tile([0.0, 0.0, 9.81], (COUNT, 1)) + RNG.normal(0, 0.02, (COUNT, 3))
STILL = Recording(TIME_S, {"frame": Imu(ACC, GYR), "other": Imu(ACC, GYR)})
LEVER = geometry.lever_acceleration(ACC, 0.1, 0.1, SUZUKI_ET4D)
GO = (chair.Leg(1, 1.0), chair.Leg(2, 2.0, 1.0), chair.Leg(1, 1.0))
MOUNTING = chair.random_mounting(1)
MOTION = walker.simulate_tilts(levels.FOOTPRINT, seed=1, order=("front",))
COLUMN = hinges.column_vector(ACC, 0.3)
NOWHERE = Path(os.devnull)
RESULTS = (
    STILL,
    angles.estimate_angles(LEVER, ACC, SUZUKI_ET4D),
    sensor.SensorOutput(TIME_S, TIME_S, Imu(ACC, GYR)),
    sensor.REAL,
    levels.REAL_LEVEL,
    scooter.SimulatedRide(STILL, ONES, ONES, ACC[:, :2], TIME_S, ONES[:3], ONES[:3], ONES),
    scooter.Course("flat", (scooter.Segment(2.0),)),
    scooter.Shaking(),
    scooter.Layout(),
    scooter.ScooterUnit(),
    MOTION,
    MOTION.tilts[0],
    walker.StepTruth(0.0, 1.0, 0.3, 0.0),
    walker.attach_imu(MOTION, levels.MOUNTS["1"], seed=1, unit_seed=1),
    chair.simulate_drive(GO, SAMPLE_CHAIR, MOUNTING, seed=1),
    chair.simulate_court(GO, SAMPLE_CHAIR, MOUNTING, seed=1),
    chair.random_court(1),
)
STRANGE = (
    3j, "abc", b"abc", bytearray(b"abc"), object(), dict, {"a": 1}, [[1, 2], [3]], [object()],
    np.array([3j]), np.zeros((2, 2, 2, 2)), (n for n in range(3)), np.datetime64("2020"), {1, 2},
    np.array([object(), None], object), np.ma.array([1.0, 2.0], mask=[0, 1]),
)  # fmt: skip
WORDS = {"source", "name", "text", "path"}


@pytest.mark.parametrize("result", RESULTS, ids=lambda one: type(one).__name__)
def test_every_field_is_checked(result):
    for field in fields(result):
        for value in STRANGE:
            if field.name in WORDS and isinstance(value, str):
                continue
            said = refused(lambda f=field, v=value: replace(result, **{f.name: v}))
            assert field.name.rstrip("s") in said or is_dataclass(getattr(result, field.name))


PART = {"recording": STILL, "sensor": "frame"}
HALF = {**PART, "half": "acc"}
DOORS = {
    faults.freeze: {**HALF, "start_s": 0.5, "length_s": 0.5},
    faults.silence: {**PART, "start_s": 0.5},
    faults.clip: {**HALF, "limit": 9.9},
    faults.spike: {**HALF, "samples": [3, 4], "axis": 1, "size": 2.0},
    faults.offset: {**HALF, "vector": [0.1, 0.1, 0.1]},
    faults.scale: {**HALF, "factors": [1.1, 1.0, 1.0]},
    faults.reverse: {**PART, "signs": [-1, 1, 1]},
    faults.late: {**PART, "lag_s": 0.1},
    faults.late_half: {**HALF, "lag_s": 0.1},
    faults.exchange: {"recording": STILL, "first": "frame", "second": "other"},
    faults.left_handed: {**PART, "axis": 1},
    faults.turn: {**PART, "rotation": np.eye(3)},
    faults.tip: {**PART, "axis": [1, 0, 0], "angle_rad": 0.3, "start_s": 0.5, "length_s": 0.5},
    faults.jump: {"recording": STILL, "start_s": 0.5, "length_s": 0.001},
    sensor.without: {"model": sensor.REAL},
    sensor.SensorNoise().added_to: {"imu": Imu(ACC, GYR), "rng": RNG},
    disturbances.AT_ONCE.taken: {"time_s": TIME_S, "rng": RNG},
    disturbances.AT_ONCE.arrived: {"readings": [ACC], "rng": RNG},
    partial(disturbances.vibration, sensor.REAL.vibration): {
        "speed_share": ONES, "sampling_rate_hz": 100.0, "rng": RNG,
    },
    partial(levels.tilt_run, 1, "2", levels.REAL_LEVEL): {"motion": MOTION},
    chair.SlipEpisode("left", 0.1, 0.5, 1.0).profile: {"time_s": TIME_S},
    STILL.sensor: {"name": "frame", "gyroscope": True},
    STILL.gyroscope: {"name": "frame"},
    frames.as_vectors: {"values": ACC, "name": "x", "ndim": 2, "length": COUNT, "finite": True},
    frames.as_series: {"values": ONES, "name": "x", "length": COUNT},
    frames.as_clock: {"time_s": TIME_S, "even": True},
    partial(frames.as_flags, ONES, "x"): {"length": COUNT},
    partial(frames.as_rotation, np.eye(3), "x"): {"tolerance": 1e-3},
    partial(frames.as_number, 1.0, "x"): {"zero": True, "negative": True, "infinite": True},
    partial(frames.as_count, 3, "x"): {"least": 1},
    partial(as_names, ["a"], "x"): {"ordered": True},
    hinges.column_vector: {"body": ACC, "alpha_rad": 0.3},
    hinges.steered: {"column": COLUMN, "steering_rad": ONES},
    rotations.elementary_rotation: {"axis": "x", "angle_rad": ONES},
    angles.throttle_angle: {
        "lever_acc_mps2": LEVER, "body_acc_mps2": ACC, "steering_rad": ONES,
        "geometry": SUZUKI_ET4D,
    },
    angles.angle_standard_deviations: {
        "lever_acc_mps2": LEVER, "steering_rad": ONES, "throttle_rad": ONES,
        "geometry": SUZUKI_ET4D, "lever_sd_mps2": 0.1,
    },
    geometry.rotation_lever_base_to_steering: {
        "steering_inclination_rad": 0.3, "lever_inclination_rad": 0.1,
    },
    geometry.rotation_lever_to_lever_base: {"throttle_rad": ONES},
    geometry.lever_acceleration: {
        "body_acc_mps2": ACC, "steering_rad": ONES, "throttle_rad": ONES, "geometry": SUZUKI_ET4D,
    },
    geometry.body_specific_force: {"pitch_rad": ONES, "roll_rad": ONES, "gravity_mps2": 9.8},
    pulses.reference_angles: {
        "time_s": TIME_S, "reference_time_s": TIME_S, "reference_rad": ACC, "offset_s": 0.1,
    },
    partial(files.write_text, NOWHERE): {"text": "abc"},
    partial(files.csv_bytes, pd.DataFrame({"a": [1.0]})): {"path": Path("a.csv")},
}  # fmt: skip
SHAPELESS = {"angle_rad", "pitch_rad", "roll_rad", "throttle_rad", "steering_inclination_rad"}
SHAPELESS |= {"lever_inclination_rad", "time_s"}


@pytest.mark.parametrize("door", DOORS, ids=lambda door: getattr(door, "func", door).__qualname__)
def test_every_argument_is_checked(door):
    valid = DOORS[door]
    if "text" not in valid:
        door(**valid)
    for name in valid:
        for value in STRANGE:
            if name in SHAPELESS and getattr(value, "ndim", 0) == 4:
                continue  # of any shape
            if name == "text" and isinstance(value, str):
                continue
            if name == "name" and "values" in valid:
                continue  # what the message begins with
            refused(lambda n=name, v=value: door(**{**valid, n: v}))


@pytest.mark.parametrize(
    ("door", "said"),
    [
        (lambda: faults.freeze(STILL, "frame", "acc", 7.0, 1.0), "start_s = 7: the recording is"),
        (lambda: faults.spike(STILL, "frame", "acc", [COUNT], 1, 2.0), "samples = [300]"),
        (lambda: faults.spike(STILL, "frame", "acc", [-1], 1, 2.0), "indices from 0 to 299"),
        (lambda: faults.spike(STILL, "frame", "acc", [0.5], 1, 2.0), "samples = [0.5]"),
        (lambda: faults.spike(STILL, "frame", "acc", [3], 3, 2.0), "axis = 3: expected 0, 1 or 2"),
        (lambda: faults.reverse(STILL, "frame", [1, 1, 0.5]), "signs = "),
        (lambda: faults.late(STILL, "frame", 1e308), "lag_s = 1e+308"),
        (lambda: faults.tip(STILL, "frame", [0, 0, 0], 0.3, 0.5, 0.5), "axis: of length 0"),
        (lambda: sensor.without(sensor.REAL, "__class__"), "'__class__' is not an error"),
        (lambda: sensor.measure(TIME_S, ACC, GYR, None, sampling_rate_hz=9, seed=1, unit_seed=1),
         "model: got NoneType, expected SensorModel"),
        (lambda: scooter.Course("x", (scooter.Segment(1.0, tactile="no"),)), "[0].tactile = 'no'"),
        (lambda: scooter.Course("x", (scooter.Segment(1.0),)).outline(10**400), "points = "),
        (lambda: scooter.Shaking(vibration_hz=(14.0, "22")), "vibration_hz = '22'"),
        (lambda: scooter.Shaking(vibration_hz=(300.0, 200.0)), "two positive numbers <= 250"),
        (lambda: scooter.Shaking(vibration_hz=np.array([14.0, 22.0])), "<= 250, as a tuple"),
        (lambda: walker.WalkStyle(length_m=np.array([0.3, 0.4])), "0 < low <= high, as a tuple"),
        (lambda: replace(RESULTS[-3], task=np.full(len(RESULTS[-3].task), 0.5)), "task: sample 0"),
        (lambda: replace(RESULTS[-3], task=np.full(len(RESULTS[-3].task), 7)), "task: sample 0"),
        (lambda: walker.Leg([1.0]), "length_m = [1.0]"),
        (lambda: sensor.Triad(bandwidth_hz=1e-9), "Triad.bandwidth_hz = 1e-09: expected between"),
        (lambda: scooter.Ground(roughness_m=1e308), "Ground.roughness_m = 1e+308"),
        (lambda: scooter.Driver(arm_hz=1e9), "Driver.arm_hz = 1000000000.0"),
        (lambda: scooter.Layout(wheelbase_m=1e9), "Layout.wheelbase_m = 1000000000.0"),
        (lambda: scooter.Reference(wheel_radius_m=1e-9), "Reference.wheel_radius_m = 1e-09"),
        (lambda: scooter.Course("x", (scooter.Segment(1e9),)), "[0].length_m = 1e+09"),
        (lambda: scooter.Course("x", (scooter.Segment(1.0, 1e9),)), "[0].curvature_pm = 1e+09"),
        (lambda: walker.Imperfections(hold_tremor_rad=1e9), "Imperfections.hold_tremor_rad = "),
        (lambda: walker.WalkStyle(length_m=(1e-9, 0.3)), "length_m = (1e-09, 0.3)"),
        (lambda: walker.WalkStyle(turn_step_rad=1e-9), "WalkStyle.turn_step_rad = 1e-09"),
        (lambda: walker.WalkStyle(first_still_s=1e9), "first_still_s = 1e+09: expected up to"),
        (lambda: walker.TiltStyle(hold_s=(1.0, 1e9)), "hold_s = (1.0, 1000000000.0)"),
        (lambda: walker.Leg(1e9), "length_m = 1e+09"),
        (lambda: chair.Leg(2, 1e9), "Leg.duration_s = 1000000000.0"),
        (lambda: chair.Pushing(push_s=1e-9), "Pushing.push_s = 1e-09"),
        (lambda: chair.simulate_court(GO, SAMPLE_CHAIR, MOUNTING, seed=1, slips=""), "slips: got"),
        (lambda: run_all(None, [(2, 3)]), "function = None: expected a function"),
        (lambda: run_all(pow, None), "arguments: got None"),
        (lambda: run_all(pow, [3]), "arguments: 3 among them"),
        (lambda: frames.one_of("x", "a", 3), "choices: got int"),
        (lambda: read_only([1.0]), "array: got list"),
        (lambda: filters.savitzky_golay(np.full(9, np.nan), 5, 2), "not finite"),
        (lambda: files.csv_bytes(None, NOWHERE), "table: got NoneType"),
        (lambda: files.csv_bytes(pd.DataFrame, NOWHERE), "table: got the class DataFrame itself"),
        (lambda: files.figure_bytes(Figure, NOWHERE), "figure: got the class Figure itself"),
        (lambda: files.Outputs(["a.csv"]), "files: got list"),
        (lambda: files.Outputs({"-o": "a.csv"}), "files: got str"),
        (lambda: files.Outputs({}, inputs=("a.csv",)), "inputs: got str"),
        (lambda: files.Outputs({}, folder="a"), "folder: got str"),
        (lambda: hinges.steered(COLUMN, ONES[1:]), "steering_rad (299,)"),
        (lambda: geometry.lever_acceleration(ACC, ONES[1:], 0.1, SUZUKI_ET4D),
         "body_acc_mps2 (300,), steering_rad (299,), throttle_rad ()"),
        (lambda: angles.throttle_angle(LEVER, ACC, ONES[1:], SUZUKI_ET4D),
         "lever_acc_mps2 (300,), body_acc_mps2 (300,), steering_rad (299,)"),
        (lambda: angles.angle_standard_deviations(
            LEVER, ONES, ONES[1:], SUZUKI_ET4D, lever_sd_mps2=0.1), "throttle_rad (299,)"),
        (lambda: angles.ScooterAngles(ONES, ONES[1:], ONES > 0), "ScooterAngles.throttle_rad"),
        (lambda: angles.ScooterAngles(ONES, ONES, ONES[1:]), "ScooterAngles.valid"),
        (lambda: angles.ScooterAngles(ONES, ONES, ONES * np.nan), "ScooterAngles.valid"),
        (lambda: angles.estimate_angles(
            LEVER.reshape(3, 100, 3), None, SUZUKI_ET4D).to_frame(), "(3, 100)"),
    ],
)  # fmt: skip
def test_the_argument_is_named(door, said):
    assert said in refused(door)


LONG = 3 * (chair.Leg(2, 20_000.0, 1.0),)
SLOW = walker.WalkStyle(swing_s=(30_000.0, 36_000.0))
QUICK = walker.WalkStyle(swing_s=(1e-9, 1e-9), stance_s=(1e-9, 1e-9))
PARTS = (scooter.Segment(9_000.0), scooter.Segment(2_000.0))


@pytest.mark.parametrize(
    ("door", "said"),
    [
        (lambda: chair.simulate_drive(LONG, SAMPLE_CHAIR, MOUNTING, seed=1), "60000 s of the legs"),
        (lambda: chair.simulate_court(LONG, SAMPLE_CHAIR, MOUNTING, seed=1), "60000 s of the legs"),
        (lambda: chair.simulate_drive(GO, SAMPLE_CHAIR, MOUNTING, seed=1, sampling_rate_hz=1e4),
         None),
        (lambda: chair.simulate_drive(LONG[:1], SAMPLE_CHAIR, MOUNTING, seed=1,
                                      sampling_rate_hz=1e5), "sampling_rate_hz = 100000"),
        (lambda: walker.simulate_walk(9 * (walker.Leg(900.0),), seed=1), "expected up to 40000 s"),
        (lambda: walker.simulate_walk([walker.Leg(1.0)], seed=1, style=SLOW), "up to 40000 s"),
        (lambda: walker.simulate_walk([walker.Leg(1e3)], seed=1, style=QUICK, duration_s=9e3),
         "more than 1100000 steps"),
        (lambda: walker.simulate_walk(70 * (walker.Leg(1e4),), seed=1), "more than 1100000 steps"),
        (lambda: walker.simulate_walk([walker.Leg(1e4)], seed=1, duration_s=9.0), None),
        (lambda: walker.simulate_tilts(
            levels.FOOTPRINT, seed=1, order=("front",) * 2,
            style=walker.TiltStyle(hold_s=(30_000.0, 36_000.0))), "expected up to 40000 s"),
        (lambda: scooter.simulate_ride(scooter.Course("x", PARTS), seed=1), "course: 11000 m"),
        (lambda: scooter.simulate_parked(
            np.zeros((1000, 2)), pitch_rad=0, bank_rad=0, seed=1), "settings_rad: 1000 poses"),
    ],
)  # fmt: skip
def test_parts_that_are_right_may_be_too_many(door, said):
    """Each part is within its limits; a sum that no memory holds is refused before it is made."""
    assert said in refused(door) if said else door()


@pytest.mark.parametrize("size", [2.0**-1070, 2.0**-700, 2.0**700])
def test_the_length_of_an_axis_does_not_matter(size):
    tipped = [
        faults.tip(STILL, "frame", axis, 0.3, 0.5, 0.5).sensor("frame")
        for axis in ([1.0, 0, 1.0], [size, 0, size])
    ]
    assert np.array_equal(tipped[0].acc_mps2, tipped[1].acc_mps2)
    assert np.array_equal(tipped[0].gyr_radps, tipped[1].gyr_radps)
    assert not np.allclose(tipped[1].acc_mps2[-1], STILL.sensor("frame").acc_mps2[-1])


def test_what_is_right_is_taken():
    def remarked(remarks):
        return RideAngles(TIME_S, *[ONES] * 4, ONES > 0, RideSettings(), remarks)

    said = Remark("estimate", "", "odd")
    assert remarked([said]).remarks == (said,) and remarked([said]).warnings == ("odd",)
    assert "remarks" in refused(lambda: remarked(said))
    court = replace(RESULTS[-1])
    object.__setattr__(court, "toe_rad", np.True_)
    check_fields(court, toe_rad=bool)
    assert court.toe_rad is True and frames.one_of("x", np.False_, (True, False)) is False
    assert "grow" in refused(lambda: frames.one_of("grow", 1, (True, False)))
    assert scooter.Shaking(vibration_hz=(22.0, 14.0)).vibration_hz == (22.0, 14.0)
    one = angles.estimate_angles(LEVER[0], None, SUZUKI_ET4D)
    assert np.shape(one.valid) == () and len(one.to_frame()) == 1
    many = angles.estimate_angles(LEVER.reshape(3, 100, 3), ACC[:100], SUZUKI_ET4D)
    assert many.valid.shape == (3, 100)
    assert angles.ScooterAngles([0.1], [0.2], [True]).steering_rad.shape == (1,)


@st.composite
def tables(draw):
    """A table as a command may write it, of numbers and words."""
    rows, columns = draw(st.integers(0, 5)), draw(st.integers(0, 4))
    kinds = st.sampled_from(("float64", "float64", "int8", "int64", "bool", "object", "float32"))
    words = st.text(max_size=5) | st.sampled_from(("a,b", '"q"', "é\n", "nan", ""))
    found = {}
    for column in range(columns):
        kind = draw(kinds)
        text = st.lists(words, min_size=rows, max_size=rows)
        values = draw(text if kind == "object" else arrays.arrays(kind, rows))
        found[column] = pd.Series(values, dtype=kind)
    table = pd.DataFrame(found)
    table.columns = draw(st.lists(words, min_size=columns, max_size=columns))
    return table.iloc[::-1] if draw(st.booleans()) else table


@settings(max_examples=150, deadline=None)
@given(tables())
def test_tables_are_written_as_pandas_writes_them(table):
    written = files.csv_bytes(table, Path("a.csv"))
    assert written == table.to_csv(index=False, float_format="%.6f").encode()


def test_a_long_table_is_written_as_pandas_writes_it(monkeypatch):
    monkeypatch.setattr(files, "ROWS_AT_ONCE", 7)
    edge = np.array([np.nan, np.inf, -np.inf, -0.0, 1e300, 5e-324, 0.0000005, 1 / 3])
    table = pd.DataFrame({"nan": np.tile(edge, 4), "b": np.arange(32), "c": np.arange(32) > 9})
    expected = table.to_csv(index=False, float_format="%.6f").encode()
    monkeypatch.setattr(pd.DataFrame, "to_csv", lambda table, **_: ",".join(table) + "\n")
    assert files.csv_bytes(table, Path("a.csv")) == expected  # pandas gave the head alone
