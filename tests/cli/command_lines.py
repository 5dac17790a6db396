"""Command lines on the bundled recordings, and small recordings for the scooter."""

import numpy as np
import pandas as pd

from mobility_imu.data import recordings_folder

COURT = recordings_folder() / "wheelchair_court"
CORRIDOR = recordings_folder() / "walker_corridor"
SCOOTER_TOML = "[scooter]\nsteering_inclination_deg = 20.0\nlever_inclination_deg = 9.0\n"


def scooter_ride(folder, *, samples=200, acc_unit=1.0, body=True):
    """A scooter at rest on level ground, steered slowly: what both IMUs read."""
    from mobility_imu.scooter import SUZUKI_ET4D
    from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration

    time_s = np.arange(samples) / 100
    steering = np.deg2rad(30) * np.sin(2 * np.pi * time_s / 4)
    throttle = np.full(samples, np.deg2rad(10))
    force = np.broadcast_to(body_specific_force(0.0, 0.0), (samples, 3))
    lever = lever_acceleration(force, steering, throttle, SUZUKI_ET4D)
    columns = {"time_s": time_s}
    tiny = 1e-5 * np.random.default_rng(1).standard_normal((2, samples, 3))  # a sensor's last digit
    for name, values in (("lever", lever + tiny[0]), ("body", force + tiny[1])):
        if name == "body" and not body:
            continue
        for k, axis in enumerate("xyz"):
            columns[f"{name}_acc_{axis}_mps2"] = values[:, k] * acc_unit
    pd.DataFrame(columns).to_csv(folder / "ride.csv", index=False)
    (folder / "g.toml").write_text(SCOOTER_TOML)
    return np.rad2deg(steering), np.rad2deg(throttle)


def angles(ride="ride.csv", geometry="g.toml", output="a.csv"):
    return ["scooter", "angles", ride, "--geometry", geometry, "-o", output]


def velocity(trial=None, output="v.csv", **changed):
    names = {"static": "static.csv.gz", "straight": "straight.csv.gz", "geometry": "geometry.toml"}
    files = {name: COURT / file for name, file in names.items()} | changed
    options = [part for name, file in files.items() for part in (f"--{name}", file)]
    return ["wheelchair", "velocity", trial or COURT / "court.csv.gz", *options, "-o", output]


def calibrate(**options):
    files = {"tilts": CORRIDOR / "tilts.csv.gz", "geometry": CORRIDOR / "geometry.toml"} | options
    return ["walker", "calibrate", files["tilts"], "--geometry", files["geometry"], "-o", "m.toml"]


def trajectory(**options):
    files = {"walk": CORRIDOR / "walk.csv.gz", "mount": "m.toml"} | options
    return ["walker", "trajectory", files["walk"], "--geometry", files["mount"], "-o", "path.csv"]


def velocity_csv(path, *, samples=600):
    """A chair that stands, drives and turns, as ``wheelchair velocity`` writes it."""
    time_s = np.arange(samples) / 100
    table = pd.DataFrame(
        {
            "time_s": time_s,
            "linear_velocity_mps": np.clip(np.sin(time_s), 0, None),
            "yaw_rate_degps": 80 * np.clip(np.sin(2 * time_s), 0, None),
        }
    )
    table.to_csv(path, index=False, float_format="%.6f")
    return table


def rests_csv(path):
    """When the bundled walk rests, by its gyroscope alone, as ``walker trajectory`` takes it."""
    walk = pd.read_csv(CORRIDOR / "walk.csv.gz")
    turning = walk.filter(like="gyr").abs().max(axis=1).rolling(25, center=True, min_periods=1)
    rests = (turning.max() < 0.03).astype(int)
    pd.DataFrame({"time_s": walk["time_s"], "stationary": rests}).to_csv(path, index=False)


def contents(folder):
    """Every path below a folder, with what a regular file holds."""
    return {
        path: path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))
    }


# Every command that writes files: command line without outputs, inputs, options for outputs.
COMMANDS = {
    "scooter angles": (
        ["ride.csv", "--geometry", "g.toml"],
        ["ride.csv", "g.toml"],
        ["-o"],
    ),
    "scooter calibrate": (
        ["ride.csv", "ride.csv", "--geometry", "g.toml", "--poses", "poses.csv"],
        ["ride.csv", "g.toml", "poses.csv"],
        ["-o"],
    ),
    "scooter check": (
        ["ride.csv", "--geometry", "g.toml", "--poses", "poses.csv"],
        ["ride.csv", "g.toml", "poses.csv"],
        ["-o"],
    ),
    "wheelchair velocity": (
        "court.csv.gz --static static.csv.gz --straight straight.csv.gz "
        "--geometry chair.toml".split(),
        ["court.csv.gz", "static.csv.gz", "straight.csv.gz", "chair.toml"],
        ["-o"],
    ),
    "wheelchair tasks": (
        ["velocity.csv", "--settings", "settings.json"],
        ["velocity.csv", "settings.json"],
        ["-o", "--events", "--figure"],
    ),
    "walker calibrate": (
        ["tilts.csv.gz", "--geometry", "frame.toml"],
        ["tilts.csv.gz", "frame.toml"],
        ["-o"],
    ),
    "walker trajectory": (
        ["walk.csv.gz", "--geometry", "frame.toml", "--rests", "rests.csv"],
        ["walk.csv.gz", "frame.toml", "rests.csv"],
        ["-o", "--steps"],
    ),
}
NAMES = {"-o": "out.csv", "--events": "e.csv", "--steps": "s.csv", "--figure": "f.svg"}
MOUNTS = ("scooter calibrate", "walker calibrate")


def name_of(command, option):
    """Name of an output of a command that ends as that kind of file does."""
    return "out.toml" if command in MOUNTS and option == "-o" else NAMES[option]
