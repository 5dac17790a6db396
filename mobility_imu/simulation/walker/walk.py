"""Walks with the frame along a course: lift it, put it down further on, follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import check_limits, expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_number, shown
from mobility_imu.rotations import elementary_rotation
from mobility_imu.simulation.checks import LONGEST_M, LONGEST_S, check_ranges
from mobility_imu.simulation.profiles import hump, smooth, window
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.walker.motion import (
    PERFECT,
    Imperfections,
    StepTruth,
    WalkerMotion,
    band_noise,
    fast_clock,
)


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


@dataclass(frozen=True)
class WalkStyle:
    """How somebody walks with the frame; each (low, high) is drawn from evenly, for each step.

    All sizes are ours: about 0.13 m/s, a slow walk with a frame that is lifted.

    Parameters
    ----------
    length_m : m, of a step; the last one before a corner or the end is shortened
    lift_m : m, highest point of the rear tips
    swing_s : s, from lifting to placing
    pitch_rad : rad, front up by this while in the air
    stance_s : s, from placing to lifting
    turn_step_rad : rad, largest turn in one step
    first_still_s, last_still_s : s, the frame stands before the first and after the last step
    """

    length_m: tuple[float, float] = (0.30, 0.40)
    lift_m: tuple[float, float] = (0.03, 0.06)
    swing_s: tuple[float, float] = (0.8, 1.2)
    pitch_rad: tuple[float, float] = (_deg(3), _deg(8))
    stance_s: tuple[float, float] = (1.2, 2.0)
    turn_step_rad: float = _deg(30)
    first_still_s: float = 3.0
    last_still_s: float = 2.0

    def __post_init__(self) -> None:
        """Check every range."""
        check_ranges(self)
        if self.length_m[0] < 0.01:
            raise InputError(f"length_m = {self.length_m}: expected steps of 0.01 m or more")
        check_limits(self, {"turn_step_rad": (0.01, 2 * np.pi)})
        if self.pitch_rad[1] > np.pi / 4:
            raise InputError(f"pitch_rad = {self.pitch_rad}: expected up to pi/4 (in deg?)")


@dataclass(frozen=True)
class Leg:
    """A piece of a course: go straight, then turn on the spot.

    Parameters
    ----------
    length_m : m
    turn_rad : rad, to the left positive
    """

    length_m: float
    turn_rad: float = 0.0

    def __post_init__(self) -> None:
        """Check both numbers."""
        if as_number(self.length_m, "length_m", zero=True) > LONGEST_M:
            raise InputError(f"length_m = {self.length_m:g}: expected up to {LONGEST_M:g}")
        if abs(as_number(self.turn_rad, "turn_rad", negative=True)) > 2 * np.pi:
            raise InputError(f"turn_rad = {self.turn_rad}: expected within a full turn (in deg?)")


CORRIDOR = (Leg(10.0),)
"""The paper's first experiment (section 3), 10 m straight."""

RECTANGLE = tuple(Leg(length, np.pi / 2) for length in (5.0, 3.75, 5.0, 3.75))
"""The paper's second, 5 m by 3.75 m, here to the left, the last corner turned as well, so that the
frame ends with its first heading. The paper does not say whether its walkers turned there."""

RECTANGLE_OPEN = (*RECTANGLE[:-1], Leg(RECTANGLE[-1].length_m))
"""The same without the turn at the last corner. The end is the start, the heading 90 deg short. By
their directions 25 of the 30 rounds of Tables 3 and 4 ended so, if the end was corrected."""

TIMED_UP_AND_GO = (Leg(3.0, np.pi), Leg(3.0, np.pi))
"""Walking and turns of a Timed-Up and Go Test; the chair is not part of it."""

OUT_AND_BACK_30 = (Leg(30.0, np.pi), Leg(30.0, np.pi))
"""Up and down a 30 m hallway, as in a 6-Minute Walk Test (with ``duration_s=360``)."""


MOST_STEPS = 1_100_000
"""As many as the longest leg takes in the shortest steps, and some to turn."""


def simulate_walk(
    path: Sequence[Leg],
    *,
    seed: int,
    style: WalkStyle | None = None,
    imperfections: Imperfections = PERFECT,
    duration_s: float | None = None,
) -> WalkerMotion:
    """Walk a course: lift the frame, put it down further on, follow, lift it again.

    The frame turns about its body's origin, where the user's heels are; steps that turn do not
    lead forward. With ``PERFECT`` the course is kept and its end is met.

    Parameters
    ----------
    path : of Leg
    seed : of lengths, times and imperfections; the same seed gives the same bytes
    style : WalkStyle, or None for its standard values
    imperfections : Imperfections; those of tilting do not matter here
    duration_s : s, the course is repeated, without a pause, for so long after the first still
        period; the step that is being made then is finished. None for once through the course

    Returns
    -------
    WalkerMotion

    Raises
    ------
    InputError
        If the path is empty or has no length, the duration is not positive, the whole takes more
        steps or time than fit into memory, or the seed is negative or not whole.
    """
    style = settings_or_default("style", style, WalkStyle)
    expect("imperfections", imperfections, Imperfections)
    legs = isinstance(path, Sequence) and len(path) and all(isinstance(leg, Leg) for leg in path)
    if not legs:
        raise InputError(f"path = {shown(path)}: expected at least one Leg in a sequence")
    if not sum(leg.length_m for leg in path) > 0:
        raise InputError("path: expected at least one leg with a length")
    if duration_s is not None:
        duration_s = as_number(duration_s, "duration_s")
        if duration_s > LONGEST_S:
            raise InputError(
                f"duration_s = {duration_s:g}: expected up to {LONGEST_S:g} s, ten hours"
            )
    rocks, creeps, misses, landings, rings = (stream(seed, 32, k) for k in range(1, 6))
    plan = _plan(path, style, stream(seed, 32), duration_s)
    places = _places(plan, imperfections, misses, creeps)
    lift, place = plan.lift_s, plan.lift_s + plan.swing_s
    time_s = fast_clock(place[-1] + style.last_still_s)
    phase = _phase(time_s, plan)
    position = _positions(phase, plan, places)
    position += _landing(phase, plan, imperfections, landings)
    position += _ringing(phase, len(lift), imperfections, rings)
    stop = imperfections.landing_stop_s if imperfections.landing_mps > 0 else 0.0
    moved = np.linalg.norm(places.placed_m - places.start_m, axis=1)
    steps = np.column_stack([lift, place, moved, plan.turn_rad]).tolist()
    return WalkerMotion(
        time_s,
        position,
        _rotations(time_s, phase, plan, imperfections, rocks),
        ~phase.begun | (phase.since_s >= stop),
        steps=tuple(StepTruth(*row) for row in steps),
    )


class _Places(NamedTuple):
    """Where the frame stands, (k, 2) arrays, m: at the lift, as placed, and when it is left."""

    start_m: FloatArray
    placed_m: FloatArray
    left_m: FloatArray


def _places(
    plan: _Plan,
    imperfections: Imperfections,
    misses: np.random.Generator,
    creeps: np.random.Generator,
) -> _Places:
    """Aimed places with what they are missed by, and what the tips creep before the next lift."""
    count = len(plan.length_m)
    ahead = _ahead(plan.facing_rad)
    aimed = np.cumsum(plan.length_m[:, None] * ahead, axis=0)
    miss = imperfections.placement_sd_m * misses.standard_normal((count, 2))
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    placed = aimed + miss[:, :1] * ahead + miss[:, 1:] * aside
    creep = imperfections.creep_sd_m * np.abs(creeps.standard_normal(count))
    creep[-1] = 0  # nobody leans on the frame any more
    left = placed + creep[:, None] * _ahead(np.cumsum(plan.turn_rad))
    return _Places(np.vstack([np.zeros(2), left[:-1]]), placed, left)


class _Phase(NamedTuple):
    """Where in which step each time lies, (n,) arrays.

    Parameters
    ----------
    step : number of the step that was begun last
    begun : whether one was begun at all
    followed : whether another step follows
    swing, rest : 0 to 1 within its swing and within the rest after it
    since_s : s, since the frame was placed; negative in the air, minus infinity before the first
    place_s, after_s : s, when it is placed, and when it is lifted again (infinity for the last)
    """

    step: NDArray[np.intp]
    begun: NDArray[np.bool_]
    followed: NDArray[np.bool_]
    swing: FloatArray
    rest: FloatArray
    since_s: FloatArray
    place_s: FloatArray
    after_s: FloatArray


def _phase(time_s: FloatArray, plan: _Plan) -> _Phase:
    lift, place = plan.lift_s, plan.lift_s + plan.swing_s
    after = np.r_[lift[1:], np.inf]
    step = np.searchsorted(lift, time_s, side="right") - 1
    begun = step >= 0
    k = np.maximum(step, 0)
    swing = np.where(begun, (time_s - lift[k]) / plan.swing_s[k], 0.0)
    followed = begun & (after[k] < np.inf)
    rest = np.where(followed, (time_s - place[k]) / (after[k] - place[k]), 0.0)
    since = np.where(begun, time_s - place[k], -np.inf)
    return _Phase(k, begun, followed, swing, rest, since, place[k], after[k])


def _positions(phase: _Phase, plan: _Plan, places: _Places) -> FloatArray:
    """Path of the body's origin without touch-downs, (n, 3), m."""
    k = phase.step
    gone, crept = smooth(phase.swing)[:, None], smooth(phase.rest)[:, None]
    position = np.zeros((len(k), 3))
    position[:, :2] = places.start_m[k] + gone * (places.placed_m - places.start_m)[k]
    position[:, :2] += crept * (places.left_m - places.placed_m)[k]
    position[:, 2] = plan.lift_m[k] * hump(phase.swing)
    return position


def _rotations(
    time_s: FloatArray,
    phase: _Phase,
    plan: _Plan,
    imperfections: Imperfections,
    rng: np.random.Generator,
) -> FloatArray:
    """Yaw and pitch of the steps, and the rocking between them: body to world, (n, 3, 3)."""
    k = phase.step
    before = np.cumsum(plan.turn_rad) - plan.turn_rad
    yaw = before[k] + plan.turn_rad[k] * smooth(phase.swing)
    pitch = -plan.pitch_rad[k] * hump(phase.swing)
    rotation = elementary_rotation("z", yaw) @ elementary_rotation("y", pitch)
    if imperfections.rocking_rad == 0:
        return rotation
    rocking = imperfections.rocking_rad * band_noise(len(time_s), 2, (0.7, 1.4), rng)
    standing = phase.followed & (phase.since_s > 0)
    held = np.where(standing, window(time_s, phase.place_s, phase.after_s, 0.3), 0.0)
    rocking = np.column_stack([rocking * held[:, None], np.zeros(len(time_s))])
    return np.asarray(rotation @ Rotation.from_rotvec(rocking).as_matrix())


@dataclass(frozen=True)
class _Plan:
    """Steps as planned, one row each; facing is the heading before a step's turn."""

    length_m: FloatArray
    turn_rad: FloatArray
    facing_rad: FloatArray
    lift_s: FloatArray
    swing_s: FloatArray
    lift_m: FloatArray
    pitch_rad: FloatArray


def _plan(
    path: Sequence[Leg], style: WalkStyle, rng: np.random.Generator, duration_s: float | None
) -> _Plan:
    rows: list[FloatArray] = []
    clock, steps = 0.0, 0
    for leg in path if duration_s is None else cycle(path):
        lengths = _step_lengths(leg.length_m, style, rng)
        turns = int(np.ceil(abs(leg.turn_rad) / style.turn_step_rad - 1e-9))
        count = len(lengths) + turns
        spans = [
            rng.uniform(*span, count)
            for span in (style.swing_s, style.stance_s, style.lift_m, style.pitch_rad)
        ]
        moves = np.zeros((2, count))
        moves[0, : len(lengths)] = lengths
        moves[1, len(lengths) :] = leg.turn_rad / max(turns, 1)
        rows.append(np.vstack([moves, *spans]))
        clock += float(spans[0].sum() + spans[1].sum())
        steps += count
        if steps > MOST_STEPS:
            raise InputError(f"path: more than {MOST_STEPS} steps; shorten it, or take longer ones")
        if duration_s is not None and clock >= duration_s:
            break
    length, turn, swing, stance, lift, pitch = np.hstack(rows)
    lift_s = style.first_still_s + np.r_[0.0, np.cumsum(swing + stance)[:-1]]
    facing = np.cumsum(turn) - turn
    made = lift_s < style.first_still_s + (np.inf if duration_s is None else duration_s)
    if not made.any():  # so short that the sum is not later than the first lift
        raise InputError(f"duration_s = {duration_s:g}: no step begins in so short a time")
    return _Plan(*(part[made] for part in (length, turn, facing, lift_s, swing, lift, pitch)))


def _step_lengths(length_m: float, style: WalkStyle, rng: np.random.Generator) -> FloatArray:
    """Steps that make up a straight; the last is what is left, shared if that is very little."""
    drawn = rng.uniform(*style.length_m, int(np.ceil(length_m / style.length_m[0])) + 1)
    if length_m == 0:
        return drawn[:0]
    count = int(np.searchsorted(np.cumsum(drawn), length_m - 1e-9)) + 1
    lengths = drawn[:count]
    lengths[-1] = length_m - lengths[:-1].sum()
    if count > 1 and lengths[-1] < style.length_m[0] / 2:
        lengths[-2:] = lengths[-2:].mean()
    return lengths


def _landing(
    phase: _Phase, plan: _Plan, imperfections: Imperfections, rng: np.random.Generator
) -> FloatArray:
    """Displacement (n, 3) that gives each touch-down a velocity and ends in the planned place."""
    touch = imperfections.landing_mps * rng.standard_normal((len(plan.lift_s), 3))
    touch[:, 2] = -np.abs(touch[:, 2])
    if imperfections.landing_mps == 0:
        return np.zeros((len(phase.swing), 3))
    stop = imperfections.landing_stop_s
    u, w = np.clip(phase.swing, 0, 1), np.clip(phase.since_s / stop, 0, 1)
    e = u - 1
    # In the air: slope 1 at the end, where the value and two more derivatives are 0.
    arriving = plan.swing_s[phase.step] * u**4 * e * (1 - 4 * e + 10 * e**2) - stop / 2 * smooth(u)
    stopping = stop * (w - w**4 * (2.5 - 3 * w + w**2))
    return (arriving + stopping)[:, None] * touch[phase.step]


def _ringing(
    phase: _Phase, count: int, imperfections: Imperfections, rng: np.random.Generator
) -> FloatArray:
    """Displacement (n, 3) after each touch-down; it sets in within 20 ms."""
    omega = 2 * np.pi * rng.uniform(*imperfections.landing_ringing_hz, count)
    direction = rng.standard_normal((count, 3))
    if imperfections.landing_ringing_mps2 == 0:
        return np.zeros((len(phase.since_s), 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    size = imperfections.landing_ringing_mps2 / omega**2
    k, since = phase.step, np.maximum(phase.since_s, 0.0)
    decay = np.exp(-since / imperfections.landing_ringing_decay_s)
    wave = size[k] * smooth(since / 0.02) * decay * np.sin(omega[k] * since)
    return wave[:, None] * direction[k]


def _ahead(heading_rad: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(heading_rad), np.sin(heading_rad)])
