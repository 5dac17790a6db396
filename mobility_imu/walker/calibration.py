"""How the IMU is fixed to the walking frame, from tilting the frame about its edges.

Standing on level ground, the frame is tilted to the front, back, right and left by 20 to 45 deg
and set down again each time. While it tilts, the IMU runs along an arc about an edge; the arc's
plane says how the IMU is turned, its radius how far from that edge it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_vectors
from mobility_imu.quality import frozen_samples, saturated_samples
from mobility_imu.recording import Imu, Recording
from mobility_imu.runs import runs_of
from mobility_imu.walker.geometry import (
    TILT_DIRECTIONS,
    TiltDirection,
    WalkerGeometry,
    WalkerMount,
    rotation_body_to_world,
    rotation_world_to_imu,
)
from mobility_imu.walker.navigation import (
    ClosedLoop,
    Navigation,
    NavigationSettings,
    navigate,
)
from mobility_imu.walker.stillness import StillnessSettings, find_stillness

Method = Literal["four-tilts", "two-tilts", "all-samples"]
Form = Literal["corrected", "printed"]

LEAST_TILT_RAD = float(np.deg2rad(10))
"""A tilt of less says little. The error of a distance grows as one over the angle."""
LATEST_REST_S = 5.0
LEAST_RATE_HZ = 10.0
MOST_NIS = 2.0
SCALE_SD = 0.003
MISALIGNMENT_SD_RAD = float(np.deg2rad(0.1))
"""Errors of the sensor's scale and axes that we take for granted; no tilt shows them."""
_NOTICED_RAD = float(np.deg2rad(3))
_UPRIGHT_RAD = float(np.deg2rad(2))
_DIRECTED_RAD = float(np.deg2rad(5))
# Directions around the frame, a quarter turn to the left from one to the next.
_AROUND: tuple[TiltDirection, ...] = ("front", "left", "back", "right")


# Equations of the paper, in their order.


def tilt_displacement(position_m: ArrayLike) -> FloatArray:
    """Displacement of the IMU in a tilt, from its end to its start (eq. 3).

    The paper counts samples by i here and tilts by i later; the difference is r_1 - r_N of one
    tilt. In a backward tilt it points forward.

    Parameters
    ----------
    position_m : (n, 3) array, m, world, from the first to the last sample of the tilting movement

    Returns
    -------
    (3,) array, m
    """
    position = as_vectors(position_m, "position_m")
    return np.asarray(position[0] - position[-1])


def forward_axis(displacement_m: ArrayLike) -> FloatArray:
    """Forward axis of the frame in the world, from a backward tilt (eqs 4-5).

    Parameters
    ----------
    displacement_m : (3,) array, m, world, see :func:`tilt_displacement`

    Returns
    -------
    (3,) array, horizontal unit vector
    """
    x, y, _ = as_vectors(displacement_m, "displacement_m")
    length = float(np.hypot(x, y))
    if not length > 1e-6:
        raise InputError("displacement_m: no horizontal part, so no forward direction")
    return np.array([x / length, y / length, 0.0])


def rotation_imu_to_body(rotation_body_to_world: ArrayLike, quaternion: ArrayLike) -> FloatArray:
    """IMU to body, from the body's axes and the attitude at the same moment (eq. 7).

    (C_b1^w)^T C'(q_1). Our text copy lacks the first transpose, and names the result, which turns
    IMU components into body components, the other way round; the print may be right.

    Parameters
    ----------
    rotation_body_to_world : (3, 3) array
    quaternion : (4,) array, Hamilton, scalar first, IMU to world

    Returns
    -------
    (3, 3) array
    """
    to_world = rotation_world_to_imu(quaternion).T
    return np.asarray(np.asarray(rotation_body_to_world, float).T @ to_world)


def tilt_rotation(
    rotation_body_to_world: ArrayLike, quaternion: ArrayLike, imu_to_body: ArrayLike
) -> FloatArray:
    """Body at the end of a tilt to body at its start (eqs 8-9).

    Parameters
    ----------
    rotation_body_to_world : (3, 3) array, at the start of the tilt
    quaternion : (4,) array, IMU to world at the end of the tilt
    imu_to_body : (3, 3) array, see :func:`rotation_imu_to_body`

    Returns
    -------
    (3, 3) array
    """
    imu_at_end = rotation_imu_to_body(rotation_body_to_world, quaternion)
    return np.asarray(imu_at_end @ np.asarray(imu_to_body, float).T)


def quaternion_from_rotation(rotation: ArrayLike) -> FloatArray:
    """Quaternion of a rotation matrix, scalar first (eq. 10).

    As printed the vector part has the sign for the transposed matrix, one in the sense of eq. 1;
    eq. 12 takes no notice of it. The form fails near half a turn, where the scalar part is 0;
    tilts do not get there.

    Parameters
    ----------
    rotation : (3, 3) array

    Returns
    -------
    (4,) array
    """
    c = np.asarray(rotation, float)
    scalar = 0.5 * np.sqrt(max(np.trace(c) + 1, 0.0))
    if scalar < 0.05:
        raise InputError("rotation: eq. 10 does not hold near half a turn")
    vector = np.array([c[2, 1] - c[1, 2], c[0, 2] - c[2, 0], c[1, 0] - c[0, 1]])
    return np.concatenate([[scalar], vector / (4 * scalar)])


def tilt_quaternion(axis: ArrayLike, angle_rad: float) -> FloatArray:
    """Quaternion of a tilt by an angle about an axis (eq. 11).

    Parameters
    ----------
    axis : (3,) array, unit vector; +y for a tilt to the front, -y back, +x right, -x left
    angle_rad : rad

    Returns
    -------
    (4,) array, scalar first
    """
    return np.concatenate(
        [[np.cos(angle_rad / 2)], np.sin(angle_rad / 2) * np.asarray(axis, float)]
    )


def tilt_angle(quaternion: ArrayLike, *, form: Form = "corrected") -> float:
    """Angle of a tilt, without sign, rad (eq. 12).

    Near 0 the printed arc cosine magnifies rounding and noise; the arc tangent does not.

    Parameters
    ----------
    quaternion : (4,) array, scalar first
    form : "corrected" (arc tangent) or "printed" (arc cosine)
    """
    q = np.asarray(quaternion, float)
    if form == "printed":
        return float(2 * np.arccos(np.clip(q[0], -1, 1)))
    return float(2 * np.arctan2(np.linalg.norm(q[1:]), abs(q[0])))


def distance_to_edge(displacement_m: float, angle_rad: float) -> float:
    """Distance of the IMU from the edge that the frame is tilted about, m (eq. 13).

    Parameters
    ----------
    displacement_m : m, length of the chord between the two ends of the arc
    angle_rad : rad, angle between them
    """
    if not angle_rad > 0:
        raise InputError(f"angle_rad = {angle_rad}: expected a positive angle")
    return float(displacement_m / (2 * np.sin(angle_rad / 2)))


def imu_height(distances_m: Mapping[TiltDirection, float], geometry: WalkerGeometry) -> float:
    """Height of the IMU over the floor from its distances to the four edges, m (eq. 14).

    The mean of the heights of two triangles, each by Heron's formula. It needs the footprint's
    width and length, which the paper lists in its procedure.

    Parameters
    ----------
    distances_m : m, per direction of tilt: front d1, back d2, right d3, left d4
    geometry : WalkerGeometry

    Raises
    ------
    InputError
        If two distances do not reach across the footprint, so that there is no such triangle.
    """
    total = 0.0
    for base, one, other in (
        (geometry.footprint_width_m, "right", "left"),
        (geometry.footprint_length_m, "front", "back"),
    ):
        a, b = distances_m[one], distances_m[other]  # type: ignore[index]
        p = (base + a + b) / 2
        square = p * (p - base) * (p - a) * (p - b)
        if square < 0:
            raise InputError(
                f"distances to the {one} and {other} edges, {a:.3f} and {b:.3f} m, make no "
                f"triangle over {base:.3f} m: eq. 14 gives no height"
            )
        total += np.sqrt(square) / base
    return float(total)


def position_four_tilts(
    distances_m: Mapping[TiltDirection, float],
    geometry: WalkerGeometry,
    *,
    form: Form = "corrected",
) -> FloatArray:
    """Position of the IMU in the body frame from four tilts (eq. 15).

    The printed roots hold for 0 <= x and abs(y) <= width / 2, as in all of the paper's poses.
    Elsewhere they lose the sign, and they magnify errors where x or the distance to a side is
    small. The differences of squares do neither.

    Parameters
    ----------
    distances_m : m, per direction of tilt
    geometry : WalkerGeometry
    form : "corrected" (differences of squares) or "printed" (roots)

    Returns
    -------
    (3,) array, m

    Raises
    ------
    InputError
        If a root of the printed form has no real value.
    """
    height = imu_height(distances_m, geometry)
    d1, d2, d3, d4 = (distances_m[name] for name in TILT_DIRECTIONS)
    if form == "printed":
        squares = np.array([d2**2, d3**2, d4**2]) - height**2
        if (squares < 0).any():
            raise InputError(
                f"eq. 15 as printed: the height {height:.3f} m is more than the distance to the "
                f"{('back', 'right', 'left')[int(np.argmin(squares))]} edge; use the corrected form"
            )
        x, right, left = np.sqrt(squares)
        return np.array([x, (right - left) / 2, height])
    width, length = geometry.footprint_width_m, geometry.footprint_length_m
    return np.array(
        [(d2**2 - d1**2 + length**2) / (2 * length), (d3**2 - d4**2) / (2 * width), height]
    )


def arm_angle(velocity_mps: ArrayLike, *, tilt_rad: float = 0.0) -> float:
    """Angle of the arm from edge to IMU against the vertical, rad (eqs 16-17).

    At the start of a tilt the IMU moves at right angles to the arm. At the very start there is no
    velocity, and the paper does not say when its "initial velocity" is taken. Later, at a tilt of
    theta, the arm has turned by theta, which has to be added back.

    Parameters
    ----------
    velocity_mps : (3,) array, m/s, world
    tilt_rad : rad, tilt at that moment; 0 for the printed form, which is exact at the very start
    """
    velocity = as_vectors(velocity_mps, "velocity_mps")
    speed = float(np.linalg.norm(velocity))
    if not speed > 0:
        raise InputError("velocity_mps: zero, so without a direction")
    beta = np.arccos(np.clip(velocity[2] / speed, -1, 1))
    return float(np.pi / 2 - beta + tilt_rad)


def position_two_tilts(
    distance_back_m: float,
    distance_right_m: float,
    arm_back_rad: float,
    arm_right_rad: float,
    footprint_width_m: float,
) -> FloatArray:
    """Position of the IMU in the body frame from a backward and a rightward tilt (eqs 18-19).

    Parameters
    ----------
    distance_back_m, distance_right_m : m, d2 and d3
    arm_back_rad, arm_right_rad : rad, gamma_2 and gamma_3, see :func:`arm_angle`
    footprint_width_m : m, CD

    Returns
    -------
    (3,) array, m
    """
    return np.array(
        [
            distance_back_m * np.sin(arm_back_rad),
            distance_right_m * np.sin(arm_right_rad) - footprint_width_m / 2,
            (distance_back_m * np.cos(arm_back_rad) + distance_right_m * np.cos(arm_right_rad)) / 2,
        ]
    )


# Past the paper: the whole arc instead of its two ends.


class ArcFit(NamedTuple):
    """An axis fitted to the whole of a tilt.

    Parameters
    ----------
    axis_imu : (3,) array, unit vector that the frame turns positively about, IMU's axes
    arm_imu_m : (3,) array, m, from the axis to the IMU at right angles, IMU's axes
    covariance_m2 : (3, 3) array, m², of the arm
    residual_m : rms distance of the path from the arc, m
    """

    axis_imu: FloatArray
    arm_imu_m: FloatArray
    covariance_m2: FloatArray
    residual_m: float


def fit_arc(position_m: ArrayLike, rotation_imu_to_world: ArrayLike) -> ArcFit:
    """Axis and arm from all samples of a tilt, by linear least squares.

    With a fixed axis, r_k = e + R(q_k) arm. The axis is the main direction of the rotation vectors
    from the start; the arm is at right angles to it. Neighbouring residuals are alike, so that
    the covariance is that of as many samples as are independent.

    Parameters
    ----------
    position_m : (n, 3) array, m, world, upright to upright or to the end of the tilt
    rotation_imu_to_world : (n, 3, 3) array

    Returns
    -------
    ArcFit
    """
    position = as_vectors(position_m, "position_m")
    attitude = np.asarray(rotation_imu_to_world, float)
    count = len(position)
    turns = Rotation.from_matrix(attitude[0].T @ attitude).as_rotvec()
    _, _, directions = np.linalg.svd(turns, full_matrices=False)
    axis = directions[0] * np.sign(np.sum(turns @ directions[0]))
    # Two unknown components of the arm, in a basis at right angles to the axis.
    basis = directions[1:3].T
    design = np.zeros((3 * count, 5))
    design[:, :3] = np.tile(np.eye(3), (count, 1))
    design[:, 3:] = (attitude @ basis).reshape(-1, 2)
    solution, *_ = np.linalg.lstsq(design, position.ravel(), rcond=None)
    residual = (position.ravel() - design @ solution).reshape(-1, 3)
    variance = float(np.sum(residual**2)) / (3 * count - 5) * _correlated_samples(residual)
    spread = variance * np.linalg.inv(design.T @ design)[3:, 3:]
    return ArcFit(
        axis,
        basis @ solution[3:],
        basis @ spread @ basis.T,
        float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))),
    )


def _correlated_samples(residual: FloatArray) -> float:
    """How many neighbouring samples count as one: the integrated autocorrelation, at least 1."""
    count = len(residual)
    spectrum = np.abs(np.fft.rfft(residual, 2 * count, axis=0)) ** 2
    products = np.fft.irfft(spectrum.sum(axis=1))[:count]
    if not products[0] > 0:
        return 1.0
    correlation = products / products[0]
    negative = np.nonzero(correlation < 0)[0]
    until = int(negative[0]) if len(negative) else count
    return float(max(1.0, 1 + 2 * np.sum(correlation[1:until])))


# The procedure, from a recording.


class Tilt(NamedTuple):
    """A tilt that was found in a recording.

    Parameters
    ----------
    direction : which way it went
    span : slice of the samples from upright to upright
    top : int, sample at the end of the tilting movement, before it goes back
    angle_rad : rad, angle there
    """

    direction: TiltDirection
    span: slice
    top: int
    angle_rad: float


@dataclass(frozen=True)
class MountCalibration:
    """A mount with what is known of its errors.

    Parameters
    ----------
    mount : WalkerMount
    translation_sd_m : (3,) array, m; NaN for the paper's methods, which have none
    rotation_sd_rad : (3,) array, rad, about the body's axes; NaN likewise
    footprint_m : width and length of the footprint as the arcs have it, NaN where not seen
    tilts : the tilts that were used
    warnings : what the user should know
    """

    mount: WalkerMount
    translation_sd_m: FloatArray
    rotation_sd_rad: FloatArray
    footprint_m: tuple[float, float]
    tilts: tuple[Tilt, ...]
    warnings: tuple[str, ...]


def find_tilts(
    navigation: Navigation, order: Sequence[TiltDirection] = TILT_DIRECTIONS
) -> tuple[tuple[Tilt, ...], tuple[str, ...]]:
    """Find the tilts in a path, and which way each went.

    The edges form a rectangle, so that the directions follow from one of them; which edge that was,
    no recording can tell. The stated order decides, also if some of its tilts are missing.

    Parameters
    ----------
    navigation : Navigation
    order : directions of the tilts as they were made

    Returns
    -------
    the tilts in time, and warnings: another order, tilts that are too small, too many, missing

    Raises
    ------
    InputError
        If no tilt is found, one goes across a corner, or the order leaves open which they were.
    """
    unknown = [name for name in order if name not in TILT_DIRECTIONS]
    if unknown or not order:
        raise InputError(
            f"order = {', '.join(order) or '(empty)'}: expected names out of "
            f"{', '.join(TILT_DIRECTIONS)}"
        )
    attitude, time_s = navigation.rotation_imu_to_world(), navigation.time_s
    first = int(np.argmax(navigation.still))
    up = attitude[first, 2]
    lean = np.arccos(np.clip(attitude[:, 2] @ up, -1, 1))
    rest = navigation.still & (lean < _UPRIGHT_RAD)
    warnings: list[str] = []
    small: list[str] = []
    # Movements whose direction is clear take part in naming, also those that cannot be used.
    ways: list[FloatArray] = []
    usable: list[tuple[slice, int, float] | None] = []
    starts: list[str] = []
    for span in runs_of(lean > _NOTICED_RAD):
        top = _end_of_movement(lean, navigation.still, span)
        angle, when = float(lean[top]), f"the tilt at {time_s[span.start]:.1f} s"
        before = np.nonzero(rest[: span.start])[0]
        after = np.nonzero(rest[span.stop :])[0]
        whole = None
        if not len(before):
            warnings.append(f"{when} has no still phase before it: left out")
        elif angle < LEAST_TILT_RAD:
            small.append(
                f"{when} reaches only {np.rad2deg(angle):.1f} deg: left out (expected 20 to 45 deg)"
            )
        elif not len(after):
            warnings.append(f"{when} does not come back before the recording ends: left out")
        else:
            whole = slice(int(before[-1]), span.stop + int(after[0]) + 1)
        if angle > _DIRECTED_RAD:
            # Up, as the tilted IMU sees it, lies against the way that the top went.
            way = np.cos(angle) * up - attitude[top, 2]
            ways.append(way / np.linalg.norm(way))
            usable.append(None if whole is None else (whole, top, angle))
            starts.append(when)
    if len(small) > 3:
        small = [small[0], f"{len(small) - 1} more movements stay that small: is this a walk?"]
    warnings += small
    if not any(usable):
        said = f" ({'; '.join(warnings)})" if warnings else ""
        raise InputError(
            "no tilt found: expected rest on all four tips, then tilts of 20 to 45 deg with rest "
            f"between them{said}"
        )
    names, said_of_order = _name_tilts(ways, usable, starts, up, order)
    tilts = tuple(
        Tilt(name, *found) for name, found in zip(names, usable, strict=True) if found is not None
    )
    return tilts, (*warnings, *said_of_order)


def _name_tilts(
    ways: Sequence[FloatArray],
    usable: Sequence[tuple[slice, int, float] | None],
    starts: Sequence[str],
    up: FloatArray,
    order: Sequence[TiltDirection],
) -> tuple[list[TiltDirection], list[str]]:
    """Name movements by their directions, so that they follow the stated order as far as they can.

    Seen from the first movement the directions are known in quarter turns; which edge the first
    was decides for all. Movements may be missing from the order.
    """
    turns = [float(np.arctan2(np.cross(ways[0], way) @ up, ways[0] @ way)) for way in ways]
    quarters = [round(turn / (np.pi / 2)) for turn in turns]
    for turn, quarter, found, when in zip(turns, quarters, usable, starts, strict=True):
        off = abs(np.rad2deg(turn) - 90 * quarter)
        if found is not None and off > 25:
            raise InputError(
                f"{when} goes {off:.0f} deg off a right angle to the first: expected tilts about "
                "the edges"
            )
    candidates: list[list[TiltDirection]] = []
    for start in range(4):
        names = [_AROUND[(start + quarter) % 4] for quarter in quarters]
        rest = iter(order)
        distinct = [name for k, name in enumerate(names) if k == 0 or name != names[k - 1]]
        if all(name in rest for name in distinct):
            candidates.append(names)
    if len(candidates) > 1:
        options = " or ".join(", ".join(names) for names in candidates)
        raise InputError(
            f"the tilts may have gone {options}: state which ones were made, and in which order"
        )
    if candidates:
        missing = [name for name in order if name not in candidates[0]]
        return candidates[0], [f"no tilt to the {', '.join(missing)} found"] if missing else []
    start = _AROUND.index(order[0])
    names = [_AROUND[(start + quarter) % 4] for quarter in quarters]
    mirrored = {"right": "left", "left": "right"}
    hint = ""
    if [mirrored.get(name, name) for name in names] == list(order):
        hint = "; or has the accelerometer's sign been reversed?"
    return names, [
        f"the tilts went {', '.join(names)} if the first was to the {order[0]}, and not "
        f"{', '.join(order)}: taken as such. If the first was another one, the mount is turned "
        f"by a quarter or half a turn{hint}"
    ]


def _end_of_movement(lean: FloatArray, still: NDArray[np.bool_], span: slice) -> int:
    """Middle of the still phase at the top, or the largest angle if it was not held still."""
    top = span.start + int(np.argmax(lean[span]))
    held = np.arange(span.start, span.stop)[still[span] & (lean[span] > 0.8 * lean[top])]
    return int(held[len(held) // 2]) if len(held) else top


def navigate_recording(
    recording: Recording,
    *,
    smooth: bool = True,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
    closed_loop: ClosedLoop | None = None,
) -> tuple[Navigation, tuple[str, ...]]:
    """Stillness and path of a recording's sensor "frame", with warnings.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    smooth, settings, stillness, closed_loop : see
        :func:`mobility_imu.walker.navigation.navigate`

    Returns
    -------
    Navigation from the first rest on, warnings (a late rest, samples at the end of the range)

    Raises
    ------
    InputError
        If there is no rest within the first seconds.
    """
    imu = recording.sensor("frame", gyroscope=True)
    gyr = np.asarray(imu.gyr_radps)
    if not LEAST_RATE_HZ <= recording.sampling_rate_hz:
        raise InputError(
            f"{recording.source}: {recording.sampling_rate_hz:g} samples per second, expected "
            f"{LEAST_RATE_HZ:g} or more (is time_s in ms?)"
        )
    still = find_stillness(imu.acc_mps2, gyr, recording.sampling_rate_hz, stillness)
    cut_acc, cut_gyr = saturated_samples(imu.acc_mps2), saturated_samples(gyr)
    # A sensor that seldom moves repeats its largest value by rounding; a range ends far out.
    cut_acc &= np.abs(imu.acc_mps2).max(axis=1) > 15.0
    cut_gyr &= np.abs(gyr).max(axis=1) > 3.0
    warnings = [
        f"{recording.source}: frame_{name} is saturated in {int(cut.sum())} samples, first at "
        f"{recording.time_s[np.argmax(cut)]:g} s: speed and path are uncertain from there to the "
        "next still phase"
        for name, cut in (("acc", cut_acc), ("gyr", cut_gyr))
        if cut.any()
    ]
    frozen = frozen_samples(np.hstack([imu.acc_mps2, gyr]), recording.sampling_rate_hz)
    if frozen.any():
        warnings.append(
            f"{recording.source}: the readings repeat themselves in {int(frozen.sum())} samples, "
            f"first at {recording.time_s[np.argmax(frozen)]:g} s: was the sensor frozen?"
        )
    # Where up is comes from the first rest; what lies before it cannot be followed.
    begin = int(np.argmax(still))
    late_s = float(recording.time_s[begin] - recording.time_s[0])
    if late_s > LATEST_REST_S or not still.any():
        raise InputError(
            f"{recording.source}: the frame is not still within the first {LATEST_REST_S:g} s: "
            "expected some seconds of rest at the start, which say where up is"
            + _why_not_still(imu.acc_mps2, gyr, recording.sampling_rate_hz, stillness)
        )
    if late_s > 0.2:
        warnings.append(
            f"{recording.source}: the frame moves at the start; the first {late_s:.1f} s are left "
            "out"
        )
    try:
        path = navigate(
            recording.time_s[begin:],
            imu.acc_mps2[begin:],
            gyr[begin:],
            still[begin:],
            settings,
            smooth=smooth,
            cut=cut_acc[begin:],
            closed_loop=closed_loop,
        )
    except InputError as error:
        raise InputError(f"{recording.source}: {error}") from None
    updates = int(path.nis_dof.sum())
    # What is wrong throughout a rest is measured by a stride's noise, less than a sample's.
    strides, samples = np.count_nonzero(path.nis_dof), np.count_nonzero(path.still)
    nis = path.nis.sum() / updates * strides / samples if updates else 0.0
    if nis > MOST_NIS:
        excess = np.sqrt(nis)
        warnings.append(
            f"{recording.source}: the rests are {excess:.1f} times as far from what the filter "
            "expects as they should be: are axes exchanged, or signs reversed?"
        )
    return path, tuple(warnings)


def _why_not_still(
    acc: FloatArray, gyr: FloatArray, rate_hz: float, settings: StillnessSettings | None
) -> str:
    """Guess at the gyroscope's unit if the accelerometer alone finds the frame at rest."""
    soon = slice(0, int(LATEST_REST_S * rate_hz))
    quiet = find_stillness(acc[soon], np.zeros_like(gyr[soon]), rate_hz, settings)
    fast = float(np.median(np.abs(gyr[soon][quiet]).max(axis=1))) if quiet.any() else 0.0
    if quiet.mean() > 0.2 and fast > 0.02:
        return f" (the force is at rest, the rate is {fast:.2g}: is the gyroscope in deg/s?)"
    return ""


def calibrate_mount(
    recording: Recording,
    geometry: WalkerGeometry,
    *,
    method: Method = "all-samples",
    form: Form = "corrected",
    smooth: bool = True,
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    velocity_tilt_rad: float = float(np.deg2rad(3)),
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
) -> MountCalibration:
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
    settings, stillness : see :func:`mobility_imu.walker.navigation.navigate`

    Returns
    -------
    MountCalibration; the standard deviations of "all-samples" are the scatter of the arcs with
        the effect of SCALE_SD and MISALIGNMENT_SD_RAD, but not of edges that slip

    Raises
    ------
    InputError
        If the tilts that the method needs are not in the recording; the message says which.
    """

    def calibrate(readings: Recording) -> MountCalibration:
        path, said = navigate_recording(
            readings, smooth=smooth, settings=settings, stillness=stillness
        )
        return calibrate_from_path(
            path,
            geometry,
            method=method,
            form=form,
            order=order,
            velocity_tilt_rad=velocity_tilt_rad,
            warnings=said,
        )

    try:
        found = calibrate(recording)
        if method != "all-samples":
            return found
        return _with_sensor_errors(found, recording, calibrate)
    except InputError as error:
        if str(error).startswith(recording.source):
            raise
        raise InputError(f"{recording.source}: {error}") from None


def _with_sensor_errors(
    found: MountCalibration,
    recording: Recording,
    calibrate: Callable[[Recording], MountCalibration],
) -> MountCalibration:
    """Add what errors of the sensor's scale and axes do, by calibrating with each of them.

    No tilt shows them: a forward axis of the accelerometer that reads 0.3 % too much moves the
    height by 4 mm in the front and back tilts alike.
    """
    imu = recording.sensor("frame", gyroscope=True)
    place_var, turn_var = found.translation_sd_m**2, found.rotation_sd_rad**2
    for sensor in ("acc", "gyr"):
        for row in range(3):
            for column in range(3):
                size = SCALE_SD if row == column else MISALIGNMENT_SD_RAD
                mixing = np.eye(3)
                mixing[row, column] += size
                acc, gyr = imu.acc_mps2, np.asarray(imu.gyr_radps)
                wrong = Imu(acc @ mixing.T, gyr) if sensor == "acc" else Imu(acc, gyr @ mixing.T)
                other = calibrate(Recording(recording.time_s, {"frame": wrong})).mount
                place_var = (
                    place_var + (other.translation_body_m - found.mount.translation_body_m) ** 2
                )
                turn = other.rotation_imu_to_body @ found.mount.rotation_imu_to_body.T
                turn_var = turn_var + Rotation.from_matrix(turn).as_rotvec() ** 2
    place_sd, turn_sd = np.sqrt(place_var), np.sqrt(turn_var)
    mount = replace(found.mount, translation_sd_m=place_sd, rotation_sd_rad=turn_sd)
    return replace(found, mount=mount, translation_sd_m=place_sd, rotation_sd_rad=turn_sd)


def calibrate_from_path(
    path: Navigation,
    geometry: WalkerGeometry,
    *,
    method: Method = "all-samples",
    form: Form = "corrected",
    order: Sequence[TiltDirection] = TILT_DIRECTIONS,
    velocity_tilt_rad: float = float(np.deg2rad(3)),
    warnings: Sequence[str] = (),
) -> MountCalibration:
    """Do what :func:`calibrate_mount` does, from a path that is there already.

    Parameters
    ----------
    path : Navigation
    geometry, method, form, order, velocity_tilt_rad : as in :func:`calibrate_mount`
    warnings : said before

    Returns
    -------
    MountCalibration; its standard deviations are those of a sensor without errors of its axes
    """
    if method not in ("four-tilts", "two-tilts", "all-samples"):
        raise InputError(
            f"method = {method!r}: expected 'four-tilts', 'two-tilts' or 'all-samples'"
        )
    tilts, said = find_tilts(path, order)
    notes = [*warnings, *said]
    if method == "all-samples":
        return _from_arcs(path, tilts, geometry, notes)
    needed: tuple[TiltDirection, ...] = (
        TILT_DIRECTIONS if method == "four-tilts" else ("back", "right")
    )
    have = {tilt.direction: tilt for tilt in reversed(tilts)}
    missing = [name for name in needed if name not in have]
    if missing:
        more = f" ({'; '.join(said)})" if said else ""
        raise InputError(
            f"'{method}' needs tilts to the {', '.join(needed)}; missing: "
            f"{', '.join(missing)}{more}"
        )
    return _as_the_paper(path, have, needed, geometry, form, velocity_tilt_rad, notes)


def _as_the_paper(
    path: Navigation,
    have: Mapping[TiltDirection, Tilt],
    needed: Sequence[TiltDirection],
    geometry: WalkerGeometry,
    form: Form,
    velocity_tilt_rad: float,
    notes: list[str],
) -> MountCalibration:
    back = have["back"]
    displacement = tilt_displacement(path.position_m[back.span.start : back.top + 1])
    body = rotation_body_to_world(forward_axis(displacement))
    imu_to_body = rotation_imu_to_body(body, path.quaternion[back.span.start])
    distances: dict[TiltDirection, float] = {}
    for name in needed:
        tilt = have[name]
        start = path.quaternion[tilt.span.start]
        # The frame may stand a little turned after an earlier tilt: its axes at this tilt's start.
        here = rotation_world_to_imu(start).T @ imu_to_body.T
        turned = tilt_rotation(here, path.quaternion[tilt.top], imu_to_body)
        chord = tilt_displacement(path.position_m[tilt.span.start : tilt.top + 1])
        distances[name] = distance_to_edge(
            float(np.linalg.norm(chord)), tilt_angle(quaternion_from_rotation(turned))
        )
    if len(needed) == 4:
        place = position_four_tilts(distances, geometry, form=form)
        notes += _ill_conditioned(distances, geometry, form)
    else:
        arms = {}
        for name in needed:
            k, theta = _early_in_tilt(path, have[name], velocity_tilt_rad)
            lag = 0.0 if form == "printed" else theta
            arms[name] = arm_angle(path.velocity_mps[k], tilt_rad=lag)
        place = position_two_tilts(
            distances["back"],
            distances["right"],
            arms["back"],
            arms["right"],
            geometry.footprint_width_m,
        )
    unknown = np.full(3, np.nan)
    return MountCalibration(
        WalkerMount(imu_to_body, place),
        unknown,
        unknown,
        (np.nan, np.nan),
        tuple(have[name] for name in needed),
        tuple(notes),
    )


def _early_in_tilt(path: Navigation, tilt: Tilt, wanted_rad: float) -> tuple[int, float]:
    """First sample of the movement that is tilted by the wanted angle, and its angle."""
    attitude = path.rotation_imu_to_world()[tilt.span.start : tilt.top + 1, 2]
    lean = np.arccos(np.clip(attitude @ attitude[0], -1, 1))
    beyond = np.nonzero(lean >= wanted_rad)[0]
    if not len(beyond):
        raise InputError(
            f"velocity_tilt_rad = {wanted_rad:g}: the tilt to the {tilt.direction} does not get "
            "there"
        )
    return tilt.span.start + int(beyond[0]), float(lean[beyond[0]])


def position_gain(
    distances_m: Mapping[TiltDirection, float], geometry: WalkerGeometry, *, form: Form
) -> FloatArray:
    """How much an error of the distances grows in each component of eq. 15: row norms of its slope.

    Parameters
    ----------
    distances_m, geometry, form : as in :func:`position_four_tilts`

    Returns
    -------
    (3,) array, m per m
    """
    step = 1e-6

    def moved(name: TiltDirection, by: float) -> FloatArray:
        return position_four_tilts(
            {**distances_m, name: distances_m[name] + by}, geometry, form=form
        )

    slopes = [(moved(name, step) - moved(name, -step)) / (2 * step) for name in TILT_DIRECTIONS]
    return np.asarray(np.linalg.norm(slopes, axis=0))


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
    path: Navigation, tilts: Sequence[Tilt], geometry: WalkerGeometry, notes: list[str]
) -> MountCalibration:
    pairs = {"front": 0, "back": 0, "right": 1, "left": 1}
    if {pairs[tilt.direction] for tilt in tilts} != {0, 1}:
        raise InputError(
            f"tilts to the {', '.join(tilt.direction for tilt in tilts)} only: 'all-samples' needs "
            "one to the front or back, and one to the right or left"
            + (f" ({'; '.join(notes)})" if notes else "")
        )
    attitude = path.rotation_imu_to_world()
    fits = [fit_arc(path.position_m[tilt.span], attitude[tilt.span]) for tilt in tilts]
    standing = np.concatenate([[tilt.span.start, tilt.span.stop - 1] for tilt in tilts])
    up = attitude[standing, 2].mean(axis=0)
    up /= np.linalg.norm(up)
    edges = [geometry.edge(tilt.direction) for tilt in tilts]
    turn, _ = Rotation.align_vectors(
        [[0.0, 0.0, 1.0], *(edge.axis for edge in edges)],
        [up, *(fit.axis_imu for fit in fits)],
        weights=[np.inf, *([1.0] * len(fits))],
    )
    imu_to_body = turn.as_matrix()
    # Each arc observes two components: the one across its edge, and the height. Opposite edges
    # count alike, so that what both have in common (tape, ferrules) cancels.
    values: list[list[float]] = [[], [], []]
    weights: list[list[float]] = [[], [], []]
    names = [tilt.direction for tilt in tilts]
    variance = float(np.mean([np.trace(fit.covariance_m2) / 2 for fit in fits]))
    for fit, edge, name in zip(fits, edges, names, strict=True):
        arm = imu_to_body @ fit.arm_imu_m
        spread = imu_to_body @ fit.covariance_m2 @ imu_to_body.T
        values[pairs[name]].append(float(arm[pairs[name]] + edge.point_m[pairs[name]]))
        weights[pairs[name]].append(1 / max(variance * names.count(name), 1e-12))
        values[2].append(float(arm[2]))
        weights[2].append(1 / max(spread[2, 2], 1e-12))
    place = np.array([np.average(v, weights=w) for v, w in zip(values, weights, strict=True)])
    sd = np.array([1 / np.sqrt(np.sum(w)) for w in weights])
    if len(tilts) > 1:
        # Where the heights disagree by more than they should, all are that much worse (Birge).
        chi = float(np.sum(np.array(weights[2]) * (np.array(values[2]) - place[2]) ** 2))
        sd[2] *= max(1.0, np.sqrt(chi / (len(tilts) - 1)))
    headings = []
    for fit, edge in zip(fits, edges, strict=True):
        across = imu_to_body @ fit.axis_imu
        headings.append(
            np.arctan2(
                edge.axis[0] * across[1] - edge.axis[1] * across[0], edge.axis[:2] @ across[:2]
            )
        )
    level = 2 * float(np.mean(path.sd[standing, :3]))
    yaw_sd = float(np.std(headings, ddof=1)) / np.sqrt(len(headings))
    footprint = _footprint(fits, tilts, imu_to_body)
    notes += _footprint_doubts(footprint, geometry)
    return MountCalibration(
        WalkerMount(imu_to_body, place),
        sd,
        np.array([level, level, yaw_sd]),
        footprint,
        tuple(tilts),
        tuple(notes),
    )


def _footprint(
    fits: Sequence[ArcFit], tilts: Sequence[Tilt], imu_to_body: FloatArray
) -> tuple[float, float]:
    """Width and length between opposite edges, NaN where only one of them was used."""
    arms: dict[str, list[float]] = {name: [] for name in TILT_DIRECTIONS}
    for fit, tilt in zip(fits, tilts, strict=True):
        axis = 0 if tilt.direction in ("front", "back") else 1
        arms[tilt.direction].append(float((imu_to_body @ fit.arm_imu_m)[axis]))
    middle = {name: float(np.mean(v)) if v else np.nan for name, v in arms.items()}
    return middle["right"] - middle["left"], middle["back"] - middle["front"]


def _footprint_doubts(footprint: tuple[float, float], geometry: WalkerGeometry) -> list[str]:
    measured = (geometry.footprint_width_m, geometry.footprint_length_m)
    swapped = [abs(f - m) for f, m in zip(footprint, measured[::-1], strict=True)]
    apart = [abs(f - m) for f, m in zip(footprint, measured, strict=True)]
    other_way = max(apart) > 0.04 and max(swapped) < max(apart) / 2
    hint = ""
    if other_way:
        hint = (
            "; width and length fit the other way round: was the first tilt to a side, "
            "or are they swapped in the file?"
        )
    return [
        f"by the arcs the footprint's {name} is {found:.3f} m, measured {tape:.3f} m{hint}"
        for name, found, tape, off in zip(
            ("width", "length"), footprint, measured, apart, strict=True
        )
        if off > (0.04 if other_way else 0.1)
    ]
