"""Whether the sensors of a scooter agree with each other, whatever its controls do.

Lever and body are joined by two hinges. Three things must then hold. About the axis at right angles
to both hinges nothing turns but the whole scooter: there both gyroscopes read the same
(``fusion.locked_rate`` is their difference). What the hinges' rates add
up to is how far the angles of the closed form move, for the steering and for the throttle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.hinges import column_vector, steered, turn
from mobility_imu.scooter.angles import estimate_angles
from mobility_imu.scooter.geometry import ScooterGeometry

__all__ = [
    "Agreement",
    "AxisMotions",
    "Lag",
    "Motion",
    "Seen",
    "Twist",
    "agreement",
    "axis_motions",
    "lag_between",
    "motion_of",
    "seen_by",
    "twist_between",
]

MEAN_S = 0.5
"""Accelerations are averaged over this before the closed form is taken: blows and vibration last
shorter, a turn of the controls longer."""
RATE_MEAN_S = 0.05
"""Rates are averaged over this before they are compared: one sample of each is noise."""
LEAST_VALID = 0.5
"""Part of the samples that the closed form has to trust; below it nothing is judged."""
LONGEST_LAG_S = 2.0
"""Lags up to this are looked for."""


SHAKING_HZ = (1.0, 15.0)
"""Rolling and pitching on the ground's bumps; controls are steered more slowly."""
SHORTEST_SHAKING_S = 5.0


class Seen(NamedTuple):
    """Angles of the averaged accelerations, and where they can be trusted.

    Parameters
    ----------
    steering_rad, throttle_rad : (n,) arrays, rad, continuous
    good : (n,) bool array
    """

    steering_rad: FloatArray
    throttle_rad: FloatArray
    good: NDArray[np.bool_]

    @property
    def enough(self) -> bool:
        """Whether most samples can be trusted."""
        return bool(self.good.mean() >= LEAST_VALID)


class Twist(NamedTuple):
    """By how much the closed form's steering is ahead of what both gyroscopes show.

    Parameters
    ----------
    angle_rad, sd_rad : rad
    explained : part of the lever's rate about the locked axis that the body's rates explain
    """

    angle_rad: float
    sd_rad: float
    explained: float


class Motion(NamedTuple):
    """What the gyroscopes say of the hinges and of the whole scooter.

    Parameters
    ----------
    lever_locked, body_locked : (n,) arrays, rad/s, each sensor's rate about the axis at right
        angles to both hinges
    steering_rad, throttle_rad : (n,) arrays, rad, integrals of the hinges' rates from 0, without
        their means
    means_radps : (3,) array, rad/s, what was taken off: the mean rates of steering and throttle,
        and of the lever against the body about the locked axis
    turning_radps : rad/s, root mean square of the lever's rate about its mean, of all three axes
    """

    lever_locked: FloatArray
    body_locked: FloatArray
    steering_rad: FloatArray
    throttle_rad: FloatArray
    means_radps: FloatArray
    turning_radps: float


class Agreement(NamedTuple):
    """How well two sensors agree; each misfit in units of what usual errors leave.

    Parameters
    ----------
    locked, steering, throttle : misfits; 1 is usual
    correlation : of both rates about the locked axis
    """

    locked: float
    steering: float
    throttle: float
    correlation: float

    @property
    def squared(self) -> float:
        """Sum of the squared misfits; 3 is usual at most."""
        return self.locked**2 + self.steering**2 + self.throttle**2


class Lag(NamedTuple):
    """By how much the lever comes later than the body.

    Parameters
    ----------
    lag_s : s
    sd_s : s
    correlation : at that lag
    """

    lag_s: float
    sd_s: float
    correlation: float


def _averaged(values: FloatArray, seconds: float, rate_hz: float) -> FloatArray:
    """Means over a time, centred."""
    return np.asarray(ndimage.uniform_filter1d(values, max(1, round(seconds * rate_hz)), axis=0))


def seen_by(
    lever_acc: FloatArray,
    body_acc: FloatArray,
    rate_hz: float,
    geometry: ScooterGeometry,
    mean_s: float = MEAN_S,
) -> Seen:
    """Angles of the closed form, of averaged accelerations.

    Parameters
    ----------
    lever_acc, body_acc : (n, 3) arrays, m/s², in {T} and {B}
    rate_hz : Hz
    geometry : ScooterGeometry
    mean_s : s, time that they are averaged over

    Returns
    -------
    Seen

    Raises
    ------
    InputError
        If gravity is missing or points the wrong way.
    """
    lever, body = (_averaged(acc, mean_s, rate_hz) for acc in (lever_acc, body_acc))
    found = estimate_angles(lever, body, geometry)
    good = found.valid & np.isfinite(found.steering_rad)
    # A sample that is not trusted may lie a turn away: only its neighbours' turns are followed.
    steering, throttle = (
        np.unwrap(np.nan_to_num(angle)) for angle in (found.steering_rad, found.throttle_rad)
    )
    return Seen(steering, throttle, good)


def motion_of(
    lever_gyr: FloatArray,
    body_gyr: FloatArray,
    seen: Seen,
    rate_hz: float,
    geometry: ScooterGeometry,
) -> Motion:
    """Rates about the locked axis, and what the hinges' rates add up to.

    Parameters
    ----------
    lever_gyr, body_gyr : (n, 3) arrays, rad/s, in {T} and {B}
    seen : Seen
    rate_hz : Hz
    geometry : ScooterGeometry

    Returns
    -------
    Motion
    """
    column = column_vector(body_gyr, geometry.steering_inclination_rad)
    beside, ahead = steered(column, seen.steering_rad)
    tip = seen.throttle_rad + geometry.lean_rad
    across, shaft = turn(lever_gyr[:, 1], lever_gyr[:, 2], np.sin(tip), np.cos(tip))
    rates = (shaft - column.k1, beside - lever_gyr[:, 0], across - ahead)
    means = np.array([rate.mean() for rate in rates])
    steering, throttle = (np.cumsum(rates[k] - means[k]) / rate_hz for k in range(2))
    locked = [_averaged(r - r.mean(), RATE_MEAN_S, rate_hz) for r in (across, ahead)]
    turning = float(np.sqrt(lever_gyr.var(axis=0).sum()))
    return Motion(locked[0], locked[1], steering, throttle, means, turning)


LOCKED_FRACTION, LOCKED_RADPS, LOCKED_OF_ALL = 0.25, 0.01, 0.03
"""Usual misfit about the locked axis: a quarter of the scooter's own turning (mounts that are off
by some degrees), flexing, and the part of the lever's whole rate that crossed axes of 2 deg let
through."""
STEERING_FRACTION, STEERING_RAD = 0.25, float(np.deg2rad(4.0))
"""Usual misfit of the steering: a quarter of its own motion, for a mount that is off by 1 deg bends
the closed form by 3 deg and its gain by a fifth; and what accelerations in a curve do."""
THROTTLE_FRACTION, THROTTLE_RAD = 0.1, float(np.deg2rad(2.0))
"""The same of the throttle, which gravity shows three times as well."""


def agreement(seen: Seen, motion: Motion) -> Agreement:
    """How well two sensors agree.

    Parameters
    ----------
    seen : Seen
    motion : Motion

    Returns
    -------
    Agreement
    """
    good = seen.good
    return _agreement(
        motion.lever_locked[good],
        motion.body_locked[good],
        (_detrended(motion.steering_rad, good), _detrended(motion.throttle_rad, good)),
        (_detrended(seen.steering_rad, good), _detrended(seen.throttle_rad, good)),
        turning_radps=motion.turning_radps,
        samples=int(good.sum()),
    )


def _agreement(
    lever: FloatArray,
    body: FloatArray,
    by_rates: tuple[FloatArray, FloatArray],
    by_acc: tuple[FloatArray, FloatArray],
    *,
    turning_radps: float,
    samples: int,
) -> Agreement:
    """Agreement of both rates about the locked axis, and of steering and throttle about a line.

    Only lengths and products of the series enter: other coordinates of them will do.
    """

    def size(series: FloatArray) -> float:
        return float(np.sqrt(series @ series / samples))

    turns = size(body)
    usual = np.hypot(LOCKED_FRACTION * turns, np.hypot(LOCKED_RADPS, LOCKED_OF_ALL * turning_radps))
    locked = size(lever - body) / float(usual)
    product = size(lever) * turns
    both = float(lever @ body / samples)
    steering, throttle = (
        size(rates - angles) / float(np.hypot(fraction * size(angles), least))
        for rates, angles, fraction, least in (
            (by_rates[0], by_acc[0], STEERING_FRACTION, STEERING_RAD),
            (by_rates[1], by_acc[1], THROTTLE_FRACTION, THROTTLE_RAD),
        )
    )
    return Agreement(locked, steering, throttle, both / product if product > 0 else 0.0)


def _detrended(values: FloatArray, good: NDArray[np.bool_]) -> FloatArray:
    """Values of the good samples without the line through them: an unknown offset is no misfit."""
    place, chosen = np.flatnonzero(good).astype(float), values[good]
    place, chosen = place - place.mean(), chosen - chosen.mean()
    return np.asarray(chosen - place * (place @ chosen) / max(float(place @ place), 1.0))


class AxisMotions(NamedTuple):
    """What each axis of both gyroscopes adds to what is compared, which is linear in the rates.

    The series have as many coordinates as there are columns, in place of samples: those of an
    orthonormal base (QR), which leaves their lengths and products as they are.

    Parameters
    ----------
    locked : (6, 6) array, rad/s, rates about the locked axis: columns of the lever, then the body
    steering, throttle : (7, 7) arrays, rad, without the lines through them; the last column has the
        angle of the closed form
    turning_radps : (3,) array, rad/s, of the lever's axes
    samples : number of them
    """

    locked: FloatArray
    steering: FloatArray
    throttle: FloatArray
    turning_radps: FloatArray
    samples: int

    def agreement(self, factors: FloatArray) -> Agreement:
        """How well two sensors agree whose gyroscopes are multiplied.

        Parameters
        ----------
        factors : (6,) array, of the lever's axes, then the body's

        Returns
        -------
        Agreement
        """
        return _agreement(
            self.locked[:, :3] @ factors[:3],
            self.locked[:, 3:] @ factors[3:],
            (self.steering[:, :6] @ factors, self.throttle[:, :6] @ factors),
            (self.steering[:, 6], self.throttle[:, 6]),
            turning_radps=float(np.linalg.norm(self.turning_radps * factors[:3])),
            samples=self.samples,
        )


def axis_motions(seen: Seen, motions: Sequence[Motion]) -> AxisMotions:
    """What each axis of both gyroscopes adds to what is compared.

    Parameters
    ----------
    seen : Seen
    motions : six, each of one axis alone: those of the lever, then the body's

    Returns
    -------
    AxisMotions
    """
    good, lever, body = seen.good, motions[:3], motions[3:]

    def coordinates(columns: Sequence[FloatArray]) -> FloatArray:
        return np.asarray(np.linalg.qr(np.column_stack(columns), mode="r"))

    def about_lines(series: Sequence[FloatArray]) -> list[FloatArray]:
        return [_detrended(values, good) for values in series]

    return AxisMotions(
        coordinates([*(m.lever_locked[good] for m in lever), *(m.body_locked[good] for m in body)]),
        coordinates(about_lines([*(m.steering_rad for m in motions), seen.steering_rad])),
        coordinates(about_lines([*(m.throttle_rad for m in motions), seen.throttle_rad])),
        np.array([m.turning_radps for m in lever]),
        int(good.sum()),
    )


def lag_between(motion: Motion, good: NDArray[np.bool_], rate_hz: float) -> Lag:
    """Lag of the lever behind the body, by the rates about the locked axis.

    The standard deviation is that of the peak of a correlation: of white noise n beside a signal s,
    ``var = (n² / s'²) / N`` with the signal's derivative s', here of both together.

    Parameters
    ----------
    motion : Motion
    good : (n,) bool array, samples whose angles can be trusted; rates are 0 elsewhere
    rate_hz : Hz

    Returns
    -------
    Lag
    """
    low, high = SHAKING_HZ[0], min(SHAKING_HZ[1], 0.4 * rate_hz)
    if low >= high or good.sum() < SHORTEST_SHAKING_S * rate_hz:
        return Lag(0.0, np.inf, 0.0)
    # A mount that is off bends slow turns, which shifts their peak: fast ones are exact.
    lever, body = (
        _between(rates, low, high, rate_hz) * good
        for rates in (motion.lever_locked, motion.body_locked)
    )
    longest = min(round(LONGEST_LAG_S * rate_hz), len(lever) // 4)
    size = 2 ** int(np.ceil(np.log2(len(lever) + longest + 1)))
    spectra = np.fft.rfft(lever, size) * np.conj(np.fft.rfft(body, size))
    product = np.fft.irfft(spectra, size)
    product = np.r_[product[-longest:], product[: longest + 1]]
    norm = float(np.sqrt((lever**2).sum() * (body**2).sum()))
    if norm == 0:
        return Lag(0.0, np.inf, 0.0)
    top = int(np.argmax(product))
    shift = 0.0
    if 0 < top < len(product) - 1:
        before, at, after = product[top - 1 : top + 2]
        shift = float(0.5 * (before - after) / min(before - 2 * at + after, -1e-300))
    best = float(product[top]) / norm
    left = np.sqrt(max(2 * (1 - best), 1e-6)) * rms(body)
    slope = rms(np.diff(body)) * rate_hz
    # Rates that were averaged have a new error only so often.
    fresh = len(body) / max(1.0, RATE_MEAN_S * rate_hz)
    sd = left / max(slope, 1e-12) / np.sqrt(fresh)
    return Lag((top - longest + shift) / rate_hz, float(sd), best)


def twist_between(
    lever_gyr: FloatArray,
    body_gyr: FloatArray,
    seen: Seen,
    rate_hz: float,
    geometry: ScooterGeometry,
) -> Twist | None:
    """Error of the closed form's steering, by the shaking that both gyroscopes feel.

    About the locked axis the lever turns as the body does, ``ahead``. A steering that is off by p
    mixes in the rate beside it: ``across = cos(p) ahead + sin(p) beside``, which two regressors
    find. Rolling and pitching on uneven ground is what shows it, so slow motion is left out.

    Parameters
    ----------
    lever_gyr, body_gyr : (n, 3) arrays, rad/s, in {T} and {B}
    seen : Seen
    rate_hz : Hz
    geometry : ScooterGeometry

    Returns
    -------
    Twist; None for a recording that is too short or too slow
    """
    low, high = SHAKING_HZ[0], min(SHAKING_HZ[1], 0.4 * rate_hz)
    if low >= high or seen.good.sum() < SHORTEST_SHAKING_S * rate_hz:
        return None
    column = column_vector(body_gyr, geometry.steering_inclination_rad)
    beside, ahead = steered(column, seen.steering_rad)
    tip = seen.throttle_rad + geometry.lean_rad
    across, _ = turn(lever_gyr[:, 1], lever_gyr[:, 2], np.sin(tip), np.cos(tip))
    shaking = _between(np.column_stack([across, ahead, beside]), low, high, rate_hz)[seen.good]
    seen_by_lever, by_body = shaking[:, 0], shaking[:, 1:]
    normal = by_body.T @ by_body
    if np.linalg.det(normal) <= 0:
        return None
    gains = np.linalg.solve(normal, by_body.T @ seen_by_lever)
    left = seen_by_lever - by_body @ gains
    # Neighbours within the band are alike: fewer of them are new.
    alike = max(1.0, rate_hz / (2 * high))
    sd = np.sqrt(np.mean(left**2) * np.linalg.inv(normal)[1, 1] * alike)
    explained = 1 - float(np.sum(left**2) / max(float(np.sum(seen_by_lever**2)), 1e-30))
    size = float(np.hypot(*gains))
    return Twist(float(np.arctan2(gains[1], gains[0])), float(sd) / max(size, 1e-9), explained)


def _between(values: FloatArray, low_hz: float, high_hz: float, rate_hz: float) -> FloatArray:
    """What lies between two frequencies, along the first axis."""
    from scipy import signal  # takes half a second to load

    band = signal.butter(2, [low_hz, high_hz], "band", fs=rate_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(band, values, axis=0))
