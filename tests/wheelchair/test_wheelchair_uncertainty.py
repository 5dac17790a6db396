"""The stated standard deviation of speed and yaw rate against simulated truth.

Sensors with the errors of a data sheet, and geometry as a tape measures it, drawn by the standard
deviations that are assumed. The seeds were fixed before the first run.
"""

from dataclasses import replace

import numpy as np
import pytest
from chairs import trials

from mobility_imu.errors import InputError
from mobility_imu.recording import Recording
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.simulation.wheelchair import random_court
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    AssumedErrors,
    VelocitySettings,
    calibrate_mount,
    estimate_velocity,
)
from mobility_imu.wheelchair.uncertainty import wheel_yaw_standard_deviation

ASSUMED = AssumedErrors()


def measured(chair, rng):
    """The chair as a tape and a protractor give it."""
    drawn = rng.standard_normal(4)
    return replace(
        chair,
        camber_rad=max(chair.camber_rad + ASSUMED.camber_sd_rad * drawn[0], -0.09),
        wheel_radius_left_m=chair.wheel_radius_left_m * (1 + ASSUMED.radius_sd * drawn[1]),
        wheel_radius_right_m=chair.wheel_radius_right_m * (1 + ASSUMED.radius_sd * drawn[2]),
        track_m=chair.track_m + ASSUMED.track_sd_m * drawn[3],
    )


@pytest.mark.parametrize("wheels", ["both", "right"])
def test_errors_over_their_standard_deviations(wheels):
    """20 chairs; the bounds fail a standard deviation that is wrong by two either way.

    The simulation has no timing errors and axes that are better known than assumed: below 1.
    """
    speed, yaw, inside = [], [], []
    for seed in range(5000, 5020):
        court = random_court(seed, slips=0)
        static, straight = court.calibration_trials(MTI_1)
        cal = calibrate_mount(static.recording, straight.recording)
        drive = court.drive(MTI_1)
        chair = measured(court.geometry, np.random.default_rng([seed, 5]))
        recording = drive.recording
        if wheels == "right":
            sensors = {k: v for k, v in recording.sensors.items() if k != "left_wheel"}
            recording = Recording(recording.time_s, sensors)
        found = estimate_velocity(recording, chair, cal.mount, offsets=cal.offsets)
        moving = np.abs(drive.linear_velocity_mps) > 0.1
        error = found.linear_velocity_mps - drive.linear_velocity_mps
        ratio = (error / found.linear_velocity_sd_mps)[moving]
        speed.append(np.mean(ratio**2))
        inside.append(np.mean(np.abs(ratio) < 1.96))
        turning = np.abs(drive.yaw_rate_radps) > 0.3
        error = found.yaw_rate_radps - drive.yaw_rate_radps
        yaw.append(np.mean((error / found.yaw_rate_sd_radps)[turning] ** 2))
    assert 0.5 < np.sqrt(np.mean(speed)) < 1.2
    assert 0.5 < np.sqrt(np.mean(yaw)) < 1.2
    # Half of the error is one draw per chair: the fraction of 20 chairs is uncertain to 0.05.
    assert np.mean(inside) > 0.85


def test_a_larger_assumed_error_makes_the_standard_deviation_larger():
    static, straight, drive = (run.recording for run in trials(SAMPLE_CHAIR, 3))
    mount = calibrate_mount(static, straight).mount
    sensors = {k: v for k, v in drive.sensors.items() if k != "left_wheel"}
    one = Recording(drive.time_s, sensors)
    first = estimate_velocity(one, SAMPLE_CHAIR, mount)
    for name, value in ASSUMED.__dict__.items():
        settings = VelocitySettings(assumed=replace(ASSUMED, **{name: 3 * value}))
        more = estimate_velocity(one, SAMPLE_CHAIR, mount, settings)
        assert (more.linear_velocity_sd_mps >= first.linear_velocity_sd_mps).all()
        if name == "point_height_m":  # the simulated chair does not rock
            continue
        larger = more.linear_velocity_sd_mps > first.linear_velocity_sd_mps
        assert larger.mean() > 0.3, name
    none = AssumedErrors(*(0.0 for _ in ASSUMED.__dict__))
    exact = estimate_velocity(one, SAMPLE_CHAIR, mount, VelocitySettings(assumed=none))
    # Offsets remain: 0.5 deg/s, as long as no rest is known, at 0.32 and 0.42 m.
    assert exact.linear_velocity_sd_mps.max() < 0.009 * 0.55
    with pytest.raises(InputError, match=r"AssumedErrors\.radius_sd"):
        AssumedErrors(radius_sd=-0.1)


def test_a_slipping_wheel_widens_the_standard_deviation():
    """One wheel reads 20 % too much for two seconds; with two wheels the frame shows it."""
    static, straight, drive = (run.recording for run in trials(SAMPLE_CHAIR, 3))
    mount = calibrate_mount(static, straight).mount
    before = estimate_velocity(drive, SAMPLE_CHAIR, mount)
    wheel = drive.sensors["left_wheel"]
    slipping = (drive.time_s > 2) & (drive.time_s < 4)
    gyr = np.where(slipping[:, None], 1.2 * wheel.gyr_radps, wheel.gyr_radps)
    sensors = {**drive.sensors, "left_wheel": type(wheel)(wheel.acc_mps2, gyr)}
    after = estimate_velocity(Recording(drive.time_s, sensors), SAMPLE_CHAIR, mount)
    error = np.abs(after.linear_velocity_mps - before.linear_velocity_mps)[slipping]
    assert error.max() > 0.1
    assert (error < 2 * after.linear_velocity_sd_mps[slipping]).mean() > 0.95


def test_radii_of_a_turn_on_the_spot_and_of_a_straight_line():
    """Turning on the spot at w each wheel rolls at w d / 2: errors of 1 mm in both radii meet."""
    radius, distance = SAMPLE_CHAIR.wheel_radius_m, SAMPLE_CHAIR.wheel_centre_distance_m
    only_radii = {"gyr_sd_radps": 0.0, "radius_sd_m": 0.001, "distance_sd_m": 0.0}
    (spin,) = wheel_yaw_standard_deviation([2.0], [0.0], SAMPLE_CHAIR, **only_radii)
    assert spin == pytest.approx(0.001 * np.hypot(1 / radius.left, 1 / radius.right))
    (line,) = wheel_yaw_standard_deviation([0.0], [1.0], SAMPLE_CHAIR, **only_radii)
    assert line == pytest.approx(0.001 * np.hypot(1 / radius.left, 1 / radius.right) / distance)
    # On a left turn about the left wheel only the right one rolls.
    (pivot,) = wheel_yaw_standard_deviation([1.0], [distance / 2], SAMPLE_CHAIR, **only_radii)
    assert pivot == pytest.approx(0.001 / radius.right)
