"""Rests that are given with a recording, held against those that its readings show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["GIVEN_WORDS", "shifted_rests"]

GIVEN_WORDS = "the given rests"
LONGEST_SHIFT_S, LEAST_SHIFT_S = 10.0, 0.2
"""Shifts that are looked for, and the smallest one that is told: the ends of a rest by hand and by
the detector differ by a tenth of a second or so. Our choice, not swept."""
ALIKE, BETTER = 0.5, 0.15
"""Correlation of both that shows them to be the same rests, and by how much the shift has to make
it larger. Our choice, not swept. A foot's rests, of which the detector finds none, show nothing."""
LEAST_FITTING = 0.4
"""Part of the fewer rests, given or shown by the readings, that lie among the others beyond what
chance puts there, from which on both may be of one recording. Who knows some rests only, or sees
more than the detector, has all of it; true rests of 14 simulated walks have 0.99 or more, those of
another walk 0.19 (median)."""


def shifted_rests(
    given: NDArray[np.bool_], found: NDArray[np.bool_], sampling_rate_hz: float
) -> str | None:
    """Warning of rests that fit the recording better a little earlier or later, or not at all.

    Parameters
    ----------
    given, found : (n,) flags of the samples at rest, as stated and by the detector
    sampling_rate_hz : Hz

    Returns
    -------
    str, None if they fit as they are, or the readings show none
    """
    count = len(given)
    one, other = (flags - flags.mean() for flags in (given.astype(float), found.astype(float)))
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    if size == 0.0:
        return None
    from scipy import signal  # takes half a second to load

    alike = signal.correlate(other, one, mode="full", method="fft") / size
    if float(one @ other) < -ALIKE * size:
        return (
            f"{GIVEN_WORDS} lie where the readings show moves: are 0 and 1 exchanged? The path is "
            "found with them as they are"
        )
    most = min(round(LONGEST_SHIFT_S * sampling_rate_hz), count - 1)
    near = alike[count - 1 - most : count + most]
    shift_s = (int(np.argmax(near)) - most) / sampling_rate_hz
    few, many = sorted((float(given.mean()), float(found.mean())))
    fitting = (float((given & found).mean()) / few - many) / (1 - many)
    if near.max() < ALIKE and fitting < LEAST_FITTING:
        return (
            f"{GIVEN_WORDS} do not resemble those that the readings show: are they of this "
            "recording? The path is found with them as they are"
        )
    if abs(shift_s) < LEAST_SHIFT_S or near.max() < max(ALIKE, near[most] + BETTER):
        return None
    way = "later" if shift_s > 0 else "earlier"
    return (
        f"{GIVEN_WORDS} fit the readings about {abs(shift_s):.1f} s {way}: are they of this "
        "recording, and on its clock? The path is found with them as they are"
    )
