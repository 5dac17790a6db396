"""What is wrong with the sensors of a chair, and what it moves speed, turn and way by.

Beyond what any recording shows (:mod:`mobility_imu.health`), the three sensors of a chair know of
each other: :mod:`mobility_imu.wheelchair.contradictions`. Each look is made at the recording as the
looks before it have mended it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.faults import Fault, Repair, all_repaired, interpolated, with_costs
from mobility_imu.frames import FloatArray
from mobility_imu.health import examine, fault_of
from mobility_imu.offsets import GyroscopeOffset
from mobility_imu.recording import Recording
from mobility_imu.wheelchair import frame_faults, wheel_faults
from mobility_imu.wheelchair.contradictions import Witnesses, lone_jumps
from mobility_imu.wheelchair.dead_axis import without_axis
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.recovery import CHAIR, failed_gyroscopes, held_samples, replaced
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

__all__ = ["find_faults", "results", "sensor_faults", "valid_samples", "with_valid"]

LEAST_COST = {"m/s": 1e-3, "deg/s": 1e-2, "m": 1e-3, "deg": 1e-2}
"""Smaller changes of a result are no cost: below the noise of any sensor."""
SHORTEST_S = 5.0
"""In less time the sensors do not see enough of one motion to judge each other."""
SLOWEST_HZ = 10.0
"""A wheel at 4 m/s turns twice in a second: slower recordings do not show its turning."""
MUTE_PART = 0.3
"""A gyroscope that fails for more of the time is not used to judge others."""

Look = Callable[[Witnesses], Iterator[Fault]]
LOOKS: tuple[Look, ...] = (
    frame_faults.taken_for_a_wheel,
    wheel_faults.other_axles,
    wheel_faults.other_spins,
    frame_faults.tilted,
    frame_faults.other_signs,
    wheel_faults.late,
    wheel_faults.wrong_scales,
    wheel_faults.wrong_offsets,
    frame_faults.wrong_scale_or_offset,
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
        (m, signed, from the start) and ``turn`` (deg, likewise)

    Raises
    ------
    InputError
        If an argument is of another kind.
    """
    settings = settings_or_default("settings", settings, VelocitySettings)
    found = sensor_faults(recording, geometry, mount, settings, offsets=offsets)

    def estimate(one: Recording) -> dict[tuple[str, str], FloatArray]:
        return results(one, geometry, mount, settings, offsets)

    return tuple(_without_trifles(fault) for fault in with_costs(found, recording, estimate))


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
    found = list(_of_one_sensor(recording, geometry, mount))
    if any(fault.code == "copy" for fault in found):
        return tuple(found)
    if recording.time_s[-1] - recording.time_s[0] < SHORTEST_S:
        return tuple(found)
    if recording.sampling_rate_hz < SLOWEST_HZ:
        return (*found, _slow_clock(recording))
    mended = all_repaired(found, recording)
    failed = _failed(recording, geometry, mount)
    mute = {name for name, flags in failed.items() if flags.mean() > MUTE_PART}
    mute |= {f.sensor.split("_gyr")[0] for f in found if f.code == "dead axis"}
    seen = partial(
        Witnesses,
        geometry=geometry,
        mount=mount,
        given=dict(offsets or {}),
        failed=failed,
        settings=settings,
        mute=frozenset(mute),
    )
    witnesses = seen(mended)
    if not witnesses.sides or "frame" not in witnesses.names:
        return tuple(found)
    for look in LOOKS:
        try:
            new = list(look(witnesses))
        except InputError:
            continue  # what the estimate refuses as well
        found += new
        if any(fault.repair is not None for fault in new):
            mended = all_repaired(new, mended)
            witnesses = seen(mended)
    return tuple(found)


def _slow_clock(recording: Recording) -> Fault:
    whole = np.ones(len(recording), np.bool_)
    rate = recording.sampling_rate_hz
    return fault_of(
        recording, "clock", "time_s", whole,
        f"gives a sampling rate of {rate:g} Hz, at which no wheel's turning is seen: times in s?",
        size=rate, unit="Hz",
    )  # fmt: skip


def _failed(
    recording: Recording, geometry: WheelchairGeometry, mount: WheelchairMount
) -> dict[str, NDArray[np.bool_]]:
    names = [name for name, imu in recording.sensors.items() if imu.gyr_radps is not None]
    names = [name for name in names if name in ("frame", "left_wheel", "right_wheel")]
    return failed_gyroscopes(recording, names, mount, geometry)


def _of_one_sensor(
    recording: Recording, geometry: WheelchairGeometry, mount: WheelchairMount
) -> Iterator[Fault]:
    """What any recording shows; lone jumps; and better ways to undo what a gyroscope lost."""
    failed = _failed(recording, geometry, mount)
    told: set[tuple[str, str]] = set()
    for fault in examine(recording):
        sensor, half = _parts(fault.sensor)
        if half == "gyr" and fault.code == "frozen" and sensor in CHAIR and sensor not in failed:
            continue  # exact readings of a steady motion
        told.add((fault.code, sensor) if half == "gyr" else ("", ""))
        if half == "gyr" and fault.code in ("frozen", "range"):
            flags = fault.flags | (
                failed.get(sensor, fault.flags) if fault.code == "frozen" else False
            )
            fault = replace(fault, repair=_by_others(sensor, flags, failed, geometry, mount, fault))
        elif half == "gyr" and fault.code == "dead axis" and sensor in CHAIR:
            axis = "xyz".index(fault.sensor[-1])
            fault = replace(fault, repair=partial(
                without_axis, sensor=sensor, axis=axis, geometry=geometry, mount=mount
            ))  # fmt: skip
        yield fault
    for name, imu in recording.sensors.items():
        if imu.gyr_radps is None:
            continue
        if ("frozen", name) not in told:
            yield from _held(recording, name, failed, geometry, mount)
        far = lone_jumps(imu.gyr_radps, imu.acc_mps2, recording.sampling_rate_hz)
        far &= ~failed.get(name, np.zeros_like(far))
        if ("spike", name) not in told and far.any():
            bridge = interpolated(recording, name, "gyr", far).gyroscope(name)
            size = float(np.abs(imu.gyr_radps - bridge).max())
            yield fault_of(
                recording, "spike", f"{name}_gyr", far,
                f"jumps for single samples (by {size:.2g} rad/s at most), far beyond what it "
                "usually does; remove them", size=size, unit="rad/s",
                repair=partial(interpolated, sensor=name, half="gyr", flags=far),
            )  # fmt: skip


def _held(
    recording: Recording,
    name: str,
    failed: Mapping[str, NDArray[np.bool_]],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
) -> Iterator[Fault]:
    """A gyroscope that repeats its last reading for some samples only."""
    held = held_samples(recording.gyroscope(name)) & failed.get(name, np.False_)
    if held.any():
        found = fault_of(
            recording, "frozen", f"{name}_gyr", held, "repeats its last reading",
            size=float(held.sum() / recording.sampling_rate_hz), unit="s",
        )  # fmt: skip
        yield replace(found, repair=_by_others(name, held, failed, geometry, mount, found))


def _by_others(
    sensor: str,
    flags: NDArray[np.bool_],
    failed: Mapping[str, NDArray[np.bool_]],
    geometry: WheelchairGeometry,
    mount: WheelchairMount,
    fault: Fault,
) -> Repair:
    """What puts the two other gyroscopes in the place of one that fails."""
    return partial(
        replaced,
        sensor=sensor,
        flags=flags,
        others=dict(failed),
        geometry=geometry,
        mount=mount,
        at_end=fault.code == "range",
        otherwise=fault.repair or partial(interpolated, sensor=sensor, half="gyr", flags=flags),
    )


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


def valid_samples(faults: tuple[Fault, ...], count: int) -> NDArray[np.bool_]:
    """Where no fault, beyond small ones, touches a gyroscope that the result comes from.

    A gyroscope that fails while the other two replace it counts as valid here;
    :class:`~mobility_imu.wheelchair.velocity.ChairVelocity` has flags of its own for the rest.

    Parameters
    ----------
    faults : Fault, of a drive
    count : samples of the recording

    Returns
    -------
    (n,) bool array
    """
    valid = np.ones(count, np.bool_)
    for fault in faults:
        _, half = _parts(fault.sensor)
        small = fault.code in SMALL and not fault.size > SMALL[fault.code]
        if half != "acc" and fault.code not in ("frozen", "range") and not small:
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
    assert drive.valid is not None
    return replace(drive, valid=drive.valid & valid_samples(faults, len(drive)))
