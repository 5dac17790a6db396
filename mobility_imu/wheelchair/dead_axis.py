"""A gyroscope one of whose axes says nothing, mended by what the chair's motion can be.

A wheel's sensor turns by the spin about the axle, and by the chair's yaw rate times cos(camber)
about up in the wheel's plane; the frame's turns about the vertical. So two axes and gravity give
the third.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mobility_imu.faults import Fault, with_half
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.turning import up_in_plane

__all__ = ["with_axis_repair", "without_axis"]

LARGEST_PART = 0.9
"""Of the turn about the axle, lost with the axis: what is left, a tenth, is found from what the
other axes read with ten times their error."""


def with_axis_repair(
    fault: Fault,
    sensor: str,
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
) -> Fault:
    """Fault of a dead axis whose repair takes what the other axes and gravity say.

    Parameters
    ----------
    fault : Fault, "dead axis" of a gyroscope
    sensor : "frame", "left_wheel" or "right_wheel"
    recording : Recording
    geometry : WheelchairGeometry
    mount : WheelchairMount

    Returns
    -------
    Fault; as it was where too little of the sensor's turn is left, or what a wheel needs is missing
    """
    needed = {
        "frame": mount.rotation_frame_imu_to_chair,
        "left_wheel": mount.rotation_left_imu_to_wheel,
        "right_wheel": mount.rotation_right_imu_to_wheel,
    }
    axis, rotation = "xyz".index(fault.sensor[-1]), needed[sensor]
    there = all(
        needed[name] is not None
        and name in recording.sensors
        and recording.sensors[name].gyr_radps is not None
        for name in ("frame", sensor)
    )
    if not there or rotation is None or float(rotation[2, axis]) ** 2 > LARGEST_PART:
        return fault
    repair = partial(
        without_axis, sensor=sensor, axis=axis, flags=fault.flags, geometry=geometry, mount=mount
    )
    return replace(fault, repair=repair)


def without_axis(
    recording: Recording,
    sensor: str,
    axis: int,
    flags: NDArray[np.bool_],
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
    axis : 0, 1 or 2; its part in the axle, or in up on the frame, squared, is at most 0.9
    flags : (n,) bool array, the samples in which it is dead; its other readings stay
    geometry : WheelchairGeometry
    mount : WheelchairMount

    Returns
    -------
    Recording
    """
    gyr = np.array(recording.gyroscope(sensor))
    gyr[flags, axis] = 0.0
    if sensor == "frame":
        main, across = mount.rotation_frame_imu_to_chair[2], np.zeros(len(gyr))
    else:
        rotation = mount.rotation_imu_to_wheel("left" if sensor == "left_wheel" else "right")
        main, part = rotation[2], float(rotation[2, axis])
        spin = (gyr @ main) / np.where(flags, 1 - part**2, 1.0)
        up = up_in_plane(
            recording.sensor(sensor).acc_mps2 @ rotation[:2].T, spin, recording.sampling_rate_hz
        )
        yaw = recording.gyroscope("frame") @ mount.rotation_frame_imu_to_chair[2]
        across = yaw * np.cos(geometry.camber_rad) * (up @ rotation[:2, axis])
    part = float(main[axis])
    whole = (gyr @ main + part * across) / (1 - part**2)
    gyr[flags, axis] = (part * whole + across)[flags]
    return with_half(recording, sensor, "gyr", gyr)
