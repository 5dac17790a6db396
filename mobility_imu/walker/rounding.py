"""What the steps of a coarsely read gyroscope cost in the heading."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from mobility_imu.faults import Fault
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.quality import resolution_of
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.reach import FRAME, is_of_half, samples_unknown
from mobility_imu.walker.trajectory import Trajectory

__all__ = ["coarse_rates", "rounded_mean_sd"]

HARMONICS = np.arange(1, 200)
"""Terms of the series; without noise those beyond are 0.2 % of the standard deviation."""
SHORTEST_REST_S = 0.3
"""Shortest rest whose scatter counts. Our choice, not swept."""


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
    scatter = np.median([rates[rest].var(axis=0) for rest in rests], axis=0)
    off = rounded_mean_sd(step, np.sqrt(np.maximum(scatter - step**2 / 12, 0.0)))
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
