"""The app phyphox: one CSV per tab of the experiment, with units in the names; +1 g upward."""

from __future__ import annotations

import re
from collections.abc import Mapping

from mobility_imu.errors import InputError
from mobility_imu.readers.halves import Half, join_halves
from mobility_imu.readers.layout import find_layout
from mobility_imu.readers.quantities import find_triple, vectors
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import parse_numbers

TIME = "Time (s)"
ACCELERATION = r"(?:acceleration |accelerometer )?(?P<axis>[xyz]) \((?P<unit>m/s\^?2|m/s²|g)\)"
RATE = r"(?:gyroscope )?(?P<axis>[xyz]) \((?P<unit>rad/s|deg/s|°/s)\)"
LINEAR = r"linear acceleration (?P<axis>[xyz]).*"


def is_phyphox(names: str) -> bool:
    """Whether a line of names is one of phyphox'.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    found = names.replace('"', "")
    return found.startswith(TIME) and re.search(r"[xyz] \((m/s|rad/s)", found, re.I) is not None


def read_phyphox_file(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """One file by itself; rates alone, or accelerations without gravity, are refused.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : not used, for the file states clock and units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If it holds no accelerations with gravity.
    """
    acc, gyr = _halves(text, source)
    if acc is None:
        raise InputError(
            f"{source}: no accelerations; give the folder of the export, with Accelerometer.csv "
            "and Gyroscope.csv"
        )
    return (join_halves(acc, gyr, source),)


def read_phyphox(files: Mapping[str, str], source: str, asked: Asked) -> tuple[Stream, ...]:
    """The phone of one export.

    Parameters
    ----------
    files : name of a file without its ending ("Accelerometer") to its content
    source : the folder's name, for messages
    asked : not used, for the files state clock and units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If no file holds accelerations with gravity, or two do.
    """
    accelerations, rates = [], []
    for name, text in files.items():
        if not is_phyphox(text.partition("\n")[0]) or re.search("linear", name, re.IGNORECASE):
            continue
        acc, gyr = _halves(text, f"{source}/{name}.csv")
        accelerations += [] if acc is None else [acc]
        rates += [] if gyr is None else [gyr]
    if len(accelerations) != 1 or len(rates) > 1:
        raise InputError(
            f"{source}: {len(accelerations)} files with accelerations and {len(rates)} with rates, "
            "expected one of each; export the tabs of the accelerometer (with g) and the gyroscope"
        )
    return (join_halves(accelerations[0], rates[0] if rates else None, source),)


def _halves(text: str, source: str) -> tuple[Half | None, Half | None]:
    names = find_layout(text, source).names
    if find_triple([n for n in names if re.match("linear", n, re.I)], LINEAR, source):
        raise InputError(
            f"{source}: accelerations without gravity; record 'Acceleration (with g)' in phyphox"
        )
    found: list[Half | None] = []
    for pattern, quantity in ((ACCELERATION, "acc"), (RATE, "gyr")):
        triple = find_triple(names, pattern, source)
        if triple is None:
            found.append(None)
            continue
        table = parse_numbers(text, source=source, wanted={TIME, *triple.names}.__contains__)
        time_s = table.columns([TIME])[:, 0]
        found.append(Half(time_s, vectors(table, triple, quantity), source))
    return found[0], found[1]
