"""Tables as commands write them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mobility_imu.files import csv_bytes

if TYPE_CHECKING:
    import pandas as pd


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
