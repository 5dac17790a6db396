"""The true motion of a walking frame, and what a real frame, floor and user do to it.

Every size below is an assumption of ours unless it says where it is from. They were set by hand,
with the errors in the paper's tables known; what each one does is asked one at a time
(:func:`mobility_imu.reproduction.walker.studies.sources`).

World: z up, origin where the body's origin stands at the start, x where the body's x points then.
Body frame: :mod:`mobility_imu.walker.geometry`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from mobility_imu.arguments import check_columns, check_limits
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_number,
    check_positive,
    one_of,
)
from mobility_imu.results import Result
from mobility_imu.simulation.checks import check_range
from mobility_imu.simulation.kinematics import angular_rates, second_derivative
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection

if TYPE_CHECKING:
    import pandas as pd


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


FAST_HZ = 500.0
"""Rate at which the true motion is written down; the fastest part, ringing, has 25 Hz."""
LONGEST_IN_ALL_S = 4e4
"""Eleven hours, more than the longest ``duration_s`` of a walk: as many samples take 8 GB."""


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
    tape_m : m, sd of the user's tape measure, see ``measured_geometry``
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
        """Check every size."""
        sizes = [f.name for f in fields(self) if f.name != "landing_ringing_hz"]
        check_positive(self, *sizes, allow_zero=sizes)
        turns = ("edge_twist_rad", "hold_tremor_rad", "rocking_rad")
        check_limits(self, dict.fromkeys(turns, (0.0, np.pi)))
        check_range(self.landing_ringing_hz, "landing_ringing_hz", most=FAST_HZ / 10)
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

    def __post_init__(self) -> None:
        """Check the direction and the numbers."""
        one_of("TiltTruth.direction", self.direction, TILT_DIRECTIONS)
        _check_numbers(self, "angle_rad", "start_s", "held_from_s", "held_until_s", "stop_s")


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

    def __post_init__(self) -> None:
        """Check the numbers."""
        _check_numbers(self, "lift_s", "place_s", "length_m", "turn_rad")


class Knots(NamedTuple):
    """When the frame stood at which part of its way.

    Parameters
    ----------
    time_s : (k + 1,) array, s, the first lift, then the k placements
    way_m : (k + 1,) array, m, horizontal way along the places where the frame was put down, from 0
    """

    time_s: FloatArray
    way_m: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class WalkerMotion(Result):
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

    def __post_init__(self) -> None:
        """Check that what belongs together has one length."""
        check_columns(self, "time_s", flags=("stationary",))
        count = len(self.time_s)
        check_fields(
            self,
            position_m=(count, 3),
            rotation_body_to_world=(count, 3, 3),
            tilts=[TiltTruth],
            steps=[StepTruth],
        )
        super().__post_init__()

    def __getstate__(self) -> dict[str, Any]:
        """State to pickle or copy: what is worked out from it is worked out again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def step_table(self) -> pd.DataFrame:
        """Table of the steps, columns as in :class:`StepTruth`."""
        import pandas as pd

        names = [field.name for field in fields(StepTruth)]
        rows = [[getattr(step, name) for name in names] for step in self.steps]
        return pd.DataFrame(rows, columns=names, dtype=float)

    def knots(self) -> Knots:
        """Times of the first lift and of the placements, and the way along the true places.

        The way is longer than the sum of the steps' lengths if the tips creep between two steps.

        Raises
        ------
        InputError
            If the motion has no step.
        """
        if not self.steps:
            raise InputError("motion: it has no step, expected a walk")
        place = np.array([step.place_s for step in self.steps])
        at = np.r_[0, np.searchsorted(self.time_s, place)]
        legs = np.linalg.norm(np.diff(self.position_m[at, :2], axis=0), axis=1)
        return Knots(np.r_[self.steps[0].lift_s, place], np.r_[0.0, np.cumsum(legs)])

    @cached_property
    def velocity_mps(self) -> FloatArray:
        """Velocity of the body's origin in the world, (m, 3), m/s."""
        return _read_only(np.gradient(self.position_m, 1 / FAST_HZ, axis=0))

    @cached_property
    def rate_radps(self) -> FloatArray:
        """Angular rate in the body's axes, (m, 3), rad/s."""
        return _read_only(angular_rates(self.rotation_body_to_world, 1 / FAST_HZ))

    @cached_property
    def specific_force_mps2(self) -> FloatArray:
        """Specific force at the body's origin in the body's axes, (m, 3), m/s²."""
        force = second_derivative(self.position_m, 1 / FAST_HZ)
        force[:, 2] += STANDARD_GRAVITY_MPS2
        return _read_only(np.einsum("nij,ni->nj", self.rotation_body_to_world, force))

    @cached_property
    def arm_per_s2(self) -> FloatArray:
        """What a lever arm adds to the specific force, (m, 3, 3), 1/s², in the body's axes.

        R' d²R/dt², that is [alpha x] + [omega x]²: Euler and centripetal terms. Since an IMU's
        path is linear in its place, this is the same as differentiating that path twice.
        """
        turning = second_derivative(self.rotation_body_to_world, 1 / FAST_HZ)
        return _read_only(np.swapaxes(self.rotation_body_to_world, 1, 2) @ turning)


def _check_numbers(truth: Any, *names: str) -> None:
    for name in names:
        as_number(getattr(truth, name), f"{type(truth).__name__}.{name}", negative=True)


def _read_only(values: FloatArray) -> FloatArray:
    values.setflags(write=False)
    return values


def fast_clock(end_s: float) -> FloatArray:
    """Times at FAST_HZ from 0 to an end or just beyond it, (m,), s.

    Parameters
    ----------
    end_s : s

    Raises
    ------
    InputError
        If the end is later than LONGEST_IN_ALL_S.
    """
    if end_s > LONGEST_IN_ALL_S:
        raise InputError(
            f"the motion lasts {end_s:.0f} s in all, expected up to {LONGEST_IN_ALL_S:g} s, eleven "
            "hours; shorten its parts or take fewer"
        )
    return np.arange(int(np.ceil(end_s * FAST_HZ)) + 1) / FAST_HZ


def band_noise(
    count: int, columns: int, band_hz: tuple[float, float], rng: np.random.Generator
) -> FloatArray:
    """Displacement of sd 1 under a force that is white in a band: falls with frequency squared.

    Parameters
    ----------
    count : number of samples at FAST_HZ
    columns : number of independent displacements
    band_hz : Hz, (low, high)
    rng : the source of the draws

    Returns
    -------
    (count, columns) array
    """
    size = fft.next_fast_len(count, real=True)
    frequency = fft.rfftfreq(size, 1 / FAST_HZ)
    inside = np.nonzero((frequency >= band_hz[0]) & (frequency <= band_hz[1]))[0]
    spectrum = np.zeros((len(frequency), columns), complex)
    draws = rng.standard_normal((2, len(inside), columns))
    spectrum[inside] = (draws[0] + 1j * draws[1]) / frequency[inside, None] ** 2
    wave = fft.irfft(spectrum, size, axis=0)[:count]
    return np.asarray(wave / wave.std(axis=0))
