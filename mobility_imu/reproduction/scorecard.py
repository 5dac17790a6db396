"""All claims of the three works, each with our number beside the published one."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterable
from typing import Any

from mobility_imu.reproduction.claims import Claim, Outcome, check

WORKS = ("scooter", "wheelchair", "walker")
MODULES = {
    "scooter": "mobility_imu.reproduction.scooter.static_table",
    "wheelchair": "mobility_imu.reproduction.wheelchair.sample",
    "walker": "mobility_imu.reproduction.walker.tables",
}


def all_claims(work: str | None = None) -> list[Claim]:
    """Give the claims of one work, or of all."""
    found: list[Claim] = []
    for name in WORKS:
        if work in (None, name):
            found += importlib.import_module(MODULES[name]).claims()
    return found


def scorecard(work: str | None = None) -> list[Outcome]:
    """Compute our number for every claim, now."""
    return [check(claim) for claim in all_claims(work)]


def to_records(outcomes: Iterable[Outcome]) -> list[dict[str, Any]]:
    """Give plain dictionaries, as JSON wants them; a number that does not exist is None."""

    def number(value: float) -> float | None:
        return None if math.isnan(value) else round(value, 6)

    return [
        {
            "work": outcome.claim.work,
            "where": outcome.claim.where,
            "what": outcome.claim.what,
            "unit": outcome.claim.unit,
            "published": outcome.claim.published_value,
            "ours": number(outcome.ours),
            "difference": number(outcome.difference),
            "tolerance": outcome.claim.tolerance,
            "tolerance_reason": outcome.claim.tolerance_reason,
            "basis": outcome.claim.basis,
            "verdict": outcome.verdict,
        }
        for outcome in outcomes
    ]


def print_scorecard(outcomes: list[Outcome]) -> None:
    """Print the scorecard on the terminal, with the count of verdicts below."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title="Published numbers and ours", title_justify="left", expand=False)
    for heading in ("work", "where", "what", "unit"):
        table.add_column(heading)
    for heading in ("published", "ours", "difference", "tolerance"):
        table.add_column(heading, justify="right")
    table.add_column("verdict")
    colours = {"agrees": "green", "differs": "red", "not reproducible": "yellow"}
    for outcome in outcomes:
        claim = outcome.claim
        missing = math.isnan(outcome.ours)
        table.add_row(
            claim.work,
            claim.where,
            claim.what,
            claim.unit,
            f"{claim.published_value:.6g}",
            "-" if missing else f"{round(outcome.ours, 6):.6g}",
            "-" if missing else f"{round(outcome.difference, 6):+.3g}",
            f"{claim.tolerance:g}",
            f"[{colours[outcome.verdict]}]{outcome.verdict}[/]",
        )
    console = Console()
    if not console.is_terminal:
        # In a file or a pipe there is no window to fit into.
        console = Console(width=200)
    console.print(table)
    verdicts: list[str] = [outcome.verdict for outcome in outcomes]
    console.print(", ".join(f"{verdicts.count(v)} {v}" for v in colours))
