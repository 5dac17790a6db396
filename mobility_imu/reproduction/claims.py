"""One statement of a work, how we get our number for it, and what comes out.

Two columns are kept apart. *Published* is what the work prints, digit by digit, and each such row
names the table's cell or quotes the sentence. *Reference* is what a number has to be for another
reason: what the public tool answered, 1 for a ratio that should be 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from mobility_imu.errors import InputError

Work = Literal["scooter", "wheelchair", "walker"]
Basis = Literal[
    "published numbers recomputed",
    "computed by geometry alone",
    "computed on the public sample",
    "tried on independent real recordings",
    "computed on simulated data",
    "not reproducible",
]
BASES: tuple[Basis, ...] = (
    "published numbers recomputed",
    "computed by geometry alone",
    "computed on the public sample",
    "tried on independent real recordings",
    "computed on simulated data",
    "not reproducible",
)
Why = Literal[
    "the text contradicts itself",
    "the text is not right",
    "right in another reading",
    "the text leaves it open",
    "our copy may be at fault",
    "our assumptions do not explain it",
    "the simulation promised too much",
    "the stated uncertainty does not hold",
    "the reference errs more than we state",
]
Verdict = Literal["agrees", "differs", "not reproducible", "needs the sample"]
VERDICTS: tuple[Verdict, ...] = ("agrees", "differs", "not reproducible", "needs the sample")
COIN_TAIL = 0.05
"""A share counts as "holds" if a coin reaches it less often than this."""
COIN: dict[str, Any] = {"trivial": 0.5, "trivial_model": "a coin"}
"""Trivial model of a comparison of two methods."""


class Cell(NamedTuple):
    """A printed cell, as :func:`mobility_imu.reproduction.published.load_published` has it.

    Parameters
    ----------
    table : name of the published table
    row, column, quantity : of the cell
    """

    table: str
    row: str
    column: str
    quantity: str


class Quotation(NamedTuple):
    """A passage of the text, at least 25 characters, word for word.

    Parameters
    ----------
    text : contains the published number as printed, if there is one
    """

    text: str


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A statement of a work with the computation that checks it.

    Parameters
    ----------
    work : "scooter", "wheelchair" or "walker"
    where : place in the source, as in "Table 1, single IMU, 2-a"
    what : the quantity, in a few words
    unit : of all numbers of the row
    basis : what our number rests on
    source : Cell or Quotation that prints the statement; None if nothing is printed
    published : the number as printed, "" if the statement has none or nothing is printed
    reference : what the number has to be, if that is not printed; None otherwise
    reference_from : where the reference comes from
    compute : gives our number; called when asked, never stored; None if it cannot be had
    n : how many values, readings, frames or runs our number rests on
    tolerance : largest difference that counts as agreement
    tolerance_reason : why it is this large; says so where it was chosen with a result in view
    bound : "below" or "above" if the target is a bound that our number has to keep, "" if our
        number has to equal the target
    why : the reason, if our number differs. None: the kind of the finding says it, or else our
        assumptions do not explain it
    reason : why there is no number of ours, for "not reproducible"
    trivial : what a trivial model gives, NaN where that tells nothing
    trivial_model : which model that is
    experiment : whether the statement is about what was measured in the work's experiment
    finding : id of the finding that explains a difference, "" if none
    needs_sample : whether the computation reads the public sample
    copied : whether our number is a setting that we took from the text, so that agreement says
        only that we copied it right
    simulated : for a row on real recordings, the same measure on our simulated ones, and for a row
        on sensors as bad as real ones the number with a data sheet's; NaN elsewhere
    simulated_as_real : likewise, with sensors as bad as real recordings show them
    """

    work: Work
    where: str
    what: str
    unit: str
    basis: Basis
    source: Cell | Quotation | None = None
    published: str = ""
    reference: float | None = None
    reference_from: str = ""
    compute: Callable[[], float] | None = None
    n: int = 1
    tolerance: float = 0.0
    tolerance_reason: str = ""
    bound: Literal["", "below", "above"] = ""
    why: Why | None = None
    reason: str = ""
    trivial: float = math.nan
    trivial_model: str = ""
    experiment: bool = False
    finding: str = ""
    needs_sample: bool = False
    copied: bool = False
    simulated: float = math.nan
    simulated_as_real: float = math.nan

    def __post_init__(self) -> None:
        """Check that the row says what it compares."""
        if (self.compute is None) != (self.basis == "not reproducible"):
            raise InputError(f"{self.where}: a basis and a computation go together")
        if self.compute is None:
            if not self.reason:
                raise InputError(f"{self.where}: say why it is not reproducible")
            return
        if bool(self.published) == (self.reference is not None):
            raise InputError(f"{self.where}: give what is published or a reference, one of them")
        if self.published and self.source is None:
            raise InputError(f"{self.where}: {self.published} without its cell or quotation")
        if self.reference is not None and not self.reference_from:
            raise InputError(f"{self.where}: a reference of unknown origin")
        if not self.tolerance_reason:
            raise InputError(f"{self.where}: a tolerance without a reason")
        if self.bound and self.tolerance:
            raise InputError(f"{self.where}: a bound is kept or not, it has no tolerance")

    @property
    def target(self) -> float:
        """Number that ours is held against."""
        return float(self.published) if self.published else float(self.reference or 0.0)


@dataclass(frozen=True)
class Outcome:
    """A claim with our number beside it.

    Parameters
    ----------
    claim : Claim
    ours : our number, NaN if it could not be had
    """

    claim: Claim
    ours: float

    @property
    def difference(self) -> float:
        """Ours minus published or reference."""
        return math.nan if self.claim.compute is None else self.ours - self.claim.target

    @property
    def verdict(self) -> Verdict:
        """Agreement if a bound is kept, or within the tolerance and the last digit of a float."""
        if self.claim.compute is None:
            return "not reproducible"
        if math.isnan(self.ours):
            return "needs the sample" if self.claim.needs_sample else "not reproducible"
        return "agrees" if self._fits(self.ours) else "differs"

    @property
    def trivial_agrees(self) -> bool:
        """Whether the trivial model would have agreed as well."""
        return not math.isnan(self.claim.trivial) and self._fits(self.claim.trivial)

    def _fits(self, value: float) -> bool:
        if self.claim.bound == "below":
            return value < self.claim.target
        if self.claim.bound == "above":
            return value > self.claim.target
        return abs(value - self.claim.target) <= self.claim.tolerance + 1e-9


def check(claim: Claim) -> Outcome:
    """Our number for a claim, computed now.

    Parameters
    ----------
    claim : Claim; one that computes nothing gets NaN

    Returns
    -------
    Outcome
    """
    return Outcome(claim, math.nan if claim.compute is None else float(claim.compute()))


def share_rule(cases: int, note: str = "") -> dict[str, Any]:
    """How a fraction of cases is judged that should be 1: a coin must hardly reach it.

    Parameters
    ----------
    cases : scooters, pairs, rounds or courses
    note : added to the reason

    Returns
    -------
    dict
        ``n``, ``tolerance`` and ``tolerance_reason`` of a Claim. The smallest count is asked for
        that a fair coin reaches with a probability below 5 %.
    """
    tails = [0.0] * (cases + 2)
    for k in range(cases, -1, -1):
        tails[k] = tails[k + 1] + math.comb(cases, k) / 2**cases
    least = next((k for k in range(cases + 1) if tails[k] < COIN_TAIL), None)
    if least is None:
        raise InputError(f"{cases} cases: a coin gets all of them right too often to judge a share")
    reason = (
        f"{least} of {cases} or more: a coin reaches this in under 5 % "
        f"({100 * tails[least]:.1f} %, cases taken as independent)"
    )
    return {
        "n": cases,
        "tolerance": 1 - least / cases,
        "tolerance_reason": f"{reason}; {note}" if note else reason,
    }
