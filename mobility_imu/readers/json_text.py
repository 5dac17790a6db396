"""JSON as files of settings and of recordings have it: no key twice."""

from __future__ import annotations

import json
from typing import Any

from mobility_imu.errors import InputError
from mobility_imu.readers.wording import named


class RepeatedKeyError(InputError):
    """A key stands twice in one object."""


def load_json(text: str) -> Any:
    """Content of a JSON text.

    Parameters
    ----------
    text : content of the file

    Returns
    -------
    object, array, text, number, truth value or None

    Raises
    ------
    RepeatedKeyError
        If a key stands twice in one object: of two values, Python takes the second.
    ValueError, RecursionError
        As ``json.loads`` raises them.
    """
    return json.loads(text, object_pairs_hook=_without_repeats)


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for k, key in enumerate(keys) if key in keys[:k])
        raise RepeatedKeyError(f"{named(twice)} stands twice in one object")
    return found
