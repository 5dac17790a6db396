"""Lever and body of a scooter that have each other's names, whole or one half of each.

Read under the right names, the sensors agree; under wrong ones no angles of the controls explain
both.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple, TypeGuard

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.faults import Repair, exchanged, half_of, with_half
from mobility_imu.recording import Recording
from mobility_imu.scooter.agreement import Agreement
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.scooter.sensor_pair import SensorPair

__all__ = [
    "AT_ODDS",
    "CLEARLY_BETTER",
    "MUCH_BETTER",
    "Suspect",
    "exchanged_halves",
    "exchanges",
]

CLEARLY_BETTER, MUCH_BETTER = 0.5, 0.55
"""A fault, undone, has to make the sum of squared misfits smaller by the first number (3 is usual)
and to less than the second part of it. Swept on simulated rides, seeds 36,000 to 41,000."""
AT_ODDS = 12.0
"""Sum of squared misfits of sensors that contradict each other: twice what is usual of each."""
INCLINATIONS_DEG = np.arange(5.0, 46.0, 5.0)
"""Inclinations of the steering that are tried in place of the stated one."""
SMALLEST_SLIP_RAD, LARGEST_SLIP_RAD = np.deg2rad([4.0, 20.5]).tolist()
"""Errors of a stated inclination that are tried: less bends the angles and looks like a mount."""
WORDS = {"gyr": "gyroscope", "acc": "accelerometer"}


class Suspect(NamedTuple):
    """A fault that may explain what is at odds, and how well the sensors agree without it."""

    code: str
    sensor: str
    what: str
    size: float
    unit: str
    repair: Repair | None
    after: Agreement


def exchanges(pair: SensorPair) -> Iterator[Suspect]:
    """Both sensors under each other's names, and both gyroscopes or both accelerometers.

    Right names leave nothing at odds (``AT_ODDS``), wrong ones much. In simulated rides over six
    courses, seeds 700,100 to 700,103, the sum of squared misfits is 74 to 264 with exchanged
    gyroscopes, 96 and more with exchanged accelerometers; 0.2 to 2.0 once that is undone, and more
    than twice as much with anything else undone (a sensor turned by half a turn, a reversed axis).
    A sound ride with its gyroscopes exchanged has 74 or more.

    Parameters
    ----------
    pair : SensorPair

    Yields
    ------
    Suspect that agrees better than the pair does
    """
    repair = partial(exchanged, first="lever", second="body")
    after = pair.repaired(repair)
    if _is_better(after, pair):
        yield from _other_inclination(pair, after)
        yield Suspect(
            "exchanged", "lever, body",
            "have each other's names: what is called the body turns on the lever's hinges; "
            "exchange them, or the inclinations in the geometry file are wrong",
            float("nan"), "", repair, after,
        )  # fmt: skip
    for half, other in (("gyr", "acc"), ("acc", "gyr")):
        repair = partial(exchanged_halves, half=half)
        after = pair.repaired(repair)
        if _is_better(after, pair):
            yield Suspect(
                "exchanged", f"lever_{half}, body_{half}",
                f"have each other's readings: each {WORDS[half]} fits the other sensor's "
                f"{WORDS[other]}; exchange the {half} columns of both sensors, or look at how they "
                "were put together", float("nan"), "", repair, after,
            )  # fmt: skip


def _is_better(after: Agreement | None, pair: SensorPair) -> TypeGuard[Agreement]:
    """Whether names leave nothing at odds, and less than the given ones."""
    if after is None or after.squared > AT_ODDS:
        return False
    return pair.stated is None or after.squared < pair.stated.squared


def exchanged_halves(recording: Recording, half: str) -> Recording:
    """Recording in which lever and body have each other's readings of one half.

    Parameters
    ----------
    recording : Recording
    half : "acc" or "gyr"

    Returns
    -------
    Recording
    """
    lever, body = (half_of(recording, name, half) for name in ("lever", "body"))
    return with_half(with_half(recording, "lever", half, body), "body", half, lever)


def _other_inclination(pair: SensorPair, exchanged_: Agreement) -> Iterator[Suspect]:
    """Inclination of the steering with which sensors agree as they are named, clearly better.

    With names exchanged, the sensors agree at another alpha than the right one as well: what looks
    like an exchange may be a wrong alpha.
    """
    stated = pair.geometry.steering_inclination_rad
    found: list[tuple[float, float, Agreement]] = []
    for alpha in np.deg2rad(INCLINATIONS_DEG).tolist():
        if not SMALLEST_SLIP_RAD < abs(alpha - stated) <= LARGEST_SLIP_RAD:
            continue
        geometry = ScooterGeometry(alpha, pair.geometry.lever_inclination_rad)
        try:
            after = SensorPair(pair.recording, geometry, pair.mount).stated
        except InputError:
            continue
        if after is not None:
            found.append((after.squared, alpha, after))
    if not found:
        return
    squared, alpha, after = min(found, key=lambda one: one[0])
    better = exchanged_.squared - squared > CLEARLY_BETTER
    if better and squared < MUCH_BETTER * exchanged_.squared:
        yield Suspect(
            "geometry", "lever, body",
            f"fit a steering inclined by about {np.rad2deg(alpha):.0f} deg, not by "
            f"{np.rad2deg(stated):.0f}: look at the inclinations in the geometry file; or the "
            "sensors have each other's names",
            float(np.rad2deg(alpha)), "deg", None, after,
        )  # fmt: skip
