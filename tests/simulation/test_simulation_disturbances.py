"""Vibration of what a sensor sits on, and what happens to samples on their way."""

import dataclasses

import numpy as np
import pytest
from scipy import signal

from mobility_imu.errors import InputError
from mobility_imu.simulation.disturbances import AT_ONCE, Delivery, VibrationBand, vibration
from mobility_imu.simulation.sensor import IDEAL, REAL, SensorModel, Triad, measure

TIME_S = np.arange(0, 20, 0.001)
MOTION = np.column_stack([np.sin(3 * TIME_S), np.cos(2 * TIME_S), 9.8 + 0 * TIME_S])


def readings(model, seed=1, **given):
    return measure(
        TIME_S, MOTION, 0.1 * MOTION, model, sampling_rate_hz=100, seed=seed, unit_seed=2, **given
    )


def test_a_late_clock_shows_the_motion_of_before():
    """Each sensor by its own constant between 0 and the largest; the stamps stay even."""
    late = []
    for seed in range(40):
        out = readings(dataclasses.replace(IDEAL, delivery=Delivery(late_s=0.03)), seed)
        assert np.array_equal(out.time_s, readings(IDEAL).time_s)
        assert np.array_equal(out.true_time_s, out.time_s)
        k = 500
        late.append(out.time_s[k] - np.arcsin(out.imu.acc_mps2[k, 0]) / 3 % (2 * np.pi / 3))
    period = np.array(late) % (np.pi / 3)  # the arcsine knows the phase up to its branch
    assert np.ptp(period) > 0 and len(set(np.round(late, 6))) == 40
    exact = readings(IDEAL).imu.acc_mps2[:, 0]
    shifted = readings(dataclasses.replace(IDEAL, delivery=Delivery(late_s=0.03))).imu.acc_mps2
    fine = np.arange(0, 0.03, 1e-4)
    inner = slice(10, -10)
    misfit = [np.abs(np.sin(3 * (TIME_S[::10] - s))[inner] - shifted[inner, 0]).max() for s in fine]
    assert min(misfit) < 1e-3 < np.abs(exact - shifted[:, 0]).max()


def test_jitter_is_noise_in_proportion_to_the_slope():
    out = readings(dataclasses.replace(IDEAL, delivery=Delivery(jitter_s=0.002)))
    off = out.imu.acc_mps2[:, 0] - np.sin(3 * out.time_s)
    slope = 3 * np.cos(3 * out.time_s)
    assert np.std(off) == pytest.approx(0.002 * np.sqrt(np.mean(slope**2)), rel=0.1)


def test_doubled_samples_repeat_and_lost_ones_lie_on_a_line():
    noisy = SensorModel(acc=Triad(noise_density=0.01), gyr=Triad(noise_density=0.01))
    doubled = readings(dataclasses.replace(noisy, delivery=Delivery(doubled_share=0.1))).imu
    same = (np.diff(doubled.acc_mps2, axis=0) == 0).all(axis=1)
    assert same.mean() == pytest.approx(0.1, abs=0.02)
    assert np.array_equal(same, (np.diff(doubled.gyr_radps, axis=0) == 0).all(axis=1))
    filled = readings(dataclasses.replace(noisy, delivery=Delivery(filled_share=0.1))).imu.acc_mps2
    on_line = np.abs(np.diff(filled, 2, axis=0)).max(axis=1) < 1e-12
    assert 0.08 < on_line.mean() < 0.12
    changed = (filled != readings(noisy).imu.acc_mps2).any(axis=1)
    assert changed.mean() == pytest.approx(0.1, abs=0.02) and not changed[[0, -1]].any()


def test_vibration_has_its_size_and_band_and_grows_with_the_speed():
    bands = (VibrationBand((5.0, 10.0), 0.5), VibrationBand((20.0, 45.0), 2.0))
    speed = np.ones(200_000)
    shaken = vibration(bands, speed, 1000.0, np.random.default_rng(3))
    hz, power = signal.welch(shaken, 1000.0, nperseg=4096, axis=0)
    for (low, high), size in (((5, 10), 0.5), ((20, 45), 2.0), ((100, 500), 0.0)):
        inside = (hz >= low - 1) & (hz <= high + 1)
        sd = np.sqrt(power[inside].sum(axis=0) * hz[1])
        assert np.allclose(sd, size, rtol=0.1, atol=0.05)
    half = vibration(bands, 0.5 * speed, 1000.0, np.random.default_rng(3))
    assert np.allclose(half, 0.5 * shaken)
    assert not vibration(bands, 0 * speed, 1000.0, np.random.default_rng(3)).any()
    # Beyond half the sampling rate there is nothing to see.
    slow = vibration(bands, speed[:1000], 20.0, np.random.default_rng(3))
    assert 0.2 < slow.std() < 0.8


def test_what_is_off_changes_no_byte():
    """These disturbances have draws of their own: noise and biases of a seed stay."""
    model = dataclasses.replace(REAL, delivery=AT_ONCE, vibration=())
    plain = readings(model)
    again = readings(dataclasses.replace(model, vibration=REAL.vibration))  # nothing moves
    moved = readings(dataclasses.replace(model, vibration=REAL.vibration), speed_share=0 * TIME_S)
    for other in (again, moved):
        assert plain.imu.acc_mps2.tobytes() == other.imu.acc_mps2.tobytes()
        assert plain.imu.gyr_radps.tobytes() == other.imu.gyr_radps.tobytes()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Delivery(late_s=-1), "Delivery.late_s = -1"),
        (lambda: Delivery(doubled_share=1), "Delivery.doubled_share = 1"),
        (lambda: Delivery(filled_share="1"), "Delivery.filled_share = '1'"),
        (lambda: VibrationBand((9.0, 5.0), 1.0), "VibrationBand.band_hz"),
        (lambda: VibrationBand((5.0, 9.0), -1.0), "VibrationBand.sd_mps2 = -1"),
        (lambda: SensorModel(delivery=0.03), "delivery: got float, expected Delivery"),
        (
            lambda: SensorModel(vibration=(1.0,)),
            r"vibration\[0\]: got float, expected VibrationBand",
        ),
        (lambda: Triad(step=-1), "step = -1"),
        (lambda: readings(REAL, speed_share=[1.0]), "speed_share: expected 20000 samples"),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
