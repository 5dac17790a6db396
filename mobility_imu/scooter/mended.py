"""Readings that a sensor lost, from those of the others: as good as can be, for the cost of a loss.

The rates of a gyroscope that says nothing follow from the other one and the closed form's angles;
an acceleration that stands still follows from its own gyroscope, which turns gravity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.faults import half_of, with_half
from mobility_imu.frames import FloatArray
from mobility_imu.hinges import column_vector, steered, turn
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of
from mobility_imu.scooter.agreement import seen_by
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.mount import ScooterMount

__all__ = ["carried", "rebuilt"]

BESIDE_S = 0.2
"""Accelerations are averaged over this beside a loss: a blow is no gravity."""
UNTURNED = np.eye(3)


def rebuilt(
    recording: Recording,
    sensor: str,
    flags: NDArray[np.bool_],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Recording:
    """Recording in which a gyroscope's lost rates are those that the other sensors expect.

    The two hinges turn as the closed form's averaged angles do; the rest is the other gyroscope's.

    Parameters
    ----------
    recording : Recording of lever and body with gyroscopes
    sensor : "lever" or "body", whose rates are lost
    flags : (n,) bool array, the lost samples
    geometry : ScooterGeometry
    mount : ScooterMount, or None

    Returns
    -------
    Recording
    """
    rate_hz = recording.sampling_rate_hz
    axes = {
        "lever": UNTURNED if mount is None else mount.rotation_lever_imu_to_lever,
        "body": UNTURNED if mount is None else mount.rotation_body_imu_to_body,
    }
    acc = {name: recording.sensor(name).acc_mps2 @ turns.T for name, turns in axes.items()}
    seen = seen_by(acc["lever"], acc["body"], rate_hz, geometry)
    angles = seen.steering_rad, seen.throttle_rad
    steering_radps, throttle_radps = (np.gradient(a) * rate_hz for a in angles)
    tip, alpha = angles[1] + geometry.lean_rad, geometry.steering_inclination_rad
    if sensor == "lever":
        column = column_vector(recording.gyroscope("body") @ axes["body"].T, alpha)
        beside, ahead = steered(column, angles[0])
        y, z = turn(ahead, column.k1 + steering_radps, -np.sin(tip), np.cos(tip))
        expected = np.column_stack([beside - throttle_radps, y, z])
    else:
        lever = recording.gyroscope("lever") @ axes["lever"].T
        across, shaft = turn(lever[:, 1], lever[:, 2], np.sin(tip), np.cos(tip))
        x, c1 = turn(lever[:, 0] + throttle_radps, across, -np.sin(angles[0]), np.cos(angles[0]))
        y, z = turn(c1, shaft - steering_radps, -np.sin(alpha), np.cos(alpha))
        expected = np.column_stack([x, y, z])
    rates = np.where(flags[:, None], expected @ axes[sensor], recording.gyroscope(sensor))
    return with_half(recording, sensor, "gyr", rates)


def carried(recording: Recording, sensor: str, flags: NDArray[np.bool_]) -> Recording:
    """Recording in which lost accelerations are gravity, turned by the sensor's own gyroscope.

    Gravity is carried on from before the loss and back from after it; in between it goes over from
    the one to the other.

    Parameters
    ----------
    recording : Recording
    sensor : name of a sensor with a gyroscope
    flags : (n,) bool array, the lost samples

    Returns
    -------
    Recording; as it was if there is nothing to carry on from
    """
    values = np.array(half_of(recording, sensor, "acc"))
    gyr, rate_hz = recording.gyroscope(sensor), recording.sampling_rate_hz
    beside = max(1, round(BESIDE_S * rate_hz))
    known = ~flags
    for lost in runs_of(flags):
        before = np.flatnonzero(known[: lost.start])[-beside:]
        after = np.flatnonzero(known[lost.stop :])[:beside] + lost.stop
        ways = []
        if len(before):
            ways.append(_turned(np.median(values[before], axis=0), gyr[lost], rate_hz))
        if len(after):
            back = _turned(np.median(values[after], axis=0), -gyr[lost][::-1], rate_hz)
            ways.append(back[::-1])
        if len(ways) == 2:
            part = np.linspace(0, 1, len(ways[0]))[:, None]
            values[lost] = (1 - part) * ways[0] + part * ways[1]
        elif ways:
            values[lost] = ways[0]
    return with_half(recording, sensor, "acc", values)


def _turned(force: FloatArray, gyr: FloatArray, rate_hz: float) -> FloatArray:
    """Force that stays in the world, in the axes of a sensor that turns, (n, 3)."""
    turns = Rotation.from_rotvec(-gyr / rate_hz)
    out = np.empty((len(gyr), 3))
    for k, matrix in enumerate(turns.as_matrix()):
        force = matrix @ force
        out[k] = force
    return out
