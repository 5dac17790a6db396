"""Records of the walker's real recordings: rules of the comparison, and the numbers again."""

import json
import math

import matplotlib
import numpy as np
import pandas as pd
import pytest

from mobility_imu.data import recorded_folder
from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.plots import walker_real
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker import real_feet, real_record, real_walks, real_walks_study
from mobility_imu.reproduction.walker.real_sensors import (
    kinds_of,
    mean_spectrum,
    sensor_row,
    sensors_summary,
)
from mobility_imu.walker import estimate_trajectory

LABELS = pd.DataFrame({"begin_s": [0.0, 3.0], "end_s": [2.0, 5.0]})
NAMES = ("real_walks", "real_feet")


def test_a_step_belongs_to_one_label_and_the_nearest():
    lift, place = np.array([0.2, 0.6, 3.4, 8.0]), np.array([0.8, 1.4, 4.6, 9.0])
    matched = real_walks.match_labels(lift, place, LABELS)
    assert matched.of_label.tolist() == [1, 2]
    assert matched.others == [0, 3]
    near = real_walks.match_labels(lift + 0.3, place + 0.3, LABELS, near_s=0.25)
    assert near.of_label.tolist() == [0, -1]  # the first step has moved to the first label


@pytest.mark.parametrize(
    ("lift", "place", "kind"),
    [
        (-2.0, -0.5, "before the first label"),
        (1.5, 2.5, "split"),
        (2.1, 2.9, "left out"),
        (6.0, 7.0, "left out"),
    ],
)
def test_steps_without_a_label_are_classed_by_their_times(lift, place, kind):
    assert real_walks.kind_of_other(lift, place, LABELS) == kind


def test_the_turn_that_fits_takes_a_turn_off_and_nothing_else():
    rng = np.random.default_rng(0)
    true = np.cumsum(rng.normal(size=(500, 2)), axis=0)
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    path, turned = real_feet.turned_to_fit(true @ turn.T + [3.0, -2.0], true)
    assert np.abs(path - turned).max() < 1e-9
    path, turned = real_feet.turned_to_fit(1.1 * true, true)  # a wrong scale stays
    assert np.allclose(path, 1.1 * turned)
    path, turned = real_feet.turned_to_fit(true, true[::-1] * 0)  # nobody moved
    assert np.isfinite(turned).all()


def test_sensor_and_spectrum_of_known_noise():
    rate, count = 100.0, 20_000
    rng = np.random.default_rng(1)
    acc = rng.normal([0.0, 0.0, 9.7], 0.02, (count, 3))
    gyr = np.deg2rad(rng.normal([1.0, 0.0, 0.0], 0.1, (count, 3)))
    recording = Recording(np.arange(count) / rate, {"frame": Imu(acc, gyr)})
    row = sensor_row(recording, np.ones(count, bool))
    assert row["rate_hz"] == 100.0 and row["gaps"] == 0
    assert math.isclose(row["acc_noise_mps2"], 0.02, rel_tol=0.02)
    assert math.isclose(row["gyr_noise_degps"], 0.1, rel_tol=0.02)
    assert math.isclose(row["gyr_offset_degps"], 1.0, abs_tol=0.01)
    assert math.isclose(row["gravity_mps2"], 9.7, abs_tol=0.002)
    assert row["on_grid_percent"] < 10  # by chance
    coarse = Recording(recording.time_s, {"frame": Imu(np.round(acc / 0.0980665) * 0.0980665, gyr)})
    assert sensor_row(coarse, np.ones(count, bool))["on_grid_percent"] == 100
    spectrum = mean_spectrum([acc], rate)
    # White noise on three axes: variance over half the rate, all frequencies alike.
    assert np.allclose(spectrum["density"], 0.02 * math.sqrt(3 / (rate / 2)), rtol=0.1)
    low, middle, high = sensors_summary([row, {**row, "gyr_offset_degps": None}])["rate_hz"]
    assert low == middle == high == 100.0


def test_warnings_have_short_names():
    assert kinds_of(["x: the frame went backward: was it", "moves too long for one step: 2"]) == [
        "move too long for one step",
        "went backward",
    ]
    assert kinds_of(["something new"]) == ["something new"]


@pytest.mark.parametrize("name", NAMES)
def test_records_are_small_whole_and_name_no_place(name):
    path = recorded_folder() / f"{name}.json"
    assert path.stat().st_size < 61_000
    text = path.read_text()
    assert "NaN" not in text and "/work" not in text and "/home" not in text
    numbers = json.loads(text)["numbers"]
    assert set(numbers) == {"origin", "files", "rows", "summary"}
    assert all(len(sha) == 64 for sha in numbers["files"].values())


def test_every_step_without_a_label_was_looked_at():
    rows = real_record.real_numbers("real_walks")["rows"]
    seen = [one for row in rows for one in row["seen"]]
    assert len(seen) == sum(row["others"] for row in rows) == len(real_walks.LOOKED_AT)
    assert all(one["seen"] != "not looked at" for one in seen)
    for one in seen:  # the rule and the eye agree
        assert (one["kind"] == "split") == ("part of a labelled step" in one["seen"])


def test_the_page_says_whether_the_recordings_are_here(monkeypatch):
    monkeypatch.setattr(real_record, "find_folder", lambda name: None)
    assert real_record.computed_again("real_walks") == 0
    assert "no, they are not on this machine" in real_record.real_note("real_walks", 0)


def test_other_files_are_not_compared(monkeypatch, tmp_path):
    for name in ("walk_01.csv.gz", "labelled_steps.csv", "mount.toml"):
        (tmp_path / name).write_text("something else")
    monkeypatch.setattr(real_record, "find_folder", lambda name: tmp_path)
    assert real_record.computed_again("real_walks") == 0


def test_without_the_recordings_nothing_is_recorded(monkeypatch):
    for module, study in ((real_walks_study, "real_walks"), (real_feet, "real_feet")):
        monkeypatch.setattr(module, "find_folder", lambda name: None)
        assert getattr(module, study)() is None


@pytest.mark.parametrize("name", NAMES)
def test_numbers_come_out_again(name):
    """One recording in four; the page and ``reproduce --real`` take others."""
    source = real_record.SOURCES[name]
    if find_folder(source.dataset) is None:
        pytest.skip(f"{source.dataset} is not here (fetch)")
    rows = real_record.real_numbers(name)["rows"]
    assert real_record.computed_again(name, 4) == len(rows[::4])


def test_unsteady_hands_are_not_taken_for_exchanged_axes_alone():
    """Walk 01 is sound; the frame is held by hands that move it while it stands."""
    folder = find_folder(real_walks.DATASET)
    if folder is None:
        pytest.skip("labelled-walks is not here (fetch)")
    walk = real_walks.load_walk(folder, "walk_01")
    (said,) = estimate_trajectory(walk.recording, walk.geometry, walk.mount).warnings
    assert "walk_01: the rests are 1.5 times as far" in said and "unsteady hands" in said


def test_a_number_that_differs_is_named(monkeypatch):
    if find_folder(real_walks.DATASET) is None:
        pytest.skip("labelled-walks is not here (fetch)")
    changed = real_record.real_numbers("real_walks")
    changed["rows"][0]["steps"] += 1
    monkeypatch.setattr(real_record, "real_numbers", lambda name: changed)
    with pytest.raises(InputError, match=r"real_walks, walk_01, steps: the recording gives"):
        real_record.computed_again("real_walks", len(changed["rows"]))


def test_figures_draw_what_is_recorded():
    matplotlib.use("Agg")
    walks, feet = (real_record.real_numbers(name) for name in NAMES)
    seen = [one for row in walks["rows"] for one in row["seen"]]
    figures = [
        walker_real.plot_unlabelled(seen[:4]),
        walker_real.plot_unlabelled(seen[:1], 1),
        walker_real.plot_spectra({"real": walks["summary"]["spectra"]}),
        walker_real.plot_count_ranges(walks["summary"]["limits"], walks["summary"]["bursts"]),
        walker_real.plot_feet(feet["rows"]),
        walker_real.plot_error_over_time(feet["summary"]["over_time"]),
        walker_real.plot_coverage(feet["summary"]["edges"], feet["summary"]["bins"]),
    ]
    for figure in figures:
        assert any(ax.lines or ax.patches for ax in figure.axes)
    # The last bars hold all errors beyond the edges.
    bars = [bar.get_height() for bar in figures[-1].axes[0].patches]
    assert math.isclose(sum(bars), 100, rel_tol=1e-9)
