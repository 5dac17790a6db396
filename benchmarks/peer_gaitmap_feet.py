"""gaitmap's path of a foot, rests given, for bench_peers.py, in an interpreter of its own.

``python peer_gaitmap_feet.py IN OUT``: for each IN/*.npz, OUT/*.npz. RtsKalman with its own
settings, which no other that was tried betters; instead of its detector, the rests that ours is
given too. "bridged" is the same with our bridges over what the gyroscope has cut off.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from gaitmap.base import BaseZuptDetector
from gaitmap.trajectory_reconstruction import RtsKalman


class GivenRests(BaseZuptDetector):
    """Rests that are known beforehand."""

    def __init__(self, rests=None):
        self.rests = rests

    def detect(self, data, *, sampling_rate_hz=None, **_):
        padded = np.concatenate([[0], np.asarray(self.rests, int), [0]])
        changes = np.flatnonzero(np.diff(padded)).reshape(-1, 2)
        self.data, self.sampling_rate_hz = data, sampling_rate_hz
        self.zupts_ = pd.DataFrame(changes, columns=["start", "end"])
        self.per_sample_zupts_ = np.asarray(self.rests, bool)
        self.min_vel_index_, self.min_vel_value_, self.window_length_samples_ = None, None, None
        return self


def path_of(data, **settings):
    columns = [f"{sensor}_{axis}" for sensor in ("acc", "gyr") for axis in "xyz"]
    frame = pd.DataFrame(np.c_[data["acc"], np.rad2deg(data["gyr"])], columns=columns)
    method = RtsKalman(
        initial_orientation=data["quaternion"],  # scalar last
        zupt_detector=GivenRests(data["rests"]),
        **{"level_walking": True, **settings},
    )
    found = method.estimate(frame, sampling_rate_hz=float(data["rate_hz"]))
    return found.position_.to_numpy()[1:]


def main():
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    for path in sorted(source.glob("*.npz")):
        data = dict(np.load(path))
        bridged = {**data, "gyr": data["gyr_bridged"]}
        np.savez(target / path.name, path_m=path_of(data), bridged_m=path_of(bridged))


if __name__ == "__main__":
    main()
