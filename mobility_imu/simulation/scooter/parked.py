"""A parked scooter whose controls are moved from pose to pose, for the calibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_floats, as_number
from mobility_imu.recording import Recording
from mobility_imu.rotations import elementary_rotation
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry
from mobility_imu.simulation.kinematics import felt_by_imu
from mobility_imu.simulation.profiles import least_jerk
from mobility_imu.simulation.scooter.driver import ScooterMotion
from mobility_imu.simulation.scooter.parts import FAST_HZ, Layout, ScooterUnit
from mobility_imu.simulation.scooter.ride import lever_pose
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.sensor import LPMS_CU2, SensorModel, measure

PARKED_POSES_DEG = ((50, 0), (50, 40), (0, 40), (0, 0), (-50, 0), (-50, 40))
"""Steering and throttle of six poses for the calibration, in an order that is quick; steering at
both locks and straight, lever released and pressed."""
PARKED_POSES_RAD = tuple((float(s), float(t)) for s, t in np.deg2rad(PARKED_POSES_DEG))
"""The same in rad."""


def _deg(value: float) -> float:
    return float(np.deg2rad(value))


def simulate_parked(
    settings_rad: Sequence[tuple[float, float]] = PARKED_POSES_RAD,
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
    settings_rad : (steering, throttle) of each pose, rad, as the user believes them; by default
        :data:`PARKED_POSES_DEG`
    pitch_rad, bank_rad : rad, nose up and right side up
    seed : of the noise, and of how far the real stops are from what is believed
    geometry, unit, sensor : as in ``simulate_ride``
    stop_sd_rad : rad, that error; one for each different steering and throttle angle
    sampling_rate_hz : Hz

    Returns
    -------
    Recording of ``lever`` and ``body``; each pose is held for 2 s, each change takes 1 s

    Raises
    ------
    InputError
        If a part is of another class, there is no pose or more than 200, a slope is above pi/4, or
        the seed is negative or not whole.
    """
    expect("geometry", geometry, ScooterGeometry)
    expect("sensor", sensor, SensorModel)
    unit = settings_or_default("unit", unit, ScooterUnit)
    for name, angle in (("pitch_rad", pitch_rad), ("bank_rad", bank_rad)):
        if abs(as_number(angle, name, negative=True)) > np.pi / 4:
            raise InputError(f"{name} = {angle:g}: expected up to pi/4 (in deg?)")
    real = _real_stops(settings_rad, as_number(stop_sd_rad, "stop_sd_rad", zero=True), seed)
    time_s = np.arange(0, 3.0 * len(real) - 1.0, 1 / FAST_HZ)
    u = time_s[:, None] - 3.0 * np.arange(1, len(real)) + 1.0
    moved = least_jerk(u) @ np.diff(real, axis=0)
    steering, throttle = (real[0] + moved).T
    still = np.zeros(len(time_s))
    path = np.zeros((len(time_s), 2))
    motion = ScooterMotion(time_s, still, still, still, path, steering, throttle)
    place, turn = lever_pose(motion, geometry, Layout())
    nowhere = np.zeros_like(place), np.broadcast_to(np.eye(3), turn.shape)
    level = elementary_rotation("x", pitch_rad) @ elementary_rotation("y", -bank_rad)
    sensors = {}
    for k, (name, (at, axes)) in enumerate({"lever": (place, turn), "body": nowhere}.items()):
        world = level @ axes @ Rotation.from_rotvec(unit.mountings[name]).as_matrix()
        output = measure(
            time_s,
            *felt_by_imu(at @ level.T, world, 1 / FAST_HZ),
            sensor,
            sampling_rate_hz=sampling_rate_hz,
            seed=2 * seed + k,
            unit_seed=2 * unit.unit_seed + k,
        )
        sensors[name] = output.imu
    return Recording(output.time_s, sensors, source="simulated parked scooter")


def _real_stops(
    settings_rad: Sequence[tuple[float, float]], stop_sd_rad: float, seed: int
) -> FloatArray:
    """Angles where the controls really stop, (k, 2), rad; one error for each different angle."""
    believed = as_floats(settings_rad, "settings_rad")
    if believed.ndim != 2 or believed.shape[1:] != (2,) or not np.isfinite(believed).all():
        raise InputError(
            "settings_rad: expected one pair (steering, throttle) of finite numbers for each pose"
        )
    if len(believed) > 200:  # the changes of all poses are made at once
        raise InputError(f"settings_rad: {len(believed)} poses, expected up to 200")
    rng = stream(seed, 14)
    real = believed.copy()
    for control in range(2):
        for value in np.unique(believed[:, control]):
            real[believed[:, control] == value, control] += stop_sd_rad * rng.standard_normal()
    return real
