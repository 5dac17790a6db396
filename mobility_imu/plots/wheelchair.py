"""Figures of the manual chair: its frames and lengths, and the chronogram of its tasks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray, as_clock, as_flags, as_series
from mobility_imu.plots.drawing import BODY, arc, arrow, box, dimension, label, line
from mobility_imu.plots.style import COLOURS, HATCHES, use_style
from mobility_imu.runs import changes_of, runs_of
from mobility_imu.wheelchair.codes import Codes, Task, as_codes
from mobility_imu.wheelchair.geometry import (
    SAMPLE_CHAIR,
    SIDES,
    Side,
    WheelchairGeometry,
    side_sign,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TASK_COLOURS = {
    Task.STATIC: COLOURS["grey"],
    Task.FORWARD: COLOURS["green"],
    Task.BACKWARD: COLOURS["orange"],
    Task.PIVOT: COLOURS["purple"],
    Task.TIGHT: COLOURS["vermilion"],
    Task.WIDE: COLOURS["blue"],
}
TASK_HATCHES = dict(zip(Task, HATCHES, strict=True))
# More points than this are drawn as the smallest and largest of each of that many intervals.
LONGEST_LINE = 8000
SIDE_COLOURS = {"left": "#A34700", "right": "#00537F"}
YAW = "#006B4E"
SENSOR = (0.07, 0.04)
"""Size of a sensor as it is drawn, m."""
TURN_RAD = (np.deg2rad(200), np.deg2rad(500))
"""Where the round arrow about the vertical starts and stops, seen from behind."""


def chronogram(
    time_s: ArrayLike,
    codes: ArrayLike,
    linear_velocity_mps: ArrayLike | None = None,
    yaw_rate_radps: ArrayLike | None = None,
    *,
    valid: ArrayLike | None = None,
) -> Figure:
    """Draw at which times each task was done: one band per task, and velocities above if given.

    Parameters
    ----------
    time_s : (n,) array, s, increasing
    codes : (n,) array of task codes, 1 to 6
    linear_velocity_mps : (n,) array, m/s, forward positive
    yaw_rate_radps : (n,) array, rad/s, left positive; drawn in deg/s
    valid : (n,) array of truth values, whether a frame's task is known; where not, all is covered

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the series differ in length, times do not increase, or a code is no task.
    """
    import matplotlib.pyplot as plt

    time = as_clock(time_s)
    task = as_codes(codes, length=len(time))
    curves = []
    if linear_velocity_mps is not None:
        velocity = as_series(linear_velocity_mps, "linear_velocity_mps", length=len(time))
        curves.append(("velocity\nm/s", velocity))
    if yaw_rate_radps is not None:
        yaw_rate = as_series(yaw_rate_radps, "yaw_rate_radps", length=len(time))
        curves.append(("yaw rate\ndeg/s", np.rad2deg(yaw_rate)))

    spans = _spans(time, task)
    with use_style():
        figure, column = plt.subplots(
            len(curves) + 1,
            1,
            figsize=(9.0, 2.5 + 1.5 * len(curves)),
            sharex=True,
            squeeze=False,
            height_ratios=[1.0] * len(curves) + [1.6],
        )
        *panels, bands = column[:, 0]
        for ax, (name, values) in zip(panels, curves, strict=True):
            _draw_curve(ax, time, values, spans)
            ax.set_ylabel(name)
        duration = float(time[-1] - time[0])
        _draw_bands(bands, spans, duration)
        bands.set_xlim(time[0], time[-1])
        known = np.ones(len(time), np.bool_)
        if valid is not None:
            known = as_flags(valid, "valid", length=len(time))
        for run in runs_of(~known):
            for ax in column[:, 0]:
                ax.axvspan(
                    time[run.start], time[run.stop - 1], zorder=3, hatch="xx",
                    facecolor="white", edgecolor=COLOURS["grey"], alpha=0.85, linewidth=0,
                )  # fmt: skip
        share = bands.secondary_yaxis("right")
        share.set_yticks(
            list(Task), [f"{100 * ((task == code) & known).mean():.0f} %" for code in Task]
        )
        share.tick_params(length=0)
        share.set_ylabel("fraction of time")
        share.spines["right"].set_visible(False)
        _clock_axis(bands, duration)
        if not known.all():
            bands.set_xlabel(f"{bands.get_xlabel()} (crossed out: not known)")
        figure.align_ylabels(panels)
    return figure


Spans = dict[Task, list[tuple[float, float]]]


def _draw_curve(ax: Axes, time_s: FloatArray, values: FloatArray, spans: Spans) -> None:
    """Draw one velocity over the tasks' colours."""
    for code, pieces in spans.items():
        ax.broken_barh(
            pieces,
            (0, 1),
            transform=ax.get_xaxis_transform(),
            facecolor=TASK_COLOURS[code],
            alpha=0.22,
            linewidth=0,
        )
    width = 1.1 if time_s[-1] - time_s[0] <= 180 else 0.5
    ax.axhline(0, color="#888888", linewidth=0.8, linestyle="-")
    ax.plot(*_thinned(time_s, values), color="black", linestyle="-", linewidth=width)
    ax.grid(visible=False)


def _draw_bands(ax: Axes, spans: Spans, duration_s: float) -> None:
    """Draw one band per task, a bar for each of its runs."""
    for code, pieces in spans.items():
        ax.broken_barh(
            pieces,
            (code - 0.4, 0.8),
            facecolor=TASK_COLOURS[code],
            # A fine edge in its own colour keeps the shortest task visible.
            edgecolor=TASK_COLOURS[code],
            linewidth=0.6,
        )
        ax.broken_barh(
            # In a sliver a hatch only washes out the colour.
            [piece for piece in pieces if piece[1] > 0.012 * duration_s],
            (code - 0.4, 0.8),
            facecolor="none",
            edgecolor="white",
            linewidth=0,
            hatch=TASK_HATCHES[code],
        )
    ax.set_ylim(6.6, 0.4)
    ax.set_yticks(list(Task), [code.title for code in Task])
    ax.tick_params(axis="y", length=0)


def _spans(time_s: FloatArray, task: Codes) -> Spans:
    """Start and duration of every run of each task, s."""
    starts = changes_of(task)
    ends = np.r_[time_s[starts[1:]], 2 * time_s[-1] - time_s[-2]]
    spans: Spans = {}
    for first, end in zip(starts, ends, strict=True):
        begin = float(time_s[first])
        spans.setdefault(Task(int(task[first])), []).append((begin, float(end) - begin))
    return spans


def _thinned(time_s: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Leave out points that a page cannot show; each interval keeps its extreme values."""
    if len(values) <= LONGEST_LINE:
        return time_s, values
    edges = np.linspace(0, len(values), LONGEST_LINE // 2 + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    return np.repeat(time_s[edges], 2), np.column_stack([low, high]).ravel()


def _clock_axis(ax: Axes, duration_s: float) -> None:
    """Seconds for short recordings, minutes and seconds for long ones."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    if duration_s <= 180:
        ax.set_xlabel("time, s")
        return
    steps = (15, 30, 60, 120, 300, 600, 1200, 3600)
    step = next((s for s in steps if duration_s / s <= 12), 7200)
    ax.xaxis.set_major_locator(MultipleLocator(step))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda t, _: f"{t // 60:.0f}:{t % 60:02.0f}"))
    ax.set_xlabel("time, min:s")


def draw_frames(geometry: WheelchairGeometry | None = None) -> Figure:
    """Draw the chair from behind and from above, with its frame, axles, lengths and angles.

    Parameters
    ----------
    geometry : WheelchairGeometry to draw to scale; the chair of WheelMove-ID's sample if None

    Returns
    -------
    Figure with two panels, lengths to scale
    """
    import matplotlib.pyplot as plt

    if geometry is None:
        geometry = SAMPLE_CHAIR
    with use_style():
        figure, (rear, top) = plt.subplots(1, 2, figsize=(9.8, 4.8), width_ratios=[1.22, 1])
        _draw_rear(rear, geometry)
        _draw_top(top, geometry)
        for ax in (rear, top):
            ax.set_aspect("equal", anchor="N")
            ax.axis("off")
    return figure


def _draw_rear(ax: Axes, geometry: WheelchairGeometry) -> None:
    """Draw the view from behind: screen right is -y, screen up is z."""
    from matplotlib.patches import Polygon, Rectangle

    ax.set_title("From behind: y left, z up, x into the page")
    half = geometry.track_m / 2
    ax.plot([-half - 0.32, half + 0.32], [0, 0], color="#777777", linewidth=2, linestyle="-")
    ax.add_patch(Rectangle((-0.21, 0.36), 0.42, 0.05, **BODY))
    ax.add_patch(Polygon([(-0.20, 0.44), (-0.18, 0.74), (0.18, 0.74), (0.20, 0.44)], **BODY))
    centres = {}
    for side in SIDES:
        centres[side] = _draw_rear_wheel(ax, geometry, side)
    ax.plot(
        *np.transpose(list(centres.values())), color="#9A9A9A", linewidth=4, linestyle="-", zorder=1
    )
    box(ax, (0.0, 0.385), SENSOR)
    label(ax, (0.0, 0.475), "frame IMU", fontsize=9)

    height = float(np.mean([centre[1] for centre in centres.values()]))
    _distance(
        ax, centres["left"][0], centres["right"][0], 0.07, height, "$d_c$  between the centres"
    )
    _distance(ax, -half, half, -0.10, 0.0, "$d_p$  track, between the contacts")

    origin = np.array([0.0, 0.83])
    _axis(ax, origin, (0.0, 0.24), "black", "$z$", (0.04, 0.0))
    _axis(ax, origin, (-0.24, 0.0), "black", "$y$", (0.0, 0.05))
    ax.plot(*origin, marker="o", markersize=9, mfc="white", mec="black")
    ax.plot(*origin, marker="x", markersize=6, color="black")
    label(ax, origin + np.array([0.05, -0.05]), "$x$ (forward)", ha="left")
    around = origin + np.array([0.0, 0.14])
    arc(ax, around, (0.095, 0.03), *TURN_RAD, colour=YAW, arrowhead=True, linewidth=1.8, zorder=6)
    label(ax, around + np.array([0.125, 0.0]), "$\\dot\\theta$ > 0: to the left", YAW, ha="left")
    ax.set_xlim(-half - 0.36, half + 0.36)
    ax.set_ylim(-0.22, 1.13)


def _draw_rear_wheel(ax: Axes, geometry: WheelchairGeometry, side: Side) -> FloatArray:
    """Draw one wheel edge-on with its axle, radius and camber; gives its centre on the screen."""
    from matplotlib.patches import Arc, Polygon

    sign = side_sign(side)
    colour = SIDE_COLOURS[side]
    radius = geometry.wheel_radius_m.of(side)
    centre = _rear(geometry.wheel_centre(side))
    axle = _rear(geometry.axle_direction(side))
    contact = np.array([-sign * geometry.track_m / 2, 0.0])
    along = (centre - contact) / radius
    top = contact + 2 * radius * along
    thick = 0.018 * axle
    outline = [contact - thick, contact + thick, top + thick, top - thick]
    ax.add_patch(Polygon(outline, facecolor="#D9D9D9", edgecolor="#8A8A8A", zorder=2))
    ax.plot(*np.transpose([contact, centre]), color=colour, linewidth=2, linestyle="-", zorder=3)
    name = side[0].upper()
    label(
        ax,
        (contact + centre) / 2 - 0.045 * sign * axle,
        f"$r_{name}$",
        colour,
    )
    ax.plot(*centre, marker="o", color=colour, zorder=4)
    ax.plot(*contact, marker="^", color=colour, markersize=7, zorder=4)
    # The angle between the vertical and the wheel.
    vertical = contact + np.array([0, 2.2 * radius])
    ax.plot(*np.transpose([contact, vertical]), color="#555555", linewidth=1, linestyle=(0, (4, 3)))
    degrees = np.rad2deg(geometry.camber_rad)
    start = 90 - degrees if sign > 0 else 90
    size = 3.5 * radius
    ax.add_patch(Arc(contact, size, size, theta1=start, theta2=start + degrees, color="#333333"))
    half = np.pi / 2 - sign * geometry.camber_rad / 2
    label(ax, contact + 1.90 * radius * np.array([np.cos(half), np.sin(half)]), r"$\alpha$")
    # The sensor sits on the wheel, the axle comes out of its centre.
    box(ax, centre + 0.10 * along, SENSOR, float(np.arctan2(*along[::-1])), edgecolor=colour)
    arrow(ax, centre, centre + 0.26 * axle, colour, linewidth=2.2)
    end = centre + 0.26 * axle
    label(
        ax,
        end + np.array([0.0, 0.055 if sign > 0 else -0.055]),
        f"axle, {side}",
        colour,
        fontsize=9,
    )
    return centre


def _draw_top(ax: Axes, geometry: WheelchairGeometry) -> None:
    """Draw the view from above: screen up is x, screen left is y."""
    from matplotlib.patches import Ellipse, Rectangle

    ax.set_title("From above: x forward, y left, z out of the page")
    ax.add_patch(Rectangle((-0.20, -0.10), 0.40, 0.42, **BODY))
    ax.add_patch(Rectangle((-0.20, -0.14), 0.40, 0.05, **BODY))
    for y in (-0.17, 0.17):
        ax.add_patch(Rectangle((-y - 0.015, 0.40), 0.03, 0.12, facecolor="#8A8A8A"))
        ax.plot([-y, -y], [0.32, 0.42], color="#9A9A9A", linewidth=3, linestyle="-", zorder=0)
    for side in SIDES:
        colour = SIDE_COLOURS[side]
        centre = geometry.wheel_centre(side)
        radius = geometry.wheel_radius_m.of(side)
        width = max(2 * radius * np.sin(geometry.camber_rad), 0.03)
        ax.add_patch(
            Ellipse(
                (-centre[1], 0),
                width,
                2 * radius,
                facecolor="#D9D9D9",
                edgecolor="#8A8A8A",
                alpha=0.75,
            )
        )
        ax.plot(-centre[1], 0, marker="o", color=colour, zorder=4)
        contact = -side_sign(side) * geometry.track_m / 2
        ax.plot(contact, 0, marker="^", color=colour, markersize=7, zorder=4)
        label(ax, (-centre[1], -radius - 0.05), f"{side} wheel", colour, fontsize=9)
    box(ax, (0.0, 0.16), SENSOR, np.pi / 2)
    label(ax, (0.04, 0.20), "frame IMU", ha="left", fontsize=9)

    # The centre of rotation lies on the line through the wheels.
    turn = -0.86
    ax.plot([turn, 0], [0, 0], color="#555555", linewidth=1.2, linestyle=(0, (4, 3)), zorder=3)
    ax.plot(turn, 0, marker="P", color=YAW, markersize=8)
    label(ax, (turn, -0.06), "centre of\nthe turn", YAW, va="top", fontsize=9)
    label(ax, (turn * 0.78, 0.06), r"$R = |V_x / \dot\theta|$", YAW)
    angles = np.linspace(-0.30, 0.70, 60)
    path = np.column_stack([turn - turn * np.cos(angles), -turn * np.sin(angles)])
    ax.plot(*path.T, color=YAW, linewidth=1.4, linestyle=":", zorder=3)

    _axis(ax, (0, 0), (0, 0.74), "black", "$x$, $V_x$", (0.10, 0.0), width=2.2)
    _axis(ax, (0, 0), (-0.30, 0), "black", "$y$", (0.0, 0.05))
    ax.plot(0, 0, marker="o", markersize=9, mfc="white", mec="black", zorder=6)
    ax.plot(0, 0, marker="o", markersize=3, color="black", zorder=7)
    label(ax, (0.04, -0.05), "$z$", ha="left")
    sixty = np.pi / 3
    arc(ax, (0, 0), 0.15, -sixty, sixty, colour=YAW, arrowhead=True, linewidth=1.8, zorder=6)
    label(ax, (0.20, 0.08), r"$\dot\theta$", YAW, ha="left")
    ax.set_xlim(-1.03, 0.56)
    ax.set_ylim(-0.46, 0.86)


def _rear(vector: FloatArray) -> FloatArray:
    """Place of a vector of the chair frame on the screen, seen from behind."""
    return np.array([-vector[1], vector[2]])


def _axis(
    ax: Axes,
    start: ArrayLike,
    vector: ArrayLike,
    colour: str,
    text: str,
    shift: tuple[float, float],
    width: float = 1.8,
) -> None:
    """Draw an arrow along a vector, with its name beside the tip."""
    tip = np.add(start, vector)
    arrow(ax, start, tip, colour, linewidth=width)
    label(ax, tip + shift, text, colour)


def _distance(ax: Axes, left: float, right: float, y: float, foot: float, text: str) -> None:
    """Draw a length between two places, with thin lines up to what it measures."""
    for x in (left, right):
        line(ax, [(x, y), (x, foot)], color="#777777", linewidth=0.8, zorder=1)
    dimension(ax, (left, y), (right, y), text, colour="#333333")
