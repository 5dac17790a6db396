"""Motions that a walking frame's method does not follow: it rolls, is a foot, or starts loosely.

Or its floor is not level, or its IMU does not stay as it was. Each gives a true motion, so that a
path can be held against it; that of a turned IMU is a frame's which the IMU would still fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.profiles import hump, smooth, window
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.walker import FAST_HZ, WalkerMotion
from mobility_imu.walker.mount import WalkerMount

__all__ = [
    "foot_motion",
    "loose_start",
    "over_kerbs",
    "rolling_motion",
    "shaken",
    "turned_on_the_way",
    "up_a_ramp",
]

FIRST_STILL_S, LAST_STILL_S = 3.0, 2.0
ROLLED_M, ROLLS = (1.0, 2.0), 5
ROLLING_MPS = (0.3, 0.7)
"""Speeds with a rollator, ours."""
GAINED_S = (1.0, 2.0)
PAUSE_S = (1.0, 2.0)
BEND_RAD = float(np.deg2rad(40.0))
GYRO_PER_ACC = 0.02
"""rad/s of shaking that comes with 1 m/s² of it, ours."""
STANCE_S, SWING_S = (0.5, 0.8), (0.5, 0.8)
FOOT_STEPS = 20
FOOT_M, FOOT_LIFT_M = (0.6, 1.1), 0.06
RAMP_FROM_M, BEND_OF_RAMP_M = 1.0, 0.5
"""Way before a ramp, and way over which the frame comes to lean as it does: as long as the frame
is."""
SLIPS_S = 0.5
"""Time in which an IMU is turned on the frame, ours."""


def rolling_motion(seed: int) -> WalkerMotion:
    """Frame that is rolled on its wheels: gains speed, rolls in a bend, stops, and again.

    Parameters
    ----------
    seed : the same seed gives the same bytes

    Returns
    -------
    WalkerMotion without steps
    """
    rng = stream(seed, 51)
    way, bends, when, clock = [], [], [], FIRST_STILL_S
    for _ in range(ROLLS):
        length, speed = rng.uniform(*ROLLED_M), rng.uniform(*ROLLING_MPS)
        gain = rng.uniform(*GAINED_S)
        way.append((length, gain, length / speed + gain))
        bends.append(rng.uniform(-BEND_RAD, BEND_RAD))
        when.append(clock)
        clock += length / speed + gain + rng.uniform(*PAUSE_S)
    time_s = np.arange(int((clock + LAST_STILL_S) * FAST_HZ)) / FAST_HZ
    gone, heading = np.zeros(len(time_s)), np.zeros(len(time_s))
    stationary = np.ones(len(time_s), np.bool_)
    for (length, gain, takes), bend, start in zip(way, bends, when, strict=True):
        since = np.clip(time_s - start, 0.0, takes)
        rate = smooth(since / gain) - smooth((since - takes + gain) / gain)
        part = np.cumsum(rate)
        part = part / part[-1]
        gone += length * part
        heading += bend * part
        stationary &= (time_s <= start) | (time_s >= start + takes)
    step = np.diff(gone, prepend=0.0)[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    position = np.zeros((len(time_s), 3))
    position[:, :2] = np.cumsum(step, axis=0)
    rotation = Rotation.from_euler("z", heading[:, None]).as_matrix()
    return WalkerMotion(time_s, position, rotation, stationary)


def shaken(recording: Recording, motion: WalkerMotion, rms_mps2: float, seed: int) -> Recording:
    """Recording with the shaking of wheels on a floor, in proportion to the speed.

    Parameters
    ----------
    recording : Recording of the motion
    motion : WalkerMotion
    rms_mps2 : m/s² per axis at 1 m/s
    seed : of the shaking

    Returns
    -------
    Recording
    """
    speed = np.linalg.norm(motion.velocity_mps[:, :2], axis=1)
    at = np.interp(recording.time_s, motion.time_s, speed)[:, None]
    imu, rng = recording.sensor("frame"), stream(seed, 52)
    noise = rng.standard_normal((2, len(recording), 3))
    acc = imu.acc_mps2 + rms_mps2 * at * noise[0]
    gyr = recording.gyroscope("frame") + GYRO_PER_ACC * rms_mps2 * at * noise[1]
    return Recording(recording.time_s, {"frame": Imu(acc, gyr)}, source=recording.source)


def foot_motion(seed: int, pitch_rad: float) -> WalkerMotion:
    """Foot that stands flat, swings with its heel up, and stands again.

    Parameters
    ----------
    seed : the same seed gives the same bytes
    pitch_rad : rad, how far it tips over in its swing, and half as far back before it lands

    Returns
    -------
    WalkerMotion without steps
    """
    rng = stream(seed, 53)
    swing, stance = rng.uniform(*SWING_S, FOOT_STEPS), rng.uniform(*STANCE_S, FOOT_STEPS)
    length = rng.uniform(*FOOT_M, FOOT_STEPS)
    starts = FIRST_STILL_S + np.cumsum(swing + stance) - swing - stance
    time_s = np.arange(int((starts[-1] + swing[-1] + LAST_STILL_S) * FAST_HZ)) / FAST_HZ
    position, pitch = np.zeros((len(time_s), 3)), np.zeros(len(time_s))
    stationary = np.ones(len(time_s), np.bool_)
    for start, takes, way in zip(starts, swing, length, strict=True):
        part = np.clip((time_s - start) / takes, 0.0, 1.0)
        position[:, 0] += way * smooth(part)
        position[:, 2] += FOOT_LIFT_M * hump(part)
        pitch += pitch_rad * (hump(np.clip(2 * part / 1.2, 0, 1)) - _toe_up(part))
        stationary &= (part <= 0) | (part >= 1)
    rotation = Rotation.from_euler("y", pitch[:, None]).as_matrix()
    return WalkerMotion(time_s, position, rotation, stationary)


def _toe_up(part: FloatArray) -> FloatArray:
    """Second half of a swing: the toes come up by half as much as the heel did."""
    return hump(np.clip((part - 0.6) / 0.4, 0.0, 1.0)) / 2


def loose_start(motion: WalkerMotion, sway_rad: float, turn_rad: float, seed: int) -> WalkerMotion:
    """Walk before which the frame is moved on the spot where it was to rest.

    Parameters
    ----------
    motion : WalkerMotion, which begins at rest
    sway_rad : rad, amplitude of a swaying about the frame's cross axis
    turn_rad : rad, about the vertical, steadily up to the first step; the walk goes on turned
    seed : of the swaying's frequency

    Returns
    -------
    WalkerMotion
    """
    rng, time_s = stream(seed, 54), motion.time_s
    until = float(time_s[int(np.argmin(motion.stationary))]) - 0.2
    wave = np.sin(2 * np.pi * rng.uniform(0.5, 1.0) * time_s)
    sway = sway_rad * wave * window(time_s, -1.0, until, 0.5)
    ends = until - 0.3
    turn = turn_rad * np.minimum(time_s, ends) / ends
    turned = Rotation.from_euler("z", turn[:, None])
    rotation = turned.as_matrix() @ motion.rotation_body_to_world
    rotation = rotation @ Rotation.from_euler("y", sway[:, None]).as_matrix()
    # The world turns with it: the walk is the same, seen from another side.
    position = np.einsum("ij,nj->ni", turned.as_matrix()[-1], motion.position_m)
    return replace(motion, position_m=position, rotation_body_to_world=rotation)


def over_kerbs(
    motion: WalkerMotion, steps: Sequence[int], heights_m: Sequence[float]
) -> WalkerMotion:
    """Walk in which some steps end higher or lower than they began.

    Parameters
    ----------
    motion : WalkerMotion on a level floor
    steps : their numbers
    heights_m : m, of each, upward positive

    Returns
    -------
    WalkerMotion
    """
    place = motion.position_m.copy()
    for number, height in zip(steps, heights_m, strict=True):
        step = motion.steps[number]
        part = (motion.time_s - step.lift_s) / (step.place_s - step.lift_s)
        place[:, 2] += height * smooth(part)
    return replace(motion, position_m=place)


def up_a_ramp(motion: WalkerMotion, slope_rad: float) -> WalkerMotion:
    """Straight walk that begins on a level floor, which then rises or falls at one slope.

    Parameters
    ----------
    motion : WalkerMotion along x on a level floor
    slope_rad : rad, upward positive

    Returns
    -------
    WalkerMotion
    """
    way = motion.position_m[:, 0]
    grid = np.linspace(way.min() - 0.1, way.max() + 0.1, 10_001)
    slopes = slope_rad * smooth((grid - RAMP_FROM_M) / BEND_OF_RAMP_M)
    # The way is that along the floor.
    step = np.diff(grid, prepend=grid[0])
    along = np.interp(way, grid, grid[0] + np.cumsum(np.cos(slopes) * step))
    height = np.interp(way, grid, np.cumsum(np.sin(slopes) * step))
    leans = slope_rad * smooth((way - RAMP_FROM_M) / BEND_OF_RAMP_M)
    turn = Rotation.from_euler("y", -leans[:, None]).as_matrix()
    floor = np.column_stack([along, motion.position_m[:, 1], height])
    return replace(
        motion,
        position_m=floor + turn[:, :, 2] * motion.position_m[:, 2:],
        rotation_body_to_world=turn @ motion.rotation_body_to_world,
    )


def turned_on_the_way(
    motion: WalkerMotion, mount: WalkerMount, turn_rad: float, when_s: float
) -> WalkerMotion:
    """Motion of a frame that an IMU which is turned on the way would still fit.

    Parameters
    ----------
    motion : WalkerMotion
    mount : WalkerMount of the IMU before
    turn_rad : rad, by which the IMU is turned where it is, about the frame's vertical
    when_s : s, when that begins

    Returns
    -------
    WalkerMotion, for the same mount
    """
    angle = turn_rad * smooth((motion.time_s - when_s) / SLIPS_S)
    true = motion.rotation_body_to_world
    rotation = true @ Rotation.from_euler("z", angle[:, None]).as_matrix()
    apart = (true - rotation) @ mount.translation_body_m
    return replace(motion, position_m=motion.position_m + apart, rotation_body_to_world=rotation)
