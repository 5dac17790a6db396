"""Faults that only both sensors of a scooter show: what is at odds is undone until they agree.

Each way in which a fault could have come about is undone by itself: signs of a gyroscope's axes, a
scale, a lag, exchanged names, a sensor turned about the vertical. The one after which the misfits
of :mod:`mobility_imu.scooter.agreement` are smallest is named, if they are clearly smaller.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import optimize
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.faults import (
    Fault,
    multiplied,
    shifted,
    turned_back,
    with_half,
    without_offset,
)
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.scooter.agreement import RATE_MEAN_S, Lag, lag_between, seen_by, twist_between
from mobility_imu.scooter.exchanges import (
    AT_ODDS,
    CLEARLY_BETTER,
    MUCH_BETTER,
    Suspect,
    exchanges,
)
from mobility_imu.scooter.fusion import SLOWEST_RATE_HZ
from mobility_imu.scooter.geometry import ScooterGeometry, lever_acceleration
from mobility_imu.scooter.machine import zeros_of
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.pose_check import pose_uncertainty
from mobility_imu.scooter.sensor_pair import LARGE_OFFSET_RADPS, SensorPair
from mobility_imu.scooter.slips import slip_of

__all__ = ["Contradictions", "all_turned_back", "contradictions", "rearranged", "unmirrored"]

SHORTEST_S = 5.0
"""Recordings that are shorter say nothing of two sensors together; the rates of slower ones than
``SLOWEST_RATE_HZ`` cannot be integrated."""
SURE_LAG = 0.7
"""Correlation about the locked axis from which on a lag is believed."""
SMALLEST_LAG_S, LAG_SDS = 0.01, 5.0
"""A lag of a sample moves nothing, and is within what joining two clocks leaves."""
SMALLEST_SCALE, LARGEST_SCALE = 0.07, 100.0
"""Scale errors of gyroscopes end at 3 % (data sheets of consumer sensors), and mounts that are off
by 2 deg move what is found by as much again. Units that are mistaken (deg/s for rad/s) make 57."""
USUAL_SCALE = 3.0
"""Ranges that are mistaken make 2 or 4 (data sheets); beyond this, both sensors have to agree."""
BOUND_LOG, SCALES_TRIED = 0.01, 43
"""A factor so close to the limit (in logarithms) is at it; steps of a quarter between both."""
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
EVEN = (1.0, 1.0, 1.0)
FORCE_AXES = (
    ((0, 1, 2), (-1.0, 1.0, 1.0), "axis x of the accelerometer has the wrong sign"),
    ((0, 1, 2), (1.0, -1.0, 1.0), "axis y of the accelerometer has the wrong sign"),
    ((0, 1, 2), (1.0, 1.0, -1.0), "axis z of the accelerometer has the wrong sign"),
    ((1, 0, 2), EVEN, "axes x and y of the accelerometer are exchanged"),
    ((2, 1, 0), EVEN, "axes x and z of the accelerometer are exchanged"),
    ((0, 2, 1), EVEN, "axes y and z of the accelerometer are exchanged"),
)
"""Axes, signs and words of what an export makes of an accelerometer's axes."""
LARGEST_OFFSETS_MG = 100.0
"""What the zero-g offsets of two consumer accelerometers may differ by (data sheets: 50 each)."""


class Contradictions(NamedTuple):
    """What two sensors show only together.

    Parameters
    ----------
    faults : tuple of Fault; small ones too: whether they matter is not judged here
    signs_tested : whether both gyroscopes' signs were tried
    """

    faults: tuple[Fault, ...] = ()
    signs_tested: bool = False


def contradictions(
    recording: Recording, geometry: ScooterGeometry, mount: ScooterMount | None
) -> Contradictions:
    """Faults that two sensors show only together.

    Parameters
    ----------
    recording : Recording of lever and body with gyroscopes
    geometry : ScooterGeometry
    mount : ScooterMount, or None

    Returns
    -------
    Contradictions; empty for a recording that is too short or too slow
    """
    length_s = float(recording.time_s[-1] - recording.time_s[0])
    if length_s < SHORTEST_S or recording.sampling_rate_hz < SLOWEST_RATE_HZ:
        return Contradictions()
    try:
        pair = SensorPair(recording, geometry, mount)
    except InputError:
        return Contradictions()  # gravity is missing or reversed: the estimate says it
    return Contradictions(tuple(_faults_of(pair)), pair.stated is not None)


def _faults_of(pair: SensorPair, *, on_one_clock: bool = False) -> Iterator[Fault]:
    """Faults of a pair; once a lag is found, of the pair without it."""
    found = _best(pair, list(_suspects(pair, on_one_clock)))
    if found is not None:
        yield fault_of(
            pair.recording, found.code, found.sensor, _whole(pair), found.what,
            size=found.size, unit=found.unit, repair=found.repair,
        )  # fmt: skip
        if found.code == "lag" and found.repair is not None:
            # What else is wrong cannot be seen behind it.
            mended = SensorPair(found.repair(pair.recording), pair.geometry, pair.mount)
            yield from _faults_of(mended, on_one_clock=True)
        return
    yield from _offset_at_rest(pair)
    yield from _offset_by_drift(pair)
    # Parked, a mount by eye may explain the poses only in part.
    drives = rms(pair.motion.body_locked) > LEAST_TURNING_RADPS
    slipped = slip_of(pair, AT_ODDS) if drives else None
    if slipped is not None:
        # A turn from the beginning leaves most forces without angles.
        yield from (pair.stated is None and tuple(_tipped(pair))) or (slipped,)
        return
    if pair.stated is None:
        yield from _tipped(pair)
    elif pair.stated.squared > AT_ODDS:
        yield fault_of(
            pair.recording, "at odds", "lever, body", _whole(pair),
            "contradict each other: no angles of the controls explain both, and nothing that was "
            "tried makes them agree; look at how they are mounted and exported",
            size=float(np.sqrt(pair.stated.squared / 3)), unit="times the usual",
        )  # fmt: skip
    else:
        yield from _turned_since(pair)


def _whole(pair: SensorPair) -> NDArray[np.bool_]:
    return np.ones(len(pair.recording), np.bool_)


def _suspects(pair: SensorPair, on_one_clock: bool) -> Iterator[Suspect]:
    """Each way in which a fault could have come about, as far as it can be named (:func:`_best`).

    A lag has a measure of its own; nothing else makes sensors agree clearly better that agree well.
    """
    if pair.stated is None or pair.stated.squared > CLEARLY_BETTER:
        yield from _misread(pair)
    if pair.stated is not None and not on_one_clock:
        yield from _late(pair, lag_between(pair.motion, pair.seen.good, pair.rate_hz))


def _misread(pair: SensorPair) -> Iterator[Suspect]:
    """Names, axes, signs and scales other than those that are stated."""
    yield from exchanges(pair)
    yield from _force_axes(pair)
    if pair.stated is None:
        return
    yield from _signs(pair)
    yield from _scales(pair)
    if rms(pair.motion.body_locked) > LEAST_TURNING_RADPS:
        # While the scooter stands, gravity alone would be asked.
        yield from _quarters(pair)
        yield from _mirrors(pair)


def _best(pair: SensorPair, suspects: list[Suspect]) -> Suspect | None:
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


def _signs(pair: SensorPair) -> Iterator[Suspect]:
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
            yield Suspect(
                "reversed", f"{name}_gyr",
                f"turns the other way than its accelerometer and the {other}'s sensor show: {what} "
                "the wrong sign; check the export's axes",
                float("nan"), "",
                partial(multiplied, sensor=name, half="gyr", factors=np.array(signs)),
                pair.with_rates(name, np.array(signs)),
            )  # fmt: skip


def _force_axes(pair: SensorPair) -> Iterator[Suspect]:
    """Accelerometers with an axis reversed, or two exchanged; right ones leave nothing at odds."""
    drives = rms(pair.motion.body_locked) > LEAST_TURNING_RADPS
    # On a scooter that stands level the body's axes x and y feel nothing.
    for name in ("lever", "body") if drives else ("lever",):
        for axes, signs, what in FORCE_AXES:
            repair = partial(rearranged, sensor=name, axes=axes, signs=signs)
            other = np.diag(signs) @ np.eye(3)[list(axes)]
            after = pair.in_axes(name, acc=other, gyr=np.eye(3))
            if after is None or after.squared > AT_ODDS:
                continue
            if pair.stated is None or after.squared < pair.stated.squared:
                yield Suspect(
                    "reversed" if signs != EVEN else "swapped", f"{name}_acc",
                    "feels gravity elsewhere than its gyroscope and the other sensor show: "
                    f"{what}; check the export's axes", float("nan"), "", repair, after,
                )  # fmt: skip


def rearranged(
    recording: Recording, sensor: str, axes: tuple[int, int, int], signs: tuple[float, float, float]
) -> Recording:
    """Recording in which an accelerometer's axes are others, some of them reversed.

    Parameters
    ----------
    recording : Recording
    sensor : name
    axes : the axis that each one is taken from
    signs : factor of each, 1 or -1

    Returns
    -------
    Recording
    """
    values = recording.sensor(sensor).acc_mps2[:, list(axes)] * np.array(signs)
    return with_half(recording, sensor, "acc", values)


def _scales(pair: SensorPair) -> Iterator[Suspect]:
    for name in ("lever", "body"):
        factor = _factor(pair, name)
        after = pair.with_rates(name, factor)
        if abs(factor - 1) < SMALLEST_SCALE:
            continue
        if abs(np.log(factor)) > np.log(USUAL_SCALE) and after.squared > AT_ODDS:
            continue  # a gyroscope that is scaled away contradicts nothing
        reads = 1 / factor
        if reads >= LARGEST_SCALE:
            times = f"{LARGEST_SCALE:.0f} times or more"
        elif factor >= LARGEST_SCALE:
            times = f"1/{LARGEST_SCALE:.0f} or less of"
        else:
            times = f"{reads:.2f} times" if reads > 0.1 else f"{reads:.2g} times"
        yield Suspect(
            "scale", f"{name}_gyr",
            f"reads {times} what the other sensors show: check the unit and the range that it was "
            "exported with",
            reads, "times",
            partial(multiplied, sensor=name, half="gyr", factors=factor),
            after,
        )  # fmt: skip


def _factor(pair: SensorPair, name: str) -> float:
    """Factor of a gyroscope with which the sensors agree best, within its limits.

    A coarse search comes first: the misfit may have more than one minimum.
    """

    def misfit(log_factor: float) -> float:
        return pair.with_rates(name, float(np.exp(log_factor))).squared

    limit = float(np.log(LARGEST_SCALE))
    tried = np.linspace(-limit, limit, SCALES_TRIED)
    best = int(np.argmin([misfit(value) for value in tried.tolist()]))
    around = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    found = optimize.minimize_scalar(
        misfit, bounds=around, method="bounded", options={"xatol": 0.005}
    )
    # A bounded search ends beside a bound, never on it.
    at_bound = limit - abs(found.x) < BOUND_LOG and misfit(float(tried[best])) <= found.fun
    return float(np.exp(tried[best] if at_bound else found.x))


def _late(pair: SensorPair, lag: Lag) -> Iterator[Suspect]:
    least = max(SMALLEST_LAG_S, LAG_SDS * lag.sd_s)
    if lag.correlation < SURE_LAG or abs(lag.lag_s) < least:
        return
    late, first = ("lever", "body") if lag.lag_s > 0 else ("body", "lever")
    repair = partial(shifted, sensor=late, lag_s=abs(lag.lag_s))
    after = pair.repaired(repair)
    if after is not None:
        yield Suspect(
            "lag", late,
            f"comes {abs(lag.lag_s):.3f} ± {lag.sd_s:.3f} s later than the {first}'s sensor: bring "
            "both on one clock", abs(lag.lag_s), "s", repair, after,
        )  # fmt: skip


def _quarters(pair: SensorPair) -> Iterator[Suspect]:
    """Sensors that sit turned about their z axis by a quarter or two."""
    for name in ("lever", "body"):
        for angle in QUARTERS_DEG:
            back = np.asarray(Rotation.from_euler("z", angle, degrees=True).as_matrix())
            repair = partial(turned_back, sensor=name, rotation=back)
            after = pair.in_axes(name, acc=back, gyr=back)
            if after is not None:
                yield Suspect(
                    "turned", name,
                    f"sits turned by {angle:.0f} deg about its z axis; mount it as the geometry "
                    "says, or calibrate the mount", angle, "deg", repair, after,
                )  # fmt: skip


def _mirrors(pair: SensorPair) -> Iterator[Suspect]:
    """Sensors with left-handed axes: one axis of both halves is reversed."""
    for name in ("lever", "body"):
        for axis in range(3):
            signs = np.where(np.arange(3) == axis, -1.0, 1.0)
            repair = partial(unmirrored, sensor=name, signs=signs)
            after = pair.in_axes(name, acc=np.diag(signs), gyr=np.diag(signs))
            if after is not None:
                yield Suspect(
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


def _offset_at_rest(pair: SensorPair) -> Iterator[Fault]:
    for name, offset in pair.offsets.items():
        size = float(np.abs(offset).max())
        if size > LARGE_OFFSET_RADPS:
            shown = ", ".join(f"{value:.1f}" for value in np.rad2deg(offset))
            yield fault_of(
                pair.recording, "offset", f"{name}_gyr", _whole(pair),
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
        pair.recording, "offset", f"{name}_gyr", _whole(pair),
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
    turns = {}
    if yaw:
        upright = np.asarray(Rotation.from_rotvec([0, 0, yaw]).as_matrix())
        turns["body"] = pair.in_own_axes("body", upright)
    if off.any():
        turns["lever"] = pair.in_own_axes("lever", _untwisted(pair, off))
    calibrate = "calibrate the mount"
    if pair.mount is not None:
        calibrate = "was one turned since the calibration? Calibrate the mount"
        offset_mg = 1000 * _force_between(pair, off)
        if off.any() and not yaw and offset_mg <= LARGEST_OFFSETS_MG:
            calibrate += (
                f"; accelerometers whose zero-g offsets changed by {offset_mg:.0f} mg look the same"
            )
    yield fault_of(
        pair.recording, "turned", "lever, body", _whole(pair),
        f"are not mounted as stated: {' and '.join(says)}; {calibrate}",
        size=float(np.rad2deg(np.abs([*off, yaw]).max())), unit="deg",
        repair=partial(all_turned_back, rotations=turns),
    )  # fmt: skip


def all_turned_back(recording: Recording, rotations: Mapping[str, FloatArray]) -> Recording:
    """Recording in which the readings of some sensors are turned.

    Parameters
    ----------
    recording : Recording
    rotations : (3, 3) array of each sensor's name, from the axes that it has to those that it
        should have

    Returns
    -------
    Recording
    """
    for name, rotation in rotations.items():
        recording = turned_back(recording, name, rotation)
    return recording


def _mount_sd(mount: ScooterMount) -> float:
    """How well a mount is known about both z axes, rad."""
    if mount.sd_rad is None:
        return SHAFT_SD_RAD
    return float(np.hypot(mount.sd_rad[2], mount.sd_rad[5]))


def _tipped(pair: SensorPair) -> Iterator[Fault]:
    """Body that does not stand upright at the beginning, in a ride that the closed form distrusts.

    Recordings begin at rest; nothing that drives stands so steep. Controls that turn fast shorten
    a mean of half a second, which then fits no angles either: short means show whether gravity
    does.
    """
    forces = pair.turned(pair.readings.acc)
    if seen_by(*forces, pair.rate_hz, pair.geometry, RATE_MEAN_S).enough:
        return
    first = slice(0, max(1, round(FIRST_S * pair.rate_hz)))
    lever, body = (np.median(v[first], axis=0) for v in forces)
    right = {"body": np.array([0.0, 0.0, 1.0])}
    right["lever"] = lever_acceleration(right["body"], 0.0, 0.0, pair.geometry)
    for name, force in (("body", body), ("lever", lever)):
        axis = np.cross(force, right[name])
        angle = float(np.arctan2(np.linalg.norm(axis), force @ right[name]))
        limit = LARGEST_LEAN_RAD if name == "body" else LARGEST_SWUNG_RAD
        if angle <= limit:
            continue
        back = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()
        back = pair.in_own_axes(name, np.asarray(back))
        yield fault_of(
            pair.recording, "turned", name, _whole(pair),
            f"lies {np.rad2deg(angle):.0f} deg from where it should be at the beginning, and most "
            "accelerations fit no angles of the controls; mount it as the geometry says, or "
            "calibrate the mount", size=float(np.rad2deg(angle)), unit="deg",
            repair=partial(turned_back, sensor=name, rotation=back),
        )  # fmt: skip
        return


def _force_between(pair: SensorPair, off: FloatArray) -> float:
    """Force, in g, by which the lever's sensor reads another one than at zero angles."""
    read, right = (
        lever_acceleration([0.0, 0.0, 1.0], steering, throttle, pair.geometry)
        for steering, throttle in (off.tolist(), (0.0, 0.0))
    )
    return float(np.linalg.norm(np.asarray(read) - right))


def _untwisted(pair: SensorPair, off: FloatArray) -> FloatArray:
    """Turn of {T} that takes both zeros to zero."""
    up = [0.0, 0.0, 1.0]
    read = lever_acceleration(up, float(off[0]), float(off[1]), pair.geometry)
    right = lever_acceleration(up, 0.0, 0.0, pair.geometry)
    axis = np.cross(read, right)
    angle = float(np.arctan2(np.linalg.norm(axis), read @ right))
    if angle > 0:
        axis = axis / np.linalg.norm(axis) * angle
    return np.asarray(Rotation.from_rotvec(axis).as_matrix())
