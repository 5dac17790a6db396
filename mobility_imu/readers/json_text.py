"""JSON as files of settings and of recordings have it: no key twice."""

from __future__ import annotations

import json
from typing import Any

from mobility_imu.errors import InputError
from mobility_imu.readers.wording import named


class RepeatedKeyError(InputError):
    """A key appears twice in one object."""


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
        If a key appears twice in one object: of two values, Python takes the second.
    ValueError, RecursionError
        As ``json.loads`` raises them.
    """
    return json.loads(text, object_pairs_hook=_without_repeats)


def load_recording(text: str, source: str) -> Any:
    """Content of a recording in JSON.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages

    Returns
    -------
    as :func:`load_json`

    Raises
    ------
    InputError
        If it is no JSON, or a key appears twice in one object.
    """
    try:
        return load_json(text)
    except RepeatedKeyError as error:
        raise InputError(f"{source}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: no JSON ({error}); is the file complete?") from None


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise RepeatedKeyError(f"{named(key)} appears twice in one object")
            seen.add(key)
    return found
