"""Recordings and options as people bring them: trials the wrong way, coarse digits, names."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.quality import frozen_samples
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.simulation.wheelchair import Leg, random_mounting, simulate_court
from mobility_imu.wheelchair import (
    AssumedErrors,
    WheelchairGeometry,
    calibrate_mount,
    check_geometry,
    estimate_velocity,
    find_faults,
    read_settings,
    smooth_recording,
    with_smoothing_sd,
)
from mobility_imu.wheelchair.tasks import window_means

SEED = 900_001
CHAIR = WheelchairGeometry.from_degrees(
    3, wheel_radius_left_m=0.305, wheel_radius_right_m=0.305, track_m=0.58
)
STATIC = (Leg(1, 3.0),)
FORWARD = (Leg(1, 1.0), Leg(2, 5.0, 1.2), Leg(1, 1.0))
BACKWARD = (Leg(1, 1.0), Leg(3, 5.0, -1.2), Leg(1, 1.0))
AND_BACK = (Leg(1, 1.0), Leg(2, 4.0, 1.2), Leg(1, 1.5), Leg(3, 4.0, -1.2), Leg(1, 1.0))
STRAIGHT = (Leg(1, 2.0), Leg(2, 4.0, 1.3), Leg(1, 3.0))
TURNS = (
    *(Leg(1, 2.0), Leg(2, 4.0, 1.3), Leg(6, 3.0, 1.1, 60.0), Leg(1, 2.0)),
    *(Leg(4, 2.5, 0.0, -120.0), Leg(1, 1.5), Leg(6, 3.0, 1.2, -55.0), Leg(1, 2.0)),
)
ON_THE_SPOT = (Leg(1, 2.0), Leg(4, 4.0, 0, 360), Leg(1, 2.0), Leg(4, 4.0, 0, -360), Leg(1, 2.0))


@cache
def driven(legs, trial=2, rate_hz=100.0):
    return simulate_court(
        legs,
        CHAIR,
        random_mounting(SEED),
        seed=3 * SEED + trial,
        unit_seed=SEED,
        model=MTI_1,
        sampling_rate_hz=rate_hz,
    )


@cache
def calibrated(straight=FORWARD):
    return calibrate_mount(driven(STATIC, 0).recording, driven(straight, 1).recording)


def estimated(trial, straight=FORWARD):
    cal = calibrated(straight)
    return estimate_velocity(trial, CHAIR, cal.mount, offsets=cal.offsets)


def rounded(trial, step):
    def in_steps(values):
        return np.round(values / step) * step

    sensors = {
        name: Imu(imu.acc_mps2, in_steps(imu.gyr_radps)) for name, imu in trial.sensors.items()
    }
    return Recording(trial.time_s, sensors, source=trial.source)


class TestTheStraightLineTheWrongWay:
    def test_a_drive_with_turns_names_it(self):
        """A chair that is turned by half a turn has its wheels exchanged and goes backward."""
        trial, cal = driven(TURNS).recording, calibrated(BACKWARD)
        (found,) = find_faults(trial, CHAIR, cal.mount, offsets=cal.offsets)
        assert found.code == "exchanged" and found.repair is None
        assert "the straight-line trial was driven backward" in found.sentence
        with pytest.raises(InputError, match="the straight-line trial was driven backward"):
            estimated(trial, BACKWARD)

    def test_names_that_are_exchanged_are_still_named(self):
        swapped = [
            Recording(
                one.time_s,
                {
                    "frame": one.sensors["frame"],
                    "left_wheel": one.sensors["right_wheel"],
                    "right_wheel": one.sensors["left_wheel"],
                },
                source=one.source,
            )
            for one in (driven(FORWARD, 1).recording, driven(TURNS).recording)
        ]
        cal = calibrate_mount(driven(STATIC, 0).recording, swapped[0])
        (found,) = find_faults(swapped[1], CHAIR, cal.mount, offsets=cal.offsets)
        assert found.code == "exchanged" and "exchange the names in all" in found.sentence

    def test_a_drive_without_turns_is_asked_about(self):
        (warning,) = estimated(driven(STRAIGHT).recording, BACKWARD).warnings
        assert "rolls backward throughout (3.6 m)" in warning and "record that anew" in warning

    @pytest.mark.parametrize("legs", [STRAIGHT, TURNS, STATIC], ids=["straight", "turns", "rest"])
    def test_other_drives_are_not(self, legs):
        assert estimated(driven(legs).recording).warnings == ()

    def test_forward_and_as_far_back_shows_no_direction(self):
        with pytest.raises(InputError, match=r"one way and as far back.* cut the straight-line"):
            calibrated(AND_BACK)


class TestCoarseReadings:
    def test_their_standard_deviation_holds_the_steps(self):
        """In steps of 0.1 rad/s the yaw rate was 1.1 deg/s off, with a deviation of 0.2."""
        drive = driven(TURNS)
        found = estimated(rounded(drive.recording, 0.1))
        error = np.abs(found.yaw_rate_radps - drive.yaw_rate_radps)
        assert (error < 2 * found.yaw_rate_sd_radps).mean() > 0.95
        assert [w for w in found.warnings if "gyroscope of frame is read in steps of 5.7 deg" in w]

    def test_steps_below_the_noise_change_nothing(self):
        trial = driven(TURNS).recording
        fine, found = estimated(trial), estimated(rounded(trial, 1e-4))
        assert found.warnings == ()
        ratio = found.yaw_rate_sd_radps / fine.yaw_rate_sd_radps
        assert np.abs(ratio - 1).max() < 0.05


class TestOtherSensors:
    def with_wrist(self, trial):
        count = len(trial)
        dead = Imu(np.tile([0.0, 0.0, 9.8], (count, 1)), np.zeros((count, 3)))
        return Recording(trial.time_s, {**trial.sensors, "wrist": dead}, source=trial.source)

    def test_their_faults_are_none_of_the_chairs(self):
        trial, cal = self.with_wrist(driven(TURNS).recording), calibrated()
        assert find_faults(trial, CHAIR, cal.mount, offsets=cal.offsets) == ()

    def test_a_wheel_under_another_name_is_named(self):
        def renamed(trial):
            own = dict(trial.sensors)
            own["LeftWheel"] = own.pop("left_wheel")
            return Recording(trial.time_s, own, source=trial.source)

        cal = calibrate_mount(driven(STATIC, 0).recording, renamed(driven(FORWARD, 1).recording))
        found = estimate_velocity(renamed(driven(TURNS).recording), CHAIR, cal.mount)
        for warnings in (cal.warnings, found.warnings):
            assert any("LeftWheel is not used" in sentence for sentence in warnings)


class TestTurnsOnTheSpot:
    def test_radii_are_not_judged(self):
        """The mean speed was noise, and 1.59 ± 0.05 the ratio of the radii."""
        cal = calibrated()
        found = check_geometry(driven(ON_THE_SPOT).recording, CHAIR, cal.mount, offsets=cal.offsets)
        assert found.judged and found.fits and found.warnings == ()
        assert np.isnan(found.radius_ratio) and np.isnan(found.radius_ratio_sd)
        assert abs(found.track_m - CHAIR.track_m) < 3 * found.track_sd_m

    def test_a_wrong_track_is_still_seen(self):
        cal, wide = calibrated(), replace(CHAIR, track_m=0.65)
        found = check_geometry(driven(ON_THE_SPOT).recording, wide, cal.mount, offsets=cal.offsets)
        assert not found.fits and "track of 0.58" in found.warnings[0]


def test_few_equal_readings_at_a_low_rate_are_no_accident_only_if_noise_is_fine():
    """A quarter of a second is three readings at 12.5 Hz: they come by chance in coarse steps."""
    rate, rng = 12.5, np.random.default_rng(SEED)
    noise = rng.normal(0, 1.0, (2000, 3))
    assert frozen_samples(noise.round(4), rate).sum() == 0
    assert frozen_samples((noise * 0.8).round(), rate).sum() == 0
    held = noise.round(4)
    held[700:704] = held[700]
    assert frozen_samples(held, rate)[701:704].all()
    long = (noise * 0.8).round()
    long[700:725] = long[700]
    assert frozen_samples(long, rate)[701:725].all()


class TestArguments:
    def test_a_window_names_the_recording_that_is_too_short(self):
        trial = replace(driven(STATIC, 0).recording, source="static.csv")
        with pytest.raises(InputError, match=r"static\.csv: moving average window = 2799"):
            smooth_recording(trial, "moving-average", window=2799)

    @pytest.mark.parametrize("window", [-7, 0, "7", 8, 10**12 + 1, None, 7.5])
    def test_windows_of_a_smoothed_estimate(self, window):
        found = estimated(driven(STRAIGHT).recording)
        with pytest.raises(InputError, match="window"):
            with_smoothing_sd(found, found, CHAIR, calibrated().mount, window=window)

    def test_geometry_and_mount_of_a_smoothed_estimate(self):
        found = estimated(driven(STRAIGHT).recording)
        with pytest.raises(InputError, match="geometry: got NoneType"):
            with_smoothing_sd(found, found, None, calibrated().mount)
        with pytest.raises(InputError, match="mount: got WheelchairCalibration"):
            with_smoothing_sd(found, found, CHAIR, calibrated())

    def test_no_smoothing_changes_nothing(self):
        found = estimated(driven(STRAIGHT).recording)
        same = with_smoothing_sd(found, found, CHAIR, calibrated().mount, "none", window=7)
        assert np.allclose(same.yaw_rate_sd_radps, found.yaw_rate_sd_radps, rtol=1e-9)

    @pytest.mark.parametrize("name", ["gyr_scale_sd", "gyr_axis_sd_rad"])
    @pytest.mark.parametrize("value", [1e308, 1e150, 1.5])
    def test_deviations_of_gyroscopes_that_are_none(self, name, value):
        with pytest.raises(InputError, match=f"{name} = .*expected 0 to 1"):
            check_geometry(driven(TURNS).recording, CHAIR, calibrated().mount, **{name: value})

    @pytest.mark.parametrize("name", AssumedErrors.__dataclass_fields__)
    def test_assumed_errors_that_no_square_holds(self, name):
        with pytest.raises(InputError, match=f"{name} = 1e.308: expected between"):
            AssumedErrors(**{name: 1e308})

    @pytest.mark.parametrize("values", [{0: 1.0}, (x for x in (1.0, 2.0)), ["1", "2"], [1j, 2j]])
    def test_window_means_of_what_are_no_numbers(self, values):
        with pytest.raises(InputError, match="values"):
            window_means(values, 1)


class TestFiles:
    @pytest.mark.parametrize(
        ("changed", "says"),
        [
            ("camber_deg = 3.0\ncamber_rad = 0.3", "camber_rad and camber_deg are both given"),
            ("track_m = 580", r"track_m = 580: .*\(in mm\?\)"),
            ("track_m = 58", r"track_m = 58: .*\(in cm\?\)"),
            ("track_m = 1e300", r"expected between 0.3 and 1.5 m$"),
            ("wheel_radius_left_m = 305", r"wheel_radius_left_m = 305: .*\(in mm\?\)"),
        ],
    )
    def test_geometry(self, tmp_path, changed, says):
        key = changed.split()[0]
        lines = [changed if line.startswith(key) else line for line in CHAIR.to_toml().splitlines()]
        (tmp_path / "g.toml").write_text("\n".join(lines))
        with pytest.raises(InputError, match=says):
            WheelchairGeometry.from_toml(tmp_path / "g.toml")

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ('{"inptSegmentsec": -1}', r"json: inptSegmentsec = -1"),
            ('{"segment_s": -1}', r"json: segment_s = -1"),
            ('{"seuilRayonMin": 2}', r"json: seuilRayonMin = 2\.0 is larger than"),
            ('{"segment": 1}', r"segment is not a setting \(known: segment_s, .*inptSegmentsec"),
        ],
    )
    def test_settings_name_the_key_that_was_typed(self, tmp_path, text, says):
        (tmp_path / "s.json").write_text(text)
        with pytest.raises(InputError, match=says):
            read_settings(tmp_path / "s.json")


@pytest.mark.parametrize("yaw_rate_degps", [200, 300])
def test_axles_of_fast_turns_on_the_spot_are_the_same(yaw_rate_degps):
    """A fast turn pulls a wheel's sensor aside: up was wrong, and axles 15 degrees off."""
    turn = Leg(4, 4.0, 0, yaw_rate_degps), Leg(1, 2.0), Leg(4, 4.0, 0, -yaw_rate_degps)
    trial, cal = driven((Leg(1, 2.0), *turn, Leg(1, 2.0))).recording, calibrated()
    assert find_faults(trial, CHAIR, cal.mount, offsets=cal.offsets) == ()
