"""Recordings of IMUs: the canonical CSV, WheelMove-ID's CSV, Xsens MT Manager's text export."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.table import parse_numbers, pick_columns, read_text
from mobility_imu.recording import GAP_FACTOR, Imu, Recording

AXES = ("x", "y", "z")
WHEELMOVE_SENSORS = {"Chassis": "frame", "RoueGauche": "left_wheel", "RoueDroite": "right_wheel"}
# MT Manager names a file after its sensor: words that tell which one it is.
XSENS_WORDS = {
    "left_wheel": ("left", "gauche", "izquierda"),
    "right_wheel": ("right", "droite", "derecha"),
    "frame": ("frame", "chassis", "chasis"),
}
XSENS_COUNTER_RANGE = 65536


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
    path = Path(path)
    if not path.is_file():
        parts = _xsens_parts(path)
        if parts:
            return read_xsens(parts, sampling_rate_hz=sampling_rate_hz, fill_gaps_s=fill_gaps_s)
        raise InputError(f"{path}: no such file, and no Xsens exports whose names begin like this")
    text = read_text(path)
    header = text.partition("\n")[0]
    if header.startswith("//") or header.startswith("PacketCounter"):
        raise InputError(
            f"{path}: one sensor of an Xsens export; give the names' common beginning, "
            f"as in '{path.parent / path.stem.partition('-')[0]}'"
        )
    if "time_s" in header.lower():
        return _canonical(text, str(path), fill_gaps_s)
    if "chassis_" in header.lower() or "roue" in header.lower():
        return _wheelmove_id(text, str(path), sampling_rate_hz)
    raise InputError(
        f"{path}: unknown format. Expected a header with time_s and <sensor>_acc_x_mps2 ..., or "
        f"WheelMove-ID's Chassis_Acc_X; ...; it begins with '{header[:60]}'"
    )


def _canonical(text: str, source: str, fill_gaps_s: float) -> Recording:
    """``time_s``, then ``<sensor>_acc_{x,y,z}_mps2`` and ``<sensor>_gyr_{x,y,z}_radps``."""
    header, values = parse_numbers(text, separator=",", source=source)
    time_s = pick_columns(header, values, ["time_s"], source)[:, 0]
    groups: dict[str, set[str]] = {}
    for name in header:
        if name == "time_s":
            continue
        match = re.fullmatch(r"(\w+?)_(acc_[xyz]_mps2|gyr_[xyz]_radps)", name)
        if match is None:
            raise InputError(
                f"{source}: column {name} is not known; expected <sensor>_acc_x_mps2 or "
                "<sensor>_gyr_x_radps"
            )
        groups.setdefault(match[1], set()).add(match[2][:3])
    columns = {
        sensor: {
            quantity: pick_columns(
                header,
                values,
                [f"{sensor}_{quantity}_{axis}_{unit}" for axis in AXES],
                source,
            )
            for quantity, unit in (("acc", "mps2"), ("gyr", "radps"))
            if quantity == "acc" or "gyr" in have
        }
        for sensor, have in groups.items()
    }
    sensors = {name: Imu(group["acc"], group.get("gyr")) for name, group in columns.items()}
    if fill_gaps_s > 0:
        time_s, sensors = _fill_gaps(time_s, sensors, fill_gaps_s)
    return Recording(time_s, sensors, source=source)


def _wheelmove_id(text: str, source: str, sampling_rate_hz: float) -> Recording:
    """18 columns ``Chassis_``, ``RoueGauche_``, ``RoueDroite_``; no clock."""
    separator = ";" if ";" in text.partition("\n")[0] else ","
    header, values = parse_numbers(text, separator=separator, source=source)
    sensors = {}
    for theirs, ours in WHEELMOVE_SENSORS.items():
        acc, gyr = (
            pick_columns(header, values, [f"{theirs}_{kind}_{axis}" for axis in "XYZ"], source)
            for kind in ("Acc", "Gyr")
        )
        sensors[ours] = Imu(acc, gyr)
    return Recording(np.arange(len(values)) / sampling_rate_hz, sensors, source=source)


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
    for sensor, path in paths.items():
        counter, imu, rate = _xsens_file(path)
        # A sensor that starts after the counter went over has small counts throughout.
        start = next(iter(tables.values()))[0][0] if tables else counter[0]
        counter = counter + XSENS_COUNTER_RANGE * round((start - counter[0]) / XSENS_COUNTER_RANGE)
        tables[sensor] = (counter, imu)
        rates.add(rate or sampling_rate_hz)
    source = " + ".join(Path(path).name for path in paths.values())
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
        time_s, sensors = _fill_gaps(time_s, sensors, fill_gaps_s)
    return Recording(time_s, sensors, source=source)


def _xsens_parts(prefix: Path) -> dict[str, Path]:
    if not prefix.parent.is_dir() or not prefix.name:
        return {}
    parts: dict[str, Path] = {}
    for path in sorted(prefix.parent.glob("*.txt")):
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
    lines = text.splitlines()
    comments = [line for line in lines[:100] if line.startswith("//")]
    rate = re.search(r"Update Rate:\s*([\d.,]+)", "\n".join(comments))
    table = text.split("\n", len(comments))[-1]
    header, values = parse_numbers(
        table, separator="\t", source=str(path), first_line=len(comments) + 1
    )
    counter = pick_columns(header, values, ["PacketCounter"], str(path))[:, 0]
    acc = pick_columns(header, values, [f"Acc_{axis}" for axis in "XYZ"], str(path))
    gyr = pick_columns(header, values, [f"Gyr_{axis}" for axis in "XYZ"], str(path))
    step = np.diff(counter)
    # The counter starts again at 0 after 65535.
    counter = counter + XSENS_COUNTER_RANGE * np.r_[0, np.cumsum(step < -XSENS_COUNTER_RANGE / 2)]
    step = np.diff(counter)
    if (step <= 0).any():
        k = int(np.argmax(step <= 0))
        kind = "stands twice" if step[k] == 0 else "runs backwards"
        raise InputError(f"{path}: the packet counter {kind} at row {k + 2}")
    return counter, Imu(acc, gyr), float(rate[1].replace(",", ".")) if rate else None


def _common_counters(counters: Mapping[str, FloatArray], source: str) -> FloatArray:
    common: FloatArray | None = None
    for counter in counters.values():
        common = counter if common is None else np.intersect1d(common, counter, assume_unique=True)
    if common is None or len(common) < 2:
        spans = ", ".join(f"{name} {c[0]:g}-{c[-1]:g}" for name, c in counters.items())
        raise InputError(f"{source}: the sensors share no packet counters ({spans})")
    return common


def _fill_gaps(
    time_s: FloatArray, sensors: Mapping[str, Imu], longest_s: float
) -> tuple[FloatArray, dict[str, Imu]]:
    """Add interpolated samples where up to longest_s of them are missing."""
    step = np.diff(time_s)
    if len(step) == 0 or (step <= 0).any() or not np.isfinite(step).all():
        return time_s, dict(sensors)  # Recording says what is wrong
    usual = float(np.median(step))
    holes = np.nonzero((step > GAP_FACTOR * usual) & (step <= longest_s))[0]
    new = [np.linspace(time_s[k], time_s[k + 1], round(step[k] / usual) + 1)[1:-1] for k in holes]
    filled = np.sort(np.concatenate([time_s, *new]))

    def at_filled(values: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(filled, time_s, axis) for axis in values.T])

    return filled, {
        name: Imu(
            at_filled(imu.acc_mps2), None if imu.gyr_radps is None else at_filled(imu.gyr_radps)
        )
        for name, imu in sensors.items()
    }
