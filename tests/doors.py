"""What every wrong argument at a public door has to end in."""

from collections.abc import Callable
from typing import Any

import pytest

from mobility_imu.errors import InputError


def refused(door: Callable[[], Any]) -> str:
    """The message of an InputError: one short line."""
    with pytest.raises(InputError) as error:
        door()
    text = str(error.value)
    assert text and "\n" not in text and len(text) < 250
    return text
