"""Wheelchair: what every result and every option has in common, and the command line."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields, is_dataclass

import numpy as np
import pandas as pd
import pytest
from chairs import trials
from numpy.testing import assert_array_equal

import mobility_imu.wheelchair as door
from mobility_imu.cli.main import app
from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.results import Result
from mobility_imu.simulation.wheelchair import COURT, LIKE_SAMPLE
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    PushSettings,
    SlipSettings,
    TaskSettings,
    VelocitySettings,
    WheelchairGeometry,
    calibrate_mount,
    check_geometry,
    correct_slip,
    detect_pushes,
    detect_slip,
    estimate_velocity,
    identify_tasks,
    slip_report,
    smooth_recording,
    task_codes,
    wheel_speeds,
)
from mobility_imu.wheelchair.calibration import frame_alignment_angles, wheel_alignment_angles
from mobility_imu.wheelchair.tasks import task_steps

COURT_FOLDER = recordings_folder() / "wheelchair_court"


@pytest.fixture(scope="module")
def results():
    """One result of each kind, by name of its class."""
    static, straight, drive = (
        part.recording for part in trials(SAMPLE_CHAIR, 1, legs=COURT, noise=LIKE_SAMPLE)
    )
    calibration = calibrate_mount(static, straight)
    settings = VelocitySettings(slip_correction=True)
    velocity = estimate_velocity(drive, SAMPLE_CHAIR, calibration.mount, settings)
    speed, fs = velocity.linear_velocity_mps, velocity.sampling_rate_hz
    windows = detect_slip(velocity.yaw_rate_radps, velocity.yaw_rate_radps + velocity.slip, fs)
    steps = task_steps(speed, velocity.yaw_rate_radps, fs)
    found = (
        calibration.mount,
        calibration,
        velocity,
        check_geometry(drive, SAMPLE_CHAIR, calibration.mount),
        windows,
        wheel_speeds(speed, velocity.wheel_yaw_rate_radps, velocity.yaw_rate_radps, SAMPLE_CHAIR),
        slip_report(speed, speed, windows, fs),
        steps,
        steps.symbols,
        identify_tasks(velocity),
        detect_pushes(velocity.time_s, speed),
    )
    return {type(result).__name__: result for result in found}


def arrays_of(result):
    for field in fields(result):
        value = getattr(result, field.name)
        if isinstance(value, np.ndarray):
            yield field.name, value
        elif isinstance(value, Result):
            yield from arrays_of(value)


def test_every_result_of_the_chair_is_tried(results):
    public = {
        name
        for name in door.__all__
        if isinstance(kind := getattr(door, name), type) and issubclass(kind, Result)
    }
    assert public <= set(results)


def test_results_come_back_from_a_pickle_and_a_copy(results):
    for result in results.values():
        for other in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result)):
            pairs = list(zip(arrays_of(result), arrays_of(other), strict=True))
            for (name, one), (_, two) in pairs:
                assert_array_equal(one, two, err_msg=name)
                assert one.dtype == two.dtype and not two.flags.writeable
            assert repr(other) == repr(result)


def test_results_are_read_only_short_and_equal_to_themselves(results):
    for name, result in results.items():
        assert repr(result).startswith(f"{name}(") and len(repr(result).splitlines()) == 1
        assert len(repr(result)) < 500
        assert result == result and result in [result] and hash(result) is not None
        for _, array in arrays_of(result):
            with pytest.raises(ValueError, match="read-only"):
                array.flat[:1] = 1


def test_results_carry_the_settings_they_were_made_with(results):
    settings = VelocitySettings(slip_correction=True)
    assert results["ChairVelocity"].settings == settings
    assert results["Tasks"].settings == TaskSettings() and results["Tasks"].edge == "covering"
    assert results["Pushes"].settings == PushSettings()
    assert results["SlipReport"].settings == results["SlipWindows"].settings == SlipSettings()
    assert results["GeometryCheck"].geometry == SAMPLE_CHAIR
    for name in ("WheelchairCalibration", "ChairVelocity", "GeometryCheck", "Tasks", "TaskSteps"):
        assert isinstance(results[name].warnings, tuple)


def test_series_have_tables(results):
    for name in ("ChairVelocity", "Tasks", "Pushes", "SlipReport"):
        assert isinstance(results[name].to_frame(), pd.DataFrame)


def test_slip_is_corrected_with_the_settings_that_found_it():
    strict = SlipSettings(threshold_radps=0.05, shortest_s=0.5)
    yaw, wheels = np.zeros(200), np.zeros(200)
    wheels[50:80] = 0.1
    windows = detect_slip(yaw, wheels, 100, strict)
    assert len(windows) == 1 and windows.settings == strict
    mean = np.full(200, 1.0)
    speeds = wheel_speeds(mean, wheels, yaw, SAMPLE_CHAIR)
    same = correct_slip(mean, np.zeros(200), windows, 100, wheels=speeds)
    assert np.array_equal(same, mean)  # 0.3 s is shorter than 0.5 s
    assert not slip_report(mean, mean, windows, 100).corrected.any()


OPTIONS = {
    "form": [
        lambda value: VelocitySettings(form=value),
        lambda value: wheel_alignment_angles([1, 2, 3], form=value),
        lambda value: frame_alignment_angles([1, 2, 3], form=value),
    ],
    "slip_method": [lambda value: VelocitySettings(slip_method=value)],
    "slip_correction": [lambda value: VelocitySettings(slip_correction=value)],
    "edge": [lambda value: task_codes(np.ones(50), np.zeros(50), 100, edge=value)],
    "method": [
        lambda value: correct_slip(
            np.ones(9), np.ones(9), detect_slip(np.ones(9), np.ones(9), 100), 100, method=value
        ),
        lambda value: smooth_recording(
            read_recording(COURT_FOLDER / "static.csv.gz"), value, window=7
        ),
    ],
}


@pytest.mark.parametrize("value", ["prnted", "", None, "Corrected", ["corrected"], 3])
@pytest.mark.parametrize("option", OPTIONS)
def test_a_misspelt_option_is_refused(option, value):
    for call in OPTIONS[option]:
        with pytest.raises(InputError, match=f"{option} = .*expected"):
            call(value)


def test_the_printed_form_is_not_corrected_by_wheels():
    with pytest.raises(InputError, match="slip_method='tool'"):
        VelocitySettings(form="printed", slip_correction=True)


SETTINGS = (PushSettings, SlipSettings, TaskSettings)


@pytest.mark.parametrize("kind", SETTINGS)
def test_settings_take_numbers_of_numpy_and_refuse_what_is_none(kind):
    assert is_dataclass(kind)
    for field in fields(kind):
        whole = kind(**{field.name: np.float32(0.25)})
        assert getattr(whole, field.name) == 0.25 and type(getattr(whole, field.name)) is float
        for wrong in (True, "0.25", None, np.nan, np.inf, -1.0, 1j, [0.25]):
            with pytest.raises(InputError, match=f"{kind.__name__}.{field.name} = "):
                kind(**{field.name: wrong})
    assert TaskSettings(yaw_rate_degps=np.int64(30)).yaw_rate_degps == 30.0


def test_inputs_of_another_kind_are_named():
    static, straight, drive = (part.recording for part in trials(SAMPLE_CHAIR, 1))
    calibration = calibrate_mount(static, straight)
    with pytest.raises(InputError, match="mount: got WheelchairCalibration, expected Wheelchair"):
        estimate_velocity(drive, SAMPLE_CHAIR, calibration)
    with pytest.raises(InputError, match="geometry: got WheelchairMount"):
        estimate_velocity(drive, calibration.mount, SAMPLE_CHAIR)
    with pytest.raises(InputError, match="settings: got str"):
        estimate_velocity(drive, SAMPLE_CHAIR, calibration.mount, "printed")
    with pytest.raises(InputError, match="recording 0: got str"):
        estimate_velocity(["drive.csv"], SAMPLE_CHAIR, calibration.mount)
    with pytest.raises(InputError, match="drive: got ndarray without time_s"):
        identify_tasks(np.ones(100))


@pytest.mark.parametrize("pool", [None, ThreadPoolExecutor, ProcessPoolExecutor])
def test_a_list_of_recordings_gives_the_same_with_any_executor(pool):
    static, straight, drive = (part.recording for part in trials(SAMPLE_CHAIR, 4))
    mount = calibrate_mount(static, straight).mount
    one = estimate_velocity(drive, SAMPLE_CHAIR, mount)
    if pool is None:
        found = estimate_velocity([drive, straight], SAMPLE_CHAIR, mount)
    else:
        with pool(2) as executor:
            found = estimate_velocity([drive, straight], SAMPLE_CHAIR, mount, executor=executor)
    assert [len(result) for result in found] == [len(drive), len(straight)]
    for field in ("linear_velocity_mps", "wheel_yaw_rate_radps", "slip"):
        assert_array_equal(getattr(found[0], field), getattr(one, field))
    assert estimate_velocity([], SAMPLE_CHAIR, mount) == []


@pytest.mark.parametrize(
    ("arguments", "settings"),
    [
        ([], VelocitySettings()),
        (["--slip-correction"], VelocitySettings(slip_correction=True)),
        (["--camber", "printed"], VelocitySettings(form="printed")),
        (
            ["--camber", "printed", "--slip-correction"],
            VelocitySettings(form="printed", slip_correction=True, slip_method="tool"),
        ),
    ],
)
def test_the_command_writes_what_the_library_gives(tmp_path, arguments, settings):
    static, straight, court = (
        COURT_FOLDER / f"{name}.csv.gz" for name in ("static", "straight", "court")
    )
    geometry = COURT_FOLDER / "geometry.toml"
    velocity, tasks = tmp_path / "v.csv", tmp_path / "t.csv"
    trial = [court, "--static", static, "--straight", straight, "--geometry", geometry]
    command = ["wheelchair", "velocity", *trial, "-o", velocity, *arguments]
    app([str(part) for part in command], standalone_mode=False)
    app(["wheelchair", "tasks", str(velocity), "-o", str(tasks)], standalone_mode=False)

    mount = calibrate_mount(read_recording(static), read_recording(straight)).mount
    chair = WheelchairGeometry.from_toml(geometry)
    drive = estimate_velocity(read_recording(court), chair, mount, settings)
    written = pd.read_csv(velocity)
    pd.testing.assert_frame_equal(written, drive.to_frame(), rtol=0, atol=1e-5)
    labels = pd.read_csv(tasks)
    frame = identify_tasks(drive).to_frame()
    assert list(labels) == list(frame)
    # Written velocities are rounded: a frame at a limit may change its label.
    assert (labels["task_code"] == frame["task_code"]).mean() > 0.999
