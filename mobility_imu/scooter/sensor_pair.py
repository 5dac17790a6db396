"""Lever and body of a scooter as a pair: their readings, and how well they agree."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.faults import Repair
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.offsets import rest_flags
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs
from mobility_imu.scooter.agreement import (
    Agreement,
    AxisMotions,
    Motion,
    Seen,
    agreement,
    axis_motions,
    motion_of,
    seen_by,
)
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.mount import ScooterMount

__all__ = ["LARGE_OFFSET_RADPS", "SensorPair"]

LARGE_OFFSET_RADPS = float(np.deg2rad(4.5))
"""Data sheets of consumer sensors state up to 3 deg/s at rest, and half as much for warmth."""
SHORTEST_REST_S = 1.0
LARGEST_SPIN = 0.9
"""Part of a rate at rest that lies along gravity from which on a turntable explains it."""
USUAL_RATE_RADPS, USUAL_ANGLE_RAD = 0.03, float(np.deg2rad(5.0))
"""Usual misfits about the locked axis and of both angles, for weights."""


class _Readings(NamedTuple):
    """Both sensors' readings in their own axes, with the offsets at rest taken off."""

    acc: dict[str, FloatArray]
    gyr: dict[str, FloatArray]


class _Rest(NamedTuple):
    """Medians of both sensors' readings at rest, in their own axes."""

    acc: dict[str, FloatArray]
    gyr: dict[str, FloatArray]

    @property
    def offsets(self) -> dict[str, FloatArray]:
        """What the gyroscopes read; none where both sensors stand on something that turns."""
        along = {name: rate @ _direction(self.acc[name]) for name, rate in self.gyr.items()}
        alike = abs(along["lever"] - along["body"]) < LARGE_OFFSET_RADPS / 3
        spins = alike and all(
            abs(along[name]) >= LARGEST_SPIN * np.linalg.norm(rate)
            for name, rate in self.gyr.items()
        )
        return {} if spins else self.gyr


def _direction(vector: FloatArray) -> FloatArray:
    return np.asarray(vector / np.linalg.norm(vector))


class SensorPair:
    """Two sensors, and how well they agree once something is undone."""

    def __init__(
        self, recording: Recording, geometry: ScooterGeometry, mount: ScooterMount | None
    ) -> None:
        self.recording, self.geometry, self.mount = recording, geometry, mount
        self.rate_hz = recording.sampling_rate_hz
        self.rest = _rest_of(recording)
        self.offsets = _offsets(self.rest)
        self.readings = _readings_of(recording, self.offsets)
        self.seen = self.angles(self.readings.acc)
        self.motion = self.moved(self.readings.gyr, self.seen)
        self.stated = agreement(self.seen, self.motion) if self.seen.enough else None
        self.drift: tuple[str, FloatArray] | None = None
        if self.stated is not None and not self.offsets:
            self._take_off(_drift(self))

    def _take_off(self, drift: tuple[str, FloatArray]) -> None:
        """Take an offset off that no rest shows, if the sensors then agree better."""
        name, offset = drift
        gyr = {**self.readings.gyr, name: self.readings.gyr[name] - offset}
        motion = self.moved(gyr, self.seen)
        after = agreement(self.seen, motion)
        assert self.stated is not None
        if after.squared < self.stated.squared or np.abs(offset).max() > LARGE_OFFSET_RADPS:
            self.drift = drift
            self.readings, self.motion = self.readings._replace(gyr=gyr), motion
            self.stated = after

    def turned(self, vectors: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Vectors of lever and body in {T} and {B}."""
        if self.mount is None:
            return vectors["lever"], vectors["body"]
        return self.mount.lever(vectors["lever"]), self.mount.body(vectors["body"])

    def in_own_axes(self, name: str, turn: FloatArray) -> FloatArray:
        """Turn of {T} or {B} in the axes of the sensor that the mount turns into them."""
        if self.mount is None:
            return turn
        to = {
            "lever": self.mount.rotation_lever_imu_to_lever,
            "body": self.mount.rotation_body_imu_to_body,
        }[name]
        return np.asarray(to.T @ turn @ to)

    def angles(self, acc: dict[str, FloatArray]) -> Seen:
        """Angles by accelerations alone."""
        return seen_by(*self.turned(acc), self.rate_hz, self.geometry)

    def moved(self, gyr: dict[str, FloatArray], seen: Seen) -> Motion:
        """Motion by the gyroscopes."""
        return motion_of(*self.turned(gyr), seen, self.rate_hz, self.geometry)

    @cached_property
    def axes(self) -> AxisMotions:
        """What each axis of the gyroscopes adds to the motion."""
        gyr, motions = self.readings.gyr, []
        for name in ("lever", "body"):
            for one in np.eye(3):
                alone = {other: gyr[other] * (one if other == name else 0.0) for other in gyr}
                motions.append(self.moved(alone, self.seen))
        return axis_motions(self.seen, motions)

    def with_rates(self, name: str, factors: FloatArray | float) -> Agreement:
        """Agreement with one gyroscope multiplied."""
        both = np.ones(6)
        both[slice(3) if name == "lever" else slice(3, None)] = factors
        return self.axes.agreement(both)

    def repaired(self, repair: Repair) -> Agreement | None:
        """Agreement of the recording once something is undone; None if most angles have gone."""
        try:
            mended = repair(self.recording)
        except InputError:
            return None
        return self._agreement(_readings_of(mended, _offsets(_rest_of(mended))))

    def in_axes(self, name: str, *, acc: FloatArray, gyr: FloatArray) -> Agreement | None:
        """Agreement with one sensor's halves in other axes; None if most angles have gone.

        ``acc`` and ``gyr``, (3, 3) arrays, take readings into these axes and keep their lengths. So
        the sensor rests when it did, and its medians at rest turn with it.
        """
        raw, rest = _readings_of(self.recording, {}), self.rest
        if rest is not None:
            rest = _Rest(_turned(rest.acc, name, acc), _turned(rest.gyr, name, gyr))
        rates = _less(_turned(raw.gyr, name, gyr), _offsets(rest))
        return self._agreement(_Readings(_turned(raw.acc, name, acc), rates))

    def _agreement(self, readings: _Readings) -> Agreement | None:
        """Agreement of readings; None if most angles have gone."""
        try:
            seen = self.angles(readings.acc)
        except InputError:
            return None
        return agreement(seen, self.moved(readings.gyr, seen)) if seen.enough else None


def _turned(vectors: dict[str, FloatArray], name: str, turn: FloatArray) -> dict[str, FloatArray]:
    """Vectors of both sensors, those of one in other axes."""
    return {**vectors, name: vectors[name] @ turn.T}


def _less(rates: dict[str, FloatArray], offsets: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Rates of both gyroscopes without their offsets, however large these are."""
    return {name: rate - offsets[name] if offsets else rate for name, rate in rates.items()}


def _readings_of(recording: Recording, offsets: dict[str, FloatArray]) -> _Readings:
    """Readings of a recording without its offsets at rest."""
    names = ("lever", "body")
    return _Readings(
        {name: recording.sensor(name).acc_mps2 for name in names},
        _less({name: recording.gyroscope(name) for name in names}, offsets),
    )


def _rest_of(recording: Recording) -> _Rest | None:
    """Medians at rest; None without a second of it."""
    sensors = {name: recording.sensor(name) for name in ("lever", "body")}
    gyr = {name: recording.gyroscope(name) for name in sensors}
    rate_hz, rest = recording.sampling_rate_hz, np.ones(len(recording), np.bool_)
    for name, sensor in sensors.items():
        rest &= rest_flags(sensor.acc_mps2, gyr[name], rate_hz)
    rest = long_runs(rest, max(1, round(SHORTEST_REST_S * rate_hz)), grow=False)
    if not rest.any():
        return None
    return _Rest(
        {name: np.median(sensor.acc_mps2[rest], axis=0) for name, sensor in sensors.items()},
        {name: np.median(rates[rest], axis=0) for name, rates in gyr.items()},
    )


def _offsets(rest: _Rest | None) -> dict[str, FloatArray]:
    """What both gyroscopes read at rest, by sensor, rad/s; empty where nothing shows it."""
    return {} if rest is None else rest.offsets


def _drift(pair: SensorPair) -> tuple[str, FloatArray]:
    """Sensor and offset that explain best what grows, or stays, with the time.

    Hinges and locked axis show an offset; least squares over its three components find it, for each
    sensor by itself.
    """
    fits = {}
    for name in ("lever", "body"):
        before = _residuals(pair, name, np.zeros(3))
        columns = [_residuals(pair, name, np.eye(3)[k]) - before for k in range(3)]
        added = np.asarray(np.linalg.lstsq(np.column_stack(columns), -before, rcond=None)[0], float)
        fits[name] = (rms(_residuals(pair, name, added)), -added)
    name = min(fits, key=lambda one: fits[one][0])
    return name, fits[name][1]


def _residuals(pair: SensorPair, name: str, added_radps: FloatArray) -> FloatArray:
    """What lever and body disagree by, in usual sizes, if a gyroscope read something more."""
    gyr = {**pair.readings.gyr, name: pair.readings.gyr[name] + added_radps}
    motion, seen, good = pair.moved(gyr, pair.seen), pair.seen, pair.seen.good
    time_s = np.arange(len(good)) / pair.rate_hz
    means = motion.means_radps
    parts = [(motion.lever_locked - motion.body_locked + means[2])[good] / USUAL_RATE_RADPS]
    for by_rates, by_acc, mean in (
        (motion.steering_rad, seen.steering_rad, means[0]),
        (motion.throttle_rad, seen.throttle_rad, means[1]),
    ):
        apart = (by_rates + mean * time_s - by_acc)[good]
        parts.append((apart - apart.mean()) / USUAL_ANGLE_RAD)
    return np.concatenate(parts)
