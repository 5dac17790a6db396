"""Is the geometry right? The frame's gyroscope knows the turns; the wheels must agree.

With the no-slip speeds of the wheel centres, r_R Om_R - r_L Om_L = d_c * yaw + c * V + o. A
least-squares fit gives the distance d_c that the data have, with c the mismatch of the radii, and
with o what is left of the gyroscopes' offsets, which are found at rest and taken off; the rate
across the axle gives the camber, whatever the distances are. A gyroscope that reads 1 % too much
cannot be told from a radius or a distance that is 1 % off: the standard deviations hold that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.faults import Fault
from mobility_imu.fields import check_fields
from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray, as_number
from mobility_imu.offsets import (
    GyroscopeOffset,
    merge_offsets,
    rest_offsets,
    without_offsets,
)
from mobility_imu.quality import LARGEST_OFFSET_RADPS
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.wheelchair.faults import SMALL, sensor_faults
from mobility_imu.wheelchair.fits import fit_by_pieces, pieces_of
from mobility_imu.wheelchair.geometry import SIDES, WheelchairGeometry
from mobility_imu.wheelchair.lags import lag_between
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.rest_faults import offsets_not_told
from mobility_imu.wheelchair.saturation import (
    saturated_gyroscopes,
    saturation_warnings,
    usable_samples,
)
from mobility_imu.wheelchair.series import as_offsets

__all__ = ["GeometryCheck", "check_geometry"]

SLOWEST_TURN_RADPS = 0.3
SHORTEST_TURNING_S = 1.0
"""Shortest time of turns to one side that gives a factor for this side."""
STEADY_S = 1.0
"""Over a second the wobble of pushes averages out; what is left is turning."""
LEAST_TURNED_RAD = 2 * np.pi
"""A whole turn: on rough ground a straight drive of half a minute turns by half of one."""
# Two wheels against each other; with it the radii are taken as given, as a tape gives them.
RADIUS_RATIO_SD = 0.005 * float(np.sqrt(2))
# What a tape can do: a centimetre of track, a degree of camber, half a percent of radius.
TRACK_TOLERANCE_M = 0.01
CAMBER_TOLERANCE_RAD = float(np.deg2rad(2.0))
RADIUS_TOLERANCE = 0.005
LARGEST_MISMATCH = 0.2
"""No two wheels of a pair differ by more in radius."""
GYROSCOPE_SCALE_SD = 0.01
"""Assumed error of a gyroscope's scale factor as it leaves the factory.

The data sheet of the MPU-6050 (PS-MPU-6000A-00, 6.1) allows 3 %, taken as three standard
deviations."""
GYROSCOPE_AXIS_SD_RAD = 0.02 / 3
"""Assumed lean of its axes toward each other, from the 2 % cross-axis sensitivity of that sheet."""
BLOCK_S = 1.0
"""Residuals last about a push; those of one block are taken together."""
LEAST_ROLLED = 0.05
"""Way that does not go with turning, as a fraction of the wheels' way, from which on the radii
show. On the spot scale and time of the gyroscopes leave under a hundredth of a mean speed, and what
goes with it is theirs."""
# Below this, track, mismatch of the radii and offset cannot be told apart.
SMALLEST_INDEPENDENT_PART = 1e-6
UNJUDGED = frozenset(
    {"frozen", "dead axis", "copy", "exchanged", "turned", "reversed", "at odds", "clock", "unit"}
)
"""Codes of faults with which turns and wheels say nothing of the geometry, whatever their size. In
a drive that is mirrored they do: track, radii and camber are the same to the left and the right."""
UNJUDGED_BEYOND = MappingProxyType(
    {
        "lag": SMALL["lag"],
        "scale": SMALL["scale"],
        "offset": float(np.rad2deg(LARGEST_OFFSET_RADPS)),
    }
)
"""The same of faults beyond a size, in s, as a fraction and in deg/s. Turns begin within half a
second: a lag of a tenth of that changes gains by half a percent. A constant is fitted with the
track, so that an offset moves neither track nor radii unless it changes within the drive; beyond
what a gyroscope can have, a rest is taken for a turn."""
ALIKE = 0.95
"""Correlation from which on wheels and frame go together: their factor is the geometry's."""
NO_VERDICT_WHY = "a sensor failed, so there is no verdict on track, radii and camber"
NO_VERDICT = MappingProxyType(
    {"judged": False, "fits": False}
    | dict.fromkeys(
        (
            "yaw_gain_left",
            "yaw_gain_right",
            "track_m",
            "track_sd_m",
            "radius_ratio",
            "radius_ratio_sd",
            "camber_rad",
            "camber_sd_rad",
        ),
        float("nan"),
    )
)
"""What is stated of track, radii and camber where a drive turns too little."""


@dataclass(frozen=True, eq=False, repr=False)
class GeometryCheck(Result):
    """What a drive says of the geometry it is analysed with.

    Parameters
    ----------
    residual_radps : rad/s, root mean square of the wheels' yaw rate less the frame's
    correlation : of the two yaw rates; NaN if one of them does not change. Here and in what
        follows samples are left out in which a gyroscope is at the end of its range
    gain : factor on the frame's yaw rate that fits the wheels' best
    lag_s : s by which the wheels come after the frame; NaN if the two yaw rates do not go together
    turned_rad : rad turned in all, to either side, while turning faster than 0.3 rad/s
    judged : False if the drive turns too little to judge the geometry, or a sensor is at fault;
        what follows is then NaN
    fits : True if it is judged and nothing is wrong with track, radii and camber
    yaw_gain_left, yaw_gain_right : wheels' yaw rate over the frame's, in left and in right turns;
        1 is right; NaN without enough of such turns
    track_m, track_sd_m : track that fits the turns, with the camber as given and the radii as
        given to 0.5 % each
    radius_ratio, radius_ratio_sd : factor on right over left radius that fits (1: as given); NaN
        where the chair turns on the spot only
    camber_rad, camber_sd_rad : camber from the rate across the axles
    geometry : WheelchairGeometry that was checked
    offsets : sensor to GyroscopeOffset that was taken off
    warnings : sentences on what is wrong and by how much, on what cannot be judged, and on offsets
        that are large or unknown
    """

    residual_radps: float
    correlation: float
    gain: float
    lag_s: float
    turned_rad: float
    judged: bool
    fits: bool
    yaw_gain_left: float
    yaw_gain_right: float
    track_m: float
    track_sd_m: float
    radius_ratio: float
    radius_ratio_sd: float
    camber_rad: float
    camber_sd_rad: float
    geometry: WheelchairGeometry
    offsets: dict[str, GyroscopeOffset] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check every field."""
        kinds = {"judged": bool, "fits": bool, "geometry": WheelchairGeometry}
        others = {each.name for each in fields(self)} - {*kinds, "offsets", "warnings"}
        check_fields(self, **dict.fromkeys(others, float), **kinds)
        object.__setattr__(self, "offsets", as_offsets(self.offsets))
        super().__post_init__()


def check_geometry(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    *,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
    gyr_scale_sd: float = GYROSCOPE_SCALE_SD,
    gyr_axis_sd_rad: float = GYROSCOPE_AXIS_SD_RAD,
) -> GeometryCheck:
    """Compare the wheels with the frame over a drive with turns.

    The absolute size of the radii cannot be checked this way: only a known distance shows it. The
    standard deviations hold the scatter of the residuals, and scale factors and axes of the
    gyroscopes that are known to ``gyr_scale_sd`` and ``gyr_axis_sd_rad``: a drive cannot show
    them. With the defaults radii that differ by less than about 4 % from what is given are not
    reported; with 0.003, of a sensor that its maker calibrated, less than about 1.3 %. A drive that
    turns by less than a whole turn in all, or whose scatter tells the track less well than a tape,
    judges nothing, and says so.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel
    geometry : WheelchairGeometry to be checked
    mount : WheelchairMount, from
        :func:`~mobility_imu.wheelchair.calibration.calibrate_mount`
    offsets : sensor to GyroscopeOffset of other recordings of that day, such as
        ``calibration.offsets``; offsets are found at rest and taken off in any case
    gyr_scale_sd : fraction, standard deviation of each gyroscope's scale factors; the default is
        of a sensor as it leaves the factory, makers that calibrate theirs state 0.003 to 0.005
    gyr_axis_sd_rad : rad, of the lean of its axes toward each other

    Returns
    -------
    GeometryCheck

    Raises
    ------
    InputError
        If a sensor is missing in the recording or in the mount, or the wheels' speed goes with the
        yaw rate throughout although the chair turns.
    """
    expect("recording", recording, Recording)
    expect("geometry", geometry, WheelchairGeometry)
    expect("mount", mount, WheelchairMount)
    gyroscopes = _Gyroscopes(
        _at_most_1(gyr_scale_sd, "gyr_scale_sd"), _at_most_1(gyr_axis_sd_rad, "gyr_axis_sd_rad")
    )
    names = ("frame", *(f"{side}_wheel" for side in SIDES))
    merged = merge_offsets(rest_offsets(recording, names), as_offsets(offsets))
    found = {name: merged[name] for name in names if name in merged}
    saturated = saturated_gyroscopes(recording, names)
    faults = sensor_faults(recording, geometry, mount, offsets=offsets)
    warnings = (
        *offsets_not_told(recording, found, names, faults),
        *saturation_warnings(recording, saturated),
    )
    cut = {f.sensor: f.flags for f in faults if f.code == "range" and f.sensor.endswith("_gyr")}
    usable = usable_samples(len(recording), {**saturated, **cut})
    recording = without_offsets(recording, found)
    yaw = mount.frame(recording.gyroscope("frame"))[:, 2]
    wheels = [mount.wheel(side, recording.gyroscope(f"{side}_wheel")) for side in SIDES]
    left, right = (
        radius * rate[:, 2] for radius, rate in zip(geometry.wheel_radius_m, wheels, strict=True)
    )
    agreement = _agreement(
        yaw, (right - left) / geometry.wheel_centre_distance_m, recording.sampling_rate_hz, usable
    )
    parts = _Parts(
        recording, yaw, wheels[0], wheels[1], (left + right) / 2, right - left, usable, gyroscopes
    )
    together = _go_together(parts)
    faulty = [f.sentence for f in faults if _spoils(f, agreement["turned_rad"], together)]
    if faulty:
        verdict: dict[str, Any] = {"warnings": (NO_VERDICT_WHY, *faulty)}
    else:
        verdict = _verdict(parts, geometry, mount, found, agreement)
        warnings = (*(f.sentence for f in faults if f.code == "mirrored"), *warnings)
    return GeometryCheck(
        **agreement,
        **{**NO_VERDICT, **verdict, "warnings": (*verdict["warnings"], *warnings)},
        geometry=geometry,
        offsets=found,
    )


def _at_most_1(value: float, name: str) -> float:
    number = as_number(value, name, zero=True)
    if number > 1:
        hint = " (in percent?)" if name == "gyr_scale_sd" else " (in deg?)"
        raise InputError(f"{name} = {number:g}: expected 0 to 1{hint}")
    return number


def _spoils(fault: Fault, turned_rad: float, together: bool) -> bool:
    """Whether the geometry, which a drive with turns would show, cannot be judged with a fault."""
    if fault.code == "lag" and turned_rad < LEAST_TURNED_RAD:
        return False
    if fault.code == "at odds" and together:
        return False  # the geometry that was given is wrong, which is what is asked
    if fault.changes:
        return True  # one constant is fitted, which is wrong in a part of the drive
    if fault.code in UNJUDGED_BEYOND:
        return fault.size > UNJUDGED_BEYOND[fault.code]
    return fault.code in UNJUDGED and "_acc" not in fault.sensor


def _go_together(parts: _Parts) -> bool:
    """Whether the wheels follow the frame's yaw rate, whatever track and radii are."""
    rest = np.column_stack([parts.speed, np.ones(len(parts.speed))])[parts.usable]
    pair = np.column_stack([parts.yaw, parts.apart])[parts.usable]
    left = pair - rest @ np.linalg.lstsq(rest, pair, rcond=None)[0]
    size = float(np.linalg.norm(left[:, 0]) * np.linalg.norm(left[:, 1]))
    return size > 0 and float(left[:, 0] @ left[:, 1]) > ALIKE * size


class _Gyroscopes(NamedTuple):
    """Standard deviations of the scale factors (fraction) and of the axes' lean, rad."""

    scale_sd: float
    axis_sd_rad: float

    def gain_sd(self, axis_imu: FloatArray) -> float:
        """Relative uncertainty of the rate about an axis, from those of the scale and the axes."""
        share = np.outer(axis_imu, axis_imu) ** 2
        on_axes = float(np.trace(share))
        across = max(float(share.sum()) - on_axes, 0.0)
        return float(np.hypot(self.scale_sd * np.sqrt(on_axes), self.axis_sd_rad * np.sqrt(across)))


class _Distances(NamedTuple):
    """What the fit says of wheel centres and radii, with standard deviations.

    ``told_sd_m`` is that of the distance if the gyroscopes had no errors: the drive's own scatter.
    """

    distance_m: float
    distance_sd_m: float
    mismatch: float
    mismatch_sd: float
    told_sd_m: float


class _Parts(NamedTuple):
    """Yaw rate, rates of both wheels in their frames, their mean speed and its difference.

    Samples with a gyroscope at the end of its range are not usable.
    """

    recording: Recording
    yaw: FloatArray
    left: FloatArray
    right: FloatArray
    speed: FloatArray
    apart: FloatArray
    usable: NDArray[np.bool_]
    gyroscopes: _Gyroscopes


def _agreement(
    yaw: FloatArray, wheels: FloatArray, fs: float, usable: NDArray[np.bool_]
) -> dict[str, Any]:
    """Fields of GeometryCheck that compare the two yaw rates, with no geometry fitted."""
    steady = ndimage.uniform_filter1d(yaw, max(1, round(STEADY_S * fs)))[usable]
    steady = steady[np.abs(steady) > SLOWEST_TURN_RADPS]
    lag = lag_between(yaw * usable, wheels * usable, fs)
    yaw, wheels = yaw[usable], wheels[usable]
    moves = len(yaw) > 0 and yaw.std() > 0 and wheels.std() > 0
    return {
        "residual_radps": rms(wheels - yaw) if len(yaw) else float("nan"),
        "correlation": float(np.corrcoef(yaw, wheels)[0, 1]) if moves else float("nan"),
        "gain": float(wheels @ yaw / (yaw @ yaw)) if yaw.any() else float("nan"),
        "lag_s": float("nan") if lag is None else lag.lag_s,
        "turned_rad": float(np.abs(steady).sum() / fs),
    }


def _verdict(
    parts: _Parts,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    offsets: Mapping[str, GyroscopeOffset],
    agreement: Mapping[str, float],
) -> dict[str, Any]:
    """Fields of GeometryCheck on track, radii and camber; only a sentence without enough turns."""
    turning = parts.usable & (np.abs(parts.yaw) > SLOWEST_TURN_RADPS)
    if agreement["turned_rad"] < LEAST_TURNED_RAD:
        turned = np.rad2deg(agreement["turned_rad"])
        sentences = [
            f"turns too little to judge the geometry: {turned:.0f} deg in all faster than "
            f"{SLOWEST_TURN_RADPS} rad/s, expected a whole turn or more"
        ]
        if agreement["correlation"] < -0.5:
            sentences.append(_swapped(agreement["gain"]))
        return {"warnings": tuple(sentences)}
    fitted = _distances(parts, geometry, mount, offsets, turning)
    distance, distance_sd, mismatch, mismatch_sd, told_sd = fitted
    if told_sd > TRACK_TOLERANCE_M and distance > 3 * distance_sd:
        return {"warnings": (_scattered(agreement["turned_rad"], told_sd),)}
    gains = [
        float((parts.apart - np.nan_to_num(mismatch) * parts.speed)[way] @ parts.yaw[way])
        / float(parts.yaw[way] @ parts.yaw[way])
        / geometry.wheel_centre_distance_m
        if way.sum() >= SHORTEST_TURNING_S * parts.recording.sampling_rate_hz
        else float("nan")
        for way in (turning & (parts.yaw > 0), turning & (parts.yaw < 0))
    ]
    camber, camber_sd = _camber(
        parts.left,
        parts.right,
        parts.yaw,
        turning,
        parts.gyroscopes.gain_sd(mount.rotation_frame_imu_to_chair[2]),
        parts.gyroscopes.scale_sd,
    )
    sentences = [
        *_on_distances(geometry, fitted),
        *_on_camber(geometry, camber, camber_sd),
    ]
    return {
        "judged": True,
        "fits": not sentences,
        "yaw_gain_left": gains[0],
        "yaw_gain_right": gains[1],
        "track_m": distance + geometry.track_m - geometry.wheel_centre_distance_m,
        "track_sd_m": distance_sd,
        # A radius mismatch e adds e times the speed; the ratio that fits is 1 - e (first order).
        "radius_ratio": 1 - mismatch,
        "radius_ratio_sd": mismatch_sd,
        "camber_rad": camber,
        "camber_sd_rad": camber_sd,
        "warnings": tuple(sentences),
    }


def _scattered(turned_rad: float, told_sd_m: float) -> str:
    return (
        "wheels and frame disagree too much to judge the geometry: in "
        f"{np.rad2deg(turned_rad):.0f} deg of turns, the track could be told to {told_sd_m:.3f} m "
        f"only, expected {TRACK_TOLERANCE_M} m; look for slip, and for a loose or late sensor"
    )


def _distances(
    parts: _Parts,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    offsets: Mapping[str, GyroscopeOffset],
    turning: NDArray[np.bool_],
) -> _Distances:
    """Distance of the wheel centres and mismatch of the radii."""
    recording, yaw, speed = parts.recording, parts.yaw, parts.speed
    moving = turning | (parts.usable & (np.abs(speed) > 0.2))
    design = np.column_stack([yaw, speed, np.ones(len(yaw))])[moving]
    sizes = np.linalg.svd(design, compute_uv=False)
    if sizes[2] <= SMALLEST_INDEPENDENT_PART * sizes[0]:
        raise InputError(
            f"{recording.source}: the wheels' speed is constant or proportional to the yaw rate "
            "throughout, expected turns and straight lines; do both wheel sensors work?"
        )
    block = pieces_of(len(yaw), BLOCK_S, recording.sampling_rate_hz)[moving]
    rolls = _rolled(design, parts.apart[moving]) >= LEAST_ROLLED
    if rolls:
        found, covariance = fit_by_pieces(design, parts.apart[moving], block)
    else:  # the radii are as given, to what a tape can do
        found, covariance = np.zeros(3), np.zeros((3, 3))
        others = np.ix_([0, 2], [0, 2])
        found[[0, 2]], covariance[others] = fit_by_pieces(
            design[:, [0, 2]], parts.apart[moving], block
        )
    axes = {
        "frame": -geometry.wheel_centre_distance_m * mount.rotation_frame_imu_to_chair[2],
        **{
            f"{side}_wheel": radius * mount.rotation_imu_to_wheel(side)[2]
            for side, radius in zip(SIDES, geometry.wheel_radius_m, strict=True)
        },
    }
    if all(name in offsets for name in axes):
        left_over = [offsets[name].sd_along(axis) for name, axis in axes.items()]
        found, covariance = _known(found, covariance, 2, float(np.hypot.reduce(left_over)))
    gain_sd = parts.gyroscopes.gain_sd
    left, right = (gain_sd(mount.rotation_imu_to_wheel(side)[2]) for side in SIDES)
    # Gains g of the wheels change the difference of their speeds by (g_R - g_L) V, and by
    # (g_R + g_L) / 2 of what the turn makes of it.
    by_wheels = np.hypot(left, right)
    by_turn = np.hypot(by_wheels / 2, gain_sd(mount.rotation_frame_imu_to_chair[2]))
    mismatch, mismatch_sd = found[1], np.hypot(np.sqrt(covariance[1, 1]), by_wheels)
    if not rolls:
        mismatch, mismatch_sd = np.nan, np.nan
    _, told = _known(found, covariance, 1, RADIUS_RATIO_SD)
    found, covariance = _known(found, covariance, 1, float(np.hypot(RADIUS_RATIO_SD, by_wheels)))
    distance_sd = np.hypot(np.sqrt(covariance[0, 0]), found[0] * by_turn)
    return _Distances(
        float(found[0]),
        float(distance_sd),
        float(mismatch),
        float(mismatch_sd),
        float(np.sqrt(told[0, 0])),
    )


def _rolled(design: FloatArray, apart: FloatArray) -> float:
    """Way that does not go with the yaw rate, over the wheels' way.

    The design has yaw rate, speed and ones.
    """
    yaw, speed = design[:, 0], design[:, 1]
    left = speed - (yaw @ speed) / (yaw @ yaw) * yaw
    return float(np.abs(left).sum() / np.maximum(np.abs(speed), np.abs(apart) / 2).sum())


def _known(
    found: FloatArray, covariance: FloatArray, place: int, sd: float
) -> tuple[FloatArray, FloatArray]:
    """Fit and covariance when one of the unknowns is known to be zero to a standard deviation.

    Where the fit contradicts what is known, the model lacks something: the covariance is multiplied
    by the square of the contradiction in standard deviations (Birge's ratio).
    """
    variance = covariance[place, place] + sd**2
    gain = covariance[:, place] / variance
    contradiction = max(1.0, float(found[place] ** 2 / variance))
    return (
        np.asarray(found - gain * found[place]),
        np.asarray(covariance - np.outer(gain, covariance[place])) * contradiction,
    )


def _on_distances(geometry: WheelchairGeometry, fitted: _Distances) -> list[str]:
    """Sentences on track and radii that do not fit, or on swapped sensors."""
    distance, distance_sd, mismatch, mismatch_sd, _ = fitted
    if distance < -max(TRACK_TOLERANCE_M, 3 * distance_sd):
        gain = distance / geometry.wheel_centre_distance_m
        return [_swapped(gain)]
    sentences = []
    track = distance + geometry.track_m - geometry.wheel_centre_distance_m
    off = track - geometry.track_m
    if abs(off) > max(TRACK_TOLERANCE_M, 3 * distance_sd):
        # Radii scale both the speed difference and the lean.
        resized = geometry.track_m / track - 1
        sentences.append(
            f"the turns fit a track of {track:.3f} m, not {geometry.track_m:.3f} m "
            f"({off:+.3f} m); or both radii should be {resized:+.1%} of what is given, or the "
            "camber is off"
        )
    if abs(mismatch) > max(LARGEST_MISMATCH, 3 * mismatch_sd):
        sentences.append(
            f"driving straight, the wheels' speeds differ by {abs(mismatch):.0%}, more than radii "
            "can explain: has a wheel's sensor failed, or did a wheel slip throughout?"
        )
    elif abs(mismatch) > max(RADIUS_TOLERANCE, 3 * mismatch_sd):
        sentences.append(
            "driving straight, the wheels differ: the right radius over the left one should be "
            f"{1 - mismatch:.4f} times what is given; or the scale factors of the wheels' "
            "gyroscopes differ by as much"
        )
    return sentences


def _swapped(gain: float) -> str:
    return (
        f"the wheels turn against the frame (gain {gain:.2f}): left and right wheel sensor are "
        "swapped, or the frame's sensor is upside down, or the straight-line trial was driven "
        "backward"
    )


def _on_camber(geometry: WheelchairGeometry, camber: float, camber_sd: float) -> list[str]:
    """Sentence on a camber that does not fit."""
    off = abs(camber - geometry.camber_rad)
    if not np.isfinite(camber) or off <= max(CAMBER_TOLERANCE_RAD, 3 * camber_sd):
        return []
    return [
        f"the rates across the axles fit a camber of {np.rad2deg(camber):.1f} deg, not "
        f"{np.rad2deg(geometry.camber_rad):.1f} deg"
    ]


def _camber(
    left: FloatArray,
    right: FloatArray,
    yaw: FloatArray,
    turning: NDArray[np.bool_],
    yaw_gain_sd: float,
    scale_sd: float,
) -> tuple[float, float]:
    """Camber from cos(camber) = rate across the axle / yaw rate, both wheels.

    A cosine is flat at zero: small cambers have a large standard deviation.
    """
    cosines = [
        float(
            np.hypot(w[turning, 0], w[turning, 1])
            @ np.abs(yaw[turning])
            / (yaw[turning] @ yaw[turning])
        )
        for w in (left, right)
    ]
    # The wheels differ by what their gyroscopes read; the frame's errs for both alike. A wheel's
    # two axes across the axle take turns, so that their scale factors are averaged.
    by_wheels = max(abs(cosines[0] - cosines[1]) / 2, scale_sd / 2)
    spread = float(np.hypot(by_wheels, yaw_gain_sd))
    cosine = min(float(np.mean(cosines)), 1.0)
    camber = float(np.arccos(cosine))
    return camber, float(spread / max(np.sin(camber), np.sqrt(2 * spread)))
