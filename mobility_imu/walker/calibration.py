"""How the IMU is fixed to the walking frame, from tilting the frame about its edges.

Standing on level ground, the frame is tilted to the front, back, right and left by 20 to 45 deg
and set down again each time. While it tilts, the IMU runs along an arc about an edge; the arc's
plane says how the IMU is turned, its radius how far from that edge it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_number, one_of
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.walker.arc_fit import ArcFit, arm_noise, fit_arc
from mobility_imu.walker.follow import as_sentences, followed, navigate_recording
from mobility_imu.walker.footprint import (
    ACROSS,
    FOOTPRINT_WORDS,
    footprint_by_arcs,
    footprint_warnings,
)
from mobility_imu.walker.geometry import (
    TILT_DIRECTIONS,
    Edge,
    TiltDirection,
    WalkerGeometry,
)
from mobility_imu.walker.mount import REACH_M, WalkerMount
from mobility_imu.walker.navigation import Navigation, NavigationSettings
from mobility_imu.walker.sensor_errors import (
    SCALES_OF_ACC,
    check_deviations,
    off_scale,
    scale_at_rest,
    wrong_readings,
)
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.tilt_detection import Tilt, check_order, find_tilts
from mobility_imu.walker.tilt_ends import arms_by_velocity, distances_by_ends, rotation_by_ends
from mobility_imu.walker.tilt_equations import (
    Form,
    position_four_tilts,
    position_gain,
    position_two_tilts,
)

__all__ = [
    "Method",
    "WalkerCalibration",
    "calibrate_from_path",
    "calibrate_mount",
    "check_choices",
    "with_sensor_errors",
]

Method = Literal["four-tilts", "two-tilts", "all-samples"]
_VELOCITY_TILT_RAD = float(np.deg2rad(3))


@dataclass(frozen=True, eq=False, repr=False)
class WalkerCalibration(Result):
    """A mount with its uncertainty, and what it was found with.

    Parameters
    ----------
    mount : WalkerMount
    translation_sd_m : (3,) array, m; NaN for the paper's methods, which have none
    rotation_sd_rad : (3,) array, rad, about the body's axes; NaN likewise
    footprint_m : width and length of the footprint as the arcs have it, NaN where not seen
    tilts : the tilts that were used
    warnings : what the user should know
    geometry, method, form, settings, stillness : what it was found with
    """

    mount: WalkerMount
    translation_sd_m: FloatArray
    rotation_sd_rad: FloatArray
    footprint_m: tuple[float, float]
    tilts: tuple[Tilt, ...]
    warnings: tuple[str, ...] = ()
    geometry: WalkerGeometry = field(kw_only=True)
    method: Method = field(kw_only=True)
    form: Form = field(kw_only=True)
    settings: NavigationSettings = field(default_factory=NavigationSettings, kw_only=True)
    stillness: StillnessSettings = field(default_factory=StillnessSettings, kw_only=True)

    def __post_init__(self) -> None:
        """Check every field."""
        check_choices(self.geometry, self.method, self.form, TILT_DIRECTIONS)
        check_fields(self, mount=WalkerMount, tilts=[Tilt], footprint_m=[float, 2])
        check_fields(self, translation_sd_m=(3,), rotation_sd_rad=(3,))
        check_fields(self, settings=NavigationSettings, stillness=StillnessSettings)
        super().__post_init__()

    def to_toml(self, path: str | Path | None = None) -> str:
        """Geometry and mount as the text of a geometry file, with a comment on the tilts.

        Parameters
        ----------
        path : file to write the text to; None writes none

        Returns
        -------
        str
        """
        tilts = ", ".join(f"{t.direction} {np.rad2deg(t.angle_rad):.0f} deg" for t in self.tilts)
        return self.mount.to_toml(path, geometry=self.geometry, comment=f"{self.method}: {tilts}")


def calibrate_mount(
    recording: Recording,
    geometry: WalkerGeometry,
    *,
    method: Method = "all-samples",
    form: Form = "corrected",
    smooth: bool = True,
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    velocity_tilt_rad: float = _VELOCITY_TILT_RAD,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
) -> WalkerCalibration:
    """Rotation and position of the IMU on the frame, from a recording of tilts.

    Parameters
    ----------
    recording : Recording with a sensor "frame"; it begins at rest
    geometry : WalkerGeometry
    method : "four-tilts" (eqs 3-15), "two-tilts" (eqs 3-13, 16-19, from the backward and the
        rightward tilt), or "all-samples" (axes fitted to the whole arcs; any tilts of both pairs)
    form : "corrected", or "printed": the roots of eq. 15, no tilt angle in eqs 16-17
    smooth : whether to smooth the path; the paper filters only
    order : directions of the tilts as they were made
    velocity_tilt_rad : rad, tilt at which "two-tilts" takes the velocity; the paper gives none
    settings : NavigationSettings of the filter
    stillness : StillnessSettings of the detector

    Returns
    -------
    WalkerCalibration
        The standard deviations of "all-samples" hold the sensor's noise, a bias of its
        accelerometer, and errors of its scale and its axes (``settings.scale_sd`` and
        ``axes_sd_rad``); or the scatter of the arcs and the filter's attitude where that is
        more. Edges that slip are in them as far as the arcs scatter. With 120 units of a simulated
        MTI-1, and ``for_calibrated_sensor``, the errors are 0.9, 1.0, 0.9 of them in position, and
        0.9, 1.1, 0.9 in rotation (rms).

    Raises
    ------
    InputError
        If the tilts that the method needs are not in the recording (the message says which), or
        an option has none of its values.
    """
    expect("recording", recording, Recording)
    check_choices(geometry, method, form, order)
    one_of("smooth", smooth, (True, False))

    try:
        path, warnings = navigate_recording(
            recording, smooth=smooth, settings=settings, stillness=stillness
        )
        found = calibrate_from_path(
            path,
            geometry,
            method=method,
            form=form,
            order=order,
            velocity_tilt_rad=velocity_tilt_rad,
            settings=settings,
            stillness=stillness,
            warnings=warnings,
        )
        if method != "all-samples":
            return found
        return with_sensor_errors(
            found,
            path,
            recording,
            lambda wrong: followed(wrong, smooth, found.settings, found.stillness)[0],
        )
    except InputError as error:
        if str(error).startswith(recording.source):
            raise
        raise InputError(f"{recording.source}: {error}") from None


def check_choices(
    geometry: WalkerGeometry, method: Method, form: Form, order: Sequence[TiltDirection]
) -> None:
    """Check what a calibration is asked for, whatever the readings are.

    Parameters
    ----------
    geometry, method, form, order : of :func:`calibrate_mount`

    Raises
    ------
    InputError
        If one is of another kind, or has none of its values.
    """
    expect("geometry", geometry, WalkerGeometry)
    one_of("method", method, get_args(Method))
    one_of("form", form, ("corrected", "printed"))
    check_order(order)


def with_sensor_errors(
    found: WalkerCalibration,
    path: Navigation,
    recording: Recording,
    path_of: Callable[[Recording], Navigation],
) -> WalkerCalibration:
    """State what errors of the sensor's scale, axes and bias do, by calibrating with each of them.

    The arcs show only a part of it: a forward axis of the accelerometer that reads 0.3 % too much
    moves the height by about 1 cm in the front and in the back tilt, and hardly in the others. What
    they do show is in their scatter, and the filter's noise factors stand in for the same errors:
    their sum would count them twice, the larger of both is stated.

    Parameters
    ----------
    found : WalkerCalibration by "all-samples"
    path : Navigation that it is from
    recording : Recording that the path is of
    path_of : gives the path of another recording

    Returns
    -------
    WalkerCalibration with these standard deviations, and without warnings of a footprint that
    the sensor's errors explain

    Raises
    ------
    InputError
        If one of the recordings gives no path, or the deviations leave no mount.
    """
    tilts = found.tilts
    edges = [found.geometry.edge(tilt.direction) for tilt in tilts]
    fits, turn = _fit_arcs(path, [tilt.span for tilt in tilts], edges)
    # The weights of the arcs stay: they follow the residuals, and would amplify each error.
    trust = [fit.covariance_m2 for fit in fits]
    noise = _noise_of_arcs(path, tilts, found.settings)
    place, _, noise_sd = _position_from_arcs(fits, tilts, edges, turn, trust, noise)
    place_var, turn_var = noise_sd**2, np.zeros(3)
    changes, sides = [], []
    settings = found.settings
    for wrong in wrong_readings(
        recording, settings.acc_bias_sd_mps2, settings.scale_sd, settings.axes_sd_rad
    ):
        other = path_of(wrong)
        later = len(other.time_s) - len(path.time_s)
        spans = [slice(t.span.start + later, t.span.stop + later) for t in tilts]
        other_fits, other_turn = _fit_arcs(other, spans, edges)
        there, _, _ = _position_from_arcs(other_fits, tilts, edges, other_turn, trust, noise)
        changes.append(there - place)
        sides.append(footprint_by_arcs(other_fits, tilts, other_turn))
        place_var = place_var + changes[-1] ** 2
        turn_var = turn_var + Rotation.from_matrix(other_turn @ turn.T).as_rotvec() ** 2
    place_sd = np.maximum(found.translation_sd_m, np.sqrt(place_var))
    turn_sd = np.maximum(found.rotation_sd_rad, np.sqrt(turn_var))
    check_deviations(place_sd, turn_sd)
    mount = replace(found.mount, translation_sd_m=place_sd, rotation_sd_rad=turn_sd)
    scale = scale_at_rest(path, recording)
    moved = scale / settings.scale_sd * np.sum([changes[k] for k in SCALES_OF_ACC], axis=0)
    sides_sd = np.sqrt(np.sum(np.square(np.subtract(sides, found.footprint_m)), axis=0))
    others = [text for text in found.warnings if not text.startswith(FOOTPRINT_WORDS)]
    of_sides = footprint_warnings(found.footprint_m, found.geometry, sides_sd)
    return replace(
        found,
        mount=mount,
        translation_sd_m=place_sd,
        rotation_sd_rad=turn_sd,
        warnings=(*others, *of_sides, *off_scale(scale, moved, place_sd)),
    )


def calibrate_from_path(
    path: Navigation,
    geometry: WalkerGeometry,
    *,
    method: Method = "all-samples",
    form: Form = "corrected",
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    velocity_tilt_rad: float = _VELOCITY_TILT_RAD,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
    warnings: Sequence[str] = (),
) -> WalkerCalibration:
    """Like :func:`calibrate_mount`, for an existing path of the IMU.

    Parameters
    ----------
    path : Navigation
    geometry, method, form, order, velocity_tilt_rad : as in :func:`calibrate_mount`
    settings, stillness : what the path was found with; the result carries them
    warnings : of the path; they stand first on the result

    Returns
    -------
    WalkerCalibration
        Its standard deviations hold the scatter of the arcs, the sensor's white noise and the
        filter's attitude, but not the sensor's errors of scale and axes, which take the readings:
        with a simulated MTI-1 the errors are 1.8, 1.4 and 4.5 times as large in position, and 2.3,
        2.5 and 4.6 times in rotation. Those of :func:`calibrate_mount` hold them.
    """
    check_choices(geometry, method, form, order)
    as_number(velocity_tilt_rad, "velocity_tilt_rad")
    expect("path", path, Navigation)
    warnings = as_sentences(warnings)
    tilts, of_tilts = find_tilts(path, order)
    with_ = _Choice(
        geometry,
        method,
        form,
        settings_or_default(
            "settings", path.settings if settings is None else settings, NavigationSettings
        ),
        settings_or_default("stillness", stillness, StillnessSettings),
    )
    notes = [*warnings, *of_tilts]
    if method == "all-samples":
        return _from_arcs(path, tilts, with_, notes)
    needed: tuple[TiltDirection, ...] = (
        TILT_DIRECTIONS if method == "four-tilts" else ("back", "right")
    )
    have = {tilt.direction: tilt for tilt in reversed(tilts)}
    missing = [name for name in needed if name not in have]
    if missing:
        more = f" ({'; '.join(of_tilts)})" if of_tilts else ""
        raise InputError(
            f"'{method}' needs tilts to the {', '.join(needed)}; missing: "
            f"{', '.join(missing)}{more}"
        )
    return _as_the_paper(path, have, needed, with_, velocity_tilt_rad, notes)


class _Choice(NamedTuple):
    """What a calibration is made with; the result carries it."""

    geometry: WalkerGeometry
    method: Method
    form: Form
    settings: NavigationSettings
    stillness: StillnessSettings


def _as_the_paper(
    path: Navigation,
    have: Mapping[TiltDirection, Tilt],
    needed: Sequence[TiltDirection],
    with_: _Choice,
    velocity_tilt_rad: float,
    notes: list[str],
) -> WalkerCalibration:
    """Mount by eqs 3 to 19, from the two ends of the tilts."""
    geometry, form = with_.geometry, with_.form
    tilts = {name: have[name] for name in needed}
    imu_to_body = rotation_by_ends(path, have["back"])
    distances = distances_by_ends(path, tilts, imu_to_body)
    if len(needed) == 4:
        place = position_four_tilts(distances, geometry, form=form)
        notes += _ill_conditioned(distances, geometry, form)
    else:
        arms = arms_by_velocity(path, tilts, velocity_tilt_rad, form)
        place = position_two_tilts(
            distances["back"],
            distances["right"],
            arms["back"],
            arms["right"],
            geometry.footprint_width_m,
        )
    unknown = np.full(3, np.nan)
    return WalkerCalibration(
        _mount(imu_to_body, place),
        unknown,
        unknown,
        (np.nan, np.nan),
        tuple(tilts.values()),
        tuple(notes),
        **with_._asdict(),
    )


def _ill_conditioned(
    distances: Mapping[TiltDirection, float], geometry: WalkerGeometry, form: Form
) -> list[str]:
    gain = position_gain(distances, geometry, form=form)
    return [
        f"'four-tilts' is ill-conditioned here: an error of the distances grows {value:.1f} times "
        f"in {axis}; 'all-samples' is not"
        for axis, value in zip("xyz", gain, strict=True)
        if value > 3
    ]


def _from_arcs(
    path: Navigation, tilts: Sequence[Tilt], with_: _Choice, notes: list[str]
) -> WalkerCalibration:
    """Mount from axes that are fitted to the whole arcs."""
    geometry = with_.geometry
    if {ACROSS[tilt.direction] for tilt in tilts} != {0, 1}:
        raise InputError(
            f"tilts to the {', '.join(tilt.direction for tilt in tilts)} only: 'all-samples' needs "
            "one to the front or back, and one to the right or left"
            + (f" ({'; '.join(notes)})" if notes else "")
        )
    edges = [geometry.edge(tilt.direction) for tilt in tilts]
    fits, imu_to_body = _fit_arcs(path, [tilt.span for tilt in tilts], edges)
    place, by_scatter, by_noise = _position_from_arcs(
        fits,
        tilts,
        edges,
        imu_to_body,
        [fit.covariance_m2 for fit in fits],
        _noise_of_arcs(path, tilts, with_.settings),
    )
    place_sd = np.maximum(by_scatter, by_noise)
    # The filter's errors of attitude are half angles about the IMU's axes. Where the heading is
    # known, as at the start, they are errors of the tilt, which has two directions.
    standing = [k for tilt in tilts for k in (tilt.span.start, tilt.span.stop - 1)]
    attitude_var = np.sum(path.sd[[0, *standing], :3] ** 2, axis=1)
    level = 2 * float(np.sqrt(attitude_var.min() / 2))
    footprint = footprint_by_arcs(fits, tilts, imu_to_body)
    notes += footprint_warnings(footprint, geometry)
    return WalkerCalibration(
        _mount(imu_to_body, place),
        place_sd,
        np.array([level, level, _heading_sd(fits, edges, imu_to_body)]),
        footprint,
        tuple(tilts),
        tuple(notes),
        **with_._asdict(),
    )


def _mount(imu_to_body: FloatArray, place: FloatArray) -> WalkerMount:
    """Mount that the arcs give; the message of one beyond reach is that of a bad recording."""
    if np.abs(place).max() > REACH_M:
        raise InputError(
            f"by these tilts the IMU is at {np.round(place, 2).tolist()} m in the frame's axes, "
            f"expected within {REACH_M:g} m: the recording does not show tilts about the edges; is "
            "one of the sensor's axes broken, or a unit wrong?"
        )
    return WalkerMount(imu_to_body, place)


def _fit_arcs(
    path: Navigation, spans: Sequence[slice], edges: Sequence[Edge]
) -> tuple[list[ArcFit], FloatArray]:
    """Arcs of the tilts, and the rotation IMU to body that they have with the rests."""
    attitude = path.rotation_imu_to_world()
    fits = [fit_arc(path.position_m[span], attitude[span]) for span in spans]
    standing = np.concatenate([[span.start, span.stop - 1] for span in spans])
    return fits, _rotation_from_arcs(attitude[standing, 2].mean(axis=0), fits, edges)


def _rotation_from_arcs(
    up: FloatArray, fits: Sequence[ArcFit], edges: Sequence[Edge]
) -> FloatArray:
    """IMU to body: upright by the rests, turned about the vertical as the axes fit the edges."""
    turn, _ = Rotation.align_vectors(
        [[0.0, 0.0, 1.0], *(edge.axis for edge in edges)],
        [up / np.linalg.norm(up), *(fit.axis_imu for fit in fits)],
        weights=[np.inf, *([1.0] * len(fits))],
    )
    return np.asarray(turn.as_matrix())


def _noise_of_arcs(
    path: Navigation, tilts: Sequence[Tilt], settings: NavigationSettings
) -> list[FloatArray]:
    """Covariance of each arc's arm by the sensor's noise, (3, 3) in m², in the IMU's axes."""
    attitude = path.rotation_imu_to_world()
    interval_s = float(np.median(np.diff(path.time_s)))
    return [
        arm_noise(
            attitude[tilt.span],
            path.still[tilt.span],
            interval_s,
            acc_noise_mps2_sqrthz=settings.acc_noise_mps2_sqrthz,
            gyr_noise_radps_sqrthz=settings.gyr_noise_radps_sqrthz,
        )
        for tilt in tilts
    ]


def _position_from_arcs(
    fits: Sequence[ArcFit],
    tilts: Sequence[Tilt],
    edges: Sequence[Edge],
    imu_to_body: FloatArray,
    trust: Sequence[FloatArray],
    noise: Sequence[FloatArray],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position of the IMU in the body frame; its standard deviations by scatter and by noise.

    Each arc observes two components: the one across its edge, and the height. Opposite edges
    count alike, so that what both have in common (tape, ferrules) cancels.

    Parameters
    ----------
    fits, tilts, edges : of each arc
    imu_to_body : (3, 3) array
    trust, noise : (3, 3) arrays, m², covariance of each arm by which the arcs are weighted, and
        that of the sensor's noise; in the IMU's axes
    """
    values: list[list[float]] = [[], [], []]
    weights: list[list[float]] = [[], [], []]
    by_noise: list[list[float]] = [[], [], []]
    names = [tilt.direction for tilt in tilts]
    variance = float(np.mean([np.trace(covariance) / 2 for covariance in trust]))
    for fit, edge, name, covariance, of_noise in zip(fits, edges, names, trust, noise, strict=True):
        arm = imu_to_body @ fit.arm_imu_m
        spread = imu_to_body @ covariance @ imu_to_body.T
        slow = imu_to_body @ of_noise @ imu_to_body.T
        across = ACROSS[name]
        values[across].append(float(arm[across] + edge.point_m[across]))
        weights[across].append(1 / max(variance * names.count(name), 1e-12))
        by_noise[across].append(float(slow[across, across]))
        values[2].append(float(arm[2]))
        weights[2].append(1 / max(spread[2, 2], 1e-12))
        by_noise[2].append(float(slow[2, 2]))
    place = np.array([np.average(v, weights=w) for v, w in zip(values, weights, strict=True)])
    sd = np.array([1 / np.sqrt(np.sum(w)) for w in weights])
    sd[2] *= _birge_factor(values[2], weights[2])
    noise_sd = [
        np.sqrt(np.square(w) @ np.asarray(v)) / np.sum(w)
        for v, w in zip(by_noise, weights, strict=True)
    ]
    return place, sd, np.array(noise_sd)


def _birge_factor(values: Sequence[float], weights: Sequence[float]) -> float:
    """Factor, 1 or more, by which values scatter beyond their own variances (Birge ratio).

    Parameters
    ----------
    values : repeated estimates of one quantity
    weights : one over the variance of each
    """
    if len(values) < 2:
        return 1.0
    off = np.asarray(values) - np.average(values, weights=weights)
    return max(1.0, float(np.sqrt(np.sum(np.asarray(weights) * off**2) / (len(values) - 1))))


def _heading_sd(fits: Sequence[ArcFit], edges: Sequence[Edge], imu_to_body: FloatArray) -> float:
    """Standard deviation of the mount about the vertical, rad, from how the axes miss the edges."""
    headings = []
    for fit, edge in zip(fits, edges, strict=True):
        across = imu_to_body @ fit.axis_imu
        headings.append(
            np.arctan2(
                edge.axis[0] * across[1] - edge.axis[1] * across[0], edge.axis[:2] @ across[:2]
            )
        )
    return float(np.std(headings, ddof=1)) / float(np.sqrt(len(headings)))
