"""Sums over the force between two rests, turned as the gyroscope says: in arrays, or in a loop.

A fit of both halves needs them a hundred times. The compiled loop takes a fifth of the time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobility_imu._compiled import choose, compiled
from mobility_imu.frames import FloatArray

__all__ = ["Attitudes", "Moved", "TurnedSums", "quickest_sums", "sums_in_a_loop", "sums_in_arrays"]

TINY = 1e-300
"""A turn of nothing is divided by it instead of by zero."""
SERIES = 1e-3
"""Square of a half angle, up to which what the series of sine and cosine leave out is rounding."""
PLAIN_S = 5e-5
"""About the time that a fit by the arrays takes for each sample, s."""

ComplexArray = NDArray[np.complexfloating[Any, Any]]
"""Halves of quaternions, as :class:`Attitudes` has them."""


class Moved(NamedTuple):
    """Moves side by side, each padded to the longest one.

    Parameters
    ----------
    begins, counts : (m,) int arrays, first sample of each move and the number of its samples
    rates : (k + 1, 3) array, rad/s, means of neighbours; row i is from sample i - 1 to i
    step : (m, n - 1) array, s, 0 in the padding
    force : (m, n, 3) array, m/s²
    weights : (m, w, n) array, of each sum; 0 in the padding
    """

    begins: NDArray[np.int64]
    counts: NDArray[np.int64]
    rates: FloatArray
    step: FloatArray
    force: FloatArray
    weights: FloatArray


class TurnedSums(NamedTuple):
    """Sums over each move, in the axes of its first sample.

    Parameters
    ----------
    forces : (m, w, 3) array, weighed sums of the turned force
    turns : (m, w, 3, 3) array, of the rotations to the first sample: an offset of the force times
        them adds to ``forces``
    ends : (m, 3, 3) array, rotation of the last sample to the first
    """

    forces: FloatArray
    turns: FloatArray
    ends: FloatArray


Sums = Callable[[Moved, int, FloatArray], TurnedSums]


class Attitudes(NamedTuple):
    """Quaternions as pairs of complex numbers, w + x i and y + z i, which multiply fastest."""

    first: ComplexArray
    second: ComplexArray

    def times(self, first: ComplexArray, second: ComplexArray) -> Attitudes:
        """Product with other quaternions."""
        return Attitudes(
            self.first * first - self.second * second.conj(),
            self.first * second + self.second * first.conj(),
        )

    def part(self, samples: slice) -> Attitudes:
        """Those of some samples of each move."""
        return Attitudes(self.first[:, samples], self.second[:, samples])

    def running_products(self) -> Attitudes:
        """Product of each and all before it: of pairs first, then of the single ones after them."""
        count = self.first.shape[1]
        if count == 1:
            return self
        pairs = self.part(slice(0, count - 1, 2)).times(*self.part(slice(1, None, 2)))
        pairs = pairs.running_products()
        singles = pairs.part(slice((count - 1) // 2)).times(*self.part(slice(2, None, 2)))
        result = Attitudes(self.first.copy(), self.second.copy())
        for whole, of_pairs, of_singles in zip(result, pairs, singles, strict=True):
            whole[:, 1::2], whole[:, 2::2] = of_pairs, of_singles
        return result

    def rows(self, out: FloatArray) -> None:
        """The nine numbers of the same turns as matrices, row by row, in ``out`` (m, 9, n)."""
        w, x, y, z = self.first.real, self.first.imag, self.second.real, self.second.imag
        for i, j, one, two, three in ((0, 1, x, y, z), (1, 2, y, z, x), (2, 0, z, x, y)):
            out[:, 4 * i] = 1 - 2 * (two * two + three * three)
            product, turn = one * two, w * three
            out[:, 3 * i + j], out[:, 3 * j + i] = 2 * (product - turn), 2 * (product + turn)


def quickest_sums(moved: Moved) -> Sums:
    """The loop or the arrays, whichever a fit is done by sooner.

    Parameters
    ----------
    moved : Moved

    Returns
    -------
    :func:`sums_in_a_loop` or :func:`sums_in_arrays`
    """
    plain_s = PLAIN_S * moved.weights.shape[0] * moved.weights.shape[2]
    how = choose({_loop: (*moved, 0, np.eye(3))}, plain_s=plain_s, what="fit from rest to rest")
    return sums_in_a_loop if how == "compiled" else sums_in_arrays


def sums_in_a_loop(moved: Moved, late: int, mixing: FloatArray) -> TurnedSums:
    """Sums with rates that come late, and are multiplied, one sample after the other.

    Parameters
    ----------
    moved : Moved
    late : samples
    mixing : (3, 3) array

    Returns
    -------
    TurnedSums
    """
    return TurnedSums(*_loop(*moved, late, mixing))


def sums_in_arrays(moved: Moved, late: int, mixing: FloatArray) -> TurnedSums:
    """The same sums for all moves at once.

    Parameters
    ----------
    moved : Moved
    late : samples
    mixing : (3, 3) array

    Returns
    -------
    TurnedSums
    """
    begins, counts, rates, step, force, weights = moved
    after = np.minimum(np.arange(1, weights.shape[2]), counts[:, None] - 1)
    between = np.clip(begins[:, None] + after + late, 0, len(rates) - 1)
    x, y, z = (mixing @ rates.T)[:, between] * step
    half = np.sqrt(x**2 + y**2 + z**2) / 2
    size = np.sin(half) / np.maximum(half, TINY) / 2
    shape = weights.shape[::2]
    first, second = np.ones(shape, complex), np.zeros(shape, complex)
    first[:, 1:] = np.cos(half) + 1j * (size * x)
    second[:, 1:] = size * (y + 1j * z)
    # Nine numbers of the turn and three of the turned force, each side by side for all samples.
    rows = np.empty((shape[0], 12, shape[1]))
    Attitudes(first, second).running_products().rows(rows[:, :9])
    along = force.transpose(2, 0, 1)
    for i in range(3):
        rows[:, 9 + i] = sum(rows[:, 3 * i + axis] * along[axis] for axis in range(3))
    both = weights @ rows.swapaxes(1, 2)
    turns = both[..., :9].reshape(*both.shape[:2], 3, 3)
    return TurnedSums(both[..., 9:], turns, rows[:, :9, -1].reshape(-1, 3, 3))


@compiled(fastmath={"contract"}, error_model="numpy")
def _loop(
    begins: NDArray[np.int64],
    counts: NDArray[np.int64],
    rates: FloatArray,
    step: FloatArray,
    force: FloatArray,
    weights: FloatArray,
    late: int,
    mixing: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    moves, kinds = weights.shape[0], weights.shape[1]
    forces, turns = np.zeros((moves, kinds, 3)), np.zeros((moves, kinds, 3, 3))
    ends, last = np.zeros((moves, 3, 3)), rates.shape[0] - 1
    for m in range(moves):
        w, x, y, z = 1.0, 0.0, 0.0, 0.0
        for k in range(counts[m]):
            if k > 0:
                row = min(max(begins[m] + k + late, 0), last)
                a, b, c = rates[row, 0], rates[row, 1], rates[row, 2]
                half = step[m, k - 1] / 2
                p = (mixing[0, 0] * a + mixing[0, 1] * b + mixing[0, 2] * c) * half
                q = (mixing[1, 0] * a + mixing[1, 1] * b + mixing[1, 2] * c) * half
                r = (mixing[2, 0] * a + mixing[2, 1] * b + mixing[2, 2] * c) * half
                square = p * p + q * q + r * r
                if square < SERIES:
                    cosine = 1 - square * (1 / 2 - square * (1 / 24 - square / 720))
                    sine = 1 - square * (1 / 6 - square * (1 / 120 - square / 5040))
                else:
                    angle = np.sqrt(square)
                    cosine, sine = np.cos(angle), np.sin(angle) / angle
                p, q, r = sine * p, sine * q, sine * r
                w, x, y, z = (
                    w * cosine - x * p - y * q - z * r,
                    w * p + x * cosine + y * r - z * q,
                    w * q - x * r + y * cosine + z * p,
                    w * r + x * q - y * p + z * cosine,
                )
            turn = (
                w * w + x * x - y * y - z * z,
                2 * (x * y - w * z),
                2 * (x * z + w * y),
                2 * (x * y + w * z),
                w * w - x * x + y * y - z * z,
                2 * (y * z - w * x),
                2 * (x * z - w * y),
                2 * (y * z + w * x),
                w * w - x * x - y * y + z * z,
            )
            a, b, c = force[m, k, 0], force[m, k, 1], force[m, k, 2]
            for i in range(3):
                one, two, three = turn[3 * i], turn[3 * i + 1], turn[3 * i + 2]
                along = one * a + two * b + three * c
                for kind in range(kinds):
                    weight = weights[m, kind, k]
                    forces[m, kind, i] += weight * along
                    turns[m, kind, i, 0] += weight * one
                    turns[m, kind, i, 1] += weight * two
                    turns[m, kind, i, 2] += weight * three
                ends[m, i, 0], ends[m, i, 1], ends[m, i, 2] = one, two, three
    return forces, turns, ends
