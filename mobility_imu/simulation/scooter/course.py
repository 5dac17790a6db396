"""Courses for a mobility scooter: the five of Figure 5, and the ground under the wheels.

Every size is an assumption of ours unless it says where it is from.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import interpolate, ndimage

from mobility_imu.arguments import check_limits, expect
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_count, as_number, check_positive, one_of, shown
from mobility_imu.simulation.checks import LONGEST_M, check_range
from mobility_imu.simulation.profiles import least_jerk


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


SHARPEST_PM = 100.0
"""A circle of a centimetre: no wheel rolls along a sharper curve."""
MOST_POINTS = 1_000_000
"""Points of a part of a course that is drawn."""


class Segment(NamedTuple):
    """A piece of a course.

    Parameters
    ----------
    length_m : m
    curvature_pm : 1/m, left positive
    grade_rad : rad, uphill positive
    bank_rad : rad, right side up positive
    tactile : whether tactile paving lies on it
    """

    length_m: float
    curvature_pm: float = 0.0
    grade_rad: float = 0.0
    bank_rad: float = 0.0
    tactile: bool = False


@dataclass(frozen=True)
class Course:
    """A named sequence of parts, one after the other.

    Parameters
    ----------
    name : str
    segments : of Segment, at least one
    transition_m : m, slopes change over this length

    Raises
    ------
    InputError
        If there is no part, or a length or a slope is impossible; the message says which.
    """

    name: str
    segments: tuple[Segment, ...]
    transition_m: float = 0.8

    def __post_init__(self) -> None:
        """Check every part."""
        expect("Course.name", self.name, str)
        try:
            object.__setattr__(self, "segments", tuple(self.segments))
        except TypeError:
            got = type(self.segments).__name__
            raise InputError(f"segments: got {got}, expected a sequence of Segment") from None
        check_positive(self, "transition_m", allow_zero=("transition_m",))
        if not self.segments:
            raise InputError("segments: none, expected at least one Segment")
        for k, segment in enumerate(self.segments):
            where = f"segments[{k}]"
            if not isinstance(segment, Segment):
                raise InputError(f"{where} = {shown(segment)}: expected a Segment")
            one_of(f"{where}.tactile", segment.tactile, (True, False))
            length = as_number(segment.length_m, f"{where}.length_m")
            if length > LONGEST_M:
                raise InputError(f"{where}.length_m = {length:g}: expected up to {LONGEST_M:g}")
            bend = as_number(segment.curvature_pm, f"{where}.curvature_pm", negative=True)
            if abs(bend) > SHARPEST_PM:
                raise InputError(f"{where}.curvature_pm = {bend:g}: expected up to {SHARPEST_PM:g}")
            for what in ("grade_rad", "bank_rad"):
                slope = as_number(getattr(segment, what), f"{where}.{what}", negative=True)
                if abs(slope) > np.pi / 4:
                    raise InputError(f"{where}.{what} = {slope:g}: expected up to pi/4 (in deg?)")

    @property
    def length_m(self) -> float:
        """Length along the path, m."""
        return sum(segment.length_m for segment in self.segments)

    def outline(self, points: int = 60) -> tuple[FloatArray, ...]:
        """Middle line of the course as it is drawn, without run-out and transitions.

        Parameters
        ----------
        points : number of points of each part

        Returns
        -------
        one (points, 3) array for each part, m: x right, y forward, z up from the start; a
        part begins where the one before ends
        """
        points = as_count(points, "points", least=2)
        if points > MOST_POINTS:
            raise InputError(f"points = {shown(points)}: expected up to {MOST_POINTS}")
        start, heading, lines = np.zeros(3), 0.0, []
        for segment in self.segments:
            along = np.linspace(0, segment.length_m, points)
            turn = segment.curvature_pm * along
            # Chord of an arc: its length, and half of the turn as its direction.
            chord = along * np.sinc(turn / 2 / np.pi) * np.cos(segment.grade_rad)
            towards = heading + turn / 2
            height = along * np.sin(segment.grade_rad)
            lines.append(
                start + np.column_stack([-chord * np.sin(towards), chord * np.cos(towards), height])
            )
            start, heading = lines[-1][-1], heading + turn[-1]
        return tuple(lines)


_CURVE = 1 / 1.6

# Figure 5 names lengths and angles; radii, run-ups and the order are ours, set by hand.
COURSES = {
    "straight": Course("straight", (Segment(20.0),)),
    "curves": Course(
        "curves",
        (
            Segment(2.0),
            Segment(np.pi / 2 / _CURVE, _CURVE),
            Segment(1.0),
            Segment(np.pi / 2 / _CURVE, -_CURVE),
            Segment(1.0),
            Segment(np.pi / 2 / _CURVE, -_CURVE),
            Segment(1.0),
            Segment(np.pi / 2 / _CURVE, _CURVE),
            Segment(2.0),
        ),
    ),
    "slopes": Course(
        "slopes",
        (
            Segment(2.5),
            Segment(5.0, grade_rad=_deg(7)),
            Segment(2.5),
            Segment(7.0, grade_rad=_deg(-5)),
            Segment(2.5),
        ),
    ),
    "side": Course("side", (Segment(2.0), Segment(9.0, bank_rad=_deg(7)), Segment(2.0))),
    "tactile": Course("tactile", (Segment(2.0), Segment(10.0, tactile=True), Segment(2.0))),
}
"""The five courses of Figure 5 by name."""


@dataclass(frozen=True)
class Ground:
    """Unevenness that the wheels meet, after the tyres have smoothed it; all sizes set by hand.

    Parameters
    ----------
    roughness_m : sd of the height under each wheel
    roughness_length_m : shortest length of a bump
    tactile_m : sd of the height on tactile paving, a sine
    tactile_pitch_m : its length, drawn per run between these two (JIS T 9251: dots every 55 to
        60 mm). Whether the scooter heaves or pitches on them depends on how many fit into the
        wheelbase, which we do not know either; with one fixed length it would be an accident.
    grade_sd_rad, bank_sd_rad : slope of a floor that is called flat, along and across the start,
        drawn per run; it stays where it is when the scooter turns
    """

    roughness_m: float = 0.4e-3
    roughness_length_m: float = 0.08
    tactile_m: float = 0.2e-3
    tactile_pitch_m: tuple[float, float] = (0.055, 0.060)
    grade_sd_rad: float = _deg(0.3)
    bank_sd_rad: float = _deg(0.6)

    def __post_init__(self) -> None:
        """Check every size."""
        sizes = ("roughness_m", "tactile_m", "grade_sd_rad", "bank_sd_rad")
        check_positive(self, "roughness_length_m", *sizes, allow_zero=sizes)
        check_range(self.tactile_pitch_m, "Ground.tactile_pitch_m")
        slopes = dict.fromkeys(("grade_sd_rad", "bank_sd_rad"), (0.0, np.pi / 4))
        heights = dict.fromkeys(("roughness_m", "tactile_m"), (0.0, 1.0))
        check_limits(self, {"roughness_length_m": (1e-3, 10.0), **heights, **slopes})


SMOOTH_GROUND = Ground(0.0, 0.08, 0.0, (0.055, 0.060), 0.0, 0.0)


def middle_line(course: Course) -> tuple[FloatArray, FloatArray]:
    """Points along the course's middle line, every 2 cm, with a run-out.

    Parameters
    ----------
    course : Course

    Returns
    -------
    (n,) array, m, distance along the line, and (n, 2) array, m, x right and y forward
    """
    s = np.arange(0, course.length_m + 3, 0.02)
    heading = np.cumsum(level_at(course, s, "curvature_pm", 0.0)) * 0.02
    return s, np.cumsum(np.column_stack([-np.sin(heading), np.cos(heading)]) * 0.02, axis=0)


def level_at(course: Course, distance: FloatArray, what: str, blend_m: float) -> FloatArray:
    """Value of one property along the path, part by part; changes are S-shaped over blend_m.

    Parameters
    ----------
    course : Course
    distance : (n,) array, m, along the path
    what : field of Segment
    blend_m : m, length of a change; 0 for jumps

    Returns
    -------
    (n,) array
    """
    ends = np.cumsum([segment.length_m for segment in course.segments])[:-1]
    values = [float(getattr(segment, what)) for segment in course.segments]
    level = np.full(len(distance), values[0])
    for end, step in zip(ends, np.diff(values), strict=True):
        if blend_m == 0:
            level += step * (distance >= end)
        else:
            u = np.clip((distance - end) / blend_m + 0.5, 0, 1)
            level += least_jerk(u, step)
    return level


def ground_line(
    course: Course,
    wheelbase_m: float,
    ground: Ground,
    tactile_pitch_m: float,
    rng: np.random.Generator,
) -> Callable[[FloatArray], FloatArray]:
    """Height along one wheel track, as the tyre follows it.

    Parameters
    ----------
    course : Course
    wheelbase_m : m
    ground : Ground
    tactile_pitch_m : m, of the tactile paving
    rng : the source of the draws

    Returns
    -------
    function of the distance along the path, m, that returns heights, m
    """
    grid = np.arange(-0.5, course.length_m + wheelbase_m + 4, 0.005)
    rough = ndimage.gaussian_filter1d(
        rng.standard_normal(len(grid)), ground.roughness_length_m / 2.5 / 0.005
    )
    rough *= ground.roughness_m / rough.std()
    tactile = level_at(course, grid, "tactile", 0.2)
    bumps = np.sqrt(2) * ground.tactile_m * np.sin(2 * np.pi * grid / tactile_pitch_m)
    spline = interpolate.CubicSpline(grid, rough + tactile * bumps)
    return lambda distance_m: np.asarray(spline(distance_m))
