"""Command line: from a recording to angles, velocities, tasks, and the papers' numbers checked.

Exit code 0: done. Exit code 2: the input or an argument is at fault; one line on stderr says
what, and no output file is left behind.
"""

from __future__ import annotations

import gzip
import json
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from mobility_imu import __version__
from mobility_imu.errors import InputError, MobilityImuError

if TYPE_CHECKING:
    import pandas as pd

    from mobility_imu.frames import FloatArray
    from mobility_imu.recording import Recording
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.calibration import ScooterMounting
    from mobility_imu.scooter.fusion import FusedAngles

app = typer.Typer(
    name="mobility-imu",
    help="Angles, tasks and paths of mobility aids from inertial sensors (IMUs).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # [walker] in a help text is a section's name, not a style
)
scooter_app = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="Mobility scooter: steering and throttle."
)
wheelchair_app = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="Manual wheelchair: velocities and tasks."
)
walker_app = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="Walking frame: mount of the IMU, and path."
)
simulate_app = typer.Typer(
    no_args_is_help=True, rich_markup_mode=None, help="Recordings with known truth."
)
app.add_typer(scooter_app, name="scooter")
app.add_typer(wheelchair_app, name="wheelchair")
app.add_typer(walker_app, name="walker")
app.add_typer(simulate_app, name="simulate")


class Method(StrEnum):
    """How scooter angles are estimated."""

    closed_form = "closed-form"
    fusion = "fusion"


class Form(StrEnum):
    """Which closed form."""

    three_axis = "three-axis"
    printed = "printed"


class Camber(StrEnum):
    """Which form of the camber term."""

    sign_safe = "sign-safe"
    printed = "printed"


class Smoothing(StrEnum):
    """Filter on the sensors of a chair, before everything else."""

    none = "none"
    moving_average = "moving-average"
    savitzky_golay = "savitzky-golay"


class Edge(StrEnum):
    """Who votes on a trial's first frames."""

    covering = "covering"
    tool = "tool"


class MountMethod(StrEnum):
    """How a walking frame's tilts are used."""

    four_tilts = "four-tilts"
    two_tilts = "two-tilts"
    all_samples = "all-samples"


class TiltForm(StrEnum):
    """Which form of eqs 12 and 15 to 17."""

    corrected = "corrected"
    printed = "printed"


class FrameCourse(StrEnum):
    """What a simulated walking frame walks."""

    corridor = "corridor"
    rectangle = "rectangle"
    timed_up_and_go = "timed-up-and-go"


class FrameLevel(StrEnum):
    """What goes wrong in a simulated walk."""

    data_sheet = "data-sheet"
    sensor = "sensor"
    realistic = "realistic"


class Work(StrEnum):
    """The three works."""

    scooter = "scooter"
    wheelchair = "wheelchair"
    walker = "walker"


Output = Annotated[Path, typer.Option("--output", "-o", help="File to write.")]
Rate = Annotated[
    float, typer.Option(help="Hz; for formats that have no clock (WheelMove-ID, Xsens).", min=1)
]
FillGaps = Annotated[
    float, typer.Option(help="Fill gaps up to this length (s) by interpolation; 0 refuses any.")
]


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mobility-imu {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Angles, tasks and paths of mobility aids from inertial sensors (IMUs)."""


@scooter_app.command("angles")
def scooter_angles(
    recording: Annotated[Path, typer.Argument(help="CSV with sensors 'lever' and 'body'.")],
    geometry: Annotated[
        Path, typer.Option(help="TOML with [scooter]; with [scooter.mount], that is applied.")
    ],
    output: Output,
    single_imu: Annotated[
        bool, typer.Option("--single-imu", help="Use the lever's IMU alone (level ground).")
    ] = False,
    method: Annotated[
        Method, typer.Option(help="Closed form, or gyroscopes as well (filter and smoother).")
    ] = Method.closed_form,
    form: Annotated[
        Form, typer.Option(help="Closed form: all three axes, or eqs 6 and 7 as printed.")
    ] = Form.three_axis,
    median_window: Annotated[
        int, typer.Option(help="Closed form: samples of the running median, odd; 1 for none.")
    ] = 25,
    acc_noise_mps2: Annotated[
        float | None,
        typer.Option(
            help="Noise (1 sd, per axis) of each accelerometer, m/s²; closed form: after the "
            "median. Fusion takes it from the recording if it is not given.",
            min=0,
        ),
    ] = None,
    causal: Annotated[
        bool, typer.Option("--causal", help="Fusion: use the past only, no smoother.")
    ] = False,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """Steering and throttle angles from one or two IMUs (Suzurikawa et al. 2022).

    With the closed form the columns steering_sd_deg and throttle_sd_deg stay empty unless
    --acc-noise-mps2 is given.
    """
    import numpy as np
    import pandas as pd

    from mobility_imu.readers import read_recording
    from mobility_imu.recording import frozen_samples, saturated_samples
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.calibration import read_mounting

    scooter = ScooterGeometry.from_toml(geometry)
    mounting = read_mounting(geometry)
    ride = read_recording(recording, fill_gaps_s=fill_gaps_s)
    names = ["lever"] if single_imu else ["lever", "body"]
    if not single_imu and "body" not in ride.sensors:
        raise InputError(
            f"{recording}: no sensor 'body'; with the lever's IMU alone give --single-imu"
        )
    if method is Method.fusion and single_imu:
        raise InputError("--method fusion needs both IMUs: it cannot be had with --single-imu")
    usable = np.ones(len(ride), bool)
    for name in names:
        acc = ride.sensor(name).acc_mps2
        for what, bad in (
            ("is frozen", frozen_samples(acc, ride.sampling_rate_hz)),
            ("is saturated", saturated_samples(acc)),
        ):
            if bad.any():
                warnings.warn(
                    f"{recording}: {name}_acc {what} in {int(bad.sum())} samples, first at "
                    f"{ride.time_s[np.argmax(bad)]:g} s; they are marked as not valid",
                    stacklevel=1,
                )
                usable &= ~bad
    try:
        angles: tuple[Any, ...]
        if method is Method.fusion:
            angles = _fused(ride, scooter, mounting, acc_noise_mps2, causal)
        else:
            angles = _closed_form(
                ride, scooter, mounting, names, form, median_window, acc_noise_mps2
            )
    except InputError as error:
        raise InputError(f"{recording}: {error}") from None
    steering, throttle, steering_sd, throttle_sd, valid = angles
    table = pd.DataFrame(
        {
            "time_s": ride.time_s,
            "steering_deg": np.rad2deg(steering),
            "throttle_deg": np.rad2deg(throttle),
            "steering_sd_deg": np.rad2deg(steering_sd),
            "throttle_sd_deg": np.rad2deg(throttle_sd),
            "valid": (valid & usable).astype(int),
        }
    )
    _write_tables({output: table})


def _closed_form(
    ride: Recording,
    scooter: ScooterGeometry,
    mounting: ScooterMounting | None,
    names: list[str],
    form: Form,
    median_window: int,
    acc_noise_mps2: float | None,
) -> tuple[Any, ...]:
    import numpy as np

    from mobility_imu.filters import median_filter
    from mobility_imu.scooter import estimate_angles
    from mobility_imu.scooter.angles import angle_standard_deviations

    span = median_window / ride.sampling_rate_hz
    if median_window > 1 and not 0.2 <= span <= 0.3:
        odd = 2 * round(0.25 * ride.sampling_rate_hz / 2 - 0.5) + 1
        warnings.warn(
            f"a median of {median_window} samples is {span:.3g} s long at "
            f"{ride.sampling_rate_hz:g} Hz, the paper's is 0.25 s: --median-window {odd} would be",
            stacklevel=1,
        )
    acc = {name: median_filter(ride.sensor(name).acc_mps2, median_window) for name in names}
    lever, body = acc["lever"], acc.get("body")
    if mounting is not None:
        lever, body = mounting.lever(lever), None if body is None else mounting.body(body)
    angles = estimate_angles(lever, body, scooter, form=form.value)
    sd: tuple[FloatArray, ...] = (np.full(len(ride), np.nan),) * 2
    if acc_noise_mps2 is not None:
        sd = angle_standard_deviations(
            lever,
            angles.steering_rad,
            angles.throttle_rad,
            scooter,
            lever_sd_mps2=acc_noise_mps2,
            body_sd_mps2=0.0 if body is None else acc_noise_mps2,
        )
    return angles.steering_rad, angles.throttle_rad, *sd, angles.valid


def _fused(
    ride: Recording,
    scooter: ScooterGeometry,
    mounting: ScooterMounting | None,
    acc_noise_mps2: float | None,
    causal: bool,
) -> FusedAngles:
    import numpy as np

    from mobility_imu.scooter.fusion import FusionSettings, fuse_angles

    lever, body = ride.sensor("lever", gyroscope=True), ride.sensor("body", gyroscope=True)
    lever_acc, lever_gyr = lever.acc_mps2, np.asarray(lever.gyr_radps)
    body_acc, body_gyr = body.acc_mps2, np.asarray(body.gyr_radps)
    if mounting is not None:
        lever_acc, lever_gyr = mounting.lever(lever_acc), mounting.lever(lever_gyr)
        body_acc, body_gyr = mounting.body(body_acc), mounting.body(body_gyr)
    return fuse_angles(
        lever_acc,
        lever_gyr,
        body_acc,
        body_gyr,
        ride.sampling_rate_hz,
        scooter,
        # The filter's noise is that of the difference of both sensors.
        FusionSettings(acc_sd_mps2=None if acc_noise_mps2 is None else acc_noise_mps2 * 2**0.5),
        smooth=not causal,
    )


@scooter_app.command("calibrate")
def scooter_calibrate(
    parked: Annotated[
        list[Path], typer.Argument(help="Parked recordings, one per place; two places or more.")
    ],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [scooter].")],
    poses: Annotated[
        Path, typer.Option(help="CSV steering_deg,throttle_deg: the poses, in order.")
    ],
    output: Output,
) -> None:
    """How both IMUs are mounted, from parked poses with the controls at their stops.

    Park, move the controls through the poses, hold each for two seconds. Do it on level ground and
    on a ramp: level ground alone does not show a turn of the body's IMU about the vertical.
    """
    import numpy as np

    from mobility_imu.readers import read_recording
    from mobility_imu.readers.table import parse_numbers, pick_columns, read_text
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.calibration import calibrate_mounting, parked_poses

    scooter = ScooterGeometry.from_toml(geometry)
    header, values = parse_numbers(read_text(poses), separator=",", source=str(poses))
    columns = pick_columns(header, values, ["steering_deg", "throttle_deg"], str(poses))
    if not np.isfinite(columns).all():
        raise InputError(f"{poses}: an angle is missing")
    settings = [(float(s), float(t)) for s, t in np.deg2rad(columns)]
    found = [pose for path in parked for pose in parked_poses(read_recording(path), settings)]
    mounting = calibrate_mounting(found, scooter)
    for name in mounting.unseen:
        warnings.warn(
            f"the poses tell little of the turn of the {name}: park at another slope as well",
            stacklevel=1,
        )
    matrices = {
        key: [[round(float(v), 6) for v in row] for row in getattr(mounting, key)]
        for key in ("rotation_lever_imu_to_lever", "rotation_body_imu_to_body")
    }
    sd = ", ".join(f"{value:.2f}" for value in np.rad2deg(mounting.sd_rad))
    lines = [
        "[scooter]",
        f"steering_inclination_deg = {np.rad2deg(scooter.steering_inclination_rad):.6g}",
        f"lever_inclination_deg = {np.rad2deg(scooter.lever_inclination_rad):.6g}",
        "",
        "[scooter.mount]",
        f"# sd in deg about x, y, z of the lever's, then the body's IMU: {sd}",
        *(f"{key} = {value}" for key, value in matrices.items()),
    ]
    with _new_file(output) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n")


@wheelchair_app.command("velocity")
def wheelchair_velocity(
    trial: Annotated[
        Path, typer.Argument(help="Recording, or the common beginning of three Xsens exports.")
    ],
    static: Annotated[Path, typer.Option(help="Trial with the chair standing still.")],
    straight: Annotated[Path, typer.Option(help="Trial with the chair pushed straight forward.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [wheelchair].")],
    output: Output,
    camber: Annotated[
        Camber, typer.Option(help="Camber term: with the turn's sign, or eq. 1.16 as printed.")
    ] = Camber.sign_safe,
    slip_correction: Annotated[
        bool,
        typer.Option(
            "--slip-correction/--no-slip-correction",
            help="Where wheels slip, integrate the frame's acceleration instead.",
        ),
    ] = False,
    smoothing: Annotated[
        Smoothing, typer.Option("--filter", help="Smooth every sensor of all three recordings.")
    ] = Smoothing.none,
    filter_window: Annotated[int, typer.Option(help="Samples in the filter's window, odd.")] = 7,
    filter_order: Annotated[int, typer.Option(help="Order of the Savitzky-Golay filter.")] = 2,
    sampling_rate_hz: Rate = 100.0,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """Linear velocity and yaw rate of a chair from wheel and frame IMUs (WheelMove-ID)."""
    from mobility_imu.readers import read_recording
    from mobility_imu.wheelchair import WheelchairGeometry, calibrate, estimate_velocity

    chair = WheelchairGeometry.from_toml(geometry)
    drive, still, line = (
        _smoothed(
            read_recording(path, sampling_rate_hz=sampling_rate_hz, fill_gaps_s=fill_gaps_s),
            smoothing,
            filter_window,
            filter_order,
        )
        for path in (trial, static, straight)
    )
    velocity = estimate_velocity(
        drive,
        calibrate(still, line),
        chair,
        camber=camber.value,
        slip_correction=slip_correction,
    )
    _write_tables({output: velocity.to_frame()})


def _smoothed(recording: Recording, how: Smoothing, window: int, order: int) -> Recording:
    from mobility_imu.filters import moving_average, savitzky_golay
    from mobility_imu.recording import Imu, Recording

    if how is Smoothing.none:
        return recording

    def smooth(values: FloatArray) -> FloatArray:
        if how is Smoothing.moving_average:
            return moving_average(values, window)
        return savitzky_golay(values, window, order)

    sensors = {
        name: Imu(smooth(imu.acc_mps2), None if imu.gyr_radps is None else smooth(imu.gyr_radps))
        for name, imu in recording.sensors.items()
    }
    return Recording(recording.time_s, sensors, source=recording.source)


@wheelchair_app.command("check")
def wheelchair_check(
    trial: Annotated[Path, typer.Argument(help="Recording of a drive with turns to both sides.")],
    static: Annotated[Path, typer.Option(help="Trial with the chair standing still.")],
    straight: Annotated[Path, typer.Option(help="Trial with the chair pushed straight forward.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [wheelchair].")],
    sampling_rate_hz: Rate = 100.0,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """Whether track, radii and camber fit what the frame's gyroscope says of the turns."""
    import numpy as np

    from mobility_imu.readers import read_recording
    from mobility_imu.wheelchair import WheelchairGeometry, calibrate
    from mobility_imu.wheelchair.check import check_geometry

    chair = WheelchairGeometry.from_toml(geometry)
    drive, still, line = (
        read_recording(path, sampling_rate_hz=sampling_rate_hz, fill_gaps_s=fill_gaps_s)
        for path in (trial, static, straight)
    )
    found = check_geometry(drive, calibrate(still, line), chair)
    typer.echo(f"wheels' yaw rate over the frame's, left turns   {found.yaw_gain_left:.3f}")
    typer.echo(f"wheels' yaw rate over the frame's, right turns  {found.yaw_gain_right:.3f}")
    typer.echo(f"track that fits the turns   {found.track_m:.4f} ± {found.track_sd_m:.4f} m")
    typer.echo(
        f"right over left radius      {found.radius_ratio:.4f} ± {found.radius_ratio_sd:.4f}"
    )
    camber, camber_sd = np.rad2deg([found.camber_rad, found.camber_sd_rad])
    typer.echo(f"camber from the axles       {camber:.1f} ± {camber_sd:.1f} deg")
    for message in found.messages or ("the geometry fits",):
        typer.echo(f"- {message}")


@wheelchair_app.command("tasks")
def wheelchair_tasks(
    velocity: Annotated[Path, typer.Argument(help="CSV with a linear and an angular velocity.")],
    output: Output,
    settings: Annotated[
        Path | None, typer.Option(help="JSON of thresholds; WheelMove-ID's files serve.")
    ] = None,
    edge: Annotated[
        Edge, typer.Option(help="First frames: windows that cover them, or as the public tool.")
    ] = Edge.covering,
    figure: Annotated[
        Path | None, typer.Option(help="Also draw the chronogram (.png, .svg or .pdf).")
    ] = None,
    events: Annotated[
        Path | None, typer.Option(help="Also write one row per task: onset, end, distance, angle.")
    ] = None,
    direction: Annotated[
        bool, typer.Option("--direction", help="Add a column with the direction of rotations.")
    ] = False,
    sampling_rate_hz: Annotated[
        float | None, typer.Option(help="Hz; for files that have no time column.", min=1)
    ] = None,
) -> None:
    """Locomotor tasks and a chronogram from a chair's velocities (WheelMove-ID)."""
    import numpy as np
    import pandas as pd

    from mobility_imu.outcomes import task_events, turn_direction
    from mobility_imu.readers.velocities import read_velocities
    from mobility_imu.wheelchair import Task, TaskSettings, identify_tasks
    from mobility_imu.wheelchair.tasks import read_settings

    thresholds, stated_rate = (
        (TaskSettings(), None) if settings is None else read_settings(settings)
    )
    series = read_velocities(velocity, sampling_rate_hz=sampling_rate_hz or stated_rate)
    rate = series.sampling_rate_hz
    if stated_rate and abs(stated_rate - rate) > 0.01 * rate:
        raise InputError(
            f"{settings}: freqAcq = {stated_rate:g} Hz, but {velocity} has {rate:g} Hz"
        )
    codes = identify_tasks(
        series.linear_velocity_mps, series.yaw_rate_radps, rate, thresholds, edge=edge.value
    )
    names = np.array(["", *(task.title for task in Task)])
    table = pd.DataFrame(
        {
            "time_s": series.time_s,
            "linear_velocity_mps": series.linear_velocity_mps,
            "yaw_rate_degps": np.rad2deg(series.yaw_rate_radps),
            "task_code": codes,
            "task": names[codes],
        }
    )
    if direction:
        table["direction"] = turn_direction(codes, series.yaw_rate_radps)
    tables = {output: table}
    if events is not None:
        tables[events] = task_events(
            series.time_s, codes, series.linear_velocity_mps, series.yaw_rate_radps
        )
    if figure is None:
        _write_tables(tables)
        return
    if figure.suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"--figure {figure}: expected a name that ends in .png, .svg or .pdf")
    import matplotlib as mpl

    mpl.use("agg")
    from mobility_imu.plots.wheelchair import chronogram

    drawing = chronogram(series.time_s, codes, series.linear_velocity_mps, series.yaw_rate_radps)
    with _new_file(figure) as unfinished:
        drawing.savefig(unfinished, format=figure.suffix[1:], dpi=150)
        _write_tables(tables)


@walker_app.command("calibrate")
def walker_calibrate(
    tilts: Annotated[Path, typer.Argument(help="Recording of the tilts: CSV with sensor 'frame'.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [walker].")],
    output: Output,
    method: Annotated[
        MountMethod, typer.Option(help="The paper's two methods, or arcs fitted whole.")
    ] = MountMethod.all_samples,
    form: Annotated[
        TiltForm, typer.Option(help="The paper's methods: corrected, or as printed.")
    ] = TiltForm.corrected,
    order: Annotated[
        str, typer.Option(help="Tilts as they were made; some may be missing in the recording.")
    ] = "front,back,right,left",
    smooth: Annotated[
        bool, typer.Option("--smooth/--no-smooth", help="Smooth the path, or filter only.")
    ] = True,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """How the IMU is fixed to a walking frame, from tilting it (Doan & Pham).

    Let the frame stand for three seconds on level ground. Tilt it by 20 to 45 degrees to the front,
    back, right and left, about the tips of one side each time; let it stand for two seconds after
    each tilt.
    """
    import numpy as np

    from mobility_imu.readers import read_recording
    from mobility_imu.walker import WalkerGeometry, calibrate_mount

    frame = WalkerGeometry.from_toml(geometry)
    recording = read_recording(tilts, fill_gaps_s=fill_gaps_s)
    found = calibrate_mount(
        recording,
        frame,
        method=method.value,
        form=form.value,
        order=[name.strip() for name in order.split(",")],  # type: ignore[misc]
        smooth=smooth,
    )
    for said in found.warnings:
        warnings.warn(said, stacklevel=1)
    rotation = [[round(float(v), 6) for v in row] for row in found.mount.rotation_imu_to_body]
    place = [round(float(v), 4) for v in found.mount.translation_body_m]
    lines = [
        "[walker]",
        f"footprint_width_m = {frame.footprint_width_m}",
        f"footprint_length_m = {frame.footprint_length_m}",
        "",
        "[walker.mount]",
        f"# {method.value}: "
        + ", ".join(f"{t.direction} {np.rad2deg(t.angle_rad):.0f} deg" for t in found.tilts),
    ]
    if np.isfinite(found.translation_sd_m).all():
        place_sd = [round(float(value), 5) for value in found.translation_sd_m]
        turn_sd = [round(float(value), 5) for value in found.rotation_sd_rad]
        lines += [f"translation_sd_m = {place_sd}", f"rotation_sd_rad = {turn_sd}"]
    lines += [f"rotation_imu_to_body = {rotation}", f"translation_body_m = {place}"]
    with _new_file(output) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n")


@walker_app.command("trajectory")
def walker_trajectory(
    walk: Annotated[Path, typer.Argument(help="Recording of a walk: CSV with sensor 'frame'.")],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [walker.mount].")],
    output: Output,
    steps: Annotated[
        Path | None, typer.Option(help="Also write a table of the steps to this CSV file.")
    ] = None,
    smooth: Annotated[
        bool, typer.Option("--smooth/--no-smooth", help="Smooth the path, or filter only.")
    ] = True,
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
    from mobility_imu.readers import read_recording
    from mobility_imu.walker import WalkerMount, estimate_trajectory
    from mobility_imu.walker.gait import find_steps
    from mobility_imu.walker.navigation import ClosedLoop

    if closed_loop and not smooth:
        raise InputError("--closed-loop needs the smoother: it cannot be had with --no-smooth")
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
    for said in found.warnings:
        warnings.warn(said, stacklevel=1)
    tables = {output: found.to_frame()}
    try:
        placed = find_steps(found)
    except InputError as error:
        if steps is not None:
            raise InputError(f"{walk}: {error}") from None
        warnings.warn(f"{walk}: no steps: {error}", stacklevel=1)
    else:
        for said in placed.warnings:
            warnings.warn(said, stacklevel=1)
        if not len(placed):
            warnings.warn(f"{walk}: no step found: is it a walk?", stacklevel=1)
        if steps is not None:
            tables[steps] = placed.to_frame()
    _write_tables(tables)


@simulate_app.command("scooter")
def simulate_scooter(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write into.")],
    seed: Annotated[int, typer.Option(help="The same seed gives the same bytes.")],
    course: Annotated[
        str, typer.Option(help="straight, curves, slopes, side or tactile.")
    ] = "curves",
) -> None:
    """A scooter drawn from the seed: a ride, two parked recordings, truth and reference."""
    import numpy as np
    import pandas as pd

    from mobility_imu.simulation.scooter import (
        COURSES,
        draw_driver,
        draw_scooter,
        simulate_parked,
        simulate_ride,
    )

    if course not in COURSES:
        raise InputError(f"--course {course}: expected one of {', '.join(COURSES)}")
    unit = draw_scooter(seed)
    ride = simulate_ride(COURSES[course], seed=seed, unit=unit, driver=draw_driver(seed))
    poses = np.array([(50, 0), (50, 40), (0, 40), (0, 0), (-50, 0), (-50, 40)], float)
    settings = [(float(s), float(t)) for s, t in np.deg2rad(poses)]
    output.mkdir(parents=True, exist_ok=True)
    tables = {
        output / "ride.csv.gz": ride.recording.to_frame(),
        output / "truth.csv.gz": ride.truth(),
        output / "reference.csv.gz": pd.DataFrame(
            {
                "time_s": ride.reference_time_s,
                "steering_deg": np.rad2deg(ride.reference[:, 0]),
                "throttle_deg": np.rad2deg(ride.reference[:, 1]),
            }
        ),
        output / "poses.csv": pd.DataFrame(poses, columns=["steering_deg", "throttle_deg"]),
    }
    for k, (place, pitch) in enumerate((("level", 0.0), ("ramp", np.deg2rad(5)))):
        parked = simulate_parked(
            settings, pitch_rad=pitch, bank_rad=0, seed=10 * seed + k, unit=unit
        )
        tables[output / f"parked_{place}.csv.gz"] = parked.to_frame()
    with _new_file(output / "geometry.toml") as unfinished:
        unfinished.write_text(
            "[scooter]\nsteering_inclination_deg = 20.0\nlever_inclination_deg = 9.0\n"
        )
        _write_tables(tables)


@simulate_app.command("wheelchair")
def simulate_wheelchair(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write into.")],
    seed: Annotated[int, typer.Option(help="The same seed gives the same bytes.")],
) -> None:
    """A chair with 19 degrees of camber on a court: three trials, truth and geometry."""
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
    output.mkdir(parents=True, exist_ok=True)
    tables = {
        output / f"{name}.csv.gz": drive.recording.to_frame() for name, drive in drives.items()
    }
    tables[output / "truth.csv.gz"] = drives["court"].truth()
    with _new_file(output / "geometry.toml") as unfinished:
        unfinished.write_text(
            "[wheelchair]\n"
            "camber_deg = 19.0\n"
            f"wheel_radius_left_m = {chair.wheel_radius_left_m}\n"
            f"wheel_radius_right_m = {chair.wheel_radius_right_m}\n"
            f"track_m = {chair.track_m}\n"
        )
        _write_tables(tables)


@simulate_app.command("walker")
def simulate_walker(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write into.")],
    seed: Annotated[int, typer.Option(help="The same seed gives the same bytes.")],
    course: Annotated[FrameCourse, typer.Option(help="What is walked.")] = FrameCourse.corridor,
    level: Annotated[
        FrameLevel, typer.Option(help="Noise only, errors of the sensor, of the frame as well.")
    ] = FrameLevel.realistic,
    pose: Annotated[int, typer.Option(help="Mounting of the paper's Table 1.", min=1, max=5)] = 1,
) -> None:
    """A walking frame: tilts for the calibration, a walk, its truth, geometry and true mount."""
    import numpy as np
    import pandas as pd

    from mobility_imu.reproduction.walker.studies import LEVELS, tilt_run
    from mobility_imu.reproduction.walker.tables import pose_mount
    from mobility_imu.simulation import walker

    chosen = LEVELS[level.value.replace("-", " ")]
    tilts, tape = tilt_run(seed, str(pose), chosen)
    path = getattr(walker, course.name.upper())
    walk = walker.attach_imu(
        walker.simulate_walk(path, seed=seed, imperfections=chosen.imperfections),
        pose_mount(str(pose)),
        chosen.sensor,
        seed=100 * seed + pose,
        unit_seed=10 * seed + pose,  # the sensor of the tilts
    )
    forward = walk.rotation_body_to_world[:, :, 0]
    truth = pd.DataFrame(
        {
            "time_s": walk.recording.time_s,
            **{f"{axis}_m": walk.position_body_m[:, k] for k, axis in enumerate("xyz")},
            "yaw_deg": np.rad2deg(np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))),
            "stationary": walk.stationary.astype(int),
        }
    )
    output.mkdir(parents=True, exist_ok=True)
    footprint = (
        f"[walker]\nfootprint_width_m = {tape.footprint_width_m:.4f}\n"
        f"footprint_length_m = {tape.footprint_length_m:.4f}\n"
    )
    rotation = [[round(float(v), 6) for v in row] for row in walk.mount.rotation_imu_to_body]
    place = [round(float(v), 4) for v in walk.mount.translation_body_m]
    true_mount = (
        f"{footprint}\n[walker.mount]\nrotation_imu_to_body = {rotation}\n"
        f"translation_body_m = {place}\n"
    )
    with (
        _new_file(output / "geometry.toml") as unfinished,
        _new_file(output / "true_mount.toml") as beside,
    ):
        unfinished.write_text(footprint)
        beside.write_text(true_mount)
        _write_tables(
            {
                output / "tilts.csv.gz": tilts.recording.to_frame(),
                output / "walk.csv.gz": walk.recording.to_frame(),
                output / "truth.csv.gz": truth,
            }
        )


@app.command()
def reproduce(
    work: Annotated[Work | None, typer.Option(help="Only one of the works.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="JSON instead of a table.")] = False,
    everything: Annotated[
        bool, typer.Option("--all", help="All rows of the table, not only those that differ.")
    ] = False,
) -> None:
    """The scorecard: what the works print beside our numbers, with a verdict."""
    from rich.console import Console
    from rich.progress import Progress

    from mobility_imu.reproduction.scorecard import print_scorecard, scorecard, to_records

    # Rich draws the bar on a terminal only, so a log file stays clean.
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("computing", total=None)
        outcomes = scorecard(
            work.value if work else None,
            progress=lambda done, of: bar.update(task, completed=done, total=of),
        )
    if as_json:
        typer.echo(json.dumps(to_records(outcomes), indent=2, ensure_ascii=False))
    else:
        print_scorecard(outcomes, everything=everything)


@contextmanager
def _new_file(path: Path) -> Iterator[Path]:
    """Give a file to write; it gets its name only when all went well."""
    if not path.parent.is_dir():
        raise InputError(f"{path.parent}: no such folder to write {path.name} into")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        os.close(handle)
        unfinished = Path(name)
        try:
            yield unfinished
            os.chmod(unfinished, 0o644)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


def _write_tables(tables: dict[Path, pd.DataFrame]) -> None:
    """Write CSV files, all or none; names in .gz are packed, the same bytes each time."""
    if not tables:
        return
    path, table = next(iter(tables.items()))
    with _new_file(path) as unfinished:
        text = table.to_csv(index=False, float_format="%.6f").encode()
        unfinished.write_bytes(gzip.compress(text, mtime=0) if path.suffix == ".gz" else text)
        _write_tables({other: tables[other] for other in tables if other != path})


def _fail(message: str) -> NoReturn:
    print("mobility-imu: " + " ".join(message.split()), file=sys.stderr)
    sys.exit(2)


def main() -> None:
    """Run the command line; faults of the input end with one line and exit code 2."""
    warnings.showwarning = lambda message, *_: print(
        f"mobility-imu: warning: {message}", file=sys.stderr
    )
    try:
        code = app(standalone_mode=False)
    except MobilityImuError as error:
        _fail(str(error))
    except typer.Abort:
        _fail("stopped")
    except Exception as error:
        # Typer's own errors on arguments: one line instead of its box.
        if hasattr(error, "format_message") and hasattr(error, "exit_code"):
            _fail(error.format_message() or "give a command; --help lists them")
        raise
    sys.exit(code if isinstance(code, int) else 0)
