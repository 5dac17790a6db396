"""Suzurikawa et al. 2022, Table 1: what besides geometry could have made these 100 numbers.

Nested models, each with the parameters of those before it: geometry alone; the lever's IMU turned
about its z (yaw); both IMUs tilted (mounting); each row's ground not quite as stated (slopes);
reading noise of the reference angles (noise). Every parameter has a prior of zero mean, fixed
before the fit. With 18 parameters a small misfit alone says little; so every fit can be asked what
it does to shuffled tables and to the half of the table that it has not seen.

Single and dual cells come from the same readings of the lever's IMU, and the cells of one row from
one slope. The fit takes all cells as independent: its standard deviations are too small, not by
more than a factor of two if pairs and quadruples of cells were one.

All angles of this module's tables are in degrees, as printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.scooter.table1_model import (
    DUAL,
    FLOOR_DEG,
    MODELS,
    NOISE,
    OTHER_MODELS,
    PARAMETERS,
    PRIOR_SD_DEG,
    SINGLE,
    TableCost,
    cell_sd,
    pick,
    places,
)
from mobility_imu.results import Result

if TYPE_CHECKING:
    import pandas as pd

Shuffle = Literal["rows", "columns", "both"]
SHUFFLES: tuple[Shuffle, ...] = ("rows", "columns", "both")

IDENTIFIED_SHARE = float(np.sqrt(0.5))
"""Posterior over prior sd below which the table says more about a parameter than the prior does."""
STRONG_CORRELATION = 0.8


@dataclass(frozen=True, eq=False, repr=False)
class TableFit(Result):
    """A model fitted to a table (maximum a posteriori).

    Parameters
    ----------
    names : free parameters
    left_row_ax_sign : which side of "left side slope" is up, see
        :func:`mobility_imu.reproduction.scooter.static_table`
    values_deg, sd_deg : (p,) arrays, deg, the best values and their posterior sd (Gauss-Newton)
    correlation : (p, p) array, posterior
    cost : squared residuals over their variances, data and priors together
    prior_cost : of that, the priors
    table_deg : (5, 5, 4) array, deg, what the model predicts: row, column, quantity
    converged : whether the search ended at an optimum, not at its limit of evaluations
    """

    names: tuple[str, ...]
    left_row_ax_sign: int
    values_deg: FloatArray
    sd_deg: FloatArray
    correlation: FloatArray
    cost: float
    prior_cost: float
    table_deg: FloatArray
    converged: bool = True

    def value_deg(self, name: str) -> float:
        """Value of one parameter, zero if it was not free.

        Parameters
        ----------
        name : of a parameter

        Returns
        -------
        float, deg
        """
        return float(self.values_deg[self.names.index(name)]) if name in self.names else 0.0

    def parameters(self) -> pd.DataFrame:
        """Value, posterior sd, prior sd and whether the table identifies it, one row per name."""
        import pandas as pd

        prior = np.array([PRIOR_SD_DEG[name] for name in self.names])
        strongest = np.abs(self.correlation - np.eye(len(self.names)))
        tied = strongest.argmax(axis=1) if self.names else np.zeros(0, int)
        return pd.DataFrame(
            {
                "value_deg": self.values_deg,
                "sd_deg": self.sd_deg,
                "prior_sd_deg": prior,
                "sd_over_prior": self.sd_deg / prior,
                "most_correlated_with": [self.names[k] for k in tied],
                "correlation": self.correlation[np.arange(len(tied)), tied],
                "identified": (self.sd_deg < IDENTIFIED_SHARE * prior)
                & (strongest.max(axis=1, initial=0) < STRONG_CORRELATION),
            },
            index=pd.Index(self.names, name="parameter"),
        )


class FitQuality(NamedTuple):
    """How near a predicted table is to a printed one.

    Parameters
    ----------
    single_rms_deg, dual_rms_deg : deg, root mean square of the MAE's differences
    single_cells, dual_cells : cells of 25 with an MAE within 1 deg
    """

    single_rms_deg: float
    dual_rms_deg: float
    single_cells: int
    dual_cells: int


def fit_table(
    table_deg: FloatArray,
    names: Sequence[str],
    *,
    left_row_ax_sign: int = -1,
    starts: int = 6,
    seed: int = 0,
    first_deg: FloatArray | None = None,
    use: slice = slice(0, 4),
    floor_deg: float = FLOOR_DEG,
    spread_deg: FloatArray | None = None,
) -> list[TableFit]:
    """Fit a model from several starting points.

    Parameters
    ----------
    table_deg : (5, 5, 4) array, deg, as ``table1_model.published_table`` gives it
    names : free parameters, the others stay zero
    left_row_ax_sign : -1 or +1
    starts : number of random starting points, drawn from half the priors, besides the one next to
        the stated values; 0 with ``first_deg`` starts there only
    seed : of the starting points
    first_deg : (29,) array, deg, one more starting point
    use : quantities to fit: all, ``SINGLE`` or ``DUAL``
    floor_deg : deg, smallest standard deviation of a cell
    spread_deg : (5, 5, 4) array, deg, sd of each cell; None is that of the table and ``floor_deg``

    Returns
    -------
    list of TableFit, the best first; later ones are other optima, if their cost differs
    """
    cost = TableCost(
        table_deg,
        tuple(names),
        left_row_ax_sign,
        use,
        cell_sd(table_deg, floor_deg) if spread_deg is None else spread_deg,
    )
    places(names)  # every name is known
    if not names:
        return [_described(cost, np.zeros(0))]
    found = [fit_from(cost, guess) for guess in _guesses(cost, starts, seed, first_deg)]
    return sorted(found, key=lambda fit: fit.cost)


def _guesses(
    cost: TableCost, starts: int, seed: int, first_deg: FloatArray | None
) -> list[FloatArray]:
    """Where to start: at ``first_deg``, next to the stated values, and at random."""
    prior, is_noise = cost.prior_sd_deg, cost.is_noise
    rng = np.random.default_rng(seed)
    guesses = [0.5 * prior * rng.standard_normal(len(prior)) for _ in range(starts)]
    # Not at zero itself: the mean of |e| has a kink there, and the cost no slope by the noise.
    if starts or first_deg is None:
        guesses.insert(0, np.where(is_noise, 0.5, 0.02) * prior)
    if first_deg is not None:
        first = pick(np.asarray(first_deg, float), *cost.names)
        guesses.insert(0, np.where(is_noise & (first == 0), 0.5 * prior, first))
    return guesses


def fit_from(cost: TableCost, guess_deg: FloatArray) -> TableFit:
    """Go from one point, (p,), deg, to the nearest optimum; noise is given as its size.

    Parameters
    ----------
    cost : TableCost
    guess_deg : (p,) array, deg

    Returns
    -------
    TableFit
    """
    from scipy import optimize

    solved = optimize.least_squares(
        cost.residuals, guess_deg, cost.derivative, method="trf", max_nfev=60, ftol=1e-7, xtol=1e-6
    )
    values = np.where(cost.is_noise, np.abs(solved.x), solved.x)
    return _described(cost, values, converged=bool(solved.success))


def _described(cost: TableCost, part_deg: FloatArray, *, converged: bool = True) -> TableFit:
    """A fit with its posterior by Gauss and Newton, from its values."""
    misfit = cost.residuals(part_deg)
    jacobian = cost.derivative(part_deg) if cost.names else np.zeros((len(misfit), 0))
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    sd = np.sqrt(np.diag(covariance))
    return TableFit(
        names=cost.names,
        left_row_ax_sign=cost.left_row_ax_sign,
        values_deg=part_deg,
        sd_deg=sd,
        correlation=covariance / np.outer(sd, sd),
        cost=float(misfit @ misfit),
        prior_cost=float(((part_deg / cost.prior_sd_deg) ** 2).sum()),
        table_deg=cost.predict(part_deg),
        converged=converged,
    )


def fit_models(
    table_deg: FloatArray, *, left_row_ax_sign: int = -1, starts: int = 6, seed: int = 0
) -> dict[str, TableFit]:
    """Fit the chain of ``MODELS``, each also from where the one before it ended.

    Absolute errors hardly tell the sign of a small cause: every value within 2 sd of zero is tried
    with the other sign as well.

    Parameters
    ----------
    table_deg, left_row_ax_sign, starts, seed : as in :func:`fit_table`

    Returns
    -------
    dict of TableFit, the best of each model; the costs never grow along the chain
    """
    best: dict[str, TableFit] = {}
    values = np.zeros(len(PARAMETERS))
    for name, names in MODELS.items():
        fit = fit_table(
            table_deg,
            names,
            left_row_ax_sign=left_row_ax_sign,
            starts=starts,
            seed=seed,
            first_deg=values,
        )[0]
        best[name] = fit = _other_side(table_deg, fit)
        values = values.copy()
        values[places(fit.names)] = fit.values_deg
    return best


def _other_side(table_deg: FloatArray, fit: TableFit) -> TableFit:
    """Fit again from each value that may have the other sign, and keep what is better."""
    best = fit
    for place, name in enumerate(fit.names):
        if name in NOISE or abs(fit.values_deg[place]) > 2 * fit.sd_deg[place]:
            continue
        first = np.zeros(len(PARAMETERS))
        first[places(fit.names)] = fit.values_deg
        first[places([name])] *= -1
        again = fit_table(
            table_deg,
            fit.names,
            left_row_ax_sign=fit.left_row_ax_sign,
            starts=0,
            first_deg=first,
        )[0]
        best = min(best, again, key=lambda found: found.cost)
    return best


def quality(predicted_deg: FloatArray, table_deg: FloatArray) -> FitQuality:
    """Compare the MAE of two tables, (5, 5, 4), deg.

    Parameters
    ----------
    predicted_deg, table_deg : (5, 5, 4) arrays, deg

    Returns
    -------
    FitQuality
    """
    gap = predicted_deg - table_deg
    single, dual = gap[..., 0], gap[..., 2]
    return FitQuality(
        float(np.sqrt((single**2).mean())),
        float(np.sqrt((dual**2).mean())),
        int((np.abs(single) <= 1 + 1e-9).sum()),
        int((np.abs(dual) <= 1 + 1e-9).sum()),
    )


def shuffled_tables(
    table_deg: FloatArray, what: Shuffle, *, count: int, seed: int = 0
) -> list[FloatArray]:
    """The same numbers, single and dual together, under wrong headings; no two alike.

    Rows: never only left and right exchanged, which the other side sign could explain. Columns:
    always at least one of steering (a, b) exchanged with one of throttle.

    Parameters
    ----------
    table_deg : (5, 5, 4) array
    what : "rows", "columns" or "both"
    count : number of tables
    seed : int

    Returns
    -------
    list of (5, 5, 4) arrays
    """
    rng = np.random.default_rng([seed, 71])
    orders = np.array(list(permutations(range(5))))
    rows = orders[(orders[:, :3] != [0, 1, 2]).any(axis=1)]
    columns = orders[orders[:, :2].max(axis=1) > 1]
    rows, columns = rng.permutation(rows)[:count], rng.permutation(columns)[:count]
    same = np.arange(5)
    return [
        table_deg[row if what != "columns" else same][:, column if what != "rows" else same]
        for row, column in zip(rows, columns, strict=True)
    ]


def model_table(table_deg: FloatArray, *, starts: int = 6, seed: int = 0) -> pd.DataFrame:
    """Fit every model of the chain with both side signs, and those beside the chain with -1.

    Parameters
    ----------
    table_deg, starts, seed : as in :func:`fit_table`

    Returns
    -------
    DataFrame
        Index model and left_row_ax_sign; ``free``, ``cost``, ``prior_cost``, the four numbers of
        :class:`FitQuality` and the :class:`TableFit` itself in ``fit``.
    """
    import pandas as pd

    fits = [
        (name, fit)
        for sign in (-1, 1)
        for name, fit in fit_models(
            table_deg, left_row_ax_sign=sign, starts=starts, seed=seed
        ).items()
    ] + [
        (name, fit_table(table_deg, names, starts=starts, seed=seed)[0])
        for name, names in OTHER_MODELS.items()
    ]
    table = pd.DataFrame(
        [
            {
                "model": name,
                "left_row_ax_sign": fit.left_row_ax_sign,
                "free": len(fit.names),
                "cost": fit.cost,
                "prior_cost": fit.prior_cost,
                **quality(fit.table_deg, table_deg)._asdict(),
                "fit": fit,
            }
            for name, fit in fits
        ]
    )
    return table.set_index(["model", "left_row_ax_sign"])


def shuffle_controls(
    table_deg: FloatArray, *, count: int, starts: int = 2, seed: int = 1
) -> pd.DataFrame:
    """Fit the full chain to the table as printed and to shuffled ones, all in the same way.

    Parameters
    ----------
    table_deg : (5, 5, 4) array, deg
    count : shuffled tables of each kind
    starts, seed : as in :func:`fit_table`, with both side signs

    Returns
    -------
    DataFrame with ``table`` (as printed, rows, columns, both), ``cost``, ``prior_cost``,
    ``single_rms_deg``, ``dual_rms_deg``
    """
    import pandas as pd

    tables = [("as printed", table_deg)]
    for what in SHUFFLES:
        tables += [(what, t) for t in shuffled_tables(table_deg, what, count=count, seed=seed)]
    rows = []
    for name, shuffled in tables:
        fit = min(
            (
                fit_table(
                    shuffled, MODELS["+ noise"], left_row_ax_sign=sign, starts=starts, seed=seed
                )[0]
                for sign in (-1, 1)
            ),
            key=lambda found: found.cost,
        )
        near = quality(fit.table_deg, shuffled)
        rows.append((name, fit.cost, fit.prior_cost, near.single_rms_deg, near.dual_rms_deg))
    return pd.DataFrame(
        rows, columns=["table", "cost", "prior_cost", "single_rms_deg", "dual_rms_deg"]
    )


def half_controls(table_deg: FloatArray, *, starts: int = 8, seed: int = 4) -> pd.DataFrame:
    """Fit one half of the table, predict the other: rms of the MAE's differences in both.

    Parameters
    ----------
    table_deg : (5, 5, 4) array, deg
    starts, seed : as in :func:`fit_table`

    Returns
    -------
    DataFrame
        One row per fitted half and model: ``seen_rms_deg``, ``unseen_rms_deg``, and the
        :class:`TableFit` in ``fit``.
    """
    import pandas as pd

    models = {
        "geometry": (),
        "yaw and noise": OTHER_MODELS["yaw and noise"],
        "mounting and noise": OTHER_MODELS["mounting and noise"],
        "+ noise": MODELS["+ noise"],
    }
    rows = []
    for half, use in (("single", SINGLE), ("dual", DUAL)):
        for name, names in models.items():
            fit = fit_table(table_deg, names, starts=starts, seed=seed, use=use)[0]
            near = quality(fit.table_deg, table_deg)
            pair = (near.single_rms_deg, near.dual_rms_deg)
            seen, unseen = pair if half == "single" else pair[::-1]
            rows.append((half, name, seen, unseen, fit))
    return pd.DataFrame(
        rows, columns=["fitted", "model", "seen_rms_deg", "unseen_rms_deg", "fit"]
    ).set_index(["fitted", "model"])
