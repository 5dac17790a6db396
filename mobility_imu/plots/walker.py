"""Drawings for the walker's chapters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.walker.geometry import FOOTPRINT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH_M, LENGTH_M = FOOTPRINT.footprint_width_m, FOOTPRINT.footprint_length_m
HEIGHT_M = 0.85
# Oblique view: x forward goes right and up, y left goes up-left, z up.
VIEW = np.array([[0.92, -0.42, 0.0], [0.28, 0.32, 1.0]])


def draw_frames() -> Figure:
    """Draw a walking frame with its footprint, the body, IMU and world frames.

    The world frame is drawn beside the walker, so that it can be seen; the paper puts its origin
    where the IMU starts. Its axes are dotted, the IMU's dashed, the body's solid.
    """
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
    brace = [p + 0.3 * (top[n] - p) for n, p in zip("AB", (a, b), strict=True)]
    _line(axes, *brace, color="0.5", linewidth=3)
    for name, foot, shift in (
        ("A front\nleft", a, (0.02, 0.0)),
        ("B front right", b, (0.03, -0.03)),
        ("C rear right", c, (0.03, -0.03)),
        ("D rear left", d, (-0.30, -0.05)),
    ):
        axes.annotate(name, VIEW @ foot + shift, fontsize=9, color="0.25")
    _axes3(axes, np.zeros(3), np.eye(3) * 0.18, "b", COLOURS)
    beside, turned = np.array([0.62, -0.85, 0.0]), np.deg2rad(35)
    world = np.array(
        [[np.cos(turned), np.sin(turned), 0], [-np.sin(turned), np.cos(turned), 0], [0, 0, 1]]
    )
    _axes3(axes, beside, world * 0.22, "w", COLOURS, line=":")
    axes.annotate("world", VIEW @ beside + (-0.02, -0.08), fontsize=9, color="0.25", ha="center")
    imu = a + 0.5 * (top["A"] - a)
    turn = np.array([[0.5, -0.6, 0.62], [0.7, 0.7, 0.1], [-0.5, 0.38, 0.78]]) * 0.2
    _axes3(axes, imu, turn, "I", COLOURS, line="--")
    axes.plot(*(VIEW @ imu), "s", color=COLOURS["vermilion"], markersize=9, zorder=6)
    axes.annotate("IMU", VIEW @ imu + (0.03, -0.07), color=COLOURS["vermilion"])
    _arrow(axes, np.zeros(3), imu, color=COLOURS["purple"], linestyle=":")
    axes.annotate("$T$", VIEW @ (imu * 0.55) + (0.02, -0.06), color=COLOURS["purple"], fontsize=13)
    axes.annotate("(forward)", VIEW @ np.array([0.28, 0, 0]) + (0.0, -0.02), fontsize=9)
    axes.set_aspect("equal")
    axes.set_xlim(-0.55, 1.30)
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
    line: str = "-",
) -> None:
    for name, direction, colour in zip(
        "xyz", directions, ("vermilion", "green", "blue"), strict=True
    ):
        _arrow(
            axes,
            origin,
            origin + direction,
            color=colours[colour],
            linestyle=line,
        )
        axes.annotate(
            f"${name}_{frame}$",
            VIEW @ (origin + 1.18 * direction) - (0.02, 0.02),
            fontsize=12,
            color=colours[colour],
        )


def plot_pose_errors(error_m: FloatArray, *, path_m: float) -> Figure:
    """Plot the signed error of every run of Table 2 by pose, with each pose's mean.

    Parameters
    ----------
    error_m : (poses, runs) array, m, estimated minus true distance
    path_m : m, true distance, for the axis in percent on the right
    """
    import matplotlib.pyplot as plt

    from mobility_imu.plots.style import COLOURS, use_style

    with use_style():
        figure, axes = plt.subplots(figsize=(7.2, 3.6))
        axes.axhline(0, color="black", linewidth=0.8, linestyle="-")
        for place, errors in enumerate(error_m, start=1):
            spread = place + np.linspace(-0.18, 0.18, len(errors))
            axes.plot(
                spread,
                errors,
                "o",
                color=COLOURS["blue"],
                mfc="none",
                label="one run" if place == 1 else None,
            )
            axes.plot(
                [place - 0.3, place + 0.3],
                [errors.mean()] * 2,
                color=COLOURS["vermilion"],
                linestyle="-",
                linewidth=2.4,
                label="mean of the pose" if place == 1 else None,
            )
        axes.set_xticks(range(1, len(error_m) + 1))
        axes.set_xlabel("pose of the IMU")
        axes.set_ylabel("estimated − true distance, m")
        axes.grid(visible=False, axis="x")
        percent = axes.secondary_yaxis(
            "right", functions=(lambda m: 100 * m / path_m, lambda p: p * path_m / 100)
        )
        percent.set_ylabel("% of the path")
        axes.legend(loc="upper right")
    return figure


def plot_positions(first_m: FloatArray, second_m: FloatArray) -> Figure:
    """Plot the positions of Table 1 by both methods, seen from above and from the right.

    Parameters
    ----------
    first_m, second_m : (poses, 3) arrays, m, body frame
    """
    import matplotlib.pyplot as plt

    from mobility_imu.plots.style import COLOURS, use_style

    half = WIDTH_M / 2
    with use_style():
        figure, (above, side) = plt.subplots(1, 2, figsize=(8.6, 4.2))
        corners = np.array(
            [(0, half), (LENGTH_M, half), (LENGTH_M, -half), (0, -half), (0, half)], float
        )
        above.plot(-corners[:, 1], corners[:, 0], color="0.6", linestyle="--", linewidth=1)
        for y, x, name in zip((half, -half, -half, half), (1, 1, 0, 0), "ABCD", strict=True):
            above.annotate(name, (-y, x * LENGTH_M), xytext=(3, 3), textcoords="offset points")
        side.plot([0, LENGTH_M], [0, 0], color="0.6", linestyle="--", linewidth=1)
        for axes, one, other, sign in ((above, 1, 0, -1), (side, 0, 2, 1)):
            for k, (first, second) in enumerate(zip(first_m, second_m, strict=True), start=1):
                across = sign * np.array([first[one], second[one]])
                along = np.array([first[other], second[other]])
                axes.plot(across, along, color="0.5", linestyle="-", linewidth=1)
                axes.plot(
                    across[0],
                    along[0],
                    "o",
                    color=COLOURS["blue"],
                    label="first method, four tilts" if k == 1 else None,
                )
                axes.plot(
                    across[1],
                    along[1],
                    "s",
                    color=COLOURS["vermilion"],
                    mfc="white",
                    label="second method, two tilts" if k == 1 else None,
                )
                axes.annotate(
                    str(k),
                    (across[0], along[0]),
                    xytext=(5, 4),
                    textcoords="offset points",
                    weight="bold",
                )
            axes.set_aspect("equal")
        above.set_title("from above")
        above.set_xlabel("−y, m (to the right)")
        above.set_ylabel("x, m (forward)")
        side.set_title("from the right")
        side.set_xlabel("x, m (forward)")
        side.set_ylabel("z, m (up)")
        handles, labels = above.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def plot_lever_arm(
    apart_m: FloatArray, arm_m: FloatArray, heading_rad: FloatArray, poses: Sequence[str]
) -> Figure:
    """Plot what separates Tables 3 and 4 in each run against the lever arms of Table 1.

    Parameters
    ----------
    apart_m : (poses, runs, 2) array, m, closing errors of Table 3 minus those of Table 4
    arm_m : (poses, 2) array, m, horizontal part of T1 - T2
    heading_rad : (poses, runs) array, rad, implied heading at the end
    poses : names
    """
    import matplotlib.pyplot as plt

    from mobility_imu.plots.style import cue, use_style

    with use_style():
        figure, (plane, turns) = plt.subplots(1, 2, figsize=(8.8, 4.4), width_ratios=(1, 0.9))
        angle = np.linspace(0, 2 * np.pi, 200)
        for k, name in enumerate(poses):
            look = cue(k)
            radius = np.hypot(*arm_m[k])
            plane.plot(
                radius * np.cos(angle),
                radius * np.sin(angle),
                color=look["color"],
                linestyle=look["linestyle"],
                linewidth=1,
            )
            dots = {"color": look["color"], "marker": look["marker"], "linestyle": "none"}
            plane.plot(apart_m[k, :, 0], apart_m[k, :, 1], label=f"pose {name}", **dots)
            place = k + 1 + np.linspace(-0.2, 0.2, heading_rad.shape[1])
            turns.plot(place, np.rad2deg(heading_rad[k]), **dots)
        plane.plot(0, 0, "P", color="black", markersize=10, mec="white")
        plane.annotate(
            "(27): all here", (0, 0), xytext=(0, -16), textcoords="offset points", ha="center"
        )
        plane.set_aspect("equal")
        plane.set_xlabel("x of Table 3 − x of Table 4, m")
        plane.set_ylabel("y of Table 3 − y of Table 4, m")
        plane.set_title("difference of the closing errors")
        turns.axhline(-90, color="0.4", linestyle="--", linewidth=1)
        turns.axhline(0, color="0.4", linestyle="-", linewidth=1)
        turns.annotate("closed: as at the start", (5.4, 0), xytext=(0, 4), ha="right", **_OFFSET)
        turns.annotate("last corner not turned", (1.6, -90), xytext=(0, 26), ha="left", **_OFFSET)
        turns.set_ylim(-130, 25)
        turns.set_yticks([-120, -90, -60, -30, 0])
        turns.set_xticks(range(1, len(poses) + 1))
        turns.set_xlabel("pose of the IMU")
        turns.set_ylabel("implied final heading, deg (left positive)")
        turns.set_title("heading, if only the end was corrected")
        turns.grid(visible=False, axis="x")
        handles, labels = plane.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(poses))
    return figure


_OFFSET = {"textcoords": "offset points", "fontsize": 9}
