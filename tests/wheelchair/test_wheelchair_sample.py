"""Wheelchair: our results beside the public tool's, on a bundled series and on its real sample.

The sample may not be passed on: its tests run where MOBILITY_IMU_DATA names its folder. Those that
need the tool's answers to it, which the public sample does not contain, run where they are.
"""

import gzip
import hashlib
import json
import re

import numpy as np
import pandas as pd
import pytest

from mobility_imu.data import SAMPLE_VARIABLE, reference_folder, sample_folder
from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.reproduction import recorded
from mobility_imu.reproduction.wheelchair.choices import frames_changed, label_steps
from mobility_imu.reproduction.wheelchair.recorded_sample import sample_note, sample_numbers
from mobility_imu.reproduction.wheelchair.sample import (
    LABEL_FILES,
    SAMPLE_FILES,
    SHIPPED_VELOCITIES,
    TOOL_VELOCITIES,
    TRIAL_FILES,
    load_sample,
    yaw_gain,
)
from mobility_imu.reproduction.wheelchair.sample_study import PARTS, sample_checksum, study
from mobility_imu.wheelchair import SAMPLE_CHAIR, VelocitySettings, estimate_velocity, task_codes
from mobility_imu.wheelchair.slip import detect_slip
from mobility_imu.wheelchair.velocity import printed_yaw_gain

SAMPLE = sample_folder()
needs_sample = pytest.mark.skipif(
    SAMPLE is None,
    reason=f"{SAMPLE_VARIABLE} is not set: WheelMove-ID's sample recording is not bundled",
)
needs_tool = pytest.mark.skipif(
    SAMPLE is None or not (SAMPLE / TOOL_VELOCITIES).is_file(),
    reason="the public tool's answers to the sample are not here",
)

STRUCTURING = "0 - For Data Structuring"
FRAMES = 12656


@pytest.fixture
def public_sample(tmp_path, monkeypatch):
    """The sample as its repository has it, without the tool's answers that we recorded."""
    folder = tmp_path / "SampleData"
    for name in SAMPLE_FILES:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).symlink_to(SAMPLE / name)
    monkeypatch.setenv(SAMPLE_VARIABLE, str(folder))
    return folder


@pytest.fixture
def no_sample(monkeypatch):
    monkeypatch.delenv(SAMPLE_VARIABLE, raising=False)


# The made-up series: everywhere


def frames_unlike_the_tools(file, edge):
    folder = file.folder(SAMPLE)
    series = read_velocities(folder / file.velocities)
    theirs = pd.read_csv(folder / file.labels)["label"]
    ours = task_codes(
        series.linear_velocity_mps,
        series.yaw_rate_radps,
        series.sampling_rate_hz,
        file.settings,
        edge=edge,
    )
    assert len(ours) == len(theirs)
    return np.count_nonzero(ours != theirs)


@pytest.mark.parametrize("edge", ["tool", "covering"])
@pytest.mark.parametrize("file", [f for f in LABEL_FILES if f.bundled], ids=lambda f: f.labels)
def test_no_frame_of_the_made_up_series_is_labelled_otherwise_than_by_the_tool(file, edge):
    # The series begins at rest, where the two edges say the same.
    assert frames_unlike_the_tools(file, edge) == 0


def test_the_made_up_series_has_all_six_tasks_and_labels_that_can_differ():
    labels = {}
    for file in LABEL_FILES:
        if file.bundled:
            labels[file.labels] = pd.read_csv(reference_folder() / file.labels)["label"]
            assert set(labels[file.labels]) == set(range(1, 7))
    one, other = labels.values()
    assert len(one) == len(other) == 20000
    # A longer segment changes labels, so a wrong segment would be noticed.
    assert (one != other).mean() > 0.01


def test_open_choices_change_as_many_frames_as_another_implementation_found():
    series = read_velocities(reference_folder() / "velocities_six_tasks.csv.gz")
    v, w = series.linear_velocity_mps, series.yaw_rate_radps
    assert (label_steps(v, w, 100) == task_codes(v, w, 100)).all()
    # Counted beforehand with a plain implementation that shares no code with this one.
    assert frames_changed(v, w, 100) == {
        "first frames as in the tool": 0,
        "one offset instead of 25": 1630,
        "yaw rate > 40, as in the document (tool: >=)": 0,
        "radius from °/s": 5483,
        "radius from means, not mean of radii": 619,
        "no step 4": 1749,
        "step 4 looks half as far": 850,
        "step 4 looks twice as far": 192,
        "step 4 looks without end": 5253,
        "no step 5": 121,
        "step 5 of any length": 7411,
    }


def test_bundled_answers_are_the_recorded_ones():
    readme = (reference_folder() / "README.md").read_text()
    sums = dict(re.findall(r"`([\w.]+\.csv)\.gz`.*?`([0-9a-f]{64})`", readme))
    assert len(sums) == 3
    for name, expected in sums.items():
        content = gzip.decompress((reference_folder() / f"{name}.gz").read_bytes())
        assert hashlib.sha256(content).hexdigest() == expected
        original = SAMPLE / "reference-outputs" / name if SAMPLE else None
        if original is not None and original.is_file():
            assert original.read_bytes() == content


# The real sample


@needs_tool
@pytest.mark.parametrize("edge", ["tool", "covering"])
@pytest.mark.parametrize("file", [f for f in LABEL_FILES if not f.bundled], ids=lambda f: f.labels)
def test_no_frame_of_the_sample_is_labelled_otherwise_than_by_the_tool(file, edge):
    assert frames_unlike_the_tools(file, edge) == 0


@pytest.fixture(scope="module")
def sample():
    return load_sample(SAMPLE)


@pytest.fixture(scope="module")
def tool():
    return pd.read_csv(SAMPLE / TOOL_VELOCITIES)


def estimated(sample, form):
    return estimate_velocity(
        sample.trial, SAMPLE_CHAIR, sample.calibration.mount, VelocitySettings(form=form)
    )


@needs_tool
def test_velocities_before_slip_correction(sample, tool):
    printed, safe = (estimated(sample, form) for form in ("printed", "corrected"))
    # The tool averages per-frame matrices, the package takes the principal axis of the rate. The
    # limit was set with the result known: 0.0038 with the document's mean rate, 0.0011 here.
    difference = printed.linear_velocity_mps - tool["linear_velocity_mps"]
    assert np.abs(difference).max() <= 0.004
    # The corrected form is meant to differ: half the difference of the radii times sin(form) for
    # each rad/s of yaw rate, and the vibration across the axles, which the tool takes for turning.
    apart = np.abs(safe.linear_velocity_mps - tool["linear_velocity_mps"]).max()
    assert 0.01 < apart < 0.1
    for ours in (printed, safe):
        # The tool takes the middle half of the static trial: its vertical is 0.1 mrad away.
        difference = np.rad2deg(ours.yaw_rate_radps - tool["yaw_rate_frame_radps"])
        assert np.abs(difference).max() <= 0.01
    # 1.7e-4 of wheel rates up to 15 rad/s, by 0.64 m / 0.63 m
    difference = printed.wheel_yaw_rate_radps - tool["yaw_rate_wheels_radps"]
    assert np.abs(difference).max() <= 0.005


@needs_sample
def test_slip_share_is_mostly_the_printed_camber_term(sample):
    share = {form: estimated(sample, form).slip.mean() for form in ("printed", "corrected")}
    # the tool: 3670 of 12656 frames; single frames flip at the threshold
    assert share["printed"] == pytest.approx(3670 / FRAMES, abs=0.005)
    assert share["corrected"] <= 0.03


@needs_tool
def test_slip_windows_are_the_tools_when_the_yaw_rates_are(tool):
    windows = detect_slip(tool["yaw_rate_frame_radps"], tool["yaw_rate_wheels_radps"], 100)
    theirs = pd.read_csv(
        SAMPLE / "reference-outputs" / "propulsion_slip_windows_properties.csv", sep=";"
    )
    assert windows.first.tolist() == theirs["start"].tolist()
    assert windows.last.tolist() == theirs["end"].tolist()
    assert np.count_nonzero(windows.flags(FRAMES)) == 3670


@needs_sample
def test_wheels_follow_the_frame_in_left_turns_only_with_the_sign_safe_term(sample):
    gain, share = {}, {}
    for form in ("printed", "corrected"):
        found = estimated(sample, form)
        gain[form], share[form] = yaw_gain(
            found.yaw_rate_radps,
            found.wheel_yaw_rate_radps,
            found.linear_velocity_mps,
            side="left",
        )
    # a track known to 1 cm of 84, radii to 1 %
    assert gain["corrected"] == pytest.approx(1.0, abs=0.02)
    # the rate across the axle, which the print takes for the yaw rate's, has vibration in it too
    assert gain["printed"] == pytest.approx(printed_yaw_gain(SAMPLE_CHAIR)[0], abs=0.03)
    # The stated radii differ by 1.5 %; the turns say that the wheels do not (within 0.3 %, one
    # millimetre).
    stated = 2 * (0.3195 - 0.3147) / (0.3195 + 0.3147)
    assert share["corrected"] * SAMPLE_CHAIR.track_m == pytest.approx(stated, abs=0.003)


@needs_sample
@pytest.mark.parametrize("name", TRIAL_FILES)
def test_xsens_exports_read_as_the_shipped_table(name):
    trial = name.rpartition("/")[2].removesuffix(".csv")
    joined = understand(SAMPLE / STRUCTURING / trial, sampling_rate_hz=100).recording
    table = understand(SAMPLE / name, sampling_rate_hz=100).recording
    pd.testing.assert_frame_equal(
        joined.to_frame()[table.to_frame().columns], table.to_frame(), check_exact=True
    )


@needs_sample
def test_shipped_velocities_are_not_those_of_the_shipped_properties(sample):
    """Every frame differs, so the shipped file is no reference for velocities."""
    shipped = read_velocities(SAMPLE / SHIPPED_VELOCITIES)
    ours = estimated(sample, "printed")
    assert np.abs(ours.linear_velocity_mps - shipped.linear_velocity_mps).max() > 0.5
    assert np.abs(ours.yaw_rate_radps - shipped.yaw_rate_radps).max() < np.deg2rad(0.01)


# The record


def test_the_record_holds_nothing_of_the_sample():
    record = recorded.load_record("wheelmove_sample")
    assert set(record["numbers"]) == {*PARTS, "sample_sha256"}
    # Our task codes by run, not the sample's signals: nothing else is longer than a dozen numbers.
    runs = record["numbers"]["tasks"]
    rest = {key: value for key, value in runs.items() if not key.startswith("run_")}
    text = json.dumps({**record["numbers"], "tasks": rest})
    assert len(re.findall(r"[\d.]+", text)) < 120
    assert len(runs["run_starts"]) == len(runs["run_codes"]) < 100


def test_the_record_is_read_without_the_sample(no_sample):
    assert study() is None
    assert sample_numbers("velocity")["frames"] == FRAMES
    assert "here: no" in sample_note()


@needs_sample
@pytest.mark.parametrize("part", PARTS)
def test_the_sample_gives_the_recorded_numbers(part):
    assert sample_numbers(part)
    assert "here: yes" in sample_note()


@needs_sample
@pytest.mark.parametrize("part", PARTS)
def test_the_public_sample_alone_gives_what_does_not_need_the_tools_answers(public_sample, part):
    assert study() is None  # a record needs all
    found = PARTS[part](public_sample)
    assert found and not {"tool", "differing_from_tool"} & set(found)
    complete = recorded.numbers("wheelmove_sample")[part]
    assert set(complete) - set(found) <= {"tool", "differing_from_tool"}
    assert sample_numbers(part) == complete


@needs_sample
def test_another_sample_or_another_number_is_noticed(public_sample, monkeypatch):
    changed = {**PARTS["mounting"](public_sample), "x_beside_forward_deg": 5.0}
    monkeypatch.setitem(PARTS, "mounting", lambda folder: changed)
    with pytest.raises(InputError, match=r"mounting\.x_beside_forward_deg: the sample gives 5"):
        sample_numbers("mounting")
    static = public_sample / TRIAL_FILES[0]
    text = static.read_text()
    static.unlink()
    static.write_text(text + "\n")
    assert sample_checksum(public_sample) != sample_checksum(SAMPLE)
    with pytest.raises(InputError, match="not those of the recorded sample"):
        sample_numbers("velocity")


@needs_tool
def test_the_study_gives_the_recorded_bytes():
    found = study()
    record = recorded.load_record("wheelmove_sample")
    assert found["inputs"] == record["inputs"]
    assert json.loads(json.dumps(found["numbers"])) == record["numbers"]
