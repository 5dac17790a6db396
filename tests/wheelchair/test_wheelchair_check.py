"""The chair's check: stated standard deviations against the errors that they are of.

Errors over their standard deviations have an rms of 1. The seeds were fixed before the first run.
The bounds hold what chance allows and fail a standard deviation that is wrong by a factor of two.
"""

from dataclasses import replace

import numpy as np
import pytest
from chairs import BOTH_WAYS, CHAIRS, calibrated, trials
from scipy import ndimage, stats

from mobility_imu.cli.wheelchair import check_text
from mobility_imu.errors import InputError
from mobility_imu.faults import with_readings
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.sensor import MTI_1, REAL
from mobility_imu.simulation.wheelchair import (
    LIKE_SAMPLE,
    Leg,
    random_court,
    random_mounting,
    simulate_court,
)
from mobility_imu.wheelchair import SAMPLE_CHAIR, calibrate_mount, check_geometry
from mobility_imu.wheelchair import check as module
from mobility_imu.wheelchair.check import (
    GYROSCOPE_AXIS_SD_RAD,
    GYROSCOPE_SCALE_SD,
    _agreement,
    _camber,
    _Distances,
    _Gyroscopes,
    _known,
    _on_camber,
    _on_distances,
)
from mobility_imu.wheelchair.fits import fit_by_pieces

CALIBRATED = {"gyr_scale_sd": 0.003, "gyr_axis_sd_rad": float(np.deg2rad(0.1))}
"""What is true of the simulated MTI-1, and what its user would state."""


def rms(ratios):
    return np.sqrt(np.mean(np.square(ratios), axis=0))


def chance(count, probability=0.999):
    """Interval that holds the rms of so many standard normal numbers with this probability."""
    tail = (1 - probability) / 2
    return np.sqrt(stats.chi2.ppf([tail, 1 - tail], count) / count)


@pytest.mark.parametrize("chairs", [30, pytest.param(60, marks=pytest.mark.slow)])
def test_errors_of_the_check_over_their_standard_deviations(chairs):
    """Chairs, courts and sets of sensors, without slip; 99.9 % of 30 numbers: 0.62 to 1.44.

    Of 60 numbers: 0.72 to 1.31. A standard deviation that is wrong by a factor of two fails both.
    """
    ratios, warnings = [], []
    for seed in range(7000, 7000 + chairs):
        court = random_court(seed, slips=0)
        static, straight = court.calibration_trials(MTI_1)
        mount = calibrate_mount(static.recording, straight.recording).mount
        found = check_geometry(court.drive(MTI_1).recording, court.geometry, mount, **CALIBRATED)
        ratios.append(
            [
                (found.track_m - court.geometry.track_m) / found.track_sd_m,
                (found.radius_ratio - 1) / found.radius_ratio_sd,
                (found.camber_rad - court.geometry.camber_rad) / found.camber_sd_rad,
            ]
        )
        warnings += [] if found.fits else found.warnings
    low, high = chance(chairs)
    assert (rms(ratios) > low).all() and (rms(ratios) < high).all(), rms(ratios)
    # Beyond three standard deviations lies 1 in 370.
    assert len(warnings) <= chairs // 30, warnings


@pytest.mark.parametrize(
    ("chairs", "few"), [(20, 16), pytest.param(40, 33, marks=pytest.mark.slow)]
)
def test_sensors_as_real_ones_are_do_not_make_a_right_geometry_wrong(chairs, few):
    """Chairs with scale factors off by 1 %: nine in ten fit, and stated intervals cover.

    Of normal errors 95 % lie inside; 40 of them give 33 or fewer once in a hundred times, 20 give
    16 or fewer 1.6 times.
    """
    fits, inside = [], []
    for seed in range(7100, 7100 + chairs):
        court = random_court(seed, slips=0)
        static, straight = court.calibration_trials(REAL)
        cal = calibrate_mount(static.recording, straight.recording)
        found = check_geometry(
            court.drive(REAL).recording, court.geometry, cal.mount, offsets=cal.offsets
        )
        if found.judged:
            fits.append(found.fits)
            inside.append(abs(found.track_m - court.geometry.track_m) < 1.96 * found.track_sd_m)
    assert len(fits) >= 0.9 * chairs and np.mean(fits) >= 0.9
    assert np.mean(inside) > few / chairs


def test_the_defaults_are_those_of_the_data_sheet():
    """PS-MPU-6000A-00: scale to 3 %, cross-axis 2 %, taken as three standard deviations."""
    assert pytest.approx(0.03 / 3) == GYROSCOPE_SCALE_SD
    assert pytest.approx(0.02 / 3) == GYROSCOPE_AXIS_SD_RAD


@pytest.mark.parametrize("value", [-0.01, float("nan"), "1 %"])
@pytest.mark.parametrize("name", ["gyr_scale_sd", "gyr_axis_sd_rad"])
def test_errors_of_gyroscopes_are_numbers_from_zero_on(name, value):
    recording, mount = turns()
    with pytest.raises(InputError, match=name):
        check_geometry(recording, SAMPLE_CHAIR, mount, **{name: value})


@pytest.mark.parametrize(
    ("name", "unit"), [("gyr_scale_sd", "percent"), ("gyr_axis_sd_rad", "deg")]
)
def test_errors_of_gyroscopes_in_another_unit_are_asked_for_it(name, unit):
    recording, mount = turns()
    with pytest.raises(InputError, match=rf"{name} = 1\.5: expected 0 to 1 \(in {unit}\?\)"):
        check_geometry(recording, SAMPLE_CHAIR, mount, **{name: 1.5})


@pytest.mark.parametrize("sensor", ["frame", "left_wheel", "right_wheel"])
def test_a_constant_offset_of_a_gyroscope_moves_neither_track_nor_radii(sensor):
    """An offset of 1 deg/s on every axis of one sensor; 0.1 mm and 1e-4 are a tenth of a sd."""
    chair = CHAIRS[2]
    runs = trials(chair, 71)
    mount, drive = calibrated(*runs).mount, runs[2].recording
    imu = drive.sensors[sensor]
    offset = Imu(imu.acc_mps2, drive.gyroscope(sensor) + np.deg2rad(1.0))
    shifted = Recording(drive.time_s, {**drive.sensors, sensor: offset})
    before, after = (check_geometry(each, chair, mount) for each in (drive, shifted))
    assert abs(after.radius_ratio - before.radius_ratio) < 1e-4
    assert abs(after.track_m - before.track_m) < 1e-4


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_the_fit_over_its_standard_deviation_with_residuals_that_last(memory):
    """300 fits of 40 s whose noise is white, or remembers 10 samples of the 100 in a block."""
    rng = np.random.default_rng(72)
    time_s = np.arange(4000) / 100
    design = np.column_stack(
        [np.sin(0.7 * time_s), 1 + 0.3 * np.sin(0.31 * time_s), np.ones_like(time_s)]
    )
    true = np.array([0.8, 0.01, 0.002])
    ratios = []
    for _ in range(300):
        noise = rng.standard_normal(4100)
        for k in range(1, len(noise)):
            noise[k] += memory * noise[k - 1]
        found, covariance = fit_by_pieces(
            design, design @ true + 0.01 * noise[100:], np.arange(4000) // 100
        )
        ratios.append((found - true) / np.sqrt(np.diag(covariance)))
    low, high = chance(300)
    # From 40 blocks the sd itself is known to a tenth.
    assert (rms(ratios) > low / 1.1).all() and (rms(ratios) < 1.1 * high).all(), rms(ratios)


def test_the_gain_about_an_axis_follows_the_errors_of_scale_and_axes():
    """2000 sensors with errors of 0.3 % and 0.1 deg; 99.9 % of 2000 numbers."""
    rng = np.random.default_rng(73)
    low, high = chance(2000)
    for axis in ([0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [1 / np.sqrt(3)] * 3):
        mixing = np.deg2rad(0.1) * rng.standard_normal((2000, 3, 3))
        mixing[:, range(3), range(3)] = 0.003 * rng.standard_normal((2000, 3))
        gain = np.einsum("i,nij,j->n", axis, mixing, axis)
        assert low < rms(gain) / _Gyroscopes(0.003, np.deg2rad(0.1)).gain_sd(np.array(axis)) < high


@pytest.mark.parametrize(
    ("stated", "off", "reported"),
    [(CALIBRATED, 0.99, False), (CALIBRATED, 0.98, True), ({}, 0.97, False), ({}, 0.94, True)],
)
def test_one_radius_off_within_and_beyond_what_scale_factors_leave_open(stated, off, reported):
    """Three standard deviations are 1.3 % with scale factors to 0.3 %, and 4.3 % with 1 %."""
    static, straight, drive = trials(CHAIRS[1], 74, BOTH_WAYS)
    mount = calibrated(static, straight).mount
    chair = CHAIRS[1]
    wrong = type(chair)(
        camber_rad=chair.camber_rad,
        wheel_radius_left_m=chair.wheel_radius_left_m,
        wheel_radius_right_m=chair.wheel_radius_right_m * off,
        track_m=chair.track_m,
    )
    found = check_geometry(drive.recording, wrong, mount, **stated)
    # First order in the mismatch.
    assert found.radius_ratio == pytest.approx(1 / off, abs=0.002 + (1 - off) ** 2)
    assert any("right radius over the left" in text for text in found.warnings) == reported
    assert all("scale factors" in t for t in found.warnings if "radius over" in t)


def test_a_wheel_that_seems_to_stand_is_no_question_of_radii():
    """A left wheel's gyroscope that reads nothing during the drive."""
    static, straight, drive = trials(CHAIRS[1], 75, BOTH_WAYS)
    mount = calibrated(static, straight).mount
    left = drive.recording.sensors["left_wheel"]
    dead = np.zeros_like(left.acc_mps2)
    sensors = {**drive.recording.sensors, "left_wheel": Imu(left.acc_mps2, dead)}
    found = check_geometry(Recording(drive.recording.time_s, sensors), CHAIRS[1], mount)
    assert not any("radius over" in text for text in found.warnings)
    assert any("sensor failed" in text for text in found.warnings), found


def turns(seed=3, legs=BOTH_WAYS):
    static, straight, drive = trials(SAMPLE_CHAIR, seed, legs, noise=LIKE_SAMPLE)
    return drive.recording, calibrate_mount(static.recording, straight.recording).mount


@pytest.mark.parametrize("late", [-8, -3, 0, 5, 9])
def test_the_lag_of_the_wheels_is_found(late):
    """Wheels whose samples come some hundredths of a second after the frame's, or before."""
    recording, mount = turns()
    sensors = {
        name: imu if name == "frame" else Imu(*(np.roll(v, late, axis=0) for v in (imu.acc_mps2, imu.gyr_radps)))  # noqa: E501
        for name, imu in recording.sensors.items()
    }  # fmt: skip
    found = check_geometry(Recording(recording.time_s, sensors), SAMPLE_CHAIR, mount)
    assert found.lag_s == pytest.approx(late / 100, abs=0.003)


def test_wheels_that_do_not_go_with_the_frame_have_no_lag():
    """Two yaw rates that have nothing in common; a correlation always has some largest value."""
    recording, mount = turns()
    rng = np.random.default_rng(4)
    frame = recording.sensors["frame"]
    sensors = dict(recording.sensors)
    sensors["frame"] = Imu(frame.acc_mps2, rng.normal(0, 1, frame.gyr_radps.shape))
    assert np.isnan(check_geometry(Recording(recording.time_s, sensors), SAMPLE_CHAIR, mount).lag_s)


def test_a_gain_of_each_side_needs_a_second_of_turning():
    """1.6 s of turning to the right are enough, 0.9 s are not."""
    for seconds, known in ((1.6, True), (0.9, False)):
        legs = (
            Leg(1, 1.0), Leg(2, 2.0, 1.2), Leg(4, 6.0, 0.0, 70.0),
            Leg(4, seconds, 0.0, -70.0), Leg(3, 2.0, -1.0), Leg(1, 1.0),
        )  # fmt: skip
        found = check_geometry(*reversed_(turns(legs=legs)))
        assert found.judged and np.isfinite(found.yaw_gain_left)
        assert np.isfinite(found.yaw_gain_right) == known


def test_turns_on_the_spot_show_the_track_and_not_the_radii():
    """The wheels go as much forward as backward: a radius that is off adds nothing to a turn."""
    legs = (Leg(1, 2.0), Leg(4, 6.0, 0.0, 70.0), Leg(4, 6.0, 0.0, -70.0), Leg(1, 2.0))
    recording, mount = turns(legs=legs)
    found = check_geometry(recording, SAMPLE_CHAIR, mount)
    assert found.judged and found.fits
    assert np.isnan([found.radius_ratio, found.radius_ratio_sd]).all()
    assert abs(found.track_m - SAMPLE_CHAIR.track_m) < 2 * found.track_sd_m < 0.05


def reversed_(pair):
    recording, mount = pair
    return recording, SAMPLE_CHAIR, mount


def test_wheels_that_disagree_make_the_camber_uncertain():
    """Cosines of 0.96 and 0.92: the difference of their scale is in the standard deviation."""
    yaw = np.linspace(0.5, 2.0, 200)
    turning = np.ones(200, bool)

    def rates(cosine):
        return np.column_stack([cosine * yaw, 0 * yaw, 0 * yaw])

    same, sd_same = _camber(rates(0.94), rates(0.94), yaw, turning, 0.002, 0.003)
    other, sd_other = _camber(rates(0.96), rates(0.92), yaw, turning, 0.002, 0.003)
    assert same == pytest.approx(np.arccos(0.94)) and other == pytest.approx(same)
    spread = np.hypot(0.02, 0.002)
    assert sd_other == pytest.approx(spread / max(np.sin(other), np.sqrt(2 * spread)))
    assert sd_other > 2 * sd_same


def test_an_offset_that_contradicts_the_rest_widens_the_uncertainty():
    """A wheel's gyroscope reads 3 deg/s more as soon as it moves: the rests do not show it."""
    court = random_court(7, slips=0)
    static, straight = court.calibration_trials(MTI_1)
    cal = calibrate_mount(static.recording, straight.recording)
    drive = court.drive(MTI_1)
    before = check_geometry(drive.recording, court.geometry, cal.mount, offsets=cal.offsets)
    wheel = drive.recording.sensors["left_wheel"]
    moving = (np.abs(drive.linear_velocity_mps) > 0.02) | (np.abs(drive.yaw_rate_radps) > 0.02)
    axle = cal.mount.rotation_imu_to_wheel("left")[2]
    gyr = wheel.gyr_radps + np.deg2rad(3.0) * moving[:, None] * axle
    sensors = {**drive.recording.sensors, "left_wheel": Imu(wheel.acc_mps2, gyr)}
    changed = Recording(drive.recording.time_s, sensors)
    after = check_geometry(changed, court.geometry, cal.mount, offsets=cal.offsets)
    assert after.track_sd_m > 1.5 * before.track_sd_m
    assert abs(after.track_m - court.geometry.track_m) < 3 * after.track_sd_m


def test_a_camber_of_zero_is_as_uncertain_as_its_cosine_makes_it():
    """cos(c) = 1 - s has c = sqrt(2 s): an error s of the cosine hides a camber of that size."""
    yaw, turning = np.linspace(0.5, 2.0, 200), np.ones(200, bool)
    upright = np.column_stack([yaw, 0 * yaw, 0 * yaw])
    for gain_sd in (0.003, 0.01):
        camber, sd = _camber(upright, upright, yaw, turning, gain_sd, 0.003)
        hidden = np.arccos(1 - np.hypot(0.0015, gain_sd))
        assert camber == 0 and 0.4 * hidden < sd < hidden


def test_residuals_that_last_are_taken_in_blocks_of_a_second():
    """A wheel whose rate errs by as much from half second to half second, or in each sample."""
    recording, mount = turns()
    time_s = recording.time_s
    rng = np.random.default_rng(77)
    knots = np.arange(0, time_s[-1] + 0.5, 0.5)
    lasting = np.interp(time_s, knots, np.sqrt(1.5) * rng.standard_normal(len(knots)))
    axle = mount.rotation_imu_to_wheel("left")[2]
    wheel, sd = recording.sensors["left_wheel"], []
    for error in (lasting, rng.standard_normal(len(time_s))):
        gyr = wheel.gyr_radps + 0.12 * error[:, None] * axle
        sensors = {**recording.sensors, "left_wheel": Imu(wheel.acc_mps2, gyr)}
        noisy = Recording(time_s, sensors)
        found = check_geometry(noisy, SAMPLE_CHAIR, mount, **CALIBRATED)
        sd.append(found.radius_ratio_sd)
    # Beside it stands what scale factors leave open: 0.3 % of either wheel.
    by_noise = np.sqrt(np.square(sd) - 2 * 0.003**2)
    assert by_noise[0] > 3 * by_noise[1], sd


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("sd", [0.05, 0.5])
def test_what_is_known_of_one_unknown_is_one_more_observation(place, sd):
    """The information of both adds up; a contradiction of more than one sd widens the rest."""
    rng = np.random.default_rng(78)
    root = rng.standard_normal((3, 3))
    covariance, found = root @ root.T, 0.3 * rng.standard_normal(3)
    information = np.linalg.inv(covariance)
    both = information + np.diag(np.eye(3)[place]) / sd**2
    for factor in (1.0, 5.0):
        there = factor * found
        known, spread = _known(there, covariance, place, sd)
        assert known == pytest.approx(np.linalg.solve(both, information @ there))
        widened = max(1.0, there[place] ** 2 / (covariance[place, place] + sd**2))
        assert spread == pytest.approx(widened * np.linalg.inv(both))


def test_yaw_rates_are_compared_sample_by_sample():
    """Wheels that read 1.2 times the frame's rate, which turns by 5 rad, then 5 rad back."""
    yaw = np.repeat([0.0, 1.0, 0.0, -1.0, 0.0, 0.2], [200, 500, 200, 500, 200, 300])
    usable = np.ones(len(yaw), bool)
    found = _agreement(yaw, 1.2 * yaw, 100.0, usable)
    assert found["gain"] == pytest.approx(1.2) and found["correlation"] == pytest.approx(1.0)
    assert found["residual_radps"] == pytest.approx(0.2 * np.sqrt(np.mean(yaw**2)))
    # The mean over a second makes a ramp of a second of each end: 0.3² / 2 lie below 0.3 rad/s.
    assert found["turned_rad"] == pytest.approx(10 - 4 * 0.045, abs=0.02)
    assert abs(found["lag_s"]) < 0.002  # a fifth of a sample
    usable[200:700] = False
    half = _agreement(yaw, np.where(usable, -yaw, 9.0), 100.0, usable)
    assert half["gain"] == pytest.approx(-1.0) and half["correlation"] == pytest.approx(-1.0)
    # Of the first turn the ramps are left that reach out of it, from 0.5 to 0.3 rad/s.
    assert half["turned_rad"] == pytest.approx(5 - 2 * 0.045 + 2 * 0.08, abs=0.02)
    still = _agreement(0 * yaw, 0 * yaw, 100.0, usable)
    assert np.isnan([still["gain"], still["correlation"], still["lag_s"]]).all()
    assert still["residual_radps"] == still["turned_rad"] == 0


@pytest.mark.parametrize(
    ("off", "sd", "mismatch", "mismatch_sd", "says"),
    [
        (0.009, 0.001, 0.0, 0.001, ""),
        (0.011, 0.001, 0.0, 0.001, "a track of 0.851 m, not 0.840 m (+0.011 m)"),
        (-0.011, 0.001, 0.0, 0.001, "both radii should be +1.3%"),
        (0.020, 0.007, 0.0, 0.001, ""),
        (0.0, 0.001, 0.0049, 0.001, ""),
        (0.0, 0.001, 0.0051, 0.001, "should be 0.9949 times"),
        (0.0, 0.001, -0.0051, 0.001, "should be 1.0051 times"),
        (0.0, 0.001, 0.02, 0.007, ""),
        (0.0, 0.001, 0.19, 0.001, "should be 0.8100 times"),
        (0.0, 0.001, 0.21, 0.001, "speeds differ by 21%"),
        (-0.640, 0.001, 0.0, 0.001, ""),
        (-0.650, 0.001, 0.0, 0.001, "gain -0.03): left and right wheel sensor are swapped"),
    ],
)
def test_what_a_tape_cannot_err_by_is_told(off, sd, mismatch, mismatch_sd, says):
    """Beyond a centimetre of track, half a percent of a radius, and three standard deviations."""
    distance = SAMPLE_CHAIR.wheel_centre_distance_m + off
    said = _on_distances(SAMPLE_CHAIR, _Distances(distance, sd, mismatch, mismatch_sd, sd))
    if off == -0.640:  # between: no distance at all, but not the other way round
        assert len(said) == 1 and "a track of 0.200 m" in said[0]
    else:
        assert [says in text for text in said] == [True] * bool(says)


@pytest.mark.parametrize(
    ("camber_deg", "sd_deg", "told"),
    [(20.9, 0.1, False), (21.1, 0.1, True), (16.9, 0.1, True), (24.0, 2.0, False)],
)
def test_a_camber_is_told_beyond_two_degrees(camber_deg, sd_deg, told):
    said = _on_camber(SAMPLE_CHAIR, *np.deg2rad([camber_deg, sd_deg]))
    assert len(said) == told
    assert all(f"a camber of {camber_deg} deg, not 19.0 deg" in text for text in said)


def test_wheels_and_frame_that_disagree_are_not_called_too_few_turns():
    """A wheel whose rate wanders by 1 rad/s while the chair turns, by more than a whole turn."""
    court = random_court(1, slips=0)
    static, straight = court.calibration_trials(MTI_1)
    found, drive = calibrate_mount(static.recording, straight.recording), court.drive(MTI_1)
    trial, yaw = drive.recording, drive.yaw_rate_radps
    wander = ndimage.gaussian_filter1d(np.random.default_rng(1).normal(size=len(trial)), 20)
    turning = ndimage.uniform_filter1d((np.abs(yaw) > 0.1).astype(float), 50)
    along = (wander / wander.std() * turning)[:, None] * found.mount.rotation_imu_to_wheel("right")[
        2
    ]
    wrong = with_readings(trial, "right_wheel", gyr_radps=trial.gyroscope("right_wheel") + along)
    check = check_geometry(wrong, court.geometry, found.mount, offsets=found.offsets)
    assert not check.judged and check.turned_rad > 2 * np.pi
    assert "wheels and frame disagree too much to judge the geometry" in check.warnings[0]
    assert not any("too little" in sentence for sentence in check.warnings)


@pytest.mark.parametrize(("sd_m", "judged"), [(0.0227, False), (0.0276, True)])
def test_a_scattered_track_is_judged_if_it_may_be_none(sd_m, judged, monkeypatch):
    """0.08 m are 3.5 standard deviations from none, or 2.9: swapped sensors may scatter too."""
    scattered = _Distances(0.08, sd_m, 0.0, 0.001, 0.02)
    monkeypatch.setattr(module, "_distances", lambda *_: scattered)
    recording, mount = turns()
    found = check_geometry(recording, SAMPLE_CHAIR, mount)
    assert found.judged == judged and not found.fits
    assert ("could be told to 0.020 m only" in found.warnings[0]) != judged


def test_turns_to_one_side_only_give_no_factor_of_the_other():
    left, right = Leg(4, 3.0, 0.0, 120.0), Leg(1, 1.0)
    static, straight, drive = trials(
        SAMPLE_CHAIR, 3, legs=(right, left, right, Leg(2, 2.0, 1.0), left)
    )
    mount = calibrate_mount(static.recording, straight.recording).mount
    text = check_text(check_geometry(drive.recording, SAMPLE_CHAIR, mount))
    assert "nan" not in text and "right turns  too few of them" in text
    assert "times what is given" in text


def test_what_a_drive_does_not_show_is_printed_as_not_found():
    """Wheels and frame do not go together in a drive without a turn, and at rest nothing moves."""
    parts = trials(SAMPLE_CHAIR, 1)
    mount = calibrated(*parts).mount
    for drive, lines in ((parts[1], ("lag of the wheels",)), (parts[0], ("correlation", "lag"))):
        found = check_geometry(drive.recording, SAMPLE_CHAIR, mount)
        assert np.isnan(found.lag_s)
        text = check_text(found)
        assert "nan" not in text
        for name in lines:
            (line,) = [one for one in text.splitlines() if one.startswith(name)]
            assert line.endswith(" not found")


def test_a_drive_at_nearly_one_speed_shows_the_track():
    """Straight at 0.6 m/s and around at 0.7 m/s: no turn on the spot, so the radii are judged."""
    chair = replace(SAMPLE_CHAIR, camber_rad=0.0)
    around = (Leg(1, 6.0), Leg(2, 4.0, 0.6), Leg(6, 30.0, 0.7, 35.0), Leg(2, 4.0, 0.6), Leg(1, 2.0))
    line = (Leg(1, 6.0), Leg(2, 20.0, 1.0), Leg(1, 4.0))
    straight, turns = (
        simulate_court(legs, chair, random_mounting(3), seed=6 + k, unit_seed=3, model=REAL)
        for k, legs in enumerate((line, around))
    )
    trial = straight.recording
    found = calibrate_mount(trial.trim(0.0, 5.5), trial)
    check = check_geometry(turns.recording, chair, found.mount, offsets=found.offsets)
    assert np.isfinite(check.radius_ratio)
    assert abs(check.track_m - chair.track_m) < 2 * check.track_sd_m < 0.02
