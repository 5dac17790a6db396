"""Numbers that were computed again, held against those of a record."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 0.01, 1e-4
"""A number is as recorded within 1 % or 0.0001; between processors, versions of the
libraries, and readable and compiled loops the last digits differ, and filters carry that on."""


def differing(
    found: Any, recorded: Any, place: str = "", *, partial: bool = False
) -> Iterator[tuple[str, Any, Any]]:
    """What was found and is not as recorded, within 1 % or 0.0001.

    Parameters
    ----------
    found, recorded : nested dicts and lists of numbers, text and None
    place : where they stand, for the result
    partial : what ``found`` lacks is not compared

    Yields
    ------
    place, value found, value recorded; None stands for what one of them lacks
    """
    if isinstance(found, Mapping) and isinstance(recorded, Mapping):
        for key in found if partial else dict.fromkeys([*found, *recorded]):
            inside = f"{place}.{key}".strip(".")
            yield from differing(found.get(key), recorded.get(key), inside, partial=partial)
    elif isinstance(found, list) and isinstance(recorded, list) and len(found) == len(recorded):
        for k, (one, other) in enumerate(zip(found, recorded, strict=True)):
            yield from differing(one, other, f"{place}[{k}]", partial=partial)
    elif _is_number(found) and _is_number(recorded):
        if not _alike(found, recorded):
            yield place, found, recorded
    elif found != recorded:
        yield place, found, recorded


def leaves(numbers: Any) -> Iterator[Any]:
    """Every value inside nested dicts and lists.

    Parameters
    ----------
    numbers : nested dicts and lists

    Yields
    ------
    value
    """
    if isinstance(numbers, Mapping):
        numbers = list(numbers.values())
    if isinstance(numbers, list):
        for part in numbers:
            yield from leaves(part)
    else:
        yield numbers


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _alike(one: float, other: float) -> bool:
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) and math.isnan(other)
    return math.isclose(one, other, rel_tol=RELATIVE_TOLERANCE, abs_tol=ABSOLUTE_TOLERANCE)


def shown(value: Any) -> str:
    """Value of a record on one line.

    Parameters
    ----------
    value : number, text or None

    Returns
    -------
    str
    """
    return f"{value:.4g}" if _is_number(value) else repr(value)[:60]
