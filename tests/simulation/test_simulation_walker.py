"""Walker simulator: what must hold of its physics, its courses and each imperfection."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.simulation.sensor import IDEAL, MTI_1, without
from mobility_imu.simulation.walker import (
    CORRIDOR,
    FAST_HZ,
    OUT_AND_BACK_30,
    PERFECT,
    REALISTIC,
    RECTANGLE,
    RECTANGLE_OPEN,
    TIMED_UP_AND_GO,
    Imperfections,
    Leg,
    TiltStyle,
    WalkStyle,
    attach_imu,
    measured_geometry,
    simulate_tilts,
    simulate_walk,
)
from mobility_imu.walker.geometry import TILT_DIRECTIONS, WalkerGeometry
from mobility_imu.walker.mount import WalkerMount

G = 9.80665
FRAME = WalkerGeometry(0.60, 0.52)
MOUNT = WalkerMount(
    Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix(), np.array([0.46, -0.21, 0.63])
)
TIPS = np.array([[0.52, 0.3, 0], [0.52, -0.3, 0], [0, -0.3, 0], [0, 0.3, 0]])
EDGES = {"front": [0, 1], "back": [2, 3], "right": [1, 2], "left": [0, 3]}
SIDES = {"front": (1, 0), "back": (-1, 0), "right": (0, -1), "left": (0, 1)}
PATHS = {
    "corridor": CORRIDOR,
    "rectangle": RECTANGLE,
    "open": RECTANGLE_OPEN,
    "tug": TIMED_UP_AND_GO,
}


@cache
def tilts(seed=1, **sizes):
    return simulate_tilts(FRAME, seed=seed, imperfections=Imperfections(**sizes))


@cache
def walk(name="corridor", seed=1, **sizes):
    return simulate_walk(PATHS[name], seed=seed, imperfections=Imperfections(**sizes))


def ideal(motion, rate_hz=100.0):
    return attach_imu(motion, MOUNT, IDEAL, seed=0, unit_seed=0, sampling_rate_hz=rate_hz)


def places(motion, points):
    """World positions (m, k, 3) of points of the body."""
    turned = np.einsum("nij,kj->nki", motion.rotation_body_to_world, points)
    return motion.position_m[:, None] + turned


def during(motion, start_s, stop_s):
    return (motion.time_s >= start_s) & (motion.time_s <= stop_s)


def heading(motion):
    turn = motion.rotation_body_to_world
    return np.arctan2(turn[:, 1, 0], turn[:, 0, 0])


def strapdown(run, *, true_attitude=False):
    """Path of the IMU from its readings; sample k holds over half a step either side."""
    imu, dt = run.recording.sensors["frame"], 1 / run.recording.sampling_rate_hz
    turns = Rotation.from_rotvec(imu.gyr_radps * dt).as_matrix()
    halves = Rotation.from_rotvec(imu.gyr_radps * dt / 2).as_matrix()
    attitude = run.rotation_imu_to_world[0]
    velocity, position = np.zeros(3), run.position_imu_m[0]
    for k in range(len(turns)):
        middle = run.rotation_imu_to_world[k] if true_attitude else attitude @ halves[k]
        later = velocity + dt * (middle @ imu.acc_mps2[k] - [0, 0, G])
        position = position + dt * (velocity + later) / 2
        velocity = np.zeros(3) if run.stationary[k] else later
        attitude = attitude @ turns[k]
    return position, attitude


@pytest.mark.parametrize("seed", range(3))
def test_the_turning_edge_stays_on_the_floor(seed):
    """Both its tips do not move at all (1e-12 m: rounding); the other two are above the floor."""
    motion = tilts(seed)
    tips = places(motion, TIPS)
    for tilt in motion.tilts:
        now = during(motion, tilt.start_s, tilt.stop_s)
        edge = EDGES[tilt.direction]
        others = [k for k in range(4) if k not in edge]
        assert np.abs(tips[now][:, edge] - tips[0, edge]).max() < 1e-12
        assert tips[now][:, others, 2].min() > -1e-12
        assert tips[now][:, others, 2].max() > 0.52 * np.sin(np.deg2rad(19))


def test_top_of_the_frame_goes_to_the_named_side():
    motion = tilts()
    top = places(motion, np.array([[0.26, 0.0, 0.8]]))[:, 0, :2]
    assert [tilt.direction for tilt in motion.tilts] == list(TILT_DIRECTIONS)
    for tilt in motion.tilts:
        held = during(motion, tilt.held_from_s, tilt.held_until_s)
        moved = top[held].mean(axis=0) - top[0]
        assert np.allclose(moved / np.linalg.norm(moved), SIDES[tilt.direction], atol=1e-9)


def test_tilts_reach_their_angle_and_hold_it():
    motion = tilts()
    style = TiltStyle()
    ends = [0.0]
    for tilt in motion.tilts:
        held = during(motion, tilt.held_from_s, tilt.held_until_s)
        size = Rotation.from_matrix(motion.rotation_body_to_world[held]).magnitude()
        assert np.allclose(size, tilt.angle_rad, atol=1e-12)
        assert style.angle_rad[0] <= tilt.angle_rad <= style.angle_rad[1]
        assert 1.0 <= tilt.held_from_s - tilt.start_s <= 1.6
        assert 0.7 <= tilt.held_until_s - tilt.held_from_s <= 1.3
        assert 1.0 <= tilt.stop_s - tilt.held_until_s <= 1.6
        assert tilt.start_s - ends[-1] >= 1.5
        ends.append(tilt.stop_s)
    assert motion.tilts[0].start_s >= 2.5 and motion.time_s[-1] - ends[-1] >= 1.5
    assert np.allclose(motion.rotation_body_to_world[motion.stationary], np.eye(3), atol=1e-12)
    assert np.abs(motion.position_m[motion.stationary]).max() < 1e-12


def test_order_may_be_any():
    motion = simulate_tilts(FRAME, seed=0, order=("back", "right"))
    assert [tilt.direction for tilt in motion.tilts] == ["back", "right"]


@pytest.mark.parametrize("motion", [tilts(), walk()], ids=["tilts", "walk"])
def test_a_resting_imu_reads_gravity_through_its_mount(motion):
    """First two seconds: 9.80665 m/s² along the IMU's own direction of up, no rate."""
    run = ideal(motion)
    imu, start = run.recording.sensors["frame"], run.time_s < 2
    up = MOUNT.rotation_imu_to_body.T @ [0, 0, G]
    assert np.allclose(imu.acc_mps2[start], up, atol=1e-9)
    assert np.abs(imu.gyr_radps[start]).max() < 1e-9
    assert run.stationary[start].all()


def test_forces_at_100_hz_give_the_path():
    """Along 10 m, with the true attitude: 1e-4 m, a fortieth of what a good sensor's noise does."""
    run = ideal(walk())
    assert np.linalg.norm(strapdown(run, true_attitude=True)[0] - run.position_imu_m[-1]) < 1e-4


def test_rates_and_forces_give_the_path():
    """1e-4 m at FAST_HZ. At 100 Hz point samples of the rate leave dt²/12 times its slope: 1e-3."""
    for rate_hz, tolerance_m in ((FAST_HZ, 1e-4), (100.0, 1e-3)):
        run = ideal(walk(), rate_hz)
        position, attitude = strapdown(run)
        assert np.linalg.norm(position - run.position_imu_m[-1]) < tolerance_m
        assert np.allclose(attitude, run.rotation_imu_to_world[-1], atol=1e-6)


def test_rates_and_forces_give_the_path_with_turns():
    """Turning while pitching is coning, which 100 Hz samples half miss: 5 mm; FAST_HZ 1 mm."""
    for rate_hz, tolerance_m in ((FAST_HZ, 1e-3), (100.0, 5e-3)):
        run = ideal(walk("rectangle"), rate_hz)
        assert np.linalg.norm(strapdown(run)[0] - run.position_imu_m[-1]) < tolerance_m


def test_rates_and_forces_give_the_tilts():
    run = ideal(tilts())
    assert np.linalg.norm(strapdown(run)[0] - run.position_imu_m[-1]) < 1e-3


@pytest.mark.parametrize("kind", [tilts, walk])
def test_rigid_body_formula_equals_direct_differentiation(kind):
    """Same bytes up to rounding (1e-7 m/s² of 1e-15 m over (2 ms)²); textbook's to 1 %.

    The textbook's Euler and centripetal terms use rates differentiated once more.
    """
    motion = kind(**{k: v for k, v in vars(REALISTIC).items()})
    run = ideal(motion, FAST_HZ)
    path = places(motion, MOUNT.translation_body_m[None])[:, 0]
    world = np.zeros_like(path)
    world[1:-1] = np.diff(path, 2, axis=0) * FAST_HZ**2
    world[:, 2] += G
    direct = np.einsum("nij,ni->nj", motion.rotation_body_to_world, world)
    read = run.recording.sensors["frame"].acc_mps2 @ MOUNT.rotation_imu_to_body.T
    assert np.allclose(read, direct, atol=1e-7)
    rate, arm = motion.rate_radps, MOUNT.translation_body_m
    euler = np.cross(np.gradient(rate, 1 / FAST_HZ, axis=0), arm)
    textbook = motion.specific_force_mps2 + euler + np.cross(rate, np.cross(rate, arm))
    added = np.abs(direct - motion.specific_force_mps2).max()
    assert added > 0.5
    assert np.abs(direct - textbook).max() < 0.01 * added


def test_truth_at_the_samples_is_the_motion():
    """Also between the motion's own times, as with 37 Hz and a clock that is off: 1e-6 m."""
    motion = walk("tug")
    sensor = without(MTI_1, "noise_density")
    run = attach_imu(motion, MOUNT, sensor, seed=1, unit_seed=2, sampling_rate_hz=37.0)
    at = [np.interp(run.time_s, motion.time_s, axis) for axis in motion.position_m.T]
    assert np.abs(run.position_body_m - np.column_stack(at)).max() < 1e-5
    turned = np.einsum("nij,j->ni", run.rotation_body_to_world, MOUNT.translation_body_m)
    assert np.allclose(run.position_imu_m, run.position_body_m + turned, atol=1e-12)
    there = run.rotation_body_to_world @ MOUNT.rotation_imu_to_body
    assert np.allclose(run.rotation_imu_to_world, there, atol=1e-12)
    eye = there @ np.swapaxes(there, 1, 2)
    assert np.allclose(eye, np.eye(3), atol=1e-9)
    fine = ideal(motion, FAST_HZ)
    by_position = np.gradient(fine.position_imu_m, 1 / FAST_HZ, axis=0)
    assert np.abs(fine.velocity_imu_mps - by_position).max() < 1e-3
    assert run.steps == motion.steps and run.tilts == ()


@pytest.mark.parametrize(
    ("name", "end", "turned_deg", "length_m"),
    [
        ("corridor", (10, 0), 0, 10),
        ("rectangle", (0, 0), 360, 17.5),
        ("open", (0, 0), 270, 17.5),
        ("tug", (0, 0), 360, 6),
    ],
)
@pytest.mark.parametrize("seed", range(3))
def test_courses_end_where_they_should(name, end, turned_deg, length_m, seed):
    motion = walk(name, seed)
    assert np.allclose(motion.position_m[-1], [*end, 0], atol=1e-9)
    assert np.allclose(motion.position_m[0], 0) and np.allclose(
        motion.rotation_body_to_world[0], np.eye(3)
    )
    turns = np.array([step.turn_rad for step in motion.steps])
    assert np.isclose(np.rad2deg(turns.sum()), turned_deg)
    assert np.isclose(sum(step.length_m for step in motion.steps), length_m)
    assert np.isclose(np.unwrap(heading(motion))[-1], np.deg2rad(turned_deg), atol=1e-9)
    assert np.abs(turns).max() <= np.deg2rad(30) + 1e-12
    assert motion.stationary[-int(1.9 * FAST_HZ) :].all() and motion.steps[0].lift_s == 3.0


@pytest.mark.parametrize("seed", range(5))
def test_steps_are_of_the_style(seed):
    style, motion = WalkStyle(), walk("corridor", seed)
    lengths = np.array([step.length_m for step in motion.steps])
    assert 25 <= len(lengths) <= 34  # 10 m in steps of 0.3 to 0.4 m
    assert (lengths[:-2] >= 0.30).all() and (lengths <= 0.40).all() and lengths[-1] >= 0.15
    tips = places(motion, TIPS)[:, :, 2]
    assert tips.min() > -1e-12
    for step, following in zip(motion.steps[:-1], motion.steps[1:], strict=True):
        now = during(motion, step.lift_s, step.place_s)
        assert 0.8 <= step.place_s - step.lift_s <= 1.2
        assert 1.2 <= following.lift_s - step.place_s <= 2.0
        assert 0.03 - 1e-5 <= tips[now][:, 2].max() <= 0.06
        pitch = np.arcsin(motion.rotation_body_to_world[now][:, 2, 0]).max()
        assert style.pitch_rad[0] - 1e-4 <= pitch <= style.pitch_rad[1]
        assert not motion.stationary[now][1:-1].any()


def test_rectangle_goes_counterclockwise():
    corners = walk("rectangle").position_m[:, :2]
    assert np.allclose(corners.max(axis=0), [5, 3.75], atol=1e-9)
    assert np.allclose(corners.min(axis=0), 0, atol=1e-9)


def test_a_duration_repeats_or_cuts_the_course():
    short = simulate_walk(CORRIDOR, seed=1, duration_s=20)
    once = simulate_walk(CORRIDOR, seed=1)
    assert short.steps == once.steps[: len(short.steps)]
    assert short.steps[-1].lift_s < 23 <= once.steps[len(short.steps)].lift_s
    six = simulate_walk(OUT_AND_BACK_30, seed=1, duration_s=360)
    assert 359 < six.steps[-1].lift_s < 363
    long = simulate_walk(CORRIDOR, seed=1, duration_s=120)
    assert long.position_m[-1, 0] > 12 and abs(long.position_m[-1, 1]) < 1e-9


def test_same_seed_gives_the_same_bytes():
    for make in (
        lambda seed: simulate_tilts(FRAME, seed=seed, imperfections=REALISTIC),
        lambda seed: simulate_walk(TIMED_UP_AND_GO, seed=seed, imperfections=REALISTIC),
    ):
        runs = [
            attach_imu(make(seed), MOUNT, seed=power_up, unit_seed=1)
            for seed, power_up in ((5, 1), (5, 1), (6, 1), (5, 2))
        ]
        data = [run.recording.sensors["frame"].acc_mps2.tobytes() for run in runs]
        assert data[0] == data[1] and data[0] != data[2] and data[0] != data[3]
        assert runs[0].position_imu_m.tobytes() == runs[1].position_imu_m.tobytes()


def test_imperfections_draw_apart():
    """Switching one off leaves angles, times and the other ones as they were."""
    both, one = tilts(edge_slip_m=0.005, edge_twist_rad=0.02), tilts(edge_twist_rad=0.02)
    assert both.tilts == one.tilts == tilts().tilts
    assert np.array_equal(both.rotation_body_to_world, one.rotation_body_to_world)
    times = [[(s.lift_s, s.place_s) for s in w.steps] for w in (walk(), walk(**vars(REALISTIC)))]
    assert times[0] == times[1]


def radius_of_first_tilt(motion):
    """Chord over 2 sin of half the angle: the IMU's distance from the axis it turned about."""
    first = motion.tilts[0]
    path = places(motion, MOUNT.translation_body_m[None])[:, 0]
    held = np.searchsorted(motion.time_s, first.held_from_s + 0.01)
    return np.linalg.norm(path[held] - path[0]) / (2 * np.sin(first.angle_rad / 2))


def test_ferrules_move_the_turning_edge_outward():
    """Front: 15 mm further ahead of the IMU, which sits 6 cm behind AB and 63 cm above."""
    behind, up = 0.52 - 0.46, 0.63
    assert np.isclose(radius_of_first_tilt(tilts()), np.hypot(behind, up), atol=1e-9)
    wide = tilts(ferrule_edge_m=0.015)
    assert np.isclose(radius_of_first_tilt(wide), np.hypot(behind + 0.015, up), atol=1e-9)
    assert np.abs(wide.position_m[-1]).max() < 1e-12
    assert places(wide, TIPS)[:, :, 2].min() > -1e-12


def test_slip_displaces_and_does_not_turn():
    moved = np.array([tilts(k, edge_slip_m=0.005).position_m[-1] for k in range(60)])
    assert np.abs(moved[:, 2]).max() < 1e-12
    # Four slips of sd 5 mm in any direction: sd 5 mm * sqrt(4 / 2) per axis, of 120 values.
    assert np.isclose(moved[:, :2].std(), 0.005 * np.sqrt(2), rtol=0.25)
    slipped = tilts(edge_slip_m=0.005)
    assert np.allclose(slipped.rotation_body_to_world, tilts().rotation_body_to_world, atol=1e-12)
    assert np.abs(places(slipped, TIPS)[:, :, 2].min()) < 1e-12


def test_twist_stays_and_keeps_the_edge_on_the_floor():
    size = np.deg2rad(1.0)
    yaws = [heading(tilts(k, edge_twist_rad=size))[-1] for k in range(60)]
    assert np.isclose(np.std(yaws), 2 * size, rtol=0.3)  # four tilts; 60 values
    motion = tilts(edge_twist_rad=size)
    assert places(motion, TIPS)[:, :, 2].min() > -1e-12
    first = motion.tilts[0]
    now = during(motion, first.start_s, first.stop_s)
    assert np.abs(places(motion, TIPS)[now][:, EDGES["front"], 2]).max() < 1e-12


def test_tremor_shakes_only_while_held():
    calm, shaken = tilts(), tilts(hold_tremor_rad=np.deg2rad(0.3))
    apart = np.swapaxes(calm.rotation_body_to_world, 1, 2) @ shaken.rotation_body_to_world
    angle = Rotation.from_matrix(apart).as_rotvec()
    held = np.zeros(len(angle), bool)
    for tilt in calm.tilts:
        now = during(calm, tilt.held_from_s, tilt.held_until_s)
        held |= now
        other = 1 if tilt.direction in ("right", "left") else 0
        assert np.abs(angle[now][:, [other, 2]]).max() < 1e-9  # about the edge only
    assert np.abs(angle[~held]).max() < 1e-9
    # A sine of 0.3 deg has 0.21 deg; the fades at both ends take some of it.
    size = np.rad2deg(np.sqrt((angle[held] ** 2).sum(axis=1).mean()))
    assert 0.08 < size < 0.3


def test_rocking_is_of_its_size_and_only_between_steps():
    size = np.deg2rad(0.06)
    motion = walk(rocking_rad=size)
    angle = Rotation.from_matrix(motion.rotation_body_to_world).as_rotvec()
    between = during(motion, motion.steps[0].place_s, motion.steps[-1].lift_s) & motion.stationary
    assert 0.5 * size < angle[between][:, :2].std() < 1.1 * size
    assert np.abs(angle[during(motion, 0, 3.0)]).max() < 1e-12
    assert np.abs(angle[during(motion, motion.steps[-1].place_s, np.inf)]).max() < 1e-9
    assert np.allclose(motion.position_m, walk().position_m)


def test_creep_is_forward_and_missing_from_the_steps():
    """What the tips slide while they stand is no step: their lengths fall short by it."""
    motion = walk(creep_sd_m=0.002)
    forward = np.diff(motion.position_m[:, 0])
    assert forward.min() > -1e-12 and np.isclose(motion.position_m[-1, 0], 10)
    slid = forward[motion.stationary[1:] & motion.stationary[:-1]].sum()
    count = len(motion.steps) - 1
    # Mean of abs(N) is 0.8 sd, its sd 0.6 sd; three of its own standard errors.
    assert abs(slid - 0.8 * 0.002 * count) < 3 * 0.6 * 0.002 * np.sqrt(count)
    assert np.isclose(sum(step.length_m for step in motion.steps), 10 - slid, atol=1e-6)


def test_placements_scatter_about_the_course():
    ends = np.array([walk("tug", k, placement_sd_m=0.03).position_m[-1] for k in range(40)])
    assert np.isclose(ends[:, :2].std(), 0.03, rtol=0.3)  # 80 values, and they do not add up
    assert np.abs(ends[:, 2]).max() < 1e-12


def test_landing_has_a_velocity_that_the_floor_stops():
    motion = walk(landing_mps=0.02)
    touched, stopped = [], []
    for step in motion.steps:
        at = np.searchsorted(motion.time_s, step.place_s)
        touched.append(motion.velocity_mps[at])
        stopped.append(motion.velocity_mps[at + int(0.035 * FAST_HZ)])
    touched = np.array(touched)
    assert np.isclose(touched[:, :2].std(), 0.02, rtol=0.4)  # some 58 values
    assert touched[:, 2].max() < 1e-4 and np.isclose(touched[:, 2].std(), 0.012, rtol=0.5)
    assert np.abs(stopped).max() < 1e-6
    assert np.allclose(motion.position_m[-1], [10, 0, 0], atol=1e-9)
    assert places(motion, TIPS)[:, :, 2].min() > -1e-9
    assert np.abs(motion.velocity_mps[motion.stationary]).max() < 1e-3


def test_ringing_follows_each_landing_and_dies_away():
    calm, ringing = walk(), walk(landing_ringing_mps2=1.0)
    added = ringing.specific_force_mps2 - calm.specific_force_mps2
    for step in ringing.steps:
        now = during(ringing, step.place_s, step.place_s + 0.15)
        late = during(ringing, step.place_s + 0.6, step.place_s + 1.1)
        peak = np.linalg.norm(added[now], axis=1).max()
        assert 0.5 < peak < 2.0  # within a factor of 2: decay takes, setting in adds
        assert np.linalg.norm(added[late], axis=1).max() < 1e-3
    assert np.array_equal(calm.rotation_body_to_world, ringing.rotation_body_to_world)


def test_tape_changes_only_what_is_measured():
    assert measured_geometry(FRAME, PERFECT, 1) == FRAME
    found = [measured_geometry(FRAME, REALISTIC, k) for k in range(200)]
    off = np.array([(f.footprint_width_m - 0.60, f.footprint_length_m - 0.52) for f in found])
    assert np.isclose(off.std(), 0.005, rtol=0.15) and abs(off.mean()) < 0.001
    assert np.array_equal(tilts(tape_m=0.005).position_m, tilts().position_m)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: simulate_tilts(FRAME, seed=1, order=()), "order"),
        (lambda: simulate_tilts(FRAME, seed=1, order="front"), "order"),
        (lambda: simulate_tilts(FRAME, seed=1, order=("up",)), "direction"),
        (lambda: Imperfections(edge_slip_m=-0.001), "edge_slip_m"),
        (lambda: Imperfections(rocking_rad=np.nan), "rocking_rad"),
        (lambda: replace(REALISTIC, landing_ringing_hz=(25.0, 20.0)), "landing_ringing_hz"),
        (lambda: replace(REALISTIC, landing_stop_s=0.0), "landing_stop_s"),
        (lambda: replace(REALISTIC, landing_ringing_decay_s=3.0), "landing_ringing_decay_s"),
        (lambda: TiltStyle(out_s=(1.6, 1.0)), "out_s"),
        (lambda: TiltStyle(angle_rad=(20.0, 45.0)), "deg"),
        (lambda: WalkStyle(pitch_rad=(3.0, 8.0)), "deg"),
        (lambda: WalkStyle(turn_step_rad=0.0), "turn_step_rad"),
        (lambda: Leg(-1.0), "length_m"),
        (lambda: Leg(1.0, 90.0), "turn_rad"),
        (lambda: simulate_walk((), seed=1), "path"),
        (lambda: simulate_walk((Leg(0.0, 1.0),), seed=1), "path"),
        (lambda: simulate_walk(CORRIDOR, seed=1, duration_s=0.0), "duration_s"),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
