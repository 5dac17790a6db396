"""Passes of the fusion over a recording: inputs, noise sizes, filter, smoother, and again.

The first pass of the filter tells the noise. The next ones run filter and smoother, each around the
angles and constants that the pass before found from the whole recording, until these no longer move
(Gauss-Newton; Bell, The iterated Kalman smoother as a Gauss-Newton method, SIAM J. Optim. 4, 1994).
A filter that takes its slopes along its own way takes some from angles that it later knows to be
wrong, and so believes more than the readings tell.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import ndimage, signal

from mobility_imu._compiled import choose
from mobility_imu.frames import FloatArray
from mobility_imu.hinges import column_vector, steered
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.fusion_filter import (
    ARMS,
    BODY,
    CONSTANTS,
    STATES,
    Chunk,
    Estimate,
    Inputs,
    Model,
    plain,
    run_filter,
    run_smoother,
)
from mobility_imu.scooter.fusion_noise import (
    acceleration_noise,
    bounded_and_wandering,
    smallest_step,
    white_and_coloured,
)
from mobility_imu.scooter.fusion_settings import (
    FROM_THE_RECORDING,
    SETTING_LIMITS,
    SMALLEST_DISTURBANCE_MPS2,
    SMALLEST_RATE_NOISE,
    FusionSettings,
)
from mobility_imu.scooter.geometry import ScooterGeometry

__all__ = ["Problem", "Readings", "first_angles", "locked_rate", "prepared", "run_passes"]

READINGS_SMOOTHING_S = 0.02
"""Width of the Gaussian that smooths accelerations and the rates' derivatives alike; the controls
turn within 0.1 s."""
SLOPES_SMOOTHING_S = 0.3
"""Width of the Gaussian over which the body's acceleration is smoothed for the slopes; shaking by
tyres and ground begins at 2 Hz. The causal filter has three low-passes of a third of it."""
START_SD_RAD = 0.35
"""How far the first angles may be off."""
PLAIN_S_PER_SAMPLE = 5e-4
"""Seconds that all passes take for a sample where nothing is compiled."""
CHUNK_SAMPLES = 20_000
"""Samples of which the smoother keeps everything at once; for more the filter runs again."""
MOST_PASSES = 5
"""Passes of filter and smoother at most."""
NEAR = 0.1
"""Passes end when both angles move by less than this part of their standard deviation (rms)."""
NOWHERE = np.empty((0, STATES))
"""In place of states to linearise around: around those that the filter knows."""


class Readings(NamedTuple):
    """Contiguous (n, 3) arrays of all four sensors, m/s² and rad/s, in {T} and {B}."""

    lever_acc: FloatArray
    lever_gyr: FloatArray
    body_acc: FloatArray
    body_gyr: FloatArray


class Loops(NamedTuple):
    """Filter and smoother, compiled or plain."""

    run_filter: Callable[..., tuple[Chunk, Estimate]]
    run_smoother: Callable[..., tuple[FloatArray, ...]]


class Problem(NamedTuple):
    """A recording as the passes need it.

    Parameters
    ----------
    inputs : Inputs
    smoothed : by how much its accelerations are smoothed: white noise keeps this part of its
        variance, 1 of it
    geometry : ScooterGeometry
    rate_hz : Hz
    run : loops, compiled or plain
    """

    inputs: Inputs
    smoothed: float
    geometry: ScooterGeometry
    rate_hz: float
    run: Loops


class Seen(NamedTuple):
    """What a pass leaves: angles and all states, their sd, residuals, and the constants."""

    states: FloatArray
    sd: FloatArray
    residuals: FloatArray
    constants: FloatArray


def prepared(
    readings: Readings, geometry: ScooterGeometry, rate_hz: float, smooth: bool
) -> Problem:
    """Recording with the rates' derivatives and the slow acceleration; loops for it.

    Parameters
    ----------
    readings : Readings
    geometry : ScooterGeometry
    rate_hz : Hz
    smooth : whether both may look ahead

    Returns
    -------
    Problem
    """
    inputs, smoothed = _ahead(readings, rate_hz) if smooth else _causal(readings, rate_hz)
    return Problem(inputs, smoothed, geometry, rate_hz, _loops(inputs, geometry, rate_hz))


def _ahead(readings: Readings, rate_hz: float) -> tuple[Inputs, float]:
    """Accelerations and the rates' derivatives, smoothed alike; by how much.

    A derivative must be smoothed, or noise passes for motion. Shaking that it loses and the
    acceleration keeps would make the lever arms grow, to metres.
    """
    width = READINGS_SMOOTHING_S * rate_hz

    def smoothed(values: FloatArray, width: float, order: int = 0) -> FloatArray:
        found = ndimage.gaussian_filter1d(
            values,
            width,
            axis=0,
            order=order,
            mode="nearest",
            radius=min(int(4 * width + 0.5), max(len(values), 1)),
        )
        return np.ascontiguousarray(found * rate_hz**order)

    at = np.arange(-int(4 * width + 0.5), int(4 * width + 0.5) + 1)
    weights = np.exp(-((at / width) ** 2) / 2)
    weights /= weights.sum()
    inputs = Inputs(
        smoothed(readings.lever_acc, width),
        readings.lever_gyr,
        smoothed(readings.body_acc, width),
        readings.body_gyr,
        smoothed(readings.lever_gyr, width, 1),
        smoothed(readings.body_gyr, width, 1),
        smoothed(readings.body_acc, SLOPES_SMOOTHING_S * rate_hz),
    )
    return inputs, float(1 / (weights @ weights))


def _causal(readings: Readings, rate_hz: float) -> tuple[Inputs, float]:
    """The same from the past alone: no smoothing, differences, and three low-passes in a row."""
    spins = (
        np.diff(gyr, axis=0, prepend=gyr[:1]) * rate_hz
        for gyr in (readings.lever_gyr, readings.body_gyr)
    )
    gain = 1 / (1 + SLOPES_SMOOTHING_S / 3 * rate_hz)
    slow = readings.body_acc
    start = (1 - gain) * np.median(slow[: max(1, round(0.5 * rate_hz))], axis=0)[None]
    for _ in range(3):
        slow, _ = signal.lfilter([gain], [1, gain - 1], slow, axis=0, zi=start)
    lever_spin, body_spin = (np.ascontiguousarray(spin) for spin in spins)
    return Inputs(*readings, lever_spin, body_spin, np.ascontiguousarray(slow)), 1.0


def run_passes(
    problem: Problem, asked: FusionSettings, smooth: bool
) -> tuple[FloatArray, FloatArray, FusionSettings]:
    """Angles, their sd, and settings with what the recording tells.

    Parameters
    ----------
    problem : Problem
    asked : FusionSettings
    smooth : whether each angle uses the whole recording

    Returns
    -------
    angles, sd : (n, 2) arrays, rad, with what flexing and the clock add
    settings : FusionSettings
    """
    settings = asked
    if not asked.complete:
        first = _first_guess(asked, problem)
        settings = _measured(asked, first, _filtered(problem, first), problem)
    if smooth:
        seen = _iterated(problem, settings)
        if asked.flexing_sd_rad is None:
            # By angles from the whole recording the locked axis is known better.
            settings = dataclasses.replace(settings, flexing_sd_rad=_flexing(seen, problem)[0])
    else:
        seen = _filtered(problem, settings)
    angles = seen.states[:, :2]
    added = _added_variance(angles, settings, problem.rate_hz, smooth)
    return angles, np.sqrt(seen.sd**2 + added), settings


def _iterated(problem: Problem, settings: FusionSettings) -> Seen:
    """Filter and smoother, around what they found the time before, until the angles stay.

    From the third pass on the way is halved, for whole steps may swing from side to side.
    """
    about, constants = NOWHERE, np.zeros(CONSTANTS)
    for number in range(MOST_PASSES):
        seen = _smoothed(problem, settings, about, constants)
        if number:
            moved = (seen.states - about)[:, :2] / np.maximum(seen.sd, 1e-12)
            if np.sqrt(np.mean(moved**2, axis=0)).max() < NEAR:
                break
        part = 0.5 if number > 1 else 1.0
        about = seen.states if part == 1.0 else about + part * (seen.states - about)
        constants = constants + part * (seen.constants - constants)
    return seen


def _loops(inputs: Inputs, geometry: ScooterGeometry, rate_hz: float) -> Loops:
    """Loops as machine code, if that is there or is worth its time, else as plain Python."""
    guess = FusionSettings(**dict.fromkeys(FROM_THE_RECORDING, 0.01))
    model, start = _model(guess, geometry, rate_hz), _start(inputs, guess, geometry, rate_hz)
    none = (inputs, 0, 0, start, model, False, NOWHERE, start.constants)
    empty = Chunk(
        np.empty((0, STATES)), np.empty((0, 2)), np.empty((0, 3)), np.empty((0, STATES, STATES)),
        np.empty((0, STATES)), np.empty((0, STATES, STATES)), np.empty((0, STATES, CONSTANTS)),
    )  # fmt: skip
    back = (empty, *start)
    way = choose(
        {run_filter: none, run_smoother: back},
        plain_s=len(inputs.lever_acc) * PLAIN_S_PER_SAMPLE,
        what="scooter's fusion",
    )
    if way == "compiled":
        return Loops(run_filter, run_smoother)
    return Loops(plain(run_filter), plain(run_smoother))


def _first_guess(settings: FusionSettings, problem: Problem) -> FusionSettings:
    """Settings for a first pass, from the lengths of the accelerations alone."""
    inputs = problem.inputs
    step = settings.acc_step_mps2 or smallest_step(inputs.lever_acc, inputs.body_acc)
    noise = acceleration_noise(inputs.lever_acc, inputs.body_acc) * problem.smoothed**0.5
    guesses = (
        max(noise, step),
        step,
        SMALLEST_DISTURBANCE_MPS2,
        SMALLEST_RATE_NOISE,
        SETTING_LIMITS["flexing_sd_rad"][0],
        max(SETTING_LIMITS["clock_sd_s"][0], 0.5 / problem.rate_hz),
    )
    missing = {
        name: guess
        for name, guess in zip(FROM_THE_RECORDING, guesses, strict=True)
        if getattr(settings, name) is None
    }
    return dataclasses.replace(settings, **missing)


def _measured(
    settings: FusionSettings, first: FusionSettings, seen: Seen, problem: Problem
) -> FusionSettings:
    """Settings with what the residuals and the locked axis of a first pass show."""
    found: dict[str, float | None] = {}
    # While it learns the constants, the residuals are not yet noise.
    settled = seen.residuals[len(seen.residuals) // 10 :]
    noise = white_and_coloured(
        settled, problem.rate_hz, settings.disturbance_time_s, problem.smoothed
    )
    if noise is not None:
        assert first.acc_step_mps2 is not None
        found["acc_sd_mps2"] = max(noise[0], first.acc_step_mps2)
        found["disturbance_sd_mps2"] = max(noise[1], SMALLEST_DISTURBANCE_MPS2)
    found["flexing_sd_rad"], density = _flexing(seen, problem)
    found["rate_noise_radps_sqrthz"] = max(density, SMALLEST_RATE_NOISE)
    changes = {}
    for name in FROM_THE_RECORDING:
        if getattr(settings, name) is None:
            low, high = SETTING_LIMITS[name]
            value = found.get(name) or getattr(first, name)
            changes[name] = float(np.clip(value, low, high))
    return dataclasses.replace(settings, **changes)


def _flexing(seen: Seen, problem: Problem) -> tuple[float, float]:
    """Angle of flexing, within the limits of the setting, and density of the rates' noise."""
    inputs = problem.inputs
    locked = locked_rate(inputs.lever_gyr, inputs.body_gyr, seen, problem.geometry)
    angle, density = bounded_and_wandering(locked, problem.rate_hz)
    low, high = SETTING_LIMITS["flexing_sd_rad"]
    return float(np.clip(angle, low, high)), density


def locked_rate(
    lever_gyr: FloatArray, body_gyr: FloatArray, seen: Seen, geometry: ScooterGeometry
) -> FloatArray:
    """Rate about the axis at right angles to both hinges: nothing can turn there but by flexing.

    Parameters
    ----------
    lever_gyr, body_gyr : (n, 3) arrays, rad/s, in {T} and {B}
    seen : states and constants of a pass
    geometry : ScooterGeometry

    Returns
    -------
    (n,) array, rad/s
    """
    lever, body = (
        gyr - np.cross(c[6:9] + c[15:18], gyr) - c[9:12] * gyr - c[12:15]
        for gyr, c in ((lever_gyr, seen.constants), (body_gyr, seen.constants[BODY:]))
    )
    tip = seen.states[:, 1] + geometry.lean_rad
    _, ahead = steered(column_vector(body, geometry.steering_inclination_rad), seen.states[:, 0])
    return np.asarray(lever[:, 1] * np.cos(tip) + lever[:, 2] * np.sin(tip) - ahead)


def _added_variance(
    angles: FloatArray, settings: FusionSettings, rate_hz: float, smooth: bool
) -> FloatArray:
    """What flexing and the clock add to the variance of both angles, rad²."""
    assert settings.flexing_sd_rad is not None and settings.clock_sd_s is not None
    if smooth and len(angles) > 1:
        rates = np.gradient(angles, 1 / rate_hz, axis=0)
    else:
        rates = np.diff(angles, axis=0, prepend=angles[:1]) * rate_hz
    return np.asarray(settings.flexing_sd_rad**2 + (settings.clock_sd_s * rates) ** 2)


def _model(
    settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float, smoothed: float = 1.0
) -> Model:
    """Model of the loops; all that the recording tells is in the settings."""
    assert settings.acc_sd_mps2 is not None and settings.disturbance_sd_mps2 is not None
    assert settings.rate_noise_radps_sqrthz is not None
    alpha, dt = geometry.steering_inclination_rad, 1 / rate_hz
    return Model(
        dt,
        float(np.sin(alpha)),
        float(np.cos(alpha)),
        float(geometry.lean_rad),
        float(settings.acc_sd_mps2**2),
        float(settings.disturbance_sd_mps2**2),
        float(np.exp(-dt / settings.disturbance_time_s)),
        np.array([settings.rate_noise_radps_sqrthz**2 * dt, settings.bias_walk_radps**2 * dt]),
        # A smoothed residual is as much smaller than the white noise that it stands for.
        float(settings.huber) / smoothed**0.5,
    )


def _start(
    inputs: Inputs, settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float
) -> Estimate:
    """What is assumed at the start: angles of the first half second, all constants zero."""
    assert settings.disturbance_sd_mps2 is not None
    angles = first_angles(inputs.lever_acc, inputs.body_acc, rate_hz, geometry)
    # The drift is what wanders: the offset it starts from is among the constants.
    sd = np.array([START_SD_RAD] * 2 + [1e-6] * 2 + [settings.disturbance_sd_mps2] * 3)
    sensor = np.repeat(
        [
            settings.acc_offset_sd_mps2,
            settings.acc_scale_sd,
            settings.misalignment_sd_rad,
            settings.gyr_scale_sd,
            settings.bias_sd_radps,
            settings.axes_apart_sd_rad,
        ],
        3,
    )
    arms = np.full(CONSTANTS - ARMS, settings.lever_arm_sd_m)
    return Estimate(
        np.concatenate((angles, np.zeros(STATES - 2))),
        np.diag(sd**2),
        np.zeros((STATES, CONSTANTS)),
        np.zeros(CONSTANTS),
        np.diag(np.concatenate((sensor, sensor, arms)) ** 2),
    )


def _filtered(problem: Problem, settings: FusionSettings) -> Seen:
    """One pass of the filter over the recording."""
    inputs, geometry, rate_hz = problem.inputs, problem.geometry, problem.rate_hz
    start = _start(inputs, settings, geometry, rate_hz)
    model = _model(settings, geometry, rate_hz, problem.smoothed)
    count = len(inputs.lever_acc)
    chunk, after = problem.run.run_filter(
        inputs, 0, count, start, model, False, NOWHERE, start.constants
    )
    return Seen(chunk.states.copy(), chunk.sd, chunk.residuals, after.constants)


def _smoothed(
    problem: Problem, settings: FusionSettings, about: FloatArray, constants: FloatArray
) -> Seen:
    """One pass of filter and smoother, in pieces that fit into memory."""
    inputs, run = problem.inputs, problem.run
    model = _model(settings, problem.geometry, problem.rate_hz, problem.smoothed)
    borders = [*range(0, len(inputs.lever_acc), CHUNK_SAMPLES), len(inputs.lever_acc)]
    pieces = list(pairwise(borders))
    at = [_start(inputs, settings, problem.geometry, problem.rate_hz)]
    residuals = []
    for piece in pieces:
        keep = piece is pieces[-1]
        kept, after = run.run_filter(inputs, *piece, at[-1], model, keep, about, constants)
        at.append(Estimate(*(np.ascontiguousarray(part) for part in after)))
        residuals.append(kept.residuals)
    last = at[-1]
    state, covariance, by_constants = last.state, last.covariance, last.by_constants
    found, sd = [], []
    for piece, before in zip(pieces[::-1], at[-2::-1], strict=True):
        if piece is not pieces[-1]:
            kept, _ = run.run_filter(inputs, *piece, before, model, True, about, constants)
        given = (np.ascontiguousarray(part) for part in (state, covariance, by_constants))
        states, spread, state, covariance, by_constants = run.run_smoother(
            kept, *given, last.constants, last.constants_covariance
        )
        found.append(states)
        sd.append(spread)
    return Seen(
        np.concatenate(found[::-1]),
        np.concatenate(sd[::-1]),
        np.concatenate(residuals),
        last.constants,
    )


def first_angles(
    lever_acc: FloatArray, body_acc: FloatArray, rate_hz: float, geometry: ScooterGeometry
) -> FloatArray:
    """Both angles by the median of the first half second.

    Parameters
    ----------
    lever_acc, body_acc : (n, 3) arrays, m/s², in {T} and {B}
    rate_hz : Hz
    geometry : ScooterGeometry

    Returns
    -------
    (2,) array, rad
    """
    first = slice(0, max(1, round(0.5 * rate_hz)))
    lever, body = (np.median(acc[first], axis=0) for acc in (lever_acc, body_acc))
    return np.array(three_axis_angles(lever, body, geometry), float)
