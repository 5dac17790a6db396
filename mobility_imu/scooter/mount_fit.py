"""Least squares by which parked poses give the turns of both IMUs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import optimize
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.rotations import cross_matrix

__all__ = ["MountFit"]


class MountFit(NamedTuple):
    """Weighted misfit of eq. 5, and the prior, by the turns of both IMUs.

    Parameters
    ----------
    lever, body : (n, 3) arrays, directions that the sensors read, in their own axes
    lever_to_body : (n, 3, 3) array, the product in eq. 5 at the stated angles
    pose_sd_rad, prior_sd_rad : rad, that each row is divided by
    """

    lever: FloatArray
    body: FloatArray
    lever_to_body: FloatArray
    pose_sd_rad: float
    prior_sd_rad: float

    def _upright(self, turns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Directions in the axes of lever and body."""
        of_lever, of_body = Rotation.from_rotvec(turns.reshape(2, 3)).as_matrix()
        return self.lever @ of_lever.T, self.body @ of_body.T

    def solved(self) -> optimize.OptimizeResult:
        """Result of the least squares: ``x``, the turns, and ``jac``.

        Raises
        ------
        InputError
            If they do not end.
        """
        found = optimize.least_squares(self.misfit, np.zeros(6), self.slopes, method="lm")
        if not found.success:
            raise InputError(
                f"the poses fit no mount: the least squares did not end ({found.message})"
            )
        return found

    def misfit(self, turns: FloatArray) -> FloatArray:
        """Three rows for each pose, six for the prior.

        Parameters
        ----------
        turns : (6,) array, rad, rotation vectors of lever and body

        Returns
        -------
        (3 n + 6,) array
        """
        lever, body = self._upright(turns)
        apart = lever - np.einsum("nji,nj->ni", self.lever_to_body, body)
        return np.asarray(np.r_[apart.ravel() / self.pose_sd_rad, turns / self.prior_sd_rad])

    def slopes(self, turns: FloatArray) -> FloatArray:
        """Change of the misfit by each component of the two rotation vectors.

        Parameters
        ----------
        turns : (6,) array, rad

        Returns
        -------
        (3 n + 6, 6) array
        """
        lever, body = self._upright(turns)
        of_lever = np.cross(_small_turns(turns[:3]).T, lever[:, None]).swapaxes(-1, -2)
        of_body = np.cross(body[:, None], _small_turns(turns[3:]).T).swapaxes(-1, -2)
        of_body = np.swapaxes(self.lever_to_body, -1, -2) @ of_body
        by_turns = np.concatenate([of_lever, of_body], axis=-1)
        rows = by_turns.reshape(-1, 6) / self.pose_sd_rad, np.eye(6) / self.prior_sd_rad
        return np.concatenate(rows)


def _small_turns(rotvec: FloatArray) -> FloatArray:
    """Turn that each change of a rotation vector adds after it: left Jacobian of SO(3), (3, 3)."""
    angle = float(np.linalg.norm(rotvec))
    if angle < 1e-6:
        return np.eye(3) + cross_matrix(rotvec) / 2
    axis = cross_matrix(rotvec / angle)
    sine = np.sin(angle) / angle
    return np.asarray(np.eye(3) + (1 - np.cos(angle)) / angle * axis + (1 - sine) * axis @ axis)
