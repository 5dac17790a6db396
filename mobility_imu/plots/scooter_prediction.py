"""Figures of the scooter's driving test as the static test predicts it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray
from mobility_imu.plots.style import COLOURS, HATCHES, cue, use_style

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PUBLISHED: dict[str, Any] = {"color": COLOURS["black"], "linestyle": ":", "linewidth": 1.4}


def plot_largest(largest_deg: Mapping[str, FloatArray], limits_deg: tuple[float, float]) -> Figure:
    """Largest dual 90 % errors of scooters, steering against throttle.

    Parameters
    ----------
    largest_deg : set of scooters to (n, 2) array, deg: steering, throttle
    limits_deg : deg, below which the paper's lie

    Returns
    -------
    Figure with one panel
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 4.6))
        for k, (name, values) in enumerate(largest_deg.items()):
            ax.plot(
                *np.asarray(values).T,
                linestyle="none",
                marker=cue(k)["marker"],
                color=cue(k)["color"],
                markersize=5,
                alpha=0.65,
                label=name,
            )
        x_deg, y_deg = limits_deg
        ax.fill_between(
            [0, x_deg], 0, y_deg, facecolor="none", hatch=HATCHES[1], edgecolor="#BBBBBB",
            linewidth=0, zorder=0,
        )  # fmt: skip
        ax.plot([0, x_deg, x_deg], [y_deg, y_deg, 0], label="the paper: below both", **PUBLISHED)
        ax.set_xlim(0, None)
        ax.set_ylim(0, None)
        ax.set_xlabel("steering: largest 90 % error of a course, deg")
        ax.set_ylabel("throttle: largest 90 % error, deg")
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_faults(
    names: Sequence[str], prior_sd_deg: ArrayLike, quantiles_deg: Mapping[str, FloatArray]
) -> Figure:
    """Intervals of all faults before and after the table was seen.

    Parameters
    ----------
    names : of the p faults; names that end in "noise" have a prior on one side only
    prior_sd_deg : (p,) array, deg
    quantiles_deg : name of a posterior to (3, p) array, deg: 5 %, 50 %, 95 %

    Returns
    -------
    Figure with one panel
    """
    import matplotlib.pyplot as plt

    sd = np.asarray(prior_sd_deg, float)
    with use_style():
        figure, ax = plt.subplots(figsize=(7.6, 5.6))
        for k, name in enumerate(names):
            low = 0.0 if name.endswith("noise") else -1.645 * sd[k]
            high = (1.96 if name.endswith("noise") else 1.645) * sd[k]
            ax.barh(
                k, high - low, left=low, height=0.7, facecolor="#E4E4E4", edgecolor="#999999",
                label="prior, 90 %" if k == 0 else None,
            )  # fmt: skip
        count = len(quantiles_deg)
        for j, (label, (low, middle, high)) in enumerate(quantiles_deg.items()):
            at = np.arange(len(names)) + 0.18 * (2 * j - count + 1)
            style = cue(j)
            ax.hlines(at, low, high, color=style["color"], linewidth=2.2)
            ax.plot(
                middle, at, linestyle="none", color=style["color"], marker=style["marker"],
                label=f"{label}, 90 %",
            )  # fmt: skip
        ax.axvline(0, color=COLOURS["black"], linewidth=0.8)
        ax.set_yticks(range(len(names)), names)
        ax.invert_yaxis()
        ax.set_xlabel("deg")
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_runs(values_deg: FloatArray, names: Sequence[str], chosen: Sequence[str]) -> Figure:
    """Distribution of some faults in each run of a sampler, all runs on top of one another.

    Parameters
    ----------
    values_deg : (run, step, walker, p) array, deg
    names : of the p faults
    chosen : which of them to show

    Returns
    -------
    Figure with one panel per fault
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, panels = plt.subplots(
            1, len(chosen), figsize=(2.6 * len(chosen), 2.6), squeeze=False
        )
        for ax, name in zip(panels[0], chosen, strict=True):
            part = values_deg[..., list(names).index(name)]
            low, high = np.quantile(part, [0.002, 0.998])
            edges = np.linspace(low, high, 41)
            for k, run in enumerate(part):
                height, _ = np.histogram(run, edges, density=True)
                style = cue(k)
                ax.step(
                    (edges[1:] + edges[:-1]) / 2, height, where="mid", color=style["color"],
                    linestyle=style["linestyle"], linewidth=1.2, label=f"run {k + 1}",
                )  # fmt: skip
            ax.set_title(name)
            ax.set_xlabel("deg")
            ax.set_yticks([])
        panels[0, -1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_ranks(
    below: FloatArray, names: Sequence[str], chosen: Sequence[str], *, bins: int = 10
) -> Figure:
    """Histograms of where the true values lie among the draws.

    Parameters
    ----------
    below : (table, p) array, 1, fraction of the draws below the true value
    names : of the p faults
    chosen : the identified ones, drawn darker
    bins : of each histogram

    Returns
    -------
    Figure with one panel per fault; the band holds 99 of 100 counts if the fractions are even
    """
    import matplotlib.pyplot as plt
    from scipy import stats

    count = len(below)
    low, high = stats.binom.ppf([0.005, 0.995], count, 1 / bins)
    columns = 6
    rows = -(-len(names) // columns)
    with use_style():
        figure, panels = plt.subplots(
            rows, columns, figsize=(9.0, 1.5 * rows), sharex=True, sharey=True
        )
        for ax, name, part in zip(panels.flat, names, below.T, strict=False):
            ax.axhspan(low, high, color="#E4E4E4", zorder=0)
            ax.hist(
                part, np.linspace(0, 1, bins + 1), edgecolor="white", linewidth=0.5,
                color=COLOURS["blue" if name in chosen else "sky"],
                hatch=None if name in chosen else HATCHES[1],
            )  # fmt: skip
            ax.set_title(name, fontsize=9)
            ax.set_xticks([0, 0.5, 1])
        for ax in panels[:, 0]:
            ax.set_ylabel("tables")
        figure.supxlabel("fraction of the draws below the true value", fontsize=10)
    return figure


def plot_intervals(
    intervals: Mapping[str, pd.DataFrame], limits_deg: Mapping[str, float]
) -> Figure:
    """The twenty predicted 90 % errors, 5 % to 95 % of the scooters of each set.

    Parameters
    ----------
    intervals : set to DataFrame with index (angle, estimator, course) and columns ``low``,
        ``middle``, ``high`` in deg
    limits_deg : angle to what the paper says of two IMUs, deg

    Returns
    -------
    Figure with four panels: angle by estimator
    """
    import matplotlib.pyplot as plt

    angles = list(limits_deg)
    with use_style():
        figure, panels = plt.subplots(2, 2, figsize=(9.4, 6.0), sharex=True, sharey="row")
        for (i, j), ax in np.ndenumerate(panels):
            angle, estimator = angles[i], ("single", "dual")[j]
            for k, (name, table) in enumerate(intervals.items()):
                part = table.xs((angle, estimator), level=("angle", "estimator"))
                at = np.arange(len(part)) + 0.2 * (k - (len(intervals) - 1) / 2)
                style = cue(k)
                ax.vlines(at, part["low"], part["high"], color=style["color"], linewidth=2.4)
                ax.plot(
                    at, part["middle"], linestyle="none", marker=style["marker"],
                    color=style["color"], label=name,
                )  # fmt: skip
                ax.set_xticks(range(len(part)), part.index)
            if estimator == "dual":
                ax.axhline(limits_deg[angle], label="the paper: below", **PUBLISHED)
            ax.set_ylim(0, None)
            ax.set_title(f"{angle}, {estimator}")
            if j == 0:
                ax.set_ylabel("90 % error, deg")
        panels[0, 1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def plot_sweep(largest_deg: Mapping[str, FloatArray], limits_deg: Mapping[str, float]) -> Figure:
    """Largest dual 90 % errors of the same scooters under changed assumptions.

    Parameters
    ----------
    largest_deg : variation to (n, 2) array, deg: steering, throttle; the first is the base
    limits_deg : angle to what the paper says, deg

    Returns
    -------
    Figure with one panel per angle; bars from 5 % to 95 % of the scooters, mark at the median
    """
    import matplotlib.pyplot as plt

    names = list(largest_deg)
    with use_style():
        figure, panels = plt.subplots(1, 2, figsize=(9.4, 0.8 + 0.28 * len(names)), sharey=True)
        for k, (ax, angle) in enumerate(zip(panels, limits_deg, strict=True)):
            found = np.array(
                [np.quantile(largest_deg[name][:, k], [0.05, 0.5, 0.95]) for name in names]
            )
            style = cue(k)
            ax.axvspan(found[0, 0], found[0, 2], color="#EEEEEE", zorder=0)
            ax.hlines(range(len(names)), found[:, 0], found[:, 2], color=style["color"])
            ax.plot(
                found[:, 1], range(len(names)), linestyle="none", marker=style["marker"],
                color=style["color"],
            )  # fmt: skip
            ax.axvline(limits_deg[angle], **PUBLISHED)
            ax.set_title(angle)
            ax.set_xlabel("largest dual 90 % error, deg")
            ax.set_xlim(0, None)
        panels[0].set_yticks(range(len(names)), names)
        panels[0].invert_yaxis()
    return figure
