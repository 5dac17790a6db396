"""Drawings for the walker's chapters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mobility_imu.frames import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH_M, LENGTH_M, HEIGHT_M = 0.60, 0.52, 0.85
# Oblique view: x forward goes right and up, y left goes up-left, z up.
VIEW = np.array([[0.92, -0.42, 0.0], [0.28, 0.32, 1.0]])


def draw_frames() -> Figure:
    """Draw a walking frame with its footprint, body frame and an IMU fixed somewhere on it."""
    from mobility_imu.plots.style import use_style

    with use_style():
        return _draw_frames()


def _draw_frames() -> Figure:
    import matplotlib.pyplot as plt

    from mobility_imu.plots.style import COLOURS

    figure, axes = plt.subplots(figsize=(6.4, 4.6))
    half = WIDTH_M / 2
    a, b, c, d = (
        np.array(p)
        for p in (
            (LENGTH_M, half, 0),
            (LENGTH_M, -half, 0),
            (0, -half, 0),
            (0, half, 0),
        )
    )
    footprint = np.array([a, b, c, d, a])
    axes.fill(*(VIEW @ footprint.T), color="0.93", zorder=0)
    axes.plot(*(VIEW @ footprint.T), color="0.55", linestyle="--", linewidth=1)
    lean = np.array([0.08, 0, 0])
    top = {
        name: np.array([p[0], p[1], HEIGHT_M]) + s * lean
        for name, p, s in (("A", a, -1), ("B", b, -1), ("C", c, 1), ("D", d, 1))
    }
    for name, foot in zip("ABCD", (a, b, c, d), strict=True):
        _line(axes, foot, top[name], color="0.35", linewidth=4)
    for one, other in (("D", "A"), ("A", "B"), ("B", "C")):
        _line(axes, top[one], top[other], color="0.35", linewidth=4)
    brace = [p + 0.45 * (top[n] - p) for n, p in zip("AB", (a, b), strict=True)]
    _line(axes, *brace, color="0.5", linewidth=3)
    for name, foot, shift in (
        ("A front left", a, (0.02, 0.03)),
        ("B front right", b, (0.03, -0.03)),
        ("C rear right", c, (0.03, -0.03)),
        ("D rear left", d, (-0.30, -0.05)),
    ):
        axes.annotate(name, VIEW @ foot + shift, fontsize=9, color="0.25")
    _axes3(axes, np.zeros(3), np.eye(3) * 0.25, "b", COLOURS)
    imu = a + 0.62 * (top["A"] - a)
    turn = np.array([[0.5, -0.6, 0.62], [0.7, 0.7, 0.1], [-0.5, 0.38, 0.78]]) * 0.2
    _axes3(axes, imu, turn, "I", COLOURS, dashed=True)
    axes.plot(*(VIEW @ imu), "s", color=COLOURS["vermilion"], markersize=9, zorder=6)
    axes.annotate("IMU", VIEW @ imu + (0.03, -0.07), color=COLOURS["vermilion"])
    _arrow(axes, np.zeros(3), imu, color=COLOURS["purple"], linestyle=":")
    axes.annotate("$T$", VIEW @ (imu * 0.55) + (0.02, -0.06), color=COLOURS["purple"], fontsize=13)
    axes.annotate("(forward)", VIEW @ np.array([0.35, 0, 0]) + (0.0, -0.02), fontsize=9)
    axes.set_aspect("equal")
    axes.set_xlim(-0.55, 1.15)
    axes.set_ylim(-0.18, 1.25)
    axes.set_axis_off()
    return figure


def _line(axes: Axes, start: FloatArray, end: FloatArray, **style: object) -> None:
    points = VIEW @ np.array([start, end]).T
    axes.plot(points[0], points[1], "-", solid_capstyle="round", **style)


def _arrow(axes: Axes, start: FloatArray, end: FloatArray, **style: object) -> None:
    axes.annotate(
        "",
        xy=tuple(VIEW @ end),
        xytext=tuple(VIEW @ start),
        arrowprops={"arrowstyle": "-|>", "linewidth": 2, **style},
    )


def _axes3(
    axes: Axes,
    origin: FloatArray,
    directions: FloatArray,
    frame: str,
    colours: dict[str, str],
    *,
    dashed: bool = False,
) -> None:
    for name, direction, colour in zip(
        "xyz", directions, ("vermilion", "green", "blue"), strict=True
    ):
        _arrow(
            axes,
            origin,
            origin + direction,
            color=colours[colour],
            linestyle="--" if dashed else "-",
        )
        axes.annotate(
            f"${name}_{frame}$",
            VIEW @ (origin + 1.18 * direction) - (0.02, 0.02),
            fontsize=12,
            color=colours[colour],
        )
