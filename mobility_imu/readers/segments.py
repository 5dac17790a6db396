"""Tables of a chain's segments: the rate in the first line, columns ``seg1_acc_x`` and so on."""

from __future__ import annotations

import re

from mobility_imu.errors import InputError
from mobility_imu.readers.clocks import check_rate
from mobility_imu.readers.table import NumberTable, parse_numbers
from mobility_imu.readers.wording import quoted


def parse_segments(text: str, source: str) -> tuple[float, NumberTable]:
    """Rate and columns of a table whose head states ``# sampling frequency: 40``.

    Parameters
    ----------
    text : content of the file; units are s, m, rad
    source : the file's name, for messages

    Returns
    -------
    rate_hz : Hz
    table : columns; NaN where a cell is empty or says so

    Raises
    ------
    InputError
        If the rate is not stated, or a cell is no number.
    """
    lines = text.split("\n", 20)
    comments = [line for line in lines if line.startswith("#")]
    stated = re.search(r"#\s*sampling frequency:\s*(\d+(?:\.\d+)?)\s*$", "\n".join(comments), re.M)
    if stated is None:
        raise InputError(
            f"{source}: no line '# sampling frequency: ...' (it begins with '{quoted(lines[0])}')"
        )
    rest = text.split("\n", len(comments))[-1]
    table = parse_numbers(rest, separator=",", source=source, first_line=len(comments) + 1)
    return check_rate(float(stated[1]), source), table
