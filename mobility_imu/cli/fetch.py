"""Command that downloads public recordings by name."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mobility_imu.errors import InputError

if TYPE_CHECKING:
    from mobility_imu.datasets import Dataset

# The catalogue's names once more: importing it would load numpy for every command.
Name = Literal[
    "wheelmove-id-sample",
    "worklab-ngimu",
    "terrain-chair",
    "labelled-walks",
    "mocap-chair",
    "car-wheels",
    "two-hinges",
    "one-hinge",
    "foot-walks",
]
INDENT = "    "


def fetch(
    name: Annotated[
        Name | None,
        typer.Argument(metavar="NAME", help="Name of a data set; --list shows all names."),
    ] = None,
    listing: Annotated[
        bool,
        typer.Option(
            "--list", help="List the sets: name, size, origin, licence, and what each can test."
        ),
    ] = False,
) -> None:
    """Download public recordings by name into the cache, as canonical CSV with a note of origin.

    The cache is the folder that the variable MOBILITY_IMU_CACHE names, or else the usual one of the
    operating system. Most origins state no licence: use the files, do not pass them on.
    """
    if listing == (name is not None):
        raise InputError("give the name of one data set, or --list to see them all")
    _check_cache()
    if name is None:
        _list()
    else:
        _fetch(name)


def _check_cache() -> None:
    """Check that the cache's folder has a name, which one below a removed folder has not."""
    from mobility_imu.datasets.folders import CACHE_VARIABLE, cache_folder

    try:
        cache_folder()
    except FileNotFoundError:
        raise InputError(
            f"{CACHE_VARIABLE} = {os.environ.get(CACHE_VARIABLE)}: the current folder does not "
            "exist any more; change to one that does, or name a folder from the root on"
        ) from None


def _list() -> None:
    """Print every data set, and its folder if it has been fetched."""
    from mobility_imu.datasets import list_datasets
    from mobility_imu.datasets.folders import find_folder

    # First all, then print: looking for a folder may fail.
    folders = {dataset: find_folder(dataset.name) for dataset in list_datasets()}
    for dataset, folder in folders.items():
        typer.echo(dataset.name)
        for line in (*described(dataset), f"here: {folder}" if folder else "not here"):
            typer.echo(INDENT + line)


def described(dataset: Dataset) -> list[str]:
    """Lines that describe a data set.

    Parameters
    ----------
    dataset : data set to describe

    Returns
    -------
    list of str
    """
    return [
        dataset.about,
        f"good for: {dataset.good_for}",
        f"origin: {dataset.origin} at {dataset.commit}",
        f"licence: {dataset.licence}; about {dataset.download_mb:g} MB to fetch, "
        f"{dataset.size_mb:g} MB kept",
    ]


def _fetch(name: Name) -> None:
    """Fetch one data set and say where it is."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    from mobility_imu.datasets import fetch_dataset
    from mobility_imu.datasets.folders import NOTE

    console = Console(stderr=True)
    if console.is_interactive:
        columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        with Progress(*columns, console=console, transient=True) as bar:
            task = bar.add_task("fetching", total=None)
            folder = fetch_dataset(name, progress=lambda doing: bar.update(task, description=doing))
    else:  # a log file stays clean
        folder = fetch_dataset(name)
    typer.echo(f"{name}: {folder} ({NOTE} says what was done)")
    if name == "wheelmove-id-sample":
        typer.echo("for tests and book: set the variable MOBILITY_IMU_DATA to this folder")
