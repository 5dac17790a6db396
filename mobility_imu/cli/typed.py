"""Slips in a command line that the parser of arguments would take for something else."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence

DASHES = "\u2010\u2011\u2012\u2013\u2014\u2015\u2212"
"""Hyphens, dashes and a minus sign that a program for texts writes in place of a hyphen."""


def given_options(
    arguments: Sequence[str], valued: Mapping[str, str], flags: Collection[str] = ()
) -> Iterator[tuple[str, str]]:
    """Options with values, and flags, that stand in a command line, each as often as it does.

    Parameters
    ----------
    arguments : of the command line
    valued : names of options behind which a value stands, to the longest name of the option
    flags : names of options without one

    Returns
    -------
    iterator of the option's longest name and its value, which is empty for a flag
    """
    waiting = iter(arguments)
    for argument in waiting:
        if argument == "--":  # what follows are arguments
            return
        name, value, apart = _option(argument, valued)
        if argument in flags:
            yield argument, ""
        elif name in valued:
            yield valued[name], next(waiting, "") if apart else value


def _option(argument: str, valued: Mapping[str, str]) -> tuple[str, str, bool]:
    """Name of an option and its value in one word, and whether the value is the next word."""
    if argument.startswith("--"):
        name, _, value = argument.partition("=")
        return name, value, name == argument
    if not argument.startswith("-"):
        return "", "", False
    # Letters of flags may stand before that of the option, and its value behind.
    k = next((k for k in range(1, len(argument)) if f"-{argument[k]}" in valued), 0)
    return f"-{argument[k]}", argument[k + 1 :], k == len(argument) - 1


def wrong_dash(
    arguments: Sequence[str], valued: Mapping[str, str], names: Collection[str]
) -> str | None:
    """Message for the first option with one hyphen too few, or with another kind of dash.

    Parameters
    ----------
    arguments : of the command line
    valued : as for :func:`given_options`
    names : of all options

    Returns
    -------
    str, or None if there is no such option
    """
    waiting = iter(arguments)
    for argument in waiting:
        if argument == "--":
            return None
        option, _, apart = _option(argument, valued)
        if apart and option in valued:
            next(waiting, None)  # a value may look like anything
            continue
        word = argument.lstrip(f"-{DASHES}")
        before = argument[: len(argument) - len(word)]
        name, sign, value = word.partition("=")
        # One letter, or the long name: programs for texts make one dash of two hyphens.
        meant = next((n for n in (f"--{name}", f"-{name}") if n in names), None)
        if not before or meant is None or os.path.exists(argument):
            continue
        if any(dash in before for dash in DASHES):
            return f"{argument}: begins with what is no hyphen; write {meant}{sign}{value}"
        if before == "-" and meant.startswith("--"):
            return f"{argument}: has one dash; write {meant}{sign}{value}"
    return None


def no_number(
    arguments: Sequence[str], valued: Mapping[str, str], numbers: Collection[str]
) -> str | None:
    """Message for the first value of an option that Python reads as a number, and nobody else.

    Parameters
    ----------
    arguments : of the command line
    valued : as for :func:`given_options`
    numbers : longest names of the options that take a number

    Returns
    -------
    str, or None if there is no such value
    """
    for name, value in given_options(arguments, valued):
        if name in numbers and "_" in value:
            return f"{name}: {value!r} is no number; write it without an underscore"
    return None
