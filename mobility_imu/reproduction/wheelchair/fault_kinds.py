"""Drives without a fault, and the kinds of faults that are put into them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.sensor import LPMS_CU2, MTI_1, REAL, SensorModel
from mobility_imu.simulation.wheelchair import Court, Leg, random_court, simulate_court
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount

__all__ = ["KINDS", "MODELS", "Drive", "Injected", "clean_drive"]

SENSORS = ("frame", "left_wheel", "right_wheel")
WIDE = replace(
    LPMS_CU2,
    acc=replace(LPMS_CU2.acc, full_scale=16 * 9.80665),
    gyr=replace(LPMS_CU2.gyr, full_scale=float(np.deg2rad(2000))),
)
"""The scooter paper's sensor, set to ranges that a chair does not reach."""
PUNCTUAL = replace(
    REAL,
    acc=replace(REAL.acc, scale_sd=0.003),
    gyr=replace(REAL.gyr, scale_sd=0.003, misalignment_sd_rad=MTI_1.gyr.misalignment_sd_rad),
    delivery=replace(REAL.delivery, late_s=0.0),
)
"""Noise, offsets, steps, doubled and lost samples of real recordings, without what is a fault to
these looks: sensors up to 0.03 s late, and scale factors and axes off by 1 %."""
MODELS: dict[str, SensorModel] = {"MTi-1": MTI_1, "LPMS": WIDE, "real, punctual": PUNCTUAL}


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive with what its analysis needs.

    Parameters
    ----------
    court : Court, of chair and mounting
    model : of the sensors
    trial, static, straight : Recording
    """

    court: Court
    model: SensorModel
    trial: Recording
    static: Recording
    straight: Recording

    def calibration(self) -> WheelchairCalibration:
        """Mount and offsets, as the trials give them."""
        return calibrate_mount(self.static, self.straight)


def clean_drive(seed: int, model: SensorModel = MTI_1, *, rests: bool = True) -> Drive:
    """A random court without a fault.

    Parameters
    ----------
    seed : of the court
    model : of the sensors
    rests : False leaves out rests and all tasks that need one, and cuts off both ends

    Returns
    -------
    Drive
    """
    court = random_court(seed)
    if not rests:
        moving = tuple(leg for leg in court.legs if leg.task in (2, 5, 6))
        court = replace(court, legs=(Leg(1, 1.5), *moving, Leg(1, 1.5)), slips=())
    static, straight = court.calibration_trials(model)
    trial = court.drive(model).recording
    if not rests:
        trial = trial.trim(float(trial.time_s[0]) + 3.0, float(trial.time_s[-1]) - 3.0)
    return Drive(court, model, trial, static.recording, straight.recording)


@dataclass(frozen=True)
class Injected:
    """A drive with a fault.

    Parameters
    ----------
    drive : Drive, with the fault
    sensor, size, unit : of the fault
    """

    drive: Drive
    sensor: str
    size: float
    unit: str


Injection = Callable[[Drive, np.random.Generator], Injected]


def _size(rng: np.random.Generator, least: float, most: float) -> float:
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def _sensor(rng: np.random.Generator, among: Sequence[str] = SENSORS) -> str:
    return str(among[int(rng.integers(len(among)))])


def _direction(rng: np.random.Generator) -> FloatArray:
    vector = rng.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def _start(drive: Drive, rng: np.random.Generator) -> float:
    return float(rng.uniform(0.05, 0.85) * (drive.trial.time_s[-1] - drive.trial.time_s[0]))


def _with(drive: Drive, trial: Recording, sensor: str, size: float, unit: str) -> Injected:
    return Injected(replace(drive, trial=trial), sensor, size, unit)


def freezes(drive: Drive, rng: np.random.Generator) -> Injected:
    """One gyroscope repeats its last reading, for 0.05 s (a lost packet) to 40 s."""
    sensor, length = _sensor(rng), _size(rng, 0.05, 40.0)
    trial = inject.freeze(drive.trial, sensor, "gyr", _start(drive, rng), length)
    return _with(drive, trial, f"{sensor}_gyr", length, "s")


def whole_sensor_freezes(drive: Drive, rng: np.random.Generator) -> Injected:
    """Both halves of a sensor repeat their last reading, for 0.05 to 40 s."""
    sensor, length, start = _sensor(rng), _size(rng, 0.05, 40.0), _start(drive, rng)
    trial = drive.trial
    for half in ("acc", "gyr"):
        trial = inject.freeze(trial, sensor, half, start, length)
    return _with(drive, trial, sensor, length, "s")


def dies(drive: Drive, rng: np.random.Generator) -> Injected:
    """A gyroscope reads zero for the last 0.1 to 60 s."""
    sensor, length = _sensor(rng), _size(rng, 0.1, 60.0)
    duration = float(drive.trial.time_s[-1] - drive.trial.time_s[0])
    trial = inject.silence(drive.trial, sensor, max(duration - length, 0.0))
    return _with(drive, trial, f"{sensor}_gyr", length, "s")


def axis_dies(drive: Drive, rng: np.random.Generator) -> Injected:
    """One axis of a gyroscope reads zero throughout; mountings at random make it matter or not."""
    sensor, axis = _sensor(rng), int(rng.integers(3))
    factors = np.ones(3)
    factors[axis] = 0.0
    trial = inject.scale(drive.trial, sensor, "gyr", factors)
    part = _axis_of(drive, sensor)[axis] ** 2
    return _with(drive, trial, f"{sensor}_gyr_{'xyz'[axis]}", float(part), "")


def _axis_of(drive: Drive, sensor: str) -> FloatArray:
    """Axle or vertical in the sensor's axes, by the simulation."""
    mounting = drive.court.mounting[sensor]
    return np.asarray(mounting.rotation_body_to_imu[:, 2])


def range_of_gyroscope(drive: Drive, rng: np.random.Generator) -> Injected:
    """A gyroscope's range ends at 0.5 to 12 rad/s (a wheel at 3 m/s turns at 10)."""
    sensor, limit = _sensor(rng), _size(rng, 0.5, 12.0)
    trial = inject.clip(drive.trial, sensor, "gyr", limit)
    return _with(drive, trial, f"{sensor}_gyr", limit, "rad/s")


def range_of_accelerometer(drive: Drive, rng: np.random.Generator) -> Injected:
    """An accelerometer's range ends at 9.9 to 40 m/s²."""
    sensor, limit = _sensor(rng), _size(rng, 9.9, 40.0)
    trial = inject.clip(drive.trial, sensor, "acc", limit)
    return _with(drive, trial, f"{sensor}_acc", limit, "m/s²")


def spikes_of_gyroscope(drive: Drive, rng: np.random.Generator) -> Injected:
    """One to five readings with a flipped bit: 0.001 to 35 rad/s of a range of 2000 deg/s."""
    sensor, size = _sensor(rng), _size(rng, 0.001, 35.0)
    return _spiked(drive, rng, sensor, "gyr", size, "rad/s")


def spikes_of_accelerometer(drive: Drive, rng: np.random.Generator) -> Injected:
    """One to five readings with a flipped bit: 0.005 to 157 m/s² of a range of 16 g."""
    sensor, size = _sensor(rng), _size(rng, 0.005, 157.0)
    return _spiked(drive, rng, sensor, "acc", size, "m/s²")


def _spiked(
    drive: Drive, rng: np.random.Generator, sensor: str, half: str, size: float, unit: str
) -> Injected:
    places = rng.integers(5, len(drive.trial) - 5, int(rng.integers(1, 6)))
    axis, sign = int(rng.integers(3)), 1.0 if rng.random() < 0.5 else -1.0
    trial = inject.spike(drive.trial, sensor, half, np.unique(places), axis, sign * size)
    return _with(drive, trial, f"{sensor}_{half}", size, unit)


def beyond_any_range(drive: Drive, rng: np.random.Generator) -> Injected:
    """Readings that are off by 45 to 1.1e6 rad/s, or by 4400 to 1.1e6 m/s²."""
    half, least = ("gyr", 41.0) if rng.random() < 0.5 else ("acc", 4001.0)
    size = _size(rng, least, 1e6)
    return _spiked(drive, rng, _sensor(rng), half, 1.1 * size, "rad/s" if half == "gyr" else "m/s²")


def offset(drive: Drive, rng: np.random.Generator) -> Injected:
    """A gyroscope's offset of 0.02 to 8 deg/s in any direction."""
    sensor, size = _sensor(rng), _size(rng, 0.02, 8.0)
    trial = inject.offset(drive.trial, sensor, "gyr", np.deg2rad(size) * _direction(rng))
    return _with(drive, trial, f"{sensor}_gyr", size, "deg/s")


def scale_of_wheel(drive: Drive, rng: np.random.Generator) -> Injected:
    """A wheel's gyroscope reads 0.1 to 60 % too much or too little."""
    return _scaled(drive, rng, _sensor(rng, SENSORS[1:]))


def scale_of_frame(drive: Drive, rng: np.random.Generator) -> Injected:
    """The frame's gyroscope reads 0.1 to 60 % too much or too little."""
    return _scaled(drive, rng, "frame")


def _scaled(drive: Drive, rng: np.random.Generator, sensor: str) -> Injected:
    size, sign = _size(rng, 0.001, 0.6), 1.0 if rng.random() < 0.5 else -1.0
    trial = inject.scale(drive.trial, sensor, "gyr", 1 + sign * size)
    return _with(drive, trial, f"{sensor}_gyr", size, "")


def lag(drive: Drive, rng: np.random.Generator) -> Injected:
    """A sensor comes late by 0.005 s (half a sample) to 2 s."""
    sensor, size = _sensor(rng), _size(rng, 0.005, 2.0)
    return _with(drive, inject.late(drive.trial, sensor, size), sensor, size, "s")


def exchanged_in_trial(drive: Drive, rng: np.random.Generator) -> Injected:
    """Left and right wheel have each other's names in the trial."""
    trial = inject.exchange(drive.trial, "left_wheel", "right_wheel")
    return _with(drive, trial, "left_wheel, right_wheel", float("nan"), "")


def exchanged_everywhere(drive: Drive, rng: np.random.Generator) -> Injected:
    """Left and right wheel have each other's names in all three recordings."""
    three = (
        inject.exchange(one, "left_wheel", "right_wheel")
        for one in (drive.trial, drive.static, drive.straight)
    )
    faulty = Drive(drive.court, drive.model, *three)
    return Injected(faulty, "left_wheel, right_wheel", float("nan"), "")


def frame_for_wheel(drive: Drive, rng: np.random.Generator) -> Injected:
    """The frame and a wheel have each other's names in the trial."""
    wheel = _sensor(rng, SENSORS[1:])
    trial = inject.exchange(drive.trial, "frame", wheel)
    return _with(drive, trial, f"frame, {wheel}", float("nan"), "")


def turned_frame(drive: Drive, rng: np.random.Generator) -> Injected:
    """The frame's sensor is turned by 0.3 to 180 deg about any axis after the static trial."""
    return _turned(drive, rng, "frame")


def turned_wheel(drive: Drive, rng: np.random.Generator) -> Injected:
    """A wheel's sensor is turned by 0.3 to 180 deg about any axis after the straight trial."""
    return _turned(drive, rng, _sensor(rng, SENSORS[1:]))


def _turned(drive: Drive, rng: np.random.Generator, sensor: str) -> Injected:
    size = _size(rng, 0.3, 180.0)
    rotation = Rotation.from_rotvec(np.deg2rad(size) * _direction(rng)).as_matrix()
    return _with(drive, inject.turn(drive.trial, sensor, rotation), sensor, size, "deg")


def reversed_gyroscope(drive: Drive, rng: np.random.Generator) -> Injected:
    """All axes of a gyroscope have the wrong sign in the trial."""
    sensor = _sensor(rng)
    trial = inject.reverse(drive.trial, sensor)
    return _with(drive, trial, f"{sensor}_gyr", float("nan"), "")


def left_handed(drive: Drive, rng: np.random.Generator) -> Injected:
    """One axis of a sensor has the wrong sign in both halves in the trial.

    The size is that axis' part of the turn. The other two sensors do not know of an axis across
    the turn: what is told goes by the turn, as of one wrong sign of the gyroscope.
    """
    sensor, axis = _sensor(rng), int(rng.integers(3))
    trial = inject.left_handed(drive.trial, sensor, axis)
    return _with(drive, trial, sensor, float(_axis_of(drive, sensor)[axis] ** 2), "")


def one_wrong_sign(drive: Drive, rng: np.random.Generator) -> Injected:
    """One axis of a gyroscope has the wrong sign in the trial; the size is its part of the turn.

    On a level floor the frame turns about the vertical only: an axis whose part of it is a then
    reads as if the scale were off by 2 a, and "scale" is a right name.
    """
    sensor, axis = _sensor(rng), int(rng.integers(3))
    signs = np.ones(3)
    signs[axis] = -1.0
    trial = inject.reverse(drive.trial, sensor, signs)
    part = float(_axis_of(drive, sensor)[axis] ** 2)
    return _with(drive, trial, f"{sensor}_gyr", part, "")


def clock(drive: Drive, rng: np.random.Generator) -> Injected:
    """Times in milliseconds, or a clock that jumps by 0.02 to 100 s."""
    time_s = np.array(drive.trial.time_s)
    if rng.random() < 0.3:
        size, time_s = 1000.0, 1000 * time_s
    else:
        size = _size(rng, 0.02, 100.0)
        back = -1.0 if rng.random() < 0.3 else 1.0
        time_s[int(rng.integers(10, len(time_s) - 10)) :] += back * size
    trial = Recording(time_s, drive.trial.sensors, source="a faulty clock")
    return _with(drive, trial, "time_s", size, "s")


def tipped_static(drive: Drive, rng: np.random.Generator) -> Injected:
    """The chair is tipped by 0.3 to 60 deg in the last two thirds of the static trial."""
    size = _size(rng, 0.3, 60.0)
    static = inject.tip(drive.static, "frame", _direction(rng), np.deg2rad(size), 1.0, 0.5)
    return Injected(replace(drive, static=static), "frame", size, "deg")


def turning_straight(drive: Drive, rng: np.random.Generator) -> Injected:
    """The chair turns by 1 to 300 deg in the straight-line trial."""
    size, sign = _size(rng, 1.0, 300.0), 1.0 if rng.random() < 0.5 else -1.0
    legs = (Leg(1, 1.0), Leg(2, 5.0, 1.2, sign * size / 5.0), Leg(1, 1.0))
    court = drive.court
    run = simulate_court(
        legs, court.geometry, court.mounting, seed=3 * court.seed + 2, unit_seed=court.seed,
        toe_rad=court.toe_rad, pushing=court.pushing, model=drive.model,
    )  # fmt: skip
    return Injected(replace(drive, straight=run.recording), "frame", size, "deg")


def another_frame(drive: Drive, rng: np.random.Generator) -> Injected:
    """The frame's readings are those of another drive of the same chair."""
    legs = tuple(reversed(drive.court.legs))
    other = replace(drive.court, legs=legs, slips=(), seed=drive.court.seed).drive(drive.model)
    imu = other.recording.sensor("frame")
    trial = Recording(
        drive.trial.time_s, {**drive.trial.sensors, "frame": imu}, source=drive.trial.source
    )
    return _with(drive, trial, "frame", float("nan"), "")


def copied_sensor(drive: Drive, rng: np.random.Generator) -> Injected:
    """One sensor's readings stand for two."""
    first, second = rng.permutation(list(SENSORS))[:2]
    sensors = {**drive.trial.sensors, str(second): drive.trial.sensor(str(first))}
    trial = Recording(drive.trial.time_s, sensors, source=drive.trial.source)
    return _with(drive, trial, f"{first}, {second}", float("nan"), "")


KINDS: dict[str, tuple[Injection, frozenset[str], bool]] = {
    "gyroscope freezes": (freezes, frozenset({"frozen"}), True),
    "sensor freezes": (whole_sensor_freezes, frozenset({"frozen"}), True),
    "gyroscope dies": (dies, frozenset({"frozen"}), True),
    "axis dies": (axis_dies, frozenset({"dead axis"}), True),
    "range, gyroscope": (range_of_gyroscope, frozenset({"range"}), True),
    "range, accelerometer": (range_of_accelerometer, frozenset({"range"}), True),
    "spikes, gyroscope": (spikes_of_gyroscope, frozenset({"spike"}), True),
    "spikes, accelerometer": (spikes_of_accelerometer, frozenset({"spike"}), True),
    "beyond any range": (beyond_any_range, frozenset(), True),
    "offset, rests": (offset, frozenset({"offset"}), True),
    "offset, no rest": (offset, frozenset({"offset"}), False),
    "scale, wheel": (scale_of_wheel, frozenset({"scale"}), True),
    "scale, frame": (scale_of_frame, frozenset({"scale"}), True),
    "lag": (lag, frozenset({"lag"}), True),
    "exchanged in the trial": (exchanged_in_trial, frozenset({"exchanged"}), True),
    "exchanged everywhere": (exchanged_everywhere, frozenset({"exchanged"}), True),
    "frame for wheel": (frame_for_wheel, frozenset({"exchanged", "turned"}), True),
    "turned frame": (turned_frame, frozenset({"turned"}), True),
    "turned wheel": (turned_wheel, frozenset({"turned"}), True),
    "reversed gyroscope": (reversed_gyroscope, frozenset({"reversed"}), True),
    "left-handed": (left_handed, frozenset({"reversed", "turned", "scale"}), True),
    "clock": (clock, frozenset({"clock"}), True),
    "static trial tipped": (tipped_static, frozenset({"turned"}), True),
    "straight trial turns": (turning_straight, frozenset(), True),
    "another drive's frame": (another_frame, frozenset({"at odds", "lag"}), True),
    "copy": (copied_sensor, frozenset({"copy"}), True),
    "one wrong sign": (one_wrong_sign, frozenset({"reversed", "turned", "scale"}), True),
}
"""Kinds of faults: how each is injected, by which codes it is rightly named, and whether the drive
has rests. Where no code is right, only a refusal is."""
