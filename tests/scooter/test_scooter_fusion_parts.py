"""The parts of fusion and ride one by one: sizes assumed, guessed, measured; what is said."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from scooters import (
    COS,
    KNOWN,
    LEAN,
    SIN,
    TIMES,
    body_turn,
    lever_turn,
    parked,
    rate_of,
    readings_at,
    steering,
    tip,
)

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter import (
    SUZUKI_ET4D,
    FusedAngles,
    RideSettings,
    ScooterMount,
    estimate_ride,
    fuse_angles,
    fusion,
    ride,
)
from mobility_imu.scooter import fusion_filter as loops
from mobility_imu.scooter.angles import LARGEST_ERROR_RAD
from mobility_imu.scooter.fusion import complementary_angles
from mobility_imu.scooter.fusion_noise import (
    SMALLEST_NOISE_MPS2,
    acceleration_noise,
    bounded_and_wandering,
    smallest_step,
    white_and_coloured,
)
from mobility_imu.scooter.fusion_settings import (
    SETTING_LIMITS,
    SMALLEST_DISTURBANCE_MPS2,
    SMALLEST_RATE_NOISE,
    FusionSettings,
)
from mobility_imu.scooter.geometry import lever_acceleration


@pytest.fixture(autouse=True)
def readable_loops(monkeypatch):
    """Nothing is compiled here: each test is done before a compiler would have begun."""
    monkeypatch.setattr(fusion, "choose", lambda *_, **__: "plain")
    monkeypatch.setattr(fusion, "_complement", loops.plain(fusion._complement))


# Settings: what is assumed, guessed and measured.


def test_without_a_prediction_only_the_noise_counts():
    """Parked, the state's own variance shrinks like one over the number of samples."""
    readings = parked(64, noise=0.0)
    exact = {
        name: SETTING_LIMITS[name][0] for name in SETTING_LIMITS if name.endswith(("rad", "m"))
    }
    tiny = dict.fromkeys(("acc_scale_sd", "gyr_scale_sd", "bias_sd_radps"), 1e-6)
    settings = replace(
        KNOWN, **exact, **tiny, acc_offset_sd_mps2=1e-6, bias_walk_radps=1e-10, clock_sd_s=1e-8,
        rate_noise_radps_sqrthz=1e-6, disturbance_sd_mps2=1e-6,
    )  # fmt: skip
    sd = fuse_angles(*readings, 100.0, SUZUKI_ET4D, settings, smooth=False).steering_sd_rad
    assert_allclose(sd[15] / sd[63], 2.0, rtol=1e-3)


def test_the_model_has_variances_per_sample():
    settings = replace(
        KNOWN, acc_sd_mps2=0.3, disturbance_sd_mps2=0.2, disturbance_time_s=5.0, huber=3.0,
        rate_noise_radps_sqrthz=0.04, bias_walk_radps=0.01,
    )  # fmt: skip
    model = fusion._model(settings, SUZUKI_ET4D, 50.0)
    assert_allclose((model.dt, model.sin_alpha, model.cos_alpha), (0.02, SIN, COS))
    assert_allclose((model.lean, model.huber), (LEAN, 3.0))
    assert_allclose((model.noise, model.disturbance), (0.09, 0.04))
    # The noise of a density adds up to density² t, whatever the rate.
    assert_allclose(50 * model.drift, (0.04**2, 0.01**2))
    assert_allclose(model.decay**250, np.exp(-1))


def test_the_start_knows_what_the_settings_assume():
    sizes = {
        "acc_offset_sd_mps2": 0.1, "acc_scale_sd": 0.02, "misalignment_sd_rad": 0.03,
        "gyr_scale_sd": 0.04, "bias_sd_radps": 0.05, "axes_apart_sd_rad": 0.06,
    }  # fmt: skip
    settings = replace(KNOWN, **sizes, lever_arm_sd_m=0.7, disturbance_sd_mps2=0.8)
    lever, lever_gyr, body, body_gyr = parked(noise=0.0)
    inputs = loops.Inputs(lever, lever_gyr, body, body_gyr, lever_gyr, body_gyr)
    start = fusion._start(inputs, settings, SUZUKI_ET4D, 100.0)
    assert_allclose(start.state, [0.4, 0.2, 0, 0, 0, 0, 0], atol=1e-9)
    own = np.r_[[fusion.START_SD_RAD] * 2, [1e-6] * 2, [0.8] * 3]
    assert_allclose(start.covariance, np.diag(own**2))
    sensor = np.repeat(list(sizes.values()), 3)
    assert_allclose(start.constants_covariance, np.diag(np.r_[sensor, sensor, [0.7] * 9] ** 2))
    assert not start.constants.any() and not start.by_constants.any()
    assert start.by_constants.shape == (loops.STATES, loops.CONSTANTS)
    assert_allclose(start.slow, body[0])


def test_it_starts_from_the_median_of_half_a_second():
    lever, _, body, _ = parked(40, noise=0.0)
    other, _, below, _ = parked(40, noise=0.0, steering=-0.7, throttle=0.5)
    for rate_hz, first in ((10.0, 5), (40.0, 20), (0.5, 1)):
        moved, under = other.copy(), 2 * below
        moved[:first], under[:first] = lever[:first], body[:first]
        few = (first - 1) // 2
        moved[:few] += 3.0
        angles, slow = fusion._first_angles(moved, under, rate_hz, SUZUKI_ET4D)
        assert_allclose(angles, [0.4, 0.2], atol=1e-9)
        assert_allclose(slow, body[0])


def readings_of(values):
    return fusion._Readings(*values)


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.6])
@pytest.mark.parametrize("rate_hz", [100.0, 1e8])
def test_first_guesses_are_the_noise_of_the_lengths_or_the_least(noise, rate_hz):
    values = parked(noise=noise)
    found = fusion._first_guess(FusionSettings(), readings_of(values), rate_hz)
    lengths, step = acceleration_noise(values[0], values[2]), smallest_step(values[0], values[2])
    assert_allclose((found.acc_sd_mps2, found.acc_step_mps2), (max(lengths, step), step))
    assert found.disturbance_sd_mps2 == max(SMALLEST_DISTURBANCE_MPS2, lengths / 2)
    assert found.rate_noise_radps_sqrthz == SMALLEST_RATE_NOISE
    assert found.flexing_sd_rad == 1e-8
    assert found.clock_sd_s == (0.005 if rate_hz == 100 else 1e-8)
    assert fusion._first_guess(KNOWN, readings_of(values), rate_hz) == KNOWN
    coarse = fusion._first_guess(FusionSettings(acc_step_mps2=5.0), readings_of(values), rate_hz)
    assert coarse.acc_sd_mps2 == 5.0


def measured(settings, residuals, locked, rate_hz=10.0):
    """Settings of a pass with these residuals, in which the locked axis turns at these rates."""
    n = len(residuals)
    lever = np.zeros((n, 3))
    lever[:, 1], lever[:, 2] = np.cos(LEAN) * locked, np.sin(LEAN) * locked
    still = np.tile([0.0, 0.0, 9.81], (n, 1))
    inputs = loops.Inputs(still, lever, still, np.zeros((n, 3)), lever, lever)
    seen = fusion._Seen(np.zeros((n, 2)), np.ones((n, 2)), residuals, np.zeros(loops.CONSTANTS))
    first = fusion._first_guess(settings, readings_of(inputs[:4]), rate_hz)
    return fusion._measured(settings, first, seen, inputs, SUZUKI_ET4D, rate_hz), first


ASKED = FusionSettings(disturbance_time_s=1.0)


def test_a_quiet_recording_has_the_least_of_each_size():
    found, first = measured(ASKED, np.zeros((300, 3)), np.zeros(300))
    assert found == replace(
        ASKED,
        acc_sd_mps2=SMALLEST_NOISE_MPS2,
        acc_step_mps2=SMALLEST_NOISE_MPS2,
        disturbance_sd_mps2=SMALLEST_DISTURBANCE_MPS2,
        rate_noise_radps_sqrthz=SMALLEST_RATE_NOISE,
        flexing_sd_rad=SETTING_LIMITS["flexing_sd_rad"][0],
        clock_sd_s=first.clock_sd_s,
    )
    assert found.complete and not ASKED.complete


def test_a_loud_recording_has_the_sizes_of_its_residuals_and_its_locked_axis():
    rng = np.random.default_rng(6)
    slow = np.repeat(rng.standard_normal((40, 3)), 10, axis=0)
    residuals = 0.5 * rng.standard_normal((400, 3)) + 2 * slow
    # A tenth of the recording counts not: there the constants are learnt.
    residuals[:40] *= 1e3
    locked = 0.3 * np.sin(np.arange(400)) + 0.1 * rng.standard_normal(400)
    found, _ = measured(ASKED, residuals, locked)
    white, coloured = white_and_coloured(residuals[40:], 10.0, 1.0)
    assert_allclose((found.acc_sd_mps2, found.disturbance_sd_mps2), (white, coloured))
    angle, density = bounded_and_wandering(locked, 10.0)
    assert_allclose((found.flexing_sd_rad, found.rate_noise_radps_sqrthz), (angle, density))
    assert min(white, coloured) > 0.1 and angle > 0.01 and density > SMALLEST_RATE_NOISE
    beyond, _ = measured(ASKED, 1e12 * residuals, 1e6 * locked)
    for name in ("acc_sd_mps2", "disturbance_sd_mps2", "flexing_sd_rad", "rate_noise_radps_sqrthz"):
        assert getattr(beyond, name) == SETTING_LIMITS[name][1]
    known, _ = measured(replace(KNOWN, flexing_sd_rad=None), residuals, locked)
    assert known == replace(KNOWN, flexing_sd_rad=found.flexing_sd_rad)
    short, first = measured(ASKED, residuals[:60], locked[:60])
    assert (short.acc_sd_mps2, short.disturbance_sd_mps2) == (1e-3, first.disturbance_sd_mps2)


def test_the_locked_axis_turns_by_flexing_alone():
    """The mechanism's rates, read with errors that are known: nothing; what flexes: all of it."""
    c = np.zeros(loops.CONSTANTS)
    c[[6, 10, 14, 16, loops.BODY + 7, loops.BODY + 9, loops.BODY + 12, loops.BODY + 17]] = 1e-4
    rates, angles = [], []
    for t in TIMES:
        pair = [rate_of(turn, t) for turn in (lever_turn, body_turn)]
        for rate, at in zip(pair, (0, loops.BODY), strict=True):
            turn = c[at + 6 : at + 9] + c[at + 15 : at + 18]
            rate += np.cross(turn, rate) + c[at + 9 : at + 12] * rate + c[at + 12 : at + 15]
        rates.append(pair)
        angles.append([steering(t), tip(t) - LEAN])
    lever, body = np.swapaxes(rates, 0, 1)
    tips = np.array(angles)[:, 1] + LEAN
    across = np.column_stack([0 * tips, np.cos(tips), np.sin(tips)])
    seen = fusion._Seen(np.array(angles), np.ones((3, 2)), np.zeros((3, 3)), c)
    assert_allclose(fusion.locked_rate(lever, body, seen, SUZUKI_ET4D), 0, atol=1e-6)
    flexed = fusion.locked_rate(lever + 0.2 * across, body, seen, SUZUKI_ET4D)
    assert_allclose(flexed, 0.2, atol=1e-4)


@pytest.mark.parametrize("smooth", [False, True])
def test_what_flexes_and_the_clock_are_in_the_sd(smooth):
    values = parked(40)
    values[1][:, 2] += 1.0
    quiet = replace(KNOWN, flexing_sd_rad=1e-8, clock_sd_s=1e-8)
    sizes = ({}, {"flexing_sd_rad": 0.1}, {"clock_sd_s": 0.05})
    less, flexing, clock = (
        fuse_angles(*values, 100.0, SUZUKI_ET4D, replace(quiet, **size), smooth=smooth)
        for size in sizes
    )
    for name in ("steering", "throttle"):
        sd, flexed, late = (getattr(each, f"{name}_sd_rad") for each in (less, flexing, clock))
        angle = getattr(less, f"{name}_rad")
        changes = np.gradient(angle) if smooth else np.diff(angle, prepend=angle[0])
        assert_allclose(flexed**2 - sd**2, 0.01, rtol=1e-9)
        assert_allclose(late**2 - sd**2, (0.05 * 100 * changes) ** 2, atol=1e-14)
    assert np.abs(np.diff(less.steering_rad)).max() > 1e-3
    one = fuse_angles(*(v[:1] for v in values), 100.0, SUZUKI_ET4D, quiet, smooth=smooth)
    assert one.steering_sd_rad.shape == (1,) and np.isfinite(one.steering_sd_rad).all()


def test_derivatives_of_the_rates_know_the_past_only_unless_it_smooths():
    """A rate that grows evenly from a sample on: its derivative is seen from then, or around it."""
    gyr = np.zeros((60, 3))
    gyr[30:] = np.arange(1, 31)[:, None] * [0.01, 0.02, -0.03]
    rows = fusion._Readings(gyr, gyr, gyr, 2 * gyr)
    past, both = (fusion._inputs(rows, 100.0, smooth) for smooth in (False, True))
    assert not past.lever_spin[:30].any()
    assert_allclose(past.lever_spin[30:], np.tile([1.0, 2.0, -3.0], (30, 1)), rtol=1e-9)
    assert both.lever_spin[29].any() and not both.lever_spin[:20].any()
    assert_allclose(both.lever_spin[45], [1.0, 2.0, -3.0], rtol=2e-3)
    for spins in (past, both):
        assert_allclose(spins.body_spin, 2 * spins.lever_spin)


def test_calibrated_settings_are_never_wider_than_those_assumed():
    assumed = FusionSettings()
    part = 0.004 / 2**0.5
    found = assumed.after_calibration(np.array([0.004, 0.001, 0.004, 0.1, 0.004, 0.004]))
    assert_allclose(
        (found.acc_offset_sd_mps2, found.acc_scale_sd, found.misalignment_sd_rad),
        (part * 9.80665, part, part),
    )
    assert assumed.after_calibration(np.full(6, 1.0)) == assumed
    least = assumed.after_calibration(np.zeros(6))
    names = ("acc_offset_sd_mps2", "acc_scale_sd", "misalignment_sd_rad")
    assert all(getattr(least, name) == SETTING_LIMITS[name][0] for name in names)
    own = FusionSettings(acc_scale_sd=0.02).after_calibration(np.full(6, 0.004))
    assert own.acc_scale_sd == 0.02 and own.misalignment_sd_rad == found.misalignment_sd_rad


def test_limits_of_readings_and_rate_are_allowed():
    values = parked(20)
    values[0][0, 0] = fusion.LARGEST_ACC_MPS2
    values[3][0, 0] = -fusion.LARGEST_RATE_RADPS
    fusion._checked(*values, fusion.SLOWEST_RATE_HZ, SUZUKI_ET4D)
    for place, name in ((0, "lever_acc_mps2"), (3, "body_gyr_radps")):
        beyond = [each.copy() for each in values]
        beyond[place][0, 0] *= 1.001
        with pytest.raises(InputError, match=name):
            fusion._checked(*beyond, 100.0, SUZUKI_ET4D)
    with pytest.raises(InputError, match="sampling_rate_hz"):
        fusion._checked(*values, 9.99, SUZUKI_ET4D)


# The complementary filter.


def test_a_bias_leaves_itself_times_the_time_constant():
    values = parked(800, noise=0.0)
    tilt = 0.2 + LEAN
    values[1] = values[1] + 0.01 * np.array([-1.0, -np.sin(tilt), np.cos(tilt)])
    for time_constant in (0.5, 1.0):
        steering_rad, throttle_rad = complementary_angles(
            *values, 100.0, SUZUKI_ET4D, time_constant_s=time_constant
        )
        # The tip is turned by the bias too: the share of the steering's is off by its cosine.
        assert_allclose(throttle_rad[-1] - 0.2, 0.01 * time_constant, rtol=1e-3)
        assert_allclose(steering_rad[-1] - 0.4, 0.01 * time_constant, rtol=1e-3)
        assert_allclose((steering_rad[0], throttle_rad[0]), (0.4, 0.2), atol=1e-9)
    default = complementary_angles(*values, 100.0, SUZUKI_ET4D)
    stated = complementary_angles(*values, 100.0, SUZUKI_ET4D, time_constant_s=1.5)
    assert np.array_equal(default, stated)


def test_the_complementary_filter_takes_the_shorter_way_round():
    slow = np.tile([-3.1, 3.1], (300, 1))
    zeros = np.zeros((300, 3))
    found = fusion._complement(slow, zeros, zeros, np.array([3.1, -3.1]), 0.01, 0.2, 0.3, 0.1)
    assert_allclose(found[-1], [2 * np.pi - 3.1, 3.1 - 2 * np.pi], atol=1e-5)
    share = 0.01 / 0.21
    assert_allclose(found[0], np.array([1, -1]) * (3.1 + share * (2 * np.pi - 6.2)))
    assert (np.diff(found[:, 0]) > 0).all() and (np.diff(found[:, 1]) < 0).all()


def test_the_complementary_filter_follows_the_gyroscopes():
    """With a long time constant, the angles of the moving mechanism, from its rates alone."""
    each = [readings_at(0.3 + k / 200, np.zeros((3, 3))) for k in range(100)]
    rows = [np.concatenate(parts) for parts in zip(*each, strict=True)]
    start = np.array([steering(0.3), tip(0.3) - LEAN])
    found = fusion._complement(
        np.tile(start, (100, 1)), rows[1], rows[3], start, 1 / 200, 1e6,
        SUZUKI_ET4D.steering_inclination_rad, LEAN,
    )  # fmt: skip
    true = np.array([[steering(0.3 + k / 200), tip(0.3 + k / 200) - LEAN] for k in range(100)])
    assert_allclose(found, true, atol=2e-3)
    assert np.ptp(true[:, 0]) > 0.1


# The door: what of the recording goes in, and what is said.

POSE = (0.4, 0.2)
TURNED = Rotation.from_rotvec([0.02, -0.03, 0.1]).as_matrix()


def still_ride(samples=40, rate_hz=100.0, *, body=True, mount=None, level=False):
    values = parked(samples, noise=0.0)
    if level:
        values[2] = np.tile([0.0, 0.0, 9.80665], (samples, 1))
        values[0] = lever_acceleration(values[2], *POSE, SUZUKI_ET4D)
    if mount is not None:
        values[0] = values[0] @ mount.rotation_lever_imu_to_lever
        values[2] = values[2] @ mount.rotation_body_imu_to_body
    sensors = {"lever": Imu(*values[:2]), "body": Imu(*values[2:])}
    names = ("lever", "body") if body else ("lever",)
    clock = np.arange(samples) / rate_hz
    return Recording(clock, {name: sensors[name] for name in names}, source="r.csv")


@pytest.mark.parametrize("method", ["closed-form", "fusion"])
def test_the_mount_is_taken_out_of_both_sensors(method):
    mount, settings = ScooterMount(TURNED, TURNED.T), RideSettings(method=method)
    found = estimate_ride(still_ride(mount=mount), SUZUKI_ET4D, mount, settings)
    assert_allclose(found.steering_rad, POSE[0], atol=2e-3)
    assert_allclose(found.throttle_rad, POSE[1], atol=2e-3)


def test_the_mount_of_the_lever_alone():
    mount = ScooterMount(TURNED, TURNED.T)
    single = RideSettings(single_imu=True, acc_noise_mps2=0.1)
    alone = still_ride(body=False, mount=mount, level=True)
    found = estimate_ride(alone, SUZUKI_ET4D, mount, single)
    assert_allclose((found.steering_rad[0], found.throttle_rad[0]), POSE, atol=1e-6)


@pytest.mark.parametrize(
    ("window", "rate_hz", "better"),
    [(1, 20.0, None), (3, 20.0, 5), (5, 20.0, None), (5, 25.0, None), (3, 10.0, None),
     (7, 20.0, 5), (1, 1000.0, None), (3, 100.0, 25)],
)  # fmt: skip
def test_a_median_is_about_a_quarter_of_a_second_long(window, rate_hz, better):
    said = ride._median_warnings(window, rate_hz)
    assert len(said) == (better is not None)
    assert better is None or f"median_window = {better} would be" in said[0]


@pytest.mark.parametrize("sd_deg", [0.0, 2.0])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_steering_beyond_the_limit_and_three_sd_is_contradicted(sd_deg, sign):
    lever, _, body, _ = parked(50, noise=0.0)
    sd = np.full(50, np.deg2rad(sd_deg))
    limit, zeros = LARGEST_ERROR_RAD + 3 * sd, np.zeros(50)
    for part, contradicted in ((0.99, False), (1.01, True)):
        off = np.full(50, POSE[0]) + sign * part * limit
        found = FusedAngles(off, zeros, sd, sd, np.ones(50, bool), KNOWN)
        told = ride._contradicted(found, lever, body, 100.0, SUZUKI_ET4D)
        assert told.all() if contradicted else not told.any()


def test_the_noise_of_both_sensors_is_root_two_of_one_and_the_step_is_of_their_own_axes():
    acc = {"lever": np.zeros((6, 3)), "body": np.zeros((6, 3))}
    acc["lever"][:, 0] = [0.0, 0.5, 0.0, 0.5, 1.0, 0.0]
    asked = RideSettings(method="fusion", acc_noise_mps2=0.2)
    found = ride._fusion_settings(asked, acc, None)
    assert found == FusionSettings(acc_sd_mps2=0.2 * 2**0.5, acc_step_mps2=0.5)
    known = RideSettings(method="fusion", fusion=KNOWN)
    assert ride._fusion_settings(known, acc, ScooterMount(np.eye(3), np.eye(3))) == KNOWN
    mount = ScooterMount(np.eye(3), np.eye(3), np.full(6, 1e-3))
    narrow = ride._fusion_settings(known, acc, mount)
    assert narrow == KNOWN.after_calibration(np.full(6, 1e-3)) != KNOWN
