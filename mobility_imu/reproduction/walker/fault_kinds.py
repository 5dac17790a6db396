"""Kinds of faults of a walking frame's recordings: how each is injected, and what names it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.reproduction.walker.fault_motions import (
    foot_motion,
    loose_start,
    over_kerbs,
    rolling_motion,
    shaken,
    turned_on_the_way,
    up_a_ramp,
)
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.levels import LEVELS, MOUNTS, REAL_LEVEL, Level, tilt_run, unit_of
from mobility_imu.simulation.walker import (
    CORRIDOR,
    Leg,
    SimulatedWalker,
    WalkerMotion,
    attach_imu,
    simulate_walk,
)
from mobility_imu.walker.calibration import calibrate_from_path, calibrate_mount
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection, WalkerGeometry
from mobility_imu.walker.mount import WalkerMount

__all__ = [
    "DRAWN_BY",
    "FLOOR_KINDS",
    "KINDS",
    "LATER_KINDS",
    "MOTION_KINDS",
    "TILT_KINDS",
    "Injected",
    "Walked",
    "clean_walk",
]

COURSE = (Leg(2.5, np.pi / 2), Leg(1.5, np.pi / 2))
"""Fifteen steps or so, and two corners: 50 s."""
FRAME = "frame"
FOOT_MOUNT_M = (0.1, 0.0, 0.08)


@dataclass(frozen=True, eq=False)
class Walked:
    """A walk and the tilts before it, of one frame and one sensor.

    Parameters
    ----------
    seed : of the motions
    level : Level
    walk, tilts : SimulatedWalker
    tape : WalkerGeometry, as measured
    mount : WalkerMount, as calibrated from the tilts
    """

    seed: int
    level: Level
    walk: SimulatedWalker
    tilts: SimulatedWalker
    tape: WalkerGeometry
    mount: WalkerMount

    @property
    def pose(self) -> str:
        """Mounting of Table 1."""
        return pose_of(self.seed)

    def followed(self, motion: WalkerMotion, mount: WalkerMount | None = None) -> SimulatedWalker:
        """Recording of another motion by the same sensor.

        Parameters
        ----------
        motion : WalkerMotion
        mount : WalkerMount, the true one; None takes that of the pose

        Returns
        -------
        SimulatedWalker
        """
        unit = unit_of(self.seed, self.pose)
        where = MOUNTS[self.pose] if mount is None else mount
        return attach_imu(motion, where, self.level.sensor, seed=unit, unit_seed=unit)


def pose_of(seed: int) -> str:
    """Mounting of Table 1 that a seed has.

    Parameters
    ----------
    seed : of a walk
    """
    return str(1 + seed % len(MOUNTS))


def clean_walk(seed: int, level: str, *, with_sd: bool = True) -> Walked:
    """A walk and tilts without a fault, and the mount that the tilts give.

    Parameters
    ----------
    seed : the same seed gives the same bytes
    level : a key of ``LEVELS``, or "real"
    with_sd : whether the mount has standard deviations, which take most of the time

    Returns
    -------
    Walked
    """
    of = REAL_LEVEL if level == "real" else LEVELS[level]
    pose = pose_of(seed)
    tilts, tape = tilt_run(seed, pose, of)
    motion = simulate_walk(COURSE, seed=seed, imperfections=of.imperfections)
    unit = unit_of(seed, pose)
    walk = attach_imu(motion, MOUNTS[pose], of.sensor, seed=unit, unit_seed=unit)
    if with_sd:
        mount = calibrate_mount(tilts.recording, tape).mount
    else:
        mount = calibrate_from_path(navigate_recording(tilts.recording)[0], tape).mount
    return Walked(seed, of, walk, tilts, tape, mount)


@dataclass(frozen=True, eq=False)
class Injected:
    """A recording with a fault.

    Parameters
    ----------
    recording : Recording
    sensor, size, unit : of the fault
    mount : WalkerMount that the path is found with
    tape, order : of a calibration
    truth : SimulatedWalker where the motion itself is at fault; None where the reading is
    """

    recording: Recording
    sensor: str
    size: float
    unit: str
    mount: WalkerMount
    tape: WalkerGeometry
    order: tuple[TiltDirection, ...] = TILT_DIRECTIONS
    truth: SimulatedWalker | None = None


Injection = Callable[[Walked, np.random.Generator], Injected]


def _size(rng: np.random.Generator, least: float, most: float) -> float:
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def _sign(rng: np.random.Generator) -> float:
    return 1.0 if rng.random() < 0.5 else -1.0


def _direction(rng: np.random.Generator) -> FloatArray:
    vector = rng.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def _moment(recording: Recording, rng: np.random.Generator) -> float:
    """A time at which the frame is walked with, s after the start."""
    return float(rng.uniform(3.0, recording.time_s[-1] - recording.time_s[0] - 4.0))


def _given(walk: Walked, recording: Recording, sensor: str, size: float, unit: str) -> Injected:
    return Injected(recording, sensor, size, unit, walk.mount, walk.tape)


def gyroscope_freezes(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope repeats its last reading for 0.05 to 10 s."""
    return _frozen(walk, walk.walk.recording, rng, "gyr")


def accelerometer_freezes(walk: Walked, rng: np.random.Generator) -> Injected:
    """The accelerometer repeats its last reading for 0.05 to 10 s."""
    return _frozen(walk, walk.walk.recording, rng, "acc")


def _frozen(walk: Walked, recording: Recording, rng: np.random.Generator, half: str) -> Injected:
    length = _size(rng, 0.05, 10.0)
    faulty = inject.freeze(recording, FRAME, half, _moment(recording, rng), length)
    return _given(walk, faulty, f"{FRAME}_{half}", length, "s")


def gyroscope_dies(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope reads zero for the last 0.5 to 40 s."""
    recording, length = walk.walk.recording, _size(rng, 0.5, 40.0)
    duration = float(recording.time_s[-1] - recording.time_s[0])
    faulty = inject.silence(recording, FRAME, max(duration - length, 0.0))
    return _given(walk, faulty, f"{FRAME}_gyr", length, "s")


def axis_dies(walk: Walked, rng: np.random.Generator) -> Injected:
    """One axis of the gyroscope reads zero throughout; the size is its part of the vertical."""
    axis = int(rng.integers(3))
    faulty = inject.scale(walk.walk.recording, FRAME, "gyr", np.where(np.arange(3) == axis, 0, 1))
    part = float(MOUNTS[walk.pose].rotation_imu_to_body[2, axis] ** 2)
    return _given(walk, faulty, f"{FRAME}_gyr_{'xyz'[axis]}", part, "")


def range_of_gyroscope(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope's range ends at 5 to 150 deg/s; a turning step has 70."""
    limit = _size(rng, 5.0, 150.0)
    faulty = inject.clip(walk.walk.recording, FRAME, "gyr", np.deg2rad(limit))
    return _given(walk, faulty, f"{FRAME}_gyr", limit, "deg/s")


def range_of_accelerometer(walk: Walked, rng: np.random.Generator) -> Injected:
    """The accelerometer's range ends at 9 to 30 m/s²."""
    limit = _size(rng, 9.0, 30.0)
    faulty = inject.clip(walk.walk.recording, FRAME, "acc", limit)
    return _given(walk, faulty, f"{FRAME}_acc", limit, "m/s²")


def spikes_of_gyroscope(walk: Walked, rng: np.random.Generator) -> Injected:
    """One to five single readings are 0.05 to 35 rad/s off: a flipped bit of 2000 deg/s."""
    return _spiked(walk, walk.walk.recording, rng, "gyr", _size(rng, 0.05, 35.0), "rad/s")


def spikes_of_accelerometer(walk: Walked, rng: np.random.Generator) -> Injected:
    """One to five single readings are 0.5 to 157 m/s² off: a flipped bit of 16 g."""
    return _spiked(walk, walk.walk.recording, rng, "acc", _size(rng, 0.5, 157.0), "m/s²")


def _spiked(
    walk: Walked,
    recording: Recording,
    rng: np.random.Generator,
    half: str,
    size: float,
    unit: str,
) -> Injected:
    places = np.unique(rng.integers(5, len(recording) - 5, int(rng.integers(1, 6))))
    axis = int(rng.integers(3))
    faulty = inject.spike(recording, FRAME, half, places, axis, _sign(rng) * size)
    return _given(walk, faulty, f"{FRAME}_{half}", size, unit)


def beyond_any_range(walk: Walked, rng: np.random.Generator) -> Injected:
    """A reading of 215 to 1e8 m/s², or of 50 to 1e6 rad/s."""
    half, least, most, unit = (
        ("acc", 215.0, 1e8, "m/s²") if rng.random() < 0.5 else ("gyr", 50.0, 1e6, "rad/s")
    )
    return _spiked(walk, walk.walk.recording, rng, half, _size(rng, least, most), unit)


def offset(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope has an offset of 0.05 to 20 deg/s in any direction."""
    size = _size(rng, 0.05, 20.0)
    vector = np.deg2rad(size) * _direction(rng)
    faulty = inject.offset(walk.walk.recording, FRAME, "gyr", vector)
    return _given(walk, faulty, f"{FRAME}_gyr", size, "deg/s")


def offset_jumps(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope's offset jumps by 0.05 to 10 deg/s in the middle of the walk."""
    size, recording = _size(rng, 0.05, 10.0), walk.walk.recording
    when = rng.uniform(0.2, 0.8) * float(recording.time_s[-1])
    vector = np.deg2rad(size) * _direction(rng)
    faulty = inject.offset(recording, FRAME, "gyr", vector)
    late = recording.time_s >= when
    rates = np.where(late[:, None], faulty.gyroscope(FRAME), recording.gyroscope(FRAME))
    imu = replace(recording.sensor(FRAME), gyr_radps=rates)
    faulty = Recording(recording.time_s, {FRAME: imu}, source=recording.source)
    return _given(walk, faulty, f"{FRAME}_gyr", size, "deg/s")


def scale_of_gyroscope(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope reads 0.1 to 50 % too much or too little."""
    return _scaled(walk, walk.walk.recording, rng, "gyr", _size(rng, 0.001, 0.5))


def scale_of_accelerometer(walk: Walked, rng: np.random.Generator) -> Injected:
    """The accelerometer reads 0.1 to 30 % too much or too little."""
    return _scaled(walk, walk.walk.recording, rng, "acc", _size(rng, 0.001, 0.3))


def _scaled(
    walk: Walked, recording: Recording, rng: np.random.Generator, half: str, size: float
) -> Injected:
    faulty = inject.scale(recording, FRAME, half, 1 + _sign(rng) * size)
    return _given(walk, faulty, f"{FRAME}_{half}", size, "")


def lag(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope comes 0.01 to 1 s late or early against the accelerometer."""
    return _lagging(walk, walk.walk.recording, rng)


def _lagging(walk: Walked, recording: Recording, rng: np.random.Generator) -> Injected:
    size = _size(rng, 0.01, 1.0)
    faulty = inject.late_half(recording, FRAME, "gyr", _sign(rng) * size)
    return _given(walk, faulty, f"{FRAME}_gyr", size, "s")


def reversed_gyroscope(walk: Walked, rng: np.random.Generator) -> Injected:
    """One, two or all axes of the gyroscope have the wrong sign; the size is how many."""
    return _reversed(walk, walk.walk.recording, rng)


def _reversed(walk: Walked, recording: Recording, rng: np.random.Generator) -> Injected:
    signs = [1 - 2 * int(bit) for bit in f"{int(rng.integers(1, 8)):03b}"]
    faulty = inject.reverse(recording, FRAME, signs)
    return _given(walk, faulty, f"{FRAME}_gyr", float(signs.count(-1)), "")


def left_handed(walk: Walked, rng: np.random.Generator) -> Injected:
    """One axis has the wrong sign in both halves, in the walk and in the tilts before it."""
    axis = int(rng.integers(3))
    tilts = inject.left_handed(walk.tilts.recording, FRAME, axis)
    mount = calibrate_mount(tilts, walk.tape).mount
    faulty = inject.left_handed(walk.walk.recording, FRAME, axis)
    return replace(_given(walk, faulty, f"{FRAME}_{'xyz'[axis]}", float(axis), ""), mount=mount)


def turned(walk: Walked, rng: np.random.Generator) -> Injected:
    """The IMU is turned by 0.2 to 90 deg about any axis after the calibration."""
    return _turned(walk, _direction(rng), _size(rng, 0.2, 90.0))


def turned_about_vertical(walk: Walked, rng: np.random.Generator) -> Injected:
    """The IMU is turned by 0.2 to 180 deg about the vertical after the calibration."""
    axis = MOUNTS[walk.pose].rotation_imu_to_body[2]
    return _turned(walk, _sign(rng) * axis, _size(rng, 0.2, 180.0))


def _turned(walk: Walked, axis: FloatArray, size: float) -> Injected:
    """Before the sensor rounds its readings: turned afterwards, they would be finer than that."""
    true = MOUNTS[walk.pose]
    rotation = Rotation.from_rotvec(-np.deg2rad(size) * axis).as_matrix()
    mount = replace(true, rotation_imu_to_body=true.rotation_imu_to_body @ rotation)
    return _given(walk, walk.followed(walk.walk.motion, mount).recording, FRAME, size, "deg")


def clock(walk: Walked, rng: np.random.Generator) -> Injected:
    """Times in milliseconds, or a clock that jumps by 0.02 to 100 s."""
    recording = walk.walk.recording
    time_s = recording.time_s
    if rng.random() < 0.3:
        size = 1000.0
        faulty = Recording(1000 * time_s, recording.sensors, source=recording.source)
    else:
        size = _size(rng, 0.02, 100.0)
        back = -1.0 if rng.random() < 0.3 else 1.0
        start = float(time_s[int(rng.integers(10, len(time_s) - 10))] - time_s[0])
        faulty = inject.jump(recording, start, back * size)
    return _given(walk, faulty, "time_s", size, "s")


def rate(walk: Walked, rng: np.random.Generator) -> Injected:
    """The clock runs 1 to 100 % too fast or too slow: another sampling rate is taken for true."""
    size = _size(rng, 0.01, 1.0)
    factor = 1 + size if rng.random() < 0.5 else 1 / (1 + size)
    recording = walk.walk.recording
    faulty = Recording(factor * recording.time_s, recording.sensors, source=recording.source)
    return _given(walk, faulty, "time_s", size, "")


def rolls(walk: Walked, rng: np.random.Generator) -> Injected:
    """A frame that is rolled on its wheels; the floor shakes it by 0.01 to 3 m/s² at 1 m/s."""
    size, seed = _size(rng, 0.01, 3.0), int(rng.integers(1 << 30))
    motion = rolling_motion(seed)
    truth = walk.followed(motion)
    faulty = shaken(truth.recording, motion, size, seed)
    return replace(_given(walk, faulty, FRAME, size, "m/s²"), truth=truth)


def foot(walk: Walked, rng: np.random.Generator) -> Injected:
    """A sensor on a foot, which pitches by 5 to 80 deg in its swing."""
    size, seed = _size(rng, 5.0, 80.0), int(rng.integers(1 << 30))
    mount = WalkerMount(MOUNTS[walk.pose].rotation_imu_to_body, np.array(FOOT_MOUNT_M))
    truth = walk.followed(foot_motion(seed, np.deg2rad(size)), mount)
    given = _given(walk, truth.recording, FRAME, size, "deg")
    return replace(given, mount=mount, truth=truth)


def start_sways(walk: Walked, rng: np.random.Generator) -> Injected:
    """The frame is swayed by 0.02 to 20 deg where it was to rest before the walk."""
    size = _size(rng, 0.02, 20.0)
    motion = loose_start(walk.walk.motion, np.deg2rad(size), 0.0, int(rng.integers(1 << 30)))
    truth = walk.followed(motion)
    return replace(_given(walk, truth.recording, FRAME, size, "deg"), truth=truth)


def start_turns(walk: Walked, rng: np.random.Generator) -> Injected:
    """The frame is turned by 0.1 to 90 deg where it was to rest before the walk."""
    size = _size(rng, 0.1, 90.0)
    turn = _sign(rng) * np.deg2rad(size)
    motion = loose_start(walk.walk.motion, 0.0, turn, int(rng.integers(1 << 30)))
    truth = walk.followed(motion)
    return replace(_given(walk, truth.recording, FRAME, size, "deg"), truth=truth)


def turned_while_walked(walk: Walked, rng: np.random.Generator) -> Injected:
    """The IMU is turned by 0.2 to 180 deg about the vertical between 20 and 80 % of the walk."""
    size, motion = _size(rng, 0.2, 180.0), walk.walk.motion
    turn = _sign(rng) * np.deg2rad(size)
    when = rng.uniform(0.2, 0.8) * float(motion.time_s[-1])
    fits = turned_on_the_way(motion, MOUNTS[walk.pose], turn, when)
    return _given(walk, walk.followed(fits).recording, FRAME, size, "deg")


def kerbs(walk: Walked, rng: np.random.Generator) -> Injected:
    """One to five steps go 0.003 to 0.3 m up or down; a sill has 0.02 m, a stair 0.17 m."""
    size, motion = _size(rng, 0.003, 0.3), walk.walk.motion
    steps = rng.choice(len(motion.steps), int(rng.integers(1, 6)), replace=False).tolist()
    motion = over_kerbs(motion, steps, [_sign(rng) * size for _ in steps])
    truth = walk.followed(motion)
    return replace(_given(walk, truth.recording, FRAME, size, "m"), truth=truth)


def ramp(walk: Walked, rng: np.random.Generator) -> Injected:
    """All but the first metre of 10 m goes 0.05 to 10 deg up or down; 3.4 deg are 6 %."""
    size = _size(rng, 0.05, 10.0)
    slope, seed = _sign(rng) * np.deg2rad(size), int(rng.integers(1 << 30))
    level = simulate_walk(CORRIDOR, seed=seed, imperfections=walk.level.imperfections)
    truth = walk.followed(up_a_ramp(level, slope))
    return replace(_given(walk, truth.recording, FRAME, size, "deg"), truth=truth)


def tilts_in_another_order(walk: Walked, rng: np.random.Generator) -> Injected:
    """The tilts are stated in another order than they were made."""
    order = TILT_DIRECTIONS
    while order == TILT_DIRECTIONS:
        order = tuple(TILT_DIRECTIONS[k] for k in rng.permutation(4))
    given = _given(walk, walk.tilts.recording, "order", float("nan"), "")
    return replace(given, order=order)


def another_footprint(walk: Walked, rng: np.random.Generator) -> Injected:
    """A length of the footprint is 0.5 to 60 % off, or both are exchanged (size 0)."""
    tape = walk.tape
    if rng.random() < 0.3:
        size = 0.0
        tape = WalkerGeometry(tape.footprint_length_m, tape.footprint_width_m)
    else:
        size = _size(rng, 0.005, 0.6)
        name = ("footprint_width_m", "footprint_length_m")[int(rng.integers(2))]
        tape = replace(tape, **{name: getattr(tape, name) * (1 + _sign(rng) * size)})
    return replace(_given(walk, walk.tilts.recording, "footprint", size, ""), tape=tape)


def tilts_scaled(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope reads 0.1 to 50 % too much or too little in the tilts."""
    return _scaled(walk, walk.tilts.recording, rng, "gyr", _size(rng, 0.001, 0.5))


def tilts_lagging(walk: Walked, rng: np.random.Generator) -> Injected:
    """The gyroscope comes 0.01 to 1 s late or early in the tilts."""
    return _lagging(walk, walk.tilts.recording, rng)


def tilts_reversed(walk: Walked, rng: np.random.Generator) -> Injected:
    """Axes of the gyroscope have the wrong sign in the tilts."""
    return _reversed(walk, walk.tilts.recording, rng)


def tilts_frozen(walk: Walked, rng: np.random.Generator) -> Injected:
    """A half of the sensor repeats its last reading for 0.05 to 10 s of the tilts."""
    return _frozen(walk, walk.tilts.recording, rng, "gyr" if rng.random() < 0.5 else "acc")


def tilts_spiked(walk: Walked, rng: np.random.Generator) -> Injected:
    """One to five single readings of the tilts are 0.5 to 157 m/s² off."""
    return _spiked(walk, walk.tilts.recording, rng, "acc", _size(rng, 0.5, 157.0), "m/s²")


def tilts_without_rest(walk: Walked, rng: np.random.Generator) -> Injected:
    """The recording of the tilts begins 0.5 to 6 s late: its first rest is short or gone."""
    recording, size = walk.tilts.recording, _size(rng, 0.5, 6.0)
    begin = float(recording.time_s[0]) + size
    faulty = recording.trim(begin, float(recording.time_s[-1]))
    return _given(walk, faulty, FRAME, size, "s")


KINDS: dict[str, tuple[Injection, frozenset[str]]] = {
    "gyroscope freezes": (gyroscope_freezes, frozenset({"frozen"})),
    "accelerometer freezes": (accelerometer_freezes, frozenset({"frozen"})),
    "gyroscope dies": (gyroscope_dies, frozenset({"frozen"})),
    "axis dies": (axis_dies, frozenset({"dead axis"})),
    "range, gyroscope": (range_of_gyroscope, frozenset({"range"})),
    "range, accelerometer": (range_of_accelerometer, frozenset({"range", "gravity"})),
    "spikes, gyroscope": (spikes_of_gyroscope, frozenset({"spike"})),
    "spikes, accelerometer": (spikes_of_accelerometer, frozenset({"spike"})),
    "beyond any range": (beyond_any_range, frozenset({"spike"})),
    "offset": (offset, frozenset()),
    "offset jumps": (offset_jumps, frozenset({"offset"})),
    "scale, gyroscope": (scale_of_gyroscope, frozenset({"scale"})),
    "scale, accelerometer": (scale_of_accelerometer, frozenset({"gravity"})),
    "lag": (lag, frozenset({"lag"})),
    "reversed gyroscope": (reversed_gyroscope, frozenset({"reversed"})),
    "left-handed": (left_handed, frozenset({"reversed"})),
    "turned": (turned, frozenset({"turned"})),
    "turned about the vertical": (turned_about_vertical, frozenset({"turned"})),
    "clock": (clock, frozenset()),
    "sampling rate": (rate, frozenset({"scale"})),
    "rolls": (rolls, frozenset({"rolls", "no rest"})),
    "foot": (foot, frozenset({"foot", "no rest", "rolls"})),
    "start sways": (start_sways, frozenset({"start", "offset"})),
    "start turns": (start_turns, frozenset({"start", "offset"})),
    "turned on the way": (turned_while_walked, frozenset({"turned"})),
    "kerbs": (kerbs, frozenset({"floor"})),
    "ramp": (ramp, frozenset({"floor"})),
}
"""Kinds of faults of a walk: how each is injected, and by which codes it is rightly named. Where no
code is right, only a refusal is."""

FLOOR_KINDS = ("kerbs", "ramp")
"""Those in which the floor is not level."""
MOTION_KINDS = ("rolls", "foot", "start sways", "start turns", *FLOOR_KINDS)
"""Those in which the motion is at fault, not the sensor: the path is held against the true one."""

TILT_KINDS: dict[str, tuple[Injection, frozenset[str]]] = {
    "tilts, another order": (tilts_in_another_order, frozenset({"poses"})),
    "tilts, another footprint": (another_footprint, frozenset({"poses"})),
    "tilts, scale": (tilts_scaled, frozenset({"scale"})),
    "tilts, lag": (tilts_lagging, frozenset({"lag"})),
    "tilts, reversed": (tilts_reversed, frozenset({"reversed"})),
    "tilts, frozen": (tilts_frozen, frozenset({"frozen"})),
    "tilts, spikes": (tilts_spiked, frozenset({"spike"})),
    "tilts, short rest": (tilts_without_rest, frozenset({"start", "poses"})),
}
"""The same of the tilts by which the mount is found."""

LATER_KINDS = ("turned on the way", *FLOOR_KINDS)
DRAWN_BY = {
    kind: number
    for number, kind in enumerate(
        [*(kind for kind in (*KINDS, *TILT_KINDS) if kind not in LATER_KINDS), *LATER_KINDS]
    )
}
"""Number that the cases of a kind are drawn by; a later kind leaves those of the others alone."""
