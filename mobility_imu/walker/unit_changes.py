"""A gyroscope that is in deg/s in one part of a recording and in rad/s in the other.

Where rates are 57 times too large, they say turns about level axes that gravity would show; where
the sensor moves as much and the rates are right, none do.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of

__all__ = ["UnitChange", "find_unit_change"]

WINDOW_S = 0.5
"""Readings are averaged over it: a push is over by then, and a frame has hardly turned."""
LEAST_TURN_MPS2 = 3.0
"""Least change of gravity, as the rates tell it, that is held against what is felt: a third of it.
Set by hand."""
TIMES_FELT = 4.0
"""A turn that gravity does not show is told so many times as large as what is felt. No half second
of 27 recordings of frames and chairs has one."""
FEWEST_WINDOWS, LEAST_PART = 5, 0.1
"""Such half seconds in the part in deg/s: their number, and their fraction. Our choices, not
swept."""
MOST_UNSEEN = 0.5
"""Fraction of the part's turns that gravity does not show, from which on the part is in deg/s. Our
choice, not swept."""
SHORTEST_S = 5.0
"""Shortest part of the recording that is held against the other. Our choice, not swept: a step or
two."""
LEAST_MOTION = 0.5
"""How much one part moves, as a fraction of the other, to be compared with it. Our choice, not
swept."""
LEAST_FELT_MPS2, LEAST_TIMES = 1e-3, 0.01
"""Below them, a change of force, and how many times as large a turn is told, are noise at rest."""
DEG = float(np.rad2deg(1.0))
QUIET, MOVING, LEVELS = 0.25, 0.7, (0.5, 0.75, 0.9)
"""Quantiles at which the parts' rates are compared: of all half seconds, of the change of force
from which on one moves, and of the samples of those that move."""
MOST_TIMES, MEAN_TIMES = 2.0, 1.5
"""All these differ by the ratio of the units, times or over the first, and their geometric mean by
it times or over the second: nobody moves evenly. Parts of one walk that are a quarter of it or
longer have 38 to 94, with a mean of 47 or more, in deg/s; 29 to 40, with a mean of 33, if 30 times
too large; 800 or more of the quiet ones with noise of 3 rad/s; 8 or less with spikes; 0 to 1 with
an offset, or frozen."""


class UnitChange(NamedTuple):
    """Parts of a recording whose rates are 57 times those of the rest.

    Parameters
    ----------
    spans_s : pairs of start and stop, s, one for each part, to half a second or where the first
        turn shows it
    sentence : for the user
    """

    spans_s: tuple[tuple[float, float], ...]
    sentence: str


def find_unit_change(recording: Recording, name: str = "frame") -> UnitChange | None:
    """Where the unit of a gyroscope changes within a recording, as far as gravity shows it.

    Parameters
    ----------
    recording : Recording
    name : sensor on what neither spins nor falls

    Returns
    -------
    UnitChange, None if there is none, if it changes more than twice, or if one part is at rest, in
    which nothing shows
    """
    expect("recording", recording, Recording)
    expect("name", name, str)
    imu, rate_hz = recording.sensor(name), recording.sampling_rate_hz
    if imu.gyr_radps is None:
        return None
    width = max(1, round(WINDOW_S * rate_hz))
    count = len(imu) // width
    if count < 2 * SHORTEST_S / WINDOW_S:
        return None
    force = _means(imu.acc_mps2, width)
    turned = np.cumsum(imu.gyr_radps, axis=0)[width // 2 :: width][:count] / rate_hz
    told = np.cross(np.diff(turned, axis=0), (force[1:] + force[:-1]) / 2)
    told, felt = (np.linalg.norm(each, axis=1) for each in (told, np.diff(force, axis=0)))
    turns = told > LEAST_TURN_MPS2
    # Where nothing at all is felt, the accelerometer is frozen.
    unseen = turns & (told > TIMES_FELT * felt) & (felt > 0)
    if unseen.sum() < FEWEST_WINDOWS:
        return None
    rates = np.sqrt(_means((imu.gyr_radps**2).sum(axis=1, keepdims=True), width)[1:, 0])
    times_felt = np.log(told / np.maximum(felt, LEAST_FELT_MPS2) + LEAST_TIMES)
    moving = felt >= np.quantile(felt, MOVING)
    windows = imu.gyr_radps[width : count * width].reshape(count - 1, width, 3)
    for part in _parts(times_felt):
        if not _differ(part, unseen, felt) or unseen[part].sum() < MOST_UNSEEN * turns[part].sum():
            continue
        # One part may rest more than the other.
        if _is_in_degrees(*(_levels(windows[each], moving[each]) for each in (part, ~part))):
            ends = [(run.start, run.stop) for run in runs_of(part)]
            spans = tuple(
                (
                    float(recording.time_s[start * width]),
                    float(recording.time_s[-1 if stop == count - 1 else stop * width]),
                )
                for start, stop in ends
            )
            return UnitChange(spans, _sentence(recording, name, spans, rates, part))
    return None


def _sentence(
    recording: Recording,
    name: str,
    spans_s: tuple[tuple[float, float], ...],
    rates: FloatArray,
    part: NDArray[np.bool_],
) -> str:
    times = " and from ".join(f"{start:.0f} to {stop:.0f} s" for start, stop in spans_s)
    return (
        f"{recording.source}: {name}_gyr reads about {_rms(rates, part):.2g} rad/s from {times} "
        f"and {_rms(rates, ~part):.2g} rad/s elsewhere, where it moves alike, and gravity does "
        "not show these turns: is it in deg/s there? Convert these rows"
    )


def _means(values: FloatArray, width: int) -> FloatArray:
    count = len(values) // width
    return np.asarray(values[: count * width].reshape(count, width, -1).mean(axis=1))


def _parts(values: FloatArray) -> Iterator[NDArray[np.bool_]]:
    """Parts of a series that may be at another level than the rest: the middle, both ends, an end.

    Logarithms are given: a middle differs from both ends by half of that of the units' ratio or
    more. Its two steps are each found anew without what lies beyond the other.
    """
    index, change = np.arange(len(values)), _step(values)
    pairs = []
    if change < len(values) - 1:
        last = change + _step(values[change:])
        pairs.append((_step(values[:last]), last))
    if change > 1:
        first = _step(values[:change])
        pairs.append((first, first + _step(values[first:])))
    for first, last in pairs:
        level = values[first:last].mean()
        off = [float(end.mean() - level) for end in (values[:first], values[last:])]
        long = min(first, len(values) - last) * WINDOW_S >= SHORTEST_S
        if long and (min(off) > np.log(DEG) / 2 or max(off) < -np.log(DEG) / 2):
            middle = (index >= first) & (index < last)
            yield from (middle, ~middle)
    yield from (index >= change, index < change)


def _step(values: FloatArray) -> int:
    """Where a series steps from one level to another, by least squares; from 1."""
    count = np.arange(1, len(values))
    sums = np.cumsum(values)
    before, after = sums[:-1], sums[-1] - sums[:-1]
    return 1 + int(np.argmax(before**2 / count + after**2 / (len(values) - count)))


def _rms(values: FloatArray, where: NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(values[where] ** 2)))


def _is_in_degrees(here: FloatArray, elsewhere: FloatArray) -> bool:
    """Whether the levels of the rates here are those of elsewhere in the other unit."""
    if not elsewhere.all() or not here.all():
        return False
    off = np.log(here / elsewhere / DEG)
    return bool(np.abs(off).max() < np.log(MOST_TIMES) and abs(off.mean()) < np.log(MEAN_TIMES))


def _levels(windows: FloatArray, moving: NDArray[np.bool_]) -> FloatArray:
    """Sizes of the rates (k, w, 3) off their median, an offset: the quiet and the moving ones."""
    if not moving.any():
        return np.zeros(1 + len(LEVELS))
    size = np.linalg.norm(windows - np.median(windows, axis=(0, 1)), axis=2)
    quiet = np.quantile(np.median(size, axis=1), QUIET)
    return np.array([quiet, *np.quantile(size[moving], LEVELS)])


def _differ(part: NDArray[np.bool_], unseen: NDArray[np.bool_], felt: FloatArray) -> bool:
    """Whether a part tells turns that are not felt, and the rest, which moves alike, does not."""
    if (~part).sum() * WINDOW_S < SHORTEST_S or unseen[part].mean() < LEAST_PART:
        return False
    if unseen[~part].any():
        return False
    return _rms(felt, ~part) >= LEAST_MOTION * _rms(felt, part)
