"""How an IMU is fixed to a walking frame. Frames: :mod:`mobility_imu.walker.geometry`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.files import write_text
from mobility_imu.frames import FloatArray, as_rotation, as_vectors
from mobility_imu.readers.geometry import find_table, read_arrays
from mobility_imu.results import Result
from mobility_imu.walker.geometry import WalkerGeometry

__all__ = ["REACH_M", "WalkerMount"]

REACH_M = 2.0
"""No frame carries an IMU further from the middle of its rear tips."""


@dataclass(frozen=True, eq=False, repr=False)
class WalkerMount(Result):
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
        """Check that the matrix is a rotation and the position within reach."""
        arrays = {
            "rotation_imu_to_body": as_rotation(self.rotation_imu_to_body, "rotation_imu_to_body"),
            "translation_body_m": as_vectors(
                self.translation_body_m, "translation_body_m", ndim=1, finite=True
            ),
        }
        place = arrays["translation_body_m"]
        if np.abs(place).max() > REACH_M:
            raise InputError(
                f"translation_body_m = {place.tolist()}: expected within {REACH_M:g} m "
                "(in cm or mm?)"
            )
        for name, most in (("rotation_sd_rad", np.pi), ("translation_sd_m", REACH_M)):
            value = getattr(self, name)
            if value is not None:
                arrays[name] = as_vectors(value, name, ndim=1)
                if not ((arrays[name] >= 0) & (arrays[name] <= most)).all():
                    raise InputError(
                        f"{name} = {arrays[name].tolist()}: expected three numbers between 0 and "
                        f"{most:.3g}; leave it out if it is not known"
                    )
        for name, array in arrays.items():
            object.__setattr__(self, name, array.copy())
        super().__post_init__()

    @classmethod
    def from_toml(cls, path: str | Path) -> WalkerMount:
        """Mount from section [walker.mount], as ``mobility-imu walker calibrate`` writes it.

        Parameters
        ----------
        path : TOML file
        """
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

    def to_toml(
        self,
        path: str | Path | None = None,
        *,
        geometry: WalkerGeometry | None = None,
        comment: str = "",
    ) -> str:
        """Section [walker.mount] as the text of a geometry file.

        Parameters
        ----------
        path : file to write the text to; None writes none
        geometry : WalkerGeometry, written before it as section [walker]
        comment : first line of the section, such as how the mount was found

        Returns
        -------
        str
        """
        expect("geometry", geometry, WalkerGeometry, none=True)
        expect("comment", comment, str)
        remark = " ".join("".join(c if c.isprintable() else " " for c in comment).split())
        lines = ["[walker.mount]", *([f"# {remark}"] if remark else [])]
        for name, digits in (
            ("translation_sd_m", 5),
            ("rotation_sd_rad", 5),
            ("rotation_imu_to_body", 6),
            ("translation_body_m", 4),
        ):
            value = getattr(self, name)
            if value is not None:
                rounded = np.vectorize(lambda v, digits=digits: round(float(v), digits))(value)
                lines.append(f"{name} = {rounded.tolist()}")
        text = "\n".join(lines) + "\n"
        if geometry is not None:
            text = f"{geometry.to_toml()}\n{text}"
        if path is not None:
            write_text(path, text)
        return text
