"""What is wrong with the sensors of a recording, whatever device it comes from.

:func:`examine` looks for faults that change a result without stopping it: a sensor that repeats its
last sample, an axis that says nothing, single readings far off, a range that is cut, a gyroscope
whose signs do not fit the accelerometer beside it, a half that is in another unit for a while, two
sensors with the same data.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.faults import (
    Fault,
    Repair,
    as_faults,
    half_of,
    interpolated,
    multiplied,
    reaches_an_end,
    repaired_where_possible,
    rescaled,
    widened,
    with_half,
)
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_count,
    as_flags,
    as_floats,
    as_number,
    as_vectors,
)
from mobility_imu.quality import (
    QUIET_SAMPLES,
    SHORTEST_FROZEN_S,
    frozen_samples,
    pinned_axes,
    same_as_before,
    saturated_samples,
    smallest_step,
    turned_gravity,
)
from mobility_imu.recording import Imu, Recording
from mobility_imu.runs import FEWEST_VALUES, long_runs, runs_of
from mobility_imu.unit_changes import find_unit_change

LONGEST_STILL_GYR_S = 1.0
"""A gyroscope that says the same number for longer, while gravity turns beside it, is dead."""
TURNED_MPS2 = 1.0
"""Change of the accelerations, in a second or so, that comes with a turn (6 deg of tilt)."""
SHORTEST_STUCK = 25
"""Equal readings of one axis, and at least as long as a whole half has to repeat itself. With noise
of one step the next reading is the same with a chance of 0.38 at most: 25 come once in 10^10."""
OWN_STEPS, MOST_REPEATS, OWN_TURNS = 1.0, 0.4, 0.2
"""An axis changes by its own noise if its mean change, where the others are as quiet, is a step or
more, it seldom repeats itself there, and turns back often: white noise does so in two of three
samples, a smooth motion without noise hardly ever. Our choice, not swept."""
MOST_OF_ALL = 0.7
"""... and if more than this part of its repetitions are so: coarse steps that were interpolated
look fine between the rests, but an axis at rest repeats itself in each."""
FEWEST_BESIDE = 100
"""Changes elsewhere, at least, by which an axis' noise is judged."""
SPIKE_MPS2, SPIKE_RADPS = 100.0, 10.0
"""One reading that leaves both neighbours by more, while these agree, is no movement: a hand or a
wheel needs more than two samples for it."""
SPIKE_TIMES = 20.0
"""... and by so many times the usual change from sample to sample."""
SHORTEST_AT_END_S = 0.05
"""Fewer equal readings at the largest size come by chance, where readings are doubled."""
SMOOTHED_S = 0.1
"""Accelerations are averaged over this before their changes are looked at."""
SPANS_S = (0.05, 0.3)
"""Changes over such times are compared: short ones for wheels, long ones beneath vibration. Where
both say something they have to say the same."""
LEAST_CHANGE_MPS2 = 0.5
"""Change that the gyroscope expects from which on it counts as turning: 3 deg of tilt."""
LARGEST_PUSH_MPS2 = 2.0
"""Only samples count whose force is gravity within this."""
LEAST_TURNING_S = 2.0
"""Time with such changes from which on the signs of a gyroscope are judged."""
SURE_FIT, CLEARLY_WORSE, SOME_FIT = 0.75, 0.25, 0.55
"""Correlation of the best signs from which on they are believed, and by how much the stated signs
have to fit worse; and from which on the stated signs are, where none are believed.

Pushes go with a motion: the forces of a foot that swings, or of a chair that is pushed and pitches,
have correlations down to -0.68 although the signs are right (recordings of others). Gravity that
turns beside a wheel's or a lever's gyroscope has 0.76 to 0.99."""


def examine(recording: Recording) -> tuple[Fault, ...]:
    """Look for faults of the sensors of a recording.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    tuple of Fault, empty if nothing was found
    """
    expect("recording", recording, Recording)
    found = [fault for name in recording.sensors for fault in unit_faults(recording, name)]
    # The edges of a part in another unit, and the readings in it, look like other faults.
    recording = repaired_where_possible(found, recording)
    for name, imu in recording.sensors.items():
        own = list(_halves(recording, name, imu))
        found += own
        if imu.gyr_radps is not None:
            lost = samples_lost(own, len(recording))
            found += _reversed(recording, name, imu.acc_mps2, imu.gyr_radps, lost)
    found += _copies(recording)
    return tuple(found)


def unit_faults(recording: Recording, name: str) -> list[Fault]:
    """Halves of a sensor that are in another unit for a while; the gyroscope beside a mended force.

    Parameters
    ----------
    recording : Recording
    name : of the sensor

    Returns
    -------
    list of Fault
    """
    found: list[Fault] = []
    while change := find_unit_change(repaired_where_possible(found, recording), name):
        label = f"{name}_{change.half}"
        if any(fault.sensor == label for fault in found):
            break
        repair = partial(
            rescaled, sensor=name, half=change.half, flags=change.flags, factor=change.factor
        )
        seconds = float(change.flags.sum() / recording.sampling_rate_hz)
        found.append(
            Fault(
                "unit",
                label,
                change.spans_s[0][0],
                change.flags,
                change.sentence,
                seconds,
                "s",
                repair,
            )
        )
    return found


def _halves(recording: Recording, name: str, imu: Imu) -> Iterator[Fault]:
    """Faults of one half of a sensor: frozen, dead axis, spikes, range."""
    rate = recording.sampling_rate_hz
    felt: tuple[FloatArray, ...] = ()
    if imu.gyr_radps is not None and same_as_before(imu.acc_mps2).any():
        felt = (turned_gravity(imu.acc_mps2, imu.gyr_radps, rate),)
    halves = [("acc", imu.acc_mps2, SPIKE_MPS2, "m/s²")]
    if imu.gyr_radps is not None:
        halves.append(("gyr", imu.gyr_radps, SPIKE_RADPS, "rad/s"))

    def bridged(flags: NDArray[np.bool_]) -> Repair:
        return partial(interpolated, sensor=name, half=half, flags=flags)

    for half, values, spike, unit in halves:
        label = f"{name}_{half}"
        frozen = (
            frozen_samples(values, rate, follows=felt)
            if half == "acc"
            else frozen_gyroscope(imu.acc_mps2, values, rate)
        )
        if frozen.any():
            yield fault_of(
                recording, "frozen", label, frozen,
                "repeats its last reading; leave these times out, or record again",
                size=float(frozen.sum() / rate), unit="s", repair=bridged(frozen),
            )  # fmt: skip
        for k in _dead_axes(values):
            whole = np.ones(len(values), np.bool_)
            yield fault_of(
                recording, "dead axis", f"{label}_{'xyz'[k]}", whole,
                f"is {values[0, k] + 0.0:g} {unit} throughout, while other axes move: it is dead; "
                "use another sensor",
            )  # fmt: skip
        yield from _stuck(recording, name, half, frozen, unit)
        far = single_spikes(values, spike)
        if far.any():
            largest = float(np.abs(values[far]).max())
            yield fault_of(
                recording, "spike", label, far,
                f"jumps for single samples (to {largest:.3g} {unit} at most), which no movement "
                "does; remove them", size=largest, unit=unit, repair=bridged(far),
            )  # fmt: skip
        shortest = max(3, round(SHORTEST_AT_END_S * rate))
        often = _pinned(values)
        cut = saturated_samples(values, run=shortest) & ~(frozen | often)
        cut = long_runs(cut, shortest, grow=False) | (often & ~frozen)
        if cut.any():
            largest = _end_of_range(values, cut)
            yield fault_of(
                recording, "range", label, cut,
                f"stays at the end of its range, {largest:.4g} {unit}; choose a wider range",
                size=largest, unit=unit, repair=partial(widened, sensor=name, half=half, flags=cut),
            )  # fmt: skip


def _end_of_range(values: FloatArray, cut: NDArray[np.bool_]) -> float:
    """Largest size at which an axis stays; the others may be beyond it for a moment."""
    sizes = np.abs(values)
    ends = sizes[cut].max(axis=0)
    stays = [
        long_runs(cut & (sizes[:, k] == end), 3, grow=False).any() for k, end in enumerate(ends)
    ]
    return float(ends[stays].max() if any(stays) else ends.max())


def fault_of(
    recording: Recording,
    code: str,
    sensor: str,
    flags: NDArray[np.bool_],
    what: str,
    *,
    size: float = float("nan"),
    unit: str = "",
    repair: Repair | None = None,
) -> Fault:
    """Fault whose sentence names the file, the sensor, and when it begins.

    Parameters
    ----------
    recording : Recording
    code, sensor, flags, size, unit, repair : of :class:`~mobility_imu.faults.Fault`
    what : the rest of the sentence, after the sensor's name

    Returns
    -------
    Fault
    """
    expect("recording", recording, Recording)
    flags = as_flags(flags, "flags", length=len(recording))
    first = float(recording.time_s[int(np.argmax(flags))])
    count = int(flags.sum())
    samples = "1 sample" if count == 1 else f"{count} samples"
    where = "" if flags.all() else f" in {samples}, first at {first:.2f} s,"
    sentence = f"{recording.source}: {sensor}{where} {what}"
    return Fault(code, sensor, first, flags, sentence, size, unit, repair)


def frozen_gyroscope(
    acc_mps2: FloatArray, gyr_radps: FloatArray, sampling_rate_hz: float
) -> NDArray[np.bool_]:
    """Where a gyroscope repeats its last reading, or says one number while gravity turns.

    Parameters
    ----------
    acc_mps2, gyr_radps : (n, 3) arrays, m/s² and rad/s, of one sensor
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) bool array
    """
    return np.asarray(
        frozen_samples(gyr_radps, sampling_rate_hz) | _silent(acc_mps2, gyr_radps, sampling_rate_hz)
    )


def _silent(acc: FloatArray, gyr: FloatArray, rate_hz: float) -> NDArray[np.bool_]:
    """Where a gyroscope says one number for seconds although gravity turns beside it."""
    same = same_as_before(gyr)
    silent = np.zeros(len(gyr), np.bool_)
    for run in runs_of(same):
        whole = slice(max(0, run.start - 1), run.stop)
        long = whole.stop - whole.start > LONGEST_STILL_GYR_S * rate_hz
        # Means of a quarter of a second: a push is shorter than that, a turn is not.
        width = max(1, round(0.25 * rate_hz))
        if long and whole.stop - whole.start > 2 * width:
            sums = np.cumsum(np.vstack([np.zeros(3), acc[whole]]), axis=0)
            means = (sums[width:] - sums[:-width]) / width
            size = np.linalg.norm(means, axis=1, keepdims=True)
            direction = STANDARD_GRAVITY_MPS2 * means / np.maximum(size, 1e-9)
            silent[whole] = np.ptp(direction, axis=0).max() > TURNED_MPS2
    return silent


def _dead_axes(values: FloatArray) -> list[int]:
    """Axes that never change, of a half whose other axes take many values."""
    still = [k for k, axis in enumerate(values.T) if (axis == axis[0]).all()]
    if still and max(len(np.unique(axis)) for axis in values.T) > FEWEST_VALUES:
        return still
    return []


def samples_lost(faults: Iterable[Fault], count: int) -> NDArray[np.bool_]:
    """Samples in which a half or an axis says nothing: it is frozen, or dead.

    Parameters
    ----------
    faults : Fault
    count : samples of the recording

    Returns
    -------
    (n,) bool array
    """
    lost = np.zeros(as_count(count, "count", least=0), np.bool_)
    for fault in as_faults(faults):
        if fault.code in ("frozen", "dead axis"):
            lost |= as_flags(fault.flags, "flags of a fault", length=count)
    return lost


def _stuck(
    recording: Recording, name: str, half: str, frozen: NDArray[np.bool_], unit: str
) -> Iterator[Fault]:
    """Axes that say one number for some time, while their noise should change it."""
    values, rate = half_of(recording, name, half), recording.sampling_rate_hz
    for k, stuck in enumerate(stuck_axes(values, rate, skip=frozen).T):
        if not stuck.any():
            continue
        number = values[int(np.argmax(stuck)), k]
        bridged = partial(_axis_bridged, sensor=name, half=half, axis=k, flags=stuck)
        yield fault_of(
            recording, "dead axis", f"{name}_{half}_{'xyz'[k]}", stuck,
            f"stays at {number:.4g} {unit}, which its noise alone would change: it says nothing "
            "there; leave these times out, or use another sensor",
            size=float(stuck.sum() / rate), unit="s",
            repair=None if reaches_an_end(stuck) else bridged,
        )  # fmt: skip


def _axis_bridged(
    recording: Recording, sensor: str, half: str, axis: int, flags: NDArray[np.bool_]
) -> Recording:
    """Recording in which samples of one axis are lines between their neighbours."""
    values = np.array(half_of(recording, sensor, half))
    bridged = interpolated(recording, sensor, half, flags)
    values[:, axis] = half_of(bridged, sensor, half)[:, axis]
    return with_half(recording, sensor, half, values)


def stuck_axes(
    values: FloatArray, sampling_rate_hz: float, *, skip: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Where single axes repeat their last reading, although their own noise would change it.

    An axis' noise is what it does elsewhere while the other axes are as quiet as here, or quieter.
    One with steps that are coarse against its noise is not judged, nor one without noise, nor where
    it is at the end of its range.

    Parameters
    ----------
    values : (n, 3) array
    sampling_rate_hz : Hz
    skip : (n,) bool array, samples that are not looked at: where all axes are frozen

    Returns
    -------
    (n, 3) bool array
    """
    values = as_vectors(values, "values", ndim=2)
    skip = as_flags(skip, "skip", length=len(values))
    rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    stuck = np.zeros(values.shape, np.bool_)
    if len(values) < SHORTEST_STUCK:
        return stuck
    shortest = max(SHORTEST_STUCK, round(SHORTEST_FROZEN_S * rate_hz)) - 1
    change = np.diff(values, axis=0, prepend=values[:1])
    repeats = (change == 0) & ~skip[:, None]
    if not any(long_runs(axis, shortest, grow=False).any() for axis in repeats.T):
        return stuck
    scale = np.abs(change).mean(axis=0)
    busy = ndimage.uniform_filter1d(
        np.abs(change) / np.where(scale > 0, scale, 1.0), QUIET_SAMPLES, axis=0, mode="nearest"
    )
    for k, axis in enumerate(values.T):
        at_end = (axis == axis.max()) | (axis == axis.min())
        at_end &= np.abs(axis) > 0.9 * np.abs(axis).max()
        same = long_runs(repeats[:, k] & ~at_end, shortest, grow=True)
        if not same.any() or np.ptp(axis) == 0:
            continue
        step = smallest_step(axis)
        others = np.delete(busy, k, axis=1).sum(axis=1)
        free = ~(same | skip)
        free[1:] &= free[:-1].copy()
        free[0] = False
        told = np.zeros(len(values), np.bool_)
        for run in runs_of(same):
            beside = change[free & (others <= np.median(others[run])), k]
            if len(beside) < FEWEST_BESIDE:
                continue
            turns = (beside[1:] * beside[:-1] < 0).mean()
            told[run] = (
                np.abs(beside).mean() >= OWN_STEPS * step
                and (beside == 0).mean() < MOST_REPEATS
                and turns > OWN_TURNS
            )
        if told.sum() > MOST_OF_ALL * same.sum():
            stuck[:, k] = told
    return stuck


def single_spikes(values: FloatArray, least: float) -> NDArray[np.bool_]:
    """Single readings far from both neighbours, which agree.

    Parameters
    ----------
    values : (n, k) array
    least : distance from both neighbours, in the values' unit, and :data:`SPIKE_TIMES` the usual
        change from sample to sample

    Returns
    -------
    (n,) bool array
    """
    values, least = as_floats(values, "values"), as_number(least, "least", zero=True)
    if values.ndim != 2:
        raise InputError(f"values: expected shape (n, k), got {values.shape}")
    far = np.zeros(len(values), np.bool_)
    if len(values) < 5:
        return far
    step = np.diff(values, axis=0)
    up, down = step[:-1], step[1:]
    size = np.minimum(np.abs(up), np.abs(down))
    if not (size > least).any():
        return far
    usual = np.median(np.abs(step), axis=0)
    alone = (np.sign(up) != np.sign(down)) & (np.abs(up + down) < 0.25 * size)
    far[1:-1] = (alone & (size > np.maximum(least, SPIKE_TIMES * usual))).any(axis=1)
    return far


def _pinned(values: FloatArray) -> NDArray[np.bool_]:
    """Where an axis says exactly its largest size, if it does so for much of the recording."""
    sizes = np.abs(values[:, pinned_axes(values)])
    return np.asarray((sizes == sizes.max(axis=0, initial=0.0)).any(axis=1))


def _reversed(
    recording: Recording, name: str, acc: FloatArray, gyr: FloatArray, lost: NDArray[np.bool_]
) -> Iterator[Fault]:
    """A gyroscope whose signs do not fit: gravity turns in the sensor's axes by -rate x force.

    All eight choices of signs are tried; accelerations only add noise to each. Signs of axes that
    hardly turn change nothing, and are not judged. Changes over samples that are lost do not count.
    """
    rate_hz = recording.sampling_rate_hz
    smooth = max(1, round(SMOOTHED_S * rate_hz))
    kernel = np.ones(smooth) / smooth
    # What each axis of the rate alone adds to the force, summed up from the start: 3 of (3, n).
    sums = [
        np.cumsum(rate * np.cross(acc, axis).T, axis=1) / rate_hz
        for rate, axis in zip(gyr.T, np.eye(3), strict=True)
    ]
    force, *terms = (
        np.array([np.convolve(row, kernel, "valid") for row in rows]) for rows in (acc.T, *sums)
    )
    calm = np.abs(np.linalg.norm(force, axis=0) - STANDARD_GRAVITY_MPS2) < LARGEST_PUSH_MPS2
    gone = np.r_[0, np.cumsum(lost)]
    verdicts = []
    for span_s in SPANS_S:
        span = max(1, round(span_s * rate_hz))
        if len(calm) < 4 * span:
            continue
        seen = force[:, span:] - force[:, :-span]
        parts = np.array([term[:, span:] - term[:, :-span] for term in terms])
        turning = np.linalg.norm(parts.sum(axis=0), axis=0) > LEAST_CHANGE_MPS2
        turning &= calm[span:] & calm[:-span]
        turning &= gone[span + smooth - 1 :][1:] == gone[: -(span + smooth)]
        if turning.sum() < LEAST_TURNING_S * rate_hz:
            continue
        fits = _alike(parts[:, :, turning].reshape(3, -1), seen[:, turning].ravel())
        best = max(fits, key=lambda signs: fits[signs])
        stated = fits[1.0, 1.0, 1.0]
        if fits[best] > SURE_FIT and stated < fits[best] - CLEARLY_WORSE:
            verdicts.append(best)
        elif fits[best] > SOME_FIT:
            verdicts.append((1.0, 1.0, 1.0))
    bad = []
    if verdicts and len(set(verdicts)) == 1:
        bad = [axis for axis, sign in zip("xyz", verdicts[0], strict=True) if sign < 0]
    if bad:
        what = "the gyroscope" if len(bad) == 3 else f"axis {', '.join(bad)} of the gyroscope"
        whole = np.ones(len(acc), np.bool_)
        signs = np.array(verdicts[0])
        yield fault_of(
            recording, "reversed", f"{name}_gyr", whole,
            f"turns the other way than gravity shows: {what} has the wrong sign, or the "
            "accelerometer has; check the export's axes",
            repair=partial(multiplied, sensor=name, half="gyr", factors=signs),
        )  # fmt: skip


def _alike(parts: FloatArray, seen: FloatArray) -> dict[tuple[float, ...], float]:
    """Correlation about zero of what is seen with the sum of three parts, by the parts' signs."""
    among, along = np.einsum("im,jm->ij", parts, parts), np.einsum("im,m->i", parts, seen)
    power = float((seen**2).sum())
    fits = {}
    for signs in product((1.0, -1.0), repeat=3):
        size = float(np.sqrt(max(signs @ among @ signs, 0.0) * power))
        fits[signs] = float(signs @ along) / size if size > 0 else 0.0
    return fits


def _copies(recording: Recording) -> Iterator[Fault]:
    """Sensors whose accelerations are the same in every sample, and do change."""
    seen: dict[str, FloatArray] = {}
    for name, imu in recording.sensors.items():
        acc = imu.acc_mps2
        if (~same_as_before(acc)[1:]).sum() < FEWEST_VALUES:
            continue
        first = next((one for one, other in seen.items() if np.array_equal(acc, other)), name)
        seen.setdefault(first, acc)
        if first != name:
            yield Fault(
                "copy", f"{first}, {name}", float(recording.time_s[0]), np.ones(len(imu), np.bool_),
                f"{recording.source}: {first} and {name} have the same readings: one sensor was "
                "exported twice; give the recording of each",
            )  # fmt: skip
