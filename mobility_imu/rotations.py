"""Elementary rotations (by ``scipy.spatial.transform``) and cross products as matrices."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray, as_floats, as_vectors, one_of


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
    one_of("axis", axis, ("x", "y", "z"))
    angle = as_floats(angle_rad, "angle_rad")
    turns = np.zeros((angle.size, 3))
    turns[:, "xyz".index(axis)] = angle.ravel()
    return np.reshape(Rotation.from_rotvec(turns).as_matrix(), (*angle.shape, 3, 3))


def cross_matrix(vector: ArrayLike) -> FloatArray:
    """Matrix that forms the cross product with a vector: ``cross_matrix(a) @ b = a x b``.

    Parameters
    ----------
    vector : (3,) array

    Returns
    -------
    (3, 3) array, antisymmetric

    Examples
    --------
    >>> (cross_matrix([1, 0, 0]) @ [0, 1, 0]).tolist()
    [0.0, 0.0, 1.0]
    """
    x, y, z = as_vectors(vector, "vector", ndim=1)
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
