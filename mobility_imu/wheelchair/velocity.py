"""Wheel spin, chair velocity and yaw rate (sections 1.2 and 1.3).

For a wheel that leans by the camber, the gyroscope along the axle reads the spin plus the part
s * yaw_rate * sin(camber) of the chair's yaw rate (s = +1 left, -1 right). Two exact pairs follow:
the uncorrected rate with the distance between wheel centres, and the spin with the track.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import check_columns, expect, for_each, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_floats, as_number, as_series, as_vectors, one_of
from mobility_imu.offsets import (
    GyroscopeOffset,
    merge_offsets,
    offset_warnings,
    rest_offsets,
    without_offsets,
)
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.wheelchair.calibration import Form
from mobility_imu.wheelchair.geometry import (
    SIDES,
    Side,
    WheelchairGeometry,
    printed_yaw_gain,
    side_sign,
)
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.recovery import (
    failed_gyroscopes,
    recovered,
    recovery_warnings,
    unknown_where,
    wheel_forces,
    with_gyroscope,
    with_recovered_sd,
)
from mobility_imu.wheelchair.remarks import alone, backward, coarse, coarse_steps, with_steps
from mobility_imu.wheelchair.saturation import (
    saturated_gyroscopes,
    saturation_warnings,
    usable_samples,
)
from mobility_imu.wheelchair.series import alike, as_offsets
from mobility_imu.wheelchair.slip import (
    SlipMethod,
    SlipSettings,
    at_odds,
    correct_slip,
    detect_slip,
    wheel_speeds,
)
from mobility_imu.wheelchair.uncertainty import AssumedErrors, speed_uncertainty

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "ChairVelocity",
    "VelocitySettings",
    "estimate_velocity",
    "linear_velocity",
    "printed_yaw_gain",
    "single_wheel_velocity",
    "wheel_spin_rate",
    "wheel_spin_rate_printed",
    "wheel_yaw_rate",
]


def wheel_spin_rate(
    gyr_axle_radps: ArrayLike, yaw_rate_radps: ArrayLike, camber_rad: float, *, side: Side
) -> FloatArray:
    """Spin of one wheel about its own axle (eq. 1.16, corrected form).

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
    lean = side_sign(side) * np.sin(as_number(camber_rad, "camber_rad", negative=True))
    axle, yaw_rate = alike(gyr_axle_radps=gyr_axle_radps, yaw_rate_radps=yaw_rate_radps)
    return np.asarray(axle - yaw_rate * lean)


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
    gyr = as_vectors(gyr_wheel_radps, "gyr_wheel_radps", ndim=2)
    camber_rad = as_number(camber_rad, "camber_rad", negative=True)
    across = np.hypot(gyr[:, 0], gyr[:, 1])
    return np.asarray(gyr[:, 2] + side_sign(side) * across * np.tan(camber_rad))


def linear_velocity(
    rate_left_radps: ArrayLike, rate_right_radps: ArrayLike, geometry: WheelchairGeometry
) -> FloatArray:
    """Chair's forward velocity from both wheels (eq. 1.17, forward spin positive on both sides).

    The document subtracts the right wheel: in its Figure 1 the wheels' axes point outward, and the
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

    The document adds the wheels. With the outward axes of its Figure 1 that is positive in turns to
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
    return (right - left) / as_number(distance_m, "distance_m")


def _rolling_speeds(
    rate_left: ArrayLike, rate_right: ArrayLike, geometry: WheelchairGeometry
) -> tuple[FloatArray, FloatArray]:
    expect("geometry", geometry, WheelchairGeometry)
    left, right = alike(rate_left_radps=rate_left, rate_right_radps=rate_right)
    return geometry.wheel_radius_m.left * left, geometry.wheel_radius_m.right * right


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
    expect("geometry", geometry, WheelchairGeometry)
    rate, yaw_rate = alike(rate_axle_radps=rate_axle_radps, yaw_rate_radps=yaw_rate_radps)
    centre = geometry.wheel_centre(side)[1]
    return np.asarray(geometry.wheel_radius_m.of(side) * rate + centre * yaw_rate)


@dataclass(frozen=True)
class VelocitySettings:
    """How velocities are found from a recording.

    Parameters
    ----------
    form : "corrected" takes the yaw rate's part out of each wheel with its sign; "printed" uses
        the root of (1.16) with the fixed signs that the public tool gives it
    slip_correction : whether the speed is corrected where the wheels disagree
    slip_method : "wheels" takes the speed from the wheel that still rolls, "tool" integrates the
        frame's acceleration (:func:`~mobility_imu.wheelchair.slip.correct_slip`). The printed form
        tells no wheel from the other: its correction needs "tool"
    slip : SlipSettings, when a disagreement counts as slip
    take_off_offsets : whether the gyroscopes' offsets are found at rest and taken off; the printed
        form never does
    assumed : AssumedErrors of geometry and sensors, for the standard deviations

    Raises
    ------
    InputError
        If an option has none of its values, or the printed form is to be corrected by "wheels".

    Examples
    --------
    >>> VelocitySettings(form="printed", slip_correction=True, slip_method="tool").form
    'printed'
    """

    form: Form = "corrected"
    slip_correction: bool = False
    slip_method: SlipMethod = "wheels"
    slip: SlipSettings = field(default_factory=SlipSettings)
    take_off_offsets: bool = True
    assumed: AssumedErrors = field(default_factory=AssumedErrors)

    def __post_init__(self) -> None:
        """Check the options."""
        one_of("form", self.form, ("corrected", "printed"))
        one_of("slip_correction", self.slip_correction, (True, False))
        one_of("slip_method", self.slip_method, ("wheels", "tool"))
        expect("slip", self.slip, SlipSettings)
        one_of("take_off_offsets", self.take_off_offsets, (True, False))
        expect("assumed", self.assumed, AssumedErrors)
        if self.form == "printed" and self.slip_correction and self.slip_method == "wheels":
            raise InputError(
                "slip_method = 'wheels': eq. 1.16 as printed tells no wheel from the other; "
                "correct its speed with slip_method='tool'"
            )


@dataclass(frozen=True, eq=False, repr=False)
class ChairVelocity(Result):
    """Velocities of the chair on the recording's clock.

    Parameters
    ----------
    time_s : (n,) array, s
    linear_velocity_mps : (n,) array, m/s, forward positive
    yaw_rate_radps : (n,) array, rad/s, from the frame's gyroscope, left positive
    wheel_yaw_rate_radps : (n,) array, rad/s, the same from the wheels: they differ when one slips;
        NaN where only one wheel has a sensor
    slip : (n,) bool array, True where the two yaw rates differ too much and for too long; False
        where a gyroscope is at the end of its range, which tells nothing
    linear_velocity_sd_mps : (n,) array, m/s, standard deviation of the speed: noise, offsets and
        scale of the gyroscopes, radii, axles, timing, rocking; with two wheels their disagreement
        with the frame, with one wheel track and camber. Sizes: ``settings.assumed``. A slip of
        both wheels alike, or of the only one, is not seen and not contained. Infinite where a
        gyroscope that is needed fails (repeats itself, or is at the end of its range) and the two
        others do not replace it
    yaw_rate_sd_radps : (n,) array, rad/s, standard deviation of the frame's yaw rate, infinite
        likewise
    offsets : sensor to GyroscopeOffset that was taken off; empty if none was
    settings : VelocitySettings that were used
    warnings : sentences on what limits the result; empty if nothing does
    valid : (n,) bool array, False where a gyroscope that is needed fails and nothing replaces it;
        all True if None
    """

    time_s: FloatArray
    linear_velocity_mps: FloatArray
    yaw_rate_radps: FloatArray
    wheel_yaw_rate_radps: FloatArray
    slip: NDArray[np.bool_]
    linear_velocity_sd_mps: FloatArray
    yaw_rate_sd_radps: FloatArray
    offsets: dict[str, GyroscopeOffset] = field(default_factory=dict)
    settings: VelocitySettings = VelocitySettings()
    warnings: tuple[str, ...] = ()
    valid: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        """Check that all are series of one length."""
        expect("settings", self.settings, VelocitySettings)
        rates = ("yaw_rate_radps", "wheel_yaw_rate_radps", "yaw_rate_sd_radps")
        speeds = ("linear_velocity_mps", "linear_velocity_sd_mps")
        if self.valid is None:
            known = np.ones(as_floats(self.time_s, "time_s").size, np.bool_)
            object.__setattr__(self, "valid", known)
        check_columns(self, "time_s", *speeds, *rates, flags=("slip", "valid"))
        object.__setattr__(self, "offsets", as_offsets(self.offsets))
        check_fields(self)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time_s)

    @property
    def sampling_rate_hz(self) -> float:
        """Samples per second, from the whole length."""
        return round(float((len(self) - 1) / (self.time_s[-1] - self.time_s[0])), 6)

    def to_frame(self) -> pd.DataFrame:
        """Columns of the velocity CSV, the yaw rate in deg/s.

        Returns
        -------
        DataFrame
            ``time_s``, ``linear_velocity_mps``, ``yaw_rate_degps``, ``slip`` (0 or 1),
            ``linear_velocity_sd_mps``, ``yaw_rate_sd_degps`` and ``valid`` (0 or 1)
        """
        import pandas as pd

        assert self.valid is not None

        return pd.DataFrame(
            {
                "time_s": self.time_s,
                "linear_velocity_mps": self.linear_velocity_mps,
                "yaw_rate_degps": np.rad2deg(self.yaw_rate_radps),
                "slip": self.slip.astype(int),
                "linear_velocity_sd_mps": self.linear_velocity_sd_mps,
                "yaw_rate_sd_degps": np.rad2deg(self.yaw_rate_sd_radps),
                "valid": self.valid.astype(int),
            }
        )


@overload
def estimate_velocity(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings | None = None,
    *,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
    executor: Any = None,
) -> ChairVelocity: ...


@overload
def estimate_velocity(
    recording: Sequence[Recording],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings | None = None,
    *,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
    executor: Any = None,
) -> list[ChairVelocity]: ...


def estimate_velocity(
    recording: Recording | Sequence[Recording],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings | None = None,
    *,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
    executor: Any = None,
) -> ChairVelocity | list[ChairVelocity]:
    """Chair velocity and yaw rate of one recording or several (eqs 1.16-1.18).

    The gyroscopes' offsets are found where the chair rests, and taken off
    (:mod:`mobility_imu.offsets`); the printed form takes nothing off.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel, or a list of them. One wheel
        may be missing: the other and the frame then give the speed, with a warning, and slip
        cannot be seen
    geometry : WheelchairGeometry
    mount : WheelchairMount, from :func:`~mobility_imu.wheelchair.calibration.calibrate_mount`
    settings : VelocitySettings; the corrected form without slip correction if None
    offsets : sensor to GyroscopeOffset of other recordings of that day, such as
        ``calibration.offsets``; they help where the recording rests shortly or not at all. Without
        any, nothing is taken off, with a warning
    executor : anything with ``submit``, for a list
        (:func:`~mobility_imu.executors.run_all`); None computes here

    Returns
    -------
    ChairVelocity
        for a list of recordings a list of them, in its order

    Raises
    ------
    InputError
        If a sensor or a gyroscope is missing, or the wheels turn against the frame (left and right
        swapped).
    """
    expect("geometry", geometry, WheelchairGeometry)
    expect("mount", mount, WheelchairMount)
    settings = settings_or_default("settings", settings, VelocitySettings)
    offsets = as_offsets(offsets)
    return for_each(
        _one_recording,
        recording,
        executor,
        geometry=geometry,
        mount=mount,
        settings=settings,
        offsets=offsets,
    )


def _one_recording(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings,
    offsets: Mapping[str, GyroscopeOffset],
) -> ChairVelocity:
    present = [side for side in SIDES if f"{side}_wheel" in recording.sensors]
    names = ["frame", *(f"{side}_wheel" for side in present or SIDES)]
    there, source = with_gyroscope(recording, names), recording
    warnings = saturation_warnings(recording, saturated_gyroscopes(recording, there))
    failed = failed_gyroscopes(recording, there, mount, geometry)
    if settings.form == "printed" or not settings.take_off_offsets:
        offsets = {}
    else:
        found = merge_offsets(rest_offsets(recording, names, skip=failed), offsets)
        offsets = {name: found[name] for name in names if name in found}
        warnings = (*offset_warnings(recording, offsets, names), *warnings)
        recording = without_offsets(recording, offsets)
    rates = _rates(recording, mount, present or SIDES)
    both = len(present) == 2
    needed = names[1:] if both else names
    lost = failed
    if settings.form == "corrected":
        forces = wheel_forces(recording, mount) if failed else {}
        rates, lost = recovered(rates, forces, failed, geometry, recording.sampling_rate_hz)
        warnings += recovery_warnings(source, failed, lost)
    velocity, wheel_yaw, slip = (_from_two_wheels if both else _from_one_wheel)(
        recording, geometry, mount, rates, settings, usable_samples(len(recording), failed)
    )
    yaw_rate = rates["frame"][:, 2]
    if both and settings.form == "corrected":
        warnings += at_odds(slip, wheel_yaw, yaw_rate, settings.slip, source.source)
    steps = coarse_steps(source, there, failed)
    rate, errors, widened = recording.sampling_rate_hz, settings.assumed, with_steps(offsets, steps)
    apart = wheel_yaw - yaw_rate if both else None
    sd = speed_uncertainty(rates, apart, geometry, mount, rate, offsets=widened, errors=errors)
    if both:
        sd = with_recovered_sd(sd, rates, failed, geometry, mount, rate, widened, errors)
    valid = usable_samples(len(recording), {n: lost[n] for n in names if n in lost})
    return ChairVelocity(
        time_s=recording.time_s,
        linear_velocity_mps=as_series(velocity, f"{recording.source}: linear velocity"),
        yaw_rate_radps=yaw_rate,
        wheel_yaw_rate_radps=wheel_yaw,
        slip=slip,
        linear_velocity_sd_mps=unknown_where(sd.linear_velocity_sd_mps, lost, needed),
        yaw_rate_sd_radps=unknown_where(sd.yaw_rate_sd_radps, lost, ["frame"]),
        offsets=dict(offsets),
        settings=settings,
        warnings=(
            *alone(recording, present),
            *warnings,
            *coarse(source, steps),
            *backward(recording, velocity, geometry),
        ),
        valid=valid,
    )


def _rates(
    recording: Recording, mount: WheelchairMount, sides: Sequence[Side]
) -> dict[str, FloatArray]:
    """Rates in the axes of the chair and of the wheels."""
    try:
        return {"frame": mount.frame(recording.gyroscope("frame"))} | {
            f"{side}_wheel": mount.wheel(side, recording.gyroscope(f"{side}_wheel"))
            for side in sides
        }
    except InputError as error:
        where = "" if recording.source in str(error) else f"{recording.source}: "
        raise InputError(f"{where}{error}") from None


def _from_two_wheels(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    rates: Mapping[str, FloatArray],
    settings: VelocitySettings,
    usable: NDArray[np.bool_],
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Speed, wheels' yaw rate and slip."""
    yaw_rate = rates["frame"][:, 2]
    corrected = settings.form == "corrected"
    if corrected:
        left, right = (
            wheel_spin_rate(rates[f"{side}_wheel"][:, 2], yaw_rate, geometry.camber_rad, side=side)
            for side in SIDES
        )
    else:
        left, right = (
            wheel_spin_rate_printed(rates[f"{side}_wheel"], geometry.camber_rad, side=side)
            for side in SIDES
        )
    # The document pairs its spin with the wheel-centre distance.
    distance = geometry.track_m if corrected else geometry.wheel_centre_distance_m
    velocity = linear_velocity(left, right, geometry)
    wheel_yaw = wheel_yaw_rate(left, right, geometry, distance_m=distance)
    _refuse_swapped_wheels(recording, yaw_rate, wheel_yaw)
    fs = recording.sampling_rate_hz
    windows = detect_slip(yaw_rate, np.where(usable, wheel_yaw, yaw_rate), fs, settings.slip)
    if settings.slip_correction:
        velocity = correct_slip(
            velocity,
            mount.frame(recording.sensor("frame").acc_mps2)[:, 0],
            windows,
            fs,
            settings.slip,
            wheels=wheel_speeds(velocity, wheel_yaw, yaw_rate, geometry),
            method=settings.slip_method,
        )
    return velocity, wheel_yaw, windows.flags(len(recording))


def _from_one_wheel(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    rates: Mapping[str, FloatArray],
    settings: VelocitySettings,
    usable: NDArray[np.bool_],
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Speed; there is no yaw rate of the wheels, and no slip can be seen, usable or not."""
    del usable
    (side,) = (side for side in SIDES if f"{side}_wheel" in rates)
    if settings.form == "printed":
        raise InputError(
            f"{recording.source}: eq. 1.16 as printed needs both wheels, found the {side}"
        )
    velocity = single_wheel_velocity(
        rates[f"{side}_wheel"][:, 2], rates["frame"][:, 2], geometry, side=side
    )
    count = len(recording)
    return velocity, np.full(count, np.nan), np.zeros(count, bool)


def _refuse_swapped_wheels(
    recording: Recording, yaw_rate: FloatArray, wheel_yaw: FloatArray
) -> None:
    """In a second of turning, wheels that were swapped turn the other way."""
    turning = np.abs(yaw_rate) > 0.3
    if turning.sum() < recording.sampling_rate_hz:
        return
    gain = float(yaw_rate[turning] @ wheel_yaw[turning] / (yaw_rate[turning] @ yaw_rate[turning]))
    if gain < -0.3:
        raise InputError(
            f"{recording.source}: the wheels' yaw rate is {gain:.2f} times the frame's, expected "
            "about 1: left and right wheel are swapped, or the frame's sensor is upside down, or "
            "the straight-line trial was driven backward"
        )
