"""Figures of the scooter: its frames, and Table 1 beside what geometry predicts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.plots.style import COLOURS
from mobility_imu.scooter.geometry import ScooterGeometry

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# One colour and line style per frame, the same in every panel.
FRAME_LOOK: dict[str, dict[str, Any]] = {
    "B": {"color": COLOURS["black"], "linestyle": "-"},
    "N": {"color": COLOURS["blue"], "linestyle": "-"},
    "S": {"color": COLOURS["vermillion"], "linestyle": "-"},
    "W": {"color": COLOURS["green"], "linestyle": "-"},
    "T": {"color": COLOURS["purple"], "linestyle": "-"},
}


def draw_frames(geometry: ScooterGeometry, *, steering_rad: float, throttle_rad: float) -> Figure:
    """Draw the scooter with {B}, {N}, {S}, {W}, {T} and the four angles between them.

    Parameters
    ----------
    geometry : ScooterGeometry
    steering_rad : float, rad, shown in the view along the shaft, positive to the left
    throttle_rad : float, rad, shown at the lever, positive pushed

    Returns
    -------
    Figure with three panels: side view, view along the shaft, lever from the side
    """
    import matplotlib.pyplot as plt

    figure, axes = plt.subplot_mosaic(
        [["side", "shaft"], ["side", "lever"]],
        figsize=(9.6, 6.2),
        width_ratios=[1.55, 1],
        height_ratios=[1, 1],
    )
    _draw_side(axes["side"], geometry)
    _draw_shaft_view(axes["shaft"], steering_rad)
    _draw_lever(axes["lever"], geometry, throttle_rad)
    for ax in axes.values():
        ax.set_aspect("equal")
        ax.axis("off")
    return figure


def plot_static_table(comparison: pd.DataFrame) -> Figure:
    """Plot Table 1 as printed beside ours: one panel per number of IMUs, same axes.

    Parameters
    ----------
    comparison : what ``reproduction.scooter.compare_static_table`` gives

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    table = comparison.set_index(["quantity", "row", "column"])[["published", "ours"]]
    rows = list(dict.fromkeys(comparison["row"]))
    columns = list(dict.fromkeys(comparison["column"]))
    places = np.array([6 * r + c for r in range(len(rows)) for c in range(len(columns))])
    figure, panels = plt.subplots(2, 1, figsize=(9.0, 6.4), sharex=True, sharey=True)
    for ax, mode, title in zip(
        panels, ("single", "dual"), ("Single IMU", "Dual IMUs"), strict=True
    ):
        for who, shift, look in (
            ("ours", -0.17, {"marker": "s", "mfc": "white", "color": COLOURS["blue"]}),
            ("published", 0.17, {"marker": "o", "color": COLOURS["vermillion"]}),
        ):
            mean, spread = (table.loc[f"{mode}_{part}", who].to_numpy() for part in ("mae", "sd"))
            label = "published" if who == "published" else "geometry alone"
            ax.errorbar(
                places + shift,
                mean,
                yerr=spread,
                linestyle="none",
                capsize=2,
                elinewidth=1,
                label=f"{label}: MAE, bar: SD",
                **look,
            )
        ax.set_title(title)
        ax.set_ylabel("error, deg")
        ax.grid(visible=False, axis="x")
        for edge in range(1, len(rows)):
            ax.axvline(6 * edge - 1, color="#BBBBBB", linewidth=0.8, linestyle="-")
    panels[0].legend(loc="upper left")
    panels[0].set_ylim(bottom=0)
    panels[1].set_xticks(places, columns * len(rows))
    for index, row in enumerate(rows):
        panels[1].annotate(
            row,
            (6 * index + 2, 0),
            xycoords=("data", "axes fraction"),
            xytext=(0, -22),
            textcoords="offset points",
            ha="center",
            va="top",
        )
    panels[1].set_xlabel(
        "body inclination, and column of Table 1 (a, b: steering error; c, d, e: throttle error)",
        labelpad=20,
    )
    return figure


def _draw_side(ax: Axes, geometry: ScooterGeometry) -> None:
    """Draw the scooter from its right; forward is to the right, lengths in m."""
    from matplotlib.patches import Circle, FancyBboxPatch, Polygon

    alpha = geometry.steering_inclination_rad
    body = {"facecolor": "#EFEFEF", "edgecolor": "#9A9A9A", "linewidth": 1.2}
    for centre in (0.17, 0.99):
        ax.add_patch(Circle((centre, 0.14), 0.14, facecolor="#D9D9D9", edgecolor="#8A8A8A"))
        ax.add_patch(Circle((centre, 0.14), 0.05, facecolor="white", edgecolor="#8A8A8A"))
    deck = [(0.02, 0.30), (0.36, 0.30), (0.42, 0.17), (0.80, 0.17), (0.90, 0.32), (1.16, 0.32)]
    ax.add_patch(Polygon([*deck, (1.16, 0.39), (0.86, 0.39), (0.77, 0.23), (0.45, 0.23),
                          (0.40, 0.44), (0.02, 0.44)], closed=True, **body))  # fmt: skip
    ax.add_patch(FancyBboxPatch((0.05, 0.50), 0.36, 0.05, boxstyle="round,pad=0.015", **body))
    ax.add_patch(Polygon([(0.02, 0.56), (-0.06, 0.93), (0.00, 0.94), (0.08, 0.56)], **body))
    ax.plot([0.22, 0.22], [0.44, 0.49], color="#9A9A9A", linewidth=6, solid_capstyle="butt")
    ax.plot([-0.2, 1.55], [0, 0], color="#8A8A8A", linewidth=1, linestyle="-")

    foot = np.array([1.02, 0.36])
    along = np.array([-np.sin(alpha), np.cos(alpha)])
    top = foot + 0.62 * along
    ax.plot(*np.transpose([foot, top]), color="#8A8A8A", linewidth=7, solid_capstyle="round",
            linestyle="-")  # fmt: skip
    across = np.array([np.cos(alpha), np.sin(alpha)])
    ax.plot(*np.transpose([top - 0.10 * across, top + 0.06 * across]), color="#8A8A8A",
            linewidth=5, solid_capstyle="round", linestyle="-")  # fmt: skip
    basket = np.array([[1.13, 0.52], [1.36, 0.52], [1.39, 0.72], [1.10, 0.72]])
    ax.add_patch(Polygon(basket, facecolor="none", edgecolor="#9A9A9A", hatch="xx", linewidth=1))
    ax.plot([1.10, 1.20], [0.39, 0.52], color="#9A9A9A", linewidth=3, linestyle="-")

    # Shaft and its inclination.
    ax.plot(*np.transpose([foot - 0.1 * along, top + 0.42 * along]), linewidth=1.2,
            color=COLOURS["blue"], linestyle="--")  # fmt: skip
    ax.plot([foot[0]] * 2, [foot[1], foot[1] + 0.98], linewidth=1.2, color="black", linestyle=":")
    _arc(ax, foot, 0.86, np.pi / 2, np.pi / 2 + alpha, r"$\alpha$", COLOURS["blue"], push=0.06)

    _triad(ax, foot + 0.02 * along, alpha, "N", length=0.30, forward_dy=0.05)
    body_imu = np.array([1.24, 0.62])
    _imu(ax, body_imu, 0.0, "B")
    _triad(ax, body_imu, 0.0, "B", length=0.30)
    lever_imu = top - 0.06 * across + 0.06 * along
    tilt = geometry.lever_inclination_rad
    _imu(ax, lever_imu, tilt, "T")
    ax.annotate(
        "lever IMU {T}",
        lever_imu + [-0.02, 0.03],
        (0.30, 1.20),
        ha="center",
        color=COLOURS["purple"],
        arrowprops={"arrowstyle": "-", "color": COLOURS["purple"], "shrinkB": 3},
    )
    ax.annotate(
        "body IMU {B}\n(basket, fixed to the body)",
        body_imu + [0.06, -0.02],
        (1.46, 0.30),
        ha="center",
        arrowprops={"arrowstyle": "-", "color": "black", "shrinkB": 3},
    )
    ax.text(0.75, 1.42, "steering shaft", color=COLOURS["blue"], ha="right")
    ax.annotate(
        "", (1.75, 0.06), (1.45, 0.06), arrowprops={"arrowstyle": "-|>", "color": "#6E6E6E"}
    )
    ax.text(1.60, 0.08, "forward", ha="center", color="#6E6E6E")
    ax.set_title("Side view, from the right: x points to the reader")
    ax.set_xlim(-0.15, 1.85)
    ax.set_ylim(-0.05, 1.52)


def _draw_shaft_view(ax: Axes, steering_rad: float) -> None:
    """Draw the wheel as seen along the shaft from above; forward is up."""
    from matplotlib.patches import Circle

    ax.add_patch(Circle((0, 0), 0.62, facecolor="none", edgecolor="#BBBBBB", linewidth=7))
    turn = np.array(
        [
            [np.cos(steering_rad), -np.sin(steering_rad)],
            [np.sin(steering_rad), np.cos(steering_rad)],
        ]
    )
    bar = turn @ np.array([[-0.62, 0.62], [0.0, 0.0]])
    ax.plot(*bar, color="#BBBBBB", linewidth=7, linestyle="-", zorder=1)
    grip = turn @ np.array([0.40, 0.12])
    _imu(ax, grip, steering_rad, "T", size=0.13)
    ax.text(*(turn @ np.array([0.37, 0.30])), "lever IMU", color=COLOURS["purple"], fontsize=9)
    for frame, angle, length in (("N", 0.0, 1.0), ("S", steering_rad, 1.0)):
        for axis, direction in (("x", angle), ("y", angle + np.pi / 2)):
            tip = length * np.array([np.cos(direction), np.sin(direction)])
            _arrow(ax, np.zeros(2), tip, frame)
            ax.text(*(1.1 * tip), rf"${axis}_{frame}$", ha="center", va="center",
                    color=FRAME_LOOK[frame]["color"])  # fmt: skip
    ax.plot(0, 0, "o", color="black", markersize=5)
    ax.plot(0, 0, "o", color="black", markersize=11, mfc="none")
    ax.text(-0.06, -0.16, r"$z_N = z_S$", ha="right")
    _arc(ax, np.zeros(2), 0.8, np.pi / 2, np.pi / 2 + steering_rad, r"$\theta_S > 0$",
         COLOURS["vermillion"], push=0.2, arrow=True)  # fmt: skip
    ax.set_title("Along the shaft, from above: left is positive")
    ax.set_xlim(-1.3, 1.3)
    ax.set_ylim(-0.72, 1.25)


def _draw_lever(ax: Axes, geometry: ScooterGeometry, throttle_rad: float) -> None:
    """Draw the lever from its right, wheel straight: what alpha, beta and throttle do to y."""
    alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
    origin = np.zeros(2)
    ax.plot([0, 1.45], [0, 0], color="black", linewidth=1, linestyle=":")
    ax.text(1.47, 0.0, r"$y_B$", va="center")
    for frame, label, angle in (
        ("S", r"$y_N, y_S$", alpha),
        ("W", r"$y_W$", beta),
        ("T", r"$y_T$", beta - throttle_rad),
    ):
        tip = 1.3 * np.array([np.cos(angle), np.sin(angle)])
        _arrow(ax, origin, tip, frame)
        ax.text(*(tip * 1.04), label, color=FRAME_LOOK[frame]["color"], va="center", ha="left")
    for frame, angle in (("W", beta), ("T", beta - throttle_rad)):
        up = 0.85 * np.array([-np.sin(angle), np.cos(angle)])
        _arrow(ax, origin, up, frame)
        ax.text(*(up * 1.1), rf"$z_{frame}$", color=FRAME_LOOK[frame]["color"], ha="center")
    _imu(ax, origin, beta - throttle_rad, "T", size=0.16)
    ax.plot(0, 0, "o", color="black", markersize=4, zorder=5)
    _arc(ax, origin, 1.12, 0, alpha, r"$\alpha$", COLOURS["vermillion"], push=-0.09)
    _arc(ax, origin, 0.78, 0, beta, r"$\beta$", COLOURS["green"], push=-0.08)
    _arc(ax, origin, 0.6, np.pi / 2 + beta, np.pi / 2 + beta - throttle_rad, r"$\theta_T > 0$",
         COLOURS["purple"], push=0.14, arrow=True)  # fmt: skip
    _arc(ax, origin, 0.98, beta, beta - throttle_rad, "", COLOURS["purple"], arrow=True)
    ax.set_title("At the lever, from the right: pushing is positive")
    ax.set_xlim(-0.45, 1.75)
    ax.set_ylim(-0.55, 1.05)


def _triad(
    ax: Axes, origin: Any, angle: float, frame: str, *, length: float, forward_dy: float = 0.0
) -> None:
    """Draw y and z of a frame seen from the right, and x as an arrow's point."""
    for axis, direction in (("y", angle), ("z", angle + np.pi / 2)):
        tip = origin + length * np.array([np.cos(direction), np.sin(direction)])
        _arrow(ax, origin, tip, frame)
        shift = np.array([0.045, 0.0 + forward_dy]) if axis == "y" else np.array([0.035, 0.02])
        ax.text(*(tip + shift), rf"${axis}_{frame}$", color=FRAME_LOOK[frame]["color"],
                ha="center", va="center")  # fmt: skip
    colour = FRAME_LOOK[frame]["color"]
    ax.plot(*origin, "o", color=colour, markersize=4, zorder=6)
    ax.plot(*origin, "o", color=colour, markersize=10, mfc="none", zorder=6)
    ax.text(*(np.asarray(origin) + [-0.055, -0.045]), rf"$x_{frame}$", color=colour,
            ha="center", va="center")  # fmt: skip


def _arrow(ax: Axes, start: Any, tip: Any, frame: str) -> None:
    ax.annotate(
        "",
        tip,
        start,
        arrowprops={
            "arrowstyle": "-|>",
            "linewidth": 1.8,
            "shrinkA": 0,
            "shrinkB": 0,
            **FRAME_LOOK[frame],
        },
    )


def _imu(ax: Axes, centre: Any, angle: float, frame: str, size: float = 0.08) -> None:
    from matplotlib.patches import Rectangle

    box = Rectangle(
        (centre[0] - size / 2, centre[1] - size / 4),
        size,
        size / 2,
        angle=float(np.rad2deg(angle)),
        rotation_point="center",
        facecolor="white",
        edgecolor=FRAME_LOOK[frame]["color"],
        linewidth=1.6,
        zorder=4,
    )
    ax.add_patch(box)


def _arc(
    ax: Axes,
    centre: Any,
    radius: float,
    start: float,
    stop: float,
    label: str,
    colour: str,
    *,
    push: float = 0.0,
    arrow: bool = False,
) -> None:
    """Draw an arc from start to stop with its label ``push`` outside of its middle."""
    angle = np.linspace(start, stop, 40)
    points = np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    ax.plot(*points.T, color=colour, linewidth=1.3, linestyle="-")
    if arrow:
        ax.annotate(
            "",
            points[-1],
            points[-4],
            arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0},
        )
    middle = (start + stop) / 2
    place = np.asarray(centre) + (radius + push) * np.array([np.cos(middle), np.sin(middle)])
    ax.text(*place, label, color=colour, ha="center", va="center")
