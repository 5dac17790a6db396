"""Rides of a simulated scooter, and faults of its sensors that are put into them.

Sizes are drawn log-uniformly from harmless to gross. Nothing here is shared with what looks for
faults.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.scooter.calibration import calibrate_mount
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.ride import RideAngles, RideSettings, estimate_ride
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import (
    COURSES,
    PARKED_POSES_RAD,
    Course,
    Segment,
    draw_driver,
    draw_scooter,
    simulate_parked,
    simulate_ride,
)
from mobility_imu.simulation.sensor import LPMS_CU2, REAL, SensorModel

SEED = 250_000
"""First seed of scooters, drivers and rides. Nobody had looked at these rides when a check was last
changed. Thresholds were chosen on 15,000 to 21,000, 25,000 to 27,000, 36,000 to 41,000 and 90,000.
"""
SEEN_SEED = 50_000
"""Of an earlier run, after which some checks were changed; examples and tests use it."""
CASES = 100
"""Faults of each kind."""
RIDES = 25
"""Rides that the faults of a kind are put into, four into each; each draws its own."""
FUSION = RideSettings(method="fusion")
_CURVE = 1 / 1.6
_QUARTER_M = np.pi / 2 / _CURVE
ROUND = Course(
    "round",
    (
        Segment(2.0),
        Segment(_QUARTER_M, _CURVE),
        Segment(1.0),
        Segment(_QUARTER_M, -_CURVE),
        Segment(1.0),
        Segment(_QUARTER_M, -_CURVE),
        Segment(1.0),
        Segment(3.0, grade_rad=float(np.deg2rad(5))),
        Segment(1.5),
        Segment(_QUARTER_M, _CURVE),
        Segment(2.0, grade_rad=float(np.deg2rad(-5))),
        Segment(3.0),
    ),
)
"""Curves to both sides and a hill, some 27 s."""


class Ride(NamedTuple):
    """A ride without a fault.

    Parameters
    ----------
    recording : Recording
    mount : ScooterMount of a calibration, or None
    level : "LPMS, calibrated" or "real"
    """

    recording: Recording
    mount: ScooterMount | None
    level: str

    @property
    def found(self) -> RideAngles:
        """Its angles by fusion."""
        return _angles_of(self)


class Case(NamedTuple):
    """A fault that is put into a ride.

    Parameters
    ----------
    sensor : where
    size : in the unit; NaN for a kind without one
    faulty : gives the recording with the fault
    """

    sensor: str
    size: float
    faulty: Callable[[], Recording]


class Kind(NamedTuple):
    """A kind of fault.

    Parameters
    ----------
    draw : a case for a recording, by random numbers
    unit : of the sizes
    codes : by which it is rightly told
    calibrated : whether it is put into rides with a calibrated mount alone
    """

    draw: Callable[[Recording, np.random.Generator], Case]
    unit: str
    codes: tuple[str, ...]
    calibrated: bool = False


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Number drawn log-uniformly.

    Parameters
    ----------
    rng : source of the draw
    low, high : its limits

    Returns
    -------
    float
    """
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _sensor(rng: np.random.Generator) -> str:
    return ("lever", "body")[int(rng.integers(2))]


def _half(rng: np.random.Generator) -> str:
    return ("acc", "gyr")[int(rng.integers(2))]


def _length_s(recording: Recording) -> float:
    return float(recording.time_s[-1] - recording.time_s[0])


def _direction(rng: np.random.Generator) -> FloatArray:
    vector = rng.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def _frozen(ride: Recording, rng: np.random.Generator) -> Case:
    """A tenth of a second passes unseen in any plot, twenty are most of the ride."""
    name, half, size = _sensor(rng), _half(rng), log_uniform(rng, 0.1, 20.0)
    start = float(rng.uniform(0, max(_length_s(ride) - size, 0.1)))
    return Case(f"{name}_{half}", size, lambda: put.freeze(ride, name, half, start, size))


def _dead(ride: Recording, rng: np.random.Generator) -> Case:
    """From the end's last half second to the whole ride."""
    name, size = _sensor(rng), log_uniform(rng, 0.5, _length_s(ride))
    return Case(f"{name}_gyr", size, lambda: put.silence(ride, name, _length_s(ride) - size))


def _clipped(ride: Recording, rng: np.random.Generator) -> Case:
    """Range as a part of the largest reading: from nothing lost to a tenth of it left."""
    name, half, size = _sensor(rng), _half(rng), log_uniform(rng, 0.1, 1.0)
    imu = ride.sensor(name)
    values = imu.acc_mps2 if half == "acc" else ride.gyroscope(name)
    limit = size * float(np.abs(values).max())
    return Case(f"{name}_{half}", size, lambda: put.clip(ride, name, half, limit))


def _spikes(ride: Recording, rng: np.random.Generator) -> Case:
    """One to twenty samples; from what a hand does to beyond what a sensor measures."""
    name, half = _sensor(rng), _half(rng)
    size = log_uniform(rng, 5.0, 5000.0) if half == "acc" else log_uniform(rng, 0.2, 35.0)
    count = int(rng.integers(1, 21))
    places = rng.choice(np.arange(5, len(ride) - 5), count, replace=False)
    axis = int(rng.integers(3))
    return Case(f"{name}_{half}", size, lambda: put.spike(ride, name, half, places, axis, size))


def _offset(ride: Recording, rng: np.random.Generator) -> Case:
    """From a good sensor's offset to what none has that works."""
    name, size = _sensor(rng), log_uniform(rng, 0.5, 60.0)
    vector = np.deg2rad(size) * _direction(rng)
    return Case(f"{name}_gyr", size, lambda: put.offset(ride, name, "gyr", vector))


def _offset_without_rest(ride: Recording, rng: np.random.Generator) -> Case:
    """The same, with the standing at both ends cut off."""
    end = float(ride.time_s[-1])
    return _offset(ride.trim(float(ride.time_s[0]) + 2.0, end - 2.0), rng)


def _scale(ride: Recording, rng: np.random.Generator) -> Case:
    """From a calibrated sensor's 1 % to a range that was mistaken (times 1/4 to 4)."""
    name, size = _sensor(rng), float(np.exp(log_uniform(rng, 0.01, 1.4) * rng.choice([-1, 1])))
    return Case(f"{name}_gyr", size, lambda: put.scale(ride, name, "gyr", size))


def _late(ride: Recording, rng: np.random.Generator) -> Case:
    """From one sample to a second."""
    name, size = _sensor(rng), log_uniform(rng, 0.01, 1.0)
    return Case(name, size, lambda: put.late(ride, name, size))


def _exchanged(ride: Recording, rng: np.random.Generator) -> Case:
    """Without a size: each time another part of a ride."""
    part = _part(ride, rng)
    return Case("lever, body", float("nan"), lambda: put.exchange(part, "lever", "body"))


def _exchanged_halves(ride: Recording, rng: np.random.Generator) -> Case:
    """Both gyroscopes or both accelerometers, each time of another part of a ride."""
    part, half = _part(ride, rng), _half(rng)
    lever, body = part.sensor("lever"), part.sensor("body")
    if half == "acc":  # the other half of the others
        lever, body = body, lever
    wrong = {
        "lever": Imu(lever.acc_mps2, body.gyr_radps),
        "body": Imu(body.acc_mps2, lever.gyr_radps),
    }
    faulty = Recording(part.time_s, {**part.sensors, **wrong}, source=part.source)
    return Case(f"lever_{half}, body_{half}", float("nan"), lambda: faulty)


def _part(ride: Recording, rng: np.random.Generator) -> Recording:
    """Ride from a second or some on, without up to some at the end."""
    first, last = rng.uniform(0, 5, 2)
    return ride.trim(float(ride.time_s[0] + first), float(ride.time_s[-1] - last))


def _turned(ride: Recording, rng: np.random.Generator) -> Case:
    """About any axis, from what a careful hand leaves to a sensor that fell over."""
    name, size = _sensor(rng), log_uniform(rng, 0.5, 90.0)
    turn = Rotation.from_rotvec(np.deg2rad(size) * _direction(rng)).as_matrix()
    return Case(name, size, lambda: put.turn(ride, name, turn))


def _reversed(ride: Recording, rng: np.random.Generator) -> Case:
    """All axes of a gyroscope, or one."""
    part, name = _part(ride, rng), _sensor(rng)
    axis = int(rng.integers(-3, 3))
    signs = -np.ones(3) if axis < 0 else np.where(np.arange(3) == axis, -1.0, 1.0)
    return Case(f"{name}_gyr", float("nan"), lambda: put.reverse(part, name, signs))


def _left_handed(ride: Recording, rng: np.random.Generator) -> Case:
    """One axis of both halves of a sensor."""
    part, name, axis = _part(ride, rng), _sensor(rng), int(rng.integers(3))
    return Case(f"{name}_{'xyz'[axis]}", float("nan"), lambda: put.left_handed(part, name, axis))


def _clock(ride: Recording, rng: np.random.Generator) -> Case:
    """One leap, from a tenth of a sample to ten seconds; each fifth clock runs in ms."""
    if rng.integers(5) == 0:
        time_ms = 1000 * ride.time_s
        return Case("time", 1000.0, lambda: Recording(time_ms, ride.sensors, source=ride.source))
    size = log_uniform(rng, 1e-3, 10.0)
    start, sign = float(rng.uniform(1, _length_s(ride) - 1)), float(rng.choice([-1, 1]))
    return Case("time", size, lambda: put.jump(ride, start, sign * size))


KINDS: dict[str, Kind] = {
    "frozen": Kind(_frozen, "s", ("frozen",)),
    "dead gyroscope": Kind(_dead, "s", ("frozen",)),
    "clipped range": Kind(_clipped, "of the largest", ("range",)),
    "spikes": Kind(_spikes, "m/s² or rad/s", ("spike",)),
    "gyroscope offset": Kind(_offset, "deg/s", ("offset",)),
    "gyroscope offset, no rest": Kind(_offset_without_rest, "deg/s", ("offset",)),
    "gyroscope scale": Kind(_scale, "times", ("scale",)),
    "lag": Kind(_late, "s", ("lag",)),
    "exchanged sensors": Kind(_exchanged, "", ("exchanged",)),
    "turned since the calibration": Kind(_turned, "deg", ("turned", "at odds"), True),
    "reversed gyroscope": Kind(_reversed, "", ("reversed",)),
    "left-handed axes": Kind(_left_handed, "", ("left-handed", "reversed")),
    "clock": Kind(_clock, "s", ("refused",)),
    "exchanged halves": Kind(_exchanged_halves, "", ("exchanged",)),
}
"""Kinds of faults; sizes are drawn log-uniformly from harmless to gross."""
POSES = "poses"
LATER_KINDS = ("exchanged halves",)
DRAWN_BY = {
    kind: number
    for number, kind in enumerate(
        [*(kind for kind in KINDS if kind not in LATER_KINDS), POSES, *LATER_KINDS]
    )
}
"""Number that the cases of a kind are drawn by; a later kind leaves those of the others alone."""


@cache
def ride_of(number: int, first_seed: int = SEED, course: str = "round") -> Ride:
    """Ride without a fault: of calibrated LPMS-CU2, or of sensors as real ones are without mount.

    Parameters
    ----------
    number : of the ride; even ones are calibrated
    first_seed : from which scooters, drivers and rides are drawn
    course : "round" or a name in ``COURSES``

    Returns
    -------
    Ride
    """
    seed, fine = first_seed + number, number % 2 == 0
    unit, sensor = draw_scooter(seed), LPMS_CU2 if fine else REAL
    way = ROUND if course == "round" else COURSES[course]
    ride = simulate_ride(way, seed=seed, unit=unit, driver=draw_driver(seed), sensor=sensor)
    mount = _calibrated(seed, sensor) if fine else None
    return Ride(ride.recording, mount, "LPMS, calibrated" if fine else "real")


@cache
def _angles_of(ride: Ride) -> RideAngles:
    return estimate_ride(ride.recording, SUZUKI_ET4D, ride.mount, FUSION)


def _calibrated(seed: int, sensor: SensorModel) -> ScooterMount:
    parked = [
        simulate_parked(
            pitch_rad=pitch, bank_rad=0.0, seed=2 * seed + k, unit=draw_scooter(seed), sensor=sensor
        )
        for k, pitch in enumerate((0.0, float(np.deg2rad(5))))
    ]
    return calibrate_mount(parked, PARKED_POSES_RAD, SUZUKI_ET4D).mount


def cases_of(kind: str, ride: int) -> int:
    """Number of faults of a kind that are put into a ride.

    Parameters
    ----------
    kind : of :data:`KINDS`
    ride : number

    Returns
    -------
    int
    """
    if not KINDS[kind].calibrated:
        return CASES // RIDES
    calibrated = (RIDES + 1) // 2
    least, more = divmod(CASES, calibrated)
    return (least + (ride // 2 < more)) if ride % 2 == 0 else 0
