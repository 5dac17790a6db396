"""Locomotor tasks from a chair's velocities (section 2 of the document, steps 1-6).

Where the document is silent the public tool decides, and each such choice is named here. All
offsets of the piecewise aggregate approximation together are the means of the windows that start
at each frame, so a vote over offsets is a vote over the windows that cover a frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import check_columns, expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import (
    FloatArray,
    as_clock,
    as_count,
    as_flags,
    as_floats,
    as_number,
    one_of,
)
from mobility_imu.results import Result
from mobility_imu.runs import changes_of, runs_of
from mobility_imu.wheelchair.codes import Codes, Task, as_codes
from mobility_imu.wheelchair.series import alike, as_motion
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.validity import known_tasks, on_unknown

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "Codes",
    "Edge",
    "Symbols",
    "Task",
    "TaskSteps",
    "Tasks",
    "Velocities",
    "curvature_radius",
    "find_pattern",
    "identify_tasks",
    "reduce_variability",
    "refine_edges",
    "symbolic_signals",
    "task_codes",
    "task_steps",
    "window_means",
]

Edge = Literal["covering", "tool"]

# Frames that are worked on at once: the few arrays of a block stay in the processor's cache.
BLOCK = 16384


def curvature_radius(linear_velocity_mps: ArrayLike, yaw_rate_radps: ArrayLike) -> FloatArray:
    """Radius of the path's curvature (eq. 2.1).

    The document lists the yaw rate in deg/s; the radius is in metres only with rad/s. Without
    any turning the radius is infinite, also at rest.

    Parameters
    ----------
    linear_velocity_mps : (n,) array, m/s
    yaw_rate_radps : (n,) array, rad/s

    Returns
    -------
    (n,) array, m, not negative

    Examples
    --------
    >>> curvature_radius([1.0, 0.0, 0.0], [0.5, 1.0, 0.0]).tolist()
    [2.0, 0.0, inf]
    """
    velocity, yaw_rate = alike(
        linear_velocity_mps=linear_velocity_mps, yaw_rate_radps=yaw_rate_radps
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        radius = np.abs(velocity / yaw_rate)
    return np.where(yaw_rate == 0, np.inf, radius)


@dataclass(frozen=True, eq=False, repr=False)
class Symbols(Result):
    """The four symbolic signals of steps 2 and 3: 0, 1, 2 stand for a, b, c.

    Parameters
    ----------
    velocity, speed, yaw_rate, radius : (n,) arrays of 0, 1, 2
    """

    velocity: Codes
    speed: Codes
    yaw_rate: Codes
    radius: Codes

    def __post_init__(self) -> None:
        """Check that all four are letters of one length."""
        count = as_floats(self.velocity, "symbols.velocity").size
        for name in ("velocity", "speed", "yaw_rate", "radius"):
            codes = as_codes(getattr(self, name), f"symbols.{name}", (0, 1, 2), length=count)
            object.__setattr__(self, name, codes)
        super().__post_init__()


@dataclass(frozen=True, eq=False, repr=False)
class TaskSteps(Result):
    """What each step gives: for the chapters that show them one by one.

    Parameters
    ----------
    symbols : Symbols of steps 1 and 2
    pattern, refined, reduced : (n,) arrays of task codes after steps 3, 4 and 5
    settings : TaskSettings that were used
    warnings : sentences on how the settings were met; empty if they were met exactly
    """

    symbols: Symbols
    pattern: Codes
    refined: Codes
    reduced: Codes
    settings: TaskSettings = field(default_factory=TaskSettings)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that all are of one length."""
        check_fields(self, symbols=Symbols, settings=TaskSettings)
        for name in ("pattern", "refined", "reduced"):
            codes = as_codes(getattr(self, name), name, length=len(self.symbols.velocity))
            object.__setattr__(self, name, codes)
        super().__post_init__()


class Velocities(Protocol):
    """What tasks are identified from: a ``ChairVelocity``, or a series from a file."""

    @property
    def time_s(self) -> FloatArray:
        """Times, (n,) array, s."""
        ...

    @property
    def linear_velocity_mps(self) -> FloatArray:
        """Velocity, (n,) array, m/s, forward positive."""
        ...

    @property
    def yaw_rate_radps(self) -> FloatArray:
        """Yaw rate, (n,) array, rad/s, left positive."""
        ...

    @property
    def sampling_rate_hz(self) -> float:
        """Samples per second."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class Tasks(Result):
    """Task of each frame of a drive.

    Parameters
    ----------
    time_s : (n,) array, s, even
    codes : (n,) array of int8, codes of :class:`Task`
    linear_velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s, as they were given
    settings : TaskSettings that were used
    edge : how the first frames were treated
    warnings : sentences on how the settings were met, and on velocities that are not valid; empty
        if there is nothing to say
    valid : (n,) bool array, False where a velocity that the frame's task comes from is not valid;
        the task there is not known. All True if None
    """

    time_s: FloatArray
    codes: Codes
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    settings: TaskSettings = field(default_factory=TaskSettings)
    edge: Edge = "covering"
    warnings: tuple[str, ...] = ()
    valid: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        """Check that all are series of one length, and the codes those of tasks."""
        expect("settings", self.settings, TaskSettings)
        one_of("edge", self.edge, ("covering", "tool"))
        if self.valid is None:
            known = np.ones(as_floats(self.time_s, "time_s").size, np.bool_)
            object.__setattr__(self, "valid", known)
        series = ("time_s", "linear_velocity_mps", "yaw_rate_radps")
        check_columns(self, *series, flags=("valid",))
        object.__setattr__(self, "codes", as_codes(self.codes, length=len(self.time_s)))
        check_fields(self)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.codes)

    def to_frame(self) -> pd.DataFrame:
        """Columns of the tasks' CSV, the yaw rate in deg/s.

        Returns
        -------
        DataFrame
            ``time_s``, ``linear_velocity_mps``, ``yaw_rate_degps``, ``task_code``, ``task`` and
            ``valid`` (0 or 1)
        """
        import pandas as pd

        assert self.valid is not None
        names = np.array(["", *(task.title for task in Task)])
        return pd.DataFrame(
            {
                "time_s": self.time_s,
                "linear_velocity_mps": self.linear_velocity_mps,
                "yaw_rate_degps": np.rad2deg(self.yaw_rate_radps),
                "task_code": self.codes,
                "task": names[self.codes],
                "valid": self.valid.astype(int),
            }
        )


def window_means(values: ArrayLike, length: int) -> FloatArray:
    """Means of the windows that start at each frame: all offsets at once (step 1).

    The last windows are cut by the end of the series and averaged over what they hold.

    Parameters
    ----------
    values : (n,) array
    length : frames in a window

    Returns
    -------
    (n,) array; element s is the mean of values[s : s + length]

    Examples
    --------
    >>> window_means([1.0, 2.0, 6.0], 2).tolist()
    [1.5, 4.0, 6.0]
    """
    x, length = as_floats(values, "values"), as_count(length, "length")
    if x.ndim != 1:
        raise InputError(f"values: expected one time series, got an array of shape {x.shape}")
    total = np.zeros(len(x))
    # Added in the order of the frames: a cumulative sum would lose precision after one huge radius.
    for k in range(min(length, len(x))):
        total[: len(x) - k] += x[k:]
    return total / np.minimum(min(length, len(x)), np.arange(len(x), 0, -1))


def identify_tasks(
    drive: Velocities, settings: TaskSettings | None = None, *, edge: Edge = "covering"
) -> Tasks:
    """Task of every frame of a drive (section 2).

    Parameters
    ----------
    drive : ChairVelocity of :func:`~mobility_imu.wheelchair.velocity.estimate_velocity`, or a
        series of :func:`~mobility_imu.readers.velocities.read_velocities`; where its ``valid`` is
        False the velocities are not known, and the tasks found from them are not valid either
    settings : TaskSettings; the document's defaults if None
    edge : as for :func:`task_codes`

    Returns
    -------
    Tasks

    Raises
    ------
    InputError
        If the times are not even, the series differ in length, hold NaN or what nothing moves at,
        or are shorter than one segment.
    """
    missing = [
        name
        for name in ("time_s", "linear_velocity_mps", "yaw_rate_radps", "sampling_rate_hz")
        if not hasattr(drive, name)
    ]
    if missing:
        raise InputError(
            f"drive: got {type(drive).__name__} without {', '.join(missing)}; expected what "
            "estimate_velocity gives (task_codes takes arrays)"
        )
    time_s = as_clock(drive.time_s, even=True)
    steps = task_steps(
        drive.linear_velocity_mps, drive.yaw_rate_radps, drive.sampling_rate_hz, settings, edge=edge
    )
    if len(steps.reduced) != len(time_s):
        raise InputError(f"time_s: {len(time_s)} times for {len(steps.reduced)} velocities")
    given = getattr(drive, "valid", None)
    known = np.ones(len(time_s), np.bool_)
    if given is not None:
        known = as_flags(given, "valid", length=len(time_s))
    segment, _ = steps.settings.frames(as_number(drive.sampling_rate_hz, "sampling_rate_hz"))
    return Tasks(
        time_s=time_s,
        codes=steps.reduced,
        linear_velocity_mps=as_motion(drive.linear_velocity_mps, "linear_velocity_mps"),
        yaw_rate_radps=as_motion(drive.yaw_rate_radps, "yaw_rate_radps"),
        settings=steps.settings,
        edge=edge,
        warnings=(*steps.warnings, *on_unknown(time_s, known)),
        valid=known_tasks(known, segment),
    )


def task_codes(
    linear_velocity_mps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    sampling_rate_hz: float,
    settings: TaskSettings | None = None,
    *,
    edge: Edge = "covering",
) -> Codes:
    """Task of every frame of two series (section 2); :func:`identify_tasks` takes a drive.

    Parameters
    ----------
    linear_velocity_mps : (n,) array, m/s, forward positive
    yaw_rate_radps : (n,) array, rad/s; its sign does not matter
    sampling_rate_hz : Hz
    settings : TaskSettings; the document's defaults if None
    edge : for the first frames, which not all offsets cover. "covering" lets only windows vote
        that cover the frame; "tool" counts the missing ones as no motion, as the public tool does

    Returns
    -------
    (n,) array of int8, codes of :class:`Task`

    Raises
    ------
    InputError
        If the series differ in length, hold NaN or what nothing moves at, or are shorter than one
        segment.

    Examples
    --------
    >>> velocity = np.r_[np.zeros(100), np.full(100, 1.2)]
    >>> codes = task_codes(velocity, np.zeros(200), 100)
    >>> [Task(code).title for code in codes[[0, -1]]]
    ['static', 'forward propulsion']
    """
    return task_steps(
        linear_velocity_mps, yaw_rate_radps, sampling_rate_hz, settings, edge=edge
    ).reduced


def task_steps(
    linear_velocity_mps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    sampling_rate_hz: float,
    settings: TaskSettings | None = None,
    *,
    edge: Edge = "covering",
) -> TaskSteps:
    """What each step gives; the last one is what :func:`task_codes` returns.

    Parameters
    ----------
    linear_velocity_mps, yaw_rate_radps, sampling_rate_hz, settings, edge : as for
        :func:`task_codes`

    Returns
    -------
    TaskSteps

    Raises
    ------
    InputError
        As for :func:`task_codes`.
    """
    settings = settings_or_default("settings", settings, TaskSettings)
    one_of("edge", edge, ("covering", "tool"))
    fs = as_number(sampling_rate_hz, "sampling_rate_hz")
    velocity = as_motion(linear_velocity_mps, "linear_velocity_mps")
    yaw_rate = as_motion(yaw_rate_radps, "yaw_rate_radps", length=len(velocity))
    segment, look = settings.frames(fs)
    if len(velocity) < segment:
        raise InputError(
            f"{len(velocity)} frames are fewer than the {segment} of one segment "
            f"({settings.segment_s} s at {fs:g} Hz)"
        )
    symbols = symbolic_signals(velocity, yaw_rate, segment, settings, edge)
    pattern = find_pattern(symbols)
    refined = refine_edges(pattern, np.abs(velocity), np.abs(np.rad2deg(yaw_rate)), look, settings)
    reduced = reduce_variability(refined, segment)
    return TaskSteps(symbols, pattern, refined, reduced, settings, settings.rounding(fs))


def symbolic_signals(
    velocity: FloatArray, yaw_rate: FloatArray, segment: int, settings: TaskSettings, edge: Edge
) -> Symbols:
    """Steps 1 and 2: window means, thresholds of Table 1, and the vote for each frame.

    Parameters
    ----------
    velocity, yaw_rate : (n,) arrays, m/s and rad/s
    segment : frames in a segment
    settings : TaskSettings
    edge : see :func:`identify_tasks`

    Returns
    -------
    Symbols, four (n,) arrays
    """
    n = len(velocity)
    letters = [np.empty(n, np.int8) for _ in range(4)]
    for start in range(0, n, BLOCK):
        stop = min(start + BLOCK, n)
        # Windows that cover these frames start up to a segment earlier and end up to one later.
        low, high = max(start - segment + 1, 0), min(stop + segment - 1, n)
        v, w = velocity[low:high], yaw_rate[low:high]
        windows = stop - low
        speed = np.abs(v)
        means = (
            _block_means(v, windows, segment),
            _block_means(speed, windows, segment),
            _block_means(np.abs(np.rad2deg(w)), windows, segment),
            _block_means(curvature_radius(v, w), windows, segment),
        )
        limit = settings.linear_velocity_mps
        never = np.zeros(windows, bool)
        pivot = means[3] <= settings.pivot_radius_m
        # Per signal: which windows vote a, which vote c; the rest vote b.
        ballots = (
            (means[0] <= -limit, means[0] >= limit),
            (never, means[1] >= limit),
            (never, means[2] >= settings.yaw_rate_degps),
            (pivot, ~pivot & ~(means[3] < settings.wide_radius_m)),
        )
        voters = np.minimum(np.arange(start, stop) + 1, segment)
        # Offsets that do not reach back to a frame: the tool takes them for b, the radius for c.
        missing = segment - voters if edge == "tool" else 0
        for symbol, (vote_a, vote_c) in zip(letters, ballots, strict=True):
            a, c = (_count(vote, start - low, stop - start, segment) for vote in (vote_a, vote_c))
            b = voters - a - c
            if symbol is letters[-1]:
                c = c + missing
            else:
                b = b + missing
            # The most votes win; of equals the first letter.
            symbol[start:stop] = np.where((a >= b) & (a >= c), 0, np.where(b >= c, 1, 2))
    return Symbols(*letters)


def _block_means(values: FloatArray, windows: int, segment: int) -> FloatArray:
    """Means of the windows starting at the first ``windows`` values (cut where values end)."""
    count = len(values)
    if count >= windows + segment - 1:
        total = values[:windows].copy()
        for k in range(1, segment):
            total += values[k : k + windows]
        total /= segment
        return total
    return window_means(values, segment)[:windows]


def _count(flags: NDArray[np.bool_], skip: int, frames: int, segment: int) -> NDArray[np.int32]:
    """For each frame, how many of the last ``segment`` windows carry the flag."""
    total = np.cumsum(flags, dtype=np.int32)
    here = total[skip : skip + frames].copy()
    first = skip - segment
    if first >= 0:
        here -= total[first : first + frames]
    elif frames > -first:
        here[-first:] -= total[: frames + first]
    return here


def find_pattern(symbols: Symbols) -> Codes:
    """Step 3: the task of each frame by Table 2.

    The table leaves frames open whose speed is high but whose velocity is neither (rocking back
    and forth within a segment); they count as forward propulsion, as in the public tool.

    Parameters
    ----------
    symbols : Symbols

    Returns
    -------
    (n,) array of task codes
    """
    turning = symbols.yaw_rate == 2
    travelling = symbols.speed == 2
    straight = np.where(symbols.velocity == 0, Task.BACKWARD, Task.FORWARD)
    still = np.where(travelling, straight, Task.STATIC)
    return np.where(turning, Task.PIVOT + symbols.radius, still).astype(np.int8)


def refine_edges(
    codes: Codes,
    speed_mps: FloatArray,
    turning_degps: FloatArray,
    look: int,
    settings: TaskSettings,
) -> Codes:
    """Step 4: move the start and the end of each task to where the motion begins and ends.

    From the first frame of a task back, and from the first frame after it on, up to ``look``
    frames are searched for one below the onset threshold; the task grows up to that frame. If
    there is none it stays. Forward comes first, then backward, then the rotations, which so take
    precedence. The search after a task starts one frame late (as in the tool): where it succeeds
    the task grows by a frame at least.

    Parameters
    ----------
    codes : (n,) array of task codes
    speed_mps, turning_degps : (n,) arrays, sizes of velocity and yaw rate, m/s and deg/s
    look : frames
    settings : TaskSettings

    Returns
    -------
    (n,) array of task codes
    """
    codes = as_codes(codes).copy()
    slow = speed_mps < settings.onset_velocity_mps
    for task in (Task.FORWARD, Task.BACKWARD):
        for first, stop, _ in _extensions(codes == task, slow, look):
            codes[first:stop] = task
    calm = turning_degps < settings.onset_yaw_rate_degps
    for first, stop, inside in _extensions(codes >= Task.PIVOT, calm, look):
        codes[first:stop] = codes[inside]
    return codes


def _extensions(
    active: NDArray[np.bool_], calm: NDArray[np.bool_], look: int
) -> Iterator[tuple[int, int, int]]:
    """Intervals [first, stop) by which runs grow, with a frame of the run, in the frames' order."""
    n = len(active)
    runs = runs_of(active)
    onsets = np.array([run.start for run in runs], int)
    ends = np.array([run.stop for run in runs if run.stop < n], int)
    index = np.arange(n)
    last_calm = np.maximum.accumulate(np.where(calm, index, -1))
    next_calm = np.minimum.accumulate(np.where(calm, index, n)[::-1])[::-1]
    onsets = onsets[onsets > 0]
    before = last_calm[onsets - 1]
    found = (before >= 0) & (before >= onsets - look)
    early = np.stack([before + 1, onsets, onsets])[:, found]
    ends = ends[ends + 1 < n]
    after = next_calm[ends + 1]
    found = (after < n) & (after <= ends + look)
    late = np.stack([ends, after, ends - 1])[:, found]
    both = np.concatenate([early, late], axis=1)
    # A later transition overwrites an earlier one: go by where the run begins or ends.
    order = np.argsort(np.concatenate([early[1], late[0]]), kind="stable")
    yield from zip(*both[:, order].tolist(), strict=True)


def reduce_variability(codes: Codes, segment: int) -> Codes:
    """Step 5: short tasks between two runs of one and the same task become that task.

    The document's example gives the length, a single segment; its general sentence alone has
    none, and a whole slalom would become one task. The tool takes what is shorter than a segment,
    from left to right, until nothing changes; so does this.

    Parameters
    ----------
    codes : (n,) array of task codes
    segment : frames; runs of fewer frames may be absorbed

    Returns
    -------
    (n,) array of task codes
    """
    codes, segment = as_codes(codes), as_count(segment, "segment", least=0)
    while True:
        starts = changes_of(codes)
        if len(starts) < 3:
            return codes
        lengths = np.diff(np.r_[starts, len(codes)])
        label = codes[starts]
        between = np.zeros(len(starts), bool)
        between[1:-1] = (label[:-2] == label[2:]) & (lengths[1:-1] < segment)
        if not between.any():
            return codes
        # From left to right: a run that follows an absorbed one has another left neighbour now,
        # so of a chain of candidates every second one is absorbed.
        index = np.arange(len(starts))
        chain = index - np.maximum.accumulate(np.where(between, -1, index))
        absorbed = between & (chain % 2 == 1)
        label = label.copy()
        label[absorbed] = label[np.nonzero(absorbed)[0] - 1]
        codes = np.repeat(label, lengths)
