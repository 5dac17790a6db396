"""What the sensors of real recordings are like: clock, offset, noise, steps of the values, spectra.

Every number comes from the recording alone, none from a reference.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import signal

from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_flags
from mobility_imu.offsets import gyroscope_offset
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of

GAP_FACTOR = 1.5
"""A step of the clock this many times the median one is counted as a gap."""
SEGMENT_S = 1.0
"""Length of the pieces of which a spectrum is the mean; its lines are 1 Hz apart."""
BANDS = 16
"""Bands of one spectrum, of equal width on a logarithmic scale."""
GRID_G = 0.01
"""Rounding of the acceleration that is looked for; by chance one reading in 25 falls on it."""

WARNINGS = {
    "times as far from what the filter expects": "rests do not fit the filter",
    "moves too long for one step": "move too long for one step",
    "moves at the start": "moves at the start",
    "no rest for more than": "no rest for seconds",
    "went backward": "went backward",
    "leans by": "leans while it stands",
    "has an offset": "offset of the gyroscope taken off",
    "is saturated": "end of the range",
    "readings repeat": "readings repeat",
}
"""What a warning is called in a table, by words that are in it."""

Spectrum = dict[str, list[float]]


def sensor_row(
    recording: Recording, rest: ArrayLike, clock_s: FloatArray | None = None
) -> dict[str, float | None]:
    """Clock, rest and resolution of the sensor "frame" of one recording.

    Parameters
    ----------
    recording : Recording
    rest : (n,) flags, samples at which the sensor rests
    clock_s : s, the times before gaps were filled; those of the recording if None

    Returns
    -------
    dict: ``rate_hz``; ``shortest_step_ms`` and ``longest_step_ms`` of the clock; ``gaps``;
    ``repeated_percent`` of the samples have the acceleration of the one before; ``gravity_mps2``,
    length of the mean specific force at rest; ``acc_noise_mps2`` and ``gyr_noise_degps``, standard
    deviation of one sample at rest by the differences of neighbours; ``gyr_offset_degps``, length
    of the offset; ``gyr_largest_degps``, largest rate about an axis; ``on_grid_percent`` of the
    accelerations are multiples of 0.01 g
    """
    flags = as_flags(rest, "rest", length=len(recording))
    clock = recording.time_s if clock_s is None else clock_s
    step = np.diff(clock)
    acc, gyr = recording.sensor("frame").acc_mps2, recording.gyroscope("frame")
    offset = gyroscope_offset(gyr, flags, recording.sampling_rate_hz)
    size = None if offset is None else float(np.linalg.norm(offset.offset_radps))
    return {
        "rate_hz": rounded(len(step) / (clock[-1] - clock[0]), 2),
        "shortest_step_ms": rounded(1e3 * step.min(), 1),
        "longest_step_ms": rounded(1e3 * step.max(), 1),
        "gaps": int(np.count_nonzero(step > GAP_FACTOR * np.median(step))),
        "repeated_percent": rounded(100 * np.mean((np.diff(acc, axis=0) == 0).all(axis=1)), 1),
        "gravity_mps2": rounded(np.linalg.norm(acc[flags].mean(axis=0)), 3),
        "acc_noise_mps2": rounded(_noise(acc, flags), 4),
        "gyr_noise_degps": rounded(np.rad2deg(_noise(gyr, flags)), 3),
        "gyr_offset_degps": None if size is None else rounded(np.rad2deg(size), 2),
        "gyr_largest_degps": rounded(np.rad2deg(np.abs(gyr).max()), 0),
        "on_grid_percent": rounded(100 * _on_grid(acc), 0),
    }


def sensors_summary(rows: list[dict[str, float | None]]) -> dict[str, list[float]]:
    """Lowest, median and highest of each number over several recordings.

    Parameters
    ----------
    rows : from :func:`sensor_row`

    Returns
    -------
    dict from name to three numbers
    """
    found = {}
    for name in rows[0]:
        values = [value for row in rows if (value := row[name]) is not None]
        found[name] = [rounded(np.percentile(values, p), 4) for p in (0, 50, 100)]
    return found


def kinds_of(warnings: Iterable[str]) -> list[str]:
    """Warnings by short names, sorted, without their numbers.

    Parameters
    ----------
    warnings : sentences

    Returns
    -------
    list of str; a sentence that is not known stays as it is
    """
    return sorted(
        next((name for words, name in WARNINGS.items() if words in text), text) for text in warnings
    )


def rounded(value: Any, digits: int) -> float:
    """Number for a record: a float of so many decimals.

    Parameters
    ----------
    value : number
    digits : behind the decimal point

    Returns
    -------
    float
    """
    return round(float(value), digits)


def _noise(values: FloatArray, rest: NDArray[np.bool_]) -> float:
    """Standard deviation of one sample per axis, from differences of neighbours at rest."""
    differences = [np.diff(values[run], axis=0) for run in runs_of(rest)]
    return float(np.sqrt(np.mean(np.square(np.concatenate(differences))) / 2))


def _on_grid(acc: FloatArray) -> float:
    """Fraction of readings that are a multiple of GRID_G, to a fiftieth of it."""
    steps = acc / (GRID_G * STANDARD_GRAVITY_MPS2)
    return float(np.mean(np.abs(steps - np.round(steps)) < 1 / 50))


def mean_spectrum(pieces: list[FloatArray], rate_hz: float) -> Spectrum:
    """Density of noise and vibration over frequency, all axes together, means over bands.

    Parameters
    ----------
    pieces : (n, 3) arrays; each longer than a second, of one rate and in one unit
    rate_hz : Hz

    Returns
    -------
    dict with ``hz``, middles of the bands, and ``density``, unit per root of Hz
    """
    length = round(SEGMENT_S * rate_hz)
    total, weight = np.zeros(length // 2 + 1), 0
    for piece in pieces:
        if len(piece) < length:
            continue
        frequency, power = signal.welch(piece, rate_hz, nperseg=length, axis=0)
        total += len(piece) * power.sum(axis=1)
        weight += len(piece)
    power = total / max(weight, 1)
    edges = np.geomspace(0.5, frequency[-1], BANDS + 1)
    band = np.digitize(frequency, edges)
    inside = [band == k for k in range(1, BANDS + 1) if (band == k).any()]
    return {
        "hz": [rounded(frequency[here].mean(), 2) for here in inside],
        "density": [float(f"{np.sqrt(power[here].mean()):.3g}") for here in inside],
    }


def spectra(
    recordings: list[tuple[Recording, NDArray[np.bool_]]],
) -> dict[str, dict[str, Spectrum]]:
    """Spectra of several recordings of one kind of sensor, at rest and on the way.

    Parameters
    ----------
    recordings : each with its (n,) flags of rest, of which those of a second and more are used; on
        the way is all between the first and the last move

    Returns
    -------
    dict: "acc" in m/s²/sqrt(Hz) and "gyr" in deg/s/sqrt(Hz), each with "at rest" and "on the way"
    """
    rate = float(np.median([recording.sampling_rate_hz for recording, _ in recordings]))
    found: dict[str, dict[str, Spectrum]] = {"acc": {}, "gyr": {}}
    for quantity in found:
        still, moving = [], []
        for recording, rest in recordings:
            values = (
                recording.sensor("frame").acc_mps2
                if quantity == "acc"
                else np.rad2deg(recording.gyroscope("frame"))
            )
            long = long_runs(rest, round(SEGMENT_S * rate), grow=False)
            still += [values[run] for run in runs_of(long)]
            way = np.flatnonzero(~rest)
            if len(way):
                moving.append(values[way[0] : way[-1] + 1])
        found[quantity] = {
            name: mean_spectrum(pieces, rate)
            for name, pieces in (("at rest", still), ("on the way", moving))
        }
    return found
