"""Commands that simulate: recordings of each device, with their truth."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mobility_imu.cli.messages import summarize
from mobility_imu.cli.options import Folder, Quiet, Seed, sub_app
from mobility_imu.files import Outputs, csv_bytes

if TYPE_CHECKING:
    import pandas as pd

ScooterCourse = Literal["straight", "curves", "slopes", "side", "tactile"]
WalkerCourse = Literal["corridor", "rectangle", "timed-up-and-go"]
Level = Literal["data-sheet", "sensor", "realistic", "real"]
ScooterLevel = Literal["data-sheet", "real"]
WheelchairLevel = Literal["sample", "real"]

app = sub_app("Simulate recordings with known truth.")


class _FolderOutputs:
    """Output files of one folder; the folder is made if necessary."""

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


NEXT = {
    "scooter": "mobility-imu scooter angles {0}/ride.csv.gz --geometry {0}/geometry.toml "
    "-o angles.csv",
    "wheelchair": "mobility-imu wheelchair velocity {0}/court.csv.gz --static "
    "{0}/static.csv.gz --straight {0}/straight.csv.gz --geometry {0}/geometry.toml "
    "-o velocity.csv",
    "walker": "mobility-imu walker calibrate {0}/tilts.csv.gz --geometry "
    "{0}/geometry.toml -o mount.toml",
}
"""Command that begins the analysis of each device's folder."""


def _summarize(device: str, folder: Path, seed: int, names: Sequence[str], quiet: bool) -> None:
    typed = f"./{folder}" if str(folder).startswith("-") else str(folder)
    lines = [
        f"simulated with seed {seed}: {', '.join(names)}",
        f"written: {folder}",
        f"next: {NEXT[device].format(shlex.quote(typed))}",
    ]
    summarize(lines, quiet)


@app.command("scooter")
def scooter(
    output: Folder,
    seed: Seed,
    course: Annotated[ScooterCourse, typer.Option(help="Course to drive.")] = "curves",
    level: Annotated[
        ScooterLevel,
        typer.Option(
            help="data-sheet: errors of the sensors as stated there; real: as in real recordings."
        ),
    ] = "data-sheet",
    quiet: Quiet = False,
) -> None:
    """A scooter drawn from the seed: a ride, two parked recordings, truth and reference."""
    from mobility_imu.simulation import bundle

    outputs = _FolderOutputs(output, bundle.SCOOTER_FILES)
    outputs.write(bundle.scooter_bundle(seed, course, level=level.replace("-", " ")))
    _summarize("scooter", output, seed, bundle.SCOOTER_FILES, quiet)


@app.command("wheelchair")
def wheelchair(
    output: Folder,
    seed: Seed,
    level: Annotated[
        WheelchairLevel,
        typer.Option(
            help="sample: noise and offsets like those of WheelMove-ID's sample; real: sensors as "
            "in real recordings, and a drive with pushes."
        ),
    ] = "sample",
    quiet: Quiet = False,
) -> None:
    """A chair with 19 degrees of camber on a court: three trials, truth and geometry."""
    from mobility_imu.simulation import bundle

    outputs = _FolderOutputs(output, bundle.WHEELCHAIR_FILES)
    outputs.write(bundle.wheelchair_bundle(seed, level=level))
    _summarize("wheelchair", output, seed, bundle.WHEELCHAIR_FILES, quiet)


@app.command("walker")
def walker(
    output: Folder,
    seed: Seed,
    course: Annotated[WalkerCourse, typer.Option(help="Course to walk.")] = "corridor",
    level: Annotated[
        Level,
        typer.Option(
            help="data-sheet: noise only; sensor: its other errors, too; realistic: also those of "
            "the frame; real: sensors as in real recordings."
        ),
    ] = "realistic",
    pose: Annotated[
        int, typer.Option(help="Pose of the IMU in the paper's Table 1.", min=1, max=5)
    ] = 1,
    quiet: Quiet = False,
) -> None:
    """A walking frame: tilts for the calibration, a walk, its truth, geometry and true mount."""
    from mobility_imu.simulation import bundle

    outputs = _FolderOutputs(output, bundle.WALKER_FILES)
    outputs.write(bundle.walker_bundle(seed, course, level=level.replace("-", " "), pose=pose))
    _summarize("walker", output, seed, bundle.WALKER_FILES, quiet)
