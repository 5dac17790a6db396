"""A walking frame's footprint and its axes (Doan & Pham).

Frames:

* world: z up; where x points is a matter of choice, see :mod:`mobility_imu.walker.navigation`.
* body: origin on the floor midway between the rear tips C and D, x forward, y left, z up.
* IMU: the axes printed on the sensor.

Tips: A front left, B front right, C rear right, D rear left. Quaternions are Hamilton's, scalar
first, and turn IMU components into world components.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.files import write_text
from mobility_imu.frames import FloatArray, as_floats, as_number, one_of, shown
from mobility_imu.readers.geometry import read_section

__all__ = [
    "FOOTPRINT",
    "TILT_DIRECTIONS",
    "Edge",
    "TiltDirection",
    "WalkerGeometry",
    "rotation_body_to_world",
    "rotation_world_to_imu",
]

TiltDirection = Literal["front", "back", "right", "left"]
TILT_DIRECTIONS: tuple[TiltDirection, ...] = ("front", "back", "right", "left")
"""The four tilts, in the order of the paper's procedure."""


class Edge(NamedTuple):
    """An edge of the footprint that the frame can be tilted about.

    Parameters
    ----------
    point_m : (3,) array, m, body frame, middle of the edge
    axis : (3,) array, unit vector in the body frame; the tilt turns positively about it
    """

    point_m: FloatArray
    axis: FloatArray


@dataclass(frozen=True)
class WalkerGeometry:
    """What has to be measured on the walking frame.

    Parameters
    ----------
    footprint_width_m : float, m, AB = CD, between the left and the right tips
    footprint_length_m : float, m, AD = BC, between the rear and the front tips

    Raises
    ------
    InputError
        If a length is impossible; the message says which and guesses at a wrong unit.

    Examples
    --------
    >>> WalkerGeometry(0.60, 0.52).edge("left").point_m.tolist()
    [0.26, 0.3, 0.0]
    """

    footprint_width_m: float
    footprint_length_m: float

    def __post_init__(self) -> None:
        """Check that both lengths are those of a walking frame."""
        for name in ("footprint_width_m", "footprint_length_m"):
            length = as_number(getattr(self, name), name, negative=True)
            object.__setattr__(self, name, length)
            if not 0.2 <= length <= 1.2:
                hint = ""
                if 20 <= length <= 120:
                    hint = " (in cm?)"
                elif 200 <= length <= 1200:
                    hint = " (in mm?)"
                raise InputError(f"{name} = {length:g}: expected between 0.2 and 1.2 m{hint}")

    @classmethod
    def from_toml(cls, path: str | Path) -> WalkerGeometry:
        """Geometry from section [walker] of a geometry file.

        Parameters
        ----------
        path : TOML file
        """
        keys = ("footprint_width_m", "footprint_length_m")
        values = read_section(path, "walker", keys)
        try:
            return cls(**values)
        except InputError as error:
            raise InputError(f"{path}, [walker]: {error}") from None

    def to_toml(self, path: str | Path | None = None) -> str:
        """Section [walker] as the text of a geometry file.

        Parameters
        ----------
        path : file to write the text to; None writes none

        Returns
        -------
        str
        """
        text = (
            f"[walker]\nfootprint_width_m = {self.footprint_width_m}\n"
            f"footprint_length_m = {self.footprint_length_m}\n"
        )
        if path is not None:
            write_text(path, text)
        return text

    def edge(self, direction: TiltDirection) -> Edge:
        """Edge that a tilt goes about: AB front, CD back, BC right, AD left.

        Parameters
        ----------
        direction : way that the frame is tilted
        """
        width, length = self.footprint_width_m, self.footprint_length_m
        edges = {
            "front": ((length, 0, 0), (0, 1, 0)),
            "back": ((0, 0, 0), (0, -1, 0)),
            "right": ((length / 2, -width / 2, 0), (1, 0, 0)),
            "left": ((length / 2, width / 2, 0), (-1, 0, 0)),
        }
        point, axis = edges[one_of("direction", direction, TILT_DIRECTIONS)]
        return Edge(np.array(point, float), np.array(axis, float))


FOOTPRINT = WalkerGeometry(footprint_width_m=0.60, footprint_length_m=0.52)
"""Footprint of the drawn and of the simulated frame. That is an assumption; the paper gives none,
standard frames have it, and the positions of the paper's Table 1 fit into it."""


def rotation_world_to_imu(
    quaternion: ArrayLike, *, form: Literal["corrected", "printed"] = "corrected"
) -> FloatArray:
    """Rotation matrix C(q), world to IMU, of an attitude quaternion (eq. 1).

    In our text copy two entries repeat a neighbouring index, row 2 column 3 and row 3 column 2;
    that is no rotation, and the print may be right. The paper counts q(4) as the scalar here, and
    q(1) elsewhere.

    Parameters
    ----------
    quaternion : (..., 4) array, of length 1, Hamilton, scalar first, IMU to world
    form : "corrected", or "printed" for what our text copy has

    Returns
    -------
    (..., 3, 3) array

    Raises
    ------
    InputError
        If the length of a quaternion is not 1 (to 0.001): the matrix would be no rotation.

    Examples
    --------
    >>> rotation_world_to_imu([0.5**0.5, 0.0, 0.0, 0.5**0.5]).round(3).tolist()
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """
    one_of("form", form, ("corrected", "printed"))
    q = as_floats(quaternion, "quaternion")
    if q.shape[-1:] != (4,):
        raise InputError(f"quaternion: expected four components, got shape {q.shape}")
    q4, q1, q2, q3 = np.moveaxis(q, -1, 0)
    with np.errstate(over="ignore"):  # infinitely long is refused
        length = np.sqrt(q4**2 + q1**2 + q2**2 + q3**2)
    unit = np.abs(length - 1) < 1e-3
    if not unit.all():
        bad = float(length.ravel()[np.argmin(unit)])
        raise InputError(f"quaternion: of length {bad:.4g}, expected 1; divide by its length")
    yz, zy = (q2 * q3, q2 * q3) if form == "corrected" else (q1 * q2, q1 * q3)
    rows = [
        [q4**2 + q1**2 - q2**2 - q3**2, 2 * (q1 * q2 + q4 * q3), 2 * (q1 * q3 - q4 * q2)],
        [2 * (q1 * q2 - q4 * q3), q4**2 - q1**2 + q2**2 - q3**2, 2 * (yz + q4 * q1)],
        [2 * (q1 * q3 + q4 * q2), 2 * (zy - q4 * q1), q4**2 - q1**2 - q2**2 + q3**2],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotation_body_to_world(forward: Sequence[float] | FloatArray) -> FloatArray:
    """Body to world of a frame that stands upright, from its forward axis (eqs 2, 6).

    Parameters
    ----------
    forward : (3,) array, unit vector, horizontal, the body's x axis in the world

    Returns
    -------
    (3, 3) array with the body's axes as columns
    """
    x_axis, up = as_floats(forward, "forward"), np.array([0.0, 0.0, 1.0])
    unit = x_axis.shape == (3,) and bool((np.abs(x_axis) < 2).all())
    if not unit or abs(x_axis @ x_axis - 1) > 1e-9 or abs(x_axis[2]) > 1e-9:
        raise InputError(f"forward = {shown(forward)}: expected a horizontal unit vector")
    return np.column_stack([x_axis, np.cross(up, x_axis), up])
