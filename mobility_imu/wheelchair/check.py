"""Is the geometry right? The frame's gyroscope knows the turns; the wheels must agree.

With the no-slip speeds of the wheel centres, r_R Om_R - r_L Om_L = d_c * yaw + c * V. A
least-squares fit gives the distance d_c that the data have, and with c the mismatch of the radii;
the rate across the axle gives the camber, whatever the distances are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.calibration import WheelchairCalibration
from mobility_imu.wheelchair.geometry import WheelchairGeometry

SLOWEST_TURN_RADPS = 0.3
SHORTEST_TURNING_S = 2.0
# What a tape can do: a centimetre of track, a degree of camber, half a percent of radius.
TRACK_TOLERANCE_M = 0.01
CAMBER_TOLERANCE_RAD = float(np.deg2rad(2.0))
RADIUS_TOLERANCE = 0.005


@dataclass(frozen=True)
class GeometryCheck:
    """What a drive says of the geometry it is analysed with.

    Parameters
    ----------
    yaw_gain_left, yaw_gain_right : wheels' yaw rate over the frame's, in left and in right turns;
        1 is right; NaN without enough of such turns
    track_m, track_sd_m : track that fits the turns, with radii and camber as given
    radius_ratio, radius_ratio_sd : factor on right over left radius that fits (1: as given)
    camber_rad, camber_sd_rad : camber from the rate across the axles
    messages : what is wrong, by how much, in words; empty if all fits
    """

    yaw_gain_left: float
    yaw_gain_right: float
    track_m: float
    track_sd_m: float
    radius_ratio: float
    radius_ratio_sd: float
    camber_rad: float
    camber_sd_rad: float
    messages: tuple[str, ...]


def check_geometry(
    trial: Recording, calibration: WheelchairCalibration, geometry: WheelchairGeometry
) -> GeometryCheck:
    """Compare the wheels with the frame over a drive with turns.

    The absolute size of the radii cannot be checked this way: only a known distance shows it.

    Parameters
    ----------
    trial : Recording with sensors frame, left_wheel, right_wheel
    calibration : from :func:`mobility_imu.wheelchair.calibration.calibrate`
    geometry : WheelchairGeometry to be checked

    Returns
    -------
    GeometryCheck

    Raises
    ------
    InputError
        If the chair turns for less than two seconds in all.
    """
    frame = np.asarray(trial.sensor("frame", gyroscope=True).gyr_radps)
    yaw = frame @ calibration.rotation_frame_imu_to_chair[2]
    wheels = {
        side: np.asarray(trial.sensor(f"{side}_wheel", gyroscope=True).gyr_radps) @ rotation.T
        for side, rotation in (
            ("left", calibration.rotation_left_imu_to_wheel),
            ("right", calibration.rotation_right_imu_to_wheel),
        )
    }
    turning = np.abs(yaw) > SLOWEST_TURN_RADPS
    fs = trial.sampling_rate_hz
    if turning.sum() < SHORTEST_TURNING_S * fs:
        raise InputError(
            f"{trial.source}: {turning.sum() / fs:.1f} s of turning faster than "
            f"{SLOWEST_TURN_RADPS} rad/s, expected at least {SHORTEST_TURNING_S} s to check with"
        )
    radius = geometry.wheel_radius_m
    left, right = radius.left * wheels["left"][:, 2], radius.right * wheels["right"][:, 2]
    speed, apart = (left + right) / 2, right - left
    moving = turning | (np.abs(speed) > 0.2)
    design = np.column_stack([yaw, speed])[moving]
    (distance, mismatch), distance_sd, mismatch_sd = _fit(design, apart[moving], fs)
    lean = geometry.track_m - geometry.wheel_centre_distance_m
    gains = [
        float((apart - mismatch * speed)[way] @ yaw[way] / (yaw[way] @ yaw[way]))
        / geometry.wheel_centre_distance_m
        if way.sum() >= SHORTEST_TURNING_S / 2 * fs
        else np.nan
        for way in (turning & (yaw > 0), turning & (yaw < 0))
    ]
    camber, camber_sd = _camber(wheels["left"], wheels["right"], yaw, turning)
    # apart = (1 + e/2) right - (1 - e/2) left has the speed term e: undo it on the ratio.
    ratio = 1 - mismatch
    messages = []
    if distance < 0:
        gain = distance / geometry.wheel_centre_distance_m
        messages.append(
            f"the wheels turn against the frame (gain {gain:.2f}): left and right wheel sensor are "
            "swapped, or the frame's sensor is upside down"
        )
    else:
        off = distance + lean - geometry.track_m
        resized = geometry.track_m / (distance + lean) - 1  # they set the scale and the lean
        if abs(off) > max(TRACK_TOLERANCE_M, 3 * distance_sd):
            messages.append(
                f"the turns fit a track of {distance + lean:.3f} m, not {geometry.track_m:.3f} m "
                f"({off:+.3f} m); or both radii should be {resized:+.1%} of what is given, or the "
                "camber is off"
            )
        if abs(mismatch) > max(RADIUS_TOLERANCE, 3 * mismatch_sd):
            messages.append(
                "driving straight, the wheels differ: the right radius over the left one should be "
                f"{ratio:.4f} times what is given"
            )
    tilt = camber - geometry.camber_rad
    if np.isfinite(camber) and abs(tilt) > max(CAMBER_TOLERANCE_RAD, 3 * camber_sd):
        messages.append(
            f"the rates across the axles fit a camber of {np.rad2deg(camber):.1f} deg, not "
            f"{np.rad2deg(geometry.camber_rad):.1f} deg"
        )
    return GeometryCheck(
        yaw_gain_left=gains[0],
        yaw_gain_right=gains[1],
        track_m=float(distance + lean),
        track_sd_m=distance_sd,
        radius_ratio=float(ratio),
        radius_ratio_sd=mismatch_sd,
        camber_rad=camber,
        camber_sd_rad=camber_sd,
        messages=tuple(messages),
    )


def _fit(design: np.ndarray, target: np.ndarray, fs: float) -> tuple[np.ndarray, float, float]:
    """Least squares; residuals last about a push, so a second counts as one observation."""
    found, *_ = np.linalg.lstsq(design, target, rcond=None)
    residual = target - design @ found
    independent = max(len(target) / fs, 3.0)
    covariance = np.linalg.inv(design.T @ design) * residual.var() * len(target) / independent
    return found, float(np.sqrt(covariance[0, 0])), float(np.sqrt(covariance[1, 1]))


def _camber(
    left: np.ndarray, right: np.ndarray, yaw: np.ndarray, turning: np.ndarray
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
