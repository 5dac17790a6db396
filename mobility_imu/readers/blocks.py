"""Rows that share a time stamp in blocks, as packets of a radio or a rounded clock leave them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import GAP_FACTOR, FloatArray
from mobility_imu.readers.clocks import check_forward
from mobility_imu.readers.streams import GIVEN, LARGEST_RATE_DIFFERENCE, Asked, Stream

FEWEST_BLOCKS = 3
"""The first and the last block may be cut; one whole block is needed between them."""
REGULAR = 0.8
"""Blocks are regular if no fewer than this part is near the usual length. Set by hand."""
NEAR = 0.5
"""Part of the usual length by which the length of a block near it may differ. Set by hand."""


def rows_to_a_stamp(time_s: FloatArray, *values: FloatArray | None) -> int:
    """How many rows with different readings share each stamp.

    A row that repeats the one before with its stamp is a doubled packet, and does not count.

    Parameters
    ----------
    time_s : (n,) array, s
    values : (n, 3) arrays of readings; None is passed over

    Returns
    -------
    int; 1 where rows have stamps of their own, or blocks are not regular
    """
    if len(time_s) < FEWEST_BLOCKS or not time_s[-1] > time_s[0]:
        return 1
    new = np.diff(time_s) != 0
    differ = new.copy()
    for readings in values:
        if readings is not None:
            differ |= (np.diff(readings, axis=0) != 0).any(axis=1)
    block = np.cumsum(np.r_[False, new])
    length = np.bincount(block[np.r_[True, differ]])
    if len(length) < FEWEST_BLOCKS:
        return 1
    whole = length[1:-1]
    usual = float(np.median(whole))
    regular = np.abs(whole - usual) <= NEAR * usual
    return round(usual) if usual >= 2 and regular.mean() >= REGULAR else 1


def check_stamps(time_s: FloatArray, values: FloatArray, source: str) -> None:
    """Check that rows have stamps of their own, where a rate of the rows would not help.

    Parameters
    ----------
    time_s : (n,) array, s
    values : (n, 3) array, m/s² or rad/s
    source : the file's name, for messages

    Raises
    ------
    InputError
        If most share theirs.
    """
    rows = rows_to_a_stamp(time_s, values)
    if rows > 1:
        raise InputError(
            f"{_shared(rows, source)}; export the recording again, with all digits of the times"
        )


def with_times_of_rows(
    streams: Iterable[Stream], asked: Asked, *, mapped: bool = False
) -> tuple[tuple[Stream, ...], tuple[str, ...]]:
    """Streams in which rows that share stamps have times of their own, by the rate of the user.

    A longer step between the stamps of two blocks stays a gap.

    Parameters
    ----------
    streams : of one recording
    asked : with the sampling rate
    mapped : whether a map says how they are read, which may state a rate, too

    Returns
    -------
    streams : tuple of Stream
    said : tuple of str, what was counted

    Raises
    ------
    InputError
        If rows share stamps and no rate is given, which the message asks for, or one is given that
        differs from the stamps' by more than 1 % and one block.
    """
    found, said = [], []
    for stream in streams:
        rows = rows_to_a_stamp(stream.time_s, stream.acc_mps2, stream.gyr_radps)
        if rows == 1:
            found.append(stream)
            continue
        told, rate = _shared(rows, stream.source), asked.sampling_rate_hz
        if rate is None:
            way = ", or by rate_hz in place of column in the map" if mapped else ""
            raise InputError(
                f"{told}; give their rate with --sampling-rate-hz (sampling_rate_hz in Python){way}"
            )
        said.append(f"{told}; they are counted at {rate:g} Hz; one lost in a block cannot be seen")
        check_forward(stream.time_s, stream.source)
        place = _places(stream.time_s, rows)
        own = float(place[-1] - rows + 1) / float(stream.time_s[-1] - stream.time_s[0])
        if abs(rate - own) > (LARGEST_RATE_DIFFERENCE + rows / len(place)) * own:
            raise InputError(
                f"{told}; {rate:g} Hz are given, but by the stamps it is about {own:.4g} Hz; give "
                "the right one, or read the file by a map with rate_hz if the stamps are wrong"
            )
        time_s = stream.time_s[0] + place / rate
        found.append(replace(stream, time_s=time_s, counted=True, rate_from=GIVEN))
    return tuple(found), tuple(dict.fromkeys(said))


def _shared(rows: int, source: str) -> str:
    return (
        f"{source}: {rows} rows in succession share each time stamp, and differ in their readings"
    )


def _places(time_s: FloatArray, rows: int) -> FloatArray:
    """Number of each row, where a longer step between blocks stands for lost ones."""
    step = np.diff(time_s)
    usual = float(np.median(step[step > 0]))
    lost = np.where(step > GAP_FACTOR * usual, np.rint(step / usual) - 1, 0.0)
    return np.asarray(np.arange(len(time_s)) + rows * np.cumsum(np.r_[0.0, lost]))
