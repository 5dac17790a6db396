"""Recordings in which gravity is missing since an axis of an accelerometer says nothing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_clock
from mobility_imu.recording import PLAUSIBLE_ACC_MPS2, Imu, Recording
from mobility_imu.runs import FEWEST_VALUES


def recorded(time_s: FloatArray, sensors: Mapping[str, Imu], source: str) -> Recording:
    """Recording; where a dead axis is why gravity is missing, the error names that axis.

    Parameters
    ----------
    time_s : (n,) array, s
    sensors : sensor name to Imu
    source : the first words of a message

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        What a Recording refuses.
    """
    try:
        return Recording(time_s, sensors, source=source)
    except InputError:
        as_clock(time_s, f"{source}: time_s", even=True)  # a clock comes first
        for name, imu in sensors.items():
            if (k := _axis_without_gravity(imu.acc_mps2)) is not None:
                raise InputError(
                    f"{source}: {name}_acc_{'xyz'[k]} is {imu.acc_mps2[0, k] + 0.0:g} m/s² "
                    "throughout, while other axes move: it is dead, and gravity is missing; use "
                    "another sensor"
                ) from None
        raise


def _axis_without_gravity(acc_mps2: FloatArray) -> int | None:
    """Dead axis of an accelerometer that reads less than gravity, None if that is not why."""
    if not np.isfinite(acc_mps2).all():
        return None
    with np.errstate(over="ignore"):
        length = float(np.median(np.linalg.norm(acc_mps2, axis=1)))
    values = [len(np.unique(axis)) for axis in acc_mps2.T]
    if length >= PLAUSIBLE_ACC_MPS2[0] or max(values) <= FEWEST_VALUES or 1 not in values:
        return None
    return values.index(1)
