"""Figures of the scooter's limits, and of Table 1 beside fitted models."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.plots.style import COLOURS, cue, use_style
from mobility_imu.scooter.geometry import ScooterGeometry, body_specific_force
from mobility_imu.scooter.sensitivity import (
    Sensitivities,
    mirror_angles,
    sensitivities,
    single_imu_range,
    worst_error_per_tilt,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

WHITE: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85}
SHADES = ("#FFFFFF", "#FCE3D3", "#F2B48C", "#DE7F42", "#A34700")


def plot_costs(geometry: ScooterGeometry, *, pressed_rad: float, lock_rad: float) -> Figure:
    """Plot what one degree of each error costs both angles over the range of the wheel.

    Parameters
    ----------
    geometry : ScooterGeometry
    pressed_rad : rad, throttle angle of the right panels; the left ones have the lever at rest
    lock_rad : rad, end of the wheel's range

    Returns
    -------
    Figure with four panels: steering above, throttle below
    """
    import matplotlib.pyplot as plt

    wheel = np.linspace(-lock_rad, lock_rad, 101)
    errors: tuple[tuple[str, Callable[[Sensitivities], FloatArray]], ...] = (
        ("lever IMU about y", lambda s: s.lever_mounting[..., 1]),
        ("lever IMU about z", lambda s: s.lever_mounting[..., 2]),
        ("body IMU about y", lambda s: s.body_mounting[..., 1]),
        ("alpha", lambda s: s.steering_inclination[..., 0]),
        ("beta, lever IMU about x", lambda s: -s.lever_mounting[..., 0]),
    )
    with use_style():
        figure, panels = plt.subplots(2, 2, figsize=(8.6, 6.0), sharex=True, sharey="row")
        for column, (throttle, words) in enumerate(
            ((0.0, "lever at rest"), (pressed_rad, f"lever at {np.rad2deg(pressed_rad):.0f}°"))
        ):
            s = sensitivities(0.0, 0.0, wheel, throttle, geometry, imus="dual")
            for row, angle in enumerate(("steering", "throttle")):
                ax = panels[row, column]
                for index, (label, pick) in enumerate(errors):
                    look = cue(index) | {"marker": None}
                    ax.plot(np.rad2deg(wheel), np.abs(pick(s)[..., row]), label=label, **look)
                ax.set_title(f"{angle}, {words}")
                ax.set_xlabel("steering, deg")
                ax.set_ylabel("|error|, deg per deg")
                ax.set_ylim(bottom=-0.1)
        panels[1, 0].legend(loc="upper center")
        panels[1, 0].set_ylim(-0.1, 2.6)
    return figure


def plot_budget(
    steering_rad: FloatArray,
    parts_rad: Mapping[str, FloatArray],
    total_rad: FloatArray,
    drawn_rad: tuple[FloatArray, FloatArray],
) -> Figure:
    """Plot the sd of both angles by cause over the range of the wheel, and drawn scooters as dots.

    Parameters
    ----------
    steering_rad : (n,) array, rad
    parts_rad : for each cause an (n, 2) array, rad, sd of steering and throttle by it alone
    total_rad : (n, 2) array, rad, of all causes
    drawn_rad : (m,) steering angles and (m, 2) sd of drawn scooters there, rad

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, panels = plt.subplots(1, 2, figsize=(8.6, 4.2), sharex=True)
        for k, (ax, angle) in enumerate(zip(panels, ("steering", "throttle"), strict=True)):
            for index, (label, sd) in enumerate(parts_rad.items()):
                look = cue(index) | {"marker": None}
                ax.plot(np.rad2deg(steering_rad), np.rad2deg(sd[:, k]), label=label, **look)
            ax.plot(
                np.rad2deg(steering_rad),
                np.rad2deg(total_rad[:, k]),
                color="black",
                linestyle="-",
                linewidth=2.4,
                label="all, first order",
            )
            at, sd = drawn_rad
            ax.plot(
                np.rad2deg(at),
                np.rad2deg(sd[:, k]),
                "o",
                color="black",
                mfc="white",
                label="all, random scooters",
            )
            ax.set_title(angle)
            ax.set_xlabel("steering, deg")
            ax.set_ylabel("standard deviation, deg")
            ax.set_ylim(bottom=0)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def plot_domain(geometry: ScooterGeometry, *, lock_rad: float) -> Figure:
    """Map over pitch and roll: where one IMU saturates, and what a tilt costs with two.

    Parameters
    ----------
    geometry : ScooterGeometry
    lock_rad : rad, the wheel turns this far to either side

    Returns
    -------
    Figure with two panels
    """
    import matplotlib.pyplot as plt

    axis_deg = np.linspace(-15, 15, 121)
    pitch_deg, roll_deg = np.meshgrid(axis_deg, axis_deg)
    pitch, roll = np.deg2rad(pitch_deg), np.deg2rad(roll_deg)
    right, left = single_imu_range(pitch, roll, geometry)
    room = np.rad2deg(np.minimum(left, -right))
    cost = worst_error_per_tilt(body_specific_force(pitch, roll), geometry, lock_rad=lock_rad)
    with use_style():
        figure, (first, second) = plt.subplots(1, 2, figsize=(8.8, 4.4), sharey=True)
        bands = first.contourf(
            pitch_deg,
            roll_deg,
            np.clip(room, 0, 89.9),
            levels=[0, 30, 40, 50, 60, 90],
            colors=SHADES[::-1],
            hatches=["...", "xx", "//", "", ""],
        )
        figure.colorbar(bands, ax=first, label="smallest steering that saturates, deg")
        first.set_title("one IMU: saturation")
        bands = second.contourf(
            pitch_deg,
            roll_deg,
            np.minimum(cost, 99),
            levels=[0, 5, 7.5, 10, 20, 100],
            colors=SHADES,
            hatches=["", "", "//", "xx", "..."],
        )
        figure.colorbar(
            bands, ax=second, label="worst steering error, deg per deg of tilt"
        ).set_ticks([0, 5, 7.5, 10, 20], labels=["0", "5", "7.5", "10", "20"])
        second.set_title("two IMUs: cost of a tilted lever IMU")
        for ax in (first, second):
            for x, y, label in ((7, 0, "7° up"), (-5, 0, "5° down"), (0, 7, "7° side")):
                ax.plot(x, y, "P", color=COLOURS["blue"], markersize=8, mec="white")
                ax.text(x + 0.7, y + 0.6, label, color="#00537F", bbox=WHITE)
            ax.set_xlabel("pitch, deg (nose up is positive)")
            ax.grid(visible=False)
        first.set_ylabel("roll, deg (right side higher is positive)")
    return figure


def plot_mirror(geometry: ScooterGeometry, *, lock_rad: float) -> Figure:
    """Plot the wheel angle of the mirror image against the true one, on several slopes.

    Parameters
    ----------
    geometry : ScooterGeometry
    lock_rad : rad, the wheel turns this far to either side

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    true_deg = np.linspace(-50, 50, 201)
    lock_deg = float(np.rad2deg(lock_rad))
    slopes = (
        ("level", 0, 0),
        ("7° side", 0, 7),
        ("5° down, 10° side", -5, 10),
        ("10° down, 10° side", -10, 10),
        ("10° down, 15° side", -10, 15),
    )
    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 4.4))
        ax.axhspan(-lock_deg, lock_deg, color="#EFEFEF", zorder=0)
        ax.text(18, -lock_deg + 8, "range of the wheel", color="#555555")
        for label, pitch, roll in slopes:
            body = body_specific_force(*np.deg2rad([pitch, roll]))
            other, _ = mirror_angles(body, np.deg2rad(true_deg), 0.0, geometry)
            ax.plot(true_deg, np.rad2deg(np.mod(other, 2 * np.pi)), label=label)
        ax.plot(true_deg, true_deg, color="#6E6E6E", linestyle="-", linewidth=1)
        ax.text(-27, -21, "true", color="#555555", rotation=14)
        ax.set_xlabel("true steering, deg")
        ax.set_ylabel("steering of the mirror image, deg")
        ax.set_ylim(-lock_deg - 2, 235)
        ax.legend(loc="upper right", ncols=2)
    return figure


def plot_cells(published_deg: FloatArray, models_deg: Mapping[str, FloatArray]) -> Figure:
    """Plot all 50 MAE and 50 SD of Table 1 against each model's.

    Parameters
    ----------
    published_deg : (5, 5, 4) array, deg: row, column, quantity
    models_deg : for each model an array of the same shape

    Returns
    -------
    Figure with one column of panels per model, MAE above, SD below
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, panels = plt.subplots(
            2, len(models_deg), figsize=(2.1 * len(models_deg), 4.9), sharex="row", sharey="row"
        )
        for column, (name, table) in enumerate(models_deg.items()):
            for row, (what, top) in enumerate((("MAE", 23.0), ("SD", 15.0))):
                ax = panels[row, column]
                line = np.linspace(0, top, 200)
                ax.fill_between(
                    line, np.maximum(line - 1, 0), line + 1, color="#E4E4E4", zorder=0, linewidth=0
                )
                for mode, quantity, look in (
                    ("one IMU", row, {"marker": "o", "color": COLOURS["blue"]}),
                    (
                        "two IMUs",
                        row + 2,
                        {"marker": "s", "color": COLOURS["vermilion"], "mfc": "none"},
                    ),
                ):
                    ax.plot(
                        published_deg[..., quantity].ravel(),
                        table[..., quantity].ravel(),
                        linestyle="none",
                        markersize=4,
                        clip_on=False,
                        zorder=3,
                        label=mode,
                        **look,
                    )
                ticks = [0, 1, 2, 5, 10, 20] if row == 0 else [0, 1, 2, 5, 10]
                for axis in ("x", "y"):
                    getattr(ax, f"set_{axis}scale")("function", functions=(_root, np.square))
                    getattr(ax, f"set_{axis}lim")(0, top)
                    getattr(ax, f"set_{axis}ticks")(ticks)
                if row == 0:
                    ax.set_title(name)
                if column == 0:
                    ax.set_ylabel(f"{what} of the model, deg")
                ax.set_xlabel(f"the paper's {what}, deg")
        panels[0, 0].legend(loc="upper left", handletextpad=0.1, borderaxespad=0.1)
    return figure


def _root(values: FloatArray) -> FloatArray:
    return np.sqrt(np.maximum(values, 0))


def plot_controls(controls: pd.DataFrame) -> Figure:
    """Plot the cost of the paper's table and of shuffled ones.

    Parameters
    ----------
    controls : what ``reproduction.scooter.table1_fit.shuffle_controls`` gives

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 2.6))
        kinds = list(dict.fromkeys(controls["table"]))
        for place, kind in enumerate(kinds):
            cost = np.sort(controls.loc[controls["table"] == kind, "cost"])
            look = cue(place) | {"linestyle": "none", "markersize": 8}
            ax.plot(cost, np.full(len(cost), -place), mfc="none" if place else None, **look)
        ax.set_xscale("log")
        ax.set_xticks([50, 100, 200, 500, 1000], labels=["50", "100", "200", "500", "1000"])
        ax.set_xticks([], minor=True)
        ax.set_yticks([-k for k in range(len(kinds))])
        names = ["the paper's table", *(f"{kind} shuffled" for kind in kinds[1:])]
        ax.set_yticklabels(names)
        ax.set_ylim(-len(kinds) + 0.5, 0.5)
        ax.set_xlabel("cost of the best fit (squared residuals over variances, with priors), 1")
    return figure


def plot_parameters(narrow: pd.DataFrame, wide: pd.DataFrame) -> Figure:
    """Plot fitted nuisances with their sd: of the chain, and with rival causes admitted.

    Parameters
    ----------
    narrow, wide : what ``TableFit.parameters`` gives; those of ``narrow`` are shown

    Returns
    -------
    Figure
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(7.2, 5.6))
        place = -np.arange(len(narrow))
        prior = narrow["prior_sd_deg"].to_numpy()
        low = np.where(narrow.index.str.endswith("noise"), 0.0, -prior)
        ax.barh(place, prior - low, left=low, height=0.7, color="#E9E9E9", label="prior, ± 1 sd")
        for shift, table, label, look in (
            (0.15, narrow, "chain, ± 1 sd", {"marker": "o", "color": COLOURS["blue"]}),
            (
                -0.15,
                wide.loc[narrow.index],
                "with rivals, ± 1 sd",
                {"marker": "s", "color": COLOURS["vermilion"], "mfc": "none"},
            ),
        ):
            ax.errorbar(
                table["value_deg"],
                place + shift,
                xerr=table["sd_deg"],
                linestyle="none",
                capsize=2,
                label=label,
                **look,
            )
        ax.axvline(0, color="black", linewidth=0.8, linestyle="-")
        ax.set_yticks(place, list(narrow.index))
        ax.set_xlabel("deg")
        ax.grid(visible=False, axis="y")
        figure.legend(loc="outside lower center", ncols=3)
    return figure
