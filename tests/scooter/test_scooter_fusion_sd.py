"""Standard deviations of the fusion: sensors with errors, against truth and a dense filter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.hinges import tip_reading
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    RideSettings,
    ScooterMount,
    estimate_ride,
    fuse_angles,
    fusion,
)
from mobility_imu.scooter import fusion_filter as loops
from mobility_imu.scooter.fusion_noise import bounded_and_wandering, white_and_coloured
from mobility_imu.scooter.fusion_settings import FROM_THE_RECORDING, FusionSettings
from mobility_imu.simulation.scooter import (
    COURSES,
    NO_SHAKING,
    SMOOTH_GROUND,
    draw_driver,
    draw_scooter,
    simulate_ride,
)
from mobility_imu.simulation.sensor import SensorModel, Triad

ASSUMED = FusionSettings()
SENSOR = SensorModel(
    acc=Triad(0.02, turn_on_bias_sd=ASSUMED.acc_offset_sd_mps2, scale_sd=ASSUMED.acc_scale_sd),
    gyr=Triad(0.001, turn_on_bias_sd=ASSUMED.bias_sd_radps, scale_sd=ASSUMED.gyr_scale_sd),
)
"""Errors as large as the settings assume; the mounting is the scooter's."""


def with_errors(seed, **how):
    """Ride of a scooter whose sensors and mounting are off as far as the filter assumes."""
    unit = draw_scooter(seed, mounting_sd_rad=ASSUMED.misalignment_sd_rad)
    settings = {"ground": SMOOTH_GROUND, "shaking": NO_SHAKING, "sensor": SENSOR, **how}
    course = COURSES[("curves", "slopes")[seed % 2]]
    return simulate_ride(course, seed=seed, unit=unit, driver=draw_driver(seed), **settings)


def readings(ride):
    lever, body = ride.recording.sensors["lever"], ride.recording.sensors["body"]
    return [lever.acc_mps2, lever.gyr_radps, body.acc_mps2, body.gyr_radps]


def fused(ride, settings=None, **how):
    return fuse_angles(*readings(ride), 100.0, SUZUKI_ET4D, settings, **how)


@pytest.fixture(scope="module")
def rides():
    return [with_errors(seed) for seed in range(16)]


@pytest.mark.parametrize(("smooth", "most"), [(True, 1.6), (False, 3.5)])
def test_errors_of_the_sensors_are_in_the_sd(rides, smooth, most):
    """Mean of (error / sd)² over sixteen scooters: 1, where half or twice the sd gives 4 or 0.25.

    The error is nearly one constant in a ride, so there are some 32 draws: 95 % lie within 0.6 and
    1.5. What flexes and what the clock adds are not in the simulation. Without the smoother the sd
    is too small, by 1.7 in rides of 20 s: the filter takes an early guess of the constants for
    more than it is.
    """
    ratios = []
    for ride in rides:
        found = fused(ride, FusionSettings(flexing_sd_rad=1e-6, clock_sd_s=1e-6), smooth=smooth)
        half = slice(len(found.steering_rad) // 2, None)
        for name in ("steering", "throttle"):
            error = getattr(found, f"{name}_rad") - getattr(ride, f"{name}_rad")
            ratios.append(np.median((error / getattr(found, f"{name}_sd_rad"))[half] ** 2))
    assert 0.5 <= np.mean(ratios) <= most


def test_white_noise_alone_would_state_far_too_little(rides):
    """Without the constants the stated sd is a tenth of the error: what this filter is for."""
    tiny = dict.fromkeys(
        (
            "acc_offset_sd_mps2",
            "acc_scale_sd",
            "misalignment_sd_rad",
            "axes_apart_sd_rad",
            "lever_arm_sd_m",
            "disturbance_sd_mps2",
        ),
        1e-6,
    )
    errors, stated = [], []
    for ride in rides[:6]:
        found = fused(ride, FusionSettings(**tiny, flexing_sd_rad=1e-6, clock_sd_s=1e-6))
        errors.append(np.sqrt(np.mean((found.steering_rad - ride.steering_rad) ** 2)))
        stated.append(np.median(found.steering_sd_rad))
    assert np.median(stated) < 0.3 * np.median(errors)


# The filter itself: what it learns. Against the filter of one vector: test_scooter_fusion_filter.


def learnt(with_arms):
    """Constants less their true values, and their covariance, of six drawn sets of them."""
    found = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        known = dict.fromkeys(FROM_THE_RECORDING, 0.05)
        settings = replace(
            FusionSettings(**known), rate_noise_radps_sqrthz=1e-4, huber=1e6, bias_sd_radps=0.01
        )
        rows, c = sweeps(rng, settings, with_arms)
        spins = [np.gradient(rate, 0.01, axis=0) for rate in (rows[1], rows[3])]
        inputs = loops.Inputs(*rows, *spins)
        start = fusion._start(inputs, settings, SUZUKI_ET4D, 100.0)
        model = fusion._model(settings, SUZUKI_ET4D, 100.0)
        _, after = loops.run_filter(inputs, 0, len(inputs.lever_acc), start, model, False)
        found.append((after.constants - c, after.constants_covariance))
    return found


def test_constants_of_the_model_have_the_stated_covariance():
    """Normalised squared error of all 45 constants, of readings that the model made: 1 for each.

    Without arms: the filter leaves out that an arm's effect depends on the gyroscope's scale. The
    gyroscopes' offset is half of what is assumed by default: with all of it the angles at the
    start err so far that the slopes do, and the ratio is 1.5.
    """
    ratios = [off @ np.linalg.solve(p, off) / len(off) for off, p in learnt(with_arms=False)]
    assert 0.7 <= np.mean(ratios) <= 1.4


def test_lever_arms_are_learnt():
    """Of 0.3 m before, the lever's arms are known to centimetres after half a minute of sweeps."""
    arms = slice(loops.ARMS, loops.ARMS + 3)
    found = learnt(with_arms=True)
    off = np.array([each[arms] for each, _ in found])
    sd = np.array([np.sqrt(np.diag(p)[arms]) for _, p in found])
    assert sd[:, 1:].max() < 0.1 and np.abs(off[:, 1:]).max() < 0.15


def sweeps(rng, settings, with_arms, samples=3000):
    """Readings of a still body and a lever that sweeps, with drawn constants, and these."""
    time_s = np.arange(samples) / 100
    steering, throttle = 0.6 * np.sin(1.3 * time_s), 0.7 * np.sin(2.1 * time_s)
    rates = np.gradient(np.array([steering, throttle]), 0.01, axis=1)
    tip = throttle + SUZUKI_ET4D.lean_rad
    sin, cos = (f(SUZUKI_ET4D.steering_inclination_rad) for f in (np.sin, np.cos))
    body = np.tile([0.3, 0.5, 9.8], (samples, 1))
    lever = np.array(
        [tip_reading(b, s, t, sin, cos)[:3] for b, s, t in zip(body, steering, tip, strict=True)]
    )
    gyr = np.column_stack([-rates[1], -np.sin(tip) * rates[0], np.cos(tip) * rates[0]])
    start = fusion._start(loops.Inputs(lever, gyr, body, 0 * gyr, gyr, gyr), settings,
                          SUZUKI_ET4D, 100.0)  # fmt: skip
    c = np.sqrt(np.diag(start.constants_covariance)) * rng.standard_normal(loops.CONSTANTS)
    c[loops.ARMS + 3 * with_arms :] = 0.0
    spin = np.gradient(gyr, 0.01, axis=0)
    arms = [loops.arm_acceleration(w, s) for w, s in zip(gyr, spin, strict=True)]
    lever = lever + arms @ c[loops.ARMS : loops.ARMS + 3]
    made = []
    for acc, rate, at in ((lever, gyr, 0), (body, 0 * gyr, loops.BODY)):
        turn, scale = c[at + 6 : at + 9], c[at + 9 : at + 12]
        off = c[at : at + 3] + c[at + 3 : at + 6] * acc + np.cross(turn, acc)
        own_turn = turn + c[at + 15 : at + 18]
        turned = np.cross(own_turn, rate) + scale * rate + c[at + 12 : at + 15]
        noise = 0.05 / 2**0.5 * rng.standard_normal((samples, 3))
        made += [acc + off + noise, rate + turned + 1e-3 / 2**0.5 * rng.standard_normal(rate.shape)]
    return made, c


def test_a_long_recording_in_pieces_is_the_same(rides, monkeypatch):
    part = [values[:500] for values in readings(rides[0])]
    whole = fuse_angles(*part, 100.0, SUZUKI_ET4D)
    monkeypatch.setattr(fusion, "CHUNK_SAMPLES", 130)
    pieces = fuse_angles(*part, 100.0, SUZUKI_ET4D)
    for name in ("steering_rad", "throttle_rad", "steering_sd_rad", "throttle_sd_rad"):
        assert np.allclose(getattr(whole, name), getattr(pieces, name), rtol=1e-9, atol=1e-12)


# What a recording tells.


def test_white_and_coloured_noise_are_told_apart():
    rng = np.random.default_rng(5)
    n, decay = 40_000, np.exp(-0.01 / 0.3)
    slow = np.zeros((n, 3))
    for k in range(1, n):
        slow[k] = decay * slow[k - 1] + 0.3 * np.sqrt(1 - decay**2) * rng.standard_normal(3)
    white, coloured = white_and_coloured(0.2 * rng.standard_normal((n, 3)) + slow, 100.0, 0.3)
    assert white == pytest.approx(0.2, rel=0.15) and coloured == pytest.approx(0.3, rel=0.15)
    assert white_and_coloured(slow[:100], 100.0, 0.3) is None


def test_flexing_and_noise_of_a_locked_axis_are_told_apart():
    rng = np.random.default_rng(6)
    n = 60_000
    angle = ndimage.gaussian_filter1d(rng.standard_normal(n), 8)
    angle *= 0.01 / np.std(angle)
    rates = np.gradient(angle, 0.01) + 0.004 * 10 * rng.standard_normal(n) + 0.02
    bounded, density = bounded_and_wandering(rates, 100.0)
    assert bounded == pytest.approx(0.01, rel=0.15) and density == pytest.approx(0.004, rel=0.3)
    assert bounded_and_wandering(rates[:20], 100.0) == (0.0, 0.0)


def test_flexing_and_clock_add_to_the_sd(rides):
    settings = fused(rides[0]).settings
    less = replace(settings, flexing_sd_rad=1e-8, clock_sd_s=1e-8)
    more = replace(settings, flexing_sd_rad=0.1, clock_sd_s=1e-8)
    late = replace(settings, flexing_sd_rad=1e-8, clock_sd_s=0.05)
    sd, flexing, clock = (fused(rides[0], each).steering_sd_rad for each in (less, more, late))
    assert np.allclose(flexing**2 - sd**2, 0.01)
    rate = np.gradient(fused(rides[0], less).steering_rad, 0.01)
    assert np.allclose(clock**2 - sd**2, (0.05 * rate) ** 2, atol=1e-9)


# What a calibration tells.


def test_a_calibrated_mount_narrows_the_sd_and_goes_through_a_file(rides, tmp_path):
    ride, sd = rides[0].recording, np.full(6, np.deg2rad(0.4))
    plain, known = ScooterMount(np.eye(3), np.eye(3)), ScooterMount(np.eye(3), np.eye(3), sd)
    path = tmp_path / "mount.toml"
    known.to_toml(path, geometry=SUZUKI_ET4D)
    read = ScooterMount.from_toml(path)
    assert np.allclose(read.sd_rad, sd, atol=1e-6)
    fusion_ = RideSettings(method="fusion")
    wide, narrow = (estimate_ride(ride, SUZUKI_ET4D, m, fusion_) for m in (plain, read))
    # The gyroscopes and what bends and warms are not calibrated.
    assert np.median(narrow.steering_sd_rad) < 0.8 * np.median(wide.steering_sd_rad)
    used = narrow.settings.fusion
    assert used.misalignment_sd_rad == pytest.approx(np.deg2rad(0.4) / 2**0.5, rel=1e-3)
    own = RideSettings(method="fusion", fusion=FusionSettings(acc_offset_sd_mps2=0.5))
    found = estimate_ride(ride, SUZUKI_ET4D, read, own)
    assert found.settings.fusion.acc_offset_sd_mps2 == 0.5
    assert plain.sd_rad is None and "sd_rad" not in plain.to_toml()


@pytest.mark.parametrize("sd", [np.full(5, 0.1), np.full(6, -0.1), np.full(6, np.nan)])
def test_standard_deviations_of_a_mount_that_cannot_be(sd):
    with pytest.raises(InputError, match="sd_rad"):
        ScooterMount(np.eye(3), np.eye(3), sd)
