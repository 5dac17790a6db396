"""Walker: tables and rows of the record ``walker_walks``, for chapters and claims."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from mobility_imu.reproduction.recorded import load_record

if TYPE_CHECKING:
    import pandas as pd

RECORD = "walker_walks"


@cache
def walk_record() -> dict[str, Any]:
    """The record, see :func:`mobility_imu.reproduction.recorded.load_record`."""
    return load_record(RECORD)


def recorded_row(section: str, **key: Any) -> dict[str, Any]:
    """The one row of a recorded table that has the given values.

    Parameters
    ----------
    section : a table of :func:`mobility_imu.reproduction.walker.walks.walk_numbers`
    **key : columns and their values

    Returns
    -------
    dict

    Examples
    --------
    >>> row = recorded_row("corridor", level="realistic")
    >>> row["walks"]
    100
    """
    rows = walk_record()["numbers"][section]
    (row,) = (r for r in rows if all(r[name] == key[name] for name in key))
    return dict(row)


def recorded_table(section: str, **key: Any) -> pd.DataFrame:
    """A recorded table, or its rows that have the given values.

    Parameters
    ----------
    section : as in :func:`recorded_row`
    **key : columns and their values; these columns are left out

    Returns
    -------
    DataFrame

    Examples
    --------
    >>> len(recorded_table("corridor")), len(recorded_table("corridor", level="sensor"))
    (3, 1)
    """
    import pandas as pd

    table = pd.DataFrame(walk_record()["numbers"][section])
    for name, value in key.items():
        table = table[table[name] == value].drop(columns=name)
    return table.reset_index(drop=True)
