"""Suzurikawa et al. 2022: what the paper prints and states, each with our number beside it.

Table 1 by geometry alone, what the text says of the table, its other numbers, and its statements on
the driving test. What only the images or the recordings hold is listed as not reproducible.
"""

from __future__ import annotations

from typing import Any

from mobility_imu.reproduction.claims import Claim, Quotation
from mobility_imu.reproduction.scooter.driving_claims import driving_claims
from mobility_imu.reproduction.scooter.driving_rides import ANGLES
from mobility_imu.reproduction.scooter.table_claims import (
    COLOURED,
    Mode,
    largest_mae,
    table_claims,
)
from mobility_imu.simulation.scooter import COURSES

IMAGE = "shown in the figure, which our text copies lack"
PRIVATE = (
    "not published; the paper offers its data on reasonable request to the corresponding author, "
    "and we have not asked"
)


def claims() -> list[Claim]:
    """Claims of the scooter's paper: table, text, driving test, and what cannot be had.

    Returns
    -------
    list of Claim
    """
    return [*table_claims(), *driving_claims(), *_not_reproducible()]


def _not_reproducible() -> list[Claim]:
    """Numbers in images, and what only the recordings could give."""
    percentiles = [
        _lost(
            where="Figure 9",
            what=f"90th percentile, {angle}, {course}, {imus}",
            unit="deg",
            source=Quotation(
                "The 90th percentile values of the error distributions are also shown in the "
                "panels."
            ),
            reason=IMAGE,
        )
        for angle in ANGLES
        for course in COURSES
        for imus in ("single IMU", "dual IMUs")
    ]
    return [
        *percentiles,
        *_coloured(),
        _lost(
            where="Table 1",
            what="the table from its readings",
            unit="deg",
            source=Quotation("Table 1 summarizes the results of the geometric evaluation"),
            reason=PRIVATE,
            n=100,
        ),
        _lost(
            where="Figure 6",
            what="estimated against true angles at every position",
            unit="deg",
            source=Quotation(
                "Figure 6 shows line plots of the true and estimated angles for all the measurement"
            ),
            reason=IMAGE,
            n=100,
        ),
        _lost(
            where="Figure 7",
            what="time series of both angles on five courses",
            unit="deg",
            source=Quotation("Figure 7 shows the true and estimated time series values"),
            reason=f"{IMAGE}; {PRIVATE}",
        ),
        _lost(
            where="Figure 8",
            what="durations by true and estimated angle",
            unit="s",
            source=Quotation("The recorded duration at each bin with widths of 2° in both axes"),
            reason=f"{IMAGE}; {PRIVATE}",
        ),
        *_beyond_the_figures(),
    ]


def _beyond_the_figures() -> list[Claim]:
    """What no figure could give, either."""
    return [
        _lost(
            where="section 3.1",
            what="backlash as the cause of the crosstalk",
            unit="deg",
            source=Quotation(
                "The mechanical looseness or backlash in the rotational axes of both interfaces is "
                "one possible cause of this tendency"
            ),
            reason=f"{PRIVATE}; the table alone cannot tell it from a lever IMU that is turned",
        ),
        _lost(
            where="section 4",
            what="the method on a single-board microcontroller",
            unit="1",
            source=Quotation(
                "this performance can be sufficiently achieved with low-cost single-board "
                "microcontrollers such as the Arduino series"
            ),
            reason="no such board was tried, by the paper or here",
            experiment=False,
        ),
    ]


def _coloured() -> list[Claim]:
    """Conditions that Figure 6 draws in colour, as those with the largest MAE of their panel."""
    panels: tuple[tuple[str, Mode, str], ...] = (
        ("(a)(i)", "single", "ab"),
        ("(b)(i)", "single", "cde"),
        ("(a)(ii)", "dual", "ab"),
        ("(b)(ii)", "dual", "cde"),
    )
    return [
        _lost(
            where=f"Figure 6 {panel}",
            what="condition with the largest MAE of the panel",
            unit="-",
            source=COLOURED,
            reason="the legend is in the figure, which our text copies lack; by Table 1 it "
            f"must be {largest_mae(mode, columns)}",
            n=5 * len(columns),
        )
        for panel, mode, columns in panels
    ]


def _lost(**given: Any) -> Claim:
    usual: dict[str, Any] = {"work": "scooter", "basis": "not reproducible", "experiment": True}
    return Claim(**(usual | given))
