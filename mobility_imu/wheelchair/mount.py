"""How the three IMUs sit on a chair. Frames: :mod:`mobility_imu.wheelchair.geometry`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.files import write_text
from mobility_imu.frames import FloatArray, as_rotation, as_vectors
from mobility_imu.readers.geometry import find_table, read_arrays
from mobility_imu.results import Result
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry, side_sign

__all__ = ["WheelchairMount"]

SECTION = "wheelchair.mount"
KEYS = (
    "rotation_left_imu_to_wheel",
    "rotation_right_imu_to_wheel",
    "rotation_frame_imu_to_chair",
)


@dataclass(frozen=True, eq=False, repr=False)
class WheelchairMount(Result):
    """How the three IMUs are fixed to the chair.

    Parameters
    ----------
    rotation_left_imu_to_wheel, rotation_right_imu_to_wheel : (3, 3) arrays; the wheel frame's z is
        the axle, positive when rolling forward (for both wheels). None for a wheel without a
        sensor; one of the two must be there
    rotation_frame_imu_to_chair : (3, 3) array; chair x forward, y left, z up

    Raises
    ------
    InputError
        If a matrix is no rotation, or both wheels have none.
    """

    rotation_left_imu_to_wheel: FloatArray | None
    rotation_right_imu_to_wheel: FloatArray | None
    rotation_frame_imu_to_chair: FloatArray

    def __post_init__(self) -> None:
        """Check and copy the rotations."""
        for name in KEYS:
            matrix = getattr(self, name)
            if matrix is not None:
                object.__setattr__(self, name, np.array(as_rotation(matrix, name)))
        if self.rotation_frame_imu_to_chair is None:
            raise InputError("rotation_frame_imu_to_chair: missing, expected a 3 x 3 rotation")
        if self.rotation_left_imu_to_wheel is None and self.rotation_right_imu_to_wheel is None:
            raise InputError(f"{KEYS[0]}, {KEYS[1]}: both missing, expected one or two rotations")
        super().__post_init__()

    @classmethod
    def from_toml(cls, path: str | Path) -> WheelchairMount:
        """Mount from section [wheelchair.mount] of a geometry file.

        Parameters
        ----------
        path : TOML file, as :meth:`to_toml` writes it

        Returns
        -------
        WheelchairMount

        Raises
        ------
        InputError
            If there is no such file or section, a key is missing or unknown, or a matrix is no
            rotation; the message names the file.
        """
        table = find_table(path, SECTION)
        if table is None:
            raise InputError(f"{path}: no section [{SECTION}] (`mount.to_toml(path)` writes it)")
        needed = [name for name in KEYS if name in table or name == KEYS[-1]]
        found = read_arrays(path, SECTION, dict.fromkeys(needed, (3, 3))) or {}
        try:
            return cls(found.get(KEYS[0]), found.get(KEYS[1]), found[KEYS[2]])
        except InputError as error:
            raise InputError(f"{path}, [{SECTION}]: {error}") from None

    def to_toml(
        self, path: str | Path | None = None, *, geometry: WheelchairGeometry | None = None
    ) -> str:
        """Text of section [wheelchair.mount], as :meth:`from_toml` reads it.

        Parameters
        ----------
        path : file to write the text into; None writes nothing
        geometry : WheelchairGeometry whose section is to stand before the mount's

        Returns
        -------
        str
        """
        expect("geometry", geometry, WheelchairGeometry, none=True)
        lines = [f"[{SECTION}]"]
        for name in KEYS:
            matrix = getattr(self, name)
            if matrix is not None:
                rows = [[round(float(value), 9) + 0.0 for value in row] for row in matrix]
                lines.append(f"{name} = {rows}")
        text = "\n".join(lines) + "\n"
        if geometry is not None:
            text = f"{geometry.to_toml()}\n{text}"
        if path is not None:
            write_text(path, text)
        return text

    def rotation_imu_to_wheel(self, side: Side) -> FloatArray:
        """Rotation of one wheel's IMU; its third row is the axle in the IMU's axes.

        Parameters
        ----------
        side : "left" or "right"

        Returns
        -------
        (3, 3) array

        Raises
        ------
        InputError
            If ``side`` is neither, or that wheel has no sensor.
        """
        left = side_sign(side) > 0
        matrix = self.rotation_left_imu_to_wheel if left else self.rotation_right_imu_to_wheel
        if matrix is None:
            raise InputError(
                f"the mount has no rotation for the {side} wheel's sensor: it is missing in the "
                "straight-line trial; calibrate with a trial that has it"
            )
        return matrix

    @np.errstate(over="ignore", invalid="ignore")  # beyond the largest number is infinity
    def wheel(self, side: Side, vectors_imu: ArrayLike) -> FloatArray:
        """Vectors that one wheel's IMU measured, in that wheel's frame.

        Parameters
        ----------
        side : "left" or "right"
        vectors_imu : (..., 3) array in the IMU's axes

        Returns
        -------
        (..., 3) array; z is the axle, positive when rolling forward
        """
        return as_vectors(vectors_imu, "vectors_imu") @ self.rotation_imu_to_wheel(side).T

    @np.errstate(over="ignore", invalid="ignore")  # beyond the largest number is infinity
    def frame(self, vectors_imu: ArrayLike) -> FloatArray:
        """Vectors that the frame's IMU measured, in the chair frame.

        Parameters
        ----------
        vectors_imu : (..., 3) array in the IMU's axes

        Returns
        -------
        (..., 3) array; x forward, y left, z up
        """
        return as_vectors(vectors_imu, "vectors_imu") @ self.rotation_frame_imu_to_chair.T
