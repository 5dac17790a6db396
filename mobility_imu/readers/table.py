"""Read a text table of numbers, or say which line and column is at fault."""

from __future__ import annotations

import gzip
import io
import re
import stat
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.files import as_path
from mobility_imu.frames import FloatArray
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.results import Result

_BLANKS = " \t\r\v\f"
"""What the parser of numbers passes over; a space that is not to be broken is none of them."""
_LINE_ENDS = re.compile(r"\r\n|\r|\n")
_NUMBER = re.compile(
    r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|inf|infinity|nan)", re.ASCII | re.IGNORECASE
)


def read_text(path: str | Path, *, again: bool = False) -> str:
    """Content of a text file; a name that ends in ``.gz`` is unpacked.

    Parameters
    ----------
    path : file, or a pipe
    again : whether it is read more than once, which no pipe allows

    Returns
    -------
    str

    Raises
    ------
    InputError
        If the file is missing, empty, not text, or a packed file that is damaged or cut short.
    """
    path = as_path(path)
    try:
        raw = _read_bytes(path, again)
        if path.suffix == ".gz":
            raw = gzip.decompress(raw)
        text = raw.decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file (byte {error.start})") from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{path}: cannot be unpacked ({error}); is it complete?") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read ({why})") from None
    if not text.strip():
        raise InputError(f"{path}: the file is empty")
    return text


def _read_bytes(path: Path, again: bool) -> bytes:
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise InputError(f"{path}: is a folder, expected a file")
    if again and stat.S_ISFIFO(mode):
        raise InputError(f"{path}: is a pipe, which can be read only once; expected a file")
    # Some devices never end.
    if not (stat.S_ISREG(mode) or stat.S_ISFIFO(mode)):
        raise InputError(f"{path}: is a device or socket, expected a file")
    return path.read_bytes()


@dataclass(frozen=True, eq=False, repr=False)
class NumberTable(Result):
    """Columns of numbers under their names.

    Parameters
    ----------
    header : names of the columns, as the file has them
    numbers : (n, columns) array; an empty cell is NaN
    source : the file's name, for messages
    """

    header: list[str]
    numbers: FloatArray
    source: str

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.numbers)

    def columns(self, wanted: Sequence[str]) -> FloatArray:
        """Columns with these names (any case), in this order.

        Parameters
        ----------
        wanted : names

        Returns
        -------
        (n, len(wanted)) array

        Raises
        ------
        InputError
            If a column is missing, or any name of the table stands twice.
        """
        places = self._places
        missing = [name for name in wanted if name.lower() not in places]
        if missing:
            raise InputError(
                f"{self.source}: no column {listed(missing)} (it has: {listed(self.header)})"
            )
        return self.numbers[:, [places[name.lower()] for name in wanted]]

    @cached_property
    def _places(self) -> dict[str, int]:
        places: dict[str, int] = {}
        for k, name in enumerate(self.header):
            if name.lower() in places:
                raise InputError(f"{self.source}: column {quoted(name.lower())} stands twice")
            places[name.lower()] = k
        return places


def parse_numbers(text: str, *, separator: str, source: str, first_line: int = 1) -> NumberTable:
    """Parse a header line and rows of numbers; decimal points or, with ``;`` or tabs, commas.

    Parameters
    ----------
    text : header and rows
    separator : one character
    source : the file's name, for messages
    first_line : line number of the header in the file, for messages

    Returns
    -------
    NumberTable

    Raises
    ------
    InputError
        No rows, a row with another number of cells (a cut last line), or a cell that is no number.
    """
    import pandas as pd

    header_line, _, body = text.partition("\n")
    header = [name.strip() for name in header_line.strip("\r\n").rstrip(separator).split(separator)]
    if not body.strip():
        raise InputError(f"{source}: a header, but no rows of data")
    decimal = "," if separator != "," and "," in body[:4096] else "."
    count = len(header)
    values = None
    # The parser takes the table's width from the first row, and drops cells beyond it; some
    # versions drop what follows a NUL, too.
    if _first_row(body).count(separator) <= count and "\0" not in body:
        try:
            frame = pd.read_csv(
                io.StringIO(body),
                sep=separator,
                header=None,
                # One more than the header has: there a row with a cell too many shows itself.
                names=list(range(count + 1)),
                index_col=False,
                decimal=decimal,
                dtype=np.float64,
                skipinitialspace=True,
                **_exact(pd.__version__),
            )
        except (ValueError, OverflowError, pd.errors.ParserError):
            pass
        else:
            values = frame.to_numpy()
    if values is None or np.isnan(values[:, :-1]).any() or not np.isnan(values[:, -1]).all():
        # Slow and thorough, only when something is wrong: name the line and the column.
        _check_cells(body, header, separator, decimal, source, first_line + 1)
    if values is None:
        raise InputError(f"{source}: cannot be read as a table of numbers")
    return NumberTable(header, values[:, :-1], source)


def _exact(version: str) -> dict[str, Any]:
    """Options with which this version of pandas reads each number to its last digit."""
    before = tuple(int(part) for part in version.split(".")[:2]) < (3, 1)
    return {"float_precision": "round_trip"} if before else {}


def _first_row(body: str) -> str:
    start = len(body) - len(body.lstrip("\r\n"))
    end = _LINE_ENDS.search(body, start)
    return body[start : end.start() if end else len(body)]


def _check_cells(
    body: str, header: Sequence[str], separator: str, decimal: str, source: str, line: int
) -> None:
    """Raise an error for the first line with another number of cells, or with a cell of text."""
    for number, row in enumerate(_LINE_ENDS.split(body), start=line):
        if not row.strip():
            continue
        cells = row.split(separator)
        if len(cells) == len(header) + 1 and not cells[-1].strip():
            cells.pop()
        if len(cells) != len(header):
            guess = ""
            if len(cells) < len(header):
                guess = "; was the file cut short?"
            elif separator == ",":
                guess = "; decimal commas?"
            raise InputError(
                f"{source}: line {number} has {len(cells)} of {len(header)} cells{guess}"
            )
        for name, cell in zip(header, cells, strict=True):
            if not _is_number(cell, decimal):
                raise InputError(
                    f"{source}: line {number}, column {quoted(name)}: '{quoted(cell)}' is not a "
                    "number" + (" with a decimal comma" if decimal == "," else "")
                )


def _is_number(cell: str, decimal: str) -> bool:
    """Whether a cell is empty or holds a number, in quotation marks or not."""
    text = cell.strip(_BLANKS)
    if len(text) > 1 and text[0] == text[-1] == '"':
        text = text[1:-1].strip(_BLANKS)
    if decimal != ".":
        if "." in text:
            return False
        text = text.replace(decimal, ".")
    return not text or _NUMBER.fullmatch(text) is not None
