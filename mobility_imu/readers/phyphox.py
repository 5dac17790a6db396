"""The app phyphox: one CSV per tab of the experiment, with units in the names; +1 g upward.

Times are those of the experiment, which stand still while it is paused. ``meta/time.csv`` holds
each start and pause with the time of day.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.halves import Half, Pause, join_halves
from mobility_imu.readers.layout import check_names, find_layout, split_row
from mobility_imu.readers.quantities import find_triple, vectors
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.table import line_of, parse_numbers
from mobility_imu.readers.wording import listed

TIME = "Time (s)"
ACCELERATION = r"(?:acceleration |accelerometer )?(?P<axis>[xyz]) \((?P<unit>m/s\^?2|m/s²|g)\)"
RATE = r"(?:gyroscope )?(?P<axis>[xyz]) \((?P<unit>rad/s|deg/s|°/s)\)"
LINEAR = r"linear acceleration (?P<axis>[xyz]).*"
EVENTS = "meta/time"
"""Name of the file of starts and pauses."""
EXPERIMENT_TIME, SYSTEM_TIME = "experiment time", "system time"


class WithoutGravity(InputError):
    """A file whose accelerations have no gravity."""


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
    if acc is not None and re.search("linear", Path(source).name, re.IGNORECASE):
        raise WithoutGravity(
            f"{source}: accelerations without gravity, by its name; give the folder of the export, "
            "with Accelerometer.csv and Gyroscope.csv"
        )
    if acc is None and gyr is None:
        names = find_layout(text, source).names
        raise InputError(
            f"{source}: no accelerations and no rates under phyphox' names (it has: "
            f"{listed(names)}); renamed columns are read by a map (mobility-imu read --map)"
        )
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
    files : name of a file without its ending ("Accelerometer", "meta/time") to its content
    source : the folder's name, for messages
    asked : not used, for the files state clock and units

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If no file holds accelerations with gravity, or two do, or the length of a pause is not
        told.
    """
    accelerations, rates, refused = [], [], []
    for name, text in files.items():
        if not is_phyphox(text.partition("\n")[0]) or re.search("linear", name, re.IGNORECASE):
            continue
        try:
            acc, gyr = _halves(text, f"{source}/{name}.csv")
        except WithoutGravity as error:  # another file may have it
            refused.append(error)
            continue
        accelerations += [] if acc is None else [acc]
        rates += [] if gyr is None else [gyr]
    if refused and not accelerations:
        raise refused[0]
    if len(accelerations) != 1 or len(rates) > 1:
        found = [Path(half.source).name for half in (*accelerations, *rates)]
        raise InputError(
            f"{source}: {len(accelerations)} files with accelerations and {len(rates)} with rates"
            f"{f' ({listed(found)})' if found else ''}, expected one of each; export the tabs of "
            "the accelerometer (with g) and the gyroscope, into a folder of their own"
        )
    events = _events(files[EVENTS], f"{source}/{EVENTS}.csv") if EVENTS in files else Events()
    first, last = accelerations[0].time_s.min(), accelerations[0].time_s.max()
    within = [k for k, at_s in enumerate(events.at_s) if first < at_s <= last]
    said = []
    if within:
        k = within[0]
        said.append(
            f"{source}: {len(within)} pause(s) ({EVENTS}.csv), the first of "
            f"{events.length_s[k]:.3g} s after {events.at_s[k] - first:.2f} s; a pause is a gap"
        )
    phone, *turning = (
        half._replace(time_s=events.with_pauses(half.time_s)) for half in (*accelerations, *rates)
    )
    joined = join_halves(
        phone, turning[0] if turning else None, source,
        warnings=tuple(said), epoch_s=events.epoch_s, pauses=events.pauses(),
    )  # fmt: skip
    return (joined,)


class Events(NamedTuple):
    """Pauses of an experiment.

    Parameters
    ----------
    at_s : times of the experiment at which it was paused
    length_s : lengths of the pauses, s
    epoch_s : time of day at which the experiment's time is 0; None if it is not told
    """

    at_s: tuple[float, ...] = ()
    length_s: tuple[float, ...] = ()
    epoch_s: float | None = None

    def with_pauses(self, time_s: FloatArray) -> FloatArray:
        """Times that go on while the experiment is paused.

        Parameters
        ----------
        time_s : (n,) array, s, of the experiment

        Returns
        -------
        (n,) array, s
        """
        before = np.searchsorted(self.at_s, time_s, side="right")
        return np.asarray(time_s + np.cumsum([0.0, *self.length_s])[before])

    def pauses(self) -> list[Pause]:
        """Pauses on the clock that goes on.

        Returns
        -------
        list of Pause
        """
        waited_s = np.cumsum([0.0, *self.length_s])
        return [
            Pause(at_s + before_s, length_s, f"pause of {length_s:.3g} s ({EVENTS}.csv)")
            for at_s, before_s, length_s in zip(
                self.at_s, waited_s[:-1], self.length_s, strict=True
            )
        ]


def _events(text: str, source: str) -> Events:
    """Pauses that ``meta/time.csv`` tells: each from a PAUSE to the START after it."""
    if len(text.splitlines()) < 2:
        return Events()
    layout = find_layout(text, source)
    names = [name.strip('"').lower() for name in layout.names]
    if not {"event", EXPERIMENT_TIME} <= set(names):
        return Events()
    used = ("event", EXPERIMENT_TIME, SYSTEM_TIME)
    check_names([name for name in names if name in used], source)
    rows: list[tuple[str, float, float]] = []
    for k, line in enumerate(filter(str.strip, layout.body.splitlines())):
        cells = split_row(line, layout.separator)[layout.indexed :]
        row = dict(zip(names, cells, strict=False))
        if not {"event", EXPERIMENT_TIME} <= set(row):
            raise InputError(
                f"{source}: line {line_of(text, k)} has {len(cells)} of {len(names)} cells; was "
                "the file cut short? Export it again, or remove it if there was no pause"
            )
        experiment_s, system_s = (
            _number(row.get(name, "").replace(",", ".")) for name in (EXPERIMENT_TIME, SYSTEM_TIME)
        )
        rows.append((row["event"].strip(), experiment_s, system_s))
    pauses = []
    for (event, _, paused_s), (next_event, at_s, started_s) in pairwise(rows):
        if (event, next_event) != ("PAUSE", "START"):
            continue
        length_s = started_s - paused_s
        if not (length_s >= 0 and np.isfinite(at_s)):
            raise InputError(
                f"{source}: a pause after {at_s:.2f} s, whose length the system times do not tell; "
                "cut the recording there"
            )
        pauses.append((at_s, length_s))
    epochs = [system_s - at_s for event, at_s, system_s in rows if event == "START"]
    epoch_s = epochs[0] if epochs and np.isfinite(epochs[0]) else None
    return Events(tuple(at for at, _ in pauses), tuple(length for _, length in pauses), epoch_s)


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def _halves(text: str, source: str) -> tuple[Half | None, Half | None]:
    names = find_layout(text, source).names
    linear = find_triple([n for n in names if re.match("linear", n, re.I)], LINEAR, source)
    if linear and not find_triple(names, ACCELERATION, source):
        raise WithoutGravity(
            f"{source}: accelerations without gravity; record 'Acceleration (with g)' in phyphox"
        )
    found: list[Half | None] = []
    for pattern, quantity in ((ACCELERATION, "acc"), (RATE, "gyr")):
        triple = find_triple(names, pattern, source)
        if triple is None:
            found.append(None)
            continue
        table = parse_numbers(text, source=source, wanted={TIME, *triple.names}.__contains__)
        time_s = table.columns([TIME], finite=True)[:, 0]
        found.append(Half(time_s, vectors(table, triple, quantity), source))
    return found[0], found[1]
