"""What is wrong with the sensors of a chair, and what it moves speed, turn and way by.

Beyond what any recording shows (:mod:`mobility_imu.health`), the three sensors of a chair know of
each other: :mod:`mobility_imu.wheelchair.contradictions`. Each look is made at the recording as the
looks before it have mended it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.faults import (
    Fault,
    all_repaired,
    as_faults,
    interpolated,
    one_sided,
    repaired_where_possible,
    with_costs,
)
from mobility_imu.frames import FloatArray, as_count, as_flags
from mobility_imu.health import examine, fault_of
from mobility_imu.offsets import GyroscopeOffset, offset_warnings
from mobility_imu.recording import Recording
from mobility_imu.wheelchair import (
    frame_faults,
    piece_faults,
    rest_faults,
    sign_faults,
    wheel_faults,
)
from mobility_imu.wheelchair.contradictions import SharedMotion, lone_jumps
from mobility_imu.wheelchair.dead_axis import with_axis_repair
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.recovery import (
    CHAIR,
    failed_gyroscopes,
    held_samples,
    others_of,
    recovery_warnings,
    replaced,
    unreplaced,
    with_gyroscope,
)
from mobility_imu.wheelchair.remarks import of_chair
from mobility_imu.wheelchair.rest_faults import offsets_not_told
from mobility_imu.wheelchair.saturation import saturated_gyroscopes, saturation_warnings
from mobility_imu.wheelchair.series import as_offsets
from mobility_imu.wheelchair.slip import at_odds
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

__all__ = [
    "find_faults",
    "not_told",
    "ranges_told",
    "results",
    "sensor_faults",
    "valid_samples",
    "with_valid",
]

LEAST_COST = {"m/s": 1e-3, "deg/s": 1e-2, "m": 1e-3, "deg": 1e-2}
"""Smaller changes of a result are no cost: below the noise of any sensor."""
SHORTEST_S = 5.0
"""In less time the sensors do not see enough of one motion to judge each other."""
SLOWEST_HZ = 10.0
"""A wheel at 4 m/s turns twice in a second: slower recordings do not show its turning."""
MUTE_PART = 0.3
"""A sensor that fails for more of the time is not used to judge others. Set by hand on simulated
courts that the study of faults does not use."""

Look = Callable[[SharedMotion], Iterator[Fault]]
LOOKS: tuple[Look, ...] = (
    frame_faults.taken_for_a_wheel,
    rest_faults.large_offsets,
    rest_faults.changing_offsets,
    wheel_faults.other_axles,
    wheel_faults.other_spins,
    frame_faults.tilted,
    frame_faults.other_signs,
    piece_faults.at_odds_in_part,
    wheel_faults.late,
    wheel_faults.wrong_scales,
    wheel_faults.wrong_offsets,
    frame_faults.wrong_scale_or_offset,
    piece_faults.still_at_odds_in_part,
    frame_faults.at_odds,
)
"""What is looked at, in this order: what turns a sensor round before what moves it a little."""


def find_faults(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings | None = None,
    *,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
) -> tuple[Fault, ...]:
    """Look for faults of the sensors of a drive, and find what they cost.

    Parameters
    ----------
    recording : Recording with sensors frame, left_wheel, right_wheel; one wheel may be missing,
        fewer faults are then seen
    geometry : WheelchairGeometry
    mount : WheelchairMount, from :func:`~mobility_imu.wheelchair.calibration.calibrate_mount`
    settings : VelocitySettings of the estimate; the corrected form if None
    offsets : sensor to GyroscopeOffset of other recordings of that day, such as
        ``calibration.offsets``

    Returns
    -------
    tuple of Fault
        empty if nothing was found; costs are of ``speed`` (m/s), ``yaw rate`` (deg/s), ``distance``
        (m, signed, from the start) and ``turn`` (deg, likewise). What a gyroscope costs that the
        others replace throughout is not known: the estimate replaces it as the repair does. Nor
        is what one costs that repeats its first reading, or its last one to the end.

    Raises
    ------
    InputError
        If an argument is of another kind, or a reading is larger than any sensor's.
    """
    settings = settings_or_default("settings", settings, VelocitySettings)
    found = sensor_faults(recording, geometry, mount, settings, offsets=offsets)

    def estimate(one: Recording) -> dict[tuple[str, str], FloatArray]:
        return results(one, geometry, mount, settings, offsets)

    if not found:
        return ()
    one = _own(recording, geometry, mount, settings)
    known = [replace(f, repair=None) if _is_unpriced(one, f) else f for f in found]
    return tuple(
        _without_trifles(replace(priced, repair=fault.repair))
        for priced, fault in zip(with_costs(known, recording, estimate), found, strict=True)
    )


def results(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings | None = None,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
) -> dict[tuple[str, str], FloatArray]:
    """Series of a drive that a fault can move.

    Parameters
    ----------
    recording, geometry, mount, settings, offsets : as for
        :func:`~mobility_imu.wheelchair.velocity.estimate_velocity`

    Returns
    -------
    dict from name and unit to (n,) array: speed, yaw rate, distance and turn from the start
    """
    drive = estimate_velocity(recording, geometry, mount, settings, offsets=offsets)
    speed, yaw = drive.linear_velocity_mps, np.rad2deg(drive.yaw_rate_radps)
    return {
        ("speed", "m/s"): speed,
        ("yaw rate", "deg/s"): yaw,
        ("distance", "m"): np.cumsum(speed) / drive.sampling_rate_hz,
        ("turn", "deg"): np.cumsum(yaw) / drive.sampling_rate_hz,
    }


def sensor_faults(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings | None = None,
    *,
    offsets: Mapping[str, GyroscopeOffset] | None = None,
) -> tuple[Fault, ...]:
    """Look for faults as :func:`find_faults` does, without their costs.

    Parameters
    ----------
    recording, geometry, mount, settings, offsets : as for :func:`find_faults`

    Returns
    -------
    tuple of Fault
    """
    expect("recording", recording, Recording)
    expect("geometry", geometry, WheelchairGeometry)
    expect("mount", mount, WheelchairMount)
    settings = settings_or_default("settings", settings, VelocitySettings)
    given = as_offsets(offsets)
    recording = of_chair(recording)
    if recording.sampling_rate_hz < SLOWEST_HZ:
        copies = (fault for fault in examine(recording) if fault.code == "copy")
        return (*copies, _slow_clock(recording))
    one = _own(recording, geometry, mount, settings)
    found = list(_of_one_sensor(one))
    if any(fault.code == "copy" for fault in found):
        return tuple(found)
    if recording.time_s[-1] - recording.time_s[0] < SHORTEST_S:
        return tuple(found)
    shared = _shared_motion(one, found, settings, given)
    if not shared.sides or "frame" not in shared.names:
        return tuple(found)
    looked: list[Fault] = []
    for look in LOOKS:
        new = list(look(shared))
        looked += new
        part = [fault for fault in new if fault.code == "at odds" and not fault.flags.all()]
        if any(fault.flags.mean() > piece_faults.MUCH for fault in part):
            break
        for fault in part:
            shared = replace(shared, touched=shared.spoiled | fault.flags)
        mending = [fault for fault in new if fault.repair is not None]
        if any(fault.code == "exchanged" for fault in mending):
            # What each sensor shows by itself, and what replaces it, goes by the right names now.
            named = repaired_where_possible(looked, recording)
            one = _own(named, geometry, mount, settings)
            shared = _shared_motion(one, _of_one_sensor(one), settings, shared.given)
        elif mending:
            mended = repaired_where_possible(mending, shared.recording)
            shared = replace(shared, recording=mended)
    return tuple(sign_faults.told_once([*found, *looked]))


def _shared_motion(
    one: _Own,
    own: Iterable[Fault],
    settings: VelocitySettings,
    given: Mapping[str, GyroscopeOffset],
) -> SharedMotion:
    """Motion by a recording in which what each sensor shows by itself is mended."""
    own, failed = list(own), one.failed
    mute = {name for name, flags in failed.items() if flags.mean() > MUTE_PART}
    blind = frozenset(_long_lost(own, "acc", "dead axis", "frozen"))
    # The frame knows its yaw rate without gravity; where gyroscopes are frozen is known better.
    mute |= _long_lost(own, "gyr", "dead axis") | (blind - {"frame"})
    touched = np.any([f.flags for f in own if not f.flags.all()] + [*failed.values()], axis=0)
    return SharedMotion(
        repaired_where_possible(own, one.recording),
        one.geometry,
        one.mount,
        given,
        failed,
        settings,
        frozenset(mute),
        touched if np.ndim(touched) else None,
        blind,
    )


def _long_lost(own: Iterable[Fault], half: str, *codes: str) -> set[str]:
    """Sensors with a half that has a fault of these kinds for too long."""
    lost = [f for f in own if f.code in codes and f.flags.mean() > MUTE_PART]
    return {name for name, which in (_parts(fault.sensor) for fault in lost) if which == half}


def _slow_clock(recording: Recording) -> Fault:
    whole = np.ones(len(recording), np.bool_)
    rate = recording.sampling_rate_hz
    return fault_of(
        recording, "clock", "time_s", whole,
        f"gives a sampling rate of {rate:g} Hz, at which no wheel's turning is seen; "
        "correct the file's times, which are in seconds (--sampling-rate-hz is for files without "
        "times)", size=rate, unit="Hz",
    )  # fmt: skip


class _Own(NamedTuple):
    """A recording whose sensors are looked at one by one, and where their gyroscopes fail."""

    recording: Recording
    geometry: WheelchairGeometry
    mount: WheelchairMount
    failed: Mapping[str, NDArray[np.bool_]]
    lost: Mapping[str, NDArray[np.bool_]]
    """Samples of failed gyroscopes that the estimate does not replace."""


def _own(
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    settings: VelocitySettings,
) -> _Own:
    works = [name for name, imu in recording.sensors.items() if imu.gyr_radps is not None]
    chair = [name for name in works if name in CHAIR]
    failed = failed_gyroscopes(recording, chair, mount, geometry)
    lost = unreplaced(failed, works) if settings.form == "corrected" else failed
    return _Own(recording, geometry, mount, failed, lost)


def _is_unpriced(one: _Own, fault: Fault) -> bool:
    """Whether no repair but the estimate's own is known, or none at all."""
    gyroscope = not fault.sensor.endswith("_acc")
    return _is_replaced(one, fault) or (gyroscope and one_sided(fault))


def _is_replaced(one: _Own, fault: Fault) -> bool:
    """Whether the others replace a frozen gyroscope in all samples that it repeats."""
    sensor, half = _parts(fault.sensor)
    if fault.code != "frozen" or half == "acc" or sensor not in one.failed:
        return False
    return sensor not in one.lost or not (fault.flags & one.lost[sensor]).any()


def _of_one_sensor(one: _Own) -> Iterator[Fault]:
    """What any recording shows; lone jumps; and better ways to undo what a gyroscope lost."""
    recording, geometry, mount, failed, _ = one
    found = list[Fault]()
    for fault in examine(recording):
        sensor, half = _parts(fault.sensor)
        if fault.code == "reversed":
            found.append(sign_faults.of_accelerometer(fault, recording, geometry, mount))
        elif half != "gyr" or sensor not in CHAIR or fault.code not in REPLACED:
            found.append(fault)
        elif fault.code == "dead axis":
            found.append(with_axis_repair(fault, sensor, recording, geometry, mount))
        elif fault.code == "range":
            found.append(_replaced(one, fault, sensor, fault.flags))
        elif sensor in failed:  # other repetitions are exact readings of a steady motion
            fault = _stand_in(one, fault, sensor)
            found.append(_replaced(one, fault, sensor, fault.flags | failed[sensor]))
    told = {(fault.code, *_parts(fault.sensor)): fault.flags for fault in found}
    for name, imu in recording.sensors.items():
        if imu.gyr_radps is None:
            continue
        none = np.zeros(len(recording), np.bool_)
        if ("frozen", name, "gyr") not in told and name in CHAIR:
            found += _held(one, name, told.get(("range", name, "gyr"), none))
        far = lone_jumps(imu.gyr_radps, imu.acc_mps2, recording.sampling_rate_hz)
        far &= ~failed.get(name, none)
        if ("spike", name, "gyr") not in told and far.any():
            found.append(_jumps(recording, name, imu.gyr_radps, far))
    yield from _whole_sensors(one, found)


REPLACED = frozenset({"frozen", "range", "dead axis"})
"""Codes of faults of a chair's gyroscope that the others undo better than its own readings."""


def _jumps(recording: Recording, name: str, gyr_radps: FloatArray, far: NDArray[np.bool_]) -> Fault:
    bridge = interpolated(recording, name, "gyr", far).gyroscope(name)
    size = float(np.abs(gyr_radps - bridge).max())
    return fault_of(
        recording, "spike", f"{name}_gyr", far,
        f"jumps for single samples (by {size:.2g} rad/s at most), far beyond what it usually does; "
        "remove them", size=size, unit="rad/s",
        repair=partial(interpolated, sensor=name, half="gyr", flags=far),
    )  # fmt: skip


def _held(one: _Own, name: str, cut: NDArray[np.bool_]) -> list[Fault]:
    """A gyroscope that repeats its last reading for some samples only; a cut range is another."""
    imu, failed = one.recording.sensor(name), one.failed.get(name, np.False_)
    held = held_samples(one.recording.gyroscope(name), imu.acc_mps2) & failed & ~cut
    if not held.any():
        return []
    found = fault_of(
        one.recording, "frozen", f"{name}_gyr", held, "",
        size=float(held.sum() / one.recording.sampling_rate_hz), unit="s",
    )  # fmt: skip
    return [_replaced(one, _stand_in(one, found, name), name, held)]


def _stand_in(one: _Own, fault: Fault, sensor: str) -> Fault:
    """A frozen sensor whose sentence says what the estimate does about it."""
    back = fault.flags & one.failed[sensor] & ~one.lost.get(sensor, np.False_)
    what = f"repeats its last reading; {others_of(sensor)} replace it there, where slip cannot be "
    if not back.any():
        what = "repeats its last reading; leave these times out, or record again"
    elif back.all() or (back == fault.flags).all():
        what += "seen"
    else:
        what += (
            f"seen, but in {int((fault.flags & ~back).sum())} of these samples another one fails "
            "as well; leave those out, or record again"
        )
    told = fault_of(one.recording, "frozen", fault.sensor, fault.flags, what)
    return replace(fault, sentence=told.sentence)


def _whole_sensors(one: _Own, found: Sequence[Fault]) -> Iterator[Fault]:
    """Faults; a sensor both of whose halves repeat the same samples is told once."""
    halves = {_parts(fault.sensor): fault for fault in found if fault.code == "frozen"}
    for fault in found:
        sensor, half = _parts(fault.sensor)
        acc, gyr = halves.get((sensor, "acc")), halves.get((sensor, "gyr"))
        whole = acc is not None and gyr is not None and (acc.flags == gyr.flags).all()
        if fault.code != "frozen" or not whole or sensor not in CHAIR:
            yield fault
        elif half == "gyr":
            assert acc is not None
            repair = partial(all_repaired, (acc, fault))
            yield _stand_in(one, replace(fault, sensor=sensor, repair=repair), sensor)


def _replaced(one: _Own, fault: Fault, sensor: str, flags: NDArray[np.bool_]) -> Fault:
    """Fault whose repair puts the two other gyroscopes in the place of one that fails."""
    otherwise = fault.repair or partial(interpolated, sensor=sensor, half="gyr", flags=flags)
    repair = partial(
        replaced,
        sensor=sensor,
        flags=flags,
        others=dict(one.failed),
        geometry=one.geometry,
        mount=one.mount,
        at_end=fault.code == "range",
        otherwise=otherwise,
    )
    return replace(fault, repair=repair)


def _parts(sensor: str) -> tuple[str, str]:
    """Name of the sensor and its half, empty where the fault is of both."""
    for half in ("acc", "gyr"):
        name, found, _ = sensor.partition(f"_{half}")
        if found:
            return name, half
    return sensor, ""


def _without_trifles(fault: Fault) -> Fault:
    """Fault whose costs below any sensor's noise are 0."""
    costs = tuple(
        cost if cost.largest >= LEAST_COST[cost.unit] else cost._replace(largest=0.0)
        for cost in fault.costs
    )
    return replace(fault, costs=costs)


SMALL = {"lag": 0.05, "scale": 0.03, "offset": 1.0, "mirrored": float("inf")}
"""Faults up to these sizes (s, fraction, deg/s) leave the samples valid: their cost is told. A
mirrored chair has the right speed; which way it turns is in question throughout."""


def valid_samples(faults: Iterable[Fault], count: int) -> NDArray[np.bool_]:
    """Where no fault, beyond small ones, touches a gyroscope that the result comes from.

    A gyroscope that repeats its last reading while the other two replace it counts as valid here:
    :class:`~mobility_imu.wheelchair.velocity.ChairVelocity` has flags of its own for where nothing
    replaces it. Samples at the end of a range are not valid, whatever the range: the estimate
    knows only ranges that are sold, and uses the readings of any other one as they are.

    Parameters
    ----------
    faults : Fault, of a drive
    count : samples of the recording

    Returns
    -------
    (n,) bool array
    """
    valid = np.ones(as_count(count, "count", least=0), np.bool_)
    for fault in as_faults(faults):
        as_flags(fault.flags, "flags of a fault", length=count)
        _, half = _parts(fault.sensor)
        small = fault.code in SMALL and not fault.size > SMALL[fault.code]
        if half != "acc" and fault.code != "frozen" and not small:
            valid &= ~fault.flags
    return valid


def with_valid(drive: ChairVelocity, faults: tuple[Fault, ...]) -> ChairVelocity:
    """Velocities whose ``valid`` also knows the faults that were found.

    Parameters
    ----------
    drive : ChairVelocity
    faults : Fault, of the same recording

    Returns
    -------
    ChairVelocity
    """
    expect("drive", drive, ChairVelocity)
    assert drive.valid is not None
    return replace(drive, valid=drive.valid & valid_samples(faults, len(drive)))


EXPLAINS = frozenset(
    {
        *("at odds", "dead axis", "exchanged", "lag", "mirrored", "offset", "range", "reversed"),
        *("scale", "turned"),
    }
)
"""Codes of faults for which wheels and frame may disagree throughout. Where they still do once the
others are mended, the look :func:`~mobility_imu.wheelchair.frame_faults.at_odds` tells it. Those of
an accelerometer alone explain nothing: the yaw rates that are compared are of gyroscopes."""


def ranges_told(recording: Recording, faults: Iterable[Fault]) -> set[str]:
    """Warnings of gyroscopes at the end of their range that faults say already.

    Parameters
    ----------
    recording : Recording that an estimate or a calibration used
    faults : Fault, of the same recording as it came

    Returns
    -------
    set of str
    """
    expect("recording", recording, Recording)
    told = _gyroscopes_with("range", as_faults(faults))
    cut = saturated_gyroscopes(recording, with_gyroscope(recording, CHAIR))
    return set(saturation_warnings(recording, {n: f for n, f in cut.items() if n in told}))


def _gyroscopes_with(code: str, faults: Iterable[Fault]) -> set[str]:
    """Sensors whose gyroscope has a fault of this kind."""
    parts = [_parts(fault.sensor) for fault in faults if fault.code == code]
    return {sensor for sensor, half in parts if half != "acc"}


def not_told(
    drive: ChairVelocity,
    recording: Recording,
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    faults: Iterable[Fault],
) -> list[str]:
    """Warnings of an estimate that no fault says already.

    A warning of a gyroscope at the end of its range, or replaced by the others, is left out where
    such a fault of that sensor is told, as is that of an offset that no rest shows; that wheels and
    frame disagree, where a fault explains it.
    One more warning says of a short drive that its sensors were not compared.

    Parameters
    ----------
    drive : ChairVelocity
    recording, geometry, mount : that it was estimated from
    faults : Fault, of the same drive

    Returns
    -------
    list of str
    """
    expect("drive", drive, ChairVelocity)
    expect("recording", recording, Recording)
    faults = as_faults(faults)
    names = with_gyroscope(recording, CHAIR)
    failed = failed_gyroscopes(recording, names, mount, geometry)
    frozen = _gyroscopes_with("frozen", faults)
    known = ranges_told(recording, faults) | set(
        recovery_warnings(
            recording,
            {name: flags for name, flags in failed.items() if name in frozen},
            unreplaced(failed, names),
        )
    )
    if any(fault.code in EXPLAINS and _parts(fault.sensor)[1] != "acc" for fault in faults):
        known |= set(
            at_odds(
                drive.slip,
                drive.wheel_yaw_rate_radps,
                drive.yaw_rate_radps,
                drive.settings.slip,
                recording.source,
            )
        )
    of_chair = [name for name in CHAIR if name in recording.sensors]
    unknown = set(offset_warnings(recording, drive.offsets, of_chair)) & set(drive.warnings)
    others = offsets_not_told(recording, drive.offsets, of_chair, faults) if unknown else ()
    left = [sentence for sentence in drive.warnings if sentence not in known | unknown]
    return [*others, *left, *_too_short(recording)]


def _too_short(recording: Recording) -> list[str]:
    """Warning that the sensors of a short drive were not compared with each other."""
    duration_s = float(recording.time_s[-1] - recording.time_s[0])
    if duration_s >= SHORTEST_S:
        return []
    return [
        f"{recording.source}: {duration_s:.1f} s are too short to compare the sensors with each "
        f"other ({SHORTEST_S:g} s or more); only what each shows by itself was looked for"
    ]
