"""Drawings of the scooter under test: sensors, controls, measuring chain, static conditions.

They are drawn from the captions and the text of Suzurikawa et al. (2022), Figures 1, 3 and 4; the
originals were not seen. Overall sizes, alpha and beta are the paper's; every other size and shape
is assumed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.plots.drawing import (
    BODY,
    GREY,
    SMALL_PT,
    WIDTH_IN,
    arc,
    arrow,
    blank,
    box,
    dimension,
    direction,
    disc,
    label,
    line,
    number,
    shape,
)
from mobility_imu.plots.style import COLOURS, use_style
from mobility_imu.scooter.geometry import ScooterGeometry

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mobility_imu.frames import FloatArray

LENGTH_M, WIDTH_M, HEIGHT_M = 1.195, 0.650, 0.980
"""Length, width and height of the scooter's body, m (section 2.1)."""
STEER, PUSH, TRUE = COLOURS["vermilion"], COLOURS["blue"], COLOURS["green"]
BAR: dict[str, Any] = {"color": "#9A9A9A", "linewidth": 5}
SENSORS = (
    "IMU on the throttle lever: gives both angles",
    "IMU in the front basket, which is fixed to the body",
    "disc on the shaft, with wire sensor: true steering",
    "disc on the lever's axis, with wire sensor: true throttle",
    "Hall sensor, magnets on the rear wheel: speed, common time",
)
"""What the numbers in the side view mean, in their order."""
INCLINATIONS = ("1 flat", "2 upward", "3 downward", "4 left side\nslope", "5 right side\nslope")
STATUSES = (
    "a\nlever at\nrest",
    "b\nlever\npressed",
    "c\nwheel\nneutral",
    "d\nwheel\nleft",
    "e\nwheel\nright",
)


def draw_scooter(geometry: ScooterGeometry) -> Figure:
    """Draw the scooter from its right with its sizes, and number its five sensors.

    Parameters
    ----------
    geometry : ScooterGeometry, for the lean of shaft and lever

    Returns
    -------
    Figure, lengths in m, forward to the right; the outline is 1.195 m long and 0.980 m high
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 6.2))
        _draw_body(ax)
        foot, top = _draw_shaft(ax, geometry)
        lever = _draw_lever_and_basket(ax, geometry, top)
        alpha = geometry.steering_inclination_rad
        across = direction(alpha)
        number(ax, (0.52, 1.12), "1", lever)
        number(ax, (1.36, 0.76), "2", (1.10, 0.60))
        disc_at = top - 0.13 * (top - foot) / np.linalg.norm(top - foot)
        number(ax, (0.40, 0.72), "3", disc_at - 0.05 * across)
        number(ax, (1.15, 1.08), "4", top + 0.045 * across + [0.0, 0.012])
        number(ax, (0.42, 0.07), "5", (0.24, 0.14))
        dimension(ax, (0, -0.12), (LENGTH_M, -0.12), "1195 mm", gid="length")
        dimension(ax, (-0.12, 0), (-0.12, HEIGHT_M), "980\nmm", gid="height")
        for z in (0, HEIGHT_M):
            line(ax, [(-0.16, z), (-0.03, z)], color=GREY, linewidth=0.8)
        label(ax, (LENGTH_M / 2, -0.23), "(from side to side: 650 mm)", GREY)
        arrow(ax, (1.22, 0.05), (1.42, 0.05), GREY)
        label(ax, (1.33, 0.11), "forward", GREY)
        for k, text in enumerate(SENSORS, start=1):
            y = -0.26 - 0.105 * k
            number(ax, (-0.08, y), str(k))
            ax.text(-0.02, y, text, va="center", fontsize=SMALL_PT)
        blank(ax, (-0.20, 1.46), (-0.86, 1.18))
    return figure


def _draw_body(ax: Axes) -> None:
    """Draw wheels, deck, seat and floor; together they reach from 0 to the front wheel."""
    line(ax, [(-0.16, 0), (1.44, 0)], color=GREY, linewidth=1)
    for x in (0.15, 0.97):
        disc(ax, (x, 0.14), 0.14, facecolor="#D9D9D9", zorder=3)
        disc(ax, (x, 0.14), 0.05, facecolor="white", zorder=3)
    for angle in np.deg2rad([0, 90, 180, 270]):
        ax.plot(*([0.15, 0.14] + 0.09 * direction(angle)), "s", color=TRUE, markersize=4, zorder=4)
    box(ax, (0.27, 0.14), (0.035, 0.05), 0.0, edgecolor=TRUE)
    deck = [(0.0, 0.42), (0.36, 0.42), (0.42, 0.24), (0.76, 0.24), (0.85, 0.40), (1.12, 0.40)]
    under = [(1.12, 0.33), (0.88, 0.32), (0.79, 0.18), (0.40, 0.18), (0.33, 0.30), (0.0, 0.30)]
    shape(ax, deck + under, gid="body")
    shape(ax, [(0.04, 0.50), (0.38, 0.50), (0.38, 0.56), (0.04, 0.56)])
    shape(ax, [(0.05, 0.56), (0.0, 0.92), (0.06, 0.93), (0.12, 0.56)])
    line(ax, [(0.2, 0.42), (0.2, 0.50)], **BAR)


def _draw_shaft(ax: Axes, geometry: ScooterGeometry) -> tuple[FloatArray, FloatArray]:
    """Draw the steering shaft, its lean and the steering wheel edge-on; give its two ends."""
    alpha = geometry.steering_inclination_rad
    up = direction(np.pi / 2 + alpha)
    across = direction(alpha)
    foot = np.array([0.985, 0.36])
    top = foot + 0.57 * up
    line(ax, [foot, top], color="#A8A8A8", linewidth=9, zorder=1)
    line(ax, [foot - 0.04 * up, top + 0.16 * up], color=STEER, linestyle="--", gid="shaft")
    line(ax, [foot, np.add(foot, [0, 0.74])], color=GREY, linestyle=":", gid="vertical")
    arc(ax, foot, 0.66, np.pi / 2, np.pi / 2 + alpha)
    label(
        ax,
        foot + 0.73 * direction(np.pi / 2 + 0.45 * alpha),
        rf"$\alpha$ = {np.rad2deg(alpha):.0f}°",
    )
    line(ax, [top - 0.17 * across, top + 0.09 * across], **BAR)
    disc_at = top - 0.13 * up
    line(ax, [disc_at - 0.055 * across, disc_at + 0.055 * across], color=TRUE, linewidth=4)
    return foot, top


def _draw_lever_and_basket(ax: Axes, geometry: ScooterGeometry, top: FloatArray) -> FloatArray:
    """Draw the lever with its IMU, and the basket with the body's; give the lever IMU's place."""
    beta = geometry.lever_inclination_rad
    across = direction(geometry.steering_inclination_rad)
    hinge = top + 0.045 * across
    blade = direction(np.pi / 2 + beta)
    tip = hinge + (HEIGHT_M - hinge[1]) / blade[1] * blade
    line(ax, [hinge, tip], color="#777777", linewidth=4, gid="lever", solid_capstyle="butt")
    disc(ax, hinge, 0.022, facecolor="white", edgecolor=TRUE, linewidth=2, zorder=4)
    imu = hinge + 0.55 * (tip - hinge)
    box(ax, imu, (0.055, 0.028), beta, edgecolor=PUSH, zorder=6)
    line(ax, [(1.06, 0.40), (1.06, 0.50)], **BAR)
    basket = [(1.005, 0.50), (1.18, 0.50), (LENGTH_M, 0.70), (0.99, 0.70)]
    shape(ax, basket, facecolor="none", edgecolor="#B5B5B5", hatch="xx", gid="basket")
    box(ax, (1.09, 0.60), (0.07, 0.035), edgecolor="black")
    return np.asarray(imu)


def draw_controls(geometry: ScooterGeometry, *, throttle_rad: float) -> Figure:
    """Draw wheel and levers as the driver sees them, the lever from its right, a disc with wire.

    Parameters
    ----------
    geometry : ScooterGeometry
    throttle_rad : float, rad, how far the lever is drawn pushed

    Returns
    -------
    Figure with three panels
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, axes = plt.subplot_mosaic(
            [["wheel", "wheel"], ["lever", "disc"]],
            figsize=(WIDTH_IN, 5.9),
            height_ratios=[1.05, 1],
        )
        _draw_wheel(axes["wheel"])
        _draw_lever(axes["lever"], geometry, throttle_rad)
        _draw_disc(axes["disc"])
        for name, title in (
            ("wheel", "(1) Along the shaft, from above; forward is up"),
            ("lever", "(2) Lever, from the right"),
            ("disc", "(3) Disc and wire"),
        ):
            axes[name].set_title(title)
    return figure


def _draw_wheel(ax: Axes) -> None:
    from matplotlib.patches import FancyBboxPatch

    loop = {"facecolor": "none", "edgecolor": "#9A9A9A", "linewidth": 9, "zorder": 2}
    style = "round,pad=0.02,rounding_size=0.09"
    ax.add_patch(FancyBboxPatch((-0.21, -0.10), 0.42, 0.18, boxstyle=style, **loop))
    panel = {**BODY, "boxstyle": "round,pad=0.01", "zorder": 3}
    ax.add_patch(FancyBboxPatch((-0.08, -0.10), 0.16, 0.17, **panel))
    label(ax, (0, -0.05), "panel", bbox=None)
    line(ax, [(-0.21, 0.03), (0.21, 0.03)], color=PUSH, linestyle="--", zorder=4, gid="lever axis")
    for side in (-1, 1):
        box(ax, (side * 0.155, 0.03), (0.09, 0.022), facecolor="#777777", edgecolor="#777777")
        arrow(ax, (side * 0.115, 0.045), (side * 0.115, 0.15), PUSH)
    box(ax, (0.175, 0.03), (0.05, 0.04), edgecolor=PUSH, zorder=7)
    ax.plot(0, 0, "o", color=STEER, markersize=5, zorder=7)
    turn = 0.30
    for middle in (np.pi, 0.0):
        for half in (0.45, -0.45):
            arc(ax, (0, 0), turn, middle - half, middle + half, colour=STEER, arrowhead=True)
    label(ax, (0.40, 0.20), r"wheel $\theta_S$" + "\nabout ±50°", STEER)
    label(ax, (0, 0.19), r"both levers $\theta_T$, about 40°", PUSH)
    for place, text, target in (
        ((0.40, -0.20), "lever IMU", (0.19, 0.02)),
        ((-0.40, 0.20), "common axis\nof the levers", (-0.10, 0.03)),
        ((-0.36, -0.21), "bars on the driver's\nside, for the palms", (-0.14, -0.12)),
    ):
        line(ax, np.array([place, target]), color=GREY, linewidth=0.9, zorder=7)
        label(ax, place, text, fontsize=SMALL_PT)
    label(ax, (0.06, -0.21), "driver", GREY)
    blank(ax, (-0.56, 0.54), (-0.26, 0.25))


def _draw_lever(ax: Axes, geometry: ScooterGeometry, throttle_rad: float) -> None:
    beta = geometry.lever_inclination_rad
    hinge = np.zeros(2)
    disc(ax, (-0.6, 0.28), 0.15, facecolor="#C9C9C9")
    label(ax, (-0.62, -0.05), "bar under\nthe palm", GREY, fontsize=SMALL_PT)
    for name, turn, look in (("rest", 0.0, "-"), ("pushed", -throttle_rad, "--")):
        up = direction(np.pi / 2 + beta + turn)
        line(
            ax,
            [hinge, 1.05 * up],
            color="#777777",
            linewidth=5 if look == "-" else 2,
            linestyle=look,
            gid=f"lever {name}",
        )
        box(ax, 0.72 * up, (0.34, 0.17), beta + turn, edgecolor=PUSH, linestyle=look)
    disc(ax, hinge, 0.09, facecolor="white", edgecolor="black", zorder=6)
    start = np.pi / 2 + beta
    arc(ax, hinge, 1.2, start, start - throttle_rad, colour=PUSH, arrowhead=True, gid="throttle")
    label(ax, 1.42 * direction(start - throttle_rad / 2), r"$\theta_T$", PUSH)
    label(ax, (-0.28, 1.28), "at rest", GREY, fontsize=SMALL_PT)
    label(ax, (0.98, 0.80), "pushed", GREY, fontsize=SMALL_PT)
    arrow(ax, (0.55, -0.15), (1.25, -0.15), GREY)
    label(ax, (0.9, -0.32), "forward", GREY, fontsize=SMALL_PT)
    blank(ax, (-1.05, 1.4), (-0.45, 1.6))


def _draw_disc(ax: Axes) -> None:
    """Draw how a disc turns an angle into a length of wire."""
    radius, turn = 0.62, np.deg2rad(50)
    disc(ax, (0, 0), radius, facecolor="#EAF5F0", edgecolor=TRUE, linewidth=2)
    disc(ax, (0, 0), 0.09, facecolor="white", edgecolor="black", zorder=4)
    line(ax, [(0, -radius), (1.35, -radius)], color=TRUE, linewidth=2)
    box(ax, (1.5, -radius + 0.06), (0.45, 0.42), edgecolor=TRUE)
    label(ax, (1.38, -radius - 0.38), "wire sensor", TRUE, fontsize=SMALL_PT)
    arc(ax, (0, 0), radius, -np.pi / 2 - turn, -np.pi / 2, colour=TRUE, linewidth=5, gid="wound")
    for angle in (-np.pi / 2, -np.pi / 2 - turn):
        spoke = np.array([[0, 0], radius * direction(angle)])
        line(ax, spoke, color=GREY, linewidth=1, linestyle=":")
    label(ax, 0.36 * direction(-np.pi / 2 - turn / 2), r"$\theta$")
    label(ax, (-0.12, 0.32), "disc", TRUE, fontsize=SMALL_PT)
    label(ax, (0.45, 1.02), r"wire wound: $R\,\theta$", TRUE)
    label(ax, (0.35, -0.25), r"$R$")
    line(ax, np.array([[0, 0], radius * direction(-0.12)]), linewidth=1)
    blank(ax, (-0.95, 1.95), (-1.2, 1.2))


def draw_measuring_chain() -> Figure:
    """Draw the way from the sensors to the error as a block diagram.

    Returns
    -------
    Figure; on the left what is tested, on the right what it is compared with
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 7.6))
        _block(ax, (1.3, 13.0), (2.3, 1.5), "IMU on\nthe lever", PUSH)
        _block(ax, (3.8, 13.0), (2.3, 1.5), "IMU in\nthe basket", "black")
        _block(ax, (6.25, 13.0), (2.2, 1.5), "Hall sensor\nrear wheel", GREY, dashed=True)
        _block(ax, (8.75, 13.0), (2.4, 1.5), "wire sensors\non both axes", TRUE)
        _block(ax, (2.55, 10.4), (4.8, 1.5), "CAN analyser\n16 bit, 100 Hz", "black")
        _block(ax, (8.75, 10.4), (2.4, 1.5), "data logger\n100 Hz", TRUE)
        clocks = "one time for both records,\nfrom the pulses of the Hall sensor"
        _block(ax, (5.0, 7.9), (9.8, 1.4), clocks, GREY, dashed=True)
        _block(ax, (1.5, 5.1), (2.7, 2.0), "eqs (6), (7)\nsingle IMU\nbody: 0, 0, g", PUSH)
        _block(ax, (4.7, 5.1), (2.9, 2.0), "eqs (6), (7)\ndual IMUs\nbody: measured", "black")
        _block(ax, (8.5, 5.1), (2.8, 2.0), "wire length\nto angle", TRUE)
        _block(ax, (5.0, 1.5), (9.8, 1.3), "error = estimated angle − true angle", STEER)
        for x, text in ((1.3, "acceleration"), (3.8, "acceleration"), (8.75, "voltage")):
            _flow(ax, (x, 12.25), (x, 11.15), text)
        _flow(ax, (6.25, 12.25), (6.25, 8.6), "pulses", dashed=True)
        _flow(ax, (2.55, 9.65), (2.55, 8.6))
        _flow(ax, (8.75, 9.65), (8.75, 8.6))
        _flow(ax, (1.5, 7.2), (1.5, 6.1), "lever")
        _flow(ax, (4.7, 7.2), (4.7, 6.1), "lever and body")
        _flow(ax, (8.5, 7.2), (8.5, 6.1), "both wires")
        for x, text in ((1.5, "estimated"), (4.7, "estimated"), (8.5, "true")):
            _flow(ax, (x, 4.1), (x, 2.15), rf"{text}" + "\n" + r"$\theta_S,\ \theta_T$")
        ax.set_xlim(0, 10)
        ax.set_ylim(0.6, 13.9)
        ax.axis("off")
    return figure


def _block(
    ax: Axes,
    centre: tuple[float, float],
    size: tuple[float, float],
    text: str,
    colour: str,
    *,
    dashed: bool = False,
) -> None:
    look = "--" if dashed else "-"
    box(ax, centre, size, edgecolor=colour, facecolor="#F7F7F7", linestyle=look, zorder=3)
    label(ax, centre, text, bbox=None, fontsize=SMALL_PT)


def _flow(
    ax: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    text: str = "",
    *,
    dashed: bool = False,
) -> None:
    arrow(ax, start, end, GREY, linewidth=1.4, linestyle="--" if dashed else "-")
    if text:
        middle = (np.asarray(start) + np.asarray(end)) / 2
        ground = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
        label(ax, np.add(middle, [0, 0.08]), text, fontsize=SMALL_PT, bbox=ground)


def draw_static_conditions(
    geometry: ScooterGeometry,
    *,
    slope_rad: float,
    steering_positions_rad: ArrayLike,
    throttle_positions_rad: ArrayLike,
) -> Figure:
    """Draw the 25 conditions of the static test, arranged as Table 1 is.

    Parameters
    ----------
    geometry : ScooterGeometry, for the lever at rest
    slope_rad : float, rad, of every inclination
    steering_positions_rad : (n,) array, rad, left positive; drawn in columns a and b
    throttle_positions_rad : (m,) array, rad, pushed positive; drawn in columns c, d and e

    Returns
    -------
    Figure; one row per inclination of the body, one column per status of the other control
    """
    import matplotlib.pyplot as plt

    steering = np.asarray(steering_positions_rad, float)
    throttle = np.asarray(throttle_positions_rad, float)
    lock, pressed = float(np.abs(steering).max()), float(throttle.max())
    columns, rows = 3.3 + 1.95 * np.arange(5), -1.85 * np.arange(5)
    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 6.1))
        for column, (x, text) in enumerate(zip(columns, STATUSES, strict=True)):
            label(ax, (x, 3.45), text, fontsize=SMALL_PT)
            if column < 2:
                _lever_sign(ax, np.array([x, 1.9]), geometry, pressed * column)
            else:
                _wheel_sign(ax, np.array([x, 1.9]), (0.0, lock, -lock)[column - 2])
        for row, (y, text) in enumerate(zip(rows, INCLINATIONS, strict=True)):
            label(ax, (-1.6, y), text, fontsize=SMALL_PT)
            _body_sign(ax, np.array([0.6, y]), row, slope_rad)
            for x in columns[:2]:
                _positions(ax, (x, y - 0.55), np.pi / 2 + steering, STEER, "steering")
            for x in columns[2:]:
                rest = np.pi / 2 + geometry.lever_inclination_rad
                _positions(ax, (x, y - 0.55), rest - throttle, PUSH, "throttle")
        bottom = rows[-1] - 1.35
        for x, what, count, colour in (
            (columns[:2].mean(), "steering", len(steering), STEER),
            (columns[2:].mean(), "throttle", len(throttle), PUSH),
        ):
            label(ax, (x, bottom), f"{what} set to\n{count} positions", colour, fontsize=SMALL_PT)
        blank(ax, (-2.8, 12.1), (bottom - 0.6, 4.4))
    return figure


def _body_sign(ax: Axes, at: FloatArray, row: int, slope_rad: float) -> None:
    """Draw a scooter on its slope: from the right for three rows, from behind for two."""
    lean = (0.0, slope_rad, -slope_rad, -slope_rad, slope_rad)[row]
    turn = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])

    def placed(points: ArrayLike) -> FloatArray:
        return np.asarray(np.asarray(points, float) @ turn.T + at)

    line(ax, placed([(-1.0, -0.62), (1.0, -0.62)]), color=GREY, gid=f"ground {row}")
    line(ax, np.add(at, [[-1.0, -0.62], [1.0, -0.62]]), color=GREY, linewidth=0.8, linestyle=":")
    if row < 3:
        deck = [(-0.8, -0.1), (-0.3, -0.1), (-0.2, -0.35), (0.3, -0.35), (0.4, -0.12)]
        for x in (-0.55, 0.5):
            disc(ax, placed([x, -0.42]), 0.19, facecolor="#C9C9C9")
        shape(ax, placed([*deck, (0.7, -0.12), (0.7, -0.27), (-0.8, -0.27)]))
        for foot, top in (((-0.6, -0.1), (-0.72, 0.5)), ((0.5, -0.15), (0.22, 0.6))):
            line(ax, placed([foot, top]), **{**BAR, "linewidth": 3})
    else:
        for x in (-0.42, 0.42):
            box(ax, placed([x, -0.42]), (0.16, 0.4), lean, facecolor="#C9C9C9", edgecolor="#9A9A9A")
        shape(ax, placed([(-0.45, -0.3), (0.45, -0.3), (0.45, -0.05), (-0.45, -0.05)]))
        shape(ax, placed([(-0.3, -0.05), (0.3, -0.05), (0.26, 0.5), (-0.26, 0.5)]))


def _lever_sign(ax: Axes, at: FloatArray, geometry: ScooterGeometry, throttle_rad: float) -> None:
    lean = geometry.lever_inclination_rad - throttle_rad
    up = direction(np.pi / 2 + lean)
    foot = np.add(at, [-0.2, -0.55])
    line(ax, [foot, foot + 1.15 * up], color="#777777", linewidth=4, gid="lever status")
    box(ax, foot + 0.8 * up, (0.5, 0.26), lean, edgecolor=PUSH)
    disc(ax, foot, 0.13, facecolor="white", edgecolor="black", zorder=6)


def _wheel_sign(ax: Axes, at: FloatArray, steering_rad: float) -> None:
    along = 0.62 * direction(steering_rad)
    disc(ax, at, 0.62, facecolor="none", edgecolor="#9A9A9A", linewidth=3)
    line(ax, [at - along, at + along], color=STEER, linewidth=3, gid="wheel status")


def _positions(
    ax: Axes, foot: tuple[float, float], angles_rad: FloatArray, colour: str, name: str
) -> None:
    """Draw the positions of the control that was moved, as a fan of lines."""
    for angle in angles_rad:
        line(ax, np.array([foot, foot + 1.15 * direction(angle)]), color=colour, gid=name)
    ax.plot(*foot, "o", color=colour, markersize=4)
