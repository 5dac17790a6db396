"""What is wrong with a recording of a walking frame, and what it costs in the path.

One IMU has no second sensor beside it. What shows its faults are its own halves, which have to fit
together from rest to rest, and the frame itself, which stands between its moves, is lifted and goes
forward. In principle not seen: a gyroscope's scale about the vertical. With rates (1 + e) w about
the vertical at rest and in level moves, gravity's direction, the return of the velocity to zero and
the height stay as they are: the path is turned by e times the angle that was turned, and nothing in
the recording changes. An accelerometer's scale along horizontal axes is not seen either: it
multiplies the velocity, and zero stays zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.faults import Cost, Fault, as_faults, half_of, largest_change, with_costs
from mobility_imu.frames import FloatArray
from mobility_imu.health import examine
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs
from mobility_imu.walker.calibration import (
    Method,
    WalkerCalibration,
    calibrate_from_path,
    check_choices,
    with_sensor_errors,
)
from mobility_imu.walker.fault_checks import faults_of_readings, is_held, steps_are_coarse
from mobility_imu.walker.floor import floor_faults
from mobility_imu.walker.follow import (
    LATEST_REST_S,
    as_sentences,
    checked_options,
    followed,
    navigate_recording,
)
from mobility_imu.walker.footprint import FOOTPRINT_WORDS
from mobility_imu.walker.gaps import filled_samples, gaps_in_moves, is_of_a_gap, without_samples
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection, WalkerGeometry
from mobility_imu.walker.given_rests import GIVEN_WORDS
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation import ClosedLoop, Navigation, NavigationSettings
from mobility_imu.walker.path_checks import ODDS_WORDS, faults_of_path, faults_of_tilts
from mobility_imu.walker.reach import FRAME, UNKNOWN, with_reach
from mobility_imu.walker.rest_checks import Readings
from mobility_imu.walker.rounding import coarse_rates
from mobility_imu.walker.sensor_errors import REST_WORDS
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.tilt_equations import Form
from mobility_imu.walker.trajectory import OPEN_WORDS, Trajectory, estimate_trajectory

__all__ = ["find_faults", "find_tilt_faults", "not_told", "valid_samples"]

NEGLIGIBLE = {"m": 1e-3, "deg": 0.01}
"""A range whose end costs less is not told: a sensor with coarse steps repeats its largest value by
chance. A millimetre, and what turns 5 m by one: our choice, not swept."""
BEYOND_END, BESIDE, OFTEN_AT_END = 1.1, 3, 0.05
"""All axes of a half have one range, but for calibration, which is some per cent. So an axis that
ends below another's neighbouring readings, of which there are some, by more than the first was not
cut there: samples that come twice, or were filled in, made a peak of few steps flat. A single spike
shows no range. An axis that is at its end for the last part of all samples is stuck there. Our
choices, not swept."""
MOST_FILLED = 0.5
"""Part of a recording up to which straight lines are gaps; beyond it all was interpolated. Our
choice, not swept."""
TILTS_UNKNOWN = "; how the frame tilts there is not known, and the mount may be wrong"
BY_RESTS = frozenset({"at odds", "rolls", "offset", "lag", "scale", "reversed", "floor"})
"""Faults that the readings show from rest to rest, and within them."""
SAID = (
    (f"{FRAME}_acc is saturated in", "range", f"{FRAME}_acc", ""),
    (f"{FRAME}_gyr is saturated in", "range", f"{FRAME}_gyr", ""),
    ("readings repeat themselves", "frozen", FRAME, ""),
    ("the frame went backward", "turned", FRAME, "of its forward axis"),
    (ODDS_WORDS, "at odds", FRAME, ""),
    (REST_WORDS, "gravity", f"{FRAME}_acc", ""),
)
"""Words of a warning, and code, sensor and words of the fault that says the same in its own."""


def find_faults(
    recording: Recording,
    geometry: WalkerGeometry | None,
    mount: WalkerMount,
    settings: NavigationSettings | None = None,
    *,
    stillness: StillnessSettings | None = None,
    smooth: bool = True,
    closed_loop: ClosedLoop | None = None,
    rests: ArrayLike | None = None,
) -> tuple[Fault, ...]:
    """Look for what is wrong with the recording of a walk, and what it costs.

    The costs are by how far the path ("place", m) and its heading ("heading", deg) move if the
    fault is undone as well as can be. Where nothing can undo it, none is stated.

    Parameters
    ----------
    recording, geometry, mount, settings, stillness, smooth, closed_loop, rests : as in
        :func:`mobility_imu.walker.trajectory.estimate_trajectory`

    Returns
    -------
    tuple of Fault; of a recording that no path can be found from, those of its sensors alone

    Raises
    ------
    InputError
        If the recording has no sensor "frame" with gyroscope, or another argument is impossible.
    """
    expect("geometry", geometry, WalkerGeometry, none=True)
    expect("mount", mount, WalkerMount)
    settings, stillness, known = checked_options(
        recording,
        smooth=smooth,
        settings=settings,
        stillness=stillness,
        closed_loop=closed_loop,
        rests=rests,
    )
    recording = _frame_of(recording)
    path_of = partial(
        estimate_trajectory,
        geometry=geometry,
        mount=mount,
        settings=settings,
        stillness=stillness,
        smooth=smooth,
        closed_loop=closed_loop,
        rests=known,
    )
    filled = filled_samples(recording)
    found = _of_sensors(recording, stillness, filled)
    try:
        path = path_of(recording)
    except InputError:
        return tuple(found)
    shifted = [text for text in path.warnings if GIVEN_WORDS in text]
    if shifted:  # by wrong rests every other check would accuse the sensor
        whole = np.ones(len(recording), np.bool_)
        first = float(recording.time_s[0])
        return (*found, Fault("rests", FRAME, first, whole, shifted[0]))
    readings = _readings(recording, path.time_s, path.stationary)
    found += gaps_in_moves(recording, path.stationary, filled)
    more = faults_of_readings(recording, readings, found, stillness)
    found = _with_readings(recording, found, more)
    # The limits of what a path shows are those of smoothed ones.
    shown = path if smooth else replace(path_of(recording, smooth=True), warnings=path.warnings)
    found += faults_of_path(recording, shown, mount, found)
    found += coarse_rates(recording, path, mount, found)
    found += floor_faults(recording, path, found)
    found += _not_closed(recording, path, path_of)

    def series(changed: Recording) -> dict[tuple[str, str], FloatArray]:
        moved = path if changed is recording else path_of(changed)
        return _path_series(moved, path, len(recording))

    priced = with_costs(_by_rests(found, given=known is not None), recording, series)
    return tuple(_carried_back(f, recording, path, path_of) for f in priced if not _negligible(f))


def find_tilt_faults(
    recording: Recording,
    geometry: WalkerGeometry,
    *,
    method: Method = "all-samples",
    form: Form = "corrected",
    smooth: bool = True,
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
) -> tuple[Fault, ...]:
    """Look for what is wrong with the recording of the tilts, and what it costs in the mount.

    The costs are by how far the IMU's position ("position of the IMU", m) and its axes ("turn of
    the IMU", deg) move if the fault is undone.

    Parameters
    ----------
    recording, geometry, method, form, smooth, order, settings, stillness : as in
        :func:`mobility_imu.walker.calibration.calibrate_mount`

    Returns
    -------
    tuple of Fault; of a recording that no mount can be found from, those of its sensors alone

    Raises
    ------
    InputError
        If the recording has no sensor "frame" with gyroscope, or another argument is impossible.
    """
    check_choices(geometry, method, form, order)
    settings, stillness, _ = checked_options(
        recording, smooth=smooth, settings=settings, stillness=stillness
    )
    recording = _frame_of(recording)
    filled = filled_samples(recording)
    found = _of_sensors(recording, stillness, filled)

    def path_of(changed: Recording) -> tuple[Navigation, tuple[str, ...]]:
        return navigate_recording(changed, smooth=smooth, settings=settings, stillness=stillness)

    def mount_of(changed: Recording) -> tuple[Navigation, WalkerCalibration]:
        path, warnings = path_of(changed)
        return path, calibrate_from_path(
            path,
            geometry,
            method=method,
            form=form,
            order=order,
            settings=settings,
            stillness=stillness,
            warnings=warnings,
        )

    try:
        path, stated = mount_of(recording)
    except InputError:
        return tuple(_of_tilts(fault) for fault in found)
    if any(text.startswith(FOOTPRINT_WORDS) for text in stated.warnings):
        # The sensor's usual errors may be the cause. Where they leave no mount, all is told.
        with suppress(InputError):
            stated = with_sensor_errors(
                stated,
                path,
                recording,
                lambda wrong: followed(wrong, smooth, settings, stillness)[0],
            )
    readings = _readings(recording, path.time_s, path.still)
    found += gaps_in_moves(recording, path.still, filled)
    more = faults_of_readings(recording, readings, found, stillness)
    found = _with_readings(recording, found, more)
    found += faults_of_tilts(recording, stated.warnings, len(path.time_s), found)
    found = [_of_tilts(fault) for fault in found]

    def series(changed: Recording) -> dict[tuple[str, str], FloatArray]:
        return _mount_series(stated if changed is recording else mount_of(changed)[1], stated)

    return tuple(f for f in with_costs(found, recording, series) if not _negligible(f))


def valid_samples(found: Trajectory, faults: Iterable[Fault]) -> NDArray[np.bool_]:
    """Samples of a path that no fault touches.

    A rest brings velocity and tilt back, never place and heading. So a fault that nothing can undo,
    or that moves place (in space) or heading by more than their stated standard deviations at the
    end, leaves everything from the rest before its first sample on not valid: a smoother carries
    the error back to there. In a path without a smoother it is everything from its first sample on.
    One that costs less touches its own samples, or none if it lasts throughout. One that could be
    undone, but whose cost is not known, touches its own samples, also if these are all.

    A start that moves does not count, since the path begins after it. "At odds" beside another
    fault touches its own samples, as that fault may be its cause or not; a lasting one is, where
    all rests are at odds.

    Parameters
    ----------
    found : Trajectory
    faults : Fault, of :func:`find_faults` for its recording

    Returns
    -------
    (n,) bool array, one flag for each sample of the path

    Raises
    ------
    InputError
        If an argument is of another kind, or a fault is one of another recording.
    """
    expect("found", found, Trajectory)
    valid = np.ones(len(found), np.bool_)
    faults = [fault for fault in _checked(faults, found) if fault.code != "start"]
    alone = all(fault.code == "at odds" for fault in faults)
    caused = any(fault.code != "at odds" and _lasts(fault, found) for fault in faults)
    for fault in faults:
        touched = fault.flags[-len(found) :].copy()
        odds = fault.code == "at odds"
        if odds and caused and touched[found.stationary].all():
            continue
        lasts = _lasts(fault, found) and (alone or not odds)
        if lasts and touched.any():
            first = int(np.argmax(touched))
            rested = np.flatnonzero(found.stationary[:first]) if found.smooth else [first]
            touched[rested[-1] if len(rested) else 0 :] = True
        if lasts or not fault.costs or not touched.all():
            valid &= ~touched
    return valid


def not_told(warnings: Iterable[str], faults: Iterable[Fault]) -> list[str]:
    """Warnings of a result that no fault says already, in the same words or in its own.

    Parameters
    ----------
    warnings : sentences of a Trajectory or a WalkerCalibration
    faults : Fault, of :func:`find_faults` or :func:`find_tilt_faults`

    Returns
    -------
    list of str

    Raises
    ------
    InputError
        If an argument is of another kind.
    """
    faults = _checked(faults)
    texts = as_sentences(warnings)
    return [text for text in texts if not any(_says(fault, text) for fault in faults)]


def _carried_back(
    fault: Fault,
    recording: Recording,
    stated: Trajectory,
    path_of: Callable[[Recording], Trajectory],
) -> Fault:
    """Fault that begins where it begins to move the path by more than its deviations.

    The smoother takes an offset that jumps for one that wanders, before the jump as well.
    """
    first = int(np.argmax(fault.flags[-len(stated) :]))
    if fault.repair is None or first == 0 or not _moves_more_than_sd(fault, stated):
        return fault
    try:
        moved = path_of(fault.repair(recording))
    except InputError:
        return fault
    count = min(len(moved), len(stated))
    place = np.linalg.norm(moved.position_m[-count:] - stated.position_m[-count:], axis=1)
    turned = np.abs(moved.yaw_rad[-count:] - stated.yaw_rad[-count:])
    sd_m = np.linalg.norm(stated.position_sd_m[-count:], axis=1)
    off = place > np.maximum(sd_m, NEGLIGIBLE["m"])
    off |= turned > np.maximum(stated.yaw_sd_rad[-count:], np.deg2rad(NEGLIGIBLE["deg"]))
    before = len(recording) - len(stated) + first
    begin = len(recording) - count + int(np.argmax(off))
    if not off.any() or begin >= before:
        return fault
    flags, first_s = fault.flags.copy(), float(recording.time_s[begin])
    flags[begin:before] = True
    return replace(
        fault, flags=flags, first_s=first_s,
        sentence=f"{fault.sentence}; the path is off from {first_s:.2f} s on, since each of its "
        "estimates uses what comes after it",
    )  # fmt: skip


def _checked(faults: Iterable[Fault], found: Trajectory | None = None) -> tuple[Fault, ...]:
    """Faults as a tuple; those of a path may have the few seconds more before its first rest."""
    faults = as_faults(faults)
    for fault in faults:
        if found is None:
            continue
        most = len(found) + LATEST_REST_S / float(np.median(np.diff(found.time_s))) + 1
        if not len(found) <= len(fault.flags) <= most:
            raise InputError(
                f"faults: one is of a recording of {len(fault.flags)} samples, the path has "
                f"{len(found)}: expected the faults of its own recording"
            )
    return faults


def _lasts(fault: Fault, found: Trajectory) -> bool:
    """Whether a fault spoils all that comes after it: by more than the sds, or without a repair."""
    return _moves_more_than_sd(fault, found) if fault.costs else fault.repair is None


def _moves_more_than_sd(fault: Fault, found: Trajectory) -> bool:
    """Whether a fault moves place (in space) or heading by more than their sds at the end."""
    sds = {
        "place": float(np.linalg.norm(found.position_sd_m[-1])),
        "heading": float(np.rad2deg(found.yaw_sd_rad[-1])),
    }
    return any(cost.largest > sds.get(cost.name, np.inf) for cost in fault.costs)


def _not_closed(
    recording: Recording, tied: Trajectory, path_of: Callable[..., Trajectory]
) -> Iterator[Fault]:
    """A constraint that the path contradicts, with how far it bends the path."""
    for text in tied.warnings:
        if text.startswith(OPEN_WORDS):
            untied = path_of(recording, closed_loop=None)
            count = len(recording)
            stated = _path_series(tied, tied, count)
            bent = _path_series(untied, tied, count)
            costs = tuple(
                Cost(name, largest_change(values, bent[name, unit]), unit)
                for (name, unit), values in stated.items()
            )
            yield Fault(
                "not closed", FRAME, float(recording.time_s[0]), np.ones(count, np.bool_),
                f"{recording.source}: {text}", costs=costs,
            )  # fmt: skip


def _says(fault: Fault, text: str) -> bool:
    """Whether a fault says what a warning does."""
    return text in fault.sentence or any(
        words in text
        and fault.code == code
        and fault.sensor.startswith(sensor)
        and own in fault.sentence
        for words, code, sensor, own in SAID
    )


def _frame_of(recording: Recording) -> Recording:
    """Recording of the frame's sensor alone: what else is in the file says nothing of the path."""
    frame = {FRAME: recording.sensor(FRAME, gyroscope=True)}
    return Recording(recording.time_s, frame, source=recording.source)


def _of_sensors(
    recording: Recording, stillness: StillnessSettings, filled: NDArray[np.bool_]
) -> list[Fault]:
    """Faults that any sensor may have, as the path sees them; what a filled gap shows is none.

    A line has finer steps than a coarse sensor, whose rests then look frozen: with a gap counts
    what is found without its samples as well.
    """
    found = [
        fault
        for fault in examine(recording)
        if not (is_of_a_gap(fault, filled) or _is_a_flat_peak(fault, recording))
    ]
    if found and 0 < filled.mean() < MOST_FILLED:
        short = {
            (fault.code, fault.sensor) for fault in examine(without_samples(recording, filled))
        }
        found = [fault for fault in found if (fault.code, fault.sensor) in short]
    return [with_reach(fault, recording, stillness) for fault in found]


def _is_a_flat_peak(fault: Fault, recording: Recording) -> bool:
    """Whether an axis seems to be cut where another axis of the same half reads on."""
    if fault.code != "range" or fault.flags.mean() > OFTEN_AT_END:
        return False
    half = half_of(recording, FRAME, fault.sensor.removeprefix(f"{FRAME}_"))
    beyond = np.abs(half) > BEYOND_END * fault.size
    return any(long_runs(axis, BESIDE, grow=False).any() for axis in beyond.T)


def _with_readings(recording: Recording, found: list[Fault], more: list[Fault]) -> list[Fault]:
    """Faults together; a late half also looks like wrong signs, and in coarse steps like frozen."""
    codes = {fault.code for fault in more}
    if "lag" in codes and steps_are_coarse(recording, found):
        found = [fault for fault in found if not is_held(fault)]
    if codes & {"lag", "reversed"}:
        found = [fault for fault in found if fault.code != "reversed"]
    return found + more


def _by_rests(faults: Iterable[Fault], *, given: bool) -> list[Fault]:
    """Faults, of which rests that are given may be the cause."""
    words = f"; or are {GIVEN_WORDS} wrong there?"
    return [
        replace(fault, sentence=fault.sentence + words)
        if given and fault.code in BY_RESTS
        else fault
        for fault in faults
    ]


def _of_tilts(fault: Fault) -> Fault:
    """Fault whose sentence speaks of the mount, where that of a walk speaks of the path."""
    return replace(fault, sentence=fault.sentence.replace(UNKNOWN, TILTS_UNKNOWN))


def _negligible(fault: Fault) -> bool:
    """Whether a cut range costs so little that it may as well be a reading's rounding."""
    return (
        fault.code == "range"
        and fault.repair is not None
        and len(fault.costs) > 0
        and all(cost.largest < NEGLIGIBLE.get(cost.unit, 0.0) for cost in fault.costs)
    )


def _readings(recording: Recording, time_s: FloatArray, still: NDArray[np.bool_]) -> Readings:
    """Readings from a path's first sample on."""
    imu, count = recording.sensor(FRAME), len(time_s)
    rates = recording.gyroscope(FRAME)[-count:]
    return Readings(time_s, imu.acc_mps2[-count:], rates, still)


def _path_series(
    moved: Trajectory, stated: Trajectory, count: int
) -> dict[tuple[str, str], FloatArray]:
    """Distance from the stated place, and heading, for each sample of a recording."""
    both = min(len(moved), len(stated))
    apart = np.linalg.norm(moved.position_m[-both:] - stated.position_m[-both:], axis=1)
    return {
        ("place", "m"): _later(apart, count),
        ("heading", "deg"): _later(np.rad2deg(moved.yaw_rad), count),
    }


def _later(values: FloatArray, count: int) -> FloatArray:
    """Series of a recording's last samples, NaN before them."""
    whole = np.full(count, np.nan)
    whole[count - len(values) :] = values
    return whole


def _mount_series(
    moved: WalkerCalibration, stated: WalkerCalibration
) -> dict[tuple[str, str], FloatArray]:
    """Distance from the stated mount, and angle to its axes, (1,) arrays."""
    apart = moved.mount.translation_body_m - stated.mount.translation_body_m
    turn = moved.mount.rotation_imu_to_body @ stated.mount.rotation_imu_to_body.T
    angle = np.rad2deg(Rotation.from_matrix(turn).magnitude())
    return {
        ("position of the IMU", "m"): np.array([np.linalg.norm(apart)]),
        ("turn of the IMU", "deg"): np.array([angle]),
    }
