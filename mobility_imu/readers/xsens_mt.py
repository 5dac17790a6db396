"""Xsens MT Manager's text export: one file per sensor, joined on the packet counter."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import GAP_FACTOR, FloatArray
from mobility_imu.readers.clocks import LONG_END_S, check_rate
from mobility_imu.readers.layout import find_layout
from mobility_imu.readers.streams import GIVEN, Asked, Stream, same_rate, times_of_rows
from mobility_imu.readers.table import NumberTable, line_of, parse_numbers
from mobility_imu.readers.wording import listed, quoted

COUNTER_RANGE = 2**16
"""The packet counter has 16 bits (Xsens, MT Low-Level Communication Protocol, PacketCounter)."""
NEAR_END = COUNTER_RANGE - 2000
"""A counter that starts again at 0 comes from above this: with 20 s lost at 100 Hz. Set by hand."""
LARGEST_COUNTER = 2**53
"""From here on a float does not hold every whole number."""
TICKS_PER_S = 10_000.0
"""SampleTimeFine counts tenths of a millisecond (same document: 10 kHz ticks)."""
TICK_RANGE = 2**32
"""SampleTimeFine has 32 bits (same document)."""
UNEVEN = 0.25
"""Steps between ticks differ from the usual one by less than this part of it, or are not even."""
BY_TEMPERATURE = 1e-3
"""Part by which packets of a gap may differ from the usual ones; crystals drift less. Set by
hand."""
COUNTERS = ("PacketCounter", "Counter")
QUANTITIES = {"Acc": "acc", "Gyr": "gyr"}
OF_DOT = r"\b(Euler_X|Quat_W|dq_W|dv\[1\])"
OF_MT_MANAGER = r"\b(Year|UTC_|Mat\[|Quat_q0|Quat_w|Roll|Latitude)"
"""Names of columns that only an Xsens DOT has, or only an export of MT Manager."""
MOST_COMMENTS = 100
"""Lines of comments that are read; exports of 2019 and later have 12. Set by hand."""
BY_CHANCE = 0.05
"""Two counters that have nothing to do with each other begin as near as that one time in twenty.
The packets that files share do not tell: counters of long files overlap wherever they begin."""


def is_xsens_mt(names: str) -> bool:
    """Whether the first line of a file is MT Manager's.

    Parameters
    ----------
    names : the line

    Returns
    -------
    bool
    """
    return names.startswith("//") or bool(
        re.match(r'"?(Packet)?Counter"?\s*[\t,; ]', names)
        and re.search(r"\b(Acc|Gyr|Mat|Quat|Roll)", names)
        and not re.search(OF_DOT, names)
    )


class Export(NamedTuple):
    """One file of an export.

    Parameters
    ----------
    counter : (n,) array, packets, going on where the sensor's counter starts again; None without
    ticks_s : (n,) array, s, of SampleTimeFine; None if it is not there or empty
    acc : (n, 3) array, m/s²
    gyr : (n, 3) array, rad/s, or None
    rate_hz : Hz, as the head of the file states it, or None
    source : the file's name, for messages
    warnings : rows that were left out
    """

    counter: FloatArray | None
    ticks_s: FloatArray | None
    acc: FloatArray
    gyr: FloatArray | None
    rate_hz: float | None
    source: str
    warnings: tuple[str, ...]


def read_xsens_mt(text: str, source: str, asked: Asked) -> tuple[Stream, ...]:
    """The sensor of one file.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages
    asked : with the sampling rate, if neither head nor SampleTimeFine state it, or not the same

    Returns
    -------
    tuple of one Stream

    Raises
    ------
    InputError
        If a column is missing, a cell of it is no number, no rate is known, or head,
        SampleTimeFine and packet counter contradict each other.
    """
    return (_stream(parse_export(text, source), asked),)


def _stream(export: Export, asked: Asked) -> Stream:
    """Samples at the times of the packet counter, or of SampleTimeFine without one."""
    rate, rate_from = _rate(export, asked)
    counted, counter, said = True, export.counter, export.warnings
    if counter is None and export.ticks_s is not None:
        # Without a packet counter only the ticks show what was lost.
        counter = _packets(export.ticks_s)
        counted = counter is not None
    if not counted:
        time_s = export.ticks_s
        rate_from = "SampleTimeFine"
    elif counter is not None:
        time_s = (counter - counter[0]) / rate
    else:
        time_s, unseen = times_of_rows(len(export.acc), rate, export.source)
        said = (*said, unseen)
    assert time_s is not None
    return Stream(
        time_s, export.acc, export.gyr, source=export.source, warnings=said,
        rate_from=rate_from, counted=counted, label=Path(export.source).stem,
    )  # fmt: skip


def _rate(export: Export, asked: Asked) -> tuple[float, str]:
    """Packets per second, and where that comes from.

    If head and SampleTimeFine have different rates, the one that the user gives is taken.
    """
    stated, own = export.rate_hz, _rate_of_ticks(export)
    if stated is not None and own is not None and not same_rate(stated, own):
        given = asked.sampling_rate_hz
        right = [rate for rate in (stated, own) if given is not None and same_rate(given, rate)]
        if not right:
            raise InputError(
                f"{export.source}: its head states {stated:g} Hz, but its SampleTimeFine has "
                f"{own:.5g} Hz; give the right one with --sampling-rate-hz (sampling_rate_hz in "
                "Python)"
            )
        return right[0], GIVEN
    if stated is not None:
        return stated, "the file's head"
    if own is not None:
        return own, "SampleTimeFine"
    what = "an export of MT Manager without Update Rate and SampleTimeFine"
    return asked.rate(export.source, what), GIVEN


def _rate_of_ticks(export: Export) -> float | None:
    """Packets per second of SampleTimeFine; None without it."""
    ticks = export.ticks_s
    if ticks is None or len(ticks) < 2:
        return None
    counter = _packets(ticks) if export.counter is None else export.counter
    if counter is None:
        rate = 1 / float(np.median(np.diff(ticks)))
    else:
        rate = float((counter[-1] - counter[0]) / (ticks[-1] - ticks[0]))
    return check_rate(rate, f"{export.source}: SampleTimeFine")


def _usual_step(step: FloatArray) -> float:
    """Mean of the steps near the median: ticks are whole, and a loss says nothing of the rate."""
    median = float(np.percentile(step, 50, method="lower"))  # one of the steps
    return float(np.mean(step[(step > 0.5 * median) & (step <= GAP_FACTOR * median)]))


def _packets(ticks_s: FloatArray) -> FloatArray | None:
    """Number of each sample, by even ticks that have gaps; None if they are not even."""
    step = np.diff(ticks_s)
    if not len(step):
        return np.zeros(len(ticks_s))
    packets = step / _usual_step(step)
    near = packets <= GAP_FACTOR
    if (np.abs(packets[near] - 1) > UNEVEN).any():
        return None
    return np.asarray(np.r_[0, np.cumsum(np.maximum(np.rint(packets), 1))])


def parse_export(text: str, source: str) -> Export:
    """Parse one text export; rows without any reading are lost packets and are left out.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages

    Returns
    -------
    Export

    Raises
    ------
    InputError
        If there is no acceleration, the counter cannot be, or a cell is no number.
    """
    comments: list[str] = []
    rest = text
    while rest and len(comments) < MOST_COMMENTS:
        line, _, behind = rest.partition("\n")
        if line.strip() and not line.startswith("//"):
            break
        comments.append(line)
        rest = behind
    head = rest.partition("\n")[0]
    separator = " " if not re.search(r"[\t,;]", head) else None
    names = find_layout(rest, source, separator=separator, first_line=len(comments) + 1).names
    quantities = [q for q in QUANTITIES if any(f"{q}_{axis}" in names for axis in "XYZ")]
    if "Acc" not in quantities:
        raise InputError(
            f"{source}: no column Acc_X, Acc_Y, Acc_Z (it has: {listed(names)}); export "
            "calibrated accelerations (and rates) from MT Manager"
        )
    read = {f"{q}_{axis}" for q in quantities for axis in "XYZ"} | {*COUNTERS, "SampleTimeFine"}
    table = parse_numbers(
        rest,
        separator=separator,
        source=source,
        first_line=len(comments) + 1,
        wanted=read.__contains__,
    )
    counter_name = next((name for name in COUNTERS if name in table.header), None)
    counter = None
    if counter_name is not None:
        counter = unwrapped(table.columns([counter_name])[:, 0], source)
    values = np.hstack([table.columns([f"{q}_{axis}" for axis in "XYZ"]) for q in quantities])
    kept, said = _readable(values, counter, table)
    headless = not any(line.startswith("//") for line in comments)
    if headless and "Gyr" in quantities and not re.search(OF_MT_MANAGER, head):
        said.append(f"{source}: has no head of MT Manager; its Gyr is taken in rad/s")
    return Export(
        None if counter is None else counter[kept],
        _ticks(table, kept, counter),
        values[kept, :3],
        values[kept, 3:] if "Gyr" in quantities else None,
        _update_rate("\n".join(comments), source),
        source,
        tuple(said),
    )


def _readable(
    values: FloatArray, counter: FloatArray | None, table: NumberTable
) -> tuple[NDArray[np.bool_], list[str]]:
    """Rows with readings, and sentences on the others: lost packets, which the clock shows."""
    source = table.source
    placed = counter is not None or _has_ticks(table)
    said = []
    empty = np.isnan(values).all(axis=1)
    if empty.any():
        if not placed:
            raise InputError(
                f"{source}: {int(empty.sum())} row(s) without readings and no packet counter"
            )
        said.append(f"{source}: {int(empty.sum())} lost packet(s), rows without readings")
    kept = np.asarray(~empty)
    partly = np.isnan(values).any(axis=1) & kept
    if partly.any() and placed:
        said.append(f"{source}: {int(partly.sum())} row(s) left out in which a reading is missing")
        kept &= ~partly
    return kept, said


def _has_ticks(table: NumberTable) -> bool:
    """Whether SampleTimeFine is there and not empty; some versions write 0 throughout."""
    if "SampleTimeFine" not in table.header:
        return False
    raw = table.columns(["SampleTimeFine"])[:, 0]
    known = raw[~np.isnan(raw)]
    return len(known) > 0 and (len(raw) == 1 or bool(np.ptp(known) != 0))


def _ticks(
    table: NumberTable, kept: NDArray[np.bool_], counter: FloatArray | None
) -> FloatArray | None:
    """SampleTimeFine of the kept rows in s, going on after 2^32; None without it, or if empty.

    Refused if it does not run forward, or by other packets than the counter.
    """
    if not _has_ticks(table):
        return None
    rows = np.nonzero(kept)[0]
    raw = table.columns(["SampleTimeFine"])[kept, 0]
    if counter is not None and not np.isfinite(raw).all():
        return None  # the counter is clock enough

    def refused(k: int, what: str) -> InputError:
        line = line_of(table.text, int(rows[k]), table.first_line)
        return InputError(f"{table.source}: line {line}: {what}")

    bad = ~((raw >= 0) & (raw < LARGEST_COUNTER) & (raw == np.rint(raw)))
    if bad.any():
        k = int(np.argmax(bad))
        raise refused(k, f"SampleTimeFine is {raw[k]:g}, expected a whole number; correct it, or "
                         "take out the row")  # fmt: skip
    wraps = np.cumsum(np.diff(raw, prepend=raw[:1]) < -TICK_RANGE / 2)
    ticks = np.asarray((raw + TICK_RANGE * wraps) / TICKS_PER_S)
    step = np.diff(ticks)
    if (step <= 0).any():
        k = int(np.argmax(step <= 0)) + 1
        kind = "repeats" if step[k - 1] == 0 else "runs back"
        raise refused(k, f"SampleTimeFine {kind} ({raw[k - 1]:.0f}, then {raw[k]:.0f}); cut the "
                         "recording there")  # fmt: skip
    if counter is not None and len(step):
        count = np.diff(counter[kept])
        usual = _usual_step(step / count)
        apart = np.abs(step - usual * count) > usual * (0.5 + BY_TEMPERATURE * count)
        if apart.any():
            k = int(np.argmax(apart)) + 1
            raise refused(
                k,
                f"the packet counter goes on by {count[k - 1]:.0f}, but SampleTimeFine by "
                f"{step[k - 1]:.4g} s, where a packet lasts {usual:.4g} s; cut the recording there",
            )
    return ticks


def share_packets(exports: Mapping[str, Export]) -> bool:
    """Whether the sensors count packets together, as those of one receiver do.

    Their counters begin near each other, and more than half of the packets of each file, the
    longest as well, are in all others.

    Parameters
    ----------
    exports : sensor name to its file

    Returns
    -------
    bool
    """
    if any(export.counter is None or not len(export.counter) for export in exports.values()):
        return False
    counters, common = _together(exports)
    begins = [counter[0] for counter in counters.values()]
    return bool(
        max(begins) - min(begins) < BY_CHANCE * COUNTER_RANGE / 2
        and 2 * len(common) > max(len(counter) for counter in counters.values())
    )


def _together(exports: Mapping[str, Export]) -> tuple[dict[str, FloatArray], FloatArray]:
    """Counters of sensors, none more than half a turn from the first one's, and what all have."""
    counters: dict[str, FloatArray] = {}
    first, common = None, np.empty(0)
    for name, export in exports.items():
        assert export.counter is not None
        first = export.counter[0] if first is None else first
        # A sensor that starts after the counter went over has small counts throughout.
        turns = round((first - export.counter[0]) / COUNTER_RANGE)
        counter = export.counter + COUNTER_RANGE * turns
        common = np.intersect1d(common, counter, assume_unique=True) if counters else counter
        counters[name] = counter
    return counters, common


def join_exports(
    exports: Mapping[str, Export], asked: Asked, *, from_first: bool = False
) -> tuple[Stream, ...]:
    """Sensors of one session on the packet counter that they share.

    Samples that not all sensors have are left out at the two ends; inside they are gaps.

    Parameters
    ----------
    exports : sensor name to its file
    asked : with the sampling rate, if the files do not state it
    from_first : whether times count from the first packet that any sensor has, as beside files
        that began with it, instead of from the first that all have

    Returns
    -------
    tuple of Stream, all with the same times

    Raises
    ------
    InputError
        If the rates differ, or the sensors share no packets.
    """
    source = " + ".join(Path(export.source).name for export in exports.values())
    if any(export.counter is None for export in exports.values()):
        raise InputError(f"{source}: no PacketCounter in one of the files; export it with them")
    counters, common = _together(exports)
    if len(common) < 2:
        spans = ", ".join(f"{name} {c[0]:g}-{c[-1]:g}" for name, c in counters.items())
        raise InputError(f"{source}: the sensors share no packet counters ({spans})")
    rates = {_rate(export, asked)[0] for export in exports.values()}
    if max(rates) - min(rates) > 1e-3 * max(rates):
        raise InputError(f"{source}: sensors at different rates ({sorted(rates)} Hz)")
    start = min(counter[0] for counter in counters.values()) if from_first else common[0]
    time_s = (common - start) / max(rates)
    streams = []
    for name, export in exports.items():
        at = np.isin(counters[name], common, assume_unique=True)
        said = list(export.warnings)
        begin, end = int(np.argmax(at)), int(np.argmax(at[::-1]))
        if begin + end > LONG_END_S * max(rates):
            said.append(
                f"{export.source}: {begin} sample(s) at the beginning and {end} at the end left "
                "out, which another sensor does not have"
            )
        gyr = None if export.gyr is None else export.gyr[at]
        streams.append(
            Stream(
                time_s, export.acc[at], gyr, source=export.source, label=name, counted=True,
                warnings=tuple(said), rate_from=_rate(export, asked)[1],
                file_label=Path(export.source).stem,
            )
        )  # fmt: skip
    return tuple(streams)


def unwrapped(counter: FloatArray, source: str) -> FloatArray:
    """Packet counter that goes on where the sensor's starts again at 0, after 65535.

    Parameters
    ----------
    counter : (n,) array, as the file has it
    source : the file's name, for messages

    Returns
    -------
    (n,) array, increasing

    Raises
    ------
    InputError
        If a counter is no whole number, repeats, or falls from far below 65535.
    """
    bad = ~((counter >= 0) & (counter < LARGEST_COUNTER) & (counter == np.rint(counter)))
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(f"{source}: the packet counter is {counter[k]:g} at row {k + 1}")
    step = np.diff(counter)
    wraps = (
        (step < -COUNTER_RANGE / 2)
        & (counter[:-1] > NEAR_END)
        & (counter[1:] < COUNTER_RANGE - NEAR_END)
    )
    counter = counter + COUNTER_RANGE * np.r_[0, np.cumsum(wraps)]
    step = np.diff(counter)
    if (step <= 0).any():
        k = int(np.argmax(step <= 0))
        kind = "appears twice" if step[k] == 0 else "runs backwards"
        raise InputError(f"{source}: the packet counter {kind} at row {k + 2}")
    return counter


def _update_rate(comments: str, source: str) -> float | None:
    """Rate in Hz that the comments state; None if there is no such line."""
    rates = set()
    for key, stated in re.findall(r"(Update Rate|Sample rate):(.*)", comments, re.IGNORECASE):
        number = re.fullmatch(r"\s*(\d+(?:[.,]\d+)?)\s*(?:Hz)?[\s;,]*", stated, re.ASCII)
        if number is None:
            raise InputError(f"{source}: {key}:{quoted(stated)}, expected a number of Hz")
        rates.add(check_rate(float(number[1].replace(",", ".")), f"{source}: {key}:"))
    if len(rates) > 1:
        raise InputError(f"{source}: Update Rate: appears twice ({sorted(rates)} Hz)")
    return rates.pop() if rates else None
