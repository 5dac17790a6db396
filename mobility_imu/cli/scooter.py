"""Commands of the scooter: angles from a ride, and the mounting of both IMUs."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from mobility_imu.cli.files import Outputs, csv_bytes
from mobility_imu.cli.options import FillGaps, Output, sub_app
from mobility_imu.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from mobility_imu.frames import FloatArray
    from mobility_imu.recording import Recording
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.fusion import FusedAngles
    from mobility_imu.scooter.mount import ScooterMount

Method = Literal["closed-form", "fusion"]
Form = Literal["three-axis", "printed"]
LARGEST_NOISE_MPS2 = 100.0
LARGEST_POSE_DEG = 180.0

app = sub_app("Mobility scooter: steering and throttle.")


class AngleOptions(NamedTuple):
    """How angles are estimated; the options of the command say what each means."""

    single_imu: bool
    method: Method
    form: Form
    median_window: int
    acc_noise_mps2: float | None
    causal: bool

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors that are used."""
        return ("lever",) if self.single_imu else ("lever", "body")


@app.command("angles")
def angles(
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
    ] = "closed-form",
    form: Annotated[
        Form, typer.Option(help="Closed form: all three axes, or eqs 6 and 7 as printed.")
    ] = "three-axis",
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
    from mobility_imu.readers import read_recording, recording_files
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.mount import ScooterMount

    outputs = Outputs({"--output": output}, (*recording_files(recording), geometry))
    options = AngleOptions(single_imu, method, form, median_window, acc_noise_mps2, causal)
    _check_options(options)
    scooter = ScooterGeometry.from_toml(geometry)
    mounting = ScooterMount.from_toml(geometry)
    ride = read_recording(recording, fill_gaps_s=fill_gaps_s)
    table = estimate_ride_table(ride, scooter, mounting, options)
    outputs.write({output: csv_bytes(table, output)})


def _check_options(options: AngleOptions) -> None:
    if options.method == "fusion" and options.single_imu:
        raise InputError("--method fusion needs both IMUs: it cannot be had with --single-imu")
    noise = options.acc_noise_mps2
    if noise is not None and not 0 <= noise <= LARGEST_NOISE_MPS2:
        raise InputError(
            f"--acc-noise-mps2 {noise:g}: expected between 0 and {LARGEST_NOISE_MPS2:g} m/s²"
        )
    if noise == 0 and options.method == "fusion":
        raise InputError("--acc-noise-mps2 0: fusion needs a noise above 0")


def estimate_ride_table(
    ride: Recording,
    scooter: ScooterGeometry,
    mounting: ScooterMount | None,
    options: AngleOptions,
) -> pd.DataFrame:
    """Table of a ride's angles, as the command writes it.

    Parameters
    ----------
    ride : Recording with a sensor ``lever`` and, unless it is used alone, ``body``
    scooter : ScooterGeometry
    mounting : ScooterMount that is applied to the readings, or None
    options : AngleOptions

    Returns
    -------
    DataFrame
        ``time_s``, ``steering_deg``, ``throttle_deg``, ``steering_sd_deg``, ``throttle_sd_deg``,
        ``valid`` (1 or 0)
    """
    import numpy as np
    import pandas as pd

    if "body" in options.sensors and "body" not in ride.sensors:
        raise InputError(
            f"{ride.source}: no sensor 'body'; with the lever's IMU alone give --single-imu"
        )
    usable = usable_samples(ride, options.sensors)
    try:
        found: tuple[Any, ...]
        if options.method == "fusion":
            found = _fused(ride, scooter, mounting, options)
        else:
            found = _closed_form(ride, scooter, mounting, options)
    except InputError as error:
        raise InputError(f"{ride.source}: {error}") from None
    steering, throttle, steering_sd, throttle_sd, valid = found
    return pd.DataFrame(
        {
            "time_s": ride.time_s,
            "steering_deg": np.rad2deg(steering),
            "throttle_deg": np.rad2deg(throttle),
            "steering_sd_deg": np.rad2deg(steering_sd),
            "throttle_sd_deg": np.rad2deg(throttle_sd),
            "valid": (valid & usable).astype(int),
        }
    )


def usable_samples(ride: Recording, names: tuple[str, ...]) -> NDArray[Any]:
    """Samples in which no accelerometer is frozen or saturated; a warning tells of the others.

    Parameters
    ----------
    ride : Recording
    names : sensors that are looked at

    Returns
    -------
    (n,) bool array
    """
    import numpy as np

    from mobility_imu.quality import frozen_samples, saturated_samples

    usable = np.ones(len(ride), bool)
    for name in names:
        acc = ride.sensor(name).acc_mps2
        for what, bad in (
            ("is frozen", frozen_samples(acc, ride.sampling_rate_hz)),
            ("is saturated", saturated_samples(acc)),
        ):
            if bad.any():
                warnings.warn(
                    f"{ride.source}: {name}_acc {what} in {int(bad.sum())} samples, first at "
                    f"{ride.time_s[np.argmax(bad)]:g} s; they are marked as not valid",
                    stacklevel=1,
                )
                usable &= ~bad
    return usable


def _closed_form(
    ride: Recording,
    scooter: ScooterGeometry,
    mounting: ScooterMount | None,
    options: AngleOptions,
) -> tuple[Any, ...]:
    import numpy as np

    from mobility_imu.filters import median_filter
    from mobility_imu.scooter import estimate_angles
    from mobility_imu.scooter.angles import angle_standard_deviations

    acc = {
        name: median_filter(ride.sensor(name).acc_mps2, options.median_window)
        for name in options.sensors
    }
    _warn_of_median(options.median_window, ride.sampling_rate_hz)
    lever, body = acc["lever"], acc.get("body")
    if mounting is not None:
        lever, body = mounting.lever(lever), None if body is None else mounting.body(body)
    found = estimate_angles(lever, body, scooter, form=options.form)
    sd: tuple[FloatArray, ...] = (np.full(len(ride), np.nan),) * 2
    noise = options.acc_noise_mps2
    if noise is not None:
        sd = angle_standard_deviations(
            lever,
            found.steering_rad,
            found.throttle_rad,
            scooter,
            lever_sd_mps2=noise,
            body_sd_mps2=0.0 if body is None else noise,
        )
    return found.steering_rad, found.throttle_rad, *sd, found.valid


def _warn_of_median(window: int, sampling_rate_hz: float) -> None:
    span = window / sampling_rate_hz
    if window > 1 and not 0.2 <= span <= 0.3:
        odd = 2 * round(0.25 * sampling_rate_hz / 2 - 0.5) + 1
        warnings.warn(
            f"a median of {window} samples is {span:.3g} s long at {sampling_rate_hz:g} Hz, the "
            f"paper's is 0.25 s: --median-window {odd} would be",
            stacklevel=1,
        )


def _fused(
    ride: Recording,
    scooter: ScooterGeometry,
    mounting: ScooterMount | None,
    options: AngleOptions,
) -> FusedAngles:
    import numpy as np

    from mobility_imu.scooter.fusion import FusionSettings, fuse_angles

    lever, body = ride.sensor("lever", gyroscope=True), ride.sensor("body", gyroscope=True)
    lever_acc, lever_gyr = lever.acc_mps2, np.asarray(lever.gyr_radps)
    body_acc, body_gyr = body.acc_mps2, np.asarray(body.gyr_radps)
    if mounting is not None:
        lever_acc, lever_gyr = mounting.lever(lever_acc), mounting.lever(lever_gyr)
        body_acc, body_gyr = mounting.body(body_acc), mounting.body(body_gyr)
    noise = options.acc_noise_mps2
    return fuse_angles(
        lever_acc,
        lever_gyr,
        body_acc,
        body_gyr,
        ride.sampling_rate_hz,
        scooter,
        # The filter's noise is that of the difference of both sensors.
        FusionSettings(acc_sd_mps2=None if noise is None else noise * 2**0.5),
        smooth=not options.causal,
    )


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
) -> None:
    """How both IMUs are mounted, from parked poses with the controls at their stops.

    Park, move the controls through the poses, hold each for two seconds. Do it on level ground and
    on a ramp: level ground alone does not show a turn of the body's IMU about the vertical.
    """
    from mobility_imu.readers import read_recording, recording_files
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.calibration import calibrate_mounting, parked_poses

    recordings = (file for path in parked for file in recording_files(path))
    outputs = Outputs({"--output": output}, (*recordings, geometry, poses))
    scooter = ScooterGeometry.from_toml(geometry)
    settings = read_poses(poses)
    found = [pose for path in parked for pose in parked_poses(read_recording(path), settings)]
    mounting = calibrate_mounting(found, scooter)
    for name in mounting.unseen:
        warnings.warn(
            f"the poses tell little of the turn of the {name}: park at another slope as well",
            stacklevel=1,
        )
    outputs.write({output: mounting_to_toml(mounting, scooter).encode()})


def read_poses(path: Path) -> list[tuple[float, float]]:
    """Steering and throttle of the parked poses.

    Parameters
    ----------
    path : CSV with the columns steering_deg and throttle_deg

    Returns
    -------
    list of (steering, throttle), rad
    """
    import numpy as np

    from mobility_imu.readers.table import parse_numbers, read_text

    table = parse_numbers(read_text(path), separator=",", source=str(path))
    columns = table.columns(["steering_deg", "throttle_deg"])
    if not np.isfinite(columns).all():
        raise InputError(f"{path}: an angle is missing")
    largest = float(np.abs(columns).max())
    if largest > LARGEST_POSE_DEG:
        raise InputError(
            f"{path}: an angle of {largest:g}, expected between -{LARGEST_POSE_DEG:g} and "
            f"{LARGEST_POSE_DEG:g} deg"
        )
    return [(float(steering), float(throttle)) for steering, throttle in np.deg2rad(columns)]


def mounting_to_toml(mounting: ScooterMount, scooter: ScooterGeometry) -> str:
    """Geometry and mounting as the text of a geometry file.

    Parameters
    ----------
    mounting : ScooterMount
    scooter : ScooterGeometry

    Returns
    -------
    str
    """
    import numpy as np

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
    return "\n".join(lines) + "\n"
