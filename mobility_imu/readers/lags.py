"""Lag and drift between clocks, from the movement that sensors on one device share.

Rates of sensors on one device depend on each other: two on a rigid part turn alike, a wheel's rate
follows the frame's, the frame's yaw rate is the difference of both wheels'. How much they have in
common is their total correlation, half the logarithm of (product of the determinants of each
clock's covariance) over (determinant of the covariance of all), for Gaussian signals the
information shared by the clocks. It needs neither mounting nor geometry, and is largest when the
clocks are in step: its maximum gives lags and drifts. Their standard deviations are those of the
jackknife: the maximum is found anew with each of up to twenty parts of the recording left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize
from scipy.signal import butter, sosfiltfilt

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.streams import Stream
from mobility_imu.readers.wording import listed
from mobility_imu.recording import HIGHEST_RATE_HZ, LOWEST_RATE_HZ
from mobility_imu.results import Result

OCTAVES_HZ = (0.3, 0.6, 1.25, 2.5, 5.0)
"""Edges of the bands, in which what sensors share is measured one by one and added up: slow bands
tell turns, quick ones pushes and bumps. Below lies the gyroscope's offset, above vibration, which
differs from place to place."""
FEWEST_PER_CHANNEL = 3.0
"""Independent samples in the lowest band for each channel; with fewer, it is joined to the next."""
GRID_HZ = 20.0
"""Rate at which signals are compared: four times the highest edge."""
LARGEST_BAND_SHARE = 0.35
"""Of a sensor's rate; above, what is sampled too slowly would be taken for movement."""
NOISE = {"gyr": 0.002, "acc": 0.03}
"""rad/s and m/s²: twice a cheap sensor's step (0.06 deg/s), and a third of 0.01 g. Movement below
it says nothing."""
FIRST_LOOK_S = 120.0
"""Length in which the lag is looked for first. A drift of 100 ppm moves its ends by 6 ms."""
SHORTEST_S, SHORTEST_SHARE = 10.0, 0.5
"""Less shared time than this, or than this part of the shorter recording, says nothing."""
UNKNOWN_DRIFT = 1e-4
"""Standard deviation of the drift of any two crystals, twice what their data sheets allow. Where
the movement shows a drift less well than this, it is taken for none."""
MOST_PARTS, SHORTEST_PART_S = 20, 2.0
"""Parts of the jackknife: many enough for a standard deviation, longer than one movement."""
CLEAR_ODDS = float(np.log(1000.0))
"""Logarithm of the odds for the best lag against any other: a thousand to one."""
CLEAR_SPREAD = 2.0
"""Standard deviations (jackknife) by which it must be better, so that no single moment decides."""
PEAK_S = 0.3
"""Lags nearer than this to the best one belong to its peak."""
FINE_S = 0.01
"""Steps in which peaks beside the best one are looked for."""
NEAR_S = 0.15
"""Two looks at one clock must find the same lag to this."""
MOST_GUESSES = 6
"""Peaks of a pair of clocks that are tried when there are more than two."""
LARGEST_LAG_SD_S = 0.05
STEP_S = 1e-4
"""For differences of the total correlation, which is a sharp peak where sensors agree well."""
FIRST_STEP_S, LAST_STEP_S = 0.03, 1e-5
"""First and last steps of the search for the largest total correlation."""
MOST_CLOCKS = 5
LONGEST_S = 8 * 3600.0
"""Of a recording; a longer one is to be cut."""
MOST_SAMPLES = 24_000
"""Samples that are looked at once the lag is nearly known; of a longer recording fewer a second."""
MOST_FILLED = 4.0
"""Times its samples that a sensor could have had in its time; more is a clock that jumps."""
SAY_SAME = "add clock=same if the files share a start or a trigger"


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


class Signals(NamedTuple):
    """Movement of the sensors of one clock, without its slow and fast parts.

    Parameters
    ----------
    begin_s, end_s : s, on their clock, the time that all of them have
    at : (bands, n, channels) array of their movement in each band, at n times in between
    channels : three for each sensor
    width_hz : (bands,) array, Hz, width of each band
    """

    begin_s: float
    end_s: float
    at: Callable[[FloatArray], FloatArray]
    channels: int
    width_hz: FloatArray


class Look(NamedTuple):
    """What two bunches of clocks share at any lag between them.

    Parameters
    ----------
    odds : (k,) array, logarithm of the odds that speak for each lag
    shift : (k,) array, begin of the second signals in the first, samples
    lag_s : (k,) array, s
    middle_s : s, on the second clock
    one, two : (bands, n, channels) arrays, of both
    width_hz : (bands,) array, Hz, width of each band
    """

    odds: FloatArray
    shift: FloatArray
    lag_s: FloatArray
    middle_s: float
    one: FloatArray
    two: FloatArray
    width_hz: FloatArray


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
        _check(stream, f"{source}, {name}")
    edges = _edges(streams)
    signals = [_signals([streams[name] for name in names], kind, edges) for names in clocks]
    guess = _best_guess(signals, kind)
    if guess is None:
        raise InputError(_unclear(source, clocks[-1]))
    fitted = _fit(_of(guess, signals), guess[next(reversed(guess))].at_s, kind)
    if fitted is None or max(one.lag_sd_s for one in fitted) > LARGEST_LAG_SD_S:
        raise InputError(_unclear(source, clocks[-1]))
    found = dict(zip(guess, fitted, strict=True))
    # However the clocks are divided in two, one half must be clear against the other.
    for count in range(1, len(clocks)):
        for half in combinations(range(1, len(clocks)), count):
            if not _is_clear(found, half, signals, kind):
                raise InputError(_unclear(source, [name for k in half for name in clocks[k]]))
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


def _unclear(source: str, names: Sequence[str]) -> str:
    return (
        f"{source}: the clock of {listed(names)} is its own, and the movement does not show "
        "clearly how it lies to the others'; record ten seconds of quick, irregular movement, or "
        f"{SAY_SAME}"
    )


def _check(stream: Stream, source: str) -> None:
    """Check that a stream can be compared with others."""
    values = [stream.time_s, stream.acc_mps2]
    values += [] if stream.gyr_radps is None else [stream.gyr_radps]
    bad = ~np.isfinite(np.column_stack(values)).all(axis=1)
    if bad.any():
        raise InputError(f"{source}: not a finite number at row {int(np.argmax(bad)) + 1}")
    length = float(np.ptp(stream.time_s))
    if not SHORTEST_S < length <= LONGEST_S:
        raise InputError(
            f"{source}: a recording of {length:.3g} s, expected {SHORTEST_S:g} to {LONGEST_S:g} s "
            f"to find how its clock lies to the others'; {SAY_SAME}"
        )
    step = _step(stream)
    if length > MOST_FILLED * step * len(stream):
        raise InputError(f"{source}: most of its time has no sample; are the times in s?")
    if not LOWEST_RATE_HZ <= 1 / step <= HIGHEST_RATE_HZ:
        raise InputError(f"{source}: sampling rate of {1 / step:.3g} Hz; are the times in s?")


def _step(stream: Stream) -> float:
    return float(np.median(np.diff(np.unique(stream.time_s))))


def _edges(streams: Mapping[str, Stream]) -> FloatArray:
    """Edges of the bands that all sensors can show, and in which chance has little room."""
    highest = LARGEST_BAND_SHARE / max(_step(stream) for stream in streams.values())
    edges = [edge for edge in OCTAVES_HZ if edge <= highest]
    if len(edges) < 2:
        edges = [OCTAVES_HZ[0], max(highest, 2 * OCTAVES_HZ[0])]
    shared = _least_shared(min(float(np.ptp(stream.time_s)) for stream in streams.values()))
    fewest = FEWEST_PER_CHANNEL * 3 * len(streams)
    while len(edges) > 2 and 2 * (edges[1] - edges[0]) * shared < fewest:
        del edges[1]
    return np.array(edges)


def _least_shared(length_s: float) -> float:
    """Time that two recordings must share at a lag, the shorter of which has a length."""
    return max(SHORTEST_S, SHORTEST_SHARE * length_s)


def _signals(streams: Sequence[Stream], kind: str, edges: FloatArray) -> Signals:
    """Rates, or accelerations, of sensors that share a clock, in bands."""
    curves = []
    for stream in streams:
        stamps, first = np.unique(stream.time_s, return_index=True)
        values = stream.acc_mps2 if stream.gyr_radps is None or kind == "acc" else stream.gyr_radps
        step = _step(stream)
        even = np.arange(stamps[0], stamps[-1], step)
        there = np.column_stack([np.interp(even, stamps, axis) for axis in values[first].T])
        bands = [
            sosfiltfilt(butter(4, band, "bandpass", fs=1 / step, output="sos"), there, axis=0)
            for band in pairwise(edges)
        ]
        curves.append(CubicSpline(even, np.stack(bands, axis=1)))
    return Signals(
        max(float(curve.x[0]) for curve in curves),
        min(float(curve.x[-1]) for curve in curves),
        lambda times: np.concatenate([curve(times) for curve in curves], axis=2).swapaxes(0, 1),
        3 * len(curves),
        np.diff(edges),
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
    least = _least_shared(min(len(time_s), len(there)) / GRID_HZ) * GRID_HZ
    odds: FloatArray = np.zeros(1)
    for own, other, width in zip(one, two, width_hz, strict=True):
        shared, count, shift = _at_all_lags(own, other, NOISE[kind], least)
        odds = odds + _weight(count, width, own.shape[1] + other.shape[1]) * shared
    lag_s = there[0] - time_s[0] - shift / GRID_HZ
    return Look(odds, shift, lag_s, float(there.mean()), one, two, width_hz)


def _weight(samples: FloatArray, width_hz: FloatArray, channels: int) -> FloatArray:
    """Independent samples that a band holds, less Bartlett's correction for their small number."""
    independent = 2 * width_hz * samples / GRID_HZ
    return np.asarray(np.maximum(independent - (channels + 3) / 2, 0.0))


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
    """Lags that belong to a peak: down to half its height, and those near it."""
    begin = end = k
    while begin > 0 and odds[begin] > 0.5 * odds[k]:
        begin -= 1
    while end < len(odds) - 1 and odds[end] > 0.5 * odds[k]:
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
    outside = np.array(look.odds)
    outside[_peak_of(look.odds, best)] = -np.inf
    other = int(np.argmax(outside))
    if not np.isfinite(outside[other]):
        return False
    shifts = int(look.shift[best]), int(look.shift[other])
    return bool(
        abs(look.lag_s[best] - expected) <= NEAR_S
        and look.odds[best] - look.odds[other] > CLEAR_ODDS
        and _spread(look, shifts, NOISE[kind]) > CLEAR_SPREAD
    )


def _is_clear_nearby(first: Sequence[Clocked], second: Sequence[Clocked], kind: str) -> bool:
    """Whether no peak beside the found one, closer than a first look shows, is nearly as high."""
    begin, end = _shared([*first, *second])
    edge = PEAK_S + 1 / GRID_HZ
    time_s = np.arange(begin + edge, end - edge, 1 / GRID_HZ)
    one = np.concatenate([s.at(lag.stamps(time_s)) for s, lag in first], axis=2)
    sizes, odds = (one.shape[2], sum(s.channels for s, _ in second)), []
    for step in np.arange(-PEAK_S, PEAK_S + FINE_S / 2, FINE_S):
        two = [signal.at(lag.stamps(time_s + step)) for signal, lag in second]
        sums = _sums(np.concatenate([one, *two], axis=2), 1)
        odds.append(float(_left_out(sums, sizes, NOISE[kind], first[0][0].width_hz)[0]))
    middle = begin_of = end_of = len(odds) // 2
    while begin_of > 0 and odds[begin_of - 1] < odds[begin_of]:
        begin_of -= 1
    while end_of < len(odds) - 1 and odds[end_of + 1] < odds[end_of]:
        end_of += 1
    beside = [*odds[:begin_of], *odds[end_of + 1 :]]
    return not beside or odds[middle] - max(beside) > CLEAR_ODDS


def _on_grid(clocked: Sequence[Clocked]) -> tuple[FloatArray, FloatArray]:
    """Times on the first of some clocks, and the channels of all of them."""
    time_s = np.arange(*_shared(clocked), 1 / GRID_HZ)
    return time_s, np.concatenate([s.at(lag.stamps(time_s)) for s, lag in clocked], axis=2)


def _at_all_lags(
    one: FloatArray, two: FloatArray, noise: float, least: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Total correlation, samples in common and shift, for each shift of the second signals.

    Shifts are those of the second's begin in the first; with fewer than ``least`` samples in common
    they are left out.
    """
    n, m = len(one), len(two)
    size = 1 << int(np.ceil(np.log2(n + m)))
    p, q = one.shape[1], two.shape[1]

    def spectra(values: FloatArray) -> FloatArray:
        return np.asarray(np.fft.rfft(values, size, axis=0))

    def slid(a: FloatArray, b: FloatArray) -> FloatArray:
        """Sum of a(k + shift) b(k) over k, for shifts from -m + 1 to n - 1."""
        full = np.fft.irfft(a * np.conj(b), size, axis=0)
        return np.concatenate([full[size - m + 1 :], full[:n]])[enough]

    shift = np.arange(-m + 1, n)
    common = np.minimum(np.minimum(shift + m, n - shift), min(n, m))
    enough = common >= least
    ones, twos = np.column_stack([np.ones(n), one]), np.column_stack([np.ones(m), two])
    of_one = [spectra(column) for column in ones.T]
    of_two = [spectra(column) for column in twos.T]
    sums = np.empty((int(enough.sum()), 1 + p + q, 1 + p + q))
    for i in range(1 + p):
        for j in range(i, 1 + p):
            both = slid(spectra(ones[:, i] * ones[:, j]), of_two[0])
            sums[:, i, j] = sums[:, j, i] = both
        for j in range(1, 1 + q):
            both = slid(of_one[i], of_two[j])
            sums[:, i, p + j] = sums[:, p + j, i] = both
    for i in range(1, 1 + q):
        for j in range(i, 1 + q):
            both = slid(of_one[0], spectra(twos[:, i] * twos[:, j]))
            sums[:, p + i, p + j] = sums[:, p + j, p + i] = both
    kept = (np.asarray(values[enough], float) for values in (common, shift))
    return _total_correlation(sums, (p, q), noise), *kept  # type: ignore[return-value]


def _spread(look: Look, shifts: tuple[int, int], noise: float) -> float:
    """By how many standard deviations (jackknife) the first shift is better than the second."""
    one, two = look.one, look.two
    parts = _parts(two.shape[1] / GRID_HZ)
    each = []
    for shift in shifts:
        here = np.arange(two.shape[1]) + shift
        inside = (here >= 0) & (here < one.shape[1])
        both = np.concatenate([one[:, np.clip(here, 0, one.shape[1] - 1)], two], axis=2)
        sums = _sums(both, parts, inside)
        each.append(_left_out(sums, (one.shape[2], two.shape[2]), noise, look.width_hz))
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

    def gain(at: FloatArray) -> FloatArray:
        channels = [signals[0].at(time_s)]
        for signal, pair in zip(signals[1:], at.reshape(-1, each), strict=True):
            stamps = time_s + pair[0]
            if drift:
                stamps = stamps + pair[1] * (time_s - middle) / half
            channels.append(signal.at(np.clip(stamps, signal.begin_s, signal.end_s)))
        sums = _sums(np.concatenate(channels, axis=2), parts) * (len_grid / len(time_s))
        return _left_out(sums, sizes, NOISE[kind], signals[0].width_hz)

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


def _sums(values: FloatArray, parts: int, inside: NDArray[np.bool_] | None = None) -> FloatArray:
    """Sums of all products of 1 and the channels, in each part and band: (parts, bands, ...)."""
    one = np.ones(values.shape[1]) if inside is None else inside.astype(float)
    bands = [np.column_stack([one, band * one[:, None]]) for band in values]
    return np.stack(
        [[part.T @ part for part in np.array_split(band, parts)] for band in bands], axis=1
    )


def _left_out(
    sums: FloatArray, sizes: tuple[int, ...], noise: float, width_hz: FloatArray
) -> FloatArray:
    """Logarithm of the odds from all parts, then from all but each."""
    whole = sums.sum(axis=0)
    kept = np.concatenate([whole[None], whole - sums])
    weight = _weight(kept[:, :, 0, 0], width_hz, sum(sizes))
    return np.asarray((weight * _total_correlation(kept, sizes, noise)).sum(axis=1))


def _total_correlation(sums: FloatArray, sizes: tuple[int, ...], noise: float) -> FloatArray:
    """Information that groups of channels share, in nats per sample, from sums of products.

    Parameters
    ----------
    sums : (..., 1 + c, 1 + c) array: of 1 and c channels, summed over the samples
    sizes : channels of each group
    noise : standard deviation of a sensor's noise, in the channels' unit

    Returns
    -------
    (...) array
    """
    count = np.maximum(sums[..., :1, :1], 1.0)
    mean = sums[..., 0, 1:] / count[..., 0]
    covariance = sums[..., 1:, 1:] / count - mean[..., :, None] * mean[..., None, :]
    covariance = covariance + noise**2 * np.eye(covariance.shape[-1])
    shared = -np.linalg.slogdet(covariance)[1]
    first = 0
    for size in sizes:
        part = slice(first, first + size)
        shared = shared + np.linalg.slogdet(covariance[..., part, part])[1]
        first += size
    return np.asarray(0.5 * shared)
