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
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.scooter.static_table import (
    COLUMNS,
    ROWS,
    SLOPE_RAD,
    STEERING_POSITIONS_RAD,
    THROTTLE_POSITIONS_RAD,
)
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.geometry import (
    SUZUKI_ET4D,
    ScooterGeometry,
    body_specific_force,
    rotation_lever_to_body,
)

if TYPE_CHECKING:
    import pandas as pd

QUANTITIES = ("single_mae", "single_sd", "dual_mae", "dual_sd")
SINGLE, DUAL = slice(0, 2), slice(2, 4)
Shuffle = Literal["rows", "columns", "both"]
SHUFFLES: tuple[Shuffle, ...] = ("rows", "columns", "both")

# Fixed before the fit. Mounting: set by eye and tape. Slopes: CELL_TOLERANCE_REASON of the static
# test. Noise: backlash and reading of the wire sensors, half-normal.
PRIOR_SD_DEG = {
    "lever z": 2.0,
    "lever x": 2.0,
    "lever y": 2.0,
    "body x": 2.0,
    "body y": 2.0,
    "body z": 2.0,
    **{f"{angle} {row}": 1.0 for angle in ("pitch", "roll") for row in ROWS},
    "steering noise": 1.0,
    "throttle noise": 1.0,
    # Rivals: other causes of the same size. Biases as the tilt that they look like: 5 milli-g.
    "alpha": 1.0,
    "steering reference offset": 1.0,
    "throttle reference offset": 1.0,
    "steering reference at lock": 1.0,
    "throttle reference at end": 1.0,
    **{f"{imu} bias {axis}": 0.286 for imu in ("lever", "body") for axis in "xyz"},
}
PARAMETERS = tuple(PRIOR_SD_DEG)
"""Names of all free parameters, in the order of the vectors."""
_NOISE = PARAMETERS[16:18]
MODELS: dict[str, tuple[str, ...]] = {
    "geometry": (),
    "+ yaw": PARAMETERS[:1],
    "+ mounting": PARAMETERS[:6],
    "+ slopes": PARAMETERS[:16],
    "+ noise": PARAMETERS[:18],
}
"""The nested models and their free parameters."""
OTHER_MODELS: dict[str, tuple[str, ...]] = {
    "geometry and noise only": _NOISE,
    "yaw and noise": (*PARAMETERS[:1], *_NOISE),
    "yaw, side slopes, noise": (*PARAMETERS[:1], "roll left", "roll right", *_NOISE),
    "mounting and noise": (*PARAMETERS[:6], *_NOISE),
    "+ noise + rivals": PARAMETERS,
}
"""Models beside the chain. They show which of its steps matter, and whether its values survive.

The rivals are an error of alpha (one of beta is one of the lever IMU about x, exactly), offset and
range of the two reference angles, and both accelerometers' biases.
"""

# A cell is a mean of 4 or 7 positions: reading noise of 1 deg leaves 0.3 to 0.5 deg of chance in
# it. What grows with the error itself (positions and range of the dials) is taken as a share.
FLOOR_DEG = 0.5
SHARE_MAE, SHARE_SD = 0.08, 0.15

IDENTIFIED_SHARE = float(np.sqrt(0.5))
"""Posterior over prior sd below which the table says more about a parameter than the prior does."""
STRONG_CORRELATION = 0.8


@dataclass(frozen=True)
class TableFit:
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
    """

    names: tuple[str, ...]
    left_row_ax_sign: int
    values_deg: FloatArray
    sd_deg: FloatArray
    correlation: FloatArray
    cost: float
    prior_cost: float
    table_deg: FloatArray

    def value_deg(self, name: str) -> float:
        """Value of one parameter, zero if it was not free."""
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


def published_table() -> FloatArray:
    """Table 1 as printed, (5, 5, 4), deg: row, column, quantity."""
    from mobility_imu.reproduction.published import load_published

    cells = load_published("scooter_table1").set_index(["row", "column", "quantity"])["value"]
    return np.array([[[cells[r, c, q] for q in QUANTITIES] for c in COLUMNS] for r in ROWS])


def predict_table(
    values_deg: ArrayLike,
    *,
    left_row_ax_sign: int = -1,
    geometry: ScooterGeometry = SUZUKI_ET4D,
) -> FloatArray:
    """Expected Table 1 for given nuisances.

    Noise is handled in expectation: the mean of ``|e + n|`` with Gaussian n (folded normal), and
    the root of the expected squared SD. Where noise is all there is, that root is 11 % (4
    positions) or 6 % (7) above the expected SD; less than the 15 % and 0.5 deg that an SD may
    differ by.

    Parameters
    ----------
    values_deg : (..., 29) array, deg, in the order of :data:`PARAMETERS`; zeros are geometry alone
    left_row_ax_sign : -1 or +1
    geometry : ScooterGeometry

    Returns
    -------
    (..., 5, 5, 4) array, deg: row, column, quantity

    Raises
    ------
    InputError
        If the sign is not +1 or -1, or there are not 29 values.
    """
    if left_row_ax_sign not in (-1, 1):
        raise InputError(f"left_row_ax_sign = {left_row_ax_sign}: expected +1 or -1")
    values = np.asarray(values_deg, float)
    if values.shape[-1:] != (len(PARAMETERS),):
        raise InputError(f"values_deg: shape {values.shape}, expected {len(PARAMETERS)} values")
    lead = values.shape[:-1]
    values = values.reshape(-1, len(PARAMETERS))
    rad = np.deg2rad(values)
    # Parameters are stored z, x, y for the lever (yaw is the first step of the chain).
    lever_turn = _turn(rad[:, [1, 2, 0]])
    body_turn = _turn(rad[:, 3:6])
    side = left_row_ax_sign * SLOPE_RAD
    pitch = rad[:, 6:11] + [0.0, SLOPE_RAD, -SLOPE_RAD, 0.0, 0.0]
    roll = rad[:, 11:16] + [0.0, 0.0, 0.0, side, -side]
    force = body_specific_force(pitch, roll)
    level = body_specific_force(0.0, 0.0)
    bias = np.tan(rad[:, 23:29]) * level[2]
    felt = force @ body_turn + bias[:, None, 3:]  # a row times a rotation: its inverse
    # The true alpha is smaller than the believed one by "alpha": eq. 5 between two turns about x.
    shaft = _turn(-rad[:, 18, None] * [1.0, 0.0, 0.0])
    force = force @ shaft
    lever_turn = np.swapaxes(shaft, 1, 2) @ lever_turn

    table = np.empty((len(values), len(ROWS), len(COLUMNS), len(QUANTITIES)))
    for columns, which, steering, throttle in _conditions():
        rotation = rotation_lever_to_body(steering, throttle, geometry)
        lever = np.einsum("cpji,krj->krcpi", rotation, force) @ lever_turn[:, None, None]
        lever += bias[:, None, None, None, :3]
        truth = (steering, throttle)[which]
        reference_deg = values[:, 19 + which, None, None] + values[:, 21 + which, None, None] * (
            truth / truth.max()
        )
        for mode, body in ((SINGLE, level), (DUAL, felt[:, :, None, None])):
            angle = three_axis_angles(lever, body, geometry)[which]
            error_deg = np.rad2deg(angle - truth) - reference_deg[:, None]
            noise = np.abs(values[:, 16 + which])[:, None, None, None]
            table[:, :, columns, mode] = _expected_cell(error_deg, noise)
    return table.reshape(*lead, *table.shape[1:])


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
) -> list[TableFit]:
    """Fit a model from several starting points.

    Parameters
    ----------
    table_deg : (5, 5, 4) array, deg, as :func:`published_table`
    names : free parameters, the others stay zero
    left_row_ax_sign : -1 or +1
    starts : number of random starting points, drawn from half the priors, besides the one next to
        the stated values; 0 with ``first_deg`` starts there only
    seed : of the starting points
    first_deg : (29,) array, deg, one more starting point
    use : quantities to fit: all, ``SINGLE`` or ``DUAL``
    floor_deg : deg, smallest standard deviation of a cell

    Returns
    -------
    list of TableFit, the best first; later ones are other optima, if their cost differs
    """
    from scipy import optimize

    unknown = [name for name in names if name not in PRIOR_SD_DEG]
    if unknown:
        raise InputError(f"names: {unknown[0]!r} is not a parameter of Table 1's models")
    free = np.array([PARAMETERS.index(name) for name in names], int)
    prior = np.array([PRIOR_SD_DEG[name] for name in names])
    spread = np.maximum(floor_deg, table_deg * [SHARE_MAE, SHARE_SD, SHARE_MAE, SHARE_SD])

    def full(part: FloatArray) -> FloatArray:
        values = np.zeros((*part.shape[:-1], len(PARAMETERS)))
        values[..., free] = part
        return values

    def residuals(part: FloatArray) -> FloatArray:
        predicted = predict_table(full(part), left_row_ax_sign=left_row_ax_sign)
        misfit = ((predicted - table_deg) / spread)[..., use]
        return np.concatenate([misfit.reshape(*part.shape[:-1], -1), part / prior], axis=-1)

    def derivative(part: FloatArray) -> FloatArray:
        step = 1e-3 * np.eye(len(part))
        both = residuals(np.concatenate([part + step, part - step]))
        return (both[: len(part)] - both[len(part) :]).T / 2e-3

    rng = np.random.default_rng(seed)
    guesses = [0.5 * prior * rng.standard_normal(len(free)) for _ in range(starts)]
    # Not at zero itself: the mean of |e| has a kink there, and the cost no slope by the noise.
    is_noise = np.isin(free, (16, 17))
    if starts or first_deg is None:
        guesses.insert(0, np.where(is_noise, 0.5, 0.02) * prior)
    if first_deg is not None:
        first = np.asarray(first_deg, float)[free]
        guesses.insert(0, np.where(is_noise & (first == 0), 0.5 * prior, first))
    found = []
    for guess in guesses:
        if len(free):
            solved = optimize.least_squares(
                residuals, guess, derivative, method="trf", max_nfev=60, ftol=1e-7, xtol=1e-6
            )
            part = np.where(is_noise, np.abs(solved.x), solved.x)
        else:
            part = guess
        found.append(part)
        if not len(free):
            break
    fits = []
    for part in found:
        misfit = residuals(part)
        jacobian = derivative(part) if len(free) else np.zeros((len(misfit), 0))
        covariance = np.linalg.inv(jacobian.T @ jacobian)
        sd = np.sqrt(np.diag(covariance))
        fits.append(
            TableFit(
                names=tuple(names),
                left_row_ax_sign=left_row_ax_sign,
                values_deg=part,
                sd_deg=sd,
                correlation=covariance / np.outer(sd, sd),
                cost=float(misfit @ misfit),
                prior_cost=float(((part / prior) ** 2).sum()),
                table_deg=predict_table(full(part), left_row_ax_sign=left_row_ax_sign),
            )
        )
    return sorted(fits, key=lambda fit: fit.cost)


def fit_models(
    table_deg: FloatArray, *, left_row_ax_sign: int = -1, starts: int = 6, seed: int = 0
) -> dict[str, TableFit]:
    """Fit the chain of :data:`MODELS`, each also from where the one before it ended.

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
        values[[PARAMETERS.index(p) for p in fit.names]] = fit.values_deg
    return best


def _other_side(table_deg: FloatArray, fit: TableFit) -> TableFit:
    """Fit again from each value that may have the other sign, and keep what is better."""
    best = fit
    for place, name in enumerate(fit.names):
        if name in _NOISE or abs(fit.values_deg[place]) > 2 * fit.sd_deg[place]:
            continue
        first = np.zeros(len(PARAMETERS))
        first[[PARAMETERS.index(other) for other in fit.names]] = fit.values_deg
        first[PARAMETERS.index(name)] *= -1
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
    """Compare the MAE of two tables, (5, 5, 4), deg."""
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


def _conditions() -> list[tuple[slice, int, FloatArray, FloatArray]]:
    """Columns, which angle is judged (0 steering, 1 throttle), positions (column, place)."""
    wheel, lever = np.array(STEERING_POSITIONS_RAD), np.array(THROTTLE_POSITIONS_RAD)
    ends = np.array([0.0, wheel.max(), wheel.min()])
    shape = (2, len(wheel)), (3, len(lever))
    return [
        (slice(0, 2), 0, np.broadcast_to(wheel, shape[0]), _across(lever[[0, -1]], shape[0])),
        (slice(2, 5), 1, _across(ends, shape[1]), np.broadcast_to(lever, shape[1])),
    ]


def _across(values: FloatArray, shape: tuple[int, int]) -> FloatArray:
    return np.broadcast_to(values[:, None], shape)


def _expected_cell(error_deg: FloatArray, noise_deg: FloatArray) -> FloatArray:
    """Mean and SD (n - 1) of ``|error + noise|`` over the last axis, as (..., 2)."""
    from scipy.special import erf

    noise = np.maximum(noise_deg, 1e-9)
    ratio = error_deg / noise
    mean = noise * np.sqrt(2 / np.pi) * np.exp(-(ratio**2) / 2) + error_deg * erf(
        ratio / np.sqrt(2)
    )
    variance = np.maximum(error_deg**2 + noise**2 - mean**2, 0)
    spread = np.sqrt(mean.var(axis=-1, ddof=1) + variance.mean(axis=-1))
    return np.stack([mean.mean(axis=-1), spread], axis=-1)


def _turn(vectors_rad: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vectors_rad).as_matrix()
