"""Mount of both IMUs on a scooter, from parked poses with the controls at their stops.

A degree of mounting error costs up to three degrees of steering, more than the sensor's noise.
Parked, with the steering at its locks and the lever at its ends, eq. 5 has no unknown left but the
mounting.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.files import write_text
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray, as_number, as_vectors, wrap_angle
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.runs import runs_of
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.force import PoseLength, wrong_lengths
from mobility_imu.scooter.geometry import (
    ScooterGeometry,
    lever_acceleration,
    rotation_lever_to_body,
)
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.mount_fit import MountFit
from mobility_imu.scooter.pose_table import Places, as_poses, step_of, wrong_angles

__all__ = [
    "ParkedPose",
    "ScooterCalibration",
    "calibrate_mount",
    "find_stills",
    "mount_from_poses",
    "parked_poses",
]

STILL_RATE_RADPS = 0.03
"""Root mean square rate below which the lever's IMU rests."""
SHORTEST_STILL_S = 0.8
"""Seconds that a pose is held at least."""
POSE_SD_RAD = float(np.deg2rad(0.5))
"""Standard deviation of the controls' angles at their stops."""
ACC_BIAS_SD, ACC_SCALE_SD, ACC_MISALIGNMENT_SD_RAD = 0.005, 0.003, float(np.deg2rad(0.2))
"""Assumed errors of an accelerometer, sd on each axis; bias (of gravity), scale, lean of the axis.

They are those of the usual factory calibration; parked poses do not show them.
"""
PRIOR_SD_RAD = float(np.deg2rad(2.0))
"""Standard deviation of a mount about each axis before anything was measured."""
SMALLEST_SD_RAD = 1e-9
"""Smallest standard deviation of a stop or a mount that may be stated: misfits are over it."""
LARGEST_MISFIT_RAD = float(np.deg2rad(2.0))
"""Misfit from which on poses are not what the controls did. Stops that are off by 0.5 deg leave
0.4 deg; each table whose meaning is wrong (rad for deg, another order, signs) over 5."""
LARGEST_TURN_SDS = 10.0
"""Standard deviations of the prior about an axis from which on a turn is no way of mounting: poses
with the sensors of a phone, uncalibrated, lead to 15 deg, axes that were exchanged to 90."""
LARGEST_SWAY_RAD = float(np.deg2rad(2.0))
"""The body of a parked scooter sways less when its controls are moved, or its sensor is bad: on a
track of 0.5 m a wheel would have to sink by 17 mm, a tyre's whole deflection under a rider."""
UNSEEN_FRACTION = 0.8
"""A direction is unseen if its standard deviation is more than this fraction of the prior's."""
DIRECTIONS = (
    "lever IMU about x",
    "lever IMU about y",
    "lever IMU about z",
    "body IMU about x",
    "body IMU about y",
    "body IMU about z",
)


@dataclass(frozen=True, eq=False, repr=False)
class ParkedPose(Result):
    """What both IMUs read in one still pose, and where the controls were.

    Parameters
    ----------
    lever_acc_mps2, body_acc_mps2 : (3,) arrays, m/s², means over the pose, IMU axes
    steering_rad, throttle_rad : rad, known from the stops

    Raises
    ------
    InputError
        If a vector is no three finite numbers, or an angle is no number.
    """

    lever_acc_mps2: FloatArray
    body_acc_mps2: FloatArray
    steering_rad: float
    throttle_rad: float

    def __post_init__(self) -> None:
        """Check and copy the vectors, and check the angles."""
        for name in ("lever_acc_mps2", "body_acc_mps2"):
            vector = as_vectors(getattr(self, name), name, ndim=1, finite=True)
            object.__setattr__(self, name, vector.copy())
        for name in ("steering_rad", "throttle_rad"):
            object.__setattr__(self, name, as_number(getattr(self, name), name, negative=True))
        super().__post_init__()


@dataclass(frozen=True, eq=False, repr=False)
class ScooterCalibration(Result):
    """Mount of both IMUs, and how well the parked poses show it.

    Parameters
    ----------
    mount : ScooterMount
    sd_rad : (6,) array, rad, standard deviations about x, y, z of the lever's, then the body's IMU
    unseen : names of directions that the poses tell little of: the prior stays there
    geometry : ScooterGeometry that the calibration was made with
    warnings : sentences for the user
    pose_sd_rad, prior_sd_rad : rad, what it was made with, see :func:`mount_from_poses`
    misfit_rad : rad, root mean square angle by which the poses miss eq. 5 with this mount
    severe : those of the warnings after which the mount must not be used
    wrong_lengths : PoseLength of each sensor that reads something else than gravity in a pose
    """

    mount: ScooterMount
    sd_rad: FloatArray
    unseen: tuple[str, ...]
    geometry: ScooterGeometry
    warnings: tuple[str, ...] = ()
    pose_sd_rad: float = POSE_SD_RAD
    prior_sd_rad: float = PRIOR_SD_RAD
    misfit_rad: float = float("nan")
    severe: tuple[str, ...] = ()
    wrong_lengths: tuple[PoseLength, ...] = ()

    def __post_init__(self) -> None:
        """Check every field."""
        check_fields(
            self, mount=ScooterMount, sd_rad=(6,), unseen=[str], geometry=ScooterGeometry,
            pose_sd_rad=float, prior_sd_rad=float, misfit_rad=float, severe=[str],
            wrong_lengths=[PoseLength],
        )  # fmt: skip
        super().__post_init__()

    def to_toml(self, path: str | Path | None = None) -> str:
        """Text of a geometry file with geometry, mount and standard deviations.

        Parameters
        ----------
        path : file to write the text to, too; an existing one is replaced

        Returns
        -------
        str
        """
        text = self.mount.to_toml(geometry=self.geometry, sd_rad=self.sd_rad)
        if np.isfinite(self.misfit_rad):
            text += f"# the poses miss this mount by {np.rad2deg(self.misfit_rad):.2f} deg (rms)\n"
        if path is not None:
            write_text(path, text)
        return text


def calibrate_mount(
    parked_recordings: Recording | Sequence[Recording],
    settings_of_poses_rad: Sequence[tuple[float, float]],
    geometry: ScooterGeometry,
    *,
    pose_sd_rad: float = POSE_SD_RAD,
    prior_sd_rad: float = PRIOR_SD_RAD,
) -> ScooterCalibration:
    """Mount of both IMUs from recordings of a parked scooter.

    Park, move the controls through the poses, hold each for two seconds; do it on level ground and
    on a ramp. A stated angle that does not fit the others is told; one angle by which all are off
    is a turn of an IMU and cannot be seen (:mod:`mobility_imu.scooter.pose_table`).

    Parameters
    ----------
    parked_recordings : Recording, or several, one per place, each with all poses in their order
    settings_of_poses_rad : (steering, throttle) of each pose, rad
    geometry : ScooterGeometry
    pose_sd_rad, prior_sd_rad : rad, see :func:`mount_from_poses`

    Returns
    -------
    ScooterCalibration

    Raises
    ------
    InputError
        If a recording has not as many still poses as settings, or the poses are too few or alike.
    """
    expect("geometry", geometry, ScooterGeometry)
    parked = [parked_recordings] if isinstance(parked_recordings, Recording) else parked_recordings
    if not isinstance(parked, list | tuple):
        raise InputError(
            f"parked_recordings: got {type(parked).__name__}, expected Recording or a list of them"
        )
    for number, one in enumerate(parked):
        expect(f"parked recording {number}", one, Recording)
    of_each = [(one.source, parked_poses(one, settings_of_poses_rad)) for one in parked]
    poses = [pose for _, some in of_each for pose in some]
    found = mount_from_poses(poses, geometry, pose_sd_rad=pose_sd_rad, prior_sd_rad=prior_sd_rad)
    lengths = [_wrong_lengths(source, some) for source, some in of_each]
    swayed = [
        text
        for wrong, (source, some) in zip(lengths, of_each, strict=True)
        for text in (*(one.sentence for one in wrong), *_says_sway(source, some))
    ]
    # Where a reading is at fault, no angle is to blame.
    angles = [] if swayed else _says_wrong(found, [some for _, some in of_each], parked)
    severe = (*swayed, *found.severe, *angles)
    others = [text for text in found.warnings if text not in found.severe]
    told = tuple(one for wrong in lengths for one in wrong)
    return replace(found, warnings=(*severe, *others), severe=severe, wrong_lengths=told)


def mount_from_poses(
    poses: Sequence[ParkedPose],
    geometry: ScooterGeometry,
    *,
    pose_sd_rad: float = POSE_SD_RAD,
    prior_sd_rad: float = PRIOR_SD_RAD,
) -> ScooterCalibration:
    """Mount of both IMUs by least squares over parked poses (eq. 5).

    The attitude of the scooter need not be known: the body's IMU measures it. What the poses
    cannot tell apart: a turn of the body's IMU about the vertical (on level ground only: park on a
    ramp as well), alpha's error from a turn of the body's IMU about x, beta's error from one of the
    lever's IMU about x, and a constant bias of an accelerometer from a tilt of it. The estimate is
    then the sum that explains the poses, and so corrects them; a weak prior keeps the rest small.

    Parameters
    ----------
    poses : at least three, not all with the same steering and throttle
    geometry : ScooterGeometry
    pose_sd_rad : rad, how well the angles at the stops are known
    prior_sd_rad : rad, how far from nominal a mount may be expected to be, about each axis

    Returns
    -------
    ScooterCalibration
        ``sd_rad`` allows for stops and sensors that are off as usual; where the poses fit no mount
        (``LARGEST_MISFIT_RAD``), it is as many times larger as the misfit is.

    Raises
    ------
    InputError
        If there are too few different poses, an angle is none, a standard deviation is
        too small to divide by, or the least squares find no mount.
    """
    expect("geometry", geometry, ScooterGeometry)
    pose_sd = _as_sd(pose_sd_rad, "pose_sd_rad")
    prior_sd = _as_sd(prior_sd_rad, "prior_sd_rad")
    expect("poses", poses, Sequence)
    for number, pose in enumerate(poses):
        expect(f"pose {number}", pose, ParkedPose)
    _check_settings(poses)
    lever = _directions([p.lever_acc_mps2 for p in poses], "lever_acc_mps2")
    body = _directions([p.body_acc_mps2 for p in poses], "body_acc_mps2")
    steering = np.array([p.steering_rad for p in poses])
    throttle = np.array([p.throttle_rad for p in poses])
    held = _Held(lever, body, steering, throttle, _Stops.of(steering, throttle), geometry)
    fit = MountFit(
        lever, body, rotation_lever_to_body(steering, throttle, geometry), pose_sd, prior_sd
    )
    found = fit.solved()
    by_faults = held.by_faults(found.x) * _fault_deviations(held.stops.number, pose_sd) / pose_sd
    try:
        sd, usual = _standard_deviations(found.jac, by_faults)
    except np.linalg.LinAlgError:
        raise InputError(
            f"pose_sd_rad = {pose_sd:g}, prior_sd_rad = {prior_sd:g}: with them the poses tell no "
            "mount; expected angles of stops and mounts, in rad"
        ) from None
    left = held.apart(found.x, held.none)
    apart_rad = rms(np.linalg.norm(left.reshape(-1, 3), axis=1))
    if apart_rad > LARGEST_MISFIT_RAD:
        sd = sd * max(1.0, rms(left) / (usual * pose_sd))
    unseen = _unseen(sd, prior_sd)
    mount = ScooterMount(*_matrices(found.x), sd)
    warnings = [
        f"the poses tell little of the turn of the {name}: park at another slope as well"
        for name in unseen
    ]
    severe = _says_turned(found.x, prior_sd)
    if apart_rad > LARGEST_MISFIT_RAD:
        set_rad = np.column_stack([steering, throttle])
        off = _angles_apart(mount, lever, body, set_rad, geometry)
        severe.insert(0, _says_misfit(apart_rad, off))
    told = (*severe, *warnings)
    return ScooterCalibration(
        mount, sd, unseen, geometry, told, pose_sd, prior_sd, apart_rad, tuple(severe)
    )


def _matrices(turns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation matrices of both IMUs, from their rotation vectors one after the other."""
    lever, body = Rotation.from_rotvec(turns.reshape(2, 3)).as_matrix()
    return lever, body


def _unseen(sd_rad: FloatArray, prior_sd_rad: float) -> tuple[str, ...]:
    """Names of the directions that the poses tell little of."""
    return tuple(
        name
        for name, spread in zip(DIRECTIONS, sd_rad, strict=True)
        if spread > UNSEEN_FRACTION * prior_sd_rad
    )


def _check_settings(poses: Sequence[ParkedPose]) -> None:
    """Check that there are enough different poses, of angles that a control can have."""
    as_poses([(p.steering_rad, p.throttle_rad) for p in poses] or np.zeros((0, 2)), "poses")
    different = {(round(p.steering_rad, 3), round(p.throttle_rad, 3)) for p in poses}
    if len(poses) < 3 or len({p[0] for p in different}) < 2 or len({p[1] for p in different}) < 2:
        raise InputError(
            f"{len(poses)} poses with {len(different)} different settings: expected at least three "
            "poses, with two steering and two throttle angles among them"
        )


def _fault_deviations(stops: int, pose_sd_rad: float) -> FloatArray:
    """Standard deviations of the stops' angles, then of bias and axes of each sensor."""
    axes = np.where(np.eye(3, dtype=bool), ACC_SCALE_SD, ACC_MISALIGNMENT_SD_RAD).ravel()
    of_sensor = np.r_[np.full(3, ACC_BIAS_SD), axes]
    return np.asarray(np.r_[np.full(stops, pose_sd_rad), of_sensor, of_sensor])


def _angles_apart(
    mount: ScooterMount,
    lever: FloatArray,
    body: FloatArray,
    set_rad: FloatArray,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Largest difference of steering and throttle from what was set, with this mount, (2,), rad."""
    found = np.column_stack(three_axis_angles(mount.lever(lever), mount.body(body), geometry))
    return np.asarray(np.abs(wrap_angle(found - set_rad)).max(axis=0))


def _says_misfit(misfit_rad: float, off_rad: FloatArray) -> str:
    misfit, steering, throttle = np.rad2deg([misfit_rad, *off_rad])
    return (
        f"the poses fit no mount: they miss the best one by {misfit:.1f} deg, which leaves the "
        f"steering up to {steering:.1f} deg and the throttle up to {throttle:.1f} deg off what was "
        "set; are they in degrees, in the order of time, left and pushed positive? Accelerometers "
        "with offsets of 20 mg leave 2 deg, too"
    )


def _says_turned(turns: FloatArray, prior_sd_rad: float) -> list[str]:
    """A sentence for each sensor that is turned too far for one that was put on straight."""
    return [
        f"the {name}'s IMU would be turned by {np.rad2deg(np.linalg.norm(turn)):.0f} deg from its "
        f"nominal axes, {np.abs(turn).max() / prior_sd_rad:.0f} times what is usual about one: are "
        "its axes exchanged, is it the right sensor, are the inclinations right?"
        for name, turn in (("lever", turns[:3]), ("body", turns[3:]))
        if np.abs(turn).max() > LARGEST_TURN_SDS * prior_sd_rad
    ]


def _says_wrong(
    found: ScooterCalibration, places: Sequence[Sequence[ParkedPose]], parked: Sequence[Recording]
) -> list[str]:
    """A sentence on the angles that do not fit the others."""
    lever, body = (
        np.array([_directions([getattr(p, name) for p in some], name) for some in places])
        for name in ("lever_acc_mps2", "body_acc_mps2")
    )
    held = Places(lever, body, max(map(step_of, parked)))
    flat = lever.reshape(-1, 3), body.reshape(-1, 3)

    def mount_of(table: FloatArray) -> ScooterMount:
        steering, throttle = np.tile(table, (len(places), 1)).T
        chain = rotation_lever_to_body(steering, throttle, found.geometry)
        turns = MountFit(*flat, chain, found.pose_sd_rad, PRIOR_SD_RAD).solved().x
        return ScooterMount(*_matrices(turns))

    table = np.array([(pose.steering_rad, pose.throttle_rad) for pose in places[0]])
    wrong = wrong_angles(held, table, found.geometry, mount_of)
    if wrong is None or (not wrong.poses and found.misfit_rad > LARGEST_MISFIT_RAD):
        return []
    return [wrong.sentence(table)]


def _wrong_lengths(source: str, poses: Sequence[ParkedPose]) -> tuple[PoseLength, ...]:
    """Pose and length for each sensor that reads something else than gravity in a pose."""
    return tuple(
        wrong
        for name in ("lever", "body")
        for wrong in wrong_lengths(
            source, name, np.array([getattr(pose, f"{name}_acc_mps2") for pose in poses])
        )
    )


def _says_sway(source: str, poses: Sequence[ParkedPose]) -> list[str]:
    """Sentence if the body's sensor reads another direction in some pose of a parked recording."""
    body = _directions([pose.body_acc_mps2 for pose in poses], "body_acc_mps2")
    off = np.linalg.norm(body - np.median(body, axis=0), axis=1)
    worst = int(np.argmax(off))
    if off[worst] <= LARGEST_SWAY_RAD:
        return []
    return [
        f"{source}: in pose {worst + 1} gravity lies {np.rad2deg(off[worst]):.1f} deg otherwise in "
        "the body's IMU than in most poses, though the scooter is parked: did it move, or is the "
        "accelerometer at fault?"
    ]


def _as_sd(value: float, name: str) -> float:
    """Standard deviation that misfits can be divided by."""
    sd = as_number(value, name)
    if sd < SMALLEST_SD_RAD:
        raise InputError(f"{name} = {sd:g}: expected at least {SMALLEST_SD_RAD:g} rad")
    return sd


class _Stops(NamedTuple):
    """Stops of both controls: poses with the same believed angle have the same error of it."""

    of_steering: NDArray[np.intp]
    of_throttle: NDArray[np.intp]
    number: int

    @classmethod
    def of(cls, steering_rad: FloatArray, throttle_rad: FloatArray) -> _Stops:
        """Number the stops of each control; those of the throttle follow those of the steering."""
        one, of_steering = np.unique(steering_rad.round(6), return_inverse=True)
        other, of_throttle = np.unique(throttle_rad.round(6), return_inverse=True)
        return cls(of_steering, len(one) + of_throttle, len(one) + len(other))

    def steering(self, angle_rad: FloatArray, off_rad: FloatArray) -> FloatArray:
        """Steering angle of each pose with the errors of the stops added."""
        return np.asarray(angle_rad + off_rad[..., self.of_steering])

    def throttle(self, angle_rad: FloatArray, off_rad: FloatArray) -> FloatArray:
        """Throttle angle of each pose with the errors of the stops added."""
        return np.asarray(angle_rad + off_rad[..., self.of_throttle])


class _Held(NamedTuple):
    """Directions that both sensors read in the poses, and the angles that are stated."""

    lever: FloatArray
    body: FloatArray
    steering: FloatArray
    throttle: FloatArray
    stops: _Stops
    geometry: ScooterGeometry

    @property
    def none(self) -> FloatArray:
        """Faults that are all zero: of the stops' angles, then bias and axes of each sensor."""
        return np.zeros(self.stops.number + 24)

    def apart(self, turns: FloatArray, faults: FloatArray) -> FloatArray:
        """Misfit of eq. 5, (..., m), with faults, (..., k), in the order of :attr:`none`."""
        off, of_lever, of_body = faults[..., :-24], faults[..., -24:-12], faults[..., -12:]
        seen = _spoilt(self.lever, of_lever) @ Rotation.from_rotvec(turns[:3]).as_matrix().T
        upright = _spoilt(self.body, of_body) @ Rotation.from_rotvec(turns[3:]).as_matrix().T
        steering = self.stops.steering(self.steering, off)
        throttle = self.stops.throttle(self.throttle, off)
        expected = lever_acceleration(upright, steering, throttle, self.geometry)
        return np.reshape(seen - expected, (*faults.shape[:-1], -1))

    def by_faults(self, turns: FloatArray) -> FloatArray:
        """Change of the misfit by each fault, a column each."""
        step = 1e-5 * np.eye(len(self.none))
        changes = (self.apart(turns, step) - self.apart(turns, -step)) / 2e-5
        return np.asarray(changes.T)


def _spoilt(directions: FloatArray, faults: FloatArray) -> FloatArray:
    """Readings of a sensor, (..., n, 3), with faults, (..., 12): bias, then errors of its axes."""
    axes = np.eye(3) + faults[..., 3:].reshape(*faults.shape[:-1], 3, 3)
    return np.asarray(directions @ np.swapaxes(axes, -1, -2) + faults[..., None, :3])


def _standard_deviations(by_turns: FloatArray, by_faults: FloatArray) -> tuple[FloatArray, float]:
    """Standard deviations of the least-squares turns, rad, and the weighted misfit that is usual.

    The gain of the least squares carries the misfit over to the turns. What disturbs the misfit is
    not a new error in each pose: a stop's error comes back whenever that stop is used, and those
    of the sensors in every pose. The last six rows are the prior, of which the truth is one draw.

    Parameters
    ----------
    by_turns : (m + 6, 6) array, Jacobian of the weighted misfit
    by_faults : (m, k) array, change of the weighted misfit by each fault of one standard deviation
    """
    gain = np.linalg.solve(by_turns.T @ by_turns, by_turns.T)
    seen, prior = gain[:, :-6] @ by_faults, gain[:, -6:]
    left = by_faults - by_turns[:-6] @ seen, by_turns[:-6] @ prior
    usual = np.sqrt(sum((part**2).sum() for part in left) / len(by_faults))
    return np.asarray(np.sqrt((seen**2).sum(axis=1) + (prior**2).sum(axis=1))), float(usual)


def find_stills(parked: Recording) -> list[slice]:
    """Intervals in which lever and body rest, in the order of time.

    Rest means a small rate of the lever's gyroscope for at least ``SHORTEST_STILL_S``; a
    tenth of a second at each end is left out.

    Parameters
    ----------
    parked : Recording with a sensor ``lever`` that has a gyroscope

    Returns
    -------
    list of slices of samples
    """
    expect("parked", parked, Recording)
    return _rests_of(parked, "lever")


def _rests_of(parked: Recording, name: str) -> list[slice]:
    """Intervals in which one sensor rests."""
    fs = parked.sampling_rate_hz
    gyr = parked.gyroscope(name)
    gyr = gyr - np.median(gyr, axis=0)  # a constant bias is no motion
    power = ndimage.uniform_filter1d((gyr**2).sum(axis=1), max(3, round(0.2 * fs)))
    margin = round(0.1 * fs)
    return [
        slice(still.start + margin, still.stop - margin)
        for still in runs_of(power < STILL_RATE_RADPS**2)
        if still.stop - still.start >= SHORTEST_STILL_S * fs
    ]


def parked_poses(
    parked: Recording, settings_rad: Sequence[tuple[float, float]]
) -> list[ParkedPose]:
    """Poses of a parked recording: one still interval per setting, in order.

    Parameters
    ----------
    parked : Recording with sensors ``lever`` and ``body``
    settings_rad : (steering, throttle) of each pose, rad

    Returns
    -------
    list of ParkedPose

    Raises
    ------
    InputError
        If there are not as many still intervals as settings; the message lists their times.
    """
    settings = as_poses(settings_rad, "settings of the poses")
    stills = find_stills(parked)
    if len(stills) != len(settings):
        times = ", ".join(
            f"{parked.time_s[s.start]:.1f}-{parked.time_s[s.stop - 1]:.1f} s" for s in stills
        )
        raise InputError(
            f"{parked.source}: {len(stills)} still intervals ({times or 'none'}), expected "
            f"{len(settings)}, one per pose{_says_why(parked, len(settings))}"
        )
    lever, body = parked.sensor("lever").acc_mps2, parked.sensor("body").acc_mps2
    return [
        ParkedPose(lever[still].mean(axis=0), body[still].mean(axis=0), *setting)
        for still, setting in zip(stills, settings.tolist(), strict=True)
    ]


def _says_why(parked: Recording, poses: int) -> str:
    """That the poses are too few, or the body's sensor rests as often as the lever's should."""
    if poses == 1:  # the body of a parked scooter rests once
        return "; three poses or more are needed"
    if parked.sensor("body").gyr_radps is None or len(_rests_of(parked, "body")) != poses:
        return ""
    return "; the body's sensor has that many: have lever and body each other's names?"


def _directions(vectors: Sequence[ArrayLike], name: str) -> FloatArray:
    rows = np.array(vectors, float)
    with np.errstate(over="ignore"):  # what overflows is refused
        lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    if not (lengths > 0).all():
        pose = int(np.argmin(lengths)) + 1
        raise InputError(f"{name}: pose {pose} is without acceleration, expected gravity in each")
    if not np.isfinite(lengths).all():
        raise InputError(f"{name}: a pose whose acceleration is too large to have a length")
    return np.asarray(rows / lengths)
