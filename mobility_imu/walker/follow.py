"""The path of a recording's IMU: rests found, sensors checked, filter and smoother run."""

from __future__ import annotations

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.quality import frozen_samples, saturated_samples
from mobility_imu.recording import Recording
from mobility_imu.walker.navigation import (
    ClosedLoop,
    Navigation,
    NavigationSettings,
    navigate,
)
from mobility_imu.walker.stillness import StillnessSettings, find_stillness

LATEST_REST_S = 5.0
LEAST_RATE_HZ = 10.0
MOST_NIS = 2.0


def navigate_recording(
    recording: Recording,
    *,
    smooth: bool = True,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
    closed_loop: ClosedLoop | None = None,
) -> tuple[Navigation, tuple[str, ...]]:
    """Stillness and path of a recording's sensor "frame", with warnings.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    smooth, settings, stillness, closed_loop : see
        :func:`mobility_imu.walker.navigation.navigate`

    Returns
    -------
    Navigation from the first rest on, warnings (a late rest, samples at the end of the range)

    Raises
    ------
    InputError
        If there is no rest within the first seconds.
    """
    imu = recording.sensor("frame", gyroscope=True)
    gyr = np.asarray(imu.gyr_radps)
    if not LEAST_RATE_HZ <= recording.sampling_rate_hz:
        raise InputError(
            f"{recording.source}: {recording.sampling_rate_hz:g} samples per second, expected "
            f"{LEAST_RATE_HZ:g} or more (is time_s in ms?)"
        )
    still = find_stillness(imu.acc_mps2, gyr, recording.sampling_rate_hz, stillness)
    cut_acc, cut_gyr = saturated_samples(imu.acc_mps2), saturated_samples(gyr)
    # A sensor that seldom moves repeats its largest value by rounding; a range ends far out.
    cut_acc &= np.abs(imu.acc_mps2).max(axis=1) > 15.0
    cut_gyr &= np.abs(gyr).max(axis=1) > 3.0
    warnings = [
        f"{recording.source}: frame_{name} is saturated in {int(cut.sum())} samples, first at "
        f"{recording.time_s[np.argmax(cut)]:g} s: speed and path are uncertain from there to the "
        "next still phase"
        for name, cut in (("acc", cut_acc), ("gyr", cut_gyr))
        if cut.any()
    ]
    frozen = frozen_samples(np.hstack([imu.acc_mps2, gyr]), recording.sampling_rate_hz)
    if frozen.any():
        warnings.append(
            f"{recording.source}: the readings repeat themselves in {int(frozen.sum())} samples, "
            f"first at {recording.time_s[np.argmax(frozen)]:g} s: was the sensor frozen?"
        )
    # Where up is comes from the first rest; what lies before it cannot be followed.
    begin = int(np.argmax(still))
    late_s = float(recording.time_s[begin] - recording.time_s[0])
    if late_s > LATEST_REST_S or not still.any():
        raise InputError(
            f"{recording.source}: the frame is not still within the first {LATEST_REST_S:g} s: "
            "expected some seconds of rest at the start, which say where up is"
            + _why_not_still(imu.acc_mps2, gyr, recording.sampling_rate_hz, stillness)
        )
    if late_s > 0.2:
        warnings.append(
            f"{recording.source}: the frame moves at the start; the first {late_s:.1f} s are left "
            "out"
        )
    try:
        path = navigate(
            recording.time_s[begin:],
            imu.acc_mps2[begin:],
            gyr[begin:],
            still[begin:],
            settings,
            smooth=smooth,
            cut=cut_acc[begin:],
            closed_loop=closed_loop,
        )
    except InputError as error:
        raise InputError(f"{recording.source}: {error}") from None
    updates = int(path.nis_dof.sum())
    # What is wrong throughout a rest is measured by a stride's noise, less than a sample's.
    strides, samples = np.count_nonzero(path.nis_dof), np.count_nonzero(path.still)
    nis = path.nis.sum() / updates * strides / samples if updates else 0.0
    if nis > MOST_NIS:
        excess = np.sqrt(nis)
        warnings.append(
            f"{recording.source}: the rests are {excess:.1f} times as far from what the filter "
            "expects as they should be: are axes exchanged, or signs reversed?"
        )
    return path, tuple(warnings)


def _why_not_still(
    acc: FloatArray, gyr: FloatArray, rate_hz: float, settings: StillnessSettings | None
) -> str:
    """Guess at the gyroscope's unit if the accelerometer alone finds the frame at rest."""
    soon = slice(0, int(LATEST_REST_S * rate_hz))
    quiet = find_stillness(acc[soon], np.zeros_like(gyr[soon]), rate_hz, settings)
    fast = float(np.median(np.abs(gyr[soon][quiet]).max(axis=1))) if quiet.any() else 0.0
    if quiet.mean() > 0.2 and fast > 0.02:
        return f" (the force is at rest, the rate is {fast:.2g}: is the gyroscope in deg/s?)"
    return ""
