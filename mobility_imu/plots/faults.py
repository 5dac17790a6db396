"""Faults of sensors: a recording with one, the wrong result, and what a study found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.plots.style import COLOURS, use_style

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RIGHT = {"color": "black", "linestyle": ":", "linewidth": 1.8, "label": "without the fault"}
WRONG = {
    "color": COLOURS["vermilion"],
    "linestyle": "-",
    "linewidth": 1.2,
    "label": "with the fault",
}


class Pair(NamedTuple):
    """A quantity without and with a fault.

    Parameters
    ----------
    label : of the axis, with the unit
    right, wrong : (n,) arrays
    """

    label: str
    right: FloatArray
    wrong: FloatArray


class Drawn(NamedTuple):
    """A fault to be drawn.

    Parameters
    ----------
    title : what is wrong
    time_s : (n,) array
    reading : Pair of what the sensor says
    result : Pair of what comes out
    """

    title: str
    time_s: FloatArray
    reading: Pair
    result: Pair


def draw_faults(faults: Sequence[Drawn]) -> Figure:
    """Draw each fault in a row: the reading on the left, the result on the right.

    Parameters
    ----------
    faults : Drawn, one for a row

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplots(
            len(faults), 2, figsize=(8.6, 0.4 + 1.9 * len(faults)), squeeze=False
        )
        for row, fault in zip(axes, faults, strict=True):
            for ax, pair in zip(row, (fault.reading, fault.result), strict=True):
                _draw(ax, fault.time_s, pair)
            row[0].set_title(fault.title)
        for ax in axes[-1]:
            ax.set_xlabel("time, s")
        handles = axes[0, 1].get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=2)
    return figure


def _draw(ax: Axes, time_s: FloatArray, pair: Pair) -> None:
    ax.plot(time_s, pair.wrong, **WRONG)
    ax.plot(time_s, pair.right, **RIGHT)
    ax.set_ylabel(pair.label)


def draw_percentages(counts: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw the percentage of the faults that matter and are reported, by kind and device.

    Parameters
    ----------
    counts : device to its :func:`~mobility_imu.reproduction.faults.fault_counts`

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        tallest = max(len(table) for table in counts.values())
        figure, axes = plt.subplots(
            1, len(counts), figsize=(10.5, 0.9 + 0.24 * tallest), squeeze=False
        )
        for ax, (device, table) in zip(axes[0], counts.items(), strict=True):
            seen = table[table["matter"] > 0]
            seen = seen.assign(part=100 * seen["told"] / seen["matter"]).sort_values("part")
            places = np.arange(len(seen)) + tallest - len(seen)
            ax.barh(places, 100, color="#E8E8E8", height=0.7)
            full = seen["part"] >= 98
            for chosen, colour, hatch in ((full, "blue", ""), (~full, "orange", "///")):
                ax.barh(
                    places[chosen], seen["part"][chosen], color=COLOURS[colour], hatch=hatch,
                    edgecolor="white", height=0.7,
                )  # fmt: skip
            ax.set_yticks(places, [f"{kind} ({n})" for kind, n in seen["matter"].items()])
            ax.tick_params(axis="y", labelsize=8, length=0)
            ax.set(xlim=(0, 100), ylim=(-0.6, tallest - 0.4), xlabel="reported, %", title=device)
            ax.grid(visible=False, axis="y")
    return figure
