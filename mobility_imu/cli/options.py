"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def _folder(name: str) -> Path:
    """Path of a folder; an empty name, such as an unset variable's, is not the current folder."""
    if not name:
        raise typer.BadParameter("the name is empty; the current folder is '.'")
    return Path(name)


Output = Annotated[Path, typer.Option("--output", "-o", help="File to write.")]
Folder = Annotated[
    Path,
    typer.Option("--output", "-o", help="Folder to write into.", parser=_folder, metavar="PATH"),
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
