"""Figures of real walks with a walking frame, and of feet; drawn from the records."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.plots.style import COLOURS, LINE_STYLES, MARKERS, use_style

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZES_HZ = 10.0
"""Rate of the recorded speeds."""
_NORMAL_AT = np.linspace(-4.5, 4.5, 181)


def plot_unlabelled(steps: Sequence[Mapping[str, Any]], columns: int = 3) -> Figure:
    """Plot the forward speed around steps without a label, with labelled windows and found steps.

    Parameters
    ----------
    steps : entries of ``seen`` of the record's rows
    columns : panels beside each other
    """
    import matplotlib.pyplot as plt

    rows = -(-len(steps) // columns)
    with use_style():
        figure, axes = plt.subplots(
            rows, columns, figsize=(8.8, 2.6 if rows == 1 else 1.4 * rows + 0.7),
            sharey=True, squeeze=False,
        )  # fmt: skip
        for ax, step in zip(axes.flat, steps, strict=False):
            _draw_step(ax, step)
            if len(steps) > 1:
                ax.set_title(f"{step['walk']}, {step['lift_s']:.1f} s: {step['kind']}", fontsize=8)
        for ax in axes.flat[len(steps) :]:
            ax.set_axis_off()
        for ax in axes[-1]:
            ax.set_xlabel("time since the lift, s")
        for row in axes:
            row[0].set_ylabel("speed, m/s")
        handles = [
            plt.Rectangle((0, 0), 1, 1, fc="#CFE8DC", hatch="///", ec="#7FB89D", label="labelled"),
            plt.Line2D([], [], color=COLOURS["blue"], lw=5, label="step found"),
            plt.Line2D([], [], color=COLOURS["vermilion"], lw=5, ls=(0, (1.2, 0.4)),
                       label="found, no label"),
        ]  # fmt: skip
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _draw_step(ax: Axes, step: Mapping[str, Any]) -> None:
    # Before the recording begins there is no speed: null in the record.
    speed = np.array(step["speed_mps"], float)
    clock = np.arange(len(speed)) / SIZES_HZ - 4.0
    for begin, end in step["windows_s"]:
        ax.axvspan(begin, end, facecolor="#CFE8DC", hatch="///", edgecolor="#7FB89D", lw=0)
    for lift, place in step["moves_s"]:
        own = abs(lift) < 1e-6
        ax.plot(
            [lift, place], [-0.12, -0.12], color=COLOURS["vermilion" if own else "blue"], lw=5,
            linestyle=(0, (1.2, 0.4)) if own else "-", solid_capstyle="butt",
        )  # fmt: skip
    ax.plot(clock, speed, color="black", linestyle="-", lw=1.2)
    ax.set_xlim(clock[0], clock[-1])
    ax.set_ylim(-0.2, 0.75)
    ax.grid(visible=False, axis="x")


def plot_spectra(sets: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Plot densities over frequency: accelerometer to the left, gyroscope to the right.

    Parameters
    ----------
    sets : name to spectra as the records have them, each "at rest" and "on the way"
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(8.8, 3.6))
        units = {"acc": "m/s²/√Hz", "gyr": "(deg/s)/√Hz"}
        names = ("specific force", "turning rate")
        for ax, quantity, name in zip(axes, units, names, strict=True):
            for k, (label, found) in enumerate(sets.items()):
                for how, filled in (("on the way", True), ("at rest", False)):
                    curve = found[quantity][how]
                    colour = COLOURS[("blue", "vermilion", "green")[k]]
                    ax.loglog(
                        curve["hz"], curve["density"], color=colour, linestyle=LINE_STYLES[k],
                        marker=MARKERS[k], mfc=colour if filled else "white",
                        label=f"{label}, {how}",
                    )  # fmt: skip
            ax.set_xlabel("frequency, Hz")
            ax.set_ylabel(f"density of the {name}, {units[quantity]}")
        figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(sets)
        )
    return figure


def plot_count_ranges(
    limits: Sequence[Mapping[str, float]], bursts: Sequence[Mapping[str, float]]
) -> Figure:
    """Plot labels found and others against the limits of two methods.

    Parameters
    ----------
    limits : dicts with ``factor``, ``labels``, ``found``, ``others``
    bursts : dicts with ``limit_mps2`` instead of ``factor``
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(8.8, 3.2), sharey=True)
        for ax, sweep, by, title in (
            (axes[0], limits, "factor", "our detector and filter"),
            (axes[1], bursts, "limit_mps2", "bursts of the force, no filter"),
        ):
            labels = sweep[0]["labels"]
            at = [row[by] for row in sweep]
            found = [100 * row["found"] / labels for row in sweep]
            others = [100 * row["others"] / labels for row in sweep]
            ax.plot(at, found, color=COLOURS["blue"], marker="o", linestyle="-", label="found")
            ax.plot(
                at, others, color=COLOURS["vermilion"], marker="s", linestyle="--", label="others"
            )
            ax.axhline(99, color="0.4", lw=0.9, linestyle=":")
            ax.set_title(title)
        axes[0].axvline(1.0, color="0.4", lw=0.9, linestyle=":")
        axes[0].annotate("used", (1.0, 50), xytext=(4, 0), textcoords="offset points", fontsize=9)
        axes[1].annotate("99 %", (0.7, 99), xytext=(0, -12), textcoords="offset points", fontsize=9)
        axes[0].set_xlabel("factor on both limits of the detector")
        axes[1].set_xlabel("limit of the running rms, m/s²")
        axes[0].set_ylabel("% of the labels")
        axes[0].set_ylim(0, 104)
        axes[1].legend(loc="center right")
    return figure


def plot_feet(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Plot error and stated standard deviation of each walk, with settings of frame and of foot.

    Parameters
    ----------
    rows : of the record, with "frame" and "foot"
    """
    import matplotlib.pyplot as plt

    order = sorted(rows, key=lambda row: float(row["foot"]["rms_m"]))
    at = np.arange(len(order))
    with use_style():
        figure, axes = plt.subplots(2, 1, figsize=(8.8, 4.6), sharex=True, sharey=True)
        for ax, way in zip(axes, ("frame", "foot"), strict=True):
            error, sd = (100 * np.array([row[way][k] for row in order]) for k in ("rms_m", "sd_m"))
            ax.vlines(at, np.minimum(error, sd), np.maximum(error, sd), color="0.75", lw=1.2)
            ax.plot(at, error, "o", color=COLOURS["blue"], label="error, rms")
            ax.plot(at, sd, "_", color=COLOURS["vermilion"], ms=11, mew=2.2, label="stated sd")
            ax.set_yscale("log")
            ax.set_yticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
            ax.set_title(f"settings for a {way}")
            ax.set_ylabel("error on the floor, cm")
            ax.set_ylim(0.5, 150)
        axes[0].legend(loc="upper left", ncols=2)
        axes[1].set_xticks(at, [row["walk"][-2:] for row in order], fontsize=8)
        axes[1].set_xlabel("walk, in the order of the lower panel's error")
    return figure


def plot_error_over_time(series: Sequence[Mapping[str, Any]]) -> Figure:
    """Plot walks from above, and the error and twice its stated standard deviation over time.

    Parameters
    ----------
    series : ``over_time`` of the record
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(
            len(series), 2, figsize=(8.8, 2.9 * len(series)), width_ratios=(1, 1.7), squeeze=False
        )
        for (above, ax), walk in zip(axes, series, strict=True):
            x, y = (np.array(walk[f"true_{axis}_m"]) for axis in "xy")
            above.plot(x, y, color="0.55", linestyle="-", label="motion capture")
            time = np.array(walk["time_s"])
            for k, (way, colour) in enumerate((("foot", "blue"), ("frame", "vermilion"))):
                e_x, e_y = (np.array(walk[way][f"error_{axis}_m"]) for axis in "xy")
                look = {"color": COLOURS[colour], "linestyle": LINE_STYLES[k]}
                above.plot(x + e_x, y + e_y, lw=1.0, label=f"settings for a {way}", **look)
                ax.plot(time, 100 * np.hypot(e_x, e_y), label=f"error, {way}", **look)
            sd = 200 * np.array(walk["foot"]["sd_m"])
            ax.fill_between(time, 0, sd, color="0.88", label="2 sd, foot")
            thin = 200 * np.array(walk["frame"]["sd_m"])
            ax.fill_between(time, 0, thin, color="0.7", hatch="...", lw=0, label="2 sd, frame")
            above.set_aspect("equal", adjustable="datalim")
            above.set_title(walk["walk"].replace("_", " "))
            above.set_ylabel("y, m")
            ax.set_ylabel("error on the floor, cm")
        axes[-1][0].set_xlabel("x, m")
        axes[-1][1].set_xlabel("time, s")
        axes[0][1].legend(loc="upper left", ncols=2)
        figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def plot_coverage(edges: Sequence[float], bins: Mapping[str, Sequence[int]]) -> Figure:
    """Plot how often errors of each size over the stated standard deviation occur.

    Parameters
    ----------
    edges : of the bins; one more on each side is open
    bins : "frame" and "foot" to counts
    """
    import matplotlib.pyplot as plt

    width = edges[1] - edges[0]
    middles = np.r_[edges[0] - width / 2, np.array(edges[:-1]) + width / 2, edges[-1] + width / 2]
    normal = np.exp(-(_NORMAL_AT**2) / 2) / np.sqrt(2 * np.pi) * width * 100
    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(8.8, 3.0), sharey=True)
        for ax, way, hatch in zip(axes, ("frame", "foot"), ("///", ""), strict=True):
            part = 100 * np.array(bins[way]) / np.sum(bins[way])
            ax.bar(
                middles, part, 0.92 * width, color=COLOURS["sky"], hatch=hatch, edgecolor="white",
                label="real feet",
            )  # fmt: skip
            ax.plot(_NORMAL_AT, normal, color="black", linestyle="--", label="as stated")
            ax.set_title(f"settings for a {way}")
            ax.set_xlabel("error over stated sd")
            ax.set_xticks([-4.25, -2, 0, 2, 4.25], ["< −4", "−2", "0", "2", "> 4"])
        axes[0].set_ylabel("% of the samples")
        axes[1].legend(loc="upper right")
    return figure
