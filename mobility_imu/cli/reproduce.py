"""Command that checks the papers' numbers."""

from __future__ import annotations

import codecs
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any, Literal

import typer

from mobility_imu.errors import InputError

Work = Literal["scooter", "wheelchair", "walker"]


def reproduce(
    work: Annotated[Work | None, typer.Option(help="Check only this work.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="JSON instead of a table.")] = False,
    everything: Annotated[
        bool, typer.Option("--all", help="All rows of the table, not only those that differ.")
    ] = False,
    real: Annotated[
        bool,
        typer.Option(
            "--real",
            help="Only results on independent real recordings; computed again if these are here.",
        ),
    ] = False,
) -> None:
    """Compare the numbers of the three works with ours, and give a verdict for each."""
    if not real and work in (None, "wheelchair"):
        _check_sample()
    from mobility_imu.reproduction.real_scorecard import print_real, real_records, real_scorecard
    from mobility_imu.reproduction.scorecard import print_scorecard, scorecard, to_records

    if real:
        with _progress() as told:
            found = real_scorecard(work, progress=told)
        if as_json:
            _echo_json(real_records(found))
        else:
            print_real(found)
        return
    with _progress() as told:
        outcomes = scorecard(work, progress=told)
    if as_json:
        _echo_json(to_records(outcomes))
    else:
        print_scorecard(outcomes, everything=everything)


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """Progress bar on standard error; the caller states how much is done, and of how much."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Off a terminal Rich would still end with an empty line.
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("computing", total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)


def _check_sample() -> None:
    """Check that the folder that the environment names is that of WheelMove-ID's sample."""
    from mobility_imu.data import SAMPLE_VARIABLE, sample_folder
    from mobility_imu.reproduction.wheelchair.sample import SAMPLE_FILES

    folder = sample_folder()
    missing = [] if folder is None else [n for n in SAMPLE_FILES if not (folder / n).is_file()]
    if missing:
        raise InputError(
            f"{SAMPLE_VARIABLE} = {folder}: does not hold the sample ({missing[0]!r} is missing); "
            "name its folder, or unset the variable"
        )


def _echo_json(records: list[dict[str, Any]]) -> None:
    # JSON is in UTF-8 (RFC 8259); where standard output is not, characters are written as codes.
    encoding = codecs.lookup(getattr(sys.stdout, "encoding", None) or "utf-8").name
    typer.echo(json.dumps(records, indent=2, ensure_ascii=encoding != "utf-8"))
