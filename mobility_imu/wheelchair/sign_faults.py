"""Wrong signs and mixed axes of a wheel's sensor: which of its two halves, told once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mobility_imu.faults import Fault, all_repaired, multiplied
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.recording import Recording
from mobility_imu.wheelchair.contradictions import SharedMotion
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.lags import lag_between
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.recovery import tied_rate

__all__ = ["correlation_of", "of_accelerometer", "reads_gravity", "told_once"]

GO_TOGETHER, APART = 0.95, 0.9
"""Correlations of rates that surely are of one motion, and of such that are not. Set by hand on
simulated courts that the study of faults does not use."""


def correlation_of(first: FloatArray, second: FloatArray, rate_hz: float) -> float:
    """Correlation of two series at the lag that suits them best; 0 where they do not go together.

    Parameters
    ----------
    first, second : (n,) arrays
    rate_hz : samples per second
    """
    lag = lag_between(first, second, rate_hz)
    return 0.0 if lag is None else lag.correlation


def reads_gravity(w: SharedMotion, name: str) -> bool:
    """Whether a wheel's own yaw rate is the others', turned round, and its spin is right.

    Parameters
    ----------
    w : SharedMotion
    name : sensor of a wheel
    """
    others = [n for n in w.yaw if n != name]
    if len(others) < 2 or not w.turns(others[0]):
        return False
    first, second = (w.yaw[other] for other in others)
    spins = {one: w.rates[one][:, 2] for one in w.names}
    expected = tied_rate({n: r for n, r in spins.items() if n != name}, name, w.geometry)
    return (
        _cosine(first, second) > GO_TOGETHER
        and _cosine(first, -w.yaw[name]) > GO_TOGETHER
        and _cosine(spins[name], expected) > GO_TOGETHER
    )


def of_accelerometer(
    fault: Fault, recording: Recording, geometry: WheelchairGeometry, mount: WheelchairMount
) -> Fault:
    """Wrong signs of a wheel, put on its accelerometer where the others speak for its gyroscope.

    One axis of forces that is turned round goes with two of rates: gravity alone cannot tell which
    half is wrong. The two other sensors know the spin.

    Parameters
    ----------
    fault : Fault, "reversed", with its repair
    recording : Recording
    geometry : WheelchairGeometry
    mount : WheelchairMount

    Returns
    -------
    Fault; the same one if the gyroscope may be wrong
    """
    name = fault.sensor.removesuffix("_gyr")
    wheels = mount.rotation_left_imu_to_wheel, mount.rotation_right_imu_to_wheel
    names = ("frame", "left_wheel", "right_wheel")
    there = all(
        n in recording.sensors and recording.sensors[n].gyr_radps is not None for n in names
    )
    if name not in names[1:] or not there or any(turn is None for turn in wheels):
        return fault
    assert isinstance(fault.repair, partial)
    signs = np.asarray(fault.repair.keywords["factors"], float)
    if signs.prod() < 0:
        return fault
    turns = dict(zip(names, (mount.rotation_frame_imu_to_chair, *wheels), strict=True))
    along = {n: recording.gyroscope(n) @ turn[2] for n, turn in turns.items() if turn is not None}
    expected = tied_rate({n: r for n, r in along.items() if n != name}, name, geometry)
    axle = turns[name]
    assert axle is not None
    flipped = (recording.gyroscope(name) * signs) @ axle[2]
    if _cosine(along[name], expected) < GO_TOGETHER or _cosine(flipped, expected) > APART:
        return fault
    bad = ", ".join(axis for axis, sign in zip("xyz", signs, strict=True) if sign > 0)
    return fault_of(
        recording, "reversed", f"{name}_acc", np.ones(len(recording), np.bool_),
        f"turns the other way than its gyroscope, which the two others speak for: axis {bad} of "
        "the accelerometer has the wrong sign; check the export's axes",
        repair=partial(multiplied, sensor=name, half="acc", factors=-signs),
    )  # fmt: skip


def _cosine(first: FloatArray, second: FloatArray) -> float:
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(first @ second) / size if size > 0 else 0.0


def told_once(faults: Sequence[Fault]) -> list[Fault]:
    """Faults; a wheel's sensor with another axle and wrong signs has its axes mixed up.

    Parameters
    ----------
    faults : Fault, in the order in which their repairs are made

    Returns
    -------
    list of Fault
    """
    told, dropped = list[Fault](), list[Fault]()
    for fault in faults:
        name = fault.sensor
        halves = f"{name}_gyr", f"{name}_acc"
        signs = [f for f in faults if f.code == "reversed" and f.sensor in halves]
        if fault.code == "turned" and signs:
            dropped += signs
            own = tuple(f for f in faults if f is fault or any(f is one for one in signs))
            fault = replace(
                fault,
                sentence=f"{fault.sentence.partition(': ')[0]}: {name} has its axes in another "
                "order or with other signs than in the static and the straight-line trial, by its "
                "spin and by gravity; check the export's axes, or record all trials with one "
                "export",
                repair=partial(all_repaired, own),
            )
        told.append(fault)
    return [fault for fault in told if not any(fault is one for one in dropped)]
