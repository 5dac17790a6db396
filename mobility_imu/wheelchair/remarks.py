"""Warnings of an estimate: a wheel without a sensor, a way that is backward, coarse readings."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.offsets import GyroscopeOffset
from mobility_imu.quality import resolution_of, smallest_step
from mobility_imu.readers.wording import listed
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelchairGeometry

__all__ = ["alone", "backward", "coarse", "coarse_steps", "of_chair", "other_names", "with_steps"]

NAMES = ("frame", *(f"{side}_wheel" for side in SIDES))
LEAST_FORWARD = 0.05
"""Who drives a way backward rolls forward by a few percent of it, while stopping and turning."""
COARSE_RADPS = float(np.deg2rad(1.0))
"""Steps that are worth a warning: half of one, not seen for a minute, is a turn of 30 degrees."""


def of_chair(recording: Recording) -> Recording:
    """Recording of a chair's sensors only; the same one if it has no others.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    Recording
    """
    own = {name: imu for name, imu in recording.sensors.items() if name in NAMES}
    if not own or len(own) == len(recording.sensors):
        return recording
    return Recording(recording.time_s, own, source=recording.source)


def other_names(recording: Recording) -> str:
    """Sensors whose names are none of a chair's, for the end of a warning of one that is missing.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    str, empty if there are none
    """
    others = [name for name in recording.sensors if name not in NAMES]
    return f" ({listed(others)} is not used: no name of a chair's sensor)" if others else ""


def alone(recording: Recording, present: Sequence[Side]) -> tuple[str, ...]:
    """Warning where one wheel has no sensor.

    Parameters
    ----------
    recording : Recording
    present : sides with a sensor

    Returns
    -------
    tuple of str, empty or with one sentence
    """
    if len(present) == 2:
        return ()
    return (
        f"{recording.source}: only the {present[0]} wheel has a sensor; speed from it and the "
        f"frame, slip cannot be seen{other_names(recording)}",
    )


def backward(
    recording: Recording, linear_velocity_mps: FloatArray, geometry: WheelchairGeometry
) -> tuple[str, ...]:
    """Warning where a chair rolls backward throughout.

    It does so if the straight-line trial, which tells what forward is, was driven backward. In a
    drive without turns nothing else shows that.

    Parameters
    ----------
    recording : Recording
    linear_velocity_mps : (n,) array
    geometry : WheelchairGeometry

    Returns
    -------
    tuple of str, empty or with one sentence
    """
    forward, back = (
        float(np.clip(way, 0.0, None).sum()) / recording.sampling_rate_hz
        for way in (linear_velocity_mps, -linear_velocity_mps)
    )
    one_turn_m = 2 * np.pi * max(geometry.wheel_radius_m)
    if back < one_turn_m or forward > LEAST_FORWARD * back:
        return ()
    return (
        f"{recording.source}: the chair rolls backward throughout ({back:.1f} m); if it went "
        "forward, the straight-line trial was driven backward: record that anew",
    )


def coarse_steps(
    recording: Recording,
    names: Collection[str],
    failed: Mapping[str, NDArray[np.bool_]] = MappingProxyType({}),
) -> dict[str, FloatArray]:
    """Steps of gyroscopes that are coarse against their noise.

    Parameters
    ----------
    recording : Recording
    names : sensors with a gyroscope
    failed : sensor to (n,) bool array, samples that say nothing

    Returns
    -------
    dict from sensor to (3,) array, rad/s; 0 for axes whose noise changes the reading, and without
    sensors that have no other axes
    """
    found = {}
    for name in names:
        gyr = recording.gyroscope(name)
        seen = resolution_of(gyr, skip=failed.get(name))
        # Changes of a sensor that never is quiet are larger than its steps.
        steps = np.array(
            [
                min(step, smallest_step(axis)) if coarse else 0.0
                for step, axis, coarse in zip(seen.step, gyr.T, seen.coarse, strict=True)
            ]
        )
        if steps.any():
            found[name] = steps
    return found


def with_steps(
    offsets: Mapping[str, GyroscopeOffset], steps: Mapping[str, FloatArray]
) -> dict[str, GyroscopeOffset]:
    """Offsets whose uncertainty counts that readings are rounded.

    Where the noise does not change the last digit, the noise that is seen at rest says nothing of
    the rounding, neither of one sample nor of the offset: each is off by a rounding error, which
    has the standard deviation step / sqrt(12).

    Parameters
    ----------
    offsets : sensor to GyroscopeOffset
    steps : sensor to (3,) array, rad/s, from :func:`coarse_steps`

    Returns
    -------
    dict from sensor to GyroscopeOffset
    """
    widened = dict(offsets)
    for name, step in steps.items():
        if name in offsets:
            variance = np.square(step) / 12
            widened[name] = replace(
                offsets[name],
                covariance=offsets[name].covariance + np.diag(variance),
                noise_radps=np.sqrt(np.square(offsets[name].noise_radps) + variance),
            )
    return widened


def coarse(recording: Recording, steps: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Warnings of gyroscopes whose steps hide slow turns.

    Parameters
    ----------
    recording : Recording
    steps : sensor to (3,) array, rad/s, from :func:`coarse_steps`

    Returns
    -------
    tuple of str
    """
    return tuple(
        f"{recording.source}: the gyroscope of {name} is read in steps of "
        f"{np.rad2deg(step.max()):.2g} deg/s, larger than its noise: slower turns are lost; export "
        "more digits"
        for name, step in steps.items()
        if step.max() >= COARSE_RADPS
    )
