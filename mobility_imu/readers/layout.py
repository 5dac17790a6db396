"""How a text table is laid out: separator, decimal mark, names, an index column, a ``sep=`` line.

Excel, R and pandas write the same table in different ways. This module finds the way; the numbers
are read in :mod:`mobility_imu.readers.table`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from typing import NamedTuple

from mobility_imu.errors import InputError
from mobility_imu.readers.wording import named

SEPARATORS = ("\t", ";", ",")
ROWS_LOOKED_AT = 20
"""Rows behind the names from which separator and decimal mark are told. Set by hand."""
_NOTHING = " \t\r\v\f;,"
_SEP_LINE = re.compile(r'\s*"?sep=(.)"?[\s;,]*', re.IGNORECASE)
"""Where a spreadsheet filled the rows up, separators stand behind it."""
_JSON = re.compile(r'\s*(?:\{\s*["}]|\[\s*[\[{])')
"""How an object or an array of JSON begins; no table has such names."""


class Layout(NamedTuple):
    """Where the cells of a text table are.

    Parameters
    ----------
    names : of the columns, without quotes and blanks around them
    separator : one character
    decimal : "." or ","
    indexed : whether each row begins with a cell that has no name (pandas' and R's index)
    line : line number of the names in the file, from 1
    body : the rows
    """

    names: tuple[str, ...]
    separator: str
    decimal: str
    indexed: bool
    line: int
    body: str


def find_layout(
    text: str, source: str, *, separator: str | None = None, first_line: int = 1
) -> Layout:
    """Layout of a table whose names stand in the first line that is not empty.

    Parameters
    ----------
    text : names and rows, perhaps after a line ``sep=;``
    source : the file's name, for messages
    separator : one character, if the format fixes it
    first_line : line number of the text's first line in its file, for messages

    Returns
    -------
    Layout

    Raises
    ------
    InputError
        If there is no row of data.
    """
    line = first_line
    head, rest = _next_line(text)
    while True:
        told = _SEP_LINE.fullmatch(head)
        if told and separator is None:
            separator = told[1]
        elif head.strip(_NOTHING) and not told:
            break
        if not rest:
            break
        head, rest = _next_line(rest)
        line += 1
    if _JSON.match(text):
        raise InputError(
            f"{source}: is JSON, expected a table with the names of its columns in the first line"
        )
    if not rest.strip():
        raise InputError(f"{source}: a header, but no rows of data")
    if separator is None:
        separator = max(SEPARATORS, key=_unquoted(head).count)
    names = [name.strip() for name in split_row(head, separator)]
    while len(names) > 1 and not names[-1]:
        names.pop()  # rows that end with a separator
    rows = [split_row(row, separator) for row in _first_rows(rest)]
    empty = _empty_ends(rows, len(names))
    if empty > 1:  # one is passed over anyway
        rest = re.sub(rf"(?m){re.escape(separator)}{{{empty}}}[ \r]*$", "", rest)
        rows = [row[:-empty] if not any(row[-empty:]) else row for row in rows]
    indexed = len(names) > 1 and not names[0]
    if indexed:
        names = names[1:]
    elif rows and all(len(row) == len(names) + 1 and row[-1].strip() for row in rows):
        # R's write.table has no name for its index; a cell too many has no other meaning if it
        # counts the rows.
        indexed = [row[0].strip().strip('"') for row in rows[:2]] == ["1", "2"]
    return Layout(tuple(names), separator, _decimal(rows), indexed, line, rest)


def split_row(row: str, separator: str) -> list[str]:
    """Cells of one line; a separator in quotation marks is part of its cell.

    Parameters
    ----------
    row : one line
    separator : one character

    Returns
    -------
    list of str
    """
    row = row.rstrip("\r\n")
    if '"' not in row:
        return row.split(separator)
    row = row.rstrip(" ")  # a blank behind a quoted cell is part of none
    try:
        return next(
            csv.reader([row], delimiter=separator, skipinitialspace=True, strict=True), [""]
        )
    except csv.Error:
        return row.split(separator)


def comma_separated(text: str) -> str:
    """Text of a format that has commas, also where a spreadsheet saved it with semicolons or tabs.

    A spreadsheet with decimal commas separates cells by semicolons, and any by tabs where it saves
    text; a line ends with as many as the longest line needs.

    Parameters
    ----------
    text : content of a file whose first line has no comma unless they separate cells

    Returns
    -------
    str, with decimal points and commas between cells
    """
    first = _unquoted(text.lstrip().partition("\n")[0])
    mark = next((mark for mark in ";\t" if mark in first), None)
    return text if mark is None or "," in first else text.replace(",", ".").replace(mark, ",")


def from_names(text: str) -> str:
    """Text of a table from its names on, without empty lines and a ``sep=`` line before them.

    Parameters
    ----------
    text : content of a file

    Returns
    -------
    str
    """
    rest = text
    while rest:
        head, behind = _next_line(rest)
        if head.strip(_NOTHING) and not _SEP_LINE.fullmatch(head):
            return rest
        rest = behind
    return text


def _empty_ends(rows: Sequence[Sequence[str]], count: int) -> int:
    """Empty cells beyond the named columns that every row ends with."""
    beyond = {len(row) - count for row in rows}
    if len(beyond) != 1 or (empty := beyond.pop()) < 1:
        return 0
    return empty if not any(cell.strip() for row in rows for cell in row[-empty:]) else 0


def _next_line(text: str) -> tuple[str, str]:
    head, _, rest = text.partition("\n")
    return head.rstrip("\r"), rest


def _unquoted(line: str) -> str:
    return re.sub(r'"[^"]*"', "", line)


def _first_rows(body: str) -> list[str]:
    """Some rows of the beginning; the last of a long body may be cut and is left out."""
    rows = [row for row in body[:100_000].splitlines()[: ROWS_LOOKED_AT + 1] if row.strip()]
    return rows[:ROWS_LOOKED_AT]


def _decimal(rows: Sequence[Sequence[str]]) -> str:
    """Decimal mark: a comma if some number has one, in quotation marks where commas separate."""
    number = re.compile(r"\s*[-+]?\d*,\d+\S*\s*")
    return "," if any(number.fullmatch(cell) for row in rows for cell in row) else "."


def check_names(names: Sequence[str], source: str) -> None:
    """Check that no name of a column appears twice.

    Parameters
    ----------
    names : of the columns
    source : the file's name, for messages

    Raises
    ------
    InputError
        With the first name that appears twice, whatever its case.
    """
    seen: set[str] = set()
    for name in names:
        if name.lower() in seen:
            raise InputError(f"{source}: column {named(name.lower())} appears twice")
        seen.add(name.lower())
