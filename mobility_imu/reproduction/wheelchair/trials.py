"""Simulated drives with the calibration that belongs to them; the document's signs tried out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.reproduction.wheelchair.facing import Facing, facing_mounting
from mobility_imu.reproduction.wheelchair.printed import (
    velocity_printed,
    wheel_rates_printed,
    yaw_rate_printed,
)
from mobility_imu.simulation.sensor import IDEAL, MTI_1
from mobility_imu.simulation.wheelchair import (
    COURT,
    LIKE_SAMPLE,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    Leg,
    Mounting,
    SensorNoise,
    SimulatedCourt,
    SimulatedDrive,
    SlipEpisode,
    random_mounting,
    simulate_court,
    simulate_drive,
)
from mobility_imu.wheelchair.calibration import calibrate_mount
from mobility_imu.wheelchair.codes import Codes
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.tasks import identify_tasks
from mobility_imu.wheelchair.velocity import estimate_velocity

STRAIGHT_ON = (Leg(1, 1.0), Leg(2, 5.0, 1.0), Leg(1, 1.0))
"""Straight ahead at 1 m/s."""

TURN_LEFT = (Leg(1, 1.0), Leg(4, 5.0, 0.0, float(np.rad2deg(1.0))), Leg(1, 1.0))
"""On the spot to the left at 1 rad/s."""

MIDDLE = 350
"""A sample in the middle of both drives, where speed and yaw rate are constant."""


def drive_and_calibrate(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: Mapping[str, Mounting],
) -> tuple[SimulatedDrive, WheelchairMount]:
    """Simulate a drive with ideal sensors, and the mount that the chair's calibration gives.

    Parameters
    ----------
    legs : the drive
    geometry : WheelchairGeometry
    mounting : of ``frame``, ``left_wheel``, ``right_wheel``

    Returns
    -------
    drive : SimulatedDrive
    mount : WheelchairMount, from a trial at rest and one straight ahead
    """
    still, line, drive = (
        simulate_drive(part, geometry, mounting, seed=seed, noise=IDEAL)
        for seed, part in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, legs))
    )
    return drive, calibrate_mount(still.recording, line.recording).mount


def court_and_calibrate(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: Mapping[str, Mounting],
    slips: Sequence[SlipEpisode] = (),
) -> tuple[SimulatedCourt, WheelchairMount]:
    """Simulate a drive with pushes, slip and a data sheet's sensors, and the chair's mount.

    Parameters
    ----------
    legs : the drive
    geometry : WheelchairGeometry
    mounting : of ``frame``, ``left_wheel``, ``right_wheel``
    slips : episodes in which a wheel spins or skids; none in the calibration trials

    Returns
    -------
    court : SimulatedCourt, sensors as ``MTI_1``
    mount : WheelchairMount, from trials with the same sensors
    """
    trials = ((STATIC_TRIAL, ()), (STRAIGHT_TRIAL, ()), (legs, slips))
    still, line, court = (
        simulate_court(part, geometry, mounting, seed=seed, slips=some, model=MTI_1)
        for seed, (part, some) in enumerate(trials)
    )
    return court, calibrate_mount(still.recording, line.recording).mount


def court_tasks(camber_deg: float, noise_times: float, seed: int) -> tuple[Codes, Codes]:
    """Tasks found on the standard court, from raw readings on, and the tasks that were driven.

    Parameters
    ----------
    camber_deg : of a chair with radii of 0.31 and 0.312 m and a track of 0.80 m
    noise_times : factor of the noise and the biases of WheelMove-ID's sample
    seed : of mounting and noise

    Returns
    -------
    found, driven : (n,) arrays of task codes
    """
    chair = WheelchairGeometry.from_degrees(
        camber_deg, wheel_radius_left_m=0.31, wheel_radius_right_m=0.312, track_m=0.80
    )
    noise = SensorNoise(*(noise_times * size for size in astuple(LIKE_SAMPLE)))
    mounting = random_mounting(seed)
    static, straight, drive = (
        simulate_drive(legs, chair, mounting, seed=10 * seed + k, noise=noise)
        for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, COURT))
    )
    mount = calibrate_mount(static.recording, straight.recording).mount
    found = identify_tasks(estimate_velocity(drive.recording, chair, mount))
    return found.codes, drive.task


def wheel_rates(recording: Recording, mount: WheelchairMount) -> dict[Side, FloatArray]:
    """Gyroscope of each wheel in wheel axes.

    Parameters
    ----------
    recording : Recording with sensors left_wheel and right_wheel
    mount : WheelchairMount

    Returns
    -------
    dict from side to (n, 3) array, rad/s; z is the axle, positive rolling forward
    """
    return {side: mount.wheel(side, recording.gyroscope(f"{side}_wheel")) for side in SIDES}


def printed_speed_and_turn(
    facing: Facing, geometry: WheelchairGeometry, *, seed: int
) -> tuple[float, float]:
    """Speed by (1.17) straight ahead at 1 m/s, and yaw rate by (1.18) in a left turn at 1 rad/s.

    The document to the letter, from its arctangents on, with bare axle rates and the distance of
    the wheels' centres.

    Parameters
    ----------
    facing : "outward" as in Figure 1, "inward" as on the public sample
    geometry : WheelchairGeometry
    seed : of the sensors' tilts

    Returns
    -------
    speed : m/s
    yaw rate : rad/s
    """
    mounting = facing_mounting(facing, seed)
    line, turn = (
        simulate_drive(legs, geometry, mounting, seed=0, noise=IDEAL, push_share=0.0).recording
        for legs in (STRAIGHT_ON, TURN_LEFT)
    )
    pushed, turned = wheel_rates_printed(line, line), wheel_rates_printed(line, turn)
    speed = velocity_printed(pushed.left[:, 2], pushed.right[:, 2], geometry)
    distance_m = geometry.wheel_centre_distance_m
    yaw_rate = yaw_rate_printed(
        turned.left[:, 2], turned.right[:, 2], geometry, distance_m=distance_m
    )
    return float(speed[MIDDLE]), float(yaw_rate[MIDDLE])
