"""Faults of a scooter's sensors: what one sensor shows, and what only lever and body show together.

:func:`mobility_imu.health.examine` looks at each sensor alone. Here both are held against each
other (:mod:`mobility_imu.scooter.agreement`), and against what a scooter does
(:mod:`mobility_imu.scooter.machine`). What is at odds is undone in every way that a fault could
have come about; the one after which the sensors agree best is named.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.faults import (
    Fault,
    Repair,
    as_faults,
    interpolated,
    reaches_an_end,
    repaired_where_possible,
    with_costs,
)
from mobility_imu.frames import FloatArray, as_flags, wrap_angle
from mobility_imu.health import examine, fault_of, single_spikes, unit_faults
from mobility_imu.recording import Recording
from mobility_imu.runs import FEWEST_VALUES, runs_of
from mobility_imu.scooter.contradictions import SHORTEST_S, Contradictions, contradictions
from mobility_imu.scooter.force import ends_in_a_jump, held_faults, scale_fault, weightless
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.mended import carried, cut_axes, lengthened, rebuilt, stretched
from mobility_imu.scooter.mount import ScooterMount
from mobility_imu.scooter.ride import RideAngles, RideSettings, estimate_ride

__all__ = ["find_faults", "mark_faults"]

LEAST_SDS = 1.0
"""A fault that every recording has a little of is told if it moves an angle by more than this times
its standard deviation."""
LEAST_MOVED_DEG = 1.0
"""Stands for the standard deviation where none is stated."""
UNTRUSTED_SDS = 2.0
"""A sample is not valid if a fault moves it by more than this times its standard deviation."""
UNTRUSTED_DEG = 20.0
"""The same, where none is stated: an error that the closed form allows in a valid sample
(``LARGEST_ERROR_RAD``)."""
SMALLEST_COST_DEG = 0.05
"""Costs below are not named."""
USUAL = {"lag": 0.03, "offset": 7.0}
"""Sizes (s, deg/s) that sound recordings of others have: clocks joined by hand (a chair against
motion capture), four standard deviations of a gyroscope's offset (data/reference/real_sensors.csv).
Up to them a fault has to move an angle by twice its standard deviation to be told."""
LAG_FACTOR = 2.0
"""A lag moves an angle by its rate, and by the scooter's own turning, which is as fast at most."""
ANGLES = ("steering", "throttle")
SPIKE_RADPS = 1.0
"""A rate that leaves both neighbours by more is no movement: a hand needs more than 20 ms to reach,
and to leave, 60 deg/s."""
QUICK_HZ = 50.0
"""Sampling rate from which on single readings are that short."""
GROSS = {"lag": 0.1, "offset": 20.0}
"""Sizes (s, deg/s) from which on such faults are told whatever they cost."""
GROSS_SCALE = 1.3
"""The same of a scale, or of its inverse."""
BY_CHANCE = {"frozen_gyr": 1.0, "frozen_acc": np.inf, "range_gyr": 6, "range_acc": 6}
"""Sizes (s, samples) up to which such a fault is told only if it moves the angles. An accelerometer
in steps of 0.01 g repeats for seconds where it rests, and is not to be told from a stuck one; any
sensor reads its largest value for some samples."""
LARGEST_RESTING_MPS2 = 11.0
"""Readings that gravity explains, with scale and offset of a consumer sensor: one that rests in
coarse steps is at its largest for long, and is not to be told from one that is cut there unless
the angles show it."""
MOSTLY = 0.5
"""Part of the samples at which an axis cannot be at its largest value by chance (in sound rides,
simulated, seeds 2 to 13: 0.1 % at most), and which a sensor must not have lost to be held against
another one: the median over a ride is then one of what it lost."""
GRADED = ("lag", "offset", "turned", "scale")
"""Faults that every recording has a little of."""
LOST = ("frozen", "no gravity")
"""Faults that leave no reading."""


def find_faults(
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None = None,
    settings: RideSettings | None = None,
) -> tuple[Fault, ...]:
    """Faults of the sensors of a ride, or of a parked recording, with what they cost.

    Beside what :func:`~mobility_imu.health.examine` finds of each sensor alone: the lever's sensor
    late against the body's; both exchanged, or one half of both; axes of a gyroscope with the wrong
    sign, or left-handed axes; scale and offset of a gyroscope; axes of an accelerometer with the
    wrong sign, or exchanged; a sensor that is turned otherwise than the mount says, or slips during
    the ride; an inclination of the steering at which the sensors agree, other than that of the
    geometry (code ``geometry``); and two sensors that contradict each other. Of each accelerometer:
    no gravity for a while; another length of gravity than a sensor can read; and readings that are
    given again.

    What both show together is not looked for with one sensor, without gyroscopes, below 5 s or
    10 Hz, where an accelerometer is lost for most of the time, or where a gyroscope or an axis says
    nothing throughout. Where the closed form distrusts most samples (a recording that is not of
    slow drive), only exchanged sensors, wrong axes of an accelerometer, a sensor that slips, one
    that lies otherwise than it should at the beginning, and offsets at rest are looked for.

    What cannot be seen: a scale of an accelerometer below a fifth, and its offset, which on level
    ground are turns of it; a turn of a sensor by less than the mount is uncertain; a slip about the
    vertical, or one that moves the throttle by less than 10 deg or the steering by less than 25; a
    scale of a gyroscope below some per cent; a turn of a sensor on a ride without curves and on
    smooth ground; a reversed axis of a gyroscope that turns so little that fusion's angles stay
    within their standard deviation.

    Parameters
    ----------
    recording : Recording with a sensor ``lever`` and, unless it is used alone, ``body``
    geometry : ScooterGeometry
    mount : ScooterMount that is applied to the readings, or None
    settings : RideSettings, of the estimate that the costs are found with; None is the default

    Returns
    -------
    tuple of Fault
        The costs are the largest changes of steering and throttle, in deg, over the samples that
        the estimate trusts once the fault is undone; 0 where they are within what the estimate
        leaves uncertain. Where nothing can undo a fault, or the estimate is refused or trusts no
        sample, there are none.

    Raises
    ------
    InputError
        If a sensor is missing.

    Examples
    --------
    >>> from mobility_imu.scooter import SUZUKI_ET4D, find_faults
    >>> from mobility_imu.simulation.faults import late
    >>> from mobility_imu.simulation.scooter import COURSES, simulate_ride
    >>> ride = simulate_ride(COURSES["curves"], seed=1).recording
    >>> find_faults(ride, SUZUKI_ET4D)
    ()
    >>> [(f.code, round(f.size, 2)) for f in find_faults(late(ride, "lever", 0.3), SUZUKI_ET4D)]
    [('lag', 0.3)]
    """
    expect("recording", recording, Recording)
    expect("geometry", geometry, ScooterGeometry)
    expect("mount", mount, ScooterMount, none=True)
    settings = settings_or_default("settings", settings, RideSettings)
    for name in settings.sensors:
        recording.sensor(name)
    alone = _unless_shared(list(_alone(recording, settings.sensors, geometry, mount)), recording)
    # Both sensors together say better which signs are wrong, if they say something.
    others = [fault for fault in alone if fault.code != "reversed"]
    together = Contradictions()
    complete = all(recording.sensor(name).gyr_radps is not None for name in settings.sensors)
    if len(settings.sensors) == 2 and complete and not any(map(_is_lost, others)):
        together = _told_together(others, recording, geometry, mount)
    if together.signs_tested:
        alone = others
    return _priced([*together.faults, *alone], recording, geometry, mount, settings)


def _is_lost(fault: Fault) -> bool:
    """Whether too little is left of a sensor for another one to be held against it.

    A scale loses nothing: all readings come back.
    """
    if fault.code in LOST and fault.sensor.endswith("_acc"):
        return bool(fault.flags.mean() > MOSTLY)
    return fault.code != "scale" and bool(fault.flags.all())


def _unless_shared(faults: Sequence[Fault], recording: Recording) -> list[Fault]:
    """Faults of which none is undone by readings that the other sensor lost at the same time.

    What may be a rest in coarse steps keeps its repair: both sensors rest at the same time, and one
    that moves nothing is no fault.
    """
    lost = [fault for fault in faults if fault.code in LOST]

    def is_shared(fault: Fault) -> bool:
        name, _, half = fault.sensor.partition("_")
        shared = np.zeros(len(recording), np.bool_)
        for other in lost:
            if other.sensor.endswith(f"_{half}") and not other.sensor.startswith(f"{name}_"):
                shared |= other.flags & fault.flags
        if fault.size < _by_chance(fault):
            if half == "gyr":
                return False
            shared &= ends_in_a_jump(recording.sensor(name).acc_mps2, fault.flags)
        return bool(shared.any())

    return [
        replace(fault, repair=None) if fault.code in LOST and is_shared(fault) else fault
        for fault in faults
    ]


def _told_together(
    alone: Iterable[Fault],
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Contradictions:
    """What both sensors show together, with the faults of each undone.

    Where an accelerometer feels no gravity, or both sensors lost the same, nothing comes back that
    another sensor could be held against: the longest part without such a loss is looked at.
    """
    mended, kept = repaired_where_possible(alone, recording), np.ones(len(recording), np.bool_)
    for fault in alone:
        if fault.code == "no gravity" or (fault.code in LOST and fault.repair is None):
            kept &= ~fault.flags
    if kept.all():
        return contradictions(mended, geometry, mount)
    longest = max(runs_of(kept), key=lambda run: run.stop - run.start, default=slice(0, 0))
    if longest.stop - longest.start < SHORTEST_S * recording.sampling_rate_hz:
        return Contradictions()
    times = recording.time_s[longest]
    found = contradictions(mended.trim(times[0], times[-1]), geometry, mount)
    whole = np.ones(len(recording), np.bool_)
    first_s = float(recording.time_s[0])
    faults = tuple(replace(fault, flags=whole, first_s=first_s) for fault in found.faults)
    return Contradictions(faults, found.signs_tested)


def mark_faults(ride: RideAngles, faults: Iterable[Fault]) -> RideAngles:
    """Ride whose samples are not valid where a fault of a sensor that is used moves them.

    A fault counts if nothing can undo it, if it is not known what it costs, or if it moves an angle
    by more than its standard deviation; lags, scales, offsets and turns, of which every recording
    has a little, if they are known to move one by more than twice that (20 deg where none is
    stated). Fusion trusts nothing where both sensors lost readings at once.

    Parameters
    ----------
    ride : RideAngles
    faults : of :func:`find_faults`, for the same recording

    Returns
    -------
    RideAngles

    Raises
    ------
    InputError
        If an argument is something else, or a fault is of a recording of another length.
    """
    expect("ride", ride, RideAngles)
    faults = as_faults(faults)
    valid = np.array(ride.valid)
    closed = ride.settings.method == "closed-form"
    beside = ride.settings.median_window // 2 if closed else 0
    for fault in faults:
        as_flags(fault.flags, "flags of a fault", length=len(valid))
        if _is_used(fault, ride.settings) and _matters(fault, ride):
            valid &= ~fault.flags & (not _spoils_all(fault, ride.settings))
            if beside and fault.code in ("held", *LOST):
                # A median has the readings on both sides in it.
                valid &= ~ndimage.binary_dilation(fault.flags, iterations=beside)
    return replace(ride, valid=valid)


def _spoils_all(fault: Fault, settings: RideSettings) -> bool:
    """Whether the other samples are not to be trusted either.

    The filter learns its constants from what both sensors lost, and nothing shows by how much.
    """
    return settings.method == "fusion" and fault.code in LOST and fault.repair is None


def _is_used(fault: Fault, settings: RideSettings) -> bool:
    """Whether the estimate reads what is at fault; only fusion reads gyroscopes.

    Sensors at odds may have a wrong accelerometer as well as a wrong gyroscope.
    """
    return settings.method == "fusion" or "_gyr" not in fault.sensor


def _matters(fault: Fault, ride: RideAngles) -> bool:
    if fault.repair is None:
        return True
    if fault.code not in GRADED:
        return not fault.costs or any(cost.largest > 0 for cost in fault.costs)
    stated = {"steering": ride.steering_sd_rad, "throttle": ride.throttle_sd_rad}
    for cost in fault.costs:
        sd = stated[cost.name][np.isfinite(stated[cost.name])]
        limit = UNTRUSTED_SDS * float(np.rad2deg(np.median(sd))) if sd.size else UNTRUSTED_DEG
        if cost.largest > limit:
            return True
    return False


def _alone(
    recording: Recording,
    names: Sequence[str],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Iterator[Fault]:
    """Faults that one sensor shows by itself."""
    units = [fault for name in names for fault in unit_faults(recording, name)]
    yield from units
    # A part in g has no gravity, and so on: what else is wrong shows once it is converted.
    recording = repaired_where_possible(units, recording)
    spiky, told, broken = set(), dict[str, NDArray[np.bool_]](), set()
    dead = {f"{name}_acc": weightless(recording, name) for name in names}
    for fault in (held for name in names for held in held_faults(recording, name)):
        # The reading that is given again belongs to its repetitions.
        told[fault.sensor] = fault.flags | np.append(fault.flags[1:], False)
        yield fault
    for fault in (*examine(recording), *_pinned(recording, names)):
        if not all(part.split("_")[0] in names for part in fault.sensor.split(", ")):
            continue
        if fault.code == "spike":
            spiky.add(fault.sensor)
        if fault.code == "frozen":
            rest = _beside(recording, fault, dead.get(fault.sensor))
            if rest is None:
                continue
            fault = rest
        if _is_held_pose(recording, fault):
            continue
        if fault.code in ("frozen", "range"):
            # What repeats itself, or was told already, is not the end of a range as well.
            known = told.setdefault(fault.sensor, np.zeros(len(recording), np.bool_))
            if not (fault.flags & ~known).any():
                continue
            told[fault.sensor] = known | fault.flags
        if fault.code in ("range", "dead axis"):
            broken.add(fault.sensor.rpartition("_acc")[0])
        if fault.code in ("frozen", "range"):
            fault = replace(fault, repair=_bridge(recording, fault, names, geometry, mount))
        yield fault
    for name in names:
        lost = dead[f"{name}_acc"]
        if lost is not None:
            yield replace(lost, repair=_bridge(recording, lost, names, geometry, mount))
        # A cut or dead axis shortens what is left.
        scaled = None if name in broken else scale_fault(recording, name)
        if scaled is not None:
            yield scaled
        gyr = recording.sensor(name).gyr_radps
        quick = recording.sampling_rate_hz >= QUICK_HZ
        if gyr is None or not quick or f"{name}_gyr" in spiky:
            continue
        far = single_spikes(gyr, SPIKE_RADPS)
        if far.any():
            largest = float(np.abs(np.diff(gyr, axis=0)[far[1:]]).max())
            yield fault_of(
                recording, "spike", f"{name}_gyr", far,
                f"jumps for single samples (by {largest:.3g} rad/s at most), which no hand does; "
                "remove them", size=largest, unit="rad/s",
                repair=partial(interpolated, sensor=name, half="gyr", flags=far),
            )  # fmt: skip


def _beside(recording: Recording, frozen: Fault, dead: Fault | None) -> Fault | None:
    """Frozen samples in which an accelerometer feels gravity; those without are told as that."""
    if dead is None or not (frozen.flags & dead.flags).any():
        return frozen
    rest = frozen.flags & ~dead.flags
    if not rest.any():
        return None
    return fault_of(
        recording, "frozen", frozen.sensor, rest,
        "repeats its last reading; leave these times out, or record again",
        size=float(rest.sum() / recording.sampling_rate_hz), unit="s", repair=frozen.repair,
    )  # fmt: skip


def _is_held_pose(recording: Recording, fault: Fault) -> bool:
    """Whether what looks like the end of an accelerometer's range is a pose that is held.

    No axis is cut there: another one goes on beyond it.
    """
    if fault.code != "range" or fault.repair is None or not fault.sensor.endswith("_acc"):
        return False
    acc = recording.sensor(fault.sensor.removesuffix("_acc")).acc_mps2
    return not any(True for _ in cut_axes(acc, fault.flags))


def _pinned(recording: Recording, names: Sequence[str]) -> Iterator[Fault]:
    """Axes of an accelerometer that say one number, their largest, most of the time."""
    for name in names:
        acc = recording.sensor(name).acc_mps2
        size = np.abs(acc)
        for k in range(3):
            at_end = size[:, k] == size[:, k].max()
            others = np.delete(acc, k, axis=1)
            lively = all(len(np.unique(axis)) > FEWEST_VALUES for axis in others.T)
            if lively and MOSTLY < at_end.mean() < 1:
                yield fault_of(
                    recording, "range", f"{name}_acc", at_end,
                    f"stays at the end of its range, {size[:, k].max():.4g} m/s², most of the "
                    "time; choose a wider range", size=float(size[:, k].max()), unit="m/s²",
                )  # fmt: skip


def _bridge(
    recording: Recording,
    fault: Fault,
    names: Sequence[str],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Repair | None:
    """What puts the other sensors' knowledge where one repeats itself, or is cut."""
    name, half = fault.sensor.split("_")[:2]
    gyroscopes = all(recording.sensor(one).gyr_radps is not None for one in names)
    alone = len(names) < 2 or not gyroscopes
    if fault.code in LOST and half == "acc":
        # A line needs readings on both sides, the hinges' rates those on one.
        if fault.flags.all() or (alone and reaches_an_end(fault.flags)):
            return None
    if alone:
        return fault.repair
    ways = {("frozen", "gyr"): rebuilt, ("range", "gyr"): stretched}
    ways |= {(code, "acc"): carried for code in LOST}
    if (fault.code, half) == ("range", "acc"):
        return partial(lengthened, sensor=name, flags=fault.flags)
    way = ways.get((fault.code, half))
    if way is None:
        return fault.repair
    return partial(way, sensor=name, flags=fault.flags, geometry=geometry, mount=mount)


class _Runs:
    """Angles of a recording as it is, then once each fault is undone; in deg, and in their sd."""

    def __init__(
        self, geometry: ScooterGeometry, mount: ScooterMount | None, settings: RideSettings
    ) -> None:
        self.geometry, self.mount, self.settings = geometry, mount, settings
        self.found: FloatArray | None = None
        self.better: dict[int, FloatArray] = {}
        self.sd_deg: FloatArray = np.zeros((2, 0))
        self.undone: int | None = None

    def watched(self, number: int, fault: Fault) -> Fault:
        """Fault after whose repair the next estimate is that of a number.

        A frozen sensor that its repair leaves as it is has no known cost: the repair is refused.
        """
        repair = fault.repair
        if repair is None:
            return fault

        def mended(recording: Recording) -> Recording:
            self.undone = number
            better = repair(recording)
            if fault.code == "frozen" and _are_equal(better, recording):
                raise InputError(f"{recording.source}: {fault.sensor} has no reading to go on from")
            return better

        return replace(fault, repair=mended)

    def __call__(self, recording: Recording) -> dict[tuple[str, str], FloatArray]:
        """Estimate of a recording, the one of the last repair if there was one.

        Angles of a repaired recording are within half a turn of the others.
        """
        ride = estimate_ride(recording, self.geometry, self.mount, self.settings)
        angles = np.rad2deg([ride.steering_rad, ride.throttle_rad])
        if self.undone is None or self.found is None:
            stated = np.rad2deg([ride.steering_sd_rad, ride.throttle_sd_rad])
            self.sd_deg = np.where(np.isfinite(stated), stated, LEAST_MOVED_DEG)
            self.found = angles
        else:
            angles = self.found + np.rad2deg(wrap_angle(np.deg2rad(angles - self.found)))
            angles = np.where(ride.valid, angles, np.nan)
            self.better[self.undone] = angles
        return {(name, "deg"): series for name, series in zip(ANGLES, angles, strict=True)}

    def most_by_lag(self, lag_s: float, rate_hz: float) -> float:
        """How far a lag can move the angles at most, in their sd: by their rates."""
        if self.found is None:
            return np.inf
        rates = np.abs(np.gradient(self.found, axis=1)) * rate_hz
        return float((LAG_FACTOR * lag_s * rates / self.sd_deg).max())

    def moved_sds(self, number: int) -> FloatArray | None:
        """How far a repair moves the angles, (n,), in their sd; None if that is not known."""
        better = self.better.get(number)
        if self.found is None or better is None:
            return None
        apart = np.abs(self.found - better) / self.sd_deg
        return np.asarray(np.nan_to_num(apart).max(axis=0)) if np.isfinite(apart).any() else None


def _are_equal(first: Recording, second: Recording) -> bool:
    """Whether two recordings have the same readings."""
    return all(
        np.array_equal(imu.acc_mps2, other.acc_mps2)
        and (
            imu.gyr_radps is None
            or other.gyr_radps is None
            or np.array_equal(imu.gyr_radps, other.gyr_radps)
        )
        for imu, other in ((first.sensor(name), second.sensor(name)) for name in first.sensors)
    )


def _priced(
    faults: Sequence[Fault],
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
    settings: RideSettings,
) -> tuple[Fault, ...]:
    """Faults with their costs; without those that every recording has and that move nothing."""
    runs, told = _Runs(geometry, mount, settings), []
    watched = [runs.watched(k, fault) for k, fault in enumerate(faults)]
    for k, fault in enumerate(with_costs(watched, recording, runs)):
        fault = replace(fault, repair=faults[k].repair)
        moved = runs.moved_sds(k)
        if moved is None:
            told.append(_of_unknown_cost(fault, settings))
            continue
        most = float(moved.max(initial=0.0))
        if fault.code == "lag" and fault.size < USUAL["lag"]:
            most = min(most, runs.most_by_lag(fault.size, recording.sampling_rate_hz))
        if most < _least_sds(fault, settings) and not _is_gross(fault):
            continue
        flags, sentence = fault.flags | (moved > UNTRUSTED_SDS), fault.sentence
        least = SMALLEST_COST_DEG
        if most < LEAST_SDS:
            # What a repair changes within the estimate's own noise is no measure of the fault.
            least, sentence = np.inf, f"{sentence}; {_says_little(settings, fault)}"
        costs = tuple(c if c.largest >= least else c._replace(largest=0.0) for c in fault.costs)
        told.append(replace(fault, costs=costs, flags=flags, sentence=sentence))
    return tuple(told)


def _of_unknown_cost(fault: Fault, settings: RideSettings) -> Fault:
    if fault.code != "at odds" and not _spoils_all(fault, settings):
        return replace(fault, costs=())
    return replace(fault, costs=(), sentence=f"{fault.sentence}; the angles are not valid")


def _says_little(settings: RideSettings, fault: Fault) -> str:
    """That a fault hardly matters, in words that are true of the estimate."""
    if not _is_used(fault, settings):
        return "the closed form does not use it"
    if settings.method == "closed-form" and _is_scale_of_force(fault):
        return "the closed form takes it for an acceleration, and no sample is valid"
    if settings.method == "closed-form" and settings.acc_noise_mps2 is None:
        return f"it moves the angles by less than {LEAST_MOVED_DEG:.0f} deg"
    return "it moves the angles by less than their standard deviation"


def _least_sds(fault: Fault, settings: RideSettings) -> float:
    """How far a fault has to move the angles to be told, in their sd.

    An axis of a gyroscope that hardly turns looks reversed by its noise; one that turns moves them.
    """
    if fault.code == "reversed" and fault.sensor.endswith("_gyr") and _is_used(fault, settings):
        return LEAST_SDS
    if fault.code in GRADED:
        return UNTRUSTED_SDS if fault.size < USUAL.get(fault.code, 0.0) else LEAST_SDS
    if fault.code == "range" and fault.sensor.endswith("_acc"):
        if fault.size <= LARGEST_RESTING_MPS2:
            return LEAST_SDS
    size = fault.samples if fault.code == "range" else fault.size
    return LEAST_SDS if size < _by_chance(fault) else 0.0


def _by_chance(fault: Fault) -> float:
    """Size up to which such a fault may be none."""
    return BY_CHANCE.get(f"{fault.code}_{fault.sensor.rpartition('_')[2]}", 0.0)


def _is_scale_of_force(fault: Fault) -> bool:
    return fault.code == "scale" and fault.sensor.endswith("_acc")


def _is_gross(fault: Fault) -> bool:
    if _is_scale_of_force(fault):
        return True  # that small ones are no fault is known before
    if fault.code == "scale":
        return max(fault.size, 1 / fault.size) > GROSS_SCALE
    return fault.size > GROSS.get(fault.code, np.inf)
