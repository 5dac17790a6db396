"""What the steps of a simulated walk are in truth, for tests and chapters."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.simulation.walker import WalkerMotion


def true_steps(motion: WalkerMotion) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Lift and placement, s, length, m, and turn, rad, of each step: four (k,) arrays.

    Parameters
    ----------
    motion : WalkerMotion with k steps
    """
    rows = [(s.lift_s, s.place_s, s.length_m, s.turn_rad) for s in motion.steps]
    lift, place, length, turn = np.array(rows, float).reshape(-1, 4).T
    return lift, place, length, turn


def true_knots(motion: WalkerMotion) -> tuple[FloatArray, FloatArray]:
    """First lift and placements, s, and the way along the true places, m: two (k + 1,) arrays.

    The way is longer than the sum of the steps' lengths if the tips creep between two steps.

    Parameters
    ----------
    motion : WalkerMotion with k steps, at least one
    """
    lift, place, _, _ = true_steps(motion)
    at = np.r_[0, np.searchsorted(motion.time_s, place)]
    legs = np.linalg.norm(np.diff(motion.position_m[at, :2], axis=0), axis=1)
    return np.r_[lift[0], place], np.r_[0.0, np.cumsum(legs)]
