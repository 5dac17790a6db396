"""Figures of the walking frame's steps and of walking tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.plots.style import COLOURS, CYCLE, HATCHES, LINE_STYLES, cue, use_style
from mobility_imu.runs import runs_of
from mobility_imu.walker.steps import Steps
from mobility_imu.walker.stillness import StillnessSettings, stillness_signals
from mobility_imu.walker.walking_tests import TUG_PHASES, TimedUpAndGo

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mobility_imu.recording import Recording
    from mobility_imu.walker.trajectory import Trajectory

PHASE_SHADES = ("#DCE9F5", "#FBE3CF", "#DCE9F5", "#FBE3CF")


def plot_step_signals(
    recording: Recording,
    trajectory: Trajectory,
    steps: Steps,
    span_s: tuple[float, float],
) -> Figure:
    """Plot the stillness detector's signals, the height, and the lifts and placements found.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    trajectory, steps : found from it
    span_s : s, first and last time to be shown
    """
    import matplotlib.pyplot as plt

    settings = trajectory.stillness or StillnessSettings()
    rate, deviation = stillness_signals(
        recording.sensor("frame").acc_mps2,
        recording.gyroscope("frame"),
        recording.sampling_rate_hz,
        settings,
    )
    curves = (
        (recording.time_s, rate, settings.rate_radps, "rate, rad/s"),
        (recording.time_s, deviation, settings.acc_deviation_mps2, "deviation, m/s²"),
        (trajectory.time_s, 100 * trajectory.position_m[:, 2], None, "height, cm"),
    )
    with use_style():
        figure, axes = plt.subplots(3, 1, figsize=(8.6, 5.6), sharex=True)
        for ax, (time, values, limit, name) in zip(axes, curves, strict=True):
            _mark_rests_and_steps(ax, trajectory, steps, span_s)
            ax.plot(time, values, color="black", linestyle="-", linewidth=1.1)
            if limit is not None:
                ax.axhline(limit, color=COLOURS["green"], linestyle=":")
                ax.annotate(
                    "limit",
                    (span_s[0], limit),
                    xytext=(3, 3),
                    color=COLOURS["green"],
                    textcoords="offset points",
                    fontsize=9,
                )
                inside = (time > span_s[0]) & (time < span_s[1])
                ax.set_ylim(0, 1.1 * values[inside].max())
            ax.set_ylabel(name)
            ax.grid(visible=False, axis="x")
        axes[-1].set_xlim(span_s)
        axes[-1].set_xlabel("time, s")
        handles = [
            plt.Line2D([], [], color=COLOURS["vermilion"], linestyle="--", label="lift"),
            plt.Line2D([], [], color=COLOURS["blue"], linestyle="-", label="placement"),
            plt.Rectangle((0, 0), 1, 1, color="#E4E4E4", label="detected as still"),
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _mark_rests_and_steps(
    ax: Axes, trajectory: Trajectory, steps: Steps, span_s: tuple[float, float]
) -> None:
    time = trajectory.time_s
    for run in runs_of(trajectory.stationary):
        ax.axvspan(time[run.start], time[run.stop - 1], color="#E4E4E4", lw=0)
    for moments, colour, line in ((steps.lift_s, "vermilion", "--"), (steps.place_s, "blue", "-")):
        for at in moments[(moments > span_s[0]) & (moments < span_s[1])]:
            ax.axvline(at, color=COLOURS[colour], linestyle=line, linewidth=1.3)


def plot_step_errors(errors: Mapping[str, Mapping[str, ArrayLike]]) -> Figure:
    """Plot the distribution of each error by level, one panel per error.

    Parameters
    ----------
    errors : name of the error with its unit -> level -> values
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, len(errors), figsize=(8.8, 3.3))
        for ax, (name, levels) in zip(axes, errors.items(), strict=True):
            boxes = ax.boxplot(
                [np.asarray(v) for v in levels.values()],
                whis=(0, 100),  # codespell:ignore whis
                widths=0.55,
                patch_artist=True,
                medianprops={"color": "black", "linewidth": 1.6},
            )
            for box, colour, hatch in zip(boxes["boxes"], CYCLE, HATCHES, strict=False):
                box.set(facecolor=COLOURS[colour], alpha=0.55, hatch=hatch)
            ax.axhline(0, color="black", linewidth=0.8, linestyle="-")
            ax.set_xticks(range(1, len(levels) + 1), list(levels), rotation=25)
            ax.set_title(name)
            ax.grid(visible=False, axis="x")
        axes[0].set_ylabel("found − true")
    return figure


def plot_distributions(
    found: Sequence[ArrayLike], true: Sequence[ArrayLike], names: Sequence[str]
) -> Figure:
    """Plot found values beside the true ones as histograms, one panel per quantity.

    Parameters
    ----------
    found, true : one array per quantity
    names : with units, for the axes
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, len(names), figsize=(8.8, 3.0))
        for ax, ours, truth, name in zip(axes, found, true, names, strict=True):
            edges = np.histogram_bin_edges(np.r_[np.asarray(ours), np.asarray(truth)], 24)
            ax.hist(truth, edges, color="0.8", label="true")
            ax.hist(
                ours,
                edges,
                histtype="step",
                color=COLOURS["vermilion"],
                linewidth=1.6,
                label="found",
            )
            ax.set_xlabel(name)
        axes[0].set_ylabel("steps")
        axes[0].legend(loc="upper left")
    return figure


def plot_sweeps(sweeps: Sequence[dict[str, Any]]) -> Figure:
    """Plot the fraction of walks with an exact count; each panel varies one thing.

    Parameters
    ----------
    sweeps : dicts with ``x``, ``lines`` (label -> percent of walks), ``xlabel``, ``chosen`` (the
        value used) and ``log``
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, len(sweeps), figsize=(8.8, 3.3), sharey=True)
        for ax, sweep in zip(np.atleast_1d(axes), sweeps, strict=True):
            ax.axvline(sweep["chosen"], color="0.45", linestyle=":", linewidth=2)
            ax.annotate(
                "used",
                (sweep["chosen"], 50),
                xytext=(4, 0),
                textcoords="offset points",
                color="0.35",
                fontsize=9,
            )
            for k, (label, share) in enumerate(sweep["lines"].items()):
                ax.plot(sweep["x"], share, label=label, **cue(k))
            if sweep["log"]:
                ax.set_xscale("log")
                ax.xaxis.set_major_formatter("{x:g}")
                ax.xaxis.set_minor_formatter("")
            ax.set_xlabel(sweep["xlabel"])
            if len(sweep["lines"]) > 1:
                ax.legend(loc="lower left", bbox_to_anchor=(0, 0.06))
            ax.set_ylim(-4, 104)
        np.atleast_1d(axes)[0].set_ylabel("walks counted exactly, %")
    return figure


def plot_distance_error(curves: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> Figure:
    """Plot the error of the distance walked against time.

    Parameters
    ----------
    curves : label -> time in s, error in m (found minus true)
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(figsize=(7.2, 3.3))
        axes.axhline(0, color="black", linewidth=0.8, linestyle="-")
        for k, (label, (time, error)) in enumerate(curves.items()):
            axes.plot(time, error, color=COLOURS[CYCLE[k]], linestyle=LINE_STYLES[k], label=label)
        axes.set_xlabel("time since the first lift, s")
        axes.set_ylabel("found − true distance, m")
        axes.legend(loc="lower left")
    return figure


def plot_timed_up_and_go(trajectory: Trajectory, steps: Steps, phases: TimedUpAndGo) -> Figure:
    """Plot the heading over time and the path from above, the phases shaded and named.

    Parameters
    ----------
    trajectory, steps : of the walk
    phases : TimedUpAndGo found in it
    """
    import matplotlib.pyplot as plt

    names = tuple(name.replace(" ", "\n") for name in TUG_PHASES)
    with use_style():
        figure, (above, below) = plt.subplots(2, 1, figsize=(8.6, 5.2), height_ratios=(1.5, 1))
        above.plot(trajectory.time_s, np.rad2deg(trajectory.yaw_rad), color="black", linestyle="-")
        top = 1.32 * np.rad2deg(np.abs(trajectory.yaw_rad)).max()
        for name, start, stop, shade in zip(
            names, phases.boundary_s[:-1], phases.boundary_s[1:], PHASE_SHADES, strict=True
        ):
            above.axvspan(start, stop, color=shade, lw=0)
            above.axvline(start, color="0.4", linestyle="--", linewidth=0.9)
            above.annotate(name, ((start + stop) / 2, 0.99 * top), ha="center", va="top")
        above.axvline(phases.boundary_s[-1], color="0.4", linestyle="--", linewidth=0.9)
        above.set_ylim(-15, top)
        above.set_xlim(trajectory.time_s[0], trajectory.time_s[-1])
        above.set_xlabel("time, s")
        above.set_ylabel("heading, deg")
        place = np.searchsorted(phases.boundary_s, steps.place_s, side="left") - 1
        for k, name in enumerate(TUG_PHASES):
            here = steps.place_m[place == k]
            look = cue(k)
            below.plot(
                here[:, 0],
                here[:, 1],
                linestyle="none",
                marker=look["marker"],
                color=look["color"],
                mfc="none" if k % 2 else look["color"],
                label=name,
                markersize=8 if k % 2 else 5,
            )
        below.plot(
            trajectory.position_m[:, 0],
            trajectory.position_m[:, 1],
            color="0.6",
            linestyle="-",
            linewidth=0.8,
            zorder=1,
        )
        below.set_aspect("equal", adjustable="datalim")
        below.set_xlabel("x, m (forward at the start)")
        below.set_ylabel("y, m (left)")
        figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure
