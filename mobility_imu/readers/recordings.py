"""Recordings of IMUs, in whatever format: one file, several, a folder or an archive."""

from __future__ import annotations

import errno
import re
import stat
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.files import as_path
from mobility_imu.names import as_names
from mobility_imu.readers.blocks import with_times_of_rows
from mobility_imu.readers.clocks import check_fill, check_rate, needed_on_one_clock
from mobility_imu.readers.column_map import read_mapped
from mobility_imu.readers.formats import find_format
from mobility_imu.readers.prefixes import (
    DEVICES,
    by_words,
    exports_in,
    first_line,
    of_one_prefix,
    xsens_parts,
)
from mobility_imu.readers.sessions import (
    NoSession,
    is_session,
    own_name,
    read_session,
    session_files,
)
from mobility_imu.readers.streams import BELIEVED, STARTED, Asked, Stream, held_warnings
from mobility_imu.readers.table import beside, read_text
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.readers.xsens_mt import (
    is_xsens_mt,
    join_exports,
    parse_export,
    share_packets,
)
from mobility_imu.recording import Recording
from mobility_imu.results import Result

if TYPE_CHECKING:
    from mobility_imu.readers.lags import ClockLag

MOST_SENSORS = 12
"""Files that are one recording at most, four times those of a chair: more are a study."""
CLOCK, SAME_CLOCK, OWN_CLOCK, ONE_START = "clock", "same", "own", "start"
"""``clock=same`` among several files: their stamps come from one clock; where
all files tell the time of day, all in UTC or all in local time, their times count from it.
``clock=own``: each sensor has a clock of its own, also where a file or session holds several.
``clock=start``: the first samples of all files are of one moment, as a trigger gives them; wall
clocks and packet counters are not used."""
CLOCKS = (SAME_CLOCK, OWN_CLOCK, ONE_START)
XSENS = "Xsens MT Manager"
PAIR = r"\s*(\w+)\s*=\s*(.+)"
"""A sensor's name and its file."""
LONGEST_EXAMPLE = 300
"""Characters of a file's name and label that a message gives as an example."""
Named = str | Path | Sequence[str | Path]
"""What names a recording."""


@dataclass(frozen=True, eq=False, repr=False)
class Reading(Result):
    """A recording, and what was understood of its file.

    Parameters
    ----------
    recording : Recording
    format : name of the format
    labels : sensor name to what its file calls it, or the file's name where the format has no word
        for it; empty if neither tells
    rate_from : where the sampling rate comes from
    lags : sensor name to its clock's lag, for sensors that were joined by their movement
    warnings : what was left out, reversed, interpolated, joined or found odd
    """

    recording: Recording
    format: str
    labels: Mapping[str, str]
    rate_from: str
    lags: Mapping[str, ClockLag] = field(default_factory=dict, kw_only=True)
    warnings: tuple[str, ...] = field(default=(), kw_only=True)


def read_recording(
    path: str | Path | Sequence[str | Path],
    *,
    sampling_rate_hz: float | None = None,
    fill_gaps_s: float = 0.0,
    expected: Sequence[str] = (),
) -> Recording:
    """Read a recording in any format that the package knows; warnings say what was odd.

    Parameters
    ----------
    path : a file, a folder or archive of a session, the common beginning of the names of several
        Xsens exports (``Trial`` for ``Trial-Frame.txt``, ``Trial-LeftWheel.txt``, ...), or several
        files, in a list or as ``lever=a.csv,body=b.csv``. Files of several sensors each have a
        clock of their own, and are joined by their movement; Xsens exports of one receiver are
        joined on their packet counter. With ``clock=same`` among them their stamps are believed;
        with ``clock=own`` neither these nor a counter are, also in one file or session; with
        ``clock=start`` each file's first sample is of the same moment
    sampling_rate_hz : Hz, for formats without a clock; such a file is refused without it
    fill_gaps_s : gaps up to this length are filled by linear interpolation. With 0 a gap is
        refused; where sensors or uneven stamps are brought on one clock, one of more than 0.1 s
        and one and a half steps
    expected : names of sensors that are wanted; a sensor without a telling name gets them in order

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        Unknown format, missing columns, a rate or unit that nobody states, and whatever
        :class:`~mobility_imu.recording.Recording` refuses.
    """
    found = understand(
        path,
        sampling_rate_hz=sampling_rate_hz,
        fill_gaps_s=fill_gaps_s,
        expected=expected,
    )
    for sentence in found.warnings:
        warnings.warn(sentence, stacklevel=2)
    return found.recording


def understand(
    path: Named,
    *,
    sampling_rate_hz: float | None = None,
    fill_gaps_s: float = 0.0,
    expected: Sequence[str] = (),
    map_path: str | Path | None = None,
) -> Reading:
    """Read a recording as :func:`read_recording` does, and say what was understood.

    Parameters
    ----------
    path, sampling_rate_hz, fill_gaps_s, expected : as in :func:`read_recording`
    map_path : TOML file that says which column is what, for tables of no known format
        (:mod:`mobility_imu.readers.column_map`)

    Returns
    -------
    Reading

    Raises
    ------
    InputError
        As :func:`read_recording`.
    """
    path = _alone(path)
    source = str(own_name(Path(_text(path))))
    if sampling_rate_hz is not None:
        check_rate(sampling_rate_hz, source)
    check_fill(fill_gaps_s)
    expected = as_names(expected, "expected", ordered=True)
    asked = Asked(sampling_rate_hz)
    try:
        form, streams, are_named = _streams(path, asked, map_path)
    except InputError as error:
        raise InputError(f"{error}{_as_several(path, expected)}") from None
    streams, counted = with_times_of_rows(streams, asked, mapped=map_path is not None)
    named, said = _named(streams, expected, source, are_named=are_named)
    _check_case(named, source)
    said = (*said, *counted, *asked.unused(streams))
    for name, stream in named.items():
        whose = stream.source if len(named) == 1 else f"{stream.source}, {name}"
        said += held_warnings(stream.time_s, stream.acc_mps2, whose)
    recording, found, lags = needed_on_one_clock(
        named, source, expected=expected, fill_gaps_s=fill_gaps_s
    )
    return Reading(
        recording,
        form,
        {name: named[name].file_label or "" for name in recording.sensors},
        ", ".join(dict.fromkeys(stream.rate_from for stream in streams)),
        lags=lags,
        warnings=(*said, *found),
    )


def _alone(path: Named) -> Named:
    """The file, where it is the only one of a list."""
    if isinstance(path, list | tuple):
        if not path:
            raise InputError("no file is named")
        return path[0] if len(path) == 1 else path
    return path


def _text(path: Named) -> str:
    """What was given, as messages show it."""
    if isinstance(path, list | tuple):
        return ",".join(_text_of_one(part) for part in path)
    return _text_of_one(path)


def _text_of_one(path: object) -> str:
    if isinstance(path, str) and not path:
        raise InputError("the name of a file is empty")
    return str(as_path(path))  # type: ignore[arg-type]


def _as_several(path: Named, expected: Sequence[str]) -> str:
    """How several files are named, if that is what was meant; empty otherwise."""
    parts = [] if isinstance(path, list | tuple) else _text(path).split(",")
    if not 1 < len(parts) <= MOST_SENSORS or not all(_is_there(Path(part)) for part in parts):
        return ""
    names = [*expected, *(f"SENSOR{k + 1}" for k in range(len(expected), len(parts)))]
    return "; give several files as " + ",".join(
        f"{name}={part}" for name, part in zip(names, parts, strict=False)
    )


def _streams(
    path: Named, asked: Asked, map_path: str | Path | None
) -> tuple[str, tuple[Stream, ...], bool]:
    """Format and sensors of everything that a path names, and whether these bear our names."""
    several = _several(path)
    if several:
        return _streams_of_several(several, asked, map_path)
    path = as_path(_text(path))
    form, streams, are_named = _streams_of_one(path, asked, map_path)
    return form, tuple(s.called(s.label, clock=str(path)) for s in streams), are_named


def _streams_of_several(
    parts: Sequence[tuple[str, str]], asked: Asked, map_path: str | Path | None
) -> tuple[str, tuple[Stream, ...], bool]:
    """Format and sensors of several files, each with its sensor's name, or without one."""
    clock = next((value for sensor, value in parts if sensor == CLOCK), None)
    parts = [(sensor, file) for sensor, file in parts if sensor != CLOCK]
    asked = asked._replace(own_clocks=clock == OWN_CLOCK)
    each = map_path is not None or clock in (OWN_CLOCK, ONE_START)
    streams = [] if each else _streams_of_one_receiver(parts, asked, clock)
    files = [(stream.source, False) for stream in streams]
    forms = [XSENS] if streams else []
    joined = {stream.source for stream in streams}
    for sensor, part in parts:
        if str(as_path(part)) in joined:
            continue
        file, label = _file_and_label(part)
        form, found, are_named = _streams(file, asked, map_path)
        if sensor or label is not None:
            found = (_the_one(found, sensor, file, label),)
        forms.append(form)
        for stream in found:
            name = sensor or (stream.label if are_named else "")
            name = name or _name_of(as_path(file), stream.label)
            streams.append(stream.called(name, clock=name if clock == OWN_CLOCK else None))
            of_xsens = form == XSENS and not are_named
            files.append((file, not of_xsens and _from_own_start(stream)))
            if of_xsens and clock == SAME_CLOCK and len(parts) > 1:
                said = f"{stream.source}: its times count from its own first packet"
                streams[-1] = replace(streams[-1], warnings=(*stream.warnings, said))
    if clock is not None and len(streams) == 1:
        said = f"{parts[0][1]}: {CLOCK}={clock} has no effect: there is one sensor only"
        streams[0] = replace(streams[0], warnings=(*streams[0].warnings, said))
    if clock == SAME_CLOCK:
        streams = [replace(stream, clock=BELIEVED) for stream in _begun(streams, files)]
    elif clock == ONE_START:
        streams = _from_one_start(streams, [file for file, _ in files])
    return ", ".join(dict.fromkeys(forms)), tuple(streams), True


def _begun(streams: Sequence[Stream], files: Sequence[tuple[str, bool]]) -> Sequence[Stream]:
    """Streams whose times count from one moment, by the times of day in their files if all tell.

    Where not all do, or some in UTC and some in local time, a warning names those whose times count
    from their file's start.
    """
    if len({file for file, _ in files}) < 2:
        return streams
    epochs = [stream.epoch_s for stream in streams if stream.epoch_s is not None]
    kinds = {stream.epoch_in: stream.label for stream in streams if stream.epoch_s is not None}
    if len(epochs) == len(streams) and len(kinds) == 1:
        later = [float(stream.epoch_s or 0.0) - min(epochs) for stream in streams]
        told = ", ".join(f"{s.label} {t:+.3f} s" for s, t in zip(streams, later, strict=True))
        said = f"begins by the times of day in the files: {told}"
        streams = [
            replace(stream, time_s=stream.time_s + shift)
            for stream, shift in zip(streams, later, strict=True)
        ]
    else:
        own = [stream.label for stream, (_, is_own) in zip(streams, files, strict=True) if is_own]
        if not own:
            return streams
        said = (
            f"times of {listed(own)} count from their file's start; did the files begin together?"
        )
        if len(kinds) > 1:
            told = " and ".join(f"{kind} ({label})" for kind, label in sorted(kinds.items()))
            said = f"the files tell the time of day in {told}, so it is not used; {said}"
    said = f"{CLOCK}={SAME_CLOCK}: {said}"
    return [replace(streams[0], warnings=(*streams[0].warnings, said)), *streams[1:]]


def _from_one_start(streams: Sequence[Stream], files: Sequence[str]) -> list[Stream]:
    """Streams whose times count from their file's first sample; one file's keep their distances."""
    first: dict[str, float] = {}
    for stream, file in zip(streams, files, strict=True):
        first[file] = min(first.get(file, np.inf), float(stream.time_s.min()))
    moved = [
        replace(stream, time_s=stream.time_s - first[file], clock=STARTED)
        for stream, file in zip(streams, files, strict=True)
    ]
    whose = listed(stream.label for stream in streams)
    if len(first) > 1:
        said = f"{STARTED}: the first samples of the files of {whose} are taken as one moment"
    elif len(streams) > 1:
        said = f"{STARTED} has no effect: one file, session or beginning of names has {whose}"
    else:
        return moved
    moved[0] = replace(moved[0], warnings=(*moved[0].warnings, said))
    return moved


def _from_own_start(stream: Stream) -> bool:
    """Whether times count from the begin of a stream's own file."""
    step = float(np.median(np.diff(stream.time_s))) if len(stream) > 1 else 0.0
    return stream.epoch_s is not None or abs(float(stream.time_s[0])) <= 2 * step


def _the_one(found: Sequence[Stream], sensor: str, file: str, label: str | None) -> Stream:
    """The sensor of a file that has a label; without a label, its only sensor."""
    labels = [stream.label for stream in found]
    wanted = [stream for stream in found if label in (None, stream.label)]
    if len(wanted) == 1:
        return wanted[0]
    whom = f" for '{sensor}'" if sensor else ""
    what = (
        f"{len(found)} sensors{whom} ({listed(labels)})"
        if wanted
        else f"no sensor '{quoted(label or '')}'{whom} (it has: {listed(labels)})"
    )
    example = f"{sensor or 'frame'}={file}#{labels[0] or 'LABEL'}"
    raise InputError(f"{file}: {what}; name one as in {quoted(example, LONGEST_EXAMPLE)}")


def _streams_of_one_receiver(
    parts: Sequence[tuple[str, str]], asked: Asked, clock: str | None
) -> list[Stream]:
    """Sensors of Xsens exports whose packet counter is a common clock; none without it."""
    names: dict[str, Path] = {}
    for sensor, part in parts:
        file = as_path(part)
        if (
            _is_there(file)
            and not is_session(file)
            and file.is_file()
            and is_xsens_mt(first_line(file))
        ):
            name = sensor or _name_of(file, "")
            if name in names:
                return []
            names[name] = file
    if len(names) < 2:
        return []
    exports = {name: parse_export(read_text(file), str(file)) for name, file in names.items()}
    if not share_packets(exports):
        return []
    beside_others = clock == SAME_CLOCK and len(names) < len(parts)
    first, *others = join_exports(exports, asked, from_first=beside_others)
    said = (
        f"{' + '.join(file.name for file in names.values())}: joined on the packet counter that "
        f"the files share; {CLOCK}={OWN_CLOCK} if they are of different receivers"
    )
    if beside_others:
        said += "; their times count from the first packet that any of them has"
    first = replace(first, warnings=(*first.warnings, said))
    return [replace(stream, clock="packet counter") for stream in (first, *others)]


def _name_of(file: Path, label: str) -> str:
    """Sensor that a label or a file's name tells, or one of these as a name."""
    stem = own_name(file).stem
    plain = re.sub(r"\W+", "_", label or stem).strip("_")
    return by_words(label) or by_words(stem) or plain or "sensor"


def _streams_of_one(
    whole: Path, asked: Asked, map_path: str | Path | None
) -> tuple[str, tuple[Stream, ...], bool]:
    """Format and sensors of one file, session or prefix, and whether these bear our names."""
    no_session: InputError | None = None
    if map_path is not None:
        return "mapped CSV", read_mapped(read_text(whole), str(whole), map_path), True
    if not _is_there(whole):
        if is_session(whole):
            try:
                return (*read_session(whole, asked), False)
            except NoSession as error:  # the exports may lie beside a folder of the same name
                no_session = error
        parts = xsens_parts(whole, strict=no_session is None)
        if parts:
            return XSENS, of_one_prefix(whole, parts, asked), True
        if no_session is not None:
            raise InputError(f"{no_session}{exports_in(whole)}")
        what, do = _not_there(whole), beside(whole)
        if _is_there(Path(_file_and_label(str(whole))[0])):
            do = f"; one sensor of a file is given a name, as in frame={whole}"
        raise InputError(f"{whole}: {what}, and no Xsens exports whose names begin like this{do}")
    if is_session(whole):
        return (*read_session(whole, asked), False)
    text = read_text(whole)
    known = find_format(text, str(whole))
    return known.name, known.read(text, str(whole), asked), known.names_sensors


def _several(path: Named) -> list[tuple[str, str]]:
    """Sensors and files where several are given; empty where it is one."""
    text = _text(path)
    if isinstance(path, list | tuple):
        return _pairs([piece for part in path for piece in _pieces(str(part))], loose=True)
    whole = as_path(text)
    if _is_there(whole) or is_session(whole):
        return []
    pair = re.fullmatch(PAIR, text)
    if pair and _is_there(Path(pair[2])):  # a comma may be in the file's name
        return _pairs([text])
    parts = [part.strip() for part in text.split(",")]
    named = [part for part in parts if part]
    return _pairs(named if len(named) > 1 else parts, loose=f",{CLOCK}=" in "".join(text.split()))


def _pieces(part: str) -> list[str]:
    """A part of a list; more where commas in it part sensors, as in ``lever=a.csv,``."""
    pieces = [piece.strip() for piece in part.split(",") if piece.strip()]
    pairs = [re.fullmatch(PAIR, piece) for piece in pieces]
    whole = re.fullmatch(PAIR, part)
    if not pairs or not all(pairs) or _is_there(Path(whole[2] if whole else part)):
        return [part]
    return pieces


def _pairs(parts: Sequence[str], *, loose: bool = False) -> list[tuple[str, str]]:
    """Sensors and files of ``lever=a.csv``, ``body=b.csv``; empty if a part is nothing like it.

    Where that is loose, a part may be a file alone.
    """
    found = [re.fullmatch(PAIR, part) for part in parts]
    if not (loose or (all(found) and len(parts) <= MOST_SENSORS)):
        return []
    if len(parts) > MOST_SENSORS:
        raise InputError(f"{len(parts)} files, expected at most {MOST_SENSORS}")
    pairs = [
        (match[1], match[2]) if match and not _is_there(as_path(part)) else ("", part)
        for match, part in zip(found, parts, strict=True)
    ]
    names = [name for name, _ in pairs if name]
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        what = "the clock is" if twice == CLOCK else f"the sensor {twice} is"
        raise InputError(f"{quoted(','.join(parts))}: {what} named twice; give it once")
    _check_case(names, quoted(",".join(parts)), "give each file a name of its own")
    for name, value in pairs:
        if name == CLOCK and value not in CLOCKS:
            known = [f"{CLOCK}={each}" for each in CLOCKS]
            raise InputError(
                f"{CLOCK}={quoted(value)}: expected {', '.join(known[:-1])} or {known[-1]}"
            )
    if not any(name != CLOCK for name, _ in pairs):
        raise InputError(f"{quoted(','.join(parts))}: no file")
    return pairs


def _file_and_label(text: str) -> tuple[str, str | None]:
    """File and sensor of ``session.csv#Lumbar``; a file whose own name has the mark is itself."""
    if "#" not in text or _is_there(as_path(text)):
        return text, None
    file, _, label = text.rpartition("#")
    return file, label


def _named(
    streams: Sequence[Stream], expected: Sequence[str], source: str, *, are_named: bool
) -> tuple[dict[str, Stream], tuple[str, ...]]:
    """Sensors under the names that the devices' commands know."""
    names: list[str | None] = [s.label if are_named else by_words(s.label) for s in streams]
    said = []
    if len(streams) == 1 and not are_named and len(expected) <= 1:
        ours = expected[0] if expected else names[0] or "frame"
        if names[0] not in (None, ours):
            said.append(f"{source}: '{quoted(streams[0].label)}' taken as {ours}")
        names[0] = ours
    open_names = [name for name in expected if name not in names]
    unnamed = [k for k, name in enumerate(names) if name is None]
    # A scooter's two sensors, or one of them, may be taken in their order; a chair's may not.
    if unnamed and len(unnamed) <= len(open_names) and tuple(expected) == DEVICES[1]:
        for k, name in zip(unnamed, open_names, strict=False):
            names[k] = name
        if len(streams) > 1:
            told = (f"'{quoted(streams[k].label)}' as {names[k]}" for k in unnamed)
            said.append(f"{source}: sensors taken in their order: {', '.join(told)}")
    elif not expected and (unnamed or len(set(names)) < len(names)):
        # Nothing is asked of the names: the file's own will do.
        names = [
            re.sub(r"\W+", "_", stream.label).strip("_") or f"sensor_{k + 1}"
            for k, stream in enumerate(streams)
        ]
    for k, given in enumerate(names):
        if given is None:
            label = streams[k].label or streams[k].source
            raise InputError(
                f"{source}: which sensor is '{quoted(label)}' (of "
                f"{listed(s.label or s.source for s in streams)})? Give them as "
                f"{','.join(f'{n}=FILE#LABEL' for n in expected)}"
            )
        if names.count(given) > 1:
            both = [
                f"'{quoted(s.file_label or s.label)}' in {s.source}"
                for s, n in zip(streams, names, strict=True)
                if n == given
            ]
            asked = expected if len(expected) > 1 else DEVICES[0][:2]
            raise InputError(
                f"{source}: two sensors are called {given}: {' and '.join(both[:2])}; give each "
                f"its name, as in {','.join(f'{name}=FILE' for name in asked)}"
            )
    return {str(name): stream for name, stream in zip(names, streams, strict=True)}, tuple(said)


def _check_case(names: Iterable[str], source: str, advice: str = "") -> None:
    """Check that no two sensors differ in case only: columns of tables have names in any case.

    Without advice, the two may be one sensor whose columns are spelt in two ways.
    """
    seen: dict[str, str] = {}
    for name in names:
        first = seen.setdefault(name.lower(), name)
        if first != name:
            one = f"if they are one sensor, call it {name.lower()} everywhere, else rename one"
            raise InputError(
                f"{source}: the sensors {first} and {name} differ only in upper and lower case; "
                f"{advice or one}"
            )


def recording_files(path: str | Path | Sequence[str | Path]) -> list[Path]:
    """Files that :func:`read_recording` opens for a name.

    Parameters
    ----------
    path : as in :func:`read_recording`

    Returns
    -------
    list of Path, empty if there is no such recording
    """
    path = _alone(path)
    several = _several(path)
    if several:
        return [
            file
            for sensor, name in several
            if sensor != CLOCK
            for file in recording_files(_file_and_label(name)[0])
        ]
    whole = as_path(_text(path))
    if is_session(whole):
        return [*session_files(whole), *xsens_parts(whole, strict=False).values()]
    return [whole] if _is_there(whole) else list(xsens_parts(whole).values())


def _is_there(path: Path) -> bool:
    """Whether a file can be looked at under this name; folders begin names of Xsens exports."""
    try:
        return path.exists() and not path.is_dir()
    except (OSError, ValueError):  # a name that is too long, a folder that may not be entered
        return False


def _not_there(path: Path) -> str:
    """What a name leads to that is no file; raises an InputError if the system does not tell."""
    try:
        return "is a folder" if stat.S_ISDIR(path.stat().st_mode) else "no such file"
    except ValueError:
        return "no such file"
    except OSError as error:
        # Windows has no files with some characters in their names.
        if error.errno in (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG, errno.EINVAL):
            return "no such file"
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
