"""Geometry of a manual chair's two driving wheels.

Chair frame: origin on the floor midway between the wheels' contact points, x forward, y left,
z up. A wheel's axle direction is taken so that rolling forward turns it positively.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.geometry import read_section

Side = Literal["left", "right"]

DOCUMENT_TO_CHAIR = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation from the axes of WheelMove-ID's Figure 1 (v0) to the chair frame, (3, 3).

The figure draws the chair with X forward, Y up and Z to the right; the chair frame here has x
forward, y left and z up. Both are right-handed. Positive yaw, about the figure's Y and about z
here, is to the left in both.
"""
DOCUMENT_TO_CHAIR.setflags(write=False)


class WheelPair(NamedTuple):
    """One value per wheel."""

    left: float
    right: float


@dataclass(frozen=True)
class WheelchairGeometry:
    """What has to be measured on the chair.

    Parameters
    ----------
    camber_rad : float, rad, positive with the wheels' tops leaning in
    wheel_radius_left_m, wheel_radius_right_m : float, m, from axle to floor along the wheel
    track_m : float, m, between the wheels' contacts with the floor

    Raises
    ------
    InputError
        If a value is impossible; the message says which and guesses at a wrong unit.

    Examples
    --------
    >>> chair = WheelchairGeometry.from_degrees(
    ...     19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
    ... )
    >>> round(chair.wheel_centre_distance_m, 4)
    0.6335
    """

    camber_rad: float
    wheel_radius_left_m: float
    wheel_radius_right_m: float
    track_m: float

    def __post_init__(self) -> None:
        """Refuse what no chair can have."""
        if not np.isfinite(self.camber_rad) or not -0.1 <= self.camber_rad <= np.deg2rad(35):
            hint = " (a camber in degrees?)" if self.camber_rad > 1 else ""
            raise InputError(
                f"camber_rad = {self.camber_rad:g}: expected between -0.1 and 0.61 rad{hint}"
            )
        for name in ("wheel_radius_left_m", "wheel_radius_right_m"):
            radius = getattr(self, name)
            if not np.isfinite(radius) or not 0.1 <= radius <= 0.5:
                hint = ""
                if 10 <= radius <= 50:
                    hint = " (in cm?)"
                elif 0.5 < radius <= 2.5:
                    hint = " (a diameter or circumference?)"
                raise InputError(f"{name} = {radius:g}: expected between 0.1 and 0.5 m{hint}")
        if not np.isfinite(self.track_m) or not 0.3 <= self.track_m <= 1.5:
            hint = " (in cm?)" if self.track_m > 30 else ""
            raise InputError(f"track_m = {self.track_m:g}: expected between 0.3 and 1.5 m{hint}")
        if self.wheel_centre_distance_m < 0.2:
            raise InputError(
                f"track_m = {self.track_m:g}: with this camber and these radii the wheel centres "
                f"would be {self.wheel_centre_distance_m:.3f} m apart, expected 0.2 m or more"
            )

    @classmethod
    def from_degrees(
        cls,
        camber_deg: float,
        *,
        wheel_radius_left_m: float,
        wheel_radius_right_m: float,
        track_m: float,
    ) -> WheelchairGeometry:
        """Make it with the camber in degrees."""
        if 0 < abs(camber_deg) < 0.61:
            raise InputError(
                f"camber_deg = {camber_deg:g}: no camber is that small; is it in radians?"
            )
        return cls(
            float(np.deg2rad(camber_deg)), wheel_radius_left_m, wheel_radius_right_m, track_m
        )

    @classmethod
    def from_circumference(
        cls,
        camber_deg: float,
        *,
        wheel_circumference_left_m: float,
        wheel_circumference_right_m: float,
        track_m: float,
    ) -> WheelchairGeometry:
        """Make it from the wheels' roll-out lengths (m), which are easier to measure."""
        return cls.from_degrees(
            camber_deg,
            wheel_radius_left_m=wheel_circumference_left_m / (2 * np.pi),
            wheel_radius_right_m=wheel_circumference_right_m / (2 * np.pi),
            track_m=track_m,
        )

    @classmethod
    def from_toml(cls, path: str | Path) -> WheelchairGeometry:
        """Read section [wheelchair] of a geometry file."""
        keys = ("camber_deg", "wheel_radius_left_m", "wheel_radius_right_m", "track_m")
        values = read_section(path, "wheelchair", keys)
        try:
            return cls.from_degrees(values.pop("camber_deg"), **values)
        except InputError as error:
            raise InputError(f"{path}, [wheelchair]: {error}") from None

    @property
    def wheel_radius_m(self) -> WheelPair:
        """Radii of the left and the right wheel, m."""
        return WheelPair(self.wheel_radius_left_m, self.wheel_radius_right_m)

    @property
    def wheel_centre_distance_m(self) -> float:
        """Lateral distance in m between the wheels' centres (the track less the lean of both)."""
        return self.track_m - float(sum(self.wheel_radius_m) * np.sin(self.camber_rad))

    def axle_direction(self, side: Side) -> FloatArray:
        """Unit vector of a wheel's axle in the chair frame, forward spin positive, (3,)."""
        lean = side_sign(side) * np.sin(self.camber_rad)
        return np.array([0.0, np.cos(self.camber_rad), lean])

    def wheel_centre(self, side: Side) -> FloatArray:
        """Position of a wheel's centre in the chair frame, m, (3,)."""
        sign = side_sign(side)
        radius = getattr(self.wheel_radius_m, side)
        inward = radius * np.sin(self.camber_rad)
        height = radius * np.cos(self.camber_rad)
        return np.array([0.0, sign * (self.track_m / 2 - inward), height])


SAMPLE_CHAIR = WheelchairGeometry.from_degrees(
    19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
)
"""Chair of WheelMove-ID's public sample, from its file ``Properties.txt``."""


def side_sign(side: Side) -> int:
    """+1 for the left wheel (y > 0), -1 for the right one."""
    if side not in ("left", "right"):
        raise InputError(f"side = {side!r}: expected 'left' or 'right'")
    return 1 if side == "left" else -1
