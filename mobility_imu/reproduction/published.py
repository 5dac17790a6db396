"""The papers' tables as printed: the numbers that ours are compared with."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from mobility_imu.data import published_folder
from mobility_imu.errors import InputError
from mobility_imu.frames import shown

if TYPE_CHECKING:
    import pandas as pd


def published_names() -> list[str]:
    """Names that :func:`load_published` knows, in alphabetical order.

    Returns
    -------
    list of str

    Examples
    --------
    >>> published_names()[0]
    'scooter_table1'
    """
    return sorted(path.stem for path in published_folder().glob("*_table*.csv"))


def load_published(name: str) -> pd.DataFrame:
    """One published table, one line per printed cell, apparent misprints included.

    Parameters
    ----------
    name : work and table, for instance ``"scooter_table1"``

    Returns
    -------
    DataFrame
        Columns ``work``, ``table``, ``row``, ``column``, ``quantity``, ``printed`` (text, exactly
        as printed), ``value`` (the same as a number, NaN for letters and conditions), ``unit``.

    Raises
    ------
    InputError
        If there is no such table.

    Examples
    --------
    >>> cells = load_published("scooter_table1").set_index(["row", "column", "quantity"])
    >>> cells.loc[("upward", "e", "single_mae"), "printed"]
    '9.7'
    """
    if not isinstance(name, str):
        raise InputError(f"published table {shown(name)}: expected the name of a table")
    return _load(published_folder(), name).copy()


@cache
def _load(folder: Path, name: str) -> pd.DataFrame:
    """The table, read once."""
    import pandas as pd

    names = published_names()
    if name not in names:
        raise InputError(f"published table {name!r} is unknown; available: {', '.join(names)}")
    cells = pd.read_csv(folder / f"{name}.csv", dtype=str, keep_default_na=False)
    cells = cells.rename(columns={"value": "printed"})
    cells["table"] = cells["table"].astype(int)
    cells.insert(
        cells.columns.get_loc("unit"), "value", pd.to_numeric(cells["printed"], errors="coerce")
    )
    return cells
