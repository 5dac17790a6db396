"""Scooters that several test files take: parked, and a mechanism of two hinges that moves."""

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.hinges import tip_reading
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter import fusion_filter as loops
from mobility_imu.scooter.fusion_settings import FROM_THE_RECORDING, FusionSettings
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration

LEAN = SUZUKI_ET4D.lean_rad
SIN, COS = (f(SUZUKI_ET4D.steering_inclination_rad) for f in (np.sin, np.cos))
KNOWN = FusionSettings(**dict.fromkeys(FROM_THE_RECORDING, 0.02))
TIMES = (0.3, 1.1, 2.7)


def parked(samples=300, *, noise=0.02, steering=0.4, throttle=0.2, seed=0):
    """Readings of a scooter that stands still: accelerations and rates of lever and body."""
    rng = np.random.default_rng(seed)
    body = np.tile(body_specific_force(0.03, 0.02), (samples, 1))
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    shaken = [acc + noise * rng.standard_normal(acc.shape) for acc in (lever, body)]
    rates = 0.25 * noise * rng.standard_normal((2, samples, 3))
    return [shaken[0], rates[0], shaken[1], rates[1]]


# A mechanism of two hinges that moves: what its sensors read follows from its positions alone.

STEP_S = 1e-3


def slope(function, at):
    """Derivative to the fourth order."""
    near, far = (function(at + k * STEP_S) - function(at - k * STEP_S) for k in (1, 2))
    return (8 * near - far) / (12 * STEP_S)


def curvature(function, at):
    """Second derivative to the fourth order."""
    near, far = (function(at + k * STEP_S) + function(at - k * STEP_S) for k in (1, 2))
    return (16 * near - far - 30 * function(at)) / (12 * STEP_S**2)


def steering(t):
    return 0.5 * np.sin(1.7 * t) + 0.1


def tip(t):
    return 0.4 * np.sin(2.3 * t) + 0.3 + LEAN


def body_turn(t):
    turned = [0.2 * np.sin(1.1 * t), 0.3 * np.cos(1.3 * t), 0.5 * t]
    return Rotation.from_rotvec(turned).as_matrix()


def body_to_lever(t):
    return np.array(tip_reading(np.eye(3), steering(t), tip(t), SIN, COS)[:3])


def lever_turn(t):
    return body_turn(t) @ body_to_lever(t).T


def column_turn(t):
    """The part between both hinges: the lever, turned back about its x by the tip."""
    sin, cos = np.sin(tip(t)), np.cos(tip(t))
    return lever_turn(t) @ np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])


def rate_of(turn, t):
    spun = turn(t).T @ slope(turn, t)
    return np.array([spun[2, 1], spun[0, 2], spun[1, 0]])


def specific_force(turn, place, t):
    path = curvature(lambda at: np.array([at**2, np.sin(at), 0.2 * np.cos(2 * at)]) + place(at), t)
    return turn(t).T @ (path + np.array([0.0, 0.0, 9.81]))


def readings_at(t, arms):
    """One sample of an IMU on the lever and one on the body, each at the end of its arm."""
    lever, body, column = arms

    def lever_place(at):
        return lever_turn(at) @ lever + column_turn(at) @ column

    def body_place(at):
        return body_turn(at) @ body

    places = ((lever_turn, lever_place), (body_turn, body_place))
    acc = [specific_force(turn, place, t) for turn, place in places]
    gyr = [rate_of(turn, t) for turn, _ in places]
    spin = [slope(lambda at, turn=turn: rate_of(turn, at), t) for turn, _ in places]
    rows = (acc[0], gyr[0], acc[1], gyr[1], *spin)
    return loops.Inputs(*(values[None] for values in rows))


def state_at(t):
    return np.r_[steering(t), tip(t) - LEAN, np.zeros(loops.STATES - 2)]
