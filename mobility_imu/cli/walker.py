"""Commands of the walking frame: mount of the IMU, and path with steps."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mobility_imu.cli.files import Outputs, csv_bytes
from mobility_imu.cli.options import FillGaps, Output, Smooth, sub_app
from mobility_imu.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

    from mobility_imu.walker import MountCalibration, Trajectory, WalkerGeometry

Method = Literal["four-tilts", "two-tilts", "all-samples"]
Form = Literal["corrected", "printed"]

app = sub_app("Walking frame: mount of the IMU, and path.")


@app.command("calibrate")
def calibrate(
    tilts: Annotated[Path, typer.Argument(help="Recording of the tilts: CSV with sensor 'frame'.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [walker].")],
    output: Output,
    method: Annotated[
        Method, typer.Option(help="The paper's two methods, or arcs fitted whole.")
    ] = "all-samples",
    form: Annotated[
        Form, typer.Option(help="The paper's methods: corrected, or as printed.")
    ] = "corrected",
    order: Annotated[
        str, typer.Option(help="Tilts as they were made; some may be missing in the recording.")
    ] = "front,back,right,left",
    smooth: Smooth = True,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """How the IMU is fixed to a walking frame, from tilting it (Doan & Pham).

    Let the frame stand for three seconds on level ground. Tilt it by 20 to 45 degrees to the front,
    back, right and left, about the tips of one side each time; let it stand for two seconds after
    each tilt.
    """
    from mobility_imu.readers import read_recording, recording_files
    from mobility_imu.walker import WalkerGeometry, calibrate_mount

    outputs = Outputs({"--output": output}, (*recording_files(tilts), geometry))
    frame = WalkerGeometry.from_toml(geometry)
    found = calibrate_mount(
        read_recording(tilts, fill_gaps_s=fill_gaps_s),
        frame,
        method=method,
        form=form,
        order=[name.strip() for name in order.split(",")],  # type: ignore[misc]
        smooth=smooth,
    )
    _warn(found.warnings)
    outputs.write({output: mount_to_toml(found, frame, method).encode()})


def _warn(messages: Iterable[str]) -> None:
    for message in messages:
        warnings.warn(message, stacklevel=1)


def mount_to_toml(found: MountCalibration, frame: WalkerGeometry, method: str) -> str:
    """Geometry and mount as the text of a geometry file.

    Parameters
    ----------
    found : MountCalibration
    frame : WalkerGeometry
    method : how the mount was found, for the comment

    Returns
    -------
    str
    """
    import numpy as np

    rotation = [[round(float(v), 6) for v in row] for row in found.mount.rotation_imu_to_body]
    place = [round(float(v), 4) for v in found.mount.translation_body_m]
    lines = [
        "[walker]",
        f"footprint_width_m = {frame.footprint_width_m}",
        f"footprint_length_m = {frame.footprint_length_m}",
        "",
        "[walker.mount]",
        f"# {method}: "
        + ", ".join(f"{t.direction} {np.rad2deg(t.angle_rad):.0f} deg" for t in found.tilts),
    ]
    if np.isfinite(found.translation_sd_m).all():
        place_sd = [round(float(value), 5) for value in found.translation_sd_m]
        turn_sd = [round(float(value), 5) for value in found.rotation_sd_rad]
        lines += [f"translation_sd_m = {place_sd}", f"rotation_sd_rad = {turn_sd}"]
    lines += [f"rotation_imu_to_body = {rotation}", f"translation_body_m = {place}"]
    return "\n".join(lines) + "\n"


@app.command("trajectory")
def trajectory(
    walk: Annotated[Path, typer.Argument(help="Recording of a walk: CSV with sensor 'frame'.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [walker.mount].")],
    output: Output,
    steps: Annotated[
        Path | None, typer.Option(help="Also write a table of the steps to this CSV file.")
    ] = None,
    smooth: Smooth = True,
    closed_loop: Annotated[
        bool,
        typer.Option(
            "--closed-loop",
            help="The walk ends where and as it began: a constraint, never evidence of accuracy.",
        ),
    ] = False,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """Path of a walking frame, and its lift-and-place steps (Doan & Pham).

    The recording begins with some seconds of rest. x points forward and y to the left as the frame
    stands at the start.
    """
    if closed_loop and not smooth:
        raise InputError("--closed-loop needs the smoother: it cannot be had with --no-smooth")
    from mobility_imu.readers import read_recording, recording_files
    from mobility_imu.walker import WalkerMount, estimate_trajectory
    from mobility_imu.walker.navigation import ClosedLoop

    files = (*recording_files(walk), geometry)
    outputs = Outputs({"--output": output, "--steps": steps}, files)
    mount = WalkerMount.from_toml(geometry)
    try:
        found = estimate_trajectory(
            read_recording(walk, fill_gaps_s=fill_gaps_s),
            mount,
            smooth=smooth,
            closed_loop=ClosedLoop() if closed_loop else None,
        )
    except InputError as error:
        raise InputError(str(error) if str(walk) in str(error) else f"{walk}: {error}") from None
    _warn(found.warnings)
    contents = {output: csv_bytes(found.to_frame(), output)}
    placed = steps_table(found, walk, needed=steps is not None)
    if steps is not None and placed is not None:
        contents[steps] = csv_bytes(placed, steps)
    outputs.write(contents)


def steps_table(found: Trajectory, walk: Path, *, needed: bool) -> pd.DataFrame | None:
    """Table of the steps of a path; a warning tells why there are none.

    Parameters
    ----------
    found : Trajectory
    walk : name of the recording, for messages
    needed : whether it is an error that steps cannot be found

    Returns
    -------
    DataFrame, or None if steps cannot be found
    """
    from mobility_imu.walker.steps import find_steps

    try:
        placed = find_steps(found)
    except InputError as error:
        if needed:
            raise InputError(f"{walk}: {error}") from None
        _warn([f"{walk}: no steps: {error}"])
        return None
    _warn(placed.warnings)
    if not len(placed):
        _warn([f"{walk}: no step found: is it a walk?"])
    return placed.to_frame()
