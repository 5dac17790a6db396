"""Where the data lie: bundled in the project's folder ``data``, the public sample elsewhere."""

from __future__ import annotations

import os
from pathlib import Path

from mobility_imu.errors import InputError

DATA = Path(__file__).resolve().parents[1] / "data"
SAMPLE_VARIABLE = "MOBILITY_IMU_DATA"
SAMPLE_REPOSITORY = "https://github.com/YoannPoulet/wheelmove-IDv0"
SAMPLE_COMMIT = "c4607af211de9dc3aa4bc7d1e4722ca2c53e12f7"
SAMPLE_ARCHIVE = "assets/SampleData.zip"
"""The public sample, a file of the repository at that commit."""
SAMPLE_ARCHIVE_SHA256 = "cf6acec163e966480f2bf3e1b430b2cc87436e0c1b46d6a5d351fcbe6e454aff"


def recordings_folder() -> Path:
    """Folder of the simulated recordings.

    Raises
    ------
    InputError
        If the package was installed without the project around it.
    """
    return _bundled("recordings", "the bundled recordings")


def reference_folder() -> Path:
    """Folder of the public tool's answers to a made-up series, recorded by us.

    Raises
    ------
    InputError
        If the package was installed without the project around it.
    """
    return _bundled("reference", "the public tool's recorded answers")


def _bundled(name: str, what: str) -> Path:
    folder = DATA / name
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; {what} come with a checkout of the project")
    return folder


def sample_folder() -> Path | None:
    """Folder of WheelMove-ID's sample recording, None if the environment does not name it.

    The sample may not be passed on, so it is not bundled. ``data/README.md`` says where it is to
    be had; the environment variable MOBILITY_IMU_DATA names its folder.

    Raises
    ------
    InputError
        If the named folder does not exist.
    """
    name = os.environ.get(SAMPLE_VARIABLE)
    if not name:
        return None
    folder = Path(name)
    if not folder.is_dir():
        raise InputError(f"{SAMPLE_VARIABLE} = {name}: no such folder")
    return folder
