"""Drawings of the walker's calibration: tilts, distances, triangles, angles, poses.

They follow the captions, the text and the equations of Doan & Pham (2020), Figures 2 to 5; we have
not seen the originals. Shape and size of the walking frame are assumed; the caller gives the place
of the IMU.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray, as_vectors
from mobility_imu.plots.drawing import (
    GREY,
    SMALL_PT,
    WIDTH_IN,
    arc,
    arrow,
    blank,
    box,
    dimension,
    direction,
    label,
    line,
    number,
)
from mobility_imu.plots.style import COLOURS, use_style
from mobility_imu.plots.walker import HEIGHT_M
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection, WalkerGeometry
from mobility_imu.walker.mount import WalkerMount

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARM, CHORD, VELOCITY = COLOURS["blue"], COLOURS["vermilion"], COLOURS["green"]
EDGES: dict[TiltDirection, str] = {"front": "AB", "back": "CD", "right": "BC", "left": "AD"}
"""Edge of the footprint that each tilt goes about."""
FROM_THE_RIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
FROM_BEHIND = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
OBLIQUE = np.array([[0.45, -0.90, 0.0], [0.34, 0.10, 1.0]])
"""View from behind and the right, from above; rows are screen right and up in the body frame."""
AXIS_M = 0.13
"""Length that the IMU's axes are drawn with, m."""
AXIS_LOOKS = (("x", "black", "-"), ("y", COLOURS["blue"], "--"), ("z", COLOURS["vermilion"], ":"))
"""Name, colour and line of an IMU's axes; the colours are those of the paper's Figure 5."""


class View(NamedTuple):
    """A view along an edge.

    Parameters
    ----------
    screen : (2, 3) array, rows: directions of screen right and up in the body frame
    title : where it is seen from
    """

    screen: FloatArray
    title: str


def view_of(tilt: TiltDirection) -> View:
    """View along the edge of a tilt: from the right for front and back, from behind else.

    Parameters
    ----------
    tilt : way that the frame is tilted
    """
    if tilt in ("front", "back"):
        return View(FROM_THE_RIGHT, "from the right")
    return View(FROM_BEHIND, "from behind")


def draw_tilts(geometry: WalkerGeometry, place_m: ArrayLike, *, tilt_rad: float) -> Figure:
    """Draw the four tilts, each along its edge, with the distance from edge to IMU and its arc.

    Parameters
    ----------
    geometry : WalkerGeometry
    place_m : (3,) array, m, body frame, where the IMU sits
    tilt_rad : float, rad, of every tilt

    Returns
    -------
    Figure with four panels: front about AB, back about CD, right about BC, left about AD
    """
    import matplotlib.pyplot as plt

    place = as_vectors(place_m, "place_m")
    with use_style():
        figure, axes = plt.subplots(2, 2, figsize=(WIDTH_IN, 5.2))
        for k, (ax, tilt) in enumerate(zip(axes.flat, TILT_DIRECTIONS, strict=True), start=1):
            screen, title = view_of(tilt)
            edge = geometry.edge(tilt)
            turn = Rotation.from_rotvec(tilt_rad * edge.axis).as_matrix()
            _outline(ax, geometry, screen, color="#BBBBBB", linestyle="--")
            _outline(ax, geometry, screen, turn=turn, point=edge.point_m, color="#777777")
            end = edge.point_m + turn @ (place - edge.point_m)
            pivot, start, stop = (screen @ p for p in (edge.point_m, place, end))
            _arm_and_arc(ax, pivot, start, stop, f"$d_{k}$", name=tilt)
            label(ax, np.add(pivot, [0, -0.09]), f"edge {EDGES[tilt]}", fontsize=SMALL_PT)
            ax.set_title(f"{tilt}, {title}")
            middle = screen[0] @ [geometry.footprint_length_m / 2, 0, 0]
            blank(ax, (middle - 0.80, middle + 0.80), (-0.17, 1.08))
    return figure


def _outline(
    ax: Axes,
    geometry: WalkerGeometry,
    screen: FloatArray,
    *,
    turn: FloatArray | None = None,
    point: FloatArray | None = None,
    **look: Any,
) -> None:
    """Draw the walking frame as seen from one side, upright or turned about a point."""
    bars = _bars(geometry)
    if turn is not None and point is not None:
        bars = [point + (bar - point) @ turn.T for bar in bars]
    for bar in bars:
        line(ax, bar @ screen.T, linewidth=2.5, zorder=1, **look)
    line(ax, [(-2, 0), (2, 0)], color=GREY, linewidth=1, zorder=0)


def _bars(geometry: WalkerGeometry) -> list[FloatArray]:
    """Bars of the drawn frame, each (2, 3), m, body frame; the shape is assumed."""
    half, length = geometry.footprint_width_m / 2, geometry.footprint_length_m
    feet = {"A": (length, half), "B": (length, -half), "C": (0.0, -half), "D": (0.0, half)}
    lean = {"A": -0.05, "B": -0.05, "C": 0.05, "D": 0.05}
    foot = {name: np.array([*place, 0.0]) for name, place in feet.items()}
    top = {name: np.array([x + lean[name], y, HEIGHT_M]) for name, (x, y) in feet.items()}
    bars = [np.array([foot[name], top[name]]) for name in "ABCD"]
    bars += [np.array([top[one], top[other]]) for one, other in ("AD", "BC", "AB")]
    low = {name: foot[name] + 0.35 * (top[name] - foot[name]) for name in "ABCD"}
    bars += [np.array([low[one], low[other]]) for one, other in ("AD", "BC", "AB")]
    return bars


def _arm_and_arc(
    ax: Axes, pivot: FloatArray, start: FloatArray, stop: FloatArray, text: str, *, name: str
) -> None:
    """Draw an arm before and after a turn, and the arc that its end runs along."""
    from_rad, to_rad = (float(np.arctan2(*(p - pivot)[::-1])) for p in (start, stop))
    radius = float(np.linalg.norm(start - pivot))
    line(ax, [pivot, start], color=ARM, linestyle="--", gid=f"{name} arm before", zorder=4)
    line(ax, [pivot, stop], color=ARM, linewidth=2.2, gid=f"{name} arm after", zorder=4)
    arc(ax, pivot, radius, from_rad, to_rad, colour=CHORD, arrowhead=True, linewidth=2.2)
    box(ax, start, (0.07, 0.05), edgecolor="#777777")
    box(ax, stop, (0.07, 0.05), to_rad - from_rad)
    ax.plot(*pivot, "o", color="black", markersize=6, zorder=6)
    along = (stop - pivot) / radius
    side = np.sign(from_rad - to_rad) * np.array([along[1], -along[0]])
    label(ax, pivot + 0.62 * (stop - pivot) + 0.07 * side, text, ARM)


def draw_chord(distance_m: float, angle_rad: float) -> Figure:
    """Draw distance, angle and chord of one tilt: the isosceles triangle behind (13).

    Parameters
    ----------
    distance_m : float, m, from the edge to the IMU, d_i
    angle_rad : float, rad, of the tilt, alpha_i

    Returns
    -------
    Figure; the chord l_i is drawn from the first to the last place of the IMU
    """
    import matplotlib.pyplot as plt

    first, last = np.pi / 2 - angle_rad / 2, np.pi / 2 + angle_rad / 2
    start, stop = distance_m * direction(first), distance_m * direction(last)
    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 3.9))
        pivot = np.zeros(2)
        arc(ax, pivot, distance_m, first, last, colour=CHORD, linestyle=":")
        for end, name in ((start, "before"), (stop, "after")):
            line(ax, [pivot, end], color=ARM, linewidth=2.2, gid=f"d {name}")
            label(ax, 0.55 * end + [0.09 * np.sign(end[0]), 0], "$d_i$", ARM)
            box(ax, end, (0.07, 0.05), np.arctan2(end[1], end[0]) - np.pi / 2)
        line(ax, [start, stop], color=CHORD, linewidth=2.2, gid="l")
        label(ax, (start + stop) / 2 + [0.1, -0.06], "$l_i$", CHORD)
        line(ax, [pivot, (start + stop) / 2], color=GREY, linestyle="--", gid="half")
        arc(ax, pivot, 0.3 * distance_m, first, last, gid="alpha")
        label(ax, 0.37 * distance_m * direction(np.pi / 2 + angle_rad / 4), r"$\alpha_i$")
        label(ax, (0, -0.07), "edge", fontsize=SMALL_PT)
        label(ax, np.add(start, [0.17, 0]), "first place", fontsize=SMALL_PT)
        label(ax, np.add(stop, [-0.17, 0]), "last place", fontsize=SMALL_PT)
        formula = r"$d_i = \dfrac{l_i}{2\,\sin(\alpha_i/2)}$"
        label(ax, (0.42, 0.16), formula, fontsize=13)
        blank(ax, (-0.56, 0.64), (-0.12, distance_m + 0.07))
    return figure


def draw_triangles(geometry: WalkerGeometry, place_m: ArrayLike) -> Figure:
    """Draw the two triangles behind (14) and (15): d3, d4 over AB, and d1, d2 over AD.

    Parameters
    ----------
    geometry : WalkerGeometry
    place_m : (3,) array, m, body frame, where the IMU sits

    Returns
    -------
    Figure with two panels: from behind (left is y) and from the right (right is x)
    """
    import matplotlib.pyplot as plt

    place = as_vectors(place_m, "place_m")
    half, length = geometry.footprint_width_m / 2, geometry.footprint_length_m
    with use_style():
        figure, (rear, side) = plt.subplots(1, 2, figsize=(WIDTH_IN, 4.5))
        feet = (FROM_BEHIND @ [0, half, 0], FROM_BEHIND @ [0, -half, 0])
        _triangle(rear, feet, FROM_BEHIND @ place, ("d_4", "d_3"), "AB", ("AD", "BC"))
        rear.set_title("from behind")
        _axis_arrow(rear, (-0.16, 0), "$y$")
        feet = (FROM_THE_RIGHT @ [0, 0, 0], FROM_THE_RIGHT @ [length, 0, 0])
        _triangle(side, feet, FROM_THE_RIGHT @ place, ("d_2", "d_1"), "AD", ("CD", "AB"))
        side.set_title("from the right")
        _axis_arrow(side, (0.16, 0), "$x$")
        for ax, middle in ((rear, 0.0), (side, length / 2)):
            blank(ax, (middle - 0.43, middle + 0.43), (-0.40, place[2] + 0.07))
    return figure


def _axis_arrow(ax: Axes, tip: tuple[float, float], name: str) -> None:
    """Draw the body's origin with one axis along the floor."""
    ax.plot(0, 0, "o", color="black", markersize=7, zorder=7)
    arrow(ax, (0, 0), tip, "black", gid=f"axis {name}")
    label(ax, np.add(tip, [0, 0.05]), name)


def _triangle(
    ax: Axes,
    feet: tuple[FloatArray, FloatArray],
    top: FloatArray,
    sides: tuple[str, str],
    base: str,
    edges: tuple[str, str],
) -> None:
    """Draw a triangle over the floor with its height, and the two legs that (15) takes from it."""
    line(ax, [(-2, 0), (2, 0)], color=GREY, linewidth=1)
    line(ax, list(feet), color="black", linewidth=2.2, gid=base)
    middle = np.array([top[0], 0.0])
    line(ax, [middle, top], color=GREY, linestyle="--", gid=f"h over {base}")
    label(ax, middle + 0.45 * (top - middle), "$h$")
    for foot, text, edge, sign in zip(feet, sides, edges, (-1, 1), strict=True):
        line(ax, [foot, top], color=ARM, linewidth=2.2, gid=text)
        label(ax, (foot + top) / 2 + [0.07 * sign, 0.03], f"${text}$", ARM)
        ax.plot(*foot, "o", color="black", markersize=6, zorder=6)
        label(ax, np.add(foot, [0.04 * sign, -0.05]), f"edge {edge}", fontsize=SMALL_PT)
        if text == "d_1":  # not in (15)
            continue
        row = -0.12 if sign < 0 else -0.22
        ends = [foot[0], top[0]]
        dimension(ax, (min(ends), row), (max(ends), row), "", gid=f"leg of {text}", colour=CHORD)
        root = rf"$\sqrt{{{text}^2-h^2}}$"
        label(ax, (sum(ends) / 2, row - 0.055), root, CHORD, fontsize=SMALL_PT)
        line(ax, [(foot[0], -0.08), (foot[0], row)], color=GREY, linewidth=0.8, linestyle=":")
    line(ax, [(top[0], 0), (top[0], -0.22)], color=GREY, linewidth=0.8, linestyle=":")
    dimension(ax, (feet[0][0], -0.34), (feet[1][0], -0.34), f"${base}$")
    box(ax, top, (0.06, 0.045))


def draw_arm_angles(
    geometry: WalkerGeometry, place_m: ArrayLike, *, velocity_m: float = 0.3
) -> Figure:
    """Draw the angles behind (16) to (19): arm, initial velocity and vertical, in two tilts.

    Parameters
    ----------
    geometry : WalkerGeometry
    place_m : (3,) array, m, body frame, where the IMU sits
    velocity_m : float, m, length that the velocity arrows are drawn with

    Returns
    -------
    Figure with two panels: the tilt to the back about CD, the tilt to the right about BC
    """
    import matplotlib.pyplot as plt

    place = as_vectors(place_m, "place_m")
    tilts: tuple[TiltDirection, TiltDirection] = ("back", "right")
    with use_style():
        figure, axes = plt.subplots(1, 2, figsize=(WIDTH_IN, 4.5))
        for ax, tilt, index in zip(axes, tilts, (2, 3), strict=True):
            screen, title = view_of(tilt)
            edge = geometry.edge(tilt)
            arm = place - edge.point_m
            moves = np.cross(edge.axis, arm)
            pivot, top = screen @ edge.point_m, screen @ place
            ahead = velocity_m * screen @ moves / np.linalg.norm(screen @ moves)
            line(ax, [(-2, 0), (2, 0)], color=GREY, linewidth=1)
            _draw_angles(ax, pivot, top, ahead, index)
            ax.set_title(f"{tilt}, {title}")
            label(ax, np.add(pivot, [0, -0.06]), f"edge {EDGES[tilt]}", fontsize=SMALL_PT)
            across = (pivot[0] + top[0]) / 2
            blank(ax, (across - 0.46, across + 0.46), (-0.22, place[2] + 0.34))
        _offsets(axes, geometry, place)
    return figure


def _draw_angles(
    ax: Axes, pivot: FloatArray, top: FloatArray, ahead: FloatArray, index: int
) -> None:
    """Draw arm, velocity and the two verticals, with gamma at the edge and beta at the IMU."""
    upright = np.pi / 2
    lean, heading = (float(np.arctan2(*v[::-1])) for v in (top - pivot, ahead))
    reach = float(np.linalg.norm(top - pivot))
    line(ax, [pivot, top], color=ARM, linewidth=2.2, gid=f"d{index}")
    label(ax, pivot + 0.6 * (top - pivot) + [0.07 * np.sign(np.cos(lean)), 0], f"$d_{index}$", ARM)
    line(ax, [pivot, np.add(pivot, [0, 0.75 * reach])], color=GREY, linestyle=":", gid=f"up{index}")
    arc(ax, pivot, 0.42 * reach, lean, upright)
    label(ax, pivot + 0.50 * reach * direction((lean + upright) / 2), rf"$\gamma_{index}$")
    arrow(ax, top, np.add(top, [0, 0.27]), "black", gid=f"g{index}")
    label(ax, np.add(top, [0.04 * np.sign(np.cos(lean)), 0.27]), "$g$")
    arrow(ax, top, top + ahead, VELOCITY, gid=f"v{index}")
    label(ax, top + 1.12 * ahead + [0, 0.05], rf"$v_{{{index},init}}$", VELOCITY)
    arc(ax, top, 0.15, upright, heading)
    label(ax, top + 0.21 * direction((upright + heading) / 2), rf"$\beta_{index}$")
    box(ax, top, (0.07, 0.05))


def _offsets(axes: Sequence[Axes], geometry: WalkerGeometry, place: FloatArray) -> None:
    """Write under the floor what (19) takes from the two drawings."""
    (back, right), half = axes, geometry.footprint_width_m / 2
    foot, below = -0.12, (0.0, -0.055)
    dimension(back, (0, foot), (place[0], foot), r"$d_2\,\sin\gamma_2$", gid="x", shift=below)
    line(back, [(place[0], 0), (place[0], place[2])], color=GREY, linewidth=0.8, linestyle=":")
    legs = ((half, foot), (-place[1], foot))
    dimension(right, *legs, r"$d_3\,\sin\gamma_3$", gid="y from BC", shift=below)
    line(right, [(-place[1], 0), (-place[1], place[2])], color=GREY, linewidth=0.8, linestyle=":")


def draw_poses(geometry: WalkerGeometry, mounts: Sequence[WalkerMount]) -> Figure:
    """Draw a walking frame with the IMU in several poses, each with its three axes.

    Parameters
    ----------
    geometry : WalkerGeometry
    mounts : of the IMU, numbered from 1 in the drawing

    Returns
    -------
    Figure, oblique view from behind and the right: y goes left, x into the depth, z up
    """
    import matplotlib.pyplot as plt

    with use_style():
        figure, ax = plt.subplots(figsize=(WIDTH_IN, 5.6))
        for bar in _bars(geometry):
            line(ax, bar @ OBLIQUE.T, color="#BBBBBB", linewidth=4, zorder=1)
        _floor(ax, geometry)
        for k, mount in enumerate(mounts, start=1):
            _pose(ax, mount, str(k))
        for name, colour, look in AXIS_LOOKS:
            ax.plot([], [], color=colour, linestyle=look, label=f"the IMU's {name}")
        figure.legend(loc="outside lower center", ncols=3, fontsize=SMALL_PT)
        blank(ax, (-0.36, 0.62), (-0.14, 1.12))
    return figure


def _pose(ax: Axes, mount: WalkerMount, name: str) -> None:
    """Draw one IMU with its axes, and the point of the floor under it."""
    place = mount.translation_body_m
    here, drop = OBLIQUE @ place, OBLIQUE @ [place[0], place[1], 0]
    line(ax, [here, drop], color="#BBBBBB", linewidth=0.9, linestyle=":", zorder=1)
    ax.plot(*drop, "x", color="#888888", markersize=5, zorder=2)
    for (axis, colour, look), along in zip(AXIS_LOOKS, mount.rotation_imu_to_body.T, strict=True):
        tip = OBLIQUE @ (place + AXIS_M * along)
        arrow(ax, here, tip, colour, linestyle=look, gid=f"pose {name} {axis}")
    number(ax, here, name)


def _floor(ax: Axes, geometry: WalkerGeometry) -> None:
    """Draw the footprint with its corners, and the body's frame between C and D."""
    half, length = geometry.footprint_width_m / 2, geometry.footprint_length_m
    corners = {"A": (length, half), "B": (length, -half), "C": (0.0, -half), "D": (0.0, half)}
    outline = np.array([OBLIQUE @ [*corners[name], 0.0] for name in "ABCDA"])
    line(ax, outline, color=GREY, linestyle="--", linewidth=1)
    for name, shift in zip(
        "ABCD", ((0.04, 0.03), (0.04, -0.02), (0.0, -0.06), (-0.05, -0.03)), strict=True
    ):
        label(ax, OBLIQUE @ [*corners[name], 0.0] + shift, name)
    for name, axis, shift in zip(
        "xyz", np.eye(3), ((0.03, -0.03), (0, -0.05), (-0.05, 0)), strict=True
    ):
        arrow(ax, (0, 0), OBLIQUE @ (0.2 * axis), GREY)
        label(ax, OBLIQUE @ (0.2 * axis) + shift, f"${name}_b$", GREY)
    ax.plot(0, 0, "o", color=GREY, markersize=7, zorder=6)
