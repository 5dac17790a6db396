"""How commands read recordings: with what the user says of files that do not say it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mobility_imu.errors import InputError

if TYPE_CHECKING:
    from mobility_imu.recording import Recording

SENSORS = {
    "scooter": ("lever", "body"),
    "wheelchair": ("frame", "left_wheel", "right_wheel"),
    "walker": ("frame",),
}
"""Names of the sensors that each device's commands use, in the order of a file without names."""


def parse_units(units: list[str] | None) -> dict[str, str]:
    """Units of ``--unit acc=g --unit gyr=deg/s``.

    Parameters
    ----------
    units : as typed

    Returns
    -------
    dict of quantity to unit

    Raises
    ------
    InputError
        If one is not of this form.
    """
    found = {}
    for text in units or []:
        quantity, mark, unit = text.partition("=")
        if not mark or not unit:
            raise InputError(f"--unit {text}: expected acc=UNIT or gyr=UNIT, such as acc=g")
        found[quantity.strip()] = unit.strip()
    return found


def read_input(
    path: Path,
    device: str,
    *,
    sampling_rate_hz: float | None,
    fill_gaps_s: float = 0.0,
    units: list[str] | None = None,
) -> Recording:
    """Recording for a command of a device.

    Parameters
    ----------
    path : as typed
    device : "scooter", "wheelchair" or "walker"
    sampling_rate_hz : of ``--sampling-rate-hz``
    fill_gaps_s : of ``--fill-gaps-s``
    units : of ``--unit``

    Returns
    -------
    Recording
    """
    from mobility_imu.readers import read_recording

    return read_recording(
        path,
        sampling_rate_hz=sampling_rate_hz,
        fill_gaps_s=fill_gaps_s,
        units=parse_units(units),
        expected=SENSORS[device],
    )
