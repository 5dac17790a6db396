"""From the scooter's body to its throttle lever: four rotations (Suzurikawa et al. 2022).

Frames, each x right, y forward, z up when the controls are at rest on level ground:

* {B} body. {N} steering column: {B} leaned back by alpha, so that z runs along the shaft.
* {S} steering wheel: {N} turned about the shaft by the steering angle, positive to the left.
* {W} lever base: turns with the wheel, leaned back by beta against the body when straight.
* {T} throttle lever, and the IMU on it: {W} tipped forward by the throttle angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.files import write_text
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_floats,
    as_number,
    as_vectors,
    check_together,
)
from mobility_imu.readers.geometry import read_section
from mobility_imu.rotations import elementary_rotation

__all__ = [
    "SUZUKI_ET4D",
    "ScooterGeometry",
    "body_specific_force",
    "lever_acceleration",
    "rotation_lever_base_to_steering",
    "rotation_lever_to_body",
    "rotation_lever_to_lever_base",
    "rotation_steering_column_to_body",
    "rotation_steering_to_column",
]

# Along a vertical shaft gravity does not change with steering. At 2 deg a tilt of the lever IMU
# of 1 deg already looks like 30 deg of steering.
SMALLEST_STEERING_INCLINATION_RAD = float(np.deg2rad(2.0))
LARGEST_STEERING_INCLINATION_RAD = float(np.deg2rad(88.0))


@dataclass(frozen=True)
class ScooterGeometry:
    """What has to be measured on the scooter.

    Parameters
    ----------
    steering_inclination_rad : float, rad, alpha: how far the steering shaft leans back from the
        body's vertical, between 2 and 88 deg
    lever_inclination_rad : float, rad, beta: how far the lever IMU's y axis points up from the
        body's forward axis with steering and throttle at rest, between -90 and 90 deg

    Raises
    ------
    InputError
        If a value is impossible; the message says which and guesses at a wrong unit.

    Examples
    --------
    >>> ScooterGeometry.from_degrees(20, 9) == SUZUKI_ET4D
    True
    """

    steering_inclination_rad: float
    lever_inclination_rad: float

    def __post_init__(self) -> None:
        """Check that both angles are possible, and that gravity can show the steering."""
        for name in ("steering_inclination_rad", "lever_inclination_rad"):
            object.__setattr__(self, name, as_number(getattr(self, name), name, negative=True))
        alpha = self.steering_inclination_rad
        low, high = SMALLEST_STEERING_INCLINATION_RAD, LARGEST_STEERING_INCLINATION_RAD
        if not low < alpha < high:
            hint = ""
            if 2 < alpha < 88:
                hint = " (is it in degrees?)"
            elif 0 <= alpha <= low:
                hint = (
                    " (gravity hardly sees steering about a shaft so near the vertical; "
                    "or was it converted to radians twice?)"
                )
            raise InputError(
                f"steering_inclination_rad = {alpha:g}: expected between {low:.3f} and "
                f"{high:.3f} rad (2 to 88 deg){hint}"
            )
        beta = self.lever_inclination_rad
        if not abs(beta) < np.pi / 2:
            hint = " (is it in degrees?)" if abs(beta) < 90 else ""
            raise InputError(
                f"lever_inclination_rad = {beta:g}: expected between -1.571 and 1.571 rad "
                f"(-90 to 90 deg){hint}"
            )

    @property
    def lean_rad(self) -> float:
        """Angle of the lever's IMU to the shaft with the throttle at rest; alpha less beta, rad."""
        return self.steering_inclination_rad - self.lever_inclination_rad

    @classmethod
    def from_degrees(
        cls, steering_inclination_deg: float, lever_inclination_deg: float
    ) -> ScooterGeometry:
        """Geometry from alpha and beta in degrees.

        Parameters
        ----------
        steering_inclination_deg : float, deg, alpha
        lever_inclination_deg : float, deg, beta

        Returns
        -------
        ScooterGeometry

        Raises
        ------
        InputError
            If a value is impossible.
        """
        alpha = as_number(steering_inclination_deg, "steering_inclination_deg", negative=True)
        beta = as_number(lever_inclination_deg, "lever_inclination_deg", negative=True)
        if not 2 < alpha < 88:
            hint = ""
            if 0 <= alpha <= 2:
                hint = (
                    " (gravity hardly sees steering about a shaft so near the vertical; "
                    "or is it in radians?)"
                )
            raise InputError(
                f"steering_inclination_deg = {alpha:g}: expected between 2 and 88 deg{hint}"
            )
        if not abs(beta) < 90:
            raise InputError(f"lever_inclination_deg = {beta:g}: expected between -90 and 90 deg")
        return cls(float(np.deg2rad(alpha)), float(np.deg2rad(beta)))

    @classmethod
    def from_toml(cls, path: str | Path) -> ScooterGeometry:
        """Read section [scooter] of a geometry file.

        Parameters
        ----------
        path : TOML file with ``steering_inclination_deg`` and ``lever_inclination_deg``

        Raises
        ------
        InputError
            If the file, the section or a key is missing, or a value is impossible.
        """
        keys = ("steering_inclination_deg", "lever_inclination_deg")
        values = read_section(path, "scooter", keys)
        try:
            return cls.from_degrees(*(values[key] for key in keys))
        except InputError as error:
            raise InputError(f"{path}, [scooter]: {error}") from None

    def to_toml(self, path: str | Path | None = None) -> str:
        """Text of a section [scooter].

        Parameters
        ----------
        path : file to write the text to, too; an existing one is replaced

        Returns
        -------
        str
        """
        text = (
            "[scooter]\n"
            f"steering_inclination_deg = {_in_degrees(self.steering_inclination_rad)}\n"
            f"lever_inclination_deg = {_in_degrees(self.lever_inclination_rad)}\n"
        )
        if path is not None:
            write_text(path, text)
        return text


def _in_degrees(angle_rad: float) -> str:
    """Degrees that give the same radians again, to the last bit if any number of degrees does.

    As few digits as possible: 20 deg, not 20.000000000000004.
    """
    exact = float(np.rad2deg(angle_rad))
    near = [float(f"{exact:.{digits}g}") for digits in (6, 9, 12, 15, 16)]
    near += [exact, *np.nextafter(exact, [-360.0, 360.0]).tolist()]
    chosen = next((deg for deg in near if float(np.deg2rad(deg)) == angle_rad), exact)
    return np.format_float_positional(chosen, trim="-")


SUZUKI_ET4D = ScooterGeometry.from_degrees(20, 9)
"""The scooter of the paper (section 2.2), with alpha 20 deg and beta 9 deg."""


def rotation_steering_column_to_body(steering_inclination_rad: ArrayLike) -> FloatArray:
    """Turn components in the steering column {N} into the body {B} (eq. 1).

    Parameters
    ----------
    steering_inclination_rad : (...) array, rad, alpha, positive with the shaft leaning back

    Returns
    -------
    (..., 3, 3) array
    """
    alpha = as_floats(steering_inclination_rad, "steering_inclination_rad")
    return elementary_rotation("x", alpha)


def rotation_steering_to_column(steering_rad: ArrayLike) -> FloatArray:
    """Turn components in the steering wheel {S} into the column {N} (eq. 2).

    Parameters
    ----------
    steering_rad : (...) array, rad, positive to the left

    Returns
    -------
    (..., 3, 3) array
    """
    return elementary_rotation("z", as_floats(steering_rad, "steering_rad"))


def rotation_lever_base_to_steering(
    steering_inclination_rad: ArrayLike, lever_inclination_rad: ArrayLike
) -> FloatArray:
    """Turn components in the lever base {W} into the steering wheel {S} (eq. 3).

    Parameters
    ----------
    steering_inclination_rad, lever_inclination_rad : (...) arrays, rad, alpha and beta

    Returns
    -------
    (..., 3, 3) array
    """
    alpha = as_floats(steering_inclination_rad, "steering_inclination_rad")
    beta = as_floats(lever_inclination_rad, "lever_inclination_rad")
    check_together(steering_inclination_rad=alpha.shape, lever_inclination_rad=beta.shape)
    return elementary_rotation("x", -(alpha - beta))


def rotation_lever_to_lever_base(throttle_rad: ArrayLike) -> FloatArray:
    """Turn components in the lever {T} into the lever base {W} (eq. 4).

    Parameters
    ----------
    throttle_rad : (...) array, rad, positive with the lever pushed (its z axis tips forward)

    Returns
    -------
    (..., 3, 3) array
    """
    return elementary_rotation("x", -as_floats(throttle_rad, "throttle_rad"))


def rotation_lever_to_body(
    steering_rad: ArrayLike, throttle_rad: ArrayLike, geometry: ScooterGeometry
) -> FloatArray:
    """Turn components in the lever {T} into the body {B}: the product in eq. 5.

    Parameters
    ----------
    steering_rad, throttle_rad : (...) arrays, rad, that broadcast together
    geometry : ScooterGeometry

    Returns
    -------
    (..., 3, 3) array
    """
    expect("geometry", geometry, ScooterGeometry)
    steering_rad = as_floats(steering_rad, "steering_rad")
    throttle_rad = as_floats(throttle_rad, "throttle_rad")
    check_together(steering_rad=steering_rad.shape, throttle_rad=throttle_rad.shape)
    alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
    return (
        rotation_steering_column_to_body(alpha)
        @ rotation_steering_to_column(steering_rad)
        @ rotation_lever_base_to_steering(alpha, beta)
        @ rotation_lever_to_lever_base(throttle_rad)
    )


def lever_acceleration(
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Specific force that the lever IMU reads: eq. 5, from the body to the lever.

    Both IMUs are taken to feel the same specific force. That holds at rest; on the move the
    lever's own acceleration and the distance between the IMUs come on top.

    Parameters
    ----------
    body_acc_mps2 : (..., 3) array, m/s², in {B}
    steering_rad : (...) array, rad, positive to the left
    throttle_rad : (...) array, rad, positive with the lever pushed
    geometry : ScooterGeometry

    Returns
    -------
    (..., 3) array, m/s², in {T}; the leading axes broadcast together

    Raises
    ------
    InputError
        If the body's vectors do not have three components, or the arrays do not broadcast together.

    Examples
    --------
    >>> level = body_specific_force(0.0, 0.0)
    >>> lever_acceleration(level, 0.0, 0.0, SUZUKI_ET4D).round(3).tolist()
    [0.0, 1.534, 9.686]
    """
    body = as_vectors(body_acc_mps2, "body_acc_mps2")
    rotation = rotation_lever_to_body(steering_rad, throttle_rad, geometry)
    check_together(
        body_acc_mps2=body.shape[:-1],
        steering_rad=np.shape(steering_rad),
        throttle_rad=np.shape(throttle_rad),
    )
    return np.asarray(np.einsum("...ji,...j->...i", rotation, body))


def body_specific_force(
    pitch_rad: ArrayLike,
    roll_rad: ArrayLike,
    gravity_mps2: float = STANDARD_GRAVITY_MPS2,
) -> FloatArray:
    """Specific force in {B} of a scooter at rest on a slope.

    Parameters
    ----------
    pitch_rad : (...) array, rad, forward axis above the horizontal: positive with the nose up
    roll_rad : (...) array, rad, turn about the forward axis: positive with the right side up
    gravity_mps2 : float, m/s²

    Returns
    -------
    (..., 3) array, m/s², in {B}: g (cos pitch sin roll, sin pitch, cos pitch cos roll)

    Examples
    --------
    >>> body_specific_force(np.deg2rad(5), 0.0).round(3).tolist()
    [0.0, 0.855, 9.769]
    """
    pitch, roll = as_floats(pitch_rad, "pitch_rad"), as_floats(roll_rad, "roll_rad")
    check_together(pitch_rad=pitch.shape, roll_rad=roll.shape)
    pitch, roll = np.broadcast_arrays(pitch, roll)
    gravity_mps2 = as_number(gravity_mps2, "gravity_mps2", negative=True)
    return gravity_mps2 * np.stack(
        [np.cos(pitch) * np.sin(roll), np.sin(pitch), np.cos(pitch) * np.cos(roll)], axis=-1
    )
