"""Constant offsets of gyroscopes, found while the device rests.

A gyroscope that stands still reads its offset: 0.2 deg/s is usual, 3 deg/s are found on cheap ones.
Integrated over half a minute, 1 deg/s is a turn of 30 deg that never was. Rests are found without
knowing the offset: a sensor rests while neither its rates nor its specific force change.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_flags, as_number, as_vectors, shown
from mobility_imu.names import as_names
from mobility_imu.quality import LARGEST_OFFSET_RADPS
from mobility_imu.recording import Imu, Recording
from mobility_imu.results import Result
from mobility_imu.runs import long_runs, runs_of

__all__ = [
    "LARGE_OFFSET_RADPS",
    "LARGE_SD_RADPS",
    "UNKNOWN_OFFSET_SD_RADPS",
    "GyroscopeOffset",
    "RestBlocks",
    "check_offsets",
    "common_rest",
    "gyroscope_offset",
    "merge_offsets",
    "offset_warnings",
    "rest_blocks",
    "rest_flags",
    "rest_offsets",
    "without_offsets",
]

LARGEST_READING = 1e6
"""Of a rate or an acceleration, in rad/s and m/s²; squares of it can be summed."""
WINDOW_S = 1.0
"""Length over which rates and specific force must not change."""
LARGEST_WOBBLE_RADPS = 0.05
"""Root mean square of the rates about their mean: a person who sits in a chair stays below a third
of it, a device held in the hand below all of it."""
LARGEST_SWAY_MPS2 = 0.15
"""The same of the specific force: gravity moves by more on a wheel that turns by 3 deg in a
second."""
VIBRATION_S = 0.25
"""Specific force is averaged over this, so that an idling motor does not pass for a motion."""
EDGE_S = 0.25
"""Left off at each end of a rest: there a motion may begin."""
BLOCK_S = 0.5
"""A rest is cut into blocks of this length, whose means are taken for independent."""
SHORTEST_REST_S = 1.0
LARGE_OFFSET_RADPS = float(np.deg2rad(1.0))
"""From this size on a warning states the offset, which makes 30 deg in half a minute."""
LARGE_SD_RADPS = float(np.deg2rad(0.5))
"""From this uncertainty on too."""
UNKNOWN_OFFSET_SD_RADPS = float(np.deg2rad(0.5))
"""Offset of a usual sensor without a known rest; 0.5 deg/s in the data sheet of the MTi-1."""
DRIFT_SD_RADPS = float(np.deg2rad(0.1))
"""Change of an offset between two recordings of one day: warming up by some degrees, at 0.02 to
0.05 (deg/s)/K of usual data sheets."""
IN_RUN_SD_RADPS = float(np.deg2rad(0.01))
"""Change of an offset within a recording (usual data sheets: 5 to 40 deg/h)."""
FARTHEST_BLOCK = 3.0
"""Blocks farther from the middle one than this times the median distance are taken for motions."""
MOST_COMPARED = 2000
"""Blocks of which each is compared with each: a quarter of an hour of rest."""
LARGEST_CHI_SQUARE = 16.3
"""Of three numbers, passed by chance once in a thousand times."""
LARGEST_T_VARIANCE = 3.0
"""Student's distribution of a mean of few blocks is wider than the normal one, at most by this."""


@dataclass(frozen=True, eq=False, repr=False)
class GyroscopeOffset(Result):
    """Constant offset of one gyroscope, in the sensor's axes.

    Parameters
    ----------
    offset_radps : (3,) array, rad/s, what the gyroscope reads at rest
    covariance : (3, 3) array, rad²/s², of the offset
    noise_radps : (3,) array, rad/s, standard deviation of one sample about it, by the differences
        of neighbours at rest; slow wobble is not in it
    rest_s : s of rest that it was found from
    """

    offset_radps: FloatArray
    covariance: FloatArray
    noise_radps: FloatArray
    rest_s: float

    def __post_init__(self) -> None:
        """Check shapes and signs."""
        for name in ("offset_radps", "noise_radps"):
            vector = as_vectors(getattr(self, name), name, ndim=1, finite=True)
            object.__setattr__(self, name, vector)
        if (self.noise_radps < 0).any():
            raise InputError(f"noise_radps: expected 0 or more, got {self.noise_radps}")
        covariance = as_vectors(self.covariance, "covariance", length=3, finite=True)
        if (np.diag(covariance) < 0).any() or np.abs(covariance - covariance.T).max() > 1e-9:
            raise InputError("covariance: expected a symmetric matrix without negative variances")
        object.__setattr__(self, "covariance", covariance)
        object.__setattr__(self, "rest_s", as_number(self.rest_s, "rest_s", zero=True))
        super().__post_init__()

    @property
    def sd_radps(self) -> FloatArray:
        """Standard deviations of the offset along the sensor's axes, (3,) array, rad/s."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def sd_along(self, axis: ArrayLike) -> float:
        """Standard deviation in rad/s of the offset along one direction.

        Parameters
        ----------
        axis : (3,) array, unit vector in the sensor's axes
        """
        unit = _readings(axis, "axis", ndim=1)
        return float(np.sqrt(max(float(unit @ self.covariance @ unit), 0.0)))

    def noise_along(self, axis: ArrayLike) -> float:
        """Standard deviation in rad/s of one sample's noise along one direction.

        Parameters
        ----------
        axis : (3,) array, unit vector in the sensor's axes
        """
        return float(np.linalg.norm(_readings(axis, "axis", ndim=1) * self.noise_radps))


def rest_flags(
    acc_mps2: ArrayLike, gyr_radps: ArrayLike, sampling_rate_hz: float
) -> NDArray[np.bool_]:
    """Where one sensor rests: neither its rates nor its specific force change for a second.

    A constant offset does not matter. A steady turn about the vertical looks like a rest to one
    sensor alone; other sensors of the device tell it (:func:`rest_offsets`).

    Parameters
    ----------
    acc_mps2, gyr_radps : (n, 3) arrays
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) bool array; empty of rests if the recording is shorter than one second

    Raises
    ------
    InputError
        If the arrays are no series of three real numbers, differ in length, or hold what no
        sensor reads.
    """
    acc = _readings(acc_mps2, "acc_mps2", ndim=2)
    gyr = _readings(gyr_radps, "gyr_radps", length=len(acc))
    rate = as_number(sampling_rate_hz, "sampling_rate_hz")
    window = max(3, round(WINDOW_S * rate))
    if len(acc) < window:
        return np.zeros(len(acc), np.bool_)
    slow = ndimage.uniform_filter1d(acc, max(1, round(VIBRATION_S * rate)), axis=0)
    quiet = (_spread(gyr, window) <= LARGEST_WOBBLE_RADPS) & (
        _spread(slow, window) <= LARGEST_SWAY_MPS2
    )
    begun = np.zeros(len(acc) + window, np.intp)
    begun[window : window + len(quiet)] = quiet
    begun = np.cumsum(begun)
    return np.asarray(begun[window:] > begun[:-window])


def _readings(values: ArrayLike, name: str, **shape: int) -> FloatArray:
    """Vectors whose squares can be summed."""
    vectors = as_vectors(values, name, finite=True, **shape)
    largest = float(np.abs(vectors).max(initial=0.0))
    if largest > LARGEST_READING:
        raise InputError(
            f"{name}: reaches {largest:.4g}, more than any sensor reads; remove that sample, or "
            "check the unit"
        )
    return vectors


def _spread(values: FloatArray, window: int) -> FloatArray:
    """Root mean square about the mean in each window that lies inside, by its first sample."""
    x, y, z = (axis - axis.mean() for axis in values.T)
    mean_square = _means(x**2 + y**2 + z**2, window)
    square_mean = _means(x, window) ** 2 + _means(y, window) ** 2 + _means(z, window) ** 2
    return np.asarray(np.sqrt(np.maximum(mean_square - square_mean, 0.0)))


def _means(values: FloatArray, window: int) -> FloatArray:
    """Mean of each window that lies inside."""
    sums = np.zeros(len(values) + 1)
    np.cumsum(values, out=sums[1:])
    return (sums[window:] - sums[:-window]) / window


class RestBlocks(NamedTuple):
    """Half seconds of rest of one gyroscope.

    Parameters
    ----------
    first : (k,) int array, their first samples
    length : samples of each
    mean_radps : (k, 3) array, rad/s
    noise_radps : (3,) array, rad/s, of one sample, by the differences of neighbours
    """

    first: NDArray[np.int64]
    length: int
    mean_radps: FloatArray
    noise_radps: FloatArray


def rest_blocks(gyr_radps: ArrayLike, rest: ArrayLike, sampling_rate_hz: float) -> RestBlocks:
    """Means of the half seconds in which one gyroscope rests, without both ends of each rest.

    Parameters
    ----------
    gyr_radps : (n, 3) array, rad/s
    rest : (n,) flags, as from :func:`rest_flags`
    sampling_rate_hz : Hz

    Returns
    -------
    RestBlocks, in the order of time
    """
    gyr = _readings(gyr_radps, "gyr_radps", ndim=2)
    flags = as_flags(rest, "rest", length=len(gyr))
    rate = as_number(sampling_rate_hz, "sampling_rate_hz")
    # No block fits into fewer samples than it has.
    block, edge = (min(round(s * rate), len(gyr) + 1) for s in (BLOCK_S, EDGE_S))
    block = max(2, block)
    firsts, means, noise = [np.zeros(0, np.int64)], [np.zeros((0, 3))], [np.zeros((0, 3))]
    for run in runs_of(flags):
        # The recording's own ends are no motion.
        start = run.start + (edge if run.start else 0)
        stop = run.stop - (edge if run.stop < len(gyr) else 0)
        count = max(stop - start, 0) // block
        parts = gyr[start : start + count * block].reshape(count, block, 3)
        firsts.append(start + block * np.arange(count))
        means.append(parts.mean(axis=1))
        noise.append(np.diff(parts, axis=1).reshape(-1, 3))
    changes = np.concatenate(noise)
    white = np.sqrt(np.mean(np.square(changes), axis=0) / 2) if len(changes) else np.zeros(3)
    return RestBlocks(np.concatenate(firsts), block, np.concatenate(means), white)


def gyroscope_offset(
    gyr_radps: ArrayLike, rest: ArrayLike, sampling_rate_hz: float
) -> GyroscopeOffset | None:
    """Offset of one gyroscope from the samples in which it rests.

    The mean of the means of half seconds, without those that lie far from most others: a motion
    that passes for a rest does not count while most of the time is rest. The covariance comes from
    the scatter of these means, so that a person's wobble is in it. All of it turns with the
    sensor's axes.

    Parameters
    ----------
    gyr_radps : (n, 3) array, rad/s
    rest : (n,) flags, as from :func:`rest_flags`
    sampling_rate_hz : Hz

    Returns
    -------
    GyroscopeOffset, or None with less than a second of rest
    """
    found = rest_blocks(gyr_radps, rest, sampling_rate_hz)
    rate, blocks = as_number(sampling_rate_hz, "sampling_rate_hz"), found.mean_radps
    block = found.length
    still = (np.abs(blocks) <= LARGEST_OFFSET_RADPS).all(axis=1)
    blocks = blocks[still]
    count = len(blocks)
    if count * block < round(SHORTEST_REST_S * rate) or count < 2:
        return None
    # Of many, some find the middle: all distances of a day would fill the memory. They are drawn at
    # random: of a motion that comes again and again, evenly spaced ones may all be a part.
    some = blocks[np.sort(np.random.default_rng(0).permutation(count)[:MOST_COMPARED])]
    apart = np.linalg.norm(some[:, None] - some, axis=2)
    from_middle = np.linalg.norm(some[int(np.argmin(apart.sum(axis=1)))] - blocks, axis=1)
    blocks = blocks[from_middle <= FARTHEST_BLOCK * np.median(from_middle)]
    count = len(blocks)
    free = count - 1
    student = min(free / (free - 2), LARGEST_T_VARIANCE) if free > 2 else LARGEST_T_VARIANCE
    scatter = np.cov(blocks.T) if free > 0 else np.zeros((3, 3))
    white = found.noise_radps
    # Three blocks or less show no scatter in some directions: the samples' noise is in all.
    least = np.mean(white**2) / (count * block) * min(3 / count, 1.0) + IN_RUN_SD_RADPS**2
    return GyroscopeOffset(
        blocks.mean(axis=0),
        student * scatter / count + least * np.eye(3),
        white,
        count * block / rate,
    )


def rest_offsets(
    recording: Recording,
    sensors: Collection[str] | None = None,
    *,
    skip: Mapping[str, ArrayLike] | None = None,
    rest: ArrayLike | None = None,
) -> dict[str, GyroscopeOffset]:
    """Offsets of the gyroscopes of one recording, from the times in which all its sensors rest.

    A gyroscope that fails tells neither its offset nor whether it rests; the others still do.

    Parameters
    ----------
    recording : Recording
    sensors : names of those that move together with the device; all with a gyroscope if None
    skip : sensor to (n,) flags, the samples in which its gyroscope fails; none if None
    rest : (n,) flags of :func:`common_rest` where they are known already

    Returns
    -------
    dict from sensor to GyroscopeOffset; without the sensors that have no rest of a second

    Raises
    ------
    InputError
        If a sensor is missing or has no gyroscope, or flags have another length.
    """
    expect("recording", recording, Recording)
    if sensors is None:
        sensors = [name for name, imu in recording.sensors.items() if imu.gyr_radps is not None]
    names = as_names(sensors, "sensors")
    fails = _as_skip(skip, len(recording))
    rate, none = recording.sampling_rate_hz, np.zeros(len(recording), np.bool_)
    if rest is None:
        still = common_rest(recording, names, skip=skip)
    else:
        still = as_flags(rest, "rest", length=len(recording))
    found = {
        name: gyroscope_offset(
            recording.gyroscope(name),
            still & ~fails.get(name, none),
            rate,
        )
        for name in names
    }
    return {name: offset for name, offset in found.items() if offset is not None}


def common_rest(
    recording: Recording, sensors: Collection[str], *, skip: Mapping[str, ArrayLike] | None = None
) -> NDArray[np.bool_]:
    """Where all of some sensors rest, for a second or longer.

    Parameters
    ----------
    recording : Recording
    sensors : names
    skip : as for :func:`rest_offsets`

    Returns
    -------
    (n,) bool array
    """
    expect("recording", recording, Recording)
    names = as_names(sensors, "sensors")
    rate, count = recording.sampling_rate_hz, len(recording)
    fails = _as_skip(skip, count)
    none = np.zeros(count, np.bool_)
    rest, works = ~none, none.copy()
    for name in names:
        still = rest_flags(recording.sensor(name).acc_mps2, recording.gyroscope(name), rate)
        rest &= still | fails.get(name, none)
        works |= ~fails.get(name, none)
    return long_runs(rest & works, max(1, round(SHORTEST_REST_S * rate)), grow=False)


def _as_skip(skip: Mapping[str, ArrayLike] | None, count: int) -> dict[str, NDArray[np.bool_]]:
    expect("skip", skip, Mapping, none=True)
    given = {} if skip is None else skip
    return {
        name: as_flags(flags, f"skip[{shown(name)}]", length=count) for name, flags in given.items()
    }


def check_offsets(name: str, offsets: Mapping[str, GyroscopeOffset]) -> None:
    """Check that gyroscopes' offsets come by the names of their sensors.

    Parameters
    ----------
    name : of the argument
    offsets : sensor to GyroscopeOffset

    Raises
    ------
    InputError
        If it is no mapping, or a value is no GyroscopeOffset.
    """
    expect(name, offsets, Mapping)
    for sensor, offset in offsets.items():
        expect(f"{name}[{shown(sensor)}]", offset, GyroscopeOffset)


def merge_offsets(
    own: Mapping[str, GyroscopeOffset], others: Mapping[str, GyroscopeOffset]
) -> dict[str, GyroscopeOffset]:
    """Offsets of a recording's own rests together with those of other recordings of that day.

    An offset changes between recordings by some 0.1 deg/s, which is added to the uncertainty of
    the others. Where the two agree they are averaged by their weights; where they differ by more
    than their uncertainties explain, the recording's own rest counts alone.

    Parameters
    ----------
    own : sensor to GyroscopeOffset, from the recording itself
    others : the same from elsewhere

    Returns
    -------
    dict from sensor to GyroscopeOffset
    """
    check_offsets("own", own)
    check_offsets("others", others)
    merged = {
        name: replace(other, covariance=other.covariance + DRIFT_SD_RADPS**2 * np.eye(3))
        for name, other in others.items()
    }
    for name, mine in own.items():
        other = merged.get(name)
        merged[name] = mine
        if other is None:
            continue
        apart = other.offset_radps - mine.offset_radps
        together = np.linalg.inv(mine.covariance + other.covariance)
        if apart @ together @ apart <= LARGEST_CHI_SQUARE:
            gain = mine.covariance @ together
            covariance = mine.covariance - gain @ mine.covariance
            merged[name] = replace(
                mine,
                offset_radps=mine.offset_radps + gain @ apart,
                covariance=(covariance + covariance.T) / 2,
            )
    return merged


def without_offsets(recording: Recording, offsets: Mapping[str, GyroscopeOffset]) -> Recording:
    """Recording from whose gyroscopes the offsets are taken off.

    Parameters
    ----------
    recording : Recording
    offsets : sensor to GyroscopeOffset; sensors that the recording does not have are left out

    Returns
    -------
    Recording; the same one if there is nothing to take off
    """
    expect("recording", recording, Recording)
    check_offsets("offsets", offsets)
    sensors = dict(recording.sensors)
    for name, offset in offsets.items():
        if name in sensors and sensors[name].gyr_radps is not None and offset.offset_radps.any():
            rates = recording.gyroscope(name) - offset.offset_radps
            sensors[name] = Imu(sensors[name].acc_mps2, rates)
    if all(imu is recording.sensors[name] for name, imu in sensors.items()):
        return recording
    return Recording(recording.time_s, sensors, source=recording.source)


def offset_warnings(
    recording: Recording, offsets: Mapping[str, GyroscopeOffset], sensors: Collection[str]
) -> tuple[str, ...]:
    """Sentences on offsets that are large, uncertain or unknown.

    Parameters
    ----------
    recording : Recording that they belong to
    offsets : sensor to GyroscopeOffset
    sensors : those that are used

    Returns
    -------
    tuple of str
    """
    expect("recording", recording, Recording)
    check_offsets("offsets", offsets)
    sensors = as_names(sensors, "sensors")
    unknown = [name for name in sensors if name not in offsets]
    sentences = []
    if unknown:
        sentences.append(
            f"{recording.source}: no second of rest, so that no gyroscope offset is known or taken "
            f"off ({', '.join(unknown)}); let the device stand for some seconds at the beginning"
        )
    for name in sensors:
        if name not in offsets:
            continue
        size, sd = offsets[name].offset_radps, offsets[name].sd_radps
        if np.abs(size).max() > LARGE_OFFSET_RADPS or sd.max() > LARGE_SD_RADPS:
            axes = ", ".join(
                f"{axis} {np.rad2deg(v):.2f} ± {np.rad2deg(s):.2f}"
                for axis, v, s in zip("xyz", size, sd, strict=True)
            )
            sentences.append(
                f"{recording.source}: the gyroscope of {name} has an offset ({axes} deg/s), "
                "which is taken off"
            )
    return tuple(sentences)
