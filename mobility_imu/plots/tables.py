"""Tables that several chapters show: statements of a work with their verdicts, and Table 1."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mobility_imu.plots.style import show_table

if TYPE_CHECKING:
    import pandas as pd
    from pandas.io.formats.style import Styler

SHADES = {
    "agrees": "background-color: #DCEBF7; color: black",
    "differs": "background-color: #F8DFCF; color: black",
}
PARTS = ("mae", "sd")


def show_statements(outcomes: Iterable[Any], name: str, *, caption: str = "") -> Styler:
    """Statements of a work beside our numbers, one row each, with verdicts shaded and in words.

    Parameters
    ----------
    outcomes : ``reproduction.claims.Outcome``, one for each claim
    name : identifies the table in the page
    caption : text above the table

    Returns
    -------
    pandas Styler
        Statement with its place and unit, published number (or bound), reference, ours,
        tolerance, verdict. A fraction has no unit.

    Examples
    --------
    >>> from mobility_imu.reproduction.claims import check
    >>> from mobility_imu.reproduction.scooter.table_claims import table_claims
    >>> page = show_statements([check(table_claims()[-1])], "one").to_html()
    >>> ">agrees<" in page
    True
    """
    import pandas as pd

    rows = []
    for outcome in outcomes:
        claim = outcome.claim
        unit = "" if claim.unit == "1" else f" ({claim.unit})"
        reference = "" if claim.reference is None else f"{claim.reference:.4g}"
        rows.append(
            {
                "statement": f"{claim.what}{unit}",
                "place": claim.where,
                "published": f"{claim.bound} {claim.published}".strip() if claim.published else "",
                "reference": f"{claim.bound} {reference}".strip() if reference else "",
                "ours": _short(outcome.ours),
                "tolerance": _short(claim.tolerance),
                "verdict": outcome.verdict,
            }
        )
    table = pd.DataFrame(rows)
    shown = show_table(table, name, caption=caption or None, missing="")
    shown = shown.map(lambda cell: SHADES.get(cell, ""), subset=["verdict"])
    narrow = [column for column in table.columns if column != "statement"]
    shown = shown.set_properties(subset=narrow, **{"white-space": "nowrap"})
    return shown.set_properties(subset=["statement"], **{"min-width": "16em"})


def show_static_table(
    comparison: pd.DataFrame,
    mode: str,
    name: str,
    *,
    caption: str,
    tolerance_deg: float | None = None,
) -> Styler:
    """Table 1 of the scooter's paper in its own layout: five rows by five columns.

    Parameters
    ----------
    comparison : what ``reproduction.scooter.static_table.compare_static_table`` returned
    mode : "single" or "dual", for one IMU or two
    name : identifies the table in the page
    caption : text above the table
    tolerance_deg : float, deg; a mean error of ours that is further from the published one is
        shaded and marked with ≠. None leaves our rows out

    Returns
    -------
    pandas Styler
        Mean absolute error ± SD in each cell, deg; published and, below it, ours.

    Examples
    --------
    >>> from mobility_imu.reproduction.scooter.static_table import compare_static_table
    >>> table = compare_static_table()
    >>> shown = show_static_table(table, "single", "t1", caption="deg", tolerance_deg=1.0)
    >>> shown.to_html().count("≠")
    7
    """
    import pandas as pd

    wanted = comparison[comparison["quantity"].isin([f"{mode}_{part}" for part in PARTS])]
    columns = sorted(set(wanted["column"]))
    cells = wanted.set_index(["row", "column", "quantity"])
    rows: list[dict[str, Any]] = []
    for row in dict.fromkeys(wanted["row"]):
        mean, sd = ({c: cells.loc[(row, c, f"{mode}_{part}")] for c in columns} for part in PARTS)
        printed = {c: f"{mean[c]['published']:.2f} ± {sd[c]['published']:.2f}" for c in columns}
        source = {} if tolerance_deg is None else {"": "published"}
        rows.append({"slope": row} | source | printed)
        if tolerance_deg is not None:
            far = {c: abs(mean[c]["difference"]) > tolerance_deg for c in columns}
            ours = {c: f"{mean[c]['ours']:.2f} ± {sd[c]['ours']:.2f}" for c in columns}
            rows.append(
                {"slope": "", "": "geometry"}
                | {c: ours[c] + (" ≠" if far[c] else "") for c in columns}
            )
    shown = show_table(pd.DataFrame(rows), name, caption=caption)
    shown = shown.map(lambda text: SHADES["differs"] if "≠" in text else "", subset=columns)
    narrow = {"selector": "td, th", "props": "padding: 0.1em 0.35em"}
    shown = shown.set_table_styles([narrow], overwrite=False)
    return shown.set_properties(subset=columns, **{"white-space": "nowrap"})


def _short(value: float) -> str:
    """Four digits; a rounding error of a float becomes zero."""
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"
