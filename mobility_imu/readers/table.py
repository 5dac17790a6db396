"""Read a text table of numbers, or say which line and column is at fault."""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import re
import stat
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.files import as_path
from mobility_imu.frames import FloatArray
from mobility_imu.readers.kinds import CONTROL, EXPORT, is_plain, what_to_do
from mobility_imu.readers.layout import Layout, check_names, find_layout, split_row
from mobility_imu.readers.wording import listed, named, quoted
from mobility_imu.results import Result

GZIP = b"\x1f\x8b"
"""How a packed file begins (RFC 1952, section 2.3.1)."""
LARGEST_UNPACKED = 2_000_000_000
"""Bytes of an unpacked file; more is no recording, and may fill the memory. Set by hand: 8 hours of
three sensors at 100 Hz with rows of 250 characters are 720 million."""
NUL = "\0"
MOST_COLUMNS = 20
"""Names of columns that a message lists at most."""
LONGEST_FILL_S = 60.0
"""A straight line over a longer gap says nothing of the motion. Set by hand."""
MEND_ROW = (
    "correct it, or remove the row; --fill-gaps-s (fill_gaps_s in Python) bridges gaps of up to "
    f"{LONGEST_FILL_S:g} s"
)
"""What to do with a row of a recording that lacks a number."""
_BEFORE = re.compile(r"[\s\ufeff]*")
"""What may stand before a text; a byte order mark stands behind blanks, or twice, where files were
put together."""
_BLANKS = " \t\r\v\f"
"""What the parser of numbers passes over; a space that is not to be broken is none of them."""
_LINE_ENDS = re.compile(r"\r\n|\r|\n")
MOST_RETURNS = 10
"""Carriage returns without a line feed, for each line feed, that are no ends of lines. Double ends
of lines have one. Set by hand."""
PART_BYTES = 2**20
_NUMBER = re.compile(
    r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|inf|infinity|nan)", re.ASCII | re.IGNORECASE
)


class EmptyFile(InputError):
    """A file without content."""


def read_text(path: str | Path, *, again: bool = False, form: str | None = None) -> str:
    """Content of a text file; a packed one (gzip) is unpacked, whatever its name.

    Parameters
    ----------
    path : file, or a pipe
    again : whether it is read more than once, which no pipe allows
    form : what is expected, such as "TOML"; None for a recording or another table

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
        if raw.startswith(GZIP) or (path.suffix.lower() == ".gz" and not _is_other(raw)):
            raw = _unpacked(raw, path)
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file{'' if again else beside(path)}") from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{path}: cannot be unpacked ({error}); is it complete?") from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read ({why})") from None
    return decoded(raw, str(path), form)


def beside(path: Path) -> str:
    """End of a message on a name that leads nowhere: what was meant by a hyphen.

    Parameters
    ----------
    path : the name

    Returns
    -------
    str, empty for other names
    """
    return "; standard input is read as /dev/stdin" if str(path) == "-" else ""


def _unpacked(raw: bytes, path: Path) -> bytes:
    with gzip.GzipFile(fileobj=io.BytesIO(raw)) as file:
        content = file.read(LARGEST_UNPACKED + 1)
    if len(content) > LARGEST_UNPACKED:
        raise InputError(f"{path}: is too large for a recording when it is unpacked")
    return content


def decoded(raw: bytes, source: str, form: str | None = None) -> str:
    """Text of a file in UTF-8, in UTF-16 with its mark, or as Windows in Western Europe writes it.

    Lines may end as on an old Macintosh, which some programs still write.

    Parameters
    ----------
    raw : content
    source : the file's name, for messages
    form : as for :func:`read_text`

    Returns
    -------
    str

    Raises
    ------
    InputError
        If it is empty or not text.
    """
    no_text = what_to_do(raw) if form is None else what_to_do(raw, export=f"expected {form}")
    if no_text:
        raise InputError(f"{source}: {no_text}")
    try:
        text = _as_text(raw)
    except UnicodeDecodeError as error:
        do = EXPORT if form is None else f"expected {form}"
        raise InputError(f"{source}: not a text file (byte {error.start}); {do}") from None
    before = _BEFORE.match(text)
    if before and "\ufeff" in before[0]:
        text = before[0].replace("\ufeff", "") + text[before.end() :]
    if not text.strip():
        raise EmptyFile(f"{source}: the file is empty")
    _check_end(text, source)
    return _with_line_feeds(text)


def _check_end(text: str, source: str) -> None:
    """Check that a text does not end in NUL bytes, as where a device loses its power."""
    end = text.rstrip()
    if not end.endswith(2 * NUL):  # UTF-16 without its mark has single ones
        return
    begin = end.rstrip(NUL)
    if not begin.strip():
        raise InputError(f"{source}: holds nothing but NUL bytes; copy it from the device again")
    raise InputError(
        f"{source}: line {begin.count(chr(10)) + 1}: the rest is NUL bytes, as where a device "
        "loses its power; cut the file there"
    )


def _with_line_feeds(text: str) -> str:
    """Text whose lines end in line feeds, if carriage returns alone end most of them."""
    feeds = text.count("\n")
    alone = text.count("\r") - text.count("\r\n")
    # One line feed at the end is often a program's own that passed the file on.
    if alone and (alone > MOST_RETURNS * feeds or "\n" not in text.rstrip()):
        return _LINE_ENDS.sub("\n", text)
    return text


def _is_other(raw: bytes) -> bool:
    """Whether bytes are known as no packed file: as a browser saves what it unpacked, by its name.

    They can be a text with some content in an 8-bit encoding, or begin as another kind of file.
    """
    return what_to_do(raw) != "" or is_plain(raw)


def _as_text(raw: bytes) -> str:
    if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return raw.decode("utf-16")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        if CONTROL.search(raw):
            raise
        try:
            return raw.decode("cp1252")
        except UnicodeDecodeError:
            pass
        raise


def _read_bytes(path: Path, again: bool) -> bytes:
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise InputError(f"{path}: is a folder, expected a file")
    if again and stat.S_ISFIFO(mode):
        raise InputError(f"{path}: is a pipe, which can be read only once; expected a file")
    # Some devices never end.
    if not (stat.S_ISREG(mode) or stat.S_ISFIFO(mode)):
        raise InputError(f"{path}: is a device or socket, expected a file")
    with path.open("rb", buffering=0) as file:
        # In parts: a whole pipe is read without looking for an interrupt after each part.
        return b"".join(iter(lambda: file.read(PART_BYTES), b""))


@dataclass(frozen=True, eq=False, repr=False)
class NumberTable(Result):
    """Columns of numbers under their names.

    Parameters
    ----------
    header : names of the columns, as the file has them
    numbers : (n, columns) array; an empty cell is NaN
    source : the file's name, for messages
    left_out : names of columns that were not read
    every : names of all columns of the file, in their order; empty if they are those of the header
    text, first_line : as :func:`parse_numbers` took them; empty for what is no text table
    """

    header: list[str]
    numbers: FloatArray
    source: str
    left_out: tuple[str, ...] = ()
    every: tuple[str, ...] = ()
    text: str = ""
    first_line: int = 1

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.numbers)

    def columns(self, wanted: Sequence[str], *, finite: bool = False) -> FloatArray:
        """Columns with these names (any case), in this order.

        Parameters
        ----------
        wanted : names
        finite : whether each row has to have a number in them

        Returns
        -------
        (n, len(wanted)) array

        Raises
        ------
        InputError
            If a column is missing, any name of the table appears twice, or a number is not finite.
        """
        places = self._places
        missing = [name for name in wanted if name.lower() not in places]
        if missing:
            raise InputError(
                f"{self.source}: no column {listed(missing)} (it has: {self.listed()})"
            )
        read = [places[name.lower()] for name in wanted]
        if finite:
            self.check_finite(read, advice=MEND_ROW)
        return self.numbers[:, read]

    def check_finite(self, places: Iterable[int], *, advice: str = "correct it") -> None:
        """Check that columns have a number in every row.

        Parameters
        ----------
        places : of the columns in the header
        advice : what to do, the end of the message

        Raises
        ------
        InputError
            With the line of the first cell that is empty, NaN or infinite.
        """
        for k in places:
            bad = ~np.isfinite(self.numbers[:, k])
            if bad.any():
                row = int(np.argmax(bad))
                where = (
                    f"line {line_of(self.text, row, self.first_line)}"
                    if self.text
                    else f"sample {row}"
                )
                raise InputError(
                    f"{self.source}: {where}, column {named(self.header[k])}: expected a number, "
                    f"got nothing, NaN or infinity ({int(bad.sum())} such row(s)); {advice}"
                )

    def listed(self) -> str:
        """Names of the file's columns, as messages list them."""
        return listed(self.every or self.header, MOST_COLUMNS)

    @cached_property
    def _places(self) -> dict[str, int]:
        check_names(self.header, self.source)
        return {name.lower(): k for k, name in enumerate(self.header)}


def parse_numbers(
    text: str,
    *,
    source: str,
    separator: str | None = None,
    first_line: int = 1,
    wanted: Callable[[str], bool] | None = None,
) -> NumberTable:
    """Parse a line of names and rows of numbers, in the dress of Excel, R or pandas.

    Names and numbers may stand in quotation marks; an index column is left out. With ``;`` or tabs
    as separator, numbers may have decimal commas.

    Parameters
    ----------
    text : names and rows, perhaps after a line ``sep=;``
    source : the file's name, for messages
    separator : one character, where the format fixes it; None finds it
    first_line : line number of the text's first line in its file, for messages
    wanted : says of a name whether its column is read; the cells of the other columns may hold
        anything. None reads all.

    Returns
    -------
    NumberTable

    Raises
    ------
    InputError
        No rows, a row with another number of cells (a cut last line), or a cell of a column that
        is read that is no number.
    """
    layout = find_layout(text, source, separator=separator, first_line=first_line)
    names = layout.names
    begin = int(layout.indexed)
    count = len(names) + begin
    read = [k for k, name in enumerate(names) if wanted is None or wanted(name)]
    kept = set(read)
    left_out = tuple(name for k, name in enumerate(names) if k not in kept)
    columns = [k + begin for k in read]
    frame = _read_quickly(layout, columns)
    if '"' in layout.body and (frame is None or len(frame) != sum(1 for _ in _lines(layout))):
        _check_quotes(layout, columns, source)
    values = None if frame is None else as_numbers(frame[[*columns, count]])
    if values is None or np.isnan(values[:, :-1]).any() or not np.isnan(values[:, -1]).all():
        # Slow and thorough, only when something is wrong: name the line and the column.
        _check_cells(layout, columns, source)
    # The parser fills a short row up at its end, whichever cell was lost.
    if frame is None or frame[count - 1].isna().any():
        _check_widths(layout, source)
    if values is None:
        values = _read_slowly(layout, columns, source)
    return NumberTable(
        [names[k] for k in read], values[:, : len(columns)], source, left_out=left_out, every=names,
        text=text, first_line=first_line,
    )  # fmt: skip


def cells_of(text: str, place: int, source: str, first_line: int = 1) -> list[tuple[int, str]]:
    """Cells of one column as they are written, with their lines; without quotation marks.

    Parameters
    ----------
    text, source, first_line : as :func:`parse_numbers` takes them, which has found every row whole
    place : of the column among the names of the whole table, from 0

    Returns
    -------
    list of (line from 1, cell)
    """
    layout = find_layout(text, source, first_line=first_line)
    cell = place + int(layout.indexed)
    return [(line, cells[cell].strip(_BLANKS)) for line, cells in _rows(layout)]


def line_of(text: str, row: int, first_line: int = 1) -> int:
    """Line in which a row of a table stands, as an editor counts lines.

    Parameters
    ----------
    text, first_line : as :func:`parse_numbers` takes them
    row : from 0

    Returns
    -------
    int, from 1
    """
    layout = find_layout(text, "", first_line=first_line)
    lines = enumerate(_LINE_ENDS.split(layout.body), start=layout.line + 1)
    return next(islice((number for number, line in lines if line.strip()), row, None))


def _read_quickly(layout: Layout, columns: Sequence[int]) -> Any:
    """All columns and one more, those to be read as numbers; None if the parser refuses them."""
    import pandas as pd

    count = len(layout.names) + int(layout.indexed)
    floats = set(columns)
    # The parser takes the table's width from the first row, and drops cells beyond it; some
    # versions drop what follows a NUL, too.
    if _first_row(layout.body).count(layout.separator) > count or "\0" in layout.body:
        return None
    try:
        return pd.read_csv(
            io.StringIO(layout.body),
            sep=layout.separator,
            header=None,
            # One more than the header has: there a row with a cell too many shows itself.
            names=list(range(count + 1)),
            index_col=False,
            decimal=layout.decimal,
            dtype={k: str for k in range(count) if k not in floats},
            skipinitialspace=layout.separator != " ",
            low_memory=False,  # in parts, one column could have several types
            **_exact(pd.__version__),
        )
    except (ValueError, OverflowError, pd.errors.ParserError):
        return None


def as_numbers(frame: Any) -> FloatArray | None:
    """Columns of a pandas table as numbers; None if one holds anything else.

    Words such as TRUE would be converted to 1, and "1_0" to 10.

    Parameters
    ----------
    frame : DataFrame whose columns have the types that pandas found

    Returns
    -------
    (n, columns) array, or None
    """
    if any(dtype.kind not in "iuf" for dtype in frame.dtypes):
        return None
    return np.asarray(frame.to_numpy(dtype=float))


def _exact(version: str) -> dict[str, Any]:
    """Options with which this version of pandas reads each number to its last digit."""
    before = tuple(int(part) for part in version.split(".")[:2]) < (3, 1)
    return {"float_precision": "round_trip"} if before else {}


def _first_row(body: str) -> str:
    start = len(body) - len(body.lstrip("\r\n"))
    end = _LINE_ENDS.search(body, start)
    return body[start : end.start() if end else len(body)]


def _lines(layout: Layout) -> Iterator[tuple[int, str]]:
    """Line number and text of each row."""
    for number, row in enumerate(_LINE_ENDS.split(layout.body), start=layout.line + 1):
        if row.strip():
            yield number, row


def _rows(layout: Layout) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row; an empty cell may be left over at its end."""
    count = len(layout.names) + int(layout.indexed)
    for number, row in _lines(layout):
        cells = split_row(row, layout.separator)
        if len(cells) == count + 1 and not cells[-1].strip():
            cells.pop()
        yield number, cells


def _check_quotes(layout: Layout, columns: Sequence[int], source: str) -> None:
    """Raise an error for the first cell of text whose quotation mark is not closed on its line.

    In a column of numbers, the mark is part of what is no number.
    """
    mark = layout.separator
    for number, row in _lines(layout):
        if '"' not in row:
            continue
        reader = csv.reader([row, ""], delimiter=mark, skipinitialspace=mark != " ")
        try:
            cells = next(reader)
        except csv.Error:
            continue
        # A cell that is still open at the end of the row takes the next line in.
        if reader.line_num > 1 and len(cells) - 1 not in columns:
            raise InputError(
                f"{source}: line {number}: a quotation mark is not closed on its line, and the "
                "rows behind it would be lost; close it or remove it"
            )


def _check_widths(layout: Layout, source: str) -> None:
    """Raise an error for a line that lost a cell, or has one too many, whatever its cells hold.

    Where rows end with a separator, one that lost a cell has as many as the header, the last empty.
    """
    count = len(layout.names) + int(layout.indexed)
    mark = layout.separator
    ended: list[tuple[int, str]] = []
    bare: list[tuple[int, str]] = []
    for number, row in _lines(layout):
        if '"' in row:
            cells = split_row(row, mark)
            width, last = len(cells), cells[-1]
        else:
            width, last = row.count(mark) + 1, row.rpartition(mark)[2]
        empty = not last.strip()
        if width != count and not (empty and width == count + 1):
            raise _wrong_width(layout, number, split_row(row, mark), source)
        if empty:
            (bare if width == count else ended).append((number, row))
    if ended and bare:
        number, row = min(ended, bare, key=len)[0]
        cells = split_row(row, mark)
        raise _wrong_width(layout, number, cells if len(cells) > count else cells[:-1], source)


def _wrong_width(layout: Layout, number: int, cells: Sequence[str], source: str) -> InputError:
    """Error for a line with another number of cells than the header has names."""
    count = len(layout.names) + int(layout.indexed)
    guess = ""
    if len(cells) == 1 and len(row_of_words := cells[0].split()) > 1:
        guess = (
            f"; {len(row_of_words)} words between blanks: separate them by commas, "
            "semicolons or tabs"
        )
    elif len(cells) < count:
        guess = "; was the file cut short?"
    elif layout.separator == "," and _pairs_up(cells, count):
        guess = "; decimal commas? Then separate the cells by semicolons or tabs"
    return InputError(f"{source}: line {number} has {len(cells)} of {count} cells{guess}")


def _check_cells(layout: Layout, columns: Sequence[int], source: str) -> None:
    """Raise an error for the first line with another number of cells, or with a cell of text."""
    begin = int(layout.indexed)
    count = len(layout.names) + begin
    for number, cells in _rows(layout):
        if len(cells) != count:
            raise _wrong_width(layout, number, cells, source)
        for k in columns:
            if not _is_number(cells[k], layout.decimal):
                raise InputError(
                    f"{source}: line {number}, column {named(layout.names[k - begin])}: "
                    f"'{quoted(cells[k])}' is not a number"
                    + (" with a decimal comma" if layout.decimal == "," else "")
                )


def _pairs_up(cells: Sequence[str], count: int) -> bool:
    """Whether the cells can be numbers cut in two at their decimal commas."""
    fractions = sum(re.fullmatch(r"\s*\d+\s*", cell, re.ASCII) is not None for cell in cells)
    return fractions >= len(cells) - count


def _read_slowly(layout: Layout, columns: Sequence[int], source: str) -> FloatArray:
    """Numbers cell by cell, for tables whose cells are right but which the parser refuses."""
    rows = [[_number(cells[k], layout.decimal) for k in columns] for _, cells in _rows(layout)]
    if not rows:
        raise InputError(f"{source}: cannot be read as a table of numbers")
    return np.array(rows, float).reshape(len(rows), len(columns))


def _number(cell: str, decimal: str) -> float:
    text = cell.strip(_BLANKS).strip('"').strip(_BLANKS).replace(decimal, ".")
    return float(text) if text else float("nan")


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
