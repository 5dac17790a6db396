"""What is recorded of two hinged chains: errors, sensors, errors over time, swept assumptions."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.datasets.folders import find_folder
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.offsets import gyroscope_offset
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import Numbers
from mobility_imu.reproduction.scooter.real_hinges import (
    ANGLES,
    ONE_HINGE,
    TWO_HINGES,
    Chain,
    ChainRecording,
    chain_numbers,
    errors_by_angle,
    read_chain,
    simulated_summary,
)
from mobility_imu.reproduction.walker.real_sensors import mean_spectrum, rounded
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.scooter.fusion_noise import SMALLEST_NOISE_MPS2, smallest_step
from mobility_imu.scooter.fusion_settings import FusionSettings
from mobility_imu.scooter.ride import RideSettings
from mobility_imu.simulation.sensor import REAL

POINTS = 200
"""Points of an error over time that a record keeps."""
WINDOW_S = {"two-hinges": (0.0, 66.0), "one-hinge": (60.0, 20.0)}
"""Start and length of the part that is kept, s: all of the chain in the hand, some sweeps of the
motor."""
PIECE_S = 10.0
"""Length of the pieces over which a mean error is kept for all of a recording."""
BIN_DEG = 15.0
"""Width of the bins of the throttle's true angle."""
QUIET_RADPS = 0.05
"""Rate below which a sensor counts as quiet."""
QUIET_S = 1.0
"""Shortest rest of which an offset is taken."""
NOTHING = 1e-8
"""Size of an error that a variant leaves out; as small as the filter takes it."""
CONSTANTS = (
    "acc_offset_sd_mps2",
    "misalignment_sd_rad",
    "axes_apart_sd_rad",
    "lever_arm_sd_m",
    "acc_scale_sd",
    "gyr_scale_sd",
)
"""Errors that stay as they are in a recording, beside the gyroscopes' offsets."""
SWEPT = (
    "acc_offset_sd_mps2",
    "misalignment_sd_rad",
    "axes_apart_sd_rad",
    "bias_sd_radps",
    "disturbance_time_s",
)
"""Assumed sizes that are halved and doubled, beside the clock's."""


def two_hinges_record(executor: Any = None) -> Numbers | None:
    """What the record ``real_two_hinges`` keeps; None if the recordings are not here.

    Parameters
    ----------
    executor : not used: the study takes a minute
    """
    return _recorded(TWO_HINGES)


def one_hinge_record(executor: Any = None) -> Numbers | None:
    """What the record ``real_one_hinge`` keeps; None if the recordings are not here.

    Parameters
    ----------
    executor : not used: the study takes a minute
    """
    return _recorded(ONE_HINGE)


def _recorded(chain: Chain) -> Numbers | None:
    folder = find_folder(chain.dataset)
    if folder is None:
        return None
    numbers = chain_numbers(chain, folder)
    numbers["summary"]["simulated"] = simulated_summary()
    numbers["summary"]["simulated_as_real"] = simulated_summary(REAL)
    return {"numbers": numbers | chain_details(chain, folder), "inputs": numbers["files"]}


def chain_details(chain: Chain, folder: Path) -> Numbers:
    """What a chapter shows of a chain beside the errors of the methods.

    Parameters
    ----------
    chain : TWO_HINGES or ONE_HINGE
    folder : of the data set

    Returns
    -------
    dict, each with one entry by recording
        ``sensors``, see :func:`sensor_numbers`; ``spectra`` by sensor; ``found``, what the
        recording told the filter; ``series``, see :func:`error_series`; ``causes``, see
        :func:`error_causes`; ``variants``, see :func:`settings_variants`; ``fit``, for the motor
        alone, see :func:`fit_to_encoder`
    """
    kinds = ("sensors", "spectra", "found", "series", "causes", "variants")
    details: Numbers = {kind: {} for kind in kinds}
    for stem, geometry in chain.recordings.items():
        one = read_chain(folder, stem, geometry)
        found = one.estimate(RideSettings(method="fusion"))
        error_rad = one.error_rad(found)
        sd_rad = np.column_stack([found.steering_sd_rad, found.throttle_sd_rad])
        details["sensors"][stem] = sensor_numbers(one.ride)
        details["spectra"][stem] = _spectra(one.ride)
        details["found"][stem] = _told(found.settings.fusion)
        details["series"][stem] = error_series(one, error_rad, sd_rad, WINDOW_S[chain.dataset])
        details["causes"][stem] = error_causes(one, error_rad)
        details["variants"][stem] = settings_variants(one)
        if chain is ONE_HINGE:
            details.setdefault("fit", {})[stem] = fit_to_encoder(one)
    return details


def sensor_numbers(ride: Recording) -> Numbers:
    """Clock, steps of the values, and rest of each sensor, by the recording alone.

    Parameters
    ----------
    ride : Recording

    Returns
    -------
    dict by sensor: ``rate_hz``, ``shortest_step_ms``, ``longest_step_ms``; ``acc_step_mps2`` and
    ``gyr_step_degps``, smallest step between two readings, None if finer than a thousandth of m/s²
    or rad/s; ``repeated_percent`` of the samples have the acceleration of the one before;
    ``length_mps2``, of the acceleration, not exceeded by 5, 50 and 95 % of the samples;
    ``fastest_degps``; ``quiet_s`` in rests of a second and more, and of these ``offset_degps``,
    length of the gyroscope's offset, and ``noise_mps2``, of one sample; both None without a rest
    """
    found: Numbers = {}
    step_ms = 1e3 * np.diff(ride.time_s)
    rate = ride.sampling_rate_hz
    for name in ride.sensors:
        acc, gyr = ride.sensor(name).acc_mps2, ride.gyroscope(name)
        spin = np.linalg.norm(gyr, axis=1)
        quiet = long_runs(spin < QUIET_RADPS, round(QUIET_S * rate), grow=False)
        offset = gyroscope_offset(gyr, quiet, rate)
        steps = [np.diff(acc[run], axis=0) for run in runs_of(quiet)]
        found[name] = {
            "rate_hz": rounded(rate, 2),
            "shortest_step_ms": rounded(step_ms.min(), 2),
            "longest_step_ms": rounded(step_ms.max(), 2),
            "acc_step_mps2": _coarse_step(acc, 1.0),
            "gyr_step_degps": _coarse_step(gyr, np.rad2deg(1.0)),
            "repeated_percent": rounded(100 * np.mean(np.all(np.diff(acc, axis=0) == 0, 1)), 1),
            "length_mps2": [
                rounded(v, 2) for v in np.percentile(np.linalg.norm(acc, axis=1), [5, 50, 95])
            ],
            "fastest_degps": rounded(np.rad2deg(np.abs(gyr).max()), 0),
            "quiet_s": rounded(quiet.sum() / rate, 1),
            "offset_degps": None
            if offset is None
            else rounded(np.rad2deg(np.linalg.norm(offset.offset_radps)), 2),
            "noise_mps2": rounded(np.sqrt(np.mean(np.concatenate(steps) ** 2) / 2), 3)
            if steps
            else None,
        }
    return found


def _coarse_step(values: FloatArray, unit: float) -> float | None:
    step = smallest_step(values, values)
    return None if step <= SMALLEST_NOISE_MPS2 else rounded(step * unit, 3)


def _spectra(ride: Recording) -> Numbers:
    rate = ride.sampling_rate_hz
    return {
        name: {
            "acc": mean_spectrum([ride.sensor(name).acc_mps2], rate),
            "gyr": mean_spectrum([np.rad2deg(ride.gyroscope(name))], rate),
        }
        for name in ride.sensors
    }


def _told(used: FusionSettings) -> Numbers:
    assert used.flexing_sd_rad is not None and used.clock_sd_s is not None
    return {
        "white_mps2": rounded(used.acc_sd_mps2, 3),
        "coloured_mps2": rounded(used.disturbance_sd_mps2, 3),
        "flexing_deg": rounded(np.rad2deg(used.flexing_sd_rad), 2),
        "clock_ms": rounded(1e3 * used.clock_sd_s, 1),
    }


def error_series(
    one: ChainRecording, error_rad: FloatArray, sd_rad: FloatArray, window_s: tuple[float, float]
) -> Numbers:
    """Error over time, over the throttle's angle, and over the recording.

    Parameters
    ----------
    one : ChainRecording
    error_rad, sd_rad : (n, 2) arrays, rad, steering and throttle
    window_s : s, start and length of what is kept sample by sample, thinned to ``POINTS``

    Returns
    -------
    dict
        ``start_s``, ``step_s``; ``edges_deg`` of bins of the throttle's true angle; and by angle
        ``true_deg``, ``error_deg``, ``sd_deg`` over time, ``pieces_deg``, mean error in each
        ten seconds, ``bins_deg``, mean error in each bin. None stands where no reference is.
    """
    rate = one.ride.sampling_rate_hz
    first, count = (round(t * rate) for t in window_s)
    count = min(count, len(one.ride) - first)
    every = max(1, count // POINTS)
    here = slice(first, first + every * POINTS, every)
    true_deg = np.rad2deg(one.true_rad)
    throttle = true_deg[:, 1]
    low, high = np.nanmin(throttle), np.nanmax(throttle)
    edges = np.arange(np.floor(low / BIN_DEG), np.ceil(high / BIN_DEG) + 1) * BIN_DEG
    piece = np.arange(len(one.ride)) // round(PIECE_S * rate)
    series: Numbers = {
        "start_s": rounded(first / rate, 2),
        "step_s": every / rate,
        "edges_deg": edges.tolist(),
    }
    bins = np.digitize(throttle, edges)
    for k, angle in enumerate(ANGLES):
        error = np.rad2deg(error_rad[:, k])
        series[angle] = {
            "true_deg": _listed(true_deg[here, k], 1),
            "error_deg": _listed(error[here], 2),
            "sd_deg": _listed(np.rad2deg(sd_rad[here, k]), 2),
            "pieces_deg": _listed([_mean(error[piece == j]) for j in range(piece[-1] + 1)], 2),
            "bins_deg": _listed([_mean(error[bins == j]) for j in range(1, len(edges))], 2),
        }
    return series


def _mean(values: FloatArray) -> float:
    there = np.isfinite(values)
    return float(values[there].mean()) if there.any() else np.nan


def _listed(values: ArrayLike, digits: int) -> list[float | None]:
    return [rounded(v, digits) if np.isfinite(v) else None for v in np.asarray(values, float)]


def error_causes(one: ChainRecording, error_rad: FloatArray) -> Numbers:
    """Two simple shapes of an error: one constant, and a delay of the reference.

    A reference that is late by t differs by t times the rate of the angle.

    Parameters
    ----------
    one : ChainRecording
    error_rad : (n, 2) array, rad

    Returns
    -------
    dict by angle: ``constant``, part of the mean square error that its mean is; ``rate_degps``,
    root mean square of the true rate; ``delay_ms``, that fits the rest of the error best;
    ``explained``, part of that rest which the delay takes away; the last two None for an angle that
    does not move
    """
    causes: Numbers = {}
    for k, angle in enumerate(ANGLES):
        rate = np.gradient(one.true_rad[:, k], one.ride.time_s)
        error = error_rad[:, k]
        there = np.isfinite(rate) & np.isfinite(error)
        rate, error = rate[there], error[there]
        rest = error - error.mean()
        causes[angle] = {
            "constant": rounded(error.mean() ** 2 / np.mean(error**2), 3),
            "rate_degps": rounded(np.rad2deg(np.sqrt(np.mean(rate**2))), 1),
            "delay_ms": None,
            "explained": None,
        }
        if rate.any():
            delay = float(rest @ rate / (rate @ rate))
            left = np.mean((rest - delay * rate) ** 2) / np.mean(rest**2)
            causes[angle] |= {
                "delay_ms": rounded(1e3 * delay, 1),
                "explained": rounded(1 - left, 3),
            }
    return causes


def settings_variants(one: ChainRecording) -> list[Numbers]:
    """Errors with other assumptions: errors left out, sizes halved and doubled.

    Parameters
    ----------
    one : ChainRecording

    Returns
    -------
    list of dict: ``variant``, and by angle ``rms_deg``, ``sd_ratio`` and ``covered``
    """
    usual = FusionSettings()
    clock_s = 0.5 / one.ride.sampling_rate_hz
    constants = dict.fromkeys(CONSTANTS, 1e-6)
    white = {"disturbance_sd_mps2": 1e-6, "flexing_sd_rad": NOTHING, "clock_sd_s": NOTHING}
    variants = {
        "as it is": RideSettings(method="fusion"),
        "white noise only": _with(**constants, **white),
        "no constants": _with(**constants),
        "past only": RideSettings(method="fusion", smooth=False),
    }
    sizes = {name: getattr(usual, name) for name in SWEPT} | {"clock_sd_s": clock_s}
    for name, size in sizes.items():
        variants[f"{name} / 2"] = _with(**{name: size / 2})
        variants[f"{name} × 2"] = _with(**{name: size * 2})
    rows = []
    for name, settings in variants.items():
        errors = errors_by_angle(one.estimate(settings), one.true_rad)
        kept = ("rms_deg", "sd_ratio", "covered")
        rows.append(
            {"variant": name}
            | {angle: {key: errors[angle][key] for key in kept} for angle in ANGLES}
        )
    return rows


def _with(**sizes: float) -> RideSettings:
    return RideSettings(method="fusion", fusion=dataclasses.replace(FusionSettings(), **sizes))


def fit_to_encoder(one: ChainRecording) -> Numbers:
    """Errors of the lever's sensors by the encoder; no estimate uses them.

    On a fixed horizontal axis gravity in the lever's axes is a circle, and the gyroscope reads the
    encoder's rate.

    Parameters
    ----------
    one : ChainRecording of the motorised hinge

    Returns
    -------
    dict: ``offset_mg`` and ``scale_percent`` of both accelerometer axes across the shaft,
    ``leaving_mg``, standard deviation of what the fit leaves; ``gyr_offset_degps`` and
    ``gyr_scale_percent`` along the shaft
    """
    angle = one.true_rad[:, 1]
    rate = np.gradient(angle, one.ride.time_s)
    there = np.isfinite(rate) & np.isfinite(angle)
    angle, rate = angle[there], rate[there]
    across = one.ride.sensor("lever").acc_mps2[there, 1:] / STANDARD_GRAVITY_MPS2
    circle = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
    found, *_ = np.linalg.lstsq(circle, across, rcond=None)
    line = np.column_stack([np.ones_like(rate), rate])
    spin = one.ride.gyroscope("lever")[there, 0]
    # A positive throttle turns the lever about -x.
    (offset, gain), *_ = np.linalg.lstsq(line, spin, rcond=None)
    return {
        "offset_mg": [rounded(v, 1) for v in 1e3 * found[0]],
        "scale_percent": [rounded(v, 1) for v in 100 * (np.hypot(found[1], found[2]) - 1)],
        "leaving_mg": [rounded(v, 1) for v in 1e3 * (across - circle @ found).std(axis=0)],
        "gyr_offset_degps": rounded(np.rad2deg(offset), 2),
        "gyr_scale_percent": rounded(100 * (abs(gain) - 1), 2),
    }
