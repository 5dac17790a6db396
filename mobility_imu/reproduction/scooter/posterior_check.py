"""Suzurikawa et al. 2022: a check that the posterior of Table 1's faults means what it says.

Simulation-based calibration. Faults are drawn from the prior; the table that they give gets exactly
the scatter that the likelihood assumes (normal, the standard deviations of Table 1's cells, cells
independent); the sampler then gets this table as if it were the printed one. Over many tables, a
fault's true value must lie below a fraction u of the draws that is even between 0 and 1, and inside
the 90 % interval in 90 of 100 tables. A simulated cell may be negative; the likelihood allows it.
"""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from mobility_imu.executors import run_all
from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.scooter.posterior import (
    NAMES,
    Sampling,
    diagnose,
    draw_posterior,
)
from mobility_imu.reproduction.scooter.table1_model import (
    TableCost,
    cell_sd,
    published_table,
    table_checksum,
)

TABLES = 100
SHORTER = Sampling(runs=2, walkers=48, steps=600, burn_in=200, particles=192, mode_starts=12)
"""A shorter run for each of the many tables; its own convergence is kept, too."""
SEED = 2022


class TableCheck(NamedTuple):
    """What the posterior of one simulated table says of the true faults.

    Parameters
    ----------
    below : (p,) array, 1, fraction of the draws that lie below the true value
    rhat : largest R-hat between the runs over the p faults
    effective : smallest effective number of draws over the p faults
    """

    below: FloatArray
    rhat: float
    effective: float


def simulated_table(table: int) -> tuple[TableCost, FloatArray]:
    """A table drawn from the model, as something to fit, and its true faults, (p,), deg.

    Parameters
    ----------
    table : number of the table, its seed

    Returns
    -------
    cost : TableCost of the table
    true : (p,) array, deg
    """
    printed = published_table()
    model = TableCost(printed, NAMES)
    rng = np.random.default_rng([SEED, table])
    truth = model.prior_sd_deg * rng.standard_normal(len(NAMES))
    spread = cell_sd(printed)
    drawn = model.predict(truth) + spread * rng.standard_normal(spread.shape)
    truth = np.where(model.is_noise, np.abs(truth), truth)
    return TableCost(drawn, NAMES, spread_deg=spread), truth


def check_table(table: int, sampling: Sampling = SHORTER) -> TableCheck:
    """Draw the posterior of one simulated table and hold the true faults against it.

    Parameters
    ----------
    table : number of the table
    sampling : Sampling

    Returns
    -------
    TableCheck
    """
    cost, truth = simulated_table(table)
    draws = draw_posterior(cost, sampling, seed=[SEED, table, 1])
    found = diagnose(draws)
    below = (draws.pooled_deg < truth).mean(axis=0)
    return TableCheck(below, float(found.rhat_runs.max()), float(found.effective.min()))


def coverage(below: FloatArray, share: float = 0.9) -> FloatArray:
    """How often the central interval with this fraction of the draws holds the true value.

    Parameters
    ----------
    below : (table, p) array, 1, see :class:`TableCheck`
    share : 1, of the draws

    Returns
    -------
    (p,) array, number of tables
    """
    return np.asarray((np.abs(below - 0.5) < share / 2).sum(axis=0).astype(float))


def uniformity(below: FloatArray, bins: int = 10) -> FloatArray:
    """Probability of ranks at least as uneven as these if they are even, (p,); chi-square.

    Parameters
    ----------
    below : (table, p) array, 1, see :class:`TableCheck`
    bins : number of equal bins

    Returns
    -------
    (p,) array, 1
    """
    place = np.minimum((below * bins).astype(int), bins - 1)
    counts = np.array([(place == k).sum(axis=0) for k in range(bins)])
    return np.asarray(stats.chisquare(counts, axis=0).pvalue)


def all_even(p_values: FloatArray, level: float = 0.05) -> bool:
    """Whether none of several tests rejects, the level held for all together (Holm, Bonferroni).

    Parameters
    ----------
    p_values : one per test
    level : chance that even one of them rejects although all are even

    Returns
    -------
    bool

    Examples
    --------
    >>> all_even(np.array([0.02, 0.5, 0.9])), all_even(np.array([0.01, 0.5, 0.9]))
    (True, False)
    """
    return bool(np.min(p_values) >= level / len(p_values))


def recorded_check(executor: Executor | None = None) -> dict[str, Any]:
    """Calibrate the posterior on all simulated tables; see the record of this name.

    Parameters
    ----------
    executor : anything with ``submit``, which then gets one task per table; None computes here

    Returns
    -------
    dict with ``numbers``
    """
    found = run_all(check_table, [(table,) for table in range(TABLES)], executor)
    return {
        "numbers": {
            "names": list(NAMES),
            "below": [[round(float(u), 4) for u in one.below] for one in found],
            "rhat": [round(one.rhat, 4) for one in found],
            "effective": [round(one.effective) for one in found],
        },
        "inputs": table_checksum(),
    }
