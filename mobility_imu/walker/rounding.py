"""What the steps of a coarsely read gyroscope cost in the heading."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from mobility_imu.faults import Fault
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.health import fault_of
from mobility_imu.quality import resolution_of
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.reach import FRAME, is_of_half, samples_unknown
from mobility_imu.walker.rest_checks import Readings
from mobility_imu.walker.trajectory import Trajectory

__all__ = ["coarse_rates", "rounded_mean_sd", "unsure_by_rounding"]

HARMONICS = np.arange(1, 200)
"""Terms of the series; without noise those beyond are 0.2 % of the standard deviation."""
SHORTEST_REST_S = 0.3
"""Shortest rest whose scatter counts. Our choice, not swept."""
ROUGH_MPS2 = 0.035
"""Error of gravity at rest by rounding that counts. Two axes in steps of 0.1 m/s² without noise
have 0.041; recordings of the level "real" have up to 0.029, and their limits are set with it."""
LAG_PER_MPS2, SCALE_PER_MPS2 = 2.0, 3.0
"""Lag, s, and scale, 1, that rounding makes up at most, for each m/s² of that error. Of 24
simulated walks (three levels) in steps of 0.25 m/s² the largest are 1.5 and 2.7."""
MOVE_S = 1.0
"""Length of a usual move, in which the gyroscope's error turns gravity."""


def rounded_mean_sd(step: FloatArray, noise: FloatArray) -> FloatArray:
    """Standard deviation of the mean of a rounded value with noise, over where the value may lie.

    Without noise it is step / sqrt(12), as the value lies anywhere in its step; noise of half a
    step takes it away (Widrow and Kollar, Quantization Noise, 2008: the mean error is a Fourier
    series in the value, whose terms the noise's characteristic function damps).

    Parameters
    ----------
    step : (k,) array, distance of two readings
    noise : (k,) array, standard deviation of the noise before rounding, same unit

    Returns
    -------
    (k,) array, same unit

    Examples
    --------
    >>> rounded_mean_sd(np.array([1.0, 1.0]), np.array([0.0, 0.5])).round(2).tolist()
    [0.29, 0.0]
    """
    step, noise = np.asarray(step, float), np.asarray(noise, float)
    part = np.where(step > 0, noise / np.where(step > 0, step, 1.0), np.inf)
    damped = np.exp(-((2 * np.pi * np.outer(part, HARMONICS)) ** 2)) / HARMONICS**2
    return np.asarray(step / np.pi * np.sqrt(damped.sum(axis=1) / 2))


def unsure_by_rounding(readings: Readings) -> tuple[float, float]:
    """Lag and scale of the gyroscope that coarse steps alone may make up.

    A frame stands nearly alike in all rests, so that rounding errs by the same in each.

    Parameters
    ----------
    readings : Readings

    Returns
    -------
    float, float : s and 1; 0 where noise takes the steps away
    """
    count = max(3, round(SHORTEST_REST_S * readings.rate_hz))
    rests = runs_of(long_runs(readings.still_and_known, count, grow=False))
    if not rests:
        return 0.0, 0.0
    acc, gyr = (
        float(np.linalg.norm(_hidden(values, rests, readings.lost)))
        for values in (readings.acc_mps2, readings.gyr_radps)
    )
    rough = float(np.hypot(acc, STANDARD_GRAVITY_MPS2 * MOVE_S * gyr))
    return (LAG_PER_MPS2 * rough, SCALE_PER_MPS2 * rough) if rough > ROUGH_MPS2 else (0.0, 0.0)


def _hidden(
    values: FloatArray, rests: Sequence[slice], skip: NDArray[np.bool_] | None
) -> FloatArray:
    """Standard deviation of a rest's mean by the steps of the readings, for each axis."""
    step = resolution_of(values, skip=skip).step
    scatter = np.median([values[rest].var(axis=0) for rest in rests], axis=0)
    return rounded_mean_sd(step, np.sqrt(np.maximum(scatter - step**2 / 12, 0.0)))


def coarse_rates(
    recording: Recording, found: Trajectory, mount: WalkerMount, known: Iterable[Fault] = ()
) -> Iterator[Fault]:
    """A gyroscope whose offset at rest hides within its steps, and what that may turn the path by.

    At rest it reads one number, wherever the rate lies within the step; in a move the readings
    average out. Their difference turns the heading for as long as the frame moves.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    found : Trajectory of its last samples
    mount : WalkerMount
    known : Fault, of the recording; where the gyroscope is frozen or cut off, and in a gap that was
        filled, the readings say nothing of its steps

    Yields
    ------
    Fault; none if it turns the path by less than the heading's sd
    """
    rates = recording.gyroscope(FRAME)[-len(found) :]
    interval_s = float(np.median(np.diff(found.time_s)))
    count = max(3, round(SHORTEST_REST_S / interval_s))
    silent = [fault for fault in known if fault.code == "gap" or is_of_half(fault, "gyr")]
    broken = samples_unknown(silent, len(recording))[-len(found) :]
    rests = runs_of(long_runs(found.stationary & ~broken, count, grow=False))
    step = resolution_of(rates, skip=broken).step
    if not rests or not step.any():
        return
    off = _hidden(rates, rests, broken)
    about_up = float(np.linalg.norm(off * mount.rotation_imu_to_body[2]))
    moving = ~found.stationary if found.settings.zero_rate else np.ones(len(found), np.bool_)
    heading = about_up * interval_s * np.count_nonzero(moving)
    if heading <= found.yaw_sd_rad[-1]:
        return
    largest, turned = float(np.rad2deg(step.max())), float(np.rad2deg(heading))
    yield fault_of(
        recording, "coarse", f"{FRAME}_gyr", np.ones(len(recording), np.bool_),
        f"reads in steps of {largest:.2g} deg/s, in which its offset at rest cannot be seen; that "
        f"may turn the path by {turned:.2g} deg (one standard deviation): export more digits, or "
        "set a smaller range", size=largest, unit="deg/s",
    )  # fmt: skip
