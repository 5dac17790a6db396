"""Faults that begin or end within a drive, by what each piece of it says.

Each sensor knows the chair's yaw rate by itself, without slip and radii. Where one differs from the
two others in some pieces by far more than in the rest of the drive, something happened to it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobility_imu.faults import Fault
from mobility_imu.frames import FloatArray
from mobility_imu.health import fault_of
from mobility_imu.runs import runs_of
from mobility_imu.wheelchair.contradictions import SharedMotion, gain_of
from mobility_imu.wheelchair.fits import pieces_of
from mobility_imu.wheelchair.recovery import replaced
from mobility_imu.wheelchair.wheel_faults import drift_between

__all__ = ["MUCH", "at_odds_in_part", "still_at_odds_in_part"]

MUCH = 0.1
"""Part of a drive that is at odds, from which on no other look is made: what replaces it would
speak there."""
PIECE_S = 2.0
"""A stroke lasts about a second, a turn some."""
SMOOTH_S = 0.2
"""Vibration of a wheel is averaged over this."""
USUAL_PART = 0.4
"""So much of a drive, the best of it, shows how well its sensors agree."""
TIMES = 5.0
"""Times what is usual, from which on a piece is at odds. Set by hand, like the limits that follow
without a reason, on simulated courts that the study of faults does not use."""
LEAST_RADPS = float(np.deg2rad(7.0))
"""A real wheel on grass differs by 5 deg/s for two seconds, on other grounds by 2 at most."""
LEAST_NOISE_RADPS = float(np.deg2rad(15.0))
"""The same without the average, which hides noise."""
LEAST_OF_YAW = 0.12
"""Part of a piece's yaw rate: more than scale factors, leaning and camber explain."""
FEWEST_PIECES = 6
"""Pieces without another fault, from which on what is usual is known. Set by hand, as above."""
LEAST_APART = 2.0
"""A sensor is at fault whose differences from the two others are so many times theirs."""
ALIKE = 0.95
"""Correlation from which on one lag and one factor may explain the whole of a drive."""
EXPLAINED = 0.5
"""They do where they leave less than this part of the differences."""
SURELY_EXPLAINED = 0.3
"""The same of a lag that grows steadily, which fits a late part of a drive by half, too."""
NEAR_ODDS = 0.4
"""Part of the limit that counts beside a piece at odds."""
TELLING_RADPS = float(np.deg2rad(8.0))
"""Change of yaw rate in a piece in which a lag and a factor both would show."""


def at_odds_in_part(w: SharedMotion) -> Iterator[Fault]:
    """A sensor whose yaw rate leaves the two others' in some pieces of a drive.

    No fault is told where one lag, steady or drifting, and one factor of the whole drive explain
    most of it: they are looked for first, and :func:`still_at_odds_in_part` looks again.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    for first, second in combinations(w.yaw, 2):
        raw = w.yaw[second] - w.yaw[first]
        left = _aligned(w, first, second) - w.yaw[first]
        if np.abs(left).mean() < EXPLAINED * np.abs(raw).mean():
            return
        drift = drift_between(w, second, first)
        if drift is not None:
            at = np.arange(len(raw))
            late = np.interp(at + np.linspace(*drift, len(at)) * w.rate_hz, at, w.yaw[second])
            left = late - w.yaw[first]
            if np.abs(left).mean() < SURELY_EXPLAINED * np.abs(raw).mean():
                return
    yield from still_at_odds_in_part(w)


def still_at_odds_in_part(w: SharedMotion) -> Iterator[Fault]:
    """The same, whatever would explain the whole of the drive.

    Parameters
    ----------
    w : SharedMotion

    Yields
    ------
    Fault
    """
    if len(w.yaw) < 3:
        return
    piece = pieces_of(len(w.recording), PIECE_S, w.rate_hz)
    count = int(piece[-1]) + 1
    clear = np.bincount(piece, w.spoiled, count) == 0
    if clear.sum() < FEWEST_PIECES:
        return
    rates = {name: _with_sign_of(w, "frame", name) for name in w.yaw}
    turn = np.min([_by_piece(yaw, piece, count) for yaw in rates.values()], axis=0)
    found = {name: (np.zeros(count, np.bool_), np.zeros(count, np.bool_), 0.0) for name in rates}
    for smooth_s, floor in ((SMOOTH_S, LEAST_RADPS), (0.0, LEAST_NOISE_RADPS)):
        width = max(1, round(smooth_s * w.rate_hz))
        apart = {
            (first, second): _by_piece(
                ndimage.uniform_filter1d(rates[second] - rates[first], width), piece, count
            )
            for first, second in combinations(rates, 2)
        }
        # Of two that agree, the third stands off in both of its pairs.
        for name, (odds, near, size) in found.items():
            mine = np.min([one for pair, one in apart.items() if name in pair], axis=0)
            theirs = next(one for pair, one in apart.items() if name not in pair)
            usual = float(np.quantile(mine[clear], USUAL_PART))
            least = np.maximum(max(TIMES * usual, floor), LEAST_OF_YAW * turn)
            off = clear & (mine > least) & (mine > LEAST_APART * theirs)
            by = clear & (mine > NEAR_ODDS * least) & (mine > theirs)
            largest = float(mine[off].max(initial=0.0))
            found[name] = odds | off, near | by, max(size, largest)
    for name, (odds, near, size) in found.items():
        if odds.any():
            changes = np.array([np.std(rates[name][piece == k]) for k in range(count)])
            agrees = clear & ~near & (changes > TELLING_RADPS) & (turn > TELLING_RADPS)
            flags = _that_last(odds, near, agrees)[piece]
            yield _told(w, name, flags, float(np.rad2deg(size)))


def _told(w: SharedMotion, name: str, flags: NDArray[np.bool_], size: float) -> Fault:
    until = float(w.recording.time_s[int(np.flatnonzero(flags)[-1])])
    return fault_of(
        w.recording, "at odds", name, flags,
        f"knows another yaw rate than the two others (by up to {size:.0f} deg/s over 2 s, until "
        f"{until:.0f} s), with which it agrees in the rest of the drive; leave these times out, or "
        "record again", size=size, unit="deg/s",
        repair=partial(
            replaced, sensor=name, flags=flags,
            others={n: f for n, f in w.failed.items() if n != name},
            geometry=w.geometry, mount=w.mount, otherwise=None,
        ),
    )  # fmt: skip


def _aligned(w: SharedMotion, first: str, second: str) -> FloatArray:
    """Second of two yaw rates without a lag, a factor and a constant of the whole drive."""
    yaw, lag = w.yaw[second], w.lag(first, second)
    if lag is not None and lag.correlation > ALIKE:
        at = np.arange(len(yaw))
        yaw = np.interp(at + lag.lag_s * w.rate_hz, at, yaw)
    gain = gain_of(w.yaw[first], yaw, w.rate_hz)
    if gain is not None and gain.correlation > ALIKE and abs(gain.gain) > EXPLAINED:
        yaw = (yaw - gain.constant_radps) / gain.gain
    return yaw


def _with_sign_of(w: SharedMotion, first: str, second: str) -> FloatArray:
    """Second yaw rate, turned round where it surely goes against the first: a mirrored sensor."""
    found = (w.lag(first, second, sign=sign) for sign in (1, -1))
    with_it, against = (0.0 if lag is None else lag.correlation for lag in found)
    return -w.yaw[second] if against > with_it else w.yaw[second]


def _by_piece(values: FloatArray, piece: NDArray[np.int64], count: int) -> FloatArray:
    """Root mean square of each piece."""
    return np.asarray(np.sqrt(np.bincount(piece, values**2, count) / np.bincount(piece)))


def _that_last(
    odds: NDArray[np.bool_], near: NDArray[np.bool_], agrees: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Pieces at odds, and those around them up to one that surely shows that all is well."""
    whole = odds.copy()
    for run in runs_of(odds | near):
        whole[run] |= odds[run].any()
    for run in runs_of(~whole):
        well = run.start + np.flatnonzero(agrees[run])
        if len(well):
            first = well[0] if run.start else 0
            last = well[-1] + 1 if run.stop < len(whole) else len(whole)
            whole[run.start : first] = True
            whole[last : run.stop] = True
        else:
            whole[run] = run.start > 0 or run.stop < len(whole)
    return whole
