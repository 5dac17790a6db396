"""gaitmap's Kalman filter and smoother, for bench_walker.py, in an interpreter of its own.

Reads a recording's .npz; then, for each line on its input, runs once and prints one line: CPU
seconds and the share of samples with a zero-velocity update. ``import`` comes first.
"""

import sys
import time

started = time.perf_counter()
import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
from gaitmap.trajectory_reconstruction import RtsKalman  # noqa: E402
from gaitmap.zupt_detection import NormZuptDetector  # noqa: E402


def main():
    data = np.load(sys.argv[1])
    columns = [f"{sensor}_{axis}" for sensor in ("acc", "gyr") for axis in "xyz"]
    frame = pd.DataFrame(np.c_[data["acc"], np.rad2deg(data["gyr"])], columns=columns)
    method = RtsKalman(
        initial_orientation=data["quaternion"],  # scalar last
        zupt_detector=NormZuptDetector(
            sensor="gyr",
            window_length_s=float(data["window_s"]),
            window_overlap=0.5,
            metric="maximum",
            inactive_signal_threshold=3.0,
        ),
        level_walking=True,
    )
    for _ in sys.stdin:
        start = time.process_time()
        found = method.clone().estimate(frame, sampling_rate_hz=float(data["rate_hz"]))
        spent = time.process_time() - start
        zupts = found.zupts_
        share = (zupts["end"] - zupts["start"]).sum() / len(frame)
        print(spent, share, time.perf_counter() - started, flush=True)


if __name__ == "__main__":
    main()
