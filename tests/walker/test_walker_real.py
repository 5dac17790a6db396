"""Walker on recordings that others made: steps labelled by people, feet under motion capture.

Of the walks only the steps are known, neither course nor place. Of the feet the rests are given
too (the best mask of the data's origin), and the heading's zero is fitted. All of these
walks were seen when ``NavigationSettings.for_foot`` was chosen: no half of them is held out.
"""

import functools

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.datasets.folders import find_folder
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.runs import runs_of
from mobility_imu.walker import (
    NavigationSettings,
    WalkerGeometry,
    WalkerMount,
    estimate_trajectory,
    find_steps,
)

WALKS, FEET = find_folder("labelled-walks"), find_folder("foot-walks")
NEAR_S = 1.0
"""A step belongs to a label if its middle is this near to the label's, and to one label only."""

walks = pytest.mark.skipif(WALKS is None, reason="labelled-walks is not here (fetch)")
feet = pytest.mark.skipif(FEET is None, reason="foot-walks is not here (fetch)")
pytestmark = pytest.mark.filterwarnings("ignore:.*gap.s. filled in")


# Walks with labelled steps.


def walk_names():
    return sorted(path.name.split(".")[0] for path in WALKS.glob("walk_??.csv.gz"))


@functools.cache
def walked(name, offset_degps=0.0):
    recording = read_recording(WALKS / f"{name}.csv.gz")
    imu = recording.sensor("frame")
    gyr = recording.gyroscope("frame") + np.deg2rad([0.0, offset_degps, 0.0])
    mount = WALKS / "mount.toml"
    return estimate_trajectory(
        Recording(recording.time_s, {"frame": Imu(imu.acc_mps2, gyr)}, source=name),
        WalkerGeometry.from_toml(mount),
        WalkerMount.from_toml(mount),
    )


def compared(name, trajectory):
    """Number of labels, labels with a step, and the steps without a label."""
    steps = find_steps(trajectory)
    labels = pd.read_csv(WALKS / "labelled_steps.csv").query("walk == @name")
    middle = (steps.lift_s + steps.place_s) / 2
    free = set(range(len(steps)))
    found = 0
    for label in (labels["begin_s"] + labels["end_s"]) / 2:
        near = [k for k in free if abs(middle[k] - label) < NEAR_S]
        if near:
            free.remove(min(near, key=lambda k: abs(middle[k] - label)))
            found += 1
    others = sorted(free)
    return len(labels), found, others, steps, labels


@walks
def test_labelled_steps_are_found():
    """At least 99 % of them, and at most 6 % others."""
    counts = np.zeros(3)
    for name in walk_names():
        labels, found, others, *_ = compared(name, walked(name))
        counts += [labels, found, len(others)]
    assert counts[0] >= 316
    assert counts[1] >= 0.99 * counts[0]
    assert counts[2] <= 0.06 * counts[0]


@walks
def test_steps_without_a_label_are_moves_of_the_frame():
    """Each goes by 5 cm or more; most come before the first label, where nothing was cut out."""
    before = between = 0
    for name in walk_names():
        _, _, others, steps, labels = compared(name, walked(name))
        early = steps.place_s[others] < labels["begin_s"].min()
        before, between = before + early.sum(), between + (~early).sum()
        assert (steps.length_m[others] > 0.05).all()
        assert (steps.swing_s[others] > 0.3).all()
    assert before > between


@walks
@pytest.mark.parametrize("offset_degps", [-3.0, 2.5])
def test_an_offset_of_the_gyroscope_loses_no_step(offset_degps):
    labels = found = others = 0
    for name in walk_names()[::4]:
        trajectory = walked(name, offset_degps)
        some = compared(name, trajectory)
        labels, found, others = labels + some[0], found + some[1], others + len(some[2])
        assert any("has an offset" in text for text in trajectory.warnings)
    assert found >= 0.97 * labels and others <= 0.1 * labels


@walks
def test_walks_are_one_metre_to_ten_long_and_sure_of_it():
    """Scale and axes, 1 % of the way along and across it by the settings, leave 7 cm at most."""
    for name in walk_names()[::4]:
        trajectory = walked(name)
        length_m = np.linalg.norm(trajectory.position_m[-1, :2])
        assert 1 < length_m < 10
        assert trajectory.horizontal_sd_m[-1] < np.hypot(0.07, np.sqrt(2) * 0.01 * length_m)
        assert not any("no rest for" in text for text in trajectory.warnings)


ROLLED = find_folder("terrain-chair")


@pytest.mark.skipif(ROLLED is None, reason="terrain-chair is not here (fetch)")
@pytest.mark.parametrize("name", ["grass_donut", "asphalt_straight", "sidewalk_donut"])
def test_a_frame_that_rolls_on_real_ground_does_not_pass_for_still(name):
    """The frame of a chair stands for one on wheels: shaken by the ground, it finds no rest."""
    recording = read_recording(ROLLED / f"{name}.csv.gz")
    first = recording.sensor("frame").acc_mps2[:100].mean(axis=0)
    upright, _ = Rotation.align_vectors([[0, 0, 1]], [first])
    found = estimate_trajectory(recording, None, WalkerMount(upright.as_matrix(), [0.0, 0.0, 0.0]))
    wheel = np.abs(recording.gyroscope("left_wheel")).max(axis=1)[-len(found) :]
    assert np.mean(found.stationary[wheel > 1.0]) < 0.02
    assert any(text.startswith("no rest for more than 5 s") for text in found.warnings)
    assert any("was it rolled" in text for text in found.warnings)


# Feet under motion capture.


def foot_names():
    return sorted(path.name[5:7] for path in FEET.glob("foot_??.csv.gz"))


@functools.cache
def foot(name):
    """Recording, mount by the gravity of its first half second, truth on the recording's clock."""
    recording = read_recording(FEET / f"foot_{name}.csv.gz", fill_gaps_s=0.05)
    truth = pd.read_csv(FEET / f"foot_{name}_truth.csv.gz").set_index("time_s")
    first = recording.sensor("frame").acc_mps2[recording.time_s < recording.time_s[0] + 0.5]
    upright, _ = Rotation.align_vectors([[0, 0, 1]], [first.mean(axis=0)])
    place = np.column_stack(
        [np.interp(recording.time_s, truth.index, truth[f"{axis}_m"]) for axis in "xyz"]
    )
    still = np.interp(recording.time_s, truth.index, truth["still"]) > 0.99
    return recording, WalkerMount(upright.as_matrix(), [0.0, 0.0, 0.0]), place, still


def followed(name, settings=None, *, given=True):
    """Trajectory and its horizontal error, complex, in its own axes, best heading of the start."""
    recording, mount, place, still = foot(name)
    found = estimate_trajectory(recording, None, mount, settings, rests=still if given else None)
    place = place[-len(found) :]
    true = place @ [1, 1j, 0] - place[0] @ [1, 1j, 0]
    path = found.position_m @ [1, 1j, 0]
    path = path - path[0]
    turn = np.vdot(true, path)
    return found, path - true * turn / abs(turn)


RANGE_RADPS = np.deg2rad(500.0)
"""The readings of this gyroscope pile up between 515 and 560 deg/s; below 500 they do not."""


def judged(names, settings=None, *, given=True):
    """Root mean square error, its ratio to the median sd, and coverage by 95 % intervals."""
    rms, ratio, inside = [], [], []
    for name in names:
        found, error = followed(name, settings, given=given)
        rms.append(np.sqrt(np.mean(np.abs(error) ** 2)))
        ratio.append(rms[-1] / np.median(found.horizontal_sd_m))
        sure = found.position_sd_m[:, :2]
        moved = (sure > 1e-4).all(axis=1)
        off = np.column_stack([error.real, error.imag])
        inside.append(np.mean(np.abs(off[moved]) < 1.96 * sure[moved]))
    return np.array(rms), np.array(ratio), float(np.mean(inside))


@feet
def test_feet_with_settings_of_a_frame():
    """A quarter of a metre; the stated sd is some ten times too small: a foot is no frame."""
    rms, ratio, _ = judged(foot_names(), NavigationSettings.for_calibrated_sensor())
    assert len(rms) >= 28
    assert np.median(rms) <= 0.25
    assert 4 < np.median(ratio) < 20


@feet
def test_a_foot_that_is_faster_than_its_gyroscope():
    """The range's end is told: the mean error falls, and the stated intervals cover as they say."""
    without, *_ = judged(foot_names(), NavigationSettings.for_foot())
    settings = NavigationSettings.for_foot(gyr_range_radps=RANGE_RADPS)
    rms, ratio, covered = judged(foot_names(), settings)
    assert np.median(rms) <= 0.065
    assert np.mean(rms) < np.mean(without)
    assert 0.5 < np.median(ratio) < 2
    assert 0.85 <= covered <= 0.99


@feet
@pytest.mark.parametrize("half", [0, 1], ids=["odd places", "even places"])
def test_feet_with_their_own_settings(half):
    """At most 8 cm (median); the stated sd lies between half and twice the error (median)."""
    rms, ratio, covered = judged(foot_names()[half::2], NavigationSettings.for_foot())
    assert np.median(rms) <= 0.08
    assert 0.5 < np.median(ratio) < 2
    assert 0.85 <= covered <= 0.99


@feet
def test_feet_without_rests_are_uncertain_by_metres_and_say_so():
    """The frame's detector sees no stance of a foot: metres off, but within what is stated."""
    names = [name for name in foot_names()[::3] if name != "19"]
    rms, ratio, covered = judged(names, given=False)
    assert np.median(rms) > 1
    assert 0.5 < np.median(ratio) < 2
    assert 0.8 <= covered <= 0.99
    for name in names:
        found, _ = followed(name, given=False)
        longest = max(run.stop - run.start for run in runs_of(~found.stationary)) / 200
        said = [text for text in found.warnings if text.startswith("no rest for more than 5 s")]
        assert len(said) == (longest > 5), name
