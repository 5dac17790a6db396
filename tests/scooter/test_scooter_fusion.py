"""Gyro fusion and self-calibration: against simulated truth, and their standard deviations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.quality import frozen_samples, saturated_samples
from mobility_imu.scooter import SUZUKI_ET4D, estimate_angles
from mobility_imu.scooter.angles import angle_standard_deviations
from mobility_imu.scooter.calibration import (
    ParkedPose,
    find_stills,
    mount_from_poses,
    parked_poses,
)
from mobility_imu.scooter.fusion import (
    FusionSettings,
    acceleration_noise,
    fuse_angles,
    move_specific_force,
)
from mobility_imu.scooter.mount import ScooterMount
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
    rate_noise_radps_sqrthz=GYR_SD / 10 * np.sqrt(2),
    bias_sd_radps=0.005 * np.sqrt(2),
    bias_walk_radps=1e-6,
)


def fused(ride, settings=None, *, smooth=True, mounting=None):
    lever, body = ride.recording.sensors["lever"], ride.recording.sensors["body"]
    rows = [lever.acc_mps2, lever.gyr_radps, body.acc_mps2, body.gyr_radps]
    if mounting is not None:
        turns = (mounting.lever, mounting.lever, mounting.body, mounting.body)
        rows = [turn(values) for turn, values in zip(turns, rows, strict=True)]
    return fuse_angles(*rows, 100.0, SUZUKI_ET4D, settings, smooth=smooth)


def plainly(loop):
    """Python of a compiled loop; without numba it is that already."""
    return getattr(loop, "py_func", loop)


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


# One sd holds 68.3 % of a Gaussian; the bounds are those the project set before any run.
@pytest.mark.parametrize("smooth", [False, True])
def test_filter_states_its_own_error(noisy_rides, smooth):
    shares = []
    for ride in noisy_rides:
        angles = fused(ride, STATED, smooth=smooth)
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


def test_smoother_beats_filter_beats_closed_form(noisy_rides):
    def rms(estimate):
        return np.sqrt(np.mean([np.mean((estimate(r) - r.steering_rad) ** 2) for r in noisy_rides]))

    def closed(ride):
        sensors = ride.recording.sensors
        return estimate_angles(
            sensors["lever"].acc_mps2, sensors["body"].acc_mps2, SUZUKI_ET4D
        ).steering_rad

    causal = rms(lambda ride: fused(ride, STATED, smooth=False).steering_rad)
    whole = rms(lambda ride: fused(ride, STATED).steering_rad)
    assert whole < causal < 0.3 * rms(closed)


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
    angles = fused(ride, FusionSettings(acc_sd_mps2=0.01))
    assert np.abs(angles.steering_rad - ride.steering_rad).max() < 1e-3
    assert np.abs(angles.throttle_rad - ride.throttle_rad).max() < 1e-3


def test_compiled_and_plain_loops_agree(noisy_rides):
    from mobility_imu.scooter import fusion

    ride = noisy_rides[0]
    lever, body = ride.recording.sensors["lever"], ride.recording.sensors["body"]
    part = slice(0, 300)
    arguments = (
        *(np.ascontiguousarray(v[part]) for v in (lever.acc_mps2, lever.gyr_radps)),
        *(np.ascontiguousarray(v[part]) for v in (body.acc_mps2, body.gyr_radps)),
        body.acc_mps2[0].copy(),
        0.01,
        0.35,
        0.19,
        0.08,
        np.array([1e-8, 1e-8, 1e-12, 1e-12]),
        2.0,
        np.zeros(4),
        np.eye(4) * 0.01,
    )
    fast, plain = fusion._filter(*arguments), plainly(fusion._filter)(*arguments)
    for one, other in zip(fast, plain, strict=True):
        assert np.allclose(one, other, rtol=1e-9, atol=1e-12)
    for one, other in zip(fusion._smooth(*fast), plainly(fusion._smooth)(*plain), strict=True):
        assert np.allclose(one, other, rtol=1e-7, atol=1e-10)


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


def test_calibration_finds_what_gravity_shows():
    """Ideal sensors, exact stops, three attitudes: the mounting itself comes out."""
    unit = draw_scooter(3)
    poses = []
    for k, (pitch, bank) in enumerate(((0, 0), (8, 0), (0, 8))):
        parked = simulate_parked(
            POSES,
            pitch_rad=np.deg2rad(pitch),
            bank_rad=np.deg2rad(bank),
            seed=k,
            unit=unit,
            sensor=IDEAL,
            stop_sd_rad=0.0,
        )
        poses += parked_poses(parked, POSES)
    # Nothing but rounding is left, so the prior may be as weak as one likes.
    found = mount_from_poses(poses, SUZUKI_ET4D, prior_sd_rad=1e3).mount
    for matrix, tilt in (
        (found.rotation_lever_imu_to_lever, unit.lever_mounting),
        (found.rotation_body_imu_to_body, unit.body_mounting),
    ):
        apart = Rotation.from_matrix(matrix) * Rotation.from_rotvec(tilt).inv()
        assert apart.magnitude() < 1e-6


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


def test_level_ground_does_not_show_the_heading_of_the_body_imu():
    parked = simulate_parked(POSES, pitch_rad=0.0, bank_rad=0.0, seed=1, unit=draw_scooter(1))
    mounting = mount_from_poses(parked_poses(parked, POSES), SUZUKI_ET4D)
    assert mounting.unseen == ("body IMU about z",)


def test_stills_are_found_one_per_pose():
    parked = simulate_parked(POSES, pitch_rad=0.0, bank_rad=0.0, seed=1)
    stills = find_stills(parked)
    assert len(stills) == len(POSES)
    for k, still in enumerate(stills):
        assert (
            3.0 * k - 0.2 <= parked.time_s[still.start] < parked.time_s[still.stop] <= 3 * k + 2.3
        )
    with pytest.raises(InputError, match=r"6 still stretches .* expected 5"):
        parked_poses(parked, POSES[:5])


def test_too_few_poses():
    pose = ParkedPose(np.array([0, 0, 9.8]), np.array([0, 0, 9.8]), 0.0, 0.0)
    with pytest.raises(InputError, match="at least three poses"):
        mount_from_poses([pose] * 4, SUZUKI_ET4D)


def test_mounting_file(tmp_path):
    path = tmp_path / "g.toml"
    path.write_text("[scooter]\nsteering_inclination_deg = 20\n")
    assert ScooterMount.in_toml(path) is None
    with pytest.raises(InputError, match=r"no section \[scooter.mount\]"):
        ScooterMount.from_toml(path)
    path.write_text("[scooter.mount]\nrotation_lever_imu_to_lever = [[1, 0], [0, 1]]\n")
    with pytest.raises(InputError, match="expected 3 x 3 numbers"):
        ScooterMount.from_toml(path)


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
