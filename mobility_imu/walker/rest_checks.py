"""What the two halves of an IMU say of each other from rest to rest.

A frame that stands shows gravity to its accelerometer and its offset to its gyroscope. Between two
rests three things are known without any other sensor: gravity's direction turns as the gyroscope
says, the velocity comes back to zero, and the height to the floor. What is left over is a misfit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu.frames import FloatArray
from mobility_imu.rotations import cross_matrix
from mobility_imu.runs import long_runs, runs_of
from mobility_imu.walker.turned_sums import (
    Moved,
    Sums,
    TurnedSums,
    quickest_sums,
    sums_in_arrays,
)

__all__ = [
    "HalvesFit",
    "Moves",
    "Readings",
    "drift_at_rest",
    "fit_halves",
    "moves_between_rests",
    "rest_rates",
    "shortest_turns",
]

GRAVITY_S = 0.5
"""Longest part of a rest, next to a move, that gravity is averaged over. Our choice, not swept:
about as long as the shortest rests between two steps."""
LONGEST_MOVE_S = 5.0
"""Longer moves are left out. In 5 s an offset of the gyroscope of 0.1 deg/s turns gravity so far
that a velocity of 0.2 m/s is left over, ten times its usual misfit."""
SIZES = np.array([0.02, 0.02, 0.02, 0.2, 0.2, 0.005])
"""Usual misfits of a frame that is lifted and set down (m/s, deg, m): simulated, "realistic"."""
BACK_RAD = float(np.deg2rad(2.0))
"""Gravity's directions before and after a move are nearer if the frame stands on its tips again."""
LARGEST_LAG_S, LAG_STEP_S = 1.0, 0.1
"""Lags that are looked for, the length of a step, and their grid: a tenth of a move, from which the
fit finds the way. Our choice, not swept."""
FITS = 0.3
"""Where the best lag brings the misfits below this part of those without a gyroscope, the grid is
not searched with the scale first as well. It saves time; our choice, not swept."""
SCALES = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Starting points of the fit: from half to twice, the error of a range that is one setting off
(250, 500, 1000 deg/s in data sheets), a factor of 1.4 apart."""
FAR_SCALES = (0.0175, 0.03, 0.06, 0.12, 0.25, 4.0, 8.0, 16.0, 32.0, 57.3)
"""The same for another unit: deg/s and rad/s are 57.3 apart. They are tried where none of the
others explains the misfits."""
FEWEST_MOVES = 4
"""Moves from which on the halves are held against each other: their 24 misfits are three times the
fit's 8 unknowns."""
CLEARLY = 0.5
"""A gyroscope explains the misfits if it makes them smaller by this factor: rates that say nothing,
as of a frame that is rolled and never tilts, leave them as they are. Our choice, not swept."""
HUBER = 1.5
"""Moves count less beyond so many medians of all lengths. Huber's constant is 1.345 standard
deviations for one number; of six normal ones 6 % are longer than this."""
LEVEL_M = 0.4
"""Sum of the moves' heights from which on they say nothing of the halves: the floor may not be
level. On a ramp of 3 deg and more they passed for lags of up to 0.1 s and scales of 16 %. The
heights of 80 simulated walks on a level floor add up to 0.21 m."""
LEVEL_BY_OFFSET_M = 0.1
"""The same sum beside a fitted offset of the accelerometer, up to which the floor may be level: of
50 simulated walks, level "real", on a level floor it is at most 0.06 m."""
NO_TURN = np.zeros(3)
UP = np.array([0.0, 0.0, 1.0])
NO_ERROR = np.array([0.0, 1.0, *[0.0] * 6])
OFFSETS = [2, 3, 4]
"""Numbers of the accelerometer's offsets among the errors of the fit."""
USUAL_ERRORS = np.array([LARGEST_LAG_S, 1.0, *[0.2] * 3, *[0.01] * 3])
"""Sizes of lag, scale, the accelerometer's offset (20 mg) and the gyroscope's axes against the
accelerometer's (1 %, data sheets of cheap sensors). The last two are fitted so that they do not
pass for the first two; a frame that turns makes them all look alike."""
LEAST = NO_ERROR - np.array([LARGEST_LAG_S, 0.99, *[1.0] * 3, *[0.1] * 3])
MOST = NO_ERROR + np.array([LARGEST_LAG_S, 99.0, *[1.0] * 3, *[0.1] * 3])
"""Bounds of the same errors, beyond all that is looked for: scales of 1/100 to 100, offsets of 100
mg, axes askew by 6 deg."""
NO_MORE = 1.5
"""Median rate in the moves, in times of that at rest, up to which a gyroscope says nothing. Our
choice, not swept."""
MUCH = 8.0
"""Mean misfit, in usual ones, that a gyroscope has to explain. Of 10 simulated walks it is 13.5 to
17.6 without a gyroscope, and 1.7 to 4.8 with a sound one."""
FEWEST_STEPS = 12
"""Moves that end as they began, from which on the scale is that of the speeds alone: their 24
speeds are three times the fit's 8 unknowns. A frame that rocks where it stands leans otherwise than
on the mean: by the leans the rates of 8 sound walks of six minutes, level "realistic", seeds from
900,600 on, were 6 % too large on average, by the speeds 0.2 %."""
ROUNDS = 3
"""Steps of Gauss and Newton after the grid; the third moves by less than an error."""


class Readings(NamedTuple):
    """What the checks need of a recording and its rests.

    Parameters
    ----------
    time_s : (n,) array, s
    acc_mps2, gyr_radps : (n, 3) arrays, IMU's axes
    still : (n,) bool array
    lost : (n,) bool array, samples in which a half or an axis says nothing, or None for none; moves
        with such samples are left out, and what they are of a rest is
    """

    time_s: FloatArray
    acc_mps2: FloatArray
    gyr_radps: FloatArray
    still: NDArray[np.bool_]
    lost: NDArray[np.bool_] | None = None

    @property
    def still_and_known(self) -> NDArray[np.bool_]:
        """Samples at rest that are not lost, (n,) bool array."""
        return self.still if self.lost is None else self.still & ~self.lost

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return 1 / float(np.median(np.diff(self.time_s)))

    def offset(self) -> FloatArray:
        """Median of the rests' mean rates, (3,) array, rad/s."""
        means = [self.gyr_radps[rest].mean(axis=0) for rest in runs_of(self.still_and_known)]
        return np.asarray(np.median(means, axis=0)) if means else np.zeros(3)


class Moves(NamedTuple):
    """Misfits of the moves from rest to rest, one row each; moves of over 5 s are left out.

    Parameters
    ----------
    spans : slices, from the last sample of the rest before to the first of the rest after
    misfit : (m, 6) array: velocity at the end along x, y, z in level axes (m/s); gravity's
        direction against the gyroscope's, x and y (deg); height at the end (m)
    """

    spans: list[slice]
    misfit: FloatArray

    @property
    def speed_mps(self) -> FloatArray:
        """Velocity that is left at the end, (m,) array, m/s."""
        return np.asarray(np.linalg.norm(self.misfit[:, :3], axis=1))

    @property
    def tilt_deg(self) -> FloatArray:
        """Angle between gravity and what the gyroscope expects of it, (m,) array, deg."""
        return np.asarray(np.hypot(self.misfit[:, 3], self.misfit[:, 4]))


class _Stood(NamedTuple):
    """Gravity at both ends of each move, with an offset of the accelerometer.

    Parameters
    ----------
    upright : (m, 3, 3) array, from the axes of the first sample to level ones
    last : (m, 3) array of unit vectors, gravity at the end
    down, aside : (m, 2) and (m, 1) arrays, weighed sums over gravity's size, m/s and m, and over
        its lean, m/s for each rad
    """

    upright: FloatArray
    last: FloatArray
    down: FloatArray
    aside: FloatArray


class _Batch:
    """Moves of a recording side by side, each padded with its last sample to the longest one."""

    def __init__(self, readings: Readings) -> None:
        rests, rate_hz = runs_of(readings.still), readings.rate_hz
        pairs = [
            (before, after)
            for before, after in pairwise(rests)
            if (after.start + 1 - before.stop) / rate_hz < LONGEST_MOVE_S
        ]
        window = max(1, int(GRAVITY_S * rate_hz))
        if readings.lost is not None:
            pairs = [
                (before, after)
                for before, after in pairs
                if not readings.lost[
                    max(before.start, before.stop - window) : min(after.stop, after.start + window)
                ].any()
            ]
        self.spans = [slice(before.stop - 1, after.start + 1) for before, after in pairs]
        acc = readings.acc_mps2
        self.first = np.array(
            [acc[max(r.start, r.stop - window) : r.stop].mean(axis=0) for r, _ in pairs]
        ).reshape(-1, 3)
        self.last = np.array(
            [acc[r.start : min(r.stop, r.start + window)].mean(axis=0) for _, r in pairs]
        ).reshape(-1, 3)
        ends = [np.linalg.norm(each, axis=1) for each in (self.first, self.last)]
        # Set down as it was lifted; a frame that is held tilted has its IMU at another height.
        self.back = (self.first * self.last).sum(axis=1) > np.cos(BACK_RAD) * ends[0] * ends[1]
        longest = max((span.stop - span.start for span in self.spans), default=1)
        begins = np.array([span.start for span in self.spans], int)
        counts = np.array([span.stop - span.start for span in self.spans], int)
        index = begins[:, None] + np.minimum(np.arange(longest), counts[:, None] - 1)
        clock = readings.time_s[index]
        step = np.diff(clock, axis=1)
        seconds = clock[:, -1:] - clock[:, :1]
        part = (clock - clock[:, :1]) / np.maximum(seconds, 1e-9)
        # Velocity and height are sums over the force by the trapezoidal rule. The height's weighs a
        # force by the time that its velocity lasts, less half the move's: what is left of the
        # velocity at the end is spread evenly.
        lasts = seconds * (1 - part[:, 1:] - part[:, :-1]) / 2
        between = np.stack([step, step * lasts], axis=1) / 2
        weights = np.zeros((len(pairs), 2, longest))
        weights[:, :, 1:] += between
        weights[:, :, :-1] += between
        powers = np.stack([np.ones_like(part), part, part**2], axis=-1)
        self.moments = weights @ powers
        self.rate_hz = rate_hz
        rates = np.pad(readings.gyr_radps - readings.offset(), ((1, 1), (0, 0)), mode="edge")
        self.moved = Moved(begins, counts, (rates[1:] + rates[:-1]) / 2, step, acc[index], weights)
        self.sums: Sums = sums_in_arrays
        self.known: dict[bytes, _Stood] = {}

    def misfit(self, turned: TurnedSums, offset_mps2: ArrayLike = 0.0) -> FloatArray:
        """Misfits (m, 6) with the sums of :meth:`turned`, and an offset added to the force.

        The tilt's misfit is spread evenly over its move before the velocity is summed up, the
        velocity's before the height is: each misfit counts once.
        """
        offset = np.broadcast_to(np.asarray(offset_mps2, float), 3)
        stood = self._stood(offset)
        sums = turned.forces + (turned.turns * offset).sum(axis=-1)
        sums = sums @ np.swapaxes(stood.upright, 1, 2)
        lean = (stood.upright @ (turned.ends @ stood.last[:, :, None]))[:, :2, 0]
        result = np.empty((len(lean), 6))
        result[:, :2] = sums[:, 0, :2] - stood.aside * lean
        result[:, 2] = sums[:, 0, 2] - stood.down[:, 0]
        result[:, 3:5] = np.rad2deg(lean)
        result[:, 5] = (sums[:, 1, 2] - stood.down[:, 1]) * self.back
        return result

    def _stood(self, offset_mps2: FloatArray) -> _Stood:
        """What the rests alone say, which most misfits of a fit have in common."""
        key = offset_mps2.tobytes()
        if key not in self.known:
            first, last = self.first + offset_mps2, self.last + offset_mps2
            sizes = np.linalg.norm(first, axis=1), np.linalg.norm(last, axis=1)
            upright = shortest_turns(first / sizes[0][:, None], UP)
            # Gravity's size changes evenly from first to last; its lean grows evenly from none.
            gravity = np.column_stack([sizes[0], sizes[1] - sizes[0]])[:, None]
            self.known[key] = _Stood(
                upright,
                last / sizes[1][:, None],
                (gravity * self.moments[:, :, :2]).sum(axis=2),
                (gravity * self.moments[:, :, 1:]).sum(axis=2)[:, :1],
            )
        return self.known[key]

    def turned(
        self, factors: ArrayLike = 1.0, lag_s: float = 0.0, askew_rad: ArrayLike = NO_TURN
    ) -> TurnedSums:
        """Sums in the axes of each move's first sample, with errors of the gyroscope taken back.

        The rates are multiplied and come late by some time, and the gyroscope's axes are turned
        against the accelerometer's.
        """
        mixing = (np.eye(3) + cross_matrix(np.asarray(askew_rad, float))) * np.asarray(
            factors, float
        )
        return self.sums(self.moved, round(lag_s * self.rate_hz), mixing)


def moves_between_rests(readings: Readings) -> Moves:
    """Misfits of each move.

    Parameters
    ----------
    readings : Readings

    Returns
    -------
    Moves
    """
    batch = _Batch(readings)
    return Moves(batch.spans, batch.misfit(batch.turned()) if batch.spans else np.zeros((0, 6)))


def shortest_turns(first: FloatArray, second: FloatArray) -> FloatArray:
    """Shortest turns that bring unit vectors to others.

    Parameters
    ----------
    first, second : (..., 3) arrays of unit vectors; no pair points in opposite directions

    Returns
    -------
    (..., 3, 3) array
    """
    axis, cosine = np.cross(first, second), np.sum(first * second, axis=-1)[..., None, None]
    # The matrix of the cross product with the axis.
    across = np.zeros((*axis.shape, 3))
    across[..., [2, 0, 1], [1, 2, 0]], across[..., [1, 2, 0], [2, 0, 1]] = axis, -axis
    along = axis[..., :, None] * axis[..., None, :]
    return np.asarray(cosine * np.eye(3) + across + along / np.maximum(1 + cosine, 1e-9))


class HalvesFit(NamedTuple):
    """What would bring gyroscope and accelerometer together.

    Parameters
    ----------
    seen : whether the moves tilt the frame enough that the gyroscope explains the misfits; if not,
        nothing else here means anything
    signs : (3,) array, best signs of the gyroscope's axes
    lag_s, lag_sd_s : s, by which the gyroscope comes late
    scale, scale_sd : 1, what the rates have to be multiplied by
    silent : gravity turns in the moves, and the gyroscope reads no more there than at rest
    left : mean misfit that the best fit leaves, in usual ones
    """

    seen: bool
    signs: FloatArray
    lag_s: float = 0.0
    lag_sd_s: float = np.inf
    scale: float = 1.0
    scale_sd: float = np.inf
    silent: bool = False
    left: float = np.inf


UNSEEN = HalvesFit(False, np.ones(3))


def fit_halves(readings: Readings) -> HalvesFit:
    """Signs, lag and scale of the gyroscope that the rests ask for.

    A move is judged by the size of its misfit, each part over ``SIZES``. The signs are tried
    first; then scales and lags on a grid; then both, with an offset of the accelerometer and turned
    axes beside them, by Gauss and Newton with the weights of Huber.

    Parameters
    ----------
    readings : Readings

    Returns
    -------
    HalvesFit
    """
    batch = _Batch(readings)
    if len(batch.spans) < FEWEST_MOVES:
        return UNSEEN

    batch.sums = quickest_sums(batch.moved)
    stated_misfit = batch.misfit(batch.turned())
    rises = _largest_sum(stated_misfit[:, 5]) > LEVEL_M
    usual = SIZES[:5] if rises else SIZES

    def weighed(misfit: FloatArray) -> FloatArray:
        return np.asarray(misfit[:, : len(usual)] / usual)

    def rows(factors: ArrayLike, lag_s: float = 0.0) -> FloatArray:
        return weighed(batch.misfit(batch.turned(factors, lag_s)))

    without, stated = _size(rows(0.0)), _size(weighed(stated_misfit))
    choices = [np.array(signs) for signs in product((1.0, -1.0), repeat=3)][1:]
    sizes = [_size(rows(signs)) for signs in choices]
    least, lag, scale = min(_descents(rows, without))
    best = int(np.argmin(sizes))
    if sizes[best] < min(CLEARLY * without, CLEARLY * stated, least):
        return HalvesFit(True, choices[best], left=sizes[best])
    starts = np.array([lag, scale, *[0.0] * 6]), NO_ERROR.copy()
    fits = [_best_fitted(batch, starts, weighed)]
    if rises:
        # The floor, or the accelerometer's offset: a lag is one only if it is by both.
        level, sd = _best_fitted(batch, starts, lambda misfit: misfit / SIZES)
        heights = batch.misfit(_turned(batch, level), level[OFFSETS])[:, 5]
        if _largest_sum(heights) < LEVEL_BY_OFFSET_M:
            fits.append((level, sd))
    found, sd = min(fits, key=lambda fit: float(abs(fit[0][0]) / fit[1][0]))
    left = _size(weighed(batch.misfit(_turned(batch, found), found[OFFSETS])))
    if left > CLEARLY * without:
        return UNSEEN._replace(silent=without > MUCH and _says_nothing(readings), left=left)
    lag, scale = found[:2].tolist()
    if batch.back.sum() >= FEWEST_STEPS:
        found, by_speed = _fitted(batch, found, lambda misfit: misfit[:, :2] / SIZES[:2])
        scale, sd[1] = float(found[1]), by_speed[1]
    return HalvesFit(True, np.ones(3), lag, float(sd[0]), scale, float(sd[1]), left=left)


def _largest_sum(heights_m: FloatArray) -> float:
    """Height of the highest or lowest place above the start, m."""
    return float(np.abs(np.cumsum(heights_m)).max())


def _turned(batch: _Batch, errors: FloatArray) -> TurnedSums:
    return batch.turned(errors[1], float(errors[0]), errors[5:8])


def _best_fitted(
    batch: _Batch,
    starts: tuple[FloatArray, FloatArray],
    weighed: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Better fit of two starts; its standard deviations say how sure both are of an error.

    The grid knows no offset of the accelerometer, which may look late there: its start may lead to
    a minimum beside that of no error, and as low. What speaks for an error is at most how much
    worse the other fit is, and how far, in its own standard deviations, that is from no error.
    """
    fits = [_fitted(batch, start, weighed) for start in starts]
    rows = [weighed(batch.misfit(_turned(batch, fit), fit[OFFSETS])) for fit, _ in fits]
    weight = _weights(min(rows, key=_size))
    scatter = min(_scatter(each, weight) for each in rows)
    costs = [
        (weight[:, None] * each**2).sum() / scatter
        + (((fit - NO_ERROR) / _usual_errors(fit)) ** 2).sum()
        for (fit, _), each in zip(fits, rows, strict=True)
    ]
    best = int(np.argmin(costs))
    (found, sd), (other, other_sd) = fits[best], fits[1 - best]
    speaks = costs[1 - best] - costs[best] + ((other - NO_ERROR) / other_sd) ** 2
    return found, np.maximum(sd, np.abs(found - NO_ERROR) / np.sqrt(np.maximum(speaks, 1.0)))


def _fitted(
    batch: _Batch, start: FloatArray, weighed: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Errors of the halves that leave the smallest misfits, and their standard deviations."""

    def at(errors: FloatArray, attitudes: TurnedSums) -> FloatArray:
        return weighed(batch.misfit(attitudes, errors[OFFSETS]))

    found, sd = start.copy(), np.full(8, np.inf)
    for _ in range(ROUNDS):
        # A lag is taken in whole samples: its slope comes from some of them.
        steps = np.array([2 / batch.rate_hz, 0.02 * max(1.0, found[1]), *[0.05] * 3, *[0.005] * 3])
        steps[1] = min(steps[1], found[1] / 4)
        found[0] = round(found[0] * batch.rate_hz) / batch.rate_hz
        here, slopes = _turned(batch, found), []
        for k, step in enumerate(steps):
            more, less = found.copy(), found.copy()
            more[k] += step
            less[k] -= step
            # An offset of the accelerometer turns nothing.
            of_more, of_less = (
                (here, here) if k in OFFSETS else (_turned(batch, more), _turned(batch, less))
            )
            slopes.append((at(more, of_more) - at(less, of_less)) / (2 * step))
        change, sd = _step(at(found, here), np.array(slopes), found)
        found = np.clip(found + change, LEAST, MOST)
    return found, sd


def _says_nothing(readings: Readings) -> bool:
    """Whether a gyroscope reads in the moves no more than at rest."""
    size = np.linalg.norm(readings.gyr_radps - readings.offset(), axis=1)
    lost = np.zeros(len(size), np.bool_) if readings.lost is None else readings.lost
    moves, rests = size[~readings.still & ~lost], size[readings.still_and_known]
    return bool(len(moves) and len(rests) and np.median(moves) < NO_MORE * np.median(rests))


def _descents(
    rows: Callable[..., FloatArray], without: float
) -> Iterator[tuple[float, float, float]]:
    """Misfit, lag and scale on a grid: the best lag first, the best scale first, far scales."""
    lags = np.arange(-LARGEST_LAG_S, LARGEST_LAG_S + 1e-9, LAG_STEP_S).tolist()
    for first in ("lag", "scale"):
        lag, scale = 0.0, 1.0
        for what in (first, "lag" if first == "scale" else "scale"):
            if what == "lag":
                by_lag = [_size(rows(scale, each)) for each in lags]
                lag, least = lags[int(np.argmin(by_lag))], min(by_lag)
            else:
                by_scale = [_size(rows(each, lag)) for each in SCALES]
                scale, least = SCALES[int(np.argmin(by_scale))], min(by_scale)
        yield least, lag, scale
        if least < FITS * without:
            return
    by_scale = [_size(rows(each)) for each in FAR_SCALES]
    yield min(by_scale), 0.0, FAR_SCALES[int(np.argmin(by_scale))]


def _size(rows: FloatArray) -> float:
    """Mean length: no single move decides, and no few are overlooked."""
    return float(np.linalg.norm(rows, axis=1).mean())


def _step(
    here: FloatArray, slopes: FloatArray, errors: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Change of the errors, and their standard deviations, by the scatter of the moves or more."""
    weight, known = _weights(here), np.diag(1 / _usual_errors(errors) ** 2)
    normal = np.einsum("m,pmk,qmk->pq", weight, slopes, slopes) + known
    pull = np.einsum("m,pmk,mk->pm", weight, slopes, here)
    change = -np.linalg.solve(normal, pull.sum(axis=1) + known @ (errors - NO_ERROR))
    rest = here + np.einsum("p,pmk->mk", change, slopes)
    inverse = np.linalg.inv(normal)
    pull = np.einsum("m,pmk,mk->pm", weight, slopes, rest)
    # What the moves hardly show is as unsure as it is known beforehand.
    by_moves = inverse @ (pull @ pull.T / _free(here) + known) @ inverse
    by_size = inverse * _scatter(rest, weight)
    return change, np.sqrt(np.maximum(np.diag(by_moves), np.diag(by_size)))


def _weights(rows: FloatArray) -> FloatArray:
    """Huber's weights of the moves."""
    length = np.linalg.norm(rows, axis=1)
    return np.asarray(np.minimum(1.0, HUBER * np.median(length) / np.maximum(length, 1e-9)))


def _usual_errors(errors: FloatArray) -> FloatArray:
    """Of the scale it is against the scale, so that another unit is found as well."""
    return np.asarray(USUAL_ERRORS * [1.0, max(1.0, errors[1]), *[1.0] * 6])


def _free(rows: FloatArray) -> float:
    """Part of the misfits that is free; few moves leave little scatter beside the unknowns."""
    return max(1.0, rows.size - len(NO_ERROR)) / rows.size


def _scatter(rows: FloatArray, weight: FloatArray) -> float:
    """Mean square of weighed misfits."""
    return max(float((weight[:, None] * rows**2).mean()) / _free(rows), 1e-9)


def rest_rates(readings: Readings, shortest_s: float) -> tuple[list[slice], FloatArray]:
    """Rests of some length, and the mean rate of each less the median one, (r, 3) array, rad/s.

    Parameters
    ----------
    readings : Readings
    shortest_s : s

    Returns
    -------
    list of slices, (r, 3) array
    """
    count = max(1, round(shortest_s * readings.rate_hz))
    rests = runs_of(long_runs(readings.still_and_known, count, grow=False))
    if not rests:
        return [], np.zeros((0, 3))
    means = np.array([readings.gyr_radps[rest].mean(axis=0) for rest in rests])
    return rests, means - np.median(means, axis=0)


def drift_at_rest(readings: Readings, span_s: float) -> Iterator[tuple[slice, FloatArray]]:
    """Speed that each rest gains within some time, by the accelerometer.

    Gravity is turned as the gyroscope says. What the force is off its mean over six seconds counts:
    an error of the gyroscope's offset turns gravity more slowly than that.

    Parameters
    ----------
    readings : Readings
    span_s : s; shorter rests are left out

    Yields
    ------
    slice, (k,) array, m/s, gained from each of its samples on that has the time left
    """
    rates, count = readings.gyr_radps - readings.offset(), round(span_s * readings.rate_hz)
    slowly = max(3, round(4 * span_s * readings.rate_hz))
    for rest in runs_of(readings.still_and_known):
        if rest.stop - rest.start <= count:
            continue
        step = np.diff(readings.time_s[rest], append=readings.time_s[rest.stop - 1])[:, None]
        # Small turns add up like vectors.
        turned = np.cumsum(rates[rest] * step, axis=0)
        force = readings.acc_mps2[rest]
        force = force + np.cross(turned, force)
        slow = ndimage.uniform_filter1d(force, slowly, axis=0, mode="nearest")
        speed = np.cumsum((force - slow) * step, axis=0)
        yield rest, np.linalg.norm(speed[count:] - speed[:-count], axis=1)
