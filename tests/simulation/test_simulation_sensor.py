"""Sensor error model: every error has the stated size, and nothing else moves."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.simulation.sensor import (
    IDEAL,
    LPMS_CU2,
    MTI_1,
    SensorModel,
    Triad,
    measure,
    without,
)

RATE_HZ = 100.0
G = 9.80665


def still(seconds, rate_hz=RATE_HZ):
    time_s = np.arange(round(seconds * rate_hz) + 1) / rate_hz
    return time_s, np.tile([0.0, 0.0, G], (len(time_s), 1)), np.zeros((len(time_s), 3))


def moving(seconds, rate_hz=RATE_HZ):
    """Accelerations and rates that excite all axes, independent from sample to sample."""
    time_s = still(seconds, rate_hz)[0]
    rng = np.random.default_rng(5)
    return time_s, rng.normal(0, 5, (len(time_s), 3)), rng.normal(0, 2, (len(time_s), 3))


def sense(motion, model, *, rate_hz=RATE_HZ, seed=1, unit_seed=2):
    return measure(*motion, model, sampling_rate_hz=rate_hz, seed=seed, unit_seed=unit_seed)


def test_ideal_sensor_is_exact():
    motion = moving(3)
    out = sense(motion, IDEAL)
    assert np.array_equal(out.time_s, motion[0])
    assert np.array_equal(out.true_time_s, motion[0])
    assert np.array_equal(out.imu.acc_mps2, motion[1])
    assert np.array_equal(out.imu.gyr_radps, motion[2])


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 400.0])
def test_white_noise_has_the_sd_of_its_density(rate_hz):
    """Density times the square root of the rate; 60 000 values leave 0.3 % of chance (1 sd)."""
    model = SensorModel(acc=Triad(noise_density=0.01), gyr=Triad(noise_density=0.002))
    motion = still(20_000 / rate_hz, 400.0)
    out = sense(motion, model, rate_hz=rate_hz)
    for values, mean, density in (
        (out.imu.acc_mps2, [0, 0, G], 0.01),
        (out.imu.gyr_radps, [0, 0, 0], 0.002),
    ):
        noise = values - mean
        assert np.isclose(noise.std(), density * np.sqrt(rate_hz), rtol=0.015)
        white = noise - noise.mean(axis=0)
        assert abs((white[1:] * white[:-1]).mean() / white.var()) < 0.02


def test_bias_wanders_as_gauss_markov():
    """Sd and autocorrelation exp(-lag/time); 2000 correlation times x 3 axes leave about 3 %."""
    model = SensorModel(acc=Triad(bias_instability=0.5, bias_time_s=1.0))
    bias = sense(still(2000), model).imu.acc_mps2 - [0, 0, G]
    assert np.isclose(bias.std(), 0.5, rtol=0.1)
    for lag_s in (0.1, 0.5, 1.0, 2.0):
        lag = round(lag_s * RATE_HZ)
        correlation = (bias[lag:] * bias[:-lag]).mean() / bias.var()
        assert np.isclose(correlation, np.exp(-lag_s), atol=0.08)


def test_bias_starts_with_its_full_spread():
    model = SensorModel(acc=Triad(bias_instability=0.5, bias_time_s=100.0))
    first = [sense(still(0.1), model, seed=k).imu.acc_mps2[0] - [0, 0, G] for k in range(300)]
    assert np.isclose(np.std(first), 0.5, rtol=0.15)


def fitted(out, motion):
    """Regress readings on the truth: (3, 3) matrix and bias."""
    known = np.column_stack([motion[1], np.ones(len(motion[0]))])
    solution, *_ = np.linalg.lstsq(known, out.imu.acc_mps2, rcond=None)
    return solution[:3].T, solution[3]


def test_scale_and_misalignment_belong_to_the_unit_and_bias_to_the_run():
    model = SensorModel(acc=Triad(scale_sd=0.01, misalignment_sd_rad=0.005, turn_on_bias_sd=0.1))
    motion = moving(2)
    matrix, bias = fitted(sense(motion, model, seed=1, unit_seed=7), motion)
    again, other_bias = fitted(sense(motion, model, seed=2, unit_seed=7), motion)
    other, same_bias = fitted(sense(motion, model, seed=1, unit_seed=8), motion)
    assert np.allclose(matrix, again, atol=1e-10)
    assert not np.allclose(matrix, other, atol=1e-4)
    assert np.allclose(bias, same_bias, atol=1e-9)
    assert not np.allclose(bias, other_bias, atol=1e-4)


def test_drawn_constants_have_the_stated_spread():
    """400 units: 1200 scale factors, 2400 misalignments, 1200 biases; tolerance 3 sd of chance."""
    model = SensorModel(acc=Triad(scale_sd=0.01, misalignment_sd_rad=0.005, turn_on_bias_sd=0.1))
    motion = moving(0.2)
    fits = [fitted(sense(motion, model, seed=k, unit_seed=k), motion) for k in range(400)]
    off = np.array([matrix for matrix, _ in fits]) - np.eye(3)
    diagonal = np.eye(3, dtype=bool)
    assert np.isclose(off[:, diagonal].std(), 0.01, rtol=0.07)
    assert np.isclose(off[:, ~diagonal].std(), 0.005, rtol=0.05)
    assert np.isclose(np.std([bias for _, bias in fits]), 0.1, rtol=0.07)


def test_gyroscope_feels_acceleration():
    model = SensorModel(g_sensitivity_sd=0.01)
    motion = moving(2)
    out = sense(motion, model)
    coupling, *_ = np.linalg.lstsq(motion[1], out.imu.gyr_radps - motion[2], rcond=None)
    assert np.allclose(out.imu.gyr_radps - motion[2], motion[1] @ coupling, atol=1e-10)
    assert 0.003 < coupling.std() < 0.03
    assert np.array_equal(out.imu.acc_mps2, motion[1])


def test_readings_are_cut_at_the_range():
    out = sense(moving(2), SensorModel(acc=Triad(full_scale=4.0)))
    truth = moving(2)[1]
    assert np.array_equal(out.imu.acc_mps2, np.clip(truth, -4, 4))
    assert (np.abs(truth) > 4).any()


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_readings_lie_on_the_converters_steps(bits):
    out = sense(moving(5), SensorModel(acc=Triad(full_scale=40.0, bits=bits)))
    step = 2 * 40.0 / 2**bits
    counts = out.imu.acc_mps2 / step
    assert np.allclose(counts, np.round(counts), atol=1e-6)
    error = out.imu.acc_mps2 - moving(5)[1]
    assert np.abs(error).max() <= step / 2 * (1 + 1e-9)
    assert np.isclose(error.std(), step / np.sqrt(12), rtol=0.06)  # uniform rounding error


def test_low_pass_loses_3_db_at_its_corner():
    """Second-order Butterworth: 1/sqrt(2) at the corner, and its formula one octave above."""
    rate_hz, corner_hz = 1000.0, 45.0
    octave = np.tan(np.pi * 90 / rate_hz) / np.tan(np.pi * corner_hz / rate_hz)  # bilinear
    time_s = np.arange(0, 4, 1 / rate_hz)
    model = SensorModel(acc=Triad(bandwidth_hz=corner_hz))
    for frequency_hz, expected in ((5.0, 1.0), (45.0, 0.7071), (90.0, 1 / np.sqrt(1 + octave**4))):
        wave = np.sin(2 * np.pi * frequency_hz * time_s)
        acc = np.column_stack([wave, wave, wave])
        out = sense((time_s, acc, np.zeros_like(acc)), model, rate_hz=rate_hz)
        settled = out.imu.acc_mps2[1000:, 0]
        amplitude = np.sqrt(2) * settled.std()
        assert np.isclose(amplitude, expected, rtol=0.02, atol=0.002)


def test_low_pass_starts_settled():
    out = sense(still(1, 1000.0), SensorModel(acc=Triad(bandwidth_hz=45.0)))
    assert np.allclose(out.imu.acc_mps2, [0, 0, G], atol=1e-9)


def test_clock_rate_stretches_time():
    model = SensorModel(clock_rate_sd=1e-3)
    ends = []
    for unit_seed in range(200):
        out = sense(still(10), model, unit_seed=unit_seed)
        steps = np.diff(out.true_time_s)
        assert np.allclose(steps, steps[0])
        assert np.allclose(np.diff(out.time_s), 0.01)
        ends.append(out.true_time_s[-1] - out.time_s[-1])
    assert np.isclose(np.std(ends), 10 * 1e-3, rtol=0.15)


def test_jitter_moves_each_sample():
    model = SensorModel(clock_jitter_s=5e-4)
    motion = still(100)
    ramp = np.column_stack([motion[0]] * 3)
    out = sense((motion[0], ramp, np.zeros_like(ramp)), model)
    late = out.true_time_s - out.time_s
    assert np.isclose(late.std(), 5e-4, rtol=0.04)
    inside = slice(10, -10)  # beyond the ends there is no motion to sample
    assert np.allclose(out.imu.acc_mps2[inside, 0], out.true_time_s[inside], atol=1e-12)


def test_lost_samples_leave_gaps():
    model = SensorModel(dropped_share=0.1)
    motion = moving(100)
    out = sense(motion, model)
    assert np.isclose(1 - len(out.time_s) / len(motion[0]), 0.1, atol=0.01)
    assert len(out.time_s) == len(out.true_time_s) == len(out.imu.acc_mps2)
    kept = np.round(out.time_s * RATE_HZ).astype(int)
    assert np.array_equal(out.imu.acc_mps2, motion[1][kept])
    assert (np.diff(kept) > 1).any()


@pytest.mark.parametrize("model", [MTI_1, LPMS_CU2], ids=["MTi-1", "LPMS-CU2"])
def test_same_seeds_give_the_same_bytes(model):
    motion = moving(5, 1000.0)
    first, second, other = (sense(motion, model, seed=seed) for seed in (3, 3, 4))
    assert first.imu.acc_mps2.tobytes() == second.imu.acc_mps2.tobytes()
    assert first.imu.gyr_radps.tobytes() == second.imu.gyr_radps.tobytes()
    assert first.imu.acc_mps2.tobytes() != other.imu.acc_mps2.tobytes()


@pytest.mark.parametrize("model", [MTI_1, LPMS_CU2], ids=["MTi-1", "LPMS-CU2"])
def test_named_sensors_read_gravity_to_their_class(model):
    """A mean at rest is off by bias and scale only: 4 sd of both, on every axis."""
    for seed in range(20):
        out = sense(still(5), model, seed=seed, unit_seed=seed)
        acc = out.imu.acc_mps2.mean(axis=0) - [0, 0, G]
        spread = np.hypot(
            model.acc.turn_on_bias_sd, G * max(model.acc.scale_sd, model.acc.misalignment_sd_rad)
        )
        assert np.abs(acc).max() < 4 * spread
        assert np.abs(out.imu.gyr_radps.mean(axis=0)).max() < 4 * np.hypot(
            model.gyr.turn_on_bias_sd, G * model.g_sensitivity_sd
        )


def test_without_switches_off_one_error_and_keeps_the_draws_of_the_others():
    motion = moving(2)
    full = SensorModel(
        acc=Triad(noise_density=0.01, turn_on_bias_sd=0.1, scale_sd=0.01, full_scale=50, bits=16),
        clock_rate_sd=1e-5,
    )
    quiet = without(full, "noise_density", "full_scale", "clock_rate_sd")
    assert quiet.acc.noise_density == 0 and quiet.acc.bits == 0 and quiet.clock_rate_sd == 0
    assert quiet.acc.full_scale == np.inf and quiet.acc.turn_on_bias_sd == 0.1
    matrix, bias = fitted(sense(motion, without(full, "clock_rate_sd", "full_scale")), motion)
    clean_matrix, clean_bias = fitted(sense(motion, quiet), motion)
    # What is left is the chance of 200 noisy samples, far below the errors drawn.
    assert np.allclose(bias, clean_bias, atol=0.03) and np.abs(bias).max() > 0.03
    assert np.allclose(matrix, clean_matrix, atol=0.006)


def test_without_everything_is_ideal():
    names = [field.name for field in fields(Triad) if field.name != "bias_time_s"]
    names += ["g_sensitivity_sd", "clock_rate_sd", "clock_jitter_s", "dropped_share"]
    motion = moving(2)
    out = sense(motion, without(LPMS_CU2, *names))
    assert np.array_equal(out.imu.acc_mps2, motion[1])
    assert np.array_equal(out.imu.gyr_radps, motion[2])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Triad(noise_density=-1.0), "noise_density = -1"),
        (lambda: Triad(bias_instability=np.nan), "bias_instability = nan"),
        (lambda: Triad(bits=16), "finite full_scale"),
        (lambda: SensorModel(dropped_share=1.0), "dropped_share = 1"),
        (lambda: SensorModel(clock_jitter_s=-1e-3), "clock_jitter_s = -0.001"),
        (lambda: SensorModel(clock_rate_sd=np.nan), "clock_rate_sd = nan"),
        (lambda: without(IDEAL, "colour"), "'colour' is not an error"),
        (lambda: without(IDEAL, "acc"), "'acc' is not an error"),
    ],
)
def test_impossible_sensor_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t, a, g: ((t, a[:-1], g), RATE_HZ), "acc_mps2: expected shape"),
        (lambda t, a, g: ((t, a, g[:, :2]), RATE_HZ), "gyr_radps"),
        (lambda t, a, g: ((t, a, g), 200.0), "faster than the 100 Hz"),
        (lambda t, a, g: ((t, a, g), 0.0), "sampling_rate_hz = 0"),
        (lambda t, a, g: ((t[::-1], a, g), RATE_HZ), "runs backwards"),
        (lambda t, a, g: ((t**1.5, a, g), RATE_HZ), "even steps"),
        (lambda t, a, g: ((t[:1], a[:1], g[:1]), RATE_HZ), "expected at least 2"),
    ],
)
def test_impossible_motion_is_refused(change, words):
    motion, rate_hz = change(*still(1))
    with pytest.raises(InputError, match=words):
        sense(motion, IDEAL, rate_hz=rate_hz)
