"""Is the geometry right? The frame's gyroscope knows the turns; the wheels must agree.

With the no-slip speeds of the wheel centres, r_R Om_R - r_L Om_L = d_c * yaw + c * V. A
least-squares fit gives the distance d_c that the data have, and with c the mismatch of the radii;
the rate across the axle gives the camber, whatever the distances are.
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
# Below this, yaw rate and speed tell no track from a mismatch of the radii.
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

    The absolute size of the radii cannot be checked this way: only a known distance shows it.

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
        seconds in all, or its speed goes with its yaw rate throughout.
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
    moving = turning | (np.abs(speed) > 0.2)
    design = np.column_stack([yaw, speed])[moving]
    sizes = np.linalg.svd(design, compute_uv=False)
    if sizes[1] <= SMALLEST_INDEPENDENT_PART * sizes[0]:
        raise InputError(
            f"{recording.source}: the wheels' speed is proportional to the yaw rate throughout, "
            "expected turns and straight lines; do both wheel sensors work?"
        )
    (distance, mismatch), distance_sd, mismatch_sd = _fit(design, apart[moving], fs)
    gains = [
        float((apart - mismatch * speed)[way] @ yaw[way] / (yaw[way] @ yaw[way]))
        / geometry.wheel_centre_distance_m
        if way.sum() >= SHORTEST_TURNING_S / 2 * fs
        else float("nan")
        for way in (turning & (yaw > 0), turning & (yaw < 0))
    ]
    camber, camber_sd = _camber(wheels[0], wheels[1], yaw, turning)
    lean = geometry.track_m - geometry.wheel_centre_distance_m
    return GeometryCheck(
        yaw_gain_left=gains[0],
        yaw_gain_right=gains[1],
        track_m=float(distance + lean),
        track_sd_m=distance_sd,
        # A radius mismatch e adds e times the speed; the ratio that fits is 1 - e (first order).
        radius_ratio=float(1 - mismatch),
        radius_ratio_sd=mismatch_sd,
        camber_rad=camber,
        camber_sd_rad=camber_sd,
        geometry=geometry,
        warnings=(
            *_on_distances(geometry, float(distance), distance_sd, float(mismatch), mismatch_sd),
            *_on_camber(geometry, camber, camber_sd),
        ),
    )


def _on_distances(
    geometry: WheelchairGeometry,
    distance: float,
    distance_sd: float,
    mismatch: float,
    mismatch_sd: float,
) -> list[str]:
    """Sentences on track and radii that do not fit, or on swapped sensors."""
    if distance < 0:
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
    if abs(mismatch) > max(RADIUS_TOLERANCE, 3 * mismatch_sd):
        sentences.append(
            "driving straight, the wheels differ: the right radius over the left one should be "
            f"{1 - mismatch:.4f} times what is given"
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


def _fit(design: FloatArray, target: FloatArray, fs: float) -> tuple[FloatArray, float, float]:
    """Least squares; residuals last about a push, so a second counts as one observation."""
    found = np.asarray(np.linalg.lstsq(design, target, rcond=None)[0], float)
    residual = target - design @ found
    independent = max(len(target) / fs, 3.0)
    covariance = np.linalg.inv(design.T @ design) * residual.var() * len(target) / independent
    return found, float(np.sqrt(covariance[0, 0])), float(np.sqrt(covariance[1, 1]))


def _camber(
    left: FloatArray, right: FloatArray, yaw: FloatArray, turning: NDArray[np.bool_]
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
    spread = abs(cosines[0] - cosines[1]) / 2 + 0.003  # 0.3 % scale of a gyroscope
    cosine = min(float(np.mean(cosines)), 1.0)
    camber = float(np.arccos(cosine))
    return camber, float(spread / max(np.sin(camber), np.sqrt(2 * spread)))
