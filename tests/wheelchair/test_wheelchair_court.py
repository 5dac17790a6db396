"""The court simulator against independent numbers, and slip: found, mended and judged by truth."""

import math
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pandas as pd
import pytest
from scipy import integrate
from scipy.spatial.transform import Rotation

from mobility_imu.data import SAMPLE_VARIABLE, sample_folder
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.reproduction.wheelchair.sample import load_sample
from mobility_imu.reproduction.wheelchair.slip_study import random_court_errors
from mobility_imu.simulation.sensor import MTI_1, SensorModel
from mobility_imu.simulation.wheelchair import (
    Leg,
    Pushing,
    SlipEpisode,
    random_court,
    random_mounting,
    simulate_court,
    simulate_drive,
)
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    VelocitySettings,
    WheelchairGeometry,
    calibrate_mount,
    estimate_velocity,
)
from mobility_imu.wheelchair.slip import (
    SlipWindows,
    Source,
    WheelSpeeds,
    correct_slip,
    detect_slip,
    slip_report,
    slip_sources,
    wheel_speeds,
)
from mobility_imu.wheelchair.velocity import linear_velocity, wheel_yaw_rate

# The same after some dozen operations per sample, with speeds and rates of size 1 to 10.
EXACT = 1e-9
SIDES = ("left", "right")


def calibrated(court, model=None):
    static, straight = court.calibration_trials(model)
    return calibrate_mount(static.recording, straight.recording)


# Simulator


@pytest.mark.parametrize("seed", range(12))
def test_rolling_wheels_give_the_true_velocities_with_both_exact_pairs(seed):
    court = random_court(seed, slips=0, largest_toe_rad=0.0)
    made, calibration = court.drive(), calibrated(court)
    found = estimate_velocity(made.recording, court.geometry, calibration.mount)
    assert found.linear_velocity_mps == pytest.approx(made.linear_velocity_mps, abs=EXACT)
    assert found.yaw_rate_radps == pytest.approx(made.yaw_rate_radps, abs=EXACT)
    assert found.wheel_yaw_rate_radps == pytest.approx(made.yaw_rate_radps, abs=EXACT)
    assert not found.slip.any()
    bare = [
        made.recording.sensor(f"{side}_wheel").gyr_radps
        @ calibration.mount.rotation_imu_to_wheel(side)[2]
        for side in SIDES
    ]
    distance = court.geometry.wheel_centre_distance_m
    assert wheel_yaw_rate(*bare, court.geometry, distance_m=distance) == pytest.approx(
        made.yaw_rate_radps, abs=EXACT
    )
    middle = sum(court.geometry.wheel_centre(side)[1] for side in SIDES) / 2
    assert linear_velocity(*bare, court.geometry) == pytest.approx(
        made.linear_velocity_mps - made.yaw_rate_radps * middle, abs=EXACT
    )


def test_courts_have_all_tasks_both_turns_and_cambers_up_to_24_degrees():
    courts = [random_court(seed) for seed in range(40)]
    for court in courts:
        assert {leg.task for leg in court.legs} == {1, 2, 3, 4, 5, 6}
        for task in (4, 5, 6):
            signs = {np.sign(leg.yaw_rate_degps) for leg in court.legs if leg.task == task}
            assert signs == {-1, 1}
    cambers = [np.rad2deg(court.geometry.camber_rad) for court in courts]
    assert 0 <= min(cambers) < 3 and 21 < max(cambers) <= 24
    assert {slip.side for court in courts for slip in court.slips} == set(SIDES)
    assert {np.sign(slip.peak_mps) for court in courts for slip in court.slips} == {-1, 1}


SLOPING = (
    Leg(1, 1.0),
    Leg(2, 2.5, 1.4),
    Leg(6, 1.5, 1.2, 70.0, slope_deg=5.0),
    Leg(5, 2.0, 0.7, -100.0, slope_deg=-3.0),
    Leg(1, 1.0),
    Leg(3, 2.0, -0.8),
)
SLIPS = (SlipEpisode("left", 1.6, 0.8, 1.1), SlipEpisode("right", 3.0, 0.6, -0.7, 0.1))


@pytest.mark.parametrize("sensor", ["frame", "left_wheel", "right_wheel"])
@pytest.mark.parametrize("toe_rad", [0.0, 0.03])
def test_sensors_are_the_derivatives_of_their_path_in_the_room(sensor, toe_rad):
    """With slope, toe and slip; the path and the turns are summed up here from the truth alone."""
    rate, mounting = 2000.0, random_mounting(3)
    made = simulate_court(
        SLOPING,
        SAMPLE_CHAIR,
        mounting,
        seed=0,
        slips=SLIPS,
        toe_rad=toe_rad,
        sampling_rate_hz=rate,
    )
    time_s, v, pitch = made.recording.time_s, made.linear_velocity_mps, made.pitch_rad

    def sum_up(series):
        return integrate.cumulative_simpson(series, x=time_s, initial=0)

    # about a tilted z the yaw rate is the heading's rate times the cosine of the tilt
    heading = sum_up(made.yaw_rate_radps / np.cos(pitch))
    chair_to_room = Rotation.from_euler("ZY", np.column_stack([heading, -pitch]))
    nose = chair_to_room.apply([1.0, 0.0, 0.0])
    room = np.column_stack([sum_up(v * axis) for axis in nose.T])
    if sensor == "frame":
        body_to_chair, origin = Rotation.identity(len(v)), np.zeros(3)
    else:
        side = sensor.removesuffix("_wheel")
        sign = {"left": 1, "right": -1}[side]
        radius = getattr(SAMPLE_CHAIR.wheel_radius_m, side)
        half, camber = SAMPLE_CHAIR.track_m / 2, SAMPLE_CHAIR.camber_rad
        travel = (v - sign * made.yaw_rate_radps * half) * math.cos(toe_rad)
        rolled = sum_up(travel + getattr(made, f"slip_{side}_mps")) / radius
        toed = Rotation.from_euler("z", -sign * toe_rad)
        upright = Rotation.from_euler("x", sign * camber - math.pi / 2)
        body_to_chair = toed * upright * Rotation.from_rotvec(rolled[:, None] * [0, 0, 1])
        up_the_wheel = [0, -sign * radius * math.sin(camber), radius * math.cos(camber)]
        origin = np.array([0, sign * half, 0]) + toed.apply(up_the_wheel)
    place, turn = mounting[sensor].position_m, mounting[sensor].rotation_body_to_imu
    path = room + chair_to_room.apply(origin + body_to_chair.apply(np.array(place)))
    imu_to_room = chair_to_room * body_to_chair * Rotation.from_matrix(turn.T)
    acc = (path[2:] - 2 * path[1:-1] + path[:-2]) * rate**2
    force = imu_to_room[1:-1].inv().apply(acc + np.array([0, 0, STANDARD_GRAVITY_MPS2]))
    spun = (imu_to_room[:-2].inv() * imu_to_room[2:]).as_rotvec() * rate / 2
    imu = made.recording.sensor(sensor)
    # Where a bump begins or ends its acceleration has a kink: a difference over 0.5 ms is off by
    # a share of one step there, jerk (up to 40 m/s^3) times 0.25 ms = 0.01 m/s^2.
    error = np.abs(imu.acc_mps2[1:-1] - force).max(axis=1)
    assert error.max() < 0.02
    assert np.quantile(error, 0.9) < 5e-4
    assert imu.gyr_radps[1:-1] == pytest.approx(spun, abs=2e-4)


def test_speed_is_the_integral_of_the_acceleration_and_pushes_speed_up():
    made = random_court(5, slips=0).drive(sampling_rate_hz=1000.0)
    time_s = made.recording.time_s
    summed = integrate.cumulative_trapezoid(made.acceleration_mps2, time_s, initial=0)
    assert summed == pytest.approx(made.linear_velocity_mps, abs=1e-4)
    assert len(made.push_onset_s) > 15
    ahead = np.sign(np.interp(made.push_onset_s + 0.3, time_s, made.linear_velocity_mps))
    at_push = np.interp(made.push_onset_s + 0.15, time_s, made.acceleration_mps2)
    assert (at_push * ahead > 0.1).all()
    assert np.abs(made.linear_velocity_mps[made.task == 1]).max() < EXACT
    assert (made.linear_velocity_mps[made.task == 3] < EXACT).all()


def test_chair_coasts_at_the_rolling_resistance_between_pushes():
    pushing = Pushing(push_s=0.4, cycle_s=2.0, coasting_mps2=0.2)
    made = simulate_court(
        (Leg(2, 12.0, 1.5),), SAMPLE_CHAIR, random_mounting(0), seed=0, pushing=pushing
    )
    third = made.push_onset_s[2]
    middle = (made.recording.time_s > third + 0.6) & (made.recording.time_s < third + 1.8)
    # ramps of 0.1 s at both ends of 1.6 s make the plateau 1.6 / 1.5 of the mean
    assert made.acceleration_mps2[middle] == pytest.approx(-0.2 * 1.6 / 1.5, abs=EXACT)
    assert made.linear_velocity_mps[300:1000].mean() == pytest.approx(1.5, abs=0.1)


def test_slip_is_where_it_was_asked_and_leaves_the_truth_alone():
    made, rolling = (
        simulate_court(SLOPING, SAMPLE_CHAIR, random_mounting(1), seed=0, slips=slips)
        for slips in (SLIPS, ())
    )
    for name in ("linear_velocity_mps", "yaw_rate_radps", "task"):
        assert np.array_equal(getattr(made, name), getattr(rolling, name))
    time_s = made.recording.time_s
    inside = (time_s > 1.605) & (time_s < 2.395)
    assert np.array_equal(np.abs(made.slip_left_mps) > 1e-9, inside)
    assert made.slip_left_mps.max() == pytest.approx(1.1)
    assert made.slip_right_mps.min() == pytest.approx(-0.7)
    assert np.array_equal(made.slipping, (made.slip_left_mps != 0) | (made.slip_right_mps != 0))
    assert not rolling.slipping.any()
    for side in SIDES:
        spin, rolled = (
            court.recording.sensor(f"{side}_wheel").gyr_radps for court in (made, rolling)
        )
        extra = np.linalg.norm(spin - rolled, axis=1)
        radius = getattr(SAMPLE_CHAIR.wheel_radius_m, side)
        # the wheel's angle differs after a slip, so its axes do: the rate across them turns
        axle = random_mounting(1)[f"{side}_wheel"].rotation_body_to_imu[:, 2]
        along = (spin - rolled) @ axle * radius
        assert along == pytest.approx(getattr(made, f"slip_{side}_mps"), abs=EXACT)
        assert extra.max() > 1
    assert list(made.truth())[-2:] == ["slip_left_mps", "slip_right_mps"]
    assert (made.truth()["task_code"] == made.task).all()


def test_same_seed_gives_the_same_bytes_and_other_trials_other_noise():
    first, again = (random_court(4).drive(MTI_1) for _ in range(2))
    pd.testing.assert_frame_equal(
        first.recording.to_frame(), again.recording.to_frame(), check_exact=True
    )
    pd.testing.assert_frame_equal(first.truth(), again.truth(), check_exact=True)
    court = random_court(4)
    static, _ = court.calibration_trials(MTI_1)
    still = slice(0, 100)
    assert not np.array_equal(
        static.recording.sensor("frame").acc_mps2[still],
        first.recording.sensor("frame").acc_mps2[still],
    )


def test_sensor_model_adds_its_errors_and_only_those():
    court = random_court(6)
    ideal, through, noisy = (court.drive(model) for model in (None, SensorModel(), MTI_1))
    for name in ideal.recording.sensors:
        kept, clean, off = (
            made.recording.sensor(name).gyr_radps for made in (ideal, through, noisy)
        )
        # the rolled angle is summed up in finer steps: 1/12 (10 ms)^2 of the spin's changes, times
        # the rate across the axle of 2 rad/s
        assert clean == pytest.approx(kept, abs=2e-3)
        assert 1e-3 < np.abs(off - kept).mean() < 0.1
    assert np.array_equal(ideal.linear_velocity_mps, through.linear_velocity_mps) or (
        through.linear_velocity_mps == pytest.approx(ideal.linear_velocity_mps, abs=EXACT)
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Pushing(push_s=0.0), "push_s = 0"),
        (lambda: Pushing(push_s=1.0, cycle_s=0.9), r"cycle_s = 0\.9"),
        (lambda: SlipEpisode("middle", 0, 1, 1), "middle"),
        (lambda: SlipEpisode("left", 0, 0, 1), "duration_s = 0"),
        (lambda: SlipEpisode("left", 0, 1, 1, -0.1), r"rise_s = -0\.1"),
        (lambda: random_court(0).drive(SensorModel(dropped_share=0.1)), r"dropped_share = 0\.1"),
        (
            lambda: simulate_court((Leg(1, 0.5),), SAMPLE_CHAIR, random_mounting(0), seed=0),
            r"0\.5 s",
        ),
        (
            lambda: simulate_drive(
                (Leg(2, 2.0, 1.0, slope_deg=2.0),), SAMPLE_CHAIR, random_mounting(0), seed=0
            ),
            "slope_deg = 2",
        ),
    ],
)
def test_what_cannot_be_driven_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


# Slip


def slipping_pair(side, peak, *, acc_offset=0.0):
    """One wheel slips for half a second while the chair speeds up and slows down."""
    time_s = np.arange(300) / 100
    truth = 1.5 + 0.4 * np.sin(2 * np.pi * time_s)
    acc = 0.8 * np.pi * np.cos(2 * np.pi * time_s) + acc_offset
    extra = SlipEpisode(side, 1.0, 0.5, peak).profile(time_s)[0]
    speeds = {name: truth + (extra if name == side else 0) for name in SIDES}
    wheels = WheelSpeeds(speeds["left"], speeds["right"])
    excess = (wheels.right - wheels.left) / 0.8
    return truth, acc, wheels, detect_slip(np.zeros(300), excess, 100), extra


@pytest.mark.parametrize("peak", [1.0, -1.0, 0.4, -0.4])
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("acc_offset", [0.0, 0.9])  # 0.9 m/s^2: a slope of 5 degrees
def test_the_rolling_wheel_is_recognised_and_taken(side, peak, acc_offset):
    truth, acc, wheels, windows, extra = slipping_pair(side, peak, acc_offset=acc_offset)
    source = slip_sources(wheels, acc, windows, 100)
    flagged = windows.flags(300)
    other = Source.RIGHT_WHEEL if side == "left" else Source.LEFT_WHEEL
    assert set(source[flagged].tolist()) == {other}
    assert not source[~flagged].any()
    mean = (wheels.left + wheels.right) / 2
    mended = correct_slip(mean, acc, windows, 100, wheels=wheels)
    assert mended[flagged] == pytest.approx(truth[flagged], abs=EXACT)
    assert np.array_equal(mended[~flagged], mean[~flagged])
    tool = correct_slip(mean, acc, windows, 100, method="tool")
    assert np.abs(tool - truth)[flagged].max() > np.abs(mended - truth)[flagged].max()
    assert np.abs(extra[~flagged]).max() < 0.2 * 0.8 + EXACT  # below the threshold


def test_where_no_wheel_rolls_the_acceleration_is_integrated():
    truth, acc, wheels, _, _ = slipping_pair("left", 1.5)
    wheels = WheelSpeeds(wheels.left, truth + 0.5 * (wheels.left - truth))
    windows = detect_slip(np.zeros(300), (wheels.right - wheels.left) / 0.8, 100)
    source = slip_sources(wheels, acc, windows, 100)
    assert set(source[windows.flags(300)].tolist()) == {Source.ACCELERATION}
    mean = (wheels.left + wheels.right) / 2
    mended = correct_slip(mean, acc, windows, 100, wheels=wheels)
    error, left_alone = np.abs(mended - truth), np.abs(mean - truth)
    assert error.max() < left_alone.max() / 2


@pytest.mark.parametrize("window", [(0, 40), (250, 299)])
def test_windows_at_the_ends_of_the_recording_are_judged_from_the_end_that_is_there(window):
    time_s = np.arange(300) / 100
    truth = 1.5 + 0.4 * np.sin(2 * np.pi * time_s)
    acc = 0.8 * np.pi * np.cos(2 * np.pi * time_s)
    first, last = window
    slipping = truth.copy()
    slipping[first : last + 1] += 0.6
    windows = SlipWindows(np.array([first]), np.array([last]))
    wheels = WheelSpeeds(slipping, truth)
    mean = (slipping + truth) / 2
    mended = correct_slip(mean, acc, windows, 100, wheels=wheels)
    assert mended == pytest.approx(truth, abs=EXACT)


def test_slip_that_changes_wheels_inside_a_window_is_taken_apart():
    truth, acc, wheels, _, extra = slipping_pair("left", 1.0)
    later = np.roll(extra, 40)  # overlaps the end of the first slip
    wheels = WheelSpeeds(wheels.left, truth + later)
    windows = SlipWindows(np.array([105]), np.array([185]))
    source = slip_sources(wheels, acc, windows, 100)
    assert source[120] == Source.RIGHT_WHEEL and source[165] == Source.LEFT_WHEEL


def test_speed_of_each_wheel_comes_from_the_disagreement_of_the_yaw_rates():
    chair = WheelchairGeometry.from_degrees(
        12, wheel_radius_left_m=0.30, wheel_radius_right_m=0.31, track_m=0.8
    )
    left, right, yaw = np.array([4.0, 2.0]), np.array([4.5, 5.0]), np.array([0.3, -0.2])
    speeds = wheel_speeds(
        linear_velocity(left, right, chair),
        wheel_yaw_rate(left, right, chair, distance_m=chair.track_m),
        yaw,
        chair,
    )
    assert speeds.left == pytest.approx(0.30 * left + yaw * 0.4, abs=EXACT)
    assert speeds.right == pytest.approx(0.31 * right - yaw * 0.4, abs=EXACT)


def test_method_is_checked():
    windows = SlipWindows(np.array([2]), np.array([20]))
    with pytest.raises(InputError, match="method = 'wheel'"):
        correct_slip(np.ones(30), np.zeros(30), windows, 100, method="wheel")
    with pytest.raises(InputError, match="needs the speed from each wheel"):
        correct_slip(np.ones(30), np.zeros(30), windows, 100, method="wheels")


def test_report_counts_windows_samples_and_changes():
    truth, acc, wheels, _, _ = slipping_pair("right", 1.0)
    windows = SlipWindows(np.array([20, 105]), np.array([23, 144]))  # 4 frames are too short
    mean = (wheels.left + wheels.right) / 2
    mended = correct_slip(mean, acc, windows, 100, wheels=wheels)
    source = slip_sources(wheels, acc, windows, 100)
    report = slip_report(mean, mended, windows, 100, source=source)
    assert report.corrected.tolist() == [False, True]
    assert report.sources == ("both wheels", "left wheel")
    assert report.share == pytest.approx(44 / 300)
    assert report.corrected_share == pytest.approx(40 / 300)
    assert report.largest_change == pytest.approx(np.abs(mean - truth)[105:145].max())
    assert report.largest_change_mps[0] == 0
    table = report.to_frame()
    assert table["start_s"].tolist() == [0.2, 1.05] and table["end_s"].tolist() == [0.23, 1.44]
    tool = slip_report(mean, correct_slip(mean, acc, windows, 100, method="tool"), windows, 100)
    assert tool.sources == ("both wheels", "acceleration")
    empty = slip_report(mean, mean, SlipWindows(*np.zeros((2, 0), int)), 100)
    assert empty.share == empty.largest_change == 0 and empty.to_frame().empty


COURTS = [25, pytest.param(50, marks=pytest.mark.slow)]


@pytest.fixture(scope="module", params=COURTS)
def one_wheel(request):
    found = random_court_errors(range(request.param), both_wheels_share=0.0)
    flags = [(court.flagged_that_slip, court.slipping_that_are_flagged) for court in found]
    return np.array([court.rms_mps for court in found]), np.array(flags)


def test_corrected_speed_is_the_best_on_every_court(one_wheel):
    uncorrected, tool, ours, printed, printed_tool = one_wheel[0].T
    for other in (uncorrected, tool, printed, printed_tool):
        assert (ours < other).all()
    assert ours.mean() < 0.1 * uncorrected.mean()
    assert ours.mean() < 0.5 * tool.mean()


def test_flags_are_slip_and_most_slip_is_flagged(one_wheel):
    true_share, found_share = one_wheel[1].T
    assert true_share.min() > 0.99
    assert 0.75 < found_share.mean() < 0.95  # the ends of an episode lie below the threshold


@pytest.mark.parametrize("courts", COURTS)
def test_corrected_speed_is_better_also_where_both_wheels_slip_alike(courts):
    rms = np.array([c.rms_mps for c in random_court_errors(range(courts), both_wheels_share=0.15)])
    uncorrected, tool, ours, printed, printed_tool = rms.T
    for other in (uncorrected, tool, printed):
        assert (ours < other).all()
    # The printed term calls every turn slip and integrates there: by accident it also mends slip
    # of both wheels in a turn, which no yaw rate shows.
    assert ours.mean() < printed_tool.mean()
    assert (ours < printed_tool).mean() >= 0.7


def test_on_a_changing_slope_integration_fails_and_the_rolling_wheel_does_not():
    legs = (Leg(1, 1.0), Leg(2, 3.0, 1.3), Leg(2, 4.0, 1.3, slope_deg=5.0), Leg(2, 3.0, 1.3))
    slips = (SlipEpisode("left", 3.6, 0.9, 0.8), SlipEpisode("right", 7.5, 1.0, -0.8))
    mounting = random_mounting(2)
    still, line, made = (
        simulate_court(part, SAMPLE_CHAIR, mounting, seed=0, slips=episodes)
        for part, episodes in (
            ((Leg(1, 3.0),), ()),
            ((Leg(1, 1.0), Leg(2, 5.0, 1.2), Leg(1, 1.0)), ()),
            (legs, slips),
        )
    )
    calibration = calibrate_mount(still.recording, line.recording)
    before, after = (
        estimate_velocity(
            made.recording, SAMPLE_CHAIR, calibration.mount, VelocitySettings(slip_correction=on)
        )
        for on in (False, True)
    )
    windows = detect_slip(before.yaw_rate_radps, before.wheel_yaw_rate_radps, 100)
    acc = calibration.mount.frame(made.recording.sensor("frame").acc_mps2)[:, 0]
    tool = correct_slip(before.linear_velocity_mps, acc, windows, 100, method="tool")
    flagged = windows.flags(len(tool))
    tool_error, our_error = (
        np.abs(speed - made.linear_velocity_mps)[flagged].max()
        for speed in (tool, after.linear_velocity_mps)
    )
    assert tool_error > 0.1
    # while the slope changes by 5 deg in 0.8 s the wheel's own pitch rate adds 0.3 m x 0.2 rad/s,
    # and at its middle pitch rates of minimum jerk are 1.9 times the mean
    assert our_error < 0.07


# The real sample


sample = pytest.mark.skipif(
    sample_folder() is None, reason=f"{SAMPLE_VARIABLE} does not name WheelMove-ID's sample"
)


@sample
def test_sample_hardly_slips_once_the_turn_direction_is_kept():
    data = load_sample(sample_folder())
    share = {
        form: estimate_velocity(
            data.trial, SAMPLE_CHAIR, data.calibration.mount, VelocitySettings(form=form)
        ).slip
        for form in ("corrected", "printed")
    }
    assert share["corrected"].mean() <= 0.03
    assert share["printed"].mean() == pytest.approx(0.29, abs=0.005)


@sample
def test_sample_is_changed_less_than_by_the_tool():
    data = load_sample(sample_folder())
    change = {}
    for form in ("corrected", "printed"):
        before, after = (
            estimate_velocity(
                data.trial,
                SAMPLE_CHAIR,
                data.calibration.mount,
                VelocitySettings(
                    form=form,
                    slip_correction=on,
                    slip_method="tool" if form == "printed" else "wheels",
                ),
            ).linear_velocity_mps
            for on in (False, True)
        )
        change[form] = np.abs(after - before)
    assert (change["corrected"] > 0).mean() < 0.01 < 0.2 < (change["printed"] > 0).mean()


def test_courts_have_the_same_errors_on_other_processes():
    one = random_court_errors(range(2), 0.15)
    with ProcessPoolExecutor(2) as executor:
        other = random_court_errors(range(2), 0.15, executor)
    assert [c.rms_mps.tobytes() for c in one] == [c.rms_mps.tobytes() for c in other]
