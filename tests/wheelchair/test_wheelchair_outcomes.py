"""Geometry check, one wheel, standard deviations, filters, events and pushes of a chair."""

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.filters import moving_average, savitzky_golay
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.wheelchair import (
    COURT,
    IDEAL,
    LIKE_SAMPLE,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    random_court,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    Task,
    VelocitySettings,
    WheelchairGeometry,
    calibrate_mount,
    estimate_velocity,
    task_codes,
)
from mobility_imu.wheelchair.check import check_geometry
from mobility_imu.wheelchair.outcomes import (
    PushSettings,
    detect_pushes,
    onset_errors,
    task_events,
    turn_direction,
)
from mobility_imu.wheelchair.uncertainty import (
    velocity_standard_deviation,
    wheel_yaw_standard_deviation,
)
from mobility_imu.wheelchair.velocity import (
    linear_velocity,
    single_wheel_velocity,
    wheel_yaw_rate,
)

CHAIR = SAMPLE_CHAIR


def drive(geometry=CHAIR, seed=0, noise=LIKE_SAMPLE):
    mounting = random_mounting(seed)
    trials = [
        simulate_drive(legs, geometry, mounting, seed=10 * seed + k, noise=noise)
        for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, COURT))
    ]
    return trials[2], calibrate_mount(trials[0].recording, trials[1].recording)


@pytest.fixture(scope="module")
def court():
    return drive()


def changed(**values):
    return WheelchairGeometry(
        **(
            {
                "camber_rad": CHAIR.camber_rad,
                "wheel_radius_left_m": 0.3147,
                "wheel_radius_right_m": 0.3195,
                "track_m": 0.84,
            }
            | values
        )
    )


CALIBRATED = {"gyr_scale_sd": 0.003, "gyr_axis_sd_rad": float(np.deg2rad(0.1))}


class TestGeometryCheck:
    def test_right_geometry_passes(self, court):
        found = check_geometry(court[0].recording, CHAIR, court[1].mount, **CALIBRATED)
        assert found.warnings == ()
        assert found.yaw_gain_left == pytest.approx(1, abs=0.002)
        assert found.yaw_gain_right == pytest.approx(1, abs=0.002)
        assert found.track_m == pytest.approx(0.84, abs=3 * found.track_sd_m)
        assert found.radius_ratio == pytest.approx(1, abs=3 * found.radius_ratio_sd)
        assert found.camber_rad == pytest.approx(CHAIR.camber_rad, abs=found.camber_sd_rad)

    def test_wrong_track_is_named_with_its_size(self, court):
        found = check_geometry(
            court[0].recording, changed(track_m=0.86), court[1].mount, **CALIBRATED
        )
        assert found.track_m == pytest.approx(0.84, abs=0.002)
        (message,) = found.warnings
        assert "0.840 m, not 0.860 m" in message and "-0.020 m" in message

    def test_both_radii_too_large(self, court):
        wrong = changed(wheel_radius_left_m=0.3147 * 1.03, wheel_radius_right_m=0.3195 * 1.03)
        (message,) = check_geometry(
            court[0].recording, wrong, court[1].mount, **CALIBRATED
        ).warnings
        assert "both radii should be -2.9%" in message  # 1 / 1.03

    def test_one_radius_wrong(self, court):
        wrong = changed(wheel_radius_right_m=0.3195 * 0.98)
        found = check_geometry(court[0].recording, wrong, court[1].mount, **CALIBRATED)
        assert found.radius_ratio == pytest.approx(1 / 0.98, abs=0.002)
        assert any("right radius over the left" in message for message in found.warnings)

    def test_wrong_camber_shows_across_the_axles(self, court):
        found = check_geometry(
            court[0].recording, changed(camber_rad=np.deg2rad(12)), court[1].mount, **CALIBRATED
        )
        assert any("camber of 19.0 deg, not 12.0 deg" in message for message in found.warnings)

    def test_swapped_wheels(self, court):
        def swap(recording):
            sensors = recording.sensors
            return Recording(
                recording.time_s,
                {
                    "frame": sensors["frame"],
                    "left_wheel": sensors["right_wheel"],
                    "right_wheel": sensors["left_wheel"],
                },
            )

        mounting = random_mounting(0)
        static, straight = (
            simulate_drive(legs, CHAIR, mounting, seed=k).recording
            for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL))
        )
        found = check_geometry(
            swap(court[0].recording), CHAIR, calibrate_mount(swap(static), swap(straight)).mount
        )
        assert any("have each other's names" in sentence for sentence in found.warnings)

    def test_without_turns_nothing_can_be_said(self, court):
        straight = simulate_drive(STRAIGHT_TRIAL, CHAIR, random_mounting(0), seed=1).recording
        found = check_geometry(straight, CHAIR, court[1].mount)
        assert not found.judged and not found.fits and np.isnan(found.track_m)
        assert "turns too little to judge the geometry: 0 deg" in found.warnings[0]


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("camber_deg", [0, 19])
def test_one_wheel_and_the_frame_are_enough(side, camber_deg):
    geometry = WheelchairGeometry.from_degrees(
        camber_deg, wheel_radius_left_m=0.31, wheel_radius_right_m=0.31, track_m=0.8
    )
    trial, calibration = drive(geometry, noise=IDEAL)
    gyr = trial.recording.sensors[f"{side}_wheel"].gyr_radps
    axle = gyr @ calibration.mount.rotation_imu_to_wheel(side)[2]
    velocity = single_wheel_velocity(axle, trial.yaw_rate_radps, geometry, side=side)
    assert np.abs(velocity - trial.linear_velocity_mps).max() < 1e-9


@pytest.mark.parametrize("missing", ["left_wheel", "right_wheel"])
def test_a_missing_wheel_sensor(missing):
    def without(recording):
        sensors = {name: imu for name, imu in recording.sensors.items() if name != missing}
        return Recording(recording.time_s, sensors)

    mounting = random_mounting(4)
    static, straight, court = (
        simulate_drive(legs, CHAIR, mounting, seed=k, noise=IDEAL)
        for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, COURT))
    )
    calibration = calibrate_mount(static.recording, without(straight.recording))
    trial = without(court.recording)
    assert f"no sensor on the {missing.removesuffix('_wheel')} wheel" in calibration.warnings[0]
    found = estimate_velocity(trial, CHAIR, calibration.mount)
    assert "slip cannot be seen" in found.warnings[0]
    assert np.abs(found.linear_velocity_mps - court.linear_velocity_mps).max() < 1e-9
    assert not found.slip.any()
    with pytest.raises(InputError, match="needs both wheels"):
        estimate_velocity(trial, CHAIR, calibration.mount, VelocitySettings(form="printed"))


def test_swapped_wheels_are_refused():
    def swap(recording):
        names = {"frame": "frame", "left_wheel": "right_wheel", "right_wheel": "left_wheel"}
        return Recording(recording.time_s, {a: recording.sensors[b] for a, b in names.items()})

    mounting = random_mounting(4)
    static, straight, court = (
        swap(simulate_drive(legs, CHAIR, mounting, seed=k).recording)
        for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, COURT))
    )
    with pytest.raises(InputError, match="swapped"):
        estimate_velocity(court, CHAIR, calibrate_mount(static, straight).mount)


def test_standard_deviations_by_monte_carlo():
    rng = np.random.default_rng(3)
    speed, yaw, gyr_sd, radius_sd, distance_sd = 1.4, 0.8, 0.02, 0.002, 0.006
    distance = CHAIR.wheel_centre_distance_m
    left = (speed - yaw * distance / 2) / CHAIR.wheel_radius_left_m
    right = (speed + yaw * distance / 2) / CHAIR.wheel_radius_right_m
    speeds, yaws = [], []
    for _ in range(4000):
        tape = changed(
            wheel_radius_left_m=0.3147 + radius_sd * rng.standard_normal(),
            wheel_radius_right_m=0.3195 + radius_sd * rng.standard_normal(),
        )
        rates = (left, right) + gyr_sd * rng.standard_normal(2)
        speeds.append(float(linear_velocity(*rates, tape)))
        wide = distance + distance_sd * rng.standard_normal()
        yaws.append(float(wheel_yaw_rate(*rates, tape, distance_m=wide)))
    sd = velocity_standard_deviation(left, right, CHAIR, gyr_sd_radps=gyr_sd, radius_sd_m=radius_sd)
    # 4000 draws give a standard deviation to 1.1 %; three of those.
    assert np.std(speeds) == pytest.approx(float(sd), rel=0.035)
    sd = wheel_yaw_standard_deviation(
        yaw, speed, CHAIR, gyr_sd_radps=gyr_sd, radius_sd_m=radius_sd, distance_sd_m=distance_sd
    )
    assert np.std(yaws) == pytest.approx(float(sd), rel=0.035)


class TestFilters:
    def test_savitzky_golay_keeps_what_its_order_holds(self):
        """The public tool's does nothing at all; this one smooths and keeps a parabola."""
        t = np.linspace(-1, 1, 201)
        parabola = np.column_stack([3 * t**2 - t, 0 * t + 2])
        assert np.allclose(savitzky_golay(parabola, 7, 2), parabola, atol=1e-12)
        noise = np.random.default_rng(1).standard_normal((5000, 1))
        assert savitzky_golay(noise, 7, 2).std() < 0.65 * noise.std()  # sqrt(1/3) in theory

    def test_moving_average_of_noise(self):
        noise = np.random.default_rng(1).standard_normal(20_000)
        assert moving_average(noise, 9).std() == pytest.approx(1 / 3, rel=0.05)
        assert np.allclose(moving_average(np.full(20, 2.5), 5), 2.5)

    @pytest.mark.parametrize(("window", "says"), [(4, "odd"), (0, "odd"), (101, "longer")])
    def test_windows_are_checked(self, window, says):
        for smooth in (moving_average, lambda v, w: savitzky_golay(v, w, 2)):
            with pytest.raises(InputError, match=says):
                smooth(np.zeros(50), window)
        with pytest.raises(InputError, match="order"):
            savitzky_golay(np.zeros(50), 5, 5)


class TestEvents:
    def test_events_tile_the_trial_and_add_up(self, court):
        trial = court[0]
        codes = task_codes(trial.linear_velocity_mps, trial.yaw_rate_radps, 100)
        table = task_events(
            trial.recording.time_s, codes, trial.linear_velocity_mps, trial.yaw_rate_radps
        )
        assert table["duration_s"].sum() == pytest.approx(len(codes) / 100)
        assert np.allclose(table["end_s"].to_numpy()[:-1], table["onset_s"].to_numpy()[1:])
        path = np.abs(trial.linear_velocity_mps).sum() / 100
        assert table["distance_m"].sum() == pytest.approx(path, rel=1e-3)
        turned = np.rad2deg(trial.yaw_rate_radps.sum() / 100)
        assert table["turn_angle_deg"].sum() == pytest.approx(turned, abs=0.5)

    def test_direction_belongs_to_rotations_and_follows_the_sign(self):
        codes = np.repeat(np.array([1, 4, 2, 6], np.int8), 50)
        yaw = np.repeat([0.0, 2.0, 0.1, -1.0], 50)
        way = turn_direction(codes, yaw)
        assert way[::50].tolist() == ["", "left", "", "right"]
        assert turn_direction(codes, -yaw)[::50].tolist() == ["", "right", "", "left"]

    def test_court_turns_as_programmed(self, court):
        trial = court[0]
        table = task_events(
            trial.recording.time_s, trial.task, trial.linear_velocity_mps, trial.yaw_rate_radps
        )
        pivots = table[table["task"] == Task.PIVOT.title]
        assert pivots["direction"].tolist() == ["right", "left"]


class TestPushes:
    def test_pushes_of_a_simulated_drive(self, court):
        """The simulated speed swings as 1 + 0.08 sin(2 pi t): it is lowest at t = 0.75 + k."""
        trial = court[0]
        stretch = (trial.recording.time_s > 4) & (trial.recording.time_s < 7)
        time_s, velocity = trial.recording.time_s[stretch], trial.linear_velocity_mps[stretch]
        found = detect_pushes(time_s, velocity)
        inside = found.onset_s[found.onset_s > 4.2]
        # Half a smoothing width is the precision to be had.
        assert np.allclose(inside, [4.75, 5.75], atol=0.03)
        assert np.diff(inside) == pytest.approx([1.0], abs=0.02)

    def test_pushes_of_random_courts(self):
        """Ten courts with turns, braking and coasting: most onsets are real, most are found.

        What is missed are pushes that gain less than 0.05 m/s, and those while rolling backward.
        """
        real, found, seen, late = 0, 0, [], []
        for seed in range(10):
            drive = random_court(seed).drive()
            pushes = detect_pushes(drive.recording.time_s, drive.linear_velocity_mps)
            nearest = [np.abs(drive.push_onset_s - t).min() for t in pushes.onset_s]
            real += int(np.sum(np.array(nearest) < 0.15))
            found += len(nearest)
            gap = np.array([np.abs(pushes.onset_s - t).min() for t in drive.push_onset_s])
            after = np.interp(
                drive.push_onset_s + 0.3, drive.recording.time_s, drive.linear_velocity_mps
            )
            seen += (gap[after > 0.05] < 0.15).tolist()
            late += gap[gap < 0.15].tolist()
        assert real / found > 0.85
        assert np.mean(seen) > 0.75
        assert np.median(late) < 0.06

    def test_a_push_from_rest_begins_where_the_rest_ends(self):
        time_s = np.arange(0, 3, 0.01)
        velocity = np.clip((time_s - 1.0) / 0.4, 0, 1) - 0.3 * np.clip(time_s - 1.4, 0, None)
        found = detect_pushes(time_s, velocity)
        assert found.onset_s == pytest.approx([1.0], abs=0.08)
        assert found.speed_gain_mps == pytest.approx([1.0], abs=0.1)

    @pytest.mark.parametrize(
        ("samples", "pause"), [(2, False), (40, False), (42, True), (90, True)]
    )
    def test_a_minimum_longer_than_two_fifths_of_a_second_is_a_pause(self, samples, pause):
        """The push starts where the minimum begins, or where the pause ends."""
        fall, rise = np.linspace(1.0, 0.6, 50), np.linspace(0.6, 1.2, 60)
        velocity = np.r_[fall, np.full(samples, 0.5), rise, np.full(30, 1.0)]
        found = detect_pushes(
            np.arange(len(velocity)) / 100, velocity, PushSettings(smoothing_s=1e-3)
        )
        assert found.onset_s == pytest.approx([(49 + samples if pause else 50) / 100])
        assert found.peak_s == pytest.approx([(109 + samples) / 100])
        assert found.speed_gain_mps == pytest.approx([0.7])

    def test_backward_and_rest_have_no_pushes(self):
        time_s = np.arange(0, 5, 0.01)
        for velocity in (0 * time_s, -1 - 0.2 * np.sin(2 * np.pi * time_s)):
            assert len(detect_pushes(time_s, velocity).onset_s) == 0

    def test_settings_are_checked(self):
        with pytest.raises(InputError, match="smallest_gain_mps"):
            PushSettings(smallest_gain_mps=0)


UNEVEN = {
    "a gap": ([0.0, 1, 2, 3, 10], "gap of 7 s after 3 s"),
    "backwards": ([4.0, 3, 2, 1, 0], "runs backwards"),
    "twice": ([0.0, 0, 0, 0, 0], "appears twice"),
    "NaN": ([0.0, 1, np.nan, 3, 4], "sample 2 is nan"),
    "one": ([0.0], "expected at least 2"),
    "none": ([], "expected at least 2"),
    "two dimensions": (np.zeros((5, 2)), "one time series"),
    "text": (list("abcde"), "expected real numbers"),
}


@pytest.mark.parametrize(("time_s", "message"), UNEVEN.values(), ids=UNEVEN)
def test_clocks_that_cannot_be_used_are_refused(time_s, message):
    count = len(time_s)
    with pytest.raises(InputError, match=f"time_s: .*{message}"):
        task_events(time_s, np.ones(count), np.ones(count), np.ones(count))
    with pytest.raises(InputError, match=f"time_s: .*{message}"):
        detect_pushes(time_s, np.ones(count))


def test_codes_come_as_lists_series_and_arrays_alike():
    time_s = np.arange(6) / 10
    codes = [1, 1, 4, 4, 2, 2]
    velocity, yaw = np.ones(6), np.full(6, 0.5)
    first = task_events(time_s, codes, velocity, yaw)
    index = range(10, 16)
    series = (pd.Series(values, index=index) for values in (time_s, codes, velocity, yaw))
    for other in (
        task_events(*series),
        task_events(list(time_s), np.array(codes, float), list(velocity), list(yaw)),
    ):
        pd.testing.assert_frame_equal(first, other)
    assert turn_direction(pd.Series(codes, index=index), yaw).tolist()[2] == "left"
    assert turn_direction([], []).tolist() == []


@pytest.mark.parametrize(
    ("codes", "message"),
    [
        ([1, 2, 7], "codes: sample 2 is 7, expected 1 to 6"),
        ([1, 2.5, 3], "codes: sample 1 is 2.5"),
        ([1, 2], "codes: expected 3 samples like the others, got 2"),
        (np.array([0, 1, 2], np.int8), "codes: sample 0 is 0"),
        ([[1, 2, 3]], "codes: expected one time series"),
        ([1, np.nan, 2], "codes: sample 1 is nan"),
    ],
)
def test_codes_that_are_no_tasks_are_refused(codes, message):
    with pytest.raises(InputError, match=message):
        task_events([0.0, 0.1, 0.2], codes, np.zeros(3), np.zeros(3))


def test_a_true_task_that_was_not_found_has_no_onset_error():
    errors = onset_errors([1, 1, 1, 1, 2, 2], [1, 1, 4, 2, 2, 2], 10)
    assert errors["task"].tolist() == ["pivot rotation", "forward propulsion"]
    assert np.isnan(errors["error_s"][0]) and errors["error_s"][1] == pytest.approx(0.1)
    with pytest.raises(InputError, match="expected 3 samples"):
        onset_errors([1, 1], [1, 1, 2], 100)


def test_a_wheel_that_the_straight_line_lacks_stops_the_check(court):
    trials = drive()
    static, straight = (
        simulate_drive(legs, CHAIR, random_mounting(0), seed=k).recording
        for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL))
    )
    sensors = {k: v for k, v in straight.sensors.items() if k != "left_wheel"}
    mount = calibrate_mount(static, Recording(straight.time_s, sensors)).mount
    for call in (check_geometry, estimate_velocity):
        with pytest.raises(InputError, match="left wheel's sensor: it is missing in the straight"):
            call(trials[0].recording, CHAIR, mount)


@pytest.mark.parametrize("dead", [("left_wheel", "right_wheel")])
def test_dead_wheels_are_no_matter_for_linear_algebra(court, dead):
    recording, mount = court[0].recording, court[1].mount
    sensors = dict(recording.sensors)
    for name in dead:
        sensors[name] = Imu(sensors[name].acc_mps2, np.zeros((len(recording), 3)))
    found = check_geometry(Recording(recording.time_s, sensors), CHAIR, mount)
    assert not found.judged and "a sensor failed" in found.warnings[0]
    assert all(any(f"{name}_gyr" in text for text in found.warnings) for name in dead)
