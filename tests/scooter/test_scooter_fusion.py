"""Gyro fusion and self-calibration: against simulated truth, and their standard deviations."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobility_imu.errors import InputError
from mobility_imu.quality import frozen_samples, saturated_samples
from mobility_imu.scooter import SUZUKI_ET4D, estimate_angles, fusion
from mobility_imu.scooter.angles import angle_standard_deviations
from mobility_imu.scooter.calibration import (
    mount_from_poses,
    parked_poses,
)
from mobility_imu.scooter.fusion import (
    complementary_angles,
    fuse_angles,
    move_specific_force,
)
from mobility_imu.scooter.fusion_noise import acceleration_noise
from mobility_imu.scooter.fusion_settings import (
    SETTING_LIMITS,
    FusionSettings,
)
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
from mobility_imu.simulation.scooter import (
    COURSES,
    NO_SHAKING,
    SMOOTH_GROUND,
    Layout,
    draw_driver,
    draw_scooter,
    simulate_parked,
    simulate_ride,
)
from mobility_imu.simulation.sensor import IDEAL, SensorModel, Triad

POSES = [tuple(np.deg2rad(p)) for p in ((50, 0), (50, 40), (0, 40), (0, 0), (-50, 0), (-50, 40))]
ACC_SD, GYR_SD = 0.2, 0.01
WHITE = SensorModel(
    acc=Triad(noise_density=ACC_SD / 10),
    gyr=Triad(noise_density=GYR_SD / 10, turn_on_bias_sd=0.005),
)
STATED = FusionSettings(
    acc_sd_mps2=ACC_SD * np.sqrt(2),
    acc_step_mps2=1e-3,
    disturbance_sd_mps2=1e-4,
    rate_noise_radps_sqrthz=GYR_SD / 10 * np.sqrt(2),
    bias_sd_radps=0.005,
    bias_walk_radps=1e-6,
    acc_offset_sd_mps2=1e-5,
    acc_scale_sd=1e-6,
    misalignment_sd_rad=1e-6,
    axes_apart_sd_rad=1e-6,
    gyr_scale_sd=1e-6,
    lever_arm_sd_m=1e-6,
    flexing_sd_rad=1e-6,
    clock_sd_s=1e-6,
)
"""All that these sensors do, and nothing else: white noise, and an offset of each gyroscope."""


def fused(ride, settings=None, *, smooth=True, mounting=None):
    lever, body = ride.recording.sensors["lever"], ride.recording.sensors["body"]
    rows = [lever.acc_mps2, lever.gyr_radps, body.acc_mps2, body.gyr_radps]
    if mounting is not None:
        turns = (mounting.lever, mounting.lever, mounting.body, mounting.body)
        rows = [turn(values) for turn, values in zip(turns, rows, strict=True)]
    return fuse_angles(*rows, 100.0, SUZUKI_ET4D, settings, smooth=smooth)


def share_within(error, sd):
    return float(np.mean(np.abs(error) < sd))


@pytest.fixture(scope="module")
def noisy_rides():
    """Twelve rides with white noise of stated size, both IMUs in one point."""
    return [
        simulate_ride(
            COURSES[name],
            seed=seed,
            layout=Layout.together(),
            ground=SMOOTH_GROUND,
            shaking=NO_SHAKING,
            sensor=WHITE,
        )
        for seed in range(6)
        for name in ("curves", "slopes")
    ]


@pytest.fixture(scope="module")
def estimated(noisy_rides):
    """Their angles, by the filter (False) and by the smoother (True)."""
    return {
        smooth: [fused(ride, STATED, smooth=smooth) for ride in noisy_rides]
        for smooth in (False, True)
    }


# One sd holds 68.3 % of a Gaussian; the bounds are those the project set before any run.
@pytest.mark.parametrize("smooth", [False, True])
def test_filter_states_its_own_error(noisy_rides, estimated, smooth):
    shares = []
    for ride, angles in zip(noisy_rides, estimated[smooth], strict=True):
        shares.append(
            (
                share_within(angles.steering_rad - ride.steering_rad, angles.steering_sd_rad),
                share_within(angles.throttle_rad - ride.throttle_rad, angles.throttle_sd_rad),
            )
        )
    for share in np.mean(shares, axis=0):
        assert 0.60 <= share <= 0.76


def test_closed_form_states_its_own_error(noisy_rides):
    shares = []
    for ride in noisy_rides:
        lever = ride.recording.sensors["lever"].acc_mps2
        angles = estimate_angles(lever, ride.recording.sensors["body"].acc_mps2, SUZUKI_ET4D)
        sd = angle_standard_deviations(
            lever,
            angles.steering_rad,
            angles.throttle_rad,
            SUZUKI_ET4D,
            lever_sd_mps2=ACC_SD,
            body_sd_mps2=ACC_SD,
        )
        shares.append(share_within(angles.steering_rad - ride.steering_rad, sd[0]))
        shares.append(share_within(angles.throttle_rad - ride.throttle_rad, sd[1]))
    assert 0.60 <= np.mean(shares) <= 0.76


def test_smoother_beats_filter_beats_closed_form(noisy_rides, estimated):
    def rms(found):
        pairs = zip(found, noisy_rides, strict=True)
        return np.sqrt(np.mean([np.mean((f.steering_rad - r.steering_rad) ** 2) for f, r in pairs]))

    def closed(ride):
        sensors = ride.recording.sensors
        return estimate_angles(sensors["lever"].acc_mps2, sensors["body"].acc_mps2, SUZUKI_ET4D)

    causal, whole = rms(estimated[False]), rms(estimated[True])
    assert whole < causal < 0.3 * rms(map(closed, noisy_rides))


def test_ideal_sensors_give_the_truth():
    """What is left is the integration over one sample while the controls speed up."""
    ride = simulate_ride(
        COURSES["curves"],
        seed=1,
        layout=Layout.together(),
        ground=SMOOTH_GROUND,
        shaking=NO_SHAKING,
        sensor=IDEAL,
    )
    angles = fused(ride, replace(STATED, acc_sd_mps2=0.01, bias_sd_radps=1e-6))
    assert np.abs(angles.steering_rad - ride.steering_rad).max() < 1e-3
    assert np.abs(angles.throttle_rad - ride.throttle_rad).max() < 1e-3


def test_compiled_and_plain_loops_agree(noisy_rides, monkeypatch):
    ride = noisy_rides[0]
    lever, body = ride.recording.sensors["lever"], ride.recording.sensors["body"]
    rows = [lever.acc_mps2, lever.gyr_radps, body.acc_mps2, body.gyr_radps]
    given = (*(values[:400] for values in rows), 100.0, SUZUKI_ET4D)
    for smooth in (False, True):
        monkeypatch.setattr(fusion, "choose", lambda *_, **__: "plain")
        slow = fuse_angles(*given, smooth=smooth)
        monkeypatch.setattr(fusion, "choose", lambda *_, **__: "compiled")
        fast = fuse_angles(*given, smooth=smooth)
        for name in ("steering_rad", "throttle_rad", "steering_sd_rad", "throttle_sd_rad"):
            assert np.allclose(getattr(fast, name), getattr(slow, name), rtol=1e-7, atol=1e-10)


def test_noise_is_read_off_the_lengths():
    rng = np.random.default_rng(1)
    force = np.tile([0.0, 2.0, 9.6], (20_000, 1))
    lever, body = (force + 0.3 * rng.standard_normal(force.shape) for _ in range(2))
    assert acceleration_noise(lever, body) == pytest.approx(0.3 * np.sqrt(2), rel=0.05)


def test_specific_force_of_a_spinning_body():
    """On a turntable: centripetal inward, Euler along the path."""
    time_s = np.arange(0, 4, 0.01)
    rate = 1.0 + 0.5 * time_s
    gyr = np.column_stack([0 * rate, 0 * rate, rate])
    at_centre = np.tile([0.0, 0.0, 9.81], (len(time_s), 1))
    moved = move_specific_force(at_centre, gyr, [0.5, 0.0, 0.0], 100.0)
    middle = slice(50, -50)
    assert np.allclose(moved[middle, 0], -0.5 * rate[middle] ** 2)
    # The derivative's Gaussian is sampled at two samples per sd: 0.04 % short.
    assert np.allclose(moved[middle, 1], 0.25, rtol=1e-3)


@pytest.fixture(scope="module")
def calibrated():
    """Six drawn scooters, parked on level ground and on a ramp."""
    found = []
    for seed in range(6):
        unit = draw_scooter(seed)
        poses = []
        for k, pitch in enumerate((0.0, 5.0)):
            parked = simulate_parked(
                POSES, pitch_rad=np.deg2rad(pitch), bank_rad=0.0, seed=10 * seed + k, unit=unit
            )
            poses += parked_poses(parked, POSES)
        found.append((unit, mount_from_poses(poses, SUZUKI_ET4D).mount))
    return found


def test_calibration_and_smoother_cut_the_error_of_a_ride(calibrated):
    before, after = [], []
    for seed, (unit, mounting) in enumerate(calibrated):
        ride = simulate_ride(COURSES["curves"], seed=seed, unit=unit, driver=draw_driver(seed))
        moving = ride.speed_mps > 0.1
        sensors = ride.recording.sensors
        paper = estimate_angles(sensors["lever"].acc_mps2, sensors["body"].acc_mps2, SUZUKI_ET4D)
        ours = fused(ride, mounting=mounting)
        for list_, angle in ((before, paper.steering_rad), (after, ours.steering_rad)):
            list_.append(np.percentile(np.abs(angle - ride.steering_rad)[moving], 90))
    assert np.median(after) < 0.5 * np.median(before)


def test_shapes_are_checked():
    good = np.tile([0.0, 0.0, 9.8], (10, 1))
    with pytest.raises(InputError, match="expected all"):
        fuse_angles(good, good[:5], good, good, 100.0, SUZUKI_ET4D)


def test_frozen_and_saturated_sensors():
    rng = np.random.default_rng(2)
    acc = [0, 0, 9.8] + 0.05 * rng.standard_normal((500, 3))
    assert not frozen_samples(acc, 100.0).any() and not saturated_samples(acc).any()
    frozen = acc.copy()
    frozen[200:260] = frozen[200]
    assert np.nonzero(frozen_samples(frozen, 100.0))[0].tolist() == list(range(200, 260))
    cut = acc.copy()
    cut[100:105, 0] = 39.2
    assert np.nonzero(saturated_samples(cut))[0].tolist() == list(range(100, 105))


def parked(samples=300, noise=0.02, seed=0):
    """Readings of a scooter that stands still: accelerations and rates of lever and body."""
    rng = np.random.default_rng(seed)
    body = np.tile(body_specific_force(0.03, 0.02), (samples, 1))
    lever = lever_acceleration(body, 0.4, 0.2, SUZUKI_ET4D)
    shaken = [acc + noise * rng.standard_normal(acc.shape) for acc in (lever, body)]
    rates = 0.005 * rng.standard_normal((2, samples, 3))
    return [shaken[0], rates[0], shaken[1], rates[1]]


def coarse(step):
    return [*(np.round(values / step) * step if k % 2 == 0 else values for k, values in TO_ROUND)]


TO_ROUND = list(enumerate(parked(noise=0.002)))


@pytest.mark.parametrize(
    "readings",
    [
        coarse(0.004 * 9.80665),
        coarse(0.5),
        parked(noise=0.0),
        [np.tile(values[:1], (300, 1)) for values in parked()],
        [np.zeros_like(v) if k % 2 else np.tile(v[:1], (300, 1)) for k, v in TO_ROUND],
        [values[:1] for values in parked()],
    ],
    ids=["12 bit", "coarse", "without noise", "frozen", "still", "one sample"],
)
@pytest.mark.parametrize("smooth", [False, True])
def test_readings_that_repeat_have_angles(readings, smooth):
    """Rounded, frozen or noise-free: the angles are those of the readings, and finite."""
    found = fuse_angles(*readings, 100.0, SUZUKI_ET4D, smooth=smooth)
    assert np.isfinite(found.steering_rad).all() and np.isfinite(found.steering_sd_rad).all()
    assert found.settings.acc_sd_mps2 >= 1e-3
    closed = estimate_angles(readings[0], readings[2], SUZUKI_ET4D)
    off = found.steering_rad[-1] - np.median(closed.steering_rad)
    assert abs(off) < 0.02 + 3 * found.steering_sd_rad[-1]


def test_noise_of_a_coarse_converter_is_one_step():
    """More than half of the readings are alike, so their spread alone would be zero."""
    body = np.tile([0.0, 2.0, 9.5], (100, 1))
    body[::5, 0] += 0.5
    assert acceleration_noise(np.tile([0.0, 2.0, 9.5], (100, 1)), body) == 0.5
    for bad, words in (
        (np.zeros((0, 3)), "no sample"),
        ([[0, 0, np.nan]], "not a finite number"),
        ([0, 0, 9.8], "shape"),
    ):
        with pytest.raises(InputError, match=words):
            acceleration_noise(bad, bad)


@pytest.mark.parametrize("function", [fuse_angles, complementary_angles])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda r: [np.where(np.arange(300)[:, None] == 7, np.nan, r[0]), *r[1:]], "row 7"),
        (lambda r: [*r[:3], np.full((300, 3), np.inf)], "body_gyr_radps"),
        (lambda r: [r[0] / 9.80665, r[1], r[2] / 9.80665, r[3]], "in g"),
        (lambda r: [-r[0], r[1], -r[2], r[3]], "sign is flipped"),
        (lambda r: [r[0] * 1e30, *r[1:]], "lever_acc_mps2: reaches"),
        (lambda r: [r[0], np.rad2deg(r[1]) + 400, *r[2:]], "lever_gyr_radps: reaches"),
        (lambda r: [v[:0] for v in r], "one sample or more"),
        (lambda r: [r[0][:, :2], *r[1:]], "three components"),
        (lambda r: [r[0][0], *r[1:]], "expected shape"),
        (lambda r: [r[0][:-1], *r[1:]], "expected all"),
        (lambda r: [r[0].astype(complex), *r[1:]], "real numbers"),
    ],
)
def test_readings_that_cannot_be(function, change, words):
    with pytest.raises(InputError, match=words):
        function(*change(parked()), 100.0, SUZUKI_ET4D)


@pytest.mark.parametrize("function", [fuse_angles, complementary_angles])
@pytest.mark.parametrize("rate", [0, -100, np.nan, np.inf, 0.1, 5, "100", None, True])
def test_rates_that_cannot_be(function, rate):
    with pytest.raises(InputError, match="sampling_rate_hz"):
        function(*parked(), rate, SUZUKI_ET4D)


@pytest.mark.parametrize("value", [0, 0.0, -1, np.nan, np.inf, 1e-300, 1e300, "1", True])
@pytest.mark.parametrize("name", [field.name for field in fields(FusionSettings)])
def test_settings_that_cannot_be(name, value):
    with pytest.raises(InputError, match=f"FusionSettings.{name}"):
        FusionSettings(**{name: value})


@given(
    logs=st.tuples(*(st.floats(*np.log10(limits)) for limits in SETTING_LIMITS.values())),
    samples=st.integers(1, 40),
    rate_hz=st.floats(10, 1e6),
)
def test_no_settings_break_the_filter(logs, samples, rate_hz):
    """Numbers for any settings that are allowed, never LinAlgError."""
    limits = SETTING_LIMITS.items()
    settings = FusionSettings(
        **{name: np.clip(10.0**log, *both) for log, (name, both) in zip(logs, limits, strict=True)}
    )
    found = fuse_angles(*(v[:samples] for v in parked()), rate_hz, SUZUKI_ET4D, settings)
    assert np.isfinite(found.steering_rad).all()


def test_inputs_of_any_float_and_read_only():
    readings = parked()
    expected = fuse_angles(*readings, 100.0, SUZUKI_ET4D)
    for values in readings:
        values.setflags(write=False)
    assert np.array_equal(
        fuse_angles(*readings, 100.0, SUZUKI_ET4D).steering_rad, expected.steering_rad
    )
    lists = [values.tolist() for values in readings]
    assert np.array_equal(
        fuse_angles(*lists, 100.0, SUZUKI_ET4D).steering_rad, expected.steering_rad
    )
    small = [np.asfortranarray(values, np.float32) for values in readings]
    found = fuse_angles(*small, 100.0, SUZUKI_ET4D)
    assert np.allclose(found.steering_rad, expected.steering_rad, atol=1e-4)


def test_density_of_the_rates_does_not_depend_on_the_sampling_rate(noisy_rides):
    """Every second sample of a ride, the same settings: the same sd of the filter within 20 %."""
    ride = noisy_rides[0].recording
    lever, body = ride.sensors["lever"], ride.sensors["body"]
    readings = [lever.acc_mps2, lever.gyr_radps, body.acc_mps2, body.gyr_radps]
    # Accelerations with twice the information per sample, so that both have the same per second.
    whole = fuse_angles(*readings, 100.0, SUZUKI_ET4D, STATED)
    halved = replace(STATED, acc_sd_mps2=STATED.acc_sd_mps2 / np.sqrt(2))
    half = fuse_angles(*(values[::2] for values in readings), 50.0, SUZUKI_ET4D, halved)
    for name in ("steering_sd_rad", "throttle_sd_rad"):
        ratio = np.median(getattr(half, name)) / np.median(getattr(whole, name))
        assert 0.8 < ratio < 1.25


def test_valid_ends_where_the_steering_is_not_known():
    """No gravity to lean on: the steering's sd grows beyond 20 degrees, and no sample is valid."""
    unknown = FusionSettings(acc_sd_mps2=1e6)
    found = fuse_angles(*parked(), 100.0, SUZUKI_ET4D, unknown)
    assert (found.steering_sd_rad > np.deg2rad(19)).all()
    assert np.array_equal(found.valid, found.steering_sd_rad < np.deg2rad(20))
    assert not found.valid.all()
    assert fuse_angles(*parked(), 100.0, SUZUKI_ET4D).valid.all()


def test_a_blow_counts_less_than_its_size():
    """One reading 30 sd off: with the robust weight it moves the angles a quarter as far."""
    readings = parked()
    blow = [values.copy() for values in readings]
    blow[0][150, 0] += 30 * 0.2
    moved = {}
    for huber in (2.0, 1e6):
        settings = FusionSettings(acc_sd_mps2=0.2, huber=huber)
        pair = [fuse_angles(*each, 100.0, SUZUKI_ET4D, settings) for each in (readings, blow)]
        moved[huber] = np.abs(pair[1].steering_rad - pair[0].steering_rad).max()
    assert moved[2.0] < 0.25 * moved[1e6]


def test_specific_force_needs_arrays_that_fit():
    still = np.tile([0.0, 0.0, 9.8], (10, 1))
    for arguments, words in (
        ((still, still[:5], [0, 0, 1], 100.0), "gyr_radps"),
        ((still, still, [0, 1], 100.0), "arm_m"),
        ((still, still, [0, 0, 1], 0.0), "sampling_rate_hz"),
    ):
        with pytest.raises(InputError, match=words):
            move_specific_force(*arguments)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"steering_rad": None}, "FusedAngles.steering_rad"),
        ({"throttle_sd_rad": np.zeros(3)}, r"FusedAngles.throttle_sd_rad: expected shape \(2,\)"),
        ({"valid": [0.5, 1]}, "FusedAngles.valid"),
        ({"settings": None}, "FusedAngles.settings: got NoneType"),
        ({"warnings": 3}, "FusedAngles.warnings: got 3"),
    ],
)
def test_angles_that_a_script_makes_are_checked(change, says):
    rad = np.zeros(2)
    made = fusion.FusedAngles(rad, rad, rad, rad, rad == 0, FusionSettings())
    with pytest.raises(InputError, match=says):
        replace(made, **change)


@pytest.mark.parametrize("smooth", [3, None, [1, 2], np.array([True, False])], ids=str)
def test_smoothing_is_on_or_off(smooth):
    with pytest.raises(InputError, match="smooth = "):
        fuse_angles(*parked(), 100.0, SUZUKI_ET4D, smooth=smooth)


@pytest.mark.parametrize("sd", [None, "abc", 3, np.zeros(5), np.full(6, np.nan), -np.ones(6)])
def test_deviations_of_a_mount_are_six(sd):
    with pytest.raises(InputError, match="mount_sd_rad"):
        FusionSettings().after_calibration(sd)
