"""Lines, arrows, arcs and labels that the explanatory drawings are made of.

An artist whose length or direction means something gets a name (``gid``), so that a test can
measure on the finished figure what was drawn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH_IN = 5.6
"""Width of a drawing, inches. On a phone, 360 px wide, its smallest letters are 9 px high."""
TEXT_PT = 11
SMALL_PT = 10.5
PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
BODY: dict[str, Any] = {"facecolor": "#EFEFEF", "edgecolor": "#9A9A9A", "linewidth": 1.2}
GREY = "#555555"


def direction(angle_rad: float) -> FloatArray:
    """Unit vector at an angle.

    Parameters
    ----------
    angle_rad : rad, counter-clockwise from the drawing's right

    Returns
    -------
    (2,) array
    """
    return np.array([np.cos(angle_rad), np.sin(angle_rad)])


def line(ax: Axes, points: ArrayLike, *, gid: str | None = None, **look: Any) -> None:
    """Draw a line through points.

    Parameters
    ----------
    ax : matplotlib axes
    points : (n, 2) array, in units of the drawing
    gid : name to find the artist by
    **look : for ``ax.plot``
    """
    look = {
        "color": "black",
        "linestyle": "-",
        "linewidth": 1.3,
        "solid_capstyle": "round",
        "zorder": 2,
        **look,
    }
    ax.plot(*np.asarray(points, float).T, gid=gid, **look)


def shape(ax: Axes, points: ArrayLike, *, gid: str | None = None, **look: Any) -> None:
    """Fill an outline, by default in the light grey of a body.

    Parameters
    ----------
    ax : matplotlib axes
    points : (n, 2) array, in units of the drawing
    gid : name to find the artist by
    **look : for ``Polygon``
    """
    from matplotlib.patches import Polygon

    ax.add_patch(Polygon(np.asarray(points, float), gid=gid, **{**BODY, "zorder": 1, **look}))


def disc(ax: Axes, centre: ArrayLike, radius: float, **look: Any) -> None:
    """Draw a circle.

    Parameters
    ----------
    ax : matplotlib axes
    centre : (2,) array, in units of the drawing
    radius : in the same units
    **look : for ``Circle``
    """
    from matplotlib.patches import Circle

    x, y = np.asarray(centre, float)
    ax.add_patch(Circle((x, y), radius, **{**BODY, "zorder": 1, **look}))


def box(
    ax: Axes, centre: ArrayLike, size: tuple[float, float], angle_rad: float = 0.0, **look: Any
) -> None:
    """Draw a rectangle about its centre.

    Parameters
    ----------
    ax : matplotlib axes
    centre : (2,) array, in units of the drawing
    size : length and height of its sides
    angle_rad : rad, of the first side, counter-clockwise from the drawing's right
    **look : for ``Rectangle``
    """
    from matplotlib.patches import Rectangle

    x, y = np.asarray(centre, float)
    width, height = size
    ax.add_patch(
        Rectangle(
            (x - width / 2, y - height / 2),
            width,
            height,
            angle=float(np.rad2deg(angle_rad)),
            rotation_point="center",
            **{"facecolor": "white", "edgecolor": "black", "linewidth": 1.6, "zorder": 5, **look},
        )
    )


def arrow(
    ax: Axes,
    start: ArrayLike,
    tip: ArrayLike,
    colour: str = "black",
    *,
    gid: str | None = None,
    head: str = "-|>",
    **look: Any,
) -> None:
    """Draw an arrow; the line under it carries the name, so that it can be measured.

    Parameters
    ----------
    ax : matplotlib axes
    start, tip : (2,) arrays, in units of the drawing
    colour : of line and head
    gid : name to find the artist by
    head : matplotlib's arrow style
    **look : for ``FancyArrowPatch``
    """
    from matplotlib.patches import FancyArrowPatch

    foot, point = np.asarray(start, float), np.asarray(tip, float)
    if gid is not None:
        line(ax, [foot, point], gid=gid, linewidth=0)
    look = {"linewidth": 1.8, "mutation_scale": 13, "zorder": 6, **look}
    ax.add_patch(
        FancyArrowPatch(
            tuple(foot), tuple(point), arrowstyle=head, color=colour, shrinkA=0, shrinkB=0, **look
        )
    )


def label(ax: Axes, place: ArrayLike, text: str, colour: str = "black", **look: Any) -> None:
    """Write on a light ground, so that lines underneath do not disturb.

    Parameters
    ----------
    ax : matplotlib axes
    place : (2,) array, in units of the drawing
    text : what to write
    colour : of the letters
    **look : for ``ax.text``
    """
    x, y = np.asarray(place, float)
    look = {"ha": "center", "va": "center", "fontsize": TEXT_PT, "bbox": PAPER, "zorder": 8, **look}
    ax.text(x, y, text, color=colour, **look)


def arc(
    ax: Axes,
    centre: ArrayLike,
    radius: ArrayLike,
    start_rad: float,
    stop_rad: float,
    *,
    colour: str = "black",
    arrowhead: bool = False,
    gid: str | None = None,
    **look: Any,
) -> None:
    """Draw part of a circle or ellipse, with an arrowhead at its end if wanted.

    Parameters
    ----------
    ax : matplotlib axes
    centre : (2,) array, in units of the drawing
    radius : one radius, or (2,) for an ellipse that shows a circle from the side
    start_rad, stop_rad : rad, counter-clockwise from the drawing's right
    colour : of the line
    arrowhead : whether the end has one
    gid : name to find the artist by
    **look : for ``ax.plot``
    """
    angles = np.linspace(start_rad, stop_rad, 60)
    reach = np.broadcast_to(np.asarray(radius, float), (2,))
    points = np.asarray(centre, float) + reach * np.column_stack([np.cos(angles), np.sin(angles)])
    line(ax, points, gid=gid, color=colour, **{"linewidth": 1.5, **look})
    if arrowhead:
        arrow(ax, points[-5], points[-1], colour, linewidth=0.1)


def dimension(
    ax: Axes,
    start: ArrayLike,
    end: ArrayLike,
    text: str,
    *,
    gid: str | None = None,
    colour: str = "black",
    shift: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Draw a length between two points, with its name in the middle.

    Parameters
    ----------
    ax : matplotlib axes
    start, end : (2,) arrays, in units of the drawing
    text : name of the length
    gid : name to find the artist by
    colour : of line and name
    shift : of the name, from the middle
    """
    foot, point = np.asarray(start, float), np.asarray(end, float)
    arrow(ax, foot, point, colour, gid=gid, head="<|-|>", linewidth=1.0, mutation_scale=10)
    label(ax, (foot + point) / 2 + shift, text, colour)


def point_out(ax: Axes, place: ArrayLike, colour: str, *, into: bool = False) -> None:
    """Mark an axis that points to the reader (dot), or away from the reader (cross).

    Parameters
    ----------
    ax : matplotlib axes
    place : (2,) array, in units of the drawing
    colour : of the mark
    into : whether the axis points away from the reader
    """
    x, y = np.asarray(place, float)
    ax.plot(x, y, "o", color=colour, markersize=11, mfc="white", mew=1.6, zorder=7)
    ax.plot(x, y, "x" if into else "o", color=colour, markersize=6 if into else 4, zorder=8)


def number(ax: Axes, place: ArrayLike, text: str, target: ArrayLike | None = None) -> None:
    """Write a number in a circle, with a thin line to what it names.

    Parameters
    ----------
    ax : matplotlib axes
    place : (2,) array, in units of the drawing
    text : the number
    target : (2,) array, where the line ends; None draws no line
    """
    x, y = np.asarray(place, float)
    if target is not None:
        line(ax, [(x, y), tuple(np.asarray(target, float))], color=GREY, linewidth=0.9, zorder=6)
        ax.plot(*np.asarray(target, float), "o", color=GREY, markersize=3, zorder=6)
    ax.text(
        x,
        y,
        text,
        ha="center",
        va="center",
        fontsize=SMALL_PT,
        zorder=9,
        bbox={"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": "black"},
    )


def blank(ax: Axes, across: tuple[float, float], upward: tuple[float, float]) -> None:
    """Take off the axes; lengths are true to scale.

    Parameters
    ----------
    ax : matplotlib axes
    across, upward : lowest and highest coordinate that is shown
    """
    ax.set_aspect("equal")
    ax.set_xlim(*across)
    ax.set_ylim(*upward)
    ax.axis("off")
