"""Records of two hinged chains: what they keep, what is found again, and how errors are split."""

import json

import numpy as np
import pytest

from mobility_imu.data import recorded_folder
from mobility_imu.datasets.folders import RECORDINGS_VARIABLE
from mobility_imu.errors import InputError
from mobility_imu.plots import scooter_real as plots
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.scooter import real_hinges_page as page
from mobility_imu.reproduction.scooter.real_hinges import ChainRecording
from mobility_imu.reproduction.scooter.real_hinges_record import error_causes, fit_to_encoder
from mobility_imu.scooter import ScooterGeometry

RECORDS = ("real_two_hinges", "real_one_hinge")
ANGLES = ("steering", "throttle")
GRAVITY = 9.80665


def chain(true_rad, rate_hz=100.0, lever=None):
    n = len(true_rad)
    time = np.arange(n) / rate_hz
    still = Imu(np.tile([0.0, 0.0, GRAVITY], (n, 1)), np.zeros((n, 3)))
    ride = Recording(time, {"lever": lever or still, "body": still})
    return ChainRecording(ride, true_rad, ScooterGeometry.from_degrees(20, 0), None)


def sweeps(n=2000, rate_hz=100.0):
    time = np.arange(n) / rate_hz
    return time, np.deg2rad(-90 + 90 * np.cos(2 * np.pi * 0.2 * time))


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_is_small_enough_to_read(name):
    assert (recorded_folder() / f"{name}.json").stat().st_size <= 60_000
    assert "/work" not in json.dumps(page.hinge_numbers(name))


@pytest.mark.parametrize("name", RECORDS)
def test_the_thinned_errors_are_those_of_the_rows(name):
    """The root mean square of the part that is drawn is that of all, but for a third."""
    numbers = page.hinge_numbers(name)
    for recording, series in numbers["series"].items():
        row = next(r for r in numbers["rows"] if r["recording"] == recording)
        assert row["method"] == "fusion"
        for angle in ANGLES:
            error = np.array(series[angle]["error_deg"], float)
            drawn = np.sqrt(np.nanmean(error**2))
            assert drawn == pytest.approx(row[angle]["rms_deg"], rel=1 / 3)


def test_numbers_of_both_chains_are_found_by_recording_and_name():
    assert list(page.of_all("series")) == [
        recording for name in RECORDS for recording in page.hinge_numbers(name)["series"]
    ]
    closed = page.row_of("pitch_slow", "closed-form")
    assert closed in page.hinge_numbers("real_one_hinge")["rows"]
    white = page.variant_of("trial1_foam", "white noise only")
    assert white in page.hinge_numbers("real_two_hinges")["variants"]["trial1_foam"]


def test_numbers_that_are_not_recorded_are_refused():
    with pytest.raises(InputError, match="kind"):
        page.of_all("weather")
    with pytest.raises(InputError, match="no such row"):
        page.row_of("pitch_slow", "guess")
    with pytest.raises(InputError, match="no such variant"):
        page.variant_of("pitch_slow", "guess")


@pytest.mark.parametrize("name", RECORDS)
def test_the_first_variant_is_the_row(name):
    numbers = page.hinge_numbers(name)
    for recording, variants in numbers["variants"].items():
        row = next(r for r in numbers["rows"] if r["recording"] == recording)
        for angle in ANGLES:
            for key, value in variants[0][angle].items():
                assert value == row[angle][key]


def test_a_constant_and_a_delay_are_told_apart():
    _, throttle = sweeps()
    one = chain(np.column_stack([np.zeros_like(throttle), throttle]))
    rate = np.gradient(throttle, 0.01)
    found = error_causes(one, np.column_stack([np.full_like(throttle, 0.02), 0.03 + 0.012 * rate]))
    assert found["steering"]["constant"] == 1 and found["steering"]["delay_ms"] is None
    assert found["throttle"]["delay_ms"] == 12.0 and found["throttle"]["explained"] == 1
    assert 0 < found["throttle"]["constant"] < 1
    assert found["throttle"]["rate_degps"] == pytest.approx(np.rad2deg(rate.std()), abs=0.1)


def test_the_encoder_shows_offsets_and_scales():
    time, throttle = sweeps()
    acc = GRAVITY * np.column_stack([0 * time, np.sin(throttle), np.cos(throttle)])
    acc[:, 1] = 1.02 * acc[:, 1] + 0.02 * GRAVITY
    spin = -0.99 * np.gradient(throttle, time) + np.deg2rad(0.5)
    gyr = np.column_stack([spin, 0 * time, 0 * time])
    one = chain(np.column_stack([0 * time, throttle]), lever=Imu(acc, gyr))
    found = fit_to_encoder(one)
    assert found["offset_mg"] == pytest.approx([20, 0], abs=0.1)
    assert found["scale_percent"] == pytest.approx([2, 0], abs=0.05)
    assert found["leaving_mg"] == [0, 0]
    assert found["gyr_offset_degps"] == 0.5 and found["gyr_scale_percent"] == -1


def test_without_the_recordings_nothing_is_computed_again(monkeypatch, tmp_path):
    monkeypatch.setenv(RECORDINGS_VARIABLE, str(tmp_path))
    (tmp_path / "two_hinges").mkdir()
    assert page.hinges_again("real_two_hinges") == 0
    note = page.hinge_note("real_two_hinges", 0)
    assert "not here" in note and len(note.splitlines()) == 3
    assert len(page.hinge_note("real_one_hinge").splitlines()) == 2


def test_another_number_of_the_same_file_is_an_error(monkeypatch):
    numbers = page.hinge_numbers("real_two_hinges")
    row = numbers["rows"][0]
    monkeypatch.setattr(page, "hinge_numbers", lambda name: numbers)
    monkeypatch.setattr(page, "find_folder", lambda name: recorded_folder())
    monkeypatch.setattr(page, "_same_files", lambda folder, files: True)
    monkeypatch.setattr(page, "read_chain", lambda *a: None)
    other = json.loads(json.dumps(row))
    other["throttle"]["rms_deg"] *= 1.1
    monkeypatch.setattr(page, "errors_of", lambda *a: {"throttle": other["throttle"]})
    with pytest.raises(InputError, match=r"trial1_rigid, fusion, throttle.rms_deg.*renew"):
        page.hinges_again("real_two_hinges")


def test_figures_show_what_is_recorded():
    import matplotlib.pyplot as plt

    two, one = (page.hinge_numbers(name) for name in RECORDS)
    assert len(plots.draw_chains().axes) == 3
    figure = plots.plot_chain_errors(two["series"])
    drawn = figure.axes[2].lines[0].get_ydata()
    recorded = np.array(two["series"]["trial1_rigid"]["steering"]["error_deg"], float)
    assert np.array_equal(drawn, recorded, equal_nan=True)
    labels = [line.get_label() for line in plots.plot_constant_errors(one["series"]).axes[1].lines]
    assert labels[0] == "pitch_slow, steering" and len(labels) == 5
    plt.close("all")


def test_recordings_held_back_have_both_angles_and_none_is_in_a_record():
    pairs = {(row.recording, row.angle) for row in page.HELD_BACK}
    held = {recording for recording, _ in pairs}
    assert len(pairs) == len(page.HELD_BACK) == 2 * len(held)
    assert not held & {name for record in RECORDS for name in page.hinge_numbers(record)["series"]}
