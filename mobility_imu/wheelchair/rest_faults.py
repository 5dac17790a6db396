"""Offsets of a chair's gyroscopes that its rests show and a constant does not undo.

An offset that is larger than any sound sensor's is not taken off by the estimate, and one that
changes within a drive is taken off rightly in one part of it only.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from mobility_imu.faults import Fault, without_offset
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.offsets import (
    LARGE_OFFSET_RADPS,
    LARGE_SD_RADPS,
    GyroscopeOffset,
    offset_warnings,
    rest_blocks,
)
from mobility_imu.quality import LARGEST_OFFSET_RADPS
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.contradictions import SharedMotion
from mobility_imu.wheelchair.recovery import tied_rate

__all__ = ["FEWEST_BLOCKS", "changing_offsets", "large_offsets", "offsets_not_told", "rests"]

FEWEST_BLOCKS = 4
"""Half seconds of rest on each side of a change: a motion that passes for a rest is shorter."""
LITTLE = 0.5
"""A sensor that reads less than this part of what another one reads does not turn as that one does:
its axes lie otherwise, but the size of a steady turn is the same. Our choice, not swept."""
SURE = 4.0
"""Times the scatter of the half seconds, from which on a change is told. Set by hand, like the two
parts that follow, and not swept; none by the courts of the study of faults."""
LONG_PART = 0.5
"""Part of a drive over which rests have to lie to show a drift."""
ALONG_PART = 0.5
"""Part of a step along the axis that the others know, with which they show when it came."""


def large_offsets(w: SharedMotion) -> Iterator[Fault]:
    """Gyroscopes that read more at rest than any sound one, while another one reads little.

    A steady turn, which may pass for a rest, is in the readings of all three; in a wheel that rolls
    gravity goes round.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    shown = {name: blocks for name, (_, blocks) in rests(w).items() if len(blocks) >= FEWEST_BLOCKS}
    middle = {name: np.median(blocks, axis=0) for name, blocks in shown.items()}
    large = {n: m for n, m in middle.items() if np.abs(m).max() > LARGEST_OFFSET_RADPS}
    sizes = {name: float(np.linalg.norm(offset)) for name, offset in middle.items()}
    if len(middle) < 3 or not large:
        return
    if min(sizes.values()) > LITTLE * min(sizes[name] for name in large):
        return  # all three may read the same steady turn
    for name, offset in large.items():
        size = float(np.rad2deg(sizes[name]))
        by_axis = ", ".join(
            f"{axis} {value:.1f}" for axis, value in zip("xyz", np.rad2deg(offset), strict=True)
        )
        yield fault_of(
            w.recording, "offset", f"{name}_gyr", np.ones(len(w.recording), np.bool_),
            f"reads {size:.1f} deg/s while the chair stands ({by_axis} deg/s), more than any sound "
            "sensor's offset, so that it is not taken off; check or change the sensor",
            size=size, unit="deg/s",
            repair=partial(without_offset, sensor=name, offset_radps=offset),
        )  # fmt: skip


def offsets_not_told(
    recording: Recording,
    offsets: Mapping[str, GyroscopeOffset],
    sensors: Collection[str],
    faults: Iterable[Fault],
) -> tuple[str, ...]:
    """Sentences on offsets, without those that are unknown because of a fault that is told.

    Parameters
    ----------
    recording, offsets, sensors : as for :func:`~mobility_imu.offsets.offset_warnings`
    faults : Fault, of the same recording

    Returns
    -------
    tuple of str
    """
    told = {fault.sensor.removesuffix("_gyr") for fault in faults if fault.code == "offset"}
    left = [name for name in sensors if name in offsets or name not in told]
    return offset_warnings(recording, offsets, left)


def rests(w: SharedMotion) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Half seconds in which each gyroscope rests, whatever it reads then.

    Parameters
    ----------
    w : SharedMotion

    Returns
    -------
    dict from sensor to their times, in samples, (m,), and means, (m, 3), rad/s
    """
    found: dict[str, tuple[FloatArray, FloatArray]] = {}
    for name in w.names:
        rest = w.rest & ~w.failed[name] if name in w.failed else w.rest
        blocks = rest_blocks(w.recording.gyroscope(name), rest, w.rate_hz)
        if name not in w.mute:
            found[name] = np.asarray(blocks.first + blocks.length / 2, float), blocks.mean_radps
    return found


class _Change(NamedTuple):
    """How an offset changes: by a step, or steadily."""

    scatter_radps: float
    step: tuple[float, float] | None
    """Samples between which the step came; None of a drift."""
    ends: tuple[FloatArray, FloatArray]
    """Offset in the first and the last rest, (3,) arrays, rad/s."""
    between: tuple[float, float]
    """Samples of the first and the last rest."""

    @property
    def by_radps(self) -> FloatArray:
        return np.asarray(self.ends[1] - self.ends[0])


def _change_of(times: FloatArray, blocks: FloatArray, count: int) -> _Change | None:
    """Change of an offset that its rests surely show."""
    if len(blocks) < 2 * FEWEST_BLOCKS:
        return None
    whole = float(times[0]), float(times[-1])
    found = []
    for k in range(FEWEST_BLOCKS, len(blocks) - FEWEST_BLOCKS + 1):
        ends = np.median(blocks[:k], axis=0), np.median(blocks[k:], axis=0)
        left = np.vstack([blocks[:k] - ends[0], blocks[k:] - ends[1]])
        step = float(times[k - 1]), float(times[k])
        found.append(_Change(_scatter(left), step, ends, whole))
    if np.ptp(times) > LONG_PART * count:
        design = np.column_stack([times, np.ones(len(times))])
        line = np.linalg.lstsq(design, blocks, rcond=None)[0]
        first, last = design[[0, -1]] @ line
        found.append(_Change(_scatter(blocks - design @ line), None, (first, last), whole))
    best = min(found, key=lambda change: change.scatter_radps)
    size = float(np.linalg.norm(best.by_radps))
    return best if size > max(LARGE_OFFSET_RADPS, SURE * best.scatter_radps) else None


def _scatter(left: FloatArray) -> float:
    """Mean length of what is left; a few outliers count less than in its root mean square."""
    return float(np.mean(np.linalg.norm(left, axis=1)))


def changing_offsets(w: SharedMotion) -> Iterator[Fault]:
    """A gyroscope whose rests disagree: its offset steps or drifts within the drive.

    A slow motion that passes for a rest moves two sensors or more; one sensor alone is at fault.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    count = len(w.recording)
    changes = {
        name: change
        for name, (times, blocks) in rests(w).items()
        if (change := _change_of(times, blocks, count)) is not None
    }
    if len(changes) != 1:
        return
    for name, change in changes.items():
        size = float(np.rad2deg(np.linalg.norm(change.by_radps)))
        taken = w.offsets[name].offset_radps if name in w.offsets else np.zeros(3)
        start_s, rate = float(w.recording.time_s[0]), w.rate_hz
        if change.step is None:
            first, last = change.between
            part = (np.arange(count) - first) / (last - first)
            offset = change.ends[0] + part[:, None] * change.by_radps
            flags = np.linalg.norm(offset - taken, axis=1) > LARGE_SD_RADPS
            what = f"has an offset that drifts by {size:.1f} deg/s from the first rest to the last"
        else:
            at = _time_of(w, name, change, taken)
            offset = np.where((np.arange(count) < at)[:, None], *change.ends)
            flags = np.zeros(count, np.bool_)
            early, late = (np.linalg.norm(end - taken) > LARGE_SD_RADPS for end in change.ends)
            flags[: int(change.step[1])] |= early
            flags[int(change.step[0]) :] |= late
            times = [start_s + sample / rate for sample in (at, *change.step)]
            what = (
                f"has an offset that changes by {size:.1f} deg/s at about {times[0]:.0f} s, "
                f"between the rests at {times[1]:.1f} and {times[2]:.1f} s"
            )
        told = fault_of(
            w.recording, "offset", f"{name}_gyr", flags,
            f"{what}: one constant is taken off, which is wrong there; leave these times out, or "
            "record again", size=size, unit="deg/s",
            repair=partial(without_offset, sensor=name, offset_radps=offset - taken),
        )  # fmt: skip
        yield replace(told, changes=True)


def _time_of(w: SharedMotion, name: str, change: _Change, taken: FloatArray) -> int:
    """Sample of a step, by what the others say of the sensor's rate; else the middle."""
    assert change.step is not None
    first, last = (int(sample) for sample in change.step)
    middle = (first + last) // 2
    along = {one: w.rates[one][:, 2] for one in w.names}
    main = w.mount.rotation_frame_imu_to_chair
    if name != "frame":
        main = w.mount.rotation_imu_to_wheel("left" if name == "left_wheel" else "right")
    step = float(main[2] @ change.by_radps)
    if len(along) < 3 or abs(step) < ALONG_PART * np.linalg.norm(change.by_radps):
        return middle
    others = {one: rate for one, rate in along.items() if one != name}
    apart = (along[name] - tied_rate(others, name, w.geometry))[first:last]
    # Half a step below zero before it, and half a step above after it; what slips is farther off.
    apart = apart - float(main[2] @ ((change.ends[0] + change.ends[1]) / 2 - taken))
    gained = np.cumsum(np.clip(apart * np.sign(step), -abs(step), abs(step)))
    return first + int(np.argmin(gained)) + 1 if len(gained) else middle
