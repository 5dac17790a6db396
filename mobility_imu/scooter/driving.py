"""From the recording of a ride to both angles, as the paper does it (section 2.5), and baselines.

The paper's order: keep what was recorded in motion, by the Hall pulses of a rear wheel; smooth the
accelerations with a median of 25 samples; apply eqs. 6 and 7. Its reference runs on a second
logger, whose clock is found by the same pulses. Two simple alternatives stand beside it: to
subtract the body's acceleration from the lever's, and a complementary filter with the gyroscopes.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.filters import median_filter
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_series, as_vectors
from mobility_imu.scooter.angles import steering_angle, three_axis_angles, throttle_angle
from mobility_imu.scooter.geometry import ScooterGeometry

PAPER_MEDIAN_WINDOW = 25
"""Samples in the paper's window; MATLAB's "order" of a median is its width, 0.25 s at 100 Hz."""


class ClockOffset(NamedTuple):
    """How far one clock is ahead of another.

    Parameters
    ----------
    offset_s : s, reference clock minus own clock
    matched : number of pulses that support it
    """

    offset_s: float
    matched: int


class ClippedAngles(NamedTuple):
    """Angles by the printed formulas, and where an arcsine had to be clipped.

    Parameters
    ----------
    steering_rad, throttle_rad : (n,) arrays, rad
    clipped : (n,) bool array, true where no angle explains the reading
    """

    steering_rad: FloatArray
    throttle_rad: FloatArray
    clipped: NDArray[np.bool_]


def moving_samples(
    time_s: ArrayLike, pulses_s: ArrayLike, *, longest_gap_s: float
) -> NDArray[np.bool_]:
    """Tell which samples were recorded in motion: those between two pulses that follow soon.

    The paper extracts "the data recorded during motion based on the signal from the Hall sensor"
    and says no more. A longest gap between pulses is our reading of it. Motion before the first
    and after the last pulse of a ride, up to one pulse's way each, is lost.

    Parameters
    ----------
    time_s : (n,) array, s
    pulses_s : (m,) array, s, on the same clock
    longest_gap_s : s; two pulses further apart have a standstill between them. The way from pulse
        to pulse divided by this is the slowest speed that counts as motion.

    Returns
    -------
    (n,) bool array

    Raises
    ------
    InputError
        If the pulses are not in order, or the gap is not positive.

    Examples
    --------
    >>> moving_samples([0, 1, 2, 3, 4, 5], [0.9, 2.1, 4.8], longest_gap_s=1.5).tolist()
    [False, True, True, False, False, False]
    """
    time, pulses = as_series(time_s, "time_s"), _pulses(pulses_s, "pulses_s", 0)
    if not longest_gap_s > 0:
        raise InputError(f"longest_gap_s = {longest_gap_s}: expected a positive time")
    if len(pulses) < 2:
        return np.zeros(len(time), bool)
    after = np.searchsorted(pulses, time, side="right")
    inside = (after > 0) & (after < len(pulses))
    gaps = np.diff(pulses)[np.clip(after - 1, 0, len(pulses) - 2)]
    return inside & (gaps <= longest_gap_s)


def synchronise(
    pulses_s: ArrayLike, reference_pulses_s: ArrayLike, *, tolerance_s: float = 0.02
) -> ClockOffset:
    """Find the offset of a second clock from the pulses that both loggers saw.

    Every pair of pulses proposes an offset. The one proposed most often, within the tolerance, is
    taken, and the median of its proposals returned: a pulse that one logger missed, or saw twice,
    does no harm. At constant speed a shift by one pulse fits almost as well; starting and stopping
    tell them apart.

    Parameters
    ----------
    pulses_s : (m,) array, s, on our clock
    reference_pulses_s : (k,) array, s, on the reference's clock
    tolerance_s : s, width of the window in which proposals count as one: the sampling interval of
        the slower logger and some reserve for drift

    Returns
    -------
    ClockOffset
        ``reference_time - offset_s`` is on our clock. A logger that samples sees a pulse up to one
        sample late, on average half of it: that stays in the offset.

    Raises
    ------
    InputError
        With fewer than three pulses on a side, or if another offset fits as well.

    Examples
    --------
    >>> ours = np.array([1.0, 2.0, 2.7, 3.3, 4.1])
    >>> offset = synchronise(ours, np.delete(ours, 1) + 12.5)
    >>> round(offset.offset_s, 3), offset.matched
    (12.5, 4)
    """
    ours = _pulses(pulses_s, "pulses_s", 3)
    theirs = _pulses(reference_pulses_s, "reference_pulses_s", 3)
    proposed = np.sort((theirs[:, None] - ours[None, :]).ravel())
    ends = np.searchsorted(proposed, proposed + tolerance_s, side="right")
    votes = ends - np.arange(len(proposed))
    best = int(np.argmax(votes))
    offset = float(np.median(proposed[best : ends[best]]))
    elsewhere = np.abs(proposed - offset) > 2 * tolerance_s
    rival = int(votes[elsewhere].max(initial=0))
    if votes[best] < 3 or rival >= votes[best]:
        raise InputError(
            f"pulses_s and reference_pulses_s: {votes[best]} of {len(ours)} pulses match at "
            f"{offset:.3f} s, {rival} at another offset: no one offset fits (constant speed all "
            "the way, or pulses of two rides?)"
        )
    return ClockOffset(offset, int(votes[best]))


def subtract_body(lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike) -> FloatArray:
    """Subtract what the body's IMU reads beyond gravity from the lever's, axis by axis.

    The compensation of the paper's reference 37, as section 4 describes it; the angles then follow
    from the single-IMU equations. It takes the axes of {T} and {B} for parallel: right only with
    both controls at beta = 0 and at rest, and the more wrong the further they are turned.

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², in {T}
    body_acc_mps2 : (..., 3) array, m/s², in {B}

    Returns
    -------
    (..., 3) array, m/s²
    """
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2")
    body = as_vectors(body_acc_mps2, "body_acc_mps2")
    return lever - (body - np.array([0.0, 0.0, STANDARD_GRAVITY_MPS2]))


def clipped_angles(
    lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike | None, geometry: ScooterGeometry
) -> ClippedAngles:
    """Angles as printed (eqs. 6 and 7), with the arcsines' arguments clipped to +-1.

    Noise and unknown slopes drive the argument beyond 1, where MATLAB's ``asin`` turns complex and
    NumPy's gives NaN. The paper does not say what it did. Clipping keeps the real part of MATLAB's
    steering angle, and keeps every sample in the statistics.

    Parameters
    ----------
    lever_acc_mps2 : (n, 3) array, m/s², in {T}
    body_acc_mps2 : (n, 3) array, m/s², in {B}; None for a single IMU on level ground
    geometry : ScooterGeometry

    Returns
    -------
    ClippedAngles
    """
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2")
    level = (0.0, 0.0, STANDARD_GRAVITY_MPS2)
    body = as_vectors(level if body_acc_mps2 is None else body_acc_mps2, "body_acc_mps2")
    sin, cos = np.sin(geometry.steering_inclination_rad), np.cos(geometry.steering_inclination_rad)
    c1 = body[..., 1] * cos + body[..., 2] * sin
    k1 = body[..., 2] * cos - body[..., 1] * sin
    held = lever.copy()
    reach = np.hypot(body[..., 0], c1) * (1 - 1e-12)
    held[..., 0] = np.clip(lever[..., 0], -reach, reach)
    steering = steering_angle(held, body, geometry)
    k2 = c1 * np.cos(steering) - body[..., 0] * np.sin(steering)
    reach = np.hypot(k1, k2) * (1 - 1e-12)
    held[..., 1] = np.clip(lever[..., 1], -reach, reach)
    throttle = throttle_angle(held, body, steering, geometry)
    return ClippedAngles(steering, throttle, (held != lever).any(axis=-1))


def paper_angles(
    lever_acc_mps2: ArrayLike,
    body_acc_mps2: ArrayLike | None,
    moving: NDArray[np.bool_],
    geometry: ScooterGeometry,
    *,
    method: Literal["single", "dual", "subtraction"],
    window: int = PAPER_MEDIAN_WINDOW,
    edge: Literal["zero", "nearest"] = "zero",
) -> ClippedAngles:
    """Angles in motion as the paper computes them: extract, smooth, transform (section 2.5).

    The samples in motion are joined before the median runs over them, so where a standstill was cut
    out the window sees both sides of it. With ``edge="zero"``, as MATLAB's ``medfilt1`` pads unless
    told otherwise, the first and last half window are pulled towards zero: the outermost sample is
    the smallest of 13 positive readings, not their median.

    Parameters
    ----------
    lever_acc_mps2 : (n, 3) array, m/s², in {T}, the whole recording
    body_acc_mps2 : (n, 3) array, m/s², in {B}; None is allowed for "single"
    moving : (n,) bool array, see :func:`moving_samples`
    geometry : ScooterGeometry
    method : "single" (level ground assumed), "dual", or "subtraction" (see :func:`subtract_body`)
    window, edge : of the median filter; a window of 1 leaves it out

    Returns
    -------
    ClippedAngles of the samples in motion only

    Raises
    ------
    InputError
        If nothing moves for as long as the window, or the body's sensor is missing.
    """
    if method not in ("single", "dual", "subtraction"):
        raise InputError(f"method = {method!r}: expected 'single', 'dual' or 'subtraction'")
    if method != "single" and body_acc_mps2 is None:
        raise InputError(f"method = {method!r}: needs the body's sensor, which is missing")
    inside = np.asarray(moving, bool)
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2")
    if inside.shape != lever.shape[:1]:
        raise InputError(
            f"moving has shape {inside.shape}, lever_acc_mps2 {lever.shape}: expected (n,), (n, 3)"
        )
    if inside.sum() < window:
        raise InputError(
            f"only {int(inside.sum())} samples in motion: fewer than the median window of {window}"
        )
    lever = median_filter(lever[inside], window, edge=edge)
    if method == "single" or body_acc_mps2 is None:
        return clipped_angles(lever, None, geometry)
    body = as_vectors(body_acc_mps2, "body_acc_mps2")
    body = median_filter(body[inside], window, edge=edge)
    if method == "dual":
        return clipped_angles(lever, body, geometry)
    return clipped_angles(subtract_body(lever, body), None, geometry)


def reference_angles(
    time_s: ArrayLike, reference_time_s: ArrayLike, reference_rad: ArrayLike, offset_s: float
) -> FloatArray:
    """Bring the wire sensors' angles to the times of our samples, by linear interpolation.

    Parameters
    ----------
    time_s : (n,) array, s, our clock
    reference_time_s : (m,) array, s, the reference's clock
    reference_rad : (m, k) array, rad
    offset_s : s, reference clock minus ours, see :func:`synchronise`

    Returns
    -------
    (n, k) array, rad; the first and last value hold beyond the reference's ends
    """
    time = as_series(time_s, "time_s")
    theirs = as_series(reference_time_s, "reference_time_s") - offset_s
    values = np.asarray(reference_rad, float)
    if values.ndim != 2 or len(values) != len(theirs):
        raise InputError(f"reference_rad has shape {values.shape}: expected ({len(theirs)}, k)")
    return np.column_stack([np.interp(time, theirs, column) for column in values.T])


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
    """
    if not (sampling_rate_hz > 0 and time_constant_s > 0):
        raise InputError(
            f"sampling_rate_hz = {sampling_rate_hz}, time_constant_s = {time_constant_s}: "
            "expected positive numbers"
        )
    arrays = [
        np.ascontiguousarray(as_vectors(values, name))
        for values, name in (
            (lever_acc_mps2, "lever_acc_mps2"),
            (lever_gyr_radps, "lever_gyr_radps"),
            (body_acc_mps2, "body_acc_mps2"),
            (body_gyr_radps, "body_gyr_radps"),
        )
    ]
    if len({array.shape for array in arrays}) != 1 or arrays[0].ndim != 2:
        raise InputError(f"shapes {[array.shape for array in arrays]}: expected all (n, 3)")
    lever_acc, lever_gyr, body_acc, body_gyr = arrays
    first = slice(0, max(1, round(0.5 * sampling_rate_hz)))
    start = three_axis_angles(
        np.median(lever_acc[first], axis=0), np.median(body_acc[first], axis=0), geometry
    )
    slow = np.column_stack(three_axis_angles(lever_acc, body_acc, geometry))
    alpha = geometry.steering_inclination_rad
    out = _complement(
        slow, lever_gyr, body_gyr, np.array(start, float), 1 / sampling_rate_hz, time_constant_s,
        alpha, alpha - geometry.lever_inclination_rad,
    )  # fmt: skip
    return out[:, 0], out[:, 1]


@njit(cache=True)
def _complement(slow, lever_gyr, body_gyr, start, dt, time_constant, alpha, lean):
    out = np.empty_like(slow)
    ca, sa = np.cos(alpha), np.sin(alpha)
    share = dt / (time_constant + dt)
    s, t = start[0], start[1]
    for k in range(len(slow)):
        if k > 0:
            gt, gb = (lever_gyr[k] + lever_gyr[k - 1]) / 2, (body_gyr[k] + body_gyr[k - 1]) / 2
            tipped = t + lean
            level, along = gb[1] * ca + gb[2] * sa, -gb[1] * sa + gb[2] * ca
            rate_s = -gt[1] * np.sin(tipped) + gt[2] * np.cos(tipped) - along
            rate_t = -gt[0] + gb[0] * np.cos(s) + level * np.sin(s)
            s += dt * rate_s
            t += dt * rate_t
        # Shortest way round: a blow may throw the slow angle across +-180 deg.
        s += share * ((slow[k, 0] - s + np.pi) % (2 * np.pi) - np.pi)
        t += share * ((slow[k, 1] - t + np.pi) % (2 * np.pi) - np.pi)
        out[k, 0], out[k, 1] = s, t
    return out


def _pulses(values: ArrayLike, name: str, least: int) -> FloatArray:
    pulses = np.asarray(values, float)
    if pulses.ndim != 1 or not np.isfinite(pulses).all() or (np.diff(pulses) < 0).any():
        raise InputError(f"{name}: expected finite times in order, one axis")
    if len(pulses) < least:
        raise InputError(f"{name}: {len(pulses)} pulses, expected at least {least}")
    return pulses
