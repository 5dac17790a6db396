"""Faults that a path shows: of its start, its mount, its moves, and what it follows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.faults import Cost, Fault, turned_back
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.rotations import elementary_rotation
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.reach import FRAME, placed, samples_unknown
from mobility_imu.walker.rest_checks import shortest_turns
from mobility_imu.walker.steps import find_steps
from mobility_imu.walker.trajectory import Trajectory

__all__ = ["faults_of_path", "faults_of_tilts"]

FOOT_DEG = 25.0
"""A frame that is walked with is pitched by 10 deg or less (on 16 real walks by 3); a foot swings
by 30 to 75."""
LONGEST_STEP_M, LONG_STEPS = 0.8, 2
"""Nobody sets a frame down further ahead than an arm reaches; one such move may be a rest that was
not seen. The number is our choice, not swept."""
ASIDE_DEG, FEWEST_STEPS, LEAST_STEP_M, LEAST_WAY_M = 4.0, 5, 0.1, 2.0
"""Steps go forward: on 16 real walks the way goes within 2.6 deg of it. The fewest steps that show
it, the shortest that has a direction, and the shortest way, are our choices, not swept."""
SLIPPED_DEG, SLIPPED_TIMES, LEAST_SD_RAD, FEWEST_BESIDE = 20.0, 8.0, 1e-3, 3
"""Change of the way of the steps that is told, also in times its standard deviation: on 16 real
walks the largest are 14 deg and 5.2 times, on 40 simulated ones ("real", other seeds than the
study's) 8 deg and 2.1 times. Below the third it is rounding; the fourth are the
fewest steps on either side, our choice, not swept."""
ROUNDS = 5
"""How often a turned mount's angle is found anew: of 18 simulated ones, turned by 8 to 180 deg, the
fourth is right to 1 deg, the first to 45 deg."""
GROSS_SCALE = 0.5
"""A path from rates that are so far off, or that say nothing, shows neither mount nor manner. Our
choice, not swept."""
LONG_MOVE_WORDS, START_WORDS = "no rest for more than", "the frame moves at the start"
LEAN_WORDS, ODDS_WORDS = "the frame leans by", "as far from what the filter expects"
FAR_WORDS = "far off a frame"
POSES_WORDS = ("the footprint's", "the tilts went")


def faults_of_path(
    recording: Recording, found: Trajectory, mount: WalkerMount, known: Sequence[Fault] = ()
) -> list[Fault]:
    """Faults that a path shows: of its start, its mount, its moves, and what it follows.

    Parameters
    ----------
    recording : Recording that it is of
    found : Trajectory, whose warnings become sentences of faults
    mount : WalkerMount that it was found with
    known : Fault, of the readings: a path from a broken sensor shows no mount and no manner, and
        what is known to be at odds is not told again in the filter's words

    Returns
    -------
    list of Fault
    """
    codes = {fault.code for fault in known}
    count, late = len(recording), len(recording) - len(found)
    whole = np.ones(count, np.bool_)
    told = []
    for text in found.warnings:
        said = _said(recording, text)
        if START_WORDS in text:
            told.append(_stated("start", np.arange(count) < late, said, recording))
        elif LEAN_WORDS in text:
            told.append(_leaning(recording, found, mount, said))
        elif LONG_MOVE_WORDS in text:
            told.append(_stated("no rest", placed(_long_moves(found), count), said, recording))
        elif ODDS_WORDS in text:
            if "at odds" not in codes:
                told.append(_stated("at odds", placed(found.stationary, count), said, recording))
        elif FAR_WORDS in text:
            told.append(_stated("mount", whole, said, recording))
    gross = any(f.code == "scale" and not abs(f.size) < GROSS_SCALE for f in known)
    if "reversed" in codes or gross:
        return told
    usable = _without_lost(found, samples_unknown(known, count)[late:])
    if not usable[~found.stationary].any():
        return told
    if found.settings.zero_rate:  # settings of a foot are without
        told += _foot(recording, found, usable)
    if not {fault.code for fault in told} & {"foot", "no rest"}:
        told += _far_steps(recording, found, usable)
    if not {fault.code for fault in told} & {"foot", "no rest", "rolls"}:
        slipped = list(_slipped(recording, found, mount, usable))
        told += slipped or _aside(recording, found, mount, usable)
    return told


def faults_of_tilts(
    recording: Recording, warnings: Sequence[str], count: int, known: Sequence[Fault] = ()
) -> list[Fault]:
    """Faults of a recording of tilts that its calibration warns of.

    Parameters
    ----------
    recording : Recording
    warnings : of the calibration
    count : samples of its path, the last ones of the recording
    known : Fault, of the readings

    Returns
    -------
    list of Fault: a start that moves, rests at odds with the filter unless that is known, tilts
    that do not fit, each once
    """
    whole = np.ones(len(recording), np.bool_)
    told = []
    for text in warnings:
        said = _said(recording, text)
        if START_WORDS in text:
            flags = np.arange(len(recording)) < len(recording) - count
            told.append(_stated("start", flags, said, recording))
        elif ODDS_WORDS in text and "at odds" not in {fault.code for fault in known}:
            told.append(_stated("at odds", whole, said, recording))
    poses = [text for text in warnings if any(words in text for words in POSES_WORDS)]
    if poses:
        told.append(_stated("poses", whole, _said(recording, "; ".join(poses)), recording))
    return told


def _said(recording: Recording, text: str) -> str:
    """Sentence of a warning, which names the file."""
    return text if text.startswith(f"{recording.source}: ") else f"{recording.source}: {text}"


def _stated(code: str, flags: NDArray[np.bool_], sentence: str, recording: Recording) -> Fault:
    first = float(recording.time_s[int(np.argmax(flags))])
    return Fault(code, FRAME, first, flags, sentence)


def _long_moves(found: Trajectory) -> NDArray[np.bool_]:
    step_s = float(np.median(np.diff(found.time_s)))
    count = int(found.settings.longest_move_s / step_s) + 1
    return long_runs(~found.stationary, count, grow=False)


def _leaning(recording: Recording, found: Trajectory, mount: WalkerMount, said: str) -> Fault:
    """Mount by which the standing frame leans; undone by turning the readings upright."""
    acc = recording.sensor(FRAME).acc_mps2[-len(found) :]
    force = acc[runs_of(found.stationary)[0]].mean(axis=0)
    up, level = force / np.linalg.norm(force), mount.rotation_imu_to_body[2]
    turn = shortest_turns(up, level)
    lean = float(np.rad2deg(np.arccos(np.clip(up @ level, -1, 1))))
    fault = _stated("turned", np.ones(len(recording), np.bool_), said, recording)
    return replace(
        fault, size=lean, unit="deg", repair=partial(turned_back, sensor=FRAME, rotation=turn)
    )


def _without_lost(found: Trajectory, lost: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Samples of a path but for those of moves in or beside which readings are lost.

    A rest brings tilt and velocity back, so that the next move shows the frame as it is.
    """
    usable = np.ones(len(found), np.bool_)
    for move in runs_of(~found.stationary):
        usable[move] = not lost[max(0, move.start - 1) : move.stop + 1].any()
    return usable


def _foot(recording: Recording, found: Trajectory, usable: NDArray[np.bool_]) -> Iterator[Fault]:
    """Tilts that no frame makes."""
    upright = np.where(usable, found.rotation_body_to_world[:, 2, 2], 1.0)
    flags = upright < np.cos(np.deg2rad(FOOT_DEG))
    if flags.any():
        largest = float(np.rad2deg(np.arccos(np.clip(upright.min(), -1, 1))))
        yield fault_of(
            recording, "foot", FRAME, placed(flags, len(recording)),
            f"tilts by up to {largest:.0f} deg, {len(runs_of(flags))} times, which no walking "
            "frame does: is the sensor on a foot or in a hand, or did the frame fall? The path is "
            "that of something else (Python: NavigationSettings.for_foot)",
            size=largest, unit="deg",
        )  # fmt: skip


def _far_steps(
    recording: Recording, found: Trajectory, usable: NDArray[np.bool_]
) -> Iterator[Fault]:
    """Moves from stand to stand that are too far for a frame that is set down."""
    flags, longest, often = np.zeros(len(found), np.bool_), 0.0, 0
    for move in runs_of(~found.stationary & usable):
        way = found.position_m[min(move.stop, len(found) - 1)] - found.position_m[move.start]
        length = float(np.hypot(*way[:2]))
        if length > LONGEST_STEP_M:
            flags[move], longest, often = True, max(longest, length), often + 1
    if often >= LONG_STEPS:
        yield fault_of(
            recording, "rolls", FRAME, placed(flags, len(recording)),
            f"moves by up to {longest:.2g} m from stand to stand, {often} times by more than "
            f"{LONGEST_STEP_M:g} m: is it rolled, or is the sensor on a foot? This method follows "
            "a frame that is lifted and set down: record it so", size=longest, unit="m",
        )  # fmt: skip


def _aside(
    recording: Recording, found: Trajectory, mount: WalkerMount, usable: NDArray[np.bool_]
) -> Iterator[Fault]:
    """Steps that go aside or backward: the mount is turned about the vertical."""
    way = _way_of_steps(found, usable)
    middle = float(np.angle(way))
    if not _goes_aside(way):
        return
    # A mount that is turned also has the IMU elsewhere: steps that turn go astray, and mix in.
    for _ in range(ROUNDS):
        way = _way_of_steps(_with_mount_turned(found, mount, middle), usable)
        middle = float(np.angle(np.exp(1j * (middle + np.angle(way)))))
    middle = float(np.rad2deg(middle))
    about = elementary_rotation("z", -np.deg2rad(middle))
    turn = mount.rotation_imu_to_body.T @ about @ mount.rotation_imu_to_body
    yield fault_of(
        recording, "turned", FRAME, np.ones(len(recording), np.bool_),
        f"steps {abs(middle):.0f} deg to the {'left' if middle > 0 else 'right'} of its "
        "forward axis: has the IMU been turned since it was calibrated, or was it calibrated with "
        "tilts in another order than stated? Then calibrate the mount again",
        size=middle, unit="deg", repair=partial(turned_back, sensor=FRAME, rotation=turn),
    )  # fmt: skip


def _goes_aside(way: complex) -> bool:
    """Whether a way is so far, and so far from forward, that the mount seems turned."""
    return abs(np.rad2deg(np.angle(way))) >= ASIDE_DEG and abs(way) >= LEAST_WAY_M


def _slipped(
    recording: Recording, found: Trajectory, mount: WalkerMount, usable: NDArray[np.bool_]
) -> Iterator[Fault]:
    """Steps that go another way from some time on: the IMU was turned about the vertical there.

    Where all steps together go aside, the mount is turned throughout or from some time on.
    """
    ways, lift_s = _ways_of_steps(found, usable, straight=True)
    best = (0.0, 0.0, 0)
    for k in range(FEWEST_BESIDE, len(ways) - FEWEST_BESIDE + 1):
        parts = ways[:k], ways[k:]
        first, last = (part.sum() for part in parts)
        off = np.concatenate([np.angle(part * np.conj(part.sum())) for part in parts])
        sd = np.sqrt(np.mean(off**2) * (1 / k + 1 / (len(ways) - k)))
        turn = float(np.angle(last * np.conj(first)))
        best = max(best, (abs(turn) / max(float(sd), LEAST_SD_RAD), turn, k))
    times, turn, k = best
    if np.rad2deg(abs(turn)) < SLIPPED_DEG or times < SLIPPED_TIMES:
        if not _goes_aside(_way_of_steps(found, usable)):
            return
        turn, k = _turned_later(ways)
        if not k:
            return
    when = float(lift_s[k])
    fault = fault_of(
        recording, "turned", FRAME, recording.time_s >= lift_s[k - 1],
        f"steps {np.rad2deg(abs(turn)):.0f} deg further to the {'left' if turn > 0 else 'right'} "
        f"of its forward axis from {when:.1f} s on than before: was the IMU turned on the frame "
        "there? Cut the recording there, and calibrate the mount again for the later part",
        size=float(np.rad2deg(turn)), unit="deg",
    )  # fmt: skip
    yield replace(fault, costs=_costs_of_slip(found, mount, lift_s, k, turn))


def _turned_later(ways: NDArray[np.complex128]) -> tuple[float, int]:
    """Turn, rad, and step from which on it is, if ways are forward before; 0 and 0 if not likely.

    Held against one turn of all ways: both have one angle, and the step is one of many.
    """
    best = (np.inf, 0.0, 0)
    for k in range(FEWEST_BESIDE, len(ways) - FEWEST_BESIDE + 1):
        last = ways[k:].sum()
        off = np.angle(np.r_[ways[:k], ways[k:] * np.conj(last)])
        best = min(best, (float(off @ off), float(np.angle(last)), k))
    left, turn, k = max(best[0], len(ways) * LEAST_SD_RAD**2), *best[1:]
    off = np.angle(ways * np.conj(ways.sum()))
    if not k or (off @ off / left - 1) * len(ways) / 2 < np.log(len(ways)):
        return 0.0, 0
    return turn, k


def _costs_of_slip(
    found: Trajectory, mount: WalkerMount, lift_s: FloatArray, k: int, turn_rad: float
) -> tuple[Cost, ...]:
    """What a turn of the IMU on the way costs, if its gyroscope felt it; else nothing is known.

    The heading jumps where the frame did not turn, and the arm from it to the IMU is laid another
    way. A heading that goes on did not feel the turn, as in a gap: then the way is bent. At a
    corner, where the heading turns by more, nobody can tell.
    """
    # Some steps apart, since the steps tell the time of the turn within one or two.
    ends = np.searchsorted(found.time_s, lift_s[[k - FEWEST_BESIDE, k + FEWEST_BESIDE - 1]])
    jump = np.ptp(found.yaw_rad[ends[0] : ends[1] + 1])
    if not abs(turn_rad) / 2 <= jump <= 1.5 * abs(turn_rad):
        return ()
    arm = float(np.hypot(*mount.translation_body_m[:2]))
    return (
        Cost("place", float(2 * abs(np.sin(turn_rad / 2)) * arm), "m"),
        Cost("heading", float(np.rad2deg(abs(turn_rad))), "deg"),
    )


def _way_of_steps(found: Trajectory, usable: NDArray[np.bool_]) -> complex:
    """Sum of the steps against their heading, m, forward + 1j left; 0 if they are too few."""
    return complex(_ways_of_steps(found, usable)[0].sum())


def _ways_of_steps(
    found: Trajectory, usable: NDArray[np.bool_], *, straight: bool = False
) -> tuple[NDArray[np.complex128], FloatArray]:
    """Each step against its heading, m, forward + 1j left, and its lift, s; none of too few.

    Steps that turn may be left out: by a turned mount, which has the IMU elsewhere, they go astray.
    """
    none = np.zeros(0, complex), np.zeros(0)
    try:
        steps = find_steps(found)
    except InputError:
        return none
    far = steps.length_m > LEAST_STEP_M
    if straight:
        far &= np.abs(steps.turn_rad) < steps.settings.least_turn_rad
    lift, place = (np.searchsorted(found.time_s, each) for each in (steps.lift_s, steps.place_s))
    spoilt = np.r_[0, np.cumsum(~usable)]
    far &= spoilt[np.minimum(place + 1, len(found))] == spoilt[np.maximum(lift - 1, 0)]
    if np.count_nonzero(far) < FEWEST_STEPS:
        return none
    heading = np.interp(steps.lift_s, found.time_s, found.yaw_rad)
    # Vectors, not courses: who places one step aside corrects it with the next.
    way = steps.length_m * np.exp(1j * (steps.direction_rad - heading))
    return way[far], steps.lift_s[far]


def _with_mount_turned(found: Trajectory, mount: WalkerMount, turn_rad: float) -> Trajectory:
    """Path by a mount that is turned about the frame's vertical."""
    attitude = found.rotation_body_to_world @ elementary_rotation("z", turn_rad)
    place = found.position_m
    place = place + (found.rotation_body_to_world - attitude) @ mount.translation_body_m
    return replace(found, position_m=place - place[0], rotation_body_to_world=attitude)
