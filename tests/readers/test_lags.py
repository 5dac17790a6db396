"""Lag and drift of clocks, from the movement that sensors share: known ones are found again."""

import os
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.readers.lags import ClockLag, find_lags
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.streams import Stream
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.bundle import REAL
from mobility_imu.simulation.scooter import COURSES, draw_driver, draw_scooter, simulate_ride
from mobility_imu.simulation.wheelchair import (
    COURT,
    random_mounting,
    simulate_court,
    simulate_drive,
)
from mobility_imu.wheelchair import SAMPLE_CHAIR

FOLDER = Path(os.environ.get("MOBILITY_IMU_RECORDINGS", "/nowhere"))
ONE_CLOCK = replace(REAL, clock_rate_sd=0.0, delivery=replace(REAL.delivery, late_s=0.0))
"""Real sensors, but on one clock and without delay: the lags that are put in are the only ones."""


def apart(recording, seed):
    """Each sensor sampled at instants of its own, with stamps of its own clock; the true lags."""
    rng = np.random.default_rng(seed)
    time_s, streams, true = recording.time_s, {}, {}
    for k, (name, imu) in enumerate(recording.sensors.items()):
        lag = ClockLag(
            rng.uniform(-200, 200) if k else 0.0, 0, rng.normal(0, 5e-5) if k else 0.0, 0,
            float(time_s.mean()),
        )  # fmt: skip
        begin, end = time_s[0] + rng.uniform(0, 1.5), time_s[-1] - rng.uniform(0, 1.5)
        own = np.arange(begin, end, 0.01 * (1 + rng.normal(0, 1e-3)))
        values = CubicSpline(time_s, np.hstack([imu.acc_mps2, imu.gyr_radps]))(own)
        stamps = np.round(lag.stamps(own), 4)
        streams[name] = Stream(stamps, values[:, :3], values[:, 3:], source=name, label=name)
        true[name] = lag
    return streams, true


def found_in(streams):
    lags = find_lags(streams, [[name] for name in streams], "made")
    return dict(zip(streams, lags, strict=True))


def court(seed, legs=COURT, sensors=None):
    found = simulate_court(
        legs, SAMPLE_CHAIR, random_mounting(seed), seed=seed, unit_seed=seed, model=ONE_CLOCK
    ).recording
    names = sensors or list(found.sensors)
    return Recording(found.time_s, {name: found.sensor(name) for name in names}, source="court")


def drive(seed):
    return simulate_drive(COURT, SAMPLE_CHAIR, random_mounting(seed), seed=seed).recording


def ride(seed):
    return simulate_ride(
        COURSES["curves"], seed=seed, unit=draw_scooter(seed), driver=draw_driver(seed),
        sensor=ONE_CLOCK,
    ).recording  # fmt: skip


def errors(recording, seed):
    """Error and stated standard deviation of each lag, and of each drift."""
    streams, true = apart(recording, seed)
    lags, drifts = [], []
    for name, lag in list(found_in(streams).items())[1:]:
        at = np.array(lag.at_s)
        lags.append((lag.lag_s - float(true[name].stamps(at) - at), lag.lag_sd_s))
        drifts.append((lag.drift - true[name].drift, lag.drift_sd))
    return lags, drifts


def spread(pairs):
    error, sd = np.array(pairs).T
    return float(np.sqrt(np.mean((error / sd) ** 2)))


@pytest.mark.parametrize(("make", "largest_s", "refused"), [(drive, 2e-3, 0), (ride, 4e-3, 2)])
def test_the_stated_deviation_is_the_errors_to_a_factor_of_two(make, largest_s, refused):
    """A scooter's body turns after its lever, so one in some rides is refused."""
    lags = []
    for seed in range(100, 108):
        try:
            lags += errors(make(seed), seed)[0]
        except InputError:
            refused -= 1
    assert refused >= 0
    assert np.abs(np.array(lags)[:, 0]).max() < largest_s
    assert 0.5 < spread(lags) < 2


def test_below_half_a_millisecond_the_stated_deviation_is_cautious():
    """What real sensors add cancels over a whole drive, but not in the parts of the jackknife."""
    lags = np.array([pair for seed in range(100, 103) for pair in errors(court(seed), seed)[0]])
    assert np.abs(lags[:, 0]).max() < 0.5e-3
    assert lags[:, 1].max() < 1e-3
    assert spread(lags) < 2


def test_drifts_of_recordings_over_a_minute():
    found = [errors(court(seed, (*COURT, *COURT)), seed) for seed in range(100, 102)]
    lags, drifts = ([pair for each in found for pair in each[k]] for k in (0, 1))
    assert np.abs(np.array(drifts)[:, 0]).max() < 20e-6
    assert np.array(drifts)[:, 1].max() < 40e-6
    assert 0.3 < spread(drifts) < 2.2 and 0.3 < spread(lags) < 2.2


def test_a_clock_is_a_line():
    lag = ClockLag(2.0, 0.001, 1e-4, 1e-5, 100.0)
    time_s = np.linspace(0, 300, 7)
    np.testing.assert_allclose(lag.times(lag.stamps(time_s)), time_s, atol=1e-12)
    np.testing.assert_allclose(lag.stamps(np.array([100.0, 200.0])), [102.0, 202.01])


# What is refused


def refused(streams, says):
    with pytest.raises(InputError, match=says):
        found_in(streams)


@pytest.mark.parametrize("seed", range(100, 104))
def test_sensors_of_two_drives_do_not_fit(seed):
    """Two drives on one course, so that both do much the same at the same times."""
    for make in (court, ride):
        one, other = make(seed), make(seed + 50)
        first, second = list(one.sensors)[:2]
        streams = apart(one, seed)[0] | {second: apart(other, seed)[0][second]}
        refused({name: streams[name] for name in (first, second)}, "movement does not show clearly")


def test_movement_that_repeats_or_rests_is_not_clear():
    time_s = np.arange(0, 40, 0.01)
    rng = np.random.default_rng(1)
    for size in (0.0, 1.0):
        wave = size * np.sin(2 * np.pi * time_s)[:, None] * [1.0, 0.5, 0.2]
        streams = {
            name: Stream(
                time_s, [0, 0, 9.8] + 0 * wave, wave + rng.normal(0, 0.1, wave.shape), source=name
            )
            for name in ("lever", "body")
        }
        refused(streams, "movement does not show clearly .* add clock=same")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t, v: (t[:500], v[:500]), r"recording of 4\.99 s, expected 10 to 28800 s"),
        (lambda t, v: (1e6 * t, v), "expected 10 to 28800 s"),
        (lambda t, v: (np.r_[t[:1000], 5000 + t[1000:]], v), "most of its time has no sample"),
        (lambda t, v: (2 * np.floor(t), v), "most of its time|sampling rate of 0.5 Hz"),
    ],
)
def test_clocks_that_are_none(change, says):
    streams = apart(ride(1), 1)[0]
    body = streams["body"]
    time_s, rows = change(body.time_s, np.arange(len(body)))
    streams["body"] = Stream(time_s, body.acc_mps2[rows], body.gyr_radps[rows], source="body")
    refused(streams, says)


def test_no_more_clocks_than_can_be_tried():
    stream = apart(ride(1), 1)[0]["body"]
    refused({f"s{k}": stream for k in range(6)}, "6 clocks, expected at most 5")


def test_what_is_no_number_is_named():
    time_s = np.arange(0, 20, 0.01)
    rows = np.tile([0.0, 0.0, 9.8], (len(time_s), 1))
    rows[7, 1] = np.nan
    streams = {name: Stream(time_s, rows, rows, source=name, counted=True) for name in ("a", "b")}
    refused(streams, "made, a: not a finite number at row 8")


# Files


def write_apart(recording, folder, seed=5):
    streams, true = apart(recording, seed)
    files = {}
    for name, stream in streams.items():
        one = Recording(stream.time_s, {name: Imu(stream.acc_mps2, stream.gyr_radps)}, source=name)
        files[name] = folder / f"{name}.csv"
        one.to_frame().to_csv(files[name], index=False)
    return files, true


def test_files_of_a_chair_come_on_one_clock(tmp_path):
    recording = read_recording(recordings_folder() / "wheelchair_court" / "court.csv.gz")
    files, true = write_apart(recording, tmp_path)
    found = understand([f"{name}={path}" for name, path in files.items()])
    assert found.lags.keys() == {"left_wheel", "right_wheel"}
    for name, lag in found.lags.items():
        at = np.array(lag.at_s)
        assert lag.lag_s == pytest.approx(float(true[name].stamps(at) - at), abs=0.002)
    (said,) = [w for w in found.warnings if "joined by their movement" in w]
    assert "left_wheel lags by " in said and " ± 0.000" in said
    begin = max(
        float(true[n].times(np.loadtxt(f, delimiter=",", skiprows=1, max_rows=1, usecols=0)))
        for n, f in files.items()
    )
    for name in files:
        here = np.interp(
            found.recording.time_s + begin, recording.time_s, recording.gyroscope(name)[:, 1]
        )
        there = found.recording.gyroscope(name)[:, 1]
        assert np.sqrt(np.mean((here - there) ** 2)) < 0.05 * np.std(here) + 0.01


def test_what_the_files_call_their_sensors_serves(tmp_path):
    recording = read_recording(recordings_folder() / "wheelchair_court" / "court.csv.gz")
    files, _ = write_apart(recording.trim(8, 28), tmp_path)
    found = understand(list(files.values()))
    assert set(found.recording.sensors) == set(files)


def test_a_session_on_one_clock_can_be_joined_by_its_movement():
    path = recordings_folder() / "wheelchair_court" / "court.csv.gz"
    assert understand(path).lags == {}
    for name in ([path, "clock=own"], f"{path},clock=own"):
        lags = understand(name).lags
        assert lags.keys() == {"left_wheel", "right_wheel"}
        assert all(abs(lag.lag_s) < 1e-3 for lag in lags.values())


# Real recordings, cut apart


real = pytest.mark.skipif(
    not (FOLDER / "truth").is_dir(), reason="recordings are not where MOBILITY_IMU_RECORDINGS is"
)
DRIVES = ["drives/asphalt_donut", "drives/grass_donut", "drives/sidewalk_donut"]
CHAIRS = [f"truth/chair_mocap/{name}" for name in ("P03_slalom_hs", "P03_uturn_ls")]


def on_own_clocks(recording, lags, drift=0.0):
    middle = recording.time_s.mean()
    streams = {}
    for k, (name, imu) in enumerate(recording.sensors.items()):
        stamps = recording.time_s + lags[k] + (drift * (recording.time_s - middle) if k else 0.0)
        kept = slice(40 * k, len(stamps) - 25 * k)  # they do not start together
        streams[name] = Stream(
            stamps[kept], imu.acc_mps2[kept], imu.gyr_radps[kept], source=name, label=name
        )
    return streams


@real
@pytest.mark.parametrize("name", [*DRIVES, *CHAIRS])
def test_a_real_drive_that_is_cut_apart_comes_together(name):
    """Their own stamps may differ: what is put in must be found beside what was there before."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        recording = read_recording(FOLDER / f"{name}.csv.gz")
    before = found_in(on_own_clocks(recording, (0.0, 0.0, 0.0)))
    after = found_in(on_own_clocks(recording, (0.0, -7.3, 132.71), drift=4e-5))
    for k, sensor in enumerate(list(recording.sensors)[1:]):
        put_in = (-7.3, 132.71)[k]
        moved = after[sensor].lag_s - before[sensor].lag_s - put_in
        assert abs(moved) < 2 * np.hypot(after[sensor].lag_sd_s, before[sensor].lag_sd_s) + 1e-3
        assert abs(before[sensor].lag_s) < 0.03


@real
def test_a_session_whose_clocks_were_not_in_step():
    """Three modules of one session: in step, the frame's turns fit the wheels' far better."""
    path = FOLDER / "drives/grass_straight.csv.gz"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        before, after = read_recording(path), understand([path, "clock=own"])
    assert after.lags["left_wheel"].lag_s == pytest.approx(0.112, abs=0.005)
    assert after.lags["right_wheel"].lag_s == pytest.approx(0.021, abs=0.005)
    unexplained = []
    for recording in (before, after.recording):
        frame, *wheels = (
            savgol_filter(recording.gyroscope(name), 51, 3, axis=0)
            for name in ("frame", "left_wheel", "right_wheel")
        )
        known = np.hstack([*wheels, np.ones((len(frame), 1))])
        yaw = frame[:, np.argmax(frame.var(axis=0))]
        left_over = yaw - known @ np.linalg.lstsq(known, yaw, rcond=None)[0]
        unexplained.append(left_over.var() / yaw.var())
    assert unexplained[1] < 0.5 * unexplained[0]


@real
def test_a_car_whose_clocks_differ_by_two_minutes():
    """Its body turns some hundredths of a second after its wheels: no deviation contains that."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        recording = read_recording(FOLDER / "truth/car_gnss/trial08.csv.gz")
    lag = found_in(on_own_clocks(recording, (0.0, 0.0, 132.71)))["right_wheel"]
    assert abs(lag.lag_s - 132.71) < 0.04
    assert lag.lag_sd_s < 0.02 and lag.drift == 0


@real
def test_a_straight_drive_and_a_fixed_base_are_not_joined():
    names = ("drives/asphalt_straight", "truth/one_hinge/pitch_medium")
    for name in names:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            recording = read_recording(FOLDER / f"{name}.csv.gz")
        refused(on_own_clocks(recording, (0.0, 3.0, 132.71)), "movement does not show clearly")
