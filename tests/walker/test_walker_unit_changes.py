"""A gyroscope whose unit changes within a recording, and what must not be taken for that."""

import numpy as np
import pytest

from mobility_imu.data import recordings_folder
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording
from mobility_imu.walker.unit_changes import find_unit_change

DEG = np.rad2deg(1.0)


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
    # A move follows a rest in a few seconds: where the frame stands, no rate shows its unit.
    assert found.start_s == pytest.approx(begin, abs=5) and found.stop_s == pytest.approx(
        end, abs=5
    )


@pytest.mark.parametrize("name", ["tilts", "walk"])
def test_sound_recordings_have_one_unit(name):
    path = recordings_folder() / "walker_corridor" / f"{name}.csv.gz"
    assert find_unit_change(read_recording(path)) is None


OTHERS = {
    "reversed": lambda gyr: -gyr,
    "exchanged": lambda gyr: gyr[:, [1, 2, 0]],
    "offset": lambda gyr: gyr + np.array([0.5, 0.2, 0.1]),
    "dead": np.zeros_like,
}


@pytest.mark.parametrize("fault", OTHERS)
@pytest.mark.parametrize("begin", [0.0, 0.5])
def test_other_faults_are_no_change_of_unit(walk, fault, begin):
    part = slice(round(begin * len(walk)), None)
    assert find_unit_change(with_rates(walk, OTHERS[fault], part)) is None


def test_a_whole_recording_in_degrees_has_one_unit(walk):
    assert find_unit_change(with_rates(walk, lambda gyr: DEG * gyr)) is None


def test_a_part_at_rest_shows_no_unit(walk):
    """Nor does a recording of a few seconds, or one without a gyroscope."""
    rests = int(np.argmax(np.abs(walk.gyroscope("frame")).max(axis=1) > 0.1))
    assert find_unit_change(with_rates(walk, lambda gyr: DEG * gyr, slice(rests))) is None
    assert find_unit_change(walk.trim(0, 8)) is None
    imu = walk.sensor("frame")
    assert find_unit_change(Recording(walk.time_s, {"frame": Imu(imu.acc_mps2)})) is None
