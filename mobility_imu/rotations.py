"""Elementary rotations, thin on ``scipy.spatial.transform``."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray


def elementary_rotation(axis: Literal["x", "y", "z"], angle_rad: ArrayLike) -> FloatArray:
    """Matrix that turns vectors by an angle about one coordinate axis, right-hand rule.

    Parameters
    ----------
    axis : "x", "y" or "z"
    angle_rad : (...) array, rad

    Returns
    -------
    (..., 3, 3) array

    Examples
    --------
    >>> (elementary_rotation("z", np.pi / 2) @ [1, 0, 0]).round(12).tolist()
    [0.0, 1.0, 0.0]
    """
    angle = np.asarray(angle_rad, float)
    turns = np.zeros((angle.size, 3))
    turns[:, "xyz".index(axis)] = angle.ravel()
    return Rotation.from_rotvec(turns).as_matrix().reshape(*angle.shape, 3, 3)
