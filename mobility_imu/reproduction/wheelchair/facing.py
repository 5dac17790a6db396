"""Simulated chairs whose wheel sensors face outward, as in the document's Figure 1, or inward."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.simulation.wheelchair import Mounting, random_mounting
from mobility_imu.wheelchair.calibration import Form, alignment_matrix, wheel_alignment_angles
from mobility_imu.wheelchair.geometry import SIDES, side_sign

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
    rng = np.random.default_rng(seed)
    mounting = random_mounting(seed)
    for side in SIDES:
        # The wheel's own z is its axle, positive forward: it points to the chair's left.
        flip = (side_sign(side) > 0) != (facing == "outward")
        tilt = rng.uniform(0, LARGEST_TILT_RAD) * _unit(rng.normal(size=2))
        turn = Rotation.from_rotvec([*tilt, 0]) * Rotation.from_euler("x", np.pi * flip)
        place = mounting[f"{side}_wheel"].position_m
        mounting[f"{side}_wheel"] = Mounting(turn.as_matrix(), place)
    return mounting


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
    for seed in range(count):
        mounting = facing_mounting(facing, seed)
        for side in SIDES:
            # Rolling forward, the wheel turns about its axle, which points to the chair's left.
            rolling = mounting[f"{side}_wheel"].rotation_body_to_imu[:, 2]
            aligned = alignment_matrix(*wheel_alignment_angles(rolling, form=form))[:, 2]
            found.append(side_sign(side) * aligned @ rolling)
    return np.array(found)


def _unit(vector: FloatArray) -> FloatArray:
    return vector / np.linalg.norm(vector)
