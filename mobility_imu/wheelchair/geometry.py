"""Geometry of a manual chair's two driving wheels.

Chair frame: origin on the floor midway between the wheels' contact points, x forward, y left,
z up. A wheel's axle direction is taken so that rolling forward turns it positively.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.files import write_text
from mobility_imu.frames import FloatArray, as_number, one_of
from mobility_imu.readers.geometry import find_table, read_section

__all__ = [
    "DOCUMENT_TO_CHAIR",
    "SAMPLE_CHAIR",
    "SIDES",
    "Side",
    "WheelPair",
    "WheelchairGeometry",
    "printed_yaw_gain",
    "side_sign",
]

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")
SMALLEST_CAMBER_RAD, LARGEST_CAMBER_RAD = -0.1, float(np.deg2rad(35))
"""Between these lies the camber of any chair."""

DOCUMENT_TO_CHAIR = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation from the axes of WheelMove-ID's Figure 1 (v0) to the chair frame, (3, 3).

The figure draws the chair with X forward, Y up and Z to the right; the chair frame here has x
forward, y left and z up. Both are right-handed. Positive yaw, about the figure's Y and about z
here, is to the left in both.
"""
DOCUMENT_TO_CHAIR.setflags(write=False)


class WheelPair(NamedTuple):
    """One value per wheel.

    Parameters
    ----------
    left, right : float
    """

    left: float
    right: float

    def of(self, side: Side) -> float:
        """Value of one wheel.

        Parameters
        ----------
        side : "left" or "right"
        """
        return self.left if side_sign(side) > 0 else self.right


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
        """Check that the lengths and the angle can be those of a chair."""
        for name in ("camber_rad", "wheel_radius_left_m", "wheel_radius_right_m", "track_m"):
            object.__setattr__(self, name, as_number(getattr(self, name), name, negative=True))
        if not SMALLEST_CAMBER_RAD <= self.camber_rad <= LARGEST_CAMBER_RAD:
            hint = " (a camber in degrees?)" if self.camber_rad > 1 else ""
            raise InputError(
                f"camber_rad = {self.camber_rad:g}: expected between {SMALLEST_CAMBER_RAD} and "
                f"{LARGEST_CAMBER_RAD:.2f} rad{hint}"
            )
        for name in ("wheel_radius_left_m", "wheel_radius_right_m"):
            radius = getattr(self, name)
            if not 0.1 <= radius <= 0.5:
                hint = ""
                if 10 <= radius <= 50:
                    hint = " (in cm?)"
                elif 100 <= radius <= 500:
                    hint = " (in mm?)"
                elif 0.5 < radius <= 2.5:
                    hint = " (a diameter or circumference?)"
                raise InputError(f"{name} = {radius:g}: expected between 0.1 and 0.5 m{hint}")
        if not 0.3 <= self.track_m <= 1.5:
            hint = " (in cm?)" if 30 <= self.track_m <= 150 else ""
            hint = " (in mm?)" if 300 <= self.track_m <= 1500 else hint
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
        """Geometry with the camber in degrees.

        Parameters
        ----------
        camber_deg : deg, positive with the wheels' tops leaning in
        wheel_radius_left_m, wheel_radius_right_m : m, from axle to floor along the wheel
        track_m : m, between the wheels' contacts with the floor

        Returns
        -------
        WheelchairGeometry

        Raises
        ------
        InputError
            If a value is impossible, or the camber seems to be in radians.
        """
        camber_deg = as_number(camber_deg, "camber_deg", negative=True)
        low, high = np.rad2deg([SMALLEST_CAMBER_RAD, LARGEST_CAMBER_RAD])
        if 0 < abs(camber_deg) < LARGEST_CAMBER_RAD:
            raise InputError(
                f"camber_deg = {camber_deg:g}: may be in radians; in a file, write camber_rad = "
                f"{camber_deg:g} if it is, camber_rad = {np.deg2rad(camber_deg):.4g} if not"
            )
        if not low - 1e-9 <= camber_deg <= high + 1e-9:  # as a file rounds them
            raise InputError(
                f"camber_deg = {camber_deg:g}: expected between {low:.1f} and {high:g} deg"
            )
        camber_rad = float(np.clip(np.deg2rad(camber_deg), SMALLEST_CAMBER_RAD, LARGEST_CAMBER_RAD))
        return cls(camber_rad, wheel_radius_left_m, wheel_radius_right_m, track_m)

    @classmethod
    def from_circumference(
        cls,
        camber_deg: float,
        *,
        wheel_circumference_left_m: float,
        wheel_circumference_right_m: float,
        track_m: float,
    ) -> WheelchairGeometry:
        """Geometry from the wheels' roll-out lengths, which are easier to measure than radii.

        Parameters
        ----------
        camber_deg : deg, positive with the wheels' tops leaning in
        wheel_circumference_left_m, wheel_circumference_right_m : m, rolled in one turn
        track_m : m, between the wheels' contacts with the floor

        Returns
        -------
        WheelchairGeometry

        Raises
        ------
        InputError
            If a value is impossible; the message gives radii, not roll-out lengths.
        """
        left, right = (
            as_number(length, name) / (2 * np.pi)
            for name, length in (
                ("wheel_circumference_left_m", wheel_circumference_left_m),
                ("wheel_circumference_right_m", wheel_circumference_right_m),
            )
        )
        return cls.from_degrees(
            camber_deg, wheel_radius_left_m=left, wheel_radius_right_m=right, track_m=track_m
        )

    @classmethod
    def from_toml(cls, path: str | Path) -> WheelchairGeometry:
        """Geometry from section [wheelchair] of a geometry file.

        Parameters
        ----------
        path : TOML file with the camber as camber_deg or as camber_rad

        Returns
        -------
        WheelchairGeometry

        Raises
        ------
        InputError
            If there is no such file or section, a key is missing or unknown, or a value is
            impossible; the message names the file.
        """
        table = find_table(path, "wheelchair") or {}
        in_radians = "camber_rad" in table
        if in_radians and "camber_deg" in table:
            raise InputError(
                f"{path}, [wheelchair]: camber_rad and camber_deg are both given; leave one out"
            )
        camber = "camber_rad" if in_radians else "camber_deg"
        keys = (camber, "wheel_radius_left_m", "wheel_radius_right_m", "track_m")
        values = read_section(path, "wheelchair", keys)
        try:
            return cls(**values) if in_radians else cls.from_degrees(**values)
        except InputError as error:
            raise InputError(f"{path}, [wheelchair]: {error}") from None

    def to_toml(self, path: str | Path | None = None) -> str:
        """Text of section [wheelchair], as :meth:`from_toml` reads it.

        Parameters
        ----------
        path : file to write the text into; None writes nothing

        Returns
        -------
        str
        """
        # Twelve digits: radians and back leave the last ones of 19 degrees wrong.
        camber_deg = float(f"{np.rad2deg(self.camber_rad):.12g}")
        ambiguous = 0 < abs(camber_deg) < LARGEST_CAMBER_RAD
        camber = f"camber_rad = {self.camber_rad}" if ambiguous else f"camber_deg = {camber_deg}"
        text = (
            "[wheelchair]\n"
            f"{camber}\n"
            f"wheel_radius_left_m = {self.wheel_radius_left_m}\n"
            f"wheel_radius_right_m = {self.wheel_radius_right_m}\n"
            f"track_m = {self.track_m}\n"
        )
        if path is not None:
            write_text(path, text)
        return text

    @property
    def wheel_radius_m(self) -> WheelPair:
        """Radii of the left and the right wheel, m."""
        return WheelPair(self.wheel_radius_left_m, self.wheel_radius_right_m)

    @property
    def wheel_centre_distance_m(self) -> float:
        """Lateral distance in m between the wheels' centres (the track less the lean of both)."""
        return self.track_m - float(sum(self.wheel_radius_m) * np.sin(self.camber_rad))

    def axle_direction(self, side: Side) -> FloatArray:
        """Unit vector of a wheel's axle in the chair frame, forward spin positive.

        Parameters
        ----------
        side : "left" or "right"

        Returns
        -------
        (3,) array
        """
        lean = side_sign(side) * np.sin(self.camber_rad)
        return np.array([0.0, np.cos(self.camber_rad), lean])

    def wheel_centre(self, side: Side) -> FloatArray:
        """Position of a wheel's centre in the chair frame.

        Parameters
        ----------
        side : "left" or "right"

        Returns
        -------
        (3,) array, m
        """
        sign = side_sign(side)
        radius = self.wheel_radius_m.of(side)
        inward = radius * np.sin(self.camber_rad)
        height = radius * np.cos(self.camber_rad)
        return np.array([0.0, sign * (self.track_m / 2 - inward), height])


SAMPLE_CHAIR = WheelchairGeometry.from_degrees(
    19, wheel_radius_left_m=0.3147, wheel_radius_right_m=0.3195, track_m=0.84
)
"""Chair of WheelMove-ID's public sample, from its file ``Properties.txt``."""


def side_sign(side: Side) -> int:
    """+1 for the left wheel (y > 0), -1 for the right one.

    Parameters
    ----------
    side : "left" or "right"

    Returns
    -------
    int

    Raises
    ------
    InputError
        If it is neither.
    """
    return 1 if one_of("side", side, SIDES) == "left" else -1


def printed_yaw_gain(geometry: WheelchairGeometry) -> tuple[float, float]:
    """Factors of the wheels' yaw rate with the public tool's signs and distance.

    With the same length across the axle on both wheels, abs(yaw rate) cos(camber), eqs 1.16 and
    1.18 with the tool's signs and the wheel-centre distance d_c give, for a yaw rate w in a left
    turn, w - (r_L + r_R) sin(camber) / d_c w, and the sum of the two in a right turn. With both
    signs changed the two factors change places.

    Parameters
    ----------
    geometry : WheelchairGeometry

    Returns
    -------
    (left, right) : floats, in a left and in a right turn; 1 would be right
    """
    expect("geometry", geometry, WheelchairGeometry)
    lean = sum(geometry.wheel_radius_m) * np.sin(geometry.camber_rad)
    loss = lean / geometry.wheel_centre_distance_m
    return float(1 - loss), float(1 + loss)
