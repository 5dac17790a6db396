"""Commands of the walking frame: mount of the IMU, and path with steps."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from mobility_imu.cli.inputs import as_typed, naming, read_input, sd_in_degrees, tell_faults
from mobility_imu.cli.messages import summarize, warn
from mobility_imu.cli.options import (
    FillGaps,
    Output,
    Quiet,
    Rate,
    Smooth,
    Strict,
    Table,
    sub_app,
    table_file,
)
from mobility_imu.cli.outputs import MOUNT, checked_outputs, table_bytes
from mobility_imu.errors import InputError

Method = Literal["four-tilts", "two-tilts", "all-samples"]
Form = Literal["corrected", "printed"]

if TYPE_CHECKING:
    from pandas import DataFrame

    from mobility_imu.recording import Recording
    from mobility_imu.walker import (
        NavigationSettings,
        Steps,
        Trajectory,
        WalkerGeometry,
        WalkerMount,
    )

SCALE_PERCENT = (1e-4, 100.0)
"""Least and largest of ``--scale-percent``, as the settings of the path allow them."""

app = sub_app("Walking frame: mount of the IMU, and path.")
ScalePercent = Annotated[
    float,
    typer.Option(
        help="How well the sensor's scale factors are known (one standard deviation), and its axes "
        "to as many hundredths of a rad: 1 of cheap sensors, 0.3 where the maker calibrates each."
    ),
]


def _settings(scale_percent: float) -> NavigationSettings:
    from mobility_imu.walker import NavigationSettings

    least, most = SCALE_PERCENT
    if not least <= scale_percent <= most:
        raise InputError(f"--scale-percent {scale_percent:g}: expected {least:g} to {most:g}")
    return NavigationSettings(scale_sd=scale_percent / 100, axes_sd_rad=scale_percent / 100)


def _direction(name: str) -> str:
    """Name of a tilt, whose letters may be capitals; another name as it was typed."""
    from mobility_imu.walker.geometry import TILT_DIRECTIONS

    return name.lower() if name.lower() in TILT_DIRECTIONS else name


@app.command("calibrate")
def calibrate(
    tilts: Annotated[Path, typer.Argument(help="Recording of the tilts with sensor 'frame'.")],
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
    scale_percent: ScalePercent = 1.0,
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """How the IMU is fixed to a walking frame, from tilting it (Doan & Pham).

    Let the frame stand for three seconds on level ground. Tilt it by 20 to 45 degrees to the front,
    back, right and left, about the tips of one side each time; let it stand for two seconds after
    each tilt.
    """
    from mobility_imu.cli.summaries import read_line, walker_mount_lines, written_line
    from mobility_imu.readers import recording_files
    from mobility_imu.walker import (
        WalkerGeometry,
        calibrate_mount,
        find_tilt_faults,
    )
    from mobility_imu.walker.faults import not_told

    outputs = checked_outputs({"--output": output}, (*recording_files(tilts), geometry), MOUNT)
    if form != "corrected" and method == "all-samples":
        warn([f"--form has no effect with --method {method}"])
    frame = WalkerGeometry.from_toml(geometry)
    recording = read_input(tilts, "walker", sampling_rate_hz, fill_gaps_s)
    options: dict[str, Any] = {
        "method": method,
        "form": form,
        "order": [_direction(name.strip()) for name in order.split(",")],
        "smooth": smooth,
        "settings": _settings(scale_percent),
    }
    with as_typed({"order = ": "--order "}):
        faults = find_tilt_faults(recording, frame, **options)
    tell_faults(faults, strict)
    with naming(faults):
        found = calibrate_mount(recording, frame, **options)
    warn(_named(tilts, not_told(found.warnings, faults)))
    outputs.write({output: found.to_toml().encode()})
    summarize([read_line(recording), *walker_mount_lines(found), written_line([output])], quiet)


@app.command("trajectory")
def trajectory(
    walk: Annotated[Path, typer.Argument(help="Recording of a walk with sensor 'frame'.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [walker.mount].")],
    output: Table,
    steps: Annotated[
        Path | None,
        typer.Option(
            help="Also write a table of the steps to this CSV file.",
            parser=table_file,
            metavar="PATH",
        ),
    ] = None,
    rests: Annotated[
        Path | None,
        typer.Option(
            help="CSV time_s,stationary (0 or 1): the rests, where they are known; a path.csv does."
        ),
    ] = None,
    smooth: Smooth = True,
    closed_loop: Annotated[
        bool,
        typer.Option(
            "--closed-loop",
            help="The walk ends where and as it began: a constraint, never evidence of accuracy.",
        ),
    ] = False,
    scale_percent: ScalePercent = 1.0,
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """Path of a walking frame, and its lift-and-place steps (Doan & Pham).

    The recording begins with some seconds of rest. x points forward and y to the left as the frame
    stands at the start.
    """
    if closed_loop and not smooth:
        raise InputError("--closed-loop needs the smoother: it cannot be had with --no-smooth")
    from mobility_imu.cli.summaries import read_line, trajectory_lines, written_line
    from mobility_imu.readers import recording_files
    from mobility_imu.readers.rests import read_rests
    from mobility_imu.walker import WalkerMount

    files = (*recording_files(walk), geometry, *([] if rests is None else [rests]))
    outputs = checked_outputs({"--output": output, "--steps": steps}, files)
    mount = WalkerMount.from_toml(geometry)
    warn(sd_in_degrees(geometry, "[walker.mount] rotation_sd_rad", mount.rotation_sd_rad))
    recording = read_input(walk, "walker", sampling_rate_hz, fill_gaps_s)
    known = None if rests is None else read_rests(rests, recording.time_s)
    settings = _settings(scale_percent)
    options = {
        "settings": settings, "smooth": smooth, "closed_loop": closed_loop, "rests": known
    }  # fmt: skip
    found, table = _followed(walk, recording, _footprint(geometry), mount, options, strict)
    contents = {output: table_bytes(table, output)}
    placed = _steps(found, walk, needed=steps is not None)
    if steps is not None and placed is not None:
        contents[steps] = table_bytes(placed.to_frame(), steps)
    outputs.write(contents)
    lines = [read_line(recording), *trajectory_lines(found, placed), written_line(contents)]
    summarize(lines, quiet)


def _followed(
    walk: Path,
    recording: Recording,
    frame: WalkerGeometry | None,
    mount: WalkerMount,
    options: dict[str, Any],
    strict: bool,
) -> tuple[Trajectory, DataFrame]:
    """Path and its table, whose last column says where no fault touches it; faults are told."""
    from mobility_imu.walker import ClosedLoop, estimate_trajectory, find_faults, valid_samples
    from mobility_imu.walker.faults import not_told

    options = {**options, "closed_loop": ClosedLoop() if options["closed_loop"] else None}
    faults = find_faults(recording, frame, mount, **options)
    tell_faults(faults, strict)
    with naming(faults):
        try:
            found = estimate_trajectory(recording, frame, mount, **options)
        except InputError as error:
            text = str(error)
            raise InputError(text if str(walk) in text else f"{walk}: {text}") from None
    warn(_named(walk, not_told(found.warnings, faults)))
    return found, found.to_frame().assign(valid=valid_samples(found, faults).astype(int))


def _named(path: Path, texts: Iterable[str]) -> list[str]:
    """Sentences that begin with the file that they are of."""
    return [text if text.startswith(f"{path}: ") else f"{path}: {text}" for text in texts]


def _steps(found: Trajectory, walk: Path, *, needed: bool) -> Steps | None:
    """Steps of a path; None, with a warning, where none can be told and none are needed."""
    from mobility_imu.walker import find_steps

    try:
        placed = find_steps(found)
    except InputError as error:
        if needed:
            raise InputError(f"{walk}: {error}") from None
        warn([f"{walk}: no steps: {error}"])
        return None
    warn(f"{walk}: {text}" for text in placed.warnings)
    return placed


def _footprint(path: Path) -> WalkerGeometry | None:
    """Footprint of a geometry file; None if the file has a mount alone."""
    from mobility_imu.readers.geometry import find_table
    from mobility_imu.walker import WalkerGeometry

    section = find_table(path, "walker") or {}
    stated = any(not isinstance(value, dict) for value in section.values())
    return WalkerGeometry.from_toml(path) if stated else None
