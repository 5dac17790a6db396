"""What the studies of others' recordings share: files, offsets, spectra, error against a reference.

The numbers go into records under ``data/recorded``; the recordings themselves may not be passed on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import signal

from mobility_imu.datasets.folders import find_folder
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.offsets import GyroscopeOffset
from mobility_imu.reproduction.real_files import Numbers, origin_of
from mobility_imu.results import Result
from mobility_imu.runs import runs_of

SIGNIFICANT_DIGITS = 5
INSIDE = 1.96
"""Standard deviations on each side of an interval that holds 95 % of a normal distribution."""
RATIO_EDGES = np.linspace(-4.0, 4.0, 33)
"""Edges of the histograms of error over standard deviation; what lies beyond counts at the ends."""


@dataclass(frozen=True, eq=False, repr=False)
class Against(Result):
    """A quantity beside its reference, at the times that have one.

    Parameters
    ----------
    time_s : (n,) array, s
    found, true : (n,) arrays, one unit
    sd : (n,) array, stated standard deviation
    step_s : (n,) array, s, that each sample stands for
    """

    time_s: FloatArray
    found: FloatArray
    true: FloatArray
    sd: FloatArray
    step_s: FloatArray

    @property
    def error(self) -> FloatArray:
        """Found minus true, (n,)."""
        return np.asarray(self.found - self.true)

    @property
    def inside(self) -> float:
        """Fraction of the samples whose 95 % interval holds the reference."""
        return float(np.mean(np.abs(self.error) < INSIDE * self.sd))

    @property
    def path_ratio(self) -> float:
        """Way found over way of the reference, where there is one."""
        return float(np.abs(self.found) @ self.step_s / (np.abs(self.true) @ self.step_s))

    def summary(self) -> Numbers:
        """Number of samples, root mean square, mean, median stated sd, their ratio, coverage."""
        size, sd = rms(self.error), float(np.median(self.sd))
        return {
            "samples": len(self.true),
            "rms": size,
            "mean_error": float(self.error.mean()),
            "largest_error": float(np.abs(self.error).max()),
            "sd_median": sd,
            "sd_over_rms": sd / size,
            "inside": self.inside,
        }


def low_passed(values: ArrayLike, rate_hz: float, cutoff_hz: float) -> FloatArray:
    """Low-pass forward and backward, as the references were.

    Parameters
    ----------
    values : (n,) array
    rate_hz, cutoff_hz : Hz

    Returns
    -------
    (n,) array
    """
    sections = signal.butter(2, cutoff_hz, fs=rate_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sections, np.ascontiguousarray(values)))


def against(
    time_s: FloatArray,
    true: FloatArray,
    found_time_s: FloatArray,
    found: FloatArray,
    sd: FloatArray,
) -> Against:
    """Bring a result to the times of its reference.

    Parameters
    ----------
    time_s, true : (m,) arrays, reference; NaN where it is not usable
    found_time_s, found, sd : (n,) arrays, result, low-passed like the reference

    Returns
    -------
    Against
    """
    there = np.isfinite(true)
    return Against(
        time_s[there],
        np.interp(time_s, found_time_s, found)[there],
        true[there],
        np.interp(time_s, found_time_s, sd)[there],
        np.gradient(time_s)[there],
    )


def in_degrees(radians: Against) -> Against:
    """Angles or rates in degrees instead of radians.

    Parameters
    ----------
    radians : Against

    Returns
    -------
    Against
    """
    found, true, sd = (np.rad2deg(v) for v in (radians.found, radians.true, radians.sd))
    return Against(radians.time_s, found, true, sd, radians.step_s)


def ratio_fractions(ratios: ArrayLike) -> list[float]:
    """Histogram of error over standard deviation, in :data:`RATIO_EDGES`.

    Parameters
    ----------
    ratios : (n,) array

    Returns
    -------
    list of fractions of the samples; the first and the last hold what lies beyond as well
    """
    inside = np.clip(np.asarray(ratios, float), RATIO_EDGES[0], RATIO_EDGES[-1])
    return [float(k) for k in np.histogram(inside, RATIO_EDGES)[0] / len(inside)]


def spectrum(values: ArrayLike, rate_hz: float, flags: NDArray[np.bool_] | None = None) -> Numbers:
    """Amplitude spectral density in bands of a third of an octave.

    Parameters
    ----------
    values : (n,) array
    rate_hz : Hz
    flags : (n,) bool array, the part that is looked at; runs of less than two seconds are left out

    Returns
    -------
    dict of lists: ``hz``, middle of the band; ``density``, unit of the values per root hertz
    """
    values = np.asarray(values, float)
    parts = [values] if flags is None else [values[run] for run in runs_of(flags)]
    length = round(2 * rate_hz)
    powers = [
        signal.welch(part, rate_hz, nperseg=length, detrend="constant")[1] * len(part)
        for part in parts
        if len(part) >= length
    ]
    if not powers:
        return {"hz": [], "density": []}
    power = np.sum(powers, axis=0) / sum(len(part) for part in parts if len(part) >= length)
    lines = np.fft.rfftfreq(length, 1 / rate_hz)
    middle = 2.0 ** (np.arange(0, 3 * np.log2(rate_hz / 2)) / 3)
    found = [
        (m, np.sqrt(power[band].mean()))
        for m in middle
        if (band := (lines >= m * 2 ** (-1 / 6)) & (lines < m * 2 ** (1 / 6))).any()
    ]
    return {"hz": [float(m) for m, _ in found], "density": [float(d) for _, d in found]}


def offset_numbers(offsets: Mapping[str, GyroscopeOffset]) -> Numbers:
    """Offsets and noise of the gyroscopes, deg/s.

    Parameters
    ----------
    offsets : sensor to GyroscopeOffset

    Returns
    -------
    dict from sensor to ``offset_degps`` (3 numbers), ``sd_degps`` (the largest of the axes),
    ``noise_degps`` (root mean square over the axes) and ``rest_s``
    """
    return {
        name: {
            "offset_degps": np.rad2deg(offset.offset_radps).tolist(),
            "sd_degps": float(np.rad2deg(offset.sd_radps.max())),
            "noise_degps": float(np.rad2deg(rms(offset.noise_radps))),
            "rest_s": offset.rest_s,
        }
        for name, offset in offsets.items()
    }


def rounded(value: Any) -> Any:
    """Numbers to five significant digits, in nested dicts and lists; NaN becomes None.

    Parameters
    ----------
    value : nested dicts, lists and tuples of numbers and text

    Returns
    -------
    the same, as JSON has it
    """
    if isinstance(value, dict):
        return {key: rounded(each) for key, each in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [rounded(each) for each in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(f"{value:.{SIGNIFICANT_DIGITS}g}") if np.isfinite(value) else None
    return value


def spread(values: Iterable[float]) -> Numbers:
    """Median, smallest and largest of some numbers.

    Parameters
    ----------
    values : numbers

    Returns
    -------
    dict with ``median``, ``least``, ``most``
    """
    numbers = np.array(list(values), float)
    return {
        "median": float(np.median(numbers)),
        "least": float(numbers.min()),
        "most": float(numbers.max()),
    }


def recorded_study(
    dataset: str,
    record: str,
    compute: Callable[[Path], Numbers],
    simulated: Mapping[str, Callable[[], Numbers]] | None = None,
) -> Numbers | None:
    """All numbers of a record, with those of the simulations beside the recordings in its summary.

    Parameters
    ----------
    dataset : name by which it is fetched
    record : name of the record
    compute : numbers of the data set in a folder, ``files``, ``rows`` and ``summary`` among them
    simulated : key in the summary to what computes its numbers

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if the data set is not here
    """
    folder = find_folder(dataset)
    if folder is None:
        return None
    found = compute(folder)
    numbers = {
        "origin": origin_of(dataset),
        "command": f"python -m mobility_imu.reproduction.recorded {record}",
        **found,
    }
    for key, simulate in (simulated or {}).items():
        numbers["summary"][key] = rounded(simulate())
    return {"numbers": numbers, "inputs": found["files"]}
