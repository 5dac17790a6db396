"""Tilts of the frame about its edges, as the calibration asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, shown
from mobility_imu.simulation.checks import check_ranges
from mobility_imu.simulation.profiles import least_jerk, window
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.walker.motion import (
    PERFECT,
    Imperfections,
    TiltTruth,
    WalkerMotion,
    band_noise,
    fast_clock,
)
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection, WalkerGeometry


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


@dataclass(frozen=True)
class TiltStyle:
    """How somebody tilts the frame; each (low, high) is drawn from evenly, for each tilt.

    The paper asks for about 20 to 45 deg (section 1); the times are ours.

    Parameters
    ----------
    angle_rad : rad
    out_s, back_s : s, of the movements, both of least jerk
    hold_s : s, the frame is held tilted
    still_s : s, the frame stands after each tilt
    first_still_s : s, the frame stands before the first
    """

    angle_rad: tuple[float, float] = (_deg(20), _deg(45))
    out_s: tuple[float, float] = (1.0, 1.6)
    hold_s: tuple[float, float] = (0.7, 1.3)
    back_s: tuple[float, float] = (1.0, 1.6)
    still_s: tuple[float, float] = (1.5, 2.2)
    first_still_s: tuple[float, float] = (2.5, 3.0)

    def __post_init__(self) -> None:
        """Check every range."""
        check_ranges(self)
        if self.angle_rad[1] > np.pi / 2:
            raise InputError(f"angle_rad = {self.angle_rad}: expected up to pi/2 (in deg?)")


def simulate_tilts(
    geometry: WalkerGeometry,
    *,
    seed: int,
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    style: TiltStyle | None = None,
    imperfections: Imperfections = PERFECT,
) -> WalkerMotion:
    """Tilt the frame about its edges, one after the other, as the calibration asks for.

    Parameters
    ----------
    geometry : WalkerGeometry, the true one
    seed : of angles, times and imperfections; the same seed gives the same bytes
    order : which tilts, by direction
    style : TiltStyle, or None for its standard values
    imperfections : Imperfections; those of walking do not matter here

    Returns
    -------
    WalkerMotion

    Raises
    ------
    InputError
        If there is no tilt, a direction is unknown, the tilts last too long in all, or the seed is
        negative or not whole.
    """
    expect("geometry", geometry, WalkerGeometry)
    style = settings_or_default("style", style, TiltStyle)
    expect("imperfections", imperfections, Imperfections)
    if isinstance(order, str) or not isinstance(order, Sequence) or not order:
        raise InputError(f"order = {shown(order)}: expected at least one direction in a sequence")
    edges = [geometry.edge(direction) for direction in order]
    slips, twists, tremors = (stream(seed, 31, k) for k in range(1, 4))
    tilts, end_s = _drawn_tilts(order, style, stream(seed, 31))
    time_s = fast_clock(end_s)
    count = len(time_s)
    position, rotation = np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1))
    stationary = np.ones(count, bool)
    shaking = imperfections.hold_tremor_rad / np.sqrt(2) * band_noise(count, 1, (2.0, 8.0), tremors)
    for tilt, edge in zip(tilts, edges, strict=True):
        first, last = np.searchsorted(time_s, [tilt.start_s, tilt.stop_s])
        out, angle = _tipped(tilt, time_s[first:last], shaking[first:last, 0])
        slip = imperfections.edge_slip_m * abs(slips.standard_normal())
        course = slips.uniform(0, 2 * np.pi)
        slide = slip * np.array([np.cos(course), np.sin(course), 0.0])
        twist = imperfections.edge_twist_rad * twists.standard_normal()
        standing, at = rotation[first].copy(), position[first].copy()
        outward = np.cross(edge.axis, [0, 0, 1])
        pivot = at + standing @ (edge.point_m + imperfections.ferrule_edge_m * outward)
        about = standing @ edge.axis
        turn = _turned(twist * out, angle, about)
        end = _turned(np.array([twist]), np.zeros(1), about)[0]
        position[first:last] = pivot + np.outer(out, slide) + turn @ (at - pivot)
        rotation[first:last] = turn @ standing
        position[last:] = pivot + slide + end @ (at - pivot)
        rotation[last:] = end @ standing
        stationary[first:last] = False
    return WalkerMotion(time_s, position, rotation, stationary, tilts=tilts)


def _drawn_tilts(
    order: Sequence[TiltDirection], style: TiltStyle, rng: np.random.Generator
) -> tuple[tuple[TiltTruth, ...], float]:
    """Angles and times of the tilts, and when the recording ends."""
    clock = rng.uniform(*style.first_still_s)
    tilts = []
    for direction in order:
        angle = rng.uniform(*style.angle_rad)
        spans = [rng.uniform(*span) for span in (style.out_s, style.hold_s, style.back_s)]
        times = clock + np.cumsum([0.0, *spans])
        tilts.append(TiltTruth(direction, float(angle), *times.tolist()))
        clock = times[-1] + rng.uniform(*style.still_s)
    return tuple(tilts), clock


def _tipped(
    tilt: TiltTruth, time_s: FloatArray, shaking_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How far the tilt has come, 0 to 1, and the angle about the edge with its tremor, rad."""
    out = least_jerk((time_s - tilt.start_s) / (tilt.held_from_s - tilt.start_s))
    back = least_jerk((time_s - tilt.held_until_s) / (tilt.stop_s - tilt.held_until_s))
    fade = 0.2 * (tilt.held_until_s - tilt.held_from_s)
    held = window(time_s, tilt.held_from_s, tilt.held_until_s, fade)
    return out, tilt.angle_rad * (out - back) + held * shaking_rad


def _turned(yaw_rad: FloatArray, tip_rad: FloatArray, about: FloatArray) -> FloatArray:
    """Rotations by an angle about an axis, then by a yaw, (n, 3, 3)."""
    yaw = Rotation.from_rotvec(np.outer(yaw_rad, [0, 0, 1]))
    return np.asarray((yaw * Rotation.from_rotvec(np.outer(tip_rad, about))).as_matrix())


def measured_geometry(
    geometry: WalkerGeometry, imperfections: Imperfections, seed: int
) -> WalkerGeometry:
    """Footprint as the user's tape measures it: both lengths off by N(0, tape_m).

    Parameters
    ----------
    geometry : WalkerGeometry, the true one
    imperfections : Imperfections
    seed : of the two errors

    Returns
    -------
    WalkerGeometry
    """
    expect("geometry", geometry, WalkerGeometry)
    expect("imperfections", imperfections, Imperfections)
    width, length = imperfections.tape_m * stream(seed, 33).standard_normal(2)
    return WalkerGeometry(
        geometry.footprint_width_m + float(width), geometry.footprint_length_m + float(length)
    )
