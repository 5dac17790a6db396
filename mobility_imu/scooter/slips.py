"""A sensor that is turned during a ride: the parts of the recording before and after disagree.

A turn that is there from the beginning is a wrong mount. One that comes later shows in two ways:
accelerations that are gravity and that no angles of the controls explain, or angles that step where
the gyroscopes show no motion.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.faults import Fault
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.health import fault_of
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.scooter.agreement import MEAN_S
from mobility_imu.scooter.sensor_pair import SensorPair

__all__ = ["Step", "slip_of", "steps_of", "unexplained"]

CALM = 0.05
"""Part of gravity by which the length of a force may be off where only gravity is felt. Scales of
consumer sensors are off by up to 3 % (data sheets). Swept from 0.02 to 0.1 on 72 simulated rides,
seeds 2 to 13: in sound ones such forces fit no angles for 0.02 s at most, from 0.07 on for 0.34 s;
with a sensor turned by 15 deg for 0.8 s (median), below 0.03 for 0.5 s."""
SHORTEST_UNEXPLAINED_S = 0.5
"""Time for which gravity has to fit no angles: between what sound and turned sensors have (see
``CALM``)."""
WINDOW_S = 30.0
"""Steps are looked for in parts of this length: gyroscopes drift away from the angles later on."""
SHORTEST_S = 5.0
"""Parts that are shorter say nothing by themselves."""
POINTS_HZ = 10.0
"""Differences are compared so often."""
STEPS_RAD = (float(np.deg2rad(25.0)), float(np.deg2rad(10.0)))
"""Steps of steering and throttle from which on they are told. Curves make up to 21 and 8 deg of
them in sound rides (simulated, seeds 1 to 30, sensors of consumers by eye)."""
STEP_EXPLAINS = 0.55
"""Part of the difference's variance about its line that a step has to explain, likewise."""
ENDS = 0.1
"""Part of a window, at either end, in which no step can be told from a line. Of a step after the
part p, a line leaves p (1 - p) (1 - 3 p (1 - p)); nearer to an end than this, it leaves less than
of a step in the middle."""


class Step(NamedTuple):
    """A step in a series.

    Parameters
    ----------
    size : in the unit of the series
    time_s : s, on the clock of its points
    explained : part of the variance about a line that it explains
    """

    size: float
    time_s: float
    explained: float


def unexplained(pair: SensorPair) -> NDArray[np.bool_]:
    """Where both forces are gravity, and no angles of the controls explain them.

    Parameters
    ----------
    pair : SensorPair

    Returns
    -------
    (n,) bool array
    """
    width = max(1, round(MEAN_S * pair.rate_hz))
    bad = ~pair.seen.good
    for acc in pair.readings.acc.values():
        length = np.linalg.norm(ndimage.uniform_filter1d(acc, width, axis=0), axis=1)
        bad &= np.abs(length / STANDARD_GRAVITY_MPS2 - 1) < CALM
    return long_runs(bad, max(1, round(SHORTEST_UNEXPLAINED_S * pair.rate_hz)), grow=False)


def steps_of(values: FloatArray, time_s: FloatArray) -> Step:
    """Largest step in a series that is a line otherwise.

    Parameters
    ----------
    values, time_s : (n,) arrays

    Returns
    -------
    Step; of size 0 in a series of fewer than 20 points
    """
    count = len(values)
    if count < 20:
        return Step(0.0, float("nan"), 0.0)
    line = np.linalg.qr(np.column_stack([np.ones(count), time_s - time_s.mean()]))[0]
    first, last = round(ENDS * count), count - round(ENDS * count)
    steps = (np.arange(count)[:, None] >= np.arange(first, last)).astype(float)
    steps -= line @ (line.T @ steps)
    left = values - line @ (line.T @ values)
    power = np.maximum((steps**2).sum(axis=0), 1e-12)
    sizes = steps.T @ left / power
    explained = sizes**2 * power / max(float(left @ left), 1e-30)
    best = int(np.argmax(explained))
    return Step(float(sizes[best]), float(time_s[first + best]), float(explained[best]))


def _steps(pair: SensorPair) -> Iterator[tuple[float, str]]:
    """Times of steps between the closed form's angles and the gyroscopes', and their sentences."""
    every = max(1, round(pair.rate_hz / POINTS_HZ))
    width, count = round(WINDOW_S * pair.rate_hz), len(pair.recording)
    time_s, good = pair.recording.time_s, pair.seen.good
    motion, seen = pair.motion, pair.seen
    for start in range(0, max(1, count - width // 2), max(1, width // 2)):
        part = np.arange(start, min(count, start + width), every)
        part = part[good[part]]
        for name, by_rates, by_acc, least in (
            ("steering", motion.steering_rad, seen.steering_rad, STEPS_RAD[0]),
            ("throttle", motion.throttle_rad, seen.throttle_rad, STEPS_RAD[1]),
        ):
            step = steps_of(np.unwrap(by_acc[part] - by_rates[part]), time_s[part])
            if abs(step.size) > least and step.explained > STEP_EXPLAINS:
                yield (
                    step.time_s,
                    f"the {name} jumps by {np.rad2deg(step.size):+.0f} deg, the gyroscopes do not",
                )


def _parts_agree(pair: SensorPair, split_s: float, at_odds: float) -> bool:
    """Whether the sensors agree before a time, and after it, as far as these parts are long."""
    for start_s, stop_s in ((-np.inf, split_s), (split_s, np.inf)):
        inside = (pair.recording.time_s >= start_s) & (pair.recording.time_s < stop_s)
        if inside.sum() <= SHORTEST_S * pair.rate_hz:
            continue
        part = pair.recording.trim(start_s, stop_s)
        try:
            stated = SensorPair(part, pair.geometry, pair.mount).stated
        except InputError:
            continue  # Gravity points the wrong way: no angles are at odds, and a turn explains it.
        if stated is not None and stated.squared > at_odds:
            return False
    return True


def slip_of(pair: SensorPair, at_odds: float) -> Fault | None:
    """Sensor that was turned during a ride.

    Parameters
    ----------
    pair : SensorPair of a scooter that drives
    at_odds : sum of squared misfits from which on sensors contradict each other: where they do so
        before or after a step, the step is not why

    Returns
    -------
    Fault of all samples, for it is not known which part is right; or None
    """
    recording, bad = pair.recording, unexplained(pair)
    if bad.any():
        run = runs_of(bad)[0]
        # A part that fits at no time is no slip, but a wrong mount.
        at = run.start if run.start > SHORTEST_UNEXPLAINED_S * pair.rate_hz else run.stop
        if at >= len(recording) or bad.mean() > 1 - ENDS:
            return None
        what = f"no angles of the controls explain gravity in {bad.mean():.0%} of the samples"
        split_s = float(recording.time_s[at])
    else:
        split_s, what = next(_steps(pair), (float("nan"), "")) if pair.stated else (np.nan, "")
        if not what:
            return None
        odds = pair.stated is not None and pair.stated.squared > at_odds
        if odds and not _parts_agree(pair, split_s, at_odds):
            return None
    return fault_of(
        recording, "slipped", "lever, body", np.ones(len(recording), np.bool_),
        f"do not agree before and after {split_s:.1f} s: {what}; one sensor was turned in "
        "its place, or its accelerometer failed; cut the recording there, and calibrate the mount "
        "again; the angles are not valid",
    )  # fmt: skip
