"""A fault of a sensor: where it is, how large, how to undo it, and what it costs in the result.

What a fault costs is found by running the estimate twice: on the recording as it is, and on one in
which the fault is undone as well as the other readings allow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_flags, as_floats, as_number, one_of, shown
from mobility_imu.recording import Imu, Recording
from mobility_imu.results import Result
from mobility_imu.runs import long_runs, runs_of, some_flags

HALVES = ("acc", "gyr")
"""Halves of a sensor: accelerometer and gyroscope."""
FEWEST_BESIDE = 5
"""Samples on either side of a cut peak that a curve is fitted to, at least."""
FEWEST_CUT = 3
"""Samples, one after the other, at which an axis has to stay to be taken as cut."""
MOST_PRICED = 6
"""Faults whose cost is found, of one recording: each takes an estimate of its own."""


Repair = Callable[[Recording], Recording]
"""Gives a recording without a fault, as well as the other readings allow."""


class Cost(NamedTuple):
    """How far a fault moves a result.

    Parameters
    ----------
    name : of the result ("steering")
    largest : largest change of the result over the recording, in the unit
    unit : "deg", "m/s", "deg/s", "m"
    """

    name: str
    largest: float
    unit: str

    def __str__(self) -> str:
        """Words of a message."""
        return f"the {self.name} by up to {float(f'{self.largest:.2g}'):g} {self.unit}"


@dataclass(frozen=True, eq=False, repr=False)
class Fault(Result):
    """A fault of a sensor, or of what was promised of a recording.

    Parameters
    ----------
    code : kind of the fault ("frozen", "range", "lag")
    sensor : name, with the half that is at fault where it is one ("frame_gyr")
    first_s : s, when it begins, on the recording's clock
    flags : (n,) bool array, the samples that it touches
    sentence : what is wrong, where, and what to do
    size : how large it is, in ``unit``; NaN if it has no size
    unit : of the size
    repair : what gives the recording without the fault, as well as can be; None if nothing can
    costs : how far it moves each result, 0 if it does not; empty if that is not known
    changes : whether it is another one in one part of the recording than in the next, as an offset
        is that steps or drifts
    """

    code: str
    sensor: str
    first_s: float
    flags: NDArray[np.bool_]
    sentence: str
    size: float = float("nan")
    unit: str = ""
    repair: Repair | None = None
    costs: tuple[Cost, ...] = ()
    changes: bool = False

    def __post_init__(self) -> None:
        """Check every field."""
        check_fields(
            self, code=str, sensor=str, first_s=float, sentence=str, size=float, unit=str,
            costs=[Cost], changes=bool,
        )  # fmt: skip
        object.__setattr__(self, "flags", some_flags(self.flags, "Fault.flags"))
        if not (self.repair is None or callable(self.repair)):
            raise InputError(f"Fault.repair: got {shown(self.repair)}, expected a function or None")
        super().__post_init__()

    @property
    def samples(self) -> int:
        """Number of samples that it touches."""
        return int(self.flags.sum())

    @property
    def told(self) -> str:
        """The sentence, with what the fault costs where that is known."""
        known = [str(cost) for cost in self.costs if cost.largest > 0]
        if not known:
            return self.sentence
        *others, last = known
        moved = f"{', '.join(others)} and {last}" if others else last
        return f"{self.sentence}; it moves {moved}"


def as_faults(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Check that faults are some.

    Parameters
    ----------
    faults : Fault, in any collection

    Returns
    -------
    tuple of Fault

    Raises
    ------
    InputError
        If they are something else.
    """
    try:
        if isinstance(faults, str | bytes | Mapping) or not isinstance(faults, Iterable):
            raise TypeError
        found = tuple(faults)
    except TypeError:  # an array of no dimension is iterable by its class only
        raise InputError(
            f"faults: got {type(faults).__name__}, expected those that find_faults gives"
        ) from None
    for number, fault in enumerate(found):
        expect(f"faults[{number}]", fault, Fault)
    return found


Estimate = Callable[[Recording], Mapping[tuple[str, str], FloatArray]]
"""What an estimate gives for a recording: name and unit of each result to its series."""


def with_costs(
    faults: Iterable[Fault], recording: Recording, estimate: Estimate
) -> tuple[Fault, ...]:
    """Find what each fault moves the results by.

    Each fault is undone by itself; what the others cost does not enter.

    Parameters
    ----------
    faults : Fault, of the recording
    recording : Recording
    estimate : function of a recording; its series have one value per sample, NaN where there is
        none, in the unit that the message names

    Returns
    -------
    tuple of Fault; those that cannot be undone, whose estimate is refused or knows nothing, and
    those beyond the first :data:`MOST_PRICED` that can be undone are as they were
    """
    faults = as_faults(faults)
    expect("recording", recording, Recording)
    expect("estimate", estimate, Callable)  # type: ignore[arg-type]
    fixable = [k for k, fault in enumerate(faults) if fault.repair is not None][:MOST_PRICED]
    if not fixable:
        return faults
    try:
        found = estimate(recording)
    except InputError:
        return faults
    return tuple(
        _priced(fault, recording, estimate, found) if k in fixable else fault
        for k, fault in enumerate(faults)
    )


def one_sided(fault: Fault) -> bool:
    """Whether a frozen sensor has no reading before or after the loss.

    A line between neighbours then repeats the one reading that is left, which is the fault itself.

    Parameters
    ----------
    fault : Fault

    Returns
    -------
    bool
    """
    expect("fault", fault, Fault)
    return fault.code == "frozen" and reaches_an_end(fault.flags)


def reaches_an_end(flags: NDArray[np.bool_]) -> bool:
    """Whether a loss has no sample before it or after it, so that no line can bridge it.

    Parameters
    ----------
    flags : (n,) bool array, the lost samples

    Returns
    -------
    bool
    """
    lost = some_flags(flags)
    return bool(len(lost) and (lost[0] or lost[-1]))


def _priced(
    fault: Fault,
    recording: Recording,
    estimate: Estimate,
    found: Mapping[tuple[str, str], FloatArray],
) -> Fault:
    if fault.repair is None:
        return fault
    try:
        better = estimate(fault.repair(recording))
    except InputError:
        return fault
    changes = {key: largest_change(values, better[key]) for key, values in found.items()}
    costs = tuple(
        Cost(name, change, unit) for (name, unit), change in changes.items() if np.isfinite(change)
    )
    return replace(fault, costs=costs)


def largest_change(first: ArrayLike, second: ArrayLike) -> float:
    """Largest difference of two series where both are known; NaN if they are so nowhere.

    Parameters
    ----------
    first, second : arrays of one shape

    Returns
    -------
    float
    """
    one, other = as_floats(first, "first"), as_floats(second, "second")
    if one.shape != other.shape:
        raise InputError(f"second: expected shape {one.shape} like first, got {other.shape}")
    apart = np.abs(one - other)
    return float(np.nanmax(apart)) if np.isfinite(apart).any() else float("nan")


def all_repaired(faults: Iterable[Fault], recording: Recording) -> Recording:
    """Recording in which each fault is undone that can be.

    Parameters
    ----------
    faults : Fault, of the recording
    recording : Recording

    Returns
    -------
    Recording
    """
    expect("recording", recording, Recording)
    repairs = [fault.repair for fault in as_faults(faults) if fault.repair is not None]
    return reduce(lambda mended, repair: repair(mended), repairs, recording)


def repaired_where_possible(faults: Iterable[Fault], recording: Recording) -> Recording:
    """Recording in which each fault is undone, as far as the result is a recording.

    Parameters
    ----------
    faults : Fault, of the recording
    recording : Recording

    Returns
    -------
    Recording
    """
    expect("recording", recording, Recording)
    for fault in as_faults(faults):
        try:
            recording = all_repaired([fault], recording)
        except InputError:
            continue
    return recording


def with_readings(
    recording: Recording,
    sensor: str,
    *,
    acc_mps2: FloatArray | None = None,
    gyr_radps: FloatArray | None = None,
) -> Recording:
    """Recording with other readings of one sensor.

    Parameters
    ----------
    recording : Recording
    sensor : name
    acc_mps2, gyr_radps : (n, 3) arrays; None leaves what is there

    Returns
    -------
    Recording
    """
    imu = _sensor(recording, sensor)
    new = Imu(
        imu.acc_mps2 if acc_mps2 is None else acc_mps2,
        imu.gyr_radps if gyr_radps is None else gyr_radps,
    )
    return Recording(recording.time_s, {**recording.sensors, sensor: new}, source=recording.source)


def with_half(recording: Recording, sensor: str, half: str, values: FloatArray) -> Recording:
    """Recording with other readings of one half of a sensor.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    values : (n, 3) array, m/s² or rad/s

    Returns
    -------
    Recording
    """
    if one_of("half", half, HALVES) == "acc":
        return with_readings(recording, sensor, acc_mps2=values)
    return with_readings(recording, sensor, gyr_radps=values)


def half_of(recording: Recording, sensor: str, half: str) -> FloatArray:
    """Readings of one half of a sensor.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"

    Returns
    -------
    (n, 3) array, m/s² or rad/s
    """
    imu = _sensor(recording, sensor)
    if one_of("half", half, HALVES) == "acc":
        return imu.acc_mps2
    return recording.gyroscope(sensor)


def interpolated(
    recording: Recording, sensor: str, half: str, flags: NDArray[np.bool_]
) -> Recording:
    """Recording in which samples of one half are replaced by lines between their neighbours.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    flags : (n,) bool array, the samples that are replaced

    Returns
    -------
    Recording; as it was if no sample is left to interpolate from
    """
    values = half_of(recording, sensor, half)
    time_s = recording.time_s
    flags = as_flags(flags, "flags", length=len(time_s))
    if flags.all():
        return recording
    axes = [np.interp(time_s, time_s[~flags], axis[~flags]) for axis in values.T]
    return with_half(recording, sensor, half, np.column_stack(axes))


def widened(recording: Recording, sensor: str, half: str, flags: NDArray[np.bool_]) -> Recording:
    """Recording in which the readings at the end of a range go on as a smooth curve.

    A cubic that fits the samples on both sides takes the place of the lost ones; where it falls
    inside the range they stay as they are.

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    flags : (n,) bool array, the samples at the end of the range

    Returns
    -------
    Recording
    """
    values = half_of(recording, sensor, half)
    flags = as_flags(flags, "flags", length=len(values))
    curves = np.array(values)
    for k, axis in enumerate(values.T):
        limit = np.abs(axis[flags]).max(initial=0.0)
        at_end = long_runs(flags & (np.abs(axis) == limit), FEWEST_CUT, grow=False)
        for lost in runs_of(at_end):
            beside = max(FEWEST_BESIDE, (lost.stop - lost.start) // 2)
            around = np.arange(max(0, lost.start - beside), min(len(axis), lost.stop + beside))
            known = around[~at_end[around]]
            if known.size < FEWEST_BESIDE or not known[0] < lost.start <= known[-1]:
                continue
            cubic = np.polynomial.Polynomial.fit(known, axis[known], 3)
            # A bow through many lost samples means nothing: twice the range at most.
            sign = np.sign(axis[lost])
            curves[lost, k] = sign * np.clip(
                sign * cubic(np.arange(len(axis))[lost]), limit, 2 * limit
            )
    return with_half(recording, sensor, half, curves)


def multiplied(recording: Recording, sensor: str, half: str, factors: ArrayLike) -> Recording:
    """Recording in which one half is multiplied, axis by axis (signs, scale factors).

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    factors : number or (3,) array

    Returns
    -------
    Recording
    """
    values, each = half_of(recording, sensor, half), as_floats(factors, "factors")
    if each.shape not in ((), (3,)):
        raise InputError(f"factors: expected a number or three, got shape {each.shape}")
    return with_half(recording, sensor, half, values * each)


def rescaled(
    recording: Recording, sensor: str, half: str, flags: NDArray[np.bool_], factor: float
) -> Recording:
    """Recording in which some samples of one half are multiplied (another unit).

    Parameters
    ----------
    recording : Recording
    sensor : name
    half : "acc" or "gyr"
    flags : (n,) bool array, the samples that are multiplied
    factor : number

    Returns
    -------
    Recording
    """
    values = half_of(recording, sensor, half)
    flags, factor = as_flags(flags, "flags", length=len(values)), as_number(factor, "factor")
    return with_half(recording, sensor, half, values * np.where(flags, factor, 1.0)[:, None])


def shifted(
    recording: Recording, sensor: str, lag_s: float, *, half: str | None = None
) -> Recording:
    """Recording in which a sensor's readings come earlier by a lag; its ends are held.

    Parameters
    ----------
    recording : Recording
    sensor : name
    lag_s : s by which the sensor comes late; negative if it comes early
    half : "acc" or "gyr", if one half alone comes late

    Returns
    -------
    Recording
    """
    imu, time_s = _sensor(recording, sensor), recording.time_s
    lag_s = as_number(lag_s, "lag_s", negative=True)

    def moved(values: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(time_s + lag_s, time_s, axis) for axis in values.T])

    if half is not None:
        return with_half(recording, sensor, half, moved(half_of(recording, sensor, half)))
    return with_readings(
        recording,
        sensor,
        acc_mps2=moved(imu.acc_mps2),
        gyr_radps=None if imu.gyr_radps is None else moved(imu.gyr_radps),
    )


def turned_back(recording: Recording, sensor: str, rotation: FloatArray) -> Recording:
    """Recording in which a sensor's readings are turned.

    Parameters
    ----------
    recording : Recording
    sensor : name
    rotation : (3, 3) array, from the axes that the sensor has to those that it should have

    Returns
    -------
    Recording
    """
    imu = _sensor(recording, sensor)
    turn = as_floats(rotation, "rotation")
    if turn.shape != (3, 3):
        raise InputError(f"rotation: expected a 3 x 3 matrix, got shape {turn.shape}")
    return with_readings(
        recording,
        sensor,
        acc_mps2=imu.acc_mps2 @ turn.T,
        gyr_radps=None if imu.gyr_radps is None else imu.gyr_radps @ turn.T,
    )


def without_offset(recording: Recording, sensor: str, offset_radps: FloatArray) -> Recording:
    """Recording in which an offset is taken off a gyroscope.

    Parameters
    ----------
    recording : Recording
    sensor : name
    offset_radps : (3,) array, or (n, 3) of an offset that changes, rad/s, in the sensor's axes

    Returns
    -------
    Recording
    """
    rates, offset = half_of(recording, sensor, "gyr"), as_floats(offset_radps, "offset_radps")
    if offset.shape not in ((3,), rates.shape):
        raise InputError(f"offset_radps: expected shape (3,) or {rates.shape}, got {offset.shape}")
    return with_half(recording, sensor, "gyr", rates - offset)


def exchanged(recording: Recording, first: str, second: str) -> Recording:
    """Recording in which two sensors have each other's names.

    Parameters
    ----------
    recording : Recording
    first, second : names

    Returns
    -------
    Recording
    """
    for name in (first, second):
        _sensor(recording, name)
    names = {first: second, second: first}
    sensors = {name: recording.sensor(names.get(name, name)) for name in recording.sensors}
    return Recording(recording.time_s, sensors, source=recording.source)


def _sensor(recording: Recording, name: str) -> Imu:
    expect("recording", recording, Recording)
    expect("sensor", name, str)
    return recording.sensor(name)
