"""Motion of a chair and the IMUs on its frame and wheels: rigid-body kinematics.

Nothing of the estimators is used: positions, rates and forces follow from the chair's speed and yaw
rate, and from its geometry.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import integrate
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import check_limits, expect
from mobility_imu.errors import InputError
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_number,
    as_rotation,
    as_vectors,
    check_positive,
    one_of,
)
from mobility_imu.recording import HIGHEST_RATE_HZ, Imu
from mobility_imu.results import Result
from mobility_imu.rotations import elementary_rotation
from mobility_imu.simulation.checks import LONGEST_S
from mobility_imu.simulation.profiles import least_jerk, least_jerk_bend, least_jerk_slope
from mobility_imu.simulation.seeds import stream
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry, side_sign

SIDES: tuple[Side, Side] = ("left", "right")


@dataclass(frozen=True)
class Leg:
    """An interval of a drive with one speed and one yaw rate.

    Parameters
    ----------
    task : task code 1-6 that is driven here (see ``mobility_imu.wheelchair.Task``)
    duration_s : s
    linear_velocity_mps : m/s, forward positive
    yaw_rate_degps : deg/s, left positive
    slope_deg : deg, the floor rises this much in the direction the chair faces; only
        ``simulate_court`` drives on slopes
    """

    task: int
    duration_s: float
    linear_velocity_mps: float = 0.0
    yaw_rate_degps: float = 0.0
    slope_deg: float = 0.0

    def __post_init__(self) -> None:
        """Check every number."""
        one_of("Leg.task", self.task, range(1, 7))
        check_positive(self, "duration_s")
        check_limits(self, {"duration_s": (0.0, LONGEST_S)})
        for name in ("linear_velocity_mps", "yaw_rate_degps", "slope_deg"):
            as_number(getattr(self, name), f"Leg.{name}", negative=True)
        if abs(self.slope_deg) > 45:
            raise InputError(f"Leg.slope_deg = {self.slope_deg:g}: expected up to 45 deg")


@dataclass(frozen=True, eq=False, repr=False)
class Mounting(Result):
    """How one IMU sits on its body.

    Parameters
    ----------
    rotation_body_to_imu : (3, 3) array
    position_m : (3,) array, m, in the body's frame (wheel: from its centre)
    """

    rotation_body_to_imu: FloatArray
    position_m: FloatArray

    def __post_init__(self) -> None:
        """Check both arrays."""
        rotation = as_rotation(self.rotation_body_to_imu, "rotation_body_to_imu")
        place = as_vectors(self.position_m, "position_m", ndim=1, finite=True)
        object.__setattr__(self, "rotation_body_to_imu", rotation)
        object.__setattr__(self, "position_m", place)
        super().__post_init__()


def random_mounting(seed: int) -> dict[str, Mounting]:
    """Mounting of the three IMUs with any orientation, at places as on a real chair.

    Parameters
    ----------
    seed : the same seed gives the same mounting

    Returns
    -------
    dict of Mounting by sensor: ``frame``, ``left_wheel``, ``right_wheel``
    """
    rng = stream(seed)
    places = {
        "frame": (0.10, 0.05, 0.40),
        "left_wheel": (0.04, 0.02, 0.03),
        "right_wheel": (-0.03, 0.05, 0.03),
    }
    return {
        name: Mounting(Rotation.random(rng=rng).as_matrix(), np.array(place))
        for name, place in places.items()
    }


SHORTEST_CHANGE_S = 1e-3
"""A shorter change of speed is a blow, no motion that can be sampled."""


def check_legs(legs: Sequence[Leg], transition_s: float) -> float:
    """Check that there are legs, and that each is long enough for a change.

    Parameters
    ----------
    legs : of Leg
    transition_s : s, length of a change

    Returns
    -------
    float, s, length of a change

    Raises
    ------
    InputError
        If there is no leg, a leg is shorter than a change, or the length of a change is no
        positive number of a millisecond or more.
    """
    transition_s = as_number(transition_s, "transition_s")
    if transition_s < SHORTEST_CHANGE_S:
        raise InputError(
            f"transition_s = {transition_s:g}: expected {SHORTEST_CHANGE_S:g} s or more"
        )
    if not isinstance(legs, Sequence):
        raise InputError(f"legs: got {type(legs).__name__}, expected a list of Leg")
    if not legs:
        raise InputError("legs: none, expected at least one Leg")
    for leg in legs:
        expect("legs", leg, Leg)
        if leg.duration_s < transition_s:
            raise InputError(
                f"leg of {leg.duration_s} s is shorter than a change of {transition_s} s"
            )
    return transition_s


def checked_rate(sampling_rate_hz: float) -> float:
    """Check that a sampling rate is one that a recording can have.

    Parameters
    ----------
    sampling_rate_hz : Hz

    Returns
    -------
    float, Hz

    Raises
    ------
    InputError
        If it is no positive number, or higher than that of any IMU.
    """
    rate = as_number(sampling_rate_hz, "sampling_rate_hz")
    if rate > HIGHEST_RATE_HZ:
        raise InputError(f"sampling_rate_hz = {rate:g}: expected up to {HIGHEST_RATE_HZ:g} Hz")
    return rate


MOST_SAMPLES = 4_000_000
"""Eleven hours at 100 Hz: a court of as many samples takes 10 GB."""


def samples_of(legs: Sequence[Leg], sampling_rate_hz: float) -> int:
    """Number of samples of a drive along legs.

    Parameters
    ----------
    legs : of Leg
    sampling_rate_hz : Hz

    Returns
    -------
    int, 2 or more

    Raises
    ------
    InputError
        If the drive is over before the second sample, or has more than MOST_SAMPLES.
    """
    duration_s = sum(leg.duration_s for leg in legs)
    count = round(duration_s * sampling_rate_hz)
    if count < 2:
        raise InputError(
            f"sampling_rate_hz = {sampling_rate_hz:g}: {count} sample(s) in the {duration_s:g} s "
            "of the legs, expected at least 2"
        )
    if count > MOST_SAMPLES:
        raise InputError(
            f"sampling_rate_hz = {sampling_rate_hz:g}: {count} samples in the {duration_s:g} s of "
            f"the legs, expected up to {MOST_SAMPLES}"
        )
    return count


def stepped(
    values: Sequence[float], ends: FloatArray, time_s: FloatArray, transition_s: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Levels with minimum-jerk changes centred on the ends, and its first two derivatives.

    Parameters
    ----------
    values : k levels
    ends : (k - 1,) array, s, where one level changes into the next
    time_s : (n,) array, s
    transition_s : s, length of a change

    Returns
    -------
    three (n,) arrays
    """
    level = np.full(len(time_s), float(values[0]))
    slope, bend = np.zeros(len(time_s)), np.zeros(len(time_s))
    for end, step in zip(ends, np.diff(values), strict=True):
        u = np.clip((time_s - end) / transition_s + 0.5, 0, 1)
        level += least_jerk(u, step)
        slope += least_jerk_slope(u, step) / transition_s
        bend += least_jerk_bend(u, step) / transition_s**2
    return level, slope, bend


class ChairMotion(NamedTuple):
    """The chair's motion in its own frame; the origin is midway between the contacts.

    Parameters
    ----------
    velocity, acceleration, yaw, yaw_change : (n,) arrays, along x and about z
    rate, rate_change : (n, 3) arrays, rad/s and rad/s²
    force : (n, 3) array, m/s², specific force at the origin
    """

    velocity: FloatArray
    acceleration: FloatArray
    yaw: FloatArray
    yaw_change: FloatArray
    rate: FloatArray
    rate_change: FloatArray
    force: FloatArray


def sloping(
    velocity: FloatArray,
    acceleration: FloatArray,
    yaw: FloatArray,
    yaw_change: FloatArray,
    pitch: tuple[FloatArray, FloatArray, FloatArray],
) -> ChairMotion:
    """Motion with the nose raised by a pitch (with its two derivatives), the axle level.

    Parameters
    ----------
    velocity, acceleration : (n,) arrays, m/s and m/s², along the chair's x
    yaw, yaw_change : (n,) arrays, rad/s and rad/s², about the chair's z
    pitch : three (n,) arrays, rad, rad/s, rad/s²

    Returns
    -------
    ChairMotion
    """
    angle, angle_change, angle_bend = pitch
    # Heading about the vertical, then pitch: the chair's x shares in the heading's rate.
    roll = yaw * np.tan(angle)
    roll_change = yaw_change * np.tan(angle) + yaw * angle_change / np.cos(angle) ** 2
    gravity = STANDARD_GRAVITY_MPS2
    return ChairMotion(
        velocity,
        acceleration,
        yaw,
        yaw_change,
        rate=np.column_stack([roll, -angle_change, yaw]),
        rate_change=np.column_stack([roll_change, -angle_bend, yaw_change]),
        force=np.column_stack(
            [
                acceleration + gravity * np.sin(angle),
                velocity * yaw,
                velocity * angle_change + gravity * np.cos(angle),
            ]
        ),
    )


def check_mounting(mounting: Mapping[str, Mounting]) -> None:
    """Check that each of the three IMUs has its mounting.

    Parameters
    ----------
    mounting : sensor to Mounting

    Raises
    ------
    InputError
        If one is missing or is no Mounting.
    """
    expect("mounting", mounting, Mapping)
    for name in ("frame", *(f"{side}_wheel" for side in SIDES)):
        if name not in mounting:
            raise InputError(f"mounting: {name!r} is missing, expected a Mounting for it")
        expect(f"mounting[{name!r}]", mounting[name], Mounting)


def frame_imu(motion: ChairMotion, mounting: Mounting) -> Imu:
    """Ideal readings of the IMU on the frame.

    Parameters
    ----------
    motion : ChairMotion
    mounting : Mounting

    Returns
    -------
    Imu
    """
    place = np.broadcast_to(mounting.position_m, motion.rate.shape)
    still = np.zeros_like(place)
    turn = mounting.rotation_body_to_imu.T
    return Imu(_specific_force(motion, place, still, still) @ turn, motion.rate @ turn)


def wheel_imu(
    time_s: FloatArray,
    motion: ChairMotion,
    geometry: WheelchairGeometry,
    side: Side,
    mounting: Mounting,
    *,
    toe_rad: float = 0.0,
    slip_mps: FloatArray | float = 0.0,
    slip_change_mps2: FloatArray | float = 0.0,
) -> Imu:
    """Ideal readings of the IMU on a wheel.

    Parameters
    ----------
    time_s : (n,) array, s
    motion : ChairMotion
    geometry : WheelchairGeometry
    side : "left" or "right"
    mounting : Mounting
    toe_rad : rad, the wheel's front points inward by this
    slip_mps, slip_change_mps2 : (n,) arrays, m/s and m/s², the rim's speed beyond rolling

    Returns
    -------
    Imu
    """
    sign = side_sign(side)
    contact = np.array([0.0, sign * geometry.track_m / 2, 0.0])
    radius = getattr(geometry.wheel_radius_m, side)
    # The contact travels as the chair does at its lateral place; a wheel that toes in rolls as
    # far as the travel goes along its plane, and scrubs sideways. Slip comes on top.
    along = np.cos(toe_rad)
    travel = motion.velocity - motion.yaw * contact[1]
    travel_change = motion.acceleration - motion.yaw_change * contact[1]
    spin = (travel * along + slip_mps) / radius
    spin_change = (travel_change * along + slip_change_mps2) / radius
    angle = integrate.cumulative_trapezoid(spin, time_s, initial=0)
    toed = elementary_rotation("z", -sign * toe_rad)
    axle = toed @ geometry.axle_direction(side)
    ahead = toed @ np.array([1.0, 0.0, 0.0])
    centre = contact + toed @ (geometry.wheel_centre(side) - contact)
    base = np.column_stack([ahead, np.cross(axle, ahead), axle])  # wheel to chair at angle 0
    turned = base @ elementary_rotation("z", angle)
    arm = turned @ mounting.position_m
    swing = spin[:, None] * np.cross(axle, arm)
    swing_change = spin_change[:, None] * np.cross(axle, arm) + spin[:, None] * np.cross(
        axle, swing
    )
    acc = _specific_force(motion, centre + arm, swing, swing_change)
    rate = spin[:, None] * axle + motion.rate
    to_imu = mounting.rotation_body_to_imu @ np.swapaxes(turned, 1, 2)
    return Imu(np.einsum("nij,nj->ni", to_imu, acc), np.einsum("nij,nj->ni", to_imu, rate))


def _specific_force(
    motion: ChairMotion, place: FloatArray, drift: FloatArray, drift_change: FloatArray
) -> FloatArray:
    """Specific force at a place that moves in the chair's frame; chair components, (n, 3)."""
    around = np.cross(motion.rate, place)
    carried = np.cross(motion.rate_change, place) + np.cross(motion.rate, around)
    coriolis = 2 * np.cross(motion.rate, drift)
    return np.asarray(carried + coriolis + drift_change + motion.force)
