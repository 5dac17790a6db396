"""One look for every figure: colours that colour-blind readers tell apart, and a second cue.

Never let colour alone carry a meaning: pair it with a line style, marker, hatch or label.
"""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
    from pandas.io.formats.style import Styler

# Okabe and Ito's palette, with a grey instead of the yellow, which is too pale on white.
COLOURS = {
    "black": "#000000",
    "blue": "#0072B2",
    "vermilion": "#D55E00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "grey": "#6E6E6E",
}
CYCLE = ("blue", "vermilion", "green", "purple", "orange", "black")
LINE_STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 3)))
MARKERS = ("o", "s", "^", "D", "v", "X")
HATCHES = ("", "///", "...", "xx", "\\\\\\", "++")


class _Restore(ExitStack):
    """Puts the former defaults back; as the last line of a notebook's cell it shows nothing."""

    def _ipython_display_(self) -> None:
        """Show nothing."""


def use_style() -> ExitStack:
    """Set matplotlib's defaults: palette, line styles, type sizes.

    Returns
    -------
    ExitStack
        As a context manager it puts the former defaults back at the end of the ``with`` block;
        left alone, the style stays for the session.

    Examples
    --------
    >>> import matplotlib
    >>> with use_style():
    ...     matplotlib.rcParams["axes.spines.top"]
    False
    """
    import matplotlib
    from cycler import cycler

    settings: dict[str, Any] = {
        "axes.prop_cycle": cycler(color=[COLOURS[name] for name in CYCLE])
        + cycler(linestyle=list(LINE_STYLES)),
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.titlesize": 11,
        "axes.titlelocation": "left",
        "axes.labelsize": 10,
        "figure.constrained_layout.use": True,
        "figure.dpi": 110,
        "figure.figsize": (7.2, 4.0),
        "font.size": 10,
        "grid.color": "#DDDDDD",
        "grid.linewidth": 0.6,
        "legend.fontsize": 9,
        "legend.frameon": False,
        "lines.linewidth": 1.6,
        "lines.markersize": 5,
        "xtick.labelsize": 9,
        "ytick.labelsize": 9,
    }
    former = {key: matplotlib.rcParams[key] for key in settings}
    matplotlib.rcParams.update(settings)
    restore = _Restore()
    restore.callback(matplotlib.rcParams.update, former)
    return restore


def cue(index: int) -> dict[str, Any]:
    """Colour, line style and marker number ``index`` as keyword arguments of a plot call.

    Parameters
    ----------
    index : counted from 0; starts again after the last

    Returns
    -------
    dict with ``color``, ``linestyle`` and ``marker``

    Examples
    --------
    >>> cue(1)
    {'color': '#D55E00', 'linestyle': '--', 'marker': 's'}
    """
    return {
        "color": COLOURS[CYCLE[index % len(CYCLE)]],
        "linestyle": LINE_STYLES[index % len(LINE_STYLES)],
        "marker": MARKERS[index % len(MARKERS)],
    }


def show_table(
    table: pd.DataFrame,
    name: str,
    digits: int = 3,
    *,
    index: bool = False,
    caption: str | None = None,
    missing: str = "–",
) -> Styler:
    """Table of a chapter: numbers of one length, words to the left, the same page each time.

    Parameters
    ----------
    table : DataFrame
    name : identifies the table in the page, so that two builds give the same page
    digits : behind the decimal point
    index : whether the rows' labels are shown
    caption : text above the table
    missing : text shown for NaN

    Returns
    -------
    pandas Styler, which a notebook shows as HTML

    Examples
    --------
    >>> import pandas as pd
    >>> "0.33" in show_table(pd.DataFrame({"sd": [1 / 3]}), "thirds", 2).to_html()
    True
    """
    padding = {"selector": "td, th", "props": "padding: 0.1em 0.7em; text-align: left"}
    styled = table.style.format(precision=digits, na_rep=missing).set_table_styles([padding])
    styled = styled.set_table_attributes('class="dataframe"')  # the page's colours, light or dark
    if not index:
        styled = styled.hide(axis="index")
    if caption is not None:
        styled = styled.set_caption(caption)
    return styled.set_uuid("".join(c for c in name if c.isalnum() or c in "-_"))
