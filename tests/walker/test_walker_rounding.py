"""A gyroscope that is read in coarse steps: what it hides at rest, and what that costs."""

import functools
import re

import numpy as np
import pytest

from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.fault_kinds import clean_walk
from mobility_imu.walker import (
    NavigationSettings,
    estimate_trajectory,
    find_faults,
    valid_samples,
)
from mobility_imu.walker.rounding import rounded_mean_sd


@functools.cache
def walked():
    return clean_walk(21, "realistic", with_sd=False)


def rounded(step_radps, part):
    """The walk's recording with an offset of a part of the step about each axis, in steps."""
    recording = walked().walk.recording
    imu = recording.sensor("frame")
    rates = imu.gyr_radps
    if step_radps:
        rates = step_radps * np.round(rates / step_radps + part)
    return Recording(recording.time_s, {"frame": Imu(imu.acc_mps2, rates)}, source="coarse")


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.2, 0.4])
def test_the_mean_of_rounded_values_scatters_as_simulated(noise):
    """Over 400 places of the value in its step, to 1 % or two thousandths of a step."""
    rng = np.random.default_rng(5)
    at = np.linspace(0, 1, 400, endpoint=False)
    values = at[:, None] + noise * rng.standard_normal((400, 4000))
    simulated = np.sqrt(np.mean((np.round(values).mean(axis=1) - at) ** 2 - noise**2 / 4000))
    stated = rounded_mean_sd(np.array([3.0]), np.array([3 * noise]))[0] / 3
    assert stated == pytest.approx(simulated, rel=0.01, abs=2e-3)


def test_coarse_steps_are_told_with_what_they_turn():
    """Steps of 1 deg/s: an offset of 0.3 of a step turns the path by many of its sd."""
    walk, step = walked(), float(np.deg2rad(1))
    sensor = NavigationSettings.for_calibrated_sensor()
    found = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount, sensor)
    wrong = rounded(step, 0.3)
    moved = estimate_trajectory(wrong, walk.tape, walk.mount, sensor)
    off = np.rad2deg(abs(moved.yaw_rad[-1] - found.yaw_rad[-1]))
    (told,) = (
        f for f in find_faults(wrong, walk.tape, walk.mount, settings=sensor) if f.code == "coarse"
    )
    stated = float(re.search(r"the path by ([\d.]+) deg", told.sentence)[1])
    assert off > 3 * np.rad2deg(moved.yaw_sd_rad[-1]) and "1 deg/s" in told.sentence
    assert stated / 2 < off < 2 * stated
    assert not valid_samples(moved, [told]).any()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_dead_axis_of_the_accelerometer_hides_no_coarse_steps(axis):
    """It says nothing of the gyroscope."""
    walk, wrong = walked(), rounded(float(np.deg2rad(1)), 0.3)
    imu = wrong.sensor("frame")
    acc = imu.acc_mps2.copy()
    acc[:, axis] = acc[0, axis]
    dead = Recording(wrong.time_s, {"frame": Imu(acc, imu.gyr_radps)}, source="dead")
    found = find_faults(dead, walk.tape, walk.mount)
    assert {("dead axis", f"frame_acc_{'xyz'[axis]}"), ("coarse", "frame_gyr")} <= {
        (f.code, f.sensor) for f in found
    }


@pytest.mark.parametrize("step", [0.0, 1e-4, 1e-3])
def test_fine_steps_are_not_told(step):
    """0.001 rad/s is the step of a range of 2000 deg/s in 16 bits."""
    walk = walked()
    assert find_faults(rounded(step, 0.3), walk.tape, walk.mount) == ()
