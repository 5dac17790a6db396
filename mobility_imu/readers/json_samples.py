"""JSON arrays of samples, as small boards write them: one object per sample.

The files state no units. Those that are known (the recordings of a rollator with an Arduino Nano 33
BLE) are in g, deg/s and s; other units are stated by a map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.readers.json_text import load_recording
from mobility_imu.readers.streams import Asked, Stream, stream_in_g_and_degrees
from mobility_imu.readers.table import NumberTable
from mobility_imu.readers.wording import quoted

ACCELEROMETER = ["acc_x", "acc_y", "acc_z"]
GYROSCOPE = ["gy_x", "gy_y", "gy_z"]
KEYS = ["timestamp", *ACCELEROMETER, *GYROSCOPE]


def is_json_samples(line: str) -> bool:
    """Whether a text begins like an array of samples.

    Parameters
    ----------
    line : its beginning

    Returns
    -------
    bool
    """
    return line.lstrip().startswith("[{") and '"acc_x"' in line[:400]


def read_json_samples(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """Stream of an array of objects ``acc_x … gy_z, timestamp``.

    They are taken in g, deg/s and s since 1970, which a warning says.

    Parameters
    ----------
    text : content of the file; a number may stand as text, as in ``"timestamp": "1680000000.5"``
    source : the file's name, for messages
    asked : not used

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If it is no such array, or a value is no number.
    """
    table = json_table(text, source, KEYS)
    said = (
        f"{source}: states no units; taken in g, deg/s and s. If they are others, state them in a "
        "map (mobility-imu read --map)"
    )
    time_s = table.columns(KEYS[:1], finite=True)[:, 0]
    found = stream_in_g_and_degrees(table, time_s, ACCELEROMETER, GYROSCOPE)
    return (replace(found, warnings=(*found.warnings, said)),)


def json_table(text: str, source: str, keys: Sequence[str]) -> NumberTable:
    """Numbers of an array of objects, as a table.

    Parameters
    ----------
    text : content of the file; a number may stand as text
    source : the file's name, for messages
    keys : of the values that are read, in the order of the columns

    Returns
    -------
    NumberTable

    Raises
    ------
    InputError
        If it is no such array, or a value is no number.
    """
    samples = load_recording(text, source)
    if not isinstance(samples, list) or not samples:
        raise InputError(f"{source}: expected a JSON array of samples")
    rows = np.empty((len(samples), len(keys)))
    for k, sample in enumerate(samples):
        if not isinstance(sample, dict):
            raise InputError(f"{source}: sample {k} is no object with {', '.join(keys)}")
        for j, key in enumerate(keys):
            value = sample.get(key)
            try:
                rows[k, j] = json_number(value)
            except ValueError:
                raise InputError(
                    f"{source}: sample {k}: {key} is {quoted(repr(value))}, expected a number"
                ) from None
    return NumberTable(list(keys), rows, source)


def json_number(value: object) -> float:
    """Number that a value of a JSON file is.

    Parameters
    ----------
    value : number, or number as text

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If it is none; Python takes true for 1, "1_0" for 10, and digits of other scripts.
    """
    if type(value) is float:  # as most are
        return value
    if isinstance(value, bool) or (
        isinstance(value, str) and ("_" in value or not value.isascii())
    ):
        raise ValueError(value)
    try:
        return float(value)  # type: ignore[arg-type]  # what is no number is refused
    except (TypeError, OverflowError) as error:
        raise ValueError(value) from error
