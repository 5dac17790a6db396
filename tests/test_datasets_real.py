"""The real data sets, as far as they are here: named by MOBILITY_IMU_RECORDINGS, or fetched."""

import tomllib

import numpy as np
import pandas as pd
import pytest

from mobility_imu.datasets import list_datasets
from mobility_imu.datasets.folders import find_folder
from mobility_imu.readers import read_recording
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.wheelchair.geometry import WheelchairGeometry

GEOMETRIES = {
    "scooter": ScooterGeometry,
    "wheelchair": WheelchairGeometry,
    "walker": WalkerGeometry,
}
SENSORS = {
    "worklab-ngimu": {"frame", "left_wheel", "right_wheel"},
    "terrain-chair": {"frame", "left_wheel", "right_wheel"},
    "labelled-walks": {"frame"},
    "mocap-chair": {"frame", "right_wheel"},
    "car-wheels": {"frame", "left_wheel", "right_wheel"},
    "two-hinges": {"lever", "body"},
    "one-hinge": {"lever", "body"},
    "foot-walks": {"frame"},
}
TRUTH = {
    "mocap-chair": ["time_s", "speed_mps", "yaw_rate_radps"],
    "car-wheels": ["time_s", "speed_mps", "east_m", "north_m"],
    "two-hinges": ["time_s", "steering_rad", "throttle_rad"],
    "one-hinge": ["time_s", "steering_rad", "throttle_rad"],
    "foot-walks": ["time_s", "x_m", "y_m", "z_m", "still"],
}
MOST = 6
"""Recordings that are read of each set: all are of one making."""


HERE = {name: folder for name in SENSORS if (folder := find_folder(name)) is not None}
each = pytest.mark.parametrize("name", HERE)


def recordings(folder):
    """Recordings of a folder, without truth, labels and the table of a choice."""
    names = (p.name for p in folder.glob("*.csv.gz"))
    kept = [n for n in sorted(names) if not n.endswith("_truth.csv.gz") and n != "trials.csv.gz"]
    return kept[:: max(1, len(kept) // MOST)]


# One walk in seven has one step that is a gap.
@pytest.mark.filterwarnings("ignore:.*gap.*:UserWarning")
@each
def test_recordings_are_canonical(name):
    folder = HERE[name]
    assert recordings(folder)
    for file in recordings(folder):
        recording = read_recording(folder / file, fill_gaps_s=0.05)
        assert set(recording.sensors) == SENSORS[name]
        for sensor in recording.sensors:
            length = np.median(np.linalg.norm(recording.sensor(sensor).acc_mps2, axis=1))
            # Wheels and running feet add what their turning brings.
            assert 9 < length < 60
            assert len(recording.gyroscope(sensor)) == len(recording)


@pytest.mark.parametrize("name", [name for name in HERE if name in TRUTH])
def test_truth_is_beside_each_recording_on_its_clock(name):
    folder = HERE[name]
    for file in recordings(folder):
        if file.endswith(("_static.csv.gz", "_straight.csv.gz")):
            continue
        truth = pd.read_csv(folder / file.replace(".csv.gz", "_truth.csv.gz"))
        assert list(truth) == TRUTH[name]
        clock = pd.read_csv(folder / file, usecols=["time_s"]).time_s
        assert clock.iloc[0] - 0.1 <= truth.time_s.iloc[0]
        assert truth.time_s.iloc[-1] <= clock.iloc[-1] + 0.1
        assert truth.notna().all(axis=1).mean() > 0.3


@each
def test_geometry_files_can_be_read(name):
    for path in sorted(HERE[name].glob("*.toml")):
        (device,) = tomllib.loads(path.read_text())
        GEOMETRIES[device].from_toml(path)


@pytest.mark.skipif("labelled-walks" not in HERE, reason="labelled-walks is not here")
def test_labels_lie_inside_their_walks():
    folder = HERE["labelled-walks"]
    labels = pd.read_csv(folder / "labelled_steps.csv")
    assert len(labels) >= 300
    for walk, steps in labels.groupby("walk"):
        end = pd.read_csv(folder / f"{walk}.csv.gz", usecols=["time_s"]).time_s.iloc[-1]
        assert (steps.begin_s >= -0.02).all() and (steps.end_s <= end + 0.02).all()
        assert steps.begin_s.is_monotonic_increasing


def test_every_set_is_looked_at():
    assert {"wheelmove-id-sample", *SENSORS} == {dataset.name for dataset in list_datasets()}
