"""Command line: from a recording to angles, velocities, tasks, and the papers' numbers checked.

Exit code 0: done. Exit code 2: the input or an argument is at fault; one line on stderr says
what, and no output file is left behind.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from mobility_imu import __version__
from mobility_imu.errors import InputError, MobilityImuError

if TYPE_CHECKING:
    import pandas as pd

app = typer.Typer(
    name="mobility-imu",
    help="Angles, tasks and paths of mobility aids from inertial sensors (IMUs).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
scooter_app = typer.Typer(no_args_is_help=True, help="Mobility scooter: steering and throttle.")
wheelchair_app = typer.Typer(no_args_is_help=True, help="Manual wheelchair: velocities and tasks.")
simulate_app = typer.Typer(no_args_is_help=True, help="Recordings with known truth.")
app.add_typer(scooter_app, name="scooter")
app.add_typer(wheelchair_app, name="wheelchair")
app.add_typer(simulate_app, name="simulate")


class Method(StrEnum):
    """How scooter angles are estimated."""

    closed_form = "closed-form"


class Form(StrEnum):
    """Which closed form."""

    three_axis = "three-axis"
    printed = "printed"


class Camber(StrEnum):
    """Which form of the camber term."""

    sign_safe = "sign-safe"
    printed = "printed"


class Edge(StrEnum):
    """Who votes on a trial's first frames."""

    covering = "covering"
    tool = "tool"


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
    geometry: Annotated[Path, typer.Option(help="TOML with a section [scooter].")],
    output: Output,
    single_imu: Annotated[
        bool, typer.Option("--single-imu", help="Use the lever's IMU alone (level ground).")
    ] = False,
    method: Annotated[Method, typer.Option(help="Estimator.")] = Method.closed_form,
    form: Annotated[
        Form, typer.Option(help="Closed form: all three axes, or eqs 6 and 7 as printed.")
    ] = Form.three_axis,
    median_window: Annotated[
        int, typer.Option(help="Samples of the running median, odd; 1 for none.")
    ] = 25,
    acc_noise_mps2: Annotated[
        float | None,
        typer.Option(
            help="Noise (1 sd, per axis, after the median) of each accelerometer, m/s².", min=0
        ),
    ] = None,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """Steering and throttle angles from one or two IMUs (Suzurikawa et al. 2022).

    The columns steering_sd_deg and throttle_sd_deg stay empty unless --acc-noise-mps2 is given.
    """
    import numpy as np
    import pandas as pd

    from mobility_imu.filters import median_filter
    from mobility_imu.readers import read_recording
    from mobility_imu.scooter import ScooterGeometry, estimate_angles
    from mobility_imu.scooter.angles import angle_standard_deviations

    del method  # one estimator so far
    scooter = ScooterGeometry.from_toml(geometry)
    rides = read_recording(recording, fill_gaps_s=fill_gaps_s)
    lever = median_filter(rides.sensor("lever").acc_mps2, median_window)
    body = None
    if not single_imu:
        if "body" not in rides.sensors:
            raise InputError(
                f"{recording}: no sensor 'body'; with the lever's IMU alone give --single-imu"
            )
        body = median_filter(rides.sensor("body").acc_mps2, median_window)
    try:
        angles = estimate_angles(lever, body, scooter, form=form.value)
    except InputError as error:
        raise InputError(f"{recording}: {error}") from None
    sd = np.full((2, len(rides)), np.nan)
    if acc_noise_mps2 is not None:
        sd = np.asarray(
            angle_standard_deviations(
                lever,
                angles.steering_rad,
                angles.throttle_rad,
                scooter,
                lever_sd_mps2=acc_noise_mps2,
                body_sd_mps2=0.0 if single_imu else acc_noise_mps2,
            )
        )
    table = pd.DataFrame(
        {
            "time_s": rides.time_s,
            "steering_deg": np.rad2deg(angles.steering_rad),
            "throttle_deg": np.rad2deg(angles.throttle_rad),
            "steering_sd_deg": np.rad2deg(sd[0]),
            "throttle_sd_deg": np.rad2deg(sd[1]),
            "valid": angles.valid.astype(int),
        }
    )
    _write_tables({output: table})


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
    sampling_rate_hz: Rate = 100.0,
    fill_gaps_s: FillGaps = 0.0,
) -> None:
    """Linear velocity and yaw rate of a chair from wheel and frame IMUs (WheelMove-ID)."""
    from mobility_imu.readers import read_recording
    from mobility_imu.wheelchair import WheelchairGeometry, calibrate, estimate_velocity

    chair = WheelchairGeometry.from_toml(geometry)
    drive, still, line = (
        read_recording(path, sampling_rate_hz=sampling_rate_hz, fill_gaps_s=fill_gaps_s)
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
    sampling_rate_hz: Annotated[
        float | None, typer.Option(help="Hz; for files that have no time column.", min=1)
    ] = None,
) -> None:
    """Locomotor tasks and a chronogram from a chair's velocities (WheelMove-ID)."""
    import numpy as np
    import pandas as pd

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
    if figure is None:
        _write_tables({output: table})
        return
    if figure.suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"--figure {figure}: expected a name that ends in .png, .svg or .pdf")
    import matplotlib as mpl

    mpl.use("agg")
    from mobility_imu.plots.wheelchair import chronogram

    drawing = chronogram(series.time_s, codes, series.linear_velocity_mps, series.yaw_rate_radps)
    with _new_file(figure) as unfinished:
        drawing.savefig(unfinished, format=figure.suffix[1:], dpi=150)
        _write_tables({output: table})


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


@app.command()
def reproduce(
    work: Annotated[Work | None, typer.Option(help="Only one of the works.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="JSON instead of a table.")] = False,
) -> None:
    """The scorecard: published numbers beside ours, computed now, with a verdict."""
    from mobility_imu.reproduction.scorecard import print_scorecard, scorecard, to_records

    outcomes = scorecard(work.value if work else None)
    if as_json:
        typer.echo(json.dumps(to_records(outcomes), indent=2, ensure_ascii=False))
    else:
        print_scorecard(outcomes)


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
    packing = {"method": "gzip", "mtime": 0} if path.suffix == ".gz" else None
    with _new_file(path) as unfinished:
        table.to_csv(unfinished, index=False, float_format="%.6f", compression=packing)
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
