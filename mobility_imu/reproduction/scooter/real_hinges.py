"""Scooter's methods on two hinged chains that others recorded with a reference.

No recording of a scooter with a reference is public. A chain of two hinges moved by hand, with
motion capture, and one hinge on a motor, with an encoder, have the same equations (1 to 7). Beside
them stand simulated rides, judged by the same measures.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, wrap_angle
from mobility_imu.readers import read_recording
from mobility_imu.readers.table import parse_numbers, read_text
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import Numbers, checksums, origin_of
from mobility_imu.reproduction.scooter.calibration import PLACES_DEG
from mobility_imu.scooter.calibration import calibrate_mount
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.ride import Method, RideAngles, RideSettings, estimate_ride
from mobility_imu.simulation.scooter import (
    COURSES,
    PARKED_POSES_RAD,
    SimulatedRide,
    draw_driver,
    draw_scooter,
    simulate_parked,
    simulate_ride,
)
from mobility_imu.simulation.sensor import LPMS_CU2, SensorModel

ANGLES = ("steering", "throttle")
METHODS: tuple[Method, ...] = ("fusion", "closed-form")
SIMULATED_SCOOTERS = 4
"""Drawn scooters, each on every course; their errors are the promise."""
QUANTILE_95 = 1.96
DIGITS = 4


class Chain(NamedTuple):
    """A data set of hinges: its recordings, and their geometry files.

    Parameters
    ----------
    dataset : name by which it is fetched
    recordings : recording to its geometry file; those that the record holds
    """

    dataset: str
    recordings: Mapping[str, str]


TWO_HINGES = Chain("two-hinges", {"trial1_rigid": "geometry.toml", "trial1_foam": "geometry.toml"})
ONE_HINGE = Chain(
    "one-hinge",
    {
        "pitch_slow": "pitch_slow_geometry.toml",
        "pitch_medium": "pitch_medium_geometry.toml",
    },
)


@dataclass(frozen=True)
class AngleErrors:
    """How far one angle is from its reference, and whether the stated deviation holds that.

    Parameters
    ----------
    rms_deg : deg, root mean square of the error in the samples that count as valid
    sd_deg : deg, median of the stated standard deviation in them; None if none is stated
    sd_ratio : stated over actual, ``sd_deg / rms_deg``
    covered : fraction of samples whose error is inside the stated 95 % interval
    samples : number of samples with a reference
    valid : fraction of these that count as valid
    mean_deg : deg, mean of the error in the samples that count as valid
    rms_all_deg : deg, root mean square of the error in all samples with a reference, valid or not
    """

    rms_deg: float | None
    sd_deg: float | None
    sd_ratio: float | None
    covered: float | None
    samples: int
    valid: float
    mean_deg: float | None = None
    rms_all_deg: float | None = None


def angle_errors(
    error_rad: FloatArray, sd_rad: FloatArray, valid: NDArray[np.bool_]
) -> AngleErrors:
    """Errors of one angle against its reference, to four digits behind the point.

    Parameters
    ----------
    error_rad : (n,) array, rad, found minus reference; NaN where there is no reference
    sd_rad : (n,) array, rad, stated standard deviation; NaN where none is stated
    valid : (n,) bool array, samples that the method trusts

    Returns
    -------
    AngleErrors
    """
    there = np.isfinite(error_rad)
    used = there & valid
    samples = int(there.sum())
    fraction = round(float(used.sum() / max(samples, 1)), DIGITS)
    of_all = _rms_deg(error_rad[there]) if samples else None
    if not used.any():
        return AngleErrors(None, None, None, None, samples, fraction, None, of_all)
    off, sd = np.rad2deg(error_rad[used]), np.rad2deg(sd_rad[used])
    rms, mean = _rms_deg(error_rad[used]), round(float(off.mean()), DIGITS)
    if np.isnan(sd).all():
        return AngleErrors(rms, None, None, None, samples, fraction, mean, of_all)
    stated = round(float(np.nanmedian(sd)), DIGITS)
    covered = round(float(np.mean(np.abs(off) <= QUANTILE_95 * sd)), DIGITS)
    ratio = round(stated / rms, DIGITS)
    return AngleErrors(rms, stated, ratio, covered, samples, fraction, mean, of_all)


def _rms_deg(error_rad: FloatArray) -> float:
    return round(float(np.rad2deg(np.sqrt(np.mean(error_rad**2)))), DIGITS)


def two_hinges(folder: Path) -> Numbers:
    """Steering and throttle of the chain of two hinges against motion capture.

    Parameters
    ----------
    folder : of the data set ``two-hinges``

    Returns
    -------
    dict, see :func:`chain_numbers`
    """
    return chain_numbers(TWO_HINGES, folder)


def one_hinge(folder: Path) -> Numbers:
    """Throttle of the motorised hinge against its encoder; the steering is 0 by construction.

    Parameters
    ----------
    folder : of the data set ``one-hinge``

    Returns
    -------
    dict, see :func:`chain_numbers`
    """
    return chain_numbers(ONE_HINGE, folder)


def chain_numbers(chain: Chain, folder: Path) -> Numbers:
    """Errors of both angles in each recording of a chain, by each method, and their summary.

    Parameters
    ----------
    chain : TWO_HINGES or ONE_HINGE
    folder : of the data set

    Returns
    -------
    dict
        ``origin``; ``files``, SHA-256 by name; ``rows``, one for each recording and method, with
        :class:`AngleErrors` of ``steering`` and ``throttle``, or the sentence with which the
        method refused the recording in ``refused``; ``summary``, see :func:`summary_of`.
    """
    names = [
        name
        for stem, geometry in chain.recordings.items()
        for name in (f"{stem}.csv.gz", f"{stem}_truth.csv.gz", geometry)
    ]
    rows = [
        {"recording": stem, "method": method, **errors_of(one, method)}
        for stem, geometry in chain.recordings.items()
        for one in [read_chain(folder, stem, geometry)]
        for method in METHODS
    ]
    return {
        "origin": origin_of(chain.dataset),
        "files": checksums(folder, dict.fromkeys(names)),
        "rows": rows,
        "summary": summary_of(rows),
    }


class ChainRecording(NamedTuple):
    """One recording of a chain, with its reference.

    Parameters
    ----------
    ride : Recording with sensors ``lever`` and ``body``
    true_rad : (n, 2) array, rad, steering and throttle; NaN where the reference is lost
    geometry : ScooterGeometry
    mount : ScooterMount or None
    """

    ride: Recording
    true_rad: FloatArray
    geometry: ScooterGeometry
    mount: ScooterMount | None

    def estimate(self, settings: RideSettings) -> RideAngles:
        """Both angles; the arguments are those of ``estimate_ride``."""
        return estimate_ride(self.ride, self.geometry, self.mount, settings)

    def error_rad(self, found: RideAngles) -> FloatArray:
        """Found minus true, (n, 2) array, rad, wrapped."""
        angles = np.column_stack([found.steering_rad, found.throttle_rad])
        return wrap_angle(angles - self.true_rad)


def read_chain(folder: Path, stem: str, geometry: str) -> ChainRecording:
    """One recording and its reference.

    Parameters
    ----------
    folder : of the data set
    stem : of the recording's file
    geometry : name of its geometry file

    Returns
    -------
    ChainRecording
    """
    path, place = folder / f"{stem}_truth.csv.gz", folder / geometry
    truth = parse_numbers(read_text(path), separator=",", source=str(path))
    return ChainRecording(
        read_recording(folder / f"{stem}.csv.gz"),
        truth.columns([f"{angle}_rad" for angle in ANGLES]),
        ScooterGeometry.from_toml(place),
        ScooterMount.in_toml(place),
    )


def errors_of(chain: ChainRecording, method: Method) -> Numbers:
    """Errors of both angles in one recording by one method.

    Parameters
    ----------
    chain : ChainRecording
    method : "fusion" or "closed-form"

    Returns
    -------
    dict with :class:`AngleErrors` of each angle and ``warnings``, or ``refused`` alone
    """
    source = chain.ride.source
    try:
        found = chain.estimate(RideSettings(method=method))
    except InputError as error:
        return {"refused": str(error).removeprefix(f"{source}: ")}
    # No path of this machine in what is recorded.
    warnings = [warning.removeprefix(f"{source}: ") for warning in found.warnings]
    return errors_by_angle(found, chain.true_rad) | {"warnings": warnings}


def errors_by_angle(found: RideAngles, true_rad: FloatArray) -> Numbers:
    """Errors of steering and throttle of one ride.

    Parameters
    ----------
    found : RideAngles
    true_rad : (n, 2) array, rad, steering and throttle on the ride's clock

    Returns
    -------
    dict from angle to the fields of :class:`AngleErrors`
    """
    numbers: Numbers = {}
    for k, angle in enumerate(ANGLES):
        error = wrap_angle(getattr(found, f"{angle}_rad") - true_rad[:, k])
        errors = angle_errors(error, getattr(found, f"{angle}_sd_rad"), found.valid)
        numbers[angle] = dataclasses.asdict(errors)
    return numbers


def summary_of(rows: Iterable[Numbers]) -> Numbers:
    """What the recordings of a set amount to, by method and angle.

    Parameters
    ----------
    rows : with ``method`` and, unless ``refused``, :class:`AngleErrors` of each angle

    Returns
    -------
    dict from method to
        ``recordings``; ``refused``, how many the method refused; and for each angle
        ``median_rms_deg`` and ``worst_rms_deg`` over recordings, ``covered`` over all valid
        samples, ``median_ratio`` of stated over actual and ``worst_ratio``, that of the recording
        with the worst error, and ``ratios_within_two``, number of recordings with the median stated
        deviation between half and twice the actual error.
    """
    rows = list(rows)
    summary: Numbers = {}
    for method in METHODS:
        of_method = [row for row in rows if row["method"] == method]
        answered = [row for row in of_method if "refused" not in row]
        part: Numbers = {
            "recordings": len(of_method),
            "refused": len(of_method) - len(answered),
        }
        for angle in ANGLES:
            errors = [row[angle] for row in answered if row[angle]["rms_deg"] is not None]
            if errors:
                part[angle] = _over_recordings(errors)
        summary[method] = part
    return summary


def _over_recordings(errors: list[Numbers]) -> Numbers:
    rms = [one["rms_deg"] for one in errors]
    weights = [one["samples"] * one["valid"] for one in errors]
    part: Numbers = {
        "median_rms_deg": round(float(np.median(rms)), 4),
        "worst_rms_deg": max(rms),
        "valid": round(sum(weights) / sum(one["samples"] for one in errors), 4),
    }
    if all(one["covered"] is not None for one in errors):
        covered = np.average([one["covered"] for one in errors], weights=weights)
        part["covered"] = round(float(covered), 4)
        part["median_ratio"] = round(float(np.median([one["sd_ratio"] for one in errors])), 4)
        part["worst_ratio"] = errors[int(np.argmax(rms))]["sd_ratio"]
        part["ratios_within_two"] = sum(0.5 <= one["sd_ratio"] <= 2 for one in errors)
    return part


@cache
def simulated_summary(
    sensor: SensorModel = LPMS_CU2, scooters: int = SIMULATED_SCOOTERS
) -> Numbers:
    """The same summary of simulated rides, calibrated on the car park: what simulation promises.

    Parameters
    ----------
    sensor : SensorModel of both IMUs
    scooters : how many are drawn; each drives every course once

    Returns
    -------
    dict, see :func:`summary_of`
    """
    rows = []
    for seed in range(scooters):
        unit, driver = draw_scooter(seed), draw_driver(seed)
        parked = [
            simulate_parked(
                pitch_rad=float(np.deg2rad(pitch)),
                bank_rad=float(np.deg2rad(roll)),
                seed=100 * seed + k,
                unit=unit,
                sensor=sensor,
            )
            for k, (pitch, roll) in enumerate(PLACES_DEG["level + ramp"])
        ]
        mount = calibrate_mount(parked, PARKED_POSES_RAD, SUZUKI_ET4D).mount
        for course in COURSES.values():
            ride = simulate_ride(course, seed=seed, unit=unit, driver=driver, sensor=sensor)
            true_rad = np.column_stack([ride.steering_rad, ride.throttle_rad])
            for method in METHODS:
                rows.append({"method": method, **_simulated_errors(ride, mount, true_rad, method)})
    return summary_of(rows)


def _simulated_errors(
    ride: SimulatedRide, mount: ScooterMount, true_rad: FloatArray, method: Method
) -> Numbers:
    try:
        found = estimate_ride(ride.recording, SUZUKI_ET4D, mount, RideSettings(method=method))
    except InputError as error:
        return {"refused": str(error)}
    return errors_by_angle(found, true_rad)
