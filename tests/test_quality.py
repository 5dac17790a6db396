"""Sensors that repeat themselves, and sensors at the end of their range."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.quality import (
    frozen_samples,
    resolution_of,
    saturated_samples,
    turned_gravity,
)
from mobility_imu.runs import long_runs
from mobility_imu.simulation.profiles import window

RATE_HZ = 100
DEAD, DEAD_IN_MOTION = slice(3000, 3200), slice(700, 800)


def noise(count=600, axes=3):
    return np.random.default_rng(3).standard_normal((count, axes))


def test_a_sensor_that_works_is_neither():
    assert not frozen_samples(noise(), 100).any() and not saturated_samples(noise()).any()


def test_a_sensor_that_repeats_itself():
    stuck = noise()
    stuck[200:260] = stuck[200]
    assert np.nonzero(frozen_samples(stuck, 100))[0].tolist() == list(range(200, 260))
    short = noise()
    short[200:220] = short[200]  # a fifth of a second
    assert not frozen_samples(short, 100).any()
    one_axis = noise()
    one_axis[200:260, 0] = 0
    assert not frozen_samples(one_axis, 100).any()


def test_from_the_first_sample_on():
    assert frozen_samples(np.ones((600, 3)), 100).all()


@pytest.mark.parametrize("kind", [float, np.float32, np.int16])
def test_the_end_of_a_range_at_either_side(kind):
    """Of int16 the most negative number has no absolute value."""
    acc = np.round(1000 * noise()).astype(kind)
    acc[100:105, 1] = -32768
    acc[300:302, 1] = -32768  # two samples may be a blow
    assert np.nonzero(saturated_samples(acc))[0].tolist() == list(range(100, 105))
    assert saturated_samples(acc, run=2).sum() == 7


def rests_and_moves(seed, noise, step, size, seconds=60):
    """Accelerations, m/s², before and after rounding: rests of 5 s between movements of 5 s."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(seconds * RATE_HZ) / RATE_HZ
    waves = [np.sin(2 * np.pi * f * time_s + phase) for f, phase in ((0.7, 0), (1.1, 1), (1.9, 2))]
    moving = sum(window(time_s, start, start + 5, 0.5) for start in range(5, seconds, 10))
    true = size * np.column_stack(waves) * moving[:, None] + [0, 0, 9.8]
    # Nobody chooses where in its step a reading rests.
    true = true + step * rng.uniform(-0.5, 0.5, 3) + rng.normal(0, noise, true.shape)
    return true, np.round(true / step) * step


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 999),
    step=st.sampled_from([0.0006, 0.0024, 0.0098, 0.03, 0.098]),
    noise_per_step=st.floats(0.2, 20),
    size=st.sampled_from([0.0, 0.3, 2.0]),
)
def test_a_sensor_that_works_is_neither_at_any_resolution(seed, step, noise_per_step, size):
    """From 1/16384 g to 0.01 g, from noise that seldom reaches the next step to twenty."""
    _, acc = rests_and_moves(seed, noise_per_step * step, step, size)
    assert not frozen_samples(acc, RATE_HZ).any()
    assert not saturated_samples(acc).any()


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 999),
    step=st.sampled_from([0.0006, 0.0024, 0.0098, 0.03, 0.098]),
    noise_per_step=st.floats(1.0, 20),
    size=st.sampled_from([0.0, 0.3, 2.0]),
)
def test_fine_readings_that_repeat_are_frozen_at_rest_and_in_motion(
    seed, step, noise_per_step, size
):
    _, acc = rests_and_moves(seed, noise_per_step * step, step, size)
    for dead in (DEAD, DEAD_IN_MOTION):
        stuck = acc.copy()
        stuck[dead] = stuck[dead.start]
        found = np.nonzero(frozen_samples(stuck, RATE_HZ))[0]
        assert found.min() >= dead.start - 2 and found.max() < dead.stop + 2
        assert set(range(dead.start, dead.stop)) <= set(found)


@pytest.mark.parametrize("noise", [0.02, 0.05])
@pytest.mark.parametrize("seed", range(3))
def test_a_coarse_sensor_is_frozen_if_others_feel_what_it_does_not(noise, seed):
    """Steps of 0.01 g. Dead in motion, others tell; dead at rest, nothing is lost."""
    true, acc = rests_and_moves(seed, noise, 0.098, 2.0)
    stuck = acc.copy()
    for dead in (DEAD, DEAD_IN_MOTION):
        stuck[dead] = stuck[dead.start]
    assert not frozen_samples(stuck, RATE_HZ).any()
    found = np.nonzero(frozen_samples(stuck, RATE_HZ, follows=[true]))[0]
    assert set(found) >= set(range(700, 800)) and found.min() >= 698 and found.max() < 802


def test_an_accelerometer_beside_a_gyroscope_that_turns():
    """It expects the gravity to turn as it does; and nothing of a sensor at rest."""
    time_s = np.arange(300) / RATE_HZ
    angle = 0.5 * np.sin(2 * time_s)
    acc = 9.81 * np.column_stack([np.zeros(300), np.sin(angle), np.cos(angle)])
    gyr = np.column_stack([np.gradient(angle, time_s), np.zeros(300), np.zeros(300)])
    expected = turned_gravity(acc, gyr + 0.03, RATE_HZ)  # an offset of 1.7 deg/s as well
    moved = np.ptp(acc, axis=0)
    assert np.allclose(np.ptp(expected, axis=0)[1:], moved[1:], rtol=0.1, atol=0.1)
    stuck = np.round(acc / 0.098) * 0.098
    stuck[100:180] = stuck[100]
    assert frozen_samples(stuck, RATE_HZ, follows=[expected])[100:180].all()
    still = np.tile([0.0, 0.0, 9.8], (300, 1))
    assert np.ptp(turned_gravity(still, 0 * still + 0.05, RATE_HZ), axis=0).max() < 1e-9


@pytest.mark.parametrize(("axis_deg", "frozen"), [(0, False), (20, True), (90, True)])
def test_a_turn_about_gravity_lets_a_coarse_accelerometer_repeat_itself(axis_deg, frozen):
    """A frame that turns on the spot: gravity and the centripetal force stay in its axes.

    The same readings while it turns about a level axis are those of an accelerometer that hangs.
    """
    acc = np.tile([0.9, 0.0, 9.8], (600, 1)) + np.random.default_rng(3).normal(0, 0.05, (600, 3))
    acc[200:320] = [0.9, 0.0, 9.8]
    acc = np.round(acc / 0.0981) * 0.0981
    gyr = np.zeros((600, 3))
    tilt = np.deg2rad(axis_deg)
    gyr[180:340] = 2.1 * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    found = frozen_samples(acc, RATE_HZ, follows=[turned_gravity(acc, gyr, RATE_HZ)])
    assert found[200:320].all() if frozen else not found.any()


def test_what_is_followed_has_the_shape_of_the_values():
    with pytest.raises(InputError, match=r"follows: expected shape \(600, 3\), got \(600, 2\)"):
        frozen_samples(noise(), 100, follows=[noise(axes=2)])


def test_samples_that_are_held_do_not_pass_for_a_coarse_resolution():
    """Doubled samples repeat on all axes at once: the steps are as fine as before."""
    held = np.repeat(noise(3000), 2, axis=0)
    assert not resolution_of(held).coarse.any()
    held[2000:2100] = held[2000]
    assert frozen_samples(held, 100)[2000:2100].all()


@pytest.mark.parametrize("end", [0, 1])
def test_a_coarse_sensor_that_is_shaken_whenever_it_does_not_rest(end):
    """A straight trial: nothing but the rests at both ends shows how large the steps are."""
    rng = np.random.default_rng(5)
    acc = np.tile([-7.06, 5.2, 4.32], (700, 1)) + rng.normal(0, 0.015, (700, 3))
    acc[100:600] += rng.normal(0, 1.0, (500, 3))
    acc = np.round(acc / 0.0981) * 0.0981
    still = np.zeros_like(acc)
    assert not frozen_samples(acc, RATE_HZ, follows=[still]).any()
    # Another sensor that felt it turn there tells of a rest that was none; zeros are no rest.
    turned = still.copy()
    turned[20:, 0], turned[640:, 1] = 4.0, 4.0
    assert frozen_samples(acc, RATE_HZ, follows=[turned])[[50, 650]].all()
    rest = slice(0, 90) if end == 0 else slice(610, 700)
    lost = acc.copy()
    lost[rest] = lost[300:340] = 0.0
    assert frozen_samples(lost, RATE_HZ, follows=[still])[rest].all()


def test_one_fine_axis_speaks_for_all():
    """A coarse accelerometer and a fine gyroscope in one table: only a dead table repeats."""
    _, acc = rests_and_moves(1, 0.02, 0.098, 2.0)
    both = np.hstack([acc, 0.002 * noise(len(acc))])
    assert not frozen_samples(both, RATE_HZ).any()
    both[DEAD] = both[DEAD.start]
    assert frozen_samples(both, RATE_HZ)[DEAD].all()


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 999),
    step=st.sampled_from([0.0006, 0.0098, 0.098]),
    noise_per_step=st.floats(0.2, 3),
    most=st.floats(0.5, 0.9),
)
def test_a_range_that_is_cut_is_found_at_any_resolution(seed, step, noise_per_step, most):
    """Movements of 8 m/s², at the range's end for a tenth of a second and more.

    Of samples in runs of three, nine of ten are found; with noise above 0.15 m/s² eight, for it
    breaks up a cut that is hardly deeper (855 of 1000 in the worst of 1000 draws at 0.3 m/s²).
    """
    noise = noise_per_step * step
    _, acc = rests_and_moves(seed, noise, step, 8.0)
    limit = np.round(most * 8.0 / step) * step
    acc[:, 0] = np.clip(acc[:, 0], -limit, limit)
    found = saturated_samples(acc)
    at_limit = np.abs(acc[:, 0]) == limit
    assert not found[~at_limit].any()
    assert found[long_runs(at_limit, 3, grow=False)].mean() > (0.9 if noise <= 0.15 else 0.8)


def test_a_lever_that_rests_at_its_end_is_not_saturated():
    """The largest reading for seconds, in steps of 0.01 g: a stop, no end of the range."""
    time_s = np.arange(3000) / RATE_HZ
    angle = np.deg2rad(80) * sum(window(time_s, start, start + 5, 0.6) for start in range(2, 27, 8))
    acc = 9.81 * np.column_stack([np.zeros(3000), np.sin(angle), np.cos(angle)])
    for seed in range(10):
        rough = acc + np.random.default_rng(seed).normal(0, 0.02, acc.shape)
        assert not saturated_samples(np.round(rough / 0.098) * 0.098).any()


def real(name, *patterns):
    folder = find_folder(name)
    if folder is None:
        pytest.skip(f"{name} is not here")
    return sorted(path for pattern in patterns for path in folder.rglob(pattern))


def triads(table, quantity, unit):
    for column in table.columns:
        if column.endswith(f"_{quantity}_x_{unit}"):
            sensor = column[: -len(f"_{quantity}_x_{unit}")]
            yield sensor, table[[f"{sensor}_{quantity}_{a}_{unit}" for a in "xyz"]].to_numpy()


@pytest.mark.parametrize(
    ("name", "patterns"),
    [
        ("one-hinge", ["pitch_*[mw].csv.gz"]),
        ("two-hinges", ["trial1_[rf]*[md].csv.gz"]),
        ("labelled-walks", ["walk_*.csv.gz"]),
    ],
)
def test_no_real_sensor_that_works_is_frozen_or_saturated(name, patterns):
    """A base on its table, a walking frame that is set down, a chain in hands."""
    files = [path for path in real(name, *patterns) if "truth" not in path.name]
    assert files
    for path in files:
        table = pd.read_csv(path)
        rate = 1 / np.median(np.diff(table["time_s"]))
        turned = dict(triads(table, "gyr", "radps"))
        for sensor, acc in triads(table, "acc", "mps2"):
            follows = [turned_gravity(acc, turned[sensor], rate)]
            assert not frozen_samples(acc, rate, follows=follows).any(), (path.name, sensor)
            assert not saturated_samples(acc).any(), (path.name, sensor)


def test_a_real_coarse_sensor_that_dies_while_it_is_turned():
    """The lever of one hinge, in steps of 0.01 g, held for a second of a sweep."""
    for path in real("one-hinge", "pitch_medium.csv.gz"):
        table = pd.read_csv(path)
        rate = 1 / np.median(np.diff(table["time_s"]))
        acc = dict(triads(table, "acc", "mps2"))["lever"].copy()
        gyr = dict(triads(table, "gyr", "radps"))["lever"]
        turning = np.convolve(np.abs(gyr[:, 0]) > 1, np.ones(100), "same") > 99
        start = int(np.argmax(turning)) - 30
        acc[start : start + 80] = acc[start]
        frozen = frozen_samples(acc, rate, follows=[turned_gravity(acc, gyr, rate)])
        assert frozen[start : start + 80].all()


def test_real_wheels_beyond_250_deg_per_second_are_saturated():
    """Four of six drives reach the end of a wheel's gyroscope; the frame's never does."""
    found = {}
    for path in real("terrain-chair", "*.csv.gz"):
        for sensor, gyr in triads(pd.read_csv(path), "gyr", "radps"):
            cut = saturated_samples(gyr)
            found[path.name, sensor] = int(cut.sum())
            if cut.any():
                assert np.abs(gyr[cut]).max(axis=1).min() > np.deg2rad(248)
    assert found["asphalt_straight.csv.gz", "left_wheel"] > 1000
    assert not any(count for (_, sensor), count in found.items() if sensor == "frame")


def test_nothing_is_neither():
    assert frozen_samples(np.zeros((0, 3)), 100).shape == (0,)
    assert saturated_samples(np.zeros((0, 3))).shape == (0,)
    assert frozen_samples(np.zeros((1, 3)), 100).tolist() == [False]
    assert saturated_samples(np.zeros((1, 3))).tolist() == [False]


@pytest.mark.parametrize("values", [[1, 2, 3], 1.0, None, "abc", np.zeros((5, 0)), 1j * noise()])
def test_what_is_no_series(values):
    for look in (saturated_samples, lambda v: frozen_samples(v, 100)):
        with pytest.raises(InputError, match="values: expected"):
            look(values)


@pytest.mark.parametrize("rate", [0, -100, np.nan, np.inf, "100", None, True])
def test_rates_and_counts_that_are_none(rate):
    with pytest.raises(InputError, match="sampling_rate_hz = "):
        frozen_samples(noise(), rate)
    with pytest.raises(InputError, match="run = "):
        saturated_samples(noise(), run=rate)


@pytest.mark.parametrize("axes", [1, 3])
@pytest.mark.parametrize("step", [1e-4, 0.1])
def test_a_shaken_sensor_that_is_never_quiet_is_seen_to_be_cut(axes, step):
    """5 Hz at four times gravity with a range of four: a quarter of the samples are cut."""
    time_s = np.arange(1001) / 100
    force = np.zeros((1001, axes))
    force[:, -1] = 9.81 + 4 * 9.81 * np.sin(2 * np.pi * 5 * time_s)
    noise = 0.01 * np.random.default_rng(2).standard_normal(force.shape)
    whole = np.round((force + noise) / step) * step
    cut = saturated_samples(np.clip(whole, -39.2, 39.2))
    assert cut.mean() == pytest.approx(0.25, abs=0.01)
    assert not saturated_samples(whole).any()
