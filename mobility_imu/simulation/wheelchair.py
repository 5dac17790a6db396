"""A manual chair on a flat floor, rolling without slip, with an IMU on each wheel and the frame.

Rigid-body kinematics from the chair's speed and yaw rate: nothing of the estimators is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import integrate
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.rotations import elementary_rotation
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry, side_sign

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Leg:
    """A stretch of a drive with one speed and one yaw rate.

    Parameters
    ----------
    task : task code 1-6 that is driven here (see ``mobility_imu.wheelchair.Task``)
    duration_s : s
    linear_velocity_mps : m/s, forward positive
    yaw_rate_degps : deg/s, left positive
    """

    task: int
    duration_s: float
    linear_velocity_mps: float = 0.0
    yaw_rate_degps: float = 0.0


# All six tasks, turns to both sides; radii well inside the limits of Table 1.
COURT = (
    Leg(1, 3.0),
    Leg(2, 5.0, 1.3),
    Leg(6, 4.0, 1.2, 60.0),
    Leg(2, 3.0, 1.2),
    Leg(5, 3.0, 0.5, 90.0),
    Leg(1, 2.0),
    Leg(4, 3.0, 0.0, -120.0),
    Leg(1, 2.0),
    Leg(3, 4.0, -0.9),
    Leg(1, 2.0),
    Leg(4, 2.5, 0.0, 100.0),
    Leg(2, 4.0, 1.6),
    Leg(6, 4.0, 1.3, -55.0),
    Leg(5, 3.0, 0.6, -100.0),
    Leg(2, 5.0, 1.8),
    Leg(1, 3.0),
)
STATIC_TRIAL = (Leg(1, 3.0),)
STRAIGHT_TRIAL = (Leg(1, 1.0), Leg(2, 5.0, 1.2), Leg(1, 1.0))


@dataclass(frozen=True)
class SensorNoise:
    """White noise and constant bias of the simulated IMUs, the same size on every axis.

    Parameters
    ----------
    acc_sd_mps2, gyr_sd_radps : standard deviation of each sample
    acc_bias_sd_mps2, gyr_bias_sd_radps : standard deviation of the bias drawn per sensor and axis
    """

    acc_sd_mps2: float
    gyr_sd_radps: float
    acc_bias_sd_mps2: float
    gyr_bias_sd_radps: float


IDEAL = SensorNoise(0.0, 0.0, 0.0, 0.0)
# The size of what the three sensors of WheelMove-ID's sample show in its static trial.
LIKE_SAMPLE = SensorNoise(0.02, 0.003, 0.02, 0.003)


@dataclass(frozen=True)
class Mounting:
    """How one IMU sits on its body.

    Parameters
    ----------
    rotation_body_to_imu : (3, 3) array
    position_m : (3,) array, m, in the body's frame (wheel: from its centre)
    """

    rotation_body_to_imu: FloatArray
    position_m: FloatArray


@dataclass(frozen=True)
class SimulatedDrive:
    """A recording and the truth it was made from.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel
    linear_velocity_mps : (n,) array, m/s, midway between the wheels' contacts
    yaw_rate_radps : (n,) array, rad/s
    task : (n,) array of task codes. A rest ends when motion begins and begins when it ends;
        between two motions the change is in the middle
    """

    recording: Recording
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    task: np.ndarray

    def truth(self) -> pd.DataFrame:
        """Give the truth as the velocity and task tables name it."""
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.recording.time_s,
                "linear_velocity_mps": self.linear_velocity_mps,
                "yaw_rate_degps": np.rad2deg(self.yaw_rate_radps),
                "task_code": self.task,
            }
        )


def random_mounting(seed: int) -> dict[str, Mounting]:
    """Give the three IMUs any orientation, and places as on a real chair.

    Parameters
    ----------
    seed : the same seed gives the same mounting
    """
    rng = np.random.default_rng(seed)
    places = {
        "frame": (0.10, 0.05, 0.40),
        "left_wheel": (0.04, 0.02, 0.03),
        "right_wheel": (-0.03, 0.05, 0.03),
    }
    return {
        name: Mounting(Rotation.random(rng=rng).as_matrix(), np.array(place))
        for name, place in places.items()
    }


def simulate_drive(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: dict[str, Mounting],
    *,
    seed: int,
    noise: SensorNoise = LIKE_SAMPLE,
    sampling_rate_hz: float = 100.0,
    transition_s: float = 0.8,
    push_share: float = 0.08,
    push_rate_hz: float = 1.0,
) -> SimulatedDrive:
    """Drive along legs and record it.

    Parameters
    ----------
    legs : the drive; between two legs speed and yaw rate change with minimum jerk
    geometry : WheelchairGeometry
    mounting : of ``frame``, ``left_wheel``, ``right_wheel``
    seed : for the noise; the same seed gives the same bytes
    noise : SensorNoise
    sampling_rate_hz : Hz
    transition_s : s, length of a change
    push_share : speed swings by this share of itself with each push
    push_rate_hz : pushes per second

    Returns
    -------
    SimulatedDrive

    Raises
    ------
    InputError
        If a leg is shorter than a change.
    """
    for leg in legs:
        if leg.duration_s < transition_s:
            raise InputError(
                f"leg of {leg.duration_s} s is shorter than a change of {transition_s} s"
            )
    count = round(sum(leg.duration_s for leg in legs) * sampling_rate_hz)
    time_s = np.arange(count) / sampling_rate_hz
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    speed, speed_change = _profile(
        [leg.linear_velocity_mps for leg in legs], ends, time_s, transition_s
    )
    yaw, yaw_change = _profile(
        [np.deg2rad(leg.yaw_rate_degps) for leg in legs], ends, time_s, transition_s
    )
    turn = 2 * np.pi * push_rate_hz
    swing = 1 + push_share * np.sin(turn * time_s)
    velocity = speed * swing
    acceleration = speed_change * swing + speed * push_share * turn * np.cos(turn * time_s)
    rng = np.random.default_rng(seed)
    sensors = {
        "frame": _frame_imu(velocity, acceleration, yaw, yaw_change, mounting["frame"]),
    }
    sides: tuple[Side, Side] = ("left", "right")
    for side in sides:
        sensors[f"{side}_wheel"] = _wheel_imu(
            time_s,
            velocity,
            acceleration,
            yaw,
            yaw_change,
            geometry,
            side,
            mounting[f"{side}_wheel"],
        )
    sensors = {name: _add_noise(imu, noise, rng) for name, imu in sensors.items()}
    recording = Recording(time_s, sensors, source="simulated wheelchair")
    return SimulatedDrive(recording, velocity, yaw, _tasks(legs, ends, time_s, transition_s))


def _profile(
    values: Sequence[float], ends: FloatArray, time_s: FloatArray, transition_s: float
) -> tuple[FloatArray, FloatArray]:
    """Give a series of levels with minimum-jerk changes centred on the ends, and its derivative."""
    level = np.full(len(time_s), float(values[0]))
    slope = np.zeros(len(time_s))
    for end, step in zip(ends, np.diff(values), strict=True):
        u = np.clip((time_s - end) / transition_s + 0.5, 0, 1)
        level += step * u**3 * (10 - 15 * u + 6 * u**2)
        slope += step * 30 * u**2 * (1 - u) ** 2 / transition_s
    return level, slope


def _tasks(
    legs: Sequence[Leg], ends: FloatArray, time_s: FloatArray, transition_s: float
) -> np.ndarray:
    task = np.full(len(time_s), legs[0].task, np.int8)
    for end, before, after in zip(ends, legs[:-1], legs[1:], strict=True):
        at = end
        if before.task == 1 and after.task != 1:
            at = end - transition_s / 2
        elif after.task == 1 and before.task != 1:
            at = end + transition_s / 2
        task[time_s >= at] = after.task
    return task


def _frame_imu(
    velocity: FloatArray,
    acceleration: FloatArray,
    yaw: FloatArray,
    yaw_change: FloatArray,
    mounting: Mounting,
) -> Imu:
    place = np.broadcast_to(mounting.position_m, (len(yaw), 3))
    rate = np.zeros((len(yaw), 3))
    rate[:, 2] = yaw
    still = np.zeros_like(place)
    acc = _specific_force(velocity, acceleration, yaw, yaw_change, place, still, still)
    turn = mounting.rotation_body_to_imu.T
    return Imu(acc @ turn, rate @ turn)


def _wheel_imu(
    time_s: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    yaw: FloatArray,
    yaw_change: FloatArray,
    geometry: WheelchairGeometry,
    side: Side,
    mounting: Mounting,
) -> Imu:
    contact = side_sign(side) * geometry.track_m / 2
    radius = getattr(geometry.wheel_radius_m, side)
    # No slip: the contact travels as the chair does at its lateral place.
    spin = (velocity - yaw * contact) / radius
    spin_change = (acceleration - yaw_change * contact) / radius
    angle = integrate.cumulative_trapezoid(spin, time_s, initial=0)
    axle = geometry.axle_direction(side)
    ahead = np.array([1.0, 0.0, 0.0])
    base = np.column_stack([ahead, np.cross(axle, ahead), axle])  # wheel to chair at angle 0
    turned = base @ elementary_rotation("z", angle)
    arm = turned @ mounting.position_m
    swing = spin[:, None] * np.cross(axle, arm)
    swing_change = spin_change[:, None] * np.cross(axle, arm) + spin[:, None] * np.cross(
        axle, swing
    )
    acc = _specific_force(
        velocity,
        acceleration,
        yaw,
        yaw_change,
        geometry.wheel_centre(side) + arm,
        swing,
        swing_change,
    )
    rate = spin[:, None] * axle
    rate[:, 2] += yaw
    to_imu = mounting.rotation_body_to_imu @ np.swapaxes(turned, 1, 2)
    return Imu(np.einsum("nij,nj->ni", to_imu, acc), np.einsum("nij,nj->ni", to_imu, rate))


def _specific_force(
    velocity: FloatArray,
    acceleration: FloatArray,
    yaw: FloatArray,
    yaw_change: FloatArray,
    place: FloatArray,
    drift: FloatArray,
    drift_change: FloatArray,
) -> FloatArray:
    """Specific force at a place that moves in the chair's frame; chair components, (n, 3)."""
    up = np.array([0.0, 0.0, 1.0])
    around = np.cross(up, place)
    force = yaw_change[:, None] * around + yaw[:, None] ** 2 * np.cross(up, around)
    force = force + 2 * yaw[:, None] * np.cross(up, drift) + drift_change
    force[:, 0] += acceleration
    force[:, 1] += velocity * yaw
    force[:, 2] += STANDARD_GRAVITY_MPS2
    return force


def _add_noise(imu: Imu, noise: SensorNoise, rng: np.random.Generator) -> Imu:
    assert imu.gyr_radps is not None
    shape = imu.acc_mps2.shape
    acc_bias = noise.acc_bias_sd_mps2 * rng.standard_normal(3)
    gyr_bias = noise.gyr_bias_sd_radps * rng.standard_normal(3)
    return Imu(
        imu.acc_mps2 + acc_bias + noise.acc_sd_mps2 * rng.standard_normal(shape),
        imu.gyr_radps + gyr_bias + noise.gyr_sd_radps * rng.standard_normal(shape),
    )
