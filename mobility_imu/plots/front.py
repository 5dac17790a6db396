"""The three devices with their sensors, and what comes out of each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.plots.drawing import GREY, SMALL_PT, box, direction, disc, line, shape
from mobility_imu.plots.style import COLOURS, use_style
from mobility_imu.plots.wheelchair import TASK_COLOURS, TASK_HATCHES
from mobility_imu.wheelchair import Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mobility_imu.scooter import RideAngles
    from mobility_imu.walker import Steps, Trajectory
    from mobility_imu.wheelchair import Tasks

SENSOR = COLOURS["vermilion"]
TUBE: dict[str, Any] = {"color": "#8A8A8A", "linewidth": 3.5, "zorder": 2}
SIDE_M = 1.45
"""Width of each device's drawing, m."""


def draw_front(
    ride: RideAngles, tasks: Tasks, walk: Trajectory, steps: Steps, truth_deg: ArrayLike
) -> Figure:
    """Draw the devices in a row, each above the result that its sensors give.

    Parameters
    ----------
    ride : RideAngles of a scooter
    tasks : Tasks of a wheelchair's drive
    walk : Trajectory of a walking frame
    steps : Steps of that walk
    truth_deg : (n, 2) array, deg, true steering and throttle of the ride

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(
            2, 3, figsize=(10.5, 6.2), gridspec_kw={"height_ratios": [1.0, 1.1]}
        )
        for ax, draw, title in zip(
            axes[0],
            (_scooter, _chair, _frame),
            ("Scooter: 1 or 2 sensors", "Wheelchair: 3 sensors", "Walking frame: 1 sensor"),
            strict=True,
        ):
            draw(ax)
            ax.set_title(title, loc="center")
        _angles(axes[1, 0], ride, np.asarray(truth_deg, float))
        _tasks(axes[1, 1], tasks)
        _path(axes[1, 2], walk, steps)
    return figure


def _sensor(ax: Axes, place: ArrayLike, angle_rad: float = 0.0) -> None:
    box(ax, place, (0.085, 0.05), angle_rad, facecolor=SENSOR, edgecolor="black", linewidth=1.0)


def _name(ax: Axes, text: str, place: tuple[float, float], of: ArrayLike | None = None) -> None:
    """Write a sensor's name in its colour; ``of`` draws a line to the sensor."""
    x, y = place if of is None else np.asarray(of, float)
    pointer = {"arrowstyle": "-", "color": SENSOR, "linewidth": 0.8}
    ax.annotate(
        text, (x, y), place, color=SENSOR, fontsize=SMALL_PT, ha="left", va="center",
        arrowprops=None if of is None else pointer,
    )  # fmt: skip


def _floor(ax: Axes) -> None:
    line(ax, [(-0.1, 0), (SIDE_M, 0)], color=GREY, linewidth=1)
    ax.set(xlim=(-0.12, SIDE_M), ylim=(-0.04, 1.16), aspect="equal")
    ax.set_axis_off()


def _scooter(ax: Axes) -> None:
    """Draw a scooter from its right: one sensor on the throttle lever, one on the body."""
    for x in (0.18, 1.05):
        disc(ax, (x, 0.14), 0.14, facecolor="#D9D9D9", zorder=3)
        disc(ax, (x, 0.14), 0.05, facecolor="white", zorder=3)
    deck = [(0.03, 0.42), (0.4, 0.42), (0.46, 0.24), (0.82, 0.24), (0.92, 0.4), (1.2, 0.4)]
    shape(ax, [*deck, (1.2, 0.32), (0.95, 0.31), (0.86, 0.17), (0.42, 0.17), (0.03, 0.30)])
    shape(ax, [(0.06, 0.5), (0.42, 0.5), (0.42, 0.56), (0.06, 0.56)])
    shape(ax, [(0.07, 0.56), (0.02, 0.95), (0.08, 0.96), (0.14, 0.56)])
    line(ax, [(0.23, 0.42), (0.23, 0.5)], **TUBE)
    foot, lean = np.array([1.06, 0.38]), direction(np.pi / 2 + 0.35)
    top = foot + 0.58 * lean
    line(ax, [foot, top], **TUBE)
    line(ax, [top - 0.13 * direction(0.35), top + 0.08 * direction(0.35)], **TUBE)
    lever = top + 0.16 * direction(np.pi / 2 + 0.1)
    line(ax, [top, lever], color="#777777", linewidth=2.5, zorder=3)
    _sensor(ax, (top + lever) / 2, 0.1 + np.pi / 2)
    _sensor(ax, (1.08, 0.44))
    _name(ax, "on the lever", (1.0, 1.02))
    _name(ax, "on the body", (1.1, 0.56))
    _floor(ax)


def _chair(ax: Axes) -> None:
    """Draw a wheelchair from its right: a sensor on each wheel, one on the frame."""
    line(ax, [(0.22, 1.0), (0.28, 0.5), (0.78, 0.5), (0.92, 0.2), (1.06, 0.2)], **TUBE)
    line(ax, [(0.14, 1.0), (0.22, 1.0)], **TUBE)
    line(ax, [(0.7, 0.5), (0.78, 0.16)], **TUBE)
    disc(ax, (0.8, 0.09), 0.09, facecolor="#D9D9D9", zorder=3)
    wheel = np.array([0.36, 0.32])
    disc(ax, wheel, 0.32, facecolor="none", edgecolor="#555555", linewidth=3.5, zorder=3)
    disc(ax, wheel, 0.27, facecolor="none", edgecolor="#AAAAAA", linewidth=1.5, zorder=3)
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        line(ax, np.stack([wheel, wheel + 0.31 * direction(angle)]), color="#C4C4C4", linewidth=0.8)
    _sensor(ax, wheel, 0.5)
    _sensor(ax, (0.62, 0.5))
    _name(ax, "on each wheel", (0.5, 0.95), of=wheel)
    _name(ax, "on the frame", (0.7, 0.59))
    _floor(ax)


def _frame(ax: Axes) -> None:
    """Draw a walking frame from its side, with a sensor somewhere on it."""
    rear, front = [(0.3, 0), (0.38, 0.86)], [(0.86, 0), (0.8, 0.86)]
    top, low = [(0.28, 0.9), (0.38, 0.86), (0.8, 0.86)], [(0.33, 0.32), (0.84, 0.32)]
    for bar in (rear, front, top, low):
        line(ax, bar, **TUBE)
    for x in (0.3, 0.86):
        box(ax, (x, 0.02), (0.06, 0.04), facecolor="#555555", edgecolor="#555555")
    line(ax, [(0.26, 0.9), (0.44, 0.87)], color="#444444", linewidth=5)
    _sensor(ax, (0.82, 0.6), 0.6)
    _name(ax, "anywhere", (0.93, 0.64))
    _floor(ax)


def _angles(ax: Axes, ride: RideAngles, truth_deg: np.ndarray) -> None:
    """Draw both angles of a ride over their truth."""
    for k, (name, colour) in enumerate((("steering", "blue"), ("throttle", "vermilion"))):
        found = np.rad2deg(getattr(ride, f"{name}_rad"))
        ax.plot(ride.time_s, truth_deg[:, k], color="black", linestyle=":", linewidth=1.0)
        ax.plot(ride.time_s, found, color=COLOURS[colour], linestyle=("-", "--")[k], label=name)
    ax.plot([], [], color="black", linestyle=":", linewidth=1.0, label="truth")
    ax.set(xlabel="time (s)", ylabel="angle (deg)", title="Angles of steering and throttle")
    ax.set_ylim(top=1.45 * float(np.nanmax(truth_deg)))
    ax.legend(loc="upper center", ncols=3, columnspacing=1.0)


def _tasks(ax: Axes, tasks: Tasks) -> None:
    """Draw a band for each task."""
    edges = np.flatnonzero(np.diff(tasks.codes)) + 1
    ends = np.r_[edges, len(tasks.codes)]
    step = 1 / 100 if len(tasks) < 2 else float(np.median(np.diff(tasks.time_s)))
    for first, end in zip(np.r_[0, edges], ends, strict=True):
        code = Task(int(tasks.codes[first]))
        span = [(float(tasks.time_s[first]), float(end - first) * step)]
        ax.broken_barh(
            span, (code - 0.4, 0.8), facecolor=TASK_COLOURS[code],
            edgecolor="white", linewidth=0, hatch=TASK_HATCHES[code],
        )  # fmt: skip
    ax.set_ylim(6.6, 0.4)
    ax.set_yticks(list(Task), [code.title.replace(" ", "\n") for code in Task])
    ax.tick_params(axis="y", length=0, labelsize=8)
    ax.set(xlabel="time (s)", title="Chronogram of six tasks")


def _path(ax: Axes, walk: Trajectory, steps: Steps) -> None:
    """Draw the path from above, a mark at each place where the frame was put down."""
    place = walk.position_m[:, :2]
    ax.plot(place[:, 0], place[:, 1], color=COLOURS["blue"], linewidth=1.2, label="path")
    ax.plot(
        steps.place_m[:, 0], steps.place_m[:, 1], "o", color=COLOURS["vermilion"],
        markersize=4, label=f"{len(steps)} steps",
    )  # fmt: skip
    ax.plot(*place[0], "s", color="black", markersize=6, label="start")
    ax.set(xlabel="forward (m)", ylabel="left (m)", title="Path and steps", aspect="equal")
    ax.legend(loc="best")
