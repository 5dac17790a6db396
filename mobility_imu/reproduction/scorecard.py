"""All statements of the three works that we check, each with our number beside it, and totals."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

from mobility_imu.reproduction.claims import (
    BASES,
    VERDICTS,
    Cell,
    Claim,
    Outcome,
    Quotation,
    Why,
    Work,
    check,
)
from mobility_imu.reproduction.findings import Kind, findings
from mobility_imu.reproduction.real_claims import real_claims
from mobility_imu.reproduction.real_level_claims import level_claims

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import Console
    from rich.table import Table

WORKS: tuple[Work, ...] = get_args(Work)
NO_RECORDING = (
    "No recording of a study was available to us, so no published result was reproduced "
    "from a recording. The table counts separately what we recomputed from published numbers, "
    "computed by geometry alone, on the public sample of WheelMove-ID, on recordings of other "
    "people or on simulated data. The scooter's authors offer their data on request; we have asked "
    "neither them nor the other authors."
)
"""The sentence with which page, front page and command begin."""


class WorkVerdict(NamedTuple):
    """What the check of one work amounts to, on our own scale.

    Parameters
    ----------
    work : "scooter", "wheelchair" or "walker"
    kind : "reproduction" (their data) or "replication" (other data, their method)
    degree : "full", "partial" or "failed"
    why : what holds, and what stood in the way
    """

    work: Work
    kind: Literal["reproduction", "replication"]
    degree: Literal["full", "partial", "failed"]
    why: str


WORK_VERDICTS = (
    WorkVerdict(
        "scooter",
        "replication",
        "partial",
        "The equations are right, and geometry explains most errors of one IMU at rest. To check "
        "the errors of two IMUs and the driving test, one needs the readings. They are not "
        "published (the paper offers them on request; we have not asked). In our simulation, many "
        "statements on the driving test are true for a part of the scooters only, two for none.",
    ),
    WorkVerdict(
        "wheelchair",
        "reproduction",
        "partial",
        "We reproduced the answers of the public tool, not a study; the document contains no "
        "results. With the tool's rule for the start of a trial, our task labels equal the tool's "
        "at each moment of the two series that we compared (the public sample and a made-up "
        "series). The term for camber must be changed before the wheels show the right yaw rate.",
    ),
    WorkVerdict(
        "walker",
        "replication",
        "partial",
        "The calibration works in simulation, and 58 of the 60 averages in the tables are right "
        "to the last digit; one more is wrong by one unit of this digit only. To check the "
        "distances and closing errors, one needs the recordings. They are not published. The "
        "closing errors also depend on where the IMU is fixed on the frame (finding K6), so a "
        "reproduction should compare other numbers.",
    ),
)
"""One verdict for each work; the scorecard's page defines the scale."""


def all_claims(work: Work | None = None) -> list[Claim]:
    """Claims of one work, or of all.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three

    Returns
    -------
    list of Claim
    """
    found: list[Claim] = []
    for name in WORKS:
        if work in (None, name):
            found += importlib.import_module(f"mobility_imu.reproduction.{name}.claims").claims()
            found += real_claims(name)
            found += level_claims(name)
    return found


def scorecard(
    work: Work | None = None, *, progress: Callable[[int, int], None] | None = None
) -> list[Outcome]:
    """Our number for every claim, computed now or read from a record that a test keeps current.

    Parameters
    ----------
    work : "scooter", "wheelchair", "walker" or None for all three
    progress : is told how many claims are done, and of how many

    Returns
    -------
    list of Outcome
    """
    claims = all_claims(work)
    outcomes = []
    for k, claim in enumerate(claims):
        outcomes.append(check(claim))
        if progress is not None:
            progress(k + 1, len(claims))
    return outcomes


def to_records(outcomes: Iterable[Outcome]) -> list[dict[str, Any]]:
    """Plain dictionaries, as JSON wants them; what does not exist is None.

    Parameters
    ----------
    outcomes : what :func:`scorecard` gave

    Returns
    -------
    list of dict
        ``work``, ``where``, ``what``, ``unit``, ``published`` (text, digits as printed), ``source``
        (the cell, or the sentence), ``reference``, ``reference_from``, ``ours``, ``difference``,
        ``tolerance``, ``tolerance_reason``, ``bound``, ``basis``, ``n``, ``verdict``, ``why``,
        ``trivial``, ``trivial_model``, ``trivial_agrees``, ``experiment``, ``copied``, ``finding``,
        ``simulated``, ``simulated_as_real``.
    """
    return [_record(outcome) for outcome in outcomes]


REASONS: dict[Kind, Why] = {
    "contradiction": "the text contradicts itself",
    "error": "the text is not right",
    "ambiguity": "right in another reading",
    "silence": "the text leaves it open",
    "our copy": "our copy may be at fault",
}
"""Why a row differs that a finding explains, by the finding's kind."""


def reason_of(claim: Claim) -> Why:
    """Why a claim differs, if it does.

    Parameters
    ----------
    claim : Claim

    Returns
    -------
    str
        What the claim itself says, else by the kind of the finding that it names, else that our
        assumptions do not explain it.
    """
    if claim.why is not None:
        return claim.why
    if not claim.finding:
        return "our assumptions do not explain it"
    return REASONS[next(f.kind for f in findings(claim.work) if f.id == claim.finding)]


def _record(outcome: Outcome) -> dict[str, Any]:
    claim, verdict = outcome.claim, outcome.verdict
    why = {"differs": reason_of(claim), "not reproducible": claim.reason}.get(verdict, "")
    compared = claim.compute is not None
    return {
        "work": claim.work,
        "where": claim.where,
        "what": claim.what,
        "unit": claim.unit,
        "published": claim.published or None,
        "source": _source(claim.source),
        "reference": claim.reference,
        "reference_from": claim.reference_from or None,
        "ours": _number(outcome.ours),
        "difference": _number(outcome.difference),
        "tolerance": claim.tolerance if compared else None,
        "tolerance_reason": claim.tolerance_reason or None,
        "bound": claim.bound or None,
        "basis": claim.basis,
        "n": claim.n,
        "verdict": verdict,
        "why": why or None,
        "trivial": _number(claim.trivial),
        "trivial_model": claim.trivial_model or None,
        "trivial_agrees": outcome.trivial_agrees,
        "experiment": claim.experiment,
        "copied": claim.copied,
        "finding": claim.finding or None,
        "simulated": _number(claim.simulated),
        "simulated_as_real": _number(claim.simulated_as_real),
    }


def _number(value: float) -> float | None:
    return None if math.isnan(value) else round(value, 6)


def _source(source: Cell | Quotation | None) -> str | None:
    if source is None:
        return None
    if isinstance(source, Cell):
        return f"{source.table}: {source.row}, {source.column}, {source.quantity}"
    return source.text


def totals(outcomes: Sequence[Outcome]) -> pd.DataFrame:
    """Number of rows by work, basis and verdict.

    Parameters
    ----------
    outcomes : what :func:`scorecard` gave

    Returns
    -------
    DataFrame
        Index work and basis, a column for each verdict, and two that count rows among those that
        agree: ``trivial too``, where a trivial model agrees as well, and ``settings copied``, where
        our number is a setting taken from the text.
    """
    import pandas as pd

    table = pd.DataFrame(
        [
            {
                "work": o.claim.work,
                "basis": o.claim.basis,
                "verdict": o.verdict,
                "trivial too": o.verdict == "agrees" and o.trivial_agrees,
                "settings copied": o.verdict == "agrees" and o.claim.copied,
            }
            for o in outcomes
        ]
    )
    counted = pd.crosstab([table["work"], table["basis"]], table["verdict"])
    wanted = [(w, b) for w in WORKS for b in BASES if (w, b) in counted.index]
    counted = counted.reindex(index=pd.MultiIndex.from_tuples(wanted, names=["work", "basis"]))
    counted = counted.reindex(columns=list(VERDICTS), fill_value=0)
    return counted.join(table.groupby(["work", "basis"])[["trivial too", "settings copied"]].sum())


class Experiments(NamedTuple):
    """How many statements on the works' own experiments our simulations bear out.

    Parameters
    ----------
    agree : number of statements that our simulations bear out
    trivial : how many of these a trivial model bears out as well
    all : number of statements
    """

    agree: int
    trivial: int
    all: int


def simulated_experiments(outcomes: Iterable[Outcome]) -> Experiments:
    """Count the statements on the works' experiments that rest on simulated data.

    Parameters
    ----------
    outcomes : what :func:`scorecard` gave

    Returns
    -------
    Experiments
    """
    chosen = [
        o for o in outcomes if o.claim.experiment and o.claim.basis == "computed on simulated data"
    ]
    agree = [o for o in chosen if o.verdict == "agrees"]
    return Experiments(len(agree), sum(o.trivial_agrees for o in agree), len(chosen))


def print_scorecard(outcomes: list[Outcome], *, everything: bool = False) -> None:
    """Print the scorecard on the terminal: what it counts, totals, and the rows that differ.

    Parameters
    ----------
    outcomes : what :func:`scorecard` gave
    everything : print all rows, not only those that differ
    """
    console = terminal()
    console.print(NO_RECORDING, "\n")
    console.print(_totals_table(outcomes))
    experiments = simulated_experiments(outcomes)
    console.print(
        f"Statements on the works' experiments, tried by simulation: {experiments.agree} of "
        f"{experiments.all} agree; a trivial model meets {experiments.trivial} of those that "
        "agree.\n"
    )
    chosen = [o for o in outcomes if everything or o.verdict == "differs"]
    console.print(row_table(chosen, "All rows" if everything else "Rows that differ"))
    if not everything:
        console.print(
            f"{len(outcomes)} rows in all: --all prints them, --json writes them for a program."
        )


def terminal() -> Console:
    """Console that prints to standard output; in a file or a pipe 200 characters wide.

    Returns
    -------
    rich.console.Console
    """
    from rich.console import Console

    console = Console()
    # In a file or a pipe there is no window to fit into.
    return console if console.is_terminal else Console(width=200)


COUNTED_AMONG = (
    "The last two columns count rows among those that agree: trivial too, if a trivial model "
    "agrees as well; settings copied, if our number is a setting from the text, so that only our "
    "copying was checked."
)
"""What the last two columns of the totals count."""


def _totals_table(outcomes: list[Outcome]) -> Any:
    from rich.table import Table

    table = Table(
        title="What was compared, by work and basis",
        title_justify="left",
        caption=COUNTED_AMONG,
        caption_justify="left",
    )
    for heading in ("work", "basis"):
        table.add_column(heading)
    counted = totals(outcomes)
    for heading in counted.columns:
        table.add_column(str(heading), justify="right")
    for (work, basis), row in counted.iterrows():
        table.add_row(str(work), str(basis), *(str(value) if value else "-" for value in row))
    return table


def row_table(outcomes: Iterable[Outcome], title: str) -> Table:
    """Rows of the scorecard as a table for the terminal.

    Parameters
    ----------
    outcomes : what :func:`scorecard` gave
    title : of the table

    Returns
    -------
    rich.table.Table
    """
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=title, title_justify="left", expand=False)
    for heading in ("work", "where", "what", "unit"):
        table.add_column(heading)
    for heading in ("published", "reference", "ours", "tolerance"):
        table.add_column(heading, justify="right")
    table.add_column("verdict")
    colours = {"agrees": "green", "differs": "red"}
    for outcome in outcomes:
        claim, record = outcome.claim, _record(outcome)
        verdict = outcome.verdict + (f": {record['why']}" if record["why"] else "")
        verdict += " (a setting taken from the text)" if claim.copied else ""
        colour = colours.get(outcome.verdict, "yellow")
        table.add_row(
            claim.work,
            escape(claim.where),
            escape(claim.what),
            claim.unit,
            f"{claim.bound} {claim.published}".strip() or "-",
            *(
                "-" if value is None else f"{value:.6g}"
                for value in (claim.reference, record["ours"], record["tolerance"])
            ),
            f"[{colour}]{escape(verdict)}[/]",
        )
    return table
