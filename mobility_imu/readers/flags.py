"""Columns of truth values: as numbers, or in the words of pandas, R, and spreadsheets."""

from __future__ import annotations

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.table import NumberTable, cells_of
from mobility_imu.readers.wording import quoted

TRUE = frozenset({"true", "t", "yes", "y", "vrai", "oui", "verdadero", "sí", "si"})
FALSE = frozenset({"false", "f", "no", "n", "faux", "non", "falso"})
"""In English, French and Spanish, as the names of columns."""
MISSING = frozenset({"", "na", "nan"})


def flag_column(table: NumberTable, place: int) -> FloatArray:
    """Truth values of a column that a table may have left out as no numbers.

    Parameters
    ----------
    table : NumberTable of a text
    place : of the column in ``table.every``

    Returns
    -------
    (n,) array, the number of each cell: 1 for a word that says true, 0 for false, NaN for nothing

    Raises
    ------
    InputError
        With the line of the first cell that is neither a number nor such a word.
    """
    name = quoted(table.every[place])
    return np.array(
        [
            _flag(cell, f"{table.source}: line {line}, column {name}")
            for line, cell in cells_of(table.text, place, table.source, table.first_line)
        ]
    )


def _flag(cell: str, where: str) -> float:
    word = cell.lower()
    if word in TRUE or word in FALSE:
        return float(word in TRUE)
    if word in MISSING:
        return float("nan")
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        raise InputError(
            f"{where}: got '{quoted(cell)}', expected 1 or 0, TRUE or FALSE, yes or no"
        ) from None
