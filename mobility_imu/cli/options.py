"""Options that several commands have."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated

import typer

OTHER_FORMATS = (
    *(".xlsx", ".xls", ".ods", ".parquet", ".feather", ".mat", ".npy", ".npz", ".pkl", ".h5"),
    *(".hdf5", ".zip", ".bz2", ".xz"),
)
"""Endings of tables that are no CSV."""


def written(name: str) -> Path:
    """Path of a file or folder to write: nothing is written to standard output.

    Parameters
    ----------
    name : as typed

    Returns
    -------
    Path

    Raises
    ------
    BadParameter
        If the name is a hyphen, or begins with an equals sign, as of ``-o=a.csv``.
    """
    if name.startswith("="):
        raise typer.BadParameter(
            f"{name!r} begins with an equals sign; leave it out, or write a blank in its place "
            f"(./{name} for a file that is called so)"
        )
    if name == "-":
        raise typer.BadParameter(
            "'-' is no file, and nothing is written to standard output; give a name "
            "(./- for a file that is called so)"
        )
    return Path(name)


def written_file(name: str) -> Path:
    """Path of a file to write, which a folder's name is not.

    Parameters
    ----------
    name : as typed

    Returns
    -------
    Path

    Raises
    ------
    BadParameter
        As :func:`written`; and if the name ends as that of a folder.
    """
    path = written(name)
    if re.search(r"[/\\]\.?$" if os.sep == "\\" else r"/\.?$", name) and path.name:
        raise typer.BadParameter(
            f"{name!r} ends as the name of a folder does; expected the name of a file to write"
        )
    return path


def picture_file(name: str) -> Path:
    """Path of a picture to write; its ending is looked at by the command.

    Parameters
    ----------
    name : as typed

    Returns
    -------
    Path

    Raises
    ------
    BadParameter
        If the name ends as that of a folder.
    """
    return Path(name) if name == "-" else written_file(name)


def table_file(name: str) -> Path:
    """Path of a table to write, which is a CSV.

    Parameters
    ----------
    name : as typed

    Returns
    -------
    Path

    Raises
    ------
    BadParameter
        If the name is a hyphen, or says that it is another kind of file.
    """
    path = written_file(name)
    if path.suffix.lower() in OTHER_FORMATS:
        raise typer.BadParameter(
            f"tables are written as CSV, and {path.name} would be no {path.suffix[1:]} file; "
            "expected a name that ends in .csv or .csv.gz"
        )
    return path


Output = Annotated[
    Path,
    typer.Option("--output", "-o", help="File to write.", parser=written_file, metavar="PATH"),
]
Table = Annotated[
    Path,
    typer.Option(
        "--output", "-o", help="Table to write, as CSV.", parser=table_file, metavar="PATH"
    ),
]
Folder = Annotated[
    Path,
    typer.Option("--output", "-o", help="Folder to write into.", parser=written, metavar="PATH"),
]
Rate = Annotated[
    float | None,
    typer.Option(
        help="Hz; for files that state no rate (WheelMove-ID, the first x-IMU, some of Xsens), or "
        "whose rows share time stamps.",
        min=1,
    ),
]
Strict = Annotated[
    bool,
    typer.Option("--strict", help="Refuse a recording with any fault of a sensor that is used."),
]
FillGaps = Annotated[
    float,
    typer.Option(
        help="Fill gaps up to this length (s, at most 60) by interpolation; 0 refuses any, but up "
        "to 0.1 s, or one and a half steps, where uneven stamps or several files are brought on "
        "one clock.",
        min=0,
    ),
]
Seed = Annotated[int, typer.Option(help="The same seed gives the same bytes.", min=0)]
Smooth = Annotated[
    bool, typer.Option("--smooth/--no-smooth", help="Smooth the path, or filter only.")
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="No summary; warnings and errors are still shown.")
]


def sub_app(help_text: str) -> typer.Typer:
    """Group of commands, such as those of one device.

    Parameters
    ----------
    help_text : what ``--help`` says of the group

    Returns
    -------
    typer.Typer
    """
    # Without markup: [walker] in a help text is a section's name, not a style.
    return typer.Typer(no_args_is_help=True, rich_markup_mode=None, help=help_text)
