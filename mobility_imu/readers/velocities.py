"""Velocity series of a chair, from this package, from WheelMove-ID or from anything else."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, shown
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.table import NumberTable, parse_numbers, read_text
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.results import Result

UNITS = {
    "linear": {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 0.01, "mm/s": 0.001},
    "angular": {"deg/s": float(np.pi / 180), "rad/s": 1.0, "mrad/s": 0.001},
}
"""Units of both velocities, and what turns them into m/s and rad/s."""
SPELLINGS = {
    "linear": {"mps": "m/s", "ms-1": "m/s", "kmh": "km/h", "kph": "km/h", "kmph": "km/h",
               "kmh-1": "km/h", "cmps": "cm/s", "cms-1": "cm/s", "mmps": "mm/s", "mms-1": "mm/s"},
    "angular": {"degps": "deg/s", "dps": "deg/s", "degs-1": "deg/s", "degrees/s": "deg/s",
                "radps": "rad/s", "rads-1": "rad/s", "mradps": "mrad/s", "mrads-1": "mrad/s"},
}  # fmt: skip
LARGEST = {"linear": 40.0, "angular": 70.0}
"""m/s and rad/s: 144 km/h, and twice a gyroscope's usual range of 2000 deg/s. No chair does more,
so a larger value is damaged, or in another unit."""
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


def read_velocities(
    path: str | Path, *, sampling_rate_hz: float | None = None, units: str | None = None
) -> VelocitySeries:
    """Read a CSV with a linear and an angular velocity.

    The columns are found by ``lin`` and by ``ang`` or ``yaw`` in their names, so that headers in
    French, English and Spanish serve alike, and a time column by ``time``, ``temps``, ``tiempo``.
    Columns with ``sd`` or ``std`` as a word in their names hold standard deviations and are left
    aside. Their names state the units, as ``(m/s)``, ``[deg/s]`` or ``_radps``; a unit that is not
    stated is asked for.

    Parameters
    ----------
    path : CSV with ``;`` or ``,``; with ``;`` also decimal commas
    sampling_rate_hz : Hz, needed when there is no time column
    units : of the linear and the angular velocity, such as "m/s, deg/s"; for names without them

    Returns
    -------
    VelocitySeries

    Raises
    ------
    InputError
        Missing columns, NaN, times that are not even, no clock at all, a unit that nobody states
        or that differs from the given one, a value beyond what a chair can do.
    """
    source = str(path)
    text = read_text(path)
    first = text.partition("\n")[0]
    table = parse_numbers(text, separator=max(";,\t", key=first.count), source=source)
    header, values = table.header, table.numbers
    linear = _column(table, r"lin", "linear velocity ('lin')")
    angular = _column(table, r"ang|yaw", "angular velocity ('ang' or 'yaw')")
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
    given = _given_units(units)
    speed, yaw = (
        _in_si(table, place, quantity, given.get(quantity))
        for place, quantity in ((linear, "linear"), (angular, "angular"))
    )
    return VelocitySeries(time_s, speed, yaw, rate)


def _given_units(units: str | None) -> dict[str, str]:
    """Units that the user gave, by quantity."""
    if units is None:
        return {}
    parts = units.split(",") if isinstance(units, str) else []
    found = [_unit(part, quantity) for part, quantity in zip(parts, UNITS, strict=False)]
    if len(parts) != len(UNITS) or None in found:
        raise InputError(
            f"units: got {shown(units)}, expected those of the linear and the angular velocity, "
            f"such as 'm/s, deg/s' ({', '.join(UNITS['linear'])}; {', '.join(UNITS['angular'])})"
        )
    return {quantity: str(unit) for quantity, unit in zip(UNITS, found, strict=True)}


def _unit(text: str, quantity: str) -> str | None:
    """Unit that a text is, None if it is none of the quantity's."""
    plain = re.sub(r"[\s.·]", "", text.lower()).replace("^", "").replace("⁻¹", "-1")
    plain = re.sub("[°º]", "deg", plain)
    name = SPELLINGS[quantity].get(plain, plain)
    return name if name in UNITS[quantity] else None


def _stated_unit(name: str, quantity: str) -> str | None:
    """Unit at the end of a column's name, in brackets or after a mark; None if there is none."""
    bracketed = re.findall(r"[(\[]([^()\[\]]*)[)\]]", name)
    parts = re.split(r"[\s_,]+", name.strip())
    # "v m s-1": a unit may itself hold blanks.
    ends = [" ".join(parts[-count:]) for count in (1, 2) if len(parts) > count]
    found = [_unit(text, quantity) for text in [*bracketed, *ends]]
    return next((unit for unit in found if unit is not None), None)


def _in_si(table: NumberTable, place: int, quantity: str, given: str | None) -> FloatArray:
    """Velocities in m/s or rad/s; the unit is the column's, or what the user says."""
    name = quoted(table.header[place])
    stated = _stated_unit(table.header[place], quantity)
    known = ", ".join(UNITS[quantity])
    if stated is None and given is None:
        raise InputError(
            f"{table.source}: column {name} states no unit that is known ({known}); write it into "
            "the name, or give both with --units 'm/s, deg/s' (units in Python)"
        )
    if stated is not None and given not in (None, stated):
        raise InputError(f"{table.source}: column {name} is in {stated}, but --units says {given}")
    unit = stated or str(given)
    values = np.asarray(table.numbers[:, place] * UNITS[quantity][unit])
    beyond = np.abs(values) > LARGEST[quantity]
    if beyond.any():
        row = int(np.argmax(beyond))
        most = LARGEST[quantity] / UNITS[quantity][unit]
        raise InputError(
            f"{table.source}: line {row + 2}, column {name}: {table.numbers[row, place]:g} {unit}, "
            f"more than any chair does ({most:.4g} {unit}; {int(beyond.sum())} such row(s)); is it "
            "damaged, or in another unit?"
        )
    return values


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
