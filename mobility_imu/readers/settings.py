"""Settings in JSON: one object of numbers."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import Any

from mobility_imu.errors import InputError
from mobility_imu.frames import shown
from mobility_imu.readers.geometry import as_number
from mobility_imu.readers.json_text import RepeatedKeyError, load_json
from mobility_imu.readers.table import read_text
from mobility_imu.readers.wording import named


def read_json_numbers(path: str | Path) -> dict[str, float | None]:
    """Read a JSON object whose values are finite numbers or null.

    Parameters
    ----------
    path : JSON file

    Returns
    -------
    dict of key to float, None for null

    Raises
    ------
    InputError
        If the file is no such object; the message names the key.
    """
    text = read_text(path, form="JSON")
    try:
        content: Any = load_json(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not valid JSON ({error})") from None
    except RepeatedKeyError as error:
        raise InputError(f"{path}: {error}") from None
    except RecursionError:
        raise InputError(f"{path}: not a JSON object of settings (nested too deeply)") from None
    except ValueError:
        # Python converts no integer of more than some thousand digits.
        raise InputError(f"{path}: a number has too many digits") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a JSON object of settings")
    numbers = {}
    for key, value in content.items():
        number = None if value is None else as_number(value)
        if value is not None and (number is None or not isfinite(number)):
            raise InputError(f"{path}: {named(key)} = {shown(value)}, expected a number")
        numbers[key] = number
    return numbers
