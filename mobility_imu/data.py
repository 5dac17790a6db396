"""Where the bundled data lie: beside the package, in the project's folder ``data``."""

from __future__ import annotations

import os
from pathlib import Path

from mobility_imu.errors import InputError

DATA = Path(__file__).resolve().parents[1] / "data"
SAMPLE_VARIABLE = "MOBILITY_IMU_DATA"


def recordings_folder() -> Path:
    """Give the folder of the simulated recordings.

    Raises
    ------
    InputError
        If the package was installed without the project around it.
    """
    folder = DATA / "recordings"
    if not folder.is_dir():
        raise InputError(
            f"{folder}: no such folder; the bundled recordings come with a checkout of the project"
        )
    return folder


def sample_folder() -> Path | None:
    """Give the folder of WheelMove-ID's sample recording, None if nobody said where it is.

    It may not be passed on, so it is not bundled: the environment variable MOBILITY_IMU_DATA
    names its folder.
    """
    name = os.environ.get(SAMPLE_VARIABLE)
    if not name:
        return None
    folder = Path(name)
    if not folder.is_dir():
        raise InputError(f"{SAMPLE_VARIABLE} = {name}: no such folder")
    return folder
