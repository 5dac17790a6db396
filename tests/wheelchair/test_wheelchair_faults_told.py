"""What a fault that is told does to samples, to the check of the geometry, to other sentences."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from faulty import SEED, SENSORS, calibration, drive, largest, look, of_code, series

from mobility_imu.faults import rescaled
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.wheelchair.fault_kinds import clean_drive
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.sensor import MTI_1
from mobility_imu.wheelchair import check_geometry, estimate_velocity, find_faults
from mobility_imu.wheelchair.faults import not_told, sensor_faults, with_valid
from mobility_imu.wheelchair.lags import Lag
from mobility_imu.wheelchair.wheel_faults import late

RANGES = {
    "a wheel's, between those that are sold": ("left_wheel", "gyr", 4.0, False),
    "a wheel's, as sold": ("left_wheel", "gyr", float(np.deg2rad(250)), False),
    "the frame's": ("frame", "gyr", 0.8, False),
    "an accelerometer's": ("left_wheel", "acc", 8.0, True),
}


@pytest.mark.parametrize("name", RANGES)
def test_samples_of_a_cut_gyroscope_are_not_valid(name):
    sensor, half, limit, stays = RANGES[name]
    faulty, cal = inject.clip(drive().trial, sensor, half, limit), calibration()
    (found,) = of_code(look(faulty), "range")
    assert found.sensor == f"{sensor}_{half}" and 10 < found.samples < len(faulty)
    result = estimate_velocity(faulty, drive().court.geometry, cal.mount, offsets=cal.offsets)
    valid = with_valid(result, (found,)).valid
    assert valid[~found.flags].all()
    assert valid.all() if stays else not valid[found.flags].any()


def other_frame(trial):
    """The frame's sensor of another court's drive, cut to the same length."""
    other = clean_drive(SEED + 1, MTI_1, rests=False).trial
    count = min(len(trial), len(other))
    sensors = {
        name: Imu(one.acc_mps2[:count], one.gyr_radps[:count])
        for name, one in {**trial.sensors, "frame": other.sensor("frame")}.items()
    }
    return Recording(trial.time_s[:count], sensors, source=trial.source)


def mirrored(trial):
    for sensor in SENSORS[1:]:
        trial = inject.scale(trial, sensor, "acc", (-1, -1, -1))
    return trial


def paced(trial, pace):
    return Recording(trial.time_s * pace, trial.sensors, source=trial.source)


def with_offset(trial, size_degps):
    up = drive(rests=False).court.mounting["frame"].rotation_body_to_imu[:, 2]
    return inject.offset(trial, "frame", "gyr", np.deg2rad(size_degps) * up)


UNJUDGED = {
    "scale": lambda t: inject.scale(t, "right_wheel", "gyr", 1.05),
    "clock": lambda t: paced(t, 1.1),
    "offset": lambda t: with_offset(t, 20.0),
    "at odds": other_frame,
    "lag": lambda t: inject.late(t, "frame", 0.3),
}


@pytest.mark.parametrize("code", UNJUDGED)
def test_the_geometry_is_not_judged_with_a_fault_that_moves_it(code):
    """Each of these drives would give a track or a camber that is wrong, or none at all."""
    cal, geometry = calibration(rests=False), drive(rests=False).court.geometry
    faulty = UNJUDGED[code](drive(rests=False).trial)
    told = of_code(look(faulty, rests=False), code)
    found = check_geometry(faulty, geometry, cal.mount, offsets=cal.offsets)
    assert told and told[0].sentence in found.warnings
    assert not found.judged and not found.fits and np.isnan(found.track_m)
    assert "no verdict on track, radii and camber" in found.warnings[0]


def test_a_mirrored_drive_has_the_same_track_and_camber():
    """Whichever of the two it is, left turns are like right ones; that it is so is told."""
    cal, geometry = calibration(rests=False), drive(rests=False).court.geometry
    faulty = mirrored(drive(rests=False).trial)
    (told,) = of_code(look(faulty, rests=False), "mirrored")
    found = check_geometry(faulty, geometry, cal.mount, offsets=cal.offsets)
    assert found.judged and told.sentence in found.warnings
    assert abs(found.track_m - geometry.track_m) < 0.01


@pytest.mark.parametrize(
    "wrong",
    [
        {"track_m": 0.75},
        {"track_m": 1.3},
        {"camber_rad": 0.0},
        {"wheel_radius_left_m": 1.06},
        {"wheel_radius_left_m": 1.1, "wheel_radius_right_m": 1.1},
    ],
)
@pytest.mark.parametrize("seed", [41, 42, 45])
def test_a_wrong_geometry_is_judged_although_wheels_and_frame_are_at_odds(seed, wrong):
    """By a quarter of the track, by all of the camber, by one radius or by both."""
    court = clean_drive(seed, MTI_1, rests=False)
    geometry, cal = court.court.geometry, court.calibration()
    given = replace(geometry, **{n: getattr(geometry, n) * times for n, times in wrong.items()})
    found = check_geometry(court.trial, given, cal.mount, offsets=cal.offsets)
    assert found.judged and not found.fits
    assert any("the turns fit a track of" in text for text in found.warnings) or any(
        "right radius over the left" in text for text in found.warnings
    )
    for fault in sensor_faults(court.trial, given, cal.mount, offsets=cal.offsets):
        assert fault.code != "scale" or fault.size < 0.03
        assert fault.code != "at odds" or "are track, radii and camber right" in fault.sentence
        assert fault.code != "at odds" or "record again" not in fault.sentence


SMALL = {
    "none": lambda t: t,
    "scale": lambda t: inject.scale(t, "right_wheel", "gyr", 1.02),
    "offset": lambda t: with_offset(t, 6.0),
}


@pytest.mark.parametrize("name", SMALL)
def test_the_geometry_is_judged_with_a_small_fault(name):
    """An offset of 6 deg/s is fitted with the track: 1 cm of it is a hundredth."""
    cal, geometry = calibration(rests=False), drive(rests=False).court.geometry
    faulty = SMALL[name](drive(rests=False).trial)
    found = check_geometry(faulty, geometry, cal.mount, offsets=cal.offsets)
    assert found.judged and abs(found.track_m - geometry.track_m) < 0.01
    assert abs(found.camber_rad - geometry.camber_rad) < 3 * found.camber_sd_rad


def test_that_wheels_and_frame_disagree_is_a_warning_until_a_fault_explains_it():
    cal, geometry = calibration(rests=False), drive(rests=False).court.geometry
    faulty = other_frame(drive(rests=False).trial)
    found = estimate_velocity(faulty, geometry, cal.mount, offsets=cal.offsets)
    (sentence,) = [s for s in found.warnings if "wheels and frame disagree" in s]
    assert "record again" in sentence
    assert sentence in not_told(found, faulty, geometry, cal.mount, ())
    told = find_faults(faulty, geometry, cal.mount, offsets=cal.offsets)
    assert sentence not in not_told(found, faulty, geometry, cal.mount, told)


def test_samples_at_the_end_of_a_range_are_not_told_as_frozen_too():
    for sensor, limit in (("left_wheel", 4.0), ("left_wheel", np.deg2rad(250)), ("frame", 0.8)):
        found = look(inject.clip(drive().trial, sensor, "gyr", limit))
        assert [f.code for f in found if f.sensor.startswith(sensor)] == ["range"]


@pytest.mark.parametrize("start_s", [0.0, 30.0])
def test_what_gyroscopes_cost_that_never_read_again_is_not_known(start_s):
    """Nothing comes after the loss, or nothing before it: a line between neighbours repeats it."""
    trial = drive().trial
    length_s = 10.0 if start_s == 0 else float(trial.time_s[-1]) - start_s + 1
    for sensor in ("left_wheel", "right_wheel"):
        trial = inject.freeze(trial, sensor, "gyr", start_s, length_s)
    frozen = of_code(look(trial), "frozen")
    assert {fault.sensor for fault in frozen} >= {"left_wheel_gyr", "right_wheel_gyr"}
    assert all(fault.costs == () for fault in frozen)


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_frozen_gyroscope_is_told_once_with_what_replaces_it(sensor):
    cal, geometry = calibration(), drive().court.geometry
    faulty = inject.freeze(drive().trial, sensor, "gyr", 12.0, 10.0)
    told = look(faulty)
    (frozen,) = of_code(told, "frozen")
    others = " and ".join(name for name in SENSORS if name != sensor)
    assert f"{others} replace it there" in frozen.sentence
    assert "record again" not in frozen.sentence
    assert frozen.costs == ()  # by the estimate itself, which replaces it, no cost can be found
    found = estimate_velocity(faulty, geometry, cal.mount, offsets=cal.offsets)
    assert any("replace it there" in s for s in found.warnings)
    left = not_told(found, faulty, geometry, cal.mount, told)
    assert not any("replace it there" in s for s in left)
    # Of an accelerometer alone, the gyroscope's warning stays.
    other = inject.freeze(drive().trial, sensor, "acc", 12.0, 10.0)
    only_acc = of_code(look(other), "frozen")
    assert any("replace it" in s for s in not_told(found, faulty, geometry, cal.mount, only_acc))


def test_a_frozen_gyroscope_that_nothing_replaces_is_to_be_left_out():
    faulty = drive().trial
    for sensor in ("frame", "left_wheel"):
        faulty = inject.freeze(faulty, sensor, "gyr", 20.0, 5.0)
    for fault in of_code(look(faulty), "frozen"):
        assert "leave these times out, or record again" in fault.sentence
        assert "replace it there" not in fault.sentence
    part = inject.freeze(inject.freeze(drive().trial, "frame", "gyr", 12.0, 10.0),
                         "left_wheel", "gyr", 20.0, 5.0)  # fmt: skip
    for fault in of_code(look(part), "frozen"):
        assert "replace it there" in fault.sentence and "another one fails" in fault.sentence


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_whole_sensor_that_freezes_is_one_line(sensor):
    faulty = drive().trial
    for half in ("acc", "gyr"):
        faulty = inject.freeze(faulty, sensor, half, 12.0, 10.0)
    found = look(faulty)
    assert [(fault.code, fault.sensor) for fault in found] == [("frozen", sensor)]
    assert f"{sensor} in " in found[0].sentence and "replace it there" in found[0].sentence
    pickle.loads(pickle.dumps(found))


@pytest.mark.parametrize("rate_hz", [0.1, 1.0, 9.0])
def test_a_slow_clock_is_told_alone(rate_hz):
    """At such a rate a steady drive repeats itself; what the times say comes first."""
    trial = drive().trial
    slow = Recording(np.arange(len(trial)) / rate_hz, trial.sensors, source="slow")
    sensors = dict(trial.sensors)
    for name in SENSORS:
        sensors[name] = Imu(sensors[name].acc_mps2, np.round(sensors[name].gyr_radps, 1))
    for one in (slow, Recording(slow.time_s, sensors, source="coarse")):
        (found,) = look(one)
        assert found.code == "clock" and "--sampling-rate-hz" in found.sentence
    sensors["left_wheel"] = sensors["right_wheel"]
    assert [f.code for f in look(Recording(slow.time_s, sensors))] == ["copy", "clock"]


class Lags:
    """Sensors that know lags only; halves that do not go together show no drift."""

    def __init__(self, lags, recording):
        self.found, self.recording, self.rate_hz = lags, recording, recording.sampling_rate_hz

    def lags(self):
        return self.found

    def lag(self, first, second, *, half):
        return None


@pytest.mark.parametrize("lags", [
    {("frame", "right_wheel"): 0.0, ("left_wheel", "right_wheel"): 0.3},
    {("left_wheel", "right_wheel"): 0.3, ("frame", "right_wheel"): 0.0},
    {("frame", "left_wheel"): -0.3, ("left_wheel", "right_wheel"): 0.3},
    {("frame", "left_wheel"): -0.3, ("frame", "right_wheel"): 0.0},
])  # fmt: skip
def test_a_lag_is_found_over_whichever_sensor_two_others_share(lags):
    pairs = {pair: Lag(lag_s, 0.002, 0.99) for pair, lag_s in lags.items()}
    (found,) = late(Lags(pairs, drive().trial))
    assert found.sensor == "left_wheel" and found.size == pytest.approx(0.3, abs=1e-9)
    assert "comes early by 0.300" in found.sentence


def test_what_a_look_cannot_do_is_no_fault_and_no_error():
    """Sensors that are missing in the recording or in the mount, and dead axes of the rest."""
    cal, geometry = calibration(), drive().court.geometry
    for names in (SENSORS[1:], SENSORS[:2], SENSORS[:1], SENSORS[2:], SENSORS):
        for dead in names:
            trial = inject.scale(drive().trial, dead, "gyr", [1, 0, 1])
            part = Recording(trial.time_s, {name: trial.sensors[name] for name in names})
            (found,) = of_code(sensor_faults(part, geometry, cal.mount), "dead axis")
            frame = "frame" in names
            assert (found.repair is not None) == frame
            assert not found.repair or len(found.repair(part)) == len(part)


def silent(imu, half):
    """A sensor one of whose halves reads one thing: nothing, or gravity."""
    if half == "acc":
        return Imu(np.tile([0.0, 0.0, 9.81], (len(imu), 1)), imu.gyr_radps)
    return Imu(imu.acc_mps2, np.zeros_like(imu.acc_mps2))


@pytest.mark.parametrize("half", ["acc", "gyr"])
@pytest.mark.parametrize("names", [SENSORS, *((name,) for name in SENSORS)])
def test_sensors_that_say_nothing_end_no_look(names, half):
    """What is looked for may be there or not; an estimate of the same recording tells more."""
    cal, geometry = calibration(), drive().court.geometry
    sensors = dict(drive().trial.sensors)
    for name in names:
        sensors[name] = silent(sensors[name], half)
    trial = Recording(drive().trial.time_s, sensors, source="silent")
    found = sensor_faults(trial, geometry, cal.mount, offsets=cal.offsets)
    assert [(f.code, f.sensor) for f in found] == [("frozen", f"{name}_{half}") for name in names]
    drives = estimate_velocity(trial, geometry, cal.mount, offsets=cal.offsets)
    assert len(not_told(drives, trial, geometry, cal.mount, found)) <= len(drives.warnings)


@pytest.mark.parametrize("sensor", SENSORS[1:])
def test_exchanged_wheels_of_which_one_fails_are_not_told_as_turned(sensor):
    swapped = inject.exchange(drive().trial, "left_wheel", "right_wheel")
    faulty = inject.freeze(swapped, sensor, "gyr", 5.0, 25.0)
    codes = {fault.code for fault in look(faulty)}
    assert "exchanged" in codes and not codes & {"turned", "reversed", "lag", "scale"}


UNITS = {"gyr": np.rad2deg(1.0), "acc": 9.80665}


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize(("half", "way"), [("gyr", -1), ("acc", 1), ("acc", -1)])
def test_a_part_in_another_unit_is_told_alone_with_its_cost(sensor, half, way):
    trial = drive().trial
    part = np.zeros(len(trial), np.bool_)
    part[1500:1900] = True
    wrong = rescaled(trial, sensor, half, part, UNITS[half] ** way)
    (found,) = look(wrong)
    assert (found.code, found.sensor) == ("unit", f"{sensor}_{half}")
    assert np.count_nonzero(found.flags ^ part) <= 4
    undone = largest(series(wrong), series(trial), "turn")
    stated = {cost.name: cost.largest for cost in found.costs}["turn"]
    assert np.isclose(stated, undone, rtol=0.05, atol=0.5)


def test_the_geometry_is_not_judged_with_a_gyroscope_in_another_unit():
    part = np.arange(len(drive().trial)) > 1500
    wrong = rescaled(drive().trial, "frame", "gyr", part, 1 / UNITS["gyr"])
    cal = calibration()
    checked = check_geometry(wrong, drive().court.geometry, cal.mount, offsets=cal.offsets)
    assert not checked.judged and any("twice there?" in text for text in checked.warnings)
