"""Recordings that were held back until the settings were fixed: their numbers, and the first run's.

The settings were fixed by the commit :data:`~mobility_imu.reproduction.real_files.FROZEN`. What the
first run with them gave is kept in ``data/reference/held_first_run.csv``, so that a later change
is seen.
"""

from __future__ import annotations

import csv
from typing import Any

from mobility_imu.data import reference_folder
from mobility_imu.frames import one_of
from mobility_imu.reproduction.real import HELD_OF
from mobility_imu.reproduction.real_files import Numbers
from mobility_imu.reproduction.recorded import numbers


def held_numbers(name: str) -> Numbers:
    """Recorded numbers of recordings that were held back.

    Parameters
    ----------
    name : a key of :data:`~mobility_imu.reproduction.real.HELD_OF`

    Returns
    -------
    dict with ``origin``, ``frozen``, ``files``, ``rows``, ``summary``
    """
    found: Numbers = numbers(one_of("name", name, tuple(HELD_OF)))
    return found


def first_run(name: str) -> dict[str, dict[str, Any]]:
    """Headline numbers of the first run with the settings that had been fixed.

    Parameters
    ----------
    name : a key of :data:`~mobility_imu.reproduction.real.HELD_OF`

    Returns
    -------
    dict from recording to dict from quantity to float
    """
    one_of("name", name, tuple(HELD_OF))
    found: dict[str, dict[str, Any]] = {}
    path = reference_folder() / "held_first_run.csv"
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["record"] == name:
                found.setdefault(row["recording"], {})[row["quantity"]] = float(row["value"])
    return found
