"""Standard deviation of the chair's speed and yaw rate.

Errors are independent of each other and of first order. Radius, track, camber, scale, axes and
offsets have one value for a whole recording: no average over it makes them smaller.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from mobility_imu.arguments import check_limits, expect
from mobility_imu.frames import (
    FloatArray,
    as_floats,
    as_number,
    as_series,
    as_vectors,
    check_positive,
)
from mobility_imu.offsets import UNKNOWN_OFFSET_SD_RADPS, GyroscopeOffset
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.series import alike, as_rate

__all__ = [
    "AssumedErrors",
    "SpeedUncertainty",
    "frame_yaw_standard_deviation",
    "one_wheel_standard_deviation",
    "root_mean_square_over_a_push",
    "speed_uncertainty",
    "two_wheel_standard_deviation",
    "velocity_standard_deviation",
    "wheel_yaw_standard_deviation",
]

UNKNOWN_NOISE_RADPS = float(np.deg2rad(0.1))
"""Noise of one sample of a usual sensor of which no rest is known."""
LARGEST_ASSUMED = 1e6
"""Beyond this an assumed error says no more than this does, and its squares overflow."""
PUSH_S = 1.0
"""About a push: over this the wheels' disagreement and the chair's rocking are averaged."""


@dataclass(frozen=True)
class AssumedErrors:
    """Standard deviations of what no recording of a drive shows.

    Parameters
    ----------
    radius_sd : fraction of each wheel's radius: what a tape or a roll-out shows of a tyre that
        gives under load
    track_sd_m : m, a tape between the wheels' contacts
    camber_sd_rad : rad, a protractor on a spoked wheel
    scale_sd : fraction of each gyroscope's rate (usual data sheets: 0.3 to 0.5 %)
    axis_sd_rad : rad, each gyroscope's axis against the wheel's axle or the chair's vertical
    timing_sd_samples : samples; a sensor's row stands for some time within one step, all of them
        alike likely
    point_height_m : m, of the point of the chair whose speed is meant, over the wheels' centres: a
        seat's. While the chair rocks, its speed differs by the pitch rate times this height

    Raises
    ------
    InputError
        If a value is no finite number of 0 or more, or beyond 1e6.
    """

    radius_sd: float = 0.005
    track_sd_m: float = 0.01
    camber_sd_rad: float = float(np.deg2rad(1.0))
    scale_sd: float = 0.003
    axis_sd_rad: float = float(np.deg2rad(0.5))
    timing_sd_samples: float = 1 / float(np.sqrt(12))
    point_height_m: float = 0.25

    def __post_init__(self) -> None:
        """Check the numbers."""
        names = tuple(self.__dataclass_fields__)
        check_positive(self, *names, allow_zero=names)
        check_limits(self, dict.fromkeys(names, (0.0, LARGEST_ASSUMED)))


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
    expect("geometry", geometry, WheelchairGeometry)
    radius = geometry.wheel_radius_m
    gyr_sd_radps = as_number(gyr_sd_radps, "gyr_sd_radps", zero=True)
    radius_sd_m = as_number(radius_sd_m, "radius_sd_m", zero=True)
    left, right = alike(rate_left_radps=rate_left_radps, rate_right_radps=rate_right_radps)
    with np.errstate(over="ignore"):
        noise = gyr_sd_radps * np.hypot(*radius)
        return np.asarray(np.hypot(noise, radius_sd_m * np.hypot(left, right)) / 2)


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
    yaw, speed = alike(yaw_rate_radps=yaw_rate_radps, linear_velocity_mps=linear_velocity_mps)
    expect("geometry", geometry, WheelchairGeometry)
    gyr_sd_radps = as_number(gyr_sd_radps, "gyr_sd_radps", zero=True)
    radius_sd_m = as_number(radius_sd_m, "radius_sd_m", zero=True)
    distance_sd_m = as_number(distance_sd_m, "distance_sd_m", zero=True)
    radius, distance = geometry.wheel_radius_m, geometry.wheel_centre_distance_m
    left, right = speed - yaw * distance / 2, speed + yaw * distance / 2
    with np.errstate(over="ignore"):
        noise = gyr_sd_radps * np.hypot(*radius)
        sizes = radius_sd_m * np.hypot(left / radius.left, right / radius.right)
        return np.asarray(np.hypot(np.hypot(noise, sizes), yaw * distance_sd_m) / distance)


def frame_yaw_standard_deviation(
    rates_chair_radps: ArrayLike,
    mount: WheelchairMount,
    sampling_rate_hz: float,
    *,
    offset: GyroscopeOffset | None,
    errors: AssumedErrors,
) -> FloatArray:
    """Standard deviation of the frame's yaw rate: noise, offset, scale, axis, timing.

    Parameters
    ----------
    rates_chair_radps : (n, 3) array, rad/s, in the chair's axes
    mount : WheelchairMount
    sampling_rate_hz : Hz
    offset : of the frame's gyroscope, None if unknown
    errors : AssumedErrors

    Returns
    -------
    (n,) array, rad/s
    """
    expect("mount", mount, WheelchairMount)
    return _rate_standard_deviation(
        as_vectors(rates_chair_radps, "rates_chair_radps", ndim=2),
        mount.rotation_frame_imu_to_chair[2],
        sampling_rate_hz,
        offset,
        errors,
    )


def _rate_standard_deviation(
    rates: FloatArray,
    axis_imu: FloatArray,
    sampling_rate_hz: float,
    offset: GyroscopeOffset | None,
    errors: AssumedErrors,
) -> FloatArray:
    """Of the rate about z, rad/s; ``axis_imu`` is z in the sensor's axes."""
    expect("offset", offset, GyroscopeOffset, none=True)
    expect("errors", errors, AssumedErrors)
    constant = UNKNOWN_OFFSET_SD_RADPS, UNKNOWN_NOISE_RADPS
    if offset is not None:
        constant = offset.sd_along(axis_imu), offset.noise_along(axis_imu)
    return _root_sum(
        *constant,
        errors.scale_sd * rates[:, 2],
        errors.axis_sd_rad * np.hypot(rates[:, 0], rates[:, 1]),
        errors.timing_sd_samples * _change(rates[:, 2]),
    )


def _change(values: FloatArray) -> FloatArray:
    """Change of a series per sample."""
    return np.gradient(values) if len(values) > 1 else np.zeros_like(values)


def _root_sum(*parts: FloatArray | float) -> FloatArray:
    with np.errstate(over="ignore"):
        return np.asarray(np.sqrt(sum(np.square(part) for part in parts)))


def one_wheel_standard_deviation(
    rates_wheel_radps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    yaw_rate_sd_radps: ArrayLike,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    sampling_rate_hz: float,
    *,
    side: Side,
    offset: GyroscopeOffset | None,
    errors: AssumedErrors,
) -> FloatArray:
    """Standard deviation of the chair's speed from one wheel and the frame.

    Track and camber enter by the yaw rate, which carries the speed from the wheel to the middle.
    A slip of this wheel is not seen and not contained.

    Parameters
    ----------
    rates_wheel_radps : (n, 3) array, rad/s, wheel frame: z is the axle, positive rolling forward
    yaw_rate_radps, yaw_rate_sd_radps : (n,) arrays, rad/s, from the frame
    geometry : WheelchairGeometry
    mount : WheelchairMount
    sampling_rate_hz : Hz
    side : of the wheel
    offset : of the wheel's gyroscope, None if unknown
    errors : AssumedErrors

    Returns
    -------
    (n,) array, m/s
    """
    wheel, centre = _wheel_part(
        rates_wheel_radps,
        yaw_rate_radps,
        geometry,
        mount,
        sampling_rate_hz,
        side=side,
        offset=offset,
        errors=errors,
    )
    yaw, yaw_sd = alike(yaw_rate_radps=yaw_rate_radps, yaw_rate_sd_radps=yaw_rate_sd_radps)
    lean = geometry.wheel_radius_m.of(side) * np.cos(geometry.camber_rad)
    return _root_sum(
        wheel,
        centre * yaw_sd,
        errors.track_sd_m / 2 * yaw,
        lean * errors.camber_sd_rad * yaw,
    )


def _wheel_part(
    rates_wheel_radps: ArrayLike,
    yaw_rate_radps: ArrayLike,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    sampling_rate_hz: float,
    *,
    side: Side,
    offset: GyroscopeOffset | None,
    errors: AssumedErrors,
) -> tuple[FloatArray, float]:
    """Part of the wheel's radius and gyroscope, m/s, and the wheel centre's place, m."""
    expect("geometry", geometry, WheelchairGeometry)
    expect("mount", mount, WheelchairMount)
    rates = as_vectors(rates_wheel_radps, "rates_wheel_radps", ndim=2)
    yaw = as_floats(yaw_rate_radps, "yaw_rate_radps")
    radius = geometry.wheel_radius_m.of(side)
    axle_sd = _rate_standard_deviation(
        rates, mount.rotation_imu_to_wheel(side)[2], sampling_rate_hz, offset, errors
    )
    spin = rates[:, 2] - yaw * geometry.axle_direction(side)[2]
    part = _root_sum(radius * axle_sd, errors.radius_sd * radius * spin)
    return part, float(geometry.wheel_centre(side)[1])


def two_wheel_standard_deviation(
    rates_wheel_radps: Mapping[Side, ArrayLike],
    yaw_rate_radps: ArrayLike,
    disagreement_radps: ArrayLike,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    sampling_rate_hz: float,
    *,
    offsets: Mapping[Side, GyroscopeOffset | None],
    errors: AssumedErrors,
) -> FloatArray:
    """Standard deviation of the chair's speed from both wheels.

    Half of each wheel's error, and what the wheels' disagreement with the frame shows: a wheel
    that slips changes the wheels' yaw rate by its slip over the track, and the speed by half of
    the slip. Track and camber do not enter.

    Parameters
    ----------
    rates_wheel_radps : side to (n, 3) array, rad/s, wheel frame
    yaw_rate_radps : (n,) array, rad/s, from the frame
    disagreement_radps : (n,) array, rad/s, standard deviation of the wheels' yaw rate against the
        frame's (:func:`root_mean_square_over_a_push`)
    geometry : WheelchairGeometry
    mount : WheelchairMount
    sampling_rate_hz : Hz
    offsets : side to GyroscopeOffset, or None if unknown
    errors : AssumedErrors

    Returns
    -------
    (n,) array, m/s
    """
    (apart,) = alike(disagreement_radps=disagreement_radps)
    halves = [
        _wheel_part(
            rates,
            yaw_rate_radps,
            geometry,
            mount,
            sampling_rate_hz,
            side=side,
            offset=offsets.get(side),
            errors=errors,
        )[0]
        / 2
        for side, rates in rates_wheel_radps.items()
    ]
    return _root_sum(*halves, geometry.track_m / 2 * apart)


def root_mean_square_over_a_push(values: ArrayLike, sampling_rate_hz: float) -> FloatArray:
    """Root mean square of a series over the second around each sample.

    Parameters
    ----------
    values : (n,) array
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) array in the unit of the values
    """
    window = max(1, round(PUSH_S * as_rate(sampling_rate_hz)))
    with np.errstate(over="ignore"):
        mean_square = ndimage.uniform_filter1d(np.square(as_series(values, "values")), window)
    return np.asarray(np.sqrt(np.maximum(mean_square, 0.0)))


class SpeedUncertainty(NamedTuple):
    """Standard deviations of a chair's velocities.

    Parameters
    ----------
    linear_velocity_sd_mps : (n,) array, m/s
    yaw_rate_sd_radps : (n,) array, rad/s
    """

    linear_velocity_sd_mps: FloatArray
    yaw_rate_sd_radps: FloatArray


class SampleNoise(NamedTuple):
    """Noise of single samples in a chair's velocities, m/s and rad/s."""

    linear_velocity_sd_mps: float
    yaw_rate_sd_radps: float


def sample_noise(
    offsets: Mapping[str, GyroscopeOffset],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    *,
    both: bool,
) -> SampleNoise:
    """Noise of single samples, which is the part of the uncertainty that a filter makes smaller.

    Parameters
    ----------
    offsets : sensor to GyroscopeOffset; a sensor without one has the noise of a usual sensor
    geometry : WheelchairGeometry
    mount : WheelchairMount
    both : whether both wheels give the speed; the mount's one wheel and the frame do otherwise

    Returns
    -------
    SampleNoise
    """

    def noise(name: str, axis_imu: FloatArray) -> float:
        return offsets[name].noise_along(axis_imu) if name in offsets else UNKNOWN_NOISE_RADPS

    yaw = noise("frame", mount.rotation_frame_imu_to_chair[2])
    mounted = {
        "left": mount.rotation_left_imu_to_wheel,
        "right": mount.rotation_right_imu_to_wheel,
    }
    parts = {
        side: geometry.wheel_radius_m.of(side)
        * noise(f"{side}_wheel", mount.rotation_imu_to_wheel(side)[2])
        for side in SIDES
        if mounted[side] is not None
    }
    if both:
        return SampleNoise(float(_root_sum(*parts.values())) / 2, yaw)
    side, part = min(parts.items(), key=lambda item: item[1])
    return SampleNoise(float(np.hypot(part, geometry.wheel_centre(side)[1] * yaw)), yaw)


def speed_uncertainty(
    rates_radps: Mapping[str, FloatArray],
    disagreement_radps: FloatArray | None,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    sampling_rate_hz: float,
    *,
    offsets: Mapping[str, GyroscopeOffset],
    errors: AssumedErrors,
) -> SpeedUncertainty:
    """Standard deviations of speed and yaw rate of a recording with one wheel or two.

    Parameters
    ----------
    rates_radps : sensor to (n, 3) array, rad/s, in the axes of the chair and of the wheels
    disagreement_radps : (n,) array, rad/s, of the wheels' yaw rate and the frame's; None for one
        wheel
    geometry : WheelchairGeometry
    mount : WheelchairMount
    sampling_rate_hz : Hz
    offsets : sensor to GyroscopeOffset; a sensor without one has an unknown offset
    errors : AssumedErrors

    Returns
    -------
    SpeedUncertainty
    """
    frame = rates_radps["frame"]
    yaw_sd = frame_yaw_standard_deviation(
        frame, mount, sampling_rate_hz, offset=offsets.get("frame"), errors=errors
    )
    sides = [side for side in SIDES if f"{side}_wheel" in rates_radps]
    if disagreement_radps is None:
        (side,) = sides
        speed_sd = one_wheel_standard_deviation(
            rates_radps[f"{side}_wheel"],
            frame[:, 2],
            yaw_sd,
            geometry,
            mount,
            sampling_rate_hz,
            side=side,
            offset=offsets.get(f"{side}_wheel"),
            errors=errors,
        )
    else:
        speed_sd = two_wheel_standard_deviation(
            {side: rates_radps[f"{side}_wheel"] for side in sides},
            frame[:, 2],
            root_mean_square_over_a_push(disagreement_radps, sampling_rate_hz),
            geometry,
            mount,
            sampling_rate_hz,
            offsets={side: offsets.get(f"{side}_wheel") for side in sides},
            errors=errors,
        )
    rocking = root_mean_square_over_a_push(frame[:, 1], sampling_rate_hz)
    return SpeedUncertainty(_root_sum(speed_sd, errors.point_height_m * rocking), yaw_sd)
