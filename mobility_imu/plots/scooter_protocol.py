"""Drawings for the protocol that judges a scooter's angles: the two scales, and what came out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mobility_imu.plots.drawing import (
    GREY,
    SMALL_PT,
    WIDTH_IN,
    arc,
    arrow,
    blank,
    box,
    direction,
    disc,
    label,
    line,
)
from mobility_imu.plots.style import COLOURS, use_style
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.pose_check import QUANTILE_95, PoseCheck

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEER, PUSH = COLOURS["vermilion"], COLOURS["blue"]
LARGEST_MARK_DEG, LARGEST_PUSH_DEG = 60, 40
"""Ends of the two scales."""
SPREAD_DEG = 1.2
"""Poses with the same set angle stand beside each other, by so much."""


def draw_scales(geometry: ScooterGeometry, *, steering_rad: float, throttle_rad: float) -> Figure:
    """Draw the scale on the shaft, the scale at the lever, and where the two IMUs sit.

    Parameters
    ----------
    geometry : ScooterGeometry
    steering_rad : rad, shown on the left, positive to the left
    throttle_rad : rad, shown on the right, positive pushed

    Returns
    -------
    Figure with two panels
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, (shaft, lever) = plt.subplots(1, 2, figsize=(WIDTH_IN, 3.9))
        _draw_shaft_scale(shaft, steering_rad)
        _draw_lever_scale(lever, geometry, throttle_rad)
        shaft.set_title("(1) Along the shaft, from above")
        lever.set_title("(2) Lever, from the right")
    return figure


def _draw_shaft_scale(ax: Axes, steering_rad: float) -> None:
    """Draw a paper scale that stays with the body, and the wheel with its pointer above it."""
    disc(ax, (0, 0), 1.0, facecolor="#F4F4F4", edgecolor=GREY, zorder=1)
    ahead = np.pi / 2
    for mark in range(-LARGEST_MARK_DEG, LARGEST_MARK_DEG + 1, 10):
        at = direction(ahead + np.deg2rad(mark))
        long = mark % 20 == 0
        line(ax, [(0.86 if long else 0.92) * at, at], color="black", linewidth=1)
        if long:
            label(ax, 1.13 * at, f"{mark:d}°", fontsize=SMALL_PT, bbox=None)
    turned = direction(ahead + steering_rad)
    right = direction(steering_rad)
    line(ax, [-0.62 * right, 0.62 * right], color="#9A9A9A", linewidth=8, zorder=3)
    arrow(ax, (0, 0), 0.84 * turned, STEER, gid="pointer")
    box(ax, 0.47 * right, (0.26, 0.15), steering_rad, edgecolor=PUSH, zorder=6)
    arc(ax, (0, 0), 0.66, ahead, ahead + steering_rad, colour=STEER, arrowhead=True, gid="steering")
    label(ax, 0.55 * direction(ahead + steering_rad / 2), r"$\theta_S$", STEER)
    for place, text, target in (
        ((0.62, -0.62), "lever IMU", 0.47 * right + np.array([0.02, -0.08])),
        ((-0.25, -1.3), "paper scale, fixed to the body,\ncentre on the shaft", (-0.35, -0.8)),
    ):
        line(ax, np.array([place, target]), color=GREY, linewidth=0.9, zorder=7)
        label(ax, place, text, fontsize=SMALL_PT)
    blank(ax, (-1.3, 1.3), (-1.55, 1.3))


def _draw_lever_scale(ax: Axes, geometry: ScooterGeometry, throttle_rad: float) -> None:
    """Draw the lever at rest and pushed before a scale about its axis."""
    rest = np.pi / 2 + geometry.lever_inclination_rad
    disc(ax, (0, 0), 0.07, facecolor="white", edgecolor="black", zorder=6)
    for mark in range(0, LARGEST_PUSH_DEG + 1, 10):
        at = direction(rest - np.deg2rad(mark))
        line(ax, [1.08 * at, 1.2 * at], color="black", linewidth=1)
        if mark % 20 == 0:
            label(ax, 1.32 * at, f"{mark:d}°", fontsize=SMALL_PT, bbox=None)
    whole = np.deg2rad(LARGEST_PUSH_DEG)
    arc(ax, (0, 0), 1.08, rest - whole, rest, colour=GREY, gid="throttle scale")
    for name, turn, look in (("at rest", 0.0, ":"), ("pushed", throttle_rad, "-")):
        up = direction(rest - turn)
        width = 2 if look == ":" else 5
        line(
            ax, [np.zeros(2), 1.02 * up], color="#777777", linewidth=width, linestyle=look, gid=name
        )
    up = direction(rest - throttle_rad)
    box(ax, 0.62 * up, (0.30, 0.16), rest - throttle_rad - np.pi / 2, edgecolor=PUSH, zorder=6)
    arc(ax, (0, 0), 0.9, rest, rest - throttle_rad, colour=PUSH, arrowhead=True, gid="throttle")
    label(ax, 0.78 * direction(rest - 0.42 * throttle_rad), r"$\theta_T$", PUSH)
    label(ax, (0.95, 0.2), "lever IMU", fontsize=SMALL_PT)
    line(ax, np.array([(0.8, 0.3), 0.62 * up]), color=GREY, linewidth=0.9)
    label(ax, (-0.52, 0.62), "lever\nat rest", GREY, fontsize=SMALL_PT)
    arrow(ax, (-0.2, -0.25), (0.6, -0.25), GREY)
    label(ax, (0.2, -0.42), "forward", GREY, fontsize=SMALL_PT)
    label(
        ax,
        (0.2, -0.72),
        "body IMU: on the floor or in\nthe basket, fixed to the body",
        fontsize=SMALL_PT,
    )
    blank(ax, (-1.05, 1.45), (-1.25, 1.5))


def plot_pose_check(check: PoseCheck) -> Figure:
    """Plot found minus set angles with their 95 % intervals, one panel for each control.

    Parameters
    ----------
    check : PoseCheck

    Returns
    -------
    Figure, deg
    """
    import matplotlib.pyplot as plt

    table = check.to_frame()
    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(WIDTH_IN, 3.6), layout="constrained")
        for ax, (control, colour) in zip(
            axes, {"steering": "vermilion", "throttle": "blue"}.items(), strict=True
        ):
            rows = table[(table["control"] == control) & (table["judged"] == 1)]
            for name, marker, part in (
                ("inside", "o", rows[rows["inside_95"] == 1]),
                ("outside", "X", rows[rows["inside_95"] == 0]),
            ):
                order = part.groupby("set_deg").cumcount()
                ax.errorbar(
                    part["set_deg"] + SPREAD_DEG * order,
                    part["difference_deg"],
                    QUANTILE_95 * part["sd_deg"],
                    fmt=marker,
                    linestyle="none",
                    color=COLOURS[colour],
                    elinewidth=1,
                    label=f"{name} ({len(part)})",
                )
            ax.axhline(0, color="black", linewidth=1)
            ax.set(xlabel=f"{control} as set (deg)", ylabel="found minus set (deg)")
            ax.legend(title="95 % interval", loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure
