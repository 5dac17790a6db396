"""Velocity series of a chair, from this package, from WheelMove-ID or from anything else."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.table import parse_numbers, read_text


class VelocitySeries(NamedTuple):
    """Linear velocity (m/s, forward positive) and yaw rate (rad/s, left positive) on a clock."""

    time_s: FloatArray
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    sampling_rate_hz: float


def read_velocities(path: str | Path, *, sampling_rate_hz: float | None = None) -> VelocitySeries:
    """Read a CSV with a linear and an angular velocity.

    The columns are found by ``lin`` and by ``ang`` or ``yaw`` in their names, so that headers in
    French, English and Spanish serve alike, and a time column by ``time``, ``temps``, ``tiempo``.
    The angular velocity is in deg/s unless its header says rad.

    Parameters
    ----------
    path : CSV with ``;`` or ``,``; with ``;`` also decimal commas
    sampling_rate_hz : Hz, needed when there is no time column

    Returns
    -------
    VelocitySeries

    Raises
    ------
    InputError
        Missing columns, NaN, times that are not even, no clock at all.
    """
    source = str(path)
    text = read_text(path)
    first = text.partition("\n")[0]
    separator = max(";,\t", key=first.count)
    header, values = parse_numbers(text, separator=separator, source=source)
    linear = _column(header, r"lin", "linear velocity ('lin')", source)
    angular = _column(header, r"ang|yaw", "angular velocity ('ang' or 'yaw')", source)
    if re.search(r"km\s*/?\s*h|kmh", header[linear].lower()):
        raise InputError(f"{source}: column {header[linear]} is in km/h, expected m/s")
    clock = [k for k, name in enumerate(header) if re.match(r"time|temps|tiempo", name.lower())]
    for k in (linear, angular, *clock):
        bad = ~np.isfinite(values[:, k])
        if bad.any():
            row = int(np.argmax(bad))
            raise InputError(
                f"{source}: line {row + 2}, column {header[k]}: expected a number, got nothing "
                f"or NaN ({int(bad.sum())} such row(s))"
            )
    if clock:
        time_s = values[:, clock[0]]
        step = np.diff(time_s)
        if len(step) == 0:
            raise InputError(f"{source}: only one row")
        usual = float(np.median(step))
        # Printed times are rounded: a step may be off by a rounding, not by half a sample.
        uneven = np.abs(step - usual) > 0.5 * abs(usual)
        if usual <= 0 or uneven.any():
            row = int(np.argmax(uneven)) if uneven.any() else 0
            raise InputError(
                f"{source}: time steps from {time_s[row]:g} to {time_s[row + 1]:g} s at line "
                f"{row + 3}, expected even steps of {usual:.3g} s (gaps, repeats and unsorted "
                "times are not allowed here)"
            )
        rate = round((len(time_s) - 1) / float(time_s[-1] - time_s[0]), 3)
    elif sampling_rate_hz is None:
        raise InputError(f"{source}: no time column, so the sampling rate must be given")
    else:
        rate = float(sampling_rate_hz)
        time_s = np.arange(len(values)) / rate
    yaw = values[:, angular]
    if "rad" not in header[angular].lower():
        yaw = np.deg2rad(yaw)
    return VelocitySeries(time_s, values[:, linear], yaw, rate)


def _column(header: list[str], pattern: str, what: str, source: str) -> int:
    found = [k for k, name in enumerate(header) if re.search(pattern, name.lower())]
    if len(found) != 1:
        state = "no column" if not found else f"{len(found)} columns"
        raise InputError(f"{source}: {state} for the {what} (columns: {', '.join(header)})")
    return found[0]
