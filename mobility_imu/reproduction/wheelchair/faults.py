"""Faults put into simulated drives: which are found, what they cost, and what is told of that.

Each kind has a hundred drives, on seeds that nothing was set on. Sizes are drawn evenly in their
logarithm, from what changes nothing to what spoils the drive. A fault matters if it moves speed or
yaw rate somewhere by more than twice the standard deviation that the result without it states.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.faults import Fault
from mobility_imu.frames import FloatArray
from mobility_imu.offsets import GyroscopeOffset
from mobility_imu.recording import Recording
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.sensor import LPMS_CU2, MTI_1, REAL, SensorModel
from mobility_imu.simulation.wheelchair import Court, Leg, random_court, simulate_court
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount
from mobility_imu.wheelchair.faults import find_faults, results
from mobility_imu.wheelchair.velocity import ChairVelocity, estimate_velocity

__all__ = ["CASES", "KINDS", "Drive", "clean_drive", "example", "study"]

CASES = 100
"""Drives of each kind."""
POOL = 25
"""Clean drives that the kinds share; places and sizes are drawn anew for each case."""
FIRST_SEED = 7000
SENSORS = ("frame", "left_wheel", "right_wheel")
MATTERS = 2.0
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


@lru_cache(maxsize=2 * POOL)
def _pool(k: int, rests: bool = True) -> Drive:
    return clean_drive(FIRST_SEED + k, tuple(MODELS.values())[k % 2], rests=rests)


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
    """A reading of 41 to 1e6 rad/s, or of 4001 to 1e8 m/s²."""
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
    """One axis of a gyroscope has the wrong sign in the trial; the size is its part of the turn."""
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
    "left-handed": (left_handed, frozenset({"reversed", "turned"}), True),
    "clock": (clock, frozenset({"clock"}), True),
    "static trial tipped": (tipped_static, frozenset({"turned"}), True),
    "straight trial turns": (turning_straight, frozenset(), True),
    "another drive's frame": (another_frame, frozenset({"at odds", "lag"}), True),
    "copy": (copied_sensor, frozenset({"copy"}), True),
}
"""Kinds of faults: how each is injected, by which codes it is rightly named, and whether the drive
has rests. Where no code is right, only a refusal is."""


def one_case(kind: str, case: int) -> dict[str, Any]:
    """Inject one fault and look for it.

    Parameters
    ----------
    kind : a key of :data:`KINDS`
    case : 0 to 99

    Returns
    -------
    dict
        ``sensor``, ``size``, ``unit``; ``ratio``: largest change in standard deviations (infinite
        if the estimate refuses); ``of``: the result that changes most by it; ``found_as``: codes,
        or "refused"; ``right``: whether the kind is rightly named or refused; ``cost_real`` and
        ``cost_stated`` of that result, None where there is none
    """
    injection, codes, rests = KINDS[kind]
    rng = stream(FIRST_SEED, list(KINDS).index(kind), case)
    clean = _pool(case % POOL, rests)
    row: dict[str, Any] = {"kind": kind, "case": case}
    try:
        faulty = injection(clean, rng)
        row |= {"sensor": faulty.sensor, "size": faulty.size, "unit": faulty.unit}
        calibration = faulty.drive.calibration()
        found = find_faults(
            faulty.drive.trial,
            clean.court.geometry,
            calibration.mount,
            offsets=calibration.offsets,
        )
        told = sorted({fault.code for fault in found})
        drive = _estimate(faulty.drive, calibration)
    except InputError as refusal:
        return row | {"ratio": float("inf"), "found_as": "refused", "right": True,
                      "why": str(refusal)[:80]}  # fmt: skip
    row |= {"found_as": ", ".join(told), "right": bool(codes & set(told))}
    return row | _moved(_clean_result(case % POOL, rests), drive, found, codes)


def _estimate(drive: Drive, calibration: WheelchairCalibration) -> ChairVelocity:
    return estimate_velocity(
        drive.trial, drive.court.geometry, calibration.mount, offsets=calibration.offsets
    )


@lru_cache(maxsize=2 * POOL)
def _clean_result(k: int, rests: bool) -> ChairVelocity:
    drive = _pool(k, rests)
    return _estimate(drive, drive.calibration())


def _moved(
    clean: ChairVelocity, faulty: ChairVelocity, found: tuple[Fault, ...], codes: frozenset[str]
) -> dict[str, Any]:
    """How far the results moved, in standard deviations and in their unit, and what was stated."""
    speed = np.abs(faulty.linear_velocity_mps - clean.linear_velocity_mps)
    turn = np.rad2deg(np.abs(faulty.yaw_rate_radps - clean.yaw_rate_radps))
    by_sd = {
        "speed": float((speed / clean.linear_velocity_sd_mps).max()),
        "yaw rate": float((turn / np.rad2deg(clean.yaw_rate_sd_radps)).max()),
    }
    of = max(by_sd, key=lambda name: by_sd[name])
    stated = [
        cost.largest
        for fault in found
        for cost in fault.costs
        if cost.name == of and (fault.code in codes or not codes)
    ]
    return {
        "ratio": by_sd[of],
        "of": of,
        "cost_real": float({"speed": speed, "yaw rate": turn}[of].max()),
        "cost_stated": max(stated) if stated else None,
    }


def false_alarms(seed: int, name: str) -> dict[str, Any]:
    """What is told of a drive without a fault.

    Parameters
    ----------
    seed : of the court
    name : a key of :data:`MODELS`, or "real"

    Returns
    -------
    dict with ``model``, ``seed`` and ``told``, a list of "code sensor size"
    """
    model = REAL if name == "real" else MODELS[name]
    drive = clean_drive(seed, model)
    calibration = drive.calibration()
    found = find_faults(
        drive.trial, drive.court.geometry, calibration.mount, offsets=calibration.offsets
    )
    told = [f"{fault.code} {fault.sensor} {fault.size:.3g}" for fault in found]
    return {"model": name, "seed": seed, "told": told}


CLEAN = 70
"""Clean drives of each model."""


def study(executor: Any = None) -> dict[str, Any]:
    """Both halves of the study: faults that are found, and alarms where there is none.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here

    Returns
    -------
    dict with ``numbers``: ``kinds`` (one row each, of :func:`summary_of`), ``cases`` (columns of
    all rows) and ``clean`` (alarms by model)
    """
    jobs = [(kind, list(range(k, CASES, 4))) for kind in KINDS for k in range(4)]
    rows = [row for some in run_all(_cases, jobs, executor) for row in some]
    clean = run_all(
        false_alarms,
        [
            (FIRST_SEED + 1000 * m + k, name)
            for m, name in enumerate((*MODELS, "real"), start=1)
            for k in range(CLEAN)
        ],
        executor,
    )
    return {"numbers": numbers_of(rows, clean)}


def _cases(kind: str, cases: list[int]) -> list[dict[str, Any]]:
    return [one_case(kind, case) for case in cases]


COLUMNS = ("case", "sensor", "size", "unit", "ratio", "of", "found_as", "right", "cost_stated",
           "cost_real")  # fmt: skip


def numbers_of(rows: list[dict[str, Any]], clean: list[dict[str, Any]]) -> dict[str, Any]:
    """Rows and alarms as the record has them.

    Parameters
    ----------
    rows : of :func:`one_case`
    clean : of :func:`false_alarms`

    Returns
    -------
    dict
    """
    cases = {
        kind: {
            column: [_kept(row.get(column)) for row in sorted(of_kind, key=lambda r: r["case"])]
            for column in COLUMNS
        }
        for kind in KINDS
        if (of_kind := [row for row in rows if row["kind"] == kind])
    }
    alarms = {
        name: {
            "drives": len(of_model),
            "with_alarm": sum(bool(one["told"]) for one in of_model),
            "told": {str(one["seed"]): one["told"] for one in of_model if one["told"]},
        }
        for name in (*MODELS, "real")
        if (of_model := [one for one in clean if one["model"] == name])
    }
    return {"kinds": [summary_of(kind, rows) for kind in cases], "cases": cases, "clean": alarms}


def _kept(value: Any) -> Any:
    """Three digits of a number; None for what JSON has no word for."""
    if isinstance(value, float):
        return float(f"{value:.3g}") if np.isfinite(value) else None
    return value


def summary_of(kind: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How many faults of a kind matter, are found, and have a cost that holds.

    Parameters
    ----------
    kind : a key of :data:`KINDS`
    rows : of :func:`one_case`

    Returns
    -------
    dict with ``cases``, ``refused``, ``matter`` (refusals left out), and of those that matter
    ``right`` (named rightly) and ``found`` (told at all); ``priced`` (with a stated cost) and
    ``within_two`` of them; ``largest_missed`` (in standard deviations)
    """
    mine = [row for row in rows if row["kind"] == kind]
    refused = [row for row in mine if row["found_as"] == "refused"]
    matter = [r for r in mine if r["found_as"] != "refused" and r["ratio"] > MATTERS]
    priced = [row for row in matter if row["right"] and row["cost_stated"]]
    within = [r for r in priced if 0.5 <= r["cost_stated"] / r["cost_real"] <= 2.0]
    missed = [row["ratio"] for row in matter if not row["found_as"]]
    return {
        "kind": kind,
        "cases": len(mine),
        "refused": len(refused),
        "matter": len(matter),
        "right": sum(row["right"] for row in matter),
        "found": sum(bool(row["found_as"]) for row in matter),
        "priced": len(priced),
        "within_two": len(within),
        "largest_missed": _kept(max(missed, default=0.0)),
    }


def example(
    kind: str, case: int = 0
) -> tuple[Recording, Recording, dict[tuple[str, str], FloatArray],
           dict[tuple[str, str], FloatArray], tuple[Fault, ...]]:  # fmt: skip
    """A drive with and without a fault, for a drawing.

    Parameters
    ----------
    kind : a key of :data:`KINDS`
    case : 0 to 99, which of its drives

    Returns
    -------
    clean, faulty : Recording
    result_clean, result_faulty : series of :func:`mobility_imu.wheelchair.faults.results`
    faults : what is found, with costs
    """
    injection, _, rests = KINDS[kind]
    clean = _pool(case % POOL, rests)
    faulty = injection(clean, stream(FIRST_SEED, list(KINDS).index(kind), case)).drive
    series, offsets = [], dict[str, GyroscopeOffset]()
    calibration = clean.calibration()
    for drive in (clean, faulty):
        calibration = drive.calibration()
        offsets = calibration.offsets
        series.append(results(drive.trial, drive.court.geometry, calibration.mount, None, offsets))
    found = find_faults(
        faulty.trial, faulty.court.geometry, calibration.mount, offsets=calibration.offsets
    )
    return clean.trial, faulty.trial, series[0], series[1], found
