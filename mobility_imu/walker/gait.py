"""Steps of a walking frame, and what walking tests make of them. Goes past the paper.

A step is: lift the frame, put it down elsewhere, stand. Everything here is about the frame. The
user's own feet, left and right, sitting down and standing up, load and balance leave no trace that
could be read from an IMU on the frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.runs import runs_of
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd

_STILLNESS = StillnessSettings()
_LONGEST_SWING_S = 3.0
"""Nobody who walks holds the frame up for longer: such a move will be several."""
_STANDING_TILT_RAD = float(np.deg2rad(2))
"""A frame that stands leans with the floor; one that is in the air is pitched by more."""
_ROUNDING_M = 1e-9


@dataclass(frozen=True)
class GaitSettings:
    """What counts as a step.

    Parameters
    ----------
    least_length_m : m, a move of the body's origin by this much is a step
    least_turn_rad : rad, and so is one that turns by this much, even on the spot
    margin_s : s, what the stillness detector takes off each end of a still stretch: the sum of
        ``margin_s`` and ``shorten_s`` of the settings that it ran with
    """

    least_length_m: float = 0.05
    least_turn_rad: float = float(np.deg2rad(5))
    margin_s: float = _STILLNESS.margin_s + _STILLNESS.shorten_s

    def __post_init__(self) -> None:
        """Refuse what cannot be a setting."""
        for name, value in vars(self).items():
            if not np.isfinite(value) or value < 0 or (value == 0 and name != "margin_s"):
                raise InputError(f"{name} = {value}: expected a positive number")
        if self.least_turn_rad > np.pi / 2:
            raise InputError(f"least_turn_rad = {self.least_turn_rad}: expected rad (in deg?)")


@dataclass(frozen=True)
class Steps:
    """Steps of the frame, one entry each, in their order; the world is that of the trajectory.

    Parameters
    ----------
    lift_s, place_s : (k,) arrays, s, the frame leaves its stand, and stands again
    swing_s : (k,) array, s, from lifting to placing
    stance_s : (k,) array, s, from placing to the next lift; NaN for the last
    length_m : (k,) array, m, horizontal, of the body's origin; about 0 if it turns on the spot
    direction_rad : (k,) array, rad, course of the step; NaN if it is shorter than a step
    turn_rad : (k,) array, rad, left positive
    lift_height_m : (k,) array, m, highest point of the body's origin above the line from stand to
        stand; no better than a centimetre, since height drifts while the frame is in the air
    pitch_rad : (k,) array, rad, largest backward tilt (front up) on the way, against the stand
        before
    place_m : (k, 2) array, m, where the body's origin is put down
    start_m : (2,) array, m, where it stood before the first step
    warnings : what the user should know
    """

    lift_s: FloatArray
    place_s: FloatArray
    swing_s: FloatArray
    stance_s: FloatArray
    length_m: FloatArray
    direction_rad: FloatArray
    turn_rad: FloatArray
    lift_height_m: FloatArray
    pitch_rad: FloatArray
    place_m: FloatArray
    start_m: FloatArray
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Give the number of steps."""
        return len(self.lift_s)

    @property
    def path_m(self) -> FloatArray:
        """Way in m along the placements up to each one; it is not the distance from the start."""
        legs = np.diff(np.vstack([self.start_m, self.place_m]), axis=0)
        return np.asarray(np.cumsum(np.linalg.norm(legs, axis=1)))

    def to_frame(self) -> pd.DataFrame:
        """Give the table that ``mobility-imu walker trajectory --steps`` writes."""
        import pandas as pd

        return pd.DataFrame(
            {
                "step": np.arange(1, len(self) + 1),
                "lift_s": self.lift_s,
                "place_s": self.place_s,
                "swing_s": self.swing_s,
                "stance_s": self.stance_s,
                "length_m": self.length_m,
                "turn_deg": np.rad2deg(self.turn_rad),
                "lift_height_m": self.lift_height_m,
                "pitch_deg": np.rad2deg(self.pitch_rad),
                "x_m": self.place_m[:, 0],
                "y_m": self.place_m[:, 1],
            }
        )


def find_steps(trajectory: Trajectory, settings: GaitSettings | None = None) -> Steps:
    """Cut a walk into the steps of the frame.

    A move is what lies between two still stretches. It is a step if it goes far enough or turns
    far enough; any other, as from rocking, belongs to the stance around it and does not split it.
    A move that the recording begins or ends in is left out, and said.

    Parameters
    ----------
    trajectory : Trajectory
    settings : GaitSettings

    Returns
    -------
    Steps
        Both times are brought in by ``margin_s``. What is left is about a tenth of a second: the
        detector's running means see a move a little before it begins, and late if it begins
        gently.

    Raises
    ------
    InputError
        If the frame never stands, or a move lasts less than twice ``margin_s``.
    """
    settings = settings or GaitSettings()
    time, still = trajectory.time_s, trajectory.stationary
    if not still.any():
        raise InputError("trajectory: the frame never stands still, so no step begins or ends")
    moves = runs_of(~still)
    warnings = []
    if moves and moves[0].start == 0:
        warnings.append(
            f"the recording begins in a move, left out: until {time[moves[0].stop]:g} s"
        )
        del moves[0]
    if moves and moves[-1].stop == len(time):
        since = time[moves[-1].start]
        warnings.append(f"the recording ends in a move, left out: from {since:g} s")
        del moves[-1]
    # From the last still sample before a move to the first one after it.
    from_, to = np.array([(m.start - 1, m.stop) for m in moves], int).reshape(-1, 2).T
    floor, yaw = trajectory.position_m[:, :2], trajectory.yaw_rad
    way, turn = floor[to] - floor[from_], yaw[to] - yaw[from_]
    length = np.linalg.norm(way, axis=1)
    is_step = (length >= settings.least_length_m) | (np.abs(turn) >= settings.least_turn_rad)
    from_, to, way, turn, length = (part[is_step] for part in (from_, to, way, turn, length))
    lift, place = time[from_] + settings.margin_s, time[to] - settings.margin_s
    if (place < lift).any():
        raise InputError(
            f"margin_s = {settings.margin_s}: longer than half of the move at "
            f"{time[from_[np.argmax(place < lift)]]:g} s (was the detector set otherwise?)"
        )
    pitch = np.arcsin(np.clip(trajectory.rotation_body_to_world[:, 2, 0], -1, 1))
    shape = [_height_and_pitch(trajectory, pitch, a, b) for a, b in zip(from_, to, strict=True)]
    height, tilt = np.array(shape, float).reshape(-1, 2).T
    swing = place - lift
    warnings += _doubts(trajectory, swing)
    course = np.arctan2(way[:, 1], way[:, 0])
    return Steps(
        lift_s=lift,
        place_s=place,
        swing_s=swing,
        stance_s=np.r_[lift[1:], np.full(min(len(lift), 1), np.nan)] - place,
        length_m=length,
        direction_rad=np.where(length >= settings.least_length_m, course, np.nan),
        turn_rad=turn,
        lift_height_m=height,
        pitch_rad=tilt,
        place_m=floor[to],
        start_m=floor[from_[0]] if len(from_) else floor[np.argmax(still)],
        warnings=tuple(warnings),
    )


def _height_and_pitch(
    trajectory: Trajectory, pitch: FloatArray, from_: int, to: int
) -> tuple[float, float]:
    here = slice(from_, to + 1)
    z = trajectory.position_m[here, 2]
    line = np.linspace(z[0], z[-1], len(z))
    return float((z - line).max()), float((pitch[here] - pitch[from_]).max())


def _doubts(trajectory: Trajectory, swing_s: FloatArray) -> list[str]:
    """What makes a count doubtful: moves with no stand between them, stands in the air."""
    doubts = []
    limit = min(_LONGEST_SWING_S, 2 * float(np.median(swing_s))) if len(swing_s) else 0.0
    long = swing_s > limit
    if long.any():
        doubts.append(
            f"moves too long for one step: {long.sum()}, up to {swing_s.max():.1f} s; if the frame "
            "did not stand still between two steps, they count as one"
        )
    lean = np.arccos(np.clip(trajectory.rotation_body_to_world[:, 2, 2], -1, 1))
    usual = float(np.median(lean[trajectory.stationary]))
    stands = runs_of(trajectory.stationary)
    aslant = sum(float(np.median(lean[run])) > usual + _STANDING_TILT_RAD for run in stands)
    if aslant:
        doubts.append(
            f"stands that lean by {np.rad2deg(_STANDING_TILT_RAD):.0f} deg more than usual: "
            f"{aslant} of {len(stands)}; if the frame was in the air then, it moved so slowly that "
            "it passed for still: one step may count as two or none, and the path is too short"
        )
    return doubts


class Turns(NamedTuple):
    """Turns of a walk: consecutive steps that turn, all in one sense.

    Parameters
    ----------
    start_s, stop_s : (k,) arrays, s, first lift and last placement
    angle_rad : (k,) array, rad, left positive
    first_step, last_step : (k,) int arrays, counted from 0
    """

    start_s: FloatArray
    stop_s: FloatArray
    angle_rad: FloatArray
    first_step: np.ndarray
    last_step: np.ndarray


def find_turns(steps: Steps, settings: GaitSettings | None = None) -> Turns:
    """Join consecutive turning steps of one sense to turns.

    Parameters
    ----------
    steps : Steps
    settings : GaitSettings, whose ``least_turn_rad`` makes a step a turning one

    Returns
    -------
    Turns
    """
    settings = settings or GaitSettings()
    sense = np.sign(steps.turn_rad) * (np.abs(steps.turn_rad) >= settings.least_turn_rad)
    runs = [run for side in (-1, 1) for run in runs_of(sense == side)]
    runs.sort(key=lambda run: run.start)
    first, last = np.array([(r.start, r.stop - 1) for r in runs], int).reshape(-1, 2).T
    angle = np.array([steps.turn_rad[run].sum() for run in runs])
    return Turns(steps.lift_s[first], steps.place_s[last], angle, first, last)


@dataclass(frozen=True)
class WalkingSummary:
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

    def to_frame(self) -> pd.DataFrame:
        """Give one row of numbers, with the number of turns and their sum without sign."""
        import pandas as pd

        row = {name: value for name, value in vars(self).items() if name != "turns"}
        row["turn_count"] = len(self.turns.angle_rad)
        row["turned_deg"] = float(np.rad2deg(np.abs(self.turns.angle_rad).sum()))
        return pd.DataFrame([row])


def walking_summary(
    steps: Steps, trajectory: Trajectory, settings: GaitSettings | None = None
) -> WalkingSummary:
    """Sum a walk up.

    Parameters
    ----------
    steps : Steps
    trajectory : Trajectory that they were found in
    settings : GaitSettings that they were found with

    Returns
    -------
    WalkingSummary
        What takes more steps than there are is NaN.

    Raises
    ------
    InputError
        If there is no step.
    """
    _check(trajectory, steps)
    going = steps.length_m[np.abs(steps.turn_rad) < (settings or GaitSettings()).least_turn_rad]
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
        turns=find_turns(steps, settings),
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
    knots = np.r_[steps.lift_s[0], steps.place_s]
    return float(np.interp(time_s, knots, np.r_[0.0, steps.path_m]))


def time_at(steps: Steps, path_m: float) -> float:
    """When the way along the placements reaches a length, s: the inverse of :func:`path_at`.

    Parameters
    ----------
    steps : Steps, at least one
    path_m : m, positive

    Raises
    ------
    InputError
        If the way is shorter.
    """
    path = steps.path_m
    if path_m > path[-1] + _ROUNDING_M:
        raise InputError(f"the walk is {path[-1]:.2f} m long: shorter than {path_m:g} m")
    knots, way = np.r_[steps.lift_s[0], steps.place_s], np.r_[0.0, path]
    k = max(int(np.searchsorted(way, path_m - _ROUNDING_M)), 1)
    share = (path_m - way[k - 1]) / (way[k] - way[k - 1])
    return float(knots[k - 1] + np.clip(share, 0, 1) * (knots[k] - knots[k - 1]))


@dataclass(frozen=True)
class WalkTest:
    """A timed walk of the frame.

    Parameters
    ----------
    start_s, stop_s : s, on the recording's clock
    distance_m : m, along the placements in this time
    step_count : steps put down in this time
    """

    start_s: float
    stop_s: float
    distance_m: float
    step_count: int

    @property
    def duration_s(self) -> float:
        """Time taken, s."""
        return self.stop_s - self.start_s

    @property
    def speed_mps(self) -> float:
        """Distance over time, m/s."""
        return self.distance_m / self.duration_s


def ten_metre_walk(
    trajectory: Trajectory,
    steps: Steps,
    *,
    start: Literal["static", "rolling"],
    distance_m: float = 10.0,
    run_up_m: float = 2.0,
) -> WalkTest:
    """Time over a stretch of the way, as in the 10-Metre Walk Test.

    The middle of the rear tips passes the lines here, in a test the leading foot. Between two
    placements the way grows evenly, see :func:`path_at`; the frame itself, which stands first and
    then jumps, passes a line up to two thirds of a step later.

    Parameters
    ----------
    trajectory : Trajectory
    steps : Steps found in it
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
    _check(trajectory, steps)
    if start not in ("static", "rolling"):
        raise InputError(f"start = {start!r}: expected 'static' or 'rolling'")
    if not (np.isfinite(distance_m) and distance_m > 0):
        raise InputError(f"distance_m = {distance_m}: expected a positive number")
    from_m, to_m = (0.0, distance_m) if start == "static" else (run_up_m, distance_m - run_up_m)
    if start == "rolling" and not 0 < run_up_m < distance_m / 2:
        raise InputError(f"run_up_m = {run_up_m}: expected less than half of {distance_m:g} m")
    begun = float(steps.lift_s[0]) if start == "static" else time_at(steps, from_m)
    return _walk_test(steps, begun, time_at(steps, to_m), to_m - from_m)


def six_minute_walk(trajectory: Trajectory, steps: Steps, duration_s: float = 360.0) -> WalkTest:
    """Distance walked in a time, as in the 6-Minute Walk Test: from the first lift on.

    What is under way when the time is up counts in part, by its share of the time between two
    placements (:func:`path_at`); nothing of it if the recording ends before the second.

    Parameters
    ----------
    trajectory : Trajectory
    steps : Steps found in it
    duration_s : s

    Returns
    -------
    WalkTest

    Raises
    ------
    InputError
        If the recording ends before the time is up, or there is no step.
    """
    _check(trajectory, steps)
    if not (np.isfinite(duration_s) and duration_s > 0):
        raise InputError(f"duration_s = {duration_s}: expected a positive number")
    begun = float(steps.lift_s[0])
    recorded = float(trajectory.time_s[-1]) - begun
    if recorded < duration_s:
        raise InputError(
            f"the recording goes on for {recorded:.1f} s after the first lift: expected at least "
            f"{duration_s:g} s"
        )
    return _walk_test(steps, begun, begun + duration_s, path_at(steps, begun + duration_s))


def _walk_test(steps: Steps, start_s: float, stop_s: float, distance_m: float) -> WalkTest:
    inside = (steps.place_s > start_s) & (steps.place_s <= stop_s)
    return WalkTest(start_s, stop_s, distance_m, int(inside.sum()))


TUG_PHASES = ("walk out", "first turn", "walk back", "second turn")


@dataclass(frozen=True)
class TimedUpAndGo:
    """Phases of a Timed-Up and Go Test, each beginning where the one before ends.

    Parameters
    ----------
    boundary_s : (5,) array, s: first lift; lift of the first turning step; placement of the last;
        lift of the first turning step of the second turn; last placement of that turn
    distance_m : (4,) array, m, along the placements
    turn_rad : (4,) array, rad, left positive
    step_count : (4,) int array
    """

    boundary_s: FloatArray
    distance_m: FloatArray
    turn_rad: FloatArray
    step_count: np.ndarray

    @property
    def duration_s(self) -> float:
        """Time in s from first lift to last placement, without standing up and sitting down."""
        return float(self.boundary_s[-1] - self.boundary_s[0])

    def to_frame(self) -> pd.DataFrame:
        """Give one row per phase."""
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


def timed_up_and_go(
    trajectory: Trajectory,
    steps: Steps,
    *,
    least_turn_rad: float = float(np.deg2rad(90)),
    settings: GaitSettings | None = None,
) -> TimedUpAndGo:
    """Find the walks and turns of a Timed-Up and Go Test.

    From the first lift of the frame to the last placement of the second turn. It is shorter than
    the test: standing up before and sitting down after it happen while the frame stands, and an
    IMU on the frame does not tell them from waiting.

    Parameters
    ----------
    trajectory : Trajectory
    steps : Steps found in it
    least_turn_rad : rad, half of what each of both turns should have
    settings : GaitSettings that the steps were found with

    Returns
    -------
    TimedUpAndGo

    Raises
    ------
    InputError
        If there are not two such turns, or no step before one of them.
    """
    _check(trajectory, steps)
    if not 0 < least_turn_rad <= np.pi:
        raise InputError(f"least_turn_rad = {least_turn_rad}: expected up to pi (in deg?)")
    turns = find_turns(steps, settings)
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
        np.array(boundary), np.diff(path[edges]), np.diff(turned[edges]), np.diff(edges)
    )


def _check(trajectory: Trajectory, steps: Steps) -> None:
    if not len(steps):
        raise InputError("steps: there is none")
    if steps.lift_s[0] < trajectory.time_s[0] or steps.place_s[-1] > trajectory.time_s[-1]:
        raise InputError("steps: not of this trajectory, their times lie outside it")
