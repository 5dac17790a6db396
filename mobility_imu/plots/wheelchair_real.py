"""Figures of the chair on recordings of other people; drawn from the records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.plots.drawing import WIDTH_IN, arc, arrow, blank, box, disc, label, line
from mobility_imu.plots.style import COLOURS, cue, use_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Numbers = Mapping[str, Any]
BAND = "#DCE9F5"
"""Shade of a stated 95 % interval."""
INSIDE = 1.96


def draw_rocking(height_m: float = 0.25, radius_m: float = 0.3) -> Figure:
    """Draw the chair from its right side: the wheel's axle, and a marker above it.

    Parameters
    ----------
    height_m : m, of the marker over the axle
    radius_m : m, of the wheel
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.6))
        line(ax, [(-0.55, -radius_m), (0.85, -radius_m)], color="#555555", linewidth=1.5)
        disc(ax, (0, 0), radius_m)
        disc(ax, (0.5, -radius_m + 0.08), 0.08)
        line(ax, [(-0.05, 0.02), (0.5, -0.05), (0.5, -0.2)], linewidth=2.5)
        line(ax, [(-0.05, 0.02), (-0.1, 0.42)], linewidth=2.5)
        box(ax, (0.0, -0.13), (0.11, 0.06))
        label(ax, (-0.32, -0.2), "IMU on\nthe wheel", ha="center")
        line(ax, [(-0.22, -0.18), (-0.06, -0.14)], color="#555555", linewidth=0.9)
        box(ax, (0.3, -0.02), (0.11, 0.06), -0.12)
        label(ax, (0.3, -0.13), "IMU on the frame")
        disc(ax, (0, 0), 0.022, facecolor="black", edgecolor="black")
        disc(ax, (0, height_m), 0.03, facecolor=COLOURS["vermilion"], edgecolor="black", zorder=7)
        line(ax, [(0, 0), (0, height_m)], color=COLOURS["vermilion"], linestyle="--")
        arrow(ax, (0.04, height_m), (0.34, height_m), COLOURS["vermilion"], gid="marker's speed")
        label(ax, (0.5, height_m + 0.08), "marker: v + h · pitch rate", COLOURS["vermilion"])
        arrow(ax, (0.03, 0.0), (0.2, 0.0), COLOURS["blue"], gid="axle's speed")
        label(ax, (0.17, 0.07), "axle: v", COLOURS["blue"])
        arc(ax, (0, 0), 0.42, np.deg2rad(125), np.deg2rad(65), arrowhead=True)
        label(ax, (-0.3, 0.4), "pitch rate")
        label(ax, (-0.06, height_m / 2), "h", COLOURS["vermilion"])
        blank(ax, (-0.6, 0.9), (-0.36, 0.52))
    return figure


def plot_errors_over_time(series: Sequence[Numbers], *, rocking: bool = True) -> Figure:
    """Plot the speed, its error and the stated 95 % interval over time, one column per trial.

    Parameters
    ----------
    series : each with ``trial``, ``time_s``, ``true_mps``, ``error_mps``, ``sd_mps`` and, if
        ``rocking``, ``rocking_mps``
    rocking : whether the part of the error that rocking predicts is drawn
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(
            2, len(series), figsize=(8.6, 4.5), sharex="col", sharey="row", squeeze=False
        )
        for (top, bottom), one in zip(axes.T, series, strict=True):
            time_s, true, error, sd = (
                _with_gaps(one["time_s"], one[name])
                for name in ("time_s", "true_mps", "error_mps", "sd_mps")
            )
            top.plot(time_s, true, color="black", linestyle="-")
            top.set_title(one["trial"])
            bottom.fill_between(
                time_s, -INSIDE * sd, INSIDE * sd, color=BAND, linewidth=0, label="stated 95 %"
            )
            bottom.plot(time_s, error, color=COLOURS["blue"], linestyle="-", label="found − true")
            if rocking:
                bottom.plot(
                    time_s,
                    _with_gaps(one["time_s"], one["rocking_mps"]),
                    color=COLOURS["vermilion"],
                    linestyle="--",
                    linewidth=1.2,
                    label="by rocking",
                )
            bottom.axhline(0, color="black", linewidth=0.8, linestyle="-")
            bottom.set_xlabel("time, s")
        axes[0, 0].set_ylabel("reference, m/s")
        axes[1, 0].set_ylabel("error of the speed, m/s")
        handles, names = axes[1, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure


def _with_gaps(time_s: ArrayLike, values: ArrayLike) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Values with NaN where the time jumps, so that no line crosses a gap."""
    time, found = np.asarray(time_s, float), np.array(values, float)
    found[np.r_[False, np.diff(time) > 3 * np.median(np.diff(time))]] = np.nan
    return found


def plot_ratios(fractions: Mapping[str, Sequence[float]], edges: ArrayLike) -> Figure:
    """Plot histograms of error over stated standard deviation beside the normal distribution.

    Parameters
    ----------
    fractions : title -> fraction of the samples in each bin; the outermost bins hold the rest
    edges : of the bins
    """
    import matplotlib.pyplot as plt

    edges = np.asarray(edges, float)
    grid = np.linspace(edges[0], edges[-1], 200)
    normal = np.exp(-(grid**2) / 2) / np.sqrt(2 * np.pi)
    with use_style():
        figure, axes = plt.subplots(1, len(fractions), figsize=(8.6, 3.2), squeeze=False)
        for ax, (title, found) in zip(axes[0], fractions.items(), strict=True):
            heights = np.asarray(found) / np.diff(edges)
            ax.stairs(heights, edges, fill=True, color=COLOURS["sky"], alpha=0.7, label="found")
            ax.stairs(heights, edges, color="black", linewidth=0.8)
            ax.plot(grid, normal, color=COLOURS["vermilion"], linestyle="--", label="normal")
            ax.set_title(title)
            ax.set_xlabel("error over stated sd")
        axes[0, 0].set_ylabel("density")
        axes[0, 0].legend(loc="upper left")
    return figure


def plot_spectra(
    spectra: Mapping[str, Numbers], unit: str, floor: float | None = None, floor_name: str = ""
) -> Figure:
    """Plot amplitude spectral densities.

    Parameters
    ----------
    spectra : name -> ``hz`` and ``density``
    unit : of the density
    floor : density of a simulated sensor's white noise
    floor_name : what the floor is
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(7.6, 3.6))
        for k, (name, one) in enumerate(spectra.items()):
            ax.loglog(one["hz"], one["density"], label=name, **(cue(k) | {"markersize": 3}))
        if floor is not None:
            ax.axhline(floor, color="black", linestyle="-", linewidth=2.5, label=floor_name)
        ax.set_xlabel("frequency, Hz")
        ax.set_ylabel(unit)
        figure.legend(loc="outside right upper")
    return figure


def plot_trials(rows: Sequence[Numbers], simulated: Numbers) -> Figure:
    """Plot the speed's error of each trial, with and without rocking, and what was simulated.

    Parameters
    ----------
    rows : of the record of motion capture
    simulated : ``least``, ``median`` and ``most`` of the simulated courts
    """
    import matplotlib.pyplot as plt

    names = [row["trial"] for row in rows]
    place = np.arange(len(rows))[::-1]
    with use_style():
        figure, ax = plt.subplots(figsize=(7.6, 4.3))
        ax.axvspan(
            simulated["least"], simulated["most"], color="#E4E4E4", label="simulated, all courts"
        )
        ax.axvline(simulated["median"], color="black", linestyle=":", label="simulated, median")
        ax.plot(
            [row["speed"]["rms"] for row in rows],
            place,
            "o",
            color=COLOURS["blue"],
            label="found",
        )
        ax.plot(
            [row["speed_rms_without_rocking_mps"] for row in rows],
            place,
            "D",
            markerfacecolor="none",
            color=COLOURS["vermilion"],
            label="rocking taken off",
        )
        ax.set_yticks(place, names)
        ax.set_xlim(0, None)
        ax.set_xlabel("root mean square error of the speed, m/s")
        figure.legend(loc="outside lower center", ncols=4)
    return figure


def plot_wheels_and_frame(series: Mapping[str, Numbers]) -> Figure:
    """Plot speed and both yaw rates of drives; shaded where a wheel's gyroscope is at its limit.

    Parameters
    ----------
    series : title -> ``time_s``, ``speed_mps``, ``frame_degps``, ``wheels_degps``, ``usable``
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(
            2, len(series), figsize=(8.6, 4.5), sharex="col", sharey="row", squeeze=False
        )
        for (top, bottom), (title, one) in zip(axes.T, series.items(), strict=True):
            time_s = one["time_s"]
            top.plot(time_s, one["speed_mps"], color="black", linestyle="-")
            top.set_title(title)
            bottom.plot(time_s, one["frame_degps"], color="black", linestyle="-", label="frame")
            bottom.plot(
                time_s,
                one["wheels_degps"],
                color=COLOURS["vermilion"],
                linestyle="--",
                label="wheels",
            )
            for ax in (top, bottom):
                limit = np.asarray(one["usable"]) < 1
                ax.fill_between(
                    time_s,
                    0,
                    1,
                    where=limit,
                    transform=ax.get_xaxis_transform(),
                    color="#DDDDDD",
                    linewidth=0,
                    label="a wheel's gyroscope is at its limit" if limit.any() else None,
                )
            bottom.set_xlabel("time, s")
        axes[0, 0].set_ylabel("speed, m/s")
        axes[1, 0].set_ylabel("yaw rate, deg/s")
        handles, names = axes[1, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure


def plot_tracks(rows: Sequence[Numbers]) -> Figure:
    """Plot the track that each drive in circles shows, by the straight drive that calibrated.

    Parameters
    ----------
    rows : of the record of the drives; those without ``tracks_by_calibration`` are left out
    """
    import matplotlib.pyplot as plt

    judged = [row for row in rows if row["tracks_by_calibration"]]
    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 3.4))
        for k, line_name in enumerate(judged[0]["tracks_by_calibration"]):
            found = [row["tracks_by_calibration"][line_name] for row in judged]
            look = cue(k)
            ax.errorbar(
                np.arange(len(judged)) + 0.15 * (k - 1),
                [1000 * one["track_m"] for one in found],
                yerr=[1000 * INSIDE * one["track_sd_m"] for one in found],
                linestyle="none",
                color=look["color"],
                marker=look["marker"],
                capsize=3,
                label=f"calibrated on {line_name.replace('_', ' ')}",
            )
        at = np.arange(len(judged))
        by_hand = [1000 * row["track_by_hand_m"] for row in judged]
        ax.hlines(by_hand, at - 0.21, at + 0.21, color="black", linewidth=2, label="by hand")
        ax.set_xticks(range(len(judged)), [row["drive"].replace("_", " ") for row in judged])
        ax.set_xlim(-0.5, len(judged) - 0.5)
        ax.set_ylabel("track, mm")
        figure.legend(loc="outside right upper")
    return figure
