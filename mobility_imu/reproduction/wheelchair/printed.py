"""The document's equations (1.5) to (1.18) as printed, in the axes of its Figure 1.

Figure 1 draws one wheel, with the axle's z pointing outward, away from the chair, and the IMU's z
nearly along it. Both wheels are taken to be like that. Rolling forward then turns the left wheel
positively and the right wheel negatively about its z. The estimators of this package take both
axles positive forward instead; here the print is kept to the letter, so that it can be judged.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.wheelchair.calibration import alignment_matrix, realign, wheel_alignment_angles
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelchairGeometry, side_sign

# Slower than this a wheel's rate is mostly noise: it does not show the axle.
SMALLEST_ROLLING_RATE_RADPS = 1.0


def printed_matrix(about_y_rad: float, about_x_rad: float) -> FloatArray:
    """Alignment matrix written out, as printed (eqs 1.5 and 1.11).

    Parameters
    ----------
    about_y_rad, about_x_rad : gamma and epsilon, or sigma and delta, rad

    Returns
    -------
    (3, 3) array
    """
    c, s = np.cos(about_y_rad), np.sin(about_y_rad)
    ce, se = np.cos(about_x_rad), np.sin(about_x_rad)
    return np.array([[c, s * se, s * ce], [0, ce, -se], [-s, c * se, c * ce]])


def printed_product(about_y_rad: float, about_x_rad: float) -> FloatArray:
    """Product of the two elementary rotations as printed (eqs 1.3 and 1.4), (3, 3)."""
    c, s = np.cos(about_y_rad), np.sin(about_y_rad)
    ce, se = np.cos(about_x_rad), np.sin(about_x_rad)
    about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return np.asarray(about_y @ np.array([[1, 0, 0], [0, ce, -se], [0, se, ce]]))


def printed_angles(vector_imu: ArrayLike) -> tuple[float, float]:
    """Two angles by inverse tangents, as printed (eqs 1.8 and 1.9, 1.14 and 1.15).

    Parameters
    ----------
    vector_imu : (3,) array, angular rate of a wheel or acceleration of the frame, IMU axes

    Returns
    -------
    about_y, about_x : rad
    """
    x, y, z = np.asarray(vector_imu, float)
    about_y = float(np.arctan(x / z))
    return about_y, float(np.arctan(-y * np.cos(about_y) / z))


def outward_axle(geometry: WheelchairGeometry, side: Side) -> FloatArray:
    """Z of a wheel in Figure 1, chair frame (x forward, y left, z up), (3,) unit array."""
    return side_sign(side) * geometry.axle_direction(side)


def velocity_printed(
    rate_left_radps: ArrayLike, rate_right_radps: ArrayLike, geometry: WheelchairGeometry
) -> FloatArray:
    """Chair's velocity, left wheel minus right wheel, as printed (eq. 1.17).

    Parameters
    ----------
    rate_left_radps, rate_right_radps : (n,) array, rad/s, about each wheel's z
    geometry : WheelchairGeometry

    Returns
    -------
    (n,) array, m/s
    """
    radius = geometry.wheel_radius_m
    return (
        np.asarray(rate_left_radps, float) * radius.left
        - np.asarray(rate_right_radps, float) * radius.right
    ) / 2


def yaw_rate_printed(
    rate_left_radps: ArrayLike,
    rate_right_radps: ArrayLike,
    geometry: WheelchairGeometry,
    *,
    distance_m: float,
) -> FloatArray:
    """Chair's yaw rate, sum of both wheels over a distance, as printed (eq. 1.18).

    Parameters
    ----------
    rate_left_radps, rate_right_radps : (n,) array, rad/s, about each wheel's z
    geometry : WheelchairGeometry
    distance_m : m, d of the equation

    Returns
    -------
    (n,) array, rad/s
    """
    radius = geometry.wheel_radius_m
    return (
        np.asarray(rate_left_radps, float) * radius.left
        + np.asarray(rate_right_radps, float) * radius.right
    ) / distance_m


@dataclass(frozen=True, eq=False, repr=False)
class WheelRates(Result):
    """Gyroscope of both wheels in wheel axes.

    Parameters
    ----------
    left, right : (n, 3) arrays, rad/s; z is the axle
    """

    left: FloatArray
    right: FloatArray


def wheel_rates_printed(straight: Recording, trial: Recording) -> WheelRates:
    """Gyroscope of each wheel in wheel axes by the printed equations (1.1 and 1.6 to 1.9).

    Parameters
    ----------
    straight : the chair pushed straight forward
    trial : Recording to re-express

    Returns
    -------
    WheelRates
    """
    rates = []
    for side in SIDES:
        pushed = straight.gyroscope(f"{side}_wheel")
        rolling = pushed[np.linalg.norm(pushed, axis=1) > SMALLEST_ROLLING_RATE_RADPS]
        angles = wheel_alignment_angles(rolling.mean(axis=0), form="printed")
        measured = trial.gyroscope(f"{side}_wheel")
        rates.append(realign(measured, alignment_matrix(*angles)))
    return WheelRates(*rates)


class SignChoice(NamedTuple):
    """One fixed reading of (1.16) to (1.18), and what it gives at a yaw rate of 1 rad/s.

    Parameters
    ----------
    sign_left, sign_right : +1 or -1 for the root in (1.16), axes of Figure 1
    distance : "centres" or "contacts", d in (1.18)
    yaw_left, yaw_right : size of the yaw rate found over the true one, in a left and a right turn
    velocity_left, velocity_right : error of (1.17) in m/s, in the same turns
    """

    sign_left: int
    sign_right: int
    distance: str
    yaw_left: float
    yaw_right: float
    velocity_left: float
    velocity_right: float


def sign_choices(geometry: WheelchairGeometry) -> list[SignChoice]:
    """Four fixed choices of the two signs in (1.16), with either distance in (1.18).

    Parameters
    ----------
    geometry : WheelchairGeometry

    Returns
    -------
    list of eight SignChoice
    """
    distances = {"centres": geometry.wheel_centre_distance_m, "contacts": geometry.track_m}
    found = []
    for left, right, (name, distance) in product((1, -1), (1, -1), distances.items()):
        yaw, velocity = [], []
        for yaw_rate in (1.0, -1.0):
            spin_left, spin_right = (
                spin_printed(gyroscope_outward(0.0, yaw_rate, geometry, side), geometry, sign)
                for side, sign in zip(SIDES, (left, right), strict=True)
            )
            turned = yaw_rate_printed(spin_left, spin_right, geometry, distance_m=distance)
            yaw.append(abs(float(turned)))
            velocity.append(float(velocity_printed(spin_left, spin_right, geometry)))
        found.append(SignChoice(left, right, name, *yaw, *velocity))
    return found


def gyroscope_outward(
    velocity_mps: float, yaw_rate_radps: float, geometry: WheelchairGeometry, side: Side
) -> tuple[float, float]:
    """Gyroscope of a rolling wheel in the axes of Figure 1, from rigid-body kinematics.

    Parameters
    ----------
    velocity_mps : m/s, forward positive
    yaw_rate_radps : rad/s, left positive
    geometry : WheelchairGeometry
    side : "left" or "right"

    Returns
    -------
    along, across : rad/s, along the outward axle, and the length across it
    """
    s = side_sign(side)
    rim = velocity_mps - s * yaw_rate_radps * geometry.track_m / 2
    spin = rim / geometry.wheel_radius_m.of(side)
    rate = spin * geometry.axle_direction(side) + np.array([0.0, 0.0, yaw_rate_radps])
    axle = outward_axle(geometry, side)
    along = float(rate @ axle)
    return along, float(np.linalg.norm(rate - along * axle))


def spin_printed(gyroscope: tuple[float, float], geometry: WheelchairGeometry, sign: int) -> float:
    """Wheel's spin with one sign for the root, as printed (eq. 1.16).

    Parameters
    ----------
    gyroscope : rad/s along and across the axle
    geometry : WheelchairGeometry
    sign : +1 or -1

    Returns
    -------
    float, rad/s
    """
    along, across = gyroscope
    return along + sign * across * float(np.tan(geometry.camber_rad))
