"""The two figures of the WheelMove-ID document (v0), drawn by ourselves.

We looked at the original Figure 1. The chronogram shows a series of ours, because the numbers of
the printed chronogram are not available.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray, as_series
from mobility_imu.plots.drawing import (
    BODY,
    GREY,
    SMALL_PT,
    WIDTH_IN,
    arc,
    arrow,
    blank,
    box,
    direction,
    label,
    line,
    point_out,
    shape,
)
from mobility_imu.plots.style import use_style
from mobility_imu.plots.wheelchair import TASK_COLOURS, TASK_HATCHES
from mobility_imu.runs import changes_of
from mobility_imu.wheelchair.codes import Task, as_codes
from mobility_imu.wheelchair.geometry import (
    DOCUMENT_TO_CHAIR,
    SAMPLE_CHAIR,
    SIDES,
    Side,
    WheelchairGeometry,
    side_sign,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WHEEL, SENSOR, YAW = "#00537F", "#A34700", "#006B4E"
# Screen right and up in the chair frame: x forward, y left, z up.
FROM_BEHIND = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
FROM_THE_FRONT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
SENSOR_TURN_RAD = float(np.deg2rad(9))
"""How far the wheel's IMU is drawn turned from the wheel; in the original it is about so."""


def document_wheel_axes(geometry: WheelchairGeometry, side: Side) -> FloatArray:
    """Axes of a wheel as the document's Figure 1 draws them, in the chair frame.

    Z lies along the axle and points away from the chair, Y along the wheel's plane and up. The
    figure shows the axes of the right wheel only; that the left wheel's Z points outward too is
    the reading in which (1.17) is right.

    Parameters
    ----------
    geometry : WheelchairGeometry
    side : "left" or "right"

    Returns
    -------
    (3, 3) array, columns X, Y, Z
    """
    outward = side_sign(side) * geometry.axle_direction(side)
    contact = np.array([0.0, side_sign(side) * geometry.track_m / 2, 0.0])
    up = (geometry.wheel_centre(side) - contact) / geometry.wheel_radius_m.of(side)
    return np.column_stack([np.cross(up, outward), up, outward])


def draw_document_frames(geometry: WheelchairGeometry | None = None) -> Figure:
    """Draw the document's Figure 1 as printed, and below it the same views with our frames.

    Parameters
    ----------
    geometry : WheelchairGeometry to draw to scale; if None the chair of WheelMove-ID's sample, with
        equal wheels

    Returns
    -------
    Figure with four panels: right wheel from the front and chair from behind, printed and ours
    """
    import matplotlib.pyplot as plt

    if geometry is None:
        geometry = replace(SAMPLE_CHAIR, wheel_radius_left_m=0.317, wheel_radius_right_m=0.317)
    with use_style():
        figure, axes = plt.subplots(2, 2, figsize=(WIDTH_IN, 6.9), width_ratios=[1, 1.4])
        for row, printed in enumerate((True, False)):
            _draw_wheel(axes[row, 0], geometry, printed=printed)
            _draw_chair(axes[row, 1], geometry, printed=printed)
            axes[row, 0].set_title("In the document" if printed else "In this book")
        figure.supxlabel(
            "x = X,   y = −Z,   z = Y\n(small: this book; capitals: the document)",
            fontsize=SMALL_PT,
        )
    return figure


def _draw_wheel(ax: Axes, geometry: WheelchairGeometry, *, printed: bool) -> None:
    """Draw the right wheel edge-on from the front; its top leans in, to the screen's right."""
    side: Side = "right"
    axes = document_wheel_axes(geometry, side)
    flat = FROM_THE_FRONT
    radius = geometry.wheel_radius_m.right
    up, outward = flat @ axes[:, 1], flat @ axes[:, 2]
    contact = -radius * up
    _edge_on(ax, contact, up, outward, radius)
    line(ax, [(-0.40, contact[1]), (0.34, contact[1])], color=GREY, linewidth=1.5)
    if printed:
        _spin(ax, 0.2 * outward, up, outward, WHEEL)
        arrow(ax, (0, 0), 0.38 * outward, WHEEL, gid="printed wheel Z")
        arrow(ax, (0, 0), 0.42 * up, WHEEL, gid="printed wheel Y")
        label(ax, 0.34 * outward + [-0.02, 0.09], "$Z_{wheel}$", WHEEL)
        label(ax, 0.42 * up + [-0.02, 0.06], "$Y_{wheel}$", WHEEL)
        label(ax, 0.2 * outward + [0.06, 0.16], r"$\dot\beta$", WHEEL)
        _draw_sensor(ax, -0.05 * outward - 0.14 * up, up, outward)
    else:
        axle = flat @ geometry.axle_direction(side)
        _spin(ax, 0.17 * axle, -up, axle, WHEEL)
        arrow(ax, (0, 0), 0.33 * axle, WHEEL, gid="our axle")
        label(ax, 0.30 * axle + [-0.01, -0.10], "axle", WHEEL)
        label(ax, 0.17 * axle + [0.04, 0.17], r"$\dot\beta$", WHEEL)
    words = "right wheel,\nfrom the front"
    ax.text(-0.03, -0.46, words, ha="center", fontsize=SMALL_PT, va="center")
    blank(ax, (-0.42, 0.38), (-0.58, 0.52))


def _draw_sensor(ax: Axes, place: FloatArray, up: FloatArray, outward: FloatArray) -> None:
    """Draw the wheel's IMU on the inner side, its Y and Z nearly along the wheel's."""
    cos, sin = np.cos(SENSOR_TURN_RAD), np.sin(SENSOR_TURN_RAD)
    turn = np.array([[cos, -sin], [sin, cos]])
    y_axis, z_axis = turn @ up, turn @ outward
    box(ax, place, (0.09, 0.04), np.arctan2(y_axis[1], y_axis[0]), edgecolor=SENSOR)
    for axis, name in ((y_axis, "Y"), (z_axis, "Z")):
        arrow(ax, place, place + 0.2 * axis, SENSOR, linestyle="--", gid=f"printed sensor {name}")
    label(ax, place + 0.2 * y_axis + [0.14, 0.0], "$Y_{IMU}$", SENSOR)
    label(ax, place + 0.2 * z_axis + [-0.07, -0.06], "$Z_{IMU}$", SENSOR)


def _draw_chair(ax: Axes, geometry: WheelchairGeometry, *, printed: bool) -> None:
    """Draw the chair from behind with the printed frame or with ours."""
    half = geometry.track_m / 2
    line(ax, [(-half - 0.16, 0), (half + 0.16, 0)], color=GREY, linewidth=1.5)
    shape(ax, [(-0.21, 0.37), (0.21, 0.37), (0.21, 0.42), (-0.21, 0.42)])
    shape(ax, [(-0.20, 0.45), (-0.18, 0.86), (0.18, 0.86), (0.20, 0.45)], zorder=0)
    centres = {side: FROM_BEHIND @ geometry.wheel_centre(side) for side in SIDES}
    line(ax, list(centres.values()), color="#9A9A9A", linewidth=4, zorder=1)
    for side in SIDES:
        axes = document_wheel_axes(geometry, side)
        up, outward = FROM_BEHIND @ axes[:, 1], FROM_BEHIND @ axes[:, 2]
        radius = geometry.wheel_radius_m.of(side)
        contact = centres[side] - radius * up
        _edge_on(ax, contact, up, outward, radius)
        inner = centres[side] - 0.045 * outward + 0.1 * up
        box(ax, inner, (0.08, 0.035), np.arctan2(up[1], up[0]), edgecolor=SENSOR)
        if printed and side == "left":
            shift = 0.11 * outward
            arrow(ax, centres[side] + shift, contact + shift, GREY, head="<|-|>", linewidth=1.0)
            label(ax, (centres[side] + contact) / 2 + shift, "$r$")
        elif not printed:
            axle = FROM_BEHIND @ geometry.axle_direction(side)
            arrow(ax, centres[side], centres[side] + 0.22 * axle, WHEEL, gid=f"our axle {side}")
            if side == "left":
                label(ax, centres[side] + 0.24 * axle + [0, 0.06], "axles", WHEEL)
    contact, reach = np.array([half, 0.0]), 2.15 * geometry.wheel_radius_m.right
    line(ax, [contact, np.add(contact, [0, reach])], color=GREY, linestyle=":", gid="vertical")
    lean = geometry.camber_rad
    arc(ax, contact, 0.9 * reach, np.pi / 2, np.pi / 2 + lean)
    label(ax, contact + reach * direction(np.pi / 2 + lean / 2), r"$\alpha$")
    _draw_axes(ax, printed=printed)
    ax.text(0, -0.19, "chair, from behind", ha="center", fontsize=SMALL_PT, va="center")
    blank(ax, (-half - 0.17, half + 0.17), (-0.26, 0.95))


def _draw_axes(ax: Axes, *, printed: bool) -> None:
    """Draw the chair's frame on the floor midway between the wheels, and its yaw arrow."""
    origin = np.zeros(2)
    columns = DOCUMENT_TO_CHAIR if printed else np.eye(3)
    names = "XYZ" if printed else "xyz"
    for name, axis in zip(names, columns.T, strict=True):
        flat = FROM_BEHIND @ axis
        if not flat.any():
            point_out(ax, origin, "black", into=bool(axis[0] > 0))
            label(ax, np.add(origin, [0.0, -0.075]), f"${name}$ forward", fontsize=SMALL_PT)
            continue
        arrow(ax, origin, 0.26 * flat, "black", gid=f"{'printed' if printed else 'our'} {name}")
        label(ax, 0.26 * flat + ([0.05, 0.0] if flat[1] else [0.0, 0.06]), f"${name}$")
    # Seen from a little above, a counter-clockwise arrow runs to the right in front.
    arc(ax, (0, 0.15), (0.085, 0.028), -3.6, 1.2, colour=YAW, arrowhead=True)
    label(ax, (-0.15, 0.16), r"$\dot\theta$", YAW)


def _edge_on(
    ax: Axes, contact: FloatArray, up: FloatArray, outward: FloatArray, radius: float
) -> None:
    thick = 0.018 * outward
    top = contact + 2 * radius * up
    look = {"facecolor": "#D9D9D9", "edgecolor": "#8A8A8A", "zorder": 2}
    shape(ax, [contact - thick, contact + thick, top + thick, top - thick], **{**BODY, **look})
    ax.plot(*(contact + radius * up), "o", color="#777777", markersize=5, zorder=4)


def _spin(ax: Axes, centre: FloatArray, toward: FloatArray, axis: FloatArray, colour: str) -> None:
    """Draw a turn about an axis that lies in the page; the near half runs to ``toward``."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 40)
    for side, look in ((1, "-"), (-1, ":")):
        curve = (
            centre
            + np.outer(0.1 * np.sin(angles), toward)
            + side * np.outer(0.035 * np.cos(angles), axis)
        )
        line(ax, curve, color=colour, linestyle=look, linewidth=1.5, zorder=7)
        if side > 0:
            arrow(ax, curve[-6], curve[-1], colour, linewidth=0.1)


def plot_document_chronogram(codes: ArrayLike, linear_velocity_mps: ArrayLike) -> Figure:
    """Plot velocity over frames on coloured tasks, with the axes of the document's chronogram.

    Parameters
    ----------
    codes : (n,) array of task codes, 1 to 6
    linear_velocity_mps : (n,) array, m/s, forward positive

    Returns
    -------
    Figure; velocity from -1 to 3.5 m/s over frames, the legend of the six tasks below

    Raises
    ------
    InputError
        If the series differ in length, or a code is no task.
    """
    import matplotlib.pyplot as plt
    from matplotlib.patches import Patch

    velocity = as_series(linear_velocity_mps, "linear_velocity_mps")
    task = as_codes(codes, length=len(velocity))
    edges = [*changes_of(task), len(task)]
    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 4.4))
        for first, stop in pairwise(edges):
            code = Task(task[first])
            look = {"facecolor": TASK_COLOURS[code], "edgecolor": "white", "linewidth": 0}
            ax.axvspan(first, stop, alpha=0.55, hatch=TASK_HATCHES[code], gid=code.name, **look)
        ax.axhline(0, color="black", linewidth=0.8, linestyle="-")
        ax.plot(velocity, color="black", linestyle="-", linewidth=2.0)
        ax.set(xlim=(0, len(task)), ylim=(-1.2, 3.7), xlabel="frame", ylabel="linear velocity, m/s")
        ax.set_yticks(np.arange(-1, 4))
        ax.tick_params(labelsize=SMALL_PT)
        ax.xaxis.label.set_size(SMALL_PT)
        ax.yaxis.label.set_size(SMALL_PT)
        ax.grid(visible=False)
        handles = [
            Patch(
                facecolor=TASK_COLOURS[code],
                edgecolor="white",
                hatch=TASK_HATCHES[code],
                alpha=0.55,
                label=code.title,
            )
            for code in Task
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=SMALL_PT)
    return figure
