"""Wheel spin, chair velocity and yaw rate (sections 1.2 and 1.3).

For a wheel that leans by the camber, the gyroscope along the axle reads the spin plus the share
s * yaw_rate * sin(camber) of the chair's yaw rate (s = +1 left, -1 right). Two exact pairs follow:
the uncorrected rate with the distance between wheel centres, and the spin with the track.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_series, as_vectors
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.calibration import WheelchairCalibration
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry, side_sign

if TYPE_CHECKING:
    import pandas as pd

Camber = Literal["sign-safe", "printed"]


def wheel_spin_rate(
    gyr_axle_radps: ArrayLike, yaw_rate_radps: ArrayLike, camber_rad: float, *, side: Side
) -> FloatArray:
    """Spin of one wheel about its own axle (eq. 1.16, sign-safe form).

    The printed square root loses the direction of the turn; the frame's yaw rate keeps it.

    Parameters
    ----------
    gyr_axle_radps : (n,) array, rad/s, wheel gyroscope along the axle, positive rolling forward
    yaw_rate_radps : (n,) array, rad/s, chair's yaw rate, positive to the left
    camber_rad : float, rad, positive with the wheels' tops leaning in
    side : "left" or "right"

    Returns
    -------
    (n,) array, rad/s

    Examples
    --------
    Turning on the spot to the left, the wheels' centres 0.6335 m apart:

    >>> gyr = -1.0 * 0.6335 / 2 / 0.317
    >>> wheel_spin_rate([gyr], [1.0], np.deg2rad(19), side="left").round(3).tolist()
    [-1.325]
    """
    lean = side_sign(side) * np.sin(camber_rad)
    return np.asarray(gyr_axle_radps, float) - np.asarray(yaw_rate_radps, float) * lean


def wheel_spin_rate_printed(
    gyr_wheel_radps: ArrayLike, camber_rad: float, *, side: Side
) -> FloatArray:
    """Spin of one wheel as printed (eq. 1.16), with the signs that the public tool gives it.

    It adds (left) or takes away (right) the rate across the axle times tan(camber). That rate is
    a length, never negative, so that a fixed sign is right in turns to one side only: with this
    choice, in right turns. The wheels' yaw rate is wrong by the factors of
    :func:`printed_yaw_gain`.

    Parameters
    ----------
    gyr_wheel_radps : (n, 3) array, rad/s, wheel frame: z is the axle, positive rolling forward
    camber_rad : float, rad
    side : "left" or "right"

    Returns
    -------
    (n,) array, rad/s
    """
    gyr = as_vectors(gyr_wheel_radps, "gyr_wheel_radps")
    across = np.hypot(gyr[:, 0], gyr[:, 1])
    return gyr[:, 2] + side_sign(side) * across * np.tan(camber_rad)


def linear_velocity(
    rate_left_radps: ArrayLike, rate_right_radps: ArrayLike, geometry: WheelchairGeometry
) -> FloatArray:
    """Chair's forward velocity from both wheels (eq. 1.17, forward spin positive on both sides).

    The print subtracts the right wheel: in its Figure 1 the wheels' axes point outward, and the
    right wheel then turns negatively. Here forward is positive on both sides, so they are added.

    Parameters
    ----------
    rate_left_radps, rate_right_radps : (n,) array, rad/s. Spin rates give the velocity midway
        between the wheels' contacts, uncorrected rates that midway between their centres; for
        equal radii these are the same.
    geometry : WheelchairGeometry

    Returns
    -------
    (n,) array, m/s
    """
    left, right = _rolling_speeds(rate_left_radps, rate_right_radps, geometry)
    return (left + right) / 2


def wheel_yaw_rate(
    rate_left_radps: ArrayLike,
    rate_right_radps: ArrayLike,
    geometry: WheelchairGeometry,
    *,
    distance_m: float,
) -> FloatArray:
    """Chair's yaw rate from both wheels (eq. 1.18, left turn positive).

    The print adds the wheels. With the outward axes of its Figure 1 that is positive in turns to
    the right, against the arrow in the figure.

    Parameters
    ----------
    rate_left_radps, rate_right_radps : (n,) array, rad/s
    geometry : WheelchairGeometry
    distance_m : float, m: ``geometry.track_m`` with spin rates, or
        ``geometry.wheel_centre_distance_m`` with uncorrected rates; other pairs are wrong

    Returns
    -------
    (n,) array, rad/s
    """
    left, right = _rolling_speeds(rate_left_radps, rate_right_radps, geometry)
    return (right - left) / distance_m


def _rolling_speeds(
    rate_left: ArrayLike, rate_right: ArrayLike, geometry: WheelchairGeometry
) -> tuple[FloatArray, FloatArray]:
    radius = geometry.wheel_radius_m
    return radius.left * np.asarray(rate_left, float), radius.right * np.asarray(rate_right, float)


def single_wheel_velocity(
    rate_axle_radps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    geometry: WheelchairGeometry,
    *,
    side: Side,
) -> FloatArray:
    """Chair's velocity from one wheel and the frame, when the other sensor is missing.

    The wheel's centre moves at radius times the uncorrected rate; the yaw rate takes it to the
    middle. Slip of that wheel cannot be seen any more.

    Parameters
    ----------
    rate_axle_radps : (n,) array, rad/s, wheel gyroscope along the axle, forward positive
    yaw_rate_radps : (n,) array, rad/s, frame gyroscope, left positive
    geometry : WheelchairGeometry
    side : of the wheel that has a sensor

    Returns
    -------
    (n,) array, m/s, midway between the wheels' contacts
    """
    radius = getattr(geometry.wheel_radius_m, side)
    centre = geometry.wheel_centre(side)[1]
    rolling = radius * np.asarray(rate_axle_radps, float)
    return rolling + centre * np.asarray(yaw_rate_radps, float)


def velocity_standard_deviation(
    rate_left_radps: ArrayLike,
    rate_right_radps: ArrayLike,
    geometry: WheelchairGeometry,
    *,
    gyr_sd_radps: float,
    radius_sd_m: float,
) -> FloatArray:
    """Standard deviation of the linear velocity (eq. 1.17, first order).

    Noise of both gyroscopes and errors of both radii, all independent. A radius error is one
    draw for the whole recording, so it does not average out. Camber and track do not enter.

    Parameters
    ----------
    rate_left_radps, rate_right_radps : (n,) arrays, rad/s
    geometry : WheelchairGeometry
    gyr_sd_radps : rad/s, of each sample
    radius_sd_m : m, of each radius

    Returns
    -------
    (n,) array, m/s
    """
    radius = geometry.wheel_radius_m
    left, right = np.asarray(rate_left_radps, float), np.asarray(rate_right_radps, float)
    noise = gyr_sd_radps**2 * (radius.left**2 + radius.right**2)
    return np.sqrt(noise + radius_sd_m**2 * (left**2 + right**2)) / 2


def wheel_yaw_standard_deviation(
    yaw_rate_radps: ArrayLike,
    linear_velocity_mps: ArrayLike,
    geometry: WheelchairGeometry,
    *,
    gyr_sd_radps: float,
    radius_sd_m: float,
    distance_sd_m: float,
) -> FloatArray:
    """Standard deviation of the wheels' yaw rate with the wheel-centre distance (eq. 1.18).

    Radius errors weigh most: they scale each wheel's speed and meet in the difference. The
    frame's yaw rate has its gyroscope's noise and nothing else.

    Parameters
    ----------
    yaw_rate_radps, linear_velocity_mps : (n,) arrays, rad/s and m/s
    geometry : WheelchairGeometry
    gyr_sd_radps, radius_sd_m, distance_sd_m : as above, and of the distance of the wheel centres

    Returns
    -------
    (n,) array, rad/s
    """
    yaw, speed = np.asarray(yaw_rate_radps, float), np.asarray(linear_velocity_mps, float)
    radius, distance = geometry.wheel_radius_m, geometry.wheel_centre_distance_m
    left, right = speed - yaw * distance / 2, speed + yaw * distance / 2
    noise = gyr_sd_radps**2 * (radius.left**2 + radius.right**2)
    sizes = radius_sd_m**2 * ((left / radius.left) ** 2 + (right / radius.right) ** 2)
    return np.sqrt(noise + sizes + (yaw * distance_sd_m) ** 2) / distance


def printed_yaw_gain(geometry: WheelchairGeometry) -> tuple[float, float]:
    """Factors of the wheels' yaw rate with the public tool's signs and distance.

    With the same length across the axle on both wheels, abs(yaw rate) cos(camber), eqs 1.16 and
    1.18 with the tool's signs and the wheel-centre distance d_c give, for a yaw rate w in a left
    turn, w - (r_L + r_R) sin(camber) / d_c w, and the sum of the two in a right turn. With both
    signs changed the two factors change places.

    Returns
    -------
    (left, right) : floats, in a left and in a right turn; 1 would be right
    """
    lean = sum(geometry.wheel_radius_m) * np.sin(geometry.camber_rad)
    loss = lean / geometry.wheel_centre_distance_m
    return float(1 - loss), float(1 + loss)


@dataclass(frozen=True)
class ChairVelocity:
    """Velocities of the chair on the recording's clock.

    Parameters
    ----------
    time_s : (n,) array, s
    linear_velocity_mps : (n,) array, m/s, forward positive
    yaw_rate_radps : (n,) array, rad/s, from the frame's gyroscope, left positive
    wheel_yaw_rate_radps : (n,) array, rad/s, the same from the wheels: they differ when one slips
    slip : (n,) bool array, True where the two yaw rates differ too much and for too long
    """

    time_s: FloatArray
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    wheel_yaw_rate_radps: FloatArray
    slip: np.ndarray

    def to_frame(self) -> pd.DataFrame:
        """Give the columns of the velocity CSV, yaw rate in deg/s."""
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.time_s,
                "linear_velocity_mps": self.linear_velocity_mps,
                "yaw_rate_degps": np.rad2deg(self.yaw_rate_radps),
                "slip": self.slip.astype(int),
            }
        )


def estimate_velocity(
    trial: Recording,
    calibration: WheelchairCalibration,
    geometry: WheelchairGeometry,
    *,
    camber: Camber = "sign-safe",
    slip_correction: bool = False,
) -> ChairVelocity:
    """Chair velocity and yaw rate of one trial (eqs 1.16-1.18).

    Parameters
    ----------
    trial : Recording with sensors frame, left_wheel, right_wheel. One wheel may be missing: the
        other and the frame then give the speed, with a warning, and slip cannot be seen
    calibration : from :func:`~mobility_imu.wheelchair.calibration.calibrate`
    geometry : WheelchairGeometry
    camber : "sign-safe" takes the yaw rate's part out of each wheel with its sign; "printed"
        uses the root of (1.16) with the fixed signs that the public tool gives it
    slip_correction : where the wheels disagree, take the speed from the wheel that still rolls
        (:func:`~mobility_imu.wheelchair.slip.correct_slip`); with the printed camber term, which
        tells no wheel from the other, integrate the frame's acceleration as the tool does

    Returns
    -------
    ChairVelocity

    Raises
    ------
    InputError
        If a sensor or a gyroscope is missing, the wheels turn against the frame (left and right
        swapped), or ``camber`` is neither of the two.
    """
    from mobility_imu.wheelchair.slip import correct_slip, detect_slip, wheel_speeds

    if camber not in ("sign-safe", "printed"):
        raise InputError(f"camber = {camber!r}: expected 'sign-safe' or 'printed'")
    frame = trial.sensor("frame", gyroscope=True)
    yaw_rate = np.asarray(frame.gyr_radps) @ calibration.rotation_frame_imu_to_chair[2]

    def spin(side: Side) -> FloatArray:
        gyr_imu = np.asarray(trial.sensor(f"{side}_wheel", gyroscope=True).gyr_radps)
        gyr = gyr_imu @ calibration.rotation_imu_to_wheel(side).T
        if camber == "printed":
            return wheel_spin_rate_printed(gyr, geometry.camber_rad, side=side)
        return wheel_spin_rate(gyr[:, 2], yaw_rate, geometry.camber_rad, side=side)

    sides: tuple[Side, Side] = ("left", "right")
    present = [side for side in sides if f"{side}_wheel" in trial.sensors]
    if len(present) == 1:
        return _one_wheel(trial, calibration, geometry, yaw_rate, present[0], camber)
    left, right = spin("left"), spin("right")
    # The printed document pairs its spin with the wheel-centre distance.
    distance = geometry.track_m if camber == "sign-safe" else geometry.wheel_centre_distance_m
    velocity = linear_velocity(left, right, geometry)
    wheel_yaw = wheel_yaw_rate(left, right, geometry, distance_m=distance)
    _refuse_swapped_wheels(trial, yaw_rate, wheel_yaw)
    windows = detect_slip(yaw_rate, wheel_yaw, trial.sampling_rate_hz)
    if slip_correction:
        forward = frame.acc_mps2 @ calibration.rotation_frame_imu_to_chair[0]
        velocity = correct_slip(
            velocity,
            forward,
            windows,
            trial.sampling_rate_hz,
            wheels=wheel_speeds(velocity, wheel_yaw, yaw_rate, geometry),
            method="wheels" if camber == "sign-safe" else "tool",
        )
    return ChairVelocity(
        time_s=trial.time_s,
        linear_velocity_mps=as_series(velocity, "linear velocity"),
        yaw_rate_radps=yaw_rate,
        wheel_yaw_rate_radps=wheel_yaw,
        slip=windows.flags(len(trial)),
    )


def _one_wheel(
    trial: Recording,
    calibration: WheelchairCalibration,
    geometry: WheelchairGeometry,
    yaw_rate: FloatArray,
    side: Side,
    camber: Camber,
) -> ChairVelocity:
    if camber == "printed":
        raise InputError(f"{trial.source}: eq. 1.16 as printed needs both wheels, found the {side}")
    warnings.warn(
        f"{trial.source}: only the {side} wheel has a sensor; speed from it and the frame, slip "
        "cannot be seen",
        stacklevel=3,
    )
    gyr = np.asarray(trial.sensor(f"{side}_wheel", gyroscope=True).gyr_radps)
    axle = gyr @ calibration.rotation_imu_to_wheel(side)[2]
    velocity = single_wheel_velocity(axle, yaw_rate, geometry, side=side)
    return ChairVelocity(
        time_s=trial.time_s,
        linear_velocity_mps=as_series(velocity, f"{trial.source}: linear velocity"),
        yaw_rate_radps=yaw_rate,
        wheel_yaw_rate_radps=np.full(len(trial), np.nan),
        slip=np.zeros(len(trial), bool),
    )


def _refuse_swapped_wheels(trial: Recording, yaw_rate: FloatArray, wheel_yaw: FloatArray) -> None:
    """In a second of turning, wheels that were swapped turn the other way."""
    turning = np.abs(yaw_rate) > 0.3
    if turning.sum() < trial.sampling_rate_hz:
        return
    gain = float(yaw_rate[turning] @ wheel_yaw[turning] / (yaw_rate[turning] @ yaw_rate[turning]))
    if gain < -0.3:
        raise InputError(
            f"{trial.source}: the wheels' yaw rate is {gain:.2f} times the frame's, expected about "
            "1: left and right wheel are swapped, or the frame's sensor is upside down"
        )
