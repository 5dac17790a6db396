"""The loops of the fusion one by one, readable: against a mechanism, differences, one vector."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scooters import (
    COS,
    KNOWN,
    LEAN,
    SIN,
    TIMES,
    body_turn,
    lever_turn,
    rate_of,
    readings_at,
    slope,
    state_at,
    steering,
    tip,
)

from mobility_imu.hinges import hinge_rates
from mobility_imu.scooter import SUZUKI_ET4D, fusion
from mobility_imu.scooter import fusion_filter as loops

arm_acceleration, reading_errors, true_rate, predict, measurement, correct, run_filter, smoother = (
    loops.plain(function)
    for function in (
        loops.arm_acceleration, loops.reading_errors, loops._true_rate, loops.predict,
        loops._measurement, loops.correct, loops.run_filter, loops.run_smoother,
    )
)  # fmt: skip


MODEL = fusion._model(KNOWN, SUZUKI_ET4D, 100.0)


@pytest.mark.parametrize("t", TIMES)
def test_hinges_turn_by_the_difference_of_the_gyroscopes(t):
    lever, body = rate_of(lever_turn, t), rate_of(body_turn, t)
    rates = loops.plain(hinge_rates)(lever, body, steering(t), tip(t), SIN, COS)
    assert_allclose(rates[:2], [slope(steering, t), slope(tip, t)], atol=1e-9)


@pytest.mark.parametrize("t", TIMES)
@pytest.mark.parametrize("which", [0, 1, 2])
def test_lever_arms_explain_what_sensors_apart_read(t, which):
    """The arms of lever, body and column, each alone, and the motion of the mechanism: no rest."""
    arms = np.zeros((3, 3))
    arms[which] = [0.3, -0.2, 0.25]
    inputs, c = readings_at(t, arms), np.zeros(loops.CONSTANTS)
    c[loops.ARMS :] = arms.ravel()
    slow = inputs.body_acc[0]
    rest, *_ = measurement(inputs, 0, state_at(t), c, slow, MODEL)
    assert_allclose(rest, 0, atol=1e-6)
    without, *_ = measurement(inputs, 0, state_at(t), 0 * c, slow, MODEL)
    assert np.abs(without).max() > 0.02


def misread(true, c):
    """Readings of a sensor by its offset, scale and misalignment."""
    return true + c[:3] + c[3:6] * true + np.cross(c[6:9], true)


@pytest.mark.parametrize("at", [0, loops.BODY])
@pytest.mark.parametrize("which", range(9))
def test_errors_of_the_accelerometers_explain_the_residual(at, which):
    t, c = 1.1, np.zeros(loops.CONSTANTS)
    c[at + which] = 1e-4
    inputs = readings_at(t, np.zeros((3, 3)))
    acc = inputs.lever_acc if at == 0 else inputs.body_acc
    acc[0] = misread(acc[0], c[at:])
    rest, _, by_c = measurement(inputs, 0, state_at(t), c, inputs.body_acc[0], MODEL)
    assert_allclose(rest, 0, atol=1e-6)
    without, *_ = measurement(inputs, 0, state_at(t), 0 * c, inputs.body_acc[0], MODEL)
    assert_allclose(without, by_c @ c, atol=1e-6)
    assert np.abs(without).max() > 1e-5


def test_slopes_of_the_measurement_are_those_of_its_residual():
    """By angles and disturbance, where the smoothed acceleration is that of the sample."""
    t = 1.1
    inputs, x = readings_at(t, np.zeros((3, 3))), state_at(t) + 0.01
    inputs.lever_acc[:] += 0.5
    none, slow = np.zeros(loops.CONSTANTS), inputs.body_acc[0]
    residual, h, _ = measurement(inputs, 0, x, none, slow, MODEL)
    for k in range(loops.STATES):

        def moved(value, k=k):
            other = x.copy()
            other[k] += value
            return measurement(inputs, 0, other, none, slow, MODEL)[0]

        assert_allclose(slope(moved, 0.0), -h[:, k], atol=1e-8)
    assert np.abs(residual).max() > 0.1


def test_an_arm_is_accelerated_by_euler_and_centripetal():
    rng = np.random.default_rng(1)
    rate, spin, arm = rng.standard_normal((3, 3))
    expected = np.cross(spin, arm) + np.cross(rate, np.cross(rate, arm))
    assert_allclose(arm_acceleration(rate, spin) @ arm, expected, rtol=1e-12)


def test_errors_of_a_reading_and_a_rate_without_them():
    rng = np.random.default_rng(2)
    reading, c = rng.standard_normal(3), 0.1 * rng.standard_normal(loops.CONSTANTS)
    assert_allclose(reading_errors(reading) @ c[:9], misread(reading, c) - reading, rtol=1e-12)
    for at in (0, loops.BODY):
        turn, scale, offset = c[at + 6 :][:3] + c[at + 15 :][:3], c[at + 9 :][:3], c[at + 12 :][:3]
        expected = reading - np.cross(turn, reading) - scale * reading - offset
        assert_allclose(true_rate(reading, c, at), expected, rtol=1e-12)


# Prediction and correction: derivatives by differences, and the filter of one vector.


def any_estimate(seed=3, small=0.05):
    """An estimate whose state, constants and covariances are all of no special value."""
    rng = np.random.default_rng(seed)
    p, m = (
        size * (a @ a.T + np.eye(len(a)))
        for size, a in (
            (1e-3, rng.standard_normal((loops.STATES,) * 2)),
            (1e-4, rng.standard_normal((loops.CONSTANTS,) * 2)),
        )
    )
    v = small * rng.standard_normal((loops.STATES, loops.CONSTANTS))
    x, c = (small * rng.standard_normal(n) for n in (loops.STATES, loops.CONSTANTS))
    return loops.Estimate(x, p, v, c, m, np.array([0.1, 0.2, 9.8]))


RATES = (np.array([0.3, -0.5, 0.7]), np.array([-0.2, 0.4, 0.6]))


def predicted(before, x=None, c=None):
    """State after a sample, of other angles or constants."""
    at = before._replace(state=before.state if x is None else x)
    return predict(*RATES, at._replace(constants=before.constants if c is None else c), MODEL)[0]


def test_prediction_integrates_the_rates_of_the_hinges():
    before = any_estimate()
    x, c, dt = before.state, before.constants, MODEL.dt
    lever, body = true_rate(RATES[0], c, 0), true_rate(RATES[1], c, loops.BODY)
    rates = loops.plain(hinge_rates)(lever, body, x[0], x[1] + LEAN, SIN, COS)
    expected = np.r_[x[:2] + dt * (np.array(rates[:2]) - x[2:4]), x[2:4], MODEL.decay * x[4:]]
    assert_allclose(predicted(before), expected, rtol=1e-12)


def test_slopes_of_the_prediction_are_those_of_its_state():
    before = any_estimate()
    _, p, v, f = predict(*RATES, before, MODEL)
    for k in range(loops.STATES):

        def moved(value, k=k):
            return predicted(before, x=before.state + value * np.eye(loops.STATES)[k])

        assert_allclose(slope(moved, 0.0), f[:, k], atol=1e-10)
    for k in range(loops.CONSTANTS):

        def moved(value, k=k):
            return predicted(before, c=before.constants + value * np.eye(loops.CONSTANTS)[k])

        own = v[:, k] - f @ before.by_constants[:, k]
        assert_allclose(slope(moved, 0.0), own, atol=1e-10)
    wander = (1 - MODEL.decay**2) * MODEL.disturbance
    added = np.r_[np.repeat(MODEL.drift, 2), [wander] * 3]
    assert_allclose(p, f @ before.covariance @ f.T + np.diag(added), atol=1e-14)


@pytest.mark.parametrize("size", [0.01, 3.0])
def test_correction_is_that_of_one_vector_with_state_and_constants(size):
    """Within ``huber`` as any Kalman filter; beyond it, with the noise grown by the square."""
    before, rng = any_estimate(), np.random.default_rng(4)
    x, p, v, c, m, _ = before
    h, by_c = rng.standard_normal((3, loops.STATES)), rng.standard_normal((3, loops.CONSTANTS))
    residual, noise, huber = size * np.array([1.0, -2.0, 1.5]), 0.04, 2.0
    whole, slopes = np.block([[p + v @ m @ v.T, v @ m], [m @ v.T, m]]), np.hstack((h, by_c))
    spread = slopes @ whole @ slopes.T + noise * np.eye(3)
    distance = np.sqrt(residual @ np.linalg.solve(spread, residual) / 3)
    assert (distance > huber) == (size > 1)
    spread += noise * max(0.0, (distance / huber) ** 2 - 1) * np.eye(3)
    gain = np.linalg.solve(spread, slopes @ whole).T
    expected, left = np.r_[x, c] + gain @ residual, whole - gain @ slopes @ whole
    # The sums are those of a matrix of 52, with entries that cancel.
    x, p, v, c, m = correct(x, p, v, c, m, residual, h, by_c, noise, huber)
    assert_allclose(np.r_[x, c], expected, atol=1e-9)
    found = np.block([[p + v @ m @ v.T, v @ m], [m @ v.T, m]])
    assert_allclose(found, left, atol=1e-10)
    assert np.array_equal(p, p.T)


def small_problem(samples=40, settings=KNOWN):
    """Arguments of the loops: the mechanism moves, at 100 Hz, with noise and arms."""
    rng = np.random.default_rng(5)
    arms = np.array([[0.1, 0.05, 0.1], [0.0, 0.2, -0.1], [0.05, 0.0, 0.1]])
    each = [readings_at(0.3 + k / 100, arms) for k in range(samples)]
    rows = [np.concatenate(parts) for parts in zip(*each, strict=True)]
    inputs = loops.Inputs(*(rows[k] + 0.01 * rng.standard_normal(rows[k].shape) for k in range(6)))
    start = fusion._start(inputs, settings, SUZUKI_ET4D, 100.0)
    return inputs, start, fusion._model(settings, SUZUKI_ET4D, 100.0)


def one_vector(inputs, start, model):
    """Filter and smoother with one covariance of all 52, from the same slopes."""
    n, states = len(inputs.lever_acc), loops.STATES
    x, c, slow = start.state, start.constants, start.slow.copy()
    p = np.zeros((states + loops.CONSTANTS,) * 2)
    p[:states, :states], p[states:, states:] = start.covariance, start.constants_covariance
    zeros = np.zeros((states, states)), np.zeros((states, loops.CONSTANTS))
    after, before, steps, innovations = [], [], [], []
    for k in range(n):
        f = np.eye(len(p))
        if k:
            rates = ((v[k] + v[k - 1]) / 2 for v in (inputs.lever_gyr, inputs.body_gyr))
            at = loops.Estimate(x, *zeros, c, p, slow)
            x, noise, by_constants, transition = predict(*rates, at, model)
            f[:states, :states], f[:states, states:] = transition, by_constants
            p = f @ p @ f.T
            p[:states, :states] += noise
        steps.append(f)
        before.append((np.r_[x, c], p))
        slow += model.dt / loops.SLOPE_SMOOTHING_S * (inputs.body_acc[k] - slow)
        residual, h, by_c = measurement(inputs, k, x, c, slow, model)
        innovations.append(residual + x[4:])
        slopes = np.hstack((h, by_c))
        gain = np.linalg.solve(slopes @ p @ slopes.T + model.noise * np.eye(3), slopes @ p).T
        whole = np.r_[x, c] + gain @ residual
        x, c, p = whole[:states], whole[states:], p - gain @ slopes @ p
        after.append((whole, p))
    whole, p = after[-1]
    smoothed = [(whole, p)]
    for k in range(n - 2, -1, -1):
        gain = np.linalg.solve(before[k + 1][1], steps[k + 1] @ after[k][1]).T
        whole = after[k][0] + gain @ (whole - before[k + 1][0])
        p = after[k][1] + gain @ (p - before[k + 1][1]) @ gain.T
        smoothed.append((whole, p))
    return after, smoothed[::-1], innovations


def test_filter_and_smoother_are_those_of_one_vector():
    inputs, start, model = small_problem(settings=replace(KNOWN, huber=1e6))
    filtered, smoothed, innovations = one_vector(inputs, start, model)
    n = len(filtered)
    chunk, after = run_filter(inputs, 0, n, start, model, False)
    assert_allclose(chunk.states, [w[: loops.STATES] for w, _ in filtered], atol=1e-8)
    assert_allclose(chunk.sd, np.sqrt([np.diag(p)[:2] for _, p in filtered]), rtol=1e-6)
    assert_allclose(chunk.residuals, innovations, atol=1e-7)
    assert_allclose(after.constants, filtered[-1][0][loops.STATES :], atol=1e-8)
    chunk, after = run_filter(inputs, 0, n, start, model, True)
    states, spread, *_ = smoother(chunk, *after[:5])
    assert_allclose(states, [w[: loops.STATES] for w, _ in smoothed], atol=1e-6)
    assert_allclose(spread, np.sqrt([np.diag(p)[:2] for _, p in smoothed]), rtol=1e-4)


def test_filter_and_smoother_go_on_where_a_piece_ends():
    inputs, start, model = small_problem(20)
    for keep in (False, True):
        whole, last = run_filter(inputs, 0, 20, start, model, keep)
        first, between = run_filter(inputs, 0, 13, start, model, keep)
        rest, end = run_filter(inputs, 13, 20, between, model, keep)
        for k in (0, 2, *((3, 4, 5, 6) if keep else (1,))):
            assert_allclose(np.concatenate((first[k], rest[k])), whole[k], atol=1e-12)
        for one, other in zip(last, end, strict=True):
            assert_allclose(one, other, atol=1e-12)
    states, sd, *_ = smoother(whole, *last[:5])
    late, late_sd, *at = smoother(rest, *end[:5])
    early, early_sd, *_ = smoother(first, *at, *end[3:5])
    assert_allclose(np.concatenate((early, late)), states, atol=1e-10)
    assert_allclose(np.concatenate((early_sd, late_sd)), sd, rtol=1e-8)


def test_a_squared_distance_that_rounding_made_negative_is_none():
    """With extreme settings a covariance may lose its sign by rounding: no reading counts less."""
    constants, by_c = np.zeros(loops.CONSTANTS), np.zeros((3, loops.CONSTANTS))
    by_c[:, :3] = np.eye(3)
    lost = np.diag(np.full(loops.CONSTANTS, -1e-6))
    covariance, by_constants = (
        np.zeros((loops.STATES, loops.STATES)),
        np.zeros((loops.STATES, loops.CONSTANTS)),
    )
    x, *_, c, m = correct(
        np.zeros(loops.STATES), covariance, by_constants, constants, lost,
        np.ones(3), np.zeros((3, loops.STATES)), by_c, 1e-8, 3.0,
    )  # fmt: skip
    assert not x.any() and np.isfinite(c).all() and np.isfinite(m).all()
