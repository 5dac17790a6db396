"""Smooth drives on a flat floor without slip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_number, as_series, shown
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.sensor import IDEAL, SensorModel, SensorNoise
from mobility_imu.simulation.wheelchair.chair import (
    SIDES,
    ChairMotion,
    Leg,
    Mounting,
    check_legs,
    check_mounting,
    checked_rate,
    frame_imu,
    samples_of,
    sloping,
    stepped,
    wheel_imu,
)
from mobility_imu.wheelchair.geometry import WheelchairGeometry

if TYPE_CHECKING:
    import pandas as pd

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


# The size of what the three sensors of WheelMove-ID's sample show in its static trial.
LIKE_SAMPLE = SensorNoise(0.02, 0.003, 0.02, 0.003)


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedDrive(Result):
    """A recording and the truth that it was simulated from.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel
    linear_velocity_mps : (n,) array, m/s, midway between the wheels' contacts
    yaw_rate_radps : (n,) array, rad/s
    task : (n,) array of task codes, 1 to 6. A rest ends when motion begins and begins when it ends;
        between two motions the change is in the middle
    """

    recording: Recording
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    task: NDArray[np.int8]

    def __post_init__(self) -> None:
        """Check that there is one number for each sample."""
        expect(f"{type(self).__name__}.recording", self.recording, Recording)
        count = len(self.recording)
        check_fields(self, linear_velocity_mps=(count,), yaw_rate_radps=(count,))
        label = f"{type(self).__name__}.task"
        task = as_series(self.task, label, length=count)
        strange = ~np.isin(task, np.arange(1, 7))
        if strange.any():
            first = int(np.argmax(strange))
            raise InputError(f"{label}: sample {first} is {task[first]:g}, expected 1 to 6")
        object.__setattr__(self, "task", task.astype(np.int8))
        super().__post_init__()

    def truth(self) -> pd.DataFrame:
        """Table of the truth, columns as the velocity and task tables have them."""
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.recording.time_s,
                "linear_velocity_mps": self.linear_velocity_mps,
                "yaw_rate_degps": np.rad2deg(self.yaw_rate_radps),
                "task_code": self.task,
            }
        )


def simulate_drive(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: Mapping[str, Mounting],
    *,
    seed: int,
    noise: SensorNoise | SensorModel = LIKE_SAMPLE,
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
    noise : SensorNoise, or ``IDEAL`` for none. Other sensor
        models need samples that are finer than the recording's: see ``simulate_court``
    sampling_rate_hz : Hz
    transition_s : s, length of a change
    push_share : speed swings by this fraction of itself with each push, from 0 to below 1
    push_rate_hz : pushes per second

    Returns
    -------
    SimulatedDrive

    Raises
    ------
    InputError
        If there is no leg, a leg is shorter than a change or slopes, the mounting of a sensor is
        missing, a number is out of its range, or the seed is negative or not whole.
    """
    transition_s = check_legs(legs, transition_s)
    check_mounting(mounting)
    expect("geometry", geometry, WheelchairGeometry)
    sampling_rate_hz = checked_rate(sampling_rate_hz)
    if as_number(push_share, "push_share", zero=True) >= 1:
        raise InputError(f"push_share = {push_share:g}: expected from 0 to below 1")
    push_rate_hz = as_number(push_rate_hz, "push_rate_hz")
    if isinstance(noise, SensorModel) and noise == IDEAL:
        noise = SensorNoise()
    if not isinstance(noise, SensorNoise):
        raise InputError(
            f"noise = {shown(noise)}: expected SensorNoise or IDEAL; simulate_court takes any model"
        )
    for leg in legs:
        if leg.slope_deg:
            raise InputError(f"slope_deg = {leg.slope_deg:g}: this drive is on a flat floor")
    count = samples_of(legs, sampling_rate_hz)
    time_s = np.arange(count) / sampling_rate_hz
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    speed, speed_change, _ = stepped(
        [leg.linear_velocity_mps for leg in legs], ends, time_s, transition_s
    )
    yaw, yaw_change, _ = stepped(
        [np.deg2rad(leg.yaw_rate_degps) for leg in legs], ends, time_s, transition_s
    )
    turn = 2 * np.pi * push_rate_hz
    swing = 1 + push_share * np.sin(turn * time_s)
    velocity = speed * swing
    acceleration = speed_change * swing + speed * push_share * turn * np.cos(turn * time_s)
    motion = _flat(velocity, acceleration, yaw, yaw_change)
    rng = stream(seed)
    sensors = {"frame": frame_imu(motion, mounting["frame"])}
    for side in SIDES:
        sensors[f"{side}_wheel"] = wheel_imu(
            time_s, motion, geometry, side, mounting[f"{side}_wheel"]
        )
    sensors = {name: noise.added_to(imu, rng) for name, imu in sensors.items()}
    recording = Recording(time_s, sensors, source="simulated wheelchair")
    return SimulatedDrive(recording, velocity, yaw, _tasks(legs, ends, time_s, transition_s))


def _tasks(
    legs: Sequence[Leg], ends: FloatArray, time_s: FloatArray, transition_s: float
) -> NDArray[np.int8]:
    task = np.full(len(time_s), legs[0].task, np.int8)
    for end, before, after in zip(ends, legs[:-1], legs[1:], strict=True):
        at = end
        if before.task == 1 and after.task != 1:
            at = end - transition_s / 2
        elif after.task == 1 and before.task != 1:
            at = end + transition_s / 2
        task[time_s >= at] = after.task
    return task


def _flat(
    velocity: FloatArray, acceleration: FloatArray, yaw: FloatArray, yaw_change: FloatArray
) -> ChairMotion:
    level = np.zeros_like(velocity)
    return sloping(velocity, acceleration, yaw, yaw_change, (level, level, level))
