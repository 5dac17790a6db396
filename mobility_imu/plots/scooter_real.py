"""Figures of hinged chains that others recorded with a reference; drawn from the records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.plots.drawing import WIDTH_IN, arc, blank, box, disc, label, line
from mobility_imu.plots.style import COLOURS, cue, use_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Numbers = Mapping[str, Any]
ANGLES = ("steering", "throttle")
BAND = "#DCE9F5"
"""Shade of a stated 95 % interval."""
QUANTILE_95 = 1.96
IMU = (0.17, 0.1)
"""Length and height of a drawn IMU."""


def draw_chains() -> Figure:
    """Draw the scooter's controls, the chain in the hand, and the hinge on a motor."""
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, 3, figsize=(WIDTH_IN, 2.7))
        for ax, draw, title in zip(
            axes,
            (_draw_controls, _draw_chain, _draw_motor),
            ("a scooter's controls", "two hinges in the hand", "one hinge on a motor"),
            strict=True,
        ):
            draw(ax)
            ax.set_title(title, loc="center")
            blank(ax, (-0.85, 0.85), (-0.72, 0.82))
    return figure


def _draw_controls(ax: Axes) -> None:
    line(ax, [(-0.7, -0.6), (0.2, -0.6), (0.02, 0.3)], linewidth=4, color="#777777")
    line(ax, [(0.02, 0.3), (-0.32, 0.42)], linewidth=4, color="#777777")
    disc(ax, (0.02, 0.3), 0.05, facecolor="white")
    _name_imu(ax, (-0.42, -0.53), 0.0, "body", (-0.42, -0.36), "blue")
    _name_imu(ax, (-0.25, 0.47), -0.34, "lever", (-0.5, 0.62), "vermilion")
    arc(ax, (0.1, -0.1), (0.22, 0.08), np.deg2rad(200), np.deg2rad(340), arrowhead=True)
    label(ax, (0.55, -0.1), "steering")
    arc(ax, (0.02, 0.3), 0.26, np.deg2rad(100), np.deg2rad(20), arrowhead=True)
    label(ax, (0.5, 0.52), "throttle")


def _draw_chain(ax: Axes) -> None:
    line(ax, [(-0.75, -0.45), (-0.2, -0.2), (0.2, 0.12), (0.3, 0.62)], linewidth=5, color="#777777")
    for place in ((-0.2, -0.2), (0.2, 0.12)):
        disc(ax, place, 0.06, facecolor="white")
    _name_imu(ax, (-0.52, -0.27), 0.46, "body", (-0.62, -0.08), "blue")
    _name_imu(ax, (0.18, 0.42), 1.37, "lever", (-0.12, 0.5), "vermilion")
    label(ax, (0.16, -0.34), "steering")
    label(ax, (0.56, 0.08), "throttle")
    for x, y in ((-0.72, -0.52), (0.36, 0.66)):
        disc(ax, (x, y), 0.035, facecolor=COLOURS["green"])
    label(ax, (0.1, -0.6), "markers on all segments", COLOURS["green"])


def _draw_motor(ax: Axes) -> None:
    box(ax, (-0.1, -0.4), (0.5, 0.3))
    label(ax, (-0.1, -0.66), "motor and encoder", COLOURS["green"])
    line(ax, [(-0.1, -0.4), (-0.1, 0.1), (0.35, 0.5)], linewidth=4, color="#777777")
    disc(ax, (-0.1, 0.1), 0.06, facecolor="white")
    _name_imu(ax, (0.18, 0.42), 0.73, "lever", (-0.1, 0.55), "vermilion")
    _name_imu(ax, (-0.42, -0.3), np.pi / 2, "body", (-0.58, -0.06), "blue")
    arc(ax, (-0.1, 0.1), 0.4, np.deg2rad(20), np.deg2rad(-60), arrowhead=True)
    label(ax, (0.52, 0.12), "throttle")


def _name_imu(
    ax: Axes, at: tuple[float, float], angle: float, name: str, place: tuple[float, float], col: str
) -> None:
    box(ax, at, IMU, angle, facecolor=COLOURS[col], edgecolor="black", zorder=5)
    label(ax, place, name, COLOURS[col])


def plot_chain_errors(series: Mapping[str, Numbers]) -> Figure:
    """Plot both true angles, and the error with its stated 95 % interval in each recording.

    Parameters
    ----------
    series : recording to ``series`` of the record, of one and the same motion
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(
            1 + len(series), 2, figsize=(8.8, 1.3 + 1.5 * len(series)), sharex=True, sharey="row"
        )
        for column, angle in enumerate(ANGLES):
            first = next(iter(series.values()))
            top = axes[0, column]
            top.plot(_clock(first), _numbers(first[angle]["true_deg"]), color="black", lw=1.1)
            top.set_title(angle)
            for ax, (name, one) in zip(axes[1:, column], series.items(), strict=True):
                sd = QUANTILE_95 * _numbers(one[angle]["sd_deg"])
                ax.fill_between(_clock(one), -sd, sd, color=BAND, label="stated 95 %")
                error = _numbers(one[angle]["error_deg"])
                ax.plot(_clock(one), error, color=COLOURS["blue"], ls="-", lw=1.1, label="error")
                ax.text(0.01, 0.97, name, transform=ax.transAxes, va="top", fontsize=9)
            axes[-1, column].set_xlabel("time, s")
        axes[0, 0].set_ylabel("true angle, deg")
        for ax in axes[1:, 0]:
            ax.set_ylabel("error, deg")
        handles = axes[-1, 0].get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=2)
    return figure


def plot_constant_errors(series: Mapping[str, Numbers]) -> Figure:
    """Plot the error of the motorised hinge over the recording and over the shaft's angle.

    Parameters
    ----------
    series : recording to ``series`` of the record
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(8.8, 3.4), sharey=True)
        k = 0
        for name, one in series.items():
            middles = np.array(one["edges_deg"][:-1]) + np.diff(one["edges_deg"]) / 2
            for angle in ANGLES:
                look = cue(k) | {"markersize": 3.5, "label": f"{name}, {angle}"}
                pieces = _numbers(one[angle]["pieces_deg"])
                axes[0].plot(10 * np.arange(len(pieces)) + 5, pieces, **look)
                axes[1].plot(middles, _numbers(one[angle]["bins_deg"]), **look)
                k += 1
        axes[0].set_xlabel("time, s (means of 10 s)")
        axes[1].set_xlabel("true throttle, deg (means of 15 deg)")
        axes[0].set_ylabel("error, deg")
        for ax in axes:
            ax.axhline(0, color="black", linestyle="-", linewidth=0.8)
        handles = axes[0].get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=2)
    return figure


def plot_stated(rows: Sequence[Numbers]) -> Figure:
    """Plot error, stated deviation, and what a filter states that takes all errors for noise.

    Parameters
    ----------
    rows : each with ``what``, ``rms_deg``, ``sd_deg``, ``white_rms_deg`` and ``white_sd_deg``
    """
    import matplotlib.pyplot as plt

    at = np.arange(len(rows))[::-1]
    columns = {
        name: np.array([row[name] for row in rows])
        for name in ("rms_deg", "sd_deg", "white_rms_deg", "white_sd_deg")
    }
    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(8.8, 3.4), sharey=True, sharex=True)
        for ax, title, part in (
            (axes[0], "all errors taken for noise", "white_"),
            (axes[1], "our filter", ""),
        ):
            rms, sd = columns[f"{part}rms_deg"], columns[f"{part}sd_deg"]
            ax.barh(at, 1.5 * rms, left=rms / 2, height=0.62, color="#E3E3E3", label="½ to 2 × rms")
            ax.plot(rms, at, "o", color=COLOURS["blue"], linestyle="none", label="error, rms")
            ax.plot(
                sd, at, "|", color=COLOURS["vermilion"], ms=13, mew=2.6, linestyle="none",
                label="stated sd",
            )  # fmt: skip
            ax.set_xscale("log")
            ax.set_title(title)
            ax.set_xlabel("deg")
            ax.grid(visible=False, axis="y")
        axes[0].set_xticks([0.03, 0.1, 0.3, 1, 3, 10], ["0.03", "0.1", "0.3", "1", "3", "10"])
        axes[0].set_yticks(at, [row["what"] for row in rows])
        handles = axes[0].get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=3)
    return figure


def plot_hinge_spectra(curves: Mapping[str, Numbers], floors: Mapping[str, float]) -> Figure:
    """Plot densities of the specific force over frequency.

    Parameters
    ----------
    curves : name to ``hz`` and ``density``, all axes together
    floors : name to the density of a simulated sensor's white noise, all axes together, m/s²/√Hz
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(8.8, 3.4))
        for k, (name, one) in enumerate(curves.items()):
            ax.loglog(one["hz"], one["density"], label=name, **(cue(k) | {"markersize": 4}))
        for (name, floor), style in zip(floors.items(), ("-", ":"), strict=False):
            ax.axhline(floor, color="black", linestyle=style, linewidth=1.8, label=name)
        ax.set_xticks([1, 2, 5, 10, 20, 40], ["1", "2", "5", "10", "20", "40"])
        ax.minorticks_off()
        ax.set_xlabel("frequency, Hz")
        ax.set_ylabel("specific force, m/s²/√Hz")
        figure.legend(loc="outside right upper")
    return figure


def _clock(one: Numbers) -> Any:
    count = len(one["steering"]["error_deg"])
    return one["start_s"] + one["step_s"] * np.arange(count)


def _numbers(values: Sequence[float | None]) -> Any:
    """Numbers with NaN where the record has none."""
    return np.array(values, float)
