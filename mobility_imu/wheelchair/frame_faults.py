"""Faults of the frame's sensor, and of names and signs, that the wheels' sensors show."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product

import numpy as np
from scipy import ndimage
from scipy.spatial.transform import Rotation

from mobility_imu.faults import Fault, exchanged, multiplied, turned_back
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.wheelchair.contradictions import (
    Gain,
    SharedMotion,
    gain_of,
    steady_direction,
    tilt_of,
)
from mobility_imu.wheelchair.lags import lag_between
from mobility_imu.wheelchair.recovery import replaced
from mobility_imu.wheelchair.slip import CHECK_SENSORS, detect_slip
from mobility_imu.wheelchair.slip import at_odds as disagreement
from mobility_imu.wheelchair.wheel_faults import (
    FEWEST_PIECES,
    LEAST_OFFSET_RADPS,
    PIECE_S,
    SURE,
    exchanged_wheels,
    offset_fault,
)

__all__ = ["at_odds", "other_signs", "taken_for_a_wheel", "tilted", "wrong_scale_or_offset"]

STEADY, GOES_ROUND = 0.9, 0.7
"""Gravity stays in the frame's axes to 0.96 on real drives, and goes round in a wheel's."""
SPINNING_RADPS = 1.0
"""A frame that turns faster than this for a second in all may be a wheel; chairs turn so, too."""
LARGEST_TILT_RAD = float(np.deg2rad(6.0))
"""Ramps rise by 1 in 12 at most (4.8 deg, ISO 21542); no drive leans by more on average."""
SIGN = 0.2
"""A gain beyond it has a sign for sure: no scale is so far off."""
LEAST_SCALE = 0.015
"""Scale factors of a calibrated sensor (0.3 to 0.5 %) to three standard deviations."""
FITS = 0.015
"""What the right signs may leave of the gain: as much as a scale error that is not told."""
LEAST_FLIP = 0.2
"""Smaller changes of the gain are scale errors rather than a wrong sign of an axis."""
ALIKE, APART = 0.95, 0.8
"""Correlations of yaw rates that agree, and of such that do not. Like :data:`SIGN` and
:data:`LEAST_FLIP`, set by hand on simulated courts that the study of faults does not use."""


def taken_for_a_wheel(w: SharedMotion) -> Iterator[Fault]:
    """A sensor called the frame's in whose axes gravity goes round.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    rate = w.rate_hz
    steady = {
        name: steady_direction(ndimage.uniform_filter1d(force, max(1, round(rate / 2)), axis=0))
        for name, force in w.forces.items()
    }
    spins = np.linalg.norm(w.rates["frame"], axis=1) > SPINNING_RADPS
    if "frame" in w.blind or steady["frame"] > GOES_ROUND or spins.sum() < rate:
        return
    others = [n for n in steady if n != "frame" and n not in w.blind and steady[n] > STEADY]
    whole = np.ones(len(w.recording), np.bool_)
    if len(others) != 1:
        yield fault_of(
            w.recording, "turned", "frame", whole,
            "turns over as a wheel does: no sensor sits on the frame; check the names",
        )  # fmt: skip
        return
    yield fault_of(
        w.recording, "exchanged", f"frame, {others[0]}", whole,
        "have each other's names: gravity goes round in the frame's axes and not in the wheel's; "
        "exchange the names", repair=partial(exchanged, first="frame", second=others[0]),
    )  # fmt: skip


def tilted(w: SharedMotion) -> Iterator[Fault]:
    """A frame whose up in the drive is not that of the static trial.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    found = None if "frame" in w.blind else tilt_of(w)
    if found is None or found[1] < GOES_ROUND:
        return
    up = found[0]
    angle = float(np.arccos(np.clip(up[2], -1.0, 1.0)))
    if angle <= LARGEST_TILT_RAD:
        return
    chair = w.mount.rotation_frame_imu_to_chair
    back = Rotation.align_vectors(np.array([[0.0, 0.0, 1.0]]), up[None])[0].as_matrix()
    yield fault_of(
        w.recording, "turned", "frame", np.ones(len(w.recording), np.bool_),
        f"leans by {np.rad2deg(angle):.0f} deg against the static trial, more than a ramp does: "
        "the sensor was turned in between, or the chair was tipped in one of the two; record the "
        "static trial anew", size=float(np.rad2deg(angle)), unit="deg",
        repair=partial(turned_back, sensor="frame", rotation=chair.T @ back @ chair),
    )  # fmt: skip


def other_signs(w: SharedMotion) -> Iterator[Fault]:
    """Names and signs, by three yaw rates: of the frame, of gravity, of the wheels' speeds.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    if "frame" in w.mute or w.by_gravity is None:
        return
    frame, whole = w.yaw["frame"], np.ones(len(w.recording), np.bool_)
    with_gravity = _sign(w.by_gravity, frame, w.rate_hz)
    speeds = w.by_speeds
    with_speeds = 0 if speeds is None else _sign(speeds, frame, w.rate_hz)
    if with_gravity > 0 and with_speeds < 0:
        yield exchanged_wheels(w)
    elif with_gravity < 0 and with_speeds > 0:
        yield fault_of(
            w.recording, "mirrored", "frame", whole,
            "and the wheels' speeds turn the other way than each wheel's own gravity shows: either "
            "the wheels' accelerometers read -1 g upward, or the frame's gyroscope has the wrong "
            "sign and left and right are exchanged, so that left turns are right ones; turn the "
            "chair to the left by hand and look",
        )  # fmt: skip
    signs = _fitting_signs(w)
    if signs is not None:
        bad = [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
        what = "the gyroscope" if len(bad) == 3 else f"axis {', '.join(bad)} of the gyroscope"
        yield fault_of(
            w.recording, "reversed", "frame_gyr", whole,
            f"turns the other way than {_wheels(w)}: {what} has the wrong sign; check the "
            "export's axes",
            repair=partial(multiplied, sensor="frame", half="gyr", factors=np.array(signs)),
        )  # fmt: skip


def _sign(first: FloatArray, second: FloatArray, rate_hz: float) -> int:
    """1 or -1 if two series surely go with or against each other, whatever the lag; else 0."""
    found = [
        0.0 if lag is None else lag.correlation
        for lag in (lag_between(first, sign * second, rate_hz) for sign in (1, -1))
    ]
    if max(found) == 0.0 or np.abs(first).sum() / rate_hz < np.pi:
        return 0
    return 1 if found[0] > found[1] else -1


def _fitting_signs(w: SharedMotion) -> tuple[float, ...] | None:
    """Signs of the frame's axes with which its yaw rate fits; None if the stated ones do."""
    assert w.by_gravity is not None
    stated = gain_of(w.by_gravity, w.yaw["frame"], w.rate_hz)
    if stated is None or abs(stated.gain - 1) < LEAST_FLIP:
        return None
    lag = lag_between(w.by_gravity, w.yaw["frame"], w.rate_hz)
    if lag is not None and round(lag.lag_s * w.rate_hz):
        return None
    speeds = w.by_speeds
    if speeds is not None and _sign(w.by_gravity, speeds, w.rate_hz) < 0:
        return None
    axis = w.mount.rotation_frame_imu_to_chair[2]
    gyr = w.at_rest.gyroscope("frame")
    best, least = None, FITS
    for signs in product((1.0, -1.0), repeat=3):
        gain = gain_of(w.by_gravity, gyr @ (axis * np.array(signs)), w.rate_hz)
        if gain is not None and gain.correlation > ALIKE and abs(gain.gain - 1) < least:
            best, least = signs, abs(gain.gain - 1)
    return best if best is not None and min(best) < 0 else None


def wrong_scale_or_offset(w: SharedMotion) -> Iterator[Fault]:
    """A frame's gyroscope that reads too much, or a constant that no rest shows.

    The scale is known by the camber from the wheels' own yaw rates, and by the track from their
    speeds; both have to agree. What they leave open, 1 deg of camber and 1 cm of track, limits it.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    if "frame" in w.mute or w.by_gravity is None:
        return
    gain = _against_wheels(w)
    if gain is None or gain.correlation < ALIKE or gain.gain < SIGN:
        return
    whole = np.ones(len(w.recording), np.bool_)
    error, sd = _scale(w, gain)
    if abs(error) > max(LEAST_SCALE, 3 * sd):
        way = "too much" if error > 0 else "too little"
        yield fault_of(
            w.recording, "scale", "frame_gyr", whole,
            f"reads {100 * abs(error):.1f} ± {100 * sd:.1f} % {way} against {_wheels(w)}; "
            "calibrate it, or check its range and unit", size=abs(error),
            repair=partial(multiplied, sensor="frame", half="gyr", factors=1 / (1 + error)),
        )  # fmt: skip
    offset, offset_sd = gain.constant_radps, gain.constant_sd_radps
    long = len(w.recording) >= FEWEST_PIECES * PIECE_S * w.rate_hz
    if (
        long
        and "frame" not in w.own_offsets
        and abs(offset) > max(LEAST_OFFSET_RADPS, SURE * offset_sd)
    ):
        up = w.mount.rotation_frame_imu_to_chair[2]
        yield offset_fault(w, "frame", up, offset, offset_sd, _wheels(w))


def _wheels(w: SharedMotion) -> str:
    """Wheels that others are judged by, for a sentence."""
    return "both wheels" if len(w.sides) == 2 else f"the {w.sides[0]} wheel"


def _against_wheels(w: SharedMotion) -> Gain | None:
    """Gain and constant of the frame's yaw rate; what the two wheels differ by counts as error."""
    found = [gain_of(w.yaw[f"{side}_wheel"], w.yaw["frame"], w.rate_hz) for side in w.sides]
    known = [gain for gain in found if gain is not None]
    if len(known) < len(found):
        return None
    gains, constants = ([getattr(g, n) for g in known] for n in ("gain", "constant_radps"))
    return Gain(
        float(np.mean(gains)),
        float(np.hypot(max(g.gain_sd for g in known), np.ptp(gains) / 2)),
        float(np.mean(constants)),
        float(np.hypot(max(g.constant_sd_radps for g in known), np.ptp(constants) / 2)),
        min(g.correlation for g in known),
    )


def _scale(w: SharedMotion, by_gravity: Gain) -> tuple[float, float]:
    """Scale error of the frame's gyroscope and its standard deviation.

    Gravity in the wheels knows it but for the camber, their speeds but for the track: the mean of
    both by their variances, to which the scale that sound gyroscopes differ by is added.
    """
    errors, camber = w.errors, w.geometry.camber_rad
    error, variance = (
        by_gravity.gain - 1,
        (
            by_gravity.gain_sd**2
            + (np.tan(camber) * errors.camber_sd_rad) ** 2
            + errors.scale_sd**2 / (2 * len(w.sides))
        ),
    )
    speeds = w.by_speeds
    # What slips stands on the left: far off, it would turn the line.
    other = None if speeds is None else gain_of(w.yaw["frame"], speeds, w.rate_hz)
    if other is not None and other.correlation > ALIKE:
        track = errors.track_sd_m / w.geometry.wheel_centre_distance_m
        wheels = float(np.hypot(track, errors.radius_sd))
        if abs(1 / other.gain - by_gravity.gain) / by_gravity.gain > 3 * wheels:
            # Camber or track is wrong, which is another question.
            return 0.0, float(np.sqrt(variance + errors.scale_sd**2))
        weight = variance / (variance + wheels**2 + errors.scale_sd**2 + other.gain_sd**2)
        error += weight * (1 / other.gain - 1 - error)
        variance *= 1 - weight
    return float(error), float(np.sqrt(variance + errors.scale_sd**2))


def at_odds(w: SharedMotion) -> Iterator[Fault]:
    """Wheels and frame that disagree for longer than any wheel slips.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    speeds = w.by_speeds
    if speeds is None or "frame" in w.mute or w.by_gravity is None:
        return
    frame = w.yaw["frame"]
    if _sign(speeds, frame, w.rate_hz) < 0:
        return  # names or signs, which were told
    failed = np.zeros(len(frame), np.bool_)
    for flags in w.failed.values():
        failed |= flags
    rules = w.settings.slip
    windows = detect_slip(frame, np.where(failed, frame, speeds), w.rate_hz, rules)
    slip = windows.flags(len(frame))
    told = disagreement(slip, np.where(failed, frame, speeds), frame, rules, w.recording.source)
    if not told:
        return
    sentence = told[0]
    own, other = (_alike(w.by_gravity, series) for series in (frame, speeds))
    sensor, repair = "frame, left_wheel, right_wheel", None
    if own < APART and other > ALIKE:
        sensor = "frame_gyr"
        sentence += "; both wheels' own gravity speaks against the frame's gyroscope"
        repair = partial(
            replaced,
            sensor="frame",
            flags=slip,
            others={n: f for n, f in w.failed.items() if n != "frame"},
            geometry=w.geometry,
            mount=w.mount,
            otherwise=None,
        )
    elif own > ALIKE and other < APART:
        sentence += "; each wheel's own gravity speaks for the frame, so a wheel's spin is wrong"
    elif own > ALIKE and other > ALIKE:
        sentence = sentence.removesuffix(CHECK_SENSORS) + (
            "all go together but for a factor; are track, radii and camber right? Run "
            "`mobility-imu wheelchair check`"
        )
    else:
        sentence += "; what the result is wrong by is not known"
    first = float(w.recording.time_s[int(np.argmax(slip))])
    yield Fault("at odds", sensor, first, slip, sentence, repair=repair)


def _alike(first: FloatArray, second: FloatArray) -> float:
    if not first.any() or not second.any():
        return 0.0
    return float(np.corrcoef(first, second)[0, 1])
