"""Misfits from rest to rest, which are found for all moves at once: against one step at a time."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.spatial.transform import Rotation

from mobility_imu.rotations import cross_matrix
from mobility_imu.runs import runs_of
from mobility_imu.walker.rest_checks import GRAVITY_S, Readings, _Batch
from mobility_imu.walker.turned_sums import (
    SERIES,
    Attitudes,
    Moved,
    sums_in_a_loop,
    sums_in_arrays,
)

LENGTHS = [80, 30, 40, 47, 25, 20, 60, 1, 90]
"""Samples of rests and moves in turn; some rests are shorter than gravity is averaged over."""
LEANS_RAD = [0.0, 0.01, 0.2, 0.21, 0.2]
"""Of the rests: the second move sets the frame down tilted."""


@pytest.fixture(scope="module")
def readings():
    """Moves of any kind between rests, on a clock that is not even."""
    rng = np.random.default_rng(7)
    still = np.repeat(np.arange(len(LENGTHS)) % 2 == 0, LENGTHS)
    count = len(still)
    time_s = np.cumsum(0.01 * rng.uniform(0.8, 1.2, count))
    acc, gyr = 2.0 * rng.standard_normal((count, 3)) + [0, 9, 3], rng.standard_normal((count, 3))
    for rest, lean in zip(runs_of(still), LEANS_RAD, strict=True):
        acc[rest] = Rotation.from_rotvec([lean, 0, 0]).apply([1.0, 9.5, 2.0])
        acc[rest] += 0.01 * rng.standard_normal(acc[rest].shape)
        gyr[rest] = [0.02, -0.01, 0.03] + 0.001 * rng.standard_normal(gyr[rest].shape)
    return Readings(time_s, acc, gyr, still)


def attitudes(readings, span, factors, lag, askew):
    """Of a move against its first sample, each from the one before by the mean of two rates."""
    rates = (readings.gyr_radps - readings.offset()) * factors
    rates = rates @ (np.eye(3) + cross_matrix(askew)).T
    last = len(rates) - 1
    found = [Rotation.identity()]
    for k in range(span.start, span.stop - 1):
        before, after = np.clip([k + lag, k + lag + 1], 0, last)
        step = readings.time_s[k + 1] - readings.time_s[k]
        found.append(found[-1] * Rotation.from_rotvec((rates[before] + rates[after]) / 2 * step))
    return found


def misfit(readings, before, after, turned, offset):
    """Velocity and gravity's direction at the end of one move, and height, by trapezia."""
    time_s, acc = readings.time_s, readings.acc_mps2 + offset
    window = int(GRAVITY_S * readings.rate_hz)
    parts = (
        slice(max(before.start, before.stop - window), before.stop),
        slice(after.start, min(after.stop, after.start + window)),
    )
    stood = [readings.acc_mps2[part].mean(axis=0) for part in parts]
    first, last = (mean + offset for mean in stood)
    sizes = np.linalg.norm(first), np.linalg.norm(last)
    axis = np.cross(first / sizes[0], [0, 0, 1])
    angle = np.arctan2(np.linalg.norm(axis), first[2] / sizes[0])
    upright = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    span = slice(before.stop - 1, after.start + 1)
    force = np.array([(upright * q).apply(f) for q, f in zip(turned, acc[span], strict=True)])
    lean = (upright * turned[-1]).apply(last / sizes[1])[:2]
    clock = time_s[span] - time_s[span.start]
    part = (clock / clock[-1])[:, None]
    down = sizes[0] + (sizes[1] - sizes[0]) * part
    force = force - down * np.hstack([part * lean, np.ones_like(part)])
    speed = cumulative_trapezoid(force, clock, axis=0, initial=0)
    height = trapezoid((speed - part * speed[-1])[:, 2], clock)
    cosine = stood[0] @ stood[1] / np.prod([np.linalg.norm(mean) for mean in stood])
    back = np.rad2deg(np.arccos(cosine)) < 2
    return np.concatenate([speed[-1], np.rad2deg(lean), [height * back]])


@pytest.mark.parametrize("times", [1.0, 57.3], ids=["", "another unit"])
@pytest.mark.parametrize("sums", [sums_in_arrays, sums_in_a_loop])
@pytest.mark.parametrize("lag", [0, 12, -100])
def test_misfits_of_all_moves_are_those_of_each(readings, lag, sums, times):
    factors, askew = times * np.array([1.1, -0.8, 1.0]), np.array([0.01, -0.02, 0.03])
    offset = np.array([0.1, -0.2, 0.05])
    batch = _Batch(readings)
    batch.sums = sums
    found = batch.misfit(batch.turned(factors, lag / readings.rate_hz, askew), offset)
    pairs = list(pairwise(runs_of(readings.still)))
    assert batch.spans == [slice(a.stop - 1, b.start + 1) for a, b in pairs] and len(pairs) == 4
    for (before, after), span, row in zip(pairs, batch.spans, found, strict=True):
        turned = attitudes(readings, span, factors, lag, askew)
        assert np.allclose(row, misfit(readings, before, after, turned, offset), atol=1e-9)
    assert (found[:, 5] != 0).tolist() == [True, False, True, True]


@pytest.mark.parametrize("sums", [sums_in_arrays, sums_in_a_loop])
@pytest.mark.parametrize("times", [0.99, 1.01])
def test_turns_are_exact_where_a_series_ends(times, sums):
    """At a constant rate: what the series of sine and cosine leave out is rounding."""
    count, step, force = 200, 0.01, np.array([1.0, -2.0, 9.8])
    rate = np.sqrt(times * SERIES) * 2 / step * np.array([2.0, -1.0, 2.0]) / 3
    moved = Moved(
        *(np.array([0]), np.array([count]), np.tile(rate, (count, 1))),
        *(np.full((1, count - 1), step), np.tile(force, (1, count, 1)), np.ones((1, 1, count))),
    )
    turned = Rotation.from_rotvec(np.outer(np.arange(count) * step, rate))
    found = sums(moved, 0, np.eye(3))
    assert np.allclose(found.forces[0, 0], turned.apply(force).sum(axis=0), rtol=0, atol=1e-10)


@pytest.mark.parametrize("count", [1, 2, 3, 8, 21])
def test_pairs_of_complex_numbers_turn_as_rotations_do(count):
    rng = np.random.default_rng(count)
    each = [[Rotation.random(random_state=rng) for _ in range(count)] for _ in range(3)]
    x, y, z, w = np.moveaxis([[q.as_quat() for q in row] for row in each], -1, 0)
    found = Attitudes(w + 1j * x, y + 1j * z).running_products()
    vectors = rng.standard_normal((3, count, 3))
    rows = np.empty((3, 9, count))
    found.rows(rows)
    matrices = np.moveaxis(rows, 1, 2).reshape(3, count, 3, 3)
    applied = (matrices @ vectors[..., None])[..., 0]
    for row, of_row, right in zip(each, vectors, applied, strict=True):
        whole = Rotation.identity()
        for q, vector, turned in zip(row, of_row, right, strict=True):
            whole = whole * q
            assert np.allclose(whole.apply(vector), turned)
