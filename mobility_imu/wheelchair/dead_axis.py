"""A gyroscope one of whose axes says nothing, mended by what the chair's motion can be.

A wheel's sensor turns by the spin about the axle, and by the chair's yaw rate times cos(camber)
about up in the wheel's plane; the frame's turns about the vertical. So two axes and gravity give
the third.
"""

from __future__ import annotations

import numpy as np

from mobility_imu.faults import with_half
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.turning import up_in_plane

__all__ = ["without_axis"]

LARGEST_PART = 0.9
"""Of the turn about the axle, lost with the axis: what is left, a tenth, is found from what the
other axes read with ten times their error."""


def without_axis(
    recording: Recording,
    sensor: str,
    axis: int,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
) -> Recording:
    """Recording whose gyroscope's dead axis reads what the two others and gravity say.

    With a the dead axis' part of the axle and w its part of the chair's turn, the spin that is left
    is Om (1 - a^2) - a w.

    Parameters
    ----------
    recording : Recording
    sensor : "frame", "left_wheel" or "right_wheel"
    axis : 0, 1 or 2
    geometry : WheelchairGeometry
    mount : WheelchairMount

    Returns
    -------
    Recording; as it was where too little is left
    """
    gyr = np.array(recording.gyroscope(sensor))
    if sensor == "frame":
        main, across = mount.rotation_frame_imu_to_chair[2], np.zeros(len(gyr))
    else:
        rotation = mount.rotation_imu_to_wheel("left" if sensor == "left_wheel" else "right")
        main = rotation[2]
        across = _turn_about(recording, sensor, rotation, axis, geometry, mount)
    part = float(main[axis])
    if part**2 > LARGEST_PART:
        return recording
    whole = (gyr @ main + part * across - part * gyr[:, axis]) / (1 - part**2)
    gyr[:, axis] = part * whole + across
    return with_half(recording, sensor, "gyr", gyr)


def _turn_about(
    recording: Recording,
    sensor: str,
    rotation: FloatArray,
    axis: int,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
) -> FloatArray:
    """What the chair's turn makes a wheel's axis read, rad/s."""
    rate = recording.sampling_rate_hz
    gyr, acc = recording.gyroscope(sensor), recording.sensor(sensor).acc_mps2
    main = rotation[2]
    spin = (gyr @ main) / max(1 - float(main[axis]) ** 2, 1 - LARGEST_PART)
    up = up_in_plane(acc @ rotation[:2].T, spin, rate)
    yaw = recording.gyroscope("frame") @ mount.rotation_frame_imu_to_chair[2]
    upward = up @ rotation[:2, axis]
    return np.asarray(yaw * np.cos(geometry.camber_rad) * upward)
