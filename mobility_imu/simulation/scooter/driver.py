"""The driver of a scooter, its speed controller and the bicycle that they move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import signal

from mobility_imu._compiled import compiled
from mobility_imu.arguments import check_limits
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, check_positive
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.simulation.scooter.course import Course, middle_line
from mobility_imu.simulation.scooter.parts import Layout
from mobility_imu.simulation.seeds import stream


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


SPEED_LIMIT_MPS = 4 / 3.6
"""Limit set in the paper's test drives (section 2.1)."""

LARGEST_STEERING_RAD = float(np.deg2rad(50))

LARGEST_THROTTLE_RAD = float(np.deg2rad(40))

DRIVER_HZ = 200.0


@dataclass(frozen=True)
class Driver:
    """How somebody drives.

    Parameters
    ----------
    look_ahead_m : distance of the point that is steered at
    throttle_rad : angle that is held on a straight
    hand_noise_rad : sd of slow, unwanted movement of steering and throttle
    arm_hz : how fast the arms follow
    """

    look_ahead_m: float = 1.0
    throttle_rad: float = _deg(32)
    hand_noise_rad: float = _deg(1.5)
    arm_hz: float = 1.5

    def __post_init__(self) -> None:
        """Check every size."""
        check_positive(self, allow_zero=("hand_noise_rad",))
        # Faster arms would not be stable in steps of 1 / DRIVER_HZ.
        check_limits(self, {"arm_hz": (1e-3, 20.0), "look_ahead_m": (0.01, 100.0)})
        if self.throttle_rad > LARGEST_THROTTLE_RAD:
            raise InputError(
                f"Driver.throttle_rad = {self.throttle_rad:g}: expected up to "
                f"{LARGEST_THROTTLE_RAD:.3f} (in deg?)"
            )


def draw_driver(seed: int) -> Driver:
    """Draw a driver.

    Parameters
    ----------
    seed : of the driver; the same seed gives the same one

    Returns
    -------
    Driver
    """
    rng = stream(seed, 12)
    return Driver(
        look_ahead_m=float(rng.uniform(0.8, 1.3)),
        throttle_rad=float(np.deg2rad(rng.uniform(25, 38))),
        hand_noise_rad=float(np.deg2rad(rng.uniform(0.8, 2.0))),
        arm_hz=float(rng.uniform(1.0, 2.0)),
    )


class ScooterMotion(NamedTuple):
    """A driven run, at DRIVER_HZ or refined.

    Parameters
    ----------
    time_s : (n,) array, s
    distance_m : (n,) array, m, driven by the rear axle's middle
    speed_mps, heading_rad, steering_rad, throttle_rad : (n,) arrays, m/s and rad, left positive
    position_m : (n, 2) array, m, x right and y forward of the start
    """

    time_s: FloatArray
    distance_m: FloatArray
    speed_mps: FloatArray
    heading_rad: FloatArray
    position_m: FloatArray  # (n, 2)
    steering_rad: FloatArray
    throttle_rad: FloatArray


def drive(
    course: Course,
    driver: Driver,
    layout: Layout,
    geometry: ScooterGeometry,
    rng: np.random.Generator,
) -> ScooterMotion:
    """Steer at a point ahead on the path, hold the throttle, let go before the end.

    Parameters
    ----------
    course : Course
    driver : Driver
    layout : Layout
    geometry : ScooterGeometry
    rng : the source of the hands' unwanted movement

    Returns
    -------
    ScooterMotion at DRIVER_HZ
    """
    path_s, path = middle_line(course)
    dt = 1 / DRIVER_HZ
    longest = round((course.length_m / SPEED_LIMIT_MPS * 2.5 + 10) * DRIVER_HZ)
    # Slow wandering of both hands: white noise through a first-order lag of 0.7 s.
    keep = np.exp(-dt / 0.7)
    wander = signal.lfilter(
        [np.sqrt(1 - keep**2)], [1, -keep], rng.standard_normal((longest, 2)), axis=0
    )
    table = _follow(
        path_s,
        path,
        driver.hand_noise_rad * wander,
        dt,
        course.length_m - 0.6,
        driver.look_ahead_m,
        driver.throttle_rad,
        2 * np.pi * driver.arm_hz,
        layout.wheelbase_m,
        float(np.cos(geometry.steering_inclination_rad)),
    )
    return ScooterMotion(
        table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4:6], table[:, 6], table[:, 7]
    )


@compiled()
def _follow(
    path_s: FloatArray,
    path: FloatArray,
    wander: FloatArray,
    dt: float,
    stop_at: float,
    look_ahead: float,
    held: float,
    omega: float,
    wheelbase: float,
    project: float,
) -> FloatArray:
    """Step driver, speed controller and bicycle, each from where it is now."""
    full_speed = np.deg2rad(30.0)
    rest = round(1.0 / dt)  # the controls stay put for a second before and after
    log = np.empty((len(wander), 8))
    x = y = heading = speed = distance = 0.0
    steering = throttle = steering_rate = throttle_rate = 0.0
    after, ahead = 0, 0
    for k in range(len(wander)):
        log[k, 0], log[k, 1], log[k, 2], log[k, 3] = k * dt, distance, speed, heading
        log[k, 4], log[k, 5], log[k, 6], log[k, 7] = x, y, steering, throttle
        moving = k >= rest and distance < stop_at
        if not moving and k > rest:
            if speed < 1e-3:
                after += 1
            if after > rest:
                return log[: k + 1]
        goal_steering = 0.0
        if moving:
            while ahead < len(path_s) - 1 and path_s[ahead] < distance + look_ahead:
                ahead += 1
            dx, dy = path[ahead, 0] - x, path[ahead, 1] - y
            # Lateral offset of that point in the body's axes (forward is y at heading 0).
            left = -dx * np.cos(heading) - dy * np.sin(heading)
            front = np.arctan(2 * wheelbase * left / (dx * dx + dy * dy))
            goal_steering = np.arctan(np.tan(front) / project) + wander[k, 0]
        elif k >= rest:
            goal_steering = steering if after > 0 else 0.5 * steering
        goal_throttle = max(held + wander[k, 1], 0.0) if moving else 0.0
        goal_steering = min(max(goal_steering, -LARGEST_STEERING_RAD), LARGEST_STEERING_RAD)
        goal_throttle = min(goal_throttle, LARGEST_THROTTLE_RAD)
        steering_rate += dt * (omega**2 * (goal_steering - steering) - 1.8 * omega * steering_rate)
        throttle_rate += dt * (omega**2 * (goal_throttle - throttle) - 1.8 * omega * throttle_rate)
        steering += dt * steering_rate
        throttle += dt * throttle_rate
        if throttle < 0:
            throttle, throttle_rate = 0.0, max(throttle_rate, 0.0)
        # The controller follows the lever with a ramp, up to the limit set by the knob.
        goal_speed = SPEED_LIMIT_MPS * min(throttle / full_speed, 1.0)
        change = min(max((goal_speed - speed) / 0.35, -1.2), 0.8)
        speed = max(speed + dt * change, 0.0)
        heading += dt * speed * np.tan(steering) * project / wheelbase
        x -= dt * speed * np.sin(heading)
        y += dt * speed * np.cos(heading)
        distance += dt * speed
    return log
