"""Outputs of commands: tables as they write them, and names that promise another kind of file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from mobility_imu.errors import InputError
from mobility_imu.files import Outputs, csv_bytes

if TYPE_CHECKING:
    import pandas as pd

TABLE, MOUNT = "a table in CSV", "a mount in TOML"
ENDINGS = {TABLE: (".csv", ".csv.gz"), MOUNT: (".toml",)}
"""Of the names of each kind of output."""
OTHER_KINDS = (
    *(".toml", ".json", ".jsonl", ".yaml", ".yml", ".xml", ".html", ".md", ".tex", ".py", ".ipynb"),
    *(".png", ".svg", ".pdf", ".jpg", ".jpeg", ".gif", ".eps", ".docx", ".doc"),
    *(".csv", ".tsv", ".xlsx", ".xls", ".ods", ".parquet", ".feather", ".mat", ".npy", ".npz"),
    *(".pkl", ".pickle", ".h5", ".hdf5", ".sqlite", ".gz", ".zip", ".bz2", ".xz", ".7z", ".tar"),
    *(".tgz", ".rar", ".zst", ".lz4", ".lzma", ".xlsm", ".rds", ".db", ".bmp", ".tif"),
)
"""Endings that name a kind of file; others, such as .txt, and names without one do not."""


def checked_outputs(
    files: Mapping[str, Path | None], inputs: tuple[Path, ...], kind: str = TABLE
) -> Outputs:
    """Outputs of one kind, checked as files and by their names.

    Parameters
    ----------
    files, inputs : as :class:`~mobility_imu.files.Outputs` takes them
    kind : :data:`TABLE` or :data:`MOUNT`

    Returns
    -------
    Outputs

    Raises
    ------
    InputError
        As ``Outputs``; then for a name that ends as that of another kind of file.
    """
    outputs = Outputs(files, inputs)
    check_kinds(files, kind)
    return outputs


def check_kinds(outputs: Mapping[str, Path | None], kind: str = TABLE) -> None:
    """Check that no output's name ends as that of another kind of file.

    Parameters
    ----------
    outputs : option to path, None where an option is not given; they are checked as files before
    kind : :data:`TABLE` or :data:`MOUNT`

    Raises
    ------
    InputError
        With the option and the name.
    """
    for option, path in outputs.items():
        if path is None or path.name.lower().endswith(ENDINGS[kind]):
            continue
        packed = kind == TABLE and path.suffix.lower() == ".gz"
        ending = Path(path.stem if packed else path.name).suffix.lower()
        if ending in OTHER_KINDS:
            raise InputError(
                f"{option} {path}: is to be {kind}, and its name says {ending[1:]}; expected a "
                f"name that ends in {' or '.join(ENDINGS[kind])}"
            )


def print_and_write(text: str, outputs: Outputs, contents: Mapping[Path, bytes]) -> None:
    """Print, and write files; what cannot be printed leaves no file behind.

    Where nobody reads the text any more, as behind ``| head``, the files are written all the same.

    Parameters
    ----------
    text : for standard output
    outputs : checked before the work
    contents : as ``Outputs.write`` takes them
    """
    unread = None
    try:
        typer.echo(text)
    except BrokenPipeError as error:
        unread = error
    if contents:
        outputs.write(contents)
    if unread is not None:
        raise unread


def table_bytes(table: pd.DataFrame, path: Path) -> bytes:
    """Content of a CSV file; packed if its name ends in .gz, in capitals or not.

    Parameters
    ----------
    table : DataFrame
    path : name of the file, as typed

    Returns
    -------
    bytes
    """
    return csv_bytes(table, path.with_suffix(path.suffix.lower()))
