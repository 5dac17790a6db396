"""How an IMU is fixed to a walking frame. Frames: :mod:`mobility_imu.walker.geometry`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.geometry import find_table, read_arrays


@dataclass(frozen=True)
class WalkerMount:
    """How the IMU is fixed to the walking frame.

    Parameters
    ----------
    rotation_imu_to_body : (3, 3) array, turns components in the IMU's axes into the body's
    translation_body_m : (3,) array, m, position of the IMU in the body frame
    rotation_sd_rad : (3,) array, rad, sd about the body's axes; None if it is not known
    translation_sd_m : (3,) array, m, sd of the position; None if it is not known

    Raises
    ------
    InputError
        If the matrix is not a rotation, or the position is out of any frame's reach.
    """

    rotation_imu_to_body: FloatArray
    translation_body_m: FloatArray
    rotation_sd_rad: FloatArray | None = None
    translation_sd_m: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse what is no rotation, or no place on a walking frame."""
        rotation = np.asarray(self.rotation_imu_to_body, float)
        place = np.asarray(self.translation_body_m, float)
        if rotation.shape != (3, 3) or not np.isfinite(rotation).all():
            raise InputError("rotation_imu_to_body: expected three rows of three numbers")
        defect = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
        if defect > 1e-3 or np.linalg.det(rotation) < 0:
            raise InputError(
                f"rotation_imu_to_body: not a rotation (C C' is off 1 by {defect:.2g}, "
                f"determinant {np.linalg.det(rotation):.4f})"
            )
        if place.shape != (3,) or not np.isfinite(place).all():
            raise InputError("translation_body_m: expected three numbers")
        if np.abs(place).max() > 2:
            raise InputError(
                f"translation_body_m = {place.tolist()}: expected within 2 m (in cm or mm?)"
            )
        for name in ("rotation_sd_rad", "translation_sd_m"):
            value = getattr(self, name)
            if value is None:
                continue
            spread = np.asarray(value, float)
            if spread.shape != (3,) or not (spread >= 0).all():
                raise InputError(f"{name}: expected three numbers that are not negative")
            object.__setattr__(self, name, spread)
        object.__setattr__(self, "rotation_imu_to_body", rotation)
        object.__setattr__(self, "translation_body_m", place)

    @classmethod
    def from_toml(cls, path: str | Path) -> WalkerMount:
        """Read section [walker.mount], as ``mobility-imu walker calibrate`` writes it."""
        found = read_arrays(
            path, "walker.mount", {"rotation_imu_to_body": (3, 3), "translation_body_m": (3,)}
        )
        if found is None:
            raise InputError(
                f"{path}: no section [walker.mount] (`mobility-imu walker calibrate` writes it)"
            )
        table = find_table(path, "walker.mount") or {}
        stated: dict[str, tuple[int, ...]] = {
            key: (3,) for key in ("rotation_sd_rad", "translation_sd_m") if key in table
        }
        found |= read_arrays(path, "walker.mount", stated) or {}
        try:
            return cls(**found)
        except InputError as error:
            raise InputError(f"{path}, [walker.mount]: {error}") from None
