"""Walker: what is refused at the doors, and what all results have in common."""

import copy
import inspect
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walker_recordings import FRAME, changed, pose_mount, rebuilt, tilt_recording, walked

import mobility_imu.walker as walker
from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.results import Result
from mobility_imu.runs import runs_of
from mobility_imu.simulation.sensor import IDEAL
from mobility_imu.walker import (
    ClosedLoop,
    GaitSettings,
    NavigationSettings,
    StillnessSettings,
    WalkerGeometry,
    WalkerMount,
    calibrate_mount,
    estimate_trajectory,
    find_steps,
    find_turns,
    six_minute_walk,
    ten_metre_walk,
    timed_up_and_go,
    walking_summary,
)
from mobility_imu.walker.arc_fit import fit_arc
from mobility_imu.walker.calibration import calibrate_from_path
from mobility_imu.walker.follow import (
    _faulty_samples,
    _inconsistent_rests,
    _why_not_still,
    navigate_recording,
)
from mobility_imu.walker.geometry import TILT_DIRECTIONS, rotation_world_to_imu
from mobility_imu.walker.stillness import find_stillness, stillness_signals
from mobility_imu.walker.tilt_equations import (
    arm_angle,
    distance_to_edge,
    forward_axis,
    imu_height,
    position_four_tilts,
    position_gain,
    quaternion_from_rotation,
    rotation_imu_to_body,
    tilt_angle,
    tilt_displacement,
    tilt_quaternion,
)
from mobility_imu.walker.trajectory import (
    _standard_deviations,
    _without_rest,
    body_position,
    trajectory_from_path,
    walking_displacement,
)
from mobility_imu.walker.walking_tests import path_at, time_at

MOUNT = pose_mount("1")
QUATERNION = [1.0, 0.0, 0.0, 0.0]
DISTANCES = dict.fromkeys(TILT_DIRECTIONS, 0.7)


@pytest.fixture(scope="module")
def path():
    return navigate_recording(tilt_recording(0, "1", IDEAL))[0]


@pytest.fixture(scope="module")
def walk():
    return estimate_trajectory(walked().recording, FRAME, MOUNT)


# Options and values.


@pytest.mark.parametrize(
    "call",
    [
        lambda: tilt_angle(QUATERNION, form="prnted"),
        lambda: position_four_tilts(DISTANCES, FRAME, form="prnted"),
        lambda: position_gain(DISTANCES, FRAME, form="prnted"),
        lambda: rotation_world_to_imu(QUATERNION, form="prnted"),
        lambda: calibrate_mount(tilt_recording(), FRAME, form="prnted"),
    ],
)
def test_a_misspelt_form_is_refused(call):
    with pytest.raises(InputError, match="form = 'prnted': expected 'corrected' or 'printed'"):
        call()


def test_other_misspelt_options_are_refused(path, walk):
    with pytest.raises(InputError, match="method = 'best': expected 'four-tilts'"):
        calibrate_mount(tilt_recording(), FRAME, method="best")
    with pytest.raises(InputError, match="method = 'best'"):
        calibrate_from_path(path, FRAME, method="best")
    with pytest.raises(InputError, match="order = up: expected names"):
        calibrate_mount(tilt_recording(), FRAME, order=("up",))
    with pytest.raises(InputError, match="velocity_tilt_rad"):
        calibrate_from_path(path, FRAME, method="two-tilts", velocity_tilt_rad=0)
    with pytest.raises(InputError, match="start = 'flying': expected 'static' or 'rolling'"):
        ten_metre_walk(find_steps(walk), start="flying")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tilt_displacement([1, 2, 3]), r"position_m: expected shape \(n, 3\)"),
        (lambda: tilt_displacement(np.zeros((1, 3))), "both ends of a tilt"),
        (lambda: forward_axis((1, 3)), "displacement_m: expected three components"),
        (lambda: forward_axis([[1, 2, 3]]), r"displacement_m: expected shape \(3,\)"),
        (lambda: tilt_angle([1.0, 0.0]), r"quaternion: expected shape \(4,\)"),
        (lambda: rotation_imu_to_body(2 * np.eye(3), QUATERNION), "not orthogonal"),
        (lambda: rotation_imu_to_body(np.eye(3), [2.0, 0, 0, 0]), "of length 2, expected 1"),
        (lambda: quaternion_from_rotation(np.diag([1, 1, -1])), "a mirror"),
        (lambda: tilt_quaternion([0, 1], 0.1), "axis: expected three components"),
        (lambda: tilt_quaternion([0, 1, 0], "0.1"), "angle_rad"),
        (lambda: distance_to_edge(0.1, np.nan), "angle_rad = nan"),
        (lambda: imu_height({"front": 0.7}, FRAME), "no distance to the back, right, left edge"),
        (lambda: imu_height({**DISTANCES, "left": -1}, FRAME), r"distances_m\['left'\] = -1"),
        (lambda: arm_angle(np.ones((2, 3))), "velocity_mps"),
        (lambda: walking_displacement([0, 0], [0, 0, 0], *[np.eye(3)] * 2, [0] * 3), "position_fi"),
        (lambda: WalkerGeometry("0.6", 0.52), "footprint_width_m = '0.6': expected a number"),
        (lambda: WalkerGeometry(0.6, None), "footprint_length_m = None: expected a number"),
        (lambda: StillnessSettings(rate_radps=0), "StillnessSettings.rate_radps = 0"),
        (lambda: StillnessSettings(margin_s=-0.1), "StillnessSettings.margin_s = -0.1"),
        (lambda: StillnessSettings(mean_s="0.1"), "StillnessSettings.mean_s = '0.1'"),
        (lambda: GaitSettings(least_turn_rad=True), "GaitSettings.least_turn_rad = True"),
    ],
)
def test_shapes_and_numbers_are_checked(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.parametrize("rate", [0, -100, np.nan, np.inf, "100", None])
def test_the_detector_needs_a_sampling_rate(rate):
    with pytest.raises(InputError, match="sampling_rate_hz"):
        find_stillness(np.ones((9, 3)), np.zeros((9, 3)), rate)


@pytest.mark.parametrize(
    ("acc", "gyr", "message"),
    [
        (np.ones((9, 3)), np.zeros((8, 3)), r"gyr_radps: expected shape \(9, 3\)"),
        (np.ones(3), np.zeros(3), r"acc_mps2: expected shape \(n, 3\)"),
        (np.ones((0, 3)), np.ones((0, 3)), "no samples"),
        (np.full((9, 3), np.nan), np.zeros((9, 3)), "acc_mps2: not a finite number"),
    ],
)
def test_the_detector_needs_finite_arrays_of_one_length(acc, gyr, message):
    with pytest.raises(InputError, match=message):
        stillness_signals(acc, gyr, 100.0)


def test_an_arc_needs_three_samples_and_an_angle():
    turn = np.tile(np.eye(3), (9, 1, 1))
    for count, message in ((2, "2 sample"), (9, "turns by 0 deg")):
        with pytest.raises(InputError, match=message):
            fit_arc(np.zeros((count, 3)), turn[:count])
    with pytest.raises(InputError, match=r"expected \(9, 3, 3\)"):
        fit_arc(np.zeros((9, 3)), turn[:8])


def test_no_steps_are_refused_by_all_that_need_one(walk):
    none = find_steps(replace(walk, stationary=np.ones(len(walk), bool)))
    assert len(none) == 0 and any("no step found" in text for text in none.warnings)
    assert len(find_turns(none)) == 0 and len(find_turns(none).to_frame()) == 0
    for call in (
        walking_summary,
        six_minute_walk,
        timed_up_and_go,
        lambda steps: ten_metre_walk(steps, start="static"),
        lambda steps: path_at(steps, 1.0),
        lambda steps: time_at(steps, 1.0),
    ):
        with pytest.raises(InputError, match="there is none"):
            call(none)


# One damaged reading, an offset, a wrong sign: the message says what is known.


@pytest.mark.parametrize("value", [1e30, -9.8e4, 201.0])
@pytest.mark.parametrize("door", [estimate_trajectory, calibrate_mount])
def test_a_reading_beyond_any_sensor_is_one_clear_error(value, door):
    recording = walked().recording if door is estimate_trajectory else tilt_recording()
    acc = recording.sensors["frame"].acc_mps2.copy()
    acc[120, 2] = value
    arguments = (FRAME, MOUNT) if door is estimate_trajectory else (FRAME,)
    with pytest.raises(InputError, match=r"frame_acc_z is .* at 1\.2 s \(sample 120\)"):
        door(rebuilt(recording, acc=acc), *arguments)


@pytest.mark.parametrize("offset_degps", [[0.0, 3.0, 0.0], [2.0, -1.0, 2.0], [0.0, 0.0, 6.0]])
def test_an_offset_of_the_gyroscope_hides_no_rest(walk, offset_degps):
    """The path with it is the path without, to a centimetre; the offset is stated."""
    recording = walked().recording
    offset = np.deg2rad(offset_degps)
    gyr = recording.gyroscope("frame") + offset
    found = estimate_trajectory(rebuilt(recording, gyr=gyr), FRAME, MOUNT)
    assert np.mean(found.stationary != walk.stationary) < 0.01
    assert np.abs(found.position_m - walk.position_m).max() < 0.01
    assert len(find_steps(found)) == len(find_steps(walk))
    assert [text for text in found.warnings if "has an offset" in text]
    path, _ = navigate_recording(rebuilt(recording, gyr=gyr))
    plain, _ = navigate_recording(recording)
    assert np.allclose(path.gyr_bias_radps[-1] - plain.gyr_bias_radps[-1], offset, atol=2e-4)


def test_a_small_offset_is_left_to_the_filter(walk):
    assert not walk.warnings
    gyr = walked().recording.gyroscope("frame") + np.deg2rad([0.0, 1.0, 0.0])
    found = estimate_trajectory(rebuilt(walked().recording, gyr=gyr), FRAME, MOUNT)
    assert not found.warnings


def test_an_even_turn_is_not_called_a_unit():
    recording = walked().recording
    gyr = recording.gyroscope("frame") + np.deg2rad([0.0, 12.0, 0.0])
    with pytest.raises(InputError, match=r"reads 0\.2\d* rad/s.*turning evenly") as caught:
        estimate_trajectory(rebuilt(recording, gyr=gyr), FRAME, MOUNT)
    assert "deg/s" not in str(caught.value)


# Rests that are known.


def test_known_rests_replace_the_detector(walk):
    """With the detector's own rests the same path; the times of the steps are not shortened."""
    recording = walked().recording
    found = estimate_trajectory(recording, FRAME, MOUNT, rests=walk.stationary)
    assert np.array_equal(found.position_m, walk.position_m)
    assert found.stillness is None and find_steps(found).stillness is None
    longer = find_steps(found).swing_s - find_steps(walk).swing_s
    assert np.allclose(longer, 2 * StillnessSettings().eroded_s)


@pytest.mark.parametrize(
    ("rests", "message"),
    [
        ([True, False], "rests"),
        (np.zeros(10), "rests"),
        ("early", "not still within the first 5 s"),
    ],
)
def test_rests_that_do_not_serve(walk, rests, message):
    if isinstance(rests, str):
        rests = walk.stationary & (walk.time_s > 10)
    with pytest.raises(InputError, match=message):
        estimate_trajectory(walked().recording, FRAME, MOUNT, rests=rests)
    with pytest.raises(InputError, match="belong to one recording"):
        estimate_trajectory([walked().recording], FRAME, MOUNT, rests=[rests])


def test_without_rests_the_path_grows_uncertain_and_says_so(walk):
    """Half a minute without a rest: metres, though the same sensor walks ten within decimetres."""
    few = walk.stationary & ((walk.time_s < 10) | (walk.time_s > 40))
    found = estimate_trajectory(walked().recording, FRAME, MOUNT, rests=few)
    said = [text for text in found.warnings if text.startswith("no rest for more than 5 s, ")]
    assert len(said) == 1 and "from 10.0 s on" in said[0] and "known can be given" not in said[0]
    during = (walk.time_s > 15) & (walk.time_s < 35)
    assert found.horizontal_sd_m[during].max() > 1.0
    assert found.horizontal_sd_m[during].max() > 20 * walk.horizontal_sd_m[during].max()
    off = np.linalg.norm((found.position_m - walk.position_m)[:, :2], axis=1)
    assert (off < 3 * found.horizontal_sd_m + 0.05).all()
    unseen = estimate_trajectory(
        walked().recording, FRAME, MOUNT, stillness=StillnessSettings(margin_s=1.0)
    )
    assert any("Rests that are known can be given" in text for text in unseen.warnings)


def test_standard_deviations_turn_with_the_axes():
    """In x and y of the start, whichever way the filter's world looks."""
    path, _ = navigate_recording(walked().recording)
    quarter = Rotation.from_euler("z", 37, degrees=True)
    turn = quarter.as_matrix()
    x, y, xy = path.sd[:, 6] ** 2, path.sd[:, 7] ** 2, path.xy_covariance_m2
    covariance = np.array([[x, xy], [xy, y]]).transpose(2, 0, 1)
    covariance = turn[:2, :2] @ covariance @ turn[:2, :2].T
    sd = path.sd.copy()
    sd[:, 6:8] = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    q = (quarter * Rotation.from_quat(path.quaternion, scalar_first=True)).as_quat(
        scalar_first=True
    )
    other = replace(
        path,
        position_m=path.position_m @ turn.T,
        quaternion=q,
        sd=sd,
        xy_covariance_m2=covariance[:, 0, 1],
    )
    for field in ("position_m", "position_sd_m", "yaw_sd_rad"):
        one, two = (getattr(trajectory_from_path(each, MOUNT), field) for each in (path, other))
        assert np.allclose(one, two, atol=1e-9), field


def test_one_blow_is_not_called_an_exchange_of_axes():
    recording = walked().recording
    acc = recording.sensors["frame"].acc_mps2.copy()
    acc[120, 2] += 150
    found = estimate_trajectory(rebuilt(recording, acc=acc), FRAME, MOUNT)
    said = " ".join(found.warnings)
    assert "axes exchanged" not in said, said


def test_a_mount_far_off_the_frame_is_said_if_the_frame_is_known():
    far = WalkerMount(MOUNT.rotation_imu_to_body, [0.3, 1.6, 0.6])
    recording = walked().recording
    assert any("far off" in t for t in estimate_trajectory(recording, FRAME, far).warnings)
    assert not estimate_trajectory(recording, None, far).warnings
    assert not estimate_trajectory(recording, FRAME, MOUNT).warnings


def test_arguments_in_the_wrong_order_are_refused():
    with pytest.raises(InputError, match="geometry: got WalkerMount"):
        estimate_trajectory(walked().recording, MOUNT, FRAME)
    with pytest.raises(InputError, match="mount: got WalkerGeometry"):
        estimate_trajectory(walked().recording, FRAME, FRAME)
    with pytest.raises(InputError, match="geometry: got WalkerMount"):
        calibrate_mount(tilt_recording(), MOUNT)
    for wrong, message in (("walk.csv", "or a list of them"), ([None], "recording 0: got None")):
        with pytest.raises(InputError, match=message):
            estimate_trajectory(wrong, FRAME, MOUNT)
    for door in (navigate_recording, lambda name: calibrate_mount(name, FRAME)):
        with pytest.raises(InputError, match="recording: got str, expected Recording"):
            door("tilts")
    with pytest.raises(InputError, match="closed_loop needs the smoother"):
        estimate_trajectory(
            walked().recording, FRAME, MOUNT, smooth=False, closed_loop=ClosedLoop()
        )


# Settings travel with the results.


def test_steps_know_the_detector_of_their_path(walk):
    """Swings by a detector with wider margins are as long: the margin is given back."""
    wide = StillnessSettings(margin_s=0.15)
    wider = estimate_trajectory(walked().recording, FRAME, MOUNT, stillness=wide)
    assert wider.stillness == find_steps(wider).stillness == wide
    usual = find_steps(walk)
    assert usual.stillness == StillnessSettings() and usual.settings == GaitSettings()
    assert np.isclose(find_steps(wider).swing_s.mean(), usual.swing_s.mean(), atol=1e-9)


def test_a_turning_step_is_one_by_the_settings_that_the_steps_were_found_with():
    """Its turning steps turn by 30 deg each."""
    there_and_back = estimate_trajectory(turned_round().recording, FRAME, MOUNT)
    assert len(find_turns(find_steps(there_and_back))) == 2
    large = find_steps(there_and_back, GaitSettings(least_turn_rad=np.deg2rad(35)))
    assert len(find_turns(large)) == 0


# What all results have in common.


@pytest.fixture(scope="module")
def results(path, walk):
    steps = find_steps(walk)
    calibration = calibrate_from_path(path, FRAME)
    tilt = calibration.tilts[0]
    arc = fit_arc(path.position_m[tilt.span], path.rotation_imu_to_world()[tilt.span])
    whole = estimate_trajectory(turned_round().recording, FRAME, MOUNT)
    tug = timed_up_and_go(find_steps(whole))
    return {
        "Trajectory": walk, "Steps": steps, "Turns": find_turns(steps), "ArcFit": arc,
        "WalkingSummary": walking_summary(steps), "WalkerCalibration": calibration,
        "WalkerMount": calibration.mount, "TimedUpAndGo": tug,
    }  # fmt: skip


def turned_round():
    from mobility_imu.simulation.walker import TIMED_UP_AND_GO

    return walked(course=TIMED_UP_AND_GO)


def test_results_can_be_pickled_and_copied_and_print_in_one_line(results):
    for name, result in results.items():
        assert type(result).__name__ == name and isinstance(result, Result)
        for other in (pickle.loads(pickle.dumps(result)), copy.deepcopy(result)):
            assert type(other) is type(result) and repr(other) == repr(result)
            assert other != result and result == result and hash(result)
            for field, value in vars(result).items():
                if isinstance(value, np.ndarray):
                    assert np.array_equal(getattr(other, field), value, equal_nan=True)
                    assert not value.flags.writeable and not getattr(other, field).flags.writeable
        assert "\n" not in repr(result) and len(repr(result)) < 700, repr(result)
        if hasattr(result, "to_frame"):
            table = result.to_frame()
            rows = {"TimedUpAndGo": 4, "WalkingSummary": 1}.get(name)
            assert len(table) == (len(result) if rows is None else rows), name


def test_a_list_of_recordings_is_followed_by_any_executor(walk):
    recordings = [walked().recording, walked("1").recording]
    here = estimate_trajectory(recordings, FRAME, MOUNT)
    with ThreadPoolExecutor(2) as pool:
        there = estimate_trajectory(recordings, FRAME, MOUNT, executor=pool)
    assert len(here) == len(there) == 2
    for one, other in zip(here, there, strict=True):
        assert np.array_equal(one.position_m, walk.position_m)
        assert np.array_equal(one.position_m, other.position_m)


def test_all_that_is_exported_has_a_docstring_with_its_parameters():
    for name in walker.__all__:
        public = getattr(walker, name)
        assert public.__doc__, name
        if inspect.isfunction(public):
            assert "Parameters\n" in public.__doc__, name


# Geometry files.


def test_a_mount_is_written_as_it_is_read(tmp_path):
    found = calibrate_mount(tilt_recording(), FRAME)
    text = found.to_toml(tmp_path / "m.toml")
    assert (tmp_path / "m.toml").read_text() == text
    assert text.startswith("[walker]\nfootprint_width_m = 0.6\nfootprint_length_m = 0.52\n\n[walk")
    assert "# all-samples: front " in text
    read = WalkerMount.from_toml(tmp_path / "m.toml")
    assert np.allclose(read.translation_body_m, found.mount.translation_body_m, atol=5e-5)
    assert np.allclose(read.rotation_imu_to_body, found.mount.rotation_imu_to_body, atol=5e-7)
    assert np.allclose(read.translation_sd_m, found.translation_sd_m, atol=5e-6)
    assert np.allclose(read.rotation_sd_rad, found.rotation_sd_rad, atol=5e-6)
    assert WalkerGeometry.from_toml(tmp_path / "m.toml") == FRAME
    FRAME.to_toml(tmp_path / "g.toml")
    assert WalkerGeometry.from_toml(tmp_path / "g.toml") == FRAME
    alone = WalkerMount(np.eye(3), [0.1, 0.2, 0.3]).to_toml(tmp_path / "alone.toml")
    assert alone.startswith("[walker.mount]\nrotation_imu_to_body = [[1.0, 0.0, 0.0], ")
    assert WalkerMount.from_toml(tmp_path / "alone.toml").translation_sd_m is None


def test_unknown_keys_of_a_mount_are_refused(tmp_path):
    text = WalkerMount(np.eye(3), [0.1, 0.2, 0.3]).to_toml()
    (tmp_path / "m.toml").write_text(text + "translation_m = [0, 0, 0]\n")
    with pytest.raises(InputError, match=r"translation_m.* is unknown"):
        WalkerMount.from_toml(tmp_path / "m.toml")


def test_a_recording_of_a_resting_frame_needs_a_sensor_named_frame():
    rest = Recording(np.arange(99) / 100, {"lever": Imu(np.tile([0, 0, 9.8], (99, 1)))})
    with pytest.raises(InputError, match="no sensor 'frame'"):
        estimate_trajectory(rest, FRAME, MOUNT)


@pytest.mark.parametrize(("worst", "says"), [(1, "all of it in 1 of"), (12, "signs reversed")])
def test_rests_that_contradict_the_filter_are_told_one_by_one_or_all(worst, says):
    """One damaged rest is named with its time; with a third of them, the axes are doubted."""
    path, _ = navigate_recording(walked().recording)
    rests = runs_of(path.still)
    assert len(rests) > 25 and _inconsistent_rests(path, "walk") == []
    nis = np.array(path.nis)
    for rest in rests[2 : 2 + 2 * worst : 2]:
        nis[rest] += 2e4 * (path.nis_dof[rest] > 0)
    (said,) = _inconsistent_rests(changed(path, nis=nis), "walk")
    assert said.startswith("walk: the rests are ") and says in said
    if worst == 1:
        when = float(said.rpartition("most at ")[2].partition(" s")[0])
        assert path.time_s[rests[2].start] <= when + 0.05 and when <= path.time_s[rests[2].stop - 1]


def test_only_moves_longer_than_the_longest_are_told():
    """The clock counts, not its size: a walk that begins at an hour is none longer."""
    path, _ = navigate_recording(walked().recording)
    found = trajectory_from_path(path, pose_mount("1"))
    assert _without_rest(found) == ()
    late = replace(found, time_s=found.time_s + 3600.0)
    assert _without_rest(late) == ()
    moves = [
        found.time_s[move.stop - 1] - found.time_s[move.start] for move in runs_of(~path.still)
    ]
    short = replace(found.settings, longest_move_s=0.9 * max(moves))
    (said,) = _without_rest(replace(late, settings=short))
    assert f"no rest for more than {short.longest_move_s:g} s" in said


def test_uncertainty_turns_with_the_axes_of_the_start():
    """The same path and covariance seen along axes turned by 30 deg: C' = R C R'."""
    path, _ = navigate_recording(walked().recording)
    bare = replace(pose_mount("1"), translation_sd_m=None, rotation_sd_rad=None)
    place, attitude = body_position(path.position_m, path.quaternion, bare)
    none = np.zeros_like(place)
    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    settings = NavigationSettings(scale_sd=1e-6, axes_sd_rad=1e-6)
    sd, _ = _standard_deviations(path, bare, turn, none, attitude, settings, tied=True)
    for k in range(0, len(path.still), 500):
        (x, y), xy = path.sd[k, 6:8] ** 2, path.xy_covariance_m2[k]
        expected = turn[:2, :2] @ np.array([[x, xy], [xy, y]]) @ turn[:2, :2].T
        assert np.allclose(sd[k, :2] ** 2, np.diag(expected))
    assert (np.abs(path.xy_covariance_m2) > 0).any()


@pytest.mark.parametrize(
    ("sensor", "limit", "cut"),
    [("acc", 20.0, True), ("acc", 14.0, False), ("gyr", 3.5, True), ("gyr", 2.5, False)],
)
def test_a_limit_is_told_where_a_range_may_end(sensor, limit, cut):
    """A swing along z is cut off at its peaks; rounding of slow readings lies much lower."""
    rng = np.random.default_rng(3)
    readings = {
        "acc": [0.0, 0.0, 9.8] + 0.1 * rng.standard_normal((590, 3)),
        "gyr": 0.05 * rng.standard_normal((590, 3)),
    }
    swing = 1.5 * limit * np.sin(np.arange(590) / 30) ** 3
    readings[sensor][:, 2] = np.clip(swing, -limit, limit)
    at_limit = np.abs(swing) >= limit
    recording = Recording(np.arange(590) / 100, {"frame": Imu(readings["acc"], readings["gyr"])})
    (of_acc, of_gyr), warnings = _faulty_samples(recording)
    found, other = (of_acc, of_gyr) if sensor == "acc" else (of_gyr, of_acc)
    assert not other.any()
    if cut:
        assert np.array_equal(found, at_limit)
        (said,) = warnings
        first = recording.time_s[np.argmax(at_limit)]
        assert (
            f"frame_{sensor} is saturated in {at_limit.sum()} samples, first at {first:g} s" in said
        )
    else:
        assert not found.any() and not warnings


@pytest.mark.parametrize(
    ("scatter", "mean", "says"),
    [
        (0.009, 0.2, "turning evenly"),
        (0.011, 0.2, "in deg/s"),
        (0.5, 0.0, "in deg/s"),
    ],
)
def test_a_gyroscope_that_keeps_a_resting_frame_from_rest_is_told_apart(scatter, mean, says):
    """A resting one scatters by less than 0.01 rad/s about its offset; in deg/s by more."""
    acc = np.tile([0.0, 0.0, 9.8], (800, 1))
    gyr = np.array([0.0, mean, 0.0]) + scatter * np.where(np.arange(800) % 2, 1, -1)[:, None]
    settings = StillnessSettings()
    said = _why_not_still(acc, gyr, 100.0, settings)
    assert says in said and f"reads {mean:.2g} rad/s in the mean, with a scatter of" in said
    acc[:, 0] += 3 * np.sin(np.arange(800) / 8)
    assert _why_not_still(acc, gyr, 100.0, settings) == ""
