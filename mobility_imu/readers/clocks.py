"""Clocks of recordings: rates that can be, gaps that are filled, sensors that come on one clock."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import GAP_FACTOR, FloatArray, as_number, shown
from mobility_imu.readers.silent_axes import recorded
from mobility_imu.readers.streams import BELIEVED, STARTED, Stream
from mobility_imu.readers.table import LONGEST_FILL_S
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.recording import HIGHEST_RATE_HZ, LOWEST_RATE_HZ, Imu, Recording

if TYPE_CHECKING:
    from mobility_imu.readers.lags import ClockLag

_log = logging.getLogger("mobility_imu")
WORTH_A_LINE_S = 600.0
"""The search by movement in a longer recording takes half a minute or more."""
FEWEST_TO_FILL = 1000
"""So many samples may be filled in even if the recording has fewer: 10 s at 100 Hz. Set by hand."""
MOSTLY_USUAL = 0.8
"""If fewer steps than this part are near the median, there is no usual step. Set by hand."""
LONGEST_SILENT_GAP_S = 0.1
"""Stamps that are not even may leave gaps up to this, which are interpolated over: at 1 rad/s a
lever turns by 6 deg meanwhile. Set by hand."""
AS_PRINTED = 1.005
"""A message states a length with three digits: the gap may be longer by this factor."""
ROUNDING_S = 1e-6
"""Stamps in decimals are this far from what they say, or nearer. Finer ones than µs are rare."""
LONG_END_S = 1.0
"""Sensors start and stop within this; more that one sensor does not have is worth a warning. Set by
hand; the streams of a phone's recording start up to 0.2 s apart."""


def check_rate(sampling_rate_hz: float, source: str, *, clock: bool = False) -> float:
    """Check that a sampling rate is one that an IMU can have.

    Parameters
    ----------
    sampling_rate_hz : Hz
    source : the first words of the message
    clock : whether the rate was found from a time column, so that its unit may be wrong

    Returns
    -------
    float, Hz

    Raises
    ------
    InputError
        If no IMU has it: lower than 1 Hz, or higher than 100 kHz.
    """
    rate = _number(sampling_rate_hz)
    if not LOWEST_RATE_HZ <= rate <= HIGHEST_RATE_HZ:
        hint = "; are the times in s?" if clock else ""
        raise InputError(
            f"{source}: sampling rate of {shown(sampling_rate_hz)} Hz, expected "
            f"{LOWEST_RATE_HZ:g} to {HIGHEST_RATE_HZ:g} Hz{hint}"
        )
    return rate


def check_fill(longest_s: float) -> float:
    """Check the length up to which gaps are filled.

    Parameters
    ----------
    longest_s : s

    Returns
    -------
    float, s

    Raises
    ------
    InputError
        If it is not between 0 and 60 s.
    """
    length = _number(longest_s)
    if not 0 <= length <= LONGEST_FILL_S:
        raise InputError(
            f"gaps to be filled up to {shown(longest_s)} s: expected between 0 and "
            f"{LONGEST_FILL_S:g} s"
        )
    return length


def _number(value: object) -> float:
    """Number that was given; NaN for what is none."""
    try:
        return as_number(value, "value", negative=True, infinite=True)
    except InputError:
        return float("nan")


def longest_silent_gap(usual_s: float) -> float:
    """Longest step between stamps that is interpolated over without being asked for.

    Parameters
    ----------
    usual_s : s, the sensor's usual step

    Returns
    -------
    float, s
    """
    longest = max(LONGEST_SILENT_GAP_S, GAP_FACTOR * min(usual_s, 1 / LOWEST_RATE_HZ))
    return longest + ROUNDING_S


def check_forward(time_s: FloatArray, source: str) -> None:
    """Check that no clock is set back; single stamps that repeat or are swapped may stay.

    Parameters
    ----------
    time_s : (n,) array, s
    source : the first words of the message

    Raises
    ------
    InputError
        If a time is earlier than one before it by more than a gap that may be.
    """
    if len(time_s) < 2:
        return
    with np.errstate(invalid="ignore"):
        latest = np.maximum.accumulate(time_s)
        back = latest - time_s > longest_silent_gap(float(np.median(np.diff(time_s))))
    if back.any():
        k = int(np.argmax(back))
        raise InputError(
            f"{source}: the clock jumps back by {latest[k] - time_s[k]:.4g} s at sample {k + 1} "
            f"({latest[k] - time_s[0]:.2f} s after the first); cut the recording there"
        )


def ends_left_out(clocks: Mapping[str, FloatArray], source: str) -> list[str]:
    """Sentence on what is lost because one series begins late or ends early.

    Parameters
    ----------
    clocks : name to its times, s, increasing
    source : the first words of the message

    Returns
    -------
    list of str, empty or with one sentence
    """
    first = min(clock[0] for clock in clocks.values())
    last = max(clock[-1] for clock in clocks.values())
    begin = max(clock[0] for clock in clocks.values())
    end = min(clock[-1] for clock in clocks.values())
    lost = []
    if begin - first > LONG_END_S:
        late = {name: clock[0] - first for name, clock in clocks.items()}
        at = [f"{name} only from {s:.2f} s" for name, s in late.items() if s > LONG_END_S]
        lost.append(f"the first {begin - first:.2f} s ({', '.join(at)})")
    if last - end > LONG_END_S:
        at = [
            f"{name} only until {clock[-1] - first:.2f} s"
            for name, clock in clocks.items()
            if last - clock[-1] > LONG_END_S
        ]
        lost.append(f"the last {last - end:.2f} s ({', '.join(at)})")
    if not lost:
        return []
    return [f"{source}: {' and '.join(lost)} of {last - first:.2f} s left out: not all have it"]


def fill_gaps(
    time_s: FloatArray, sensors: Mapping[str, Imu], longest_s: float, source: str
) -> tuple[FloatArray, dict[str, Imu]]:
    """Add samples on the straight line between the two ends of each gap up to a length.

    Parameters
    ----------
    time_s : (n,) array, s
    sensors : sensor name to Imu, each with n samples
    longest_s : s, to the three digits of a message that states a gap's length; longer gaps stay
    source : the first words of a message; a warning says how much was filled in

    Returns
    -------
    time_s : (m,) array, s
    sensors : sensor name to Imu, each with m samples

    Raises
    ------
    InputError
        If more samples would be filled in than the recording has.
    """
    step = np.diff(time_s)
    if len(step) == 0 or not np.isfinite(step).all() or (step <= 0).any():
        return time_s, dict(sensors)  # Recording says what is wrong
    usual = float(np.median(step))
    holes = np.nonzero((step > GAP_FACTOR * usual) & (step <= AS_PRINTED * longest_s))[0]
    added = np.rint(step[holes] / usual).sum() - len(holes)
    if not _may_be_added(added, len(time_s)):
        raise InputError(
            f"{source}: {added:.0f} samples would be filled in beside the {len(time_s)} that there "
            "are; fill shorter gaps only"
        )
    if len(holes):
        longest = holes[np.argmax(step[holes])]
        warnings.warn(
            f"{source}: {len(holes)} gap(s) filled in with {added:.0f} interpolated samples, the "
            f"longest of {step[longest]:.3g} s after {time_s[longest]:g} s",
            stacklevel=1,
        )
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


def _may_be_added(added: float, there: int) -> bool:
    return added <= max(there, FEWEST_TO_FILL)


def needed_on_one_clock(
    streams: Mapping[str, Stream], source: str, *, expected: Sequence[str], fill_gaps_s: float
) -> tuple[Recording, tuple[str, ...], dict[str, ClockLag]]:
    """Recording of sensors, without those that are not expected if the recording is refused.

    Parameters
    ----------
    streams, source, fill_gaps_s : as :func:`one_clock` takes them
    expected : names of the sensors that are needed

    Returns
    -------
    recording, warnings, lags : as of :func:`one_clock`

    Raises
    ------
    InputError
        As :func:`one_clock`, of the sensors that are needed.
    """
    needed = {name: stream for name, stream in streams.items() if name in expected}
    if not needed or len(needed) == len(streams):
        return one_clock(streams, source, fill_gaps_s=fill_gaps_s)
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            found = one_clock(streams, source, fill_gaps_s=fill_gaps_s)
    except InputError as error:  # what was told of all of them is told again of those that are left
        recording, said, lags = one_clock(needed, source, fill_gaps_s=fill_gaps_s)
        others = [name for name in streams if name not in needed]
        left = "is left out, since it is" if len(others) == 1 else "are left out, since they are"
        return recording, (f"{error}; {listed(others)} {left} not needed", *said), lags
    for one in told:
        warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
    return found


def one_clock(
    streams: Mapping[str, Stream], source: str, *, fill_gaps_s: float = 0.0
) -> tuple[Recording, tuple[str, ...], dict[str, ClockLag]]:
    """Recording of sensors that may each have a clock of its own.

    Sensors whose streams name different clocks, and sensors of one file that share no time, are
    joined by their movement (:mod:`~mobility_imu.readers.lags`); a warning says by how much they
    were moved.

    Samples stay as they are if all sensors have the same times and these count samples or are
    increasing without gaps. Otherwise the sensors are interpolated to one even clock at the rate
    of the slowest; a gap longer than 0.1 s and than one and a half steps is refused unless
    ``fill_gaps_s`` is as long, and so is a clock that jumps back.

    Parameters
    ----------
    streams : sensor name to what it gave
    source : the first words of a message
    fill_gaps_s : s, gaps up to this length are bridged by straight lines

    Returns
    -------
    recording : Recording, from 0 s unless the times were kept
    warnings : of the readers, what was interpolated, and lags that were found
    lags : sensor name to its clock's lag and drift, for sensors that were joined by their movement

    Raises
    ------
    InputError
        Gaps, sensors whose lag the movement does not show, sensors that share no time although
        their stamps are to be believed, and whatever a Recording refuses.
    """
    said = [sentence for stream in streams.values() for sentence in stream.warnings]
    first = next(iter(streams.values()))
    same = all(
        stream.time_s is first.time_s or np.array_equal(stream.time_s, first.time_s, equal_nan=True)
        for stream in streams.values()
    )
    if not (same and first.counted):  # else Recording says where the times run backwards
        for name, stream in streams.items():
            check_forward(stream.time_s, f"{source}, {name}")
    streams, lags = _by_movement(streams, source)
    if lags:
        said.append(f"{source}: joined by their movement: {_lags_said(lags)}")
        same = False
    if same and (first.counted or _is_even(first.time_s)):
        time_s = first.time_s if first.counted else first.time_s - first.time_s[0]
        on_gap = _on_gaps(time_s)
        sensors = {name: Imu(s.acc_mps2, s.gyr_radps) for name, s in streams.items()}
        if fill_gaps_s > 0:
            time_s, sensors = fill_gaps(time_s, sensors, fill_gaps_s, source)
        recording = _recorded(time_s, sensors, source, on_gap)
        check_rate(recording.sampling_rate_hz, source, clock=True)
        return recording, tuple(said), lags
    rates = []
    for name, stream in streams.items():
        stamps = np.unique(stream.time_s)
        if len(stamps) < 3:
            raise InputError(f"{source}, {name}: fewer than three stamps that differ")
        step = np.diff(stamps)
        longest = max(AS_PRINTED * fill_gaps_s, longest_silent_gap(float(np.median(step))))
        if step.max() > longest:
            k = int(np.argmax(step))
            at_gap = (why for j, why in stream.gap_why.items() if stream.time_s[j] == stamps[k])
            why = "".join(f": {text}" for text in at_gap)
            raise InputError(
                f"{source}, {name}: gap of {step[k]:.3g} s after {stamps[k] - stamps[0]:.2f} s "
                f"({int((step > longest).sum())} longer than {longest:.3g} s){why}; "
                f"{BRIDGE if _can_be_filled(step[k]) else CUT}"
            )
        rates.append(_rate(step))
    rate = check_rate(min(rates), source, clock=True)
    recording, found = join_streams(streams, rate, source=source)
    said.append(f"{source}: interpolated to an even clock of {rate:.5g} Hz, for {_why(streams)}")
    return recording, tuple(dict.fromkeys([*found, *said])), lags


def _by_movement(
    streams: Mapping[str, Stream], source: str
) -> tuple[Mapping[str, Stream], dict[str, ClockLag]]:
    """Streams with stamps of one clock, and lags of those whose stamps were changed."""
    clocks: dict[str, list[str]] = {}
    for name, stream in streams.items():
        clocks.setdefault(stream.clock, []).append(name)
    groups = list(clocks.values())
    begin = max(float(stream.time_s.min()) for stream in streams.values())
    apart = begin >= min(float(stream.time_s.max()) for stream in streams.values())
    if len(groups) == 1 and len(streams) > 1 and apart:
        given = next((clock for clock in (BELIEVED, STARTED) if clock in clocks), None)
        if given is not None:
            spans = _spans({name: stream.time_s for name, stream in streams.items()})
            told = [sentence for stream in streams.values() for sentence in stream.warnings]
            shifts = "".join(f"; {text}" for text in told if text.startswith(f"{given}: "))
            raise InputError(
                f"{source}: the sensors share no time ({spans}){shifts}; leave out {given}"
            )
        if not any(stream.counted for stream in streams.values()):
            groups = [[name] for name in streams]
    if len(groups) <= 1:
        return streams, {}
    from mobility_imu.readers.lags import find_lags  # loads scipy.signal

    longest_s = max(float(np.ptp(stream.time_s)) for stream in streams.values())
    if longest_s > WORTH_A_LINE_S:
        _log.info(
            "%s: joining the clocks by their movement, %.0f min long; this takes a while",
            source,
            longest_s / 60,
        )
    lags = find_lags(streams, groups, source)
    moved = {name: lag for names, lag in zip(groups[1:], lags[1:], strict=True) for name in names}
    joined = {
        name: replace(stream, time_s=moved[name].times(stream.time_s)) if name in moved else stream
        for name, stream in streams.items()
    }
    return joined, moved


def _lags_said(lags: Mapping[str, ClockLag]) -> str:
    parts = []
    for name, lag in lags.items():
        text = f"{quoted(name)} lags by {lag.lag_s:.4f} ± {max(lag.lag_sd_s, 1e-4):.4f} s"
        if lag.drift:
            way = "fast" if lag.drift > 0 else "slow"
            text += f", clock {1e6 * abs(lag.drift):.0f} ± {1e6 * lag.drift_sd:.0f} ppm {way}"
        parts.append(text)
    return "; ".join(parts)


def _rate(step: FloatArray) -> float:
    """Rate of a sensor from the steps of its stamps; what was lost says nothing of it."""
    usual = _near_usual(step)
    if usual.mean() < MOSTLY_USUAL:  # no usual step: a logger that writes when it can
        usual = step <= longest_silent_gap(float(np.median(step)))
    return 1 / float(np.mean(step[usual]))


def _near_usual(step: FloatArray) -> NDArray[np.bool_]:
    """Which steps are near the median."""
    median = np.median(step)
    return np.asarray((step > 0.5 * median) & (step <= GAP_FACTOR * median))


def _is_even(time_s: FloatArray) -> bool:
    """Whether times increase without a gap, so that a Recording takes them as they are."""
    step = np.diff(time_s)
    if len(step) < 2 or not (step > 0).all():
        return False
    usual = float(np.median(step))
    return bool(usual / GAP_FACTOR <= step.min() and step.max() <= GAP_FACTOR * usual)


def _why(streams: Mapping[str, Stream]) -> str:
    return "its stamps are not even" if len(streams) == 1 else "each sensor has its own stamps"


def join_streams(
    streams: Mapping[str, Stream],
    rate_hz: float,
    *,
    offsets_s: Mapping[str, float] | None = None,
    source: str = "recording",
) -> tuple[Recording, tuple[str, ...]]:
    """Join sensors that have stamps of their own on one even clock, by linear interpolation.

    Parameters
    ----------
    streams : sensor name to what it gave
    rate_hz : Hz, of the common clock, which starts at 0 with the sensor that begins last and ends
        with the one that ends first
    offsets_s : s, added to a sensor's stamps, for sensors whose clocks differ by a constant
    source : the first words of a message

    Returns
    -------
    recording : Recording
    warnings : samples left out since their stamp is not after all before it, gaps that the
        interpolation bridges (lost samples; where no step is usual, more than 0.1 s), and what
        is left out at the ends because not all sensors have it

    Raises
    ------
    InputError
        If there is no sensor, an offset names none, or the sensors share no time.
    """
    check_rate(rate_hz, source)
    offsets = dict(offsets_s or {})
    unknown = [name for name in offsets if name not in streams]
    if not streams or unknown:
        raise InputError(f"{source}: no sensor {', '.join(unknown) or 'at all'}")
    said: list[str] = []
    clocks: dict[str, FloatArray] = {}
    kept: dict[str, NDArray[np.bool_]] = {}
    for name, stream in streams.items():
        said += stream.warnings
        stamps = stream.time_s + offsets.get(name, 0.0)
        before = np.maximum.accumulate(np.r_[-np.inf, stamps[:-1]])
        kept[name] = stamps > before
        clocks[name] = stamps[kept[name]]
        left_out = int((~kept[name]).sum())
        said += _oddities(clocks[name], left_out, stream.counted, f"{source}, {name}")
    begin = max(clock[0] for clock in clocks.values())
    span = min(clock[-1] for clock in clocks.values()) - begin
    if not span * rate_hz > 1:
        raise InputError(f"{source}: the sensors share no time ({_spans(clocks)})")
    said += ends_left_out(clocks, source)
    time_s = np.arange(0.0, span, 1.0 / rate_hz)

    def at_common(name: str, values: FloatArray | None) -> FloatArray | None:
        if values is None:
            return None
        here = values[kept[name]].T
        return np.column_stack([np.interp(time_s + begin, clocks[name], axis) for axis in here])

    sensors = {}
    for name, stream in streams.items():
        acc = at_common(name, stream.acc_mps2)
        assert acc is not None
        sensors[name] = Imu(acc, at_common(name, stream.gyr_radps))
    return recorded(time_s, sensors, source), tuple(said)


def losses(clock: FloatArray, counted: bool = False) -> NDArray[np.bool_]:
    """Steps in which samples are missing; a late stamp before an early one is no loss.

    Where no step is usual, it is those that are longer than a silent gap.

    Parameters
    ----------
    clock : (n,) array, s, increasing
    counted : whether the times count samples, so that every step longer than one is a loss

    Returns
    -------
    (n - 1,) bool array
    """
    step = np.diff(clock)
    if len(step) < 2:
        return np.zeros(len(step), bool)
    usual = float(np.median(step))
    long = step > GAP_FACTOR * usual
    if counted:
        return np.asarray(long)
    if _near_usual(step).mean() < MOSTLY_USUAL:
        return np.asarray(step > longest_silent_gap(usual))
    three = np.convolve(np.r_[usual, step, usual], np.ones(3), "valid")
    return np.asarray(long & (three > (2 + GAP_FACTOR) * usual))


def _oddities(clock: FloatArray, left_out: int, counted: bool, source: str) -> list[str]:
    """Sentences on stamps that were left out and on gaps that are bridged."""
    said = []
    if left_out:
        said.append(f"{source}: {left_out} sample(s) left out whose stamps repeat or run backwards")
    long = losses(clock, counted)
    if long.any():
        step = np.diff(clock)
        k = int(np.argmax(np.where(long, step, 0.0)))
        said.append(
            f"{source}: {int(long.sum())} gap(s) bridged by straight lines, the longest of "
            f"{step[k]:.3g} s, {clock[k] - clock[0]:.1f} s after the start"
        )
    return said


def _spans(clocks: Mapping[str, FloatArray]) -> str:
    return ", ".join(f"{name} {clock[0]:.3f}-{clock[-1]:.3f} s" for name, clock in clocks.items())


CUT = "cut the recording there"
BRIDGE = f"give --fill-gaps-s (fill_gaps_s in Python) to bridge it, or {CUT}"
BRIDGE_ALL = f"give --fill-gaps-s (fill_gaps_s in Python) of that length to bridge it, or {CUT}"


def _can_be_filled(gap_s: float) -> bool:
    """Whether the length that a message states of a gap is one that may be asked for."""
    return float(f"{gap_s:.3g}") <= LONGEST_FILL_S


def _on_gaps(time_s: FloatArray) -> str:
    """What to do about gaps that a Recording refuses: fill them only if all may be filled."""
    step = np.diff(time_s)
    with np.errstate(all="ignore"):  # of a clock that is refused for something else
        usual = float(np.median(step)) if len(step) else np.nan
        gaps = step[step > GAP_FACTOR * usual]
        added = (gaps / usual).sum() - len(gaps)
    if not len(gaps) or (_can_be_filled(gaps.max()) and _may_be_added(added, len(time_s))):
        return BRIDGE_ALL
    return CUT if len(gaps) == 1 else "cut the recording at its gaps"


def _recorded(
    time_s: FloatArray, sensors: Mapping[str, Imu], source: str, on_gap: str
) -> Recording:
    """Recording; if its clock is refused, the message ends with what to do."""
    try:
        return recorded(time_s, sensors, source)
    except InputError as error:
        advice = {"time_s: gap of": f"; {on_gap}"} | ADVICE
        found = next((do for words, do in advice.items() if words in str(error)), "")
        raise InputError(f"{error}{found}") from None


ADVICE = {
    "s appears twice (samples": "; remove one of the two rows",
    "time_s: runs backwards": "; sort the rows, or cut the recording there",
}
"""What to do where a Recording refuses a clock for something else, by words of its message."""
