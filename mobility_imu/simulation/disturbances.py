"""What real recordings add to a sensor's own errors: vibration of what it sits on, and its clock.

Recordings of several sensors were joined on one even clock by somebody: each sensor's samples were
taken a little late or early, some were doubled, and lost ones were filled in. That is done to the
readings here, so that the clock of the recording stays even.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_floats, as_number, as_series, as_vectors
from mobility_imu.simulation.checks import check_range

__all__ = ["AT_ONCE", "Delivery", "VibrationBand", "vibration"]


@dataclass(frozen=True)
class Delivery:
    """How samples reach the common clock of a joined recording.

    Parameters
    ----------
    late_s : s, a sensor's clock is late by up to this, evenly drawn per power-up
    jitter_s : s, sd of the time at which a sample was really taken
    doubled_share : 1, fraction of samples that repeat the sample before
    filled_share : 1, fraction of samples that got lost and lie on a line between their neighbours
    """

    late_s: float = 0.0
    jitter_s: float = 0.0
    doubled_share: float = 0.0
    filled_share: float = 0.0

    def __post_init__(self) -> None:
        """Check every size."""
        for field in fields(self):
            number = as_number(getattr(self, field.name), f"Delivery.{field.name}", zero=True)
            object.__setattr__(self, field.name, number)
            if field.name.endswith("share") and number >= 1:
                raise InputError(f"Delivery.{field.name} = {number:g}: expected from 0 to below 1")

    def taken(self, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """When the samples that are stamped with some times were really taken.

        Parameters
        ----------
        time_s : (n,) array, s
        rng : the source of the draws

        Returns
        -------
        (n,) array, s, within the first and the last time
        """
        expect("rng", rng, np.random.Generator)
        time_s = as_series(time_s, "time_s")
        if not len(time_s):
            raise InputError("time_s: 0 samples, expected at least 1")
        late = self.late_s * rng.random()
        taken = time_s - late + self.jitter_s * rng.standard_normal(len(time_s))
        return np.asarray(np.clip(taken, time_s[0], time_s[-1]))

    def arrived(self, readings: list[FloatArray], rng: np.random.Generator) -> list[FloatArray]:
        """Readings in which some samples are doubled and others filled in.

        Parameters
        ----------
        readings : of (n, 3) arrays; the same samples of each are changed
        rng : the source of the draws

        Returns
        -------
        list of (n, 3) arrays; the first and the last sample stay
        """
        expect("rng", rng, np.random.Generator)
        if not isinstance(readings, list | tuple) or not readings:
            raise InputError(f"readings: got {type(readings).__name__}, expected a list of arrays")
        count = len(as_vectors(readings[0], "readings", ndim=2))
        readings = [as_vectors(values, "readings", length=count) for values in readings]
        if not count:
            raise InputError("readings: 0 samples, expected at least 1")
        doubled = rng.random(count) < self.doubled_share
        lost = rng.random(count) < self.filled_share
        doubled[0] = False
        lost[[0, -1]] = False
        return [_filled(_repeated(values, doubled), lost) for values in readings]


AT_ONCE = Delivery()
"""No delay, no loss."""


@dataclass(frozen=True)
class VibrationBand:
    """Vibration of one band of frequencies while the device moves at full speed.

    Parameters
    ----------
    band_hz : Hz, lowest and highest frequency
    sd_mps2 : m/s², standard deviation on each axis
    """

    band_hz: tuple[float, float]
    sd_mps2: float

    def __post_init__(self) -> None:
        """Check band and size."""
        check_range(self.band_hz, "VibrationBand.band_hz")
        as_number(self.sd_mps2, "VibrationBand.sd_mps2", zero=True)


def vibration(
    bands: tuple[VibrationBand, ...],
    speed_share: FloatArray,
    sampling_rate_hz: float,
    rng: np.random.Generator,
) -> FloatArray:
    """Vibration of some bands, in proportion to the speed.

    Parameters
    ----------
    bands : of VibrationBand; those beyond half the sampling rate are left out
    speed_share : (n,) array, speed as a fraction of the one that the sizes are for
    sampling_rate_hz : Hz, of the array
    rng : the source of the draws

    Returns
    -------
    (n, 3) array, m/s²
    """
    expect("rng", rng, np.random.Generator)
    expect("bands", bands, tuple)
    speed_share = as_floats(speed_share, "speed_share")
    if speed_share.ndim != 1 or not len(speed_share):
        raise InputError(f"speed_share: expected one series, got shape {speed_share.shape}")
    sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    shaken = np.zeros((len(speed_share), 3))
    for band in bands:
        expect("bands", band, VibrationBand)
        noise = rng.standard_normal(shaken.shape)
        low, high = band.band_hz
        high = min(high, 0.45 * sampling_rate_hz)
        if low >= high:
            continue
        sections = signal.butter(4, [low, high], "band", fs=sampling_rate_hz, output="sos")
        # White noise of unit variance keeps the part of its power that lies in the band.
        part = np.sqrt(2 * (high - low) / sampling_rate_hz)
        shaken += band.sd_mps2 / part * signal.sosfilt(sections, noise, axis=0)
    return np.asarray(np.clip(speed_share, 0, 1)[:, None] * shaken)


def _repeated(values: FloatArray, doubled: NDArray[np.bool_]) -> FloatArray:
    """Each doubled sample as the last one before it that is not doubled."""
    source = np.maximum.accumulate(np.where(doubled, 0, np.arange(len(values))))
    return np.asarray(values[source])


def _filled(values: FloatArray, lost: NDArray[np.bool_]) -> FloatArray:
    places = np.arange(len(values))
    columns = [np.interp(places, places[~lost], column[~lost]) for column in values.T]
    return np.column_stack(columns)
