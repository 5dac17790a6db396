"""Rows of the scorecard that rest on independent real recordings: what was promised, what came.

The promise is what our simulations gave for the same quantity; for a standard deviation it is the
meaning of the word. Limits were fixed before the recordings were run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from mobility_imu.reproduction.claims import Basis, Claim, Work
from mobility_imu.reproduction.real import REAL_SETS, real_record, real_sets

Numbers = Mapping[str, Any]
REAL_BASIS: Basis = "tried on independent real recordings"
TWICE = (
    "up to twice the simulated value: other sensors and another motion; fixed before the "
    "recordings were run"
)
LEAST_COVERED = 0.85
COVERED_FROM = "95 % is what is stated; 85 % is the least that we accept of dependent samples"
WITHIN_TWO = "in every recording; a stated deviation that is off by more than two tells too little"


def real_claims(
    work: Work | None = None, summaries: Mapping[str, Numbers] | None = None
) -> list[Claim]:
    """Rows on independent real recordings.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three
    summaries : name of a record to its summary as computed here; without it the recorded one

    Returns
    -------
    list of Claim; none of a set of which nothing is recorded
    """
    claims: list[Claim] = []
    for real in real_sets(work):
        summary = (summaries or {}).get(real.record)
        if summary is None:
            record = real_record(real.record)
            summary = None if record is None else record.summary
        if summary is not None:
            claims += ROWS[real.record](real.record, summary)
    return claims


def promised(
    record: str, what: str, unit: str, *, simulated: float, real: float, n: int, where: str = ""
) -> Claim:
    """Row for an error that our simulation promised to be small.

    Parameters
    ----------
    record : name of the record
    what : the error
    unit : of both numbers
    simulated : the promise
    real : what the recordings give
    n : number of recordings, or of what is counted
    where : part of the set, "" for all of it

    Returns
    -------
    Claim that agrees up to twice the promise
    """
    return _claim(
        record,
        where,
        what,
        unit,
        reference=simulated,
        reference_from="the same measure on our simulated recordings",
        tolerance=simulated,
        tolerance_reason=TWICE,
        compute=lambda: real,
        n=n,
    )


def covered(record: str, what: str, fraction: float, n: int, where: str = "") -> Claim:
    """Row for how many samples lie inside the stated 95 % interval.

    Parameters
    ----------
    record, where : as in :func:`promised`
    what : the quantity whose interval it is
    fraction : of samples inside
    n : number of recordings

    Returns
    -------
    Claim that agrees from 85 % on
    """
    return _claim(
        record,
        where,
        f"samples inside the stated 95 % interval, {what}",
        "1",
        reference=LEAST_COVERED,
        reference_from=COVERED_FROM,
        bound="above",
        tolerance_reason=COVERED_FROM,
        compute=lambda: fraction,
        n=n,
    )


def within_two(record: str, what: str, number: int, n: int, where: str = "") -> Claim:
    """Row for how many recordings have a stated deviation of the right size.

    Parameters
    ----------
    record, where : as in :func:`promised`
    what : the quantity whose deviation it is
    number : of recordings in which the median stated sd lies between half and twice the actual rms
    n : number of recordings

    Returns
    -------
    Claim that agrees if it is all of them
    """
    return _claim(
        record,
        where,
        f"recordings with a stated sd of half to twice the actual error, {what}",
        "1",
        reference=1.0,
        reference_from="all of them",
        tolerance_reason=WITHIN_TWO,
        compute=lambda: number / n,
        n=n,
    )


def counted(
    record: str, what: str, *, simulated: float, real: float, n: int, tolerance: float, reason: str
) -> Claim:
    """Row for a fraction, or a ratio, that has to be what the simulation gave.

    Parameters
    ----------
    record : name of the record
    what : the fraction
    simulated, real : promise, and what came
    n : of how many
    tolerance, reason : largest difference that agrees, and why

    Returns
    -------
    Claim
    """
    return _claim(
        record,
        "",
        what,
        "1",
        reference=simulated,
        reference_from="our simulated recordings",
        tolerance=tolerance,
        tolerance_reason=reason,
        compute=lambda: real,
        n=n,
    )


def _claim(record: str, where: str, what: str, unit: str, **fields: Any) -> Claim:
    real = REAL_SETS[record]
    return Claim(
        work=real.work,
        where=f"{real.title}, {where}" if where else real.title,
        what=what,
        unit=unit,
        basis=REAL_BASIS,
        why="the simulation promised too much",
        **fields,
    )


def _hinge_rows(record: str, summary: Numbers) -> list[Claim]:
    """Fusion and closed form on a chain of hinges, beside the same on simulated rides."""
    rows = []
    for method in ("fusion", "closed-form"):
        found, simulated = summary[method], summary["simulated"][method]
        n = found["recordings"]
        rows.append(
            counted(
                record,
                f"recordings that the {method.replace('-', ' ')} answers",
                simulated=1.0 - simulated["refused"] / simulated["recordings"],
                real=1.0 - found["refused"] / n,
                n=n,
                tolerance=0.0,
                reason="each recording is a right one and has to be answered",
            )
        )
        for angle in ("steering", "throttle"):
            if angle in found:
                rows += _angle_rows(record, method, angle, found, simulated[angle])
    return rows


def _angle_rows(
    record: str, method: str, angle: str, found: Numbers, simulated: Numbers
) -> list[Claim]:
    n, here = found["recordings"] - found["refused"], found[angle]
    name = f"{angle} by {method.replace('-', ' ')}"
    rows = [
        promised(
            record,
            f"{name}: rms error where valid, median over recordings",
            "deg",
            simulated=simulated["median_rms_deg"],
            real=here["median_rms_deg"],
            n=n,
        )
    ]
    if "covered" in here:
        rows.append(covered(record, name, here["covered"], n))
        rows.append(within_two(record, name, here["ratios_within_two"], n))
    return rows


ROWS: dict[str, Callable[[str, Numbers], list[Claim]]] = {
    "real_two_hinges": _hinge_rows,
    "real_one_hinge": _hinge_rows,
}
"""Rows of each set, from the name of its record and its summary."""
