"""Walker: strapdown, error-state filter and smoother against what must be true of them."""

import copy
import os
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from walker_recordings import pose_mount

from mobility_imu._compiled import HAVE_NUMBA
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.reproduction.walker.studies import DATASHEET
from mobility_imu.runs import runs_of
from mobility_imu.simulation.walker import CORRIDOR, attach_imu, simulate_walk
from mobility_imu.walker import _kernel, navigation
from mobility_imu.walker.eskf import stride_ends, world_up
from mobility_imu.walker.geometry import rotation_world_to_imu
from mobility_imu.walker.navigation import (
    GRAVITY_MPS2,
    ClosedLoop,
    NavigationSettings,
    NavigationState,
    corrected_state,
    error_dynamics,
    imu_output,
    integrate_strapdown,
    interval_means,
    navigate,
    run_filter,
    state_error,
    step_transition,
    strapdown_rates,
)
from mobility_imu.walker.stillness import find_stillness

needs_numba = pytest.mark.skipif(
    not HAVE_NUMBA, reason="without numba the loops of the kernel take minutes"
)
DT = 0.01
G = np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2])


def random_state(seed):
    rng = np.random.default_rng(seed)
    q = Rotation.random(random_state=seed).as_quat(scalar_first=True)
    return NavigationState(q, *(rng.normal(size=(4, 3)) * [[5], [1], [0.02], [0.1]])), rng


def disturbed(state, error):
    """State whose true value errs from the given one by the error: eq. 22 turned round."""
    turn = np.array([1.0, *error[:3]])
    q = Rotation.from_quat(state.quaternion, scalar_first=True) * Rotation.from_quat(
        turn, scalar_first=True
    )
    return NavigationState(
        q.as_quat(scalar_first=True, canonical=False),
        state.position_m + error[6:9],
        state.velocity_mps + error[9:12],
        state.gyr_bias_radps + error[3:6],
        state.acc_bias_mps2 + error[12:15],
    )


def aligned(true, estimate):
    """The error, with the quaternion on the estimate's side of the double cover."""
    sign = np.sign(true.quaternion @ estimate.quaternion)
    return state_error(true._replace(quaternion=sign * true.quaternion), estimate)


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_eq20_rates_are_those_of_a_turning_frame(seed):
    """Over 1 µs the rates carry the attitude where the rotation vector does."""
    state, rng = random_state(seed)
    rate, acc = rng.normal(size=3), rng.normal(size=3)
    q_dot, v_dot, r_dot = strapdown_rates(state.quaternion, state.velocity_mps, rate, acc)
    here = Rotation.from_quat(state.quaternion, scalar_first=True)
    there = here * Rotation.from_rotvec(rate * 1e-6)
    stepped = state.quaternion + 1e-6 * q_dot
    assert np.allclose(rotation_world_to_imu(stepped).T, there.as_matrix(), atol=1e-11)
    assert np.allclose(v_dot, here.apply(acc))
    assert np.allclose(r_dot, state.velocity_mps)


def test_eq21_resting_accelerometer_reads_up():
    upright = NavigationState(np.array([1.0, 0, 0, 0]), *np.zeros((4, 3)))
    force, rate = imu_output(upright, np.zeros(3), np.zeros(3))
    assert np.allclose(force, G) and np.allclose(rate, 0)
    biased = upright._replace(acc_bias_mps2=np.ones(3), gyr_bias_radps=np.full(3, 0.1))
    force, rate = imu_output(biased, [1.0, 0, 0], [0, 0, 2.0])
    assert np.allclose(force - G, [2, 1, 1]) and np.allclose(rate, [0.1, 0.1, 2.1])


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_eq22_error_is_half_the_rotation_vector(seed):
    state, rng = random_state(seed)
    error = rng.normal(size=15) * 1e-5
    assert np.allclose(aligned(disturbed(state, error), state), error, atol=1e-9)


@given(st.integers(0, 10**6), st.floats(1e-4, 1.0))
@settings(max_examples=30, deadline=None)
def test_quaternions_of_steps_and_corrections_keep_their_length(seed, size):
    """However large the correction or the turn, and whatever the length was before."""
    state, rng = random_state(seed)
    longer = state._replace(quaternion=(1 + 0.1 * size) * state.quaternion)
    corrected = corrected_state(state, size * rng.normal(size=15))
    stepped, _ = step_transition(longer, rng.normal(size=3), rng.normal(size=3) * size, 0.1)
    for found in (corrected, stepped):
        assert np.isclose(np.linalg.norm(found.quaternion), 1, atol=1e-12)


def numeric_transition(state, acc, gyr, dt):
    after, _ = step_transition(state, acc, gyr, dt)
    columns = []
    for k in range(15):
        small = np.zeros(15)
        small[k] = 1e-5
        ends = [
            aligned(step_transition(disturbed(state, s * small), acc, gyr, dt)[0], after)
            for s in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / 2e-5)
    return np.array(columns).T


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_eq24_transition_is_the_derivative_of_the_nonlinear_step(seed):
    """To 1e-6 (issue), at rates up to some rad/s and forces up to some g."""
    state, rng = random_state(seed)
    acc, gyr = rng.normal(size=3) * 15, rng.normal(size=3) * 2
    _, phi = step_transition(state, acc, gyr, DT)
    assert np.abs(numeric_transition(state, acc, gyr, DT) - phi).max() < 1e-6


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_eq24_transition_holds_for_large_turns_as_far_as_its_series_goes(seed):
    """A turn p of 0.3 rad within one interval. What is left of the bias's parts is the next term.

    Right Jacobian of p: -p³/24 follows p²/6. Of half the turn: p²/24 follows p/4.
    """
    state, rng = random_state(seed)
    dt, p, axis = 0.1, 0.3, rng.normal(size=3)
    gyr = state.gyr_bias_radps + p / dt * axis / np.linalg.norm(axis)
    acc = rng.normal(size=3) * 10
    force = np.linalg.norm(acc - state.acc_bias_mps2)
    _, phi = step_transition(state, acc, gyr, dt)
    off = np.abs(numeric_transition(state, acc, gyr, dt) - phi)
    assert off[0:3, 3:6].max() < 1.1 * dt / 2 * p**3 / 24 + 1e-9
    by_bias = dt / 4 * 2 * dt * force * 1.1 * p**2 / 24
    assert off[9:12, 3:6].max() < by_bias + 1e-8 and off[6:9, 3:6].max() < dt / 2 * by_bias + 1e-8
    off[0:3, 3:6] = off[6:12, 3:6] = 0
    assert off.max() < 1e-6


def test_eq24_is_the_rate_of_the_transition():
    """Continuous A from the discrete step, dt towards 0, in both forms; the printed one errs."""
    state, rng = random_state(4)
    acc, gyr = rng.normal(size=3) * 10, rng.normal(size=3)
    rate, force = gyr - state.gyr_bias_radps, acc - state.acc_bias_mps2
    for form in ("corrected", "printed"):
        _, phi = step_transition(state, acc, gyr, 1e-6, form=form)
        a = error_dynamics(state.quaternion, rate, force, form=form)
        assert np.allclose((phi - np.eye(15)) / 1e-6, a, atol=1e-3)
    numeric = (numeric_transition(state, acc, gyr, 1e-4) - np.eye(15)) / 1e-4
    right = error_dynamics(state.quaternion, rate, force)
    wrong = error_dynamics(state.quaternion, rate, force, form="printed")
    assert np.abs(numeric - right).max() < 0.01
    assert np.allclose(wrong[0:3, 3:6], -right[0:3, 3:6]) and not wrong[9:12, 12:15].any()
    assert np.abs((numeric - wrong)[0:3, 3:6]).max() > 0.9


def wobbling(seconds, seed=1, noise=True):
    """Readings of an IMU that turns and shakes smoothly between rests, and its truth."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, seconds, DT)
    phase = time % 4.0
    on = np.where(phase > 2, np.sin(np.pi * (phase - 2) / 2) ** 2, 0.0)
    gyr = np.outer(on, [0.6, -0.4, 0.3]) * np.sin(np.pi * (phase - 2))[:, None]
    turn = Rotation.random(random_state=seed)
    rest = turn.inv().apply(G)
    acc = rest + np.outer(on, [1.0, 0.5, -0.7]) * np.sin(np.pi * phase)[:, None]
    if noise:
        acc = acc + 0.012 * rng.standard_normal(acc.shape) + [0.01, -0.02, 0.015]
        gyr = gyr + 0.0012 * rng.standard_normal(gyr.shape) + [0.003, -0.002, 0.001]
    return time, acc, gyr, phase < 1.9


def textbook(time, acc, gyr, still, start, covariance, chosen, closed=None):
    """The same filter with dense matrices and a Rauch-Tung-Striebel smoother, in plain NumPy."""
    g2 = (chosen.gyr_noise_radps_sqrthz * chosen.gyr_noise_factor) ** 2
    a2 = (chosen.acc_noise_mps2_sqrthz * chosen.acc_noise_factor) ** 2
    s2 = chosen.rate_noise_radps_sqrthz**2
    state, p = start, covariance
    up = rotation_world_to_imu(start.quaternion)[:, 2]
    priors, posts, phis, shifts, states = [], [p], [], [], [start]
    eye = np.eye(15)
    for k in range(len(time)):
        share = s2 / (s2 + g2) if still[k] and chosen.zero_rate else 1.0
        reading = state.gyr_bias_radps + share * (gyr[k] - state.gyr_bias_radps)
        moved, phi = step_transition(state, acc[k], reading, DT)
        phi[:, 3:6] = eye[:, 3:6] + share * (phi - eye)[:, 3:6]
        q = np.zeros((15, 15))
        q[0:3, 0:3] = g2 * share / 4 * DT * np.eye(3)
        q[3:6, 3:6] = chosen.gyr_bias_walk_radps_sqrts**2 * DT * np.eye(3)
        q[6:9, 6:9], q[9:12, 9:12] = a2 * DT**3 / 4 * np.eye(3), a2 * DT * np.eye(3)
        q[6:9, 9:12] = q[9:12, 6:9] = a2 * DT**2 / 2 * np.eye(3)
        q[12:15, 12:15] = chosen.acc_bias_walk_mps2_sqrts**2 * DT * np.eye(3)
        p = phi @ p @ phi.T + q
        priors.append(p)
        shift = np.zeros(15)
        if still[k]:
            rows, z, r = (
                [9, 10, 11],
                list(-moved.velocity_mps),
                [chosen.velocity_noise_mps_sqrthz**2 / DT] * 3,
            )
            if rotation_world_to_imu(moved.quaternion)[:, 2] @ up > np.cos(chosen.upright_rad):
                rows.append(8)
                z.append(-moved.position_m[2])
                r.append(chosen.height_noise_m_sqrthz**2 / DT)
            if chosen.zero_rate:
                rows += [3, 4, 5]
                z += list(gyr[k] - moved.gyr_bias_radps)
                r += [(s2 + g2) / DT] * 3
            h = eye[rows]
            gain = np.linalg.solve(h @ p @ h.T + np.diag(r), h @ p).T
            shift = gain @ np.array(z)
            left = eye - gain @ h
            p = left @ p @ left.T + gain @ np.diag(r) @ gain.T
        state = disturbed(moved, shift)
        state = state._replace(quaternion=state.quaternion / np.linalg.norm(state.quaternion))
        phis.append(phi)
        shifts.append(shift)
        posts.append(p)
        states.append(state)
    error, spread = np.zeros(15), posts[-1]
    if closed is not None:
        error, spread = known_end(states[0], states[-1], posts[-1], closed)
    smoothed = [(disturbed(states[-1], error), spread)]
    for k in range(len(time) - 1, -1, -1):
        gain = np.linalg.solve(priors[k].T, (posts[k] @ phis[k].T).T).T
        error = gain @ (shifts[k] + error)
        spread = posts[k] + gain @ (spread - priors[k]) @ gain.T
        smoothed.append((disturbed(states[k], error), spread))
    return states, posts, smoothed[::-1]


def heading_against(first, state):
    """Turn about the world's z axis since a first state, rad."""
    turn = rotation_world_to_imu(state.quaternion).T @ rotation_world_to_imu(first.quaternion)
    return Rotation.from_matrix(turn).as_rotvec()[2]


def known_end(first, last, p, closed):
    """Error and covariance after the known end; the observation's matrix by finite differences."""

    def end(state):
        return np.array([*(state.position_m - first.position_m)[:2], heading_against(first, state)])

    small = 1e-6 * np.eye(15)
    h = np.array([(end(disturbed(last, e)) - end(disturbed(last, -e))) / 2e-6 for e in small]).T
    r = np.diag([closed.position_sd_m] * 2 + [closed.heading_sd_rad]) ** 2
    gain = np.linalg.solve(h @ p @ h.T + r, h @ p).T
    left = np.eye(15) - gain @ h
    return -gain @ end(last), left @ p @ left.T + gain @ r @ gain.T


def at_samples(states, name):
    values = np.array([getattr(s, name) for s in states])
    return (values[1:] + values[:-1]) / 2


@pytest.mark.parametrize("zero_rate", [True, False])
def test_compiled_filter_and_smoother_equal_the_textbook(zero_rate):
    """Sparse transition, joint updates and the adjoint recursion change nothing but the speed."""
    time, acc, gyr, still = wobbling(12)
    chosen = NavigationSettings(zero_rate=zero_rate, moving_stride=1, resting_stride=1)
    start, p = random_state(1)[0], np.diag(np.repeat([1e-3, 1e-3, 1e-3, 1e-2, 3e-2], 3)) ** 2
    start = start._replace(
        quaternion=Rotation.random(random_state=1).as_quat(scalar_first=True),
        position_m=np.zeros(3), velocity_mps=np.zeros(3),
        gyr_bias_radps=np.zeros(3), acc_bias_mps2=np.zeros(3),
    )  # fmt: skip
    states, posts, smoothed = textbook(time, acc, gyr, still, start, p, chosen)
    for smooth, expected, spread in (
        (False, states, posts),
        (True, [s for s, _ in smoothed], [c for _, c in smoothed]),
    ):
        ours = run_filter(time, acc, gyr, still, start, p, chosen, smooth=smooth)
        for name in ("position_m", "velocity_mps", "gyr_bias_radps", "acc_bias_mps2"):
            assert np.allclose(
                getattr(ours, name), at_samples(expected, name), rtol=0, atol=1e-8
            ), name
        variance = np.array([np.diag(c) for c in spread])
        assert np.allclose(ours.sd**2, (variance[1:] + variance[:-1]) / 2, rtol=1e-6, atol=1e-16)


def test_known_end_of_the_smoother_equals_the_textbook():
    """Place and heading of the end are drawn to the start's, as one more observation would.

    The gyroscope's bias turns the heading, and a wrong sign or weight of the constraint would turn
    it on. The textbook has the observation's matrix from finite differences; what differs is of
    second order in the errors, far below 1 % of them.
    """
    time, acc, gyr, still = wobbling(12)
    chosen = NavigationSettings(zero_rate=False, moving_stride=1, resting_stride=1)
    start, p = NavigationState(
        Rotation.random(random_state=1).as_quat(scalar_first=True), *np.zeros((4, 3))
    ), np.diag(np.repeat([1e-3, 2e-3, 1e-3, 1e-3, 3e-2], 3)) ** 2  # fmt: skip
    closed = ClosedLoop(position_sd_m=0.002, heading_sd_rad=0.001)
    free, _, _ = textbook(time, acc, gyr, still, start, p, chosen)
    _, _, smoothed = textbook(time, acc, gyr, still, start, p, chosen, closed)
    ours = run_filter(time, acc, gyr, still, start, p, chosen, closed_loop=closed)
    drift = heading_against(free[0], free[-1])
    assert abs(drift) > 0.01
    assert abs(heading_against(ours.state(0), ours.state(-1))) < 0.1 * abs(drift)
    moved = np.abs(at_samples(free, "position_m") - ours.position_m).max()
    apart = np.abs(at_samples([s for s, _ in smoothed], "position_m") - ours.position_m).max()
    assert apart < 0.01 * moved
    variance = np.array([np.diag(c) for _, c in smoothed])
    # A heading known 20 times better than before shows the second order most: 20 % in variance.
    assert np.allclose(ours.sd**2, (variance[1:] + variance[:-1]) / 2, rtol=0.2, atol=1e-16)


VARIANTS = {
    "default strides": ({}, {}),
    "one sample a stride": ({"moving_stride": 1, "resting_stride": 1}, {}),
    "no zero rates": ({"zero_rate": False}, {}),
    "printed": ({"form": "printed"}, {}),
    "filter alone": ({}, {"smooth": False}),
    "closed loop": ({}, {"closed_loop": ClosedLoop()}),
    "all moves too long": ({"longest_move_s": 0.5, "long_move_factor": 7.0}, {}),
}


@needs_numba
@pytest.mark.parametrize("variant", VARIANTS)
def test_readable_filter_equals_the_compiled_one(walked, variant, monkeypatch):
    """Same strides, same updates: to 1e-9 in every state, on a walk with a gap and saturation."""
    chosen, options = VARIANTS[variant]
    time, acc, gyr, still = (values[:3000] for values in walked)
    kept = np.r_[0:1500, 1530:3000]
    time, acc, gyr, still = time[kept], acc[kept], gyr[kept], still[kept]
    cut = np.zeros(len(time), bool)
    cut[[700, 1800, 2500]] = True
    fast = np.roll(cut, 3)
    found = []
    for way in ("plain", "compiled"):
        monkeypatch.setattr(navigation, "choose", lambda *_, way=way, **__: way)
        found.append(
            navigate(
                time,
                acc,
                gyr,
                still,
                NavigationSettings(**chosen),
                cut=cut,
                cut_gyr=fast,
                **options,
            )
        )
    readable, compiled = found
    for name in ("quaternion", "position_m", "velocity_mps", "gyr_bias_radps", "acc_bias_mps2"):
        apart = np.abs(getattr(readable, name) - getattr(compiled, name)).max()
        assert apart < 1e-9, (name, apart)
    assert np.allclose(readable.sd, compiled.sd, rtol=1e-6, atol=1e-9)
    crossed = readable.xy_covariance_m2
    assert np.allclose(crossed, compiled.xy_covariance_m2, rtol=1e-6, atol=1e-14)
    assert np.abs(crossed / readable.sd[:, 6] / readable.sd[:, 7])[100:].max() <= 1
    assert (readable.nis_dof == compiled.nis_dof).all()
    assert np.allclose(readable.nis, compiled.nis, rtol=1e-6, atol=1e-8)
    paths = []
    for way in ("plain", "compiled"):
        monkeypatch.setattr(navigation, "choose", lambda *_, way=way, **__: way)
        paths.append(integrate_strapdown(time, acc, gyr, readable.state(0), still=still))
    assert np.allclose(paths[0].position_m, paths[1].position_m, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("size", [0.0, 1e-6, 0.01, 0.1, 0.126, 0.127, 1.0, 3.0])
def test_half_a_turn_of_the_kernel_is_exact_for_small_and_large_turns(size):
    """Its series and the functions that it stands for, on both sides of where they meet."""
    plain = getattr(_kernel.half_turn, "py_func", _kernel.half_turn)
    axis = np.array([0.6, -0.48, 0.64])
    half = size / 4  # a quaternion holds half of the angle, here of half the turn
    expected = [np.cos(half), *(np.sin(half) * axis)]
    assert np.allclose(plain(tuple(size * axis)), expected, rtol=2e-15, atol=1e-16)


def test_matrices_of_the_kernel_multiply_as_matrices_do():
    """Flat, with rows of 16 numbers of which 15 count."""
    rng = np.random.default_rng(9)
    a, b = rng.standard_normal((2, 15, 15))
    symmetric = a @ a.T
    flat = {name: np.zeros(240) for name in ("a", "b", "out", "p", "work", "other", "vector")}
    for name, values in (("a", a), ("b", b), ("p", symmetric)):
        flat[name].reshape(15, 16)[:, :15] = values

    def dense(name):
        return flat[name].reshape(15, 16)[:, :15]

    _kernel.multiply(flat["a"], flat["b"], flat["out"])
    assert np.allclose(dense("out"), a @ b, rtol=1e-13, atol=1e-13)
    _kernel.sandwich(flat["b"], flat["p"], flat["work"], flat["other"])
    assert np.allclose(dense("p"), b @ symmetric @ b.T, rtol=1e-12, atol=1e-12)
    _kernel.times_vector(flat["p"], b[0], flat["vector"])
    assert np.allclose(flat["vector"][:15], dense("p") @ b[0], rtol=1e-12, atol=1e-12)
    _kernel.identity(flat["out"])
    assert np.array_equal(dense("out"), np.eye(15))
    _kernel.transpose(flat["a"], flat["out"])
    assert np.array_equal(dense("out"), a.T)


def test_first_path_in_a_fresh_environment_waits_for_no_compiler(tmp_path):
    """Two minutes of walking leave nothing compiled, at 1,300 steps of the interpreter a sample.

    Those are 1 s for two minutes; at three times as many it would still be ready within 5 s.
    """
    code = """
import numpy as np
from mobility_imu._compiled import HAVE_NUMBA
from mobility_imu.walker import _kernel
from mobility_imu.walker.navigation import navigate
from steps_taken import steps_of

def walk(n):
    clock = np.arange(n) / 100
    acc = np.tile([0.0, 0.0, 9.80665], (n, 1))
    acc += 0.01 * np.random.default_rng(0).normal(size=(n, 3))
    navigate(clock, acc, np.zeros((n, 3)), clock % 3 < 1.5)

walk(12_000)
assert not HAVE_NUMBA or not _kernel.run_filter.overloads
assert steps_of(walk, 600) - steps_of(walk, 300) < 3 * 1300 * 300
"""
    here = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "MOBILITY_IMU_COMPILE": ""}
    env["PYTHONPATH"] = here
    subprocess.run([sys.executable, "-c", code], check=True, env=env)


@pytest.fixture(scope="module")
def walked():
    """Readings of a data-sheet sensor on a 10 m walk, and where the frame was still."""
    motion = simulate_walk(CORRIDOR, seed=3)
    imu = attach_imu(motion, pose_mount("2"), DATASHEET, seed=3, unit_seed=3)
    readings = imu.recording.sensor("frame")
    acc, gyr = np.asarray(readings.acc_mps2), np.asarray(readings.gyr_radps)
    return imu.recording.time_s, acc, gyr, find_stillness(acc, gyr, 100.0)


def departures(walked, moving, resting):
    """How far strides move a smoothed path, and by which part they change standard deviations."""
    one, other = (
        navigate(*walked, NavigationSettings(moving_stride=m, resting_stride=r))
        for m, r in ((1, 1), (moving, resting))
    )
    apart = np.linalg.norm(one.position_m - other.position_m, axis=1)
    return apart.max(), np.abs(other.sd / one.sd - 1), one.sd[-1, 6:8].min()


def test_strides_of_a_moving_frame_move_nothing(walked):
    """Without updates in between, the step of several samples is the product of theirs.

    What is left: noise of the rate that reaches the velocity within a stride, and corrections and
    variances that are linear inside one.
    """
    away, sd, _ = departures(walked, 8, 1)
    assert away < 3e-5
    assert np.median(sd) < 1e-3 and sd.max() < 0.1


@pytest.mark.parametrize("resting", [2, 4])
def test_strides_of_a_resting_frame_move_less_than_the_filter_knows(walked, resting):
    """One update for some samples, with the noise of its duration, tells what theirs would."""
    away, sd, smallest = departures(walked, 8, resting)
    assert away < 0.1 * smallest
    assert np.median(sd) < 2e-3 and sd.max() < 0.15


def test_a_gap_shares_its_stride_with_nothing(walked):
    """0.3 s without samples in the middle of a movement: there, too, strides change little."""
    still = walked[3]
    swing = max(runs_of(~still), key=lambda run: run.stop - run.start)
    assert swing.stop - swing.start > 60
    kept = np.r_[0 : swing.start + 19, swing.start + 49 : len(still)]
    away, sd, smallest = departures([values[kept] for values in walked], 8, 4)
    assert away < 0.1 * smallest
    assert np.median(sd) < 2e-3 and sd.max() < 0.15


def test_strides_break_where_rest_begins_and_ends_and_around_what_stands_alone():
    still = np.zeros(30, bool)
    still[7:19] = True
    cut = np.zeros(30, bool)
    cut[24] = True
    ends = stride_ends(still, cut, 4, 4)
    # 0-6 moving; 7-18 at rest, singly within 4 of its ends; 19-23 moving; 24 cut; 25-29 moving
    assert ends.tolist() == [4, 7, 8, 9, 10, 11, 15, 16, 17, 18, 19, 23, 24, 25, 29, 30]
    assert stride_ends(still, cut, 1, 1).tolist() == list(range(1, 31))
    # Each setting is heeded without the other; rests are strided also if movements are not.
    ends = stride_ends(still, cut, 1, 4)
    assert ends.tolist() == [k for k in range(1, 31) if k not in (12, 13, 14)]
    ends = stride_ends(still, cut, 4, 1)
    assert ends.tolist() == [4, 7, *range(8, 20), 23, 24, 25, 29, 30]
    with pytest.raises(
        InputError, match="resting_stride = 0: expected a whole number of 1 or more"
    ):
        NavigationSettings(resting_stride=0)


def test_a_move_that_is_too_long_counts_with_more_noise(walked):
    """Where every move is too long: with four times the noise in moves, none of it at rest."""
    time, acc, gyr, still = (values[:3000] for values in walked)
    usual = NavigationSettings(zero_rate=False)
    longer = replace(usual, longest_move_s=0.01, long_move_factor=4.0)
    one, plain = (navigate(time, acc, gyr, still, s) for s in (longer, usual))
    first = runs_of(~still)[0]
    middle = (first.start + first.stop) // 2
    gain = one.sd[:, 9:11] / plain.sd[:, 9:11]
    assert (2 < gain[middle]).all() and (gain[middle] < 4.01).all()
    assert (gain[: first.start - 50] < 1.2).all()
    last = replace(usual, longest_move_s=60.0, long_move_factor=4.0)
    assert np.array_equal(navigate(time, acc, gyr, still, last).sd, plain.sd)


def test_an_assumed_bias_is_as_large_as_stated(walked):
    """Without the first rest's mean the filter starts at zero, with the sd of the settings."""
    time, acc, gyr, still = (values[:2000] for values in walked)
    for size in (1e-4, 1e-2):
        settings = NavigationSettings(initial_gyr_mean=False, gyr_bias_prior_sd_radps=size)
        path = navigate(time, acc, gyr, still, settings, smooth=False)
        assert np.allclose(path.sd[0, 3:6], size, rtol=0.6) and path.sd[0, 3] <= size


@needs_numba
def test_same_without_compiling(tmp_path):
    """The compiled functions give the same when Python runs them as they stand."""
    code = """
import sys
import numpy as np
from mobility_imu.walker.navigation import navigate
given = np.load(sys.argv[1])
n = navigate(*(given[name] for name in ("time", "acc", "gyr", "still")))
np.save(sys.argv[2], np.column_stack([n.quaternion, n.position_m, n.sd]))
"""
    given = tmp_path / "given.npz"
    np.savez(given, **dict(zip(("time", "acc", "gyr", "still"), wobbling(3.0), strict=True)))
    found = []
    for off in ("0", "1"):
        path = tmp_path / f"{off}.npy"
        env = {**os.environ, "NUMBA_DISABLE_JIT": off, "MOBILITY_IMU_COMPILE": "always"}
        subprocess.run([sys.executable, "-c", code, str(given), str(path)], check=True, env=env)
        found.append(np.load(path))
    # Rounding alone: the compiler may fuse a product and a sum.
    assert np.allclose(found[0], found[1], rtol=1e-9, atol=1e-10)


def test_ideal_readings_of_a_turn_and_a_shift_are_integrated_exactly():
    """A frame turned by 40 deg and shifted by 0.3 m comes out there, noise aside.

    The turn leaves nothing sideways or in height. Along the way a least-jerk movement starts with a
    jump of the jerk, 60 D / T³, that samples cannot show: dt²/12 of it over its 1.2 s is 0.10 mm.
    """
    time = np.arange(0, 3.0, DT)
    u = np.clip((time - 1) / 1.2, 0, 1)
    turn, axis = np.deg2rad(40), np.array([0.6, 0.0, 0.8])
    angle = turn * (10 * u**3 - 15 * u**4 + 6 * u**5)
    rate = turn * (30 * u**2 - 60 * u**3 + 30 * u**4) / 1.2
    acceleration = 0.3 * (60 * u - 180 * u**2 + 120 * u**3) / 1.44
    acceleration[(u <= 0) | (u >= 1)] = 0
    attitude = Rotation.from_rotvec(np.outer(angle, axis))
    force = attitude.inv().apply(np.outer(acceleration, [1, 0, 0]) + G)
    start = NavigationState(np.array([1.0, 0, 0, 0]), *np.zeros((4, 3)))
    path = integrate_strapdown(
        time, force, np.outer(rate, axis), start, still=(time < 0.98) | (time > 2.22)
    )
    assert np.allclose(path.position_m[-1], [0.3, 0, 0], atol=[1.5e-4, 1e-6, 1e-6])
    last = Rotation.from_quat(path.quaternion[-1], scalar_first=True)
    assert np.allclose(last.as_rotvec(), turn * axis, atol=1e-6)


def test_a_cone_is_integrated_without_drift():
    """An axis that goes round a cone of 17 deg at 1.1 Hz while it spins up.

    With the samples as they are, two seconds at 100 Hz drift by 0.2 mrad; the means leave less
    than a thousandth of it.
    """

    def attitude(time):
        cone = 0.3 * np.column_stack([np.cos(7 * time), np.sin(7 * time), 0 * time])
        return Rotation.from_rotvec(cone + np.outer(0.8 * time**2, [0.0, 0.0, 1.0]))

    time, half, tiny = DT * np.arange(200), DT / 2, 1e-4
    rate = (attitude(time - tiny).inv() * attitude(time + tiny)).as_rotvec() / (2 * tiny)
    _, mean = interval_means(attitude(time).inv().apply(G), rate, DT)
    true = attitude(time[[1]] - half).inv() * attitude(time[[-2]] + half)
    drift = []
    for rates in (rate, mean):
        turned = Rotation.identity()
        for step in Rotation.from_rotvec(DT * rates[1:-1]):
            turned = turned * step
        drift.append((turned.inv() * true).magnitude()[0])
    assert drift[0] > 1e-4 and drift[1] < drift[0] / 1000


def test_turning_everything_changes_nothing():
    """The IMU's axes are a matter of choice: heights and speeds do not depend on them."""
    time, acc, gyr, still = wobbling(8)
    turn = Rotation.random(random_state=7).as_matrix()
    one, other = (navigate(time, acc @ m, gyr @ m, still) for m in (np.eye(3), turn))
    assert np.allclose(one.position_m[:, 2], other.position_m[:, 2], atol=1e-9)
    assert np.allclose(
        np.linalg.norm(one.velocity_mps, axis=1),
        np.linalg.norm(other.velocity_mps, axis=1),
        atol=1e-9,
    )


def drawn_walks(runs, chosen):
    """Truths, readings and observations of many runs at once, drawn from the filter's own model.

    Returned are the start, its covariance, clock and flags, and per run: readings (n, 6), observed
    velocity and height (n, 4) and the list of true states.
    """
    rng = np.random.default_rng(0)
    time, acc, gyr, still = wobbling(24, seed=3, noise=False)
    count, root = len(time), np.sqrt(DT)
    p = np.diag(np.repeat([2e-3, 1e-4, 1e-3, 1e-3, 0.02], 3)) ** 2
    nominal = NavigationState(
        Rotation.random(random_state=3).as_quat(scalar_first=True), *np.zeros((4, 3))
    )
    error = rng.multivariate_normal(np.zeros(15), p, runs)
    attitude = Rotation.from_quat(nominal.quaternion, scalar_first=True) * Rotation.from_quat(
        np.column_stack([np.ones(runs), error[:, :3]]), scalar_first=True
    )
    gyr_bias, position, velocity, acc_bias = (error[:, k : k + 3] for k in (3, 6, 9, 12))
    g = chosen.gyr_noise_radps_sqrthz * chosen.gyr_noise_factor
    a = chosen.acc_noise_mps2_sqrthz * chosen.acc_noise_factor
    readings, truth = np.empty((count, 2, runs, 3)), np.empty((count + 1, runs, 16))

    def row():
        return np.hstack(
            [attitude.as_quat(scalar_first=True), position, velocity, gyr_bias, acc_bias]
        )

    truth[0] = row()
    for k in range(count):
        # A frame that stands moves by what the settings say: a rate of that noise, and no force.
        noise = rng.standard_normal((5, runs, 3))
        rate = np.tile(gyr[k], (runs, 1))
        if still[k] and chosen.zero_rate:
            rate = chosen.rate_noise_radps_sqrthz / root * noise[0]
        readings[k, 0] = acc[k] + acc_bias + a / root * noise[1]
        readings[k, 1] = rate + gyr_bias + g / root * noise[2]
        half = Rotation.from_rotvec(rate * DT / 2)
        gain = DT * ((attitude * half).apply(acc[k]) - G)
        position = position + DT * (velocity + gain / 2)
        velocity, attitude = velocity + gain, attitude * half * half
        gyr_bias = gyr_bias + chosen.gyr_bias_walk_radps_sqrts * root * noise[3]
        acc_bias = acc_bias + chosen.acc_bias_walk_mps2_sqrts * root * noise[4]
        truth[k + 1] = row()
    # What is observed is said of a stride's end; its mean has the noise of the stride.
    none = np.zeros(count, bool)
    ends = stride_ends(still, none, chosen.moving_stride, chosen.resting_stride)
    last = np.repeat(ends, np.diff(ends, prepend=0))
    seen = truth[last][:, :, [7, 8, 9, 6]]
    densities = [*[chosen.velocity_noise_mps_sqrthz] * 3, chosen.height_noise_m_sqrthz]
    seen = seen + rng.standard_normal(seen.shape) / root * densities
    return nominal, p, time, still, readings, seen, truth


def state_between(first, second):
    """Mean of two true states, as numbers."""
    middle = (first + second) / 2
    return NavigationState(*np.split(middle, [4, 7, 10, 13]))


@pytest.mark.parametrize(
    ("zero_rate", "strides"),
    [
        (True, (1, 1)),
        (False, (8, 4)),
        pytest.param(False, (1, 1), marks=pytest.mark.slow),
        pytest.param(True, (8, 4), marks=pytest.mark.slow),
    ],
)
def test_filter_is_consistent_at_stated_noise(zero_rate, strides):
    """Innovations and errors are as large as the filter says: inside 95 % chi-square bounds.

    60 runs; bounds of the mean over independent numbers (innovations of all runs; one error per
    run, at the end). Each state's own error is held to a family-wise bound of 95 %; a standard
    deviation that is wrong by a factor of two misses it.
    """
    from scipy import stats

    chosen = NavigationSettings(
        gyr_noise_factor=1.0,
        acc_noise_factor=1.0,
        zero_rate=zero_rate,
        moving_stride=strides[0],
        resting_stride=strides[1],
    )
    runs = 60
    nominal, p, time, still, readings, seen, truth = drawn_walks(runs, chosen)
    total, dof = 0.0, 0
    filtered, smoothed = [], []
    for run in range(runs):
        forward, both = (
            run_filter(
                time, readings[:, 0, run], readings[:, 1, run], still, nominal, p, chosen,
                smooth=smooth, observed=seen[:, run],
            )
            for smooth in (False, True)
        )  # fmt: skip
        for found, at, errors in ((forward, 2399, filtered), (both, 1150, smoothed)):
            estimate = found.state(at)
            error = aligned(state_between(*truth[at : at + 2, run]), estimate)
            errors.append(error / found.sd[at])
        total += forward.nis.sum()
        dof += int(forward.nis_dof.sum())
    low, high = stats.chi2.ppf([0.025, 0.975], dof)
    assert low < total < high, f"NIS {total / dof:.4f}, bounds {low / dof:.4f} {high / dof:.4f}"
    low, high = stats.chi2.ppf([0.025 / 30, 1 - 0.025 / 30], runs) / runs
    assert 0.25 * high < 1 / 1.2 and 4 * low > 1.2  # twice or half the sd is out
    for errors in (filtered, smoothed):
        squares = np.mean(np.array(errors) ** 2, axis=0)
        assert ((low < squares) & (squares < high)).all(), (squares, low, high)


def test_smoothing_never_adds_uncertainty_over_a_long_walk():
    """Over five minutes the smoothed standard deviations stay below the filter's.

    The expanded form of the adjoint's covariance lets an unsymmetric part grow unless it is
    taken out; 1e-6 is left for rounding.
    """
    time, acc, gyr, still = wobbling(300)
    forward, both = (navigate(time, acc, gyr, still, smooth=s) for s in (False, True))
    assert (both.sd <= forward.sd * (1 + 1e-6) + 1e-9).all()
    assert (both.sd[:, 6:9].max(axis=0) < 10).all()


def test_one_hour_in_bounded_memory():
    """An hour at 100 Hz, smoothed: less than 1 GB at its peak, interpreter and numba included."""
    code = """
import re, numpy as np
from mobility_imu.walker.navigation import navigate
rng = np.random.default_rng(0)
n = 360_000
time = np.arange(n) / 100
acc = np.tile([0.0, 0.0, 9.80665], (n, 1)) + 0.01 * rng.standard_normal((n, 3))
gyr = 0.001 * rng.standard_normal((n, 3))
found = navigate(time, acc, gyr, time % 3 < 1.5)
assert np.isfinite(found.position_m).all()
# The peak of the process that started this one counts too, if that was larger: hence the file.
print(int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1e6)
"""
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert float(out.stdout) < 1.0


def test_attitude_before_the_first_rest_is_not_invented():
    """A sensor that lies level, is tipped, and rests: no later rest tells its first attitude."""
    time, acc, gyr, _ = wobbling(4, noise=False)
    still = (time > 2.5) & (time < 3.5)
    with pytest.raises(InputError, match=r"not still at the first sample.*begins at sample 251"):
        navigate(time, acc, gyr, still)


def test_refuses_what_cannot_be_navigated():
    time, acc, gyr, still = wobbling(3)
    with pytest.raises(InputError, match="not still at the first sample"):
        navigate(time, acc, gyr, np.zeros(len(time), bool))
    with pytest.raises(InputError, match="runs backwards"):
        navigate(time[::-1], acc, gyr, still)
    with pytest.raises(InputError, match=r"acc_mps2: expected shape \(300, 3\)"):
        navigate(time, acc[:-1], gyr, still)
    with pytest.raises(InputError, match="closed_loop with smooth = False"):
        navigate(time, acc, gyr, still, smooth=False, closed_loop=ClosedLoop())
    with pytest.raises(InputError, match="acc_mps2: zero in the first rest"):
        navigate(time, np.zeros_like(acc), gyr, still)
    huge = acc.copy()
    huge[250] = 1e300
    fastest = np.abs(interval_means(acc, gyr, DT)[1]).max()
    says = rf"no finite end: the largest readings are 1e\+300 m/s² and {fastest:.3g} rad/s"
    with pytest.raises(InputError, match=says), np.errstate(all="ignore"):
        navigate(time, huge, gyr, still)


START = NavigationState(np.array([1.0, 0.0, 0.0, 0.0]), *np.zeros((4, 3)))


def entries(time, acc, gyr, still):
    """Each public entry that may reach a compiled loop, with what it is given."""
    p = 1e-4 * np.eye(15)
    return {
        "interval_means": lambda: interval_means(acc, gyr, DT),
        "integrate_strapdown": lambda: integrate_strapdown(time, acc, gyr, START, still=still),
        "navigate": lambda: navigate(time, acc, gyr, still),
        "run_filter": lambda: run_filter(time, acc, gyr, still, START, p, NavigationSettings()),
    }


@pytest.mark.parametrize("entry", entries(*[None] * 4))
@pytest.mark.parametrize("what", ["acc", "gyr", "longer gyr", "still", "NaN", "inf", "text", "1-D"])
def test_entries_of_compiled_loops_refuse_arrays_that_do_not_fit(entry, what):
    """Unequal lengths would be written beyond their ends; one message for each instead."""
    time, acc, gyr, still = wobbling(6)
    given = {"time": time, "acc": acc, "gyr": gyr, "still": still}
    if what in ("acc", "gyr", "still"):
        given[what] = given[what][:10]
    elif what == "longer gyr":
        given["gyr"] = np.vstack([gyr, gyr])
    elif what in ("NaN", "inf"):
        given["acc"] = acc.copy()
        given["acc"][7, 1] = float(what)
    elif what == "text":
        given["gyr"] = [["a", "b", "c"]] * len(time)
    else:
        given["acc"], given["gyr"] = acc[0], gyr[0]
    free = entry == "interval_means" and what in ("still", "NaN", "inf")
    if free:  # it knows no flags; a reading that is no number spoils its neighbours alone
        means = entries(**given)[entry]()
        assert np.isfinite(means[0]).all(axis=1).sum() >= len(time) - 3
    else:
        with pytest.raises(InputError):
            entries(**given)[entry]()


@pytest.mark.parametrize("entry", entries(*[None] * 4))
def test_entries_of_compiled_loops_take_every_kind_of_array(entry):
    """Lists, other types, read-only and strided arrays give what plain arrays give."""
    time, acc, gyr, still = wobbling(3)
    acc32, gyr32 = acc.astype(np.float32), gyr.astype(np.float32)
    given = time, acc32.astype(float), gyr32.astype(float), still
    expected = entries(*given)[entry]()
    frozen = [values.copy() for values in given]
    for values in frozen:
        values.setflags(write=False)
    strided = [np.repeat(values, 2, axis=0)[::2] for values in given]
    fortran = [np.asfortranarray(values) for values in given]
    for other in (
        (time, acc32, gyr32, still.astype(np.int8)),
        [values.tolist() for values in given],
        frozen,
        strided,
        fortran,
    ):
        found = entries(*other)[entry]()
        if entry == "interval_means":
            pairs = list(zip(found, expected, strict=True))
        else:
            pairs = [(found.position_m, expected.position_m), (found.sd, expected.sd)]
        assert all(np.array_equal(a, b, equal_nan=True) for a, b in pairs)
    for values, plain in zip(given, wobbling(3), strict=True):
        assert values.shape == plain.shape  # and what was given is as it was
    assert np.array_equal(given[1], acc32.astype(float))


@pytest.mark.parametrize(
    "covariance",
    [
        np.eye(6),
        np.full((15, 15), np.nan),
        -np.eye(15),
        np.diag([1.0] * 14 + [-1e-9]),
        np.triu(np.ones((15, 15))),
        np.eye(15) + np.eye(15, k=1) * 1e-3,
    ],
)
def test_covariances_that_are_none_are_refused(covariance):
    time, acc, gyr, still = wobbling(3)
    with pytest.raises(InputError, match="covariance"):
        run_filter(time, acc, gyr, still, START, covariance, NavigationSettings())


def test_other_arguments_that_do_not_fit_are_refused():
    time, acc, gyr, still = wobbling(3)
    chosen, p = NavigationSettings(), np.eye(15)
    with pytest.raises(InputError, match=r"observed \(1, 4\): expected \(300, 4\)"):
        run_filter(time, acc, gyr, still, START, p, chosen, observed=np.zeros((1, 4)))
    with pytest.raises(InputError, match=r"cut: expected shape \(300,\)"):
        run_filter(time, acc, gyr, still, START, p, chosen, cut=np.zeros(3, bool))
    with pytest.raises(InputError, match=r"start\.quaternion"):
        run_filter(time, acc, gyr, still, START._replace(quaternion=np.zeros(4)), p, chosen)
    with pytest.raises(InputError, match="position_m"):
        run_filter(time, acc, gyr, still, START._replace(position_m=np.zeros(2)), p, chosen)
    with pytest.raises(InputError, match=r"dt_s = -0\.01: expected a positive number"):
        interval_means(acc, gyr, -DT)
    for call in (
        lambda: step_transition(START, acc[0], gyr[0], DT, form="prnted"),
        lambda: error_dynamics(START.quaternion, gyr[0], acc[0], form="prnted"),
        lambda: NavigationSettings(form="prnted"),
    ):
        with pytest.raises(InputError, match="form = 'prnted': expected 'corrected' or 'printed'"):
            call()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gyr_noise_factor", True), ("acc_bias_walk_mps2_sqrts", -1), ("upright_rad", np.nan),
        ("velocity_noise_mps_sqrthz", "0.1"), ("zero_rate", "no"), ("initial_gyr_mean", 1),
        ("moving_stride", 0), ("resting_stride", 2.0), ("resting_stride", True),
    ],
)  # fmt: skip
def test_settings_that_are_impossible_are_refused(name, value):
    with pytest.raises(InputError, match=f"NavigationSettings.{name} = "):
        NavigationSettings(**{name: value})
    with pytest.raises(InputError, match=r"ClosedLoop.heading_sd_rad = 0"):
        ClosedLoop(heading_sd_rad=0)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("acc_noise_factor", 1e-12, 1e6),
        ("gyr_bias_prior_sd_radps", 1e-12, 1e6),
        ("resting_stride", 1, 10**6),
        ("moving_stride", 1, 10**6),
        ("upright_rad", 1e-12, np.pi),
    ],
)
def test_settings_hold_up_to_the_sizes_that_the_filter_can_square(name, low, high):
    for value in (low, high):
        assert getattr(NavigationSettings(**{name: value}), name) == value
    beyond = (0, high + 1) if isinstance(high, int) else (0.9 * low, 1.1 * high)
    for value in beyond:
        with pytest.raises(InputError, match=name):
            NavigationSettings(**{name: value})


def test_settings_take_numbers_of_numpy():
    chosen = NavigationSettings(gyr_noise_factor=np.float32(0.25), moving_stride=np.int64(8))
    assert chosen.gyr_noise_factor == 0.25 and chosen.moving_stride == 8


def test_navigation_is_a_result():
    """It is pickled and copied, cannot be changed, prints in one line and becomes a table."""
    chosen = NavigationSettings(zero_rate=False)
    path = navigate(*wobbling(3), chosen)
    for other in (pickle.loads(pickle.dumps(path)), copy.deepcopy(path)):
        assert np.array_equal(other.position_m, path.position_m) and other.settings == chosen
        assert not other.position_m.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        path.sd[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        GRAVITY_MPS2[2] = -9.8
    assert path != navigate(*wobbling(3), chosen) and path.warnings == ()
    assert "\n" not in repr(path) and "position_m[300 x 3]" in repr(path)
    table = path.to_frame()
    assert np.array_equal(table[["x_m", "y_m", "z_m"]], path.position_m)
    assert np.array_equal(table[["qw", "qx", "qy", "qz"]], path.quaternion)
    assert np.array_equal(table["velocity_z_sd_mps"], path.sd[:, 11])
    assert np.array_equal(path.state(-1).velocity_mps, path.velocity_mps[-1])


def test_the_start_is_known_as_well_as_its_rest_is_long():
    """A bias b of the accelerometer leans the first attitude by b/g; both err together.

    By finite differences: the attitude that a biased rest gives against the true one. The turn
    about the vertical is a matter of choice.
    """
    rng = np.random.default_rng(6)
    force = Rotation.random(random_state=6).inv().apply(G)
    settings = NavigationSettings()
    noise, bias_sd = settings.noise(), settings.acc_bias_sd_mps2
    for rest in (100, 400):
        count = rest + 100
        clock, still = DT * np.arange(count), np.arange(count) < rest
        rate = np.tile([0.01, -0.02, 0.03], (count, 1)) + np.where(still, 0, 1)[:, None]
        true, p = navigation._start(clock, np.tile(force, (count, 1)), rate, still, settings)
        assert np.allclose(true.gyr_bias_radps, [0.01, -0.02, 0.03])
        up = force / np.linalg.norm(force)
        flat = np.eye(3) - np.outer(up, up)
        assert np.allclose(rotation_world_to_imu(true.quaternion)[:, 2], up)
        length = rest * DT
        size = (bias_sd**2 + noise.acc / length) / (2 * STANDARD_GRAVITY_MPS2) ** 2
        assert np.allclose(p[0:3, 0:3], size * flat + 1e-10 * np.eye(3), rtol=1e-9, atol=1e-15)
        b = 1e-5 * rng.normal(size=3)
        biased, _ = navigation._start(clock, np.tile(force + b, (count, 1)), rate, still, settings)
        error = aligned(true._replace(acc_bias_mps2=b), biased)
        assert np.allclose(flat @ p[0:3, 12:15] @ b / bias_sd**2, flat @ error[:3], atol=1e-11)
        assert np.array_equal(p, p.T) and np.allclose(p[12:15, 12:15], bias_sd**2 * np.eye(3))
        gyr_var = settings.gyr_bias_sd_radps**2 + noise.gyr / length
        assert np.allclose(p[3:6, 3:6], gyr_var * np.eye(3))


def test_intervals_reach_from_midpoint_to_midpoint_and_moves_last_as_long():
    clock = np.array([0.0, 0.1, 0.2, 0.5, 0.6, 0.8])
    interval = navigation._intervals(clock)
    assert np.allclose(interval, [0.1, 0.1, 0.2, 0.2, 0.15, 0.2])
    still = np.array([True, False, False, True, False, True])
    for longest, expected in ((0.31, [0, 0, 0, 0, 0, 0]), (0.29, [0, 1, 1, 0, 0, 0])):
        found = navigation._long_moves(still, interval, longest)
        assert found.tolist() == np.array(expected, bool).tolist()


def test_samples_lie_in_the_middle_of_their_intervals():
    """States are means of both ends; within strides of 2 and 3 samples variances are linear."""
    states = np.zeros((6, 16))
    states[:, 0] = 1.0
    states[:, 4:] = np.arange(6)[:, None] * np.arange(1, 13)
    variances = np.outer([0.0, 1.0, 4.0], np.ones(16))
    variances[:, 15] *= -0.5
    nothing = np.zeros(5)
    path = navigation._at_samples(
        DT * np.arange(5), states, np.array([2, 5]), variances, nothing > 0, nothing,
        nothing.astype(int), None,
    )  # fmt: skip
    assert np.allclose(path.position_m, np.outer(np.arange(5) + 0.5, [1, 2, 3]))
    assert np.allclose(path.acc_bias_mps2, np.outer(np.arange(5) + 0.5, [10, 11, 12]))
    expected = np.array([0.25, 0.75, 1.5, 2.5, 3.5])
    assert np.allclose(path.sd**2, expected[:, None])
    assert np.allclose(path.xy_covariance_m2, -0.5 * expected)


@pytest.mark.parametrize("way", ["plain", pytest.param("compiled", marks=needs_numba)])
def test_what_is_observed_of_a_stride_is_its_mean(way, monkeypatch):
    """Velocity and height that go from -0.1 to 0.1 within each stride observe a mean of zero."""
    monkeypatch.setattr(navigation, "choose", lambda *_, **__: way)
    time, acc, gyr, _ = wobbling(2)
    rest, still = 100, np.arange(len(time)) < 100
    chosen = NavigationSettings(resting_stride=4)
    p, moved = 1e-4 * np.eye(15), []
    ends = stride_ends(still, np.zeros(len(time), bool), chosen.moving_stride, 4)
    sizes = np.diff(ends, prepend=0)
    within = np.concatenate([np.linspace(-1, 1, n) if n > 1 else [0.0] for n in sizes])
    for size, offset in ((0.0, 0.0), (0.1, 0.0), (0.0, 0.01)):
        seen = (size * within + offset * (np.arange(len(time)) < rest))[:, None] * np.ones(4)
        path = run_filter(time, acc, gyr, still, START, p, chosen, observed=seen, smooth=False)
        moved.append(path.velocity_mps[rest - 1])
    assert np.allclose(moved[1], moved[0], atol=1e-12)
    # A rest of a second that is seen to move by 1 cm/s moves by that.
    assert np.allclose(moved[2] - moved[0], 0.01, rtol=0.05)


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_the_upward_axis_is_that_of_the_world_in_the_axes_of_the_imu(seed):
    state, _ = random_state(seed)
    turn = Rotation.from_quat(state.quaternion, scalar_first=True)
    assert np.allclose(world_up(state), turn.inv().apply([0, 0, 1.0]), atol=1e-12)
