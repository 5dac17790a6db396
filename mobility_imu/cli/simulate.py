"""Commands that simulate: recordings of each device, with their truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mobility_imu.cli.files import Outputs, csv_bytes
from mobility_imu.cli.options import Folder, Seed, sub_app

if TYPE_CHECKING:
    import pandas as pd

    from mobility_imu.simulation.walker import SimulatedWalker
    from mobility_imu.walker import WalkerGeometry

ScooterCourse = Literal["straight", "curves", "slopes", "side", "tactile"]
WalkerCourse = Literal["corridor", "rectangle", "timed-up-and-go"]
Level = Literal["data-sheet", "sensor", "realistic"]

PARKED_POSES_DEG = ((50, 0), (50, 40), (0, 40), (0, 0), (-50, 0), (-50, 40))
"""Steering and throttle of the parked scooter's poses."""
SCOOTER_FILES = (
    "geometry.toml",
    "ride.csv.gz",
    "truth.csv.gz",
    "reference.csv.gz",
    "poses.csv",
    "parked_level.csv.gz",
    "parked_ramp.csv.gz",
)
WHEELCHAIR_FILES = (
    "geometry.toml",
    "static.csv.gz",
    "straight.csv.gz",
    "court.csv.gz",
    "truth.csv.gz",
)
WALKER_FILES = (
    "geometry.toml",
    "true_mount.toml",
    "tilts.csv.gz",
    "walk.csv.gz",
    "truth.csv.gz",
)

app = sub_app("Recordings with known truth.")


class _FolderOutputs:
    """Files of one folder, which is made for them."""

    def __init__(self, folder: Path, names: Sequence[str]) -> None:
        self.folder = folder
        self.outputs = Outputs({name: folder / name for name in names}, folder=folder)

    def write(self, contents: Mapping[str, pd.DataFrame | str]) -> None:
        """Write tables and texts, all or none."""
        packed = {}
        for name, content in contents.items():
            path = self.folder / name
            packed[path] = (
                content.encode() if isinstance(content, str) else csv_bytes(content, path)
            )
        self.outputs.write(packed)


@app.command("scooter")
def scooter(
    output: Folder,
    seed: Seed,
    course: Annotated[ScooterCourse, typer.Option(help="What is driven.")] = "curves",
) -> None:
    """A scooter drawn from the seed: a ride, two parked recordings, truth and reference."""
    outputs = _FolderOutputs(output, SCOOTER_FILES)
    import numpy as np
    import pandas as pd

    from mobility_imu.simulation.scooter import (
        COURSES,
        draw_driver,
        draw_scooter,
        simulate_parked,
        simulate_ride,
    )

    unit = draw_scooter(seed)
    ride = simulate_ride(COURSES[course], seed=seed, unit=unit, driver=draw_driver(seed))
    settings = [(float(s), float(t)) for s, t in np.deg2rad(PARKED_POSES_DEG)]
    parked = {
        place: simulate_parked(
            settings, pitch_rad=pitch, bank_rad=0, seed=10 * seed + k, unit=unit
        ).to_frame()
        for k, (place, pitch) in enumerate((("level", 0.0), ("ramp", np.deg2rad(5))))
    }
    reference = pd.DataFrame(
        {
            "time_s": ride.reference_time_s,
            "steering_deg": np.rad2deg(ride.reference[:, 0]),
            "throttle_deg": np.rad2deg(ride.reference[:, 1]),
        }
    )
    outputs.write(
        {
            "geometry.toml": "[scooter]\n"
            "steering_inclination_deg = 20.0\nlever_inclination_deg = 9.0\n",
            "ride.csv.gz": ride.recording.to_frame(),
            "truth.csv.gz": ride.truth(),
            "reference.csv.gz": reference,
            "poses.csv": pd.DataFrame(
                np.array(PARKED_POSES_DEG, float), columns=["steering_deg", "throttle_deg"]
            ),
            **{f"parked_{place}.csv.gz": table for place, table in parked.items()},
        }
    )


@app.command("wheelchair")
def wheelchair(output: Folder, seed: Seed) -> None:
    """A chair with 19 degrees of camber on a court: three trials, truth and geometry."""
    outputs = _FolderOutputs(output, WHEELCHAIR_FILES)
    from mobility_imu.simulation.wheelchair import (
        COURT,
        STATIC_TRIAL,
        STRAIGHT_TRIAL,
        random_mounting,
        simulate_drive,
    )
    from mobility_imu.wheelchair import WheelchairGeometry

    chair = WheelchairGeometry.from_degrees(
        19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
    )
    mounting = random_mounting(seed)
    trials = {"static": STATIC_TRIAL, "straight": STRAIGHT_TRIAL, "court": COURT}
    drives = {
        name: simulate_drive(legs, chair, mounting, seed=1000 * seed + k)
        for k, (name, legs) in enumerate(trials.items())
    }
    geometry = (
        "[wheelchair]\n"
        "camber_deg = 19.0\n"
        f"wheel_radius_left_m = {chair.wheel_radius_left_m}\n"
        f"wheel_radius_right_m = {chair.wheel_radius_right_m}\n"
        f"track_m = {chair.track_m}\n"
    )
    outputs.write(
        {
            "geometry.toml": geometry,
            **{f"{name}.csv.gz": drive.recording.to_frame() for name, drive in drives.items()},
            "truth.csv.gz": drives["court"].truth(),
        }
    )


@app.command("walker")
def walker(
    output: Folder,
    seed: Seed,
    course: Annotated[WalkerCourse, typer.Option(help="What is walked.")] = "corridor",
    level: Annotated[
        Level, typer.Option(help="Noise only, errors of the sensor, of the frame as well.")
    ] = "realistic",
    pose: Annotated[int, typer.Option(help="Mounting of the paper's Table 1.", min=1, max=5)] = 1,
) -> None:
    """A walking frame: tilts for the calibration, a walk, its truth, geometry and true mount."""
    outputs = _FolderOutputs(output, WALKER_FILES)
    from mobility_imu.reproduction.walker.studies import LEVELS, tilt_run
    from mobility_imu.reproduction.walker.tables import pose_mount
    from mobility_imu.simulation import walker as simulation

    chosen = LEVELS[level.replace("-", " ")]
    tilts, tape = tilt_run(seed, str(pose), chosen)
    path = getattr(simulation, course.replace("-", "_").upper())
    walk = simulation.attach_imu(
        simulation.simulate_walk(path, seed=seed, imperfections=chosen.imperfections),
        pose_mount(str(pose)),
        chosen.sensor,
        seed=100 * seed + pose,
        unit_seed=10 * seed + pose,  # the sensor of the tilts
    )
    outputs.write(
        {
            "geometry.toml": _footprint_to_toml(tape),
            "true_mount.toml": f"{_footprint_to_toml(tape)}\n{_true_mount_to_toml(walk)}",
            "tilts.csv.gz": tilts.recording.to_frame(),
            "walk.csv.gz": walk.recording.to_frame(),
            "truth.csv.gz": _walk_truth(walk),
        }
    )


def _footprint_to_toml(tape: WalkerGeometry) -> str:
    return (
        f"[walker]\nfootprint_width_m = {tape.footprint_width_m:.4f}\n"
        f"footprint_length_m = {tape.footprint_length_m:.4f}\n"
    )


def _true_mount_to_toml(walk: SimulatedWalker) -> str:
    rotation = [[round(float(v), 6) for v in row] for row in walk.mount.rotation_imu_to_body]
    place = [round(float(v), 4) for v in walk.mount.translation_body_m]
    return f"[walker.mount]\nrotation_imu_to_body = {rotation}\ntranslation_body_m = {place}\n"


def _walk_truth(walk: SimulatedWalker) -> pd.DataFrame:
    """Table of the true path: columns as ``walker trajectory`` writes them."""
    import numpy as np
    import pandas as pd

    forward = walk.rotation_body_to_world[:, :, 0]
    return pd.DataFrame(
        {
            "time_s": walk.recording.time_s,
            **{f"{axis}_m": walk.position_body_m[:, k] for k, axis in enumerate("xyz")},
            "yaw_deg": np.rad2deg(np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))),
            "stationary": walk.stationary.astype(int),
        }
    )
