"""Summary of a walk and walking tests, from the steps of the frame. Goes past the paper."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_count, as_number, one_of
from mobility_imu.results import Result
from mobility_imu.walker.steps import GaitSettings, Steps, Turns, find_turns

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "TUG_PHASES",
    "TimedUpAndGo",
    "WalkTest",
    "WalkingSummary",
    "path_at",
    "six_minute_walk",
    "ten_metre_walk",
    "time_at",
    "timed_up_and_go",
    "walking_summary",
]

_ROUNDING_M = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class WalkingSummary(Result):
    """A walk in a few numbers; all of the frame, none of the feet.

    Parameters
    ----------
    step_count : steps of the frame, turning ones too
    cadence_per_min : 1/min, of the frame: from each lift to the next, mean; with pauses
    step_length_mean_m, step_length_cv : m and 1, over the steps that do not turn; the short last
        step before a corner counts too. CV is sd over mean
    swing_mean_s, swing_cv : s and 1, time that the frame is not on the floor
    stance_mean_s, stance_cv : s and 1, time that it stands between two steps, when the user walks
    path_m : m, along the placements, so that a loop counts in full, and so does every placement
        beside the straight line: a little longer than the course
    mean_speed_mps : m/s, that path from the first lift to the last placement, turns included
    turns : Turns
    warnings : those of the steps
    settings : GaitSettings of the steps
    """

    step_count: int
    cadence_per_min: float
    step_length_mean_m: float
    step_length_cv: float
    swing_mean_s: float
    swing_cv: float
    stance_mean_s: float
    stance_cv: float
    path_m: float
    mean_speed_mps: float
    turns: Turns
    warnings: tuple[str, ...] = ()
    settings: GaitSettings = field(default_factory=GaitSettings)

    def __post_init__(self) -> None:
        """Check every field."""
        kinds = {"step_count": int, "turns": Turns, "settings": GaitSettings}
        others = {each.name for each in fields(self)} - {*kinds, "warnings"}
        check_fields(self, **dict.fromkeys(others, float), **kinds)
        super().__post_init__()

    def to_frame(self) -> pd.DataFrame:
        """One row of numbers, with the number of turns and their sum without sign."""
        import pandas as pd

        others = ("turns", "warnings", "settings")
        row = {name: value for name, value in vars(self).items() if name not in others}
        row["turn_count"] = len(self.turns.angle_rad)
        row["turned_deg"] = float(np.rad2deg(np.abs(self.turns.angle_rad).sum()))
        return pd.DataFrame([row])


def walking_summary(steps: Steps) -> WalkingSummary:
    """Number, cadence, lengths, times and speed of the frame's steps in a walk.

    Parameters
    ----------
    steps : Steps

    Returns
    -------
    WalkingSummary
        What needs more steps than there are is NaN.

    Raises
    ------
    InputError
        If there is no step.
    """
    _check(steps)
    going = steps.length_m[np.abs(steps.turn_rad) < steps.settings.least_turn_rad]
    count = len(steps)
    between = steps.lift_s[-1] - steps.lift_s[0]
    path = float(steps.path_m[-1])
    length, swing, stance = (_mean_and_cv(v) for v in (going, steps.swing_s, steps.stance_s[:-1]))
    return WalkingSummary(
        step_count=count,
        cadence_per_min=float(60 * (count - 1) / between) if count > 1 else float("nan"),
        step_length_mean_m=length[0],
        step_length_cv=length[1],
        swing_mean_s=swing[0],
        swing_cv=swing[1],
        stance_mean_s=stance[0],
        stance_cv=stance[1],
        path_m=path,
        mean_speed_mps=path / float(steps.place_s[-1] - steps.lift_s[0]),
        turns=find_turns(steps),
        warnings=steps.warnings,
        settings=steps.settings,
    )


def _mean_and_cv(values: FloatArray) -> tuple[float, float]:
    if not len(values):
        return float("nan"), float("nan")
    mean = float(values.mean())
    return mean, float(values.std(ddof=1) / mean) if len(values) > 1 else float("nan")


def path_at(steps: Steps, time_s: float) -> float:
    """Way along the placements at a time, m: even from the first lift and between placements.

    The frame itself moves by jumps. Evenly in between is nearer to the user, who follows while it
    stands, and keeps a line that lies near a placement from costing a whole stance.

    Parameters
    ----------
    steps : Steps, at least one
    time_s : s
    """
    _check(steps)
    time = as_number(time_s, "time_s", negative=True)
    knots = np.r_[steps.lift_s[0], steps.place_s]
    return float(np.interp(time, knots, np.r_[0.0, steps.path_m]))


def time_at(steps: Steps, path_m: float) -> float:
    """When the way along the placements reaches a length, s: the inverse of :func:`path_at`.

    Parameters
    ----------
    steps : Steps, at least one
    path_m : m, positive

    Raises
    ------
    InputError
        If the way is shorter, or there is no step.
    """
    _check(steps)
    as_number(path_m, "path_m", zero=True)
    path = steps.path_m
    if path_m > path[-1] + _ROUNDING_M:
        short = path_m - path[-1]
        raise InputError(
            f"the walk is {path[-1]:.4g} m long, {short:.2g} m shorter than {path_m:g} m"
        )
    knots, way = np.r_[steps.lift_s[0], steps.place_s], np.r_[0.0, path]
    k = max(int(np.searchsorted(way, path_m - _ROUNDING_M)), 1)
    fraction = (path_m - way[k - 1]) / (way[k] - way[k - 1])
    return float(knots[k - 1] + np.clip(fraction, 0, 1) * (knots[k] - knots[k - 1]))


@dataclass(frozen=True)
class WalkTest:
    """A timed walk of the frame.

    Parameters
    ----------
    start_s, stop_s : s, on the recording's clock
    distance_m : m, along the placements in this time
    step_count : steps put down in this time
    warnings : those of the steps
    settings : GaitSettings of the steps

    Raises
    ------
    InputError
        If a number is none, or the walk ends before it begins.
    """

    start_s: float
    stop_s: float
    distance_m: float
    step_count: int
    warnings: tuple[str, ...] = ()
    settings: GaitSettings = field(default_factory=GaitSettings)

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("start_s", "stop_s"):
            object.__setattr__(self, name, as_number(getattr(self, name), name, negative=True))
        distance = as_number(self.distance_m, "distance_m", zero=True)
        object.__setattr__(self, "distance_m", distance)
        object.__setattr__(self, "step_count", as_count(self.step_count, "step_count", least=0))
        if not self.stop_s > self.start_s:
            raise InputError(f"stop_s = {self.stop_s:g}: expected after start_s, {self.start_s:g}")
        check_fields(self, settings=GaitSettings)

    @property
    def duration_s(self) -> float:
        """Time taken, s."""
        return self.stop_s - self.start_s

    @property
    def speed_mps(self) -> float:
        """Distance over time, m/s."""
        return self.distance_m / self.duration_s


def ten_metre_walk(
    steps: Steps,
    *,
    start: Literal["static", "rolling"],
    distance_m: float = 10.0,
    run_up_m: float = 2.0,
) -> WalkTest:
    """Time over a part of the way, as in the 10-Metre Walk Test.

    The middle of the rear tips passes the lines here, in a test the leading foot. Between two
    placements the way grows evenly, see :func:`path_at`; the frame itself, which stands first and
    then jumps, passes a line up to two thirds of a step later.

    Parameters
    ----------
    steps : Steps
    start : "static": from the first lift, over the whole distance; "rolling": without the first
        and the last ``run_up_m`` of the distance, so 6 m of 10 m
    distance_m, run_up_m : m

    Returns
    -------
    WalkTest

    Raises
    ------
    InputError
        If the way ends before the timed part does, or there is no step.
    """
    _check(steps)
    one_of("start", start, ("static", "rolling"))
    distance_m, run_up_m = as_number(distance_m, "distance_m"), as_number(run_up_m, "run_up_m")
    from_m, to_m = (0.0, distance_m) if start == "static" else (run_up_m, distance_m - run_up_m)
    if start == "rolling" and not run_up_m < distance_m / 2:
        raise InputError(f"run_up_m = {run_up_m}: expected less than half of {distance_m:g} m")
    begun = float(steps.lift_s[0]) if start == "static" else time_at(steps, from_m)
    return _walk_test(steps, begun, time_at(steps, to_m), to_m - from_m)


def six_minute_walk(steps: Steps, duration_s: float = 360.0) -> WalkTest:
    """Distance walked in a time, as in the 6-Minute Walk Test: from the first lift on.

    What is under way when the time is up counts in part, by its fraction of the time between two
    placements (:func:`path_at`); nothing of it if the recording ends before the second.

    Parameters
    ----------
    steps : Steps
    duration_s : s

    Returns
    -------
    WalkTest

    Raises
    ------
    InputError
        If the recording ends before the time is up, or there is no step.
    """
    _check(steps)
    duration_s = as_number(duration_s, "duration_s")
    begun = float(steps.lift_s[0])
    recorded = float(steps.recorded_s[1]) - begun
    if recorded < duration_s:
        raise InputError(
            f"the recording goes on for {recorded:.1f} s after the first lift: expected at least "
            f"{duration_s:g} s"
        )
    return _walk_test(steps, begun, begun + duration_s, path_at(steps, begun + duration_s))


def _walk_test(steps: Steps, start_s: float, stop_s: float, distance_m: float) -> WalkTest:
    inside = (steps.place_s > start_s) & (steps.place_s <= stop_s)
    count = int(inside.sum())
    return WalkTest(start_s, stop_s, distance_m, count, steps.warnings, steps.settings)


TUG_PHASES = ("walk out", "first turn", "walk back", "second turn")


@dataclass(frozen=True, eq=False, repr=False)
class TimedUpAndGo(Result):
    """Phases of a Timed-Up and Go Test, each beginning where the one before ends.

    Parameters
    ----------
    boundary_s : (5,) array, s: first lift; lift of the first turning step; placement of the last;
        lift of the first turning step of the second turn; last placement of that turn
    distance_m : (4,) array, m, along the placements
    turn_rad : (4,) array, rad, left positive
    step_count : (4,) int array
    warnings : those of the steps
    settings : GaitSettings of the steps
    """

    boundary_s: FloatArray
    distance_m: FloatArray
    turn_rad: FloatArray
    step_count: NDArray[np.int64]
    warnings: tuple[str, ...] = ()
    settings: GaitSettings = field(default_factory=GaitSettings)

    def __post_init__(self) -> None:
        """Check that there is one entry for each phase."""
        check_fields(
            self, boundary_s=(5,), distance_m=(4,), turn_rad=(4,), step_count=[int, 4],
            settings=GaitSettings,
        )  # fmt: skip
        super().__post_init__()

    @property
    def duration_s(self) -> float:
        """Time in s from first lift to last placement, without standing up and sitting down."""
        return float(self.boundary_s[-1] - self.boundary_s[0])

    def to_frame(self) -> pd.DataFrame:
        """One row per phase."""
        import pandas as pd

        return pd.DataFrame(
            {
                "phase": TUG_PHASES,
                "start_s": self.boundary_s[:-1],
                "stop_s": self.boundary_s[1:],
                "duration_s": np.diff(self.boundary_s),
                "steps": self.step_count,
                "distance_m": self.distance_m,
                "turn_deg": np.rad2deg(self.turn_rad),
            }
        )


def timed_up_and_go(steps: Steps, *, least_turn_rad: float = float(np.deg2rad(90))) -> TimedUpAndGo:
    """Walks and turns of a Timed-Up and Go Test.

    From the first lift of the frame to the last placement of the second turn. It is shorter than
    the test: standing up before and sitting down after it happen while the frame stands, and an
    IMU on the frame does not tell them from waiting.

    Parameters
    ----------
    steps : Steps
    least_turn_rad : rad, half of what each of both turns should have

    Returns
    -------
    TimedUpAndGo

    Raises
    ------
    InputError
        If there are not two such turns, or no step before one of them.
    """
    _check(steps)
    if not as_number(least_turn_rad, "least_turn_rad") <= np.pi:
        raise InputError(f"least_turn_rad = {least_turn_rad}: expected up to pi (in deg?)")
    turns = find_turns(steps)
    large = np.nonzero(np.abs(turns.angle_rad) >= least_turn_rad)[0]
    if len(large) != 2:
        raise InputError(
            f"turns of {np.rad2deg(least_turn_rad):.0f} deg or more: found {len(large)}, expected 2"
        )
    first, last = turns.first_step[large], turns.last_step[large]
    edges = np.array([0, first[0], last[0] + 1, first[1], last[1] + 1])
    if (np.diff(edges) == 0).any():
        raise InputError("no step before the first turn, or none between both")
    lift, place = steps.lift_s, steps.place_s
    boundary = [lift[0], lift[first[0]], place[last[0]], lift[first[1]], place[last[1]]]
    path, turned = (np.r_[0.0, v] for v in (steps.path_m, np.cumsum(steps.turn_rad)))
    return TimedUpAndGo(
        np.array(boundary),
        np.diff(path[edges]),
        np.diff(turned[edges]),
        np.diff(edges),
        steps.warnings,
        steps.settings,
    )


def _check(steps: Steps) -> None:
    expect("steps", steps, Steps)
    if not len(steps):
        raise InputError("steps: there is none, expected a walk of one step or more")
