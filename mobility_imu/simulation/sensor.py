"""What an IMU makes of a true motion: the error model that all simulators share.

A true specific force and rate, given much faster than the sensor samples, pass a low-pass, are
taken at the sensor's own clock, scaled, mixed between axes, biased, made noisy, cut at the range
and rounded to the converter's steps; some samples get lost. Each step has a parameter with its
unit; zero (or infinity) turns it off. Constants of one unit (scale factors, misalignment) and of
one power-up (biases) are drawn from two seeds.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import signal

from mobility_imu.arguments import check_columns, check_limits, expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_clock,
    as_count,
    as_number,
    as_series,
    as_vectors,
    check_positive,
    shown,
)
from mobility_imu.recording import Imu
from mobility_imu.results import Result
from mobility_imu.simulation.disturbances import AT_ONCE, Delivery, VibrationBand, vibration
from mobility_imu.simulation.seeds import stream

__all__ = [
    "IDEAL",
    "LPMS_CU2",
    "MTI_1",
    "REAL",
    "SensorModel",
    "SensorNoise",
    "SensorOutput",
    "Triad",
    "measure",
    "without",
]


@dataclass(frozen=True)
class Triad:
    """Errors of three like sensors; units of the quantity q are m/s² or rad/s.

    Parameters
    ----------
    noise_density : q/sqrt(Hz), white noise; a sample at f Hz has the sd density * sqrt(f)
    turn_on_bias_sd : q, constant bias, drawn per axis at each power-up
    bias_instability : q, sd of a Gauss-Markov bias on top
    bias_time_s : s, correlation time of that bias
    scale_sd : 1, relative error of the scale factor, drawn per unit and axis
    misalignment_sd_rad : rad, each axis leans toward each other one by this, drawn per unit
    full_scale : q, readings beyond are cut
    bits : of the converter over twice the full scale; 0 leaves the readings unrounded
    step : q, readings are rounded to multiples of it, after the converter; 0 for none
    bandwidth_hz : Hz, corner of a second-order low-pass; inf for none
    """

    noise_density: float = 0.0
    turn_on_bias_sd: float = 0.0
    bias_instability: float = 0.0
    bias_time_s: float = 100.0
    scale_sd: float = 0.0
    misalignment_sd_rad: float = 0.0
    full_scale: float = np.inf
    bits: int = 0
    bandwidth_hz: float = np.inf
    step: float = 0.0

    def __post_init__(self) -> None:
        """Check every size."""
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            endless = name in ("bias_time_s", "full_scale", "bandwidth_hz")
            if name == "bits":
                as_count(value, name, least=0)
            else:
                number = as_number(value, name, zero=not endless, infinite=endless)
                object.__setattr__(self, name, number)
        check_limits(self, {"bandwidth_hz": (1e-3, np.inf)})
        if self.bits and not np.isfinite(self.full_scale):
            raise InputError(f"bits = {self.bits}: rounding needs a finite full_scale")


@dataclass(frozen=True)
class SensorModel:
    """An IMU: two triads, their coupling, and the clock.

    Parameters
    ----------
    acc, gyr : Triad, in m/s² and rad/s
    g_sensitivity_sd : (rad/s)/(m/s²), each gyroscope axis responds to each acceleration by this
    clock_rate_sd : 1, relative error of the sampling rate, drawn per unit
    clock_jitter_s : s, sd of each sample's time
    dropped_share : 1, fraction of samples that get lost
    delivery : Delivery of the samples to the clock of a joined recording
    vibration : of VibrationBand, what the sensor sits on, at the simulator's full speed
    """

    acc: Triad = Triad()
    gyr: Triad = Triad()
    g_sensitivity_sd: float = 0.0
    clock_rate_sd: float = 0.0
    clock_jitter_s: float = 0.0
    dropped_share: float = 0.0
    delivery: Delivery = AT_ONCE
    vibration: tuple[VibrationBand, ...] = ()

    def __post_init__(self) -> None:
        """Check both triads, the coupling and the clock."""
        for name in ("acc", "gyr"):
            if not isinstance(getattr(self, name), Triad):
                raise InputError(f"{name} = {shown(getattr(self, name))}: expected a Triad")
        check_fields(self, delivery=Delivery, vibration=[VibrationBand])
        sizes = ("g_sensitivity_sd", "clock_rate_sd", "clock_jitter_s", "dropped_share")
        check_positive(self, *sizes, allow_zero=sizes)
        if self.dropped_share >= 1:
            raise InputError(f"dropped_share = {self.dropped_share}: expected from 0 to below 1")


@dataclass(frozen=True)
class SensorNoise:
    """White noise and constant biases alone, the same on every axis, per sample.

    A :class:`SensorModel` states a noise density, so that its samples become noisier with the
    sampling rate. These sizes are what one sample has at any rate, as they are read from a
    recording at rest. ``simulate_drive`` adds them to exact
    samples; the bundled recordings were made that way.

    Parameters
    ----------
    acc_sd_mps2, gyr_sd_radps : m/s² and rad/s, standard deviation of each sample
    acc_bias_sd_mps2, gyr_bias_sd_radps : m/s² and rad/s, standard deviation of the bias, drawn per
        sensor and axis
    """

    acc_sd_mps2: float = 0.0
    gyr_sd_radps: float = 0.0
    acc_bias_sd_mps2: float = 0.0
    gyr_bias_sd_radps: float = 0.0

    def __post_init__(self) -> None:
        """Check every size."""
        check_positive(self, allow_zero=[field.name for field in fields(self)])

    def added_to(self, imu: Imu, rng: np.random.Generator) -> Imu:
        """Readings with these errors.

        Parameters
        ----------
        imu : Imu with a gyroscope
        rng : the source of the draws

        Returns
        -------
        Imu
        """
        expect("imu", imu, Imu)
        expect("rng", rng, np.random.Generator)
        if imu.gyr_radps is None:
            raise InputError("imu: it has no gyroscope, expected rates to add noise to")
        shape = imu.acc_mps2.shape
        acc_bias = self.acc_bias_sd_mps2 * rng.standard_normal(3)
        gyr_bias = self.gyr_bias_sd_radps * rng.standard_normal(3)
        return Imu(
            imu.acc_mps2 + acc_bias + self.acc_sd_mps2 * rng.standard_normal(shape),
            imu.gyr_radps + gyr_bias + self.gyr_sd_radps * rng.standard_normal(shape),
        )


IDEAL = SensorModel()
"""No error at all; samples are taken at the exact times."""

_G = STANDARD_GRAVITY_MPS2
_DEG = float(np.deg2rad(1))

# Xsens MTi-1: noise density, bias instability, range and bandwidth as tabulated from its data sheet
# in Transactions on Aerospace Research 2023 (doi 10.2478/tar-2023-0022); gyroscope turn-on bias
# from Xsens' note on bias repeatability (0.5 deg/s within a year, taken as 2.5 sd). Turn-on bias of
# the accelerometer, scale, misalignment, g-sensitivity and clock are not in them: we assume them.
MTI_1 = SensorModel(
    acc=Triad(
        noise_density=120e-6 * _G,
        turn_on_bias_sd=3e-3 * _G,
        bias_instability=0.03e-3 * _G,
        scale_sd=0.003,
        misalignment_sd_rad=0.1 * _DEG,
        full_scale=16 * _G,
        bits=16,
        bandwidth_hz=324.0,
    ),
    gyr=Triad(
        noise_density=0.007 * _DEG,
        turn_on_bias_sd=0.2 * _DEG,
        bias_instability=10 * _DEG / 3600,
        scale_sd=0.003,
        misalignment_sd_rad=0.1 * _DEG,
        full_scale=2000 * _DEG,
        bits=16,
        bandwidth_hz=255.0,
    ),
    g_sensitivity_sd=0.001 * _DEG / _G,
    clock_rate_sd=20e-6,
)

# LPMS-CU2: 16 bits and 100 Hz are in the scooter paper; no data sheet was at hand. The rest is what
# sensors of this class state (Bosch BMI160: 150 ug/sqrt(Hz), 0.008 deg/s/sqrt(Hz), 6 deg/h), with a
# factory calibration to 5 mg; the bandwidth is that of a usual digital low-pass at 100 Hz output.
LPMS_CU2 = SensorModel(
    acc=Triad(
        noise_density=150e-6 * _G,
        turn_on_bias_sd=5e-3 * _G,
        bias_instability=0.05e-3 * _G,
        scale_sd=0.003,
        misalignment_sd_rad=0.2 * _DEG,
        full_scale=4 * _G,
        bits=16,
        bandwidth_hz=45.0,
    ),
    gyr=Triad(
        noise_density=0.008 * _DEG,
        turn_on_bias_sd=0.3 * _DEG,
        bias_instability=6 * _DEG / 3600,
        scale_sd=0.005,
        misalignment_sd_rad=0.2 * _DEG,
        full_scale=500 * _DEG,
        bits=16,
        bandwidth_hz=45.0,
    ),
    g_sensitivity_sd=0.01 * _DEG / _G,
    clock_rate_sd=20e-6,
)

# What recordings of others show, measured by benchmarks/measure_real_sensors.py into
# data/reference/real_sensors.csv, where files and checksums stand: noise (wheels of a chair, 0.015
# m/s² and, of the frame, 0.07 deg/s in a sample at 100 Hz), gyroscope offset (1.7 deg/s on an axis,
# median of a left wheel), steps of 0.01 g and 0.06 deg/s (one hinge), vibration (frame of a chair,
# medians of six drives on four grounds), doubled samples (0.6 %, the worst of three streams), lost
# ones (0.9 %, their median), stamps (0.2 ms, the worst). Stated with the recordings: accelerometer
# offsets of 0.007 to 0.03 g (one hinge), lengths of gravity of 9.72 to 9.90 m/s² (two hinges, 1 %),
# clocks of two sensors that agree within 30 ms (chair against motion capture). Misalignment is the
# cross-axis sensitivity of 1 % that data sheets of this class state; clock rate, bandwidth and
# ranges are assumed.
REAL = SensorModel(
    acc=Triad(
        noise_density=0.0015,
        turn_on_bias_sd=0.02 * _G,
        scale_sd=0.01,
        misalignment_sd_rad=0.01,
        full_scale=8 * _G,
        bandwidth_hz=45.0,
        step=0.01 * _G,
    ),
    gyr=Triad(
        noise_density=0.0075 * _DEG,
        turn_on_bias_sd=1.7 * _DEG,
        scale_sd=0.01,
        misalignment_sd_rad=0.01,
        full_scale=2000 * _DEG,
        bandwidth_hz=45.0,
        step=0.06 * _DEG,
    ),
    clock_rate_sd=20e-6,
    delivery=Delivery(late_s=0.03, jitter_s=0.0002, doubled_share=0.006, filled_share=0.009),
    vibration=(
        VibrationBand((5.0, 10.0), 0.63),
        VibrationBand((10.0, 20.0), 0.87),
        VibrationBand((20.0, 45.0), 1.86),
    ),
)


@dataclass(frozen=True, eq=False, repr=False)
class SensorOutput(Result):
    """What the sensor delivered.

    Parameters
    ----------
    time_s : (n,) array, s, by the sensor's own clock; lost samples leave gaps
    true_time_s : (n,) array, s, when the samples were really taken
    imu : Imu with n samples
    """

    time_s: FloatArray
    true_time_s: FloatArray
    imu: Imu

    def __post_init__(self) -> None:
        """Check that times and readings belong together."""
        check_columns(self, "time_s", "true_time_s")
        expect("SensorOutput.imu", self.imu, Imu)
        if len(self.imu) != len(self.time_s):
            raise InputError(
                f"SensorOutput.imu: {len(self.imu)} samples, expected {len(self.time_s)}"
            )
        super().__post_init__()


def measure(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    model: SensorModel,
    *,
    sampling_rate_hz: float,
    seed: int,
    unit_seed: int,
    speed_share: ArrayLike | None = None,
) -> SensorOutput:
    """Readings that an IMU makes of a true motion.

    Parameters
    ----------
    time_s : (m,) array, s, even; fast enough that linear interpolation is exact for the purpose
    acc_mps2 : (m, 3) array, m/s², true specific force in the sensor's axes
    gyr_radps : (m, 3) array, rad/s, true rate in the sensor's axes
    model : SensorModel
    sampling_rate_hz : Hz, of the output
    seed : of this power-up: biases, noise, jitter, losses
    unit_seed : of this unit: scale factors, misalignments, g-sensitivity, clock rate
    speed_share : (m,) array, speed as a fraction of full speed, by which the model's vibration
        grows; without it nothing vibrates

    Returns
    -------
    SensorOutput; the same bytes for the same arguments

    Raises
    ------
    InputError
        If the shapes differ, a value is not finite, the times are not even, the output is to be
        faster than the input, or a seed is negative or not whole.
    """
    expect("model", model, SensorModel)
    clock = as_clock(time_s)
    acc = as_vectors(acc_mps2, "acc_mps2", length=len(clock), finite=True)
    gyr = as_vectors(gyr_radps, "gyr_radps", length=len(clock), finite=True)
    step = np.diff(clock)
    if np.ptp(step) > 1e-3 * step.mean():
        raise InputError(
            f"time_s: steps from {step.min():g} to {step.max():g} s, expected even steps"
        )
    fast_hz = (len(clock) - 1) / (clock[-1] - clock[0])
    sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    if sampling_rate_hz > fast_hz * (1 + 1e-9):
        raise InputError(
            f"sampling_rate_hz = {sampling_rate_hz:g}: faster than the {fast_hz:g} Hz of the input"
        )
    unit, run = stream(unit_seed, 1, name="unit_seed"), stream(seed, 2)
    rate = 1 + model.clock_rate_sd * unit.standard_normal()
    count = int(np.floor((clock[-1] - clock[0]) * sampling_rate_hz * (1 + 1e-12))) + 1
    stated = clock[0] + np.arange(count) / sampling_rate_hz
    true = clock[0] + (stated - clock[0]) / rate + model.clock_jitter_s * run.standard_normal(count)

    way = stream(seed, 3)  # draws of its own: what was drawn before stays as it is
    taken = true if model.delivery == AT_ONCE else model.delivery.taken(true, way)
    if model.vibration and speed_share is not None:
        share = as_series(speed_share, "speed_share", length=len(clock))
        acc = acc + vibration(model.vibration, share, fast_hz, way)

    def sampled(values: FloatArray, triad: Triad) -> FloatArray:
        smooth = _low_pass(values, triad.bandwidth_hz, fast_hz)
        return np.column_stack([np.interp(taken, clock, axis) for axis in smooth.T])

    true_acc, true_gyr = sampled(acc, model.acc), sampled(gyr, model.gyr)
    coupling = model.g_sensitivity_sd * unit.standard_normal((3, 3))
    readings = [
        _read(values, triad, sampling_rate_hz, unit, run)
        for values, triad in ((true_acc, model.acc), (true_gyr + true_acc @ coupling.T, model.gyr))
    ]
    if model.delivery != AT_ONCE:
        readings = model.delivery.arrived(readings, way)
    kept = run.random(count) >= model.dropped_share
    return SensorOutput(stated[kept], true[kept], Imu(readings[0][kept], readings[1][kept]))


def without(model: SensorModel, *names: str) -> SensorModel:
    """Model with some of its errors switched off, for an ablation.

    Parameters
    ----------
    model : SensorModel
    names : fields of SensorModel, or of both triads

    Returns
    -------
    SensorModel

    Raises
    ------
    InputError
        If a name is not an error of the model.

    Examples
    --------
    >>> without(MTI_1, "noise_density", "g_sensitivity_sd").acc.noise_density
    0.0
    """
    expect("model", model, SensorModel)
    clean = Triad()
    for name in names:
        expect("name", name, str)
        if name in Triad.__dataclass_fields__:
            off = {name: getattr(clean, name)}
            if name == "full_scale":
                off["bits"] = 0
            model = replace(model, acc=replace(model.acc, **off), gyr=replace(model.gyr, **off))
        elif name in SensorModel.__dataclass_fields__ and name not in ("acc", "gyr"):
            model = replace(model, **{name: getattr(IDEAL, name)})
        else:
            raise InputError(f"{name!r} is not an error of the sensor model")
    return model


def _low_pass(values: FloatArray, corner_hz: float, sampling_rate_hz: float) -> FloatArray:
    if corner_hz >= sampling_rate_hz / 2:
        return values
    sections = signal.butter(2, corner_hz, fs=sampling_rate_hz, output="sos")
    start = signal.sosfilt_zi(sections)[:, :, None] * values[0]
    return np.asarray(signal.sosfilt(sections, values, axis=0, zi=start)[0])


def _read(
    values: FloatArray,
    triad: Triad,
    sampling_rate_hz: float,
    unit: np.random.Generator,
    run: np.random.Generator,
) -> FloatArray:
    """One triad: scale, misalignment, biases, noise, range and rounding."""
    count = len(values)
    mixing = triad.misalignment_sd_rad * unit.standard_normal((3, 3))
    np.fill_diagonal(mixing, 1 + triad.scale_sd * unit.standard_normal(3))
    reading = values @ mixing.T + triad.turn_on_bias_sd * run.standard_normal(3)
    wander = run.standard_normal((count, 3))
    if triad.bias_instability > 0:
        keep = np.exp(-1 / (sampling_rate_hz * triad.bias_time_s))
        drive = triad.bias_instability * np.sqrt(1 - keep**2)
        first = triad.bias_instability * wander[:1]
        later, _ = signal.lfilter([drive], [1, -keep], wander[1:], axis=0, zi=keep * first)
        reading = reading + np.concatenate([first, later])
    reading = reading + triad.noise_density * np.sqrt(sampling_rate_hz) * run.standard_normal(
        (count, 3)
    )
    reading = np.clip(reading, -triad.full_scale, triad.full_scale)
    if triad.bits:
        step = 2 * triad.full_scale / 2**triad.bits
        reading = np.round(reading / step) * step
    if triad.step:
        reading = np.round(reading / triad.step) * triad.step
    return np.asarray(reading)
