"""Scorecard of independent real recordings, computed again where they are, for the terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from mobility_imu.reproduction.claims import Outcome, Work, check
from mobility_imu.reproduction.real import Recomputed, real_record, real_sets, recompute
from mobility_imu.reproduction.real_claims import real_claims
from mobility_imu.reproduction.scorecard import reason_of, terminal, to_records

if TYPE_CHECKING:
    from rich.table import Table

ABOUT_REAL = (
    "Our methods, with default settings, on recordings of other people. An error agrees if it is "
    "at most twice that on our simulated recordings; stated uncertainties must be right. The "
    "numbers are recorded with origin, checksums and command. If the recordings are on this "
    "machine, they are computed again. Simulated: the same measure on our simulated recordings. At "
    "real level: the same with simulated sensors as bad as real ones."
)
"""The sentence with which the command begins."""
COLOURS = {"as recorded": "green", "differs": "red", "other files": "red"}


class RealScorecard(NamedTuple):
    """What came of computing the sets again, and the rows with the numbers from here.

    Parameters
    ----------
    sets : one for each set
    outcomes : rows of the scorecard; of sets that are not here, with the recorded numbers
    """

    sets: list[Recomputed]
    outcomes: list[Outcome]


def real_scorecard(
    work: Work | None = None, *, progress: Callable[[int, int], None] | None = None
) -> RealScorecard:
    """Compute the records of real recordings again where the recordings are.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three
    progress : is told how many sets are done, and of how many

    Returns
    -------
    RealScorecard
    """
    chosen, sets = real_sets(work), []
    for k, real in enumerate(chosen):
        sets.append(recompute(real.record))
        if progress is not None:
            progress(k + 1, len(chosen))
    found = {one.real.record: one.numbers for one in sets if one.numbers is not None}
    return RealScorecard(sets, [check(claim) for claim in real_claims(work, found)])


def real_records(found: RealScorecard) -> list[dict[str, Any]]:
    """Plain dictionaries, one for each set, as JSON wants them.

    Parameters
    ----------
    found : what :func:`real_scorecard` gave

    Returns
    -------
    list of dict
        ``record``, ``dataset``, ``work``, ``title``, ``state``, ``message``, ``compared`` (how many
        numbers), ``origin``, ``command``, ``date``, ``files`` (SHA-256 by name; None without a
        record), ``rows`` as of :func:`~mobility_imu.reproduction.scorecard.to_records`.
    """
    return [_set_record(one, found.outcomes) for one in found.sets]


def _set_record(one: Recomputed, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    real, record = one.real, real_record(one.real.record)
    rows = [o for o in outcomes if o.claim.where == real.title]
    return {
        "record": real.record,
        "dataset": real.dataset,
        "work": real.work,
        "title": real.title,
        "state": one.state,
        "message": one.message,
        "compared": one.compared,
        "origin": None if record is None else record.origin,
        "command": None if record is None else record.command,
        "date": None if record is None else record.date,
        "files": None if record is None else dict(record.files),
        "rows": to_records(rows),
    }


def print_real(found: RealScorecard) -> None:
    """Print one line for each set, and the rows.

    Parameters
    ----------
    found : what :func:`real_scorecard` gave
    """
    from rich.markup import escape

    console = terminal()
    console.print(ABOUT_REAL, "\n")
    for one in found.sets:
        colour = COLOURS.get(one.state, "yellow")
        console.print(f"[{colour}]{one.state}[/]: {escape(one.message)}")
    console.print()
    console.print(_promises(found.outcomes))
    kept = sum(o.verdict == "agrees" for o in found.outcomes)
    console.print(f"{kept} of {len(found.outcomes)} rows agree.")


def _promises(outcomes: Sequence[Outcome]) -> Table:
    from rich.table import Table

    as_real = any(not math.isnan(o.claim.simulated_as_real) for o in outcomes)
    table = Table(
        title="Found on real recordings, and predicted by simulation", title_justify="left"
    )
    for heading in ("set", "what", "unit"):
        table.add_column(heading)
    for heading in ("asked for", "found", "simulated", *(["at real level"] * as_real), "n"):
        table.add_column(heading, justify="right")
    table.add_column("verdict")
    for outcome in outcomes:
        claim, agrees = outcome.claim, outcome.verdict == "agrees"
        values = [outcome.ours, claim.simulated, *([claim.simulated_as_real] * as_real)]
        table.add_row(
            claim.where,
            claim.what,
            claim.unit,
            f"{claim.bound} {claim.target:.3g}".strip(),
            *("-" if math.isnan(value) else f"{value:.3g}" for value in values),
            str(claim.n),
            "[green]agrees[/]" if agrees else f"[red]{outcome.verdict}: {reason_of(claim)}[/]",
        )
    return table
