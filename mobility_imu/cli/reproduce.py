"""Command that checks the papers' numbers."""

from __future__ import annotations

import json
from typing import Annotated, Literal

import typer

Work = Literal["scooter", "wheelchair", "walker"]


def reproduce(
    work: Annotated[Work | None, typer.Option(help="Only one of the works.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="JSON instead of a table.")] = False,
    everything: Annotated[
        bool, typer.Option("--all", help="All rows of the table, not only those that differ.")
    ] = False,
) -> None:
    """The scorecard: what the works print beside our numbers, with a verdict."""
    from rich.console import Console
    from rich.progress import Progress

    from mobility_imu.reproduction.scorecard import print_scorecard, scorecard, to_records

    # Rich draws the bar on a terminal only, so a log file stays clean.
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("computing", total=None)
        outcomes = scorecard(
            work, progress=lambda done, of: bar.update(task, completed=done, total=of)
        )
    if as_json:
        typer.echo(json.dumps(to_records(outcomes), indent=2, ensure_ascii=False))
    else:
        print_scorecard(outcomes, everything=everything)
