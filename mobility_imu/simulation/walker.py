"""A walking frame that is tilted for its calibration, or walked with, and an IMU fixed to it.

The rigid frame's position and orientation are written down as smooth functions of time; what the
IMU feels follows by differentiating its own path twice, no formula of an estimator is used. Every
size below is an assumption of ours unless it says where it is from. They were set by hand, with the
errors in the paper's tables known; what each one does is asked one at a time
(:func:`mobility_imu.reproduction.walker.studies.sources`).

World: z up, origin where the body's origin stands at the start, x where the body's x points then.
Body and IMU frames: :mod:`mobility_imu.walker.geometry`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.recording import Recording
from mobility_imu.simulation.kinematics import angular_rates, second_derivative
from mobility_imu.simulation.sensor import MTI_1, SensorModel, measure
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection, WalkerGeometry
from mobility_imu.walker.mount import WalkerMount

FAST_HZ = 500.0
"""Rate at which the true motion is written down; the fastest part, ringing, has 25 Hz."""


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


@dataclass(frozen=True)
class TiltStyle:
    """How somebody tilts the frame; each (low, high) is drawn from evenly, for each tilt.

    The paper asks for about 20 to 45 deg (section 1); the times are ours.

    Parameters
    ----------
    angle_rad : rad
    out_s, back_s : s, of the movements, both of least jerk
    hold_s : s, the frame is held tilted
    still_s : s, the frame stands after each tilt
    first_still_s : s, the frame stands before the first
    """

    angle_rad: tuple[float, float] = (_deg(20), _deg(45))
    out_s: tuple[float, float] = (1.0, 1.6)
    hold_s: tuple[float, float] = (0.7, 1.3)
    back_s: tuple[float, float] = (1.0, 1.6)
    still_s: tuple[float, float] = (1.5, 2.2)
    first_still_s: tuple[float, float] = (2.5, 3.0)

    def __post_init__(self) -> None:
        """Refuse what is no range."""
        _check_ranges(self)
        if self.angle_rad[1] > np.pi / 2:
            raise InputError(f"angle_rad = {self.angle_rad}: expected up to pi/2 (in deg?)")


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
        """Refuse what is no range."""
        _check_ranges(self)
        if self.pitch_rad[1] > np.pi / 4:
            raise InputError(f"pitch_rad = {self.pitch_rad}: expected up to pi/4 (in deg?)")


@dataclass(frozen=True)
class Imperfections:
    """How a real frame, floor and user depart from the plan; zero turns each one off.

    Each one draws from a random stream of its own: switching it off leaves the others as they are.

    Parameters
    ----------
    edge_slip_m : m, sd of how far the edge slides along the floor while the frame is tilted out,
        in any direction; it stays there
    edge_twist_rad : rad, sd of how far the frame yaws about the edge's middle while it is tilted
        out; it stays turned
    ferrule_edge_m : m, the edge that the frame turns about lies this far outside the line through
        the legs' axes, since rubber ferrules are wider than the legs
    tape_m : m, sd of the user's tape measure, see :func:`measured_geometry`
    hold_tremor_rad : rad, amplitude of the shaking about the edge while the frame is held, 2 to
        8 Hz (sd: amplitude over the root of 2), as if by a force that is white in this band
    rocking_rad : rad, sd of roll and pitch about the body's origin between two steps, near 1 Hz
    creep_sd_m : m, sd of how far the tips slide between two steps, always forward: abs(N)
    placement_sd_m : m, sd of where each step is placed against where it was aimed at, along and
        sideways; the next step is aimed at the course again, so that this does not add up
    landing_mps : m/s, sd of the velocity at touch-down per axis, the vertical one downward
    landing_stop_s : s, within which the floor stops it, by then at the place of the step
    landing_ringing_mps2 : m/s², amplitude of the frame's ringing after each touch-down before it
        decays (setting in makes the first peak half as large again), all of the frame alike, in a
        direction drawn anew
    landing_ringing_hz : Hz, its frequency is drawn from (low, high) for each touch-down
    landing_ringing_decay_s : s, time constant of its decay
    """

    edge_slip_m: float = 0.0
    edge_twist_rad: float = 0.0
    ferrule_edge_m: float = 0.0
    tape_m: float = 0.0
    hold_tremor_rad: float = 0.0
    rocking_rad: float = 0.0
    creep_sd_m: float = 0.0
    placement_sd_m: float = 0.0
    landing_mps: float = 0.0
    landing_stop_s: float = 0.03
    landing_ringing_mps2: float = 0.0
    landing_ringing_hz: tuple[float, float] = (20.0, 25.0)
    landing_ringing_decay_s: float = 0.05

    def __post_init__(self) -> None:
        """Refuse negative sizes."""
        for name, value in vars(self).items():
            if name != "landing_ringing_hz" and not (np.isfinite(value) and value >= 0):
                raise InputError(f"{name} = {value}: expected a number that is not negative")
        low, high = self.landing_ringing_hz
        if not 0 < low <= high <= FAST_HZ / 10:
            raise InputError(
                f"landing_ringing_hz = {self.landing_ringing_hz}: expected 0 < low <= high <= "
                f"{FAST_HZ / 10:g}"
            )
        if not 0.01 <= self.landing_stop_s <= 0.2:
            raise InputError(f"landing_stop_s = {self.landing_stop_s}: expected 0.01 to 0.2 s")
        if not 0.01 <= self.landing_ringing_decay_s <= 0.2:
            raise InputError(
                f"landing_ringing_decay_s = {self.landing_ringing_decay_s}: expected 0.01 to 0.2 s"
            )


PERFECT = Imperfections()
"""Edges that stay, legs without width, a frame that stands like a rock between its moves."""

REALISTIC = Imperfections(
    edge_slip_m=0.005,
    edge_twist_rad=_deg(1),
    ferrule_edge_m=0.015,
    tape_m=0.005,
    hold_tremor_rad=_deg(0.3),
    rocking_rad=_deg(0.06),
    creep_sd_m=0.002,
    placement_sd_m=0.03,
    landing_mps=0.02,
    landing_ringing_mps2=1.0,
)
"""Sizes that we hold to be plausible; nobody measured them, and the paper gives none."""


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
        """Refuse a negative length."""
        if not (np.isfinite(self.length_m) and self.length_m >= 0):
            raise InputError(f"length_m = {self.length_m}: expected a number that is not negative")
        if not abs(self.turn_rad) <= 2 * np.pi:
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


@dataclass(frozen=True)
class TiltTruth:
    """One tilt as it was.

    Parameters
    ----------
    direction : "front", "back", "right" or "left"
    angle_rad : rad, held
    start_s, held_from_s, held_until_s, stop_s : s
    """

    direction: TiltDirection
    angle_rad: float
    start_s: float
    held_from_s: float
    held_until_s: float
    stop_s: float


@dataclass(frozen=True)
class StepTruth:
    """One step of the frame as it was.

    Parameters
    ----------
    lift_s, place_s : s
    length_m : m, horizontal, of the body's origin; about 0 for a step that turns
    turn_rad : rad, to the left positive
    """

    lift_s: float
    place_s: float
    length_m: float
    turn_rad: float


@dataclass(frozen=True)
class WalkerMotion:
    """True motion of the rigid frame, at FAST_HZ.

    Parameters
    ----------
    time_s : (m,) array, s, from 0
    position_m : (m, 3) array, m, the body's origin in the world
    rotation_body_to_world : (m, 3, 3) array
    stationary : (m,) bool array, the frame stands on its four tips between two planned moves (it
        may still rock, creep or ring; held tilted it does not count as standing)
    tilts : of TiltTruth
    steps : of StepTruth
    """

    time_s: FloatArray
    position_m: FloatArray
    rotation_body_to_world: FloatArray
    stationary: NDArray[np.bool_]
    tilts: tuple[TiltTruth, ...] = ()
    steps: tuple[StepTruth, ...] = ()

    @cached_property
    def velocity_mps(self) -> FloatArray:
        """Velocity of the body's origin in the world, (m, 3), m/s."""
        return np.gradient(self.position_m, 1 / FAST_HZ, axis=0)

    @cached_property
    def rate_radps(self) -> FloatArray:
        """Angular rate in the body's axes, (m, 3), rad/s."""
        return angular_rates(self.rotation_body_to_world, 1 / FAST_HZ)

    @cached_property
    def specific_force_mps2(self) -> FloatArray:
        """Specific force at the body's origin in the body's axes, (m, 3), m/s²."""
        force = second_derivative(self.position_m, 1 / FAST_HZ)
        force[:, 2] += STANDARD_GRAVITY_MPS2
        return np.einsum("nij,ni->nj", self.rotation_body_to_world, force)

    @cached_property
    def arm_per_s2(self) -> FloatArray:
        """What a lever arm adds to the specific force, (m, 3, 3), 1/s², in the body's axes.

        R' d²R/dt², that is [alpha x] + [omega x]²: Euler and centripetal terms. Since an IMU's
        path is linear in its place, this is the same as differentiating that path twice.
        """
        turning = second_derivative(self.rotation_body_to_world, 1 / FAST_HZ)
        return np.swapaxes(self.rotation_body_to_world, 1, 2) @ turning


@dataclass(frozen=True)
class SimulatedWalker:
    """What an IMU on the frame recorded, and the truth when it took its samples.

    Parameters
    ----------
    recording : Recording of ``frame``, on the IMU's clock
    motion : WalkerMotion
    mount : WalkerMount, the true one
    time_s : (n,) array, s, when the samples were really taken
    position_body_m : (n, 3) array, m, the body's origin in the world
    rotation_body_to_world : (n, 3, 3) array
    position_imu_m : (n, 3) array, m, in the world
    velocity_imu_mps : (n, 3) array, m/s, in the world
    rotation_imu_to_world : (n, 3, 3) array
    stationary : (n,) bool array, as in :class:`WalkerMotion`
    """

    recording: Recording
    motion: WalkerMotion
    mount: WalkerMount
    time_s: FloatArray
    position_body_m: FloatArray
    rotation_body_to_world: FloatArray
    position_imu_m: FloatArray
    velocity_imu_mps: FloatArray
    rotation_imu_to_world: FloatArray
    stationary: NDArray[np.bool_]

    @property
    def tilts(self) -> tuple[TiltTruth, ...]:
        """Tilts of the motion."""
        return self.motion.tilts

    @property
    def steps(self) -> tuple[StepTruth, ...]:
        """Steps of the motion."""
        return self.motion.steps


def simulate_tilts(
    geometry: WalkerGeometry,
    *,
    seed: int,
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    style: TiltStyle | None = None,
    imperfections: Imperfections = PERFECT,
) -> WalkerMotion:
    """Tilt the frame about its edges, one after the other, as the calibration asks for.

    Parameters
    ----------
    geometry : WalkerGeometry, the true one
    seed : of angles, times and imperfections; the same seed gives the same bytes
    order : which tilts, by direction
    style : TiltStyle, or None for its standard values
    imperfections : Imperfections; those of walking do not matter here

    Returns
    -------
    WalkerMotion

    Raises
    ------
    InputError
        If there is no tilt, or a direction is unknown.
    """
    style = style or TiltStyle()
    if isinstance(order, str) or not len(order):
        raise InputError(f"order = {order!r}: expected at least one direction in a sequence")
    edges = [geometry.edge(direction) for direction in order]
    rng = np.random.default_rng([seed, 31])
    slips, twists, tremors = (np.random.default_rng([seed, 31, k]) for k in range(1, 4))
    clock = rng.uniform(*style.first_still_s)
    tilts = []
    for direction in order:
        angle = rng.uniform(*style.angle_rad)
        spans = [rng.uniform(*span) for span in (style.out_s, style.hold_s, style.back_s)]
        times = clock + np.cumsum([0.0, *spans])
        tilts.append(TiltTruth(direction, float(angle), *times.tolist()))
        clock = times[-1] + rng.uniform(*style.still_s)
    time_s = _fast_clock(clock)
    count = len(time_s)
    position, rotation = np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1))
    stationary = np.ones(count, bool)
    shaking = imperfections.hold_tremor_rad / np.sqrt(2) * _noise(count, 1, (2.0, 8.0), tremors)
    for tilt, edge in zip(tilts, edges, strict=True):
        first, last = np.searchsorted(time_s, [tilt.start_s, tilt.stop_s])
        now = time_s[first:last]
        out = _least_jerk((now - tilt.start_s) / (tilt.held_from_s - tilt.start_s))
        back = _least_jerk((now - tilt.held_until_s) / (tilt.stop_s - tilt.held_until_s))
        fade = 0.2 * (tilt.held_until_s - tilt.held_from_s)
        held = _window(now, tilt.held_from_s, tilt.held_until_s, fade)
        angle = tilt.angle_rad * (out - back) + held * shaking[first:last, 0]
        slip = imperfections.edge_slip_m * abs(slips.standard_normal())
        course = slips.uniform(0, 2 * np.pi)
        slide = slip * np.array([np.cos(course), np.sin(course), 0.0])
        twist = imperfections.edge_twist_rad * twists.standard_normal()
        standing, at = rotation[first].copy(), position[first].copy()
        outward = np.cross(edge.axis, [0, 0, 1])
        pivot = at + standing @ (edge.point_m + imperfections.ferrule_edge_m * outward)
        about = standing @ edge.axis

        def turned(yaw: FloatArray, tip: FloatArray, *, about: FloatArray = about) -> FloatArray:
            whole = Rotation.from_rotvec(np.outer(yaw, [0, 0, 1])) * Rotation.from_rotvec(
                np.outer(tip, about)
            )
            return whole.as_matrix()

        turn = turned(twist * out, angle)
        end = turned(np.array([twist]), np.zeros(1))[0]
        position[first:last] = pivot + np.outer(out, slide) + turn @ (at - pivot)
        rotation[first:last] = turn @ standing
        position[last:] = pivot + slide + end @ (at - pivot)
        rotation[last:] = end @ standing
        stationary[first:last] = False
    return WalkerMotion(time_s, position, rotation, stationary, tilts=tuple(tilts))


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
    lead forward. With :data:`PERFECT` the course is kept and its end is met.

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
        If the path is empty or has no length, or the duration is not positive.
    """
    style = style or WalkStyle()
    if not len(path) or not sum(leg.length_m for leg in path) > 0:
        raise InputError("path: expected at least one leg with a length")
    if duration_s is not None and not (np.isfinite(duration_s) and duration_s > 0):
        raise InputError(f"duration_s = {duration_s}: expected a positive number")
    rng = np.random.default_rng([seed, 32])
    streams = (np.random.default_rng([seed, 32, k]) for k in range(1, 6))
    rocks, creeps, misses, landings, rings = streams
    plan = _plan(path, style, rng, duration_s)
    count = len(plan.length_m)
    aimed = np.cumsum(plan.length_m[:, None] * _ahead(plan.facing_rad), axis=0)
    heading = np.cumsum(plan.turn_rad)
    miss = imperfections.placement_sd_m * misses.standard_normal((count, 2))
    ahead = _ahead(plan.facing_rad)
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    placed = aimed + miss[:, :1] * ahead + miss[:, 1:] * aside
    creep = imperfections.creep_sd_m * np.abs(creeps.standard_normal(count))
    creep[-1] = 0  # nobody leans on the frame any more
    left = placed + creep[:, None] * _ahead(heading)
    start = np.vstack([np.zeros(2), left[:-1]])
    lift, place = plan.lift_s, plan.lift_s + plan.swing_s
    after = np.r_[lift[1:], np.inf]

    time_s = _fast_clock(place[-1] + style.last_still_s)
    step = np.searchsorted(lift, time_s, side="right") - 1
    begun = step >= 0
    k = np.maximum(step, 0)
    swing = np.where(begun, (time_s - lift[k]) / plan.swing_s[k], 0.0)
    gone = _smooth(swing)
    hump = _hump(swing)
    rest = np.where(begun & (after[k] < np.inf), (time_s - place[k]) / (after[k] - place[k]), 0.0)
    position = np.zeros((len(time_s), 3))
    position[:, :2] = start[k] + gone[:, None] * (placed - start)[k]
    position[:, :2] += _smooth(rest)[:, None] * (left - placed)[k]
    position[:, 2] = plan.lift_m[k] * hump
    since = np.where(begun, time_s - place[k], -np.inf)
    position += _landing(swing, since, plan.swing_s[k], k, count, imperfections, landings)
    position += _ringing(since, k, count, imperfections, rings)
    yaw = (heading - plan.turn_rad)[k] + plan.turn_rad[k] * gone
    rotation = Rotation.from_euler("ZY", np.column_stack([yaw, -plan.pitch_rad[k] * hump]))
    rocking = imperfections.rocking_rad * _noise(len(time_s), 2, (0.7, 1.4), rocks)
    if imperfections.rocking_rad > 0:
        standing = begun & (after[k] < np.inf) & (since > 0)
        held = np.where(standing, _window(time_s, place[k], after[k], 0.3), 0.0)
        rocking = np.column_stack([rocking * held[:, None], np.zeros(len(time_s))])
        rotation = rotation * Rotation.from_rotvec(rocking)
    stop = imperfections.landing_stop_s if imperfections.landing_mps > 0 else 0.0
    moved = np.linalg.norm(placed - start, axis=1)
    steps = tuple(
        StepTruth(*row) for row in np.column_stack([lift, place, moved, plan.turn_rad]).tolist()
    )
    return WalkerMotion(
        time_s, position, rotation.as_matrix(), ~begun | (since >= stop), steps=steps
    )


def attach_imu(
    motion: WalkerMotion,
    mount: WalkerMount,
    sensor: SensorModel = MTI_1,
    *,
    seed: int,
    unit_seed: int,
    sampling_rate_hz: float = 100.0,
) -> SimulatedWalker:
    """Record a motion by an IMU that is fixed to the frame.

    Parameters
    ----------
    motion : WalkerMotion; what all its IMUs share is worked out once
    mount : WalkerMount, where the IMU really is
    sensor : SensorModel
    seed : of this power-up: biases, noise
    unit_seed : of this unit: scale factors, misalignments, clock
    sampling_rate_hz : Hz

    Returns
    -------
    SimulatedWalker

    Raises
    ------
    InputError
        If the sensor loses samples, which no Recording allows.
    """
    axes, arm = mount.rotation_imu_to_body, mount.translation_body_m
    force = motion.specific_force_mps2 + motion.arm_per_s2 @ arm
    output = measure(
        motion.time_s,
        force @ axes,
        motion.rate_radps @ axes,
        sensor,
        sampling_rate_hz=sampling_rate_hz,
        seed=seed,
        unit_seed=unit_seed,
    )
    recording = Recording(output.time_s, {"frame": output.imu}, source="simulated walker")
    # Truth between two fast times: from the nearest one on, by rate and acceleration.
    true = np.clip(output.true_time_s, motion.time_s[0], motion.time_s[-1])
    near = np.round(true * FAST_HZ).astype(int)
    ahead = (true - motion.time_s[near])[:, None]
    standing, rate = motion.rotation_body_to_world[near], motion.rate_radps[near]
    force_world = np.einsum("nij,nj->ni", standing, force[near])
    force_world[:, 2] -= STANDARD_GRAVITY_MPS2
    rotation = standing @ Rotation.from_rotvec(rate * ahead).as_matrix()
    spin = np.einsum("nij,nj->ni", standing, np.cross(rate, arm))
    velocity = motion.velocity_mps[near] + spin
    imu = motion.position_m[near] + standing @ arm
    imu = imu + velocity * ahead + force_world * ahead**2 / 2
    return SimulatedWalker(
        recording=recording,
        motion=motion,
        mount=mount,
        time_s=true,
        position_body_m=imu - rotation @ arm,
        rotation_body_to_world=rotation,
        position_imu_m=imu,
        velocity_imu_mps=velocity + force_world * ahead,
        rotation_imu_to_world=rotation @ axes,
        stationary=motion.stationary[near],
    )


def measured_geometry(
    geometry: WalkerGeometry, imperfections: Imperfections, seed: int
) -> WalkerGeometry:
    """Give the footprint as the user's tape gives it: both lengths off by N(0, tape_m).

    Parameters
    ----------
    geometry : WalkerGeometry, the true one
    imperfections : Imperfections
    seed : of the two errors

    Returns
    -------
    WalkerGeometry
    """
    width, length = imperfections.tape_m * np.random.default_rng([seed, 33]).standard_normal(2)
    return WalkerGeometry(
        geometry.footprint_width_m + float(width), geometry.footprint_length_m + float(length)
    )


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
    clock = 0.0
    while not rows or (duration_s is not None and clock < duration_s):
        for leg in path:
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
    length, turn, swing, stance, lift, pitch = np.hstack(rows)
    lift_s = style.first_still_s + np.r_[0.0, np.cumsum(swing + stance)[:-1]]
    facing = np.cumsum(turn) - turn
    made = lift_s < style.first_still_s + (np.inf if duration_s is None else duration_s)
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
    swing: FloatArray,
    since_s: FloatArray,
    swing_s: FloatArray,
    k: NDArray[np.intp],
    count: int,
    imperfections: Imperfections,
    rng: np.random.Generator,
) -> FloatArray:
    """Displacement (n, 3) that gives each touch-down a velocity and ends in the planned place."""
    touch = imperfections.landing_mps * rng.standard_normal((count, 3))
    touch[:, 2] = -np.abs(touch[:, 2])
    if imperfections.landing_mps == 0:
        return np.zeros((len(swing), 3))
    stop = imperfections.landing_stop_s
    u, w = np.clip(swing, 0, 1), np.clip(since_s / stop, 0, 1)
    e = u - 1
    # In the air: slope 1 at the end, where the value and two more derivatives are 0.
    arriving = swing_s * u**4 * e * (1 - 4 * e + 10 * e**2) - stop / 2 * _smooth(u)
    stopping = stop * (w - w**4 * (2.5 - 3 * w + w**2))
    return (arriving + stopping)[:, None] * touch[k]


def _ringing(
    since_s: FloatArray,
    k: NDArray[np.intp],
    count: int,
    imperfections: Imperfections,
    rng: np.random.Generator,
) -> FloatArray:
    """Displacement (n, 3) after each touch-down; it sets in within 20 ms."""
    omega = 2 * np.pi * rng.uniform(*imperfections.landing_ringing_hz, count)
    direction = rng.standard_normal((count, 3))
    if imperfections.landing_ringing_mps2 == 0:
        return np.zeros((len(since_s), 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    size = imperfections.landing_ringing_mps2 / omega**2
    since = np.maximum(since_s, 0.0)
    decay = np.exp(-since / imperfections.landing_ringing_decay_s)
    wave = size[k] * _smooth(since / 0.02) * decay * np.sin(omega[k] * since)
    return wave[:, None] * direction[k]


def _check_ranges(style: TiltStyle | WalkStyle) -> None:
    for name, value in vars(style).items():
        if isinstance(value, tuple):
            if len(value) != 2 or not 0 < value[0] <= value[1] < np.inf:
                raise InputError(f"{name} = {value}: expected 0 < low <= high")
        elif not 0 < value < np.inf:
            raise InputError(f"{name} = {value}: expected a positive number")


def _fast_clock(end_s: float) -> FloatArray:
    return np.arange(int(np.ceil(end_s * FAST_HZ)) + 1) / FAST_HZ


def _ahead(heading_rad: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(heading_rad), np.sin(heading_rad)])


def _least_jerk(u: FloatArray) -> FloatArray:
    """From 0 at u = 0 to 1 at u = 1 with least jerk; acceleration has no jumps."""
    u = np.clip(u, 0, 1)
    return u**3 * (10 - 15 * u + 6 * u**2)


def _smooth(u: FloatArray) -> FloatArray:
    """The same, one order smoother: sums of samples at 100 Hz are then as good as integrals."""
    u = np.clip(u, 0, 1)
    return u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3)


def _hump(u: FloatArray) -> FloatArray:
    """From 0 up to 1 at the middle and back, as smooth at both ends."""
    u = np.clip(u, 0, 1)
    return (4 * u * (1 - u)) ** 4


def _window(
    time_s: FloatArray, start_s: FloatArray | float, stop_s: FloatArray | float, fade_s: float
) -> FloatArray:
    """Rise to 1 after the start, and fall to 0 before the stop."""
    return _smooth((time_s - start_s) / fade_s) * _smooth((stop_s - time_s) / fade_s)


def _noise(
    count: int, columns: int, band_hz: tuple[float, float], rng: np.random.Generator
) -> FloatArray:
    """Displacement of sd 1 under a force that is white in a band: falls with frequency squared."""
    size = fft.next_fast_len(count, real=True)
    frequency = fft.rfftfreq(size, 1 / FAST_HZ)
    inside = np.nonzero((frequency >= band_hz[0]) & (frequency <= band_hz[1]))[0]
    spectrum = np.zeros((len(frequency), columns), complex)
    draws = rng.standard_normal((2, len(inside), columns))
    spectrum[inside] = (draws[0] + 1j * draws[1]) / frequency[inside, None] ** 2
    wave = fft.irfft(spectrum, size, axis=0)[:count]
    return wave / wave.std(axis=0)
