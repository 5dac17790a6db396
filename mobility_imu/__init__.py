"""Angles, tasks and paths of mobility aids from inertial sensors.

Three devices share one plan (read, calibrate, estimate, summarise, show):
``mobility_imu.scooter`` and ``mobility_imu.wheelchair``; readers, simulators and the
comparison with the published numbers stand beside them. Importing this package loads
none of them: each is loaded when it is first used.
"""

__version__ = "0.1.0"
