"""What an accelerometer of a scooter must feel: gravity, everywhere and always.

A scooter neither falls nor flies, and drives slowly. So the length of what an accelerometer reads
is gravity's, to within what shaking, turning and driving add, and its readings are new ones at each
sample.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.faults import Fault, interpolated, multiplied
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.health import fault_of
from mobility_imu.quality import (
    FELT_STEPS,
    FINE_REPEATS,
    frozen_samples,
    resolution_of,
    same_as_before,
)
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of

__all__ = [
    "PoseLength",
    "ends_in_a_jump",
    "forceless",
    "held_faults",
    "held_samples",
    "is_wrong_length",
    "length_of_gravity",
    "scale_fault",
    "weightless",
    "wrong_length",
    "wrong_lengths",
]

MEAN_S = 0.5
"""Readings are averaged over this, or their lengths: blows last shorter."""
LEAST_FORCE = 0.5
"""Part of gravity below which no mean length can be: a scooter that drops off a kerb of 0.1 m falls
for 0.14 s, which leaves 0.7."""
LARGEST_SCALE = 1.2
"""Factor by which the length of gravity may be off, either way: 8.2 to 11.8 m/s². Accelerometers of
consumer sensors have read 8.45 to 11.2 in recordings of others (data/reference/real_sensors.csv),
offsets among it."""
SHORTEST_HELD_S = 0.05
"""Readings that repeat for as long are late by half of it on average, 25 ms."""
FEWEST_HELD = 3
"""... and more samples than a doubled one."""
LEAST_HELD = 0.05
"""Part of the samples from which on held readings are told: four times what sound rides have
(simulated, seeds 2 to 13, rests of coarse sensors among them: 1.1 % at most)."""


def forceless(acc_mps2: FloatArray, sampling_rate_hz: float) -> NDArray[np.bool_]:
    """Where an accelerometer feels no gravity.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s²
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) bool array
    """
    length = np.linalg.norm(acc_mps2, axis=1)
    width = max(1, round(MEAN_S * sampling_rate_hz))
    least = LEAST_FORCE * STANDARD_GRAVITY_MPS2
    lost = ndimage.uniform_filter1d(length, width) < least
    # Means are half lost at the ends of a loss.
    beside = ndimage.binary_dilation(lost, iterations=width) & (length < least)
    return np.asarray(lost | beside)


def length_of_gravity(acc_mps2: FloatArray, sampling_rate_hz: float) -> float:
    """Length that an accelerometer reads of gravity, as near to the right one as it may be.

    A mean of half a second is right where the sensor is shaken, and too short where it turns: by
    sin(x) / x, with x half the turn, so by 1.2 for a sensor that turns at 240 deg/s. The length of
    a single reading does not change with a turn; shaking across gravity makes it longer, and so
    does a lever arm in a turn. What is read of gravity lies between the medians of both. In rides
    they are within 3 % of each other (simulated on all courses, seeds 930,000 to 930,003); on cars'
    and chairs' wheels in recordings of others the second is up to 3.6 times the first, and right.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s²
    sampling_rate_hz : Hz

    Returns
    -------
    float, m/s²
    """
    width = max(1, round(MEAN_S * sampling_rate_hz))
    mean = ndimage.uniform_filter1d(acc_mps2, width, axis=0)
    both = (np.median(np.linalg.norm(vectors, axis=1)) for vectors in (mean, acc_mps2))
    return float(np.clip(STANDARD_GRAVITY_MPS2, *sorted(both)))


def wrong_length(acc_mps2: FloatArray, sampling_rate_hz: float) -> float | None:
    """Length of gravity if no sensor in m/s² reads such a one; None if one can.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s²
    sampling_rate_hz : Hz

    Returns
    -------
    float, m/s², or None
    """
    felt = ~forceless(acc_mps2, sampling_rate_hz)
    if not felt.any():
        return None
    length = length_of_gravity(acc_mps2[felt], sampling_rate_hz)
    return length if is_wrong_length(length) else None


def is_wrong_length(length_mps2: float) -> bool:
    """Whether no sensor in m/s² reads such a length of gravity.

    Parameters
    ----------
    length_mps2 : m/s²

    Returns
    -------
    bool
    """
    times = length_mps2 / STANDARD_GRAVITY_MPS2
    return not 1 / LARGEST_SCALE <= times <= LARGEST_SCALE


def held_samples(
    values: FloatArray, sampling_rate_hz: float, *, first: bool = False
) -> NDArray[np.bool_]:
    """Where a sensor gives an old reading again, time after time.

    Parameters
    ----------
    values : (n, 3) array, of one half of a sensor
    sampling_rate_hz : Hz
    first : whether the reading that is given again belongs to its repetitions

    Returns
    -------
    (n,) bool array; none where the steps of the sensor
    explain it, or where it is rare
    """
    count = max(FEWEST_HELD, round(SHORTEST_HELD_S * sampling_rate_hz))
    held = long_runs(same_as_before(values), count - 1, grow=False)
    held &= ~frozen_samples(values, sampling_rate_hz)
    if held.mean() < LEAST_HELD:
        return np.zeros(len(values), np.bool_)
    resolution = resolution_of(values, skip=held)
    if not resolution.pairs or resolution.repeats.prod() > FINE_REPEATS ** values.shape[1]:
        # Steps may hold a reading at rest; then the next one is a step away.
        for run in runs_of(held):
            after = np.abs(values[min(run.stop, len(values) - 1)] - values[run.start])
            held[run] = (after > FELT_STEPS * resolution.step).any()
    if held.mean() < LEAST_HELD:
        return np.zeros(len(values), np.bool_)
    return held | np.append(held[1:], False) if first else held


def ends_in_a_jump(
    acc_mps2: FloatArray, frozen: NDArray[np.bool_], *, at_end: bool = False
) -> NDArray[np.bool_]:
    """Repeated readings of which the next one is further away than a step of the sensor at rest.

    A sensor that rests in coarse steps repeats itself as well; it goes on a step away.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s²
    frozen : (n,) bool array, readings that repeat themselves
    at_end : whether to count what goes on until the recording ends: no reading shows what it is

    Returns
    -------
    (n,) bool array
    """
    lost = np.zeros(len(acc_mps2), np.bool_)
    step = resolution_of(acc_mps2, skip=frozen).step
    for run in runs_of(frozen):
        after = np.abs(acc_mps2[run.stop : run.stop + 1] - acc_mps2[run.start])
        lost[run] = bool((after > FELT_STEPS * step).any()) if after.size else at_end
    return lost


def held_faults(recording: Recording, name: str) -> Iterator[Fault]:
    """Halves of a sensor that give old readings again."""
    sensor, rate_hz = recording.sensor(name), recording.sampling_rate_hz
    for half, values in (("acc", sensor.acc_mps2), ("gyr", sensor.gyr_radps)):
        if values is None:
            continue
        held = held_samples(values, rate_hz)
        if held.any():
            starts = int((held & ~np.r_[False, held[:-1]]).sum())
            longest_s = held.sum() / starts / rate_hz
            yield fault_of(
                recording, "held", f"{name}_{half}", held,
                f"gives its last reading again, for {longest_s:.2g} s each time: it is read more "
                "often than it measures, or loses readings; record with its own rate",
                size=float(longest_s), unit="s",
                repair=partial(interpolated, sensor=name, half=half, flags=held),
            )  # fmt: skip


def weightless(recording: Recording, name: str) -> Fault | None:
    """Accelerometer that feels no gravity for a while.

    Parameters
    ----------
    recording : Recording
    name : of the sensor

    Returns
    -------
    Fault, or None
    """
    acc, rate_hz = recording.sensor(name).acc_mps2, recording.sampling_rate_hz
    lost = forceless(acc, rate_hz)
    if not lost.any() or length_of_gravity(acc, rate_hz) < LEAST_FORCE * STANDARD_GRAVITY_MPS2:
        return None  # in g, or dead: the estimate is refused
    return fault_of(
        recording, "no gravity", f"{name}_acc", lost,
        "feels no gravity, which is everywhere: it is dead there; leave these times out, or use "
        "another sensor", size=float(lost.sum() / rate_hz), unit="s",
        repair=partial(interpolated, sensor=name, half="acc", flags=lost),
    )  # fmt: skip


def scale_fault(recording: Recording, name: str) -> Fault | None:
    """Accelerometer whose length of gravity no sensor in m/s² reads.

    Parameters
    ----------
    recording : Recording
    name : of the sensor

    Returns
    -------
    Fault, or None
    """
    length = wrong_length(recording.sensor(name).acc_mps2, recording.sampling_rate_hz)
    if length is None or length < LEAST_FORCE * STANDARD_GRAVITY_MPS2:
        return None
    times = length / STANDARD_GRAVITY_MPS2
    return fault_of(
        recording, "scale", f"{name}_acc", np.ones(len(recording), np.bool_),
        f"reads {length:.3g} m/s² of gravity, {times:.2f} times what it is: check the unit and the "
        "range that it was exported with", size=times, unit="times",
        repair=partial(multiplied, sensor=name, half="acc", factors=1 / times),
    )  # fmt: skip


class PoseLength(NamedTuple):
    """A parked pose in which an accelerometer reads something else than gravity.

    Parameters
    ----------
    source : name of the recording
    pose : its number in the recording, from 0
    sensor : "lever" or "body"
    length_mps2 : m/s², length of the mean reading
    """

    source: str
    pose: int
    sensor: str
    length_mps2: float

    @property
    def sentence(self) -> str:
        """Words of a message."""
        return (
            f"{self.source}: in pose {self.pose + 1} the {self.sensor}'s IMU reads "
            f"{self.length_mps2:.3g} m/s², where gravity is {STANDARD_GRAVITY_MPS2:.3g}: its "
            "accelerometer is at fault for some time or in its range; record again"
        )


def wrong_lengths(source: str, sensor: str, forces_mps2: FloatArray) -> tuple[PoseLength, ...]:
    """Pose of a parked recording whose force is farthest from gravity, if it is none.

    Parameters
    ----------
    source : name of the recording
    sensor : "lever" or "body"
    forces_mps2 : (n, 3) array, m/s², mean reading in each pose

    Returns
    -------
    tuple of one PoseLength, or empty
    """
    lengths = np.linalg.norm(forces_mps2, axis=1).tolist()
    wrong = [k for k, length in enumerate(lengths) if is_wrong_length(length)]
    if not wrong:
        return ()
    worst = max(wrong, key=lambda k: abs(lengths[k] - STANDARD_GRAVITY_MPS2))
    return (PoseLength(source, worst, sensor, lengths[worst]),)
