"""A gyroscope that is in deg/s in one part of a recording and in rad/s in the other.

Where rates are 57 times too large, they say turns about level axes that gravity would show; where
the sensor moves as much and the rates are right, none do.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of

__all__ = ["UnitChange", "find_unit_change"]

WINDOW_S = 0.5
"""Readings are averaged over it: a push is over by then, and a frame has hardly turned."""
LEAST_TURN_MPS2 = 3.0
"""Least change of gravity, as the rates tell it, that is held against what is felt: a third of it.
Set by hand."""
TIMES_FELT = 4.0
"""A turn that gravity does not show is told so many times as large as what is felt. No half second
of 27 recordings of frames and chairs has one."""
FEWEST_WINDOWS, LEAST_PART = 5, 0.1
"""Such half seconds in the part in deg/s: their number, and their fraction."""
SHORTEST_S = 5.0
"""Shortest part of the recording that is held against the other."""
LEAST_MOTION = 0.5
"""How much one part moves, as a fraction of the other, to be compared with it."""
DEG = float(np.rad2deg(1.0))
MOST_TIMES = 2.0
"""The parts' rates differ by the ratio of the units, times or over this: nobody moves evenly."""


class UnitChange(NamedTuple):
    """Part of a recording whose rates are 57 times those of the other.

    Parameters
    ----------
    start_s, stop_s : s, of the part, to half a second or where the first turn shows it
    sentence : for the user
    """

    start_s: float
    stop_s: float
    sentence: str


def find_unit_change(recording: Recording, name: str = "frame") -> UnitChange | None:
    """Where the unit of a gyroscope changes within a recording, as far as gravity shows it.

    Parameters
    ----------
    recording : Recording
    name : sensor on what neither spins nor falls

    Returns
    -------
    UnitChange, None if there is none or if one part is at rest, in which nothing shows
    """
    imu, rate_hz = recording.sensor(name), recording.sampling_rate_hz
    if imu.gyr_radps is None:
        return None
    width = max(1, round(WINDOW_S * rate_hz))
    count = len(imu) // width
    if count < 2 * SHORTEST_S / WINDOW_S:
        return None
    force = _means(imu.acc_mps2, width)
    turned = np.cumsum(imu.gyr_radps, axis=0)[width // 2 :: width][:count] / rate_hz
    told = np.cross(np.diff(turned, axis=0), (force[1:] + force[:-1]) / 2)
    told, felt = (np.linalg.norm(each, axis=1) for each in (told, np.diff(force, axis=0)))
    # Where nothing at all is felt, the accelerometer is frozen.
    unseen = (told > LEAST_TURN_MPS2) & (told > TIMES_FELT * felt) & (felt > 0)
    if unseen.sum() < FEWEST_WINDOWS:
        return None
    rates = np.sqrt(_means((imu.gyr_radps**2).sum(axis=1, keepdims=True), width)[1:, 0])
    change = _step(np.log(np.maximum(rates, 1e-6)))
    for part in (np.arange(count - 1) >= change, np.arange(count - 1) < change):
        if _differ(part, unseen, felt, rates):
            (run,) = runs_of(part)
            start, stop = recording.time_s[[run.start * width, min(run.stop * width, len(imu)) - 1]]
            return UnitChange(
                float(start),
                float(stop),
                f"{recording.source}: {name}_gyr reads about {_rms(rates, part):.2g} rad/s from "
                f"{start:.0f} to {stop:.0f} s and {_rms(rates, ~part):.2g} rad/s elsewhere, where "
                "it moves alike, and gravity does not show these turns: is it in deg/s there? "
                "Convert these rows",
            )
    return None


def _means(values: FloatArray, width: int) -> FloatArray:
    count = len(values) // width
    return np.asarray(values[: count * width].reshape(count, width, -1).mean(axis=1))


def _step(values: FloatArray) -> int:
    """Where a series steps from one level to another, by least squares; from 1."""
    count = np.arange(1, len(values))
    sums = np.cumsum(values)
    before, after = sums[:-1], sums[-1] - sums[:-1]
    return 1 + int(np.argmax(before**2 / count + after**2 / (len(values) - count)))


def _rms(values: FloatArray, where: NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(values[where] ** 2)))


def _differ(
    part: NDArray[np.bool_], unseen: NDArray[np.bool_], felt: FloatArray, rates: FloatArray
) -> bool:
    """Whether a part has rates in another unit than the rest, which moves alike."""
    if (~part).sum() * WINDOW_S < SHORTEST_S or unseen[part].mean() < LEAST_PART:
        return False
    if unseen[~part].any():
        return False
    if _rms(felt, ~part) < LEAST_MOTION * _rms(felt, part):
        return False
    ratio = _rms(rates, part) / max(_rms(rates, ~part), 1e-9)
    return DEG / MOST_TIMES < ratio < DEG * MOST_TIMES
