"""Files as three vendors' programs write them, made from simulated recordings, for the README.

    python tests/readers/vendor_files.py data/recordings/vendor

The sensors' readings are those of ``mobility-imu simulate ... --seed 1``; signs, units, digits and
columns are the vendors'.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from mobility_imu.frames import STANDARD_GRAVITY_MPS2 as G
from mobility_imu.readers import read_recording

XYZ = "XYZ"
RUNS = (
    "simulate scooter --seed 1 -o ride",
    "scooter calibrate ride/parked_level.csv.gz ride/parked_ramp.csv.gz "
    "--geometry ride/geometry.toml --poses ride/poses.csv -o scooter.toml",
    "simulate wheelchair --seed 1 -o court",
    "simulate walker --seed 1 -o corridor",
    "walker calibrate corridor/tilts.csv.gz --geometry corridor/geometry.toml -o frame.toml",
)
"""Commands that the files are made from."""


def lpms(recording):
    """LpmsControl's table of two sensors: g and deg/s, and 1 g *downward* at rest."""
    rows = []
    for number, name in enumerate(("lever", "body"), start=1):
        imu = recording.sensor(name)
        table = {"SensorId": number, " TimeStamp (s)": recording.time_s.round(4)}
        table[" FrameNumber"] = np.arange(len(recording))
        for k, axis in enumerate(XYZ):
            table[f" Acc{axis} (g)"] = -imu.acc_mps2[:, k] / G
        for k, axis in enumerate(XYZ):
            table[f" Gyro{axis} (deg/s)"] = np.rad2deg(imu.gyr_radps[:, k])
        rows.append(pd.DataFrame(table))
    table = pd.concat(rows).sort_values(" TimeStamp (s)", kind="stable")
    lines = [",".join(table.columns)]
    for row in table.itertuples(index=False):
        numbers = (f"{value:.6f}" for value in row[3:])
        lines.append(", ".join([f"{row[0]:.0f}", f"{row[1]:.4f}", f"{row[2]:.0f}", *numbers]))
    return "\n".join(lines) + "\n"


def mt_manager(recording, name):
    """MT Manager's export of one sensor of a receiver, every second sample: 50 Hz."""
    imu = recording.sensor(name)
    names = ["PacketCounter", *(f"{q}_{a}" for q in ("Acc", "Gyr") for a in XYZ)]
    lines = ["// Start Time: Unknown", "// Update Rate: 50.0Hz", "// Firmware Version: 4.0.2"]
    lines.append("\t".join(names))
    for k, row in enumerate(np.hstack([imu.acc_mps2, imu.gyr_radps])[::2]):
        lines.append("\t".join([f"{3583 + k:05d}", *(f"{value:.6f}" for value in row)]))
    return "\n".join(lines) + "\n"


def ximu3(recording):
    """x-IMU3's Inertial.csv, every second sample: 50 Hz; the clock begins with the power."""
    imu = recording.sensor("frame")
    names = [f"Gyroscope {a} (deg/s)" for a in XYZ] + [f"Accelerometer {a} (g)" for a in XYZ]
    lines = [",".join(["Timestamp (us)", *names])]
    values = np.hstack([np.rad2deg(imu.gyr_radps), imu.acc_mps2 / G])
    for time_s, row in zip(recording.time_s[::2], values[::2], strict=True):
        lines.append(
            ",".join([f"{392_093_562 + 1e6 * time_s:.0f}", *(f"{value:.6f}" for value in row)])
        )
    return "\n".join(lines) + "\n"


TRIALS = {"Trial": "court", "Static": "static", "StraightLine": "straight"}
PLACES = {"Frame": "frame", "LeftWheel": "left_wheel", "RightWheel": "right_wheel"}


def chair_files(court):
    """Names and contents of a chair's three trials."""
    found = {}
    for trial, name in TRIALS.items():
        recording = read_recording(court / f"{name}.csv.gz")
        for place, sensor in PLACES.items():
            found[f"{trial}-{place}.txt"] = mt_manager(recording, sensor)
    return found


def make(folder):
    """Write all files."""
    with tempfile.TemporaryDirectory() as name:
        room = Path(name)
        for run in RUNS:
            command = [sys.executable, "-m", "mobility_imu", *run.split()]
            subprocess.run(command, cwd=room, check=True, capture_output=True)
        contents = {
            "scooter/ride.csv": lpms(read_recording(room / "ride" / "ride.csv.gz")),
            "scooter/scooter.toml": (room / "scooter.toml").read_text(),
            "wheelchair/geometry.toml": (room / "court" / "geometry.toml").read_text(),
            "walker/Inertial.csv": ximu3(read_recording(room / "corridor" / "walk.csv.gz")),
            "walker/frame.toml": (room / "frame.toml").read_text(),
        } | {f"wheelchair/{n}": text for n, text in chair_files(room / "court").items()}
    for path, text in contents.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)


if __name__ == "__main__":
    make(Path(sys.argv[1]))
