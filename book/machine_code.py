"""Have the filters compiled while the first notebooks run, so that no notebook waits for it.

The results do not matter: the types of the arrays choose the machine code that numba keeps.
"""

import numpy as np

from mobility_imu import scooter, walker
from mobility_imu.data import recordings_folder
from mobility_imu.readers import read_recording
from mobility_imu.simulation.scooter import COURSES, simulate_ride

corridor = recordings_folder() / "walker_corridor"
walker.estimate_trajectory(
    read_recording(corridor / "walk.csv.gz"),
    walker.WalkerGeometry.from_toml(corridor / "geometry.toml"),
    walker.WalkerMount.from_toml(corridor / "true_mount.toml"),
)
ride = simulate_ride(COURSES["curves"], seed=1)
straight = scooter.ScooterMount(np.eye(3), np.eye(3), np.full(6, 0.02))
scooter.estimate_ride(
    ride.recording, scooter.SUZUKI_ET4D, straight, scooter.RideSettings(method="fusion")
)
