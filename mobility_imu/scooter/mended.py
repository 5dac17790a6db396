"""Readings that a sensor lost, from those of the others: as good as can be, for the cost of a loss.

The rates of a gyroscope that says nothing follow from the other one and the closed form's angles;
an acceleration that stands still follows from the other one and the gyroscopes' angles.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.errors import InputError
from mobility_imu.faults import with_half
from mobility_imu.frames import FloatArray
from mobility_imu.hinges import column_vector, hinge_rates, steered, turn
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of
from mobility_imu.scooter.agreement import MEAN_S, seen_by
from mobility_imu.scooter.geometry import ScooterGeometry, rotation_lever_to_body
from mobility_imu.scooter.mount import ScooterMount

__all__ = ["carried", "cut_axes", "lengthened", "rebuilt", "stretched"]

BESIDE_S = 0.3
"""Samples so close to a loss give no angles: the means of ``MEAN_S`` reach into it from there."""
SHORTEST_CUT = 3
"""Samples that an axis stays at the end of its range, at least; fewer are a peak."""
UNTURNED = np.eye(3)


def rebuilt(
    recording: Recording,
    sensor: str,
    flags: NDArray[np.bool_],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Recording:
    """Recording in which a gyroscope's lost rates are those that the other sensors expect.

    The two hinges turn as the closed form's averaged angles do; the rest is the other gyroscope's.

    Parameters
    ----------
    recording : Recording of lever and body with gyroscopes
    sensor : "lever" or "body", whose rates are lost
    flags : (n,) bool array, the lost samples
    geometry : ScooterGeometry
    mount : ScooterMount, or None

    Returns
    -------
    Recording
    """
    rate_hz, axes = recording.sampling_rate_hz, _axes(mount)
    acc = {name: recording.sensor(name).acc_mps2 @ turns.T for name, turns in axes.items()}
    seen = seen_by(acc["lever"], acc["body"], rate_hz, geometry)
    angles = seen.steering_rad, seen.throttle_rad
    steering_radps, throttle_radps = (np.gradient(a) * rate_hz for a in angles)
    tip, alpha = angles[1] + geometry.lean_rad, geometry.steering_inclination_rad
    if sensor == "lever":
        column = column_vector(recording.gyroscope("body") @ axes["body"].T, alpha)
        beside, ahead = steered(column, angles[0])
        y, z = turn(ahead, column.k1 + steering_radps, -np.sin(tip), np.cos(tip))
        expected = np.column_stack([beside - throttle_radps, y, z])
    else:
        lever = recording.gyroscope("lever") @ axes["lever"].T
        across, shaft = turn(lever[:, 1], lever[:, 2], np.sin(tip), np.cos(tip))
        x, c1 = turn(lever[:, 0] + throttle_radps, across, -np.sin(angles[0]), np.cos(angles[0]))
        y, z = turn(c1, shaft - steering_radps, -np.sin(alpha), np.cos(alpha))
        expected = np.column_stack([x, y, z])
    rates = np.where(flags[:, None], expected @ axes[sensor], recording.gyroscope(sensor))
    return with_half(recording, sensor, "gyr", rates)


def stretched(
    recording: Recording,
    sensor: str,
    flags: NDArray[np.bool_],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Recording:
    """Recording in which cut rates bow over the end of the range as the other sensors expect.

    Of what those say, only the mean over each time at the end counts; it is no less than the end.

    Parameters
    ----------
    recording : Recording of lever and body with gyroscopes
    sensor : "lever" or "body", whose rates are cut
    flags : (n,) bool array, the samples at the end of the range
    geometry : ScooterGeometry
    mount : ScooterMount, or None

    Returns
    -------
    Recording
    """
    rates = np.array(recording.gyroscope(sensor))
    expected = rebuilt(recording, sensor, flags, geometry, mount).gyroscope(sensor)
    for k, axis, limit, at_end in cut_axes(rates, flags):
        for cut in runs_of(at_end):
            sign = np.sign(axis[cut.start])
            beyond = max(0.0, float(np.mean(sign * expected[cut, k])) - limit)
            count = cut.stop - cut.start
            across = (np.arange(count) + 0.5) / count * 2 - 1
            rates[cut, k] = sign * (limit + beyond * 1.5 * (1 - across**2))
    return with_half(recording, sensor, "gyr", rates)


def lengthened(recording: Recording, sensor: str, flags: NDArray[np.bool_]) -> Recording:
    """Recording in which a cut axis of an accelerometer is as long as the other sensor says.

    Whatever the angles, both measure accelerations of one length; averaged, for blows are not
    shared.

    Parameters
    ----------
    recording : Recording of lever and body
    sensor : "lever" or "body", whose accelerations are cut
    flags : (n,) bool array, the samples at the end of the range

    Returns
    -------
    Recording
    """
    other = "body" if sensor == "lever" else "lever"
    width = max(1, round(MEAN_S * recording.sampling_rate_hz))
    length, values = (
        ndimage.uniform_filter1d(recording.sensor(name).acc_mps2 ** 2, width, axis=0)
        for name in (other, sensor)
    )
    acc = np.array(recording.sensor(sensor).acc_mps2)
    for k, axis, limit, cut in cut_axes(acc, flags):
        rest = values.sum(axis=1) - values[:, k]
        size = np.sqrt(np.maximum(length.sum(axis=1) - rest, limit**2))
        acc[cut, k] = (np.sign(axis) * size)[cut]
    return with_half(recording, sensor, "acc", acc)


def cut_axes(
    values: FloatArray, flags: NDArray[np.bool_]
) -> Iterator[tuple[int, FloatArray, float, NDArray[np.bool_]]]:
    """Axes that are cut, their readings, the end of their range, and where they are at it.

    Flags are of samples, not of axes. All axes of a sensor have one range: an axis that ends below
    the largest reading is not cut, nor one that is there for a sample or two, nor one that goes on
    beyond it elsewhere for longer than a peak.

    Parameters
    ----------
    values : (n, 3) array, of one half of a sensor
    flags : (n,) bool array, samples that may be at the end of the range

    Yields
    ------
    number of the axis, its readings, the end of its range in the values' unit, and (n,) bool array
    """
    sizes = np.abs(values)
    limit = float(sizes[flags].max(initial=0.0))
    for k, axis in enumerate(np.array(values.T)):
        at_end = flags & (sizes[:, k] == limit)
        if _lasts(at_end) and not _lasts(sizes[:, k] > limit):
            yield k, axis, limit, at_end


def _lasts(flags: NDArray[np.bool_]) -> bool:
    """Whether flags hold for more than a peak."""
    return any(run.stop - run.start >= SHORTEST_CUT for run in runs_of(flags))


def carried(
    recording: Recording,
    sensor: str,
    flags: NDArray[np.bool_],
    geometry: ScooterGeometry,
    mount: ScooterMount | None,
) -> Recording:
    """Recording in which an accelerometer's lost readings are those that the other one expects.

    In a loss the angles go on by the hinges' rates, from what they were before to what they are
    after it; with them eq. 5 turns the other sensor's acceleration.

    Parameters
    ----------
    recording : Recording of lever and body with gyroscopes
    sensor : "lever" or "body", whose accelerations are lost
    flags : (n,) bool array, the lost samples
    geometry : ScooterGeometry
    mount : ScooterMount, or None

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        If too little is left beside the loss for angles to go on from.
    """
    rate_hz, axes = recording.sampling_rate_hz, _axes(mount)
    acc = {name: recording.sensor(name).acc_mps2 @ turns.T for name, turns in axes.items()}
    gyr = {name: recording.gyroscope(name) @ turns.T for name, turns in axes.items()}
    seen = seen_by(acc["lever"], acc["body"], rate_hz, geometry)
    angles = np.column_stack([seen.steering_rad, seen.throttle_rad])
    beside = max(1, round(BESIDE_S * rate_hz))
    # Means that reach into a loss are no angles.
    known = ~ndimage.binary_dilation(flags, iterations=beside)
    if not known.any():
        raise InputError(f"{recording.source}: {sensor}_acc has no reading beside a loss")
    for lost in runs_of(~known):
        angles[lost] = _integrated(angles, gyr, lost, geometry, rate_hz)
    turns = rotation_lever_to_body(angles[:, 0], angles[:, 1], geometry)
    if sensor == "lever":
        expected = np.einsum("nji,nj->ni", turns, acc["body"])
    else:
        expected = np.einsum("nij,nj->ni", turns, acc["lever"])
    readings = recording.sensor(sensor).acc_mps2
    values = np.where(flags[:, None], expected @ axes[sensor], readings)
    return with_half(recording, sensor, "acc", values)


def _axes(mount: ScooterMount | None) -> dict[str, FloatArray]:
    """Rotations from both IMUs' axes to {T} and {B}."""
    if mount is None:
        return {"lever": UNTURNED, "body": UNTURNED}
    return {"lever": mount.rotation_lever_imu_to_lever, "body": mount.rotation_body_imu_to_body}


def _integrated(
    angles: FloatArray,
    gyr: dict[str, FloatArray],
    lost: slice,
    geometry: ScooterGeometry,
    rate_hz: float,
) -> FloatArray:
    """Angles within a loss, (m, 2): the hinges' rates, bent to the known angles on both sides."""
    count = lost.stop - lost.start
    before = angles[lost.start - 1] if lost.start else None
    after = angles[lost.stop] if lost.stop < len(angles) else None
    alpha = geometry.steering_inclination_rad
    sin, cos = float(np.sin(alpha)), float(np.cos(alpha))
    ways = []
    for start, order, step in ((before, range(count), 1), (after, range(count - 1, -1, -1), -1)):
        if start is None:
            continue
        way, now = np.empty((count, 2)), np.array(start)
        for k in order:
            at = lost.start + k
            tip = now[1] + geometry.lean_rad
            rates = hinge_rates(gyr["lever"][at], gyr["body"][at], now[0], tip, sin, cos)[:2]
            now = now + step * np.array(rates) / rate_hz
            way[k] = now
        ways.append(way)
    if len(ways) == 1:
        return ways[0]
    part = np.linspace(0, 1, count)[:, None]
    return np.asarray((1 - part) * ways[0] + part * ways[1])
