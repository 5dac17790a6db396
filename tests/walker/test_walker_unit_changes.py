"""A gyroscope whose unit changes within a recording, and what must not be taken for that."""

import numpy as np
import pytest

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.walker import WalkerMount, calibrate_mount, estimate_trajectory
from mobility_imu.walker.geometry import FOOTPRINT as FRAME
from mobility_imu.walker.unit_changes import find_unit_change

DEG = np.rad2deg(1.0)
TRUE_MOUNT = recordings_folder() / "walker_corridor" / "true_mount.toml"


@pytest.fixture(scope="module")
def walk():
    return read_recording(recordings_folder() / "walker_corridor" / "walk.csv.gz")


def with_rates(walk, rates, part=slice(None)):
    imu = walk.sensor("frame")
    gyr = np.array(imu.gyr_radps)
    gyr[part] = rates(gyr[part])
    return Recording(walk.time_s, {"frame": Imu(imu.acc_mps2, gyr)}, source="walk")


@pytest.mark.parametrize("quarter", [1, 2, 3])
@pytest.mark.parametrize("first", [True, False])
def test_a_part_in_degrees_is_found_with_its_times(walk, quarter, first):
    at = quarter * len(walk) // 4
    part = slice(None, at) if first else slice(at, None)
    found = find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, part))
    assert found.sentence.startswith("walk: frame_gyr reads about ")
    assert "is it in deg/s there?" in found.sentence
    begin, end = (0.0, walk.time_s[at]) if first else (walk.time_s[at], walk.time_s[-1])
    assert np.allclose(found.spans_s, [(begin, end)], atol=1)


@pytest.mark.parametrize("name", ["tilts", "walk"])
def test_sound_recordings_have_one_unit(name):
    path = recordings_folder() / "walker_corridor" / f"{name}.csv.gz"
    assert find_unit_change(read_recording(path)) is None


PARTS = [(1 / 3, 2 / 3), (0.2, 0.5), (0.6, 0.9), (0.15, 0.85)]


@pytest.mark.parametrize("middle", PARTS)
def test_a_middle_or_both_ends_in_degrees_are_found_with_their_times(walk, middle):
    """A range from one of its ends to the end of the recording would spoil sound rows."""
    first, last = (round(each * len(walk)) for each in middle)
    begin, end = walk.time_s[first], walk.time_s[last]
    inside = find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, slice(first, last)))
    assert np.allclose(inside.spans_s, [(begin, end)], atol=1)
    outside = np.r_[:first, last : len(walk)]
    both = find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, outside))
    assert np.allclose(both.spans_s, [(0, begin), (end, walk.time_s[-1])], atol=1)
    assert f"from 0 to {both.spans_s[0][1]:.0f} s and from " in both.sentence


def test_a_unit_that_changes_more_often_has_no_false_range(walk):
    fifth = len(walk) // 5
    parts = np.r_[fifth : 2 * fifth, 3 * fifth : 4 * fifth]
    assert find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, parts)) is None


def with_spikes(gyr):
    rng, gyr = np.random.default_rng(1), gyr.copy()
    gyr[rng.choice(len(gyr), 60, replace=False)] += 30 * rng.choice([-1, 1], (60, 1))
    return gyr


OTHERS = {
    "reversed": lambda gyr: -gyr,
    "exchanged": lambda gyr: gyr[:, [1, 2, 0]],
    "offset": lambda gyr: gyr + np.array([0.5, 0.2, 0.1]),
    "offset of 3": lambda gyr: gyr + np.array([3, 0, 0]),
    "offset of 6": lambda gyr: gyr + np.array([0, 6, 0]),
    "offset of 10": lambda gyr: gyr + np.array([6, 8, 0]),
    "dead": np.zeros_like,
    "frozen": lambda gyr: np.full_like(gyr, 6),
    "spikes": with_spikes,
    "noise": lambda gyr: gyr + 8 * np.random.default_rng(2).standard_normal(gyr.shape),
    "less noise": lambda gyr: gyr + 3 * np.random.default_rng(2).standard_normal(gyr.shape),
    "30 times": lambda gyr: 30 * gyr,
}


@pytest.mark.parametrize("fault", OTHERS)
@pytest.mark.parametrize("part", [(0, 1), (0.5, 1), (0, 0.5)])
def test_other_faults_are_no_change_of_unit(walk, fault, part):
    begin, end = (round(each * len(walk)) for each in part)
    assert find_unit_change(with_rates(walk, OTHERS[fault], slice(begin, end))) is None


def test_an_offset_that_is_57_times_as_large_is_no_unit(walk):
    """The turns that it tells are unseen, but the frame moves as before."""
    offset = np.array([0.0, 0.5, 0.0])
    wrong = with_rates(walk, lambda gyr: gyr + offset)
    half = slice(len(walk) // 2, None)
    assert find_unit_change(with_rates(wrong, lambda gyr: gyr + (DEG - 1) * offset, half)) is None


@pytest.mark.parametrize("shift", range(0, 50, 7))
def test_a_part_may_begin_anywhere_within_a_half_second(walk, shift):
    at = 3000 + shift
    found = find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, slice(at, None)))
    assert np.allclose(found.spans_s, [(walk.time_s[at], walk.time_s[-1])], atol=1.1)


def test_a_whole_recording_in_degrees_has_one_unit(walk):
    assert find_unit_change(with_rates(walk, lambda gyr: DEG * gyr)) is None


def test_a_part_at_rest_shows_no_unit(walk):
    """Nor does a recording of a few seconds, or one without a gyroscope."""
    rests = int(np.argmax(np.abs(walk.gyroscope("frame")).max(axis=1) > 0.1))
    assert find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, slice(rests))) is None
    assert find_unit_change(walk.trim(0, 8)) is None
    imu = walk.sensor("frame")
    assert find_unit_change(Recording(walk.time_s, {"frame": Imu(imu.acc_mps2)})) is None


@pytest.mark.parametrize("find", [estimate_trajectory, calibrate_mount])
def test_every_door_names_the_unit(walk, find):
    """Not a frame that never rests, nor a foot."""
    wrong = with_rates(walk, lambda gyr: DEG * gyr, slice(len(walk) // 2, None))
    said = (None, WalkerMount.from_toml(TRUE_MOUNT)) if find is estimate_trajectory else (FRAME,)
    with pytest.raises(InputError, match=r"walk: frame_gyr reads .* is it in deg/s there\?"):
        find(wrong, *said)
