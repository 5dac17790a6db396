"""Movesense's JSON logs: blocks of samples, each with one time stamp in ms; m/s² and deg/s."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.json_samples import json_number
from mobility_imu.readers.streams import TIME_UNITS, Asked, Stream
from mobility_imu.readers.wording import listed

LISTS = ("IMU9", "IMU6", "IMU6m")


def is_movesense(text: str) -> bool:
    """Whether a text begins like a Movesense log.

    Parameters
    ----------
    text : its beginning

    Returns
    -------
    bool
    """
    return text.lstrip().startswith("{") and '"Meas"' in text[:200]


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
    try:
        measured = json.loads(text)["Meas"]
        kind = next(name for name in LISTS if name in measured)
        blocks = measured[kind]
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: no JSON ({error}); is the file complete?") from None
    except (KeyError, TypeError, StopIteration):
        raise InputError(
            f"{source}: no list {listed(LISTS)} under Meas; record acceleration and rate together"
        ) from None
    if not isinstance(blocks, list) or len(blocks) < 2:
        raise InputError(f"{source}: fewer than two blocks of samples")
    stamps = _stamps(blocks, source)
    acc, lengths = _vectors(blocks, "ArrayAcc", source)
    gyr, gyr_lengths = _vectors(blocks, "ArrayGyro", source)
    if lengths != gyr_lengths:
        raise InputError(f"{source}: blocks with more accelerations than rates, or fewer")
    usual = float(np.median(np.diff(stamps) / np.array(lengths[:-1])))
    time_s = np.concatenate(
        [stamp + usual * np.arange(n) for stamp, n in zip(stamps, lengths, strict=True)]
    )
    # A fitted line has no jitter of the stamps' whole milliseconds; losses stay visible as steps.
    first = np.r_[0, np.cumsum(lengths)[:-1]]
    slope, start = np.polyfit(first, stamps, 1)
    even = start + slope * np.arange(len(acc))
    said: tuple[str, ...] = ()
    if np.abs(time_s - even).max() < 2 * usual + 2e-3:
        time_s = even
    else:
        said = (f"{source}: the stamps of the blocks are not even; samples may be missing",)
    return (Stream(time_s, acc, np.deg2rad(gyr), source=source, warnings=said),)


def _stamps(blocks: list[Any], source: str) -> FloatArray:
    try:
        return np.array([json_number(block["Timestamp"]) for block in blocks]) * TIME_UNITS["ms"]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{source}: a block without Timestamp in ms") from None


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
        rows += here
        lengths.append(len(here))
    return np.array(rows), lengths
