"""The averages of Tables 2 to 4, computed exactly from the decimals that the tables give."""

from __future__ import annotations

from decimal import Decimal
from typing import TYPE_CHECKING

from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.walker.tables import POSES

if TYPE_CHECKING:
    import pandas as pd

HALF_UNIT = Decimal("0.00005")
"""Half of the last digit that the tables give."""
RUNS = range(1, 7)


def decimals(table: int) -> dict[tuple[str, str], Decimal]:
    """All numbers of a table as exact decimals, by row and column.

    Parameters
    ----------
    table : 2, 3 or 4

    Examples
    --------
    >>> decimals(2)["5/1", "distance_estimation"]
    Decimal('9.6525')
    """
    cells = load_published(f"walker_table{table}")
    return {
        (row, column): Decimal(text)
        for row, column, text in cells[["row", "column", "printed"]].to_numpy()
    }


def recomputed_averages() -> pd.DataFrame:
    """Averages of Tables 2 to 4 beside the exact means of their rows.

    Returns
    -------
    DataFrame, one row for each average: table, pose ("all" over all poses), column, published (m),
    recomputed (m, to six decimals), fits (whether rounding explains the difference)
    """
    import pandas as pd

    rows = []
    for table in (2, 3, 4):
        number = decimals(table)
        for column in dict.fromkeys(column for _, column in number):
            for pose in (*POSES, None):
                poses = POSES if pose is None else (pose,)
                values = [number[f"{p}/{run}", column] for p in poses for run in RUNS]
                mean = sum(values, Decimal(0)) / len(values)
                published = number["average" if pose is None else f"{pose}/average", column]
                rows.append(
                    {
                        "table": table,
                        "pose": "all" if pose is None else pose,
                        "column": column,
                        "published": float(published),
                        "recomputed": round(float(mean), 6),
                        "fits": abs(published - mean) <= HALF_UNIT,
                    }
                )
    return pd.DataFrame(rows)
