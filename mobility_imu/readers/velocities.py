"""Velocity series of a chair, from this package, from WheelMove-ID or from anything else."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.table import NumberTable, parse_numbers, read_text
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.results import Result

STANDARD_DEVIATION = r"(?<![a-z])(?:sd|std)(?![a-z])"
"""In the name of a column that holds a standard deviation, not a velocity."""


@dataclass(frozen=True, eq=False, repr=False)
class VelocitySeries(Result):
    """Linear velocity and yaw rate of a chair on an even clock.

    Parameters
    ----------
    time_s : (n,) array, s
    linear_velocity_mps : (n,) array, m/s, forward positive
    yaw_rate_radps : (n,) array, rad/s, left positive
    sampling_rate_hz : Hz
    """

    time_s: FloatArray
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    sampling_rate_hz: float


def read_velocities(path: str | Path, *, sampling_rate_hz: float | None = None) -> VelocitySeries:
    """Read a CSV with a linear and an angular velocity.

    The columns are found by ``lin`` and by ``ang`` or ``yaw`` in their names, so that headers in
    French, English and Spanish serve alike, and a time column by ``time``, ``temps``, ``tiempo``.
    Columns with ``sd`` or ``std`` as a word in their names hold standard deviations and are left
    aside. The angular velocity is in deg/s unless its header says rad; a warning tells of a header
    without a unit.

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
    table = parse_numbers(text, separator=max(";,\t", key=first.count), source=source)
    header, values = table.header, table.numbers
    linear = _column(table, r"lin", "linear velocity ('lin')")
    angular = _column(table, r"ang|yaw", "angular velocity ('ang' or 'yaw')")
    if re.search(r"km\s*/?\s*h|kmh", header[linear].lower()):
        raise InputError(f"{source}: column {quoted(header[linear])} is in km/h, expected m/s")
    clock = [k for k, name in enumerate(header) if re.match(r"time|temps|tiempo", name.lower())]
    _check_finite(table, [linear, angular, *clock])
    if clock:
        time_s = values[:, clock[0]]
        rate = _even_rate(time_s, source)
    elif sampling_rate_hz is None:
        raise InputError(f"{source}: no time column, so the sampling rate must be given")
    else:
        rate = check_rate(sampling_rate_hz, source)
        time_s = np.arange(len(values)) / rate
    yaw = values[:, angular]
    unit = re.search(r"rad|deg|°|º", header[angular].lower())
    if unit is None:
        warnings.warn(
            f"{source}: column {quoted(header[angular])} states no unit and is taken for deg/s; "
            "write (deg/s) or (rad/s) into its name",
            stacklevel=1,
        )
    if unit is None or unit[0] != "rad":
        yaw = np.deg2rad(yaw)
    return VelocitySeries(time_s, values[:, linear], yaw, rate)


def _check_finite(table: NumberTable, places: list[int]) -> None:
    for k in places:
        bad = ~np.isfinite(table.numbers[:, k])
        if bad.any():
            row = int(np.argmax(bad))
            raise InputError(
                f"{table.source}: line {row + 2}, column {quoted(table.header[k])}: expected a "
                f"number, got nothing, NaN or infinity ({int(bad.sum())} such row(s))"
            )


def _even_rate(time_s: FloatArray, source: str) -> float:
    """Sampling rate in Hz of a time column whose steps are even, which is checked."""
    with np.errstate(over="ignore", invalid="ignore"):
        step = np.diff(time_s)
        if len(step) == 0:
            raise InputError(f"{source}: only one row")
        usual = float(np.median(step))
        # Printed times are rounded: a step may be off by a rounding, not by half a sample.
        uneven = ~(np.abs(step - usual) <= 0.5 * abs(usual))
    if not usual > 0 or uneven.any():
        row = int(np.argmax(uneven)) if uneven.any() else 0
        raise InputError(
            f"{source}: time steps from {time_s[row]:g} to {time_s[row + 1]:g} s at line "
            f"{row + 3}, expected even steps of {usual:.3g} s (gaps, repeats and unsorted "
            "times are not allowed here)"
        )
    rate = round((len(time_s) - 1) / float(time_s[-1] - time_s[0]), 3)
    return check_rate(rate, source, clock=True)


def _column(table: NumberTable, pattern: str, what: str) -> int:
    found = [
        k
        for k, name in enumerate(table.header)
        if re.search(pattern, name.lower()) and not re.search(STANDARD_DEVIATION, name.lower())
    ]
    if len(found) != 1:
        state = "no column" if not found else f"{len(found)} columns"
        raise InputError(
            f"{table.source}: {state} for the {what} (columns: {listed(table.header)})"
        )
    return found[0]
