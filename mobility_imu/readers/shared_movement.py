"""Movement that sensors share: their rates in bands, and how much they tell about each other.

Rates of sensors on one device depend on each other: two on a rigid part turn alike, a wheel's rate
follows the frame's, the frame's yaw rate is the difference of both wheels'. How much they have in
common is their total correlation, half the logarithm of (product of the determinants of each
clock's covariance) over (determinant of the covariance of all): for Gaussian signals the
information shared by the clocks, in nats per independent sample. It needs neither mounting nor
geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.streams import Stream
from mobility_imu.recording import HIGHEST_RATE_HZ, LOWEST_RATE_HZ

OCTAVES_HZ = (0.3, 0.6, 1.25, 2.5, 5.0)
"""Edges of the bands, in which what sensors share is measured one by one and added up: slow bands
tell turns, quick ones pushes and bumps. Below lies the gyroscope's offset, above vibration, which
differs from place to place. Set by hand."""
FEWEST_PER_CHANNEL = 3.0
"""Independent samples in the lowest band for each channel; with fewer, it is joined to the next.
With 1 a covariance is singular; 3 is set by hand."""
GRID_HZ = 4 * OCTAVES_HZ[-1]
"""Rate at which signals are compared: four times the highest edge."""
LARGEST_BAND_SHARE = 0.35
"""Of a sensor's rate; above, what is sampled too slowly would be taken for movement: half the rate,
less the flank of the bands' filter."""
NOISE = {"gyr": 0.002, "acc": 0.03}
"""rad/s and m/s²: twice a cheap sensor's step (0.06 deg/s), and a third of 0.01 g. Movement below
it says nothing."""
SHORTEST_S, SHORTEST_SHARE = 10.0, 0.5
"""Less shared time than this, or than this part of the shorter recording, says nothing: three
periods of the lowest band. The part is set by hand."""
LONGEST_S = 8 * 3600.0
"""Of a recording, a working day; a longer one is to be cut."""
MOST_FILLED = 4.0
"""Times its samples that a sensor could have had in its time; more is a clock that jumps. Set by
hand: a sensor that lost three of four samples."""
SAY_SAME = "add clock=same if the stamps are of one clock, clock=start if the files began together"


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


def check_stream(stream: Stream, source: str) -> None:
    """Check that a stream can be compared with others.

    Parameters
    ----------
    stream : Stream
    source : the first words of a message

    Raises
    ------
    InputError
        A value that is no number, a length or a rate that no recording of a movement has.
    """
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


def band_edges(streams: Mapping[str, Stream]) -> FloatArray:
    """Edges of the bands that all sensors can show, and in which chance has little room.

    Parameters
    ----------
    streams : sensor name to what it gave

    Returns
    -------
    (bands + 1,) array, Hz
    """
    highest = LARGEST_BAND_SHARE / max(_step(stream) for stream in streams.values())
    edges = [edge for edge in OCTAVES_HZ if edge <= highest]
    if len(edges) < 2:
        edges = [OCTAVES_HZ[0], max(highest, 2 * OCTAVES_HZ[0])]
    shared = least_shared(min(float(np.ptp(stream.time_s)) for stream in streams.values()))
    fewest = FEWEST_PER_CHANNEL * 3 * len(streams)
    while len(edges) > 2 and 2 * (edges[1] - edges[0]) * shared < fewest:
        del edges[1]
    return np.array(edges)


def least_shared(length_s: float) -> float:
    """Time that two recordings must share at a lag.

    Parameters
    ----------
    length_s : s, of the shorter recording

    Returns
    -------
    float, s
    """
    return max(SHORTEST_S, SHORTEST_SHARE * length_s)


def band_signals(streams: Sequence[Stream], kind: str, edges: FloatArray) -> Signals:
    """Rates, or accelerations, of sensors that share a clock, in bands.

    Parameters
    ----------
    streams : of the sensors
    kind : "gyr" or "acc"
    edges : (bands + 1,) array, Hz

    Returns
    -------
    Signals
    """
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


def independent_samples(samples: FloatArray, width_hz: FloatArray, channels: int) -> FloatArray:
    """Independent samples that a band holds, less Bartlett's correction for their small number.

    Parameters
    ----------
    samples : (...) array, number of samples at :data:`GRID_HZ`
    width_hz : (...) array, Hz, width of the band
    channels : of all clocks

    Returns
    -------
    (...) array
    """
    independent = 2 * width_hz * samples / GRID_HZ
    return np.asarray(np.maximum(independent - (channels + 3) / 2, 0.0))


def at_all_shifts(
    one: FloatArray, two: FloatArray, noise: float, least: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Total correlation of two signals for each shift of the second.

    Parameters
    ----------
    one, two : (n, p) and (m, q) arrays
    noise : standard deviation of a sensor's noise, in the channels' unit
    least : samples that they must have in common; other shifts are left out

    Returns
    -------
    shared : (k,) array, nats per independent sample
    common : (k,) array, samples in common
    shift : (k,) array, begin of the second signals in the first
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
    return total_correlation(sums, (p, q), noise), *kept  # type: ignore[return-value]


def sums_in_parts(
    values: FloatArray, parts: int, inside: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Sums of all products of 1 and the channels, in each part of the time and each band.

    Parameters
    ----------
    values : (bands, n, c) array
    parts : number of parts
    inside : (n,) array of bool, samples that count; None for all

    Returns
    -------
    (parts, bands, 1 + c, 1 + c) array
    """
    one = np.ones(values.shape[1]) if inside is None else inside.astype(float)
    bands = [np.column_stack([one, band * one[:, None]]) for band in values]
    return np.stack(
        [[part.T @ part for part in np.array_split(band, parts)] for band in bands], axis=1
    )


def odds_without_each(
    sums: FloatArray,
    sizes: tuple[int, ...],
    noise: float,
    width_hz: FloatArray,
    weight: FloatArray | None = None,
) -> FloatArray:
    """Logarithm of the odds for a lag: from all parts, then from all but each.

    Parameters
    ----------
    sums : array of :func:`sums_in_parts`
    sizes : channels of each clock
    noise : standard deviation of a sensor's noise, in the channels' unit
    width_hz : (bands,) array, Hz
    weight : (bands,) array, independent samples that are taken to count; None for those there are

    Returns
    -------
    (1 + parts,) array
    """
    whole = sums.sum(axis=0)
    kept = np.concatenate([whole[None], whole - sums])
    if weight is None:
        weight = independent_samples(kept[:, :, 0, 0], width_hz, sum(sizes))
    return np.asarray((weight * total_correlation(kept, sizes, noise)).sum(axis=1))


def pooled(sums: FloatArray) -> FloatArray:
    """Means over all bands, each counted alike, so that one relation must hold in all of them.

    Parameters
    ----------
    sums : (parts, bands, 1 + c, 1 + c) array

    Returns
    -------
    (parts, 1, 1 + c, 1 + c) array
    """
    energy = np.trace(sums.sum(axis=0)[:, 1:, 1:], axis1=1, axis2=2)
    scale = np.sqrt(energy.mean() / np.maximum(energy, np.finfo(float).tiny))
    each = np.concatenate(
        [np.ones((len(scale), 1)), np.tile(scale[:, None], sums.shape[-1] - 1)], 1
    )
    return np.asarray((sums * each[:, :, None] * each[:, None, :]).mean(axis=1, keepdims=True))


def total_correlation(sums: FloatArray, sizes: tuple[int, ...], noise: float) -> FloatArray:
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
