"""Velocity series of a chair, from this package, from WheelMove-ID or from anything else."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, shown
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.flags import flag_column, with_flags
from mobility_imu.readers.layout import check_names
from mobility_imu.readers.streams import (
    FACTORS,
    LARGEST_RATE_DIFFERENCE,
    TIME_UNITS,
    known_unit,
    same_rate,
    times_of_rows,
)
from mobility_imu.readers.table import NumberTable, line_of, read_text
from mobility_imu.readers.wording import listed, named, quoted
from mobility_imu.results import Result

QUANTITIES = {"linear": "speed", "angular": "gyr"}
"""Which units each of both velocities may have."""
LARGEST = {"linear": 40.0, "angular": 70.0}
"""m/s and rad/s: 144 km/h, and twice a gyroscope's usual range of 2000 deg/s. No chair does more,
so a larger value is damaged, or in another unit."""
LINEAR, ANGULAR = r"lin", r"ang|yaw"
"""In the names of both velocities' columns."""
STANDARD_DEVIATION = r"(?<![a-z])(?:sd|std)(?![a-z])"
"""In the name of a column that holds a standard deviation, not a velocity."""
WORDS = {
    "km": r"kilom[eè]t(?:er|re)s?|kil[oó]metros?", "cm": r"centim[eè]t(?:er|re)s?",
    "m": r"m[eè]t(?:er|re)s?|metros?", "ms": r"milliseconds?|millisecondes?|milisegundos?",
    "us": r"µs|μs|microseconds?", "s": r"sec|secs|seg|seconds?|secondes?|segundos?",
    "min": r"mins|minutes?|minutos?", "h": r"hrs?|hours?|heures?|horas?",
    "deg": r"degrees?|degr[eé]s?|grados?", "rad": r"radians?|radianes",
}  # fmt: skip
"""Units in words, in English, French and Spanish."""
_COUNTS = re.compile(
    r"(?<![a-z])(?:index|idx|samples?|frames?|counts?|counter|number|no|nr)(?![a-z])"
)
"""In the name of a column that counts rows: no clock."""
_TICKS = re.compile(r"(?<![a-z])ticks?(?![a-z])")
"""In the name of a column that counts, unless it states a unit of time and no length of a tick."""
_BRACKETED = re.compile(r"[(\[]([^()\[\]]*)[)\]]")
_OTHER_UNIT = re.compile(
    r"mph|kts?|kn|knots?|ftps|fps|ips|rpm|rps|hz|deg|degrees?|rad"
    r"|[^/]+/(s|sec|second|min|minute|h|hr|hour|ms)(\^?[2²])?"
)
"""Outside brackets, words that are units of something else than a chair's velocity."""


@dataclass(frozen=True, eq=False, repr=False)
class VelocitySeries(Result):
    """Linear velocity and yaw rate of a chair on an even clock.

    Parameters
    ----------
    time_s : (n,) array, s
    linear_velocity_mps : (n,) array, m/s, forward positive
    yaw_rate_radps : (n,) array, rad/s, left positive
    sampling_rate_hz : Hz
    valid : (n,) bool array, False where the file says that the velocities are not known; None if it
        says nothing
    """

    time_s: FloatArray
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    sampling_rate_hz: float
    valid: NDArray[np.bool_] | None = None


def read_velocities(
    path: str | Path, *, sampling_rate_hz: float | None = None, units: str | None = None
) -> VelocitySeries:
    """Read a CSV with a linear and an angular velocity.

    The columns are found by ``lin`` and by ``ang`` or ``yaw`` in their names, so that headers in
    French, English and Spanish serve alike, and a time column by ``time``, ``temps``, ``tiempo``.
    Columns with ``sd`` or ``std`` as a word in their names hold standard deviations: where one is
    infinite, empty or below 0, or a column ``valid`` is 0, a word such as FALSE or empty, the
    velocities are not valid. The names state the units, as ``(m/s)``, ``[deg/s]`` or ``_radps``; a
    unit that is not stated is asked for. A time column is in s unless its name states another unit;
    of several the first is taken, with a warning if one that states no unit counts other times.

    Parameters
    ----------
    path : CSV with ``;`` or ``,``; with ``;`` also decimal commas
    sampling_rate_hz : Hz, needed when there is no time column; beside one, it has to fit its steps
    units : of the linear and the angular velocity, such as "m/s, deg/s"; for names without them

    Returns
    -------
    VelocitySeries

    Raises
    ------
    InputError
        Missing columns, NaN, times that are not even or not at the given rate, no clock at all, two
        that contradict each other, a unit that nobody states or that differs from the given one, a
        value beyond what a chair can do.
    """
    source = str(path)
    table = with_flags(read_text(path), source=source, wanted=_is_read, flags=_is_flag)
    check_names([name for name in table.every if _is_read(name) or _is_flag(name)], source)
    header, values = table.header, table.numbers
    linear = _column(table, LINEAR, "linear velocity ('lin')")
    angular = _column(table, ANGULAR, "angular velocity ('ang' or 'yaw')")
    clock = [k for k, name in enumerate(header) if _is_clock(name)]
    table.check_finite([linear, angular, *clock])
    if clock:
        time_s = values[:, clock[0]] * _clock_unit(header[clock[0]], source)
        rate = _even_rate(time_s, table)
        _compare_clocks(table, clock)
        _check_given_rate(sampling_rate_hz, rate, source)
    elif sampling_rate_hz is None:
        counts = [name for name in table.every if _begins_as_time(name)]
        but = f" ({listed(counts)} is taken as a count)" if counts else ""
        raise InputError(
            f"{source}: no time column{but}, so the sampling rate must be given "
            "(--sampling-rate-hz; sampling_rate_hz in Python)"
        )
    else:
        rate = check_rate(sampling_rate_hz, source)
        time_s, unseen = times_of_rows(len(values), rate, source)
        warnings.warn(unseen, stacklevel=2)
    given = _given_units(units)
    speed, yaw = (
        _in_si(table, place, quantity, given.get(quantity))
        for place, quantity in ((linear, "linear"), (angular, "angular"))
    )
    return VelocitySeries(time_s, speed, yaw, rate, _valid(table))


def _valid(table: NumberTable) -> NDArray[np.bool_] | None:
    """Where the file's own columns do not say that the velocities are unknown."""
    names = [name.lower().strip() for name in table.header]
    deviations = (table.numbers[:, k] for k in _of_deviations(names))
    unknown = [~((sd >= 0) & (sd < np.inf)) for sd in deviations]
    flags = (k for k, name in enumerate(table.every) if _is_flag(name))
    unknown += [~(flag_column(table, k) > 0) for k in flags]
    return ~np.any(unknown, axis=0) if unknown else None


def _is_read(name: str) -> bool:
    """Whether a column holds numbers that are read; others may hold words, as tasks do."""
    quantities = (STANDARD_DEVIATION, LINEAR, ANGULAR)
    return _is_clock(name) or any(re.search(pattern, name.lower()) for pattern in quantities)


def _is_flag(name: str) -> bool:
    return name.lower() == "valid"


def _of_deviations(names: list[str]) -> list[int]:
    return [k for k, name in enumerate(names) if re.search(STANDARD_DEVIATION, name)]


def _given_units(units: str | None) -> dict[str, str]:
    """Units that the user gave, by velocity."""
    if units is None:
        return {}
    parts = units.split(",") if isinstance(units, str) else []
    found = [
        known_unit(quantity, part)
        for part, quantity in zip(parts, QUANTITIES.values(), strict=False)
    ]
    if len(parts) != len(QUANTITIES) or None in found:
        known = "; ".join(", ".join(FACTORS[quantity]) for quantity in QUANTITIES.values())
        raise InputError(
            f"units: got {shown(units)}, expected those of the linear and the angular velocity, "
            f"such as 'm/s, deg/s' ({known})"
        )
    return {velocity: str(unit) for velocity, unit in zip(QUANTITIES, found, strict=True)}


def _is_clock(name: str) -> bool:
    lower = name.lower()
    if not _begins_as_time(name) or _COUNTS.search(lower):
        return False
    # Of "time_tick_10_ms", the unit is that of a tick, not of the numbers.
    return not _TICKS.search(lower) or (bool(_time_units(name)) and not re.search(r"\d", name))


def _begins_as_time(name: str) -> bool:
    return re.match(r"time|temps|tiempo", name.lower()) is not None


def _time_units(name: str) -> list[str]:
    """Units that the name of a time column states."""
    words = re.split(r"[\s_,.]+", _BRACKETED.sub(" ", name).strip())[1:]
    parts = (*(text.strip() for text in _BRACKETED.findall(name)), *words)
    return [unit for text in parts if (unit := _shortened(text)) in TIME_UNITS]


def _clock_unit(name: str, source: str) -> float:
    """Seconds of one unit of a time column; s if its name states none."""
    bracketed = [text.strip() for text in _BRACKETED.findall(name) if text.strip()]
    stated = _time_units(name)
    multiple = re.search(rf"\d({'|'.join(TIME_UNITS)})(?![^\W_])", name.lower())  # "time_10ms"
    if len(set(stated)) > 1 or ((bracketed or multiple) and not stated):
        raise InputError(
            f"{source}: column {named(name)}: expected one unit of time "
            f"({', '.join(TIME_UNITS)}); rename it"
        )
    return TIME_UNITS[stated[0]] if stated else 1.0


def _compare_clocks(table: NumberTable, clock: list[int]) -> None:
    """Raise an error, or warn, where a further time column counts other times than the first.

    A further one that states no unit may be in any, and may count something else.
    """
    first = table.header[clock[0]]
    with np.errstate(over="ignore"):
        spans = table.numbers[-1, clock] - table.numbers[0, clock]
    span = spans[0] * _clock_unit(first, table.source)
    allowed = LARGEST_RATE_DIFFERENCE * span + span / (len(table) - 1)
    for place, other in zip(clock[1:], spans[1:], strict=True):
        name = table.header[place]
        stated = _time_units(name)
        if len(set(stated)) > 1 or (not stated and _BRACKETED.search(name)):
            continue  # in % of a cycle, for example
        units = [TIME_UNITS[unit] for unit in stated] or list(TIME_UNITS.values())
        if any(abs(other * unit - span) <= allowed for unit in units):
            continue
        said = (
            f"{table.source}: column {named(first)} counts {span:.5g} s from the first row to the "
            f"last, but {named(name)} counts {other * units[0]:.5g} s"
        )
        if stated:
            raise InputError(f"{said}; remove or rename the wrong one")
        warnings.warn(f"{said}; the first is taken", stacklevel=3)


def _check_given_rate(given_hz: float | None, found_hz: float, source: str) -> None:
    if given_hz is None:
        return
    given_hz = check_rate(given_hz, source)
    if not same_rate(given_hz, found_hz):
        raise InputError(
            f"{source}: its time column has {found_hz:g} Hz, but {given_hz:g} Hz is given "
            "(--sampling-rate-hz, or freqAcq of the settings); leave it out, or correct the column"
        )


def _shortened(name: str) -> str:
    """Name in which units in words are signs: "kilometers per hour" is "km/h"."""
    text = name.lower()
    for sign, word in WORDS.items():
        text = re.sub(rf"(?<![^\W_])(?:{word})(?![^\W_])", sign, text)
    return re.sub(r"(?<=[^\W_])[\s_]+(?:per|par|por)[\s_]+(?=[^\W_])", "/", text)


def _stated_units(name: str) -> list[str]:
    """Units in a column's name: what stands in brackets, and what looks like one outside."""
    name = _shortened(re.sub(r"\s*/\s*", "/", name))
    words = re.split(r"[\s_,]+", _BRACKETED.sub(" ", name).strip())
    # "v m s-1": a unit may itself hold blanks.
    pairs = [pair for pair in map(" ".join, pairwise(words)) if _is_known(pair)]
    outside = [word for word in words if _is_known(word) or _OTHER_UNIT.fullmatch(word.lower())]
    found = [*_BRACKETED.findall(name), *pairs, *outside]
    return [text.strip() for text in found if re.search(r"\w|[°º%]", text)]


def _is_known(text: str) -> bool:
    # "g" may be a side's initial.
    return len(text) > 2 and any(known_unit(quantity, text) for quantity in FACTORS)


def _unit(name: str, velocity: str, given: str | None, source: str) -> str:
    """Unit of a column: what its name states, or what the user says of a name that states none."""
    quantity = QUANTITIES[velocity]
    stated = _stated_units(name)
    found = list(dict.fromkeys(u for text in stated if (u := known_unit(quantity, text))))
    known = ", ".join(FACTORS[quantity])
    if len(found) > 1:
        raise InputError(f"{source}: column {named(name)} states two units, {listed(found)}")
    if stated and not found:
        raise InputError(
            f"{source}: column {named(name)} states '{quoted(stated[0])}', no unit that is known "
            f"for the {velocity} velocity ({known}); convert or rename it, for --units does not "
            "replace what a name states"
        )
    if found and given not in (None, found[0]):
        raise InputError(
            f"{source}: column {named(name)} is in {found[0]}, but --units says {given}"
        )
    unit = found[0] if found else given
    if unit is None:
        raise InputError(
            f"{source}: column {named(name)} states no unit that is known ({known}); write it "
            "into the name, or give both with --units 'm/s, deg/s' (units in Python)"
        )
    return unit


def _in_si(table: NumberTable, place: int, velocity: str, given: str | None) -> FloatArray:
    """Velocities in m/s or rad/s; the unit is the column's, or what the user says."""
    unit = _unit(table.header[place], velocity, given, table.source)
    per = FACTORS[QUANTITIES[velocity]][unit]
    values = np.asarray(table.numbers[:, place] * per)
    beyond = np.abs(values) > LARGEST[velocity]
    if beyond.any():
        row = int(np.argmax(beyond))
        most = LARGEST[velocity] / per
        line, name = line_of(table.text, row), named(table.header[place])
        raise InputError(
            f"{table.source}: line {line}, column {name}: "
            f"{table.numbers[row, place]:g} {unit}, more than any chair does ({most:.4g} {unit}; "
            f"{int(beyond.sum())} such row(s)); is it damaged, or in another unit?"
        )
    return values


def _even_rate(time_s: FloatArray, table: NumberTable) -> float:
    """Sampling rate in Hz of a time column whose steps are even, which is checked."""
    with np.errstate(over="ignore", invalid="ignore"):
        step = np.diff(time_s)
        if len(step) == 0:
            raise InputError(f"{table.source}: only one row")
        usual = float(np.median(step))
        # Printed times are rounded: a step may be off by a rounding, not by half a sample.
        uneven = ~(np.abs(step - usual) <= 0.5 * abs(usual))
    if not usual > 0 or uneven.any():
        row = int(np.argmax(uneven)) if uneven.any() else 0
        raise InputError(
            f"{table.source}: time steps from {time_s[row]:g} to {time_s[row + 1]:g} s at "
            f"line {line_of(table.text, row + 1)}, expected even steps of {usual:.3g} s (gaps, "
            "repeats and unsorted times are not allowed here)"
        )
    rate = round((len(time_s) - 1) / float(time_s[-1] - time_s[0]), 3)
    return check_rate(rate, table.source, clock=True)


def _column(table: NumberTable, pattern: str, what: str) -> int:
    found = [
        k
        for k, name in enumerate(table.header)
        if re.search(pattern, name.lower()) and not re.search(STANDARD_DEVIATION, name.lower())
    ]
    if len(found) != 1:
        state = "no column" if not found else f"{len(found)} columns"
        raise InputError(f"{table.source}: {state} for the {what} (columns: {listed(table.every)})")
    return found[0]
