"""Faults that only a walking frame shows: by its rests, by its moves, and by its path."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.faults import Fault, half_of, interpolated, multiplied, shifted, with_half
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.health import fault_of
from mobility_imu.quality import (
    SHORTEST_FROZEN_S,
    resolution_of,
    same_as_before,
    turned_gravity,
)
from mobility_imu.recording import Recording
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.reach import (
    FRAME,
    UNKNOWN,
    is_of_half,
    placed,
    rates_in_time,
    samples_unknown,
    with_reach,
)
from mobility_imu.walker.rest_checks import (
    LARGEST_LAG_S,
    LEAST,
    MOST,
    MUCH,
    HalvesFit,
    Readings,
    drift_at_rest,
    fit_halves,
    moves_between_rests,
    rest_rates,
)
from mobility_imu.walker.rounding import unsure_by_rounding
from mobility_imu.walker.stillness import StillnessSettings, find_stillness

__all__ = ["faults_of_readings", "is_held", "steps_are_coarse"]

SOME_CUT = 0.01
"""Part of the samples at the end of a range from which on the halves are not held against each
other: what was cut looks like a scale. Our choice, not swept."""
HELD_STEPS, HELD_MPS2 = 2.0, 0.1
"""Change of gravity in a sensor's axes that it has to feel: so many steps and so much beyond.
Rounding hides one step, and one more at its edge; the rest is 0.6 deg of tilt. Our choice, not
swept."""
LEAST_LAG_S, LEAST_SCALE = 0.05, 0.06
"""Smallest lag that is told: the halves of one chip differ by up to 0.01 s (data sheets of their
low-passes), and the lags of 60 simulated walks without a fault, level "real", scatter by 0.014 s;
the largest is 0.040 s. (Lags and scales of 26 such walks, seeds from 500,000 on, scatter by 1.3
times what the fits state, those of 16 of the level "realistic" by as much as they state.) Smallest
error of the gyroscope's scale that is told: data sheets of cheap sensors allow 3 %, and of 165
simulated tilts of the level "real" the largest are 5.7, 5.5, 4.9 and 4.8 %."""
NEW_RESTS, LESS_LEFT = 4, 0.9
"""How often the rests are found anew beside a late half, and the part of the misfit that may be
left each time. Our choice, not swept."""
LARGE_SCALE = 3.0
"""A scale that is so many times wrong is told in times, a smaller one in per cent."""
NEAR_UNIT = 1.35
"""A scale that is as many times wrong as deg/s are rad/s, within this factor, is asked for its
unit. Our choice, not swept; of a unit what is found lies within 15 %."""
SURE_TIMES = 4.0
"""Lag and scale are told if they are so many standard deviations: one in 16 000 of normal errors,
which those of few moves are not. Our choice, not swept."""
SHORTEST_REST_S = 0.5
"""Shortest rest whose mean rate counts. Our choice, not swept."""
ANY_REST_RADPS, FIRST_REST_RADPS, LASTING_RADPS = np.deg2rad([1.0, 0.1, 0.2]).tolist()
"""Mean rate of a rest against the other rests': of any; of the first,
from which the path starts; of three that follow each other. On 16 real walks the largest are 0.66,
0.41 and 0.41 deg/s; with unsteady hands all are large, so that the last two also have to be
:data:`REST_TIMES` the usual one."""
REST_TIMES, FEWEST_RESTS = 5.0, 3
"""Times the usual size, our choice, not swept; and the fewest rests whose median leaves out one
that is off."""
JUMP_RADPS, JUMP_TIMES = float(np.deg2rad(0.1)), 6.0
"""Difference of the rests' median rates before and after a moment, our choice, not swept: left
in the rates it turns by 6 deg in a minute. And how many times its standard deviation it has to be:
on 16 real walks the largest is 5.0 times."""
SD_OF_MEDIAN, SD_BY_MEDIAN = 1.25, 1.48
"""Of normal numbers: a median's standard deviation against a mean's, sqrt(pi / 2), and the standard
deviation against the median of their sizes."""
LEAST_SCATTER_RADPS = 1e-6
"""Scatter of the rests' rates below which it is rounding."""
INSIDE = 0.1
"""Part of the jump from which on a rest shows it. Our choice, not swept."""
ROLLS_MPS, ROLLS_S = 0.3, 1.5
"""A frame at rest does not gain so much speed in so short a time, twice. Rocking and landing of 200
simulated recordings gain up to 0.24 m/s."""
OFF_GRAVITY_MPS2 = 0.6
"""Gravity at rest against 9.81: an offset of 60 mg, what data sheets of cheap sensors allow."""
OFF_TILT_DEG, OFF_SPEED_MPS = 8.0, 1.5
"""Misfit of a single move that no real walk of 16 has (5.9 deg, 0.9 m/s)."""
SPIKE_RADPS, SPIKE_MPS2, LEAST_SPIKE_MPS2, SPIKE_TIMES = 0.5, 8.0, 3.0, 8.0
"""Single readings off both neighbours, which agree, by so much and by so many times the changes
around them. On 16 real walks the largest are 0.32 rad/s and 3.7 m/s². A smaller one of the
accelerometer is told if the velocity comes back to zero without it."""
AROUND = 11
"""Samples around a spike whose changes are the usual ones: their median leaves a spike out. Our
choice, not swept."""
AGREE = 0.25
"""Neighbours of a spike agree if they differ by less than this part of it, as for the spikes that
every recording is examined for."""
SPOILT_TIMES, COMES_BACK = 3.0, 0.5
"""The velocity after a move comes back to zero without a reading if it was more than so many times
the usual one, and then is less than this part of it. Our choice, not swept."""


def faults_of_readings(
    recording: Recording,
    readings: Readings,
    found: Sequence[Fault],
    stillness: StillnessSettings,
) -> list[Fault]:
    """Faults that the readings show by their rests, other than those that are found already.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    readings : Readings of its last samples, with their rests
    found : Fault of the frame, of :func:`mobility_imu.health.examine`
    stillness : StillnessSettings that the rests were found with

    Returns
    -------
    list of Fault
    """
    checks: list[Iterable[Fault]] = [_spikes(recording, readings, found)]
    cut = any(f.code == "range" and f.flags.mean() > SOME_CUT for f in found)
    frozen = any(f.code == "frozen" for f in found)
    held = [] if frozen else list(_held(recording, found, stillness))
    lost = samples_unknown([*found, *held], len(recording))
    # In coarse steps a late half looks frozen: then its samples are asked for a lag first.
    firm = samples_unknown([f for f in found if not is_held(f)], len(recording))
    late: list[Fault] = []
    if (cut or lost.any()) and steps_are_coarse(recording, found):
        asked = readings._replace(lost=firm[-len(readings.time_s) :])
        late = [fault for fault in _halves(recording, asked, stillness) if fault.code == "lag"]
    if late:
        held, lost = [], firm
    readings = readings._replace(lost=lost[-len(readings.time_s) :])
    turning = [] if cut else list(_turning_rests(recording, readings))
    checks.append(late if late or cut else _halves(recording, readings, stillness, turning))
    checks.append(_gravity(recording, readings))
    told = held + [fault for check in checks for fault in check]
    if cut:
        return told
    told += turning
    if not turning:
        steady = readings._replace(
            gyr_radps=rates_in_time(recording, told)[-len(readings.time_s) :]
        )
        told += _rolling_rests(recording, steady, stillness)
    if not told:
        told += _misfits(recording, readings)
    return told


def is_held(fault: Fault) -> bool:
    """Whether a fault is an accelerometer that repeats itself.

    Parameters
    ----------
    fault : Fault

    Returns
    -------
    bool
    """
    return (fault.code, fault.sensor) == ("frozen", f"{FRAME}_acc")


def steps_are_coarse(recording: Recording, found: Iterable[Fault]) -> bool:
    """Whether the accelerometer may repeat itself because of its steps.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    found : Fault; a gap that was filled tells nothing of the steps

    Returns
    -------
    bool
    """
    gaps = samples_unknown([f for f in found if f.code == "gap"], len(recording))
    return resolution_of(recording.sensor(FRAME).acc_mps2, skip=gaps).all_coarse


def _halves(
    recording: Recording,
    readings: Readings,
    stillness: StillnessSettings,
    turning: Iterable[Fault] = (),
) -> Iterator[Fault]:
    """Signs, lag and scale of the gyroscope against the accelerometer.

    One offset is taken for all rests. Where rests are told to turn, the rates without their offsets
    are tried as well: a late half also turns at rest, an offset that changes also looks late.
    """
    whole = np.ones(len(recording), np.bool_)
    fit = _with_own_rests(readings, recording.sampling_rate_hz, stillness)
    for fault in turning:
        if fault.repair is not None:
            steady = fault.repair(recording).gyroscope(FRAME)[-len(readings.time_s) :]
            fit = min(fit, fit_halves(readings._replace(gyr_radps=steady)), key=_left)
    label = f"{FRAME}_gyr"
    if fit.silent:
        yield fault_of(
            recording, "scale", label, whole,
            "reads no more in moves than at rest, although the frame tilts there, as the velocity "
            "that is left at the next rest shows: it says nothing of it; check its unit and its "
            "axes, or use another sensor" + UNKNOWN,
        )  # fmt: skip
    if not fit.seen:
        return
    if (fit.signs < 0).any():
        bad = [axis for axis, sign in zip("xyz", fit.signs, strict=True) if sign < 0]
        yield fault_of(
            recording, "reversed", label, whole,
            f"turns the other way than gravity shows from rest to rest: {_wrong_signs(bad)}; check "
            "the export's axes",
            repair=partial(multiplied, sensor=FRAME, half="gyr", factors=fit.signs),
        )  # fmt: skip
        return
    lag_by_steps, scale_by_steps = unsure_by_rounding(readings)
    if abs(fit.lag_s) > max(LEAST_LAG_S + lag_by_steps, SURE_TIMES * fit.lag_sd_s):
        way = "later" if fit.lag_s > 0 else "earlier"
        yield fault_of(
            recording, "lag", label, whole,
            f"comes {abs(fit.lag_s):.2f} ± {fit.lag_sd_s:.2f} s {way} than the accelerometer, as "
            "the rests show; read both halves with one clock",
            size=fit.lag_s, unit="s",
            repair=partial(shifted, sensor=FRAME, lag_s=fit.lag_s, half="gyr"),
        )  # fmt: skip
    off = 1 / fit.scale - 1
    # Gravity along a wrong axis turns by up to as much too far, or too little.
    unsure = abs(_gravity_at_rest(readings) / STANDARD_GRAVITY_MPS2 - 1)
    if unsure <= OFF_GRAVITY_MPS2 / STANDARD_GRAVITY_MPS2:
        unsure = 0.0
    if (
        abs(off) > LEAST_SCALE + unsure + scale_by_steps
        and abs(fit.scale - 1) > SURE_TIMES * fit.scale_sd
    ):
        yield fault_of(
            recording, "scale", label, whole,
            f"reads {_scale_words(fit)} as far as tilts show it, and about the vertical, "
            "where nothing shows it, probably as well; calibrate it, or use another sensor",
            size=off, unit="1", repair=partial(_rates_scaled, factor=fit.scale),
        )  # fmt: skip


def _wrong_signs(bad: Sequence[str]) -> str:
    """Which half may have wrong signs; two axes of the gyroscope are one of the accelerometer."""
    what = "the gyroscope" if len(bad) == 3 else f"axis {', '.join(bad)} of the gyroscope"
    other = "the accelerometer has"
    if len(bad) == 2:  # the same from rest to rest, but the place by it is another
        (axis,) = set("xyz") - set(bad)
        other = f"axis {axis} of the accelerometer has, and the path is mirrored as well"
    return f"{what} has the wrong sign, or {other}"


def _left(fit: HalvesFit) -> float:
    return fit.left


def _with_own_rests(readings: Readings, rate_hz: float, stillness: StillnessSettings) -> HalvesFit:
    """Fit of the halves, with rests found anew after a lag is taken back, if that leaves far less.

    Beside a late half a slow turn begins, or ends, in what passes for a rest.
    """
    fit, time_s = fit_halves(readings), readings.time_s
    for _ in range(NEW_RESTS):
        if not fit.seen or fit.left < MUCH or (fit.signs < 0).any():
            break
        rates = np.column_stack(
            [np.interp(time_s + fit.lag_s, time_s, axis) for axis in readings.gyr_radps.T]
        )
        moved = readings._replace(gyr_radps=rates)
        still = find_stillness(readings.acc_mps2, rates - moved.offset(), rate_hz, stillness)
        new = fit_halves(moved._replace(still=still))
        if (
            not new.seen
            or new.left > LESS_LEFT * fit.left
            or abs(fit.lag_s + new.lag_s) > 2 * LARGEST_LAG_S
        ):
            break
        fit = new._replace(lag_s=fit.lag_s + new.lag_s)
    return fit


def _scale_words(fit: HalvesFit) -> str:
    """By how much the rates are too large or too small, in parts or in times."""
    way = "too much" if fit.scale < 1 else "too little"
    if 1 / LARGE_SCALE < fit.scale < LARGE_SCALE:
        sd = 100 * fit.scale_sd / fit.scale**2
        return f"{abs(100 * (1 / fit.scale - 1)):.0f} ± {sd:.0f} % {way}"
    times = max(fit.scale, 1 / fit.scale)
    if not LEAST[1] < fit.scale < MOST[1]:
        return f"{times:.0f} times or more {way}"
    words = f"{times:.3g} ± {times * fit.scale_sd / fit.scale:.2g} times {way}"
    unit = abs(np.log(times / np.rad2deg(1.0))) < np.log(NEAR_UNIT)
    return f"{words} (deg/s and rad/s are 57.3 apart: is the unit right?)" if unit else words


def _held(
    recording: Recording, found: Sequence[Fault], stillness: StillnessSettings
) -> Iterator[Fault]:
    """An accelerometer in coarse steps that repeats itself while the gyroscope turns gravity."""
    imu, rate_hz = recording.sensor(FRAME), recording.sampling_rate_hz
    same = long_runs(
        same_as_before(imu.acc_mps2), max(2, round(SHORTEST_FROZEN_S * rate_hz) - 1), grow=True
    )
    if not same.any():
        return
    # The offset is taken off in there.
    felt = turned_gravity(imu.acc_mps2, recording.gyroscope(FRAME), rate_hz)
    unknown = same | samples_unknown(found, len(recording))
    step = float(resolution_of(imu.acc_mps2, skip=unknown).step.max())
    flags = np.zeros(len(recording), np.bool_)
    for run in runs_of(same):
        flags[run] = np.ptp(felt[run], axis=0).max() > HELD_STEPS * step + HELD_MPS2
    if flags.any():
        fault = fault_of(
            recording, "frozen", f"{FRAME}_acc", flags,
            "repeats its last reading while the gyroscope reads that the frame tilts; leave these "
            "times out, or record again", size=float(flags.sum() / rate_hz), unit="s",
            repair=partial(interpolated, sensor=FRAME, half="acc", flags=flags),
        )  # fmt: skip
        yield with_reach(fault, recording, stillness)


def _rates_scaled(recording: Recording, factor: float) -> Recording:
    """Recording with rates times a factor about their median, which is the offset of most."""
    rates = recording.gyroscope(FRAME)
    offset = np.median(rates, axis=0)
    return with_half(recording, FRAME, "gyr", offset + factor * (rates - offset))


def _gravity(recording: Recording, readings: Readings) -> Iterator[Fault]:
    """An accelerometer that reads another gravity than the earth's."""
    size = _gravity_at_rest(readings)
    if abs(size - STANDARD_GRAVITY_MPS2) <= OFF_GRAVITY_MPS2:
        return
    factor = STANDARD_GRAVITY_MPS2 / size
    percent, way = abs(100 / factor - 100), "long" if factor < 1 else "short"
    yield fault_of(
        recording, "gravity", f"{FRAME}_acc", np.ones(len(recording), np.bool_),
        f"reads {size:.2f} m/s² at rest, expected {STANDARD_GRAVITY_MPS2:.2f}: its scale or its "
        f"offset is wrong; if it is the scale, lengths are {percent:.0f} % too {way}; calibrate "
        "it, or use another sensor",
        size=size - STANDARD_GRAVITY_MPS2, unit="m/s²",
        repair=partial(multiplied, sensor=FRAME, half="acc", factors=factor),
    )  # fmt: skip


def _gravity_at_rest(readings: Readings) -> float:
    """Median length of the rests' mean forces, m/s²; the earth's gravity if there is no rest."""
    rests = runs_of(readings.still_and_known)
    means = [readings.acc_mps2[rest].mean(axis=0) for rest in rests]
    return float(np.median(np.linalg.norm(means, axis=1))) if rests else STANDARD_GRAVITY_MPS2


def _turning_rests(recording: Recording, readings: Readings) -> Iterator[Fault]:
    """Rests in which the gyroscope reads another offset than in the others."""
    rests, off = rest_rates(readings, SHORTEST_REST_S)
    if len(rests) < FEWEST_RESTS:
        return
    size = np.linalg.norm(off, axis=1)
    lasting = np.linalg.norm(ndimage.median_filter(off, (3, 1), mode="nearest"), axis=1)
    usual = REST_TIMES * float(np.median(size))
    first = size[0] > max(FIRST_REST_RADPS, usual)
    bad = (size > ANY_REST_RADPS) | (lasting > max(LASTING_RADPS, usual))
    bad[0] |= first
    middles = np.array([readings.time_s[rest].mean() for rest in rests])
    jump, drifts = _jump_at(off, middles)
    bad[jump if jump else len(bad) :] = True
    bad |= drifts
    if not bad.any():
        return
    flags = np.zeros(len(readings.time_s), np.bool_)
    for rest, is_bad in zip(rests, bad, strict=True):
        flags[rest] |= is_bad
    flags, largest = placed(flags, len(recording)), float(np.rad2deg(size[bad].max()))
    if jump:
        apart = np.median(off[:jump], axis=0) - np.median(off[jump:], axis=0)
        largest = float(np.rad2deg(np.linalg.norm(apart)))
        last, when = _time_of_jump(readings.time_s, rests, off, jump)
        what = (
            f"reads another rate at rest from {when:.1f} s on than before, {largest:.2f} deg/s "
            "apart: its offset jumps; cut the recording there, or use another sensor"
        )
        flags = recording.time_s >= last
        repair = partial(_rates_off, flags=recording.time_s >= when, rate_radps=-apart)
    elif drifts:
        largest = float(np.rad2deg(np.linalg.norm(off[-1] - off[0])))
        what = (
            f"reads another rate in the last rest than in the first, {largest:.2f} deg/s apart, "
            "and others between them in turn: its offset drifts; let the sensor warm up, or use "
            "another sensor"
        )
        flags = np.ones(len(recording), np.bool_)
        repair = partial(_offsets_off, middles_s=middles, offsets=off)
    elif first and not bad[1:].any():
        what = (
            f"reads another rate in the first rest than in the others, {largest:.1f} deg/s apart: "
            "the frame moves where rest was promised, and this passes for the gyroscope's offset; "
            "let it stand for some seconds before it moves"
        )
        repair = partial(_rates_off, flags=flags, rate_radps=off[0])
    else:
        what = (
            f"reads another rate in some rests than in most, up to {largest:.1f} deg/s apart: its "
            "offset changes, or the frame is turned where it counts as still; let the sensor warm "
            "up, and the frame stand between its moves"
        )
        repair = partial(_offsets_off, middles_s=middles, offsets=off)
    label = f"{FRAME}_gyr"
    yield fault_of(
        recording, "offset", label, flags, what, size=largest, unit="deg/s", repair=repair
    )


def _jump_at(off: FloatArray, middles_s: FloatArray) -> tuple[int, bool]:
    """First rest after a jump of the offset, 0 if there is none; and whether it drifts instead."""
    if len(off) < 2 * FEWEST_RESTS:
        return 0, False
    scatter = SD_BY_MEDIAN * np.median(np.abs(np.diff(off, axis=0)), axis=0) / np.sqrt(2)
    scatter = np.maximum(scatter, LEAST_SCATTER_RADPS)
    sure = False
    for k in range(FEWEST_RESTS, len(off) - FEWEST_RESTS + 1):
        apart = np.abs(np.median(off[:k], axis=0) - np.median(off[k:], axis=0))
        sd = SD_OF_MEDIAN * scatter * np.sqrt(1 / k + 1 / (len(off) - k))
        sure |= bool((apart / sd).max() > JUMP_TIMES and np.linalg.norm(apart) > JUMP_RADPS)
    if not sure:
        return 0, False
    # Medians hardly change with some rests of the other side: what is left beside them does.
    left = [
        sum(np.abs(part - np.median(part, axis=0)).sum() for part in (off[:k], off[k:]))
        for k in range(1, len(off))
    ]
    if np.abs(off - _curve(off, middles_s)).sum() < min(left):
        return 0, True
    return 1 + int(np.argmin(left)), False


def _curve(off: FloatArray, middles_s: FloatArray) -> FloatArray:
    """Parabola through the rests' rates: as many numbers as a jump has, two levels and a time."""
    when = middles_s - middles_s.mean()
    fit = np.polynomial.polynomial.polyfit(when, off, 2)
    return np.asarray(np.polynomial.polynomial.polyval(when, fit).T)


def _time_of_jump(
    time_s: FloatArray, rests: Sequence[slice], off: FloatArray, jump: int
) -> tuple[float, float]:
    """End of the last rest that does not show a jump, and when it jumps, s.

    The mean of a rest in which it jumps says when; between two rests it is the middle.
    """
    before, after = np.median(off[:jump], axis=0), np.median(off[jump:], axis=0)
    apart = after - before
    part = (off - before) @ apart / max(float(apart @ apart), 1e-12)
    when = (time_s[rests[jump - 1].stop - 1] + time_s[rests[jump].start]) / 2
    for k in (jump - 1, jump):
        if INSIDE < part[k] < 1 - INSIDE:
            begin, end = time_s[rests[k].start], time_s[rests[k].stop - 1]
            when = end - part[k] * (end - begin)
    last = jump - 1
    while last > 0 and part[last] > INSIDE:
        last -= 1
    return float(time_s[rests[last].stop - 1]), float(when)


def _rates_off(recording: Recording, flags: NDArray[np.bool_], rate_radps: FloatArray) -> Recording:
    """Recording with a rate taken off where the flags say so."""
    rates = recording.gyroscope(FRAME) - np.outer(flags, rate_radps)
    return with_half(recording, FRAME, "gyr", rates)


def _offsets_off(recording: Recording, middles_s: FloatArray, offsets: FloatArray) -> Recording:
    """Recording without offsets that are lines from rest to rest."""
    off = [np.interp(recording.time_s, middles_s, axis) for axis in offsets.T]
    return with_half(recording, FRAME, "gyr", recording.gyroscope(FRAME) - np.column_stack(off))


def _rolling_rests(
    recording: Recording, readings: Readings, stillness: StillnessSettings
) -> Iterator[Fault]:
    """Rests in which the frame gains speed.

    Of rests that are known, the ends count as far as the detector finds them still as well: there
    the frame lands, and is lifted.
    """
    quiet = np.zeros(len(readings.time_s), np.bool_)
    for offset in (np.zeros(3), readings.offset()):  # the detector takes off large ones alone
        rates = readings.gyr_radps - offset
        quiet |= find_stillness(readings.acc_mps2, rates, recording.sampling_rate_hz, stillness)
    inner = np.zeros(len(quiet), np.bool_)
    for rest in runs_of(readings.still):
        if quiet[rest].any():
            first, last = np.flatnonzero(quiet[rest])[[0, -1]]
            inner[rest.start + first : rest.start + last + 1] = True
    flags, largest, often = np.zeros(len(readings.time_s), np.bool_), 0.0, 0
    for rest, gained in drift_at_rest(readings._replace(still=inner), ROLLS_S):
        if gained.max() > ROLLS_MPS:
            flags[rest], largest = True, max(largest, float(gained.max()))
            often += len(runs_of(gained > ROLLS_MPS))
    if often > 1:
        yield fault_of(
            recording, "rolls", FRAME, placed(flags, len(recording)),
            f"counts as still, but gains up to {largest:.2g} m/s within {ROLLS_S:g} s, {often} "
            "times: a frame that is rolled smoothly passes for still, and the way that it rolls "
            "there is lost; this method follows a frame that is lifted and set down: record it so",
            size=largest, unit="m/s",
        )  # fmt: skip


def _misfits(recording: Recording, readings: Readings) -> Iterator[Fault]:
    """Moves after which both halves are far apart."""
    moves = moves_between_rests(readings)
    bad = (moves.tilt_deg > OFF_TILT_DEG) | (moves.speed_mps > OFF_SPEED_MPS)
    if not bad.any():
        return
    flags = np.zeros(len(readings.time_s), np.bool_)
    for span, is_bad in zip(moves.spans, bad, strict=True):
        flags[span] |= is_bad
    yield fault_of(
        recording, "at odds", FRAME, placed(flags, len(recording)),
        f"does not fit together in {int(bad.sum())} moves: from rest to rest gravity turns up to "
        f"{moves.tilt_deg.max():.1f} deg otherwise than the gyroscope reads, and the velocity that "
        f"is left at rest is up to {moves.speed_mps.max():.2g} m/s; check the units and axes of "
        "both halves, and what happened there" + UNKNOWN,
        size=float(moves.tilt_deg.max()), unit="deg",
    )  # fmt: skip


def _spikes(recording: Recording, readings: Readings, found: Sequence[Fault]) -> Iterator[Fault]:
    """Single readings that are smaller than those that any recording is examined for."""
    count = len(recording)
    for half, unit in (("acc", "m/s²"), ("gyr", "rad/s")):
        label = f"{FRAME}_{half}"
        known = np.zeros(count, np.bool_)
        for fault in found:
            if is_of_half(fault, half):
                known |= fault.flags
        if known.all():
            continue
        size = _alone(half_of(recording, FRAME, half)) * ~known
        far = size > (SPIKE_MPS2 if half == "acc" else SPIKE_RADPS)
        if half == "acc":
            far |= placed(_explaining(readings, size[-len(readings.time_s) :]), count)
        if far.any():
            yield fault_of(
                recording, "spike", label, far,
                f"jumps for single samples (by {size[far].max():.3g} {unit} at most), which no "
                "frame does; remove them", size=float(size[far].max()), unit=unit,
                repair=partial(interpolated, sensor=FRAME, half=half, flags=far),
            )  # fmt: skip


def _alone(values: FloatArray) -> FloatArray:
    """By how much each reading is off both neighbours, where these agree; else 0."""
    size = np.zeros(len(values))
    if len(values) < 5:
        return size
    step = np.diff(values, axis=0)
    up, down = step[:-1], step[1:]
    off = np.minimum(np.abs(up), np.abs(down))
    usual = ndimage.median_filter(np.abs(step), (AROUND, 1))[1:]
    alone = (np.sign(up) != np.sign(down)) & (np.abs(up + down) < AGREE * off)
    size[1:-1] = np.where(alone & (off > SPIKE_TIMES * usual), off, 0.0).max(axis=1)
    return size


def _explaining(readings: Readings, size: FloatArray) -> NDArray[np.bool_]:
    """Readings without which the velocity after their move comes back to zero."""
    far = size > LEAST_SPIKE_MPS2
    if not far.any():
        return far
    index = np.arange(len(size))
    acc = np.column_stack([np.interp(index, index[~far], a[~far]) for a in readings.acc_mps2.T])
    before, after = (
        moves_between_rests(each) for each in (readings, readings._replace(acc_mps2=acc))
    )
    usual = float(np.median(after.speed_mps)) if after.spans else np.inf
    sure = np.zeros(len(size), np.bool_)
    for span, was, now in zip(before.spans, before.speed_mps, after.speed_mps, strict=True):
        if was > SPOILT_TIMES * usual and now < COMES_BACK * was:
            sure[span] = True
    return far & sure
