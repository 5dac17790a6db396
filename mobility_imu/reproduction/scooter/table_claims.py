"""Claims on Table 1 of Suzurikawa et al. 2022 and on the other numbers of its text.

The basis is the geometry alone, or the paper's numbers computed again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from itertools import product
from typing import Any, Literal

import numpy as np

from mobility_imu.reproduction.claims import COIN, Cell, Claim, Quotation, share_rule
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.scooter.static_table import (
    CELL_TOLERANCE_DEG,
    CELL_TOLERANCE_REASON,
    COLUMNS,
    ROWS,
    STEERING_POSITIONS_RAD,
    THROTTLE_POSITIONS_RAD,
    static_subtraction,
    static_table,
)
from mobility_imu.scooter.angles import estimate_angles, steering_angle, throttle_angle
from mobility_imu.scooter.geometry import SUZUKI_ET4D, body_specific_force, lever_acceleration

Mode = Literal["single", "dual"]
FloatTable = dict[tuple[str, str], float]

RANGE_DEG = {"steering": 100.0, "throttle": 40.0}
"""Ranges of both controls (section 2.1, "approximately")."""
HOLDS = "the statement holds"
COUNT_REASON = "a count of published numbers"

SHARES = Quotation(
    "These values are approximately equal to 10% and 11.3% of the movable ranges for the two "
    "interfaces."
)
EXCEEDED = Quotation(
    "While the MAEs with the single IMU exceeded 5° under 13 conditions, the corresponding errors "
    "with the dual IMUs remained under 5° under all conditions."
)
ELIMINATED = Quotation(
    "Although the inclination of the scooter body caused large estimation errors when using a "
    "single IMU, the acceleration correction with use of the second IMU on the scooter body "
    "eliminated these errors successfully."
)
CROSSTALK = Quotation(
    "However, the operation of one interface affected the estimation accuracy for the other "
    "interface to some extent."
)
COLOURED = Quotation(
    "the conditions under which the maximum MAEs were observed in their respective"
)
MERIT = Quotation(
    "This calculation naturally causes an estimation error due to the angular misalignment between "
    "the two IMU coordinates. The current method, therefore, has obvious merit in the estimation "
    "accuracy."
)
JOYSTICK = Quotation(
    "A prior study of the angle estimation of a PWC joystick with IMUs reported a MAE that was "
    "under 10% of the maximum range [37]. This level of accuracy is approximately equivalent to "
    "that achieved using the current method."
)
LEVEL_TERRAIN = Quotation(
    "If the measurements are performed on terrains without inclinations, the correction performed "
    "with the second IMU may not be necessary, depending on the accuracy required."
)
REQUISITES = Quotation("The test scooter described above has all these structural requisites.")


def table_claims() -> list[Claim]:
    """Claims that follow from the paper's numbers or from geometry.

    Returns
    -------
    list of Claim
        First the 100 cells of Table 1.
    """
    return [*_cells(), *_of_the_table(), *_of_the_text()]


def _cells() -> list[Claim]:
    """All 100 numbers of Table 1, by geometry alone."""
    found = []
    for mode, row, column, part in product(("single", "dual"), ROWS, COLUMNS, ("mae", "sd")):
        quantity = f"{mode}_{part}"
        steering = column in "ab"
        claim = Claim(
            work="scooter",
            where=f"Table 1, {_imus(mode)}, {ROWS.index(row) + 1}-{column}",
            what=f"{part.upper()} of the {'steering' if steering else 'throttle'} angle, {row}",
            unit="deg",
            basis="computed by geometry alone",
            source=Cell("scooter_table1", row, column, quantity),
            published=_printed()[row, column, quantity],
            compute=partial(_ours, row, column, quantity),
            n=len(STEERING_POSITIONS_RAD if steering else THROTTLE_POSITIONS_RAD),
            tolerance=CELL_TOLERANCE_DEG if mode == "single" else 0.005,
            tolerance_reason=_cell_reason(mode, part),
            trivial=0.0,
            trivial_model="zeros",
            experiment=True,
            finding="S4" if row == "right" and not steering else "",
            why="our assumptions do not explain it",
        )
        found.append(claim)
    return found


def _imus(mode: str) -> str:
    return {"single": "single IMU", "dual": "dual IMUs"}[mode]


def _cell_reason(mode: str, part: str) -> str:
    if mode == "dual":
        return "half of the last published digit; geometry alone leaves two IMUs no error"
    if part == "sd":
        return "as for the MAE; the reading of the SD was chosen with four cells known"
    return CELL_TOLERANCE_REASON


@cache
def _printed() -> dict[tuple[str, str, str], str]:
    cells = load_published("scooter_table1")
    keys = zip(cells["row"], cells["column"], cells["quantity"], strict=True)
    return dict(zip(keys, cells["printed"], strict=True))


@cache
def _table() -> dict[tuple[str, str, str], float]:
    table = static_table()
    keys = zip(table["row"], table["column"], table["quantity"], strict=True)
    return dict(zip(keys, (float(v) for v in table["value"]), strict=True))


def _ours(row: str, column: str, quantity: str) -> float:
    return _table()[row, column, quantity]


def _maes(mode: Mode, columns: str = "abcde", *, ours: bool = False) -> FloatTable:
    """MAE by row and column, deg, as in the paper or by geometry alone."""
    return {
        (row, column): (
            _table()[row, column, f"{mode}_mae"]
            if ours
            else float(_printed()[row, column, f"{mode}_mae"])
        )
        for row in ROWS
        for column in columns
    }


def _of_the_table() -> list[Claim]:
    """What section 3.1 and the captions say of Table 1."""
    recomputed = partial(
        Claim,
        work="scooter",
        basis="published numbers recomputed",
        n=25,
        tolerance_reason=COUNT_REASON,
        experiment=True,
    )
    geometry = partial(recomputed, basis="computed by geometry alone")
    holds: dict[str, Any] = {"unit": "1", "reference": 1.0, "reference_from": HOLDS}
    return [
        recomputed(
            where="section 3.1",
            what="conditions of Table 1 (rows times columns)",
            unit="conditions",
            source=Quotation("showing the mean absolute errors (MAEs) and SDs for 25 measurement"),
            published="25",
            compute=lambda: float(len(_maes("single"))),
            experiment=False,
        ),
        recomputed(
            where="section 3.1",
            what="cells with an MAE above 5 deg, single IMU",
            unit="cells",
            source=EXCEEDED,
            published="13",
            compute=lambda: _above(_maes("single")),
        ),
        geometry(
            where="section 3.1",
            what="cells with an MAE above 5.00 deg, single IMU, by geometry",
            unit="cells",
            source=EXCEEDED,
            published="13",
            compute=lambda: _above(_maes("single", ours=True)),
            tolerance_reason="a count; geometry puts 2-c and 3-c at 5.00 deg itself",
            trivial=0.0,
            trivial_model="zeros",
        ),
        recomputed(
            where="section 3.1",
            what="fraction of the dual cells with an MAE under 5 deg",
            source=EXCEEDED,
            compute=lambda: float(np.mean([v < 5 for v in _maes("dual").values()])),
            **holds,
        ),
        *_corrected(recomputed, geometry, holds),
        *_crosstalk(recomputed, geometry, holds),
    ]


def _above(cells: FloatTable) -> float:
    return float(sum(round(value, 2) > 5 for value in cells.values()))


def _corrected(
    recomputed: Callable[..., Claim], geometry: Callable[..., Claim], holds: dict[str, Any]
) -> list[Claim]:
    """Whether the second IMU takes out what the slope does."""

    def better(ours: bool) -> float:
        single, dual = _maes("single", ours=ours), _maes("dual", ours=ours)
        return float(np.mean([dual[key] < single[key] for key in single if key[0] != "flat"]))

    common: dict[str, Any] = holds | {
        "where": "section 3.1",
        "source": ELIMINATED,
        **share_rule(20),
        **COIN,
    }
    what = "fraction of the 20 inclined conditions with a smaller MAE for two IMUs"
    return [
        recomputed(what=what, compute=partial(better, False), **common),
        geometry(what=f"{what}, by geometry", compute=partial(better, True), **common),
    ]


def _crosstalk(
    recomputed: Callable[..., Claim], geometry: Callable[..., Claim], holds: dict[str, Any]
) -> list[Claim]:
    """Whether one control changes the error of the other."""

    def affected(ours: bool) -> float:
        cells = _maes("dual", ours=ours)
        spans = [
            np.ptp([cells[row, column] for column in columns])
            for row in ROWS
            for columns in ("ab", "cde")
        ]
        return float(np.mean(np.array(spans) > 0.5))

    common: dict[str, Any] = holds | {
        "where": "section 3.1",
        "source": CROSSTALK,
        **share_rule(10, "the 0.5 deg are ours"),
    }
    what = "fraction of rows in which a dual MAE changes by over 0.5 deg with the other control"
    return [
        recomputed(what=what, compute=partial(affected, False), **common),
        geometry(what=f"{what}, by geometry", compute=partial(affected, True), **common),
    ]


def largest_mae(mode: Mode, columns: str) -> str:
    """Cell of Table 1 with the largest MAE of the paper, as in "4-a".

    Parameters
    ----------
    mode : "single" or "dual"
    columns : "ab" for steering, "cde" for throttle

    Returns
    -------
    str
        Number of the row and letter of the column.
    """
    cells = _maes(mode, columns)
    row, column = max(cells, key=lambda key: cells[key])
    return f"{ROWS.index(row) + 1}-{column}"


def _of_the_text() -> list[Claim]:
    """Percentages of the ranges, data rate, equations, and the other study's accuracy."""
    recomputed = partial(
        Claim, work="scooter", basis="published numbers recomputed", tolerance_reason=COUNT_REASON
    )
    rounding = "rounding of the published number"
    return [
        recomputed(
            where="section 3.2",
            what="10 deg in percent of the steering's range of 100 deg",
            unit="%",
            source=SHARES,
            published="10",
            compute=lambda: 100 * 10 / RANGE_DEG["steering"],
            tolerance=0.5,
            tolerance_reason=rounding,
        ),
        recomputed(
            where="section 3.2",
            what='5 deg in percent of a range of exactly 40 deg, one reading of "these values"',
            unit="%",
            source=SHARES,
            published="11.3",
            compute=lambda: 100 * 5 / RANGE_DEG["throttle"],
            tolerance=0.05,
            tolerance_reason=rounding,
            finding="S1",
        ),
        recomputed(
            where="section 4",
            what="data rate of six 16-bit streams at 100 Hz",
            unit="kbit/s",
            source=Quotation(
                "The data acquisition bitrate is at least 9.6 kbps for six 16-bit acceleration "
                "streams at 100 Hz"
            ),
            published="9.6",
            compute=lambda: 6 * 16 * 100 / 1000,
            tolerance=0.05,
            tolerance_reason=rounding,
        ),
        *_comparisons_of_the_text(),
    ]


def _comparisons_of_the_text() -> list[Claim]:
    """Statements of the text that compare errors."""
    recomputed = partial(
        Claim, work="scooter", basis="published numbers recomputed", tolerance_reason=COUNT_REASON
    )
    return [
        recomputed(
            where="section 4",
            what="fraction of Table 1's dual MAE under 10 % of the control's range",
            unit="1",
            source=JOYSTICK,
            reference=1.0,
            reference_from=HOLDS,
            compute=_share_under_ten_percent,
            n=25,
            experiment=True,
            finding="S5",
        ),
        recomputed(
            where="section 4",
            what="flat row of Table 1: mean MAE of one IMU less that of two",
            unit="deg",
            source=LEVEL_TERRAIN,
            reference=0.0,
            reference_from="no gain from the second IMU on level ground",
            compute=_gain_on_the_level,
            n=10,
            tolerance=0.5,
            tolerance_reason="half a degree, ours; chosen with the result known",
            experiment=True,
        ),
        Claim(
            work="scooter",
            where="section 4",
            what="fraction of the 20 inclined conditions, dual below subtraction, by geometry",
            unit="1",
            basis="computed by geometry alone",
            source=MERIT,
            reference=1.0,
            reference_from=HOLDS,
            compute=_merit_at_rest,
            n=20,
            tolerance_reason="all of them; geometry leaves two IMUs no error",
        ),
        *_of_the_equations(),
    ]


def _merit_at_rest() -> float:
    subtraction = static_subtraction()
    dual = _maes("dual", ours=True)
    return float(
        np.mean([dual[r, c] < subtraction.loc[r, c] for r in ROWS if r != "flat" for c in COLUMNS])
    )


def _share_under_ten_percent() -> float:
    return float(
        np.mean(
            [
                value < 0.1 * RANGE_DEG["steering" if column in "ab" else "throttle"]
                for (_, column), value in _maes("dual").items()
            ]
        )
    )


def _gain_on_the_level() -> float:
    single, dual = _maes("single"), _maes("dual")
    return float(np.mean([single["flat", c] - dual["flat", c] for c in COLUMNS]))


def _of_the_equations() -> list[Claim]:
    """Equations 6 and 7 against 5, and the conditions of section 2.2."""
    geometry = partial(Claim, work="scooter", basis="computed by geometry alone")
    common: dict[str, Any] = {
        "unit": "deg",
        "reference": 0.0,
        "reference_from": "equations 6 and 7 undo equation 5",
        "n": 2000,
        "tolerance": 1e-9,
        "tolerance_reason": "rounding of the computer; slopes up to 7 deg, all positions",
    }
    return [
        geometry(
            where="equation 6",
            what="largest steering error on readings that equation 5 gives, two IMUs",
            compute=lambda: _round_trip_deg()[0],
            **common,
        ),
        geometry(
            where="equation 7",
            what="largest throttle error on readings that equation 5 gives, two IMUs",
            compute=lambda: _round_trip_deg()[1],
            **common,
        ),
        geometry(
            where="section 2.2",
            what="fraction of the controls' range, level ground, where both angles can be seen",
            unit="1",
            source=REQUISITES,
            reference=1.0,
            reference_from=HOLDS,
            compute=_observable_share,
            n=303,
            tolerance_reason="a count",
        ),
    ]


@cache
def _round_trip_deg() -> tuple[float, float]:
    rng = np.random.default_rng(2022)
    steering, throttle = np.deg2rad(rng.uniform([[-50], [0]], [[50], [40]], (2, 2000)))
    body = body_specific_force(*np.deg2rad(rng.uniform(-7, 7, (2, 2000))))
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    wheel = steering_angle(lever, body, SUZUKI_ET4D)
    press = throttle_angle(lever, body, wheel, SUZUKI_ET4D)
    return (
        float(np.rad2deg(np.abs(wheel - steering).max())),
        float(np.rad2deg(np.abs(press - throttle).max())),
    )


def _observable_share() -> float:
    """Fraction of the controls' positions at which the package calls the angles valid."""
    wheel, press = np.meshgrid(np.deg2rad(np.linspace(-50, 50, 101)), np.deg2rad([0, 20, 40]))
    lever = lever_acceleration(body_specific_force(0.0, 0.0), wheel, press, SUZUKI_ET4D)
    return float(estimate_angles(lever, None, SUZUKI_ET4D).valid.mean())
