"""A recording: one clock, named sensors, SI units, checked once when it is made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import (
    FloatArray,
    as_clock,
    as_number,
    as_vectors,
    check_switches,
    shown,
)
from mobility_imu.results import Result

if TYPE_CHECKING:
    import pandas as pd

LOWEST_RATE_HZ, HIGHEST_RATE_HZ = 1.0, 1e5
"""Between these lies the sampling rate of any IMU."""
# 2000 deg/s is the widest range of the usual IMUs; a unit error (deg/s) overshoots it at once.
LARGEST_RATE_RADPS = 40.0
# 400 g, the widest range of the sensors for impacts. Larger numbers are no readings at all.
LARGEST_ACC_MPS2 = 4000.0
# Median length of the specific force. A wheel adds a centripetal part, so the upper end is loose.
PLAUSIBLE_ACC_MPS2 = (6.0, 60.0)


@dataclass(frozen=True, eq=False, repr=False)
class Imu(Result):
    """What one sensor measured, in its own axes.

    Parameters
    ----------
    acc_mps2 : (n, 3) array, m/s², specific force (+9.81 upward at rest); copied, read-only
    gyr_radps : (n, 3) array, rad/s; None if the sensor has no gyroscope; copied, read-only

    Raises
    ------
    InputError
        If an array is no series of three real numbers, or the two differ in length.
    """

    acc_mps2: FloatArray
    gyr_radps: FloatArray | None = None

    def __post_init__(self) -> None:
        """Convert and copy both arrays, so that no later change of the input reaches them."""
        acc = as_vectors(self.acc_mps2, "acc_mps2", ndim=2)
        object.__setattr__(self, "acc_mps2", np.asarray(acc, order="C"))
        if self.gyr_radps is not None:
            gyr = as_vectors(self.gyr_radps, "gyr_radps", length=len(acc))
            object.__setattr__(self, "gyr_radps", np.asarray(gyr, order="C"))
        super().__post_init__()

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.acc_mps2)


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Result):
    """Samples of one or more IMUs on one clock.

    Parameters
    ----------
    time_s : (n,) array, s, strictly increasing, without gaps; copied, read-only
    sensors : sensor name to :class:`Imu`, all with n samples; kept as a read-only mapping
    source : where the recording comes from; error messages begin with it

    Raises
    ------
    InputError
        Too few samples, NaN, times that repeat, run backwards or leave a gap, arrays of
        other shapes, and accelerations or rates in other units than m/s² and rad/s.

    Examples
    --------
    >>> still = np.tile([0.0, 0.0, 9.81], (3, 1))
    >>> recording = Recording(np.arange(3) / 100, {"frame": Imu(still)}, source="walk.csv")
    >>> recording
    Recording('walk.csv', 3 samples, 100 Hz, 0.02 s: frame[acc])
    >>> recording.sampling_rate_hz
    100.0
    """

    time_s: FloatArray
    sensors: Mapping[str, Imu]
    source: str = field(default="recording", kw_only=True)

    def __post_init__(self) -> None:
        """Check everything that later steps rely on."""
        if not isinstance(self.source, str | PathLike):
            raise InputError(f"source: got {type(self.source).__name__}, expected text")
        time_s = as_clock(self.time_s, f"{self.source}: time_s", even=True)
        if not isinstance(self.sensors, Mapping) or not self.sensors:
            raise InputError(f"{self.source}: no sensor; expected a mapping of name to Imu")
        for name, imu in self.sensors.items():
            if not isinstance(name, str) or not name:
                raise InputError(f"{self.source}: sensor {shown(name)}: expected a name as text")
            if not isinstance(imu, Imu):
                raise InputError(
                    f"{self.source}: sensor {shown(name)} is {shown(imu)}, expected an Imu"
                )
            _check_imu(name, imu, time_s, self.source)
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "sensors", MappingProxyType(dict(self.sensors)))
        super().__post_init__()

    def __getstate__(self) -> dict[str, Any]:
        """State to pickle or copy: a read-only mapping can be neither."""
        return {**self.__dict__, "sensors": dict(self.sensors)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore from a pickle or a copy."""
        super().__setstate__({**state, "sensors": MappingProxyType(state["sensors"])})

    def __repr__(self) -> str:
        """One line: source, samples, rate, length, sensors."""
        sensors = ", ".join(
            f"{name}[{'acc' if imu.gyr_radps is None else 'acc, gyr'}]"
            for name, imu in self.sensors.items()
        )
        return (
            f"Recording({self.source!r}, {len(self)} samples, {self.sampling_rate_hz:g} Hz, "
            f"{self.time_s[-1] - self.time_s[0]:g} s: {sensors})"
        )

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.time_s)

    @property
    def sampling_rate_hz(self) -> float:
        """Samples per second, from the whole length (one late sample hardly moves it)."""
        rate = (len(self) - 1) / (self.time_s[-1] - self.time_s[0])
        return round(float(rate), 6)

    def sensor(self, name: str, *, gyroscope: bool = False) -> Imu:
        """One sensor; the error lists the available names.

        Parameters
        ----------
        name : the sensor's name
        gyroscope : whether its gyroscope is needed

        Returns
        -------
        Imu
        """
        check_switches(gyroscope=gyroscope)
        if not isinstance(name, str) or name not in self.sensors:
            have = ", ".join(self.sensors)
            raise InputError(f"{self.source}: no sensor {shown(name)} (it has: {have})")
        imu = self.sensors[name]
        if gyroscope and imu.gyr_radps is None:
            raise InputError(f"{self.source}: sensor '{name}' has no gyroscope columns")
        return imu

    def gyroscope(self, name: str) -> FloatArray:
        """Rates of one sensor; an error if it has no gyroscope.

        Parameters
        ----------
        name : the sensor's name

        Returns
        -------
        (n, 3) array, rad/s
        """
        rates = self.sensor(name, gyroscope=True).gyr_radps
        assert rates is not None
        return rates

    def to_frame(self) -> pd.DataFrame:
        """Table of the canonical CSV: time and one column per sensor, axis, quantity."""
        import pandas as pd

        columns = {"time_s": self.time_s}
        for name, imu in self.sensors.items():
            for k, axis in enumerate("xyz"):
                columns[f"{name}_acc_{axis}_mps2"] = imu.acc_mps2[:, k]
            if imu.gyr_radps is not None:
                for k, axis in enumerate("xyz"):
                    columns[f"{name}_gyr_{axis}_radps"] = imu.gyr_radps[:, k]
        return pd.DataFrame(columns)

    def trim(self, start_s: float, stop_s: float) -> Recording:
        """Recording of the samples with start_s <= time < stop_s.

        Parameters
        ----------
        start_s, stop_s : s, on the recording's clock; infinity leaves an end as it is

        Returns
        -------
        Recording
        """
        start_s = as_number(start_s, "start_s", negative=True, infinite=True)
        stop_s = as_number(stop_s, "stop_s", negative=True, infinite=True)
        keep = (self.time_s >= start_s) & (self.time_s < stop_s)
        if keep.sum() < 2:
            raise InputError(
                f"{self.source}: nothing between {start_s:g} and {stop_s:g} s (it runs from "
                f"{self.time_s[0]:g} to {self.time_s[-1]:g} s)"
            )
        sensors = {
            name: Imu(imu.acc_mps2[keep], None if imu.gyr_radps is None else imu.gyr_radps[keep])
            for name, imu in self.sensors.items()
        }
        return Recording(self.time_s[keep], sensors, source=self.source)

    def resample(self, sampling_rate_hz: float) -> Recording:
        """Recording on an even clock, by linear interpolation.

        Parameters
        ----------
        sampling_rate_hz : Hz. Going down, filter first: nothing is low-passed here.

        Returns
        -------
        Recording
        """
        sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
        if sampling_rate_hz > HIGHEST_RATE_HZ:
            raise InputError(
                f"sampling_rate_hz = {sampling_rate_hz:g}: expected up to {HIGHEST_RATE_HZ:g} Hz"
            )
        span = self.time_s[-1] - self.time_s[0]
        count = int(np.floor(span * sampling_rate_hz + 1e-9)) + 1
        time_s = self.time_s[0] + np.arange(count) / sampling_rate_hz

        def at_new_times(values: FloatArray) -> FloatArray:
            return np.column_stack([np.interp(time_s, self.time_s, axis) for axis in values.T])

        sensors = {
            name: Imu(
                at_new_times(imu.acc_mps2),
                None if imu.gyr_radps is None else at_new_times(imu.gyr_radps),
            )
            for name, imu in self.sensors.items()
        }
        return Recording(time_s, sensors, source=self.source)


def _check_imu(name: str, imu: Imu, time_s: FloatArray, source: str) -> None:
    count = len(time_s)
    for quantity, values in (("acc", imu.acc_mps2), ("gyr", imu.gyr_radps)):
        if values is None:
            continue
        label = f"{source}: {name}_{quantity}"
        if len(values) != count:
            raise InputError(f"{label}: expected shape ({count}, 3), got {values.shape}")
        bad = ~np.isfinite(values)
        if bad.any():
            k, axis = (int(index[0]) for index in np.nonzero(bad))
            raise InputError(
                f"{label}_{'xyz'[axis]}: sample {k} is {values[k, axis]}, expected a finite number "
                f"({int(bad.sum())} such value(s))"
            )
    _check_units(name, imu, time_s, source)


def _check_units(name: str, imu: Imu, time_s: FloatArray, source: str) -> None:
    with np.errstate(over="ignore"):  # huge numbers are refused below
        squared = np.einsum("ij,ij->i", imu.acc_mps2, imu.acc_mps2)  # three times as fast as norm
        acc = float(np.sqrt(np.median(squared)))
    low, high = PLAUSIBLE_ACC_MPS2
    if not low <= acc <= high:
        if 0.6 <= acc <= 2.5:
            guess = "this looks like g"
        elif 600 <= acc <= 2500:
            guess = "this looks like milli-g"
        elif acc > 2500:
            guess = "this looks like mm/s² or raw counts"
        elif acc > high:
            guess = (
                "no recording of these devices stays that high (a sensor far out on a fast wheel?)"
            )
        else:
            guess = "was gravity taken out?"
        raise InputError(
            f"{source}: {name}_acc has a median length of {acc:.4g}, expected about 9.81 m/s²: "
            f"{guess}"
        )
    largest = max(float(imu.acc_mps2.max()), -float(imu.acc_mps2.min()))
    if largest > LARGEST_ACC_MPS2:
        k, axis = (int(i) for i in np.argwhere(np.abs(imu.acc_mps2) > LARGEST_ACC_MPS2)[0])
        raise InputError(
            f"{source}: {name}_acc_{'xyz'[axis]} is {imu.acc_mps2[k, axis]:.4g} m/s² at "
            f"{time_s[k]:g} s (sample {k}), more than any such sensor measures "
            f"({LARGEST_ACC_MPS2:g}): correct or remove it"
        )
    if imu.gyr_radps is not None:
        fastest = float(np.abs(imu.gyr_radps).max())
        if fastest > LARGEST_RATE_RADPS:
            raise InputError(
                f"{source}: {name}_gyr reaches {fastest:.4g}, more than any such sensor measures "
                f"in rad/s ({LARGEST_RATE_RADPS:g}): this looks like deg/s"
            )
