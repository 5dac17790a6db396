"""Walking frame with one IMU: calibrated by tilting, then followed (Doan & Pham)."""

from mobility_imu.walker.geometry import WalkerGeometry, WalkerMount

__all__ = ["WalkerGeometry", "WalkerMount"]
