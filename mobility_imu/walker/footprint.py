"""The footprint that the arcs of the tilts show, held against the tape's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray
from mobility_imu.walker.arc_fit import ArcFit
from mobility_imu.walker.geometry import TILT_DIRECTIONS, WalkerGeometry
from mobility_imu.walker.tilt_detection import Tilt

__all__ = ["ACROSS", "FOOTPRINT_WORDS", "footprint_by_arcs", "footprint_warnings"]

ACROSS = {"front": 0, "back": 0, "right": 1, "left": 1}
"""What an edge across x or across y says: the component of the position."""
FOOTPRINT_WORDS = "by the arcs the footprint's"
FOOTPRINT_OFF_M, OTHER_WAY_OFF_M = 0.1, 0.04
"""Differences, in m, between a side of the footprint by the arcs and by the tape. Below the first a
side is not told; from the second on it is, if the sides fit twice as well when they are exchanged.
Our choice: the largest error of 60 simulated calibrations of the level "realistic" is 6 cm. None
of them fits twice as well with its sides exchanged, and 2 of 150 of the level "real"."""
FOOTPRINT_TIMES, FERRULES_M = 3.0, 0.03
"""Standard deviations by the sensor's errors within which a side is not told, one in 370 of normal
errors, and by how much rubber tips make both sides longer: each turns on its outer rim. Our choice:
of 150 simulated calibrations of the level "real" 3 are told, 2 by the rule of exchanged sides."""


def footprint_by_arcs(
    fits: Sequence[ArcFit], tilts: Sequence[Tilt], imu_to_body: FloatArray
) -> tuple[float, float]:
    """Width and length between opposite edges, NaN where only one of them was used.

    Parameters
    ----------
    fits, tilts : of each arc
    imu_to_body : (3, 3) array

    Returns
    -------
    float, float : m
    """
    arms: dict[str, list[float]] = {name: [] for name in TILT_DIRECTIONS}
    for fit, tilt in zip(fits, tilts, strict=True):
        arms[tilt.direction].append(float((imu_to_body @ fit.arm_imu_m)[ACROSS[tilt.direction]]))
    middle = {name: float(np.mean(v)) if v else np.nan for name, v in arms.items()}
    return middle["right"] - middle["left"], middle["back"] - middle["front"]


def footprint_warnings(
    footprint: tuple[float, float], geometry: WalkerGeometry, sd_m: ArrayLike = (0.0, 0.0)
) -> list[str]:
    """Warn of sides that the arcs have otherwise than the tape, beyond what the sensor's errors do.

    Parameters
    ----------
    footprint : m, width and length by the arcs
    geometry : WalkerGeometry, by the tape
    sd_m : (2,) array, m, standard deviations of both by the sensor's errors

    Returns
    -------
    list of str
    """
    measured = (geometry.footprint_width_m, geometry.footprint_length_m)
    swapped = [abs(f - m) for f, m in zip(footprint, measured[::-1], strict=True)]
    apart = [abs(f - m) for f, m in zip(footprint, measured, strict=True)]
    both = bool(np.isfinite(footprint).all())
    other_way = both and max(apart) > OTHER_WAY_OFF_M and max(swapped) < max(apart) / 2
    hint = ""
    if other_way:
        hint = (
            "; width and length fit the other way round: was the first tilt to a side, "
            "or are they swapped in the file?"
        )
    most = np.maximum(FOOTPRINT_OFF_M, FERRULES_M + FOOTPRINT_TIMES * np.asarray(sd_m))
    if other_way:
        most = np.full(2, OTHER_WAY_OFF_M)
    return [
        f"{FOOTPRINT_WORDS} {name} is {found:.3f} m, measured {tape:.3f} m{hint}"
        for name, found, tape, off, limit in zip(
            ("width", "length"), footprint, measured, apart, most, strict=True
        )
        if off > limit
    ]
