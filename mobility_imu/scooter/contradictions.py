"""Faults that only both sensors of a scooter show: what is at odds is undone until they agree.

Each way in which a fault could have come about is undone by itself: signs of a gyroscope's axes, a
scale, a lag, exchanged names, a sensor turned about the vertical. The one after which the misfits
of :mod:`mobility_imu.scooter.agreement` are smallest is named, if they are clearly smaller.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy import optimize
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.faults import (
    Fault,
    Repair,
    exchanged,
    multiplied,
    shifted,
    turned_back,
    without_offset,
)
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.scooter.agreement import Agreement, Lag, lag_between, twist_between
from mobility_imu.scooter.fusion import SLOWEST_RATE_HZ
from mobility_imu.scooter.geometry import ScooterGeometry, lever_acceleration
from mobility_imu.scooter.machine import zeros_of
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.pose_check import pose_uncertainty
from mobility_imu.scooter.sensor_pair import (
    LARGE_OFFSET_RADPS,
    SensorPair,
    offsets_at_rest,
)

__all__ = ["contradictions"]

SHORTEST_S = 5.0
"""Recordings that are shorter say nothing of two sensors together; the rates of slower ones than
``SLOWEST_RATE_HZ`` cannot be integrated."""
CLEARLY_BETTER, MUCH_BETTER = 0.5, 0.55
"""A fault, undone, has to make the sum of squared misfits smaller by the first number (3 is usual)
and to less than the second part of it. Swept on simulated rides, seeds 36,000 to 41,000."""
AT_ODDS = 12.0
"""Sum of squared misfits of sensors that contradict each other: twice what is usual of each."""
SURE_LAG = 0.7
"""Correlation about the locked axis from which on a lag is believed."""
SMALLEST_LAG_S, LAG_SDS = 0.01, 5.0
"""A lag of a sample moves nothing, and is within what joining two clocks leaves."""
SMALLEST_SCALE, LARGEST_SCALE = 0.07, 3.0
"""Scale errors of gyroscopes end at 3 % (data sheets of consumer sensors), and mounts that are off
by 2 deg move what is found by as much again."""
LEAST_TURNING_RADPS = 0.01
"""Rate of the whole scooter from which on it shows how the body's sensor is turned."""
ZERO_SDS = 3.0
"""Standard deviations by which a zero may be off; by chance one in 370 has more."""
ZERO_FIT_SD_RAD = float(np.deg2rad(1.3))
"""Error of the steering at which a scooter does not turn: floors slope by 0.6 deg across, which
bends the closed form's angles; swept on simulated rides, seeds 26,000 to 26,078."""
LEAST_EXPLAINED = 0.9
"""Part of the lever's shaking that the body's has to explain before it says how both are turned;
in tight curves hands shake as much as the ground, and it says nothing."""
LARGEST_LEAN_RAD = float(np.deg2rad(20.0))
"""Angle of the body's axis z from the vertical at the beginning: twice the steepest ramp."""
LARGEST_SWUNG_RAD = float(np.deg2rad(25.0))
"""The same of the lever's sensor: with the lever released, gravity turns by 17 deg in its axes when
the wheel is turned by 50 deg."""
FIRST_S = 1.0
SHAFT_SD_RAD = float(np.deg2rad(2.8))
"""Turn of two IMUs about z, each stuck on by eye to 2 deg."""
QUARTERS_DEG = (90.0, 180.0, 270.0)


class _Suspect(NamedTuple):
    """A fault that may explain what is at odds, and how well the sensors agree without it."""

    code: str
    sensor: str
    what: str
    size: float
    unit: str
    repair: Repair
    after: Agreement


def contradictions(
    recording: Recording, geometry: ScooterGeometry, mount: ScooterMount | None
) -> Iterator[Fault]:
    """Faults that two sensors show only together.

    Parameters
    ----------
    recording : Recording of lever and body with gyroscopes
    geometry : ScooterGeometry
    mount : ScooterMount, or None

    Yields
    ------
    Fault; small ones too: whether they matter is not judged here
    """
    whole = np.ones(len(recording), np.bool_)
    length_s = float(recording.time_s[-1] - recording.time_s[0])
    if length_s < SHORTEST_S or recording.sampling_rate_hz < SLOWEST_RATE_HZ:
        return
    try:
        pair = SensorPair(recording, geometry, mount)
    except InputError:
        return  # gravity is missing or reversed: the estimate says it
    suspects = [*_exchange(pair)]
    if pair.stated is not None:
        lag = lag_between(pair.motion, pair.seen.good, pair.rate_hz)
        suspects += [*_signs(pair), *_scales(pair), *_late(pair, lag)]
        if rms(pair.motion.body_locked) > LEAST_TURNING_RADPS:
            # While the scooter stands, gravity alone would be asked.
            suspects += [*_quarters(pair), *_mirrors(pair)]
    found = _best(pair, suspects)
    if found is not None:
        yield fault_of(
            recording, found.code, found.sensor, whole, found.what,
            size=found.size, unit=found.unit, repair=found.repair,
        )  # fmt: skip
        if found.code != "lag":
            return
    yield from _offset_at_rest(recording, offsets_at_rest(recording))
    yield from _offset_by_drift(pair)
    if pair.stated is None:
        yield from _tipped(pair)
        return
    if pair.stated.squared > AT_ODDS:
        yield fault_of(
            recording, "at odds", "lever, body", whole,
            "contradict each other: no angles of the controls explain both, and nothing that was "
            "tried makes them agree; look at how they are mounted and exported. What follows has "
            "no known error", size=float(np.sqrt(pair.stated.squared / 3)), unit="times the usual",
        )  # fmt: skip
    else:
        yield from _turned_since(pair)


def _best(pair: SensorPair, suspects: list[_Suspect]) -> _Suspect | None:
    """Suspect without which the sensors agree best, if they do so clearly better.

    A lag need not make them agree better: it has a standard deviation of its own. Axes across the
    turns, reversed, look much like a lag; the correlation at the lag tells them apart.
    """
    late = next((s for s in suspects if s.code == "lag"), None)
    others = [s for s in suspects if s.code != "lag"]
    best = min(others, key=lambda s: s.after.squared, default=None)
    if best is None or pair.stated is None:
        return late or best
    better = pair.stated.squared - best.after.squared > CLEARLY_BETTER
    if not better or best.after.squared > MUCH_BETTER * pair.stated.squared:
        return late
    if late is not None:
        as_good = late.after.squared < best.after.squared + CLEARLY_BETTER
        if as_good and late.after.correlation >= best.after.correlation:
            return late
    return best


def _signs(pair: SensorPair) -> Iterator[_Suspect]:
    for name in ("lever", "body"):
        for signs in product((1.0, -1.0), repeat=3):
            bad = [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
            if not bad:
                continue
            if len(bad) == 1:
                what = f"axis {bad[0]} of the gyroscope has"
            else:
                what = f"axes {', '.join(bad)} of the gyroscope have"
            other = "body" if name == "lever" else "lever"
            yield _Suspect(
                "reversed", f"{name}_gyr",
                f"turns the other way than its accelerometer and the {other}'s sensor show: {what} "
                "the wrong sign; check the export's axes",
                float("nan"), "",
                partial(multiplied, sensor=name, half="gyr", factors=np.array(signs)),
                pair.with_rates(name, np.array(signs)),
            )  # fmt: skip


def _scales(pair: SensorPair) -> Iterator[_Suspect]:
    for name in ("lever", "body"):

        def misfit(log_factor: float, name: str = name) -> float:
            return pair.with_rates(name, float(np.exp(log_factor))).squared

        limit = float(np.log(LARGEST_SCALE))
        found = optimize.minimize_scalar(
            misfit, bounds=(-limit, limit), method="bounded", options={"xatol": 0.005}
        )
        factor = float(np.exp(found.x))
        if abs(factor - 1) < SMALLEST_SCALE:
            continue
        yield _Suspect(
            "scale", f"{name}_gyr",
            f"reads {1 / factor:.2f} times what the other sensors show: check the unit and the "
            "range that it was exported with",
            1 / factor, "times",
            partial(multiplied, sensor=name, half="gyr", factors=factor),
            pair.with_rates(name, factor),
        )  # fmt: skip


def _late(pair: SensorPair, lag: Lag) -> Iterator[_Suspect]:
    least = max(SMALLEST_LAG_S, LAG_SDS * lag.sd_s)
    if lag.correlation < SURE_LAG or abs(lag.lag_s) < least:
        return
    late, first = ("lever", "body") if lag.lag_s > 0 else ("body", "lever")
    repair = partial(shifted, sensor=late, lag_s=abs(lag.lag_s))
    after = pair.repaired(repair)
    if after is not None:
        yield _Suspect(
            "lag", late,
            f"comes {abs(lag.lag_s):.3f} ± {lag.sd_s:.3f} s later than the {first}'s sensor: bring "
            "both on one clock", abs(lag.lag_s), "s", repair, after,
        )  # fmt: skip


def _exchange(pair: SensorPair) -> Iterator[_Suspect]:
    repair = partial(exchanged, first="lever", second="body")
    after = pair.repaired(repair)
    if after is not None and (pair.stated is None or after.squared < pair.stated.squared):
        if pair.stated is None and after.squared > AT_ODDS:
            return
        yield _Suspect(
            "exchanged", "lever, body",
            "have each other's names: what is called the body turns on the lever's hinges; "
            "exchange them", float("nan"), "", repair, after,
        )  # fmt: skip


def _quarters(pair: SensorPair) -> Iterator[_Suspect]:
    """Sensors that sit turned about their z axis by a quarter or two."""
    for name in ("lever", "body"):
        for angle in QUARTERS_DEG:
            repair = partial(
                turned_back,
                sensor=name,
                rotation=Rotation.from_euler("z", angle, degrees=True).as_matrix(),
            )
            after = pair.repaired(repair)
            if after is not None:
                yield _Suspect(
                    "turned", name,
                    f"sits turned by {angle:.0f} deg about its z axis; mount it as the geometry "
                    "says, or calibrate the mount", angle, "deg", repair, after,
                )  # fmt: skip


def _mirrors(pair: SensorPair) -> Iterator[_Suspect]:
    """Sensors with left-handed axes: one axis of both halves is reversed."""
    for name in ("lever", "body"):
        for axis in range(3):
            signs = np.where(np.arange(3) == axis, -1.0, 1.0)
            repair = partial(unmirrored, sensor=name, signs=signs)
            after = pair.repaired(repair)
            if after is not None:
                yield _Suspect(
                    "left-handed", name,
                    f"has left-handed axes: with its {'xyz'[axis]} axis the other way round both "
                    "sensors agree; check the export's axes", float("nan"), "", repair, after,
                )  # fmt: skip


def unmirrored(recording: Recording, sensor: str, signs: FloatArray) -> Recording:
    """Recording in which axes of both halves of a sensor have other signs.

    Parameters
    ----------
    recording : Recording
    sensor : name
    signs : (3,) array of 1 and -1

    Returns
    -------
    Recording
    """
    return multiplied(multiplied(recording, sensor, "acc", signs), sensor, "gyr", signs)


def _offset_at_rest(recording: Recording, offsets: dict[str, FloatArray]) -> Iterator[Fault]:
    whole = np.ones(len(recording), np.bool_)
    for name, offset in offsets.items():
        size = float(np.abs(offset).max())
        if size > LARGE_OFFSET_RADPS:
            shown = ", ".join(f"{value:.1f}" for value in np.rad2deg(offset))
            yield fault_of(
                recording, "offset", f"{name}_gyr", whole,
                f"reads ({shown}) deg/s at rest; let the sensor warm up, or take the offset off",
                size=float(np.rad2deg(size)), unit="deg/s",
                repair=partial(without_offset, sensor=name, offset_radps=offset),
            )  # fmt: skip


def _offset_by_drift(pair: SensorPair) -> Iterator[Fault]:
    if pair.drift is None:
        return
    name, offset = pair.drift
    size = float(np.abs(offset).max())
    if size <= LARGE_OFFSET_RADPS:
        return
    shown = ", ".join(f"{value:.1f}" for value in np.rad2deg(offset))
    yield fault_of(
        pair.recording, "offset", f"{name}_gyr", np.ones(len(pair.recording), np.bool_),
        f"drifts against the other sensors, by about ({shown}) deg/s, and no rest shows its "
        "offset by itself; let the scooter stand for some seconds at the beginning",
        size=float(np.rad2deg(size)), unit="deg/s",
        repair=partial(without_offset, sensor=name, offset_radps=offset),
    )  # fmt: skip


def _turned_since(pair: SensorPair) -> Iterator[Fault]:
    """Angles that should be zero, or alike, and are off by more than the mount is uncertain."""
    body_acc, (lever_gyr, body_gyr) = (
        pair.turned(pair.readings.acc)[1],
        pair.turned(pair.readings.gyr),
    )
    zeros = zeros_of(pair.seen, body_acc, body_gyr, lever_gyr, pair.rate_hz)
    twist = twist_between(lever_gyr, body_gyr, pair.seen, pair.rate_hz, pair.geometry)
    calibrated = pair.mount is not None and pair.mount.sd_rad is not None
    sd = pose_uncertainty([[0.0, 0.0]], pair.geometry, calibrated=calibrated)[0]
    limits = ZERO_SDS * sd
    off = np.array([zeros.steering_rad, zeros.throttle_rad])
    yaw = 0.0
    if twist is not None and twist.explained > LEAST_EXPLAINED:
        # Poses show little of turns about the vertical, which gravity does not feel.
        about_z = SHAFT_SD_RAD if pair.mount is None else _mount_sd(pair.mount)
        if np.isnan(off[0]):
            limit = ZERO_SDS * float(np.linalg.norm([sd[0], about_z, twist.sd_rad]))
            off[0] = twist.angle_rad if abs(twist.angle_rad) > limit else 0.0
        elif abs(off[0]) <= limits[0]:
            # An error of the closed form is in both, and drops out.
            limit = ZERO_SDS * float(np.linalg.norm([ZERO_FIT_SD_RAD, about_z, twist.sd_rad]))
            apart = twist.angle_rad - float(off[0])
            yaw = apart if abs(apart) > limit else 0.0
    off = np.where(np.abs(off) > limits, off, 0.0)  # NaN is no finding
    says = []
    if off[0]:
        says.append(f"the steering is {np.rad2deg(off[0]):+.1f} deg where it should be 0")
    if off[1]:
        says.append(f"the throttle is {np.rad2deg(off[1]):+.1f} deg with the lever released")
    if yaw:
        says.append(f"their gyroscopes are turned by {np.rad2deg(yaw):+.1f} deg about the vertical")
    if not says:
        return
    sensor, size = ("body", abs(yaw)) if yaw else ("lever", float(np.abs(off).max()))
    back = Rotation.from_rotvec([0, 0, yaw]).as_matrix() if yaw else _untwisted(pair, off)
    yield fault_of(
        pair.recording, "turned", "lever, body", np.ones(len(body_acc), np.bool_),
        f"are not mounted as stated: {' and '.join(says)}; was one turned since the calibration? "
        "Calibrate the mount", size=float(np.rad2deg(size)), unit="deg",
        repair=partial(turned_back, sensor=sensor, rotation=back),
    )  # fmt: skip


def _mount_sd(mount: ScooterMount) -> float:
    """How well a mount is known about both z axes, rad."""
    if mount.sd_rad is None:
        return SHAFT_SD_RAD
    return float(np.hypot(mount.sd_rad[2], mount.sd_rad[5]))


def _tipped(pair: SensorPair) -> Iterator[Fault]:
    """Body that does not stand upright at the beginning, in a ride that the closed form distrusts.

    Recordings begin at rest; nothing that drives stands so steep.
    """
    first = slice(0, max(1, round(FIRST_S * pair.rate_hz)))
    lever, body = (np.median(v[first], axis=0) for v in pair.turned(pair.readings.acc))
    right = {"body": np.array([0.0, 0.0, 1.0])}
    right["lever"] = lever_acceleration(right["body"], 0.0, 0.0, pair.geometry)
    for name, force in (("body", body), ("lever", lever)):
        axis = np.cross(force, right[name])
        angle = float(np.arctan2(np.linalg.norm(axis), force @ right[name]))
        limit = LARGEST_LEAN_RAD if name == "body" else LARGEST_SWUNG_RAD
        if angle <= limit:
            continue
        back = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()
        if pair.mount is not None:
            turn = getattr(pair.mount, f"rotation_{name}_imu_to_{name}")
            back = turn.T @ back @ turn
        yield fault_of(
            pair.recording, "turned", name, np.ones(len(pair.recording), np.bool_),
            f"lies {np.rad2deg(angle):.0f} deg from where it should be at the beginning, and most "
            "accelerations fit no angles of the controls; mount it as the geometry says, or "
            "calibrate the mount", size=float(np.rad2deg(angle)), unit="deg",
            repair=partial(turned_back, sensor=name, rotation=back),
        )  # fmt: skip
        return


def _untwisted(pair: SensorPair, off: FloatArray) -> FloatArray:
    """Turn of the lever's sensor that takes both zeros to zero, in its own axes."""
    up = [0.0, 0.0, 1.0]
    read = lever_acceleration(up, float(off[0]), float(off[1]), pair.geometry)
    right = lever_acceleration(up, 0.0, 0.0, pair.geometry)
    axis = np.cross(read, right)
    angle = float(np.arctan2(np.linalg.norm(axis), read @ right))
    if angle > 0:
        axis = axis / np.linalg.norm(axis) * angle
    turn = Rotation.from_rotvec(axis).as_matrix()
    if pair.mount is None:
        return np.asarray(turn)
    to_lever = pair.mount.rotation_lever_imu_to_lever
    return np.asarray(to_lever.T @ turn @ to_lever)
