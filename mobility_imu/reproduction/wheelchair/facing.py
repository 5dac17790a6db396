"""Simulated chairs whose wheel sensors face outward, as in the document's Figure 1, or inward."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.simulation.wheelchair import Mounting, random_mounting
from mobility_imu.wheelchair.calibration import Form, alignment_matrix, wheel_alignment_angles
from mobility_imu.wheelchair.geometry import SIDES, Side, side_sign

Facing = Literal["outward", "inward"]
LARGEST_TILT_RAD = 0.5


def facing_mounting(facing: Facing, seed: int) -> dict[str, Mounting]:
    """Three IMUs, those of the wheels with their z outward or inward, tilted at random.

    Parameters
    ----------
    facing : "outward" as in Figure 1, "inward" as on the public sample
    seed : of the tilts (up to 0.5 rad) and of the frame's IMU

    Returns
    -------
    dict from sensor name to Mounting
    """
    mounting = random_mounting(seed)
    for side, turn in _turns(facing, seed).items():
        place = mounting[f"{side}_wheel"].position_m
        mounting[f"{side}_wheel"] = Mounting(turn.as_matrix(), place)
    return mounting


def _turns(facing: Facing, seed: int) -> dict[Side, Rotation]:
    """How the wheels' sensors are turned."""
    rng = np.random.default_rng(seed)
    turns = {}
    for side in SIDES:
        # The wheel's own z is its axle, positive forward: it points to the chair's left.
        flip = (side_sign(side) > 0) != (facing == "outward")
        tilt = rng.uniform(0, LARGEST_TILT_RAD) * _unit(rng.normal(size=2))
        turns[side] = Rotation.from_rotvec([*tilt, 0]) * Rotation.from_rotvec([np.pi * flip, 0, 0])
    return turns


def forward_axles(facing: Facing, count: int) -> Iterator[tuple[Side, FloatArray]]:
    """Axles in the axes of the wheels' sensors, positive forward, of :func:`facing_mounting`.

    Parameters
    ----------
    facing : "outward" as in Figure 1, "inward" as on the public sample
    count : chairs, seeds 0, 1, 2 ...

    Yields
    ------
    side, and (3,) array of length 1
    """
    for seed in range(count):
        for side, turn in _turns(facing, seed).items():
            # Rolling forward, the wheel turns about its axle, which points to the chair's left.
            yield side, turn.as_matrix()[:, 2]


def along_outward_axle(facing: Facing, form: Form, *, count: int = 1000) -> FloatArray:
    """Cosines between the aligned z and Figure 1's outward axle, over chairs with tilted sensors.

    Parameters
    ----------
    facing : "outward" as in Figure 1, "inward" as on the public sample
    form : of the two angles: "printed" for the arctangents (1.8) and (1.9), "corrected" for atan2
    count : chairs, each with two wheels

    Returns
    -------
    (2 count,) array; 1 where the aligned z is the outward axle, -1 where it is the inward one
    """
    found = []
    for side, rolling in forward_axles(facing, count):
        aligned = alignment_matrix(*wheel_alignment_angles(rolling, form=form))[:, 2]
        found.append(side_sign(side) * aligned @ rolling)
    return np.array(found)


def _unit(vector: FloatArray) -> FloatArray:
    return vector / np.linalg.norm(vector)
