"""Suzurikawa et al. 2022: the driving test predicted from the static test.

Scooters are drawn from what Table 1 allows (:mod:`~mobility_imu.reproduction.scooter.posterior`),
and each is driven over the five courses by four drivers, three times. The static table is the only
thing that is fitted; no number of the driving test is looked at. Other sets of scooters stand
beside: drawn from the priors alone, from tables with shuffled headings, from the other reading of
"left side slope", and from Table 1 with each cell at half its weight.

What of a table carries over to a ride: the turns of both IMUs, as they are; the reading noise of
the two reference angles, as play of the wires, as wide as gives this noise if all of it is
backlash; the slopes do not, they belong to the rows of the table. Sizes of the ride that neither
the table nor the paper gives are those of the driving test; a second layer sweeps them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.frames import FloatArray, wrap_angle
from mobility_imu.reproduction.scooter.driving_rides import (
    ANGLES,
    DRIVERS,
    PUBLISHED_LIMIT_DEG,
    RUNS,
    Conditions,
    motion_and_truth,
    paper_estimates,
)
from mobility_imu.reproduction.scooter.posterior import (
    NAMES,
    Draws,
    Run,
    Sampling,
    diagnose,
    draw_run,
    identified,
    join_runs,
)
from mobility_imu.reproduction.scooter.table1_fit import shuffled_tables
from mobility_imu.reproduction.scooter.table1_model import (
    BODY_TURN,
    LEVER_TURN,
    NOISE,
    TableCost,
    cell_sd,
    published_table,
    table_checksum,
)
from mobility_imu.simulation.scooter import (
    COURSES,
    NO_SHAKING,
    SMOOTH_GROUND,
    Course,
    Reference,
    ScooterUnit,
    Segment,
    SimulatedRide,
    draw_driver,
    simulate_ride,
)
from mobility_imu.simulation.sensor import IDEAL

if TYPE_CHECKING:
    import pandas as pd

ESTIMATORS = ("single", "dual")
SCOOTERS = 100
SWEPT_SCOOTERS = 24
PLAY_PER_NOISE = 2.0
"""Width of the backlash over the sd of the reading, if a control is approached from either side;
the wire is half a width behind or ahead."""
SEED = 1
PRINTED = Sampling()
SHUFFLED = Sampling(runs=2, steps=1000)
SHUFFLED_TABLES = 4


BASE = "as assumed"
SETS = ("posterior", "prior", "shuffled", "other side", "half weight")
"""All sets of scooters, 100 in each of the first three, 24 in the others."""


class Column(NamedTuple):
    """One 90 % error of the driving test."""

    angle: str
    estimator: str
    course: str


CELLS = tuple(Column(a, e, c) for a in ANGLES for e in ESTIMATORS for c in COURSES)
"""The twenty 90 % errors of Figure 9, in the order of all arrays here."""


@dataclass(frozen=True)
class Variation:
    """What the rides are made of, beside the scooter.

    Parameters
    ----------
    conditions : Conditions; of its reference, the plays are replaced where ``play_from_noise``
    curve_radius_m : m, of the course "curves"
    right_side_up : whether the "right-sided slope" of the course "side" has its right side up
    play_from_noise : whether the wires' play comes from the scooter's reading noise
    drivers, runs : how many of each, on every course
    """

    conditions: Conditions = field(default_factory=Conditions)
    curve_radius_m: float = 1.6
    right_side_up: bool = True
    play_from_noise: bool = True
    drivers: int = DRIVERS
    runs: int = RUNS


def unit_of(faults_deg: ArrayLike, number: int) -> ScooterUnit:
    """The scooter with these faults.

    Parameters
    ----------
    faults_deg : (18,) array, deg, in the order of
        :data:`~mobility_imu.reproduction.scooter.posterior.NAMES`
    number : of the scooter; its sensors' constants are drawn from it

    Returns
    -------
    ScooterUnit
    """
    fault = _by_name(faults_deg)
    lever, body = (
        np.deg2rad([fault[name] for name in turn]).tolist() for turn in (LEVER_TURN, BODY_TURN)
    )
    return ScooterUnit(tuple(lever), tuple(body), number)


def reference_of(faults_deg: ArrayLike, reference: Reference) -> Reference:
    """A reference whose plays are those that the reading noise asks for; see PLAY_PER_NOISE.

    Parameters
    ----------
    faults_deg : (18,) array, deg, faults of a scooter
    reference : Reference without them

    Returns
    -------
    Reference
    """
    fault = _by_name(faults_deg)
    steering, throttle = (float(np.deg2rad(PLAY_PER_NOISE * fault[name])) for name in NOISE)
    return replace(reference, steering_play_rad=steering, throttle_play_rad=throttle)


def _by_name(faults_deg: ArrayLike) -> dict[str, float]:
    faults = np.asarray(faults_deg, float)
    if faults.shape != (len(NAMES),):
        raise InputError(f"faults_deg: shape {faults.shape}, expected ({len(NAMES)},)")
    return dict(zip(NAMES, faults.tolist(), strict=True))


def curves(radius_m: float) -> Course:
    """Course "curves" with another radius, m: four quarter circles and what lies between.

    Parameters
    ----------
    radius_m : m

    Returns
    -------
    Course
    """
    segments = tuple(
        segment
        if segment.curvature_pm == 0
        else Segment(np.pi / 2 * radius_m, float(np.sign(segment.curvature_pm)) / radius_m)
        for segment in COURSES["curves"].segments
    )
    return Course("curves", segments)


def course_of(name: str, variation: Variation) -> Course:
    """A course as a variation lays it.

    Parameters
    ----------
    name : in ``mobility_imu.simulation.scooter.COURSES``
    variation : Variation

    Returns
    -------
    Course
    """
    if name == "curves":
        return curves(variation.curve_radius_m)
    if name == "side" and not variation.right_side_up:
        segments = (one._replace(bank_rad=-one.bank_rad) for one in COURSES[name].segments)
        return Course(name, tuple(segments))
    return COURSES[name]


def ride_scooter(
    number: int, faults_deg: ArrayLike, course: str, driver: int, run: int, variation: Variation
) -> SimulatedRide:
    """Drive a scooter once. Rides of one number share seeds, whatever its faults.

    Parameters
    ----------
    number : of the scooter
    faults_deg : (18,) array, deg
    course : name
    driver, run : numbers
    variation : Variation

    Returns
    -------
    SimulatedRide
    """
    of = variation.conditions
    reference = of.reference
    if variation.play_from_noise:
        reference = reference_of(faults_deg, reference)
    place = list(COURSES).index(course)
    return simulate_ride(
        course_of(course, variation),
        seed=((number * len(COURSES) + place) * 16 + driver) * 16 + run,
        unit=unit_of(faults_deg, number),
        driver=draw_driver(driver),
        layout=of.layout,
        ground=of.ground,
        shaking=of.shaking,
        reference=reference,
        sensor=of.sensor,
    )


def drive_scooter(
    number: int, faults_deg: Sequence[float], variation: Variation | None = None
) -> FloatArray:
    """Drive a scooter over all courses and give its twenty 90 % errors.

    Parameters
    ----------
    number : of the scooter
    faults_deg : (18,) array, deg
    variation : Variation; None is that of the driving test

    Returns
    -------
    (20,) array, deg, in the order of :data:`CELLS`: 90th percentile of the absolute error against
    the wires, over the samples in motion of all drivers and runs
    """
    variation = variation or Variation()
    p90 = {}
    for course in COURSES:
        found: dict[str, list[FloatArray]] = {name: [] for name in ESTIMATORS}
        wires = []
        for driver, run in np.ndindex(variation.drivers, variation.runs):
            ride = ride_scooter(number, faults_deg, course, driver, run, variation)
            moving, truth = motion_and_truth(ride)
            wires.append(truth["wire"])
            for name, angles in paper_estimates(
                ride, moving, ESTIMATORS, window=variation.conditions.median_window
            ).items():
                found[name].append(angles)
        for name, pieces in found.items():
            off = np.rad2deg(wrap_angle(np.concatenate(pieces) - np.concatenate(wires)))
            for angle, value in zip(ANGLES, np.quantile(np.abs(off), 0.9, axis=0), strict=True):
                p90[Column(angle, name, course)] = float(value)
    return np.array([p90[cell] for cell in CELLS])


def holds(p90_deg: FloatArray) -> FloatArray:
    """Whether the four statements of section 3.2 hold for scooters.

    Parameters
    ----------
    p90_deg : (n, 20) array, deg, in the order of :data:`CELLS`

    Returns
    -------
    (n, 4) bool array, columns as :data:`~mobility_imu.reproduction.scooter.driving.STATEMENTS`:
    dual below 10 deg and 5 deg, dual below single in steering and throttle, on all courses
    """
    by = np.asarray(p90_deg).reshape(-1, len(ANGLES), len(ESTIMATORS), len(COURSES))
    single, dual = by[:, :, 0], by[:, :, 1]
    limit = np.array([PUBLISHED_LIMIT_DEG[angle] for angle in ANGLES])
    below = (dual < limit[:, None]).all(axis=2)
    return np.concatenate([below, (dual < single).all(axis=2)], axis=1)


def largest_dual(p90_deg: FloatArray) -> FloatArray:
    """Largest 90 % error of two IMUs over the courses, (n, 2), deg: steering and throttle.

    Parameters
    ----------
    p90_deg : (n, 20) array, deg, in the order of :data:`CELLS`

    Returns
    -------
    (n, 2) array, deg
    """
    by = np.asarray(p90_deg).reshape(-1, len(ANGLES), len(ESTIMATORS), len(COURSES))
    return np.asarray(by[:, :, 1].max(axis=2))


def quantiles(p90_deg: FloatArray) -> pd.DataFrame:
    """5 %, 50 % and 95 % of every cell over scooters.

    Parameters
    ----------
    p90_deg : (n, 20) array, deg, in the order of :data:`CELLS`

    Returns
    -------
    DataFrame, index ``angle``, ``estimator``, ``course``; columns ``low``, ``middle``, ``high``
    """
    import pandas as pd

    return pd.DataFrame(
        np.quantile(p90_deg, [0.05, 0.5, 0.95], axis=0).T,
        columns=["low", "middle", "high"],
        index=pd.MultiIndex.from_tuples(CELLS, names=Column._fields),
    )


def variations() -> Mapping[str, Variation]:
    """The second layer: sizes without a source, one at a time, then all kinds of shaking off."""
    plain = Variation()
    of = plain.conditions
    shake, ground = of.shaking, of.ground

    def shaken(**sizes: Any) -> Variation:
        return replace(plain, conditions=replace(of, shaking=replace(shake, **sizes)))

    def laid(**sizes: Any) -> Variation:
        return replace(plain, conditions=replace(of, ground=replace(ground, **sizes)))

    wire = of.reference
    return MappingProxyType(
        {
            BASE: plain,
            "vibration: none": shaken(vibration_mps2=0.0),
            "vibration: twice": shaken(vibration_mps2=2 * shake.vibration_mps2),
            "blows: none": shaken(spikes_per_s=0.0),
            "floor: half as rough": laid(roughness_m=ground.roughness_m / 2),
            "floor: twice as rough": laid(roughness_m=2 * ground.roughness_m),
            "floor: level": laid(grade_sd_rad=0.0, bank_sd_rad=0.0),
            "tactile bumps: none": laid(tactile_m=0.0),
            "tactile bumps: half": laid(tactile_m=ground.tactile_m / 2),
            "tactile bumps: twice": laid(tactile_m=2 * ground.tactile_m),
            "curves: radius 1.2 m": replace(plain, curve_radius_m=1.2),
            "curves: radius 2.5 m": replace(plain, curve_radius_m=2.5),
            "curves: radius 4 m": replace(plain, curve_radius_m=4.0),
            "side slope: left side up": replace(plain, right_side_up=False),
            "play: 1° and 0.6°": replace(plain, play_from_noise=False),
            "play: none": replace(
                plain,
                play_from_noise=False,
                conditions=replace(
                    of, reference=replace(wire, steering_play_rad=0.0, throttle_play_rad=0.0)
                ),
            ),
            "sensors: ideal": replace(plain, conditions=replace(of, sensor=IDEAL)),
            "no shaking at all": replace(
                plain, conditions=replace(of, shaking=NO_SHAKING, ground=SMOOTH_GROUND)
            ),
        }
    )


class Posterior(NamedTuple):
    """One posterior, as it is sampled: what to fit, how long, from which seed."""

    cost: TableCost
    sampling: Sampling
    seed: tuple[int, ...]


def posteriors() -> dict[str, list[Posterior]]:
    """The posteriors behind each set of scooters."""
    printed = published_table()
    wider = np.sqrt(2) * cell_sd(printed)
    shuffled = shuffled_tables(printed, "both", count=SHUFFLED_TABLES, seed=SEED)
    return {
        "posterior": [Posterior(TableCost(printed, NAMES), PRINTED, (SEED, 0))],
        "other side": [Posterior(TableCost(printed, NAMES, 1), PRINTED, (SEED, 1))],
        "half weight": [Posterior(TableCost(printed, NAMES, spread_deg=wider), PRINTED, (SEED, 9))],
        "shuffled": [
            Posterior(TableCost(table, NAMES), SHUFFLED, (SEED, 2 + k))
            for k, table in enumerate(shuffled)
        ],
    }


def draw_scooters(name: str, found: Sequence[Draws]) -> FloatArray:
    """Scooters of one set, (n, 18), deg, rounded as they are recorded.

    Parameters
    ----------
    name : of the set
    found : Draws of its posteriors

    Returns
    -------
    (n, 18) array, deg
    """
    if name == "prior":
        rng = np.random.default_rng([SEED, 99])
        cost = TableCost(published_table(), NAMES)
        values = cost.prior_sd_deg * rng.standard_normal((SCOOTERS, len(NAMES)))
        values = np.where(cost.is_noise, np.abs(values), values)
    else:
        count = SCOOTERS if name in ("posterior", "shuffled") else SWEPT_SCOOTERS
        values = np.concatenate([draws.thinned_deg(count // len(found)) for draws in found])
    return np.round(values, 3)


def sample_all(executor: Executor | None = None) -> dict[str, list[Draws]]:
    """Draw all posteriors, run by run.

    Parameters
    ----------
    executor : anything with ``submit``, which then gets one task per run; None computes here

    Returns
    -------
    dict of lists of Draws, one for each table, in the order of :func:`posteriors`
    """
    todo = [
        (name, k, one.cost, one.sampling, (*one.seed, run))
        for name, several in posteriors().items()
        for k, one in enumerate(several)
        for run in range(one.sampling.runs)
    ]
    runs: list[Run] = run_all(draw_run, [task[2:] for task in todo], executor)
    found: dict[str, list[Draws]] = {}
    for name, several in posteriors().items():
        found[name] = [
            join_runs(
                one.cost,
                [run for task, run in zip(todo, runs, strict=True) if task[:2] == (name, k)],
            )
            for k, one in enumerate(several)
        ]
    return found


def recorded_prediction(executor: Executor | None = None) -> dict[str, Any]:
    """Sample, draw and drive everything; see the record of this name.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here. The same bytes for any.

    Returns
    -------
    dict with ``numbers``: ``names``, ``posteriors`` (diagnosis of each), ``faults_deg`` and
    ``p90_deg`` by set, ``swept_p90_deg`` by variation; a scooter is one line of numbers
    """
    found = sample_all(executor)
    faults = {name: draw_scooters(name, found.get(name, [])) for name in SETS}
    # What is up on the "left side slope" of the table is up on the side slope of the course.
    sides = {name: Variation(right_side_up=name != "other side") for name in faults}
    sets = {
        name: run_all(
            drive_scooter,
            [(k, row.tolist(), sides[name]) for k, row in enumerate(rows)],
            executor,
        )
        for name, rows in faults.items()
    }
    few = faults["posterior"][:SWEPT_SCOOTERS]
    swept = {BASE: sets["posterior"][:SWEPT_SCOOTERS]}
    swept |= {
        name: run_all(
            drive_scooter, [(k, row.tolist(), one) for k, row in enumerate(few)], executor
        )
        for name, one in variations().items()
        if name != BASE
    }
    return {
        "numbers": {
            "names": list(NAMES),
            "emcee": version("emcee"),
            "posteriors": {
                name: [
                    _described(one, draws)
                    for one, draws in zip(posteriors()[name], several, strict=True)
                ]
                for name, several in found.items()
            },
            "faults_deg": {name: _lines(rows, 3) for name, rows in faults.items()},
            "p90_deg": {name: _lines(rows, 3) for name, rows in sets.items()},
            "swept_p90_deg": {name: _lines(rows, 3) for name, rows in swept.items()},
        },
        "inputs": table_checksum(),
    }


def _described(one: Posterior, draws: Draws) -> dict[str, Any]:
    """Diagnosis and summary of one posterior, as JSON wants it."""
    check = diagnose(draws)
    pooled = draws.pooled_deg
    names = np.array(NAMES)
    return {
        "runs": one.sampling.runs,
        "draws": len(pooled),
        "accepted": [round(float(x), 3) for x in draws.accepted],
        "modes": list(draws.modes),
        "lowest_cost": round(float(-2 * one.cost.log_density(pooled[::7]).max()), 1),
        "rhat_runs": [round(float(x), 4) for x in check.rhat_runs],
        "rhat_walkers": [round(float(x), 3) for x in check.rhat_walkers],
        "effective": [round(float(x)) for x in check.effective],
        "mean_deg": [round(float(x), 3) for x in pooled.mean(axis=0)],
        "sd_deg": [round(float(x), 3) for x in pooled.std(axis=0)],
        "quantiles_deg": _lines(np.quantile(pooled, [0.05, 0.5, 0.95], axis=0), 3),
        "identified": names[identified(draws, one.cost.prior_sd_deg)].tolist(),
    }


def _lines(rows: ArrayLike, digits: int) -> list[str]:
    return [" ".join(f"{value:.{digits}f}" for value in row) for row in np.asarray(rows)]


def read_lines(lines: Sequence[str]) -> FloatArray:
    """Numbers of a recorded table, (n, m), from its lines.

    Parameters
    ----------
    lines : one scooter each

    Returns
    -------
    (n, m) array
    """
    return np.array([line.split() for line in lines], float)
