"""What a recording tells about the noise of its own fusion, without a reference.

Both IMUs should measure accelerations of the same length, whatever the angles; and about the axis
at right angles to both hinges nothing can turn. What is seen there is noise, vibration and flexing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_vectors
from mobility_imu.scooter.fusion_settings import FusionSettings

__all__ = [
    "acceleration_noise",
    "added_variance",
    "bounded_and_wandering",
    "check_largest",
    "smallest_step",
    "smoothed",
    "trust",
    "white_and_coloured",
]

SMALLEST_NOISE_MPS2 = 1e-3
"""Noise that :func:`acceleration_noise` finds at least; no accelerometer of a scooter has less."""
COLOURED_AFTER_S = 1.0
"""Time after which a coloured disturbance has forgotten itself."""
KEPT_BY_MEANS = 2 * float(np.exp(-1.0))
"""Variance of a Gauss-Markov noise that its mean over one correlation time keeps."""
TURNS_AFTER_S = (2.0, 8.0)
"""Two intervals over which flexing, which is bounded, and noise, which adds up, differ."""
FEWEST_SAMPLES = 50
"""Samples below which a recording tells nothing about its noise but the lengths."""


def acceleration_noise(lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike) -> float:
    """Noise of eq. 5 per axis, from the lengths of the two accelerations.

    Whatever the angles, both IMUs should measure the same length; the spread of the difference
    (robust, from the median absolute deviation) is the noise along one direction. Readings that
    repeat themselves, of a coarse or a dead converter, have no spread that means anything: the
    noise is one step of the converter at least, and ``SMALLEST_NOISE_MPS2``.

    Parameters
    ----------
    lever_acc_mps2, body_acc_mps2 : (n, 3) arrays, m/s², best in the sensors' own axes, where the
        steps of the converters show

    Returns
    -------
    float, m/s²

    Raises
    ------
    InputError
        If the arrays differ in shape, are empty, or hold a number that is not finite or has no
        square.

    Examples
    --------
    >>> parked = np.tile([0.0, 0.0, 9.81], (100, 1))
    >>> acceleration_noise(parked, parked)
    0.001
    """
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2", ndim=2, finite=True)
    body = as_vectors(body_acc_mps2, "body_acc_mps2", length=len(lever), finite=True)
    if not len(lever):
        raise InputError("lever_acc_mps2: no sample, expected at least one")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused
        apart = np.linalg.norm(lever, axis=1) - np.linalg.norm(body, axis=1)
    if not np.isfinite(apart).all():
        row = int(np.argmin(np.isfinite(apart)))
        raise InputError(f"accelerations at row {row}: too large to have a length")
    return max(float(_spread(apart)), smallest_step(lever, body))


def trust(residuals: FloatArray, limit: float) -> FloatArray:
    """Weights of samples, less than 1 where residuals are too large to be noise, as in the filter.

    Parameters
    ----------
    residuals : (n, 3) array
    limit : root mean square of three axes beyond which a residual counts less

    Returns
    -------
    (n, 1) array
    """
    size = np.sqrt(np.mean(residuals**2, axis=1, keepdims=True))
    return np.asarray((limit / np.maximum(size, limit)) ** 2)


def smoothed(values: FloatArray, weights: FloatArray, width: float) -> FloatArray:
    """Weighted means by a Gaussian, so that a blow is not spread over its neighbours.

    White noise keeps its density: what a smoothed sample counts for is that of a raw one.

    Parameters
    ----------
    values : (n, 3) array
    weights : (n, 1) array, positive
    width : of the Gaussian, in samples

    Returns
    -------
    (n, 3) array, contiguous
    """
    both = ndimage.gaussian_filter1d(np.hstack([weights * values, weights]), width, axis=0)
    return np.ascontiguousarray(both[:, :3] / both[:, 3:])


def added_variance(
    angles: FloatArray, settings: FusionSettings, rate_hz: float, *, past: bool
) -> FloatArray:
    """What flexing and the clock add to the variance of both angles.

    Parameters
    ----------
    angles : (n, 2) array, rad
    settings : FusionSettings, complete
    rate_hz : Hz
    past : whether only the past is known

    Returns
    -------
    (n, 2) array, rad²
    """
    assert settings.flexing_sd_rad is not None and settings.clock_sd_s is not None
    if not past and len(angles) > 1:
        rates = np.gradient(angles, 1 / rate_hz, axis=0)
    else:
        rates = np.diff(angles, axis=0, prepend=angles[:1]) * rate_hz
    return np.asarray(settings.flexing_sd_rad**2 + (settings.clock_sd_s * rates) ** 2)


def check_largest(values: FloatArray, name: str, limit: float) -> None:
    """Check that nothing is beyond any sensor and any body; NaN passes.

    Parameters
    ----------
    values : array
    name : of it, for the message
    limit : largest absolute value

    Raises
    ------
    InputError
        If a value is larger.
    """
    largest = float(np.abs(values).max(initial=0.0))
    if largest > limit:
        raise InputError(
            f"{name}: reaches {largest:.4g}, expected {limit:g} at most: is it in another unit?"
        )


def smallest_step(lever_acc: FloatArray, body_acc: FloatArray) -> float:
    """Noise that rounding leaves: one step of the coarser converter, or ``SMALLEST_NOISE_MPS2``.

    Parameters
    ----------
    lever_acc, body_acc : (n, 3) arrays, m/s², in the sensors' own axes

    Returns
    -------
    float, m/s²
    """
    return max(SMALLEST_NOISE_MPS2, _step(lever_acc), _step(body_acc))


def _step(values: FloatArray) -> float:
    """Smallest step between the readings of a sensor; 0 if they all are the same."""
    steps = [np.diff(np.unique(axis)) for axis in values.T]
    return min((float(step.min()) for step in steps if len(step)), default=0.0)


def _spread(values: FloatArray) -> FloatArray:
    """Robust standard deviation along the first axis, from the median absolute deviation."""
    middle = np.median(values, axis=0)
    return np.asarray(1.4826 * np.median(np.abs(values - middle), axis=0))


def white_and_coloured(
    residuals: FloatArray, sampling_rate_hz: float, correlation_time_s: float
) -> tuple[float, float] | None:
    """White and coloured part of a noise, from the changes of its means and of itself.

    Means over one correlation time keep a coloured noise (0.736 of a Gauss-Markov one's variance),
    while white noise and fast vibration leave them; what is left of the whole is white. Changes
    over a second are compared, so that constants do not matter: ``sd² = change² / 2``. Of the axes
    the worst counts.

    Parameters
    ----------
    residuals : (n, 3) array
    sampling_rate_hz : Hz
    correlation_time_s : s, of the coloured part

    Returns
    -------
    white, coloured : standard deviations in the residuals' unit; None for fewer than
        ``FEWEST_SAMPLES``, or less than ten times a second and the correlation time
    """
    block = max(1, round(correlation_time_s * sampling_rate_hz))
    apart = round(COLOURED_AFTER_S * sampling_rate_hz)
    blocks, wait = len(residuals) // block, -(-apart // block)
    if len(residuals) < max(FEWEST_SAMPLES, 10 * apart) or blocks < 10 * wait:
        return None
    means = residuals[: blocks * block].reshape(blocks, block, 3).mean(axis=1)
    whole, slow, fast = (
        float(_spread(values[step:] - values[:-step]).max()) ** 2 / 2
        for values, step in ((residuals, apart), (means, wait), (residuals, 1))
    )
    coloured = max(0.0, slow - fast / block) / (KEPT_BY_MEANS if block > 1 else 1.0)
    return max(fast, whole - coloured) ** 0.5, coloured**0.5


def bounded_and_wandering(rates: FloatArray, sampling_rate_hz: float) -> tuple[float, float]:
    """Angle that comes and goes, and density of the noise that adds up, of a rate that should be 0.

    The rate's integral over a time T has the variance ``2 angle² + density² T``: two times tell
    both. Its mean is an offset, and is taken off.

    Parameters
    ----------
    rates : (n,) array, rad/s
    sampling_rate_hz : Hz

    Returns
    -------
    angle : rad, standard deviation; of a short recording 0
    density : rad/s per square root of Hz; of a short recording 0
    """
    turned = np.concatenate(([0.0], np.cumsum(rates - np.mean(rates)))) / sampling_rate_hz
    longest = len(rates) / sampling_rate_hz / 4
    scale = min(1.0, longest / TURNS_AFTER_S[1])
    steps = [round(scale * after * sampling_rate_hz) for after in TURNS_AFTER_S]
    if len(rates) < FEWEST_SAMPLES or steps[0] == 0:
        return 0.0, 0.0
    short, long = (float(np.mean((turned[step:] - turned[:-step]) ** 2)) for step in steps)
    seconds = [step / sampling_rate_hz for step in steps]
    density2 = max(0.0, (long - short) / (seconds[1] - seconds[0]))
    return max(0.0, (short - density2 * seconds[0]) / 2) ** 0.5, density2**0.5
