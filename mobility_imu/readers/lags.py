"""Lag and drift between clocks, from the movement that sensors on one device share.

What the sensors tell about each other (:mod:`~mobility_imu.readers.shared_movement`) is most when
their clocks are in step: the maximum gives lags and drifts. Their standard deviations are those of
the jackknife: the maximum is found anew with each of up to twenty parts of the recording left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.shared_movement import (
    GRID_HZ,
    NOISE,
    SAY_SAME,
    SHORTEST_S,
    Signals,
    at_all_shifts,
    band_edges,
    band_signals,
    check_stream,
    independent_samples,
    least_shared,
    odds_without_each,
    pooled,
    sums_in_parts,
)
from mobility_imu.readers.streams import Stream
from mobility_imu.readers.wording import listed
from mobility_imu.results import Result

FIRST_LOOK_S = 120.0
"""Length in which the lag is looked for first. A drift of 100 ppm moves its ends by 6 ms."""
UNKNOWN_DRIFT = 1e-4
"""Standard deviation of the drift of any two crystals, twice what their data sheets allow. Where
the movement shows a drift less well than this, it is taken for none."""
MOST_PARTS, SHORTEST_PART_S = 20, 2.0
"""Parts of the jackknife: many enough for a standard deviation, longer than one movement."""
CLEAR_ODDS = float(np.log(1000.0))
"""Logarithm of the odds for the best lag against any other: a thousand to one, set by hand."""
CLEAR_SPREAD = 2.0
"""Standard deviations (jackknife) by which it must be better, so that no single moment decides."""
PEAK_S = 0.3
"""A first look takes lags nearer than this for one peak; peaks in it are then told apart."""
FINE_S = 0.01
"""Steps in which peaks beside the best one are looked for."""
NEAR_S = 0.15
"""Two looks at one clock must find the same lag to this."""
MOST_GUESSES = 6
"""Peaks of a pair of clocks that are tried when there are more than two."""
LARGEST_LAG_SD_S = 0.05
"""With a lag that is known less well, a lever that turns at 1 rad/s may be 3 deg elsewhere."""
STEP_S = 1e-4
"""For differences of the total correlation, which is a sharp peak where sensors agree well."""
FIRST_STEP_S, LAST_STEP_S = 0.03, 1e-5
"""First and last steps of the search for the largest total correlation."""
MOST_CLOCKS = 5
"""One more than a device and a reference have; each doubles the ways in which they are divided."""
MOST_SAMPLES = 24_000
"""Samples that are looked at once the lag is nearly known, 20 minutes at 20 Hz; of a
longer recording fewer a second."""


@dataclass(frozen=True, eq=False, repr=False)
class ClockLag(Result):
    """How the stamps of one clock lie to those of another.

    Parameters
    ----------
    lag_s : s, positive if its stamps are later than the other clock's, at ``at_s``
    lag_sd_s : s, standard deviation of it
    drift : rate of the clock over the other's, less 1; positive if it is fast
    drift_sd : standard deviation of it
    at_s : s, on the other clock, middle of the time that both share
    """

    lag_s: float
    lag_sd_s: float
    drift: float
    drift_sd: float
    at_s: float

    def stamps(self, time_s: FloatArray) -> FloatArray:
        """What this clock shows at times of the other.

        Parameters
        ----------
        time_s : (n,) array, s, on the other clock

        Returns
        -------
        (n,) array, s
        """
        return np.asarray(time_s + self.lag_s + self.drift * (time_s - self.at_s))

    def times(self, stamps_s: FloatArray) -> FloatArray:
        """Times on the other clock of this clock's stamps.

        Parameters
        ----------
        stamps_s : (n,) array, s, on this clock

        Returns
        -------
        (n,) array, s
        """
        here = self.at_s + self.lag_s
        return np.asarray(self.at_s + (stamps_s - here) / (1 + self.drift))


class Look(NamedTuple):
    """What two bunches of clocks share at any lag between them.

    Parameters
    ----------
    shared : (bands, k) array, nats per independent sample
    weight : (bands, k) array, independent samples
    shift : (k,) array, begin of the second signals in the first, samples
    lag_s : (k,) array, s
    middle_s : s, on the second clock
    one, two : (bands, n, channels) arrays, of both
    width_hz : (bands,) array, Hz, width of each band
    """

    shared: FloatArray
    weight: FloatArray
    shift: FloatArray
    lag_s: FloatArray
    middle_s: float
    one: FloatArray
    two: FloatArray
    width_hz: FloatArray

    @property
    def odds(self) -> FloatArray:
        """Logarithm of the odds that speak for each lag."""
        return np.asarray((self.weight * self.shared).sum(axis=0))

    def behind(self, best: int) -> FloatArray:
        """By how much each lag is worse than the best one, with as many samples."""
        weight = np.minimum(self.weight, self.weight[:, [best]])
        return np.asarray((weight * (self.shared[:, [best]] - self.shared)).sum(axis=0))


SAME = ClockLag(0.0, 0.0, 0.0, 0.0, 0.0)
Clocked = tuple[Signals, ClockLag]


def find_lags(
    streams: Mapping[str, Stream], clocks: Sequence[Sequence[str]], source: str
) -> list[ClockLag]:
    """Lag and drift of each clock against the first, from the movement that the sensors share.

    Parameters
    ----------
    streams : sensor name to what it gave
    clocks : names of the sensors on each clock
    source : the first words of a message

    Returns
    -------
    list of ClockLag, one for each clock; the first one's is zero

    Raises
    ------
    InputError
        If a lag is not clear: too little movement that the sensors share, or such as repeats.
    """
    if len(clocks) > MOST_CLOCKS:
        raise InputError(
            f"{source}: {len(clocks)} clocks, expected at most {MOST_CLOCKS}; {SAY_SAME}"
        )
    kind = "gyr" if all(s.gyr_radps is not None for s in streams.values()) else "acc"
    for name, stream in streams.items():
        check_stream(stream, f"{source}, {name}")
    edges = band_edges(streams)
    signals = [band_signals([streams[name] for name in names], kind, edges) for names in clocks]
    guess = _best_guess(signals, kind)
    if guess is None:
        raise InputError(_unclear(source, *clocks))
    fitted = _fit(_of(guess, signals), guess[next(reversed(guess))].at_s, kind)
    if fitted is None or max(one.lag_sd_s for one in fitted) > LARGEST_LAG_SD_S:
        raise InputError(_unclear(source, *clocks))
    found = dict(zip(guess, fitted, strict=True))
    # However the clocks are divided in two, one half must be clear against the other.
    for count in range(1, len(clocks)):
        for half in combinations(range(1, len(clocks)), count):
            if not _is_clear(found, half, signals, kind):
                others = [k for k in range(len(clocks)) if k not in half]
                sides = ([name for k in side for name in clocks[k]] for side in (half, others))
                raise InputError(_unclear(source, *sides))
    return [found[k] for k in range(len(clocks))]


def _of(bunch: Mapping[int, ClockLag], signals: Sequence[Signals]) -> list[Clocked]:
    return [(signals[k], lag) for k, lag in bunch.items()]


def _best_guess(signals: Sequence[Signals], kind: str) -> dict[int, ClockLag] | None:
    """Lags of all clocks to the first one, as a first look at pairs of them shows; None without."""
    guesses = []
    for k, j in combinations(range(len(signals)), 2):
        looks = _look([(signals[k], SAME)], [(signals[j], SAME)], kind)
        guesses += [({k: SAME, j: lag}, odds) for lag, odds in _peaks(looks)]
    while guesses and len(guesses[0][0]) < len(signals):
        guesses = sorted(guesses, key=lambda guess: -guess[1])[: 2 * MOST_GUESSES]
        longer = []
        for bunch, odds in guesses:
            for k in set(range(len(signals))) - set(bunch):
                looks = _look(_of(bunch, signals), [(signals[k], SAME)], kind)
                longer += [(bunch | {k: lag}, odds + more) for lag, more in _peaks(looks)[:1]]
        guesses = longer
    if not guesses:
        return None
    best = max(guesses, key=lambda guess: guess[1])[0]
    return {k: _against(best[k], best[0]) for k in (0, *(k for k in best if k))}


def _against(lag: ClockLag, other: ClockLag) -> ClockLag:
    """Lag of a clock against a second one, both known against a third."""
    at = other.stamps(np.array([lag.at_s, lag.at_s + 1.0]))
    first, second = lag.stamps(other.times(at)) - at
    return ClockLag(float(first), 0.0, float(second - first), 0.0, float(at[0]))


def _unclear(source: str, *sides: Sequence[str]) -> str:
    """Message that names all sides: which of them has the other movement is not known."""
    clocks = " and of ".join(listed(names) for names in sides)
    return (
        f"{source}: the clocks of {clocks} are their own, and the movement does not show clearly "
        "how they lie to each other; record ten seconds of quick, irregular movement, or "
        f"{SAY_SAME}"
    )


def _look(first: Sequence[Clocked], second: Sequence[Clocked], kind: str) -> Look | None:
    """What two bunches of clocks share at any lag between them; None if one is too short."""
    (time_s, one), (there, two) = _on_grid(first), _on_grid(second)
    if min(len(time_s), len(there)) < SHORTEST_S * GRID_HZ:
        return None
    most = int(FIRST_LOOK_S * GRID_HZ)
    if len(there) > most:  # where it moves most
        energy = np.cumsum(np.r_[0.0, (two**2).sum(axis=(0, 2))])
        k = int(np.argmax(energy[most:] - energy[:-most]))
        there, two = there[k : k + most], two[:, k : k + most]
    width_hz = first[0][0].width_hz
    least = least_shared(min(len(time_s), len(there)) / GRID_HZ) * GRID_HZ
    shared, weight = [], []
    for own, other, width in zip(one, two, width_hz, strict=True):
        nats, count, shift = at_all_shifts(own, other, NOISE[kind], least)
        shared.append(nats)
        weight.append(independent_samples(count, width, own.shape[1] + other.shape[1]))
    lag_s = there[0] - time_s[0] - shift / GRID_HZ
    return Look(
        np.array(shared), np.array(weight), shift, lag_s, float(there.mean()), one, two, width_hz
    )


def _peaks(look: Look | None) -> list[tuple[ClockLag, float]]:
    """Lags at the highest peaks, the highest first, and the odds that speak for each."""
    found: list[tuple[ClockLag, float]] = []
    if look is None:
        return found
    left = np.array(look.odds)
    while len(found) < MOST_GUESSES and np.isfinite(left).any():
        k = int(np.argmax(left))
        lag = float(look.lag_s[k])
        found.append((ClockLag(lag, 0.0, 0.0, 0.0, look.middle_s - lag), float(left[k])))
        left[_peak_of(look.odds, k)] = -np.inf
    return found


def _peak_of(odds: FloatArray, k: int) -> slice:
    """Lags that belong to a peak: down its slopes, and those near it."""
    begin = end = k
    while begin > 0 and odds[begin - 1] < odds[begin]:
        begin -= 1
    while end < len(odds) - 1 and odds[end + 1] < odds[end]:
        end += 1
    near = int(PEAK_S * GRID_HZ)
    return slice(max(0, min(begin, k - near)), max(end, k + near) + 1)


def _is_clear(
    found: Mapping[int, ClockLag], half: Sequence[int], signals: Sequence[Signals], kind: str
) -> bool:
    """Whether the lag of some clocks to the others is better than any other, by odds and spread."""
    others = _of({k: lag for k, lag in found.items() if k not in half}, signals)
    first = half[0]
    own = [(signals[k], _against(found[k], found[first])) for k in half]
    look = _look(others, own, kind)
    if look is None or not _is_clear_nearby(
        others, _of({k: found[k] for k in half}, signals), kind
    ):
        return False
    best = int(np.argmax(look.odds))
    middle = look.middle_s - look.lag_s[best]
    expected = float(found[first].stamps(np.array(middle)) - middle)
    behind = look.behind(best)
    behind[_peak_of(look.odds, best)] = np.inf
    other = int(np.argmin(behind))
    return bool(
        np.isfinite(behind[other])
        and abs(look.lag_s[best] - expected) <= NEAR_S
        and behind[other] > CLEAR_ODDS
        and _spread(look, best, other, NOISE[kind]) > CLEAR_SPREAD
    )


def _is_clear_nearby(first: Sequence[Clocked], second: Sequence[Clocked], kind: str) -> bool:
    """Whether no peak beside the found one, closer than a first look shows, is nearly as high."""
    begin, end = _shared([*first, *second])
    edge = PEAK_S + 1 / GRID_HZ
    time_s = np.arange(begin + edge, end - edge, 1 / GRID_HZ)
    one = np.concatenate([s.at(lag.stamps(time_s)) for s, lag in first], axis=2)
    sizes, odds = (one.shape[2], sum(s.channels for s, _ in second)), []
    together, width_hz = [], first[0][0].width_hz
    for step in np.arange(-PEAK_S, PEAK_S + FINE_S / 2, FINE_S):
        two = [signal.at(lag.stamps(time_s + step)) for signal, lag in second]
        sums = sums_in_parts(np.concatenate([one, *two], axis=2), 1)
        odds.append(float(odds_without_each(sums, sizes, NOISE[kind], width_hz)[0]))
        whole = np.array([width_hz.sum()])
        together.append(float(odds_without_each(pooled(sums), sizes, NOISE[kind], whole)[0]))
    middle = begin_of = end_of = len(odds) // 2
    while begin_of > 0 and odds[begin_of - 1] < odds[begin_of]:
        begin_of -= 1
    while end_of < len(odds) - 1 and odds[end_of + 1] < odds[end_of]:
        end_of += 1
    # Bands that may each have a relation of their own agree more easily than by one relation.
    return all(
        curve[middle] - max([*curve[:begin_of], *curve[end_of + 1 :]], default=-np.inf) > CLEAR_ODDS
        for curve in (odds, together)
    )


def _on_grid(clocked: Sequence[Clocked]) -> tuple[FloatArray, FloatArray]:
    """Times on the first of some clocks, and the channels of all of them."""
    time_s = np.arange(*_shared(clocked), 1 / GRID_HZ)
    return time_s, np.concatenate([s.at(lag.stamps(time_s)) for s, lag in clocked], axis=2)


def _spread(look: Look, best: int, other: int, noise: float) -> float:
    """By how many standard deviations (jackknife) the best lag is better than another."""
    one, two = look.one, look.two
    weight = np.minimum(look.weight[:, best], look.weight[:, other])
    parts = _parts(two.shape[1] / GRID_HZ)
    each = []
    for shift in look.shift[[best, other]].astype(int):
        here = np.arange(two.shape[1]) + shift
        inside = (here >= 0) & (here < one.shape[1])
        both = np.concatenate([one[:, np.clip(here, 0, one.shape[1] - 1)], two], axis=2)
        sums = sums_in_parts(both, parts, inside)
        each.append(
            odds_without_each(sums, (one.shape[2], two.shape[2]), noise, look.width_hz, weight)
        )
    better = each[0] - each[1]
    spread = np.sqrt((parts - 1) * np.mean((better[1:] - better[1:].mean()) ** 2))
    return float(better[0] / spread) if spread > 0 else 0.0


def _fit(clocked: Sequence[Clocked], middle_s: float, kind: str) -> list[ClockLag] | None:
    """Lags and drifts at the largest total correlation; None if there is no maximum."""
    half = FIRST_LOOK_S / 2
    while True:
        begin, end = _shared(clocked)
        window = max(begin, middle_s - half), min(end, middle_s + half)
        fitted = _fit_window(clocked, window, kind, drift=True)
        if fitted is None or max(lag.drift_sd for lag in fitted) > UNKNOWN_DRIFT:
            fitted = _fit_window(clocked, window, kind, drift=False)
        if fitted is None or (window[0] <= begin and window[1] >= end):
            return fitted
        clocked = [(signal, lag) for (signal, _), lag in zip(clocked, fitted, strict=True)]
        half *= 2


def _fit_window(
    clocked: Sequence[Clocked], window: tuple[float, float], kind: str, *, drift: bool
) -> list[ClockLag] | None:
    """Lags and drifts in a window of time; None if there is no maximum."""
    middle, half = (window[0] + window[1]) / 2, (window[1] - window[0]) / 2
    if 2 * half < SHORTEST_S:
        return None
    time_s = np.arange(window[0], window[1], max(1 / GRID_HZ, 2 * half / MOST_SAMPLES))
    parts, len_grid = _parts(2 * half), 2 * half * GRID_HZ
    each = 2 if drift else 1  # lag in the middle, and what drift adds at the end
    signals = [signal for signal, _ in clocked]
    given = [
        [float(lag.stamps(np.array(middle)) - middle), lag.drift * half] for _, lag in clocked[1:]
    ]
    values = np.array([pair[:each] for pair in given]).ravel()
    sizes = tuple(s.channels for s in signals)

    first = signals[0].at(time_s)

    @lru_cache(maxsize=len(signals))  # most steps move one clock
    def moved(k: int, *pair: float) -> FloatArray:
        stamps = time_s + pair[0]
        if drift:
            stamps = stamps + pair[1] * (time_s - middle) / half
        return signals[k].at(np.clip(stamps, signals[k].begin_s, signals[k].end_s))

    def gain(at: FloatArray) -> FloatArray:
        pairs = enumerate(at.reshape(-1, each).tolist(), start=1)
        channels = [first, *(moved(k, *pair) for k, pair in pairs)]
        sums = sums_in_parts(np.concatenate(channels, axis=2), parts) * (len_grid / len(time_s))
        return odds_without_each(sums, sizes, NOISE[kind], signals[0].width_hz)

    values = _scanned(gain, values, each)
    corners = np.vstack([values, values + FIRST_STEP_S * np.eye(len(values))])
    best = minimize(
        lambda at: -float(gain(at)[0]),
        values,
        method="Nelder-Mead",
        options={"initial_simplex": corners, "xatol": LAST_STEP_S, "fatol": np.inf, "maxfev": 2000},
    )
    values = best.x
    slope, bend = _derivatives(gain, values)
    if (np.linalg.eigvalsh(-bend) <= 0).any():
        return None
    # One of Newton's steps finds the maximum of what is left when a part is left out.
    without = -np.linalg.solve(bend[1:], slope[1:, :, None])[:, :, 0]
    sd = np.sqrt((parts - 1) * np.mean((without - without.mean(axis=0)) ** 2, axis=0))
    found = [ClockLag(0.0, 0.0, 0.0, 0.0, middle)]
    for pair, pair_sd in zip(values.reshape(-1, each), sd.reshape(-1, each), strict=True):
        rate, rate_sd = (pair[1] / half, pair_sd[1] / half) if drift else (0.0, UNKNOWN_DRIFT)
        found.append(
            ClockLag(float(pair[0]), float(pair_sd[0]), float(rate), float(rate_sd), middle)
        )
    return found


def _scanned(gain: Callable[[FloatArray], FloatArray], at: FloatArray, each: int) -> FloatArray:
    """Lags at the highest of neighbouring peaks, each lag in turn and then all together."""
    steps = np.arange(-PEAK_S, PEAK_S + FIRST_STEP_S / 2, FIRST_STEP_S / 3)
    lags = np.eye(len(at))[::each]  # drifts stay
    together = [lags.sum(axis=0)] if len(lags) > 1 else []
    for move in [*lags, *together, *lags]:
        tried = [at + step * move for step in steps]
        at = tried[int(np.argmax([gain(one)[0] for one in tried]))]
    return at


def _derivatives(
    gain: Callable[[FloatArray], FloatArray], at: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """First and second differences of the total correlation, of all and with a part left out."""
    count = len(at)
    steps = STEP_S * np.eye(count)
    centre = gain(at)
    up = [gain(at + step) for step in steps]
    down = [gain(at - step) for step in steps]
    slope = np.stack([(u - d) / (2 * STEP_S) for u, d in zip(up, down, strict=True)], axis=1)
    bend = np.empty((len(centre), count, count))
    for i in range(count):
        bend[:, i, i] = (up[i] - 2 * centre + down[i]) / STEP_S**2
        for j in range(i + 1, count):
            both = gain(at + steps[i] + steps[j])
            bend[:, i, j] = bend[:, j, i] = (both - up[i] - up[j] + centre) / STEP_S**2
    return slope, bend


def _shared(clocked: Sequence[Clocked]) -> tuple[float, float]:
    """Begin and end, on the first clock, of the time that all clocks have."""
    ends = [lag.times(np.array([signal.begin_s, signal.end_s])) for signal, lag in clocked]
    return max(float(pair[0]) for pair in ends), min(float(pair[1]) for pair in ends)


def _parts(length_s: float) -> int:
    """Parts of the jackknife in a recording of a length."""
    return int(np.clip(length_s / SHORTEST_PART_S, 2, MOST_PARTS))
