"""Smoothing of a whole recording before it is evaluated, as the public tool offers it."""

from __future__ import annotations

from functools import partial
from typing import Literal

from mobility_imu.arguments import expect
from mobility_imu.filters import moving_average, savitzky_golay
from mobility_imu.frames import one_of
from mobility_imu.recording import Imu, Recording

__all__ = ["Smoothing", "smooth_recording"]

Smoothing = Literal["none", "moving-average", "savitzky-golay"]


def smooth_recording(
    recording: Recording, method: Smoothing = "savitzky-golay", *, window: int = 7, order: int = 2
) -> Recording:
    """Recording with every sensor smoothed. Smooth the calibration trials in the same way.

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
    one_of("method", method, ("none", "moving-average", "savitzky-golay"))
    expect("recording", recording, Recording)
    if method == "none":
        return recording
    smooth = (
        partial(moving_average, window=window)
        if method == "moving-average"
        else partial(savitzky_golay, window=window, order=order)
    )
    sensors = {
        name: Imu(smooth(imu.acc_mps2), None if imu.gyr_radps is None else smooth(imu.gyr_radps))
        for name, imu in recording.sensors.items()
    }
    return Recording(recording.time_s, sensors, source=recording.source)
