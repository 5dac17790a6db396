"""Where the public tool fails: each failure found in it, as a case that ours gets right."""

import warnings

import numpy as np
import pytest

from mobility_imu.filters import savitzky_golay
from mobility_imu.readers.recordings import understand
from mobility_imu.simulation.wheelchair import (
    COURT,
    IDEAL,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    Mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    TaskSettings,
    WheelchairGeometry,
    calibrate_mount,
    estimate_velocity,
    task_codes,
)
from mobility_imu.wheelchair.settings import read_settings

CHAIR = WheelchairGeometry.from_degrees(
    15, wheel_radius_left_m=0.31, wheel_radius_right_m=0.31, track_m=0.8
)
# Rows: the body's axes that the sensor's x, y, z lie along; exact zeros and ones.
Z_UP = np.eye(3)
X_UP = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
Y_UP = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
Z_DOWN = np.diag([1.0, -1, -1])


def mounted(frame, left, right):
    place = np.array([0.03, 0.02, 0.01])
    turns = {"frame": frame, "left_wheel": left, "right_wheel": right}
    return {name: Mounting(turn, place) for name, turn in turns.items()}


@pytest.mark.parametrize(
    ("frame", "left", "right"),
    [
        (X_UP, Z_UP, Z_UP),  # frame sensor with x vertical: the tool takes z, up to 88 deg/s off
        (Z_UP, X_UP, X_UP),  # axle along x: the tool multiplies the rotations the wrong way round
        (
            Z_UP,
            Y_UP,
            Z_UP,
        ),  # left sensor on another axis: the tool uses the right one's, 7.7 m/s off
        (Z_DOWN, Z_DOWN, Z_UP),  # upside down, and exact zeros: the tool gets NaN and stops
    ],
)
def test_every_mounting_on_an_axis(frame, left, right):
    mounting = mounted(frame, left, right)
    static, straight, court = (
        simulate_drive(legs, CHAIR, mounting, seed=1, noise=IDEAL)
        for legs in (STATIC_TRIAL, STRAIGHT_TRIAL, COURT)
    )
    found = estimate_velocity(
        court.recording, CHAIR, calibrate_mount(static.recording, straight.recording).mount
    )
    assert np.abs(found.linear_velocity_mps - court.linear_velocity_mps).max() < 1e-9
    assert np.abs(found.yaw_rate_radps - court.yaw_rate_radps).max() < 1e-9


@pytest.mark.parametrize(
    ("segment_s", "fs", "frames"), [(0.25, 50, 12), (0.29, 100, 29), (0.07, 100, 7)]
)
def test_segments_that_are_no_whole_number_of_frames(segment_s, fs, frames):
    """0.29 * 100 is 28.999...: the tool goes on with it and labels nearly all frames wrongly."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert TaskSettings(segment_s=segment_s).frames(fs)[0] == frames


def test_look_window_is_a_time():
    """The tool looks 30 frames at any rate; at 400 Hz that is 0.075 s."""
    assert [TaskSettings().frames(fs)[1] for fs in (100, 400)] == [30, 120]


def test_long_recordings():
    """The tool runs out of stack at 21 minutes."""
    rng = np.random.default_rng(1)
    velocity, yaw = rng.normal(0.5, 0.5, 360_000), rng.normal(0, 0.7, 360_000)
    assert len(task_codes(velocity, yaw, 100)) == 360_000


def test_savitzky_golay_filters():
    """The tool's coefficients are 0, 0, 0, 1, 0, 0, 0."""
    pulse = np.zeros(7)
    pulse[3] = 1
    assert savitzky_golay(pulse, 7, 2)[3] == pytest.approx(1 / 3)


def test_decimal_commas_in_the_first_step(tmp_path):
    names = [
        f"{sensor}_{kind}_{axis}"
        for sensor in ("Chassis", "RoueGauche", "RoueDroite")
        for kind in ("Acc", "Gyr")
        for axis in "XYZ"
    ]
    row = ";".join(["0,10", "0,20", "9,80", "0,01", "0,02", "0,03"] * 3)
    path = tmp_path / "trial.csv"
    path.write_text("\n".join([";".join(names), row, row, row]) + "\n")
    acc = understand(path, sampling_rate_hz=100).recording.sensors["right_wheel"].acc_mps2
    assert acc[0].tolist() == [0.1, 0.2, 9.8]


def test_zero_thresholds_survive_the_settings_file(tmp_path):
    """The tool writes a zero as null."""
    path = tmp_path / "s.json"
    path.write_text('{"newSeuilVitLinAbs": null, "freqAcq": 100}')
    assert read_settings(path).settings.onset_velocity_mps == 0


def test_no_yaw_rate_at_all():
    """The radius is then infinite, not NaN: a chair that goes straight."""
    codes = task_codes(np.full(200, 1.0), np.zeros(200), 100)
    assert set(codes) == {2}
