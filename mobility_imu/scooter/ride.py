"""From the recording of a ride to both angles, with standard deviations and flags."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.arguments import check_columns, expect, for_each, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.filters import median_filter
from mobility_imu.frames import (
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_count,
    as_number,
    one_of,
    wrap_angle,
)
from mobility_imu.quality import frozen_samples, saturated_samples, turned_gravity
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.scooter.angles import (
    ACCELERATED_FRACTION,
    LARGEST_ERROR_RAD,
    Form,
    angle_standard_deviations,
    estimate_angles,
)
from mobility_imu.scooter.force import ends_in_a_jump, forceless, held_samples, wrong_length
from mobility_imu.scooter.fusion import LARGEST_VALID_SD_RAD, FusedAngles, fuse_angles
from mobility_imu.scooter.fusion_noise import acceleration_noise, smallest_step
from mobility_imu.scooter.fusion_settings import SETTING_LIMITS, FusionSettings
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.uncertain import uncertain_angles

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["LOSSES", "Remark", "RideAngles", "RideSettings", "estimate_ride", "usable_samples"]

Method = Literal["closed-form", "fusion"]
LOSSES = {"frozen": "frozen", "range": "saturated", "no gravity": "weightless"}
"""Words for the faults of an accelerometer that take some samples from it."""
REMARKS = (*LOSSES, "scale", "accelerated", "estimate", "uncertain", "settings")
"""Codes of the remarks."""
LARGEST_STATED_MPS2 = 100.0
"""Largest noise of an accelerometer that settings may state."""
SMALLEST_STATED_MPS2 = SETTING_LIMITS["acc_sd_mps2"][0]
"""Smallest one that fusion can compute with."""
NOISE_TIMES = 3.0
"""A recording with more noise than so many times the stated one was not made at rest: shaking is
ten times what a data sheet says of the sensor, and the filter has to know it."""
ASSUMED_TURN_SD_RAD = FusionSettings().misalignment_sd_rad
"""What fusion assumes of a mount unless settings say otherwise."""
LEAST_VALID = 0.5
"""Part of the samples below which a ride says why so few are valid."""
PAPER_MEDIAN_S = (0.2, 0.3)
"""Length of a median that passes for the paper's, which is 0.25 s."""
ODDS_S = 1.0
"""Time over which accelerations are averaged before fused angles are held against them."""
LARGEST_ANGLE_RAD = float(np.deg2rad(270.0))
"""No control turns so far: a filter that is there has gone round once."""


@dataclass(frozen=True)
class RideSettings:
    """How the angles of a ride are estimated.

    Parameters
    ----------
    method : "closed-form" (accelerations, sample by sample) or "fusion" (gyroscopes as well)
    single_imu : whether the lever's IMU is used alone, on level ground; closed form only
    form : of the closed form, see :func:`~mobility_imu.scooter.angles.estimate_angles`
    median_window : samples of the running median before the closed form, odd; 1 for none
    acc_noise_mps2 : m/s², noise (1 sd, per axis) of each accelerometer, for the closed form after
        the median. Without it the closed form states no standard deviation, and fusion takes the
        noise from the recording; so it does, with a warning, where that is ``NOISE_TIMES`` as large
    smooth : whether fusion uses the whole recording; False uses the past only
    fusion : FusionSettings; ``acc_noise_mps2``, if it is used, takes the place of its noise

    Raises
    ------
    InputError
        An unknown option, a number that cannot be, or fusion with a single IMU.
    """

    method: Method = "closed-form"
    single_imu: bool = False
    form: Form = "corrected"
    median_window: int = 25
    acc_noise_mps2: float | None = None
    smooth: bool = True
    fusion: FusionSettings = field(default_factory=FusionSettings)

    def __post_init__(self) -> None:
        """Check every option."""
        one_of("method", self.method, ("closed-form", "fusion"))
        one_of("form", self.form, ("corrected", "printed"))
        one_of("single_imu", self.single_imu, (False, True))
        one_of("smooth", self.smooth, (False, True))
        expect("fusion", self.fusion, FusionSettings)
        window = as_count(self.median_window, "median_window")
        if window % 2 == 0:
            raise InputError(f"median_window = {window}: expected an odd number of samples")
        object.__setattr__(self, "median_window", window)
        if self.method == "fusion" and self.single_imu:
            raise InputError("method = 'fusion': needs both IMUs, but single_imu is True")
        if self.acc_noise_mps2 is not None:
            closed = self.method == "closed-form"
            noise = as_number(self.acc_noise_mps2, "acc_noise_mps2", zero=closed)
            if noise > LARGEST_STATED_MPS2:
                raise InputError(
                    f"acc_noise_mps2 = {noise:g}: expected at most {LARGEST_STATED_MPS2:g} m/s²"
                )
            if noise < SMALLEST_STATED_MPS2 and not closed:
                raise InputError(
                    f"acc_noise_mps2 = {noise:g}: expected at least {SMALLEST_STATED_MPS2:g} m/s² "
                    "with method = 'fusion'"
                )
            object.__setattr__(self, "acc_noise_mps2", noise)

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the sensors that are used."""
        return ("lever",) if self.single_imu else ("lever", "body")


class Remark(NamedTuple):
    """What an estimate says of a ride.

    Parameters
    ----------
    code : "frozen", "range", "no gravity" or "scale", as the :class:`~mobility_imu.faults.Fault` of
        the same kind; "accelerated" of sensors that were pushed; "estimate" of angles that few
        samples show or that contradict the readings; "uncertain" of angles that are so by more than
        the paper's errors; "settings" of what a setting says
    sensor : accelerometer that it is about, such as "lever_acc"; empty for the ride
    sentence : for the user
    """

    code: str
    sensor: str
    sentence: str


@dataclass(frozen=True, eq=False, repr=False)
class RideAngles(Result):
    """Steering and throttle of a ride.

    Parameters
    ----------
    time_s : (n,) array, s, the recording's clock
    steering_rad, throttle_rad : (n,) arrays, rad, positive to the left and with the lever pushed
    steering_sd_rad, throttle_sd_rad : (n,) arrays, rad, one standard deviation by the sensors'
        noise; NaN for the closed form without a stated noise
    valid : (n,) bool array: the method trusts the sample, no accelerometer that is used is frozen,
        saturated, weightless or out of scale, no such loss is within half the closed form's median
        (a rest in coarse steps is none), and the accelerations do not contradict the filter
    settings : RideSettings; with fusion, ``settings.fusion`` has the sizes that were used
    remarks : what the estimate says of the ride
    warnings : sentences of the remarks, for the user

    Raises
    ------
    InputError
        Columns that are no series of one length, and remarks that are none.
    """

    time_s: FloatArray
    steering_rad: FloatArray
    throttle_rad: FloatArray
    steering_sd_rad: FloatArray
    throttle_sd_rad: FloatArray
    valid: NDArray[np.bool_]
    settings: RideSettings
    remarks: tuple[Remark, ...] = field(default=(), repr=False)
    warnings: tuple[str, ...] = field(default=(), init=False)

    def __post_init__(self) -> None:
        """Check that all are series of one length, and that the remarks are some."""
        expect("settings", self.settings, RideSettings)
        numbers = ("steering_rad", "throttle_rad", "steering_sd_rad", "throttle_sd_rad")
        check_columns(self, "time_s", *numbers, flags=("valid",))
        check_fields(self, remarks=[Remark])
        for remark in self.remarks:
            one_of("code of a remark", remark.code, REMARKS)
            expect("sensor of a remark", remark.sensor, str)
            expect("sentence of a remark", remark.sentence, str)
        object.__setattr__(self, "warnings", tuple(one.sentence for one in self.remarks))
        super().__post_init__()

    def to_frame(self) -> pd.DataFrame:
        """Table of ``mobility-imu scooter angles``: time, both angles and their sd in deg, valid.

        Returns
        -------
        DataFrame
            ``time_s``, ``steering_deg``, ``throttle_deg``, ``steering_sd_deg``,
            ``throttle_sd_deg``, ``valid`` (1 or 0)
        """
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.time_s,
                "steering_deg": np.rad2deg(self.steering_rad),
                "throttle_deg": np.rad2deg(self.throttle_rad),
                "steering_sd_deg": np.rad2deg(self.steering_sd_rad),
                "throttle_sd_deg": np.rad2deg(self.throttle_sd_rad),
                "valid": self.valid.astype(int),
            }
        )


@overload
def estimate_ride(
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None = None,
    settings: RideSettings | None = None,
    *,
    executor: Any = None,
) -> RideAngles: ...


@overload
def estimate_ride(
    recording: Sequence[Recording],
    geometry: ScooterGeometry,
    mount: ScooterMount | None = None,
    settings: RideSettings | None = None,
    *,
    executor: Any = None,
) -> list[RideAngles]: ...


def estimate_ride(
    recording: Recording | Sequence[Recording],
    geometry: ScooterGeometry,
    mount: ScooterMount | None = None,
    settings: RideSettings | None = None,
    *,
    executor: Any = None,
) -> RideAngles | list[RideAngles]:
    """Steering and throttle angles of one ride, or of several.

    Parameters
    ----------
    recording : Recording, or a list of them, with a sensor ``lever`` and, unless it is used alone,
        ``body``; fusion needs the gyroscopes of both
    geometry : ScooterGeometry
    mount : ScooterMount that is applied to the readings; None takes the IMUs' axes for {T} and {B}
    settings : RideSettings; None is the default
    executor : for a list, anything with ``submit``, which then gets one task per recording

    Returns
    -------
    RideAngles, or a list of them in the order of the recordings

    Raises
    ------
    InputError
        A sensor or gyroscope that is missing, a recording that is shorter than the median or too
        slow for fusion, accelerations in g, or with gravity in the wrong direction. The message
        begins with the recording's source.

    Examples
    --------
    >>> import numpy as np
    >>> from mobility_imu.recording import Imu, Recording
    >>> from mobility_imu.scooter import SUZUKI_ET4D, estimate_ride
    >>> noise = np.random.default_rng(1).normal(0, 0.02, (2, 100, 3))
    >>> body, lever = noise + [[[0.0, 0.0, 9.807]], [[1.677, -2.256, 9.395]]]
    >>> sensors = {"lever": Imu(lever), "body": Imu(body)}
    >>> ride = estimate_ride(Recording(np.arange(100) / 100, sensors), SUZUKI_ET4D)
    >>> ride.to_frame()[["steering_deg", "throttle_deg"]].mean().round().tolist()
    [30.0, 20.0]
    """
    expect("geometry", geometry, ScooterGeometry)
    expect("mount", mount, ScooterMount, none=True)
    settings = settings_or_default("settings", settings, RideSettings)
    return for_each(
        _estimate, recording, executor, geometry=geometry, mount=mount, settings=settings
    )


def _estimate(
    ride: Recording, geometry: ScooterGeometry, mount: ScooterMount | None, settings: RideSettings
) -> RideAngles:
    if "body" in settings.sensors and "body" not in ride.sensors:
        raise InputError(
            f"{ride.source}: no sensor 'body'; with the lever's IMU alone set single_imu=True"
        )
    acc = {name: ride.sensor(name).acc_mps2 for name in settings.sensors}
    closed = settings.method == "closed-form"
    beside = settings.median_window // 2 if closed else 0
    usable, remarks = usable_samples(ride, settings.sensors, beside)
    if settings.method == "fusion":
        gyr = {name: ride.gyroscope(name) for name in settings.sensors}
    try:
        if settings.method == "fusion":
            quiet = _quieter_than_it_is(settings, acc)
            own = _fusion_settings(settings, acc, mount, stated=not quiet)
            settings = dataclasses.replace(settings, fusion=own)
            angles, used, odds = _fused(acc, gyr, ride.sampling_rate_hz, geometry, mount, settings)
            settings = dataclasses.replace(settings, fusion=used)
            said = [*quiet, *_less_known_than_assumed(own, mount)]
        else:
            angles, accelerated = _closed_form(acc, geometry, mount, settings)
            scaled = _out_of_scale(acc, ride.sampling_rate_hz)
            # No acceleration lasts for a whole ride.
            odds = scaled or tuple(Remark("accelerated", "", text) for text in accelerated)
            said = _median_warnings(settings.median_window, ride.sampling_rate_hz)
    except InputError as error:
        raise InputError(f"{ride.source}: {error}") from None
    steering, throttle, steering_sd, throttle_sd, valid = angles
    remarks += [one._replace(sentence=f"{ride.source}: {one.sentence}") for one in odds]
    remarks += [Remark("settings", "", text) for text in said]
    if valid.mean() < LEAST_VALID and not odds:
        few = f"{ride.source}: {_few_valid(valid, settings.method)}"
        remarks.append(Remark("estimate", "", few))
    else:
        vague = uncertain_angles(steering_sd, throttle_sd, valid & usable)
        remarks += [Remark("uncertain", "", f"{ride.source}: {text}") for text in vague]
    return RideAngles(
        ride.time_s,
        steering,
        throttle,
        steering_sd,
        throttle_sd,
        valid & usable,
        settings,
        tuple(remarks),
    )


def _few_valid(valid: NDArray[np.bool_], method: Method) -> str:
    """Why few samples are valid although the sensors were hardly accelerated."""
    why = "fit no angles of the controls, or do not show the steering"
    if method == "fusion":
        why = f"leave the steering uncertain by {np.rad2deg(LARGEST_VALID_SD_RAD):.0f} deg or more"
    return (
        f"{valid.mean():.0%} of the samples are valid: the others {why}; look at the mount, at the "
        "inclinations of the geometry, and at the axes and names of the sensors"
    )


def usable_samples(
    ride: Recording, names: Sequence[str], beside: int = 0
) -> tuple[NDArray[np.bool_], list[Remark]]:
    """Samples in which no accelerometer is frozen, saturated or weightless; a sentence on others.

    Parameters
    ----------
    ride : Recording
    names : sensors that are looked at
    beside : samples on either side of a reading that a median has in it: beside a loss they are not
        usable. What stands still may be a rest in coarse steps; it is a loss if it ends in a jump,
        or with the recording

    Returns
    -------
    usable : (n,) bool array
    remarks : list of Remark
    """
    usable, remarks = np.ones(len(ride), bool), []
    for name in names:
        acc, rate_hz = ride.sensor(name).acc_mps2, ride.sampling_rate_hz
        frozen = frozen_samples(acc, rate_hz, follows=_felt(ride, name))
        # An accelerometer that is not in m/s², or dead throughout, is another matter.
        dead = forceless(acc, rate_hz)
        cut = saturated_samples(acc) & ~held_samples(acc, rate_hz, first=True)
        for (code, what), bad in zip(LOSSES.items(), (frozen & ~dead, cut, dead), strict=True):
            if bad.any():
                said = (
                    f"{ride.source}: {name}_acc is {what} in {int(bad.sum())} samples, first at "
                    f"{ride.time_s[np.argmax(bad)]:g} s; they are marked as not valid"
                )
                remarks.append(Remark(code, f"{name}_acc", said))
                usable &= ~bad
        lost = dead | ends_in_a_jump(acc, frozen, at_end=True)
        if beside and lost.any():
            usable &= ~ndimage.binary_dilation(lost, iterations=beside)
    return usable, remarks


def _felt(ride: Recording, name: str) -> list[FloatArray]:
    """What other sensors expect an accelerometer to feel: its gyroscope, and the body below it."""
    sensor, felt = ride.sensor(name), []
    if sensor.gyr_radps is not None:
        felt.append(turned_gravity(sensor.acc_mps2, sensor.gyr_radps, ride.sampling_rate_hz))
    if name == "lever" and "body" in ride.sensors:
        felt.append(ride.sensor("body").acc_mps2)
    return felt


def _turned(
    vectors: dict[str, FloatArray], mount: ScooterMount | None
) -> tuple[FloatArray, FloatArray | None]:
    """Readings of lever and body in {T} and {B}."""
    lever, body = vectors["lever"], vectors.get("body")
    if mount is None:
        return lever, body
    return mount.lever(lever), None if body is None else mount.body(body)


def _closed_form(
    acc: dict[str, FloatArray],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
    settings: RideSettings,
) -> tuple[tuple[Any, ...], tuple[str, ...]]:
    """Angles, standard deviations and flags, and warnings."""
    smooth = {name: median_filter(values, settings.median_window) for name, values in acc.items()}
    lever, body = _turned(smooth, mount)
    found = estimate_angles(lever, body, geometry, form=settings.form)
    sd: tuple[FloatArray, ...] = (np.full(len(lever), np.nan),) * 2
    noise = settings.acc_noise_mps2
    if noise is not None:
        sd = angle_standard_deviations(
            lever,
            found.steering_rad,
            found.throttle_rad,
            geometry,
            lever_sd_mps2=noise,
            body_sd_mps2=0.0 if body is None else noise,
        )
    return (found.steering_rad, found.throttle_rad, *sd, found.valid), found.warnings


def _median_warnings(window: int, sampling_rate_hz: float) -> list[str]:
    span = window / sampling_rate_hz
    low, high = PAPER_MEDIAN_S
    if window == 1 or low <= span <= high:
        return []
    odd = 2 * round(0.25 * sampling_rate_hz / 2 - 0.5) + 1
    return [
        f"a median of {window} samples is {span:.3g} s long at {sampling_rate_hz:g} Hz, the "
        f"paper's is 0.25 s: median_window = {odd} would be"
    ]


def _quieter_than_it_is(settings: RideSettings, acc: dict[str, FloatArray]) -> tuple[str, ...]:
    """Warning if the stated noise is far below that of the recording."""
    stated = settings.acc_noise_mps2
    if stated is None:
        return ()
    # Of the difference of both sensors; half of its variance is each one's.
    own = acceleration_noise(acc["lever"], acc["body"]) / 2**0.5
    if own <= NOISE_TIMES * stated:
        return ()
    return (
        f"a noise of {stated:.3g} m/s² is stated, the accelerations have {own:.2g} m/s² (with "
        "shaking): the standard deviations would be too small, so the recording's noise is taken",
    )


def _less_known_than_assumed(used: FusionSettings, mount: ScooterMount | None) -> tuple[str, ...]:
    """Warning if a mount states more than fusion assumes of one that was never calibrated."""
    if mount is None or mount.sd_rad is None:
        return ()
    part = float(np.median(mount.sd_rad)) / 2**0.5
    if part <= used.misalignment_sd_rad or used.misalignment_sd_rad != ASSUMED_TURN_SD_RAD:
        return ()
    stated, assumed = np.rad2deg([part, used.misalignment_sd_rad]) * 2**0.5
    return (
        f"the mount's sd_rad states {stated:.1f} deg (median), fusion assumes {assumed:.1f} deg at "
        "most: if the mount is known so badly, the angles' standard deviations are too small; "
        "calibrate it",
    )


def _fusion_settings(
    settings: RideSettings,
    acc: dict[str, FloatArray],
    mount: ScooterMount | None,
    *,
    stated: bool = True,
) -> FusionSettings:
    """Settings with what was stated beside them, and with what a calibration left of the mount."""
    fusion = settings.fusion
    if settings.acc_noise_mps2 is not None and stated:
        # The filter's noise is that of the difference of both sensors.
        fusion = dataclasses.replace(fusion, acc_sd_mps2=settings.acc_noise_mps2 * 2**0.5)
    if fusion.acc_step_mps2 is None:
        # Steps of the converters show in the sensors' own axes, before the mount turns them.
        step = smallest_step(acc["lever"], acc["body"])
        fusion = dataclasses.replace(fusion, acc_step_mps2=step)
    if mount is not None and mount.sd_rad is not None:
        fusion = fusion.after_calibration(mount.sd_rad)
    return fusion


def _fused(
    acc: dict[str, FloatArray],
    gyr: dict[str, FloatArray],
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
    settings: RideSettings,
) -> tuple[tuple[Any, ...], FusionSettings, tuple[Remark, ...]]:
    """Angles, standard deviations and flags; what was used; remarks."""
    lever_acc, body_acc = _turned(acc, mount)
    lever_gyr, body_gyr = _turned(gyr, mount)
    assert body_acc is not None and body_gyr is not None
    found = fuse_angles(
        lever_acc,
        lever_gyr,
        body_acc,
        body_gyr,
        sampling_rate_hz,
        geometry,
        settings.fusion,
        smooth=settings.smooth,
    )
    contradicted = _contradicted(found, lever_acc, body_acc, sampling_rate_hz, geometry)
    scaled = _out_of_scale(acc, sampling_rate_hz)
    if scaled:
        contradicted[:] = True
    angles = (
        found.steering_rad,
        found.throttle_rad,
        found.steering_sd_rad,
        found.throttle_sd_rad,
        found.valid & ~contradicted,
    )
    if scaled:
        return angles, found.settings, scaled
    own = tuple(Remark("estimate", "", text) for text in found.warnings)
    fraction = float(contradicted.mean())
    if fraction <= ACCELERATED_FRACTION:
        return angles, found.settings, own
    warning = (
        f"the filter's angles contradict the accelerations around them in {fraction:.0%} of the "
        f"samples, by more than {np.rad2deg(LARGEST_ERROR_RAD):.0f} deg and three standard "
        "deviations: it went astray, and these samples are marked as not valid; "
        "are the sensors worse than FusionSettings assumes?"
    )
    return angles, found.settings, (Remark("estimate", "", warning), *own)


def _contradicted(
    found: FusedAngles,
    lever_acc: FloatArray,
    body_acc: FloatArray,
    sampling_rate_hz: float,
    geometry: ScooterGeometry,
) -> NDArray[np.bool_]:
    """Where accelerations, averaged over a second, contradict the filter.

    A filter that has gone astray states a small standard deviation all the same. It has where the
    closed form gives other angles, and where an angle is beyond what any control has. Where the
    closed form is not valid it says nothing.
    """
    width = max(1, round(ODDS_S * sampling_rate_hz))
    lever, body, steering, throttle = (
        ndimage.uniform_filter1d(values, width, axis=0)
        for values in (lever_acc, body_acc, found.steering_rad, found.throttle_rad)
    )
    closed = estimate_angles(lever, body, geometry)
    bad = np.zeros(len(lever), np.bool_)
    for angle, by_force, sd in (
        (steering, closed.steering_rad, found.steering_sd_rad),
        (throttle, closed.throttle_rad, found.throttle_sd_rad),
    ):
        apart = np.abs(wrap_angle(by_force - angle))
        bad |= closed.valid & np.isfinite(apart) & (apart > LARGEST_ERROR_RAD + 3 * sd)
    for angle in (found.steering_rad, found.throttle_rad):
        bad |= np.abs(angle) > LARGEST_ANGLE_RAD
    return bad


def _out_of_scale(acc: dict[str, FloatArray], sampling_rate_hz: float) -> tuple[Remark, ...]:
    """Remarks on accelerometers that read a length of gravity which no sound sensor reads."""
    lengths = {name: wrong_length(values, sampling_rate_hz) for name, values in acc.items()}
    return tuple(
        Remark(
            "scale",
            f"{name}_acc",
            f"{name}_acc is out of scale and reads {length:.3g} m/s² of gravity, expected about "
            f"{STANDARD_GRAVITY_MPS2:.2f}; check the unit and the range that it was exported with; "
            "no sample is valid",
        )
        for name, length in lengths.items()
        if length is not None
    )
