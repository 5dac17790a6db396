"""Suzurikawa et al. 2022, Table 1: the fits to shuffled tables, as a record.

Eighteen shuffled tables and the table itself, each fitted with both side signs, take longer than a
page may. The record ``scooter_table1_controls`` holds cost and misfit of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

from mobility_imu.executors import run_all
from mobility_imu.reproduction.scooter.table1_fit import shuffle_controls
from mobility_imu.reproduction.scooter.table1_model import published_table, table_checksum

if TYPE_CHECKING:
    import pandas as pd

SHUFFLED = 6
"""Shuffled tables of each kind."""
COLUMNS = ("cost", "prior_cost", "single_rms_deg", "dual_rms_deg")


def shuffle_record(executor: Executor | None = None) -> dict[str, Any]:
    """Numbers of the record ``scooter_table1_controls``.

    Parameters
    ----------
    executor : anything with ``submit``; None computes here

    Returns
    -------
    dict
        ``numbers`` with ``count`` (shuffled tables of each kind), ``table`` (as printed, rows,
        columns, both) and one list each of ``cost``, ``prior_cost``, ``single_rms_deg`` and
        ``dual_rms_deg``, in the order of ``table``; ``inputs``, the checksum of Table 1
    """
    (controls,) = run_all(shuffle_controls_of_the_paper, [(SHUFFLED,)], executor)
    return {
        "numbers": {
            "count": SHUFFLED,
            "table": controls["table"].tolist(),
            **{name: [round(float(v), 4) for v in controls[name]] for name in COLUMNS},
        },
        "inputs": table_checksum(),
    }


def shuffle_controls_of_the_paper(count: int) -> pd.DataFrame:
    """Fit the full chain to the paper's table and to shuffled ones.

    Parameters
    ----------
    count : shuffled tables of each kind

    Returns
    -------
    DataFrame, see :func:`mobility_imu.reproduction.scooter.table1_fit.shuffle_controls`
    """
    return shuffle_controls(published_table(), count=count)


def recorded_controls(numbers: Mapping[str, Any]) -> pd.DataFrame:
    """Table of the record, one row per fitted table.

    Parameters
    ----------
    numbers : what ``recorded.numbers("scooter_table1_controls")`` returns

    Returns
    -------
    DataFrame with ``table``, ``cost``, ``prior_cost``, ``single_rms_deg``, ``dual_rms_deg``
    """
    import pandas as pd

    return pd.DataFrame({name: numbers[name] for name in ("table", *COLUMNS)})
