"""Commands of the scooter: angles from a ride, and the mounting of both IMUs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mobility_imu.cli.inputs import (
    as_typed,
    in_words,
    naming,
    read_input,
    sd_in_degrees,
    tell_faults,
)
from mobility_imu.cli.messages import summarize, warn
from mobility_imu.cli.options import (
    FillGaps,
    Output,
    Quiet,
    Rate,
    Strict,
    Table,
    sub_app,
    table_file,
)
from mobility_imu.cli.outputs import MOUNT, checked_outputs, print_and_write, table_bytes
from mobility_imu.errors import InputError

if TYPE_CHECKING:
    from mobility_imu.faults import Fault
    from mobility_imu.recording import Recording
    from mobility_imu.scooter import (
        PoseCheck,
        PoseCheckSettings,
        RideAngles,
        RideSettings,
        ScooterGeometry,
        ScooterMount,
    )
    from mobility_imu.scooter.angles import Form as LibraryForm
    from mobility_imu.scooter.force import PoseLength

Method = Literal["closed-form", "fusion"]
Form = Literal["three-axis", "printed"]
Sensors = Literal["consumer", "calibrated"]
FORMS: dict[Form, LibraryForm] = {"three-axis": "corrected", "printed": "printed"}
"""Name of each form in the library."""
LARGEST_POSE_DEG = 180.0
"""Half a turn; a larger angle is the same pose as a smaller one."""
LARGEST_SCALE_SD_DEG = 10.0
"""A protractor that is set no better judges nothing. Set by hand."""
LARGEST_SHAFT_DEG = 55.0
"""Steering shafts lean back by 10 to 35 deg, which is 55 to 80 from the horizontal. Set by hand."""
MEDIAN_WINDOW = 25
"""As in RideSettings, which is loaded only where it is needed."""
WORDS = {
    "median_window = ": "--median-window ",
    "median window = ": "--median-window ",
}
"""Names of the settings in the library's messages, and of the options."""
NO_FAULT = ("accelerated", "uncertain", "settings")
"""Kinds of remarks on a ride that are of no fault: to be pushed is none of a sensor."""

Ride = Annotated[
    Path,
    typer.Argument(
        help="Recording with sensors 'lever' and 'body', as a file, a session's folder or "
        "lever=a.csv,body=b.csv."
    ),
]
app = sub_app("Mobility scooter: steering and throttle.")


@app.command("angles")
def angles(
    recording: Ride,
    geometry: Annotated[
        Path, typer.Option(help="TOML with [scooter]; with [scooter.mount], that is applied.")
    ],
    output: Table,
    single_imu: Annotated[
        bool, typer.Option("--single-imu", help="Use the lever's IMU alone (level ground).")
    ] = False,
    method: Annotated[
        Method, typer.Option(help="Closed form, or gyroscopes as well (filter and smoother).")
    ] = "closed-form",
    form: Annotated[
        Form, typer.Option(help="Closed form: all three axes, or eqs 6 and 7 as printed.")
    ] = "three-axis",
    median_window: Annotated[
        int, typer.Option(help="Closed form: samples of the running median, odd; 1 for none.")
    ] = MEDIAN_WINDOW,
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
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """Steering and throttle angles from one or two IMUs (Suzurikawa et al. 2022).

    With the closed form the columns steering_sd_deg and throttle_sd_deg stay empty unless
    --acc-noise-mps2 is given.
    """
    from mobility_imu.cli.summaries import read_line, ride_lines, written_line
    from mobility_imu.readers import recording_files
    from mobility_imu.scooter import RideSettings

    outputs = checked_outputs({"--output": output}, (*recording_files(recording), geometry))
    _check_options(method, single_imu, acc_noise_mps2)
    _tell_unused(method, form=form, median_window=median_window, causal=causal)
    with as_typed(WORDS):
        settings = RideSettings(
            method=method,
            single_imu=single_imu,
            form=FORMS[form],
            median_window=median_window,
            acc_noise_mps2=acc_noise_mps2,
            smooth=not causal,
        )
    scooter, mount = _read_scooter_and_mount(geometry)
    ride = read_input(recording, "scooter", sampling_rate_hz, fill_gaps_s)
    if "body" not in ride.sensors and not single_imu:
        raise InputError(
            f"{ride.source}: no sensor 'body'; with the lever's IMU alone give --single-imu"
        )
    with as_typed(WORDS):
        found = _judged(ride, scooter, mount, settings, strict)
    outputs.write({output: table_bytes(found.to_frame(), output)})
    summarize([read_line(ride), *ride_lines(found), written_line([output])], quiet)


def _read_scooter(path: Path) -> ScooterGeometry:
    """Geometry; warns of an inclination that is possible, and probably another one."""
    import math

    from mobility_imu.scooter import ScooterGeometry

    geometry = ScooterGeometry.from_toml(path)
    alpha_deg = math.degrees(geometry.steering_inclination_rad)
    if alpha_deg > LARGEST_SHAFT_DEG:
        warn([
            f"{path}, [scooter] steering_inclination_deg = {alpha_deg:g}: a shaft that leans back "
            "so far from the vertical? If it was measured from the horizontal, write "
            f"{90 - alpha_deg:g}"
        ])  # fmt: skip
    return geometry


def _read_scooter_and_mount(path: Path) -> tuple[ScooterGeometry, ScooterMount | None]:
    """Geometry and mount; warns of numbers that are possible, and probably meant otherwise."""
    from mobility_imu.scooter import ScooterMount

    geometry, mount = _read_scooter(path), ScooterMount.in_toml(path)
    sd_rad = None if mount is None else mount.sd_rad
    warn(sd_in_degrees(path, "[scooter.mount] sd_rad", sd_rad))
    return geometry, mount


def _judged(
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
    settings: RideSettings,
    strict: bool,
) -> RideAngles:
    """Angles of a ride whose faults are told, and which are not valid where these move them."""
    from mobility_imu.scooter import estimate_ride, find_faults, mark_faults
    from mobility_imu.scooter.ride import LOSSES

    faults = find_faults(recording, geometry, mount, settings)
    tell_faults(faults, strict)
    with naming(faults):
        found = mark_faults(estimate_ride(recording, geometry, mount, settings), faults)
    # The estimate says of some sensors what was told with its cost.
    told = {(fault.code, fault.sensor) for fault in faults}
    left = [one for one in found.remarks if (one.code, one.sensor) not in told]
    # Losses that were not told move no angle that is valid; their own samples are not.
    faulty = [one for one in left if one.code not in (*NO_FAULT, *LOSSES)]
    if strict and faulty:
        raise InputError(faulty[0].sentence)
    warn(in_words(one.sentence, WORDS) for one in left)
    return found


def _check_options(method: Method, single_imu: bool, noise: float | None) -> None:
    """Check that the options go together; messages are in the words of the command line."""
    from mobility_imu.scooter.ride import LARGEST_STATED_MPS2, SMALLEST_STATED_MPS2

    if method == "fusion" and single_imu:
        raise InputError("--method fusion needs both IMUs: it cannot be had with --single-imu")
    if noise is not None and not 0 <= noise <= LARGEST_STATED_MPS2:
        raise InputError(
            f"--acc-noise-mps2 {noise:g}: expected between 0 and {LARGEST_STATED_MPS2:g} m/s²"
        )
    if noise == 0 and method == "fusion":
        raise InputError("--acc-noise-mps2 0: fusion needs a noise above 0")
    if noise is not None and method == "fusion" and noise < SMALLEST_STATED_MPS2:
        raise InputError(
            f"--acc-noise-mps2 {noise:g}: expected at least {SMALLEST_STATED_MPS2:g} m/s² with "
            "--method fusion"
        )


def _tell_unused(method: Method, *, form: Form, median_window: int, causal: bool) -> None:
    """Warn of options that are given and that the method does not use."""
    unused = ["--causal"] if causal and method == "closed-form" else []
    if method == "fusion":
        unused += ["--form"] if form != "three-axis" else []
        unused += ["--median-window"] if median_window != MEDIAN_WINDOW else []
    warn(f"{name} has no effect with --method {method}" for name in unused)


@app.command("calibrate")
def calibrate(
    parked: Annotated[
        list[Path], typer.Argument(help="Parked recordings, one per place; two places or more.")
    ],
    geometry: Annotated[Path, typer.Option(help="TOML with a section [scooter].")],
    poses: Annotated[
        Path, typer.Option(help="CSV steering_deg,throttle_deg: the poses, in order.")
    ],
    output: Output,
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """How both IMUs are mounted, from parked poses with the controls at their stops.

    Park, move the controls through the poses, hold each for two seconds. Do it on level ground and
    on a ramp: level ground alone does not show a turn of the body's IMU about the vertical.
    """
    from mobility_imu.cli.summaries import scooter_mount_lines, written_line
    from mobility_imu.readers import recording_files
    from mobility_imu.scooter import calibrate_mount, find_faults

    files = (file for path in parked for file in recording_files(path))
    outputs = checked_outputs({"--output": output}, (*files, geometry, poses), MOUNT)
    scooter, settings = _read_scooter(geometry), read_poses(poses)
    recordings = [read_input(path, "scooter", sampling_rate_hz, fill_gaps_s) for path in parked]
    of = [(one, fault) for one in recordings for fault in find_faults(one, scooter)]
    faults = [fault for _, fault in of]
    tell_faults(faults, strict)
    with naming(faults):
        found = calibrate_mount(recordings, settings, scooter)
    if strict and found.severe:
        by_file = found.severe[0].startswith(tuple(one.source for one in recordings))
        raise InputError(found.severe[0] if by_file else f"{poses}: {found.severe[0]}")
    explained = [wrong.sentence for wrong in found.wrong_lengths if _is_explained(wrong, of)]
    warn(text for text in found.warnings if text not in explained)
    outputs.write({output: found.to_toml().encode()})
    read = f"read: {len(parked)} parked recordings, {len(settings)} poses in each"
    summarize([read, *scooter_mount_lines(found), written_line([output])], quiet)


def _is_explained(wrong: PoseLength, of: Sequence[tuple[Recording, Fault]]) -> bool:
    """Whether a wrong length of gravity in a pose repeats a fault that was told of it."""
    from mobility_imu.scooter.calibration import find_stills

    for parked, fault in of:
        if parked.source != wrong.source or f"{wrong.sensor}_acc" not in fault.sensor.split(", "):
            continue
        if fault.flags[find_stills(parked)[wrong.pose]].any():
            return True
    return False


AlsoTable = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o", help="Also write the table as CSV.", parser=table_file, metavar="PATH"
    ),
]


@app.command("check")
def check(
    parked: Annotated[
        Path, typer.Argument(help="Parked recording; the controls rest in one pose after another.")
    ],
    poses: Annotated[
        Path, typer.Option(help="CSV steering_deg,throttle_deg: the angles as set, in order.")
    ],
    geometry: Annotated[
        Path, typer.Option(help="TOML with [scooter]; with [scooter.mount], that is applied.")
    ],
    method: Annotated[
        Method, typer.Option(help="Means over each rest, or the fusion with its own deviations.")
    ] = "closed-form",
    sensors: Annotated[
        Sensors, typer.Option(help="What is assumed of the IMUs: phones, or calibrated by a maker.")
    ] = "consumer",
    scale_sd_deg: Annotated[
        float, typer.Option(help="How well the protractor's zero and centre are set, deg.", min=0.0)
    ] = 0.5,
    kept_on: Annotated[
        bool, typer.Option("--kept-on", help="IMUs were not switched off since the calibration.")
    ] = False,
    output: AlsoTable = None,
    sampling_rate_hz: Rate = None,
    strict: Strict = False,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """Whether the angles agree with those that a protractor set.

    Park, set the controls to known angles, hold each pose for two seconds or more. The book's page
    "Judge your own scooter" has the whole protocol.
    """
    from mobility_imu.cli.summaries import pose_check_lines, read_line, written_line
    from mobility_imu.readers import recording_files
    from mobility_imu.scooter import (
        RideSettings,
        check_poses,
        find_faults,
    )

    outputs = checked_outputs({"--output": output}, (*recording_files(parked), geometry, poses))
    settings = _check_settings(method, sensors, scale_sd_deg, kept_on)
    scooter, mount = _read_scooter_and_mount(geometry)
    set_rad = read_poses(poses)
    recording = read_input(parked, "scooter", sampling_rate_hz, fill_gaps_s)
    faults = find_faults(recording, scooter, mount, RideSettings(method=method))
    tell_faults(faults, strict)
    with naming(faults):
        found = check_poses(recording, set_rad, scooter, mount, settings)
    table = {} if output is None else {output: table_bytes(found.to_frame(), output)}
    print_and_write(check_text(found), outputs, table)
    written = [] if output is None else [written_line([output])]
    summarize([read_line(recording), *pose_check_lines(found), *written], quiet)


def _check_settings(
    method: Method, sensors: Sensors, scale_sd_deg: float, kept_on: bool
) -> PoseCheckSettings:
    """Settings of ``scooter check`` from its options."""
    import dataclasses

    import numpy as np

    from mobility_imu.scooter import PoseCheckSettings

    if not 0 < scale_sd_deg <= LARGEST_SCALE_SD_DEG:
        raise InputError(
            f"--scale-sd-deg {scale_sd_deg:g}: expected above 0 and up to {LARGEST_SCALE_SD_DEG:g}"
        )
    make = PoseCheckSettings.for_calibrated_imus if sensors == "calibrated" else PoseCheckSettings
    settings = dataclasses.replace(make(method), scale_sd_rad=float(np.deg2rad(scale_sd_deg)))
    return settings.kept_on() if kept_on else settings


def check_text(found: PoseCheck) -> str:
    """Lines that ``scooter check`` prints.

    Parameters
    ----------
    found : PoseCheck

    Returns
    -------
    str
    """
    from mobility_imu.cli.summaries import pose_check_lines

    lines = ["pose  control   set, deg  found, deg  difference, deg  sd, deg  inside 95 %"]
    for row in found.to_frame().itertuples():
        inside = ("yes" if row.inside_95 else "no") if row.judged else "not judged"
        lines.append(
            f"{row.pose:4}  {row.control}  {row.set_deg:8.1f}  {row.found_deg:10.2f}  "
            f"{row.difference_deg:15.2f}  {row.sd_deg:7.2f}  {inside}"
        )
    *rms, verdict = pose_check_lines(found)
    chi = f"chi-square {found.chi_square:.1f}, about {2 * int(found.judged.sum())} expected"
    return "\n".join([*lines, *rms, chi, f"- {verdict}", *(f"- {w}" for w in found.warnings)])


def read_poses(path: Path) -> list[tuple[float, float]]:
    """Steering and throttle of the parked poses.

    Parameters
    ----------
    path : CSV with the columns steering_deg and throttle_deg

    Returns
    -------
    list of (steering, throttle), rad

    Raises
    ------
    InputError
        If a column is missing, or an angle is missing or beyond half a turn.
    """
    import numpy as np

    from mobility_imu.readers.table import line_of, parse_numbers, read_text

    names = ["steering_deg", "throttle_deg"]
    table = parse_numbers(
        read_text(path), source=str(path), wanted=lambda name: name.lower() in names
    )
    columns = table.columns(names)
    table.check_finite(range(len(table.header)))
    beyond = (np.abs(columns) > LARGEST_POSE_DEG).any(axis=1)
    if beyond.any():
        row = int(np.argmax(beyond))
        raise InputError(
            f"{path}: line {line_of(table.text, row)}: an angle of {np.abs(columns[row]).max():g}, "
            f"expected between -{LARGEST_POSE_DEG:g} and {LARGEST_POSE_DEG:g} deg"
        )
    largest = float(np.abs(columns).max())
    if 0 < largest <= np.pi / 2:
        warn([f"{path}: no angle is beyond {largest:.3g} deg: are they in rad? Write them in deg"])
    return [(float(steering), float(throttle)) for steering, throttle in np.deg2rad(columns)]
