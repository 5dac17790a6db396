"""Steering and throttle angles of a motorized mobility scooter (Suzurikawa et al. 2022)."""

from mobility_imu.scooter.angles import ScooterAngles, estimate_angles
from mobility_imu.scooter.geometry import SUZUKI_ET4D, ScooterGeometry

__all__ = ["SUZUKI_ET4D", "ScooterAngles", "ScooterGeometry", "estimate_angles"]
