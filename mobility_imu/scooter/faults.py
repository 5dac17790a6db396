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

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.faults import Fault, Repair, all_repaired, interpolated, with_costs
from mobility_imu.frames import FloatArray
from mobility_imu.health import FEWEST_VALUES, examine, fault_of, single_spikes
from mobility_imu.recording import Recording
from mobility_imu.scooter.contradictions import contradictions
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.mended import carried, lengthened, rebuilt, stretched
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
GROSS = {"lag": 0.1, "offset": 20.0, "turned": float("inf")}
"""Sizes (s, deg/s) from which on such faults are told whatever they cost."""
GROSS_SCALE = 1.3
"""The same of a scale, or of its inverse."""
BY_CHANCE = {"frozen_gyr": 1.0, "frozen_acc": np.inf, "range_gyr": 6, "range_acc": 6}
"""Sizes (s, samples) up to which such a fault is told only if it moves the angles. An accelerometer
in steps of 0.01 g repeats for seconds where it rests, and is not to be told from a stuck one; any
sensor reads its largest value for some samples."""
LARGEST_RESTING_MPS2 = 11.0
"""Readings that gravity explains, with scale and offset of a consumer sensor."""
LEAST_CUT_MPS2 = 1.0
"""Lengths of two such sensors differ by less."""
MOSTLY = 0.5
"""Part of the samples at which an axis cannot be at its largest value by chance."""
GRADED = (*GROSS, "scale")
"""Faults that every recording has a little of."""


def find_faults(
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None = None,
    settings: RideSettings | None = None,
) -> tuple[Fault, ...]:
    """Faults of the sensors of a ride, or of a parked recording, with what they cost.

    Beside what :func:`~mobility_imu.health.examine` finds of each sensor alone: the lever's sensor
    late against the body's; both exchanged; axes of a gyroscope with the wrong sign, or left-handed
    axes; scale and offset of a gyroscope; a sensor that is turned otherwise than the mount says;
    and two sensors that contradict each other. With one sensor, or without gyroscopes, or if the
    closed form distrusts most samples (a recording that is not of slow drive), only the former.

    What cannot be seen: scale and offset of an accelerometer, which on level ground are turns of
    it; a turn of a sensor by less than the mount is uncertain; a scale below some per cent; a turn
    of a sensor on a ride without curves and on smooth ground.

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
        the estimate trusts once the fault is undone. Where nothing can undo a fault, or the
        estimate is refused, there are none.

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
    alone = list(_alone(recording, settings.sensors, geometry, mount))
    together: list[Fault] = []
    complete = all(recording.sensor(name).gyr_radps is not None for name in settings.sensors)
    if len(settings.sensors) == 2 and complete and not any(f.code == "copy" for f in alone):
        if not any(fault.flags.all() for fault in alone):
            together = list(contradictions(_mended(alone, recording), geometry, mount))
    return _priced([*together, *alone], recording, geometry, mount, settings)


def _mended(faults: Iterable[Fault], recording: Recording) -> Recording:
    """Recording in which each fault is undone, as far as the result is a recording."""
    for fault in faults:
        try:
            recording = all_repaired([fault], recording)
        except InputError:
            continue
    return recording


def mark_faults(ride: RideAngles, faults: Iterable[Fault]) -> RideAngles:
    """Ride whose samples are not valid where a fault of a sensor that is used moves them.

    A fault counts if nothing can undo it, or if it moves an angle by more than its standard
    deviation; lags, scales, offsets and turns, of which every recording has a little, by more than
    twice that (20 deg where none is stated).

    Parameters
    ----------
    ride : RideAngles
    faults : of :func:`find_faults`, for the same recording

    Returns
    -------
    RideAngles
    """
    expect("ride", ride, RideAngles)
    valid = np.array(ride.valid)
    for fault in faults:
        if _is_used(fault, ride.settings) and _matters(fault, ride):
            valid &= ~fault.flags
    return replace(ride, valid=valid)


def _is_used(fault: Fault, settings: RideSettings) -> bool:
    """Whether the estimate reads what is at fault; only fusion reads gyroscopes."""
    if settings.method == "fusion":
        return True
    return "_gyr" not in fault.sensor and fault.code != "at odds"


def _matters(fault: Fault, ride: RideAngles) -> bool:
    if fault.repair is None:
        return True
    if fault.code not in GRADED:
        return bool(fault.costs)
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
    spiky = set()
    for fault in (*examine(recording), *_pinned(recording, names)):
        if not all(part.split("_")[0] in names for part in fault.sensor.split(", ")):
            continue
        if fault.code == "reversed" and len(names) == 2:
            continue  # both sensors together say it better
        if fault.code == "spike":
            spiky.add(fault.sensor)
        if _at_rest(recording, fault, names):
            continue
        if fault.code in ("frozen", "range"):
            fault = replace(fault, repair=_bridge(recording, fault, names, geometry, mount))
        yield fault
    for name in names:
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


def _at_rest(recording: Recording, fault: Fault, names: Sequence[str]) -> bool:
    """Whether an accelerometer at the end of its range just reads gravity, in coarse steps.

    Then its length is that of the other sensor without anything added.
    """
    if fault.code != "range" or len(names) < 2 or not fault.sensor.endswith("_acc"):
        return False
    if fault.size > LARGEST_RESTING_MPS2:
        return False
    name = fault.sensor.removesuffix("_acc")
    longer = lengthened(recording, name, fault.flags).sensor(name).acc_mps2
    added = np.abs(longer - recording.sensor(name).acc_mps2)[fault.flags].max(axis=1)
    return bool(np.median(added) < LEAST_CUT_MPS2)


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
    if len(names) < 2 or not gyroscopes:
        return fault.repair
    ways = {("frozen", "gyr"): rebuilt, ("frozen", "acc"): carried, ("range", "gyr"): stretched}
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
        self.angles_deg: list[FloatArray | None] = []
        self.sd_deg: FloatArray = np.zeros((2, 0))

    def __call__(self, recording: Recording) -> dict[tuple[str, str], FloatArray]:
        """Estimate of a recording; one that is refused leaves None."""
        self.angles_deg.append(None)
        ride = estimate_ride(recording, self.geometry, self.mount, self.settings)
        angles = np.rad2deg([ride.steering_rad, ride.throttle_rad])
        if len(self.angles_deg) == 1:
            stated = np.rad2deg([ride.steering_sd_rad, ride.throttle_sd_rad])
            self.sd_deg = np.where(np.isfinite(stated), stated, LEAST_MOVED_DEG)
        else:
            angles = np.where(ride.valid, angles, np.nan)
        self.angles_deg[-1] = angles
        return {(name, "deg"): series for name, series in zip(ANGLES, angles, strict=True)}

    def most_by_lag(self, lag_s: float, rate_hz: float) -> float:
        """How far a lag can move the angles at most, in their sd: by their rates."""
        found = self.angles_deg[0]
        if found is None:
            return np.inf
        rates = np.abs(np.gradient(found, axis=1)) * rate_hz
        return float((LAG_FACTOR * lag_s * rates / self.sd_deg).max())

    def moved_sds(self, run: int) -> FloatArray | None:
        """How far a repair moves the angles, (n,), in their sd; None if that is not known."""
        if run >= len(self.angles_deg):
            return None
        found, better = self.angles_deg[0], self.angles_deg[run]
        if found is None or better is None:
            return None
        return np.asarray(np.nan_to_num(np.abs(found - better) / self.sd_deg).max(axis=0))


def _priced(
    faults: Sequence[Fault],
    recording: Recording,
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
    settings: RideSettings,
) -> tuple[Fault, ...]:
    """Faults with their costs; without those that every recording has and that move nothing."""
    runs, run, told = _Runs(geometry, mount, settings), 0, []
    for fault in with_costs(faults, recording, runs):
        moved = None
        if fault.repair is not None:
            run += 1
            moved = runs.moved_sds(run)
        if moved is None:
            told.append(fault)
            continue
        most = float(moved.max(initial=0.0))
        if fault.code == "lag" and fault.size < USUAL["lag"]:
            most = min(most, runs.most_by_lag(fault.size, recording.sampling_rate_hz))
        if most < _least_sds(fault) and not _is_gross(fault):
            continue
        flags = fault.flags | (moved > UNTRUSTED_SDS)
        if most >= LEAST_SDS:
            costs = tuple(cost for cost in fault.costs if cost.largest >= SMALLEST_COST_DEG)
            told.append(replace(fault, costs=costs, flags=flags))
        else:
            # What a repair changes within the estimate's own noise is no measure of the fault.
            sentence = f"{fault.sentence}; {_says_little(settings, fault)}"
            told.append(replace(fault, costs=(), flags=flags, sentence=sentence))
    return tuple(told)


def _says_little(settings: RideSettings, fault: Fault) -> str:
    """That a fault hardly matters, in words that are true of the estimate."""
    if not _is_used(fault, settings):
        return "the closed form does not use it"
    if settings.method == "closed-form" and settings.acc_noise_mps2 is None:
        return f"it moves the angles by less than {LEAST_MOVED_DEG:.0f} deg"
    return "it moves the angles by less than their standard deviation"


def _least_sds(fault: Fault) -> float:
    """How far a fault has to move the angles to be told, in their sd."""
    if fault.code in GRADED:
        return UNTRUSTED_SDS if fault.size < USUAL.get(fault.code, 0.0) else LEAST_SDS
    size = fault.samples if fault.code == "range" else fault.size
    kind = f"{fault.code}_{fault.sensor.rpartition('_')[2]}"
    return LEAST_SDS if size < BY_CHANCE.get(kind, 0.0) else 0.0


def _is_gross(fault: Fault) -> bool:
    if fault.code == "scale":
        return max(fault.size, 1 / fault.size) > GROSS_SCALE
    return fault.size > GROSS.get(fault.code, np.inf)
