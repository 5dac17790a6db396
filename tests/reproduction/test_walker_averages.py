"""Averages of the walker's tables: exact sums of what the tables give."""

from decimal import Decimal

import numpy as np

from mobility_imu.reproduction.walker.averages import HALF_UNIT, decimals, recomputed_averages
from mobility_imu.reproduction.walker.tables import POSES, runs


def test_every_average_is_the_mean_of_its_own_rows():
    averages = recomputed_averages()
    assert len(averages) == 60 and set(averages["table"]) == {2, 3, 4}
    for row in averages.itertuples():
        values = runs(row.table, row.column)
        mean = values.mean() if row.pose == "all" else values[POSES.index(row.pose)].mean()
        assert np.isclose(row.recomputed, mean, atol=1e-6)
        assert row.fits == (abs(row.published - mean) <= float(HALF_UNIT) + 1e-12)


def test_sums_are_exact():
    """A tie at half a unit is kept as one, which binary fractions would not."""
    averages = recomputed_averages()
    tie = averages[
        (averages["table"] == 2)
        & (averages["pose"] == "5")
        & (averages["column"] == "distance_error")
    ]
    assert tie["recomputed"].item() == 0.37845 and tie["published"].item() == 0.3785
    assert tie["fits"].item()
    assert sum(decimals(2)[f"5/{run}", "distance_error"] for run in range(1, 7)) == Decimal(
        "2.2707"
    )
