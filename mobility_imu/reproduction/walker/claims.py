"""What Doan & Pham state about the walker, each with our number beside it.

Their recordings are not published. What can be had is the arithmetic of the printed tables, the
geometry of the equations (:mod:`mobility_imu.reproduction.walker.claims_equations`), and the
experiments on a simulated frame (:mod:`mobility_imu.reproduction.walker.claims_simulated`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from mobility_imu.reproduction.claims import Cell, Claim, Quotation, share_rule
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.walker.claims_equations import equation_claims
from mobility_imu.reproduction.walker.claims_simulated import simulated_claims
from mobility_imu.reproduction.walker.tables import (
    CLOSING_COLUMN,
    POSES,
    PRINT_DEFECT,
    lever_arm_ratio,
    rotation_defect,
    runs,
)

UNIT_M = 1e-4
UNIT_REASON = "one unit of the fourth decimal: the average is rounded, and so are its rows"
WALK = {2: "walk", 3: "round", 4: "round"}
COLUMNS = {
    2: {"distance_estimation": "distance", "distance_error": "distance error"},
    3: {"x": "x error", "y": "y error", "z": "z error", "distance": "closing error"},
    4: {"x": "x error", "y": "y error", "z": "z error", "position": "closing error"},
}
"""Columns of Tables 2 to 4, and what they hold."""
NOT_PUBLISHED = "not published"
IMAGE_ONLY = "shown in the figure, which our text copies lack"


def claims() -> list[Claim]:
    """All rows of the walker's work.

    Returns
    -------
    list of Claim
    """
    return [
        *_averages(),
        *_distance_errors(),
        *_closing_lengths(),
        *_rotations(),
        *_text(),
        *_methods_compared(),
        *_from_recordings(),
        *equation_claims(),
        *simulated_claims(),
    ]


def _claim(where: str, what: str, unit: str, **fields: Any) -> Claim:
    return Claim(work="walker", where=where, what=what, unit=unit, **fields)


def _printed(
    where: str, what: str, unit: str, compute: Callable[[], float], **fields: Any
) -> Claim:
    """A row of arithmetic with printed numbers; why it differs, a finding says, if there is one."""
    return _claim(
        where,
        what,
        unit,
        basis="published numbers recomputed",
        compute=compute,
        why=None if fields.get("finding") else "the text contradicts itself",
        **fields,
    )


def _cells(table: int) -> dict[tuple[str, str], tuple[Cell, str]]:
    """Cell and printed text by row and column."""
    name = f"walker_table{table}"
    cells = load_published(name)[["row", "column", "quantity", "printed"]]
    return {
        (row, column): (Cell(name, row, column, quantity), printed)
        for row, column, quantity, printed in cells.itertuples(index=False)
    }


def _averages() -> list[Claim]:
    """The 60 printed averages of Tables 2 to 4 against the mean of their printed rows."""
    found = []
    for table, columns in COLUMNS.items():
        cells = _cells(table)
        for column, what in columns.items():
            for pose in (*POSES, None):
                row = "average" if pose is None else f"{pose}/average"
                source, printed = cells[row, column]
                count = 30 if pose is None else 6
                own = (table, column, pose) == (2, "distance_estimation", "5")
                zeros = column == "z"
                found.append(
                    _printed(
                        f"Table {table}" if pose is None else f"Table {table}, pose {pose}",
                        f"mean {what} of {count} {WALK[table]}s",
                        "m",
                        partial(_mean, table, column, pose),
                        source=source,
                        published=printed,
                        n=count,
                        tolerance=UNIT_M,
                        tolerance_reason=UNIT_REASON,
                        trivial=0.0 if zeros else np.nan,
                        trivial_model="zeros" if zeros else "",
                        finding="K5" if own else "",
                    )
                )
    return found


def _mean(table: int, column: str, pose: str | None) -> float:
    values = runs(table, column)
    return float(values.mean() if pose is None else values[POSES.index(pose)].mean())


def _distance_errors() -> list[Claim]:
    """The 30 distance errors of Table 2 against the distances beside them."""
    cells = _cells(2)
    return [
        _printed(
            f"Table 2, pose {pose}, walk {walk}",
            "distance error: difference of the distance from 10 m",
            "m",
            partial(
                lambda k, j: abs(10 - float(runs(2, "distance_estimation")[k, j])), k, walk - 1
            ),
            source=cells[f"{pose}/{walk}", "distance_error"][0],
            published=cells[f"{pose}/{walk}", "distance_error"][1],
            tolerance=1e-9,
            tolerance_reason="the difference of two published decimals is exact",
        )
        for k, pose in enumerate(POSES)
        for walk in range(1, 7)
    ]


def _closing_lengths() -> list[Claim]:
    """The 60 lengths of Tables 3 and 4 against the x and y beside them."""
    found = []
    for table, column in CLOSING_COLUMN.items():
        cells = _cells(table)
        found += [
            _printed(
                f"Table {table}, pose {pose}, round {walk}",
                "closing error: length of its x and y",
                "m",
                partial(_length, table, k, walk - 1),
                source=cells[f"{pose}/{walk}", column][0],
                published=cells[f"{pose}/{walk}", column][1],
                tolerance=1.21e-4,
                tolerance_reason="half a unit of the fourth decimal in x, in y and in the length",
            )
            for k, pose in enumerate(POSES)
            for walk in range(1, 7)
        ]
    return found


def _length(table: int, pose: int, walk: int) -> float:
    return float(np.hypot(runs(table, "x")[pose, walk], runs(table, "y")[pose, walk]))


def _rotations() -> list[Claim]:
    """Whether the matrices of Table 1 are rotations, and what Tables 3 and 4 hold."""
    matrices = [
        _printed(
            f"Table 1, pose {pose}",
            "largest entry of abs(C C' - I)",
            "1",
            partial(rotation_defect, pose),
            reference=0.0,
            reference_from="a rotation matrix",
            n=9,
            tolerance=PRINT_DEFECT,
            tolerance_reason="the rows are up to 0.0005 short of unit length; chosen with the "
            "table known",
            finding={"1": "K4", "2": "K11"}.get(pose, ""),
        )
        for pose in POSES
    ]
    return [
        *matrices,
        _printed(
            "Tables 1, 3 and 4 with eq. 27",
            "rounds whose two closing errors differ by the length of T1 − T2, to 1 %",
            "of 30",
            lambda: float((np.abs(lever_arm_ratio() - 1) < 0.01).sum()),
            reference=0.0,
            reference_from="(27): 0 times the lever arm for a round that ends with its first "
            "heading, 1.41 times for a last corner that is not turned",
            n=30,
            tolerance=0.0,
            tolerance_reason="a count",
            finding="K6",
        ),
    ]


_AVERAGES_IN_TEXT = (
    "However, the average position errors of the x, y, z distance errors are -0.3019 m, 0.2849 m, "
    "0.517 m using the first estimated BCS and -0.33374 m, 0.2012 m, 0.5041 m using the second "
    "estimated BCS, respectively."
)
_CORRIDOR_IN_TEXT = (
    "The average distance estimation is 9.8011 m and the average distance error is 0.3123 m."
)


def _text() -> list[Claim]:
    """Numbers that the text prints, against the tables."""
    quoted = (
        (_CORRIDOR_IN_TEXT, "9.8011", "mean distance of 30 walks", (2, "distance_estimation")),
        (_CORRIDOR_IN_TEXT, "0.3123", "mean distance error of 30 walks", (2, "distance_error")),
        (_AVERAGES_IN_TEXT, "-0.3019", "mean x error, first method", (3, "x")),
        (_AVERAGES_IN_TEXT, "0.2849", "mean y error, first method", (3, "y")),
        (_AVERAGES_IN_TEXT, "0.517", "mean closing error, first method", (3, "distance")),
        (_AVERAGES_IN_TEXT, "-0.33374", "mean x error, second method", (4, "x")),
        (_AVERAGES_IN_TEXT, "0.2012", "mean y error, second method", (4, "y")),
        (_AVERAGES_IN_TEXT, "0.5041", "mean closing error, second method", (4, "position")),
    )
    averages = [
        _printed(
            "section 3, text",
            what,
            "m",
            partial(_mean, *place, None),
            source=Quotation(sentence),
            published=printed,
            n=30,
            tolerance=UNIT_M,
            tolerance_reason=UNIT_REASON,
            finding="K5" if printed == "-0.33374" else "",
        )
        for sentence, printed, what, place in quoted
    ]
    return [*averages, *_accuracies(), *_counts()]


def _distance_accuracy() -> float:
    return 100 - 10 * float(runs(2, "distance_error").mean())


def _closing_percent(table: int) -> float:
    return 100 * float(runs(table, CLOSING_COLUMN[table]).mean()) / 17.5


def _accuracies() -> list[Claim]:
    """Percentages of the text."""
    rows: tuple[tuple[str, str, str, str, Callable[[], float]], ...] = (
        (
            "section 3, text",
            "accuracy of the distance in the corridor",
            "97",
            "the accuracy of distance estimation using the walker system is approximately 97%",
            _distance_accuracy,
        ),
        (
            "abstract, position",
            "100 % less the mean closing error over 17.5 m, first method",
            "97",
            "the proposed method achieves acceptable accuracy (97% of distance and position)",
            lambda: 100 - _closing_percent(3),
        ),
        (
            "section 4, position",
            "100 % less the mean closing error over 17.5 m, second method",
            "97",
            "the accuracy of the estimated distance and position is approximately 97%",
            lambda: 100 - _closing_percent(4),
        ),
        (
            "section 3, text",
            "mean closing error over 17.5 m, first method",
            "3",
            "The average distance error is approximately 3% (0.517 m per 17.5 m walking)",
            lambda: _closing_percent(3),
        ),
        (
            "section 3, text",
            "mean closing error over 17.5 m, second method",
            "3",
            "give the same performance with a distance error of approximately 3%",
            lambda: _closing_percent(4),
        ),
        (
            "section 4, text",
            "accuracy of the distance in this study, beside 98.3 % and 98.5 % before",
            "97",
            "approximately 98.3% in [10], 98.5% in [19], and 97% in this study.",
            _distance_accuracy,
        ),
    )
    return [
        _printed(
            where,
            what,
            "%",
            compute,
            source=Quotation(sentence),
            published=printed,
            n=30,
            tolerance=0.5,
            tolerance_reason="the paper gives whole percents",
        )
        for where, what, printed, sentence, compute in rows
    ]


def _counts() -> list[Claim]:
    return [
        _printed(
            "section 4, text",
            "perimeter of the rectangle of 5 m by 3.75 m",
            "m",
            lambda: 2 * (5 + 3.75),
            source=Quotation("a rectangle with a perimeter of 17.5m (5m × 3.75m)"),
            published="17.5",
            n=2,
            tolerance=1e-9,
            tolerance_reason="exact",
        ),
        _printed(
            "section 3, text",
            "poses of the IMU in the corridor's table",
            "poses",
            lambda: float(len(runs(2, "distance_estimation"))),
            source=Quotation("Thus, the ICS is only set at pose 1 and only"),
            reference=1.0,
            reference_from='"only set at pose 1"',
            n=30,
            tolerance=0.0,
            tolerance_reason="a count",
            finding="K9",
        ),
    ]


def _methods_compared() -> list[Claim]:
    """What the text concludes from Tables 3 and 4 about the two methods."""
    return [
        _printed(
            "section 3, same performance",
            "mean closing error, second less first method",
            "m",
            lambda: float((runs(4, "position") - runs(3, "distance")).mean()),
            source=Quotation("give the same performance with a distance error of approximately 3%"),
            reference=0.0,
            reference_from="the same performance",
            n=30,
            tolerance=0.05,
            tolerance_reason="a tenth of the error itself; chosen with the tables known",
            experiment=True,
            finding="K12",
        ),
        _printed(
            "section 3, small difference",
            "share of poses in which the two methods' mean closing errors differ by less than six "
            "rounds scatter (sd)",
            "of 1",
            _less_than_scatter,
            source=Quotation(
                "there is a small difference of position error and distance error using the first "
                "and second estimated BCS"
            ),
            reference=1.0,
            reference_from="the statement holds",
            experiment=True,
            finding="K12",
            **share_rule(5, "what is small was chosen with the tables known"),
        ),
        *_not_tested(),
    ]


def _not_tested() -> list[Claim]:
    """Statements that neither the authors nor we have tested."""
    return [
        _claim(
            "section 4, no significant reduction",
            "accuracy of the distance against that of references 10 and 19",
            "%",
            basis="not reproducible",
            source=Quotation("there is no significant reduction in the accuracy of the distance"),
            reason="the spread of the earlier results is not given: 1.3 and 1.5 points of "
            "accuracy less are about twice the error, and both views are fair",
            experiment=True,
            finding="K19",
        ),
        *(
            _claim(
                f"section 4, front-wheeled walker, {name} method",
                what,
                "-",
                basis="not reproducible",
                source=Quotation(sentence),
                reason="not tested by the authors, and no front-wheeled frame is simulated here",
            )
            for name, what, sentence in (
                (
                    "second",
                    "whether two tilts calibrate it",
                    "it can be applied to a front-wheeled walker by using the second method (two "
                    "tilting movements)",
                ),
                (
                    "first",
                    "whether the tilt to the front fails",
                    "The first method (four tilting movements) cannot be directly applied to a "
                    "front-wheeled walker",
                ),
            )
        ),
    ]


def _less_than_scatter() -> float:
    first, second = runs(3, "distance"), runs(4, "position")
    apart = np.abs(second.mean(axis=1) - first.mean(axis=1))
    return float((apart < first.std(axis=1, ddof=1)).mean())


def _from_recordings() -> list[Claim]:
    """What only the recordings could give: Tables 1 to 4 and Figures 6 and 7."""
    missing = partial(_claim, basis="not reproducible", experiment=True)
    cells = _cells(1)
    found = [
        missing(
            f"Table 1, pose {pose}, from the recording",
            f"{axis} of the IMU's position by the {('first', 'second')[k - 1]} method",
            "m",
            source=cells[pose, f"T{k}[{axis}]"][0],
            published=cells[pose, f"T{k}[{axis}]"][1],
            reason=NOT_PUBLISHED,
        )
        for pose in POSES
        for k in (1, 2)
        for axis in "xyz"
    ]
    found += [
        missing(
            f"Table {table}, pose {pose}, from the recordings",
            what,
            unit,
            n=n,
            reason=NOT_PUBLISHED,
        )
        for table, what, unit, n in (
            (1, "nine entries of the rotation matrix", "1", 9),
            (2, "six distances", "m", 6),
            (3, "x, y and length of six closing errors", "m", 18),
            (4, "x, y and length of six closing errors", "m", 18),
        )
        for pose in POSES
    ]
    return found + [
        missing(f"Figure {number}", what, "m", reason=IMAGE_ONLY)
        for number, what in ((6, "paths along the corridor"), (7, "paths around the rectangle"))
    ]
