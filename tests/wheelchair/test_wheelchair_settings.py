"""Wheelchair: settings of the tasks, and their files."""

import json
import math

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.wheelchair import (
    Task,
    TaskSettings,
    task_codes,
)
from mobility_imu.wheelchair.settings import read_settings
from mobility_imu.wheelchair.tasks import task_steps


def test_settings_file_with_the_tools_keys_and_nulls(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text(
        json.dumps(
            {
                "freqAcq": 100,
                "inptSegmentsec": 0.5,
                "seuilVitLinAbs": 0.6,
                "seuilVitAngAbs": 30,
                "seuilRayonMin": None,
                "seuilRayonMax": 0.7,
                "newSeuilVitLinAbs": 0.2,
                "newSeuilVitAngAbs": None,
            }
        )
    )
    found = read_settings(path)
    assert found.sampling_rate_hz == 100
    assert found.settings == TaskSettings(
        segment_s=0.5,
        linear_velocity_mps=0.6,
        yaw_rate_degps=30.0,
        pivot_radius_m=0.0,
        wide_radius_m=0.7,
        onset_velocity_mps=0.2,
        onset_yaw_rate_degps=0.0,
    )
    path.write_text('{"segment_s": 0.4}')
    assert read_settings(path) == (TaskSettings(segment_s=0.4), None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"seuilVitLin": 0.5}', "seuilVitLin is not a setting.*seuilVitLinAbs"),
        ('{"seuilVitLinAbs": "fast"}', "seuilVitLinAbs = 'fast', expected a number"),
        ('{"seuilVitLinAbs": [1]}', "expected a number"),
        ('{"seuilVitLinAbs": -1}', r": seuilVitLinAbs = -1\.0: expected"),
        ('{"inptSegmentsec": null}', ": inptSegmentsec = null, which is read as 0"),
        ('{"seuilRayonMin": 2}', "seuilRayonMin = 2.0 is larger than seuilRayonMax = 0.5"),
        ('{"seuilVitAngAbs": -40}', ": seuilVitAngAbs = -40"),
        ('{"newSeuilVitAngAbs": -1}', ": newSeuilVitAngAbs = -1"),
        ('{"pivot_radius_m": 2}', ": pivot_radius_m = 2.0 is larger than wide_radius_m = 0.5"),
        ('{"seuilRayonMin": 2, "wide_radius_m": 1}', "Min = 2.0 is larger than wide_radius_m = 1"),
        ('{"segment_s": -1}', ": segment_s = -1"),
        ("[1, 2]", "JSON object"),
        ("{", "not valid JSON"),
        ("", "empty"),
    ],
)
def test_bad_settings_file_is_named_with_what_is_wrong(tmp_path, text, message):
    path = tmp_path / "settings.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_settings(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    "change",
    [
        {"segment_s": 0.0},
        {"segment_s": -1.0},
        {"linear_velocity_mps": math.inf},
        {"yaw_rate_degps": math.nan},
        {"pivot_radius_m": 0.6},
        {"look_s": "long"},
    ],
)
def test_impossible_settings_are_refused(change):
    with pytest.raises(InputError, match=next(iter(change))):
        TaskSettings(**change)


def test_segment_of_a_broken_number_of_frames_is_rounded_with_a_warning():
    velocity, yaw_rate = np.ones(500), np.zeros(500)
    steps = task_steps(velocity, yaw_rate, 50)
    assert "0.25 s is 12.5 frames at 50 Hz: rounded to 12" in steps.warnings[0]
    assert (steps.reduced == Task.FORWARD).all()
    # 0.29 s at 100 Hz is 28.999999999999996 in floating point: whole, no warning
    assert task_steps(velocity, yaw_rate, 100, TaskSettings(segment_s=0.29)).warnings == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"freqAcq": 0}', "freqAcq: sampling rate of 0"),
        ('{"freqAcq": null}', "freqAcq = null, expected the sampling rate"),
        ('{"freqAcq": NaN}', "freqAcq = nan, expected a number"),
        ('{"freqAcq": 1e9}', "freqAcq: sampling rate"),
        ('{"freqAcq": "100"}', "freqAcq = '100', expected a number"),
        ('{"inptSegmentsec": "0.5"}', "inptSegmentsec = '0.5', expected a number"),
        ('{"seuilVitLinAbs": true}', "seuilVitLinAbs = True, expected a number"),
        ('{"seuilVitLinAbs": 1' + 310 * "0" + "}", "expected a number"),
        ('{"seuilVitLinAbs": 1' + 5000 * "0" + "}", "too many digits"),
        (
            '{"segment_s": 0.2, "inptSegmentsec": 0.3}',
            "inptSegmentsec = 0.3, but segment_s = 0.2 as well",
        ),
        (
            '{"inptSegmentsec": 0.3, "segment_s": 0.2}',
            "segment_s = 0.2, but inptSegmentsec = 0.3 as well",
        ),
        ('{"seuilVitLinAbs": NaN}', "seuilVitLinAbs = nan, expected a number"),
        (9000 * '{"a":', "nested too deeply"),
    ],
)
@pytest.mark.usefixtures("no_collection")
def test_a_faulty_settings_file_is_refused_by_the_library_too(tmp_path, text, message):
    path = tmp_path / "settings.json"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_settings(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("change", [{"segment_s": 1e300}, {"look_s": 1e300}, {"segment_s": 1e9}])
def test_settings_longer_than_any_recording_are_refused(change):
    with pytest.raises(InputError, match=f"{next(iter(change))} = .*is it in s"):
        task_codes(np.ones(100), np.zeros(100), 100, TaskSettings(**change))


@pytest.mark.parametrize("rate", [0, -1, np.nan, np.inf, "100", True])
def test_rates_that_are_none_are_refused(rate):
    with pytest.raises(InputError, match="sampling_rate_hz"):
        TaskSettings().frames(rate)
    with pytest.raises(InputError, match="sampling_rate_hz"):
        task_codes(np.ones(100), np.zeros(100), rate)
