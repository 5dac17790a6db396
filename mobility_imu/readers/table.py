"""Read a text table of numbers, or say which line and column is at fault."""

from __future__ import annotations

import gzip
import io
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray


def read_text(path: str | Path) -> str:
    """Give a text file's content; ``.gz`` is unpacked.

    Raises
    ------
    InputError
        If the file is missing, empty, cut short (``.gz``), or not text.
    """
    path = Path(path)
    try:
        raw = path.read_bytes()
        if path.suffix == ".gz":
            raw = gzip.decompress(raw)
        text = raw.decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, expected a file") from None
    except (EOFError, gzip.BadGzipFile, OSError) as error:
        raise InputError(f"{path}: cannot be read ({error}); is it complete?") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file (byte {error.start})") from None
    if not text.strip():
        raise InputError(f"{path}: the file is empty")
    return text


def parse_numbers(
    text: str, *, separator: str, source: str, first_line: int = 1
) -> tuple[list[str], FloatArray]:
    """Parse a header line and rows of numbers; decimal points or, with ``;`` or tabs, commas.

    Parameters
    ----------
    text : header and rows
    separator : one character
    source : the file's name, for messages
    first_line : line number of the header in the file, for messages

    Returns
    -------
    header : column names, stripped
    values : (n, columns) array; an empty cell is NaN

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
    try:
        with warnings.catch_warnings():
            # Rows longer than the header: pandas would drop the rest and go on.
            warnings.simplefilter("error", pd.errors.ParserWarning)
            frame = pd.read_csv(
                io.StringIO(body),
                sep=separator,
                header=None,
                names=list(range(len(header))),
                index_col=False,
                decimal=decimal,
                dtype=np.float64,
                skipinitialspace=True,
            )
    except (ValueError, pd.errors.ParserError, pd.errors.ParserWarning):
        frame = None
    if frame is None or frame.isna().to_numpy().any():
        # Slow and thorough, only when something is wrong: name the line and the column.
        _check_cells(body, header, separator, decimal, source, first_line + 1)
    if frame is None:
        raise InputError(f"{source}: cannot be read as a table of numbers")
    return header, frame.to_numpy()


def _check_cells(
    body: str, header: Sequence[str], separator: str, decimal: str, source: str, line: int
) -> None:
    for number, row in enumerate(body.splitlines(), start=line):
        if not row.strip():
            continue
        cells = row.strip("\r\n").split(separator)
        if len(cells) == len(header) + 1 and not cells[-1].strip():
            cells.pop()
        if len(cells) != len(header):
            guess = "was the file cut short?" if len(cells) < len(header) else "decimal commas?"
            raise InputError(
                f"{source}: line {number} has {len(cells)} of {len(header)} cells; {guess}"
            )
        for name, cell in zip(header, cells, strict=True):
            try:
                float(cell.replace(decimal, ".") or "nan")
            except ValueError:
                raise InputError(
                    f"{source}: line {number}, column {name}: '{cell}' is not a number"
                ) from None


def pick_columns(
    header: Sequence[str], values: FloatArray, wanted: Sequence[str], source: str
) -> FloatArray:
    """Give the columns with these names (any case), in this order."""
    lower = [name.lower() for name in header]
    for name in lower:
        if lower.count(name) > 1:
            raise InputError(f"{source}: column {name} stands twice")
    missing = [name for name in wanted if name.lower() not in lower]
    if missing:
        raise InputError(f"{source}: no column {', '.join(missing)} (it has: {', '.join(header)})")
    return values[:, [lower.index(name.lower()) for name in wanted]]
