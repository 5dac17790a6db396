"""Least squares with the scatter of whole pieces; its coverage is tested with the check."""

import numpy as np
import pytest

from mobility_imu.wheelchair.fits import fit_by_pieces, pieces_of


def test_pieces_may_lack_samples_and_each_counts_once():
    """Doubled samples within pieces change neither what is found nor its covariance by pieces."""
    rng = np.random.default_rng(5)
    design = np.column_stack([rng.normal(0, 1, 600), np.ones(600)])
    target = design @ [2.0, 0.1] + rng.normal(0, 0.1, 600)
    piece = pieces_of(600, 1.0, 50.0)
    found, covariance = fit_by_pieces(design, target, piece)
    twice = np.repeat(np.arange(600), 2)
    again, same = fit_by_pieces(design[twice], target[twice], piece[twice])
    assert again == pytest.approx(found) and same == pytest.approx(covariance)
    kept = rng.random(600) < 0.5
    _, wider = fit_by_pieces(design[kept], target[kept], piece[kept])
    assert 1.2 < wider[0, 0] / covariance[0, 0] < 3.5


def test_a_factor_for_few_pieces():
    """Of three pieces and two unknowns the covariance is three times the bare one."""
    design = np.column_stack([np.arange(6.0), np.ones(6)])
    target = np.array([0.0, 1.0, 2.5, 2.9, 4.2, 5.0])
    found, covariance = fit_by_pieces(design, target, np.repeat([0, 1, 2], 2))
    left = target - design @ found
    sums = np.array([(design[k : k + 2] * left[k : k + 2, None]).sum(axis=0) for k in (0, 2, 4)])
    bread = np.linalg.inv(design.T @ design)
    assert covariance == pytest.approx(3 * bread @ sums.T @ sums @ bread)
