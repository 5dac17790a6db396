"""Gyroscope offsets at rest: found without knowing them, robust, and as uncertain as stated."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.offsets import (
    DRIFT_SD_RADPS,
    GyroscopeOffset,
    gyroscope_offset,
    merge_offsets,
    offset_warnings,
    rest_flags,
    rest_offsets,
    without_offsets,
)
from mobility_imu.recording import Imu, Recording

RATE_HZ = 100.0
OFFSET = np.deg2rad([2.0, -3.0, 1.0])


def sensor(rest_s=4.0, moving_s=6.0, *, offset=OFFSET, seed=0, wobble=0.0, noise=0.002):
    """Arrays of a sensor that rests, then turns with a swing; wobble is a slow rocking in rest."""
    rng = np.random.default_rng(seed)
    count = round((rest_s + moving_s) * RATE_HZ)
    time_s = np.arange(count) / RATE_HZ
    moving = time_s >= rest_s
    phases = rng.uniform(0, 2 * np.pi, 3)
    slow = wobble * np.sin(2 * np.pi * np.array([0.31, 0.47, 0.73]) * time_s[:, None] + phases)
    swing = 1.5 * np.sin(4 * time_s)[:, None] * [1, 0.5, 0.8]
    gyr = offset + np.where(moving[:, None], swing, slow) + noise * rng.standard_normal((count, 3))
    acc = np.array([0.0, 0.0, 9.81]) + 0.02 * rng.standard_normal((count, 3))
    acc[moving] += np.sin(3 * time_s[moving])[:, None]
    return acc, gyr, time_s


def recording(*arrays, names=("frame",)):
    return Recording(
        arrays[0][2], {n: Imu(a[0], a[1]) for n, a in zip(names, arrays, strict=True)}, source="x"
    )


@pytest.mark.parametrize("size", [0.0, 1.0, 3.0, 5.0])
def test_rest_is_found_whatever_the_offset(size):
    acc, gyr, time_s = sensor(offset=np.deg2rad(size) * np.array([1.0, -1.0, 1.0]))
    rest = rest_flags(acc, gyr, RATE_HZ)
    assert rest[time_s < 3.5].all() and not rest[time_s > 4.5].any()


def test_offset_is_as_uncertain_as_stated():
    """200 rests of 4 s; a factor of two either way fails."""
    ratios = []
    for seed in range(200):
        acc, gyr, _ = sensor(seed=seed, noise=0.02)
        found = gyroscope_offset(gyr, rest_flags(acc, gyr, RATE_HZ), RATE_HZ)
        ratios.append((found.offset_radps - OFFSET) / found.sd_radps)
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.2


def test_the_rocking_of_a_person_is_in_the_uncertainty():
    """A sum of slow swings of 0.6 deg/s stays within its bounds: no mean of it grows with time."""
    ratios = []
    for seed in range(100):
        acc, gyr, _ = sensor(seed=seed, wobble=0.01)
        found = gyroscope_offset(gyr, rest_flags(acc, gyr, RATE_HZ), RATE_HZ)
        ratios.append((found.offset_radps - OFFSET) / found.sd_radps)
    assert np.mean(np.abs(ratios) < 2) > 0.95


def test_offset_turns_with_the_axes_of_the_sensor():
    acc, gyr, _ = sensor(wobble=0.01)
    turned = Rotation.random(rng=1).as_matrix()
    first = gyroscope_offset(gyr, rest_flags(acc, gyr, RATE_HZ), RATE_HZ)
    acc, gyr = acc @ turned.T, gyr @ turned.T
    second = gyroscope_offset(gyr, rest_flags(acc, gyr, RATE_HZ), RATE_HZ)
    np.testing.assert_allclose(second.offset_radps, turned @ first.offset_radps, atol=1e-12)
    np.testing.assert_allclose(second.covariance, turned @ first.covariance @ turned.T, atol=1e-12)


def test_coarse_steps_hide_no_offset():
    """Steps of 0.06 and 1 deg/s, as some sensors have, with noise below the step."""
    for step in np.deg2rad([0.06, 1.0]):
        acc, gyr, _ = sensor(noise=0.004)
        gyr = np.round(gyr / step) * step
        found = gyroscope_offset(gyr, rest_flags(acc, gyr, RATE_HZ), RATE_HZ)
        assert np.abs(found.offset_radps - OFFSET).max() < 0.55 * step + 3 * found.sd_radps.max()


def test_a_short_motion_that_passes_for_rest_moves_nothing():
    _, gyr, _ = sensor(rest_s=6.0)
    found = gyroscope_offset(gyr, np.arange(len(gyr)) < 700, RATE_HZ)  # one second too long
    assert np.abs(found.offset_radps - OFFSET).max() < 0.001


def test_no_rest_no_offset():
    acc, gyr, time_s = sensor(rest_s=0.5)
    assert not rest_flags(acc, gyr, RATE_HZ).any()
    moving = recording((acc, gyr, time_s))
    assert rest_offsets(moving) == {}
    assert without_offsets(moving, {}) is moving
    (sentence,) = offset_warnings(moving, {}, ["frame"])
    assert "no second of rest" in sentence
    # Faster than any offset: a steady turn.
    acc, gyr, _ = sensor(offset=np.array([0.0, 0.0, 0.5]))
    assert gyroscope_offset(gyr, rest_flags(acc, gyr, RATE_HZ), RATE_HZ) is None


def test_all_sensors_of_the_device_must_rest_at_once():
    still, turning = sensor(rest_s=8.0, moving_s=2.0), sensor(rest_s=3.0, moving_s=7.0, seed=1)
    found = rest_offsets(recording(still, turning, names=("frame", "left_wheel")))
    assert found["frame"].rest_s <= 3.0
    assert rest_offsets(recording(still)).get("frame").rest_s > 6.0


def test_pieces_of_common_rest_shorter_than_a_second_are_none():
    """Two pieces of 0.7 s in which both rest: together 1.4 s, but neither is a rest."""
    acc, gyr, time_s = sensor(rest_s=9.0, moving_s=0.0)
    swing = 1.5 * np.sin(4 * time_s)[:, None] * [1, 0.5, 0.8]
    frame, wheel = gyr.copy(), gyr.copy()
    middle = (time_s > 3.0) & (time_s < 6.0)
    frame[middle] += swing[middle]
    outer = (time_s < 2.3) | (time_s > 6.7)
    wheel[outer] += swing[outer]
    both = recording((acc, frame, time_s), (acc, wheel, time_s), names=("frame", "left_wheel"))
    assert rest_offsets(both) == {}
    assert set(rest_offsets(both, ["frame"])) == {"frame"}


def test_uncertainty_and_noise_along_a_direction():
    covariance = np.array([[4.0, 1.0, 0.0], [1.0, 9.0, 0.0], [0.0, 0.0, 1.0]])
    found = GyroscopeOffset(np.zeros(3), covariance, np.array([1.0, 2.0, 4.0]), 2.0)
    across = np.array([0.6, 0.8, 0.0])
    # 0.36 * 4 + 0.64 * 9 + 2 * 0.48 * 1 = 8.16
    assert np.isclose(found.sd_along(across), np.sqrt(8.16))
    assert np.isclose(found.noise_along(across), np.hypot(0.6, 1.6))
    np.testing.assert_allclose(found.sd_radps, [2.0, 3.0, 1.0])


def offset(rate_degps, sd_degps):
    covariance = np.deg2rad(sd_degps) ** 2 * np.eye(3)
    return GyroscopeOffset(np.deg2rad(rate_degps) * np.ones(3), covariance, np.zeros(3), 2.0)


def test_own_rest_and_others_are_weighed_or_kept_apart():
    other = offset(1.0, 0.0)
    (alone,) = merge_offsets({}, {"frame": other}).values()
    np.testing.assert_allclose(alone.sd_radps, DRIFT_SD_RADPS)
    (merged,) = merge_offsets({"frame": offset(1.2, 0.1)}, {"frame": other}).values()
    np.testing.assert_allclose(np.rad2deg(merged.offset_radps), 1.1)
    assert np.rad2deg(merged.sd_radps).max() < 0.08
    (changed,) = merge_offsets({"frame": offset(2.0, 0.1)}, {"frame": other}).values()
    np.testing.assert_allclose(np.rad2deg(changed.offset_radps), 2.0)


def test_wrong_shapes_are_refused():
    acc, gyr, _ = sensor()
    with pytest.raises(InputError, match="gyr_radps"):
        rest_flags(acc, gyr[:-1], RATE_HZ)
    with pytest.raises(InputError, match="rest"):
        gyroscope_offset(gyr, np.ones(3, bool), RATE_HZ)
    with pytest.raises(InputError, match="covariance"):
        GyroscopeOffset(np.zeros(3), -np.eye(3), np.zeros(3), 1.0)
    assert not rest_flags(acc[:50], gyr[:50], RATE_HZ).any()


@pytest.mark.parametrize("blocks", [2, 3, 6])
def test_without_scatter_the_noise_of_the_samples_is_the_uncertainty(blocks):
    """Samples at plus and minus a: each half second has one mean, and neighbours differ by 2 a.

    Of the mean of n samples with a variance of 2 a² that is 2 a²/n, in three directions, which
    more than three blocks share; beside it stands the drift within a recording, 0.01 deg/s.
    """
    a = 0.03
    gyr = OFFSET + a * np.where(np.arange(50 * blocks) % 2, 1, -1)[:, None]
    found = gyroscope_offset(gyr, np.ones(len(gyr), bool), RATE_HZ)
    np.testing.assert_allclose(found.offset_radps, OFFSET, atol=1e-12)
    np.testing.assert_allclose(found.noise_radps, np.sqrt(2) * a)
    variance = 2 * a**2 / len(gyr) * min(3 / blocks, 1) + np.deg2rad(0.01) ** 2
    np.testing.assert_allclose(found.covariance, variance * np.eye(3), rtol=1e-9, atol=1e-18)
    assert found.rest_s == pytest.approx(blocks / 2)


@pytest.mark.parametrize("rate_hz", [1.0, 100.0])
def test_one_block_alone_shows_no_scatter(rate_hz):
    """Half a second, or the two samples of a slow recording; one more block is enough."""
    block = 2 if rate_hz == 1.0 else 50
    gyr = 0.001 * np.random.default_rng(1).standard_normal((2 * block, 3))
    rest = np.ones(2 * block, bool)
    assert gyroscope_offset(gyr[:block], rest[:block], rate_hz) is None
    assert gyroscope_offset(gyr, rest, rate_hz) is not None


@pytest.mark.parametrize(
    ("tremble", "sway", "vibration", "rests"),
    [
        (0.048, 0.0, 0.0, True),
        (0.052, 0.0, 0.0, False),
        (0.0, 0.22, 0.0, True),  # 0.14 m/s² of root mean square, with the mean over 0.25 s
        (0.0, 0.25, 0.0, False),  # 0.16 m/s²
        (0.0, 0.0, 1.0, True),  # a motor that idles at 8 Hz
    ],
)
def test_a_rest_trembles_and_sways_by_little(tremble, sway, vibration, rests):
    time_s = np.arange(1000) / RATE_HZ
    gyr = OFFSET + tremble * np.where(np.arange(1000) % 2, 1, -1)[:, None] * [0.6, 0.0, 0.8]
    force = sway * np.sin(2 * np.pi * time_s) + vibration * np.sin(2 * np.pi * 8 * time_s)
    acc = np.array([0.0, 0.0, 9.81]) + force[:, None] * [0.8, -0.6, 0.0]
    inside = rest_flags(acc, gyr, RATE_HZ)[200:800]
    assert inside.all() if rests else not inside.any()


@pytest.mark.parametrize(("count", "factor"), [(4, 1.0), (12, 1 / 9)])
def test_the_scatter_of_few_blocks_is_widened_as_students(count, factor):
    """Half of the half seconds read d more, half d less than the offset.

    Their variance is d² n/(n - 1); of the mean, d²/(n - 1); Student's has (n - 1)/(n - 3) of it.
    The rest lies within a recording, and a quarter of a second at each end is left out.
    """
    d = np.array([0.01, -0.02, 0.005])
    sign = np.repeat(np.where(np.arange(count) % 2, 1.0, -1.0), 50)
    gyr = np.vstack([np.ones((100, 3)), OFFSET + np.outer(sign, d), np.ones((100, 3))])
    gyr = np.insert(gyr, 100, np.tile(OFFSET, (25, 1)), axis=0)
    gyr = np.insert(gyr, len(gyr) - 100, np.tile(OFFSET, (25, 1)), axis=0)
    rest = np.zeros(len(gyr), bool)
    rest[100:-100] = True
    found = gyroscope_offset(gyr, rest, RATE_HZ)
    np.testing.assert_allclose(found.offset_radps, OFFSET, atol=1e-12)
    expected = factor * np.outer(d, d) + np.deg2rad(0.01) ** 2 * np.eye(3)
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-9, atol=1e-15)
    assert found.rest_s == pytest.approx(count / 2) and not found.noise_radps.any()


def test_offsets_of_unequal_weight_are_weighed_until_they_contradict():
    """Variances of 1 and of 3: a quarter of the way; beyond a chi-square of 16.3 none of it."""
    mine, drift = 0.2, np.rad2deg(DRIFT_SD_RADPS)
    theirs = np.sqrt(3 * mine**2 - drift**2)
    far = np.sqrt(16.3 / 3 * 4) * mine  # of three numbers, each of them
    for apart, part in ((0.1, 0.25), (0.99 * far, 0.25), (1.01 * far, 0.0)):
        own, other = {"frame": offset(1.0, mine)}, {"frame": offset(1.0 + apart, theirs)}
        (merged,) = merge_offsets(own, other).values()
        np.testing.assert_allclose(np.rad2deg(merged.offset_radps), 1.0 + part * apart)
        sd = mine * np.sqrt(0.75) if part else mine
        np.testing.assert_allclose(np.rad2deg(merged.sd_radps), sd)


@pytest.mark.parametrize(
    ("size", "sd", "told"),
    [(0.9, 0.4, False), (1.1, 0.1, True), (-1.1, 0.1, True), (0.1, 0.6, True)],
)
def test_offsets_are_told_if_they_are_large_or_uncertain(size, sd, told):
    moving = recording(sensor())
    said = offset_warnings(moving, {"frame": offset(size, sd)}, ["frame"])
    assert len(said) == told
    if told:
        assert f"x {size:.2f} ± {sd:.2f}" in said[0] and "which is taken off" in said[0]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"noise_radps": [0.1, -0.1, 0.1]}, "noise_radps"),
        ({"covariance": np.diag([1.0, 1.0, -1e-6])}, "covariance"),
        ({"covariance": np.eye(3) + np.eye(3, k=1) * 1e-6}, "covariance"),
        ({"rest_s": -1.0}, "rest_s"),
    ],
)
def test_impossible_offsets_are_refused(given, says):
    usual = {"offset_radps": np.zeros(3), "covariance": np.eye(3), "noise_radps": np.zeros(3)}
    GyroscopeOffset(**usual, rest_s=0.0)
    with pytest.raises(InputError, match=says):
        GyroscopeOffset(**{**usual, "rest_s": 1.0, **given})


@pytest.mark.parametrize("size", [1e7, 1e160, 1.7e308])
def test_what_no_sensor_reads_is_refused(size):
    usual = np.full((200, 3), 0.1)
    for arrays, name in (((size * usual * 10, usual), "acc"), ((usual, size * usual * 10), "gyr")):
        with (
            np.errstate(over="ignore"),
            pytest.raises(InputError, match=f"{name}_.*: reaches|nite"),
        ):
            rest_flags(*arrays, 100.0)


def test_a_gyroscope_that_fails_tells_no_offset_and_no_motion():
    """It repeats a turn through the whole rest: what works keeps its offset, it has none."""
    still, dead = sensor(seed=1), sensor(seed=2)
    dead[1][:450] = [0.0, 2.0, 0.0] + np.sin(np.arange(450))[:, None]
    both = recording(still, dead, names=("frame", "wheel"))
    assert rest_offsets(both) == {}
    fails = np.arange(len(still[0])) < 450
    found = rest_offsets(both, skip={"wheel": fails})
    assert list(found) == ["frame"]
    assert found["frame"].offset_radps == pytest.approx(OFFSET, abs=1e-3)
    with pytest.raises(InputError, match="skip"):
        rest_offsets(both, skip={"wheel": fails[1:]})
