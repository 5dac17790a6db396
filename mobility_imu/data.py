"""Where data are: the folder ``data`` of a checkout, or the tables inside an installed package.

An installed package carries the published tables, the recorded results and the public tool's
answers. The simulated recordings come with a checkout; WheelMove-ID's sample comes with neither.
"""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path

from mobility_imu.errors import InputError

ROOT = Path(__file__).resolve().parents[1]
"""Folder that holds the package, in a checkout or where packages are installed."""
INSTALLED = "_data"
"""Folder inside the package in which a wheel carries the tables (see ``setup.py``)."""
SAMPLE_VARIABLE = "MOBILITY_IMU_DATA"
SAMPLE_REPOSITORY = "https://github.com/YoannPoulet/wheelmove-IDv0"
SAMPLE_COMMIT = "c4607af211de9dc3aa4bc7d1e4722ca2c53e12f7"
SAMPLE_ARCHIVE = "assets/SampleData.zip"
"""The public sample, a file of the repository at that commit."""
SAMPLE_ARCHIVE_SHA256 = "cf6acec163e966480f2bf3e1b430b2cc87436e0c1b46d6a5d351fcbe6e454aff"


def checkout() -> Path | None:
    """Root of the project if this package runs from a checkout of it.

    Returns
    -------
    Path, or None for an installed package. A folder ``data`` of somebody else, beside an installed
    package, is not taken for ours.
    """
    try:
        project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    except OSError:
        return None
    return ROOT if 'name = "mobility-imu"' in project else None


def published_folder() -> Path:
    """Folder of the papers' tables as printed.

    Raises
    ------
    InputError
        If it is missing.
    """
    return _bundled("published", "the published tables")


def recorded_folder() -> Path:
    """Folder of the results that are too long for a page.

    Raises
    ------
    InputError
        If it is missing.
    """
    return _bundled("recorded", "the recorded results")


def reference_folder() -> Path:
    """Folder of the public tool's answers to a made-up series, recorded by us.

    Raises
    ------
    InputError
        If it is missing.
    """
    return _bundled("reference", "the public tool's recorded answers")


def recordings_folder() -> Path:
    """Folder of the simulated recordings, which come with a checkout only.

    Raises
    ------
    InputError
        If the package was installed without the project around it.
    """
    root = checkout()
    folder = None if root is None else root / "data" / "recordings"
    if folder is None or not folder.is_dir():
        raise InputError(
            "the bundled recordings come with a checkout of the project only; "
            "'mobility-imu simulate' makes them anew"
        )
    return folder


def _bundled(name: str, what: str) -> Path:
    root = checkout()
    if root is not None:
        folder = root / "data" / name
    else:
        folder = Path(str(resources.files("mobility_imu") / INSTALLED / name))
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; it holds {what}: install the package again")
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
