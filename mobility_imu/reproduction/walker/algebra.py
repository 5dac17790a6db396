"""Quaternions and vectors of numbers or of symbols, for derivations that a chapter carries out.

Hamilton's quaternions, scalar first. Only sums and products are used, so the entries may be
numbers, arrays of them, or SymPy's symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

__all__ = ["conjugate", "cross_rows", "product", "turned", "turning_rows"]

Entries = Sequence[Any]


def product(p: Entries, q: Entries) -> list[Any]:
    """Product of two quaternions.

    Parameters
    ----------
    p, q : four entries each, scalar first

    Returns
    -------
    list of four entries

    Examples
    --------
    >>> product([0, 1, 0, 0], [0, 0, 1, 0])  # i j = k
    [0, 0, 0, 1]
    """
    p0, p1, p2, p3 = p
    q0, q1, q2, q3 = q
    return [
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 - p1 * q3 + p2 * q0 + p3 * q1,
        p0 * q3 + p1 * q2 - p2 * q1 + p3 * q0,
    ]


def conjugate(q: Entries) -> list[Any]:
    """Conjugate of a quaternion: the opposite turn.

    Parameters
    ----------
    q : four entries, scalar first

    Returns
    -------
    list of four entries
    """
    return [q[0], -q[1], -q[2], -q[3]]


def turned(q: Entries, v: Entries) -> list[Any]:
    """Vector turned by a quaternion: the vector part of q (0, v) q*.

    Parameters
    ----------
    q : four entries, scalar first; of length 1 for a turn
    v : three entries

    Returns
    -------
    list of three entries

    Examples
    --------
    >>> turned([0, 0, 0, 1], [1, 2, 3])  # half a turn about z
    [-1, -2, 3]
    """
    return product(product(q, [0, *v]), conjugate(q))[1:]


def turning_rows(q: Entries) -> list[list[Any]]:
    """Matrix of the same turn, row by row; its columns are the turned unit vectors.

    Parameters
    ----------
    q : four entries, scalar first

    Returns
    -------
    list of three rows

    Examples
    --------
    >>> turning_rows([1, 0, 0, 0])
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    """
    columns = [turned(q, unit) for unit in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]
    return [list(row) for row in zip(*columns, strict=True)]


def cross_rows(v: Entries) -> list[list[Any]]:
    """Matrix [v×] of the cross product with a vector, row by row.

    Parameters
    ----------
    v : three entries

    Returns
    -------
    list of three rows
    """
    v1, v2, v3 = v
    return [[0, -v3, v2], [v3, 0, -v1], [-v2, v1, 0]]
