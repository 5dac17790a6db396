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
    with_half,
    with_readings,
)
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.offsets import rest_flags, rest_offsets, without_offsets
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs
from mobility_imu.scooter.agreement import (
    Agreement,
    Lag,
    Motion,
    Seen,
    agreement,
    lag_between,
    motion_of,
    seen_by,
)
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.machine import zeros_of
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.pose_check import pose_uncertainty

__all__ = ["contradictions"]

CLEARLY_BETTER = 0.5
"""By how much a fault, undone, has to make the sum of squared misfits smaller; 3 is usual."""
AT_ODDS = 12.0
"""Sum of squared misfits of sensors that contradict each other: twice what is usual of each."""
SURE_LAG = 0.7
"""Correlation about the locked axis from which on a lag is believed."""
SMALLEST_LAG_S, LAG_SDS = 0.01, 5.0
"""A lag of a sample moves nothing, and is within what joining two clocks leaves."""
SMALLEST_SCALE, LARGEST_SCALE = 0.07, 3.0
"""Scale errors of gyroscopes end at 3 % (data sheets of consumer sensors), and mounts that are off
by 2 deg move what is found by as much again."""
LARGE_OFFSET_RADPS = float(np.deg2rad(5.0))
"""Data sheets of consumer sensors state up to 3 deg/s at rest; recordings of others show 1.7 deg/s
on an axis (median of a chair's wheels, data/reference/real_sensors.csv), of which this is three."""
SHORTEST_REST_S = 1.0
LARGEST_SPIN = 0.9
"""Part of a rate at rest that lies along gravity from which on a turntable explains it."""
ZERO_SDS = 3.5
"""Standard deviations by which a zero may be off; by chance one ride in 2000 has more."""
QUARTERS_DEG = (90.0, 180.0, 270.0)


class _Readings(NamedTuple):
    """Both sensors' readings in their own axes, with the offsets at rest taken off."""

    acc: dict[str, FloatArray]
    gyr: dict[str, FloatArray]


class _Pair:
    """Two sensors, and how well they agree once something is undone."""

    def __init__(
        self, recording: Recording, geometry: ScooterGeometry, mount: ScooterMount | None
    ) -> None:
        self.recording, self.geometry, self.mount = recording, geometry, mount
        self.rate_hz = recording.sampling_rate_hz
        self.readings = self.of(recording)
        self.seen = self.angles(self.readings.acc)
        self.motion = self.moved(self.readings.gyr, self.seen)
        self.stated = agreement(self.seen, self.motion) if self.seen.enough else None

    def of(self, recording: Recording) -> _Readings:
        """Readings of a recording."""
        still = without_offsets(recording, rest_offsets(recording, ("lever", "body")))
        names = ("lever", "body")
        return _Readings(
            {name: still.sensor(name).acc_mps2 for name in names},
            {name: still.gyroscope(name) for name in names},
        )

    def turned(self, vectors: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Vectors of lever and body in {T} and {B}."""
        if self.mount is None:
            return vectors["lever"], vectors["body"]
        return self.mount.lever(vectors["lever"]), self.mount.body(vectors["body"])

    def angles(self, acc: dict[str, FloatArray]) -> Seen:
        """Angles by accelerations alone."""
        return seen_by(*self.turned(acc), self.rate_hz, self.geometry)

    def moved(self, gyr: dict[str, FloatArray], seen: Seen) -> Motion:
        """Motion by the gyroscopes."""
        return motion_of(*self.turned(gyr), seen, self.rate_hz, self.geometry)

    def with_rates(self, name: str, factors: FloatArray | float) -> Agreement:
        """Agreement with one gyroscope multiplied."""
        gyr = {**self.readings.gyr, name: self.readings.gyr[name] * factors}
        return agreement(self.seen, self.moved(gyr, self.seen))

    def repaired(self, repair: Repair) -> Agreement | None:
        """Agreement of the recording once something is undone; None if most angles have gone."""
        try:
            readings = self.of(repair(self.recording))
            seen = self.angles(readings.acc)
        except InputError:
            return None
        if not seen.enough:
            return None
        return agreement(seen, self.moved(readings.gyr, seen))


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
    try:
        pair = _Pair(recording, geometry, mount)
    except InputError:
        return  # gravity is missing or reversed: the estimate says it
    suspects = [*_exchange(pair)]
    if pair.stated is not None:
        lag = lag_between(pair.motion, pair.seen.good, pair.rate_hz)
        suspects += [*_signs(pair), *_scales(pair), *_late(pair, lag), *_quarters(pair)]
    found = _best(pair, suspects)
    if found is not None:
        yield fault_of(
            recording, found.code, found.sensor, whole, found.what,
            size=found.size, unit=found.unit, repair=found.repair,
        )  # fmt: skip
        return
    if pair.stated is None:
        return
    if pair.stated.squared > AT_ODDS:
        yield fault_of(
            recording, "at odds", "lever, body", whole,
            "contradict each other: no angles of the controls explain both, and nothing that was "
            "tried makes them agree; look at how they are mounted and exported. What follows has "
            "no known error", size=float(np.sqrt(pair.stated.squared / 3)), unit="times the usual",
        )  # fmt: skip
        return
    yield from _offset(pair)
    yield from _turned_since(pair)


def _best(pair: _Pair, suspects: list[_Suspect]) -> _Suspect | None:
    """Suspect without which the sensors agree best, if they do so clearly better."""
    if not suspects:
        return None
    best = min(suspects, key=lambda s: s.after.squared)
    late = [s for s in suspects if s.code == "lag"]
    if best.code == "reversed" and late and late[0].after.correlation > best.after.correlation:
        # An axis across the turns, reversed, looks much like a lag, but not in the correlation.
        best = late[0]
    if pair.stated is None or best.code == "lag":
        return best
    better = pair.stated.squared - best.after.squared
    return best if better > CLEARLY_BETTER else (late[0] if late else None)


def _signs(pair: _Pair) -> Iterator[_Suspect]:
    for name in ("lever", "body"):
        for signs in product((1.0, -1.0), repeat=3):
            bad = [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
            if not bad:
                continue
            what = "all axes" if len(bad) == 3 else f"axis {', '.join(bad)}"
            other = "body" if name == "lever" else "lever"
            yield _Suspect(
                "reversed", f"{name}_gyr",
                f"turns the other way than its accelerometer and the {other}'s sensor show: {what} "
                "of the gyroscope has the wrong sign; check the export's axes",
                float("nan"), "",
                partial(multiplied, sensor=name, half="gyr", factors=np.array(signs)),
                pair.with_rates(name, np.array(signs)),
            )  # fmt: skip


def _scales(pair: _Pair) -> Iterator[_Suspect]:
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


def _late(pair: _Pair, lag: Lag) -> Iterator[_Suspect]:
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


def _exchange(pair: _Pair) -> Iterator[_Suspect]:
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


def _quarters(pair: _Pair) -> Iterator[_Suspect]:
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


def turned_back(recording: Recording, sensor: str, rotation: FloatArray) -> Recording:
    """Recording in which a sensor's readings are turned.

    Parameters
    ----------
    recording : Recording
    sensor : name
    rotation : (3, 3) array, from the sensor's axes to those that it should have

    Returns
    -------
    Recording
    """
    imu = recording.sensor(sensor)
    return with_readings(
        recording,
        sensor,
        acc_mps2=imu.acc_mps2 @ rotation.T,
        gyr_radps=None if imu.gyr_radps is None else imu.gyr_radps @ rotation.T,
    )


def shifted_rates(recording: Recording, sensor: str, offset_radps: FloatArray) -> Recording:
    """Recording in which an offset is taken off a gyroscope.

    Parameters
    ----------
    recording : Recording
    sensor : name
    offset_radps : (3,) array, rad/s, in the sensor's axes

    Returns
    -------
    Recording
    """
    return with_half(recording, sensor, "gyr", recording.gyroscope(sensor) - offset_radps)


def _offset(pair: _Pair) -> Iterator[Fault]:
    """Large offsets: at rest of each gyroscope, else of one against the other."""
    recording = pair.recording
    whole = np.ones(len(recording), np.bool_)
    rest = np.ones(len(recording), np.bool_)
    for name in ("lever", "body"):
        rest &= rest_flags(
            recording.sensor(name).acc_mps2, recording.gyroscope(name), pair.rate_hz
        )
    rest = long_runs(rest, max(1, round(SHORTEST_REST_S * pair.rate_hz)), grow=False)
    if rest.any():
        for name in ("lever", "body"):
            offset = np.median(recording.gyroscope(name)[rest], axis=0)
            size = float(np.abs(offset).max())
            if size > LARGE_OFFSET_RADPS and not _spins(recording, rest):
                shown = ", ".join(f"{value:.1f}" for value in np.rad2deg(offset))
                yield fault_of(
                    recording, "offset", f"{name}_gyr", whole,
                    f"reads ({shown}) deg/s at rest; let the sensor warm up, or take the offset "
                    "off", size=float(np.rad2deg(size)), unit="deg/s",
                    repair=partial(shifted_rates, sensor=name, offset_radps=offset),
                )  # fmt: skip
        return
    drift = _drift(pair)
    size = float(np.abs(drift).max())
    if size > LARGE_OFFSET_RADPS:
        yield fault_of(
            recording, "offset", "lever_gyr, body_gyr", whole,
            f"drift apart by {np.rad2deg(size):.1f} deg/s, and no rest shows which of them has the "
            "offset; let the scooter stand for some seconds at the beginning",
            size=float(np.rad2deg(size)), unit="deg/s",
            repair=partial(shifted_rates, sensor="lever", offset_radps=_in_lever(pair, drift)),
        )  # fmt: skip


def _spins(recording: Recording, rest: FloatArray) -> bool:
    """Whether both sensors turn alike about gravity: then they stand on something that turns."""
    rates = []
    for name in ("lever", "body"):
        up = np.median(recording.sensor(name).acc_mps2[rest], axis=0)
        gyr = np.median(recording.gyroscope(name)[rest], axis=0)
        along = float(gyr @ up / np.linalg.norm(up))
        if abs(along) < LARGEST_SPIN * np.linalg.norm(gyr):
            return False
        rates.append(along)
    return bool(abs(rates[0] - rates[1]) < LARGE_OFFSET_RADPS / 3)


def _drift(pair: _Pair) -> FloatArray:
    """Offset of the lever's gyroscope less the body's, (3,): steering, throttle, locked axis."""
    good, means = pair.seen.good, pair.motion.means_radps
    place = np.flatnonzero(good) / pair.rate_hz
    slopes = [
        float(np.polyfit(place, (by_rates - by_acc)[good], 1)[0])
        for by_rates, by_acc in (
            (pair.motion.steering_rad, pair.seen.steering_rad),
            (pair.motion.throttle_rad, pair.seen.throttle_rad),
        )
    ]
    return np.array([means[0] + slopes[0], means[1] + slopes[1], means[2]])


def _in_lever(pair: _Pair, drift: FloatArray) -> FloatArray:
    """Drift of the hinges as an offset of the lever's gyroscope, at its usual tip."""
    tip = float(np.median(pair.seen.throttle_rad)) + pair.geometry.lean_rad
    sin, cos = np.sin(tip), np.cos(tip)
    shaft, throttle, across = drift
    offset = np.array([-throttle, across * cos - shaft * sin, across * sin + shaft * cos])
    return offset if pair.mount is None else offset @ pair.mount.rotation_lever_imu_to_lever


def _turned_since(pair: _Pair) -> Iterator[Fault]:
    """Zeros of steering and throttle that are off by more than the mount is uncertain."""
    body_acc, body_gyr = (
        pair.turned(vectors)[1] for vectors in (pair.readings.acc, pair.readings.gyr)
    )
    rest = np.ones(len(body_acc), np.bool_)
    for name in ("lever", "body"):
        rest &= rest_flags(pair.readings.acc[name], pair.readings.gyr[name], pair.rate_hz)
    zeros = zeros_of(pair.seen, body_acc, body_gyr, rest, pair.rate_hz)
    calibrated = pair.mount is not None and pair.mount.sd_rad is not None
    sd = pose_uncertainty([[0.0, 0.0]], pair.geometry, calibrated=calibrated)[0]
    off = np.array([zeros.steering_rad, zeros.throttle_rad])
    off = np.where(np.abs(off) > ZERO_SDS * sd, off, 0.0)  # NaN is no finding
    if not off.any():
        return
    says = []
    if off[0]:
        says.append(f"the steering is {np.rad2deg(off[0]):+.1f} deg while it drives straight on")
    if off[1]:
        says.append(f"the throttle is {np.rad2deg(off[1]):+.1f} deg while it stands")
    yield fault_of(
        pair.recording, "turned", "lever, body", np.ones(len(body_acc), np.bool_),
        f"are not mounted as stated: {' and '.join(says)}; was one turned since the calibration? "
        "Calibrate the mount", size=float(np.rad2deg(np.abs(off).max())), unit="deg",
        repair=partial(turned_back, sensor="lever", rotation=_untwisted(pair, off)),
    )  # fmt: skip


def _untwisted(pair: _Pair, off: FloatArray) -> FloatArray:
    """Turn of the lever's sensor that takes both zeros to zero, in its own axes."""
    from mobility_imu.scooter.geometry import lever_acceleration

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
