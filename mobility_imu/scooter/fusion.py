"""Steering and throttle angles from accelerometers and gyroscopes together.

The controls are hinges: what the lever's gyroscope reads beyond the body's is their motion. An
extended Kalman filter integrates that, corrects it with eq. 5 sample by sample, and learns what is
constant: offsets, scales and misalignments of the sensors, and the lever arms between. A smoother
(Rauch-Tung-Striebel) lets each angle use the whole recording; a simpler filter is the baseline.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu._compiled import choose, compiled
from mobility_imu.arguments import check_columns, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_number, as_vectors, one_of
from mobility_imu.hinges import column_vector, hinge_rates, steered
from mobility_imu.results import Result
from mobility_imu.scooter.angles import check_gravity, three_axis_angles
from mobility_imu.scooter.fusion_constants import constant_deviations, unlikely_constant
from mobility_imu.scooter.fusion_filter import (
    BODY,
    CONSTANTS,
    STATES,
    Chunk,
    Estimate,
    Inputs,
    Model,
    plain,
    run_filter,
    run_smoother,
)
from mobility_imu.scooter.fusion_noise import (
    acceleration_noise,
    added_variance,
    bounded_and_wandering,
    check_largest,
    smallest_step,
    smoothed,
    trust,
    white_and_coloured,
)
from mobility_imu.scooter.fusion_settings import (
    FROM_THE_RECORDING,
    SETTING_LIMITS,
    SMALLEST_DISTURBANCE_MPS2,
    SMALLEST_RATE_NOISE,
    FusionSettings,
)
from mobility_imu.scooter.geometry import ScooterGeometry, lever_acceleration

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "FusedAngles",
    "FusionSettings",
    "complementary_angles",
    "fuse_angles",
    "locked_rate",
    "move_specific_force",
]

SPIN_SMOOTHING_S = 0.02
"""Width of the Gaussian over which the rates' derivatives are taken, and the accelerations."""
LARGEST_VALID_SD_RAD = float(np.deg2rad(20.0))
"""Standard deviation of the steering from which a sample is not valid."""
SLOWEST_RATE_HZ = 10.0
"""Sampling rate below which the rates cannot be integrated; the controls turn within 0.1 s."""
FASTEST_RATE_HZ = 1e6
"""Sampling rate beyond which no such sensor measures; filters over it would fill the memory."""
LARGEST_ACC_MPS2 = 2000.0
"""Largest component of an acceleration, m/s²; beyond what such sensors measure (200 g)."""
LARGEST_RATE_RADPS = 100.0
"""Largest component of a rate, rad/s; beyond what such sensors measure (4000 deg/s is 70)."""
LONGEST_ARM_M = 1000.0
"""Largest component of a lever arm, m, that a rigid body may have."""
NARROWEST, WIDEST = 1e-3, 1e6
"""Widths of the Gaussian of a derivative, in samples."""
START_SD_RAD = 0.35
"""How far the first angles may be off."""
PLAIN_S_PER_SAMPLE = 3e-4
"""Seconds that both passes take for a sample where nothing is compiled."""
CHUNK_SAMPLES = 20_000
"""Samples of which the smoother keeps everything at once; for more the filter runs again."""


@dataclass(frozen=True, eq=False, repr=False)
class FusedAngles(Result):
    """Angles of the filter with their standard deviations.

    Parameters
    ----------
    steering_rad, throttle_rad : (n,) arrays, rad
    steering_sd_rad, throttle_sd_rad : (n,) arrays, rad, one standard deviation: noise, errors of
        the sensors and of their mounting, flexing, and the clock
    valid : (n,) bool array: the numbers are finite, and the sd of the steering is below
        ``LARGEST_VALID_SD_RAD``
    settings : FusionSettings, with what was taken from the recording
    warnings : sentences for the user

    Raises
    ------
    InputError
        Columns that are no series of one length, or other fields of a wrong kind.
    """

    steering_rad: FloatArray
    throttle_rad: FloatArray
    steering_sd_rad: FloatArray
    throttle_sd_rad: FloatArray
    valid: NDArray[np.bool_]
    settings: FusionSettings
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check every field."""
        angles = ("steering_rad", "throttle_rad", "steering_sd_rad", "throttle_sd_rad")
        check_columns(self, *angles, flags=("valid",))
        check_fields(self, settings=FusionSettings)
        super().__post_init__()

    def to_frame(self) -> pd.DataFrame:
        """Table in degrees with steering_deg, throttle_deg, their sd, and valid."""
        import pandas as pd

        return pd.DataFrame(
            {
                "steering_deg": np.rad2deg(self.steering_rad),
                "throttle_deg": np.rad2deg(self.throttle_rad),
                "steering_sd_deg": np.rad2deg(self.steering_sd_rad),
                "throttle_sd_deg": np.rad2deg(self.throttle_sd_rad),
                "valid": self.valid,
            }
        )


class _Readings(NamedTuple):
    """Contiguous (n, 3) arrays of all four sensors, checked."""

    lever_acc: FloatArray
    lever_gyr: FloatArray
    body_acc: FloatArray
    body_gyr: FloatArray


def move_specific_force(
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    arm_m: ArrayLike,
    sampling_rate_hz: float,
    *,
    smoothing_s: float = 0.02,
) -> FloatArray:
    """Specific force at another place of the same rigid body: Euler and centripetal terms added.

    Parameters
    ----------
    acc_mps2, gyr_radps : (n, 3) arrays, m/s² and rad/s, in the body's axes
    arm_m : (3,) array, m, from the sensor to the other place
    sampling_rate_hz : Hz
    smoothing_s : s, Gaussian smoothing of the derivative of the rate

    Returns
    -------
    (n, 3) array, m/s²

    Raises
    ------
    InputError
        If the arrays differ in shape or hold numbers that no such sensor measures, a number is not
        positive, or the smoothing is far narrower than a sample or wider than any recording.
    """
    acc = as_vectors(acc_mps2, "acc_mps2", ndim=2)
    gyr = as_vectors(gyr_radps, "gyr_radps", length=len(acc))
    arm = as_vectors(arm_m, "arm_m", ndim=1)
    check_largest(acc, "acc_mps2", LARGEST_ACC_MPS2)
    check_largest(gyr, "gyr_radps", LARGEST_RATE_RADPS)
    check_largest(arm, "arm_m", LONGEST_ARM_M)
    rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    smoothing = as_number(smoothing_s, "smoothing_s")
    width = smoothing * rate_hz
    if not NARROWEST <= width <= WIDEST:
        raise InputError(
            f"smoothing_s = {smoothing:g}: expected {NARROWEST:g} to {WIDEST:g} samples at "
            f"sampling_rate_hz = {rate_hz:g}"
        )
    spin_up = ndimage.gaussian_filter1d(gyr, width, axis=0, order=1)
    euler = np.cross(spin_up * rate_hz, arm)
    return acc + euler + np.cross(gyr, np.cross(gyr, arm))


def fuse_angles(
    lever_acc_mps2: ArrayLike,
    lever_gyr_radps: ArrayLike,
    body_acc_mps2: ArrayLike,
    body_gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
    settings: FusionSettings | None = None,
    *,
    smooth: bool = True,
) -> FusedAngles:
    """Angles by an extended Kalman filter and, unless ``smooth=False``, an RTS smoother.

    State: steering, throttle, drift of both hinges' rates, and a coloured disturbance of the
    acceleration; beside it the constants of :class:`FusionSettings`, which it learns as far as the
    recording shows them, and whose uncertainty stays in the angles' as far as it does not. A first
    pass finds the sizes that the settings leave to the recording, and the shocks. Before the second
    the accelerations are smoothed as the rates' derivatives are, without the shocks. The filter
    starts from the median of the first half second: the scooter should be still there, or steered
    slowly.

    Parameters
    ----------
    lever_acc_mps2, lever_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {T}, all finite
    body_acc_mps2, body_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {B}, all finite
    sampling_rate_hz : Hz, even samples, from ``SLOWEST_RATE_HZ`` to ``FASTEST_RATE_HZ``
    geometry : ScooterGeometry
    settings : FusionSettings; None is the default, with the noises taken from the recording
    smooth : whether each angle uses the whole recording; False uses the past only, and states a
        standard deviation that is too small, by 1.7 in simulated rides of 20 s

    Returns
    -------
    FusedAngles
        ``valid`` is true where the numbers are finite and the steering's standard deviation is
        below ``LARGEST_VALID_SD_RAD``. It cannot see a sensor that is frozen, saturated or
        turned.

    Raises
    ------
    InputError
        Arrays of different shapes, without samples, with numbers that are not finite or that no
        such sensor measures; a sampling rate that is too low or too high; accelerations in g, or
        with gravity in the wrong direction, or 0 in the first half second.
    """
    settings = settings_or_default("settings", settings, FusionSettings)
    one_of("smooth", smooth, (False, True))
    readings, rate_hz = _checked(
        lever_acc_mps2, lever_gyr_radps, body_acc_mps2, body_gyr_radps, sampling_rate_hz, geometry
    )
    inputs = _inputs(readings, rate_hz, smooth)
    run = _loops(inputs, geometry, rate_hz)
    if smooth or not settings.complete:
        first = _first_guess(settings, readings, rate_hz)
        seen = _filtered(run, inputs, first, geometry, rate_hz)
        settings = _measured(settings, first, seen, inputs, geometry, rate_hz)
    if smooth:
        inputs = _as_smooth_as_spins(inputs, seen, settings, geometry, rate_hz)
        angles, sd, constants = _smoothed(run, inputs, settings, geometry, rate_hz)
    else:
        angles, sd, _, constants = _filtered(run, inputs, settings, geometry, rate_hz)
    sd = np.sqrt(sd**2 + added_variance(angles, settings, rate_hz, past=not smooth))
    valid = np.isfinite(angles).all(axis=1) & (sd[:, 0] < LARGEST_VALID_SD_RAD)
    said = unlikely_constant(constants, settings)
    return FusedAngles(angles[:, 0], angles[:, 1], sd[:, 0], sd[:, 1], valid, settings, said)


class _Loops(NamedTuple):
    """Filter and smoother, compiled or plain."""

    run_filter: Callable[..., tuple[Chunk, Estimate]]
    run_smoother: Callable[..., tuple[FloatArray, ...]]


class _Seen(NamedTuple):
    """What a pass of the filter leaves: angles, their sd, residuals, and the constants."""

    angles: FloatArray
    sd: FloatArray
    residuals: FloatArray
    constants: FloatArray


def _inputs(readings: _Readings, rate_hz: float, smooth: bool) -> Inputs:
    """Readings with the derivatives of the rates; without smoothing they know the past only."""
    spins = []
    for gyr in (readings.lever_gyr, readings.body_gyr):
        if smooth:
            spin = ndimage.gaussian_filter1d(gyr, SPIN_SMOOTHING_S * rate_hz, axis=0, order=1)
        else:
            spin = np.diff(gyr, axis=0, prepend=gyr[:1])
        spins.append(np.ascontiguousarray(spin * rate_hz))
    return Inputs(*readings, *spins)


def _loops(inputs: Inputs, geometry: ScooterGeometry, rate_hz: float) -> _Loops:
    """Loops as machine code, if that is there or is worth its time, else as plain Python."""
    guess = FusionSettings(**dict.fromkeys(FROM_THE_RECORDING, 0.01))
    model, start = _model(guess, geometry, rate_hz), _start(inputs, guess, geometry, rate_hz)
    none = (inputs, 0, 0, start, model, False)
    empty = Chunk(
        np.empty((0, STATES)), np.empty((0, 2)), np.empty((0, 3)), np.empty((0, STATES, STATES)),
        np.empty((0, STATES)), np.empty((0, STATES, STATES)), np.empty((0, STATES, CONSTANTS)),
    )  # fmt: skip
    back = (empty, *start[:5])
    way = choose(
        {run_filter: none, run_smoother: back},
        plain_s=len(inputs.lever_acc) * PLAIN_S_PER_SAMPLE,
        what="scooter's fusion",
    )
    if way == "compiled":
        return _Loops(run_filter, run_smoother)
    return _Loops(plain(run_filter), plain(run_smoother))


def _first_guess(settings: FusionSettings, readings: _Readings, rate_hz: float) -> FusionSettings:
    """Settings for a first pass, from the lengths of the accelerations alone."""
    noise = acceleration_noise(readings.lever_acc, readings.body_acc)
    step = smallest_step(readings.lever_acc, readings.body_acc)
    guesses = (
        max(noise, settings.acc_step_mps2 or 0.0),
        step,
        max(SMALLEST_DISTURBANCE_MPS2, noise / 2),
        SMALLEST_RATE_NOISE,
        SETTING_LIMITS["flexing_sd_rad"][0],
        max(SETTING_LIMITS["clock_sd_s"][0], 0.5 / rate_hz),
    )
    missing = {
        name: guess
        for name, guess in zip(FROM_THE_RECORDING, guesses, strict=True)
        if getattr(settings, name) is None
    }
    return dataclasses.replace(settings, **missing)


def _measured(
    settings: FusionSettings,
    first: FusionSettings,
    seen: _Seen,
    inputs: Inputs,
    geometry: ScooterGeometry,
    rate_hz: float,
) -> FusionSettings:
    """Settings with what the residuals and the locked axis of a first pass show."""
    found: dict[str, float | None] = {}
    # While it learns the constants, the residuals are not yet noise.
    settled = seen.residuals[len(seen.residuals) // 10 :]
    noise = white_and_coloured(settled, rate_hz, settings.disturbance_time_s)
    if noise is not None:
        assert first.acc_step_mps2 is not None
        found["acc_sd_mps2"] = max(noise[0], first.acc_step_mps2)
        found["disturbance_sd_mps2"] = max(noise[1], SMALLEST_DISTURBANCE_MPS2)
    locked = locked_rate(inputs.lever_gyr, inputs.body_gyr, seen, geometry)
    angle, density = bounded_and_wandering(locked, rate_hz)
    found["flexing_sd_rad"] = max(angle, SETTING_LIMITS["flexing_sd_rad"][0])
    found["rate_noise_radps_sqrthz"] = max(density, SMALLEST_RATE_NOISE)
    changes = {}
    for name in FROM_THE_RECORDING:
        if getattr(settings, name) is None:
            low, high = SETTING_LIMITS[name]
            value = found.get(name) or getattr(first, name)
            changes[name] = float(np.clip(value, low, high))
    return dataclasses.replace(settings, **changes)


def locked_rate(
    lever_gyr: FloatArray, body_gyr: FloatArray, seen: _Seen, geometry: ScooterGeometry
) -> FloatArray:
    """Rate about the axis at right angles to both hinges: nothing can turn there but by flexing.

    Parameters
    ----------
    lever_gyr, body_gyr : (n, 3) arrays, rad/s, in {T} and {B}
    seen : angles and constants of a pass of the filter
    geometry : ScooterGeometry

    Returns
    -------
    (n,) array, rad/s
    """
    lever, body = (
        gyr - np.cross(c[6:9] + c[15:18], gyr) - c[9:12] * gyr - c[12:15]
        for gyr, c in ((lever_gyr, seen.constants), (body_gyr, seen.constants[BODY:]))
    )
    tip = seen.angles[:, 1] + geometry.lean_rad
    _, ahead = steered(column_vector(body, geometry.steering_inclination_rad), seen.angles[:, 0])
    return np.asarray(lever[:, 1] * np.cos(tip) + lever[:, 2] * np.sin(tip) - ahead)


def _as_smooth_as_spins(
    inputs: Inputs, seen: _Seen, settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float
) -> Inputs:
    """Inputs whose accelerations have the spins' Gaussian: else a lever arm explains too little."""
    assert settings.acc_sd_mps2 is not None
    at, width = (seen.angles[:, 0], seen.angles[:, 1]), SPIN_SMOOTHING_S * rate_hz
    weights = trust(seen.residuals, settings.huber * settings.acc_sd_mps2)
    # The body's readings are smoothed, too: its errors are multiples of them.
    body = smoothed(inputs.body_acc, weights, width)
    apart = inputs.lever_acc - lever_acceleration(inputs.body_acc, *at, geometry)
    apart = smoothed(apart - seen.residuals * (1 - weights), np.ones_like(weights), width)
    lever = lever_acceleration(body, *at, geometry) + apart
    return inputs._replace(lever_acc=np.ascontiguousarray(lever), body_acc=body)


def _model(settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float) -> Model:
    """Model of the loops; all that the recording tells is in the settings."""
    assert settings.acc_sd_mps2 is not None and settings.disturbance_sd_mps2 is not None
    assert settings.rate_noise_radps_sqrthz is not None
    alpha, dt = geometry.steering_inclination_rad, 1 / rate_hz
    return Model(
        dt,
        float(np.sin(alpha)),
        float(np.cos(alpha)),
        float(geometry.lean_rad),
        float(settings.acc_sd_mps2**2),
        float(settings.disturbance_sd_mps2**2),
        float(np.exp(-dt / settings.disturbance_time_s)),
        np.array([settings.rate_noise_radps_sqrthz**2 * dt, settings.bias_walk_radps**2 * dt]),
        float(settings.huber),
    )


def _start(
    inputs: Inputs, settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float
) -> Estimate:
    """What is assumed at the start: angles of the first half second, all constants zero."""
    assert settings.disturbance_sd_mps2 is not None
    angles, slow = _first_angles(inputs.lever_acc, inputs.body_acc, rate_hz, geometry)
    # The drift is what wanders: the offset it starts from is among the constants.
    sd = np.array([START_SD_RAD] * 2 + [1e-6] * 2 + [settings.disturbance_sd_mps2] * 3)
    return Estimate(
        np.concatenate((angles, np.zeros(STATES - 2))),
        np.diag(sd**2),
        np.zeros((STATES, CONSTANTS)),
        np.zeros(CONSTANTS),
        np.diag(constant_deviations(settings) ** 2),
        slow,
    )


def _filtered(
    run: _Loops, inputs: Inputs, settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float
) -> _Seen:
    """One pass of the filter over the recording."""
    start, model = _start(inputs, settings, geometry, rate_hz), _model(settings, geometry, rate_hz)
    chunk, after = run.run_filter(inputs, 0, len(inputs.lever_acc), start, model, False)
    return _Seen(chunk.states[:, :2].copy(), chunk.sd, chunk.residuals, after.constants)


def _smoothed(
    run: _Loops, inputs: Inputs, settings: FusionSettings, geometry: ScooterGeometry, rate_hz: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angles, their sd and the constants by filter and smoother, in pieces that fit into memory."""
    model = _model(settings, geometry, rate_hz)
    borders = [*range(0, len(inputs.lever_acc), CHUNK_SAMPLES), len(inputs.lever_acc)]
    pieces = list(pairwise(borders))
    at = [_start(inputs, settings, geometry, rate_hz)]
    for piece in pieces:
        kept, after = run.run_filter(inputs, *piece, at[-1], model, piece is pieces[-1])
        at.append(Estimate(*(np.ascontiguousarray(part) for part in after)))
    last = at[-1]
    state, covariance, by_constants = last.state, last.covariance, last.by_constants
    angles, sd = [], []
    for piece, before in zip(pieces[::-1], at[-2::-1], strict=True):
        if piece is not pieces[-1]:
            kept, _ = run.run_filter(inputs, *piece, before, model, True)
        given = (np.ascontiguousarray(part) for part in (state, covariance, by_constants))
        states, spread, state, covariance, by_constants = run.run_smoother(
            kept, *given, last.constants, last.constants_covariance
        )
        angles.append(states[:, :2])
        sd.append(spread)
    return np.concatenate(angles[::-1]), np.concatenate(sd[::-1]), last.constants


def _checked(
    lever_acc: ArrayLike,
    lever_gyr: ArrayLike,
    body_acc: ArrayLike,
    body_gyr: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
) -> tuple[_Readings, float]:
    """All readings as the compiled loops need them, and the sampling rate."""
    rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    if not SLOWEST_RATE_HZ <= rate_hz <= FASTEST_RATE_HZ:
        raise InputError(
            f"sampling_rate_hz = {rate_hz:g}: expected {SLOWEST_RATE_HZ:g} Hz or more, for rates "
            f"are integrated, and {FASTEST_RATE_HZ:g} at most (is the time in ms?)"
        )
    arrays = []
    for values, name, limit in (
        (lever_acc, "lever_acc_mps2", LARGEST_ACC_MPS2),
        (lever_gyr, "lever_gyr_radps", LARGEST_RATE_RADPS),
        (body_acc, "body_acc_mps2", LARGEST_ACC_MPS2),
        (body_gyr, "body_gyr_radps", LARGEST_RATE_RADPS),
    ):
        # A copy: a read-only array would be another type to the compiler.
        array = np.array(as_vectors(values, name, ndim=2, finite=True), order="C")
        check_largest(array, name, limit)
        arrays.append(array)
    readings = _Readings(*arrays)
    shapes = {array.shape for array in readings}
    if len(shapes) != 1 or not len(readings.lever_acc):
        raise InputError(
            f"accelerations and rates have shapes {sorted(shapes)}: expected all (n, 3), with one "
            "sample or more"
        )
    check_gravity(readings.lever_acc, readings.body_acc, geometry)
    return readings, rate_hz


def _first_angles(
    lever_acc: FloatArray, body_acc: FloatArray, rate_hz: float, geometry: ScooterGeometry
) -> tuple[FloatArray, FloatArray]:
    """Angles, and the body's acceleration, by the median of the first half second."""
    first = slice(0, max(1, round(0.5 * rate_hz)))
    lever, body = (np.median(acc[first], axis=0) for acc in (lever_acc, body_acc))
    off = [name for name, acc in (("lever", lever), ("body", body)) if not acc.any()]
    if off:
        raise InputError(f"{off[0]}_acc_mps2: is 0 from 0 to 0.5 s, where the angles start from")
    return np.array(three_axis_angles(lever, body, geometry), float), body


def complementary_angles(
    lever_acc_mps2: ArrayLike,
    lever_gyr_radps: ArrayLike,
    body_acc_mps2: ArrayLike,
    body_gyr_radps: ArrayLike,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
    *,
    time_constant_s: float = 1.5,
) -> tuple[FloatArray, FloatArray]:
    """Angles by a causal complementary filter: gyroscopes for the fast, eq. 5 for the slow.

    The hinges' rates, the lever's gyroscope less the body's, are integrated; the result is drawn to
    the angles of :func:`~mobility_imu.scooter.angles.three_axis_angles` from the raw accelerations
    with the time constant. It starts from the median of the first half second: start at rest.

    Parameters
    ----------
    lever_acc_mps2, lever_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {T}
    body_acc_mps2, body_gyr_radps : (n, 3) arrays, m/s² and rad/s, in {B}
    sampling_rate_hz : Hz
    geometry : ScooterGeometry
    time_constant_s : s. A bias of b rad/s between the gyroscopes leaves b * time_constant_s. At
        1.5 s the 0.3 deg/s of a usual gyroscope costs about half a degree; a shorter one lets more
        of the shaking through.

    Returns
    -------
    steering_rad, throttle_rad : (n,) arrays, rad

    Raises
    ------
    InputError
        As :func:`fuse_angles`, and if the time constant is no positive number.
    """
    time_constant = as_number(time_constant_s, "time_constant_s")
    readings, rate_hz = _checked(
        lever_acc_mps2, lever_gyr_radps, body_acc_mps2, body_gyr_radps, sampling_rate_hz, geometry
    )
    start, _ = _first_angles(readings.lever_acc, readings.body_acc, rate_hz, geometry)
    slow = np.column_stack(three_axis_angles(readings.lever_acc, readings.body_acc, geometry))
    out = _complement(
        slow, readings.lever_gyr, readings.body_gyr, start, 1 / rate_hz, time_constant,
        geometry.steering_inclination_rad, geometry.lean_rad,
    )  # fmt: skip
    return out[:, 0], out[:, 1]


@compiled()
def _complement(
    slow: FloatArray,
    lever_gyr: FloatArray,
    body_gyr: FloatArray,
    start: FloatArray,
    dt: float,
    time_constant: float,
    alpha: float,
    lean: float,
) -> FloatArray:
    """Integrated rates of the hinges, drawn to the slow angles with the time constant."""
    out = np.empty_like(slow)
    ca, sa = np.cos(alpha), np.sin(alpha)
    gain = dt / (time_constant + dt)
    s, t = start[0], start[1]
    for k in range(len(slow)):
        if k > 0:
            gt, gb = (lever_gyr[k] + lever_gyr[k - 1]) / 2, (body_gyr[k] + body_gyr[k - 1]) / 2
            rate_s, rate_t, _, _ = hinge_rates(gt, gb, s, t + lean, sa, ca)
            s += dt * rate_s
            t += dt * rate_t
        # Shortest way round: a blow may throw the slow angle across +-180 deg.
        s += gain * ((slow[k, 0] - s + np.pi) % (2 * np.pi) - np.pi)
        t += gain * ((slow[k, 1] - t + np.pi) % (2 * np.pi) - np.pi)
        out[k, 0], out[k, 1] = s, t
    return out
