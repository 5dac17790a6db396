"""Columns of truth values: as numbers, or in the words of pandas, R, and spreadsheets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.table import NumberTable, cells_of, parse_numbers
from mobility_imu.readers.wording import named, quoted

TRUE = frozenset({"true", "t", "yes", "y", "vrai", "oui", "verdadero", "sí", "si"})
FALSE = frozenset({"false", "f", "no", "n", "faux", "non", "falso"})
"""In English, French and Spanish, as the names of columns."""
MISSING = frozenset({"", "na", "nan"})


def with_flags(
    text: str, *, source: str, wanted: Callable[[str], bool], flags: Callable[[str], bool]
) -> NumberTable:
    """Parse a table whose columns of truth values are read if they are numbers.

    Parameters
    ----------
    text, source, wanted : as :func:`~mobility_imu.readers.table.parse_numbers` takes them
    flags : says of a name whether its column has truth values, for :func:`flag_column`

    Returns
    -------
    NumberTable, without the columns of truth values if any of them has words

    Raises
    ------
    InputError
        As ``parse_numbers``, for the columns that are wanted.
    """
    try:
        return parse_numbers(text, source=source, wanted=lambda name: wanted(name) or flags(name))
    except InputError:
        return parse_numbers(text, source=source, wanted=wanted)


def flag_column(table: NumberTable, place: int) -> FloatArray:
    """Truth values of a column that a table may have left out as no numbers.

    Parameters
    ----------
    table : NumberTable of a text, from :func:`with_flags`
    place : of the column in ``table.every``

    Returns
    -------
    (n,) array, 1 for a cell that says true, 0 for false, NaN for nothing

    Raises
    ------
    InputError
        With the line of the first cell that is neither 1 nor 0 nor such a word.
    """
    name = table.every[place]
    if table.header.count(name) == 1:
        flags = table.numbers[:, table.header.index(name)]
        wrong = ~(np.isnan(flags) | (flags == 0) | (flags == 1))
        if wrong.any():
            cells = cells_of(table.text, place, table.source, table.first_line)
            raise _no_flag(table, name, *cells[int(np.argmax(wrong))])
        return flags
    words = []  # cell by cell, which is slow
    for line, cell in cells_of(table.text, place, table.source, table.first_line):
        try:
            words.append(_flag(cell))
        except ValueError:
            raise _no_flag(table, name, line, cell) from None
    return np.array(words)


def _no_flag(table: NumberTable, name: str, line: int, cell: str) -> InputError:
    return InputError(
        f"{table.source}: line {line}, column {named(name)}: got '{quoted(cell)}', expected 1 or "
        "0, TRUE or FALSE, yes or no"
    )


def _flag(cell: str) -> float:
    word = cell.lower()
    if word in TRUE or word in FALSE:
        return float(word in TRUE)
    if word in MISSING:
        return float("nan")
    number = float(cell.replace(",", "."))
    if number not in (0, 1) or not cell.isascii():
        raise ValueError(cell)
    return number
