"""Simulated walks whose steps are known, for the chapters on steps and on walking tests."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, one_of
from mobility_imu.recording import Recording
from mobility_imu.simulation.levels import FOOTPRINT, LEVELS, MOUNTS
from mobility_imu.simulation.walker import (
    CORRIDOR,
    RECTANGLE,
    TIMED_UP_AND_GO,
    Imperfections,
    Leg,
    WalkerMotion,
    WalkStyle,
    attach_imu,
    simulate_walk,
)
from mobility_imu.walker.steps import GaitSettings, Steps, find_steps
from mobility_imu.walker.trajectory import Trajectory, estimate_trajectory

COURSES = MappingProxyType(
    {"10 m": (CORRIDOR, 20), "rectangle": (RECTANGLE, 3), "out and back": (TIMED_UP_AND_GO, 5)}
)
"""Courses on which steps are counted, and the number of walks on each."""


class GaitWalk(NamedTuple):
    """A simulated walk and what is found from its recording.

    Parameters
    ----------
    motion : WalkerMotion, the truth
    recording : Recording of the IMU on the frame
    trajectory : Trajectory estimated from the recording
    """

    motion: WalkerMotion
    recording: Recording
    trajectory: Trajectory


@lru_cache(maxsize=2)  # the levels of one walk share the motion
def _moved(
    course: tuple[Leg, ...],
    seed: int,
    style: WalkStyle | None,
    imperfections: Imperfections,
    duration_s: float | None,
) -> WalkerMotion:
    return simulate_walk(
        course, seed=seed, style=style, imperfections=imperfections, duration_s=duration_s
    )


def gait_walk(
    course: tuple[Leg, ...],
    seed: int,
    *,
    level: str = "realistic",
    style: WalkStyle | None = None,
    imperfections: Imperfections | None = None,
    duration_s: float | None = None,
) -> GaitWalk:
    """Simulate a walk and estimate its trajectory; the five poses of Table 1 take turns.

    Parameters
    ----------
    course : legs of the walk
    seed : of the walk and of the sensor; the same seed gives the same bytes
    level : name in :data:`mobility_imu.simulation.levels.LEVELS`
    style : WalkStyle; None takes the standard one
    imperfections : of the frame; None takes those of the level
    duration_s : s, the course is repeated until then; None walks it once

    Returns
    -------
    GaitWalk

    Raises
    ------
    InputError
        If the level is unknown, or ``simulate_walk`` refuses the
        walk.

    Examples
    --------
    >>> walk = gait_walk((Leg(1.0),), 0)
    >>> len(find_steps(walk.trajectory)) == len(walk.motion.steps)
    True
    """
    chosen = LEVELS[one_of("level", level, tuple(LEVELS))]
    frame = chosen.imperfections if imperfections is None else imperfections
    motion = _moved(course, seed, style, frame, duration_s)
    mount = list(MOUNTS.values())[seed % len(MOUNTS)]
    recording = attach_imu(motion, mount, chosen.sensor, seed=seed, unit_seed=seed).recording
    return GaitWalk(motion, recording, estimate_trajectory(recording, FOOTPRINT, mount))


def gait_walks(most: int | None = None) -> dict[tuple[str, str, int], GaitWalk]:
    """Simulate the walks of :data:`COURSES` at each level.

    Parameters
    ----------
    most : walks on each course and level; None takes all, 28 for each level

    Returns
    -------
    dict: (level, course, seed) -> GaitWalk
    """
    return {
        (level, name, seed): gait_walk(course, seed, level=level)
        for name, (course, count) in COURSES.items()
        for seed in range(count if most is None else min(most, count))
        for level in LEVELS
    }


def step_errors(walks: Iterable[GaitWalk], found: Iterable[Steps]) -> dict[str, FloatArray]:
    """Found minus true, step by step, over several walks.

    Parameters
    ----------
    walks : GaitWalks
    found : Steps found in each, as many as there truly are

    Returns
    -------
    dict of arrays with one entry for each step: ``lift_s``, ``place_s`` and ``swing_s`` in s,
    ``length_m`` in m, ``turn_rad`` in rad

    Raises
    ------
    InputError
        If the count of a walk is wrong: its steps cannot be matched.
    """
    parts: dict[str, list[FloatArray]] = {
        name: [] for name in ("lift_s", "place_s", "swing_s", "length_m", "turn_rad")
    }
    for walk, steps in zip(walks, found, strict=True):
        true = walk.motion.step_table()
        true["swing_s"] = true["place_s"] - true["lift_s"]
        if len(true) != len(steps):
            raise InputError(f"found: {len(steps)} steps in a walk of {len(true)}, expected equal")
        for name, values in parts.items():
            values.append(getattr(steps, name) - true[name].to_numpy())
    return {name: np.hstack(values) for name, values in parts.items()}


def percent_exact(walks: Sequence[GaitWalk], settings: GaitSettings | None = None) -> float:
    """Percentage of walks in which as many steps are found as there truly are.

    Parameters
    ----------
    walks : GaitWalks
    settings : GaitSettings; None takes the standard ones

    Returns
    -------
    float, percent
    """
    exact = [len(find_steps(w.trajectory, settings)) == len(w.motion.steps) for w in walks]
    return float(100 * np.mean(exact))
