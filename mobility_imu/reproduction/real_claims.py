"""Rows of the scorecard that rest on independent real recordings: what was promised, what came.

The promise is what our simulations gave for the same quantity; for a standard deviation it is the
meaning of the word. Each limit says whether results were known when it was chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from mobility_imu.reproduction.claims import Basis, Claim, Why, Work
from mobility_imu.reproduction.real import HELD_OF, REAL_SETS, real_record, real_sets
from mobility_imu.reproduction.recorded import numbers as recorded_numbers

Numbers = Mapping[str, Any]
Rows = Callable[[str, Numbers], list[Claim]]
REAL_BASIS: Basis = "tried on independent real recordings"
TWICE = (
    "up to twice the simulated value, because sensors and motion are different; chosen when first "
    "results were known"
)
LEAST_COVERED = 0.85
COVERED_FROM = (
    "95 % is stated; neighbouring samples have similar errors, so we accept 85 % or more; chosen "
    "before the standard deviations were corrected"
)
WITHIN_TWO = (
    "in every recording: a stated deviation that is wrong by more than a factor of two is of "
    "little use; chosen before the standard deviations were corrected"
)


def real_claims(
    work: Work | None = None, numbers: Mapping[str, Numbers] | None = None
) -> list[Claim]:
    """Rows on independent real recordings.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three
    numbers : name of a record to its ``rows`` and ``summary`` as computed here; without them those
        that are recorded

    Returns
    -------
    list of Claim; none of a set of which nothing is recorded
    """
    claims: list[Claim] = []
    for real in real_sets(work):
        found = (numbers or {}).get(real.record)
        if found is None:
            record = real_record(real.record)
            found = None if record is None else record.numbers
        if found is not None:
            claims += ROWS[real.record](real.record, found)
    return claims


class Sides(NamedTuple):
    """One number of a set of recordings, and of our simulated ones.

    Parameters
    ----------
    real : what the recordings give
    simulated : the same measure on our simulated recordings; NaN if it was not computed
    simulated_as_real : likewise, with sensors as bad as real recordings show them
    """

    real: float
    simulated: float = math.nan
    simulated_as_real: float = math.nan


def promised(record: str, what: str, unit: str, sides: Sides, n: int) -> Claim:
    """Row for an error that our simulation promised to be small.

    Parameters
    ----------
    record : name of the record
    what : the error
    unit : of all numbers
    sides : ``simulated`` is the promise
    n : number of recordings, or of what is counted

    Returns
    -------
    Claim that agrees up to twice the promise
    """
    return _claim(
        record,
        what,
        unit,
        sides,
        n,
        reference=sides.simulated,
        reference_from="the same measure on our simulated recordings",
        tolerance=sides.simulated,
        tolerance_reason=TWICE,
        why="the simulation promised too much",
    )


def counted(
    record: str, what: str, sides: Sides, n: int, *, tolerance: float, reason: str
) -> Claim:
    """Row for a fraction, or a ratio, that has to be what the simulation gave.

    Parameters
    ----------
    record, what, sides, n : as in :func:`promised`
    tolerance, reason : largest difference that agrees, and why

    Returns
    -------
    Claim
    """
    return _claim(
        record,
        what,
        "1",
        sides,
        n,
        reference=sides.simulated,
        reference_from="the same measure on our simulated recordings",
        tolerance=tolerance,
        tolerance_reason=reason,
        why="the simulation promised too much",
    )


def covered(
    record: str,
    what: str,
    sides: Sides,
    n: int,
    why: Why = "the stated uncertainty does not hold",
) -> Claim:
    """Row for the samples that lie inside the stated 95 % interval.

    Parameters
    ----------
    record, n : as in :func:`promised`
    what : the quantity whose interval it is
    sides : fractions of samples inside
    why : the reason, if they are too few

    Returns
    -------
    Claim that agrees from 85 % on
    """
    return _claim(
        record,
        f"samples inside the stated 95 % interval: {what}",
        "1",
        sides,
        n,
        reference=LEAST_COVERED,
        reference_from=COVERED_FROM,
        bound="above",
        tolerance_reason=COVERED_FROM,
        why=why,
    )


def within_two(record: str, what: str, sides: Sides, n: int) -> Claim:
    """Row for the recordings whose stated deviation is of the right size.

    Parameters
    ----------
    record, n : as in :func:`promised`
    what : the quantity whose deviation it is
    sides : fractions of recordings in which the median stated sd lies between half and twice the
        actual rms

    Returns
    -------
    Claim that agrees if it is all of them
    """
    return _claim(
        record,
        f"recordings with a stated sd of half to twice the actual error: {what}",
        "1",
        sides,
        n,
        reference=1.0,
        reference_from="all of them",
        tolerance_reason=WITHIN_TWO,
        why="the stated uncertainty does not hold",
    )


def limited(record: str, what: str, unit: str, sides: Sides, n: int, limit: float) -> Claim:
    """Row for an error of which our simulation says nothing.

    Parameters
    ----------
    record, what, unit, sides, n : as in :func:`promised`
    limit : the error has to be below it; chosen when first results were known

    Returns
    -------
    Claim
    """
    return _claim(
        record,
        what,
        unit,
        sides,
        n,
        reference=limit,
        reference_from="a limit of ours, chosen when first results were known",
        bound="below",
        tolerance_reason="with a larger error the result would be of no use",
        why="the simulation promised too much",
    )


def _claim(record: str, what: str, unit: str, sides: Sides, n: int, **fields: Any) -> Claim:
    real = REAL_SETS[record]
    return Claim(
        work=real.work,
        where=real.title,
        what=what,
        unit=unit,
        basis=REAL_BASIS,
        compute=lambda: sides.real,
        n=n,
        simulated=sides.simulated,
        simulated_as_real=sides.simulated_as_real,
        **fields,
    )


def _sides(summary: Numbers, number: Callable[[Numbers], float]) -> Sides:
    """One number of the recordings and, where the summary has them, of simulated ones."""
    given = (summary, summary.get("simulated"), summary.get("simulated_as_real"))
    return Sides(*(math.nan if part is None else number(part) for part in given))


def _hinge_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Fusion and closed form on a chain of hinges, beside the same on simulated rides."""
    rows, summary = [], numbers["summary"]
    for method in ("fusion", "closed-form"):
        rows += _method_rows(record, summary, method)
        for angle in ("steering", "throttle"):
            if angle in summary[method]:
                rows += _angle_rows(record, summary, method, angle)
    return rows


def _method_rows(record: str, summary: Numbers, method: str) -> list[Claim]:
    """How many recordings a method answers, and how many of their samples it calls valid."""

    def answered(part: Numbers) -> float:
        return float(1 - part[method]["refused"] / part[method]["recordings"])

    def valid(part: Numbers) -> float:
        return float(part[method].get("steering", {"valid": 0.0})["valid"])

    n, name = summary[method]["recordings"], method.replace("-", " ")
    return [
        counted(
            record,
            f"recordings for which the {name} gives a result",
            _sides(summary, answered),
            n,
            tolerance=0.0,
            reason="each recording is good, so the method must give a result",
        ),
        counted(
            record,
            f"samples that the {name} calls valid",
            _sides(summary, valid),
            n,
            tolerance=0.1,
            reason="in one of ten samples an angle may not be observable; chosen when first "
            "results were known",
        ),
    ]


def _angle_rows(record: str, summary: Numbers, method: str, angle: str) -> list[Claim]:
    def of(key: str) -> Sides:
        return _sides(summary, lambda part: part[method][angle][key])

    def fraction(part: Numbers) -> float:
        answered = part[method]["recordings"] - part[method]["refused"]
        return float(part[method][angle]["ratios_within_two"] / answered)

    n = summary[method]["recordings"] - summary[method]["refused"]
    name = f"{angle} by {method.replace('-', ' ')}"
    error = f"{name}: rms error where valid, median over recordings"
    rows = [promised(record, error, "deg", of("median_rms_deg"), n)]
    if "covered" in summary[method][angle]:
        rows.append(covered(record, name, of("covered"), n))
        rows.append(within_two(record, name, _sides(summary, fraction), n))
    return rows


def _walk_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Steps of a walking frame, beside the count of steps on simulated corridors."""
    summary = numbers["summary"]
    found, others = _simulated_steps(
        [row for row in summary["simulated"] if row["level"] == "realistic"]
    )
    as_real = _simulated_steps(summary.get("simulated_as_real", []))
    labels = summary["labels"]
    return [
        counted(
            record,
            "labelled steps that are found",
            Sides(summary["found"] / labels, found, as_real[0]),
            labels,
            tolerance=0.01,
            reason="one in a hundred; chosen when first results were known",
        ),
        counted(
            record,
            "other steps found, per label",
            Sides(summary["others"] / labels, others, as_real[1]),
            labels,
            tolerance=0.06,
            reason="labels leave steps out; chosen when first results were known",
        ),
    ]


def _simulated_steps(rows: list[Numbers]) -> tuple[float, float]:
    """Fractions of the true steps: of those that are found, and of those found beside them."""
    true = sum(row["true_steps"] for row in rows)
    if not true:
        return math.nan, math.nan
    found = sum(min(row["steps"], row["true_steps"]) for row in rows)
    return found / true, sum(max(row["steps"] - row["true_steps"], 0) for row in rows) / true


def _feet_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Walker's filter on a foot: its settings for a frame, those for a foot, its own detector."""
    level = "realistic"
    (walks,) = (
        row for row in recorded_numbers("walker_walks")["smoothing"] if row["level"] == level
    )
    as_real = numbers["summary"].get("simulated_as_real", {}).get("smoothed_rms_m", math.nan)
    rows = []
    for part, name in (
        ("frame", "with settings for a frame, rests given"),
        ("foot", "with settings for a foot, rests given"),
        ("detector", "with settings for a frame, rests by our detector"),
    ):
        found = numbers["summary"][part]
        n = found["walks"]
        error = Sides(found["median_rms_m"], walks["smoothed_rms_m"], as_real)
        rows += [
            promised(record, f"place {name}: rms error, median over walks", "m", error, n),
            covered(record, f"place {name}", Sides(found["covered_percent"] / 100), n),
            within_two(record, f"place {name}", Sides(found["within_factor_two"] / n), n),
        ]
    return rows


def _chair_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Speed and yaw rate of sports chairs beside simulated courts with the same sensors."""
    summary, n = numbers["summary"], numbers["summary"]["recordings"]

    def of(key: str) -> Sides:
        return _sides(summary, lambda part: float(part[key]["median"]))

    rows = [
        promised(record, "speed: rms error, median over trials", "m/s", of("speed_rms_mps"), n),
        promised(
            record,
            "distance: largest error over trials, as a fraction of the distance",
            "1",
            _sides(summary, _off_way),
            n,
        ),
        covered(record, "speed", _sides(summary, lambda part: float(part["speed_inside"])), n),
        within_two(record, "speed", Sides(_within_two(numbers["rows"])), n),
    ]
    if "yaw_rate_inside" in summary:
        inside = Sides(summary["yaw_rate_inside"])
        why: Why = "the reference errs more than we state"
        rows.append(covered(record, "yaw rate", inside, n, why))
    return rows


def _car_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Speed of a car; nothing like it was simulated."""
    summary, n = numbers["summary"], numbers["summary"]["recordings"]
    speed = Sides(summary["speed_rms_mps"]["most"])
    return [
        limited(record, "speed: rms error, largest over drives", "m/s", speed, n, 0.15),
        limited(
            record,
            "distance: largest error over drives, as a fraction of the distance",
            "1",
            Sides(_off_way(summary)),
            n,
            0.02,
        ),
        covered(record, "speed", Sides(summary["speed_inside"]), n),
        within_two(record, "speed", Sides(_within_two(numbers["rows"])), n),
    ]


def _drive_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Drives on real ground, beside a computation by hand with independent code."""
    summary = numbers["summary"]
    n, judged = summary["recordings"], summary["judged"]
    by_hand = summary["distance_over_by_hand"]
    off = max(abs(by_hand[end] - 1) for end in ("least", "most"))
    turned = summary["turn_less_by_hand_deg"]
    angle = max(abs(turned[end]) for end in ("least", "most"))
    return [
        counted(
            record,
            "drives that give a result",
            Sides(1 - summary["refused"] / n, 1.0),
            n,
            tolerance=0.0,
            reason="each recording is good, so the method must give a result",
        ),
        limited(
            record, "distance against the count by hand: largest error", "1", Sides(off), n, 0.02
        ),
        limited(
            record, "turn against the count by hand: largest error", "deg", Sides(angle), n, 4.0
        ),
        _claim(
            record,
            "drives in circles whose stated 95 % interval contains the track by hand",
            "1",
            _sides(summary, _track_inside),
            judged,
            reference=1.0,
            reference_from="all of them",
            tolerance_reason="three drives: each interval must contain the track",
            why="the stated uncertainty does not hold",
        ),
    ]


def _off_way(part: Numbers) -> float:
    return float(max(abs(part["path_ratio"][end] - 1) for end in ("least", "most")))


def _track_inside(part: Numbers) -> float:
    """Fraction of drives whose stated interval holds the track; simulated ones are all judged."""
    drives = part.get("judged", part.get("drives"))
    return float(part.get("track_inside", math.nan) / drives)


def _within_two(rows: list[Numbers]) -> float:
    """Fraction of rows whose speed has a stated deviation of half to twice the actual error."""
    return float(np.mean([0.5 <= row["speed"]["sd_over_rms"] <= 2 for row in rows]))


def _held(rows: Rows) -> Rows:
    """Rows of recordings that were held back, beside the simulations of those that were not."""

    def held_rows(record: str, numbers: Numbers) -> list[Claim]:
        of = real_record(HELD_OF[record])
        beside = {} if of is None else of.summary
        promised = {k: beside[k] for k in ("simulated", "simulated_as_real") if k in beside}
        return rows(record, {**numbers, "summary": {**promised, **numbers["summary"]}})

    return held_rows


def _held_drive_rows(record: str, numbers: Numbers) -> list[Claim]:
    """Drives that nobody counted by hand: the chair's track by hand is that of other drives."""
    summary = numbers["summary"]
    n, judged = summary["recordings"], summary["judged"]
    return [
        counted(
            record,
            "drives that give a result",
            Sides(1 - summary["refused"] / n, 1.0),
            n,
            tolerance=0.0,
            reason="each recording is good, so the method must give a result",
        ),
        limited(
            record,
            "track against the count by hand of other drives: largest error",
            "m",
            Sides(summary["track_off_m"]),
            judged,
            0.012,
        ),
        _claim(
            record,
            "drives in circles whose stated 95 % interval contains the track by hand",
            "1",
            _sides(summary, _track_inside),
            judged,
            reference=1.0,
            reference_from="all of them",
            tolerance_reason="four drives: each interval must contain the track",
            why="the stated uncertainty does not hold",
        ),
    ]


ROWS: dict[str, Rows] = {
    "real_two_hinges": _hinge_rows,
    "real_one_hinge": _hinge_rows,
    "real_drives": _drive_rows,
    "real_chair_mocap": _chair_rows,
    "real_car": _car_rows,
    "real_walks": _walk_rows,
    "real_feet": _feet_rows,
    "held_drives": _held(_held_drive_rows),
    "held_chairs": _held(_chair_rows),
    "dropped_chairs": _held(_chair_rows),
    "held_car": _held(_car_rows),
    "held_walks": _held(_walk_rows),
    "held_feet": _held(_feet_rows),
}
"""Rows of each set, from the name of its record and its numbers."""
