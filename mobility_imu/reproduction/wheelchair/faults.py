"""Faults put into simulated drives: which are found, what they cost, and what is told of that.

Each kind has a hundred drives, on seeds on which no limit was set. Some checks were changed after
an earlier run had shown what they missed. Sizes are drawn evenly in their logarithm, from what
changes nothing to what spoils the drive. A fault matters if it moves speed or yaw rate somewhere by
more than twice the standard deviation that the result without it states.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.faults import Fault
from mobility_imu.frames import FloatArray
from mobility_imu.offsets import GyroscopeOffset
from mobility_imu.recording import Recording
from mobility_imu.reproduction.wheelchair.fault_kinds import KINDS, MODELS, Drive, clean_drive
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.sensor import REAL
from mobility_imu.wheelchair.calibration import WheelchairCalibration
from mobility_imu.wheelchair.faults import find_faults, results
from mobility_imu.wheelchair.velocity import ChairVelocity, estimate_velocity

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["CASES", "cases_table", "example", "numbers_of", "one_case", "study", "summary_of"]

CASES = 100
"""Drives of each kind."""
POOL = 25
"""Clean drives that the kinds share; places and sizes are drawn anew for each case."""
FIRST_SEED = 317_000
"""Of the study. Nobody had looked at these drives when a check was last changed."""
SEEN_SEED = 17_000
"""Of an earlier run, after which some checks were changed; examples and tests use it."""
MATTERS = 2.0


@lru_cache(maxsize=2 * POOL)
def _pool(k: int, rests: bool, first_seed: int) -> Drive:
    """A drive without a fault.

    The simulation draws another offset at each power-up, of 0.2 to 0.3 deg/s (1 sd, each axis), for
    each of the three recordings. Where no rest shows that of the drive it is a fault by itself: one
    that is put in may undo it, or pass for told by it. So drives without rests have none of it.
    """
    model = tuple(MODELS.values())[k % 2]
    if not rests:
        model = replace(model, gyr=replace(model.gyr, turn_on_bias_sd=0.0))
    return clean_drive(first_seed + k, model, rests=rests)


def one_case(kind: str, case: int, first_seed: int = FIRST_SEED) -> dict[str, Any]:
    """Inject one fault and look for it.

    Parameters
    ----------
    kind : a key of ``KINDS``
    case : 0 to 99
    first_seed : of the drives

    Returns
    -------
    dict
        ``sensor``, ``size``, ``unit``; ``ratio``: largest change in standard deviations (infinite
        if the estimate refuses); ``of``: the result that changes most by it; ``found_as``: codes,
        or "refused"; ``right``: whether the kind is rightly named or refused; ``cost_real`` and
        ``cost_stated`` of that result, None where there is none
    """
    injection, codes, rests = KINDS[kind]
    rng = stream(first_seed, list(KINDS).index(kind), case)
    clean = _pool(case % POOL, rests, first_seed)
    row: dict[str, Any] = {"kind": kind, "case": case}
    try:
        faulty = injection(clean, rng)
        row |= {"sensor": faulty.sensor, "size": faulty.size, "unit": faulty.unit}
        calibration = faulty.drive.calibration()
        found = find_faults(
            faulty.drive.trial,
            clean.court.geometry,
            calibration.mount,
            offsets=calibration.offsets,
        )
        told = sorted({fault.code for fault in found})
        drive = _estimate(faulty.drive, calibration)
    except InputError as refusal:
        return row | {"ratio": float("inf"), "found_as": "refused", "right": True,
                      "why": str(refusal)[:80]}  # fmt: skip
    row |= {"found_as": ", ".join(told), "right": bool(codes & set(told))}
    return row | _moved(_clean_result(case % POOL, rests, first_seed), drive, found, codes)


def _estimate(drive: Drive, calibration: WheelchairCalibration) -> ChairVelocity:
    return estimate_velocity(
        drive.trial, drive.court.geometry, calibration.mount, offsets=calibration.offsets
    )


@lru_cache(maxsize=2 * POOL)
def _clean_result(k: int, rests: bool, first_seed: int) -> ChairVelocity:
    drive = _pool(k, rests, first_seed)
    return _estimate(drive, drive.calibration())


def _moved(
    clean: ChairVelocity, faulty: ChairVelocity, found: tuple[Fault, ...], codes: frozenset[str]
) -> dict[str, Any]:
    """How far the results moved, in standard deviations and in their unit, and what was stated."""
    speed = np.abs(faulty.linear_velocity_mps - clean.linear_velocity_mps)
    turn = np.rad2deg(np.abs(faulty.yaw_rate_radps - clean.yaw_rate_radps))
    by_sd = {
        "speed": float((speed / clean.linear_velocity_sd_mps).max()),
        "yaw rate": float((turn / np.rad2deg(clean.yaw_rate_sd_radps)).max()),
    }
    of = max(by_sd, key=lambda name: by_sd[name])
    stated = [
        cost.largest
        for fault in found
        for cost in fault.costs
        if cost.name == of and (fault.code in codes or not codes)
    ]
    return {
        "ratio": by_sd[of],
        "of": of,
        "cost_real": float({"speed": speed, "yaw rate": turn}[of].max()),
        "cost_stated": max(stated) if stated else None,
    }


def false_alarms(seed: int, name: str) -> dict[str, Any]:
    """What is told of a drive without a fault.

    Parameters
    ----------
    seed : of the court
    name : a key of :data:`MODELS`, or "real"

    Returns
    -------
    dict with ``model``, ``seed`` and ``told``, a list of "code sensor size"
    """
    model = REAL if name == "real" else MODELS[name]
    drive = clean_drive(seed, model)
    calibration = drive.calibration()
    found = find_faults(
        drive.trial, drive.court.geometry, calibration.mount, offsets=calibration.offsets
    )
    told = [f"{fault.code} {fault.sensor} {fault.size:.3g}" for fault in found]
    return {"model": name, "seed": seed, "told": told}


CLEAN = 70
"""Clean drives of each model."""


def study(executor: Any = None) -> dict[str, Any]:
    """Both halves of the study: faults that are found, and alarms where there is none.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here

    Returns
    -------
    dict with ``numbers``: ``kinds`` (one row each, of :func:`summary_of`), ``cases`` (columns of
    all rows) and ``clean`` (alarms by model)
    """
    jobs = [(kind, list(range(k, CASES, 4))) for kind in KINDS for k in range(4)]
    rows = [row for some in run_all(_cases, jobs, executor) for row in some]
    clean = run_all(
        false_alarms,
        [
            (FIRST_SEED + 1000 * m + k, name)
            for m, name in enumerate((*MODELS, "real"), start=1)
            for k in range(CLEAN)
        ],
        executor,
    )
    return {"numbers": numbers_of(rows, clean)}


def _cases(kind: str, cases: list[int]) -> list[dict[str, Any]]:
    return [one_case(kind, case) for case in cases]


COLUMNS = (
    "case", "sensor", "size", "unit", "ratio", "of", "found_as", "right", "cost_stated", "cost_real"
)  # fmt: skip


def numbers_of(rows: list[dict[str, Any]], clean: list[dict[str, Any]]) -> dict[str, Any]:
    """Rows and alarms as the record has them.

    Parameters
    ----------
    rows : of :func:`one_case`
    clean : of ``false_alarms``

    Returns
    -------
    dict
    """
    cases = {
        kind: [
            ";".join(_text(row.get(column)) for column in COLUMNS)
            for row in sorted(of_kind, key=lambda r: int(r["case"]))
        ]
        for kind in KINDS
        if (of_kind := [row for row in rows if row["kind"] == kind])
    }
    alarms = {
        name: {
            "drives": len(of_model),
            "with_alarm": sum(bool(one["told"]) for one in of_model),
            "told": {str(one["seed"]): one["told"] for one in of_model if one["told"]},
        }
        for name in (*MODELS, "real")
        if (of_model := [one for one in clean if one["model"] == name])
    }
    return {
        "kinds": [summary_of(kind, rows) for kind in cases],
        "columns": ";".join(COLUMNS),
        "cases": cases,
        "clean": alarms,
    }


def _text(value: Any) -> str:
    """A cell: three digits of a number, 1 or 0 for yes or no, nothing where there is nothing."""
    if isinstance(value, bool | int):
        return str(int(value))
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.3g}"
    return "" if value is None else str(value)


def cases_table(numbers: dict[str, Any]) -> pd.DataFrame:
    """All cases of a record as a table.

    Parameters
    ----------
    numbers : of :func:`study`

    Returns
    -------
    DataFrame with ``kind``, ``case``, ``sensor``, ``size``, ``unit``, ``ratio`` (largest change in
    standard deviations), ``of`` (the result that moves most), ``found_as``, ``right``,
    ``cost_stated``, ``cost_real`` and ``matters``
    """
    import pandas as pd

    names = numbers["columns"].split(";")
    rows = [
        dict(zip(names, line.split(";"), strict=True)) | {"kind": kind}
        for kind, lines in numbers["cases"].items()
        for line in lines
    ]
    table = pd.DataFrame(rows)[["kind", *names]]
    for name in ("case", "size", "ratio", "right", "cost_stated", "cost_real"):
        table[name] = pd.to_numeric(table[name])
    table["matters"] = (table["ratio"] > MATTERS) & (table["found_as"] != "refused")
    return table


def summary_of(kind: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How many faults of a kind matter, are found, and have a cost that holds.

    Parameters
    ----------
    kind : a key of ``KINDS``
    rows : of :func:`one_case`

    Returns
    -------
    dict with ``cases``, ``refused``, ``matter`` (refusals left out), and of those that matter
    ``told`` (at all) and ``right`` (by the right name); ``priced``, those whose right name states
    a cost of the result that moves most, and of these ``within_two``, whose cost is right within a
    factor of two; ``unpriced``, told without such a cost; ``largest_missed`` (in standard
    deviations)
    """
    mine = [row for row in rows if row["kind"] == kind]
    refused = [row for row in mine if row["found_as"] == "refused"]
    matter = [r for r in mine if r["found_as"] != "refused" and r["ratio"] > MATTERS]
    told = [row for row in matter if row["found_as"]]
    priced = [row for row in told if row["right"] and row["cost_stated"] is not None]
    within = [r for r in priced if 0.5 <= r["cost_stated"] / r["cost_real"] <= 2.0]
    missed = [row["ratio"] for row in matter if not row["found_as"]]
    return {
        "kind": kind,
        "cases": len(mine),
        "refused": len(refused),
        "matter": len(matter),
        "told": len(told),
        "right": sum(row["right"] for row in told),
        "priced": len(priced),
        "within_two": len(within),
        "unpriced": len(told) - len(priced),
        "largest_missed": float(f"{max(missed, default=0.0):.3g}"),
    }


def example(
    kind: str, case: int = 0
) -> tuple[Recording, Recording, dict[tuple[str, str], FloatArray],
           dict[tuple[str, str], FloatArray], tuple[Fault, ...]]:  # fmt: skip
    """A drive with and without a fault, for a drawing.

    Parameters
    ----------
    kind : a key of ``KINDS``
    case : 0 to 99, which of its drives

    Returns
    -------
    clean, faulty : Recording
    result_clean, result_faulty : series of :func:`mobility_imu.wheelchair.faults.results`
    faults : what is found, with costs
    """
    injection, _, rests = KINDS[kind]
    clean = _pool(case % POOL, rests, SEEN_SEED)
    faulty = injection(clean, stream(SEEN_SEED, list(KINDS).index(kind), case)).drive
    series, offsets = [], dict[str, GyroscopeOffset]()
    calibration = clean.calibration()
    for drive in (clean, faulty):
        calibration = drive.calibration()
        offsets = calibration.offsets
        series.append(results(drive.trial, drive.court.geometry, calibration.mount, None, offsets))
    found = find_faults(
        faulty.trial, faulty.court.geometry, calibration.mount, offsets=calibration.offsets
    )
    return clean.trial, faulty.trial, series[0], series[1], found
