"""Figures of the walker's navigation chapter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.frames import FloatArray
from mobility_imu.plots.style import COLOURS, cue, use_style
from mobility_imu.runs import runs_of
from mobility_imu.walker.stillness import StillnessSettings

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_stillness(
    time_s: ArrayLike,
    rate_radps: ArrayLike,
    deviation_mps2: ArrayLike,
    still: NDArray[np.bool_],
    standing: NDArray[np.bool_],
    settings: StillnessSettings,
) -> Figure:
    """Plot both signals of the stillness detector with their thresholds.

    Parameters
    ----------
    time_s : (n,) array, s
    rate_radps : (n,) array, rad/s, size of the mean rate
    deviation_mps2 : (n,) array, m/s², distance of the mean specific force from its longer mean
    still : (n,) bool array, shaded
    standing : (n,) bool array, the truth, drawn as a bar on top
    settings : StillnessSettings, for the thresholds
    """
    import matplotlib.pyplot as plt

    clock = np.asarray(time_s, float)
    with use_style():
        figure, panels = plt.subplots(2, 1, figsize=(7.6, 4.6), sharex=True)
        rows = (
            (np.asarray(rate_radps), settings.rate_radps, "mean rate, rad/s"),
            (np.asarray(deviation_mps2), settings.acc_deviation_mps2, "deviation, m/s²"),
        )
        for ax, (values, threshold, label) in zip(panels, rows, strict=True):
            _shade(ax, clock, still)
            ax.semilogy(clock, values, color=COLOURS["blue"], linestyle="-", linewidth=1.1)
            ax.axhline(threshold, color=COLOURS["vermilion"], linestyle="--", linewidth=1.4)
            ax.text(clock[-1], threshold, " threshold", color=COLOURS["vermilion"], va="center")
            ax.set_xlim(clock[0], clock[-1])
            ax.set_ylabel(label)
            top = 10 ** (np.log10(values.max()) + 0.25)
            ax.plot(clock, np.where(standing, top, np.nan), color="black", linewidth=4)
        panels[0].set_title("black bar: it stands;  grey: found still")
        panels[1].set_xlabel("time, s")
        return figure


def plot_threshold_sweep(table: pd.DataFrame, chosen: float) -> Figure:
    """Plot distance error and fraction of still samples against the detector's rate threshold.

    Parameters
    ----------
    table : with columns ``level``, ``rate, rad/s``, ``error, m``, ``sd, m``, ``still, %`` and
        ``standing, %``
    chosen : rad/s, threshold of the package, marked
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.6))
        for k, (level, rows) in enumerate(table.groupby("level", sort=False)):
            rate = rows["rate, rad/s"]
            panels[0].errorbar(
                rate, rows["error, m"], yerr=rows["sd, m"], capsize=3, label=level, **cue(k)
            )
            panels[1].plot(rate, rows["still, %"], label=level, **cue(k))
            panels[1].axhline(rows["standing, %"].iloc[0], linestyle=":", color=cue(k)["color"])
        panels[0].set_ylabel("distance, found minus true, m")
        panels[1].set_ylabel("samples found still, %")
        for ax in panels:
            ax.set_xscale("log")
            ax.axvline(chosen, color="0.6", linestyle="-", linewidth=4, alpha=0.4, zorder=0)
            ax.set_xticks(table["rate, rad/s"].unique(), minor=False)
            ax.set_xticklabels([f"{rate:g}" for rate in table["rate, rad/s"].unique()])
            ax.minorticks_off()
            ax.set_xlabel("rate threshold, rad/s")
        panels[1].text(0.021, table["standing, %"].max() + 0.5, "at rest (dotted)", fontsize=9)
        panels[0].legend(loc="lower left")
        return figure


def plot_position_errors(time_s: ArrayLike, errors_m: Mapping[str, FloatArray]) -> Figure:
    """Plot how far each method's position is from the truth, on a logarithmic axis.

    Parameters
    ----------
    time_s : (n,) array, s
    errors_m : by method, (n,) arrays, m
    """
    import matplotlib.pyplot as plt

    clock = np.asarray(time_s, float)
    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 4.0))
        for k, (name, error) in enumerate(errors_m.items()):
            style = {**cue(k), "marker": None}
            ax.semilogy(clock, np.maximum(error, 1e-5), label=name, **style)
        ax.set_xlabel("time, s")
        ax.set_ylabel("distance from the true place, m")
        ax.legend(loc="lower right")
        return figure


def plot_error_bands(
    time_s: ArrayLike,
    errors: Mapping[str, tuple[FloatArray, FloatArray]],
) -> Figure:
    """Plot errors with the band of two standard deviations that the filter states.

    Parameters
    ----------
    time_s : (n,) array, s
    errors : by label (with unit), error and standard deviation, (n,) arrays
    """
    import matplotlib.pyplot as plt

    clock = np.asarray(time_s, float)
    with use_style():
        figure, panels = plt.subplots(
            len(errors), 1, figsize=(7.4, 1.7 * len(errors) + 0.5), sharex=True
        )
        for ax, (label, (error, sd)) in zip(panels, errors.items(), strict=True):
            ax.fill_between(clock, -2 * sd, 2 * sd, color="#DDDDDD", linewidth=0, label="±2 sd")
            ax.plot(clock, error, color=COLOURS["blue"], linestyle="-", label="error")
            ax.set_ylabel(label)
        panels[0].legend(loc="upper left", ncols=2)
        panels[-1].set_xlabel("time, s")
        return figure


def _shade(ax: Axes, time_s: FloatArray, flags: NDArray[np.bool_]) -> None:
    for run in runs_of(flags):
        ax.axvspan(time_s[run.start], time_s[run.stop - 1], color="#E4E4E4", linewidth=0)
