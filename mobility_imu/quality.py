"""What is wrong with a sensor: samples in which it is frozen or at the end of its range.

Both faults show as readings that repeat themselves. So do the readings of a sensor that works, if
its steps are coarse against its noise: at rest it says the same number for seconds, and at the end
of a slow movement its largest one. The two are told apart by what the recording itself shows: how
often each axis repeats where another one changes, and how large the steps are.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.frames import (
    FloatArray,
    as_count,
    as_flags,
    as_floats,
    as_number,
    as_vectors,
)
from mobility_imu.runs import long_runs, runs_of

LARGEST_OFFSET_RADPS = 0.15
"""No gyroscope that is sold has a larger offset (8.6 deg/s): it is a steady turn."""
SHORTEST_FROZEN_S = 0.25
"""Seconds of the shortest repetition that is called frozen."""
NO_ACCIDENT = 1e-9
"""Chance of a repetition from which on it is none, by how often each axis repeats elsewhere. It
counts at low sampling rates only: a quarter of a second is 3 readings at 12.5 Hz."""
COARSE_REPEATS = 0.5
"""Chance from which on an axis at rest is called coarse: its next reading is the same again.

With white noise of standard deviation s and steps q the chance is near 0.28 for s = q and 0.5 for
s = q/2. A reading in the middle of its step then repeats with erf(q / (s sqrt(8))), 0.68 for
s = q/2; at 0.7, all three axes of an accelerometer repeat for a quarter of a second at 100 Hz once
in 10^11 samples. So long repetitions of finer axes are no accident.
"""
QUIET_PAIRS = 0.02
"""Fraction of all changes, the quietest, at which the steps are looked at."""
FEWEST_PAIRS = 60
"""Changes that are looked at at least."""
QUIET_SAMPLES = 25
"""Samples around a change by which its quietness is measured."""
FELT_STEPS = 4.0
"""Steps that a working sensor's reading changes by for sure; rounding explains one or two."""
FINE_REPEATS = 0.3
"""Chance up to which the noise is as large as a step or larger; then 8 equal readings in a row are
no accident."""
LONG_PLATEAU = 8
LARGEST_LOOK = 10
"""Samples beyond a plateau at which it is looked at how far the readings have fallen, at most."""
FELT_FRACTION = 0.15
"""Fraction of a reading's length by which another sensor has to expect a change (9 deg of tilt)."""
ABOUT_ITSELF = float(np.cos(np.deg2rad(12.0)))
"""Cosine of the angle to the axis of a turn up to which a force is taken to stay in the sensor's
axes: 12 deg are a centripetal force of 2 m/s², at 2 rad/s and 0.5 m. So up to 24 deg of tilt are
not seen in such a turn. Our choice, not swept."""


class Resolution(NamedTuple):
    """How finely a sensor's axes are read where it is quietest.

    Parameters
    ----------
    repeats : (k,) array, chance that an axis reads the same again while another one changes
    step : (k,) array, median size of an axis' changes there, in the unit of the readings; of an
        axis that does not change there, a small one of all its changes; 0 for one that never does
    pairs : number of changes that this rests on; 0 tells nothing
    """

    repeats: FloatArray
    step: FloatArray
    pairs: int

    @property
    def coarse(self) -> NDArray[np.bool_]:
        """Axes that repeat themselves at rest because of their steps, (k,)."""
        return (self.repeats >= COARSE_REPEATS) & (self.pairs > 0)

    @property
    def all_coarse(self) -> bool:
        """Whether all axes together may repeat themselves at rest because of their steps.

        The geometric mean of the chances counts: an axis at the edge of its step changes often.
        """
        return bool(self.pairs and self.repeats.prod() >= COARSE_REPEATS ** len(self.repeats))


def resolution_of(values: ArrayLike, *, skip: ArrayLike | None = None) -> Resolution:
    """Resolution that a sensor's readings show, in the quietest part of a recording.

    Samples that are held or doubled repeat on all axes at once and tell nothing of the steps: the
    repetitions of one axis are counted where another one changes.

    Parameters
    ----------
    values : (n, k) array
    skip : (n,) bool array, samples that are not looked at; none if it is not given

    Returns
    -------
    Resolution

    Raises
    ------
    InputError
        If the readings are no series of one or more axes.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(0, 0.02, (1000, 3))
    >>> resolution_of(noise.round(1)).coarse.tolist(), resolution_of(noise.round(3)).coarse.tolist()
    ([True, True, True], [False, False, False])
    """
    values = _readings(values)
    change = np.abs(np.diff(values, axis=0))
    changed = change > 0
    live = np.logical_or.reduce(changed.T)
    if skip is not None:
        unused = as_flags(skip, "skip", length=len(values))
        live &= ~(unused[1:] | unused[:-1])
    axes = values.shape[1]
    if not live.any():
        return Resolution(np.ones(axes), np.zeros(axes), 0)
    size = change[live].mean(axis=0)
    activity = sum((change / np.where(size > 0, size, 1.0)).T)
    activity = ndimage.uniform_filter1d(activity, QUIET_SAMPLES, mode="nearest")
    places = np.nonzero(live)[0]
    count = min(len(places), max(FEWEST_PAIRS, int(QUIET_PAIRS * len(places))))
    quiet = places[_least(activity[places], count)]
    found, sizes = changed[quiet], change[quiet]
    repeats, step = np.empty(axes), np.zeros(axes)
    for k in range(axes):
        others = np.delete(found, k, axis=1).any(axis=1)
        # Where the other axes hardly change, nothing tells a held sample from a still one.
        enough = others.sum() >= min(FEWEST_PAIRS, count) / 2
        repeats[k] = 1 - (found[others, k] if enough else changed[:, k]).mean()
        if found[:, k].any():
            step[k] = np.median(sizes[found[:, k], k])
        elif changed[:, k].any():
            step[k] = np.percentile(change[changed[:, k], k], 10)
    return Resolution(repeats, step, count)


def _least(values: FloatArray, count: int) -> NDArray[np.intp]:
    """Places of the least values; of equal ones the first."""
    most = np.partition(values, count - 1)[count - 1]
    below, equal = np.flatnonzero(values < most), np.flatnonzero(values == most)
    return np.concatenate([below, equal[: count - len(below)]])


def same_as_before(values: ArrayLike) -> NDArray[np.bool_]:
    """Where a sensor reads on all axes what it read one sample before.

    Parameters
    ----------
    values : (n, k) array

    Returns
    -------
    (n,) bool array; the first sample has none before it

    Raises
    ------
    InputError
        If the readings are no series of one or more axes.

    Examples
    --------
    >>> same_as_before([[0, 1], [0, 1], [0, 2]]).tolist()
    [False, True, False]
    """
    values = _readings(values)
    same = np.zeros(len(values), np.bool_)
    same[1:] = np.logical_and.reduce([axis[1:] == axis[:-1] for axis in values.T])
    return same


def frozen_samples(
    values: ArrayLike, sampling_rate_hz: float, *, follows: Sequence[ArrayLike] = ()
) -> NDArray[np.bool_]:
    """Where a sensor repeats itself on all axes, and neither rest nor resolution explains it.

    All axes have to repeat for :data:`SHORTEST_FROZEN_S` or longer. A sensor whose noise changes
    the last digit is then frozen. One with coarse steps (:class:`Resolution`) may be at rest, and
    so may one that comes back to the same reading; it is frozen if other sensors felt a motion
    that it had to feel.

    Parameters
    ----------
    values : (n, k) array
    sampling_rate_hz : Hz
    follows : (n, k) arrays in the unit of the values: what other sensors expect the values to be,
        each up to a constant, such as :func:`turned_gravity`. A repetition in which one of them
        changes by more than :data:`FELT_STEPS` steps and :data:`FELT_FRACTION` of the reading's
        length is no rest.

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If the readings are no series of one or more axes, or what they follow has another shape.
    """
    values = _readings(values)
    rate = as_number(sampling_rate_hz, "sampling_rate_hz")
    if not isinstance(follows, list | tuple):
        raise InputError(f"follows: got {type(follows).__name__}, expected a list of arrays")
    expected = [as_floats(one, "follows") for one in follows]
    for one in expected:
        if one.shape != values.shape:
            raise InputError(f"follows: expected shape {values.shape}, got {one.shape}")
    if not len(values):
        return np.zeros(0, np.bool_)
    same = same_as_before(values)
    repeated = long_runs(same, max(2, round(SHORTEST_FROZEN_S * rate) - 1), grow=True)
    if not repeated.any():
        return repeated
    resolution = resolution_of(values, skip=repeated)
    parts = _repetitions(values, repeated)
    if resolution.pairs and not resolution.all_coarse:
        chance = float(resolution.repeats.prod())
        for part in parts:
            repeated[part] = chance ** (part.stop - part.start - 1) < NO_ACCIDENT
        parts = [part for part in parts if repeated[part].all()]
    # Where it moves whenever it does not repeat, its steps are seen by what it comes back to.
    rests = parts if resolution.all_coarse else _taken_again(values, parts) if expected else []
    frozen = repeated.copy()
    step = resolution.step.max()
    if not resolution.all_coarse:
        step = min(step, max(smallest_step(axis) for axis in values.T))
    for run in rests:
        least = max(FELT_STEPS * step, FELT_FRACTION * _length(values[run.start]))
        frozen[run] = any(np.ptp(one[run], axis=0).max() > least for one in expected)
    return frozen


def turned_gravity(
    acc_mps2: ArrayLike, gyr_radps: ArrayLike, sampling_rate_hz: float
) -> FloatArray:
    """Accelerations that a gyroscope expects of an accelerometer beside it, up to a constant.

    A force that stays as it is in the world turns in the sensor's axes by -rate x force. One that
    lies nearly along the axis of the turn is gravity with the centripetal force of a turn on level
    ground, which stays as it is in the sensor's axes. The mean
    rate of the quietest second is taken for the gyroscope's offset, if an offset can be so large;
    the median would be the spin of a wheel.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s²
    gyr_radps : (n, 3) array, rad/s, of the same sensor
    sampling_rate_hz : Hz

    Returns
    -------
    (n, 3) array, m/s²; its differences are right for a second or so

    Raises
    ------
    InputError
        If a series is not finite, both are not of one length, or the rate is not positive.
    """
    acc = as_vectors(acc_mps2, "acc_mps2", ndim=2)
    gyr = as_vectors(gyr_radps, "gyr_radps", length=len(acc))
    step_s = 1 / as_number(sampling_rate_hz, "sampling_rate_hz")
    rate = gyr - _quiet_rate(gyr, max(2, round(1 / step_s))) if len(gyr) else gyr
    turning = np.cross(rate, acc)
    along = np.abs(np.einsum("ni,ni->n", rate, acc))
    sizes = np.sqrt([np.einsum("ni,ni->n", vectors, vectors) for vectors in (rate, acc)])
    turning[along > ABOUT_ITSELF * sizes.prod(axis=0)] = 0
    return np.cumsum(-turning * step_s, axis=0)


def _quiet_rate(gyr: FloatArray, window: int) -> FloatArray:
    """Mean rate where it changes least over a window; zero if no offset is so large."""
    window = min(window, len(gyr))
    mean = ndimage.uniform_filter1d(gyr, window, axis=0)
    spread = ndimage.uniform_filter1d(gyr**2, window, axis=0) - mean**2
    inside = slice(window // 2, max(len(gyr) - window // 2, window // 2 + 1))
    quiet = mean[inside][int(np.argmin(spread[inside].sum(axis=1)))]
    return quiet if np.abs(quiet).max() <= LARGEST_OFFSET_RADPS else np.zeros(3)


def saturated_samples(values: ArrayLike, *, run: int = 3) -> NDArray[np.bool_]:
    """Where an axis stays at its largest size for some samples: the range of the sensor is cut.

    An axis also stays there at the end of a slow movement, or at rest, if its steps are large
    against its noise. So the readings must come and go faster than rounding explains at a smooth
    peak, while another axis moves; or stay on an axis whose noise would change them.

    Parameters
    ----------
    values : (n, k) array
    run : fewest samples at the limit, one after the other

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If the readings are no series of one or more axes.
    """
    values, run = _readings(values), as_count(run, "run")
    cut = np.zeros(len(values), bool)
    if not len(values):
        return cut
    size = np.abs(values)
    limit = np.array([axis.max() for axis in size.T])
    at_limit = np.column_stack([long_runs(axis, run, grow=False) for axis in (size == limit).T])
    if not at_limit.any():
        return cut
    # Of an axis that is cut for half of the time, the median itself is the limit.
    at_limit &= (limit > 1.2 * np.median(size, axis=0)) | pinned_axes(values)
    if not at_limit.any():
        return cut
    resolution = resolution_of(values, skip=at_limit.any(axis=1))
    for k, (axis, limit) in enumerate(zip(size.T, at_limit.T, strict=True)):
        # A sensor that never is quiet shows its steps by the values that it takes at all.
        step = min(resolution.step[k], smallest_step(values[:, k]))
        for plateau in runs_of(limit):
            others = np.delete(np.arange(values.shape[1]), k)
            spread = np.ptp(values[plateau][:, others], axis=0)
            at_rest = len(others) and (spread <= FELT_STEPS * resolution.step[others]).all()
            noisy = resolution.repeats[k] < FINE_REPEATS and resolution.pairs
            if (noisy and plateau.stop - plateau.start >= LONG_PLATEAU) or (
                not (at_rest and resolution.coarse[k]) and _falls_fast(axis, plateau, step)
            ):
                cut[plateau] = True
    return cut


OFTEN_AT_END = 0.05
"""Part of the samples that only a cut range leaves exactly at an axis' largest value."""
VARIED_VALUES = 20
"""... if the axis takes more values than this."""


def pinned_axes(values: ArrayLike) -> NDArray[np.bool_]:
    """Axes that read exactly their largest size for much of a recording.

    Parameters
    ----------
    values : (n, k) array

    Returns
    -------
    (k,) bool array

    Raises
    ------
    InputError
        If the readings are no series of one or more axes.
    """
    values = _readings(values)
    if not len(values):
        return np.zeros(values.shape[1], np.bool_)
    return np.array([_is_pinned(axis) for axis in values.T])


def _is_pinned(axis: FloatArray) -> bool:
    size = np.abs(axis)
    often = size.max() > 0 and (size == size.max()).mean() > OFTEN_AT_END
    return bool(often and len(np.unique(axis)) > VARIED_VALUES)


def smallest_step(axis: FloatArray) -> float:
    """How far apart the values of an axis are where they are closest; infinite for one value.

    Parameters
    ----------
    axis : (n,) array

    Returns
    -------
    float, in the values' unit

    Raises
    ------
    InputError
        If it is no series of numbers.

    Examples
    --------
    >>> smallest_step(np.array([0.5, 0.0, 1.5, 0.5]))
    0.55
    """
    values = as_floats(axis, "axis")
    if values.ndim != 1:
        raise InputError(f"axis: expected one series, got an array of shape {values.shape}")
    apart = np.diff(np.unique(values))
    return float(np.percentile(apart, 10)) if len(apart) else np.inf


def _falls_fast(axis: FloatArray, plateau: slice, step: float) -> bool:
    """Whether the readings fall on both sides of a plateau by more than rounding explains.

    Rounded to steps q, a smooth peak stays for n samples; m samples beyond, the parabola has fallen
    by q (1 + 2 m / n)². Twice that is asked for.
    """
    count = plateau.stop - plateau.start
    beyond = min(count, LARGEST_LOOK)
    ends = (plateau.start - beyond, plateau.stop - 1 + beyond)
    rounding = step * (1 + 2 * beyond / count) ** 2
    falls = [axis[plateau.start] - axis[end] for end in ends if 0 <= end < len(axis)]
    return all(fall > 2 * rounding for fall in falls)


def _repetitions(values: FloatArray, repeated: NDArray[np.bool_]) -> list[slice]:
    """Runs of one and the same reading within the samples that repeat."""
    parts = []
    for run in runs_of(repeated):
        starts = np.nonzero((np.diff(values[run], axis=0) != 0).any(axis=1))[0] + 1
        edges = [run.start, *(run.start + starts).tolist(), run.stop]
        parts += [slice(a, b) for a, b in pairwise(edges)]
    return parts


def _taken_again(values: FloatArray, parts: Sequence[slice]) -> list[slice]:
    """Repetitions of a reading that the sensor left and came back to, exactly, on all axes.

    A sensor that freezes twice does so at two readings; one that writes zeros instead is no rest.
    """
    found: dict[bytes, list[slice]] = {}
    for part in parts:
        if values[part.start].any():
            found.setdefault(values[part.start].tobytes(), []).append(part)
    return [part for same in found.values() if len(same) > 1 for part in same]


def _length(reading: FloatArray) -> float:
    return float(np.linalg.norm(reading))


def _readings(values: ArrayLike) -> FloatArray:
    """Readings as floats, not as int16, which cannot hold its own largest size."""
    array = as_floats(values, "values")
    if array.ndim != 2 or not array.shape[1]:
        raise InputError(f"values: expected shape (n, k), got {array.shape}")
    return array
