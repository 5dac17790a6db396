"""Named levels of what goes wrong, and the walker's five mountings, as the studies simulate them.

The paper's recordings are not published. The simulated frame has the five mountings of Table 1, at
three levels of what goes wrong. The sensor's noise and its gyroscope's bias are from data sheets;
its other errors and all sizes of frame and user are ours, set by hand when the paper's tables were
known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy import linalg

from mobility_imu.arguments import expect
from mobility_imu.frames import as_count, one_of
from mobility_imu.simulation.sensor import MTI_1, REAL, SensorModel, without
from mobility_imu.simulation.walker import (
    PERFECT,
    REALISTIC,
    Imperfections,
    SimulatedWalker,
    WalkerMotion,
    attach_imu,
    measured_geometry,
    simulate_tilts,
)
from mobility_imu.walker.geometry import FOOTPRINT, WalkerGeometry
from mobility_imu.walker.mount import WalkerMount

__all__ = [
    "DATASHEET",
    "FOOTPRINT",
    "LEVELS",
    "MOUNTS",
    "REAL_LEVEL",
    "Level",
    "tilt_run",
    "unit_of",
]

DATASHEET = without(MTI_1, "scale_sd", "misalignment_sd_rad", "g_sensitivity_sd")
"""The walker's sensor with the errors of its data sheet alone; noise, bias, range, bandwidth."""


@dataclass(frozen=True)
class Level:
    """What goes wrong in a simulation of the walker.

    Parameters
    ----------
    sensor : SensorModel
    imperfections : Imperfections of tilting and walking
    """

    sensor: SensorModel
    imperfections: Imperfections = PERFECT

    def __post_init__(self) -> None:
        """Check both parts."""
        expect("Level.sensor", self.sensor, SensorModel)
        expect("Level.imperfections", self.imperfections, Imperfections)


_REAL_FRAME = replace(REAL, gyr=replace(REAL.gyr, turn_on_bias_sd=float(np.deg2rad(0.57))))
REAL_LEVEL = Level(_REAL_FRAME, REALISTIC)
"""The sensor at the sizes that recordings of others show, on a frame that lands as "realistic".

The gyroscope's offset is that of real frames, 0.57 deg/s (median of 29 recordings at rest in
data/reference/real_sensors.csv); the wheels' of a chair are three times as large.
"""

LEVELS = MappingProxyType(
    {
        "data sheet": Level(DATASHEET),
        "sensor": Level(MTI_1),
        "realistic": Level(MTI_1, REALISTIC),
    }
)
"""Noise and bias of the data sheet; with errors of scale, axes and g-sensitivity; and with a frame
that slips, twists, trembles, rocks, creeps and lands hard."""

# Rotations and positions (by the first method) of Table 1, row by row. Two matrices are no
# rotations as printed: entry (3, 2) of pose 1 (printed -1.0017) and entry (1, 1) of pose 2 (printed
# 0.1563) have here the value that brings the matrix nearest to one, see `repaired_rotation` in
# mobility_imu/reproduction/walker/tables.py. A test holds them equal to the table.
_TABLE_1 = {
    "1": (
        (0.1563, 0.0119, -0.9876, 0.9873, 0.025, 0.1565, 0.0266, -0.9996157677217765, -0.0079),
        (0.4589, -0.212, 0.6268),
    ),
    "2": (
        (0.3306989358610166, -0.6062, -0.7229, -0.9318, -0.0898, -0.3507, 0.1478, 0.79, -0.595),
        (0.4996, 0.0159, 0.657),
    ),
    "3": (
        (0.0426, -0.87, -0.4902, 0.0618, 0.492, -0.8678, 0.9972, 0.0066, 0.0749),
        (0.1944, -0.2489, 0.358),
    ),
    "4": (
        (-0.1929, -0.5562, 0.808, -0.9442, 0.3286, 0.0008, -0.266, -0.7632, -0.5888),
        (0.4554, -0.1453, 0.5755),
    ),
    "5": (
        (-0.6299, -0.4139, -0.6566, -0.4547, -0.4886, 0.7442, -0.6293, 0.7679, 0.1196),
        (0.0917, 0.0264, 0.5654),
    ),
}


def _mount(rotation: tuple[float, ...], place_m: tuple[float, ...]) -> WalkerMount:
    nearest, _ = linalg.polar(np.reshape(rotation, (3, 3)))
    return WalkerMount(nearest, np.array(place_m))


MOUNTS = MappingProxyType({pose: _mount(*printed) for pose, printed in _TABLE_1.items()})
"""The five mountings of the paper's Table 1 by pose, "1" to "5", as simulations take them for true.

That is our choice, an assumption: nobody measured the true ones, and the positions by the paper's
second method lie 0.14 m away on average."""


def unit_of(seed: int, pose: str) -> int:
    """Seed of the sensor that records a pose.

    Parameters
    ----------
    seed : of the run
    pose : "1" to "5"

    Returns
    -------
    int
    """
    return 10 * as_count(seed, "seed", least=0) + int(one_of("pose", pose, tuple(MOUNTS)))


def tilt_run(
    seed: int, pose: str, level: Level, motion: WalkerMotion | None = None
) -> tuple[SimulatedWalker, WalkerGeometry]:
    """Calibration recording of a pose, and the footprint as the user's tape measures it.

    Parameters
    ----------
    seed : of the run; the same seed gives the same bytes
    pose : mounting of Table 1, "1" to "5"
    level : Level
    motion : WalkerMotion of the tilts; None simulates those of the seed and the level

    Returns
    -------
    SimulatedWalker and WalkerGeometry

    Raises
    ------
    InputError
        If the seed is negative or not whole, or there is no such pose.

    Examples
    --------
    >>> run, tape = tilt_run(1, "2", LEVELS["data sheet"])
    >>> len(run.tilts), tape == FOOTPRINT
    (4, True)
    """
    expect("level", level, Level)
    expect("motion", motion, WalkerMotion, none=True)
    unit = unit_of(seed, pose)
    if motion is None:
        motion = simulate_tilts(FOOTPRINT, seed=seed, imperfections=level.imperfections)
    run = attach_imu(motion, MOUNTS[pose], level.sensor, seed=unit, unit_seed=unit)
    return run, measured_geometry(FOOTPRINT, level.imperfections, seed)
