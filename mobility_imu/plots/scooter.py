"""Figures of the scooter: its frames, and Table 1 beside what geometry predicts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.plots.style import COLOURS, use_style
from mobility_imu.scooter.geometry import ScooterGeometry

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Of each frame, the same in every panel: the colour of its arrows, and a darker one for letters.
FRAME_COLOURS = {
    "B": (COLOURS["black"], "#000000"),
    "N": (COLOURS["blue"], "#00537F"),
    "S": (COLOURS["vermilion"], "#A34700"),
    "W": (COLOURS["green"], "#006B4E"),
    "T": (COLOURS["purple"], "#9A4373"),
}
BODY: dict[str, Any] = {"facecolor": "#EFEFEF", "edgecolor": "#9A9A9A", "linewidth": 1.2}
PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}


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

    with use_style():
        figure, axes = plt.subplot_mosaic(
            [["side", "shaft"], ["side", "lever"]], figsize=(9.6, 5.9), width_ratios=[1.45, 1]
        )
        _draw_side(axes["side"], geometry)
        _draw_shaft_view(axes["shaft"], steering_rad)
        _draw_lever(axes["lever"], geometry, throttle_rad)
        for ax in axes.values():
            ax.set_aspect("equal", anchor="N")
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

    rows = list(dict.fromkeys(comparison["row"]))
    columns = sorted(set(comparison["column"]))
    places = np.array([6 * r + c for r in range(len(rows)) for c in range(len(columns))])
    looks: dict[str, tuple[str, float, dict[str, Any], str]] = {
        "ours": ("geometry alone", -0.17, {"marker": "s", "mfc": "white", "zorder": 3}, "blue"),
        "published": ("published", 0.17, {"marker": "o"}, "vermilion"),
    }
    with use_style():
        figure, panels = plt.subplots(2, 1, figsize=(9.0, 6.4), sharex=True, sharey=True)
        for ax, mode in zip(panels, ("single", "dual"), strict=True):
            for who, (label, shift, look, colour) in looks.items():
                mean, spread = (
                    comparison.loc[comparison["quantity"] == f"{mode}_{part}", who].to_numpy()
                    for part in ("mae", "sd")
                )
                ax.errorbar(
                    places + shift,
                    mean,
                    yerr=spread,
                    color=COLOURS[colour],
                    linestyle="none",
                    capsize=2,
                    elinewidth=1,
                    label=f"{label} (MAE; bar: SD)",
                    **look,
                )
            ax.set_title(f"{mode.capitalize()} IMU{'s' if mode == 'dual' else ''}")
            ax.set_ylabel("absolute error, deg")
            ax.grid(visible=False, axis="x")
            for edge in range(1, len(rows)):
                ax.axvline(6 * edge - 1, color="#BBBBBB", linewidth=0.8, linestyle="-")
        panels[1].legend(loc="upper left")
        panels[0].set_ylim(-0.6, 24)
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
            "body inclination, and column of Table 1 (a, b: steering error; c, d, e: throttle)",
            labelpad=20,
        )
    return figure


def _draw_side(ax: Axes, geometry: ScooterGeometry) -> None:
    """Draw the scooter from its right, lengths in m, forward to the right."""
    from matplotlib.patches import Circle, FancyBboxPatch, Polygon

    alpha = geometry.steering_inclination_rad
    along = np.array([-np.sin(alpha), np.cos(alpha)])  # up the shaft
    across = np.array([np.cos(alpha), np.sin(alpha)])
    foot = np.array([1.02, 0.36])
    top = foot + 0.62 * along

    for centre in (0.17, 0.99):
        ax.add_patch(Circle((centre, 0.14), 0.14, facecolor="#D9D9D9", edgecolor="#8A8A8A"))
        ax.add_patch(Circle((centre, 0.14), 0.05, facecolor="white", edgecolor="#8A8A8A"))
    upper = [(0.02, 0.44), (0.40, 0.44), (0.45, 0.23), (0.77, 0.23), (0.86, 0.39), (1.16, 0.39)]
    lower = [(1.16, 0.32), (0.90, 0.32), (0.80, 0.17), (0.42, 0.17), (0.36, 0.30), (0.02, 0.30)]
    back = [(0.02, 0.56), (-0.06, 0.93), (0.00, 0.94), (0.08, 0.56)]
    ax.add_patch(Polygon(upper + lower, **BODY))
    ax.add_patch(Polygon(back, **BODY))
    ax.add_patch(FancyBboxPatch((0.05, 0.50), 0.36, 0.05, boxstyle="round,pad=0.015", **BODY))
    _line(ax, (0.22, 0.44), (0.22, 0.49), color="#9A9A9A", linewidth=6)
    _line(ax, (-0.15, 0), (1.75, 0), color="#8A8A8A", linewidth=1)
    _line(ax, foot, top, color="#A8A8A8", linewidth=7)
    _line(ax, top - 0.10 * across, top + 0.06 * across, color="#A8A8A8", linewidth=5)
    _line(ax, (1.10, 0.39), (1.20, 0.52), color="#9A9A9A", linewidth=3)
    basket = [(1.13, 0.52), (1.36, 0.52), (1.39, 0.72), (1.10, 0.72)]
    ax.add_patch(Polygon(basket, facecolor="none", edgecolor="#C4C4C4", hatch="xx", linewidth=1))

    _line(ax, foot - 0.1 * along, foot + 1.12 * along, color=COLOURS["blue"], linestyle="--")
    _line(ax, foot, np.add(foot, [0, 1.12]), color="black", linestyle=":")
    _arc(ax, foot, 1.05, np.pi / 2, np.pi / 2 + alpha, r"$\alpha$", "N", push=0.06)
    _label(ax, foot + 1.12 * along - [0.03, 0], "steering shaft", "N", ha="right")
    _side_axes(ax, top, alpha, "N", 0.30)

    body_imu = np.array([1.24, 0.62])
    _imu(ax, body_imu, 0.0, "B", 0.08)
    _side_axes(ax, body_imu, 0.0, "B", 0.30)
    lever_imu = top - 0.21 * across
    _line(ax, top - 0.1 * across, lever_imu, color="#A8A8A8", linewidth=2)
    _imu(ax, lever_imu, geometry.lever_inclination_rad, "T", 0.08)
    _name_imus(ax, lever_imu, body_imu)
    _arrow(ax, (1.42, 0.07), (1.72, 0.07), "#6E6E6E")
    ax.text(1.57, 0.09, "forward", ha="center", color="#555555")
    ax.set_title("Side view, from the right; x points to the reader")
    ax.set_xlim(-0.15, 1.80)
    ax.set_ylim(-0.05, 1.56)


def _name_imus(ax: Axes, lever_imu: FloatArray, body_imu: FloatArray) -> None:
    """Names of both IMUs in the side view, with lines to where they sit."""
    for text, place, target, frame in (
        ("lever IMU {T}", (0.33, 1.14), np.add(lever_imu, [-0.02, 0.02]), "T"),
        (
            "body IMU {B}\n(basket, fixed to the body)",
            (1.42, 0.30),
            np.add(body_imu, [0.04, -0.02]),
            "B",
        ),
    ):
        arrow = {"arrowstyle": "-", "color": FRAME_COLOURS[frame][0], "shrinkB": 3}
        ax.annotate(
            text,
            (target[0], target[1]),
            place,
            ha="center",
            color=FRAME_COLOURS[frame][1],
            arrowprops=arrow,
        )


def _draw_shaft_view(ax: Axes, steering_rad: float) -> None:
    """Draw the wheel as seen along the shaft from above, forward up."""
    from matplotlib.patches import Circle

    cos, sin = np.cos(steering_rad), np.sin(steering_rad)
    turn = np.array([[cos, -sin], [sin, cos]])
    centre = np.zeros(2)
    ax.add_patch(Circle((0, 0), 0.62, facecolor="none", edgecolor="#C4C4C4", linewidth=7))
    _line(ax, turn @ [-0.62, 0], turn @ [0.62, 0], color="#C4C4C4", linewidth=7)
    _imu(ax, turn @ [0.36, 0.17], steering_rad, "T", 0.14)
    _label(ax, (0.42, 0.80), "lever IMU {T}", "T", ha="left")
    for frame, angle in (("N", 0.0), ("S", steering_rad)):
        for axis, direction in (("x", angle), ("y", angle + np.pi / 2)):
            tip = np.array([np.cos(direction), np.sin(direction)])
            _arrow(ax, centre, tip, FRAME_COLOURS[frame][0])
            _label(ax, 1.12 * tip, rf"${axis}_{frame}$", frame)
    ax.plot(0, 0, "o", color="black", markersize=5)
    ax.plot(0, 0, "o", color="black", markersize=11, mfc="none")
    _label(ax, (0.1, -0.16), r"$z_N = z_S$", "B", ha="left")
    start = np.pi / 2
    _arc(ax, centre, 0.8, start, start + steering_rad, r"$\theta_S$", "S", push=0.13, arrow=True)
    ax.set_title("Along the shaft, from above; left is positive")
    ax.set_xlim(-1.05, 1.55)
    ax.set_ylim(-0.72, 1.22)


def _draw_lever(ax: Axes, geometry: ScooterGeometry, throttle_rad: float) -> None:
    """Draw the lever from its right, wheel straight: what alpha, beta and throttle turn."""
    alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
    pushed = beta - throttle_rad
    hinge = np.zeros(2)
    _line(ax, hinge, (1.42, 0), color="black", linewidth=1, linestyle=":")
    ax.text(1.45, 0.0, r"$y_B$", va="center")
    for frame, label, angle in (
        ("S", r"$y_N, y_S$", alpha),
        ("W", r"$y_W$", beta),
        ("T", r"$y_T$", pushed),
    ):
        tip = 1.3 * np.array([np.cos(angle), np.sin(angle)])
        _arrow(ax, hinge, tip, FRAME_COLOURS[frame][0])
        _label(ax, 1.04 * tip, label, frame, ha="left")
    for frame, angle in (("W", beta), ("T", pushed)):
        tip = 0.8 * np.array([-np.sin(angle), np.cos(angle)])
        _arrow(ax, hinge, tip, FRAME_COLOURS[frame][0])
        _label(ax, 1.12 * tip, rf"$z_{frame}$", frame)
    _imu(ax, hinge, pushed, "T", 0.18)
    ax.plot(0, 0, "o", color="black", markersize=4, zorder=5)
    _arc(ax, hinge, 1.10, 0, alpha, r"$\alpha$", "S", push=-0.08, at=0.72)
    _arc(ax, hinge, 0.78, 0, beta, r"$\beta$", "W", push=-0.08)
    _arc(ax, hinge, 0.95, beta, pushed, r"$\theta_T$", "T", push=-0.1, at=0.75, arrow=True)
    upright = np.pi / 2
    _arc(ax, hinge, 0.58, upright + beta, upright + pushed, r"$\theta_T$", "T", 0.1, arrow=True)
    ax.set_title("At the lever, from the right; pushed is positive")
    ax.set_xlim(-0.45, 1.75)
    ax.set_ylim(-0.50, 1.0)


def _side_axes(ax: Axes, origin: Any, angle: float, frame: str, length: float) -> None:
    """Draw y and z of a frame seen from the right, and x as an arrow's point."""
    colour, _ = FRAME_COLOURS[frame]
    for axis, direction in (("y", angle), ("z", angle + np.pi / 2)):
        tip = np.add(origin, length * np.array([np.cos(direction), np.sin(direction)]))
        _arrow(ax, origin, tip, colour)
        _label(ax, np.add(tip, [0.05, 0.01]), rf"${axis}_{frame}$", frame)
    ax.plot(*origin, "o", color=colour, markersize=4, zorder=6)
    ax.plot(*origin, "o", color=colour, markersize=10, mfc="none", zorder=6)
    _label(ax, np.add(origin, [0.055, -0.06]), rf"$x_{frame}$", frame)


def _label(ax: Axes, place: Any, text: str, frame: str, ha: str = "center") -> None:
    x, y = place
    ax.text(x, y, text, color=FRAME_COLOURS[frame][1], ha=ha, va="center", bbox=PAPER, zorder=7)


def _line(ax: Axes, start: Any, end: Any, **look: Any) -> None:
    look = {"linestyle": "-", "linewidth": 1.2, "solid_capstyle": "round", "zorder": 1, **look}
    ax.plot(*np.transpose([start, end]), **look)


def _arrow(ax: Axes, start: Any, tip: Any, colour: str) -> None:
    look = {"arrowstyle": "-|>", "linewidth": 1.8, "color": colour, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", tip, start, arrowprops=look, zorder=5)


def _imu(ax: Axes, centre: Any, angle: float, frame: str, size: float) -> None:
    from matplotlib.patches import Rectangle

    ax.add_patch(
        Rectangle(
            (centre[0] - size / 2, centre[1] - size / 4),
            size,
            size / 2,
            angle=float(np.rad2deg(angle)),
            rotation_point="center",
            facecolor="white",
            edgecolor=FRAME_COLOURS[frame][0],
            linewidth=1.6,
            zorder=4,
        )
    )


def _arc(
    ax: Axes,
    centre: Any,
    radius: float,
    start: float,
    stop: float,
    label: str,
    frame: str,
    push: float = 0.0,
    *,
    at: float = 0.5,
    arrow: bool = False,
) -> None:
    """Draw an arc; its label lies ``push`` outside of it, at the fraction ``at`` of the way."""
    colour, _ = FRAME_COLOURS[frame]
    angle = np.linspace(start, stop, 40)
    points = np.asarray(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    ax.plot(*points.T, color=colour, linewidth=1.3, linestyle="-")
    if arrow:
        look = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", points[-1], points[-4], arrowprops=look)
    there = start + at * (stop - start)
    place = np.asarray(centre) + (radius + push) * np.array([np.cos(there), np.sin(there)])
    _label(ax, place, label, frame)
