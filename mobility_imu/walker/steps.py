"""Steps and turns of a walking frame. Goes past the paper.

A step is: lift the frame, put it down elsewhere, stand. Everything here is about the frame. The
user's own feet, left and right, sitting down and standing up, load and balance leave no trace that
could be read from an IMU on the frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import check_columns, check_shape, expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, check_positive
from mobility_imu.results import Result
from mobility_imu.runs import runs_of
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["GaitSettings", "Steps", "Turns", "find_steps", "find_turns"]

_LONGEST_SWING_S = 3.0
"""Nobody who walks holds the frame up for longer; such a move will be several."""
_STANDING_TILT_RAD = float(np.deg2rad(2))
"""A frame that stands leans with the floor; one that is in the air is pitched by more."""


@dataclass(frozen=True)
class GaitSettings:
    """What counts as a step.

    Parameters
    ----------
    least_length_m : m, a move of the body's origin by this much is a step
    least_turn_rad : rad, and so is one that turns by this much, even on the spot
    """

    least_length_m: float = 0.05
    least_turn_rad: float = float(np.deg2rad(5))

    def __post_init__(self) -> None:
        """Check that both are positive, and the turn an angle in rad."""
        check_positive(self)
        if self.least_turn_rad > np.pi / 2:
            raise InputError(f"least_turn_rad = {self.least_turn_rad}: expected rad (in deg?)")


COLUMNS = (
    "lift_s", "place_s", "swing_s", "stance_s", "length_m", "direction_rad", "turn_rad",
    "lift_height_m", "pitch_rad",
)  # fmt: skip
"""Series of steps that have one number each."""


@dataclass(frozen=True, eq=False, repr=False)
class Steps(Result):
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
    recorded_s : (2,) array, s, first and last time of the recording
    warnings : what the user should know
    settings : GaitSettings that they were found with
    stillness : StillnessSettings of the detector that found the rests; None if they were given
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
    recorded_s: FloatArray
    warnings: tuple[str, ...] = ()
    settings: GaitSettings = field(default_factory=GaitSettings, kw_only=True)
    stillness: StillnessSettings | None = field(default_factory=StillnessSettings, kw_only=True)

    def __post_init__(self) -> None:
        """Check that there is one entry for each step."""
        expect("settings", self.settings, GaitSettings)
        if self.stillness is not None:
            expect("stillness", self.stillness, StillnessSettings)
        check_columns(self, *COLUMNS)
        check_shape(self, "place_m", (len(self.lift_s), 2))
        for name in ("start_m", "recorded_s"):
            check_shape(self, name, (2,))
        check_fields(self)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self.lift_s)

    @property
    def path_m(self) -> FloatArray:
        """Way in m along the placements up to each one; it is not the distance from the start."""
        legs = np.diff(np.vstack([self.start_m, self.place_m]), axis=0)
        return np.asarray(np.cumsum(np.linalg.norm(legs, axis=1)))

    def to_frame(self) -> pd.DataFrame:
        """Table that ``mobility-imu walker trajectory --steps`` writes."""
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

    A move is what lies between two still intervals. It is a step if it goes far enough or turns
    far enough; any other, as from rocking, belongs to the stance around it and does not split it.
    A move that the recording begins or ends in is left out, with a warning.

    Parameters
    ----------
    trajectory : Trajectory; it knows the settings of its stillness detector
    settings : GaitSettings

    Returns
    -------
    Steps
        Both times are brought in by what the detector takes off the ends of a rest (by nothing if
        the rests were given). What is left
        is about a tenth of a second: its running means see a move a little before it begins, and
        late if it begins gently.

    Raises
    ------
    InputError
        If the frame never stands, or a move is shorter than what the detector took off both rests
        around it.
    """
    expect("trajectory", trajectory, Trajectory)
    settings = settings_or_default("settings", settings, GaitSettings)
    time, still = trajectory.time_s, trajectory.stationary
    if not still.any():
        raise InputError("trajectory: the frame never stands still, so no step begins or ends")
    moves = runs_of(~still)
    warnings = []
    margin_s = 0.0 if trajectory.stillness is None else trajectory.stillness.eroded_s
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
    length = np.hypot(*way.T)
    is_step = (length >= settings.least_length_m) | (np.abs(turn) >= settings.least_turn_rad)
    from_, to, way, turn, length = (part[is_step] for part in (from_, to, way, turn, length))
    lift, place = time[from_] + margin_s, time[to] - margin_s
    if (place < lift).any():
        raise InputError(
            f"margin_s and shorten_s of the stillness detector, {margin_s:g} s in all, are longer "
            f"than half of the move at {time[from_[np.argmax(place < lift)]]:g} s: make them "
            "shorter"
        )
    pitch = np.arcsin(np.clip(trajectory.rotation_body_to_world[:, 2, 0], -1, 1))
    shape = [_height_and_pitch(trajectory, pitch, a, b) for a, b in zip(from_, to, strict=True)]
    height, tilt = np.array(shape, float).reshape(-1, 2).T
    swing = place - lift
    warnings += _uncertain_count(trajectory, swing)
    if not len(lift):
        warnings.append("no step found: is it a walk?")
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
        recorded_s=time[[0, -1]],
        warnings=tuple(warnings),
        settings=settings,
        stillness=trajectory.stillness,
    )


def _height_and_pitch(
    trajectory: Trajectory, pitch: FloatArray, from_: int, to: int
) -> tuple[float, float]:
    here = slice(from_, to + 1)
    z = trajectory.position_m[here, 2]
    line = np.linspace(z[0], z[-1], len(z))
    return float((z - line).max()), float((pitch[here] - pitch[from_]).max())


def _uncertain_count(trajectory: Trajectory, swing_s: FloatArray) -> list[str]:
    """What makes a count uncertain: moves with no stand between them, stands in the air."""
    found = []
    limit = min(_LONGEST_SWING_S, 2 * float(np.median(swing_s))) if len(swing_s) else 0.0
    long = swing_s > limit
    if long.any():
        found.append(
            f"moves too long for one step: {long.sum()}, up to {swing_s.max():.1f} s; if the frame "
            "did not stand still between two steps, they count as one"
        )
    lean = np.arccos(np.clip(trajectory.rotation_body_to_world[:, 2, 2], -1, 1))
    usual = float(np.median(lean[trajectory.stationary]))
    stands = runs_of(trajectory.stationary)
    aslant = sum(float(np.median(lean[run])) > usual + _STANDING_TILT_RAD for run in stands)
    if aslant:
        found.append(
            f"stands that lean by {np.rad2deg(_STANDING_TILT_RAD):.0f} deg more than usual: "
            f"{aslant} of {len(stands)}; if the frame was in the air then, it moved so slowly that "
            "it passed for still: one step may count as two or none, and the path is too short"
        )
    return found


@dataclass(frozen=True, eq=False, repr=False)
class Turns(Result):
    """Turns of a walk: consecutive steps that turn, all in one sense.

    Parameters
    ----------
    start_s, stop_s : (k,) arrays, s, first lift and last placement
    angle_rad : (k,) array, rad, left positive
    first_step, last_step : (k,) int arrays, counted from 0
    settings : GaitSettings of the steps
    warnings : those of the steps
    """

    start_s: FloatArray
    stop_s: FloatArray
    angle_rad: FloatArray
    first_step: NDArray[np.int64]
    last_step: NDArray[np.int64]
    settings: GaitSettings = field(default_factory=GaitSettings)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that there is one entry for each turn."""
        check_columns(self, "start_s", "stop_s", "angle_rad")
        steps = [int, len(self.start_s)]
        check_fields(self, first_step=steps, last_step=steps, settings=GaitSettings)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of turns."""
        return len(self.angle_rad)

    def to_frame(self) -> pd.DataFrame:
        """Table with one row per turn; steps are counted from 1, as in the table of the steps."""
        import pandas as pd

        return pd.DataFrame(
            {
                "start_s": self.start_s,
                "stop_s": self.stop_s,
                "turn_deg": np.rad2deg(self.angle_rad),
                "first_step": self.first_step + 1,
                "last_step": self.last_step + 1,
            }
        )


def find_turns(steps: Steps) -> Turns:
    """Turns: consecutive turning steps of one sense, joined.

    Parameters
    ----------
    steps : Steps; ``least_turn_rad`` of their settings makes a step a turning one

    Returns
    -------
    Turns
    """
    expect("steps", steps, Steps)
    sense = np.sign(steps.turn_rad) * (np.abs(steps.turn_rad) >= steps.settings.least_turn_rad)
    runs = [run for side in (-1, 1) for run in runs_of(sense == side)]
    runs.sort(key=lambda run: run.start)
    first, last = np.array([(r.start, r.stop - 1) for r in runs], int).reshape(-1, 2).T
    angle = np.array([steps.turn_rad[run].sum() for run in runs])
    return Turns(
        steps.lift_s[first],
        steps.place_s[last],
        angle,
        first,
        last,
        steps.settings,
        steps.warnings,
    )
