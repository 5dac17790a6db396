"""Gyroscopes at the end of their range: the wheel turns faster than they can read.

A wheel of 0.3 m that rolls at 1.3 m/s turns at 250 deg/s, the range that many modules are set to.
Beyond it the readings stand still at the limit, and speed and path come out too small.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from mobility_imu.quality import same_as_before, saturated_samples
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of

__all__ = ["saturated_gyroscopes", "saturation_warnings", "usable_samples"]

RANGES_DEGPS = (125, 150, 245, 250, 300, 350, 400, 450, 500, 600, 900, 1000, 1200, 2000, 4000)
"""Ranges of the gyroscopes that are sold, by their data sheets."""
RANGE_TOLERANCE = 0.02
"""A sensor's own calibration moves the limit by about so much."""
SHORTEST_S = 0.05
"""The peak of a slow motion in coarse steps repeats itself for less."""


def saturated_gyroscopes(
    recording: Recording, sensors: Collection[str]
) -> dict[str, NDArray[np.bool_]]:
    """Where the gyroscopes are at the end of their range.

    A sample counts if an axis stays at its largest size, that size is a usual range, and another
    axis still changes: exact readings of a steady motion, as simulated, repeat themselves as well.

    Parameters
    ----------
    recording : Recording as it came, with offsets: the limit is a constant of the sensor
    sensors : names

    Returns
    -------
    dict from sensor to (n,) bool array; without the sensors that are never at their limit
    """
    run = max(3, round(SHORTEST_S * recording.sampling_rate_hz))
    found = {}
    for name in sensors:
        gyr = recording.gyroscope(name)
        flags = saturated_samples(gyr, run=run)
        if not flags.any():
            continue
        size = np.rad2deg(np.abs(gyr).max(axis=1))
        apart = np.abs(size[:, None] / np.array(RANGES_DEGPS) - 1).min(axis=1)
        flags &= (apart < RANGE_TOLERANCE) & ~same_as_before(gyr)
        if flags.any():
            found[name] = flags
    return found


def usable_samples(count: int, saturated: Mapping[str, NDArray[np.bool_]]) -> NDArray[np.bool_]:
    """Where no gyroscope is at the end of its range.

    Parameters
    ----------
    count : samples of the recording
    saturated : from :func:`saturated_gyroscopes`

    Returns
    -------
    (n,) bool array
    """
    usable = np.ones(count, np.bool_)
    for flags in saturated.values():
        usable &= ~flags
    return usable


def saturation_warnings(
    recording: Recording, saturated: Mapping[str, NDArray[np.bool_]]
) -> tuple[str, ...]:
    """Sentences on gyroscopes that were at the end of their range.

    Parameters
    ----------
    recording : Recording, as it came
    saturated : from :func:`saturated_gyroscopes`

    Returns
    -------
    tuple of str
    """
    sentences = []
    for name, flags in saturated.items():
        limit = np.rad2deg(np.abs(recording.gyroscope(name)[flags]).max())
        first = recording.time_s[runs_of(flags)[0].start]
        sentences.append(
            f"{recording.source}: the gyroscope of {name} is at the end of its range "
            f"({limit:.0f} deg/s) for {flags.sum() / recording.sampling_rate_hz:.2f} s, first at "
            f"{first:.2f} s; it turned faster, and what is found there is too small: choose a "
            "larger range"
        )
    return tuple(sentences)
