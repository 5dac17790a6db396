"""Steering and throttle angles from accelerations (Suzurikawa et al. 2022, eqs. 6 and 7).

Two forms of one solution. The printed one uses arcsine and arctangent and needs C1 > 0, K1 > 0
and a lever z axis that points up. The three-axis one uses all components of the lever's
acceleration, needs no branch, and is a least-squares solution of eq. 5.

Neither can tell a steering angle from its mirror image: ``s`` and
``pi - s - 2 atan2(ax_B, C1)``, each with its own throttle angle, give the same acceleration of
the lever. Of the two, the three-axis form takes the one nearer to straight ahead; for C1 > 0 so
does the printed one. They meet, and the angle cannot be observed, where K2 = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_flags,
    as_floats,
    as_number,
    as_vectors,
    check_together,
    one_of,
    wrap_angle,
)
from mobility_imu.hinges import column_vector, steered, turn
from mobility_imu.results import Result
from mobility_imu.scooter.geometry import ScooterGeometry, lever_acceleration

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "OBSERVABILITY_LIMIT",
    "Form",
    "ScooterAngles",
    "angle_standard_deviations",
    "estimate_angles",
    "steering_angle",
    "three_axis_angles",
    "throttle_angle",
]

Form = Literal["corrected", "printed"]
"""All three axes at once, or eqs. 6 and 7 as the paper prints them."""

OBSERVABILITY_LIMIT = float(np.sin(np.deg2rad(2.0)))
"""Smallest lever arm, as a fraction of the acceleration's length, on which an angle may rest.

An error of direction (tilt of an IMU, noise over g) reaches the angle divided by this fraction:
below it, 0.1 deg of tilt moves the angle by 3 deg or more.
"""

LARGEST_ERROR_RAD = float(np.deg2rad(20.0))
"""Steering error that an acceleration may cause in a sample that is valid.

A sensor that is accelerated by as much across gravity as its length shows along gravity reads a
force that is turned by ``|length - g| / g``, and steering errs by that times
``hypot(K1, K2) / |K2|``, 2.9 straight ahead on level ground. There 20 deg, twice what the paper
states for nine of ten samples of its drives, allow lengths that are off by 12 %.
"""

LARGEST_LEAN_RAD = float(np.deg2rad(30.0))
"""Angle between the body's force and its z axis beyond which the scooter is not in slow drive.

Upright, 30 deg are a horizontal acceleration of 5.7 m/s², or a slope on which no scooter stands.
Leaning sideways by 30 deg, with alpha 20 deg, the mirror image of straight ahead has come to
61 deg, about as far as a steering turns: which of the two is true cannot be told any more.
"""

ACCELERATED_FRACTION = 0.05
"""Fraction of accelerated samples from which on a warning says so."""

UPRIGHT_FRACTION = 0.1
"""Fraction of samples within 90 deg of rest that a sensor with a reversed sign does not reach."""
FIRST_SAMPLES = 25
"""Samples at the beginning in which the controls are taken to be at rest, by their median."""
SAMPLES_LOOKED_AT = 5000
"""Samples, spread over a recording, in which the lever's sign is looked at."""

# Samples worked on at once: the rows of a block stay in the processor's cache.
BLOCK = 16384

# Medians below this many m/s² cannot be a sensor at rest in m/s², but can be one in g.
_LOOKS_LIKE_G = 2.5


@dataclass(frozen=True, eq=False, repr=False)
class ScooterAngles(Result):
    """Angles of the two controls, and whether to trust them.

    Parameters
    ----------
    steering_rad : (...) array, rad, positive to the left
    throttle_rad : (...) array, rad, positive with the lever pushed
    valid : (...) bool array, see :func:`estimate_angles`. Of one vector alone, of shape (3,), all
        three are single values; of a series of one sample, arrays of shape (1,)
    form : "corrected" or "printed", what they were estimated with
    warnings : sentences for the user

    Raises
    ------
    InputError
        If the arrays differ in shape, or a field is something else.
    """

    steering_rad: FloatArray
    throttle_rad: FloatArray
    valid: NDArray[np.bool_]
    form: Form = "corrected"
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that the arrays are alike; a single sample stays the number that it is."""
        one_of("ScooterAngles.form", self.form, ("corrected", "printed"))
        check_fields(self)
        names = ("steering_rad", "throttle_rad")
        both = [as_floats(getattr(self, name), f"ScooterAngles.{name}") for name in names]
        shape = both[0].shape
        if both[1].shape != shape:
            raise InputError(
                f"ScooterAngles.throttle_rad: expected shape {shape} like steering_rad, got "
                f"{both[1].shape}"
            )
        valid = as_flags(self.valid, "ScooterAngles.valid", length=shape)
        if shape:
            for name, array in zip((*names, "valid"), (*both, valid), strict=True):
                object.__setattr__(self, name, array)
        super().__post_init__()

    def to_frame(self) -> pd.DataFrame:
        """Table in degrees with steering_deg, throttle_deg and valid, one row per sample."""
        import pandas as pd

        shape = np.shape(self.steering_rad)
        if len(shape) > 1:
            raise InputError(f"angles of shape {shape}: a table is of one series")
        return pd.DataFrame(
            {
                "steering_deg": np.atleast_1d(np.rad2deg(self.steering_rad)),
                "throttle_deg": np.atleast_1d(np.rad2deg(self.throttle_rad)),
                "valid": np.atleast_1d(self.valid),
            }
        )


def steering_angle(
    lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike, geometry: ScooterGeometry
) -> FloatArray:
    """Steering angle as printed (eq. 6).

    Right where C1 > 0 and ``|steering + atan(ax_B / C1)| <= pi/2``; elsewhere it gives another
    angle without a sign of it. NaN where the arcsine's argument is beyond +-1, which noise, a
    moving lever or an unknown slope can bring about.

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², specific force in {T}
    body_acc_mps2 : (..., 3) array, m/s², specific force in {B}; [0, 0, g] for a single IMU
    geometry : ScooterGeometry

    Returns
    -------
    (...) array, rad, positive to the left

    Raises
    ------
    InputError
        If the arrays are not three-vectors or do not broadcast together.
    """
    lever, body = _vectors(lever_acc_mps2, body_acc_mps2, geometry)
    column = column_vector(body, geometry.steering_inclination_rad)
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN is the answer, not an accident
        sine = lever[..., 0] / np.sqrt(column.x**2 + column.c1**2)
        return np.arcsin(sine) - np.arctan(column.x / column.c1)


def throttle_angle(
    lever_acc_mps2: ArrayLike,
    body_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    geometry: ScooterGeometry,
) -> FloatArray:
    """Throttle angle as printed, once the steering angle is known (eq. 7).

    Right where K1 > 0 and the lever IMU's z axis points up. NaN where the arcsine's argument
    is beyond +-1 or the steering angle is NaN.

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², specific force in {T}
    body_acc_mps2 : (..., 3) array, m/s², specific force in {B}; [0, 0, g] for a single IMU
    steering_rad : (...) array, rad, positive to the left
    geometry : ScooterGeometry

    Returns
    -------
    (...) array, rad, positive with the lever pushed

    Raises
    ------
    InputError
        If the arrays are not three-vectors or do not broadcast together.
    """
    lever, body = _vectors(lever_acc_mps2, body_acc_mps2, geometry)
    steering = as_floats(steering_rad, "steering_rad")
    check_together(
        lever_acc_mps2=lever.shape[:-1], body_acc_mps2=body.shape[:-1], steering_rad=steering.shape
    )
    column = column_vector(body, geometry.steering_inclination_rad)
    k1, (_, k2) = column.k1, steered(column, steering)
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = lever[..., 1] / np.sqrt(k1**2 + k2**2)
        return np.arctan(k2 / k1) - np.arcsin(sine) - geometry.lean_rad


def three_axis_angles(
    lever_acc_mps2: ArrayLike, body_acc_mps2: ArrayLike, geometry: ScooterGeometry
) -> tuple[FloatArray, FloatArray]:
    """Both angles from all three axes: the least-squares solution of eq. 5.

    Minimises the length of the difference between the measured lever acceleration and the one
    that eq. 5 predicts. Any sign of C1, K1 and of the lever's z component is right, and it always
    answers: a reading beyond what any steering angle can give is met as nearly as can be, at
    K2 = 0. The scale of each sensor may be unknown.

    Two pairs of angles do this equally well. This gives the one nearer to straight ahead, in
    which K2 has the sign of C1. It cannot know that the wheel is really turned beyond K2 = 0
    (on level ground: beyond 90 deg), nor of an acceleration that only one of the IMUs feels.

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², specific force in {T}
    body_acc_mps2 : (..., 3) array, m/s², specific force in {B}; [0, 0, g] for a single IMU
    geometry : ScooterGeometry

    Returns
    -------
    steering_rad, throttle_rad : (...) arrays, rad, in [-pi, pi]

    Raises
    ------
    InputError
        If the arrays are not three-vectors or do not broadcast together.
    """
    lever, body = _vectors(lever_acc_mps2, body_acc_mps2, geometry)
    shape = np.broadcast_shapes(lever.shape, body.shape)
    lever, body = (np.broadcast_to(v, shape).reshape(-1, 3) for v in (lever, body))
    angles = np.empty((2, len(lever)))
    workspace = np.empty((10, min(BLOCK, len(lever))))
    with np.errstate(all="ignore"):  # a zero vector has no angles: NaN
        for start in range(0, len(lever), BLOCK):
            part = slice(start, start + BLOCK)
            _three_axis_block(lever[part], body[part], geometry, angles[:, part], workspace)
    return angles[0].reshape(shape[:-1]), angles[1].reshape(shape[:-1])


def _three_axis_block(
    lever: FloatArray,
    body: FloatArray,
    geometry: ScooterGeometry,
    angles: FloatArray,
    workspace: FloatArray,
) -> None:
    """Fill ``angles``; every step works in place on rows that stay in the processor's cache.

    Differences of arctangents are taken inside one ``arctan2``, by the sine and cosine of the
    difference: half the calls.
    """
    alpha, lean = geometry.steering_inclination_rad, geometry.lean_rad
    sin, cos = np.sin(alpha), np.cos(alpha)
    tx, ty, tz, x, c1, k1, k2, a, b, c = (row[: len(lever)] for row in workspace)
    tx[:], ty[:], tz[:] = lever.T
    x[:], a[:], b[:] = body.T
    c1[:], k1[:] = turn(a, b, sin, cos)
    np.add(np.multiply(x, x, out=k2), np.multiply(c1, c1, out=c), out=k2)
    # The lever's x component, as it would be with the lever's length equal to the body's.
    np.add(np.multiply(tx, tx, out=a), np.multiply(ty, ty, out=c), out=a)
    np.add(a, np.multiply(tz, tz, out=c), out=a)
    np.add(k2, np.multiply(k1, k1, out=c), out=b)
    np.multiply(tx, np.sqrt(np.divide(b, a, out=b), out=b), out=tx)
    # Beyond the reach of any steering angle K2 is 0, and the arctangent below takes it from there.
    np.maximum(np.subtract(k2, np.multiply(tx, tx, out=c), out=k2), 0, out=k2)
    np.copysign(np.sqrt(k2, out=k2), c1, out=k2)
    # Steering: atan2(tx, K2) - atan2(x, C1).
    np.subtract(np.multiply(tx, c1, out=a), np.multiply(x, k2, out=c), out=a)
    np.add(np.multiply(k2, c1, out=b), np.multiply(tx, x, out=c), out=b)
    np.arctan2(a, b, out=angles[0])
    # Throttle: atan2(K2, K1) - atan2(ty, tz) - (alpha - beta).
    np.subtract(np.multiply(k2, tz, out=a), np.multiply(k1, ty, out=c), out=a)
    np.add(np.multiply(k1, tz, out=b), np.multiply(k2, ty, out=c), out=b)
    throttle = np.arctan2(a, b, out=angles[1])
    throttle -= lean
    beyond = np.abs(throttle) > np.pi
    if beyond.any():
        throttle[beyond] = wrap_angle(throttle[beyond])


def estimate_angles(
    lever_acc_mps2: ArrayLike,
    body_acc_mps2: ArrayLike | None,
    geometry: ScooterGeometry,
    *,
    form: Form = "corrected",
) -> ScooterAngles:
    """Steering and throttle angles from one or two IMUs (eqs. 6 and 7, or both axes at once).

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², specific force in {T}
    body_acc_mps2 : (..., 3) array, m/s², specific force in {B}. None for a single IMU: then
        the scooter is taken to stand level and still, gravity (0, 0, g) in {B}.
    geometry : ScooterGeometry
    form : "corrected" for :func:`three_axis_angles`; "printed" for :func:`steering_angle`
        followed by :func:`throttle_angle`, as in the paper

    Returns
    -------
    ScooterAngles
        ``valid`` is true where the numbers are finite; where some steering angle explains the
        lever's x component (the arcsine's argument is within +-1); where both angles are
        observable, that is, ``|K2|`` (the lever arm of the steering) and the part of the
        acceleration across the lever's axis (that of the throttle) are longer than
        :data:`OBSERVABILITY_LIMIT` times the whole; where the sensors are at rest or in slow drive,
        by the lengths of their readings (``LARGEST_ERROR_RAD``) and the body's direction
        (``LARGEST_LEAN_RAD``); and for "printed" also where C1 > 0, K1 > 0 and the lever's z
        component > 0.
        An angle that is not valid is as the formula left it: perhaps NaN, never to be trusted.
        ``valid`` cannot see the mirror solution, an unknown slope, or an acceleration across
        gravity of one IMU only, which changes no length.
        ``warnings`` says if more than ``ACCELERATED_FRACTION`` of the samples were accelerated.

    Raises
    ------
    InputError
        Arrays of a wrong shape, an unknown form, units of g, and sensors that read gravity with
        the wrong sign or are mounted upside down.

    Examples
    --------
    >>> from mobility_imu.scooter import SUZUKI_ET4D
    >>> angles = estimate_angles([[1.677, -2.256, 9.395]], None, SUZUKI_ET4D)
    >>> angles.to_frame().round(1).values.tolist()
    [[30.0, 20.0, True]]
    """
    one_of("form", form, ("corrected", "printed"))
    level = (0.0, 0.0, STANDARD_GRAVITY_MPS2)
    body_acc = level if body_acc_mps2 is None else body_acc_mps2
    lever, body = _vectors(lever_acc_mps2, body_acc, geometry)
    with np.errstate(all="ignore"):  # what overflows has no angle
        check_gravity(lever, body, geometry)
        lever_length, body_length = (np.linalg.norm(acc, axis=-1) for acc in (lever, body))
        if form == "corrected":
            steering, throttle = three_axis_angles(lever, body, geometry)
            sideways = _scaled_sideways(lever, lever_length, body_length)
        else:
            steering = steering_angle(lever, body, geometry)
            throttle = throttle_angle(lever, body, steering, geometry)
            sideways = lever[..., 0]
        column = column_vector(body, geometry.steering_inclination_rad)
        k2 = np.abs(steered(column, steering)[1])
        off = _length_error(lever_length)
        if body_acc_mps2 is not None:
            off = np.maximum(off, _length_error(body_length))
        fast = off * np.hypot(column.k1, k2) > LARGEST_ERROR_RAD * k2
        leans = body[..., 2] < np.cos(LARGEST_LEAN_RAD) * body_length
        observable = k2 > OBSERVABILITY_LIMIT * body_length
        valid = (
            np.isfinite(steering)
            & np.isfinite(throttle)
            & (np.abs(sideways) <= np.hypot(column.x, column.c1))
            & observable
            & ~fast
            & ~leans
        )
        if form == "printed":
            valid &= (column.c1 > 0) & (column.k1 > 0) & (lever[..., 2] > 0)
        warnings = _accelerated((fast & observable) | leans, leans, off)
    return ScooterAngles(steering, throttle, valid, form, warnings)


def angle_standard_deviations(
    lever_acc_mps2: ArrayLike,
    steering_rad: ArrayLike,
    throttle_rad: ArrayLike,
    geometry: ScooterGeometry,
    *,
    lever_sd_mps2: float,
    body_sd_mps2: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """How far sensor noise spreads the angles of the three-axis form, to first order.

    With H the 3x2 derivative of eq. 5 by the two angles, the least-squares solution has the
    covariance ``(sd_T² + sd_B²) (HᵀH)⁻¹``; its diagonal is written out here. A column of H is
    the acceleration crossed with the axis of one control, in {T}. The value of the steering
    angle does not enter: all that it does is in the lever's acceleration.

    Mounting errors, bias, and vibration that the two IMUs do not share are not in it. Near the
    limit of observability first order is too little.

    Parameters
    ----------
    lever_acc_mps2 : (..., 3) array, m/s², specific force in {T}
    steering_rad, throttle_rad : (...) arrays, rad, as estimated
    geometry : ScooterGeometry
    lever_sd_mps2, body_sd_mps2 : float, m/s², standard deviation of the noise of each IMU, the
        same on its three axes and independent

    Returns
    -------
    steering_sd_rad, throttle_sd_rad : (...) arrays, rad; infinite where K2 = 0, NaN where an angle
    is NaN

    Raises
    ------
    InputError
        If the vectors have not three components, the arrays do not broadcast together, or a
        standard deviation is negative or no number.

    Examples
    --------
    >>> from mobility_imu.scooter import SUZUKI_ET4D
    >>> level = lever_acceleration([0.0, 0.0, 9.80665], 0.0, 0.0, SUZUKI_ET4D)
    >>> milli_g = 9.80665e-3
    >>> sd = angle_standard_deviations(level, 0.0, 0.0, SUZUKI_ET4D, lever_sd_mps2=milli_g)
    >>> [round(float(np.rad2deg(value)), 3) for value in sd]
    [0.168, 0.057]
    """
    expect("geometry", geometry, ScooterGeometry)
    lever = as_vectors(lever_acc_mps2, "lever_acc_mps2")
    steering, throttle = (
        as_floats(steering_rad, "steering_rad"),
        as_floats(throttle_rad, "throttle_rad"),
    )
    check_together(
        lever_acc_mps2=lever.shape[:-1], steering_rad=steering.shape, throttle_rad=throttle.shape
    )
    lever_sd = as_number(lever_sd_mps2, "lever_sd_mps2", zero=True)
    body_sd = as_number(body_sd_mps2, "body_sd_mps2", zero=True)
    x, y, z = lever[..., 0], lever[..., 1], lever[..., 2]
    tipped = geometry.lean_rad + throttle
    arm, along_shaft = turn(y, z, np.sin(tipped), np.cos(tipped))  # K2, K1
    length = np.linalg.norm(lever, axis=-1)
    noise = np.hypot(lever_sd, body_sd)
    with np.errstate(divide="ignore", invalid="ignore"):
        # det(HᵀH) = (length arm)²
        scale = noise / (length * np.abs(arm))
        scale = np.where(np.isnan(steering), np.nan, scale)
        return scale * np.hypot(along_shaft, arm), scale * np.hypot(x, arm)


def _vectors(
    lever_acc: ArrayLike, body_acc: ArrayLike, geometry: ScooterGeometry
) -> tuple[FloatArray, FloatArray]:
    """Both accelerations as arrays; they and the geometry are checked."""
    expect("geometry", geometry, ScooterGeometry)
    lever = as_vectors(lever_acc, "lever_acc_mps2")
    body = as_vectors(body_acc, "body_acc_mps2")
    try:
        np.broadcast_shapes(lever.shape, body.shape)
    except ValueError:
        raise InputError(
            f"lever_acc_mps2 has shape {lever.shape}, body_acc_mps2 {body.shape}: expected the "
            "same number of samples"
        ) from None
    return lever, body


def _length_error(length: FloatArray) -> FloatArray:
    """How far the length of each reading is off gravity, as a fraction of it."""
    return np.asarray(np.abs(length / STANDARD_GRAVITY_MPS2 - 1))


def _accelerated(
    accelerated: NDArray[np.bool_], leans: NDArray[np.bool_], off: FloatArray
) -> tuple[str, ...]:
    """Warning if more than a few of the samples were accelerated."""
    read = np.isfinite(off)
    accelerated = accelerated & read
    fraction = accelerated.sum() / max(read.sum(), 1)
    if fraction <= ACCELERATED_FRACTION:
        return ()
    leaning = np.broadcast_to(leans, read.shape)[accelerated]
    length, lean = 100 * np.median(off[accelerated]), 100 * np.mean(leaning)
    return (
        f"the sensors were accelerated in {100 * fraction:.0f} % of the samples: there the lengths "
        f"are off gravity by {length:.0f} % (median), and the body's force lies more than "
        f"{np.rad2deg(LARGEST_LEAN_RAD):.0f} deg from its z axis in {lean:.0f} %; the closed form "
        "holds at rest and in slow drive, on an upright scooter: they are marked as not valid",
    )


def _scaled_sideways(
    lever: FloatArray, lever_length: FloatArray, body_length: FloatArray
) -> FloatArray:
    """Lever's x component, as it would be with the lever's length equal to the body's."""
    length = np.where(np.isinf(lever_length), np.nan, lever_length)
    return np.asarray(lever[..., 0] * (body_length / length))


def check_gravity(lever: FloatArray, body: FloatArray, geometry: ScooterGeometry) -> None:
    """Check unit and sign of gravity, which all rests on.

    The unit is checked in the median sample. A sign is called reversed if the first samples and
    nine of ten samples are more than 90 deg away from the controls at rest: a sweep of the lever
    beyond 90 deg begins at rest or passes it.

    Parameters
    ----------
    lever, body : (..., 3) arrays, m/s², in {T} and {B}
    geometry : ScooterGeometry

    Raises
    ------
    InputError
        If the readings look like g, or gravity points the wrong way.
    """
    lever_median, body_median = _median(lever), _median(body)
    if lever_median is None or body_median is None:
        return
    for name, median in (("lever", lever_median), ("body", body_median)):
        length = float(np.linalg.norm(median))
        if length < _LOOKS_LIKE_G:
            raise InputError(
                f"{name}_acc_mps2: the median sample is {length:.3g} long, expected about "
                f"{STANDARD_GRAVITY_MPS2:.2f} m/s²: is it in g, or was gravity taken out?"
            )
    if _is_reversed(body[..., 2]):
        raise InputError(
            f"body_acc_mps2: the median z is {body_median[2]:.3g} m/s², expected about "
            f"+{STANDARD_GRAVITY_MPS2:.2f} (specific force, z up): the sign is flipped or the "
            "sensor is upside down"
        )
    lever, body = np.broadcast_arrays(lever, body)
    some = slice(None, None, max(1, lever.size // (3 * SAMPLES_LOOKED_AT)))
    lever, body = lever.reshape(-1, 3)[some], body.reshape(-1, 3)[some]
    if _is_reversed((lever * lever_acceleration(body, 0.0, 0.0, geometry)).sum(axis=-1)):
        at_rest = lever_acceleration(body_median, 0.0, 0.0, geometry)
        raise InputError(
            f"lever_acc_mps2: the median {_show(lever_median)} m/s² is more than 90 deg away from "
            f"{_show(at_rest)}, which the controls at rest would give: the sign is flipped or the "
            "sensor is upside down"
        )


def _is_reversed(along: FloatArray) -> bool:
    """Whether readings are on the wrong side of rest at first, and in nine of ten samples."""
    known = along[np.isfinite(along)]
    if not len(known):
        return False
    at_first, upright = np.median(known[:FIRST_SAMPLES]), np.mean(known >= 0)
    return bool(at_first < 0 and upright < UPRIGHT_FRACTION)


def _median(vectors: FloatArray) -> FloatArray | None:
    rows = vectors.reshape(-1, 3)
    rows = rows[np.isfinite(rows).all(axis=1)]
    return np.median(rows, axis=0) if len(rows) else None


def _show(vector: FloatArray) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in vector) + ")"
