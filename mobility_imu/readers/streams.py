"""One sensor on its own clock, as a vendor's file has it: the state before sensors are joined."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import (
    GAP_FACTOR,
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_floats,
    as_series,
    as_vectors,
)
from mobility_imu.readers.table import NumberTable
from mobility_imu.readers.wording import quoted
from mobility_imu.results import Result
from mobility_imu.runs import long_runs

GIVEN = "given"
"""Where the rate of streams comes from whose file states none: from the user."""
BELIEVED = "clock=same"
"""Clock of streams whose stamps are believed, because the user says so."""
STARTED = "clock=start"
"""Clock of streams whose files began at one moment, because the user says so."""
UTC, LOCAL = "UTC", "local time"
"""What a time of day is in; local time differs from UTC by hours, which no file tells."""


@dataclass(frozen=True, eq=False, repr=False)
class Stream(Result):
    """What one sensor gave, on its own clock.

    Unlike a :class:`~mobility_imu.recording.Recording`, whose clock is checked, times may repeat,
    run backwards or leave gaps: :func:`~mobility_imu.readers.clocks.join_streams` mends that.

    Parameters
    ----------
    time_s : (n,) array, s, the sensor's own stamps
    acc_mps2 : (n, 3) array, m/s², specific force
    gyr_radps : (n, 3) array, rad/s, or None without a gyroscope
    source : where it comes from; error messages begin with it
    warnings : what the reader left out or found odd
    label : what the file calls the sensor, such as a number or a place on the body, until it is
        :meth:`called` otherwise
    file_label : what the file calls a sensor that is called otherwise; None for one that is not
    rate_from : where the sampling rate comes from
    counted : whether the times count samples, so that every step longer than one is a loss
    clock : which clock the stamps come from; streams with the same name here share one.
        :data:`BELIEVED` if the user says that they do, :data:`STARTED` if the user says that the
        files began together
    epoch_s : s, what is added to the times for a clock that other files share, such as the wall
        clock; None if the file does not tell it
    epoch_in : what that clock shows, :data:`UTC` or :data:`LOCAL`
    gap_why : why there is a gap that the file's own stamps do not show, by the sample before it

    Raises
    ------
    InputError
        If there is no sample, the lengths differ, or a value is no finite number.
    """

    time_s: FloatArray
    acc_mps2: FloatArray
    gyr_radps: FloatArray | None
    source: str = field(default="stream", kw_only=True)
    warnings: tuple[str, ...] = field(default=(), kw_only=True)
    label: str = field(default="", kw_only=True)
    rate_from: str = field(default="its clock", kw_only=True)
    counted: bool = field(default=False, kw_only=True)
    clock: str = field(default="", kw_only=True)
    file_label: str | None = field(default=None, kw_only=True)
    epoch_s: float | None = field(default=None, kw_only=True)
    epoch_in: str = field(default=UTC, kw_only=True)
    gap_why: Mapping[int, str] = field(default_factory=dict, kw_only=True)

    def __post_init__(self) -> None:
        """Check shapes and numbers."""
        # What counts samples becomes a Recording as it is, which says which value is at fault.
        name = f"{self.source}: time_s"
        time_s = as_floats(self.time_s, name) if self.counted else as_series(self.time_s, name)
        if not len(time_s):
            raise InputError(f"{self.source}: no usable sample")
        object.__setattr__(self, "time_s", time_s)
        for name in ("acc_mps2", "gyr_radps"):
            given = getattr(self, name)
            if given is None and name == "gyr_radps":
                continue
            values = as_vectors(
                given, f"{self.source}: {name}", length=len(time_s), finite=not self.counted
            )
            object.__setattr__(self, name, values)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time_s)

    def called(self, label: str, *, clock: str | None = None) -> Stream:
        """The same stream under another label.

        Parameters
        ----------
        label : name of the sensor
        clock : which clock its stamps come from; as before if None

        Returns
        -------
        Stream
        """
        return replace(
            self,
            label=label,
            clock=self.clock if clock is None else clock,
            file_label=self.label if self.file_label is None else self.file_label,
        )


class Asked(NamedTuple):
    """What the user says of a file that does not say it itself.

    Parameters
    ----------
    sampling_rate_hz : Hz, or None
    own_clocks : whether each sensor has a clock of its own, also within a session
    """

    sampling_rate_hz: float | None = None
    own_clocks: bool = False

    def rate(self, source: str, what: str, hint: str = "") -> float:
        """Sampling rate that the user gave, for a file that has no clock.

        Parameters
        ----------
        source : the file's name, for messages
        what : what states no rate
        hint : where else it may be found

        Returns
        -------
        float, Hz

        Raises
        ------
        InputError
            If none was given; the message asks for it.
        """
        if self.sampling_rate_hz is None:
            raise InputError(
                f"{source}: {what} states no sampling rate{hint}; give it with "
                "--sampling-rate-hz (sampling_rate_hz in Python)"
            )
        return self.sampling_rate_hz

    def unused(self, streams: Sequence[Stream]) -> tuple[str, ...]:
        """Whether a given sampling rate differs from that of a file's own clock, which is kept.

        A difference of less than :data:`LARGEST_RATE_DIFFERENCE` is not told.

        Parameters
        ----------
        streams : of one recording

        Returns
        -------
        tuple of str, one sentence for each stream that has another rate
        """
        said = []
        for stream in streams if self.sampling_rate_hz is not None else ():
            own = None if stream.rate_from == GIVEN else rate_of_stamps(stream.time_s)
            assert self.sampling_rate_hz is not None
            if own is not None and not same_rate(self.sampling_rate_hz, own):
                said.append(
                    f"{stream.source}: the given {self.sampling_rate_hz:g} Hz are not used: it has "
                    f"{own:.5g} Hz from {stream.rate_from}"
                )
        return tuple(dict.fromkeys(said))


def rate_of_stamps(time_s: FloatArray) -> float | None:
    """Rate of the rows by their stamps; those that repeat or run back, and losses, do not count.

    Parameters
    ----------
    time_s : (n,) array, s

    Returns
    -------
    float, Hz; None if no stamp is after another
    """
    step = np.diff(time_s)
    step = step[step > 0]
    if not len(step):
        return None
    return 1 / float(np.mean(step[step <= GAP_FACTOR * np.median(step)]))


def same_rate(stated_hz: float, own_hz: float) -> bool:
    """Whether a stated rate is that of a clock, to :data:`LARGEST_RATE_DIFFERENCE`.

    Parameters
    ----------
    stated_hz : Hz, of the user or of a file's head
    own_hz : Hz, of the stamps

    Returns
    -------
    bool
    """
    return abs(stated_hz - own_hz) <= LARGEST_RATE_DIFFERENCE * own_hz


def contradicted(stated_hz: float, time_s: FloatArray, column: str, source: str) -> tuple[str, ...]:
    """Sentence on a rate of a file's head that its stamps do not have; the stamps are the clock.

    Parameters
    ----------
    stated_hz : Hz
    time_s : (n,) array, s, the stamps
    column : name of theirs
    source : the file's name, for messages

    Returns
    -------
    tuple of str, empty or with one sentence
    """
    own_hz = rate_of_stamps(time_s)
    if own_hz is None or same_rate(stated_hz, own_hz):
        return ()
    return (
        f"{source}: the {stated_hz:g} Hz of its head are not used: its column {column} has "
        f"{own_hz:.5g} Hz; if the times are wrong, correct them",
    )


def times_of_rows(count: int, rate_hz: float, source: str) -> tuple[FloatArray, str]:
    """Times of rows that have neither stamps nor a counter: their number over a stated rate.

    Parameters
    ----------
    count : number of rows
    rate_hz : Hz
    source : the file's name, for messages

    Returns
    -------
    time_s : (n,) array, s
    said : sentence that says what these times do not show
    """
    said = (
        f"{source}: its rows are counted at {rate_hz:g} Hz, without a clock or packet counter: "
        "lost samples cannot be seen"
    )
    return np.arange(count) / rate_hz, said


FEWEST_TO_JUDGE = 100
"""Samples, one second of most sensors; fewer are not judged. Set by hand."""
MOSTLY_HELD = 0.5
"""More repeated samples than half: the rate of the rows is not the rate of the sensor."""
MOSTLY_TOGETHER = 0.5
"""Part of the new samples that are new on all axes, below which the repeats come from coarse steps.
Three axes of a sensor at rest seldom pass a step at once. Real files have 0.75 or more where
samples are held, 0.03 or less where a sensor with coarse steps rests."""
LONGEST_HELD_S = 0.25
"""s; a sensor that repeats itself for longer is frozen there, as :mod:`mobility_imu.quality` tells,
and not slower than its rows."""
LARGEST_RATE_DIFFERENCE = 0.01
"""Part by which a given sampling rate may differ from that of a file's own clock: a rate that is
rounded to a whole number from 50 Hz on. Crystals differ by a hundredth of it."""
FACTORS = {
    "acc": {"m/s2": 1.0, "g": STANDARD_GRAVITY_MPS2, "mg": STANDARD_GRAVITY_MPS2 / 1000},
    "gyr": {"rad/s": 1.0, "deg/s": float(np.pi / 180), "mrad/s": 1e-3},
    "speed": {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 0.01, "mm/s": 0.001},
}
"""Units of acceleration, angular rate and speed, and what turns them into m/s², rad/s and m/s."""
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
"""Seconds of the units of time that a column's name or a map may state."""
QUANTITIES = {"acc": "acceleration", "gyr": "angular rate", "speed": "speed"}
SPELLINGS = {
    "ms-2": "m/s2", "m/s/s": "m/s2", "mps2": "m/s2", "milli-g": "mg",
    "degs-1": "deg/s", "degps": "deg/s", "dps": "deg/s", "rads-1": "rad/s", "radps": "rad/s",
    "rads": "rad/s", "mrads-1": "mrad/s", "mradps": "mrad/s",
    "ms-1": "m/s", "mps": "m/s", "cms-1": "cm/s", "cmps": "cm/s", "mms-1": "mm/s", "mmps": "mm/s",
    "kmh-1": "km/h", "kmh": "km/h", "kph": "km/h", "kmph": "km/h",
}  # fmt: skip
_SIGNS = str.maketrans(
    {"°": "deg", "º": "deg", "⁻": "-", "−": "-", "¹": "1", "²": "2"} | dict.fromkeys(".·⋅*^()âÂ")
)
"""What signs of units stand for; Â is before some where UTF-8 was taken for another encoding."""


def known_unit(quantity: str, text: str) -> str | None:
    """Unit that a text is, however it is spelled.

    Parameters
    ----------
    quantity : "acc", "gyr" or "speed"
    text : as the file or the user writes it

    Returns
    -------
    str, as in :data:`FACTORS`; None if it is no unit of the quantity

    Examples
    --------
    >>> known_unit("gyr", "°·s⁻¹"), known_unit("acc", "mph")
    ('deg/s', None)
    """
    plain = re.sub("degrees?", "deg", "".join(text.lower().split()).translate(_SIGNS))
    unit = SPELLINGS.get(plain, plain)
    return unit if unit in FACTORS[quantity] else None


def factor(quantity: str, unit: str, source: str) -> float:
    """What a reading is multiplied by to be in m/s², rad/s or m/s.

    Parameters
    ----------
    quantity : "acc", "gyr" or "speed"
    unit : as the file or the user writes it
    source : the file's name, for messages

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the unit is not known.

    Examples
    --------
    >>> factor("acc", "g", "walk.csv")
    9.80665
    """
    known = known_unit(quantity, unit)
    if known is None:
        raise InputError(
            f"{source}: {QUANTITIES[quantity]} in '{quoted(unit)}' is not known; expected "
            f"{', '.join(FACTORS[quantity])}"
        )
    return FACTORS[quantity][known]


def held_warnings(time_s: FloatArray, acc_mps2: FloatArray, source: str) -> tuple[str, ...]:
    """Whether most rows repeat the one before: a logger that writes faster than its sensor reads.

    A sensor that never changes, or not for a while, is a fault of its own
    (:func:`mobility_imu.health.examine`); coarse steps at rest are none: axes change one by one.

    Parameters
    ----------
    time_s : (n,) array, s
    acc_mps2 : (n, 3) array, m/s²
    source : the file's name, for messages

    Returns
    -------
    tuple of str, empty or with one sentence
    """
    changed = np.diff(acc_mps2, axis=0) != 0
    held = ~changed.any(axis=1)
    span = float(np.ptp(time_s))
    if len(held) < FEWEST_TO_JUDGE or not span > 0:
        return ()
    shortest = max(2, round(LONGEST_HELD_S * len(held) / span))
    frozen = long_runs(held, shortest, grow=False)
    span -= float(np.diff(time_s)[frozen].sum())
    changed, held = changed[~frozen], held[~frozen]
    if len(held) < FEWEST_TO_JUDGE or not span > 0 or held.mean() <= MOSTLY_HELD or held.all():
        return ()
    if changed[~held].all(axis=1).mean() < MOSTLY_TOGETHER:
        return ()
    return (
        f"{source}: {100 * held.mean():.0f} % of the samples repeat the one before; the "
        f"accelerometer gives about {int((~held).sum()) / span:.0f} new values a second",
    )


def stream_in_g_and_degrees(
    table: NumberTable, time_s: FloatArray, acc: list[str], gyr: list[str]
) -> Stream:
    """Stream from columns in g and deg/s.

    Parameters
    ----------
    table : the file's columns
    time_s : (n,) array, s
    acc : names of the three columns of the accelerometer, g
    gyr : names of the three columns of the gyroscope, deg/s

    Returns
    -------
    Stream
    """
    return Stream(
        time_s,
        table.columns(acc, finite=True) * STANDARD_GRAVITY_MPS2,
        np.deg2rad(table.columns(gyr, finite=True)),
        source=table.source,
    )
