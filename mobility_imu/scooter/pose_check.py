"""Are the angles right? Poses that a protractor set, beside the angles that the IMUs give.

The scooter is parked, the controls rest at known angles. The errors that stay the same in all
poses stand in one vector e: turns of both IMUs; offset, scale and axes of both accelerometers;
alpha and beta. To first order they make the reading miss eq. 5 by ``D e``, and the angles by
``H⁺ D e``, with H⁺ as in :mod:`mobility_imu.scooter.sensitivity`. A calibration of the mount has
seen such a misfit before and turned the IMUs by ``-K (D e + s)``, K being the gain of its least
squares and s what its stops were off. What it leaves is propagated to the poses of the check. The
differences are judged by their whole covariance: an error that all poses share counts once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from mobility_imu.arguments import check_columns, expect, settings_or_default
from mobility_imu.fields import check_fields
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_number,
    check_positive,
    one_of,
    wrap_angle,
)
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.scooter.angles import estimate_angles
from mobility_imu.scooter.calibration import (
    ACC_BIAS_SD,
    ACC_MISALIGNMENT_SD_RAD,
    ACC_SCALE_SD,
    POSE_SD_RAD,
    PRIOR_SD_RAD,
    find_stills,
    parked_poses,
)
from mobility_imu.scooter.geometry import (
    ScooterGeometry,
    body_specific_force,
)
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.pose_errors import by_errors, by_set_angles, set_covariance
from mobility_imu.scooter.pose_table import as_poses, within_a_turn
from mobility_imu.scooter.ride import Method, RideSettings, estimate_ride
from mobility_imu.scooter.sensitivity import by_lever_acceleration

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["PoseCheck", "PoseCheckSettings", "check_poses", "pose_uncertainty"]

CONTROLS = ("steering", "throttle")
Verdict = Literal["agrees", "differs", "cannot be judged"]
LEVEL_95 = 0.95
QUANTILE_95 = float(special.ndtri(0.5 + LEVEL_95 / 2))
EACH_TEST = 0.05 / 3
"""Chi-square and two mean differences: together they call 5 of 100 right scooters wrong."""
TOO_GOOD = 0.005
"""A chi-square that is smaller by chance in so few checks means that the stated sizes are large."""
FEWEST_POSES = 3
"""Fewer poses say nothing of a method."""
STOPS_DEG = ((50, 0), (50, 40), (0, 40), (0, 0), (-50, 0), (-50, 40))
SLOPES_DEG = (0.0, 5.0)
"""Poses and slopes of the calibration that is assumed where there is a mount."""
MOST_OF_A_REST = 0.5
"""Fraction of a rest's samples that a method has to trust."""


@dataclass(frozen=True)
class PoseCheckSettings:
    """What is assumed of protractor and sensors, and by which method the angles are found.

    The sizes are those of consumer sensors, stuck on by eye, and of a printed scale. Zero-g offset:
    20 mg, scale and axes: 1 %, as data sheets of phones' accelerometers state them. Turn of an
    IMU: 2 deg, by eye. Change of the offset since the calibration: 7 mg, for 5 mg from power-up to
    power-up, or 7 K at 1 mg/K. Inclinations: 0.5 deg, by a phone's inclinometer. Scale with a mark
    per degree, read to half a mark: 0.3 deg; its zero and centre: 0.5 deg.

    Parameters
    ----------
    method : "closed-form" (means over each rest) or "fusion" (its own standard deviations)
    reading_sd_rad : rad, error of setting one angle, new in each pose
    scale_sd_rad : rad, error of the scale, the same wherever the same angle is set
    mount_sd_rad : rad, turn of an IMU about each of its axes, before a calibration
    acc_offset_sd_mps2 : m/s², constant error of each axis of an accelerometer
    acc_change_sd_mps2 : m/s², change of that error since the calibration
    acc_scale_sd : 1, error of the scale of each axis
    acc_axes_sd_rad : rad, lean of each axis towards each of the others
    geometry_sd_rad : rad, error of alpha and of beta
    stop_sd_rad : rad, error of the stops in the calibration

    Raises
    ------
    InputError
        If the method is unknown or a size is not above zero.
    """

    method: Method = "closed-form"
    reading_sd_rad: float = float(np.deg2rad(0.3))
    scale_sd_rad: float = float(np.deg2rad(0.5))
    mount_sd_rad: float = float(np.deg2rad(2.0))
    acc_offset_sd_mps2: float = 0.02 * STANDARD_GRAVITY_MPS2
    acc_change_sd_mps2: float = 0.007 * STANDARD_GRAVITY_MPS2
    acc_scale_sd: float = 0.01
    acc_axes_sd_rad: float = 0.01
    geometry_sd_rad: float = float(np.deg2rad(0.5))
    stop_sd_rad: float = float(np.deg2rad(0.5))

    def __post_init__(self) -> None:
        """Check the method and every size."""
        one_of("method", self.method, ("closed-form", "fusion"))
        check_positive(
            self,
            "reading_sd_rad",
            "scale_sd_rad",
            "mount_sd_rad",
            "acc_offset_sd_mps2",
            "acc_change_sd_mps2",
            "acc_scale_sd",
            "acc_axes_sd_rad",
            "geometry_sd_rad",
            "stop_sd_rad",
        )

    @classmethod
    def for_calibrated_imus(cls, method: Method = "closed-form") -> PoseCheckSettings:
        """Settings for IMUs whose accelerometers the maker calibrated, stuck on with care.

        Offset 5 mg, scale 0.3 %, axes 0.2 deg, as :mod:`mobility_imu.scooter.calibration` assumes;
        turns of 1 deg.

        Parameters
        ----------
        method : "closed-form" or "fusion"

        Returns
        -------
        PoseCheckSettings
        """
        return cls(
            method,
            mount_sd_rad=float(np.deg2rad(1.0)),
            acc_offset_sd_mps2=ACC_BIAS_SD * STANDARD_GRAVITY_MPS2,
            acc_scale_sd=ACC_SCALE_SD,
            acc_axes_sd_rad=ACC_MISALIGNMENT_SD_RAD,
        )

    def kept_on(self) -> PoseCheckSettings:
        """The same settings for IMUs that were not switched off since the calibration.

        Their offsets changed by 1 mg: a kelvin, at 1 mg/K.

        Returns
        -------
        PoseCheckSettings
        """
        return replace(self, acc_change_sd_mps2=0.001 * STANDARD_GRAVITY_MPS2)

    @property
    def set_sd_rad(self) -> float:
        """Standard deviation of a set angle, rad."""
        return float(np.hypot(self.reading_sd_rad, self.scale_sd_rad))


@dataclass(frozen=True, eq=False, repr=False)
class PoseCheck(Result):
    """Set and found angles of parked poses, and whether they agree.

    Parameters
    ----------
    start_s, stop_s : (n,) arrays, s, rest of each pose on the recording's clock
    set_rad : (n, 2) array, rad, steering and throttle as set
    found_rad : (n, 2) array, rad, as found
    found_sd_rad : (n, 2) array, rad, standard deviation of the found angles
    difference_sd_rad : (n, 2) array, rad, of found minus set; with the protractor's part
    judged : (n,) bool array, whether the method trusts the pose; only these count
    chi_square : squared differences by their whole covariance; 2 per pose is expected
    verdict : "differs" if the chi-square, or the mean difference of a control, is larger than
        chance makes it in 5 of 100 checks; else "agrees"; "cannot be judged" with fewer than three
        poses
    geometry : ScooterGeometry
    calibrated : whether a mount was given
    settings : PoseCheckSettings
    warnings : sentences for the user
    """

    start_s: FloatArray
    stop_s: FloatArray
    set_rad: FloatArray
    found_rad: FloatArray
    found_sd_rad: FloatArray
    difference_sd_rad: FloatArray
    judged: NDArray[np.bool_]
    chi_square: float
    verdict: Verdict
    geometry: ScooterGeometry
    calibrated: bool
    settings: PoseCheckSettings
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check that there is one entry for each pose."""
        check_columns(self, "start_s", "stop_s", flags=("judged",))
        pairs = (len(self.start_s), 2)
        check_fields(
            self, set_rad=pairs, found_rad=pairs, found_sd_rad=pairs, difference_sd_rad=pairs,
            chi_square=float, geometry=ScooterGeometry, calibrated=bool, settings=PoseCheckSettings,
        )  # fmt: skip
        one_of("PoseCheck.verdict", self.verdict, get_args(Verdict))
        super().__post_init__()

    @property
    def difference_rad(self) -> FloatArray:
        """Found minus set angles, (n, 2), rad."""
        return wrap_angle(self.found_rad - self.set_rad)

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Whether each difference lies inside its 95 % interval, (n, 2)."""
        return np.asarray(np.abs(self.difference_rad) <= QUANTILE_95 * self.difference_sd_rad)

    @property
    def rms_rad(self) -> FloatArray:
        """Root mean square of the differences in steering and throttle, (2,), rad."""
        if not self.judged.any():
            return np.full(2, np.nan)
        return np.asarray(np.sqrt(np.mean(self.difference_rad[self.judged] ** 2, axis=0)))

    @property
    def probability(self) -> float:
        """How often chance alone makes the chi-square as large, if the assumed sizes hold."""
        degrees = 2 * int(self.judged.sum())
        return float(special.chdtrc(degrees, self.chi_square)) if degrees else float("nan")

    def to_frame(self) -> pd.DataFrame:
        """Table in degrees, one row for each pose and control.

        Returns
        -------
        DataFrame
            ``pose`` (from 1), ``start_s``, ``stop_s``, ``control``, ``set_deg``, ``found_deg``,
            ``difference_deg``, ``sd_deg`` (of the difference), ``inside_95`` (1 or 0),
            ``judged`` (1 or 0)
        """
        import pandas as pd

        n = len(self.start_s)
        return pd.DataFrame(
            {
                "pose": np.repeat(np.arange(1, n + 1), 2),
                "start_s": np.repeat(self.start_s, 2),
                "stop_s": np.repeat(self.stop_s, 2),
                "control": CONTROLS * n,
                "set_deg": np.rad2deg(self.set_rad).ravel(),
                "found_deg": np.rad2deg(self.found_rad).ravel(),
                "difference_deg": np.rad2deg(self.difference_rad).ravel(),
                "sd_deg": np.rad2deg(self.difference_sd_rad).ravel(),
                "inside_95": self.inside.ravel().astype(int),
                "judged": np.repeat(self.judged, 2).astype(int),
            }
        )


def check_poses(
    parked: Recording,
    settings_of_poses_rad: Sequence[tuple[float, float]],
    geometry: ScooterGeometry,
    mount: ScooterMount | None = None,
    settings: PoseCheckSettings | None = None,
) -> PoseCheck:
    """Angles of parked poses beside those that a protractor set.

    Each pose is held at rest for a second or longer. Poses near K2 = 0, where no reading shows the
    steering, are left out and named.

    Parameters
    ----------
    parked : Recording with sensors ``lever`` and ``body``, both with gyroscopes for fusion
    settings_of_poses_rad : (steering, throttle) of each pose as set, rad, in the order of time
    geometry : ScooterGeometry
    mount : ScooterMount, taken as calibrated by parked poses on level ground and on a ramp; None
        takes the IMUs' axes for {T} and {B}, and lets them be turned by ``settings.mount_sd_rad``
    settings : PoseCheckSettings; None is the default

    Returns
    -------
    PoseCheck

    Raises
    ------
    InputError
        If the recording has not as many rests as there are poses, or lacks a sensor.

    Examples
    --------
    >>> import numpy as np
    >>> from mobility_imu.recording import Imu, Recording
    >>> from mobility_imu.scooter import SUZUKI_ET4D, check_poses
    >>> from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration
    >>> poses = np.deg2rad([[30.0, 0.0], [0.0, 20.0], [-30.0, 10.0]])
    >>> each = np.repeat([0, 1, 2], 200)
    >>> body = np.tile(body_specific_force(0.0, 0.0), (600, 1))
    >>> lever = lever_acceleration(body, *poses[each].T, SUZUKI_ET4D)
    >>> turning = np.zeros((600, 3))
    >>> turning[195:205] = turning[395:405] = 1.0
    >>> sensors = {"lever": Imu(lever, turning), "body": Imu(body, 0 * turning)}
    >>> found = check_poses(Recording(np.arange(600) / 100, sensors), poses.tolist(), SUZUKI_ET4D)
    >>> found.verdict, np.rad2deg(found.found_rad).round(1).tolist()
    ('agrees', [[30.0, 0.0], [0.0, 20.0], [-30.0, 10.0]])
    """
    expect("parked", parked, Recording)
    expect("geometry", geometry, ScooterGeometry)
    expect("mount", mount, ScooterMount, none=True)
    settings = settings_or_default("settings", settings, PoseCheckSettings)
    poses = parked_poses(parked, settings_of_poses_rad)
    rests = find_stills(parked)
    believed = np.array([(pose.steering_rad, pose.throttle_rad) for pose in poses])
    body = np.array([pose.body_acc_mps2 for pose in poses])
    lever = np.array([pose.lever_acc_mps2 for pose in poses])
    if mount is not None:
        lever, body = mount.lever(lever), mount.body(body)
    spread = _residual(geometry, settings, calibrated=mount is not None)
    if settings.method == "fusion":
        found, stated, judged = _fused(parked, rests, geometry, mount)
    else:
        angles = estimate_angles(lever, body, geometry)
        found = np.column_stack([angles.steering_rad, angles.throttle_rad])
        stated, judged = None, np.asarray(angles.valid)
    covariance = _covariance(found, body, geometry, spread, stated, judged)
    of_set = set_covariance(believed, settings.scale_sd_rad, settings.reading_sd_rad)
    difference, total = wrap_angle(found - believed), covariance + of_set
    verdict, warnings = _judge(difference, total, judged)
    return PoseCheck(
        np.array([parked.time_s[rest.start] for rest in rests]),
        np.array([parked.time_s[rest.stop - 1] for rest in rests]),
        believed,
        found,
        _deviations(covariance),
        _deviations(total),
        judged,
        _chi_square(difference, total, judged),
        verdict,
        geometry,
        mount is not None,
        settings,
        warnings,
    )


def pose_uncertainty(
    poses_rad: ArrayLike,
    geometry: ScooterGeometry,
    settings: PoseCheckSettings | None = None,
    *,
    calibrated: bool = True,
    pitch_rad: float = 0.0,
    roll_rad: float = 0.0,
) -> FloatArray:
    """Expected standard deviations of the closed form's angles in parked poses.

    Parameters
    ----------
    poses_rad : (n, 2) array, rad, steering and throttle
    geometry : ScooterGeometry
    settings : PoseCheckSettings; None is the default
    calibrated : whether the mount was calibrated by parked poses on level ground and on a ramp
    pitch_rad, roll_rad : rad, of the ground; nose up, right side up

    Returns
    -------
    (n, 2) array, rad; the protractor's part is not in it

    Raises
    ------
    InputError
        If the poses are not pairs of finite numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from mobility_imu.scooter import SUZUKI_ET4D
    >>> poses = np.deg2rad([[0.0, 0.0], [30.0, 20.0]])
    >>> sd = [pose_uncertainty(poses, SUZUKI_ET4D, calibrated=c) for c in (False, True)]
    >>> np.rad2deg(sd).round(1).tolist()
    [[[9.8, 3.4], [11.2, 3.9]], [[1.7, 0.8], [1.9, 0.8]]]
    """
    expect("geometry", geometry, ScooterGeometry)
    settings = settings_or_default("settings", settings, PoseCheckSettings)
    one_of("calibrated", calibrated, (False, True))
    poses = as_poses(poses_rad, "poses_rad")
    pitch = as_number(pitch_rad, "pitch_rad", negative=True)
    roll = as_number(roll_rad, "roll_rad", negative=True)
    for name, angle in (("pitch_rad", pitch), ("roll_rad", roll)):
        within_a_turn(angle, name)
    body = np.broadcast_to(body_specific_force(pitch, roll), (len(poses), 3))
    spread = _residual(geometry, settings, calibrated=calibrated)
    everywhere = np.ones(len(poses), bool)
    return _deviations(_covariance(poses, body, geometry, spread, None, everywhere))


def _residual(
    geometry: ScooterGeometry, settings: PoseCheckSettings, *, calibrated: bool
) -> FloatArray:
    """Covariance of the errors that all poses share, (32, 32); with what a calibration leaves."""
    axes = np.where(np.eye(3) > 0, settings.acc_scale_sd, settings.acc_axes_sd_rad).ravel()
    sensor = np.r_[np.full(3, settings.acc_offset_sd_mps2 / STANDARD_GRAVITY_MPS2), axes]
    inclinations = np.full(2, settings.geometry_sd_rad)
    turns = np.full(6, settings.mount_sd_rad)
    spread = np.diag(np.r_[turns, sensor, sensor, inclinations] ** 2)
    if not calibrated:
        return spread
    stops = np.deg2rad(np.tile(STOPS_DEG, (len(SLOPES_DEG), 1)).astype(float))
    slopes = np.repeat(np.deg2rad(SLOPES_DEG), len(STOPS_DEG))
    body = body_specific_force(slopes, np.zeros_like(slopes), 1.0)
    misfit = by_errors(stops, body, geometry).reshape(3 * len(stops), -1)
    weighted = misfit[:, :6].T @ misfit[:, :6] / POSE_SD_RAD**2 + np.eye(6) / PRIOR_SD_RAD**2
    gain = np.linalg.solve(weighted, misfit[:, :6].T) / POSE_SD_RAD**2
    left = np.eye(len(spread))
    left[:6] -= gain @ misfit
    spread = left @ spread @ left.T
    # Stops that are off move the prediction, pose by pose; the same stop always by the same angle.
    by_stops = by_set_angles(stops, body, geometry)
    moved = np.zeros((len(stops), 3, len(stops), 2))
    moved[np.arange(len(stops)), :, np.arange(len(stops))] = by_stops
    turned = gain @ moved.reshape(3 * len(stops), -1)
    spread[:6, :6] += turned @ set_covariance(stops, settings.stop_sd_rad, 0.0) @ turned.T
    offsets = np.r_[6:9, 18:21]
    spread[offsets, offsets] += (settings.acc_change_sd_mps2 / STANDARD_GRAVITY_MPS2) ** 2
    return np.asarray(spread)


def _covariance(
    found: FloatArray,
    body: FloatArray,
    geometry: ScooterGeometry,
    spread: FloatArray,
    stated: FloatArray | None,
    judged: NDArray[np.bool_],
) -> FloatArray:
    """Covariance of found angles, (2n, 2n): H P Hᵀ; scaled to deviations that a method states."""
    size = found.size
    covariance = np.full((size, size), np.nan)
    used = np.flatnonzero(np.repeat(judged, 2))
    poses = found[judged]
    force = body[judged] / np.linalg.norm(body[judged], axis=-1, keepdims=True)
    inverse = by_lever_acceleration(force, poses[:, 0], poses[:, 1], geometry)
    moved = (inverse @ by_errors(poses, force, geometry)).reshape(poses.size, len(spread))
    shared = moved @ spread @ moved.T
    if stated is not None:
        scale = stated[judged].ravel() / np.sqrt(np.diag(shared))
        shared = shared * np.outer(scale, scale)
    covariance[np.ix_(used, used)] = shared
    return covariance


def _deviations(covariance: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.diag(covariance)).reshape(-1, 2))


def _fused(
    parked: Recording,
    rests: Sequence[slice],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Angles by fusion, means over each rest, with the deviations that it states there."""
    ride = estimate_ride(parked, geometry, mount, RideSettings(method="fusion"))
    angles = np.column_stack([ride.steering_rad, ride.throttle_rad])
    sd = np.column_stack([ride.steering_sd_rad, ride.throttle_sd_rad])
    found = np.array([angles[rest].mean(axis=0) for rest in rests])
    stated = np.array([np.median(sd[rest], axis=0) for rest in rests])
    judged = np.array([bool(ride.valid[rest].mean() >= MOST_OF_A_REST) for rest in rests])
    return found, stated, judged & np.isfinite(found).all(axis=1)


def _chi_square(difference: FloatArray, covariance: FloatArray, judged: NDArray[np.bool_]) -> float:
    """Squared differences of the judged poses, weighed by their covariance."""
    used = np.flatnonzero(np.repeat(judged, 2))
    if not len(used):
        return float("nan")
    off = difference.ravel()[used]
    return float(off @ np.linalg.solve(covariance[np.ix_(used, used)], off))


def _means(
    difference: FloatArray, covariance: FloatArray, judged: NDArray[np.bool_]
) -> list[tuple[str, float, float]]:
    """Name of each control, its mean difference and that mean's standard deviation, rad."""
    found = []
    for control, name in enumerate(CONTROLS):
        used = 2 * np.flatnonzero(judged) + control
        spread = covariance[np.ix_(used, used)].mean()
        found.append((name, float(difference.ravel()[used].mean()), float(np.sqrt(spread))))
    return found


def _judge(
    difference: FloatArray, covariance: FloatArray, judged: NDArray[np.bool_]
) -> tuple[Verdict, tuple[str, ...]]:
    """Verdict, and what a user has to know beside it."""
    found = [
        f"pose {k + 1}: no reading shows its angles well enough; it is not judged"
        for k in np.flatnonzero(~judged)
    ]
    count = int(judged.sum())
    if count < FEWEST_POSES:
        found.append(f"{count} poses can be judged, expected {FEWEST_POSES} or more")
        return "cannot be judged", tuple(found)
    chi_square = _chi_square(difference, covariance, judged)
    apart = [
        f"{name} is off by {np.rad2deg(mean):+.1f} deg on average, stated sd "
        f"{np.rad2deg(sd):.1f} deg: look at the zero of the protractor, at alpha and beta, and "
        "calibrate the mount"
        for name, mean, sd in _means(difference, covariance, judged)
        if abs(mean) > special.ndtri(1 - EACH_TEST / 2) * sd
    ]
    if chi_square < 2 * special.gammaincinv(count, TOO_GOOD):
        found.append(
            "the differences are smaller than stated: sensors and protractor are better than "
            "assumed, the stated standard deviations too large"
        )
    differs = bool(apart) or chi_square > special.chdtri(2 * count, EACH_TEST)
    return "differs" if differs else "agrees", (*apart, *found)
