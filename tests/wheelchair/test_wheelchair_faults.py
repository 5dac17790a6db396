"""Faults of a chair's sensors: found at a clear size, with what they cost; none invented."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from faulty import SENSORS, calibration, drive, largest, look, of_code, series, turned
from scipy.integrate import cumulative_trapezoid

from mobility_imu.errors import InputError
from mobility_imu.faults import with_readings
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.recorded import numbers
from mobility_imu.reproduction.wheelchair.fault_kinds import KINDS, MODELS, clean_drive
from mobility_imu.reproduction.wheelchair.faults import (
    CASES,
    SEEN_SEED,
    cases_table,
    example,
    false_alarms,
    one_case,
    summary_of,
)
from mobility_imu.simulation import faults as inject
from mobility_imu.wheelchair import (
    VelocitySettings,
    estimate_velocity,
    find_faults,
    frame_faults,
)
from mobility_imu.wheelchair.contradictions import gain_of
from mobility_imu.wheelchair.faults import valid_samples, with_valid
from mobility_imu.wheelchair.lags import lag_between
from mobility_imu.wheelchair.recovery import held_samples, recovered, tied_rate
from mobility_imu.wheelchair.turning import spin_fit, upward_angle, yaw_rate_of_wheel

# A few samples of smoothing and noise lie between a cost that is stated and the true one.
FACTOR = 2.0


CLEAR = {
    "a wheel's range": ("range", "left_wheel_gyr", "speed",
                        lambda t: inject.clip(t, "left_wheel", "gyr", 4.0)),
    "the frame's range": ("range", "frame_gyr", "yaw rate",
                          lambda t: inject.clip(t, "frame", "gyr", 0.8)),
    "spikes": ("spike", "frame_gyr", "yaw rate",
               lambda t: inject.spike(t, "frame", "gyr", [1500, 2500], 1, 3.0)),
    "small spikes": ("spike", "right_wheel_gyr", "speed",
                     lambda t: inject.spike(t, "right_wheel", "gyr", [1500, 2500], 1, 0.3)),
    "a wheel's scale": ("scale", "right_wheel_gyr", "speed",
                        lambda t: inject.scale(t, "right_wheel", "gyr", 1.05)),
    "the frame's scale": ("scale", "frame_gyr", "yaw rate",
                          lambda t: inject.scale(t, "frame", "gyr", 0.93)),
    "a late frame": ("lag", "frame", "yaw rate", lambda t: inject.late(t, "frame", 0.3)),
    "a late wheel": ("lag", "left_wheel", "speed", lambda t: inject.late(t, "left_wheel", 0.05)),
    "a turned frame": ("turned", "frame", "yaw rate", lambda t: turned(t, "frame", 25.0)),
    "a turned wheel": ("turned", "left_wheel", "speed", lambda t: turned(t, "left_wheel", 20.0)),
    "a reversed wheel": ("reversed", "left_wheel_gyr", "speed",
                         lambda t: inject.reverse(t, "left_wheel")),
    "a reversed frame": ("reversed", "frame_gyr", "yaw rate",
                         lambda t: inject.reverse(t, "frame")),
    "frame for wheel": ("exchanged", "frame, left_wheel", "speed",
                        lambda t: inject.exchange(t, "frame", "left_wheel")),
    "a dead axis": ("dead axis", "frame_gyr_y", "yaw rate",
                    lambda t: inject.scale(t, "frame", "gyr", [1, 0, 1])),
}  # fmt: skip


@pytest.mark.parametrize("name", CLEAR)
def test_a_clear_fault_is_found_with_its_cost(name):
    code, sensor, result, fault = CLEAR[name]
    faulty = fault(drive().trial)
    (found,) = [f for f in look(faulty) if f.code == code]
    assert found.sensor == sensor
    try:
        moved = series(faulty)
    except InputError:  # the estimate refuses it; nothing was moved that could be compared
        assert not found.costs
        return
    (stated,) = [cost.largest for cost in found.costs if cost.name == result]
    real = largest(moved, series(drive().trial), result)
    assert real / FACTOR < stated < real * FACTOR
    assert "; it moves the " in found.told
    pickle.loads(pickle.dumps(found))


def test_distance_and_turn_are_speed_and_yaw_rate_added_up():
    found = series(drive().trial)
    time_s = drive().trial.time_s
    for rate, way in (
        (("speed", "m/s"), ("distance", "m")),
        (("yaw rate", "deg/s"), ("turn", "deg")),
    ):
        added = cumulative_trapezoid(found[rate], time_s, initial=0)
        largest_step = np.abs(found[rate]).max() / drive().trial.sampling_rate_hz
        assert np.abs(found[way] - added).max() < 2 * largest_step


def test_an_offset_that_changes_hides_no_scale():
    """It is in a part of the drive, which is long; its repair leaves the rest to be looked at."""
    trial, up = drive().trial, drive().court.mounting["frame"].rotation_body_to_imu[:, 2]
    late = trial.time_s > 0.5 * trial.time_s[-1]
    more = np.outer(late, np.deg2rad(5.0) * up)
    changed = with_readings(trial, "frame", gyr_radps=trial.gyroscope("frame") + more)
    found = look(inject.scale(changed, "right_wheel", "gyr", 1.05))
    assert {(fault.code, fault.sensor) for fault in found} == {
        ("offset", "frame_gyr"),
        ("scale", "right_wheel_gyr"),
    }
    assert 0.1 < of_code(found, "offset")[0].flags.mean() < 1


def test_a_frame_is_judged_by_wheels_that_both_go_with_it():
    """One wheel whose gravity says little speaks against the scale that the other one shows."""
    rng, time_s = np.random.default_rng(5), np.arange(6000) / 100
    true = np.sin(time_s / 3)
    yaw = {"frame": 1.1 * true, "left_wheel": true + rng.normal(0, 0.01, len(true))}
    for noise_radps, alike in ((0.01, True), (0.6, False)):
        yaw["right_wheel"] = true + rng.normal(0, noise_radps, len(true))
        shared = SimpleNamespace(yaw=yaw, sides=("left", "right"), rate_hz=100.0)
        found = frame_faults._against_wheels(shared)
        assert (found.correlation > frame_faults.ALIKE) == alike
        # A gain of either wheel that the other one does not have is part of the deviation.
        gains = [gain_of(yaw[f"{side}_wheel"], yaw["frame"], 100.0).gain for side in shared.sides]
        assert found.gain == pytest.approx(np.mean(gains)) and found.gain_sd > np.ptp(gains) / 2


@pytest.mark.parametrize("name", MODELS)
def test_nothing_is_found_where_nothing_is_wrong(name):
    for seed in (61, 62, 63):
        assert false_alarms(seed, name)["told"] == []


def test_a_size_comes_with_its_uncertainty():
    # A sensor that comes late repeats its first reading: that is another fault.
    (lag,) = of_code(look(inject.late(drive().trial, "frame", 0.3)), "lag")
    assert lag.size == pytest.approx(0.3, abs=0.01) and "lags by 0.30" in lag.sentence
    both = inject.late(inject.late(drive().trial, "frame", 0.2), "left_wheel", 0.2)
    (early,) = of_code(look(both), "lag")
    assert early.sensor == "right_wheel" and "comes early by" in early.sentence
    (scale,) = look(inject.scale(drive().trial, "left_wheel", "gyr", 1.04))
    assert scale.size == pytest.approx(0.04, abs=0.015)


def test_sensors_of_real_recordings_are_late_and_that_is_told():
    """The model's sensors lie up to 0.03 s apart: three samples, which a common turn shows."""
    told = [false_alarms(seed, "real")["told"] for seed in range(61, 67)]
    lags = [text for one in told for text in one if text.startswith("lag")]
    assert lags and all(float(text.split()[-1]) < 0.035 for text in lags)


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_gyroscope_that_fails_is_replaced_by_the_others(sensor):
    """For ten seconds of a court with slips: what slips is in a wheel's replacement."""
    clean, cal = drive().trial, calibration()
    frozen = inject.freeze(clean, sensor, "gyr", 12.0, 10.0)
    before, after = (
        estimate_velocity(one, drive().court.geometry, cal.mount, offsets=cal.offsets)
        for one in (clean, frozen)
    )
    assert after.valid.all() and np.isfinite(after.linear_velocity_sd_mps).all()
    steady = ~(before.slip | after.slip)
    assert np.abs(after.linear_velocity_mps - before.linear_velocity_mps)[steady].max() < 0.1
    assert np.abs(after.yaw_rate_radps - before.yaw_rate_radps).max() < np.deg2rad(3.0)
    assert any("replace it there" in sentence for sentence in after.warnings)
    (found,) = [fault for fault in look(frozen) if fault.code == "frozen"]
    assert found.sensor == f"{sensor}_gyr" and found.size == pytest.approx(10.0, abs=0.05)


def test_where_two_fail_nothing_is_known():
    faulty = drive().trial
    for sensor in ("frame", "left_wheel"):
        faulty = inject.freeze(faulty, sensor, "gyr", 20.0, 5.0)
    cal = calibration()
    found = estimate_velocity(faulty, drive().court.geometry, cal.mount, offsets=cal.offsets)
    inside = slice(2005, 2495)
    assert not found.valid[inside].any() and np.isinf(found.linear_velocity_sd_mps[inside]).all()
    assert found.valid[:1990].all() and found.to_frame()["valid"].iloc[2200] == 0


@pytest.mark.parametrize("reading", [0.0, 0.01, "first"])
def test_gyroscopes_that_are_all_dead_are_told(reading):
    """None of them can contradict another; with the accelerometers frozen too, they are told."""
    sensors = {}
    for name, imu in drive().trial.sensors.items():
        acc, gyr = np.array(imu.acc_mps2), np.array(imu.gyr_radps)
        if reading == "first":
            acc[:], gyr[:] = acc[0], gyr[0]
        else:
            gyr[:] = reading
        sensors[name] = Imu(acc, gyr)
    dead = Recording(drive().trial.time_s, sensors, source="dead")
    told = of_code(look(dead), "frozen")
    assert {fault.sensor.removesuffix("_gyr") for fault in told} == set(SENSORS)
    cal = calibration()
    found = estimate_velocity(dead, drive().court.geometry, cal.mount, offsets=cal.offsets)
    assert not found.valid.any() and np.isinf(found.linear_velocity_sd_mps).all()


def test_a_short_repetition_is_too_long_for_chance():
    rng = np.random.default_rng(5)
    noise = (rng.normal(0, 0.002, (6000, 3)) / 0.001).round() * 0.001
    assert not held_samples(noise).any()
    noise[3000:3008] = noise[3000]
    assert np.flatnonzero(held_samples(noise)).tolist() == list(range(3000, 3008))
    exact = np.zeros((6000, 3))
    exact[2000:4000] = np.sin(np.arange(2000) / 300)[:, None]
    assert not held_samples(exact).any()


@pytest.mark.parametrize(("others", "told"), [(50, False), (51, True)])
def test_so_few_readings_do_not_show_whether_they_are_noise(others, told):
    """Beside the ten that are held; fifty changes are asked for."""
    noise = (np.random.default_rng(0).normal(0, 0.002, (others + 10, 3)) / 0.001).round() * 0.001
    noise[30:40] = noise[30]
    assert np.flatnonzero(held_samples(noise)).tolist() == (list(range(30, 40)) if told else [])


def test_a_repetition_of_both_halves_is_a_lost_packet_sooner():
    """Noise of two steps repeats all axes of one half with a chance of 0.02 or less."""
    rng = np.random.default_rng(6)
    gyr, acc = ((rng.normal(0, 1.0, (6000, 3))).round() * step for step in (0.001, 0.005))
    assert not held_samples(gyr, acc).any()
    gyr[3000:3005] = gyr[3000]
    assert not held_samples(gyr).any() and not held_samples(gyr, acc).any()
    acc[3000:3005] = acc[3000]
    assert np.flatnonzero(held_samples(gyr, acc)).tolist() == list(range(3000, 3005))
    # An accelerometer that says one number at rest tells nothing more.
    assert not held_samples(gyr, np.tile([0.0, 0.0, 9.81], (6000, 1))).any()


def test_a_repetition_that_hid_a_motion_is_told_sooner():
    """Five equal readings of noise of two steps, at rest and while the rate changes."""
    rng = np.random.default_rng(8)
    motion = 2 * np.sin(np.arange(6000) / 40) * (np.arange(6000) > 2000)
    gyr = (
        motion[:, None] * [1.0, 0.5, 0.5] / 0.001 + rng.normal(0, 1.0, (6000, 3))
    ).round() * 0.001
    assert not held_samples(gyr).any()
    for first, told in ((1000, False), (3011, True)):
        held = gyr.copy()
        held[first : first + 5] = held[first]
        assert np.flatnonzero(held_samples(held)).tolist() == (
            list(range(first, first + 5)) if told else []
        )


@pytest.mark.parametrize(("seed", "factor"), [(63, 0.98), (67, 1.02), (80, 0.98), (96, 1.02)])
def test_camber_and_track_together_know_the_frame_s_scale_better(seed, factor):
    """By 13 to 22 deg of camber alone 2 % is within three standard deviations."""
    court = clean_drive(seed)
    cal = court.calibration()
    faulty = inject.scale(court.trial, "frame", "gyr", factor)
    (found,) = find_faults(faulty, court.court.geometry, cal.mount, offsets=cal.offsets)
    assert found.code == "scale" and found.sensor == "frame_gyr"
    assert abs(found.size - 0.02) < 0.006
    assert find_faults(court.trial, court.court.geometry, cal.mount, offsets=cal.offsets) == ()


def test_an_offset_that_no_rest_shows():
    clean = drive(rests=False).trial
    assert look(clean, rests=False) == ()
    up = drive(rests=False).court.mounting["frame"].rotation_body_to_imu[:, 2]
    (found,) = look(inject.offset(clean, "frame", "gyr", np.deg2rad(3.0) * up), rests=False)
    assert (found.code, found.sensor) == ("offset", "frame_gyr")
    assert "too much upward (turns to the left)" in found.sentence
    assert found.size == pytest.approx(3.0, abs=0.5)
    axle = drive(rests=False).court.mounting["left_wheel"].rotation_body_to_imu[:, 2]
    (found,) = look(inject.offset(clean, "left_wheel", "gyr", -np.deg2rad(4.0) * axle), rests=False)
    assert (found.code, found.sensor) == ("offset", "left_wheel_gyr")
    way = float(axle @ calibration(rests=False).mount.rotation_imu_to_wheel("left")[2])
    assert f"too {'much' if way < 0 else 'little'} forward about its axle" in found.sentence
    assert found.size == pytest.approx(4.0, abs=1.0)


def test_at_rest_an_offset_costs_nothing():
    assert look(inject.offset(drive().trial, "frame", "gyr", np.deg2rad([3.0, -2.0, 4.0]))) == ()


def test_wheels_exchanged_in_the_trial_only():
    faulty = inject.exchange(drive().trial, "left_wheel", "right_wheel")
    (found,) = [fault for fault in look(faulty) if fault.code == "exchanged"]
    assert "have each other's names in the trial" in found.sentence and found.costs


def test_wheels_exchanged_everywhere_are_told_without_a_repair():
    swap = [
        inject.exchange(one, "left_wheel", "right_wheel")
        for one in (drive().trial, drive().static, drive().straight)
    ]
    from mobility_imu.wheelchair import calibrate_mount

    cal = calibrate_mount(swap[1], swap[2])
    found = find_faults(swap[0], drive().court.geometry, cal.mount, offsets=cal.offsets)
    assert [fault.code for fault in found] == ["exchanged"] and found[0].repair is None


def test_a_frame_of_another_drive_is_at_odds_with_both_wheels():
    row = one_case("another drive's frame", 3, SEEN_SEED)
    assert row["right"] or row["found_as"] == "refused"


def test_accelerations_that_read_gravity_instead_of_force_are_mirrored():
    """Both wheels' accelerometers with the wrong sign: names or signs are in question."""
    faulty = drive().trial
    for sensor in SENSORS[1:]:
        faulty = inject.scale(faulty, sensor, "acc", (-1, -1, -1))
    (found,) = look(faulty)
    assert found.code == "mirrored" and not found.costs
    assert "turn the chair to the left by hand" in found.sentence
    assert valid_samples((found,), len(faulty)).all()


def test_small_faults_leave_the_samples_valid():
    cal = calibration()
    for lag_s, valid in ((0.02, True), (0.5, False)):
        faulty = inject.late(drive().trial, "frame", lag_s)
        found = look(faulty)
        assert found
        result = estimate_velocity(faulty, drive().court.geometry, cal.mount, offsets=cal.offsets)
        assert with_valid(result, found).valid.all() == valid


def test_a_clock_of_another_unit_and_one_sensor_for_two():
    slow = Recording(1000 * drive().trial.time_s, drive().trial.sensors, source="slow")
    assert "clock" in [fault.code for fault in look(slow)]
    cal = calibration()  # a rate of 0.1 Hz is told, and no reason to end with another word
    estimate_velocity(slow, drive().court.geometry, cal.mount, offsets=cal.offsets)
    twice = {**drive().trial.sensors, "left_wheel": drive().trial.sensor("right_wheel")}
    assert [f.code for f in look(Recording(drive().trial.time_s, twice))] == ["copy"]


def test_a_frame_that_reads_nothing_does_not_speak_against_a_clock():
    """Both wheels read 10 % too little; that no two gyroscopes do, and a frame could not say."""
    trial = inject.silence(drive().trial, "frame")
    found = look(Recording(trial.time_s * 1.1, trial.sensors, source="other rate"))
    assert {(fault.code, fault.sensor) for fault in found} == {
        ("frozen", "frame_gyr"),
        ("clock", "time_s"),
    }


@pytest.mark.parametrize("pace", [0.9, 1.04, 1.1])
def test_a_clock_at_another_pace_is_not_blamed_on_the_gyroscopes(pace):
    """Both wheels turn too much or too little by one factor; the frame fits them as recorded."""
    trial = drive().trial
    found = look(Recording(trial.time_s * pace, trial.sensors, source="other rate"))
    assert [fault.code for fault in found] == ["clock"]
    assert found[0].size == pytest.approx(abs(pace - 1), abs=0.01)
    assert "state the right sampling rate" in found[0].sentence
    costs = {cost.name: cost.largest for cost in found[0].costs}
    true = largest(series(trial), series(Recording(trial.time_s * pace, trial.sensors)), "distance")
    assert 0.5 < costs["distance"] / true < 2 and costs["speed"] == 0


def test_a_wheel_that_is_turned_by_half_a_turn_is_told_with_the_whole_angle():
    faulty = turned(drive().trial, "left_wheel", 160.0)
    (fault,) = of_code(look(faulty), "turned")
    assert fault.size == pytest.approx(160, abs=2) and not of_code(look(faulty), "reversed")


def test_a_second_is_too_short_for_a_judgement():
    trial = drive().trial
    assert look(trial.trim(trial.time_s[0], trial.time_s[0] + 1)) == ()


def test_one_wheel_and_no_gyroscope_are_looked_at_as_far_as_they_go():
    sensors = dict(drive().trial.sensors)
    alone = Recording(drive().trial.time_s, {k: sensors[k] for k in SENSORS[:2]})
    assert look(alone) == ()
    late = inject.late(alone, "frame", 0.2)
    (found,) = of_code(look(late), "lag")
    assert "which of the two is wrong, two cannot tell" in found.sentence
    sensors["frame"] = Imu(sensors["frame"].acc_mps2)
    assert look(Recording(drive().trial.time_s, sensors)) == ()


@pytest.mark.parametrize("other", ["right_wheel", "frame"])
@pytest.mark.parametrize("there", [True, False])
def test_signs_of_a_wheel_are_told_by_its_own_gravity_alone(other, there):
    """Whether its gyroscope or its accelerometer is wrong, two other gyroscopes would tell."""
    faulty = inject.scale(drive().trial, "left_wheel", "gyr", (-1, -1, 1))
    sensors = dict(faulty.sensors)
    without = sensors.pop(other)
    if there:
        sensors[other] = Imu(without.acc_mps2)
    (found,) = look(Recording(faulty.time_s, sensors))
    assert (found.code, found.sensor) == ("reversed", "left_wheel_gyr")


def test_settings_and_arguments_are_checked():
    cal, geometry = calibration(), drive().court.geometry
    with pytest.raises(InputError, match="settings"):
        find_faults(drive().trial, geometry, cal.mount, {"form": "printed"})
    with pytest.raises(InputError, match="geometry"):
        find_faults(drive().trial, 3, cal.mount)
    printed = VelocitySettings(form="printed")
    assert find_faults(drive().trial, geometry, cal.mount, printed, offsets=cal.offsets) == ()


# The tools


@pytest.mark.parametrize("factor", [1.0, 1.1, -1.0])
def test_gravity_counts_the_turns_of_a_wheel(factor):
    rng = np.random.default_rng(8)
    time_s = np.arange(6000) / 100
    spin = 4 + 2 * np.sin(time_s)
    angle = np.cumsum(spin) / 100
    acc = np.column_stack([9.81 * np.cos(angle), -9.81 * np.sin(angle), 0 * angle])
    acc += rng.normal(0, 0.3, acc.shape)
    assert -np.ptp(upward_angle(acc, 100)) == pytest.approx(angle[0] - angle[-1], abs=0.3)
    fit = spin_fit(acc, factor * spin, 100)
    error, sd = fit.scale(0.0)
    assert error == pytest.approx(factor - 1, abs=3 * sd) and sd < 0.01
    # With a scale error of 10 % for sure, an offset is judged with that freedom.
    assert abs(fit.offset(1.0)[0]) < 3 * fit.offset(1.0)[1]
    assert spin_fit(acc[:300], spin[:300], 100) is None
    assert spin_fit(np.tile([0.0, 9.81, 0.0], (6000, 1)), np.zeros(6000), 100) is None


def test_a_wheel_knows_the_turn_of_the_chair():
    run = drive().court.drive(None)
    for side in ("left", "right"):
        mount = calibration().mount
        imu = run.recording.sensor(f"{side}_wheel")
        yaw = yaw_rate_of_wheel(
            mount.wheel(side, imu.gyr_radps),
            mount.wheel(side, imu.acc_mps2),
            drive().court.geometry.camber_rad,
            100,
        )
        assert np.abs(yaw - run.yaw_rate_radps).max() < np.deg2rad(6.0)
        assert np.sqrt(np.mean((yaw - run.yaw_rate_radps) ** 2)) < np.deg2rad(1.0)


def test_two_rates_give_the_third():
    geometry = drive().court.geometry
    rng = np.random.default_rng(2)
    rates = {name: rng.normal(0, 3, 50) for name in SENSORS[1:]}
    rates["frame"] = tied_rate(rates, "frame", geometry)
    for name in SENSORS:
        assert tied_rate(rates, name, geometry) == pytest.approx(rates[name], abs=1e-12)
    vectors = {name: np.column_stack([0 * r, 0 * r, r]) for name, r in rates.items()}
    bad = np.zeros(50, bool)
    bad[10:20] = True
    wrong = vectors | {"left_wheel": vectors["left_wheel"] + 1.0}
    new, lost = recovered(wrong, {}, {"left_wheel": bad}, geometry, 100)
    assert new["left_wheel"][bad, 2] == pytest.approx(rates["left_wheel"][bad]) and not lost


@pytest.mark.parametrize("lag", [-120, -7, 0, 1, 33, 250])
def test_a_lag_is_found_to_a_part_of_a_sample(lag):
    rng = np.random.default_rng(3)
    motion = np.convolve(rng.normal(0, 1, 5000), np.hanning(80) / 40, "same")
    noise = rng.normal(0, 0.02, (2, 4000))
    found = lag_between(motion[500:4500] + noise[0], motion[500 - lag : 4500 - lag] + noise[1], 100)
    assert found.lag_s == pytest.approx(lag / 100, abs=max(4 * found.sd_s, 0.001))
    assert lag_between(motion[:4000], rng.normal(0, 1, 4000), 100) is None
    rounding = 1e-17 * np.arange(4000)
    assert lag_between(0.1 + rounding, rounding, 100) is None


# The study


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_the_study_runs_and_is_told_or_harmless(kind):
    """One case each; the record has a hundred. What matters much is told or refused."""
    row = one_case(kind, 1, SEEN_SEED)
    assert row["found_as"] == "refused" or row["right"] or row["ratio"] < 20
    assert summary_of(kind, [row | {"kind": kind}])["cases"] == 1


def test_a_summary_counts_what_is_told_and_priced():
    """Two matter and are told, one without a cost; a cost of 0 is one, and it is wrong."""
    said = {"kind": "lag", "found_as": "lag", "right": True, "ratio": 5.0, "cost_real": 0.1}
    rows = [
        said | {"cost_stated": 0.15},
        said | {"cost_stated": 0.0},
        said | {"cost_stated": None},
        said | {"cost_stated": 0.1, "right": False, "found_as": "turned"},
        said | {"cost_stated": None, "right": False, "found_as": ""},
        said | {"cost_stated": 0.1, "ratio": 1.0},
        said | {"found_as": "refused", "ratio": float("inf")},
    ]
    assert summary_of("lag", rows) == {
        "kind": "lag", "cases": 7, "refused": 1, "matter": 5, "told": 4, "right": 3, "priced": 2,
        "within_two": 1, "unpriced": 2, "largest_missed": 5.0,
    }  # fmt: skip


def test_an_example_for_a_drawing():
    clean, faulty, before, after, found = example("lag", 2)
    assert len(clean) == len(faulty) and list(before) == list(after)
    assert "lag" in {fault.code for fault in found}


def test_the_record_as_a_table():
    record = numbers("faults_wheelchair")
    table = cases_table(record)
    assert set(table["kind"]) == set(KINDS) and (table.groupby("kind").size() == CASES).all()
    for row in record["kinds"]:
        mine = table[table["kind"] == row["kind"]]
        assert (mine["found_as"] == "refused").sum() == row["refused"]
        # The table's ratios have three digits: one that was 1.999 or 2.001 stands there as 2.
        on_edge = int((mine["ratio"] == 2.0).sum())
        assert abs(int(mine["matters"].sum()) - row["matter"]) <= on_edge
        found = int((mine["matters"] & (mine["found_as"].fillna("") != "")).sum())
        assert abs(found - row["told"]) <= on_edge


def test_hardly_anything_is_told_of_drives_without_a_fault():
    clean = numbers("faults_wheelchair")["clean"]
    without = [clean[name] for name in MODELS]
    drives, alarms = (sum(one[key] for one in without) for key in ("drives", "with_alarm"))
    assert drives == 210 and alarms <= 0.01 * drives
