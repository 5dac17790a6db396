"""Is the geometry right? The frame's gyroscope knows the turns; the wheels must agree.

With the no-slip speeds of the wheel centres, r_R Om_R - r_L Om_L = d_c * yaw + c * V + o. A
least-squares fit gives the distance d_c that the data have, with c the mismatch of the radii, and
with o what constant offsets of the three gyroscopes leave; the rate across the axle gives the
camber, whatever the distances are. A gyroscope that reads 0.3 % too much cannot be told from a
radius or a distance that is 0.3 % off: the standard deviations hold that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.wheelchair.geometry import SIDES, WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount

__all__ = ["GeometryCheck", "check_geometry"]

SLOWEST_TURN_RADPS = 0.3
SHORTEST_TURNING_S = 2.0
# What a tape can do: a centimetre of track, a degree of camber, half a percent of radius.
TRACK_TOLERANCE_M = 0.01
CAMBER_TOLERANCE_RAD = float(np.deg2rad(2.0))
RADIUS_TOLERANCE = 0.005
LARGEST_MISMATCH = 0.2
"""No two wheels of a pair differ by more in radius."""
# Assumed errors of a gyroscope's scale factors and axes; a drive cannot show them. The data sheets
# of the usual sensors do not state them; the simulated MTI-1 is drawn with these.
GYROSCOPE_SCALE_SD = 0.003
GYROSCOPE_MISALIGNMENT_SD_RAD = float(np.deg2rad(0.1))
BLOCK_S = 1.0
"""Residuals last about a push: those of one block are taken together."""
# Below this, track, mismatch of the radii and offset cannot be told apart.
SMALLEST_INDEPENDENT_PART = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class GeometryCheck(Result):
    """What a drive says of the geometry it is analysed with.

    Parameters
    ----------
    yaw_gain_left, yaw_gain_right : wheels' yaw rate over the frame's, in left and in right turns;
        1 is right; NaN without enough of such turns
    track_m, track_sd_m : track that fits the turns, with radii and camber as given
    radius_ratio, radius_ratio_sd : factor on right over left radius that fits (1: as given)
    camber_rad, camber_sd_rad : camber from the rate across the axles
    geometry : WheelchairGeometry that was checked
    warnings : what is wrong, by how much, in words; empty if all fits
    """

    yaw_gain_left: float
    yaw_gain_right: float
    track_m: float
    track_sd_m: float
    radius_ratio: float
    radius_ratio_sd: float
    camber_rad: float
    camber_sd_rad: float
    geometry: WheelchairGeometry
    warnings: tuple[str, ...] = ()


def check_geometry(
    recording: Recording, geometry: WheelchairGeometry, mount: WheelchairMount
) -> GeometryCheck:
    """Compare the wheels with the frame over a drive with turns.

    The absolute size of the radii cannot be checked this way: only a known distance shows it. The
    standard deviations hold the scatter of the residuals, and gyroscopes whose scale factors are
    known to GYROSCOPE_SCALE_SD. With that, radii that differ by less than 1.3 % from what is given
    are not reported.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel
    geometry : WheelchairGeometry to be checked
    mount : WheelchairMount, from
        :func:`~mobility_imu.wheelchair.calibration.calibrate_mount`

    Returns
    -------
    GeometryCheck

    Raises
    ------
    InputError
        If a sensor is missing in the recording or in the mount, the chair turns for less than two
        seconds in all, or its speed is constant or goes with its yaw rate throughout.
    """
    expect("recording", recording, Recording)
    expect("geometry", geometry, WheelchairGeometry)
    expect("mount", mount, WheelchairMount)
    yaw = mount.frame(recording.gyroscope("frame"))[:, 2]
    wheels = [mount.wheel(side, recording.gyroscope(f"{side}_wheel")) for side in SIDES]
    turning = np.abs(yaw) > SLOWEST_TURN_RADPS
    fs = recording.sampling_rate_hz
    if turning.sum() < SHORTEST_TURNING_S * fs:
        raise InputError(
            f"{recording.source}: {turning.sum() / fs:.1f} s of turning faster than "
            f"{SLOWEST_TURN_RADPS} rad/s, expected at least {SHORTEST_TURNING_S} s to check with"
        )
    left, right = (
        radius * rate[:, 2] for radius, rate in zip(geometry.wheel_radius_m, wheels, strict=True)
    )
    speed, apart = (left + right) / 2, right - left
    distance, distance_sd, mismatch, mismatch_sd = _distances(
        recording, mount, yaw, speed, apart, turning
    )
    gains = [
        float((apart - mismatch * speed)[way] @ yaw[way] / (yaw[way] @ yaw[way]))
        / geometry.wheel_centre_distance_m
        if way.sum() >= SHORTEST_TURNING_S / 2 * fs
        else float("nan")
        for way in (turning & (yaw > 0), turning & (yaw < 0))
    ]
    yaw_gain_sd = _gain_sd(mount.rotation_frame_imu_to_chair[2])
    camber, camber_sd = _camber(wheels[0], wheels[1], yaw, turning, yaw_gain_sd)
    lean = geometry.track_m - geometry.wheel_centre_distance_m
    return GeometryCheck(
        yaw_gain_left=gains[0],
        yaw_gain_right=gains[1],
        track_m=distance + lean,
        track_sd_m=distance_sd,
        # A radius mismatch e adds e times the speed; the ratio that fits is 1 - e (first order).
        radius_ratio=1 - mismatch,
        radius_ratio_sd=mismatch_sd,
        camber_rad=camber,
        camber_sd_rad=camber_sd,
        geometry=geometry,
        warnings=(
            *_on_distances(geometry, distance, distance_sd, mismatch, mismatch_sd),
            *_on_camber(geometry, camber, camber_sd),
        ),
    )


def _distances(
    recording: Recording,
    mount: WheelchairMount,
    yaw: FloatArray,
    speed: FloatArray,
    apart: FloatArray,
    turning: NDArray[np.bool_],
) -> tuple[float, float, float, float]:
    """Distance of the wheel centres and mismatch of the radii, each with its standard deviation."""
    moving = turning | (np.abs(speed) > 0.2)
    design = np.column_stack([yaw, speed, np.ones(len(yaw))])[moving]
    sizes = np.linalg.svd(design, compute_uv=False)
    if sizes[2] <= SMALLEST_INDEPENDENT_PART * sizes[0]:
        raise InputError(
            f"{recording.source}: the wheels' speed is constant or proportional to the yaw rate "
            "throughout, expected turns and straight lines; do both wheel sensors work?"
        )
    block = np.arange(len(yaw))[moving] // max(round(BLOCK_S * recording.sampling_rate_hz), 1)
    (distance, mismatch, _), covariance = _fit(design, apart[moving], block)
    left, right = (_gain_sd(mount.rotation_imu_to_wheel(side)[2]) for side in SIDES)
    # Gains g of the wheels change the difference of their speeds by (g_R - g_L) V, and by
    # (g_R + g_L) / 2 of what the turn makes of it.
    by_wheels = np.hypot(left, right)
    by_turn = np.hypot(by_wheels / 2, _gain_sd(mount.rotation_frame_imu_to_chair[2]))
    distance_sd = np.hypot(np.sqrt(covariance[0, 0]), distance * by_turn)
    mismatch_sd = np.hypot(np.sqrt(covariance[1, 1]), by_wheels)
    return float(distance), float(distance_sd), float(mismatch), float(mismatch_sd)


def _on_distances(
    geometry: WheelchairGeometry,
    distance: float,
    distance_sd: float,
    mismatch: float,
    mismatch_sd: float,
) -> list[str]:
    """Sentences on track and radii that do not fit, or on swapped sensors."""
    if distance < -max(TRACK_TOLERANCE_M, 3 * distance_sd):
        gain = distance / geometry.wheel_centre_distance_m
        return [
            f"the wheels turn against the frame (gain {gain:.2f}): left and right wheel sensor are "
            "swapped, or the frame's sensor is upside down"
        ]
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


def _on_camber(geometry: WheelchairGeometry, camber: float, camber_sd: float) -> list[str]:
    """Sentence on a camber that does not fit."""
    off = abs(camber - geometry.camber_rad)
    if not np.isfinite(camber) or off <= max(CAMBER_TOLERANCE_RAD, 3 * camber_sd):
        return []
    return [
        f"the rates across the axles fit a camber of {np.rad2deg(camber):.1f} deg, not "
        f"{np.rad2deg(geometry.camber_rad):.1f} deg"
    ]


def _fit(
    design: FloatArray, target: FloatArray, block: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Least squares and its covariance, from the scatter of whole blocks of residuals.

    Residuals of one block may depend on each other in any way (cluster-robust covariance).
    """
    found = np.asarray(np.linalg.lstsq(design, target, rcond=None)[0], float)
    scores = design * (target - design @ found)[:, None]
    starts = np.nonzero(np.diff(block, prepend=block[0] - 1))[0]
    sums = np.add.reduceat(scores, starts, axis=0)
    bread = np.linalg.inv(design.T @ design)
    unexplained = max(len(starts) - design.shape[1], 1)
    return found, bread @ (sums.T @ sums) @ bread * len(starts) / unexplained


def _gain_sd(axis_imu: FloatArray) -> float:
    """Relative uncertainty of the rate about an axis, from those of the sensor's scale and axes."""
    share = np.outer(axis_imu, axis_imu) ** 2
    on_axes = float(np.trace(share))
    across = float(share.sum()) - on_axes
    return float(
        np.hypot(
            GYROSCOPE_SCALE_SD * np.sqrt(on_axes),
            GYROSCOPE_MISALIGNMENT_SD_RAD * np.sqrt(max(across, 0.0)),
        )
    )


def _camber(
    left: FloatArray,
    right: FloatArray,
    yaw: FloatArray,
    turning: NDArray[np.bool_],
    yaw_gain_sd: float,
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
    # The wheels differ by what their gyroscopes read; the frame's errs for both alike.
    spread = float(np.hypot((cosines[0] - cosines[1]) / 2, yaw_gain_sd))
    cosine = min(float(np.mean(cosines)), 1.0)
    camber = float(np.arccos(cosine))
    return camber, float(spread / max(np.sin(camber), np.sqrt(2 * spread)))
