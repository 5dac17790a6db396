"""The three studies of injected faults in one table.

Each device's study has its own record (``faults_scooter``, ``faults_wheelchair``,
``faults_walker``): a hundred faults of each kind, put into simulated recordings.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
        name); ``priced``, those with a stated cost, and of these ``within`` a factor of two of what
        they really cost
    """
    import pandas as pd

    one_of("device", device, DEVICES)
    rows = [_counts(row) for row in _summaries(device)]
    return pd.DataFrame(rows).set_index("kind")


def _summaries(device: str) -> list[dict[str, Any]]:
    found = numbers(f"faults_{device}")
    return list(found["summary" if device == "scooter" else "kinds"])


def _counts(row: dict[str, Any]) -> dict[str, Any]:
    refused = row.get(
        "refused", 0
    )  # the scooter's study counts them among what matters and is told
    told, right = row.get("told", row.get("found")), row.get("rightly", row.get("right"))
    return {
        "kind": row["kind"],
        "cases": row["cases"],
        "matter": row["matter"] + refused,
        "told": told + refused,
        "right": right + refused,
        "priced": row["priced"],
        "within": row["within_two"],
    }


def shares(counts: pd.DataFrame) -> pd.Series:
    """Percentages over all kinds.

    Parameters
    ----------
    counts : of :func:`fault_counts`

    Returns
    -------
    Series
        ``told`` and ``right`` of those that matter, ``within`` of those with a cost
    """
    import pandas as pd

    total = counts.sum()
    return pd.Series(
        {
            "told": 100 * total["told"] / total["matter"],
            "right": 100 * total["right"] / total["matter"],
            "within": 100 * total["within"] / total["priced"],
        }
    )
