"""Seeds: whole numbers from which all that is drawn at random follows."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import as_count


def stream(seed: int, *parts: int, name: str = "seed") -> np.random.Generator:
    """Random numbers of one seed and one purpose; the same seed gives the same ones.

    Parameters
    ----------
    seed : whole number of 0 or more
    parts : whole numbers that tell the purposes of one seed apart
    name : what to call the seed in the error message

    Returns
    -------
    numpy.random.Generator

    Raises
    ------
    InputError
        If the seed is negative or not whole.

    Examples
    --------
    >>> stream(-1, 2)
    Traceback (most recent call last):
    mobility_imu.errors.InputError: seed = -1: expected a whole number of 0 or more
    """
    return np.random.default_rng([as_count(seed, name, least=0), *parts])
