"""One published number, how we get ours, and when the two agree."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Basis = Literal[
    "published numbers recomputed",
    "reproduced by geometry alone",
    "reproduced on real data",
    "reproduced on synthetic data",
    "not reproducible",
]
Verdict = Literal["agrees", "differs", "not reproducible"]


@dataclass(frozen=True)
class Claim:
    """A published number with the computation that checks it.

    Parameters
    ----------
    work : "scooter", "wheelchair" or "walker"
    where : place in the source, as in "Table 1, single IMU, 2-a"
    what : the quantity, in a few words
    published_value : the number as printed
    unit : its unit
    basis : what kind of check this is
    compute : gives our number; called when asked, never stored
    tolerance : largest difference that counts as agreement, fixed before any run
    tolerance_reason : why it is this large
    """

    work: str
    where: str
    what: str
    published_value: float
    unit: str
    basis: Basis
    compute: Callable[[], float] | None
    tolerance: float
    tolerance_reason: str


@dataclass(frozen=True)
class Outcome:
    """A claim with our number beside it."""

    claim: Claim
    ours: float

    @property
    def difference(self) -> float:
        """Ours minus published."""
        return self.ours - self.claim.published_value

    @property
    def verdict(self) -> Verdict:
        """Agreement within the tolerance (and a rounding of the last float digit)."""
        if self.claim.compute is None or math.isnan(self.ours):
            return "not reproducible"
        return "agrees" if abs(self.difference) <= self.claim.tolerance + 1e-9 else "differs"


def check(claim: Claim) -> Outcome:
    """Compute our number for a claim."""
    return Outcome(claim, math.nan if claim.compute is None else float(claim.compute()))
