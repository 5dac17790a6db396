"""A chair's inertial sensors beside motion capture: clock shift, agreement, calibration cuts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.datasets.series import longest_run, low_pass
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.readers.optitrack import Poses
from mobility_imu.recording import Recording
from mobility_imu.results import Result

if TYPE_CHECKING:
    import pandas as pd

FRAME_RATE_HZ = 120.0
CUTOFF_HZ = 3.0
BRIDGED_FRAMES = 6
"""Gaps up to 50 ms are interpolated."""
MARGIN_FRAMES = 32
"""Unused frames on both sides of a longer gap; there the low-pass knows too little."""
FEWEST_FRAMES = 300
SEARCH_S = (-3.0, 5.0)
"""Motion capture begins within these times of the recording's start."""
SHORTEST_WAY_M = 5.0
LARGEST_MISFIT_MPS = 0.05


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Result):
    """What motion capture says of the chair.

    Parameters
    ----------
    time_s : (n,) array, s, of the frames
    good : (n,) bool array, where the cameras saw it, with margins
    yaw_rate_radps : (n,) array, rad/s, positive to the left
    velocity_mps : (n, 2) array, m/s, horizontal, in axes that turn with the body
    """

    time_s: FloatArray
    good: NDArray[np.bool_]
    yaw_rate_radps: FloatArray
    velocity_mps: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Agreement(Result):
    """How a recording agrees with motion capture, once one clock shift is fitted.

    Parameters
    ----------
    motion : what motion capture says
    used : (n,) bool array, frames that are good and inside the recording
    begin_s : s, when the capture begins on the recording's clock
    speed_mps : (n,) array, m/s, along the chair's forward axis
    radius_m, half_track_m : m, of the right wheel, by least squares
    wheel_misfit_mps : m/s, standard deviation of wheel speed against capture
    correlation, gain : of the frame's gyroscope along the vertical with the yaw rate
    path_m : m, way in sight
    fastest_mps : m/s
    """

    motion: Motion
    used: NDArray[np.bool_]
    begin_s: float
    speed_mps: FloatArray
    radius_m: float
    half_track_m: float
    wheel_misfit_mps: float
    correlation: float
    gain: float
    path_m: float
    fastest_mps: float

    def fault(self) -> str:
        """Why the truth of this trial is not sound; empty if it is."""
        if not self.correlation > 0.99:
            return "yaw rates do not correlate"
        if not 0.97 < self.gain < 1.03:
            return "yaw rates differ in size"
        if not self.wheel_misfit_mps < LARGEST_MISFIT_MPS:
            return "wheel and capture differ: slip, or the capture is bad"
        if not self.path_m > SHORTEST_WAY_M or not self.used.sum() > 5 * FRAME_RATE_HZ:
            return "too short a way in sight"
        return ""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A person's longest rest and longest steady straight way.

    Parameters
    ----------
    static, straight : tables of the canonical CSV, on the clock of the trial they are from
    """

    static: pd.DataFrame
    straight: pd.DataFrame

    @property
    def shortest(self) -> int:
        """Samples of the shorter of the two."""
        return min(len(self.static), len(self.straight))


def motion_of(poses: Poses) -> Motion:
    """Yaw rate and horizontal velocity of a body whose y axis points up.

    Parameters
    ----------
    poses : of motion capture

    Returns
    -------
    Motion

    Raises
    ------
    InputError
        If the body is seen in fewer than 300 frames.
    """
    values = np.column_stack([poses.quaternion, poses.position_m])
    seen = np.flatnonzero(np.isfinite(values).all(axis=1))
    if len(seen) < FEWEST_FRAMES:
        raise InputError(f"motion capture sees the chair in {len(seen)} frames only")
    known = values[seen].copy()
    # A quaternion and its negative are one rotation: keep to one side, to interpolate.
    turned = np.sum(known[1:, :4] * known[:-1, :4], axis=1) < 0
    known[1:, :4] *= np.where(np.cumsum(turned) % 2, -1.0, 1.0)[:, None]
    time_s = poses.time_s
    whole = np.column_stack([np.interp(time_s, time_s[seen], axis) for axis in known.T])
    good = np.ones(len(time_s), np.bool_)
    good[: seen[0] + MARGIN_FRAMES] = False
    good[max(0, seen[-1] - MARGIN_FRAMES) :] = False
    for k in np.flatnonzero(np.diff(seen) > BRIDGED_FRAMES):
        good[max(0, seen[k] - MARGIN_FRAMES) : seen[k + 1] + MARGIN_FRAMES] = False
    ahead = Rotation.from_quat(whole[:, :4]).apply([1.0, 0.0, 0.0])
    yaw = np.unwrap(np.arctan2(-ahead[:, 2], ahead[:, 0]))
    velocity = _low(np.gradient(whole[:, 4:], time_s, axis=0))
    cos, sin = np.cos(yaw), np.sin(yaw)
    horizontal = np.column_stack(
        [
            velocity[:, 0] * cos - velocity[:, 2] * sin,
            velocity[:, 0] * sin + velocity[:, 2] * cos,
        ]
    )
    return Motion(time_s, good, _low(np.gradient(yaw, time_s)), horizontal)


def agreement(recording: Recording, poses: Poses) -> Agreement:
    """Agreement of a recording with motion capture.

    Parameters
    ----------
    recording : sensors ``frame`` and ``right_wheel``, whose axle is its x
    poses : of the chair

    Returns
    -------
    Agreement

    Raises
    ------
    InputError
        If the chair is hardly seen, or no clock shift joins the two.
    """
    motion = motion_of(poses)
    fitter = _Fitter.of(recording, motion)
    begin_s, fit = fitter.best()
    if fit is None:
        raise InputError(f"{recording.source}: no clock shift joins sensors and motion capture")
    used, wheel_per = fit.used, fit.wheel_per
    seen = np.column_stack([motion.velocity_mps, motion.yaw_rate_radps])[used]
    speed = motion.velocity_mps @ _forward(seen, wheel_per)
    if np.median(speed[used & (np.abs(speed) > 0.3)]) < 0:
        speed = -speed
    per_speed, per_turn = np.linalg.lstsq(
        np.column_stack([speed, motion.yaw_rate_radps])[used], seen @ wheel_per
    )[0]
    return Agreement(
        motion=motion,
        used=used,
        begin_s=float(begin_s),
        speed_mps=speed,
        radius_m=float(abs(1 / per_speed)),
        half_track_m=float(abs(per_turn / per_speed)),
        wheel_misfit_mps=fit.misfit_mps,
        correlation=fit.correlation,
        gain=fit.gain,
        path_m=float(np.abs(speed[used]).sum() / FRAME_RATE_HZ),
        fastest_mps=float(np.abs(speed[used]).max()),
    )


def _forward(seen: FloatArray, wheel_per: FloatArray) -> FloatArray:
    """Forward axis: that along which the axle does not slide sideways.

    If the data do not tell (the axis with the least motion is no velocity), that which the wheel
    follows.
    """
    across = np.linalg.eigh(seen.T @ seen)[1][:, 0]
    size = np.hypot(*across[:2])
    if size < 0.5:
        return np.asarray(wheel_per[:2] / np.hypot(*wheel_per[:2]))
    return np.asarray(np.array([across[1], -across[0]]) / size)


@dataclass(frozen=True, eq=False)
class _Fit:
    """Result at one clock shift."""

    used: NDArray[np.bool_]
    wheel_per: FloatArray
    misfit_mps: float
    correlation: float
    gain: float


@dataclass(frozen=True, eq=False)
class _Fitter:
    """Yaw rate and wheel rate of the sensors, low-passed at the capture's rate, and the capture."""

    time_s: FloatArray
    yaw: FloatArray
    wheel: FloatArray
    motion: Motion

    @classmethod
    def of(cls, recording: Recording, motion: Motion) -> _Fitter:
        up = np.median(recording.sensor("frame").acc_mps2, axis=0)
        up /= np.linalg.norm(up)
        fine = np.arange(0, recording.time_s[-1], 1 / FRAME_RATE_HZ)
        if len(fine) < FEWEST_FRAMES / 2:
            raise InputError(f"{recording.source}: too short to be put beside motion capture")
        yaw, wheel = (
            _low(np.interp(fine, recording.time_s, rate))
            for rate in (
                recording.gyroscope("frame") @ up,
                recording.gyroscope("right_wheel")[:, 0],
            )
        )
        return cls(fine, yaw, wheel, motion)

    def best(self) -> tuple[float, _Fit | None]:
        """Clock shift with the least misfit, to 2 ms, and the fit there."""
        begin = min(np.arange(*SEARCH_S, 0.02), key=lambda b: self.at(b)[0])
        begin = min(np.arange(begin - 0.03, begin + 0.031, 0.002), key=lambda b: self.at(b)[0])
        return begin, self.at(begin)[1]

    def at(self, begin_s: float) -> tuple[float, _Fit | None]:
        """Misfit and fit if the capture begins at this time."""
        motion = self.motion
        at = begin_s + motion.time_s
        used = motion.good & (at > 0.2) & (at < self.time_s[-1] - 0.2)
        if used.sum() < max(200, 0.6 * motion.good.sum()):
            return 9.0, None
        yaw = np.interp(at[used], self.time_s, self.yaw)
        wheel = np.interp(at[used], self.time_s, self.wheel)
        rate = motion.yaw_rate_radps[used]
        line = np.polyfit(rate, yaw, 1)
        seen = np.column_stack([motion.velocity_mps, motion.yaw_rate_radps])[used]
        wheel_per = np.linalg.lstsq(seen, wheel)[0]
        misfit = float(np.std(wheel - seen @ wheel_per) / np.hypot(*wheel_per[:2]))
        total = misfit + 0.3 * float(np.std(yaw - np.polyval(line, rate)))
        correlation = float(np.corrcoef(rate, yaw)[0, 1])
        return total, _Fit(used, wheel_per, misfit, correlation, float(line[0]))


def truth_table(time_s: FloatArray, fit: Agreement) -> dict[str, FloatArray]:
    """Speed and yaw rate at the recording's times; NaN where the capture is not usable.

    Parameters
    ----------
    time_s : (n,) array, s, of the recording
    fit : of the same recording

    Returns
    -------
    dict of columns
    """
    columns = {"time_s": time_s}
    clock = fit.begin_s + fit.motion.time_s
    for name, values in (
        ("speed_mps", fit.speed_mps),
        ("yaw_rate_radps", fit.motion.yaw_rate_radps),
    ):
        known = np.where(fit.used, values, np.nan)
        columns[name] = np.interp(time_s, clock, known, left=np.nan, right=np.nan)
    return columns


def cut_calibration(recordings: Mapping[str, Recording]) -> Calibration:
    """A person's longest rest, and the longest steady straight way of the straight pushes.

    Parameters
    ----------
    recordings : name of the task to recording; at least one

    Returns
    -------
    Calibration; its tables are empty where there is no such part
    """
    import pandas as pd

    rests, ways = [pd.DataFrame()], [pd.DataFrame()]
    for task, recording in recordings.items():
        table = recording.to_frame()
        rates = np.hstack([recording.gyroscope(name) for name in recording.sensors])
        turning = pd.Series(np.sqrt((rates**2).sum(axis=1)))
        turning = turning.rolling(15, center=True, min_periods=1).max()
        rests.append(table.iloc[longest_run(turning < 0.06)].iloc[:250])
        if task.startswith("straightpush"):
            wheel = _steady(recording.gyroscope("right_wheel")[:, 0])
            frame = _steady(recording.gyroscope("frame")[:, 0])
            ways.append(table.iloc[longest_run((wheel > 2) & (frame < 0.12))])
    return Calibration(max(rests, key=len), max(ways, key=len))


def camber_from_gravity(straight: pd.DataFrame) -> float:
    """Lean of the right wheel: gravity along its axle, mean over whole turns.

    Parameters
    ----------
    straight : table of a straight way

    Returns
    -------
    float, rad; NaN if the wheel does not turn once
    """
    rate = straight["right_wheel_gyr_x_radps"].to_numpy()
    turned = np.abs(np.cumsum(rate) * 0.02)
    if not len(turned) or turned[-1] <= 2 * np.pi:
        return np.nan
    whole = turned <= turned[-1] // (2 * np.pi) * 2 * np.pi
    along = straight["right_wheel_acc_x_mps2"].to_numpy()[whole] / STANDARD_GRAVITY_MPS2
    mean = abs(np.average(along, weights=np.abs(rate[whole])))
    return float(np.arcsin(min(mean, 1.0)))


def _low(values: FloatArray) -> FloatArray:
    return low_pass(values, CUTOFF_HZ, FRAME_RATE_HZ)


def _steady(rate: FloatArray) -> FloatArray:
    """Size of the mean of a centred window of 0.2 s."""
    import pandas as pd

    return np.asarray(pd.Series(rate).rolling(10, center=True, min_periods=1).mean().abs(), float)
