"""Movesense's JSON logs: blocks of samples, each with one time stamp in ms; m/s² and deg/s.

The app writes ``{"Meas": {"IMU9": [block, ...]}}``; Movesense's converter of logs from the sensor's
memory, sbem2json, writes ``{"Samples": [{"MeasIMU9": block}, ...]}``.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.halves import Half, join_halves
from mobility_imu.readers.json_samples import json_number
from mobility_imu.readers.json_text import load_recording
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream
from mobility_imu.readers.wording import listed

LISTS = ("IMU9", "IMU6", "IMU6m")
LARGEST_STAMP_MS = 2**53
"""From here on a float does not hold every whole number."""


def is_movesense(text: str) -> bool:
    """Whether a text begins like a Movesense log.

    Parameters
    ----------
    text : its beginning

    Returns
    -------
    bool
    """
    converted = re.match(r'\s*\{\s*"Samples"\s*:\s*\[', text) is not None and '{"Meas' in text
    return converted or (text.lstrip().startswith("{") and '"Meas"' in text[:200])


def read_movesense(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The sensor of a log.

    The log does not say to which sample of its block a stamp belongs. Here it is the first; the
    samples of a block are spread evenly to the next stamp, so that a wrong choice shifts all times
    by less than a block.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the log states its clock, and Movesense documents its units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If it is no such log, or a value is no number.
    """
    acc_blocks, gyr_blocks = _lists(text, source)
    acc, lengths = _vectors(acc_blocks, "ArrayAcc", source)
    gyr, gyr_lengths = _vectors(gyr_blocks, "ArrayGyro", source)
    time_s, said = _spread(acc_blocks, lengths, source)
    if acc_blocks is not gyr_blocks:
        gyr_time_s, of_gyr = _spread(gyr_blocks, gyr_lengths, source)
        rates = Half(gyr_time_s, np.deg2rad(gyr), f"{source}: Gyro")
        half = Half(time_s, acc, f"{source}: Acc")
        return (join_halves(half, rates, source, warnings=tuple(dict.fromkeys(said + of_gyr))),)
    if lengths != gyr_lengths:
        raise InputError(f"{source}: blocks with more accelerations than rates, or fewer")
    return (Stream(time_s, acc, np.deg2rad(gyr), source=source, warnings=said),)


def _lists(text: str, source: str) -> tuple[list[Any], list[Any]]:
    """Blocks with accelerations and blocks with rates; the same list where each has both."""
    log = load_recording(text, source)
    try:
        measured = log["Meas"] if "Meas" in log else _by_kind(log["Samples"])
        kind = next((name for name in LISTS if name in measured), None)
        found = (measured[kind or "Acc"], measured[kind or "Gyro"])
    except (KeyError, TypeError, AttributeError):
        raise InputError(
            f"{source}: no list {listed(LISTS)} under Meas; record acceleration and rate together"
        ) from None
    if not all(isinstance(blocks, list) and len(blocks) > 1 for blocks in found):
        raise InputError(f"{source}: fewer than two blocks of samples")
    return found


def _by_kind(samples: list[dict[str, Any]]) -> dict[str, list[Any]]:
    """Blocks of a converted log, by what they hold."""
    measured: dict[str, list[Any]] = {}
    for sample in samples:
        for name, block in sample.items():
            measured.setdefault(name.removeprefix("Meas"), []).append(block)
    return measured


def _spread(
    blocks: list[Any], lengths: list[int], source: str
) -> tuple[FloatArray, tuple[str, ...]]:
    """Times of the samples of blocks, and a warning where the stamps are not even."""
    stamps = _stamps(blocks, source)
    usual = float(np.median(np.diff(stamps) / np.array(lengths[:-1])))
    time_s = np.concatenate(
        [stamp + usual * np.arange(n) for stamp, n in zip(stamps, lengths, strict=True)]
    )
    # A fitted line has no jitter of the stamps' whole milliseconds; losses stay visible as steps.
    first = np.r_[0, np.cumsum(lengths)[:-1]]
    slope, start = np.polyfit(first, stamps, 1)
    even = np.asarray(start + slope * np.arange(len(time_s)))
    if np.abs(time_s - even).max() < 2 * usual + 2e-3:
        return even, ()
    return time_s, (f"{source}: the stamps of the blocks are not even; samples may be missing",)


def _stamps(blocks: list[Any], source: str) -> FloatArray:
    """Stamps of the blocks, s."""
    found = []
    for k, block in enumerate(blocks):
        try:
            stamp = json_number(block["Timestamp"])
        except (KeyError, TypeError, ValueError):
            raise InputError(
                f"{source}: block {k} without Timestamp in ms; correct it, or take out the block"
            ) from None
        if not 0 <= stamp < LARGEST_STAMP_MS:  # also what is NaN
            raise InputError(
                f"{source}: block {k}: Timestamp is {stamp:g}, expected ms; correct it, or take "
                "out the block"
            )
        found.append(stamp)
    return np.array(found) * TIME_UNITS["ms"]


def _vectors(blocks: list[Any], name: str, source: str) -> tuple[FloatArray, list[int]]:
    rows: list[list[float]] = []
    lengths = []
    for k, block in enumerate(blocks):
        try:
            here = [[json_number(sample[axis]) for axis in "xyz"] for sample in block[name]]
        except (KeyError, TypeError, ValueError):
            raise InputError(f"{source}: block {k}: no {name} with numbers x, y, z") from None
        if not here:
            raise InputError(f"{source}: block {k}: {name} is empty")
        if not np.isfinite(here).all():
            raise InputError(
                f"{source}: block {k}: a value of {name} is no finite number; correct it, or take "
                "out the block"
            )
        rows += here
        lengths.append(len(here))
    return np.array(rows), lengths
