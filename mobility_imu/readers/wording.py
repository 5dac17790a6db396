"""How messages quote what a file holds: short, and without characters that act on a terminal."""

from __future__ import annotations

from collections.abc import Iterable

LONGEST_QUOTE = 60
"""Characters of a cell, name or value that a message quotes at most."""
MOST_NAMES = 10
"""Names that a message lists at most."""


def escaped(text: str) -> str:
    r"""Text in which control characters and other unprintable ones are written as escapes.

    Parameters
    ----------
    text : any text, such as a file's name

    Returns
    -------
    str

    Examples
    --------
    >>> escaped("ride\x1b[2J.csv")
    'ride\\x1b[2J.csv'
    """
    if text.isprintable():
        return text
    return "".join(
        char if char.isprintable() else char.encode("unicode_escape").decode() for char in text
    )


def quoted(text: str, longest: int = LONGEST_QUOTE) -> str:
    """Text of a file as a message shows it: escaped, and cut after some characters.

    Parameters
    ----------
    text : as the file has it
    longest : characters that are kept

    Returns
    -------
    str

    Examples
    --------
    >>> quoted("7" * 1000, longest=5)
    '77777...'
    """
    # Cut before it is escaped: a text of a megabyte costs nothing then.
    short = escaped(text[: longest + 1])
    return short if len(text) <= longest and len(short) <= longest else f"{short[:longest]}..."


def named(name: str) -> str:
    """Name as a message shows it; in quotation marks where it begins or ends with a blank.

    Parameters
    ----------
    name : of a column, a key or a section, as the file has it

    Returns
    -------
    str

    Examples
    --------
    >>> print(named("time_s"), named(""), named("a "))
    time_s '' 'a '
    """
    return quoted(name) if name and name == name.strip() else f"'{quoted(name)}'"


def listed(names: Iterable[str], most: int = MOST_NAMES) -> str:
    """Names joined by commas; what is beyond the first ones is counted.

    Parameters
    ----------
    names : names of columns, sensors or sections
    most : names that are listed

    Returns
    -------
    str

    Examples
    --------
    >>> listed("abcde", most=3)
    'a, b, c and 2 more'
    """
    every = list(names)
    text = ", ".join(named(name) for name in every[:most])
    return text if len(every) <= most else f"{text} and {len(every) - most} more"
