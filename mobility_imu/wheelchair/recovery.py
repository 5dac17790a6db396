"""A gyroscope that fails for a while, replaced by the two others of the chair.

The speeds of the wheels' centres and the chair's yaw rate are tied by one equation,
r_R Om_R - r_L Om_L = d_c * yaw, as long as no wheel slips: any two of the three give the third.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.faults import Repair, with_half
from mobility_imu.frames import FloatArray
from mobility_imu.health import frozen_gyroscope
from mobility_imu.offsets import (
    UNKNOWN_OFFSET_SD_RADPS,
    GyroscopeOffset,
    rest_offsets,
    without_offsets,
)
from mobility_imu.quality import LARGEST_OFFSET_RADPS, Resolution, resolution_of, same_as_before
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.saturation import saturated_gyroscopes, usable_samples
from mobility_imu.wheelchair.turning import upward_angle, yaw_rate_of_wheel
from mobility_imu.wheelchair.uncertainty import (
    UNKNOWN_NOISE_RADPS,
    AssumedErrors,
    SpeedUncertainty,
    one_wheel_standard_deviation,
    wheel_yaw_standard_deviation,
)

__all__ = [
    "failed_gyroscopes",
    "held_samples",
    "others_of",
    "recovered",
    "recovery_warnings",
    "replaced",
    "tied_rate",
    "unknown_where",
    "unreplaced",
    "wheel_forces",
    "with_gyroscope",
    "with_recovered_sd",
]

Flags = NDArray[np.bool_]
CHAIR = ("frame", "left_wheel", "right_wheel")
FEWEST_AT_END = 3
"""Samples at the end of a range; fewer are a peak that happens to be as high."""
LEAST_TURNED_RAD, LEAST_CORRELATION = np.pi / 2, 0.98
"""Turn of the chair, and agreement, by which the wheels' own yaw rate shows that it can be used.
Set by hand, like the limits without a reason below, on simulated courts that the study of faults
does not use."""
SHORTEST_HELD = 4
"""Fewer equal readings in a row are not looked at."""
LARGEST_CHANCE, LEAST_CHANCE = 1e-3, 0.02
"""Of a repetition by noise alone (three sensors then alarm in 0.3 % of sound drives at most); three
axes repeat together at least so often."""
JUMP_PART = 0.1
"""A repetition that ends in a change as large as so few are hid a motion; by chance, so few do."""
FEWEST_CHANGES = 50
"""Of fewer changes a correlation says little."""
QUIETEST = 0.2
"""Part of the changes, the smallest, that noise makes rather than motion."""
LEAST_CHANGE_RADPS = 1e-5
"""A tenth of the finest steps that are sold; smaller changes are those of a computer's numbers."""
BACK_AND_FORTH = -0.1
"""Correlation of one change with the next: -0.5 for white noise, near 1 for exact readings."""
GRAVITY_S = 0.3
"""The turning of gravity is averaged over this: a quarter of a turn of a wheel at 1.5 m/s."""
LONGEST_SLIP_S, MOSTLY_APART = 2.0, 0.5
"""A repetition that lasts longer, and that the others contradict most of the time, is no slip."""


def failed_gyroscopes(
    recording: Recording,
    sensors: Sequence[str],
    mount: WheelchairMount,
    geometry: WheelchairGeometry,
) -> dict[str, Flags]:
    """Where gyroscopes repeat their last reading, or are at the end of their range.

    Exact readings of a steady motion, as simulated, repeat themselves as well: where no gyroscope
    has noise, a repetition counts if the others contradict it for long, or if the sensor's
    accelerometer, on a wheel that turns, repeats itself too. Gyroscopes none of which ever changes
    its reading contradict nothing: all of them count.

    Parameters
    ----------
    recording : Recording as it came, with offsets
    sensors : names
    mount : WheelchairMount
    geometry : WheelchairGeometry

    Returns
    -------
    dict from sensor to (n,) bool array; without the sensors that work throughout
    """
    rate = recording.sampling_rate_hz
    found = {
        name: flags
        for name, flags in saturated_gyroscopes(recording, sensors).items()
        if flags.sum() >= FEWEST_AT_END
    }
    frozen = {
        name: frozen_gyroscope(recording.sensor(name).acc_mps2, recording.gyroscope(name), rate)
        | held_samples(recording.gyroscope(name), recording.sensor(name).acc_mps2)
        for name in sensors
    }
    if not any(flags.any() for flags in frozen.values()):
        return found
    along = _along(recording, sensors, mount)
    noisy = any(_is_noisy(recording.gyroscope(n)[~flags]) for n, flags in frozen.items())
    noisy |= _none_says_anything(recording, sensors)
    for name, flags in frozen.items():
        real = flags if noisy else _contradicted(recording, name, flags, along, geometry)
        if real.any():
            found[name] = found[name] | real if name in found else real
    return found


def _none_says_anything(recording: Recording, sensors: Sequence[str]) -> bool:
    """Whether all gyroscopes read one number throughout, which may be an offset and is no spin."""
    rates = [recording.gyroscope(name) for name in sensors]
    return all(
        not np.ptp(rate, axis=0).any() and np.abs(rate).max() <= LARGEST_OFFSET_RADPS
        for rate in rates
    )


def held_samples(gyr_radps: FloatArray, acc_mps2: FloatArray | None = None) -> Flags:
    """Repetitions of a gyroscope, or of both halves, that are too long for chance by its noise.

    Parameters
    ----------
    gyr_radps : (n, 3) array, rad/s
    acc_mps2 : (n, 3) array, m/s², of the same sensor; None if it is not to be looked at

    Returns
    -------
    (n,) bool array; none of exact readings, which repeat themselves in steady motion
    """
    held = np.zeros(len(gyr_radps), np.bool_)
    same = same_as_before(gyr_radps)
    runs = [run for run in runs_of(same) if run.stop - run.start >= SHORTEST_HELD - 1]
    if not runs:
        return held
    for run in runs:
        held[run.start - 1 : run.stop] = True
    found = resolution_of(gyr_radps, skip=held)
    if not found.pairs or not _is_noisy(gyr_radps[~held]):
        return np.zeros_like(held)
    alone = _chance_of(found)
    beside = np.zeros_like(held) if acc_mps2 is None else same_as_before(acc_mps2)
    # Packets that are delivered twice repeat both halves as well: never below the least.
    both = 1.0 if acc_mps2 is None else _chance_of(resolution_of(acc_mps2, skip=held))
    together = max(alone * both, LEAST_CHANCE)
    step = np.append(np.linalg.norm(np.diff(gyr_radps, axis=0), axis=1), 0.0)
    jumps = step > np.quantile(step, 1 - JUMP_PART)
    for run in runs:
        chance = together if beside[run].all() else alone
        most = LARGEST_CHANCE / JUMP_PART if jumps[run.stop - 1] else LARGEST_CHANCE
        if len(gyr_radps) * chance ** (run.stop - run.start) > most:
            held[run.start - 1 : run.stop] = False
    return held


def _chance_of(found: Resolution) -> float:
    """Chance that noise repeats a reading on all axes; 1 where nothing shows it."""
    return float(np.clip(found.repeats.prod(), LEAST_CHANCE, 1.0)) if found.pairs else 1.0


def _is_noisy(gyr: FloatArray) -> bool:
    """Whether the smallest changes go back and forth, as noise and no motion does."""
    change = np.diff(gyr, axis=0)
    if len(change) < FEWEST_CHANGES:
        return False
    first, second = change[:-1], change[1:]
    size = np.linalg.norm(first, axis=1) + np.linalg.norm(second, axis=1)
    small = size <= np.quantile(size, QUIETEST)
    power = float((first[small] ** 2).sum() + (second[small] ** 2).sum()) / 2
    if power <= LEAST_CHANGE_RADPS**2 * small.sum():
        return False
    return bool((first[small] * second[small]).sum() < BACK_AND_FORTH * power)


def _along(
    recording: Recording, sensors: Sequence[str], mount: WheelchairMount
) -> dict[str, FloatArray]:
    """Rates about the chair's vertical and the axles, of those sensors that have a mount."""
    axes = {
        "frame": mount.rotation_frame_imu_to_chair,
        "left_wheel": mount.rotation_left_imu_to_wheel,
        "right_wheel": mount.rotation_right_imu_to_wheel,
    }
    return {
        name: recording.gyroscope(name) @ rotation[2]
        for name, rotation in axes.items()
        if name in sensors and rotation is not None
    }


def _contradicted(
    recording: Recording,
    name: str,
    flags: Flags,
    along: Mapping[str, FloatArray],
    geometry: WheelchairGeometry,
) -> Flags:
    """Repetitions that the other sensors, or the sensor's own accelerometer, contradict."""
    real = np.zeros_like(flags)
    if name not in along:
        return real
    acc, rate = recording.sensor(name).acc_mps2, recording.sampling_rate_hz
    tied = tied_rate(along, name, geometry) if len(along) == len(CHAIR) else along[name]
    for run in runs_of(flags):
        turns = name != "frame" and np.abs(along[name][run]).max() > LARGEST_OFFSET_RADPS
        held = turns and not np.diff(acc[run], axis=0).any()
        apart = float((np.abs(tied - along[name])[run] > LARGEST_OFFSET_RADPS).mean())
        long = run.stop - run.start > LONGEST_SLIP_S * rate
        real[run] = held or (long and apart > MOSTLY_APART)
    return real


def tied_rate(
    rates: Mapping[str, FloatArray], sensor: str, geometry: WheelchairGeometry
) -> FloatArray:
    """Rate that one of the three gyroscopes has to read, by the two others (eq. 1.18).

    Parameters
    ----------
    rates : sensor to (n,) array, rad/s: ``frame`` about the vertical, wheels about their axles as
        their gyroscopes read it, forward positive
    sensor : which rate is wanted
    geometry : WheelchairGeometry

    Returns
    -------
    (n,) array, rad/s
    """
    left, right = geometry.wheel_radius_m
    distance = geometry.wheel_centre_distance_m
    if sensor == "frame":
        return np.asarray((right * rates["right_wheel"] - left * rates["left_wheel"]) / distance)
    if sensor == "left_wheel":
        return np.asarray((right * rates["right_wheel"] - distance * rates["frame"]) / left)
    return np.asarray((left * rates["left_wheel"] + distance * rates["frame"]) / right)


def unreplaced(failed: Mapping[str, Flags], sensors: Collection[str]) -> dict[str, Flags]:
    """Where nothing replaces a gyroscope that fails: another one fails as well, or is missing.

    Parameters
    ----------
    failed : from :func:`failed_gyroscopes`
    sensors : names of those that there are

    Returns
    -------
    dict from sensor to (n,) bool array; without the sensors that are replaced throughout
    """
    if any(name not in sensors for name in CHAIR):
        return dict(failed)
    together = sum(flags.astype(int) for flags in failed.values())
    lost = {name: flags & (together > 1) for name, flags in failed.items()}
    return {name: flags for name, flags in lost.items() if flags.any()}


def recovered(
    rates: Mapping[str, FloatArray],
    forces: Mapping[str, FloatArray],
    failed: Mapping[str, Flags],
    geometry: WheelchairGeometry,
    sampling_rate_hz: float,
) -> tuple[dict[str, FloatArray], dict[str, Flags]]:
    """Replace what a failed gyroscope reads by what the two others say.

    A wheel's rate comes from the other wheel and the frame. The frame's comes from the wheels' own
    gyroscopes along up (:func:`~mobility_imu.wheelchair.turning.yaw_rate_of_wheel`), where slip
    does not enter, if these go with the frame while it works; else from the wheels' speeds.

    Parameters
    ----------
    rates, forces : sensor to (n, 3) array, rad/s and m/s², in the axes of the chair and of the
        wheels
    failed : sensor to (n,) bool array
    geometry : WheelchairGeometry
    sampling_rate_hz : Hz

    Returns
    -------
    rates : the same with z replaced, x and y zero, where one of three sensors failed alone
    lost : sensor to (n,) bool array, where nothing replaces it
    """
    new = dict(rates)
    if not failed:
        return new, {}
    lost = unreplaced(failed, rates)
    if any(name not in rates for name in CHAIR):
        return new, lost
    along = {name: rate[:, 2] for name, rate in rates.items()}
    others = {name: tied_rate(along, name, geometry) for name in failed}
    if "frame" in failed:
        own = _yaw_of_wheels(rates, forces, geometry, sampling_rate_hz)
        works = ~np.any(list(failed.values()), axis=0)
        gain = _gain_while_it_works(own[works], along["frame"][works], sampling_rate_hz)
        if gain is not None:
            others["frame"] = gain * own
    for name, flags in failed.items():
        alone = flags & ~lost[name] if name in lost else flags
        values = np.array(rates[name])
        values[alone] = 0.0
        values[alone, 2] = others[name][alone]
        new[name] = values
    return new, lost


def _yaw_of_wheels(
    rates: Mapping[str, FloatArray],
    forces: Mapping[str, FloatArray],
    geometry: WheelchairGeometry,
    sampling_rate_hz: float,
) -> FloatArray:
    """Mean of the yaw rates that the wheels' sensors know by themselves, (n,) array, rad/s."""
    known = [
        yaw_rate_of_wheel(rates[name], forces[name], geometry.camber_rad, sampling_rate_hz)
        for name in CHAIR[1:]
    ]
    return np.asarray(np.mean(known, axis=0))


def _gain_while_it_works(
    first: FloatArray, second: FloatArray, sampling_rate_hz: float
) -> float | None:
    """Factor on the first series that gives the second; None if they do not go together."""
    if np.abs(second).sum() / sampling_rate_hz < LEAST_TURNED_RAD or not first.any():
        return None
    power = float(first @ first)
    together = float(first @ second)
    if abs(together) < LEAST_CORRELATION * np.sqrt(power * float(second @ second)):
        return None
    return together / power


def others_of(sensor: str) -> str:
    """Names of the chair's two other sensors, for a sentence.

    Parameters
    ----------
    sensor : "frame", "left_wheel" or "right_wheel"

    Examples
    --------
    >>> others_of("frame")
    'left_wheel and right_wheel'
    """
    return " and ".join(other for other in CHAIR if other != sensor)


def recovery_warnings(
    recording: Recording, failed: Mapping[str, Flags], lost: Mapping[str, Flags]
) -> tuple[str, ...]:
    """Sentences on gyroscopes that two others replace, or that nothing replaces.

    Parameters
    ----------
    recording : Recording
    failed : from :func:`failed_gyroscopes`
    lost : from :func:`recovered`

    Returns
    -------
    tuple of str
    """
    rate, sentences = recording.sampling_rate_hz, []
    for name, flags in failed.items():
        gone = lost.get(name, np.zeros_like(flags))
        back = flags & ~gone
        if back.any():
            sentences.append(
                f"{recording.source}: the gyroscope of {name} fails for {back.sum() / rate:.2f} s; "
                f"{others_of(name)} replace it there, where slip cannot be seen"
            )
    return tuple(sentences)


def with_recovered_sd(
    sd: SpeedUncertainty,
    rates: Mapping[str, FloatArray],
    failed: Mapping[str, Flags],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    sampling_rate_hz: float,
    offsets: Mapping[str, GyroscopeOffset],
    errors: AssumedErrors,
) -> SpeedUncertainty:
    """Standard deviations with those of the replacement where a gyroscope fails.

    Parameters
    ----------
    sd : SpeedUncertainty of all three gyroscopes
    rates : from :func:`recovered`
    failed : from :func:`failed_gyroscopes`
    geometry : WheelchairGeometry
    mount : WheelchairMount
    sampling_rate_hz : Hz
    offsets : sensor to GyroscopeOffset that was taken off
    errors : AssumedErrors

    Returns
    -------
    SpeedUncertainty
    """
    speed_sd, yaw_sd = sd
    yaw = rates["frame"][:, 2]
    for side, other in zip(SIDES, reversed(SIDES), strict=True):
        if f"{side}_wheel" in failed:
            alone = one_wheel_standard_deviation(
                rates[f"{other}_wheel"],
                yaw,
                yaw_sd,
                geometry,
                mount,
                sampling_rate_hz,
                side=other,
                offset=offsets.get(f"{other}_wheel"),
                errors=errors,
            )
            speed_sd = np.where(failed[f"{side}_wheel"], np.maximum(alone, speed_sd), speed_sd)
    if "frame" in failed:
        rims = [
            r * rates[f"{side}_wheel"][:, 2]
            for side, r in zip(SIDES, geometry.wheel_radius_m, strict=True)
        ]
        of_wheels = wheel_yaw_standard_deviation(
            yaw,
            np.mean(rims, axis=0),
            geometry,
            gyr_sd_radps=_largest_sd(offsets, mount),
            radius_sd_m=float(np.hypot(errors.radius_sd, errors.scale_sd))
            * max(geometry.wheel_radius_m),
            distance_sd_m=errors.track_sd_m,
        )
        yaw_sd = np.where(failed["frame"], of_wheels, yaw_sd)
    return SpeedUncertainty(speed_sd, yaw_sd)


def replaced(
    recording: Recording,
    sensor: str,
    flags: Flags,
    others: Mapping[str, Flags],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    otherwise: Repair | None,
    at_end: bool = False,
) -> Recording:
    """Recording in which a gyroscope reads what the two others say of it.

    Offsets that the recording's rests show stay on the sensor that is replaced.

    Parameters
    ----------
    recording : Recording
    sensor : name
    flags : (n,) bool array, the samples that are replaced
    others : sensor to (n,) bool array, where gyroscopes fail; this sensor's does not count
    geometry : WheelchairGeometry
    mount : WheelchairMount
    otherwise : what mends the samples in which another gyroscope fails as well; None leaves them
    at_end : whether the readings are at the end of a range: the middle of three then counts, of
        the others, of the curve through what is left, and of gravity

    Returns
    -------
    Recording
    """
    mended = recording if otherwise is None else otherwise(recording)
    names = with_gyroscope(recording, CHAIR)
    if len(_along(recording, names, mount)) < len(CHAIR):
        return mended
    offsets = rest_offsets(recording, names, skip={**others, sensor: flags})
    calm = without_offsets(recording, offsets)
    turn = {
        "frame": mount.rotation_frame_imu_to_chair,
        "left_wheel": mount.rotation_imu_to_wheel("left"),
        "right_wheel": mount.rotation_imu_to_wheel("right"),
    }
    rates = {name: calm.gyroscope(name) @ turn[name].T for name in CHAIR}
    forces = {name: calm.sensor(name).acc_mps2 @ turn[name].T for name in CHAIR}
    good = flags.copy()
    for name, bad in others.items():
        if name != sensor:
            good &= ~bad
    rate = recording.sampling_rate_hz
    new, _ = recovered(rates, forces, {sensor: good}, geometry, rate)
    along = new[sensor][:, 2]
    values = np.array(mended.gyroscope(sensor))
    axis = turn[sensor][2]
    offset = offsets[sensor].offset_radps if sensor in offsets else np.zeros(3)
    if at_end:
        # Cut peaks: the others err where a wheel slips, the curve where much is lost.
        curve = (values - offset) @ axis
        gravity = _by_gravity(rates, forces, sensor, geometry, rate)
        along = np.median([along, curve, gravity], axis=0)
        values[good] += (along - curve)[good, None] * axis
    else:
        values[good] = along[good, None] * axis + offset
    return with_half(mended, sensor, "gyr", values)


def _by_gravity(
    rates: Mapping[str, FloatArray],
    forces: Mapping[str, FloatArray],
    sensor: str,
    geometry: WheelchairGeometry,
    sampling_rate_hz: float,
) -> FloatArray:
    """Rate that gravity's turning in the wheels' planes gives without this gyroscope, rad/s."""
    if sensor == "frame":
        along = {name: rate[:, 2] for name, rate in rates.items()}
        return tied_rate(along, "frame", geometry)
    side: Side = "left" if sensor == "left_wheel" else "right"
    angle = upward_angle(forces[sensor], sampling_rate_hz)
    width = max(1, round(GRAVITY_S * sampling_rate_hz))
    spin = -ndimage.uniform_filter1d(np.gradient(angle) * sampling_rate_hz, width)
    return np.asarray(spin + geometry.axle_direction(side)[2] * rates["frame"][:, 2])


def unknown_where(sd: FloatArray, lost: Mapping[str, Flags], needed: Sequence[str]) -> FloatArray:
    """Standard deviation, infinite where a sensor that it comes from fails.

    Parameters
    ----------
    sd : (n,) array
    lost : sensor to (n,) bool array
    needed : names of the sensors that it comes from

    Returns
    -------
    (n,) array
    """
    flags = {name: lost[name] for name in needed if name in lost}
    return np.where(usable_samples(len(sd), flags), sd, np.inf)


def wheel_forces(recording: Recording, mount: WheelchairMount) -> dict[str, FloatArray]:
    """Specific forces of the wheels that have a sensor, in their axes.

    Parameters
    ----------
    recording : Recording
    mount : WheelchairMount

    Returns
    -------
    dict from sensor to (n, 3) array, m/s²
    """
    return {
        f"{side}_wheel": mount.wheel(side, recording.sensors[f"{side}_wheel"].acc_mps2)
        for side in SIDES
        if f"{side}_wheel" in recording.sensors
    }


def with_gyroscope(recording: Recording, names: Sequence[str]) -> list[str]:
    """Sensors of the recording that can be looked at; what is missing is refused later.

    Parameters
    ----------
    recording : Recording
    names : of sensors

    Returns
    -------
    list of those that are there and have a gyroscope
    """
    sensors = recording.sensors
    return [n for n in names if n in sensors and sensors[n].gyr_radps is not None]


def _largest_sd(offsets: Mapping[str, GyroscopeOffset], mount: WheelchairMount) -> float:
    """Offset and noise of the worse of the wheels' gyroscopes, rad/s."""
    sizes = []
    for side in SIDES:
        offset, axle = offsets.get(f"{side}_wheel"), mount.rotation_imu_to_wheel(side)[2]
        sizes.append(
            np.hypot(UNKNOWN_OFFSET_SD_RADPS, UNKNOWN_NOISE_RADPS)
            if offset is None
            else np.hypot(offset.sd_along(axle), offset.noise_along(axle))
        )
    return float(max(sizes))
