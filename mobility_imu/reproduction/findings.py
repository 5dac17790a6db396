"""What we found in the works beside their numbers: contradictions, errors, ambiguities, silences.

The findings are data, ``findings.toml``; pages, counts and tests are made from it. Each has a check
that gives numbers, so that the finding can turn out wrong.
"""

from __future__ import annotations

import importlib
import math
import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

from mobility_imu.errors import InputError
from mobility_imu.reproduction.claims import Work

Kind = Literal["contradiction", "error", "ambiguity", "silence", "our copy"]
KINDS: dict[Kind, str] = {
    "contradiction": "two statements of the text cannot both be true",
    "error": "the text has only one meaning, and it is wrong",
    "ambiguity": "the text can mean two things, and does not say which",
    "silence": "the text does not state something that matters",
    "our copy": "a character, word or number is wrong, but perhaps only in our text copy",
}
"""Kinds of findings and what each means."""


Relation = Literal["apart", "together", "first above", "first below"]
OPPOSITE: dict[Relation, Relation] = {
    "apart": "together",
    "together": "apart",
    "first above": "first below",
    "first below": "first above",
}
"""Each relation and the one that must not hold beside it."""


class Evidence(NamedTuple):
    """Numbers that decide whether a finding holds.

    Parameters
    ----------
    what : the quantity, in words
    first_from, first : what it is from (the print, or one reading), and the number
    second_from, second : the same for the corrected form, the other passage or reading
    truth : what it has to be, NaN if unknown
    tolerance : differences up to this do not count
    unit : of all numbers
    relation : claimed of the first to the second where the truth is not known
    """

    what: str
    first_from: str
    first: float
    second_from: str
    second: float
    truth: float = math.nan
    tolerance: float = 0.0
    unit: str = ""
    relation: Relation = "apart"

    def holds(self) -> bool:
        """Whether the numbers bear the finding out.

        With a known truth: the second has it and the first has not. Without: as the relation says.
        """
        if not math.isnan(self.truth):
            return (
                abs(self.first - self.truth) > self.tolerance
                and abs(self.second - self.truth) <= self.tolerance
            )
        above = self.first - self.second
        return {
            "apart": abs(above) > self.tolerance,
            "together": abs(above) <= self.tolerance,
            "first above": above > self.tolerance,
            "first below": -above > self.tolerance,
        }[self.relation]

    def inverted(self) -> Evidence:
        """The same numbers with the opposite claim: it must not hold."""
        if math.isnan(self.truth):
            return self._replace(relation=OPPOSITE[self.relation])
        return self._replace(first=self.second, second=self.first)


@dataclass(frozen=True)
class Finding:
    """One finding.

    Parameters
    ----------
    id : letter of the work and a number
    work : "scooter", "wheelchair" or "walker"
    title : what it is about, without a judgement
    place : equation, section, table or figure
    kind : see :data:`KINDS`
    quotation : passages of the work, word for word, as our text copy has them
    reading : the reading in which the authors are right, and what else the words allow
    verdict : what we conclude
    settles : what would settle it
    consequence : what it changes for a user
    chapters : pages of the book that go into it
    check : dotted name of the function that gives the :class:`Evidence`
    """

    id: str
    work: Work
    title: str
    place: str
    kind: Kind
    quotation: tuple[str, ...]
    reading: str
    verdict: str
    settles: str
    consequence: str
    chapters: tuple[str, ...]
    check: str

    def evidence(self) -> tuple[Evidence, ...]:
        """Numbers of the finding's check, computed now."""
        return self.function()()

    def function(self) -> Callable[[], tuple[Evidence, ...]]:
        """Function that computes the evidence."""
        module, _, name = self.check.rpartition(".")
        function: Callable[[], tuple[Evidence, ...]] = getattr(
            importlib.import_module(module), name
        )
        return function


@cache
def findings(work: Work | None = None) -> tuple[Finding, ...]:
    """All findings, or those of one work, in the order of the file.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None

    Returns
    -------
    tuple of Finding

    Raises
    ------
    InputError
        If an entry lacks a field or has a kind that does not exist.

    Examples
    --------
    >>> sorted({finding.work for finding in findings()})
    ['scooter', 'walker', 'wheelchair']
    """
    path = Path(__file__).with_name("findings.toml")
    entries = tomllib.loads(path.read_text(encoding="utf-8"))["finding"]
    found = []
    for entry in entries:
        given: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in entry.items()
        }
        try:
            finding = Finding(**given)
        except TypeError as error:
            raise InputError(f"{path.name}, {entry.get('id', '?')}: {error}") from None
        if finding.kind not in KINDS:
            raise InputError(f"{path.name}, {finding.id}: no kind {finding.kind!r}")
        found.append(finding)
    return tuple(f for f in found if work in (None, f.work))


def quoted(finding_id: str, pattern: str) -> float:
    """Number in a finding's quotations: first group of a regular expression.

    Parameters
    ----------
    finding_id : as in the file
    pattern : regular expression with one group

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the quotations have no such number.

    Examples
    --------
    >>> quoted("S1", "lower than ([0-9]+)°")
    10.0
    """
    text = " ".join(next(f for f in findings() if f.id == finding_id).quotation)
    found = re.search(pattern, text)
    if found is None:
        raise InputError(f"{finding_id}: no {pattern!r} in its quotations")
    return float(found[1])


def counts() -> dict[Work, dict[Kind, int]]:
    """Number of findings by work and kind."""
    return {
        work: {kind: sum(f.kind == kind for f in findings(work)) for kind in KINDS}
        for work in get_args(Work)
    }
