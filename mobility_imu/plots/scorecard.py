"""Figures and tables of the scorecard, made for a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mobility_imu.plots.style import COLOURS, use_style
from mobility_imu.plots.tables import SHADES

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from pandas.io.formats.style import Styler

LOOKS = {
    "agrees": ("blue", ""),
    "differs": ("vermilion", "///"),
    "not reproducible": ("grey", "..."),
    "needs the sample": ("sky", "xx"),
}
"""Colour and hatch of each verdict."""


def plot_totals(counted: pd.DataFrame) -> Figure:
    """Plot the number of rows by work, basis and verdict as stacked bars.

    Parameters
    ----------
    counted : what ``reproduction.scorecard.totals`` returned

    Returns
    -------
    Figure: one panel per work, one bar per basis; the number of rows is written beside each bar
    """
    import matplotlib.pyplot as plt

    works = list(dict.fromkeys(counted.index.get_level_values("work")))
    bases = list(dict.fromkeys(counted.index.get_level_values("basis")))
    longest = counted[list(LOOKS)].sum(axis=1).max()
    with use_style():
        figure, panels = plt.subplots(1, len(works), figsize=(8.8, 2.9), sharey=True, sharex=True)
        for ax, work in zip(panels, works, strict=True):
            rows = counted.loc[work].reindex(bases, fill_value=0)
            start = np.zeros(len(bases))
            for verdict, (colour, hatch) in LOOKS.items():
                width = rows[verdict].to_numpy()
                bars = {"color": COLOURS[colour], "hatch": hatch, "edgecolor": "white"}
                ax.barh(range(len(bases)), width, left=start, label=verdict, **bars)
                start = start + width
            for y, total in enumerate(start):
                if total:
                    ax.text(total + 0.02 * longest, y, f"{total:.0f}", va="center", fontsize=9)
            ax.set(title=work, xlabel="rows", xlim=(0, 1.15 * longest))
            ax.grid(visible=False, axis="y")
        panels[0].set_yticks(range(len(bases)), bases)
        panels[0].invert_yaxis()
        figure.legend(
            *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(LOOKS)
        )
    return figure


def plot_real_errors(rows: pd.DataFrame) -> Figure:
    """Plot errors on real recordings as multiples of the same errors on simulated ones.

    Parameters
    ----------
    rows : records of ``reproduction.scorecard.to_records`` on real recordings, as a DataFrame

    Returns
    -------
    Figure: one dot for each row that is an error and has a simulated value; filled if it agrees
    """
    import matplotlib.pyplot as plt

    told = rows["what"].str.contains("error") & ~rows["what"].str.contains("actual error")
    errors = rows[told & (rows["simulated"] > 0)]
    ratio = errors["ours"] / errors["simulated"]
    quantity = errors["what"].str.replace(r": .*error.*", "", regex=True)
    names = errors["where"].str.replace(r",.*", "", regex=True) + ": " + quantity
    with use_style():
        figure, ax = plt.subplots(figsize=(8.4, 1.0 + 0.3 * len(errors)))
        for y, (value, verdict) in enumerate(zip(ratio, errors["verdict"], strict=True)):
            colour = COLOURS[LOOKS[verdict][0]]
            face = colour if verdict == "agrees" else "white"
            ax.plot(value, y, "o", color=colour, markerfacecolor=face, markersize=7)
        ax.axvline(2, color=COLOURS["grey"], linestyle="--", linewidth=1)
        ax.text(2.1, -0.6, "twice", color=COLOURS["grey"], fontsize=9, va="center")
        ax.set(xscale="log", xlabel="real error over simulated error", ylim=(len(errors) - 0.5, -1))
        ax.set_yticks(range(len(errors)), names)
        ax.grid(visible=False, axis="y")
    return figure


def show_rows(rows: pd.DataFrame, name: str, *, last: str) -> Styler:
    """Rows of the scorecard as a table that fits the page.

    Parameters
    ----------
    rows : records of ``reproduction.scorecard.to_records``, as a DataFrame
    name : identifies the table in the page
    last : the last column, "why" or "verdict"

    Returns
    -------
    pandas Styler
        Place with quantity and unit, published, reference, ours, tolerance, last column.
    """
    import pandas as pd

    table = pd.DataFrame(
        {
            "statement": rows["where"] + ": " + rows["what"] + _units(rows),
            "published": _bound(rows).where(rows["published"].notna(), "")
            + rows["published"].fillna("–"),
            "reference": _bound(rows).where(rows["reference"].notna(), "")
            + _digits(rows["reference"]),
            "ours": _digits(rows["ours"]),
            "tolerance": _digits(rows["tolerance"], 2),
            last: rows[last].fillna(""),
        }
    )
    return _laid_out(table, name, (37, 12, 13, 10, 13, 15))


def show_real_rows(rows: pd.DataFrame, name: str) -> Styler:
    """Rows on real recordings as a table that fits the page.

    Parameters
    ----------
    rows : records of ``reproduction.scorecard.to_records``, as a DataFrame
    name : identifies the table in the page

    Returns
    -------
    pandas Styler
        Set, quantity with its unit, asked for, found, simulated, at the level of real sensors,
        number of recordings, verdict.
    """
    import pandas as pd

    table = pd.DataFrame(
        {
            "set": rows["where"].where(~rows["where"].duplicated(), ""),
            "what": rows["what"] + _units(rows),
            "asked for": _bound(rows) + _digits(rows["reference"], 3),
            "found": _digits(rows["ours"], 3),
            "simulated": _digits(rows["simulated"], 3),
            "real level": _digits(rows["simulated_as_real"], 3),
            "n": rows["n"],
            "verdict": rows["verdict"],
        }
    )
    return _laid_out(table, name, (15, 30, 10, 10, 11, 8, 5, 11))


def show_levels(levels: pd.DataFrame, name: str) -> Styler:
    """What changes with sensors as bad as real ones, as a table that fits the page.

    Parameters
    ----------
    levels : what ``reproduction.real_level_claims.level_table`` returned
    name : identifies the table in the page

    Returns
    -------
    pandas Styler
    """
    import pandas as pd

    table = pd.DataFrame(
        {
            "chapter": levels["chapter"].where(~levels["chapter"].duplicated(), ""),
            "what": (levels["what"] + _units(levels)).str.replace("`", ""),
            "data sheet": _digits(levels["data sheet"], 3),
            "real sensors": _digits(levels["real sensors"], 3),
            "what changes": levels["what changes"].str.replace("`", ""),
        }
    )
    return _laid_out(table, name, (14, 31, 11, 11, 33))


def _units(rows: pd.DataFrame) -> pd.Series[str]:
    return rows["unit"].map(lambda unit: "" if unit == "1" else f" ({unit})")


def _bound(rows: pd.DataFrame) -> pd.Series[str]:
    return rows["bound"].map(lambda bound: f"{bound} ", na_action="ignore").fillna("")


def _digits(values: pd.Series[float], digits: int = 4) -> pd.Series[str]:
    return values.map(f"{{:.{digits}g}}".format, na_action="ignore").fillna("–")


def _laid_out(table: pd.DataFrame, name: str, widths_percent: Sequence[int]) -> Styler:
    """A table as wide as the page: columns of stated widths, long words broken, verdicts shaded."""
    styles = [{"selector": "", "props": "table-layout: fixed; width: 100%"}]
    styles += [
        {"selector": f"th:nth-child({k})", "props": f"width: {width}%; text-align: left"}
        for k, width in enumerate(widths_percent, start=1)
    ]
    cells = {"text-align": "left", "padding": "0.1em 0.3em", "overflow-wrap": "break-word"}
    shown = table.style.hide(axis="index").set_properties(**cells).set_table_styles(styles)
    if "verdict" in table:
        shown = shown.map(lambda verdict: SHADES.get(verdict, ""), subset=["verdict"])
    return shown.set_uuid(name)
