"""Parts of a recording in which one half of a sensor is in another unit than elsewhere.

A unit multiplies everything at once. Of a gyroscope it multiplies the changes from sample to
sample, at rest its noise, 57 times, while the accelerometer beside it shakes as before; and the
rates on both sides of the first sample are the same but for the unit. Of an accelerometer it
multiplies gravity 9.8 times, from one sample to the next.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.arguments import expect
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of

__all__ = ["UnitChange", "find_unit_change"]

WINDOW_S, FEWEST_IN_WINDOW = 0.1, 5
"""Sizes are compared by their medians over such windows: no longer than the shortest part that is
looked for, and long enough that a spike does not count."""
GUARD = 2
"""Samples beside an edge that a change of rates reaches over."""
MOST_EDGES = 8
"""Edges from one to which a part may reach; beyond, it would have changed its unit in between."""
MOST_BESIDE_WINDOWS = 1000
"""Windows on either side of a part that it is held against, 100 s: they hold rests and moves."""
ALIKE = float(np.log(2.0))
"""Windows whose accelerometer shakes alike, within this factor, have rates that change alike."""
MOST_ALIKE = 0.8
"""Part of the windows that have to be off by the ratio of the units."""
FEWEST_LOUD, LOUD_OFF = 5, 2 / 3
"""Windows that shake most, from which on they are looked at by themselves, and by how much of a
single window's limit their median may be off."""
LEAST_SHAKING_MPS2 = 0.03
"""Changes of the force below are noise of any accelerometer that is sold (3 mg)."""
OFF_ACC, MEAN_OFF_ACC = (0.8, 1.0), (float(np.log(1.5)), 0.8, 0.6)
OFF_GYR, MEAN_OFF_GYR = (1.2, 1.5), (float(np.log(1.8)), 2.0, 0.0)
"""How far from the ratio of the units, as logarithms of factors, an edge's step and a window may
be; the whole part; the mean readings beside an edge; and the part of the ratio that comes from one
sample to the next. With them all but 2 of 333 parts of simulated walks are found (seeds from
910,000 on; of others 716 of 721), and nothing in 198 sensors of real recordings and 740 simulated
ones without a fault. A gyroscope that is 30 times too large is none (1.9)."""
CLEARLY_OFF = 1.0
"""Mean readings beside an edge that are so far off, as a logarithm, may be a move that begins."""
JUMP_TIMES = 2.5
"""Rates of a push go on from those before and after it; converted, they would jump by so many times
as much, in parts of the rate. Without this, pushes in 22 of 840 sensors of clean courts were called
parts in another unit; with it none, and of 149 made parts as many are found (144)."""
MOST_REPEATED = 0.3
"""Part of a window's changes that may be none: from one half on, their median would be chance."""
HOLDS_MOVES, MOVES, SAME_MOVES = 20, 0.9, float(np.log(4.0))
"""Windows that hold a move, a step or two; quantile of the rates over their changes that is one of
moves; and the factor, as a logarithm, within which it is the same in both parts."""
SMALLEST = 1e-9
"""Sizes below are none: of readings that repeat themselves, or lie on a line."""
LEAST_TURN_MPS2, TIMES_FELT = 3.0, 4.0
"""A turn of gravity within a window that the rates tell, and how many times as large as the change
that is felt, from which on the rates are too large. None of 27 real recordings has such turns over
half a second. The first is set by hand: a third of gravity."""
UNSEEN = 0.05
"""Part of the windows with such turns from which on the larger rates are the wrong ones."""
MOVES_MPS2, MOVES_RADPS = 1.0, 0.1
"""Change of force from one window to the next that only a move has, and a rate that a move has."""

FEWEST_QUIET, QUIET_MPS2, NOISIEST_RADPS = 5, 0.3, 0.15
"""Windows at rest that show its noise, our choice, not swept. Median change of the force in a
window, up to which a sensor rests; and of the rates at rest, beyond which they are not in
rad/s: three times the 0.05 of all but two of 152 gyroscopes of real recordings. Of 194
simulated parts in deg/s 187 are told with their rows (152 without it), and 20 of 1008
recordings with noise in one half are (76 without it; seeds from 911,000 on)."""


class UnitChange(NamedTuple):
    """Parts of a recording in which one half of a sensor is in another unit.

    Parameters
    ----------
    spans_s : pairs of start and stop, s, one for each part, to a hundredth of a second or two
    sentence : for the user
    half : "acc" or "gyr"
    flags : (n,) bool array, the samples of the parts
    factor : that they are to be multiplied by
    """

    spans_s: tuple[tuple[float, float], ...]
    sentence: str
    half: str
    flags: NDArray[np.bool_]
    factor: float


class _Part(NamedTuple):
    """Samples from start to stop, larger (+1) or smaller (-1) by the ratio of the units."""

    start: int
    stop: int
    sign: int


class _Half(NamedTuple):
    """One half of a sensor, and by how much it may be off, in logarithms of the ratio.

    Parameters
    ----------
    values : (n, 3) array
    size : (n,) array, logarithm of what a unit multiplies: length, or size of the changes
    shaking : (n,) array, logarithm of the changes of the other half; or constant
    width : samples of a window
    ratio : logarithm of the ratio of the units
    off : of an edge's step, and of a single window
    off_mean : of the whole part
    off_edge : of the mean readings on both sides of an edge
    sharp : part of the step that comes from one sample to the next
    turning : (n,) array, logarithm of the mean rate over that of its changes; None of a force
    """

    values: FloatArray
    size: FloatArray
    shaking: FloatArray
    width: int
    ratio: float
    off: tuple[float, float]
    off_mean: float
    off_edge: float
    sharp: float
    turning: FloatArray | None = None


def find_unit_change(recording: Recording, name: str = "frame") -> UnitChange | None:
    """Where the unit of an accelerometer, or of a gyroscope, changes within a recording.

    Parts of 0.1 s and longer are looked for (of 5 samples, below 50 Hz). A part at rest in which
    all readings repeat themselves shows no unit; one whose noise alone is as many times larger, or
    smaller, as the units' ratio is taken for one.

    Parameters
    ----------
    recording : Recording
    name : of the sensor

    Returns
    -------
    UnitChange of the first half that has one, None if none is found

    Raises
    ------
    InputError
        If an argument is of another kind, or there is no such sensor.
    """
    expect("recording", recording, Recording)
    expect("name", name, str)
    imu = recording.sensor(name)
    width = max(FEWEST_IN_WINDOW, round(WINDOW_S * recording.sampling_rate_hz))
    if len(imu) < 3 * width:
        return None
    half = _accelerometer(imu.acc_mps2, width)
    large, small = _parts(half)
    if large:
        off = [abs(_level(half, each) - np.log(STANDARD_GRAVITY_MPS2)) for each in (large, small)]
        return _stated(recording, name, "acc", large if off[0] > off[1] else small)
    if imu.gyr_radps is None:
        return None
    large, small = _parts(_gyroscope(imu.gyr_radps, imu.acc_mps2, width))
    wrong = _wrong_rates(recording, name, width, large, small) if large else None
    return None if wrong is None else _stated(recording, name, "gyr", wrong)


def _accelerometer(acc_mps2: FloatArray, width: int) -> _Half:
    size = np.log(np.maximum(_lengths(acc_mps2), SMALLEST))
    ratio = float(np.log(UNITS["acc"]))
    return _Half(acc_mps2, size, np.zeros(len(size)), width, ratio, OFF_ACC, *MEAN_OFF_ACC)


def _gyroscope(gyr_radps: FloatArray, acc_mps2: FloatArray, width: int) -> _Half:
    shaking = _changing(acc_mps2)
    # Of coarse steps the quiet windows say nothing: any may be as quiet as half of them are.
    shaking = np.log(np.maximum(shaking, max(LEAST_SHAKING_MPS2, float(np.median(shaking)))))
    size = np.log(np.maximum(_changing(gyr_radps), SMALLEST))
    ratio = float(np.log(UNITS["gyr"]))
    mean = ndimage.uniform_filter1d(gyr_radps, width, axis=0)
    turning = np.log(np.maximum(_lengths(mean), SMALLEST)) - size
    return _Half(gyr_radps, size, shaking, width, ratio, OFF_GYR, *MEAN_OFF_GYR, turning)


def _changing(values: FloatArray) -> FloatArray:
    """Sizes of the second differences, (n,): of noise and of jolts, not of a smooth turn."""
    size = _lengths(np.diff(values, 2, axis=0))
    return np.asarray(np.r_[size[:1], size, size[-1:]])


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of vectors (n, 3); numpy's own function takes three times as long."""
    x, y, z = vectors.T
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _parts(half: _Half) -> tuple[list[_Part], list[_Part]]:
    """Parts that are larger than the others by the ratio, and these; none if it is one unit."""
    edges, count = _edges(half), len(half.size)
    pairs = [
        _Part(start, stop, up or -down)
        for k, (start, up) in enumerate([(0, 0), *edges])
        for stop, down in [*edges[k : k + MOST_EDGES], (count, 0)]
        if up != down and up * down <= 0 and stop - start >= half.width - GUARD
    ]
    # An edge at which a move begins may be none; of the others, the nearest belong together.
    apart = {part: off for part in pairs if (off := _apart(half, part)) < np.inf}
    if not apart:
        return [], []
    windows = _windows(half)
    found: dict[int, list[_Part]] = {1: [], -1: []}
    for part in sorted(apart, key=lambda part: (apart[part] > CLEARLY_OFF, _samples(part))):
        mine = found[part.sign]
        if any(part.start < other.stop and other.start < part.stop for other in mine):
            continue
        if _is_off(half, windows, part, [part]):
            mine.append(part)
    best: tuple[list[_Part], list[_Part]] = ([], [])
    for sign, parts in found.items():
        both = sorted(parts), _others(sorted(parts), count, -sign)
        # What is more is what the other is held against.
        less, more = sorted(both, key=_samples)
        sure = all(
            _apart(half, part) < np.inf and _is_off(half, windows, part, less) for part in less
        )
        if sure and parts and len(less) + len(more) > len(best[0]) + len(best[1]):
            best = (both[0], both[1]) if sign > 0 else (both[1], both[0])
    return best


def _others(parts: list[_Part], count: int, sign: int) -> list[_Part]:
    """What lies between, before and after some parts."""
    edges = [0, *(edge for part in parts for edge in part[:2]), count]
    between = zip(edges[::2], edges[1::2], strict=True)
    return [_Part(*each, sign) for each in between if each[0] < each[1]]


def _samples(parts: _Part | list[_Part]) -> int:
    parts = [parts] if isinstance(parts, _Part) else parts
    return sum(part.stop - part.start for part in parts)


def _edges(half: _Half) -> list[tuple[int, int]]:
    """Samples at which the sizes step by the ratio of the units, up (+1) or down (-1)."""
    step = _steps(half.size, half.width)
    found = []
    for sign in (1, -1):
        for run in runs_of(np.abs(sign * step - half.ratio) < half.off[0]):
            most = np.flatnonzero(sign * step[run] == (sign * step[run]).max())
            k = run.start + int(most[len(most) // 2])
            found.append((_sharpened(half.size, k, half.width), sign))
    return sorted(found)


def _steps(sizes: FloatArray, width: int) -> FloatArray:
    """Median of the window that begins at each sample less that of the window before it."""
    median = ndimage.median_filter(sizes, width, mode="nearest")
    step, middle = np.zeros(len(sizes)), width // 2
    at = np.arange(width, len(sizes) - width + 1)
    step[at] = median[np.minimum(at + middle, len(sizes) - 1)] - median[at - width + middle]
    return step


def _sharpened(sizes: FloatArray, near: int, width: int) -> int:
    """Where normal numbers of some sizes become larger or smaller, half a window off at most."""
    reach = width // 2 + 1
    first = max(0, near - width - reach // 2)
    squares = np.cumsum(np.exp(2 * sizes[first : near + width + reach // 2]))
    count, rest = np.arange(1, len(squares)), np.arange(len(squares) - 1, 0, -1)
    before, after = squares[:-1], squares[-1] - squares[:-1]
    unlikely = count * np.log(np.maximum(before, SMALLEST**2) / count)
    unlikely += rest * np.log(np.maximum(after, SMALLEST**2) / rest)
    close = np.abs(first + count - near) <= reach
    return int((first + count)[close][np.argmin(unlikely[close])])


def _apart(half: _Half, part: _Part) -> float:
    """How far the means beside the edges are from being the same but for the unit, as a logarithm.

    Infinite if they are not: with noise that is added they stay. An edge at which a move begins
    says nothing of it; then the moves on both sides are compared.
    """
    if half.turning is not None and _jumps(half, part):
        return np.inf
    width = max(3, min(half.width, part.stop - part.start - 2 * GUARD))
    off = []
    for edge, sign in ((part.start, part.sign), (part.stop, -part.sign)):
        if edge - GUARD < width or edge + GUARD + width > len(half.values):
            continue
        means = (
            half.values[edge - GUARD - width : edge - GUARD].mean(axis=0),
            half.values[edge + GUARD : edge + GUARD + width].mean(axis=0),
        )
        before, after = (np.log(max(float(np.linalg.norm(each)), SMALLEST)) for each in means)
        off.append(abs(sign * (after - before) - half.ratio))
        beside = half.size[edge - GUARD : edge + GUARD]
        if np.abs(np.diff(beside)).max() < half.sharp * half.ratio:
            return np.inf
    if not off or min(off) < half.off_edge:
        return max(off, default=0.0)
    if half.turning is None or part.stop - part.start < HOLDS_MOVES * half.width:
        return np.inf
    first = max(0, part.start - MOST_BESIDE_WINDOWS * half.width)
    near = half.turning[first : part.stop + MOST_BESIDE_WINDOWS * half.width : half.width]
    inside = np.zeros(len(near), np.bool_)
    inside[(part.start - first) // half.width : (part.stop - first) // half.width] = True
    mine, others = (np.quantile(near[each], MOVES) for each in (inside, ~inside))
    return max(off) if abs(mine - others) < SAME_MOVES else np.inf


def _jumps(half: _Half, part: _Part) -> bool:
    """Whether converted rates of a part jump at an edge, where those that were read do not."""
    factor = float(np.exp(-part.sign * half.ratio))
    for edge, units in ((part.start, (1.0, factor)), (part.stop, (factor, 1.0))):
        if edge < 2 * GUARD or edge + 2 * GUARD > len(half.values):
            continue
        before = half.values[edge - 2 * GUARD : edge - GUARD].mean(axis=0)
        after = half.values[edge + GUARD : edge + 2 * GUARD].mean(axis=0)
        read = _difference(before, after)
        if _difference(before * units[0], after * units[1]) > JUMP_TIMES * read:
            return True
    return False


def _difference(one: FloatArray, other: FloatArray) -> float:
    """Length of the difference over that of the longer vector, 0 to 2."""
    longer = max(float(np.linalg.norm(one)), float(np.linalg.norm(other)), SMALLEST)
    return float(np.linalg.norm(other - one)) / longer


class _Windows(NamedTuple):
    """Windows side by side: their first samples, sizes, and how much the other half shakes.

    The size is not a number where readings repeat themselves.
    """

    start: NDArray[np.int64]
    size: FloatArray
    kind: NDArray[np.int64]


def _windows(half: _Half) -> _Windows:
    count = len(half.size) // half.width

    def medians(values: FloatArray) -> FloatArray:
        whole = values[: count * half.width].reshape(count, half.width)
        return np.asarray(np.median(whole, axis=1))

    kind = np.round(medians(half.shaking - half.shaking.min()) / ALIKE).astype(int)
    none = half.size[: count * half.width].reshape(count, half.width) <= np.log(SMALLEST)
    size = np.where(none.mean(axis=1) > MOST_REPEATED, np.nan, medians(half.size))
    return _Windows(np.arange(count) * half.width, size, kind)


def _is_off(half: _Half, windows: _Windows, part: _Part, parts: list[_Part]) -> bool:
    """Whether a part is off by the ratio from windows that shake alike and are of none of some."""
    near = slice(
        max(0, part.start // half.width - MOST_BESIDE_WINDOWS),
        part.stop // half.width + MOST_BESIDE_WINDOWS,
    )
    windows = _Windows(windows.start[near], windows.size[near], windows.kind[near])
    stops = windows.start + half.width
    outside = np.isfinite(windows.size)
    for each in parts:
        outside &= (stops <= each.start) | (windows.start >= each.stop)
    if not outside.any():
        return False
    inside = (windows.start >= part.start) & (stops <= part.stop)
    size, kind = windows.size[inside], windows.kind[inside]
    if not inside.any():
        size = np.array([np.median(half.size[part.start : part.stop])])
        kind = windows.kind[[np.searchsorted(stops[:-1], part.start)]]
    kinds = np.unique(windows.kind[outside])
    usual = [np.median(windows.size[outside & (windows.kind == each)]) for each in kinds]
    off = part.sign * (size - np.interp(kind, kinds, usual)) - half.ratio
    alike = float(np.mean(np.abs(off) < half.off[1]))  # not where it is not a number
    if alike <= MOST_ALIKE or abs(np.nanmedian(off)) >= half.off_mean:
        return False
    # Noise is as large where the sensor shakes as elsewhere; a unit leaves the ratio.
    loud = off[(kind > kind.min()) & (kind >= np.quantile(kind, MOST_ALIKE))]
    return len(loud) < FEWEST_LOUD or bool(abs(np.nanmedian(loud)) < half.off[1] * LOUD_OFF)


def _wrong_rates(
    recording: Recording, name: str, width: int, large: list[_Part], small: list[_Part]
) -> list[_Part] | None:
    """Those parts whose rates are not in rad/s, as far as they show it; else the fewer.

    Rates that are too large tell turns of gravity that are not felt, or are noise at rest that no
    gyroscope has; too small ones tell none in moves. None if noise was added: they are noise, and
    their moves are in rad/s.
    """
    told, felt, rate = _turns(recording, name, width, large)
    if ((told > LEAST_TURN_MPS2) & (told > TIMES_FELT * felt)).sum() > UNSEEN * len(told):
        return large
    large_move = (felt > MOVES_MPS2).any() and rate.max() < UNITS["gyr"] * MOVES_RADPS
    _, felt, rate = _turns(recording, name, width, small)
    small_rest = (felt > MOVES_MPS2).any() and rate.max() < MOVES_RADPS
    if _noise(recording, name, width, large) > NOISIEST_RADPS:
        return None if large_move or small_rest else large
    return small if small_rest else min(large, small, key=_samples)


def _noise(recording: Recording, name: str, width: int, parts: list[_Part]) -> float:
    """Median change of some parts' rates at rest, rad/s; 0 if they hardly rest."""
    shaking = ndimage.median_filter(_changing(recording.sensor(name).acc_mps2), width)
    changes = _changing(recording.gyroscope(name))
    rest = np.zeros(len(changes), np.bool_)
    for part in parts:
        rest[part.start : part.stop] = shaking[part.start : part.stop] < QUIET_MPS2
    return float(np.median(changes[rest])) if rest.sum() >= FEWEST_QUIET * width else 0.0


def _turns(
    recording: Recording, name: str, width: int, parts: list[_Part]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Change of gravity in each window of some parts, told and felt, m/s²; mean rate, rad/s."""
    acc, gyr = recording.sensor(name).acc_mps2, recording.gyroscope(name)
    rows = []
    for part in parts:
        count = (part.stop - part.start) // width
        force, rate = (
            values[part.start : part.start + count * width].reshape(count, width, 3).mean(axis=1)
            for values in (acc, gyr)
        )
        told = np.cross(rate, force) * width / recording.sampling_rate_hz
        felt = np.diff(force, axis=0, append=force[-1:])
        rows.append([np.linalg.norm(each, axis=1) for each in (told, felt, rate)])
    told, felt, rate = (np.concatenate(each) for each in zip(*rows, strict=True))
    return told, felt, rate


def _level(half: _Half, parts: list[_Part]) -> float:
    """Median size over some parts, as a logarithm."""
    return float(np.median(np.concatenate([half.size[p.start : p.stop] for p in parts])))


WORDS = {
    ("acc", 1): ("9.8 times more", "was it converted from g twice"),
    ("acc", -1): ("9.8 times less", "is it in g"),
    ("gyr", 1): ("57 times more", "is it in deg/s"),
    ("gyr", -1): ("57 times less", "was it converted from deg/s twice"),
}
"""How much more, or less, a half reads, and in which unit it may be."""
UNITS = {"acc": STANDARD_GRAVITY_MPS2, "gyr": float(np.rad2deg(1.0))}
"""Ratio of the units of each half: m/s² in a g, deg in a rad."""


def _stated(recording: Recording, name: str, half: str, parts: list[_Part]) -> UnitChange:
    time_s, sign = recording.time_s, parts[0].sign
    flags = np.zeros(len(time_s), np.bool_)
    for part in parts:
        flags[part.start : part.stop] = True
    spans = tuple(
        (float(time_s[part.start]), float(time_s[min(part.stop, len(time_s) - 1)]))
        for part in parts
    )
    times = " and from ".join(f"{start:.2f} to {stop:.2f} s" for start, stop in spans)
    size, unit = WORDS[half, sign]
    sentence = (
        f"{recording.source}: {name}_{half} reads about {size} from {times} than elsewhere: {unit} "
        "there? Convert these rows"
    )
    return UnitChange(spans, sentence, half, flags, UNITS[half] ** -sign)
