"""Self-calibration of simulated scooters from parked poses: what it finds, what it leaves."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray, one_of
from mobility_imu.scooter.calibration import (
    ParkedPose,
    ScooterCalibration,
    mount_from_poses,
    parked_poses,
)
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.simulation.scooter import (
    PARKED_POSES_RAD,
    ScooterUnit,
    draw_scooter,
    simulate_parked,
)

if TYPE_CHECKING:
    import pandas as pd

PLACES_DEG = {
    "level": ((0.2, 0.1),),
    "level + ramp": ((0.2, 0.1), (5.0, 0.0)),
    "level + ramp + side slope": ((0.2, 0.1), (5.0, 0.0), (0.0, 5.0)),
}
"""Pitch and roll of the places where one parks; the calibration is not told them."""


@lru_cache(maxsize=256)
def _parked(unit: ScooterUnit, k: int, place_deg: tuple[float, float]) -> tuple[ParkedPose, ...]:
    """Poses at the k-th place; several sets of places share it, so it is simulated once."""
    pitch, bank = np.deg2rad(place_deg)
    parked = simulate_parked(
        PARKED_POSES_RAD,
        pitch_rad=pitch,
        bank_rad=bank,
        seed=100 * unit.unit_seed + k,
        unit=unit,
    )
    return tuple(parked_poses(parked, PARKED_POSES_RAD))


def park_and_calibrate(unit: ScooterUnit, places: str) -> ScooterCalibration:
    """Calibration of a drawn scooter that is parked at the named places.

    Parameters
    ----------
    unit : ScooterUnit
    places : a name in :data:`PLACES_DEG`

    Returns
    -------
    ScooterCalibration
    """
    one_of("places", places, PLACES_DEG)
    poses = [pose for k, place in enumerate(PLACES_DEG[places]) for pose in _parked(unit, k, place)]
    return mount_from_poses(poses, SUZUKI_ET4D)


def _corrections(unit: ScooterUnit, places: str) -> tuple[FloatArray, FloatArray]:
    mount = park_and_calibrate(unit, places).mount
    return mount.rotation_lever_imu_to_lever, mount.rotation_body_imu_to_body


parked_on_ramp = partial(_corrections, places="level + ramp")


def mounting_left(scooters: range, places: str | None) -> pd.DataFrame:
    """How far the IMUs' axes are from what is believed, over drawn scooters, deg.

    Parameters
    ----------
    scooters : seeds
    places : a name in :data:`PLACES_DEG`; None for no calibration

    Returns
    -------
    DataFrame
        One row per scooter; columns lever_x ... body_z, rotation vector in deg.
    """
    import pandas as pd

    rows = []
    for seed in scooters:
        unit = draw_scooter(seed)
        believed = [np.eye(3)] * 2 if places is None else list(_corrections(unit, places))
        left = [
            (Rotation.from_matrix(b) * Rotation.from_rotvec(tilt).inv()).as_rotvec(degrees=True)
            for b, tilt in zip(believed, (unit.lever_mounting, unit.body_mounting), strict=True)
        ]
        rows.append(np.concatenate(left))
    columns = [f"{imu}_{axis}" for imu in ("lever", "body") for axis in "xyz"]
    return pd.DataFrame(rows, columns=columns, index=list(scooters))
