"""Where data sets are on this machine: a named folder, or the cache."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from mobility_imu import data
from mobility_imu.datasets.catalogue import Dataset, find_dataset
from mobility_imu.errors import InputError

CACHE_VARIABLE = "MOBILITY_IMU_CACHE"
"""Environment variable; folder that takes what is fetched, instead of the platform's cache."""
RECORDINGS_VARIABLE = "MOBILITY_IMU_RECORDINGS"
"""Environment variable; folder with one subfolder per data set, looked at before the cache."""
NOTE = "NOTE.txt"
"""File beside the recordings that says where they are from and what was done."""


def dataset_folder(name: str) -> Path:
    """Folder of a data set on this machine; nothing is fetched.

    Looked at in this order: for ``wheelmove-id-sample`` the folder that MOBILITY_IMU_DATA names;
    below the folder that MOBILITY_IMU_RECORDINGS names, the data set's own name, then its
    ``subfolders``; the cache.

    Parameters
    ----------
    name : as in ``list_datasets``

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If there is no data set of this name, a variable names a folder that does not exist, or the
        data set is not there; the message says how to fetch it.
    """
    folder = find_folder(name)
    if folder is None:
        root = os.environ.get(RECORDINGS_VARIABLE)
        named = f"{root} nor in " if root else ""
        raise InputError(
            f"{name}: not in {named}{cache_folder()}; get it with 'mobility-imu fetch {name}'"
        )
    return folder


def find_folder(name: str) -> Path | None:
    """Folder of a data set as :func:`dataset_folder` finds it, None if it is not here.

    Parameters
    ----------
    name : as in ``list_datasets``

    Returns
    -------
    Path or None

    Raises
    ------
    InputError
        If there is no data set of this name, or a variable names a folder that does not exist.
    """
    dataset = find_dataset(name)
    if name == "wheelmove-id-sample":
        sample = data.sample_folder()
        if sample is not None:
            return sample
    root = os.environ.get(RECORDINGS_VARIABLE)
    if root:
        if not Path(root).is_dir():
            raise InputError(f"{RECORDINGS_VARIABLE} = {root}: no such folder")
        for subfolder in (dataset.name, *dataset.subfolders):
            if (Path(root) / subfolder).is_dir():
                return Path(root) / subfolder
    cached = cache_folder() / dataset.name
    return cached if is_complete(cached, dataset) else None


def is_complete(folder: Path, dataset: Dataset) -> bool:
    """Whether a folder holds a data set as ``fetch`` leaves it.

    Parameters
    ----------
    folder : below the cache
    dataset : which one

    Returns
    -------
    bool; False as well if it was fetched from another commit, or converted by another recipe
    """
    try:
        return dataset.stamp in (folder / NOTE).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return False


def cache_folder() -> Path:
    """Folder that takes what is fetched; it need not exist yet.

    MOBILITY_IMU_CACHE, or ``mobility-imu`` in the platform's folder for caches.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If there is no home folder to find the platform's in.
    """
    named = os.environ.get(CACHE_VARIABLE)
    try:
        if named:
            # No shell has read what a file of settings says.
            return Path(named).expanduser().absolute()
        return _platform_cache() / "mobility-imu"
    except RuntimeError:  # no home folder
        raise InputError(
            f"no folder for a cache can be found; name one in the variable {CACHE_VARIABLE}"
        ) from None


def _platform_cache() -> Path:
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return Path(local) if local else Path.home() / "AppData" / "Local"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    named = os.environ.get("XDG_CACHE_HOME", "")
    # A relative path is to be ignored, by the standard that defines the variable.
    return Path(named) if os.path.isabs(named) else Path.home() / ".cache"
