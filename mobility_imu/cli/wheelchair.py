"""Commands of the wheelchair: velocities, a check of the geometry, and tasks."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mobility_imu.cli.inputs import as_typed, check_reading, naming, read_input, tell_faults
from mobility_imu.cli.messages import summarize, warn
from mobility_imu.cli.options import (
    FillGaps,
    Quiet,
    Rate,
    Strict,
    Table,
    picture_file,
    sub_app,
    table_file,
)
from mobility_imu.cli.outputs import check_kinds, checked_outputs, table_bytes
from mobility_imu.errors import InputError, MissingExtraError, needs
from mobility_imu.files import Outputs, figure_bytes

if TYPE_CHECKING:
    from mobility_imu.faults import Fault
    from mobility_imu.readers.velocities import VelocitySeries
    from mobility_imu.recording import Recording
    from mobility_imu.wheelchair import (
        ChairVelocity,
        GeometryCheck,
        Tasks,
        TaskSettings,
        VelocitySettings,
        WheelchairCalibration,
        WheelchairGeometry,
    )

Camber = Literal["sign-safe", "printed"]
Smoothing = Literal["none", "moving-average", "savitzky-golay"]
Edge = Literal["covering", "tool"]
FILTER_WINDOW, FILTER_ORDER = 7, 2
FILTER_WORDS = {
    "moving average window = ": "--filter-window ",
    "Savitzky-Golay window = ": "--filter-window ",
    "Savitzky-Golay order = ": "--filter-order ",
    "from 0 to window - 1": "from 0 to one less than --filter-window",
}
"""Names of the filter's settings in the library's messages, and of the options."""
MOST_SCALE_PERCENT = 100.0
PICTURES = (".png", ".svg", ".pdf")

Trial = Annotated[
    Path,
    typer.Argument(
        help="Recording: a file, a session's folder, the common beginning of three Xsens exports, "
        "or frame=f.csv,left_wheel=l.csv,right_wheel=r.csv."
    ),
]
Static = Annotated[Path, typer.Option(help="Trial with the chair standing still.")]
Straight = Annotated[Path, typer.Option(help="Trial with the chair pushed straight forward.")]
Window = Annotated[int, typer.Option(help="Samples in the filter's window, odd.")]
Order = Annotated[int, typer.Option(help="Order of the Savitzky-Golay filter.")]
Geometry = Annotated[Path, typer.Option(help="TOML with a section [wheelchair].")]

app = sub_app("Manual wheelchair: velocities and tasks.")


@app.command("velocity")
def velocity(
    trial: Trial,
    static: Static,
    straight: Straight,
    geometry: Geometry,
    output: Table,
    camber: Annotated[
        Camber, typer.Option(help="Camber term: with the turn's sign, or eq. 1.16 as printed.")
    ] = "sign-safe",
    slip_correction: Annotated[
        bool,
        typer.Option(
            "--slip-correction/--no-slip-correction",
            help="Where the wheels disagree, take the speed from the one that rolls.",
        ),
    ] = False,
    smoothing: Annotated[
        Smoothing, typer.Option("--filter", help="Smooth every sensor of all three recordings.")
    ] = "none",
    filter_window: Window = FILTER_WINDOW,
    filter_order: Order = FILTER_ORDER,
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """Linear velocity and yaw rate of a chair from wheel and frame IMUs (WheelMove-ID)."""
    from mobility_imu.cli.summaries import read_line, velocity_lines, written_line
    from mobility_imu.wheelchair import (
        estimate_velocity,
        find_faults,
        smooth_recording,
    )
    from mobility_imu.wheelchair.faults import not_told, with_valid

    trials = (trial, static, straight)
    outputs = checked_outputs({"--output": output}, (*_files(trials), geometry))
    _tell_unused(smoothing, filter_window, filter_order)
    chair = _read_geometry(geometry)
    read = _read(trials, sampling_rate_hz, fill_gaps_s)
    of_filter = {"window": filter_window, "order": filter_order}
    with as_typed(FILTER_WORDS):
        drive, still, line = (smooth_recording(one, smoothing, **of_filter) for one in read)
    calibration = _calibrated(drive, still, line, take_off_offsets=camber != "printed")
    settings = _settings(camber, slip_correction)
    # Smoothing hides what repeats itself: faults are looked for in what was recorded.
    faults = find_faults(read[0], chair, calibration.mount, settings, offsets=calibration.offsets)
    of_line = _faults_of_trial(read[2])
    tell_faults((*_faults_of_trial(read[1]), *of_line, *faults), strict)
    with naming(faults):
        found = estimate_velocity(
            drive, chair, calibration.mount, settings, offsets=calibration.offsets
        )
        if smoothing != "none":
            found = _with_smoothing_sd(found, read, chair, settings, smoothing, of_filter)
    found = with_valid(found, faults)
    _warn_of_calibration(calibration, line, of_line)
    warn(not_told(found, drive, chair, calibration.mount, faults))
    outputs.write({output: table_bytes(found.to_frame(), output)})
    summarize([read_line(drive), *velocity_lines(found), written_line([output])], quiet)


def _read_geometry(path: Path) -> WheelchairGeometry:
    """Geometry of the chair; warns of a mount, which the trials show."""
    from mobility_imu.readers.geometry import find_table
    from mobility_imu.wheelchair import WheelchairGeometry

    geometry = WheelchairGeometry.from_toml(path)
    if find_table(path, "wheelchair.mount") is not None:
        told = "is not used: --static and --straight show the mount"
        warn([f"{path}: [wheelchair.mount] {told}"])
    return geometry


def _tell_unused(smoothing: Smoothing, window: int, order: int) -> None:
    """Warn of options that are given and that the filter does not use."""
    unused = ["--filter-window"] if smoothing == "none" and window != FILTER_WINDOW else []
    unused += ["--filter-order"] if smoothing != "savitzky-golay" and order != FILTER_ORDER else []
    warn(f"{name} has no effect with --filter {smoothing}" for name in unused)


def _settings(camber: Camber, slip_correction: bool) -> VelocitySettings:
    from mobility_imu.wheelchair import VelocitySettings

    if camber == "printed":
        return VelocitySettings(form="printed", slip_correction=slip_correction, slip_method="tool")
    return VelocitySettings(slip_correction=slip_correction)


def _with_smoothing_sd(
    smoothed: ChairVelocity,
    read: Sequence[Recording],
    chair: WheelchairGeometry,
    settings: VelocitySettings,
    method: Smoothing,
    of_filter: Mapping[str, int],
) -> ChairVelocity:
    """Velocities whose standard deviations count how far they are from those without the filter."""
    from mobility_imu.wheelchair import estimate_velocity, with_smoothing_sd

    drive, still, line = read
    own = _calibrated(drive, still, line, take_off_offsets=settings.form != "printed")
    plain = estimate_velocity(drive, chair, own.mount, settings, offsets=own.offsets)
    return with_smoothing_sd(smoothed, plain, chair, own.mount, method, **of_filter)


def _calibrated(
    drive: Recording, still: Recording, line: Recording, *, take_off_offsets: bool = True
) -> WheelchairCalibration:
    from mobility_imu.wheelchair import calibrate_mount

    # Here the straight-line trial's file can be named, which the mount does not know any more.
    for name in ("left_wheel", "right_wheel"):
        if name in drive.sensors:
            line.sensor(name, gyroscope=True)
    return calibrate_mount(still, line, take_off_offsets=take_off_offsets)


def _faults_of_trial(trial: Recording) -> list[Fault]:
    """Faults of a trial of the calibration, which uses no accelerometer of a wheel."""
    from mobility_imu.health import examine
    from mobility_imu.wheelchair.remarks import of_chair

    return [fault for fault in examine(of_chair(trial)) if "wheel_acc" not in fault.sensor]


def _warn_of_calibration(
    calibration: WheelchairCalibration, line: Recording, faults: Sequence[Fault]
) -> None:
    """Warn of what the calibration says and no fault of the straight-line trial does."""
    from mobility_imu.wheelchair.faults import ranges_told

    known = ranges_told(line, faults)
    warn(sentence for sentence in calibration.warnings if sentence not in known)


def _files(trials: tuple[Path, ...]) -> list[Path]:
    from mobility_imu.readers import recording_files

    return [file for trial in trials for file in recording_files(trial)]


def _read(
    trials: tuple[Path, ...], sampling_rate_hz: float | None, fill_gaps_s: float
) -> list[Recording]:
    return [read_input(trial, "wheelchair", sampling_rate_hz, fill_gaps_s) for trial in trials]


@app.command("check")
def check(
    trial: Annotated[Path, typer.Argument(help="Recording of a drive with turns to both sides.")],
    static: Static,
    straight: Straight,
    geometry: Geometry,
    gyroscope_scale_percent: Annotated[
        float,
        typer.Option(
            help="Standard deviation of the gyroscopes' scale factors: 1 as they leave the "
            "factory, 0.3 to 0.5 where the maker calibrates them."
        ),
    ] = 1.0,
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """Whether track, radii and camber fit what the frame's gyroscope says of the turns."""
    from mobility_imu.cli.summaries import check_lines, read_line
    from mobility_imu.wheelchair import check_geometry, find_faults
    from mobility_imu.wheelchair.faults import ranges_told

    if not 0 <= gyroscope_scale_percent <= MOST_SCALE_PERCENT:
        raise InputError(
            f"--gyroscope-scale-percent {gyroscope_scale_percent:g}: expected 0 to "
            f"{MOST_SCALE_PERCENT:g}"
        )
    chair = _read_geometry(geometry)
    drive, still, line = _read((trial, static, straight), sampling_rate_hz, fill_gaps_s)
    calibration = _calibrated(drive, still, line)
    faults = find_faults(drive, chair, calibration.mount, offsets=calibration.offsets)
    of_line = _faults_of_trial(line)
    tell_faults((*_faults_of_trial(still), *of_line, *faults), strict)
    with naming(faults):
        found = check_geometry(
            drive,
            chair,
            calibration.mount,
            offsets=calibration.offsets,
            gyr_scale_sd=gyroscope_scale_percent / 100,
        )
    _warn_of_calibration(calibration, line, of_line)
    told = {fault.sentence for fault in faults} | ranges_told(drive, faults)
    typer.echo(check_text(found, told))
    summarize([read_line(drive), *check_lines(found)], quiet)


def check_text(found: GeometryCheck, told: Collection[str] = ()) -> str:
    """Lines that ``wheelchair check`` prints.

    Parameters
    ----------
    found : GeometryCheck
    told : warnings that faults, told on the error stream, say already; they are left out here

    Returns
    -------
    str
    """
    import numpy as np

    def known(value: float, text: str) -> str:
        return "not found" if np.isnan(value) else text

    residual = float(np.rad2deg(found.residual_radps))
    lines = [
        "wheels' yaw rate against the frame's:",
        f"residual                    {known(residual, f'{residual:.2f} deg/s')}",
        f"correlation                 {known(found.correlation, f'{found.correlation:.4f}')}",
        f"gain                        {known(found.gain, f'{found.gain:.3f}')}",
        f"lag of the wheels           {known(found.lag_s, f'{found.lag_s:.3f} s')}",
    ]
    if found.judged:
        camber, camber_sd = np.rad2deg([found.camber_rad, found.camber_sd_rad])
        ways = (("left", found.yaw_gain_left), ("right", found.yaw_gain_right))
        lines += [
            f"wheels' yaw rate over the frame's, {f'{way} turns':<12} "
            + ("too few of them" if np.isnan(gain) else f"{gain:.3f}")
            for way, gain in ways
        ]
        lines += [
            f"track that fits the turns   {found.track_m:.4f} ± {found.track_sd_m:.4f} m",
            "right over left radius      "
            + known(
                found.radius_ratio,
                f"{found.radius_ratio:.4f} ± {found.radius_ratio_sd:.4f} times what is given",
            ),
            f"camber from the axles       {camber:.1f} ± {camber_sd:.1f} deg",
        ]
    if found.fits:
        lines.append("- the geometry fits")
    lines += [f"- {message}" for message in found.warnings if message not in told]
    return "\n".join(lines)


Events = Annotated[
    Path | None,
    typer.Option(
        help="Also write one row per task, as CSV: onset, end, distance, angle.",
        parser=table_file,
        metavar="PATH",
    ),
]
Picture = Annotated[
    Path | None,
    typer.Option(
        help="Also draw the chronogram (.png, .svg or .pdf).", parser=picture_file, metavar="PATH"
    ),
]


@app.command("tasks")
def tasks(
    velocity: Annotated[Path, typer.Argument(help="CSV with a linear and an angular velocity.")],
    output: Table,
    settings: Annotated[
        Path | None, typer.Option(help="JSON of thresholds; WheelMove-ID's files serve.")
    ] = None,
    edge: Annotated[
        Edge, typer.Option(help="First frames: windows that cover them, or as the public tool.")
    ] = "covering",
    figure: Picture = None,
    events: Events = None,
    direction: Annotated[
        bool, typer.Option("--direction", help="Add a column with the direction of rotations.")
    ] = False,
    sampling_rate_hz: Annotated[
        float | None, typer.Option(help="Hz; for files that have no time column.", min=1)
    ] = None,
    units: Annotated[
        str | None,
        typer.Option(help="Of both velocities, as 'm/s, deg/s'; for headers that state none."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Locomotor tasks and a chronogram from a chair's velocities (WheelMove-ID)."""
    inputs = (velocity,) if settings is None else (velocity, settings)
    outputs = Outputs({"--output": output, "--events": events, "--figure": figure}, inputs)
    check_kinds({"--output": output, "--events": events})
    if figure is not None and figure.suffix.lower() not in PICTURES:
        raise InputError(f"--figure {figure}: expected a name that ends in .png, .svg or .pdf")
    if figure is not None:
        _check_drawing(figure)  # before the work, not after it
    from mobility_imu.cli.summaries import tasks_lines, written_line
    from mobility_imu.wheelchair import task_events
    from mobility_imu.wheelchair.outcomes import turn_direction

    thresholds, series = read_series(velocity, settings, sampling_rate_hz, units)
    found = _identified(velocity, series, thresholds, edge)
    warn(found.warnings)
    table = found.to_frame()
    if direction:
        table["direction"] = turn_direction(found.codes, found.yaw_rate_radps)
    contents = {output: table_bytes(table, output)}
    if events is not None:
        rows = task_events(
            found.time_s,
            found.codes,
            found.linear_velocity_mps,
            found.yaw_rate_radps,
            valid=found.valid,
        )
        contents[events] = table_bytes(rows, events)
    if figure is not None:
        contents[figure] = _chronogram(found, figure)
    outputs.write(contents)
    rate = series.sampling_rate_hz
    read = f"read: {velocity}: {len(found) / rate:.1f} s at {rate:.5g} Hz"
    summarize([read, *tasks_lines(found), written_line(contents)], quiet)


def _check_drawing(figure: Path) -> None:
    """Check that the library that draws can be loaded.

    Parameters
    ----------
    figure : file of the picture

    Raises
    ------
    MissingExtraError
        If it is not installed.
    InputError
        If it is there and fails, as with a backend that it does not know.
    """
    try:
        needs("matplotlib")
    except MissingExtraError:
        raise
    except (ImportError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(
            f"--figure {figure}: matplotlib cannot be loaded ({reason}); mend it, or leave "
            "--figure out"
        ) from None


def _identified(
    velocity: Path, series: VelocitySeries, thresholds: TaskSettings, edge: Edge
) -> Tasks:
    """Tasks; an error names the file, and its clock where that may be the cause."""
    from mobility_imu.wheelchair import identify_tasks

    try:
        return identify_tasks(series, thresholds, edge=edge)
    except InputError as error:
        text = str(error) if str(velocity) in str(error) else f"{velocity}: {error}"
        if thresholds.segment_s * series.sampling_rate_hz < 1:
            text += "; are its times in s, and no count of samples?"
        raise InputError(text) from None


def read_series(
    velocity: Path,
    settings: Path | None,
    sampling_rate_hz: float | None,
    units: str | None = None,
) -> tuple[TaskSettings, VelocitySeries]:
    """Settings and velocities, on one sampling rate.

    Parameters
    ----------
    velocity : CSV of velocities
    settings : JSON of thresholds, or None for the document's
    sampling_rate_hz : Hz, for a CSV without a time column; None takes it from the settings
    units : of both velocities, for a CSV whose header states none

    Returns
    -------
    settings : TaskSettings
    series : VelocitySeries

    Raises
    ------
    InputError
        If the two files are faulty, or state different rates.
    """
    from mobility_imu.readers.velocities import read_velocities
    from mobility_imu.wheelchair import TaskSettings
    from mobility_imu.wheelchair.settings import read_named_settings

    check_reading(sampling_rate_hz)
    named = None if settings is None else read_named_settings(settings)
    stated_hz = None if named is None else named.sampling_rate_hz
    rate = stated_hz if sampling_rate_hz is None else sampling_rate_hz
    with as_typed({"units: got ": "--units: got "}):
        series = read_velocities(velocity, sampling_rate_hz=rate, units=units)
    if named is None:
        return TaskSettings(), series
    found_hz = series.sampling_rate_hz
    if stated_hz is not None and abs(stated_hz - found_hz) > 0.01 * found_hz:
        raise InputError(
            f"{settings}: freqAcq = {stated_hz:g} Hz, but {velocity} has {found_hz:g} Hz"
        )
    try:
        named.settings.frames(found_hz)
    except InputError as error:
        text = f"{settings}: {named.as_typed(error)}"
        if TaskSettings().segment_s * found_hz < 1:
            text += f"; has {velocity} its times in s, and no count of samples?"
        raise InputError(text) from None
    return named.settings, series


def _chronogram(found: Tasks, path: Path) -> bytes:
    import matplotlib as mpl

    mpl.use("agg")
    from matplotlib import pyplot as plt

    from mobility_imu.plots.wheelchair import chronogram

    drawing = chronogram(
        found.time_s,
        found.codes,
        found.linear_velocity_mps,
        found.yaw_rate_radps,
        valid=found.valid,
    )
    try:
        return figure_bytes(drawing, path)
    except RuntimeError as error:  # as of a LaTeX that is to set the text, and is not there
        reason = str(error).partition("\n")[0]
        raise InputError(
            f"--figure {path}: cannot be drawn ({reason}); mend the settings of matplotlib, or "
            "leave --figure out"
        ) from None
    finally:
        plt.close(drawing)
