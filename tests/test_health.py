"""Faults of sensors are found in simulated recordings, and none is found where there is none."""

from functools import cache
from itertools import product

import numpy as np
import pytest

from mobility_imu.faults import half_of
from mobility_imu.health import _alike, examine, stuck_axes
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.levels import LEVELS, MOUNTS
from mobility_imu.simulation.scooter import COURSES, draw_driver, draw_scooter, simulate_ride
from mobility_imu.simulation.walker import CORRIDOR, attach_imu, simulate_walk
from mobility_imu.simulation.wheelchair import COURT, random_mounting, simulate_drive
from mobility_imu.wheelchair import SAMPLE_CHAIR

DEVICES = ("scooter", "wheelchair", "walker")
SEEDS = (1, 2, 3)


@cache
def clean(device, seed):
    if device == "scooter":
        unit, driver = draw_scooter(seed), draw_driver(seed)
        return simulate_ride(COURSES["curves"], seed=seed, unit=unit, driver=driver).recording
    if device == "wheelchair":
        return simulate_drive(COURT, SAMPLE_CHAIR, random_mounting(seed), seed=seed).recording
    level = LEVELS["realistic"]
    motion = simulate_walk(CORRIDOR, seed=seed, imperfections=level.imperfections)
    return attach_imu(motion, MOUNTS["1"], level.sensor, seed=seed, unit_seed=seed).recording


def changed(recording, sensor, *, acc=None, gyr=None):
    imu = recording.sensor(sensor)
    new = Imu(
        imu.acc_mps2 if acc is None else acc(imu.acc_mps2.copy()),
        imu.gyr_radps if gyr is None else gyr(imu.gyr_radps.copy()),
    )
    return Recording(recording.time_s, {**recording.sensors, sensor: new}, source="faulty")


def sensors(device):
    return list(clean(device, 1).sensors)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_found_where_nothing_is_wrong(device, seed):
    assert examine(clean(device, seed)) == ()


CHANGES = {
    "gyroscope freezes": ("frozen", {"gyr": lambda v: hold(v, 0.5)}),
    "accelerometer freezes": ("frozen", {"acc": lambda v: hold(v, 0.5)}),
    "gyroscope is dead": ("frozen", {"gyr": lambda v: 0 * v}),
    "one axis is dead": ("dead axis", {"gyr": lambda v: v * [1, 0, 1]}),
    "a spike": ("spike", {"acc": lambda v: spiked(v, 300.0)}),
    "a spike in a rate": ("spike", {"gyr": lambda v: spiked(v, 34.0)}),
}


STRETCHES = {"from half on": (0.5, None), "for 3 s": (0.5, 300), "for 0.4 s": (0.33, 40)}


def hold_axis(values, axis, part, count):
    begin = int(part * len(values))
    values[begin : None if count is None else begin + count, axis] = values[begin, axis]
    return values


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("stretch", STRETCHES)
def test_an_axis_that_dies_in_between_is_told_for_its_own_samples(device, stretch):
    part, count = STRETCHES[stretch]
    recording = clean(device, 1)
    for sensor in sensors(device):
        for half in ("acc", "gyr"):
            for axis in range(3):
                how = {half: lambda v, axis=axis: hold_axis(v, axis, part, count)}
                (found,) = examine(changed(recording, sensor, **how))
                assert (found.code, found.sensor) == ("dead axis", f"{sensor}_{half}_{'xyz'[axis]}")
                begin = int(part * len(recording))
                assert found.flags[begin : begin + 40].all()
                assert found.samples - (count or len(recording) - begin) in (0, 1)
                assert "which its noise alone would change" in found.sentence


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("place", ["from half on", "at first", "in between"])
def test_an_axis_is_bridged_only_with_readings_on_both_sides(device, place):
    """A line from its last reading on repeats that reading, which is the fault itself."""
    recording = clean(device, 1)
    half_time = len(recording) // 2
    start, stop = {
        "from half on": (half_time, None),
        "at first": (0, half_time),
        "in between": (half_time, half_time + 300),
    }[place]
    for sensor in sensors(device):
        for half in ("acc", "gyr"):

            def held(values):
                values[start:stop, 1] = values[start, 1]
                return values

            (found,) = of_axis(examine(changed(recording, sensor, **{half: held})))
            assert (found.repair is not None) == (place == "in between")


def of_axis(found):
    return [fault for fault in found if fault.code == "dead axis"]


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("step", [0.01, 0.05, 0.2])
def test_an_axis_with_coarse_steps_is_not_stuck(device, step):
    """Whatever its noise is against its steps: at rest it says one number for seconds."""
    for seed in SEEDS:
        recording = clean(device, seed)
        for sensor in sensors(device):
            for half in ("acc", "gyr"):
                values = half_of(recording, sensor, half)
                coarse = step * np.round(values / step)
                none = np.zeros(len(values), np.bool_)
                assert not stuck_axes(coarse, recording.sampling_rate_hz, skip=none).any()


def test_an_axis_without_noise_is_not_stuck():
    """A drive that turns now and then, of a sensor that makes no errors."""
    time_s = np.arange(0, 30, 0.01)
    turn = np.where((time_s % 10) > 5, np.sin(2 * np.pi * time_s / 5), 0.0)
    values = np.column_stack([np.sin(3 * time_s), turn, np.cos(2 * time_s)])
    assert not stuck_axes(values, 100.0, skip=np.zeros(len(values), np.bool_)).any()


def test_signs_are_judged_beside_a_short_repetition():
    """What is frozen for 0.3 s is left out, not all of the recording."""
    recording = clean("wheelchair", 1)

    def change(values):
        values = -values
        values[-30:] = values[-30]
        return values

    found = examine(changed(recording, "left_wheel", gyr=change))
    assert sorted(f.code for f in found) == ["frozen", "reversed"]


def hold(values, part):
    begin = int(part * len(values))
    values[begin:] = values[begin]
    return values


def spiked(values, size):
    values[len(values) // 3, 1] += size
    return values


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("fault", CHANGES)
def test_each_fault_is_found_in_each_sensor(device, fault):
    code, how = CHANGES[fault]
    (half,) = how
    for seed in SEEDS:
        for sensor in sensors(device):
            found = examine(changed(clean(device, seed), sensor, **how))
            assert [f.code for f in found] == [code], (seed, sensor)
            assert found[0].sensor.startswith(f"{sensor}_{half}")
            assert "faulty: " in found[0].sentence


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("device", "sensor"), [("scooter", "lever"), ("wheelchair", "left_wheel")])
def test_a_gyroscope_with_the_wrong_sign_is_told(device, sensor, seed):
    found = examine(changed(clean(device, seed), sensor, gyr=lambda v: -v))
    assert [f.code for f in found] == ["reversed"]
    assert "has the wrong sign, or the accelerometer has" in found[0].sentence


@pytest.mark.parametrize("seed", SEEDS)
def test_signs_are_not_judged_where_pushes_go_with_the_motion(seed):
    """A walking frame is lifted and tilted at once; ``walker.find_faults`` judges by its rests."""
    recording = clean("walker", seed)
    assert examine(changed(recording, "frame", gyr=lambda v: -v)) == ()


@pytest.mark.parametrize("axis", range(3))
def test_one_wrong_sign_is_told_for_the_axis_that_turns_most(axis):
    """A wheel turns about its axle across gravity; its other axes leave no trace to judge."""
    recording = clean("wheelchair", 1)
    rate = np.abs(recording.sensor("left_wheel").gyr_radps).mean(axis=0)
    signs = np.where(np.arange(3) == axis, -1.0, 1.0)
    found = examine(changed(recording, "left_wheel", gyr=lambda v: v * signs))
    assert [f.code for f in found] == (["reversed"] if axis == rate.argmax() else [])


def test_two_sensors_with_the_same_readings_are_one():
    recording = clean("scooter", 1)
    twice = {name: recording.sensor("lever") for name in ("lever", "body")}
    (found,) = examine(Recording(recording.time_s, twice, source="twice"))
    assert found.code == "copy" and "lever and body have the same readings" in found.sentence


def test_a_range_that_is_cut():
    recording = clean("wheelchair", 1)
    fastest = np.abs(recording.sensor("left_wheel").gyr_radps).max()
    cut = changed(recording, "left_wheel", gyr=lambda v: np.clip(v, -fastest / 2, fastest / 2))
    (found,) = examine(cut)
    assert (found.code, found.sensor) == ("range", "left_wheel_gyr")
    assert found.samples > 10 and "choose a wider range" in found.sentence


def test_a_sensor_is_not_judged_by_another_one_whose_name_begins_alike():
    recording = clean("wheelchair", 1)
    wheel = changed(recording, "left_wheel", gyr=lambda v: hold(v, 0.5)).sensor("left_wheel")
    other = changed(recording, "left_wheel", gyr=lambda v: -v).sensor("left_wheel")
    both = Recording(recording.time_s, {"left_wheel": wheel, "left": other}, source="names")
    found = {(f.code, f.sensor) for f in examine(both)} - {("copy", "left_wheel, left")}
    assert found == {("frozen", "left_wheel_gyr"), ("reversed", "left_gyr")}


def test_a_still_sensor_in_coarse_steps_is_healthy():
    rng = np.random.default_rng(5)
    acc = np.round(rng.normal([0, 0, 9.8], 0.02, (3000, 3)) / 0.0981) * 0.0981
    gyr = np.round(rng.normal(0, 0.0003, (3000, 3)) / 0.001) * 0.001
    still = Recording(np.arange(3000) / 100, {"frame": Imu(acc, gyr)}, source="still")
    assert examine(still) == ()


def test_signs_of_parts_correlate_as_their_sums_do():
    """Found from products of the parts, not from eight sums of series."""
    rng = np.random.default_rng(5)
    parts = rng.normal(0.0, [[0.1], [1.0], [3.0]], (3, 400))
    parts[1] += 0.5 * parts[2]
    seen = parts[0] - parts[1] + 0.5 * parts[2] + rng.normal(0.0, 0.2, 400)
    found = _alike(parts, seen)
    assert set(found) == set(product((1.0, -1.0), repeat=3))
    for signs, alike in found.items():
        whole = np.array(signs) @ parts
        size = np.linalg.norm(whole) * np.linalg.norm(seen)
        assert alike == pytest.approx(whole @ seen / size, abs=1e-12)
    assert max(found, key=found.get) == (1.0, -1.0, 1.0)
    assert set(_alike(0 * parts, seen).values()) == {0.0}
