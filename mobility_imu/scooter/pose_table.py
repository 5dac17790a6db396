"""Whether the stated angles of parked poses are right: one of them is held against the others.

A calibration turns both IMUs until the poses fit eq. 5 best. What it leaves, ``y``, two numbers for
each reading, has a known covariance V: stops that are off, sensors as data sheets of phones allow
them, inclinations read from a phone's inclinometer, readings in steps. Where the stated angles of
one pose are off by ``d``, ``y`` moves by ``A d``, and

    g = bᵀ M⁻¹ b,    b = Aᵀ V⁻¹ y,    M = Aᵀ V⁻¹ A

is chi-square with as many degrees of freedom as ``d`` has if they are right. The most unlikely
one is told, with the angles at which it fits.

What cannot be seen is what a turn of an IMU explains. By eq. 5 the lever reads
``Rx(-throttle) C Rz(-steering) A`` times what the body does, with C and A of the inclinations.
Throttle angles that are all off by one angle are a turn of the lever's IMU about its axis x, and
steering angles that are all off by one angle one of the body's about the shaft: both are undone in
full, and the poses fit as well as right ones. A ride shows them: the steering at which the
scooter does not turn, and the throttle while it stands, are zero
(:func:`~mobility_imu.scooter.faults.find_faults`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_floats
from mobility_imu.recording import Recording
from mobility_imu.scooter.geometry import ScooterGeometry, lever_acceleration
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.pose_errors import ERRORS, by_errors, by_set_angles, set_covariance

__all__ = ["Places", "Wrong", "as_poses", "step_of", "within_a_turn", "wrong_angles"]

STOP_SD_RAD, HELD_SD_RAD = np.deg2rad([0.5, 0.2]).tolist()
"""Errors of a stop, half of its variance the same in all places and half new in each, for nothing
is known of it; and of how a hand holds a control against it, new in each pose. The first of these
sizes and the next four are those of ``PoseCheckSettings``; offsets are new in each place."""
OFFSET_SD, SCALE_SD, AXES_SD_RAD = 0.02, 0.01, 0.01
INCLINATION_SD_RAD = float(np.deg2rad(0.5))
FREE_TURN_RAD = float(np.deg2rad(10.0))
"""Turn of an IMU that is still none of the poses' misfit: that of phones, stuck on by eye."""
SECOND_ORDER_RAD = float(np.deg2rad(0.05))
"""What turns of 2 deg leave to second order."""
BY_CHANCE = 0.01
"""Probability that right angles are called wrong, if all sensors are as bad as is assumed. Of 300
simulated scooters with right tables (seeds 60,000 to 60,149, both levels of sensors) none came
near; of wrong poses that move a mount by over two standard deviations 98 % are told."""
CONTROLS = ("steering", "throttle")
LARGEST_FIT = 8
"""Steps in which a wrong angle is found; each leaves a tenth of the error or less."""


def as_poses(poses_rad: ArrayLike, name: str) -> FloatArray:
    """Check that an array has angles of both controls in each pose.

    Parameters
    ----------
    poses_rad : (n, 2) array, rad, steering and throttle
    name : what to call it in the error message

    Returns
    -------
    (n, 2) float array

    Raises
    ------
    InputError
        If it has another shape, or an angle is not finite or more than a whole turn.
    """
    poses = as_floats(poses_rad, name)
    if poses.ndim != 2 or poses.shape[1] != 2 or not np.isfinite(poses).all():
        raise InputError(
            f"{name}: got shape {poses.shape}, expected a row of two finite numbers, steering and "
            "throttle, for each pose"
        )
    within_a_turn(poses, name)
    return poses


def within_a_turn(angles_rad: FloatArray | float, name: str) -> None:
    """Check that no angle is larger than a whole turn, as no control and no ground has it.

    Parameters
    ----------
    angles_rad : rad
    name : what to call them in the error message

    Raises
    ------
    InputError
        If one is larger.
    """
    largest = float(np.abs(as_floats(angles_rad, name)).max(initial=0.0))
    if largest > 2 * np.pi:
        raise InputError(
            f"{name}: an angle is {largest:g}, more than a whole turn; expected rad (is it in deg?)"
        )


class Places(NamedTuple):
    """Directions of gravity in parked poses; each place has all poses of one table.

    Parameters
    ----------
    lever, body : (places, poses, 3) arrays, directions in the IMUs' axes
    step : of the readings, in units of gravity
    """

    lever: FloatArray
    body: FloatArray
    step: float


class Wrong(NamedTuple):
    """Stated angles that do not fit the others.

    Parameters
    ----------
    poses : numbers in the table, from 0; () where no pose and no stop by itself makes it fit
    control : "steering" or "throttle" where it is one stop in all its poses, "" where it is a pose
    right_rad : (steering, throttle) of the first of these poses with which all poses fit
    """

    poses: tuple[int, ...] = ()
    control: str = ""
    right_rad: tuple[float, float] = (np.nan, np.nan)

    def sentence(self, set_rad: FloatArray) -> str:
        """What a user is told.

        Parameters
        ----------
        set_rad : (poses, 2) array, rad, the table

        Returns
        -------
        str
        """
        if not self.poses:
            return (
                "the poses do not fit each other, and no single pose or stop is to blame: look at "
                "the table of poses, or record them again"
            )
        stated, right = np.rad2deg([set_rad[self.poses[0]], self.right_rad])
        if not self.control:
            return (
                f"pose {self.poses[0] + 1} does not fit the others: with steering and throttle at "
                f"{right[0]:.0f} and {right[1]:.0f} deg it would, and {stated[0]:.0f} and "
                f"{stated[1]:.0f} are stated; correct the table of poses, or hold it again"
            )
        k, numbers = CONTROLS.index(self.control), ", ".join(str(pose + 1) for pose in self.poses)
        return (
            f"the {self.control} of poses {numbers} does not fit the others: at {right[k]:.0f} deg "
            f"it would, and {stated[k]:.0f} are stated; correct the table of poses, or hold them "
            "again"
        )


class _Suspect(NamedTuple):
    """Angles of the table that may be wrong together: which poses, and which controls of them."""

    poses: tuple[int, ...]
    controls: tuple[int, ...]

    def columns(self, by_angles: FloatArray) -> FloatArray:
        """Change of the misfit by these angles, from that by each angle, (m, poses, 2)."""
        chosen = by_angles[:, list(self.poses)][..., list(self.controls)]
        return np.asarray(chosen.sum(axis=1))


def step_of(recording: Recording) -> float:
    """Step in which accelerometers read, in units of gravity: the usual change of a reading.

    Of a sensor without steps it is what its noise changes a reading by. A body that rests in one
    step shows none, so the lever's counts as well.

    Parameters
    ----------
    recording : Recording of ``lever`` and ``body``

    Returns
    -------
    float; 0 if no reading ever changes
    """
    steps = [0.0]
    for name in ("lever", "body"):
        changes = np.abs(np.diff(recording.sensor(name).acc_mps2, axis=0))
        if changes.any():
            steps.append(float(np.median(changes[changes > 0])))
    return max(steps) / STANDARD_GRAVITY_MPS2


def wrong_angles(
    places: Places,
    set_rad: FloatArray,
    geometry: ScooterGeometry,
    mount_of: Callable[[FloatArray], ScooterMount],
) -> Wrong | None:
    """Angles of the table that do not fit the others beyond chance.

    Parameters
    ----------
    places : Places
    set_rad : (poses, 2) array, rad, the table
    geometry : ScooterGeometry
    mount_of : mount by the same readings and another table

    Returns
    -------
    Wrong, without poses if no single pose or stop makes the table fit; None if it fits
    """
    suspects = list(_suspects(set_rad))
    left, by_angles, precision = _misfit(places, set_rad, geometry, mount_of(set_rad))
    limit = BY_CHANCE / len(suspects)
    found = []
    for suspect in suspects:
        gain, _ = _gain(left, suspect.columns(by_angles), precision)
        if special.chdtrc(len(suspect.controls), gain) < limit:
            mended, rest = _mended(suspect, places, set_rad, geometry, mount_of)
            found.append((rest, suspect, mended))
    if not found:
        return None
    rest, suspect, mended = min(found, key=lambda one: one[0])
    if rest > special.chdtri(left.size - 6 - len(suspect.controls), BY_CHANCE):
        return Wrong()
    control = CONTROLS[suspect.controls[0]] if len(suspect.controls) == 1 else ""
    steering, throttle = mended[suspect.poses[0]].tolist()
    return Wrong(suspect.poses, control, (steering, throttle))


def _suspects(set_rad: FloatArray) -> Iterator[_Suspect]:
    """Each pose, and each stop that several poses have."""
    for pose in range(len(set_rad)):
        yield _Suspect((pose,), (0, 1))
    for control in range(2):
        angles = set_rad[:, control].round(6)
        for angle in np.unique(angles).tolist():
            poses = tuple(np.flatnonzero(angles == angle).tolist())
            if len(poses) > 1:
                yield _Suspect(poses, (control,))


def _mended(
    suspect: _Suspect,
    places: Places,
    set_rad: FloatArray,
    geometry: ScooterGeometry,
    mount_of: Callable[[FloatArray], ScooterMount],
) -> tuple[FloatArray, float]:
    """Table with which a suspect fits, and the misfit that is left, in chi-square."""
    table = set_rad.copy()
    for _ in range(LARGEST_FIT):
        left, by_angles, precision = _misfit(places, table, geometry, mount_of(table))
        _, moved = _gain(left, suspect.columns(by_angles), precision)
        table[np.ix_(suspect.poses, suspect.controls)] += moved
        if np.abs(moved).max() < SECOND_ORDER_RAD:
            break
    left, _, precision = _misfit(places, table, geometry, mount_of(table))
    return table, float(left @ precision @ left)


def _gain(left: FloatArray, columns: FloatArray, precision: FloatArray) -> tuple[float, FloatArray]:
    """By how much angles make the chi-square smaller, and how far they have to move, rad."""
    weighted = columns.T @ precision
    moved = np.linalg.solve(weighted @ columns, weighted @ left)
    return float(moved @ weighted @ left), np.asarray(moved)


def _misfit(
    places: Places, set_rad: FloatArray, geometry: ScooterGeometry, mount: ScooterMount
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What the poses miss eq. 5 by, (m,), its change by each angle of the table, and V⁻¹.

    Two numbers for each reading, across the direction that is expected.
    """
    count, number = places.lever.shape[:2]
    table = np.tile(set_rad, (count, 1))
    lever = mount.lever(places.lever.reshape(-1, 3))
    body = mount.body(places.body.reshape(-1, 3))
    expected = np.asarray(lever_acceleration(body, table[:, 0], table[:, 1], geometry))
    across = _across(expected)
    left = (across @ (lever - expected)[:, :, None]).ravel()
    errors = across @ by_errors(table, body, geometry)
    by_angle = across @ by_set_angles(table, body, geometry)
    size = left.size
    flat = errors.reshape(size, ERRORS)
    covariance = (flat * _spread() ** 2) @ flat.T
    blocks = np.zeros((len(table), 2, len(table), 2))
    blocks[np.arange(len(table)), :, np.arange(len(table))] = by_angle
    each = blocks.reshape(size, size)
    covariance += each @ _stops(set_rad, count) @ each.T
    covariance += _by_offsets(errors, places.step, count) + SECOND_ORDER_RAD**2 * np.eye(size)
    by_table = each.reshape(size, count, number, 2).sum(axis=1)
    return left, by_table, np.asarray(np.linalg.inv(covariance))


def _across(directions: FloatArray) -> FloatArray:
    """Two unit vectors across each direction, (n, 2, 3)."""
    least = np.eye(3)[np.argmin(np.abs(directions), axis=1)]
    first = np.cross(directions, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(directions, first)
    second /= np.linalg.norm(second, axis=1, keepdims=True)
    return np.stack([first, second], axis=1)


def _stops(set_rad: FloatArray, count: int) -> FloatArray:
    """Covariance of the angles of all poses: of the stops, as found, and as held in each place."""
    everywhere = np.tile(set_rad, (count, 1))
    half = STOP_SD_RAD / np.sqrt(2)
    here = np.kron(np.eye(count), set_covariance(set_rad, half, HELD_SD_RAD))
    return np.asarray(set_covariance(everywhere, half, 0.0) + here)


def _spread() -> FloatArray:
    """Standard deviations of the errors that all poses share, (32,)."""
    axes = np.where(np.eye(3) > 0, SCALE_SD, AXES_SD_RAD).ravel()
    sensor = np.r_[np.full(3, OFFSET_SD), axes]
    turns, inclinations = np.full(6, FREE_TURN_RAD), np.full(2, INCLINATION_SD_RAD)
    return np.concatenate([turns, sensor, sensor, inclinations])


def _by_offsets(errors: FloatArray, step: float, count: int) -> FloatArray:
    """Covariance by offsets, new in each place, and by readings in steps, new in each pose as well.

    A body that rests reads the same step in all poses of a place.
    """
    poses, size = len(errors), errors.shape[0] * errors.shape[1]
    covariance = np.zeros((poses, 2, poses, 2))
    rounding = step**2 / 12
    for offsets in (slice(6, 9), slice(18, 21)):
        for alike, variance in ((1, rounding), (poses // count, OFFSET_SD**2 + rounding)):
            moved = errors[..., offsets].reshape(-1, 2 * alike, 3)
            for k, block in enumerate(variance * moved @ np.swapaxes(moved, 1, 2)):
                own = slice(k * alike, (k + 1) * alike)
                covariance[own, :, own] += block.reshape(alike, 2, alike, 2)
    return np.asarray(covariance.reshape(size, size))
