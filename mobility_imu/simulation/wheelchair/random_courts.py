"""Courts drawn at random: chair, mounting, tasks and slips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import as_count, as_number
from mobility_imu.results import Result
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.sensor import SensorModel
from mobility_imu.simulation.wheelchair.chair import Leg, Mounting, check_mounting, random_mounting
from mobility_imu.simulation.wheelchair.court import SimulatedCourt, simulate_court
from mobility_imu.simulation.wheelchair.drive import STATIC_TRIAL, STRAIGHT_TRIAL
from mobility_imu.simulation.wheelchair.pushing import Pushing, SlipEpisode
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry


@dataclass(frozen=True, eq=False, repr=False)
class Court(Result):
    """All that a court consists of; every drive of it has the same chair and sensors.

    Parameters
    ----------
    legs, geometry, mounting, slips, toe_rad, pushing : as in ``simulate_court``
    seed : of sensors and noise
    """

    legs: tuple[Leg, ...]
    geometry: WheelchairGeometry
    mounting: dict[str, Mounting]
    slips: tuple[SlipEpisode, ...]
    toe_rad: float
    pushing: Pushing
    seed: int

    def __post_init__(self) -> None:
        """Check every part; whether the legs can be driven is found when they are."""
        check_fields(
            self,
            legs=[Leg],
            geometry=WheelchairGeometry,
            slips=[SlipEpisode],
            toe_rad=float,
            pushing=Pushing,
            seed=int,
        )
        as_number(self.toe_rad, "Court.toe_rad", negative=True)
        check_mounting(self.mounting)
        super().__post_init__()

    def drive(
        self, model: SensorModel | None = None, *, sampling_rate_hz: float = 100.0
    ) -> SimulatedCourt:
        """Drive the court.

        Parameters
        ----------
        model, sampling_rate_hz : as in ``simulate_court``

        Returns
        -------
        SimulatedCourt
        """
        return self._record(self.legs, self.slips, 0, model, sampling_rate_hz)

    def calibration_trials(
        self, model: SensorModel | None = None, *, sampling_rate_hz: float = 100.0
    ) -> tuple[SimulatedCourt, SimulatedCourt]:
        """Record the static and the straight-line trial with the same chair and sensors.

        Parameters
        ----------
        model, sampling_rate_hz : as in ``simulate_court``

        Returns
        -------
        two SimulatedCourt
        """
        return (
            self._record(STATIC_TRIAL, (), 1, model, sampling_rate_hz),
            self._record(STRAIGHT_TRIAL, (), 2, model, sampling_rate_hz),
        )

    def _record(
        self,
        legs: Sequence[Leg],
        slips: Sequence[SlipEpisode],
        trial: int,
        model: SensorModel | None,
        sampling_rate_hz: float,
    ) -> SimulatedCourt:
        return simulate_court(
            legs,
            self.geometry,
            self.mounting,
            seed=3 * self.seed + trial,
            unit_seed=self.seed,
            slips=slips,
            toe_rad=self.toe_rad,
            pushing=self.pushing,
            model=model,
            sampling_rate_hz=sampling_rate_hz,
        )


def random_court(
    seed: int, *, slips: int = 8, both_wheels_share: float = 0.15, largest_toe_rad: float = 0.017
) -> Court:
    """Draw a court: chair, mounting, order and size of the tasks, slips.

    Camber 0 to 24°, radii that differ by up to 1 %, all six tasks, turns to both sides. A slip
    lasts 0.2 to 1 s and is the only one of its leg; ten legs roll, so that there are ten at most.
    Of one wheel, half of them spin, by 0.4 to 1.5 m/s; half skid, by 40 to 100 % of the leg's
    speed.

    Parameters
    ----------
    seed : the same seed gives the same court
    slips : number of times that the chair slips, ten at most
    both_wheels_share : probability that the other wheel slips at the same time, by 80 to 120 % of
        the first one's amount. Both are then episodes in ``Court.slips``
    largest_toe_rad : rad, the toe is drawn between this inward and this outward (1°)

    Returns
    -------
    Court

    Raises
    ------
    InputError
        If a number is out of its range, or the seed is negative or not whole.
    """
    slips = as_count(slips, "slips", least=0)
    if not as_number(both_wheels_share, "both_wheels_share", zero=True) <= 1:
        raise InputError(f"both_wheels_share = {both_wheels_share:g}: expected from 0 to 1")
    if not as_number(largest_toe_rad, "largest_toe_rad", zero=True) <= np.pi / 4:
        raise InputError(f"largest_toe_rad = {largest_toe_rad:g}: expected up to pi/4 (in deg?)")
    rng = stream(seed, 17)
    radius = rng.uniform(0.28, 0.33)
    geometry = WheelchairGeometry(
        camber_rad=float(np.deg2rad(rng.uniform(0, 24))),
        wheel_radius_left_m=float(radius),
        wheel_radius_right_m=float(radius * rng.uniform(0.99, 1.01)),
        track_m=float(rng.uniform(0.70, 0.95)),
    )
    legs = _drawn_legs(rng)
    return Court(
        legs=legs,
        geometry=geometry,
        mounting=random_mounting(seed),
        slips=_drawn_slips(legs, slips, both_wheels_share, rng),
        toe_rad=float(rng.uniform(-largest_toe_rad, largest_toe_rad)),
        pushing=Pushing(
            push_s=float(rng.uniform(0.3, 0.45)),
            cycle_s=float(rng.uniform(0.8, 1.3)),
            coasting_mps2=float(rng.uniform(0.1, 0.25)),
        ),
        seed=seed,
    )


def _drawn_legs(rng: np.random.Generator) -> tuple[Leg, ...]:
    """All six tasks in any order, turns to both sides, rests where they are needed."""
    rest = Leg(1, 1.5)

    def turn(task: int, side: int) -> tuple[Leg, ...]:
        rate = rng.uniform(55, 80) if task == 6 else rng.uniform(90, 140)
        if task == 4:
            return rest, Leg(4, rng.uniform(2, 3), 0.0, side * rate), rest
        around = rng.uniform(0.8, 1.4) if task == 6 else rng.uniform(0.28, 0.42)
        return (Leg(task, rng.uniform(3, 4), np.deg2rad(rate) * around, side * rate),)

    parts = [turn(task, side) for task in (4, 5, 6) for side in (1, -1)]
    parts += [(Leg(2, rng.uniform(3, 6), rng.uniform(0.9, 2.5)),) for _ in range(4)]
    parts += [(rest, Leg(3, rng.uniform(3, 4), -rng.uniform(0.6, 1.2)), rest) for _ in range(2)]
    order = rng.permutation(len(parts))
    return (Leg(1, 2.0), *(leg for k in order for leg in parts[k]), Leg(1, 2.0))


def _drawn_slips(
    legs: Sequence[Leg], most: int, both_wheels_share: float, rng: np.random.Generator
) -> tuple[SlipEpisode, ...]:
    """At most one episode in each leg that rolls, or one of both wheels together."""
    starts = np.cumsum([0, *(leg.duration_s for leg in legs[:-1])])
    rolling = [k for k, leg in enumerate(legs) if leg.linear_velocity_mps]
    episodes: list[SlipEpisode] = []
    for k in rng.choice(rolling, min(most, len(rolling)), replace=False):
        leg, duration = legs[k], rng.uniform(0.2, 1.0)
        begin = starts[k] + rng.uniform(0.3, leg.duration_s - duration - 0.3)
        speed = leg.linear_velocity_mps
        spin = np.sign(speed) * rng.uniform(0.4, 1.5)
        skid = -speed * rng.uniform(0.4, 1.0)
        peak = float(spin if rng.random() < 0.5 else skid)
        rise = float(rng.uniform(0.05, 0.25))
        first: Side = "left" if rng.random() < 0.5 else "right"
        episodes.append(SlipEpisode(first, float(begin), float(duration), peak, rise))
        if rng.random() < both_wheels_share:
            other: Side = "right" if first == "left" else "left"
            alike = peak * float(rng.uniform(0.8, 1.2))
            episodes.append(SlipEpisode(other, float(begin), float(duration), alike, rise))
    return tuple(episodes)
