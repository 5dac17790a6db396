"""A half whose unit changes within a recording, and what must not be taken for that."""

import numpy as np
import pytest

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.fault_motions import foot_motion, rolling_motion
from mobility_imu.reproduction.wheelchair.fault_kinds import MODELS, clean_drive
from mobility_imu.simulation.bundle import WALKER_LEVELS
from mobility_imu.simulation.levels import MOUNTS
from mobility_imu.simulation.walker import CORRIDOR, attach_imu, simulate_walk
from mobility_imu.unit_changes import find_unit_change
from mobility_imu.walker import WalkerMount, calibrate_mount, estimate_trajectory
from mobility_imu.walker.geometry import FOOTPRINT as FRAME

DEG, G = np.rad2deg(1.0), 9.80665
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
    assert f"from 0.00 to {both.spans_s[0][1]:.2f} s and from " in both.sentence


def test_two_middle_parts_in_degrees_are_found_with_their_times(walk):
    fifth = len(walk) // 5
    ends = [(fifth, 2 * fifth), (3 * fifth, 4 * fifth)]
    parts = np.concatenate([np.arange(*each) for each in ends])
    found = find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, parts))
    assert np.allclose(found.spans_s, walk.time_s[np.array(ends)], atol=0.05)


def with_forces(walk, factor, part):
    imu = walk.sensor("frame")
    acc = np.array(imu.acc_mps2)
    acc[part] *= factor
    return Recording(walk.time_s, {"frame": Imu(acc, imu.gyr_radps)}, source="walk")


SHORT = [
    *[(5500, 5500 + count) for count in (20, 30, 100, 400)],
    *[(1800, 1800 + count) for count in (20, 60, 250)],
    *[(-count, None) for count in (20, 100, 150, 200, 500, 700, 1000)],
    *[(0, count) for count in (20, 200, 450)],
    *[(300, None), (450, None), (300, -300)],
]
"""First and last row of a part, at rest and in moves: 0.2 s to nearly all of the walk."""
SAID = {
    ("gyr", DEG): "57 times more {} than elsewhere: is it in deg/s there?",
    ("gyr", 1 / DEG): "57 times less {} than elsewhere: was it converted from deg/s twice there?",
    ("acc", G): "9.8 times more {} than elsewhere: was it converted from g twice there?",
    ("acc", 1 / G): "9.8 times less {} than elsewhere: is it in g there?",
}


@pytest.mark.parametrize(
    ("half", "factor", "part"),
    # A recording whose gravity is wrong in most of its rows is none.
    [
        (*each, part)
        for each in SAID
        for part in SHORT
        if each[0] == "gyr" or part not in SHORT[-3:]
    ],
)
def test_the_unit_of_a_part_of_any_length_is_found_with_its_times(walk, half, factor, part):
    """Without it, they were told as a foot or a hand, or not at all with 31 deg of error."""
    rows = slice(*part)
    found = find_unit_change(
        with_rates(walk, lambda gyr: factor * gyr, rows)
        if half == "gyr"
        else with_forces(walk, factor, rows)
    )
    begin, end = walk.time_s[rows][[0, -1]]
    assert np.allclose(found.spans_s, [(begin, end)], atol=0.05)
    times = f"from {found.spans_s[0][0]:.2f} to {found.spans_s[0][1]:.2f} s"
    said = SAID[half, factor].format(times)
    assert found.sentence == f"walk: frame_{half} reads about {said} Convert these rows"


@pytest.mark.parametrize("half", ["acc", "gyr"])
def test_a_short_part_in_another_unit_is_no_path(walk, half):
    rows = slice(5500, 5530)
    wrong = (
        with_rates(walk, lambda gyr: DEG * gyr, rows)
        if half == "gyr"
        else with_forces(walk, 1 / G, rows)
    )
    times = r"from 5[45]\.[09]. to 55\.[23]. s"
    with pytest.raises(InputError, match=f"frame_{half} reads about .* {times}"):
        estimate_trajectory(wrong, None, WalkerMount.from_toml(TRUE_MOUNT))


@pytest.mark.parametrize("wrong", [None, "walk.csv", 3])
def test_what_is_no_recording_is_refused(wrong):
    with pytest.raises(InputError, match="recording: got "):
        find_unit_change(wrong)


def test_a_name_that_no_sensor_has_is_refused(walk):
    for name in ("seat", None, 3):
        with pytest.raises(InputError, match=r"no sensor|expected str"):
            find_unit_change(walk, name)


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


@pytest.mark.parametrize("size_radps", [0.1, 0.15, 0.2, 0.3, 0.5, 1, 2, 5])
@pytest.mark.parametrize("seed", range(8))
def test_noise_in_a_half_is_no_change_of_unit(walk, seed, size_radps):
    """It is as large at rest as in moves, which a unit's is not; 0.1 rad/s are 57 times its own."""
    rng = np.random.default_rng(seed)
    half = slice(len(walk) // 2, None) if seed % 2 else slice(len(walk) // 2)
    noisy = with_rates(walk, lambda gyr: gyr + rng.normal(0, size_radps, gyr.shape), half)
    assert find_unit_change(noisy) is None


MOTIONS = {
    "foot": lambda seed: foot_motion(seed, 0.5),
    "rolled frame": rolling_motion,
    "walk": lambda seed: simulate_walk(CORRIDOR, seed=seed),
}
SEED = 911_002


def recorded(motion):
    sensor = WALKER_LEVELS["realistic"].sensor
    made = MOTIONS[motion](SEED)
    return attach_imu(made, MOUNTS["1"], sensor, seed=SEED, unit_seed=SEED).recording


@pytest.fixture(scope="module", params=MOTIONS)
def moved(request):
    return recorded(request.param)


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("size_radps", [0.05, 0.1, 0.2])
def test_noise_that_is_as_many_times_larger_as_a_unit_is_none(moved, size_radps, first):
    """At rest it looks like one; the moves stay what they were."""
    half = slice(len(moved) // 2) if first else slice(len(moved) // 2, None)
    rng = np.random.default_rng(911_100)
    noisy = with_rates(moved, lambda gyr: gyr + rng.normal(0, size_radps, gyr.shape), half)
    assert find_unit_change(noisy) is None


@pytest.mark.parametrize("at", [0.5, 0.75, 0.9])
@pytest.mark.parametrize("first", [True, False])
def test_the_noise_at_rest_tells_which_part_is_in_degrees(first, at):
    """Of a frame that is rolled no turn is felt, and the larger part may be the wrong one."""
    recording = recorded("rolled frame")
    count = round(at * len(recording))
    rows = slice(count) if first else slice(-count, None)
    found = find_unit_change(with_rates(recording, lambda gyr: DEG * gyr, rows))
    begin, end = recording.time_s[rows][[0, -1]]
    assert "is it in deg/s there?" in found.sentence
    assert np.allclose(found.spans_s, [(begin, end)], atol=0.05)


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


@pytest.mark.parametrize(
    ("seed", "sensor"), [(318011, "right_wheel"), (319002, "left_wheel"), (320048, "left_wheel")]
)
def test_a_hard_push_is_no_part_in_degrees(seed, sensor):
    """For 0.1 s the rate changes 57 times as fast as before, from one that is small."""
    model = list(MODELS.values())[(seed - 318000) // 1000]
    assert find_unit_change(clean_drive(seed, model).trial, sensor) is None
