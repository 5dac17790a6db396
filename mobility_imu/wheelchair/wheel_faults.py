"""Faults of a wheel's sensor that the other sensors, or its own accelerometer, show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.faults import (
    Fault,
    Repair,
    exchanged,
    half_of,
    multiplied,
    shifted,
    turned_back,
    with_half,
    without_offset,
)
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.contradictions import SharedMotion, axle_of, gain_of
from mobility_imu.wheelchair.fits import fit_by_pieces, pieces_of
from mobility_imu.wheelchair.geometry import SIDES, Side
from mobility_imu.wheelchair.lags import Lag
from mobility_imu.wheelchair.recovery import tied_rate
from mobility_imu.wheelchair.rest_faults import FEWEST_BLOCKS, rests
from mobility_imu.wheelchair.sign_faults import APART, GO_TOGETHER, correlation_of, reads_gravity
from mobility_imu.wheelchair.turning import yaw_rate_of_wheel

__all__ = [
    "drift_between",
    "late",
    "other_axles",
    "other_spins",
    "wrong_offsets",
    "wrong_scales",
]

LARGEST_AXLE_RAD = float(np.deg2rad(2.0))
"""Axle of a drive against that of the straight-line trial: real drives stay below 1.5 deg."""
AXLE_SCATTERS = 1.5
"""Times what is left across the axle: in two or three turns of a wheel the chair's own turn, which
goes round with the wheel, does not cancel. Set by hand on simulated courts that the study of faults
does not use."""
MOSTLY_ACROSS = 0.2
"""A sensor that turns across its axle by more of what it turns in all shows no axle; set as above.
"""
LEAST_LAG_SAMPLES = 0.8
"""A sensor's rows stand for some time within one sample: up to one lies between two sensors."""
LEAST_LAG_SD_S = 0.001
"""Standard deviation of a lag at least: vibration is no movement of the whole chair."""
SURE_SIGN = 0.5
"""A factor beyond it, with the wrong sign, is no scale error: no gyroscope reads so little."""
SURE = 4.0
"""Standard deviations from which on a difference is told; by chance once in 10,000 times."""
LEAST_SCALE = 0.0125
"""A wheel's gyroscope that is off by more moves the speed by 0.6 %: one and a half of the standard
deviations that radii (0.5 %) and scale factors (0.3 %) leave."""
LEAST_OFFSET_RADPS = float(np.deg2rad(0.3))
"""Three times what an offset changes by from one recording to the next."""


FACTORY_SCALE_SD = 0.01
"""Scale factor of a gyroscope as it leaves the factory (MPU-6050: 3 % allowed)."""
LEAST_CLOCK, CLOCK_SDS = 0.03, 3.0
"""Scale that no gyroscope has (MPU-6050: 3 %), and how near two have to be to be one clock's."""
LARGEST_CONDITION = 50.0
"""Beyond it, turn, speed and constant cannot be told apart: errors may grow so many times."""
PIECE_S = 2.0
"""Residuals of one piece depend on each other: a stroke lasts about a second."""
FEWEST_PIECES = 10
"""Of fewer, the scatter says little: chance makes it ten times too small."""


def other_axles(w: SharedMotion) -> Iterator[Fault]:
    """A wheel's sensor that spins about another axle than in the straight-line trial.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    seen = {side: axle_of(w, side) for side in w.sides}
    known = {side: w.mount.rotation_imu_to_wheel(side)[2] for side in w.sides}
    axles = {side: found[0] for side, found in seen.items() if found and found[1] < MOSTLY_ACROSS}
    apart = {side: _between(axle, known[side]) for side, axle in axles.items()}
    least = {
        side: max(LARGEST_AXLE_RAD, AXLE_SCATTERS * found[1])
        for side, found in seen.items()
        if found
    }
    if len(axles) == 2:
        crossed = max(
            _between(axles["left"], known["right"]), _between(axles["right"], known["left"])
        )
        if max(apart.values()) > max(least.values()) and crossed < max(least.values()):
            yield _exchanged(w.recording, in_trial=True)
            return
    both = all(f"{side}_wheel" in w.names for side in SIDES)
    for side, angle in apart.items():
        if angle <= least[side]:
            continue
        if len(axles) == 1 and both:
            # The other wheel's gyroscope fails, or turns too little: its axle is still known.
            other: Side = "right" if side == "left" else "left"
            if _between(axles[side], w.mount.rotation_imu_to_wheel(other)[2]) < least[side]:
                yield _exchanged(w.recording, in_trial=True)
                return
        name = f"{side}_wheel"
        axle = axles[side] * _way_round(w, side, axles[side], known[side])
        angle = float(np.arccos(np.clip(axle @ known[side], -1.0, 1.0)))
        turn = Rotation.align_vectors(known[side][None], axle[None])[0].as_matrix()
        yield fault_of(
            w.recording, "turned", name, np.ones(len(w.recording), np.bool_),
            f"spins about an axle {np.rad2deg(angle):.1f} deg off that of the straight-line trial: "
            "the sensor was turned in between, or one of its axes has the wrong sign; record both "
            "trials anew", size=float(np.rad2deg(angle)), unit="deg",
            repair=partial(turned_back, sensor=name, rotation=turn),
        )  # fmt: skip


def _way_round(w: SharedMotion, side: Side, axle: FloatArray, known: FloatArray) -> float:
    """Sign of an axle with which it spins as the other sensors expect; nearest without them."""
    name, gyr = f"{side}_wheel", w.at_rest.gyroscope(f"{side}_wheel")
    if len(w.sides) == 2 and "frame" not in w.mute:
        along = {one: w.rates[one][:, 2] for one in w.names if one != name}
        together = float(tied_rate(along, name, w.geometry) @ (gyr @ axle))
        return 1.0 if together >= 0 else -1.0
    return 1.0 if axle @ known >= 0 else -1.0


def _between(first: FloatArray, second: FloatArray) -> float:
    """Angle between two lines, rad."""
    return float(np.arccos(np.clip(abs(first @ second), 0.0, 1.0)))


def _exchanged(recording: Recording, *, in_trial: bool, backward: bool = False) -> Fault:
    both = "left_wheel, right_wheel"
    other_way = "turn the chair the other way than each of the three sensors by itself"
    what = f"have each other's names: the wheels {other_way}; exchange the names in all recordings"
    if in_trial:
        what = (
            "have each other's names in the trial, by the axles that they spin about; exchange the "
            "names"
        )
    elif backward:
        what = (
            f"{other_way}, and roll backward: the straight-line trial was driven backward, record "
            "it anew; or, if the chair did go backward here, the two have each other's names"
        )
    repair = partial(exchanged, first="left_wheel", second="right_wheel") if in_trial else None
    whole = np.ones(len(recording), np.bool_)
    return fault_of(recording, "exchanged", both, whole, what, repair=repair)


def exchanged_wheels(w: SharedMotion) -> Fault:
    """Fault of wheels whose names are exchanged.

    Where both sensors have the same axle, only the trial's names may be wrong; where each has its
    own, which fits, the names are wrong in all recordings, and the mount with them.

    Parameters
    ----------
    w : SharedMotion

    Returns
    -------
    Fault
    """
    left, right = (w.mount.rotation_imu_to_wheel(side)[2] for side in w.sides)
    alike = float(left @ right) > np.cos(LARGEST_AXLE_RAD)
    # Turned by half a turn about the vertical a chair has its wheels exchanged and goes backward:
    # which of the two is wrong shows by the way alone, which is mostly forward.
    way = sum(float(w.rates[f"{side}_wheel"][:, 2].sum()) for side in w.sides)
    return _exchanged(w.recording, in_trial=alike, backward=way < 0)


def other_spins(w: SharedMotion) -> Iterator[Fault]:
    """A wheel's gyroscope some of whose axes have the wrong sign.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    for side in w.sides:
        fit, name = w.spin_fits[side], f"{side}_wheel"
        if reads_gravity(w, name):
            yield fault_of(
                w.recording, "reversed", f"{name}_acc", np.ones(len(w.recording), np.bool_),
                "reads -1 g upward, by the chair's turn: all axes of the accelerometer have the "
                "wrong sign; check the export's axes",
                repair=partial(multiplied, sensor=name, half="acc", factors=-np.ones(3)),
            )  # fmt: skip
            continue
        signs = (
            (-1.0, -1.0, -1.0) if fit is not None and fit.factor < -SURE_SIGN else _signs(w, side)
        )
        if signs is None:
            continue
        bad = [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
        what = "the gyroscope" if len(bad) == 3 else f"axis {', '.join(bad)} of the gyroscope"
        yield fault_of(
            w.recording, "reversed", f"{name}_gyr", np.ones(len(w.recording), np.bool_),
            f"turns the other way than gravity shows: {what} has the wrong sign, or the "
            "accelerometer has; check the export's axes",
            repair=partial(multiplied, sensor=name, half="gyr", factors=np.array(signs)),
        )  # fmt: skip


def _signs(w: SharedMotion, side: Side) -> tuple[float, ...] | None:
    """Signs of a wheel's axes with which its own yaw rate goes with the two other sensors'.

    An axis across the axle with the wrong sign leaves the spin nearly as it is, and makes nonsense
    of the chair's turn, which goes round across the axle.
    """
    name, others = f"{side}_wheel", [n for n in w.yaw if n != f"{side}_wheel"]
    if len(others) < 2 or not w.turns(others[0]):
        return None
    first, second = (w.yaw[other] for other in others)
    together = correlation_of(first, second, w.rate_hz)
    if together < GO_TOGETHER or correlation_of(first, w.yaw[name], w.rate_hz) > APART:
        return None
    turn = w.mount.rotation_imu_to_wheel(side)
    best, most = None, GO_TOGETHER
    for signs in product((1.0, -1.0), repeat=3):
        gyr = (w.at_rest.gyroscope(name) * np.array(signs)) @ turn.T
        yaw = yaw_rate_of_wheel(gyr, w.forces[name], w.geometry.camber_rad, w.rate_hz)
        found = correlation_of(first, yaw, w.rate_hz)
        if found > most:
            best, most = signs, found
    return best if best is not None and min(best) < 0 else None


def late(w: SharedMotion) -> Iterator[Fault]:
    """A sensor that comes later or earlier than the others.

    Of three sensors two agree; of two, which one is late cannot be told.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    lags = w.lags()
    if not lags:
        return
    first = next(iter(lags))[0]
    times, sds = _times_after(first, lags)
    least = LEAST_LAG_SAMPLES / w.rate_hz
    if len(times) == 3:
        middle = float(np.median(list(times.values())))
        behind = "the two others"
    elif len(times) == 2:
        middle, behind = 0.0, f"{first} (which of the two is wrong, two cannot tell)"
    else:
        return
    spread = float(np.linalg.norm(sorted(sds.values())[-2:]))
    for name, time_s in times.items():
        lag_s = time_s - middle
        drift = _drift_of(w, name, list(times))
        if drift is None and abs(lag_s) <= max(least, SURE * spread):
            continue
        way = "lags by" if lag_s > 0 else "comes early by"
        whole = np.ones(len(w.recording), np.bool_)
        if drift is not None:
            size = max(abs(one) for one in drift)
            yield fault_of(
                w.recording, "lag", name, whole,
                f"has a clock that drifts against {behind}: its lag is {drift[0]:+.3f} s at the "
                f"beginning and {drift[1]:+.3f} s at the end; put the sensors on one clock",
                size=size, unit="s", repair=partial(_redrifted, sensor=name, lags_s=drift),
            )  # fmt: skip
            continue
        yield fault_of(
            w.recording, "lag", name, whole,
            f"{way} {abs(lag_s):.3f} ± {spread:.3f} s against {behind}; put the sensors on one "
            "clock", size=abs(lag_s), unit="s", repair=partial(shifted, sensor=name, lag_s=lag_s),
        )  # fmt: skip


def _drift_of(w: SharedMotion, name: str, names: Sequence[str]) -> tuple[float, float] | None:
    """Lags of a sensor at both ends, if it drifts against two others that do not drift."""
    others = [one for one in names if one != name]
    if len(others) < 2:
        return None
    drift = drift_between(w, name, others[0])
    if drift is None or drift_between(w, name, others[1]) is None:
        return None
    return drift if drift_between(w, *others) is None else None


def drift_between(w: SharedMotion, name: str, other: str) -> tuple[float, float] | None:
    """Lags of a sensor at the beginning and the end, where those of both halves surely differ.

    Parameters
    ----------
    w : SharedMotion
    name, other : sensors

    Returns
    -------
    two floats, s, of the first sensor after the other; None if the lag does not surely change, or
    the drive is too short to tell
    """
    if len(w.recording) < 2 * FEWEST_PIECES * PIECE_S * w.rate_hz:
        return None
    early, late = (w.lag(other, name, half=half) for half in (0, 1))
    if early is None or late is None or min(early.correlation, late.correlation) < GO_TOGETHER:
        return None
    grows, sd = late.lag_s - early.lag_s, float(np.hypot(early.sd_s, late.sd_s))
    if abs(grows) <= max(LEAST_LAG_SAMPLES / w.rate_hz, SURE * float(np.hypot(sd, LEAST_LAG_SD_S))):
        return None
    return early.lag_s - grows / 2, late.lag_s + grows / 2


def _redrifted(recording: Recording, sensor: str, lags_s: tuple[float, float]) -> Recording:
    """Recording in which a sensor is read at times that run from one lag to another."""
    count, time_s = len(recording), recording.time_s
    at = time_s + np.linspace(*lags_s, count)
    for half in ("acc", "gyr"):
        values = half_of(recording, sensor, half)
        moved = np.column_stack([np.interp(at, time_s, axis) for axis in values.T])
        recording = with_half(recording, sensor, half, moved)
    return recording


def _times_after(
    first: str, lags: Mapping[tuple[str, str], Lag]
) -> tuple[dict[str, float], dict[str, float]]:
    """Lag of each sensor after a first one and its standard deviation, over others if need be."""
    times, sds = {first: 0.0}, {first: LEAST_LAG_SD_S}
    waiting = [first]
    while waiting:
        at = waiting.pop(0)
        for (one, other), lag in lags.items():
            for here, there, lag_s in ((one, other, lag.lag_s), (other, one, -lag.lag_s)):
                if here == at and there not in times:
                    times[there] = times[at] + lag_s
                    beside = LEAST_LAG_SD_S if at == first else sds[at]
                    sds[there] = float(np.hypot(lag.sd_s, beside))
                    waiting.append(there)
    return times, sds


def wrong_scales(w: SharedMotion) -> Iterator[Fault]:
    """A wheel's gyroscope that reads too much or too little, by the turns that gravity counts.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    wrong: dict[str, tuple[float, float]] = {}
    for side in w.sides:
        fit, name = w.spin_fits[side], f"{side}_wheel"
        if fit is None or fit.factor <= 0 or name in w.failed:
            continue
        error, sd = fit.scale(w.offset_sd(name, w.mount.rotation_imu_to_wheel(side)[2]))
        if abs(error) > max(LEAST_SCALE, SURE * sd):
            wrong[name] = error, sd
    if _alike(wrong) and not _frame_speaks_against_clock(w, wrong):
        yield _other_clock(w.recording, wrong)
        return
    for name, (error, sd) in wrong.items():
        way = "too much" if error > 0 else "too little"
        yield fault_of(
            w.recording, "scale", f"{name}_gyr", np.ones(len(w.recording), np.bool_),
            f"reads {100 * abs(error):.1f} ± {100 * sd:.1f} % {way}, by the turns of the wheel as "
            "gravity counts them; calibrate it, or check its range and unit",
            size=abs(error), unit="", repair=partial(
                multiplied, sensor=name, half="gyr", factors=1 / (1 + error)
            ),
        )  # fmt: skip


def _alike(wrong: dict[str, tuple[float, float]]) -> bool:
    """Whether both wheels' gyroscopes are off by one factor that no two gyroscopes share."""
    if len(wrong) < 2:
        return False
    (left, left_sd), (right, right_sd) = wrong.values()
    apart = max(CLOCK_SDS * float(np.hypot(left_sd, right_sd)), LEAST_SCALE)
    return abs(left - right) < apart and min(abs(left), abs(right)) > LEAST_CLOCK


def _frame_speaks_against_clock(w: SharedMotion, wrong: Mapping[str, tuple[float, float]]) -> bool:
    """Whether the frame's gyroscope fits the wheels' only once their scale is mended.

    Another clock leaves all gyroscopes alike: the frame then fits the wheels as they read.
    """
    if w.by_gravity is None or "frame" not in w.yaw:
        return False
    gain = gain_of(w.by_gravity, w.yaw["frame"], w.rate_hz)
    if gain is None or gain.correlation < GO_TOGETHER:
        return False
    error = float(np.mean([one[0] for one in wrong.values()]))
    return abs(gain.gain * (1 + error) - 1) < abs(gain.gain - 1)


def _other_clock(recording: Recording, wrong: dict[str, tuple[float, float]]) -> Fault:
    error = float(np.mean([one[0] for one in wrong.values()]))
    sd = float(np.linalg.norm([one[1] for one in wrong.values()]) / len(wrong))
    more, sampled = ("more", "faster") if error > 0 else ("less", "slower")
    return fault_of(
        recording, "clock", "time_s", np.ones(len(recording), np.bool_),
        f"makes the wheels turn by {100 * abs(error):.1f} ± {100 * sd:.1f} % "
        f"{more} than gravity counts, both alike: the sensors sampled {sampled} than the times say "
        "or both gyroscopes are in another unit; state the right sampling rate",
        size=abs(error), unit="", repair=partial(retimed, factor=1 / (1 + error)),
    )  # fmt: skip


def retimed(recording: Recording, factor: float) -> Recording:
    """Recording whose clock runs at another pace.

    Parameters
    ----------
    recording : Recording
    factor : on the time from sample to sample

    Returns
    -------
    Recording
    """
    start = recording.time_s[0]
    time_s = start + (recording.time_s - start) * factor
    return Recording(time_s, recording.sensors, source=recording.source)


def wrong_offsets(w: SharedMotion) -> Iterator[Fault]:
    """Offsets of the wheels' gyroscopes that no rest of the drive shows.

    With r_R Om_R - r_L Om_L = d * yaw + c * V + o, the constant o is what the wheels' offsets
    differ by; which of the two wheels it is, gravity tells. Offsets alike on both wheels are not
    seen: on a chair that rolls steadily they cannot be told from the scale factors.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    if len(w.sides) < 2 or all(f"{side}_wheel" in w.own_offsets for side in w.sides):
        return
    found = _apart(w)
    if found is None:
        return
    apart, sd = found
    radius = w.geometry.wheel_radius_m
    by_side = {"left": -apart / radius.left, "right": apart / radius.right}
    if abs(apart) <= max(LEAST_OFFSET_RADPS * min(radius), SURE * sd):
        return
    misfit = dict.fromkeys(w.sides, 0.0)
    for side, fit in w.spin_fits.items():
        if fit is None or fit.factor <= 0:
            continue
        offset, offset_sd = fit.offset(FACTORY_SCALE_SD)
        for blamed in w.sides:
            expected = by_side[side] if blamed == side else 0.0
            misfit[blamed] += ((offset - expected) / offset_sd) ** 2
    side = min(misfit, key=lambda one: misfit[one])
    axle, sd_radps = w.mount.rotation_imu_to_wheel(side)[2], sd / radius.of(side)
    name = f"{side}_wheel"
    yield offset_fault(w, name, axle, by_side[side], sd_radps, "the others")


def _apart(w: SharedMotion) -> tuple[float, float] | None:
    """Constant difference in m/s of the wheels' speeds that neither turn nor radii explain."""
    if w.by_gravity is None:
        return None
    left, right = (
        r * w.rates[f"{side}_wheel"][:, 2]
        for side, r in zip(w.sides, w.geometry.wheel_radius_m, strict=True)
    )
    # Gravity's yaw rate has no offset: what a wheel reads across its axle goes round.
    design = np.column_stack([w.by_gravity, (left + right) / 2, np.ones(len(left))])
    if np.linalg.cond(design / np.linalg.norm(design, axis=0)) > LARGEST_CONDITION:
        return None
    target = right - left
    used = np.ones(len(target), np.bool_)
    for _ in range(3):
        found = np.linalg.lstsq(design[used], target[used], rcond=None)[0]
        misfit = np.abs(target - design @ found)
        used = misfit <= max(4 * 1.48 * float(np.median(misfit)), 0.01)
    piece = pieces_of(len(target), PIECE_S, w.rate_hz)
    if len(np.unique(piece[used])) < FEWEST_PIECES:
        return None
    found, covariance = fit_by_pieces(design[used], target[used], piece[used])
    return float(found[2]), float(np.sqrt(covariance[2, 2]))


def offset_fault(
    w: SharedMotion,
    name: str,
    axis: FloatArray,
    offset_radps: float,
    sd_radps: float,
    by: str,
) -> Fault:
    """Fault of a gyroscope that reads a constant too much or too little, which is not taken off.

    Parameters
    ----------
    w : SharedMotion
    name : sensor
    axis : (3,) unit array, in the sensor's axes: a wheel's axle, positive forward, or up
    offset_radps, sd_radps : rad/s, along the axis, and its standard deviation
    by : what shows it

    Returns
    -------
    Fault
    """
    size = float(np.rad2deg(abs(offset_radps)))
    way = "too much" if offset_radps > 0 else "too little"
    about = "upward (turns to the left)" if name == "frame" else "forward about its axle"
    return fault_of(
        w.recording, "offset", f"{name}_gyr", np.ones(len(w.recording), np.bool_),
        f"reads {size:.2f} ± {np.rad2deg(sd_radps):.2f} deg/s {way} {about}, by {by}, "
        f"{_rest_shows(w, name)}",
        size=size, unit="deg/s", repair=_taken_off(name, offset_radps * axis),
    )  # fmt: skip


def _rest_shows(w: SharedMotion, name: str) -> str:
    """What the rests of a drive say of such an offset, and what to do."""
    if name in w.own_offsets:
        return "beyond what its rests show; check the sensor, or record again"
    if len(rests(w).get(name, ((), ()))[1]) < FEWEST_BLOCKS:
        return (
            "and no rest of the drive shows it; let the chair stand for some seconds at the "
            "beginning"
        )
    return (
        "and its rests show more than any sound sensor's offset, so that it is not taken off; "
        "check or change the sensor"
    )


def _taken_off(name: str, offset_radps: FloatArray) -> Repair:
    return partial(without_offset, sensor=name, offset_radps=offset_radps)
