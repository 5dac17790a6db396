"""The tilts in the path of an IMU, and which way each of them went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, one_of, shown
from mobility_imu.runs import runs_of
from mobility_imu.walker.geometry import TILT_DIRECTIONS, TiltDirection
from mobility_imu.walker.navigation import Navigation

__all__ = ["Tilt", "check_order", "find_tilts"]

LEAST_TILT_RAD = float(np.deg2rad(10))
"""A tilt of less says little. The error of a distance grows as one over the angle."""
_NOTICED_RAD = float(np.deg2rad(3))
_UPRIGHT_RAD = float(np.deg2rad(2))
_DIRECTED_RAD = float(np.deg2rad(5))
# Directions around the frame, a quarter turn to the left from one to the next.
_AROUND: tuple[TiltDirection, ...] = ("front", "left", "back", "right")


@dataclass(frozen=True)
class Tilt:
    """A tilt in a recording.

    Parameters
    ----------
    direction : which way it went
    span : slice of the samples from upright to upright
    top : int, sample at the end of the tilting movement, before it goes back
    angle_rad : rad, angle there
    """

    direction: TiltDirection
    span: slice = field(hash=False)  # a slice has no hash before Python 3.12
    top: int
    angle_rad: float

    def __post_init__(self) -> None:
        """Check every field."""
        one_of("Tilt.direction", self.direction, TILT_DIRECTIONS)
        check_fields(self, span=slice, top=int, angle_rad=float)


def find_tilts(
    navigation: Navigation, order: Sequence[TiltDirection] = TILT_DIRECTIONS
) -> tuple[tuple[Tilt, ...], tuple[str, ...]]:
    """Find the tilts in a path, and which way each went.

    The edges form a rectangle, so that the directions follow from one of them; which edge that was,
    no recording can tell. The stated order decides, also if some of its tilts are missing.

    Parameters
    ----------
    navigation : Navigation
    order : directions of the tilts as they were made

    Returns
    -------
    the tilts in time, and warnings: another order, tilts that are too small, too many, missing

    Raises
    ------
    InputError
        If no tilt is found, one goes across a corner, or the order leaves open which they were.
    """
    check_order(order)
    expect("navigation", navigation, Navigation)
    attitude, time_s = navigation.rotation_imu_to_world(), navigation.time_s
    first = int(np.argmax(navigation.still))
    up = attitude[first, 2]
    lean = np.arccos(np.clip(attitude[:, 2] @ up, -1, 1))
    rest = navigation.still & (lean < _UPRIGHT_RAD)
    warnings: list[str] = []
    small: list[str] = []
    # Movements whose direction is clear take part in naming, also those that cannot be used.
    ways: list[FloatArray] = []
    usable: list[tuple[slice, int, float] | None] = []
    starts: list[str] = []
    for span in runs_of(lean > _NOTICED_RAD):
        top = _end_of_movement(lean, navigation.still, span)
        angle, when = float(lean[top]), f"the tilt at {time_s[span.start]:.1f} s"
        before = np.nonzero(rest[: span.start])[0]
        after = np.nonzero(rest[span.stop :])[0]
        whole = None
        if not len(before):
            warnings.append(f"{when} has no still phase before it: left out")
        elif angle < LEAST_TILT_RAD:
            small.append(
                f"{when} reaches only {np.rad2deg(angle):.1f} deg: left out (expected 20 to 45 deg)"
            )
        elif not len(after):
            warnings.append(f"{when} does not come back before the recording ends: left out")
        else:
            whole = slice(int(before[-1]), span.stop + int(after[0]) + 1)
        if angle > _DIRECTED_RAD:
            # Up, as the tilted IMU sees it, lies against the way that the top went.
            way = np.cos(angle) * up - attitude[top, 2]
            ways.append(way / np.linalg.norm(way))
            usable.append(None if whole is None else (whole, top, angle))
            starts.append(when)
    if len(small) > 3:
        small = [small[0], f"{len(small) - 1} more movements stay that small: is this a walk?"]
    warnings += small
    if not any(usable):
        most = np.median(attitude[navigation.still, 2], axis=0)
        off = float(np.arccos(np.clip(most @ up / np.linalg.norm(most), -1, 1)))
        if off > LEAST_TILT_RAD:
            warnings = [
                f"the first rest, at {time_s[first]:.1f} s, is tilted by {np.rad2deg(off):.0f} deg "
                "against most: does the recording begin in a tilt?"
            ]
        reasons = f" ({'; '.join(warnings)})" if warnings else ""
        raise InputError(
            "no tilt found: expected rest on all four tips, then tilts of 20 to 45 deg with rest "
            f"between them{reasons}"
        )
    names, about_order = _name_tilts(ways, usable, starts, up, order)
    tilts = tuple(
        Tilt(name, *found) for name, found in zip(names, usable, strict=True) if found is not None
    )
    return tilts, (*warnings, *about_order)


def check_order(order: Sequence[TiltDirection]) -> None:
    """Check that an order of tilts is a list of their names.

    Parameters
    ----------
    order : directions of the tilts as they were made

    Raises
    ------
    InputError
        If it is none, is empty, or holds another name.
    """
    named = isinstance(order, Sequence) and all(isinstance(name, str) for name in order)
    if not named or isinstance(order, str):
        raise InputError(f"order: got {shown(order)}, expected a list of names")
    unknown = [name for name in order if name not in TILT_DIRECTIONS]
    if unknown or not order:
        raise InputError(
            f"order = {', '.join(order) or '(empty)'}: expected names out of "
            f"{', '.join(TILT_DIRECTIONS)}"
        )


def _name_tilts(
    ways: Sequence[FloatArray],
    usable: Sequence[tuple[slice, int, float] | None],
    starts: Sequence[str],
    up: FloatArray,
    order: Sequence[TiltDirection],
) -> tuple[list[TiltDirection], list[str]]:
    """Name movements by their directions, so that they follow the stated order as far as they can.

    Seen from the first movement the directions are known in quarter turns; which edge the first
    was decides for all. Movements may be missing from the order.
    """
    turns = [float(np.arctan2(np.cross(ways[0], way) @ up, ways[0] @ way)) for way in ways]
    quarters = [round(turn / (np.pi / 2)) for turn in turns]
    for turn, quarter, found, when in zip(turns, quarters, usable, starts, strict=True):
        off = abs(np.rad2deg(turn) - 90 * quarter)
        if found is not None and off > 25:
            raise InputError(
                f"{when} goes {off:.0f} deg off a right angle to the first: expected tilts about "
                "the edges"
            )
    candidates: list[list[TiltDirection]] = []
    for start in range(4):
        names = [_AROUND[(start + quarter) % 4] for quarter in quarters]
        rest = iter(order)
        distinct = [name for k, name in enumerate(names) if k == 0 or name != names[k - 1]]
        if all(name in rest for name in distinct):
            candidates.append(names)
    if len(candidates) > 1:
        options = " or ".join(", ".join(names) for names in candidates)
        raise InputError(
            f"the tilts may have gone {options}: state which ones were made, and in which "
            "order (--order; order in Python)"
        )
    if candidates:
        missing = [name for name in order if name not in candidates[0]]
        return candidates[0], [f"no tilt to the {', '.join(missing)} found"] if missing else []
    start = _AROUND.index(order[0])
    names = [_AROUND[(start + quarter) % 4] for quarter in quarters]
    mirrored = {"right": "left", "left": "right"}
    hint = ""
    if [mirrored.get(name, name) for name in names] == list(order):
        hint = "; or has the accelerometer's sign been reversed?"
    return names, [
        f"the tilts went {', '.join(names)} if the first was to the {order[0]}, and not "
        f"{', '.join(order)}: taken as such. If the first was another one, the mount is turned "
        f"by a quarter or half a turn{hint}"
    ]


def _end_of_movement(lean: FloatArray, still: NDArray[np.bool_], span: slice) -> int:
    """Middle of the still phase at the top, or the largest angle if it was not held still."""
    top = span.start + int(np.argmax(lean[span]))
    held = np.arange(span.start, span.stop)[still[span] & (lean[span] > 0.8 * lean[top])]
    return int(held[len(held) // 2]) if len(held) else top
