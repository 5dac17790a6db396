"""Recordings of IMUs: the canonical CSV, WheelMove-ID's CSV, Xsens MT Manager's text export."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.files import as_path
from mobility_imu.frames import FloatArray
from mobility_imu.readers.clocks import check_fill, check_rate, fill_gaps
from mobility_imu.readers.table import parse_numbers, read_text
from mobility_imu.readers.wording import quoted
from mobility_imu.recording import Imu, Recording

AXES = ("x", "y", "z")
WHEELMOVE_SENSORS = {"Chassis": "frame", "RoueGauche": "left_wheel", "RoueDroite": "right_wheel"}
# MT Manager names a file after its sensor: words that tell which one it is.
XSENS_WORDS = {
    "left_wheel": ("left", "gauche", "izquierda"),
    "right_wheel": ("right", "droite", "derecha"),
    "frame": ("frame", "chassis", "chasis"),
}
XSENS_COUNTER_RANGE = 65536
LARGEST_COUNTER = 2**53
"""From here on a float does not hold every whole number."""


def read_recording(
    path: str | Path, *, sampling_rate_hz: float = 100.0, fill_gaps_s: float = 0.0
) -> Recording:
    """Read a recording in any format that the package knows.

    Parameters
    ----------
    path : a ``.csv`` or ``.csv.gz`` file, or the common beginning of the names of several Xsens
        exports (``Trial`` for ``Trial-Frame.txt``, ``Trial-LeftWheel.txt``, ...)
    sampling_rate_hz : Hz, for formats without a clock (WheelMove-ID and Xsens files without
        an ``Update Rate`` line); 100 is both tools' usual rate
    fill_gaps_s : gaps up to this length are filled by linear interpolation; 0 refuses any gap

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        Unknown format, missing columns, and whatever
        :class:`~mobility_imu.recording.Recording` refuses.
    """
    path = as_path(path)
    source = str(path)
    check_rate(sampling_rate_hz, source)
    check_fill(fill_gaps_s)
    if not _is_there(path):
        parts = _xsens_parts(path)
        if parts:
            return read_xsens(parts, sampling_rate_hz=sampling_rate_hz, fill_gaps_s=fill_gaps_s)
        what = "is a folder" if _is_folder(path) else "no such file"
        raise InputError(f"{path}: {what}, and no Xsens exports whose names begin like this")
    text = read_text(path)
    header = text.partition("\n")[0]
    if header.startswith("//") or header.startswith("PacketCounter"):
        raise InputError(
            f"{path}: one sensor of an Xsens export; give the names' common beginning, "
            f"as in '{path.parent / path.stem.partition('-')[0]}'"
        )
    if "time_s" in header.lower():
        return _canonical(text, source, fill_gaps_s)
    if "chassis_" in header.lower() or "roue" in header.lower():
        return _wheelmove_id(text, source, sampling_rate_hz)
    raise InputError(
        f"{path}: unknown format. Expected a header with time_s and <sensor>_acc_x_mps2 ..., or "
        f"WheelMove-ID's Chassis_Acc_X; ...; it begins with '{quoted(header)}'"
    )


def recording_files(path: str | Path) -> list[Path]:
    """Files that :func:`read_recording` opens for a name.

    Parameters
    ----------
    path : as in :func:`read_recording`

    Returns
    -------
    list of Path, empty if there is no such recording
    """
    path = as_path(path)
    return [path] if _is_there(path) else list(_xsens_parts(path).values())


def _is_there(path: Path) -> bool:
    """Whether a file can be looked at under this name; folders begin names of Xsens exports."""
    try:
        return path.exists() and not path.is_dir()
    except (OSError, ValueError):  # a name that is too long, a folder that may not be entered
        return False


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def _canonical(text: str, source: str, fill_gaps_s: float) -> Recording:
    """``time_s``, then ``<sensor>_acc_{x,y,z}_mps2`` and ``<sensor>_gyr_{x,y,z}_radps``."""
    table = parse_numbers(text, separator=",", source=source)
    time_s = table.columns(["time_s"])[:, 0]
    groups: dict[str, set[str]] = {}
    for name in table.header:
        if name.lower() == "time_s":
            continue
        match = re.fullmatch(r"(\w+?)_(acc_[xyz]_mps2|gyr_[xyz]_radps)", name)
        if match is None:
            raise InputError(
                f"{source}: column {quoted(name)} is not known; expected <sensor>_acc_x_mps2 or "
                "<sensor>_gyr_x_radps"
            )
        groups.setdefault(match[1], set()).add(match[2][:3])
    sensors = {}
    for sensor, have in groups.items():
        acc, gyr = (
            table.columns([f"{sensor}_{quantity}_{axis}_{unit}" for axis in AXES])
            if quantity == "acc" or "gyr" in have
            else None
            for quantity, unit in (("acc", "mps2"), ("gyr", "radps"))
        )
        assert acc is not None
        sensors[sensor] = Imu(acc, gyr)
    if fill_gaps_s > 0:
        time_s, sensors = fill_gaps(time_s, sensors, fill_gaps_s, source)
    recording = Recording(time_s, sensors, source=source)
    check_rate(recording.sampling_rate_hz, source, clock=True)
    return recording


def _wheelmove_id(text: str, source: str, sampling_rate_hz: float) -> Recording:
    """18 columns ``Chassis_``, ``RoueGauche_``, ``RoueDroite_``; no clock."""
    separator = ";" if ";" in text.partition("\n")[0] else ","
    table = parse_numbers(text, separator=separator, source=source)
    sensors = {}
    for theirs, ours in WHEELMOVE_SENSORS.items():
        acc, gyr = (
            table.columns([f"{theirs}_{kind}_{axis}" for axis in "XYZ"]) for kind in ("Acc", "Gyr")
        )
        sensors[ours] = Imu(acc, gyr)
    return Recording(np.arange(len(table)) / sampling_rate_hz, sensors, source=source)


def read_xsens(
    paths: Mapping[str, str | Path], *, sampling_rate_hz: float = 100.0, fill_gaps_s: float = 0.0
) -> Recording:
    """Join Xsens MT Manager text exports, one file per sensor, on the packet counter.

    Samples that not all sensors have are left out at the two ends; inside they are gaps.

    Parameters
    ----------
    paths : sensor name to file
    sampling_rate_hz : Hz, used when the files do not state an ``Update Rate``
    fill_gaps_s : as in :func:`read_recording`

    Returns
    -------
    Recording
    """
    tables: dict[str, tuple[FloatArray, Imu]] = {}
    rates = set()
    source = " + ".join(Path(path).name for path in paths.values())
    check_rate(sampling_rate_hz, source)
    check_fill(fill_gaps_s)
    for sensor, path in paths.items():
        counter, imu, rate = _xsens_file(path)
        # A sensor that starts after the counter went over has small counts throughout.
        start = next(iter(tables.values()))[0][0] if tables else counter[0]
        counter = counter + XSENS_COUNTER_RANGE * round((start - counter[0]) / XSENS_COUNTER_RANGE)
        tables[sensor] = (counter, imu)
        rates.add(sampling_rate_hz if rate is None else rate)
    if len(rates) > 1:
        raise InputError(f"{source}: sensors at different rates ({sorted(rates)} Hz)")
    common = _common_counters({name: counter for name, (counter, _) in tables.items()}, source)
    sensors = {}
    for sensor, (counter, imu) in tables.items():
        at = np.isin(counter, common, assume_unique=True)
        gyr = None if imu.gyr_radps is None else imu.gyr_radps[at]
        sensors[sensor] = Imu(imu.acc_mps2[at], gyr)
    time_s = (common - common[0]) / rates.pop()
    if fill_gaps_s > 0:
        time_s, sensors = fill_gaps(time_s, sensors, fill_gaps_s, source)
    return Recording(time_s, sensors, source=source)


def _xsens_parts(prefix: Path) -> dict[str, Path]:
    try:
        if not prefix.parent.is_dir() or not prefix.name:
            return {}
        exports = sorted(prefix.parent.glob("*.txt"))
    except (OSError, ValueError):
        return {}
    parts: dict[str, Path] = {}
    for path in exports:
        rest = path.stem[len(prefix.name) :].lower()
        if not path.stem.startswith(prefix.name):
            continue
        for sensor, words in XSENS_WORDS.items():
            if any(word in rest for word in words):
                if sensor in parts:
                    raise InputError(
                        f"{prefix}: two files for the {sensor} sensor, {parts[sensor].name} and "
                        f"{path.name}"
                    )
                parts[sensor] = path
    return parts


def _xsens_file(path: str | Path) -> tuple[FloatArray, Imu, float | None]:
    text = read_text(path)
    comments = [line for line in text.splitlines()[:100] if line.startswith("//")]
    # The header is the first line after the comments.
    content = text.split("\n", len(comments))[-1]
    table = parse_numbers(content, separator="\t", source=str(path), first_line=len(comments) + 1)
    counter = _unwrapped(table.columns(["PacketCounter"])[:, 0], path)
    acc = table.columns([f"Acc_{axis}" for axis in "XYZ"])
    gyr = table.columns([f"Gyr_{axis}" for axis in "XYZ"])
    return counter, Imu(acc, gyr), _update_rate("\n".join(comments), path)


def _unwrapped(counter: FloatArray, path: str | Path) -> FloatArray:
    """Packet counter that goes on where the sensor's starts again at 0, after 65535."""
    bad = ~((counter >= 0) & (counter < LARGEST_COUNTER) & (counter == np.rint(counter)))
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError(f"{path}: the packet counter is {counter[k]:g} at row {k + 1}")
    step = np.diff(counter)
    counter = counter + XSENS_COUNTER_RANGE * np.r_[0, np.cumsum(step < -XSENS_COUNTER_RANGE / 2)]
    step = np.diff(counter)
    if (step <= 0).any():
        k = int(np.argmax(step <= 0))
        kind = "stands twice" if step[k] == 0 else "runs backwards"
        raise InputError(f"{path}: the packet counter {kind} at row {k + 2}")
    return counter


def _update_rate(comments: str, path: str | Path) -> float | None:
    """Rate in Hz that the comments state; None if there is no such line."""
    rates = set()
    for stated in re.findall(r"Update Rate:(.*)", comments):
        number = re.fullmatch(r"\s*(\d+(?:[.,]\d+)?)\s*(?:Hz)?\s*", stated, re.ASCII)
        if number is None:
            raise InputError(f"{path}: Update Rate:{quoted(stated)}, expected a number of Hz")
        rates.add(check_rate(float(number[1].replace(",", ".")), f"{path}: Update Rate:"))
    if len(rates) > 1:
        raise InputError(f"{path}: Update Rate: stands twice ({sorted(rates)} Hz)")
    return rates.pop() if rates else None


def _common_counters(counters: Mapping[str, FloatArray], source: str) -> FloatArray:
    common: FloatArray | None = None
    for counter in counters.values():
        common = counter if common is None else np.intersect1d(common, counter, assume_unique=True)
    if common is None or len(common) < 2:
        spans = ", ".join(f"{name} {c[0]:g}-{c[-1]:g}" for name, c in counters.items())
        raise InputError(f"{source}: the sensors share no packet counters ({spans})")
    return common
