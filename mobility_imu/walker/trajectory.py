"""From the IMU's path to the walking frame's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import (
    check_columns,
    check_shape,
    expect,
    for_each,
    settings_or_default,
)
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_rotation, as_vectors, one_of
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.runs import runs_of
from mobility_imu.walker.follow import as_sentences, navigate_recording
from mobility_imu.walker.geometry import WalkerGeometry, rotation_world_to_imu
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation import ClosedLoop, Navigation, NavigationSettings
from mobility_imu.walker.stillness import StillnessSettings

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "Trajectory",
    "body_position",
    "estimate_trajectory",
    "trajectory_from_path",
    "walking_displacement",
]

NOTED_LEAN_DEG, MOST_LEAN_DEG = 5.5, 20.0
"""Data sheets of cheap sensors allow the accelerometer an offset of 60 mg, at three standard
deviations. It is another after each start, so that of the calibration counts as well: two level
axes with sqrt(2) 20 mg each look like more than 5.5 deg once in 300 walks. Of 145 simulated walks
of the level "real", seeds from 500,000 on, 4 have more than 4 deg, and the largest is 4.8 deg."""
SHAPES = {"position_m": (3,), "rotation_body_to_world": (3, 3), "position_sd_m": (3,)}
"""What each sample of a trajectory has of these."""
SHORTEST_WALK_S = 1.0
"""From less neither up nor an offset is known as the settings say. Our choice, not swept."""
OPEN_TIMES = 5.0
"""A walk does not close if it ends so many standard deviations from its start, or turned by so
many. Of 12 simulated rounds that close, with sensors of the level "real", the largest is 1.6 times,
and 3.7 times if these sensors are taken for calibrated ones."""
OPEN_WORDS = "the walk does not close"
_REACH_M, _HIGHEST_M = 0.5, 1.5
"""How far beyond its footprint, and how high, a frame can carry an IMU."""


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Result):
    """Path of the walking frame; x and y along its own axes at the start, z up.

    Parameters
    ----------
    time_s : (n,) array, s
    position_m : (n, 3) array, m, middle of the rear tips, 0 at the start
    rotation_body_to_world : (n, 3, 3) array
    stationary : (n,) bool array
    position_sd_m : (n, 3) array, m, standard deviation of the position along each axis; with
        what wrong scales and axes of the sensor do to lengths, directions and headings
        (``scale_sd``, ``axes_sd_rad``), and the mount's errors, as far as the mount states them,
        but not with creep or slip of the tips, which no IMU sees. With sensors of the level "real"
        errors across a corridor are 1.0 of it, along it 1.3 with the creep
    yaw_sd_rad : (n,) array, rad. On walks with turns, where ``scale_sd`` counts, errors of a
        simulated MTI_1 are 0.9 of it (with ``NavigationSettings.for_calibrated_sensor``). At the
        end of a straight corridor they are a quarter: the filter's noise is three times the
        gyroscope's, and it allows for a resting frame that turns a little
    warnings : what the user should know
    settings, stillness : what it was found with; stillness is None if the rests were given
    smooth : whether each estimate uses what comes after it
    """

    time_s: FloatArray
    position_m: FloatArray
    rotation_body_to_world: FloatArray
    stationary: NDArray[np.bool_]
    position_sd_m: FloatArray
    yaw_sd_rad: FloatArray
    warnings: tuple[str, ...] = ()
    settings: NavigationSettings = field(default_factory=NavigationSettings, kw_only=True)
    stillness: StillnessSettings | None = field(default_factory=StillnessSettings, kw_only=True)
    smooth: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        """Check that all are series of one length."""
        expect("settings", self.settings, NavigationSettings)
        one_of("smooth", self.smooth, (True, False))
        if self.stillness is not None:
            expect("stillness", self.stillness, StillnessSettings)
        check_columns(self, "time_s", "yaw_sd_rad", flags=("stationary",))
        for name, each in SHAPES.items():
            check_shape(self, name, (len(self.time_s), *each))
        check_fields(self)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time_s)

    @property
    def yaw_rad(self) -> FloatArray:
        """Heading of the forward axis, rad, 0 at the start, positive to the left, not wrapped."""
        forward = self.rotation_body_to_world[:, :2, 0]
        return np.asarray(np.unwrap(np.arctan2(forward[:, 1], forward[:, 0])))

    @property
    def horizontal_sd_m(self) -> FloatArray:
        """Standard deviation of the place on the floor in m, root of the sum over both axes."""
        return np.asarray(np.hypot(self.position_sd_m[:, 0], self.position_sd_m[:, 1]))

    def to_frame(self) -> pd.DataFrame:
        """Table that ``mobility-imu walker trajectory`` writes."""
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.time_s,
                **{f"{axis}_m": self.position_m[:, k] for k, axis in enumerate("xyz")},
                "yaw_deg": np.rad2deg(self.yaw_rad),
                "stationary": self.stationary.astype(int),
                **{f"{axis}_sd_m": self.position_sd_m[:, k] for k, axis in enumerate("xyz")},
                "yaw_sd_deg": np.rad2deg(self.yaw_sd_rad),
            }
        )


def body_position(
    position_m: ArrayLike, quaternion: ArrayLike, mount: WalkerMount
) -> tuple[FloatArray, FloatArray]:
    """Position and attitude of the walking frame from those of its IMU (eq. 25).

    Parameters
    ----------
    position_m : (n, 3) array, m, of the IMU, world
    quaternion : (n, 4) array, Hamilton, scalar first, IMU to world
    mount : WalkerMount

    Returns
    -------
    (n, 3) array, m, of the body's origin, world; (n, 3, 3) array, body to world
    """
    expect("mount", mount, WalkerMount)
    to_imu, place = rotation_world_to_imu(quaternion), as_vectors(position_m, "position_m")
    if place.shape[:-1] != to_imu.shape[:-2]:
        raise InputError(
            f"position_m {place.shape} and quaternion {np.shape(quaternion)}: expected one "
            "position for each quaternion"
        )
    body_to_world = np.swapaxes(mount.rotation_imu_to_body @ to_imu, -1, -2)
    return place - body_to_world @ mount.translation_body_m, body_to_world


def walking_displacement(
    position_first_m: ArrayLike,
    position_last_m: ArrayLike,
    rotation_first: ArrayLike,
    rotation_last: ArrayLike,
    translation_m: ArrayLike,
    translation_error_m: ArrayLike = (0.0, 0.0, 0.0),
) -> FloatArray:
    """Displacement of the walking frame between two moments, m (eqs 26-28).

    (r_N - r_1) - (C_N - C_1)(T + T_e). Our text copy has a plus before the term of T in eq. 28,
    against eq. 27. An error of the mount counts by the change of attitude alone, as the paper says:
    not at all if the frame ends as it began, 1.41 times if it ends a quarter turn off.

    Parameters
    ----------
    position_first_m, position_last_m : (3,) arrays, m, of the IMU, world
    rotation_first, rotation_last : (3, 3) arrays, body to world
    translation_m : (3,) array, m, position of the IMU in the body frame, T
    translation_error_m : (3,) array, m, T_e

    Returns
    -------
    (3,) array, m, world; its length is the paper's walking length
    """
    arm = _one("translation_m", translation_m) + _one("translation_error_m", translation_error_m)
    turned = as_rotation(rotation_last, "rotation_last") - as_rotation(
        rotation_first, "rotation_first"
    )
    way = _one("position_last_m", position_last_m) - _one("position_first_m", position_first_m)
    return np.asarray(way - turned @ arm)


def _one(name: str, vector: ArrayLike) -> FloatArray:
    return as_vectors(vector, name, ndim=1)


@overload
def estimate_trajectory(
    recording: Recording,
    geometry: WalkerGeometry | None,
    mount: WalkerMount,
    settings: NavigationSettings | None = None,
    *,
    stillness: StillnessSettings | None = None,
    smooth: bool = True,
    closed_loop: ClosedLoop | None = None,
    rests: ArrayLike | None = None,
    executor: Any = None,
) -> Trajectory: ...


@overload
def estimate_trajectory(
    recording: Sequence[Recording],
    geometry: WalkerGeometry | None,
    mount: WalkerMount,
    settings: NavigationSettings | None = None,
    *,
    stillness: StillnessSettings | None = None,
    smooth: bool = True,
    closed_loop: ClosedLoop | None = None,
    executor: Any = None,
) -> list[Trajectory]: ...


def estimate_trajectory(
    recording: Recording | Sequence[Recording],
    geometry: WalkerGeometry | None,
    mount: WalkerMount,
    settings: NavigationSettings | None = None,
    *,
    stillness: StillnessSettings | None = None,
    smooth: bool = True,
    closed_loop: ClosedLoop | None = None,
    rests: ArrayLike | None = None,
    executor: Any = None,
) -> Trajectory | list[Trajectory]:
    """Path of a walking frame from a recording of the IMU on it, or of several recordings.

    Parameters
    ----------
    recording : Recording with a sensor "frame"; it begins at rest. Or a list of such recordings
    geometry : WalkerGeometry, by which a mount that lies far off the frame is noticed; None if it
        is not known
    mount : WalkerMount, see :func:`mobility_imu.walker.calibration.calibrate_mount`
    settings : NavigationSettings of the filter
    stillness : StillnessSettings of the detector
    smooth : whether each estimate may use what comes after it
    closed_loop : if the walk is known to end where and as it began; never evidence of accuracy
    rests : (n,) flags of the samples at which the frame is known to rest, with one recording; None
        finds the rests by the detector
    executor : anything with ``submit``, for a list of recordings; None works in this process

    Returns
    -------
    Trajectory, or a list of them in the order of the recordings

    Raises
    ------
    InputError
        If the recording has no sensor "frame" with gyroscope, no still phase at its start, or by
        the mount the frame does not stand upright there.
    """
    expect("geometry", geometry, WalkerGeometry, none=True)
    expect("mount", mount, WalkerMount)
    if not (rests is None or isinstance(recording, Recording)):
        raise InputError("rests belong to one recording: call this for each, expected no list")
    return for_each(
        _estimate_one,
        recording,
        executor,
        geometry=geometry,
        mount=mount,
        settings=settings_or_default("settings", settings, NavigationSettings),
        stillness=settings_or_default("stillness", stillness, StillnessSettings),
        smooth=one_of("smooth", smooth, (True, False)),
        closed_loop=closed_loop,
        rests=rests,
    )


def _estimate_one(
    recording: Recording,
    *,
    geometry: WalkerGeometry | None,
    mount: WalkerMount,
    settings: NavigationSettings,
    stillness: StillnessSettings,
    smooth: bool,
    closed_loop: ClosedLoop | None,
    rests: ArrayLike | None,
) -> Trajectory:
    path, warnings = navigate_recording(
        recording,
        smooth=smooth,
        settings=settings,
        stillness=stillness,
        closed_loop=closed_loop,
        rests=rests,
    )
    lasts_s = float(path.time_s[-1] - path.time_s[0])
    if lasts_s < SHORTEST_WALK_S:
        raise InputError(
            f"{recording.source}: {lasts_s:.2g} s from the first rest on, expected a walk that "
            "begins with some seconds of rest"
        )
    rest = runs_of(path.still)[0]
    force = recording.sensor("frame").acc_mps2[-len(path.time_s) :][rest].mean(axis=0)
    up = mount.rotation_imu_to_body @ force / np.linalg.norm(force)
    lean = float(np.rad2deg(np.arccos(np.clip(up[2], -1, 1))))
    if lean > MOST_LEAN_DEG:
        raise InputError(
            f"{recording.source}: by this mount the frame leans by {lean:.0f} deg while it stands: "
            "is it another frame's mount, has the IMU been moved, or are its axes exchanged or "
            "reversed?"
        )
    if lean > NOTED_LEAN_DEG:
        warnings += (
            f"by this mount the frame leans by {lean:.1f} deg while it stands: has the IMU moved, "
            "or is the floor not level? If it has moved, calibrate the mount again",
        )
    warnings += _far_off(mount, geometry)
    found = trajectory_from_path(
        path,
        mount,
        settings=settings,
        stillness=stillness,
        smooth=smooth,
        warnings=warnings,
        closed_loop=closed_loop,
    )
    if rests is not None:
        found = replace(found, stillness=None)
    notes = [*found.warnings, *_without_rest(found)]
    if closed_loop is not None:
        path, _ = navigate_recording(
            recording, smooth=False, settings=settings, stillness=stillness, rests=rests
        )
        untied = trajectory_from_path(path, mount, settings=settings, smooth=False)
        notes += _not_closed(untied, closed_loop)
    return replace(found, warnings=tuple(notes))


def _not_closed(untied: Trajectory, closed_loop: ClosedLoop) -> Iterator[str]:
    """Warn of a constraint that the path contradicts: the frame does not end where it began.

    Parameters
    ----------
    untied : Trajectory, found without the constraint; a smoother leaves its end as it is
    closed_loop : ClosedLoop
    """
    gap_m = float(np.hypot(*untied.position_m[-1, :2]))
    sd_m = float(np.hypot(untied.horizontal_sd_m[-1], np.sqrt(2) * closed_loop.position_sd_m))
    turned = float(abs(np.angle(np.exp(1j * untied.yaw_rad[-1]))))
    turned_sd = float(np.hypot(untied.yaw_sd_rad[-1], closed_loop.heading_sd_rad))
    times = max(gap_m / sd_m, turned / turned_sd)
    if times > OPEN_TIMES:
        yield (
            f"{OPEN_WORDS}: without the constraint it ends {gap_m:.2g} m from its start, turned by "
            f"{np.rad2deg(turned):.2g} deg, {times:.0f} times the standard deviation: leave "
            "closed_loop (--closed-loop) out, or is the recording cut off before the return?"
        )


def _without_rest(found: Trajectory) -> tuple[str, ...]:
    """Warn of moves so long that the errors of the sensors add up."""
    ends = [
        (move.start, min(move.stop, len(found) - 1))
        for move in runs_of(~found.stationary)
        if found.time_s[move.stop - 1] - found.time_s[move.start] > found.settings.longest_move_s
    ]
    if not ends:
        return ()
    start, stop = max(ends, key=lambda move: float(found.time_s[move[1]] - found.time_s[move[0]]))
    largest = float(found.horizontal_sd_m[start : stop + 1].max())
    several = f"{len(ends)} times, the longest " if len(ends) > 1 else ""
    what = (
        "; a frame that is walked with rests at each step: was it rolled or carried, or is the "
        "sensor on a foot? Rests that are known can be given"
        if found.stillness is not None
        else ""
    )
    return (
        f"no rest for more than {found.settings.longest_move_s:g} s, {several}"
        f"{found.time_s[stop] - found.time_s[start]:.1f} s from {found.time_s[start]:.1f} s on: "
        f"the place becomes uncertain by {largest:.2g} m (one standard deviation){what}",
    )


def _far_off(mount: WalkerMount, geometry: WalkerGeometry | None) -> tuple[str, ...]:
    """Warn of a mount so far from the footprint that no frame carries an IMU there."""
    if geometry is None:
        return ()
    half = geometry.footprint_width_m / 2 + _REACH_M
    low = np.array([-_REACH_M, -half, 0.0])
    high = np.array([geometry.footprint_length_m + _REACH_M, half, _HIGHEST_M])
    place = mount.translation_body_m
    if ((place >= low) & (place <= high)).all():
        return ()
    return (
        f"by this mount the IMU is at {np.round(place, 3).tolist()} m, far off a frame of "
        f"{geometry.footprint_width_m:g} x {geometry.footprint_length_m:g} m: are lengths in "
        "another unit, or is it another frame's mount?",
    )


def trajectory_from_path(
    path: Navigation,
    mount: WalkerMount,
    *,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
    smooth: bool = True,
    warnings: Sequence[str] = (),
    closed_loop: ClosedLoop | None = None,
) -> Trajectory:
    """Like :func:`estimate_trajectory`, for an existing path of the IMU.

    Parameters
    ----------
    path : Navigation
    mount : WalkerMount
    settings, stillness, smooth : what the path was found with; the result carries them
    warnings : of the path; they stand first on the result
    closed_loop : that the path was found with

    Returns
    -------
    Trajectory
    """
    expect("path", path, Navigation)
    notes = list(as_sentences(warnings))
    expect("closed_loop", closed_loop, ClosedLoop, none=True)
    place, body_to_world = body_position(path.position_m, path.quaternion, mount)
    first = int(np.argmax(path.still))
    settings = settings_or_default("settings", settings, NavigationSettings)
    forward = body_to_world[first, :2, 0]
    east, north = forward / np.linalg.norm(forward)
    to_start = np.array([[east, north, 0.0], [-north, east, 0.0], [0.0, 0.0, 1.0]])
    position = (place - place[first]) @ to_start.T
    attitude = to_start @ body_to_world
    sd, yaw_sd = _standard_deviations(
        path, mount, to_start, position, attitude, settings, tied=closed_loop is not None
    )
    backward = _backward_fraction(position, attitude, path.still)
    if backward > 0.8:
        notes.append(
            "the frame went backward: was it calibrated with tilts in another order than stated?"
        )
    return Trajectory(
        path.time_s,
        position,
        attitude,
        path.still,
        sd,
        yaw_sd,
        tuple(notes),
        settings=settings,
        stillness=settings_or_default("stillness", stillness, StillnessSettings),
        smooth=smooth,
    )


def _standard_deviations(
    path: Navigation,
    mount: WalkerMount,
    to_start: FloatArray,
    position: FloatArray,
    attitude: FloatArray,
    settings: NavigationSettings,
    *,
    tied: bool,
) -> tuple[FloatArray, FloatArray]:
    """Standard deviations of the position along the axes of the start, and of the heading."""
    variance = path.sd[:, 6:9] ** 2
    east, north = to_start[0, :2]
    turned = 2 * east * north * path.xy_covariance_m2
    x, y = variance[:, :2].T.copy()
    variance[:, 0] = east**2 * x + north**2 * y + turned
    variance[:, 1] = north**2 * x + east**2 * y - turned
    # The mount's position errs by how far the frame has turned since the start (eq. 28).
    first = int(np.argmax(path.still))
    if mount.translation_sd_m is not None:
        variance += (attitude - attitude[first]) ** 2 @ mount.translation_sd_m**2
    # The accelerometer's scales and axes err along and across the IMU's way, the mount's heading
    # across the frame's.
    scale_sd = settings.scale_sd
    variance[:, 2] += (scale_sd * position[:, 2]) ** 2
    axes = attitude @ mount.rotation_imu_to_body
    way = path.position_m @ to_start.T
    variance[:, :2] += _variance_by_axes(way, axes, scale_sd, settings.axes_sd_rad, tied)
    if mount.rotation_sd_rad is not None:
        variance[:, :2] += (mount.rotation_sd_rad[2] * position[:, 1::-1]) ** 2
    up = path.rotation_imu_to_world()[:, 2]
    yaw_sd = 2 * np.sqrt(np.einsum("ni,ni->n", up**2, path.sd[:, :3] ** 2))
    heading = np.unwrap(np.arctan2(attitude[:, 1, 0], attitude[:, 0, 0]))
    variance[:, :2] += (scale_sd * _led_astray(position, attitude, tied)) ** 2
    return np.sqrt(np.maximum(variance, 0)), np.hypot(yaw_sd, scale_sd * np.abs(heading))


def _led_astray(position: FloatArray, attitude: FloatArray, tied: bool) -> FloatArray:
    """Error of the position per error of the gyroscope's scale, (n, 2) array, m.

    A scale factor that is 1 % too large makes each heading wrong by 1 % of what was turned about
    the vertical since the start, and each piece of the way that is gone with it: one constant,
    which no average makes smaller. A path that is tied to its start at the end has what is left
    over there spread along the way.
    """
    pieces = np.diff(position[:, :2], axis=0)
    # About the vertical, however the frame is tilted: its heading may jump where the rate does not.
    steps = attitude[1:] @ np.swapaxes(attitude[:-1], 1, 2)
    turns = np.arctan2(steps[:, 1, 0] - steps[:, 0, 1], steps[:, 0, 0] + steps[:, 1, 1])
    turned = (np.cumsum(turns) - turns / 2)[:, None]
    astray = np.zeros((len(position), 2))
    np.cumsum(turned * np.column_stack([-pieces[:, 1], pieces[:, 0]]), axis=0, out=astray[1:])
    return _tied(astray, pieces) if tied else astray


def _variance_by_axes(
    position: FloatArray, axes: FloatArray, scale_sd: float, axes_sd: float, tied: bool
) -> FloatArray:
    """Variance of the position by wrong scales and axes of the accelerometer, (n, 2) array, m².

    Its matrix is 1 + E with nine constants, three scales and six leans. Each piece of the way is
    gone by C E C' of itself more, where C turns the sensor's axes (``axes``) into the world's: a
    scale draws it along the way, a lean of 0.01 to the side by 0.1 m in 10 m. No rest shows that.
    """
    pieces = np.diff(position[:, :2], axis=0)
    to_world = axes[1:, :2]
    read = np.einsum("nij,ni->nj", to_world, pieces)
    variance, astray = np.zeros((len(position), 2)), np.zeros((len(position), 2))
    for row in range(3):
        for column in range(3):
            np.cumsum(to_world[:, :, row] * read[:, column, None], axis=0, out=astray[1:])
            off = _tied(astray, pieces) if tied else astray
            variance += ((scale_sd if row == column else axes_sd) * off) ** 2
    return variance


def _tied(astray: FloatArray, pieces: FloatArray) -> FloatArray:
    """An error of a path that is tied to its start at the end: the rest is spread along the way."""
    gone = np.r_[0.0, np.cumsum(np.linalg.norm(pieces, axis=1))]
    return astray - np.outer(gone / max(gone[-1], 1e-9), astray[-1])


def _backward_fraction(
    position: FloatArray, attitude: FloatArray, still: NDArray[np.bool_]
) -> float:
    """Fraction of the way between rests that goes backward; 0 if the frame hardly moved."""
    at = np.nonzero(still & ~np.r_[still[1:], False])[0]
    steps = np.diff(position[at, :2], axis=0)
    length = np.linalg.norm(steps, axis=1)
    if length.sum() < 1.0:
        return 0.0
    along = np.einsum("ni,ni->n", steps, attitude[at[:-1], :2, 0])
    return float(length[along < 0].sum() / length.sum())
