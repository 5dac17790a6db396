"""What simulators are given is checked; what they return is read-only, pickles, and repeats."""

import copy
import dataclasses
import pickle
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.simulation import scooter, walker, wheelchair
from mobility_imu.simulation.levels import DATASHEET, FOOTPRINT, MOUNTS, tilt_run
from mobility_imu.simulation.scooter import reference
from mobility_imu.simulation.sensor import (
    IDEAL,
    MTI_1,
    SensorModel,
    SensorNoise,
    SensorOutput,
    Triad,
    measure,
)
from mobility_imu.simulation.wheelchair import Leg, Mounting, Pushing, SlipEpisode
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.wheelchair.geometry import WheelchairGeometry

CHAIR = WheelchairGeometry.from_degrees(
    19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
)
MOUNTING = wheelchair.random_mounting(1)
SHORT = (walker.Leg(1.0, 0.5),)
SIDE = scooter.COURSES["side"]
GO = (Leg(1, 1.0), Leg(2, 2.0, 1.0), Leg(1, 1.0))


def ride(seed):
    return scooter.simulate_ride(SIDE, seed=seed)


def parked(seed):
    return scooter.simulate_parked(pitch_rad=0.0, bank_rad=0.0, seed=seed)


def drive(seed):
    return wheelchair.simulate_drive(GO, CHAIR, wheelchair.random_mounting(seed), seed=seed)


def court(seed):
    return wheelchair.random_court(seed).drive(MTI_1)


def tilted(seed):
    motion = walker.simulate_tilts(FOOTPRINT, seed=seed, imperfections=walker.REALISTIC)
    return walker.attach_imu(motion, MOUNTS["2"], seed=seed, unit_seed=seed)


def walked(seed):
    motion = walker.simulate_walk(SHORT, seed=seed, imperfections=walker.REALISTIC)
    return walker.attach_imu(motion, MOUNTS["2"], seed=seed, unit_seed=seed)


def measured(seed):
    time_s = np.arange(200) / 200
    still = np.tile([0.0, 0.0, 9.81], (200, 1))
    return measure(
        time_s, still, 0 * still, DATASHEET, sampling_rate_hz=100, seed=seed, unit_seed=seed
    )


MAKERS = (ride, parked, drive, court, tilted, walked, measured)


def contents(result):
    """All arrays of a result, those inside of it too; a mount is none."""
    if isinstance(result, WalkerMount):
        return []
    if isinstance(result, np.ndarray):
        return [result]
    if isinstance(result, dict | type(MOUNTS)):
        return [array for value in result.values() for array in contents(value)]
    if dataclasses.is_dataclass(result):
        values = [getattr(result, field.name) for field in dataclasses.fields(result)]
        return [array for value in values for array in contents(value)]
    return []


def data(result):
    return [array.tobytes() for array in contents(result)]


@pytest.fixture(scope="module", params=MAKERS, ids=lambda make: make.__name__)
def made(request):
    return request.param(1)


# Results.


def test_results_pickle_and_copy(made):
    for again in (pickle.loads(pickle.dumps(made)), copy.copy(made), copy.deepcopy(made)):
        assert type(again) is type(made)
        assert data(again) == data(made)


def test_arrays_of_results_are_read_only_also_after_pickling(made):
    for result in (made, pickle.loads(pickle.dumps(made))):
        arrays = contents(result)
        assert len(arrays) > 2
        assert not any(array.flags.writeable for array in arrays)


def test_results_are_equal_only_to_themselves_and_print_one_line(made):
    assert made == made and made != pickle.loads(pickle.dumps(made))
    assert len({made, made}) == 1
    assert "\n" not in repr(made) and len(repr(made)) < 700


def test_what_a_motion_works_out_is_not_sent_along():
    motion = walker.simulate_walk(SHORT, seed=1)
    before = len(pickle.dumps(motion))
    assert motion.rate_radps is motion.rate_radps
    assert not motion.rate_radps.flags.writeable
    assert motion.arm_per_s2.shape == (len(motion.time_s), 3, 3)
    assert len(pickle.dumps(motion)) == before
    again = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(again.rate_radps, motion.rate_radps)


def test_a_process_pool_gives_the_same_bytes():
    seeds = [(seed,) for seed in (0, 3)]
    with ProcessPoolExecutor(2) as pool:
        for make in (ride, drive, court, tilted, walked):
            here, there = run_all(make, seeds), run_all(make, seeds, pool)
            assert [data(each) for each in here] == [data(each) for each in there], make.__name__


# Seeds.

SEEDED = {
    "ride": lambda seed: ride(seed),
    "parked": lambda seed: parked(seed),
    "scooter": lambda seed: scooter.draw_scooter(seed),
    "driver": lambda seed: scooter.draw_driver(seed),
    "unit of a scooter": lambda seed: scooter.ScooterUnit(unit_seed=seed),
    "drive": lambda seed: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=seed),
    "court": lambda seed: wheelchair.simulate_court(GO, CHAIR, MOUNTING, seed=seed),
    "unit of a court": lambda seed: wheelchair.simulate_court(
        GO, CHAIR, MOUNTING, seed=1, unit_seed=seed
    ),
    "mounting": lambda seed: wheelchair.random_mounting(seed),
    "random court": lambda seed: wheelchair.random_court(seed),
    "tilts": lambda seed: walker.simulate_tilts(FOOTPRINT, seed=seed),
    "walk": lambda seed: walker.simulate_walk(SHORT, seed=seed),
    "tape": lambda seed: walker.measured_geometry(FOOTPRINT, walker.REALISTIC, seed),
    "power-up": lambda seed: walker.attach_imu(
        walker.simulate_walk(SHORT, seed=1), MOUNTS["1"], seed=seed, unit_seed=1
    ),
    "unit": lambda seed: walker.attach_imu(
        walker.simulate_walk(SHORT, seed=1), MOUNTS["1"], seed=1, unit_seed=seed
    ),
    "sensor": lambda seed: measured(seed),
}


@pytest.mark.parametrize("seed", [-1, 1.0, 1.5, "1", None, True, [1]], ids=repr)
@pytest.mark.parametrize("make", SEEDED.values(), ids=SEEDED)
def test_seeds_that_are_none_are_refused(make, seed):
    with pytest.raises(InputError, match=r"seed = .*: expected a whole number of 0 or more"):
        make(seed)


@pytest.mark.parametrize("seed", [np.int64(5), np.uint8(5), 10**30])
@pytest.mark.parametrize("make", SEEDED.values(), ids=SEEDED)
def test_whole_numbers_of_any_kind_are_seeds(make, seed):
    assert data(make(seed)) == data(make(int(seed)))


# Arguments.

IMPOSSIBLE = {
    "no legs": (lambda: wheelchair.simulate_drive((), CHAIR, MOUNTING, seed=0), "legs: none"),
    "no legs of a court": (
        lambda: wheelchair.simulate_court([], CHAIR, MOUNTING, seed=0),
        "legs: none, expected at least one Leg",
    ),
    "legs of a walker": (
        lambda: wheelchair.simulate_drive(SHORT, CHAIR, MOUNTING, seed=0),
        r"legs: got mobility_imu\..*walker.*Leg, expected mobility_imu\..*wheelchair.*Leg",
    ),
    "a sensor without mounting": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, {"frame": MOUNTING["frame"]}, seed=0),
        "mounting: 'left_wheel' is missing",
    ),
    "matrices as mounting": (
        lambda: wheelchair.simulate_court(GO, CHAIR, dict.fromkeys(MOUNTING, np.eye(3)), seed=0),
        r"mounting\['frame'\]: got ndarray, expected Mounting",
    ),
    "arguments exchanged": (
        lambda: wheelchair.simulate_drive(GO, MOUNTING, CHAIR, seed=0),
        "mounting: got WheelchairGeometry, expected Mapping",
    ),
    "push share": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=0, push_share=1.0),
        "push_share = 1",
    ),
    "push rate": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=0, push_rate_hz=0),
        "push_rate_hz = 0",
    ),
    "rate of a drive": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=0, sampling_rate_hz=-5),
        "sampling_rate_hz = -5",
    ),
    "a drive over before the second sample": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=0, sampling_rate_hz=1e-9),
        r"sampling_rate_hz = 1e-09: 0 sample\(s\) in the .* s of the legs, expected at least 2",
    ),
    "a court over before the second sample": (
        lambda: wheelchair.simulate_court(GO, CHAIR, MOUNTING, seed=0, sampling_rate_hz=0.2),
        r"sampling_rate_hz = 0\.2: \d sample\(s\) in the",
    ),
    "transition": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=0, transition_s=0),
        "transition_s = 0",
    ),
    "a sensor model for a drive": (
        lambda: wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=0, noise=MTI_1),
        "expected SensorNoise or IDEAL; simulate_court takes any model",
    ),
    "noise for a court": (
        lambda: wheelchair.simulate_court(GO, CHAIR, MOUNTING, seed=0, model=SensorNoise()),
        "model: got SensorNoise, expected SensorModel",
    ),
    "toe in deg": (
        lambda: wheelchair.simulate_court(GO, CHAIR, MOUNTING, seed=0, toe_rad=2.0),
        r"toe_rad = 2: expected up to pi/4 \(in deg\?\)",
    ),
    "a leg too short to brake in": (
        lambda: wheelchair.simulate_court(
            (Leg(2, 5.0, 3.0), Leg(2, 1.0, 2.9), Leg(1, 1.0)), CHAIR, MOUNTING, seed=0
        ),
        r"leg at 5 s: 1\.00 s are too short to brake in from 2\.9 m/s, expected 2\.90 s",
    ),
    "task": (lambda: Leg(7, 1.0), r"Leg\.task = 7"),
    "duration": (lambda: Leg(1, 0.0), r"Leg\.duration_s = 0"),
    "velocity": (lambda: Leg(2, 1.0, np.nan), r"Leg\.linear_velocity_mps = nan"),
    "slope": (lambda: Leg(2, 1.0, 1.0, slope_deg=50), r"Leg\.slope_deg = 50"),
    "mirror": (lambda: Mounting(np.diag([1.0, 1, -1]), np.zeros(3)), "a mirror"),
    "place": (lambda: Mounting(np.eye(3), np.zeros(2)), "position_m"),
    "pushing": (lambda: Pushing(push_s="0.3"), "push_s = '0.3'"),
    "slip": (lambda: SlipEpisode("left", np.inf, 1.0, 1.0), "start_s = inf"),
    "slips": (lambda: wheelchair.random_court(1, slips=-1), "slips = -1"),
    "share": (lambda: wheelchair.random_court(1, both_wheels_share=2), "both_wheels_share = 2"),
    "toe": (lambda: wheelchair.random_court(1, largest_toe_rad=5), "largest_toe_rad = 5"),
    "noise": (lambda: SensorNoise(acc_sd_mps2=-1), "acc_sd_mps2 = -1"),
    "density": (lambda: Triad(noise_density="1"), "noise_density = '1'"),
    "endless density": (lambda: Triad(noise_density=np.inf), "noise_density = inf"),
    "bits": (lambda: Triad(full_scale=9.0, bits=2.5), "bits = 2.5"),
    "bandwidth": (lambda: Triad(bandwidth_hz=0), "bandwidth_hz = 0"),
    "triad": (lambda: SensorModel(acc=SensorNoise()), "acc = SensorNoise.*expected a Triad"),
    "NaN motion": (
        lambda: measure(
            np.arange(3.0), np.full((3, 3), np.nan), np.zeros((3, 3)), IDEAL,
            sampling_rate_hz=1, seed=0, unit_seed=0,
        ),
        "acc_mps2: not a finite number at row 0",
    ),
    "course by name": (
        lambda: scooter.simulate_ride("side", seed=0),
        "course: got str, expected Course",
    ),
    "no segment": (lambda: scooter.Course("none", ()), "segments: none"),
    "segment": (
        lambda: scooter.Course("x", (scooter.Segment(-1.0),)),
        r"segments\[0\]\.length_m = -1",
    ),
    "grade": (
        lambda: scooter.Course("x", (scooter.Segment(1.0, grade_rad=7.0),)),
        r"grade_rad = 7: expected up to pi/4 \(in deg\?\)",
    ),
    "points": (lambda: SIDE.outline(1), "points = 1"),
    "rate of a ride": (
        lambda: scooter.simulate_ride(SIDE, seed=0, sampling_rate_hz=0),
        "sampling_rate_hz = 0",
    ),
    "too fast a ride": (
        lambda: scooter.simulate_ride(SIDE, seed=0, sampling_rate_hz=2000),
        "faster than the 1000 Hz",
    ),
    "sensor of a ride": (
        lambda: scooter.simulate_ride(SIDE, seed=0, sensor=Triad()),
        "sensor: got Triad, expected SensorModel",
    ),
    "geometry of a ride": (
        lambda: scooter.simulate_ride(SIDE, seed=0, geometry=(0.3, 0.1)),
        "geometry: got tuple, expected ScooterGeometry",
    ),
    "geometry of a parked scooter": (
        lambda: scooter.simulate_parked(pitch_rad=0, bank_rad=0, seed=0, geometry=FOOTPRINT),
        "geometry: got WalkerGeometry, expected ScooterGeometry",
    ),
    "sensor of a parked scooter": (
        lambda: scooter.simulate_parked(pitch_rad=0, bank_rad=0, seed=0, sensor="MTi-1"),
        "sensor: got str, expected SensorModel",
    ),
    "unit of a parked scooter": (
        lambda: scooter.simulate_parked(pitch_rad=0, bank_rad=0, seed=0, unit=3),
        "unit: got int, expected ScooterUnit",
    ),
    "poses as text": (
        lambda: scooter.simulate_parked("50, 0", pitch_rad=0, bank_rad=0, seed=0),
        "settings_rad: expected real numbers, got text",
    ),
    "segments": (
        lambda: scooter.Course("x", 20.0),
        "segments: got float, expected a sequence of Segment",
    ),
    "level by name": (lambda: tilt_run(1, "1", "sensor"), "level: got str, expected Level"),
    **{
        f"{part} of a ride": (
            lambda part=part: scooter.simulate_ride(SIDE, seed=0, **{part: 0.0}),
            f"{part}: got float, expected {kind}",
        )
        for part, kind in (
            ("unit", "ScooterUnit"),
            ("driver", "Driver"),
            ("layout", "Layout"),
            ("ground", "Ground"),
            ("shaking", "Shaking"),
            ("reference", "Reference"),
        )
    },
    "wheelbase": (lambda: scooter.Layout(wheelbase_m=0), "wheelbase_m = 0"),
    "place of an IMU": (lambda: scooter.Layout(body_imu_m=(0.0, 1.0)), "body_imu_m = "),
    "ground": (lambda: scooter.Ground(roughness_m=-1), "roughness_m = -1"),
    "pitch of tactile": (
        lambda: scooter.Ground(tactile_pitch_m=(0.06, 0.05)),
        r"tactile_pitch_m = \(0\.06, 0\.05\): expected \(low, high\)",
    ),
    "vibration": (lambda: scooter.Shaking(vibration_hz=(14.0, 600.0)), "vibration_hz"),
    "magnets": (lambda: scooter.Reference(wheel_magnets=0), "wheel_magnets = 0"),
    "mounting of a unit": (
        lambda: scooter.ScooterUnit((1.0, 2.0, "3")),
        "lever_mounting, z = '3'",
    ),
    "spread of mountings": (
        lambda: scooter.draw_scooter(1, mounting_sd_rad=-1),
        "mounting_sd_rad = -1",
    ),
    "throttle in deg": (lambda: scooter.Driver(throttle_rad=32), r"throttle_rad = 32.*in deg\?"),
    "arms": (lambda: scooter.Driver(arm_hz=np.nan), "arm_hz = nan"),
    "poses": (
        lambda: scooter.simulate_parked([], pitch_rad=0, bank_rad=0, seed=0),
        "settings_rad: expected one pair",
    ),
    "triples": (
        lambda: scooter.simulate_parked([(0, 0, 0)], pitch_rad=0, bank_rad=0, seed=0),
        "settings_rad: expected one pair",
    ),
    "pitch in deg": (
        lambda: scooter.simulate_parked(pitch_rad=5, bank_rad=0, seed=0),
        r"pitch_rad = 5: expected up to pi/4 \(in deg\?\)",
    ),
    "backlash": (lambda: scooter.with_play([], 1.0), "angle_rad: 0 samples"),
    "backlash of vectors": (lambda: scooter.with_play(np.eye(3), 1.0), "one time series"),
    "width of the play": (lambda: scooter.with_play([1.0], -1.0), "width_rad = -1"),
    "no path": (lambda: walker.simulate_walk((), seed=0), "path = .*expected at least one Leg"),
    "path of lengths": (lambda: walker.simulate_walk((10.0,), seed=0), "path = .*Leg"),
    "legs of a chair": (lambda: walker.simulate_walk(GO, seed=0), "path = .*Leg"),
    "time": (lambda: walker.simulate_walk(SHORT, seed=0, duration_s=0), "duration_s = 0"),
    "no time": (
        lambda: walker.simulate_walk(SHORT, seed=0, duration_s=1e-300),
        "duration_s = 1e-300: no step begins",
    ),
    "length": (lambda: walker.Leg(-1.0), "length_m = -1"),
    "turn": (lambda: walker.Leg(1.0, 90.0), r"turn_rad = 90\.0: expected within a full turn"),
    "range": (
        lambda: walker.WalkStyle(length_m=(0.4, 0.3)),
        r"length_m = \(0\.4, 0\.3\): expected \(low, high\) with 0 < low <= high",
    ),
    "number for a range": (lambda: walker.WalkStyle(swing_s=1.0), "swing_s = 1.0"),
    "range for a number": (lambda: walker.WalkStyle(last_still_s=(1, 2)), "last_still_s = "),
    "text in a range": (lambda: walker.TiltStyle(hold_s=("1", "2")), "hold_s = '1'"),
    "imperfection": (lambda: walker.Imperfections(tape_m=None), "tape_m = None"),
    "direction": (
        lambda: walker.simulate_tilts(FOOTPRINT, seed=0, order=("up",)),
        "'up'",
    ),
    "geometry of another": (
        lambda: walker.simulate_tilts(SUZUKI_ET4D, seed=0),
        "geometry: got ScooterGeometry, expected WalkerGeometry",
    ),
    "mount for motion": (
        lambda: walker.attach_imu(MOUNTS["1"], MOUNTS["2"], seed=0, unit_seed=0),
        "motion: got WalkerMount, expected WalkerMotion",
    ),
    "knots of tilts": (
        lambda: walker.simulate_tilts(FOOTPRINT, seed=0).knots(),
        "it has no step",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("make", "message"), IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_what_cannot_be_simulated_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_one_ideal_sensor_serves_everywhere():
    """No noise at all: the same as noise of size zero, and a chair at rest reads gravity."""
    assert wheelchair.IDEAL is IDEAL
    clean, zero = (
        wheelchair.simulate_drive(GO, CHAIR, MOUNTING, seed=2, noise=noise)
        for noise in (IDEAL, SensorNoise())
    )
    assert data(clean) == data(zero)
    rest = clean.recording.sensor("frame").acc_mps2[0]
    up = MOUNTING["frame"].rotation_body_to_imu @ [0, 0, 9.80665]
    assert rest == pytest.approx(up, abs=1e-12)


def test_noise_needs_a_gyroscope():
    with pytest.raises(InputError, match="no gyroscope"):
        SensorNoise().added_to(Imu(np.ones((3, 3))), np.random.default_rng(0))


# Truth.


def test_table_and_knots_of_the_steps():
    motion = walker.simulate_walk(walker.CORRIDOR, seed=1, imperfections=walker.REALISTIC)
    table = motion.step_table()
    assert list(table) == ["lift_s", "place_s", "length_m", "turn_rad"]
    assert table.to_numpy().tolist() == [list(vars(step).values()) for step in motion.steps]
    time_s, way_m = motion.knots()
    assert time_s[0] == motion.steps[0].lift_s
    assert np.array_equal(time_s[1:], table["place_s"])
    # The frame creeps a little (2 mm, sd) between its steps; perfect steps add up to the way.
    assert 0 < way_m[-1] - table["length_m"].sum() < 0.1
    perfect = walker.simulate_walk(walker.CORRIDOR, seed=1)
    assert perfect.knots().way_m[-1] == pytest.approx(10.0, abs=1e-9)
    assert walker.simulate_tilts(FOOTPRINT, seed=0).step_table().shape == (0, 4)


def test_distance_and_path_in_other_axes():
    walk = walker.attach_imu(
        walker.simulate_walk(walker.CORRIDOR, seed=2), MOUNTS["3"], IDEAL, seed=0, unit_seed=0
    )
    assert walk.distance_m == pytest.approx(10.0, abs=1e-6)
    turn = Rotation.from_euler("z", 0.7)
    path, level = walk.path_in_axes(turn.as_matrix() @ walk.rotation_imu_to_world[0])
    assert level == pytest.approx(turn.as_matrix(), abs=1e-12)
    moved = np.array(walk.position_imu_m - walk.position_imu_m[0])
    assert path == pytest.approx(turn.apply(moved), abs=1e-9)
    table = walk.truth()
    assert table["x_m"].iloc[-1] == pytest.approx(10.0, abs=1e-6)
    assert set(table["stationary"]) == {0, 1}


@pytest.mark.parametrize("name", scooter.COURSES)
def test_outlines_join_and_end_where_the_middle_line_does(name):
    """The simulator's own line is summed up in steps of 2 cm, along the slopes.

    A step changes the heading by up to 2 cm of the curvature, which the rest of the way carries on.
    """
    from mobility_imu.simulation.scooter.course import middle_line

    course = scooter.COURSES[name]
    lines = course.outline(30)
    assert len(lines) == len(course.segments) and {line.shape for line in lines} == {(30, 3)}
    for before, after in pairwise(lines):
        assert np.array_equal(before[-1], after[0])
    along = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines]
    assert along == pytest.approx([s.length_m for s in course.segments], rel=1e-3)
    climb = sum(s.length_m * np.sin(s.grade_rad) for s in course.segments)
    assert lines[-1][-1, 2] == pytest.approx(climb, abs=1e-12)
    distance, middle = middle_line(course)
    end = middle[np.searchsorted(distance, course.length_m)]
    heading = 0.02 * max(abs(s.curvature_pm) for s in course.segments)
    shorter = sum(s.length_m * (1 - np.cos(s.grade_rad)) for s in course.segments)
    near = 0.02 + shorter + heading * course.length_m
    assert lines[-1][-1, :2] == pytest.approx(end, abs=near)


def test_a_backlash_is_the_same_by_machine_code_and_without(monkeypatch):
    """Nobody waits for a compiler at the first ride, and the bytes are the same either way."""
    angle = np.cumsum(np.random.default_rng(2).standard_normal(3000))
    found = []
    for wish in ("always", "never"):
        monkeypatch.setenv("MOBILITY_IMU_COMPILE", wish)
        found.append(scooter.with_play(angle, 0.3))
    monkeypatch.setattr(reference, "choose", lambda *_, **__: "plain")
    found.append(scooter.with_play(angle, 0.3))
    assert len({one.tobytes() for one in found}) == 1


def test_a_backlash_moves_only_when_pushed():
    angle = np.sin(np.linspace(0, 12, 500))
    follower = scooter.with_play(angle, 0.4)
    assert np.abs(follower - angle).max() <= 0.2 + 1e-12
    still = np.diff(follower) == 0
    assert 0.1 < still.mean() < 0.6
    assert np.array_equal(scooter.with_play(angle, 0.0), angle)
    every_second = scooter.with_play(angle[::2], 0.4)
    assert np.array_equal(every_second, scooter.with_play(angle[::2].copy(), 0.4))


def test_results_are_of_the_floor():
    assert isinstance(measured(1), SensorOutput) and isinstance(parked(1), Recording)
