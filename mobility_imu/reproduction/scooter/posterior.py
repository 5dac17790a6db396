"""Suzurikawa et al. 2022: which scooters a static table allows.

The posterior of the nested model with 18 faults ("+ noise") under its stated priors, given a table:
its density is exp(-cost / 2) with the cost of ``table1_model.TableCost``, the same that the fits
make small. emcee's ensembles draw from it.

Absolute errors hardly tell the sign of a small fault, so the posterior can have several modes, and
an ensemble whose walkers stay each in its own mode gives them wrong weights. Two things prevent
that. Every run starts with draws from the prior, and the table's weight then grows step by step
from nothing to one, with resampling, so that walkers leave the optima that do not count. And three
tenths of the later steps propose a jump: an independent draw from a mixture of normal distributions
around the optima next to the walkers. The Metropolis rule weighs the jumps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from mobility_imu.errors import needs
from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.scooter.table1_fit import (
    IDENTIFIED_SHARE,
    STRONG_CORRELATION,
    TableFit,
    fit_from,
)
from mobility_imu.reproduction.scooter.table1_model import MODELS, TableCost

NAMES = MODELS["+ noise"]
"""The 18 faults that are drawn."""
JUMPS = 0.3
"""Fraction of the steps that propose a jump between modes."""
MODE_COST = 60.0
"""Optima whose cost is larger than the best one's by more than this are left out."""
MOST_MODES = 30
SAME_MODE_DEG = 0.02
WIDER = 1.15
"""Factor on the widths of the mixture, whose tails should not be thinner than the posterior's."""
EVEN = 0.1
"""Part of the mixture that all modes share evenly, so that a walker can leave a poor one."""


@dataclass(frozen=True)
class Sampling:
    """How long to draw.

    Parameters
    ----------
    runs : independent ensembles, each from starts of its own
    walkers : of an ensemble
    steps : of each walker that are kept
    burn_in : steps before, which are thrown away
    particles : draws from the prior that a run starts from
    stage_steps : steps of each particle after each increase of the table's weight
    mode_starts : particles from which the search for modes starts, and as many draws from the prior
    """

    runs: int = 4
    walkers: int = 64
    steps: int = 2000
    burn_in: int = 500
    particles: int = 256
    stage_steps: int = 10
    mode_starts: int = 30


class Modes(NamedTuple):
    """Normal distributions around the optima of a posterior.

    Noise is independent of the rest in them, and of either sign.

    Parameters
    ----------
    centre_deg : (k, p) array, deg
    factor_deg : (k, p, p) array, deg, lower Cholesky factors of the widened covariances
    weight : (k,) array, 1, of each; sums to 1
    cost : (k,) array, of the optimum
    is_noise : (p,) bool array
    """

    centre_deg: FloatArray
    factor_deg: FloatArray
    weight: FloatArray
    cost: FloatArray
    is_noise: NDArray[np.bool_]

    def draw(self, count: int, random: np.random.RandomState) -> FloatArray:
        """Draw from the mixture, (count, p), deg.

        Parameters
        ----------
        count : how many
        random : generator

        Returns
        -------
        (count, p) array, deg
        """
        which = random.choice(len(self.weight), size=count, p=self.weight)
        normal = random.standard_normal((count, len(self.is_noise)))
        there = self.centre_deg[which] + np.einsum("nij,nj->ni", self.factor_deg[which], normal)
        signs = random.choice([-1.0, 1.0], size=there.shape)
        return np.asarray(np.where(self.is_noise, signs * there, there))

    def log_density(self, values_deg: FloatArray) -> FloatArray:
        """Logarithm of the mixture's density but for a constant, (n,), at (n, p) values.

        Parameters
        ----------
        values_deg : (n, p) array, deg

        Returns
        -------
        (n,) array
        """
        rest = ~self.is_noise
        size = np.diagonal(self.factor_deg, axis1=1, axis2=2)
        away = values_deg[:, None, rest] - self.centre_deg[:, rest]
        inverse = np.linalg.inv(self.factor_deg[:, rest][:, :, rest])
        each = -0.5 * (np.einsum("kij,nkj->nki", inverse, away) ** 2).sum(axis=-1)
        for k in np.flatnonzero(self.is_noise):
            at, centre, sd = np.abs(values_deg[:, k, None]), self.centre_deg[:, k], size[:, k]
            each += np.logaddexp(-0.5 * ((at - centre) / sd) ** 2, -0.5 * ((at + centre) / sd) ** 2)
        return np.asarray(special.logsumexp(each + np.log(self.weight / size.prod(axis=1)), axis=1))


class Draws(NamedTuple):
    """Draws from a posterior.

    Parameters
    ----------
    names : of the p parameters
    values_deg : (run, step, walker, p) array, deg; noise as its size
    accepted : (run,) array, 1, fraction of the proposals that were taken
    modes : number of modes that each run jumped between
    """

    names: tuple[str, ...]
    values_deg: FloatArray
    accepted: FloatArray
    modes: tuple[int, ...]

    @property
    def pooled_deg(self) -> FloatArray:
        """All draws of all runs, (n, p), deg."""
        return self.values_deg.reshape(-1, len(self.names))

    def thinned_deg(self, count: int) -> FloatArray:
        """Draws far apart from one another, (count, p), deg, evenly over runs and steps.

        Parameters
        ----------
        count : how many

        Returns
        -------
        (count, p) array, deg
        """
        runs, steps, walkers, _ = self.values_deg.shape
        k = np.arange(count)
        rounds = max(1, -(-count // runs))
        step = ((k // runs + 1) * steps // rounds) - 1
        return np.asarray(self.values_deg[k % runs, step, (7 * k) % walkers])


def anneal(cost: TableCost, sampling: Sampling, random: np.random.RandomState) -> FloatArray:
    """Bring draws from the prior to the posterior, the table's weight growing from 0 to 1.

    Each increase halves the effective number of the particles; they are then resampled and moved.

    Parameters
    ----------
    cost : TableCost
    sampling : Sampling
    random : RandomState

    Returns
    -------
    (particles, p) array, deg
    """
    emcee = needs("emcee")

    count, size = sampling.particles, len(cost.names)
    here = cost.prior_sd_deg * random.standard_normal((count, size))
    weight = 0.0
    while weight < 1:
        fit = cost.log_density(here) - log_prior(cost, here)
        step = _next_step(fit, 1 - weight)
        weight = min(1.0, weight + step)
        share = special.softmax(step * fit)
        # Systematic resampling: one random number for all.
        at = (np.arange(count) + random.random_sample()) / count
        here = here[np.minimum(np.searchsorted(np.cumsum(share), at), count - 1)]

        def tempered(values: FloatArray, weight: float = weight) -> FloatArray:
            prior = log_prior(cost, values)
            return weight * (cost.log_density(values) - prior) + prior

        sampler = emcee.EnsembleSampler(
            count,
            size,
            tempered,
            vectorize=True,
            moves=[(emcee.moves.DEMove(), 0.5), (emcee.moves.StretchMove(), 0.5)],
        )
        state = emcee.State(here, random_state=random.get_state())
        last = sampler.run_mcmc(state, sampling.stage_steps, skip_initial_state_check=True)
        here = last.coords
        random.set_state(last.random_state)
    return here


def log_prior(cost: TableCost, values_deg: FloatArray) -> FloatArray:
    """Logarithm of the prior's density but for a constant, (n,), at (n, p) values.

    Parameters
    ----------
    cost : TableCost
    values_deg : (n, p) array, deg

    Returns
    -------
    (n,) array
    """
    return np.asarray(-0.5 * ((values_deg / cost.prior_sd_deg) ** 2).sum(axis=-1))


def _next_step(fit: FloatArray, largest: float) -> float:
    """Increase of the weight that halves the effective number of particles."""

    def enough(step: float) -> bool:
        share = special.softmax(step * fit)
        return bool(1 / (share**2).sum() >= len(fit) / 2)

    if enough(largest):
        return largest
    low, high = 0.0, largest
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if enough(middle) else (low, middle)
    return low


def find_modes(cost: TableCost, starts_deg: FloatArray) -> Modes:
    """Go from some points to the nearest optima and describe each by a normal distribution.

    Parameters
    ----------
    cost : TableCost
    starts_deg : (n, p) array, deg

    Returns
    -------
    Modes, the best first
    """
    fits = sorted((fit_from(cost, start) for start in starts_deg), key=lambda fit: fit.cost)
    kept: list[TableFit] = []
    for fit in fits:
        near = [np.abs(fit.values_deg - other.values_deg).max() < SAME_MODE_DEG for other in kept]
        if fit.cost <= fits[0].cost + MODE_COST and not any(near):
            kept.append(fit)
    best = kept[:MOST_MODES]
    costs = np.array([fit.cost for fit in best])
    factors = np.array([WIDER * _factor(fit, cost.is_noise) for fit in best])
    log_volume = np.log(np.diagonal(factors, axis1=1, axis2=2)).sum(axis=1)
    weight = (1 - EVEN) * special.softmax(log_volume - costs / 2) + EVEN / len(best)
    return Modes(np.array([fit.values_deg for fit in best]), factors, weight, costs, cost.is_noise)


def _factor(fit: TableFit, is_noise: NDArray[np.bool_]) -> FloatArray:
    """Cholesky factor of a fit's covariance, without the correlations of the noise."""
    tied = fit.correlation * np.outer(fit.sd_deg, fit.sd_deg)
    apart = is_noise[:, None] | is_noise
    return np.linalg.cholesky(np.where(apart, np.diag(fit.sd_deg**2), tied))


def draw_posterior(cost: TableCost, sampling: Sampling, *, seed: Sequence[int]) -> Draws:
    """Draw from the posterior of a table's faults.

    Parameters
    ----------
    cost : TableCost
    sampling : Sampling
    seed : of everything random; each run adds its number

    Returns
    -------
    Draws
    """
    return join_runs(cost, [draw_run(cost, sampling, [*seed, k]) for k in range(sampling.runs)])


class Run(NamedTuple):
    """One ensemble: values (step, walker, p) in deg, fraction taken, number of modes."""

    values_deg: FloatArray
    accepted: float
    modes: int


def draw_run(cost: TableCost, sampling: Sampling, seed: Sequence[int]) -> Run:
    """Draw one ensemble, its walkers started all over the prior.

    Parameters
    ----------
    cost : TableCost
    sampling : Sampling
    seed : whole numbers

    Returns
    -------
    Run
    """
    emcee = needs("emcee")

    random = np.random.RandomState(np.random.SeedSequence(list(seed)).generate_state(8))
    particles = anneal(cost, sampling, random)
    afresh = cost.prior_sd_deg * random.standard_normal((sampling.mode_starts, len(cost.names)))
    modes = find_modes(cost, np.concatenate([particles[: sampling.mode_starts], afresh]))
    start = particles[random.permutation(len(particles))[: sampling.walkers]]

    def jump(here: FloatArray, random: np.random.RandomState) -> tuple[FloatArray, FloatArray]:
        there = modes.draw(len(here), random)
        return there, modes.log_density(here) - modes.log_density(there)

    sampler = emcee.EnsembleSampler(
        sampling.walkers,
        len(cost.names),
        cost.log_density,
        vectorize=True,
        moves=[
            (emcee.moves.DEMove(), 1 - JUMPS),
            (emcee.moves.MHMove(jump, ndim=len(cost.names)), JUMPS),
        ],
    )
    state = emcee.State(start, random_state=random.get_state())
    sampler.run_mcmc(state, sampling.burn_in + sampling.steps, skip_initial_state_check=True)
    values = sampler.get_chain(discard=sampling.burn_in)
    return Run(values, float(sampler.acceptance_fraction.mean()), len(modes.cost))


def join_runs(cost: TableCost, runs: Sequence[Run]) -> Draws:
    """Put the runs of one posterior together.

    Parameters
    ----------
    cost : TableCost
    runs : of one posterior

    Returns
    -------
    Draws
    """
    values = np.stack([run.values_deg for run in runs])
    return Draws(
        cost.names,
        np.where(cost.is_noise, np.abs(values), values),
        np.array([run.accepted for run in runs]),
        tuple(run.modes for run in runs),
    )


class Diagnosis(NamedTuple):
    """Whether runs agree and how much they are worth, one value per parameter.

    Parameters
    ----------
    rhat_runs : (p,) array, 1, rank-normalised split R-hat with halves of runs as chains
    rhat_walkers : (p,) array, 1, the same with every walker as a chain: larger if walkers stay in
        different modes
    effective : (p,) array, effective number of draws, all runs together
    """

    rhat_runs: FloatArray
    rhat_walkers: FloatArray
    effective: FloatArray


def diagnose(draws: Draws, *, thin: int = 10) -> Diagnosis:
    """Check convergence.

    Parameters
    ----------
    draws : Draws
    thin : every how many steps count for R-hat

    Returns
    -------
    Diagnosis

    Notes
    -----
    R-hat as in Vehtari et al. 2021: the larger of that of the normal scores of the ranks and that
    of their distances from the median. The effective number is the number of draws over emcee's
    integrated autocorrelation time.
    """
    emcee = needs("emcee")

    runs, steps, walkers, count = draws.values_deg.shape
    few = draws.values_deg[:, : steps // (2 * thin) * 2 * thin : thin]
    halves = few.reshape(2 * runs, -1, count)
    each = np.swapaxes(few, 1, 2).reshape(2 * runs * walkers, -1, count)
    effective = np.zeros(count)
    for run in draws.values_deg:
        with np.errstate(invalid="ignore"):  # a walker that never moved: worth nothing
            time = emcee.autocorr.integrated_time(run, tol=0, has_walkers=True)
        time = np.where(np.isfinite(time), np.maximum(time, 1.0), np.inf)
        effective += steps * walkers / time
    return Diagnosis(split_rhat(halves), split_rhat(each), effective)


def split_rhat(chains: FloatArray) -> FloatArray:
    """Rank-normalised R-hat, (p,), of chains (chain, n, p) that are already split.

    Parameters
    ----------
    chains : (chain, n, p) array

    Returns
    -------
    (p,) array; 1 if all chains agree

    Examples
    --------
    >>> import numpy as np
    >>> chains = np.random.default_rng(0).normal(size=(4, 500, 1))
    >>> bool(split_rhat(chains)[0] < 1.01)
    True
    >>> chains[0] += 1
    >>> bool(split_rhat(chains)[0] > 1.05)
    True
    """
    distance = np.abs(chains - np.median(chains, axis=(0, 1)))
    return np.maximum(_rhat(_normal_scores(chains)), _rhat(_normal_scores(distance)))


def _normal_scores(chains: FloatArray) -> FloatArray:
    flat = chains.reshape(-1, chains.shape[-1])
    ranks = stats.rankdata(flat, axis=0)
    return np.asarray(special.ndtri((ranks - 0.375) / (len(flat) + 0.25)).reshape(chains.shape))


def _rhat(chains: FloatArray) -> FloatArray:
    length = chains.shape[1]
    within = chains.var(axis=1, ddof=1).mean(axis=0)
    between = chains.mean(axis=1).var(axis=0, ddof=1)
    return np.asarray(np.sqrt((length - 1) / length + between / within))


def identified(draws: Draws, prior_sd_deg: FloatArray) -> NDArray[np.bool_]:
    """Which parameters a table pins down, (p,), by the two rules of the fits.

    Parameters
    ----------
    draws : Draws
    prior_sd_deg : (p,) array, deg

    Returns
    -------
    (p,) bool array: the posterior's sd is below ``table1_fit.IDENTIFIED_SHARE`` of the prior's, and
    no correlation with another parameter is as strong as ``STRONG_CORRELATION``
    """
    pooled = draws.pooled_deg
    strongest = np.abs(np.corrcoef(pooled.T) - np.eye(len(draws.names))).max(axis=1)
    narrow = pooled.std(axis=0) < IDENTIFIED_SHARE * prior_sd_deg
    return np.asarray(narrow & (strongest < STRONG_CORRELATION))
