"""How the two IMUs sit on a scooter: the turns from their real axes to the nominal ones."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.files import write_text
from mobility_imu.frames import FloatArray, as_rotation, as_series, as_vectors
from mobility_imu.readers.geometry import find_table, read_arrays
from mobility_imu.results import Result
from mobility_imu.scooter.geometry import ScooterGeometry

__all__ = ["ScooterMount"]

SECTION = "scooter.mount"
SD_KEY = "sd_rad"
KEYS = ("rotation_lever_imu_to_lever", "rotation_body_imu_to_body")


@dataclass(frozen=True, eq=False, repr=False)
class ScooterMount(Result):
    """Small rotations from the IMUs' real axes to the nominal ones of {T} and {B}.

    Parameters
    ----------
    rotation_lever_imu_to_lever, rotation_body_imu_to_body : (3, 3) arrays, copied
    sd_rad : (6,) array, rad, standard deviations about x, y, z of the lever's, then the body's IMU,
        as a calibration found them; None if no calibration did

    Raises
    ------
    InputError
        If a matrix is no rotation: of another shape, not orthogonal, or a mirror; if a standard
        deviation is negative.
    """

    rotation_lever_imu_to_lever: FloatArray
    rotation_body_imu_to_body: FloatArray
    sd_rad: FloatArray | None = None

    def __post_init__(self) -> None:
        """Check and copy both matrices."""
        for key in KEYS:
            object.__setattr__(self, key, as_rotation(getattr(self, key), key).copy())
        if self.sd_rad is not None:
            object.__setattr__(self, SD_KEY, _as_deviations(self.sd_rad))
        super().__post_init__()

    @np.errstate(over="ignore", invalid="ignore")  # beyond the largest number is infinity
    def lever(self, vectors: ArrayLike) -> FloatArray:
        """Turn the lever IMU's readings into {T}.

        Parameters
        ----------
        vectors : (..., 3) array, accelerations or rates in the IMU's axes

        Returns
        -------
        (..., 3) array
        """
        return as_vectors(vectors, "vectors") @ self.rotation_lever_imu_to_lever.T

    @np.errstate(over="ignore", invalid="ignore")  # beyond the largest number is infinity
    def body(self, vectors: ArrayLike) -> FloatArray:
        """Turn the body IMU's readings into {B}.

        Parameters
        ----------
        vectors : (..., 3) array, accelerations or rates in the IMU's axes

        Returns
        -------
        (..., 3) array
        """
        return as_vectors(vectors, "vectors") @ self.rotation_body_imu_to_body.T

    @classmethod
    def from_toml(cls, path: str | Path) -> ScooterMount:
        """Read [scooter.mount] of a geometry file; see :meth:`in_toml` for a file without it.

        Parameters
        ----------
        path : TOML file

        Returns
        -------
        ScooterMount

        Raises
        ------
        InputError
            If the file or the section is missing, or a matrix is missing or is no rotation.
        """
        mount = cls.in_toml(path)
        if mount is None:
            raise InputError(
                f"{path}: no section [{SECTION}]; 'mobility-imu scooter calibrate' writes it"
            )
        return mount

    @classmethod
    def in_toml(cls, path: str | Path) -> ScooterMount | None:
        """Read [scooter.mount] of a geometry file if it has that section.

        Parameters
        ----------
        path : TOML file

        Returns
        -------
        ScooterMount, or None if the section is not there

        Raises
        ------
        InputError
            If the file is missing, or a matrix is missing or is no rotation.
        """
        shapes: dict[str, tuple[int, ...]] = dict.fromkeys(KEYS, (3, 3))
        if SD_KEY in (find_table(path, SECTION) or {}):
            shapes[SD_KEY] = (6,)
        found = read_arrays(path, SECTION, shapes)
        if found is None:
            return None
        try:
            return cls(**found)
        except InputError as error:
            raise InputError(f"{path}, [{SECTION}] {error}") from None

    def to_toml(
        self,
        path: str | Path | None = None,
        *,
        geometry: ScooterGeometry | None = None,
        sd_rad: ArrayLike | None = None,
    ) -> str:
        """Text of a section [scooter.mount].

        Parameters
        ----------
        path : file to write the text to, too; an existing one is replaced
        geometry : ScooterGeometry, whose section then comes first: a whole geometry file
        sd_rad : (6,) array, rad, in place of the mount's own; written in deg as a comment, too

        Returns
        -------
        str
        """
        expect("geometry", geometry, ScooterGeometry, none=True)
        lines = [] if geometry is None else [*geometry.to_toml().splitlines(), ""]
        lines.append(f"[{SECTION}]")
        known = self.sd_rad if sd_rad is None else _as_deviations(sd_rad)
        if known is not None:
            sd = ", ".join(f"{value:.2f}" for value in np.rad2deg(known))
            lines.append(f"# sd in deg about x, y, z of the lever's, then the body's IMU: {sd}")
            lines.append(f"{SD_KEY} = {[round(float(value), 6) for value in known]}")
        for key in KEYS:
            rows = [[round(float(v), 6) for v in row] for row in getattr(self, key)]
            lines.append(f"{key} = {rows}")
        text = "\n".join(lines) + "\n"
        if path is not None:
            write_text(path, text)
        return text


def _as_deviations(sd_rad: ArrayLike) -> FloatArray:
    sd = as_series(sd_rad, SD_KEY, length=6)
    if (sd < 0).any():
        raise InputError(f"{SD_KEY} = {sd.tolist()}: expected six numbers from 0")
    return sd.copy()
