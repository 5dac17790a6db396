"""Records of the chair on others' recordings: their form, and whether they come out again here."""

import copy
import re

import numpy as np
import pytest

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.plots.wheelchair_real import (
    draw_rocking,
    plot_errors_over_time,
    plot_ratios,
    plot_spectra,
    plot_tracks,
    plot_trials,
    plot_wheels_and_frame,
)
from mobility_imu.reproduction import recorded
from mobility_imu.reproduction.wheelchair import recorded_real
from mobility_imu.reproduction.wheelchair.real_common import (
    RATIO_EDGES,
    Against,
    in_degrees,
    ratio_fractions,
    rounded,
    spectrum,
    spread,
)
from mobility_imu.reproduction.wheelchair.real_drives import BY_HAND, load_ridden
from mobility_imu.reproduction.wheelchair.recorded_real import (
    REAL_RECORDS,
    real_note,
    real_numbers,
)
from mobility_imu.wheelchair.faults import sensor_faults

LARGEST_BYTES = 60_000


def here(name):
    return find_folder(REAL_RECORDS[name][0]) is not None


@pytest.mark.parametrize("name", REAL_RECORDS)
def test_a_record_has_origin_command_files_rows_and_summary(name):
    numbers = recorded.numbers(name)
    assert re.search(r"github.com/\S+ at [0-9a-f]{40}; licence: none stated", numbers["origin"])
    assert numbers["command"].endswith(f"recorded {name}")
    assert all(re.fullmatch(r"[0-9a-f]{64}", sha) for sha in numbers["files"].values())
    key = REAL_RECORDS[name][2]
    assert len({row[key] for row in numbers["rows"]}) == numbers["summary"]["recordings"]
    path = recorded.recorded_folder() / f"{name}.json"
    assert path.stat().st_size < LARGEST_BYTES
    assert not re.search(r"/(?:home|root|tmp|work|mnt)/\w", path.read_text())


@pytest.mark.skipif(not here("real_drives"), reason="the drives are not here")
def test_in_five_of_six_drives_the_wheels_gravity_speaks_against_their_names():
    """As the note of ``mobility-imu fetch terrain-chair`` says."""
    mirrored = []
    for name in BY_HAND:
        drive = load_ridden(find_folder(REAL_RECORDS["real_drives"][0]), name)
        found = sensor_faults(
            drive.recording, drive.chair, drive.calibration.mount, offsets=drive.calibration.offsets
        )
        mirrored.append(any(fault.code == "mirrored" for fault in found))
    assert len(mirrored) == 6 and sum(mirrored) == 5


@pytest.mark.parametrize("name", REAL_RECORDS)
def test_a_record_is_read_without_the_recordings(name, monkeypatch):
    monkeypatch.setattr(recorded_real, "find_folder", lambda _: None)
    assert real_numbers(name)["rows"]
    assert "here: no" in real_note(name)


@pytest.fixture(scope="module")
def computed():
    """Studies whose recordings are here compute their numbers once."""
    with pytest.MonkeyPatch.context() as patch:
        for name, (dataset, compute, key) in REAL_RECORDS.items():
            patch.setitem(REAL_RECORDS, name, (dataset, once(compute), key))
        yield


def once(compute):
    kept = {}

    def found(folder, names):
        at = (folder, tuple(names))
        if at not in kept:
            kept[at] = compute(folder, names)
        return copy.deepcopy(kept[at])

    return found


@pytest.mark.usefixtures("computed")
@pytest.mark.parametrize("name", REAL_RECORDS)
def test_the_recordings_give_the_recorded_numbers(name):
    if not here(name):
        pytest.skip(f"{name}: its recordings are not here")
    assert real_numbers(name)["rows"]
    assert "here: yes" in real_note(name)


def test_another_number_is_noticed(computed, monkeypatch):
    name = "real_car"
    if not here(name):
        pytest.skip(f"{name}: its recordings are not here")
    dataset, compute, key = REAL_RECORDS[name]

    def other(folder, names):
        found = compute(folder, names)
        found["rows"][0]["way_m"] *= 1.05
        return found

    monkeypatch.setitem(REAL_RECORDS, name, (dataset, other, key))
    with pytest.raises(InputError, match=r"real_car, rows\[0\]\.way_m: the recordings give"):
        real_numbers(name)


def test_what_must_hold_is_in_the_records():
    """Limits that were fixed beforehand; a record that is renewed has to meet them again."""
    chairs = recorded.numbers("real_chair_mocap")
    for row in chairs["rows"]:
        assert row["speed"]["rms"] <= 0.06
        assert abs(row["path_ratio"] - 1) <= 0.015
        assert 0.5 <= row["speed"]["sd_over_rms"] <= 2
    assert 0.85 <= chairs["summary"]["speed_inside"] <= 0.99
    for row in recorded.numbers("real_car")["rows"]:
        assert row["speed"]["rms"] <= 0.15
    for row in recorded.numbers("real_drives")["rows"]:
        assert abs(row["distance_m"] / row["distance_by_hand_m"] - 1) <= 0.02
        turn = row["turn_by_hand_deg"]
        assert abs(row["turn_deg"] - turn) <= 0.01 * abs(turn) + 4
        for one in row["tracks_by_calibration"].values():
            off = abs(one["track_m"] - row["track_by_hand_m"])
            assert off <= 0.012 and off < 1.96 * one["track_sd_m"]


def test_white_noise_has_its_density():
    rng = np.random.default_rng(1)
    found = spectrum(0.01 * rng.standard_normal(20_000), 100.0)
    # 0.01 per sample at 100 Hz: 0.01 / sqrt(50) per root hertz, one-sided.
    assert np.median(found["density"]) == pytest.approx(0.01 / np.sqrt(50), rel=0.05)
    assert spectrum(np.ones(50), 100.0) == {"hz": [], "density": []}
    flags = np.zeros(20_000, bool)
    flags[:250] = True
    assert spectrum(rng.standard_normal(20_000), 100.0, flags)["hz"]


def test_errors_against_a_reference_add_up():
    time_s = np.arange(4.0)
    one = Against(
        time_s, np.array([1.0, 2, 3, 4]), np.array([1.0, 2, 3, 2]), np.ones(4), np.ones(4)
    )
    found = one.summary()
    assert found["rms"] == pytest.approx(1.0) and found["inside"] == 0.75
    assert one.path_ratio == pytest.approx(10 / 8)
    assert in_degrees(one).summary()["rms"] == pytest.approx(np.rad2deg(1.0))
    assert sum(ratio_fractions([-9.0, 0.1, 9.0])) == pytest.approx(1)
    assert ratio_fractions([9.0])[-1] == 1
    assert rounded({"a": [np.float64(np.nan), 1.2345678, np.int64(3), True]}) == {
        "a": [None, 1.2346, 3, True]
    }
    assert spread([3.0, 1.0, 2.0]) == {"median": 2.0, "least": 1.0, "most": 3.0}


def test_every_figure_is_drawn_from_the_records():
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    chairs, drives = (recorded.numbers(n) for n in ("real_chair_mocap", "real_drives"))
    car = recorded.numbers("real_car")
    summary = chairs["summary"]
    series = list(chairs["series"].values())
    figures = [
        draw_rocking(),
        plot_errors_over_time(series),
        plot_errors_over_time(car["series"], rocking=False),
        plot_ratios({"speed": summary["speed_ratio_fractions"]}, RATIO_EDGES),
        plot_spectra(drives["spectra"], "m/s²", 0.001, "floor"),
        plot_trials(chairs["rows"], summary["simulated"]["speed_rms_mps"]),
        plot_wheels_and_frame(drives["series"]),
        plot_tracks(drives["rows"]),
    ]
    errors = figures[1].axes[len(series)]
    curve = max((line.get_ydata() for line in errors.lines), key=len)
    assert np.nanmax(np.abs(curve)) == pytest.approx(np.abs(series[0]["error_mps"]).max(), abs=0.02)
    # No line crosses a gap of the reference.
    assert np.isnan(curve).sum() > 0
    for figure in figures:
        figure.canvas.draw()
    plt.close("all")
