"""How the two IMUs sit on a scooter, from parked poses with the controls at their stops.

A degree of mounting error costs up to three degrees of steering, more than the sensor's noise.
Parked, with the steering at its locks and the lever at its ends, eq. 5 has no unknown left but the
mounting.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage, optimize
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.scooter.geometry import ScooterGeometry, lever_acceleration
from mobility_imu.scooter.mount import ScooterMount

STILL_RATE_RADPS = 0.03
"""Root mean square rate below which the lever's IMU rests."""
SHORTEST_STILL_S = 0.8
"""Seconds that a pose is held at least."""
DIRECTIONS = (
    "lever IMU about x",
    "lever IMU about y",
    "lever IMU about z",
    "body IMU about x",
    "body IMU about y",
    "body IMU about z",
)


class ParkedPose(NamedTuple):
    """What both IMUs read in one still pose, and where the controls were.

    Parameters
    ----------
    lever_acc_mps2, body_acc_mps2 : (3,) arrays, m/s², means over the pose, IMU axes
    steering_rad, throttle_rad : rad, known from the stops
    """

    lever_acc_mps2: FloatArray
    body_acc_mps2: FloatArray
    steering_rad: float
    throttle_rad: float


def calibrate_mounting(
    poses: Sequence[ParkedPose],
    geometry: ScooterGeometry,
    *,
    pose_sd_rad: float = float(np.deg2rad(0.5)),
    prior_sd_rad: float = float(np.deg2rad(2.0)),
) -> ScooterMount:
    """Find both mountings by least squares over parked poses (eq. 5).

    The attitude of the scooter need not be known: the body's IMU measures it. What the poses
    cannot tell apart: a turn of the body's IMU about the vertical (on level ground only: park on a
    ramp as well), alpha's error from a turn of the body's IMU about x, beta's error from one of the
    lever's IMU about x, and a constant bias of an accelerometer from a tilt of it. What is found is
    then the sum that explains the poses, and so mends them; a weak prior keeps the rest small.

    Parameters
    ----------
    poses : at least three, not all with the same steering and throttle
    geometry : ScooterGeometry
    pose_sd_rad : rad, how well the angles at the stops are known
    prior_sd_rad : rad, how far from nominal a mounting may be expected to be, about each axis

    Returns
    -------
    ScooterMount

    Raises
    ------
    InputError
        If there are too few different poses.
    """
    different = {(round(p.steering_rad, 3), round(p.throttle_rad, 3)) for p in poses}
    if len(poses) < 3 or len({p[0] for p in different}) < 2 or len({p[1] for p in different}) < 2:
        raise InputError(
            f"{len(poses)} poses with {len(different)} different settings: expected at least three "
            "poses, with two steering and two throttle angles among them"
        )
    lever = _directions([p.lever_acc_mps2 for p in poses])
    body = _directions([p.body_acc_mps2 for p in poses])
    steering = np.array([p.steering_rad for p in poses])
    throttle = np.array([p.throttle_rad for p in poses])

    def misfit(turns: FloatArray) -> FloatArray:
        seen = lever @ Rotation.from_rotvec(turns[:3]).as_matrix().T
        upright = body @ Rotation.from_rotvec(turns[3:]).as_matrix().T
        apart = seen - lever_acceleration(upright, steering, throttle, geometry)
        return np.r_[apart.ravel() / pose_sd_rad, turns / prior_sd_rad]

    found = optimize.least_squares(misfit, np.zeros(6), method="lm")
    information = found.jac.T @ found.jac
    # Seen: the poses alone say more about a direction than the prior does.
    poses_only = information - np.eye(6) / prior_sd_rad**2
    unseen = tuple(
        name
        for name, own in zip(DIRECTIONS, np.diag(poses_only), strict=True)
        if own < 1 / prior_sd_rad**2
    )
    sd = np.sqrt(np.diag(np.linalg.inv(information)))
    weak = tuple(
        name
        for name, spread in zip(DIRECTIONS, sd, strict=True)
        if spread > 0.8 * prior_sd_rad and name not in unseen
    )
    return ScooterMount(
        Rotation.from_rotvec(found.x[:3]).as_matrix(),
        Rotation.from_rotvec(found.x[3:]).as_matrix(),
        sd,
        unseen + weak,
    )


def find_stills(parked: Recording) -> list[slice]:
    """Stretches in which lever and body rest, in the order of time.

    Rest means a small rate of the lever's gyroscope for at least :data:`SHORTEST_STILL_S`; a
    tenth of a second at each end is left out.

    Parameters
    ----------
    parked : Recording with a sensor ``lever`` that has a gyroscope

    Returns
    -------
    list of slices of samples
    """
    fs = parked.sampling_rate_hz
    gyr = np.asarray(parked.sensor("lever", gyroscope=True).gyr_radps)
    gyr = gyr - np.median(gyr, axis=0)  # a constant bias is no motion
    power = ndimage.uniform_filter1d((gyr**2).sum(axis=1), max(3, round(0.2 * fs)))
    still = np.r_[False, power < STILL_RATE_RADPS**2, False].astype(np.int8)
    starts, stops = np.nonzero(np.diff(still) == 1)[0], np.nonzero(np.diff(still) == -1)[0]
    margin = round(0.1 * fs)
    return [
        slice(int(start) + margin, int(stop) - margin)
        for start, stop in zip(starts, stops, strict=True)
        if stop - start >= SHORTEST_STILL_S * fs
    ]


def parked_poses(
    parked: Recording, settings_rad: Sequence[tuple[float, float]]
) -> list[ParkedPose]:
    """Read the poses of a parked recording: one still stretch per setting, in order.

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
        If there are not as many still stretches as settings; the message lists their times.
    """
    stills = find_stills(parked)
    if len(stills) != len(settings_rad):
        times = ", ".join(
            f"{parked.time_s[s.start]:.1f}-{parked.time_s[s.stop - 1]:.1f} s" for s in stills
        )
        raise InputError(
            f"{parked.source}: {len(stills)} still stretches ({times or 'none'}), expected "
            f"{len(settings_rad)}, one per pose"
        )
    lever, body = parked.sensor("lever").acc_mps2, parked.sensor("body").acc_mps2
    return [
        ParkedPose(lever[still].mean(axis=0), body[still].mean(axis=0), *setting)
        for still, setting in zip(stills, settings_rad, strict=True)
    ]


def _directions(vectors: Sequence[ArrayLike]) -> FloatArray:
    rows = np.array(vectors, float)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)
