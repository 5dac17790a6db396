"""A parked scooter whose controls are moved from pose to pose, for the calibration."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.recording import Recording
from mobility_imu.rotations import elementary_rotation
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry
from mobility_imu.simulation.kinematics import angular_rates, second_derivative
from mobility_imu.simulation.profiles import least_jerk
from mobility_imu.simulation.scooter.driver import ScooterMotion
from mobility_imu.simulation.scooter.parts import Layout, ScooterUnit
from mobility_imu.simulation.scooter.ride import FAST_HZ, lever_pose
from mobility_imu.simulation.sensor import LPMS_CU2, SensorModel, measure


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


def simulate_parked(
    settings_rad: list[tuple[float, float]],
    *,
    pitch_rad: float,
    bank_rad: float,
    seed: int,
    geometry: ScooterGeometry = SUZUKI_ET4D,
    unit: ScooterUnit | None = None,
    sensor: SensorModel = LPMS_CU2,
    stop_sd_rad: float = _deg(0.5),
    sampling_rate_hz: float = 100.0,
) -> Recording:
    """Stand parked at one attitude and move the controls from pose to pose.

    Parameters
    ----------
    settings_rad : (steering, throttle) of each pose, rad, as the user believes them
    pitch_rad, bank_rad : rad, nose up and right side up
    seed : of the noise, and of how far the real stops are from what is believed
    geometry, unit, sensor : as in :func:`simulate_ride`
    stop_sd_rad : rad, that error; one for each different steering and throttle angle
    sampling_rate_hz : Hz

    Returns
    -------
    Recording of ``lever`` and ``body``; each pose is held for 2 s, each change takes 1 s
    """
    unit = unit or ScooterUnit()
    rng = np.random.default_rng([seed, 14])
    believed = np.array(settings_rad, float)
    real = believed.copy()
    for control in range(2):
        for value in np.unique(believed[:, control]):
            real[believed[:, control] == value, control] += stop_sd_rad * rng.standard_normal()
    time_s = np.arange(0, 3.0 * len(real) - 1.0, 1 / FAST_HZ)
    u = np.clip(time_s[:, None] - 3.0 * np.arange(1, len(real)) + 1.0, 0, 1)
    moved = least_jerk(u) @ np.diff(real, axis=0)
    steering, throttle = (real[0] + moved).T
    still = np.zeros(len(time_s))
    motion = ScooterMotion(
        time_s, still, still, still, np.zeros((len(time_s), 2)), steering, throttle
    )
    place, turn = lever_pose(motion, geometry, Layout())
    level = elementary_rotation("x", pitch_rad) @ elementary_rotation("y", -bank_rad)
    sensors = {}
    for k, (name, at, axes, tilt) in enumerate(
        (
            ("lever", place, turn, unit.lever_mounting),
            (
                "body",
                np.zeros_like(place),
                np.broadcast_to(np.eye(3), turn.shape),
                unit.body_mounting,
            ),
        )
    ):
        world = level @ axes @ Rotation.from_rotvec(tilt).as_matrix()
        force = second_derivative(at @ level.T, 1 / FAST_HZ)
        force[:, 2] += STANDARD_GRAVITY_MPS2
        output = measure(
            time_s,
            np.einsum("nij,ni->nj", world, force),
            angular_rates(world, 1 / FAST_HZ),
            sensor,
            sampling_rate_hz=sampling_rate_hz,
            seed=2 * seed + k,
            unit_seed=2 * unit.unit_seed + k,
        )
        sensors[name] = output.imu
    return Recording(output.time_s, sensors, source="simulated parked scooter")
