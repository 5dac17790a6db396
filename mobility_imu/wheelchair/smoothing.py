"""Smoothing of a whole recording before it is evaluated, as the public tool offers it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Literal, get_args

import numpy as np
from scipy import ndimage

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.filters import moving_average, savitzky_golay
from mobility_imu.frames import FloatArray, as_count, one_of
from mobility_imu.recording import PLAUSIBLE_ACC_MPS2, Imu, Recording
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.uncertainty import sample_noise
from mobility_imu.wheelchair.velocity import ChairVelocity

__all__ = ["Smoothing", "smooth_recording", "with_smoothing_sd"]

Smoothing = Literal["none", "moving-average", "savitzky-golay"]


def smooth_recording(
    recording: Recording, method: Smoothing = "savitzky-golay", *, window: int = 7, order: int = 2
) -> Recording:
    """Recording with every sensor smoothed. Smooth the calibration trials in the same way.

    A wheel turns gravity round: over a window as long as a turn nothing of it is left. The
    accelerations of such a sensor stay as they are. A filter takes away noise, and with it the tops
    of the motion, which no estimate from the smoothed recording can know: its standard deviations
    are too small until :func:`with_smoothing_sd` has widened them.

    Parameters
    ----------
    recording : Recording
    method : "none", "moving-average" or "savitzky-golay"
    window : samples in the filter's window, odd
    order : of the Savitzky-Golay filter

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        If the method is none of them, or the window is even or longer than the recording.
    """
    one_of("method", method, get_args(Smoothing))
    expect("recording", recording, Recording)
    if method == "none":
        return recording
    smooth = _smoother(method, window, order)
    try:
        sensors = {
            name: Imu(
                _with_gravity(imu.acc_mps2, smooth),
                None if imu.gyr_radps is None else smooth(imu.gyr_radps),
            )
            for name, imu in recording.sensors.items()
        }
    except InputError as error:
        raise InputError(f"{recording.source}: {error}") from None
    return Recording(recording.time_s, sensors, source=recording.source)


def _smoother(method: Smoothing, window: int, order: int) -> Callable[[FloatArray], FloatArray]:
    if one_of("method", method, get_args(Smoothing)) == "none":
        return np.asarray
    if method == "moving-average":
        return partial(moving_average, window=window)
    return partial(savitzky_golay, window=window, order=order)


def _with_gravity(acc_mps2: FloatArray, smooth: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Smoothed accelerations, or those given if gravity would not be left."""
    smoothed = smooth(acc_mps2)
    left = float(np.median(np.linalg.norm(smoothed, axis=1)))
    return smoothed if left >= PLAUSIBLE_ACC_MPS2[0] else acc_mps2


LOCAL_S = 0.25
"""What a filter changes is averaged over this at least: about a fourth of a push."""


def with_smoothing_sd(
    smoothed: ChairVelocity,
    unsmoothed: ChairVelocity,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    method: Smoothing = "savitzky-golay",
    *,
    window: int = 7,
    order: int = 2,
) -> ChairVelocity:
    """Velocities of a smoothed recording whose standard deviations count what the filter changes.

    Of the noise of single samples, which is white, the filter's weights w leave the part sum(w²).
    The difference of the two estimates holds the noise that is taken away, 1 - 2 w0 + sum(w²), and
    what the filter changes of the motion: the rest of its mean square over the filter's window.
    The other parts are those of the estimate from the recording as it came. Where that is not
    valid, this one is not either.

    Parameters
    ----------
    smoothed : ChairVelocity of the smoothed recording and trials
    unsmoothed : ChairVelocity of the same recording and trials as they came
    geometry : WheelchairGeometry
    mount : WheelchairMount, of the trials as they came
    method, window, order : as for :func:`smooth_recording`

    Returns
    -------
    ChairVelocity

    Raises
    ------
    InputError
        If the two differ in length, or an option of the filter is none.
    """
    expect("smoothed", smoothed, ChairVelocity)
    expect("unsmoothed", unsmoothed, ChairVelocity)
    if len(smoothed) != len(unsmoothed):
        raise InputError(
            f"unsmoothed: {len(unsmoothed)} samples, expected {len(smoothed)} as smoothed has"
        )
    expect("geometry", geometry, WheelchairGeometry)
    expect("mount", mount, WheelchairMount)
    window = as_count(window, "window")
    if one_of("method", method, get_args(Smoothing)) == "none":
        window = 1
    if window > len(smoothed):
        raise InputError(f"window = {window}: longer than the {len(smoothed)} samples")
    weights = _smoother(method, window, order)(np.eye(1, 2 * window + 1, window)[0])
    left = float(np.square(weights).sum())
    taken = 1 - 2 * float(weights[window]) + left
    local = max(window, round(LOCAL_S * smoothed.sampling_rate_hz))
    both = not np.isnan(unsmoothed.wheel_yaw_rate_radps).all()
    noise = sample_noise(unsmoothed.offsets, geometry, mount, both=both)
    assert smoothed.valid is not None and unsmoothed.valid is not None

    def widened(value: str, sd: str, sample_sd: float) -> FloatArray:
        change = getattr(smoothed, value) - getattr(unsmoothed, value)
        mean_square = ndimage.uniform_filter1d(np.square(change), local)
        motion = np.maximum(mean_square - taken * sample_sd**2, 0.0)
        others = np.square(getattr(unsmoothed, sd)) - (1 - left) * sample_sd**2
        return np.asarray(np.sqrt(np.maximum(others, left * sample_sd**2) + motion))

    return replace(
        smoothed,
        linear_velocity_sd_mps=widened(
            "linear_velocity_mps", "linear_velocity_sd_mps", noise.linear_velocity_sd_mps
        ),
        yaw_rate_sd_radps=widened("yaw_rate_radps", "yaw_rate_sd_radps", noise.yaw_rate_sd_radps),
        valid=smoothed.valid & unsmoothed.valid,
    )
