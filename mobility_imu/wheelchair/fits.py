"""Least squares with the scatter of whole pieces of a drive.

Residuals of neighbouring samples depend on each other: a stroke or a slip lasts. Those of one piece
are taken together, whatever depends on what in it (cluster-robust covariance).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.runs import changes_of

__all__ = ["covariance_by_pieces", "fit_by_pieces", "pieces_of"]


def pieces_of(count: int, length_s: float, rate_hz: float) -> NDArray[np.int64]:
    """Number of the piece that each sample belongs to.

    Parameters
    ----------
    count : samples
    length_s : s, of one piece
    rate_hz : Hz

    Returns
    -------
    (count,) int array, ascending

    Examples
    --------
    >>> pieces_of(5, 1.0, 2.0).tolist()
    [0, 0, 1, 1, 2]
    """
    return np.arange(count) // max(1, round(length_s * rate_hz))


def fit_by_pieces(
    design: FloatArray, target: FloatArray, piece: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Least squares, and its covariance from the scatter of whole pieces of residuals.

    Parameters
    ----------
    design : (n, k) array
    target : (n,) array
    piece : (n,) int array, ascending, from :func:`pieces_of`; pieces may lack samples

    Returns
    -------
    found : (k,) array
    covariance : (k, k) array
    """
    found = np.asarray(np.linalg.lstsq(design, target, rcond=None)[0], float)
    return found, covariance_by_pieces(design, target - design @ found, piece)


def covariance_by_pieces(
    design: FloatArray, residual: FloatArray, piece: NDArray[np.int64]
) -> FloatArray:
    """Covariance of a least-squares fit from the scatter of whole pieces of its residuals.

    Of G pieces and k unknowns, the covariance has the factor G / (G - k): few pieces are fitted too
    well by chance.

    Parameters
    ----------
    design : (n, k) array
    residual : (n,) array, of the fit
    piece : (n,) int array, ascending, from :func:`pieces_of`; pieces may lack samples

    Returns
    -------
    (k, k) array
    """
    starts = changes_of(piece)
    sums = np.add.reduceat(design * residual[:, None], starts, axis=0)
    bread = np.linalg.pinv(design.T @ design)
    unexplained = max(len(starts) - design.shape[1], 1)
    return np.asarray(bread @ (sums.T @ sums) @ bread * len(starts) / unexplained)
