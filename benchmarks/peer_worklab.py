"""worklab's speed of a wheelchair, for bench_peers.py, in an interpreter of its own.

``python peer_worklab.py IN OUT``: for each IN/*.npz, OUT/*.npz. As worklab's example goes: resample
to 400 Hz, take the offset off, process. It has no calibration of the mounting: axes are exchanged
and their signs set before. Two more answers tell what matters: "aligned" with the sensors turned by
our calibration, "not_resampled" at the recording's own rate, where that is lower.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from worklab.imu import offset, process_imu, resample_imu

RESAMPLED_HZ = 400.0  # its default; a filter's window is counted in samples of this rate


def frame_of(time_s, gyr_radps, acc_mps2):
    table = np.column_stack([time_s, np.rad2deg(gyr_radps), acc_mps2 / 9.81])
    names = [f"{kind}_{axis}" for kind in ("gyroscope", "accelerometer") for axis in "xyz"]
    return pd.DataFrame(table, columns=["time", *names])


def speed_of(data, way, rate_hz=RESAMPLED_HZ):
    sensors = [name for name in ("frame", "right", "left") if f"{name}_acc" in data]
    time_s = data["time_s"] - data["time_s"][0]
    session = {
        name: frame_of(time_s, data[f"{name}_gyr{way}"], data[f"{name}_acc{way}"])
        for name in sensors
    }
    session = resample_imu(session, sfreq=rate_hz)
    session = offset(session, n_sensors=len(sensors))
    found = process_imu(
        session,
        camber=float(data["camber_deg"]),
        wsize=float(data["radius_m"]),
        wbase=float(data["track_m"]),
        n_sensors=len(sensors),
        sensor_type="ximu3",
    )["frame"]
    return np.interp(time_s, found["time"], found["vel"])


def main():
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    for path in sorted(source.glob("*.npz")):
        data = dict(np.load(path))
        own_hz = 1 / float(np.median(np.diff(data["time_s"])))
        np.savez(
            target / path.name,
            speed_mps=speed_of(data, ""),
            aligned_mps=speed_of(data, "_aligned"),
            not_resampled_mps=speed_of(data, "", own_hz),
        )


if __name__ == "__main__":
    main()
