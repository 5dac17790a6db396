"""Where the three sensors of a chair contradict each other, and which of them is wrong.

Each wheel's sensor knows the chair's yaw rate by itself (:mod:`mobility_imu.wheelchair.turning`),
the frame's gyroscope reads it, and the wheels' speeds give it once more. Gravity shows each wheel's
spin. So of two that differ, a third tells the one at fault.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.offsets import (
    UNKNOWN_OFFSET_SD_RADPS,
    GyroscopeOffset,
    common_rest,
    merge_offsets,
    rest_offsets,
    without_offsets,
)
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.wheelchair.fits import fit_by_pieces, pieces_of
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelchairGeometry
from mobility_imu.wheelchair.lags import Lag, lag_between
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.recovery import tied_rate
from mobility_imu.wheelchair.turning import (
    SpinFit,
    spin_fit,
    up_in_plane,
    without_arm,
    yaw_rate_of_wheel,
)
from mobility_imu.wheelchair.uncertainty import AssumedErrors
from mobility_imu.wheelchair.velocity import VelocitySettings

__all__ = [
    "Gain",
    "SharedMotion",
    "axle_of",
    "gain_of",
    "lone_jumps",
    "steady_direction",
    "tilt_of",
]

SPINNING_RADPS = 1.0
"""A wheel from here on shows its axle."""
SHORTEST_SPINNING_S = 3.0
"""In less time a wheel goes round too rarely for the chair's turn to cancel across its axle."""
LEAST_SPUN_RAD = 6 * np.pi
"""Three turns of the wheel, in which what goes round across its axle cancels."""
UP_SD_RAD = 0.15
"""Up in a wheel's plane is known to this while the chair turns: where it turns as fast as the wheel
spins, as on the spot, so much of the turn is left across the axle. Set by hand on simulated courts
that the study of faults does not use."""
SLOW_TURN_RADPS = 0.3
"""Below it, the centripetal acceleration of a sensor beside the middle is under 0.03 m/s²."""
SHORTEST_SLOW_S = 3.0
"""In less time a chair that speeds up leans the force by some degrees throughout."""
LARGEST_PUSH_MPS2 = 1.0
"""Specific force within this of gravity, averaged over a second, shows up to 6 deg."""
LEAST_TURNED_RAD = np.pi
"""Half a turn in all, to whichever side, is needed to judge the frame's yaw rate."""
PIECE_S = 2.0
"""Residuals of one piece depend on each other: a stroke lasts about a second."""
MOST_FITS = 15
"""What is left out settles after a few fits; this ends those that go back and forth."""
ALIKE = 0.95
"""Correlation of two speeds of one wheel's centre: the wheels roll, and no name is exchanged. Set
by hand on simulated courts that the study of faults does not use."""


@dataclass(frozen=True, eq=False)
class Gain:
    """Factor and constant that turn one yaw rate into another.

    Parameters
    ----------
    gain, gain_sd : factor and standard deviation by the scatter
    constant_radps, constant_sd_radps : rad/s
    correlation : of the two
    """

    gain: float
    gain_sd: float
    constant_radps: float
    constant_sd_radps: float
    correlation: float


@dataclass(frozen=True, eq=False, repr=False)
class SharedMotion(Result):
    """What the sensors of a chair say of the same motion.

    Parameters
    ----------
    recording : Recording, as far as it is mended
    geometry : WheelchairGeometry
    mount : WheelchairMount
    given : offsets of other recordings
    failed : sensor to (n,) bool array, gyroscopes that fail
    settings : VelocitySettings
    mute : sensors that fail too long to judge others by: their gyroscope does, or an axis of it, or
        the accelerometer by which a wheel's gyroscope knows the yaw rate
    touched : (n,) bool array, samples that faults of one sensor touch; none if None
    blind : sensors whose accelerometer fails too long to show where up is
    """

    recording: Recording
    geometry: WheelchairGeometry
    mount: WheelchairMount
    given: Mapping[str, GyroscopeOffset]
    failed: Mapping[str, NDArray[np.bool_]]
    settings: VelocitySettings
    mute: frozenset[str] = frozenset()
    touched: NDArray[np.bool_] | None = None
    blind: frozenset[str] = frozenset()

    @cached_property
    def spoiled(self) -> NDArray[np.bool_]:
        """Samples in which some sensor shows a fault by itself."""
        none = np.zeros(len(self.recording), np.bool_)
        return none if self.touched is None else self.touched

    @cached_property
    def names(self) -> list[str]:
        """Sensors of the chair that the recording and the mount have."""
        mount, sensors = self.mount, self.recording.sensors
        there = {
            "frame": True,
            "left_wheel": mount.rotation_left_imu_to_wheel is not None,
            "right_wheel": mount.rotation_right_imu_to_wheel is not None,
        }
        return [
            n
            for n, has in there.items()
            if has and n in sensors and sensors[n].gyr_radps is not None
        ]

    @cached_property
    def sides(self) -> list[Side]:
        """Wheels by which others can be judged."""
        return [s for s in SIDES if f"{s}_wheel" in self.names and f"{s}_wheel" not in self.mute]

    @cached_property
    def rest(self) -> NDArray[np.bool_]:
        """Samples in which all sensors rest."""
        return common_rest(self.recording, self.names, skip=self.failed)

    @cached_property
    def own_offsets(self) -> dict[str, GyroscopeOffset]:
        """Offsets by rests of the recording itself."""
        return rest_offsets(self.recording, self.names, skip=self.failed, rest=self.rest)

    @cached_property
    def offsets(self) -> dict[str, GyroscopeOffset]:
        """Offsets that are taken off."""
        merged = merge_offsets(self.own_offsets, self.given)
        return {name: merged[name] for name in self.names if name in merged}

    @cached_property
    def at_rest(self) -> Recording:
        """The recording without its offsets."""
        return without_offsets(self.recording, self.offsets)

    @cached_property
    def rates(self) -> dict[str, FloatArray]:
        """Rates in the axes of the chair and of the wheels, (n, 3) arrays, rad/s."""
        return {name: self._turned(name, self.at_rest.gyroscope(name)) for name in self.names}

    @cached_property
    def forces(self) -> dict[str, FloatArray]:
        """Specific forces in these axes, (n, 3) arrays, m/s²."""
        return {n: self._turned(n, self.recording.sensor(n).acc_mps2) for n in self.names}

    def _turned(self, name: str, values: FloatArray) -> FloatArray:
        if name == "frame":
            return self.mount.frame(values)
        return self.mount.wheel("left" if name == "left_wheel" else "right", values)

    @property
    def errors(self) -> AssumedErrors:
        """Standard deviations of what no drive shows."""
        return self.settings.assumed

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.recording.sampling_rate_hz

    @cached_property
    def yaw(self) -> dict[str, FloatArray]:
        """Yaw rate that each sensor knows by itself, (n,) arrays, rad/s."""
        found = {"frame": self.rates["frame"][:, 2]}
        for side in self.sides:
            name = f"{side}_wheel"
            found[name] = yaw_rate_of_wheel(
                self.rates[name], self.forces[name], self.geometry.camber_rad, self.rate_hz
            )
        return {name: values for name, values in found.items() if name not in self.mute}

    @cached_property
    def by_gravity(self) -> FloatArray | None:
        """Mean of the yaw rates that the wheels' sensors know by themselves."""
        known = [self.yaw[f"{side}_wheel"] for side in self.sides]
        return np.mean(known, axis=0) if known else None

    @cached_property
    def by_speeds(self) -> FloatArray | None:
        """Yaw rate by the wheels' speeds (eq. 1.18)."""
        if len(self.sides) < 2:
            return None
        along = {f"{side}_wheel": self.rates[f"{side}_wheel"][:, 2] for side in SIDES}
        return tied_rate(along, "frame", self.geometry)

    def spin(self, side: Side) -> FloatArray:
        """Spin of a wheel; its own yaw rate takes the chair's turn out."""
        lean = self.geometry.axle_direction(side)[2]
        name = f"{side}_wheel"
        return np.asarray(self.rates[name][:, 2] - lean * self.yaw[name])

    @cached_property
    def spin_fits(self) -> dict[Side, SpinFit | None]:
        """Spin of each wheel by gravity against the gyroscope's."""
        return {
            side: spin_fit(self.forces[f"{side}_wheel"], self.spin(side), self.rate_hz)
            for side in self.sides
        }

    def offset_sd(self, name: str, axis: FloatArray) -> float:
        """Standard deviation of what an offset leaves along an axis of the sensor, rad/s.

        Parameters
        ----------
        name : sensor
        axis : (3,) array
        """
        known = self.offsets.get(name)
        return UNKNOWN_OFFSET_SD_RADPS if known is None else known.sd_along(axis)

    @cached_property
    def _known_lags(self) -> dict[tuple[str, str, int, int | None], Lag | None]:
        return {}

    def lag(self, first: str, second: str, *, sign: int = 1, half: int | None = None) -> Lag | None:
        """Lag of the yaw rate that one sensor knows after that of another one, found once.

        Parameters
        ----------
        first, second : sensors
        sign : -1 turns the second round
        half : 0 or 1, which half of the drive; the whole if None
        """
        key, known = (first, second, sign, half), self._known_lags
        if key not in known:
            one, two = self.yaw[first], sign * self.yaw[second]
            if half is not None:
                one, two = (np.array_split(yaw, 2)[half] for yaw in (one, two))
            known[key] = lag_between(one, two, self.rate_hz)
        return known[key]

    def _either_way(self, first: str, second: str) -> Lag | None:
        """Lag, whatever the sign of one of the two."""
        found = [self.lag(first, second, sign=sign) for sign in (1, -1)]
        return max((lag for lag in found if lag), key=lambda lag: lag.correlation, default=None)

    def lags(self) -> dict[tuple[str, str], Lag]:
        """Lag of the second sensor of each pair after the first."""
        yaw, rates, found = self.yaw, self.rates, {}
        for first, second in combinations(yaw, 2):
            lag = self._either_way(first, second)
            if lag is not None and lag.correlation > ALIKE and self.turns(second):
                found[first, second] = lag
        if len(self.sides) == 2:
            # The left sensor alone knows how fast the right wheel's centre moves.
            right = self.geometry.wheel_radius_m.right
            along = {"left_wheel": rates["left_wheel"][:, 2], "frame": yaw["left_wheel"]}
            expected = right * tied_rate(along, "right_wheel", self.geometry)
            lag = lag_between(expected, right * rates["right_wheel"][:, 2], self.rate_hz)
            known = found.get(("left_wheel", "right_wheel"))
            least = ALIKE if known is None else known.correlation
            if lag is not None and lag.correlation > least:
                found["left_wheel", "right_wheel"] = lag
        return found

    def turns(self, name: str) -> bool:
        """Whether the chair turns enough, as one of the sensors knows it.

        Parameters
        ----------
        name : sensor
        """
        return bool(np.abs(self.yaw[name]).sum() / self.rate_hz > LEAST_TURNED_RAD)


def gain_of(first: FloatArray, second: FloatArray, rate_hz: float) -> Gain | None:
    """Fit the second series by the first and a constant; scatter by whole pieces.

    Samples that lie far off (slip, a foot on the ground) are left out after a first fit.

    Parameters
    ----------
    first, second : (n,) arrays, rad/s
    rate_hz : samples per second

    Returns
    -------
    Gain, or None if the first turns too little
    """
    if np.abs(first).sum() / rate_hz < LEAST_TURNED_RAD or not second.any():
        return None
    design = np.column_stack([first, np.ones(len(first))])
    used = np.ones(len(first), np.bool_)
    for _ in range(MOST_FITS):
        part = design.T * used
        found = np.linalg.lstsq(part @ design, part @ second, rcond=None)[0]
        apart = np.abs(second - design @ found)
        before, used = used, apart <= max(3 * 1.48 * float(np.median(apart)), 0.02)
        if (used == before).all():
            break
    piece = pieces_of(len(first), PIECE_S, rate_hz)
    found, covariance = fit_by_pieces(design[used], second[used], piece[used])
    sd = np.sqrt(np.diag(covariance))
    correlation = float(np.corrcoef(first[used], second[used])[0, 1])
    return Gain(float(found[0]), float(sd[0]), float(found[1]), float(sd[1]), correlation)


FASTEST_UPRIGHT_RADPS = 2.5
"""A turn pulls a sensor on a wheel aside, by its distance from the axle times the square of the
rate: at 0.1 to 0.15 m and 2.5 rad/s by less than 1 m/s², 6 deg of up. In faster turns a wheel's
axle is not seen: at 3.5 to 5 rad/s sound ones were 15 deg off."""


def axle_of(shared: SharedMotion, side: Side) -> tuple[FloatArray, float] | None:
    """Axle of a wheel as a drive shows it, in its sensor's axes.

    The direction along which the rate's mean square is largest, once the part of the chair's turn,
    which goes round across the axle, is taken out.

    Parameters
    ----------
    shared : SharedMotion
    side : of the wheel

    Returns
    -------
    (3,) unit array, either way round, and its scatter: the largest of the root mean square across
    over along, the angle between the axles of both halves of the turning, and what the chair's own
    turn may leave; None if the wheel turns too little
    """
    name, rate = f"{side}_wheel", shared.rate_hz
    gyr = shared.at_rest.gyroscope(name)
    acc = shared.recording.sensor(name).acc_mps2
    fast = np.linalg.norm(gyr, axis=1) > SPINNING_RADPS
    if fast.sum() < SHORTEST_SPINNING_S * rate:
        return None
    _, directions = np.linalg.eigh(gyr[fast].T @ gyr[fast])
    axle, rest, turning = directions[:, -1], gyr, np.zeros(len(gyr))
    for _ in range(2):
        across = np.linalg.svd(axle[None, :])[2][1:]
        if np.linalg.det(np.vstack([across, axle])) < 0:
            across = across[::-1]
        # On a wheel's rim its spin pulls up aside, to one side in the sensor's axes.
        spin = gyr @ axle
        in_wheel = without_arm(acc @ np.vstack([across, axle]).T, spin, rate)
        up = up_in_plane(in_wheel[:, :2], spin, rate) @ across
        if np.abs(spin).sum() < LEAST_SPUN_RAD * rate:
            return None
        turning = (gyr * up).sum(axis=1)
        rest = gyr - turning[:, None] * up
        slow = fast & (np.abs(turning) < FASTEST_UPRIGHT_RADPS)
        if slow.sum() < SHORTEST_SPINNING_S * rate:
            return None
        axle, scatter = _main_direction(rest[slow])
    fast = slow
    halves = [_main_direction(half)[0] for half in np.array_split(rest[fast], 2)]
    apart = float(np.arccos(np.clip(abs(halves[0] @ halves[1]), 0.0, 1.0)))
    leak = UP_SD_RAD * float((turning[fast] ** 2).sum() / max((rest[fast] ** 2).sum(), 1e-12))
    return axle, max(scatter, apart, leak)


def _main_direction(rates: FloatArray) -> tuple[FloatArray, float]:
    """Direction of the largest mean square, and the root mean square across over along."""
    squares, directions = np.linalg.eigh(rates.T @ rates)
    scatter = float(np.sqrt(max(squares[0] + squares[1], 0.0) / max(squares[2], 1e-12)))
    return directions[:, -1], scatter


def steady_direction(force: FloatArray) -> float:
    """How steady a direction is: length of the mean of its unit vectors.

    Parameters
    ----------
    force : (n, 3) array

    Returns
    -------
    float, 1 if it never changes, near 0 if it goes round
    """
    size = np.maximum(np.linalg.norm(force, axis=1), 1e-9)
    return float(np.linalg.norm(np.mean(force / size[:, None], axis=0)))


def tilt_of(shared: SharedMotion) -> tuple[FloatArray, float] | None:
    """Up of the chair as the frame's accelerometer sees it over a drive, and how it scatters.

    Parameters
    ----------
    shared : SharedMotion

    Returns
    -------
    (3,) unit array in the chair's axes by the mount, and the length of the mean of all directions
    (1: gravity does not turn); None if the chair never goes steadily
    """
    rate = shared.rate_hz
    force = ndimage.uniform_filter1d(shared.forces["frame"], max(1, round(rate)), axis=0)
    size = np.linalg.norm(force, axis=1)
    calm = np.abs(size - STANDARD_GRAVITY_MPS2) < LARGEST_PUSH_MPS2
    length = steady_direction(force)
    turn = ndimage.uniform_filter1d(np.linalg.norm(shared.rates["frame"], axis=1), round(rate))
    slow = calm & (turn < SLOW_TURN_RADPS)
    slow &= ~shared.spoiled
    if slow.sum() < SHORTEST_SLOW_S * rate:
        return None  # a turn pulls a sensor beside the middle outward, by some degrees
    up = np.median(force[slow] / size[slow, None], axis=0)
    return np.asarray(up / np.linalg.norm(up)), length


JUMP_TIMES, JUMP_TAIL = 5.0, 2.8
"""A lone reading counts that is so many times beyond what nine of ten readings around it do, and
so many times beyond what two in a thousand of the whole recording do. Of sound readings that no
blow explains the largest are 3.3 and 1.9 times beyond: 60 simulated courts (seeds 48000 to 48014,
four sensors), six drives on four grounds, and sports chairs; these are half as large again."""
LEAST_JUMP_RADPS = 0.005
"""0.3 deg/s: twice what the yaw rate of a good sensor is known to."""
RAREST = 0.002
LEAST_LEVER_M = 0.05
"""A blow that turns a sensor within one sample also pushes it, at this distance from the axis."""


def lone_jumps(
    gyr_radps: FloatArray, acc_mps2: FloatArray, sampling_rate_hz: float
) -> NDArray[np.bool_]:
    """Single readings of a gyroscope that lie far off between neighbours that agree.

    A blow makes such readings too; the accelerometer beside it feels it.

    Parameters
    ----------
    gyr_radps, acc_mps2 : (n, 3) arrays, rad/s and m/s²
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) bool array
    """
    count, window = len(gyr_radps), 2 * round(sampling_rate_hz / 2) + 1
    far = np.zeros(count, np.bool_)
    if count < window:
        return far
    bends = np.zeros(count)
    change = acc_mps2[1:-1] - (acc_mps2[:-2] + acc_mps2[2:]) / 2
    bends[1:-1] = np.linalg.norm(change, axis=1)
    felt = ndimage.maximum_filter1d(bends, 5)
    for axis in gyr_radps.T:
        # Beside a lone reading the bend is half as large, the other way; at a kink it is zero.
        bend = np.zeros(count)
        bend[1:-1] = axis[1:-1] - (axis[:-2] + axis[2:]) / 2
        size = np.abs(bend)
        usual = ndimage.percentile_filter(size, 90, size=window)
        agree = np.zeros(count, np.bool_)
        agree[2:-2] = (np.abs(axis[3:-1] - axis[1:-3]) < size[2:-2] / 2) & (
            np.abs(bend[1:-3] + bend[2:-2] / 2) + np.abs(bend[3:-1] + bend[2:-2] / 2)
            < size[2:-2] / 2
        )
        times = np.where(agree, size / np.maximum(usual, 1e-3), 0.0)
        least = max(JUMP_TIMES, JUMP_TAIL * float(np.quantile(times, 1 - RAREST)))
        blow = felt > LEAST_LEVER_M * size * sampling_rate_hz
        far |= (times > least) & (size > LEAST_JUMP_RADPS) & ~blow
    return far
