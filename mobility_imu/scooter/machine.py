"""What a scooter does, held against the angles: a third source beside lever and body.

A scooter whose wheel is straight does not turn, and one that stands has its lever released. So the
steering at which it does not turn, and the throttle while it stands, are zeros that no sensor has
to give. A turned sensor moves them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mobility_imu.filters import moving_average
from mobility_imu.frames import FloatArray
from mobility_imu.scooter.agreement import MEAN_S, Seen

__all__ = ["Zeros", "zeros_of"]

LEAST_CORRELATION = 0.8
"""Correlation of the turning with the tangent of the steering from which on it is a scooter that
drives, and not two sensors in a hand."""
SLOPES = (0.3, 3.0)
"""Tangent of the steering per rad/s: wheelbase over speed, of 0.9 m at 0.3 to 3 m/s."""
STAND_S = 0.6
"""A recording begins and ends with a scooter that stands for this long; then the lever is free."""
STILL_RADPS, STILL_RAD = 0.05, float(np.deg2rad(3.0))
"""Rate of the lever's gyroscope, about its mean, and changes of the throttle while it is free; its
two ends of the recording may differ by as much."""
LEAST_PUSHED_RAD = float(np.deg2rad(15.0))
"""A ride pushes the lever at least so far beyond where it is free."""


class Zeros(NamedTuple):
    """Angles that should be zero.

    Parameters
    ----------
    steering_rad : at which the scooter does not turn; NaN if the recording does not show it
    throttle_rad : while it stands; NaN likewise
    """

    steering_rad: float
    throttle_rad: float


def zeros_of(
    seen: Seen,
    body_acc: FloatArray,
    body_gyr: FloatArray,
    lever_gyr: FloatArray,
    rate_hz: float,
) -> Zeros:
    """Steering at which the scooter does not turn, and throttle while it stands.

    On a path with the wheel at ``s`` and the speed v, a wheelbase L turns at ``v tan(s) / L``: the
    tangent is fitted as a line in the rate, whose slope is positive. A lever that sits r beside the
    middle is pulled outwards by ``r yaw²`` in curves to either side, which looks like steering: the
    fit has this term as well. Without it, calibrated rides (0.22 m, seeds 26,200 to 26,221) are off
    by 1.0 deg on average and 6.4 at most, with it by 0.0 and 3.5.

    Parameters
    ----------
    seen : Seen
    body_acc, body_gyr : (n, 3) arrays, m/s² and rad/s, in {B}, the offset at rest taken off
    lever_gyr : (n, 3) array, rad/s, of the lever's sensor
    rate_hz : Hz

    Returns
    -------
    Zeros
    """
    unknown = Zeros(float("nan"), float("nan"))
    good = seen.good & (np.abs(seen.steering_rad) < np.pi / 3)
    if not good.any():
        return unknown
    width = round(MEAN_S * rate_hz) | 1
    up = moving_average(body_acc, 2 * width - 1)
    up = up / np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    yaw = moving_average((body_gyr * up).sum(axis=1), width)[good]
    tangent = np.tan(seen.steering_rad[good])
    if yaw.std() == 0 or tangent.std() == 0:
        return unknown
    if np.corrcoef(yaw, tangent)[0, 1] < LEAST_CORRELATION:
        return unknown
    _, slope, straight = np.polyfit(yaw, tangent, 2)
    if not SLOPES[0] <= slope <= SLOPES[1]:
        return unknown
    return Zeros(float(np.arctan(straight)), _free_throttle(seen, lever_gyr, rate_hz))


def _free_throttle(seen: Seen, lever_gyr: FloatArray, rate_hz: float) -> float:
    """Throttle at both ends of a recording, where the lever is free; NaN if it moves or is held."""
    count, throttle = round(STAND_S * rate_hz), seen.throttle_rad
    if len(throttle) < 4 * count:
        return float("nan")
    ends = []
    for end in (slice(count), slice(-count, None)):
        wobble = np.sqrt(((lever_gyr[end] - lever_gyr[end].mean(axis=0)) ** 2).sum(axis=1).mean())
        if not seen.good[end].all() or wobble > STILL_RADPS or np.ptp(throttle[end]) > STILL_RAD:
            return float("nan")
        ends.append(float(np.median(throttle[end])))
    free, known = float(np.mean(ends)), throttle[seen.good]
    held = abs(ends[0] - ends[1]) > STILL_RAD or np.percentile(known, 2) < free - STILL_RAD
    pushed = np.percentile(known, 98) > free + LEAST_PUSHED_RAD
    return free if pushed and not held else float("nan")
