"""Faults put into simulated rides of a scooter, and what is told of them.

The record ``faults_scooter`` has one row for each of 100 faults of each kind: how far it moves the
fusion's angles in units of their stated standard deviation, by what name it is told, what it is
said to cost and what it really costs. Beside them: what is told of rides without a fault, and of
the recordings of others.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.faults import Fault
from mobility_imu.frames import wrap_angle
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import Numbers
from mobility_imu.reproduction.scooter.fault_cases import (
    CASES,
    DRAWN_BY,
    FUSION,
    KINDS,
    POSES,
    RIDES,
    SEED,
    SEEN_SEED,
    Case,
    Ride,
    cases_of,
    log_uniform,
    ride_of,
)
from mobility_imu.reproduction.scooter.real_hinges import ONE_HINGE, TWO_HINGES, read_chain
from mobility_imu.scooter.calibration import ScooterCalibration, calibrate_mount
from mobility_imu.scooter.faults import find_faults
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.scooter.ride import RideAngles, RideSettings, estimate_ride
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import (
    COURSES,
    PARKED_POSES_RAD,
    draw_scooter,
    simulate_parked,
)

if TYPE_CHECKING:
    import pandas as pd

CLEAN_RIDES = 240
CLEAN_SEED = 242_000
"""First seed of rides without a fault; each course has its own thousand."""
SEEN_CLEAN_SEED = 42_000
"""The same of an earlier run, after which some checks were changed; tests use it."""
MATTERS_SDS = 2.0
"""A fault matters that moves an angle by more than this times its standard deviation."""
COLUMNS = (
    "kind", "level", "sensor", "size", "unit", "moved_sds", "found_as", "right",
    "steering_stated_deg", "steering_real_deg", "throttle_stated_deg", "throttle_real_deg",
)  # fmt: skip
"""Of a row: kind and place of the fault, its size (NaN for kinds without one), largest change of an
angle in its standard deviations, code that it is told by ("" if it is not, "refused" if nothing
reads it), whether that is the right one, and stated and real largest changes."""


def rows_of(ride: int) -> list[list[Any]]:
    """All faults that are put into one ride, a row of :data:`COLUMNS` each.

    Parameters
    ----------
    ride : number

    Returns
    -------
    list of rows
    """
    clean = ride_of(ride)
    rows = []
    for name, kind in KINDS.items():
        rng = np.random.default_rng([SEED, DRAWN_BY[name], ride])
        for _ in range(cases_of(name, ride)):
            case = kind.draw(clean.recording, rng)
            rows.append([name, clean.level, case.sensor, case.size, kind.unit, *told_of(
                case, clean, kind.codes
            )])  # fmt: skip
    return rows


def told_of(case: Case, clean: Ride, codes: Sequence[str]) -> list[Any]:
    """What a fault does to the angles, and what is told of it.

    Parameters
    ----------
    case : Case
    clean : Ride that it is put into
    codes : by which it is rightly told

    Returns
    -------
    list, the columns from ``moved_sds`` on
    """
    unknown = [np.nan] * 4
    try:
        faulty = case.faulty()
        found = estimate_ride(faulty, SUZUKI_ET4D, clean.mount, FUSION)
    except InputError:
        return [np.inf, "refused", 1, *unknown]
    real, sds = _moved(found, _alike(clean, faulty))
    faults = find_faults(faulty, SUZUKI_ET4D, clean.mount, FUSION)
    if not faults:
        return [sds, "", 0, np.nan, real[0], np.nan, real[1]]
    right = [fault for fault in faults if fault.code in codes]
    told = (right or list(faults))[0]
    stated = _stated(told)
    return [sds, told.code, int(bool(right)), stated[0], real[0], stated[1], real[1]]


def _alike(clean: Ride, faulty: Recording) -> RideAngles:
    """Angles of the same part of the ride without the fault."""
    part = clean.recording
    if len(part) == len(faulty):
        return clean.found
    first, last = float(faulty.time_s[0]), float(faulty.time_s[-1])
    part = part.trim(first - 1e-6, last + 1e-6)
    return estimate_ride(part, SUZUKI_ET4D, clean.mount, FUSION)


def _moved(found: RideAngles, clean: RideAngles) -> tuple[list[float], float]:
    """Largest change of steering and throttle, deg, and the largest in standard deviations."""
    moved, sds = [], []
    for name in ("steering", "throttle"):
        apart = getattr(found, f"{name}_rad") - getattr(clean, f"{name}_rad")
        apart = np.abs(wrap_angle(apart[clean.valid]))  # whole turns are none
        sd = getattr(clean, f"{name}_sd_rad")[clean.valid]
        moved.append(float(np.rad2deg(apart.max(initial=0.0))))
        sds.append(float((apart / sd).max(initial=0.0)))
    return moved, max(sds)


def _stated(fault: Fault) -> list[float]:
    """Stated cost in steering and throttle, deg; NaN if nothing is stated."""
    if not fault.costs:
        return [np.nan, np.nan]
    costs = {cost.name: cost.largest for cost in fault.costs}
    return [costs.get("steering", 0.0), costs.get("throttle", 0.0)]


def clean_row(number: int, first_seed: int = CLEAN_SEED) -> dict[str, Any]:
    """What is told of a ride without a fault.

    Parameters
    ----------
    number : of the ride; courses take turns; of each course's rides half are of real sensors, a
        quarter of a calibrated LPMS, a quarter of one without calibration
    first_seed : of the rides

    Returns
    -------
    dict with ``course``, ``level`` and ``told``, the sentences
    """
    courses = ("round", *COURSES)
    course = courses[number % len(courses)]
    ride = ride_of(number // len(courses), first_seed + 1000 * (number % len(courses)), course)
    mount, level = ride.mount, ride.level
    if mount is not None and number // len(courses) % 4 == 0:
        mount, level = None, "LPMS"
    told = find_faults(ride.recording, SUZUKI_ET4D, mount, FUSION)
    return {"course": course, "level": level, "told": [_shown(fault) for fault in told]}


def _shown(fault: Fault) -> str:
    return f"{fault.code}: {re.sub(r'^.*?: ', '', fault.told)}"


def real_rows() -> list[dict[str, Any]] | None:
    """What is told of the recordings of two hinges and of one; None if they are not here.

    Returns
    -------
    list of dict with ``recording``, ``method`` and ``told``
    """
    rows = []
    for chain in (TWO_HINGES, ONE_HINGE):
        folder = find_folder(chain.dataset)
        if folder is None:
            return None
        for stem, geometry in chain.recordings.items():
            one = read_chain(folder, stem, geometry)
            for settings in (RideSettings(), FUSION):
                told = find_faults(one.ride, one.geometry, one.mount, settings)
                rows.append(
                    {
                        "recording": stem,
                        "method": settings.method,
                        "told": [_shown(fault) for fault in told],
                    }
                )
    return rows


def pose_rows(number: int) -> list[list[Any]]:
    """Parked poses whose stated angles are wrong, four tables, as rows of :data:`COLUMNS`.

    One of the six poses is off by a size, in a direction of steering and throttle; the change is
    that of the angles of the closed form on level ground, against what the mount is uncertain by.

    Parameters
    ----------
    number : of the scooter

    Returns
    -------
    list of rows; ``moved_sds`` is the largest turn of an IMU in its standard deviations; a pose is
    rightly told by its number, or as one that fits no mount
    """
    seed, rng = SEED + number, np.random.default_rng([SEED, DRAWN_BY[POSES], number])
    parked = [
        simulate_parked(pitch_rad=pitch, bank_rad=0.0, seed=2 * seed + k, unit=draw_scooter(seed))
        for k, pitch in enumerate((0.0, float(np.deg2rad(5))))
    ]
    right = calibrate_mount(parked, PARKED_POSES_RAD, SUZUKI_ET4D)
    rows = []
    for _ in range(CASES // RIDES):
        size, towards = log_uniform(rng, 0.3, 60.0), rng.uniform(0, 2 * np.pi)
        table = np.array(PARKED_POSES_RAD)
        place = int(rng.integers(len(table)))
        table[place] += np.deg2rad(size) * np.array([np.cos(towards), np.sin(towards)])
        wrong = calibrate_mount(parked, [(float(s), float(t)) for s, t in table], SUZUKI_ET4D)
        apart = [
            Rotation.from_matrix(getattr(wrong.mount, key) @ getattr(right.mount, key).T)
            for key in ("rotation_lever_imu_to_lever", "rotation_body_imu_to_body")
        ]
        turns = np.concatenate([turn.as_rotvec() for turn in apart])
        found_as = _found_as(wrong)
        named = found_as in ("misfit", f"pose {place + 1}")
        rows.append([POSES, "LPMS, calibrated", POSES, size, "deg",
                     float(np.abs(turns / right.sd_rad).max()), found_as.split()[0] if found_as
                     else "", int(named), np.nan, np.nan, np.nan, np.nan])  # fmt: skip
    return rows


def _found_as(calibration: ScooterCalibration) -> str:
    """The pose that a calibration calls wrong, else "misfit" if it says anything, else ""."""
    named = (re.match(r"pose \d+", text) for text in calibration.severe)
    return next((found[0] for found in named if found), "misfit" if calibration.severe else "")


def faults_record(executor: Any = None) -> Numbers | None:
    """What the record ``faults_scooter`` keeps; None if the recordings of others are not here.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here

    Returns
    -------
    dict with ``numbers``: ``columns`` and ``rows`` (each as one line, cells by commas), ``summary``
    (see :func:`summary`), ``clean`` (number of rides, and those of which something is told) and
    ``real`` (see :func:`real_rows`)
    """
    real = real_rows()
    if real is None:
        return None
    numbers = [(k,) for k in range(RIDES)]
    found = run_all(rows_of, numbers, executor) + run_all(pose_rows, numbers, executor)
    rows = sorted((row for part in found for row in part), key=_order)
    clean = run_all(clean_row, [(k,) for k in range(CLEAN_RIDES)], executor)
    levels = {level: sum(row["level"] == level for row in clean) for level in LEVELS}
    return {
        "numbers": {
            "columns": ",".join(COLUMNS),
            "rows": [";".join(map(_cell, row)) for row in rows],
            "summary": summary(table_of(rows)).reset_index().to_dict("records"),
            "clean": {
                "rides": levels,
                "told": [row for row in clean if row["told"]],
            },
            "real": real,
        }
    }


LEVELS = ("LPMS, calibrated", "LPMS", "real")


def _order(row: list[Any]) -> int:
    return [*KINDS, POSES].index(row[0])


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:.3g}"


def recorded_table(numbers: Numbers) -> pd.DataFrame:
    """Rows of the record as a table.

    Parameters
    ----------
    numbers : what ``recorded.numbers("faults_scooter")`` returns

    Returns
    -------
    DataFrame with :data:`COLUMNS`
    """
    words = {"kind", "level", "sensor", "unit", "found_as"}
    rows = []
    for line in numbers["rows"]:
        cells = line.split(";")
        rows.append([c if n in words else float(c) for n, c in zip(COLUMNS, cells, strict=True)])
    return table_of(rows)


def table_of(rows: Sequence[Sequence[Any]]) -> pd.DataFrame:
    """Rows as a table.

    Parameters
    ----------
    rows : of :func:`rows_of`

    Returns
    -------
    DataFrame with :data:`COLUMNS`
    """
    import pandas as pd

    return pd.DataFrame(list(rows), columns=list(COLUMNS))


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """By kind: how many faults matter, how many of these are told, and how well they are priced.

    Parameters
    ----------
    table : with :data:`COLUMNS`

    Returns
    -------
    DataFrame by kind
        ``cases``; ``refused``; ``matter``, more than :data:`MATTERS_SDS` and not refused; of these
        ``told`` (at all) and ``right`` (by the right name); ``priced``, told with a cost, and of
        these ``within_two``, whose cost in the angle that is moved most is within a factor of two
        of the real one; ``unpriced``, told without a cost
    """
    import pandas as pd

    rows = {}
    for kind, part in table.groupby("kind", sort=False):
        refused = part["found_as"] == "refused"
        matter = part[(part["moved_sds"] > MATTERS_SDS) & ~refused]
        told = matter[matter["found_as"] != ""]
        priced = told[told["steering_stated_deg"].notna()]
        by_throttle = priced["throttle_real_deg"] > priced["steering_real_deg"]
        stated = priced["steering_stated_deg"].where(~by_throttle, priced["throttle_stated_deg"])
        real = priced["steering_real_deg"].where(~by_throttle, priced["throttle_real_deg"])
        rows[kind] = {
            "cases": len(part),
            "refused": int(refused.sum()),
            "matter": len(matter),
            "told": len(told),
            "right": int(matter["right"].sum()),
            "priced": len(priced),
            "within_two": int(((stated <= 2 * real) & (stated >= real / 2)).sum()),
            "unpriced": len(told) - len(priced),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("kind")


class Example(NamedTuple):
    """A fault for a drawing.

    Parameters
    ----------
    clean, faulty : Recording
    result_clean, result_faulty : RideAngles
    faults : what is told
    """

    clean: Recording
    faulty: Recording
    result_clean: RideAngles
    result_faulty: RideAngles
    faults: tuple[Fault, ...]


EXAMPLES: dict[str, Callable[[Recording], Recording]] = {
    "lag": lambda ride: put.late(ride, "lever", 0.2),
    "reversed gyroscope": lambda ride: put.reverse(ride, "lever"),
    "turned since the calibration": lambda ride: put.turn(
        ride, "lever", Rotation.from_euler("y", 5, degrees=True).as_matrix()
    ),
    "dead gyroscope": lambda ride: put.silence(ride, "body", 10.0),
    "exchanged sensors": lambda ride: put.exchange(ride, "lever", "body"),
}
"""Faults that a chapter draws."""


def example(kind: str) -> Example:
    """A ride without and with a fault, for a drawing.

    Parameters
    ----------
    kind : of :data:`EXAMPLES`

    Returns
    -------
    Example; both results are by fusion
    """
    if kind not in EXAMPLES:
        raise InputError(f"kind = {kind!r}: expected one of {', '.join(EXAMPLES)}")
    ride = ride_of(0, SEEN_SEED)
    faulty = EXAMPLES[kind](ride.recording)
    return Example(
        ride.recording,
        faulty,
        estimate_ride(ride.recording, SUZUKI_ET4D, ride.mount, FUSION),
        estimate_ride(faulty, SUZUKI_ET4D, ride.mount, FUSION),
        find_faults(faulty, SUZUKI_ET4D, ride.mount, FUSION),
    )
