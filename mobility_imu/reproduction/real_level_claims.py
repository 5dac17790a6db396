"""What the chapters promise, held against the same with sensors as bad as real recordings show.

The promise is the number at the level of a data sheet. The rules are those of the rows on real
recordings: an error may be twice what was promised, a stated 95 % interval covers 85 % or more, a
fraction is off by a tenth at most. All numbers are from the record ``level_real``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from mobility_imu.reproduction.claims import Claim, Work
from mobility_imu.reproduction.real_claims import COVERED_FROM, LEAST_COVERED
from mobility_imu.reproduction.recorded import numbers
from mobility_imu.reproduction.scooter.driving_rides import ANGLES

if TYPE_CHECKING:
    import pandas as pd

Rule = Literal["error", "covered", "fraction"]
TWICE = "up to twice the number with a data sheet's sensors, as for the rows on real recordings"
TENTH = "one in ten, as for the rows on real recordings"
LARGEST_OFF = 0.1
ABOUT = 1.1
"""Errors that differ by a factor below this count as unchanged in the table."""


class Headline(NamedTuple):
    """A number that a chapter promises.

    Parameters
    ----------
    work : "scooter", "wheelchair" or "walker"
    key : of the number in the record
    chapter : that promises it
    what : the number, in a few words
    unit : of it
    rule : by which both levels are compared
    note : what stands behind a change; "" if the numbers say all
    """

    work: Work
    key: str
    chapter: str
    what: str
    unit: str
    rule: Rule
    note: str = ""


_OFFSET = (
    "the accelerometers get new offsets (0.2 m/s²) whenever they are switched on, also after the "
    "calibration, and these sensors shake more"
)
_CLOCKS = "half of the error comes from clocks that differ by up to 30 ms"
_GYROSCOPES = (
    "`check` assumes scale factors right to 1 %, as on these sensors, and axes right to 0.4 deg"
)
_SIZES = (
    "scale factors are wrong by 1 % and axes by 0.6 deg, three to six times as much as on a data "
    "sheet"
)
_CREEP = (
    "between two steps the frame's tips creep forward while the sensor seems to rest; no IMU can "
    "measure this creep, and no stated deviation contains it; without creep, the interval is right "
    "with a data sheet's sensors"
)
_PAST, _TEST = "past the paper", "driving test"
_SPEED, _SLIP, _TASKS = "velocities", "slip", "tasks judged by truth"
_MOUNT, _CORRIDOR, _RECTANGLE, _STEPS = "calibration", "corridor", "rectangle", "steps"
HEADLINES: tuple[Headline, ...] = (
    *(
        headline
        for angle in ANGLES
        for headline in (
            Headline(
                "scooter",
                f"fusion_{angle}_rms_deg",
                _PAST,
                f"{angle} by fusion, calibrated: rms error",
                "deg",
                "error",
                _OFFSET,
            ),
            Headline(
                "scooter",
                f"fusion_{angle}_covered",
                _PAST,
                f"{angle} by fusion: inside the stated 95 % interval",
                "1",
                "covered",
                _OFFSET,
            ),
            Headline(
                "scooter",
                f"closed_form_{angle}_rms_deg",
                _PAST,
                f"{angle} by the closed form, calibrated: rms error",
                "deg",
                "error",
            ),
            Headline(
                "scooter",
                f"dual_{angle}_largest_p90_deg",
                _TEST,
                f"{angle} by two IMUs, not calibrated: largest 90 % error of a course",
                "deg",
                "error",
            ),
            Headline(
                "scooter",
                f"dual_below_single_{angle}",
                _TEST,
                f"{angle}: pairs of scooter and course with two IMUs below one",
                "1",
                "fraction",
            ),
            Headline(
                "scooter",
                f"kalman_below_dual_{angle}",
                _TEST,
                f"{angle}: pairs with the Kalman filter below the paper's two IMUs",
                "1",
                "fraction",
            ),
        )
    ),
    *(
        Headline("wheelchair", *rest)
        for rest in (
            ("speed_rms_mps", _SPEED, "speed: rms error", "m/s", "error", _CLOCKS),
            ("speed_covered", _SPEED, "speed: inside the stated 95 % interval", "1", "covered"),
            ("track_error_m", _SPEED, "track by `check`: error", "m", "error"),
            (
                "track_covered",
                _SPEED,
                "track: inside the stated 95 % interval",
                "1",
                "covered",
                _GYROSCOPES,
            ),
            (
                "geometry_fits",
                _SPEED,
                "right geometries that `check` calls right",
                "1",
                "fraction",
                _GYROSCOPES,
            ),
            (
                "slip_rms_mps",
                _SLIP,
                "speed where one wheel slips, corrected: rms error",
                "m/s",
                "error",
            ),
            (
                "slip_uncorrected_rms_mps",
                _SLIP,
                "speed where one wheel slips, not corrected: rms error",
                "m/s",
                "error",
            ),
            ("slip_flags_right", _SLIP, "flagged samples that slip", "1", "fraction"),
            ("slip_found", _SLIP, "slipping samples that are flagged", "1", "fraction"),
            (
                "tasks_alike",
                _TASKS,
                "samples with the task that the chair really did",
                "1",
                "fraction",
            ),
        )
    ),
    *(
        Headline("walker", *rest)
        for rest in (
            ("answered", _MOUNT, "calibrations that give a result", "1", "fraction"),
            (
                "mount_error_m",
                _MOUNT,
                "place of the sensor by whole arcs: error",
                "m",
                "error",
                _SIZES,
            ),
            ("mount_turn_deg", _MOUNT, "rotation of the sensor: error", "deg", "error", _SIZES),
            ("mount_covered", _MOUNT, "place: inside the stated 95 % interval", "1", "covered"),
            ("corridor_distance_percent", _CORRIDOR, "distance of 10 m: error", "%", "error"),
            (
                "corridor_end_percent",
                _CORRIDOR,
                "end of the walk: error in percent of the distance",
                "%",
                "error",
            ),
            (
                "corridor_end_covered",
                _CORRIDOR,
                "end: inside the stated 95 % interval",
                "1",
                "covered",
                _CREEP,
            ),
            (
                "rectangle_end_percent",
                _RECTANGLE,
                "end of the walk: error in percent of its 17.5 m",
                "%",
                "error",
                _SIZES,
            ),
            (
                "rectangle_end_covered",
                _RECTANGLE,
                "end: inside the stated 95 % interval",
                "1",
                "covered",
            ),
            ("corridor_steps_right", _STEPS, "walks whose steps are all counted", "1", "fraction"),
        )
    ),
)
"""Numbers that the chapters promise on simulated data."""


def at_levels(headline: Headline) -> tuple[float, float]:
    """Number with a data sheet's sensors, and with sensors as real ones are.

    Parameters
    ----------
    headline : Headline

    Returns
    -------
    two float
    """
    both = _record()[headline.work]
    return both["data sheet"][headline.key], both["real"][headline.key]


def what_changes(headline: Headline) -> str:
    """Sentence on what sensors as bad as real ones do to a promise.

    Parameters
    ----------
    headline : Headline

    Returns
    -------
    str
    """
    usual, real = at_levels(headline)
    if headline.rule == "error":
        factor = real / usual
        size = f"{factor:.1f} times as large" if factor > ABOUT else "hardly changes"
        text = size if real <= 2 * usual else f"does not hold: {size}"
    elif headline.rule == "covered":
        if real > LEAST_COVERED:
            text = "holds"
        elif usual > LEAST_COVERED:
            text = "does not hold: the stated uncertainty is too small"
        else:
            text = "does not hold with either kind of sensor: the stated uncertainty is too small"
    else:
        text = "holds" if abs(real - usual) <= LARGEST_OFF else "does not hold"
    return f"{text}; {headline.note}" if headline.note else text


def level_claims(work: Work | None = None) -> list[Claim]:
    """Rows of the scorecard on the headline numbers with sensors as real ones are.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three

    Returns
    -------
    list of Claim
    """
    return [_claim(one) for one in HEADLINES if work in (None, one.work)]


def _claim(headline: Headline) -> Claim:
    usual, real = at_levels(headline)
    rules: dict[Rule, dict[str, Any]] = {
        "error": {
            "reference": usual,
            "reference_from": "the same with sensors of a data sheet",
            "tolerance": usual,
            "tolerance_reason": TWICE,
        },
        "covered": {
            "reference": LEAST_COVERED,
            "reference_from": COVERED_FROM,
            "bound": "above",
            "tolerance_reason": COVERED_FROM,
        },
        "fraction": {
            "reference": usual,
            "reference_from": "the same with sensors of a data sheet",
            "tolerance": LARGEST_OFF,
            "tolerance_reason": TENTH,
        },
    }
    covered = headline.rule == "covered"
    return Claim(
        work=headline.work,
        where=f"sensors as real ones, {headline.chapter}",
        what=headline.what,
        unit=headline.unit,
        basis="computed on simulated data",
        compute=partial(float, real),
        n=_count(headline.work),
        why="the stated uncertainty does not hold"
        if covered
        else "the simulation promised too much",
        simulated=usual,
        simulated_as_real=real,
        **rules[headline.rule],
    )


def level_table() -> pd.DataFrame:
    """Every headline number at both levels, with what changes.

    Returns
    -------
    DataFrame: ``work``, ``chapter``, ``what``, ``unit``, ``data sheet``, ``real sensors``,
    ``what changes``
    """
    import pandas as pd

    rows = []
    for one in HEADLINES:
        usual, real = at_levels(one)
        rows.append(
            {
                "work": one.work,
                "chapter": one.chapter,
                "what": one.what,
                "unit": one.unit,
                "data sheet": usual,
                "real sensors": real,
                "what changes": what_changes(one),
            }
        )
    return pd.DataFrame(rows)


def _record() -> Mapping[str, Any]:
    found: Mapping[str, Any] = numbers("level_real")
    return found


def _count(work: Work) -> int:
    of = {"scooter": "rides", "wheelchair": "courts", "walker": "frames"}[work]
    return int(_record()[work]["real"][of])
