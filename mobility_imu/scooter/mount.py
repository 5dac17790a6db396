"""How the two IMUs sit on a scooter: the turns from their real axes to the nominal ones."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_vectors
from mobility_imu.readers.geometry import read_arrays


@dataclass(frozen=True)
class ScooterMount:
    """Small rotations from the IMUs' real axes to the nominal ones of {T} and {B}.

    Parameters
    ----------
    rotation_lever_imu_to_lever, rotation_body_imu_to_body : (3, 3) arrays
    sd_rad : (6,) array, rad, standard deviations about x, y, z of the lever's, then the body's IMU
    unseen : names of directions that the poses tell nothing of: the prior stays there
    """

    rotation_lever_imu_to_lever: FloatArray
    rotation_body_imu_to_body: FloatArray
    sd_rad: FloatArray
    unseen: tuple[str, ...]

    def lever(self, vectors: ArrayLike) -> FloatArray:
        """Turn the lever IMU's readings, (..., 3), into {T}."""
        return as_vectors(vectors, "vectors") @ self.rotation_lever_imu_to_lever.T

    def body(self, vectors: ArrayLike) -> FloatArray:
        """Turn the body IMU's readings, (..., 3), into {B}."""
        return as_vectors(vectors, "vectors") @ self.rotation_body_imu_to_body.T

    @classmethod
    def from_toml(cls, path: str | Path) -> ScooterMount | None:
        """Read [scooter.mount] of a geometry file; None if it is not there.

        Raises
        ------
        InputError
            If a matrix is missing or is no rotation.
        """
        keys = ("rotation_lever_imu_to_lever", "rotation_body_imu_to_body")
        found = read_arrays(path, "scooter.mount", dict.fromkeys(keys, (3, 3)))
        if found is None:
            return None
        for key, matrix in found.items():
            if not np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-3):
                raise InputError(f"{path}, [scooter.mount] {key}: expected a 3 x 3 rotation matrix")
        return cls(found[keys[0]], found[keys[1]], np.full(6, np.nan), ())
