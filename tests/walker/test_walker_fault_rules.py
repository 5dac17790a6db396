"""What the walker's finders promise of each fault: whose it is, its cost, how long it lasts."""

import functools
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.faults import Cost, Fault, all_repaired, multiplied
from mobility_imu.health import examine
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.fault_kinds import clean_walk
from mobility_imu.runs import runs_of
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.walker import RECTANGLE, simulate_walk
from mobility_imu.walker import (
    ClosedLoop,
    StillnessSettings,
    WalkerGeometry,
    calibrate_mount,
    estimate_trajectory,
    fault_checks,
    find_faults,
    find_tilt_faults,
    path_checks,
    rest_checks,
    valid_samples,
)
from mobility_imu.walker import faults as walker_faults
from mobility_imu.walker.fault_checks import faults_of_readings
from mobility_imu.walker.faults import not_told
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.path_checks import ODDS_WORDS, faults_of_path, faults_of_tilts
from mobility_imu.walker.reach import BRIDGED_S, SHORTEST_MOVE_S, with_reach
from mobility_imu.walker.rest_checks import HalvesFit, Readings

slow = functools.partial(pytest.param, marks=pytest.mark.slow)
"""Further draws of what the suite tries on one."""


@functools.cache
def sound(seed, level):
    return clean_walk(seed, level, with_sd=False)


def walked():
    return sound(4001, "realistic")


@functools.cache
def path():
    walk = walked()
    return estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)


def readings_of(recording):
    imu, count = recording.sensor("frame"), len(path())
    rates = recording.gyroscope("frame")[-count:]
    return Readings(path().time_s, imu.acc_mps2[-count:], rates, path().stationary)


def fault(code="range", sensor="frame_gyr", at=slice(100, 110), sentence="walk.csv: so", **more):
    flags = np.zeros(len(walked().walk.recording), np.bool_)
    flags[at] = True
    return Fault(code, sensor, float(flags.argmax()) / 100, flags, sentence, **more)


def same(recording):
    return recording


# Whose fault it is.


@pytest.mark.parametrize(
    ("half", "end", "axis", "spike"), [("gyr_radps", 0.4, 2, 3.0), ("acc_mps2", 12.0, 0, 40.0)]
)
@pytest.mark.parametrize("count", [1, 2])
def test_a_spike_hides_no_range(half, end, axis, spike, count):
    """Cut readings of one axis are none of a flat peak because another has a spike beyond them."""
    walk = read_recording(recordings_folder() / "walker_corridor" / "walk.csv.gz")
    imu = walk.sensor("frame")
    halves = {"acc_mps2": imu.acc_mps2, "gyr_radps": imu.gyr_radps}
    halves[half] = np.clip(halves[half], -end, end)
    halves[half][2000 : 2000 + count, axis] = spike
    recording = Recording(walk.time_s, {"frame": Imu(**halves)}, source="walk")
    ends = [each for each in examine(recording) if each.code == "range"]
    assert len(ends) == 1 and ends[0].flags.mean() > 0.01
    nothing = np.zeros(len(recording), np.bool_)
    found = walker_faults._of_sensors(recording, StillnessSettings(), nothing)
    assert "range" in {each.code for each in found}


def test_other_sensors_of_the_file_are_not_judged():
    """A broken sensor on a lever is no fault of the frame, and does not hide one of the frame."""
    walk = walked()
    for recording, find in (
        (walk.walk.recording, lambda r: find_faults(r, walk.tape, walk.mount)),
        (walk.tilts.recording, lambda r: find_tilt_faults(r, walk.tape)),
    ):
        wrong = inject.scale(recording, "frame", "gyr", 1.2)
        lever = inject.scale(recording, "frame", "gyr", [1, 0, 1]).sensor("frame")
        both = Recording(
            wrong.time_s, {"frame": wrong.sensor("frame"), "lever": lever}, source=wrong.source
        )
        alone, beside = find(wrong), find(both)
        assert "scale" in {f.code for f in alone}
        assert [f.told for f in alone] == [f.told for f in beside]
        assert all_repaired(beside, both).sensor("lever") is lever


# Arguments.

WRONG = [
    ({"smooth": "maybe"}, "smooth"),
    ({"settings": 3}, "settings"),
    ({"stillness": 3}, "stillness"),
    ({"rests": [1, 2, 3]}, "rests"),
    ({"closed_loop": 3}, "closed_loop"),
    ({"closed_loop": ClosedLoop(), "smooth": False}, "closed_loop"),
]
WRONG_TILTS = [
    *WRONG[:3],
    ({"method": "typo"}, "method"),
    ({"form": "typo"}, "form"),
    ({"order": "front"}, "order"),
    ({"order": ["up"]}, "order"),
]


@pytest.mark.parametrize(("options", "words"), WRONG)
def test_a_wrong_argument_is_no_recording_without_faults(options, words):
    with pytest.raises(InputError, match=words):
        find_faults(walked().walk.recording, walked().tape, walked().mount, **options)


@pytest.mark.parametrize(("options", "words"), WRONG_TILTS)
def test_a_wrong_argument_of_the_tilts_is_named(options, words):
    with pytest.raises(InputError, match=words):
        find_tilt_faults(walked().tilts.recording, walked().tape, **options)


def test_flags_and_warnings_take_faults_of_their_recording():
    given = fault()
    longer = replace(given, flags=np.r_[np.zeros(4000, np.bool_), given.flags])
    shorter = replace(given, flags=given.flags[:100])
    for wrong in (given, 3, None, ["text"], [longer], [shorter]):
        with pytest.raises(InputError, match="faults"):
            valid_samples(path(), wrong)
    for wrong in (given, 3, None, ["text"]):
        with pytest.raises(InputError, match="faults"):
            not_told(["text"], wrong)
    for wrong in ("text", 3, None):
        with pytest.raises(InputError, match="warnings"):
            not_told(wrong, [given])
    with pytest.raises(InputError, match="found"):
        valid_samples(3, [given])


# What a fault costs.


def test_a_cut_range_whose_cost_is_unknown_is_told():
    negligible = walker_faults._negligible
    assert not negligible(fault(repair=same))
    assert negligible(fault(repair=same, costs=(Cost("place", 1e-4, "m"),)))
    assert not negligible(fault(repair=same, costs=(Cost("place", 1e-2, "m"),)))
    assert not negligible(fault(costs=(Cost("place", 1e-4, "m"),)))


def test_samples_that_a_fault_of_unknown_cost_leaves():
    """Without a repair: none from there on. With one: those that it does not touch."""
    whole = slice(None)
    valid = functools.partial(valid_samples, path())
    late = len(walked().walk.recording) - len(path())
    for repair, lost in ((None, slice(200, None)), (same, slice(200, 300))):
        kept = valid([fault(at=slice(late + 200, late + 300), repair=repair)])
        rested = slice(int(np.flatnonzero(path().stationary[:200])[-1]), None)
        lost = rested if repair is None else lost
        assert not kept[lost].any() and kept.sum() == len(kept) - (~kept[lost]).sum()
        assert not valid([fault(at=whole, repair=repair)]).any()
    small = fault(at=whole, repair=same, costs=(Cost("place", 0.0, "m"),))
    assert valid([small]).all()
    assert valid([fault("start", at=slice(0, late + 5))]).all()
    odds = fault("at odds", at=slice(late + 200, late + 300))
    assert not valid([odds])[200:].any()
    beside = valid([odds, small])
    assert not beside[200:300].any() and beside[:200].all() and beside[300:].all()
    # The filter's words are of all rests: of a lasting fault, from which they come.
    everywhere = replace(odds, flags=np.r_[np.zeros(late, np.bool_), path().stationary])
    lasting = fault(at=slice(late + 400, None))
    assert (valid([everywhere, lasting]) == valid([lasting])).all()
    assert (valid([everywhere, small]) == ~path().stationary).all()


def test_a_place_is_held_against_its_deviation_in_space():
    """What is moved is a distance in space, so is what it is allowed."""
    floor, space = path().horizontal_sd_m[-1], np.linalg.norm(path().position_sd_m[-1])
    between = fault(at=slice(None), repair=same, costs=(Cost("place", (floor + space) / 2, "m"),))
    beyond = fault(at=slice(None), repair=same, costs=(Cost("place", 1.01 * space, "m"),))
    assert floor < space
    assert valid_samples(path(), [between]).all()
    assert not valid_samples(path(), [beyond]).any()


def test_a_path_is_moved_by_the_distance_in_space():
    """0.3 m aside and 0.4 m up are half a metre."""
    found, count = path(), len(walked().walk.recording)
    moved = replace(found, position_m=found.position_m + np.array([0.3, 0.0, 0.4]))
    series = walker_faults._path_series(moved, found, count)
    place = series["place", "m"]
    assert np.isnan(place[: count - len(found)]).all()
    assert np.allclose(place[count - len(found) :], 0.5)
    heading = series["heading", "deg"][count - len(found) :]
    assert (heading == np.rad2deg(found.yaw_rad)).all()
    assert np.nanmax(walker_faults._path_series(found, found, count)["place", "m"]) == 0


@pytest.mark.parametrize("axis", [[1, 0, 0], [1, 1, 1], [0.2, -1, 3]])
@pytest.mark.parametrize("degrees", [0.5, 90.0, 175.0])
def test_a_mount_is_moved_by_the_angle_and_the_distance(axis, degrees):
    """An entry of the matrix would be 57 times its sine or less, as the axes lie."""
    found = calibrate_mount(walked().tilts.recording, walked().tape, method="two-tilts")
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * np.array(axis) / np.linalg.norm(axis))
    mount = replace(
        found.mount,
        rotation_imu_to_body=turn.as_matrix() @ found.mount.rotation_imu_to_body,
        translation_body_m=found.mount.translation_body_m + np.array([0.02, -0.03, 0.06]),
    )
    series = walker_faults._mount_series(replace(found, mount=mount), found)
    assert series["turn of the IMU", "deg"] == pytest.approx(degrees, abs=1e-5)
    assert series["position of the IMU", "m"] == pytest.approx(0.07)


# Nothing twice, and nothing lost.


def test_the_filters_words_do_not_tell_a_known_fault_again():
    text = f"the rests are 9.0 times {ODDS_WORDS} as they should be: hands?"
    recording, walk = walked().walk.recording, walked()
    assert ODDS_WORDS in text
    found = replace(path(), warnings=(text,))
    known = fault("at odds", "frame")
    codes = [f.code for f in faults_of_path(recording, found, walk.mount, ())]
    assert codes == ["at odds"]
    assert faults_of_path(recording, found, walk.mount, [known]) == []
    assert not_told([text], [known]) == []


def test_faults_of_tilts_are_told_once_with_all_words():
    recording, walk = walked().tilts.recording, walked()
    other = WalkerGeometry(walk.tape.footprint_length_m, walk.tape.footprint_width_m)
    warnings = [
        *calibrate_mount(recording, other).warnings,
        f"the rests are 9.0 times {ODDS_WORDS} as they should be: hands?",
    ]
    assert len(warnings) >= 3
    found = faults_of_tilts(recording, warnings, 100, ())
    assert sorted(f.code for f in found) == ["at odds", "poses"]
    assert not_told(warnings, found) == []
    poses = next(f for f in found if f.code == "poses")
    assert "width is" in poses.sentence and "length is" in poses.sentence
    known = [fault("at odds", "frame")]
    assert [f.code for f in faults_of_tilts(recording, warnings, 100, known)] == ["poses"]


def test_a_warning_is_dropped_only_if_a_fault_of_its_sensor_says_it():
    acc = "walk.csv: frame_acc is saturated in 3 samples, first at 3 s: uncertain"
    gyr = "walk.csv: frame_gyr is saturated in 3 samples, first at 3 s: uncertain"
    assert not_told([acc, gyr], [fault("range", "frame_gyr")]) == [acc]
    lean = "by this mount the frame leans by 7.0 deg while it stands: has the IMU moved?"
    back = "the frame went backward: was it calibrated with tilts in another order than stated?"
    leaning = fault("turned", "frame", sentence=f"walk.csv: {lean}")
    words = "walk.csv: frame steps 180 deg to the left of its forward axis"
    aside = fault("turned", "frame", sentence=words)
    assert not_told([lean, back], [leaning]) == [back]
    assert not_told([lean, back], [aside]) == [lean]
    still = "walk.csv: the readings repeat themselves in 30 samples, first at 3 s: frozen?"
    assert not_told([still], [fault("frozen", "frame_acc")]) == []
    assert not_told([still], [fault("range", "frame_acc")]) == [still]
    text, order = "no tilt to the left found", "walk.csv: the tilts went front, back"
    assert not_told([text], [fault("poses", "frame", sentence=order)]) == [text]


def test_a_loss_in_one_move_spoils_no_other_move():
    """The rest before and after it bring tilt and velocity back."""
    moves = runs_of(~path().stationary)
    for k, where in (
        (3, moves[3].start),
        (3, moves[3].stop),  # the first sample at rest is still the move's
        (3, moves[3].start - 1),
        (0, moves[0].start),
        (None, moves[3].start - 2),
        (None, moves[3].stop + 1),
    ):
        lost = np.arange(len(path())) == where
        spoilt = np.flatnonzero(~path_checks._without_lost(path(), lost))
        expected = [] if k is None else range(moves[k].start, moves[k].stop)
        assert spoilt.tolist() == list(expected)


@pytest.mark.parametrize(
    ("far", "told"), [((4,), ""), ((4, 9), "2 times"), ((4, 9, 10), "3 times")]
)
def test_one_move_that_is_too_far_is_a_rest_that_was_not_seen(far, told):
    """From two on the frame rolls, or the sensor is no frame's. Steps of this walk are shorter."""
    moves, place = runs_of(~path().stationary), path().position_m.copy()
    for k in far:
        way = place[moves[k].stop] - place[moves[k].start]
        place[moves[k].stop :] += 1.0 * way / np.linalg.norm(way)
    found = replace(path(), position_m=place)
    usable = np.ones(len(found), np.bool_)
    faults = list(path_checks._far_steps(walked().walk.recording, found, usable))
    assert len(faults) == bool(told)
    for each in faults:
        assert f"{told} by more than 0.8 m" in each.sentence
        assert each.flags.sum() == sum(moves[k].stop - moves[k].start for k in far)


# What the checks say.


def test_a_held_accelerometer_is_judged_by_the_users_stillness(monkeypatch):
    """Whether the gap is bridged depends on what counts as still."""
    given = StillnessSettings(rate_radps=0.07)
    asked = []

    def reach(found, recording, stillness):
        asked.append(stillness)
        return with_reach(found, recording, stillness)

    monkeypatch.setattr(fault_checks, "with_reach", reach)
    recording = inject.freeze(walked().walk.recording, "frame", "acc", 14.0, 4.0)
    faults_of_readings(recording, readings_of(recording), [], given)
    assert asked == [given]


def test_the_stated_deviation_of_the_scale_is_that_of_the_stated_scale(monkeypatch):
    """Rates are multiplied by 0.5 ± 0.01; so they are 2 ± 0.04 times too large."""
    fit = HalvesFit(True, np.ones(3), scale=0.5, scale_sd=0.01)
    monkeypatch.setattr(fault_checks, "fit_halves", lambda readings: fit)
    recording = walked().walk.recording
    (found,) = faults_of_readings(recording, readings_of(recording), [], StillnessSettings())
    assert found.code == "scale" and "100 ± 4 % too much" in found.sentence


def test_an_offset_that_jumps_is_told_from_the_jump_on():
    """A rest before it that turns does not mix into it."""
    recording = walked().walk.recording
    readings, rates = readings_of(recording), recording.gyroscope("frame").copy()
    rests, _ = rest_checks.rest_rates(readings, 0.5)
    late = len(recording) - len(path())
    rates[late + rests[2].start : late + rests[2].stop] += np.deg2rad([0, 0, 3.0])
    rates[recording.time_s > 25] += np.deg2rad([1.0, 0.0, 1.0])
    imu = replace(recording.sensor("frame"), gyr_radps=rates)
    wrong = Recording(recording.time_s, {"frame": imu}, source="jumps")
    told = faults_of_readings(wrong, readings_of(wrong), [], StillnessSettings())
    (found,) = [f for f in told if f.code == "offset"]
    assert "jumps" in found.sentence and f"first at {found.first_s:.2f} s" in found.sentence
    # From the end of the last rest that does not show it.
    assert 21 < found.first_s < 25 and found.flags[found.flags.argmax() :].all()
    when = float(re.search(r"at rest from ([\d.]+) s on", found.sentence)[1])
    assert when == pytest.approx(25, abs=1)


@pytest.mark.parametrize("part", [0.1, 0.3, 0.6, 0.9])
def test_a_jump_is_dated_wherever_it_is(part):
    """Within a step; and the path's samples that it moves beyond their sds are not valid."""
    recording, walk = walked().walk.recording, walked()
    jump_s = part * recording.time_s[-1]
    rates = recording.gyroscope("frame").copy()
    rates[recording.time_s > jump_s] += np.deg2rad([0.0, 2.0, 0.0])
    imu = replace(recording.sensor("frame"), gyr_radps=rates)
    wrong = Recording(recording.time_s, {"frame": imu}, source="jumps")
    told = find_faults(wrong, walk.tape, walk.mount)
    (found,) = [f for f in told if f.code == "offset"]
    when = float(re.search(r"at rest from ([\d.]+) s on", found.sentence)[1])
    assert when == pytest.approx(jump_s, abs=2) and found.first_s <= jump_s
    # The smoother carries it back: the fault begins there, and its sentence says so.
    assert found.first_s == wrong.time_s[found.flags.argmax()] < jump_s - 2
    assert f"the path is off from {found.first_s:.2f} s on" in found.sentence
    assert found.flags[found.flags.argmax() :].all()
    moved = estimate_trajectory(wrong, walk.tape, walk.mount)
    valid = valid_samples(moved, told)
    count = min(len(moved), len(path()))
    apart = np.linalg.norm(moved.position_m[-count:] - path().position_m[-count:], axis=1)
    sd = np.linalg.norm(moved.position_sd_m[-count:], axis=1)
    assert (apart <= 1.5 * np.maximum(sd, 2e-3))[valid[-count:]].all()


@pytest.mark.parametrize("seed", [slow(11), 12])
@pytest.mark.parametrize("warm_up_s", [10.0, 30.0, np.inf])
def test_an_offset_that_drifts_does_not_jump(seed, warm_up_s):
    """By 3 deg/s, evenly or less and less: its repair follows the rests, and its cost is right."""
    walk = sound(seed, "realistic")
    recording = walk.walk.recording
    part = (recording.time_s - recording.time_s[0]) / np.ptp(recording.time_s)
    if np.isfinite(warm_up_s):
        part = 1 - np.exp(-(recording.time_s - recording.time_s[0]) / warm_up_s)
        part /= part[-1]
    wrong = with_rates(recording, np.outer(part, np.deg2rad([0.0, 3.0, 0.0])))
    told = find_faults(wrong, walk.tape, walk.mount)
    (found,) = [f for f in told if f.code == "offset"]
    assert "drifts" in found.sentence and "jumps" not in found.sentence and found.flags.all()
    clean, as_is, mended = (
        estimate_trajectory(each, walk.tape, walk.mount)
        for each in (recording, wrong, found.repair(wrong))
    )
    rests = [rest for rest in runs_of(as_is.stationary) if rest.stop - rest.start >= 50]
    first, last = (3.0 * part[-len(as_is) :][rests[k]].mean() for k in (0, -1))
    assert found.size == pytest.approx(last - first, abs=0.05)
    count = min(len(as_is), len(mended))
    off = [
        np.rad2deg(np.abs(one.yaw_rad[-count:] - clean.yaw_rad[-count:])).max()
        for one in (as_is, mended)
    ]
    assert off[1] < max(0.2 * off[0], 0.1)  # 0.1 deg: a fifth of the heading's sd
    stated = {cost.name: cost.largest for cost in found.costs}["heading"]
    assert stated == pytest.approx(off[0], rel=0.25, abs=0.1)


@pytest.mark.parametrize("part", [0.6, 0.9])
def test_without_a_smoother_nothing_before_a_jump_is_touched(part):
    """And a mount is not told as turned because the filter has not caught up with a move yet."""
    recording, walk = walked().walk.recording, walked()
    jump_s = part * recording.time_s[-1]
    jump = np.outer(recording.time_s > jump_s, np.deg2rad([1.0, 0.0, 1.0]))
    wrong = with_rates(recording, jump)
    told = find_faults(wrong, walk.tape, walk.mount, smooth=False)
    assert {f.code for f in told} - {"at odds"} == {"offset"}
    (found,) = [f for f in told if f.code == "offset"]
    assert found.first_s == wrong.time_s[found.flags.argmax()]
    assert jump_s - 2 < found.first_s < jump_s and "the path is off from" not in found.sentence
    moved = estimate_trajectory(wrong, walk.tape, walk.mount, smooth=False)
    valid = valid_samples(moved, told)
    later = moved.time_s >= found.first_s
    assert not valid[later].any() and valid[~later & ~moved.stationary].all()


def test_without_a_smoother_what_is_lost_is_not_valid_from_its_first_sample_on():
    walk, begin = walked(), len(ended_in_a_move())
    wrong = halted(walk.walk.recording, "gyr", begin, 2000)
    told = find_faults(wrong, walk.tape, walk.mount, smooth=False)
    (found,) = [f for f in told if f.code == "frozen"]
    first = int(found.flags.argmax())
    for smooth in (True, False):
        moved = estimate_trajectory(wrong, walk.tape, walk.mount, smooth=smooth)
        assert moved.smooth is smooth
        valid = valid_samples(moved, [found])
        late = len(wrong) - len(moved)
        rest = np.flatnonzero(moved.stationary[: first - late])[-1]
        assert rest < first - late - 10
        assert np.flatnonzero(valid)[-1] == (rest if smooth else first - late) - 1


def test_a_repair_works_on_the_recording_that_it_is_given():
    """A range and a scale: both are undone, one after the other."""
    walk = walked()
    cut = inject.clip(walk.walk.recording, "frame", "gyr", np.deg2rad(40))
    (found,) = [f for f in examine(cut) if f.code == "range"]
    found = with_reach(found, cut, StillnessSettings())
    assert found.repair is not None
    doubled = multiplied(cut, "frame", "gyr", 2.0)
    first = multiplied(found.repair(cut), "frame", "gyr", 2.0).gyroscope("frame")
    second = found.repair(doubled).gyroscope("frame")
    assert np.abs(second).max() > 1.1 * np.abs(doubled.gyroscope("frame")).max()
    np.testing.assert_allclose(second, first, rtol=1e-9)


def test_shortest_turns_bring_one_direction_to_another():
    rng = np.random.default_rng(3)
    first, second = rng.standard_normal((2, 50, 3))
    first, second = (v / np.linalg.norm(v, axis=1)[:, None] for v in (first, second))
    turns = rest_checks.shortest_turns(first, second)
    assert np.allclose(np.einsum("mij,mj->mi", turns, first), second)
    angle = np.arccos(np.clip((first * second).sum(axis=1), -1, 1))
    assert np.allclose(Rotation.from_matrix(turns).magnitude(), angle)
    assert np.allclose(rest_checks.shortest_turns(first[0], second[0]), turns[0])


def test_each_sentence_says_what_to_do():
    """Checked where they are written: a sentence ends with what the reader does next."""
    walk = walked()
    gravity = inject.scale(walk.walk.recording, "frame", "acc", 1.1)
    (found,) = faults_of_readings(gravity, readings_of(gravity), [], StillnessSettings())
    assert found.code == "gravity" and "calibrate it" in found.sentence
    turn = Rotation.from_rotvec(np.deg2rad([0, 0, 20])).as_matrix()
    body = walk.mount.rotation_imu_to_body
    mount = replace(walk.mount, rotation_imu_to_body=turn @ body)
    moved = estimate_trajectory(walk.walk.recording, walk.tape, mount)
    (aside,) = path_checks.faults_of_path(walk.walk.recording, moved, mount)
    assert aside.code == "turned" and "calibrate the mount again" in aside.sentence
    leans = Rotation.from_rotvec(np.deg2rad([6, 0, 0])).as_matrix()
    mount = replace(walk.mount, rotation_imu_to_body=leans @ body)
    told = find_faults(walk.walk.recording, walk.tape, mount)
    assert "calibrate the mount again" in next(f for f in told if f.code == "turned").sentence


# What says nothing for some time hides nothing of the rest.


def halted(recording, half, begin, count, axis=slice(None)):
    """Recording of which a half, or an axis of it, repeats a reading from a sample on."""
    imu = recording.sensor("frame")
    values = {"acc": imu.acc_mps2.copy(), "gyr": imu.gyr_radps.copy()}
    values[half][begin : begin + count, axis] = values[half][begin, axis]
    new = replace(imu, acc_mps2=values["acc"], gyr_radps=values["gyr"])
    return Recording(recording.time_s, {"frame": new}, source="halted")


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("half", ["acc", "gyr"])
def test_an_axis_that_dies_in_a_walk_is_the_one_fault_and_lasts(half, axis):
    """No other cause is told, and what comes after it is not valid."""
    walk, begin = walked(), len(walked().walk.recording) // 2
    wrong = halted(walk.walk.recording, half, begin, begin, axis)
    (found,) = [f for f in find_faults(wrong, walk.tape, walk.mount) if f.code != "at odds"]
    assert (found.code, found.sensor) == ("dead axis", f"frame_{half}_{'xyz'[axis]}")
    assert found.repair is None and "is not known" in found.sentence
    valid = valid_samples(estimate_trajectory(wrong, walk.tape, walk.mount), [found])
    late = len(wrong) - len(valid)
    last = np.flatnonzero(valid)[-1]  # the smoother carries an error back to the rest before
    assert valid[:last].all() and begin - late - 300 < last <= begin - late + 1


def ended_in_a_move():
    """The walk's recording cut in the middle of a move."""
    moves = runs_of(~path().stationary)
    move = moves[len(moves) // 2]
    recording = walked().walk.recording
    end = (move.start + move.stop) // 2 + len(recording) - len(path())
    return recording.trim(float(recording.time_s[0]), float(recording.time_s[end]))


@pytest.mark.parametrize(("half", "axis"), [("acc", slice(None)), ("gyr", slice(None)), ("gyr", 1)])
def test_a_loss_at_the_end_in_a_move_has_no_line_to_bridge_it(half, axis):
    """Shorter than what is bridged, but a line would repeat the reading that is lost itself."""
    walk, short = walked(), ended_in_a_move()
    wrong = halted(short, half, len(short) - 28, 28, axis)
    told = find_faults(wrong, walk.tape, walk.mount)
    (found,) = [f for f in told if f.code in ("frozen", "dead axis")]
    assert found.repair is None and not found.costs and "is not known" in found.sentence
    valid = valid_samples(estimate_trajectory(wrong, walk.tape, walk.mount), told)
    assert not valid[-28:].any() and valid[:100].all()


@pytest.mark.parametrize("half", ["acc", "gyr"])
def test_a_loss_at_the_end_of_a_rest_is_bridged(half):
    """And so is one of the same length in a move that goes on after it."""
    walk, whole = walked(), walked().walk.recording
    short = ended_in_a_move()
    for wrong in (
        halted(whole, half, len(whole) - 28, 28),
        halted(whole, half, len(short) - 28, 28),
    ):
        told = find_faults(wrong, walk.tape, walk.mount)
        (found,) = [f for f in told if f.code == "frozen"]
        assert found.repair is not None and found.costs


def test_an_axis_that_dies_at_rest_before_the_end_costs_nothing():
    """No line bridges it, and none is needed; with another loss in a move it is not known."""
    walk, whole = walked(), walked().walk.recording
    rest = runs_of(path().stationary)[-1]
    count = rest.stop - rest.start - 10
    wrong = halted(whole, "gyr", len(whole) - count, count, 1)
    (found,) = find_faults(wrong, walk.tape, walk.mount)
    assert found.code == "dead axis" and found.repair is not None
    assert [cost.largest for cost in found.costs] == [0.0, 0.0]
    (known,) = [f for f in examine(wrong) if f.code == "dead axis"]
    begin = len(ended_in_a_move())
    moving = known.flags.copy()
    moving[begin : begin + 28] = True
    both = with_reach(replace(known, flags=moving), wrong, StillnessSettings())
    assert both.repair is None and "is not known" in both.sentence


@pytest.mark.parametrize("which", [0, 6, 12])
def test_a_step_in_which_both_halves_repeat_themselves_is_not_known(which):
    """Each half shows no motion of the other: a gap that was filled with the last reading."""
    walk, (begin, end) = walked(), moves_of_clean_walk()[which]
    first, count = round(100 * begin), round(100 * (end - begin))
    wrong = halted(halted(walk.walk.recording, "acc", first, count), "gyr", first, count)
    told = find_faults(wrong, walk.tape, walk.mount)
    assert {f.sensor for f in told if f.code == "frozen"} == {"frame_acc", "frame_gyr"}
    assert all(f.repair is None for f in told if f.code == "frozen")
    moved = estimate_trajectory(wrong, walk.tape, walk.mount)
    assert not valid_samples(moved, told)[moved.time_s > end].any()


def test_an_axis_that_dies_in_the_tilts_is_told():
    tilts = walked().tilts.recording
    wrong = halted(tilts, "acc", 500, 300, 2)
    told = find_tilt_faults(wrong, walked().tape)
    assert told[0].code == "dead axis" and told[0].sensor == "frame_acc_z"


OTHERS = {
    "lag": lambda r: inject.late_half(r, "frame", "gyr", 0.15),
    "scale": lambda r: inject.scale(r, "frame", "gyr", 1.2),
    "reversed": lambda r: inject.reverse(r, "frame"),
    "gravity": lambda r: inject.scale(r, "frame", "acc", 1.1),
}


@pytest.mark.parametrize("half", ["acc", "gyr"])
@pytest.mark.parametrize("code", OTHERS)
def test_a_short_repetition_hides_no_other_fault(code, half):
    """0.3 s in the last rest."""
    walk = walked()
    wrong = OTHERS[code](walk.walk.recording)
    wrong = halted(wrong, half, len(wrong) - 60, 30)
    told = {f.code for f in find_faults(wrong, walk.tape, walk.mount)} - {"at odds"}
    assert told == {code, "frozen"}


@pytest.mark.parametrize(
    ("seed", "step_mps2", "lag_s", "codes"),
    [(4001, 0.05, 0.3, {"lag"}), (12, 0.1, 0.5, {"lag", "coarse"})],
)
def test_in_coarse_steps_a_late_half_is_no_frozen_accelerometer(seed, step_mps2, lag_s, codes):
    """It repeats itself at rest while the late gyroscope turns; what is lost is found anew."""
    walk = sound(seed, "realistic")
    late = inject.late_half(coarse(walk.walk.recording, step_mps2), "frame", "gyr", lag_s)
    told = find_faults(late, walk.tape, walk.mount)
    assert {f.code for f in told} - {"at odds"} == codes


def test_a_late_half_and_a_frozen_one_are_both_told():
    """4 s of a fine accelerometer that repeats itself have another cause than a lag."""
    walk = walked()
    frozen = inject.freeze(walk.walk.recording, "frame", "acc", 14.0, 4.0)
    told = find_faults(inject.late_half(frozen, "frame", "gyr", 0.15), walk.tape, walk.mount)
    assert {"lag", "frozen"} <= {f.code for f in told}


def test_a_short_repetition_hides_no_jump_and_no_turned_mount():
    walk = walked()
    turn = Rotation.from_rotvec(np.deg2rad([0, 0, 20])).as_matrix()
    mount = replace(walk.mount, rotation_imu_to_body=turn @ walk.mount.rotation_imu_to_body)
    wrong = halted(walk.walk.recording, "gyr", len(walk.walk.recording) - 60, 30)
    assert {f.code for f in find_faults(wrong, walk.tape, mount)} == {"frozen", "turned"}
    rates = wrong.gyroscope("frame").copy()
    rates[(wrong.time_s > 25) & ~halted_flags(wrong)] += np.deg2rad([1.0, 0.0, 1.0])
    imu = replace(wrong.sensor("frame"), gyr_radps=rates)
    jumps = Recording(wrong.time_s, {"frame": imu}, source="jumps")
    told = {f.code for f in find_faults(jumps, walk.tape, walk.mount)}
    assert {"frozen", "offset"} <= told


def halted_flags(recording):
    return np.abs(np.arange(len(recording)) - len(recording) + 45) < 15


@pytest.mark.parametrize("code", ["lag", "scale"])
def test_a_short_repetition_hides_no_other_fault_of_the_tilts(code):
    wrong = OTHERS[code](walked().tilts.recording)
    alone = {f.code for f in find_tilt_faults(wrong, walked().tape)}
    wrong = halted(wrong, "gyr", len(wrong) - 60, 30)
    assert {f.code for f in find_tilt_faults(wrong, walked().tape)} == alone | {"frozen"}


@pytest.mark.parametrize("every", [2, slow(4), slow(5), 8])
@pytest.mark.parametrize("level", ["realistic", "real"])
def test_a_low_sampling_rate_is_no_fault(level, every):
    """What the rests are off is held against the same time, not against a sample."""
    walk = sound(11, level)
    whole, imu = walk.walk.recording, walk.walk.recording.sensor("frame")
    part = Imu(imu.acc_mps2[::every], imu.gyr_radps[::every])
    slow = Recording(whole.time_s[::every], {"frame": part}, source="slow")
    told = find_faults(slow, walk.tape, walk.mount)
    assert "at odds" not in {f.code for f in told}, [f.sentence for f in told]
    assert not [w for w in navigate_recording(slow)[1] if ODDS_WORDS in w]


@pytest.mark.parametrize("seed", [11, slow(12), slow(13), slow(14)])
def test_true_rests_that_are_given_do_not_roll(seed):
    """Their ends land and lift; the detector shaves these off, who gives the rests does not."""
    walk = sound(seed, "real")
    told = find_faults(walk.walk.recording, walk.tape, walk.mount, rests=walk.walk.stationary)
    assert "rolls" not in {f.code for f in told}, [f.sentence for f in told]


def test_a_walk_without_a_fault_has_no_lag():
    """From three and a half standard deviations of the lags of sound walks on."""
    for lag, told in ((0.04, False), (0.065, True)):
        late = inject.late_half(walked().walk.recording, "frame", "gyr", lag)
        codes = {f.code for f in find_faults(late, walked().tape, walked().mount)}
        assert ("lag" in codes) == told


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1 / 57.3, "times too little"),
        (0.1, "times too little"),
        (6.0, "times too much"),
    ],
)
def test_a_gyroscope_in_another_unit_is_told_with_its_size(factor, words):
    """And no lag beside it. Six times the rates leave short rests, and a scale of 12 %."""
    walk = walked()
    wrong = inject.scale(walk.walk.recording, "frame", "gyr", factor)
    told = find_faults(wrong, walk.tape, walk.mount)
    assert not {f.code for f in told} & {"lag", "turned", "foot"}
    (found,) = [f for f in told if f.code == "scale"]
    assert found.size + 1 == pytest.approx(factor, rel=0.15)
    assert words in found.sentence and ("deg/s" in found.sentence) == (factor < 0.05)


@pytest.mark.parametrize(("factor", "told"), [(1.05, False), (1.08, True)])
def test_a_scale_of_the_tilts_is_told_from_six_per_cent_on(factor, told):
    wrong = inject.scale(walked().tilts.recording, "frame", "gyr", factor)
    codes = {fault.code for fault in find_tilt_faults(wrong, walked().tape)}
    assert ("scale" in codes) == told


def test_a_scale_at_the_end_of_what_is_looked_for_is_a_bound(monkeypatch):
    fit = HalvesFit(True, np.ones(3), scale=rest_checks.MOST[1], scale_sd=0.5)
    monkeypatch.setattr(fault_checks, "fit_halves", lambda readings: fit)
    recording = walked().walk.recording
    (found,) = faults_of_readings(recording, readings_of(recording), [], StillnessSettings())
    assert "100 times or more too little" in found.sentence


def test_a_gyroscope_that_says_nothing_is_told():
    """Noise alone, as of a sensor that lies beside the frame."""
    walk = walked()
    imu, rng = walk.walk.recording.sensor("frame"), np.random.default_rng(1)
    rates = rng.normal(0.0, 0.002, imu.gyr_radps.shape)
    silent = Recording(
        walk.walk.recording.time_s, {"frame": replace(imu, gyr_radps=rates)}, source="silent"
    )
    told = find_faults(silent, walk.tape, walk.mount)
    (found,) = [f for f in told if f.code == "scale"]
    assert "says nothing of it" in found.sentence and found.repair is None
    valid = valid_samples(estimate_trajectory(silent, walk.tape, walk.mount), told)
    assert not valid.any()


# One cause, one fault.


def with_rates(recording, more_radps):
    imu = recording.sensor("frame")
    new = replace(imu, gyr_radps=imu.gyr_radps + more_radps)
    return Recording(recording.time_s, {"frame": new}, source="offset")


@pytest.mark.parametrize("seed", [11, slow(12), slow(13)])
@pytest.mark.parametrize("way", ["jump", "drift"])
def test_an_offset_that_changes_is_no_lag_and_no_scale(seed, way):
    """One offset for all rests made the rates look late and too large."""
    walk = sound(seed, "realistic")
    recording = walk.walk.recording
    part = (recording.time_s - recording.time_s[0]) / np.ptp(recording.time_s)
    more = np.deg2rad(2.0) * (part > 0.3) if way == "jump" else np.deg2rad(3.0) * part
    for axis in np.eye(3):
        told = find_faults(with_rates(recording, np.outer(more, axis)), walk.tape, walk.mount)
        codes = {f.code for f in told}
        assert "offset" in codes and not codes & {"lag", "scale", "reversed"}, codes


@pytest.mark.parametrize("seed", [12, slow(13), slow(14)])
@pytest.mark.parametrize("lag", [0.3, -0.3])
def test_a_late_half_of_the_tilts_is_named_and_no_scale(seed, lag):
    """Slow tilts begin in what passes for a rest beside a late half."""
    walk = sound(seed, "realistic")
    late = inject.late_half(walk.tilts.recording, "frame", "gyr", lag)
    told = find_tilt_faults(late, walk.tape)
    assert "scale" not in {f.code for f in told}
    (found,) = [f for f in told if f.code == "lag"]
    assert found.size == pytest.approx(lag, abs=0.07)


@pytest.mark.parametrize("axis", range(3))
def test_an_axis_of_the_accelerometer_with_another_scale_is_no_fault_of_the_gyroscope(axis):
    walk = walked()
    factors = np.where(np.arange(3) == axis, 1.1, 1.0)
    for recording, told in (
        (walk.walk.recording, lambda r: find_faults(r, walk.tape, walk.mount)),
        (walk.tilts.recording, lambda r: find_tilt_faults(r, walk.tape)),
    ):
        wrong = inject.scale(recording, "frame", "acc", factors)
        codes = {f.code for f in told(wrong)}
        assert not codes & {"scale", "lag", "reversed"}, codes


# A constraint that does not hold.


def test_a_loop_that_does_not_close_is_told_with_what_it_bends():
    """The course ends 2.5 m ahead and 1.5 m aside, half a turn off."""
    walk = walked()
    given = {"closed_loop": ClosedLoop()}
    tied = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount, **given)
    assert any("does not close" in text and "2.9 m" in text for text in tied.warnings)
    (found,) = find_faults(walk.walk.recording, walk.tape, walk.mount, **given)
    assert found.code == "not closed" and not_told(tied.warnings, [found]) == []
    bent = np.linalg.norm(tied.position_m - path().position_m, axis=1).max()
    assert {c.name: c.largest for c in found.costs}["place"] == pytest.approx(bent)
    assert not valid_samples(tied, [found]).any()


def test_a_loop_that_closes_is_not_told():
    level, seed = walked().level, 12
    motion = simulate_walk(RECTANGLE, seed=seed, imperfections=level.imperfections)
    walk = walked().followed(motion)
    given = {"closed_loop": ClosedLoop()}
    assert find_faults(walk.recording, walked().tape, walked().mount, **given) == ()
    assert not estimate_trajectory(walk.recording, None, walked().mount, **given).warnings


# Gaps, and words of the tilts.


def filled(recording, begin_s, length_s):
    """The recording with a gap that was filled as ``fill_gaps`` does."""
    imu, time_s = recording.sensor("frame"), recording.time_s
    kept = (time_s < begin_s) | (time_s > begin_s + length_s)
    acc, gyr = (
        np.column_stack([np.interp(time_s, time_s[kept], axis[kept]) for axis in values.T])
        for values in (imu.acc_mps2, imu.gyr_radps)
    )
    return Recording(time_s, {"frame": replace(imu, acc_mps2=acc, gyr_radps=gyr)}, source="gap")


def test_a_long_gap_that_was_filled_is_told_and_judges_nothing_else():
    walk = walked()
    wrong = filled(walk.walk.recording, 14.0, 2.0)
    told = find_faults(wrong, walk.tape, walk.mount)
    assert "gap" in {f.code for f in told} and not {f.code for f in told} & {"lag", "scale"}
    (gap,) = [f for f in told if f.code == "gap"]
    assert gap.size == pytest.approx(2.0, abs=0.05) and gap.first_s == pytest.approx(14, abs=0.05)
    moved = estimate_trajectory(wrong, walk.tape, walk.mount)
    assert not valid_samples(moved, told)[-len(wrong) + 1400 :].any()
    assert find_faults(filled(walk.walk.recording, 14.0, 0.1), walk.tape, walk.mount) == ()
    resting = filled(walk.walk.recording, 0.5, 0.8)
    assert find_faults(resting, walk.tape, walk.mount) == ()


def moves_of_clean_walk():
    """From rest to rest: times of the walk's steps, from the middle of a rest to the next's."""
    late = len(walked().walk.recording) - len(path())
    rests = runs_of(path().stationary)
    middles = [walked().walk.recording.time_s[late + (r.start + r.stop) // 2] for r in rests]
    return list(pairwise(middles))[1:-1]


@pytest.mark.parametrize("which", range(0, 15, 3))
def test_a_gap_from_rest_to_rest_swallows_a_step_and_is_told(which):
    """The filled readings say that the frame stood; nothing says where it stands now."""
    walk, (begin, end) = walked(), moves_of_clean_walk()[which]
    wrong = filled(walk.walk.recording, begin, end - begin)
    told = find_faults(wrong, walk.tape, walk.mount)
    (gap,) = [f for f in told if f.code == "gap"]
    assert gap.size == pytest.approx(end - begin, abs=0.05) and gap.repair is None
    moved = estimate_trajectory(wrong, walk.tape, walk.mount)
    valid = valid_samples(moved, told)
    assert not valid[moved.time_s >= begin + 0.05].any()


def test_a_gap_at_rest_is_spared_if_no_move_is_so_short():
    """0.9 s: the shortest move that goes on, of 450 of 16 real walks, takes 0.98 s."""
    walk = walked()
    assert SHORTEST_MOVE_S == 3 * BRIDGED_S
    for length, codes in ((0.8, set()), (1.0, {"gap"})):
        resting = filled(walk.walk.recording, 0.5, length)
        assert {f.code for f in find_faults(resting, walk.tape, walk.mount)} == codes


def coarse(recording, step_mps2=0.05):
    """The recording in steps of 0.05 m/s² and 0.5 deg/s."""
    imu, steps = recording.sensor("frame"), (step_mps2, np.deg2rad(0.5))
    acc, gyr = (
        step * np.round(values / step)
        for step, values in zip(steps, (imu.acc_mps2, imu.gyr_radps), strict=True)
    )
    new = replace(imu, acc_mps2=acc, gyr_radps=gyr)
    return Recording(recording.time_s, {"frame": new}, source="coarse")


@pytest.mark.parametrize(
    ("length", "begins"),
    [
        *((length, slice(k, None, 3)) for k, length in enumerate((0.28, 1.0, 3.0))),
        *(slow(length, slice(None)) for length in (0.28, 1.0, 3.0)),
    ],
    ids=lambda value: value if isinstance(value, float) else f"every-{value.step or 1}",
)
@pytest.mark.parametrize("change", [lambda r: r, coarse])
def test_a_gap_that_was_filled_is_no_other_fault(length, begins, change):
    """Neither a turned mount nor a dead axis: its line is level where both its ends read alike.

    The three lengths begin at different places, which together are all of them.
    """
    walk = walked()
    recording, tilts = change(walk.walk.recording), change(walk.tilts.recording)
    usual = {f.code for f in find_faults(recording, walk.tape, walk.mount)}
    usual_tilts = {f.code for f in find_tilt_faults(tilts, walk.tape)}
    for begin in np.arange(3.0, 40.0, 3.4)[begins]:
        told = find_faults(filled(recording, begin, length), walk.tape, walk.mount)
        assert {f.code for f in told} <= usual | {"gap", "at odds"}, (begin, told)
    for begin in np.arange(3.0, tilts.time_s[-1] - 4, 4.0)[begins]:
        told = find_tilt_faults(filled(tilts, begin, length), walk.tape)
        assert {f.code for f in told} <= usual_tilts | {"gap", "at odds", "poses"}, (begin, told)


def test_faults_of_tilts_speak_of_the_mount():
    recording, walk = walked().tilts.recording, walked()
    for half in ("acc", "gyr"):
        told = find_tilt_faults(inject.freeze(recording, "frame", half, 8.0, 4.0), walk.tape)
        assert told and all("path" not in f.sentence for f in told), told
