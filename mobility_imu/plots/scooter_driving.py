"""Figures of the scooter's driving test: after the paper's Figures 5, 7, 8 and 9, and our own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.plots.style import COLOURS, LINE_STYLES, MARKERS, cue, use_style
from mobility_imu.simulation.scooter import Course, SimulatedRide

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The paper's colours in Figure 7: true red, single light blue, dual deep blue. The line style and
# width tell them apart without colour.
TRUE: dict[str, Any] = {"color": COLOURS["vermilion"], "linestyle": "-", "linewidth": 2.2}
SINGLE: dict[str, Any] = {"color": COLOURS["sky"], "linestyle": "--", "linewidth": 1.2}
DUAL: dict[str, Any] = {"color": COLOURS["blue"], "linestyle": "-", "linewidth": 0.9}


class AnglesInTime(NamedTuple):
    """One ride's angles in motion, for :func:`plot_time_series`.

    Parameters
    ----------
    time_s : (n,) array, s
    true_deg, single_deg, dual_deg : (n, 2) arrays, deg, steering and throttle
    """

    time_s: FloatArray
    true_deg: FloatArray
    single_deg: FloatArray
    dual_deg: FloatArray


def plot_ride(ride: SimulatedRide, moving: NDArray[np.bool_], wire_deg: FloatArray) -> Figure:
    """Plot the recorded signals of one ride.

    Parameters
    ----------
    ride : SimulatedRide
    moving : (n,) bool array, shaded
    wire_deg : (n, 2) array, deg, wire sensors at the recording's samples

    Returns
    -------
    Figure: accelerations of both IMUs, and the reference with the Hall pulses
    """
    import matplotlib.pyplot as plt

    time_s = ride.recording.time_s
    with use_style():
        figure, panels = plt.subplots(
            3, 1, figsize=(8.4, 5.4), sharex=True, height_ratios=[1.25, 1.25, 1]
        )
        for ax, name in zip(panels, ("lever", "body"), strict=False):
            acc = ride.recording.sensor(name).acc_mps2
            for k, axis in enumerate("xyz"):
                ax.plot(time_s, acc[:, k], linewidth=0.8, label=axis)
            ax.set_title(f"IMU on the {name}: specific force")
            ax.set_ylabel("m/s²")
        panels[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        for k, (name, style) in enumerate((("steering", "-"), ("throttle", "--"))):
            panels[2].plot(time_s, wire_deg[:, k], linestyle=style, label=name)
        low = panels[2].get_ylim()[0]
        panels[2].plot(
            ride.pulses_s,
            np.full(len(ride.pulses_s), low),
            linestyle="none",
            marker="|",
            color="black",
            label="Hall pulse",
        )
        panels[2].set_title("Wire sensors, after synchronisation")
        panels[2].set_ylabel("deg")
        panels[2].set_xlabel("time, s")
        panels[2].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        start, stop = time_s[moving][[0, -1]]
        for ax in panels:
            ax.axvspan(start, stop, color="#EEEEEE", zorder=0)
    return figure


def draw_courses(courses: Mapping[str, Course]) -> Figure:
    """Draw the five courses like the paper's Figure 5: from above, or from the side or behind.

    Parameters
    ----------
    courses : name to Course: straight, curves, slopes, side, tactile

    Returns
    -------
    Figure with five panels
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplot_mosaic(
            [["straight", "straight"], ["slopes", "slopes"], ["tactile", "tactile"],
             ["curves", "side"]],
            figsize=(9.0, 7.4), height_ratios=[1, 1.5, 1, 3.2],
        )  # fmt: skip
        for letter, name in zip(
            "abcde", ("straight", "curves", "slopes", "side", "tactile"), strict=True
        ):
            ax, course = axes[name], courses[name]
            ax.set_title(f"({letter}) {name}, {course.length_m:.1f} m")
            ax.set_xlabel("m")
            ax.grid(visible=False)
            if name == "slopes":
                _draw_profile(ax, course)
            else:
                _draw_from_above(ax, course)
    return figure


def _draw_profile(ax: Axes, course: Course) -> None:
    grades = [segment.grade_rad for segment in course.segments]
    steps = [segment.length_m for segment in course.segments]
    along = np.concatenate([[0], np.cumsum(np.cos(grades) * steps)])
    height = np.concatenate([[0], np.cumsum(np.sin(grades) * steps)])
    ax.fill_between(along, height, height.min() - 0.15, color="#E4E4E4")
    ax.plot(along, height, color=COLOURS["black"])
    for k, grade in enumerate(grades):
        if grade:
            where = (along[k] + along[k + 1]) / 2, (height[k] + height[k + 1]) / 2 + 0.12
            ax.annotate(f"{np.rad2deg(grade):+.0f}°", where, ha="center")
    ax.annotate("", (1.9, 0.35), (0.3, 0.35), arrowprops={"arrowstyle": "->"})
    ax.set_ylim(height.min() - 0.15, height.max() + 0.45)
    ax.set_aspect("equal")
    ax.set_ylabel("height, m")


def _draw_from_above(ax: Axes, course: Course) -> None:
    turned = course.name == "curves"  # forward is up; elsewhere forward is to the right
    heading = 0.0
    place = np.zeros(2)
    for segment in course.segments:
        steps = np.linspace(0, segment.length_m, 60)
        headings = heading + segment.curvature_pm * steps
        moved = np.cumsum(np.column_stack([-np.sin(headings), np.cos(headings)]) * steps[1], axis=0)
        line = place + np.vstack([[0, 0], moved[:-1]])
        x, y = (line[:, 0], line[:, 1]) if turned else (line[:, 1], -line[:, 0])
        if segment.tactile or segment.bank_rad:
            ax.add_patch(
                _rectangle(
                    (x[0], -0.5), x[-1] - x[0], 1.0,
                    hatch="oo" if segment.tactile else "//",
                )
            )  # fmt: skip
            if segment.bank_rad:
                ax.annotate(
                    f"right side up by {np.rad2deg(segment.bank_rad):.0f}°\nover "
                    f"{segment.length_m:.0f} m",
                    ((x[0] + x[-1]) / 2, 0.75),
                    ha="center",
                )
            else:
                ax.annotate("tactile paving", ((x[0] + x[-1]) / 2, 0.6), ha="center")
        ax.plot(x, y, color=COLOURS["black"], linestyle="-")
        heading, place = headings[-1], line[-1]
    if turned:
        ax.annotate("", (0, 1.6), (0, 0.2), arrowprops={"arrowstyle": "->", "linewidth": 2})
        radius = 1 / max(abs(segment.curvature_pm) for segment in course.segments)
        ax.annotate(f"radius {radius:.1f} m,\n90° each", (0.6, 5.5), va="bottom")
        ax.set_xlim(-5.5, 5.0)
        ax.set_ylabel("m")
    else:
        ax.annotate("", (1.7, 0), (0.1, 0), arrowprops={"arrowstyle": "->", "linewidth": 2})
        ax.set_ylim(-0.9, 2.2 if course.name == "side" else 1.2)
        ax.set_yticks([])
    ax.set_aspect("equal")


def _rectangle(corner: tuple[float, float], width: float, height: float, *, hatch: str) -> Any:
    """Hatched grey rectangle."""
    from matplotlib.patches import Rectangle

    return Rectangle(corner, width, height, hatch=hatch, facecolor="#F2F2F2", edgecolor="#A0A0A0")


def plot_time_series(series: Mapping[str, AnglesInTime]) -> Figure:
    """Plot true and estimated angles over time, like the paper's Figure 7.

    Parameters
    ----------
    series : course to AnglesInTime

    Returns
    -------
    Figure: (a) steering, (b) throttle; one row per course
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, panels = plt.subplots(
            len(series), 2, figsize=(9.2, 1.6 * len(series) + 0.6), sharex="row", sharey="col"
        )
        for row, (course, one) in zip(panels, series.items(), strict=True):
            for k, ax in enumerate(row):
                ax.plot(one.time_s, one.single_deg[:, k], label="single IMU", **SINGLE)
                ax.plot(one.time_s, one.dual_deg[:, k], label="dual IMUs", **DUAL)
                ax.plot(one.time_s, one.true_deg[:, k], label="true (wire)", **TRUE)
                ax.set_ylabel(f"{course}\ndeg" if k == 0 else "deg")
        panels[0, 0].set_title("(a) steering")
        panels[0, 1].set_title("(b) throttle")
        panels[0, 0].set_ylim(-65, 65)
        panels[0, 1].set_ylim(-12, 52)
        for ax in panels[-1]:
            ax.set_xlabel("time, s")
        figure.legend(
            *panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3
        )
    return figure


def plot_durations(
    durations_s: Mapping[tuple[str, str], FloatArray],
    edges_deg: FloatArray,
    *,
    title: str,
    estimators: Sequence[tuple[str, str]] = (("single", "(i) single"), ("dual", "(ii) dual")),
) -> Figure:
    """Plot how long each pair of true and estimated angle lasted, like the paper's Figure 8.

    Parameters
    ----------
    durations_s : (course, estimator) to (k, k) array, s, true angle along the first axis
    edges_deg : (k + 1,) array, deg
    title : what the figure shows
    estimators : their names and labels, one row each

    Returns
    -------
    Figure: one row per estimator, one column per course, one logarithmic colour scale
    """
    import matplotlib.pyplot as plt
    from matplotlib.colors import LogNorm

    courses = list(dict.fromkeys(course for course, _ in durations_s))
    largest = max(float(values.max()) for values in durations_s.values())
    norm = LogNorm(0.01, largest)
    with use_style():
        figure, panels = plt.subplots(
            len(estimators), len(courses), figsize=(10.2, 4.9), sharex=True, sharey=True
        )
        for row, (name, label) in zip(panels, estimators, strict=True):
            for ax, course in zip(row, courses, strict=True):
                values = durations_s[course, name]
                image = ax.pcolormesh(
                    edges_deg,
                    edges_deg,
                    np.ma.masked_less_equal(values.T, 0),
                    norm=norm,
                    cmap="viridis",
                    rasterized=True,
                )
                ends = [edges_deg[0], edges_deg[-1]]
                ax.plot(ends, ends, color=COLOURS["vermilion"], linewidth=0.9, linestyle="--")
                ax.set_aspect("equal")
                if name == estimators[0][0]:
                    ax.set_title(course)
            row[0].set_ylabel(f"{label}\nestimated, deg")
        for ax in panels[-1]:
            ax.set_xlabel("true, deg")
        figure.suptitle(title, x=0.01, ha="left")
        figure.colorbar(image, ax=panels, label="duration, s", shrink=0.8)
    return figure


def plot_errors(
    errors: Mapping[tuple[int, str, str, str], ArrayLike],
    p90_deg: pd.Series,
    edges_deg: FloatArray,
    *,
    largest_deg: Mapping[str, float],
) -> Figure:
    """Plot error histograms and cumulative curves, like the paper's Figure 9.

    Parameters
    ----------
    errors : (scooter, course, estimator, angle) to counts of absolute errors; estimators single
        and dual, angles steering and throttle
    p90_deg : Series by (course, estimator, angle), deg: the number to print, median over scooters
    edges_deg : (k + 1,) array, deg
    largest_deg : by angle, end of the horizontal axis

    Returns
    -------
    Figure: rows (a) steering, (b) throttle; one column per course. Bars: all scooters together;
    thick lines: their cumulative fraction; thin lines: that of each scooter
    """
    import matplotlib.pyplot as plt

    courses = list(dict.fromkeys(key[1] for key in errors))
    scooters = sorted({key[0] for key in errors})
    looks = {
        "single": (COLOURS["blue"], "-", "///", 0.44),
        "dual": (COLOURS["vermilion"], "--", "", 0.25),
    }
    with use_style():
        figure, panels = plt.subplots(
            2, len(courses), figsize=(10.6, 5.4), sharex="row", sharey=True
        )
        for letter, row, angle in zip("ab", panels, ("steering", "throttle"), strict=True):
            for ax, course in zip(row, courses, strict=True):
                for name, (colour, style, hatch, height) in looks.items():
                    each = np.array([errors[s, course, name, angle] for s in scooters], float)
                    whole = each.sum(axis=0) / each.sum()
                    ax.stairs(
                        whole, edges_deg, fill=True, facecolor=colour, alpha=0.35, hatch=hatch,
                        edgecolor=colour,
                    )  # fmt: skip
                    for counts in each:
                        ax.plot(
                            edges_deg[1:], np.cumsum(counts) / counts.sum(),
                            color=colour, linestyle=style, linewidth=0.4, alpha=0.45,
                        )  # fmt: skip
                    ax.plot(
                        edges_deg[1:], np.cumsum(whole),
                        color=colour, linestyle=style, linewidth=1.8, label=f"{name}, all",
                    )  # fmt: skip
                    ax.annotate(
                        f"{name} {p90_deg[course, name, angle]:.1f}°",
                        (0.97, height),
                        xycoords="axes fraction",
                        ha="right",
                        color=colour if name == "single" else "#A34700",
                        fontsize=9,
                        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
                    )
                ax.axhline(0.9, color="black", linewidth=0.7, linestyle=":")
                ax.set_xlim(0, largest_deg[angle])
                if angle == "steering":
                    ax.set_title(course)
                ax.set_xlabel("absolute error, deg")
            row[0].set_ylabel(f"({letter}) {angle}\nfraction of the time")
        panels[0, 0].set_ylim(0, 1)
        figure.legend(
            *panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2
        )
    return figure


def plot_p90(summaries: Mapping[str, pd.DataFrame], courses: Sequence[str]) -> Figure:
    """Plot the 90 % errors of all estimators: median and range over the drawn scooters.

    Parameters
    ----------
    summaries : name of the mounting to what ``reproduction.scooter.driving.summary`` gives
    courses : in the order of the horizontal axis

    Returns
    -------
    Figure: columns are mountings, rows are the angles
    """
    import matplotlib.pyplot as plt

    colours = ["sky", "blue", "grey", "green", "orange", "purple", "vermilion"]
    with use_style():
        figure, panels = plt.subplots(
            2, len(summaries), figsize=(10.2, 6.4), sharex=True, sharey="row", squeeze=False
        )
        for column, (mounting, table) in zip(panels.T, summaries.items(), strict=True):
            estimators = list(dict.fromkeys(table.index.get_level_values("estimator")))
            for ax, angle in zip(column, ("steering", "throttle"), strict=True):
                for k, name in enumerate(estimators):
                    rows = table.loc[name].loc[angle].loc[list(courses)]
                    shift = (k - (len(estimators) - 1) / 2) * 0.115
                    middle = rows["median"].to_numpy()
                    ax.errorbar(
                        np.arange(len(courses)) + shift,
                        middle,
                        yerr=np.abs(rows[["min", "max"]].to_numpy().T - middle),
                        color=COLOURS[colours[k % len(colours)]],
                        marker=(*MARKERS, "P")[k % 7],
                        linestyle="none",
                        elinewidth=1,
                        capsize=2,
                        label=name,
                    )
                ax.set_ylabel(f"{angle}: 90 % error, deg")
                ax.set_ylim(bottom=0)
                ax.grid(visible=False, axis="x")
            column[0].set_title(f"mounting {mounting}")
            column[1].set_xticks(range(len(courses)), courses)
        figure.legend(
            *panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4
        )
    return figure


def plot_effects(p90_deg: Mapping[str, Mapping[str, Mapping[str, float]]]) -> Figure:
    """Plot the 90 % errors of one estimator under several conditions, as shaded numbers.

    Parameters
    ----------
    p90_deg : condition to angle to course to 90 % error, deg

    Returns
    -------
    Figure: one panel per angle; rows are conditions, columns are courses, shades are logarithmic
    """
    import matplotlib.pyplot as plt
    from matplotlib.colors import LogNorm

    conditions = list(p90_deg)
    angles = list(p90_deg[conditions[0]])
    courses = list(p90_deg[conditions[0]][angles[0]])
    with use_style():
        figure, panels = plt.subplots(
            1, len(angles), figsize=(8.8, 0.6 + 0.29 * len(conditions)), sharey=True
        )
        for ax, angle in zip(panels, angles, strict=True):
            values = np.array([list(p90_deg[row][angle].values()) for row in conditions])
            ax.imshow(values, cmap="Blues", norm=LogNorm(0.5, 50, clip=True), aspect="auto")
            for (y, x), value in np.ndenumerate(values):
                colour = "white" if value > 12 else "black"
                ax.text(x, y, f"{value:.1f}", ha="center", va="center", color=colour, fontsize=9)
            ax.set(title=f"{angle}: 90 % error, deg", xticks=range(len(courses)))
            ax.set_xticklabels(courses)
            ax.set_yticks(range(len(conditions)), conditions)
            ax.tick_params(length=0)
            ax.grid(visible=False)
    return figure


def plot_window(windows: ArrayLike, curves: Mapping[str, ArrayLike]) -> Figure:
    """Plot 90 % errors over the length of a smoothing window.

    Parameters
    ----------
    windows : (k,) array, samples
    curves : label to (k,) array, deg

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 3.6))
        for k, (label, values) in enumerate(curves.items()):
            ax.plot(windows, values, label=label, marker=MARKERS[k], linestyle=LINE_STYLES[k])
        ax.set_xlabel("window, samples at 100 Hz")
        ax.set_ylabel("90 % error, deg")
        ax.set_ylim(bottom=0)
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_pairs(table: pd.DataFrame, first: str, second: str) -> Figure:
    """Plot the 90 % errors of two estimators against each other, one point per scooter and course.

    Parameters
    ----------
    table : rows of one mounting and one reference, with columns scooter, course, estimator, angle
        and p90_deg
    first, second : estimators of the horizontal and the vertical axis

    Returns
    -------
    Figure: steering and throttle. Below the diagonal the second estimator has the smaller error
    """
    import matplotlib.pyplot as plt

    p90 = table.pivot_table(
        index=["angle", "course", "scooter"], columns="estimator", values="p90_deg", sort=False
    )
    with use_style():
        figure, panels = plt.subplots(1, 2, figsize=(8.6, 4.5))
        for ax, angle in zip(panels, ("steering", "throttle"), strict=True):
            rows = p90.loc[angle]
            for k, course in enumerate(rows.index.unique("course")):
                one = rows.loc[course]
                ax.plot(
                    one[first],
                    one[second],
                    **cue(k) | {"linestyle": "none"},
                    alpha=0.8,
                    label=course,
                )
            low, high = rows[[first, second]].to_numpy().min(), rows[[first, second]].max().max()
            ends = np.array([0.94 * low, 1.04 * high])
            ax.plot(ends, ends, color=COLOURS["grey"], linestyle="-", linewidth=1.0)
            ax.text(
                0.97, 0.05, f"{second} better", transform=ax.transAxes, ha="right", color="#555555"
            )
            ax.text(0.03, 0.93, f"{first} better", transform=ax.transAxes, color="#555555")
            ax.set(
                title=angle,
                xlabel=f"{first}: 90 % error, deg",
                ylabel=f"{second}: 90 % error, deg",
                xlim=ends,
                ylim=ends,
                aspect="equal",
            )
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure
