"""The three studies of injected faults in one table.

Each device's study has its own record (``faults_scooter``, ``faults_wheelchair``,
``faults_walker``): a hundred faults of each kind, put into simulated recordings. Some checks were
changed after earlier runs had been looked at; the records are of seeds that nobody had looked at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mobility_imu.data import reference_folder
from mobility_imu.frames import one_of
from mobility_imu.reproduction.recorded import numbers

if TYPE_CHECKING:
    import pandas as pd

DEVICES = ("scooter", "wheelchair", "walker")


def fault_counts(device: str) -> pd.DataFrame:
    """Faults of each kind that were put into a device's recordings, and what was told of them.

    Parameters
    ----------
    device : "scooter", "wheelchair" or "walker"

    Returns
    -------
    DataFrame by kind
        ``cases``; ``matter``: those that move the result by more than twice its stated standard
        deviation, or that nothing reads; of these ``told`` (at all) and ``right`` (by the right
        name); ``priced``, those with a stated cost, and of these ``within_two``, whose cost is
        right within a factor of two; ``unpriced``, told, with no cost recorded under a right name
    """
    import pandas as pd

    one_of("device", device, DEVICES)
    rows = [_with_refused(row) for row in _summaries(device)]
    return pd.DataFrame(rows).set_index("kind")


def _summaries(device: str) -> list[dict[str, Any]]:
    found = numbers(f"faults_{device}")
    return list(found["summary" if device == "scooter" else "kinds"])


def _with_refused(row: dict[str, Any]) -> dict[str, Any]:
    """Counts of a kind; a recording that is refused has a fault that matters, rightly told."""
    seen = ("matter", "told", "right")
    same = ("kind", "cases", "priced", "within_two", "unpriced")
    return {n: row[n] for n in same} | {n: row[n] + row["refused"] for n in seen}


def earlier_run() -> pd.DataFrame:
    """What the studies gave on the seeds of before, by device.

    Returns
    -------
    DataFrame by device
        ``first_seed``; the columns of :func:`fault_counts`, summed up over the kinds; ``clean``,
        recordings without a fault, and ``alarms``, those with an alarm
    """
    import pandas as pd

    return pd.read_csv(reference_folder() / "faults_earlier_run.csv", index_col="device")


def percentages(counts: pd.DataFrame) -> pd.Series:
    """Percentages over all kinds.

    Parameters
    ----------
    counts : of :func:`fault_counts`

    Returns
    -------
    Series
        ``told`` and ``right`` of those that matter, ``within_two`` of those with a cost
    """
    import pandas as pd

    total = counts.sum()
    return pd.Series(
        {
            "told": 100 * total["told"] / total["matter"],
            "right": 100 * total["right"] / total["matter"],
            "within_two": 100 * total["within_two"] / total["priced"],
        }
    )
